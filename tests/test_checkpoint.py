"""A run that stops, is killed or told to end goes on bit for bit, or says why it can't; foreign fields are refused."""

import itertools
import json
import os
import shutil
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path, load_checkpoint, save_checkpoint
from fem.result.run_file import GROUP, stored_samples
from fem.result.store import ResultFile
from fem.solver import row_state, simulate
from fem.solver.simulate import make_plan, run
from lagrange.columns import columns_of
from lagrange.errors import UsageError
from lagrange.files.hdf5 import CHECKSUM
from lagrange.scene import read_scene
from tests.reference.kit import ENTRIES, command, environment, same_data, start_run, started_as
from tests.waiting import GIVE_UP, wait_until

SETTINGS = ("numerics.mesh_size_mm=2", "numerics.duration_ms=2")
OPTIONS = ["--mesh-size", "2", "--quiet"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*OPTIONS, "--duration", "2", "--output", str(path)]) == 0
    return path


def refused(arguments, capsys):
    assert run_main(arguments) == 2
    error = capsys.readouterr().err
    assert "Traceback" not in error
    return error


def test_samples_beyond_the_checkpoint_are_written_again(whole, tmp_path):
    """What a kill between flush and checkpoint leaves."""
    path, plan = tmp_path / "killed.nc", make_plan(read_scene(None, SETTINGS))
    state = plan.first_state()
    with ResultFile(path, plan, 0.0) as store:
        run(plan, store.append, stop=lambda: state.done >= 20, state=state)
        store.commit()
        save_checkpoint(path, state, store.stored)
        run(plan, store.append, stop=lambda: state.done >= 60, state=state)
        store.commit()
    assert run_main([*OPTIONS, "--duration", "2", "--output", str(path), "--resume"]) == 0
    assert same_data(path, whole)


def test_a_second_run_is_refused_and_after_a_kill_before_the_first_checkpoint_the_samples_stay(tmp_path, capsys):
    path = tmp_path / "run.nc"
    process = start_run(path)
    try:
        with h5py.File(path) as file:  # anyone may look on
            assert file.attrs["status"] == "running"
            assert np.all(np.isfinite(file["time"][: file.attrs["committed_samples"]]))
        assert "in use" in refused([*OPTIONS, "--duration", "1", "--output", str(path)], capsys)
    finally:
        process.kill()
        process.communicate(timeout=GIVE_UP)
    assert not checkpoint_path(path).exists()
    assert "nothing to resume" in refused([*OPTIONS, "--duration", "2000", "--output", str(path), "--resume"], capsys)
    with h5py.File(path) as file:
        assert file.attrs["committed_samples"] > 0


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
    return shutil.copy(whole, path)


FORGED_STATES = {
    "a hub of three coordinates": (lambda arrays, meta: arrays.update({"drive.hub": np.zeros(3)}), "damaged"),
    "numbers of another order of bytes": (
        lambda arrays, meta: arrays.update({"drive.hub": arrays["drive.hub"].astype(">f8")}), "damaged",
    ),
    "another model": (
        lambda arrays, meta: meta.update(numbers={"model": "0" * 64}), "meshes and matrices are not those computed",
    ),
    "another processor": (
        lambda arrays, meta: meta["versions"].update(processor="pentium-mmx"), "processor was 'pentium-mmx'",
    ),
    "numbers in place of text": (lambda arrays, meta: meta.update(scene=5), "damaged"),
}  # fmt: skip


@pytest.mark.parametrize("forgery", FORGED_STATES)
def test_a_forged_checkpoint_with_sound_checksums_is_refused_in_a_sentence(forgery, whole, tmp_path, capsys):
    change, words = FORGED_STATES[forgery]
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


# Runs that are stopped within a sample that takes long, and results that are taken away from under a run

LONG = ["--set", "numerics.output_interval_us=1e6", "--duration", "3000"]  # minutes a sample
STEADY = ["--mesh-size", "2", "--duration", "100000", "--checkpoint", "0"]


