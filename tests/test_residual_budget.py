"""Error forces and their budget on a made-up run whose forces are known in closed form; stencils, fits, a cage."""

from collections import defaultdict

import numpy as np
import pytest

from fem.quantities import cage_rows
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import PowerLaw, steel_law
from lagrange.errors import InputError
from lagrange.scene.scene import parse_scene
from residual import findings
from residual.budget import traction_resultant
from residual.check_vibration import main as check_vibration
from residual.cli import main
from residual.evaluation import evaluate, near_contact_change
from residual.figures.run import cage as cage_figure
from residual.laws import DampedLaw, fit_law, passage_numbers
from residual.record import Record
from residual.report import ReportOptions, summarise
from residual.sources import read_result
from residual.spectrum import ORDERS, derivative, floor, response, stencil
from tests.reference.kit import budget_terms, read_json
from tests.reference.synthetic_run import exact_errors, make_run, recorded, report_of, run_variables, write_result


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=3001)


@pytest.fixture(scope="module")
def evaluation(run, tmp_path_factory):
    return evaluate(recorded(tmp_path_factory.mktemp("runs") / "made.nc", run))


def test_error_forces_and_their_terms_are_those_of_the_closed_form(run, evaluation):
    """The momentum balance leaves out law and friction; the run's forces are 0.95 of the law's. A roller under the
    ring, pulled along +θ (that is +x there), pulls the ring along −x.
    """
    budget, angle, traction = evaluation.budget, run.angle, run_variables(run)["inner_traction"]
    along = -np.sin(angle), np.cos(angle)
    for part, exact, on_circle in zip((budget.x, budget.y), exact_errors(run), along, strict=True):
        np.testing.assert_allclose(part.error, exact, atol=1e-5)
        rest = part.terms["differentiation"] + part.terms["ring_flexibility"]
        np.testing.assert_allclose(part.momentum, rest, atol=1e-8)
        np.testing.assert_allclose(part.terms["friction"], np.sum(-traction * on_circle, axis=1), atol=1e-9)
    push = -np.sum(run.law_force * np.sin(angle), axis=1)
    np.testing.assert_allclose(budget_terms(evaluation)[1]["contact_law"], -0.05 * push, atol=1e-7)
    below = np.zeros_like(traction)
    below[0, int(np.argmin(np.sin(angle[0])))] = 1.0
    assert traction_resultant(budget.contacts, below)[0][0] < -0.97
    count = (run.law_force > 0).sum(axis=1)
    assert evaluation.loaded_range == (count.min(), count.max())


def test_run_in_momentum_balance_is_found_balanced_and_a_force_that_the_file_does_not_tell_is_found(tmp_path):
    """Load and gravity taken from the contact forces: a run that obeys Newton must show no momentum error."""
    run = make_run(n_times=2001)
    variables = run_variables(run, force_factor=1.0, traction=0.0)
    budget = evaluate(recorded(tmp_path / "n.nc", run, variables)).budget
    np.testing.assert_allclose(budget.x.terms["contact_law"], 0.0, atol=1e-6)
    np.testing.assert_allclose(budget.y.momentum, exact_errors(run)[1], atol=1e-5)
    assert run.scene.operation.inner_ring_and_shaft_kg * np.max(np.abs(run.acceleration_x)) > 0.1
    missing = 5.0 * np.sin(2 * np.pi * 800.0 * run.time)
    lowest, rows = np.argmin(np.sin(run.angle), axis=1), np.arange(run.time.size)
    variables["inner_force"][rows, lowest] -= missing / -np.sin(run.angle[rows, lowest])
    hidden = evaluate(recorded(tmp_path / "b.nc", run, variables)).budget.y.momentum
    np.testing.assert_allclose(hidden - budget.y.momentum, missing, atol=1e-7)


