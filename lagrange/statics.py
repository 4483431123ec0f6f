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
from lagrange.equations import Overlaps, contact_resultant, nothing_carries, overlaps, touching_distances
from lagrange.kinematics import kinematics, roller_angles
from lagrange.surface.deviation import UNTURNED, Turns, profiles
from lagrange.surface.edges import pressed, softened
from lagrange.tilt import HubTilt, TiltedLaws, Tilts, falls, met, misalignments, precession_stiffness

BALANCE = 1e-10  # of load and contact forces: what Newton's method must reach
MAX_NEWTON, MAX_RADIAL, MOST_HALVINGS = 200, 100, 30
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
    system = _Plane(bearing, operation, laws, theta, mass, turns, ring)
    weight, radius = float(np.hypot(*system.load)), bearing.roller_radius
    hub = np.zeros(2) if start is None else np.array(start, dtype=float)
    if start is None and weight > 0.0:  # near enough, and faster
        hub = _Plane(replace(bearing, faults=()), operation, laws, theta, mass, turns, ring).sunk()
    here = system.at(hub)
    finest = ROUND_OFF * system.track * system.typical * bearing.n_rollers
    for _ in range(MAX_NEWTON):
        if np.max(np.abs(here.left)) <= BALANCE * (weight + np.sum(here.inner)) + finest:
            return Statics(
                x=float(hub[0]), y=float(hub[1]), rho=here.rho, theta=theta,
                inner_force=here.inner, outer_force=here.outer, stiffness=here.stiffness,
            )  # fmt: skip
        # directions without or with negative stiffness go downhill
        values, vectors = np.linalg.eigh(here.stiffness)
        step = vectors @ ((vectors.T @ here.left) / np.maximum(np.abs(values), SOFTEST * system.typical))
        step = step * min(1.0, 1e-2 * radius / max(float(np.linalg.norm(step)), 1e-30))
        forces = weight + np.sum(here.inner + here.outer) + system.springs * np.hypot(*(hub + system.ring))
        hub, here = _descended(
            system.at, hub, here, step, 10.0 * ROUND_OFF * (abs(here.energy) + forces * system.track)
        )
    raise RuntimeError(
        nothing_carries(bearing, theta, system.load)
        or f"no static equilibrium after {MAX_NEWTON} steps: {np.max(np.abs(here.left)):.3g} N unbalanced at hub "
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
    here = _Plane(bearing, operation, laws, angles, bearing.roller_mass, turns, ring).at(hub)
    return -here.left, here.rho, here.stiffness


def _load(operation: Operation) -> np.ndarray:
    """Load and weight on the hub, (2,), N."""
    return np.array([operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)])


def _descended(at, place, here, step, noise: float):
    """Place and point as far along a step as makes the energy less, or what is left where round-off hides that."""
    expected = -float(here.left @ step)  # < 0
    for _ in range(MOST_HALVINGS):
        there = at(place + step)
        lower = there.energy <= here.energy + 1e-4 * expected
        if lower or (there.energy <= here.energy + noise and there.size < here.size):
            break
        step, expected = 0.5 * step, 0.5 * expected
    return place + step, there


class _Point(NamedTuple):
    """The plane system at one hub position, elements in radial balance."""

    energy: float  # J
    size: float  # N, of what is left
    left: np.ndarray  # (2,), N, unbalanced force: minus the potential's gradient
    stiffness: np.ndarray  # (2, 2), N/m
    rho: np.ndarray
    inner: np.ndarray  # N
    outer: np.ndarray


