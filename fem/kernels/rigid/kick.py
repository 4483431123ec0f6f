"""What contacts give hub and rollers in a step: a leapfrog kick by CONTACT FORCES and FRICTION a little ahead."""

import numpy as np

from fem.kernels.columns import INNER, OUTER
from fem.kernels.drive import GAIN, SPEED
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair, maximum, minimum, store_pair
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, load, select, splat, store, total
from fem.kernels.law import kick_by_energy, released
from fem.kernels.mounts import TWELFTH
from fem.kernels.rigid.contacts import along_rings, both_forces, law_energy, met_of, move, take_more, wrap
from fem.kernels.rigid.friction import press_neighbours, tractions
from fem.kernels.rigid.rays import along_ray
from fem.kernels.rigid.state import CROSS, MOMENT, SLOPE, normals
from fem.kernels.rigid.strikes import note_strikes
from fem.kernels.rigid.surfaces import push_along
from fem.kernels.tilted_contact import SHORTEST, fallen, kick_by_work, own_approach
from fem.kernels.tilts import kick_axes, kick_hub_axis, note_furthest


@part
def kick_contacts(step):
    """Give the rollers their kick; what contacts give the hub and the outer ring, N, x and y.

    Forces are those at positions dt²/12 times the acceleration ahead, which makes leapfrog's phase error one of fourth
    order: at a tenth of a vibration's period per step 0.01 % instead of 1.6 %.

    Source: Numerov's method; Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), chapter III.
    """
    bodies, contacts, forces, drive = step.bodies, step.contacts, step.forces, step.drive
    coupling, tilted, tilts, columns, n = contacts.coupling, contacts.tilted, bodies.tilts, bodies.columns, bodies.n
    halo, dt, over = forces.halo, drive.dt, drive.dt / bodies.mass
    hub_x, hub_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    on_x, on_y = splat(0.0), splat(0.0)
    if coupling is not None:
        press_neighbours(step)
        if forces.ahead is not None:
            _tell_neighbours(step)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        ix, iy, ox, oy = normals(forces, group, columns)
        further_i, further_o = _further(step, group)
        ahead_i, ahead_o, turned = further_i, further_o, (None, None)
        if tilts is not None:
            share, pushed = TWELFTH * dt * dt, load(tilts.pushed, group)
            turn_i = pushed * (ix * ox + iy * oy) - (tilts.slope_pushed[0] * ix + tilts.slope_pushed[1] * iy)
            turned = share * turn_i, -share * pushed
        if coupling is not None:
            if forces.ahead is not None:  # less what `_tell_neighbours` has said that neighbours take
                along_i, along_o = along_rings(coupling, forces, forces.gained, group)
                take_more(forces.taken, columns, group, along_i, along_o)
                ahead_i, ahead_o = ahead_i - along_i, ahead_o - along_o
        more_i, more_o = _gains(contacts, forces, columns, group, (ahead_i, ahead_o), turned)
        if coupling is not None:
            less_i, less_o = coupling.across * more_o, coupling.across * more_i
            take_more(forces.taken, columns, group, less_i, less_o)
            ahead_i, ahead_o = ahead_i - less_i, ahead_o - less_o
        if tilted is None:
            Q_i, Q_o = load_pair(forces.estimate, group, columns)
            Q_i, Q_o = Q_i + more_i, Q_o + more_o
            P_i = _kicked(step, contacts.inner, group, ahead_i, further_i, Q_i, there)
            P_o = _kicked(step, contacts.outer, at, ahead_o, further_o, Q_o, there)
        else:
            move(forces, columns, group, ahead_i, turned[0])
            move(forces, columns, at, ahead_o, turned[1])
            P_i, M_i = _kicked_by_table(step, tilted.tables[0], INNER, group, further_i, there)
            P_o, M_o = _kicked_by_table(step, tilted.tables[1], OUTER, at, further_o, there)
            Q_i, Q_o = load_pair(forces.estimate, group, columns)
        _grow(drive, P_i, P_o)
        T_i, T_o = splat(0.0), splat(0.0)
        if coupling is not None:
            if drive.friction > 0.0:
                T_i, T_o = tractions(step, group, Q_i, Q_o)
                pulled_i, pulled_o = select(there, T_i, 0.0), select(there, T_o, 0.0)
                store_pair(forces.pulled, halo + group, forces.pulled.shape[1], pulled_i, pulled_o)
                _shift(forces, drive, columns, group, Q_i)
                _shift(forces, drive, columns, at, Q_o)
            store(bodies.spin, group, load(bodies.spin, group) + (T_o - T_i) * (dt * bodies.radius / bodies.inertia))
        along_i, along_o = push_along(step, group, (P_i, P_o), (Q_i, Q_o))
        T_i, T_o = T_i + along_i, T_o + along_o
        if coupling is not None:
            tilt_i, tilt_o = load_pair(forces.tilt, group, columns)
            T_i, T_o = T_i - P_i * tilt_i, T_o - P_o * tilt_o
        if tilts is not None:  # where slopes have a part across the normal, moments push aside
            tilt, facing, beside = load(tilts.tilt, group), ix * ox + iy * oy, oy * ix - ox * iy
            kick_axes(tilts, drive, group, M_i * facing - M_o)
            aside = tilt * beside - (tilts.slope[1] * ix - tilts.slope[0] * iy)
            T_i += M_i * aside * splat(1.0 / contacts.reach)
            T_o -= M_i * tilt * beside * splat(1.0 / contacts.track)
            on_x, on_y = on_x - M_i * ix, on_y - M_i * iy
        fx, fy = P_i * ix - T_i * iy, P_i * iy + T_i * ix
        gx, gy = P_o * ox + T_o * oy, P_o * oy - T_o * ox
        hub_x, hub_y = hub_x - select(there, fx, 0.0), hub_y - select(there, fy, 0.0)
        ring_x, ring_y = ring_x + select(there, gx, 0.0), ring_y + select(there, gy, 0.0)
        vx, vy = load_pair(bodies.velocity, group, columns)
        store_pair(bodies.velocity, group, columns, vx + over * (fx - gx), vy + over * (fy - gy) - drive.gravity * dt)
        if coupling is not None:  # guess the next step's forces and moments, in a straight line from the last two
            last_i, last_o = load_pair(forces.force, group, columns)
            changed = maximum(absolute(Q_i - last_i), absolute(Q_o - last_o))
            store(forces.fastest, 0, maximum(load(forces.fastest, 0), changed))
            on_i, on_o = (Q_i > 0.0) & (last_i > 0.0), (Q_o > 0.0) & (last_o > 0.0)
            next_i = select(on_i, maximum(2.0 * Q_i - last_i, 0.0), Q_i)
            next_o = select(on_o, maximum(2.0 * Q_o - last_o, 0.0), Q_o)
            store_pair(forces.guess, halo + group, forces.guess.shape[1], next_i, next_o)
            if tilted is not None:
                before_i, before_o = load_pair(forces.tilted.moment, group, columns)
                next_i, next_o = select(on_i, 2.0 * M_i - before_i, M_i), select(on_o, 2.0 * M_o - before_o, M_o)
                store_pair(forces.tilted.guess, halo + group, forces.tilted.guess.shape[1], next_i, next_o)
        store_pair(forces.force, group, columns, Q_i, Q_o)
        if tilted is not None:
            store_pair(forces.tilted.moment, group, columns, M_i, M_o)
    if tilts is not None:
        kick_hub_axis(tilts, drive, (total(on_x), total(on_y)))
    if coupling is not None:
        for row in range(2):
            wrap(forces.guess, row, n, halo)
            if tilted is not None:
                wrap(forces.tilted.guess, row, n, halo)
            if drive.friction > 0.0:
                wrap(forces.pulled, row, n, halo)
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def _grow(drive, P_i, P_o):
    """The work of bodies that grow against eight rollers' forces, N, as the shaft speeds up."""
    history = drive.history
    if history is not None:
        more = 2.0 * history.now[SPEED] * history.now[GAIN] * drive.dt
        drive.sums[1] += more * total(history.growth * P_i + history.roller_growth * P_o)
        outer = history.outer
        if outer is not None:  # which changes that: see `contacts.touching`
            ratio = outer.radius / drive.inner_radius
            now, gain = history.now[SPEED] - ratio * outer.now[SPEED], history.now[GAIN] - ratio * outer.now[GAIN]
            spun = history.roller_growth * (now * gain - history.now[SPEED] * history.now[GAIN])
            grown = outer.growth * outer.now[SPEED] * outer.now[GAIN]
            drive.sums[1] += 2.0 * drive.dt * total(spun * P_i + (spun - grown) * P_o)


