"""A run that is kept half way and gone on with by another state of its plan, beside the one that nobody stopped."""

import numpy as np

from fem.solver.solver import Plan, Samples


def rest_of_run(plan: Plan, first: int, rest: int) -> tuple[Samples, Samples]:
    """The samples after the first so many, of the run that was not stopped and of the one that was."""
    whole, half, later = (plan.first_state() for _ in range(3))
    whole.advance(first)
    half.advance(first)
    arrays, numbers = half.to_keep()
    later.done = half.done
    later.take_back({name: array.copy() for name, array in arrays.items()}, numbers)
    return whole.advance(rest).samples, later.advance(rest).samples


def assert_same_bits(found: Samples, expected: Samples) -> None:
    """In every column."""
    assert set(found.values) == set(expected.values)
    for name in expected.values:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)
