"""The checker knows a cage: its forces are a term of the budget, its motion a figure and numbers of the summary."""

from collections import defaultdict

import h5py
import numpy as np
import pytest

from fem.quantities import cage_rows
from lagrange.scene.scene import parse_scene
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.figures.run import cage
from residual.record import COLUMNS, Record
from residual.report import ReportOptions, summarise
from residual.sources import read_result
from tests.reference.synthetic_run import make_run, recorded, run_variables, write_result

FORWARD, MOMENT, GUIDED = 30.0, -0.02, (3.0, -4.0)  # N, N m, N: on every roller, on the cage
CAGE = {"guidance": "inner_ring", "guidance_clearance_mm": 0.1}


def made_file(folder, cage=CAGE, samples=4001, **changes):
    """A made-up run whose cage pushes every roller forward, rubs on it, and is pushed by the inner ring."""
    run = make_run(n_times=samples, scene=parse_scene({"cage": cage}, "made"))
    time, rollers = run.time, np.ones((run.time.size, 13))
    values = dict(
        cage_x=2e-5 * np.cos(100.0 * time), cage_y=2e-5 * np.sin(100.0 * time), cage_angle=180.0 * time,
        cage_guidance_x=GUIDED[0] + 0.0 * time, cage_guidance_y=GUIDED[1] + 0.0 * time, cage_force=FORWARD * rollers,
        cage_moment=MOMENT * rollers,
    )  # fmt: skip
    path = write_result(folder / "made.nc", run)
    with h5py.File(path, "r+") as file:
        for name, array in (values | changes).items():
            file[name] = array
    return run, path


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    run, path = made_file(tmp_path_factory.mktemp("caged"))
    return run, evaluate(read_result(path))


@pytest.mark.parametrize("axis", ["x", "y"])
def test_terms_with_a_cage_add_up_to_the_error(made, axis):
    budget = getattr(made[1].budget, axis)
    np.testing.assert_allclose(sum(budget.terms.values()), budget.error, atol=1e-9 * 2000.0, rtol=0.0)


def test_the_cages_term_is_what_rollers_pass_on_and_the_guide_gives(made):
    """Of a force forward each raceway takes half against it; of a moment, one raceway forward and one back."""
    run, evaluation = made
    against = -0.5 * FORWARD + 0.5 * MOMENT / 0.005  # N, of the inner raceway on the roller
    x, y = -np.sin(run.angle), np.cos(run.angle)  # along +θ
    for axis, along, guided in (("x", x, GUIDED[0]), ("y", y, GUIDED[1])):
        expected = -(against * along).sum(axis=1) - guided
        terms = getattr(evaluation.budget, axis).terms
        np.testing.assert_allclose(terms["cage"], expected, atol=1e-9)
        whole = -(run_variables(run)["inner_traction"] * along).sum(axis=1)
        np.testing.assert_allclose(terms["friction"] + terms["cage"], whole - guided, atol=1e-9)


def test_a_cage_that_rollers_guide_leaves_the_hub_alone(tmp_path):
    _, path = made_file(tmp_path, cage={"guidance": "rollers"})
    budget = evaluate(read_result(path)).budget
    against = -0.5 * FORWARD + 0.5 * MOMENT / 0.005
    angle = np.arctan2(-budget.contacts.direction_y, -budget.contacts.direction_x)
    np.testing.assert_allclose(budget.x.terms["cage"], -(against * -np.sin(angle)).sum(axis=1), atol=1e-6)


def test_the_summary_tells_slip_whirl_and_forces(made):
    cage = summarise(made[1], ReportOptions())["cage"]
    assert cage["speed_Hz"] == pytest.approx(180.0 / (2.0 * np.pi))
    assert cage["whirl_Hz"] == pytest.approx(100.0 / (2.0 * np.pi))
    assert cage["slip"] == pytest.approx(1.0 - 180.0 / (0.5 * 150.0 * np.pi * 36.0 / 46.0))
    assert cage["largest_offset_m"] == pytest.approx(2e-5)
    assert cage["largest_pocket_force_N"] == FORWARD
    assert cage["largest_guidance_force_N"] == pytest.approx(5.0)


def test_a_cage_of_a_shaft_that_turns_both_ways_has_no_mean_speed_whirl_or_slip(made, monkeypatch):
    monkeypatch.setattr(Record, "reverses", True)
    summary = summarise(made[1], ReportOptions())
    assert summary["cage_Hz"]["rolling_without_slip"] is None
    assert summary["cage"]["speed_Hz"] is summary["cage"]["whirl_Hz"] is summary["cage"]["slip"] is None
    assert summary["cage"]["largest_offset_m"] == pytest.approx(2e-5)
    samples = defaultdict(lambda: np.ones(2))
    assert "whirls" in cage_rows(samples, 1.0)["cage's centre"]
    assert "whirls" not in cage_rows(samples, 0.0)["cage's centre"]


def test_within_one_turn_no_slip_of_the_cage_is_told(tmp_path):
    _, path = made_file(tmp_path, samples=3001)
    evaluation = evaluate(read_result(path))
    assert summarise(evaluation, ReportOptions())["cage"]["slip"] is None
    assert "turns less than once and has no mean slip" in cage(evaluation).caption


def test_a_run_without_a_cage_has_neither_term_nor_numbers(tmp_path):
    evaluation = evaluate(recorded(tmp_path / "free.nc", make_run(n_times=3001)))
    assert "cage" not in evaluation.budget.x.terms
    assert "cage" not in summarise(evaluation, ReportOptions())


def test_damaged_columns_of_the_cage_are_refused(tmp_path):
    _, path = made_file(tmp_path, cage_force=np.full((4001, 13), np.nan))
    with pytest.raises(InputError, match="cage_force"):
        read_result(path)
    assert set(COLUMNS) >= {"cage_force", "cage_moment"}
