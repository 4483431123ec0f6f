"""FRICTION of rigid bodies' contacts; contacts of rollers with each other, forces and tractions.

A contact's tangential compliance takes what its bodies slip in a step but for Carter's creep.
"""

import numpy as np

from fem.kernels import lanes
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.kernels.drive import SPEED, speed_of
from fem.kernels.jit import part
from fem.kernels.lane_functions import logarithm, maximum, minimum, next_rollers
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, gather, load, select, splat, store, total
from fem.kernels.law import SLIP_FLOOR, STEEPEST, contact_force, creep_traction, damping_coefficient, kick_force
from fem.kernels.mounts import ring_rates
from fem.kernels.rigid.state import normals

TOUCHING = 1.05  # over a roller's diameter: centres further apart are out of each other's reach


@part
def tractions(step, group, Q_i, Q_o):
    """Tractions of eight rollers, N, on them along +θ: elastic up to Carter's creep.

    A contact's tangential compliance takes what the bodies slip in a step but for its creep. The slip is that on the
    way here, so tractions are springs like the normal forces, and no contact's depends on another's.
    """
    bodies, contacts, forces, drive, before = step.bodies, step.contacts, step.forces, step.drive, step.before
    columns, hub_x, hub_y = bodies.columns, before.hub_velocity[0], before.hub_velocity[1]
    vx, vy = load(before.velocity, group), load(before.velocity, columns + group)
    spin, soft = load(before.spin, group), contacts.coupling.tangential
    ix, iy, ox, oy = normals(forces, group, columns)
    along = vy * ix - vx * iy
    slip = along - (hub_y * ix - hub_x * iy)
    slip -= spin * bodies.radius + speed_of(drive) * drive.inner_radius
    rolling = absolute(spin - along * (1.0 / contacts.reach)) * bodies.radius
    T_i = _creep(contacts.inner, soft[INNER], forces, drive, columns * INNER + group, Q_i, slip, rolling)
    ring_x, ring_y = ring_rates(bodies.housing)[1]  # its kick is yet to come
    along = (vy - ring_y) * ox - (vx - ring_x) * oy
    rolling = absolute(spin - along * (1.0 / contacts.track)) * bodies.radius
    slip, outer = along + spin * bodies.radius, None if drive.history is None else drive.history.outer
    if outer is not None:
        slip = slip - outer.now[SPEED] * outer.radius
    T_o = _creep(contacts.outer, soft[OUTER], forces, drive, columns * OUTER + group, Q_o, slip, rolling)
    drive.sums[1] += speed_of(drive) * drive.inner_radius * drive.dt * total(T_i)
    if outer is not None:
        drive.sums[1] += outer.now[SPEED] * outer.radius * drive.dt * total(T_o)
    return T_i, T_o


@part
def _creep(law, soft, forces, drive, at, Q, slip, rolling):
    """Tractions of eight contacts, N, and what they dissipate; `soft` : m/N, of contacts that stick."""
    last, dt = load(forces.traction, at), drive.dt
    half_width = lanes.square_root(law.half_width_factor * Q)
    full_slip = maximum(drive.friction * law.curvature * half_width * rolling, SLIP_FLOOR)
    free = slip - last * (soft / dt)
    T, left = creep_traction(free, drive.friction * Q, full_slip, soft / dt)
    T, left = select(Q > 0.0, -T, 0.0), select(Q > 0.0, left, free)
    store(forces.traction, at, T)
    drive.sums[2] -= 0.5 * dt * total((T + last) * left)
    return T


@part
def coefficient(dampers, law, Q):
    """N s/m, of the dampers of eight contacts under forces of their laws, N; 0 of open ones."""
    closed = Q > 0.0
    soft = law.A * maximum(law.B - 0.5 * logarithm(select(closed, minimum(Q, law.Q_line), 1.0)) - 0.5, STEEPEST)
    return select(closed, damping_coefficient(dampers.law, Q, 1.0 / soft), 0.0)


@part
def press_neighbours(step):
    """Contacts of rollers with the next ones: their forces and tractions as kicks; seldom any are near."""
    bodies, coupling, forces, drive, before = step.bodies, step.contacts.coupling, step.forces, step.drive, step.before
    columns, n, law, reach = bodies.columns, bodies.n, coupling.between, 2.0 * bodies.radius * TOUCHING
    over, centre, velocity = drive.dt / bodies.mass, bodies.centre, bodies.velocity
    for group in range(0, n, WIDTH):
        i, at = next_rollers(group, n), ROLLER * columns + group
        x, y = gather(centre, i) - load(centre, group), gather(centre, i + columns) - load(centre, columns + group)
        square = x * x + y * y
        near = (square <= reach * reach) & (count_from(group) < n)
        if not any_lane(near):
            store(forces.force, at, splat(0.0))
            store(forces.kick, at, splat(0.0))
            store(forces.approach, at, splat(np.nan))
            store(forces.traction, at, splat(0.0))
            if forces.dampers is not None:
                store(forces.dampers.force, at, splat(0.0))
            continue
        distance = select(near, lanes.square_root(square), 1.0)
        nx, ny = x / distance, y / distance
        approach = select(near, 2.0 * bodies.radius - distance, -1.0)
        Q_before = load(forces.force, at)
        Q = contact_force(approach, law.A, law.B, law.Q_line, Q_before)
        last = load(forces.approach, at), Q_before, law.B, load(forces.kick, at), load(forces.residual, at)
        P, residual = kick_force((law.A, law.Q_line), last, (approach, Q, law.B))
        P, T = select(near, P, 0.0), splat(0.0)
        if drive.friction > 0.0:
            slip = (gather(before.velocity, i + columns) - load(before.velocity, columns + group)) * nx
            slip -= (gather(before.velocity, i) - load(before.velocity, group)) * ny
            slip -= (gather(before.spin, i) + load(before.spin, group)) * bodies.radius
            T = _creep(law, coupling.tangential[ROLLER], forces, drive, at, Q, slip, splat(0.0))
        store(forces.fastest, 0, maximum(load(forces.fastest, 0), absolute(Q - Q_before)))
        store(forces.force, at, Q)
        store(forces.approach, at, select(near, approach, np.nan))
        store(forces.kick, at, P)
        store(forces.residual, at, residual)
        closing = (load(before.velocity, group) - gather(before.velocity, i)) * nx
        closing += (load(before.velocity, columns + group) - gather(before.velocity, i + columns)) * ny
        if forces.dampers is not None:
            c, half = coefficient(forces.dampers, law, select(near, Q, 0.0)), over
            F = maximum(c * (closing - half * P) / (1.0 + c * half), -P)
            F = select(near & (Q > 0.0), F, 0.0)
            store(forces.dampers.force, at, F)
            P = P + F
        fx, fy = (P * nx - T * ny) * over, (P * ny + T * nx) * over
        turned = T * (-drive.dt * bodies.radius / bodies.inertia)
        fx, fy, turned = select(near, fx, 0.0), select(near, fy, 0.0), select(near, turned, 0.0)
        lanes.scatter_add(velocity, i, fx)
        lanes.scatter_add(velocity, i + columns, fy)
        lanes.scatter_add(bodies.spin, i, turned)
        store(velocity, group, load(velocity, group) - fx)
        store(velocity, columns + group, load(velocity, columns + group) - fy)
        store(bodies.spin, group, load(bodies.spin, group) + turned)
