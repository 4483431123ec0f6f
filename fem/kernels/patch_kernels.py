"""What contacts read from and write to the surface nodes of a roller or a ring.

Eight contacts at a time are read (lanes), side by side from roller `group` on; pushing is one contact's, for two
contacts may push one node. `side` is 2·kind + 0 or 1. A patch is its first node, the others follow, and weights
(side, node of the patch, roller); a ring's has them also times cosine and sine of the angle from each node to the
contact. The functions are inlined into the contact loops and take bare arrays: a named tuple taken
apart here would count references to every array at every access, twenty times the cost of the arithmetic.
"""

from math import pi

from fem.kernels.jit import kernel
from fem.kernels.lane_functions import arc_tangent
from fem.kernels.law import ripple_at
from fem.kernels.patches import N_NODES, ONE, first_node, weight_slopes, weights
from fem.kernels.ring_kernels import HALO
from fem.kernels.simd import WIDTH, gather, gather_pair, load, real, select, splat, store, whole


@kernel(forceinline=True)
def place(x, y, n_nodes):
    """Position, in node spacings in [0, n_nodes), of a direction in a body's frame; scalars or lanes."""
    position = arc_tangent(y, x) * (n_nodes / (2.0 * pi))
    position = select(position < 0.0, position + 1.0 * n_nodes, position)
    return select(position >= 1.0 * n_nodes, position - 1.0 * n_nodes, position)


@kernel(forceinline=True)
def _next(i, n_nodes):
    """The node after node i of a circle; scalar or lanes."""
    return select(i >= n_nodes - 1, 0, i + 1)


@kernel(forceinline=True)
def _row(side, group, columns, stretch):
    """Flat index of eight patches' first weights."""
    return side * N_NODES * len(stretch) * columns + group


@kernel(forceinline=True)
def _place_patch(bx, by, n_nodes, start, weight, columns, side, group, slope):
    """Put patches around directions b of circles of nodes: their first nodes, weights and the weights' slopes.

    Returns positions in node spacings, how far they are beyond a node, and the first nodes.
    """
    position = place(bx, by, n_nodes)
    base = whole(position)
    base = select((base >= 0) & (base < n_nodes), base, 0)  # of what is not a number, lest memory be read elsewhere
    t = position - real(base)
    weights(t, weight, _row(side, group, columns, ONE), columns)
    weight_slopes(t, slope, 0, WIDTH)
    node = first_node(base)
    node = select(node < 0, node + n_nodes, node)
    store(start, side * columns + group, node)
    return position, t, node


@kernel(forceinline=True)
def read_roller(u, column, columns, first, n_surface, bx, by, ripples, start, weight, side, group, slope):
    """Place patches of rollers `column` around their outward directions b (in their frames) and read the motion there.

    Returns outward motion U·b, sideways motion U·Jb, dU/ds·b per rad, ripple of A·B, its slope per rad.
    """
    position, _, node = _place_patch(bx, by, n_surface, start, weight, columns, side, group, slope)
    at = _row(side, group, columns, ONE)
    column = column + 2 * columns * first
    ux, uy, sx, sy = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES):
        i = node * (2 * columns) + column
        x, y = gather_pair(u, i, columns)
        share, change = load(weight, at + k * columns), load(slope, k * WIDTH)
        ux += share * x
        uy += share * y
        sx += change * x
        sy += change * y
        node = _next(node, n_surface)
    ripple, ripple_slope = ripple_at(position, ripples)
    per_radian = n_surface / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@kernel(forceinline=True)
