"""The contact patch: a smooth kernel over six surface nodes.

A cubic B-spline pressure of half-width 2h (h = surface spacing) integrated against the hat functions of equally
spaced nodes is the quintic B-spline at the nodes. Four continuous derivatives: nothing happens when a node passes.
"""

from fem.kernels.jit import kernel, part
from fem.kernels.lane_memory import load, store

CORNER = 0.02  # of a facet on either side of a node is rounded: no force jumps where a node passes


@kernel(forceinline=True)
def chord(beyond):
    """Depth below the circle over the sagitta h²/8R, and its slope per facet, a share `beyond` in [0, 1) past a node.

    4 t (1 − t), averaged over CORNER on either side.
    """
    d = beyond if beyond < 0.5 else beyond - 1.0
    if abs(d) < CORNER:
        return CORNER * (2.0 - 4.0 / 3.0 * CORNER) + 2.0 * d * d * (1.0 / CORNER - 2.0), 4.0 * d * (1.0 / CORNER - 2.0)
    return 4.0 * beyond * (1.0 - beyond) - 4.0 / 3.0 * CORNER * CORNER, 4.0 - 8.0 * beyond


N_NODES = 6
ONE = (0,)  # as long as a contact of one patch


@kernel(forceinline=True)
def first_node(base):
    """Node a patch begins at, where `base` is the node at or before its centre."""
    return base - 2


@kernel(forceinline=True)
def weights(t):
    """Quintic B-spline at the six nodes around a point a fraction t in [0, 1), or lanes, beyond a node.

    Their sum is 1, first moments are exact.

    Source: Schoenberg's cardinal B-spline of degree 5.
    """
    share = 1.0 / 120.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    return (
        r2 * r2 * r * share,
        (1.0 + r * (5.0 + r * (10.0 + r * (10.0 + r * (5.0 - 5.0 * r))))) * share,
        (66.0 - s2 * (60.0 - s2 * (30.0 - 10.0 * s))) * share,
        (66.0 - r2 * (60.0 - r2 * (30.0 - 10.0 * r))) * share,
        (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + s * (5.0 - 5.0 * s))))) * share,
        s2 * s2 * s * share,
    )


@part
def weight_slopes(t):
    """Derivatives of `weights` with respect to t, i.e. to the position in surface spacings."""
    share = 1.0 / 24.0
    r, s = 1.0 - t, t
    s2, r2 = s * s, r * r
    return (
        r2 * r2 * -share,
        (1.0 + r * (4.0 + r * (6.0 + r * (4.0 - 5.0 * r)))) * -share,
        s * (24.0 - s2 * (24.0 - 10.0 * s)) * -share,
        r * (24.0 - r2 * (24.0 - 10.0 * r)) * share,
        (1.0 + s * (4.0 + s * (6.0 + s * (4.0 - 5.0 * s)))) * share,
        s2 * s2 * share,
    )


@part
def put(out, at, step, six):
    """Store the values for a patch's nodes at flat indices at, at + step, ..."""
    a, b, c, d, e, f = six
    store(out, at, a)
    store(out, at + step, b)
    store(out, at + 2 * step, c)
    store(out, at + 3 * step, d)
    store(out, at + 4 * step, e)
    store(out, at + 5 * step, f)


@part
def take(array, at, step):
    """Eight contacts' values for a patch's nodes from flat indices at, at + step, ..."""
    return (
        load(array, at),
        load(array, at + step),
        load(array, at + 2 * step),
        load(array, at + 3 * step),
        load(array, at + 4 * step),
        load(array, at + 5 * step),
    )


@part
def dot(one, other):
    """Sum of the products of two sets of six."""
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return ((a * p + b * q) + (c * r + d * s)) + (e * t + f * u)


@part
def times(factor, six):
    """Six values times a factor."""
    a, b, c, d, e, f = six
    return factor * a, factor * b, factor * c, factor * d, factor * e, factor * f


@part
def products(one, other):
    """Products of two sets of six, one by one."""
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return a * p, b * q, c * r, d * s, e * t, f * u


@part
def combined(x, one, y, other):
    """x·one + y·other, of two sets of six."""
    a, b, c, d, e, f = one
    p, q, r, s, t, u = other
    return x * a + y * p, x * b + y * q, x * c + y * r, x * d + y * s, x * e + y * t, x * f + y * u
