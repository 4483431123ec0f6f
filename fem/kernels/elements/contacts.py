"""CONTACT FORCES: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.

Eight contacts at a time: lanes are rollers, of which the last may be spare. Arrays of contacts are (pair, roller).

Equation (2) of docs/method.md.
"""

import numpy as np

from fem.kernels import lanes
from fem.kernels.elements import surfaces
from fem.kernels.elements.state import DiscSurface, Pair
from fem.kernels.elements.tilted import SlicedLaw, press_tilted
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import load_pair, next_rollers, store_pair
from fem.kernels.lanes import WIDTH, any_lane, count_from, load, select, splat, store, total
from fem.kernels.law import kick_force, lowered_ring, lowered_rollers, next_force


@part
def press_patches(groups, rollers, disc, contacts, drive):
    """Normal forces of all pairs. Contacts go through it step by step together: one alone waits for its own numbers."""
    _meet_all(groups, rollers, disc, contacts)
    _read_all(groups, rollers, disc, contacts)
    _press_all(groups, rollers, disc, contacts, drive)


@part
def first_surface(pair, disc):
    """The surface on side 0."""
    return disc if pair.surface is None else pair.surface


@part
def second_rollers(pair, group, n):
    """The rollers on side 1 of eight contacts, lanes."""
    return next_rollers(group, n) if pair.surface is None else count_from(group)


@part
def share_out(array, pair, group, n, x, y):
    """Add x and y, lanes, to what side 1's rollers of eight contacts have in (2, columns), and the opposite to side 0's
    if these are rollers too."""
    columns = array.shape[1]
    if pair.surface is not None:
        lanes.scatter_add(array, group, x)
        lanes.scatter_add(array, columns + group, y)
    else:
        i = next_rollers(group, n)
        lanes.scatter_add(array, i, x)
        lanes.scatter_add(array, i + columns, y)
        lanes.scatter_add(array, group, -x)
        lanes.scatter_add(array, columns + group, -y)


@part
def share_nodes(pair, rollers, disc, group, x, y):
    """The same of impulses, N s, that nodes of rollers are given, to their centres' motion."""
    if isinstance(disc, DiscSurface):
        share_out(disc.impulse, pair, group, rollers.n, x, y)


@part
def with_dampers(dampers, row, force):
    """Forces of eight contacts with their dampers', N."""
    return force if dampers is None else force + load(dampers.force, row)


@part
def _are_near(contacts, row):
    """Whether any of eight circles are near: the overlaps of others are not a number."""
    overlap = load(contacts.forces.overlap, row)
    return any_lane(overlap == overlap)


@part
def _meet(pair, rollers, disc, contacts):
    """Overlaps of a pair's undeformed circles, normals, and patches on both sides."""
    forces, patches, centre, columns, n = contacts.forces, contacts.patches, rollers.centre, rollers.columns, rollers.n
    cosine, sine, sign, side = rollers.cosine, rollers.sine, pair.sign, 2 * pair.row
    for group in range(0, n, WIDTH):
        row = pair.row * columns + group
        x, y = load_pair(centre, group, columns)
        if pair.surface is not None:
            x, y = x - pair.centre[0], y - pair.centre[1]
            distance = lanes.square_root(x * x + y * y)
            overlap = sign * (pair.radius - distance) + rollers.radius
        else:
            i = next_rollers(group, n)
            x, y = lanes.gather(centre, i) - x, lanes.gather(centre, i + columns) - y
            distance = lanes.square_root(x * x + y * y)
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
        store_pair(patches.normal, side * columns + group, columns, nx, ny)
        c, s = load(cosine, group), load(sine, group)
        if pair.surface is not None:
            c_0, s_0 = pair.frame[1], pair.frame[2]
        else:
            c_0, s_0, c, s = c, s, lanes.gather(cosine, i), lanes.gather(sine, i)
        store_pair(patches.outward, 2 * side * columns + group, columns, c_0 * nx + s_0 * ny, c_0 * ny - s_0 * nx)
        bx, by = -sign * (c * nx + s * ny), sign * (s * nx - c * ny)
        store_pair(patches.outward, 2 * (side + 1) * columns + group, columns, bx, by)
        surfaces.locate_patch(first_surface(pair, disc), patches, side, group)
        surfaces.locate_patch(disc, patches, side + 1, group)


@part
def _read(pair, rollers, disc, contacts):
    patches, side, columns, n = contacts.patches, 2 * pair.row, rollers.columns, rollers.n
    for group in range(0, n, WIDTH):
        if _are_near(contacts, pair.row * columns + group):
            _keep_motion(first_surface(pair, disc), patches, side, group, count_from(group))
    for group in range(0, n, WIDTH):
        if _are_near(contacts, pair.row * columns + group):
            _keep_motion(disc, patches, side + 1, group, second_rollers(pair, group, n))


@part
def _keep_motion(surface, patches, side, group, column):
    motion = surfaces.interpolate_displacement(surface, patches, side, group, column)
    out, sideways, rate, ripple, ripple_rate = motion
    at, columns = 5 * side * patches.columns + group, patches.columns
    store_pair(patches.motion, at, columns, out, sideways)
    store_pair(patches.motion, at + 2 * columns, columns, rate, ripple)
    store(patches.motion, at + 4 * columns, ripple_rate)


@part
def _kept_motion(patches, side, group):
    """Outward motion, its slope, ripple and its slope, and sideways motion."""
    at, columns, motion = 5 * side * patches.columns + group, patches.columns, patches.motion
    (out, sideways), (rate, ripple) = load_pair(motion, at, columns), load_pair(motion, at + 2 * columns, columns)
    return (out, rate, ripple, load(motion, at + 4 * columns)), sideways


