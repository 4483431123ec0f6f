"""Contacts as pressures at points between exact circles: resolved by the mesh, or with points spread over patches.

For two circles with unit normal n along the line of centres and t = Jn, the points at transverse distance s from that
line face each other. Their gap along n is that of the undeformed circles less what the surfaces' outward displacements
along their own normals m₁(s), m₂(s) close of it,

    g(s) = g₀(s, d) − U₁·m₁ / cos φ₁ − U₂·m₂ / cos φ₂,    sin φ_i = s / r_i,

The points stand still relative to the contact while nodes pass through it. Where the mesh resolves the contact U is
interpolated linearly between nodes and a stiff layer resists, p = ε ⟨−g⟩; else (`spread`, a run compiles the one it
uses) U is the mean over a patch and the forces follow from what the mesh lacks, a small contact problem: find q >= 0
with G q >= c, c the overlap at the points, and G q = c where q > 0. G depends on the distance alone, so the inverse for
n neighbouring points in contact is known beforehand for every n. Either way all are the gradient of one potential,
Σ ½ ε g² Δs L or ½ qᵀG q, as in `contacts`.

The contacts that other programs have on a coarse mesh, kept for comparison, are a single point on the line of centres:
a penalty spring between the nodes around it. With facets U·m includes what the chords lack of the circles.

Positions are in node spacings, and may lie one turn outside; m is a direction in the body's frame.

Equations (4) and (5) of docs/method.md.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from fem.kernels.elements.contacts import first_surface
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import DiscSurface, Pair, RingSurface
from fem.kernels.elements.surfaces import N_NODES, chord, first_node, put, weight_slopes, weights
from fem.kernels.jit import every, part
from fem.kernels.law import MOST_REPAID, REPAID, place

MAX_SWEEPS = 1000
SWEPT = 1e-10  # of the largest force: what a sweep may still change


class Side(NamedTuple):
    """One surface of a contact: of a ring or roller j, number 0, or of roller i, number 1."""

    number: int
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
def _side(pair, number, column, c, s, n_nodes, j, contacts):
    """One surface of contact j, of a body turned by c and s; its patch is cleared."""
    patches, points, patch = contacts.patches, contacts.points, 2 * pair.row + number
    nx, ny = patches.normal[pair.row, 0, j], patches.normal[pair.row, 1, j]
    sign, facing = pair.sign, 1.0
    if number == 1:
        sign = facing = -pair.sign
    for k in range(patches.weight.shape[1]):
        patches.weight[patch, k, j] = 0.0
    bx, by = facing * (c * nx + s * ny), facing * (c * ny - s * nx)
    patches.outward[patch, 0, j], patches.outward[patch, 1, j] = bx, by
    per_radian, at = n_nodes / (2.0 * np.pi), place(bx, by, n_nodes)
    beyond = 0 if points.spread is None else 2  # nodes of a patch before its centre's
    start = int(np.floor(at - abs(points.shift[pair.row, number, 0]) * per_radian)) - beyond
    return Side(number, patch, column, sign, nx, ny, c, s, at, start, per_radian)


@part
def _press_contacts(pair, rollers, disc, contacts, drive):
    """Normal forces of a pair's contacts at the present positions and their impulses in a step.

    A contact wider than the points given to it makes its force not a number, which stops the run; a single point stands
    for any width.
    """
    points, forces, row, centre = contacts.points, contacts.forces, pair.row, rollers.centre
    normal = contacts.patches.normal
    for j in range(rollers.n):
        i = j + 1 if j + 1 < rollers.n else 0
        if pair.surface is not None:
            i = j
            x, y = centre[0, j] - pair.centre[0], centre[1, j] - pair.centre[1]
            overlap = pair.sign * (pair.radius - sqrt(x * x + y * y)) + rollers.radius
        else:
            x, y = centre[0, i] - centre[0, j], centre[1, i] - centre[1, j]
            overlap = 2.0 * rollers.radius - sqrt(x * x + y * y)
        forces.force[row, j] = 0.0
        if overlap < -contacts.reach:
            points.energy[row, j] = 0.0
            forces.approach[row, j], forces.kick[row, j] = np.nan, 0.0
            points.before[row, j, 0, 0] = np.nan
            continue
        distance = sqrt(x * x + y * y)
        normal[row, 0, j], normal[row, 1, j] = x / distance, y / distance
        _press(pair, j, i, overlap, distance, rollers, disc, contacts, drive.dt)


press_all_points = every(_press_contacts, Pair)


@part(inlined=False)
def _press(pair, j, i, overlap, distance, rollers, disc, contacts, dt):
    """One contact of points, of a ring or roller j with roller i: its forces, and their impulses in a step.

    Those that turn the line of centres, N m, and tilts of normals act on bodies as a whole; moments on frames are those
    of undeformed ones.
    """
    points, forces, patches, row, sign = contacts.points, contacts.forces, contacts.patches, pair.row, pair.sign
    surface, before, n_points = first_surface(pair, disc), points.before, points.closing.size
    closing, force, turning, single = points.closing, points.force, points.turning, points.closing.size == 1
    nx, ny = patches.normal[row, 0, j], patches.normal[row, 1, j]
    c, s, away_x, away_y = rollers.cosine[j], rollers.sine[j], 0.0, 0.0
    if pair.surface is not None:
        c, s, away_x, away_y = pair.frame[1], pair.frame[2], pair.counted_from[0], pair.counted_from[1]
    one = _side(pair, 0, j, c, s, surface.n_nodes, j, contacts)
    other = _side(pair, 1, i, rollers.cosine[i], rollers.sine[i], disc.n_nodes, j, contacts)
    for q in range(n_points):
        out_0, sideways_0, rate_0 = _read_side(surface, one, row, q, points, away_x, away_y)
        out_1, sideways_1, rate_1 = _read_side(disc, other, row, q, points, 0.0, 0.0)
        closing[q] = overlap - points.rise[row, q] + out_0 + out_1
        turning[0, q], turning[1, q], turning[2, q] = rate_0, rate_1, sideways_0 + sideways_1
    energy = 0.0  # stored; not a number where the outermost points are closed: the contact is wider than them
    if points.spread is not None:
        energy = spread_forces(points, points.spread, row, j)
    else:
        for q in range(n_points):
            force[q] = points.stiffness[row] * max(closing[q], 0.0)
            if n_points > 1 and force[q] > 0.0 and (q == 0 or q == n_points - 1):
                force[q] = np.nan
            energy += 0.5 * force[q] * closing[q]
    correction = 0.0 if single else _correction(points, row, j, energy)
    total, pushed, aside, turn_0, turn_1, tilt_0, tilt_1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
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
        x_0, _, _, mx_0, my_0 = _point(one, row, q, points)
        x_1, _, _, mx_1, my_1 = _point(other, row, q, points)
        rate_0, rate_1 = turning[0, q], turning[1, q]
        pushed += p
        aside += p * (rate_0 + rate_1 + turning[2, q])
        if single:  # what two nodes' shares turn a body by averages out over many points
            rate_0 += _lever(x_0, surface.n_nodes, surface.radius)
            rate_1 += _lever(x_1, disc.n_nodes, disc.radius)
        turn_0 += p * rate_0
        turn_1 += p * rate_1
        tilt_0 += p * points.tangent[row, 0, q]
        tilt_1 += p * points.tangent[row, 1, q]
        _share_out(patches.weight[one.patch, :, j], x_0, one.start, p, points, q)
        _share_out(patches.weight[other.patch, :, j], x_1, other.start, p, points, n_points + q)
        if not single:  # else `push_patches` does it, once the slips before this kick are known
            moment = _push_point(surface, one.column, x_0, mx_0, my_0, -(p * dt), points, q)
            if pair.surface is not None:
                pair.moment[1] += moment
            _push_point(disc, other.column, x_1, mx_1, my_1, -(p * dt), points, n_points + q)
    forces.kick[row, j] = pushed
    points.energy[row, j] = energy
    if pushed == 0.0:
        return
    forces.force[row, j] = total
    _share(surface, patches, one, j, pushed)
    _share(disc, patches, other, j, pushed)
    turned = aside / distance
    _push_roller(rollers, i, -sign, pushed, tilt_1, -turned, nx, ny, dt)
    rollers.turn_kick[i] += dt * turn_1 / rollers.inertia
    if pair.surface is not None:
        on_ring = dt * (tilt_0 + turned)  # along t
        pair.impulse[0] -= on_ring * ny
        pair.impulse[1] += on_ring * nx
        pair.moment[0] -= turn_0
    else:
        _push_roller(rollers, j, 1.0, pushed, tilt_0, turned, nx, ny, dt)
        rollers.turn_kick[j] += dt * turn_0 / rollers.inertia


@part
def _push_roller(rollers, i, sign, pushed, tilt, turned, nx, ny, dt):
    """Impulses on roller i as a whole; the points push along ±n and `tilt`, N, along t, `turned`, N, is the line's."""
    impulse, body_impulse = rollers.node_impulse, rollers.body_impulse
    impulse[0, i] -= dt * (pushed * sign * nx - tilt * ny)
    impulse[1, i] -= dt * (pushed * sign * ny + tilt * nx)
    along = dt * (tilt + turned)  # t
    body_impulse[0, i] -= along * ny
    body_impulse[1, i] += along * nx


