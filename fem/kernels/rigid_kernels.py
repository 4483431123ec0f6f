"""Bodies declared rigid: without nodes, pushed and turned as a whole.

A rigid roller's contact forces act through its centre; its leapfrog is of velocity and spin. A rigid inner ring is the
hub, a rigid outer one the ground. Every traction on one of them moves its other contacts at once, see
`friction_kernels`.
"""

from fem.kernels.jit import kernel
from fem.kernels.simd import WIDTH, gather, load, splat, store
from fem.kernels.state import INNER, OUTER, ROLLER


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
def rub_whole(kind, i, j, given, rollers, inner, contacts, drive):
    """Give the rigid bodies of contact j, roller i on its side 1, an impulse along t on side 1, N s.

    Returns the moment on the hub about the origin, N m s.
    """
    normal = contacts.normal
    x, y = -given * normal[kind, 1, j], given * normal[kind, 0, j]
    if len(rollers.rigid) > 0:
        _rub_roller(rollers, i, x, y, given if kind == OUTER else -given)
        if kind == ROLLER:
            _rub_roller(rollers, j, -x, -y, -given)
    if len(inner.rigid) > 0 and kind == INNER:
        drive.velocity[0] -= x / drive.mass
        drive.velocity[1] -= y / drive.mass
        return drive.hub[1] * x - drive.hub[0] * y - inner.radius * given
    return 0.0


@kernel(forceinline=True)
def _rub_roller(rollers, i, x, y, around):
    """An impulse (x, y), N s, at the surface of roller i, which turns it counter-clockwise by `around`."""
    over = 1.0 / rollers.total_mass
    rollers.velocity[0, i] += x * over
    rollers.velocity[1, i] += y * over
    rollers.turn_kick[i] += around * (rollers.radius / rollers.inertia)


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
def whole_mobility(kind, rollers, inner, drive):
    """What rigid bodies add to the mobility of a contact, 1/kg."""
    mobility = 0.0
    if len(rollers.rigid) > 0:
        mobility += roller_mobility(rollers) * (2.0 if kind == ROLLER else 1.0)
    if len(inner.rigid) > 0 and kind == INNER:
        mobility += hub_mobility(rollers, drive)
    return mobility


@kernel(forceinline=True)
def whole_slip(kind, group, i, rollers, inner, contacts, drive):
    """What the rigid bodies' motion adds to the slip of eight contacts from `group` on, m/s; `i`: the rollers after."""
    columns, radius = rollers.columns, rollers.radius
    velocity, spin, turn_kick = rollers.velocity, rollers.spin, rollers.turn_kick
    nx = load(contacts.normal, 2 * kind * columns + group)
    ny = load(contacts.normal, (2 * kind + 1) * columns + group)
    slip = splat(0.0)
    if len(rollers.rigid) > 0:
        around = (load(spin, group) + load(turn_kick, group)) * radius
        along = load(velocity, columns + group) * nx - load(velocity, group) * ny
        if kind == OUTER:
            slip = along + around
        elif kind == INNER:
            slip = along - around
        else:
            after = gather(velocity, i + columns) * nx - gather(velocity, i) * ny
            slip = after - along - around - (gather(spin, i) + gather(turn_kick, i)) * radius
    if len(inner.rigid) > 0 and kind == INNER:
        slip -= drive.velocity[1] * nx - drive.velocity[0] * ny
    return slip


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