def test_without_forces_the_error_has_no_terms_and_laws_are_ranked_but_not_fitted(tmp_path, capsys):
    run = make_run(n_times=501)
    motion = {name: getattr(run, name) for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y")}
    found = evaluate(recorded(tmp_path / "n.nc", run, motion))
    assert found.budget.x.terms == {} and found.budget.x.momentum is None
    assert {s.name for s in found.laws} >= {"harris", "palmgren", "johnson"}
    assert main([str(tmp_path / "n.nc"), "--law", "fitted"]) == 2 and "forces" in capsys.readouterr().err


def test_start_skips_exactly_the_transient_and_the_load_ramp_of_a_start_from_rest(run, evaluation, tmp_path):
    late, n = evaluate(evaluation.record, start=5e-3), run.time.size - 500
    assert [late.start, late.record.time[0]] == pytest.approx([5e-3, 5e-3], abs=1e-9)
    assert late.budget.x.error.size == n  # the stencil reaches back before it
    np.testing.assert_array_equal(late.budget.x.error, evaluation.budget.x.error[-n:])
    loaded = np.zeros((12, 2), dtype=bool)
    loaded[6:, 1] = True
    assert np.flatnonzero(near_contact_change(loaded, 2)).tolist() == [4, 5, 6, 7, 8]
    scene = parse_scene({"numerics": {"start": "rest"}}, "made")
    found = evaluate(recorded(tmp_path / "n.nc", make_run(n_times=8001, scene=scene)))
    assert found.start == pytest.approx(1e-3, abs=1e-9) and any("load ramp" in note for note in found.notes)
    assert check_vibration([str(tmp_path / "n.nc"), "--quiet", "--no-figures"]) == 0
    assert read_json(tmp_path / "n-vibration" / "summary.json")["seconds"] == pytest.approx(0.079, abs=2e-5)
    found = evaluate(recorded(tmp_path / "n.nc", make_run(n_times=601, interval=1e-4)))
    assert any("Nyquist" in note for note in found.notes)


OMEGA = 2 * np.pi * 40.0


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [1, 2])
def test_stencil_is_exact_for_polynomials_and_of_its_nominal_order(order, which):
    t, half = np.linspace(-1.0, 1.0, 21), order // 2
    for power in range(order + which):
        exact = np.polynomial.polynomial.polyder([0] * power + [1], which)
        found = derivative(np.stack([t**power, -(t**power)], axis=1), t[1] - t[0], which, order)
        inner = slice(half, -half) if power > order else slice(1, -1) if power > 4 else slice(None)
        exact = np.polynomial.polynomial.polyval(t, exact)[inner]
        np.testing.assert_allclose(found[inner], np.stack([exact, -exact], axis=1), atol=2e-11)
    steps, errors = 0.1 / np.array([40, 60, 80]), []
    for step in steps:
        t = OMEGA * step * np.arange(round(0.1 / step) + 1)
        found = derivative(np.sin(t), step, which, order) / OMEGA**which
        errors.append(np.max(np.abs(found - (np.cos(t) if which == 1 else -np.sin(t)))[half:-half]))
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.25)


def test_known_weights_of_order_six_and_that_a_stencil_is_not_the_integrators_own():
    """A leapfrog trajectory's own second difference is its acceleration exactly: no test. This differs."""
    # Fornberg 1988, table 1
    expected = [1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90]
    np.testing.assert_allclose(stencil(6), expected, rtol=0, atol=1e-14)
    assert stencil(8).sum() == pytest.approx(0.0, abs=1e-13)
    dt, omega = 1e-3, 600.0
    x = np.empty(400)
    x[0], x[1] = 1.0, 1.0 - 0.5 * (omega * dt) ** 2
    for i in range(1, 399):
        x[i + 1] = 2 * x[i] - x[i - 1] - (omega * dt) ** 2 * x[i]
    own = np.diff(x, 2) / dt**2 + omega**2 * x[1:-1]
    ours = derivative(x, dt)[3:-3] + omega**2 * x[3:-3]
    assert np.max(np.abs(own)) < 1e-6 * omega**2 and np.sqrt(np.mean(ours**2)) > 1e-2 * omega**2 * np.sqrt(0.5)


def test_response_is_the_gain_on_a_sine_and_1_far_below_the_sampling_frequency():
    dt, frequency = 1e-5, 13.2e3
    record = np.sin(2 * np.pi * frequency * dt * np.arange(500))
    found, exact = derivative(record, dt, order=6), -((2 * np.pi * frequency) ** 2) * record[3:-3]
    # the mean taken off the record does not matter: the weights add up to zero
    np.testing.assert_allclose(found[3:-3], response(frequency, dt) * exact, atol=1e-8 * np.max(np.abs(exact)))
    assert abs(1 - response(frequency, dt)) < 6e-4
    for order in ORDERS:
        np.testing.assert_allclose(response([0.0, 1e-12, 1e-6, 1.0], 1e-5, order), 1.0, rtol=1e-12)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tones", [(8e3,), (300.0, 13e3, 40e3)])
