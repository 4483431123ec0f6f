"""What the commands of this package share beside `lagrange.commands`: signals in a run, outcomes, packages."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from functools import partial
from importlib.util import find_spec

from lagrange.commands import HELD
from lagrange.commands import run_app_main as run_any_main
from lagrange.errors import UsageError

MOST_THREADS = 4096


def need(package: str, user: str) -> None:
    """Refuse what needs a package that is not there, before any work for it is done.

    Errors
    ------
    UsageError: names the user, the package and the command that installs it.
    """
    if find_spec(package) is None:
        raise UsageError(f"{user}: needs {package}, which is not installed: python -m pip install {package}")


@contextmanager
def stop_signals() -> Iterator[list[int]]:
    """Ctrl-C and SIGTERM, listed as they come; a second one ends the process at once."""
    stopped: list[int] = []

    def handle(number, frame):
        stopped.append(number)
        signal.signal(number, signal.SIG_DFL)

    before = {number: signal.signal(number, handle) for number in HELD}
    try:
        yield stopped
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Outcome(Enum):
    """How a run ends: exit code, message, and the `status` in the result file."""

    COMPLETE = 0, "", "complete"
    FAILED = 1, "error: failed: {reason}\nsamples up to then are in {path}", "failed: {reason}"
    FAILED_AT_START = 1, "error: {reason}\nnothing was written", None
    INTERRUPTED = 130, "interrupted at {time:.3f} ms; {left}", "interrupted"
    TERMINATED = 143, "interrupted at {time:.3f} ms; {left}", "interrupted"
    # of a complete run whose error was to be estimated
    ESTIMATE_FAILED = (
        1, "error: the run on the coarser mesh failed: {reason}\n{path} is complete, without an estimate", None,
    )  # fmt: skip
    ESTIMATE_INTERRUPTED = 130, "interrupted; {path} is complete, without an estimate", None
    ESTIMATE_TERMINATED = 143, "interrupted; {path} is complete, without an estimate", None

    def __init__(self, code: int, text: str, status: str | None):
        self.code, self._text, self._status = code, text, status

    def sentence(self, **facts: object) -> str:
        """What to tell the user."""
        return self._text.format(**facts)

    def status(self, reason: object = "") -> str:
        """What the result file says of it."""
        return self._status.format(reason=reason)


def _check_environment() -> None:
    """Refuse settings with which the time loops can't be loaded."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        raise UsageError("NUMBA_DISABLE_JIT is set, and the time loops can't run without being compiled; unset it")
    threads = os.environ.get("NUMBA_NUM_THREADS")
    if threads is not None and not (threads.isascii() and threads.isdigit() and 1 <= int(threads[:9]) <= MOST_THREADS):
        raise UsageError(f"NUMBA_NUM_THREADS = {threads}: must be a whole number from 1 to {MOST_THREADS}; or unset it")


run_app_main = partial(run_any_main, before=_check_environment)


def standard_bearing(designation: str | None) -> tuple[str, ...]:
    """The setting that --bearing stands for."""
    return () if designation is None else (f'bearing={{designation="{designation}"}}',)
