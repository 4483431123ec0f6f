"""Forces of the reduced model's contacts at given positions.

A raceway's contact gives way by its own law and by the forces on other contacts of its bodies:

    approach = overlap of the circles − across·(force on the roller's other contact) − Σ along_k·(force k rollers away)

Those forces are guessed from the last steps, the law gives force and stiffness, and two linear sweeps set them right:
what is left is the square of a few hundredths of what the guess was off by.
"""

from math import cos, sin

import numpy as np

from fem.kernels.contact_kernels import next_rollers
from fem.kernels.course_kernels import GAIN, SPEED, speed_of
from fem.kernels.friction_kernels import SLIP_FLOOR, creep_traction
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import cosine_and_sine, larger, logarithm, smaller
from fem.kernels.lane_memory import gather, load, scatter_add, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, magnitude, root, select, splat, total
from fem.kernels.law import STEEPEST, contact_force, kick_force
from fem.kernels.profile_kernels import lowered_ring, lowered_rollers
from fem.kernels.reduced_damping import damped_neighbours, no_dampers, note_lowered, with_damper
from fem.kernels.reduced_modes import gather_waves, less_vibration, push_modes
from fem.kernels.reduced_state import INNER, NEXT, OUTER
from fem.kernels.state import Course

MORE_SWEEPS = 2  # where bodies vibrate
NEAR = 1e-3  # of a force: a guess no further off needs one step of Newton's
TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken


@part
def wrap(array, row, n, halo):
    """Repeat a ring's first and last contacts beyond its ends."""
    for k in range(halo):
        array[row, halo - 1 - k] = array[row, halo + n - 1 - k]
        array[row, halo + n + k] = array[row, halo + k]


@part
def _felt(compliance, array, row, at):
    """Approach of eight contacts, m, that forces along their ring take away."""
    found = splat(0.0)
    for k in range(compliance.distance.size):
        found += compliance.along[row, k] * load(array, at + compliance.distance[k])
    return found


@part
def _stiffness(law, force, approach):
    """dQ/dδ, N/m; 0 of open contacts."""
    closed = force > 0.0
    soft = select(closed, approach, 1.0) / select(closed, force, 1.0) - 0.5 * law.A
    return select(closed, 1.0 / larger(soft, STEEPEST * law.A), 0.0)


@part
def _level(law, brackets, at):
    """B of eight contacts."""
    if brackets is None:
        return splat(law.B)
    return load(brackets, at)


@part
def _force(law, B, approach, guess):
    """Forces of eight approaches, N, and their stiffness, N/m, 0 of open contacts.

    From a good guess one step of third order, from any other `law.contact_force`.
    """
    known = guess > 0.0
    Q = select(known, guess, 1.0)
    bracket = B - 0.5 * logarithm(Q)
    relative = 1.0 / (law.A * Q * (bracket - 0.5))  # stiffness over force
    step = (approach - law.A * Q * bracket) * relative  # of the force, over it
    stiffness = relative * Q
    bend = 0.5 * law.A * stiffness * step
    rough = (magnitude(step) >= NEAR) | (Q + step * Q >= law.Q_line)
    found = select(known, Q + Q * step * (1.0 + 0.5 * bend), 0.0)
    stiffness = select(known, stiffness * (1.0 + bend), 0.0)
    if any_lane((known & rough) | ((guess <= 0.0) & (approach > 0.0))):
        found = contact_force(approach, law.A, B, law.Q_line, guess)
        stiffness = _stiffness(law, found, approach)
    return found, stiffness


@part
def _both(inner, outer, by_inner, by_outer, guess_inner, guess_outer):
    """A roller's two forces, each with the other's change; `by_`: stiffness times what a newton on the other does."""
    beyond_inner, beyond_outer = inner - guess_inner, outer - guess_outer
    more = by_inner * (by_outer * beyond_inner - beyond_outer) / (1.0 - by_inner * by_outer)
    return inner + more, outer - by_outer * (beyond_inner + more)


