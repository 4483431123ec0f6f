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

import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
import time
import zipfile
from collections import Counter, defaultdict
from collections.abc import Hashable
from contextlib import suppress
from pathlib import Path

import numpy as np
from cyclopts import App

from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.campaign import Lines
from tests.stability.forked import samples_of

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
CALLS = {
    "open": (("open", "openat", "creat"), "EACCES"), "read": (("read", "pread64"), "EIO"),
    "write": (("write", "pwrite64"), "ENOSPC"), "sync": (("fsync", "fdatasync"), "EIO"),
    "rename": (("rename", "renameat", "renameat2"), "EACCES"), "room": (("fallocate", "ftruncate"), "ENOSPC"),
    "removal": (("unlink", "unlinkat"), "EPERM"), "memory": (("mmap",), "ENOMEM"),
}  # fmt: skip
STEPS = CALLS["sync"][0] + CALLS["rename"][0]  # what divides a command's work into stretches
CALL = re.compile(r"^(\d+) +(\w+)\((.*)")  # thread, name, arguments and what it gave
DRAWN = re.compile(r"[0-9a-f]{8,}|[a-z0-9_]{8}(?=\.part)")  # what is another each time in a file's name
LOG = "strace.log"


def calls_of(log: Path, kind: str, mine: str) -> dict[int, Hashable]:
    """Numbers of the first thread's calls of a kind that concern files below a folder, and what is alike in them.

    Reads and writes are alike that are of the same file and of the same order of length, and between the same two
    syncs or renames of the command. No other call is like another.
    """
    names, first, number, stretch, found = CALLS[kind][0], None, 0, 0, dict[int, Hashable]()
    for match in filter(None, map(CALL.match, log.read_text(errors="replace").splitlines())):
        thread, name, arguments = match.groups()
        first = first or thread
        if thread == first:
            stretch += name in STEPS
            number += name in names
            if name in names and _concerns(arguments, kind, mine):
                found[number] = number
                if kind in ("read", "write"):
                    file, length = re.search(r"<([^>]*)>", arguments), re.search(r", (\d+)(, \d+)?\) += ", arguments)
                    size = int(length[1]).bit_length() if length else 0
                    found[number] = stretch, name, DRAWN.sub("#", file[1]) if file else "", size
    return found


def _concerns(arguments: str, kind: str, mine: str) -> bool:
    """Whether a call is of the command's own files; of memory, that which the loader of libraries does not ask for."""
    if kind == "memory":
        return "MAP_ANONYMOUS" in arguments and "MAP_FIXED" not in arguments
    arguments = arguments.split("AT_FDCWD", 1)[-1]
    path = re.sub(r"^<[^>]*>", "", arguments)  # the current folder is not what is opened
    named = re.search(r'"([^"]*)"', path) if kind in ("open", "rename", "removal") else None
    place = os.path.join(mine, "work", named[1]) if named else arguments
    return mine in place and "site-packages" not in place


def state_of(folder: Path) -> str:
    """A digest of all files of a folder, without the times of day in them."""
    text = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file() and path.name != LOG):
        parts = [path.read_bytes()]
        with suppress(OSError, KeyError, ValueError, zipfile.BadZipFile):
            if path.suffix == ".nc":
                parts = [name.encode() + value.tobytes() for name, value in sorted(samples_of(path).items())]
            if path.suffix == ".checkpoint":
                with np.load(path) as arrays:
                    meta = json.loads(arrays["meta"].tobytes()) | {"wall_seconds": 0.0}
                    parts = [arrays[name].tobytes() for name in arrays.files if name != "meta"]
                    parts.append(json.dumps(meta).encode())
        text.update(str(path.relative_to(folder)).encode() + b"\0" + b"".join(parts))
    return text.hexdigest()


