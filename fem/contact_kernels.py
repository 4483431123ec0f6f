"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.
"""

from math import atan2, cos, pi, sin, sqrt

import numpy as np
from numba import njit

from fem.patches import FIRST, N_NODES, weight_slopes, weights
from fem.ring_kernels import HALO
from fem.state import INNER, OUTER, ROLLER
from fem.subgrid import contact_force, ripple_at

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)


@njit(cache=True)
def _place(x, y, n_nodes):
    """Position, in node spacings in [0, n_nodes), of a direction in a body's frame."""
    position = atan2(y, x) * (n_nodes / (2.0 * pi))
    if position < 0.0:
        position += n_nodes
    if position >= n_nodes:
        position -= n_nodes
    return position


@njit(cache=True)
def _roller_patch(rollers, contacts, kind, j, side, column, mx, my, slope):
    """Patch of a roller around its outward direction m.

    Returns outward motion U·m, sideways motion U·Jm, dU/ds·m per rad, ripple of A·B, its slope per rad.
    """
    c, s = rollers.cosine[column], rollers.sine[column]
    bx, by = c * mx + s * my, c * my - s * mx
    n = rollers.n_surface
    position = _place(bx, by, n)
    base = int(position)
    weight = contacts.weight[kind, j, side]
    weights(position - base, weight)
    weight_slopes(position - base, slope)
    contacts.base[kind, j, side] = base + FIRST
    ux, uy, sx, sy = 0.0, 0.0, 0.0, 0.0
    stride = 2 * rollers.columns
    for k in range(N_NODES):
        at = (rollers.first_surface + (base + FIRST + k + n) % n) * stride + column
        x, y = rollers.u[at], rollers.u[at + rollers.columns]
        ux += weight[k] * x
        uy += weight[k] * y
        sx += slope[k] * x
        sy += slope[k] * y
    ripple, ripple_slope = ripple_at(position, contacts.roller_ripple)
    per_radian = n / (2.0 * pi)
    return ux * bx + uy * by, uy * bx - ux * by, (sx * bx + sy * by) * per_radian, ripple, ripple_slope * per_radian


@njit(cache=True)
def _ring_patch(ring, turn_cosine, turn_sine, ripples, contacts, kind, j, nx, ny, slope):
    """Patch of a ring around the radial direction n; returns the same as `_roller_patch` along +n."""
    bx, by = turn_cosine * nx + turn_sine * ny, turn_cosine * ny - turn_sine * nx
    n = ring.n_sectors
    position = _place(bx, by, n)
    base = int(position)
    weight, across = contacts.weight[kind, j, 0], contacts.across[kind, j]
    weights(position - base, weight)
    weight_slopes(position - base, slope)
    contacts.base[kind, j, 0] = base + FIRST
    step = 2.0 * pi / n
    angle = (position - base - FIRST) * step
    c, s = cos(angle), sin(angle)
    turn_c, turn_s = cos(step), sin(step)
    radial, tangential = ring.u[ring.raceway, 0], ring.u[ring.raceway, 1]
    out, side, rate = 0.0, 0.0, 0.0
    for k in range(N_NODES):
        at = HALO + (base + FIRST + k + n) % n
        a, b = radial[at], tangential[at]
        along = a * c + b * s
        out += weight[k] * along
        side += weight[k] * (b * c - a * s)
        rate += slope[k] * along
        across[k] = weight[k] * s
        weight[k] *= c
        c, s = c * turn_c + s * turn_s, s * turn_c - c * turn_s
    ripple, ripple_slope = ripple_at(position % ripples[1], ripples[0])
    per_radian = n / (2.0 * pi)
    return out, side, rate * per_radian, ripple, ripple_slope * per_radian


@njit(cache=True)
def _push_roller(rollers, contacts, kind, j, side, column, px, py):
    """Spread an impulse, N s, in world axes over a roller's patch."""
    c, s = rollers.cosine[column], rollers.sine[column]
    bx, by = c * px + s * py, c * py - s * px
    n, columns = rollers.n_surface, rollers.columns
    base, weight = contacts.base[kind, j, side], contacts.weight[kind, j, side]
    for k in range(N_NODES):
        node = rollers.first_surface + (base + k + n) % n
        share = weight[k] / rollers.mass[node]
        at = node * 2 * columns + column
        rollers.w[at] += share * bx
        rollers.w[at + columns] += share * by
    rollers.impulse[column, 0] += px
    rollers.impulse[column, 1] += py


