"""Friction of a pair: Coulomb's limit, Carter's creep below it; `friction_solution`: of all pairs.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies. Where a contact has a tangential spring, T is the spring's
(`shear_kernels`); without, creep is solved for implicitly.

Equation (6) of docs/method.md.
"""

from fem.kernels.contact_kernels import first_surface, next_roller, next_rollers, with_dampers
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import maximum
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, select, splat, square_root, to_float, to_int, total
from fem.kernels.law import SLIP_FLOOR, creep_traction
from fem.kernels.shear_kernels import let_go, pull
from fem.kernels.state import Neighbours, Raceway
from fem.kernels.surfaces import (
    accumulate_ghost_nodes,
    body_mobility,
    clear_ghost_nodes,
    count_impulse,
    fill_ghost_nodes,
    push_body,
    scatter_force,
    scatter_tangential_force,
    tangential_mobility,
    tangential_velocity,
)

EVEN, ODD, ALL = 0, 1, 2  # contacts of a pair that are solved for at once


@part
def _closed(contacts, row):
    """Whether any of eight contacts is closed."""
    return any_lane(load(contacts.forces.force, row) > 0.0)


@part
def normals(contacts, pair, group):
    """Normals of eight contacts, x and y."""
    columns = contacts.patches.columns
    at = 2 * pair.row * columns + group
    return load(contacts.patches.normal, at), load(contacts.patches.normal, at + columns)


@part
def grip_pair(pair, rollers, disc, contacts):
    """How the patches of a pair's closed contacts grip, for all that follows."""
    for group in range(0, rollers.n, WIDTH):
        row, side = pair.row * rollers.columns + group, 2 * pair.row
        if _closed(contacts, row):
            mobility = tangential_mobility(first_surface(pair, disc), contacts.patches, side, group)
            store(
                contacts.friction.mobility, row, mobility + tangential_mobility(disc, contacts.patches, side + 1, group)
            )


@verb
def still_to_push(pair, contacts, row):
    """Normal forces of eight contacts, N, whose impulses are given with the tractions'."""


@still_to_push.of(Raceway)
def _with_dampers_of_raceway(raceway, contacts, row):
    return with_dampers(contacts.dampers, row, load(contacts.forces.kick, row))


@still_to_push.of(Neighbours)
def _without_dampers(pair, contacts, row):
    if contacts.dampers is None:
        return load(contacts.forces.kick, row)
    return splat(0.0)  # dampers of rollers that touch come one by one and need them before


