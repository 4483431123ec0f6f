"""The hub's vibration: levels and envelope lines of signals whose answer is known, and of a bearing with a spall."""

import re
from functools import cache

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.interface import check_quantities
from lagrange.errors import InputError
from lagrange.scene.scene import parse_scene
from residual.check_vibration import main as check_vibration
from residual.evaluation import evaluate
from residual.figures import save
from residual.figures.spectra import envelope
from residual.findings import vibration_sentences
from residual.sources import read_result
from residual.spectrum import find_peaks
from residual.vibration import fault_lines, vibration
from tests.reference.kit import read_json, sets
from tests.reference.synthetic_run import make_run, paper_lines, report_of, run_variables, write_result

STEP = 1e-5
TIME = STEP * np.arange(30_000)
LOWERED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")
CARRIER = 12_345.0  # Hz


def tone(frequency, amplitude=1.0):
    return amplitude * np.cos(2.0 * np.pi * frequency * TIME + 0.7)


def noise(size):
    return size * np.random.default_rng(3).standard_normal(TIME.size)


def by_name(found):
    return {line.name: line for line in found.lines}


def judged(record, lines=None, step=STEP, **keywords):
    return vibration(record, step, paper_lines() if lines is None else lines, **keywords)


def test_levels_of_sines_of_noise_and_of_silence_and_of_their_bands():
    """A sine's kurtosis is 1.5 and its crest factor √2, that of Gaussian noise 3, in whose envelope no line stands."""
    level = judged(tone(CARRIER, 7.0) + 9.81).level
    found = (level.kurtosis, level.crest, level.peak, level.rms)
    assert found == pytest.approx((1.5, np.sqrt(2.0), 7.0, 7.0 / np.sqrt(2.0)), rel=1e-3)
    random = judged(noise(5.0))
    assert random.level.kurtosis == pytest.approx(3.0, abs=4.0 * np.sqrt(24.0 / TIME.size))
    assert not any(line.stands_out for line in random.lines)
    still = judged(np.zeros(1000)).level
    assert (still.kurtosis, still.crest, still.rms) == (None, None, 0.0)
    fast = judged(tone(100.0, 3.0) + tone(5000.0, 40.0))
    assert fast.velocity == pytest.approx(3.0 / np.sqrt(2.0) / (2.0 * np.pi * 100.0), rel=2e-3)
    assert judged(tone(100.0)[:6000]).velocity is None  # 60 ms
    # Parseval: the rms of sines in one band add up as squares
    record = sum(tone(f, a) for f, a in ((300, 1.0), (2000, 2.0), (4500, 3.0), (15_000, 4.0), (30_000, 0.5)))
    bands = judged(record).bands
    np.testing.assert_allclose(list(bands), [(0.0, 1e3), (1e3, 5e3), (5e3, 20e3), (20e3, 50e3)], rtol=1e-12)
    expected = np.sqrt(0.5 * np.array([1.0, 13.0, 16.0, 0.25]))
    np.testing.assert_allclose([level.rms for level in bands.values()], expected, rtol=2e-3)
    # kurtosis of sines of incommensurate frequencies: 3 - 1.5 Σ a⁴ / (Σ a²)²
    two = 3.0 - 1.5 * (2.0**4 + 3.0**4) / 13.0**2
    np.testing.assert_allclose([level.kurtosis for level in bands.values()], [1.5, two, 1.5, 1.5], rtol=5e-3)
    crests = [level.crest for level in bands.values()]
    np.testing.assert_allclose(crests, [2**0.5, 5 / 6.5**0.5, 2**0.5, 2**0.5], rtol=0.03)
    short = judged(tone(50.0), step=4.0 * STEP).bands
    np.testing.assert_allclose(list(short), [(0.0, 1e3), (1e3, 5e3), (5e3, 12.5e3)], rtol=1e-12)


def test_a_chosen_band_is_demodulated_alone():
    """Two carriers swell at different lines: each band has its own."""
    lines = paper_lines()
    low = (1.0 + 0.4 * tone(lines["BPFO"])) * tone(6000.0)
    high = (1.0 + 0.2 * tone(lines["BPFI"])) * tone(20_000.0)
    record = low + high + noise(1e-3)
    in_low = by_name(judged(record, band=(4e3, 8e3)))
    in_high = by_name(judged(record, band=(18e3, 22e3)))
    assert in_low["BPFO"].amplitude == pytest.approx(0.4, rel=0.01) and in_low["BPFI"].amplitude < 2e-3
    assert in_high["BPFI"].amplitude == pytest.approx(0.2, rel=0.01) and in_high["BPFO"].amplitude < 2e-3
    for band in ((1e3, 60e3), (10.0, 10.1)):
        with pytest.raises(InputError, match="no envelope of this record"):
            judged(record, band=band)


