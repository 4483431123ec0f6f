"""run-fem --model lagrange: the file it writes, what the checker finds in it, balls, refusals."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.solver.simulate import make_plan
from lagrange import contact_laws
from lagrange.columns import columns_of
from lagrange.first_state import Problem
from lagrange.scene.scene import read_scene
from residual.evaluation import evaluate
from residual.sources import read_result
from residual.spectrum import rms
from tests.reference.compiled import FLOORS
from tests.reference.forward_motion import simulate
from tests.reference.synthetic_run import report_of

LOAD = 2000.0  # N, the paper's
BUDGET = 1e-9 * LOAD
PAGE = Path(__file__).parents[1].joinpath("docs", "lagrange.md").read_text(encoding="utf-8")
# the 209 deep-groove ball bearing of Harris' examples, grooves of 52 %, as the documentation has it
BALLS = next(block for block in PAGE.split("```toml\n") if block.startswith('name = "209"')).split("```")[0]


def run(path, *arguments):
    """The command with settings table.key=value; its exit code."""
    words = [word for setting in arguments for word in (("--set", setting) if "=" in setting else (setting,))]
    return run_main(["--model", "lagrange", "--output", str(path), "--force", *words])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    path = tmp_path_factory.mktemp("ideal") / "ideal.nc"
    assert run(path, "--duration", "10", "--quiet") == 0
    return path


def test_the_file_holds_the_solution_in_every_variable(short):
    scene = read_scene(None, ("model=lagrange", "numerics.duration_ms=10.0"))
    bearing = scene.ideal_bearing()
    found = simulate(Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing)), 10e-3, 1e-5)
    with h5py.File(short) as file:
        told = {"status": "complete", "committed_samples": 1001, "scene": scene.to_toml(), "degrees_of_freedom": 15,
                "mesh_nodes": 0, "steps": 7000}  # fmt: skip
        assert {name: file.attrs[name] for name in told} == told
        assert 0.0 < file.attrs["time_step"] < file.attrs["critical_time_step"] < 1e-4
        for name, (dimensions, units, _) in columns_of("").items():
            assert file[name].shape == (1001, 13)[: len(dimensions)] and file[name].attrs["units"] == units
        for name in ("inner_x", "inner_ay", "roller_y", "roller_theta", "inner_force", "outer_force", "work_external"):
            reference = getattr(found, name)  # by scipy
            allowed = FLOORS["inner_ay"] if name == "inner_ay" else 2e-3 * np.abs(reference).max()
            np.testing.assert_allclose(file[name][:], reference, rtol=0.0, atol=allowed, err_msg=name)
        np.testing.assert_allclose(file["roller_spin"][:], found.roller_spin, rtol=1e-14)
        for name in ("inner_traction", "outer_traction", "roller_roller_force", "energy_elastic"):
            assert not np.any(file[name][:])
        stored = file["energy_kinetic"][:] + file["energy_contact"][:] - file["work_external"][:]
        assert np.ptp(stored) < 1e-6 * file["energy_contact"][:].mean()
    # where contacts open the roller's own mode, 54 kHz, lies beyond what 10 µs resolve: some 0.1 N of differentiation
    checked = evaluate(read_result(short))
    assert checked.loaded_range == (6, 7)
    for direction in checked.directions:
        terms, error = direction.budget.terms, direction.budget.error
        assert np.max(np.abs(error - terms["differentiation"])) < BUDGET
        assert np.sqrt(np.mean(error**2)) < 0.3


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_its_residual_is_the_stated_floor_of_differentiation(law, tmp_path):
    """The checker's proof: two commands, no shared code but geometry and laws; contacts stay closed, 2000 N."""
    path = tmp_path / "a.nc"
    settings = ("bearing.outer_raceway_diameter_mm=55.98", "numerics.output_interval_us=5", f"lagrange.law={law}")
    assert run(path, "--duration", "5", "--quiet", *settings) == 0
    summary, _ = report_of(path, tmp_path / "out", "--quiet")
    assert summary["law"] == law  # of the run's own scene, unasked
    with h5py.File(tmp_path / "out" / "residual.nc") as file:
        for axis in "xy":
            error = file[f"error_{axis}"][:][8:-8]  # where the stencil is central
            floor = summary["differentiation_floor_N"][axis]
            assert np.sqrt(np.mean(error**2)) == pytest.approx(floor, rel=0.15)
            assert floor < 5e-5
            others = file[f"error_{axis}"][:] - file[f"budget_{axis}_differentiation"][:]
            assert np.max(np.abs(others)) < BUDGET


