"""Contacts of rollers that tilt: tables of energy by approach and misalignment, coupled through elastic bodies.

A contact's own approach is the overlap of the circles less what other contacts' forces take, as in
`reduced_contacts`; its own misalignment is the bodies' plus the response to moments along its ring: a ring of the
compliance C under a force that is spread along the length L has 12 C/L² under a moment. Of a roller's other contact
its table knows. Forces, moments and energy a little ahead follow by Taylor's series of second order from one look at
the table, whose derivatives are exact. The force of a kick makes the work of forces and moments the change of the
table's energy (`law.kick_force`); the moments' work is that of leapfrog.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.drive import turn_at
from fem.kernels.isolated_contacts import direction, isolated_damping
from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, count_from, select, splat, total
from fem.kernels.law import released
from fem.kernels.prescribed_rollers import along_ray
from fem.kernels.reduced_contacts import (
    both_forces,
    coupled_approach,
    lift,
    raceway_tilt,
    store_pair,
    touching,
    wrap,
)
from fem.kernels.reduced_damping import damping_coefficients
from fem.kernels.reduced_friction import press_neighbours, tractions
from fem.kernels.reduced_housing import ring_acceleration, ring_place
from fem.kernels.reduced_kick import expect, grow, shift
from fem.kernels.reduced_state import INNER, OUTER, Compliance
from fem.kernels.reduced_surfaces import AGAIN, follow_angles, push_along
from fem.kernels.rigid_parts import TWELFTH
from fem.kernels.tilted_contact import SHORTEST, kick_by_work
from fem.kernels.tilted_surfaces import fallen, keep_slopes, own_approach, sunk, surfaces_met, table_at
from fem.kernels.tilts import kick_axes, kick_hub_axis, push_axes

# `Compliance` and what tilt takes; `between` is None where bodies are rigid
Tilted = NamedTuple(
    "Tilted",
    [
        *Compliance.__annotations__.items(),
        ("tables", tuple),  # `tilted_contact.TiltedLaw` of the inner and the outer contacts
        ("rests", tuple),  # `tilted_surfaces.SpalledRest` of both; None: spalls take no part of the length
        ("part", tuple),  # `tilted_surfaces.PartProfiles`; None: as above
        ("share", float),  # 12/L², 1/m²
        ("length", float),  # m, of a roller
    ],
)


SLOPE, ENERGY, MOMENT, CROSS = range(4)


@part
def _at(row, what, columns, group):
    """Of eight contacts in `TiltedForces.met`."""
    return (4 * row + what) * columns + group


@part
def find_tilted(compliance, bodies, forces, drive, time, inside):
    """Forces and moments of all contacts; sums of the forces on hub and outer ring, N."""
    if compliance.between is not None:
        if inside % AGAIN == 0:
            follow_angles(bodies, compliance, forces)
    columns, n, halo, tilts = bodies.columns, bodies.n, forces.halo, bodies.tilts
    width = columns + 2 * halo
    reach, track = touching(drive.history, compliance, drive)
    ring_x, ring_y = ring_place(bodies.housing)
    turn = turn_at(drive.history, drive, time)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, halo + group
        x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
        out, ox, oy = direction(x - ring_x, y - ring_y + compliance.sag[1], there)
        away, ix, iy = direction(x - bodies.hub[0], y - bodies.hub[1] + compliance.sag[0], there)
        store_pair(forces.normal, group, columns, ix, iy)
        store_pair(forces.normal, 2 * columns + group, columns, ox, oy)
        tilt = load(tilts.tilt, group)
        slope_i, slope_o = (tilt * ox - tilts.slope[0]) * ix + (tilt * oy - tilts.slope[1]) * iy, -tilt
        deep_i, deep_o = reach - away, out - track
        guess = _guesses(compliance.between, forces.guess, at, width, there)
        given = _guesses(compliance.between, forces.tilted.guess, at, width, there)
        less_i, less_o = _taken(compliance.between, compliance, forces, drive, group, forces.guess, guess)
        more_i, more_o = _given(compliance.between, compliance, forces, group, forces.tilted.guess)
        store_pair(forces.tilted.taken, group, columns, less_i, less_o)
        met = surfaces_met(forces.slope, bodies, compliance, forces, drive, group, turn)
        deep_i, deep_o = sunk(forces.slope, forces, columns, group, met, deep_i, deep_o)
        deep_i, deep_o = select(there, deep_i - less_i, -1.0), select(there, deep_o - less_o, -1.0)
        laws, rests = compliance.tables, compliance.rests
        Q_i, M_i = _look((laws[0], rests[0]), forces, INNER, columns, group, deep_i, slope_i + more_i)
        Q_o, M_o = _look((laws[1], rests[1]), forces, OUTER, columns, group, deep_o, slope_o + more_o)
        keep_slopes(forces.slope, forces, columns, group, met)
        _tell(compliance.between, compliance, forces, group, (Q_i, Q_o), (M_i, M_o), guess, given)
    _correct(compliance.between, bodies, compliance, forces)
    return _sums(bodies, forces, drive)


@part
def _guesses(between, array, at, width, there):
    if between is None:
        return splat(0.0), splat(0.0)
    return select(there, load(array, at), 0.0), select(there, load(array, width + at), 0.0)


@part
def _taken(between, compliance, forces, drive, group, array, pair):
    """Approaches, m, that other contacts' forces take of eight rollers'."""
    if between is None:
        return splat(0.0), splat(0.0)
    less_i = compliance.across * pair[1] + coupled_approach(compliance, forces, array, INNER, group)
    less_o = compliance.across * pair[0] + coupled_approach(compliance, forces, array, OUTER, group)
    less_i += lift(compliance, forces, drive, INNER, group)
    less_o += lift(compliance, forces, drive, OUTER, group)
    over = 1.0 / compliance.reach, 1.0 / compliance.track
    tilt_i, tilt_o = raceway_tilt(compliance, forces, INNER, group), raceway_tilt(compliance, forces, OUTER, group)
    store_pair(forces.tilt, group, forces.normal.shape[2], tilt_i * over[0], tilt_o * over[1])
    return less_i, less_o


@part
def _given(between, compliance, forces, group, array):
    """Misalignments, rad, that moments along the rings give eight rollers' contacts."""
    if between is None:
        return splat(0.0), splat(0.0)
    more_i = coupled_approach(compliance, forces, array, INNER, group)
    more_o = coupled_approach(compliance, forces, array, OUTER, group)
    return more_i * compliance.share, more_o * compliance.share


