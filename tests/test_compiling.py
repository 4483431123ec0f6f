"""The layer that compiles time loops: numba's private parts, one by one; a loop that is not compiled."""

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
from fem.interface import simulate
from fem.kernels import numba_private
from fem.kernels.jit import KernelCache, kernel, part
from fem.kernels.part_compiler import KernelCompiler, PartCompiler
from lagrange.scene.scene import read_scene

SHORT = ("numerics.duration_ms=0.02", "numerics.output_interval_us=10")


@part
def _twice(x):
    return x + x


@part
def _asked(x, other):
    if other is None:
        return x
    return x + other


def _kept(tmp_path):
    """A kernel is kept on disk and loaded by another dispatcher."""
    function = numba.njit(pipeline_class=KernelCompiler)(_plain)
    function._cache = KernelCache(_plain, tmp_path)
    assert function(2.0) == 6.0 and len(list(tmp_path.glob("*.nbc"))) == 1
    again = numba.njit(pipeline_class=KernelCompiler)(_plain)
    again._cache = KernelCache(_plain, tmp_path)
    assert again(2.0) == 6.0 and sum(again.stats.cache_hits.values()) == 1


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
    command = [sys.executable, "-m", "fem", *words, *(word for key in SHORT for word in ("--set", key))]
    subprocess.run(command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=True)
    compiled = simulate(read_scene(None, (f"model={model}", *SHORT)))
    with h5py.File(path) as found:
        for name in ("inner_x", "inner_y", "roller_rho", "inner_force", "energy_contact"):
            assert np.allclose(found[name][:], compiled[name], rtol=1e-9, atol=1e-15), name
