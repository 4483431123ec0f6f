"""Contacts as pressures at points between exact circles: resolved by the mesh, or with points spread over patches.

For two circles with unit normal n along the line of centres and t = Jn, the points at transverse distance s from that
line face each other. Their gap along n is that of the undeformed circles less what the surfaces' outward displacements
along their own normals m₁(s), m₂(s) close of it,

    g(s) = g₀(s, d) − U₁·m₁ / cos φ₁ − U₂·m₂ / cos φ₂,    sin φ_i = s / r_i,

The points stand still relative to the contact while nodes pass through it. Where the mesh resolves the contact U is
interpolated linearly between nodes and a stiff layer resists, p = ε ⟨−g⟩; else U is the mean over a patch and the
forces follow from what the mesh lacks (`spread_kernels`). Either way all are the gradient of one potential, Σ ½ ε g²
Δs L or ½ qᵀG q, as in `contact_kernels`.

The contacts that other programs have on a coarse mesh, kept for comparison, are a single point on the line of centres:
a penalty spring between the nodes around it. With facets U·m includes what the chords lack of the circles.
"""

from math import sqrt

import numpy as np

from fem.kernels import point_kernels as point
from fem.kernels.facet_kernels import chord
from fem.kernels.jit import kernel
from fem.kernels.law import MOST_REPAID, REPAID
from fem.kernels.patch_kernels import place
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.spread_kernels import spread_forces
from fem.kernels.state import INNER, OUTER, ROLLER


@kernel
def resolved_contacts(rollers, inner, outer, contacts, drive, resolved):
    """Normal forces of every contact at the present positions, and their impulses over one step.

    A contact wider than the points given to it makes its force not a number, which stops the run; a single point stands
    for any width.
    """
    centre, n, radius = rollers.centre, rollers.n, rollers.radius
    hub_x, hub_y = drive.hub[0], drive.hub[1]
    for kind in range(3):
        for j in range(n):
            i = j
            if kind == INNER:
                x, y = centre[0, j] - hub_x, centre[1, j] - hub_y
            elif kind == OUTER:
                x, y = centre[0, j], centre[1, j]
            else:
                i = j + 1 if j + 1 < n else 0
                x, y = centre[0, i] - centre[0, j], centre[1, i] - centre[1, j]
            distance = sqrt(x * x + y * y)
            if kind == INNER:
                overlap = inner.radius + radius - distance
            elif kind == OUTER:
                overlap = distance + radius - outer.radius
            else:
                overlap = 2.0 * radius - distance
            contacts.force[kind, j] = 0.0
            if overlap < -contacts.reach:
                resolved.energy[kind, j] = 0.0
                contacts.approach[kind, j], contacts.push[kind, j] = np.nan, 0.0
                resolved.before[kind, j, 0, 0] = np.nan
                continue
            contacts.normal[kind, 0, j], contacts.normal[kind, 1, j] = x / distance, y / distance
            _press(rollers, inner, outer, contacts, drive, resolved, kind, j, i, distance, overlap)


