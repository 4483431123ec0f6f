"""run-fem, then check-residual on what it wrote: the two meet in the file only."""

import json

import h5py
import pytest

from fem.commands.run_fem import run_main
from residual.cli import main as check_main
from residual.evaluation import evaluate
from residual.sources import read_result


@pytest.fixture(scope="module")
def report(coarse_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "residual"
    assert check_main([str(coarse_run), "--output", str(folder), "--quiet"]) == 0
    return folder


def test_the_checker_reads_what_the_solver_wrote(report, coarse_run):
    summary = json.loads((report / "summary.json").read_text())
    with h5py.File(coarse_run) as file:
        assert summary["samples"] == file.attrs["committed_samples"]
    assert summary["loaded_rollers"] == {"min": 6, "max": 7}


def test_momentum_balances_with_the_run_s_own_forces(report):
    summary = json.loads((report / "summary.json").read_text())
    assert summary["budget_x"]["momentum"] < 2.0
    assert summary["budget_y"]["momentum"] < 2.0


def test_the_harris_law_misses_the_load_by_what_the_static_solution_says(report):
    """Harris' forces at the resolved static solution's approaches carry some 11 % less than the load."""
    summary = json.loads((report / "summary.json").read_text())
    assert 190.0 < summary["error_y"]["mean_N"] < 240.0
    assert abs(summary["error_x"]["mean_N"]) < 2.0


def test_the_report_folder_is_complete(report):
    names = {path.name for path in report.iterdir()}
    assert {"residual.nc", "summary.json", "report.html"} <= names
    for figure in ("history", "orbit", "budget", "whole_spectra"):
        assert f"{figure}.png" in names and f"{figure}.svg" in names


def test_rest_start_settles_around_the_equilibrium(tmp_path):
    path = tmp_path / "rest.nc"
    options = ["--set", "numerics.start=rest", "--set", "numerics.load_ramp_ms=0.5"]
    assert run_main(["--mesh-size", "2", "--duration", "2", "--output", str(path), "--quiet", *options]) == 0
    with h5py.File(path) as file:
        y, elastic = 1e6 * file["inner_y"][:], file["energy_elastic"][:]
        stored = file["energy_kinetic"][:] + elastic + file["energy_contact"][:]
        balance = stored - file["work_external"][:] + file["work_dissipated"][:]
    assert y[0] == 0.0
    assert y[100:].mean() == pytest.approx(-3.63, abs=0.05)
    assert abs(balance - balance[0]).max() < 1e-3 * elastic.max()
    # the checker takes the load that the ramp withholds for what it is: half a cosine of 2000 N
    budget = evaluate(read_result(path), start=0.0).budget
    assert budget.y.terms["load_and_weight"][0] == 2000.0 and not budget.y.terms["load_and_weight"][50:].any()
    assert abs(budget.y.momentum[:50]).max() < 40.0


@pytest.mark.parametrize("law", ["harris", "fitted_damped"])
def test_the_budget_of_a_simulated_run_adds_up_at_every_sample(coarse_run, law):
    budget = evaluate(read_result(coarse_run), law).budget
    laws = ["contact_law", "damping"] if law.endswith("damped") else ["contact_law"]
    assert list(budget.y.terms) == ["differentiation", *laws, "friction", "load_and_weight", "ring_flexibility"]
    for axis in "xy":
        total = sum(getattr(budget, axis).terms.values())
        assert abs(total - getattr(budget, axis).error).max() < 1e-9 * 2000.0
