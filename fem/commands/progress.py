"""Progress for people: a live bar on a terminal, a plain line now and then elsewhere."""

import sys
import time
from collections.abc import Callable
from contextlib import contextmanager

from fem.solver.solver import Plan, Progress

PLAIN_SECONDS = 10.0


@contextmanager
def progress_display(plan: Plan, quiet: bool):
    """Gives the function to call with every `Progress`."""
    if quiet or plan.n_samples == 1:
        yield lambda progress: None
    elif sys.stderr.isatty():
        with _bar(plan) as show:
            yield show
    else:
        yield _plain_lines(plan)


@contextmanager
def _bar(plan: Plan):
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as RichProgress

    columns = (
        TextColumn("{task.fields[simulated]}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[speed]} steps/s, energy imbalance {task.fields[imbalance]}"),
        TimeRemainingColumn(),
    )
    with RichProgress(*columns, console=Console(stderr=True), transient=True) as display:
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
def count_display(what: str, total: int, quiet: bool):
    """Gives the function to call after each of `total` things."""
    if quiet:
        yield lambda: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        columns = (what, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with RichProgress(*columns, console=Console(stderr=True), transient=True) as display:
            task = display.add_task("", total=total)
            yield lambda: display.advance(task)
    else:
        yield _plain_count(what, total)


def _plain_count(what: str, total: int) -> Callable[[], None]:
    began = last = time.monotonic()
    done = 0

    def show() -> None:
        nonlocal last, done
        done += 1
        now = time.monotonic()
        if now - last > PLAIN_SECONDS:
            last = now
            left = (total - done) * (now - began) / done
            print(f"{what}: {done} of {total}, {left:.0f} s left", file=sys.stderr, flush=True)

    return show


def _plain_lines(plan: Plan) -> Callable[[Progress], None]:
    last = time.monotonic()
    total = (plan.n_samples - 1) * plan.interval

    def show(progress: Progress) -> None:
        nonlocal last
        if time.monotonic() - last < PLAIN_SECONDS:
            return
        last = time.monotonic()
        left = progress.steps_left / max(progress.speed, 1e-9)
        print(
            f"{1e3 * progress.simulated:.2f} of {1e3 * total:.2f} ms, {progress.speed:,.0f} steps/s, {left:.0f} s "
            f"left, energy imbalance {progress.imbalance:+.1e}",
            file=sys.stderr,
            flush=True,
        )

    return show
