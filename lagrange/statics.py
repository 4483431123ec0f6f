"""Static equilibrium of hub and rolling elements at given angles, by Newton's method: axes parallel, or tilted.

Unknowns are the hub's place and, where it is free, its slope, the rollers' radii and tilts, and each contact's own
approach and misalignment: where bodies are elastic these are less than the bodies' by what the forces and moments of
other contacts take. The equilibrium is the least of a potential; Newton's steps, downhill along directions of negative
stiffness, are as long as makes it less. With parallel axes slopes and tilts are held, and contacts have no moments.
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.axial.table import TiltedLaw
from lagrange.bearing import Bearing, Operation
from lagrange.contact.laws import ContactLaws
from lagrange.equations import Overlaps, nothing_carries, overlaps, touching_distances
from lagrange.kinematics import kinematics, roller_angles
from lagrange.motion import HubTilt, Tilts, falls, met, misalignments, roller_inertias
from lagrange.surface.deviation import UNTURNED, Turns

MOST_STEPS, MOST_TURNS, MOST_HALVINGS = 200, 60, 30
LEAST_SCALED = 1e-9  # of scaled stiffnesses
LONGEST = 2e-3  # of a roller's radius
BALANCED = 1e-10  # of the largest force, and of that over the rollers' length; or, where contacts of edges that
NEARLY = 1e-4  # hardly touch keep steps from it, so much, which hardly moves anything
FAINTEST = 1e-4  # N, on rollers that only LOOSE holds: there the tables have kinks
LEAST_FORCE = 1e-7  # N
ROUND_OFF_ENERGY = 1e-15
ROUND_OFF = 4e-16  # of a radius: two units in its last place
FITTING = 1e-13  # m, of approaches
CONTRACTING = 0.5  # of what contacts took too little a turn ago
# N/m, and N m/rad a metre squared, keeps the hub in the middle, and rollers between raceways, that no force holds
LOOSE = 1.0

Place = ndarray | tuple[float, float]


class Statics(NamedTuple):
    """An equilibrium; SI, arrays (n_rollers,). With parallel axes slopes, tilts and moments are 0."""

    place: ndarray  # (4,), of the hub: x, y, m, and its slope along x and y, rad
    rho: ndarray
    tilt: ndarray
    theta: ndarray
    inner_force: ndarray
    outer_force: ndarray
    inner_moment: ndarray  # N m
    outer_moment: ndarray
    own: ndarray  # (2, 2 n_rollers), approach, m, and misalignment, rad, of each contact's law
    # of the hub as elements follow it, N/m, N/rad, N m/rad: of parallel axes by its place, (2, 2), of others by its
    # slope too, (4, 4); negative across what it balances on
    stiffness: ndarray
    on_hub: ndarray  # (2,), N m, moment of the contacts on the hub's slope
    is_free: bool  # whether that slope moves

    @property
    def hub(self) -> ndarray:
        return self.place[:2]

    @property
    def x(self) -> float:
        return float(self.place[0])

    @property
    def y(self) -> float:
        return float(self.place[1])

    def of_side(self, row: int) -> ndarray:
        """Approaches, m, and misalignments, rad, of the inner (0) or outer (1) contacts' laws, (2, n_rollers)."""
        return self.own.reshape(2, 2, -1)[:, row]

    @property
    def radial_stiffness(self) -> ndarray:
        """Of the hub's place as all else follows, a free slope too, (2, 2), N/m."""
        return _condensed(self.stiffness, 2) if self.is_free else self.stiffness[:2, :2]

    @property
    def moved(self) -> ndarray:
        """All places, (4 + 2 n_rollers,): of the hub, radii, tilts."""
        return np.concatenate([self.place, self.rho, self.tilt])


def _condensed(stiffness, kept):
    """Of the first coordinates as the others follow."""
    whole, k = stiffness, kept
    return whole[:k, :k] - whole[:k, k:] @ np.linalg.solve(whole[k:, k:], whole[k:, :k])


