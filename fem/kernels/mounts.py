"""What holds hub and outer ring: springs and dashpots between ground and shaft, or housing; the sensor on a housing.

Springs are explicit, dashpots act by the mean of the velocities before and after a kick: exact in the balance of
energies, and no damping shortens the step. Forces that are found after those of the dashpots change them once more: the
finite elements divide the impulses of such forces by a body's `late_mass`, its mass and half a step of its dashpots,
which is what both together resist with, and let the dashpots `conclude` a kick; rigid bodies' forces need their
compliance, `mobility`. The sensor is excited by the housing's acceleration and does not react on it: between two steps
its motion is exact. None in place of a mount: nothing holds the hub but the bearing, or the ground holds the ring.

Equation (1) of docs/supports.md.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.columns import DISSIPATED, HUB_AX, HUB_VX, HUB_X, KINETIC, WORK_GRAVITY
from fem.kernels.fields import given, room, state
from fem.kernels.jit import part

DONE, NOT_FINITE = 0, 1
TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken, see `rigid.kick`
FASTEST = 1e5  # m/s; no body is faster unless the run has blown up
PLACE_X, PLACE_Y, AX, AY, STORED, SENSOR = range(6)  # of the housing's columns, from its first one on


class Shaft(NamedTuple):
    """Springs and dashpots on the hub, whose arrays it shares."""

    place: np.ndarray  # (2,), m, of the hub; 0 where the springs are slack
    velocity: np.ndarray  # (2,), m/s, of the hub at t − dt/2; after its kick by all else at t + dt/2
    before: state("2")  # m/s, before the kick
    slowed: np.ndarray  # (2, 2), m, of the hub, see `Drive`
    drag: state("2")  # N, of the dashpots in the last kick
    stored: state("1")  # J, in the springs
    dissipated: state("1")  # J, so far
    mass: float  # kg, of the hub
    stiffness: float  # N/m
    damping: float  # N s/m
    column: int  # of a sample's row, for the energy of the springs


class Resonator(NamedTuple):
    """A sensor on the housing; see `lagrange.mounting.Sensor`."""

    motion: state("2")  # r, m, and ṙ, m/s, at t − dt/2
    step: given("2, 3")  # of dt
    half_step: given("2, 3")
    pull: given("2")  # acceleration by r and by ṙ


class Housing(NamedTuple):
    """A rigid body with the held row of an elastic outer ring, or with a rigid one, or with none: a bored one's."""

    place: state("2")  # m, of the outer ring's centre; 0 where the springs are slack
    velocity: state("2")  # m/s, at t − dt/2
    before: state("2")  # m/s, before the last kick
    impulse: state("2")  # N s, of this step, by contacts on the outer ring as a whole
    slowed: state("2, 2")  # m, that the reciprocal mass adds to its motion: in the last step, in the next
    drag: state("2")  # N, of the dashpots in the last kick
    dissipated: state("1")  # J, so far
    ring: tuple | None  # `elements.state.Ring`; None: rigid, or with play in the housing's bore
    line: room("2, width")  # of the ring
    sensor: Resonator | None
    mass: float  # kg, with held nodes or a rigid ring, if it has them
    late_mass: float  # kg
    stiffness: float  # N/m
    damping: float  # N s/m
    column: int  # of a sample's row, its first


@part
def lost(hub_velocity, rollers):
    """The first body whose velocity is not a number or absurd, or −2."""
    if not abs(hub_velocity[0]) + abs(hub_velocity[1]) < FASTEST:
        return -1
    for j in range(rollers.n):
        if not abs(rollers.velocity[0, j]) + abs(rollers.velocity[1, j]) < FASTEST:
            return j
    return -2


def late_mass(mass: float, damping: float, dt: float) -> float:
    """What resists forces that are found after those of dashpots, kg."""
    return mass + 0.5 * dt * damping


@part
def mobility(mount, mass, dt):
    """Velocity that a newton gives in a kick, m/s/N, with what the dashpots take of it; `mass` : kg."""
    over = dt / mass
    return over if mount is None else over / (1.0 + 0.5 * over * mount.damping)


@part
def push_mounted(mount, velocity, mass, x, y, dt):
    """Add the kick of forces, N, that are found after a mount's dashpots."""
    over, force = mobility(mount, mass, dt), (x, y)
    for k in range(2):
        gained = over * force[k]
        velocity[k] += gained
        if mount is not None:
            mount.drag[k] -= 0.5 * mount.damping * gained


@part
def settle(mount, dt):
    """Let the dashpots take their share of velocities that others have changed since their kick without asking."""
    if mount is not None:
        over = dt / mount.mass
        slowed = 0.5 * over * mount.damping
        for k in range(2):
            free = mount.velocity[k] - over * mount.drag[k]
            mount.velocity[k] = (free - slowed * mount.before[k]) / (1.0 + slowed)
            mount.drag[k] = -0.5 * mount.damping * (mount.before[k] + mount.velocity[k])


@part
def conclude(mount):
    """The dashpots' forces by all velocities after a kick."""
    for k in range(2):
        mount.drag[k] = -0.5 * mount.damping * (mount.before[k] + mount.velocity[k])


