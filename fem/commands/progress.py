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
    if quiet or plan.n_samples == 1:
        yield lambda progress: None
    elif sys.stderr.isatty():
        with _bar(plan) as show:
            yield show
    else:
        yield _plain_lines(plan)


@contextmanager
def _display(*columns):
    """A line of such columns on standard error that goes when it is done."""
    from rich.console import Console
    from rich.progress import Progress as RichProgress

    with RichProgress(*columns, console=Console(stderr=True), transient=True) as display:
        yield display


@contextmanager
def _bar(plan: Plan):
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn

    pace = "{task.fields[speed]} steps/s, energy imbalance {task.fields[imbalance]}"
    columns = (TextColumn("{task.fields[simulated]}"), BarColumn(), TaskProgressColumn(), TextColumn(pace))
    with _display(*columns, TimeRemainingColumn()) as display:
        task = display.add_task("", total=plan.n_samples, simulated="0 ms", speed="-", imbalance="-")

        def show(progress: Progress) -> None:
            display.update(
                task,
                completed=progress.samples,
                simulated=f"{1e3 * progress.simulated:.2f} ms",
                speed=f"{progress.speed:,.0f}",
                imbalance=f"{progress.imbalance:+.1e}",
            )

        yield show


@contextmanager
def count_display(what: str, total: int, quiet: bool) -> Iterator[Callable[[], None]]:
    """Gives the function to call after each of `total` things."""
    if quiet:
        yield lambda: None
    elif sys.stderr.isatty():
        from rich.progress import BarColumn, MofNCompleteColumn, TimeRemainingColumn

        with _display(what, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()) as display:
            task = display.add_task("", total=total)
            yield lambda: display.advance(task)
    else:
        yield _plain_count(what, total)


def _is_due() -> Callable[[], bool]:
    """Gives the function that says whether PLAIN_SECONDS have gone since the last line."""
    last = time.monotonic()

    def is_due() -> bool:
        nonlocal last
        if time.monotonic() - last < PLAIN_SECONDS:
            return False
        last = time.monotonic()
        return True

    return is_due


def _plain_count(what: str, total: int) -> Callable[[], None]:
    began, done, is_due = time.monotonic(), 0, _is_due()

    def show() -> None:
        nonlocal done
        done += 1
        if is_due():
            left = (total - done) * (time.monotonic() - began) / done
            print(f"{what}: {done} of {total}, {left:.0f} s left", file=sys.stderr, flush=True)

    return show


def _plain_lines(plan: Plan) -> Callable[[Progress], None]:
    total, is_due = (plan.n_samples - 1) * plan.interval, _is_due()

    def show(progress: Progress) -> None:
        if is_due():
            left = progress.steps_left / max(progress.speed, 1e-9)
            print(
                f"{1e3 * progress.simulated:.2f} of {1e3 * total:.2f} ms, {progress.speed:,.0f} steps/s, {left:.0f} s "
                f"left, energy imbalance {progress.imbalance:+.1e}",
                file=sys.stderr,
                flush=True,
            )

    return show
