"""Dampers of the reduced model's contacts: beside the whole approach, implicit in all bodies' velocities together.

A damper's force is that at the middle of a kick, F = c·½ (δ̇ before + δ̇ after), which every other one changes through
the hub: rollers are eliminated, two equations of the hub's velocity are left.
"""

from fem.kernels.jit import part
from fem.kernels.lane_functions import larger, logarithm, smaller
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, count_from, select, splat, total
from fem.kernels.law import STEEPEST
from fem.kernels.reduced_housing import push_ring, ring_rates
from fem.kernels.reduced_state import INNER, OUTER
from fem.kernels.sample_kernels import DAMPED_BY_BODIES, DAMPED_BY_CONTACTS, DISSIPATED, N_SCALARS


@part
def damping_coefficient(dampers, law, Q):
    """N s/m, of eight contacts under forces of their laws, N; 0 of open ones."""
    closed = Q > 0.0
    soft = law.A * larger(law.B - 0.5 * logarithm(select(closed, smaller(Q, law.Q_line), 1.0)) - 0.5, STEEPEST)
    found = dampers.constant + dampers.time / soft + 1.5 * dampers.hunt_crossley * Q
    return select(closed, found, 0.0)


@part
def note_lowered(dampers, columns, group, inner, outer, dt):
    """How fast eight rollers' approaches grow because of surfaces that pass; `inner`, `outer`: m, what these take."""
    if dampers is not None:
        for at, now in ((group, inner), (columns + group, outer)):
            last = load(dampers.lowered, at)
            store(dampers.passing, at, select(last != last, 0.0, (now - last) * (1.0 / dt)))
            store(dampers.lowered, at, now)


@part
def no_dampers(dampers, at):
    """Eight contacts out of reach."""
    if dampers is not None:
        store(dampers.force, at, splat(0.0))


@part
def with_damper(dampers, at, force):
    """Forces of eight contacts with those that their dampers had last, N."""
    if dampers is None:
        return force
    return force + load(dampers.force, at)


@part
def damped_neighbours(dampers, law, at, Q, P, rate, mobility_dt):
    """Kicks of eight contacts of two rollers, N, with their dampers'; `rate` : m/s, at which they close before."""
    if dampers is None:
        return P
    c = damping_coefficient(dampers, law, Q)
    half = 0.5 * mobility_dt
    F = larger(c * (rate - half * P) / (1.0 + c * half), -P)
    F = select(Q > 0.0, F, 0.0)
    store(dampers.force, at, F)
    store(dampers.pair_work, 0, load(dampers.pair_work, 0) + F * (rate - half * (P + F)))
    return P + F


@part
def damp_contacts(dampers, bodies, compliance, forces, before, dt):
    """Forces of all dampers of raceways' contacts and their kicks; None: there are none."""
    if dampers is not None:
        dampers.work[0] += dampers.work[1]
        x, y = _find(dampers, bodies, compliance, forces, before, dt)
        _give(dampers, bodies, forces, before, dt, x, y)


@part
def _rates(dampers, bodies, forces, hub, velocity, group, ring):
    """Rates at which eight rollers' contacts close, m/s, inner and outer, at velocities (2, columns), and a ring's."""
    columns = bodies.columns
    vx, vy = load(velocity, group), load(velocity, columns + group)
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    inner = load(dampers.passing, group) - (vx - hub[0]) * ix - (vy - hub[1]) * iy
    return inner, load(dampers.passing, columns + group) + (vx - ring[0]) * ox + (vy - ring[1]) * oy


