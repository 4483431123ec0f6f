"""What a run does whichever solver it is of: progress, signals, failures, going on bit for bit; foreign checkpoints."""

import errno
import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import time
from contextlib import nullcontext

import h5py
import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.result import checkpoint
from fem.result.checkpoint import checkpoint_path, save_checkpoint
from fem.result.run_file import GROUP, stored_samples
from fem.result.store import ResultFile
from fem.solver import row_state, simulate
from fem.solver.simulate import make_plan
from lagrange.columns import columns_of
from lagrange.files.hdf5 import CHECKSUM
from lagrange.scene.scene import read_scene
from tests.reference.kit import ENTRIES, attributes, command, environment, same_data, sets, started_as
from tests.stability.histories import disturb
from tests.waiting import GIVE_UP, wait_until

NO_CONTRACT = ("wall_seconds", "setup_seconds")  # attributes that differ from run to run
# 20 µm of clearance, dropped by the full load: contacts rattle, and the run restarts with half the step
RATTLE = sets("bearing.outer_raceway_diameter_mm=56.04", "numerics.start=rest", "numerics.output_interval_us=10",
              "numerics.load_ramp_ms=0")  # fmt: skip
CASES = {
    "finite elements": ["--model", "fem", "--mesh-size", "2"],
    "finite elements, fields": ["--mesh-size", "2", *sets("output.fields_every_ms=0.25")],
    "reduced": ["--model", "reduced"],
    "reduced that refines": ["--model", "reduced", *RATTLE, *sets("contact.friction_coefficient=0")],
    "Lagrangian": ["--model", "lagrange"],
    "Lagrangian, damped": ["--model", "lagrange", *sets("damping.contact_N_s_m=100")],
    "Lagrangian, free angles": ["--model", "lagrange", *sets("lagrange.angles=free")],
    "Lagrangian that refines": ["--model", "lagrange", *RATTLE],
}
REFINES = CASES["Lagrangian that refines"]
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES)
MODELS = "finite elements", "reduced", "Lagrangian"
each_model = pytest.mark.parametrize("case", [CASES[model] for model in MODELS], ids=MODELS)


@pytest.fixture(autouse=True)
def strict(monkeypatch):
    """A run restarts for less of the energy than usual: the steps lose 0.06 % where contacts rattle."""
    monkeypatch.setattr("fem.solver.guards.ENERGY_TOLERANCE", 3e-4)


def run(case, path, *options, duration="2"):
    return run_main([*case, "--duration", duration, "--output", str(path), "--force", *options])


def content(path):
    """All that a file says, but for the time it took: bytes of the variables, attributes."""
    with h5py.File(path) as file:
        found = {f"@{name}": file.attrs[name] for name in file.attrs if name not in NO_CONTRACT}
        file.visititems(lambda name, item: found.update({name: item[()].tobytes()} if hasattr(item, "dtype") else {}))
        return found


@each_case
@pytest.mark.parametrize("looks", [1, 17, pytest.param(130, marks=pytest.mark.slow), 201, 270])
def test_a_run_that_is_stopped_and_resumed_is_the_uninterrupted_one(case, looks, tmp_path, monkeypatch, capsys):
    refines = RATTLE[-1] in case
    if looks > 200 and not refines:
        pytest.skip("over by then")
    whole, path, before = tmp_path / "whole.nc", tmp_path / "stopped.nc", signal.getsignal(signal.SIGTERM)
    number, count = signal.SIGTERM if looks == 17 else signal.SIGINT, itertools.count(1)

    def watch(progress):  # a signal comes after so many blocks of one sample
        if next(count) == looks:
            os.kill(os.getpid(), number)

    assert run(case, whole, "--quiet") == 0
    with monkeypatch.context() as patch:
        patch.setattr("fem.runner.progress_display", lambda *_: nullcontext(watch))
        patch.setattr("fem.solver.simulate.BLOCK_SECONDS", 0.0)
        assert run(case, path, "--quiet") == 128 + number
    assert signal.getsignal(signal.SIGTERM) is before and attributes(path)["status"] == "interrupted"
    count = attributes(path)["committed_samples"]
    assert f"{count} samples are in {path}; to continue: the same command with --resume" in capsys.readouterr().err
    if refines and "reduced" in case and looks > 17:  # restarts as soon as its energy is lost
        assert 0 < count < looks
    else:
        assert count == looks % 201
    assert run(case, path, "--quiet", "--resume") == 0 and content(path) == content(whole)
    found = attributes(path)
    assert (found["status"], found["committed_samples"]) == ("complete", 201)
    # of the last pass: 14 a sample in place of 7, ten in place of five
    assert not refines or found["steps"] == (2800 if "lagrange" in case else 2000)
    if looks == 1:  # a complete run can be extended, too
        assert run(case, path, "--quiet", duration="0.7") == run(case, path, "--quiet", "--resume") == 0
        assert content(path) == content(whole)


