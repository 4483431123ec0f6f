"""Dampers of the reduced model's contacts: beside the whole approach, implicit in all bodies' velocities together.

A damper's force is that at the middle of a kick, F = c·½ (δ̇ before + δ̇ after), which every other one changes through
the hub: rollers are eliminated, two equations of the hub's velocity are left.
"""

from fem.kernels.contact_kernels import next_rollers
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import logarithm, maximum, minimum
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, square_root, total
from fem.kernels.law import STEEPEST, damping_coefficient
from fem.kernels.prescribed_rollers import hold
from fem.kernels.reduced_housing import push_ring, ring_rates
from fem.kernels.reduced_state import INNER, NEXT, OUTER, ReducedDampers
from fem.kernels.reduced_surfaces import passing_rates, push_along
from fem.kernels.rigid_parts import change_step, kick_part, note_work, write_part
from fem.kernels.sample_kernels import (
    DAMPED_BY_CONTACTS,
    DAMPER_FORCE,
    DISSIPATED,
    FORCE,
    N_SCALARS,
)
from fem.kernels.shaft import give_way, mobility
from fem.kernels.tilted_damping import (
    find_levers,
    pair_mobility,
    turn_back,
    turn_hub_back,
    with_turning,
    with_turning_power,
    write_turning,
)


@part
def _coefficient(dampers, law, Q):
    """N s/m, of eight contacts under forces of their laws, N; 0 of open ones."""
    closed = Q > 0.0
    soft = law.A * maximum(law.B - 0.5 * logarithm(select(closed, minimum(Q, law.Q_line), 1.0)) - 0.5, STEEPEST)
    return select(closed, damping_coefficient(dampers.law, Q, 1.0 / soft), 0.0)


@verb
def damping_coefficients(compliance, dampers, forces, columns, group, there):
    """The same of eight rollers' inner and outer contacts."""
    c_i = _coefficient(dampers, compliance.inner, select(there, load(forces.force, group), 0.0))
    return c_i, _coefficient(dampers, compliance.outer, select(there, load(forces.force, columns + group), 0.0))


@part
def no_dampers(dampers, at):
    """Eight contacts out of reach."""
    if dampers is not None:
        store(dampers.force, at, splat(0.0))


@part
def damped_neighbours(dampers, law, at, Q, P, rate, mobility_dt):
    """Kicks of eight contacts of two rollers, N, with their dampers'; `rate` : m/s, at which they close before."""
    if dampers is None:
        return P
    c = _coefficient(dampers, law, Q)
    half = 0.5 * mobility_dt
    F = maximum(c * (rate - half * P) / (1.0 + c * half), -P)
    F = select(Q > 0.0, F, 0.0)
    store(dampers.force, at, F)
    return P + F


@kick_part.of(ReducedDampers)
def _kick(dampers, step, push):
    """Forces of all dampers of raceways' contacts and their kicks, after which rays hold rollers once more."""
    bodies, forces, before, drive = step.bodies, step.forces, step.before, step.drive
    dampers.work[0] += dampers.work[1]
    x, y = _find(dampers, bodies, step.compliance, forces, before, drive)
    _give(dampers, bodies, forces, before, drive, x, y)
    hold(bodies.prescribed, bodies, drive, step.time)


@part
def _closing(bodies, forces, drive, group, motion):
    """Rates at which eight rollers' contacts close, m/s, inner and outer; `motion` : see `passing_rates`."""
    columns = bodies.columns
    hub, velocity, _, ring = motion
    vx, vy = load(velocity, group), load(velocity, columns + group)
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    inner, outer = passing_rates(forces.slope, bodies, forces, drive, group, motion)
    inner -= (vx - hub[0]) * ix + (vy - hub[1]) * iy
    return inner, outer + (vx - ring[0]) * ox + (vy - ring[1]) * oy


