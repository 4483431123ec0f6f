"""Runs that are stopped within a sample that takes long, and results that are taken away from under a run."""

import signal
import subprocess
import time

import h5py
import pytest

from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from fem.solver import row_state
from fem.solver.simulate import make_plan
from lagrange.scene.scene import read_scene
from tests.reference.commands import ENTRIES, environment, started_as
from tests.waiting import GIVE_UP, wait_until

LONG = ["--set", "numerics.output_interval_us=1e6", "--duration", "3000"]  # minutes a sample
STEADY = ["--mesh-size", "2", "--duration", "100000", "--checkpoint", "0"]

STRUCK = """
import os, signal, sys

def strike(event, arguments):
    if event == "open" and str(arguments[0]).endswith("s.toml"):
        os.kill(os.getpid(), signal.{signal})

sys.addaudithook(strike)
"""


def started(path, *options):
    """A run whose result file is there."""
    process = subprocess.Popen(
        [*started_as("run-fem"), *options, "--quiet", "--output", str(path)],
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until(path.exists, process)
    return process


@pytest.mark.usefixtures("coarse_run")  # kernels are compiled
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_a_signal_is_heard_within_a_sample_of_minutes(number, tmp_path):
    path = tmp_path / "run.nc"
    process = started(path, *LONG)
    time.sleep(0.5)
    process.send_signal(number)
    try:
        _, error = process.communicate(timeout=GIVE_UP)
    finally:
        process.kill()
    assert process.returncode == 128 + number, error
    assert error.startswith("interrupted at 0.000 ms; 0 samples are in") and "--resume goes on" in error
    with h5py.File(path) as file:
        assert file.attrs["status"] == "interrupted"
    assert checkpoint_path(path).is_file()


def test_a_sample_that_was_left_off_leaves_the_state_as_it_was_and_cutting_it_changes_no_bit(monkeypatch):
    monkeypatch.setattr(row_state, "size_of_block", lambda size, found, took: 4 * size)
    plan = make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=8",
                                       "numerics.output_interval_us=2000")))  # fmt: skip
    assert plan.looks > 20
    state, other = plan.first_state(), plan.first_state()
    asked = iter([False, True])
    state.stop = lambda: next(asked)
    assert state.advance(1).samples is None and state.done == 0
    for name, array in state.arrays.named().items():
        assert array.tobytes() == other.arrays.named()[name].tobytes(), name
    state.stop = lambda: False
    first, second = state.advance(1).samples, state.advance(1).samples
    both = other.advance(2).samples
    for name, values in both.values.items():
        assert values[:1].tobytes() == first[name].tobytes() and values[1:].tobytes() == second[name].tobytes(), name


@pytest.mark.parametrize(
    ("name", "number"),
    [("run-fem", signal.SIGTERM), ("run-fem", signal.SIGINT), ("run-study", signal.SIGTERM)],
)
def test_a_signal_before_there_is_a_run_ends_the_command_with_a_word(name, number, tmp_path):
    (tmp_path / "s.toml").write_text("")
    *python, program = started_as(name)
    struck = STRUCK.format(signal=signal.Signals(number).name) + program
    done = subprocess.run(
        [*python, struck, "s.toml"], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=GIVE_UP
    )
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, "", "interrupted\n")
    assert [file.name for file in tmp_path.iterdir()] == ["s.toml"]


LOADED = """
import os, signal, sys

def strike(event, arguments):
    if event == "import" and arguments[0] == "{module}":
        os.kill(os.getpid(), signal.{signal})

sys.addaudithook(strike)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("name", "module"),
    [
        *((name, "cyclopts") for name in ENTRIES),
        *((name, "numpy") for name in ("run-fem", "check-residual")),
    ],
)
def test_a_signal_while_a_command_is_loaded_ends_it_with_a_word_at_most(name, number, module, tmp_path):
    *python, program = started_as(name)
    struck = LOADED.format(module=module, signal=signal.Signals(number).name) + program
    done = subprocess.run(
        [*python, struck, "s.toml"], cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=GIVE_UP
    )
    assert (done.returncode, done.stdout) == (128 + number, "")
    assert done.stderr.count("\n") <= 1 and "Traceback" not in done.stderr


@pytest.mark.usefixtures("coarse_run")
@pytest.mark.parametrize("what", ["removed", "renamed"])
def test_a_result_taken_away_during_the_run_is_not_told_to_be_there(what, tmp_path):
    path, other = tmp_path / "run.nc", tmp_path / "other.nc"
    process = started(path, *STEADY)
    wait_until(checkpoint_path(path).exists, process)
    path.rename(other)
    if what == "removed":
        other.unlink()
    process.terminate()
    _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == 2
    assert f"error: {path}: " in error and "has been moved or removed" in error and "are in" not in error
    if what == "renamed":
        other.rename(path)
        with h5py.File(path) as file:
            done = 0.01 * int(file.attrs["committed_samples"])
        assert (
            run_main([*STEADY[:2], "--duration", f"{done + 1:.2f}", "--quiet", "--resume", "--output", str(path)]) == 0
        )