@part
def _look(laws, forces, row, columns, group, deep, slope):
    """Look eight contacts up; their forces, N, and moments, N m. `laws` : of all slices, and `SpalledRest`."""
    met = forces.tilted.met
    at = row * columns + group
    energy, Q, M, stiff, cross, tilting = table_at(forces, laws, at, columns, deep, slope)
    store(forces.first, row * columns + group, deep)
    store(forces.estimate, row * columns + group, Q)
    store(forces.stiffness, row * columns + group, stiff)
    store(forces.tilted.stiffness, row * columns + group, tilting)
    store(met, _at(row, SLOPE, columns, group), slope)
    store(met, _at(row, ENERGY, columns, group), energy)
    store(met, _at(row, MOMENT, columns, group), M)
    store(met, _at(row, CROSS, columns, group), cross)
    return Q, M


@part
def _tell(between, compliance, forces, group, Q, M, guess, given):
    """What forces and moments turn out beyond the guesses, with a roller's other contact, for all others."""
    if between is None:
        return
    at, width, factor = forces.halo + group, forces.gained.shape[1], compliance.relaxation_factor
    more_i, more_o, turn_i, turn_o = _pair(compliance, forces, group, Q, M, guess)
    store_pair(forces.gained, at, width, factor * (more_i - guess[0]), factor * (more_o - guess[1]))
    store_pair(forces.tilted.gained, at, width, factor * (turn_i - given[0]), factor * (turn_o - given[1]))


