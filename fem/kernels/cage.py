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

from fem.kernels.bodies import add_motion, drift_body, kick_body
from fem.kernels.contact_kernels import normal_forces
from fem.kernels.drive import speed_of
from fem.kernels.fields import given, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, square_root
from fem.kernels.law import kick_force
from fem.kernels.sample_kernels import CONTACT, DISSIPATED, WORK_GRAVITY

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
def half_a_work(cage, contacts, j, rates, dt):
    """Add the work of a step's dashpot and friction at the velocities of one of its ends."""
    cage.lost[DASHPOTS] -= 0.5 * dt * contacts.given[0, j] * rates[0]
    cage.lost[FRICTION] -= 0.5 * dt * contacts.given[1, j] * rates[1]


@part
def spring_kick(contacts, j, approach, stiffness, dt):
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
def dashpot(cage, closing, force, mobility_dt):
    """Force of a dashpot, N, that leaves closing − mobility·dt·force of a speed; with the spring's it never pulls."""
    return max(cage.damping * closing / (1.0 + cage.damping * mobility_dt), -force)


@part
def end_guide_work(cage, guide, ring, dt):
    if guide is not None and guide.kick[0] != 0.0:
        rates = _guide_rates(cage, guide, ring)
        guide.closing[0] = rates[0]
        half_a_work(cage, guide, 0, rates, dt)


@part
def meet_guide(cage, guide, ring, dt):
    if guide is None:
        return
    x, y = cage.motion[0, 0], cage.motion[0, 1]
    if ring is not None:
        x, y = x - ring.place[0], y - ring.place[1]
    off = sqrt(x * x + y * y)
    approach = off - cage.play
    guide.closed[0], guide.given[0, 0], guide.given[1, 0] = 0.0, 0.0, 0.0
    if approach <= 0.0 and guide.force[0] == 0.0 and guide.kick[0] == 0.0:
        guide.approach[0] = approach
        return
    guide.normal[0, 0], guide.normal[1, 0] = x / off, y / off
    guide.rates[0, 0], guide.rates[1, 0] = _guide_rates(cage, guide, ring)
    given = -dt * spring_kick(guide, 0, approach, cage.stiffness, dt)
    for i in range(2):
        cage.impulse[i] += given * guide.normal[i, 0]
    if ring is not None:
        ring.impulse[0] += -given * guide.normal[0, 0]
        ring.impulse[1] += -given * guide.normal[1, 0]
    if approach > 0.0:
        guide.closed[0] = 1.0


@part
def _guide_rates(cage, guide, ring):
    """How fast the cage moves outward against its guide, and its surface along that's, m/s."""
    x, y, turning = cage.motion[1, 0], cage.motion[1, 1], cage.motion[1, 2]
    if ring is not None:
        x, y, turning = x - ring.velocity[0], y - ring.velocity[1], turning - ring.speed[0]
    nx, ny = guide.normal[0, 0], guide.normal[1, 0]
    return x * nx + y * ny, y * nx - x * ny + turning * cage.guide_radius


@part
def rub_guide(cage, guide, ring, dt):
    if guide is None:
        return
    if ring is not None:
        for i in range(3):
            ring.rubbed[i] = 0.0
    if guide.closed[0] == 0.0:
        return
    light = 1.0 / cage.mass
    if ring is not None:
        light += 1.0 / ring.mass
    damped = dashpot(cage, _guide_rates(cage, guide, ring)[0], guide.force[0], light * dt)
    guide.given[0, 0] = -damped
    _push_by_guide(cage, guide, ring, -damped * dt, 0.0)
    slip, limit = _guide_rates(cage, guide, ring)[1], cage.friction * (guide.force[0] + damped)
    mobility = light + cage.guide_radius**2 / cage.inertia
    guide.given[1, 0] = -min(max(slip / (mobility * dt), -limit), limit)
    _push_by_guide(cage, guide, ring, 0.0, guide.given[1, 0] * dt)
    half_a_work(cage, guide, 0, (guide.rates[0, 0], guide.rates[1, 0]), dt)


