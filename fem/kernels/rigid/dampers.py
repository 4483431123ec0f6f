"""Dampers of rigid bodies' contacts: beside the whole approach, implicit in all bodies' velocities together.

A damper's force is that at the middle of a kick, F = c·½ (δ̇ before + δ̇ after), which every other one changes through
the hub: rollers are eliminated, two equations of the hub's velocity are left.

Where rollers tilt, dampers are in proportion to the second derivatives of a contact's energy. A contact of the
coefficient c and the stiffness K = ∂Q/∂δ damps by c/K ∂²U/∂(δ, ψ)²: by c on δ̇ + z ψ̇ at the lever z = ∂Q/∂ψ/K, and by
g = c/K (−∂M/∂ψ − z² K) on ψ̇ alone. The rollers' tilts are implicit as their centres are; the hub's slope is explicit,
whose inertia is so much larger. Equation (6) of docs/tilted_motion.md.
"""

from fem.kernels import columns
from fem.kernels.columns import INNER, N_SCALARS, OUTER, ROLLER
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair, maximum, minimum, next_rollers, store_pair
from fem.kernels.lanes import WIDTH, any_lane, count_from, gather, load, select, splat, square_root, store, total
from fem.kernels.law import damping_coefficient
from fem.kernels.mounts import mobility, push_mounted, ring_rates
from fem.kernels.rigid.contacts import met_of
from fem.kernels.rigid.friction import coefficient
from fem.kernels.rigid.rays import hold
from fem.kernels.rigid.state import CROSS, normals
from fem.kernels.rigid.surfaces import passing_rates, push_along


@part
def damp(dampers, step):
    """Forces of all dampers of raceways' contacts and their kicks, after which rays hold rollers once more."""
    dampers.work[0] += dampers.work[1]
    x, y = _find(dampers, step)
    _give(dampers, step, x, y)
    hold(step.bodies.prescribed, step.bodies, step.drive, step.time)


@part
def _coefficients(dampers, step, group, there):
    """N s/m, of eight rollers' inner and outer contacts; 0 of open ones."""
    contacts, forces, columns = step.contacts, step.forces, step.bodies.columns
    Q_i, Q_o = load_pair(forces.force, group, columns)
    if contacts.coupling is not None:
        if contacts.tilted is None:
            c_i = coefficient(dampers, contacts.inner, select(there, Q_i, 0.0))
            return c_i, coefficient(dampers, contacts.outer, select(there, Q_o, 0.0))
    stiff_i, stiff_o = load_pair(forces.stiffness, group, columns)
    c_i, c_o = damping_coefficient(dampers.law, Q_i, stiff_i), damping_coefficient(dampers.law, Q_o, stiff_o)
    return select(there & (Q_i > 0.0), c_i, 0.0), select(there & (Q_o > 0.0), c_o, 0.0)


@part
def _closing(step, group, motion):
    """Rates at which eight rollers' contacts close, m/s, inner and outer; `motion` : see `passing_rates`."""
    columns, forces, (hub, velocity, _, ring) = step.bodies.columns, step.forces, motion
    vx, vy = load_pair(velocity, group, columns)
    ix, iy, ox, oy = normals(forces, group, columns)
    inner, outer = passing_rates(step, group, motion)
    inner -= (vx - hub[0]) * ix + (vy - hub[1]) * iy
    return inner, outer + (vx - ring[0]) * ox + (vy - ring[1]) * oy


@part
def _motions(bodies, before):
    """Before the kick and at the velocities so far: see `passing_rates`."""
    past, next_ = ring_rates(bodies.housing)
    was = before.hub_velocity, before.velocity, before.spin, past
    return was, (bodies.hub_velocity, bodies.velocity, bodies.spin, next_)