@part
def _motions(bodies, before):
    """Before the kick and at the velocities so far: see `passing_rates`."""
    past, next_ = ring_rates(bodies.housing)
    was = before.hub_velocity, before.velocity, before.spin, past
    return was, (bodies.hub_velocity, bodies.velocity, bodies.spin, next_)


@part
def _power(dampers, bodies, forces, drive, group, motion, after):
    """What eight rollers' dampers take at velocities before (False) or after a kick, W."""
    inner, outer = _closing(bodies, forces, drive, group, motion)
    F_i, F_o = load(dampers.force, group), load(dampers.force, bodies.columns + group)
    power = F_i * inner + F_o * outer
    F = load(dampers.force, NEXT * bodies.columns + group)
    if any_lane(F != 0.0):
        power += select(F != 0.0, F * _closing_on_next(bodies, group, motion[1]), 0.0)
    return with_turning_power(dampers.tilted, bodies, forces, group, motion, after, power)


@part
def _closing_on_next(bodies, group, velocity):
    """Rates at which eight rollers close on the next ones, m/s."""
    i, columns, centre = next_rollers(group, bodies.n), bodies.columns, bodies.centre
    x, y = gather(centre, i) - load(centre, group), gather(centre, i + columns) - load(centre, columns + group)
    vx = load(velocity, group) - gather(velocity, i)
    vy = load(velocity, columns + group) - gather(velocity, i + columns)
    square = x * x + y * y
    return (vx * x + vy * y) / square_root(select(square > 0.0, square, 1.0))


@part
def _find(dampers, bodies, compliance, forces, before, drive):
    """What the dampers change of the hub's velocity, m/s; the forces they would have without that in `force`."""
    columns, half = bodies.columns, 0.5 * drive.dt / bodies.mass
    over = mobility(bodies.shaft, bodies.hub_mass, drive.dt)
    push_x, push_y, xx, xy, yy = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        there = count_from(group) < bodies.n
        ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        c_i, c_o = damping_coefficients(compliance, dampers, forces, columns, group, there)
        find_levers(dampers.tilted, forces, columns, group, c_i, c_o)
        motions = _motions(bodies, before)
        was = _closing(bodies, forces, drive, group, motions[0])
        now = _closing(bodies, forces, drive, group, motions[1])
        facing, h_i, h_o = ix * ox + iy * oy, c_i * half, c_o * half
        rates = 0.5 * (was[0] + now[0]), 0.5 * (was[1] + now[1])
        rate_i, rate_o = with_turning(dampers.tilted, bodies, forces, drive, group, motions, facing, rates)
        own_i, own_o, other = pair_mobility(dampers.tilted, bodies, drive.dt, group, facing)
        own_i, own_o = 1.0 + h_i * own_i, 1.0 + h_o * own_o
        share = 1.0 / (own_i * own_o - h_i * h_o * other * other)
        alone = (own_o * c_i * rate_i + h_i * other * c_o * rate_o) * share
        gain = 0.5 * c_i * own_o * share
        store(dampers.force, group, alone)
        store(dampers.gain, group, gain)
        store(dampers.coefficient, columns + group, c_o)
        store(dampers.rate, columns + group, rate_o)
        push_x -= select(there, alone * ix, 0.0)
        push_y -= select(there, alone * iy, 0.0)
        xx += select(there, gain * ix * ix, 0.0)
        xy += select(there, gain * ix * iy, 0.0)
        yy += select(there, gain * iy * iy, 0.0)
    a, b, d = 1.0 + over * total(xx), over * total(xy), 1.0 + over * total(yy)
    x, y = over * total(push_x), over * total(push_y)
    size = a * d - b * b
    return (d * x - b * y) / size, (a * y - b * x) / size