@each_model
def test_a_run_shows_its_progress_and_its_end(case, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fem.commands.start_up.PLAIN_SECONDS", 0.0)
    path = tmp_path / "run.nc"
    assert run(case, path) == 0
    out, error = capsys.readouterr()
    line = re.compile(r"(\S+) of 2\.00 ms, [\d,]+ steps/s, energy imbalance \S+, \d+ s left")
    slow = "planning: ", "compiling "  # what a loaded machine makes a command say
    reached = [float(line.fullmatch(text)[1]) for text in error.splitlines() if not text.startswith(slow)]
    assert reached == sorted(reached) and reached[-1] == 2.0
    assert re.search(r"^2 ms in \S+ s \(\d+ steps\), energy imbalance \S+ of the exchanged energy", out, re.M)
    assert f"Result: {path}" in out
    assert run(case, path, "--resume") == 0  # tells its energy balance again
    balance = r"energy imbalance (\S+) of the exchanged"
    assert re.search(balance, capsys.readouterr().out)[1] == re.search(balance, out)[1]
    assert run(case, path, "--quiet") == 0 and capsys.readouterr() == ("", "")


@each_model
def test_a_static_scene_prints_its_equilibrium_and_a_dry_run_its_plan(case, here, capsys):
    assert run_main([*case, "--dry-run"]) == 0
    assert capsys.readouterr().out.startswith("Plan of paper, ") and not list(here.iterdir())
    assert run(case, "run.nc", duration="0") == 0
    out = capsys.readouterr().out
    with h5py.File("run.nc") as file:
        assert file["time"].shape == (1,) and file.attrs["steps"] == 0
        assert f"hub x {round(1e6 * file['inner_x'][0], 4) + 0.0:.4f} µm" in out and "Loaded rollers: " in out


@pytest.mark.parametrize("case", [CASES[model] for model in MODELS[::2]], ids=MODELS[::2])
def test_checkpoints_of_another_model_scene_or_version_are_refused(case, tmp_path, monkeypatch, capsys):
    path, fem = tmp_path / "run.nc", "fem" in case
    assert run(case, path, "--quiet") == 0
    other = "lagrange" if fem else "fem"
    words = {f"model={other}": f"model was '{case[1]}', now '{other}'",
             "operation.speed_rpm=4000": "operation.speed_rpm was 4500.0, now 4000.0"}  # fmt: skip
    for setting, difference in words.items():
        assert run(case[2:], path, "--resume", *sets(f"model={case[1]}", setting)) == 2
        assert difference in capsys.readouterr().err
    where = "fem.kernels.kernel_folder.version" if fem else "fem.solver.rigid.lagrangian.np.__version__"
    monkeypatch.setattr(where, (lambda: "other") if fem else "0.9")
    assert run(case, path, "--resume", duration="3") == 2
    told, name = capsys.readouterr().err, "kernels" if fem else "numpy"
    assert re.search(rf"another version of the program.* \({name} was '[\w.-]+', now '(other|0\.9)'\)", told)


def test_a_run_that_restarts_says_so_and_starts_its_file_anew(tmp_path, monkeypatch, capsys):
    path, killed, seen = tmp_path / "run.nc", tmp_path / "killed.nc", []
    restart = ResultFile.restart

    def watched(store, **given):
        shutil.copy(path, killed)
        shutil.copy(checkpoint_path(path), checkpoint_path(killed))
        restart(store, **given)
        seen.append(tuple(attributes(path)[name] for name in ("committed_samples", "time_step")))

    monkeypatch.setattr(ResultFile, "restart", watched)
    assert run(REFINES, path) == 0
    error = capsys.readouterr().err
    assert "contacts rattle: the step of 1.43e-06 s changes the energy by 0.057 %" in error and "restarts" in error
    assert seen == [(0, pytest.approx(5e-6 / 7.0))]
    assert 0.7e-6 < attributes(path)["time_step"] < attributes(path)["critical_time_step"]
    assert run(REFINES, killed, "--quiet", "--resume") == 0 and content(killed) == content(path) and len(seen) == 1


def test_where_no_refinement_is_left_rattling_is_warned_of_and_too_long_a_step_fails(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fem.solver.rigid.state.LagrangianState.most_halvings", 0)
    path = tmp_path / "run.nc"
    for option in ((), ("--resume",)):
        assert run(REFINES, path, "--quiet", *option) == 0
        error = capsys.readouterr().err
        assert error.startswith("warning: contacts rattle: the step of 1.43e-06 s")
        assert error.endswith("or add damping\n")
    monkeypatch.setattr("lagrange.step_size.LEAP", 3.0)
    assert run(CASES["Lagrangian"], path, *sets("numerics.output_interval_us=20")) == 1
    assert "error: failed: the forces met make a mode of " in capsys.readouterr().err
    assert attributes(path)["status"].startswith("failed: the forces met")


def test_a_run_that_restarts_without_room_for_its_state_is_not_resumed_from_an_old_one(tmp_path, monkeypatch):
    """The checkpoint of the first pass counts samples that are no longer there."""
    path, save = tmp_path / "run.nc", checkpoint.save_checkpoint

    def full(result, state, stored):
        if state.void_steps:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(checkpoint_path(path)))
        save(result, state, stored)

    monkeypatch.setattr("fem.runner.save_checkpoint", full)
    assert run(REFINES, path, "--checkpoint", "0", "--quiet") == 0 and not checkpoint_path(path).exists()


@pytest.mark.parametrize(("model", "duration", "words", "advice"), [
    ("lagrange", "60", "the motion overflowed by t = ", "lower time_step"),
    ("fem", "5", "", "lower numerics.time_step_safety"),
])  # fmt: skip
def test_a_failed_run_keeps_its_samples_and_says_why(model, duration, words, advice, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("lagrange.step_size.LEAP", 100.0)
    monkeypatch.setattr("fem.solver.elements.plan.critical_time_step", lambda *given: 1.2 * critical_time_step(*given))
    path = tmp_path / "run.nc"
    seldom = sets("numerics.start=rest", "numerics.output_interval_us=200", "lagrange.angles=free")
    options = [*(seldom if model == "lagrange" else ["--mesh-size", "2"]), "--checkpoint", "0"]
    assert run(["--model", model], path, *options, duration=duration) == 1
    error = capsys.readouterr().err
    assert f"error: failed: {words}" in error and f"samples up to then are in {path}" in error and advice in error
    assert "Traceback" not in error and (model == "lagrange" or re.search(r"step \d+, t = \S+ ms", error))
    with h5py.File(path) as file:
        count, found = file["time"].shape[0], dict(file.attrs)
        assert found["status"].startswith(f"failed: {words}") and 0 < count == found["committed_samples"] < 501
        assert all(np.all(np.isfinite(variable[:])) for variable in file.values())
        if model == "fem":
            assert found["steps"] == (count - 1) * round(1e-5 / found["time_step"])
            assert np.abs(file["inner_y"][:]).max() < 1e-5


def test_a_start_that_fails_or_is_interrupted_writes_nothing(tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise RuntimeError("no static equilibrium after 200 steps")

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("lagrange.first_state.static_equilibrium", fail)
    monkeypatch.setattr("fem.solver.rigid.lagrangian.static_equilibrium", fail)
    for option in ("--quiet", "--dry-run"):
        assert run(CASES["Lagrangian"], tmp_path / "run.nc", option) == 1
        assert "error: no static equilibrium after 200 steps\nnothing was written" in capsys.readouterr().err
    monkeypatch.setattr("lagrange.first_state.static_equilibrium", interrupt)
    assert run(CASES["Lagrangian"], tmp_path / "run.nc") == 130
    assert capsys.readouterr().err == "interrupted\n" and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("options", "words"), [
    (["--resume"], "nothing to resume"),
    (["--estimate-error", "--mesh-size", "3"], "--estimate-error compares with a coarser mesh"),
    (["--estimate-error", *sets("contact.model=penalty")], "no order of convergence"),
])  # fmt: skip
def test_what_an_option_lacks_is_told_before_a_run_is_planned(options, words, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("fem.runner.make_plan", lambda scene: pytest.fail("planned"))
    assert run_main(["--model", "fem", *options, "--output", str(tmp_path / "run.nc")]) == 2
    assert words in capsys.readouterr().err and not list(tmp_path.iterdir())


# Processes that are stopped, killed or told to end, and results that are taken away from under a run
COARSE = ["--mesh-size", "2", "--quiet"]
SETTINGS = ("numerics.mesh_size_mm=2", "numerics.duration_ms=2")
LONG = [*sets("numerics.output_interval_us=1e6"), "--duration", "3000"]  # minutes a sample
STEADY = ["--mesh-size", "2", "--duration", "100000", "--checkpoint", "0"]


def refused(arguments, capsys):
    assert run_main(arguments) == 2
    error = capsys.readouterr().err
    assert "Traceback" not in error
    return error


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("model", ["fem", "lagrange"])
def test_a_stopped_command_says_so_and_leaves_a_readable_file(model, number, tmp_path, capsys):
    path, killed = tmp_path / "long.nc", number is signal.SIGKILL
    process = started(path, "--mesh-size", "2", "--duration", "2000", "--model", model)
    wait_until(lambda: attributes(path)["committed_samples"] > 0, process, pause=0.1)
    try:
        with h5py.File(path) as file:
            assert file.attrs["status"] == "running"
            assert np.all(np.isfinite(file["time"][: file.attrs["committed_samples"]]))
        assert not killed or "in use" in refused([*COARSE, "--duration", "1", "--output", str(path)], capsys)
    finally:
        process.send_signal(number)
        _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == (-number if killed else 128 + number)
    assert killed or ("interrupted" in error and "Traceback" not in error)
    if killed:
        again = [*COARSE, "--model", model, "--duration", "2000", "--output", str(path), "--resume"]
        assert not checkpoint_path(path).exists() and "nothing to resume" in refused(again, capsys)
    with h5py.File(path) as file:
        count = int(file.attrs["committed_samples"])
        assert count > 0 and file.attrs["status"] == ("running" if killed else "interrupted")
        assert killed or count == file["time"].shape[0]
        assert np.all(np.isfinite(file["roller_x"][:count])) and np.all(np.diff(file["time"][:count]) > 0.0)


def started(path, *options):
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
    assert attributes(path)["status"] == "interrupted" and checkpoint_path(path).is_file()


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
sys.addaudithook(lambda event, arguments: os.kill(os.getpid(), {number}) if {condition} else None)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("name", "module"), [
    *((name, "cyclopts") for name in ENTRIES), ("run-fem", "numpy"), ("check-residual", "numpy"), ("run-fem", None),
    ("run-study", None),
])  # fmt: skip
def test_a_signal_before_there_is_a_run_ends_a_command_with_a_word(name, number, module, tmp_path):
    (tmp_path / "s.toml").write_text("")
    opened = 'event == "open" and str(arguments[0]).endswith("s.toml")'
    condition = f'event == "import" and arguments[0] == "{module}"' if module else opened
    *python, program = started_as(name)
    program = [*python, STRUCK.format(number=int(number), condition=condition) + program, "s.toml"]
    done = subprocess.run(program, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=GIVE_UP)
    assert (done.returncode, done.stdout) == (128 + number, "")
    short = done.stderr.count("\n") <= 1 and "Traceback" not in done.stderr
    assert done.stderr == "interrupted\n" or (module and short)
    assert [file.name for file in tmp_path.iterdir()] == ["s.toml"]


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
        longer = f"{0.01 * attributes(path)['committed_samples'] + 1:.2f}"
        assert run_main([*COARSE, "--duration", longer, "--resume", "--output", str(path)]) == 0


def test_samples_beyond_the_checkpoint_are_written_again(whole, tmp_path):
    path, plan = tmp_path / "killed.nc", make_plan(read_scene(None, SETTINGS))
    state = plan.first_state()
    with ResultFile(path, plan, 0.0) as store:
        simulate.run(plan, store.append, stop=lambda: state.done >= 20, state=state)
        store.commit()
        save_checkpoint(path, state, store.stored)
        simulate.run(plan, store.append, stop=lambda: state.done >= 60, state=state)
        store.commit()
    assert run_main([*COARSE, "--duration", "2", "--output", str(path), "--resume"]) == 0 and same_data(path, whole)


# kill -9 at random moments: numbers of calls to the system that write, sync or move, whatever the machine's load
KILLED = [*COARSE, "--duration", "12", "--checkpoint", "0", *sets("output.fields_every_ms=1"), "--output"]
LONGEST = 3000  # calls until a kill at the most; a block makes some 120


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*KILLED, str(path)]) == 0
    with h5py.File(path) as file:
        fields = {f"{GROUP}/{name}": variable[:] for name, variable in file[GROUP].items()}
        return {name: file[name][:] for name in columns_of("")} | fields


