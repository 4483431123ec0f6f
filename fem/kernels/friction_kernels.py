"""Friction between rolling surfaces: Coulomb's limit, Carter's creep below it, solved implicitly.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies.
"""

from fem.kernels import patch_kernels as patch
from fem.kernels.contact_kernels import next_rollers, second
from fem.kernels.jit import kernel
from fem.kernels.lane_functions import larger
from fem.kernels.rigid_kernels import hub_mobility, roller_mobility, rub_whole, whole_mobility, whole_slip
from fem.kernels.simd import (
    WIDTH,
    any_lane,
    count_from,
    gather,
    load,
    magnitude,
    real,
    root,
    select,
    splat,
    store,
    total,
    whole,
    with_sign,
)
from fem.kernels.state import INNER, OUTER, ROLLER

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)


@kernel(forceinline=True)
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


@kernel(forceinline=True)
def grips(rollers, inner, outer, contacts, drive):
    """How all closed contacts' patches grip, for `slips` and `friction_contacts`."""
    points, radius, n, columns = rollers.points, rollers.radius, rollers.n, rollers.columns
    lightness, first, n_surface = rollers.lightness, rollers.first_surface, rollers.n_surface
    start, weight, along, across = contacts.start, contacts.weight, contacts.along, contacts.across
    force, outward, stretch = contacts.force, contacts.outward, contacts.stretch
    scale, lean = contacts.scale, contacts.lean
    for kind in range(3):
        for group in range(0, n, WIDTH):
            if not any_lane(load(force, kind * columns + group) > 0.0):
                continue
            side, at = 2 * kind, 4 * kind * columns + group
            if kind == ROLLER and len(rollers.rigid) > 0:
                mobility = splat(roller_mobility(rollers))
            elif kind == ROLLER:
                x, y = load(outward, at), load(outward, at + columns)
                mobility = patch.grip_roller(
                    points, lightness, first, n_surface, radius, x, y, start, weight, columns, side, group, scale, lean,
                    stretch,
                )  # fmt: skip
            elif kind == INNER and len(inner.rigid) > 0:
                mobility = splat(hub_mobility(rollers, drive))
            elif kind == OUTER and len(outer.rigid) > 0:
                mobility = splat(0.0)
            else:
                mass = inner.row_mass[inner.raceway] if kind == INNER else outer.row_mass[outer.raceway]
                mobility = patch.grip_ring(mass, weight, along, across, columns, side, group, scale, lean, stretch)
            if len(rollers.rigid) > 0:
                mobility += splat(roller_mobility(rollers))
            else:
                x, y = load(outward, at + 2 * columns), load(outward, at + 3 * columns)
                mobility += patch.grip_roller(
                    points, lightness, first, n_surface, radius, x, y, start, weight, columns, side + 1, group, scale,
                    lean, stretch,
                )  # fmt: skip
            store(contacts.mobility, kind * columns + group, mobility)