def read_ring(
    u,
    raceway,
    n_sectors,
    cosines,
    sines,
    bx,
    by,
    ripples,
    start,
    weight,
    along,
    across,
    columns,
    side,
    group,
    slope,
):
    """Place a ring's patches around radial directions b (in its frame); returns the same as `read_roller` along +b."""
    _, t, node = _place_patch(bx, by, n_sectors, start, weight, columns, side, group, slope)
    at = _row(side, group, columns, ONE)
    width = cosines.size
    radial = 2 * raceway * width + HALO
    first_c, first_s = gather(cosines, node + HALO), gather(sines, node + HALO)
    ahead_c, ahead_s = bx * first_c + by * first_s, by * first_c - bx * first_s  # of the angle from the first node to b
    out, sideways, rate = splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES):
        j = at + k * columns
        step_c, step_s = cosines[HALO + k], sines[HALO + k]
        c, s = ahead_c * step_c + ahead_s * step_s, ahead_s * step_c - ahead_c * step_s
        a, b = gather_pair(u, node + radial, width)
        share = load(weight, j)
        outward = a * c + b * s
        out += share * outward
        sideways += share * (b * c - a * s)
        rate += load(slope, k * WIDTH) * outward
        store(along, j, share * c)
        store(across, j, share * s)
        node = _next(node, n_sectors)
    ripple, ripple_slope = ripple_at(t, ripples)
    per_radian = n_sectors / (2.0 * pi)
    return out, sideways, rate * per_radian, ripple, ripple_slope * per_radian


@kernel(forceinline=True)
def push_roller(w, lightness, columns, column, first, n_surface, bx, by, start, weight, side, j, stretch):
    """Spread an impulse, N s, with components in the frame of roller `column` over its patch in contact j."""
    node = start[side, j]
    for k in range(N_NODES * len(stretch)):
        i = first + node
        share = weight[side, k, j] * lightness[i]
        at = i * 2 * columns + column
        w[at] += share * bx
        w[at + columns] += share * by
        node = _next(node, n_surface)


@kernel(forceinline=True)
def push_ring(u, w, raceway, n_sectors, radius, node_mass, push, start, along, across, side, j, stretch):
    """Spread an impulse, N s, along the normal over a ring's patch in contact j; returns its moment, N m s."""
    speed, moment, node = push / node_mass, 0.0, start[side, j]
    for k in range(N_NODES * len(stretch)):
        at = node + HALO
        radial, around = along[side, k, j], across[side, k, j]
        w[raceway, 0, at] += speed * radial
        w[raceway, 1, at] += speed * around
        moment += (radius + u[raceway, 0, at]) * around - u[raceway, 1, at] * radial
        node = _next(node, n_sectors)
    return push * moment


# Tangential motion and force of a patch. Along the contact's tangent t alone it would miss a share 1 − Σ W cos φ of a
# rotation and of the moment (φ from the contact to the node), along the nodes' own tangents as much of a translation
# and of the force. Directions g = (t_node + t + lean·b)·scale, lean = Σ W sin φ, scale = 1/(1 + Σ W cos φ), weighted
# with W, miss nothing: all that a traction does to a body it does at its own nodes, and no other contact of the body
# has a part in it. The mobility is the velocity Σ W g·w that a patch gains per unit impulse along its W g, 1/kg.


@kernel(forceinline=True)
def grip_roller(
    points, lightness, first, n_surface, radius, bx, by, start, weight, columns, side, group, scale, lean, stretch
):
    """Scale and lean of rollers' patches with outward directions b; returns their mobilities."""
    at, over = _row(side, group, columns, stretch), 1.0 / radius
    node = load(start, side * columns + group)
    i = (node + first) * 2
    first_x, first_y = gather_pair(points, i, 1)
    first_x, first_y = first_x * over, first_y * over
    x, y, light, light_x, light_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(stretch)):
        c, s = points[2 * (first + k)] * over, points[2 * (first + k) + 1] * over
        node_x, node_y = first_x * c - first_y * s, first_y * c + first_x * s
        share = load(weight, at + k * columns)
        x += share * node_x
        y += share * node_y
        share = share * share * gather(lightness, node + first)
        light += share
        light_x += share * node_x
        light_y += share * node_y
        node = _next(node, n_surface)
    size, leaning = 1.0 / (1.0 + (bx * x + by * y)), bx * y - by * x
    store(scale, side * columns + group, size)
    store(lean, side * columns + group, leaning)
    across = (leaning * by + bx) * light_x - (leaning * bx - by) * light_y
    return size * size * ((2.0 + leaning * leaning) * light + 2.0 * across)


