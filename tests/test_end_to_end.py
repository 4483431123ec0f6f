"""run-fem, then check-residual on what it wrote: the two meet in the file only; the budget of a whole machine."""

import json

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.interface import simulate
from lagrange.scene.scene import parse_scene
from residual.cli import main as check_main
from residual.evaluation import evaluate
from residual.sources import read_result
from tests.reference.kit import budget_terms, energy_left


def test_the_report_of_a_run(coarse_run, tmp_path):
    """Momentum balances with its own forces; Harris at the resolved approaches carries 11 % less than the load."""
    assert check_main([str(coarse_run), "--output", str(tmp_path), "--quiet"]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    with h5py.File(coarse_run) as file:
        assert summary["samples"] == file.attrs["committed_samples"]
    assert summary["loaded_rollers"] == {"min": 6, "max": 7}
    assert summary["budget_x"]["momentum"] < 2.0 and summary["budget_y"]["momentum"] < 2.0
    assert 190.0 < summary["error_y"]["mean_N"] < 240.0 and abs(summary["error_x"]["mean_N"]) < 2.0
    figures = {f"{name}.{kind}" for name in ("history", "orbit", "budget", "whole_spectra") for kind in ("png", "svg")}
    assert {"residual.nc", "summary.json", "report.html", *figures} <= {path.name for path in tmp_path.iterdir()}


def test_rest_start_settles_around_the_equilibrium(tmp_path):
    path = tmp_path / "rest.nc"
    options = ["--set", "numerics.start=rest", "--set", "numerics.load_ramp_ms=0.5"]
    assert run_main(["--mesh-size", "2", "--duration", "2", "--output", str(path), "--quiet", *options]) == 0
    record = read_result(path)
    y, left = 1e6 * record.inner_y, energy_left(record.energies)
    assert y[0] == 0.0
    assert y[100:].mean() == pytest.approx(-3.63, abs=0.05)
    assert abs(left - left[0]).max() < 1e-3 * record.energies["energy_elastic"].max()
    assert abs(evaluate(record, start=0.0).budget.y.momentum[:50]).max() < 40.0  # knows the ramp


@pytest.mark.parametrize(("law", "damped"), [("harris", []), ("fitted_damped", ["damping"])])
def test_the_budget_of_a_simulated_run_adds_up_at_every_sample(coarse_run, law, damped):
    for terms in budget_terms(evaluate(read_result(coarse_run), law)):
        assert list(terms) == ["differentiation", "contact_law", *damped, "friction", "load_and_weight",
                               "ring_flexibility"]  # fmt: skip


# Finite elements with all that stands around a bearing at once

TABLES = {
    "model": "fem", "bodies": {"inner_ring": "rigid"},  # whose inertia the checker's equations have all of
    "damping": {"bodies_1_s": 500.0, "contact_N_s_m": 300.0},
    "cage": {
        "mass_kg": 0.05, "guidance": "inner_ring", "guidance_clearance_mm": 0.02, "pocket_clearance_mm": 0.1,
        "friction_coefficient": 0.3, "drag_torque_N_m": 2.0, "damping_N_s_m": 1000.0,
    },
    "support": {"kind": "housing", "fit_clearance_um": 20.0, "mass_kg": 0.5, "stiffness_N_per_m": 2e8,
                "damping_N_s_m": 4000.0},
    "sensor": {},
    "operation": {
        "inner_ring_and_shaft_kg": 0.3, "shaft": "springs", "shaft_stiffness_N_per_m": 1e7,
        "shaft_damping_N_s_m": 2e4, "rotating_load_N": 300.0,
    },
    "numerics": {"mesh_size_mm": 2.5, "duration_ms": 1.5, "start": "rest", "load_ramp_ms": 0.05,
                 "output_interval_us": 1.0},
}  # fmt: skip
TERMS = "differentiation outer_ring shaft contact_law damping friction cage load_and_weight ring_flexibility"


@pytest.mark.slow  # a time loop of its own
def test_the_terms_of_a_whole_machine_add_up_and_its_dashpots_know_what_guide_and_tractions_do_after_them():
    """What the run's own forces leave of the hub's equations: 3e-5 of the largest; 3e-4 and 2e-4 where they did not."""
    found = simulate(parse_scene(TABLES, ""))
    largest = np.max(found["inner_force"])
    assert np.max(np.hypot(found["cage_guidance_x"], found["cage_guidance_y"])) > 0.1 * largest
    for terms in budget_terms(found.residual()):
        assert set(terms) == set(TERMS.split())
        assert np.std(terms["ring_flexibility"]) < 1e-4 * largest
