"""Surfaces of rigid bodies that are not perfect circles: what contacts meet, forces along slopes, how slopes pass.

Edges of spalls are compliances in series with a contact, or, where rollers tilt, with either part of one whose length
spalls take a part of: equation (5) of docs/tilted_motion.md and `tilted_contact`.
"""

from math import cos, sin

from fem.kernels.drive import SPEED, TURN, outer_of, speed_of, with_outer
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine, load_pair, store_pair
from fem.kernels.lanes import count_from, load, select, splat, store, total
from fem.kernels.mounts import ring_place
from fem.kernels.profiles import lowered_ring, lowered_rollers
from fem.kernels.rigid.rays import take_moment
from fem.kernels.rigid.state import normals
from fem.kernels.tilted_contact import FALL, NOW, PART_EDGES, SUNK


@part
def surfaces_met(step, group, turn):
    """What eight rollers' contacts meet: of the whole length, and of spalls' part of it, or None."""
    tilted, outer = step.contacts.tilted, outer_of(step.drive)
    whole = _met(step.contacts, step, group, turn, outer)
    if tilted is None:
        return whole, None
    if tilted.part is None:
        return whole, None
    return whole, _met(tilted.part, step, group, turn, outer)


@part
def _met(profiles, step, group, turn, outer):
    """What contacts meet of inner ring, roller, outer ring and roller; where steps pass no edge nothing.

    Each minus the sinkage, m, minus its slope per rad, the compliance of edges, m/N, and its slope.
    """
    bodies, forces = step.bodies, step.forces
    still = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if not step.drive.looks:
        return still, still, still, still
    columns = bodies.columns
    ix, iy, ox, oy = normals(forces, group, columns)
    c, s = cos(turn), sin(turn)
    ring = lowered_ring(profiles.ring_profiles[0], 1.0, still, c * ix + s * iy, c * iy - s * ix)
    bx, by = ox, oy  # in the outer ring's frame
    if outer is not None:
        c, s = cos(outer.now[TURN]), sin(outer.now[TURN])
        bx, by = c * ox + s * oy, c * oy - s * ox
    ring_o = lowered_ring(profiles.ring_profiles[1], 1.0, still, bx, by)
    c, s = cosine_and_sine(load(bodies.turn, group))
    own = lowered_rollers(profiles.roller_profiles[0], group, still, -(c * ix + s * iy), s * ix - c * iy)
    own_o = lowered_rollers(profiles.roller_profiles[1], group, still, c * ox + s * oy, c * oy - s * ox)
    return ring, own, ring_o, own_o


@part
def keep_edges(step, group, met, inner, outer):
    """Approaches of eight rollers, m, less what their contacts sink; compliances of edges are kept."""
    forces, columns = step.forces, step.bodies.columns
    ring, own, ring_o, own_o = met[0]
    if step.contacts.tilted is None:
        store_pair(forces.soft, group, columns, ring[2] + own[2], ring_o[2] + own_o[2])
    else:
        sunken = forces.tilted.sunken
        store_pair(forces.tilted.edges, 2 * NOW * columns + group, columns, ring[2] + own[2], ring_o[2] + own_o[2])
        if sunken is not None:
            a, b, c, d = met[1]
            store_pair(sunken, 2 * SUNK * columns + group, columns, -a[0] - b[0], -c[0] - d[0])
            store_pair(sunken, 2 * PART_EDGES * columns + group, columns, a[2] + b[2], c[2] + d[2])
    return inner + ring[0] + own[0], outer + ring_o[0] + own_o[0]


