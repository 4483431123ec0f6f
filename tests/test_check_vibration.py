"""The command check-vibration: one record, two or a series."""

import sys
from pathlib import Path

import numpy as np
import pytest

from residual.check_vibration import main
from residual.measured import checks
from residual.measured.checks import growth
from residual.measured.diagnosis import BODIES, Geometry
from residual.spectrum import power_spectrum
from residual.vibration import velocity_level
from tests.reference.kit import read_json
from tests.reference.synthetic_record import synthetic_record

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
