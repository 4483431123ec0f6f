"""What is solved, and the state at t = 0: a bearing under contact laws, at rest or in a static equilibrium that moves.

An equilibrium moves as rollers pass and loads change. A hub follows it only where the contacts hold it stiffly enough:
in clearance one roller alone may carry the hub, which is balanced on it (the stiffness across is negative), and a hub
without load is not held at all. Along such directions the hub starts without velocity.

`sampled` gives the result file's columns that follow from a motion, with those of a cage.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy import ndarray

from lagrange import motion
from lagrange.axial.slices import Axial
from lagrange.axial.table import TiltedLaw
from lagrange.bearing import Bearing, Cage, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping
from lagrange.contact.laws import ContactLaws
from lagrange.errors import UsageError
from lagrange.kinematics import kinematics, kinematics_met, roller_angles, turned
from lagrange.load_history import LONGEST_LOOK, SLOWEST, load_share
from lagrange.motion import HubTilt, State, Tilts, hub_tilt, sliced_laws
from lagrange.mounting import OF_HOUSING, ring_place
from lagrange.statics import Placement, Statics, held_hub, static_equilibrium, tilted_equilibrium
from lagrange.surface.deviation import Turns

DIFFERENCE = 1e-6  # s, for the velocities of the moving equilibrium
NO_MOVE = 1e-9  # m within that time, below which velocities that do not converge are of no matter
SAME = 0.1  # of the velocities: most that they may change by as the difference is halved
JUMP = 0.01  # of the surface speed: no hub moves that fast from one equilibrium under a steady load to the next
SOFT = (
    "at the start the contacts are too soft for the hub to follow the equilibrium from roller to roller, as with one "
    "loaded roller: it starts at rest"
)
JUMPS = "the static equilibrium jumps at the start, so the hub starts at rest"


class FirstState(NamedTuple):
    """A state to start from, and what to say of it."""

    state: State
    warning: str | None = None


def followed(stiffness: ndarray, bearing: Bearing, operation: Operation) -> tuple[ndarray, ndarray]:
    """Stiffnesses, (k,), N/m, and directions, (2, k), along which a hub follows its equilibrium as rollers pass.

    Along these λ > M (n ω_cage)²: the hub's own frequency lies above that of the rollers' passage. k is 0, 1 or 2.

    stiffness : (2, 2), N/m, of the hub in its static equilibrium
    """
    values, vectors = np.linalg.eigh(stiffness)
    passage = bearing.pockets * np.abs(kinematics_met(bearing, operation).cage).max()
    stiff = values > max(operation.inner_mass * passage**2, 0.0)
    return values[stiff], vectors[:, stiff]


class Passing(NamedTuple):
    """Equilibria that a bearing passes through around a start."""

    before: Any
    after: Any
    time: float  # s, of each from the start

    def rate(self, name: str) -> ndarray:
        """Of an array in them."""
        return (getattr(self.after, name) - getattr(self.before, name)) / (2.0 * self.time)


def passing(
    at: Callable[[float], Any], stiffness: Callable[[], ndarray], bearing: Bearing, operation: Operation, way: float
) -> tuple[Passing | None, str | None]:
    """The equilibria that give a start its velocities; without these why not, unless nothing turns or none is near.

    Elastic waves excited by such a start are of second order in the rolling speed over the wave speed. Where the hub
    can't follow (in clearance, balanced on one roller) or equilibria don't follow each other a run starts at rest.

    at : the equilibrium, with a `hub`, at a time, s; stiffness : of the hub, (2, 2), N/m, at the start
    way : m, that contacts roll meanwhile
    """
    speed = surface_speed(bearing, operation)
    if speed <= SLOWEST:
        return None, None
    if followed(stiffness(), bearing, operation)[0].size < 2:
        return None, SOFT
    # far beyond its table it is of no sense
    time = min(way / speed, inf if operation.history is None else LONGEST_LOOK)
    try:
        found = Passing(at(-time), at(time), time)
    except (RuntimeError, UsageError):
        return None, None
    return (found, None) if np.linalg.norm(found.rate("hub")) <= JUMP * speed else (None, JUMPS)


def places_moving(now: Statics, found: Passing | None) -> ndarray:
    """Rates of all places, (4 + 2 n_rollers,), by equilibria around a start; None: at rest.

    A roller on which little bears may stand at several tilts: where these do not follow each other they have no rate.
    """
    if found is None:
        return np.zeros(now.moved.size)
    (before, after, _), rates, n = found, found.rate("moved"), now.tilt.size
    jumps = np.abs(after.tilt - 2.0 * now.tilt + before.tilt) > SAME * np.abs(after.tilt - before.tilt)
    rates[4 + n :][jumps] = 0.0
    return rates


def tilts_moving(now: Statics, rates: ndarray) -> Tilts:
    """Slopes in an equilibrium and their rates by those of all places, (4 + 2 n_rollers,)."""
    return Tilts(tilt=now.tilt, tilt_rate=rates[4 + now.tilt.size :], slope_x=now.place[2], slope_y=now.place[3],
        slope_x_rate=rates[2], slope_y_rate=rates[3])  # fmt: skip


def surface_speed(bearing: Bearing, operation: Operation) -> float:
    """The faster raceway's speed along itself at the start, m/s."""
    inner, outer = np.abs(operation.ring_speeds)
    return float(max(inner * bearing.inner_raceway_radius, outer * bearing.outer_raceway_radius))


