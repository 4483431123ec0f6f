"""Bearings without a mesh: exact series for every body under Hertz pressures.

At rest they are the yardstick for the finite-element model: any bearing, frictionless, standing, weightless, in
milliseconds. For dynamics a bearing is reduced to its contacts by the same series, with couplings along its rings and
its waves.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import log, pi
from typing import ClassVar, NamedTuple

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic import continuum as series
from fem.elastic.cache import kept
from fem.elastic.continuum import hertz_approach, plane_compliance, ring_sections, roller_section
from fem.elastic.vibration import inertia
from fem.statics.contact_balance import Condensed, Loads, NotFound, balance, closed_forces
from lagrange import Bearing, Kinematics, Operation
from lagrange.contact.hertz import contact_pairs, line_compliance
from lagrange.fits import growths, outer_growth
from lagrange.kinematics import roller_angles
from lagrange.surface.deviation import Turns

HALF_WIDTH = 0.01  # of a roller's radius; the logarithm of the true half-width is in the law
N_HARMONICS_PER_WIDTH = 200.0  # harmonics times b/R: point values under Hertz pressures converge slowly
LEAST_LOAD = 1e-6  # N; under less, bodies move by less than round-off


class ExactStatics(NamedTuple):
    """Hub position, m, and contact forces, N."""

    hub: np.ndarray  # (2,)
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray


def exact_statics(bearing: Bearing, radial_load: float, first_roller_angle: float) -> ExactStatics:
    """Equilibrium of elastic bodies in Hertz contact under a load along −y, N; angle in rad from +x.

    Errors: each contact errs as Hertz's theory does, by (b/R)² of its approach; couplings are exact for loads along the
    radius.
    NotFound: no equilibrium.

    Source: Michell's series for ring and disc (`continuum`); Johnson, Contact Mechanics (1985), chapters 4 and 5.
    """
    contacts = exact_contacts(bearing, roller_angles(bearing, first_roller_angle))
    position, forces = balance(contacts, Loads(radial_load))
    return ExactStatics(position[:2], *closed_forces(forces).reshape(2, -1))


def exact_contacts(bearing: Bearing, angle: np.ndarray) -> Condensed:
    """The bearing reduced to its contacts by exact series, rollers at angles from +x, (n_rollers,), rad."""
    n, closing = bearing.n_rollers, np.zeros(2 * bearing.n_rollers)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    if bearing.missing:
        whole = exact_contacts(bearing.full, roller_angles(bearing.full, 0.0))
        compliance = _of_present(bearing, whole.compliance)
        return replace(whole, bearing=bearing, radial=radial, compliance=compliance, closing=closing)
    half_width, length, roller = HALF_WIDTH * bearing.roller_radius, bearing.roller_length, roller_section(bearing)
    single, squeezed = hertz_approach(roller, half_width), hertz_approach(roller.squeezed, half_width)
    compliance, j, laws = np.zeros((2 * n, 2 * n)), np.arange(n), []
    for k, (ring, pair) in enumerate(zip(ring_sections(bearing), contact_pairs(bearing), strict=False)):
        loaded = _loaded_ring(ring, half_width)
        for shift in range(1, n // 2 + 1):  # equally spaced: one value per distance
            value, to = series.patch_displacement(*loaded, 1.0, ring.loaded, angle[shift] - angle[0]), (j + shift) % n
            compliance[k * n + j, k * n + to] = compliance[k * n + to, k * n + j] = value
        approach = (hertz_approach(ring, half_width) + single) / length
        laws.append(ContactLaw.of_approach(approach, half_width, pair))
    compliance[j, n + j] = compliance[n + j, j] = squeezed - single
    return Condensed(
        bearing=bearing, radial=radial, inner_law=laws[0], outer_law=laws[1], compliance=compliance / length,
        closing=closing,
    )  # fmt: skip


def _of_present(bearing, compliance):
    """Compliance of the contacts of a bearing's rollers, (2 n_rollers, 2 n_rollers), of those of all pockets."""
    contacts = np.concatenate([bearing.pocket, bearing.pockets + np.array(bearing.pocket)])
    return compliance[np.ix_(contacts, contacts)]


def _loaded_ring(ring, half_width, compliance=plane_compliance):
    """Compliance, m/Pa, and transform of the load, by harmonics, (n_harmonics,)."""
    harmonics = np.arange(int(N_HARMONICS_PER_WIDTH * ring.loaded / half_width))
    return compliance(ring, harmonics), series.hertz_patch(harmonics, half_width, ring.loaded)


