"""THE CAGE, a rigid one: what its pockets and its guide do to it, to rollers and to the hub, in a step of leapfrog.

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

from math import sqrt
from typing import NamedTuple

import numpy as np

from fem.kernels.columns import CONTACT, DISSIPATED, KINETIC, WORK_GRAVITY
from fem.kernels.fields import given, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine, load_pair
from fem.kernels.lanes import WIDTH, absolute, load, square_root, store
from fem.kernels.law import kick_force

DASHPOTS, FRICTION, DRAG = 0, 1, 2  # of `Cage.lost`
# of a sample, in this order: place, angle, speed, guide's force, losses; then three blocks of rollers
N_CAGE_SCALARS = 9
SMALLEST = 1e-30  # m


class Riders(NamedTuple):
    """Rollers, as a cage meets them."""

    centre: np.ndarray  # (2, columns), m
    velocity: np.ndarray  # (2, columns), m/s, at t − dt/2; after the kick at t + dt/2
    spin: np.ndarray  # (columns,), rad/s, likewise
    node_impulse: np.ndarray  # (2, columns), N s, of this step, not in the velocity yet
    body_impulse: np.ndarray  # (2, columns), N s, of this step, which the kick takes
    turn_kick: np.ndarray  # (columns,), rad/s, of this step, not in the spin yet
    n: int
    mass: float
    inertia: float
    radius: float
    swelling: np.ndarray | None  # (columns,), kg m², inertia gained by deformation; None: rigid


class GuidingRing(NamedTuple):
    """A ring that guides the cage: the inner one, which is the hub, or the outer one in a housing that moves."""

    place: np.ndarray  # (2,), m
    velocity: np.ndarray  # (2,), m/s
    impulse: np.ndarray  # (2,), N s, of this step, which the kick takes
    rubbed: state("3")  # N s, of this step, in the velocity already; N m s about its centre
    mass: float  # kg; in finite elements, which kick it by themselves, a `late_mass`, see `shaft`
    speed: state("1")  # rad/s, in this step
    turns: bool  # with the shaft


class CageContacts(NamedTuple):
    """Contacts of a cage: in its pockets, or with its guide. Forces are those on the rollers, or on the cage by its
    guide, along a contact's normal n and across it: there along (n_y, −n_x) of a roller, (−n_y, n_x) of the guide."""

    approach: state("n", np.nan)  # m, at the last kick; negative: apart, NaN: not known
    force: state("n")  # N, of the spring, >= 0
    kick: state("n")  # N, that the last kick gave: see `law.kick_force`
    residual: state("n")  # J, likewise
    normal: state("2, n")  # unit, from the pocket to the roller's surface, or from the guide to the cage
    arm: state("2, n")  # m, at which forces along and across turn the cage
    closed: state("n")  # 1 or 0
    rates: state("2, n")  # m/s, before the kick, along and across
    closing: state("n")  # m/s, on the way here along the last step's normal
    given: state("2, n")  # N, by dashpot and by friction


class Cage(NamedTuple):
    """A rigid ring. Rows of `motion`: place, m, and angle; its velocity at t − dt/2; that before the last kick."""

    motion: state("3, 3")
    impulse: state("3")  # N s and N m s, of this step
    lost: state("3")  # J, so far: in dashpots, by friction, by drag
    drag: state("1")  # N m s, of this step
    frame: state("2")  # cosine and sine of the angle
    cosine: given("columns")  # of the pockets' angles at t = 0
    sine: given("columns")
    off: state("columns")  # m, of rollers off their pockets' middles
    pockets: CageContacts
    guide: CageContacts | None  # None: rollers guide it
    mass: float  # kg
    inertia: float  # kg m²
    pitch_radius: float  # m, of the pockets' middles
    roller_radius: float  # m
    half_clearance: float  # m, of pockets
    play: float  # m, half the guide's clearance
    guide_radius: float  # m, at which the guide rubs; negative where the cage's bore is around it
    stiffness: float  # N/m
    damping: float  # N s/m
    friction: float
    drag_torque: float  # N m
    at: int  # place of its first number in a sample


class CagePair(NamedTuple):
    """A cage, its rollers, and the ring that guides it."""

    cage: Cage
    riders: Riders
    ring: GuidingRing | None  # None: no ring guides the cage, or one that stands still


@part
def _add_half_works(cage, contacts, j, rates, dt):
    """Add the work of a step's dashpot and friction at the velocities of one of its ends."""
    cage.lost[DASHPOTS] -= 0.5 * dt * contacts.given[0, j] * rates[0]
    cage.lost[FRICTION] -= 0.5 * dt * contacts.given[1, j] * rates[1]


