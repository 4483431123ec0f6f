"""Contacts: exact circles, smooth patches, sub-grid law; all forces are the gradient of one potential.

Approach of two bodies 1, 2 with unit normal n along the line of centres and patch means U = Σ W u:

    δ = (overlap of the undeformed circles) + outward motion U₁·m₁ + U₂·m₂

The potential V(δ, s₁, s₂) depends on positions through δ and through where the patches sit. Its gradient at fixed
patches is the nodal force Q W; the rest is small (the tilt of the deformed surfaces) and acts on bodies as a whole:
a force across the line of centres and moments on the frames.
"""

from math import sqrt

import numpy as np

from fem.kernels import patch_kernels as patch
from fem.kernels.jit import kernel
from fem.kernels.law import contact_force, kick_force
from fem.kernels.resolved_kernels import resolved_contacts
from fem.kernels.state import INNER, OUTER, ROLLER


@kernel(forceinline=True)
def contact_forces(rollers, inner, outer, contacts, drive, slope, resolved):
    """Normal forces by the scene's contact model, and what they do to whole bodies; a run compiles the one it uses."""
    if resolved is None:
        normal_contacts(rollers, inner, outer, contacts, drive, slope)
    else:
        resolved_contacts(rollers, inner, outer, contacts, drive, resolved)


@kernel(forceinline=True)
def push_nodes(rollers, inner, outer, contacts, drive, resolved):
    """The forces' impulses on the surface nodes, where `contact_forces` has not given them already."""
    if resolved is None:
        push_contacts(rollers, inner, outer, contacts, drive)


@kernel(forceinline=True)
def normal_contacts(rollers, inner, outer, contacts, drive, slope):
    """Normal forces of every contact at the present positions, and their impulses over one step on whole bodies."""
    inner_contacts(rollers, inner, contacts, drive, slope)
    outer_contacts(rollers, outer, contacts, drive, slope)
    roller_contacts(rollers, contacts, drive, slope)


@kernel(forceinline=True)
def push_contacts(rollers, inner, outer, contacts, drive):
    """Impulses of the normal forces over one step on the surface nodes."""
    w, lightness, columns, n = rollers.w, rollers.lightness, rollers.columns, rollers.n
    inner_u, inner_w, inner_mass = inner.u, inner.w, inner.row_mass[inner.raceway]
    outer_u, outer_w, outer_mass = outer.u, outer.w, outer.row_mass[outer.raceway]
    node, weight, along, across = contacts.node, contacts.weight, contacts.along, contacts.across
    push, outward, stretch, dt = contacts.push, contacts.outward, contacts.stretch, drive.dt
    on_nodes = 0.0
    for kind in range(3):
        for j in range(n):
            if push[kind, j] == 0.0:
                continue
            p, given = 2 * (kind * n + j), -push[kind, j] * dt
            i = second(kind, j, n)
            if kind == INNER:
                on_nodes += patch.push_ring(
                    inner_u, inner_w, inner.raceway, inner.radius, inner_mass, given, node, along, across, p, stretch
                )
            elif kind == OUTER:
                patch.push_ring(
                    outer_u, outer_w, outer.raceway, outer.radius, outer_mass, -given, node, along, across, p, stretch
                )
            else:
                patch.push_roller(
                    w, lightness, columns, j, given * outward[p, 0], given * outward[p, 1], node, weight, p, stretch
                )
            p += 1
            patch.push_roller(
                w, lightness, columns, i, given * outward[p, 0], given * outward[p, 1], node, weight, p, stretch
            )
    drive.ring[4] += on_nodes


@kernel(forceinline=True)
def second(kind, j, n):
    """The roller on side 1 of contact j."""
    if kind != ROLLER:
        return j
    return j + 1 if j + 1 < n else 0