SIDES = {"BPFO": (), "BPFI": ("BPFI−shaft", "BPFI+shaft"), "2×BSF": ("2×BSF−FTF", "2×BSF+FTF")}


@pytest.mark.parametrize("name", SIDES)
def test_lines_of_a_modulated_resonance_have_the_modulations_amplitudes(name):
    """Of A (1 + Σ m cos) cos the envelope is A (1 + Σ m cos): lines of A m, here half of it at sidebands."""
    wanted, sides = fault_lines(paper_lines()), SIDES[name]
    swell = 1.0 + 0.3 * tone(wanted[name]) + sum(0.15 * tone(wanted[side]) for side in sides)
    found = judged(40.0 * swell * tone(CARRIER) + noise(0.1))
    levels = by_name(found)
    assert levels[name].amplitude == pytest.approx(12.0, rel=0.01)
    for side in sides:
        assert levels[side].amplitude == pytest.approx(6.0, rel=0.01)
    assert {line.name for line in found.lines if line.stands_out} == {name, *sides}
    assert find_peaks(found.envelope.spectrum, wanted)[0].line == name


def test_a_comb_of_the_cage_is_floor_and_short_or_coarse_records_and_standing_bearings_tell_no_lines():
    """Where everything repeats with the cage's revolution, BPFO is one tooth among others. In 60 ms the main lobe of
    BPFO reaches 2×BSF+FTF, 24 Hz below, 10 ms have bins of 100 Hz; at 200 µs the band from 3 BPFI ends within 500 Hz.
    """
    lines = paper_lines()
    comb = 1.0 + sum(0.03 * tone(k * lines["FTF"]) for k in range(1, 45))
    record = comb * tone(CARRIER) + noise(1e-3)
    assert not by_name(judged(record))["BPFO"].stands_out
    bpfo = by_name(judged(record + 0.2 * tone(lines["BPFO"]) * tone(CARRIER)))["BPFO"]
    assert bpfo.stands_out and bpfo.floor == pytest.approx(0.03, rel=0.05)
    record = (1.0 + 0.5 * tone(lines["BPFO"])) * tone(CARRIER) + noise(0.01)
    line = by_name(judged(record[:6000]))["2×BSF+FTF"]
    assert not line.resolved and not line.stands_out and judged(noise(1.0), step=20.0 * STEP).envelope is None
    told = [any(line.resolved for line in judged(noise(1.0)[:n]).lines) for n in (1000, 6000)]
    assert told == [False, True]
    standing = judged(noise(1.0), {})
    assert standing.envelope is None and standing.lines == []


# settings of runs; their ms, longer where the spall strikes less often: of 300 ms of a spalled roller or inner ring one
# path in four to six has a foreign line four times above its floor, of these lengths none twice; family of lines that
# stand out, some of them, and what is told
WIDE = "spall.0.width_mm=0.5"
RUNS = {
    "healthy": ((), 150, "none", "", "surfaces are perfect circles."),
    "outer": ((WIDE,), 150, "BPFO", "BPFO 2×BPFO 3×BPFO", "a spall 0.5 mm wide on the outer ring"),
    "inner": ((WIDE, "spall.0.body=inner_ring"), 600, "BPFI", "BPFI−shaft BPFI BPFI+shaft",
              "Expected of such faults: BPFI ± shaft"),
    "roller": ((WIDE, "spall.0.body=roller", "spall.0.roller=0"), 900, "2×BSF", "2×BSF",
               "a spall 0.5 mm wide on roller 0"),
}  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Path of a run of the reduced model by its name, healthy or spalled; it is made when it is first asked for."""
    folder = tmp_path_factory.mktemp("vibration")

    @cache
    def made(name):
        (settings, duration, *_), path = RUNS[name], folder / f"{name}.nc"
        options = sets("model=reduced", "numerics.output_interval_us=10", *settings)
        assert run_main([*options, "--duration", str(duration), "--output", str(path), "--quiet"]) == 0
        return path

    return made


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_a_spall_shows_at_its_own_lines_and_a_perfect_bearing_at_none(runs, name):
    evaluation, (_, _, family, expected, told) = evaluate(read_result(runs(name))), RUNS[name]
    found = {line.name for d in evaluation.directions for line in d.vibration.lines if line.stands_out}
    assert {*expected.split()} <= found and all(family in line for line in found)
    sentence = vibration_sentences(evaluation)[0]
    assert told in sentence and (name != "healthy" or " damaged." not in sentence)


def test_a_line_that_is_there_is_told_with_what_it_may_be(runs):
    """BPFO lies 23.3 Hz from 2×BSF + FTF, two bins of 86 ms; the last 50 ms can't tell them apart."""
    whole, short = (vibration_sentences(evaluate(read_result(runs("outer")), start=start))[1] for start in (0.0, 0.1))
    assert re.search(r"BPFO at [\d.]+ Hz, [\d.]+ times in y[;.]", whole)
    needed = re.search(r"BPFO at [\d.]+ Hz, [\d.]+ times in y \(it may be 2×BSF\+FTF: a record of ([\d.]+) ms", short)
    pitch, roller, shaft = 46.0, 10.0, 75.0  # mm, Hz (Harris, Rolling Bearing Analysis, 2001, ch. 8)
    cage = 0.5 * shaft * (1.0 - roller / pitch)
    spin = 0.5 * shaft * pitch / roller * (1.0 - (roller / pitch) ** 2)
    assert float(needed[1]) == pytest.approx(2e3 / (13 * cage - 2.0 * spin - cage), rel=0.1)  # slips a little


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("name", ["healthy", "outer"])
def test_check_residual_and_check_vibration_give_one_verdict_on_a_run(runs, name, tmp_path):
    here, page = report_of(runs(name), tmp_path / "a", "--quiet")
    assert check_vibration([str(runs(name)), "--quiet", "--no-figures", "--output", str(tmp_path / "b")]) == 0
    there = read_json(tmp_path / "b" / "summary.json")
    assert here["diagnosis"] == {key: there[key] for key in ("verdict", "reasons")}
    assert "Verdict of check-vibration on the hub" in page and '<h2 id="vibration">' in page
    assert RUNS[name][-1] in page


