"""Progress for people: a live bar on a terminal, a plain line now and then elsewhere."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fem.solver.solver import Plan, Progress

PLAIN_SECONDS = 10.0


@contextmanager
def progress_display(plan: Plan, quiet: bool) -> Iterator[Callable[[Progress], None]]:
    """Gives the function to call with every `Progress`."""
    total = 1e3 * (plan.n_samples - 1) * plan.interval
    with _display(plan.n_samples, quiet or plan.n_samples == 1) as show:

        def report(progress: Progress) -> None:
            pace = f"{progress.speed:,.0f} steps/s, energy imbalance {progress.imbalance:+.1e}"
            show(progress.samples, f"{1e3 * progress.simulated:.2f} of {total:.2f} ms, {pace}")

        yield report


@contextmanager
def count_display(what: str, total: int, quiet: bool) -> Iterator[Callable[[], None]]:
    """Gives the function to call after each of `total` things."""
    done = 0
    with _display(total, quiet) as show:

        def count() -> None:
            nonlocal done
            done += 1
            show(done, f"{what}: {done} of {total}")

        yield count


@contextmanager
def _display(total: int, quiet: bool) -> Iterator[Callable[[int, str], None]]:
    """Gives the function to call with how many of `total` steps are done, and words on them."""
    if quiet:
        yield lambda done, words: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
        with Bar(*columns, console=Console(stderr=True), transient=True) as display:
            task = display.add_task("", total=total)
            yield lambda done, words: display.update(task, completed=done, description=words)
    else:
        began, first = time.monotonic(), None  # a resumed run begins with samples
        last = began

        def show(done: int, words: str) -> None:
            nonlocal last, first
            first = done if first is None else min(first, done)
            if (now := time.monotonic()) - last > PLAIN_SECONDS:
                last = now
                left = (total - done) * (now - began) / max(done - first, 1)
                print(f"{words}, {left:.0f} s left", file=sys.stderr, flush=True)

        yield show
