"""Studies in several processes of this machine, which open no port; some of them die or hang."""

import multiprocessing
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import xarray

from fem.commands.run_study import study_main
from fem.study.folder import Folder
from tests.reference.small_study import BASE, GRID, same
from tests.waiting import wait_until

TWO = BASE + '[parameters]\n"operation.speed_rpm" = [1500.0, 3000.0]\n[keep]\nsignals = ["inner_ay"]\n'
CHILD = """
import sys
sys.path[:0] = {path!r}
from fem.solver.rigid.state import LagrangianState

def advance(state, most, real=LagrangianState.advance):
    if state.plan.scene.operation.speed_rpm == 3000.0:
        {deed}
    return real(state, most)

LagrangianState.advance = advance
from fem.commands.run_study import study_main
if __name__ == "__main__":
    from fem.study import workers
    workers.GRACE = 3.0
    sys.exit(study_main(["study.toml", "--quiet", "--workers", "2"]))
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return tmp_path


def listening(pid):
    """Ports on which a process takes connections."""
    links = (os.readlink(link) for link in Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink())
    sockets = {link.removeprefix("socket:[").rstrip("]") for link in links if link.startswith("socket:")}
    rows = [row.split() for name in ("tcp", "tcp6") for row in Path(f"/proc/net/{name}").read_text().splitlines()[1:]]
    return [row[1] for row in rows if row[3] == "0A" and row[9] in sockets]


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="Linux tells who listens")
def test_processes_give_what_one_gives_and_nobody_can_connect_to_them(here, monkeypatch):
    opened, processes, real = [], set(), Folder.add

    def add(*given):
        pids = [os.getpid(), *(child.pid for child in multiprocessing.active_children())]
        processes.update(pids)
        opened.extend(port for pid in pids for port in listening(pid))
        return real(*given)

    monkeypatch.setattr(Folder, "add", add)
    Path("study.toml").write_text(TWO, encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--workers", "2"]) == 0
    assert len(processes) == 3 and not opened and not multiprocessing.active_children()
    assert study_main(["study.toml", "--quiet", "--workers", "1", "--output", "here"]) == 0
    same("studies/study/study.nc", "here/study.nc")


DEEDS = {
    "dies": ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "missing"),
    "hangs": ("import ctypes; ctypes.PyDLL(None).sleep(3600)", "stopped"),  # keeps even the interpreter's lock
}


@pytest.mark.slow
@pytest.mark.parametrize("deed", DEEDS)
def test_a_process_that_dies_or_hangs_costs_its_own_point(deed, here):
    code, status = DEEDS[deed]
    path = [entry for entry in sys.path if entry]
    Path("run.py").write_text(CHILD.format(path=path, deed=code), encoding="utf-8")  # the processes begin with it, too
    Path("study.toml").write_text(GRID + "[limits]\nseconds_per_point = 20.0\n", encoding="utf-8")
    done = subprocess.run([sys.executable, "run.py"], stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert deed != "dies" or "its process died (exit code -9)" in done.stderr
    with xarray.open_dataset("studies/study/study.nc") as found:
        assert (found.sel(speed_rpm=3000.0).status == status).all()
        assert (found.drop_sel(speed_rpm=3000.0).status == "complete").all()


@pytest.mark.slow
def test_processes_end_with_an_interrupted_study(here):
    Path("run.py").write_text(
        CHILD.format(path=[entry for entry in sys.path if entry], deed="import time; time.sleep(3600)"),
        encoding="utf-8",
    )
    Path("study.toml").write_text(GRID, encoding="utf-8")
    process = subprocess.Popen([sys.executable, "run.py"], stderr=subprocess.PIPE, text=True)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    wait_until(lambda: len(list(Path("studies/study/points").glob("*.point"))) == 2, process)
    mine = children.read_text().split()
    process.send_signal(signal.SIGINT)
    assert process.wait(30) == 130
    assert "--resume goes on with the other 4" in process.stderr.read()
    wait_until(lambda: not any(_is_alive(pid) for pid in mine))


def _is_alive(pid):
    try:
        return bool(Path(f"/proc/{pid}/cmdline").read_bytes())  # empty: ended, and not asked for yet
    except OSError:
        return False
