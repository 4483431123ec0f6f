"""Levels of lines, sidebands, envelope: the right newtons under the right name, and silence where nothing is known."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fem.commands.run_fem import run_main
from residual.cli import main
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.lines import HUB, high_lines, line_levels, named_peaks, sidebands, watched_level
from residual.spectrum import envelope, find_peaks, power_spectrum
from tests.reference.synthetic_run import harris_force, make_run, paper_lines, recorded, run_variables, write_result

STEP = 1e-5
BPFO, SHAFT, CAGE = 381.52, 75.0, 29.348


def times(duration):
    return STEP * np.arange(round(duration / STEP))


def noise(duration, seed=1):
    return 0.01 * np.random.default_rng(seed).standard_normal(round(duration / STEP))


def modulated(duration, modulator, depth=0.4):
    """A tone at BPFO of 10 N amplitude whose amplitude swells at the modulator's frequency."""
    t = times(duration)
    return 10.0 * (1.0 + depth * np.cos(2 * np.pi * modulator * t)) * np.cos(2 * np.pi * BPFO * t) + noise(duration)


def by_name(levels):
    return {level.name: level for level in levels}


@pytest.mark.parametrize("duration", [0.06, 0.6])
def test_level_is_the_rms_of_the_line_whatever_the_record_length(duration):
    record = 7.0 * np.cos(2 * np.pi * BPFO * times(duration) + 0.4) + noise(duration)
    level = by_name(line_levels(power_spectrum(record, STEP), paper_lines()))["BPFO"]
    assert level.rms == pytest.approx(7.0 / np.sqrt(2), rel=0.02)
    assert level.stands_out and level.background < 0.1 * level.rms


def test_sidebands_carry_half_the_modulation():
    levels = by_name(line_levels(power_spectrum(modulated(0.6, CAGE), STEP), paper_lines()))
    for name in ("BPFO−FTF", "BPFO+FTF"):
        assert levels[name].rms == pytest.approx(10.0 * 0.4 / 2 / np.sqrt(2), rel=0.02)
        assert levels[name].stands_out and levels[name].resolved
    assert not levels["BPFO+shaft"].stands_out


def test_sidebands_a_record_cannot_resolve_are_not_listed():
    names = by_name(line_levels(power_spectrum(modulated(0.06, CAGE), STEP), paper_lines()))
    assert "BPFO+FTF" not in names and "BPFO+shaft" in names


def test_peaks_at_sidebands_get_their_name():
    spectrum = power_spectrum(modulated(0.6, SHAFT), STEP)
    peaks = named_peaks(find_peaks(spectrum, paper_lines()), spectrum, paper_lines(), 13e3, 0.0)
    assert {"BPFO", "BPFO−shaft", "BPFO+shaft"} <= {peak.line for peak in peaks}


def tones(duration, *frequencies):
    return sum(np.cos(2.0 * np.pi * f * times(duration)) for f in frequencies) + noise(duration)


def test_high_multiples_of_a_spalls_passes_get_their_name():
    """A strike rings out near 4 kHz at the outer ring and at 6 kHz on a roller; 4.3 kHz belongs to nothing."""
    roller = 2.0 * paper_lines()["BSF"]
    rings = tones(0.6, 10 * BPFO, 11 * BPFO, 18 * roller, 19 * roller, 4310.0)
    spectrum = power_spectrum(rings, STEP)
    peaks = named_peaks(find_peaks(spectrum, paper_lines()), spectrum, paper_lines(), 0.0, 0.0)
    assert {peak.line for peak in peaks[:5]} == {"10×BPFO", "11×BPFO", "36×BSF", "38×BSF", None}
    coarse = power_spectrum(rings[: round(10.0 / BPFO / STEP)], STEP)
    assert high_lines(10 * BPFO, coarse, paper_lines()) == []  # ten bins apart: chance would name peaks