@verb
def slip_velocity(pair, rollers, disc, contacts, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for closed contacts, m/s, to `out`, (3, columns).

    `grip_pair` must have been called at the present positions. `turn_kick`, (columns,), rad/s: increment of the
    rollers' spin as a whole. Open contacts get what has no meaning.
    """


@slip_velocity.of(Raceway)
def _slip_raceway(raceway, rollers, disc, contacts, turn_kick, out):
    velocity, columns, side = rollers.velocity, rollers.columns, 2 * raceway.row
    fill_ghost_nodes(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        if _closed(contacts, row):
            nx, ny = normals(contacts, raceway, group)
            own = load(turn_kick, group) * rollers.radius
            own += tangential_velocity(disc, contacts.patches, side + 1, group, count_from(group), nx, ny)
            slip = load(velocity, columns + group) * nx - load(velocity, group) * ny
            slip = slip - own if raceway.sign > 0.0 else slip + own
            slip -= tangential_velocity(raceway.surface, contacts.patches, side, group, 0, nx, ny)
            store(out, row, slip)


@slip_velocity.of(Neighbours)
def _slip_neighbours(pair, rollers, disc, contacts, turn_kick, out):
    velocity, columns, side = rollers.velocity, rollers.columns, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        if _closed(contacts, row):
            nx, ny = normals(contacts, pair, group)
            i = next_rollers(group, rollers.n)
            own = gather(turn_kick, i) * rollers.radius
            own += tangential_velocity(disc, contacts.patches, side + 1, group, i, nx, ny)
            slip = gather(velocity, i + columns) * nx - gather(velocity, i) * ny
            slip -= own + load(turn_kick, group) * rollers.radius
            slip -= tangential_velocity(disc, contacts.patches, side, group, count_from(group), nx, ny)
            slip -= load(velocity, columns + group) * nx - load(velocity, group) * ny
            store(out, row, slip)


@part
def find_tractions(pair, rollers, disc, contacts, dt, some, again):
    """Tractions of a pair's contacts, EVEN, ODD or ALL, from the slips, which become those that are left.

    `again`: the slips are with the last tractions; of ALL contacts with those of the rigid bodies alone. The
    difference from the tractions that the bodies have been given is left in `change`.
    """
    friction, columns = contacts.friction, rollers.columns
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        Q = with_dampers(contacts.dampers, row, load(contacts.forces.force, row))
        if not any_lane(Q > 0.0):
            store(friction.traction, row, splat(0.0))
            store(friction.change, row, splat(0.0))
            continue
        full_slip = _full_slip(pair, rollers, contacts, group, Q)
        mobility = load(friction.mobility, row) * dt
        given, found = splat(0.0), load(friction.slip_left, row)
        chosen, taken = Q > 0.0, mobility
        if again:
            given = load(friction.traction, row)
            if some == ALL:
                taken = splat(whole_mobility(pair, disc) * dt)
        if some != ALL:
            number = count_from(group + some)
            chosen = chosen & (number - to_int(to_float(number) * 0.5) * 2 == 0)
        T, left = creep_traction(found - taken * given, friction.coefficient * Q, full_slip, mobility)
        T = select(chosen, -T, select(Q > 0.0, given, 0.0))  # on side 1, along t
        store(friction.slip_left, row, select(chosen, left, found))
        store(friction.traction, row, T)
        store(friction.change, row, T - given)


@part
def spring_tractions(pair, rollers, contacts, dt):
    """Tractions of a pair's contacts from springs that have followed the slips; all of them is left in `change`."""
    friction, columns = contacts.friction, rollers.columns
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        Q, T = with_dampers(contacts.dampers, row, load(contacts.forces.force, row)), splat(0.0)
        if any_lane(Q > 0.0):
            full_slip = _full_slip(pair, rollers, contacts, group, Q)
            T = -pull(
                friction.shear, contacts, pair, row, dt, friction.coefficient * Q, full_slip
            )  # on side 1, along t
        else:
            let_go(friction.shear, row)
        store(friction.traction, row, T)
        store(friction.change, row, T)


@part
def _full_slip(pair, rollers, contacts, group, Q):
    """Creep speeds, m/s, beyond which eight contacts slide."""
    half_width = square_root(pair.law.half_width_factor * Q)
    rolling = _rolling_speed(pair, rollers, contacts, group)
    return maximum(contacts.friction.coefficient * pair.law.curvature * half_width * rolling, SLIP_FLOOR)


@verb
def _rolling_speed(pair, rollers, contacts, group):
    """Speed of rollers' surfaces past their contacts, m/s; 0 where two rollers meet."""
    return splat(0.0)


@_rolling_speed.of(Raceway)
def _on_raceway(raceway, rollers, contacts, group):
    nx, ny = normals(contacts, raceway, group)
    velocity = rollers.velocity
    turning = (load(velocity, rollers.columns + group) * nx - load(velocity, group) * ny) * (1.0 / raceway.orbit)
    return absolute(load(rollers.spin, group) - turning) * rollers.radius


@verb
def whole_mobility(pair, disc):
    """What rigid bodies add to the mobility of a contact, 1/kg."""


@whole_mobility.of(Raceway)
def _mobility_on_raceway(raceway, disc):
    return body_mobility(disc) + body_mobility(raceway.surface)


@whole_mobility.of(Neighbours)
def _mobility_of_neighbours(pair, disc):
    return body_mobility(disc) * 2.0


@verb
def apply_friction(pair, rollers, disc, contacts, share, dt):
    """Give the bodies of a pair the impulses of its tractions in a step.

    Bodies with nodes get those of `share`, (3, columns), N, rigid ones those of the changes of tractions.
    """


@apply_friction.of(Raceway)
def _drag_raceway(raceway, rollers, disc, contacts, share, dt):
    patches, side, moment = contacts.patches, 2 * raceway.row, splat(0.0)
    clear_ghost_nodes(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        given = load(share, raceway.row * rollers.columns + group) * dt  # along t on side 1
        if any_lane(given != 0.0):
            nx, ny = normals(contacts, raceway, group)
            scatter_tangential_force(disc, patches, side + 1, group, given * -raceway.sign)
            count_impulse(disc, group, -given * ny, given * nx)
            moment += scatter_tangential_force(raceway.surface, patches, side, group, -given)
    accumulate_ghost_nodes(raceway.surface)
    raceway.moment[1] += total(moment)
    if contacts.friction.whole is not None:
        drag_bodies(raceway, rollers, disc, contacts, dt)


@apply_friction.of(Neighbours)
def _drag_neighbours(pair, rollers, disc, contacts, share, dt):
    patches, side = contacts.patches, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        given = load(share, pair.row * rollers.columns + group) * dt
        if any_lane(given != 0.0):
            nx, ny = normals(contacts, pair, group)
            scatter_tangential_force(disc, patches, side + 1, group, -given)
            count_impulse(disc, next_rollers(group, rollers.n), -given * ny, given * nx)
            scatter_tangential_force(disc, patches, side, group, -given)
            count_impulse(disc, group, given * ny, -given * nx)
    if contacts.friction.whole is not None:
        drag_bodies(pair, rollers, disc, contacts, dt)


@verb
def push_and_drag(pair, rollers, disc, contacts, dt):
    """Give the nodes of a pair the impulses of its normal forces and of its tractions in a step, in one pass."""


@push_and_drag.of(Raceway)
def _push_and_drag_raceway(raceway, rollers, disc, contacts, dt):
    patches, side, moment, sign = contacts.patches, 2 * raceway.row, splat(0.0), raceway.sign
    clear_ghost_nodes(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * rollers.columns + group
        pushed, rubbed = still_to_push(raceway, contacts, row) * -dt, load(contacts.friction.change, row) * dt
        if any_lane((pushed != 0.0) | (rubbed != 0.0)):
            nx, ny = normals(contacts, raceway, group)
            scatter_force(disc, patches, side + 1, group, pushed, rubbed * -sign)
            count_impulse(disc, group, -rubbed * ny, rubbed * nx)
            moment += scatter_force(raceway.surface, patches, side, group, pushed * sign, -rubbed)
    accumulate_ghost_nodes(raceway.surface)
    raceway.moment[1] += total(moment)


@push_and_drag.of(Neighbours)
def _push_and_drag_neighbours(pair, rollers, disc, contacts, dt):
    patches, side = contacts.patches, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        pushed, rubbed = still_to_push(pair, contacts, row) * -dt, load(contacts.friction.change, row) * dt
        if any_lane((pushed != 0.0) | (rubbed != 0.0)):
            nx, ny = normals(contacts, pair, group)
            scatter_force(disc, patches, side + 1, group, pushed, -rubbed)
            count_impulse(disc, next_rollers(group, rollers.n), -rubbed * ny, rubbed * nx)
            scatter_force(disc, patches, side, group, pushed, -rubbed)
            count_impulse(disc, group, rubbed * ny, -rubbed * nx)


@verb
def drag_bodies(pair, rollers, disc, contacts, dt):
    """Give the rigid bodies of a pair the impulses of the changes of its tractions in a step."""


@drag_bodies.of(Raceway)
def _drag_bodies_on_raceway(raceway, rollers, disc, contacts, dt):
    normal, change, row, moment = contacts.patches.normal, contacts.friction.change, raceway.row, 0.0
    for j in range(rollers.n):
        moment += _drag_ring_and_roller(raceway, disc, j, change[row, j] * dt, normal[row, 0, j], normal[row, 1, j])
    raceway.moment[1] += moment


@drag_bodies.of(Neighbours)
def _drag_bodies_of_neighbours(pair, rollers, disc, contacts, dt):
    normal, change, row = contacts.patches.normal, contacts.friction.change, pair.row
    for j in range(rollers.n):
        i = next_roller(j, rollers.n)
        given = change[row, j] * dt
        nx = normal[row, 0, j]
        ny = normal[row, 1, j]
        push_body(disc, i, -given * ny, given * nx, -given)
        push_body(disc, j, given * ny, -given * nx, -given)


@part
def _drag_ring_and_roller(raceway, disc, j, given, nx, ny):
    """An impulse along t, N s, on roller j and against it on its ring, as far as they are rigid; its moment, N m s."""
    push_body(disc, j, -given * ny, given * nx, -raceway.sign * given)
    return push_body(raceway.surface, j, given * ny, -given * nx, -given)
