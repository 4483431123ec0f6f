"""Error forces and their budget on a made-up run whose forces are known in closed form."""

import json

import numpy as np
import pytest

from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import PowerLaw, steel_law
from residual.budget import near_contact_change, traction_resultant
from residual.cli import main
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.laws import DampedLaw, fit_law, passage_numbers
from residual.sources import read_result
from residual.spectrum import ORDERS, derivative, floor, response, stencil
from tests.reference.synthetic_run import exact_errors, make_run, recorded, run_variables, write_result


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


# Stencils: order, exactness, error floor


OMEGA = 2 * np.pi * 40.0


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [1, 2])
def test_stencil_is_exact_for_polynomials_up_to_its_order(order, which):
    t = np.linspace(-1.0, 1.0, 21)
    for power in range(order + which):
        exact = np.polynomial.polynomial.polyder([0] * power + [1], which)
        found = derivative(t**power, t[1] - t[0], which, order)
        inner = slice(order // 2, -(order // 2)) if power > order else slice(1, -1) if power > 4 else slice(None)
        np.testing.assert_allclose(found[inner], np.polynomial.polynomial.polyval(t, exact)[inner], atol=2e-11)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [1, 2])
def test_observed_order_is_the_nominal_one(order, which):
    steps = 0.1 / np.array([40, 60, 80])
    errors = []
    for step in steps:
        t = step * np.arange(round(0.1 / step) + 1)
        exact = OMEGA * np.cos(OMEGA * t) if which == 1 else -(OMEGA**2) * np.sin(OMEGA * t)
        found = derivative(np.sin(OMEGA * t), step, which, order)
        half = order // 2
        errors.append(np.max(np.abs(found - exact)[half:-half]) / OMEGA**which)
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.25)


def test_known_weights_of_order_six():
    # Fornberg 1988, table 1
    expected = [1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90]
    np.testing.assert_allclose(stencil(6), expected, rtol=0, atol=1e-14)
    assert stencil(8).sum() == pytest.approx(0.0, abs=1e-13)


def test_stencil_is_not_the_integrators_own():
    """A leapfrog trajectory's own second difference is its acceleration exactly: no test. This differs."""
    dt, omega = 1e-3, 600.0
    x = np.empty(400)
    x[0], x[1] = 1.0, 1.0 - 0.5 * (omega * dt) ** 2
    for i in range(1, 399):
        x[i + 1] = 2 * x[i] - x[i - 1] - (omega * dt) ** 2 * x[i]
    own = np.diff(x, 2) / dt**2 + omega**2 * x[1:-1]
    ours = derivative(x, dt)[3:-3] + omega**2 * x[3:-3]
    assert np.max(np.abs(own)) < 1e-6 * omega**2
    assert np.sqrt(np.mean(ours**2)) > 1e-2 * omega**2 * np.sqrt(0.5)


def test_response_is_the_gain_on_a_sine():
    dt, frequency = 1e-5, 13.2e3
    t = dt * np.arange(500)
    record = np.sin(2 * np.pi * frequency * t)
    found = derivative(record, dt, order=6)
    exact = -((2 * np.pi * frequency) ** 2) * record[3:-3]
    # the mean taken off the record does not matter: the weights add up to zero
    np.testing.assert_allclose(found[3:-3], response(frequency, dt) * exact, atol=1e-8 * np.max(np.abs(exact)))
    assert abs(1 - response(frequency, dt)) < 6e-4


@pytest.mark.parametrize("order", [4, 6, 8])
def test_response_is_1_far_below_the_sampling_frequency(order):
    np.testing.assert_allclose(response([0.0, 1e-12, 1e-6, 1.0], 1e-5, order), 1.0, rtol=1e-12)