@pytest.mark.parametrize("beside", ["12×BPFO", "11×BPFO+FTF"])
def test_a_sideband_of_a_multiple_that_is_there_wins_over_a_multiple_of_what_is_not(beside):
    """28×BSF and 12×BPFO+FTF are one frequency here: what else stands in the spectrum says which of them it is."""
    lines = {"FTF": 19.3, "BPFO": 250.9, "BPFI": 377.0, "shaft": 48.3}
    frequency = 12 * lines["BPFO"] + lines["FTF"]
    lines["BSF"] = frequency / 28
    witness = {"12×BPFO": frequency - lines["FTF"], "11×BPFO+FTF": frequency - lines["BPFO"]}[beside]
    spectrum = power_spectrum(tones(0.6, frequency, witness), STEP)
    assert high_lines(frequency, spectrum, lines) == ["12×BPFO+FTF"]
    rolling = power_spectrum(tones(0.6, frequency, 2 * lines["BSF"]), STEP)
    assert high_lines(frequency, rolling, lines) == ["28×BSF"]
    both = power_spectrum(tones(0.6, frequency, witness, 26 * lines["BSF"]), STEP)
    assert set(high_lines(frequency, both, lines)) == {"12×BPFO+FTF", "28×BSF"}
    alone = power_spectrum(tones(0.6, frequency), STEP)
    assert high_lines(frequency, alone, lines) == []


def test_the_hub_has_a_resonance_of_its_own_in_each_direction(tmp_path):
    """Stiffnesses of the prescribed approaches by differences of Harris's law, half of them for two contacts in series.

    The run's own forces are 0.9 of that law's, and so are its stiffnesses.
    """
    run = make_run(n_times=2001)
    evaluation = evaluate(recorded(tmp_path / "a.nc", run, run_variables(run, force_factor=0.9)))
    depth, step = 2.05e-6 * -np.sin(run.angle), 1e-10
    slope = (harris_force(depth + step) - harris_force(depth - step)) / (2.0 * step)
    mass = run.scene.operation.inner_ring_and_shaft_kg
    for found, part in ((evaluation.x, np.cos), (evaluation.y, np.sin)):
        stiffness = 0.9 * 0.5 * np.mean(np.sum(slope * part(run.angle) ** 2, axis=1))
        assert found.resonance == pytest.approx(np.sqrt(stiffness / mass) / (2.0 * np.pi), rel=1e-3)
    assert evaluation.x.resonance < 0.99 * evaluation.y.resonance


def test_a_vibration_across_the_load_is_named_by_the_resonance_across_it():
    lines = {"BPFO": 250.9}
    spectrum = power_spectrum(tones(0.6, 2700.0), STEP)
    found = find_peaks(spectrum, lines)
    assert [HUB in peak.also for peak in named_peaks(found, spectrum, lines, 2750.0, 0.0)[:1]] == [True]
    assert [HUB in peak.also for peak in named_peaks(found, spectrum, lines, 4600.0, 0.0)[:1]] == [False]


def test_sideband_frequencies():
    found = sidebands(paper_lines())
    assert found["BPFO−shaft"] == pytest.approx(BPFO - SHAFT, abs=0.05)
    assert found["2×BPFO+FTF"] == pytest.approx(2 * BPFO + CAGE, abs=0.1)


def test_lines_go_by_the_cage_speed_of_the_run(tmp_path):
    """A cage that creeps by 2 %: BPFO and BPFI move with it, and the peak at the run's own BPFO keeps its name."""
    run = make_run(n_times=20_001)
    slow, ideal = 0.98 * CAGE, CAGE
    turn = 2 * np.pi * (slow - ideal) * run.time[:, None]
    x, y = run.roller_x - run.inner_x[:, None], run.roller_y - run.inner_y[:, None]
    distance, angle = np.hypot(x, y), run.angle + turn
    depth = 2.05e-6 * -np.sin(angle)
    distance = np.median(distance + 2.05e-6 * -np.sin(run.angle)) - depth
    moved = replace(
        run,
        roller_x=run.inner_x[:, None] + distance * np.cos(angle),
        roller_y=run.inner_y[:, None] + distance * np.sin(angle),
        angle=angle,
    )
    evaluation = evaluate(recorded(tmp_path / "a.nc", moved))
    assert evaluation.lines["FTF"] == pytest.approx(slow, rel=1e-3)
    assert evaluation.ideal_cage == pytest.approx(ideal, rel=1e-4)
    assert evaluation.lines["BPFI"] == pytest.approx(13 * (SHAFT - slow), rel=1e-3)
    assert any(peak.line == "BPFO" and abs(peak.frequency - 13 * slow) < 0.5 for peak in evaluation.x.peaks)