class _Plane:
    """Potential of the hub's position."""

    def __init__(self, bearing, operation, laws, theta, mass, turns, ring):
        self.bearing, self.laws, self.theta, self.turns = bearing, laws, theta, turns
        self.ring, self.load, self.surfaces = np.asarray(ring, dtype=float), _load(operation), profiles(bearing)
        self.reach, self.track = touching_distances(bearing)
        self.spin = mass * kinematics(bearing, *operation.ring_speeds).cage ** 2
        self.weight = mass * operation.gravity * np.sin(theta)
        shaft = operation.mounting.shaft
        self.springs = 0.0 if shaft is None else shaft.stiffness
        self.typical = float(laws.inner.slope(1e-4 * bearing.roller_radius))  # stiffness, N/m
        sinkage, compliance = 0.0, 0.0
        if self.surfaces is not None:
            met = self.surfaces.outer(theta, turns)
            sinkage, compliance = met.sinkage, met.compliance
        self.sinkage, self.outer_law = sinkage, softened(laws.outer, compliance)

    def _contacts(self, hub, rho):
        """Inner overlaps, law, forces and stiffnesses of inner and of outer contacts, and the outer overlaps."""
        found = overlaps(self.bearing, hub[0], hub[1], rho, self.theta)
        law = self.laws.inner
        if self.surfaces is not None:
            met = self.surfaces.inner(self.theta + np.arctan2(found.circle[1], found.circle[0]), self.turns)
            law, depth = softened(law, met.compliance), found.inner - met.sinkage
            aside = met.at_force(law.force(depth)).slope / found.distance
            found = replace(found, inner=depth, outer=found.outer - self.sinkage, aside=aside)
        return found, law, *pressed(law, found.inner), *pressed(self.outer_law, found.outer)

    def at(self, hub) -> _Point:
        """Balance the elements, then sum up their forces, the shaft's and the load on the hub."""
        rho = self._balanced(hub)
        found, law, inner, stiff, outer, stiff_out = self._contacts(hub, rho)
        place = hub + self.ring
        left = np.array(contact_resultant(found, inner)) + self.load - self.springs * place
        # Hessian of the contacts' energies by hub and ρ: k g gᵀ − Q t tᵀ/χ, t along the tangent; then ρ eliminated
        x, y = found.direction_x, found.direction_y
        g, t = np.array([x, y, found.radial]), np.array([-y, x, y * found.cos - x * found.sin])
        hessian = stiff * g[:, None] * g - inner / found.distance * t[:, None] * t
        own = hessian[2, 2] + stiff_out - self.spin
        own = np.where(own > 0.0, own, np.inf)
        stiffness = np.sum(hessian[:2, :2] - hessian[:2, 2:] * hessian[2:, :2] / own, axis=-1)
        energy = law.potential(found.inner) + self.outer_law.potential(found.outer)
        energy += self.weight * found.outer - 0.5 * self.spin * (rho * rho - self.track**2)
        energy = float(np.sum(energy) + 0.5 * self.springs * (place @ place) - self.load @ hub)
        return _Point(
            energy, float(np.linalg.norm(left)), left, stiffness + self.springs * np.eye(2), rho, inner, outer
        )

    def _balanced(self, hub):
        """ρ of every element in radial balance: Newton's method kept inside a bracket."""
        cos, sin = np.cos(self.theta), np.sin(self.theta)
        along, across = hub[0] * cos + hub[1] * sin, hub[1] * cos - hub[0] * sin
        way = np.sqrt(np.maximum(self.reach**2 - across**2, 0.0))
        touch, track = along + way, self.track + self.sinkage  # ρ that touches the raceways
        if self.surfaces is not None:
            touch = touch - self.surfaces.inner(self.theta - np.arctan2(across, way), self.turns).sinkage
        push = np.abs(self.weight) + 2.0 * self.spin * track
        room = np.maximum(self.laws.inner.approach(push), self.outer_law.approach(push)) * 1.5
        low, high = np.minimum(touch, track) - room, np.maximum(touch, track) + room
        rho, finest = 0.5 * (touch + track), ROUND_OFF * track
        for _ in range(MAX_RADIAL):
            found, _, inner, stiff, outer, stiff_out = self._contacts(hub, rho)
            force = inner * found.radial - outer + self.spin * rho - self.weight
            stiffness = stiff * found.radial**2 + stiff_out - self.spin
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

    def sunk(self) -> np.ndarray:
        """Hub position along the load's direction where the elements first hold it, m: by bisection."""
        radius, along = self.bearing.roller_radius, self.load / np.hypot(*self.load)
        far, near, way = max(self.bearing.radial_clearance, 0.0) + 1e-6 * radius, 0.0, 1e-5 * radius

        def holds(distance: float) -> bool:
            return float(self.at(distance * along).left @ along) < 0.0

        for _ in range(20):
            if holds(far):
                break
            near, far, way = far, far + way, 2.0 * way
        while far - near >= 1e-5 * radius:
            middle = 0.5 * (near + far)
            near, far = (near, middle) if holds(middle) else (middle, far)
        return far * along


