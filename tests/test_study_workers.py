"""Studies in several processes of this machine, which open no port, and on a real scheduler; some die or hang."""

import json
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import xarray

from fem.commands.run_study import study_main
from fem.study.folder import Folder
from tests.reference.kit import BASE, GRID, many, same
from tests.waiting import GIVE_UP, wait_until

TWO = BASE + '[parameters]\n"operation.speed_rpm" = [1500.0, 3000.0]\n[keep]\nsignals = ["inner_ay"]\n'
PATH = [entry for entry in sys.path if entry]
KEPT = Path("studies/study/points")
DEED = """
from fem.solver.rigid.state import LagrangianState

def advance(state, most, real=LagrangianState.advance):
    if state.plan.scene.operation.speed_rpm == 3000.0:
        {deed}
    return real(state, most)

LagrangianState.advance = advance
"""
CHILD = "import sys\nsys.path[:0] = {path!r}\n" + DEED + """
from fem.commands.run_study import study_main
if __name__ == "__main__":
    from fem.study import solving
    solving.GRACE = 3.0
    sys.exit(study_main(["study.toml", "--quiet", "--workers", "2"]))
"""
HANG = "import ctypes; ctypes.PyDLL(None).sleep(3600)"  # keeps even the interpreter's lock: it answers nobody


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return tmp_path


def solved(text, *words):
    Path("study.toml").write_text(text, encoding="utf-8")
    return study_main(["study.toml", "--quiet", *words])


def is_as_by_one_process(text):
    assert solved(text, "--workers", "1", "--output", "here") == 0
    same("studies/study/study.nc", "here/study.nc")


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
    assert solved(TWO, "--workers", "2") == 0
    assert len(processes) == 3 and not opened and not multiprocessing.active_children()
    is_as_by_one_process(TWO)


@pytest.mark.slow
@pytest.mark.parametrize(("deed", "status"), [
    ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "missing"), (HANG, "stopped"),
])  # fmt: skip
def test_a_process_that_dies_or_hangs_costs_its_own_point(deed, status, here):
    Path("run.py").write_text(CHILD.format(path=PATH, deed=deed), encoding="utf-8")  # the processes begin with it, too
    Path("study.toml").write_text(GRID + "[limits]\nseconds_per_point = 20.0\n", encoding="utf-8")
    done = subprocess.run([sys.executable, "run.py"], stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert status == "stopped" or "its process died (exit code -9)" in done.stderr
    with xarray.open_dataset("studies/study/study.nc") as found:
        assert (found.sel(speed_rpm=3000.0).status == status).all()
        assert (found.drop_sel(speed_rpm=3000.0).status == "complete").all()


@pytest.mark.slow
def test_processes_end_with_an_interrupted_study(here):
    Path("run.py").write_text(CHILD.format(path=PATH, deed="import time; time.sleep(3600)"), encoding="utf-8")
    Path("study.toml").write_text(GRID, encoding="utf-8")
    process = subprocess.Popen([sys.executable, "run.py"], stderr=subprocess.PIPE, text=True)
    wait_until(lambda: len(list(KEPT.glob("*.point"))) == 2, process)
    mine = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.send_signal(signal.SIGINT)
    assert process.wait(30) == 130
    assert "--resume goes on with the other 4" in process.stderr.read()
    wait_until(lambda: not any(is_alive(pid) for pid in mine))


def is_alive(pid):
    try:
        return bool(Path(f"/proc/{pid}/cmdline").read_bytes())  # empty: ended, and not asked for yet
    except OSError:
        return False


@pytest.fixture
def started(tmp_path):
    """Starts a program of dask with the tests' own import path; all are ended with the test."""
    pytest.importorskip("distributed")
    running = []

    def start(*words):
        log = open(tmp_path / f"log-{len(running)}", "w", encoding="utf-8")
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(PATH)}
        program = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
        running.append(subprocess.Popen(program, stderr=log, stdout=log, env=environment))
        return running[-1]

    yield start
    for process in reversed(running):
        process.kill()  # they hold nothing, and a worker without its scheduler waits long
    for process in running:
        process.wait(GIVE_UP)


@pytest.fixture
def scheduler(started, tmp_path):
    """Address of a scheduler."""
    file = tmp_path / "scheduler.json"
    started("dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file), "--host", "127.0.0.1")
    wait_until(lambda: file.exists() and file.read_text().endswith("}"))
    return json.loads(file.read_text())["address"]


def worker(started, address, *words):
    return started("dask_worker", address, "--nthreads", "1", "--no-dashboard", *(words or ("--no-nanny",)))


def test_two_workers_of_a_scheduler_give_what_one_process_gives(here, started, scheduler):
    """Three programs and two points: what CI has of a cluster. The slow tests below kill and hang them."""
    for _ in range(2):
        worker(started, scheduler)
    assert solved(TWO, "--scheduler", scheduler) == 0
    is_as_by_one_process(TWO)


def test_what_is_no_scheduler_is_named(here, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.setattr("fem.study.solving.CONNECT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        hangs = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in ("tcp://127.0.0.1:9", hangs, "tls://127.0.0.1:9", "ucx://a", "inproc://x", "tcp://", ""):
            assert solved(GRID, "--scheduler", address) == 2
            error = capsys.readouterr().err
            assert f"--scheduler {address}: does not answer: " in error and not error.endswith(": \n")
    assert not Path("studies").exists()  # the study has not begun


@pytest.mark.slow
def test_points_of_a_killed_worker_are_solved_by_another(here, started, scheduler):
    first, _ = worker(started, scheduler), worker(started, scheduler)

    def kill():
        wait_until(lambda: len(list(KEPT.glob("*.point"))) > 5)
        first.send_signal(signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    assert solved(many(40), "--scheduler", scheduler) == 0
    thread.join()
    assert first.wait(GIVE_UP) == -signal.SIGKILL
    is_as_by_one_process(many(40))


@pytest.mark.slow
def test_a_point_that_hangs_in_compiled_code_ends_by_its_limit_and_the_study_goes_on(
    here, started, scheduler, monkeypatch
):
    monkeypatch.setattr("fem.study.solving.GRACE", 3.0)
    Path("hanging.py").write_text(DEED.format(deed=HANG), encoding="utf-8")
    worker(started, scheduler, "--preload", str(here / "hanging.py"))
    assert solved(GRID + "[limits]\nseconds_per_point = 2.0\n", "--scheduler", scheduler) == 1
    with xarray.open_dataset("studies/study/study.nc") as found:
        hung = found.sel(speed_rpm=3000.0)
        assert (hung.status == "stopped").all()
        assert all("hung in compiled code" in str(text) for text in hung.message.values.ravel())
        assert (found.drop_sel(speed_rpm=3000.0).status == "complete").all()
