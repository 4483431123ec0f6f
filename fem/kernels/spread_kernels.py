"""Forces of pressure points that act through what the mesh lacks between them: a small contact problem.

Find q >= 0 with G q >= c, c what the points close by, and G q = c where q > 0. G depends on the distance alone, so the
inverse for n neighbouring points in contact is known beforehand for every n.
"""

import numpy as np

from fem.kernels.jit import kernel

MAX_SWEEPS = 1000
SWEPT = 1e-10  # of the largest force: what a sweep may still change


@kernel
def spread_forces(resolved, kind, j):
    """Fill `resolved.force`; returns the energy stored below the grid, ½ qᵀG q, J.

    Points in contact are neighbours but for moments when a wave on the surface parts them; those are solved for by
    sweeps. Not a number where the outermost points are closed: the contact is wider than them.
    """
    closing, force, closed = resolved.closing, resolved.force, resolved.closed
    n = closing.size
    first, end = closed[kind, j, 0], closed[kind, j, 1]
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
        _solve(resolved, kind, first, end)
        if force[first] < 0.0:
            force[first] = 0.0
            first += 1
        elif force[end - 1] < 0.0:
            force[end - 1] = 0.0
            end -= 1
        elif first > 0 and _left(resolved, kind, first - 1, first, end) > 0.0:
            first -= 1
        elif end < n and _left(resolved, kind, end, first, end) > 0.0:
            end += 1
        else:
            found = True
            break
    pulled = False
    for q in range(first, end):
        pulled |= force[q] < 0.0
    if first < end and (pulled or not found):
        first, end = _sweep(resolved, kind)
    closed[kind, j, 0], closed[kind, j, 1] = first, end
    if end > first and (first == 0 or end == n):
        force[first] = np.nan
    energy = 0.0
    for q in range(first, end):
        energy += 0.5 * force[q] * closing[q]
    return energy


@kernel(forceinline=True)
def _solve(resolved, kind, first, end):
    """Forces of neighbouring points that are all in contact."""
    m = end - first
    at = (m - 1) * m * (2 * m - 1) // 6  # matrices of 1, 2 ... m - 1 rows come before
    for q in range(m):
        total = 0.0
        for k in range(m):
            total += resolved.inverse[kind, at + q * m + k] * resolved.closing[first + k]
        resolved.force[first + q] = total


@kernel(forceinline=True)
def _left(resolved, kind, q, first, end):
    """What a point closes by beyond its neighbours' forces in [first, end)."""
    left = resolved.closing[q]
    for k in range(first, end):
        left -= resolved.lack[kind, abs(q - k)] * resolved.force[k]
    return left


@kernel
def _sweep(resolved, kind):
    """Gauss and Seidel's method with q >= 0; returns the range of the points in contact."""
    force, n = resolved.force, resolved.closing.size
    for q in range(n):
        force[q] = max(force[q], 0.0)
    own = resolved.lack[kind, 0]
    for _ in range(MAX_SWEEPS):
        changed, largest = 0.0, 0.0
        for q in range(n):
            new = max(force[q] + _left(resolved, kind, q, 0, n) / own, 0.0)
            changed, largest = max(changed, abs(new - force[q])), max(largest, new)
            force[q] = new
        if changed <= SWEPT * largest:
            break
    first, end = n, 0
    for q in range(n):
        if force[q] > 0.0:
            first, end = min(first, q), q + 1
    return min(first, end), end
