"""The command check-vibration, one record, two or a series; verdicts, depths and widths where the truth is known."""

import sys
from collections import Counter
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import fftconvolve
from scipy.stats import exponnorm

from residual.check_vibration import main
from residual.measured import checks
from residual.measured.checks import growth
from residual.measured.diagnosis import BODIES, Geometry, Prewhitened, diagnose, envelope_spectrum
from residual.measured.judged import damage_width, mean_pulse
from residual.measured.signals import Signal
from residual.spectrum import power_spectrum
from residual.vibration import velocity_level
from tests.reference.kit import read_json
from tests.reference.synthetic_record import drawn, synthetic_record

NU206 = ("--bearing", "NU206", "--speed", "1480")
SHAFT = 1480.0 / 60.0  # Hz
GEOMETRY = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3)  # as NU206's in the catalogue
CONTRACT = "verdict lines width_mm width_interval_mm width_reason speed_rpm".split()
OF_LINES = "name expected_Hz found_Hz level p depth".split()
MOTOR = """model = "lagrange"
support = { kind = "housing", stiffness_N_per_m = 3e7 }
spall = [{ body = "outer_ring", width_mm = 1.0 }]
bearing.designation = "NU206"\noperation.radial_load_N = 500.0
damping.contact_time_us = 12.5\nsensor.frequency_Hz = 4000.0"""


def made(path, fault="BPFO", strength=1.0, seed=4, **keywords):
    """A record of NU206 as a file, and its truth."""
    keywords = {"duration": 1.0} | keywords
    truth = synthetic_record(np.random.default_rng(seed), GEOMETRY, SHAFT, fault, strength, **keywords)
    np.savez(path, acc=truth.signal.values, rate=truth.signal.rate)
    return truth


def summary_of(path, *options, folder=None):
    """What the command writes on a record."""
    folder = folder or path.with_name(f"{path.stem}-vibration")
    assert main([str(path), *options, "--output", str(folder), "--quiet"]) == 0
    return read_json(folder / "summary.json")


def test_a_damaged_record_against_a_healthy_one(tmp_path):
    """What summary.json promises; the page has the verdict first and fetches nothing."""
    truth, _ = made(tmp_path / "today.npz"), made(tmp_path / "healthy.npz", None, 0.0)
    folder, against = tmp_path / "report", str(tmp_path / "healthy.npz")
    summary = summary_of(tmp_path / "today.npz", *NU206, "--unit", "g", "--against", against, folder=folder)
    assert set(summary) >= {*CONTRACT} and all(set(line) == {*OF_LINES} for line in summary["lines"])
    first = summary["lines"][0]
    assert (summary["verdict"], first["name"], summary["against"]["verdict"]) == ("outer_ring", "BPFO", "none")
    assert first["expected_Hz"] == pytest.approx(GEOMETRY.lines(SHAFT)["BPFO"], rel=2e-4)
    assert first["found_Hz"] == pytest.approx(truth.line, rel=3e-3)
    assert summary["speed_rpm"] == pytest.approx(1480.0, rel=0.012)
    values = 9.80665 * truth.signal.values
    assert summary["rms_m_s2"] == pytest.approx(float(np.std(values)), rel=1e-9)
    spectrum = power_spectrum(values, 1.0 / truth.signal.rate, summary["kinematic_lines_Hz"]["FTF"])
    assert summary["velocity_mm_s"] == pytest.approx(1e3 * velocity_level(spectrum), rel=1e-9), "as of a run"
    assert summary["width_mm"] is None and summary["width_reason"]
    assert set(summary["files"]) == {path.name for path in folder.iterdir()}
    page = (folder / "vibration.html").read_text(encoding="utf-8")
    body = page[page.index("<body>") :]
    assert body.index("The outer ring is damaged.") < body.index("Evidence") < body.index("Comparison")
    assert body.count("data:image/") == 3 and "http" not in body.replace("http://www.w3.org", "")