@part
def _pair(compliance, forces, group, Q, M, guess):
    """A roller's two forces and moments, each with the other contact's change."""
    columns, a, met = forces.normal.shape[2], compliance.across, forces.tilted.met
    stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
    cross_i, cross_o = load(met, _at(INNER, CROSS, columns, group)), load(met, _at(OUTER, CROSS, columns, group))
    Q_i, Q_o = both_forces(Q[0], Q[1], stiff_i * a, stiff_o * a, guess[0], guess[1])
    return Q_i, Q_o, M[0] + cross_i * a * (Q_o - guess[1]), M[1] + cross_o * a * (Q_i - guess[0])


@part
def _correct(between, bodies, compliance, forces):
    """Forces, moments, energies and their places with what all others have gained."""
    if between is None:
        return
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    for row in range(2):
        wrap(forces.gained, row, n, halo)
        wrap(forces.tilted.gained, row, n, halo)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, halo + group
        guess = _guesses(between, forces.guess, at, width, there)
        less_i = coupled_approach(compliance, forces, forces.gained, INNER, group)
        less_o = coupled_approach(compliance, forces, forces.gained, OUTER, group)
        more_i, more_o = _given(between, compliance, forces, group, forces.tilted.gained)
        Q_i, M_i = _moved(forces, INNER, columns, group, -less_i, more_i)
        Q_o, M_o = _moved(forces, OUTER, columns, group, -less_o, more_o)
        Q_i, Q_o, _, _ = _pair(compliance, forces, group, (Q_i, Q_o), (M_i, M_o), guess)
        from_o, from_i = across * (Q_o - guess[1]), across * (Q_i - guess[0])
        _take_more(forces, columns, group, less_i + from_o, less_o + from_i)
        _moved(forces, INNER, columns, group, -from_o, 0.0)
        _moved(forces, OUTER, columns, group, -from_i, 0.0)


@part
def _take_more(forces, columns, group, inner, outer):
    """Keep what other contacts' forces take of eight rollers' approaches more, m."""
    taken, at = forces.tilted.taken, columns + group
    store_pair(taken, group, columns, load(taken, group) + inner, load(taken, at) + outer)


@part
def _moved(forces, row, columns, group, further, turned):
    """Move eight contacts by a further approach, m, and misalignment, rad: their forces, N, and moments, N m."""
    met, at = forces.tilted.met, row * columns + group
    Q, M = load(forces.estimate, at), load(met, _at(row, MOMENT, columns, group))
    stiff, tilting = load(forces.stiffness, at), load(forces.tilted.stiffness, at)
    cross, energy = load(met, _at(row, CROSS, columns, group)), load(met, _at(row, ENERGY, columns, group))
    Q_now, M_now = Q + stiff * further + cross * turned, M - cross * further - tilting * turned
    energy += 0.5 * (Q + Q_now) * further - 0.5 * (M + M_now) * turned
    closed = (Q > 0.0) & (Q_now > 0.0)
    store(forces.estimate, at, select(closed, Q_now, 0.0))
    store(forces.first, at, load(forces.first, at) + further)
    store(met, _at(row, SLOPE, columns, group), load(met, _at(row, SLOPE, columns, group)) + turned)
    store(met, _at(row, MOMENT, columns, group), select(closed, M_now, 0.0))
    store(met, _at(row, ENERGY, columns, group), select(closed, maximum(energy, 0.0), 0.0))
    return select(closed, Q_now, 0.0), select(closed, M_now, 0.0)


