"""Every call that a command makes of its own files fails once: `python -m tests.stability.fault_loop run`.

The n-th open, read, write, sync, rename, making of room or removal fails for n = 1, 2, 3 … with strace(1), which has to
be installed (Debian: apt-get install strace). Calls of the interpreter's and the libraries' own files are left alone,
and of compiled kernels: without them a trial takes a minute. After each the command must have

* ended with an exit code of its own, and without a traceback;
* left what was there before, or its replacement, sound;
* left caches from which the same command, without a fault, makes the same result to the last bit.

As SQLite is tested: https://www.sqlite.org/testing.html#i_o_error_testing
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from cyclopts import App
from rich.console import Console
from rich.progress import track
from rich.table import Table

from fem.kernels.kernel_folder import cache_folder

EXITS = {0, 1, 2, 130, 143}
TIME_LIMIT = 600.0  # s of wall time, of one trial
CALLS = {
    "open": (("open", "openat", "creat"), "EACCES"),
    "read": (("read", "pread64"), "EIO"),
    "write": (("write", "pwrite64"), "ENOSPC"),
    "sync": (("fsync", "fdatasync"), "EIO"),
    "rename": (("rename", "renameat", "renameat2"), "EACCES"),
    "room": (("fallocate", "ftruncate"), "ENOSPC"),
    "removal": (("unlink", "unlinkat"), "EPERM"),
}
SCENE = 'name = "s"\n[numerics]\nmesh_size_mm = 2.0\nduration_ms = 0.3\n'
COMMANDS = {
    "run": ["run-fem", "s.toml", "--quiet"],
    "lagrange": ["run-fem", "s.toml", "--model", "lagrange", "--quiet"],
    "check": ["check-residual", "runs/s.nc", "--quiet"],
    "render": ["render-fem", "runs/s.nc", "--output", "s.png"],
}
CALL = re.compile(r"^(\d+) +(\w+)\((.*)")  # thread, name, arguments and what it gave

app = App(help=__doc__)


@dataclass(frozen=True)
class Desk:
    """A folder with a scene and an earlier result, and caches of its own."""

    folder: Path

    def prepared(self, model: "Desk | None") -> None:
        """Make it anew, as another one is."""
        shutil.rmtree(self.folder, ignore_errors=True)
        if model is not None:
            shutil.copytree(model.folder, self.folder, symlinks=True)
        else:
            (self.folder / "work").mkdir(parents=True)
            (self.folder / "work" / "s.toml").write_text(SCENE, encoding="utf-8")

    def run(self, command: list[str], strace: list[str] | None = None) -> subprocess.CompletedProcess:
        words = [str(Path(sys.executable).parent / command[0]), *command[1:]]
        # kernels stay where they are kept: a copy of them would have to be made for each trial
        kept = cache_folder()
        environment = os.environ | {"XDG_CACHE_HOME": str(self.folder / "cache"), "MPLCONFIGDIR": str(self.folder)}
        if kept is not None:
            environment["NUMBA_CACHE_DIR"] = str(kept.parent.parent)
        return subprocess.run(
            [*(strace or []), *words], cwd=self.folder / "work", env=environment, capture_output=True, text=True,
            errors="replace", timeout=TIME_LIMIT, check=False,
        )  # fmt: skip


def calls_of(log: Path, kind: str, mine: str) -> list[int]:
    """Numbers of the first thread's calls of a kind that concern files below a folder."""
    names, first, number, found = CALLS[kind][0], None, 0, []
    for line in log.read_text(errors="replace").splitlines():
        match = CALL.match(line)
        if match is None:
            continue
        first = first or match[1]
        if match[1] != first or match[2] not in names:
            continue
        number += 1
        arguments = match[3].split("AT_FDCWD", 1)[-1]
        path = re.sub(r"^<[^>]*>", "", arguments)  # the current folder is not what is opened
        named = re.search(r'"([^"]*)"', path) if kind in ("open", "rename", "removal") else None
        place = os.path.join(mine, "work", named[1]) if named else arguments
        if mine in place and "site-packages" not in place:
            found.append(number)
    return found


