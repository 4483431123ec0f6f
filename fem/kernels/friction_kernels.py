"""Friction between rolling surfaces: Coulomb's limit, Carter's creep below it, solved implicitly.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies.
"""

from math import sqrt

import numpy as np

from fem.kernels import patch_kernels as patch
from fem.kernels.contact_kernels import second
from fem.kernels.jit import kernel
from fem.kernels.state import INNER, OUTER, ROLLER

SLIP_FLOOR = 1e-4  # m/s, creep speed of full slip where nothing rolls (Carter's law would make it 0)


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
    points, radius, n = rollers.points, rollers.radius, rollers.n
    node, weight, along, across = contacts.node, contacts.weight, contacts.along, contacts.across
    force, outward, stretch = contacts.force, contacts.outward, contacts.stretch
    grip_x, grip_y = contacts.grip_x, contacts.grip_y
    for kind in range(3):
        for j in range(n):
            if force[kind, j] == 0.0:
                continue
            p = 2 * (kind * n + j)
            if kind == ROLLER:
                patch.grip_roller(
                    points, radius, outward[p, 0], outward[p, 1], node, weight, p, grip_x, grip_y, stretch
                )
            else:
                patch.grip_ring(weight, along, across, p, grip_x, grip_y, stretch)
            p += 1
            patch.grip_roller(points, radius, outward[p, 0], outward[p, 1], node, weight, p, grip_x, grip_y, stretch)


