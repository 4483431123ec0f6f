"""A bearing reduced to its contacts for dynamics: exact series for every body, couplings along its rings, its waves."""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import log, pi
from typing import ClassVar

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.cache import kept
from fem.elastic.continuum import (
    hertz_approach,
    moving_softening,
    plane_compliance,
    ring_sections,
    roller_section,
    stick_approach,
    weight_sag,
)
from fem.elastic.vibration import inertia
from fem.statics.contact_balance import Condensed
from fem.statics.exact_statics import HALF_WIDTH, couplings_at, crossings_at, exact_contacts, of_present
from lagrange import Bearing, Kinematics
from lagrange.contact.hertz import Pair, contact_pairs, line_compliance
from lagrange.fits import growths, outer_growth
from lagrange.kinematics import roller_angles
from lagrange.surface.deviation import Turns


@dataclass(frozen=True, kw_only=True)
class UnseenWaves:
    """All modes of a bearing's bodies."""

    inertia: tuple[float, float]  # s⁴/kg, Σ s²/ω⁴ of them at an inner and an outer contact
    slowest: float  # rad/s


def unseen_waves(bearing: Bearing, inner_mass: float) -> UnseenWaves:
    """Those of a bearing with a hub that makes its inner ring `inner_mass`, kg."""
    table = _inertia(replace(bearing, faults=()), inner_mass)
    roller, inner, outer = table[:, 0]
    return UnseenWaves(inertia=(float(roller + inner), float(roller + outer)), slowest=float(table[:, 1].min()))


@lru_cache(maxsize=1)
def _inertia(bearing: Bearing, inner_mass: float) -> np.ndarray:
    """Σ s²/ω⁴, s⁴/kg, of all modes of a roller and both rings, and the slowest's frequency, rad/s: (3, 2)."""
    length, hub = bearing.roller_length, inner_mass - bearing.inner_ring_mass

    def make():
        inner, outer = ring_sections(bearing)
        found = (
            inertia(roller_section(bearing), length),
            inertia(inner, length, hub if bearing.bore_radius > 0.0 else None),
            inertia(outer, length),
        )
        return {"inertia": np.array(found)}

    return kept("inertia", repr((bearing, inner_mass)), make)["inertia"]


def softened(law: ContactLaw, compliance: float) -> ContactLaw:
    """The law of a contact less a linear compliance, m/N, that its bodies' modes carry."""
    return ContactLaw.of_level(law.A, law.B - compliance / law.A, law.pair)


FAINT = 1e-6  # of a contact's own compliance: a neighbour's force that moves it less is left out
STRAYS = 0.25  # of the rollers' distance, by which compliances follow their angles
FAINT_CHANGE = 1e-4  # of a contact's own compliance: what changes less over that is left out
FAINT_TRACTION = 5e-3  # of a contact's own compliance: a neighbour's traction, a tenth of a force at most, likewise


@dataclass(frozen=True, kw_only=True)
class RingCouplings:
    """Compliances by neighbours, polynomials of how much further than at equal angles these are."""

    distance: np.ndarray  # (neighbours,), in rollers: −1, 1, −2 ...
    felt: np.ndarray  # (2, 2), whole: by ring, of how many the angles matter, and how many do themselves
    along: np.ndarray  # (2, neighbours), m/N
    steep: np.ndarray  # (2, neighbours), m/N per rad
    bent: np.ndarray  # (2, 4, neighbours), m/N/rad² to m/N/rad⁵
    strays: float  # rad, how much nearer or further
    crossed: np.ndarray  # (2, neighbours), m/N, by tractions on these rollers along +θ, at equal angles
    crossing: np.ndarray  # (2,), whole: by ring, of how many they matter


def strays(n_rollers: int) -> float:
    """By how much, rad, angles between rollers may be smaller or larger; beyond, compliances stay."""
    return STRAYS * 2.0 * pi / n_rollers


