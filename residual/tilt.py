"""Rollers that tilt: laws in slices along the run's own tilts, error moments of rollers, the moment on the shaft."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from lagrange.axial.pressure import SHARP, Ends, borne, pressures_under, profile_ends
from lagrange.axial.slices import Slices, alone, contact_slices
from lagrange.axial.table import TiltedContact
from lagrange.contact.damping import ContactDamping, tilted_damper
from lagrange.contact.hertz import Pair, contact_pairs
from lagrange.contact.laws import LogarithmicLaw, PowerLaw, contact_laws
from lagrange.equations import Overlaps
from lagrange.motion import State
from lagrange.rating.sources import Unavailable
from lagrange.surface.deviation import Falls, SurfaceDeviation
from lagrange.tilt import (
    Misalignments,
    TiltedContacts,
    Tilts,
    falls,
    hub_slope_equations,
    hub_tilt,
    met,
    tilt_equations,
)
from residual.differentiate import derivative
from residual.record import Record

FLAT = 1e-10  # m: less have contacts not sunk
BLOCK = 4096  # samples whose slices are held in memory at a time
FAINT = 0.01  # of the largest force: contacts taken as open
INSIDE = 0.99  # of the largest moment that a force has: beyond, a roller stands on an end
BINS, ROLLERS = 120, 3  # of angles; shown from their side
CANDIDATES = 64  # contacts of which one has the largest pressure


class Dampers(NamedTuple):
    """Dampers of a record's tilted contacts."""

    damping: ContactDamping
    closing_speed: np.ndarray  # (n_times, n_rollers), m/s
    turning_speed: np.ndarray  # rad/s, at which misalignments grow
    length: float  # m, of rollers

    def given(self, met: TiltedContact) -> tuple[np.ndarray, np.ndarray]:
        """Forces, N, and moments, N m."""
        return tilted_damper(met, self.damping, self.closing_speed, self.turning_speed, self.length)


@dataclass(frozen=True, kw_only=True, eq=False)
class SlicedLaw:
    """A contact's law in slices at a record's misalignments; force and slope of approaches of the record's shape."""

    whole: PowerLaw | LogarithmicLaw  # of the whole length
    slices: Slices
    misalignment: np.ndarray  # (n_times, n_rollers), rad
    surface: SurfaceDeviation | None  # that the contacts meet
    dampers: "Dampers | None" = None  # None: contacts without

    @property
    def name(self) -> str:
        return self.whole.name

    @property
    def source(self) -> str:
        return f"{self.whole.source}, in {self.slices.count} slices"

    def force(self, approach) -> np.ndarray:
        """N, >= 0, of the springs."""
        return self._at(approach).force

    def damper(self, approach) -> np.ndarray | float:
        """Force of the dampers, N."""
        return 0.0 if self.dampers is None else self.dampers.given(self._at(approach))[0]

    def slope(self, approach) -> np.ndarray:
        """dQ/dδ, N/m."""
        return self._at(approach).stiffness

    def moment(self, approach) -> np.ndarray:
        """Force times z, N m, of springs and dampers."""
        met = self._at(approach)
        return met.moment if self.dampers is None else met.moment + self.dampers.given(met)[1]

    def falls(self, approach) -> Falls:
        """By how much energies fall as surfaces change."""
        return Falls() if self.surface is None else falls(self._at(approach), self.surface)

    def _at(self, approach) -> TiltedContact:
        contact, found = alone(self.slices), []
        for first in range(0, len(self.misalignment), BLOCK):
            rows = slice(first, first + BLOCK)
            surface = None if self.surface is None else self.surface.rows(rows)
            here = met(contact, approach[rows], self.misalignment[rows], surface)
            found.append([np.broadcast_to(each, here.force.shape) for each in here])
        return TiltedContact(*(np.concatenate(each) for each in zip(*found, strict=True)))


def has_tilts(record: Record) -> bool:
    """Whether the source holds the slopes of rollers that tilt."""
    return record.scene.axial is not None and record.roller_tilt is not None and record.inner_slope_x is not None


def sliced(record: Record, whole: PowerLaw | LogarithmicLaw, outer: bool = False) -> SlicedLaw:
    """A law of the whole length in slices, of inner or outer contacts at a record's slopes."""
    axial, bearing = record.scene.ideal_axial(), record.bearing
    if axial is None or record.roller_tilt is None:
        raise ValueError("the record has no rollers that tilt")
    slices, contacts = contact_slices(bearing, axial, (whole, whole))[int(outer)], record.contacts
    if outer:
        misalignment, approach, surface = -record.roller_tilt, contacts.outer, contacts.surfaces[1]
    else:
        misalignment, approach, surface = misaligned(record, contacts)[0], contacts.inner, contacts.surfaces[0]
    dampers, damping = None, record.scene.damping.contacts
    if damping.acts:
        closing, turning = (derivative(value, record.interval, 1) for value in (approach, misalignment))
        dampers = Dampers(damping, closing, turning, bearing.roller_length)
    return SlicedLaw(whole=whole, slices=slices, misalignment=misalignment, surface=surface, dampers=dampers)


