"""Axes in which elements of the Lagrangian model move: held ones on a ray that turns with the cage, free ones fixed."""

from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import splat


@part
def own_axes(first, group, columns, turned):
    """Cosine and sine of the directions of eight elements' first axes."""
    if first is None:
        return splat(1.0), splat(0.0)
    c, s = load(first, group), load(first, columns + group)
    return c * turned[0] - s * turned[1], s * turned[0] + c * turned[1]


@part
def load_own(first, array, row, group, columns):
    """Of eight elements, along their own axes; the held are on the first."""
    if first is None:
        return load(array, 2 * row * columns + group), load(array, (2 * row + 1) * columns + group)
    return load(array, row * columns + group), splat(0.0)


@part
def store_own(first, array, row, group, columns, along, aside):
    """The same, into the array."""
    if first is None:
        store(array, 2 * row * columns + group, along)
        store(array, (2 * row + 1) * columns + group, aside)
    else:
        store(array, row * columns + group, along)
