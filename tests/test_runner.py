"""What a run does whichever solver it is of: progress, checkpoints, signals, failures, resuming bit for bit."""

import errno
import os
import re
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import get_args

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result import checkpoint
from fem.result.checkpoint import checkpoint_path
from fem.result.store import ResultFile
from fem.solver.simulate import SOLVERS
from lagrange.scene.scene import Scene
from tests.reference.kit import start_run
from tests.waiting import GIVE_UP

ROOT = Path(__file__).resolve().parent.parent
NO_CONTRACT = ("wall_seconds", "setup_seconds")  # attributes that differ from run to run
# 20 µm of clearance, dropped by the full load: contacts rattle, and the run restarts with half the step
RATTLE = ["--set", "bearing.outer_raceway_diameter_mm=56.04", "--set", "numerics.start=rest",
          "--set", "numerics.output_interval_us=10", "--set", "numerics.load_ramp_ms=0"]  # fmt: skip
CASES = {
    "finite elements": ["--model", "fem", "--mesh-size", "2"],
    "finite elements, fields": ["--mesh-size", "2", "--set", "output.fields_every_ms=0.25"],
    "reduced": ["--model", "reduced"],
    "reduced that refines": ["--model", "reduced", *RATTLE, "--set", "contact.friction_coefficient=0"],
    "Lagrangian": ["--model", "lagrange"],
    "Lagrangian, damped": ["--model", "lagrange", "--set", "damping.contact_N_s_m=100"],
    "Lagrangian, free angles": ["--model", "lagrange", "--set", "lagrange.angles=free"],
    "Lagrangian that refines": ["--model", "lagrange", *RATTLE],
    "toy": ["--model", "lagrange"],
}
MODELS = ("finite elements", "reduced", "Lagrangian", "toy")


@pytest.fixture(autouse=True)
def strict(monkeypatch):
    """A run restarts for less of the energy than usual: the steps lose 0.06 % where contacts rattle."""
    monkeypatch.setattr("fem.solver.rigid.lagrangian.ENERGY_TOLERANCE", 3e-4)


@pytest.fixture
def case(request, monkeypatch):
    """Arguments of a case; the toy stands in the place of the Lagrangian model."""
    if request.param == "toy":
        monkeypatch.setitem(SOLVERS, "lagrange", "tests.reference.compiled")
    return CASES[request.param]


each_case = pytest.mark.parametrize("case", CASES, indirect=True)
each_model = pytest.mark.parametrize("case", MODELS, indirect=True)


def run(case, path, *options, duration="2"):
    """The command's exit code."""
    return run_main([*case, "--duration", duration, "--output", str(path), "--force", *options])


def content(path):
    """All that a file says, but for the time it took: bytes of the variables, attributes."""
    with h5py.File(path) as file:
        found = {}
        file.visititems(
            lambda name, item: found.update({name: item[()].tobytes()} if isinstance(item, h5py.Dataset) else {})
        )
        return found | {f"@{name}": file.attrs[name] for name in file.attrs if name not in NO_CONTRACT}


@contextmanager
def interrupted_after(monkeypatch, looks, number=signal.SIGINT):
    """A signal comes after so many blocks of one sample."""
    count = 0

    @contextmanager
    def display(plan, quiet):
        def show(progress):
            nonlocal count
            count += 1
            if count == looks:
                os.kill(os.getpid(), number)

        yield show

    with monkeypatch.context() as patch:
        patch.setattr("fem.runner.progress_display", display)
        patch.setattr("fem.solver.simulate.BLOCK_SECONDS", 0.0)
        yield


@each_case
@pytest.mark.parametrize("looks", [1, 17, pytest.param(130, marks=pytest.mark.slow), 201, 270])
def test_a_run_that_is_stopped_and_resumed_is_the_uninterrupted_one(case, looks, tmp_path, monkeypatch, capsys):
    """201 samples; where the run refines, it is stopped in both passes and just between them."""
    refines = RATTLE[-1] in case
    if looks > 200 and not refines:
        pytest.skip("over by then")
    whole, path = tmp_path / "whole.nc", tmp_path / "stopped.nc"
    assert run(case, whole, "--quiet") == 0
    with interrupted_after(monkeypatch, looks):
        assert run(case, path, "--quiet") == 130
    with h5py.File(path) as file:
        assert file.attrs["status"] == "interrupted"
        count = int(file.attrs["committed_samples"])
    assert f"{count} samples are in {path}; to continue: the same command with --resume" in capsys.readouterr().err
    if refines and "reduced" in case and looks > 17:  # restarts as soon as its energy is lost
        assert 0 < count < looks
    else:
        assert count == looks % 201
    assert run(case, path, "--quiet", "--resume") == 0
    assert content(path) == content(whole)
    with h5py.File(path) as file:
        assert file.attrs["status"] == "complete" and file.attrs["committed_samples"] == 201
        # of the last pass: 14 a sample in place of 7, ten in place of five
        assert not refines or file.attrs["steps"] == (2800 if "lagrange" in case else 2000)