def leg(path):
    return run_main([*KILLED, str(path), *(["--resume"] if checkpoint_path(path).exists() else [])])


def killed_run(path, moment):
    """A leg of the run in a process of its own, killed in its call of that number; whether it was before its end."""
    child = os.fork()
    if child == 0:
        try:
            disturb("kill", moment, path)
            os._exit(leg(path))
        finally:
            os._exit(70)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


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


@pytest.mark.parametrize("kills", [5, pytest.param(50, marks=pytest.mark.slow)])
def test_after_a_random_kill_the_file_is_sound_and_the_run_goes_on_bit_for_bit(kills, undisturbed, tmp_path):
    path, moments = tmp_path / "run.nc", np.random.default_rng(kills)
    done, before, grown = 0, 0, 0
    while done < kills:
        killed = killed_run(path, int(moments.integers(LONGEST)))
        count = samples_in(path, undisturbed) if path.exists() else 0
        if not killed:
            assert count == len(undisturbed["time"])
            path.unlink()
            checkpoint_path(path).unlink()
            count = 0
        done, grown, before = done + killed, grown + (count > before), count
    assert leg(path) == 0 and samples_in(path, undisturbed) == len(undisturbed["time"])
    assert grown >= kills // 2  # kills hit runs that were under way
    assert {entry.name for entry in tmp_path.iterdir()} == {"run.nc", "run.nc.checkpoint"}


