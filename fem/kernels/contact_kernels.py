"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.

Eight contacts at a time: lanes are rollers, of which the last may be spare. Arrays of contacts are (kind, roller).
"""

import numpy as np

from fem.kernels import patch_kernels as patch
from fem.kernels.jit import kernel
from fem.kernels.law import contact_force, kick_force
from fem.kernels.resolved_kernels import resolved_contacts
from fem.kernels.rigid_kernels import push_whole, still
from fem.kernels.simd import (
    WIDTH,
    any_lane,
    count_from,
    gather,
    load,
    root,
    scatter_add,
    select,
    splat,
    store,
    total,
)
from fem.kernels.state import INNER, OUTER, ROLLER


@kernel(forceinline=True)
def contact_forces(rollers, inner, outer, contacts, drive, slope, resolved):
    """Normal forces by the scene's contact model, and what they do to whole bodies; a run compiles the one it uses."""
    if resolved is None:
        normal_contacts(rollers, inner, outer, contacts, drive, slope)
    else:
        resolved_contacts(rollers, inner, outer, contacts, drive, resolved)


@kernel(forceinline=True)
def push_nodes(rollers, inner, outer, contacts, drive, resolved):
    """The forces' impulses on the surface nodes, where `contact_forces` has not given them already."""
    if resolved is None or resolved.shift.shape[2] == 1:
        push_contacts(rollers, inner, outer, contacts, drive)


@kernel(forceinline=True)
def normal_contacts(rollers, inner, outer, contacts, drive, slope):
    """Normal forces of every contact at the present positions, and their impulses over one step on whole bodies."""
    for kind in range(2):
        ring_contacts(kind, rollers, inner, outer, contacts, drive, slope)
    roller_contacts(rollers, contacts, drive, slope)


@kernel(forceinline=True)
def push_contacts(rollers, inner, outer, contacts, drive):
    """Impulses of the normal forces over one step on the surface nodes."""
    w, lightness, columns, n = rollers.w, rollers.lightness, rollers.columns, rollers.n
    first, n_surface = rollers.first_surface, rollers.n_surface
    inner_u, inner_w, inner_mass = inner.u, inner.w, inner.row_mass[inner.raceway]
    outer_u, outer_w, outer_mass = outer.u, outer.w, outer.row_mass[outer.raceway]
    start, weight, along, across = contacts.start, contacts.weight, contacts.along, contacts.across
    push, outward, normal = contacts.push, contacts.outward, contacts.normal
    stretch, dt = contacts.stretch, drive.dt
    on_nodes = 0.0
    for kind in range(3):
        for j in range(n):
            if push[kind, j] == 0.0:
                continue
            p, given = 2 * kind, -push[kind, j] * dt
            i = second(kind, j, n)
            if kind == INNER and len(inner.rigid) > 0:
                drive.impulse[0] += given * normal[kind, 0, j]
                drive.impulse[1] += given * normal[kind, 1, j]
            elif kind == INNER:
                on_nodes += patch.push_ring(
                    inner_u,
                    inner_w,
                    inner.raceway,
                    inner.n_sectors,
                    inner.radius,
                    inner_mass,
                    given,
                    start,
                    along,
                    across,
                    p,
                    j,
                    stretch,
                )
            elif kind == OUTER and len(outer.rigid) > 0:
                pass  # the ground's
            elif kind == OUTER:
                patch.push_ring(
                    outer_u,
                    outer_w,
                    outer.raceway,
                    outer.n_sectors,
                    outer.radius,
                    outer_mass,
                    -given,
                    start,
                    along,
                    across,
                    p,
                    j,
                    stretch,
                )
            elif len(rollers.rigid) == 0:
                x, y = given * outward[p, 0, j], given * outward[p, 1, j]
                patch.push_roller(w, lightness, columns, j, first, n_surface, x, y, start, weight, p, j, stretch)
            p += 1
            if len(rollers.rigid) == 0:
                x, y = given * outward[p, 0, j], given * outward[p, 1, j]
                patch.push_roller(w, lightness, columns, i, first, n_surface, x, y, start, weight, p, j, stretch)
    drive.ring[4] += on_nodes
    if len(rollers.rigid) > 0:
        push_whole(rollers)


@kernel(forceinline=True)
def second(kind, j, n):
    """The roller on side 1 of contact j."""
    if kind != ROLLER:
        return j
    return j + 1 if j + 1 < n else 0


@kernel(forceinline=True)
def next_rollers(group, n):
    """The rollers after eight from `group` on, lanes; of the last and of spare lanes the first."""
    after = count_from(group) + 1
    return select(after >= n, 0, after)