def test_a_hub_on_contacts_that_every_passage_softens_is_named_with_its_sidebands():
    # Mathieu's equation with a damper; its exponent by the monodromy matrix of one passage, not by a spectrum
    lines, omega, damping, depth = paper_lines(), 2.0 * np.pi * 0.54 * BPFO, 4.0, 0.2
    time = STEP * np.arange(30_000)

    def slope(t, state):
        stiffness = omega**2 * (1.0 + depth * np.cos(2.0 * np.pi * BPFO * t))
        return [state[1], -damping * state[1] - stiffness * state[0]]

    exact = {"rtol": 1e-8, "atol": 1e-10}
    passage = 1.0 / BPFO
    columns = [solve_ivp(slope, (0.0, passage), start, **exact).y[:, -1] for start in ([1.0, 0.0], [0.0, 1.0])]
    turn = abs(np.angle(np.linalg.eigvals(np.array(columns)))).max() / (2.0 * np.pi)  # of a passage, folded to ½
    assert 0.4 < turn < 0.5
    record = solve_ivp(slope, (0.0, time[-1]), [1.0, 0.0], t_eval=time, **exact).y[0]
    spectrum = power_spectrum(record, STEP)
    peaks = named_peaks(find_peaks(spectrum, lines), spectrum, lines, omega / (2.0 * np.pi), 0.0)
    told = {peak.also: peak.frequency for peak in peaks if peak.line is None}
    assert told[(HUB,)] == pytest.approx((1.0 - turn) * BPFO, abs=0.5 * spectrum.resolution)
    assert told[(f"BPFO − {HUB}",)] == pytest.approx(turn * BPFO, abs=0.5 * spectrum.resolution)
    assert told[(f"BPFO + {HUB}",)] == pytest.approx((2.0 - turn) * BPFO, abs=0.5 * spectrum.resolution)
    short = power_spectrum(record[:3000], STEP)
    found = named_peaks(find_peaks(short, lines), short, lines, omega / (2.0 * np.pi), 0.0)
    assert {also for peak in found for also in peak.also if HUB in also} <= {HUB}  # chance would name peaks


def test_background_is_the_mean_density_of_noise():
    record = np.random.default_rng(0).standard_normal(60_000)
    background = power_spectrum(record, STEP).smooth_background
    assert np.median(background) == pytest.approx(2 * STEP, rel=0.1)


def test_lines_hardly_ever_stand_out_of_mere_noise():
    found = total = 0
    for seed in range(30):
        levels = line_levels(power_spectrum(noise(0.2, seed), STEP), paper_lines())
        found, total = found + sum(level.stands_out for level in levels), total + len(levels)
    assert total > 600 and found <= 0.01 * total


@pytest.mark.parametrize("wanted", ["BPFO-shaft", "bpfo−shaft", "2xBPFO", "2×BPFO", "22", "381.5"])
def test_a_line_can_be_asked_for_by_name_or_frequency(wanted):
    level = watched_level(power_spectrum(noise(0.6), STEP), wanted, paper_lines())
    expected = {"BPFO-shaft": 306.5, "bpfo−shaft": 306.5, "2xBPFO": 763.0, "2×BPFO": 763.0}.get(wanted)
    assert level.frequency == pytest.approx(expected or float(wanted), abs=0.1)