# points of a surface; `at` : number of a point, those of side 1 behind those of side 0


@part
def _point(side, row, q, points):
    """A point of a side: its position, and the direction of the normal over cos φ, ±n + tan φ t.

    In fixed axes and in the body's frame.
    """
    x, tan = side.at + points.shift[row, side.number, q] * side.per_radian, points.tangent[row, side.number, q]
    mx, my = side.sign * side.nx - tan * side.ny, side.sign * side.ny + tan * side.nx
    return x, mx, my, side.c * mx + side.s * my, side.c * my - side.s * mx


@part
def _read_side(surface, side, row, q, points, away_x, away_y):
    """Motion of a side's surface at a point along its normal over cos φ, across it, and the first's change per rad."""
    x, mx, my, fx, fy = _point(side, row, q, points)
    first, base, out, sideways, rate = points.closing.size * side.number + q, int(np.floor(x)), 0.0, 0.0, 0.0
    share, slope, change, t = points.share, points.slope, side.number * N_NODES, x - base
    first *= N_NODES
    if points.spread is not None:
        put(share, first, 1, weights(t))
        put(slope, change, 1, weight_slopes(t))
    else:  # the two nodes beside
        put(share, first, 1, (0.0, 0.0, 1.0 - t, t, 0.0, 0.0))
        put(slope, change, 1, (0.0, 0.0, -1.0, 1.0, 0.0, 0.0))
    node = first_node(base) % surface.n_nodes
    for k in range(N_NODES):
        along, across = _node_motion(surface, node, side.column, fx, fy)
        out += share[first + k] * along
        sideways += share[first + k] * across
        rate += slope[change + k] * along
        node = node + 1 if node + 1 < surface.n_nodes else 0
    out -= away_x * mx + away_y * my
    sideways -= away_y * mx - away_x * my
    sagitta = points.sagitta[row, side.number]
    if sagitta != 0.0:
        depth, falling = chord(t)
        out -= sagitta * depth
        rate -= sagitta * falling
    return out, sideways, rate * side.per_radian