@part
def _push_by_guide(cage, guide, ring, given, rubbed):
    """Impulses on the cage along the guide's normal and across it, N s, and against them on the ring."""
    nx, ny, velocity = guide.normal[0, 0], guide.normal[1, 0], cage.motion[1]
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
def guide_force(guide):
    """On the cage, N, x and y."""
    if guide is None or guide.closed[0] == 0.0:
        return 0.0, 0.0
    nx, ny = guide.normal[0, 0], guide.normal[1, 0]
    pushed, rubbed = guide.given[0, 0] - guide.force[0], guide.given[1, 0]
    return pushed * nx - rubbed * ny, pushed * ny + rubbed * nx


@part
def given_beyond(pair):
    """What the last kick of a cage's guide gave the inner ring beyond its force, N, x and y."""
    if pair is None:
        return 0.0, 0.0
    if pair.cage.guide is None or pair.ring is None or not pair.ring.turns:
        return 0.0, 0.0
    more = pair.cage.guide.kick[0] - pair.cage.guide.force[0]
    return more * pair.cage.guide.normal[0, 0], more * pair.cage.guide.normal[1, 0]


@part
def push_ring_as_a_whole(ring):
    """The guiding ring's velocity by what the guide has given it, where it has no mesh that is kicked."""
    if ring is not None:
        for k in range(2):
            ring.velocity[k] += ring.impulse[k] / ring.mass
            ring.impulse[k] = 0.0


@part
def end_pocket_works(cage, riders, dt):
    """The works of the step behind, now that the velocities at its end are known."""
    pockets = cage.pockets
    for j in range(riders.n):
        if pockets.kick[j] != 0.0:
            rates = _pocket_rates(cage, riders, j)
            pockets.closing[j] = rates[0]
            half_a_work(cage, pockets, j, rates, dt)


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
def meet_rollers(cage, riders, dt):
    """Find what touches, eight rollers at a time: most are in the middle of their pockets, which costs no more."""
    pockets = cage.pockets
    _off_middles(cage, cage.guide, riders)
    for j in range(riders.n):
        approach = cage.off[j] - cage.half_clearance
        pockets.closed[j], pockets.given[0, j], pockets.given[1, j] = 0.0, 0.0, 0.0
        if approach <= 0.0 and pockets.force[j] == 0.0 and pockets.kick[j] == 0.0:
            pockets.approach[j] = approach
        else:
            _meet_roller(cage, pockets, riders, j, approach, dt)


@part
def _off_middles(cage, guide, riders):
    """How far all rollers are off their pockets' middles, m."""
    c, s = cage.frame[0], cage.frame[1]
    for group in range(0, riders.n, WIDTH):
        ex = c * load(cage.cosine, group) - s * load(cage.sine, group)
        ey = s * load(cage.cosine, group) + c * load(cage.sine, group)
        x = load(riders.centre, group) - cage.motion[0, 0]
        y = load(riders.centre, riders.centre.shape[1] + group) - cage.motion[0, 1]
        if guide is None:
            x, y = x - cage.pitch_radius * ex, y - cage.pitch_radius * ey
            store(cage.off, group, square_root(x * x + y * y))
        else:
            store(cage.off, group, absolute(y * ex - x * ey))


@part
def _normal(cage, guide, j, x, y):
    """Of the wall of pocket j that a roller at x, y from the cage's centre meets."""
    c, s = cage.frame[0], cage.frame[1]
    ex, ey = c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]
    if guide is None:
        over = 1.0 / max(cage.off[j], SMALLEST)
        return over * (x - cage.pitch_radius * ex), over * (y - cage.pitch_radius * ey)
    side = 1.0 if y * ex > x * ey else -1.0
    return -side * ey, side * ex