def series_around(bearing: Bearing) -> np.ndarray:
    """Compliances and slopes a bit less far, as far and further than 1, 2 ... of n equal parts: (2, 2, 3, n // 2)."""
    n = bearing.n_rollers
    shift = 2.0 * pi / n * np.arange(1, n // 2 + 1)
    angles = np.add.outer(strays(n) * np.array([-1.0, 0.0, 1.0]), shift)
    return couplings_at(bearing, angles.ravel()).reshape(2, 2, *angles.shape)


def crossed_series(bearing: Bearing) -> np.ndarray:
    """Cross compliance of a raceway under a traction 1, 2 ... of n equal parts behind: (2, n // 2), m/N."""
    n = bearing.n_rollers
    return crossings_at(bearing, 2.0 * pi / n * np.arange(1, n // 2 + 1))


def ring_couplings(bearing: Bearing, series: np.ndarray, crossed: np.ndarray, own: float) -> RingCouplings:
    """Couplings of `series_around`, and of `crossed_series`; `own` : m/N, compliance of a contact, over ln Q."""
    n, h = bearing.n_rollers, strays(bearing.n_rollers)
    distance = np.array([d for k in range(1, n // 2 + 1) for d in ((-k, k) if 2 * k < n else (k,))], dtype=np.intp)
    ahead = distance > 0
    given, slope = series[:, :, :, np.abs(distance) - 1].swapaxes(0, 1)
    given = np.where(ahead, given, given[:, ::-1])  # an even function of the angle
    slope = np.where(ahead, slope, -slope[:, ::-1])
    along, steep, bent = given[:, 1], slope[:, 1], _bent(given, slope, h)
    changed = np.abs(given - given[:, 1:2]).max(axis=1)
    count = [_last(row, FAINT * own) for row in np.abs(along)]
    near = [min(_last(row, FAINT_CHANGE * own), most) for row, most in zip(changed, count, strict=True)]
    # an odd function of the angle; what pulls a roller along pulls its ring back
    crossed = np.where(ahead, crossed[:, np.abs(distance) - 1], -crossed[:, np.abs(distance) - 1])
    pulled = [_last(row, FAINT_TRACTION * own) for row in np.abs(crossed)]
    kept = slice(max(count + pulled))
    along, steep, bent, crossed = (np.ascontiguousarray(array[..., kept]) for array in (along, steep, bent, crossed))
    return RingCouplings(
        distance=distance[kept],
        felt=np.array([near, count], dtype=np.intp).T.copy(),
        along=along,
        steep=steep,
        bent=bent,
        strays=h,
        crossed=crossed,
        crossing=np.array(pulled, dtype=np.intp),
    )


def neighbours_of(bearing: Bearing, rings: RingCouplings) -> tuple[RingCouplings, np.ndarray]:
    """Couplings by neighbours of rollers that are there, and for each, (neighbours, n_rollers), the pocket's, or −1.

    The neighbours' compliances are those of `rings` in these places, 0 at −1; the couplings' own arrays are empty.
    """
    n, total, pocket = bearing.n_rollers, bearing.pockets, np.array(bearing.pocket)
    every = np.array([d for k in range(1, n // 2 + 1) for d in ((-k, k) if 2 * k < n else (k,))], dtype=np.intp)
    distance = every[np.abs(every) <= np.abs(rings.distance).max(initial=0)]
    apart = pocket[(np.arange(n) + distance[:, None]) % n] - pocket
    below = (total - 1) // 2
    apart = (apart + below) % total - below  # the shorter way
    at = np.full(apart.shape, -1)
    for place, pockets in enumerate(rings.distance):
        at[apart == pockets] = place

    def counted(counts: np.ndarray) -> np.ndarray:
        """Neighbours as far as these many pockets."""
        furthest = [np.abs(rings.distance[:count]).max(initial=0) for count in counts.ravel()]
        return np.array([np.sum(np.abs(distance) <= far) for far in furthest], dtype=np.intp).reshape(counts.shape)

    found = replace(rings, distance=distance, felt=counted(rings.felt), crossing=counted(rings.crossing))
    return found, at


def _bent(given: np.ndarray, slope: np.ndarray, h: float) -> np.ndarray:
    """Coefficients of x² to x⁵ of the polynomials with values and slopes, (2, 3, neighbours), at −h, 0, h."""
    even = 0.5 * (given[:, 2] + given[:, 0]) - given[:, 1]
    odd = 0.5 * (given[:, 2] - given[:, 0]) - h * slope[:, 1]
    of_even, of_odd = 0.5 * h * (slope[:, 2] - slope[:, 0]), h * (0.5 * (slope[:, 2] + slope[:, 0]) - slope[:, 1])
    fourth, fifth = 0.5 * of_even - even, 0.5 * of_odd - 1.5 * odd
    found = (even - fourth) / h**2, (odd - fifth) / h**3, fourth / h**4, fifth / h**5
    return np.stack(found, axis=1)


def _last(values: np.ndarray, limit: float) -> int:
    """How many values there are up to the last one beyond a limit."""
    return int(np.flatnonzero(values > limit).max(initial=-1)) + 1


@dataclass(frozen=True, kw_only=True)
class ReducedBearing:
    """Compliances of the contacts, rollers at equal angles."""

    contacts: Condensed  # whole bodies, rollers from angle 0 on; `closing` by the growth of spinning bodies
    inner_law: ContactLaw
    outer_law: ContactLaw
    between: ContactLaw  # of two rollers
    rings: RingCouplings  # by pockets
    across: float  # m/N
    inner_growth: float  # m, of the inner raceway as it spins
    roller_growth: float
    outer_growth: float
    sag: tuple[float, float]  # m, of the raceways below hub and outer ring, by the rings' own weight

    failure_hint: ClassVar[str] = ""

    @property
    def bearing(self) -> Bearing:
        return self.contacts.bearing

    def give(self, load: float) -> float:
        """Deflection of a sound contact under the load at the hub, N, beyond that of elastic bodies, m."""
        return 0.0

    def at(self, angle: np.ndarray, turns: Turns) -> Condensed:
        """The contacts with rollers at angles from +x, (n_rollers,), rad, and bodies turned so far."""
        radial = np.column_stack([np.cos(angle), np.sin(angle)])
        sag_i, sag_o = self.sag
        fallen = np.concatenate([-sag_i * np.sin(angle), sag_o * np.sin(angle)])
        return replace(self.contacts, radial=radial, turns=turns, closing=self.contacts.closing + fallen)


def reduced_bearing(bearing: Bearing, motion: Kinematics, gravity: float = 0.0) -> ReducedBearing:
    """Reduce a bearing that rolls, under gravity, m/s², to its contacts.

    Errors
    ------
    As of `exact_statics`. Compliances between contacts are those of rollers at equal angles; the rollers' own growth is
    that of their rolling speed. What flows through a contact makes its own law softer, but no other compliance.
    UsageError: contacts roll nearly as fast as waves (`moving_softening`).
    """
    contacts, between = kept_contacts(bearing)
    contacts = replace(
        contacts,
        inner_law=_rolling(contacts.inner_law, bearing, motion),
        outer_law=_rolling(contacts.outer_law, bearing, motion),
    )
    n = bearing.n_rollers
    series = _kept_series(_sound(bearing))
    (inner_growth, roller_growth), of_outer = growths(bearing, motion), outer_growth(bearing, motion)
    closing = np.repeat([inner_growth + roller_growth, roller_growth - of_outer], n)
    return ReducedBearing(
        contacts=replace(contacts, closing=closing),
        inner_law=contacts.inner_law,
        outer_law=contacts.outer_law,
        between=between,
        rings=ring_couplings(bearing.full, series["around"], series["crossed"], contacts.inner_law.A),
        across=float(contacts.compliance[0, n]),
        inner_growth=inner_growth,
        roller_growth=roller_growth,
        outer_growth=of_outer,
        sag=sags(bearing, gravity),
    )


def _rolling(law: ContactLaw, bearing: Bearing, motion: Kinematics) -> ContactLaw:
    """The law of a contact that rolls along both surfaces: its two sides by how much softer they are.

    A ring's harmonics that are longer than two rollers' distance stand still with the load zone: they are as they were.
    """
    speed, pair = (motion.cage - motion.outer_ring) * bearing.outer_raceway_radius, law.pair
    of_ring, of_roller = (moving_softening(material, speed) for material in pair.materials)
    sides = [line_compliance(material, pair.length) for material in pair.materials]
    share = (of_ring * sides[0] + of_roller * sides[1]) / sum(sides)
    still = _long_waves(_sound(bearing), pair.kind == "inner")
    faster = ContactLaw.of_level(law.A * share, law.B - 0.5 * log(share), pair)  # b² grows as A
    return softened(faster, (of_ring - 1.0) * still)


@lru_cache(maxsize=2)
def _long_waves(bearing: Bearing, inner: bool) -> float:
    """What harmonics longer than two rollers' distance have of a ring's own compliance, m/N."""
    ring = ring_sections(bearing)[0 if inner else 1]
    series = plane_compliance(ring, np.arange((bearing.pockets + 1) // 2))
    series[0] *= 0.5
    return float(series.sum()) / (np.pi * ring.loaded * bearing.roller_length)


def sags(bearing: Bearing, gravity: float) -> tuple[float, float]:
    """How far the raceways' centres fall below the bore's and the outside's by the weight of each ring, m."""
    inner, outer = ring_sections(bearing)
    return weight_sag(inner, gravity), weight_sag(outer, gravity)


def kept_contacts(bearing: Bearing) -> tuple[Condensed, ContactLaw]:
    """`exact_contacts` of rollers from angle 0 on, and the law of rollers that meet; their series are kept on disk."""
    angle, pairs = roller_angles(bearing, 0.0), contact_pairs(bearing)
    arrays = _kept_series(_sound(bearing))
    inner, outer, between = (
        ContactLaw(A=float(A), B=float(B), Q_line=float(line), pair=pair)
        for (A, B, line), pair in zip(arrays["laws"], pairs, strict=True)
    )
    contacts = Condensed(
        bearing=bearing,
        radial=np.column_stack([np.cos(angle), np.sin(angle)]),
        inner_law=inner,
        outer_law=outer,
        compliance=of_present(bearing, arrays["compliance"]) if bearing.missing else arrays["compliance"],
        closing=np.zeros(2 * bearing.n_rollers),
    )
    return contacts, between


def _sound(bearing: Bearing) -> Bearing:
    """The bearing whose series are kept: neither faults of surfaces nor missing rollers change how bodies give way."""
    return replace(bearing, faults=()).full


@lru_cache(maxsize=1)
def _kept_series(bearing: Bearing) -> dict[str, np.ndarray]:
    """Series and laws, the last bearing's kept in memory: scenes that follow differ in speed, load or faults."""

    def make():
        found = exact_contacts(bearing, roller_angles(bearing, 0.0))
        laws = found.inner_law, found.outer_law, _between(bearing, contact_pairs(bearing)[2])
        return {
            "compliance": found.compliance,
            "laws": np.array([(law.A, law.B, law.Q_line) for law in laws]),
            "around": series_around(bearing),
            "crossed": crossed_series(bearing),
            "stick": _stick_compliance(bearing, HALF_WIDTH * bearing.roller_radius),
        }

    return kept("contact-laws", repr(bearing), make)


def _between(bearing: Bearing, pair: Pair) -> ContactLaw:
    """The law of two rollers that meet, each accelerated by the other."""
    half_width = HALF_WIDTH * bearing.roller_radius
    approach = 2.0 * hertz_approach(roller_section(bearing).elastic, half_width) / pair.length
    A = pair.line_compliance
    return ContactLaw.of_level(A, approach / A + log(half_width) - 0.5 * log(pair.half_width_factor), pair)


def tangential_compliance(bearing: Bearing, force: float) -> np.ndarray:
    """Tangential compliance, (3,), m/N, of an inner, outer and roller's contact that sticks under a normal force, N.

    Errors
    ------
    Known exactly for one half-width, from which it goes with the logarithm: 0.1 % off at half-widths of 5 % of a
    roller's radius.
    """
    known = HALF_WIDTH * bearing.roller_radius
    found = _kept_series(_sound(bearing))["stick"].copy()
    for row, pair in enumerate(contact_pairs(bearing)):
        width = min(pair.half_width(force), 0.5 * bearing.roller_radius)
        found[row] += pair.line_compliance * log(known / width)
    return found


def _stick_compliance(bearing: Bearing, half_width: float) -> np.ndarray:
    """The same of contacts so wide, m."""
    roller = stick_approach(roller_section(bearing).elastic, half_width)
    others = *(stick_approach(ring, half_width) for ring in ring_sections(bearing)), roller
    return np.array([(roller + other) / bearing.roller_length for other in others])
