"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.

Eight contacts at a time: lanes are rollers, of which the last may be spare. Arrays of contacts are (pair, roller).

Equation (2) of docs/method.md.
"""

import numpy as np

from fem.kernels.jit import every, part, verb
from fem.kernels.lane_memory import gather, load, scatter_add, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, square_root, total
from fem.kernels.law import kick_force, next_force
from fem.kernels.state import Pair
from fem.kernels.surfaces import (
    accumulate_ghost_nodes,
    clear_ghost_nodes,
    interpolate_displacement,
    keep_motion,
    kept_motion,
    locate_patch,
    lowered_ring,
    lowered_rollers,
    scatter_normal_force,
)


@verb
def normal_forces(pair, rollers, disc, contacts, drive):
    """Normal forces of a pair's contacts by the law below the grid, and their impulses in a step on whole bodies."""


@part
def press_patches(groups, rollers, disc, contacts, drive):
    """Normal forces of all pairs. Contacts go through it step by step together: one alone waits for its own numbers."""
    meet_all(groups, rollers, disc, contacts)
    place_all(groups, rollers, disc, contacts)
    read_all(groups, rollers, disc, contacts)
    press_all(groups, rollers, disc, contacts, drive)


@part
def first_surface(pair, disc):
    """The surface on side 0."""
    return disc if pair.surface is None else pair.surface


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
def _met(contacts, row):
    """Overlaps of eight circles, and whether they are near; the others' are not a number."""
    overlap = load(contacts.forces.overlap, row)
    return overlap, overlap == overlap


@part
def contact_kinematics(pair, rollers, disc, contacts):
    """Overlaps of a pair's undeformed circles, normals and outward directions on both sides."""
    forces, patches, centre, columns, n = contacts.forces, contacts.patches, rollers.centre, rollers.columns, rollers.n
    cosine, sine, sign, side = rollers.cosine, rollers.sine, pair.sign, 2 * pair.row
    for group in range(0, n, WIDTH):
        row = pair.row * columns + group
        x, y = load(centre, group), load(centre, columns + group)
        if pair.surface is not None:
            x, y = x - pair.centre[0], y - pair.centre[1]
            distance = square_root(x * x + y * y)
            overlap = sign * (pair.radius - distance) + rollers.radius
        else:
            i = next_rollers(group, n)
            x, y = gather(centre, i) - x, gather(centre, i + columns) - y
            distance = square_root(x * x + y * y)
            overlap = 2.0 * rollers.radius - distance
        near = (overlap >= -contacts.reach) & (count_from(group) < n)
        store(forces.overlap, row, select(near, overlap, np.nan))
        if not any_lane(near):
            store(forces.force, row, splat(0.0))
            store(forces.kick, row, splat(0.0))
            store(forces.approach, row, splat(np.nan))
            continue
        scale = 1.0 / select(near, distance, 1.0)
        nx, ny = select(near, x * scale, 1.0), select(near, y * scale, 0.0)
        store(forces.nearness, row, scale)
        _store_pair(patches.normal, side * columns + group, columns, nx, ny)
        c, s = load(cosine, group), load(sine, group)
        if pair.surface is not None:
            c_0, s_0 = pair.frame[1], pair.frame[2]
        else:
            c_0, s_0, c, s = c, s, gather(cosine, i), gather(sine, i)
        _store_pair(patches.outward, 2 * side * columns + group, columns, c_0 * nx + s_0 * ny, c_0 * ny - s_0 * nx)
        bx, by = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
        _store_pair(patches.outward, 2 * (side + 1) * columns + group, columns, bx, by)


@part
def _place(pair, rollers, disc, contacts):
    """Where the patches of a pair's contacts lie."""
    surface, patches, columns = first_surface(pair, disc), contacts.patches, rollers.columns
    for group in range(0, rollers.n, WIDTH):
        if any_lane(_met(contacts, pair.row * columns + group)[1]):
            locate_patch(surface, patches, 2 * pair.row, group)
            locate_patch(disc, patches, 2 * pair.row + 1, group)


@part
def _read(pair, rollers, disc, contacts):
    """Motion of the patches of a pair's contacts."""
    surface, patches, columns = first_surface(pair, disc), contacts.patches, rollers.columns
    for group in range(0, rollers.n, WIDTH):
        if any_lane(_met(contacts, pair.row * columns + group)[1]):
            keep_motion(
                patches,
                2 * pair.row,
                group,
                interpolate_displacement(surface, patches, 2 * pair.row, group, count_from(group)),
            )
    for group in range(0, rollers.n, WIDTH):
        if any_lane(_met(contacts, pair.row * columns + group)[1]):
            found = interpolate_displacement(
                disc, patches, 2 * pair.row + 1, group, second_rollers(pair, group, rollers.n)
            )
            keep_motion(patches, 2 * pair.row + 1, group, found)


meet_all, place_all, read_all = every(contact_kinematics, Pair), every(_place, Pair), every(_read, Pair)
press_all = every(normal_forces)


@part
def second_rollers(pair, group, n):
    """The rollers on side 1 of eight contacts, lanes."""
    return next_rollers(group, n) if pair.surface is None else count_from(group)