def test_truncation_floor_is_the_true_error_and_round_off_floor_bounds_that_of_single_precision(order, tones):
    eps, step = float(np.finfo(np.float32).eps), 1e-5
    exact = 4e-6 * np.sin(OMEGA * step * np.arange(4000))
    stored = exact.astype(np.float32).astype(float)
    noise = np.abs(derivative(stored, step) - derivative(exact, step))[1:-1]
    bound = floor(stored, step, eps=eps).round_off
    assert 0.05 * bound < noise.max() <= bound
    omega, t = 2 * np.pi * np.array(tones)[:, None], step * np.arange(6001)
    record, exact = np.sum(np.sin(omega * t) / omega, axis=0), -np.sum(omega * np.sin(omega * t), axis=0)
    error = (derivative(record, step, order=order) - exact)[order:-order]
    assert floor(record, step, order).truncation == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.03)


def test_ends_are_good_for_slow_motion_and_noise_is_magnified_as_the_weights_say():
    step, omega = 1e-5, 2 * np.pi * 1e3
    t = step * np.arange(200)
    for which, exact in ((1, -omega * np.sin(omega * t)), (2, -(omega**2) * np.cos(omega * t))):
        assert np.max(np.abs(derivative(np.cos(omega * t), step, which) - exact)) < 3e-4 * omega**which
    impulse_gain = [np.linalg.norm([derivative(row, 1.0)[i] for row in np.eye(15)]) for i in (0, 1, 2, -1)]
    assert impulse_gain == pytest.approx([14.0, 3.6, 2.9, 14.0], rel=0.01)
    white = derivative(1e-9 * np.random.default_rng(1).standard_normal(20000), 1e-5)
    assert np.std(white) == pytest.approx(1e-9 * np.linalg.norm(stencil(6)) / 1e-10, rel=0.03)


def test_unknown_stencils_and_too_short_records_are_refused():
    for samples, order, words in ((20, 5, "must be"), (20, 2, "must be"), (6, 6, "too few")):
        with pytest.raises(ValueError, match=words):
            derivative(np.zeros(samples), 1.0, order=order)


STIFFNESS, EXPONENT = 1.1e9, 1.09
SPRING = PowerLaw(name="true", stiffness=STIFFNESS, exponent=EXPONENT, source="")


def load_zone(n_times=1200, turns=1.5):
    """Approaches of rollers that pass a cosine-shaped load zone, m."""
    angle = 2 * np.pi * (np.arange(13) / 13 + turns * np.arange(n_times)[:, None] / n_times)
    return 2e-6 * np.cos(angle)


DEPTH = load_zone()
SPEED = 1e-3 * np.random.default_rng(4).standard_normal(DEPTH.shape)  # m/s, of the size of a vibrating roller's


def power(depth):
    return STIFFNESS * np.maximum(depth, 0.0) ** EXPONENT


def test_a_law_and_damping_beside_it_are_found_again():
    """The part held back is not seen."""
    force = power(DEPTH)
    found = fit_law(DEPTH, force, bridge=5)
    assert found.stiffness.value == pytest.approx(STIFFNESS, rel=1e-8)
    assert found.exponent.value == pytest.approx(EXPONENT, rel=1e-9) and found.scatter < 1e-6
    force[600:] *= 3.0
    assert fit_law(DEPTH, force, bridge=5).law == found.law
    force = DampedLaw(spring=SPRING, damping=ContactDamping(constant=300.0)).pushes(DEPTH, SPEED).force
    found = fit_law(DEPTH, force, bridge=5, closing_speed=SPEED)
    assert found.damping.value == pytest.approx(300.0, rel=1e-3)
    assert found.exponent.value == pytest.approx(EXPONENT, rel=1e-5) and found.law.name == "fitted_damped"
    np.testing.assert_allclose(found.law.pushes(DEPTH, SPEED).force, force, atol=0.05)
    # damping that is not there is told by an interval around zero
    noise = 0.5 * np.random.default_rng(5).standard_normal(DEPTH.shape)
    force = np.where(DEPTH > 0.0, np.maximum(power(DEPTH) + noise, 0.0), 0.0)
    found = fit_law(DEPTH, force, bridge=5, closing_speed=SPEED)
    assert found.damping.low < 0.0 < found.damping.high < found.damping.low + 100.0
    # passages bridge chatter
    closed = np.zeros((20, 2), dtype=bool)
    closed[2:6, 0] = closed[8:12, 0] = closed[16:, 0] = True
    number = passage_numbers(closed, bridge=2)
    assert number[3, 0] == number[9, 0] != number[18, 0] and number[:, 1].max() == -1


