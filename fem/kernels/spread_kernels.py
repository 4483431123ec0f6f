"""Forces of pressure points that act through what the mesh lacks between them: a small contact problem.

Find q >= 0 with G q >= c, c what the points close by, and G q = c where q > 0. G depends on the distance alone, so the
inverse for n neighbouring points in contact is known beforehand for every n.
"""

import numpy as np

from fem.kernels.jit import part

MAX_SWEEPS = 1000
SWEPT = 1e-10  # of the largest force: what a sweep may still change


@part(inlined=False)
def spread_forces(points, spread, row, j):
    """Fill `points.force` for contact j of a pair; returns the energy stored below the grid, ½ qᵀG q, J.

    Points in contact are neighbours but for moments when a wave on the surface parts them; those are solved for by
    sweeps. Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force, closed = points.closing, points.force, spread.closed
    n = closing.size
    first, end = closed[row, j, 0], closed[row, j, 1]
    for q in range(n):
        force[q] = 0.0
    if first >= end:
        first = 0
        for q in range(n):
            if closing[q] > closing[first]:
                first = q
        end = first + 1
    found = False
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
            found = True
            break
    pulled = False
    for q in range(first, end):
        pulled |= force[q] < 0.0
    if first < end and (pulled or not found):
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
    """Forces of neighbouring points that are all in contact."""
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