@part
def _spring_kick(contacts, j, approach, stiffness, dt):
    """What a kick gives of a contact's spring, N: see `law.kick_force`, of which this is the linear law.

    A kick's work is along its own normal, and normals turn: what that differs from the approach's change is residual
    energy too.
    """
    force, last, before = stiffness * max(approach, 0.0), contacts.kick[j], contacts.approach[j]
    state = before, contacts.force[j], 0.0, last, contacts.residual[j]
    kick, residual = kick_force((1.0, 0.0), state, (approach, force, 0.0))
    if before == before:
        step, coming = approach - before, contacts.rates[0, j]
        residual -= 0.5 * ((dt * contacts.closing[j] - step) * last + (dt * coming - step) * kick)
    contacts.approach[j], contacts.force[j], contacts.kick[j], contacts.residual[j] = approach, force, kick, residual
    return kick


@part
def _is_apart(contacts, j, approach):
    """Clear a contact's last step; whether it neither pushes nor has pushed."""
    contacts.closed[j] = 1.0 if approach > 0.0 else 0.0
    contacts.given[0, j], contacts.given[1, j] = 0.0, 0.0
    if approach <= 0.0 and contacts.force[j] == 0.0 and contacts.kick[j] == 0.0:
        contacts.approach[j] = approach
        return True
    return False


@part
def _pocket_rates(cage, riders, j):
    """Of roller j: how fast it closes its contact, and its surface along the wall, m/s."""
    pockets, velocity, over = cage.pockets, cage.motion[1], 1.0 / riders.mass
    nx, ny = pockets.normal[0, j], pockets.normal[1, j]
    x = riders.velocity[0, j] + over * riders.node_impulse[0, j] - velocity[0]
    y = riders.velocity[1, j] + over * riders.node_impulse[1, j] - velocity[1]
    along = x * nx + y * ny - velocity[2] * pockets.arm[0, j]
    turning = (riders.spin[j] + riders.turn_kick[j]) * riders.radius
    return along, x * ny - y * nx - turning - velocity[2] * pockets.arm[1, j]


@part
def _guide_rates(cage, ring):
    """How fast the cage moves outward against its guide, and its surface along that's, m/s."""
    x, y, turning = cage.motion[1, 0], cage.motion[1, 1], cage.motion[1, 2]
    if ring is not None:
        x, y, turning = x - ring.velocity[0], y - ring.velocity[1], turning - ring.speed[0]
    nx, ny = cage.guide.normal[0, 0], cage.guide.normal[1, 0]
    return x * nx + y * ny, y * nx - x * ny + turning * cage.guide_radius


@part(inlined=False)
def meet(pair, speed, dt):
    """Begin a step: end the last one's works, find the contacts, give the springs' impulses; `speed` of the shaft."""
    cage, riders, ring = pair.cage, pair.riders, pair.ring
    pockets, guide, motion = cage.pockets, cage.guide, cage.motion
    for j in range(riders.n):  # works of the step behind, now that the velocities at its end are known
        if pockets.kick[j] != 0.0:
            rates = _pocket_rates(cage, riders, j)
            pockets.closing[j] = rates[0]
            _add_half_works(cage, pockets, j, rates, dt)
    if guide is not None:
        if guide.kick[0] != 0.0:
            rates = _guide_rates(cage, ring)
            guide.closing[0] = rates[0]
            _add_half_works(cage, guide, 0, rates, dt)
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * motion[1, 2]
    if ring is not None:
        if ring.turns:
            ring.speed[0] = speed
    for i in range(3):
        motion[2, i] = motion[1, i]
        cage.impulse[i] = 0.0
    _find_off(cage, riders)
    for j in range(riders.n):
        approach = cage.off[j] - cage.half_clearance
        if not _is_apart(pockets, j, approach):
            _meet_roller(cage, riders, j, approach, dt)
    if guide is not None:
        _meet_guide(cage, ring, dt)


@part
def _find_off(cage, riders):
    """How far rollers are off their pockets' middles, m, eight at a time: most are there, which costs no more."""
    c, s = cage.frame[0], cage.frame[1]
    for group in range(0, riders.n, WIDTH):
        ex = c * load(cage.cosine, group) - s * load(cage.sine, group)
        ey = s * load(cage.cosine, group) + c * load(cage.sine, group)
        x, y = load_pair(riders.centre, group, riders.centre.shape[1])
        x, y = x - cage.motion[0, 0], y - cage.motion[0, 1]
        if cage.guide is None:
            x, y = x - cage.pitch_radius * ex, y - cage.pitch_radius * ey
            store(cage.off, group, square_root(x * x + y * y))
        else:
            store(cage.off, group, absolute(y * ex - x * ey))


