"""Surfaces as contacts meet them, and what contacts do to them: patches of six nodes, or bodies declared rigid.

Patch: a cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.

Eight contacts at a time (lanes), side by side from roller `group` on; `side` is 2·row + 0 or 1; `column`, lanes, is
the roller whose surface it is, which rings don't look at. A patch is the places of its nodes and weights (side, node of
the patch, roller); a ring's has them also times cosine and sine of the angle from each node to the contact.

Tangential motion and force of a patch: along the contact's tangent t alone it would miss a share 1 − Σ W cos φ of a
rotation and of the moment (φ from the contact to the node), along the nodes' own tangents as much of a translation and
of the force. Directions g = (t_node + t + slope·b)·scale, slope = Σ W sin φ, scale = 1/(1 + Σ W cos φ), weighted with
W, miss nothing: all that a traction does to a body it does at its own nodes, and no other contact of the body has a
part in it. The mobility is the velocity Σ W g·w that a patch gains per unit impulse along its W g, 1/kg.

Bodies declared rigid have no nodes, they are pushed and turned as a whole. A rigid roller's contact forces act through
its centre; its leapfrog is of velocity and spin. A rigid inner ring is the hub, a rigid outer one the ground. Every
traction on one of them moves its other contacts at once, see `friction`.
"""

from math import pi

from fem.kernels import lanes
from fem.kernels.drive import SPEED, speed_of
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import DiscSurface, Ground, Hub, RigidDisc, RingSurface
from fem.kernels.jit import kernel, part
from fem.kernels.lane_functions import load_pair, store_pair
from fem.kernels.lanes import gather, gather_rows, load, select, splat, store, total
from fem.kernels.law import place, seamless

N_NODES = 6
FILL, CLEAR, GIVE = range(3)  # of ghost nodes
ONE = (0,)  # as long as a contact of one patch
CORNER = 0.02  # of a facet on either side of a node is rounded: no force jumps where a node passes


@kernel(forceinline=True)
def chord(beyond):
    """Depth below the circle over the sagitta h²/8R, and its slope per facet, a share `beyond` in [0, 1) past a node.

    4 t (1 − t), averaged over CORNER on either side.
    """
    d = beyond if beyond < 0.5 else beyond - 1.0
    if abs(d) < CORNER:
        return CORNER * (2.0 - 4.0 / 3.0 * CORNER) + 2.0 * d * d * (1.0 / CORNER - 2.0), 4.0 * d * (1.0 / CORNER - 2.0)
    return 4.0 * beyond * (1.0 - beyond) - 4.0 / 3.0 * CORNER * CORNER, 4.0 - 8.0 * beyond


@kernel(forceinline=True)
def first_node(base):
    """Node a patch begins at, where `base` is the node at or before its centre."""
    return base - 2


@kernel(forceinline=True)
def weights(t):
    """Quintic B-spline at the six nodes around a point a fraction t in [0, 1), or lanes, beyond a node.

    Their sum is 1, first moments are exact.

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    share = 1.0 / 120.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    return (
        r2 * r2 * r * share,
        (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) * share,
        (66.0 - s2 * (60.0 - s2 * (30.0 - 10.0 * s))) * share,
        (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) * share,
        (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + s * (5.0 - 5.0 * s))))) * share,
        s2 * s2 * s * share,
    )


@part
def weight_slopes(t):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    share = 1.0 / 24.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    return (
        r2 * r2 * -share,
        (1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) * -share,
        s * (24.0 - s2 * (24.0 - 10.0 * s)) * -share,
        r * (24.0 - r2 * (24.0 - 10.0 * r)) * share,
        (1.0 + s * (4.0 + s * (6.0 + s * (4.0 - 5.0 * s)))) * share,
        s2 * s2 * share,
    )


# sets of six, of a patch's nodes


@part
def put(out, at, step, six):
    """Store the values for a patch's nodes at flat indices at, at + step, ..."""
    a, b, c, d, e, f = six
    store_pair(out, at, step, a, b)
    store_pair(out, at + 2 * step, step, c, d)
    store_pair(out, at + 4 * step, step, e, f)


@part
def take(array, at, step):
    """Eight contacts' values for a patch's nodes from flat indices at, at + step, ..."""
    a, b = load_pair(array, at, step)
    c, d = load_pair(array, at + 2 * step, step)
    e, f = load_pair(array, at + 4 * step, step)
    return a, b, c, d, e, f


@part
def _dot(one, other):
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return ((a * p + b * q) + (c * r + d * s)) + (e * t + f * u)


@part
def _products(one, other):
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return a * p, b * q, c * r, d * s, e * t, f * u


@part
def _scaled(x, one):
    a, b, c, d, e, f = one
    return x * a, x * b, x * c, x * d, x * e, x * f