def test_round_off_floor_bounds_the_error_of_positions_stored_in_single_precision():
    eps, step = float(np.finfo(np.float32).eps), 1e-5
    exact = 4e-6 * np.sin(OMEGA * step * np.arange(4000))
    stored = exact.astype(np.float32).astype(float)
    noise = np.abs(derivative(stored, step) - derivative(exact, step))[1:-1]
    bound = floor(stored, step, eps=eps).round_off
    assert 0.05 * bound < noise.max() <= bound


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tones", [(8e3,), (300.0, 13e3, 40e3)])
def test_truncation_floor_is_the_true_error(order, tones):
    step = 1e-5
    t = step * np.arange(6001)
    record, exact = np.zeros_like(t), np.zeros_like(t)
    for tone in tones:
        omega = 2 * np.pi * tone
        record += np.sin(omega * t) / omega
        exact -= omega * np.sin(omega * t)
    error = (derivative(record, step, order=order) - exact)[order:-order]
    assert floor(record, step, order).truncation == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.03)


def test_white_noise_is_magnified_as_the_weights_say():
    rng = np.random.default_rng(1)
    found = derivative(1e-9 * rng.standard_normal(20000), 1e-5)
    expected = 1e-9 * np.linalg.norm(stencil(6)) / 1e-10
    assert np.std(found) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("which", [1, 2])
def test_ends_are_good_for_slow_motion_and_not_much_noisier(which):
    step, omega = 1e-5, 2 * np.pi * 1e3
    t = step * np.arange(200)
    found = derivative(np.cos(omega * t), step, which)
    exact = -omega * np.sin(omega * t) if which == 1 else -(omega**2) * np.cos(omega * t)
    assert np.max(np.abs(found - exact)) < 3e-4 * omega**which
    impulse_gain = [np.linalg.norm([derivative(row, 1.0)[i] for row in np.eye(15)]) for i in (0, 1, 2, -1)]
    assert impulse_gain == pytest.approx([14.0, 3.6, 2.9, 14.0], rel=0.01)


def test_several_columns():
    t = np.linspace(0.0, 1.0, 50)
    found = derivative(np.stack([t**2, t**3], axis=1), t[1], order=4)
    np.testing.assert_allclose(found, np.stack([2 + 0 * t, 6 * t], axis=1), atol=1e-9)


@pytest.mark.parametrize("bad", [{"order": 5}, {"order": 2}, {"derivative": 3}])
def test_unknown_stencils_are_refused(bad):
    with pytest.raises(ValueError, match="must be"):
        derivative(np.zeros(20), 1.0, **bad)


def test_too_short_a_record_is_refused():
    with pytest.raises(ValueError, match="too few"):
        derivative(np.zeros(6), 1.0, order=6)


# Laws fitted to a run's own forces: the right numbers, honest intervals, judged on the part held back


STIFFNESS, EXPONENT = 1.1e9, 1.09


def load_zone(n_times=1200, n_rollers=13, turns=1.5):
    """Approaches of rollers that pass a cosine-shaped load zone, m."""
    angle = 2 * np.pi * (np.arange(n_rollers) / n_rollers + turns * np.arange(n_times)[:, None] / n_times)
    return 2e-6 * np.cos(angle)


def power(depth):
    return STIFFNESS * np.maximum(depth, 0.0) ** EXPONENT


def test_a_law_is_found_again():
    depth = load_zone()
    found = fit_law(depth, power(depth), bridge=5)
    assert found.stiffness.value == pytest.approx(STIFFNESS, rel=1e-8)
    assert found.exponent.value == pytest.approx(EXPONENT, rel=1e-9)
    assert found.scatter < 1e-6


def closing_speed(n_times=1200, seed=4):
    """Made-up closing speeds, m/s, of the size of a vibrating roller's."""
    return 1e-3 * np.random.default_rng(seed).standard_normal((n_times, 13))


def force_of(law, depth, speed):
    return law.pushes(depth, speed).force


def test_damping_is_found_again_beside_the_rest():
    depth, speed = load_zone(), closing_speed()
    spring = PowerLaw(name="true", stiffness=STIFFNESS, exponent=EXPONENT, source="")
    force = force_of(DampedLaw(spring=spring, damping=ContactDamping(constant=300.0)), depth, speed)
    found = fit_law(depth, force, bridge=5, closing_speed=speed)
    assert found.damping.value == pytest.approx(300.0, rel=1e-3)
    assert found.exponent.value == pytest.approx(EXPONENT, rel=1e-5)
    assert found.law.name == "fitted_damped"
    np.testing.assert_allclose(force_of(found.law, depth, speed), force, atol=0.05)


