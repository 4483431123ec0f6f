"""Isolated contacts of rigid bodies, each with a law of its own.

The approach of a contact is the overlap of its circles and the deviation of its surfaces. Edges are compliances in
series with the law. Steps, bodies and what stands around them are the reduced model's.
"""

from typing import NamedTuple

from fem.kernels.drive import outer_of, turn_at
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import exponential, logarithm, maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, select, splat, square_root, total
from fem.kernels.law import damping_coefficient, kick_by_energy, next_force, stored_energy
from fem.kernels.reduced_contacts import met_surfaces, store_pair
from fem.kernels.reduced_housing import ring_place
from fem.kernels.reduced_kick import cut_off, forces_ahead, no_less, note_ahead, repay
from fem.kernels.reduced_surfaces import push_along

MOST_STEPS, SETTLED = 60, 1e-10  # of Newton's method, and of a depth: what is left is of its square


class PowerConstants(NamedTuple):
    """Q = K δⁿ."""

    stiffness: float  # K, N/mⁿ
    exponent: float  # n


class Isolated(NamedTuple):
    """Compliance of isolated contacts by their own laws: `PowerConstants`, or `state.Law` for δ = A Q (B − ½ ln Q)."""

    inner: tuple
    outer: tuple
    reach: float  # m, distance of centres at which a roller touches the inner ring
    track: float  # m, and the outer ring
    ring_profiles: tuple  # of the inner and the outer raceway, see `surfaces`; None: a perfect circle
    roller_profiles: tuple  # of the rollers in their contacts with them


@verb
def law_force(law, depth, soft, last):
    """Forces of eight contacts, N, and their stiffness, N/m, 0 of open ones.

    Parameters
    ----------
    depth : m; soft : m/N, compliance of edges in series, or None; last : force, depth and compliance of the last step
    """
    Q_before, before, soft_before = last
    B, B_before = _level(law, soft), _level(law, soft_before)
    Q = next_force(depth, law.A, B, law.Q_line, Q_before, before, B_before)
    closed = Q > 0.0
    give = select(closed, depth - 0.5 * law.A * minimum(Q, law.Q_line), 1.0)  # Q dδ/dQ
    return Q, select(closed, Q / give, 0.0)


@part
def _level(law, soft):
    if soft is None:
        return splat(law.B)
    return law.B + soft * (1.0 / law.A)


@law_force.of(PowerConstants)
def _power_force(law, depth, soft, last):
    closed = depth > 0.0
    own = select(closed, depth, 1.0)
    if soft is not None:
        yielding = select(closed, soft, 0.0)
        if any_lane(yielding != 0.0):
            own = _less_yielding(law, own, yielding)
    Q = select(closed, _power(law, own), depth - depth)  # what is not a number stays so
    stiffness = law.exponent * Q / own
    if soft is not None:
        stiffness = stiffness / (1.0 + soft * stiffness)
    return Q, stiffness


@part
def _power(law, depth):
    return law.stiffness * exponential(law.exponent * logarithm(depth))


@part
def _less_yielding(law, depth, soft):
    """Depths of eight closed contacts, m, less what a compliance in series takes of them: Newton's method."""
    own = depth
    for _ in range(MOST_STEPS):
        force = _power(law, own)
        step = (own + soft * force - depth) / (1.0 + soft * law.exponent * force / own)
        own = maximum(own - step, 0.1 * own)
        if not any_lane(absolute(step) > SETTLED * own):
            break
    return own


@verb
def law_energy(law, Q, depth, soft):
    """Energy of eight contacts under forces, N, that their depths, m, go with, J: ∫ Q dδ."""
    return stored_energy(Q, depth, law.A, law.Q_line)


@law_energy.of(PowerConstants)
def _power_energy(law, Q, depth, soft):
    if soft is None:
        return Q * depth * (1.0 / (law.exponent + 1.0))
    return Q * (depth - soft * Q) * (1.0 / (law.exponent + 1.0)) + 0.5 * soft * Q * Q


