"""Forces of pressure points that act through what the mesh lacks between them: a small contact problem.

Find q >= 0 with G q >= c, c the overlap at the points, and G q = c where q > 0. G depends on the distance alone, so the
inverse for n neighbouring points in contact is known beforehand for every n.

One pressure point on one surface: between the two nodes beside it, or spread over the patch of six around it.

The choice is the scene's: `spread`, that of `Points`, is None or is not, and a run compiles the one it uses. Positions
are in node spacings, and may lie one turn outside. `side` is that of the contact, 0 or 1; q the point; m a direction in
the body's frame.

Equation (4) of docs/method.md.
"""

import numpy as np

from fem.kernels.jit import part, verb
from fem.kernels.patches import N_NODES, first_node, put, weight_slopes, weights
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import DiscSurface, RingSurface


@verb
def node_motion(surface, node, column, mx, my):
    """Displacement of a surface node along m and along Jm."""


@node_motion.of(RingSurface)
def _of_ring(ring, node, column, mx, my):
    node += HALO
    c, s = mx * ring.cosines[node] + my * ring.sines[node], my * ring.cosines[node] - mx * ring.sines[node]
    a, b = ring.u[ring.row, 0, node], ring.u[ring.row, 1, node]
    return a * c + b * s, b * c - a * s


@node_motion.of(DiscSurface)
def _of_disc(disc, node, column, mx, my):
    at = (node + disc.first) * 2 * disc.columns + column
    a, b = disc.u[at], disc.u[at + disc.columns]
    return a * mx + b * my, b * mx - a * my


@verb
def push_node(surface, node, column, mx, my, impulse):
    """Give a surface node an impulse along m, N s; returns its moment about the origin, N m s."""


@push_node.of(RingSurface)
def _push_ring(ring, node, column, mx, my, impulse):
    node += HALO
    radial = impulse * (mx * ring.cosines[node] + my * ring.sines[node])
    around = impulse * (my * ring.cosines[node] - mx * ring.sines[node])
    ring.w[ring.row, 0, node] += radial / ring.node_mass
    ring.w[ring.row, 1, node] += around / ring.node_mass
    return (ring.radius + ring.u[ring.row, 0, node]) * around - ring.u[ring.row, 1, node] * radial


@push_node.of(DiscSurface)
def _push_disc(disc, node, column, mx, my, impulse):
    k = node + disc.first
    at = k * 2 * disc.columns + column
    disc.w[at] += impulse * mx * disc.inverse_mass[k]
    disc.w[at + disc.columns] += impulse * my * disc.inverse_mass[k]
    return 0.0


@part
def place_point(x, points, side, q, spread):
    """Shares of the nodes around a position, kept for what follows."""
    if spread is not None:
        at = (side * points.closing.size + q) * N_NODES
        t = x - np.floor(x)
        put(spread.share, at, 1, weights(t))
        put(spread.slope, side * N_NODES, 1, weight_slopes(t))


@part
def _first(x, n_nodes):
    """First node of the patch around a position."""
    return first_node(int(np.floor(x))) % n_nodes


@part
def _pair(x, n_nodes):
    """The two nodes around a position and how far it is beyond the first."""
    base = int(np.floor(x))
    t = x - base
    near = base % n_nodes
    far = near + 1 if near + 1 < n_nodes else 0
    return near, far, t


@part
def read_point(surface, column, x, mx, my, at, spread):
    """Displacement along m and along Jm at a position, and the change of the first per node spacing.

    `at` is (side, q, number of points).
    """
    if spread is not None:
        side, q, n_points = at
        node, first = _first(x, surface.n_nodes), (side * n_points + q) * N_NODES
        out, sideways, rate = 0.0, 0.0, 0.0
        for k in range(N_NODES):
            along, across = node_motion(surface, node, column, mx, my)
            out += spread.share[first + k] * along
            sideways += spread.share[first + k] * across
            rate += spread.slope[side * N_NODES + k] * along
            node = node + 1 if node + 1 < surface.n_nodes else 0
        return out, sideways, rate
    near, far, t = _pair(x, surface.n_nodes)
    along0, side0 = node_motion(surface, near, column, mx, my)
    along1, side1 = node_motion(surface, far, column, mx, my)
    return (1.0 - t) * along0 + t * along1, (1.0 - t) * side0 + t * side1, along1 - along0


