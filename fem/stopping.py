"""Signals that end a command in good order, before a run or a study, during it and after."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of a run: undoes what Ctrl-C undoes."""


def hear_termination() -> None:
    """Turn SIGTERM into Terminated from now on; a second one ends the process at once."""

    def handle(number, frame):
        signal.signal(number, signal.SIG_DFL)
        raise Terminated

    signal.signal(signal.SIGTERM, handle)


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