@part
def _meet_roller(cage, pockets, riders, j, approach, dt):
    x, y = riders.centre[0, j] - cage.motion[0, 0], riders.centre[1, j] - cage.motion[0, 1]
    nx, ny = _normal(cage, cage.guide, j, x, y)
    pockets.normal[0, j], pockets.normal[1, j] = nx, ny
    pockets.arm[0, j], pockets.arm[1, j] = x * ny - y * nx, -(x * nx + y * ny) - riders.radius
    pockets.rates[0, j], pockets.rates[1, j] = _pocket_rates(cage, riders, j)
    given = -dt * spring_kick(pockets, j, approach, cage.stiffness, dt)
    riders.body_impulse[0, j] += given * nx
    riders.body_impulse[1, j] += given * ny
    cage.impulse[0] -= given * nx
    cage.impulse[1] -= given * ny
    cage.impulse[2] -= given * pockets.arm[0, j]
    if approach > 0.0:
        pockets.closed[j] = 1.0


@part
def rub_pockets(cage, riders, dt):
    """Dashpots and friction of all pockets, each solved for the velocity it leaves, in turn."""
    pockets, over = cage.pockets, 1.0 / cage.mass
    for j in range(riders.n):
        if pockets.closed[j] == 0.0:
            continue
        light, inertia = 1.0 / riders.mass + over, _inertia(riders.swelling, riders.inertia, j)
        mobility = light + pockets.arm[0, j] ** 2 / cage.inertia
        damped = dashpot(cage, _pocket_rates(cage, riders, j)[0], pockets.force[j], mobility * dt)
        pockets.given[0, j] = -damped
        _push_roller(cage, riders, j, -damped * dt, 0.0)
        mobility = light + riders.radius**2 / inertia + pockets.arm[1, j] ** 2 / cage.inertia
        slip, limit = _pocket_rates(cage, riders, j)[1], cage.friction * (pockets.force[j] + damped)
        pockets.given[1, j] = -min(max(slip / (mobility * dt), -limit), limit)
        _push_roller(cage, riders, j, 0.0, pockets.given[1, j] * dt)
        half_a_work(cage, pockets, j, (pockets.rates[0, j], pockets.rates[1, j]), dt)


@part
def _inertia(swelling, inertia, j):
    """Of a roller as it is: friction then gives it the angular momentum that it takes from the cage."""
    return inertia if swelling is None else inertia + swelling[j]


@part
def _push_roller(cage, riders, j, given, rubbed):
    """Impulses on roller j along its contact's normal and across it, N s, and against them on the cage."""
    pockets, velocity = cage.pockets, cage.motion[1]
    nx, ny = pockets.normal[0, j], pockets.normal[1, j]
    x, y = given * nx + rubbed * ny, given * ny - rubbed * nx
    riders.velocity[0, j] += x / riders.mass
    riders.velocity[1, j] += y / riders.mass
    riders.turn_kick[j] -= rubbed * riders.radius / _inertia(riders.swelling, riders.inertia, j)
    velocity[0] -= x / cage.mass
    velocity[1] -= y / cage.mass
    velocity[2] -= (given * pockets.arm[0, j] + rubbed * pockets.arm[1, j]) / cage.inertia


@part
def pocket_force(pockets, j):
    """On roller j, N, x and y."""
    if pockets.closed[j] == 0.0:
        return 0.0, 0.0
    nx, ny, pushed, rubbed = pockets.normal[0, j], pockets.normal[1, j], pockets.given[0, j], pockets.given[1, j]
    pushed -= pockets.force[j]
    return pushed * nx + rubbed * ny, pushed * ny - rubbed * nx


# the steps of a cage


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
    cage = pair.cage
    end_pocket_works(cage, pair.riders, dt)
    end_guide_work(cage, cage.guide, pair.ring, dt)
    cage.lost[DRAG] -= 0.5 * cage.drag[0] * cage.motion[1, 2]
    if pair.ring is not None and pair.ring.turns:
        pair.ring.speed[0] = speed
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
    if cage.guide is not None:
        stored += cage.guide.force[0] ** 2
    out[CONTACT] += 0.5 * stored / cage.stiffness