@verb
def press(law, rollers, forces, at, normal, met, level, dt):
    """Forces of eight contacts and what a kick gives, N; 0 where they are not near.

    Parameters
    ----------
    at : the first of eight rollers, and of their contacts' entries in arrays; met : whether near, and approaches, m
    level : m/N, by which the law's A B is more here
    """
    row, (near, closed) = at[1], met
    level = law.B + level * (1.0 / law.A)
    inside = select(near, closed, -1.0)
    before, approach_before = load(forces.force, row), load(forces.approach, row)
    level_before = load(forces.bracket, row)
    Q = next_force(inside, law.A, level, law.Q_line, before, approach_before, level_before)
    last = approach_before, before, level_before, load(forces.kick, row), load(forces.residual, row)
    P, residual = kick_force((law.A, law.Q_line), last, (inside, Q, level))
    P = select(near, P, 0.0)
    store(forces.force, row, Q)
    store(forces.bracket, row, level)
    store(forces.approach, row, select(near, closed, np.nan))
    store(forces.kick, row, P)
    store(forces.residual, row, residual)
    return Q, P


@verb
def turned_aside(law, row, aside):
    """Forces of eight contacts across their normals, N, times their centres' distances, m, with those of moments."""
    return aside


@part
def with_dampers(dampers, row, force):
    """Forces of eight contacts with their dampers', N."""
    if dampers is None:
        return force
    return force + load(dampers.force, row)


@part
def _store_pair(array, at, columns, x, y):
    """Components x and y of eight contacts' vectors."""
    store(array, at, x)
    store(array, at + columns, y)


@part
def _load_pair(array, at, columns):
    """What `_store_pair` has stored."""
    return load(array, at), load(array, at + columns)


@normal_forces.of(Pair)
def _press(pair, rollers, disc, contacts, drive):
    forces, patches, columns, dt, sign = contacts.forces, contacts.patches, rollers.columns, drive.dt, pair.sign
    impulse, body_impulse, turn_kick = rollers.node_impulse, rollers.body_impulse, rollers.turn_kick
    ring_x, ring_y, moment = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, rollers.n, WIDTH):
        row, side = pair.row * columns + group, 2 * pair.row
        overlap, near = _met(contacts, row)
        if not any_lane(near):
            continue
        nx, ny = _load_pair(patches.normal, side * columns + group, columns)
        motion, sideways = kept_motion(patches, side, group)
        own, sideways_r = kept_motion(patches, side + 1, group)
        if pair.surface is not None:
            i = group
            bx, by = _load_pair(patches.outward, 2 * side * columns + group, columns)
            out, rate, ripple, ripple_rate = lowered_ring(pair.profile, sign, motion, bx, by)
            away_x, away_y = pair.counted_from[0], pair.counted_from[1]
            out -= away_x * nx + away_y * ny
            sideways -= away_y * nx - away_x * ny
            bx, by = _load_pair(patches.outward, 2 * (side + 1) * columns + group, columns)
            out_r, rate_r, ripple_r, ripple_rate_r = lowered_rollers(pair.roller_profiles, group, own, bx, by)
        else:
            i = next_rollers(group, rollers.n)
            (out, rate, ripple, ripple_rate), (out_r, rate_r, ripple_r, ripple_rate_r) = motion, own
        closed = overlap + sign * out + out_r
        slopes = sign * (rate + sideways) + rate_r + sideways_r, sign * rate, rate_r
        if contacts.dampers is not None:  # how fast approaches have grown, and by which slopes they change
            dampers = contacts.dampers
            store(dampers.rate, row, (closed - load(forces.approach, row)) * (1.0 / dt))
            store(dampers.along, row, slopes[0] * load(forces.nearness, row))
            store(dampers.first, row, slopes[1])
            store(dampers.second, row, slopes[2])
        Q, P = press(pair.law, rollers, forces, (group, row), (nx, ny), (near, closed), ripple + ripple_r, dt)
        half, given, over = 0.5 * Q * Q, P * (sign * dt), dt / rollers.inertia
        x, y = given * nx, given * ny
        aside = turned_aside(pair.law, row, P * slopes[0] - half * (ripple_rate + ripple_rate_r))
        aside = aside * load(forces.nearness, row) * dt
        scatter_add(impulse, i, x)
        scatter_add(impulse, i + columns, y)
        scatter_add(body_impulse, i, aside * ny)
        scatter_add(body_impulse, i + columns, -(aside * nx))
        scatter_add(turn_kick, i, (P * rate_r - half * ripple_rate_r) * over)
        if pair.surface is not None:
            ring_x -= aside * ny
            ring_y += aside * nx
            moment += half * ripple_rate - P * slopes[1]
        else:
            scatter_add(impulse, group, -x)
            scatter_add(impulse, columns + group, -y)
            scatter_add(body_impulse, group, -(aside * ny))
            scatter_add(body_impulse, columns + group, aside * nx)
            scatter_add(turn_kick, group, (P * rate - half * ripple_rate) * over)
    if pair.surface is not None:
        pair.impulse[0] += total(ring_x)
        pair.impulse[1] += total(ring_y)
        pair.moment[0] += total(moment)


@part
def scatter_normal_forces(pair, rollers, disc, contacts, dampers, dt):
    """Give the surface nodes of a pair the impulses of its normal forces in a step, and of the dampers' if not None."""
    patches, kick, side, moment = contacts.patches, contacts.forces.kick, 2 * pair.row, splat(0.0)
    surface = first_surface(pair, disc)
    clear_ghost_nodes(surface)
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        given = with_dampers(dampers, row, load(kick, row)) * -dt
        if any_lane(given != 0.0):
            moment += scatter_normal_force(surface, patches, side, group, given * pair.sign)
            scatter_normal_force(disc, patches, side + 1, group, given)
    accumulate_ghost_nodes(surface)
    if pair.surface is not None:
        pair.moment[1] += total(moment)


@part
def _push_touching(pair, rollers, disc, contacts, dt):
    if pair.surface is None:
        scatter_normal_forces(pair, rollers, disc, contacts, None, dt)


push_patches, push_neighbours = every(scatter_normal_forces, Pair), every(_push_touching, Pair)
