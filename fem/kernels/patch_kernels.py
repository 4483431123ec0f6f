"""What a contact reads from and writes to the surface nodes of a roller or a ring.

The functions are inlined into the contact loops and take bare arrays: a named tuple taken apart here would count
references to every array at every access, twenty times the cost of the arithmetic.
"""

from math import atan2, pi

from fem.kernels.jit import kernel
from fem.kernels.law import ripple_at
from fem.kernels.patches import N_NODES, first_node, weight_slopes, weights
from fem.kernels.ring_kernels import HALO


@kernel(forceinline=True)
def place(x, y, n_nodes):
    """Position, in node spacings in [0, n_nodes), of a direction in a body's frame."""
    position = atan2(y, x) * (n_nodes / (2.0 * pi))
    if position < 0.0:
        position += n_nodes
    if position >= n_nodes:
        position -= n_nodes
    return position


@kernel(forceinline=True)
def _nodes(base, n_nodes, offset, node, patch, stretch):
    """Fill the patch's node numbers."""
    i = first_node(base, stretch)
    if i < 0:
        i += n_nodes
    for k in range(N_NODES * len(stretch)):
        node[patch, k] = offset + i
        i += 1
        if i >= n_nodes:
            i -= n_nodes


@kernel(forceinline=True)
def read_roller(u, columns, first, n_surface, column, bx, by, ripples, node, weight, patch, slope, stretch):
    """Place a roller's patch around its outward direction b (in its frame) and read the mean motion there.

    Returns outward motion U·b, sideways motion U·Jb, dU/ds·b per rad, ripple of A·B, its slope per rad.
    """
    position = place(bx, by, n_surface)
    base = int(position)
    weights(position - base, weight, patch, stretch)
    weight_slopes(position - base, slope, 0, stretch)
    _nodes(base, n_surface, first, node, patch, stretch)
    ux, uy, sx, sy = 0.0, 0.0, 0.0, 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k] * 2 * columns + column
        x, y = u[at], u[at + columns]
        ux += weight[patch, k] * x
        uy += weight[patch, k] * y
        sx += slope[0, k] * x
        sy += slope[0, k] * y
    ripple, ripple_slope = ripple_at(position, ripples)
    per_radian = n_surface / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@kernel(forceinline=True)
def read_ring(
    u, raceway, n_sectors, cosines, sines, bx, by, ripples, node, weight, along, across, patch, slope, stretch
):
    """Place a ring's patch around the radial direction b (in its frame); returns the same as `read_roller` along +b."""
    position = place(bx, by, n_sectors)
    base = int(position)
    weights(position - base, weight, patch, stretch)
    weight_slopes(position - base, slope, 0, stretch)
    _nodes(base, n_sectors, HALO, node, patch, stretch)
    out, side, rate = 0.0, 0.0, 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k]
        c, s = bx * cosines[at] + by * sines[at], by * cosines[at] - bx * sines[at]
        a, b = u[raceway, 0, at], u[raceway, 1, at]
        outward = a * c + b * s
        out += weight[patch, k] * outward
        side += weight[patch, k] * (b * c - a * s)
        rate += slope[0, k] * outward
        along[patch, k] = weight[patch, k] * c
        across[patch, k] = weight[patch, k] * s
    ripple, ripple_slope = ripple_at(position - base, ripples)
    per_radian = n_sectors / (2.0 * pi)
    return out, side, rate * per_radian, ripple, ripple_slope * per_radian


@kernel(forceinline=True)
def push_roller(w, lightness, columns, column, bx, by, node, weight, patch, stretch):
    """Spread an impulse, N s, with components in the roller's frame over its patch."""
    for k in range(N_NODES * len(stretch)):
        i = node[patch, k]
        share = weight[patch, k] * lightness[i]
        at = i * 2 * columns + column
        w[at] += share * bx
        w[at + columns] += share * by


@kernel(forceinline=True)
def push_ring(u, w, raceway, radius, node_mass, push, node, along, across, patch, stretch):
    """Spread an impulse, N s, along the patch's normal over a ring's patch; returns its moment about the origin."""
    speed, moment = push / node_mass, 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k]
        w[raceway, 0, at] += speed * along[patch, k]
        w[raceway, 1, at] += speed * across[patch, k]
        moment += (radius + u[raceway, 0, at]) * across[patch, k] - u[raceway, 1, at] * along[patch, k]
    return push * moment