@kernel(forceinline=True)
def inner_contacts(rollers, inner, contacts, drive, slope):
    """Rollers on the inner raceway: normal from the hub to the roller."""
    u, columns = rollers.u, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    ring_u, raceway, n_sectors, cosines, sines = inner.u, inner.raceway, inner.n_sectors, inner.cosines, inner.sines
    node, weight, along, across = contacts.node, contacts.weight, contacts.along, contacts.across
    force, bracket, normal, outward = contacts.force, contacts.bracket, contacts.normal, contacts.outward
    push, approach = contacts.push, contacts.approach
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
            force[INNER, j], push[INNER, j], approach[INNER, j] = 0.0, 0.0, np.nan
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
            along,
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
        closed = overlap + out + out_r
        Q = contact_force(closed, A, level, Q_line, force[INNER, j])
        P = kick_force(approach[INNER, j], force[INNER, j], bracket[INNER, j], closed, Q, level, A, Q_line)
        force[INNER, j], bracket[INNER, j], push[INNER, j], approach[INNER, j] = Q, level, P, closed
        if P == 0.0:
            continue
        normal[INNER, j, 0], normal[INNER, j, 1] = nx, ny
        outward[p + 1, 0], outward[p + 1, 1] = bx, by
        half = 0.5 * Q * Q
        impulse[j, 0] += P * dt * nx
        impulse[j, 1] += P * dt * ny
        aside = (P * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        tilt[j, 0] += aside * ny
        tilt[j, 1] -= aside * nx
        hub_tilt_x -= aside * ny
        hub_tilt_y += aside * nx
        turn_kick[j] += dt * (P * rate_r - half * ripple_rate_r) / rollers.inertia
        moment += half * ripple_rate - P * rate
    drive.impulse[0] += hub_tilt_x
    drive.impulse[1] += hub_tilt_y
    drive.ring[3] += moment


@kernel(forceinline=True)
def outer_contacts(rollers, outer, contacts, drive, slope):
    """Rollers on the outer raceway: normal from the outer ring's centre to the roller."""
    u, columns = rollers.u, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    ring_u, raceway, n_sectors, cosines, sines = outer.u, outer.raceway, outer.n_sectors, outer.cosines, outer.sines
    node, weight, along, across = contacts.node, contacts.weight, contacts.along, contacts.across
    force, bracket, normal, outward = contacts.force, contacts.bracket, contacts.normal, contacts.outward
    push, approach = contacts.push, contacts.approach
    A, B, Q_line = contacts.A[OUTER], contacts.B[OUTER], contacts.Q_line[OUTER]
    roller_ripple, ring_ripple = contacts.roller_ripple, contacts.outer_ripple
    dt, stretch = drive.dt, contacts.stretch
    for j in range(rollers.n):
        x, y = centre[j, 0], centre[j, 1]
        distance = sqrt(x * x + y * y)
        overlap = distance + radius - outer.radius
        if overlap < -contacts.reach:
            force[OUTER, j], push[OUTER, j], approach[OUTER, j] = 0.0, 0.0, np.nan
            continue
        nx, ny = x / distance, y / distance
        p = 2 * (OUTER * rollers.n + j)
        out, side, rate, ripple, ripple_rate = patch.read_ring(
            ring_u,
            raceway,
            n_sectors,
            cosines,
            sines,
            nx,
            ny,
            ring_ripple,
            node,
            weight,
            along,
            across,
            p,
            slope,
            stretch,
        )
        c, s = cosine[j], sine[j]
        bx, by = c * nx + s * ny, c * ny - s * nx
        out_r, side_r, rate_r, ripple_r, ripple_rate_r = patch.read_roller(
            u, columns, first, n_surface, j, bx, by, roller_ripple, node, weight, p + 1, slope, stretch
        )
        level = B + (ripple + ripple_r) / A
        closed = overlap - out + out_r
        Q = contact_force(closed, A, level, Q_line, force[OUTER, j])
        P = kick_force(approach[OUTER, j], force[OUTER, j], bracket[OUTER, j], closed, Q, level, A, Q_line)
        force[OUTER, j], bracket[OUTER, j], push[OUTER, j], approach[OUTER, j] = Q, level, P, closed
        if P == 0.0:
            continue
        normal[OUTER, j, 0], normal[OUTER, j, 1] = nx, ny
        outward[p + 1, 0], outward[p + 1, 1] = bx, by
        half = 0.5 * Q * Q
        impulse[j, 0] -= P * dt * nx
        impulse[j, 1] -= P * dt * ny
        aside = (P * (rate_r + side_r - rate - side) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        tilt[j, 0] += aside * ny
        tilt[j, 1] -= aside * nx
        turn_kick[j] += dt * (P * rate_r - half * ripple_rate_r) / rollers.inertia


@kernel(forceinline=True)
def roller_contacts(rollers, contacts, drive, slope):
    """Roller j on roller j + 1: normal from j to j + 1."""
    u, columns = rollers.u, rollers.columns
    first, n_surface, radius = rollers.first_surface, rollers.n_surface, rollers.radius
    cosine, sine, centre = rollers.cosine, rollers.sine, rollers.centre
    impulse, tilt, turn_kick = rollers.impulse, rollers.tilt, rollers.turn_kick
    node, weight, normal, outward = contacts.node, contacts.weight, contacts.normal, contacts.outward
    force, bracket, push, approach = contacts.force, contacts.bracket, contacts.push, contacts.approach
    A, B, Q_line = contacts.A[ROLLER], contacts.B[ROLLER], contacts.Q_line[ROLLER]
    ripples, dt, stretch = contacts.roller_ripple, drive.dt, contacts.stretch
    touching = 2.0 * radius + contacts.reach
    for j in range(rollers.n):
        i = j + 1 if j + 1 < rollers.n else 0
        x, y = centre[i, 0] - centre[j, 0], centre[i, 1] - centre[j, 1]
        if x * x + y * y > touching * touching:
            force[ROLLER, j], push[ROLLER, j], approach[ROLLER, j] = 0.0, 0.0, np.nan
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
        closed = 2.0 * radius - distance + out + out_r
        Q = contact_force(closed, A, level, Q_line, force[ROLLER, j])
        P = kick_force(approach[ROLLER, j], force[ROLLER, j], bracket[ROLLER, j], closed, Q, level, A, Q_line)
        force[ROLLER, j], bracket[ROLLER, j], push[ROLLER, j], approach[ROLLER, j] = Q, level, P, closed
        if P == 0.0:
            continue
        normal[ROLLER, j, 0], normal[ROLLER, j, 1] = nx, ny
        outward[p, 0], outward[p, 1], outward[p + 1, 0], outward[p + 1, 1] = ax, ay, bx, by
        half = 0.5 * Q * Q
        aside = (P * (rate + side + rate_r + side_r) - half * (ripple_rate + ripple_rate_r)) / distance * dt
        for body, sign in ((i, 1.0), (j, -1.0)):
            impulse[body, 0] += sign * P * dt * nx
            impulse[body, 1] += sign * P * dt * ny
            tilt[body, 0] += sign * aside * ny
            tilt[body, 1] -= sign * aside * nx
        turn_kick[j] += dt * (P * rate - half * ripple_rate) / rollers.inertia
        turn_kick[i] += dt * (P * rate_r - half * ripple_rate_r) / rollers.inertia
