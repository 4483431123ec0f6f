"""The command check-vibration: verdict, summary.json, page, comparison, refusals."""

import json
import subprocess
import sys
from collections import Counter
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import fftconvolve
from scipy.stats import exponnorm

from residual.check_vibration import main
from residual.errors import InputError
from residual.measured import checks
from residual.measured.diagnosis import BODIES, Geometry, damage_width, diagnose, envelope_spectrum, mean_pulse
from residual.measured.report import Entry, growth
from residual.measured.signals import Signal
from tests.reference.synthetic_record import drawn, synthetic_record

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
    monkeypatch.setattr(checks, "RUN_FEM", (sys.executable, "-c", "raise SystemExit('error: no equilibrium')"))
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


# Verdicts on records whose truth is known; kinematics and depth against independent values


SKF_6205 = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
SHAFT_MEASURED_DIAGNOSIS = 29.95  # Hz


def record(fault, strength=1.0, seed=3, **keywords):
    return synthetic_record(
        np.random.default_rng(seed), SKF_6205, SHAFT_MEASURED_DIAGNOSIS, fault, strength, **keywords
    )


def noise(seed=1, duration=2.0, rate=25_600.0):
    return np.random.default_rng(seed).standard_normal(int(duration * rate))


def signal(values, rate=25_600.0):
    return Signal(name="made", values=values, rate=rate, unit="")


def test_lines_are_those_of_the_catalogue():
    """Multiples of the shaft's frequency that CWRU's Bearing Data Center gives for the drive end, SKF 6205."""
    lines = SKF_6205.lines(1.0)
    for name, multiple in {"BPFO": 3.5848, "BPFI": 5.4152, "2×BSF": 4.7135, "FTF": 0.39828}.items():
        assert lines[name] == pytest.approx(multiple, rel=2e-4)


def test_contact_angle_moves_lines():
    """Rexnord ZA-2115 at 2000 rpm: 236.4 Hz as the IMS data set's readers give."""
    geometry = Geometry(
        elements=16, element_diameter=8.4074e-3, pitch_diameter=71.501e-3, contact_angle=np.radians(15.17)
    )
    assert geometry.lines(2000.0 / 60.0)["BPFO"] == pytest.approx(236.4, abs=0.05)


@pytest.mark.parametrize("depth", [0.3, 0.6])
def test_depth_of_noise_is_a_quarter_of_pi_of_that_of_its_power(depth):
    """Noise whose power swells by 1 + d cos: bins that far apart correlate by d/2, their phases alone by π/4 of that.

    Source: the correlation of two complex Gaussian numbers of which only the phases are kept, π/4 ρ (1 + ρ²/8 + ...).
    """
    time = np.arange(102_400) / 25_600.0
    values = noise(duration=4.0) * np.sqrt(1.0 + depth * np.cos(2.0 * np.pi * 107.0 * time))
    spectrum = envelope_spectrum(values, 25_600.0, 1.0, 1000.0)
    assert spectrum.modulation(np.array([107.0]))[0] == pytest.approx(0.25 * np.pi * depth, abs=0.02)


def test_noise_of_few_turns_is_hardly_ever_a_line():
    """Its own comb is taken out of the spectrum that it is compared with, without making that calmer."""
    found = [
        diagnose(signal(noise(seed, duration=0.25)), SKF_6205, SHAFT_MEASURED_DIAGNOSIS).verdict for seed in range(30)
    ]
    assert found.count("none") >= 26 and "trace" not in found


def test_tones_leave_no_lines():
    """Prewhitening makes loud tones of one family, as of an inverter, as faint as noise."""
    time = np.arange(51_200) / 25_600.0
    tones = sum(30.0 * np.cos(2.0 * np.pi * (4000.0 + k * 107.0) * time) for k in range(-5, 6))
    assert diagnose(signal(noise() + tones), SKF_6205, SHAFT_MEASURED_DIAGNOSIS).verdict == "none"


@pytest.mark.parametrize("fault", BODIES)
def test_fault_is_found_with_its_line(fault):
    truth = record(fault)
    found = diagnose(truth.signal, SKF_6205, SHAFT_MEASURED_DIAGNOSIS)
    assert found.verdict == BODIES[fault]
    assert found.findings[0].found == pytest.approx(truth.line, rel=3e-3)