@part
def keep_slopes(step, group, met, Q_i, Q_o):
    """Slopes of approaches along surfaces, m/rad, with those of all by which energies fall over the forces, N."""
    contacts, forces, columns = step.contacts, step.forces, step.bodies.columns
    ring, own, ring_o, own_o = met[0]
    soft_i, soft_o = 0.5 * Q_i, 0.5 * Q_o
    if contacts.tilted is not None:
        soft_i, soft_o = load_pair(forces.tilted.edges, 2 * FALL * columns + group, columns)
    elif contacts.coupling is not None:  # by the forces of the kick: see `push_along`
        soft_i, soft_o = splat(0.0), splat(0.0)
        store_pair(forces.softening, group, columns, ring[3] + own[3], own[3])
        store_pair(forces.softening, 2 * columns + group, columns, ring_o[3] + own_o[3], own_o[3])
    turning, turning_o = own[1] - soft_i * own[3], own_o[1] - soft_o * own_o[3]
    both, both_o = ring[1] - soft_i * ring[3] + turning, ring_o[1] - soft_o * ring_o[3] + turning_o
    if contacts.tilted is not None:
        if forces.tilted.sunken is not None:
            ring, own, ring_o, own_o = met[1]
            share_i, share_o = load_pair(forces.tilted.sunken, 2 * (SUNK + FALL) * columns + group, columns)
            soft_i, soft_o = load_pair(forces.tilted.sunken, 2 * (PART_EDGES + FALL) * columns + group, columns)
            more, more_o = share_i * own[1] - soft_i * own[3], share_o * own_o[1] - soft_o * own_o[3]
            both += share_i * ring[1] - soft_i * ring[3] + more
            both_o += share_o * ring_o[1] - soft_o * ring_o[3] + more_o
            turning, turning_o = turning + more, turning_o + more_o
    store_pair(forces.slope, group, columns, both, turning)
    store_pair(forces.slope, 2 * columns + group, columns, both_o, turning_o)


@part
def _distances(bodies, forces, group):
    """Of eight rollers' centres from those of hub and outer ring, m."""
    columns = bodies.columns
    x, y = load_pair(bodies.centre, group, columns)
    ring_x, ring_y = ring_place(bodies.housing)
    ix, iy, ox, oy = normals(forces, group, columns)
    out = (x - ring_x) * ox + (y - ring_y) * oy
    away = (x - bodies.hub[0]) * ix + (y - bodies.hub[1]) * iy
    there = count_from(group) < bodies.n
    return select(there, away, 1.0), select(there, out, 1.0)


@part
def push_along(step, group, P, Q):
    """Forces of eight rollers along +θ, N, inner and outer, that slopes add; these turn rollers and inner ring too.

    Pairs: P : N, what a kick gives, Q : N, forces of the laws, whose compliance changes along edges.
    """
    bodies, forces, drive = step.bodies, step.forces, step.drive
    if forces.slope is None:
        return splat(0.0), splat(0.0)
    if not drive.looks:
        return splat(0.0), splat(0.0)
    columns, slope, soft = bodies.columns, forces.slope, forces.softening
    away, out = _distances(bodies, forces, group)
    half, half_o = 0.5 * Q[0] * Q[0], 0.5 * Q[1] * Q[1]
    (both, own), (soft_both, soft_own) = load_pair(slope, group, columns), load_pair(soft, group, columns)
    both, own, at = P[0] * both - half * soft_both, P[0] * own - half * soft_own, 2 * columns + group
    (both_o, own_o), (soft_both, soft_own) = load_pair(slope, at, columns), load_pair(soft, at, columns)
    both_o, own_o = P[1] * both_o - half_o * soft_both, P[1] * own_o - half_o * soft_own
    drive.sums[1] -= speed_of(drive) * drive.dt * total(both - own)
    outer = None if drive.history is None else drive.history.outer
    if outer is not None:
        drive.sums[1] -= outer.now[SPEED] * drive.dt * total(both_o - own_o)
    take_moment(bodies.prescribed, drive, own + own_o)
    store(bodies.spin, group, load(bodies.spin, group) + (own + own_o) * (drive.dt / bodies.inertia))
    return -both / away, -both_o / out


@part
def passing_rates(step, group, motion):
    """Rates at which eight rollers' approaches grow as surfaces pass, m/s, inner and outer.

    What `push_along` gives of a force works along these, no more and no less. `motion` : velocities of hub and rollers,
    spins, velocity of the outer ring.
    """
    bodies, forces, drive = step.bodies, step.forces, step.drive
    if forces.slope is None:
        return splat(0.0), splat(0.0)
    if not drive.looks:
        return splat(0.0), splat(0.0)
    columns, slope, (hub, velocity, spin, ring) = bodies.columns, forces.slope, motion
    away, out = _distances(bodies, forces, group)
    (vx, vy), turn = load_pair(velocity, group, columns), load(spin, group)
    ix, iy, ox, oy = normals(forces, group, columns)
    around = ((vy - hub[1]) * ix - (vx - hub[0]) * iy) / away
    around_o = ((vy - ring[1]) * ox - (vx - ring[0]) * oy) / out
    (both, own), (both_o, own_o) = load_pair(slope, group, columns), load_pair(slope, 2 * columns + group, columns)
    inner = both * around - own * turn - (both - own) * speed_of(drive)
    outer = both_o * around_o - own_o * turn
    return inner, with_outer(drive, outer, own_o - both_o, SPEED)
