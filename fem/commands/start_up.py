"""How a command begins and ends: signals, garbage, processes that libraries begin, missing packages, exit codes."""

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from importlib.util import find_spec
from typing import NoReturn

from fem.errors import UsageError

SAFE = "PYTHONSAFEPATH"
HELD = {signal.SIGINT, signal.SIGTERM}  # end a command in good order


@contextmanager
def from_no_current_folder() -> Iterator[None]:
    """Let Python processes that begin meanwhile import nothing from the current folder, whoever has put it there."""
    before = os.environ.get(SAFE)
    os.environ[SAFE] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE]
        else:
            os.environ[SAFE] = before


def need(package: str, user: str) -> None:
    """Refuse what needs a package that is not there, before any work for it is done.

    Errors
    ------
    UsageError: names the user, the package and the command that installs it.
    """
    if find_spec(package) is None:
        raise UsageError(f"{user}: needs {package}, which is not installed: python -m pip install {package}")


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of a run: undoes what Ctrl-C undoes."""


def hear_termination() -> None:
    """Turn SIGTERM into Terminated from now on; a second one ends the process at once."""

    def handle(number, frame):
        signal.signal(number, signal.SIG_DFL)
        raise Terminated

    signal.signal(signal.SIGTERM, handle)


def hold_signals(hold: bool = True) -> None:
    """Let both wait from now on: a command that is being loaded, or ends, can't answer them in good order."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK if hold else signal.SIG_UNBLOCK, HELD)


def hear_signals() -> None:
    """Take those that have waited, and those to come."""
    hold_signals(False)


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


@contextmanager
def importing() -> Iterator[None]:
    """Look for no garbage until all is `imported`: imports make much that stays, and hardly any garbage."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def imported() -> None:
    """Look for garbage from now on, but not in what there is: a first search of that takes 0.1 s."""
    gc.freeze()
    gc.enable()


def leave(code: int) -> NoReturn:
    """End the process without searching all that libraries have made once more."""
    hold_signals()
    gc.freeze()
    sys.exit(code)


def entry(main: Callable[[], int]) -> Callable[[], None]:
    """The entry point of a command, of which `main` gives the exit code."""

    def command() -> None:
        hear_termination()
        leave(main())

    return command


class Outcome(Enum):
    """How a command ends: exit code, message, and for runs the `status` in the result file."""

    COMPLETE = 0, "", "complete"
    FAILED = 1, "error: failed: {reason}\nsamples up to then are in {path}", "failed: {reason}"
    FAILED_AT_START = 1, "error: {reason}\nnothing was written", None
    UNUSABLE = 2, "error: {reason}", None
    ENDED = 130, "interrupted", None  # where there is no run
    ENDED_BY_TERM = 143, "interrupted", None
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