def result_bytes(path: Path) -> dict[str, bytes]:
    """All numbers of a result; the times of day are no part of them."""
    with h5py.File(path) as file:
        return {name: np.asarray(file[name]).tobytes() for name in file if isinstance(file[name], h5py.Dataset)}


def trial(desk: Desk, model: Desk, name: str, kind: str, number: int, whole: dict[str, bytes]) -> tuple[int, str]:
    """Let one call fail; the exit code, and what is wrong, or nothing."""
    desk.prepared(model)
    calls, error = CALLS[kind]
    log = desk.folder / "strace.log"
    inject = f"inject={','.join(calls)}:error={error}:when={number}"
    words = ["strace", "-f", "--seccomp-bpf", "-qq", "-o", str(log), "-e", f"trace={','.join(calls)}", "-e", inject]
    try:
        done = desk.run(COMMANDS[name], words)
    except subprocess.TimeoutExpired:
        return -1, "hangs"
    struck = "; ".join(line[:160] for line in log.read_text(errors="replace").splitlines() if "INJECTED" in line)
    said = f"{done.stdout}{done.stderr}"
    if done.returncode not in EXITS:
        return done.returncode, f"exit {done.returncode}: {struck}: {said[-300:]}"
    if "Traceback" in said:
        return done.returncode, f"traceback: {struck}: {said[-600:]}"
    earlier = desk.folder / "work" / "runs" / "s.nc"
    try:
        with h5py.File(earlier) as file:
            str(file.attrs["status"])
    except (OSError, KeyError) as fault:
        return done.returncode, f"the earlier result: {fault}: {struck}"
    again = desk.run(COMMANDS[name])
    if again.returncode != 0:
        return done.returncode, f"afterwards exit {again.returncode}: {again.stderr[-300:]}: {struck}"
    if result_bytes(earlier) != whole:
        return done.returncode, f"afterwards another result: {struck}"
    return done.returncode, ""


@app.default
def main(command: str = "run", *, kinds: tuple[str, ...] = tuple(CALLS), every: int = 1) -> None:
    """Let every call of a command fail once, print what came of it.

    Parameters
    ----------
    command: run, lagrange, check or render
    kinds: of calls
    every: only each of so many calls
    """
    console = Console()
    findings: list[str] = []
    table = Table(title=" ".join(COMMANDS[command]), title_justify="left")
    for heading in ("call", "error", "times", "exit codes", "findings"):
        table.add_column(heading)
    with tempfile.TemporaryDirectory() as place:
        model, desk = Desk(Path(place) / "model"), Desk(Path(place) / "trial")
        whole = _first_run(model, command)
        desk.prepared(model)
        names = ",".join(name for calls, _ in CALLS.values() for name in calls)
        log = desk.folder / "strace.log"
        desk.run(COMMANDS[command], ["strace", "-f", "-y", "-qq", "-o", str(log), "-e", f"trace={names}"])
        recorded = {kind: calls_of(log, kind, str(desk.folder)) for kind in kinds}
        for kind, numbers in recorded.items():
            codes: Counter[int] = Counter()
            before = len(findings)
            for number in track(numbers[::every], kind, console=Console(stderr=True), transient=True):
                code, wrong = trial(desk, model, command, kind, number, whole)
                codes[code] += 1
                if wrong:
                    findings.append(f"{kind} {number}: {wrong}")
            told = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
            table.add_row(kind, CALLS[kind][1], str(codes.total()), told, str(len(findings) - before))
    console.print(table)
    for finding in findings:
        console.print(finding, soft_wrap=True, markup=False)
    sys.exit(1 if findings else 0)


def _first_run(model: Desk, command: str) -> dict[str, bytes]:
    """An earlier result in place, caches of meshes and matrices empty again."""
    model.prepared(None)
    first = COMMANDS["lagrange" if command == "lagrange" else "run"]
    done = model.run(first)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    shutil.rmtree(model.folder / "cache", ignore_errors=True)
    return result_bytes(model.folder / "work" / "runs" / "s.nc")


if __name__ == "__main__":
    app()
