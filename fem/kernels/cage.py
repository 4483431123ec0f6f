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
    """Contacts of a cage: in its pockets, or with its guide. Forces are those on the rollers, or on the guide, along a
    contact's normal n and across it, along (n_y, −n_x)."""

    approach: state("n", np.nan)  # m, at the last kick; negative: apart, NaN: not known
    force: state("n")  # N, of the spring, >= 0
    kick: state("n")  # N, that the last kick gave: see `law.kick_force`
    residual: state("n")  # J, likewise
    normal: state("2, n")  # unit, from the pocket to the roller's surface, or from the cage to the guide
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
def _rates(pair, contacts, j, riders):
    """How fast roller j closes its contact, and its surface along the wall, m/s; `riders` None: those of the guide.

    The guide is as a roller with the radius of its circle, negative: it lies around its surface.
    """
    cage, ring, velocity, x, y, turning = pair.cage, pair.ring, pair.cage.motion[1], 0.0, 0.0, 0.0
    if riders is not None:
        over = 1.0 / riders.mass
        x = riders.velocity[0, j] + over * riders.node_impulse[0, j]
        y = riders.velocity[1, j] + over * riders.node_impulse[1, j]
        turning = (riders.spin[j] + riders.turn_kick[j]) * riders.radius
    elif ring is not None:
        x, y, turning = ring.velocity[0], ring.velocity[1], -ring.speed[0] * cage.guide_radius
    nx, ny, x, y = contacts.normal[0, j], contacts.normal[1, j], x - velocity[0], y - velocity[1]
    along = x * nx + y * ny - velocity[2] * contacts.arm[0, j]
    return along, x * ny - y * nx - turning - velocity[2] * contacts.arm[1, j]


@part
def _press(pair, contacts, j, riders, approach, dt):
    """A spring's impulses at a contact with a normal and arms."""
    cage, ring = pair.cage, pair.ring
    contacts.rates[0, j], contacts.rates[1, j] = _rates(pair, contacts, j, riders)
    given = -dt * _spring_kick(contacts, j, approach, cage.stiffness, dt)
    for i in range(2):
        if riders is not None:
            riders.body_impulse[i, j] += given * contacts.normal[i, j]
        elif ring is not None:
            ring.impulse[i] += given * contacts.normal[i, j]
        cage.impulse[i] -= given * contacts.normal[i, j]
    cage.impulse[2] -= given * contacts.arm[0, j]


@part
def _end_works(pair, contacts, j, riders, dt):
    """Works of the step behind, now that the velocities at its end are known."""
    if contacts.kick[j] != 0.0:
        rates = _rates(pair, contacts, j, riders)
        contacts.closing[j] = rates[0]
        _add_half_works(pair.cage, contacts, j, rates, dt)


@part(inlined=False)
def meet(pair, speed, dt):
    """Begin a step: end the last one's works, find the contacts, give the springs' impulses; `speed` of the shaft."""
    cage, riders, ring = pair.cage, pair.riders, pair.ring
    pockets, guide, motion = cage.pockets, cage.guide, cage.motion
    for j in range(riders.n):
        _end_works(pair, pockets, j, riders, dt)
    if guide is not None:
        _end_works(pair, guide, 0, None, dt)
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * motion[1, 2]
    if ring is not None:
        if ring.turns:
            ring.speed[0] = speed
    for i in range(3):
        motion[2, i] = motion[1, i]
        cage.impulse[i] = 0.0
    c, s, middle_x, middle_y = cage.frame[0], cage.frame[1], motion[0, 0], motion[0, 1]
    for group in range(0, riders.n, WIDTH):  # off their pockets' middles, m: most are there, and eight cost no more
        ex = c * load(cage.cosine, group) - s * load(cage.sine, group)
        ey = s * load(cage.cosine, group) + c * load(cage.sine, group)
        x, y = load_pair(riders.centre, group, riders.centre.shape[1])
        x, y = x - middle_x, y - middle_y
        if guide is None:
            x, y = x - cage.pitch_radius * ex, y - cage.pitch_radius * ey
            store(cage.off, group, square_root(x * x + y * y))
        else:
            store(cage.off, group, absolute(y * ex - x * ey))
    for j in range(riders.n):
        approach = cage.off[j] - cage.half_clearance
        if not _is_apart(pockets, j, approach):
            _meet_roller(pair, riders, j, approach, dt)
    if guide is not None:
        out_x, out_y = middle_x, middle_y
        if ring is not None:
            out_x, out_y = out_x - ring.place[0], out_y - ring.place[1]
        off = sqrt(out_x * out_x + out_y * out_y)
        if not _is_apart(guide, 0, off - cage.play):
            guide.normal[0, 0], guide.normal[1, 0], guide.arm[1, 0] = -out_x / off, -out_y / off, cage.guide_radius
            _press(pair, guide, 0, None, off - cage.play, dt)


@part
def _direction(cage, j):
    """Of a pocket's middle from the cage's."""
    c, s = cage.frame[0], cage.frame[1]
    return c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]


