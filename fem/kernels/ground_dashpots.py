"""Dashpots between the ground and what a bearing sits in or on, a housing or a shaft: by the mean of the velocities
before and after a kick, which forces that are found after theirs change once more.

Finite elements divide the impulses of such forces by a body's `late_mass`, its mass and half a step of its dashpots,
which is what both together resist with, and let the dashpots `conclude` a kick; the reduced model's forces ask how they
give way.

A body here is a named tuple with `velocity`, `before`, `drag`, `mass`, `damping`: `Shaft`, which shares its arrays with
the hub, or `Housing`. None: nothing is held so.
"""

from fem.kernels.jit import part


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
