"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.

Eight contacts at a time: lanes are rollers, of which the last may be spare. Arrays of contacts are (pair, roller).
"""

import numpy as np

from fem.kernels.jit import every, part, verb
from fem.kernels.law import contact_force, kick_force
from fem.kernels.profile_kernels import lowered_ring, lowered_rollers
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
from fem.kernels.state import Neighbours, Raceway
from fem.kernels.surfaces import push, read


@verb
def press(pair, rollers, disc, contacts, drive):
    """Normal forces of a pair's contacts by the law below the grid, and their impulses in a step on whole bodies."""


@verb
def push_nodes(pair, rollers, disc, contacts, drive):
    """Give the surface nodes of a pair the impulses of its normal forces in a step."""


press_patches = every(press)
push_patches, push_neighbours = every(push_nodes), every(push_nodes, Neighbours)


@verb
def first_surface(pair, disc):
    """The surface on side 0."""


@first_surface.of(Raceway)
def _of_raceway(raceway, disc):
    return raceway.surface


@first_surface.of(Neighbours)
def _of_neighbours(pair, disc):
    return disc


@part
def next_rollers(group, n):
    """The rollers after eight from `group` on, lanes; of the last and of spare lanes the first."""
    after = count_from(group) + 1
    return select(after >= n, 0, after)


@part
def next_roller(j, n):
    """The roller after roller j."""
    return j + 1 if j + 1 < n else 0


@part
def _open(forces, row):
    """Eight contacts out of reach."""
    store(forces.force, row, splat(0.0))
    store(forces.kick, row, splat(0.0))
    store(forces.approach, row, splat(np.nan))


@part
def _press(law, forces, row, near, closed, level):
    """Forces of eight contacts and what a kick gives, N; 0 where they are not near."""
    level = law.B + level * (1.0 / law.A)
    inside = select(near, closed, -1.0)
    before = load(forces.force, row)
    Q = contact_force(inside, law.A, level, law.Q_line, before)
    P, residual = kick_force(
        load(forces.approach, row), before, load(forces.bracket, row), load(forces.kick, row),
        load(forces.residual, row), inside, Q, level, law.A, law.Q_line,
    )  # fmt: skip
    P = select(near, P, 0.0)
    store(forces.force, row, Q)
    store(forces.bracket, row, level)
    store(forces.approach, row, select(near, closed, np.nan))
    store(forces.kick, row, P)
    store(forces.residual, row, residual)
    return Q, P


@part
def _note_rate(dampers, forces, row, closed, dt):
    """How fast eight approaches have grown since the last kick, for their dampers."""
    if dampers is not None:
        store(dampers.rate, row, (closed - load(forces.approach, row)) * (1.0 / dt))


@part
def with_dampers(dampers, row, force):
    """Forces of eight contacts with those that their dampers had last, N."""
    if dampers is None:
        return force
    return force + load(dampers.force, row)


@part
def _add(array, at, lanes):
    """array[at : at + 8] += lanes."""
    store(array, at, load(array, at) + lanes)


@part
def _store_pair(array, at, columns, x, y):
    """Components x and y of eight contacts' vectors."""
    store(array, at, x)
    store(array, at + columns, y)


@press.of(Raceway)
def _press_raceway(raceway, rollers, disc, contacts, drive):
    forces, patches, reach = contacts.forces, contacts.patches, contacts.reach
    columns, n, radius, centre, dt = rollers.columns, rollers.n, rollers.radius, rollers.centre, drive.dt
    sign, ring_c, ring_s = raceway.sign, raceway.frame[1], raceway.frame[2]
    ring_x, ring_y = raceway.centre[0], raceway.centre[1]
    away_x, away_y = raceway.counted_from[0], raceway.counted_from[1]
    ring_tilt_x, ring_tilt_y, moment = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        row, side = raceway.row * columns + group, 2 * raceway.row
        x, y = load(centre, group) - ring_x, load(centre, columns + group) - ring_y
        distance = root(x * x + y * y)
        overlap = sign * (raceway.radius - distance) + radius
        near = (overlap >= -reach) & (count_from(group) < n)
        if not any_lane(near):
            _open(forces, row)
            continue
        scale = 1.0 / select(near, distance, 1.0)
        nx, ny = select(near, x * scale, 1.0), select(near, y * scale, 0.0)
        bx, by = ring_c * nx + ring_s * ny, ring_c * ny - ring_s * nx
        out, sideways, rate, ripple, ripple_rate = read(raceway.surface, patches, side, group, 0, bx, by)
        motion = out, rate, ripple, ripple_rate
        out, rate, ripple, ripple_rate = lowered_ring(raceway.profile, sign, motion, bx, by)
        out -= away_x * nx + away_y * ny
        sideways -= away_y * nx - away_x * ny
        c, s = load(rollers.cosine, group), load(rollers.sine, group)
        bx, by = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
        out_r, sideways_r, rate_r, ripple_r, ripple_rate_r = read(
            disc, patches, side + 1, group, count_from(group), bx, by
        )
        motion = out_r, rate_r, ripple_r, ripple_rate_r
        out_r, rate_r, ripple_r, ripple_rate_r = lowered_rollers(raceway.roller_profiles, group, motion, bx, by)
        closed = overlap + sign * out + out_r
        _note_rate(contacts.dampers, forces, row, closed, dt)
        Q, P = _press(raceway.law, forces, row, near, closed, ripple + ripple_r)
        _store_pair(patches.normal, side * columns + group, columns, nx, ny)
        _store_pair(patches.outward, 2 * (side + 1) * columns + group, columns, bx, by)
        half = 0.5 * Q * Q
        given = P * (sign * dt)
        _add(rollers.node_impulse, group, given * nx)
        _add(rollers.node_impulse, columns + group, given * ny)
        P = with_dampers(contacts.dampers, row, P)
        aside = P * (sign * (rate + sideways) + rate_r + sideways_r) - half * (ripple_rate + ripple_rate_r)
        aside = aside * scale * dt
        _add(rollers.body_impulse, group, aside * ny)
        _add(rollers.body_impulse, columns + group, -(aside * nx))
        _add(rollers.turn_kick, group, (P * rate_r - half * ripple_rate_r) * (dt / rollers.inertia))
        ring_tilt_x -= aside * ny
        ring_tilt_y += aside * nx
        moment += half * ripple_rate - P * rate
    raceway.impulse[0] += total(ring_tilt_x)
    raceway.impulse[1] += total(ring_tilt_y)
    raceway.moment[0] += total(moment)


