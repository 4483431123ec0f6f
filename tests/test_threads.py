"""The time loop on several threads: the same motion, the same bits each time, and a clear limit."""

import numba
import numpy as np
import pytest

from fem.errors import UsageError
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.time_loop import advance
from fem.solver.simulate import make_plan
from lagrange.scene import parse_scene
from tests.reference.bearings import arrays, copies, loop_arguments, model, operation, paper

pytestmark = pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core")


def rows(threads):
    """Samples of the paper's bearing over 60 steps."""
    how = operation()
    state = copies(arrays(model(paper(), 2e-3), how, 2e-7, friction=0.1, threads=threads))
    out = np.zeros((4, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
    numba.set_num_threads(threads)
    try:
        advance(*loop_arguments(state), 0, 20, out)
    finally:
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    return out


@pytest.mark.slow
def test_threads_change_nothing_but_round_off():
    one, two, again = rows(1), rows(2), rows(2)
    assert np.array_equal(two, again), "the same number of threads gives the same bits"
    scale = np.abs(one).max(axis=0)
    assert np.all(np.abs(two - one).max(axis=0) <= 1e-9 * np.maximum(scale, 1e-12))
    assert not np.array_equal(one[0], one[-1])


def test_more_threads_than_the_machine_has_are_refused():
    scene = parse_scene({"numerics": {"mesh_size_mm": 2.0, "threads": 64}}, "test")
    with pytest.raises(UsageError, match=r"numerics.threads = 64: .* at most"):
        make_plan(scene)
