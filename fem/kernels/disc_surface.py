"""The surface of elastic rollers."""

from math import pi

from fem.kernels.jit import part
from fem.kernels.law import ripple_at
from fem.kernels.patches import N_NODES, ONE
from fem.kernels.simd import WIDTH, gather, gather_pair, load, splat, store
from fem.kernels.state import DiscSurface
from fem.kernels.surfaces import first_weight, grip, next_node, place_patch, push, push_along, read, sideways


@read.of(DiscSurface)
def _read(disc, patches, side, group, column, bx, by):
    position, _, node = place_patch(patches, side, group, bx, by, disc.n_nodes)
    columns = patches.columns
    at = first_weight(patches, side, group, ONE)
    column = column + 2 * columns * disc.first
    ux, uy, sx, sy = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES):
        i = node * (2 * columns) + column
        x, y = gather_pair(disc.u, i, columns)
        share, change = load(patches.weight, at + k * columns), load(patches.weight_slope, k * WIDTH)
        ux += share * x
        uy += share * y
        sx += change * x
        sy += change * y
        node = next_node(node, disc.n_nodes)
    ripple, ripple_slope = ripple_at(position, disc.ripple)
    per_radian = disc.n_nodes / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@push.of(DiscSurface)
def _push(disc, patches, side, j, column, impulse):
    w, weight, columns = disc.w, patches.weight, patches.columns
    x, y = impulse * patches.outward[side, 0, j], impulse * patches.outward[side, 1, j]
    node = patches.start[side, j]
    for k in range(N_NODES * len(patches.units)):
        i = disc.first + node
        share = weight[side, k, j] * disc.lightness[i]
        at = i * 2 * columns + column
        w[at] += share * x
        w[at + columns] += share * y
        node = next_node(node, disc.n_nodes)
    return 0.0


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


@grip.of(DiscSurface)
def _grip(disc, patches, side, group):
    at, columns = first_weight(patches, side, group, patches.units), patches.columns
    out = 2 * side * columns + group
    bx, by = load(patches.outward, out), load(patches.outward, out + columns)
    node = load(patches.start, side * columns + group)
    first_x, first_y = _directions(disc, node)
    x, y, light, light_x, light_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        node_x, node_y = _turned(disc, k, first_x, first_y)
        share = load(patches.weight, at + k * columns)
        x += share * node_x
        y += share * node_y
        share = share * share * gather(disc.lightness, node + disc.first)
        light += share
        light_x += share * node_x
        light_y += share * node_y
        node = next_node(node, disc.n_nodes)
    scale, slope = 1.0 / (1.0 + (bx * x + by * y)), bx * y - by * x
    store(patches.scale, side * columns + group, scale)
    store(patches.slope, side * columns + group, slope)
    across = (slope * by + bx) * light_x - (slope * bx - by) * light_y
    return scale * scale * ((2.0 + slope * slope) * light + 2.0 * across)


@sideways.of(DiscSurface)
def _sideways(disc, patches, side, group, column, nx, ny):
    at, columns = first_weight(patches, side, group, patches.units), patches.columns
    out = 2 * side * columns + group
    bx, by = load(patches.outward, out), load(patches.outward, out + columns)
    node = load(patches.start, side * columns + group)
    first_x, first_y = _directions(disc, node)
    column = column + 2 * columns * disc.first
    x, y, around = splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        node_x, node_y = _turned(disc, k, first_x, first_y)
        i = node * (2 * columns) + column
        share = load(patches.weight, at + k * columns)
        vx, vy = gather_pair(disc.w, i, columns)
        vx, vy = share * vx, share * vy
        x += vx
        y += vy
        around += node_x * vy - node_y * vx
        node = next_node(node, disc.n_nodes)
    scale, slope = load(patches.scale, side * columns + group), load(patches.slope, side * columns + group)
    return scale * (x * (slope * bx - by) + y * (slope * by + bx) + around)


@push_along.of(DiscSurface)
def _push_along(disc, patches, side, j, column, impulse, x, y):
    disc.impulse[0, column] += x
    disc.impulse[1, column] += y
    w, points, weight, columns = disc.w, disc.points, patches.weight, patches.columns
    bx, by, slope = patches.outward[side, 0, j], patches.outward[side, 1, j], patches.slope[side, j]
    x, y, over = slope * bx - by, slope * by + bx, 1.0 / disc.radius
    node, impulse = patches.start[side, j], impulse * patches.scale[side, j]
    for k in range(N_NODES * len(patches.units)):
        i = disc.first + node
        speed = impulse * weight[side, k, j] * disc.lightness[i]
        at = i * 2 * columns + column
        w[at] += speed * (x - points[2 * i + 1] * over)
        w[at + columns] += speed * (y + points[2 * i] * over)
        node = next_node(node, disc.n_nodes)
    return 0.0