@part
def _give(dampers, bodies, forces, before, drive, hub_x, hub_y):
    """The dampers' kicks; `hub_` : m/s, what the hub's velocity changes by."""
    columns, half, over = bodies.columns, 0.5 * drive.dt / bodies.mass, drive.dt / bodies.mass
    push_x, push_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        there, at = count_from(group) < bodies.n, columns + group
        ix, iy = load(forces.normal, group), load(forces.normal, at)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        facing, c_o = ix * ox + iy * oy, load(dampers.coefficient, at)
        F_i = load(dampers.force, group) + load(dampers.gain, group) * (hub_x * ix + hub_y * iy)
        F_i = select(there & (load(forces.force, group) > 0.0), maximum(F_i, -load(forces.kick, group)), 0.0)
        _, own, other = pair_mobility(dampers.tilted, bodies, drive.dt, group, facing)
        F_o = c_o * (load(dampers.rate, at) + half * other * F_i) / (1.0 + c_o * half * own)
        F_o = select(there & (load(forces.force, at) > 0.0), maximum(F_o, -load(forces.kick, at)), 0.0)
        store(dampers.force, group, F_i)
        store(dampers.force, at, F_o)
        T_i, T_o = push_along(forces.slope, bodies, forces, drive, group, (F_i, F_o), (splat(0.0), splat(0.0)))
        motions, given = _motions(bodies, before), (F_i, F_o, T_i)
        T_i = turn_back(dampers.tilted, bodies, forces, drive, group, motions, facing, given)
        by_hub_x, by_hub_y = F_i * ix - T_i * iy, F_i * iy + T_i * ix
        by_ring_x, by_ring_y = F_o * ox + T_o * oy, F_o * oy - T_o * ox
        push_x -= by_hub_x
        push_y -= by_hub_y
        ring_x += by_ring_x
        ring_y += by_ring_y
        store(bodies.velocity, group, load(bodies.velocity, group) + over * (by_hub_x - by_ring_x))
        store(bodies.velocity, at, load(bodies.velocity, at) + over * (by_hub_y - by_ring_y))
    over = mobility(bodies.shaft, bodies.hub_mass, drive.dt)
    gained = over * total(push_x), over * total(push_y)
    for k in range(2):
        bodies.hub_velocity[k] += gained[k]
        give_way(bodies.shaft, k, gained[k])
    push_ring(bodies.housing, total(ring_x), total(ring_y), drive.dt)
    turn_hub_back(dampers.tilted, bodies, forces, drive)


@note_work.of(ReducedDampers)
def _note(dampers, step):
    """Add the work of the dampers: their forces along the approach, at the mean of the velocities before and after."""
    bodies, first = step.bodies, splat(0.0)
    was, now = _motions(bodies, step.before)
    for group in range(0, bodies.n, WIDTH):
        first += 0.5 * _power(dampers, bodies, step.forces, step.drive, group, was, False)
    dampers.work[0] += step.drive.dt * total(first)
    dampers.work[1] = _work_ahead(dampers, bodies, step.forces, step.drive, now)


@part
def _work_ahead(dampers, bodies, forces, drive, now):
    """What dampers take in the half step ahead, J."""
    work = splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        work += 0.5 * _power(dampers, bodies, forces, drive, group, now, True)
    return drive.dt * total(work)


@change_step.of(ReducedDampers)
def _change(dampers, step, change):
    now = _motions(step.bodies, step.before)[1]
    dampers.work[1] = _work_ahead(dampers, step.bodies, step.forces, change.drive, now)


@write_part.of(ReducedDampers)
def _write(dampers, step, out):
    """What contacts have damped, J, and the dampers' forces, N: see `sample_kernels.add_damper_forces`."""
    n = step.bodies.n
    out[DAMPED_BY_CONTACTS] = dampers.work[0]
    out[DISSIPATED] += dampers.work[0]
    for j in range(n):
        at = N_SCALARS + j
        for row in range(3):
            out[at + (FORCE + row) * n] = max(out[at + (FORCE + row) * n] + dampers.force[row, j], 0.0)
        for row in (INNER, OUTER):
            out[at + (DAMPER_FORCE + row) * n] = dampers.force[row, j]
    write_turning(dampers.tilted, step.bodies, out)
