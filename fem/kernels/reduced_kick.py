"""What the reduced model's contacts give hub and rollers in a step: a leapfrog kick by forces a little ahead."""

import numpy as np

from fem.kernels.drive import GAIN, SPEED
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, select, splat, total
from fem.kernels.law import kick_force
from fem.kernels.prescribed_rollers import along_ray
from fem.kernels.reduced_contacts import both_forces, coupled_approach, level, store_pair, take_more, wrap
from fem.kernels.reduced_friction import tractions
from fem.kernels.reduced_housing import ring_acceleration
from fem.kernels.reduced_radiation import note_strikes
from fem.kernels.reduced_state import INNER, OUTER
from fem.kernels.reduced_surfaces import push_along
from fem.kernels.rigid_parts import TWELFTH
from fem.kernels.state import LoadHistory


@verb
def grow(history, drive, P_i, P_o):
    """The work of bodies that grow against eight rollers' forces, N, as the shaft speeds up."""


@grow.of(LoadHistory)
def _grow_now(history, drive, P_i, P_o):
    more = 2.0 * history.now[SPEED] * history.now[GAIN] * drive.dt
    drive.sums[1] += more * total(history.growth * P_i + history.roller_growth * P_o)
    outer = history.outer
    if outer is not None:  # which changes that: see `reduced_contacts.touching`
        ratio = outer.radius / drive.inner_radius
        now, gain = history.now[SPEED] - ratio * outer.now[SPEED], history.now[GAIN] - ratio * outer.now[GAIN]
        spun = history.roller_growth * (now * gain - history.now[SPEED] * history.now[GAIN])
        grown = outer.growth * outer.now[SPEED] * outer.now[GAIN]
        drive.sums[1] += 2.0 * drive.dt * total(spun * P_i + (spun - grown) * P_o)


@part
def kick(bodies, compliance, forces, drive, before):
    """Give the rollers their kick; what contacts give the hub and the outer ring, N, x and y.

    Forces are those at positions dt²/12 times the acceleration ahead, which makes leapfrog's phase error one of fourth
    order: at a tenth of a vibration's period per step 0.01 % instead of 1.6 %.

    Source: Numerov's method; Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), chapter III.
    """
    columns, n, halo, dt = bodies.columns, bodies.n, forces.halo, drive.dt
    width, over, across = columns + 2 * halo, dt / bodies.mass, compliance.across
    hub_x, hub_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    _tell_neighbours(forces.ahead, bodies, compliance, forces, drive, before)
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, columns + group)
        further_i, further_o = forces_ahead(bodies, forces, drive, before, group, Q_i, Q_o)
        # Changes of eight rollers' approaches, m, less what `_tell_neighbours` has said that neighbours take.
        if forces.ahead is None:
            ahead_i, ahead_o = further_i, further_o
        else:
            felt_i = coupled_approach(compliance, forces, forces.gained, INNER, group)
            felt_o = coupled_approach(compliance, forces, forces.gained, OUTER, group)
            take_more(forces.taken, columns, group, felt_i, felt_o)
            ahead_i, ahead_o = further_i - felt_i, further_o - felt_o
        stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
        more_i, more_o = both_forces(stiff_i * ahead_i, stiff_o * ahead_o, stiff_i * across, stiff_o * across, 0.0, 0.0)
        more_i, more_o = no_less(Q_i, more_i), no_less(Q_o, more_o)
        Q_i, Q_o = Q_i + more_i, Q_o + more_o
        take_more(forces.taken, columns, group, across * more_o, across * more_i)
        P_i = _kicked(compliance.inner, forces, dt, group, ahead_i - across * more_o, further_i, Q_i, there)
        at = columns + group
        P_o = _kicked(compliance.outer, forces, dt, at, ahead_o - across * more_i, further_o, Q_o, there)
        note_ahead(forces.ahead, forces, group, further_i, P_i)
        note_ahead(forces.ahead, forces, columns + group, further_o, P_o)
        if forces.bracket is not None:
            store(forces.bracket, group, load(forces.bracket_now, group))
            store(forces.bracket, columns + group, load(forces.bracket_now, columns + group))
        grow(drive.history, drive, P_i, P_o)
        T_i, T_o = splat(0.0), splat(0.0)
        if drive.friction > 0.0:
            T_i, T_o = tractions(bodies, compliance, forces, drive, before, group, Q_i, Q_o)
            store_pair(forces.pulled, halo + group, width, select(there, T_i, 0.0), select(there, T_o, 0.0))
            shift(forces, drive, INNER, group, Q_i)
            shift(forces, drive, OUTER, group, Q_o)
        store(bodies.spin, group, load(bodies.spin, group) + (T_o - T_i) * (dt * bodies.radius / bodies.inertia))
        along_i, along_o = push_along(forces.slope, bodies, forces, drive, group, (P_i, P_o), (Q_i, Q_o))
        T_i, T_o = T_i + along_i, T_o + along_o
        T_i, T_o = T_i - P_i * load(forces.tilt, group), T_o - P_o * load(forces.tilt, columns + group)
        fx, fy = P_i * ix - T_i * iy, P_i * iy + T_i * ix
        hub_x -= select(there, fx, 0.0)
        hub_y -= select(there, fy, 0.0)
        ring_x += select(there, P_o * ox + T_o * oy, 0.0)
        ring_y += select(there, P_o * oy - T_o * ox, 0.0)
        fx, fy = fx - P_o * ox - T_o * oy, fy - P_o * oy + T_o * ox
        store(bodies.velocity, group, load(bodies.velocity, group) + over * fx)
        store(bodies.velocity, at, load(bodies.velocity, at) + over * fy - drive.gravity * dt)
        expect(forces, halo + group, group, Q_i)
        expect(forces, width + halo + group, columns + group, Q_o)
    for row in range(2):
        wrap(forces.guess, row, n, halo)
        if drive.friction > 0.0:
            wrap(forces.pulled, row, n, halo)
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def shift(forces, drive, row, group, Q):
    """Less dissipation, J, by how eight contacts' forces, N, shift the raceways under all tractions along their ring.

    By Betti that is how far tractions push raceways back, times what forces have changed.
    """
    columns = forces.normal.shape[2]
    now, last = load(forces.lifted, row * columns + group), load(forces.lifted, (2 + row) * columns + group)
    store(forces.lifted, (2 + row) * columns + group, now)
    drive.sums[2] -= 0.5 * total((now + last) * (Q - load(forces.force, row * columns + group)))