@part
def find_isolated(compliance, bodies, forces, drive, time, inside):
    """Forces of all contacts; their sums on hub and outer ring, N."""
    columns, n = bodies.columns, bodies.n
    ring_x, ring_y = ring_place(bodies.housing)
    turn = turn_at(drive.history, drive, time)
    on_hub_x, on_hub_y, on_ring_x, on_ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        x, y = load(bodies.centre, group), load(bodies.centre, at)
        out, ox, oy = direction(x - ring_x, y - ring_y, there)
        away, ix, iy = direction(x - bodies.hub[0], y - bodies.hub[1], there)
        store_pair(forces.normal, group, columns, ix, iy)
        store_pair(forces.normal, 2 * columns + group, columns, ox, oy)
        depth_i, depth_o = compliance.reach - away, out - compliance.track
        outer = outer_of(drive.history)
        if drive.looks:
            met = met_surfaces(forces.slope, bodies, compliance, forces, group, turn, outer)
        else:
            met = met_surfaces(None, bodies, compliance, forces, group, turn, outer)
        ring, own, ring_o, own_o = met
        depth_i, depth_o = depth_i + ring[0] + own[0], depth_o + ring_o[0] + own_o[0]
        depth_i, depth_o = select(there, depth_i, -1.0), select(there, depth_o, -1.0)
        Q_i, stiff_i = _force(forces.bracket, compliance.inner, forces, group, depth_i, ring[2] + own[2])
        Q_o, stiff_o = _force(forces.bracket, compliance.outer, forces, at, depth_o, ring_o[2] + own_o[2])
        store_pair(forces.first, group, columns, depth_i, depth_o)
        store_pair(forces.estimate, group, columns, Q_i, Q_o)
        store_pair(forces.stiffness, group, columns, stiff_i, stiff_o)
        if drive.looks:
            _keep_slopes(forces.slope, met, forces, group, columns, Q_i, Q_o)
        on_hub_x -= Q_i * ix
        on_hub_y -= Q_i * iy
        on_ring_x += Q_o * ox
        on_ring_y += Q_o * oy
    return total(on_hub_x), total(on_hub_y), total(on_ring_x), total(on_ring_y)


@part
def direction(x, y, there):
    """Lengths and unit vectors of eight ways; of spare lanes numbers."""
    length = square_root(select(there, x * x + y * y, 1.0))
    over = 1.0 / length
    return length, select(there, x * over, 1.0), select(there, y * over, 0.0)


@part
def _force(brackets, law, forces, at, depth, soft):
    """`law_force`, beginning with forces of the last step before they were taken ahead."""
    Q, before = load(forces.estimate, at), load(forces.first, at)
    if brackets is None:
        return law_force(law, depth, None, (Q, before, None))
    return law_force(law, depth, soft, (Q, before, load(brackets, at)))


@part
def _keep_slopes(slope, met, forces, group, columns, Q_i, Q_o):
    """Keep the compliances of edges, and the slopes of approaches under these forces, N."""
    if slope is not None:
        ring, own, ring_o, own_o = met
        store_pair(forces.bracket_now, group, columns, ring[2] + own[2], ring_o[2] + own_o[2])
        half, half_o = 0.5 * Q_i, 0.5 * Q_o
        turning, turning_o = own[1] - half * own[3], own_o[1] - half_o * own_o[3]
        store_pair(slope, group, columns, ring[1] - half * ring[3] + turning, turning)
        store_pair(slope, 2 * columns + group, columns, ring_o[1] - half_o * ring_o[3] + turning_o, turning_o)


