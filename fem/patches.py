"""The contact patch: a smooth kernel over six surface nodes.

A cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.
"""

from fem.jit import kernel

N_NODES = 6
FIRST = -2  # the patch of position s spans nodes floor(s) − 2 ... floor(s) + 3


@kernel(forceinline=True)
def weights(t, out, row):
    """Quintic B-spline at the six nodes around a point a fraction t in [0, 1) beyond the third.

    Parameters
    ----------
    t : float; out : ndarray, (n, 6), whose row is filled; the sum is 1, first moments are exact

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    r = 1.0 - t
    t2, r2 = t * t, r * r
    out[row, 0] = r2 * r2 * r / 120.0
    out[row, 5] = t2 * t2 * t / 120.0
    out[row, 1] = (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) / 120.0
    out[row, 4] = (1.0 + t * (5.0 + t * (10.0 + t * (10.0 + t * (5.0 - 5.0 * t))))) / 120.0
    out[row, 2] = (66.0 - t2 * (60.0 - t2 * (30.0 - 10.0 * t))) / 120.0
    out[row, 3] = (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) / 120.0


@kernel(forceinline=True)
def weight_slopes(t, out, row):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    r = 1.0 - t
    t2, r2 = t * t, r * r
    out[row, 0] = -r2 * r2 / 24.0
    out[row, 5] = t2 * t2 / 24.0
    out[row, 1] = -(1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) / 24.0
    out[row, 4] = (1.0 + t * (4.0 + t * (6.0 + t * (4.0 - 5.0 * t)))) / 24.0
    out[row, 2] = -t * (24.0 - t2 * (24.0 - 10.0 * t)) / 24.0
    out[row, 3] = r * (24.0 - r2 * (24.0 - 10.0 * r)) / 24.0