@pytest.mark.parametrize("wanted", ["BPFX", "-5", "0", "1e9", "nan", "", "1e-320"])
def test_an_unknown_line_is_refused(wanted):
    with pytest.raises(InputError):
        watched_level(power_spectrum(noise(0.06), STEP), wanted, paper_lines())


def test_the_record_said_to_be_needed_is_enough_and_a_shorter_one_is_not():
    lines = paper_lines()
    short = watched_level(power_spectrum(noise(0.06), STEP), "22", lines)
    assert not short.resolved and short.record_needed == pytest.approx(2.0 / (CAGE - 22.0), rel=1e-3)
    for factor, resolved in ((1.02, True), (0.98, False)):
        spectrum = power_spectrum(noise(factor * short.record_needed), STEP)
        assert watched_level(spectrum, "22", lines).resolved is resolved


def test_envelope_shows_what_modulates_the_resonance():
    t = times(0.3)
    record = (2.0 + 1.0 * np.cos(2 * np.pi * BPFO * t)) * np.cos(2 * np.pi * 13_000 * t) + noise(0.3)
    found = envelope(record, STEP, 13_000.0)
    assert found.rms == pytest.approx(np.sqrt(2.0 + 0.25), rel=0.01)
    assert np.mean(found.level) == pytest.approx(2.0, rel=0.01)
    peak = find_peaks(found.spectrum, paper_lines())[0]
    assert peak.line == "BPFO" and peak.rms == pytest.approx(1.0 / np.sqrt(2), rel=0.02)
    plain = power_spectrum(record, STEP)
    assert plain.band_rms(BPFO - 10, BPFO + 10) < 0.01  # nothing at BPFO itself


@pytest.mark.parametrize("resonance", [0.0, 1e-6, 120.0, 60_000.0])
def test_no_envelope_where_the_record_cannot_show_one(resonance):
    assert envelope(noise(0.06), STEP, resonance) is None


def test_report_holds_term_spectra_and_warns_of_unresolved_lines(tmp_path, capsys):
    path = write_result(tmp_path / "a.nc", make_run(n_times=3001))
    assert main([str(path), "--line", "22", "--line", "BPFO"]) == 0
    out, err = capsys.readouterr()
    assert "22 Hz can't be resolved" in err and "BPFO can't" not in err
    assert "22 Hz:" in out and "BPFO (381.5 Hz):" in out
    with h5py.File(tmp_path / "a-residual" / "residual.nc") as file:
        df = file["frequency"][1]
        term, psd = file["budget_y_contact_law"][:], file["psd_y_contact_law"][:]
        window = np.hanning(term.size + 1)[:-1]
        weighted = np.sum((window * (term - term.mean())) ** 2) / np.sum(window**2)
        assert np.sum(psd) * df == pytest.approx(weighted, rel=0.05)
        assert file["envelope_psd_x"].dims[0][0] == file["frequency"]
    assert {"envelope.png", "short_time.png"} <= {p.name for p in (tmp_path / "a-residual").iterdir()}


@pytest.mark.parametrize("speed", ["1e-310", "1e-12", "1e-4", "1e-2"])
def test_a_bearing_that_as_good_as_stands_is_reported_on(speed, tmp_path):
    path = tmp_path / "slow.nc"
    slow = ["--set", f"operation.speed_rpm={speed}", "--duration", "0.6", "--quiet", "--output", str(path)]
    assert run_main(["--model", "lagrange", *slow]) == 0
    assert main([str(path), "--no-figures", "--quiet"]) == 0
    assert main([str(path), "--no-figures", "--quiet", "--line", "1e-320"]) == 2


def test_an_unknown_line_exits_2(tmp_path, capsys):
    path = write_result(tmp_path / "a.nc", make_run(n_times=401))
    assert main([str(path), "--line", "BPFX"]) == 2
    assert "--line BPFX" in capsys.readouterr().err
