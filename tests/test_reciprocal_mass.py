"""Long steps with the reciprocal mass: what turns fast gains no energy by them."""

import numpy as np
import pytest

from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.solver.simulate import make_plan
from lagrange.scene.scene import parse_scene
from tests.reference.whole_run import whole_run

FAST = {
    "material": {"youngs_modulus_GPa": 70.0},
    "operation": {"speed_rpm": 40_000.0, "radial_load_N": 500.0},
    "numerics": {"mesh_size_mm": 2.2, "duration_ms": 1.0, "time_step_safety": 0.65},
}


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_ring_and_rollers_that_turn_fast_keep_their_energy(friction):
    """A stencil applied to velocities along chords, in frames at the step's start, took 3e-4 of it: as Ω⁴ dt³."""
    plan = make_plan(parse_scene(FAST | {"contact": {"friction_coefficient": friction}}, "scene"))
    assert plan.mass is not LUMPED
    found = whole_run(plan)
    assert np.abs(found.imbalance).max() < 3e-5 * found.exchanged[-1]


@pytest.mark.parametrize(
    ("tables", "long_steps"),
    [
        ({}, True),
        ({"operation": {"speed_rpm": 0.0}}, True),
        ({"operation": {"speed_rpm": 500.0}}, False),  # gravity is half of what turning presses rollers outwards by
        ({"operation": {"speed_rpm": 500.0, "gravity_m_s2": 0.0}}, True),
        ({"numerics": {"start": "rest", "load_ramp_ms": 5.0}}, False),
        ({"spall": [{"body": "outer_ring", "angle_deg": 0.0, "width_mm": 1.0}]}, False),
        ({"numerics": {"mesh_size_mm": 0.4}}, False),  # contacts leave too little
    ],
)
def test_steps_are_long_where_nothing_strikes_and_it_pays(tables, long_steps):
    numerics = {"mesh_size_mm": 2.2, "duration_ms": 0.1} | tables.get("numerics", {})
    assert (make_plan(parse_scene(tables | {"numerics": numerics}, "scene")).mass is not LUMPED) is long_steps


@pytest.mark.parametrize("mass", [SECOND, THIRD], ids=["second degree", "third degree"])
@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_contacts_that_roll_feed_no_waves(friction, mass, monkeypatch):
    """Springs that follow momenta instead of places gained 2e-4 in 10 ms with the third degree, and grew on."""
    monkeypatch.setattr("fem.solver.elements.plan.LONG", (mass,))
    tables = {"contact": {"friction_coefficient": friction}, "numerics": {"mesh_size_mm": 2.0, "duration_ms": 15.0}}
    plan = make_plan(parse_scene(tables, "scene"))
    assert plan.mass is mass
    found = whole_run(plan)
    assert np.abs(found.imbalance).max() < 5e-7 * found.exchanged[-1]  # measured 1e-7