@pytest.mark.parametrize("fault", BODIES)
def test_speed_four_percent_off_is_found(fault):
    truth = record(fault, speed_error=0.04)
    found = diagnose(truth.signal, SKF_6205, SHAFT_MEASURED_DIAGNOSIS, 0.05)
    assert found.verdict == BODIES[fault]
    assert found.shaft == pytest.approx(truth.shaft, rel=0.012)


def test_verdict_does_not_depend_on_the_unit():
    truth = record("BPFO")
    twice = diagnose(signal(1e4 * truth.signal.values), SKF_6205, SHAFT_MEASURED_DIAGNOSIS)
    once = diagnose(truth.signal, SKF_6205, SHAFT_MEASURED_DIAGNOSIS)
    assert twice.verdict == once.verdict
    assert twice.findings[0].found == once.findings[0].found


def test_faint_line_is_a_trace():
    found = diagnose(record("BPFO", 0.22).signal, SKF_6205, SHAFT_MEASURED_DIAGNOSIS)
    assert found.verdict == "trace"
    assert 0.0 < found.findings[0].depth < 0.2


def comb(frequency, seed=5):
    """Noise with strong pulses at a frequency."""
    time = np.arange(51_200) / 25_600.0
    return noise(seed) * (1.0 + 3.0 * (np.mod(time * frequency, 1.0) < 0.1))


def test_multiple_of_the_mains_is_uncertain():
    geometry = Geometry(elements=8, element_diameter=10e-3, pitch_diameter=50e-3)  # BPFO 3.2 times the shaft
    found = diagnose(signal(comb(150.0)), geometry, 150.0 / 3.2)
    assert found.verdict == "uncertain"
    assert "multiple of the mains" in found.reasons[1]


def test_multiple_of_the_shaft_is_uncertain():
    geometry = Geometry(elements=8, element_diameter=12.5e-3, pitch_diameter=50e-3)  # BPFO 3 times the shaft
    time = np.arange(51_200) / 25_600.0
    swell = 1.0 + sum(0.4 * np.cos(2.0 * np.pi * k * 31.0 * time) for k in (1, 2, 3, 6, 9))
    found = diagnose(signal(noise() * np.maximum(swell, 0.1)), geometry, 31.0)
    assert found.verdict == "uncertain"
    assert "multiple of the shaft" in found.reasons[1]


def test_bodies_whose_lines_the_speed_does_not_tell_apart_are_told():
    geometry = Geometry(elements=16, element_diameter=8.4e-3, pitch_diameter=71.5e-3)
    notes = diagnose(signal(noise()), geometry, 33.3, 0.06).notes
    assert any("BPFI and 2×BSF lie within the tolerance" in note for note in notes)


def test_sidebands_of_a_slow_cage_are_said_to_be_unresolved():
    geometry = Geometry(elements=16, element_diameter=8.4e-3, pitch_diameter=71.5e-3)
    notes = diagnose(signal(noise(duration=1.0)), geometry, 4.0).notes
    assert any("Sidebands of the cage" in note for note in notes)


@pytest.mark.parametrize(
    ("shaft", "tolerance", "words"),
    [(0.0, 0.01, "--speed 0"), (30.0, 0.5, "--speed-tolerance"), (1.0, 0.01, "passes"), (2000.0, 0.01, "sampled at")],
)
def test_unusable_speeds_are_refused(shaft, tolerance, words):
    with pytest.raises(InputError, match=words):
        diagnose(signal(noise()), SKF_6205, shaft, tolerance)


def test_confusion_matrix_of_drawn_records():
    """Bearings, speeds and faults by chance, half of them healthy: no one accused wrongly, deep faults found."""
    rng, matrix = np.random.default_rng(11), Counter()
    for k in range(24):
        truth, geometry, shaft = drawn(rng, k % 2 == 0, 0.03, duration=1.5)
        found = diagnose(truth.signal, geometry, shaft, 0.03)
        true = "healthy" if k % 2 == 0 else BODIES[truth.fault]
        deep = found.findings[0].depth >= 0.2
        matrix[true, found.verdict] += 1
        assert found.verdict in ("trace", "uncertain", "none", true)
        if true != "healthy" and deep:
            matrix["deep", found.verdict == true] += 1
    assert matrix["deep", True] >= 0.9 * (matrix["deep", True] + matrix["deep", False])
    assert matrix["deep", True] >= 8