def test_a_damaged_record_does_not_pass_as_sound_by_its_missing_samples_or_marks_of_thousands(tmp_path, capsys):
    """Of 30 % of its lines, in silence, and of 25,600 Hz read as 25.6."""
    truth, path = made(tmp_path / "record.npz"), tmp_path / "record.csv"
    lines, rate = [f"{x:.5f}" for x in truth.signal.values], round(truth.signal.rate)
    given = [str(path), *NU206, "--unit", "g", "--no-figures"]
    there = np.random.default_rng(5).random(len(lines)) > 0.3
    gaps = [x if shown else "#N/A" for x, shown in zip(lines, there, strict=True)]
    for head, values, more, code, words in (
        (f"{rate:,}", lines, (), 0, "The outer ring is damaged"),
        ("25,6", lines, ("--rate", str(rate)), 0, f"The file says 25.6 Hz; --rate {rate} Hz was taken"),
        (str(rate), gaps, (), 2, "samples without a number (the first: line"),
    ):
        path.write_text("\n".join([f"Sampling rate: {head} Hz", *values]), encoding="utf-8")
        assert main([*given, *more]) == code
        told = "".join(capsys.readouterr())
        assert words in told and ("The outer ring is damaged" in told) == (code == 0)


def test_verdict_is_printed_first_whatever_says_which_bearing_it_is(tmp_path, capsys):
    for fault, verdict in {None: "none", **dict(reversed(BODIES.items()))}.items():
        made(tmp_path / "record.npz", fault, 1.0 if fault else 0.0)
        assert main([str(tmp_path / "record.npz"), *NU206, "--no-figures"]) == 0
        told = capsys.readouterr().out
        assert told.startswith(f"Verdict: {verdict}. ")
        assert f"Page: {tmp_path / 'record-vibration' / 'vibration.html'}" in told
    assert main([str(tmp_path / "record.npz"), *NU206, "--unit", "mm/s", "--no-figures"]) == 0
    assert " mm/s rms, crest factor" in capsys.readouterr().out
    # sizes or a scene do as well as a bearing's name
    scene = tmp_path / "motor.toml"
    scene.write_text('bearing.designation = "NU206"\noperation.speed_rpm = -1480.0\n', encoding="utf-8")
    sizes = ("--elements", "13", "--element-diameter", "9", "--pitch-diameter", "46.5", "--speed", "1480")
    found = [summary_of(tmp_path / "record.npz", *o, "--no-figures") for o in (NU206, sizes, ("--scene", str(scene)))]
    assert {each["verdict"] for each in found} == {"outer_ring"}
    lines = [each["lines"][0]["found_Hz"] for each in found]
    assert lines == pytest.approx(lines[:1] * 3, rel=2e-3)


ON = " ".join(NU206)
REFUSED = {  # words, and the options with which they are told
    "the bearing is missing": "--speed 1480", "the speed is missing": "--bearing NU206",
    "leave all but one out": "--bearing NU206 --elements 9 --speed 1", "go together": "--elements 9 --speed 1480",
    "not in the table": "--bearing NU9 --speed 1480", "in rpm, not in Hz": "--bearing NU206 --speed 1",
    "no bearing": "--elements 9 --element-diameter 50 --pitch-diameter 40 --speed 1",
    "must be a number of per cent": f"{ON} --speed-tolerance much", "from 0 to 10%": f"{ON} --speed-tolerance 50%",
    "--speed 0": "--bearing NU206 --speed 0", "passes": "--bearing NU206 --speed 150",
    "sampled at": "--bearing NU206 --speed 150000", "scene.toml: no such file": f"{ON} --against scene.toml",
    "at one steady speed": f"{ON} --against table.toml", "No such file": f"{ON} --against none.csv",
    "motor.toml: run-fem: no equilibrium\n": f"{ON} --against motor.toml",
    "no report of check-vibration": f"{ON} --output mine",
}  # fmt: skip


