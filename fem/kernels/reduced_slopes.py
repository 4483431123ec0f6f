"""What slopes of surfaces that are not perfect circles do to rollers: forces along the surfaces, and how these pass."""

from fem.kernels.course_kernels import speed_of
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import count_from, select, splat, total
from fem.kernels.reduced_housing import ring_place


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
    columns, soft = bodies.columns, forces.softening
    away, out = _distances(bodies, forces, group)
    half, half_o = 0.5 * Q[0] * Q[0], 0.5 * Q[1] * Q[1]
    both = P[0] * load(slope, group) - half * load(soft, group)
    own = P[0] * load(slope, columns + group) - half * load(soft, columns + group)
    both_o = P[1] * load(slope, 2 * columns + group) - half_o * load(soft, 2 * columns + group)
    own_o = P[1] * load(slope, 3 * columns + group) - half_o * load(soft, 3 * columns + group)
    drive.sums[1] -= speed_of(drive.course, drive) * drive.dt * total(both - own)
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
    inner = both * around - own * turn - (both - own) * speed_of(drive.course, drive)
    return inner, both_o * around_o - own_o * turn