@part
def _shift(forces, drive, columns, at, Q):
    """Less dissipation, J, by how eight contacts' forces, N, shift the raceways under all tractions along their ring.

    By Betti that is how far tractions push raceways back, times what forces have changed.
    """
    now, last = load_pair(forces.lifted, at, 2 * columns)
    store(forces.lifted, 2 * columns + at, now)
    drive.sums[2] -= 0.5 * total((now + last) * (Q - load(forces.force, at)))


@part
def _further(step, group):
    """How much further eight rollers' contacts have approached where forces are taken, m, inner and outer."""
    bodies, forces, drive, before = step.bodies, step.forces, step.drive, step.before
    columns, share = bodies.columns, TWELFTH * drive.dt * drive.dt
    there = count_from(group) < bodies.n
    ix, iy, ox, oy = normals(forces, group, columns)
    Q_i, Q_o = load_pair(forces.estimate, group, columns)
    hub, ring = before.hub_acceleration, (0.0, 0.0)
    if bodies.housing is not None:
        ring = before.ring_acceleration[0], before.ring_acceleration[1]
    ax = (Q_i * ix - Q_o * ox) * (1.0 / bodies.mass)
    ay = (Q_i * iy - Q_o * oy) * (1.0 / bodies.mass) - drive.gravity
    ax, ay = along_ray(bodies.prescribed, ox, oy, ax, ay)
    store_pair(before.acceleration, group, columns, select(there, ax, 0.0), select(there, ay, 0.0))
    return share * (ix * (hub[0] - ax) + iy * (hub[1] - ay)), share * (ox * (ax - ring[0]) + oy * (ay - ring[1]))