@part
def _press(pair, rollers, disc, contacts, drive):
    """Normal forces of a pair's contacts by the law below the grid, and their impulses in a step on whole bodies."""
    forces, patches, columns, dt, sign = contacts.forces, contacts.patches, rollers.columns, drive.dt, pair.sign
    turn_kick, law, n = rollers.turn_kick, pair.law, rollers.n
    ring_x, ring_y, moment = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        row, side = pair.row * columns + group, 2 * pair.row
        overlap = load(forces.overlap, row)
        near = overlap == overlap
        if not any_lane(near):
            continue
        nx, ny = load_pair(patches.normal, side * columns + group, columns)
        motion, sideways = _kept_motion(patches, side, group)
        own, sideways_r = _kept_motion(patches, side + 1, group)
        if pair.surface is not None:
            bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
            out, rate, ripple, ripple_rate = lowered_ring(pair.profile, sign, motion, bx, by)
            away_x, away_y = pair.counted_from[0], pair.counted_from[1]
            out -= away_x * nx + away_y * ny
            sideways -= away_y * nx - away_x * ny
            bx, by = load_pair(patches.outward, 2 * (side + 1) * columns + group, columns)
            out_r, rate_r, ripple_r, ripple_rate_r = lowered_rollers(pair.roller_profiles, group, own, bx, by)
        else:
            (out, rate, ripple, ripple_rate), (out_r, rate_r, ripple_r, ripple_rate_r) = motion, own
        approach = overlap + sign * out + out_r
        slopes = sign * (rate + sideways) + rate_r + sideways_r, sign * rate, rate_r
        if contacts.dampers is not None:  # how fast approaches have grown, and by which slopes they change
            dampers = contacts.dampers
            store(dampers.rate, row, (approach - load(forces.approach, row)) * (1.0 / dt))
            store(dampers.along, row, slopes[0] * load(forces.nearness, row))
            store(dampers.first, row, slopes[1])
            store(dampers.second, row, slopes[2])
        if isinstance(law, SlicedLaw):
            normal, met = (nx, ny), (near, approach, ripple + ripple_r)
            Q, P, across = press_tilted(law, rollers, forces, group, row, normal, met, dt)
        else:
            # the law's A B is more by the ripple
            level, inside = law.B + (ripple + ripple_r) * (1.0 / law.A), select(near, approach, -1.0)
            before, approach_before = load(forces.force, row), load(forces.approach, row)
            level_before = load(forces.bracket, row)
            Q = next_force(inside, law.A, level, law.Q_line, before, approach_before, level_before)
            last = approach_before, before, level_before, load(forces.kick, row), load(forces.residual, row)
            P, residual = kick_force((law.A, law.Q_line), last, (inside, Q, level))
            P = select(near, P, 0.0)
            store(forces.force, row, Q)
            store(forces.bracket, row, level)
            store(forces.approach, row, select(near, approach, np.nan))
            store(forces.kick, row, P)
            store(forces.residual, row, residual)
        half, given, over = 0.5 * Q * Q, P * (sign * dt), dt / rollers.inertia
        tilting = P * slopes[0] - half * (ripple_rate + ripple_rate_r)
        if isinstance(law, SlicedLaw):
            tilting = tilting - across
        tilting = tilting * load(forces.nearness, row) * dt
        share_out(rollers.node_impulse, pair, group, n, given * nx, given * ny)
        share_out(rollers.body_impulse, pair, group, n, tilting * ny, -(tilting * nx))
        turned = (P * rate_r - half * ripple_rate_r) * over
        if pair.surface is not None:
            lanes.scatter_add(turn_kick, group, turned)
            ring_x -= tilting * ny
            ring_y += tilting * nx
            moment += half * ripple_rate - P * slopes[1]
        else:
            lanes.scatter_add(turn_kick, next_rollers(group, n), turned)
            lanes.scatter_add(turn_kick, group, (P * rate - half * ripple_rate) * over)
    if pair.surface is not None:
        pair.impulse[0] += total(ring_x)
        pair.impulse[1] += total(ring_y)
        pair.moment[0] += total(moment)


_meet_all, _read_all, _press_all = every(_meet, Pair), every(_read, Pair), every(_press, Pair)


@part
def scatter_normal_forces(pair, rollers, disc, contacts, dampers, dt):
    """Give the surface nodes of a pair the impulses of its normal forces in a step, and of the dampers' if not None."""
    patches, kick, side, moment = contacts.patches, contacts.forces.kick, 2 * pair.row, splat(0.0)
    surface = first_surface(pair, disc)
    surfaces.ghost_nodes(surface, surfaces.CLEAR)
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        given = with_dampers(dampers, row, load(kick, row)) * -dt
        if any_lane(given != 0.0):
            moment += surfaces.scatter_force(surface, patches, side, group, given * pair.sign, None)
            surfaces.scatter_force(disc, patches, side + 1, group, given, None)
    surfaces.ghost_nodes(surface, surfaces.GIVE)
    if pair.surface is not None:
        pair.moment[1] += total(moment)


@part
def _push_touching(pair, rollers, disc, contacts, dt):
    if pair.surface is None:
        scatter_normal_forces(pair, rollers, disc, contacts, None, dt)


push_patches, push_neighbours = every(scatter_normal_forces, Pair), every(_push_touching, Pair)
