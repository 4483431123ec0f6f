"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.
"""

from math import sqrt

import numpy as np

from fem import patch_kernels as patch
from fem.jit import kernel
from fem.resolved_kernels import resolved_contacts
from fem.state import INNER, OUTER, ROLLER
from fem.subgrid import contact_force

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)


@kernel(forceinline=True)
def contact_impulses(rollers, inner, outer, contacts, drive, slope, resolved):
    """Normal forces by the scene's contact model; a run compiles the one it uses."""
    if resolved is None:
        normal_contacts(rollers, inner, outer, contacts, drive, slope)
    else:
        resolved_contacts(rollers, inner, outer, contacts, drive, resolved)


@kernel(forceinline=True)
def normal_contacts(rollers, inner, outer, contacts, drive, slope):
    """Normal forces of every contact at the present positions, and their impulses over one step."""
    inner_contacts(rollers, inner, contacts, drive, slope)
    outer_contacts(rollers, outer, contacts, drive, slope)
    roller_contacts(rollers, contacts, drive, slope)


@kernel(forceinline=True)
def inner_contacts(rollers, inner, contacts, drive, slope):
    """Rollers on the inner raceway: normal from the hub to the roller."""
    u, w, mass, columns = rollers.u, rollers.w, rollers.mass, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    ring_u, ring_w, raceway, n_sectors = inner.u, inner.w, inner.raceway, inner.n_sectors
    node_mass, cosines, sines = inner.row_mass[raceway], inner.cosines, inner.sines
    node, weight, across = contacts.node, contacts.weight, contacts.across
    force, bracket, normal = contacts.force, contacts.bracket, contacts.normal
    A, B, Q_line = contacts.A[INNER], contacts.B[INNER], contacts.Q_line[INNER]
    roller_ripple, ring_ripple = contacts.roller_ripple, contacts.inner_ripple
    hub_x, hub_y, dt = drive.hub[0], drive.hub[1], drive.dt
    ring_c, ring_s = drive.ring[1], drive.ring[2]
    stretch = contacts.stretch
    hub_tilt_x, hub_tilt_y, moment = 0.0, 0.0, 0.0
    for j in range(rollers.n):
        x, y = centre[j, 0] - hub_x, centre[j, 1] - hub_y
        distance = sqrt(x * x + y * y)
        overlap = inner.radius + radius - distance
        if overlap < -contacts.reach:
            force[INNER, j] = 0.0
            continue
        nx, ny = x / distance, y / distance
        p = 2 * (INNER * rollers.n + j)
        out, side, rate, ripple, ripple_rate = patch.read_ring(
            ring_u,
            raceway,
            n_sectors,
            cosines,
            sines,
            ring_c * nx + ring_s * ny,
            ring_c * ny - ring_s * nx,
            ring_ripple,
            node,
            weight,
            across,
            p,
            slope,
            stretch,
        )
        out -= hub_x * nx + hub_y * ny  # the ring's state holds the hub's motion
        side -= hub_y * nx - hub_x * ny
        c, s = cosine[j], sine[j]
        bx, by = -(c * nx + s * ny), s * nx - c * ny
        out_r, side_r, rate_r, ripple_r, ripple_rate_r = patch.read_roller(
            u, columns, first, n_surface, j, bx, by, roller_ripple, node, weight, p + 1, slope, stretch
        )
        level = B + (ripple + ripple_r) / A
        Q = contact_force(overlap + out + out_r, A, level, Q_line, force[INNER, j])
        force[INNER, j], bracket[INNER, j] = Q, level
        if Q == 0.0:
            continue
        normal[INNER, j, 0], normal[INNER, j, 1] = nx, ny
        push, half = Q * dt, 0.5 * Q * Q
        patch.push_ring(ring_w, raceway, node_mass, -push, node, weight, across, p, stretch)
        patch.push_roller(w, mass, columns, j, -push * bx, -push * by, node, weight, p + 1, stretch)
        impulse[j, 0] += push * nx
        impulse[j, 1] += push * ny
        aside = (Q * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        tilt[j, 0] += aside * ny
        tilt[j, 1] -= aside * nx
        hub_tilt_x -= aside * ny
        hub_tilt_y += aside * nx
        turn_kick[j] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia
        moment += half * ripple_rate - Q * rate
    drive.impulse[0] += hub_tilt_x
    drive.impulse[1] += hub_tilt_y
    drive.ring[3] += moment


@kernel(forceinline=True)
def outer_contacts(rollers, outer, contacts, drive, slope):
    """Rollers on the outer raceway: normal from the outer ring's centre to the roller."""
    u, w, mass, columns = rollers.u, rollers.w, rollers.mass, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    ring_u, ring_w, raceway, n_sectors = outer.u, outer.w, outer.raceway, outer.n_sectors
    node_mass, cosines, sines = outer.row_mass[raceway], outer.cosines, outer.sines
    node, weight, across = contacts.node, contacts.weight, contacts.across
    force, bracket, normal = contacts.force, contacts.bracket, contacts.normal
    A, B, Q_line = contacts.A[OUTER], contacts.B[OUTER], contacts.Q_line[OUTER]
    roller_ripple, ring_ripple = contacts.roller_ripple, contacts.outer_ripple
    dt, stretch = drive.dt, contacts.stretch
    for j in range(rollers.n):
        x, y = centre[j, 0], centre[j, 1]
        distance = sqrt(x * x + y * y)
        overlap = distance + radius - outer.radius
        if overlap < -contacts.reach:
            force[OUTER, j] = 0.0
            continue
        nx, ny = x / distance, y / distance
        p = 2 * (OUTER * rollers.n + j)
        out, side, rate, ripple, ripple_rate = patch.read_ring(
            ring_u, raceway, n_sectors, cosines, sines, nx, ny, ring_ripple, node, weight, across, p, slope, stretch
        )
        c, s = cosine[j], sine[j]
        bx, by = c * nx + s * ny, c * ny - s * nx
        out_r, side_r, rate_r, ripple_r, ripple_rate_r = patch.read_roller(
            u, columns, first, n_surface, j, bx, by, roller_ripple, node, weight, p + 1, slope, stretch
        )
        level = B + (ripple + ripple_r) / A
        Q = contact_force(overlap - out + out_r, A, level, Q_line, force[OUTER, j])
        force[OUTER, j], bracket[OUTER, j] = Q, level
        if Q == 0.0:
            continue
        normal[OUTER, j, 0], normal[OUTER, j, 1] = nx, ny
        push, half = Q * dt, 0.5 * Q * Q
        patch.push_ring(ring_w, raceway, node_mass, push, node, weight, across, p, stretch)
        patch.push_roller(w, mass, columns, j, -push * bx, -push * by, node, weight, p + 1, stretch)
        impulse[j, 0] -= push * nx
        impulse[j, 1] -= push * ny
        aside = (Q * (rate_r + side_r - rate - side) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        tilt[j, 0] += aside * ny
        tilt[j, 1] -= aside * nx
        turn_kick[j] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia


@kernel(forceinline=True)
def roller_contacts(rollers, contacts, drive, slope):
    """Roller j on roller j + 1: normal from j to j + 1."""
    u, w, mass, columns = rollers.u, rollers.w, rollers.mass, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    node, weight, force, bracket, normal = (
        contacts.node,
        contacts.weight,
        contacts.force,
        contacts.bracket,
        contacts.normal,
    )
    A, B, Q_line = contacts.A[ROLLER], contacts.B[ROLLER], contacts.Q_line[ROLLER]
    ripples, dt, stretch = contacts.roller_ripple, drive.dt, contacts.stretch
    touching = 2.0 * radius + contacts.reach
    for j in range(rollers.n):
        i = j + 1 if j + 1 < rollers.n else 0
        x, y = centre[i, 0] - centre[j, 0], centre[i, 1] - centre[j, 1]
        if x * x + y * y > touching * touching:
            force[ROLLER, j] = 0.0
            continue
        distance = sqrt(x * x + y * y)
        nx, ny = x / distance, y / distance
        p = 2 * (ROLLER * rollers.n + j)
        ax, ay = cosine[j] * nx + sine[j] * ny, cosine[j] * ny - sine[j] * nx
        bx, by = -(cosine[i] * nx + sine[i] * ny), sine[i] * nx - cosine[i] * ny
        out, side, rate, ripple, ripple_rate = patch.read_roller(
            u, columns, first, n_surface, j, ax, ay, ripples, node, weight, p, slope, stretch
        )
        out_r, side_r, rate_r, ripple_r, ripple_rate_r = patch.read_roller(
            u, columns, first, n_surface, i, bx, by, ripples, node, weight, p + 1, slope, stretch
        )
        level = B + (ripple + ripple_r) / A
        Q = contact_force(2.0 * radius - distance + out + out_r, A, level, Q_line, force[ROLLER, j])
        force[ROLLER, j], bracket[ROLLER, j] = Q, level
        if Q == 0.0:
            continue
        normal[ROLLER, j, 0], normal[ROLLER, j, 1] = nx, ny
        push, half = Q * dt, 0.5 * Q * Q
        patch.push_roller(w, mass, columns, j, -push * ax, -push * ay, node, weight, p, stretch)
        patch.push_roller(w, mass, columns, i, -push * bx, -push * by, node, weight, p + 1, stretch)
        aside = (Q * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        for body, sign in ((i, 1.0), (j, -1.0)):
            impulse[body, 0] += sign * push * nx
            impulse[body, 1] += sign * push * ny
            tilt[body, 0] += sign * aside * ny
            tilt[body, 1] -= sign * aside * nx
        turn_kick[j] += dt * (Q * rate - half * ripple_rate) / rollers.inertia
        turn_kick[i] += dt * (Q * rate_r - half * ripple_rate_r) / rollers.inertia


@kernel(forceinline=True)
def creep_traction(slip, limit, full_slip, mobility_dt):
    """Traction, N, that opposes a slip velocity, and the slip it leaves, m/s.

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
        return np.copysign(limit, slip), np.copysign(v - mobility_dt * limit, slip)
    b = 1.0 + 2.0 * k
    x = 2.0 * x / (b + sqrt(b * b - 4.0 * k * x))
    return np.copysign(limit * x * (2.0 - x), slip), np.copysign(x * full_slip, slip)


@kernel(forceinline=True)
def grips(rollers, contacts):
    """Tangential directions of all closed contacts' patches, for `slips` and `friction_contacts`."""
    points, radius, cosine, sine = rollers.points, rollers.radius, rollers.cosine, rollers.sine
    node, weight, across, stretch = contacts.node, contacts.weight, contacts.across, contacts.stretch
    force, normal, grip_x, grip_y = contacts.force, contacts.normal, contacts.grip_x, contacts.grip_y
    n = rollers.n
    for kind in range(3):
        sign = 1.0 if kind == OUTER else -1.0  # the roller's outward direction is ±n
        for j in range(n):
            if force[kind, j] == 0.0:
                continue
            nx, ny = normal[kind, j, 0], normal[kind, j, 1]
            p = 2 * (kind * n + j)
            if kind == ROLLER:
                i = j + 1 if j + 1 < n else 0
                ax, ay = cosine[j] * nx + sine[j] * ny, cosine[j] * ny - sine[j] * nx
                patch.grip_roller(points, radius, ax, ay, node, weight, p, grip_x, grip_y, stretch)
            else:
                i = j
                patch.grip_ring(weight, across, p, grip_x, grip_y, stretch)
            bx, by = sign * (cosine[i] * nx + sine[i] * ny), sign * (cosine[i] * ny - sine[i] * nx)
            patch.grip_roller(points, radius, bx, by, node, weight, p + 1, grip_x, grip_y, stretch)


@kernel(forceinline=True)
def slips(rollers, inner, outer, contacts, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for every closed contact, m/s; out (3, n).

    `grips` must have been called at the present positions.
    """
    w, columns, velocity = rollers.w, rollers.columns, rollers.velocity
    node, grip_x, grip_y, stretch = contacts.node, contacts.grip_x, contacts.grip_y, contacts.stretch
    force, normal = contacts.force, contacts.normal
    inner_w, outer_w = inner.w, outer.w
    n = rollers.n
    for kind in range(3):
        sign = 1.0 if kind == OUTER else -1.0
        for j in range(n):
            if force[kind, j] == 0.0:
                continue
            nx, ny = normal[kind, j, 0], normal[kind, j, 1]
            p = 2 * (kind * n + j)
            i = j
            if kind == ROLLER and j + 1 < n:
                i = j + 1
            elif kind == ROLLER:
                i = 0
            slip = velocity[i, 1] * nx - velocity[i, 0] * ny
            slip += sign * patch.sideways_roller(w, columns, i, node, grip_x, grip_y, p + 1, stretch)
            if kind == INNER:
                slip -= patch.sideways_ring(inner_w, inner.raceway, node, grip_x, grip_y, p, stretch)
            elif kind == OUTER:
                slip -= patch.sideways_ring(outer_w, outer.raceway, node, grip_x, grip_y, p, stretch)
            else:
                slip -= velocity[j, 1] * nx - velocity[j, 0] * ny
                slip -= patch.sideways_roller(w, columns, j, node, grip_x, grip_y, p, stretch)
            out[kind, j] = slip


@kernel(forceinline=True)
def friction_contacts(rollers, inner, outer, contacts, drive, now):
    """Tractions of every contact and their impulses; returns the work they dissipate in this step, J.

    Each is implicit in its own patch's velocity; patches of one body do not overlap, so their order does not matter.
    (On a raceway with fewer nodes than six a roller they do, and sticking contacts then shake each other slowly.)
    """
    slips(rollers, inner, outer, contacts, now)
    w, mass, columns = rollers.w, rollers.mass, rollers.columns
    velocity, spin, impulse = rollers.velocity, rollers.spin, rollers.impulse
    node, grip_x, grip_y, stretch = contacts.node, contacts.grip_x, contacts.grip_y, contacts.stretch
    force, traction, normal, before = contacts.force, contacts.traction, contacts.normal, contacts.slip
    inner_w, outer_w = inner.w, outer.w
    inner_mass, outer_mass = inner.row_mass[inner.raceway], outer.row_mass[outer.raceway]
    friction, dt, n, radius = drive.friction, drive.dt, rollers.n, rollers.radius
    pitch = outer.radius - radius
    dissipated = 0.0
    for kind in range(3):
        sign = 1.0 if kind == OUTER else -1.0
        for j in range(n):
            Q = force[kind, j]
            if Q == 0.0:
                traction[kind, j] = 0.0
                continue
            nx, ny = normal[kind, j, 0], normal[kind, j, 1]
            p = 2 * (kind * n + j)
            i = j
            if kind == ROLLER and j + 1 < n:
                i = j + 1
            elif kind == ROLLER:
                i = 0
            mobility = patch.mobility_roller(mass, node, grip_x, grip_y, p + 1, stretch)
            rolling = 0.0
            if kind == INNER:
                mobility += patch.mobility_ring(inner_mass, grip_x, grip_y, p, stretch)
            elif kind == OUTER:
                mobility += patch.mobility_ring(outer_mass, grip_x, grip_y, p, stretch)
            else:
                mobility += patch.mobility_roller(mass, node, grip_x, grip_y, p, stretch)
            if kind != ROLLER:
                orbit = (velocity[j, 1] * nx - velocity[j, 0] * ny) / pitch
                rolling = abs(spin[j] - orbit) * radius
            half_width = sqrt(contacts.half_width_factor[kind] * Q)
            full_slip = max(friction * half_width * contacts.curvature[kind] * rolling, SLIP_FLOOR)
            T, left = creep_traction(now[kind, j], friction * Q, full_slip, mobility * dt)
            traction[kind, j] = -T
            dissipated += 0.5 * T * dt * (before[kind, j] + left)
            push = T * dt  # −T along t on side 1, T on side 0
            patch.rub_roller(w, mass, columns, i, -sign * push, node, grip_x, grip_y, p + 1, stretch)
            impulse[i, 0] += push * ny
            impulse[i, 1] -= push * nx
            if kind == INNER:
                patch.rub_ring(inner_w, inner.raceway, inner_mass, push, node, grip_x, grip_y, p, stretch)
            elif kind == OUTER:
                patch.rub_ring(outer_w, outer.raceway, outer_mass, push, node, grip_x, grip_y, p, stretch)
            else:
                patch.rub_roller(w, mass, columns, j, push, node, grip_x, grip_y, p, stretch)
                impulse[j, 0] -= push * ny
                impulse[j, 1] += push * nx
    return dissipated
