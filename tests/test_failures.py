"""Runs that go wrong numerically: noticed within 100 steps, good samples kept, the reason told."""

import re
from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.kernels.ring_kernels import HALO
from fem.solver.elements.plan import LONGEST_UNWATCHED
from fem.solver.row_state import SampleReader
from fem.solver.simulate import make_plan, run
from lagrange.errors import RunFailed
from lagrange.scene.scene import read_scene

SELDOM = ("numerics.mesh_size_mm=2", "numerics.duration_ms=60", "numerics.output_interval_us=3000")


@pytest.fixture(scope="module")
def plan():
    """One sample in 3 ms, thousands of steps."""
    plan = make_plan(read_scene(None, SELDOM))
    assert plan.stride > 40 * LONGEST_UNWATCHED and plan.stride / plan.looks <= LONGEST_UNWATCHED
    return plan


def failing_step(plan, state=None):
    with pytest.raises(RunFailed) as failed:
        run(plan, lambda samples: None, state=state)
    return int(re.search(r"at step (\d+), t = ", str(failed.value))[1])


def test_a_step_beyond_the_limit_is_noticed_within_100_steps(plan):
    """The first step whose energy is out by 5 % is found by looking at every step."""
    wild = replace(plan, time_step=1.05 * plan.critical_time_step)
    every_step = replace(wild, stride=1)
    rows, *_ = every_step.first_state().take_steps(4000)
    good = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    samples = SampleReader(every_step).read(rows[: good[0] if good.size else None])
    stored = samples["energy_elastic"] + samples["energy_contact"]
    out = np.abs(samples.imbalance) > 0.05 * np.maximum.accumulate(stored)
    first = int(np.argmax(out))
    assert first > 0
    assert 0 <= failing_step(wild) - first <= 100


@pytest.mark.parametrize("body", ["hub", "roller", "inner ring", "outer ring"])
def test_a_value_that_is_not_a_number_is_noticed_within_100_steps(body, plan):
    state = plan.first_state()
    arrays = state.arrays
    if body == "hub":
        arrays.drive.velocity[0] = np.nan
    elif body == "roller":
        arrays.bodies.disc.w[arrays.bodies.disc.w.size // 2] = np.nan
    else:
        ring = arrays.bodies.inner if body == "inner ring" else arrays.bodies.outer
        ring.w[ring.first_row, 0, HALO + 5] = np.nan
    assert failing_step(plan, state) <= 100


def test_a_failed_run_keeps_its_good_samples_and_says_what_to_do(tmp_path, monkeypatch, capsys):
    path = tmp_path / "run.nc"
    monkeypatch.setattr("fem.solver.elements.plan.critical_time_step", lambda *given: 1.2 * critical_time_step(*given))
    options = ["--mesh-size", "2", "--duration", "5", "--output", str(path), "--checkpoint", "0"]
    assert run_main(options) == 1
    error = capsys.readouterr().err
    assert "error: failed: " in error and str(path) in error and "Traceback" not in error
    assert re.search(r"step \d+, t = \S+ ms", error) and "lower numerics.time_step_safety" in error
    with h5py.File(path) as file:
        count = file["time"].shape[0]
        assert file.attrs["committed_samples"] == count and 0 < count < 501
        assert file.attrs["status"].startswith("failed: ") and "step" in file.attrs["status"]
        assert file.attrs["steps"] == (count - 1) * round(1e-5 / file.attrs["time_step"])
        assert all(np.isfinite(variable[:]).all() for variable in file.values())
        assert np.abs(file["inner_y"][:]).max() < 1e-5


def test_how_samples_are_cut_into_blocks_changes_no_bit_of_them():
    """Blocks are cut by the wall clock; angles wrap and sums run on across them."""
    plan = make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=1", "operation.speed_rpm=60000",
                                       "numerics.output_interval_us=10",
                                       "operation.first_roller_deg=91")))  # fmt: skip
    rows, *_ = plan.first_state().take_steps(plan.looks * 101)
    whole = SampleReader(plan).read(rows)
    assert np.ptp(whole["roller_theta"][:, 0]) > 2.0  # over ±π on the way
    for cuts in ([1, 5, 37, 90], list(range(1, 101))):
        reader = SampleReader(plan)
        parts = [reader.read(part) for part in np.split(rows, plan.looks * np.array(cuts))]
        for name in whole.values:
            assert np.array_equal(np.concatenate([part[name] for part in parts]), whole[name]), name


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
def test_a_speed_next_to_nothing_is_planned_as_standstill(model):
    """No time is long enough to look ahead of a shaft that takes longer than the universe has lasted for a turn."""
    starts = []
    for speed in ("0.0", "1e-15", "-1e-15"):
        plan = make_plan(
            read_scene(None, (f"model={model}", f"operation.speed_rpm={speed}", "numerics.mesh_size_mm=2"))
        )
        samples = plan.first_state().advance(1).samples
        starts.append((samples["inner_x"][0], samples["inner_y"][0]))
    assert starts[1:] == starts[:1] * 2
    assert starts[0][1] < 0.0