@part
def estimate_forces(bodies, compliance, forces, drive, turn):
    """Forces by the guess: their approach, stiffness and normals; and what they gain with a roller's other contact.

    `turn` : rad, of the inner ring.
    """
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    inner, outer = compliance.inner, compliance.outer
    reach, track = _touching(drive.course, compliance, drive)
    gather_waves(bodies.vibrations)
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
        out = root(select(there, x * x + y * y, 1.0))
        scale = 1.0 / out
        _store_pair(
            forces.normal, 2 * columns + group, columns, select(there, x * scale, 1.0), select(there, y * scale, 0.0)
        )
        x, y = x - bodies.hub[0], y - bodies.hub[1]
        away = root(select(there, x * x + y * y, 1.0))
        scale = 1.0 / away
        _store_pair(forces.normal, group, columns, select(there, x * scale, 1.0), select(there, y * scale, 0.0))
        at = halo + group
        guess_i, guess_o = load(forces.guess, at), load(forces.guess, width + at)
        guess_i, guess_o = select(there, guess_i, 0.0), select(there, guess_o, 0.0)
        first_i = reach - away - across * guess_o - _felt(compliance, forces.guess, INNER, at)
        first_o = out - track - across * guess_i - _felt(compliance, forces.guess, OUTER, width + at)
        _take(forces.taken, columns, group, reach - away - first_i, out - track - first_o)
        circles_i, circles_o = first_i, first_o
        first_i, first_o = _lowered(bodies, compliance, forces, group, turn, first_i, first_o, forces.slope)
        note_lowered(forces.dampers, columns, group, first_i - circles_i, first_o - circles_o, drive.dt)
        first_i, first_o = less_vibration(bodies.vibrations, forces, columns, group, first_i, first_o)
        first_i, first_o = select(there, first_i, -1.0), select(there, first_o, -1.0)
        B_i, B_o = _level(inner, forces.bracket_now, group), _level(outer, forces.bracket_now, columns + group)
        Q_i, stiff_i = _force(inner, B_i, first_i, guess_i)
        Q_o, stiff_o = _force(outer, B_o, first_o, guess_o)
        _store_pair(forces.first, group, columns, first_i, first_o)
        _store_pair(forces.estimate, group, columns, Q_i, Q_o)
        _store_pair(forces.stiffness, group, columns, stiff_i, stiff_o)
        Q_i, Q_o = _both(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
        _store_pair(forces.gained, at, width, Q_i - guess_i, Q_o - guess_o)
    wrap(forces.gained, INNER, n, halo)
    wrap(forces.gained, OUTER, n, halo)


@verb
def _touching(course, compliance, drive):
    """Distances from hub and centre, m, at which rollers touch the rings, grown by their spin."""
    return compliance.reach, compliance.track


@_touching.of(Course)
def _touching_now(course, compliance, drive):
    more = course.now[SPEED] * course.now[SPEED] - drive.speed * drive.speed
    return compliance.reach + course.growth * more, compliance.track - course.roller_growth * more


@verb
def _grow(course, drive, P_i, P_o):
    """The work of bodies that grow against eight rollers' forces, N, as the shaft speeds up."""


@_grow.of(Course)
def _grow_now(course, drive, P_i, P_o):
    more = 2.0 * course.now[SPEED] * course.now[GAIN] * drive.dt
    drive.sums[1] += more * total(course.growth * P_i + course.roller_growth * P_o)


@part
def _lowered(bodies, compliance, forces, group, turn, inner, outer, slope):
    """Approaches of eight rollers on surfaces that are not perfect circles; laws' brackets and slopes are kept."""
    if slope is None:
        return inner, outer
    columns = bodies.columns
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    c, s = cos(turn), sin(turn)
    still = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    ring = lowered_ring(compliance.ring_profiles[0], 1.0, still, c * ix + s * iy, c * iy - s * ix)
    ring_o = lowered_ring(compliance.ring_profiles[1], 1.0, still, ox, oy)
    c, s = cosine_and_sine(load(bodies.turn, group))
    own = lowered_rollers(compliance.roller_profiles[0], group, still, -(c * ix + s * iy), s * ix - c * iy)
    own_o = lowered_rollers(compliance.roller_profiles[1], group, still, c * ox + s * oy, c * oy - s * ox)
    _store_pair(slope, group, columns, ring[1] + own[1], own[1])
    _store_pair(slope, 2 * columns + group, columns, ring_o[1] + own_o[1], own_o[1])
    _store_pair(forces.softening, group, columns, ring[3] + own[3], own[3])
    _store_pair(forces.softening, 2 * columns + group, columns, ring_o[3] + own_o[3], own_o[3])
    B_i = compliance.inner.B + (ring[2] + own[2]) * (1.0 / compliance.inner.A)
    B_o = compliance.outer.B + (ring_o[2] + own_o[2]) * (1.0 / compliance.outer.A)
    _store_pair(forces.bracket_now, group, columns, B_i, B_o)
    return inner + ring[0] + own[0], outer + ring_o[0] + own_o[0]


@part
def _with_slopes(bodies, forces, drive, group, P, Q, T, slope):
    """Forces of eight rollers along +θ in both contacts, N, with what slopes of surfaces add; these turn rollers too.

    Pairs, inner and outer: what a kick gives, forces, tractions.
    """
    if slope is None:
        return T
    columns, soft = bodies.columns, forces.softening
    x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
    out = x * load(forces.normal, 2 * columns + group) + y * load(forces.normal, 3 * columns + group)
    x, y = x - bodies.hub[0], y - bodies.hub[1]
    away = x * load(forces.normal, group) + y * load(forces.normal, columns + group)
    there = count_from(group) < bodies.n
    out, away = select(there, out, 1.0), select(there, away, 1.0)
    half, half_o = 0.5 * Q[0] * Q[0], 0.5 * Q[1] * Q[1]
    both = P[0] * load(slope, group) - half * load(soft, group)
    own = P[0] * load(slope, columns + group) - half * load(soft, columns + group)
    both_o = P[1] * load(slope, 2 * columns + group) - half_o * load(soft, 2 * columns + group)
    own_o = P[1] * load(slope, 3 * columns + group) - half_o * load(soft, 3 * columns + group)
    drive.sums[1] -= speed_of(drive.course, drive) * drive.dt * total(both - own)
    store(bodies.spin, group, load(bodies.spin, group) + (own + own_o) * (drive.dt / bodies.inertia))
    return T[0] - both / away, T[1] - both_o / out


@part
def _store_pair(array, at, apart, one, other):
    store(array, at, one)
    store(array, at + apart, other)


@part
def sweep_again(vibrations, bodies, compliance, forces):
    """Tell what forces gain by each other's gains, as `set_right` does, before it does.

    Where bodies vibrate a guess is off by as much as a vibration bends in a step; what two sweeps leave of that lags
    behind, and would feed the fastest vibrations.
    """
    if vibrations is None:
        return
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    for _ in range(MORE_SWEEPS):
        for group in range(0, n, WIDTH):
            at = halo + group
            stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
            guess_i, guess_o = load(forces.guess, at), load(forces.guess, width + at)
            Q_i = load(forces.estimate, group) - stiff_i * _felt(compliance, forces.gained, INNER, at)
            Q_o = load(forces.estimate, columns + group) - stiff_o * _felt(compliance, forces.gained, OUTER, width + at)
            Q_i, Q_o = _both(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
            gained_i, gained_o = larger(Q_i, 0.0) - guess_i, larger(Q_o, 0.0) - guess_o
            there = count_from(group) < n
            _store_pair(forces.gained, at, width, select(there, gained_i, 0.0), select(there, gained_o, 0.0))
        wrap(forces.gained, INNER, n, halo)
        wrap(forces.gained, OUTER, n, halo)


@part
def set_right(bodies, compliance, forces):
    """The forces with what all others have gained; their sum on the hub, N, x and y. Leaves approaches in `first`."""
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    hub_x, hub_y = splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        at = halo + group
        less_i = _felt(compliance, forces.gained, INNER, at)
        less_o = _felt(compliance, forces.gained, OUTER, width + at)
        stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
        guess_i, guess_o = load(forces.guess, at), load(forces.guess, width + at)
        Q_i = load(forces.estimate, group) - stiff_i * less_i
        Q_o = load(forces.estimate, columns + group) - stiff_o * less_o
        Q_i, Q_o = _both(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
        Q_i, Q_o = larger(Q_i, 0.0), larger(Q_o, 0.0)
        _store_pair(forces.estimate, group, columns, Q_i, Q_o)
        first_i, first_o = load(forces.first, group), load(forces.first, columns + group)
        _take_more(forces.taken, columns, group, less_i + across * (Q_o - guess_o), less_o + across * (Q_i - guess_i))
        first_i = first_i - less_i - across * (Q_o - guess_o)
        first_o = first_o - less_o - across * (Q_i - guess_i)
        _store_pair(forces.first, group, columns, first_i, first_o)
        hub_x -= Q_i * load(forces.normal, group)
        hub_y -= Q_i * load(forces.normal, columns + group)
    return total(hub_x), total(hub_y)


@part
def kick(bodies, compliance, forces, drive, before):
    """Give the rollers their kick; what contacts give the hub, N, x and y.

    Forces are those at positions dt²/12 times the acceleration ahead, which makes leapfrog's phase error one of fourth
    order: at a tenth of a vibration's period per step 0.01 % instead of 1.6 %.

    Source: Numerov's method; Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), chapter III.
    """
    columns, n, halo, dt = bodies.columns, bodies.n, forces.halo, drive.dt
    width, over, across = columns + 2 * halo, dt / bodies.mass, compliance.across
    share, hub_ax, hub_ay = TWELFTH * dt * dt, before.hub_acceleration[0], before.hub_acceleration[1]
    hub_x, hub_y = splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        Q_i, Q_o = load(forces.estimate, group), load(forces.estimate, columns + group)
        ax = (Q_i * ix - Q_o * ox) * (1.0 / bodies.mass)
        ay = (Q_i * iy - Q_o * oy) * (1.0 / bodies.mass) - drive.gravity
        _store_pair(before.acceleration, group, columns, select(there, ax, 0.0), select(there, ay, 0.0))
        ahead_i = share * (ix * (hub_ax - ax) + iy * (hub_ay - ay))
        ahead_o = share * (ox * ax + oy * ay)
        stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
        more_i, more_o = _both(stiff_i * ahead_i, stiff_o * ahead_o, stiff_i * across, stiff_o * across, 0.0, 0.0)
        Q_i, Q_o = select(Q_i > 0.0, larger(Q_i + more_i, 0.0), 0.0), select(Q_o > 0.0, larger(Q_o + more_o, 0.0), 0.0)
        _take_more(forces.taken, columns, group, across * more_o, across * more_i)
        P_i = _kicked(compliance.inner, forces, group, ahead_i - across * more_o, Q_i, there)
        P_o = _kicked(compliance.outer, forces, columns + group, ahead_o - across * more_i, Q_o, there)
        _keep_brackets(forces, group, columns, forces.bracket)
        _grow(drive.course, drive, P_i, P_o)
        T_i, T_o = splat(0.0), splat(0.0)
        if drive.friction > 0.0:
            T_i, T_o = _tractions(bodies, compliance, forces, drive, before, group, Q_i, Q_o)
        store(bodies.spin, group, load(bodies.spin, group) + (T_o - T_i) * (dt * bodies.radius / bodies.inertia))
        both = with_damper(forces.dampers, group, P_i), with_damper(forces.dampers, columns + group, P_o)
        T_i, T_o = _with_slopes(bodies, forces, drive, group, both, (Q_i, Q_o), (T_i, T_o), forces.slope)
        T_i, T_o = push_modes(bodies.vibrations, bodies, forces, drive, group, P_i, P_o, T_i, T_o)
        fx, fy = P_i * ix - T_i * iy, P_i * iy + T_i * ix
        hub_x -= select(there, fx, 0.0)
        hub_y -= select(there, fy, 0.0)
        fx, fy = fx - P_o * ox - T_o * oy, fy - P_o * oy + T_o * ox
        store(bodies.velocity, group, load(bodies.velocity, group) + over * fx)
        at = columns + group
        store(bodies.velocity, at, load(bodies.velocity, at) + over * fy - drive.gravity * dt)
        _expect(forces, halo + group, group, Q_i)
        _expect(forces, width + halo + group, columns + group, Q_o)
    wrap(forces.guess, INNER, n, halo)
    wrap(forces.guess, OUTER, n, halo)
    return total(hub_x), total(hub_y)


@part
def _kicked(law, forces, at, ahead, Q, there):
    """What a kick gives of eight contacts' forces, N, whose approach is so far ahead, m: see `law.kick_force`."""
    approach = load(forces.first, at) + ahead
    approach = select(Q > 0.0, larger(approach, 1e-30), select(approach > 0.0, 0.0, approach))
    B_before, B = _level(law, forces.bracket, at), _level(law, forces.bracket_now, at)
    P, residual = kick_force(
        load(forces.approach, at), load(forces.force, at), B_before, load(forces.kick, at), load(forces.residual, at),
        approach, Q, B, law.A, law.Q_line,
    )  # fmt: skip
    P = select(there, P, 0.0)
    P, residual = _bounded(forces, forces.taken, at, approach, P, Q, residual)
    store(forces.approach, at, select(there, approach, np.nan))
    store(forces.kick, at, P)
    store(forces.residual, at, residual)
    return P


@part
def _keep_brackets(forces, group, columns, brackets):
    """The laws' B of eight rollers' contacts are now those of the last kick."""
    if brackets is not None:
        _store_pair(
            brackets, group, columns, load(forces.bracket_now, group), load(forces.bracket_now, columns + group)
        )


@part
def _take(taken, columns, group, inner, outer):
    """Keep what other contacts take of eight rollers' approaches, m."""
    if taken is not None:
        _store_pair(taken, group, columns, inner, outer)


@part
def _take_more(taken, columns, group, inner, outer):
    if taken is not None:
        at = columns + group
        _store_pair(taken, group, columns, load(taken, group) + inner, load(taken, at) + outer)


@part
def _bounded(forces, taken, at, approach, P, Q, residual):
    """A kick no further off than the larger force of the step behind; what contacts have stored beyond kicks, J.

    Where bodies vibrate a guess can be so far off that approach and force of a contact that opens don't fit. And what
    energy between contacts has grown by is more than kicks have taken for it: forces Q at both ends of a step take it
    exactly, kicks P only where the contact neither opens nor closes.
    """
    if taken is None:
        return P, residual
    before, Q_before, last = load(forces.approach, at), load(forces.force, at), at + taken.size // 2
    most = larger(Q, Q_before)
    given = larger(smaller(P, Q + most), Q - most)
    grown = load(taken, at) - load(taken, last)
    store(taken, last, load(taken, at))
    owed = 0.5 * (approach - before) * (P - given) + 0.5 * grown * (Q - given + Q_before - load(forces.kick, at))
    return given, residual + select(before != before, 0.0, owed)


@part
def _expect(forces, at, row, Q):
    """Guess the next step's forces, in a straight line from the last two; they become the last ones."""
    last = load(forces.force, row)
    store(forces.fastest, 0, larger(load(forces.fastest, 0), magnitude(Q - last)))
    store(forces.guess, at, select((Q > 0.0) & (last > 0.0), larger(2.0 * Q - last, 0.0), Q))
    store(forces.force, row, Q)


@part
def _tractions(bodies, compliance, forces, drive, before, group, Q_i, Q_o):
    """Tractions of eight rollers, N, on them along +θ: elastic up to Carter's creep.

    A contact's tangential compliance takes what the bodies slip in a step but for its creep. The slip is that on the
    way here, so tractions are springs like the normal forces, and no contact's depends on another's.
    """
    columns, hub_x, hub_y = bodies.columns, before.hub_velocity[0], before.hub_velocity[1]
    vx, vy = load(before.velocity, group), load(before.velocity, columns + group)
    spin = load(before.spin, group)
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    along = vy * ix - vx * iy
    slip = along - (hub_y * ix - hub_x * iy)
    slip -= spin * bodies.radius + speed_of(drive.course, drive) * drive.inner_radius
    rolling = magnitude(spin - along * (1.0 / compliance.reach)) * bodies.radius
    T_i = creep(compliance.inner, compliance, forces, drive, INNER, columns * INNER + group, Q_i, slip, rolling)
    along = vy * ox - vx * oy
    rolling = magnitude(spin - along * (1.0 / compliance.track)) * bodies.radius
    slip = along + spin * bodies.radius
    T_o = creep(compliance.outer, compliance, forces, drive, OUTER, columns * OUTER + group, Q_o, slip, rolling)
    drive.sums[1] += speed_of(drive.course, drive) * drive.inner_radius * drive.dt * total(T_i)
    return T_i, T_o


@part
def creep(law, compliance, forces, drive, row, at, Q, slip, rolling):
    """Tractions of eight contacts, N, and what they dissipate. Nine arguments: registers of one contact."""
    last, soft, dt = load(forces.traction, at), compliance.tangential[row], drive.dt
    full_slip = larger(drive.friction * law.curvature * root(law.half_width_factor * Q) * rolling, SLIP_FLOOR)
    free = slip - last * (soft / dt)
    T, left = creep_traction(free, drive.friction * Q, full_slip, soft / dt)
    T, left = select(Q > 0.0, -T, 0.0), select(Q > 0.0, left, free)
    store(forces.traction, at, T)
    drive.sums[2] -= 0.5 * dt * total((T + last) * left)
    return T


@part
def press_neighbours(bodies, compliance, forces, drive, before, reach):
    """Contacts of rollers with the next ones: their forces and tractions as kicks; seldom any are near."""
    columns, n, law = bodies.columns, bodies.n, compliance.between
    over, centre, velocity = drive.dt / bodies.mass, bodies.centre, bodies.velocity
    for group in range(0, n, WIDTH):
        i, at = next_rollers(group, n), NEXT * columns + group
        x, y = gather(centre, i) - load(centre, group), gather(centre, i + columns) - load(centre, columns + group)
        square = x * x + y * y
        near = (square <= reach * reach) & (count_from(group) < n)
        if not any_lane(near):
            store(forces.force, at, splat(0.0))
            store(forces.kick, at, splat(0.0))
            store(forces.approach, at, splat(np.nan))
            store(forces.traction, at, splat(0.0))
            no_dampers(forces.dampers, at)
            continue
        distance = select(near, root(square), 1.0)
        nx, ny = x / distance, y / distance
        approach = select(near, 2.0 * bodies.radius - distance, -1.0)
        Q = contact_force(approach, law.A, law.B, law.Q_line, load(forces.force, at))
        P, residual = kick_force(
            load(forces.approach, at), load(forces.force, at), law.B, load(forces.kick, at), load(forces.residual, at),
            approach, Q, law.B, law.A, law.Q_line,
        )  # fmt: skip
        P = select(near, P, 0.0)
        T = splat(0.0)
        if drive.friction > 0.0:
            slip = (gather(before.velocity, i + columns) - load(before.velocity, columns + group)) * nx
            slip -= (gather(before.velocity, i) - load(before.velocity, group)) * ny
            slip -= (gather(before.spin, i) + load(before.spin, group)) * bodies.radius
            T = creep(law, compliance, forces, drive, NEXT, at, Q, slip, splat(0.0))
        store(forces.fastest, 0, larger(load(forces.fastest, 0), magnitude(Q - load(forces.force, at))))
        store(forces.force, at, Q)
        store(forces.approach, at, select(near, approach, np.nan))
        store(forces.kick, at, P)
        store(forces.residual, at, residual)
        closing = (load(before.velocity, group) - gather(before.velocity, i)) * nx
        closing += (load(before.velocity, columns + group) - gather(before.velocity, i + columns)) * ny
        P = damped_neighbours(forces.dampers, law, at, select(near, Q, 0.0), P, closing, 2.0 * over)
        fx, fy = (P * nx - T * ny) * over, (P * ny + T * nx) * over
        turned = T * (-drive.dt * bodies.radius / bodies.inertia)
        fx, fy, turned = select(near, fx, 0.0), select(near, fy, 0.0), select(near, turned, 0.0)
        scatter_add(velocity, i, fx)
        scatter_add(velocity, i + columns, fy)
        scatter_add(bodies.spin, i, turned)
        store(velocity, group, load(velocity, group) - fx)
        store(velocity, columns + group, load(velocity, columns + group) - fy)
        store(bodies.spin, group, load(bodies.spin, group) + turned)