@part
def _meet_roller(cage, riders, j, approach, dt):
    pockets, c, s = cage.pockets, cage.frame[0], cage.frame[1]
    x, y = riders.centre[0, j] - cage.motion[0, 0], riders.centre[1, j] - cage.motion[0, 1]
    ex, ey = c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]
    if cage.guide is None:
        over = 1.0 / max(cage.off[j], SMALLEST)
        nx, ny = over * (x - cage.pitch_radius * ex), over * (y - cage.pitch_radius * ey)
    else:
        side = 1.0 if y * ex > x * ey else -1.0
        nx, ny = -side * ey, side * ex
    pockets.normal[0, j], pockets.normal[1, j] = nx, ny
    pockets.arm[0, j], pockets.arm[1, j] = x * ny - y * nx, -(x * nx + y * ny) - riders.radius
    pockets.rates[0, j], pockets.rates[1, j] = _pocket_rates(cage, riders, j)
    given = -dt * _spring_kick(pockets, j, approach, cage.stiffness, dt)
    riders.body_impulse[0, j] += given * nx
    riders.body_impulse[1, j] += given * ny
    cage.impulse[0] -= given * nx
    cage.impulse[1] -= given * ny
    cage.impulse[2] -= given * pockets.arm[0, j]


@part
def _meet_guide(cage, ring, dt):
    guide, x, y = cage.guide, cage.motion[0, 0], cage.motion[0, 1]
    if ring is not None:
        x, y = x - ring.place[0], y - ring.place[1]
    off = sqrt(x * x + y * y)
    if _is_apart(guide, 0, off - cage.play):
        return
    guide.normal[0, 0], guide.normal[1, 0] = x / off, y / off
    guide.rates[0, 0], guide.rates[1, 0] = _guide_rates(cage, ring)
    given = -dt * _spring_kick(guide, 0, off - cage.play, cage.stiffness, dt)
    for i in range(2):
        cage.impulse[i] += given * guide.normal[i, 0]
        if ring is not None:
            ring.impulse[i] -= given * guide.normal[i, 0]


@part(inlined=False)
def rub(pair, dt):
    """End a kick: dashpots and friction, each solved for the velocity it leaves, in turn."""
    cage, riders, ring = pair.cage, pair.riders, pair.ring
    pockets, guide = cage.pockets, cage.guide
    for j in range(riders.n):
        if pockets.closed[j] != 0.0:
            inertia = riders.inertia if riders.swelling is None else riders.inertia + riders.swelling[j]
            light = 1.0 / riders.mass + 1.0 / cage.mass
            mobility = light + pockets.arm[0, j] ** 2 / cage.inertia
            damped = _dashpot(cage, _pocket_rates(cage, riders, j)[0], pockets.force[j], mobility * dt)
            pockets.given[0, j] = -damped
            _push_roller(cage, riders, j, inertia, -damped * dt, 0.0)
            mobility = light + riders.radius**2 / inertia + pockets.arm[1, j] ** 2 / cage.inertia
            slip, limit = _pocket_rates(cage, riders, j)[1], cage.friction * (pockets.force[j] + damped)
            pockets.given[1, j] = -min(max(slip / (mobility * dt), -limit), limit)
            _push_roller(cage, riders, j, inertia, 0.0, pockets.given[1, j] * dt)
            _add_half_works(cage, pockets, j, (pockets.rates[0, j], pockets.rates[1, j]), dt)
    if guide is not None:
        if ring is not None:
            for i in range(3):
                ring.rubbed[i] = 0.0
        if guide.closed[0] != 0.0:
            light = 1.0 / cage.mass
            if ring is not None:
                light += 1.0 / ring.mass
            damped = _dashpot(cage, _guide_rates(cage, ring)[0], guide.force[0], light * dt)
            guide.given[0, 0] = -damped
            _push_by_guide(cage, ring, -damped * dt, 0.0)
            slip, limit = _guide_rates(cage, ring)[1], cage.friction * (guide.force[0] + damped)
            mobility = light + cage.guide_radius**2 / cage.inertia
            guide.given[1, 0] = -min(max(slip / (mobility * dt), -limit), limit)
            _push_by_guide(cage, ring, 0.0, guide.given[1, 0] * dt)
            _add_half_works(cage, guide, 0, (guide.rates[0, 0], guide.rates[1, 0]), dt)


@part
def _dashpot(cage, closing, force, mobility_dt):
    """Force of a dashpot, N, that leaves closing − mobility·dt·force of a speed; with the spring's it never pulls."""
    return max(cage.damping * closing / (1.0 + cage.damping * mobility_dt), -force)