@part
def _find(dampers, step):
    """What the dampers change of the hub's velocity, m/s; the forces they would have without that in `force`."""
    bodies, forces, drive = step.bodies, step.forces, step.drive
    columns, half = bodies.columns, 0.5 * drive.dt / bodies.mass
    over = mobility(bodies.shaft, bodies.hub_mass, drive.dt)
    push_x, push_y, xx, xy, yy = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        there = count_from(group) < bodies.n
        ix, iy, ox, oy = normals(forces, group, columns)
        c_i, c_o = _coefficients(dampers, step, group, there)
        if dampers.tilted is not None:
            levers, turning = dampers.tilted.lever, dampers.tilted.turning
            stiff_i, stiff_o = load_pair(forces.stiffness, group, columns)
            z_i, z_o = met_of(forces, CROSS, columns, group)
            tilt_i, tilt_o = load_pair(forces.tilted.stiffness, group, columns)
            over_i = select(c_i > 0.0, 1.0 / select(c_i > 0.0, stiff_i, 1.0), 0.0)
            over_o = select(c_o > 0.0, 1.0 / select(c_o > 0.0, stiff_o, 1.0), 0.0)
            z_i, z_o = z_i * over_i, z_o * over_o
            g_i, g_o = c_i * (tilt_i * over_i - z_i * z_i), c_o * (tilt_o * over_o - z_o * z_o)
            store_pair(levers, group, columns, z_i, z_o)
            store_pair(turning, group, columns, maximum(g_i, 0.0), maximum(g_o, 0.0))
        motions = _motions(bodies, step.before)
        was, now = _closing(step, group, motions[0]), _closing(step, group, motions[1])
        facing, h_i, h_o = ix * ox + iy * oy, c_i * half, c_o * half
        rate_i, rate_o = 0.5 * (was[0] + now[0]), 0.5 * (was[1] + now[1])
        if dampers.tilted is not None:  # at levers of tilt too
            turned, gone = _mean_turning(dampers.tilted, step, group, motions, facing, splat(0.0))
            z_i, z_o = load_pair(dampers.tilted.lever, group, columns)
            rate_i, rate_o = rate_i + z_i * (turned * facing - gone), rate_o - z_o * turned
        own_i, own_o, other = _pair_mobility(dampers.tilted, bodies, drive.dt, group, facing)
        own_i, own_o = 1.0 + h_i * own_i, 1.0 + h_o * own_o
        share = 1.0 / (own_i * own_o - h_i * h_o * other * other)
        alone = (own_o * c_i * rate_i + h_i * other * c_o * rate_o) * share
        gain = 0.5 * c_i * own_o * share
        store(dampers.force, group, alone)
        store(dampers.gain, group, gain)
        store(dampers.coefficient, columns + group, c_o)
        store(dampers.rate, columns + group, rate_o)
        push_x, push_y = push_x - select(there, alone * ix, 0.0), push_y - select(there, alone * iy, 0.0)
        xx += select(there, gain * ix * ix, 0.0)
        xy += select(there, gain * ix * iy, 0.0)
        yy += select(there, gain * iy * iy, 0.0)
    a, b, d = 1.0 + over * total(xx), over * total(xy), 1.0 + over * total(yy)
    x, y = over * total(push_x), over * total(push_y)
    size = a * d - b * b
    return (d * x - b * y) / size, (a * y - b * x) / size


