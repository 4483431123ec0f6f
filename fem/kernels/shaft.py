"""What holds the shaft beside the bearing: springs and dashpots between the hub and the ground, along x and along y.

Springs are explicit, dashpots act by the mean of the velocities before and after a kick, as a housing's: exact in the
balance of energies, and no damping shortens the step.

Dashpots between the ground and what a bearing sits in or on, a housing or a shaft: by the mean of the velocities before
and after a kick, which forces that are found after theirs change once more.

Finite elements divide the impulses of such forces by a body's `late_mass`, its mass and half a step of its dashpots,
which is what both together resist with, and let the dashpots `conclude` a kick; the reduced model's forces need their
compliance.

A body here is a named tuple with `velocity`, `before`, `drag`, `mass`, `damping`: `Shaft`, which shares its arrays with
the hub, or `Housing`. None: nothing is held so.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.bodies import add_motion, drift_body, end_kick, kick_body
from fem.kernels.fields import state
from fem.kernels.jit import part
from fem.kernels.sample_kernels import DISSIPATED


@part
def mobility(body, mass, dt):
    """Velocity that a newton gives in a kick, m/s/N, with what the dashpots take of it; `mass` : kg."""
    over = dt / mass
    if body is not None:
        over = over / (1.0 + 0.5 * over * body.damping)
    return over


@part
def give_way(body, component, gained):
    """The dashpots' forces when one velocity has gained so much, m/s, in which they had their share."""
    if body is not None:
        body.drag[component] -= 0.5 * body.damping * gained


@part
def settle(body, dt):
    """Let the dashpots take their share of velocities that others have changed since their kick without asking."""
    if body is not None:
        over = dt / body.mass
        slowed = 0.5 * over * body.damping
        for k in range(2):
            free = body.velocity[k] - over * body.drag[k]
            body.velocity[k] = (free - slowed * body.before[k]) / (1.0 + slowed)
            body.drag[k] = -0.5 * body.damping * (body.before[k] + body.velocity[k])


def late_mass(mass: float, damping: float, dt: float) -> float:
    """What resists forces that are found after those of dashpots, kg."""
    return mass + 0.5 * dt * damping


@part
def conclude(body):
    """The dashpots' forces by all velocities after a kick."""
    for k in range(2):
        body.drag[k] = -0.5 * body.damping * (body.before[k] + body.velocity[k])


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


@part
def pull(shaft, dt, x, y):
    """The kick by springs that are stretched by x and y, m, and by the dashpots."""
    over = 1.0 / shaft.mass
    slowed = 0.5 * dt * over * shaft.damping
    stretched = x, y
    for k in range(2):
        before = shaft.before[k]
        gained = shaft.velocity[k] - before - dt * over * shaft.stiffness * stretched[k]
        shaft.velocity[k] = (before * (1.0 - slowed) + gained) / (1.0 + slowed)
        shaft.drag[k] = -0.5 * shaft.damping * (before + shaft.velocity[k])
    shaft.stored[0] = 0.5 * shaft.stiffness * (x * x + y * y)


@kick_body.of(Shaft)
def _kick(shaft, drive):
    place = shaft.place
    pull(shaft, drive.dt, place[0], place[1])


@end_kick.of(Shaft)
def _end_kick(shaft, drive):
    conclude(shaft)
    place = shaft.place
    drive.moment[1] += drive.dt * (place[0] * shaft.drag[1] - place[1] * shaft.drag[0])


@drift_body.of(Shaft)
def _drift(shaft, drive):
    slowed = shaft.slowed
    for k in range(2):
        moved = drive.dt * (shaft.before[k] + shaft.velocity[k]) + slowed[0, k] + slowed[1, k]
        shaft.dissipated[0] -= 0.5 * shaft.drag[k] * moved
        shaft.before[k] = shaft.velocity[k]


@add_motion.of(Shaft)
def _add_motion(shaft, drive, out, kinetic):
    drag, before, slowed = shaft.drag, shaft.before, shaft.slowed
    moved_x, moved_y = drive.dt * before[0] + slowed[0, 0], drive.dt * before[1] + slowed[0, 1]
    out[DISSIPATED] += shaft.dissipated[0] - 0.5 * (drag[0] * moved_x + drag[1] * moved_y)
    out[shaft.column] = shaft.stored[0]