@each_case
def test_a_complete_run_can_be_extended(case, tmp_path):
    whole, path = tmp_path / "whole.nc", tmp_path / "short.nc"
    assert run(case, whole, "--quiet") == 0
    assert run(case, path, "--quiet", duration="0.7") == 0
    assert run(case, path, "--quiet", "--resume") == 0
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
    assert run(case, path, "--quiet") == 0
    assert capsys.readouterr() == ("", "")


@each_model
def test_a_static_scene_prints_its_equilibrium(case, tmp_path, capsys):
    path = tmp_path / "run.nc"
    assert run(case, path, duration="0") == 0
    out = capsys.readouterr().out
    with h5py.File(path) as file:
        assert file["time"].shape == (1,) and file.attrs["steps"] == 0
        assert f"hub x {round(1e6 * file['inner_x'][0], 4) + 0.0:.4f} µm" in out and "Loaded rollers: " in out


@each_model
def test_a_dry_run_shows_the_plan_and_writes_nothing(case, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_main([*case, "--dry-run"]) == 0
    assert capsys.readouterr().out.startswith("Plan of paper, ")
    assert not list(tmp_path.iterdir())


@each_model
def test_sigterm_in_the_run_has_its_own_exit_code(case, tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    before = signal.getsignal(signal.SIGTERM)
    with interrupted_after(monkeypatch, 50, signal.SIGTERM):
        assert run(case, path, "--quiet") == 143
    assert signal.getsignal(signal.SIGTERM) is before
    with h5py.File(path) as file:
        assert file.attrs["status"] == "interrupted" and file["time"].shape == (50,)


@pytest.mark.parametrize("case", ["finite elements", "Lagrangian"], indirect=True)
def test_checkpoints_of_another_model_or_scene_are_refused_by_the_difference(case, tmp_path, capsys):
    path = tmp_path / "run.nc"
    assert run(case, path, "--quiet") == 0
    other = "lagrange" if "fem" in case else "fem"
    words = {f"model={other}": f"model was '{case[1]}', now '{other}'",
             "operation.speed_rpm=4000": "operation.speed_rpm was 4500.0, now 4000.0"}  # fmt: skip
    for setting, difference in words.items():
        assert run(case[2:], path, "--resume", "--set", f"model={case[1]}", "--set", setting) == 2
        assert difference in capsys.readouterr().err


def test_the_lagrangian_model_refuses_a_state_of_another_numpy(tmp_path, monkeypatch, capsys):
    case, path = CASES["Lagrangian"], tmp_path / "run.nc"
    assert run(case, path, "--quiet") == 0
    monkeypatch.setattr("fem.solver.rigid.lagrangian.np.__version__", "0.9")
    assert run(case, path, "--resume") == 2
    assert " (numpy was " in capsys.readouterr().err


def test_a_run_that_restarts_says_so_and_starts_its_file_anew(tmp_path, monkeypatch, capsys):
    """A kill between its checkpoint and its new file leaves what can be resumed."""
    path, killed, seen = tmp_path / "run.nc", tmp_path / "killed.nc", []
    restart = ResultFile.restart

    def watched(store, **attributes):
        shutil.copy(path, killed)
        shutil.copy(checkpoint_path(path), checkpoint_path(killed))
        restart(store, **attributes)
        with h5py.File(path, locking=False) as file:
            seen.append((int(file.attrs["committed_samples"]), float(file.attrs["time_step"])))

    monkeypatch.setattr(ResultFile, "restart", watched)
    assert run(CASES["Lagrangian that refines"], path) == 0
    error = capsys.readouterr().err
    assert "contacts rattle: the step of 1.43e-06 s changes the energy by 0.057 %" in error and "restarts" in error
    assert seen == [(0, pytest.approx(5e-6 / 7.0))]
    with h5py.File(path) as file:
        assert 0.7e-6 < file.attrs["time_step"] < file.attrs["critical_time_step"]
    assert run(CASES["Lagrangian that refines"], killed, "--quiet", "--resume") == 0
    assert content(killed) == content(path) and len(seen) == 1


def test_where_no_refinement_is_left_rattling_is_warned_of_and_too_long_a_step_fails(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fem.solver.rigid.state.LagrangianState.most_halvings", 0)
    path = tmp_path / "run.nc"
    for option in ((), ("--resume",)):
        assert run(CASES["Lagrangian that refines"], path, "--quiet", *option) == 0
        error = capsys.readouterr().err
        assert error.startswith("warning: contacts rattle: the step of 1.43e-06 s") and error.endswith(
            "or add damping\n"
        )
    monkeypatch.setattr("lagrange.step_size.LEAP", 3.0)
    assert run(CASES["Lagrangian"], path, "--set", "numerics.output_interval_us=20") == 1
    assert "error: failed: the forces met make a mode of " in capsys.readouterr().err
    with h5py.File(path) as file:
        assert file.attrs["status"].startswith("failed: the forces met")


def test_a_run_that_restarts_without_room_for_its_state_is_not_resumed_from_an_old_one(tmp_path, monkeypatch):
    """The checkpoint of the first pass counts samples that are no longer there."""
    path = tmp_path / "run.nc"
    save = checkpoint.save_checkpoint

    def full(result, state, stored):
        if state.void_steps:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(checkpoint_path(path)))
        save(result, state, stored)

    monkeypatch.setattr("fem.runner.save_checkpoint", full)
    assert run(CASES["Lagrangian that refines"], path, "--checkpoint", "0", "--quiet") == 0
    assert not checkpoint_path(path).exists()


@pytest.mark.parametrize(
    ("case", "setting", "words"),
    [("Lagrangian", "lagrange.angles=free", "the motion overflowed by t = "),
     ("toy", "operation.speed_rpm=1e5", "the spring has broken")],
    indirect=["case"],
)  # fmt: skip
def test_a_failed_run_keeps_its_good_samples_and_says_why(case, setting, words, tmp_path, monkeypatch, capsys):
    """Of the finite elements see test_run_fem."""
    monkeypatch.setattr("lagrange.step_size.LEAP", 100.0)
    path = tmp_path / "run.nc"
    options = ["--set", "numerics.start=rest", "--set", "numerics.output_interval_us=200"]
    assert run(case, path, *options, "--set", setting, duration="60") == 1
    error = capsys.readouterr().err
    assert f"error: failed: {words}" in error and f"samples up to then are in {path}" in error
    with h5py.File(path) as file:
        assert file.attrs["status"].startswith(f"failed: {words}")
        assert 0 < file.attrs["committed_samples"] == file["time"].shape[0] < 301
        assert all(np.all(np.isfinite(variable[:])) for variable in file.values())


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
    assert capsys.readouterr().err == "interrupted\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("options", "words"), [
    (["--resume"], "nothing to resume"),
    (["--estimate-error", "--mesh-size", "3"], "--estimate-error compares with a coarser mesh"),
    (["--estimate-error", "--set", "contact.model=penalty"], "no order of convergence"),
])  # fmt: skip
def test_what_an_option_lacks_is_told_before_a_run_is_planned(options, words, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("fem.runner.make_plan", lambda scene: pytest.fail("planned"))
    assert run_main(["--model", "fem", *options, "--output", str(tmp_path / "run.nc")]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("case", ["Lagrangian", "toy"], indirect=True)
def test_a_model_without_a_mesh_refuses_to_estimate_its_error(case, tmp_path, capsys):
    assert run(case, tmp_path / "run.nc", "--estimate-error") == 2
    assert "--estimate-error: the " in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_every_model_that_a_scene_may_name_has_a_solver():
    assert get_args(Scene.model_fields["model"].annotation) == tuple(SOLVERS)


def test_the_command_names_its_models_without_loading_any():
    code = (
        "import sys; from fem.commands.run_fem import run_main; run_main(['--help']); "
        "print([name for name in ('numpy', 'numba', 'skfem', 'pydantic', 'h5py') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)},
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert all(f"{model}" in done.stdout for model in SOLVERS)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.skipif(os.name != "posix", reason="POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("model", ["fem", "lagrange"])
def test_a_stopped_command_says_so_and_leaves_a_readable_file(model, number, tmp_path):
    path, killed = tmp_path / "long.nc", number is signal.SIGKILL
    process = start_run(path, "--model", model)
    process.send_signal(number)
    _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == (-number if killed else 128 + number)
    assert killed or ("interrupted" in error and "Traceback" not in error)
    with h5py.File(path) as file:
        count = int(file.attrs["committed_samples"])
        assert count > 0 and file.attrs["status"] == ("running" if killed else "interrupted")
        assert killed or count == file["time"].shape[0]
        assert np.all(np.isfinite(file["roller_x"][:count])) and np.all(np.diff(file["time"][:count]) > 0.0)
