"""Rollers in their pockets: how far off the middle, how fast, and what they and the cage give each other."""

from math import sqrt

from fem.kernels.cage_contacts import dashpot, half_a_work, spring_kick
from fem.kernels.jit import part

SMALLEST = 1e-30  # m


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
def _off_middle(cage, guide, j, x, y):
    """How far a roller at x, y from the cage's centre is off its pocket's middle, m, and in which direction."""
    c, s = cage.frame[0], cage.frame[1]
    ex, ey = c * cage.cosine[j] - s * cage.sine[j], s * cage.cosine[j] + c * cage.sine[j]
    if guide is None:
        x, y = x - cage.pitch_radius * ex, y - cage.pitch_radius * ey
        off = sqrt(x * x + y * y)
        over = 1.0 / max(off, SMALLEST)
        return off, x * over, y * over
    ahead = y * ex - x * ey
    side = 1.0 if ahead > 0.0 else -1.0
    return abs(ahead), -side * ey, side * ex


@part
def meet_rollers(cage, riders, dt):
    for j in range(riders.n):
        _meet_roller(cage, cage.pockets, riders, j, dt)


@part
def _meet_roller(cage, pockets, riders, j, dt):
    x, y = riders.centre[0, j] - cage.motion[0, 0], riders.centre[1, j] - cage.motion[0, 1]
    off, nx, ny = _off_middle(cage, cage.guide, j, x, y)
    approach = off - cage.half_clearance
    pockets.closed[j], pockets.given[0, j], pockets.given[1, j] = 0.0, 0.0, 0.0
    if approach <= 0.0 and pockets.force[j] == 0.0 and pockets.kick[j] == 0.0:
        pockets.approach[j] = approach
        return
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
        light = 1.0 / riders.mass + over
        mobility = light + pockets.arm[0, j] ** 2 / cage.inertia
        damped = dashpot(cage, _pocket_rates(cage, riders, j)[0], pockets.force[j], mobility * dt)
        pockets.given[0, j] = -damped
        _push_roller(cage, riders, j, -damped * dt, 0.0)
        mobility = light + riders.radius**2 / riders.inertia + pockets.arm[1, j] ** 2 / cage.inertia
        slip, limit = _pocket_rates(cage, riders, j)[1], cage.friction * (pockets.force[j] + damped)
        pockets.given[1, j] = -min(max(slip / (mobility * dt), -limit), limit)
        _push_roller(cage, riders, j, 0.0, pockets.given[1, j] * dt)
        half_a_work(cage, pockets, j, (pockets.rates[0, j], pockets.rates[1, j]), dt)


@part
def _push_roller(cage, riders, j, given, rubbed):
    """Impulses on roller j along its contact's normal and across it, N s, and against them on the cage."""
    pockets, velocity = cage.pockets, cage.motion[1]
    nx, ny = pockets.normal[0, j], pockets.normal[1, j]
    x, y = given * nx + rubbed * ny, given * ny - rubbed * nx
    riders.velocity[0, j] += x / riders.mass
    riders.velocity[1, j] += y / riders.mass
    riders.turn_kick[j] -= rubbed * riders.radius / riders.inertia
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