@kernel(forceinline=True)
def _open(contacts, row):
    """Eight contacts out of reach."""
    store(contacts.force, row, splat(0.0))
    store(contacts.push, row, splat(0.0))
    store(contacts.approach, row, splat(np.nan))


@kernel(forceinline=True)
def _press(contacts, kind, row, near, closed, level):
    """Forces of eight contacts and what a kick gives, N; 0 where they are not near."""
    A, B, Q_line = contacts.A[kind], contacts.B[kind], contacts.Q_line[kind]
    force, bracket, approach = contacts.force, contacts.bracket, contacts.approach
    push, owed = contacts.push, contacts.owed
    level = B + level * (1.0 / A)
    inside = select(near, closed, -1.0)
    before = load(force, row)
    Q = contact_force(inside, A, level, Q_line, before)
    P, owes = kick_force(
        load(approach, row), before, load(bracket, row), load(push, row), load(owed, row), inside, Q, level, A, Q_line
    )
    P = select(near, P, 0.0)
    store(force, row, Q)
    store(bracket, row, level)
    store(approach, row, select(near, closed, np.nan))
    store(push, row, P)
    store(owed, row, owes)
    return Q, P


@kernel(forceinline=True)
def _add(array, at, lanes):
    """array[at : at + 8] += lanes."""
    store(array, at, load(array, at) + lanes)


@kernel(forceinline=True)
def _raceway(kind, inner, outer, contacts):
    """What `ring_contacts` reads of a ring; by value, lest its code be there twice and crowd the instruction cache."""
    if kind == INNER:
        u, row, n_sectors, radius, rigid = inner.u, inner.raceway, inner.n_sectors, inner.radius, len(inner.rigid) > 0
        return u, row, n_sectors, radius, inner.cosines, inner.sines, contacts.inner_ripple, rigid
    u, row, n_sectors, radius, rigid = outer.u, outer.raceway, outer.n_sectors, outer.radius, len(outer.rigid) > 0
    return u, row, n_sectors, radius, outer.cosines, outer.sines, contacts.outer_ripple, rigid


@kernel(forceinline=True)
def ring_contacts(kind, rollers, inner, outer, contacts, drive, slope):
    """Rollers on a raceway: normal from the ring's centre to the roller."""
    ring_u, raceway, n_sectors, ring_radius, cosines, sines, ripples, rigid = _raceway(kind, inner, outer, contacts)
    u, columns, n, radius = rollers.u, rollers.columns, rollers.n, rollers.radius
    first, n_surface, dt = rollers.first_surface, rollers.n_surface, drive.dt
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    start, weight, along, across = contacts.start, contacts.weight, contacts.along, contacts.across
    normal, outward = contacts.normal, contacts.outward
    sign, hub_x, hub_y, ring_c, ring_s = -1.0, 0.0, 0.0, 1.0, 0.0  # outward of the outer raceway is −n
    if kind == INNER:
        sign, hub_x, hub_y, ring_c, ring_s = 1.0, drive.hub[0], drive.hub[1], drive.ring[1], drive.ring[2]
    hub_tilt_x, hub_tilt_y, moment = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        row = kind * columns + group
        x, y = load(centre, group) - hub_x, load(centre, columns + group) - hub_y
        distance = root(x * x + y * y)
        overlap = sign * (ring_radius - distance) + radius
        near = (overlap >= -contacts.reach) & (count_from(group) < n)
        if not any_lane(near):
            _open(contacts, row)
            continue
        scale = 1.0 / select(near, distance, 1.0)
        nx, ny = select(near, x * scale, 1.0), select(near, y * scale, 0.0)
        if rigid:
            out, side, rate, ripple, ripple_rate = still(hub_x * nx + hub_y * ny, hub_y * nx - hub_x * ny)
        else:
            out, side, rate, ripple, ripple_rate = patch.read_ring(
                ring_u,
                raceway,
                n_sectors,
                cosines,
                sines,
                ring_c * nx + ring_s * ny,
                ring_c * ny - ring_s * nx,
                ripples,
                start,
                weight,
                along,
                across,
                columns,
                2 * kind,
                group,
                slope,
            )
        out -= hub_x * nx + hub_y * ny  # the inner ring's state holds the hub's motion
        side -= hub_y * nx - hub_x * ny
        c, s = load(cosine, group), load(sine, group)
        bx, by = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
        if len(rollers.rigid) > 0:
            out_r, side_r, rate_r, ripple_r, ripple_rate_r = still(splat(0.0), splat(0.0))
        else:
            out_r, side_r, rate_r, ripple_r, ripple_rate_r = patch.read_roller(
                u,
                count_from(group),
                columns,
                first,
                n_surface,
                bx,
                by,
                contacts.roller_ripple,
                start,
                weight,
                2 * kind + 1,
                group,
                slope,
            )
        Q, P = _press(contacts, kind, row, near, overlap + sign * out + out_r, ripple + ripple_r)
        store(normal, 2 * kind * columns + group, nx)
        store(normal, (2 * kind + 1) * columns + group, ny)
        store(outward, (4 * kind + 2) * columns + group, bx)
        store(outward, (4 * kind + 3) * columns + group, by)
        half = 0.5 * Q * Q
        push = P * (sign * dt)
        _add(impulse, group, push * nx)
        _add(impulse, columns + group, push * ny)
        aside = P * (sign * (rate + side) + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)
        aside = aside * scale * dt
        _add(tilt, group, aside * ny)
        _add(tilt, columns + group, -(aside * nx))
        _add(turn_kick, group, (P * rate_r - half * ripple_rate_r) * (dt / rollers.inertia))
        hub_tilt_x -= aside * ny
        hub_tilt_y += aside * nx
        moment += half * ripple_rate - P * rate
    if kind == INNER:
        drive.impulse[0] += total(hub_tilt_x)
        drive.impulse[1] += total(hub_tilt_y)
        drive.ring[3] += total(moment)