def test_skirt_of_a_line_beyond_the_tolerance_accuses_nobody():
    """A comb just outside the range of 2×BSF, nearer than the record resolves."""
    geometry = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3)
    expected = geometry.lines(2000.0 / 60.0)["2×BSF"]
    pulses = comb(1.024 * expected)[: int(0.3 * 25_600)]
    assert diagnose(signal(pulses), geometry, 2000.0 / 60.0).verdict in ("none", "uncertain")


def test_strikes_with_sidebands_of_the_cage_alone_are_an_outer_rings():
    """A simulated run repeats nearly once a turn of the cage: most lines beside the fault's are its sidebands."""
    geometry, rng = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3), np.random.default_rng(8)
    lines = geometry.lines(45.0)
    time = np.arange(25_600) / 25_600.0
    swell = 1.0 + 0.5 * np.cos(2.0 * np.pi * lines["FTF"] * time)
    values = rng.standard_normal(time.size) * (0.2 + 3.0 * swell * (np.mod(time * lines["BPFO"], 1.0) < 0.1))
    assert diagnose(signal(values), geometry, 45.0).verdict == "outer_ring"


@pytest.mark.parametrize(("duration", "few"), [(0.25, True), (1.0, False)])
def test_few_turns_of_the_shaft_are_noted_where_nothing_stands_out(duration, few):
    found = diagnose(signal(noise(seed=2, duration=duration)), SKF_6205, SHAFT_MEASURED_DIAGNOSIS)
    assert found.verdict == "none" and any("turns of the shaft" in note for note in found.notes) == few


# Widths of records with an entry and a strike of known lag, and reasons where there is none


GEOMETRY_MEASURED_WIDTH = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
SHAFT_MEASURED_WIDTH, RATE = 20.0, 51_200.0  # Hz


def judged(name, width, seed=2):
    """The width of a record whose strikes lag 0.83 of the rolling time behind entries; 0: strikes alone."""
    rng, line = np.random.default_rng(seed), GEOMETRY_MEASURED_WIDTH.lines(SHAFT_MEASURED_WIDTH)[name]
    raceway = GEOMETRY_MEASURED_WIDTH.pitch_diameter + GEOMETRY_MEASURED_WIDTH.element_diameter * (
        1.0 if name == "BPFO" else -1.0
    )
    lag = 0.83 * width / (pi * raceway * line / GEOMETRY_MEASURED_WIDTH.elements)
    strikes = 0.01 + np.cumsum(1.0 / line * (1.0 + 0.007 * rng.standard_normal(int(0.97 * line))))  # slip
    size = (
        np.maximum(0.1, np.cos(2.0 * pi * SHAFT_MEASURED_WIDTH * strikes)) if name == "BPFI" else np.ones(strikes.size)
    )
    train = np.zeros(int(RATE))
    for when, share in ((strikes, 1.0), (strikes - lag, 0.7 if width else 0.0)):
        np.add.at(train, np.rint(when * RATE).astype(int), share * size)
    time = np.arange(400) / RATE
    pulse = sum(np.exp(-time * f) * np.sin(2.0 * pi * f * time) for f in (1500.0, 4000.0, 12_000.0))
    values = fftconvolve(train, pulse)[: train.size] + 0.15 * rng.standard_normal(train.size)
    signal = Signal(name="made", values=values - values.mean(), rate=RATE, unit="")
    return damage_width(
        signal, GEOMETRY_MEASURED_WIDTH, diagnose(signal, GEOMETRY_MEASURED_WIDTH, SHAFT_MEASURED_WIDTH)
    )


@pytest.mark.parametrize("name", ["BPFO", "BPFI"])
def test_width_that_is_told_is_that_of_the_lag(name):
    """And from 2.6 mm on it is told."""
    widths = np.arange(1.4e-3, 3.7e-3, 0.4e-3)
    found = [judged(name, width) for width in widths]
    told = np.array([np.nan if each.value is None else each.value for each in found])
    assert np.all(np.isfinite(told[widths > 2.5e-3]))
    np.testing.assert_allclose(told[np.isfinite(told)], widths[np.isfinite(told)], rtol=0.04)
    last = found[-1]
    assert (last.low, last.high) == pytest.approx((last.value * 0.83 / 0.96, last.value * 0.83 / 0.70))
    assert all((each.value is None) == (each.reason is not None) for each in found)


