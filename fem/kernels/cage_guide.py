"""A cage and the ring that guides it: a circle in a circle."""

from math import sqrt

from fem.kernels.cage_contacts import dashpot, half_a_work, spring_kick
from fem.kernels.jit import part


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
    _push_ring(ring, -given * guide.normal[0, 0], -given * guide.normal[1, 0])
    if approach > 0.0:
        guide.closed[0] = 1.0


@part
def _push_ring(ring, x, y):
    if ring is not None:
        ring.impulse[0] += x
        ring.impulse[1] += y


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
    _clear_ring(ring)
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
def _clear_ring(ring):
    if ring is not None:
        for i in range(3):
            ring.rubbed[i] = 0.0


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
    nx, ny, pushed, rubbed = (
        guide.normal[0, 0],
        guide.normal[1, 0],
        guide.given[0, 0] - guide.force[0],
        guide.given[1, 0],
    )
    return pushed * nx - rubbed * ny, pushed * ny + rubbed * nx


@part
def given_beyond(pair):
    """What the last kick of a cage's guide gave the inner ring beyond its force, N, x and y."""
    if pair is None:
        return 0.0, 0.0
    return _beyond(pair.cage.guide, pair.ring)


@part
def _beyond(guide, ring):
    if guide is None or ring is None or not ring.turns:
        return 0.0, 0.0
    more = guide.kick[0] - guide.force[0]
    return more * guide.normal[0, 0], more * guide.normal[1, 0]


@part
def guide_squared(guide):
    return 0.0 if guide is None else guide.force[0] ** 2


@part
def push_ring_as_a_whole(ring):
    """The guiding ring's velocity by what the guide has given it, where it has no mesh that is kicked."""
    if ring is not None:
        for k in range(2):
            ring.velocity[k] += ring.impulse[k] / ring.mass
            ring.impulse[k] = 0.0
