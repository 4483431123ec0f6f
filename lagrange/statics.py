"""Static equilibrium of hub and rolling elements at given angles, by Newton's method: axes parallel, or tilted.

With parallel axes each element's radius ρ is eliminated: at a given hub position its radial balance has one root. The
equilibrium is the least of a potential of the hub's two coordinates, found by Newton's method with a line search.

With rollers that tilt unknowns are the hub's place and, where it is free, its slope, the rollers' radii and tilts, and
each contact's own approach and misalignment: where bodies are elastic these are less than the bodies' by what the
forces and moments of other contacts take. Contacts are smooth tables, so no contact has to be found open or closed.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.contact.laws import ContactLaws
from lagrange.equations import PolarOverlaps, nothing_carries, polar_deviated, polar_overlaps, touching_distances
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.deviation import UNTURNED, SurfaceDeviation, Turns, profiles
from lagrange.surface.edges import pressed, softened
from lagrange.tilt import HubTilt, TiltedLaws, Tilts, falls, met, misalignments, precession_stiffness

BALANCE = 1e-10  # of load and contact forces: what Newton's method must reach
MAX_NEWTON = 200
MAX_RADIAL = 100
ROUND_OFF = 4e-16  # of a radius: two units in its last place
SOFTEST = 1e-6  # smallest curvature in use, of the stiffest direction of one contact


@dataclass(frozen=True, kw_only=True)
class Statics:
    """An equilibrium; m, rad, N; arrays (n_rollers,)."""

    x: float  # centre of the inner ring
    y: float
    rho: np.ndarray
    theta: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    stiffness: np.ndarray  # (2, 2), N/m, of the hub's place as elements follow it; negative across what it balances on


def static_equilibrium(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    *,
    angles: np.ndarray | None = None,
    roller_mass: float | None = None,
    start: tuple[float, float] | None = None,
    turns: Turns = UNTURNED,
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0),
) -> Statics:
    """Equilibrium under load, weights and the elements' centrifugal force at cage speed.

    Parameters
    ----------
    angles : (n_rollers,), rad; default: equally spaced from the operation's first angle
    roller_mass : kg; default: the bearing's; 0 leaves out the elements' weight and centrifugal force
    start : hub position to begin from, m
    turns : of ring and rollers, which matter where their surfaces are not perfect
    ring : where the outer ring's centre is, m, from which all places are; the shaft's springs know the fixed frame

    Errors
    ------
    RuntimeError: no equilibrium found. Forces balance to 1e-10 of the load and of the contacts' forces, or to the
    round-off of the approaches (1e-8 N) if that is more. Without load the hub
    of a bearing with clearance stays where it is put; an element that nothing holds lies midway in its gap.
    """
    theta = roller_angles(bearing, operation.first_roller_angle) if angles is None else np.asarray(angles, dtype=float)
    mass = bearing.roller_mass if roller_mass is None else roller_mass
    load = _load(operation)
    weight = float(np.hypot(*load))
    system = _System(bearing, operation, laws, theta, mass, turns, np.asarray(ring, dtype=float))
    hub = np.zeros(2) if start is None else np.array(start, dtype=float)
    if start is None and weight > 0.0:
        perfect = _System(replace(bearing, faults=()), operation, laws, theta, mass, turns, system.ring)
        hub = _sink(perfect, load, load / weight)  # near enough, and faster
    here = system.at(hub, load)
    finest = ROUND_OFF * np.max(system.track) * system.typical_stiffness * bearing.n_rollers
    for _ in range(MAX_NEWTON):
        if np.max(np.abs(here.unbalance)) <= BALANCE * (weight + np.sum(here.inner_force)) + finest:
            return Statics(
                x=float(hub[0]), y=float(hub[1]), rho=here.rho, theta=theta,
                inner_force=here.inner_force, outer_force=here.outer_force, stiffness=here.stiffness,
            )  # fmt: skip
        step = _newton_step(here, system.typical_stiffness)
        hub, here = _descend(system, hub, here, step, load)
    raise RuntimeError(
        nothing_carries(bearing, theta, load)
        or f"no static equilibrium after {MAX_NEWTON} steps: {np.max(np.abs(here.unbalance)):.3g} N unbalanced at hub "
        f"x = {hub[0]:.3e} m, y = {hub[1]:.3e} m; check load, clearance {bearing.radial_clearance:.3e} m and law"
    )


def held_hub(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    hub: np.ndarray,
    *,
    angles: np.ndarray,
    turns: Turns = UNTURNED,
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force that holds the hub at a place, (2,), N, ρ of elements in radial balance, (n_rollers,), m, its stiffness.

    Parameters: as of `static_equilibrium`; hub : (2,), m
    """
    place = np.asarray(ring, dtype=float)
    here = _System(bearing, operation, laws, angles, bearing.roller_mass, turns, place).at(hub, _load(operation))
    return here.unbalance, here.rho, here.stiffness