class Loop:
    """One command's trials: a desk, that is a folder with a scene, an earlier result and caches; and it as it was."""

    def __init__(self, place: Path, command: str):
        self.model, self.desk, self.log = place / "model", place / "trial", place / LOG
        self.words, self.result = COMMANDS[command], self.desk / "work" / "runs" / "s.nc"
        os.environ["MPLCONFIGDIR"] = str(place / "matplotlib")
        first = COMMANDS["lagrange" if command == "lagrange" else "run"]
        (self.model / "work").mkdir(parents=True)
        (self.model / "work" / "s.toml").write_text(SCENE, encoding="utf-8")
        self.laid()
        forked.prepare([first, self.words], self.desk / "work", self.desk / "cache")
        self.laid()
        self.run(first)
        shutil.rmtree(self.desk / "cache", ignore_errors=True)
        shutil.rmtree(self.model)
        shutil.copytree(self.desk, self.model, symlinks=True)
        self.laid()
        every = ",".join(name for calls, _ in CALLS.values() for name in calls)
        self.run(self.words, ["-f", "-y", "-qq", "-o", str(self.log), "-e", f"trace={every}"])
        self.whole = samples_of(self.result)  # the result after the command without faults
        self.known: dict[str, str] = {}  # of states left by a fault: what was wrong afterwards, or nothing

    def laid(self) -> None:
        shutil.rmtree(self.desk, ignore_errors=True)
        shutil.copytree(self.model, self.desk, symlinks=True)

    def run(self, words: list[str], strace: list[str] | None = None) -> forked.Ended:
        return forked.run(words, self.desk / "work", TIME_LIMIT, strace)

    def trial(self, kind: str, number: int) -> tuple[int, str]:
        """Let one call fail; the exit code, and what is wrong, or nothing."""
        self.laid()
        (calls, error), log = CALLS[kind], self.desk / LOG
        inject = f"inject={','.join(calls)}:error={error}:when={number}"
        # a pipe between a child and its parent is on no disk: of writes those of the command itself
        every = [] if kind == "write" else ["-f"]
        traced = [*every, "-qq", "-o", str(log), "-e", f"trace={','.join(calls)}", "-e", inject]
        code, said = self.run(self.words, traced)
        if code is None:
            return -1, "hangs"
        struck = "; ".join(line[:160] for line in log.read_text(errors="replace").splitlines() if "INJECTED" in line)
        if code not in EXITS:
            return code, f"exit {code}: {struck}: {said[-300:]}"
        if "Traceback" in said:
            return code, f"traceback: {struck}: {said[-600:]}"
        if code and not said:
            return code, f"exit {code} without a word: {struck}"
        try:
            if other := forked.differing(samples_of(self.result), self.whole):
                return code, f"the earlier result has other samples of {', '.join(other)}: {struck}"
        except (OSError, KeyError) as fault:
            return code, f"the earlier result: {fault}: {struck}"
        if (state := state_of(self.desk)) not in self.known:  # whether the same command makes the same result
            again = self.run(self.words)
            self.known[state] = f"afterwards exit {again.code}: {again.said[-300:]}" if again.code != 0 else ""
            if again.code == 0 and not forked.is_same(samples_of(self.result), self.whole):
                self.known[state] = "afterwards another result"
        return code, self.known[state] and f"{self.known[state]}: {struck}"


app = App(help=__doc__)


@app.default
def main(
    command: str = "run", *, kinds: tuple[str, ...] = tuple(CALLS), alike: bool = True, output: Path | None = None,
    seconds: float = 1e9,
) -> None:  # fmt: skip
    """Let every call of a command fail once, print what came of it.

    Parameters
    ----------
    command: run, resume, lagrange, check or render
    kinds: of calls
    alike: all of the reads and writes that are alike, not only the first and the last of them
    output: CSV, a line a call; those that stand there are not repeated
    seconds: of wall time, after which no further call fails
    """
    lines, until, findings, rows = Lines(output), time.monotonic() + seconds, [], []
    with tempfile.TemporaryDirectory() as place:
        loop = Loop(Path(place), command)
        for kind in kinds:
            calls, before = calls_of(loop.log, kind, str(loop.desk)), len(findings)
            done = {int(n): (int(code), wrong) for *which, n, code, wrong in lines.rows if which == [command, kind]}
            groups = defaultdict(list)
            for number, same in calls.items():
                groups[number if alike else same].append(number)
            for number in sorted({number for numbers in groups.values() for number in (numbers[0], numbers[-1])}):
                if number not in done and time.monotonic() < until:
                    done[number] = loop.trial(kind, number)
                    lines.add(command, kind, number, *done[number])
                if wrong := done.get(number, (0, ""))[1]:
                    findings.append(f"{kind} {number}: {wrong}")
                    print(findings[-1], file=sys.stderr, flush=True)
            codes = Counter(code for code, _ in done.values())
            times = ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
            tried = f"{codes.total()} of {len(calls)}, {len(set(calls.values()))} kinds"
            rows.append([command, kind, CALLS[kind][1], tried, times, str(len(findings) - before)])
            print(rows[-1], file=sys.stderr, flush=True)
    print(markdown_table(["command", "call", "error", "tried", "exit codes: times", "findings"], rows))
    print(*findings, sep="\n")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    app()
