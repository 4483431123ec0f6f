"""The raceway of an elastic ring."""

from math import pi

from fem.kernels.jit import part
from fem.kernels.lane_memory import add_to_rows, gather, gather_rows, load, store
from fem.kernels.lanes import splat
from fem.kernels.law import seamless
from fem.kernels.patches import N_NODES, combined, dot, products, put, take, times, weight_slopes, weights
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import RingSurface
from fem.kernels.surfaces import (
    accumulate_ghost_nodes,
    clear_ghost_nodes,
    fill_ghost_nodes,
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
def _ahead(ring, bx, by, node):
    """Cosines and sines of the angles from the nodes of patches to the contacts; `node`, the patches' first ones."""
    cosines, sines = ring.cosines, ring.sines
    first_c, first_s = gather(cosines, node + HALO), gather(sines, node + HALO)
    c, s = bx * first_c + by * first_s, by * first_c - bx * first_s
    h = HALO
    steps_c = cosines[h], cosines[h + 1], cosines[h + 2], cosines[h + 3], cosines[h + 4], cosines[h + 5]
    steps_s = sines[h], sines[h + 1], sines[h + 2], sines[h + 3], sines[h + 4], sines[h + 5]
    return combined(c, steps_c, s, steps_s), combined(s, steps_c, -c, steps_s)


@locate_patch.of(RingSurface)
def _locate_patch(ring, patches, side, group):
    place_patch(patches, side, group, ring.n_nodes)


@interpolate_displacement.of(RingSurface)
def _read(ring, patches, side, group, column):
    columns, width = patches.columns, ring.cosines.size
    at, out = first_weight(patches, side, group), 2 * side * columns + group
    bx, by = load(patches.outward, out), load(patches.outward, out + columns)
    t, node = load(patches.beyond, side * columns + group), load(patches.start, side * columns + group)
    store(patches.place, at, node + (2 * ring.row * width + HALO))
    c, s = _ahead(ring, bx, by, node)
    share = weights(t)
    along, across = products(share, c), products(share, s)
    put(patches.weight, at, columns, share)
    put(patches.along, at, columns, along)
    put(patches.across, at, columns, across)
    a, b = gather_rows(ring.u, patches.place, at, 0), gather_rows(ring.u, patches.place, at, width)
    change = weight_slopes(t)
    out, sideways = dot(along, a) + dot(across, b), dot(along, b) - dot(across, a)
    rate = dot(products(change, c), a) + dot(products(change, s), b)
    ripple, ripple_slope = seamless(t, ring.ripple)
    per_radian = ring.n_nodes / (2.0 * pi)
    return out, sideways, rate * per_radian, ripple, ripple_slope * per_radian


@part
def _give(ring, patches, at, radial, around, impulse):
    """Give six nodes of eight patches what an impulse does to them; moments about the origin, N m s."""
    speed, width = impulse * (1.0 / ring.node_mass), ring.cosines.size
    add_to_rows(ring.w, patches.place, at, 0, times(speed, radial))
    add_to_rows(ring.w, patches.place, at, width, times(speed, around))
    a, b = gather_rows(ring.u, patches.place, at, 0), gather_rows(ring.u, patches.place, at, width)
    p, q, r, s, t, u = around
    total = ((p + q) + (r + s)) + (t + u)
    return impulse * (ring.radius * total + (dot(a, around) - dot(b, radial)))


@part
def _give_all(ring, patches, side, group, radial, around, impulse):
    """Give the nodes of eight patches `radial` and `around` of an impulse each, arrays of `Patches`; their moments."""
    at, columns, moment = first_weight(patches, side, group), patches.columns, splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        moment += _give(ring, patches, i, take(radial, i, columns), take(around, i, columns), impulse)
    return moment


@scatter_normal_force.of(RingSurface)
def _push(ring, patches, side, group, impulse):
    return _give_all(ring, patches, side, group, patches.along, patches.across, impulse)


@out_of_surface.of(RingSurface)
def _out_of_surface(ring, patches, side, group):
    at, columns, width = first_weight(patches, side, group), patches.columns, ring.cosines.size
    out, light = splat(0.0), splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        along, across = take(patches.along, i, columns), take(patches.across, i, columns)
        out += dot(along, gather_rows(ring.w, patches.place, i, 0))
        out += dot(across, gather_rows(ring.w, patches.place, i, width))
        light += dot(along, along) + dot(across, across)
    return out, light * (1.0 / ring.node_mass)


@tangential_mobility.of(RingSurface)
def _grip(ring, patches, side, group):
    at, columns = first_weight(patches, side, group), patches.columns
    x, slope, mobility = splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        x += load(patches.along, i)
        slope -= load(patches.across, i)
    scale = 1.0 / (1.0 + x)
    for k in range(N_NODES * len(patches.units)):
        i = at + k * columns
        c, s = load(patches.along, i), load(patches.across, i)
        radial, around = scale * (slope * c - s), scale * (load(patches.weight, i) + c + slope * s)
        store(patches.traction_x, i, radial)
        store(patches.traction_y, i, around)
        mobility += radial * radial + around * around
    return mobility * (1.0 / ring.node_mass)


@tangential_velocity.of(RingSurface)
def _sideways(ring, patches, side, group, column, nx, ny):
    at, columns, width = first_weight(patches, side, group), patches.columns, ring.cosines.size
    found = splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        found += dot(take(patches.traction_x, i, columns), gather_rows(ring.v, patches.place, i, 0))
        found += dot(take(patches.traction_y, i, columns), gather_rows(ring.v, patches.place, i, width))
    return found


@scatter_tangential_force.of(RingSurface)
def _push_along(ring, patches, side, group, impulse):
    return _give_all(ring, patches, side, group, patches.traction_x, patches.traction_y, impulse)


@scatter_force.of(RingSurface)
def _push_both_ways(ring, patches, side, group, impulse, around):
    at, columns, moment = first_weight(patches, side, group), patches.columns, splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        x = combined(impulse, take(patches.along, i, columns), around, take(patches.traction_x, i, columns))
        y = combined(impulse, take(patches.across, i, columns), around, take(patches.traction_y, i, columns))
        moment += _give(ring, patches, i, x, y, splat(1.0))
    return moment


@fill_ghost_nodes.of(RingSurface)
def _seal(ring):
    w, width = ring.w, ring.cosines.size
    for component in range(2):
        line = (2 * ring.row + component) * width
        store(w, line + width - HALO, load(w, line + HALO))


@clear_ghost_nodes.of(RingSurface)
def _unseal(ring):
    w, width = ring.w, ring.cosines.size
    for component in range(2):
        line = (2 * ring.row + component) * width
        store(w, line + width - HALO, splat(0.0))


@accumulate_ghost_nodes.of(RingSurface)
def _gather_seam(ring):
    w, width = ring.w, ring.cosines.size
    for component in range(2):
        line = (2 * ring.row + component) * width
        store(w, line + HALO, load(w, line + HALO) + load(w, line + width - HALO))