MOST_STEPS, MOST_TURNS = 150, 60
ROUND_OFF_ENERGY = 1e-15
LEAST_SCALED = 1e-9  # of scaled stiffnesses
LONGEST = 2e-3  # of a roller's radius
BALANCED = 1e-10  # of the largest force, and of that over the rollers' length; or, where contacts of edges that
NEARLY = 1e-4  # hardly touch keep steps from it, so much, which hardly moves anything
FAINTEST = 1e-4  # N, on rollers that only LOOSE holds: there the tables have kinks
LEAST_FORCE = 1e-7  # N
FITTING = 1e-13  # m, of approaches
CONTRACTING = 0.5  # of what contacts took too little a turn ago
# N/m, and N m/rad a metre squared, keeps the hub in the middle, and rollers between raceways, that no force holds
LOOSE = 1.0


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
    size: float  # of what is left, over what may be: at most 1 in equilibrium
    left: np.ndarray  # (4 + 2 n,), unbalanced forces and moments, 0 of a slope that is held
    nearly: bool  # whether it is little enough where it gets no less
    noise: float  # J, round-off of the energy
    forces: np.ndarray  # (4 n,), Q of all contacts, then −M
    stiff: np.ndarray  # (4 n, 4 n), their derivatives by own approaches and misalignments
    own: np.ndarray  # (4 n,), these
    ways: np.ndarray  # (4 n, 4 + 2 n), derivatives of approaches and misalignments by the bodies' places
    turning: np.ndarray  # (4 + 2 n, 4 + 2 n), stiffness by contacts' normals that turn
    found: Overlaps


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
    system, theta, slope = _Tilted(bearing, operation, laws, hub, placement, elastic), placement.theta, hub.slope
    moved = np.concatenate([start[0], slope, start[1], 0.5 * (slope @ np.array([np.cos(theta), np.sin(theta)]))])
    bare = nothing_carries(bearing, theta, _load(operation))
    steps, before = 0, np.inf
    for _ in range(MOST_TURNS):
        here = system.at(moved)
        while here.size > 1.0:
            steps += 1
            if steps > MOST_STEPS and here.nearly:
                break
            if steps > MOST_STEPS:
                raise RuntimeError(
                    bare
                    or f"no static equilibrium with tilt after {MOST_STEPS} steps: {np.abs(here.left[:2]).max():.3g} N "
                    "unbalanced at the hub; check load, operation.misalignment_mrad and profiles"
                )
            if (idle := system.rested(moved, here)) is not moved:
                moved, here = idle, system.at(idle)
            moved, here = _descended(system.at, moved, here, system.newton(here), here.noise)
        more = system.compliance @ here.forces - system.taken
        left = np.abs(more * system.arms).max()
        if left <= FITTING:
            return system.found(moved, here)
        # rings that bend more than their contacts need Newton's method, since their forces would swing
        system.taken += more if left < CONTRACTING * before else system.settled(here, more)
        before = left
    raise RuntimeError(bare or "no static equilibrium with tilt: contacts push one another in")