@kernel(forceinline=True)
def slips(rollers, inner, outer, contacts, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for every closed contact, m/s; out (3, n).

    `grips` must have been called at the present positions. `turn_kick`, (columns,), rad/s: what the rollers are still
    to gain by turning as a whole.
    """
    for kind in range(3):
        for j in range(rollers.n):
            if contacts.force[kind, j] > 0.0:
                out[kind, j] = slip_of(rollers, inner, outer, contacts, turn_kick, kind, j)


@kernel(forceinline=True)
def slip_of(rollers, inner, outer, contacts, turn_kick, kind, j):
    """`slips` of one contact, m/s."""
    w, columns, velocity, radius, n = rollers.w, rollers.columns, rollers.velocity, rollers.radius, rollers.n
    node, grip_x, grip_y, stretch = contacts.node, contacts.grip_x, contacts.grip_y, contacts.stretch
    nx, ny = contacts.normal[kind, j, 0], contacts.normal[kind, j, 1]
    p, i = 2 * (kind * n + j), second(kind, j, n)
    own = patch.sideways_roller(w, columns, i, node, grip_x, grip_y, p + 1, stretch) + turn_kick[i] * radius
    slip = velocity[i, 1] * nx - velocity[i, 0] * ny
    slip += own if kind == OUTER else -own
    if kind == INNER:
        return slip - patch.sideways_ring(inner.w, inner.raceway, node, grip_x, grip_y, p, stretch)
    if kind == OUTER:
        return slip - patch.sideways_ring(outer.w, outer.raceway, node, grip_x, grip_y, p, stretch)
    slip -= patch.sideways_roller(w, columns, j, node, grip_x, grip_y, p, stretch) + turn_kick[j] * radius
    return slip - (velocity[j, 1] * nx - velocity[j, 0] * ny)


@kernel(forceinline=True)
def rub(rollers, inner, outer, contacts, kind, j, push):
    """The impulse `push`, N s, of one contact's traction against t on side 1; returns its moment on an inner ring."""
    w, lightness, columns, impulse, n = rollers.w, rollers.lightness, rollers.columns, rollers.impulse, rollers.n
    node, grip_x, grip_y, stretch = contacts.node, contacts.grip_x, contacts.grip_y, contacts.stretch
    p, i = 2 * (kind * n + j), second(kind, j, n)
    ix, iy = push * contacts.normal[kind, j, 1], -push * contacts.normal[kind, j, 0]
    sign = 1.0 if kind == OUTER else -1.0
    patch.rub_roller(w, lightness, columns, i, -sign * push, node, grip_x, grip_y, p + 1, stretch)
    impulse[i, 0] += ix
    impulse[i, 1] += iy
    if kind == INNER:
        mass = inner.row_mass[inner.raceway]
        return patch.rub_ring(
            inner.u, inner.w, inner.raceway, inner.radius, mass, push, node, grip_x, grip_y, p, stretch
        )
    if kind == OUTER:
        mass = outer.row_mass[outer.raceway]
        patch.rub_ring(outer.u, outer.w, outer.raceway, outer.radius, mass, push, node, grip_x, grip_y, p, stretch)
    else:
        patch.rub_roller(w, lightness, columns, j, push, node, grip_x, grip_y, p, stretch)
        impulse[j, 0] -= ix
        impulse[j, 1] -= iy
    return 0.0


@kernel(forceinline=True)
def friction_contacts(rollers, inner, outer, contacts, drive, after):
    """Tractions of every contact and their impulses; returns the work they dissipate in this step, J.

    Each is implicit in its own patch's velocity. `after`, (3, n), m/s, is filled with the slips they leave. Where
    patches of neighbours overlap (on coarse rings), each starts from its last value and they are solved for in turn
    (Gauss and Seidel): without neighbours' part sticking contacts would shake each other.
    """
    lightness, velocity, spin, radius, n = rollers.lightness, rollers.velocity, rollers.spin, rollers.radius, rollers.n
    node, grip_x, grip_y, stretch = contacts.node, contacts.grip_x, contacts.grip_y, contacts.stretch
    force, traction, normal, before = contacts.force, contacts.traction, contacts.normal, contacts.slip
    inner_mass, outer_mass = inner.row_mass[inner.raceway], outer.row_mass[outer.raceway]
    friction, dt, pitch = drive.friction, drive.dt, outer.radius - radius
    on_nodes = 0.0
    if not contacts.crowded:
        slips(rollers, inner, outer, contacts, rollers.turn_kick, after)
    else:
        for kind in range(3):
            for j in range(n):
                if force[kind, j] > 0.0:
                    on_nodes += rub(rollers, inner, outer, contacts, kind, j, -traction[kind, j] * dt)
    for kind in range(3):
        for j in range(n):
            Q = force[kind, j]
            if Q == 0.0:
                traction[kind, j] = 0.0
                continue
            nx, ny = normal[kind, j, 0], normal[kind, j, 1]
            p = 2 * (kind * n + j)
            mobility = patch.mobility_roller(lightness, node, grip_x, grip_y, p + 1, stretch)
            rolling = 0.0
            if kind == INNER:
                mobility += patch.mobility_ring(inner_mass, grip_x, grip_y, p, stretch)
            elif kind == OUTER:
                mobility += patch.mobility_ring(outer_mass, grip_x, grip_y, p, stretch)
            else:
                mobility += patch.mobility_roller(lightness, node, grip_x, grip_y, p, stretch)
            if kind != ROLLER:
                orbit = (velocity[j, 1] * nx - velocity[j, 0] * ny) / pitch
                rolling = abs(spin[j] - orbit) * radius
            half_width = sqrt(contacts.half_width_factor[kind] * Q)
            full_slip = max(friction * half_width * contacts.curvature[kind] * rolling, SLIP_FLOOR)
            given = 0.0
            if contacts.crowded:
                given = -traction[kind, j]
                after[kind, j] = (
                    slip_of(rollers, inner, outer, contacts, rollers.turn_kick, kind, j) + mobility * dt * given
                )
            T, after[kind, j] = creep_traction(after[kind, j], friction * Q, full_slip, mobility * dt)
            traction[kind, j] = -T
            on_nodes += rub(rollers, inner, outer, contacts, kind, j, (T - given) * dt)
    drive.ring[4] += on_nodes
    if contacts.crowded:
        slips(rollers, inner, outer, contacts, rollers.turn_kick, after)
    dissipated = 0.0
    for kind in range(3):
        for j in range(n):
            dissipated -= 0.5 * dt * traction[kind, j] * (before[kind, j] + after[kind, j])
    return dissipated