def couplings_at(bearing: Bearing, angle: np.ndarray) -> np.ndarray:
    """Coupling compliance of a contact with a force at an angle, rad, along its ring, and its slope: (2, 2, n_angles).

    By ring, inner and outer: m/N, and m/N per rad.
    """
    found = []
    for ring in ring_sections(bearing):
        loaded = _loaded_ring(ring, HALF_WIDTH * bearing.roller_radius)
        given = [series.patch_displacement(*loaded, 1.0, ring.loaded, each) for each in angle]
        found.append([given, [series.patch_slope(*loaded, ring.loaded, each) for each in angle]])
    return np.array(found) / bearing.roller_length


def crossings_at(bearing: Bearing, angle: np.ndarray) -> np.ndarray:
    """Cross compliance of a raceway under tractions along +θ, at angles, rad, ahead of them: (2, n_angles), m/N.

    By ring, inner and outer.
    """
    found = []
    for ring in ring_sections(bearing):
        pulled = _loaded_ring(ring, HALF_WIDTH * bearing.roller_radius, series.cross_compliance)
        found.append([series.patch_crossing(*pulled, ring.loaded, each) for each in angle])
    return np.array(found) / bearing.roller_length


@lru_cache(maxsize=8)
def law_error(bearing: Bearing, law: ContactLaw, force: float) -> float:
    """By how much of its approach a raceway contact's law is too stiff under a force, N, as far as series know.

    The law takes a body's displacement near a contact for a half-plane's and what a narrow load adds; series have all
    of a body, under Hertz's pressure.

    Errors: the pressure's own change is not in it: collocation of twenty contacts, of half-widths of 2 to 9 % of the
    roller's radius and up to 23 % of the ring's thickness, finds 1.6 to 2.4 times as much.
    ValueError: a half-width beyond the roller's radius.
    """
    half_width, ring = law.pair.half_width(force), ring_sections(bearing)[law.pair.kind != "inner"]
    bodies = hertz_approach(ring, half_width) + hertz_approach(roller_section(bearing), half_width)
    whole = force * bodies / law.pair.length
    return whole / float(law.approach(force)) - 1.0


@dataclass(frozen=True)
class ExpectedForces:
    """Static forces of a bearing's contacts, N."""

    bearing: Bearing
    operation: Operation

    @cached_property
    def largest(self) -> float:
        """Largest force by exact statics, solved when first asked for; the bound where there is no equilibrium."""
        try:
            found = exact_statics(self.bearing, self._load, self.operation.first_roller_angle)
        except NotFound:
            return self.bound
        return float(max(found.inner_force.max(), found.outer_force.max())) + self._centrifugal

    @property
    def bound(self) -> float:
        """Above any contact's force: all the load on one roller, and the preload of rigid rings."""
        bearing, preload = self.bearing, max(0.0, -self.bearing.radial_clearance)
        bodies = bearing.roller, bearing.inner_ring, bearing.outer_ring
        modulus = max(material.plane_strain_modulus for material in bodies if not material.rigid)
        return self._load + self._centrifugal + modulus * bearing.roller_length * preload

    _load = property(lambda self: self.operation.heaviest + self.operation.inner_mass * self.operation.gravity)

    @property
    def _centrifugal(self):
        inner, outer = (np.abs(speeds).max() for speeds in self.operation.ring_speeds_met)
        cage = float(0.5 * inner + outer)  # or less
        return self.bearing.roller_mass * cage**2 * self.bearing.pitch_radius


class UnseenWaves(NamedTuple):
    """All modes of a bearing's bodies."""

    inertia: tuple[float, float]  # s⁴/kg, Σ s²/ω⁴ of them at an inner and an outer contact
    slowest: float  # rad/s


@lru_cache(maxsize=1)
def unseen_waves(bearing: Bearing, inner_mass: float) -> UnseenWaves:
    """Those of a bearing with a hub that makes its inner ring `inner_mass`, kg."""
    bearing, hub = replace(bearing, faults=()), inner_mass - bearing.inner_ring_mass

    def make():
        sections = roller_section(bearing), *ring_sections(bearing)
        hubs = None, hub if bearing.bore_radius > 0.0 else None, None
        found = [inertia(section, bearing.roller_length, on) for section, on in zip(sections, hubs, strict=True)]
        return {"inertia": np.array(found)}

    (roller, inner, outer), frequency = kept("inertia", repr((bearing, inner_mass)), make)["inertia"].T
    return UnseenWaves(inertia=(float(roller + inner), float(roller + outer)), slowest=float(frequency.min()))


