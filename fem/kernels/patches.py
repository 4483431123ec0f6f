"""The contact patch: a smooth kernel over six surface nodes.

A cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.
"""

from fem.kernels.jit import kernel, part
from fem.kernels.simd import store

N_NODES = 6
ONE = (0,)  # as long as a contact of one patch


@kernel(forceinline=True)
def first_node(base):
    """Node a patch begins at, where `base` is the node at or before its centre."""
    return base - 2


@kernel(forceinline=True)
def weights(t, out, at, step):
    """Quintic B-spline at the six nodes around a point a fraction t in [0, 1) beyond a node.

    Parameters
    ----------
    t : float or lanes; out : ndarray, filled at flat indices at, at + step, ...; the sum is 1, first moments are exact

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    share = 1.0 / 120.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    store(out, at, r2 * r2 * r * share)
    store(out, at + 5 * step, s2 * s2 * s * share)
    store(out, at + step, (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) * share)
    store(out, at + 4 * step, (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + s * (5.0 - 5.0 * s))))) * share)
    store(out, at + 2 * step, (66.0 - s2 * (60.0 - s2 * (30.0 - 10.0 * s))) * share)
    store(out, at + 3 * step, (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) * share)


@part
def weight_slopes(t, out, at, step):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    share = 1.0 / 24.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    store(out, at, r2 * r2 * -share)
    store(out, at + 5 * step, s2 * s2 * share)
    store(out, at + step, (1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) * -share)
    store(out, at + 4 * step, (1.0 + s * (4.0 + s * (6.0 + s * (4.0 - 5.0 * s)))) * share)
    store(out, at + 2 * step, s * (24.0 - s2 * (24.0 - 10.0 * s)) * -share)
    store(out, at + 3 * step, r * (24.0 - r2 * (24.0 - 10.0 * r)) * share)
