"""A rigid cage: what its pockets and its guide do to it, to rollers and to the hub, in a step of leapfrog.

A pocket's middle is at c + R e, e turning with the cage. A cage that a ring guides has pockets with flat walls across
the pitch circle: of a roller's centre at r, s = (r − c)·t is how far it is ahead of the middle. A cage that rollers
guide has round pockets, which hold them along the radius too: there s is the distance of r from the middle. Where |s|
exceeds half the clearance, a wall with the normal n meets the roller's surface at r + radius·n. The spring's force is
the gradient of ½ k (|s| − ½ clearance)², taken with the step's other forces (`meet`). Dashpots and friction, which have
no potential, act after all others, each solved for its own velocity at the step's end, one after the other (`rub`):
each can but take energy, whatever its constants, so none limits the step. Friction acts across n and turns the roller.

Works are exact: a force's is that of the mean of its velocities before and after the whole step. So that of a step's
force ends when the next one begins.

Equation (1) of docs/cage.md.
"""

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.cage import (
    DRAG,
    N_CAGE_SCALARS,
    Cage,
    CagePair,
    end_guide_work,
    end_pocket_works,
    guide_force,
    guide_squared,
    meet_guide,
    meet_rollers,
    pocket_force,
    rub_guide,
    rub_pockets,
)
from fem.kernels.contact_kernels import normal_forces
from fem.kernels.drive import speed_of
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine
from fem.kernels.sample_kernels import CONTACT, DISSIPATED, WORK_GRAVITY


@normal_forces.of(CagePair)
def _press(pair, rollers, disc, contacts, drive):
    meet(pair, speed_of(drive.history, drive), drive.dt)


@part
def rub_cage(pair, drive):
    """The end of a kick of the finite elements: see `rub`."""
    rub(pair, drive.dt)
    ring = pair.ring
    if ring is not None and ring.turns:
        drive.moment[1] += ring.place[0] * ring.rubbed[1] - ring.place[1] * ring.rubbed[0] + ring.rubbed[2]


@part(inlined=False)
def meet(pair, speed, dt):
    """Begin a step: end the last one's works, find the contacts, give the springs' impulses; `speed` of the shaft."""
    end_works(pair, dt)
    if pair.ring is not None and pair.ring.turns:
        pair.ring.speed[0] = speed
    find_contacts(pair, dt)


@part
def end_works(pair, dt):
    """The last step's works by the velocities that it has left."""
    cage = pair.cage
    end_pocket_works(cage, pair.riders, dt)
    end_guide_work(cage, cage.guide, pair.ring, dt)
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * cage.motion[1, 2]


@part
def find_contacts(pair, dt):
    """The contacts at these places, and their springs' impulses."""
    cage = pair.cage
    for i in range(3):
        cage.motion[2, i] = cage.motion[1, i]
        cage.impulse[i] = 0.0
    meet_rollers(cage, pair.riders, dt)
    meet_guide(cage, cage.guide, pair.ring, dt)


@part(inlined=False)
def rub(pair, dt):
    """End a kick: dashpots and friction, each solved for the velocity it leaves, in turn."""
    cage = pair.cage
    rub_pockets(cage, pair.riders, dt)
    rub_guide(cage, cage.guide, pair.ring, dt)


@kick_body.of(Cage)
def _kick(cage, drive):
    """The cage's weight, its springs' impulses, and its drag, which stops it at most."""
    velocity = cage.motion[1]
    velocity[0] += cage.impulse[0] / cage.mass
    velocity[1] += cage.impulse[1] / cage.mass - drive.gravity * drive.dt
    velocity[2] += cage.impulse[2] / cage.inertia
    most = cage.drag_torque * drive.dt
    cage.drag[0] = -min(max(cage.inertia * velocity[2], -most), most)
    velocity[2] += cage.drag[0] / cage.inertia
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * cage.motion[2, 2]


@drift_body.of(Cage)
def _drift(cage, drive):
    for i in range(3):
        cage.motion[0, i] += drive.dt * cage.motion[1, i]
    cage.frame[0], cage.frame[1] = cosine_and_sine(cage.motion[0, 2])


@add_motion.of(Cage)
def _add_motion(cage, drive, out, kinetic):
    """The cage's share of a sample's energies, and its own numbers."""
    motion, pockets, at = cage.motion, cage.pockets, cage.at
    before, after = motion[2], motion[1]
    both = cage.mass * (before[0] * after[0] + before[1] * after[1]) + cage.inertia * before[2] * after[2]
    out[kinetic] += 0.5 * both
    out[WORK_GRAVITY] -= drive.gravity * cage.mass * motion[0, 1]
    for i in range(3):
        out[at + i] = motion[0, i]
        out[at + 6 + i] = cage.lost[i]
        out[DISSIPATED] += cage.lost[i]
    out[at + 3] = 0.5 * (before[2] + after[2])
    out[at + 4], out[at + 5] = guide_force(cage.guide)
    n, stored, at = pockets.force.size, 0.0, at + N_CAGE_SCALARS
    c, s = cage.frame[0], cage.frame[1]
    for j in range(n):
        ex, ey = c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]
        x, y = pocket_force(pockets, j)
        out[at + j] = y * ex - x * ey
        out[at + n + j] = x * ex + y * ey
        out[at + 2 * n + j] = -pockets.given[1, j] * cage.roller_radius
        stored += pockets.force[j] ** 2
    out[CONTACT] += 0.5 * (stored + guide_squared(cage.guide)) / cage.stiffness