@kernel(forceinline=True)
def roller_contacts(rollers, contacts, drive, slope):
    """Roller j on roller j + 1: normal from j to j + 1."""
    u, columns, n, radius = rollers.u, rollers.columns, rollers.n, rollers.radius
    first, n_surface, dt = rollers.first_surface, rollers.n_surface, drive.dt
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    start, weight, ripples = contacts.start, contacts.weight, contacts.roller_ripple
    normal, outward = contacts.normal, contacts.outward
    touching = 2.0 * radius + contacts.reach
    for group in range(0, n, WIDTH):
        row, j, i = ROLLER * columns + group, count_from(group), next_rollers(group, n)
        x = gather(centre, i) - load(centre, group)
        y = gather(centre, i + columns) - load(centre, columns + group)
        square = x * x + y * y
        near = (square <= touching * touching) & (j < n)
        if not any_lane(near):
            _open(contacts, row)
            continue
        distance = select(near, root(square), 1.0)
        scale = 1.0 / distance
        nx, ny = select(near, x * scale, 1.0), select(near, y * scale, 0.0)
        c, s, c_i, s_i = load(cosine, group), load(sine, group), gather(cosine, i), gather(sine, i)
        ax, ay = c * nx + s * ny, c * ny - s * nx
        bx, by = -(c_i * nx + s_i * ny), s_i * nx - c_i * ny
        if len(rollers.rigid) > 0:
            out, side, rate, ripple, ripple_rate = still(splat(0.0), splat(0.0))
            out_i, side_i, rate_i, ripple_i, ripple_rate_i = still(splat(0.0), splat(0.0))
        else:
            out, side, rate, ripple, ripple_rate = patch.read_roller(
                u, j, columns, first, n_surface, ax, ay, ripples, start, weight, 2 * ROLLER, group, slope
            )
            out_i, side_i, rate_i, ripple_i, ripple_rate_i = patch.read_roller(
                u, i, columns, first, n_surface, bx, by, ripples, start, weight, 2 * ROLLER + 1, group, slope
            )
        Q, P = _press(contacts, ROLLER, row, near, 2.0 * radius - distance + out + out_i, ripple + ripple_i)
        store(normal, 2 * ROLLER * columns + group, nx)
        store(normal, (2 * ROLLER + 1) * columns + group, ny)
        store(outward, 4 * ROLLER * columns + group, ax)
        store(outward, (4 * ROLLER + 1) * columns + group, ay)
        store(outward, (4 * ROLLER + 2) * columns + group, bx)
        store(outward, (4 * ROLLER + 3) * columns + group, by)
        half = 0.5 * Q * Q
        push_x, push_y = P * nx * dt, P * ny * dt
        aside = P * (rate + side + rate_i + side_i) - half * (ripple_rate + ripple_rate_i)
        aside = aside * scale * dt
        over = dt / rollers.inertia
        scatter_add(impulse, i, push_x)
        scatter_add(impulse, i + columns, push_y)
        scatter_add(tilt, i, aside * ny)
        scatter_add(tilt, i + columns, -(aside * nx))
        scatter_add(turn_kick, i, (P * rate_i - half * ripple_rate_i) * over)
        _add(impulse, group, -push_x)
        _add(impulse, columns + group, -push_y)
        _add(tilt, group, -(aside * ny))
        _add(tilt, columns + group, aside * nx)
        _add(turn_kick, group, (P * rate - half * ripple_rate) * over)