@njit(cache=True)
def _push_ring(ring, contacts, kind, j, along, aside):
    """Spread an impulse, N s, with components along n and along t over a ring's patch."""
    radial, tangential = ring.w[ring.raceway, 0], ring.w[ring.raceway, 1]
    n = ring.n_sectors
    base, weight, across = contacts.base[kind, j, 0], contacts.weight[kind, j, 0], contacts.across[kind, j]
    share = 1.0 / ring.row_mass[ring.raceway]
    for k in range(N_NODES):
        at = HALO + (base + k + n) % n
        radial[at] += share * (along * weight[k] - aside * across[k])
        tangential[at] += share * (along * across[k] + aside * weight[k])


@njit(cache=True)
def _roller_sideways(rollers, contacts, kind, j, side, column, mx, my):
    """Velocity of a roller's surface along Jm, exact for rigid motion; m/s."""
    c, s = rollers.cosine[column], rollers.sine[column]
    bx, by = c * mx + s * my, c * my - s * mx
    n, columns = rollers.n_surface, rollers.columns
    base, weight = contacts.base[kind, j, side], contacts.weight[kind, j, side]
    wx, wy = 0.0, 0.0
    for k in range(N_NODES):
        at = (rollers.first_surface + (base + k + n) % n) * 2 * columns + column
        wx += weight[k] * rollers.w[at]
        wy += weight[k] * rollers.w[at + columns]
    centre = rollers.velocity[column, 1] * mx - rollers.velocity[column, 0] * my
    return wy * bx - wx * by + centre + rollers.spin[column] * rollers.radius * rollers.arc


@njit(cache=True)
def _ring_sideways(ring, contacts, kind, j, speed):
    """Velocity of a ring's surface along t, exact for rotation; m/s."""
    radial, tangential = ring.w[ring.raceway, 0], ring.w[ring.raceway, 1]
    n = ring.n_sectors
    base, weight, across = contacts.base[kind, j, 0], contacts.weight[kind, j, 0], contacts.across[kind, j]
    v = 0.0
    for k in range(N_NODES):
        at = HALO + (base + k + n) % n
        v += weight[k] * tangential[at] - across[k] * radial[at]
    return v + speed * ring.radius * ring.arc


@njit(cache=True)
def _roller_mobility(rollers, contacts, kind, j, side):
    """Velocity gained along the patch per unit impulse, 1/kg."""
    n = rollers.n_surface
    base, weight = contacts.base[kind, j, side], contacts.weight[kind, j, side]
    total = 0.0
    for k in range(N_NODES):
        total += weight[k] * weight[k] / rollers.mass[rollers.first_surface + (base + k + n) % n]
    return total


@njit(cache=True)
def _ring_mobility(ring, contacts, kind, j):
    weight, across = contacts.weight[kind, j, 0], contacts.across[kind, j]
    total = 0.0
    for k in range(N_NODES):
        total += weight[k] * weight[k] + across[k] * across[k]
    return total / ring.row_mass[ring.raceway]


@njit(cache=True)
def slip_velocity(rollers, inner, outer, contacts, drive, kind, j):
    """Sideways velocity of side 1 less that of side 0, along t = Jn, m/s."""
    nx, ny = contacts.normal[kind, j, 0], contacts.normal[kind, j, 1]
    if kind == INNER:  # the roller's outward direction is −n, its Jm is −t
        ring = _ring_sideways(inner, contacts, kind, j, drive.speed)
        return -_roller_sideways(rollers, contacts, kind, j, 1, j, -nx, -ny) - ring
    if kind == OUTER:
        ring = _ring_sideways(outer, contacts, kind, j, 0.0)
        return _roller_sideways(rollers, contacts, kind, j, 1, j, nx, ny) - ring
    other = (j + 1) % rollers.n
    first = _roller_sideways(rollers, contacts, kind, j, 0, j, nx, ny)
    return -_roller_sideways(rollers, contacts, kind, j, 1, other, -nx, -ny) - first


@njit(cache=True)
def normal_contacts(rollers, inner, outer, contacts, drive, slope):
    """Normal forces of every contact at the present positions, and their impulses over one step."""
    for j in range(rollers.n):
        _inner_contact(rollers, inner, contacts, drive, j, slope)
        _outer_contact(rollers, outer, contacts, drive, j, slope)
    if rollers.n > 1:
        for j in range(rollers.n):
            _roller_contact(rollers, contacts, drive, j, slope)
    if drive.friction > 0.0:
        for kind in range(3):
            for j in range(rollers.n):
                if contacts.force[kind, j] > 0.0:
                    contacts.slip[kind, j] = slip_velocity(rollers, inner, outer, contacts, drive, kind, j)


@njit(cache=True)
def _apart(gap, Q_scale, contacts, kind, j):
    """True, and the force cleared, where the undeformed gap is far wider than any elastic motion of the surfaces."""
    if gap > Q_scale:
        contacts.force[kind, j] = 0.0
        contacts.traction[kind, j] = 0.0
        return True
    return False