@part
def kick_isolated(compliance, bodies, forces, drive, before):
    """Give the rollers their kick by forces a little ahead; what contacts give hub and outer ring, N: `kick`."""
    columns, n, dt, over = bodies.columns, bodies.n, drive.dt, drive.dt / bodies.mass
    hub_x, hub_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        ix, iy = load(forces.normal, group), load(forces.normal, at)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, at)
        ahead_i, ahead_o = forces_ahead(bodies, forces, drive, before, group, Q_i, Q_o)
        Q_i += no_less(Q_i, load(forces.stiffness, group) * ahead_i)
        Q_o += no_less(Q_o, load(forces.stiffness, at) * ahead_o)
        P_i = _kicked(compliance.inner, forces, group, ahead_i, Q_i, there)
        P_o = _kicked(compliance.outer, forces, at, ahead_o, Q_o, there)
        along_i, along_o = push_along(forces.slope, bodies, forces, drive, group, (P_i, P_o), (Q_i, Q_o))
        fx, fy = P_i * ix - along_i * iy, P_i * iy + along_i * ix
        gx, gy = P_o * ox + along_o * oy, P_o * oy - along_o * ox
        hub_x -= fx
        hub_y -= fy
        ring_x += gx
        ring_y += gy
        store(bodies.velocity, group, load(bodies.velocity, group) + over * (fx - gx))
        store(bodies.velocity, at, load(bodies.velocity, at) + over * (fy - gy) - drive.gravity * dt)
        store_pair(forces.force, group, columns, Q_i, Q_o)
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def _kicked(law, forces, at, ahead, Q, there):
    """What a kick gives of eight contacts' forces, N, whose approach is so far ahead, m: see `law.kick_by_energy`."""
    free = load(forces.first, at) + ahead
    approach = select(Q > 0.0, maximum(free, 1e-30), select(free > 0.0, 0.0, free))
    before, Q_before = load(forces.approach, at), load(forces.force, at)
    work, eased = _stored_more(forces.bracket, law, forces, at, Q, approach)
    last = load(forces.kick, at), load(forces.residual, at)
    P, residual = kick_by_energy(before, Q_before, last[0], last[1], approach, Q, work, eased)
    P = select(there, P, 0.0)
    residual = residual + cut_off(forces.cut, forces, at, free - approach, P)
    P, residual = repay(forces, at, approach, P, residual, splat(0.0), ahead)
    store(forces.approach, at, approach)
    store(forces.kick, at, P)
    store(forces.residual, at, residual)
    note_ahead(forces.ahead, forces, at, ahead, P)
    return P


@part
def _stored_more(brackets, law, forces, at, Q, approach):
    """What eight contacts have stored since the last kick, J, and less than with edges' compliances of then."""
    before, Q_before = load(forces.approach, at), load(forces.force, at)
    if brackets is None:
        return law_energy(law, Q, approach, None) - law_energy(law, Q_before, before, None), splat(0.0)
    soft, soft_before = load(forces.bracket_now, at), load(brackets, at)
    store(brackets, at, soft)
    work = law_energy(law, Q, approach, soft) - law_energy(law, Q_before, before, soft_before)
    return work, 0.25 * (Q * Q + Q_before * Q_before) * (soft - soft_before)


@part
def isolated_energy(compliance, forces, columns, group):
    """Energy of eight rollers' contacts, J."""
    inner = _energy(compliance.inner, forces, group, forces.bracket)
    return inner + _energy(compliance.outer, forces, columns + group, forces.bracket)


@part
def _energy(law, forces, at, brackets):
    Q, approach = load(forces.force, at), load(forces.approach, at)
    if brackets is None:
        return select(Q > 0.0, law_energy(law, Q, approach, None), 0.0)
    return select(Q > 0.0, law_energy(law, Q, approach, load(brackets, at)), 0.0)


@part
def isolated_damping(compliance, dampers, forces, columns, group, there):
    """N s/m, of eight rollers' inner and outer contacts; 0 of open ones."""
    Q_i, Q_o = load(forces.force, group), load(forces.force, columns + group)
    c_i = damping_coefficient(dampers.law, Q_i, load(forces.stiffness, group))
    c_o = damping_coefficient(dampers.law, Q_o, load(forces.stiffness, columns + group))
    return select(there & (Q_i > 0.0), c_i, 0.0), select(there & (Q_o > 0.0), c_o, 0.0)
