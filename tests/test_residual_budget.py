"""Error forces and their budget on a made-up run whose forces are known in closed form."""

import numpy as np
import pytest

from residual.budget import near_contact_change, traction_resultant
from residual.evaluation import evaluate
from tests.reference.synthetic_run import exact_errors, make_run, recorded, run_variables


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=3001)


@pytest.fixture(scope="module")
def evaluation(run, tmp_path_factory):
    return evaluate(recorded(tmp_path_factory.mktemp("runs") / "made.nc", run))


def test_error_forces_equal_the_closed_form(run, evaluation):
    exact_x, exact_y = exact_errors(run)
    np.testing.assert_allclose(evaluation.budget.x.error, exact_x, atol=1e-5)
    np.testing.assert_allclose(evaluation.budget.y.error, exact_y, atol=1e-5)


def test_terms_add_up_to_the_error_and_its_momentum_balance_leaves_out_law_and_friction(evaluation):
    for part in (evaluation.budget.x, evaluation.budget.y):
        np.testing.assert_allclose(sum(part.terms.values()), part.error, atol=1e-9 * 2000.0, rtol=0)
        rest = part.terms["differentiation"] + part.terms["ring_flexibility"]
        np.testing.assert_allclose(part.momentum, rest, atol=1e-8)


def test_contact_law_term_is_the_injected_force_error(run, evaluation):
    """The run's forces are 0.95 of the law's: the term is −5 % of the law's resultant."""
    push = -np.sum(run.law_force * np.sin(run.angle), axis=1)
    np.testing.assert_allclose(evaluation.budget.y.terms["contact_law"], -0.05 * push, atol=1e-7)


def test_friction_acts_on_the_ring_against_the_roller(run, evaluation):
    """A roller under the ring, pulled along +θ (that is +x there), pulls the ring along −x."""
    traction = run_variables(run)["inner_traction"]
    angle = run.angle
    for part, along in ((evaluation.budget.x, -np.sin(angle)), (evaluation.budget.y, np.cos(angle))):
        np.testing.assert_allclose(part.terms["friction"], np.sum(-traction * along, axis=1), atol=1e-9)
    below = np.zeros_like(traction)
    roller = int(np.argmin(np.sin(angle[0])))
    below[0, roller] = 1.0
    force_x, _ = traction_resultant(evaluation.budget.contacts, below)
    assert force_x[0] < -0.97


def test_run_in_momentum_balance_is_found_balanced(tmp_path):
    """Load and gravity taken from the contact forces: a run that obeys Newton must show no momentum error."""
    run = make_run(n_times=1001)
    variables = run_variables(run, force_factor=1.0, traction=0.0)
    _, exact_y = exact_errors(run)
    mass = run.scene.operation.inner_ring_and_shaft_kg
    variables["inner_force"] = run.law_force.copy()
    trajectory = recorded(tmp_path / "n.nc", run, variables)
    budget = evaluate(trajectory).budget
    np.testing.assert_allclose(budget.x.terms["contact_law"], 0.0, atol=1e-6)
    np.testing.assert_allclose(budget.y.momentum, exact_y, atol=1e-5)
    assert mass * np.max(np.abs(run.acceleration_x)) > 0.1


def test_injected_force_is_found_in_the_momentum_balance(tmp_path):
    run = make_run(n_times=2001)
    base = recorded(tmp_path / "a.nc", run)
    variables = run_variables(run)
    missing = 5.0 * np.sin(2 * np.pi * 800.0 * run.time)  # a force that the file does not tell
    lowest = np.argmin(np.sin(run.angle), axis=1)
    rows = np.arange(run.time.size)
    direction = -np.sin(run.angle[rows, lowest])
    variables["inner_force"][rows, lowest] -= missing / direction
    hidden = recorded(tmp_path / "b.nc", run, variables)
    difference = evaluate(hidden).budget.y.momentum - evaluate(base).budget.y.momentum
    np.testing.assert_allclose(difference, missing, atol=1e-7)


def test_without_forces_the_error_has_no_terms(tmp_path):
    run = make_run(n_times=501)
    motion = ("time", "inner_x", "inner_y", "roller_x", "roller_y")
    variables = {name: getattr(run, name) for name in motion}
    budget = evaluate(recorded(tmp_path / "n.nc", run, variables)).budget
    assert budget.x.terms == {} and budget.x.momentum is None


def test_start_skips_exactly_the_transient(run, tmp_path):
    trajectory = recorded(tmp_path / "n.nc", run)
    whole, late = evaluate(trajectory), evaluate(trajectory, start=5e-3)
    assert late.start == pytest.approx(5e-3, abs=1e-9)
    assert late.record.time[0] == pytest.approx(5e-3, abs=1e-9)  # the stencil reaches back before it
    n = late.budget.x.error.size
    np.testing.assert_array_equal(late.budget.x.error, whole.budget.x.error[-n:])
    assert n == run.time.size - 500


def test_load_ramp_of_a_start_from_rest_is_left_out(tmp_path):
    scene = make_run(n_times=40).scene
    resting = scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"start": "rest"})})
    run = make_run(n_times=1001, scene=resting)
    evaluation = evaluate(recorded(tmp_path / "n.nc", run))
    assert evaluation.start == pytest.approx(1e-3, abs=1e-9)
    assert any("load ramp" in note for note in evaluation.notes)


def test_loaded_rollers_are_counted(run, evaluation):
    count = (run.law_force > 0).sum(axis=1)
    assert evaluation.loaded_range == (count.min(), count.max())


def test_coarse_sampling_is_warned_of(tmp_path):
    run = make_run(n_times=601, interval=1e-4)
    evaluation = evaluate(recorded(tmp_path / "n.nc", run))
    assert any("Nyquist" in note for note in evaluation.notes)


def test_samples_near_a_contact_change():
    loaded = np.zeros((12, 2), dtype=bool)
    loaded[6:, 1] = True
    assert np.flatnonzero(near_contact_change(loaded, 2)).tolist() == [4, 5, 6, 7, 8]
