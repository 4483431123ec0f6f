"""Friction of a pair: Coulomb's limit, Carter's creep below it, solved implicitly; `friction_solution`: of all pairs.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies.
"""

from fem.kernels.contact_kernels import first_surface, next_roller, next_rollers, with_dampers
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import larger
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, magnitude, real, root, select, splat, total, whole, with_sign
from fem.kernels.shear_kernels import let_go, spring_back, stretch
from fem.kernels.state import Neighbours, Raceway
from fem.kernels.surfaces import (
    body_mobility,
    count_impulse,
    gather_seam,
    grip,
    push_along,
    push_body,
    push_both_ways,
    seal,
    sideways,
    unseal,
)

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)
EVEN, ODD, ALL = 0, 1, 2  # contacts of a pair that are solved for at once


@part
def creep_traction(slip, limit, full_slip, mobility_dt):
    """Traction, N, that opposes a slip velocity, and the slip it leaves, m/s; scalars or lanes.

    Carter's law T = limit·(1 − (1 − v/v_full)²) up to v_full, then `limit`; solved implicitly for the velocity after
    the step, v = slip − mobility·dt·T(v), so that no stiffness limits the step.

    Parameters
    ----------
    limit : N, μQ; full_slip : m/s; mobility_dt : m/s per N

    Source: Carter, On the action of a locomotive driving wheel (1926); Johnson, Contact Mechanics (1985), chapter 8.
    """
    v = magnitude(slip)
    k = mobility_dt * limit / full_slip
    x = v / full_slip
    sliding = x >= 1.0 + k
    b = 1.0 + 2.0 * k
    x = 2.0 * x / (b + root(select(sliding, 0.0, b * b - 4.0 * k * x)))
    traction = select(sliding, limit, limit * x * (2.0 - x))
    left = select(sliding, v - mobility_dt * limit, x * full_slip)
    return with_sign(traction, slip), with_sign(left, slip)


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
            mobility, coupling = grip(first_surface(pair, disc), contacts.patches, side, group)
            mobility_1, coupling_1 = grip(disc, contacts.patches, side + 1, group)
            store(contacts.friction.mobility, row, mobility + mobility_1)
            store(contacts.friction.coupling, row, (coupling + coupling_1) * outward_sign(pair))


@verb
def outward_sign(pair):
    """1, of a bore −1."""
    return 1.0


@outward_sign.of(Raceway)
def _sign_of_raceway(raceway):
    return raceway.sign


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


@part
def slip_of_push(pair, rollers, contacts, dt):
    """Add to the slips left what the normal forces' impulses, not yet given, will do to them.

    Where no patches overlap that is each contact's own.
    """
    friction = contacts.friction
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        push = still_to_push(pair, contacts, row)
        if any_lane(push != 0.0):
            store(friction.slip_left, row, load(friction.slip_left, row) + load(friction.coupling, row) * push * dt)


