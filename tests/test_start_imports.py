"""What starting a run loads: libraries that a scene doesn't need cost every start up to a second."""

import subprocess
import sys

import pytest

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
