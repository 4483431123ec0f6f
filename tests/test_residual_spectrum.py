"""Spectra: amplitude, Parseval, peaks, names, resolution."""

import re
from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.signal import peak_prominences, welch

from fem.commands.run_fem import run_main
from fem.runner import RunOptions, run_scene
from lagrange.errors import InputError
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene, read_scene
from residual.cli import main
from residual.evaluation import evaluate
from residual.figures import save
from residual.figures.run import passages
from residual.sources import read_result
from residual.spectrum import averaged, band_envelope, find_peaks, kinematic_lines, maxima, power_spectrum, prominence
from residual.vibration import line_levels, named_peaks, sidebands, watched_level
from tests.reference.synthetic_run import harris_force, make_run, paper_lines, recorded, run_variables, write_result

STEP = 1e-5
BPFO = 381.52  # Hz
SHAFT, CAGE = 75.0, 29.348


def tones(duration, *lines, noise=0.01, seed=1):
    """A record of tones, Hz and amplitude, in noise of an rms."""
    t = STEP * np.arange(round(duration / STEP))
    found = noise * np.random.default_rng(seed).standard_normal(t.size)
    return sum((a * np.cos(2.0 * np.pi * f * t + 0.3) for f, a in lines), found)


def spectrum_of(*arguments, **keywords):
    return power_spectrum(tones(*arguments, **keywords), STEP)


def levels_of(spectrum):
    return {level.name: level for level in line_levels(spectrum, paper_lines())}


def test_density_is_of_the_variance_in_a_band_and_of_white_noise():
    """Exactly so for a record whose lines lie on bins; a density off by the usual factor 2 fails."""
    record = 3.0 + tones(0.1, (400, 5.0), (1230, 2.0), (20e3, 1.0), noise=0.0)
    spectrum = power_spectrum(record, STEP)
    assert np.sum(spectrum.psd) * spectrum.resolution == pytest.approx(np.var(record), rel=1e-9)
    spectrum = spectrum_of(0.06, (500, 3.0), (4000, 8.0))
    for middle, amplitude in ((500, 3.0), (4000, 8.0)):
        assert spectrum.band_rms(middle - 200, middle + 200) == pytest.approx(amplitude / np.sqrt(2), rel=5e-3)
    long = power_spectrum(tones(4.0, (381.5, 10.0)), STEP, slowest_line=29.35)  # averaged
    assert long.segments > 1 and long.resolution == pytest.approx(29.35 / 40, rel=1e-3)
    assert find_peaks(long, paper_lines())[0].rms == pytest.approx(10 / np.sqrt(2), rel=5e-3)
    white = spectrum_of(1.3, noise=1.0)
    assert np.mean(white.psd[1:-1]) == pytest.approx(2.0 * STEP, rel=0.02)
    assert np.median(white.smooth_background) == pytest.approx(2.0 * STEP, rel=0.1)


@pytest.mark.parametrize("count", [256, 777])
def test_averaged_density_and_prominences_are_those_of_scipy(count):
    record = tones(0.05, (500, 3.0), noise=1.0)
    frequency, psd = welch(record, 1.0 / STEP, "hann", count, nfft=2 * count)
    found = averaged([record], STEP, count, 2)
    assert found.psd == pytest.approx(psd, rel=1e-9) and found.frequency == pytest.approx(frequency)
    assert found.segments == 1 + (record.size - count) // (count - count // 2)
    at = maxima(psd)
    assert [prominence(psd, i) for i in at] == pytest.approx(peak_prominences(psd, at)[0], rel=1e-9)


def test_paper_bearing_lines():
    expected = {"shaft": 75.0, "FTF": 29.35, "BSF": 164.35, "BPFO": 381.5, "BPFI": 593.5, "2×BPFO": 763.04}
    assert {name: paper_lines()[name] for name in expected} == pytest.approx(expected, abs=0.03)
    found = sidebands(paper_lines())
    assert found["BPFO−shaft"] == pytest.approx(BPFO - SHAFT, abs=0.05)
    assert found["2×BPFO+FTF"] == pytest.approx(2 * BPFO + CAGE, abs=0.1)
    assert kinematic_lines(kinematics(Scene().ideal_bearing(), 0.0)) == {}