@press.of(Neighbours)
def _press_neighbours(pair, rollers, disc, contacts, drive):
    forces, patches = contacts.forces, contacts.patches
    columns, n, radius, centre, dt = rollers.columns, rollers.n, rollers.radius, rollers.centre, drive.dt
    cosine, sine = rollers.cosine, rollers.sine
    impulse, body_impulse, turn_kick = rollers.node_impulse, rollers.body_impulse, rollers.turn_kick
    touching = 2.0 * radius + contacts.reach
    for group in range(0, n, WIDTH):
        row, side, j, i = pair.row * columns + group, 2 * pair.row, count_from(group), next_rollers(group, n)
        x = gather(centre, i) - load(centre, group)
        y = gather(centre, i + columns) - load(centre, columns + group)
        square = x * x + y * y
        near = (square <= touching * touching) & (j < n)
        if not any_lane(near):
            _open(forces, row)
            continue
        distance = select(near, root(square), 1.0)
        scale = 1.0 / distance
        nx, ny = select(near, x * scale, 1.0), select(near, y * scale, 0.0)
        c, s, c_i, s_i = load(cosine, group), load(sine, group), gather(cosine, i), gather(sine, i)
        ax, ay = c * nx + s * ny, c * ny - s * nx
        bx, by = -(c_i * nx + s_i * ny), s_i * nx - c_i * ny
        out, sideways, rate, ripple, ripple_rate = read(disc, patches, side, group, j, ax, ay)
        out_i, sideways_i, rate_i, ripple_i, ripple_rate_i = read(disc, patches, side + 1, group, i, bx, by)
        closed = 2.0 * radius - distance + out + out_i
        _note_rate(contacts.dampers, forces, row, closed, dt)
        Q, P = _press(pair.law, forces, row, near, closed, ripple + ripple_i)
        _store_pair(patches.normal, side * columns + group, columns, nx, ny)
        _store_pair(patches.outward, 2 * side * columns + group, columns, ax, ay)
        _store_pair(patches.outward, 2 * (side + 1) * columns + group, columns, bx, by)
        half = 0.5 * Q * Q
        push_x, push_y = P * nx * dt, P * ny * dt
        P = with_dampers(contacts.dampers, row, P)
        aside = P * (rate + sideways + rate_i + sideways_i) - half * (ripple_rate + ripple_rate_i)
        aside = aside * scale * dt
        over = dt / rollers.inertia
        scatter_add(impulse, i, push_x)
        scatter_add(impulse, i + columns, push_y)
        scatter_add(body_impulse, i, aside * ny)
        scatter_add(body_impulse, i + columns, -(aside * nx))
        scatter_add(turn_kick, i, (P * rate_i - half * ripple_rate_i) * over)
        _add(impulse, group, -push_x)
        _add(impulse, columns + group, -push_y)
        _add(body_impulse, group, -(aside * ny))
        _add(body_impulse, columns + group, aside * nx)
        _add(turn_kick, group, (P * rate - half * ripple_rate) * over)


@push_nodes.of(Raceway)
def _push_raceway(raceway, rollers, disc, contacts, drive):
    patches, kick, side, moment = contacts.patches, contacts.forces.kick, 2 * raceway.row, 0.0
    for j in range(rollers.n):
        if kick[raceway.row, j] != 0.0:
            given = -kick[raceway.row, j] * drive.dt
            moment += push(raceway.surface, patches, side, j, j, raceway.sign * given)
            push(disc, patches, side + 1, j, j, given)
    raceway.moment[1] += moment


@push_nodes.of(Neighbours)
def _push_neighbours(pair, rollers, disc, contacts, drive):
    patches, kick, side = contacts.patches, contacts.forces.kick, 2 * pair.row
    for j in range(rollers.n):
        if kick[pair.row, j] != 0.0:
            given = -kick[pair.row, j] * drive.dt
            push(disc, patches, side, j, j, given)
            push(disc, patches, side + 1, j, next_roller(j, rollers.n), given)
