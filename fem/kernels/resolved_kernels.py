"""Contacts as pressures at points between exact circles: resolved by the mesh, or with points spread over patches.

For two circles with unit normal n along the line of centres and t = Jn, the points at transverse distance s from that
line face each other. Their gap along n is that of the undeformed circles less what the surfaces' outward displacements
along their own normals m₁(s), m₂(s) close of it,

    g(s) = g₀(s, d) − U₁·m₁ / cos φ₁ − U₂·m₂ / cos φ₂,    sin φ_i = s / r_i,

The points stand still relative to the contact while nodes pass through it. Where the mesh resolves the contact U is
interpolated linearly between nodes and a stiff layer resists, p = ε ⟨−g⟩; else U is the mean over a patch and the
forces follow from what the mesh lacks (`points`). Either way all are the gradient of one potential, Σ ½ ε g²
Δs L or ½ qᵀG q, as in `contact_kernels`.

The contacts that other programs have on a coarse mesh, kept for comparison, are a single point on the line of centres:
a penalty spring between the nodes around it. With facets U·m includes what the chords lack of the circles.

Equation (5) of docs/method.md.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from fem.kernels.contact_kernels import first_surface, next_roller, normal_forces
from fem.kernels.jit import every, part, verb
from fem.kernels.law import MOST_REPAID, REPAID
from fem.kernels.patches import chord
from fem.kernels.points import place_point, push_point, read_point, share_out, spread_forces
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import DiscSurface, Pair, RingSurface
from fem.kernels.surfaces import place


class Meeting(NamedTuple):
    """Two circles on the line of their centres: side 0 is a ring or roller j, side 1 is roller i."""

    first: int  # j, roller on side 0; of a ring without meaning
    second: int  # i
    x: float  # m, from centre to centre
    y: float
    overlap: float  # m, of the undeformed circles
    sign: float  # of the normal, outward of side 0: 1, of a bore −1
    c: float  # cosine and sine of the turn of side 0
    s: float
    away_x: float  # m, rigid motion that is in the displacement of side 0
    away_y: float


@part
def meet(pair, j, rollers):
    """How roller j meets its partner in a pair."""
    centre = rollers.centre
    if pair.surface is not None:
        x, y = centre[0, j] - pair.centre[0], centre[1, j] - pair.centre[1]
        overlap = pair.sign * (pair.radius - sqrt(x * x + y * y)) + rollers.radius
        away = pair.counted_from
        return Meeting(j, j, x, y, overlap, pair.sign, pair.frame[1], pair.frame[2], away[0], away[1])
    i = next_roller(j, rollers.n)
    x, y = centre[0, i] - centre[0, j], centre[1, i] - centre[1, j]
    overlap = 2.0 * rollers.radius - sqrt(x * x + y * y)
    return Meeting(j, i, x, y, overlap, 1.0, rollers.cosine[j], rollers.sine[j], 0.0, 0.0)


@verb
def press_points(pair, rollers, disc, contacts, drive):
    """Forces of a pair at the present positions and their impulses in a step; of no contacts `normal_forces`."""
    normal_forces(pair, rollers, disc, contacts, drive)


@press_points.of(Pair)
def _press_contacts(pair, rollers, disc, contacts, drive):
    """Normal forces of a pair's contacts.

    A contact wider than the points given to it makes its force not a number, which stops the run; a single point stands
    for any width.
    """
    points, forces, row = contacts.points, contacts.forces, pair.row
    for j in range(rollers.n):
        meeting = meet(pair, j, rollers)
        forces.force[row, j] = 0.0
        if meeting.overlap < -contacts.reach:
            points.energy[row, j] = 0.0
            forces.approach[row, j], forces.kick[row, j] = np.nan, 0.0
            points.before[row, j, 0, 0] = np.nan
            continue
        distance = sqrt(meeting.x * meeting.x + meeting.y * meeting.y)
        normal = contacts.patches.normal
        normal[row, 0, j], normal[row, 1, j] = meeting.x / distance, meeting.y / distance
        _press(pair, meeting, distance, rollers, disc, contacts, drive)


press_all_points = every(press_points)


class Side(NamedTuple):
    """One surface of a contact of points."""

    number: int  # 0 or 1
    patch: int  # where it stands in `Patches`
    column: int  # roller; of a ring without meaning
    sign: float  # the surface's outward direction is ±n
    nx: float
    ny: float
    c: float  # cosine and sine of the body's turn
    s: float
    at: float  # where the line of centres meets it, in node spacings
    start: int  # first node of the patch that holds all points
    per_radian: float  # node spacings


@part
def _side(pair, meeting, number, turn, n_nodes, normal, contacts):
    """One surface of a contact, whose patch is cleared."""
    (nx, ny), (c, s) = normal, turn
    patches, points = contacts.patches, contacts.points
    patch = 2 * pair.row + number
    j, column, sign, facing = meeting.first, meeting.second, -meeting.sign, -meeting.sign
    if number == 0:
        column, sign, facing = meeting.first, meeting.sign, 1.0
    for k in range(patches.weight.shape[1]):
        patches.weight[patch, k, j] = 0.0
    bx, by = facing * (c * nx + s * ny), facing * (c * ny - s * nx)
    patches.outward[patch, 0, j], patches.outward[patch, 1, j] = bx, by
    per_radian, at = n_nodes / (2.0 * np.pi), place(bx, by, n_nodes)
    beyond = 0 if points.spread is None else 2  # nodes of a patch before its centre's
    start = int(np.floor(at - abs(points.shift[pair.row, number, 0]) * per_radian)) - beyond
    return Side(number, patch, column, sign, nx, ny, c, s, at, start, per_radian)


@part
def _point(side, row, q, points):
    """A point of a side: its position in node spacings, and the direction of the normal over cos φ, ±n + tan φ t.

    In fixed axes and in the body's frame.
    """
    x, tan = side.at + points.shift[row, side.number, q] * side.per_radian, points.tangent[row, side.number, q]
    mx, my = side.sign * side.nx - tan * side.ny, side.sign * side.ny + tan * side.nx
    return x, (mx, my), (side.c * mx + side.s * my, side.c * my - side.s * mx)


@part
def _read_side(surface, side, row, q, points, away):
    """Motion of a side's surface at a point along its normal over cos φ, across it, and the first's change per rad."""
    x, (mx, my), (fx, fy) = _point(side, row, q, points)
    away_x, away_y = away
    place_point(x, points, side.number, q, points.spread)
    at = (side.number, q, points.closing.size)
    out, sideways, rate = read_point(surface, side.column, x, fx, fy, at, points.spread)
    out -= away_x * mx + away_y * my
    sideways -= away_y * mx - away_x * my
    sagitta = points.sagitta[row, side.number]
    if sagitta != 0.0:
        depth, slope = chord(x - np.floor(x))
        out -= sagitta * depth
        rate -= sagitta * slope
    return out, sideways, rate * side.per_radian


@part
def _close(row, surface, disc, side0, side1, meeting, points):
    """What every point of a contact closes by, and how that turns with the bodies."""
    closing, turning = points.closing, points.turning
    for q in range(closing.size):
        away = (meeting.away_x, meeting.away_y)
        out0, sideways0, rate0 = _read_side(surface, side0, row, q, points, away)
        out1, sideways1, rate1 = _read_side(disc, side1, row, q, points, (0.0, 0.0))
        closing[q] = meeting.overlap - points.rise[row, q] + out0 + out1
        turning[0, q], turning[1, q], turning[2, q] = rate0, rate1, sideways0 + sideways1


@part(inlined=False)
def _press(pair, meeting, distance, rollers, disc, contacts, drive):
    """One contact of points: its forces, and their impulses in a step."""
    points, forces, patches, row, j = contacts.points, contacts.forces, contacts.patches, pair.row, meeting.first
    surface, normal = first_surface(pair, disc), (patches.normal[row, 0, j], patches.normal[row, 1, j])
    turn1 = (rollers.cosine[meeting.second], rollers.sine[meeting.second])
    side0 = _side(pair, meeting, 0, (meeting.c, meeting.s), surface.n_nodes, normal, contacts)
    side1 = _side(pair, meeting, 1, turn1, disc.n_nodes, normal, contacts)
    _close(row, surface, disc, side0, side1, meeting, points)
    energy = _point_forces(points, row, j, points.spread)
    given = _push_points(pair, side0, side1, disc, contacts, energy, drive.dt)
    forces.kick[row, j] = given.normal
    points.energy[row, j] = energy
    if given.normal == 0.0:
        return
    forces.force[row, j] = given.force
    _share(surface, patches, side0, j, given.normal)
    _share(disc, patches, side1, j, given.normal)
    _react(pair, meeting, given, distance, rollers, normal, drive.dt)


class Given(NamedTuple):
    """What a contact's points give in a kick, N and N m; moments on the frames as if undeformed."""

    force: float  # sum of the points' own forces
    normal: float  # of what the kick gives, along n
    aside: float  # times what turns the line of centres, N m
    tilt0: float  # along t, on side 0 and 1
    tilt1: float
    turn0: float
    turn1: float


