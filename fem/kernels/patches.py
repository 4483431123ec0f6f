"""The contact patch: a smooth kernel over six surface nodes, or six per unit of stretch.

A cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.
On a mesh finer than the contact the spline is stretched over an integer number of node spacings, half-width 2mh, so
that the patch stays wider than the contact. `stretch` is a tuple of m entries: its length is part of its type, and
the loops over the six nodes of the usual patch are compiled as such.
"""

from fem.kernels.jit import kernel

N_NODES = 6  # times the stretch


@kernel(forceinline=True)
def first_node(base, stretch):
    """Node a patch begins at, where `base` is the node at or before its centre (it spans 6m nodes)."""
    return base + 1 - 3 * len(stretch)


@kernel(forceinline=True)
def weights(t, out, row, stretch):
    """Quintic B-spline, knots m spacings apart, at the 6m nodes around a point a fraction t in [0, 1) beyond a node.

    Parameters
    ----------
    t : float; out : ndarray, (n, 6m), whose row is filled; the sum is 1, first moments are exact

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    m = len(stretch)
    share = 1.0 / (120.0 * m)
    for i in range(m):
        r = (i + 1 - t) / m
        s = 1.0 - r
        s2, r2 = s * s, r * r
        out[row, i] = r2 * r2 * r * share
        out[row, 5 * m + i] = s2 * s2 * s * share
        out[row, m + i] = (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) * share
        out[row, 4 * m + i] = (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + s * (5.0 - 5.0 * s))))) * share
        out[row, 2 * m + i] = (66.0 - s2 * (60.0 - s2 * (30.0 - 10.0 * s))) * share
        out[row, 3 * m + i] = (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) * share


@kernel(forceinline=True)
def weight_slopes(t, out, row, stretch):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    m = len(stretch)
    share = 1.0 / (24.0 * m * m)
    for i in range(m):
        r = (i + 1 - t) / m
        s = 1.0 - r
        s2, r2 = s * s, r * r
        out[row, i] = -r2 * r2 * share
        out[row, 5 * m + i] = s2 * s2 * share
        out[row, m + i] = -(1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) * share
        out[row, 4 * m + i] = (1.0 + s * (4.0 + s * (6.0 + s * (4.0 - 5.0 * s)))) * share
        out[row, 2 * m + i] = -s * (24.0 - s2 * (24.0 - 10.0 * s)) * share
        out[row, 3 * m + i] = r * (24.0 - r2 * (24.0 - 10.0 * r)) * share