@pytest.mark.parametrize("width", [0.0, 0.3e-3, 1.0e-3])
def test_narrow_damage_has_a_reason_and_no_width(width):
    found = judged("BPFO", width)
    assert (found.value, found.low, found.high) == (None, None, None)
    assert found.reason


def test_noise_has_no_width():
    values = np.random.default_rng(1).standard_normal(51_200)
    signal = Signal(name="noise", values=values, rate=RATE, unit="")
    assert (
        damage_width(
            signal, GEOMETRY_MEASURED_WIDTH, diagnose(signal, GEOMETRY_MEASURED_WIDTH, SHAFT_MEASURED_WIDTH)
        ).reason
        == "no ring was found damaged"
    )


# A series of records: growth that is there is found, none where there is none, and unusable records are named


NU206_TREND = ("--bearing", "NU206", "--speed", "1480", "--unit", "g", "--quiet")


def series(folder, strengths, fault="BPFO"):
    """Records of one bearing whose strikes have so many times the noise's rms."""
    for k, strength in enumerate(strengths):
        truth = synthetic_record(
            np.random.default_rng(40 + k), GEOMETRY, 1480.0 / 60.0, fault if strength else None, strength, duration=1.0
        )
        np.savez(folder / f"day{k}.npz", acc=truth.signal.values, rate=truth.signal.rate)
    return [str(folder / f"day{k}.npz") for k in range(len(strengths))]


def test_growing_damage_is_found_with_the_record_from_which_on_it_accuses(tmp_path):
    paths = series(tmp_path, (0.0, 0.0, 0.1, 0.3, 0.6, 1.0, 2.0))
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04nothing")
    assert main([*paths[:3], str(tmp_path / "broken.npz"), *paths[3:], *NU206_TREND]) == 0
    folder = tmp_path / "day0-trend"
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["verdict"] == "outer_ring" and set(summary["files"]) == {path.name for path in folder.iterdir()}
    grown = summary["growth"][0]
    assert grown["name"] == "BPFO" and grown["p"] < 0.01 and grown["last_depth"] > 4.0 * grown["first_depth"]
    assert [words.split()[3] for words in summary["sentences"] if " grows" in words] == ["BPFO"]
    verdicts = [each.get("verdict") for each in summary["records"]]
    assert verdicts[3] is None and "can't be read" in summary["records"][3]["reason"]
    since = next(k for k, verdict in enumerate(verdicts) if verdict == "outer_ring")
    assert f"from day{since - 1}.npz on" in summary["sentences"][1]  # the broken one stands before it
    page = (folder / "vibration.html").read_text(encoding="utf-8")
    assert page.index("The outer ring is damaged.") < page.index("<figure") and "not used: " in page


def test_healthy_series_does_not_grow(tmp_path):
    assert main([*series(tmp_path, (0.0,) * 5), *NU206_TREND, "--no-figures"]) == 0
    summary = json.loads((tmp_path / "day0-trend" / "summary.json").read_text(encoding="utf-8"))
    assert summary["sentences"][-1] == "No line grows beyond chance over the series."


def test_chance_of_growth_is_that_of_the_ranks():
    """Of n rising values the chance is 1/n!, of any of three lines three times that."""
    entries = [Entry(name="", depths={"BPFO": 0.1 * k, "BPFI": 0.3, "2×BSF": -0.1 * k}) for k in (1, 2, 4, 7, 9, 11)]
    found = {each.name: each for each in growth(entries[:5])}
    assert found["BPFO"].p == pytest.approx(3.0 / 120.0, rel=1e-9) and not found["BPFO"].sure
    assert growth(entries)[0].p == pytest.approx(3.0 / 720.0, rel=1e-9) and growth(entries)[0].sure
    assert found["2×BSF"].tau == pytest.approx(-1.0) and found["2×BSF"].p == 1.0
    assert (found["BPFI"].tau, found["BPFI"].p) == (0.0, 1.0)


def test_short_or_unusable_series_are_refused(tmp_path, capsys):
    paths = series(tmp_path, (0.0, 0.0))
    assert main([*paths, *NU206_TREND]) == 2
    assert "a series of 2 usable records; at least 3 are needed" in capsys.readouterr().err
    assert main([*paths, *NU206_TREND, "--against", paths[0]]) == 2
    assert "only with one record" in capsys.readouterr().err
