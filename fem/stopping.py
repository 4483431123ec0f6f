"""Signals that end a command in good order, before a run or a study, during it and after."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

HELD = {signal.SIGINT, signal.SIGTERM}


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of a run: undoes what Ctrl-C undoes."""


def hear_termination() -> None:
    """Turn SIGTERM into Terminated from now on; a second one ends the process at once."""

    def handle(number, frame):
        signal.signal(number, signal.SIG_DFL)
        raise Terminated

    signal.signal(signal.SIGTERM, handle)


def hold_signals() -> None:
    """Let both wait from now on: a command that is being loaded, or ends, can't answer them in good order."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, HELD)


def hear_signals() -> None:
    """Take those that have waited, and those to come."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HELD)


@contextmanager
def stop_signals() -> Iterator[list[int]]:
    """Ctrl-C and SIGTERM, listed as they come; a second one ends the process at once."""
    stopped: list[int] = []

    def handle(number, frame):
        stopped.append(number)
        signal.signal(number, signal.SIG_DFL)

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stopped
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