class _Tilted:
    """Balance of hub, rollers and contacts."""

    def __init__(self, bearing, operation, laws, hub, placement, elastic):
        n, m = bearing.n_rollers, bearing.roller_mass
        self.n, self.length, self.j = n, bearing.roller_length, np.arange(n)
        self.rho, self.tilt = slice(4, 4 + n), slice(4 + n, None)  # among places
        self.bearing, self.laws, self.hub, self.placement = bearing, laws, hub, placement
        cos, sin, nothing = np.cos(placement.theta), np.sin(placement.theta), np.zeros((2 * n, 2 * n))
        elastic = elastic or Elastic(nothing, nothing, np.zeros(2 * n))
        self.compliance = np.block([[elastic.compliance, nothing], [nothing, elastic.tilt_compliance]])
        self.closing = np.concatenate([elastic.closing, np.zeros(2 * n)])
        self.taken = np.zeros(4 * n)  # of approaches and misalignments, by other contacts
        cage = kinematics(bearing, *operation.ring_speeds).cage
        self.is_pressed = cage != 0.0 or operation.gravity != 0.0  # rollers, against a raceway
        self.applied = np.concatenate([_load(operation), np.zeros(2), -m * operation.gravity * sin, np.zeros(n)])
        self.slack = np.concatenate(
            [np.zeros(2), hub.slope, np.full(n, bearing.pitch_radius), 0.5 * (hub.slope_x * cos + hub.slope_y * sin)]
        )
        self.springs, shaft = np.zeros(4 + 2 * n), operation.mounting.shaft
        self.springs[:2] = LOOSE
        self.springs[2:4] = max(hub.stiffness, LOOSE * self.length**2) if hub.is_free else 0.0
        if shaft is not None:
            self.springs[:2], self.slack[:2] = shaft.stiffness, -np.asarray(placement.ring)
        self.moves = np.full(4 + 2 * n, True)
        self.moves[2:4] = hub.is_free
        self.arms = np.repeat([1.0, self.length], 2 * n)
        # of half by how much inner contacts are closer than outer ones: a roller that bears nothing rests in its gap's
        # middle, wherever the hub goes, and touches no raceway
        half = 0.25 * LOOSE * np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.eye(n))
        self.between = np.kron(np.diag([1.0, self.length**2]), half)
        self.inertial = np.zeros(4 + 2 * n)  # stiffness against radii, by the centrifugal force, and tilts
        self.inertial[self.rho] = -m * cage**2
        self.inertial[self.tilt] = precession_stiffness(bearing, operation.ring_speeds)

    def at(self, moved) -> _TiltPoint:
        n, j, rho, tilt = self.n, self.j, moved[self.rho], moved[self.tilt]
        found = overlaps(self.bearing, moved[0], moved[1], rho, self.placement.theta)
        at = misalignments(found, Tilts(tilt=tilt, tilt_rate=tilt, slope_x=moved[2], slope_y=moved[3]))
        found = found.on_surfaces(self.bearing, self.placement.turns)
        own = np.concatenate([found.inner, found.outer, at.inner, at.outer]) + self.closing - self.taken
        parts, forces, stiff, fallen = np.zeros(2 * n), np.zeros(4 * n), np.zeros((4 * n, 4 * n)), []
        for row, (law, surface) in enumerate(zip(self.laws, found.surfaces, strict=True)):
            d, p, most = row * n + j, (2 + row) * n + j, law.last_approach  # of a table, beyond which a step may try
            here, more = met(law, np.minimum(own[d], most), own[p], surface), np.maximum(own[d] - most, 0.0)
            forces[d], forces[p] = here.force + here.stiffness * more, -here.moment + here.cross * more
            parts[d] = here.energy + (here.force + 0.5 * here.stiffness * more) * more
            stiff[d, d], stiff[d, p], stiff[p, d] = here.stiffness, here.cross, here.cross
            stiff[p, p] = here.tilt_stiffness
            fallen.append(falls(here, surface))
        found = found.at_contact(*fallen)
        (nx, ny), across = found.normal, at.across / found.distance
        ways, psi = np.zeros((4 * n, 4 + 2 * n)), 2 * n + j
        ways[j, 0], ways[j, 1], ways[j, 4 + j] = -found.direction_x, -found.direction_y, -found.radial
        ways[n + j, 4 + j] = 1.0
        ways[psi, 0], ways[psi, 1], ways[psi, 4 + j] = across * ny, -across * nx, -across * found.circle[1]
        ways[psi, 2], ways[psi, 3], ways[psi, 4 + n + j] = -nx, -ny, found.circle[0]
        ways[3 * n + j, 4 + n + j] = -1.0
        tangent = np.zeros((n, 4 + 2 * n))  # ways along the inner contacts' tangents
        tangent[:, 0], tangent[:, 1], tangent[j, 4 + j] = ways[j, 1], -ways[j, 0], -found.circle[1]
        off, rest = moved - self.slack, self.between @ own
        pull = self.springs * off
        left = self.applied - pull - ways.T @ (forces + rest) - self.inertial * moved
        left = np.where(self.moves, left, 0.0)
        energy = float(parts.sum() + 0.5 * (pull @ off + rest @ own) - self.applied @ off)
        carried = np.where(np.arange(moved.size) < 4 + n, self.slack, 0.0)  # from which radii's own energy counts
        energy += 0.5 * float(self.inertial @ (moved**2 - carried**2))
        size = np.abs(left)
        size[2:4], size[self.tilt] = size[2:4] / self.length, size[self.tilt] / self.length
        largest = max(float(np.abs(self.applied).max()), float(np.abs(forces[: 2 * n]).max()))
        over, nearly = (
            max(size[:4].max() / (share * largest + LEAST_FORCE), size[4:].max() / (share * largest + FAINTEST))
            for share in (BALANCED, NEARLY)
        )
        noise = ROUND_OFF_ENERGY * (np.abs(parts).sum() + abs(energy))
        turning = -(tangent.T * (forces[:n] / found.distance)) @ tangent
        return _TiltPoint(energy, over, left, nearly <= 1.0, noise, forces, stiff, own, ways, turning, found)

    def rested(self, moved: np.ndarray, here: _TiltPoint) -> np.ndarray:
        """Places with rollers that nothing presses in the middle of their gaps, where those touch no raceway there."""
        own = here.own.reshape(2, 2, -1)
        apart, middle = 0.5 * (own[:, 0] - own[:, 1]), own.mean(axis=1)
        each = zip(self.laws, here.found.surfaces, strict=True)
        bear = [met(law, middle[0], middle[1], surface).force > 0.0 for law, surface in each]
        idle = ~(bear[0] | bear[1] | self.is_pressed) & (np.abs(apart).max(axis=0) > FITTING)
        return moved + np.concatenate([np.zeros(4), *(idle * apart * [[1.0], [-1.0]])]) if idle.any() else moved

    def _stiffness(self, here: _TiltPoint, contacts: np.ndarray) -> np.ndarray:
        own = np.diag(self.springs + self.inertial)
        return here.ways.T @ (contacts + self.between) @ here.ways + here.turning + own

    def newton(self, here: _TiltPoint) -> np.ndarray:
        """Newton's step of the bodies; along directions with negative stiffness downhill."""
        moves, step = self.moves, np.zeros(self.moves.size)
        whole = self._stiffness(here, here.stiff)[np.ix_(moves, moves)]
        scale = np.sqrt(np.abs(np.diag(whole)))
        values, vectors = np.linalg.eigh(whole / np.outer(scale, scale))
        values = np.maximum(np.abs(values), LEAST_SCALED)
        step[moves] = (vectors @ ((vectors.T @ (here.left[moves] / scale)) / values)) / scale
        ways = np.abs(step[:2]).max(), np.abs(step[self.rho]).max(), self.length * np.abs(step[self.tilt]).max()
        return step * min(1.0, LONGEST * self.bearing.roller_radius / max(*map(float, ways), 1e-30))

    def settled(self, here: _TiltPoint, more: np.ndarray) -> np.ndarray:
        """Change of `taken` that Newton's method finds, (4 n,); `more` : its error under the forces at hand."""
        moves, stiff = self.moves, here.stiff
        ways = here.ways[:, moves]
        follow = np.linalg.solve(self._stiffness(here, stiff)[np.ix_(moves, moves)], ways.T @ (stiff + self.between))
        return np.linalg.solve(np.eye(4 * self.n) + self.compliance @ (stiff - stiff @ ways @ follow), more)

    def found(self, moved, here: _TiltPoint) -> TiltedStatics:
        inner, outer, inner_moment, outer_moment = here.forces.reshape(4, -1)
        effective = np.linalg.solve((np.eye(4 * self.n) + self.compliance @ here.stiff).T, here.stiff.T).T
        whole = self._stiffness(here, effective)
        return TiltedStatics(
            place=moved[:4], rho=moved[self.rho], tilt=moved[self.tilt], theta=self.placement.theta,
            inner_force=inner, outer_force=outer, inner_moment=-inner_moment, outer_moment=-outer_moment,
            own=here.own.reshape(2, -1), is_free=self.hub.is_free, on_hub=-(here.ways.T @ here.forces)[2:4],
            stiffness=whole[:4, :4] - whole[:4, 4:] @ np.linalg.solve(whole[4:, 4:], whole[4:, :4]),
        )  # fmt: skip