@part
def _find(dampers, bodies, compliance, forces, before, dt):
    """What the dampers change of the hub's velocity, m/s; the forces they would have without that in `force`."""
    columns, half, over = bodies.columns, 0.5 * dt / bodies.mass, dt / bodies.hub_mass
    push_x, push_y, xx, xy, yy = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    past, next_ = ring_rates(bodies.housing)
    for group in range(0, bodies.n, WIDTH):
        there = count_from(group) < bodies.n
        ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        c_i = damping_coefficient(dampers, compliance.inner, select(there, load(forces.force, group), 0.0))
        c_o = damping_coefficient(dampers, compliance.outer, select(there, load(forces.force, columns + group), 0.0))
        was_i, was_o = _rates(dampers, bodies, forces, before.hub_velocity, before.velocity, group, past)
        now_i, now_o = _rates(dampers, bodies, forces, bodies.hub_velocity, bodies.velocity, group, next_)
        rate_i, rate_o = 0.5 * (was_i + now_i), 0.5 * (was_o + now_o)
        facing, h_i, h_o = ix * ox + iy * oy, c_i * half, c_o * half
        share = 1.0 / ((1.0 + h_i) * (1.0 + h_o) - h_i * h_o * facing * facing)
        alone = ((1.0 + h_o) * c_i * rate_i + h_i * facing * c_o * rate_o) * share
        gain = 0.5 * c_i * (1.0 + h_o) * share
        store(dampers.force, group, alone)
        store(dampers.gain, group, gain)
        store(dampers.coefficient, columns + group, c_o)
        store(dampers.rate, group, rate_i)
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
def _give(dampers, bodies, forces, before, dt, hub_x, hub_y):
    """The dampers' kicks and the work they take; `hub_` : m/s, what the hub's velocity changes by."""
    columns, half, over = bodies.columns, 0.5 * dt / bodies.mass, dt / bodies.mass
    push_x, push_y, work, first = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    ring_x, ring_y = splat(0.0), splat(0.0)
    past, _ = ring_rates(bodies.housing)
    for group in range(0, bodies.n, WIDTH):
        there, at = count_from(group) < bodies.n, columns + group
        ix, iy = load(forces.normal, group), load(forces.normal, at)
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        facing, c_o = ix * ox + iy * oy, load(dampers.coefficient, at)
        F_i = load(dampers.force, group) + load(dampers.gain, group) * (hub_x * ix + hub_y * iy)
        F_i = select(there & (load(forces.force, group) > 0.0), larger(F_i, -load(forces.kick, group)), 0.0)
        F_o = c_o * (load(dampers.rate, at) + half * facing * F_i) / (1.0 + c_o * half)
        F_o = select(there & (load(forces.force, at) > 0.0), larger(F_o, -load(forces.kick, at)), 0.0)
        store(dampers.force, group, F_i)
        store(dampers.force, at, F_o)
        was_i, was_o = _rates(dampers, bodies, forces, before.hub_velocity, before.velocity, group, past)
        work += F_i * (load(dampers.rate, group) - half * (F_i - facing * F_o))
        work += F_o * (load(dampers.rate, at) - half * (F_o - facing * F_i))
        first += F_i * was_i + F_o * was_o
        push_x -= F_i * ix
        push_y -= F_i * iy
        ring_x += F_o * ox
        ring_y += F_o * oy
        store(bodies.velocity, group, load(bodies.velocity, group) + over * (F_i * ix - F_o * ox))
        store(bodies.velocity, at, load(bodies.velocity, at) + over * (F_i * iy - F_o * oy))
    over = dt / bodies.hub_mass
    x, y = over * total(push_x), over * total(push_y)
    bodies.hub_velocity[0] += x
    bodies.hub_velocity[1] += y
    taken = dt * total(work) - 0.5 * bodies.hub_mass * (x * x + y * y) + dt * total(load(dampers.pair_work, 0))
    taken -= push_ring(bodies.housing, total(ring_x), total(ring_y), dt)
    store(dampers.pair_work, 0, splat(0.0))
    dampers.work[0] += 0.5 * dt * total(first)
    dampers.work[1] = taken - 0.5 * dt * total(first)


@part
def write_damping(dampers, n, out):
    """What contacts have damped, J, and the dampers' forces, N: see `sample_kernels.add_damper_forces`."""
    out[DAMPED_BY_CONTACTS] = out[DAMPED_BY_BODIES] = 0.0
    if dampers is None:
        return
    out[DAMPED_BY_CONTACTS] = dampers.work[0]
    out[DISSIPATED] += dampers.work[0]
    for j in range(n):
        at = N_SCALARS + j
        for row in range(3):
            out[at + (4 + row) * n] = max(out[at + (4 + row) * n] + dampers.force[row, j], 0.0)
        for row in (INNER, OUTER):
            out[at + (9 + row) * n] = dampers.force[row, j]