def started(path, *options):
    """A run whose result file is there."""
    run_fem = [*started_as("run-fem"), *options, "--quiet", "--output", str(path)]
    process = subprocess.Popen(run_fem, env=environment(), stderr=subprocess.PIPE, text=True)
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
    seldom = ("numerics.mesh_size_mm=2", "numerics.duration_ms=8", "numerics.output_interval_us=2000")
    plan = make_plan(read_scene(None, seldom))
    assert plan.looks > 20
    state, other = plan.first_state(), plan.first_state()
    asked = iter([False, True])
    state.stop = lambda: next(asked)
    assert state.advance(1).samples is None and state.done == 0
    for name, array in state.arrays.named().items():
        assert array.tobytes() == other.arrays.named()[name].tobytes(), name
    state.stop = lambda: False
    first, second = state.advance(1).samples, state.advance(1).samples
    for name, values in other.advance(2).samples.values.items():
        assert values[:1].tobytes() == first[name].tobytes() and values[1:].tobytes() == second[name].tobytes(), name


STRUCK = """
import os, signal, sys

def strike(event, arguments):
    if {condition}:
        os.kill(os.getpid(), signal.{signal})

sys.addaudithook(strike)
"""


def struck(name, number, condition, folder):
    """A command that a signal reaches at an event."""
    *python, program = started_as(name)
    program = STRUCK.format(signal=signal.Signals(number).name, condition=condition) + program
    return subprocess.run(
        [*python, program, "s.toml"], cwd=folder, env=environment(), capture_output=True, text=True, timeout=GIVE_UP
    )


@pytest.mark.parametrize(
    ("name", "number"), [("run-fem", signal.SIGTERM), ("run-fem", signal.SIGINT), ("run-study", signal.SIGTERM)]
)
def test_a_signal_before_there_is_a_run_ends_the_command_with_a_word(name, number, tmp_path):
    (tmp_path / "s.toml").write_text("")
    done = struck(name, number, 'event == "open" and str(arguments[0]).endswith("s.toml")', tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, "", "interrupted\n")
    assert [file.name for file in tmp_path.iterdir()] == ["s.toml"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("name", "module"), [*((name, "cyclopts") for name in ENTRIES), ("run-fem", "numpy"), ("check-residual", "numpy")]
)
def test_a_signal_while_a_command_is_loaded_ends_it_with_a_word_at_most(name, number, module, tmp_path):
    done = struck(name, number, f'event == "import" and arguments[0] == "{module}"', tmp_path)
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
            longer = f"{0.01 * int(file.attrs['committed_samples']) + 1:.2f}"
        assert run_main([*OPTIONS, "--duration", longer, "--resume", "--output", str(path)]) == 0


# kill -9 at random moments: numbers of calls to the system that write, sync or move, whatever the machine's load

KILLED = ["--duration", "12", "--checkpoint", "0", "--set", "output.fields_every_ms=1", "--output"]
BLOCK = 20  # samples between two checkpoints, of 1201
COUNTER = 8  # bytes, which reach a file whole
WRITE = os.write
LONGEST = 3000  # calls until a kill at the most; a block makes some 120


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*OPTIONS, *KILLED, str(path)]) == 0
    with h5py.File(path) as file:
        fields = {f"{GROUP}/{name}": variable[:] for name, variable in file[GROUP].items()}
        return {name: file[name][:] for name in columns_of("")} | fields


def killed_run(path, moment):
    """A leg of the run in a process of its own, which is killed in a call; whether it was before the leg's end."""
    child = os.fork()
    if child == 0:
        try:
            die_in_call(moment)
            resume = ["--resume"] if checkpoint_path(path).exists() else []
            os._exit(run_main([*OPTIONS, *KILLED, str(path), *resume]))
        finally:
            os._exit(70)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