@part
def _meet_roller(pair, riders, j, approach, dt):
    cage, pockets, (ex, ey) = pair.cage, pair.cage.pockets, _direction(pair.cage, j)
    x, y = riders.centre[0, j] - cage.motion[0, 0], riders.centre[1, j] - cage.motion[0, 1]
    if cage.guide is None:
        over = 1.0 / max(cage.off[j], SMALLEST)
        nx, ny = over * (x - cage.pitch_radius * ex), over * (y - cage.pitch_radius * ey)
    else:
        side = 1.0 if y * ex > x * ey else -1.0
        nx, ny = -side * ey, side * ex
    pockets.normal[0, j], pockets.normal[1, j] = nx, ny
    pockets.arm[0, j], pockets.arm[1, j] = x * ny - y * nx, -(x * nx + y * ny) - riders.radius
    _press(pair, pockets, j, riders, approach, dt)


@part(inlined=False)
def rub(pair, dt):
    """End a kick: dashpots and friction, each solved for the velocity it leaves, in turn."""
    guide, ring = pair.cage.guide, pair.ring
    for j in range(pair.riders.n):
        _rub(pair, pair.cage.pockets, j, pair.riders, dt)
    if guide is not None:
        if ring is not None:
            for i in range(3):
                ring.rubbed[i] = 0.0
        _rub(pair, guide, 0, None, dt)


@part
def _rub(pair, contacts, j, riders, dt):
    """Dashpot and friction of a contact; with the spring's force the dashpot's never pulls."""
    cage, ring, light, turning, inertia = pair.cage, pair.ring, 1.0 / pair.cage.mass, 0.0, 1.0
    if contacts.closed[j] == 0.0:
        return
    if riders is not None:  # of a roller as it is: friction then gives it the angular momentum that the cage loses
        inertia = riders.inertia if riders.swelling is None else riders.inertia + riders.swelling[j]
        light, turning = 1.0 / riders.mass + light, riders.radius**2 / inertia
    elif ring is not None:
        light += 1.0 / ring.mass
    mobility = (light + contacts.arm[0, j] ** 2 / cage.inertia) * dt
    damped = cage.damping * _rates(pair, contacts, j, riders)[0] / (1.0 + cage.damping * mobility)
    damped = max(damped, -contacts.force[j])
    contacts.given[0, j] = -damped
    _push(pair, contacts, j, riders, inertia, -damped * dt, 0.0)
    mobility = light + turning + contacts.arm[1, j] ** 2 / cage.inertia
    slip, limit = _rates(pair, contacts, j, riders)[1], cage.friction * (contacts.force[j] + damped)
    contacts.given[1, j] = -min(max(slip / (mobility * dt), -limit), limit)
    _push(pair, contacts, j, riders, inertia, 0.0, contacts.given[1, j] * dt)
    _add_half_works(cage, contacts, j, (contacts.rates[0, j], contacts.rates[1, j]), dt)


@part
def _push(pair, contacts, j, riders, inertia, given, rubbed):
    """Impulses on roller j, or on the guide, along its contact's normal and across it, N s, and against them on the
    cage; `inertia` : kg m², of the roller."""
    cage, ring, velocity = pair.cage, pair.ring, pair.cage.motion[1]
    nx, ny = contacts.normal[0, j], contacts.normal[1, j]
    x, y = given * nx + rubbed * ny, given * ny - rubbed * nx
    if riders is not None:
        riders.velocity[0, j] += x / riders.mass
        riders.velocity[1, j] += y / riders.mass
        riders.turn_kick[j] -= rubbed * riders.radius / inertia
    elif ring is not None:
        ring.velocity[0] += x / ring.mass
        ring.velocity[1] += y / ring.mass
        ring.rubbed[0] += x
        ring.rubbed[1] += y
        ring.rubbed[2] += rubbed * cage.guide_radius
    velocity[0] -= x / cage.mass
    velocity[1] -= y / cage.mass
    velocity[2] -= (given * contacts.arm[0, j] + rubbed * contacts.arm[1, j]) / cage.inertia


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
def _force(contacts, j):
    """Of a contact on the roller, or on the guide, N, x and y."""
    if contacts.closed[j] == 0.0:
        return 0.0, 0.0
    nx, ny, pushed = contacts.normal[0, j], contacts.normal[1, j], contacts.given[0, j] - contacts.force[j]
    return pushed * nx + contacts.given[1, j] * ny, pushed * ny - contacts.given[1, j] * nx


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
        x, y = _force(guide, 0)
        out[at + 4], out[at + 5] = -x, -y
    n, stored, at = pockets.force.size, 0.0, at + N_CAGE_SCALARS
    for j in range(n):
        (ex, ey), (x, y) = _direction(cage, j), _force(pockets, j)
        out[at + j] = y * ex - x * ey
        out[at + n + j] = x * ex + y * ey
        out[at + 2 * n + j] = -pockets.given[1, j] * cage.roller_radius
        stored += pockets.force[j] ** 2
    if guide is not None:
        stored += guide.force[0] ** 2
    out[CONTACT] += 0.5 * stored / cage.stiffness