def test_damping_that_is_not_there_is_told_by_an_interval_around_zero():
    depth, speed = load_zone(), closing_speed()
    noise = 0.5 * np.random.default_rng(5).standard_normal(depth.shape)
    force = np.where(depth > 0.0, np.maximum(power(depth) + noise, 0.0), 0.0)
    found = fit_law(depth, force, bridge=5, closing_speed=speed)
    assert found.damping.low < 0.0 < found.damping.high
    assert found.damping.high - found.damping.low < 100.0


def test_a_bearing_that_does_not_move_fixes_no_damping():
    with pytest.raises(InputError, match="damping"):
        fit_law(load_zone(), power(load_zone()), bridge=5, closing_speed=0.0 * load_zone())


@pytest.mark.parametrize("scale", [1e-310, 1e-160])
def test_forces_whose_squares_are_nothing_are_refused_in_a_sentence(scale):
    with pytest.raises(InputError, match="too small to fit a law to"):
        fit_law(load_zone(), scale * (load_zone() > 0.0), bridge=5)


def test_numbers_that_a_run_does_not_fix_are_refused_in_a_sentence():
    """A dashpot whose force grows with the spring's can't be told from a stiffer spring."""
    depth = load_zone()
    with pytest.raises(InputError, match="do not fix all numbers"):
        fit_law(depth, power(depth), bridge=5, closing_speed=1e-6 * power(depth))


def test_a_damper_pushes_only_where_the_spring_does_and_never_pulls():
    spring = PowerLaw(name="true", stiffness=1.0, exponent=1.0, source="")
    law = DampedLaw(spring=spring, damping=ContactDamping(constant=2.0))
    found = force_of(law, np.array([1.0, 1.0, 1.0, -1.0]), np.array([0.5, -0.2, -3.0, 5.0]))
    np.testing.assert_array_equal(found, [2.0, 0.6, 0.0, 0.0])


def test_intervals_cover_the_truth_though_samples_of_a_passage_are_correlated():
    """Each passage errs by one factor of its own: 95 % intervals must hold about that often."""
    depth = load_zone(600, turns=2.0)
    passage = passage_numbers(depth > 0.0, 5)
    covered = []
    for seed in range(150):
        factor = 1.0 + 0.02 * np.random.default_rng(seed).standard_normal(passage.max() + 2)
        found = fit_law(depth, power(depth) * factor[passage], bridge=5, samples=600)
        known = ((found.stiffness, STIFFNESS), (found.exponent, EXPONENT))
        covered.append([number.low <= true <= number.high for number, true in known])
    share = np.mean(covered, axis=0)
    assert np.all(share > 0.85) and np.all(share < 0.999)


def test_passages_are_counted_once_each_and_chatter_bridged():
    closed = np.zeros((20, 2), dtype=bool)
    closed[2:6, 0] = closed[8:12, 0] = closed[16:, 0] = True
    number = passage_numbers(closed, bridge=2)
    assert number[3, 0] == number[9, 0] != number[18, 0]
    assert number[:, 1].max() == -1


def test_the_fit_does_not_see_the_held_back_part():
    depth = load_zone()
    force = power(depth)
    changed = force.copy()
    changed[600:] *= 3.0
    assert fit_law(depth, changed, bridge=5).law == fit_law(depth, force, bridge=5).law


@pytest.mark.parametrize("constant", [True, False])
def test_data_that_fix_no_exponent_are_refused(constant):
    depth = np.full((200, 13), 1e-6) if constant else -np.ones((200, 13))
    with pytest.raises(InputError):
        fit_law(depth, power(depth), bridge=5)


