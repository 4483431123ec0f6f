"""Facets: how a polygon's chords fall away from the circle through its nodes."""

from fem.kernels.jit import kernel

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