def _load(operation: Operation) -> np.ndarray:
    """Load and weight on the hub, (2,), N."""
    return np.array([operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)])


@dataclass(frozen=True, kw_only=True)
class _Point:
    """The system at one hub position, elements in radial balance."""

    rho: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    unbalance: np.ndarray  # (2,), gradient of the potential, N
    stiffness: np.ndarray  # (2, 2), N/m
    potential: float  # J


class _System:
    """Potential of the hub's position."""

    def __init__(self, bearing, operation, laws, theta, mass, turns, ring):
        self.inner_law, self.outer_law = laws
        self.theta, self.turns, self.surfaces = theta, turns, profiles(bearing)
        self.cos, self.sin = np.cos(theta), np.sin(theta)
        self.reach, self.track = touching_distances(bearing)
        if self.surfaces is not None:
            outer = self.surfaces.outer(theta, turns)
            self.track, self.outer_law = self.track + outer.sinkage, softened(laws.outer, outer.compliance)
        cage = kinematics(bearing, *operation.ring_speeds).cage
        self.spin = mass * cage**2
        self.weight = mass * operation.gravity * self.sin
        self.bearing, self.ring = bearing, ring
        shaft = operation.mounting.shaft
        self.shaft_stiffness = 0.0 if shaft is None else shaft.stiffness
        depth = 1e-4 * bearing.roller_radius
        self.typical_stiffness = float(laws.inner.slope(depth))

    def at(self, hub, load) -> _Point:
        """Balance the elements, then sum up their forces, the shaft's and the load, (2,), N, on the hub."""
        s = hub[0] * self.cos + hub[1] * self.sin  # hub's offset along and across each element's radius
        t = hub[1] * self.cos - hub[0] * self.sin
        rho = self._balance(s, t)
        chi, c, d, depth_in, depth_out, law_in = self._overlaps(rho, s, t)
        inner, slope_in = pressed(law_in, depth_in)
        outer, slope_out = pressed(self.outer_law, depth_out)
        radial, across = -inner * c, inner * d  # on the hub, along s and t
        unbalance = -np.array(
            [
                np.sum(radial * self.cos - across * self.sin) + load[0],
                np.sum(radial * self.sin + across * self.cos) + load[1],
            ]
        )
        place, springs = hub + self.ring, self.shaft_stiffness
        unbalance += springs * place
        # Hessian of the inner contact's energy in (along, t), then ρ eliminated
        aa = slope_in * c * c - inner / chi * d * d
        at = slope_in * c * d + inner / chi * c * d
        tt = slope_in * d * d - inner / chi * c * c
        own = aa + slope_out - self.spin
        own = np.where(own > 0.0, own, np.inf)
        ss, st, tt = aa - aa * aa / own, -(at - aa * at / own), tt - at * at / own
        cos, sin = self.cos, self.sin
        xx = np.sum(ss * cos * cos - 2.0 * st * cos * sin + tt * sin * sin)
        yy = np.sum(ss * sin * sin + 2.0 * st * cos * sin + tt * cos * cos)
        xy = np.sum((ss - tt) * cos * sin + st * (cos * cos - sin * sin))
        potential = np.sum(
            law_in.potential(depth_in) + self.outer_law.potential(depth_out)
            + self.weight * depth_out - 0.5 * self.spin * (rho * rho - self.track**2)
        )  # fmt: skip
        potential += 0.5 * springs * (place @ place)
        return _Point(
            rho=rho, inner_force=inner, outer_force=outer, unbalance=unbalance,
            stiffness=np.array([[xx + springs, xy], [xy, yy + springs]]),
            potential=float(potential) - load[1] * hub[1] - load[0] * hub[0],
        )  # fmt: skip

    def _overlaps(self, rho, s, t):
        """χ, the cosine and sine of its direction against the radius, both overlaps, m, and the inner contacts' law.

        Those are the derivatives of χ by ρ and by t; on surfaces that are not perfect, of χ and the sinkage.
        """
        along = rho - s
        chi = np.hypot(along, t)
        c, d = along / chi, t / chi
        if self.surfaces is None:
            return chi, c, d, self.reach - chi, rho - self.track, self.inner_law
        inner = self.surfaces.inner(self.theta - np.arctan2(t, along), self.turns)
        law, depth = softened(self.inner_law, inner.compliance), self.reach - chi - inner.sinkage
        aside = inner.at_force(law.force(depth)).slope / chi
        return chi, c + aside * d, d - aside * c, depth, rho - self.track, law

    def _radial(self, rho, s, t):
        """Force on the elements along +ρ, N, and minus its derivative."""
        _, c, _, depth_in, depth_out, law_in = self._overlaps(rho, s, t)
        inner, slope_in = pressed(law_in, depth_in)
        outer, slope_out = pressed(self.outer_law, depth_out)
        force = inner * c - outer + self.spin * rho - self.weight
        return force, slope_in * c**2 + slope_out - self.spin

    def _balance(self, s, t):
        """ρ of every element in radial balance: Newton's method kept inside a bracket."""
        touch_in = s + np.sqrt(np.maximum(self.reach**2 - t * t, 0.0))  # ρ that touches the inner raceway
        if self.surfaces is not None:
            touch_in -= self.surfaces.inner(self.theta - np.arctan2(t, touch_in - s), self.turns).sinkage
        push = np.abs(self.weight) + 2.0 * self.spin * self.track
        room = np.maximum(self.inner_law.approach(push), self.outer_law.approach(push)) * 1.5
        low = np.minimum(touch_in, self.track) - room
        high = np.maximum(touch_in, self.track) + room
        rho, finest = 0.5 * (touch_in + self.track), ROUND_OFF * self.track
        for _ in range(MAX_RADIAL):
            force, stiffness = self._radial(rho, s, t)
            low, high = np.where(force > 0.0, rho, low), np.where(force < 0.0, rho, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = rho + force / stiffness
            # an end of the bracket may be the root but for round-off
            inside = (newton > low - finest) & (newton < high + finest) & (stiffness > 0.0)
            step = np.where(force == 0.0, rho, np.where(inside, newton, 0.5 * (low + high)))
            if np.all(np.abs(step - rho) <= finest):
                return step
            rho = step
        return rho


def _sink(system: _System, load: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Hub position along the load's direction where the elements first hold it, m: by bisection."""
    radius = system.bearing.roller_radius
    far, near, way = max(system.bearing.radial_clearance, 0.0) + 1e-6 * radius, 0.0, 1e-5 * radius

    def holds(distance: float) -> bool:
        return float(system.at(distance * along, load).unbalance @ along) > 0.0

    for _ in range(20):
        if holds(far):
            break
        near, far, way = far, far + way, 2.0 * way
    for _ in range(60):
        middle = 0.5 * (near + far)
        if holds(middle):
            far = middle
        else:
            near = middle
        if far - near < 1e-5 * radius:
            break
    return far * along


def _newton_step(here: _Point, typical: float) -> np.ndarray:
    """Newton's step; directions without or with negative stiffness go downhill instead."""
    values, vectors = np.linalg.eigh(here.stiffness)
    values = np.maximum(np.abs(values), SOFTEST * typical)
    return -vectors @ ((vectors.T @ here.unbalance) / values)


def _descend(system: _System, hub, here: _Point, step, load: np.ndarray):
    """Go along a step as far as it lowers the potential, or the unbalance once round-off hides that."""
    size = np.linalg.norm(step)
    longest = 1e-2 * system.bearing.roller_radius
    step = step * min(1.0, longest / size) if size > 0.0 else step
    expected = float(here.unbalance @ step)  # < 0
    forces = np.hypot(*load) + np.sum(here.inner_force + here.outer_force)
    forces += system.shaft_stiffness * np.hypot(*(hub + system.ring))
    noise = 10.0 * ROUND_OFF * (abs(here.potential) + forces * np.max(system.track))
    for _ in range(60):
        there = system.at(hub + step, load)
        lower = there.potential <= here.potential + 1e-4 * expected
        finer = there.potential <= here.potential + noise and (
            np.linalg.norm(there.unbalance) < np.linalg.norm(here.unbalance)
        )
        if lower or finer:
            return hub + step, there
        step, expected = 0.5 * step, 0.5 * expected
    return hub, here


MOST_STEPS, MOST_HALVINGS, MOST_TURNS = 150, 30, 60
ROUND_OFF_ENERGY, LEAST_SCALED, LONGEST = (
    1e-15,
    1e-9,
    2e-3,
)  # of energies; of scaled stiffnesses; of a roller's radius
BALANCED = 1e-10  # of the largest force, and of that over the rollers' length; or, where contacts of edges that
NEARLY = 1e-4  # hardly touch keep steps from it, so much, which hardly moves anything
FAINTEST = 1e-4  # N, on rollers that only LOOSE holds: there the tables have kinks
LEAST_FORCE = 1e-7  # N
FITTING = 1e-13  # m, of approaches
CONTRACTING = 0.5  # of what contacts took too little a turn ago
LOOSE = 1.0  # N/m, and N m/rad a metre squared, keeps the hub in the middle, and rollers between raceways, that no
# force holds


class Elastic(NamedTuple):
    """Compliance of the bodies between contacts, inner ones first, and further contributions to the approach."""

    compliance: np.ndarray  # (2 n_rollers, 2 n_rollers), m/N, of forces
    tilt_compliance: np.ndarray  # the same, rad per N m, of moments
    closing: np.ndarray  # (2 n_rollers,), m


@dataclass(frozen=True)
class Placement:
    """Where rollers and the outer ring stand."""

    theta: np.ndarray  # (n_rollers,), rad
    ring: np.ndarray | tuple[float, float] = (0.0, 0.0)  # the outer ring's centre, m, from which all places are
    turns: Turns = UNTURNED  # of ring and rollers, which matter where their surfaces are not perfect


@dataclass(frozen=True, kw_only=True)
class TiltedStatics:
    """An equilibrium; SI, arrays (n_rollers,)."""

    place: np.ndarray  # (4,), of the hub: x, y, m, and its slope along x and y, rad
    rho: np.ndarray
    tilt: np.ndarray
    theta: np.ndarray
    inner_force: np.ndarray
    outer_force: np.ndarray
    inner_moment: np.ndarray  # N m
    outer_moment: np.ndarray
    own: np.ndarray  # (2, 2 n_rollers), approach, m, and misalignment, rad, of each contact's law
    stiffness: np.ndarray  # (4, 4), by the hub's place and slope as rollers follow: N/m, N/rad, N m/rad
    on_hub: np.ndarray  # (2,), N m, moment of the contacts on the hub's slope
    is_free: bool  # whether that slope moves

    @property
    def hub(self) -> np.ndarray:
        return self.place[:2]

    def of_side(self, row: int) -> np.ndarray:
        """Approaches, m, and misalignments, rad, of the inner (0) or outer (1) contacts' laws, (2, n_rollers)."""
        return self.own.reshape(2, 2, -1)[:, row]

    @property
    def radial_stiffness(self) -> np.ndarray:
        """Of the hub's place as all else follows, a free slope too, (2, 2), N/m."""
        whole = self.stiffness
        if not self.is_free:
            return whole[:2, :2]
        return whole[:2, :2] - whole[:2, 2:] @ np.linalg.solve(whole[2:, 2:], whole[2:, :2])

    @property
    def moved(self) -> np.ndarray:
        """All places, (4 + 2 n_rollers,): of the hub, radii, tilts."""
        return np.concatenate([self.place, self.rho, self.tilt])


class _TiltPoint(NamedTuple):
    """The system at one state of its unknowns."""

    energy: float  # J
    parts: np.ndarray  # (2 n,), J, of contacts
    forces: np.ndarray  # (4 n,), Q of all contacts, then −M
    stiff: np.ndarray  # (4 n, 4 n), their derivatives by own approaches and misalignments
    own: np.ndarray  # (4 n,), these
    ways: np.ndarray  # (4 n, 4 + 2 n), derivatives of approaches and misalignments by the bodies' places
    left: np.ndarray  # (4 + 2 n,), unbalanced forces and moments, 0 of a slope that is held
    turning: np.ndarray  # (4 + 2 n, 4 + 2 n), stiffness by contacts' normals that turn
    surfaces: tuple[SurfaceDeviation, SurfaceDeviation] | None  # what contacts meet, where surfaces are not perfect


def tilted_equilibrium(
    bearing: Bearing,
    operation: Operation,
    laws: TiltedLaws,
    hub: HubTilt,
    placement: Placement,
    start: tuple[np.ndarray, np.ndarray],
    elastic: Elastic | None = None,
) -> TiltedStatics:
    """Equilibrium under load, weights and centrifugal forces at cage speed.

    Parameters
    ----------
    laws : of the inner and the outer contact
    start : hub's place, (2,), and rollers' radii, (n_rollers,), m, to begin from
    elastic : None: bodies are rigid but for their contacts

    Errors
    ------
    RuntimeError: no equilibrium found.
    """
    system, theta = _Tilted(bearing, operation, laws, hub, placement, elastic), placement.theta
    slope = np.array([hub.slope_x, hub.slope_y])
    radial = np.array([np.cos(theta), np.sin(theta)])
    moved = np.concatenate([start[0], slope, start[1], 0.5 * (slope @ radial)])
    bare = nothing_carries(
        bearing, theta, (operation.side_load, -operation.radial_load - operation.inner_mass * operation.gravity)
    )
    taken, steps, before = np.zeros(4 * bearing.n_rollers), 0, np.inf
    for _ in range(MOST_TURNS):
        here = system.at(moved, taken)
        while system.size_of(here) > 1.0:
            steps += 1
            if steps > MOST_STEPS and system.size_of(here, NEARLY) <= 1.0:
                break
            if steps > MOST_STEPS:
                raise RuntimeError(
                    bare
                    or f"no static equilibrium with tilt after {MOST_STEPS} steps: {np.abs(here.left[:2]).max():.3g} N "
                    "unbalanced at the hub; check load, operation.misalignment_mrad and profiles"
                )
            moved, here = _descended(system, moved, taken, here)
        more = system.compliance @ here.forces - taken
        left = np.abs(more * system.arms).max()
        if left <= FITTING:
            return system.found(moved, here)
        # rings that bend more than their contacts need Newton's method, since their forces would swing
        taken, before = taken + (more if left < CONTRACTING * before else system.settled(here, more)), left
    raise RuntimeError(bare or "no static equilibrium with tilt: contacts push one another in")


def _descended(system: "_Tilted", moved, taken, here: _TiltPoint) -> tuple[np.ndarray, _TiltPoint]:
    """Newton's step, as much of it as makes the energy less, or what is left where round-off hides that."""
    idle = system.rested(moved, here)
    if idle is not moved:
        moved, here = idle, system.at(idle, taken)
    step = system.newton(here)
    expected = -float(here.left @ step)  # < 0
    noise = ROUND_OFF_ENERGY * (np.abs(here.parts).sum() + abs(here.energy))
    for _ in range(MOST_HALVINGS):
        point = system.at(moved + step, taken)
        lower = point.energy <= here.energy + 1e-4 * expected
        if lower or (point.energy <= here.energy + noise and system.size_of(point) < system.size_of(here)):
            break
        step, expected = 0.5 * step, 0.5 * expected
    return moved + step, point


class _Tilted:
    """Balance of hub, rollers and contacts."""

    def __init__(self, bearing, operation, laws, hub, placement, elastic):
        n = self.n = bearing.n_rollers
        self.bearing, self.laws, self.hub, self.surfaces = bearing, laws, hub, profiles(bearing)
        self.theta, self.turns = placement.theta, placement.turns
        self.cos, self.sin = np.cos(self.theta), np.sin(self.theta)
        nothing = np.zeros((2 * n, 2 * n))
        elastic = elastic or Elastic(nothing, nothing, np.zeros(2 * n))
        self.compliance = np.block([[elastic.compliance, nothing], [nothing, elastic.tilt_compliance]])
        self.closing = np.concatenate([elastic.closing, np.zeros(2 * n)])
        cage, m = kinematics(bearing, *operation.ring_speeds).cage, bearing.roller_mass
        self.spin, self.length = m * cage**2, bearing.roller_length
        self.is_pressed = cage != 0.0 or operation.gravity != 0.0  # rollers, against a raceway
        self.applied = np.concatenate([
            [operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)], np.zeros(2),
            -m * operation.gravity * self.sin, np.zeros(n),
        ])  # fmt: skip
        slope, shaft = np.array([hub.slope_x, hub.slope_y]), operation.mounting.shaft
        slack = np.concatenate(
            [np.zeros(2), slope, np.full(n, bearing.pitch_radius), 0.5 * (slope[0] * self.cos + slope[1] * self.sin)]
        )
        self.springs = np.zeros(4 + 2 * n)
        self.springs[:2] = LOOSE
        self.springs[2:4] = max(hub.stiffness, LOOSE * self.length**2) if hub.is_free else np.inf
        if shaft is not None:
            self.springs[:2], slack[:2] = shaft.stiffness, -np.asarray(placement.ring)
        self.slack, self.moves = slack, np.isfinite(self.springs)
        self.arms = np.repeat([1.0, self.length], 2 * n)
        # of half by how much inner contacts are closer than outer ones: a roller that bears nothing rests in its gap's
        # middle, wherever the hub goes, and touches no raceway
        half = 0.25 * LOOSE * np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.eye(n))
        self.between = np.kron(np.diag([1.0, self.length**2]), half)
        self.precession = precession_stiffness(bearing, operation.ring_speeds)

    def geometry(
        self, moved
    ) -> tuple[np.ndarray, np.ndarray, PolarOverlaps, tuple[SurfaceDeviation, SurfaceDeviation] | None]:
        """Approaches and misalignments, (4 n,), their derivatives on circles, (4 n, 4 + 2 n), the overlaps, and what
        contacts meet of surfaces that are not perfect; None: they are."""
        n, (x, y, bx, by), cos, sin = self.n, moved[:4], self.cos, self.sin
        rho, tilt = moved[4 : 4 + n], moved[4 + n :]
        found = polar_overlaps(self.bearing, rho, x * cos + y * sin, y * cos - x * sin)
        at = misalignments(found, Tilts(tilt=tilt, tilt_rate=tilt, slope_x=bx, slope_y=by), cos, sin)
        deviations = None
        if self.surfaces is not None:
            found, inner, outer = polar_deviated(self.surfaces, found, self.turns, self.theta)
            deviations = inner, outer
        nx, ny = found.radial * cos - found.tangential * sin, found.radial * sin + found.tangential * cos
        across, j = at.across / found.distance, np.arange(n)
        ways = np.zeros((4 * n, 4 + 2 * n))
        ways[j, 0], ways[j, 1], ways[j, 4 + j] = nx, ny, -found.radial
        ways[n + j, 4 + j] = 1.0
        psi = 2 * n + j
        ways[psi, 0], ways[psi, 1], ways[psi, 4 + j] = across * ny, -across * nx, -across * found.tangential
        ways[psi, 2], ways[psi, 3], ways[psi, 4 + n + j] = -nx, -ny, found.radial
        ways[3 * n + j, 4 + n + j] = -1.0
        return np.concatenate([found.inner, found.outer, at.inner, at.outer]) + self.closing, ways, found, deviations

    def _aside(self, ways, found: PolarOverlaps, slope) -> None:
        """Turn the ways of the inner contacts by the slopes of their surfaces, m/rad."""
        j, aside = np.arange(self.n), slope / found.distance
        nx, ny = ways[j, 0].copy(), ways[j, 1].copy()
        ways[j, 0] -= aside * ny
        ways[j, 1] += aside * nx
        ways[j, 4 + j] += aside * found.tangential

    def at(self, moved, taken) -> _TiltPoint:
        """Forces and energy where other contacts take so much of approaches and misalignments, (4 n,)."""
        n, j = self.n, np.arange(self.n)
        geometric, ways, found, deviations = self.geometry(moved)
        surfaces, fallen = deviations or (None, None), []
        own, parts, forces, stiff = geometric - taken, np.zeros(2 * n), np.zeros(4 * n), np.zeros((4 * n, 4 * n))
        for row, law in enumerate(self.laws):
            d, p = row * n + j, (2 + row) * n + j
            most = law.last_approach  # of a table, beyond which a step may try
            here, more = met(law, np.minimum(own[d], most), own[p], surfaces[row]), np.maximum(own[d] - most, 0.0)
            forces[d], forces[p] = here.force + here.stiffness * more, -here.moment + here.cross * more
            parts[d] = here.energy + (here.force + 0.5 * here.stiffness * more) * more
            stiff[d, d], stiff[d, p], stiff[p, d] = here.stiffness, here.cross, here.cross
            stiff[p, p] = here.tilt_stiffness
            fallen.append(falls(here, surfaces[row]))
        if deviations is not None:
            self._aside(ways, found, deviations[0].at_contact(fallen[0]).slope)
        off = moved - self.slack
        pull = np.where(self.moves, self.springs, 0.0) * off
        rest = self.between @ own
        left = self.applied - pull - ways.T @ (forces + rest)
        left[4 : 4 + n] += self.spin * moved[4 : 4 + n]
        left[4 + n :] -= self.precession * moved[4 + n :]
        energy = float(parts.sum() + 0.5 * (pull @ off + rest @ own) - self.applied @ off)
        energy -= 0.5 * self.spin * float(np.sum(off[4 : 4 + n] * (moved[4 : 4 + n] + self.slack[4 : 4 + n])))
        energy += 0.5 * self.precession * float(np.sum(moved[4 + n :] ** 2))
        across = np.zeros((n, 4 + 2 * n))  # ways along the inner contacts' tangents
        nx, ny = ways[j, 0], ways[j, 1]
        across[:, 0], across[:, 1], across[j, 4 + j] = ny, -nx, -found.tangential
        turning = -(across.T * (forces[:n] / found.distance)) @ across
        return _TiltPoint(energy, parts, forces, stiff, own, ways, np.where(self.moves, left, 0.0), turning, deviations)

    def rested(self, moved: np.ndarray, here: _TiltPoint) -> np.ndarray:
        """Places with rollers that nothing presses in the middle of their gaps, where those touch no raceway there."""
        own, surfaces = here.own.reshape(2, 2, -1), here.surfaces or (None, None)
        apart, middle = 0.5 * (own[:, 0] - own[:, 1]), own.mean(axis=1)
        bear = [met(law, middle[0], middle[1], surfaces[row]).force > 0.0 for row, law in enumerate(self.laws)]
        idle = ~(bear[0] | bear[1] | self.is_pressed) & (np.abs(apart).max(axis=0) > FITTING)
        return moved + np.concatenate([np.zeros(4), *(idle * apart * [[1.0], [-1.0]])]) if idle.any() else moved

    def size_of(self, here: _TiltPoint, share: float = BALANCED) -> float:
        """Of what is left, over what may be: at most 1 in equilibrium."""
        n, left = self.n, np.abs(here.left)
        largest = max(float(np.abs(self.applied).max()), float(np.abs(here.forces[: 2 * n]).max()))
        left[2:4], left[4 + n :] = left[2:4] / self.length, left[4 + n :] / self.length
        enough = share * largest
        return max(left[:4].max() / (enough + LEAST_FORCE), left[4:].max() / (enough + FAINTEST))

    def _stiffness(self, here: _TiltPoint, contacts: np.ndarray) -> np.ndarray:
        n = self.n
        own = np.where(self.moves, self.springs, 0.0)
        own[4 : 4 + n] -= self.spin
        own[4 + n :] += self.precession
        return here.ways.T @ (contacts + self.between) @ here.ways + here.turning + np.diag(own)

    def newton(self, here: _TiltPoint) -> np.ndarray:
        """Newton's step of the bodies; along directions with negative stiffness downhill."""
        moves, step = self.moves, np.zeros(self.moves.size)
        whole = self._stiffness(here, here.stiff)[np.ix_(moves, moves)]
        scale = np.sqrt(np.abs(np.diag(whole)))
        values, vectors = np.linalg.eigh(whole / np.outer(scale, scale))
        values = np.maximum(np.abs(values), LEAST_SCALED)
        step[moves] = (vectors @ ((vectors.T @ (here.left[moves] / scale)) / values)) / scale
        longest = LONGEST * self.bearing.roller_radius
        furthest = max(
            np.abs(step[:2]).max(), np.abs(step[4 : 4 + self.n]).max(), self.length * np.abs(step[4 + self.n :]).max()
        )
        return step * min(1.0, longest / max(float(furthest), 1e-30))

    def settled(self, here: _TiltPoint, more: np.ndarray) -> np.ndarray:
        """Change of `taken` that Newton's method finds, (4 n,); `more` : its error under the forces at hand."""
        moves, stiff = self.moves, here.stiff
        ways = here.ways[:, moves]
        follow = np.linalg.solve(self._stiffness(here, stiff)[np.ix_(moves, moves)], ways.T @ (stiff + self.between))
        return np.linalg.solve(np.eye(4 * self.n) + self.compliance @ (stiff - stiff @ ways @ follow), more)

    def found(self, moved, here: _TiltPoint) -> TiltedStatics:
        n, forces = self.n, here.forces
        effective = np.linalg.solve((np.eye(4 * n) + self.compliance @ here.stiff).T, here.stiff.T).T
        whole = self._stiffness(here, effective)
        stiffness = whole[:4, :4] - whole[:4, 4:] @ np.linalg.solve(whole[4:, 4:], whole[4:, :4])
        return TiltedStatics(
            place=moved[:4], rho=moved[4 : 4 + n], tilt=moved[4 + n :], theta=self.theta,
            inner_force=forces[:n], outer_force=forces[n : 2 * n], inner_moment=-forces[2 * n : 3 * n],
            outer_moment=-forces[3 * n :], own=here.own.reshape(2, 2 * n), stiffness=stiffness,
            on_hub=-(here.ways.T @ forces)[2:4], is_free=self.hub.is_free,
        )  # fmt: skip