@pytest.mark.parametrize(("frequency", "duration", "line", "resolved"), [
    (381.5, 0.06, "BPFO", True), (593.5, 0.06, "BPFI", True), (763.0, 0.06, "2×BPFO", True),
    (22.0, 0.06, "FTF", False),  # Δf = 16.7 Hz: 1.3 bins from zero frequency, 7 Hz from the cage
    (29.35, 0.06, "FTF", False),  # still within two bins of zero frequency
    (22.0, 1.0, None, True),  # a longer record parts it from both
    (157.0, 0.06, "2×shaft", False),  # half-way between 2×shaft and BSF
    (75.0, 0.06, "shaft", True), (500.0, 0.06, None, True), (1000.0, 0.06, None, True), (7321.7, 0.06, None, True),
])  # fmt: skip
def test_peak_names_and_resolution(frequency, duration, line, resolved):
    peak = find_peaks(spectrum_of(duration, (frequency, 10.0)), paper_lines())[0]
    assert (peak.line, peak.resolved) == (line, resolved)
    if duration * frequency > 20.0:  # bins: an isolated line
        assert peak.frequency == pytest.approx(frequency, rel=1e-3)
        assert peak.rms == pytest.approx(10.0 / np.sqrt(2), rel=5e-3)


def test_noise_hardly_shows_peaks_or_lines_silence_none_and_a_weak_tone_stands_out_of_coloured_noise():
    spectra = [spectrum_of(0.06, noise=1.0, seed=seed) for seed in range(40)]
    assert sum(len(find_peaks(spectrum, {})) for spectrum in spectra) <= 8  # one in ten spectra or so
    levels = [level for seed in range(30) for level in levels_of(spectrum_of(0.2, seed=seed)).values()]
    assert len(levels) > 600 and sum(level.stands_out for level in levels) <= 0.01 * len(levels)
    assert find_peaks(power_spectrum(np.zeros(100), STEP), paper_lines()) == []
    noise = np.cumsum(np.random.default_rng(2).standard_normal(6001)) * 0.02
    peaks = find_peaks(power_spectrum(noise + tones(0.06001, (5000, 0.1), noise=0.0), STEP), {})
    assert any(p.frequency == pytest.approx(5000, abs=2.0) for p in peaks)


# Levels of lines, sidebands, envelope: the right newtons under the right name, and silence where nothing is known
def modulated(duration, modulator):
    """A tone at BPFO of 10 N amplitude whose amplitude swells by 0.4 at the modulator's frequency."""
    swell = 1.0 + tones(duration, (modulator, 0.4), noise=0.0)
    return power_spectrum(swell * tones(duration, (BPFO, 10.0), noise=0.0) + tones(duration), STEP)


def test_a_level_is_the_lines_rms_in_any_record_and_sidebands_carry_half_the_modulation_where_it_resolves_them():
    for duration in (0.06, 0.6):
        level = levels_of(spectrum_of(duration, (BPFO, 7.0)))["BPFO"]
        assert level.rms == pytest.approx(7.0 / np.sqrt(2), rel=0.02)
        assert level.stands_out and level.background < 0.1 * level.rms
    levels = levels_of(modulated(0.6, CAGE))
    for name in ("BPFO−FTF", "BPFO+FTF"):
        assert levels[name].rms == pytest.approx(10.0 * 0.4 / 2 / np.sqrt(2), rel=0.02)
        assert levels[name].stands_out and levels[name].resolved
    assert not levels["BPFO+shaft"].stands_out
    short = levels_of(modulated(0.06, CAGE))
    assert "BPFO+FTF" not in short and "BPFO+shaft" in short
    lines, spectrum = paper_lines(), modulated(0.6, SHAFT)
    peaks = named_peaks(find_peaks(spectrum, lines), spectrum, lines, 13e3, 0.0)
    assert {"BPFO", "BPFO−shaft", "BPFO+shaft"} <= {peak.line for peak in peaks}


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


def test_lines_go_by_the_cage_speed_of_the_run(tmp_path):
    """A cage that creeps by 2 %: BPFO and BPFI move with it, and the peak at the run's own BPFO keeps its name."""
    slow = 0.98 * CAGE
    evaluation = evaluate(recorded(tmp_path / "a.nc", make_run(n_times=20_001, creep=0.98)))
    assert evaluation.lines["FTF"] == pytest.approx(slow, rel=1e-3)
    assert evaluation.ideal_cage == pytest.approx(CAGE, rel=1e-4)
    assert evaluation.lines["BPFI"] == pytest.approx(13 * (SHAFT - slow), rel=1e-3)
    assert any(peak.line == "BPFO" and abs(peak.frequency - 13 * slow) < 0.5 for peak in evaluation.x.peaks)


