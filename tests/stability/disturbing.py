"""What befalls a run from outside, at a given one of the calls by which it brings data to the disk."""

import itertools
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path

from fem.solver import simulate

BLOCK = 20  # samples between two commits and checkpoints
CALLS = ("write", "fsync", "replace")
EVENTS = ("kill", "terminate", "interrupt", "full", "removed", "renamed")
AWAY = ".away"  # behind the name of a result that was renamed


def disturb(event: str, moment: int, result: Path) -> None:
    """Have an event befall this process in its call of that number, and commit every few samples."""
    calls = itertools.count(1)
    simulate.size_of_block = lambda *_: BLOCK

    def counted(call: Callable) -> Callable:
        def made(*arguments, **options):
            if next(calls) == moment:
                befall(event, result)
            return call(*arguments, **options)

        return made

    for name in CALLS:
        setattr(os, name, counted(getattr(os, name)))


def befall(event: str, result: Path) -> None:
    """The event itself; a result that is not there yet can't be taken away."""
    if event in ("kill", "terminate", "interrupt"):
        number = {"kill": signal.SIGKILL, "terminate": signal.SIGTERM, "interrupt": signal.SIGINT}[event]
        os.kill(os.getpid(), number)
    elif event == "full":
        room = result.stat().st_size // 2 if result.exists() else 1000
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    elif event == "removed":
        result.unlink(missing_ok=True)
    elif event == "renamed" and result.exists():
        result.rename(result.with_name(result.name + AWAY))