@part
def _combined(x, one, y, other):
    """x·one + y·other, of two sets of six."""
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return x * a + y * p, x * b + y * q, x * c + y * r, x * d + y * s, x * e + y * t, x * f + y * u


@part
def first_weight(patches, side, group):
    """Flat index of eight patches' first weights."""
    return side * N_NODES * len(patches.units) * patches.columns + group


# where patches lie, and how they move


@part
def locate_patch(surface, patches, side, group):
    """Put patches around their outward directions b, of a ring radial ones: positions and first nodes."""
    if isinstance(surface, RingSurface) or isinstance(surface, DiscSurface):
        columns, n_nodes = patches.columns, surface.n_nodes
        bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
        position = place(bx, by, n_nodes)
        base = lanes.to_int(position)
        base = select((base >= 0) & (base < n_nodes), base, 0)  # of what is not a number memory would be read elsewhere
        node = first_node(base)
        store(patches.position, side * columns + group, position)
        store(patches.beyond, side * columns + group, position - lanes.to_float(base))
        store(patches.start, side * columns + group, select(node < 0, node + n_nodes, node))


@part
def interpolate_displacement(surface, patches, side, group, column):
    """Weights of patches that have been put down, and the motion there.

    Returns outward motion U·b, sideways motion U·Jb, dU/ds·b per rad, ripple of A·B, its slope per rad. That is the
    motion of nodes: of a rigid body nothing.
    """
    if isinstance(surface, RingSurface):
        return _interpolate_on_ring(surface, patches, side, group)
    if isinstance(surface, DiscSurface):
        return _interpolate_on_roller(surface, patches, side, group, column)
    zero = splat(0.0)
    return zero, zero, zero, zero, zero


@part
def _interpolate_on_ring(ring, patches, side, group):
    columns, cosines, sines, h = patches.columns, ring.cosines, ring.sines, HALO
    at, width = first_weight(patches, side, group), ring.cosines.size
    bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
    t, node = load(patches.beyond, side * columns + group), load(patches.start, side * columns + group)
    store(patches.place, at, node + (2 * ring.row * width + h))
    # cosines and sines of the angles from the nodes to the contacts
    first_c, first_s = gather(cosines, node + h), gather(sines, node + h)
    c, s = bx * first_c + by * first_s, by * first_c - bx * first_s
    steps_c = cosines[h], cosines[h + 1], cosines[h + 2], cosines[h + 3], cosines[h + 4], cosines[h + 5]
    steps_s = sines[h], sines[h + 1], sines[h + 2], sines[h + 3], sines[h + 4], sines[h + 5]
    c, s = _combined(c, steps_c, s, steps_s), _combined(s, steps_c, -c, steps_s)
    share = weights(t)
    along, across = _products(share, c), _products(share, s)
    put(patches.weight, at, columns, share)
    put(patches.along, at, columns, along)
    put(patches.across, at, columns, across)
    a, b = gather_rows(ring.u, patches.place, at, 0), gather_rows(ring.u, patches.place, at, width)
    change = weight_slopes(t)
    out, sideways = _dot(along, a) + _dot(across, b), _dot(along, b) - _dot(across, a)
    rate = _dot(_products(change, c), a) + _dot(_products(change, s), b)
    ripple, ripple_slope = seamless(t, ring.ripple)
    per_radian = ring.n_nodes / (2.0 * pi)
    return out, sideways, rate * per_radian, ripple, ripple_slope * per_radian


@part
def _interpolate_on_roller(disc, patches, side, group, column):
    columns = patches.columns
    at, stride, here = first_weight(patches, side, group), 2 * columns, side * columns + group
    put(patches.inverse_mass, at, columns, gather_rows(disc.inverse_mass, patches.start, here, disc.first))
    around, node = disc.n_nodes * stride, (load(patches.start, here) + disc.first) * stride + column
    for k in range(N_NODES):
        store(patches.place, at + k * columns, node)
        node += stride
        node = select(node >= disc.first * stride + around, node - around, node)
    t = load(patches.beyond, here)
    share, change = weights(t), weight_slopes(t)
    put(patches.weight, at, columns, share)
    x, y = lanes.gather_nodes(disc.u, patches.place, at, columns)
    ux, uy, sx, sy = _dot(share, x), _dot(share, y), _dot(change, x), _dot(change, y)
    ripple, ripple_slope = seamless(load(patches.position, here), disc.ripple)
    bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
    per_radian = disc.n_nodes / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@part