@part
def _gains(contacts, forces, columns, group, further, turned):
    """What eight rollers' forces, N, gain by further approaches, m, and misalignments, rad, or None.

    Each with the other's change; open contacts nothing, others no less than what they have.
    """
    stiff_i, stiff_o = load_pair(forces.stiffness, group, columns)
    more_i, more_o = stiff_i * further[0], stiff_o * further[1]
    if contacts.tilted is not None:
        cross_i, cross_o = met_of(forces, CROSS, columns, group)
        more_i, more_o = more_i + cross_i * turned[0], more_o + cross_o * turned[1]
    if contacts.coupling is not None:
        across = contacts.coupling.across
        more_i, more_o = both_forces(more_i, more_o, stiff_i * across, stiff_o * across, 0.0, 0.0)
    Q_i, Q_o = load_pair(forces.estimate, group, columns)
    return select(Q_i > 0.0, maximum(more_i, -Q_i), 0.0), select(Q_o > 0.0, maximum(more_o, -Q_o), 0.0)


@part
def _tell_neighbours(step):
    """Leave in `gained` what all forces are to gain beyond those that approaches know of, their steps ahead included.

    Without that, contacts that open or close take other energy from their neighbours than what the rings store.
    """
    bodies, contacts, forces = step.bodies, step.contacts, step.forces
    columns, n, halo, width = bodies.columns, bodies.n, forces.halo, forces.gained.shape[1]
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, halo + group
        more_i, more_o = _gains(contacts, forces, columns, group, _further(step, group), (None, None))
        Q_i, Q_o = load_pair(forces.estimate, group, columns)
        guess_i, guess_o = load_pair(forces.guess, at, width)
        known_i, known_o = load_pair(forces.gained, at, width)
        more_i, more_o = Q_i + more_i - (guess_i + known_i), Q_o + more_o - (guess_o + known_o)
        store_pair(forces.gained, at, width, select(there, more_i, 0.0), select(there, more_o, 0.0))
    wrap(forces.gained, INNER, n, halo)
    wrap(forces.gained, OUTER, n, halo)