@kernel(forceinline=True)
def grip_ring(node_mass, weight, along, across, columns, side, group, scale, lean, stretch):
    """Scale and lean of a ring's patches; returns their mobilities."""
    at = _row(side, group, columns, stretch)
    x, y, light, light_x, light_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(stretch)):
        share, c, s = load(weight, at + k * columns), load(along, at + k * columns), load(across, at + k * columns)
        x += c
        y -= s
        light += share * share
        light_x += share * c
        light_y += share * s
    size = 1.0 / (1.0 + x)
    store(scale, side * columns + group, size)
    store(lean, side * columns + group, y)
    return size * size * ((2.0 + y * y) * light + 2.0 * (light_x + y * light_y)) * (1.0 / node_mass)


@kernel(forceinline=True)
def sideways_roller(
    w, column, points, first, n_surface, radius, bx, by, start, weight, columns, side, group, scale, lean, stretch
):
    """Velocity of the surfaces of rollers `column` along t relative to their centres of mass, m/s."""
    at, over = _row(side, group, columns, stretch), 1.0 / radius
    node = load(start, side * columns + group)
    i = (node + first) * 2
    first_x, first_y = gather_pair(points, i, 1)
    first_x, first_y = first_x * over, first_y * over
    column = column + 2 * columns * first
    x, y, around = splat(0.0), splat(0.0), splat(0.0)
    for k in range(N_NODES * len(stretch)):
        c, s = points[2 * (first + k)] * over, points[2 * (first + k) + 1] * over
        node_x, node_y = first_x * c - first_y * s, first_y * c + first_x * s
        i = node * (2 * columns) + column
        share = load(weight, at + k * columns)
        vx, vy = gather_pair(w, i, columns)
        vx, vy = share * vx, share * vy
        x += vx
        y += vy
        around += node_x * vy - node_y * vx
        node = _next(node, n_surface)
    size, leaning = load(scale, side * columns + group), load(lean, side * columns + group)
    return size * (x * (leaning * bx - by) + y * (leaning * by + bx) + around)


@kernel(forceinline=True)
def sideways_ring(w, raceway, n_sectors, start, weight, along, across, columns, side, group, scale, lean, stretch):
    """Velocity of the surface along t, m/s."""
    at, width = _row(side, group, columns, stretch), w.shape[2]
    radial = 2 * raceway * width + HALO
    node = load(start, side * columns + group)
    outward, around = splat(0.0), splat(0.0)
    for k in range(N_NODES * len(stretch)):
        j = at + k * columns
        p, q = gather_pair(w, node + radial, width)
        c, s = load(along, j), load(across, j)
        outward += c * p + s * q
        around += (c + load(weight, j)) * q - s * p
        node = _next(node, n_sectors)
    return load(scale, side * columns + group) * (load(lean, side * columns + group) * outward + around)


@kernel(forceinline=True)
def rub_roller(
    w, lightness, columns, column, points, first, n_surface, radius, bx, by, push, start, weight, side, j, scale, lean,
    stretch,
):  # fmt: skip
    """Spread an impulse along t, N s, over the patch of roller `column` in contact j."""
    x, y, over = lean[side, j] * bx - by, lean[side, j] * by + bx, 1.0 / radius
    node, push = start[side, j], push * scale[side, j]
    for k in range(N_NODES * len(stretch)):
        i = first + node
        speed = push * weight[side, k, j] * lightness[i]
        at = i * 2 * columns + column
        w[at] += speed * (x - points[2 * i + 1] * over)
        w[at + columns] += speed * (y + points[2 * i] * over)
        node = _next(node, n_surface)


@kernel(forceinline=True)
def rub_ring(
    u, w, raceway, n_sectors, radius, node_mass, push, start, weight, along, across, side, j, scale, lean, stretch
):
    """Spread an impulse along t, N s, over a ring's patch in contact j; returns its moment about the origin, N m s."""
    push *= scale[side, j]
    leaning, speed, moment, node = lean[side, j], push / node_mass, 0.0, start[side, j]
    for k in range(N_NODES * len(stretch)):
        at, c, s = node + HALO, along[side, k, j], across[side, k, j]
        x, y = leaning * c - s, weight[side, k, j] + c + leaning * s
        w[raceway, 0, at] += speed * x
        w[raceway, 1, at] += speed * y
        moment += (radius + u[raceway, 0, at]) * y - u[raceway, 1, at] * x
        node = _next(node, n_sectors)
    return push * moment
