"""Rollers in their pockets: how far off the middle, how fast, and what they and the cage give each other."""

from fem.kernels.cage_contacts import dashpot, half_a_work, spring_kick
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, magnitude, root

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
        store(cage.off, group, _off_middle(cage, guide, x, y, ex, ey))


@part
def _off_middle(cage, guide, x, y, ex, ey):
    """Of eight rollers at x, y from the cage's centre, whose pockets lie in these directions."""
    if guide is None:
        x, y = x - cage.pitch_radius * ex, y - cage.pitch_radius * ey
        return root(x * x + y * y)
    return magnitude(y * ex - x * ey)


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
