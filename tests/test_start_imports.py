"""What starting a run loads: libraries that a scene doesn't need cost every start up to a second."""

import subprocess
import sys

import pytest

HEAVY = "scipy.interpolate scipy.optimize scipy.signal scipy.stats matplotlib websockets fem.live".split()


@pytest.mark.parametrize(
    ("model", "more"), [("reduced", ["skfem", "scipy.sparse", "scipy.linalg"]), ("lagrange", ["skfem"])]
)
def test_a_run_loads_nothing_that_its_scene_does_not_need(model, more, tmp_path):
    options = ["--quiet", "--model", model, "--output", str(tmp_path / "run.nc"), "--duration", "1"]
    program = (
        "import sys; from fem.cli import run_main\n"
        f"code = run_main({options!r})\n"
        f"print(code, *(name for name in {HEAVY + more!r} if name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.split() == ["0"], done.stderr
