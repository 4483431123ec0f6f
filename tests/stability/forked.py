"""Work in forks of a process that has the program loaded: many starts at a tenth of the price, and a crash or a hang is
an outcome, not the end. Of the platforms with `fork` only."""

import os
import signal
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

from tests.waiting import ASLEEP, limit_processor_time

_forks = get_context("forkserver")
_forks.set_forkserver_preload(
    ["fem.runner", "fem.solver.elements.plan", "fem.solver.rigid.lagrangian", "meshes.export", "residual.evaluation"]
)


class Ended(NamedTuple):
    code: int | None  # None: not within its limit; negative: by that signal
    said: str  # on both outputs
    answer: Any  # what was returned; None: nothing


def run(work: Callable, *given: Any, limit: float) -> Ended:
    """Call a function, to be pickled, in a process of its own, which may take so many s of processor time."""
    answers = _forks.SimpleQueue()
    with tempfile.NamedTemporaryFile() as said:
        process = _forks.Process(target=_work, args=(work, given, dict(os.environ), said.name, limit, answers))
        process.start()
        process.join(ASLEEP * limit)
        code = process.exitcode
        if code is None:
            process.kill()
            process.join()
        text = Path(said.name).read_text(encoding="utf-8", errors="replace")
    return Ended(None if code == -signal.SIGXCPU else code, text, None if answers.empty() else answers.get())


def _work(work, given, environment, said, limit, answers) -> None:
    limit_processor_time(limit)
    with open(said, "ab") as output:
        for number in (1, 2):
            os.dup2(output.fileno(), number)
    os.environ.clear()  # what it was when the first fork was made
    os.environ |= environment
    answers.put(work(*given))


def run_fem(words: list[str], folder: Path, before: Callable[[], None] | None = None) -> None:
    """The installed command's own function, with its arguments, folder and exit code; `before` is called before it."""
    from fem.commands import entry

    os.chdir(folder)
    sys.argv = ["run-fem", *words]
    if before is not None:
        before()
    with suppress(KeyboardInterrupt):
        entry.run_fem()
