"""What a check warns of in a record itself: vibration folded down, a beginning that is a transient."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from lagrange.scene.scene import Scene
from residual.cli import main
from residual.evaluation import evaluate
from residual.interpretation import floor_newtons, verdict
from residual.record import Record
from residual.sampling import stationarity
from residual.sources import read_result
from tests.reference.synthetic_run import make_run, write_result

# NU 206 (not E) by its makers' catalogues, a normal clearance, a shaft of 3 kg
NU206 = """
[bearing]
rollers = 13
roller_diameter_mm = 7.5
roller_length_mm = 9.0
inner_raceway_diameter_mm = 38.5
outer_raceway_diameter_mm = 53.54
bore_diameter_mm = 30.0
outside_diameter_mm = 62.0
[operation]
speed_rpm = 3000.0
radial_load_N = 1500.0
inner_ring_and_shaft_kg = 3.0
[numerics]
duration_ms = 6.0
mesh_size_mm = 2.0
"""
PASSING, STEP = 400.0, 1e-5


def checked_run(folder, interval_us):
    scene, path = folder / "nu206.toml", folder / f"{interval_us}.nc"
    scene.write_text(NU206, encoding="utf-8")
    options = ["--set", f"numerics.output_interval_us={interval_us}", "--output", str(path), "--quiet"]
    assert run_main([str(scene), *options]) == 0
    return evaluate(read_result(path))


def test_folded_vibration_of_rollers_is_warned_of_and_the_interval_named_cures_it(tmp_path):
    coarse = checked_run(tmp_path, 10)
    (note,) = [note for note in coarse.notes if "aliased" in note]
    named = float(note.rpartition("= ")[2])
    fine = checked_run(tmp_path, named)
    assert not any("aliased" in note for note in fine.notes)
    for direction, floor in zip(fine.directions, floor_newtons(fine), strict=True):
        assert direction.balance.rms < 1.5 * floor
    assert fine.y.balance.rms < 0.3 * coarse.y.balance.rms


def test_a_run_that_is_told_well_enough_is_not_warned_of(coarse_run):
    assert not any("aliased" in note for note in evaluate(read_result(coarse_run)).notes)


SPALLED = """
model = "reduced"
bearing.designation = "NU206"
operation.speed_rpm = 2950.0
operation.radial_load_N = 3000.0
numerics.duration_ms = 8.0
[[spall]]
body = "outer_ring"
width_mm = 1.2
"""


def test_a_verdict_names_our_own_sampling_and_the_interval_that_resolves_it(tmp_path):
    """Strikes in a spall: Newton's law holds for slow motion, as samples show it, and not for the strikes; the
    interval named is right where it holds for all.
    """
    scene, found, interval = tmp_path / "spalled.toml", [], 5.0
    scene.write_text(SPALLED, encoding="utf-8")
    for _ in range(2):
        path = tmp_path / f"{interval}.nc"
        options = ["--set", f"numerics.output_interval_us={interval}", "--output", str(path), "--quiet"]
        assert run_main([str(scene), *options]) == 0
        found.append(verdict(evaluate(read_result(path))))
        interval = float(found[0].partition("output_interval_us = ")[2].partition(" ")[0])
    coarse, fine = found
    assert coarse.startswith("The trajectories are sound below 10 kHz") and "samples every 5 µs do not follow" in coarse
    assert fine.startswith("The trajectories are sound (")


def test_a_warning_of_the_run_that_stands_in_its_file_twice_is_told_once(tmp_path, capsys):
    path = write_result(tmp_path / "run.nc", make_run(n_times=401), warnings="one and the same\none and the same")
    assert main([str(path), "--no-figures", "--output", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err.count("one and the same") == 1
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert page.lower().count("one and the same") == 1


def swinging(amplitudes):
    """A record whose hub swings by so much, m, in each of four quarters of 20 ms."""
    time = STEP * np.arange(8000)
    swing = np.repeat(amplitudes, 2000) * np.sin(2 * np.pi * 900.0 * time)
    none = np.zeros((time.size, 13))
    return Record(
        name="made", source=Path("made.nc"), scene=Scene(), time=time, inner_x=swing, inner_y=0.1 * swing,
        roller_x=none, roller_y=none,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("amplitudes", "settled"),
    [((1, 1, 1.2, 1), 0), ((1, 3, 3.1, 3), 1), ((1, 2, 4, 4.4), 2), ((1, 2, 3, 6), None), ((1e-5, 3e-5, 1e-6, 0), 0)],
)
def test_the_quarter_from_which_the_hub_swings_alike(amplitudes, settled):
    record = swinging(1e-7 * np.array(amplitudes, dtype=float))
    found = stationarity(record, {"x": record.inner_x, "y": record.inner_y}, PASSING)
    assert found.settled == settled
    np.testing.assert_allclose(found.hub["x"], 1e-7 * np.array(amplitudes) / np.sqrt(2), rtol=1e-6)
    if settled is None:
        assert "simulate longer" in found.note
    elif settled:
        assert f"--start {20 * settled} leaves it out" in found.note
    else:
        assert found.note is None


def test_a_record_of_few_passages_is_not_judged():
    record = swinging(np.ones(4))
    short = record.samples(slice(0, 1900))
    assert stationarity(short, {}, PASSING) is None and stationarity(record, {}, 0.0) is None
    assert stationarity(replace(record), {}, PASSING) is not None
