"""A cage between rigid bodies, as a part of their loop; what it does is in `cage_kernels`."""

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.cage import CagePair, push_ring_as_a_whole
from fem.kernels.cage_kernels import meet, rub
from fem.kernels.drive import speed_of
from fem.kernels.jit import part
from fem.kernels.rigid_parts import begin, change_step, drift_part, kick_part, rescale_kick, write_part
from fem.kernels.sample_kernels import KINETIC
from fem.kernels.shaft import settle


@begin.of(CagePair)
def _meet(pair, step):
    drive = step.drive
    meet(pair, speed_of(drive.history, drive), drive.dt)


@kick_part.of(CagePair)
def _kick(pair, step, push):
    """The cage's kick, and its forces on rollers and guiding ring, whose dashpots take their share of it."""
    bodies, drive, riders = step.bodies, step.drive, pair.riders
    over = 1.0 / bodies.mass
    for component in range(2):
        for j in range(bodies.n):
            bodies.velocity[component, j] += riders.body_impulse[component, j] * over
            riders.body_impulse[component, j] = 0.0
    push_ring_as_a_whole(pair.ring)
    kick_body(pair.cage, drive)
    rub(pair, drive.dt)
    for j in range(bodies.n):
        bodies.spin[j] += riders.turn_kick[j]
        riders.turn_kick[j] = 0.0
    _turn_rollers(bodies.prescribed, pair, drive)
    if pair.ring is not None:
        drive.sums[1] -= pair.ring.speed[0] * pair.ring.rubbed[2]
    if pair.ring is not None:
        settle(bodies.shaft, drive.dt)
        settle(bodies.housing, drive.dt)


@part
def _turn_rollers(prescribed, pair, drive):
    """The work of what keeps the rollers' spin against what rubs on them in the pockets."""
    if prescribed is not None:
        riders, pockets = pair.riders, pair.cage.pockets
        for j in range(riders.n):
            drive.sums[1] += drive.dt * pockets.given[1, j] * riders.radius * riders.spin[j]


@write_part.of(CagePair)
def _write(pair, step, out):
    add_motion(pair.cage, step.drive, out, KINETIC)


@change_step.of(CagePair)
def _change(pair, step, change):
    """Works of its contacts' last step end by its next velocities, and so does its drag's."""
    motion = pair.cage.motion
    for i in range(3):
        rescale_kick(motion[2], motion[1], i, change.back)
    pair.cage.drag[0] *= change.drive.dt / step.drive.dt


@drift_part.of(CagePair)
def _drift(pair, step):
    drift_body(pair.cage, step.drive)
