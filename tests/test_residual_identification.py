"""Laws fitted to a run's own forces: the right numbers, honest intervals, judged on the part held back."""

import json

import numpy as np
import pytest

from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import PowerLaw, steel_law
from residual.cli import main
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.fitted_laws import DampedLaw, fit_law, passage_numbers, spring_and_damper
from residual.sources import read_result
from tests.reference.synthetic_run import make_run, recorded, run_variables, write_result

STIFFNESS, EXPONENT = 1.1e9, 1.09


def load_zone(n_times=1200, n_rollers=13, turns=1.5):
    """Approaches of rollers that pass a cosine-shaped load zone, m."""
    angle = 2 * np.pi * (np.arange(n_rollers) / n_rollers + turns * np.arange(n_times)[:, None] / n_times)
    return 2e-6 * np.cos(angle)


def power(depth):
    return STIFFNESS * np.maximum(depth, 0.0) ** EXPONENT


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=3001)


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
    return sum(spring_and_damper(law, depth, speed))


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
    assert evaluation.law.exponent == pytest.approx(10 / 9, rel=1e-7)
    assert evaluation.law.stiffness == pytest.approx(0.95 * harris.stiffness, rel=1e-5)
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