@part
def push_point(surface, column, x, m, impulse, at, spread):
    """Give a surface an impulse along m, N s; returns its moment about the origin, N m s. `at` as in `read_point`."""
    mx, my = m
    if spread is not None:
        side, q, n_points = at
        node, first, moment = _first(x, surface.n_nodes), (side * n_points + q) * N_NODES, 0.0
        for k in range(N_NODES):
            moment += push_node(surface, node, column, mx, my, impulse * spread.share[first + k])
            node = node + 1 if node + 1 < surface.n_nodes else 0
        return moment
    near, far, t = _pair(x, surface.n_nodes)
    moment = push_node(surface, near, column, mx, my, impulse * (1.0 - t))
    return moment + push_node(surface, far, column, mx, my, impulse * t)


@part
def share_out(weight, x, start, p, at, spread):
    """Add a point's force to the nodes' shares of a patch, (width,), for friction, which is spread as pressure is."""
    base, width = int(np.floor(x)), weight.size
    if spread is not None:
        side, q, n_points = at
        k, first = first_node(base) - start, (side * n_points + q) * N_NODES
        if 0 <= k and k + N_NODES <= width:
            for i in range(N_NODES):
                weight[k + i] += p * spread.share[first + i]
    else:
        t, k = x - base, base - start
        if 0 <= k and k + 1 < width:
            weight[k] += p * (1.0 - t)
            weight[k + 1] += p * t


MAX_SWEEPS = 1000
SWEPT = 1e-10  # of the largest force: what a sweep may still change


@part(inlined=False)
def spread_forces(points, spread, row, j):
    """Fill `points.force` for contact j of a pair; returns the energy stored below the grid, ½ qᵀG q, J.

    Points in contact are neighbours but for moments when a wave on the surface parts them; those are solved for by
    sweeps. Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force, closed = points.closing, points.force, spread.closed
    n = closing.size
    first, end = closed[row, j, 0], closed[row, j, 1]
    for q in range(n):
        force[q] = 0.0
    if first >= end:
        first = 0
        for q in range(n):
            if closing[q] > closing[first]:
                first = q
        end = first + 1
    found = False
    for _ in range(2 * n):
        if first == end:
            break
        _solve(points, spread, row, first, end)
        if force[first] < 0.0:
            force[first] = 0.0
            first += 1
        elif force[end - 1] < 0.0:
            force[end - 1] = 0.0
            end -= 1
        elif first > 0 and _left(points, spread, row, first - 1, first, end) > 0.0:
            first -= 1
        elif end < n and _left(points, spread, row, end, first, end) > 0.0:
            end += 1
        else:
            found = True
            break
    pulled = False
    for q in range(first, end):
        pulled |= force[q] < 0.0
    if first < end and (pulled or not found):
        first, end = _sweep(points, spread, row)
    closed[row, j, 0], closed[row, j, 1] = first, end
    if end > first and (first == 0 or end == n):
        force[first] = np.nan
    energy = 0.0
    for q in range(first, end):
        energy += 0.5 * force[q] * closing[q]
    return energy


@part
def _solve(points, spread, row, first, end):
    """Forces of neighbouring points that are all in contact."""
    m = end - first
    at = (m - 1) * m * (2 * m - 1) // 6  # matrices of 1, 2 ... m - 1 rows come before
    for q in range(m):
        total = 0.0
        for k in range(m):
            total += spread.inverse[row, at + q * m + k] * points.closing[first + k]
        points.force[first + q] = total


@part
def _left(points, spread, row, q, first, end):
    """What a point closes by beyond its neighbours' forces in [first, end)."""
    left = points.closing[q]
    for k in range(first, end):
        left -= spread.missing[row, abs(q - k)] * points.force[k]
    return left


@part(inlined=False)
def _sweep(points, spread, row):
    """Gauss and Seidel's method with q >= 0; returns the range of the points in contact."""
    force, n = points.force, points.closing.size
    for q in range(n):
        force[q] = max(force[q], 0.0)
    own = spread.missing[row, 0]
    for _ in range(MAX_SWEEPS):
        changed, largest = 0.0, 0.0
        for q in range(n):
            new = max(force[q] + _left(points, spread, row, q, 0, n) / own, 0.0)
            changed, largest = max(changed, abs(new - force[q])), max(largest, new)
            force[q] = new
        if changed <= SWEPT * largest:
            break
    first, end = n, 0
    for q in range(n):
        if force[q] > 0.0:
            first, end = min(first, q), q + 1
    return min(first, end), end