@kernel(forceinline=True)
def slips(rollers, inner, outer, contacts, drive, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for every closed contact, m/s; out (3, columns).

    `grips` must have been called at the present positions. `turn_kick`, (columns,), rad/s: what the rollers are still
    to gain by turning as a whole. Contacts that are open get what has no meaning.
    """
    for kind in range(3):
        slips_of(kind, rollers, inner, outer, contacts, drive, turn_kick, out)


@kernel(forceinline=True)
def slips_of(kind, rollers, inner, outer, contacts, drive, turn_kick, out):
    """`slips` of one kind of contact."""
    w, columns, velocity, radius, n = rollers.w, rollers.columns, rollers.velocity, rollers.radius, rollers.n
    points, first, n_surface = rollers.points, rollers.first_surface, rollers.n_surface
    start, weight, along, across = contacts.start, contacts.weight, contacts.along, contacts.across
    force, normal, outward, stretch = contacts.force, contacts.normal, contacts.outward, contacts.stretch
    scale, lean, spin = contacts.scale, contacts.lean, rollers.spin
    for group in range(0, n, WIDTH):
        row = kind * columns + group
        if not any_lane(load(force, row) > 0.0):
            continue
        nx, ny = load(normal, 2 * kind * columns + group), load(normal, (2 * kind + 1) * columns + group)
        side, at, i = 2 * kind, 4 * kind * columns + group, count_from(group)
        if kind == ROLLER:
            i = next_rollers(group, n)
        bx, by = load(outward, at + 2 * columns), load(outward, at + 3 * columns)
        own = gather(turn_kick, i) * radius
        if len(rollers.rigid) > 0:
            own += gather(spin, i) * radius
        else:
            own += patch.sideways_roller(
                w, i, points, first, n_surface, radius, bx, by, start, weight, columns, side + 1, group, scale, lean,
                stretch,
            )  # fmt: skip
        slip = gather(velocity, i + columns) * nx - gather(velocity, i) * ny
        if kind == OUTER:
            slip += own
            if len(outer.rigid) == 0:
                slip -= patch.sideways_ring(
                    outer.w, outer.raceway, outer.n_sectors, start, weight, along, across, columns, side, group, scale,
                    lean, stretch,
                )  # fmt: skip
        elif kind == INNER:
            slip -= own
            if len(inner.rigid) > 0:
                slip -= drive.velocity[1] * nx - drive.velocity[0] * ny + drive.speed * inner.radius
            else:
                slip -= patch.sideways_ring(
                    inner.w, inner.raceway, inner.n_sectors, start, weight, along, across, columns, side, group, scale,
                    lean, stretch,
                )  # fmt: skip
        else:
            bx, by = load(outward, at), load(outward, at + columns)
            slip -= own + load(turn_kick, group) * radius
            if len(rollers.rigid) > 0:
                slip -= load(spin, group) * radius
            else:
                slip -= patch.sideways_roller(
                    w, count_from(group), points, first, n_surface, radius, bx, by, start, weight, columns, side, group,
                    scale, lean, stretch,
                )  # fmt: skip
            slip -= load(velocity, columns + group) * nx - load(velocity, group) * ny
        store(out, row, slip)


@kernel(forceinline=True)
def friction_contacts(rollers, inner, outer, contacts, drive, after):
    """Tractions of every contact and their impulses; returns the work they dissipate in this step, J.

    Each is implicit in its own patch's velocity. `after`, (3, columns), m/s, is filled with the slips they leave. Where
    patches of neighbours overlap (on coarse meshes), each starts from its last value and every other one is solved for
    in turn (Gauss and Seidel): without neighbours' part sticking contacts would shake each other. Where they share a
    rigid body, each knows the others' last values.
    """
    crowded = contacts.crowded or (contacts.crowded_rollers and _rollers_touch(contacts, rollers))
    if not crowded and len(rollers.rigid) + len(inner.rigid) > 0:
        _solve_on_whole_bodies(rollers, inner, outer, contacts, drive, after)
    elif not crowded:
        slips(rollers, inner, outer, contacts, drive, rollers.turn_kick, after)
        for kind in range(3):
            _find_tractions(kind, 0, 1, False, rollers, inner, outer.radius - rollers.radius, contacts, drive, after)
            _rub(kind, rollers, inner, outer, contacts, drive, contacts.change)
    else:
        _solve_in_turn(rollers, inner, outer, contacts, drive, after)
    traction, before = contacts.traction, contacts.slip
    dissipated = splat(0.0)
    for at in range(0, traction.size, WIDTH):
        dissipated -= load(traction, at) * (load(before, at) + load(after, at))
    return 0.5 * drive.dt * total(dissipated)


@kernel(forceinline=True)
def _rollers_touch(contacts, rollers):
    found = splat(0.0)
    for group in range(0, rollers.n, WIDTH):
        found += load(contacts.force, ROLLER * rollers.columns + group)
    return any_lane(found > 0.0)


@kernel
def _solve_in_turn(rollers, inner, outer, contacts, drive, after):
    """Tractions and impulses of contacts whose patches overlap; seldom needed, so kept out of the time loop."""
    for kind in range(3):  # every contact that is still closed gets its last traction
        _take_last(kind, rollers, contacts)
        _rub(kind, rollers, inner, outer, contacts, drive, contacts.change)
    for kind in range(3):
        for first in range(2):
            slips_of(kind, rollers, inner, outer, contacts, drive, rollers.turn_kick, after)
            _find_tractions(kind, first, 2, True, rollers, inner, outer.radius - rollers.radius, contacts, drive, after)
            _rub(kind, rollers, inner, outer, contacts, drive, contacts.change)
    slips(rollers, inner, outer, contacts, drive, rollers.turn_kick, after)


@kernel(forceinline=True)
def _take_last(kind, rollers, contacts):
    """Begin with the last tractions of the contacts of a kind that are still closed."""
    for group in range(0, rollers.n, WIDTH):
        row = kind * rollers.columns + group
        last = select(load(contacts.force, row) > 0.0, load(contacts.traction, row), 0.0)
        store(contacts.traction, row, last)
        store(contacts.change, row, last)


@kernel(forceinline=True)
def _solve_on_whole_bodies(rollers, inner, outer, contacts, drive, after):
    """Tractions and impulses of contacts that share a rigid body but no nodes.

    The rigid bodies have been given all last tractions when each contact finds its own: a step's tractions differ from
    the last by so little that what they do to each other's slip is caught up with in the next.
    """
    columns, n, change = rollers.columns, rollers.n, contacts.change
    for kind in range(3):
        _take_last(kind, rollers, contacts)
        for j in range(n):
            given = change[kind, j] * drive.dt
            drive.ring[4] += rub_whole(kind, second(kind, j, n), j, given, rollers, inner, contacts, drive)
    slips(rollers, inner, outer, contacts, drive, rollers.turn_kick, after)
    for kind in range(3):
        _find_tractions(kind, 0, 1, True, rollers, inner, outer.radius - rollers.radius, contacts, drive, after)
    for kind in range(3):
        mobility = whole_mobility(kind, rollers, inner, drive) * drive.dt
        for group in range(0, n, WIDTH):
            row = kind * columns + group
            moved = whole_slip(kind, group, next_rollers(group, n), rollers, inner, contacts, drive)
            store(after, row, load(after, row) - moved - mobility * load(change, row))
    for kind in range(3):
        _rub(kind, rollers, inner, outer, contacts, drive, contacts.traction)
    for kind in range(3):
        for group in range(0, n, WIDTH):
            row = kind * columns + group
            moved = whole_slip(kind, group, next_rollers(group, n), rollers, inner, contacts, drive)
            store(after, row, load(after, row) + moved)


@kernel(forceinline=True)
def _find_tractions(kind, first, step, again, rollers, inner, pitch, contacts, drive, slip):
    """Tractions of every `step`-th contact of a kind from the slips, which become those that are left.

    `again`: the slips are with the last tractions, where `step` is 1 those of the rigid bodies alone.
    What they differ by from those that the bodies have been given is left in `contacts.change`.
    """
    columns, n, radius = rollers.columns, rollers.n, rollers.radius
    velocity, spin = rollers.velocity, rollers.spin
    force, traction, change, normal = contacts.force, contacts.traction, contacts.change, contacts.normal
    friction, dt = drive.friction, drive.dt
    for group in range(0, n, WIDTH):
        row = kind * columns + group
        Q = load(force, row)
        if not any_lane(Q > 0.0):
            store(traction, row, splat(0.0))
            store(change, row, splat(0.0))
            continue
        nx, ny = load(normal, 2 * kind * columns + group), load(normal, (2 * kind + 1) * columns + group)
        rolling = splat(0.0)
        if kind != ROLLER:
            orbit = (load(velocity, columns + group) * nx - load(velocity, group) * ny) * (1.0 / pitch)
            rolling = magnitude(load(spin, group) - orbit) * radius
        half_width = root(contacts.half_width_factor[kind] * Q)
        full_slip = larger(friction * contacts.curvature[kind] * half_width * rolling, SLIP_FLOOR)
        mobility = load(contacts.mobility, row) * dt
        given, found = splat(0.0), load(slip, row)
        chosen, taken = Q > 0.0, mobility
        if again:
            given = load(traction, row)
            if step == 1:
                taken = splat(whole_mobility(kind, rollers, inner, drive) * dt)
        if step > 1:
            number = count_from(group + first)
            chosen = chosen & (number - whole(real(number) * 0.5) * 2 == 0)
        T, left = creep_traction(found - taken * given, friction * Q, full_slip, mobility)
        T = select(chosen, -T, select(Q > 0.0, given, 0.0))  # on side 1, along t
        store(slip, row, select(chosen, left, found))
        store(traction, row, T)
        store(change, row, T - given)


@kernel(forceinline=True)
def _rub(kind, rollers, inner, outer, contacts, drive, share):
    """Impulses over one step on whole rollers and on the surface nodes.

    Rigid bodies get those of the changes of tractions, all others those of `share`, the same or the tractions.
    """
    w, lightness, columns, n = rollers.w, rollers.lightness, rollers.columns, rollers.n
    points, first, n_surface, radius = rollers.points, rollers.first_surface, rollers.n_surface, rollers.radius
    inner_u, inner_w, inner_mass = inner.u, inner.w, inner.row_mass[inner.raceway]
    outer_u, outer_w, outer_mass = outer.u, outer.w, outer.row_mass[outer.raceway]
    start, weight, along, across = contacts.start, contacts.weight, contacts.along, contacts.across
    change, outward, normal, stretch, dt = (
        contacts.change,
        contacts.outward,
        contacts.normal,
        contacts.stretch,
        drive.dt,
    )
    scale, lean, impulse = contacts.scale, contacts.lean, rollers.impulse
    on_nodes = 0.0
    for j in range(n):
        given, whole = share[kind, j] * dt, change[kind, j] * dt  # along t on side 1
        if given == 0.0 and whole == 0.0:
            continue
        side = 2 * kind
        i = second(kind, j, n)
        own = given if kind == OUTER else -given
        x, y = -given * normal[kind, 1, j], given * normal[kind, 0, j]
        if len(rollers.rigid) == 0:
            impulse[0, i] += x
            impulse[1, i] += y
            bx, by = outward[side + 1, 0, j], outward[side + 1, 1, j]
            patch.rub_roller(
                w, lightness, columns, i, points, first, n_surface, radius, bx, by, own, start, weight, side + 1, j,
                scale, lean, stretch,
            )  # fmt: skip
        if kind == INNER and len(inner.rigid) == 0:
            on_nodes += patch.rub_ring(
                inner_u, inner_w, inner.raceway, inner.n_sectors, inner.radius, inner_mass, -given, start, weight,
                along, across, side, j, scale, lean, stretch,
            )  # fmt: skip
        elif kind == OUTER and len(outer.rigid) == 0:
            patch.rub_ring(
                outer_u, outer_w, outer.raceway, outer.n_sectors, outer.radius, outer_mass, -given, start, weight,
                along, across, side, j, scale, lean, stretch,
            )  # fmt: skip
        elif kind == ROLLER and len(rollers.rigid) == 0:
            impulse[0, j] -= x
            impulse[1, j] -= y
            bx, by = outward[side, 0, j], outward[side, 1, j]
            patch.rub_roller(
                w, lightness, columns, j, points, first, n_surface, radius, bx, by, -given, start, weight, side, j,
                scale, lean, stretch,
            )  # fmt: skip
        on_nodes += rub_whole(kind, i, j, whole, rollers, inner, contacts, drive)
    drive.ring[4] += on_nodes