@kernel
def _press(rollers, inner, outer, contacts, drive, resolved, kind, j, i, distance, overlap):
    """One contact: side 0 is a ring or roller j, side 1 is roller i."""
    nx, ny = contacts.normal[kind, 0, j], contacts.normal[kind, 1, j]
    dt, patch = drive.dt, 2 * kind
    first = 1.0 if kind != OUTER else -1.0  # outward direction of side 0's surface is ±n
    second = 1.0 if kind == OUTER else -1.0
    weight = contacts.weight
    width = N_NODES * len(contacts.stretch)
    for k in range(width):
        weight[patch, k, j] = 0.0
        weight[patch + 1, k, j] = 0.0
    if kind == INNER:
        c0, s0, nodes0 = drive.ring[1], drive.ring[2], inner.n_sectors
    elif kind == OUTER:
        c0, s0, nodes0 = 1.0, 0.0, outer.n_sectors
    else:
        c0, s0, nodes0 = rollers.cosine[j], rollers.sine[j], rollers.n_surface
    c1, s1 = rollers.cosine[i], rollers.sine[i]
    contacts.outward[patch, 0, j], contacts.outward[patch, 1, j] = c0 * nx + s0 * ny, c0 * ny - s0 * nx
    contacts.outward[patch + 1, 0, j] = second * (c1 * nx + s1 * ny)
    contacts.outward[patch + 1, 1, j] = second * (c1 * ny - s1 * nx)
    per_radian0, per_radian1 = nodes0 / (2.0 * np.pi), rollers.n_surface / (2.0 * np.pi)
    at0 = place(c0 * nx + s0 * ny, c0 * ny - s0 * nx, nodes0)
    at1 = place(second * (c1 * nx + s1 * ny), second * (c1 * ny - s1 * nx), rollers.n_surface)
    n_points = resolved.shift.shape[2]
    lack = resolved.lack
    beyond = 0 if lack is None else 2  # nodes of a patch before its centre's
    start0 = int(np.floor(at0 - abs(resolved.shift[kind, 0, 0]) * per_radian0)) - beyond
    start1 = int(np.floor(at1 - abs(resolved.shift[kind, 1, 0]) * per_radian1)) - beyond
    closing, force, turning = resolved.closing, resolved.force, resolved.turning
    sagitta0, sagitta1 = resolved.sagitta[kind, 0], resolved.sagitta[kind, 1]
    for q in range(n_points):
        tan0, tan1 = resolved.tangent[kind, 0, q], resolved.tangent[kind, 1, q]
        x0 = at0 + resolved.shift[kind, 0, q] * per_radian0
        x1 = at1 + resolved.shift[kind, 1, q] * per_radian1
        # directions of the surface normals over cos φ: ±n + tan φ t
        m0x, m0y = first * nx - tan0 * ny, first * ny + tan0 * nx
        m1x, m1y = second * nx - tan1 * ny, second * ny + tan1 * nx
        f0x, f0y = c0 * m0x + s0 * m0y, c0 * m0y - s0 * m0x
        f1x, f1y = c1 * m1x + s1 * m1y, c1 * m1y - s1 * m1x
        point.place(x0, resolved, 0, q, lack)
        point.place(x1, resolved, 1, q, lack)
        if kind == INNER:
            out0, side0, rate0 = point.read_ring(inner, x0, f0x, f0y, resolved, q, lack)
            out0 -= drive.hub[0] * m0x + drive.hub[1] * m0y
            side0 -= drive.hub[1] * m0x - drive.hub[0] * m0y
        elif kind == OUTER:
            out0, side0, rate0 = point.read_ring(outer, x0, f0x, f0y, resolved, q, lack)
        else:
            out0, side0, rate0 = point.read_roller(rollers, j, x0, f0x, f0y, resolved, 0, q, lack)
        out1, side1, rate1 = point.read_roller(rollers, i, x1, f1x, f1y, resolved, 1, q, lack)
        if sagitta1 != 0.0:
            depth, slope = chord(x0 - np.floor(x0))
            out0 -= sagitta0 * depth
            rate0 -= sagitta0 * slope
            depth, slope = chord(x1 - np.floor(x1))
            out1 -= sagitta1 * depth
            rate1 -= sagitta1 * slope
        closing[q] = overlap - resolved.rise[kind, q] + out0 + out1
        turning[0, q], turning[1, q], turning[2, q] = rate0 * per_radian0, rate1 * per_radian1, side0 + side1
    energy = _point_forces(resolved, kind, j, lack)
    before = resolved.before
    correction = 0.0 if n_points == 1 else _correction(resolved, kind, j, energy)
    total, pushed, aside, turn0, turn1 = 0.0, 0.0, 0.0, 0.0, 0.0
    tilt0, tilt1 = 0.0, 0.0
    for q in range(n_points):
        p = force[q]
        total += p
        if n_points == 1:
            p = _spring_kick(contacts.approach[kind, j], closing[q], resolved.stiffness[kind])
            contacts.approach[kind, j] = closing[q]
        else:
            extra = 0.0
            if correction != 0.0:
                extra = correction * (closing[q] - before[kind, j, 0, q])
            p += extra
            before[kind, j, 0, q], before[kind, j, 1, q], before[kind, j, 2, q] = closing[q], force[q], extra
        if p == 0.0:
            continue
        tan0, tan1 = resolved.tangent[kind, 0, q], resolved.tangent[kind, 1, q]
        x0 = at0 + resolved.shift[kind, 0, q] * per_radian0
        x1 = at1 + resolved.shift[kind, 1, q] * per_radian1
        rate0, rate1 = turning[0, q], turning[1, q]
        pushed += p
        aside += p * (rate0 + rate1 + turning[2, q])
        if n_points == 1:  # what two nodes' shares turn a body by averages out over many points
            rate0 += _lever(x0, nodes0, inner.radius if kind == INNER else rollers.radius)
            rate1 += _lever(x1, rollers.n_surface, rollers.radius)
        turn0 += p * rate0
        turn1 += p * rate1
        tilt0 += p * tan0
        tilt1 += p * tan1
        point.gather(weight, patch, j, x0, start0, p, width, resolved, 0, q, lack)
        point.gather(weight, patch + 1, j, x1, start1, p, width, resolved, 1, q, lack)
        if n_points == 1:  # `push_contacts` does it, once the slips before this kick are known
            continue
        m0x, m0y = first * nx - tan0 * ny, first * ny + tan0 * nx
        m1x, m1y = second * nx - tan1 * ny, second * ny + tan1 * nx
        f0x, f0y = c0 * m0x + s0 * m0y, c0 * m0y - s0 * m0x
        f1x, f1y = c1 * m1x + s1 * m1y, c1 * m1y - s1 * m1x
        push = p * dt
        if kind == INNER:
            drive.ring[4] += point.push_ring(inner, x0, f0x, f0y, -push, resolved, q, lack)
        elif kind == OUTER:
            point.push_ring(outer, x0, f0x, f0y, -push, resolved, q, lack)
        else:
            point.push_roller(rollers, j, x0, f0x, f0y, -push, resolved, 0, q, lack)
        point.push_roller(rollers, i, x1, f1x, f1y, -push, resolved, 1, q, lack)
    contacts.push[kind, j] = pushed
    resolved.energy[kind, j] = energy
    if pushed == 0.0:
        return
    contacts.force[kind, j] = total
    _share(contacts, patch, j, start0, nodes0, pushed, width)
    _share(contacts, patch + 1, j, start1, rollers.n_surface, pushed, width)
    if kind != ROLLER:
        bx, by = c0 * nx + s0 * ny, c0 * ny - s0 * nx
        cosines, sines = (inner.cosines, inner.sines) if kind == INNER else (outer.cosines, outer.sines)
        for k in range(width):
            at = HALO + (start0 + k) % nodes0
            contacts.along[patch, k, j] = weight[patch, k, j] * (bx * cosines[at] + by * sines[at])
            contacts.across[patch, k, j] = weight[patch, k, j] * (by * cosines[at] - bx * sines[at])

    impulse, tilt = rollers.impulse, rollers.tilt
    turned = aside / distance
    impulse[0, i] -= dt * (pushed * second * nx - tilt1 * ny)
    impulse[1, i] -= dt * (pushed * second * ny + tilt1 * nx)
    on_second = dt * (tilt1 - turned)  # along t
    tilt[0, i] -= on_second * ny
    tilt[1, i] += on_second * nx
    rollers.turn_kick[i] += dt * turn1 / rollers.inertia
    on_first = dt * (tilt0 + turned)
    if kind == INNER:
        drive.impulse[0] -= on_first * ny
        drive.impulse[1] += on_first * nx
        drive.ring[3] -= turn0
    elif kind == ROLLER:
        impulse[0, j] -= dt * (pushed * first * nx - tilt0 * ny)
        impulse[1, j] -= dt * (pushed * first * ny + tilt0 * nx)
        tilt[0, j] -= on_first * ny
        tilt[1, j] += on_first * nx
        rollers.turn_kick[j] += dt * turn0 / rollers.inertia


