"""The commands in forks of a process that has their libraries loaded: many starts at a tenth of the price.

Each is the installed command's own function in a process of its own, with its arguments, folder and exit code; what
Python and libraries read while they start is over before it begins. Of the platforms with `fork` only.
"""

import importlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from tests.waiting import ASLEEP, limit_processor_time, wait_until

ENTRIES = {
    "run-fem": ("fem.commands.run_fem", "run_fem"),
    "check-residual": ("residual.cli", "check_residual"),
    "render-fem": ("fem.commands.render_fem", "render_fem"),
}

USUAL = (  # modules of what the commands do in tests
    "fem.runner", "fem.solver.elements.plan", "fem.solver.rigid.lagrangian", "fem.pictures.recover",
    "fem.commands.render_fem",     "meshes.export", "residual.cli",
)  # fmt: skip

_forks = get_context("forkserver")
_forks.set_forkserver_preload(list(USUAL))


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int | None  # None: not within its limit; negative: by that signal
    said: str  # on both outputs


def preload(commands: list[list[str]], folder: Path) -> None:
    """Load all that commands load, before the first fork; they are run in a folder for it."""
    modules = list(USUAL)
    for words in commands:
        module, function = ENTRIES[words[0]]
        program = (
            f"import sys; sys.argv = {words!r}\nfrom {module} import {function} as main\n"
            "try: main()\nfinally: print('loaded', *sorted(sys.modules))"
        )
        done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False)
        modules += done.stdout.rpartition("loaded ")[2].split()
    _forks.set_forkserver_preload([name for name in dict.fromkeys(modules) if not name.startswith("_")])


def run(
    words: list[str],
    folder: Path,
    limit: float,
    strace: list[str] | None = None,
    before: Callable[[], None] | None = None,
) -> Ended:
    """Run a command to its end, s of its own processor time at most; `strace`: under it, with these options.

    `before`, to be pickled, is called in its process before the command.
    """
    with tempfile.TemporaryFile("w+b") as output, tempfile.NamedTemporaryFile() as said:
        process = _forks.Process(
            target=_command, args=(words, str(folder), dict(os.environ), said.name, limit, strace is not None, before)
        )
        process.start()
        tracer = None
        if strace is not None:
            _awaits(process.pid, "State:\tT")  # has stopped itself
            tracer = subprocess.Popen(["strace", *strace, "-p", str(process.pid)], stdout=output, stderr=output)
            _awaits(process.pid, "TracerPid:\t", other_than="0\n")
            os.kill(int(process.pid or 0), signal.SIGCONT)
        process.join(ASLEEP * limit)
        code = process.exitcode
        if code is None:
            process.kill()
            process.join()
        elif code == -signal.SIGXCPU:
            code = None
        if tracer is not None:
            tracer.wait()
        return Ended(code, Path(said.name).read_text(encoding="utf-8", errors="replace"))


def _awaits(number: int | None, wanted: str, other_than: str = "\0") -> None:
    """Wait for an entry of a process's status."""
    status = Path(f"/proc/{number}/status")

    def is_so() -> bool:
        told = status.read_text(encoding="utf-8")
        return wanted in told and wanted + other_than not in told

    wait_until(is_so, pause=0.002)


def _command(
    words: list[str],
    folder: str,
    environment: dict[str, str],
    said: str,
    limit: float,
    waits: bool,
    before: Callable[[], None] | None,
) -> None:
    """What the fork does."""
    limit_processor_time(limit)
    with open(said, "ab") as output:
        for number in (1, 2):
            os.dup2(output.fileno(), number)
    os.environ.clear()  # what it was when the first fork was made
    os.environ |= environment
    os.chdir(folder)
    sys.argv = list(words)
    module, function = ENTRIES[words[0]]
    main = getattr(importlib.import_module(module), function)
    if before is not None:
        before()
    if waits:
        os.kill(os.getpid(), signal.SIGSTOP)
    with suppress(KeyboardInterrupt):
        main()
