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
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from fem.kernels.kernel_folder import cache_folder
from tests.waiting import ASLEEP, limit_processor_time, wait_until

ENTRIES = {
    "run-fem": ("fem.commands.entry", "run_fem"), "check-residual": ("residual.cli", "check_residual"),
    "render-fem": ("fem.commands.entry", "render_fem"),
}  # fmt: skip
USUAL = (  # modules of what the commands do in tests
    "fem.runner", "fem.solver.elements.plan", "fem.solver.rigid.lagrangian", "fem.pictures.recover",
    "fem.commands.render_fem", "meshes.export", "residual.cli",
)  # fmt: skip
_forks = get_context("forkserver")
_forks.set_forkserver_preload(list(USUAL))


class Ended(NamedTuple):
    code: int | None  # None: not within its limit; negative: by that signal
    said: str  # on both outputs


def prepare(commands: list[list[str]], folder: Path, caches: Path) -> None:
    """Keep meshes and matrices in a folder for caches, compiled kernels where they are; load all that commands load.

    The commands are run in a folder for it, before the first fork.
    """
    if (kept := cache_folder()) is not None:
        os.environ["NUMBA_CACHE_DIR"] = str(kept.parent.parent)
    os.environ["XDG_CACHE_HOME"] = str(caches)
    modules = list(USUAL)
    for words in commands:
        program = (
            f"import sys; sys.argv = {words!r}\nfrom {{}} import {{}} as main\n"
            "try: main()\nfinally: print('loaded', *sorted(sys.modules))"
        ).format(*ENTRIES[words[0]])
        done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False)
        modules += done.stdout.rpartition("loaded ")[2].split()
    _forks.set_forkserver_preload([name for name in dict.fromkeys(modules) if not name.startswith("_")])


def run(
    words: list[str], folder: Path, limit: float, strace: list[str] | None = None, before: Callable | None = None
) -> Ended:
    """Run a command to its end, s of its own processor time at most; `strace`: under it, with these options.

    `before`, to be pickled, is called in its process before the command.
    """
    with tempfile.TemporaryFile("w+b") as output, tempfile.NamedTemporaryFile() as said:
        given = words, str(folder), dict(os.environ), said.name, limit, strace is not None, before
        process = _forks.Process(target=_command, args=given)
        process.start()
        tracer = None
        if strace is not None:
            status = Path(f"/proc/{process.pid}/status")
            wait_until(lambda: "State:\tT" in status.read_text(encoding="utf-8"), pause=0.002)  # has stopped itself
            tracer = subprocess.Popen(["strace", *strace, "-p", str(process.pid)], stdout=output, stderr=output)
            wait_until(lambda: "TracerPid:\t0\n" not in status.read_text(encoding="utf-8"), pause=0.002)
            os.kill(int(process.pid or 0), signal.SIGCONT)
        process.join(ASLEEP * limit)
        code = process.exitcode
        if code is None:
            process.kill()
            process.join()
        if tracer is not None:
            tracer.wait()
        text = Path(said.name).read_text(encoding="utf-8", errors="replace")
        return Ended(None if code == -signal.SIGXCPU else code, text)


def _command(words, folder, environment, said, limit, waits, before) -> None:
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


def samples_of(path: Path) -> dict[str, np.ndarray]:
    """All committed samples of a result, and what it knows of its run; the times of day are no part of them."""
    with h5py.File(path) as file:
        count = int(file.attrs["committed_samples"])
        known = {name: np.asarray(file.attrs[name]) for name in ("status", "committed_samples")}
        return known | {name: value[:count] for name, value in file.items() if isinstance(value, h5py.Dataset)}


def differing(found: dict[str, np.ndarray], whole: dict[str, np.ndarray]) -> list[str]:
    """Names of the variables whose samples are not the first ones of an undisturbed run's."""
    if found.keys() != whole.keys() or len(found["time"]) > len(whole["time"]):
        return ["another set of variables or samples"]
    names = sorted(found.keys() - {"status", "committed_samples"})
    return [name for name in names if found[name].tobytes() != whole[name][: len(found[name])].tobytes()]


def is_same(found: dict[str, np.ndarray], whole: dict[str, np.ndarray]) -> bool:
    """Whether a result has all of an undisturbed run's samples, to the last bit."""
    complete = len(found["time"]) == len(whole["time"]) and found["status"] == whole["status"]
    return bool(complete and not differing(found, whole))