def _moving(bearing, operation, ring, moved, rates, tilts=None):
    """A state of places of hub, radii and tilts with their rates, (4 + 2 n,), at the first angles and cage speed."""
    theta = roller_angles(bearing, operation.first_roller_angle)
    radii = slice(4, 4 + theta.size)
    return State(x=moved[0], y=moved[1], rho=moved[radii], theta=theta, x_rate=rates[0], y_rate=rates[1],
        rho_rate=rates[radii], theta_rate=np.zeros_like(theta) + kinematics(bearing, *operation.ring_speeds).cage,
        ring_x=ring[0], ring_y=ring[1], tilts=tilts)  # fmt: skip


def equilibrium_state(
    bearing: Bearing, operation: Operation, laws: ContactLaws, axial: Axial | None = None
) -> FirstState:
    """Static equilibrium, with the velocities at which it moves as far as the hub can follow.

    `axial` : of rollers that tilt, where a hub that cannot follow starts without velocity, and so do all

    RuntimeError: no equilibrium.
    """
    first = roller_angles(bearing, operation.first_roller_angle)

    def moment(shift, place):
        angles = first + turned(bearing, operation, shift).cage
        return operation.at(shift), dict(angles=angles, turns=Turns.rolling(bearing, operation, shift), ring=place)

    def still_at(shift, place, start=None):
        acting, there = moment(shift, place)
        plane = static_equilibrium(bearing, acting, laws, start=start, **there)
        if axial is None:
            return plane
        placement, contacts = Placement(there["angles"], place, there["turns"]), sliced_laws(bearing, axial, laws)
        return tilted_equilibrium(bearing, acting, contacts, hub_tilt(operation, axial), placement,
            (plane.hub, plane.rho))  # fmt: skip

    def force_at(place):
        still = still_at(0.0, place)
        return np.array([still.outer_force @ np.cos(first), still.outer_force @ np.sin(first)])

    ring = ring_place(operation.mounting, weight_on_springs(bearing, operation), force_at)
    now = still_at(0.0, ring)
    values, directions = followed(now.radial_stiffness, bearing, operation)
    warning = SOFT if values.size < 2 and operation.fastest > 0.0 else None
    if axial is not None:
        way = DIFFERENCE * surface_speed(bearing, operation)
        found, warning = passing(lambda shift: still_at(shift, ring), lambda: now.radial_stiffness, bearing, operation,
            way)  # fmt: skip
        rates = places_moving(now, found)
        return FirstState(_moving(bearing, operation, ring, now.moved, rates, tilts_moving(now, rates)), warning)

    def held_at(shift, velocity):
        (acting, there), at = moment(shift, ring), now.hub + shift * velocity
        force, rho, _ = held_hub(bearing, acting, laws, at, **there)
        return force, np.concatenate([at, now.place[2:], rho, now.tilt])

    def rates_by(shift):
        if values.size == 2:
            return (still_at(shift, ring, now.hub).moved - still_at(-shift, ring, now.hub).moved) / (2.0 * shift)
        # not by equilibria, which may lie far from each other here
        change = (held_at(shift, np.zeros(2))[0] - held_at(-shift, np.zeros(2))[0]) / (2.0 * shift)
        velocity = -directions @ ((directions.T @ change) / values)
        return (held_at(shift, velocity)[1] - held_at(-shift, velocity)[1]) / (2.0 * shift)

    rates = rates_by(DIFFERENCE)
    largest = np.abs(rates).max()
    too_fast = operation.history is None and np.hypot(*rates[:2]) > JUMP * surface_speed(bearing, operation)
    if 2.0 * DIFFERENCE * largest > NO_MOVE and (
        too_fast or np.abs(rates_by(0.5 * DIFFERENCE) - rates).max() > SAME * largest  # they do not converge
    ):
        rates, warning = np.zeros_like(rates), JUMPS
    return FirstState(_moving(bearing, operation, ring, now.moved, rates), warning)


