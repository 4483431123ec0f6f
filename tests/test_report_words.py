"""What a report calls things: numbers as a person reads them, causes by their right names, one sentence first."""

import numpy as np
import pytest

from residual.evaluation import evaluate
from residual.formatting import hertz, length, text
from residual.interpretation import verdict
from residual.lines import HUB, named_peaks
from residual.record import Record
from residual.spectrum import find_peaks, power_spectrum
from residual.tables import error_table, peak_name
from tests.reference.synthetic_run import make_run, recorded, run_variables

STEP = 1e-5


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (-8.03e-5, "−8.03·10⁻⁵"), (46460.0, "46460"), (213.6049, "213.6"), (0.0, "0"), (-0.5, "−0.5"),
        (0.000123456, "0.0001235"), (2.5e10, "2.5·10¹⁰"), (1.09e-9, "1.09·10⁻⁹"), (99999.6, "100000"), (1e6, "1·10⁶"),
    ],
)  # fmt: skip
def test_numbers_are_written_out_where_a_person_would(value, expected):
    assert text(value) == expected


def test_noise_is_0_and_units_fit():
    assert text(-2.8e-4, noise=2e-3) == "0" and text(2.8e-3, noise=2e-3) == "0.0028"
    assert hertz(380.04) == "380 Hz" and hertz(46460.0) == "46.46 kHz"
    assert [length(x) for x in (3.034e-10, -1.477e-5, 0.0, 1e-13)] == ["0.3034 nm", "−14.77 µm", "0 nm", "0 nm"]


def damped_record(damping):
    """A table's record whose contact forces hold the hub's motion with a damper that stands in no column."""
    run = make_run(n_times=2001)
    o, mass = run.scene.operation, run.scene.operation.inner_ring_and_shaft_kg
    velocity = 2 * np.pi * 500.0 * run.inner_x  # of inner_y: d(sin) = ω cos
    wanted = mass * run.acceleration_y + mass * o.gravity_m_s2 + o.radial_load_N + damping * velocity
    share = wanted / -np.sum(run.law_force * np.sin(run.angle), axis=1)
    record = Record(
        name="rig", source="rig.csv", scene=run.scene, time=run.time, inner_x=run.inner_x, inner_y=run.inner_y,
        roller_x=run.roller_x, roller_y=run.roller_y, inner_force=run.law_force * share[:, None],
    )  # fmt: skip
    return record, damping * velocity


def test_a_hidden_damper_is_found_as_other_forces():
    record, force = damped_record(2e4)
    terms = evaluate(record).budget.y.terms
    assert "ring_flexibility" not in terms
    found = terms["other_forces"]
    assert np.sqrt(np.mean(found**2)) == pytest.approx(np.sqrt(np.mean(force**2)), rel=5e-3)
    np.testing.assert_allclose(found[50:-50], -force[50:-50], atol=5e-3 * np.abs(force).max())


def noise_and_tones(*tones):
    time = STEP * np.arange(6001)
    record = 1e-3 * np.random.default_rng(3).standard_normal(time.size)
    return record + sum(np.cos(2 * np.pi * f * time) for f in tones)


def test_the_hubs_resonance_and_two_lines_in_one_bin_are_named():
    lines = {"BPFO": 380.0, "5×BPFI": 2995.0, "8×BPFO": 3003.0}
    spectrum = power_spectrum(noise_and_tones(3000.0, 13_100.0, 7000.0), STEP)
    peaks = named_peaks(find_peaks(spectrum, lines), spectrum, lines, 13_000.0, 0.0)
    names = {round(peak.frequency, -2): peak_name(peak) for peak in peaks}
    assert names[3000.0] in ("8×BPFO or 5×BPFI", "5×BPFI or 8×BPFO")
    assert names[13_100.0] == HUB and names[7000.0] == "-"


def test_peaks_of_no_more_than_noise_are_left_out():
    lines = {"BPFO": 380.0}
    spectrum = power_spectrum(1e-9 * noise_and_tones(3000.0), STEP)
    found = find_peaks(spectrum, lines)
    assert named_peaks(found, spectrum, lines, 13_000.0, 0.0)
    assert named_peaks(found, spectrum, lines, 13_000.0, 1e-6) == []


def test_a_roller_that_barely_touches_is_not_loaded(tmp_path):
    run = make_run(n_times=401)
    variables = run_variables(run)
    most = variables["inner_force"].max()
    before = evaluate(recorded(tmp_path / "a.nc", run, variables)).loaded_range
    variables["inner_force"] = np.maximum(variables["inner_force"], 0.009 * most)
    assert evaluate(recorded(tmp_path / "b.nc", run, variables)).loaded_range == before == (6, 7)
    variables["inner_force"] = np.maximum(variables["inner_force"], 0.011 * most)
    assert evaluate(recorded(tmp_path / "c.nc", run, variables)).loaded_range == (13, 13)


def test_the_first_sentence_tells_sound_trajectories_from_others_and_peak_from_rms(tmp_path):
    record, _ = damped_record(0.0)
    good = verdict(evaluate(record))
    assert good.startswith("The trajectories are") and "at most" in good
    told = evaluate(recorded(tmp_path / "a.nc", make_run(n_times=401)))
    found = verdict(told)
    assert found.startswith("The trajectories are not sound") and found.count(".") < 20
    worst, peak = max(e.rms for e in told.judged), max(e.max_abs for e in told.judged)
    assert f"{text(100 * worst / 2000, 3)} % of the load, and at most by {text(peak)} N" in found
    assert verdict(told, 1.0).startswith("Fails the tolerance of 1 N: the trajectories")


def test_round_off_in_a_table_is_0():
    record, _ = damped_record(0.0)
    rows = {row[0]: row[1:] for row in error_table(evaluate(record)).rows}
    assert rows["momentum balance, y"][0] == "0"
