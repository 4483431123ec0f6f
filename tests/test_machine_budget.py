"""The checker's budget of a run of finite elements with all that stands around a bearing at once."""

import numpy as np
import pytest

from fem.interface import simulate
from lagrange.scene.scene import parse_scene
from tests.reference.budgets import budget_terms

pytestmark = pytest.mark.slow  # a time loop of its own
TABLES = {
    "bodies": {"inner_ring": "rigid"},  # whose inertia the checker's equations have all of
    "damping": {"bodies_1_s": 500.0, "contact_N_s_m": 300.0},
    "cage": {
        "mass_kg": 0.05, "guidance": "inner_ring", "guidance_clearance_mm": 0.02, "pocket_clearance_mm": 0.1,
        "friction_coefficient": 0.3, "drag_torque_N_m": 2.0, "damping_N_s_m": 1000.0,
    },
    "support": {
        "kind": "housing", "fit_clearance_um": 20.0, "mass_kg": 0.5, "stiffness_N_per_m": 2e8,
        "damping_N_s_m": 4000.0,
    },
    "sensor": {},
    "operation": {
        "inner_ring_and_shaft_kg": 0.3, "shaft": "springs", "shaft_stiffness_N_per_m": 1e7,
        "shaft_damping_N_s_m": 2e4, "rotating_load_N": 300.0,
    },
    "numerics": {
        "mesh_size_mm": 2.5, "duration_ms": 1.5, "start": "rest", "load_ramp_ms": 0.05, "output_interval_us": 1.0,
    },
}  # fmt: skip
TERMS = {"differentiation", "outer_ring", "shaft", "contact_law", "damping", "friction", "cage", "load_and_weight"}


@pytest.fixture(scope="module")
def found():
    return simulate(parse_scene({"model": "fem"} | TABLES, ""))


def test_the_terms_add_up_to_the_error(found):
    for terms in budget_terms(found.residual()):
        assert set(terms) == TERMS | {"ring_flexibility"}


def test_a_shaft_s_dashpots_know_what_the_cage_s_guide_and_tractions_do_after_them(found):
    """What the run's own forces leave of the hub's equations: 3e-5 of the largest; 3e-4 and 2e-4 where they did not."""
    largest = np.max(found["inner_force"])
    assert np.max(np.hypot(found["cage_guidance_x"], found["cage_guidance_y"])) > 0.1 * largest
    for direction in found.residual().directions:
        left = direction.budget.terms["ring_flexibility"]
        assert np.std(left) < 1e-4 * largest
