"""What slopes of surfaces that are not perfect circles do to rollers: forces along the surfaces, and how these pass."""

from fem.kernels.drive import SPEED, outer_of, speed_of, turn_against, with_outer
from fem.kernels.jit import part
from fem.kernels.lane_functions import arc_tangent, maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, count_from, select, splat, total
from fem.kernels.prescribed_rollers import take_moment
from fem.kernels.reduced_housing import ring_place

# What contacts of the reduced model give way by the forces on their neighbours, at the angles where these are.
#
# Compliances along a ring go with the angle between two rollers. Within AGAIN steps they change by far less than what
# forces are solved to. Their slopes times neighbours' forces tilt a raceway, and with it a contact's force: rollers
# that neither friction nor a cage holds apart are spread by that.


AGAIN = 16  # steps, and at samples; a checkpoint needs none of it


@part(inlined=False)
def follow_angles(bodies, compliance, forces):
    """Compliances along both rings, and their slopes, where rollers are now."""
    columns, most, strayed = bodies.columns, compliance.strays, forces.strayed
    neighbours = compliance.distance.size
    _stray(bodies, compliance, forces)
    for row in range(2):
        for k in range(compliance.felt[row, 0]):
            distance = compliance.distance[k]
            for group in range(0, bodies.n, WIDTH):
                along, steep, a, b, c, d = _polynomials(compliance.spacing, compliance, row, k, group)
                at, to = forces.halo + group, (row * neighbours + k) * columns + group
                off = load(strayed, at + distance) - load(strayed, at)
                x = maximum(minimum(off, most), -most)
                store(forces.along, to, along + x * (steep + x * (a + x * (b + x * (c + x * d)))))
                slope = steep + x * (2.0 * a + x * (3.0 * b + x * (4.0 * c + x * (5.0 * d))))
                store(forces.steep, to, select(x == off, slope, 0.0))


@part
def _polynomials(spacing, compliance, row, k, group):
    """Coefficients of eight rollers' compliances by a neighbour, of how much further than usual it is."""
    if spacing is None:
        bent, at = compliance.bent, compliance.along[row, k]
        a, b, c, d = bent[row, 0, k], bent[row, 1, k], bent[row, 2, k], bent[row, 3, k]
        return splat(at), splat(compliance.steep[row, k]), splat(a), splat(b), splat(c), splat(d)
    neighbours, columns = spacing.along.shape[1], spacing.along.shape[2]
    at, apart, bent = (row * neighbours + k) * columns + group, neighbours * columns, spacing.bent
    to = at + 3 * row * apart
    a, b, c, d = load(bent, to), load(bent, to + apart), load(bent, to + 2 * apart), load(bent, to + 3 * apart)
    return load(spacing.along, at), load(spacing.steep, at), a, b, c, d


@part
def _stray(bodies, compliance, forces):
    """Tell by how much rollers are ahead of their pockets' angles from the first one's, about the outer ring.

    About the hub they are ahead by as much but for a thousandth of a roller's distance.
    """
    columns, n, halo, strayed = bodies.columns, bodies.n, forces.halo, forces.strayed
    ring_x, ring_y = ring_place(bodies.housing)
    x, y = bodies.centre[0, 0] - ring_x, bodies.centre[1, 0] - ring_y
    for group in range(0, n, WIDTH):
        c, s = load(compliance.apart, group), load(compliance.apart, columns + group)
        to_x, to_y = c * x - s * y, s * x + c * y
        here_x, here_y = load(bodies.centre, group) - ring_x, load(bodies.centre, columns + group) - ring_y
        store(strayed, halo + group, arc_tangent(to_x * here_y - to_y * here_x, to_x * here_x + to_y * here_y))
    for k in range(halo):
        strayed[halo - 1 - k] = strayed[halo + n - 1 - k]
        strayed[halo + n + k] = strayed[halo + k]


@part
def _distances(bodies, forces, group):
    """Of eight rollers' centres from those of hub and outer ring, m."""
    columns = bodies.columns
    x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
    ring_x, ring_y = ring_place(bodies.housing)
    out = (x - ring_x) * load(forces.normal, 2 * columns + group)
    out += (y - ring_y) * load(forces.normal, 3 * columns + group)
    x, y = x - bodies.hub[0], y - bodies.hub[1]
    away = x * load(forces.normal, group) + y * load(forces.normal, columns + group)
    there = count_from(group) < bodies.n
    return select(there, away, 1.0), select(there, out, 1.0)


@part
def push_along(slope, bodies, forces, drive, group, P, Q):
    """Forces of eight rollers along +θ, N, inner and outer, that slopes add; these turn rollers and inner ring too.

    `slope` : that of forces; None: perfect circles. Pairs: P : N, what a kick gives, Q : N, forces of the laws, whose
    compliance changes along edges.
    """
    if slope is None:
        return splat(0.0), splat(0.0)
    if not drive.looks:
        return splat(0.0), splat(0.0)
    columns, soft = bodies.columns, forces.softening
    away, out = _distances(bodies, forces, group)
    half, half_o = 0.5 * Q[0] * Q[0], 0.5 * Q[1] * Q[1]
    both = P[0] * load(slope, group) - half * load(soft, group)
    own = P[0] * load(slope, columns + group) - half * load(soft, columns + group)
    both_o = P[1] * load(slope, 2 * columns + group) - half_o * load(soft, 2 * columns + group)
    own_o = P[1] * load(slope, 3 * columns + group) - half_o * load(soft, 3 * columns + group)
    drive.sums[1] -= speed_of(drive.history, drive) * drive.dt * total(both - own)
    turn_against(outer_of(drive.history), drive, both_o - own_o)
    take_moment(bodies.prescribed, drive, own + own_o)
    store(bodies.spin, group, load(bodies.spin, group) + (own + own_o) * (drive.dt / bodies.inertia))
    return -both / away, -both_o / out


@part
def passing_rates(slope, bodies, forces, drive, group, motion):
    """Rates at which eight rollers' approaches grow as surfaces pass, m/s, inner and outer.

    What `push_along` gives of a force works along these, no more and no less. `motion` : velocities of hub and rollers,
    spins, velocity of the outer ring.
    """
    if slope is None:
        return splat(0.0), splat(0.0)
    if not drive.looks:
        return splat(0.0), splat(0.0)
    columns = bodies.columns
    hub, velocity, spin, ring = motion
    away, out = _distances(bodies, forces, group)
    vx, vy, turn = load(velocity, group), load(velocity, columns + group), load(spin, group)
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    around = ((vy - hub[1]) * ix - (vx - hub[0]) * iy) / away
    around_o = ((vy - ring[1]) * ox - (vx - ring[0]) * oy) / out
    both, own = load(slope, group), load(slope, columns + group)
    both_o, own_o = load(slope, 2 * columns + group), load(slope, 3 * columns + group)
    inner = both * around - own * turn - (both - own) * speed_of(drive.history, drive)
    outer = both_o * around_o - own_o * turn
    return inner, with_outer(outer_of(drive.history), outer, own_o - both_o, SPEED)