@part
def _node_motion(surface, node, column, mx, my):
    if isinstance(surface, RingSurface):
        node += HALO
        c = mx * surface.cosines[node] + my * surface.sines[node]
        s = my * surface.cosines[node] - mx * surface.sines[node]
        a, b = surface.u[surface.row, 0, node], surface.u[surface.row, 1, node]
        return a * c + b * s, b * c - a * s
    if isinstance(surface, DiscSurface):
        at = (node + surface.first) * 2 * surface.columns + column
        a, b = surface.u[at], surface.u[at + surface.columns]
        return a * mx + b * my, b * mx - a * my


@part
def _push_point(surface, column, x, mx, my, impulse, points, at):
    """Give a surface an impulse along m, N s, at a position; returns its moment about the origin, N m s."""
    node, moment = first_node(int(np.floor(x))) % surface.n_nodes, 0.0
    for k in range(N_NODES):
        given = impulse * points.share[at * N_NODES + k]
        if isinstance(surface, RingSurface):
            i, row, w, u = node + HALO, surface.row, surface.w, surface.u
            radial = given * (mx * surface.cosines[i] + my * surface.sines[i])
            around = given * (my * surface.cosines[i] - mx * surface.sines[i])
            w[row, 0, i] += radial / surface.node_mass
            w[row, 1, i] += around / surface.node_mass
            moment += (surface.radius + u[row, 0, i]) * around - u[row, 1, i] * radial
        elif isinstance(surface, DiscSurface):
            over = surface.inverse_mass[node + surface.first]
            i = (node + surface.first) * 2 * surface.columns + column
            surface.w[i] += given * mx * over
            surface.w[i + surface.columns] += given * my * over
        node = node + 1 if node + 1 < surface.n_nodes else 0
    return moment


@part
def _share_out(weight, x, start, p, points, at):
    """Add a point's force to the nodes' shares of a patch, (width,), for friction, which is spread as pressure is."""
    first = first_node(int(np.floor(x))) - start
    for k in range(N_NODES):
        if 0 <= first + k and first + k < weight.size:
            weight[first + k] += p * points.share[at * N_NODES + k]