@part
def _sums(bodies, forces, drive):
    """Sums of forces on hub and outer ring, N; angular accelerations of rollers and hub are kept."""
    columns, n, tilts = bodies.columns, bodies.n, bodies.tilts
    hub_x, hub_y, ring_x, ring_y, on_x, on_y = (
        splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    )  # fmt: skip
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, columns + group)
        M_i = select(there, load(forces.tilted.met, _at(INNER, MOMENT, columns, group)), 0.0)
        M_o = select(there, load(forces.tilted.met, _at(OUTER, MOMENT, columns, group)), 0.0)
        store(tilts.pushed, group, (M_i * (ix * ox + iy * oy) - M_o) * (1.0 / tilts.inertia))
        hub_x -= Q_i * ix
        hub_y -= Q_i * iy
        ring_x += Q_o * ox
        ring_y += Q_o * oy
        on_x -= M_i * ix
        on_y -= M_i * iy
    push_axes(tilts, drive, (total(on_x), total(on_y)))
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def kick_tilted(compliance, bodies, forces, drive, before):
    """Kicks of rollers by forces and moments a little ahead; what contacts give hub and outer ring, N."""
    if compliance.between is not None:
        press_neighbours(bodies, compliance, forces, drive, before)
    columns, n, halo, dt, tilts = bodies.columns, bodies.n, forces.halo, drive.dt, bodies.tilts
    width, over = columns + 2 * halo, dt / bodies.mass
    hub_x, hub_y, ring_x, ring_y, on_x, on_y = (
        splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    )  # fmt: skip
    bx, by = tilts.slope[0], tilts.slope[1]
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        ix, iy = load(forces.normal, group), load(forces.normal, at)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        ahead_i, ahead_o, turn_i, turn_o = _ahead(bodies, forces, drive, before, group)
        _move_both(compliance.between, compliance, forces, columns, group, (ahead_i, ahead_o), (turn_i, turn_o))
        P_i, M_i = _kicked(compliance.tables[0], bodies, compliance, forces, INNER, group, ahead_i, there)
        P_o, M_o = _kicked(compliance.tables[1], bodies, compliance, forces, OUTER, group, ahead_o, there)
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, at)
        grow(drive.history, drive, P_i, P_o)
        pushes = (Q_i, Q_o), (P_i, P_o)
        T_i, T_o = _rubbed(compliance.between, bodies, compliance, forces, drive, before, group, pushes)
        along_i, along_o = push_along(forces.slope, bodies, forces, drive, group, (P_i, P_o), (Q_i, Q_o))
        T_i, T_o = T_i + along_i, T_o + along_o
        # where slopes have a part across the normal, moments push aside
        tilt, facing, beside = load(tilts.tilt, group), ix * ox + iy * oy, oy * ix - ox * iy
        kick_axes(tilts, drive, group, M_i * facing - M_o)
        T_i += M_i * (tilt * beside - (by * ix - bx * iy)) * splat(1.0 / compliance.reach)
        T_o -= M_i * tilt * beside * splat(1.0 / compliance.track)
        fx, fy = P_i * ix - T_i * iy, P_i * iy + T_i * ix
        gx, gy = P_o * ox + T_o * oy, P_o * oy - T_o * ox
        hub_x -= select(there, fx, 0.0)
        hub_y -= select(there, fy, 0.0)
        ring_x += select(there, gx, 0.0)
        ring_y += select(there, gy, 0.0)
        on_x -= M_i * ix
        on_y -= M_i * iy
        store(bodies.velocity, group, load(bodies.velocity, group) + over * (fx - gx))
        store(bodies.velocity, at, load(bodies.velocity, at) + over * (fy - gy) - drive.gravity * dt)
        # forces of this kick become the last ones; guess the next
        if compliance.between is None:
            store_pair(forces.force, group, columns, Q_i, Q_o)
            store_pair(forces.tilted.moment, group, columns, M_i, M_o)
        else:
            _expect_moment(forces, INNER, width, columns, group, Q_i, M_i)
            _expect_moment(forces, OUTER, width, columns, group, Q_o, M_o)
    kick_hub_axis(tilts, drive, (total(on_x), total(on_y)))
    if compliance.between is not None:
        for row in range(2):
            wrap(forces.guess, row, n, forces.halo)
            wrap(forces.tilted.guess, row, n, forces.halo)
            if drive.friction > 0.0:
                wrap(forces.pulled, row, n, forces.halo)
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def _ahead(bodies, forces, drive, before, group):
    """How much further eight rollers' contacts approach and turn where forces are taken, m and rad, inner and outer."""
    columns, share, tilts = bodies.columns, TWELFTH * drive.dt * drive.dt, bodies.tilts
    there, at = count_from(group) < bodies.n, columns + group
    ix, iy = load(forces.normal, group), load(forces.normal, at)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, at)
    hub, ring = before.hub_acceleration, ring_acceleration(bodies.housing, before)
    ax = (Q_i * ix - Q_o * ox) * (1.0 / bodies.mass)
    ay = (Q_i * iy - Q_o * oy) * (1.0 / bodies.mass) - drive.gravity
    ax, ay = along_ray(bodies.prescribed, ox, oy, ax, ay)
    store_pair(before.acceleration, group, columns, select(there, ax, 0.0), select(there, ay, 0.0))
    pushed = load(tilts.pushed, group)
    turned = pushed * (ix * ox + iy * oy) - (tilts.slope_pushed[0] * ix + tilts.slope_pushed[1] * iy)
    inner, outer = ix * (hub[0] - ax) + iy * (hub[1] - ay), ox * (ax - ring[0]) + oy * (ay - ring[1])
    return share * inner, share * outer, share * turned, -share * pushed