@part
def _kick(mount, k, before, gained, dt):
    """The velocity after a kick by dashpots and all else, which alone would give `gained`, m/s."""
    slowed = 0.5 * dt * (1.0 / mount.mass) * mount.damping
    mount.velocity[k] = (before * (1.0 - slowed) + gained) / (1.0 + slowed)
    mount.drag[k] = -0.5 * mount.damping * (before + mount.velocity[k])


@part
def kick_shaft(shaft, dt, x, y):
    """The kick by springs that are stretched by x and y, m, and by the dashpots."""
    over, stretched = 1.0 / shaft.mass, (x, y)
    for k in range(2):
        before = shaft.before[k]
        gained = shaft.velocity[k] - before - dt * over * shaft.stiffness * stretched[k]
        _kick(shaft, k, before, gained, dt)
    shaft.stored[0] = 0.5 * shaft.stiffness * (x * x + y * y)


@part
def kick_housing(housing, drive):
    """The kick by weight, springs, dashpots, and impulses on the ring, which are then cleared."""
    dt, over = drive.dt, 1.0 / housing.mass
    for k in range(2):
        gained = housing.impulse[k] * over - dt * over * housing.stiffness * housing.place[k]
        if k == 1:
            gained -= drive.gravity * dt
        housing.before[k] = housing.velocity[k]
        _kick(housing, k, housing.velocity[k], gained, dt)
        housing.impulse[k] = 0.0


@part
def _dissipate(mount, dt):
    """Count the work of the dashpots in a kick by the velocities before and after it."""
    for k in range(2):
        moved = dt * (mount.before[k] + mount.velocity[k]) + mount.slowed[0, k] + mount.slowed[1, k]
        mount.dissipated[0] -= 0.5 * mount.drag[k] * moved


@part
def drift_shaft(shaft, drive):
    """Keep what a step's end needs of its beginning."""
    _dissipate(shaft, drive.dt)
    shaft.before[0], shaft.before[1] = shaft.velocity[0], shaft.velocity[1]


@part
def drift_housing(housing, drive):
    """Advance the place by one step, and the sensor."""
    dt, sensor = drive.dt, housing.sensor
    _dissipate(housing, dt)
    for k in range(2):
        housing.place[k] += dt * housing.velocity[k] + housing.slowed[1, k]
    if sensor is not None:
        acceleration = (housing.velocity[1] - housing.before[1]) / dt
        sensor.motion[0], sensor.motion[1] = _moved(sensor.motion, sensor.step, acceleration)


@part
def _moved(motion, step, acceleration):
    """A sensor's motion a step, or half of one, on, under the housing's acceleration, m/s²."""
    r, rate = motion
    return (
        step[0, 0] * r + step[0, 1] * rate + step[0, 2] * acceleration,
        step[1, 0] * r + step[1, 1] * rate + step[1, 2] * acceleration,
    )


@part
def _write_dissipated(mount, dt, out):
    drag, before, slowed = mount.drag, mount.before, mount.slowed
    moved_x, moved_y = dt * before[0] + slowed[0, 0], dt * before[1] + slowed[0, 1]
    out[DISSIPATED] += mount.dissipated[0] - 0.5 * (drag[0] * moved_x + drag[1] * moved_y)


@part
def write_hub(out, place, before, after, dt):
    """The hub's columns: its place, m, and its motion in a kick by its velocities before and after, m/s."""
    for k in range(2):
        out[HUB_X + k], out[HUB_VX + k] = place[k], 0.5 * (before[k] + after[k])
        out[HUB_AX + k] = (after[k] - before[k]) / dt


@part
def write_shaft(shaft, drive, out):
    """What the dashpots have dissipated and the springs store, J."""
    _write_dissipated(shaft, drive.dt, out)
    out[shaft.column] = shaft.stored[0]


@part
def write_housing(housing, drive, out):
    """Kinetic energy at the kick just made, J; works; the housing's and the sensor's columns."""
    place, dt, at = housing.place, drive.dt, housing.column
    velocity, before, sensor = housing.velocity, housing.before, housing.sensor
    for k in range(2):
        out[KINETIC] += 0.5 * housing.mass * before[k] * velocity[k]
    out[WORK_GRAVITY] -= drive.gravity * housing.mass * place[1]
    _write_dissipated(housing, dt, out)
    out[at + PLACE_X], out[at + PLACE_Y] = place[0], place[1]
    out[at + AX], out[at + AY] = (velocity[0] - before[0]) / dt, (velocity[1] - before[1]) / dt
    out[at + STORED] = 0.5 * housing.stiffness * (place[0] * place[0] + place[1] * place[1])
    if sensor is not None:
        r, rate = _moved(sensor.motion, sensor.half_step, out[at + AY])
        out[at + SENSOR] = sensor.pull[0] * r + sensor.pull[1] * rate


# among rigid bodies


@part
def ring_place(housing):
    """Of the outer ring's centre, m."""
    if housing is None:
        return 0.0, 0.0
    return housing.place[0], housing.place[1]


@part
def ring_rates(housing):
    """Velocities of the outer ring before and after its kick, m/s, as pairs."""
    if housing is None:
        return (0.0, 0.0), (0.0, 0.0)
    return (housing.before[0], housing.before[1]), (housing.velocity[0], housing.velocity[1])


@part
def rescale_kick(before, after, k, back):
    """Change the velocities before and after a kick to those of another step length."""
    gained = after[k] - before[k]
    before[k] += back * gained
    after[k] -= back * gained