def misaligned(record: Record, contacts: Overlaps) -> tuple[np.ndarray, np.ndarray]:
    """ψ of the inner contacts, and the slopes' part across their normals, rad, (n_times, n_rollers) each."""
    angle = np.arctan2(record.roller_y, record.roller_x)
    tilt = np.asarray(record.roller_tilt)
    x = tilt * np.cos(angle) - np.asarray(record.inner_slope_x)[:, None]
    y = tilt * np.sin(angle) - np.asarray(record.inner_slope_y)[:, None]
    nx, ny = contacts.normal
    return x * nx + y * ny, y * nx - x * ny


def moment_resultant(record: Record, contacts: Overlaps, moment) -> tuple[np.ndarray, np.ndarray]:
    """Forces by which inner contacts' moments, N m, push the hub sideways, x and y, (n_times,), N."""
    push, (nx, ny) = moment * misaligned(record, contacts)[1] / contacts.distance, contacts.normal
    return np.sum(push * ny, axis=1), np.sum(-push * nx, axis=1)


@dataclass(frozen=True, kw_only=True)
class MomentError:
    """Error moments of one equation, N m, (n_times, n_rollers), and their terms, which add up to them."""

    error: np.ndarray  # by the law
    contact_law: np.ndarray  # moments of the law less the run's, with the sign that they have in the error
    balance: np.ndarray  # the error with the run's own moments, those of tractions and guides included


@dataclass(frozen=True, kw_only=True)
class TiltErrors(MomentError):
    """Error moments of the equation of tilt, and what the hub's slope needs."""

    hub: tuple[np.ndarray, np.ndarray]  # (n_times,), N m, x and y: what else must give the hub's slope
    largest_tilt: float  # rad


