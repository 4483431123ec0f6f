"""Tractions of rollers that may skew, slice by slice, along the pitch circle and along the axis.

A slice has the share (α + β z) d^(3/2) of the contact's force, d its depth under the profile; α and β make the shares'
force and moment the contact's, and the power stands for slices that yield to each other. Each creeps by Carter's curve
with a half-width of its own. Its slip along the pitch circle is the plane section's and z (ȧ − ḃ)·t of the axes; along
the axis it is r (w a·t + ȧ·n) + r_i (Ω b·t + ḃ·n) at the inner raceway and −r (w a·t + ȧ·n) at the outer one.

Both creeps add up as a vector, the axial one by the stiffness of a line contact along its length, 1 − ν of that across
it (antiplane strain), to tractions of at most μ times the slice's force.

Source: Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), creepage coefficients of slender contacts;
Vermeulen and Johnson, J. Appl. Mech. 31 (1964) 338 (both creeps as one vector).

Equation (6) of docs/tilted_motion.md.
"""

from fem.kernels.drive import drive_outer, less_outer, outer_of, speed_of
from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import absolute, count_from, select, splat, square_root, total
from fem.kernels.law import SLIP_FLOOR, creep_traction
from fem.kernels.reduced_housing import ring_velocity
from fem.kernels.reduced_state import INNER, OUTER

FEW = 1e-9  # of slices' spread, below which they are one


@part
def sliced_tractions(tilts, bodies, compliance, forces, drive, before, group):
    """Tractions of eight rollers, N, along +θ, and what spins them, N at their surface; moments on axes are kept.

    The slip is that on the way here, between the places of the axes then and now.
    """
    skews, columns, r, dt = tilts.skews, bodies.columns, bodies.radius, drive.dt
    at, speed, there = columns + group, speed_of(drive.history, drive), count_from(group) < bodies.n
    vx, vy, spin = load(before.velocity, group), load(before.velocity, at), load(before.spin, group)
    ax, ay, rx, ry = load(skews.axis, group), load(skews.axis, at), load(skews.rate, group), load(skews.rate, at)
    back = spin * (0.5 * skews.gyration * dt)
    rx, ry = rx + back * ry, ry - back * rx  # half turned back: see `drift_skews`
    (bx, by), (sx, sy) = tilts.slope, tilts.slope_rate
    mx, my = ax - 0.5 * dt * rx, ay - 0.5 * dt * ry

    nx, ny = load(forces.normal, group), load(forces.normal, at)
    along = vy * nx - vx * ny
    rolling = absolute(spin - along * (1.0 / compliance.reach)) * r
    slip = along - (before.hub_velocity[1] * nx - before.hub_velocity[0] * ny)
    px, py = _between(nx, ny, slip * (0.5 * dt / compliance.reach))
    turning = (ry - sy) * px - (rx - sx) * py
    across = r * (spin * (my * px - mx * py) + rx * px + ry * py)
    hx, hy = bx - 0.5 * dt * sx, by - 0.5 * dt * sy
    across += drive.inner_radius * (speed * (hy * px - hx * py) + sx * px + sy * py)
    slip -= spin * r + speed * drive.inner_radius
    T_i, zT, A = _slide(skews, compliance, forces, drive, INNER, group, (slip, turning, across, rolling))
    store(skews.slid, group, zT)
    store(skews.slid, at, A)
    to = -zT * ny, zT * nx
    aside = A * (ay * nx - ax * ny)
    on_axis = to[0] + r * A * nx, to[1] + r * A * ny
    store(skews.rubbed, 2 * columns + group, select(there, drive.inner_radius * A * nx - to[0], 0.0))
    store(skews.rubbed, 3 * columns + group, select(there, drive.inner_radius * A * ny - to[1], 0.0))
    driven = select(there, T_i - A * (by * nx - bx * ny), 0.0)
    drive.sums[1] += speed * drive.inner_radius * dt * total(driven)

    nx, ny = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    ring_x, ring_y = ring_velocity(bodies.housing)
    along = (vy - ring_y) * nx - (vx - ring_x) * ny
    rolling = absolute(spin - along * (1.0 / compliance.track)) * r
    px, py = _between(nx, ny, along * (0.5 * dt / compliance.track))
    turning = ry * px - rx * py
    across = -r * (spin * (my * px - mx * py) + rx * px + ry * py)
    slip = less_outer(outer_of(drive.history), along + spin * r)
    T_o, zT, A = _slide(skews, compliance, forces, drive, OUTER, group, (slip, turning, across, rolling))
    store(skews.slid, 2 * columns + group, zT)
    store(skews.slid, 3 * columns + group, A)
    aside -= A * (ay * nx - ax * ny)
    store(skews.rubbed, group, select(there, on_axis[0] - zT * ny - r * A * nx, 0.0))
    store(skews.rubbed, at, select(there, on_axis[1] + zT * nx - r * A * ny, 0.0))
    drive_outer(outer_of(drive.history), drive, select(there, T_o, 0.0))
    return T_i, T_o, T_o - T_i + aside


