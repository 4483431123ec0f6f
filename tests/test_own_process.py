"""A command in a process of its own: its exit code comes back, and a crash is told with what cures it."""

import os
import signal
import sys

import pytest

from fem.errors import UsageError
from fem.pictures.drawing_process import run_apart


def _ends_with_three():
    sys.exit(3)


def _ends_well():
    sys.exit(0)


def _crashes():
    os.kill(os.getpid(), signal.SIGSEGV)


def _is_killed():
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("command, code", [(_ends_well, 0), (_ends_with_three, 3), (_is_killed, 137)])
def test_the_exit_code_comes_back(command, code):
    assert run_apart(command) == code


def test_nothing_is_imported_from_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("multiprocessing", "pickle", "pyvista"):
        (tmp_path / f"{name}.py").write_text("import os\nos._exit(99)\n", encoding="utf-8")
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    monkeypatch.delenv("PYTHONPATH", raising=False)  # which may name the current folder
    assert run_apart(_ends_with_three) == 3
    assert "PYTHONSAFEPATH" not in os.environ


def test_a_crash_is_answered_with_what_cures_it():
    with pytest.raises(UsageError, match="can't draw off-screen") as caught:
        run_apart(_crashes)
    assert "apt-get install --no-install-recommends libgl1 libegl1" in str(caught.value)