@part
def _share(surface, patches, side, j, total):
    """Where a patch's nodes stand and their shares in a contact's force; of a ring by their directions too."""
    patch, weight = side.patch, patches.weight
    patches.start[patch, j] = side.start % surface.n_nodes
    bx, by = patches.outward[patch, 0, j], patches.outward[patch, 1, j]
    for k in range(weight.shape[1]):
        weight[patch, k, j] /= total
        node = (side.start + k) % surface.n_nodes
        if isinstance(surface, DiscSurface):
            patches.place[patch, k, j] = (surface.first + node) * 2 * surface.columns + side.column
            patches.inverse_mass[patch, k, j] = surface.inverse_mass[surface.first + node]
        if isinstance(surface, RingSurface):
            at = HALO + node
            c, s = surface.cosines[at], surface.sines[at]
            patches.place[patch, k, j] = 2 * surface.row * surface.cosines.size + at
            patches.along[patch, k, j] = weight[patch, k, j] * (bx * c + by * s)
            patches.across[patch, k, j] = weight[patch, k, j] * (by * c - bx * s)


@part
def _lever(x, n_nodes, radius):
    """Moment about the centre of a unit force along a convex circle's inward radius, given by two nodes' shares, m."""
    spacing, t = 2.0 * np.pi / n_nodes, x - np.floor(x)
    return radius * ((1.0 - t) * np.sin(t * spacing) - t * np.sin((1.0 - t) * spacing))


# forces of points


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
    more = missing / size + max(min(REPAID * due / size, most), -most)
    points.residual[row, j] = due + missing - 0.5 * more * size
    return more


@part
def _spring_kick(before, now, stiffness):
    """Force of a linear spring that a leapfrog kick gives, N: `law.kick_force`, as rattling contacts need it.

    `before`, `now` : float, m, closing at the kick before and at this one; negative: apart, NaN: not known.
    """
    Q, last = stiffness * max(now, 0.0), stiffness * max(before, 0.0)
    if np.isnan(before) or before * now >= 0.0:  # closed at both, the spring's own force does just that work
        return Q
    return 0.5 * (Q - last + (Q * now - last * before) / (now - before))


@part(inlined=False)
def spread_forces(points, spread, row, j):
    """Fill `points.force` for contact j of a pair; returns the energy stored below the grid, ½ qᵀG q, J.

    Points in contact are neighbours but for moments when a wave on the surface parts them; those are solved for by
    sweeps. Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force, closed = points.closing, points.force, spread.closed
    n, first, end, solved = closing.size, closed[row, j, 0], closed[row, j, 1], False
    force[:] = 0.0
    if first >= end:
        first = np.argmax(closing)
        end = first + 1
    for _ in range(2 * n):
        if first == end:
            break
        _solve(points, spread, row, first, end)
        if force[first] < 0.0:
            force[first] = 0.0
            first += 1
        elif force[end - 1] < 0.0:
            force[end - 1] = 0.0
            end -= 1
        elif first > 0 and _left(points, spread, row, first - 1, first, end) > 0.0:
            first -= 1
        elif end < n and _left(points, spread, row, end, first, end) > 0.0:
            end += 1
        else:
            solved = True
            break
    pulled = False
    for q in range(first, end):
        pulled |= force[q] < 0.0
    if first < end and (pulled or not solved):
        first, end = _sweep(points, spread, row)
    closed[row, j, 0], closed[row, j, 1] = first, end
    if end > first and (first == 0 or end == n):
        force[first] = np.nan
    energy = 0.0
    for q in range(first, end):
        energy += 0.5 * force[q] * closing[q]
    return energy


@part
def _solve(points, spread, row, first, end):
    m = end - first
    at = (m - 1) * m * (2 * m - 1) // 6  # matrices of 1, 2 ... m - 1 rows come before
    for q in range(m):
        total = 0.0
        for k in range(m):
            total += spread.inverse[row, at + q * m + k] * points.closing[first + k]
        points.force[first + q] = total


@part
def _left(points, spread, row, q, first, end):
    """What a point closes by beyond its neighbours' forces in [first, end)."""
    left = points.closing[q]
    for k in range(first, end):
        left -= spread.missing[row, abs(q - k)] * points.force[k]
    return left


@part(inlined=False)
def _sweep(points, spread, row):
    """Gauss and Seidel's method with q >= 0; returns the range of the points in contact."""
    force, n = points.force, points.closing.size
    for q in range(n):
        force[q] = max(force[q], 0.0)
    own = spread.missing[row, 0]
    for _ in range(MAX_SWEEPS):
        changed, largest = 0.0, 0.0
        for q in range(n):
            new = max(force[q] + _left(points, spread, row, q, 0, n) / own, 0.0)
            changed, largest = max(changed, abs(new - force[q])), max(largest, new)
            force[q] = new
        if changed <= SWEPT * largest:
            break
    first, end = n, 0
    for q in range(n):
        if force[q] > 0.0:
            first, end = min(first, q), q + 1
    return min(first, end), end
