"""Surfaces of rigid bodies that are not perfect circles: what contacts meet, forces along slopes, how slopes pass.

Edges of spalls are compliances in series with a contact, or, where rollers tilt, with either part of one whose length
spalls take a part of: equation (5) of docs/tilted_motion.md and `tilted_contact`.
"""

from math import cos, sin

from fem.kernels.columns import INNER, OUTER
from fem.kernels.drive import SPEED, TURN, speed_of, with_outer
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine, load_pair, store_pair
from fem.kernels.lanes import count_from, load, select, splat, store, total
from fem.kernels.law import lowered_ring, lowered_rollers
from fem.kernels.mounts import ring_place
from fem.kernels.rigid.rays import take_moment
from fem.kernels.rigid.state import normals
from fem.kernels.tilted_contact import FALL, NOW, PART_EDGES, SUNK


@part
def surfaces_met(step, group, turn):
    """What eight rollers' contacts meet: of the whole length, and of spalls' part of it, or None."""
    tilted, whole = step.contacts.tilted, _met(step.contacts, step, group, turn)
    if tilted is None:
        return whole, None
    if tilted.part is None:
        return whole, None
    return whole, _met(tilted.part, step, group, turn)


@part
def _met(profiles, step, group, turn):
    """What contacts meet of ring and roller, inner and outer; where steps pass no edge nothing.

    Each minus the sinkage, m, minus its slope per rad, the compliance of edges, m/N, and its slope.
    """
    bodies, forces, history = step.bodies, step.forces, step.drive.history
    still = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if not step.drive.looks:
        return (still, still), (still, still)
    columns = bodies.columns
    ix, iy, ox, oy = normals(forces, group, columns)
    c, s = cos(turn), sin(turn)
    ring = lowered_ring(profiles.ring_profiles[0], 1.0, still, c * ix + s * iy, c * iy - s * ix)
    bx, by = ox, oy  # in the outer ring's frame
    if history is not None:
        if history.outer is not None:
            c, s = cos(history.outer.now[TURN]), sin(history.outer.now[TURN])
            bx, by = c * ox + s * oy, c * oy - s * ox
    ring_o = lowered_ring(profiles.ring_profiles[1], 1.0, still, bx, by)
    c, s = cosine_and_sine(load(bodies.turn, group))
    own = lowered_rollers(profiles.roller_profiles[0], group, still, -(c * ix + s * iy), s * ix - c * iy)
    own_o = lowered_rollers(profiles.roller_profiles[1], group, still, c * ox + s * oy, c * oy - s * ox)
    return (ring, own), (ring_o, own_o)


@part
def keep_edges(step, row, group, met, approach):
    """Approaches of eight contacts, m, less what they sink; compliances of edges are kept."""
    forces, columns, (ring, own) = step.forces, step.bodies.columns, met[0][row]
    at = row * columns + group
    if step.contacts.tilted is None:
        store(forces.soft, at, ring[2] + own[2])
    else:
        sunken = forces.tilted.sunken
        store(forces.tilted.edges, 2 * NOW * columns + at, ring[2] + own[2])
        if sunken is not None:
            of_ring, of_roller = met[1][row]
            store(sunken, 2 * SUNK * columns + at, -of_ring[0] - of_roller[0])
            store(sunken, 2 * PART_EDGES * columns + at, of_ring[2] + of_roller[2])
    return approach + ring[0] + own[0]


@part
def keep_slopes(step, row, group, met, Q):
    """Slopes of approaches along surfaces, m/rad, with those of all by which energies fall over the forces, N."""
    contacts, forces, columns, (ring, own) = step.contacts, step.forces, step.bodies.columns, met[0][row]
    at, to, soft = row * columns + group, 2 * row * columns + group, 0.5 * Q
    if contacts.tilted is not None:
        soft = load(forces.tilted.edges, 2 * FALL * columns + at)
    elif contacts.coupling is not None:  # by the forces of the kick: see `push_along`
        soft = splat(0.0)
        store_pair(forces.softening, to, columns, ring[3] + own[3], own[3])
    turning = own[1] - soft * own[3]
    both = ring[1] - soft * ring[3] + turning
    if contacts.tilted is not None:
        sunken = forces.tilted.sunken
        if sunken is not None:
            of_ring, of_roller = met[1][row]
            share = load(sunken, 2 * (SUNK + FALL) * columns + at)
            soft = load(sunken, 2 * (PART_EDGES + FALL) * columns + at)
            more = share * of_roller[1] - soft * of_roller[3]
            both += share * of_ring[1] - soft * of_ring[3] + more
            turning += more
    store_pair(forces.slope, to, columns, both, turning)


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
    away, out = _distances(bodies, forces, group)
    both, own = _along(step, INNER, group, P[0], Q[0])
    both_o, own_o = _along(step, OUTER, group, P[1], Q[1])
    drive.sums[1] -= speed_of(drive) * drive.dt * total(both - own)
    if drive.history is not None:
        if drive.history.outer is not None:
            drive.sums[1] -= drive.history.outer.now[SPEED] * drive.dt * total(both_o - own_o)
    take_moment(bodies.prescribed, drive, own + own_o)
    store(bodies.spin, group, load(bodies.spin, group) + (own + own_o) * (drive.dt / bodies.inertia))
    return -both / away, -both_o / out


@part
def _along(step, row, group, P, Q):
    """Moments, N m, of eight contacts' slopes: of ring and roller, and the roller's share."""
    columns, half = step.bodies.columns, 0.5 * Q * Q
    at = 2 * row * columns + group
    both, own = load_pair(step.forces.slope, at, columns)
    soft_both, soft_own = load_pair(step.forces.softening, at, columns)
    return P * both - half * soft_both, P * own - half * soft_own


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