@pytest.mark.parametrize("words", REFUSED)
def test_unusable_input_is_refused_in_one_line(words, tmp_path, monkeypatch, capsys):
    """A scene that run-fem refuses in its words."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(checks, "RUN_FEM", (sys.executable, "-c", "raise SystemExit('error: no equilibrium')"))
    made(tmp_path / "record.npz")
    Path("table.toml").write_text('operation.speed_table = "speeds.csv"\n')
    Path("speeds.csv").write_text("time_ms,speed_rpm\n0,1000\n100,2000\n")
    Path("motor.toml").write_text(MOTOR)
    Path("mine").mkdir()
    Path("mine/letter.txt").write_text("dear", encoding="utf-8")
    assert main(["record.npz", *REFUSED[words].split()]) == 2
    told = capsys.readouterr().err
    assert words in told and told.startswith("error: ") and told.count("\n") == 1
    assert not (tmp_path / "record-vibration").exists()
    assert [path.name for path in Path("mine").iterdir()] == ["letter.txt"]
    assert main([".", *NU206]) == 2 and "is a folder" in capsys.readouterr().err


@pytest.mark.slow  # compiles a loop; the page on measured records runs the command
def test_scene_is_simulated_at_the_record_s_speed_and_rate(tmp_path):
    made(tmp_path / "record.npz", seed=5, duration=0.2, rate=10_240.0)
    (tmp_path / "motor.toml").write_text(MOTOR, encoding="utf-8")
    given = ("--speed", "1480", "--against", str(tmp_path / "motor.toml"), "--no-figures")
    beside = summary_of(tmp_path / "record.npz", *given)["against"]  # the bearing is the scene's
    assert beside["seconds"] == pytest.approx(0.2, rel=1e-2) and beside["rate_Hz"] == pytest.approx(10_240.0, rel=1e-6)
    first = next(line for line in beside["lines"] if line["name"] == "BPFO")
    assert first["found_Hz"] == pytest.approx(GEOMETRY.lines(SHAFT)["BPFO"], rel=3e-3)  # the cage does not slip
    assumed = {each["key"]: (each["value"], each["given"]) for each in beside["assumed"]}
    assert assumed["support.stiffness_N_per_m"] == (3e7, True) and assumed["support.mass_kg"] == (12.638, False)
    assert assumed["spall.0.width_mm"] == (1.0, True) and "operation.speed_rpm=1480" in beside["command"]


SKF_6205 = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
ZA_2115 = Geometry(elements=16, element_diameter=8.4074e-3, pitch_diameter=71.501e-3, contact_angle=np.radians(15.17))
TURNING, RATE = 29.95, 25_600.0  # Hz


def record(fault, strength=1.0, **keywords):
    return synthetic_record(np.random.default_rng(3), SKF_6205, TURNING, fault, strength, **keywords)


def noise(seed=1, duration=2.0):
    return np.random.default_rng(seed).standard_normal(int(duration * RATE))


def time_of(duration=2.0):
    return np.arange(int(duration * RATE)) / RATE


def made_signal(values):
    return Signal(name="made", values=values, rate=RATE, unit="")


def judged(values, geometry=SKF_6205, shaft=TURNING, *tolerance):
    return diagnose(made_signal(values), geometry, shaft, *tolerance)


def test_lines_are_those_of_catalogues():
    """Multiples of the shaft's frequency that CWRU's Bearing Data Center gives for the drive end, SKF 6205.

    Rexnord ZA-2115 at 2000 rpm: 236.4 Hz as the IMS data set's readers give.
    """
    known, lines = {"BPFO": 3.5848, "BPFI": 5.4152, "2×BSF": 4.7135, "FTF": 0.39828}, SKF_6205.lines(1.0)
    assert {name: lines[name] for name in known} == pytest.approx(known, rel=2e-4)
    assert ZA_2115.lines(2000.0 / 60.0)["BPFO"] == pytest.approx(236.4, abs=0.05)


def test_depth_of_noise_is_a_quarter_of_pi_of_that_of_its_power():
    """Noise whose power swells by 1 + d cos: bins that far apart correlate by d/2, their phases alone by π/4 of that.

    Source: the correlation of two complex Gaussian numbers of which only the phases are kept, π/4 ρ (1 + ρ²/8 + ...).
    """
    for depth in (0.3, 0.6):
        values = noise(duration=4.0) * np.sqrt(1.0 + depth * np.cos(2.0 * np.pi * 107.0 * time_of(4.0)))
        spectrum = envelope_spectrum(*Prewhitened.of(made_signal(values)).power(), 40.0, 1000.0)
        assert spectrum.modulation(np.array([107.0]))[0] == pytest.approx(0.25 * np.pi * depth, abs=0.02)


def test_noise_of_few_turns_is_hardly_ever_a_line_and_tones_leave_none():
    """Its own comb is taken out of the spectrum that it is compared with, without making that calmer. Prewhitening
    makes loud tones of one family, as of an inverter, as faint as noise.
    """
    found = [judged(noise(seed, duration=0.25)).verdict for seed in range(30)]
    assert found.count("none") >= 27 and set(found) <= {"none", "uncertain"}
    tones = sum(30.0 * np.cos(2.0 * np.pi * (4000.0 + k * 107.0) * time_of()) for k in range(-5, 6))
    assert judged(noise() + tones).verdict == "none"
    # nor does a verdict depend on the unit, and a faint line is a trace
    values = record("BPFO").signal.values
    once, twice = judged(values), judged(1e4 * values)
    assert (twice.verdict, twice.findings[0].found) == (once.verdict, once.findings[0].found)
    faint = judged(record("BPFO", 0.4).signal.values)
    assert faint.verdict == "trace" and 0.0 < faint.findings[0].depth < 0.2


@pytest.mark.parametrize("fault", BODIES)
def test_fault_is_found_with_its_line_at_the_nominal_speed_and_four_percent_off(fault):
    truth = record(fault)
    found = judged(truth.signal.values)
    assert found.verdict == BODIES[fault] and found.findings[0].found == pytest.approx(truth.line, rel=3e-3)
    truth = record(fault, speed_error=0.04)
    found = judged(truth.signal.values, SKF_6205, TURNING, 0.05)
    assert found.verdict == BODIES[fault] and found.shaft == pytest.approx(truth.shaft, rel=0.012)


def comb(frequency):
    """Noise with strong pulses at a frequency."""
    return noise(5) * (1.0 + 3.0 * (np.mod(time_of() * frequency, 1.0) < 0.1))


def test_a_multiple_of_mains_or_shaft_is_uncertain():
    """BPFO is 3.2 times the shaft, and 3 times."""
    swell = 1.0 + sum(0.4 * np.cos(2.0 * np.pi * k * 31.0 * time_of()) for k in (1, 2, 3, 6, 9))
    swelling = noise() * np.maximum(swell, 0.1)
    cases = ("mains", 10e-3, 150.0 / 3.2, comb(150.0)), ("shaft", 12.5e-3, 31.0, swelling)
    for of, diameter, shaft, values in cases:
        found = judged(values, Geometry(elements=8, element_diameter=diameter, pitch_diameter=50e-3), shaft)
        assert found.verdict == "uncertain" and f"multiple of the {of}" in found.reasons[1]


def test_what_a_record_does_not_tell_is_noted():
    geometry = Geometry(elements=16, element_diameter=8.4e-3, pitch_diameter=71.5e-3)
    for duration, shaft, tolerance, words in (
        (2.0, 33.3, 0.06, "BPFI and 2×BSF lie within the tolerance"), (1.0, 4.0, 0.01, "Sidebands of the cage"),
        (0.25, TURNING, 0.01, "turns of the shaft"),
    ):  # fmt: skip
        assert any(words in note for note in judged(noise(2, duration=duration), geometry, shaft, tolerance).notes)
    assert not any("turns of the shaft" in note for note in judged(noise(2, duration=1.0)).notes)


def test_confusion_matrix_of_drawn_records():
    """Bearings, speeds and faults by chance, half of them healthy: no one accused wrongly, deep faults found."""
    rng, deep = np.random.default_rng(11), Counter()
    for k in range(24):
        truth, geometry, shaft = drawn(rng, k % 2 == 0, 0.03, duration=1.5)
        found = diagnose(truth.signal, geometry, shaft, 0.03)
        true = "healthy" if k % 2 == 0 else BODIES[truth.fault]
        assert found.verdict in ("trace", "uncertain", "none", true)
        if true != "healthy" and found.findings[0].depth >= 0.2:
            deep[found.verdict == true] += 1
    assert deep[True] >= max(8, 0.9 * deep.total())


def test_a_line_beyond_the_tolerance_accuses_nobody_and_strikes_with_the_cages_sidebands_alone_are_an_outer_rings():
    """A comb just outside the range of 2×BSF, nearer than the record resolves. A simulated run repeats nearly once a
    turn of the cage: most lines beside the fault's are its sidebands.
    """
    shaft = 2000.0 / 60.0
    pulses = comb(1.024 * GEOMETRY.lines(shaft)["2×BSF"])[: int(0.3 * RATE)]
    assert judged(pulses, GEOMETRY, shaft).verdict in ("none", "uncertain")
    lines, time = GEOMETRY.lines(45.0), time_of(1.0)
    swell = 1.0 + 0.5 * np.cos(2.0 * np.pi * lines["FTF"] * time)
    values = noise(8, 1.0) * (0.2 + 3.0 * swell * (np.mod(time * lines["BPFO"], 1.0) < 0.1))
    assert judged(values, GEOMETRY, 45.0).verdict == "outer_ring"


def test_length_of_a_pulse_is_that_of_the_ringing():
    rate, line, decay = 50_000.0, 50.0, 2e-3  # s, in which the amplitude falls to 1/e
    since = np.mod(np.arange(int(2.0 * rate)) / rate, 1.0 / line)
    found = mean_pulse(np.exp(-since / decay) * np.sin(2.0 * np.pi * 5e3 * since), rate, line)
    smoothing = 0.01 / line  # of an exponential by a Gaussian
    at = np.linspace(-5e-3, 15e-3, 100_001)
    shape = exponnorm(0.5 * decay / smoothing, scale=smoothing).pdf(at)
    above = np.count_nonzero(shape >= 0.5 * shape.max()) * (at[1] - at[0])
    assert found.length == pytest.approx(above, rel=0.03)  # two samples
    assert found.contrast > 1e3 and found.power.mean() == pytest.approx(1.0, rel=0.02)


def width_of(name, width, shaft=20.0, rate=51_200.0):
    """Width of a record whose strikes lag 0.83 of the rolling time behind entries; 0: strikes alone, None: noise."""
    rng, line = np.random.default_rng(2), SKF_6205.lines(shaft)[name]
    raceway = SKF_6205.pitch_diameter + SKF_6205.element_diameter * (1.0 if name == "BPFO" else -1.0)
    strikes = 0.01 + np.cumsum(1.0 / line * (1.0 + 0.007 * rng.standard_normal(int(0.97 * line))))  # slip
    size = np.maximum(0.1, np.cos(2.0 * pi * shaft * strikes)) if name == "BPFI" else np.ones(strikes.size)
    train, time = np.zeros(int(rate)), np.arange(400) / rate
    lag = 0.83 * (width or 0.0) / (pi * raceway * line / SKF_6205.elements)
    for when, share in ((strikes, 1.0), (strikes - lag, 0.7 if width else 0.0)):
        np.add.at(train, np.rint(when * rate).astype(int), (width is not None) * share * size)
    pulse = sum(np.exp(-time * f) * np.sin(2.0 * pi * f * time) for f in (1500.0, 4000.0, 12_000.0))
    values = fftconvolve(train, pulse)[: train.size] + 0.15 * rng.standard_normal(train.size)
    signal = Signal(name="made", values=values - values.mean(), rate=rate, unit="")
    return damage_width(signal, SKF_6205, diagnose(signal, SKF_6205, shaft))


@pytest.mark.parametrize("name", ["BPFO", "BPFI"])
def test_width_that_is_told_is_that_of_the_lag_but_of_narrow_damage_and_noise_none_with_a_reason(name):
    """And from 2.6 mm on it is told."""
    widths = np.arange(1.4e-3, 3.7e-3, 0.4e-3)
    found = [width_of(name, width) for width in widths]
    told = np.array([np.nan if each.value is None else each.value for each in found])
    known, last = np.isfinite(told), found[-1]
    assert np.all(known[widths > 2.5e-3]) and told[known] == pytest.approx(widths[known], rel=0.04)
    assert (last.low, last.high) == pytest.approx((last.value * 0.83 / 0.96, last.value * 0.83 / 0.70))
    assert all((each.value is None) == (each.reason is not None) for each in found)
    for width in (None, 0.0, 0.3e-3, 1.0e-3) if name == "BPFO" else ():
        found = width_of("BPFO", width)
        assert (found.value, found.low, found.high) == (None, None, None)
        assert found.reason == "no ring was found damaged" if width is None else found.reason


def series(folder, strengths):
    """Records of one bearing whose strikes have so many times the noise's rms, and options."""
    for k, strength in enumerate(strengths):
        made(folder / f"day{k}.npz", "BPFO" if strength else None, strength, 40 + k)
    return [*(str(folder / f"day{k}.npz") for k in range(len(strengths))), *NU206, "--unit", "g", "--quiet"]