@part
def _move_both(between, compliance, forces, columns, group, ahead, turn):
    """Move eight rollers' contacts ahead, with what each gives a roller's other one."""
    if between is None:
        _moved(forces, INNER, columns, group, ahead[0], turn[0])
        _moved(forces, OUTER, columns, group, ahead[1], turn[1])
    else:
        Q, across = (load(forces.estimate, group), load(forces.estimate, columns + group)), compliance.across
        near, far = (
            _would(forces, INNER, columns, group, ahead[0], turn[0]),
            _would(forces, OUTER, columns, group, ahead[1], turn[1]),
        )
        Q_i, Q_o, _, _ = _pair(compliance, forces, group, (near[0], far[0]), (near[1], far[1]), Q)
        more_i, more_o = _no_less(Q[0], Q_i - Q[0]), _no_less(Q[1], Q_o - Q[1])
        _moved(forces, INNER, columns, group, ahead[0] - across * more_o, turn[0])
        _moved(forces, OUTER, columns, group, ahead[1] - across * more_i, turn[1])
        _take_more(forces, columns, group, across * more_o, across * more_i)


@part
def _no_less(Q, more):
    return select(Q > 0.0, maximum(more, -Q), 0.0)


@part
def _would(forces, row, columns, group, further, turned):
    """Forces and moments of `_moved`, without the move."""
    met, at = forces.tilted.met, row * columns + group
    cross = load(met, _at(row, CROSS, columns, group))
    Q = load(forces.estimate, at) + load(forces.stiffness, at) * further + cross * turned
    M = load(met, _at(row, MOMENT, columns, group)) - cross * further
    return Q, M - load(forces.tilted.stiffness, at) * turned


@part
def _kicked(table, bodies, compliance, forces, row, group, ahead, there):
    """What a kick gives of eight contacts' forces, N, and their moments, N m."""
    met, own, columns = forces.tilted.met, forces.tilted, bodies.columns
    at = row * columns + group
    Q, approach = load(forces.estimate, at), load(forces.first, at)
    M, slope = load(met, _at(row, MOMENT, columns, group)), load(met, _at(row, SLOPE, columns, group))
    most = Q * compliance.length  # slices lie no further out than half of that, which tables overshoot
    M = select(there, maximum(minimum(M, most), -most), 0.0)
    energy, residual = load(met, _at(row, ENERGY, columns, group)), load(forces.residual, at)
    before, Q_before, P_before = load(forces.approach, at), load(forces.force, at), load(forces.kick, at)
    way, given = fallen(own, at, columns, Q - Q_before)
    step, known = approach - before - way, before == before
    work = given + energy - load(own.energy, at) + 0.5 * (M + load(own.moment, at)) * (slope - load(own.slope, at))
    taken, last = load(own.taken, at), at + own.taken.size // 2
    P = select(there, kick_by_work(Q, Q_before, P_before, residual, approach, step, work), 0.0)
    grown = taken - load(own.taken, last)  # forces at both ends take what is stored between contacts
    left = work - 0.5 * step * (P_before + P) + 0.5 * grown * (Q - P + Q_before - P_before)
    residual = select(known & there, residual + left, residual)
    ways = (step + grown, ahead)
    P, residual = released(load(forces.force, at), Q, P, residual, ways, SHORTEST)
    store(own.taken, last, taken)
    store(own.energy, at, energy)
    store(own.slope, at, slope)
    store(forces.approach, at, select(there, approach, np.nan))
    store(forces.kick, at, P)
    store(forces.residual, at, residual)
    deepest = own_approach(own.edges, at, approach, Q)
    reached = there & (deepest > table.first_approach)
    note_furthest(bodies.tilts, row, select(reached, deepest, 0.0), select(reached, absolute(slope), 0.0))
    return P, M


