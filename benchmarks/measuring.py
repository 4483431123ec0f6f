"""What the benchmarks share: scenes with some keys set, times, runs in turns, tables of the terminal."""

import resource
import statistics
import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import TypeVar

from rich.table import Table

from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan
from lagrange.scene.scene import read_scene

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


def paper_plan(size_mm: float, *settings: str) -> ElementPlan:
    """Plan of the paper's scene on a mesh, with further keys as run-fem's --set takes them."""
    return make_plan(read_scene(None, (f"numerics.mesh_size_mm={size_mm!r}", *settings)))


def timed(function: Callable[..., Value], *arguments, clock=time.thread_time) -> tuple[float, Value]:
    """Time a call, s, and pass on what it returns.

    The default clock is the processor time of this thread, so that waiting for a busy core is not counted.
    """
    began = clock()
    value = function(*arguments)
    return clock() - began, value


def median_seconds(function: Callable, *arguments, repeats: int = 7) -> float:
    """Median processor time of a call, s, after one that compiles and warms up."""
    function(*arguments)
    return statistics.median(timed(function, *arguments)[0] for _ in range(repeats))


def in_turns(calls: dict[Key, Callable[[], Value]], turns: int) -> Iterator[dict[Key, Value]]:
    """Make each call in every turn, every other turn in reverse: what slows the machine slows all alike."""
    for turn in range(turns):
        yield {key: calls[key]() for key in (list(calls) if turn % 2 == 0 else reversed(calls))}


def processor_seconds(*who: int) -> float:
    """Processor time so far, s, of `resource.RUSAGE_SELF`, of `RUSAGE_CHILDREN` that have ended, or of both."""
    return sum(used.ru_utime + used.ru_stime for used in map(resource.getrusage, who))


def spread(values: Iterable[float], digits: int = 3) -> str:
    """Write the lowest and the highest of some numbers."""
    values = list(values)
    return f"{min(values):.{digits}f} … {max(values):.{digits}f}"


def new_table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]] = ()) -> Table:
    """Make a table for the terminal; the first column is aligned left, the others right."""
    table = Table(title=title, title_justify="left")
    for i, heading in enumerate(headings):
        table.add_column(heading, justify="right" if i else "left")
    for row in rows:
        table.add_row(*row)
    return table