EVEN = np.full((200, 13), 1e-6)
UNFIT = {  # approaches, forces, closing speeds, words; a dashpot like the spring is no other than a stiffer spring
    "still": (DEPTH, power(DEPTH), 0.0 * DEPTH, "damping"),
    "faint": (DEPTH, 1e-310 * (DEPTH > 0.0), None, "too small to fit a law to"),
    "squares of nothing": (DEPTH, 1e-160 * (DEPTH > 0.0), None, "too small to fit a law to"),
    "like the spring": (DEPTH, power(DEPTH), 1e-6 * power(DEPTH), "do not fix all numbers"),
    "constant": (EVEN, power(EVEN), None, "hardly vary"), "open": (-EVEN, power(-EVEN), None, "passages"),
}  # fmt: skip


@pytest.mark.parametrize("kind", UNFIT)
def test_data_that_fix_no_law_are_refused_in_a_sentence(kind):
    depth, force, speed, words = UNFIT[kind]
    with pytest.raises(InputError, match=words):
        fit_law(depth, force, bridge=5, closing_speed=speed)


def test_intervals_cover_the_truth_though_samples_of_a_passage_are_correlated():
    """Each passage errs by one factor of its own: 95 % intervals must hold about that often."""
    depth, covered = load_zone(600, turns=2.0), []
    passage = passage_numbers(depth > 0.0, 5)
    for seed in range(150):
        factor = 1.0 + 0.02 * np.random.default_rng(seed).standard_normal(passage.max() + 2)
        found = fit_law(depth, power(depth) * factor[passage], bridge=5, samples=600)
        known = ((found.stiffness, STIFFNESS), (found.exponent, EXPONENT))
        covered.append([number.low <= true <= number.high for number, true in known])
    share = np.mean(covered, axis=0)
    assert np.all(share > 0.85) and np.all(share < 0.999)


def test_law_of_a_run_is_fitted_judged_by_the_held_back_part_and_ranked_among_others(run, evaluation):
    """The run's forces are 0.95 of Harris's: K is, n is Harris's, and no contact-law term is left."""
    fitted = evaluate(evaluation.record, "fitted")
    harris = steel_law("harris", run.scene.ideal_bearing().roller_length)
    assert fitted.law.spring.exponent == pytest.approx(10 / 9, rel=1e-7)
    assert fitted.law.spring.stiffness == pytest.approx(0.95 * harris.stiffness, rel=1e-5)
    np.testing.assert_allclose(budget_terms(fitted)[1]["contact_law"], 0.0, atol=1e-4)
    given = evaluate(evaluation.record, fitted.law.spring)  # the law itself in place of its name
    np.testing.assert_allclose(given.budget.y.error, fitted.budget.y.error, atol=1e-9)
    held_back = fitted.budget.y.error[fitted.identification.samples :]
    assert fitted.judged[1].rms == pytest.approx(np.sqrt(np.mean(held_back**2)), rel=1e-12)
    # the ranking agrees with an evaluation under each law
    ranked = evaluate(evaluation.record, "palmgren", fit=True)
    late = slice(fitted.identification.samples, None)
    assert [s.rms for s in ranked.laws] == sorted(s.rms for s in ranked.laws)
    for law in ("harris", "fitted", "johnson", "teutsch_sauer"):
        alone, score = evaluate(evaluation.record, law).budget, ranked.score(law)
        assert score.errors[1].mean == pytest.approx(np.mean(alone.y.error[late]), abs=1e-9), law
        assert score.errors[0].rms == pytest.approx(np.sqrt(np.mean(alone.x.error[late] ** 2)), abs=1e-9), law


def test_summary_and_terminal_tell_the_fit_and_the_ranking(run, tmp_path, capsys):
    path = write_result(tmp_path / "a.nc", run)
    summary, page = report_of(path, tmp_path / "out", "--law", "fitted", "--compare-laws", "--no-figures")
    printed, fit = capsys.readouterr().out, summary["identification"]
    assert all(words in printed for words in ("Fitted: K = ", "teutsch_sauer", "fitted (in use)"))
    assert fit["exponent"]["low"] <= fit["exponent"]["value"] <= fit["exponent"]["high"]
    assert fit["held_back"]["samples"] + round(fit["fitted_until_s"] / 1e-5) + 1 == run.time.size
    assert {row["law"] for row in summary["laws"]} >= {"harris", "fitted", "fitted_damped", "johnson"}
    assert "95 % confidence" in page and "Held-back part" in page