def static_equilibrium(
    bearing: Bearing, operation: Operation, laws: ContactLaws, *, angles: ndarray | None = None,
    roller_mass: float | None = None, start: Place | None = None, turns: Turns = UNTURNED, ring: Place = (0.0, 0.0),
) -> Statics:  # fmt: skip
    """Equilibrium under load, weights and the elements' centrifugal force at cage speed.

    angles : (n_rollers,), rad; default: equally spaced from the operation's first angle
    roller_mass : kg; default: the bearing's; 0 leaves out the elements' weight and centrifugal force
    start : hub position to begin from, m
    turns : of ring and rollers, which matter where their surfaces are not perfect
    ring : where the outer ring's centre is, m, from which all places are; the shaft's springs know the fixed frame

    RuntimeError: no equilibrium found. Forces balance to 1e-10 of the largest, or to the round-off of the
    approaches (1e-8 N) if that is more. Without load the hub of a bearing with clearance stays where it is put; an
    element that nothing holds lies midway in its gap.
    """
    theta = roller_angles(bearing, operation.first_roller_angle) if angles is None else np.asarray(angles, dtype=float)
    load, hub = _load(operation), np.zeros(2) if start is None else np.array(start, dtype=float)
    weight = float(np.hypot(*load))
    if start is None and weight > 0.0:  # near enough
        sinks = [float(law.approach(5.0 * weight / bearing.n_rollers)) for law in laws]
        hub = (max(bearing.radial_clearance, 0.0) + sum(sinks)) * load / weight
    system = _Row(bearing, operation, laws, Placement(theta, ring, turns), mass=roller_mass)
    moved = system.upright(hub)
    for free in (True,) if weight > 0.0 else (False, True):  # what nothing loads stays where it is put
        system.moves[:2] = free
        moved, here = system.settled(moved)
    return system.statics(moved, here, system.upright_stiffness(here))


def held_hub(
    bearing: Bearing, operation: Operation, laws: ContactLaws, hub, *, angles, turns=UNTURNED, ring=(0.0, 0.0)
) -> tuple[ndarray, ndarray, ndarray]:
    """Force that holds the hub at a place, (2,), N, ρ of elements in radial balance, (n_rollers,), m, its stiffness.

    Parameters: as of `static_equilibrium`; hub : (2,), m
    """
    system = _Row(bearing, operation, laws, Placement(angles, ring, turns))
    system.moves[:2] = False
    moved, here = system.settled(system.upright(hub))
    return -here.left[:2], moved[system.rho], system.upright_stiffness(here)


def _load(operation):
    """Load and weight on the hub, (2,), N."""
    return np.array([operation.side_load, -(operation.radial_load + operation.inner_mass * operation.gravity)])


class Elastic(NamedTuple):
    """Compliance of the bodies between contacts, inner ones first, and further contributions to the approach."""

    compliance: ndarray  # (2 n_rollers, 2 n_rollers), m/N, of forces
    tilt_compliance: ndarray  # the same, rad per N m, of moments
    closing: ndarray  # (2 n_rollers,), m


class Placement(NamedTuple):
    """Where rollers and the outer ring stand."""

    theta: ndarray  # (n_rollers,), rad
    ring: Place = (0.0, 0.0)  # the outer ring's centre, m, from which all places are
    turns: Turns = UNTURNED  # of ring and rollers, which matter where their surfaces are not perfect


class _Point(NamedTuple):
    """The system at one state of its unknowns."""

    energy: float  # J
    size: float  # of what is left, over what may be: at most 1 in equilibrium
    left: ndarray  # (4 + 2 n,), unbalanced forces and moments
    nearly: bool  # whether it is little enough where it gets no less
    noise: float  # J, round-off of the energy
    forces: ndarray  # (4 n,), Q of all contacts, then −M
    stiff: ndarray  # (4 n, 4 n), their derivatives by own approaches and misalignments
    own: ndarray  # (4 n,), these
    ways: ndarray  # (4 n, 4 + 2 n), derivatives of approaches and misalignments by the bodies' places
    turning: ndarray  # (4 + 2 n, 4 + 2 n), stiffness by contacts' normals that turn
    found: Overlaps