@kernel
def _point_forces(resolved, kind, j, lack):
    """Forces of a contact's points from what they close by; returns the energy stored in them, J.

    Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force = resolved.closing, resolved.force
    n = closing.size
    if lack is not None:
        return spread_forces(resolved, kind, j)
    energy = 0.0
    for q in range(n):
        force[q] = resolved.stiffness[kind] * max(closing[q], 0.0)
        if n > 1 and force[q] > 0.0 and (q == 0 or q == n - 1):
            force[q] = np.nan
        energy += 0.5 * force[q] * closing[q]
    return energy


@kernel
def _correction(resolved, kind, j, energy):
    """What a kick's forces need beside the points' own, N per m that a point has closed by since the last kick.

    As in `law.kick_force`: the half of a kick that looks back makes the work of the step behind the change of the
    stored energy, and what is left is kept account of and given back in small parts. With the points' own forces the
    work is that but where points have opened or closed.
    """
    closing, force, before = resolved.closing, resolved.force, resolved.before
    if np.isnan(before[kind, j, 0, 0]):
        return 0.0
    missing, size, extra, moved, total, same = energy - resolved.energy[kind, j], 0.0, 0.0, 0.0, 0.0, True
    for q in range(closing.size):
        step, last = closing[q] - before[kind, j, 0, q], before[kind, j, 1, q]
        missing -= 0.5 * step * (force[q] + last)
        extra += 0.5 * step * before[kind, j, 2, q]
        size += step * step
        moved += abs(step)
        total += force[q]
        same &= (force[q] == 0.0) == (last == 0.0)
    if not size > 0.0 or np.isnan(missing):
        return 0.0
    missing = 0.0 if same else missing
    debt = resolved.owed[kind, j] - extra
    most = MOST_REPAID * total / moved
    found = missing / size + max(min(REPAID * debt / size, most), -most)
    resolved.owed[kind, j] = debt + missing - 0.5 * found * size
    return found


@kernel(forceinline=True)
def _spring_kick(before, now, stiffness):
    """Force of a linear spring that a leapfrog kick gives, N: `law.kick_force`, as rattling contacts need it.

    `before`, `now` : float, m, closing at the kick before and at this one; negative: apart, NaN: not known.
    """
    Q = stiffness * max(now, 0.0)
    if np.isnan(before) or before * now >= 0.0:  # closed at both, the spring's own force does just that work
        return Q
    Q_before = stiffness * max(before, 0.0)
    stored = 0.5 * (Q * max(now, 0.0) - Q_before * max(before, 0.0))
    return 0.5 * (Q - Q_before) + stored / (now - before)


@kernel(forceinline=True)
def _lever(x, n_nodes, radius):
    """Moment about the centre of a unit force along a convex circle's inward radius, given by two nodes' shares, m."""
    spacing, t = 2.0 * np.pi / n_nodes, x - np.floor(x)
    return radius * ((1.0 - t) * np.sin(t * spacing) - t * np.sin((1.0 - t) * spacing))


@kernel(forceinline=True)
def _share(contacts, patch, j, start, n_nodes, total, width):
    contacts.start[patch, j] = start % n_nodes
    for k in range(width):
        contacts.weight[patch, k, j] /= total
