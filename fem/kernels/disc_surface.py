"""The surface of elastic rollers."""

from math import pi

from fem.kernels.jit import part
from fem.kernels.lane_memory import add_at_places, gather_pair, gather_places, gather_rows, load, scatter_add, store
from fem.kernels.lanes import select, splat
from fem.kernels.law import seamless
from fem.kernels.patches import N_NODES, dot, products, put, take, weight_slopes, weights
from fem.kernels.state import DiscSurface
from fem.kernels.surfaces import (
    count_impulse,
    first_weight,
    interpolate_displacement,
    locate_patch,
    out_of_surface,
    place_patch,
    scatter_force,
    scatter_normal_force,
    scatter_tangential_force,
    tangential_mobility,
    tangential_velocity,
)


@part
def _take_pairs(array, patches, at):
    """x and y of the six nodes of eight patches."""
    place, step = patches.place, patches.columns
    x0, y0 = gather_places(array, place, at, step)
    x1, y1 = gather_places(array, place, at + step, step)
    x2, y2 = gather_places(array, place, at + 2 * step, step)
    x3, y3 = gather_places(array, place, at + 3 * step, step)
    x4, y4 = gather_places(array, place, at + 4 * step, step)
    x5, y5 = gather_places(array, place, at + 5 * step, step)
    return (x0, x1, x2, x3, x4, x5), (y0, y1, y2, y3, y4, y5)


@locate_patch.of(DiscSurface)
def _locate_patch(disc, patches, side, group):
    place_patch(patches, side, group, disc.n_nodes)


@interpolate_displacement.of(DiscSurface)
def _read(disc, patches, side, group, column):
    columns = patches.columns
    at, stride = first_weight(patches, side, group), 2 * columns
    put(
        patches.inverse_mass,
        at,
        columns,
        gather_rows(disc.inverse_mass, patches.start, side * columns + group, disc.first),
    )
    around, place = disc.n_nodes * stride, (load(patches.start, side * columns + group) + disc.first) * stride + column
    for k in range(N_NODES):
        store(patches.place, at + k * columns, place)
        place += stride
        place = select(place >= disc.first * stride + around, place - around, place)
    t = load(patches.beyond, side * columns + group)
    share, change = weights(t), weight_slopes(t)
    put(patches.weight, at, columns, share)
    x, y = _take_pairs(disc.u, patches, at)
    ux, uy, sx, sy = dot(share, x), dot(share, y), dot(change, x), dot(change, y)
    ripple, ripple_slope = seamless(load(patches.position, side * columns + group), disc.ripple)
    out = 2 * side * columns + group
    bx, by = load(patches.outward, out), load(patches.outward, out + columns)
    per_radian = disc.n_nodes / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@scatter_normal_force.of(DiscSurface)
def _push(disc, patches, side, group, impulse):
    at, columns = first_weight(patches, side, group), patches.columns
    out = 2 * side * columns + group
    x, y = impulse * load(patches.outward, out), impulse * load(patches.outward, out + columns)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        share = load(patches.weight, i) * load(patches.inverse_mass, i)
        add_at_places(disc.w, patches.place, i, columns, share * x, share * y)
    return 0.0


@out_of_surface.of(DiscSurface)
def _out_of_surface(disc, patches, side, group):
    at, columns = first_weight(patches, side, group), patches.columns
    out = 2 * side * columns + group
    along_x, along_y, light = splat(0.0), splat(0.0), splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        share = take(patches.weight, i, columns)
        x, y = _take_pairs(disc.w, patches, i)
        along_x += dot(share, x)
        along_y += dot(share, y)
        light += dot(products(share, share), take(patches.inverse_mass, i, columns))
    return along_x * load(patches.outward, out) + along_y * load(patches.outward, out + columns), light


@part
def _directions(disc, node):
    """Unit directions of the patches' first nodes."""
    x, y = gather_pair(disc.points, (node + disc.first) * 2, 1)
    over = 1.0 / disc.radius
    return x * over, y * over


@part
def _turned(disc, k, first_x, first_y):
    """Unit directions of the nodes k further."""
    over, at = 1.0 / disc.radius, 2 * (disc.first + k)
    c, s = disc.points[at] * over, disc.points[at + 1] * over
    return first_x * c - first_y * s, first_y * c + first_x * s


@tangential_mobility.of(DiscSurface)
def _grip(disc, patches, side, group):
    at, columns = first_weight(patches, side, group), patches.columns
    out = 2 * side * columns + group
    bx, by = load(patches.outward, out), load(patches.outward, out + columns)
    first_x, first_y = _directions(disc, load(patches.start, side * columns + group))
    x, y = splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        node_x, node_y = _turned(disc, k, first_x, first_y)
        store(patches.traction_x, i, node_x)
        store(patches.traction_y, i, node_y)
        share = load(patches.weight, i)
        x += share * node_x
        y += share * node_y
    scale, slope = 1.0 / (1.0 + (bx * x + by * y)), bx * y - by * x
    x, y, mobility = slope * bx - by, slope * by + bx, splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        weight, light = load(patches.weight, i), load(patches.inverse_mass, i)
        share = scale * weight
        along_x = share * (x - load(patches.traction_y, i))
        along_y = share * (y + load(patches.traction_x, i))
        store(patches.traction_x, i, along_x)
        store(patches.traction_y, i, along_y)
        mobility += (along_x * along_x + along_y * along_y) * light
    return mobility


@tangential_velocity.of(DiscSurface)
def _sideways(disc, patches, side, group, column, nx, ny):
    at, columns = first_weight(patches, side, group), patches.columns
    found = splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        x, y = _take_pairs(disc.v, patches, i)
        found += dot(take(patches.traction_x, i, columns), x) + dot(take(patches.traction_y, i, columns), y)
    return found


@scatter_tangential_force.of(DiscSurface)
def _push_along(disc, patches, side, group, impulse):
    at, columns = first_weight(patches, side, group), patches.columns
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        speed = impulse * load(patches.inverse_mass, i)
        x, y = speed * load(patches.traction_x, i), speed * load(patches.traction_y, i)
        add_at_places(disc.w, patches.place, i, columns, x, y)
    return 0.0


@scatter_force.of(DiscSurface)
def _push_both_ways(disc, patches, side, group, impulse, around):
    at, columns = first_weight(patches, side, group), patches.columns
    out = 2 * side * columns + group
    bx, by = impulse * load(patches.outward, out), impulse * load(patches.outward, out + columns)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        weight, light = load(patches.weight, i), load(patches.inverse_mass, i)
        x = (weight * bx + around * load(patches.traction_x, i)) * light
        y = (weight * by + around * load(patches.traction_y, i)) * light
        add_at_places(disc.w, patches.place, i, columns, x, y)
    return 0.0


@count_impulse.of(DiscSurface)
def _count(disc, column, x, y):
    scatter_add(disc.impulse, column, x)
    scatter_add(disc.impulse, column + disc.columns, y)
