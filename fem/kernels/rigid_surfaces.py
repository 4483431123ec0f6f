"""Bodies declared rigid: without nodes, pushed and turned as a whole.

A rigid roller's contact forces act through its centre; its leapfrog is of velocity and spin. A rigid inner ring is the
hub, a rigid outer one the ground. Every traction on one of them moves its other contacts at once, see
`friction_kernels`.
"""

from fem.kernels.drive import outer_speed_of, speed_of
from fem.kernels.jit import verb
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, splat, total
from fem.kernels.state import Ground, Hub, RigidDisc
from fem.kernels.surfaces import (
    body_mobility,
    body_motion,
    push_body,
    scatter_force,
    scatter_normal_force,
    scatter_tangential_force,
    tangential_mobility,
    tangential_velocity,
)


@scatter_normal_force.of(Hub)
def _push_hub(hub, patches, side, group, impulse):
    at = side * patches.columns + group  # of the pair's normals: the hub is on side 0
    hub.impulse[0] += total(impulse * load(patches.normal, at))
    hub.impulse[1] += total(impulse * load(patches.normal, at + patches.columns))
    return 0.0


@tangential_mobility.of(Hub)
def _grip_hub(hub, patches, side, group):
    return splat(body_mobility(hub))


@tangential_velocity.of(Hub)
def _sideways_hub(hub, patches, side, group, column, nx, ny):
    return hub.velocity[1] * nx - hub.velocity[0] * ny + speed_of(hub.history, hub) * hub.radius


@push_body.of(Hub)
def _push_hub_along(hub, column, x, y, around):
    hub.velocity[0] += x / hub.late_mass
    hub.velocity[1] += y / hub.late_mass
    return hub.place[0] * y - hub.place[1] * x + hub.radius * around


@body_mobility.of(Hub)
def _hub_mobility(hub):
    """A bound: the hub's times the number of contacts, as if all of them rubbed in the same direction.

    They are solved for at once, each with its own mobility; with the bound none takes back what others have given. Of a
    roller's patch it is a small part.
    """
    return hub.n_contacts / hub.late_mass


@body_motion.of(Hub)
def _hub_motion(hub, column, nx, ny):
    return hub.velocity[1] * nx - hub.velocity[0] * ny, splat(0.0)


@tangential_velocity.of(Ground)
def _sideways_ground(ground, patches, side, group, column, nx, ny):
    return splat(outer_speed_of(ground.turning) * ground.radius)


@scatter_tangential_force.of(Ground)
def _turn_ground(ground, patches, side, group, impulse):
    return impulse * ground.radius


@scatter_force.of(Ground)
def _push_and_turn_ground(ground, patches, side, group, impulse, around):
    return around * ground.radius


@tangential_mobility.of(RigidDisc)
def _grip_disc(disc, patches, side, group):
    return splat(body_mobility(disc))


@tangential_velocity.of(RigidDisc)
def _sideways_disc(disc, patches, side, group, column, nx, ny):
    return gather(disc.spin, column) * disc.radius


@push_body.of(RigidDisc)
def _push_disc(disc, column, x, y, around):
    over = 1.0 / disc.total_mass
    disc.velocity[0, column] += x * over
    disc.velocity[1, column] += y * over
    disc.turn_kick[column] += around * (disc.radius / disc.inertia)
    return 0.0


@body_mobility.of(RigidDisc)
def _disc_mobility(disc):
    return 1.0 / disc.total_mass + disc.radius * disc.radius / disc.inertia


@body_motion.of(RigidDisc)
def _disc_motion(disc, column, nx, ny):
    along = gather(disc.velocity, column + disc.columns) * nx - gather(disc.velocity, column) * ny
    return along, (gather(disc.spin, column) + gather(disc.turn_kick, column)) * disc.radius


@verb
def settle(surface, rollers):
    """Bring the contacts' impulses on rigid rollers to those that act on whole bodies."""


@settle.of(RigidDisc)
def _settle(surface, rollers):
    impulse, body_impulse = rollers.node_impulse, rollers.body_impulse
    for component in range(2):
        for j in range(rollers.n):
            body_impulse[component, j] += impulse[component, j]
            impulse[component, j] = 0.0


@verb
def turn(surface, rollers, dt, moment):
    """What `disc_kernels.drift` finds of rollers with nodes: inertia times the angle by which bodies lead frames."""


@turn.of(RigidDisc)
def _turn(surface, rollers, dt, moment):
    for j in range(0, rollers.n, WIDTH):
        store(moment, j, load(rollers.turn_kick, j) * (rollers.inertia * dt))


@verb
def turning_energy(surface, rollers):
    """Twice the kinetic energy of rigid rollers' spin, J, between two half steps as leapfrog conserves it."""
    return 0.0


@turning_energy.of(RigidDisc)
def _turning_energy(surface, rollers):
    total = 0.0
    for j in range(rollers.n):
        spin = rollers.spin[j]
        total += rollers.inertia * spin * (spin + rollers.turn_kick[j])
    return total
