"""Contact laws of a check: named ones, with dampers, in slices along rollers that tilt; and fitted ones.

K and n of Q = K δ^n, and where wanted a damping d, Q = K δ^n + d δ̇, are fitted by least squares to the closed inner
contacts of the record's first part; the rest is held back to judge the law on.

The samples of one roller's passage through the load zone are far from independent, so the intervals take the
passage, not the sample, as the unit of observation. They say how well the data fix the numbers, not that a
power law is true: what the law can't follow in any passage shows in the scatter, not in the interval.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lagrange.axial.slices import Slices, alone, contact_slices
from lagrange.axial.table import TiltedContact, in_series
from lagrange.contact.damping import UNDAMPED, ContactDamping, damper_force, tilted_damper
from lagrange.contact.laws import LogarithmicLaw, PowerLaw, contact_laws
from lagrange.equations import Overlaps, contact_resultant
from lagrange.errors import InputError
from lagrange.motion import falls, met, misalignments
from lagrange.surface.deviation import Falls, SurfaceDeviation
from residual.load_zone import load_zones
from residual.record import FEWEST_SAMPLES, Record
from residual.spectrum import derivative, rms

FIT_SHARE = 0.5  # of the record
CONFIDENCE = 0.95
LEAST_FORCE = 1e-100  # N: squares of less are nothing
LEAST_SPREAD = 0.02  # of ln δ: less depth range than this fixes no exponent
FITTED = ("fitted", "fitted_damped")
ALIASES = ("tripp",)
BLOCK = 4096  # samples whose slices are held in memory at a time


class Pushes(NamedTuple):
    """Forces of contacts by a law, (..., n_rollers)."""

    spring: np.ndarray  # N
    damper: np.ndarray | float  # N
    moment: np.ndarray | None = None  # N m, springs' and dampers' force times z; None: rollers stay parallel
    falls: Falls = Falls()  # by how much the energies fall as surfaces change

    @property
    def force(self) -> np.ndarray:
        return self.spring + self.damper

    def turned(self, contacts: Overlaps) -> Overlaps:
        """Contacts with the directions that these forces have on surfaces.

        The spring alone deforms an edge, whose compliance is in series with it.
        """
        return contacts.at_contact(Falls(compliance=0.5 * self.spring) if self.moment is None else self.falls)

    def on_hub(self, record: Record, contacts: Overlaps) -> np.ndarray:
        """Their resultant on the hub along x and y, N, (2, n_times), with the force of tilted contacts' moments."""
        straight = np.array(contact_resultant(contacts, self.force))
        return straight if self.moment is None else straight + moment_resultant(record, contacts, self.moment)


@dataclass(frozen=True, kw_only=True)
class DampedLaw:
    """Q = max(Q_0(δ) + d δ̇, 0) where δ > 0, else 0: a damper beside a contact's spring."""

    spring: PowerLaw | LogarithmicLaw  # Q_0
    damping: ContactDamping = UNDAMPED  # d

    @property
    def name(self) -> str:
        return self.spring.name

    @property
    def source(self) -> str:
        return self.spring.source + (f", damping {self.damping.words}" if self.damping.acts else "")

    def slope(self, approach):
        """dQ/dδ of a contact, N/m."""
        return self.spring.slope(approach)

    def pushes(self, approach, closing_speed, compliance=0.0) -> Pushes:
        """By approaches, m, their growth, m/s, and the compliance of edges, m/N."""
        here = in_series(self.spring.at, approach, 0.0, compliance)
        if not self.damping.acts:
            return Pushes(here.force, 0.0)
        coefficient = self.damping.coefficient(here.force, here.stiffness)
        return Pushes(here.force, damper_force(here.force, closing_speed, coefficient))


class SlicedLaw(NamedTuple):
    """A contact's law in slices at a record's misalignments; of approaches of the record's shape."""

    name: str
    source: str
    slices: Slices
    misalignment: np.ndarray  # (n_times, n_rollers), rad
    surface: SurfaceDeviation | None  # that the contacts meet
    dampers: tuple | None  # damping, closing speeds, m/s, growth of misalignments, rad/s, and the rollers' length, m

    def slope(self, approach) -> np.ndarray:
        """dQ/dδ, N/m."""
        return self._at(approach).stiffness

    def pushes(self, approach, closing_speed=None, compliance=None) -> Pushes:
        """By approaches, m; speeds are those of the record, compliances those of the surface."""
        here = self._at(approach)
        force, moment = (0.0, 0.0) if self.dampers is None else tilted_damper(here, *self.dampers)
        return Pushes(here.force, force, here.moment + moment, falls(here, self.surface))

    def _at(self, approach):
        contact, found = alone(self.slices), []
        for first in range(0, len(self.misalignment), BLOCK):
            rows = slice(first, first + BLOCK)
            surface = None if self.surface is None else self.surface.rows(rows)
            here = met(contact, approach[rows], self.misalignment[rows], surface)
            found.append([np.broadcast_to(each, here.force.shape) for each in here])
        return TiltedContact(*map(np.concatenate, zip(*found, strict=True)))


