"""What contacts ask of a surface and do to it. The code for each type of surface is in the module of its body.

Eight contacts at a time are read (lanes), side by side from roller `group` on; pushing is one contact's, for two
contacts may push one node. `side` is 2·row + 0 or 1; `column`, lanes or a number, is the roller whose surface it is,
which rings don't look at. A patch is its first node, the others follow, and weights (side, node of the patch, roller);
a ring's has them also times cosine and sine of the angle from each node to the contact.

Tangential motion and force of a patch: along the contact's tangent t alone it would miss a share 1 − Σ W cos φ of a
rotation and of the moment (φ from the contact to the node), along the nodes' own tangents as much of a translation and
of the force. Directions g = (t_node + t + slope·b)·scale, slope = Σ W sin φ, scale = 1/(1 + Σ W cos φ), weighted with
W, miss nothing: all that a traction does to a body it does at its own nodes, and no other contact of the body has a
part in it. The mobility is the velocity Σ W g·w that a patch gains per unit impulse along its W g, 1/kg.
"""

from math import pi

from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import arc_tangent
from fem.kernels.patches import N_NODES, ONE, first_node, weight_slopes, weights
from fem.kernels.simd import WIDTH, real, select, splat, store, whole


@verb
def read(surface, patches, side, group, column, bx, by):
    """Place patches around outward directions b (of a ring: radial ones) in the body's frame and read the motion there.

    Returns outward motion U·b, sideways motion U·Jb, dU/ds·b per rad, ripple of A·B, its slope per rad. That is the
    motion of nodes: of a rigid body nothing.
    """
    zero = splat(0.0)
    return zero, zero, zero, zero, zero


@verb
def push(surface, patches, side, j, column, impulse):
    """Spread an impulse, N s, along b over the patch of contact j; returns its moment about the origin, N m s."""
    return 0.0


@verb
def grip(surface, patches, side, group):
    """Mobilities of patches, 1/kg; keeps their scale and slope for what follows."""
    return splat(0.0)


@verb
def sideways(surface, patches, side, group, column, nx, ny):
    """Velocity of surfaces along t = Jn, m/s; of a roller relative to its centre of mass and against a clock."""
    return splat(0.0)


@verb
def push_along(surface, patches, side, j, column, impulse, x, y):
    """Spread an impulse, N s, counter-clockwise along a surface over the patch of contact j; (x, y) in fixed axes.

    Returns its moment about the origin, N m s.
    """
    return 0.0


@verb
def push_body(surface, column, x, y, around):
    """Give a rigid body an impulse (x, y), N s, at its surface, `around` of it along the surface counter-clockwise.

    Returns its moment about the origin, N m s. A body with nodes gets nothing.
    """
    return 0.0


@verb
def body_mobility(surface):
    """Velocity of a rigid body's surface along itself per impulse along itself, 1/kg; 0 of a body with nodes."""
    return 0.0


@verb
def body_motion(surface, column, nx, ny):
    """Velocity of rigid bodies along t and that of their surface by their spin, m/s, but for the shaft's."""
    return splat(0.0), splat(0.0)


@part
def place(x, y, n_nodes):
    """Position, in node spacings in [0, n_nodes), of a direction in a body's frame; scalars or lanes."""
    position = arc_tangent(y, x) * (n_nodes / (2.0 * pi))
    position = select(position < 0.0, position + 1.0 * n_nodes, position)
    return select(position >= 1.0 * n_nodes, position - 1.0 * n_nodes, position)


@part
def next_node(i, n_nodes):
    """The node after node i of a circle; scalar or lanes."""
    return select(i >= n_nodes - 1, 0, i + 1)


@part
def first_weight(patches, side, group, units):
    """Flat index of eight patches' first weights."""
    return side * N_NODES * len(units) * patches.columns + group


@part
def place_patch(patches, side, group, bx, by, n_nodes):
    """Put patches around directions b of circles of nodes: their first nodes, weights and the weights' slopes.

    Returns positions in node spacings, how far they are beyond a node, and the first nodes.
    """
    position = place(bx, by, n_nodes)
    base = whole(position)
    base = select((base >= 0) & (base < n_nodes), base, 0)  # where it is not a number memory would be read elsewhere
    t = position - real(base)
    weights(t, patches.weight, first_weight(patches, side, group, ONE), patches.columns)
    weight_slopes(t, patches.weight_slope, 0, WIDTH)
    node = first_node(base)
    node = select(node < 0, node + n_nodes, node)
    store(patches.start, side * patches.columns + group, node)
    return position, t, node
