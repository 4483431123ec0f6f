"""The housing that carries the outer ring, on springs and dashpots to the ground, and the sensor on it.

The outer ring's held row moves with the housing as the inner ring's does with the hub. Springs are explicit; dashpots
act by the mean of the velocities before and after a kick, so that no damping shortens the step. The sensor is excited
by the housing's acceleration and does not react on it: between two steps its motion is exact.

Equation (1) of docs/supports.md.
"""

from typing import NamedTuple

from fem.kernels import ring_kernels
from fem.kernels.bodies import (
    add_motion,
    calm_body,
    drift_body,
    end_kick,
    kick_body,
    prepare,
    remember_slowed,
    slow_body,
    take_late,
)
from fem.kernels.fields import given, room, state
from fem.kernels.jit import part, verb
from fem.kernels.sample_kernels import DISSIPATED, WORK_GRAVITY
from fem.kernels.shaft import conclude
from fem.kernels.state import Ring

PLACE_X, PLACE_Y, AX, AY, STORED, SENSOR = range(6)  # of the housing's columns, from its first one on


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
    ring: Ring | None  # None: rigid, or with play in the housing's bore
    line: room("2, width")  # of the ring
    sensor: Resonator | None
    mass: float  # kg, with held nodes or a rigid ring, if it has them
    late_mass: float  # kg, see `shaft`
    stiffness: float  # N/m
    damping: float  # N s/m
    column: int  # of a sample's row, its first


@part
def set_held_row(ring, velocity):
    """Give an elastic ring's held row a velocity, m/s."""
    if ring is not None:
        at = 2 * ring.held * ring.cosines.size
        ring_kernels.set_rigid(ring.w, at, ring.cosines, ring.sines, velocity[0], velocity[1])


@part
def carry(ring, x, y):
    """Move an elastic ring's held row to (x, y), m."""
    if ring is not None:
        ring_kernels.set_rigid(ring.u, 2 * ring.held * ring.cosines.size, ring.cosines, ring.sines, x, y)


@verb
def sense(sensor, acceleration):
    """Move a sensor on by a step, under the housing's acceleration, m/s²."""


@sense.of(Resonator)
def _sense(sensor, acceleration):
    sensor.motion[0], sensor.motion[1] = _moved(sensor.motion, sensor.step, acceleration)


@part
def _moved(motion, step, acceleration):
    r, rate = motion
    return (
        step[0, 0] * r + step[0, 1] * rate + step[0, 2] * acceleration,
        step[1, 0] * r + step[1, 1] * rate + step[1, 2] * acceleration,
    )


@kick_body.of(Housing)
def _kick(body, drive):
    dt, over = drive.dt, 1.0 / body.mass
    # Impulse, N s, that an elastic ring's held row has from its nodes in a step, x and y.
    if body.ring is None:
        reaction = 0.0, 0.0
    else:
        ring_kernels.row_force(body.ring.table, body.ring.u, body.ring.held, body.line)
        x, y = ring_kernels.resultant(body.line, body.ring.cosines, body.ring.sines)
        mass = body.ring.row_mass[body.ring.held]
        reaction = mass * x, mass * y
    slowed = 0.5 * dt * over * body.damping
    for k in range(2):
        before = body.velocity[k]
        gained = (body.impulse[k] + reaction[k]) * over - dt * over * body.stiffness * body.place[k]
        if k == 1:
            gained -= drive.gravity * dt
        body.before[k] = before
        body.velocity[k] = (before * (1.0 - slowed) + gained) / (1.0 + slowed)
        body.drag[k] = -0.5 * body.damping * (before + body.velocity[k])
        body.impulse[k] = 0.0


@take_late.of(Housing)
def _take_late(body):
    for k in range(2):
        body.velocity[k] += body.impulse[k] / body.late_mass
        body.impulse[k] = 0.0


@end_kick.of(Housing)
def _end_kick(body, drive):
    conclude(body)


@prepare.of(Housing)
def _prepare(body):
    set_held_row(body.ring, body.velocity)


@calm_body.of(Housing)
def _calm(body):
    if body.ring is not None:
        ring_kernels.calm_held(body.ring, body.mass, body.line)


@slow_body.of(Housing)
def _slow(body, drive):
    if drive.slowing > 0.0:
        # What the reciprocal mass adds to the motion of a body of `mass`, kg, with an elastic ring's held row.
        if body.ring is not None:
            ring_kernels.row_force(body.ring.slowed, body.ring.calmed, body.ring.held, body.line)
            x, y = ring_kernels.resultant(body.line, body.ring.cosines, body.ring.sines)
            share = body.ring.row_mass[body.ring.held] / body.mass
            remember_slowed(body.slowed, share * x, share * y)


@drift_body.of(Housing)
def _drift(body, drive):
    dt, slowed = drive.dt, body.slowed
    for k in range(2):
        moved = dt * (body.before[k] + body.velocity[k]) + slowed[0, k] + slowed[1, k]
        body.dissipated[0] -= 0.5 * body.drag[k] * moved
        body.place[k] += dt * body.velocity[k] + slowed[1, k]
    carry(body.ring, body.place[0], body.place[1])
    sense(body.sensor, (body.velocity[1] - body.before[1]) / dt)


@add_motion.of(Housing)
def _add_motion(body, drive, out, kinetic):
    for k in range(2):
        out[kinetic] += 0.5 * body.mass * body.before[k] * body.velocity[k]
    place, dt, at = body.place, drive.dt, body.column
    out[WORK_GRAVITY] -= drive.gravity * body.mass * place[1]
    moved_x, moved_y = dt * body.before[0] + body.slowed[0, 0], dt * body.before[1] + body.slowed[0, 1]
    out[DISSIPATED] += body.dissipated[0] - 0.5 * (body.drag[0] * moved_x + body.drag[1] * moved_y)
    out[at + PLACE_X], out[at + PLACE_Y] = place[0], place[1]
    out[at + AX], out[at + AY] = (body.velocity[0] - body.before[0]) / dt, (body.velocity[1] - body.before[1]) / dt
    out[at + STORED] = 0.5 * body.stiffness * (place[0] * place[0] + place[1] * place[1])
    if body.sensor is not None:
        r, rate = _moved(body.sensor.motion, body.sensor.half_step, out[at + AY])
        out[at + SENSOR] = body.sensor.pull[0] * r + body.sensor.pull[1] * rate
