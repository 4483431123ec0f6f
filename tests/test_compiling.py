"""The layer that compiles time loops, numba's private parts one by one; times to expect; plans after others."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numba
import numpy as np
import pytest

import fem
from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step, next_rung
from fem.interface import simulate
from fem.kernels import numba_private
from fem.kernels.jit import KernelCache, PartCompiler, kernel, part
from fem.kernels.part_compiler import KernelCompiler
from fem.solver import compiling
from fem.solver.compiling import seconds_by_trial
from fem.solver.elements import plan as elements
from fem.solver.simulate import SOLVERS, make_plan
from fem.statics import exact_statics
from lagrange.scene.scene import read_scene
from lagrange.surface import deviation, edges

TINY = ("numerics.duration_ms=0.02", "numerics.output_interval_us=10")


@part
def _twice(x):
    return x + x


@part
def _asked(x, other):
    return x if other is None else x + other


def _kept(tmp_path):
    for hits in (0, 1):
        function = numba.njit(pipeline_class=KernelCompiler)(_plain)
        function._cache = KernelCache(_plain, tmp_path)
        assert function(2.0) == 6.0 and len(list(tmp_path.glob("*.nbc"))) == 1
        assert sum(function.stats.cache_hits.values()) == hits


def _plain(x):
    return 3.0 * x


USES = {
    "_Cache, CompileResult._reduce, _rebuild, dumps": _kept,
    "KernelCompiler: DefaultPassBuilder, FunctionPass, DeadBranchPrune, dead_branch_prune, build_definitions": (
        lambda _: kernel(lambda x, other: _asked(x, other))(1.0, None) == 1.0
    ),
    "PartCompiler: NativeLowering, JITCodeLibrary, _dynfunc, compile_result, AbstractTemplate, infer_global": (
        lambda _: kernel(lambda x: _twice(x))(2.0) == 4.0 and issubclass(PartCompiler, KernelCompiler)
    ),
    "config.BOUNDSCHECK, DISABLE_JIT": lambda _: {"BOUNDSCHECK", "DISABLE_JIT"} <= {*dir(numba_private.config)},
}


@pytest.mark.parametrize("use", USES)
def test_a_private_part_of_numba_does_what_is_asked_of_it(use, tmp_path):
    try:
        assert USES[use](tmp_path) in (None, True)
    except Exception as error:
        pytest.fail(f"numba {numba.__version__} changed {use}: {error}")


def test_private_parts_of_numba_stand_in_one_module():
    root = Path(fem.__file__).parent
    private = re.compile(r"^\s*(from|import) numba\.(core|misc|np)|from numba import .*\b_dynfunc", re.M)
    texts = {path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in root.rglob("*.py")}
    assert [name for name, text in texts.items() if private.search(text)] == ["kernels/numba_private.py"]


@pytest.mark.parametrize("model", ["lagrange", "reduced"])
def test_a_loop_that_is_not_compiled_makes_the_same_run(model, tmp_path):
    path = tmp_path / "plain.nc"
    words = ["--model", model, "--quiet", "--output", str(path)]
    command = [sys.executable, "-m", "fem", *words, *(word for key in TINY for word in ("--set", key))]
    subprocess.run(command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=True)
    compiled = simulate(read_scene(None, (f"model={model}", *TINY)))
    with h5py.File(path) as found:
        for name in ("inner_x", "inner_y", "roller_rho", "inner_force", "energy_contact"):
            assert np.allclose(found[name][:], compiled[name], rtol=1e-9, atol=1e-15), name


# Times to expect are scaled by what runs have taken on this machine


def plan_of(*settings):
    return make_plan(read_scene(None, settings))


@pytest.fixture
def kept(tmp_path, monkeypatch):
    path = tmp_path / "pace.json"
    monkeypatch.setattr("fem.solver.compiling.pace_file", lambda: path)
    return path


def test_the_median_of_the_last_runs_that_tell_of_the_machine_counts_and_a_damaged_file_is_replaced(kept, monkeypatch):
    for expected, took in ((1.0, 0.001), (0.0, 5.0), (1.0, 1e6), (1e6, 1.0)):
        compiling.remember("fem", expected, took)
        assert not kept.exists(), (expected, took)
    for text in ("", "[]", "{", '{"a": 3}', '{"a": ["x"]}', "\x00"):
        kept.write_text(text, encoding="utf-8")
        assert compiling.pace("fem") == 1.0, text
        compiling.remember("fem", 1.0, 3.0)
        assert compiling.pace("fem") == 3.0, text
    for took in (30.0, 2.0, 2.2, 1.8, 2.0, 40.0):
        compiling.remember("reduced", 1.0 * compiling.pace("reduced"), took)
    assert compiling.pace("reduced") == pytest.approx(2.0)  # of 2, 2.2, 1.8, 2 and 40
    assert compiling.pace("fem") == 3.0
    monkeypatch.setattr("fem.solver.compiling.pace_file", lambda: kept / "pace.json")
    compiling.remember("fem", 1.0, 3.0)
    assert compiling.pace("fem") == 1.0, "a folder that can not be made"


@pytest.mark.parametrize("model", SOLVERS)
def test_every_model_expects_what_it_has_taken(model, kept):
    settings = f"model={model}", "numerics.mesh_size_mm=2"
    plain = plan_of(*settings).expected_seconds
    compiling.remember(model, plain, 3.0 * plain if plain > compiling.SHORTEST else 3.0)
    factor = compiling.pace(model)
    assert factor > 1.0 and plan_of(*settings).expected_seconds == pytest.approx(factor * plain)


def test_a_run_is_remembered_and_the_next_plan_says_so(kept, tmp_path, capsys, monkeypatch):
    """Its own time over what its plan expected: that of the processor, whatever else the machine does meanwhile."""
    monkeypatch.setattr("time.thread_time", (0.01 * k for k in range(100_000)).__next__)  # 10 ms a block of samples
    monkeypatch.setattr("fem.runner.seconds_by_trial", lambda plan: None)
    scene = ["--model", "reduced", "--duration", "200"]
    run_main([*scene, "--dry-run"])
    assert "no run has been timed on this machine yet" in capsys.readouterr().out
    plain = plan_of("model=reduced", "numerics.duration_ms=200").expected_seconds
    assert run_main([*scene, "--quiet", "--output", str(tmp_path / "a.nc")]) == 0
    (ratio,) = json.loads(kept.read_text(encoding="utf-8"))[compiling._key("reduced")]
    took = ratio * plain
    assert took == pytest.approx(round(took, 2)) and took >= compiling.SHORTEST
    run_main([*scene, "--dry-run"])
    told = capsys.readouterr().out
    assert f"about {took:.2g} s" in told and "timed here" not in told


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_piece_of_a_compiled_run_tells_how_long_it_and_its_compilation_take(kept, capsys, monkeypatch):
    plan, short = plan_of("model=reduced", "numerics.duration_ms=2"), "--model reduced --duration 2 --dry-run".split()
    plan.prepare()
    monkeypatch.setattr("time.thread_time", iter(range(0, 1000)).__next__)  # one second a block, here of a sample
    assert seconds_by_trial(plan) == plan.n_samples - 1 == 200
    assert run_main(short) == 0
    told = capsys.readouterr().out
    assert "about 2e+02 s (measured on a short piece)" in told and re.search(r"compilation: +none", told)
    # one without steps or with samples that take long is not tried
    long = "numerics.mesh_size_mm=2", "numerics.output_interval_us=1e6", "numerics.duration_ms=1e6"
    for settings in (("model=reduced", "numerics.duration_ms=0"), long):
        assert seconds_by_trial(plan_of(*settings)) is None
    new, take_steps = numba.njit(lambda x: x), type(plan.first_state()).take_steps

    def compiles(state, count):  # a part of the time loop that no cache holds
        new(1)
        return take_steps(state, count)

    monkeypatch.setattr(type(plan.first_state()), "take_steps", compiles)
    run_main(short)
    told = capsys.readouterr().out
    assert re.search(rf"compilation: +about {plan.compiling_seconds:.2g} s, perhaps three times that", told)
    assert seconds_by_trial(plan) is None and not new.signatures  # a dry run compiles nothing
    monkeypatch.setattr("time.process_time", iter((0.0, 57.0)).__next__)
    plan.prepare()
    assert new.signatures and plan.compiling == "about 57 s"


# What planning keeps in memory: a plan made after others is, bit for bit, the one that is made first

SPALLED = {"spall.0.body": "roller", "spall.0.roller": 2, "spall.0.width_mm": 1.3, "spall.0.angle_deg": 12.0}
BEFORE = (
    {"operation.radial_load_N": 700.0, "operation.speed_rpm": 900.0, "operation.first_roller_deg": 7.0},
    {"spall.0.body": "outer_ring", "spall.0.width_mm": 0.7, "operation.radial_load_N": 2400.0},
)


def start_of(scene) -> list[bytes]:
    plan = make_plan(scene)
    arrays, numbers = plan.first_state().to_keep()
    text = json.dumps([plan.time_step, plan.critical_time_step, numbers])
    return [text.encode(), *(array.tobytes() for array in arrays.values())]


def forget() -> None:
    for kept in (elements._built, exact_statics._kept_series, deviation.profiles, edges._table):
        kept.cache_clear()


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
@pytest.mark.parametrize("changes", [{"operation.radial_load_N": 1350.0}, SPALLED], ids=["load", "spall"])
def test_a_plan_after_others_is_a_fresh_one_bit_for_bit(model, changes):
    base = read_scene(None, (f"model={model}", "numerics.mesh_size_mm=2", "numerics.duration_ms=0.1"))
    forget()
    fresh = start_of(base.varied(changes))
    forget()
    for before in BEFORE:
        start_of(base.varied(before))
    assert start_of(base.varied(changes)) == fresh


def test_forces_of_one_octave_share_few_critical_steps_on_the_safe_side():
    forces = np.geomspace(300.0, 600.0, 50, endpoint=False)
    rungs = np.array([next_rung(force) for force in forces])
    assert np.all(rungs >= forces) and np.all(rungs < 1.1 * forces) and len(set(rungs.tolist())) <= 9
    model = elements.model_of(read_scene(None, ("numerics.mesh_size_mm=2",)))
    exact, shared = critical_time_step(model, 330.0), critical_time_step(model, next_rung(330.0))
    assert 0.99 * exact < shared <= exact
