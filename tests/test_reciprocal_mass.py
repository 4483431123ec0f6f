"""Long steps with the reciprocal mass: what turns fast gains no energy by them."""

import numpy as np
import pytest

from fem.solver.simulate import make_plan, run
from lagrange.scene import parse_scene

FAST = {
    "material": {"youngs_modulus_GPa": 70.0},
    "operation": {"speed_rpm": 40_000.0, "radial_load_N": 500.0},
    "numerics": {"mesh_size_mm": 2.2, "duration_ms": 1.0},
}


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_ring_and_rollers_that_turn_fast_keep_their_energy(friction):
    """A stencil applied to velocities along chords, in frames at the step's start, took 3e-4 of it: as Ω⁴ dt³."""
    plan = make_plan(parse_scene(FAST | {"contact": {"friction_coefficient": friction}}, "scene"))
    assert plan.share > 0.0
    blocks = []
    run(plan, blocks.append)
    imbalance = np.concatenate([block.imbalance for block in blocks])
    assert np.abs(imbalance).max() < 3e-5 * blocks[-1].exchanged[-1]
