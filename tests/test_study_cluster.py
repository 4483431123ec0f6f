"""Studies on a cluster: a real scheduler with workers as processes of their own, some of which are killed."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import xarray

from fem.commands.run_study import study_main
from tests.reference.small_study import BASE, GRID, many, same
from tests.waiting import GIVE_UP, wait_until

pytest.importorskip("distributed")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fem.study.figures.study_figures", lambda *_: [])
    return tmp_path


@pytest.fixture
def started(tmp_path):
    """Starts a program of dask with the tests' own import path; all are ended with the test."""
    running = []

    def start(*words):
        path = os.pathsep.join(entry for entry in sys.path if entry)
        log = open(tmp_path / f"log-{len(running)}", "w", encoding="utf-8")
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], stderr=log, stdout=log,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
        running.append(process)
        return process

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
    text = BASE + '[parameters]\n"operation.speed_rpm" = [1500.0, 3000.0]\n[keep]\nsignals = ["inner_ay"]\n'
    Path("study.toml").write_text(text, encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler]) == 0
    assert study_main(["study.toml", "--quiet", "--workers", "1", "--output", "here"]) == 0
    same("studies/study/study.nc", "here/study.nc")


def test_what_is_no_scheduler_is_named(here, monkeypatch, capsys):
    monkeypatch.setattr("fem.study.workers.CONNECT", 0.5)
    Path("study.toml").write_text(GRID, encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes connections and says nothing
        hangs = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in ("tcp://127.0.0.1:9", hangs, "tls://127.0.0.1:9", "ucx://a", "inproc://x", "tcp://", ""):
            assert study_main(["study.toml", "--quiet", "--scheduler", address]) == 2
            said = capsys.readouterr().err
            assert f"--scheduler {address}: does not answer: " in said and not said.endswith(": \n")
    assert not Path("studies").exists()  # the study has not begun


@pytest.mark.slow
def test_points_of_a_killed_worker_are_solved_by_another(here, started, scheduler):
    first, _ = worker(started, scheduler), worker(started, scheduler)
    Path("study.toml").write_text(many(40), encoding="utf-8")
    kept = Path("studies/study/points")

    def kill():
        wait_until(lambda: len(list(kept.glob("*.point"))) > 5)
        first.send_signal(signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler]) == 0
    thread.join()
    assert first.wait(GIVE_UP) == -signal.SIGKILL
    assert study_main(["study.toml", "--quiet", "--workers", "1", "--output", "here"]) == 0
    same("studies/study/study.nc", "here/study.nc")


HANGING = """
import ctypes
from fem.solver.rigid.state import LagrangianState

def advance(state, most, real=LagrangianState.advance):
    if state.plan.scene.operation.speed_rpm == 3000.0:
        ctypes.PyDLL(None).sleep(3600)  # keeps even the interpreter's lock: the worker answers nobody
    return real(state, most)

LagrangianState.advance = advance
"""


@pytest.mark.slow
def test_a_point_that_hangs_in_compiled_code_ends_by_its_limit_and_the_study_goes_on(
    here, started, scheduler, monkeypatch
):
    monkeypatch.setattr("fem.study.workers.GRACE", 3.0)
    Path("hanging.py").write_text(HANGING, encoding="utf-8")
    worker(started, scheduler, "--preload", str(here / "hanging.py"))
    Path("study.toml").write_text(GRID + "[limits]\nseconds_per_point = 2.0\n", encoding="utf-8")
    assert study_main(["study.toml", "--quiet", "--scheduler", scheduler]) == 1
    with xarray.open_dataset("studies/study/study.nc") as found:
        hung = found.sel(speed_rpm=3000.0)
        assert np.all(hung.status == "stopped")
        assert all("hung in compiled code" in str(text) for text in hung.message.values.ravel())
        assert np.all(found.drop_sel(speed_rpm=3000.0).status == "complete")