@njit(cache=True)
def _inner_contact(rollers, inner, contacts, drive, j, slope):
    x, y = rollers.centre[j, 0] - drive.hub[0], rollers.centre[j, 1] - drive.hub[1]
    distance = sqrt(x * x + y * y)
    overlap = inner.radius + rollers.radius - distance
    if _apart(-overlap, 0.01 * rollers.radius, contacts, INNER, j):
        return
    nx, ny = x / distance, y / distance
    contacts.normal[INNER, j, 0], contacts.normal[INNER, j, 1] = nx, ny
    out, side, rate, ripple, ripple_rate = _ring_patch(
        inner, drive.ring[1], drive.ring[2], (contacts.inner_ripple, 1.0), contacts, INNER, j, nx, ny, slope
    )
    out -= drive.hub[0] * nx + drive.hub[1] * ny  # the ring's state holds the hub's motion
    side -= drive.hub[1] * nx - drive.hub[0] * ny
    out_r, side_r, rate_r, ripple_r, ripple_rate_r = _roller_patch(
        rollers, contacts, INNER, j, 1, j, -nx, -ny, slope
    )
    A = contacts.A[INNER]
    B = contacts.B[INNER] + (ripple + ripple_r) / A
    Q = contact_force(overlap + out + out_r, A, B, contacts.Q_line[INNER], contacts.force[INNER, j])
    contacts.force[INNER, j], contacts.bracket[INNER, j] = Q, B
    if Q == 0.0:
        contacts.traction[INNER, j] = 0.0
        return
    dt = drive.dt
    half = 0.5 * Q * Q
    across = (Q * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
    _push_ring(inner, contacts, INNER, j, -Q * dt, 0.0)
    _push_roller(rollers, contacts, INNER, j, 1, j, Q * dt * nx, Q * dt * ny)
    rollers.tilt[j, 0] += across * ny
    rollers.tilt[j, 1] -= across * nx
    drive.impulse[0] -= across * ny
    drive.impulse[1] += across * nx
    rollers.turn_kick[j] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia
    drive.ring[3] += half * ripple_rate - Q * rate


@njit(cache=True)
def _outer_contact(rollers, outer, contacts, drive, j, slope):
    x, y = rollers.centre[j, 0], rollers.centre[j, 1]
    distance = sqrt(x * x + y * y)
    overlap = distance + rollers.radius - outer.radius
    if _apart(-overlap, 0.01 * rollers.radius, contacts, OUTER, j):
        return
    nx, ny = x / distance, y / distance
    contacts.normal[OUTER, j, 0], contacts.normal[OUTER, j, 1] = nx, ny
    out, side, rate, ripple, ripple_rate = _ring_patch(
        outer, 1.0, 0.0, (contacts.outer_ripple, 1.0), contacts, OUTER, j, nx, ny, slope
    )
    out_r, side_r, rate_r, ripple_r, ripple_rate_r = _roller_patch(rollers, contacts, OUTER, j, 1, j, nx, ny, slope)
    A = contacts.A[OUTER]
    B = contacts.B[OUTER] + (ripple + ripple_r) / A
    Q = contact_force(overlap - out + out_r, A, B, contacts.Q_line[OUTER], contacts.force[OUTER, j])
    contacts.force[OUTER, j], contacts.bracket[OUTER, j] = Q, B
    if Q == 0.0:
        contacts.traction[OUTER, j] = 0.0
        return
    dt = drive.dt
    half = 0.5 * Q * Q
    across = (Q * (rate_r + side_r - rate - side) - half * (ripple_rate + ripple_rate_r)) / distance * dt
    _push_ring(outer, contacts, OUTER, j, Q * dt, 0.0)
    _push_roller(rollers, contacts, OUTER, j, 1, j, -Q * dt * nx, -Q * dt * ny)
    rollers.tilt[j, 0] += across * ny
    rollers.tilt[j, 1] -= across * nx
    rollers.turn_kick[j] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia


@njit(cache=True)
def _roller_contact(rollers, contacts, drive, j, slope):
    other = (j + 1) % rollers.n
    x = rollers.centre[other, 0] - rollers.centre[j, 0]
    y = rollers.centre[other, 1] - rollers.centre[j, 1]
    distance = sqrt(x * x + y * y)
    overlap = 2.0 * rollers.radius - distance
    if _apart(-overlap, 0.01 * rollers.radius, contacts, ROLLER, j):
        return
    nx, ny = x / distance, y / distance
    contacts.normal[ROLLER, j, 0], contacts.normal[ROLLER, j, 1] = nx, ny
    out, side, rate, ripple, ripple_rate = _roller_patch(rollers, contacts, ROLLER, j, 0, j, nx, ny, slope)
    out_r, side_r, rate_r, ripple_r, ripple_rate_r = _roller_patch(
        rollers, contacts, ROLLER, j, 1, other, -nx, -ny, slope
    )
    A = contacts.A[ROLLER]
    B = contacts.B[ROLLER] + (ripple + ripple_r) / A
    Q = contact_force(overlap + out + out_r, A, B, contacts.Q_line[ROLLER], contacts.force[ROLLER, j])
    contacts.force[ROLLER, j], contacts.bracket[ROLLER, j] = Q, B
    if Q == 0.0:
        contacts.traction[ROLLER, j] = 0.0
        return
    dt = drive.dt
    half = 0.5 * Q * Q
    across = (Q * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
    _push_roller(rollers, contacts, ROLLER, j, 0, j, -Q * dt * nx, -Q * dt * ny)
    _push_roller(rollers, contacts, ROLLER, j, 1, other, Q * dt * nx, Q * dt * ny)
    rollers.tilt[other, 0] += across * ny
    rollers.tilt[other, 1] -= across * nx
    rollers.tilt[j, 0] -= across * ny
    rollers.tilt[j, 1] += across * nx
    rollers.turn_kick[j] += dt * (Q * rate - half * ripple_rate) / rollers.inertia
    rollers.turn_kick[other] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia


@njit(cache=True)
def creep_traction(slip, limit, full_slip, mobility_dt):
    """Traction, N, that opposes a slip velocity and the slip it leaves, m/s.

    Carter's law T = limit·(1 − (1 − v/v_full)²) up to v_full, then `limit`; solved implicitly for the velocity after
    the step, v = slip − mobility·dt·T(v), so that no stiffness limits the step.

    Parameters
    ----------
    limit : float, N, μQ; full_slip : float, m/s; mobility_dt : float, m/s per N

    Source: Carter, On the action of a locomotive driving wheel (1926); Johnson, Contact Mechanics (1985), chapter 8.
    """
    v = abs(slip)
    k = mobility_dt * limit / full_slip
    x = v / full_slip
    if x >= 1.0 + k:
        left = v - mobility_dt * limit
        return np.copysign(limit, slip), np.copysign(left, slip)
    b = 1.0 + 2.0 * k
    x = 2.0 * x / (b + sqrt(b * b - 4.0 * k * x))
    return np.copysign(limit * x * (2.0 - x), slip), np.copysign(x * full_slip, slip)


@njit(cache=True)
def friction_contacts(rollers, inner, outer, contacts, drive):
    """Tractions of every contact; returns the work they dissipate in this step, J."""
    dissipated = 0.0
    dt = drive.dt
    for kind in range(3):
        for j in range(rollers.n):
            Q = contacts.force[kind, j]
            if Q > 0.0:
                dissipated += _traction(rollers, inner, outer, contacts, drive, kind, j, Q, dt)
    return dissipated


@njit(cache=True)
def _traction(rollers, inner, outer, contacts, drive, kind, j, Q, dt):
    nx, ny = contacts.normal[kind, j, 0], contacts.normal[kind, j, 1]
    slip = slip_velocity(rollers, inner, outer, contacts, drive, kind, j)
    mobility = _roller_mobility(rollers, contacts, kind, j, 1)
    rolling = 0.0
    if kind == ROLLER:
        mobility += _roller_mobility(rollers, contacts, kind, j, 0)
    else:
        mobility += _ring_mobility(inner if kind == INNER else outer, contacts, kind, j)
        orbit = (rollers.velocity[j, 1] * nx - rollers.velocity[j, 0] * ny) / (outer.radius - rollers.radius)
        rolling = abs(rollers.spin[j] - orbit) * rollers.radius
    half_width = sqrt(contacts.half_width_factor[kind] * Q)
    full_slip = max(drive.friction * half_width * contacts.curvature[kind] * rolling, SLIP_FLOOR)
    T, left = creep_traction(slip, drive.friction * Q, full_slip, mobility * dt)
    contacts.traction[kind, j] = -T
    px, py = T * dt * ny, -T * dt * nx  # impulse −T·t on side 1, t = (−ny, nx)
    column = (j + 1) % rollers.n if kind == ROLLER else j
    _push_roller(rollers, contacts, kind, j, 1, column, px, py)
    # what the patch misses of the moment; T on side 1 along −t, whose arm is −r (contact at −n) or +r (outer)
    moment = T * dt * rollers.radius * rollers.arc / rollers.inertia
    rollers.turn_kick[column] += -moment if kind == OUTER else moment
    if kind == INNER:
        _push_ring(inner, contacts, kind, j, 0.0, T * dt)
        drive.ring[3] -= T * inner.radius * inner.arc
    elif kind == OUTER:
        _push_ring(outer, contacts, kind, j, 0.0, T * dt)
    else:
        _push_roller(rollers, contacts, kind, j, 0, j, -px, -py)
        rollers.turn_kick[j] += moment
    return T * dt * 0.5 * (contacts.slip[kind, j] + left)