@part
def no_less(Q, more):
    """What eight forces, N, >= 0, gain: open contacts nothing, others no less than what they have."""
    return select(Q > 0.0, maximum(more, -Q), 0.0)


@part
def forces_ahead(bodies, forces, drive, before, group, Q_i, Q_o):
    """How much further eight rollers' contacts, under these forces, N, have approached where forces are taken, m."""
    columns, share = bodies.columns, TWELFTH * drive.dt * drive.dt
    there = count_from(group) < bodies.n
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    hub_ax, hub_ay = before.hub_acceleration[0], before.hub_acceleration[1]
    ring_ax, ring_ay = ring_acceleration(bodies.housing, before)
    ax = (Q_i * ix - Q_o * ox) * (1.0 / bodies.mass)
    ay = (Q_i * iy - Q_o * oy) * (1.0 / bodies.mass) - drive.gravity
    ax, ay = along_ray(bodies.prescribed, ox, oy, ax, ay)
    store_pair(before.acceleration, group, columns, select(there, ax, 0.0), select(there, ay, 0.0))
    return share * (ix * (hub_ax - ax) + iy * (hub_ay - ay)), share * (ox * (ax - ring_ax) + oy * (ay - ring_ay))


@part
def _tell_neighbours(asked, bodies, compliance, forces, drive, before):
    """Leave in `gained` what all forces are to gain beyond those that approaches know of, their steps ahead included.

    Without that, contacts that open or close take other energy from their neighbours than what the rings store.
    """
    if asked is None:
        return
    columns, n, halo, across = bodies.columns, bodies.n, forces.halo, compliance.across
    width = columns + 2 * halo
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, halo + group
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, columns + group)
        ahead_i, ahead_o = forces_ahead(bodies, forces, drive, before, group, Q_i, Q_o)
        stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
        more_i, more_o = both_forces(stiff_i * ahead_i, stiff_o * ahead_o, stiff_i * across, stiff_o * across, 0.0, 0.0)
        known_i = load(forces.guess, at) + load(forces.gained, at)
        known_o = load(forces.guess, width + at) + load(forces.gained, width + at)
        more_i, more_o = Q_i + no_less(Q_i, more_i) - known_i, Q_o + no_less(Q_o, more_o) - known_o
        store_pair(forces.gained, at, width, select(there, more_i, 0.0), select(there, more_o, 0.0))
    wrap(forces.gained, INNER, n, halo)
    wrap(forces.gained, OUTER, n, halo)


