"""Functions of eight contacts at once: what laws of contact may use."""

import numpy as np
import pytest

import fem.kernels.lane_functions  # noqa: F401  # teaches kernels numpy's functions of lanes
from fem.kernels.jit import kernel, part
from fem.kernels.lane_memory import load, store


@part
def law(force, stiffness):
    """With every function that laws may use."""
    soft = np.minimum(np.exp(-force), 1.0) + np.log(stiffness) * np.abs(force - 3.0)
    return np.where(force > 2.0, np.sqrt(stiffness) * soft, np.maximum(force, 0.5))


@kernel
def of_eight(force, stiffness, out):
    store(out, 0, law(load(force, 0), load(stiffness, 0)))


@kernel
def of_one(force, stiffness):
    return law(force, stiffness)


def test_a_law_is_the_same_of_arrays_of_one_contact_and_of_eight():
    force, stiffness, out = np.linspace(0.1, 6.0, 8), np.geomspace(1.0, 1e9, 8), np.empty(8)
    of_eight(force, stiffness, out)
    assert out == pytest.approx(law(force, stiffness), rel=1e-12)
    assert [of_one(*pair) for pair in zip(force, stiffness, strict=True)] == pytest.approx(out, rel=1e-12)