def softened(law: ContactLaw, compliance: float) -> ContactLaw:
    """The law of a contact less a linear compliance, m/N, that its bodies' modes carry."""
    return ContactLaw.of_level(law.A, law.B - compliance / law.A, law.pair)


FAINT = 1e-6  # of a contact's own compliance: a neighbour's force that moves it less is left out
STRAYS = 0.25  # of the rollers' distance, by which compliances follow their angles
FAINT_CHANGE = 1e-4  # of a contact's own compliance: what changes less over that is left out
FAINT_TRACTION = 5e-3  # of a contact's own compliance: a neighbour's traction, a tenth of a force at most, likewise


class RingCouplings(NamedTuple):
    """Compliances by neighbours, polynomials of how much further than at equal angles these are."""

    distance: np.ndarray  # (neighbours,), in rollers: −1, 1, −2 ...
    counts: np.ndarray  # (2, 2), whole: by ring, of how many the angles matter, and how many do themselves
    along: np.ndarray  # (2, neighbours), m/N
    steep: np.ndarray  # (2, neighbours), m/N per rad
    bent: np.ndarray  # (2, 4, neighbours), m/N/rad² to m/N/rad⁵
    strays: float  # rad, how much nearer or further
    crossed: np.ndarray  # (2, neighbours), m/N, by tractions on these rollers along +θ, at equal angles
    crossing: np.ndarray  # (2,), whole: by ring, of how many they matter


def strays(n_rollers: int) -> float:
    """By how much, rad, angles between rollers may be smaller or larger; beyond, compliances stay."""
    return STRAYS * 2.0 * pi / n_rollers