@part
def _push_points(pair, side0, side1, disc, contacts, energy, dt):
    """Give the surfaces of a contact the impulses of its points."""
    points, forces, patches, row, j = contacts.points, contacts.forces, contacts.patches, pair.row, side0.column
    surface, spread, before, n_points = first_surface(pair, disc), points.spread, points.before, points.closing.size
    single = n_points == 1
    closing, force, turning = points.closing, points.force, points.turning
    correction = 0.0 if single else _correction(points, row, j, energy)
    total, pushed, aside, turn0, turn1, tilt0, tilt1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for q in range(n_points):
        p = force[q]
        total += p
        if single:
            p = _spring_kick(forces.approach[row, j], closing[q], points.stiffness[row])
            forces.approach[row, j] = closing[q]
        else:
            extra = 0.0
            if correction != 0.0:
                extra = correction * (closing[q] - before[row, j, 0, q])
            p += extra
            before[row, j, 0, q], before[row, j, 1, q], before[row, j, 2, q] = closing[q], force[q], extra
        if p == 0.0:
            continue
        x0, _, m0 = _point(side0, row, q, points)
        x1, _, m1 = _point(side1, row, q, points)
        rate0, rate1 = turning[0, q], turning[1, q]
        pushed += p
        aside += p * (rate0 + rate1 + turning[2, q])
        if single:  # what two nodes' shares turn a body by averages out over many points
            rate0 += _lever(x0, surface.n_nodes, surface.radius)
            rate1 += _lever(x1, disc.n_nodes, disc.radius)
        turn0 += p * rate0
        turn1 += p * rate1
        tilt0 += p * points.tangent[row, 0, q]
        tilt1 += p * points.tangent[row, 1, q]
        at0, at1 = (0, q, n_points), (1, q, n_points)
        share_out(patches.weight[side0.patch, :, j], x0, side0.start, p, at0, spread)
        share_out(patches.weight[side1.patch, :, j], x1, side1.start, p, at1, spread)
        if not single:  # else `push_patches` does it, once the slips before this kick are known
            moment = push_point(surface, side0.column, x0, m0, -(p * dt), at0, spread)
            if pair.surface is not None:
                pair.moment[1] += moment
            push_point(disc, side1.column, x1, m1, -(p * dt), at1, spread)
    return Given(total, pushed, aside, tilt0, tilt1, turn0, turn1)