@part
def _give(dampers, step, hub_x, hub_y):
    """The dampers' kicks; `hub_` : m/s, what the hub's velocity changes by."""
    bodies, forces, drive, tilted = step.bodies, step.forces, step.drive, dampers.tilted
    columns, half, over = bodies.columns, 0.5 * drive.dt / bodies.mass, drive.dt / bodies.mass
    push_x, push_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    on_x, on_y = splat(0.0), splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        there, at = count_from(group) < bodies.n, columns + group
        ix, iy, ox, oy = normals(forces, group, columns)
        facing, c_o = ix * ox + iy * oy, load(dampers.coefficient, at)
        F_i = load(dampers.force, group) + load(dampers.gain, group) * (hub_x * ix + hub_y * iy)
        F_i = select(there & (load(forces.force, group) > 0.0), maximum(F_i, -load(forces.kick, group)), 0.0)
        _, own, other = _pair_mobility(tilted, bodies, drive.dt, group, facing)
        F_o = c_o * (load(dampers.rate, at) + half * other * F_i) / (1.0 + c_o * half * own)
        F_o = select(there & (load(forces.force, at) > 0.0), maximum(F_o, -load(forces.kick, at)), 0.0)
        store_pair(dampers.force, group, columns, F_i, F_o)
        T_i, T_o = push_along(step, group, (F_i, F_o), (splat(0.0), splat(0.0)))
        if tilted is not None:  # moments kick tilts, and push along slopes across normals
            tilts = bodies.tilts
            z_i, z_o = load_pair(tilted.lever, group, columns)
            near, far = z_i * F_i, z_o * F_o
            motions = _motions(bodies, step.before)
            turned, gone = _mean_turning(tilted, step, group, motions, facing, far - near * facing)
            M_i = _moment(tilted, forces, group, F_i, near, turned * facing - gone)
            M_o = _moment(tilted, forces, at, F_o, far, -turned)
            store(tilts.rate, group, load(tilts.rate, group) + (M_i * facing - M_o) * (drive.dt / tilts.inertia))
            T_i = T_i + M_i * (tilts.slope[0] * iy - tilts.slope[1] * ix) * tilted.over_reach
            moment = select(there, M_i, 0.0)
            on_x, on_y = on_x - moment * ix, on_y - moment * iy
        by_hub_x, by_hub_y = F_i * ix - T_i * iy, F_i * iy + T_i * ix
        by_ring_x, by_ring_y = F_o * ox + T_o * oy, F_o * oy - T_o * ox
        push_x, push_y = push_x - by_hub_x, push_y - by_hub_y
        ring_x, ring_y = ring_x + by_ring_x, ring_y + by_ring_y
        vx, vy = load_pair(bodies.velocity, group, columns)
        store_pair(
            bodies.velocity, group, columns, vx + over * (by_hub_x - by_ring_x), vy + over * (by_hub_y - by_ring_y)
        )
    housing = bodies.housing
    push_mounted(bodies.shaft, bodies.hub_velocity, bodies.hub_mass, total(push_x), total(push_y), drive.dt)
    if housing is not None:
        push_mounted(housing, housing.velocity, housing.mass, total(ring_x), total(ring_y), drive.dt)
    if tilted is not None:
        bodies.tilts.slope_rate[0] += drive.dt * bodies.tilts.hub_over * total(on_x)
        bodies.tilts.slope_rate[1] += drive.dt * bodies.tilts.hub_over * total(on_y)


@part
def note_damped(dampers, step):
    """Add the work of the dampers: their forces along the approach, at the mean of the velocities before and after."""
    was, now = _motions(step.bodies, step.before)
    dampers.work[0] += _work(dampers, step, was, False, step.drive.dt)
    dampers.work[1] = _work(dampers, step, now, True, step.drive.dt)


@part
def change_damped(dampers, step, change):
    now = _motions(step.bodies, step.before)[1]
    dampers.work[1] = _work(dampers, step, now, True, change.drive.dt)


@part
def _work(dampers, step, motion, after, dt):
    """What dampers take in the half step at velocities before (False) or after a kick, J."""
    bodies, forces, tilted, work = step.bodies, step.forces, dampers.tilted, splat(0.0)
    columns, tilts = bodies.columns, bodies.tilts
    for group in range(0, bodies.n, WIDTH):
        inner, outer = _closing(step, group, motion)
        F_i, F_o = load_pair(dampers.force, group, columns)
        power = F_i * inner + F_o * outer
        F = load(dampers.force, ROLLER * columns + group)
        if any_lane(F != 0.0):  # rates at which rollers close on the next ones
            i, velocity, centre = next_rollers(group, bodies.n), motion[1], bodies.centre
            x, y = gather(centre, i) - load(centre, group), gather(centre, i + columns) - load(centre, columns + group)
            vx = load(velocity, group) - gather(velocity, i)
            vy = load(velocity, columns + group) - gather(velocity, i + columns)
            square = x * x + y * y
            closing = (vx * x + vy * y) / square_root(select(square > 0.0, square, 1.0))
            power += select(F != 0.0, F * closing, 0.0)
        if tilted is not None:
            rates, slope_rate = (tilts.rate, tilts.slope_rate) if after else (tilts.before, tilts.slope_before)
            ix, iy, ox, oy = normals(forces, group, columns)
            rate, gone = load(rates, group), _gone(tilted, bodies, forces, group, motion, slope_rate)
            M_i, M_o = load_pair(tilted.moment, group, columns)
            more = M_o * rate - M_i * (rate * (ix * ox + iy * oy) - gone)
            power += select(count_from(group) < bodies.n, more, 0.0)
        work += 0.5 * power
    return dt * total(work)


