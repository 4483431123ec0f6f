"""The contact patch: a smooth kernel over six surface nodes, or six per unit of stretch.

A cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.
On a mesh finer than the contact the spline is stretched over an integer number of node spacings, half-width 2mh, so
that the patch stays wider than the contact. `stretch` is a tuple of m entries: its length is part of its type, and
the loops over the six nodes of the usual patch are compiled as such.
"""

from fem.kernels.jit import kernel
from fem.kernels.simd import store

N_NODES = 6  # times the stretch
ONE = (0,)


@kernel(forceinline=True)
def first_node(base, stretch):
    """Node a patch begins at, where `base` is the node at or before its centre (it spans 6m nodes)."""
    return base + (1 - 3 * len(stretch))


@kernel(forceinline=True)
def weights(t, out, at, step, stretch):
    """Quintic B-spline, knots m spacings apart, at the 6m nodes around a point a fraction t in [0, 1) beyond a node.

    Parameters
    ----------
    t : float or lanes; out : ndarray, filled at flat indices at, at + step, ...; the sum is 1, first moments are exact

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    m = len(stretch)
    share, over, ahead = 1.0 / (120.0 * m), 1.0 / m, m * step
    for i in range(m):
        r = (i + 1.0 - t) * over
        s = 1.0 - r
        s2, r2 = s * s, r * r
        k = at + i * step
        store(out, k, r2 * r2 * r * share)
        store(out, k + 5 * ahead, s2 * s2 * s * share)
        store(out, k + ahead, (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) * share)
        store(out, k + 4 * ahead, (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + s * (5.0 - 5.0 * s))))) * share)
        store(out, k + 2 * ahead, (66.0 - s2 * (60.0 - s2 * (30.0 - 10.0 * s))) * share)
        store(out, k + 3 * ahead, (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) * share)


@kernel(forceinline=True)
def weight_slopes(t, out, at, step, stretch):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    m = len(stretch)
    share, over, ahead = 1.0 / (24.0 * m * m), 1.0 / m, m * step
    for i in range(m):
        r = (i + 1.0 - t) * over
        s = 1.0 - r
        s2, r2 = s * s, r * r
        k = at + i * step
        store(out, k, r2 * r2 * -share)
        store(out, k + 5 * ahead, s2 * s2 * share)
        store(out, k + ahead, (1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) * -share)
        store(out, k + 4 * ahead, (1.0 + s * (4.0 + s * (6.0 + s * (4.0 - 5.0 * s)))) * share)
        store(out, k + 2 * ahead, s * (24.0 - s2 * (24.0 - 10.0 * s)) * -share)
        store(out, k + 3 * ahead, r * (24.0 - r2 * (24.0 - 10.0 * r)) * share)