def weight_on_springs(bearing: Bearing, operation: Operation) -> float:
    """Of a housing and its outer ring, N; 0 without."""
    housing = operation.mounting.housing
    return 0.0 if housing is None else operation.gravity * (housing.mass + bearing.outer_ring_mass)


@dataclass(frozen=True)
class Problem:
    """One motion to be found.

    start : "equilibrium": on the statics at the start, with the velocities of the equilibrium as it moves on;
        "rest": rings centred, contacts undeformed, elements at cage speed
    angles : "kinematic": θ̇ is the cage's, and the work of what holds it is accounted for; "free": no friction, nothing
        but a cage keeps the elements apart
    damping : of every closed contact; never makes it pull
    load_ramp : float, s, over which the load grows from nothing, by half a cosine
    cage : with free angles a body of its own; else what holds the angles
    axial : profiles and slices of rollers that tilt, guided against skew; None: axes stay parallel

    ValueError: impossible choices.
    """

    bearing: Bearing
    operation: Operation
    laws: ContactLaws
    _: KW_ONLY
    start: Literal["equilibrium", "rest"] = "equilibrium"
    angles: Literal["kinematic", "free"] = "kinematic"
    damping: ContactDamping = UNDAMPED
    load_ramp: float = 0.0
    cage: Cage | None = None
    axial: Axial | None = None

    def __post_init__(self):
        if not (min(self.damping) >= 0.0 and self.load_ramp >= 0.0):
            raise ValueError(f"damping = {self.damping}, load_ramp = {self.load_ramp}: both must be at least 0")
        if self.start not in ("equilibrium", "rest") or self.angles not in ("kinematic", "free"):
            raise ValueError(
                f"start = {self.start!r}, angles = {self.angles!r}: equilibrium or rest, kinematic or free"
            )

    @cached_property
    def contacts(self) -> Sequence[TiltedLaw]:
        """Laws of the contacts, of slices where rollers tilt."""
        return self.laws if self.axial is None else sliced_laws(self.bearing, self.axial, self.laws)

    @property
    def hub_tilt(self) -> HubTilt | None:
        """How the hub's axis stands; None: parallel to the others."""
        return None if self.axial is None else hub_tilt(self.operation, self.axial)

    def acting(self, time) -> Operation:
        """What acts at a time, s, or at times, (n_times,), with the ramp's share of the load."""
        acting, share = self.operation.at(time), load_share(time, self.load_ramp)
        return replace(acting, radial_load=share * acting.radial_load, side_load=share * acting.side_load)

    @property
    def free_cage(self) -> Cage | None:
        """The cage, where it moves by the forces on it."""
        return self.cage if self.angles == "free" else None

    @cached_property
    def first_state(self) -> FirstState:
        """The state at t = 0, and what to say of it. RuntimeError: no equilibrium to start from."""
        bearing, operation = self.bearing, self.operation
        if self.start == "rest" and self.axial is None:  # rings centred, contacts undeformed, elements at cage speed
            still, alone = np.zeros(4 + 2 * bearing.n_rollers), replace(operation.mounting, shaft=None)
            centred = still.copy()
            centred[4 : 4 + bearing.n_rollers] = bearing.pitch_radius
            ring = ring_place(alone, weight_on_springs(bearing, operation), lambda _: np.zeros(2))
            return FirstState(_moving(bearing, operation, ring, centred, still))
        if self.load_ramp > 0.0:
            operation = replace(operation, radial_load=0.0, side_load=0.0, history=None)
        return equilibrium_state(bearing, operation, self.laws, self.axial)


