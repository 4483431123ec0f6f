"""Runs of the reduced model that restart with shorter steps, and those that don't; how hard their shocks are."""

import numpy as np
import pytest

from fem.solver import row_state, simulate
from fem.solver.simulate import make_plan, run
from lagrange.scene.scene import parse_scene
from tests.reference.reduced_runs import CLEARANCE, RATTLES, in_longer_steps, plan_of, ran, samples_of

SOFT = {  # 41 plastic rollers in plastic rings: forces on others give a contact as much as its own
    "model": "reduced",
    "bearing": {
        "rollers": 41, "roller_diameter_mm": 27.2, "roller_length_mm": 17.0,
        "inner_raceway_diameter_mm": 495.0, "outer_raceway_diameter_mm": 549.4,
        "bore_diameter_mm": 204.0, "outside_diameter_mm": 656.0,
    },
    "material": {
        "roller": {"youngs_modulus_GPa": 3.9, "density_kg_m3": 8000.0, "poisson_ratio": 0.36},
        "inner_ring": {"youngs_modulus_GPa": 1.1, "density_kg_m3": 8300.0, "poisson_ratio": 0.05},
        "outer_ring": {"youngs_modulus_GPa": 3.4, "density_kg_m3": 14_700.0, "poisson_ratio": 0.06},
    },
    "operation": {"speed_rpm": 1380.0, "radial_load_N": 4900.0, "inner_ring_and_shaft_kg": 68.0},
    "numerics": {"duration_ms": 2.0, "start": "rest", "load_ramp_ms": 0.2},
}  # fmt: skip


def test_a_run_whose_energy_does_not_balance_restarts_with_half_the_step():
    plan = in_longer_steps(RATTLES)
    state, _, told = ran(plan)
    assert len(told) == 1 and "restarts with half" in told[0][0]
    assert state.outcome_attributes["time_step"] == pytest.approx(0.5 * plan.time_step)
    assert abs(state.imbalance) < 1e-3


@pytest.mark.parametrize(("friction", "most"), [(0.1, 1e-3), (0.0, 4e-3)])
def test_contacts_that_open_pay_what_they_owe(friction, most):
    """Paths are chaotic, so of three: where nothing is paid energy is 1.3e-3 off, and 8e-3 without friction."""
    worst = []
    for degrees in (-90.0, -89.63, -89.26):
        operation = RATTLES["operation"] | {"first_roller_deg": degrees}
        tables = RATTLES | {"operation": operation, "contact": {"friction_coefficient": friction}}
        found = samples_of(make_plan(parse_scene(tables, "test")))
        worst.append(np.abs(found["imbalance"]).max() / found["exchanged"][-1])
    assert max(worst) < most


@pytest.mark.parametrize("halvings", range(7))
def test_a_run_that_restarts_turns_as_its_times_say(halvings):
    """Whatever the number of steps between samples: rollers turn from sample to sample by their spin, to its noise."""
    plan = plan_of("numerics.output_interval_us=14", "numerics.duration_ms=0.14")
    state = plan.first_state()
    state._halvings = halvings
    state._begin()
    samples = state.advance(plan.n_samples).samples
    turned = np.diff(samples["roller_turn"], axis=0)
    spun = 0.5 * (samples["roller_spin"][1:] + samples["roller_spin"][:-1]) * np.diff(samples["time"])[:, None]
    np.testing.assert_allclose(turned, spun, rtol=1e-4)
    assert state.progress.steps == plan.stride * 2**halvings * (plan.n_samples - 1)


def test_a_run_that_goes_wrong_restarts_before_its_end(monkeypatch):
    """Rollers that rattle without friction: energy is lost from the first impacts on."""
    monkeypatch.setattr(simulate, "LARGEST_BLOCK", 1000)  # samples, of a run too short for blocks by its time
    plan = in_longer_steps(RATTLES)
    state, _, told = ran(plan)
    assert len(told) >= 1
    assert told[0][1] < 0.7 * plan.stride * (plan.n_samples - 1)
    assert abs(state.imbalance) < 1e-3


def test_a_bearing_that_comes_apart_with_shorter_steps_too_ends_with_that_reason(monkeypatch):
    """Its energy balances, so that it does not restart six times."""
    monkeypatch.setattr(row_state, "n_in_place", lambda bearing, give, samples: min(3, len(samples)))
    state = make_plan(parse_scene({"model": "reduced"}, "test")).first_state()
    first, second = state.advance(10), state.advance(10)
    assert first.restarts.startswith("the bearing comes apart with steps of") and first.trouble is None
    assert second.restarts is None and second.trouble.startswith("the bearing has come apart at step")


def test_shocks_are_warned_of_and_steady_running_is_not():
    """Between the two lie two orders of magnitude."""
    for settings, told in (((), False), (("numerics.start=rest", "numerics.load_ramp_ms=0", *CLEARANCE[:1]), True)):
        plan = plan_of(*settings, "numerics.duration_ms=10")
        state = plan.first_state()
        run(plan, lambda samples: None, state=state)
        assert (state.shock > 0.5) is told and (state.shock < 0.05) is not told
        assert any("elastic waves" in sentence for sentence in state.warnings) is told


def test_load_zones_of_soft_rings_do_not_gain_and_lose_force_together():
    """Where every contact is told of all that others gain, forces rise and fall by turns, whatever the step."""
    plan = make_plan(parse_scene(SOFT, "test"))
    assert plan.relaxation_factor < 0.7
    state, _, told = ran(plan)
    assert told == []
    assert abs(state.imbalance) < 1e-3