def test_law_of_a_run_is_fitted_and_its_error_disappears(run, tmp_path):
    """The run's forces are 0.95 of Harris's: K is, n is Harris's, and no contact-law term is left."""
    evaluation = evaluate(recorded(tmp_path / "a.nc", run), "fitted")
    harris = steel_law("harris", run.scene.ideal_bearing().roller_length)
    assert evaluation.law.spring.exponent == pytest.approx(10 / 9, rel=1e-7)
    assert evaluation.law.spring.stiffness == pytest.approx(0.95 * harris.stiffness, rel=1e-5)
    np.testing.assert_allclose(evaluation.budget.y.terms["contact_law"], 0.0, atol=1e-4)
    np.testing.assert_allclose(
        sum(evaluation.budget.y.terms.values()), evaluation.budget.y.error, atol=1e-9 * 2000.0, rtol=0
    )


@pytest.mark.parametrize("law", ["harris", "fitted", "johnson", "teutsch_sauer"])
def test_ranking_agrees_with_an_evaluation_under_each_law(law, run, tmp_path):
    trajectory = recorded(tmp_path / "a.nc", run)
    ranked = evaluate(trajectory, "palmgren", fit=True)
    late = slice(ranked.identified["fitted"].samples, None)
    alone = evaluate(trajectory, law).budget
    score = ranked.score(law)
    assert score.errors[1].mean == pytest.approx(np.mean(alone.y.error[late]), abs=1e-9)
    assert score.errors[0].rms == pytest.approx(np.sqrt(np.mean(alone.x.error[late] ** 2)), abs=1e-9)
    assert [s.rms for s in ranked.laws] == sorted(s.rms for s in ranked.laws)


@pytest.mark.usefixtures("plain_report")
def test_summary_and_terminal_tell_the_fit_and_the_ranking(run, tmp_path, capsys):
    path = write_result(tmp_path / "a.nc", run)
    assert main([str(path), "--law", "fitted", "--compare-laws", "--tolerance", "1e6"]) == 0
    printed = capsys.readouterr().out
    assert "Fitted: K = " in printed and "teutsch_sauer" in printed and "fitted (in use)" in printed
    summary = json.loads((tmp_path / "a-residual" / "summary.json").read_text())
    fit = summary["identification"]
    assert fit["exponent"]["low"] <= fit["exponent"]["value"] <= fit["exponent"]["high"]
    assert fit["held_back"]["samples"] + round(fit["fitted_until_s"] / 1e-5) + 1 == run.time.size
    assert {row["law"] for row in summary["laws"]} >= {"harris", "fitted", "fitted_damped", "johnson"}
    page = (tmp_path / "a-residual" / "report.html").read_text()
    assert "95 % confidence" in page and "Held-back part" in page


def test_verdict_on_a_fitted_law_goes_by_the_held_back_part(run, tmp_path):
    """Forces that follow another law in the second half pass on the half fitted and fail on the other."""
    variables = run_variables(run)
    evaluation = evaluate(recorded(tmp_path / "a.nc", run, variables), "fitted")
    half = evaluation.identification.samples
    expected = np.sqrt(np.mean(evaluation.budget.y.error[half:] ** 2))
    assert evaluation.judged[1].rms == pytest.approx(expected, rel=1e-12)


def test_a_run_without_forces_can_be_ranked_but_not_fitted(run, tmp_path, capsys):
    motion = {k: v for k, v in run_variables(run).items() if k.startswith(("time", "inner_x", "inner_y", "roller_x"))}
    path = write_result(tmp_path / "a.nc", run, motion | {"roller_y": run.roller_y})
    assert main([str(path), "--law", "fitted"]) == 2
    assert "forces" in capsys.readouterr().err
    assert {s.name for s in evaluate(read_result(path)).laws} >= {"harris", "palmgren", "johnson"}


def test_fitted_law_explains_a_simulated_run(coarse_run):
    """On the part of a finite-element run not fitted to: under 10 N rms in y, mean under 2 N; and no damping."""
    evaluation = evaluate(read_result(coarse_run), "fitted", fit=True)
    _, error_y = evaluation.judged
    assert error_y.rms < 10.0 and abs(error_y.mean) < 2.0
    assert evaluation.score("harris").errors[1].rms > 100.0
    damping = evaluation.identified["fitted_damped"].damping
    assert damping.low < 0.0 < damping.high