@verb
def slip_pair(pair, rollers, disc, contacts, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for closed contacts, m/s, to `out`, (3, columns).

    `grip_pair` must have been called at the present positions. `turn_kick`, (columns,), rad/s: what the rollers are
    still to gain by turning as a whole. Open contacts get what has no meaning.
    """


@slip_pair.of(Raceway)
def _slip_raceway(raceway, rollers, disc, contacts, turn_kick, out):
    velocity, columns, side = rollers.velocity, rollers.columns, 2 * raceway.row
    seal(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        if _closed(contacts, row):
            nx, ny = normals(contacts, raceway, group)
            own = load(turn_kick, group) * rollers.radius
            own += sideways(disc, contacts.patches, side + 1, group, count_from(group), nx, ny)
            slip = load(velocity, columns + group) * nx - load(velocity, group) * ny
            slip = slip - own if raceway.sign > 0.0 else slip + own
            slip -= sideways(raceway.surface, contacts.patches, side, group, 0, nx, ny)
            store(out, row, slip)


@slip_pair.of(Neighbours)
def _slip_neighbours(pair, rollers, disc, contacts, turn_kick, out):
    velocity, columns, side = rollers.velocity, rollers.columns, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        if _closed(contacts, row):
            nx, ny = normals(contacts, pair, group)
            i = next_rollers(group, rollers.n)
            own = gather(turn_kick, i) * rollers.radius
            own += sideways(disc, contacts.patches, side + 1, group, i, nx, ny)
            slip = gather(velocity, i + columns) * nx - gather(velocity, i) * ny
            slip -= own + load(turn_kick, group) * rollers.radius
            slip -= sideways(disc, contacts.patches, side, group, count_from(group), nx, ny)
            slip -= load(velocity, columns + group) * nx - load(velocity, group) * ny
            store(out, row, slip)


@verb
def slip_with_nodes(pair, rollers, disc, contacts, turn_kick):
    """`slip_pair` to the slips left, where those of a raceway have what its nodes add to them already."""


@slip_with_nodes.of(Raceway)
def _slip_raceway_with_nodes(raceway, rollers, disc, contacts, turn_kick):
    velocity, columns, left, sign = rollers.velocity, rollers.columns, contacts.friction.slip_left, raceway.sign
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        if _closed(contacts, row):
            nx, ny = normals(contacts, raceway, group)
            slip = load(velocity, columns + group) * nx - load(velocity, group) * ny
            slip -= load(turn_kick, group) * (sign * rollers.radius)
            store(left, row, load(left, row) + slip)


@slip_with_nodes.of(Neighbours)
def _slip_neighbours_with_nodes(pair, rollers, disc, contacts, turn_kick):
    slip_pair(pair, rollers, disc, contacts, turn_kick, contacts.friction.slip_left)


@part
def find_tractions(pair, rollers, disc, contacts, dt, some, again):
    """Tractions of a pair's contacts, EVEN, ODD or ALL, from the slips, which become those that are left.

    `again`: the slips are with the last tractions; of ALL contacts with those of the rigid bodies alone. What tractions
    differ by from those that the bodies have been given is left in `change`.
    """
    friction, columns = contacts.friction, rollers.columns
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        Q = with_dampers(contacts.dampers, row, load(contacts.forces.force, row))
        if not any_lane(Q > 0.0):
            store(friction.traction, row, splat(0.0))
            store(friction.change, row, splat(0.0))
            let_go(friction.shear, row)
            continue
        half_width = root(pair.law.half_width_factor * Q)
        rolling = _rolling_speed(pair, rollers, contacts, group)
        full_slip = larger(friction.coefficient * pair.law.curvature * half_width * rolling, SLIP_FLOOR)
        mobility = load(friction.mobility, row) * dt
        given, found = splat(0.0), load(friction.slip_left, row)
        chosen, taken = Q > 0.0, mobility
        if again:
            given = load(friction.traction, row)
            if some == ALL:
                taken = splat(whole_mobility(pair, disc) * dt)
        if some != ALL:
            number = count_from(group + some)
            chosen = chosen & (number - whole(real(number) * 0.5) * 2 == 0)
        free = found - taken * given
        ahead, give = spring_back(friction.shear, contacts, pair, row, dt)
        limit = friction.coefficient * Q
        T, left = creep_traction(free - ahead, limit, full_slip, mobility + give)
        left = stretch(friction.shear, row, chosen, T, limit, left, free - mobility * T)
        T = select(chosen, -T, select(Q > 0.0, given, 0.0))  # on side 1, along t
        store(friction.slip_left, row, select(chosen, left, found))
        store(friction.traction, row, T)
        store(friction.change, row, T - given)


@verb
def _rolling_speed(pair, rollers, contacts, group):
    """Speed of rollers' surfaces past their contacts, m/s; 0 where two rollers meet."""
    return splat(0.0)


@_rolling_speed.of(Raceway)
def _on_raceway(raceway, rollers, contacts, group):
    nx, ny = normals(contacts, raceway, group)
    velocity = rollers.velocity
    turning = (load(velocity, rollers.columns + group) * nx - load(velocity, group) * ny) * (1.0 / raceway.orbit)
    return magnitude(load(rollers.spin, group) - turning) * rollers.radius


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
def drag(pair, rollers, disc, contacts, share, dt):
    """Give the bodies of a pair the impulses of its tractions in a step.

    Bodies with nodes get those of `share`, (3, columns), N, rigid ones those of the changes of tractions.
    """


@drag.of(Raceway)
def _drag_raceway(raceway, rollers, disc, contacts, share, dt):
    patches, side, moment = contacts.patches, 2 * raceway.row, splat(0.0)
    unseal(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        given = load(share, raceway.row * rollers.columns + group) * dt  # along t on side 1
        if any_lane(given != 0.0):
            nx, ny = normals(contacts, raceway, group)
            push_along(disc, patches, side + 1, group, given * -raceway.sign)
            count_impulse(disc, group, -given * ny, given * nx)
            moment += push_along(raceway.surface, patches, side, group, -given)
    gather_seam(raceway.surface)
    raceway.moment[1] += total(moment)
    if contacts.friction.whole is not None:
        drag_bodies(raceway, rollers, disc, contacts, dt)


@drag.of(Neighbours)
def _drag_neighbours(pair, rollers, disc, contacts, share, dt):
    patches, side = contacts.patches, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        given = load(share, pair.row * rollers.columns + group) * dt
        if any_lane(given != 0.0):
            nx, ny = normals(contacts, pair, group)
            push_along(disc, patches, side + 1, group, -given)
            count_impulse(disc, next_rollers(group, rollers.n), -given * ny, given * nx)
            push_along(disc, patches, side, group, -given)
            count_impulse(disc, group, given * ny, -given * nx)
    if contacts.friction.whole is not None:
        drag_bodies(pair, rollers, disc, contacts, dt)


@verb
def push_and_drag(pair, rollers, disc, contacts, dt):
    """Give the nodes of a pair the impulses of its normal forces and of its tractions in a step, in one pass."""


@push_and_drag.of(Raceway)
def _push_and_drag_raceway(raceway, rollers, disc, contacts, dt):
    patches, side, moment, sign = contacts.patches, 2 * raceway.row, splat(0.0), raceway.sign
    unseal(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * rollers.columns + group
        pushed, rubbed = still_to_push(raceway, contacts, row) * -dt, load(contacts.friction.change, row) * dt
        if any_lane((pushed != 0.0) | (rubbed != 0.0)):
            nx, ny = normals(contacts, raceway, group)
            push_both_ways(disc, patches, side + 1, group, pushed, rubbed * -sign)
            count_impulse(disc, group, -rubbed * ny, rubbed * nx)
            moment += push_both_ways(raceway.surface, patches, side, group, pushed * sign, -rubbed)
    gather_seam(raceway.surface)
    raceway.moment[1] += total(moment)


@push_and_drag.of(Neighbours)
def _push_and_drag_neighbours(pair, rollers, disc, contacts, dt):
    patches, side = contacts.patches, 2 * pair.row
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        pushed, rubbed = still_to_push(pair, contacts, row) * -dt, load(contacts.friction.change, row) * dt
        if any_lane((pushed != 0.0) | (rubbed != 0.0)):
            nx, ny = normals(contacts, pair, group)
            push_both_ways(disc, patches, side + 1, group, pushed, -rubbed)
            count_impulse(disc, next_rollers(group, rollers.n), -rubbed * ny, rubbed * nx)
            push_both_ways(disc, patches, side, group, pushed, -rubbed)
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
        _drag_rollers(disc, j, i, change[row, j] * dt, normal[row, 0, j], normal[row, 1, j])


@part
def _drag_ring_and_roller(raceway, disc, j, given, nx, ny):
    """An impulse along t, N s, on roller j and against it on its ring, as far as they are rigid; its moment, N m s."""
    push_body(disc, j, -given * ny, given * nx, -raceway.sign * given)
    return push_body(raceway.surface, j, given * ny, -given * nx, -given)


@part
def _drag_rollers(disc, j, i, given, nx, ny):
    """An impulse along t, N s, on roller i and against it on roller j, as far as they are rigid."""
    push_body(disc, i, -given * ny, given * nx, -given)
    push_body(disc, j, given * ny, -given * nx, -given)