@part
def _kicked(step, law, at, ahead, further, Q, there):
    """What a kick gives of eight contacts' forces, N, whose approach is so far ahead, m: see `law.kick_by_energy`.

    `further` : m, how much the forces' bodies are there
    """
    forces = step.forces
    free = load(forces.first, at) + ahead
    approach = select(Q > 0.0, maximum(free, 1e-30), select(free > 0.0, 0.0, free))
    before, Q_before, P_before = load(forces.approach, at), load(forces.force, at), load(forces.kick, at)
    residual, grown = load(forces.residual, at), splat(0.0)
    if forces.radiation is not None:
        note_strikes(forces.radiation, before, approach, at, there, step.drive.dt)
    soft, soft_before, eased = None, None, splat(0.0)
    if forces.soft is not None:
        soft, soft_before = load(forces.soft, at), load(forces.soft_before, at)
        store(forces.soft_before, at, soft)
        eased = 0.25 * (Q * Q + Q_before * Q_before) * (soft - soft_before)
    work = law_energy(law, Q, approach, soft) - law_energy(law, Q_before, before, soft_before)
    P, residual = kick_by_energy(before, Q_before, P_before, residual, approach, Q, work, eased)
    P = select(there, P, 0.0)
    if forces.taken is not None:  # no further off than the larger force of the step behind
        # a guess can be so far off that approach and force of a contact that opens don't fit; and what energy between
        # contacts has grown by is more than kicks have taken for it: forces at both ends of a step take it exactly,
        # kicks only where the contact neither opens nor closes
        (taken, last), most = load_pair(forces.taken, at, forces.taken.size // 2), maximum(Q, Q_before)
        given, grown = maximum(minimum(P, Q + most), Q - most), taken - last
        store(forces.taken, forces.taken.size // 2 + at, taken)
        imbalance = 0.5 * (approach - before) * (P - given) + 0.5 * grown * (Q - given + Q_before - P_before)
        P, residual = given, residual + select(before != before, 0.0, imbalance)
    if forces.cut is not None:  # bodies move by what approaches were cut by to fit their forces too
        off, cut = free - approach, load(forces.cut, at)
        residual = residual + 0.5 * (P + P_before) * (cut - off)
        store(forces.cut, at, off)
    if any_lane((Q <= 0.0) & (Q_before > 0.0)):
        P, residual = released(Q_before, Q, P, residual, (approach - before + grown, further), SHORTEST)
    store(forces.approach, at, select(there, approach, np.nan))
    store(forces.kick, at, P)
    if forces.ahead is not None:
        # A kick works along what bodies move, not along how far its force is taken ahead. The energy of a step,
        # dt²/24 Σ (m a − 2f)·a, makes up for it with the forces that a is of: what kicks give beyond these, as contacts
        # open and close, is left. It is of fourth order in dt, and adds up where rollers rattle.
        apart = forces.ahead.size // 2
        ahead_before, beyond_before = load_pair(forces.ahead, at, apart)
        beyond, onward = P - load(forces.estimate, at), further - ahead_before
        residual = residual + select(onward != onward, 0.0, 0.5 * (beyond + beyond_before) * onward)
        store_pair(forces.ahead, at, apart, further, beyond)
    store(forces.residual, at, residual)
    return P


@part
def _kicked_by_table(step, table, row, at, ahead, there):
    """What a kick gives of eight contacts' forces, N, and their moments, N m: energy by forces and by moments.

    The force makes the work of both the change of the table's energy; the moments' work is that of leapfrog.
    """
    forces, own, columns, apart = step.forces, step.forces.tilted, step.bodies.columns, 2 * step.bodies.columns
    Q, approach = load(forces.estimate, at), load(forces.first, at)
    M, (slope, energy) = load(own.met, MOMENT * apart + at), load_pair(own.met, SLOPE * apart + at, apart)
    most = Q * step.contacts.tilted.length  # slices lie no further out than half of that, which tables overshoot
    M = select(there, maximum(minimum(M, most), -most), 0.0)
    residual = load(forces.residual, at)
    before, Q_before, P_before = load(forces.approach, at), load(forces.force, at), load(forces.kick, at)
    way, given = fallen(own, at, columns, Q - Q_before)
    moved, known = approach - before - way, before == before
    work = given + energy - load(own.energy, at) + 0.5 * (M + load(own.moment, at)) * (slope - load(own.slope, at))
    taken, last = load_pair(forces.taken, at, apart)
    P = select(there, kick_by_work(Q, Q_before, P_before, residual, approach, moved, work), 0.0)
    grown = taken - last  # forces at both ends take what is stored between contacts
    left = work - 0.5 * moved * (P_before + P) + 0.5 * grown * (Q - P + Q_before - P_before)
    residual = select(known & there, residual + left, residual)
    P, residual = released(Q_before, Q, P, residual, (moved + grown, ahead), SHORTEST)
    store(forces.taken, apart + at, taken)
    store(own.energy, at, energy)
    store(own.slope, at, slope)
    store(forces.approach, at, select(there, approach, np.nan))
    store(forces.kick, at, P)
    store(forces.residual, at, residual)
    deepest = own_approach(own.edges, at, approach, Q)
    reached = there & (deepest > table.first_approach)
    note_furthest(step.bodies.tilts, row, select(reached, deepest, 0.0), select(reached, absolute(slope), 0.0))
    return P, M