def _neighbours(n):
    """By how many rollers others are ahead, the nearest first: −1, 1, −2 ..."""
    return np.array([d for k in range(1, n // 2 + 1) for d in ((-k, k) if 2 * k < n else (k,))], dtype=np.intp)


def _ring_couplings(bearing, around, crossed, own):
    """Couplings by the rings' series, see `_kept_series`; `own` : m/N, compliance of a contact, over ln Q."""
    h, distance = strays(bearing.n_rollers), _neighbours(bearing.n_rollers)
    ahead, far = distance > 0, np.abs(distance) - 1
    given, slope = around[:, :, :, far].swapaxes(0, 1)
    given = np.where(ahead, given, given[:, ::-1])  # an even function of the angle
    slope = np.where(ahead, slope, -slope[:, ::-1])
    along, steep = given[:, 1], slope[:, 1]
    # coefficients of x² to x⁵ of the polynomials with these values and slopes at −h, 0, h
    even, odd = 0.5 * (given[:, 2] + given[:, 0]) - along, 0.5 * (given[:, 2] - given[:, 0]) - h * steep
    of_even, of_odd = 0.5 * h * (slope[:, 2] - slope[:, 0]), h * (0.5 * (slope[:, 2] + slope[:, 0]) - steep)
    fourth, fifth = 0.5 * of_even - even, 0.5 * of_odd - 1.5 * odd
    bent = np.stack([(even - fourth) / h**2, (odd - fifth) / h**3, fourth / h**4, fifth / h**5], axis=1)
    changed = np.abs(given - given[:, 1:2]).max(axis=1)
    # an odd function of the angle; what pulls a roller along pulls its ring back
    crossed = np.where(ahead, crossed[:, far], -crossed[:, far])

    def reach(values, limit):
        """By ring, how many there are up to the last one beyond a limit."""
        return [int(np.flatnonzero(row > limit * own).max(initial=-1)) + 1 for row in values]

    count, pulled = reach(np.abs(along), FAINT), reach(np.abs(crossed), FAINT_TRACTION)
    near, kept = np.minimum(reach(changed, FAINT_CHANGE), count), slice(max(count + pulled))
    along, steep, bent, crossed = (np.ascontiguousarray(array[..., kept]) for array in (along, steep, bent, crossed))
    return RingCouplings(
        distance=distance[kept], counts=np.array([near, count], dtype=np.intp).T.copy(), along=along, steep=steep,
        bent=bent, strays=h, crossed=crossed, crossing=np.array(pulled, dtype=np.intp),
    )  # fmt: skip


def neighbours_of(bearing: Bearing, rings: RingCouplings) -> tuple[RingCouplings, np.ndarray]:
    """Couplings by neighbours of rollers that are there, and for each, (neighbours, n_rollers), the pocket's, or −1.

    The neighbours' compliances are those of `rings` in these places, 0 at −1; the couplings' own arrays are empty.
    """
    n, total, pocket = bearing.n_rollers, bearing.pockets, np.array(bearing.pocket)
    every = _neighbours(n)
    distance = every[np.abs(every) <= np.abs(rings.distance).max(initial=0)]
    apart, below = pocket[(np.arange(n) + distance[:, None]) % n] - pocket, (total - 1) // 2
    apart = (apart + below) % total - below  # the shorter way
    at = np.full(apart.shape, -1)
    for place, pockets in enumerate(rings.distance):
        at[apart == pockets] = place

    def as_far(count):
        """How many neighbours are as far as that many pockets'."""
        return np.sum(np.abs(distance) <= np.abs(rings.distance[:count]).max(initial=0))

    counted = np.vectorize(as_far, otypes=[np.intp])
    return rings._replace(distance=distance, counts=counted(rings.counts), crossing=counted(rings.crossing)), at


@dataclass(frozen=True, kw_only=True)
class ReducedBearing:
    """Compliances of the contacts, rollers at equal angles."""

    contacts: Condensed  # whole bodies, rollers from angle 0 on; `closing` by the growth of spinning bodies
    between: ContactLaw  # of two rollers
    rings: RingCouplings  # by pockets
    across: float  # m/N
    inner_growth: float  # m, of the inner raceway as it spins
    roller_growth: float
    outer_growth: float
    sag: tuple[float, float]  # m, of the raceways below hub and outer ring, by the rings' own weight

    failure_hint: ClassVar[str] = ""
    bearing = property(lambda self: self.contacts.bearing)
    inner_law = property(lambda self: self.contacts.inner_law)
    outer_law = property(lambda self: self.contacts.outer_law)
    laws = property(lambda self: self.contacts.laws)

    def give(self, load: float) -> float:
        """Deflection of a sound contact under the load at the hub, N, beyond that of elastic bodies, m."""
        return 0.0

    def at(self, angle: np.ndarray, turns: Turns) -> Condensed:
        """The contacts with rollers at angles from +x, (n_rollers,), rad, and bodies turned so far."""
        radial = np.column_stack([np.cos(angle), np.sin(angle)])
        fallen = np.concatenate([-self.sag[0] * np.sin(angle), self.sag[1] * np.sin(angle)])
        return replace(self.contacts, radial=radial, turns=turns, closing=self.contacts.closing + fallen)


def reduced_bearing(bearing: Bearing, motion: Kinematics, gravity: float = 0.0) -> ReducedBearing:
    """Reduce a bearing that rolls, under gravity, m/s², to its contacts.

    Errors: as of `exact_statics`. Compliances between contacts are those of rollers at equal angles; the rollers' own
    growth is that of their rolling speed. What flows through a contact makes its own law softer, but no other
    compliance.
    UsageError: contacts roll nearly as fast as waves (`moving_softening`).
    """
    (contacts, between), found, n = kept_contacts(bearing), _kept_series(_sound(bearing)), bearing.n_rollers
    (inner_growth, roller_growth), of_outer = growths(bearing, motion), outer_growth(bearing, motion)
    closing = np.repeat([inner_growth + roller_growth, roller_growth - of_outer], n)
    inner, outer = (_rolling(law, bearing, motion) for law in contacts.laws)
    return ReducedBearing(
        contacts=replace(contacts, closing=closing, inner_law=inner, outer_law=outer), between=between,
        across=float(contacts.compliance[0, n]),
        rings=_ring_couplings(bearing.full, found["around"], found["crossed"], inner.A),
        inner_growth=inner_growth, roller_growth=roller_growth, outer_growth=of_outer,
        sag=tuple(series.weight_sag(ring, gravity) for ring in ring_sections(bearing)),
    )  # fmt: skip


def _rolling(law, bearing, motion):
    """The law of a contact that rolls along both surfaces: its two sides by how much softer they are.

    A ring's harmonics that are longer than two rollers' distance stand still with the load zone: they are as they were.
    """
    speed, pair = (motion.cage - motion.outer_ring) * bearing.outer_raceway_radius, law.pair
    of_ring, of_roller = (series.moving_softening(material, speed) for material in pair.materials)
    sides = [line_compliance(material, pair.length) for material in pair.materials]
    share = (of_ring * sides[0] + of_roller * sides[1]) / sum(sides)
    still = _long_waves(_sound(bearing), pair.kind != "inner")
    faster = ContactLaw.of_level(law.A * share, law.B - 0.5 * log(share), pair)  # b² grows as A
    return softened(faster, (of_ring - 1.0) * still)


@lru_cache(maxsize=2)
def _long_waves(bearing, outer):
    """What harmonics longer than two rollers' distance have of a ring's own compliance, m/N."""
    ring = ring_sections(bearing)[outer]
    harmonics = plane_compliance(ring, np.arange((bearing.pockets + 1) // 2))
    harmonics[0] *= 0.5
    return float(harmonics.sum()) / (pi * ring.loaded * bearing.roller_length)


def kept_contacts(bearing: Bearing) -> tuple[Condensed, ContactLaw]:
    """`exact_contacts` of rollers from angle 0 on, and the law of rollers that meet; their series are kept on disk."""
    angle, arrays = roller_angles(bearing, 0.0), _kept_series(_sound(bearing))
    constants = zip(arrays["laws"].tolist(), contact_pairs(bearing), strict=True)
    inner, outer, between = (ContactLaw(A=A, B=B, Q_line=line, pair=pair) for (A, B, line), pair in constants)
    contacts = Condensed(
        bearing=bearing, radial=np.column_stack([np.cos(angle), np.sin(angle)]), inner_law=inner, outer_law=outer,
        compliance=_of_present(bearing, arrays["compliance"]), closing=np.zeros(2 * bearing.n_rollers),
    )  # fmt: skip
    return contacts, between


def _sound(bearing):
    """The bearing whose series are kept: neither faults of surfaces nor missing rollers change how bodies give way."""
    return replace(bearing, faults=()).full


@lru_cache(maxsize=1)
def _kept_series(bearing):
    """Series and laws, the last bearing's kept in memory: scenes that follow differ in speed, load or faults."""

    def make():
        found, width = exact_contacts(bearing, roller_angles(bearing, 0.0)), HALF_WIDTH * bearing.roller_radius
        each = hertz_approach(roller_section(bearing).elastic, width)  # of two rollers, accelerated by the other
        between = ContactLaw.of_approach(2.0 * each / bearing.roller_length, width, contact_pairs(bearing)[2])
        laws = found.inner_law, found.outer_law, between
        n, roller = bearing.n_rollers, series.stick_approach(roller_section(bearing).elastic, width)
        shift = 2.0 * pi / n * np.arange(1, n // 2 + 1)
        angles = np.add.outer(strays(n) * np.array([-1.0, 0.0, 1.0]), shift)
        others = *(series.stick_approach(ring, width) for ring in ring_sections(bearing)), roller
        return {
            "compliance": found.compliance,
            "laws": np.array([(law.A, law.B, law.Q_line) for law in laws]),
            # compliances and slopes a bit less far, as far and further than 1, 2 ... of n equal parts
            "around": couplings_at(bearing, angles.ravel()).reshape(2, 2, *angles.shape),
            "crossed": crossings_at(bearing, shift),  # by tractions 1, 2 ... parts behind, (2, n // 2)
            "stick": np.array([(roller + other) / bearing.roller_length for other in others]),
        }

    return kept("contact-laws", repr(bearing), make)


def tangential_compliance(bearing: Bearing, force: float) -> np.ndarray:
    """Tangential compliance, (3,), m/N, of an inner, outer and roller's contact that sticks under a normal force, N.

    Errors: known exactly for one half-width, from which it goes with the logarithm: 0.1 % off at half-widths of 5 % of
    a roller's radius.
    """
    known, found = HALF_WIDTH * bearing.roller_radius, _kept_series(_sound(bearing))["stick"].copy()
    for row, pair in enumerate(contact_pairs(bearing)):
        width = min(pair.half_width(force), 0.5 * bearing.roller_radius)
        found[row] += pair.line_compliance * log(known / width)
    return found
