"""Friction of a pair: Coulomb's limit, Carter's creep below it; `friction_solution`: of all pairs.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies. Where a contact has a tangential spring, T is the spring's
(`shear_kernels`); without, creep is solved for implicitly.

Equation (6) of docs/method.md.
"""

from fem.kernels.contact_kernels import first_surface, next_roller, next_rollers, second_rollers, with_dampers
from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, select, splat, square_root, to_float, to_int, total
from fem.kernels.law import SLIP_FLOOR, creep_traction
from fem.kernels.shear_kernels import let_go, pull
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


@part
def still_to_push(pair, contacts, row):
    """Normal forces of eight contacts, N, whose impulses are given with the tractions'."""
    if pair.surface is not None:
        return with_dampers(contacts.dampers, row, load(contacts.forces.kick, row))
    if contacts.dampers is None:
        return load(contacts.forces.kick, row)
    return splat(0.0)  # dampers of rollers that touch come one by one and need them before


@part
def slip_velocity(pair, rollers, disc, contacts, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for closed contacts, m/s, to `out`, (3, columns).

    `grip_pair` must have been called at the present positions. `turn_kick`, (columns,), rad/s: increment of the
    rollers' spin as a whole. Open contacts get what has no meaning.
    """
    velocity, columns, side = rollers.velocity, rollers.columns, 2 * pair.row
    fill_ghost_nodes(first_surface(pair, disc))
    for group in range(0, rollers.n, WIDTH):
        row, patches = pair.row * columns + group, contacts.patches
        if _closed(contacts, row):
            nx, ny = normals(contacts, pair, group)
            i = second_rollers(pair, group, rollers.n)
            own = gather(turn_kick, i) * rollers.radius
            own += tangential_velocity(disc, patches, side + 1, group, i, nx, ny)
            slip = gather(velocity, i + columns) * nx - gather(velocity, i) * ny
            if pair.surface is not None:
                slip = slip - own if pair.sign > 0.0 else slip + own
                slip -= tangential_velocity(pair.surface, patches, side, group, 0, nx, ny)
            else:
                slip -= own + load(turn_kick, group) * rollers.radius
                slip -= tangential_velocity(disc, patches, side, group, count_from(group), nx, ny)
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
    """Creep speeds, m/s, beyond which eight contacts slide; where two rollers meet nothing rolls."""
    half_width, velocity, rolling = square_root(pair.law.half_width_factor * Q), rollers.velocity, splat(0.0)
    if pair.surface is not None:
        nx, ny = normals(contacts, pair, group)
        turning = (load(velocity, rollers.columns + group) * nx - load(velocity, group) * ny) * (1.0 / pair.orbit)
        rolling = absolute(load(rollers.spin, group) - turning) * rollers.radius
    return maximum(contacts.friction.coefficient * pair.law.curvature * half_width * rolling, SLIP_FLOOR)


@part
def whole_mobility(pair, disc):
    """What rigid bodies add to the mobility of a contact, 1/kg."""
    return body_mobility(disc) + body_mobility(first_surface(pair, disc))


@part
def apply_friction(pair, rollers, disc, contacts, share, dt):
    """Give the bodies of a pair the impulses of its tractions in a step.

    Bodies with nodes get those of `share`, (3, columns), N, rigid ones those of the changes of tractions.
    """
    patches, side, moment, surface = contacts.patches, 2 * pair.row, splat(0.0), first_surface(pair, disc)
    clear_ghost_nodes(surface)
    for group in range(0, rollers.n, WIDTH):
        given = load(share, pair.row * rollers.columns + group) * dt  # along t on side 1
        if any_lane(given != 0.0):
            nx, ny = normals(contacts, pair, group)
            scatter_tangential_force(disc, patches, side + 1, group, given * -pair.sign)
            _count_impulses(pair, rollers, disc, group, given * nx, given * ny)
            moment += scatter_tangential_force(surface, patches, side, group, -given)
    accumulate_ghost_nodes(surface)
    if pair.surface is not None:
        pair.moment[1] += total(moment)
    if contacts.friction.whole is not None:
        drag_bodies(pair, rollers, disc, contacts, dt)


@part
def _count_impulses(pair, rollers, disc, group, x, y):
    """Count impulses along t, the normal's (x, y) turned, that nodes of rollers are given to their centres' motion."""
    if pair.surface is not None:
        count_impulse(disc, group, -y, x)
    else:
        count_impulse(disc, next_rollers(group, rollers.n), -y, x)
        count_impulse(disc, group, y, -x)


@part
def push_and_drag(pair, rollers, disc, contacts, dt):
    """Give the nodes of a pair the impulses of its normal forces and of its tractions in a step, in one pass."""
    patches, side, moment, surface = contacts.patches, 2 * pair.row, splat(0.0), first_surface(pair, disc)
    clear_ghost_nodes(surface)
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        pushed, rubbed = still_to_push(pair, contacts, row) * -dt, load(contacts.friction.change, row) * dt
        if any_lane((pushed != 0.0) | (rubbed != 0.0)):
            nx, ny = normals(contacts, pair, group)
            scatter_force(disc, patches, side + 1, group, pushed, rubbed * -pair.sign)
            _count_impulses(pair, rollers, disc, group, rubbed * nx, rubbed * ny)
            moment += scatter_force(surface, patches, side, group, pushed * pair.sign, -rubbed)
    accumulate_ghost_nodes(surface)
    if pair.surface is not None:
        pair.moment[1] += total(moment)


@part
def drag_bodies(pair, rollers, disc, contacts, dt):
    """Give the rigid bodies of a pair the impulses of the changes of its tractions in a step."""
    normal, change, row, moment = contacts.patches.normal, contacts.friction.change, pair.row, 0.0
    for j in range(rollers.n):
        given, nx, ny = change[row, j] * dt, normal[row, 0, j], normal[row, 1, j]
        i = j if pair.surface is not None else next_roller(j, rollers.n)
        push_body(disc, i, -given * ny, given * nx, -pair.sign * given)
        moment += push_body(first_surface(pair, disc), j, given * ny, -given * nx, -given)
    if pair.surface is not None:
        pair.moment[1] += moment