@part
def _push_roller(cage, riders, j, inertia, given, rubbed):
    """Impulses on roller j along its contact's normal and across it, N s, and against them on the cage.

    `inertia` : kg m², of a roller as it is: friction then gives it the angular momentum that it takes from the cage
    """
    pockets, velocity = cage.pockets, cage.motion[1]
    nx, ny = pockets.normal[0, j], pockets.normal[1, j]
    x, y = given * nx + rubbed * ny, given * ny - rubbed * nx
    riders.velocity[0, j] += x / riders.mass
    riders.velocity[1, j] += y / riders.mass
    riders.turn_kick[j] -= rubbed * riders.radius / inertia
    velocity[0] -= x / cage.mass
    velocity[1] -= y / cage.mass
    velocity[2] -= (given * pockets.arm[0, j] + rubbed * pockets.arm[1, j]) / cage.inertia


@part
def _push_by_guide(cage, ring, given, rubbed):
    """Impulses on the cage along the guide's normal and across it, N s, and against them on the ring."""
    nx, ny, velocity = cage.guide.normal[0, 0], cage.guide.normal[1, 0], cage.motion[1]
    x, y = given * nx - rubbed * ny, given * ny + rubbed * nx
    velocity[0] += x / cage.mass
    velocity[1] += y / cage.mass
    velocity[2] += rubbed * cage.guide_radius / cage.inertia
    if ring is not None:
        ring.velocity[0] -= x / ring.mass
        ring.velocity[1] -= y / ring.mass
        ring.rubbed[0] -= x
        ring.rubbed[1] -= y
        ring.rubbed[2] -= rubbed * cage.guide_radius


@part
def kick_cage(cage, drive):
    """The cage's weight, its springs' impulses, and its drag, which stops it at most."""
    velocity = cage.motion[1]
    velocity[0] += cage.impulse[0] / cage.mass
    velocity[1] += cage.impulse[1] / cage.mass - drive.gravity * drive.dt
    velocity[2] += cage.impulse[2] / cage.inertia
    most = cage.drag_torque * drive.dt
    cage.drag[0] = -min(max(cage.inertia * velocity[2], -most), most)
    velocity[2] += cage.drag[0] / cage.inertia
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * cage.motion[2, 2]


@part
def drift_cage(cage, drive):
    """Advance the cage's place and angle by one step."""
    for i in range(3):
        cage.motion[0, i] += drive.dt * cage.motion[1, i]
    cage.frame[0], cage.frame[1] = cosine_and_sine(cage.motion[0, 2])


@part
def _force(contacts, j, sense):
    """Of a contact on the roller (sense 1) or, by its guide, on the cage (−1), N, x and y."""
    if contacts.closed[j] == 0.0:
        return 0.0, 0.0
    nx, ny, rubbed = contacts.normal[0, j], contacts.normal[1, j], sense * contacts.given[1, j]
    pushed = contacts.given[0, j] - contacts.force[j]
    return pushed * nx + rubbed * ny, pushed * ny - rubbed * nx


@part
def write_cage(cage, drive, out):
    """The cage's share of a sample's energies, and its own numbers."""
    motion, pockets, guide, at = cage.motion, cage.pockets, cage.guide, cage.at
    before, after = motion[2], motion[1]
    both = cage.mass * (before[0] * after[0] + before[1] * after[1]) + cage.inertia * before[2] * after[2]
    out[KINETIC] += 0.5 * both
    out[WORK_GRAVITY] -= drive.gravity * cage.mass * motion[0, 1]
    for i in range(3):
        out[at + i] = motion[0, i]
        out[at + 6 + i] = cage.lost[i]
        out[DISSIPATED] += cage.lost[i]
    out[at + 3] = 0.5 * (before[2] + after[2])
    out[at + 4] = out[at + 5] = 0.0
    if guide is not None:
        out[at + 4], out[at + 5] = _force(guide, 0, -1.0)
    n, stored, at = pockets.force.size, 0.0, at + N_CAGE_SCALARS
    c, s = cage.frame[0], cage.frame[1]
    for j in range(n):
        ex, ey = c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]
        x, y = _force(pockets, j, 1.0)
        out[at + j] = y * ex - x * ey
        out[at + n + j] = x * ex + y * ey
        out[at + 2 * n + j] = -pockets.given[1, j] * cage.roller_radius
        stored += pockets.force[j] ** 2
    if guide is not None:
        stored += guide.force[0] ** 2
    out[CONTACT] += 0.5 * stored / cage.stiffness
