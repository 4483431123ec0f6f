"""What measures speed, each a command that prints a table; run from the checkout's root. Correctness: `tests`.

throughput      time of every phase of a step against the machine's ceilings, memory, start-up
table_costs     time that each table of a scene adds; absent tables add none
planning        what it takes to plan a scene after others
studies         what a study adds to its points, and what a second process gives
checkpoint_cost what checkpoints and commits cost, as paired ratios
work_precision  run time against error over meshes
reduced_model   the reduced model beside finite elements
lagrange_model  the Lagrangian model solved: its time, its energy
live            frames a second of the live page, and what they take
pictures        docs' pictures; stress below contacts, times, sizes
measured_records verdicts on records whose truth is known
same_bits       whether another revision gives the same bits, and takes the same time

Here is what they share: scenes with some keys set, times, runs in turns.
"""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from fem.solver.solver import Plan

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


def paper_plan(*settings: str) -> "Plan":
    """Plan of the paper's scene with further keys as run-fem's --set takes them."""
    from fem.solver.simulate import make_plan
    from lagrange.scene.scene import read_scene

    return make_plan(read_scene(None, settings))


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


def used(function: Callable, *arguments, **options) -> tuple[float, float]:
    """Wall and processor time of a call, s, and of the processes that it starts and waits for."""
    began, before = time.perf_counter(), sum(os.times()[:4])
    function(*arguments, **options)
    return time.perf_counter() - began, sum(os.times()[:4]) - before


def command_seconds(*words: str, repeats: int = 7) -> tuple[float, float]:
    """Wall and processor time of `python -m` and words, medians, s, after one call that compiles."""
    command = [sys.executable, "-m", *words]
    wall, processor = zip(*(used(subprocess.run, command, check=True) for _ in range(repeats + 1)), strict=True)
    return statistics.median(wall[1:]), statistics.median(processor[1:])


def spread(values: Iterable[float], digits: int = 3) -> str:
    """Write the lowest and the highest of some numbers."""
    values = list(values)
    return f"{min(values):.{digits}f} … {max(values):.{digits}f}"