@part
def write_damped(dampers, step, out):
    """What contacts have damped, J, and the dampers' forces, N: kicks never pull."""
    n, tilted = step.bodies.n, dampers.tilted
    out[columns.DAMPED_BY_CONTACTS] = dampers.work[0]
    out[columns.DISSIPATED] += dampers.work[0]
    for j in range(n):
        at = N_SCALARS + j
        for row in range(3):
            out[at + (columns.FORCE + row) * n] = max(out[at + (columns.FORCE + row) * n] + dampers.force[row, j], 0.0)
        for row in (INNER, OUTER):
            out[at + (columns.DAMPER_FORCE + row) * n] = dampers.force[row, j]
    if tilted is not None:  # moments of the dampers, by themselves and in those of the contacts, N m
        at = step.bodies.tilts.column + 2 * n
        for row in range(2):
            for j in range(n):
                out[at + row * n + j] += tilted.moment[row, j]
                out[at + 2 * n + 2 + row * n + j] = tilted.moment[row, j]


# tilt


@part
def _pair_mobility(tilted, bodies, dt, group, facing):
    """Response of eight rollers' dampers to their own forces, inner and outer, and to the other's, times the mass."""
    if tilted is None:
        return splat(1.0), splat(1.0), facing
    z_i, z_o = load_pair(tilted.lever, group, bodies.columns)
    over = bodies.mass / _held(tilted, bodies, dt, group, facing)
    near = z_i * facing
    return 1.0 + over * near * near, 1.0 + over * z_o * z_o, facing + over * near * z_o


@part
def _held(tilted, bodies, dt, group, facing):
    """Inertia of eight rollers with what their dampers of tilt take in half a step, kg m²."""
    g_i, g_o = load_pair(tilted.turning, group, bodies.columns)
    return bodies.tilts.inertia + 0.5 * dt * (g_i * facing * facing + g_o)


@part
def _mean_turning(tilted, step, group, motions, facing, push):
    """Mean tilt rate of eight rollers in a kick, rad/s, under moments of dampers at levers, N m; and of `_gone`."""
    bodies, forces, dt, tilts = step.bodies, step.forces, step.drive.dt, step.bodies.tilts
    gone = 0.5 * (_gone(tilted, bodies, forces, group, motions[0], tilts.slope_before))
    gone += 0.5 * (_gone(tilted, bodies, forces, group, motions[1], tilts.slope_rate))
    rate = 0.5 * tilts.inertia * (load(tilts.before, group) + load(tilts.rate, group))
    push = push + load(tilted.turning, group) * facing * gone
    return (rate + 0.5 * dt * push) / _held(tilted, bodies, dt, group, facing), gone


@part
def _gone(tilted, bodies, forces, group, motion, slope_rate):
    """How fast the hub's slope changes along eight inner contacts' normals, rad/s, which turn as rollers go round."""
    columns, slope, (hub, velocity, _, _) = bodies.columns, bodies.tilts.slope, motion
    ix, iy = load_pair(forces.normal, group, columns)
    aside = (load(velocity, columns + group) - hub[1]) * ix - (load(velocity, group) - hub[0]) * iy
    return slope_rate[0] * ix + slope_rate[1] * iy + (slope[1] * ix - slope[0] * iy) * aside * tilted.over_reach


@part
def _moment(tilted, forces, at, F, push, turned):
    """Moments of eight dampers, N m, that push at levers, and of tilt within what contacts press."""
    most = 0.5 * tilted.length * (load(forces.kick, at) + F)
    M = maximum(minimum(-(load(tilted.turning, at) * turned), most), -most) - push
    store(tilted.moment, at, M)
    return M