def tilt_errors(record: Record, law: str, order: int) -> TiltErrors:
    """Put a record's slopes into the equations of τ and the hub's slope; `law` : by name; `order` : of stencils."""
    laws, bearing, contacts, interval = (
        contact_laws(law, record.bearing),
        record.bearing,
        record.contacts,
        record.interval,
    )
    inner = sliced(record, laws.inner).moment(contacts.inner)
    outer = sliced(record, laws.outer, outer=True).moment(contacts.outer)
    theta = np.unwrap(np.arctan2(record.roller_y, record.roller_x), axis=0)
    columns = {
        "tilt": np.asarray(record.roller_tilt),
        "slope_x": np.asarray(record.inner_slope_x), "slope_y": np.asarray(record.inner_slope_y),
    }  # fmt: skip
    rates = {f"{name}_rate": derivative(value, interval, 1, order) for name, value in columns.items()}
    gains = {name: derivative(value, interval, 2, order) for name, value in columns.items()}
    given = np.zeros_like(theta)
    state = State(
        x=record.inner_x, y=record.inner_y, rho=np.hypot(record.roller_x, record.roller_y), theta=theta,
        x_rate=0.0, y_rate=0.0, rho_rate=np.zeros_like(theta), theta_rate=derivative(theta, interval, 1, order),
        tilts=Tilts(**columns, **rates),
    )  # fmt: skip
    cos, sin = np.cos(theta), np.sin(theta)
    nx, ny = contacts.normal
    normal = nx * cos + ny * sin, ny * cos - nx * sin
    at = Misalignments(*misaligned(record, contacts)[:1], *(2 * (np.zeros_like(theta),)))

    def left(moments):
        more = TiltedContacts(inner_moment=moments[0], outer_moment=moments[1], energy=given, at=at, normal=normal)
        around, touch = derivative(theta, interval, 2, order), SimpleNamespace(tilted=more)
        found = tilt_equations(bearing, record.acting, state, touch, gains["tilt"], around)
        axial = record.scene.ideal_axial()
        hub = hub_tilt(record.operation, axial) if axial is not None else None
        slopes = hub_slope_equations(bearing, record.acting, hub, state, touch, gains["slope_x"], gains["slope_y"])
        return found[0], slopes

    own = tuple(
        law if run is None else run for run, law in ((record.inner_moment, inner), (record.outer_moment, outer))
    )
    (error, hub), (balance, _) = left((inner, outer)), left(own)
    return TiltErrors(
        error=error, contact_law=error - balance, balance=balance, hub=hub,
        largest_tilt=float(np.abs(columns["tilt"]).max()),
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class AlongRollers:
    """Pressures along rollers of a run; of contacts (2, n, n_slices), Pa, inner and outer raceway."""

    place: np.ndarray  # (n_slices,), m, along the axis from the middle
    angle: np.ndarray  # (BINS,), rad from the load's direction
    around: np.ndarray  # at these angles the contact with the largest force; 0 of open ones
    time: float  # s, of the largest moment of an inner contact
    rollers: np.ndarray  # (n,), the most loaded ones at that instant, of which there is
    along: np.ndarray
    edges: bool  # whether a loaded end has an edge, where pressure has no limit


class _Side(NamedTuple):
    """Contacts with one raceway, (n_times, n_rollers)."""

    slices: Slices
    pair: Pair
    ends: Ends
    force: np.ndarray
    moment: np.ndarray
    sunk: np.ndarray  # m, of the part of the length that spalls take

    def pressures(self, at: np.ndarray) -> np.ndarray:
        """Along the rollers of contacts by their places among all, (n, n_slices), Pa; 0 of open ones."""
        force, moment, sunk = (each.ravel()[at] for each in (self.force, self.moment, self.sunk))
        closed = (force > FAINT * self.force.max()) & (np.abs(moment) < INSIDE * self.slices.place[-1] * force)
        try:
            return pressures_under(self.slices, self.pair, force, moment, sunk, closed)[0]
        except (RuntimeError, ValueError) as error:
            raise Unavailable(str(error)) from None

    def has_loaded_edge(self, pressure: np.ndarray) -> bool:
        """Whether one of contacts with such pressures, (n, n_slices), Pa, has."""
        return bool(self.ends.are_loaded(self.slices, borne(self.pair, pressure)).any())


def _sides(record: Record) -> list[_Side]:
    """Inner and outer one; none where the source does not hold what pressures follow from."""
    axial, slices, bearing = record.scene.ideal_axial(), record.slices, record.scene.perfect_bearing()
    loads = (record.inner_force, record.inner_moment), (record.outer_force, record.outer_moment)
    if axial is None or slices is None or any(each is None for side in loads for each in side):
        return []
    contacts, parts = record.contacts, axial.parts(record.bearing)
    found = []
    each = zip(slices, contact_pairs(bearing), profile_ends(bearing, axial), loads, strict=False)
    for (own, pair, end, load), part, surface in zip(each, parts, contacts.surfaces, strict=True):
        force, moment = (np.asarray(value) for value in load)
        depth = np.broadcast_to(0.0 if surface is None else surface.part_sinkage, force.shape)
        found.append(_Side(replace(own, part=part), pair, end, force, moment, depth))
    return found


def along_rollers(record: Record) -> AlongRollers | None:
    """None where the source does not hold what pressures follow from.

    Errors
    ------
    Unavailable: its forces and moments are not those of its slices.
    """
    sides = _sides(record)
    if not sides:
        return None
    shape = sides[0].force.shape
    sample = int(np.unravel_index(np.abs(sides[0].moment).argmax(), shape)[0])
    rollers = np.sort(np.argsort(sides[0].force[sample])[-ROLLERS:])
    shown = np.ravel_multi_index((np.full(rollers.size, sample), rollers), shape)
    bins = np.floor((record.from_load / (2.0 * np.pi) + 0.5) * BINS).astype(int).ravel() % BINS
    around = np.zeros((len(sides), BINS, sides[0].slices.count))
    for found, side in zip(around, sides, strict=True):
        order = np.argsort(side.force, axis=None)
        largest = np.full(BINS, -1)
        largest[bins[order]] = order  # the last one of each bin
        found[largest >= 0] = side.pressures(largest[largest >= 0])
    return AlongRollers(
        place=sides[0].slices.place, angle=2.0 * np.pi * ((np.arange(BINS) + 0.5) / BINS - 0.5), around=around,
        time=float(record.time[sample]), rollers=rollers, along=np.array([side.pressures(shown) for side in sides]),
        edges=any(side.has_loaded_edge(found) for side, found in zip(sides, around, strict=True)),
    )  # fmt: skip


def largest_pressures(record: Record) -> tuple[float, ...]:
    """Of inner and outer raceway, Pa: of the contacts whose ends a straight line of pressure would press most.

    Errors
    ------
    Unavailable: a loaded end has an edge, the source does not hold what pressures follow from; as of `along_rollers`.
    """
    found, half = [], 0.5 * record.bearing.roller_length
    for side in _sides(record):
        most = np.argsort(side.force + 3.0 * np.abs(side.moment) / half, axis=None)[-CANDIDATES:]
        pressure = side.pressures(most)
        if side.has_loaded_edge(pressure):
            raise Unavailable(SHARP)
        if np.any(side.sunk.ravel()[most] > FLAT):
            raise Unavailable("a spall of part of the rollers' length ends with an edge, where pressure has no limit")
        found.append(float(pressure.max()))
    if not found:
        raise Unavailable("rollers tilt, and the source does not say how pressure changes along them")
    return tuple(found)


def tilt_summary(found: TiltErrors) -> dict:
    """Numbers of error moments, N m, as JSON has them."""

    def numbers(values: np.ndarray) -> dict[str, float]:
        rms = float(np.sqrt(np.mean(np.square(values))))
        return {
            "mean_N_m": float(np.mean(values)), "rms_N_m": rms, "std_N_m": float(np.std(values)),
            "max_abs_N_m": float(np.abs(values).max()),
        }  # fmt: skip

    return {
        "error_moment": numbers(found.error),
        "budget": {"contact_law": numbers(found.contact_law), "balance": numbers(found.balance)},
        **{f"hub_moment_{axis}": numbers(values) for axis, values in zip("xy", found.hub, strict=True)},
        "largest_tilt_rad": found.largest_tilt,
    }
