"""Bodies declared rigid: without nodes, pushed and turned as a whole.

A rigid roller's contact forces act through its centre; its leapfrog is of velocity and spin. A rigid inner ring is the
hub, a rigid outer one the ground. Every traction on one of them moves its other contacts at once, so their friction is
solved in turn: see `friction_kernels`.
"""

from fem.kernels.jit import kernel
from fem.kernels.simd import WIDTH, load, splat, store


@kernel(forceinline=True)
def still(out, side):
    """What a patch would read of a surface that keeps its shape: motion along and across the normal, no slopes."""
    return out, side, splat(0.0), splat(0.0), splat(0.0)


@kernel(forceinline=True)
def push_whole(rollers):
    """The contacts' impulses to where `kick` takes them from with those that act on whole bodies."""
    impulse, tilt = rollers.impulse, rollers.tilt
    for component in range(2):
        for j in range(rollers.n):
            tilt[component, j] += impulse[component, j]
            impulse[component, j] = 0.0


@kernel(forceinline=True)
def rub_roller(rollers, i, x, y, around):
    """Give roller i an impulse (x, y), N s, at its surface; `around` of it turns it counter-clockwise."""
    over = 1.0 / rollers.total_mass
    rollers.velocity[0, i] += x * over
    rollers.velocity[1, i] += y * over
    rollers.turn_kick[i] += around * rollers.radius / rollers.inertia


@kernel(forceinline=True)
def rub_hub(inner, drive, x, y, around):
    """Give the hub an impulse (x, y), N s, at the raceway, `around` counter-clockwise; returns its moment, N m s."""
    drive.velocity[0] += x / drive.mass
    drive.velocity[1] += y / drive.mass
    return drive.hub[0] * y - drive.hub[1] * x + inner.radius * around


@kernel(forceinline=True)
def roller_mobility(rollers):
    """Velocity of a roller's surface along itself per impulse along itself, 1/kg."""
    return 1.0 / rollers.total_mass + rollers.radius * rollers.radius / rollers.inertia


@kernel(forceinline=True)
def hub_mobility(rollers, drive):
    """A bound, 1/kg: the hub's times the number of contacts, as if all of them rubbed in the same direction.

    They are solved for at once, each with its own mobility; with the bound none takes back what others have given. Of a
    roller's patch it is a small part.
    """
    return rollers.n / drive.mass


@kernel(forceinline=True)
def turn_whole(rollers, dt, moment):
    """What `disc_kernels.drift` finds of rollers with nodes: inertia times the angle by which bodies lead frames."""
    for j in range(0, rollers.n, WIDTH):
        store(moment, j, load(rollers.turn_kick, j) * (rollers.inertia * dt))


@kernel(forceinline=True)
def turning_energy(rollers):
    """Twice the kinetic energy of the rollers' spin, J, between two half steps as leapfrog conserves it."""
    total = 0.0
    for j in range(rollers.n):
        spin = rollers.spin[j]
        total += rollers.inertia * spin * (spin + rollers.turn_kick[j])
    return total
