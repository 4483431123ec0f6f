"""A run that stops goes on bit for bit, or says why it can't."""

import json
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path, load_checkpoint, save_checkpoint
from fem.result.store import ResultFile
from fem.solver import row_state
from fem.solver.simulate import make_plan, run
from lagrange.errors import UsageError
from lagrange.scene.scene import read_scene
from tests.reference.commands import ENTRIES, command, environment, start_run, started_as
from tests.reference.run_files import same_data
from tests.waiting import GIVE_UP, wait_until

SETTINGS = ("numerics.mesh_size_mm=2", "numerics.duration_ms=2")
OPTIONS = ["--mesh-size", "2", "--quiet"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*OPTIONS, "--duration", "2", "--output", str(path)]) == 0
    return path


def test_samples_beyond_the_checkpoint_are_written_again(whole, tmp_path):
    """What a kill between flush and checkpoint leaves."""
    path = tmp_path / "killed.nc"
    plan = make_plan(read_scene(None, SETTINGS))
    state = plan.first_state()
    with ResultFile(path, plan, 0.0) as store:
        run(plan, store.append, stop=lambda: state.done >= 20, state=state)
        store.commit()
        save_checkpoint(path, state, store.stored)
        run(plan, store.append, stop=lambda: state.done >= 60, state=state)
        store.commit()
    assert run_main([*OPTIONS, "--duration", "2", "--output", str(path), "--resume"]) == 0
    assert same_data(path, whole)


def test_killed_before_the_first_checkpoint_there_is_nothing_to_resume_but_the_samples_stay(tmp_path, capsys):
    path = tmp_path / "killed.nc"
    process = start_run(path)
    process.kill()
    process.communicate(timeout=GIVE_UP)
    assert not checkpoint_path(path).exists()
    assert "nothing to resume" in refused([*OPTIONS, "--duration", "2000", "--output", str(path), "--resume"], capsys)
    with h5py.File(path) as file:
        assert file.attrs["committed_samples"] > 0


def refused(arguments, capsys):
    assert run_main(arguments) == 2
    error = capsys.readouterr().err
    assert "Traceback" not in error
    return error


def test_missing_damaged_and_foreign_checkpoints_are_refused(whole, tmp_path, capsys):
    path = tmp_path / "copy.nc"
    path.write_bytes(whole.read_bytes())
    arguments = [*OPTIONS, "--duration", "2", "--output", str(path), "--resume"]
    assert "nothing to resume" in refused(arguments, capsys)
    good = checkpoint_path(whole).read_bytes()
    for bad in (b"", b"nonsense", good[: len(good) // 2], good[:200] + bytes(200) + good[400:]):
        checkpoint_path(path).write_bytes(bad)
        assert str(checkpoint_path(path)) in refused(arguments, capsys)
    checkpoint_path(path).write_bytes(good)
    path.write_bytes(whole.read_bytes()[:5000])
    assert str(path) in refused(arguments, capsys)


def test_another_version_is_refused(whole, monkeypatch):
    plan = make_plan(read_scene(None, SETTINGS))
    monkeypatch.setattr("fem.kernels.kernel_folder.version", lambda: "other")
    with pytest.raises(UsageError, match=r"another version of the program.* \(kernels was '[\w-]+', now 'other'\)"):
        load_checkpoint(whole, plan)


def forged(whole, path, change):
    """A finished run's files, the checkpoint changed by `change(arrays, meta)` and sound in itself."""
    with np.load(checkpoint_path(whole)) as file:
        arrays = dict(file)
    meta = json.loads(arrays.pop("meta").tobytes())
    change(arrays, meta)
    with open(checkpoint_path(path), "wb") as file:
        np.savez(file, meta=np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8), **arrays)
    path.write_bytes(whole.read_bytes())
    return path


def say(key, value):
    return lambda arrays, meta: meta.__setitem__(key, value)


def on_another_processor(arrays, meta):
    meta["versions"]["processor"] = "pentium-mmx"


def reshaped(arrays, meta):
    arrays["drive.hub"] = np.zeros(3)


def of_another_type(arrays, meta):
    arrays["drive.hub"] = arrays["drive.hub"].astype(">f8")


FORGERIES = {
    "a hub of three coordinates": (reshaped, "damaged"),
    "numbers of another order of bytes": (of_another_type, "damaged"),
    "another model": (say("numbers", {"model": "0" * 64}), "meshes and matrices are not those computed here"),
    "another processor": (on_another_processor, "processor was 'pentium-mmx'"),
    "numbers in place of text": (say("scene", 5), "damaged"),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_forged_checkpoint_with_sound_checksums_is_refused_in_a_sentence(forgery, whole, tmp_path, capsys):
    change, words = FORGERIES[forgery]
    path = forged(whole, tmp_path / "run.nc", change)
    before = path.read_bytes()
    error = refused([*OPTIONS, "--duration", "4", "--output", str(path), "--resume"], capsys)
    assert error.startswith(f"error: {checkpoint_path(path)}: ") and words in error
    assert error.count("\n") == 1 and path.read_bytes() == before


def test_what_the_model_determines_is_not_read_from_a_checkpoint(whole, tmp_path):
    """Neighbours in the roller's mesh are places in arrays: wrong ones would have the kernels read anywhere."""

    def change(arrays, meta):
        assert not {"bodies.disc.neighbours", "bodies.disc.starts", "bodies.disc.points"} & set(arrays)
        arrays["bodies.disc.neighbours"] = np.full(153, 10**12)
        arrays["bodies.disc.points"] = np.zeros(54)

    path, other = forged(whole, tmp_path / "run.nc", change), tmp_path / "other.nc"
    for target, resume in ((path, ["--resume"]), (other, [])):
        done = command("run-fem", *OPTIONS, "--duration", "4", "--output", target, *resume)
        assert done.returncode == 0, done.stderr
    assert same_data(path, other)


def test_a_second_run_on_the_same_file_is_refused_and_harms_nothing(tmp_path, capsys):
    path = tmp_path / "shared.nc"
    process = start_run(path)
    try:
        with h5py.File(path) as file:  # anyone may look on
            assert file.attrs["status"] == "running"
            assert np.all(np.isfinite(file["time"][: file.attrs["committed_samples"]]))
        assert "in use" in refused([*OPTIONS, "--duration", "1", "--output", str(path)], capsys)
    finally:
        process.terminate()
        process.communicate(timeout=GIVE_UP)
    with h5py.File(path) as file:
        assert file.attrs["status"] == "interrupted" and file.attrs["committed_samples"] > 0


# Runs that are stopped within a sample that takes long, and results that are taken away from under a run


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
    assert error.startswith("interrupted at 0.000 ms; 0 samples are in") and "the same command with --resume" in error
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