def test_fitted_law_explains_a_simulated_run(coarse_run):
    """On the part of a finite-element run not fitted to: under 10 N rms in y, mean under 2 N; and no damping."""
    evaluation = evaluate(read_result(coarse_run), "fitted", fit=True)
    _, error_y = evaluation.judged
    assert error_y.rms < 10.0 and abs(error_y.mean) < 2.0 and evaluation.score("harris").errors[1].rms > 100.0
    damping = evaluation.identified["fitted_damped"].damping
    assert damping.low < 0.0 < damping.high


FORWARD, MOMENT, GUIDED = 30.0, -0.02, (3.0, -4.0)  # N, N m, N: on every roller, on the cage
AGAINST = -0.5 * FORWARD + 0.5 * MOMENT / 0.005  # N, of the inner raceway on the roller
GUIDE = {"guidance": "inner_ring", "guidance_clearance_mm": 0.1}


def made_file(folder, cage=GUIDE, samples=4001, **changes):
    """A made-up run whose cage pushes every roller forward, rubs on it, and is pushed by the inner ring."""
    run = make_run(n_times=samples, scene=parse_scene({"cage": cage}, "made"))
    time, rollers = run.time, np.ones((run.time.size, 13))
    values = {"cage_x": 2e-5 * np.cos(100.0 * time), "cage_y": 2e-5 * np.sin(100.0 * time), "cage_angle": 180.0 * time}
    values |= {"cage_force": FORWARD * rollers, "cage_moment": MOMENT * rollers}
    values |= {f"cage_guidance_{axis}": force + 0.0 * time for axis, force in zip("xy", GUIDED, strict=True)}
    return run, write_result(folder / "made.nc", run, run_variables(run) | values | changes)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    run, path = made_file(tmp_path_factory.mktemp("caged"))
    return run, evaluate(read_result(path))


def test_the_cages_term_is_what_rollers_pass_on_and_the_guide_gives(made, tmp_path):
    """Of a force forward each raceway takes half against it; of a moment, one raceway forward and one back. A cage that
    rollers guide leaves the hub alone.
    """
    run, evaluation = made
    split = zip(budget_terms(evaluation), (-np.sin(run.angle), np.cos(run.angle)), GUIDED, strict=True)
    for terms, along, guided in split:  # along +θ
        np.testing.assert_allclose(terms["cage"], -(AGAINST * along).sum(axis=1) - guided, atol=1e-9)
        whole = -(run_variables(run)["inner_traction"] * along).sum(axis=1)
        np.testing.assert_allclose(terms["friction"] + terms["cage"], whole - guided, atol=1e-9)
    run, path = made_file(tmp_path, cage={"guidance": "rollers"})
    terms = evaluate(read_result(path)).budget.x.terms
    np.testing.assert_allclose(terms["cage"], -(AGAINST * -np.sin(run.angle)).sum(axis=1), atol=1e-6)


def test_the_summary_tells_slip_whirl_and_forces_but_of_a_shaft_that_turns_both_ways(made, monkeypatch):
    assert summarise(made[1], ReportOptions())["cage"] == pytest.approx({
        "speed_Hz": 180.0 / (2.0 * np.pi), "whirl_Hz": 100.0 / (2.0 * np.pi), "largest_offset_m": 2e-5,
        "slip": 1.0 - 180.0 / (0.5 * 150.0 * np.pi * 36.0 / 46.0), "largest_pocket_force_N": FORWARD,
        "largest_guidance_force_N": 5.0,
    })  # fmt: skip
    monkeypatch.setattr(Record, "reverses", True)
    summary = summarise(made[1], ReportOptions())
    assert summary["cage_Hz"]["rolling_without_slip"] is None
    assert summary["cage"]["speed_Hz"] is summary["cage"]["whirl_Hz"] is summary["cage"]["slip"] is None
    assert summary["cage"]["largest_offset_m"] == pytest.approx(2e-5)
    for speed, whirls in ((1.0, True), (0.0, False)):
        assert ("whirls" in cage_rows(defaultdict(lambda: np.ones(2)), speed)["cage's centre"]) == whirls


def test_within_one_turn_no_slip_is_told_and_without_a_cage_nothing(evaluation, tmp_path):
    short = evaluate(read_result(made_file(tmp_path, samples=3001)[1]))
    assert summarise(short, ReportOptions())["cage"]["slip"] is None
    assert "slower" not in (words := findings.cage_rows(short)[0][1]) and "faster" not in words
    assert "turns less than once and has no mean slip" in cage_figure(short).caption
    assert "cage" not in evaluation.budget.x.terms and "cage" not in summarise(evaluation, ReportOptions())
    with pytest.raises(InputError, match="cage_force"):
        read_result(made_file(tmp_path, cage_force=np.full((4001, 13), np.nan))[1])
