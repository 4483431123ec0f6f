"""Triangles halved again and again where a picture needs finer ones than the mesh has.

scikit-fem refines too, but rebuilds the whole mesh at each level and doesn't tell what new nodes lie between; here all
columns of nodal data are carried along.
"""

from collections.abc import Callable

import numpy as np

MOST_LEVELS = 14


def refined(
    data: np.ndarray, triangles: np.ndarray, wanted: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Split triangles until none is larger than wanted; no node is left hanging on an edge.

    Parameters
    ----------
    data : (n_nodes, n_columns); the first two columns are the position, m; a new node has the mean of its edge's ends
    triangles : (n_triangles, 3)
    wanted : from middles, (n, 2), m, to the longest edge allowed there, (n,), m

    Returns
    -------
    data, triangles : as given, the old nodes first
    """
    settled = np.zeros((0, 3), dtype=triangles.dtype)  # small enough, which a neighbour's halved edge can undo
    for _ in range(MOST_LEVELS):
        (ax, ay), (bx, by), (cx, cy) = (data[corner, :2].T for corner in triangles.T)
        longest = np.maximum((bx - ax) ** 2 + (by - ay) ** 2, (cx - bx) ** 2 + (cy - by) ** 2)
        longest = np.sqrt(np.maximum(longest, (ax - cx) ** 2 + (ay - cy) ** 2))
        large = longest > wanted(np.column_stack([ax + bx + cx, ay + by + cy]) / 3.0)
        if not large.any():
            break
        split = np.unique(_edges(triangles[large], len(data)))
        reached = np.zeros(len(data), dtype=np.int8)
        reached[triangles[large]] = 1
        triangles = np.concatenate([triangles, settled])
        a, b, c = triangles.T
        touched = reached[a] + reached[b] + reached[c] > 1
        settled, triangles = triangles[~touched], triangles[touched]
        key = _edges(triangles, len(data))
        at = np.minimum(np.searchsorted(split, key), len(split) - 1)
        triangles = _children(triangles, split[at] == key, len(data) + at)
        data = np.concatenate([data, 0.5 * (data[split // len(data)] + data[split % len(data)])])
    return data, np.concatenate([triangles, settled])


def _edges(triangles: np.ndarray, n_nodes: int) -> np.ndarray:
    """One number for each edge, (n, 3), the same for both triangles at it; edge k joins corners k and k + 1."""
    other = np.roll(triangles, -1, axis=1)
    return np.minimum(triangles, other) * n_nodes + np.maximum(triangles, other)


def _children(triangles: np.ndarray, halved: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Four, three or two in place of a triangle with three, two or one halved edges."""
    count = halved.sum(axis=1)
    a, b, c = triangles[count == 3].T
    p, q, r = middle[count == 3].T
    new = [triangles[count == 0], *(np.column_stack(t) for t in ((a, p, r), (p, b, q), (r, q, c), (p, q, r)))]

    (a, b, c), (p, q, _) = _rotated(triangles, middle, count == 2, np.argmin(halved, axis=1) + 1)  # the last edge whole
    new += [np.column_stack(t) for t in ((p, b, q), (a, p, q), (a, q, c))]
    (a, b, c), (p, _, _) = _rotated(triangles, middle, count == 1, np.argmax(halved, axis=1))  # the first edge halved
    new += [np.column_stack(t) for t in ((a, p, c), (p, b, c))]
    return np.concatenate(new)


def _rotated(triangles, middle, chosen, first):
    """Corners and middles of the chosen triangles, counted from another corner on; each (3, n)."""
    order = (first[chosen, None] + np.arange(3)) % 3
    return (np.take_along_axis(array[chosen], order, axis=1).T for array in (triangles, middle))
