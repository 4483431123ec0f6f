"""What contacts ask of a surface and do to it. The code for each type of surface is in the module of its body.

Eight contacts at a time (lanes), side by side from roller `group` on; `side` is 2·row + 0 or 1; `column`, lanes, is
the roller whose surface it is, which rings don't look at. A patch is the places of its nodes and weights (side, node of
the patch, roller); a ring's has them also times cosine and sine of the angle from each node to the contact.

Tangential motion and force of a patch: along the contact's tangent t alone it would miss a share 1 − Σ W cos φ of a
rotation and of the moment (φ from the contact to the node), along the nodes' own tangents as much of a translation and
of the force. Directions g = (t_node + t + slope·b)·scale, slope = Σ W sin φ, scale = 1/(1 + Σ W cos φ), weighted with
W, miss nothing: all that a traction does to a body it does at its own nodes, and no other contact of the body has a
part in it. The mobility is the velocity Σ W g·w that a patch gains per unit impulse along its W g, 1/kg.

Surfaces that are not perfect circles: what comes off the outward motion of a contact's two sides.

`lagrange.surface.deviation` says what a sinkage is, and the compliance of edges, which adds to the ripple. Bodies
without a profile have None, which compiles to nothing.
"""

from math import pi

from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import arc_tangent
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import select, splat, to_float, to_int
from fem.kernels.law import spline_at
from fem.kernels.patches import N_NODES, first_node


@verb
def locate_patch(surface, patches, side, group):
    """Put patches around their outward directions b, of a ring radial ones: positions and first nodes."""


@verb
def interpolate_displacement(surface, patches, side, group, column):
    """Weights of patches that have been put down, and the motion there.

    Returns outward motion U·b, sideways motion U·Jb, dU/ds·b per rad, ripple of A·B, its slope per rad. That is the
    motion of nodes: of a rigid body nothing.
    """
    zero = splat(0.0)
    return zero, zero, zero, zero, zero


@part
def keep_motion(patches, side, group, found):
    """Keep what `interpolate_displacement` has found."""
    out, sideways, rate, ripple, ripple_rate = found
    at, columns = 5 * side * patches.columns + group, patches.columns
    store(patches.motion, at, out)
    store(patches.motion, at + columns, sideways)
    store(patches.motion, at + 2 * columns, rate)
    store(patches.motion, at + 3 * columns, ripple)
    store(patches.motion, at + 4 * columns, ripple_rate)


@part
def kept_motion(patches, side, group):
    """Outward motion, its slope, ripple and its slope, and sideways motion."""
    at, columns, motion = 5 * side * patches.columns + group, patches.columns, patches.motion
    out, sideways, rate = load(motion, at), load(motion, at + columns), load(motion, at + 2 * columns)
    return (out, rate, load(motion, at + 3 * columns), load(motion, at + 4 * columns)), sideways


@verb
def scatter_normal_force(surface, patches, side, group, impulse):
    """Spread impulses, N s, along b over patches; returns their moments about the origin, N m s."""
    return 0.0


@verb
def out_of_surface(surface, patches, side, group):
    """Velocities of patches along b, m/s, of rollers against their centres of mass, and their mobilities, 1/kg; of a
    raceway that has been sealed. Rigid bodies have neither."""
    return splat(0.0), splat(0.0)


@verb
def tangential_mobility(surface, patches, side, group):
    """Mobilities of patches, 1/kg; keeps what a unit traction does to their nodes, W g, for what follows."""
    return splat(0.0)


@verb
def tangential_velocity(surface, patches, side, group, column, nx, ny):
    """Velocity of surfaces along t = Jn, m/s; of a roller relative to its centre of mass and against a clock."""
    return splat(0.0)


@verb
def scatter_tangential_force(surface, patches, side, group, impulse):
    """Spread impulses, N s, counter-clockwise along surfaces over patches; their moments about the origin, N m s."""
    return 0.0


@verb
def scatter_force(surface, patches, side, group, impulse, around):
    """`scatter_normal_force` and `scatter_tangential_force` in one pass."""
    return 0.0


@verb
def count_impulse(surface, column, x, y):
    """Count an impulse, N s, that nodes of rollers are given to their centres' motion; `column`: the first of eight,
    or lanes."""


@verb
def fill_ghost_nodes(surface):
    """Repeat the velocities of a raceway's first nodes behind its last."""


@verb
def clear_ghost_nodes(surface):
    """Empty the room behind a raceway's last node, where impulses on its first ones may go."""


@verb
def accumulate_ghost_nodes(surface):
    """Give the first nodes of a raceway what has gone behind its last."""


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
def first_weight(patches, side, group):
    """Flat index of eight patches' first weights."""
    return side * N_NODES * len(patches.units) * patches.columns + group


@part
def place_patch(patches, side, group, n_nodes):
    """Put patches down on circles of nodes."""
    columns = patches.columns
    out = 2 * side * columns + group
    position = place(load(patches.outward, out), load(patches.outward, out + columns), n_nodes)
    base = to_int(position)
    base = select((base >= 0) & (base < n_nodes), base, 0)  # where it is not a number memory would be read elsewhere
    node = first_node(base)
    store(patches.position, side * columns + group, position)
    store(patches.beyond, side * columns + group, position - to_float(base))
    store(patches.start, side * columns + group, select(node < 0, node + n_nodes, node))


@part
def lowered_ring(profile, sign, motion, bx, by):
    """A raceway's outward motion, its slope per rad, ripple and its slope, at directions b in the ring's frame.

    `motion` : the four of a perfect circle; the sinkage comes off, compliance is added.
    """
    if profile is None:
        return motion
    out, rate, ripple, ripple_rate = motion
    n = profile.sinkage.size
    at, per_rad = place(bx, by, n), n / (2.0 * pi)
    sinkage, slope = spline_at(at, profile.sinkage, 0, n)
    soft, softening = spline_at(at, profile.compliance, 0, n)
    return out - sign * sinkage, rate - slope * (sign * per_rad), ripple + soft, ripple_rate + softening * per_rad


@part
def lowered_rollers(profiles, group, motion, bx, by):
    """The same of eight rollers from `group` on, at directions b in their frames."""
    if profiles is None:
        return motion
    out, rate, ripple, ripple_rate = motion
    n = profiles.sinkage.shape[1]
    at, first, per_rad = place(bx, by, n), load(profiles.first, group), n / (2.0 * pi)
    sinkage, slope = spline_at(at, profiles.sinkage, first, n)
    soft, softening = spline_at(at, profiles.compliance, first, n)
    return out - sinkage, rate - slope * per_rad, ripple + soft, ripple_rate + softening * per_rad
