"""The commands as a user has them: a process started from any folder, in which nothing of it is imported from there."""

import os
import subprocess
import sys
from pathlib import Path

import h5py

from tests.waiting import GIVE_UP, wait_until

ROOT = Path(__file__).resolve().parents[2]
ENTRIES = {
    "run-fem": "from fem.commands.entry import run_fem as main",
    "render-fem": "from fem.commands.entry import render_fem as main",
    "run-live": "from fem.commands.entry import run_live as main",
    "run-study": "from fem.commands.entry import run_study as main",
    "rate-bearing": "from fem.commands.entry import rate_bearing as main",
    "check-residual": "from residual.entry import check_residual as main",
}


def started_as(name: str) -> list[str]:
    """The first words of a command line."""
    return [sys.executable, "-P", "-c", f"{ENTRIES[name]}\nmain()"]


def environment(**more: object) -> dict[str, str]:
    """This process's, with the program to be found and more variables."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **{name: str(value) for name, value in more.items()}}


def command(name: str, *arguments: object, folder: Path | None = None, prepare=None, **variables: object):
    """Run a command to its end in a folder; `prepare` is called in its process before it begins."""
    return subprocess.run(
        [*started_as(name), *map(str, arguments)],
        cwd=folder,
        env=environment(**variables),
        preexec_fn=prepare,
        capture_output=True,
        text=True,
        timeout=GIVE_UP,
    )


def start_run(path, *options, duration="2000"):
    """The command in a process of its own, once it has committed samples."""
    run_fem = [sys.executable, "-m", "fem.commands.run_fem"]
    command = [*run_fem, "--mesh-size", "2", "--duration", duration, "--output", str(path)]
    process = subprocess.Popen([*command, *options], stderr=subprocess.PIPE, text=True)

    def has_committed() -> bool:
        try:
            with h5py.File(path, "r", locking=False) as file:
                return file.attrs["committed_samples"] > 0
        except (OSError, KeyError):
            return False

    wait_until(has_committed, process, pause=0.1)
    assert process.poll() is None, process.communicate()
    return process