def test_a_spall_against_the_healthy_bearing_is_told_in_decibels_and_the_figure_names_its_band(runs, tmp_path, capsys):
    """From 3 BPFI at the run's own cage speed, 1.78 kHz, to 0.9 of 50 kHz."""
    options = "--against", runs("healthy"), "--no-equations", "--no-figures"
    _, page = report_of(runs("outer"), tmp_path / "report", *options)
    row = re.search(r"<td>BPFO, g, y</td>\s*<td>(\S+)</td>\s*<td>(\S+)</td>\s*<td>\+([\d.]+)</td>", page)
    found = [float(number.replace("·10⁻", "e-").translate(LOWERED)) for number in row.groups()]
    assert found[2] == pytest.approx(20.0 * np.log10(found[0] / found[1]), abs=0.1) and found[2] > 40.0
    assert "difference, dB" in capsys.readouterr().out
    drawn = envelope(evaluate(read_result(runs("outer"))))
    assert "within 1.78 to 45 kHz: in y over 5 roller passages" in drawn.caption
    save(drawn, tmp_path)
    assert (tmp_path / f"{drawn.name}.png").stat().st_size > 10_000


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("sensor", [{"sensor": {}}, {}])
def test_vibration_is_the_sensors_or_the_housings_in_g_too_and_studies_take_its_envelope(sensor, tmp_path):
    """A carrier of 2 g in 15 kHz, half modulated by BPFO: 1 g at BPFO of the envelope, crest factor 2."""
    run, size = make_run(20_001, scene=parse_scene({"support": {"kind": "housing"}, **sensor}, "")), 2.0 * 9.80665
    passing = run.scene.bearing.rollers * np.polyfit(run.time, run.angle[:, 0], 1)[0]
    made = size * (1.0 + 0.5 * np.cos(passing * run.time)) * np.cos(2.0 * np.pi * 15e3 * run.time)
    still, variables = np.zeros(run.time.size), run_variables(run)
    variables |= dict.fromkeys(("housing_x", "housing_y", "housing_ax", "housing_ay", "energy_support"), still)
    variables |= {"sensor_ay" if sensor else "housing_ay": made}
    path, body = write_result(tmp_path / "made.nc", run, variables), "sensor" if sensor else "housing"
    summary, page = report_of(path, tmp_path / "out", "--quiet")
    found = summary["vibration_y"]
    assert f'<h2 id="vibration">Vibration of the {body}</h2>' in page and f"<th>{body}, y, g</th>" in page
    assert found["crest_factor"] == pytest.approx(found["peak_m_s2"] / found["rms_m_s2"], rel=1e-12)
    assert found["body"] == body and found["rms_m_s2"] == pytest.approx(made.std(), rel=1e-9)
    kept = {each.name: each.value for each in check_quantities(evaluate(read_result(path)))}
    assert kept["sensor_rms"] == found["rms_m_s2"] and kept["sensor_crest"] == pytest.approx(2.0, rel=1e-2)
    assert kept["sensor_bpfo"] == pytest.approx(0.5 * size, rel=0.01) and kept["sensor_bpfi"] < 0.01 * size
    assert kept["sensor_kurtosis"] == found["kurtosis"]
