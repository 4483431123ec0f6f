"""The command check-vibration: verdict, summary.json, page, comparison, refusals."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import exponnorm

from residual.check_vibration import main
from residual.measured import simulated
from residual.measured.diagnosis import BODIES, Geometry
from residual.measured.strikes import mean_pulse
from tests.reference.synthetic_record import synthetic_record

NU206 = ("--bearing", "NU206", "--speed", "1480")
SHAFT = 1480.0 / 60.0  # Hz
GEOMETRY = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3)  # as NU206's in the catalogue
CONTRACT = {
    "verdict", "lines", "width_mm", "width_interval_mm", "width_reason", "speed_rpm",
}  # fmt: skip
OF_LINES = {"name", "expected_Hz", "found_Hz", "level", "p", "depth"}


def written(path, fault="BPFO", strength=1.0, seed=4):
    truth = synthetic_record(np.random.default_rng(seed), GEOMETRY, SHAFT, fault, strength, duration=1.0)
    np.savez(path, acc=truth.signal.values, rate=truth.signal.rate)
    return truth


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A damaged record against a healthy one: folder and truth."""
    folder = tmp_path_factory.mktemp("records")
    truth = written(folder / "today.npz")
    written(folder / "healthy.npz", None, 0.0)
    code = main(
        [str(folder / "today.npz"), *NU206, "--unit", "g", "--against", str(folder / "healthy.npz"),
         "--output", str(folder / "report"), "--quiet"]
    )  # fmt: skip
    assert code == 0
    return folder / "report", truth


def test_summary_holds_what_is_promised(checked):
    folder, truth = checked
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert set(summary) >= CONTRACT
    assert all(set(line) == OF_LINES for line in summary["lines"])
    assert summary["verdict"] == "outer_ring"
    first = summary["lines"][0]
    assert first["name"] == "BPFO"
    assert first["expected_Hz"] == pytest.approx(GEOMETRY.lines(SHAFT)["BPFO"], rel=2e-4)
    assert first["found_Hz"] == pytest.approx(truth.line, rel=3e-3)
    assert summary["speed_rpm"] == pytest.approx(1480.0, rel=0.012)
    assert summary["width_mm"] is None and summary["width_reason"]
    assert summary["against"]["verdict"] == "none"
    assert set(summary["files"]) == {path.name for path in folder.iterdir()}


def test_a_damaged_record_does_not_pass_as_sound_by_its_missing_samples_or_marks_of_thousands(tmp_path, capsys):
    """Of 30 % of its lines, in silence, and of 25,600 Hz read as 25.6."""
    values = written(tmp_path / "record.npz").signal.values
    lines = [f"{x:.5f}" for x in values]
    rate = round(np.load(tmp_path / "record.npz")["rate"].item())
    given = [str(tmp_path / "record.csv"), *NU206, "--unit", "g", "--no-figures"]
    (tmp_path / "record.csv").write_text("\n".join([f"Sampling rate: {rate:,} Hz", *lines]), encoding="utf-8")
    assert main(given) == 0 and "The outer ring is damaged" in capsys.readouterr().out
    (tmp_path / "record.csv").write_text("\n".join(["Sampling rate: 25,6 Hz", *lines]), encoding="utf-8")
    assert main([*given, "--rate", str(rate)]) == 0
    out = capsys.readouterr().out
    assert "The outer ring is damaged" in out and f"The file says 25.6 Hz; --rate {rate} Hz was taken" in out
    lines = [
        x if shown else "#N/A"
        for x, shown in zip(lines, np.random.default_rng(5).random(len(lines)) > 0.3, strict=True)
    ]
    (tmp_path / "record.csv").write_text("\n".join([f"Sampling rate: {rate} Hz", *lines]), encoding="utf-8")
    assert main(given) == 2 and "samples without a number (the first: line" in capsys.readouterr().err


def test_page_says_the_verdict_first_and_fetches_nothing(checked):
    page = (checked[0] / "vibration.html").read_text(encoding="utf-8")
    body = page[page.index("<body>") :]
    assert body.index("The outer ring is damaged.") < body.index("Evidence") < body.index("Comparison")
    assert body.count("data:image/") == 3
    assert "http" not in body.replace("http://www.w3.org", "")


def test_level_is_in_the_unit_of_the_record(checked):
    folder, truth = checked
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["rms_m_s2"] == pytest.approx(9.80665 * float(np.std(truth.signal.values)), rel=1e-9)