Law = DampedLaw | SlicedLaw


def has_tilts(record: Record) -> bool:
    """Whether the source holds the slopes of rollers that tilt."""
    return record.scene.axial is not None and record.roller_tilt is not None and record.inner_slope_x is not None


def inner_law(law: str | PowerLaw | LogarithmicLaw | DampedLaw, record: Record) -> Law:
    """Law of the inner contact, also by its name, with the scene's damping of contacts unless it has its own."""
    if isinstance(law, DampedLaw):
        return law
    law = contact_laws(law, record.bearing).inner if isinstance(law, str) else law
    return sliced(record, law) if has_tilts(record) else DampedLaw(spring=law, damping=record.scene.damping.contacts)


def sliced(record: Record, whole: PowerLaw | LogarithmicLaw, outer: bool = False) -> SlicedLaw:
    """A law of the whole length in slices, of inner or outer contacts at a record's slopes."""
    axial, bearing, contacts = record.scene.ideal_axial(), record.bearing, record.contacts
    if axial is None or record.roller_tilt is None:
        raise ValueError("the record has no rollers that tilt")
    slices, damping = contact_slices(bearing, axial, (whole, whole))[outer], record.scene.damping.contacts
    at = misalignments(contacts, record.tilts)
    approach, misalignment = (contacts.outer, at.outer) if outer else (contacts.inner, at.inner)
    dampers = None
    if damping.acts:
        rates = (derivative(value, record.interval, 1) for value in (approach, misalignment))
        dampers = damping, *rates, bearing.roller_length
    source = f"{whole.source}, in {slices.count} slices"
    return SlicedLaw(whole.name, source, slices, misalignment, contacts.surfaces[outer], dampers)


def moment_resultant(record: Record, contacts: Overlaps, moment) -> np.ndarray:
    """Forces by which inner contacts' moments, N m, push the hub sideways, x and y, (2, n_times), N."""
    push, (nx, ny) = moment * misalignments(contacts, record.tilts).across / contacts.distance, contacts.normal
    return np.array([np.sum(push * ny, axis=1), np.sum(-push * nx, axis=1)])


class Interval(NamedTuple):
    """A fitted number and its 95 % confidence interval."""

    value: float
    low: float
    high: float


class Identification(NamedTuple):
    """A fitted law and how well it is known."""

    law: DampedLaw
    stiffness: Interval  # K, N/m^n
    exponent: Interval  # n
    damping: Interval | None  # d, N s/m
    samples: int  # of the record's first part; the rest is held back
    contacts: int  # closed contacts fitted
    passages: int  # independent passages through the load zone among them
    depth: tuple[float, float]  # m, smallest and largest approach fitted
    scatter: float  # N, rms of run − law per contact fitted


