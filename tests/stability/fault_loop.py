"""Every call that a command makes of its own files fails once: `python -m tests.stability.fault_loop run`.

The n-th open, read, write, sync, rename, making of room or removal fails for n = 1, 2, 3 … with strace(1), which has to
be installed (Debian: apt-get install strace), as does the n-th allocation of memory. Commands are forked with their
libraries loaded (`forked`), and calls of libraries' own files and of compiled kernels are left alone. After each the
command must have

* ended with an exit code of its own, and without a traceback;
* left what was there before, or its replacement, sound, with no other samples than those of a run without faults;
* left files and caches from which the same command, without a fault, makes the same result to the last bit. Where
  they are, byte by byte, those left by an earlier trial, that one's answer holds.

As SQLite is tested: https://www.sqlite.org/testing.html#i_o_error_testing
"""

import csv
import hashlib
import json
import os
import shutil
import sys
import tempfile
import time
import zipfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cyclopts import App
from rich.console import Console

from fem.kernels.kernel_folder import cache_folder
from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.fault_calls import CALLS, COUNTED, calls_of, ends
from tests.stability.samples import differing, samples_of

EXITS = {0, 1, 2, 130, 143}
TIME_LIMIT = 120.0  # s of processor time, of one trial
SCENE = 'name = "s"\n[numerics]\nmesh_size_mm = 2.0\nduration_ms = 0.4\n'
COMMANDS = {
    "run": ["run-fem", "s.toml", "--quiet"],
    "resume": ["run-fem", "s.toml", "--quiet", "--resume", "--duration", "0.6", "--checkpoint", "0"],
    "lagrange": ["run-fem", "s.toml", "--model", "lagrange", "--quiet"],
    "check": ["check-residual", "runs/s.nc", "--no-figures", "--quiet"],
    "render": ["render-fem", "runs/s.nc", "--output", "s.png"],
}

app = App(help=__doc__)


@dataclass(frozen=True)
class Desk:
    """A folder with a scene and an earlier result, and caches of its own."""

    folder: Path

    @property
    def result(self) -> Path:
        return self.folder / "work" / "runs" / "s.nc"

    def prepared(self, model: "Desk | None") -> None:
        """Make it anew, as another one is."""
        shutil.rmtree(self.folder, ignore_errors=True)
        if model is not None:
            shutil.copytree(model.folder, self.folder, symlinks=True)
        else:
            (self.folder / "work").mkdir(parents=True)
            (self.folder / "work" / "s.toml").write_text(SCENE, encoding="utf-8")

    def run(self, command: list[str], strace: list[str] | None = None) -> forked.Ended:
        return forked.run(command, self.folder / "work", TIME_LIMIT, strace)


def state_of(folder: Path) -> str:
    """A digest of all files of a folder, without the times of day in them."""
    text = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "strace.log"):
        text.update(str(path.relative_to(folder)).encode() + b"\0")
        try:
            text.update(_timeless(path))
        except (OSError, KeyError, ValueError, zipfile.BadZipFile):
            text.update(path.read_bytes())
    return text.hexdigest()


def _timeless(path: Path) -> bytes:
    if path.suffix == ".nc":
        return b"".join(name.encode() + value.tobytes() for name, value in sorted(samples_of(path).items()))
    if path.suffix == ".checkpoint":
        with np.load(path) as arrays:
            meta = json.loads(arrays["meta"].tobytes()) | {"wall_seconds": 0.0}
            rest = (arrays[name].tobytes() for name in arrays.files if name != "meta")
            return b"".join([json.dumps(meta).encode(), *rest])
    return path.read_bytes()


@dataclass(frozen=True)
class Loop:
    """One command's trials: the desk as it was before, what the command makes of it, and what is known already."""

    name: str
    model: Desk
    desk: Desk
    whole: dict[str, np.ndarray]  # the result after the command without faults
    known: dict[str, str]  # of states left by a fault: what was wrong afterwards, or nothing

    def trial(self, kind: str, number: int) -> tuple[int, str]:
        """Let one call fail; the exit code, and what is wrong, or nothing."""
        desk = self.desk
        desk.prepared(self.model)
        calls, error = CALLS[kind]
        log = desk.folder / "strace.log"
        inject = f"inject={','.join(calls)}:error={error}:when={number}"
        # a pipe between a child and its parent is on no disk: of writes those of the command itself
        every = [] if kind == "write" else ["-f"]
        traced = [*every, "-qq", "-o", str(log), "-e", f"trace={','.join(calls)}", "-e", inject]
        done = desk.run(COMMANDS[self.name], traced)
        if done.code is None:
            return -1, "hangs"
        struck = "; ".join(line[:160] for line in log.read_text(errors="replace").splitlines() if "INJECTED" in line)
        if done.code not in EXITS:
            return done.code, f"exit {done.code}: {struck}: {done.said[-300:]}"
        if "Traceback" in done.said:
            return done.code, f"traceback: {struck}: {done.said[-600:]}"
        if done.code and not done.said:
            return done.code, f"exit {done.code} without a word: {struck}"
        try:
            if other := differing(samples_of(desk.result), self.whole):
                return done.code, f"the earlier result has other samples of {', '.join(other)}: {struck}"
        except (OSError, KeyError) as fault:
            return done.code, f"the earlier result: {fault}: {struck}"
        state = state_of(desk.folder)
        if state not in self.known:
            self.known[state] = self._afterwards()
        return done.code, self.known[state] and f"{self.known[state]}: {struck}"

    def _afterwards(self) -> str:
        """Whether the same command without a fault makes the same result."""
        again = self.desk.run(COMMANDS[self.name])
        if again.code != 0:
            return f"afterwards exit {again.code}: {again.said[-300:]}"
        found = samples_of(self.desk.result)
        whole = len(found["time"]) == len(self.whole["time"]) and found["status"] == self.whole["status"]
        return "" if whole and not differing(found, self.whole) else "afterwards another result"


