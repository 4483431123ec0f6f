"""One pressure point on one surface: between the two nodes beside it, or spread over the patch of six around it.

The choice is the scene's: `lack`, that of `resolved`, is None or is not, and a run compiles the one it uses. Positions
are in node spacings, and may lie one turn outside.
"""

import numpy as np

from fem.kernels.jit import kernel
from fem.kernels.patches import N_NODES, first_node, weight_slopes, weights
from fem.kernels.ring_kernels import HALO


@kernel(forceinline=True)
def place(x, resolved, side, q, lack):
    """Shares of the nodes around a position, kept for what follows."""
    if lack is not None:
        at = (side * resolved.closing.size + q) * N_NODES
        t = x - np.floor(x)
        weights(t, resolved.share, at, 1)
        weight_slopes(t, resolved.slope, side * N_NODES, 1)


@kernel(forceinline=True)
def _first(x, n_nodes):
    """First node of the patch around a position."""
    return first_node(int(np.floor(x))) % n_nodes


@kernel(forceinline=True)
def _pair(x, n_nodes):
    """The two nodes around a position and how far it is beyond the first."""
    base = int(np.floor(x))
    t = x - base
    near = base % n_nodes
    far = near + 1 if near + 1 < n_nodes else 0
    return near, far, t


@kernel(forceinline=True)
def _of_ring(ring, node, mx, my):
    """Displacement of a raceway's node along m and along Jm."""
    node += HALO
    c, s = mx * ring.cosines[node] + my * ring.sines[node], my * ring.cosines[node] - mx * ring.sines[node]
    a, b = ring.u[ring.raceway, 0, node], ring.u[ring.raceway, 1, node]
    return a * c + b * s, b * c - a * s


@kernel(forceinline=True)
def read_ring(ring, x, mx, my, resolved, q, lack):
    """Displacement along m and along Jm at a position, and the change of the first per node spacing."""
    if lack is not None:
        node, at = _first(x, ring.n_sectors), q * N_NODES
        out, sideways, rate = 0.0, 0.0, 0.0
        for k in range(N_NODES):
            along, side = _of_ring(ring, node, mx, my)
            out += resolved.share[at + k] * along
            sideways += resolved.share[at + k] * side
            rate += resolved.slope[k] * along
            node = node + 1 if node + 1 < ring.n_sectors else 0
        return out, sideways, rate
    near, far, t = _pair(x, ring.n_sectors)
    along0, side0 = _of_ring(ring, near, mx, my)
    along1, side1 = _of_ring(ring, far, mx, my)
    return (1.0 - t) * along0 + t * along1, (1.0 - t) * side0 + t * side1, along1 - along0


@kernel(forceinline=True)
def _of_roller(rollers, column, node, mx, my):
    at = (node + rollers.first_surface) * 2 * rollers.columns + column
    a, b = rollers.u[at], rollers.u[at + rollers.columns]
    return a * mx + b * my, b * mx - a * my


@kernel(forceinline=True)
def read_roller(rollers, column, x, mx, my, resolved, side, q, lack):
    """As `read_ring`, of one roller; `side` of the contact."""
    if lack is not None:
        node, at = _first(x, rollers.n_surface), (side * resolved.closing.size + q) * N_NODES
        out, sideways, rate = 0.0, 0.0, 0.0
        for k in range(N_NODES):
            along, across = _of_roller(rollers, column, node, mx, my)
            out += resolved.share[at + k] * along
            sideways += resolved.share[at + k] * across
            rate += resolved.slope[side * N_NODES + k] * along
            node = node + 1 if node + 1 < rollers.n_surface else 0
        return out, sideways, rate
    near, far, t = _pair(x, rollers.n_surface)
    along0, side0 = _of_roller(rollers, column, near, mx, my)
    along1, side1 = _of_roller(rollers, column, far, mx, my)
    return (1.0 - t) * along0 + t * along1, (1.0 - t) * side0 + t * side1, along1 - along0


@kernel(forceinline=True)
def _push_ring_node(ring, node, mx, my, impulse):
    """Returns the moment of what is pushed about the origin, N m s."""
    row = ring.raceway
    node += HALO
    radial = impulse * (mx * ring.cosines[node] + my * ring.sines[node])
    around = impulse * (my * ring.cosines[node] - mx * ring.sines[node])
    ring.w[row, 0, node] += radial / ring.row_mass[row]
    ring.w[row, 1, node] += around / ring.row_mass[row]
    return (ring.radius + ring.u[row, 0, node]) * around - ring.u[row, 1, node] * radial


@kernel(forceinline=True)
def push_ring(ring, x, mx, my, impulse, resolved, q, lack):
    """Give a raceway an impulse along m, N s; returns its moment about the origin, N m s."""
    if lack is not None:
        node, moment = _first(x, ring.n_sectors), 0.0
        for k in range(N_NODES):
            moment += _push_ring_node(ring, node, mx, my, impulse * resolved.share[q * N_NODES + k])
            node = node + 1 if node + 1 < ring.n_sectors else 0
        return moment
    near, far, t = _pair(x, ring.n_sectors)
    moment = _push_ring_node(ring, near, mx, my, impulse * (1.0 - t))
    return moment + _push_ring_node(ring, far, mx, my, impulse * t)


@kernel(forceinline=True)
def _push_roller_node(rollers, column, node, mx, my, impulse):
    k = node + rollers.first_surface
    at = k * 2 * rollers.columns + column
    rollers.w[at] += impulse * mx * rollers.lightness[k]
    rollers.w[at + rollers.columns] += impulse * my * rollers.lightness[k]


@kernel(forceinline=True)
def push_roller(rollers, column, x, mx, my, impulse, resolved, side, q, lack):
    """Give a roller an impulse along m, N s."""
    if lack is not None:
        node, at = _first(x, rollers.n_surface), (side * resolved.closing.size + q) * N_NODES
        for k in range(N_NODES):
            _push_roller_node(rollers, column, node, mx, my, impulse * resolved.share[at + k])
            node = node + 1 if node + 1 < rollers.n_surface else 0
    else:
        near, far, t = _pair(x, rollers.n_surface)
        _push_roller_node(rollers, column, near, mx, my, impulse * (1.0 - t))
        _push_roller_node(rollers, column, far, mx, my, impulse * t)


@kernel(forceinline=True)
def gather(weight, patch, j, x, start, p, width, resolved, side, q, lack):
    """Add a point's force to the nodes' shares, for friction, which is spread as the pressure is."""
    base = int(np.floor(x))
    if lack is not None:
        k, at = first_node(base) - start, (side * resolved.closing.size + q) * N_NODES
        if 0 <= k and k + N_NODES <= width:
            for i in range(N_NODES):
                weight[patch, k + i, j] += p * resolved.share[at + i]
    else:
        t, k = x - base, base - start
        if 0 <= k and k + 1 < width:
            weight[patch, k, j] += p * (1.0 - t)
            weight[patch, k + 1, j] += p * t