def tilted_equilibrium(
    bearing: Bearing, operation: Operation, laws: Sequence[TiltedLaw], hub: HubTilt, placement: Placement,
    start: tuple[ndarray, ndarray], elastic: Elastic | None = None,
) -> Statics:  # fmt: skip
    """Equilibrium under load, weights and centrifugal forces at cage speed.

    laws : of the inner and the outer contact
    start : hub's place, (2,), and rollers' radii, (n_rollers,), m, to begin from
    elastic : None: bodies are rigid but for their contacts

    RuntimeError: no equilibrium found.
    """
    system, n = _Row(bearing, operation, laws, placement, hub, elastic), bearing.n_rollers
    moved, moves, before = np.concatenate([start[0], hub.slope, start[1], system.slack[system.tilt]]), system.moves, inf
    for _ in range(MOST_TURNS):
        moved, here = system.settled(moved)
        more = system.compliance @ here.forces - system.taken
        left = np.abs(more * system.arms).max()
        if left <= FITTING:
            effective = np.linalg.solve((np.eye(4 * n) + system.compliance @ here.stiff).T, here.stiff.T).T
            return system.statics(moved, here, _condensed(system.stiffness(here, effective + system.between), 4))
        if left >= CONTRACTING * before:
            # rings that bend more than their contacts need Newton's method, since their forces would swing
            stiff, ways = here.stiff, here.ways[:, moves]
            held = stiff + system.between
            whole = system.stiffness(here, held)[np.ix_(moves, moves)]
            follow = stiff - stiff @ ways @ np.linalg.solve(whole, ways.T @ held)
            more = np.linalg.solve(np.eye(4 * n) + system.compliance @ follow, more)
        system.taken += more
        before = left
    raise RuntimeError(system.bare or "no static equilibrium with tilt: contacts push one another in")


def _ways(hub, rho, tilt):
    """Rows of derivatives by the hub's four places, (4, n), and by each roller's own radius and tilt, (n,)."""
    return np.hstack([np.transpose(hub), np.diag(rho), np.diag(tilt)])