@pytest.fixture
def balls(tmp_path):
    """Options of the documentation's ball bearing, and its result file."""
    (tmp_path / "209.toml").write_text(BALLS)
    return [str(tmp_path / "209.toml"), "--output", str(tmp_path / "209.nc"), "--force"]


def test_ball_bearing_carries_harris_loads(balls, capsys):
    """Harris, Rolling Bearing Analysis, example of the 209 bearing under 8900 N: 4536, 2842, 61 N.

    Second hand; Harris reads two constants off a chart.
    """
    assert run_main([*balls, "--duration", "0"]) == 0
    shown = PAGE.split("run-fem 209.toml --duration 0\n```\n\n```text\n")[1].split("\nResult")[0].splitlines()
    printed = capsys.readouterr().out
    assert len(shown) == 2 and all(line in printed for line in shown)
    with h5py.File(balls[2]) as file:
        loads = np.sort(file["inner_force"][0])[::-1]
    assert loads[:5] == pytest.approx([4536.0, 2842.0, 2842.0, 61.0, 61.0], abs=6.0) and np.all(loads[5:] == 0.0)
    assert render_main([balls[2]]) == 2
    refused = capsys.readouterr().err
    assert 'bearing.type = "ball"' in refused and "--model lagrange" in refused


@pytest.mark.usefixtures("plain_report")
def test_ball_bearing_runs_and_is_checked_by_its_own_law(balls, tmp_path):
    assert run_main([*balls, "--duration", "6", "--set", "operation.speed_rpm=1800", "--quiet"]) == 0
    summary, _ = report_of(balls[2], tmp_path / "checked", "--quiet", "--compare-laws")
    assert summary["law"] == "hertz"
    assert {"hertz", "fitted"} <= {law["law"] for law in summary["laws"]}
    for axis in "xy":
        assert summary[f"budget_{axis}"]["contact_law"] < 1e-9 * 8900.0
        assert summary[f"error_{axis}"]["rms_N"] < 0.1


def damped(path, setting, duration):
    settings = (setting, "numerics.start=rest", "numerics.load_ramp_ms=0.5")
    assert run(path, "--duration", duration, "--quiet", *settings) == 0
    return read_result(path)


def test_damping_is_found_again_with_its_interval(tmp_path):
    found = evaluate(damped(tmp_path / "a.nc", "damping.contact_N_s_m=200", "12"), "fitted_damped", fit=True)
    fit = found.identification
    assert fit.damping.value == pytest.approx(200.0, rel=2e-3)
    assert fit.damping.low < fit.damping.value < fit.damping.high < 1.02 * fit.damping.value
    assert fit.exponent.value == pytest.approx(10 / 9, rel=1e-6)
    # the scene's own damping is part of the law checked against; without it the dampers' force is left
    assert found.score("harris").contact_rms < 0.01 < found.score("fitted").contact_rms


def test_dampers_forces_are_a_term_of_the_budget(tmp_path):
    """By the run's own law nothing is left of it; by an undamped one all that the dampers give the hub."""
    record = damped(tmp_path / "a.nc", "damping.contact_time_us=5", "6")
    for law in (None, "fitted"):
        found = evaluate(record, law, start=0.0)
        for direction, along in zip(found.directions, ("direction_x", "direction_y"), strict=True):
            terms = direction.budget.terms
            np.testing.assert_allclose(sum(terms.values()), direction.budget.error, atol=BUDGET, rtol=0)
            given = np.sum(record.inner_damping_force * getattr(record.contacts, along), axis=1)
            if law == "fitted":
                np.testing.assert_allclose(terms["damping"], given, atol=BUDGET, rtol=0)
            else:  # but for velocities from positions
                assert rms(terms["damping"]) < 0.05 * rms(given)
    with h5py.File(tmp_path / "a.nc") as file:
        assert 0.0 < file["work_dissipated"][-1] == file["work_damping_contact"][-1]
        assert not np.any(file["work_damping_bodies"])