@part
def _kicked(law, forces, dt, at, ahead, further, Q, there):
    """What a kick gives of eight contacts' forces, N, whose approach is so far ahead, m: see `law.kick_force`.

    `further` : m, how much the forces' bodies are there, for `repay`
    """
    approach = load(forces.first, at) + ahead
    free = approach
    approach = select(Q > 0.0, maximum(approach, 1e-30), select(approach > 0.0, 0.0, approach))
    note_strikes(forces.radiation, load(forces.approach, at), approach, at, there, dt)
    B_before, B = level(law, forces.bracket, at), level(law, forces.bracket_now, at)
    last = load(forces.approach, at), load(forces.force, at), B_before, load(forces.kick, at), load(forces.residual, at)
    P, residual = kick_force((law.A, law.Q_line), last, (approach, Q, B))
    P = select(there, P, 0.0)
    P, residual, grown = _bounded(forces, forces.taken, at, approach, P, Q, residual)
    residual = residual + cut_off(forces.cut, forces, at, free - approach, P)
    P, residual = repay(forces, at, approach, P, residual, grown, further)
    store(forces.approach, at, select(there, approach, np.nan))
    store(forces.kick, at, P)
    store(forces.residual, at, residual)
    return P


@part
def repay(forces, at, approach, P, residual, grown, further):
    """Kicks, N, of eight contacts, and their residual energies, J, released where they open.

    Half of a kick works in the step behind, in which bodies have moved by `grown`, m, more than the approach, half in
    the step ahead, which is longer by the acceleration: 12 times how much further forces are taken, m.
    """
    before = load(forces.approach, at)
    opens = (before > 0.0) & (approach <= 0.0)
    if not any_lane(opens):
        return P, residual
    behind = select(opens, approach - before + grown, -1.0)
    ahead = behind + further * (1.0 / TWELFTH)
    most = load(forces.force, at)
    more = (2.0 * residual - ahead * P) / minimum(ahead + behind, behind)
    more = select(opens, maximum(minimum(more, most), -most), 0.0)
    return P + more, residual - 0.5 * behind * more


@part
def cut_off(cut, forces, at, off, P):
    """Energy of eight contacts beyond kicks P, N, of approaches, m, that were cut to fit their forces, J.

    Bodies move by what is cut too, and the law does not see it.
    """
    if cut is None:
        return splat(0.0)
    imbalance = 0.5 * (P + load(forces.kick, at)) * (load(cut, at) - off)
    store(cut, at, off)
    return imbalance


@part
def note_ahead(before, forces, at, ahead, P):
    """Residual energy of eight contacts, J, by how far their forces are taken ahead, m, under kicks P, N.

    A kick works along what bodies move, not along that. The energy of a step, dt²/24 Σ (m a − 2f)·a, makes up for it
    with the forces that a is of: what kicks give beyond these, as contacts open and close, is left. It is of fourth
    order in dt, and adds up where rollers rattle.
    """
    if before is not None:
        last = at + before.size // 2
        beyond = P - load(forces.estimate, at)
        further = ahead - load(before, at)
        imbalance = select(further != further, 0.0, 0.5 * (beyond + load(before, last)) * further)
        store(forces.residual, at, load(forces.residual, at) + imbalance)
        store(before, at, ahead)
        store(before, last, beyond)


@part
def _bounded(forces, taken, at, approach, P, Q, residual):
    """A kick no further off than the larger force of the step behind; what contacts have stored beyond kicks, J.

    A guess can be so far off that approach and force of a contact that opens don't fit. And what
    energy between contacts has grown by is more than kicks have taken for it: forces Q at both ends of a step take it
    exactly, kicks P only where the contact neither opens nor closes.
    """
    if taken is None:
        return P, residual, splat(0.0)
    before, Q_before, last = load(forces.approach, at), load(forces.force, at), at + taken.size // 2
    most = maximum(Q, Q_before)
    given = maximum(minimum(P, Q + most), Q - most)
    grown = load(taken, at) - load(taken, last)
    store(taken, last, load(taken, at))
    imbalance = 0.5 * (approach - before) * (P - given) + 0.5 * grown * (Q - given + Q_before - load(forces.kick, at))
    return given, residual + select(before != before, 0.0, imbalance), grown


@part
def expect(forces, at, row, Q):
    """Guess the next step's forces, in a straight line from the last two; they become the last ones."""
    last = load(forces.force, row)
    store(forces.fastest, 0, maximum(load(forces.fastest, 0), absolute(Q - last)))
    store(forces.guess, at, select((Q > 0.0) & (last > 0.0), maximum(2.0 * Q - last, 0.0), Q))
    store(forces.force, row, Q)