def die_in_call(moment):
    """Have this process killed in its call of that number; of a longer write a part has been made by then."""
    calls = itertools.count()
    simulate.size_of_block = lambda *_: BLOCK

    def counted(call):
        def made(*arguments, **options):
            if next(calls) == moment:
                if call is WRITE and len(arguments[1]) > COUNTER:
                    call(arguments[0], arguments[1][: len(arguments[1]) // 2])
                os.kill(os.getpid(), signal.SIGKILL)
            return call(*arguments, **options)

        return made

    for name in ("write", "fsync", "replace"):
        setattr(os, name, counted(getattr(os, name)))


def samples_in(path, undisturbed):
    """How many samples a file holds, by plain h5py; all must be those of the undisturbed run."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        assert file.attrs["status"] in ("running", "complete")
        for name in columns_of(""):
            assert np.array_equal(file[name][:count], undisturbed[name][:count]), name
        frames = len(stored_samples(file, count))
        assert frames == len(range(0, count, 100))
        for name in ("time", "sample", "roller_displacement", "outer_ring_stress"):
            assert np.array_equal(file[GROUP][name][:frames], undisturbed[f"{GROUP}/{name}"][:frames]), name
    return count


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
@pytest.mark.parametrize("kills", [5, pytest.param(50, marks=pytest.mark.slow)])
def test_after_a_kill_at_a_random_moment_the_file_is_sound_and_the_run_goes_on_bit_for_bit(
    kills, undisturbed, tmp_path
):
    path, moments = tmp_path / "run.nc", np.random.default_rng(kills)
    done, before, grown = 0, 0, 0
    while done < kills:
        if not killed_run(path, int(moments.integers(LONGEST))):
            assert samples_in(path, undisturbed) == len(undisturbed["time"])
            path.unlink()
            checkpoint_path(path).unlink()
            before = 0
            continue
        done += 1
        count = samples_in(path, undisturbed) if path.exists() else 0
        grown += count > before
        before = count
    resume = ["--resume"] if checkpoint_path(path).exists() else []
    assert run_main([*OPTIONS, *KILLED, str(path), *resume]) == 0
    assert samples_in(path, undisturbed) == len(undisturbed["time"])
    assert grown >= kills // 2  # kills hit runs that were under way
    assert {entry.name for entry in tmp_path.iterdir()} == {"run.nc", "run.nc.checkpoint"}


# Result files with foreign or damaged fields: render-fem and --resume refuse them in a sentence

WITH_FIELDS = [*OPTIONS, "--set", "output.fields_every_ms=0.1", "--duration"]


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    path = tmp_path_factory.mktemp("fields") / "run.nc"
    assert run_main([*WITH_FIELDS, "0.2", "--output", str(path)]) == 0
    return path


def replaced(name, make=lambda *_: None):
    """Another variable of that name in the group of fields, or none."""

    def change(file, folder):
        old = file[GROUP].pop(name)[...] if name in file[GROUP] else None
        make(file[GROUP], name, old, folder)

    return change


def linked(group, name, old, folder):
    group[name] = h5py.ExternalLink(str(folder / "other.nc"), "/x")


def wide(group, name, old, folder):
    """Six thousand million columns of zeros in a few bytes."""
    shape = (*old.shape[:-2], 6 * 10**9, old.shape[-1])
    group.create_dataset(name, shape=shape, dtype=old.dtype, chunks=(1,) * (len(shape) - 2) + (2**20, 2), compression=9)


def fewer(group, name, old, folder):
    group[name] = old[..., :-1, :]


FORGED_FIELDS = {  # and whether they are tried with --resume, too
    "stresses in another file": (replaced("outer_ring_stress", linked), "link", True),
    "checksums in another file": (replaced(CHECKSUM, linked), "link", False),
    "more nodes than memory": (replaced("inner_ring_displacement", wide), "inner_ring_displacement", True),
    "fewer nodes than the mesh": (replaced("inner_ring_displacement", fewer), "its mesh has", True),
    "no checksums": (replaced(CHECKSUM), "checksum is missing", False),
    "a stress that has been changed": (lambda file, folder: file[GROUP]["roller_stress"].write_direct(
        np.zeros(file[GROUP]["roller_stress"].shape, "f4")), "checksum differs", False),
}  # fmt: skip


@pytest.mark.parametrize("forgery", FORGED_FIELDS)
def test_forged_fields_are_refused_in_a_sentence(forgery, with_fields, tmp_path, capsys):
    change, words, resumed = FORGED_FIELDS[forgery]
    path, target = tmp_path / "run.nc", tmp_path / "mesh.vtu"
    for suffix in ("", ".checkpoint"):
        shutil.copy(f"{with_fields}{suffix}", f"{path}{suffix}")
    with h5py.File(path, "r+") as file:
        change(file, tmp_path)
    before = path.read_bytes()
    assert render_main([str(path), "--export", str(target)]) == 2
    said = capsys.readouterr().err
    assert str(path) in said and words in said and said.count("\n") == 1
    assert not target.exists()
    if resumed:
        assert str(path) in refused([*WITH_FIELDS, "0.4", "--output", str(path), "--resume"], capsys)
        assert path.read_bytes() == before