def test_a_line_can_be_asked_for_by_name_or_frequency_with_the_record_that_it_needs_and_an_unknown_one_is_refused():
    wanted = {"BPFO-shaft": 306.5, "bpfo−shaft": 306.5, "2xBPFO": 763.0, "2×BPFO": 763.0, "22": 22.0, "381.5": 381.5}
    found = {name: watched_level(spectrum_of(0.6), name, paper_lines()).frequency for name in wanted}
    assert found == pytest.approx(wanted, abs=0.1)
    for unknown in ("BPFX", "-5", "0", "1e9", "nan", "", "1e-320"):
        with pytest.raises(InputError):
            watched_level(spectrum_of(0.06), unknown, paper_lines())
            pytest.fail(unknown)
    # the record said to be needed is enough and a shorter one is not
    lines = paper_lines()
    short = watched_level(spectrum_of(0.06), "22", lines)
    assert not short.resolved and short.record_needed == pytest.approx(2.0 / (CAGE - 22.0), rel=1e-3)
    for factor, resolved in ((1.02, True), (0.98, False)):
        spectrum = spectrum_of(factor * short.record_needed)
        assert watched_level(spectrum, "22", lines).resolved == resolved


def test_envelope_shows_what_modulates_the_resonance():
    swell, carrier = (tones(0.3, each, noise=0.0) for each in ((BPFO, 1.0), (13_000, 1.0)))
    record = (2.0 + swell) * carrier + tones(0.3)
    found = band_envelope(record, STEP, 9200.0, 18_400.0)
    assert found.rms == pytest.approx(np.sqrt(2.0 + 0.25), rel=0.01)
    assert np.mean(found.level) == pytest.approx(2.0, rel=0.01)
    peak = find_peaks(found.spectrum, paper_lines())[0]
    assert peak.line == "BPFO" and peak.rms == pytest.approx(1.0 / np.sqrt(2), rel=0.02)
    plain = power_spectrum(record, STEP)
    assert plain.band_rms(BPFO - 10, BPFO + 10) < 0.01  # nothing at BPFO itself
    for low, high in ((0.0, 1e3), (100.0, 150.0), (46_000.0, 6e4)):
        assert band_envelope(tones(0.06), STEP, low, high) is None, low


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
        assert file["hub_envelope_psd_x"].dims[0][0] == file["frequency"]


@pytest.mark.parametrize("speed", ["1e-14", "1e-12", "1e-4", "1e-2"])
def test_a_bearing_that_as_good_as_stands_is_reported_on(speed, tmp_path, capsys):
    path = tmp_path / "slow.nc"
    slow = ["--set", f"operation.speed_rpm={speed}", "--duration", "0.6", "--quiet", "--output", str(path)]
    assert run_main(["--model", "lagrange", *slow]) == 0 and main([str(path), "--no-figures", "--quiet"]) == 0
    assert main([str(path), "--no-figures", "--quiet", "--line", "1e-320"]) == 2
    assert "--line 1e-320" in capsys.readouterr().err


SETTINGS = ("model=lagrange", "numerics.duration_ms=0.45", "numerics.output_interval_us=2", "spall.0.width_mm=0.5")


def test_the_figure_tells_the_strikes_of_the_result_file_and_without_spalls_or_forces_there_is_none(tmp_path):
    """One roller passes a spall in the load zone, none another one."""
    path = tmp_path / "run.nc"
    scene = read_scene(None, (*SETTINGS, "spall.0.angle_deg=2", "spall.1.angle_deg=180.0"))
    run_scene(scene, path, RunOptions(quiet=True))
    evaluation = evaluate(read_result(path))
    figures = list(passages(evaluation))
    assert [figure.name for figure in figures] == ["passages_0"]
    caption = figures[0].caption
    force, share = re.search(r"medians are (\d+) N and (0\.\d+) of the crossing", caption).groups()
    with h5py.File(path) as file:
        events = {name: file["events"][name][:] for name in ("kind", "spall", "force", "time")}
    kinds = {kind: (events["kind"] == kind) & (events["spall"] == 0) for kind in (b"entry", b"strike", b"exit")}
    assert kinds[b"strike"].sum() == 1
    entry, strike, leaving = (events["time"][kinds[kind]] for kind in kinds)
    assert float(force) == pytest.approx(np.median(events["force"][kinds[b"strike"]]), abs=0.51)
    assert float(share) == pytest.approx(np.median((strike - entry) / (leaving - entry)), abs=0.01)
    assert "0.5 mm wide spall on the outer ring" in caption and "0.512° away" in caption
    save(figures[0], tmp_path)
    assert (tmp_path / "passages_0.png").stat().st_size > 10_000 and (tmp_path / "passages_0.svg").exists()
    for without in ({"scene": read_scene(None, SETTINGS[:3])}, {"inner_force": None}):
        assert list(passages(replace(evaluation, record=replace(evaluation.record, **without)))) == []