# Tangential motion and force of a patch. Along the contact's tangent t alone it would miss a share 1 − Σ W cos φ of a
# rotation and of the moment (φ from the contact to the node), along the nodes' own tangents as much of a translation
# and of the force. Directions (t + t_node + b Σ W sin φ)/(1 + Σ W cos φ), weighted with W, miss nothing: all that a
# traction does to a body it does at its own nodes, and no other contact of the body has a part in it.


@kernel(forceinline=True)
def grip_roller(points, radius, bx, by, node, weight, patch, grip_x, grip_y, stretch):
    """Weighted tangential directions of a roller's patch, in its frame's axes."""
    x, y = 0.0, 0.0
    for k in range(N_NODES * len(stretch)):
        i = node[patch, k]
        x += weight[patch, k] * points[2 * i]
        y += weight[patch, k] * points[2 * i + 1]
    scale, lean = 1.0 / (1.0 + (bx * x + by * y) / radius), (bx * y - by * x) / radius
    x, y, curvature = lean * bx - by, lean * by + bx, 1.0 / radius
    for k in range(N_NODES * len(stretch)):
        i, share = node[patch, k], scale * weight[patch, k]
        grip_x[patch, k] = share * (x - curvature * points[2 * i + 1])
        grip_y[patch, k] = share * (y + curvature * points[2 * i])


@kernel(forceinline=True)
def grip_ring(weight, along, across, patch, grip_x, grip_y, stretch):
    """Weighted tangential directions of a ring's patch, radial and tangential at every node."""
    both, lean = 1.0, 0.0
    for k in range(N_NODES * len(stretch)):
        both += along[patch, k]
        lean -= across[patch, k]
    scale = 1.0 / both
    for k in range(N_NODES * len(stretch)):
        c, s = along[patch, k], across[patch, k]
        grip_x[patch, k] = scale * (lean * c - s)
        grip_y[patch, k] = scale * (c + weight[patch, k] + lean * s)


@kernel(forceinline=True)
def sideways_roller(w, columns, column, node, grip_x, grip_y, patch, stretch):
    """Velocity of the surface along t relative to the centre of mass, m/s."""
    v = 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k] * 2 * columns + column
        v += grip_x[patch, k] * w[at] + grip_y[patch, k] * w[at + columns]
    return v


@kernel(forceinline=True)
def sideways_ring(w, raceway, node, grip_x, grip_y, patch, stretch):
    """Velocity of the surface along t, m/s."""
    v = 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k]
        v += grip_x[patch, k] * w[raceway, 0, at] + grip_y[patch, k] * w[raceway, 1, at]
    return v


@kernel(forceinline=True)
def rub_roller(w, lightness, columns, column, push, node, grip_x, grip_y, patch, stretch):
    """Spread an impulse along t, N s, over a roller's patch."""
    for k in range(N_NODES * len(stretch)):
        i = node[patch, k]
        speed = push * lightness[i]
        at = i * 2 * columns + column
        w[at] += speed * grip_x[patch, k]
        w[at + columns] += speed * grip_y[patch, k]


@kernel(forceinline=True)
def rub_ring(u, w, raceway, radius, node_mass, push, node, grip_x, grip_y, patch, stretch):
    """Spread an impulse along t, N s, over a ring's patch; returns its moment about the origin, N m s."""
    speed, moment = push / node_mass, 0.0
    for k in range(N_NODES * len(stretch)):
        at = node[patch, k]
        x, y = grip_x[patch, k], grip_y[patch, k]
        w[raceway, 0, at] += speed * x
        w[raceway, 1, at] += speed * y
        moment += (radius + u[raceway, 0, at]) * y - u[raceway, 1, at] * x
    return push * moment


@kernel(forceinline=True)
def mobility_roller(lightness, node, grip_x, grip_y, patch, stretch):
    """Velocity that `sideways_roller` gains per unit impulse of `rub_roller`, 1/kg."""
    total = 0.0
    for k in range(N_NODES * len(stretch)):
        x, y = grip_x[patch, k], grip_y[patch, k]
        total += (x * x + y * y) * lightness[node[patch, k]]
    return total


@kernel(forceinline=True)
def mobility_ring(node_mass, grip_x, grip_y, patch, stretch):
    """Velocity that `sideways_ring` gains per unit impulse of `rub_ring`, 1/kg."""
    total = 0.0
    for k in range(N_NODES * len(stretch)):
        x, y = grip_x[patch, k], grip_y[patch, k]
        total += x * x + y * y
    return total / node_mass