def out_of_surface(surface, patches, side, group, nx, ny):
    """Velocities of patches along b, m/s, of rollers against their centres of mass, and their mobilities, 1/kg; of a
    raceway whose ghost nodes are filled; of a rigid ring along n. What stands still has neither."""
    if isinstance(surface, Hub):
        return surface.velocity[0] * nx + surface.velocity[1] * ny, splat(1.0 / surface.late_mass)
    if isinstance(surface, RigidDisc):
        return splat(0.0), splat(1.0 / surface.total_mass)
    at, columns, out, light = first_weight(patches, side, group), patches.columns, splat(0.0), splat(0.0)
    if isinstance(surface, DiscSurface):
        bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
        for unit in range(len(patches.units)):
            i = at + unit * N_NODES * columns
            share, (x, y) = take(patches.weight, i, columns), lanes.gather_nodes(surface.w, patches.place, i, columns)
            out += bx * _dot(share, x) + by * _dot(share, y)
            light += _dot(_products(share, share), take(patches.inverse_mass, i, columns))
    if isinstance(surface, RingSurface):
        for unit in range(len(patches.units)):
            i = at + unit * N_NODES * columns
            along, across = take(patches.along, i, columns), take(patches.across, i, columns)
            out += _dot(along, gather_rows(surface.w, patches.place, i, 0))
            out += _dot(across, gather_rows(surface.w, patches.place, i, surface.cosines.size))
            light += _dot(along, along) + _dot(across, across)
        light = light * (1.0 / surface.node_mass)
    return out, light


@part
def tangential_velocity(surface, patches, side, group, column, nx, ny):
    """Velocity of surfaces along t = Jn, m/s; of a roller relative to its centre of mass and against a clock."""
    if isinstance(surface, Hub):
        return surface.velocity[1] * nx - surface.velocity[0] * ny + speed_of(surface) * surface.radius
    if isinstance(surface, Ground):
        return splat(0.0 if surface.turning is None else surface.turning.now[SPEED] * surface.radius)
    if isinstance(surface, RigidDisc):
        return gather(surface.spin, column) * surface.radius
    at, columns, found = first_weight(patches, side, group), patches.columns, splat(0.0)
    for unit in range(len(patches.units)):
        i = at + unit * N_NODES * columns
        if isinstance(surface, DiscSurface):
            x, y = lanes.gather_nodes(surface.v, patches.place, i, columns)
            found += _dot(take(patches.traction_x, i, columns), x) + _dot(take(patches.traction_y, i, columns), y)
        if isinstance(surface, RingSurface):
            width = surface.cosines.size
            found += _dot(take(patches.traction_x, i, columns), gather_rows(surface.v, patches.place, i, 0))
            found += _dot(take(patches.traction_y, i, columns), gather_rows(surface.v, patches.place, i, width))
    return found


@part
def tangential_mobility(surface, patches, side, group):
    """Mobilities of patches, 1/kg; keeps what a unit traction does to their nodes, W g, for what follows."""
    at, columns, mobility = first_weight(patches, side, group), patches.columns, splat(body_mobility(surface))
    x, y = splat(0.0), splat(0.0)
    if isinstance(surface, RingSurface):
        for k in range(N_NODES * len(patches.units)):
            x += load(patches.along, at + k * columns)
            y -= load(patches.across, at + k * columns)
        scale, slope = 1.0 / (1.0 + x), y
        for k in range(N_NODES * len(patches.units)):
            i = at + k * columns
            c, s = load(patches.along, i), load(patches.across, i)
            radial, around = scale * (slope * c - s), scale * (load(patches.weight, i) + c + slope * s)
            store(patches.traction_x, i, radial)
            store(patches.traction_y, i, around)
            mobility += radial * radial + around * around
        mobility = mobility * (1.0 / surface.node_mass)
    if isinstance(surface, DiscSurface):
        over, points = 1.0 / surface.radius, surface.points
        bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
        # unit directions of the patches' first nodes, from which those of the others follow
        start = load(patches.start, side * columns + group)
        first_x, first_y = lanes.gather_pair(points, (start + surface.first) * 2, 1)
        first_x, first_y = first_x * over, first_y * over
        for k in range(N_NODES * len(patches.units)):
            i, node = at + k * columns, 2 * (surface.first + k)
            c, s, share = points[node] * over, points[node + 1] * over, load(patches.weight, i)
            node_x, node_y = first_x * c - first_y * s, first_y * c + first_x * s
            store(patches.traction_x, i, node_x)
            store(patches.traction_y, i, node_y)
            x += share * node_x
            y += share * node_y
        scale, slope = 1.0 / (1.0 + (bx * x + by * y)), bx * y - by * x
        x, y = slope * bx - by, slope * by + bx
        for k in range(N_NODES * len(patches.units)):
            i = at + k * columns
            share, light = scale * load(patches.weight, i), load(patches.inverse_mass, i)
            along_x, along_y = share * (x - load(patches.traction_y, i)), share * (y + load(patches.traction_x, i))
            store(patches.traction_x, i, along_x)
            store(patches.traction_y, i, along_y)
            mobility += (along_x * along_x + along_y * along_y) * light
    return mobility