def sampled(problem: Problem, time: ndarray, state: State) -> dict[str, ndarray]:
    """Columns by the result file's names, but for works, and what a sensor shows; those of `problem`'s parts.

    time : (n_times,), s; of a free cage 0 alone, where it is concentric and turns with the elements
    """
    bearing, operation, hub, tilts = problem.bearing, problem.operation, problem.hub_tilt, state.tilts
    zero, per_roller, mounting, cage = np.zeros(time.size), np.zeros(state.rho.shape), operation.mounting, problem.cage
    touch = motion.contact_state(bearing, problem.contacts, state, problem.damping)
    left = motion.hub_equations(problem.acting(time), state, touch, 0.0, 0.0)
    ring_x, ring_y = zero + state.ring_x, zero + state.ring_y
    x, y = ring_x + state.x, ring_y + state.y  # in the fixed frame
    kinetic = motion.kinetic_energy(bearing, operation, state, hub)
    found = dict(time=time,
        inner_x=x, inner_y=y, inner_ax=-left[0] / operation.inner_mass, inner_ay=-left[1] / operation.inner_mass,
        inner_vx=zero + state.x_rate + state.ring_x_rate, inner_vy=zero + state.y_rate + state.ring_y_rate,
        roller_x=ring_x[:, None] + state.rho * np.cos(state.theta),
        roller_y=ring_y[:, None] + state.rho * np.sin(state.theta),
        roller_rho=state.rho, roller_theta=state.theta, inner_force=touch.inner_force, outer_force=touch.outer_force,
        inner_damping_force=per_roller + touch.inner_damper, outer_damping_force=per_roller + touch.outer_damper,
        energy_kinetic=kinetic + motion.rotation_energy(bearing, operation.at(time)),
        energy_contact=np.sum(touch.energy, axis=-1))  # fmt: skip
    if hub is not None and tilts is not None and touch.tilted is not None:
        off = np.square(tilts.slope_x - hub.slope_x) + np.square(tilts.slope_y - hub.slope_y)
        found["energy_contact"] = found["energy_contact"] + 0.5 * hub.stiffness * off  # of the shaft against tilt
        found |= dict(roller_tilt=tilts.tilt, roller_skew=per_roller, inner_moment=touch.tilted.inner_moment,
            outer_moment=touch.tilted.outer_moment, inner_slope_x=zero + tilts.slope_x,
            inner_slope_y=zero + tilts.slope_y)  # fmt: skip
        if problem.damping.acts:
            names = "inner_damping_moment", "outer_damping_moment"
            found |= zip(names, (per_roller + moment for moment in touch.tilted.dampers), strict=True)
    ring = motion.housing_accelerations(bearing, operation, state, touch)
    if mounting.shaft is not None:
        found["energy_shaft"] = 0.5 * mounting.shaft.stiffness * (x**2 + y**2)
    if mounting.housing is not None:
        found |= dict(zip(OF_HOUSING[:4], (ring_x, ring_y, *ring), strict=True))
        found["energy_support"] = 0.5 * mounting.housing.stiffness * (ring_x**2 + ring_y**2)
    if mounting.sensor is not None:
        found["sensor_ay"] = zero
    if cage is None:
        return found
    still = "angle", "guidance_x", "guidance_y", "work_dashpots", "work_friction", "work_drag"
    found |= {f"cage_{name}": zero for name in still}
    found |= dict(cage_x=ring_x, cage_y=ring_y, cage_speed=zero + state.theta_rate[:, 0], cage_moment=per_roller)
    if problem.free_cage is None:  # what holds the elements at the angles of kinematics pushes them along θ
        history = operation.history  # that of the run's start: it says how the cage speeds up
        gain = 0.0 if history is None else kinematics(bearing, *history.ring_speeds(time[:, None], 1)).cage
        *_, free = motion.accelerations(bearing, operation, state, touch, ring)
        push = bearing.roller_mass * state.rho * (gain - free)
        angle = state.theta[:, 0] - operation.first_roller_angle
        return found | dict(cage_force=push, cage_radial_force=per_roller, cage_angle=angle)
    # springs of a free cage push rollers, or a guiding ring, that lie off its play
    aside = state.rho - bearing.pitch_radius if cage.guidance == "rollers" else per_roller
    depth = np.maximum(np.abs(aside) - 0.5 * cage.pocket_clearance, 0.0)
    found |= dict(cage_force=per_roller, cage_radial_force=-np.sign(aside) * cage.stiffness * depth)
    moving = 0.5 * cage.mass * (np.square(state.ring_x_rate) + np.square(state.ring_y_rate))
    found["energy_kinetic"] = found["energy_kinetic"] + 0.5 * cage.inertia * found["cage_speed"] ** 2 + moving
    stored = np.sum(depth**2, axis=1)
    if cage.guidance == "inner_ring" and cage.guidance_clearance is not None:
        away = state.x + 1j * state.y
        deep = np.maximum(np.abs(away) - 0.5 * cage.guidance_clearance, 0.0)
        push = cage.stiffness * deep * away / np.where(deep > 0.0, np.abs(away), 1.0)  # towards the hub's centre
        found |= dict(cage_guidance_x=push.real, cage_guidance_y=push.imag)
        found["inner_ax"] = found["inner_ax"] - push.real / operation.inner_mass
        found["inner_ay"] = found["inner_ay"] - push.imag / operation.inner_mass
        stored = stored + deep**2
    found["energy_contact"] = found["energy_contact"] + 0.5 * cage.stiffness * stored
    return found