def fit_law(approach, force, bridge: int, closing_speed=None, samples: int | None = None) -> Identification:
    """Fit Q = K δ^n, or with closing speeds Q = K δ^n + d δ̇, to closed contacts by least squares.

    approach, force : ndarray, (n_times, n_rollers), m and N
    bridge : samples; a contact open no longer than this is still in the same passage
    closing_speed : δ̇, ndarray, (n_times, n_rollers), m/s; None: no damping is fitted
    samples : fit to the first so many; None: the first half

    InputError: too few samples, passages, or too little range of depth to fix the numbers. The intervals are
    linear (delta method) with a covariance clustered by passage and Student's t; passages loaded at the same time
    still share the ring's vibration, which makes the intervals somewhat too narrow.

    Source: Liang and Zeger, Biometrika 73 (1986) 13-22: covariance of an estimate from clustered observations.
    """
    from scipy.optimize import least_squares
    from scipy.special import stdtrit  # scipy.stats costs half a second to import

    samples = int(FIT_SHARE * approach.shape[0]) if samples is None else samples
    if samples < FEWEST_SAMPLES:
        raise InputError(f"{samples} samples to fit a law to, at least {FEWEST_SAMPLES} are needed; use a longer run")
    closed = force[:samples] > 0.0
    passage = np.unique(passage_numbers(closed, bridge)[closed], return_inverse=True)[1]
    depth, load = approach[:samples][closed], force[:samples][closed]
    speed = np.zeros_like(load) if closing_speed is None else closing_speed[:samples][closed]
    fitted, n_passages = 2 if closing_speed is None else 3, passage.max(initial=-1) + 1  # of ln K, n and d
    if n_passages <= fitted + 1:
        raise InputError(
            f"{n_passages} passages of rollers through the load zone in the first {samples} samples, at least "
            f"{fitted + 2} are needed to fit a law; use a longer run"
        )
    inside = depth > 0.0
    if inside.sum() < FEWEST_SAMPLES or np.std(np.log(depth[inside])) < LEAST_SPREAD:
        raise InputError("the contacts' approaches hardly vary: they fix no exponent; use a run with a load zone")
    deep, strong, fast = (rms(each) for each in (depth[inside], load, speed))  # in which the parameters are found
    if not strong > LEAST_FORCE:
        raise InputError(f"the contact forces, {strong:.3g} N rms, are too small to fit a law to")
    if closing_speed is not None and not fast > 0.0:
        raise InputError("the run has nothing that fixes a damping: nothing moves")
    logarithm, speed = np.log(np.where(inside, depth / deep, 1.0)), speed / (fast or 1.0)

    def model(parameters):  # dimensionless forces, and their derivatives by ln K, n and d
        spring = np.where(inside, np.exp(parameters[0] + parameters[1] * logarithm), 0.0)
        total = spring + parameters[2] * speed if fitted > 2 else spring
        pushes = inside & (total > 0.0)
        columns = np.column_stack([spring, spring * logarithm, speed])[:, :fitted]
        return np.where(pushes, total, 0.0), np.where(pushes[:, None], columns, 0.0)

    found = least_squares(
        lambda p: model(p)[0] - load / strong, np.array([0.0, 1.1, 0.0])[:fitted], jac=lambda p: model(p)[1],
        method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12)  # fmt: skip
    best, exponent = found.x, found.x[1]
    if not found.success or not 0.2 < exponent < 5.0:
        raise InputError(f"the run's forces follow no power law of the approach (exponent {exponent:.3g})")
    if np.linalg.matrix_rank(found.jac) < fitted:
        raise InputError("the run's forces do not fix all numbers of the law; use a longer run, or a named law")
    # covariance of the parameters, times Student's t squared, from the passages' scores
    score = np.zeros((n_passages, fitted))
    np.add.at(score, passage, found.jac * -found.fun[:, None])
    bread = np.linalg.inv(found.jac.T @ found.jac)
    reach = stdtrit(n_passages - fitted, 0.5 + 0.5 * CONFIDENCE)
    covariance = reach**2 * n_passages / (n_passages - 1) * bread @ (score.T @ score) @ bread

    def interval(*weights):
        """A sum of the parameters so weighted, and its interval's ends."""
        row = np.append(weights, np.zeros(fitted - len(weights)))
        return row @ best + np.array([0.0, -1.0, 1.0]) * np.sqrt(row @ covariance @ row)

    # ln K = ln K' + ln Q0 − n ln δ0: K and n are correlated, and K's interval is wide
    stiffness = Interval(*np.exp(interval(1.0, -np.log(deep)) + np.log(strong)))
    damping, constant = None, UNDAMPED
    if closing_speed is not None:
        damping = Interval(*(strong / fast * interval(0.0, 0.0, 1.0)))
        constant = ContactDamping(constant=damping.value)
    spring = PowerLaw(
        name=FITTED[fitted - 2], stiffness=stiffness.value, exponent=exponent, range="the depths it was fitted to",
        source="fitted to the run's own contact forces, Q = K δ^n")  # fmt: skip
    return Identification(
        DampedLaw(spring=spring, damping=constant), stiffness, Interval(*interval(0.0, 1.0)), damping,
        samples, contacts=load.size, passages=n_passages, depth=(depth.min(), depth.max()),
        scatter=strong * rms(found.fun))  # fmt: skip


def passage_numbers(closed: np.ndarray, bridge: int) -> np.ndarray:
    """Number each passage of a roller through the load zone, (n_times, n_rollers); −1 outside."""
    number = np.full(closed.shape, -1)
    zones = [(j, *zone) for j in range(closed.shape[1]) for zone in load_zones(closed[:, j], bridge)]
    for count, (j, first, last) in enumerate(zones):
        number[first : last + 1, j] = count
    return number


def identify(record: Record, approach, closing_speed, bridge: int, name: str) -> Identification:
    """Fit one of FITTED to a run's own forces over the approach, m, and its rate, m/s.

    InputError: the source holds no forces, or they fix no law.
    """
    try:
        if has_tilts(record):
            raise InputError("laws are not fitted to rollers that tilt; choose a named law")
        if record.inner_force is None:
            raise InputError(
                f"the law {name} is fitted to the run's own contact forces, which this source does not have; choose a "
                "named law"
            )
        return fit_law(approach, record.inner_force, bridge, None if name == "fitted" else closing_speed)
    except InputError as error:
        raise InputError(f"{record.source}: {error}") from None