@part
def body_mobility(surface):
    """Velocity of a rigid body's surface along itself per impulse along itself, 1/kg; 0 of a body with nodes.

    A hub's is a bound: its own times the number of contacts, as if all of them rubbed in the same direction. They are
    solved for at once, each with its own mobility; with the bound none takes back what others have given. Of a roller's
    patch it is a small part.
    """
    if isinstance(surface, Hub):
        return surface.n_contacts / surface.late_mass
    if isinstance(surface, RigidDisc):
        return 1.0 / surface.total_mass + surface.radius * surface.radius / surface.inertia
    return 0.0


# what contacts give; all return moments about the origin, N m s, of impulses on rings


@part
def _shares(impulse, normal, around, tangential, at, columns):
    """What six nodes of eight patches get of impulses along b and along surfaces, of which either may be None."""
    if around is None:
        return _scaled(impulse, take(normal, at, columns))
    if impulse is None:
        return _scaled(around, take(tangential, at, columns))
    return _combined(impulse, take(normal, at, columns), around, take(tangential, at, columns))


@part
def scatter_force(surface, patches, side, group, impulse, around):
    """Spread impulses, N s, along b and, counter-clockwise, along surfaces over patches; None: no such ones."""
    at, columns, moment = first_weight(patches, side, group), patches.columns, splat(0.0)
    if isinstance(surface, RingSurface):
        w, u, place, over, width = surface.w, surface.u, patches.place, 1.0 / surface.node_mass, surface.cosines.size
        for unit in range(len(patches.units)):
            i = at + unit * N_NODES * columns
            radial = _shares(impulse, patches.along, around, patches.traction_x, i, columns)
            tangential = _shares(impulse, patches.across, around, patches.traction_y, i, columns)
            p, q, r, s, t, v = tangential
            lanes.add_to_rows(w, place, i, 0, _scaled(over, radial))
            lanes.add_to_rows(w, place, i, width, _scaled(over, tangential))
            x, y = gather_rows(u, place, i, 0), gather_rows(u, place, i, width)
            moment += surface.radius * (((p + q) + (r + s)) + (t + v)) + (_dot(x, tangential) - _dot(y, radial))
    elif isinstance(surface, DiscSurface):
        bx, by = load_pair(patches.outward, 2 * side * columns + group, columns)
        if impulse is not None:
            bx, by = impulse * bx, impulse * by
        for k in range(N_NODES * len(patches.units)):
            i, x, y = at + k * columns, splat(0.0), splat(0.0)
            if impulse is not None:
                weight = load(patches.weight, i)
                x, y = weight * bx, weight * by
            if around is not None:
                x, y = x + around * load(patches.traction_x, i), y + around * load(patches.traction_y, i)
            light = load(patches.inverse_mass, i)
            lanes.add_at_places(surface.w, patches.place, i, columns, x * light, y * light)
    elif isinstance(surface, Hub):
        if impulse is not None:
            nx, ny = load_pair(patches.normal, side * columns + group, columns)  # the hub is on side 0
            surface.impulse[0] += total(impulse * nx)
            surface.impulse[1] += total(impulse * ny)
    elif isinstance(surface, Ground):
        if around is not None:
            moment = around * surface.radius
    return moment


@part
def push_body(surface, column, x, y, around):
    """Give a rigid body an impulse (x, y), N s, at its surface, `around` of it along the surface counter-clockwise.

    A body with nodes gets nothing.
    """
    if isinstance(surface, Hub):
        surface.velocity[0] += x / surface.late_mass
        surface.velocity[1] += y / surface.late_mass
        return surface.place[0] * y - surface.place[1] * x + surface.radius * around
    if isinstance(surface, RigidDisc):
        over = 1.0 / surface.total_mass
        surface.velocity[0, column] += x * over
        surface.velocity[1, column] += y * over
        surface.turn_kick[column] += around * (surface.radius / surface.inertia)
    return 0.0


@part
def ghost_nodes(surface, what):
    """The room behind a raceway's last node, where impulses on its first ones may go.

    FILL it with the first nodes' velocities, CLEAR it, or GIVE the first nodes what has gone there.
    """
    if isinstance(surface, RingSurface):
        w, width = surface.w, surface.cosines.size
        for component in range(2):
            first = (2 * surface.row + component) * width + HALO
            ghosts = first + width - 2 * HALO
            if what == GIVE:
                store(w, first, load(w, first) + load(w, ghosts))
            else:
                store(w, ghosts, load(w, first) if what == FILL else splat(0.0))
