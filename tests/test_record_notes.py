"""What a check warns of in a record itself: vibration folded down, a beginning that is a transient."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fem.cli import run_main
from lagrange.scene import Scene
from residual.evaluation import evaluate
from residual.quarters import quarters
from residual.record import Record
from residual.sources import read_result
from residual.tables import floor_newtons

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
    (note,) = [note for note in coarse.notes if "false frequencies" in note]
    named = float(note.rpartition("= ")[2])
    fine = checked_run(tmp_path, named)
    assert not any("false frequencies" in note for note in fine.notes)
    for direction, floor in zip(fine.directions, floor_newtons(fine), strict=True):
        assert direction.balance.rms < 1.5 * floor
    assert fine.y.balance.rms < 0.3 * coarse.y.balance.rms


def test_a_run_that_is_told_well_enough_is_not_warned_of(coarse_run):
    assert not any("false frequencies" in note for note in evaluate(read_result(coarse_run)).notes)


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
    found = quarters(record, {"x": record.inner_x, "y": record.inner_y}, PASSING)
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
    assert quarters(short, {}, PASSING) is None and quarters(record, {}, 0.0) is None
    assert quarters(replace(record), {}, PASSING) is not None
