"""What starting a run loads: libraries that a scene doesn't need cost every start up to a second."""

import subprocess
import sys
from pathlib import Path

import pytest

import fem.kernels

HEAVY = "scipy.interpolate scipy.optimize scipy.signal scipy.stats matplotlib websockets fem.live".split()


@pytest.mark.parametrize(
    ("model", "more"),
    [("reduced", ["skfem", "scipy.sparse", "scipy.linalg", "scipy.special"]), ("lagrange", ["skfem"])],
)
def test_a_run_loads_nothing_that_its_scene_does_not_need(model, more, tmp_path):
    """The second run: the first one compiles its loop and keeps what it has computed of its bearing."""
    options = ["--quiet", "--force", "--model", model, "--output", str(tmp_path / "run.nc"), "--duration", "1"]
    program = (
        "import sys; from fem.commands.run_fem import run_main\n"
        f"code = run_main({options!r})\n"
        f"print(code, *(name for name in {HEAVY + more!r} if name in sys.modules))"
    )
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split() == ["0"], done.stderr


@pytest.mark.parametrize("loop", ["time_loop", "rigid.loop"])
def test_a_time_loop_loads_all_code_that_it_is_compiled_of(loop):
    """Code of a verb for a type that is not loaded when the loop is compiled is left out of it without a word."""
    names = {"cage", "housing_kernels", "shaft", "rigid.contacts"}
    if loop == "time_loop":
        kernels = Path(fem.kernels.__file__).parent
        names = {path.stem for path in kernels.glob("*.py") if ".of(" in path.read_text()} - {"jit", "tilted_patches"}
    needed = {f"fem.kernels.{name}" for name in names}
    program = f"import sys, fem.kernels.{loop}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert needed and needed <= set(loaded)