def test_growing_damage_is_found_with_the_record_from_which_on_it_accuses(tmp_path):
    given = series(tmp_path, (0.0, 0.0, 0.1, 0.3, 0.6, 1.0, 2.0))
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04nothing")
    assert main([*given[:3], str(tmp_path / "broken.npz"), *given[3:]]) == 0
    folder = tmp_path / "day0-trend"
    summary = read_json(folder / "summary.json")
    assert summary["verdict"] == "outer_ring" and set(summary["files"]) == {path.name for path in folder.iterdir()}
    grown = summary["growth"][0]
    assert grown["name"] == "BPFO" and grown["p"] < 0.01 and grown["last_depth"] > 4.0 * grown["first_depth"]
    assert [words.split()[3] for words in summary["sentences"] if " grows" in words] == ["BPFO"]
    verdicts = [each.get("verdict") for each in summary["records"]]
    assert verdicts[3] is None and "can't be read" in summary["records"][3]["reason"]
    since = verdicts.index("outer_ring")
    assert f"from day{since - 1}.npz on" in summary["sentences"][1]  # the broken one stands before it
    page = (folder / "vibration.html").read_text(encoding="utf-8")
    assert page.index("The outer ring is damaged.") < page.index("<figure") and "not used: " in page


def test_a_healthy_series_does_not_grow_and_a_short_one_is_refused(tmp_path, capsys):
    given = series(tmp_path, (0.0,) * 5)
    assert main([*given, "--no-figures"]) == 0
    told = read_json(tmp_path / "day0-trend" / "summary.json")["sentences"]
    assert told[-1] == "No line grows beyond chance over the series."
    short = [*given[:2], *given[5:]]
    for more, words in (([], "2 usable records; at least 3 are needed"), (["--against", given[0]], "one record")):
        assert main([*short, *more]) == 2 and words in capsys.readouterr().err
    assert main(given[:5]) == 2 and capsys.readouterr().err.count("the bearing is missing") == 1


def test_chance_of_growth_is_that_of_the_ranks():
    """Of n rising values the chance is 1/n!, of any of three lines three times that."""
    entries = [{"BPFO": 0.1 * k, "BPFI": 0.3, "2×BSF": -0.1 * k} for k in (1, 2, 4, 7, 9, 11)]
    found = {each.name: each for each in growth(entries[:5])}
    assert found["BPFO"].p == pytest.approx(3.0 / 120.0, rel=1e-9) and not found["BPFO"].sure
    assert growth(entries)[0].p == pytest.approx(3.0 / 720.0, rel=1e-9) and growth(entries)[0].sure
    assert found["2×BSF"].tau == pytest.approx(-1.0) and found["2×BSF"].p == 1.0
    assert (found["BPFI"].tau, found["BPFI"].p) == (0.0, 1.0)
