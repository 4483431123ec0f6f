"""A cage among free elements of the Lagrangian model: the kernels of `cage_kernels` in its leapfrog.

Elements roll without slip, so their spin is prescribed: what friction in the pockets takes of it, and the guide of the
shaft's, those who prescribe it give back (`IdealMotion.works`, HELD).

In a housing that moves places and velocities are from the outer ring's centre, as those of hub and elements. What the
cage gives a guiding outer ring stands in that ring's `GuidingRing.velocity` until all that is seen from it loses it.
"""

from typing import NamedTuple

from fem.kernels.bodies import drift_body, kick_body
from fem.kernels.cage import push_ring_as_a_whole
from fem.kernels.cage_kernels import end_works, find_contacts, rub, turn_guide
from fem.kernels.jit import part
from fem.kernels.lagrangian_housing import carry_cage, give_ring, velocity_of_ring


class CageDrive(NamedTuple):
    """What a cage takes of the drive of a time loop."""

    gravity: float  # m/s²
    dt: float  # s


@part
def meet_cage(pair, shaft, spin, dt):
    """Find the contacts before a kick; shaft and elements turn at these speeds, rad/s."""
    if pair is not None and dt > 0.0:
        riders = pair.riders
        for j in range(riders.n):
            riders.spin[j] = spin
        turn_guide(pair.ring, shaft)
        find_contacts(pair, dt)


@part
def kick_cage(pair, motion, bearing, dt):
    """The springs' impulses on elements, cage and guiding ring; the cage's weight and drag."""
    if pair is not None and dt > 0.0:
        riders, over = pair.riders, 1.0 / pair.riders.mass
        for k in range(2):
            for j in range(riders.n):
                riders.velocity[k, j] += riders.body_impulse[k, j] * over
                riders.body_impulse[k, j] = 0.0
        push_ring_as_a_whole(pair.ring)
        _give_outer_ring(pair.ring, motion, bearing)
        kick_body(pair.cage, CageDrive(bearing.gravity, dt))


@part
def _give_outer_ring(ring, motion, bearing):
    if ring is not None:
        if not ring.turns:
            give_ring(motion.housing, motion, bearing, ring.velocity)


@part
def rub_cage(pair, motion, bearing, shaft, before, dt):
    """End a kick: dashpots and friction; the work of what turns elements and shaft, J.

    `before` : m/s, velocity of the outer ring before the kick
    """
    if pair is None or dt == 0.0:
        return 0.0
    carry_cage(motion.housing, pair, before)
    rub(pair, dt)
    end_works(pair, dt)
    kicked = velocity_of_ring(motion.housing)
    _give_outer_ring(pair.ring, motion, bearing)
    carry_cage(motion.housing, pair, kicked)
    riders, pockets, work = pair.riders, pair.cage.pockets, 0.0
    for j in range(riders.n):
        work += pockets.given[1, j] * riders.radius * riders.spin[j]
    return dt * work + _of_shaft(pair.ring, shaft)


@part
def _of_shaft(ring, shaft):
    if ring is None:
        return 0.0
    return -shaft * ring.rubbed[2] if ring.turns else 0.0


@part
def drift_cage(pair, dt):
    if pair is not None:
        drift_body(pair.cage, CageDrive(0.0, dt))


@part
def write_cage(pair, row, out):
    """A sample of a cage: its places and velocities, its losses, what dashpot and friction give in its contacts."""
    if pair is None:
        return
    cage = pair.cage
    n = cage.pockets.force.size
    for i in range(3):
        out[row, i], out[row, 3 + i], out[row, 6 + i] = cage.motion[0, i], cage.motion[1, i], cage.lost[i]
    for k in range(2):
        out[row, 9 + k] = _given(cage.guide, k)
        for j in range(n):
            out[row, 11 + k * n + j] = cage.pockets.given[k, j]


@part
def _given(guide, k):
    return 0.0 if guide is None else guide.given[k, 0]