class _Row:
    """Balance of hub, rollers and contacts; without a `hub` that has slopes axes stay parallel."""

    def __init__(self, bearing, operation, laws, placement, hub=None, elastic=None, mass=None):
        n, m = bearing.n_rollers, bearing.roller_mass if mass is None else mass
        self.length, self.rho, self.tilt = bearing.roller_length, slice(4, 4 + n), slice(4 + n, None)  # among places
        self.bearing, self.placement, self.tilts = bearing, placement, hub is not None
        self.laws = laws
        self.bare = nothing_carries(bearing, placement.theta, _load(operation))
        cos, sin, nothing = np.cos(placement.theta), np.sin(placement.theta), np.zeros((2 * n, 2 * n))
        hub, elastic = hub or HubTilt(slope_x=0.0, slope_y=0.0), elastic or Elastic(nothing, nothing, np.zeros(2 * n))
        self.compliance = np.block([[elastic.compliance, nothing], [nothing, elastic.tilt_compliance]])
        self.closing = np.concatenate([elastic.closing, np.zeros(2 * n)])
        self.taken = np.zeros(4 * n)  # of approaches and misalignments, by other contacts
        turning, (across, along) = kinematics(bearing, *operation.ring_speeds), roller_inertias(bearing)
        cage = turning.cage
        self.is_pressed = m > 0.0 and (cage != 0.0 or operation.gravity != 0.0)  # rollers, against a raceway
        self.applied = np.concatenate([_load(operation), np.zeros(2), -m * operation.gravity * sin, np.zeros(n)])
        self.slack = np.concatenate(
            [np.zeros(2), hub.slope, np.full(n, bearing.pitch_radius), 0.5 * (hub.slope_x * cos + hub.slope_y * sin)]
        )
        self.springs, shaft = np.zeros(4 + 2 * n), operation.mounting.shaft
        self.springs[:2] = LOOSE if self.tilts else 0.0
        self.springs[2:4] = max(hub.stiffness, LOOSE * self.length**2) if hub.is_free else 0.0
        if shaft is not None:
            self.springs[:2], self.slack[:2] = shaft.stiffness, -np.asarray(placement.ring)
        self.moves = np.full(4 + 2 * n, True)
        self.moves[2:4], self.moves[self.tilt] = hub.is_free, self.tilts
        self.arms = np.repeat([1.0, self.length], 2 * n)
        # of half by how much inner contacts are closer than outer ones: a roller that bears nothing rests in its gap's
        # middle, wherever the hub goes, and touches no raceway
        half = 0.25 * LOOSE * np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.eye(n))
        self.between = np.kron(np.diag([1.0, self.length**2]), half)
        # stiffness against radii, by the centrifugal force, and against tilts of guided rollers that go round at cage
        # speed, I_a w Ω − I_t Ω²
        self.inertial = np.zeros(4 + 2 * n)
        self.inertial[self.rho] = -m * cage**2
        self.inertial[self.tilt] = along * turning.roller * cage - across * cage**2
        # least forces on hub and rollers, N, and round-off of the energy by forces, m: of laws not tables' but places'
        self.reach, self.track = touching_distances(bearing)
        self.least, self.blur = (LEAST_FORCE, FAINTEST), 0.0
        if not self.tilts:
            finest = ROUND_OFF * self.track * float(laws[0].slope(1e-4 * bearing.roller_radius))
            self.least, self.blur = (n * finest, finest), 10.0 * ROUND_OFF * self.track

    def statics(self, moved, here, stiffness):
        inner, outer, inner_moment, outer_moment = here.forces.reshape(4, -1)
        return Statics(place=moved[:4], rho=moved[self.rho], tilt=moved[self.tilt], theta=self.placement.theta,
            inner_force=inner, outer_force=outer, inner_moment=-inner_moment, outer_moment=-outer_moment,
            own=here.own.reshape(2, -1), is_free=bool(self.moves[2]), on_hub=-(here.ways.T @ here.forces)[2:4],
            stiffness=stiffness)  # fmt: skip

    def upright(self, hub):
        """Places with parallel axes to begin from: rollers between both raceways, or on the one that bears them."""
        cos, sin, track = np.cos(self.placement.theta), np.sin(self.placement.theta), self.track
        across = hub[1] * cos - hub[0] * sin
        touch = hub[0] * cos + hub[1] * sin + np.sqrt(np.maximum(self.reach**2 - across**2, 0.0))
        push = self.applied[self.rho] - self.inertial[self.rho] * track
        inner, outer = (law.approach(np.abs(push)) for law in self.laws)
        rest = np.where(push > 0.0, track + outer, touch - inner)
        rho = np.where((touch < track) & (push != 0.0), rest, 0.5 * (touch + track))
        return np.concatenate([hub, np.zeros(2), rho, np.zeros(cos.size)])

    def upright_parts(self, here, loose):
        """Stiffness of parallel axes: of the hub, (2, 2), hub by rollers, (2, n), each roller's own, (n,), N/m.

        `loose` : 1, or 0: no roller follows the hub that nothing holds
        """
        whole = self.stiffness(here, here.stiff + loose * self.between)
        return whole[:2, :2], whole[:2, self.rho], np.diag(whole)[self.rho]

    def upright_stiffness(self, here):
        """Of the hub as elements follow it, (2, 2), N/m; those that nothing holds do not."""
        hub, between, own = self.upright_parts(here, 0.0)
        return hub - between / np.where(own > 0.0, own, np.inf) @ between.T

    def settled(self, moved):
        """Places in equilibrium from others that are near; what contacts have `taken` stays."""
        here, steps = self.at(moved), 0
        while here.size > 1.0:
            steps += 1
            if steps > MOST_STEPS and here.nearly and self.tilts:
                break
            if steps > MOST_STEPS:
                kind, check = (" with tilt", "operation.misalignment_mrad, profiles") if self.tilts else ("", "law")
                raise RuntimeError(
                    self.bare
                    or f"no static equilibrium{kind} after {MOST_STEPS} steps: {np.abs(here.left[:2]).max():.3g} N "
                    f"unbalanced at hub x = {moved[0]:.3e} m, y = {moved[1]:.3e} m; check load, clearance "
                    f"{self.bearing.radial_clearance:.3e} m and {check}"
                )
            if (idle := self.rested(moved, here)) is not moved:
                moved, here = idle, self.at(idle)
            step = self.newton(here)
            expected = -float(here.left @ step)  # < 0
            for _ in range(MOST_HALVINGS):  # as makes the energy less, or what is left where round-off hides that
                there = self.at(moved + step)
                lower = there.energy <= here.energy + 1e-4 * expected
                if lower or (there.energy <= here.energy + here.noise and there.size < here.size):
                    break
                step, expected = 0.5 * step, 0.5 * expected
            moved, here = moved + step, there
        if self.tilts:
            return moved, here
        moved = self.rested(moved, here) + self.newton(here)  # to the last digit
        return moved, self.at(moved)

    def newton(self, here):
        """Newton's step; along directions with negative stiffness downhill."""
        moves, step, longest = self.moves, np.zeros(self.moves.size), LONGEST * self.bearing.roller_radius
        if not self.tilts:  # a roller knows the others by the hub alone
            hub, between, own = self.upright_parts(here, 1.0)
            own, left = np.maximum(np.abs(own), LOOSE * LEAST_SCALED), here.left
            follow = between / own
            values, vectors = np.linalg.eigh(hub - follow @ between.T)
            values = np.maximum(np.abs(values), LEAST_SCALED * np.abs(values).max() + LOOSE)
            way = vectors @ ((vectors.T @ (left[:2] - follow @ left[self.rho])) / values) * moves[:2]
            # rollers in clearance hold the others back only where no step downhill is left otherwise
            step[:2] = way * min(1.0, longest / max(float(np.abs(way).max()), 1e-30))
            step[self.rho] = np.clip((left[self.rho] - step[:2] @ between) / own, -longest, longest)
            if left @ step > 0.0:
                return step
            step[:2], step[self.rho] = way, (left[self.rho] - way @ between) / own
            return step * min(1.0, longest / max(float(np.abs(step).max()), 1e-30))
        whole = self.stiffness(here, here.stiff + self.between)[np.ix_(moves, moves)]
        scale = np.sqrt(np.abs(np.diag(whole)))
        values, vectors = np.linalg.eigh(whole / np.outer(scale, scale))
        values = np.maximum(np.abs(values), LEAST_SCALED)
        step[moves] = (vectors @ ((vectors.T @ (here.left[moves] / scale)) / values)) / scale
        ways = np.abs(step[:2]).max(), np.abs(step[self.rho]).max(), self.length * np.abs(step[self.tilt]).max()
        return step * min(1.0, longest / max(*map(float, ways), 1e-30))

    def at(self, moved):
        rho, tilt, n = moved[self.rho], moved[self.tilt], self.bearing.n_rollers
        j = np.arange(n)
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
            stiff[d, d], stiff[p, p] = here.stiffness, here.tilt_stiffness
            stiff[d, p] = stiff[p, d] = here.cross
            fallen.append(falls(here, surface))
        found = found.at_contact(*fallen)
        (nx, ny), across = found.normal, at.across / found.distance
        x, y, (radial, tangential), none = found.direction_x, found.direction_y, found.circle, 0.0 * nx
        tangent = _ways([-y, x, none, none], -found.tangential, none)  # along the inner contacts' tangents
        ways = np.concatenate([
            _ways([-x, -y, none, none], -found.radial, none), _ways(4 * [none], none + 1.0, none),
            _ways([across * ny, -across * nx, -nx, -ny], -across * tangential, radial),
            _ways(4 * [none], none, none - 1.0)])  # fmt: skip
        off, rest = moved - self.slack, self.between @ own if self.tilts else np.zeros(4 * n)
        pull = self.springs * off
        left = self.applied - pull - ways.T @ (forces + rest) - self.inertial * moved
        energy = float(parts.sum() + 0.5 * (pull @ off + rest @ own) - self.applied @ off)
        carried = np.where(np.arange(moved.size) < 4 + n, self.slack, 0.0)  # from which radii's own energy counts
        energy += 0.5 * float(self.inertial @ (moved**2 - carried**2))
        size = np.where(self.moves, np.abs(left), 0.0)
        size[2:4], size[self.tilt] = size[2:4] / self.length, size[self.tilt] / self.length
        largest = max(float(np.abs(self.applied).max()), float(np.abs(forces[: 2 * n]).max()))
        over, nearly = (
            max(size[:4].max() / (share * largest + self.least[0]), size[4:].max() / (share * largest + self.least[1]))
            for share in (BALANCED, NEARLY)
        )
        noise = ROUND_OFF_ENERGY * (np.abs(parts).sum() + abs(energy)) + self.blur * forces.sum()
        turning = -(tangent.T * (forces[:n] / found.distance)) @ tangent
        return _Point(energy, over, left, nearly <= 1.0, noise, forces, stiff, own, ways, turning, found)

    def rested(self, moved, here):
        """Places with rollers that nothing presses in the middle of their gaps, where those touch no raceway there."""
        own = here.own.reshape(2, 2, -1)
        apart, middle = 0.5 * (own[:, 0] - own[:, 1]), own.mean(axis=1)
        idle = (np.abs(apart).max(axis=0) > FITTING) & (not self.is_pressed)
        for law, surface in zip(self.laws, here.found.surfaces, strict=True):
            idle &= met(law, middle[0], middle[1], surface).force <= 0.0
        return moved + np.concatenate([np.zeros(4), *(idle * apart * [[1.0], [-1.0]])]) if idle.any() else moved

    def stiffness(self, here, contacts):
        return here.ways.T @ contacts @ here.ways + here.turning + np.diag(self.springs + self.inertial)