@part
def _react(pair, meeting, given, distance, rollers, normal, dt):
    """Impulses of a contact's points in a step on whole bodies, beside those of their nodes."""
    turned = given.aside / distance
    _push_roller(rollers, meeting.second, -meeting.sign, given.normal, given.tilt1, -turned, normal, dt)
    rollers.turn_kick[meeting.second] += dt * given.turn1 / rollers.inertia
    if pair.surface is not None:
        on_ring = dt * (given.tilt0 + turned)  # along t
        pair.impulse[0] -= on_ring * normal[1]
        pair.impulse[1] += on_ring * normal[0]
        pair.moment[0] -= given.turn0
    else:
        _push_roller(rollers, meeting.first, 1.0, given.normal, given.tilt0, turned, normal, dt)
        rollers.turn_kick[meeting.first] += dt * given.turn0 / rollers.inertia


@part
def _push_roller(rollers, i, sign, pushed, tilt, turned, normal, dt):
    """Impulses on roller i as a whole; the points push along ±n and `tilt`, N, along t, `turned`, N, is the line's."""
    (nx, ny), impulse, body_impulse = normal, rollers.node_impulse, rollers.body_impulse
    impulse[0, i] -= dt * (pushed * sign * nx - tilt * ny)
    impulse[1, i] -= dt * (pushed * sign * ny + tilt * nx)
    aside = dt * (tilt + turned)  # along t
    body_impulse[0, i] -= aside * ny
    body_impulse[1, i] += aside * nx