@part
def _between(nx, ny, half):
    """Normals half a step behind, which have turned by `half`, rad, since."""
    return nx + half * ny, ny - half * nx


@part
def _slide(skews, compliance, forces, drive, row, group, slip):
    """Tractions of eight contacts, N: their sums along +θ, of these times z, N m, and along the axis.

    `slip` : along the pitch circle in the middle and per z, along the axis, and the speed of rolling, m/s and 1/s
    """
    law, n, columns = compliance.inner if row == INNER else compliance.outer, skews.place.size, skews.axis.shape[1]
    (along, turning, across, rolling), there = slip, load(forces.estimate, row * columns + group) > 0.0
    across = across * skews.lateral
    soft = compliance.tangential[row] * (n / drive.dt)
    level, tilted = _shares(skews, forces, row, group)
    speed, wide = (drive.friction * law.curvature) * rolling, law.half_width_factor * n
    T, zT, A, lost = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for k in range(n):
        z, at = skews.place[k], (2 * (row * n + k)) * columns + group
        F = select(there, maximum(load(skews.share, k * columns + group) * (level + tilted * z), 0.0), 0.0)
        last, last_a = load(skews.traction, at), load(skews.traction, at + columns)
        u, v = along + turning * z - soft * last, across - soft * last_a
        free = square_root(u * u + v * v)
        full_slip = maximum(speed * square_root(wide * F), SLIP_FLOOR)
        pull, left = creep_traction(free, drive.friction * F, full_slip, soft)
        held = (F > 0.0) & (free > 0.0)
        over = 1.0 / select(held, free, 1.0)
        pull, left = select(held, pull * over, 0.0), select(held, left * over, 1.0)
        t, a = -pull * u, -pull * v
        lost += left * ((t + last) * u + (a + last_a) * v * (1.0 / skews.lateral))
        store(skews.traction, at, t)
        store(skews.traction, at + columns, a)
        T, zT, A = T + t, zT + z * t, A + a
    store(forces.traction, row * columns + group, T)
    drive.sums[2] -= 0.5 * drive.dt * total(lost)
    return T, zT, A


@part
def _shares(skews, forces, row, group):
    """Leave the depths of eight contacts' slices to the power of 3/2 in `share`; α and β of their forces by these."""
    columns = skews.axis.shape[1]
    at = row * columns + group
    Q, deep = load(forces.estimate, at), load(forces.first, at)
    slope, M = (
        load(forces.tilted.met, 4 * row * columns + group),
        load(forces.tilted.met, (4 * row + 2) * columns + group),
    )
    one, by_z, by_square = splat(0.0), splat(0.0), splat(0.0)
    for k in range(skews.place.size):
        z = skews.place[k]
        depth = maximum(deep - skews.drop[row, k] - slope * z, 0.0)
        share = depth * square_root(depth)
        store(skews.share, k * columns + group, share)
        one, by_z, by_square = one + share, by_z + share * z, by_square + share * z * z
    spread = one * by_square - by_z * by_z
    wide = spread > FEW * one * by_square
    over = 1.0 / select(wide, spread, 1.0)
    level = select(wide, (Q * by_square - M * by_z) * over, Q / select(one > 0.0, one, 1.0))
    return level, select(wide, (M * one - Q * by_z) * over, 0.0)


@part
def sliced_energy(skews, compliance, columns, row, group):
    """Elastic energy of eight contacts' tractions, J."""
    n, found = skews.place.size, splat(0.0)
    for k in range(n):
        at = (2 * (row * n + k)) * columns + group
        t, a = load(skews.traction, at), load(skews.traction, at + columns)
        found += t * t + a * a * (1.0 / skews.lateral)
    return (0.5 * n * compliance.tangential[row]) * found