def test_the_load_that_a_ramp_withholds_is_a_term_of_its_own(tmp_path):
    path = tmp_path / "rest.nc"
    assert run(path, "--duration", "3", "--quiet", "numerics.start=rest", "numerics.load_ramp_ms=2") == 0
    found = evaluate(read_result(path), start=0.0).budget
    time = 1e-5 * np.arange(301)
    withheld = LOAD * np.where(time < 2e-3, 0.5 * (1.0 + np.cos(np.pi * time / 2e-3)), 0.0)
    np.testing.assert_allclose(found.y.terms["load_and_weight"], withheld, atol=1e-9)
    assert not np.any(found.x.terms["load_and_weight"])
    np.testing.assert_allclose(found.y.terms["ring_flexibility"], 0.0, atol=BUDGET)
    np.testing.assert_allclose(sum(found.y.terms.values()), found.y.error, atol=BUDGET, rtol=0)


def test_a_start_alone_can_be_extended_and_free_angles_have_their_own_degrees_of_freedom(tmp_path):
    path, whole = tmp_path / "a.nc", tmp_path / "whole.nc"
    assert run(path, "--duration", "0", "--quiet") == 0
    assert run(path, "--duration", "1", "--quiet", "--resume") == run(whole, "--duration", "1", "--quiet") == 0
    with h5py.File(path) as file, h5py.File(whole) as other:
        assert all(np.array_equal(file[name][:], other[name][:]) for name in columns_of(""))
    assert run(path, "--duration", "1", "--quiet", "lagrange.angles=free") == 0
    with h5py.File(path) as file:
        assert file.attrs["degrees_of_freedom"] == 2 * 13 + 2
        assert np.ptp(np.diff(file["roller_theta"][-1])) > 1e-9  # no cage keeps them apart


def test_a_law_measured_on_steel_is_warned_of_on_other_materials(tmp_path, capsys):
    path = tmp_path / "a.nc"
    ceramic = "material.roller.youngs_modulus_GPa=310"
    assert run(path, "--duration", "1", "--quiet", ceramic) == 0
    warning = capsys.readouterr().err
    assert "harris" in warning and "roller has 310 GPa" in warning and "johnson" in warning
    assert any("310 GPa" in note for note in evaluate(read_result(path)).notes)
    assert not any("310 GPa" in note for note in evaluate(read_result(path), "johnson").notes)
    assert run(path, "--duration", "1", "--quiet", ceramic, "lagrange.law=johnson") == 0
    assert capsys.readouterr().err == ""


def test_an_energy_that_has_gone_astray_is_told_of():
    state = make_plan(read_scene(None, ("model=lagrange",))).first_state()
    state.energy_scale[0], state.energy_error[0] = 2.0, 0.0198
    assert state.warnings == ()
    state.energy_error[0] = 0.052  # at any sample: most of it may be gone at the end
    assert "off by up to 2.6 %" in state.warnings[0] and state.warnings[0] in state.outcome_attributes["warnings"]


def test_rigid_bodies_that_go_through_one_another_end_the_run(tmp_path, capsys):
    path = tmp_path / "through.nc"
    settings = "operation.radial_load_N=1e7", "numerics.start='rest'", "numerics.load_ramp_ms=0"
    assert run(path, *settings, "--duration", "3", "--quiet") == 1
    assert "rigid bodies have gone through one another at step" in capsys.readouterr().err
    with h5py.File(path) as file:
        count, bearing = int(file.attrs["committed_samples"]), read_scene(None, ()).ideal_bearing()
        assert file.attrs["status"].startswith("failed: rigid bodies") and 0 < count < 301
        x, y = file["roller_x"][:count], file["roller_y"][:count]
    assert np.max(np.hypot(x, y)) < bearing.outer_raceway_radius - 0.5 * bearing.roller_radius