# Checkpoints and fields of a result file that others have made: refused in a sentence
def forged(whole, path, change):
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
        lambda arrays, meta: arrays.update({"drive.hub": arrays["drive.hub"].astype(">f8")}), "damaged"),
    "another model": (lambda arrays, meta: meta.update(numbers={"model": "0" * 64}),
                      "meshes and matrices are not those computed"),
    "another processor": (lambda arrays, meta: meta["versions"].update(processor="pentium-mmx"),
                          "processor was 'pentium-mmx'"),
    "numbers in place of text": (lambda arrays, meta: meta.update(scene=5), "damaged"),
}  # fmt: skip


@pytest.mark.parametrize("forgery", FORGED_STATES)
def test_a_forged_checkpoint_with_sound_checksums_is_refused_in_a_sentence(forgery, whole, tmp_path, capsys):
    change, words = FORGED_STATES[forgery]
    path = forged(whole, tmp_path / "run.nc", change)
    before = path.read_bytes()
    error = refused([*COARSE, "--duration", "4", "--output", str(path), "--resume"], capsys)
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
        done = command("run-fem", *COARSE, "--duration", "4", "--output", target, *resume)
        assert done.returncode == 0, done.stderr
    assert same_data(path, other)


WITH_FIELDS = [*COARSE, *sets("output.fields_every_ms=0.1"), "--duration"]


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    path = tmp_path_factory.mktemp("fields") / "run.nc"
    assert run_main([*WITH_FIELDS, "0.2", "--output", str(path)]) == 0
    return path


def replaced(name, make=lambda *_: None):

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
    "stresses in another file": (replaced("outer_ring_stress", linked), "outer_ring_stress is a link", True),
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
    assert str(path) in said and words in said and said.count("\n") == 1 and not target.exists()
    if resumed:
        assert str(path) in refused([*WITH_FIELDS, "0.4", "--output", str(path), "--resume"], capsys)
        assert path.read_bytes() == before
