"""What the commands share beside `lagrange.commands`: signals in a run, outcomes, packages, progress."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from functools import partial
from importlib.util import find_spec
from threading import Timer
from typing import TYPE_CHECKING

from lagrange.commands import HELD
from lagrange.commands import run_app_main as run_any_main
from lagrange.errors import UsageError

if TYPE_CHECKING:
    from fem.solver.solver import Plan, Progress

MOST_THREADS = 4096
PLAIN_SECONDS = 10.0  # between lines of progress where there is no terminal


def need(package: str, user: str) -> None:
    """Refuse what needs a package that is not there, before any work for it is done. UsageError: names the user, the
    package and the command that installs it."""
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
    FAILED_AT_START = 1, "error: {reason}\nnothing was written", ""
    INTERRUPTED = 130, "interrupted at {time:.3f} ms; {left}", "interrupted"
    TERMINATED = 143, "interrupted at {time:.3f} ms; {left}", "interrupted"
    # of a complete run whose error was to be estimated
    ESTIMATE_FAILED = (
        1, "error: the run on the coarser mesh failed: {reason}\n{path} is complete, without an estimate", "",
    )  # fmt: skip
    ESTIMATE_INTERRUPTED = 130, "interrupted; {path} is complete, without an estimate", ""
    ESTIMATE_TERMINATED = 143, "interrupted; {path} is complete, without an estimate", ""

    def __init__(self, code: int, sentence: str, status: str):
        self.code, self.sentence, self.status = code, sentence, status

    @classmethod
    def by(cls, signals: list[int], of: str = "") -> "Outcome":
        """Of what the first of these signals has ended; `of` : "ESTIMATE_", an estimate."""
        return cls[f"{of}TERMINATED" if signals[0] == signal.SIGTERM else f"{of}INTERRUPTED"]


def _check_environment():  # refuse settings with which the time loops can't be loaded
    threads = os.environ.get("NUMBA_NUM_THREADS")
    if threads is not None and not (threads.isascii() and threads.isdigit() and 1 <= int(threads[:9]) <= MOST_THREADS):
        raise UsageError(f"NUMBA_NUM_THREADS = {threads}: must be a whole number from 1 to {MOST_THREADS}; or unset it")


run_app_main = partial(run_any_main, before=_check_environment)


def standard_bearing(designation: str | None) -> tuple[str, ...]:
    """The setting that --bearing stands for."""
    return () if designation is None else (f'bearing={{designation="{designation}"}}',)


@contextmanager
def progress_display(plan: "Plan", quiet: bool) -> "Iterator[Callable[[Progress], None]]":
    """Gives the function to call with every `Progress`."""
    total = 1e3 * (plan.n_samples - 1) * plan.interval
    with _display(plan.n_samples, quiet or plan.n_samples == 1) as show:

        def report(progress):
            pace = f"{progress.speed:,.0f} steps/s, energy imbalance {progress.imbalance:+.1e}"
            show(progress.samples, f"{1e3 * progress.simulated:.2f} of {total:.2f} ms, {pace}")

        yield report


@contextmanager
def count_display(what: str, total: int, quiet: bool, after: float = 0.0) -> Iterator[Callable[[], None]]:
    """Gives the function to call after each of `total` things; shows nothing in the first seconds, `after`."""
    done = 0
    with _display(total, quiet, after) as show:

        def count():
            nonlocal done
            done += 1
            show(done, f"{what}: {done} of {total}")

        yield count


@contextmanager
def _display(total, quiet, after=0.0):
    """Gives what to call with how many of `total` steps are done, and words on them: a live bar on a terminal, a plain
    line now and then elsewhere."""
    if quiet:
        yield lambda done, words: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
        display = Progress(*columns, console=Console(stderr=True), transient=True)
        task, begin = display.add_task("", total=total), Timer(after, display.start)
        begin.start()
        try:
            yield lambda done, words: display.update(task, completed=done, description=words)
        finally:
            begin.cancel()
            begin.join()
            display.stop()
    else:
        began, first = time.monotonic(), None  # a resumed run begins with samples
        last = began

        def show(done, words):
            nonlocal last, first
            first = done if first is None else min(first, done)
            if (now := time.monotonic()) - last > PLAIN_SECONDS:
                last, left = now, (total - done) * (now - began) / max(done - first, 1)
                print(f"{words}, {left:.0f} s left", file=sys.stderr, flush=True)

        yield show