def test_velocity_of_one_tone_is_its_acceleration_over_its_frequency(tmp_path):
    time = np.arange(51_200) / 25_600.0
    rng = np.random.default_rng(2)
    tone = 3.0 * np.cos(2.0 * np.pi * 100.0 * time) + 1e-3 * rng.standard_normal(time.size)  # m/s²
    np.savez(tmp_path / "tone.npz", acc=tone, rate=25_600.0)
    assert main([str(tmp_path / "tone.npz"), *NU206, "--unit", "m/s2", "--no-figures", "--quiet"]) == 0
    summary = json.loads((tmp_path / "tone-vibration" / "summary.json").read_text(encoding="utf-8"))
    assert summary["velocity_mm_s"] == pytest.approx(1e3 * 3.0 / np.sqrt(2.0) / (2.0 * np.pi * 100.0), rel=5e-3)


@pytest.mark.parametrize("fault", [None, *BODIES])
def test_verdict_is_printed_first(fault, tmp_path, capsys):
    written(tmp_path / "record.npz", fault, 1.0 if fault else 0.0)
    assert main([str(tmp_path / "record.npz"), *NU206, "--no-figures"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(f"Verdict: {BODIES[fault] if fault else 'none'}. ")
    assert f"Page: {tmp_path / 'record-vibration' / 'vibration.html'}" in told


def test_sizes_of_a_bearing_do_as_well_as_its_name(tmp_path):
    written(tmp_path / "record.npz")
    found = []
    sizes = ["--elements", "13", "--element-diameter", "9", "--pitch-diameter", "46.5", "--speed", "1480"]
    for options in (NU206, sizes):
        assert main([str(tmp_path / "record.npz"), *options, "--no-figures", "--quiet"]) == 0
        found.append(
            json.loads((tmp_path / "record-vibration" / "summary.json").read_text(encoding="utf-8"))["lines"][0][
                "found_Hz"
            ]
        )
    assert found[0] == pytest.approx(found[1], rel=2e-3)


def test_scene_gives_bearing_and_speed(tmp_path):
    written(tmp_path / "record.npz")
    scene = tmp_path / "motor.toml"
    scene.write_text('bearing.designation = "NU206"\noperation.speed_rpm = -1480.0\n', encoding="utf-8")
    assert main([str(tmp_path / "record.npz"), "--scene", str(scene), "--no-figures", "--quiet"]) == 0
    summary = json.loads((tmp_path / "record-vibration" / "summary.json").read_text(encoding="utf-8"))
    assert summary["verdict"] == "outer_ring"


REFUSED = {
    "no bearing": (["--speed", "1480"], "the bearing is missing"),
    "no speed": (["--bearing", "NU206"], "the speed is missing"),
    "two bearings": (["--bearing", "NU206", "--elements", "9", "--speed", "1"], "leave all but one out"),
    "half a bearing": (["--elements", "9", "--speed", "1480"], "go together"),
    "no such bearing": (["--bearing", "NU9", "--speed", "1480"], "not in the table"),
    "impossible sizes": (
        ["--elements", "9", "--element-diameter", "50", "--pitch-diameter", "40", "--speed", "1"],
        "no bearing",
    ),
    "tolerance": ([*NU206, "--speed-tolerance", "much"], "must be a number of per cent"),
    "wide tolerance": ([*NU206, "--speed-tolerance", "50%"], "from 0 to 10%"),
    "slow": (["--bearing", "NU206", "--speed", "1"], "in rpm, not in Hz"),
    "scene against": ([*NU206, "--against", "scene.toml"], "scene.toml: no such file"),
    "scene without one speed": ([*NU206, "--against", "table.toml"], "at one steady speed"),
    "missing against": ([*NU206, "--against", "none.csv"], "No such file"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unusable_input_is_refused_in_one_line(case, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "record.npz")
    Path("table.toml").write_text('operation.speed_table = "speeds.csv"\n')
    Path("speeds.csv").write_text("time_ms,speed_rpm\n0,1000\n100,2000\n")
    options, words = REFUSED[case]
    assert main(["record.npz", *options]) == 2
    told = capsys.readouterr().err
    assert words in told and told.startswith("error: ") and told.count("\n") == 1
    assert not (tmp_path / "record-vibration").exists()


def test_a_folder_is_no_record(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([".", *NU206]) == 2 and "is a folder" in capsys.readouterr().err


MOTOR = """
model = "lagrange"
bearing.designation = "NU206"
operation.radial_load_N = 500.0
damping.contact_time_us = 12.5
support = { kind = "housing", stiffness_N_per_m = 3e7 }
sensor.frequency_Hz = 4000.0
spall = [{ body = "outer_ring", width_mm = 1.0 }]
"""


@pytest.mark.slow  # compiles a loop; the page on measured records runs the command
def test_scene_is_simulated_at_the_record_s_speed_and_rate(tmp_path):
    truth = synthetic_record(np.random.default_rng(5), GEOMETRY, SHAFT, "BPFO", 1.0, duration=0.2, rate=10_240.0)
    np.savez(tmp_path / "record.npz", acc=truth.signal.values, rate=truth.signal.rate)
    (tmp_path / "motor.toml").write_text(MOTOR, encoding="utf-8")
    options = ["--speed", "1480", "--against", str(tmp_path / "motor.toml"), "--no-figures", "--quiet"]
    assert main([str(tmp_path / "record.npz"), *options]) == 0  # the bearing is the scene's
    summary = json.loads((tmp_path / "record-vibration" / "summary.json").read_text(encoding="utf-8"))
    beside = summary["against"]
    assert beside["rate_Hz"] == pytest.approx(10_240.0, rel=1e-6)
    assert beside["seconds"] == pytest.approx(0.2, rel=1e-2)
    first = next(line for line in beside["lines"] if line["name"] == "BPFO")
    assert first["found_Hz"] == pytest.approx(GEOMETRY.lines(SHAFT)["BPFO"], rel=3e-3)  # the cage does not slip
    assumed = {each["key"]: (each["value"], each["given"]) for each in beside["assumed"]}
    assert assumed["support.stiffness_N_per_m"] == (3e7, True)
    assert assumed["support.mass_kg"] == (12.638, False)
    assert assumed["spall.0.width_mm"] == (1.0, True)
    assert "operation.speed_rpm=1480" in beside["command"]


def test_scene_that_run_fem_refuses_is_refused_in_its_words(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(simulated, "RUN_FEM", (sys.executable, "-c", "raise SystemExit('error: no equilibrium')"))
    written(tmp_path / "record.npz")
    (tmp_path / "motor.toml").write_text(MOTOR, encoding="utf-8")
    assert main([str(tmp_path / "record.npz"), *NU206, "--against", str(tmp_path / "motor.toml")]) == 2
    assert capsys.readouterr().err.endswith("motor.toml: run-fem: no equilibrium\n")


def test_length_of_a_pulse_is_that_of_the_ringing():
    rate, line, decay = 50_000.0, 50.0, 2e-3  # s, in which the amplitude falls to 1/e
    time = np.arange(int(2.0 * rate)) / rate
    since = np.mod(time, 1.0 / line)
    found = mean_pulse(np.exp(-since / decay) * np.sin(2.0 * np.pi * 5e3 * since), rate, line)
    smoothing = 0.01 / line  # of an exponential by a Gaussian
    at = np.linspace(-5e-3, 15e-3, 100_001)
    shape = exponnorm(0.5 * decay / smoothing, scale=smoothing).pdf(at)
    above = np.count_nonzero(shape >= 0.5 * shape.max()) * (at[1] - at[0])
    assert found.length == pytest.approx(above, rel=0.03)  # two samples
    assert found.contrast > 1e3
    assert found.power.mean() == pytest.approx(1.0, rel=0.02)


def test_foreign_folder_is_not_touched(tmp_path, capsys):
    written(tmp_path / "record.npz")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear", encoding="utf-8")
    assert main([str(tmp_path / "record.npz"), *NU206, "--output", str(tmp_path / "mine")]) == 2
    assert "no report of check-vibration" in capsys.readouterr().err
    assert (tmp_path / "mine" / "letter.txt").read_text(encoding="utf-8") == "dear"


def test_help_loads_no_heavy_library():
    heavy = ["numpy", "scipy", "matplotlib", "h5py", "pydantic"]
    program = (
        "import sys; from residual.check_vibration import app\n"
        "app(['--help'], exit_on_error=False)\n"
        f"print('loaded', *(name for name in {heavy!r} if name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1].split() == ["loaded"], done.stderr