@app.default
def main(
    command: str = "run",
    *,
    kinds: tuple[str, ...] = tuple(CALLS),
    alike: bool = True,
    output: Path | None = None,
    seconds: float = 1e9,
) -> None:
    """Let every call of a command fail once, print what came of it.

    Parameters
    ----------
    command: run, resume, lagrange, check or render
    kinds: of calls
    alike: all of the reads and writes that are alike, not only the first and the last of them
    output: CSV, a line a call; those that stand there are not repeated
    seconds: of wall time, after which no further call fails
    """
    console, until = Console(), time.monotonic() + seconds
    findings: list[str] = []
    rows = []
    with tempfile.TemporaryDirectory() as place:
        loop, log = prepared(Path(place), command)
        for kind in kinds:
            calls = calls_of(log, kind, str(loop.desk.folder))
            done = earlier(output, command, kind)
            before = len(findings)
            for number in calls if alike else ends(calls):
                if number not in done and time.monotonic() < until:
                    done[number] = loop.trial(kind, number)
                    if output is not None:
                        with output.open("a", newline="", encoding="utf-8") as file:
                            csv.writer(file, lineterminator="\n").writerow([command, kind, number, *done[number]])
                if wrong := done.get(number, (0, ""))[1]:
                    findings.append(f"{kind} {number}: {wrong}")
                    print(findings[-1], file=sys.stderr, flush=True)
            codes = Counter(code for code, _ in done.values())
            told = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
            tried = f"{codes.total()} of {len(calls)}, {len(set(calls.values()))} kinds"
            rows.append([command, kind, CALLS[kind][1], tried, told, str(len(findings) - before)])
            print(rows[-1], file=sys.stderr, flush=True)
    headings = ["command", "call", "error", "tried", "exit codes: times", "findings"]
    console.print(markdown_table(headings, rows), soft_wrap=True, markup=False)
    for finding in findings:
        console.print(finding, soft_wrap=True, markup=False)
    sys.exit(1 if findings else 0)


def earlier(output: Path | None, command: str, kind: str) -> dict[int, tuple[int, str]]:
    """Calls that a file tells of: number, exit code, what was wrong."""
    if output is None or not output.exists():
        return {}
    with output.open(newline="", encoding="utf-8") as file:
        return {int(n): (int(code), wrong) for *which, n, code, wrong in csv.reader(file) if which == [command, kind]}


def prepared(place: Path, command: str) -> tuple[Loop, Path]:
    """Desks in a folder, and strace's record of the command without a fault."""
    model, desk, log = Desk(place / "model"), Desk(place / "trial"), place / "strace.log"
    _first_run(model, desk, command)
    desk.prepared(model)
    desk.run(COMMANDS[command], ["-f", "-y", "-qq", "-o", str(log), "-e", f"trace={','.join(COUNTED)}"])
    return Loop(command, model, desk, samples_of(desk.result), {}), log


def _first_run(model: Desk, desk: Desk, command: str) -> None:
    """An earlier result in place, caches of meshes and matrices empty again."""
    kept = cache_folder()
    if kept is not None:  # kernels stay where they are kept: a copy of them would have to be made for each trial
        os.environ["NUMBA_CACHE_DIR"] = str(kept.parent.parent)
    os.environ |= {"XDG_CACHE_HOME": str(desk.folder / "cache"), "MPLCONFIGDIR": str(model.folder)}
    desk.prepared(None)
    first = COMMANDS["lagrange" if command == "lagrange" else "run"]
    forked.preload([first, COMMANDS[command]], desk.folder / "work")
    desk.prepared(None)
    desk.run(first)
    shutil.rmtree(desk.folder / "cache", ignore_errors=True)
    model.prepared(desk)


if __name__ == "__main__":
    app()