@part
def note_furthest(tilts, row, approach, slope):
    furthest, columns = tilts.furthest, tilts.furthest.shape[1]
    store(furthest, row * columns, maximum(load(furthest, row * columns), approach))
    store(furthest, 2 * columns, maximum(load(furthest, 2 * columns), slope))


@part
def _rubbed(between, bodies, compliance, forces, drive, before, group, pushes):
    """Tractions of eight rollers, N, and what the raceways' tilt under contacts adds.

    pushes : N, forces of the inner and the outer contact, and their kicks
    """
    if between is None:
        return splat(0.0), splat(0.0)
    T_i, T_o, there = splat(0.0), splat(0.0), count_from(group) < bodies.n
    columns, width, (Q, P) = bodies.columns, bodies.columns + 2 * forces.halo, pushes
    if drive.friction > 0.0:
        T_i, T_o = tractions(bodies, compliance, forces, drive, before, group, Q[0], Q[1])
        pulled = select(there, T_i, 0.0), select(there, T_o, 0.0)
        store_pair(forces.pulled, forces.halo + group, width, pulled[0], pulled[1])
        shift(forces, drive, INNER, group, Q[0])
        shift(forces, drive, OUTER, group, Q[1])
    turned = (T_o - T_i) * (drive.dt * bodies.radius / bodies.inertia)
    store(bodies.spin, group, load(bodies.spin, group) + turned)
    return T_i - P[0] * load(forces.tilt, group), T_o - P[1] * load(forces.tilt, columns + group)


@part
def _expect_moment(forces, row, width, columns, group, Q, M):
    tilted, at = forces.tilted, row * columns + group
    going_on = (Q > 0.0) & (load(forces.force, at) > 0.0)
    store(tilted.guess, row * width + forces.halo + group, select(going_on, 2.0 * M - load(tilted.moment, at), M))
    store(tilted.moment, at, M)
    expect(forces, row * width + forces.halo + group, at, Q)


damping_coefficients.of(Tilted)(isolated_damping)


@part
def tilted_energy(compliance, forces, columns, group):
    """Energy of eight rollers' contacts and of what moments bend between them, J."""
    own = load(forces.tilted.energy, group) + load(forces.tilted.energy, columns + group)
    return own + _between(compliance.between, compliance, forces, columns, group)


@part
def _between(between, compliance, forces, columns, group):
    if between is None:
        return splat(0.0)
    moment, gained = forces.tilted.moment, forces.tilted.gained
    M_i, M_o = load(moment, group), load(moment, columns + group)
    more = 0.5 * coupled_approach(compliance, forces, gained, INNER, group) * M_i
    more += 0.5 * coupled_approach(compliance, forces, gained, OUTER, group) * M_o
    return more * compliance.share


@part
def repeat_moments(between, forces, n, columns):
    """Leave in `gained` the moments that raceways bear around; see `reduced_samples`."""
    if between is not None:
        gained = forces.tilted.gained
        for row in range(2):
            for group in range(0, n, WIDTH):
                M = load(forces.tilted.moment, row * columns + group)
                store(gained, row * gained.shape[1] + forces.halo + group, M)
            wrap(gained, row, n, forces.halo)