@part(inlined=False)
def _point_forces(points, row, j, spread):
    """Forces of a contact's points from what they close by; returns the energy stored in them, J.

    Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force = points.closing, points.force
    n = closing.size
    if spread is not None:
        return spread_forces(points, spread, row, j)
    energy = 0.0
    for q in range(n):
        force[q] = points.stiffness[row] * max(closing[q], 0.0)
        if n > 1 and force[q] > 0.0 and (q == 0 or q == n - 1):
            force[q] = np.nan
        energy += 0.5 * force[q] * closing[q]
    return energy


@part(inlined=False)
def _correction(points, row, j, energy):
    """What a kick's forces need beside the points' own, N per m that a point has closed by since the last kick.

    As in `law.kick_force`: the half of a kick that looks back makes the work of the step behind the change of the
    stored energy, and the residual energy is recorded and repaid in small parts. With the points' own forces the
    work is that but where points have opened or closed.
    """
    closing, force, before = points.closing, points.force, points.before
    if np.isnan(before[row, j, 0, 0]):
        return 0.0
    missing, size, extra, moved, total, same = energy - points.energy[row, j], 0.0, 0.0, 0.0, 0.0, True
    for q in range(closing.size):
        step, last = closing[q] - before[row, j, 0, q], before[row, j, 1, q]
        missing -= 0.5 * step * (force[q] + last)
        extra += 0.5 * step * before[row, j, 2, q]
        size += step * step
        moved += abs(step)
        total += force[q]
        same &= (force[q] == 0.0) == (last == 0.0)
    if not size > 0.0 or np.isnan(missing):
        return 0.0
    missing = 0.0 if same else missing
    due = points.residual[row, j] - extra
    most = MOST_REPAID * total / moved
    found = missing / size + max(min(REPAID * due / size, most), -most)
    points.residual[row, j] = due + missing - 0.5 * found * size
    return found


@part
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


@part
def _lever(x, n_nodes, radius):
    """Moment about the centre of a unit force along a convex circle's inward radius, given by two nodes' shares, m."""
    spacing, t = 2.0 * np.pi / n_nodes, x - np.floor(x)
    return radius * ((1.0 - t) * np.sin(t * spacing) - t * np.sin((1.0 - t) * spacing))


@verb
def _share(surface, patches, side, j, total):
    """Where a patch's nodes stand and their shares in a contact's force; of a ring by their directions too."""


@part
def _share_nodes(patches, side, j, n_nodes, total):
    patches.start[side.patch, j] = side.start % n_nodes
    for k in range(patches.weight.shape[1]):
        patches.weight[side.patch, k, j] /= total


@_share.of(DiscSurface)
def _share_disc(disc, patches, side, j, total):
    _share_nodes(patches, side, j, disc.n_nodes, total)
    for k in range(patches.weight.shape[1]):
        node = disc.first + (side.start + k) % disc.n_nodes
        patches.place[side.patch, k, j] = node * 2 * disc.columns + side.column
        patches.inverse_mass[side.patch, k, j] = disc.inverse_mass[node]


@_share.of(RingSurface)
def _share_ring(ring, patches, side, j, total):
    _share_nodes(patches, side, j, ring.n_nodes, total)
    bx, by, weight = patches.outward[side.patch, 0, j], patches.outward[side.patch, 1, j], patches.weight
    for k in range(weight.shape[1]):
        at = HALO + (side.start + k) % ring.n_nodes
        c, s = ring.cosines[at], ring.sines[at]
        patches.place[side.patch, k, j] = 2 * ring.row * ring.cosines.size + at
        patches.along[side.patch, k, j] = weight[side.patch, k, j] * (bx * c + by * s)
        patches.across[side.patch, k, j] = weight[side.patch, k, j] * (by * c - bx * s)
