"""The raceway of an elastic ring."""

from math import pi

from fem.kernels.law import ripple_at
from fem.kernels.patches import N_NODES, ONE
from fem.kernels.ring_kernels import HALO
from fem.kernels.simd import WIDTH, gather, gather_pair, load, splat, store
from fem.kernels.state import RingSurface
from fem.kernels.surfaces import first_weight, grip, next_node, place_patch, push, push_along, read, sideways


@read.of(RingSurface)
def _read(ring, patches, side, group, column, bx, by):
    _, t, node = place_patch(patches, side, group, bx, by, ring.n_nodes)
    cosines, sines, columns = ring.cosines, ring.sines, patches.columns
    at = first_weight(patches, side, group, ONE)
    width = cosines.size
    radial = 2 * ring.row * width + HALO
    first_c, first_s = gather(cosines, node + HALO), gather(sines, node + HALO)
    ahead_c, ahead_s = bx * first_c + by * first_s, by * first_c - bx * first_s  # of the angle from the first node to b
    out, sideways, rate = splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES):
        j = at + k * columns
        step_c, step_s = cosines[HALO + k], sines[HALO + k]
        c, s = ahead_c * step_c + ahead_s * step_s, ahead_s * step_c - ahead_c * step_s
        a, b = gather_pair(ring.u, node + radial, width)
        share = load(patches.weight, j)
        outward = a * c + b * s
        out += share * outward
        sideways += share * (b * c - a * s)
        rate += load(patches.weight_slope, k * WIDTH) * outward
        store(patches.along, j, share * c)
        store(patches.across, j, share * s)
        node = next_node(node, ring.n_nodes)
    ripple, ripple_slope = ripple_at(t, ring.ripple)
    per_radian = ring.n_nodes / (2.0 * pi)
    return out, sideways, rate * per_radian, ripple, ripple_slope * per_radian


@push.of(RingSurface)
def _push(ring, patches, side, j, column, impulse):
    u, w, row = ring.u, ring.w, ring.row
    speed, moment, node = impulse / ring.node_mass, 0.0, patches.start[side, j]
    for k in range(N_NODES * len(patches.units)):
        at = node + HALO
        radial, around = patches.along[side, k, j], patches.across[side, k, j]
        w[row, 0, at] += speed * radial
        w[row, 1, at] += speed * around
        moment += (ring.radius + u[row, 0, at]) * around - u[row, 1, at] * radial
        node = next_node(node, ring.n_nodes)
    return impulse * moment


@grip.of(RingSurface)
def _grip(ring, patches, side, group):
    at, columns = first_weight(patches, side, group, patches.units), patches.columns
    x, y, light, light_x, light_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        j = at + k * columns
        share, c, s = load(patches.weight, j), load(patches.along, j), load(patches.across, j)
        x += c
        y -= s
        light += share * share
        light_x += share * c
        light_y += share * s
    scale = 1.0 / (1.0 + x)
    store(patches.scale, side * columns + group, scale)
    store(patches.slope, side * columns + group, y)
    return scale * scale * ((2.0 + y * y) * light + 2.0 * (light_x + y * light_y)) * (1.0 / ring.node_mass)


@sideways.of(RingSurface)
def _sideways(ring, patches, side, group, column, nx, ny):
    at, columns, width = first_weight(patches, side, group, patches.units), patches.columns, ring.w.shape[2]
    radial = 2 * ring.row * width + HALO
    node = load(patches.start, side * columns + group)
    outward, around = splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        j = at + k * columns
        p, q = gather_pair(ring.w, node + radial, width)
        c, s = load(patches.along, j), load(patches.across, j)
        outward += c * p + s * q
        around += (c + load(patches.weight, j)) * q - s * p
        node = next_node(node, ring.n_nodes)
    scale, slope = load(patches.scale, side * columns + group), load(patches.slope, side * columns + group)
    return scale * (slope * outward + around)


@push_along.of(RingSurface)
def _push_along(ring, patches, side, j, column, impulse, x, y):
    u, w, row = ring.u, ring.w, ring.row
    impulse *= patches.scale[side, j]
    slope, speed, moment, node = patches.slope[side, j], impulse / ring.node_mass, 0.0, patches.start[side, j]
    for k in range(N_NODES * len(patches.units)):
        at, c, s = node + HALO, patches.along[side, k, j], patches.across[side, k, j]
        x, y = slope * c - s, patches.weight[side, k, j] + c + slope * s
        w[row, 0, at] += speed * x
        w[row, 1, at] += speed * y
        moment += (ring.radius + u[row, 0, at]) * y - u[row, 1, at] * x
        node = next_node(node, ring.n_nodes)
    return impulse * moment
