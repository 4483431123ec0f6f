"""A study from its points to its dataset: here, or by the workers of a cluster."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import nan

from fem.commands.progress import count_display
from fem.result.layout import readable
from fem.solver.simulate import make_plan, programs_named
from fem.study.folder import Folder
from fem.study.solving import LOST, Points, Solved, Wanted, needs_no_run, rated, solve
from fem.study.workers import scheduler_client, solve_in_processes, solve_on_cluster
from lagrange.columns import PER_ROLLER
from lagrange.errors import RunFailed, UsageError
from lagrange.messages import say
from lagrange.scene.scene import Scene

WORTH_PROCESSES = 60.0  # s of work: below, starting them takes longer than they save
POINT_FILE = 2500  # bytes, without signals
SOLVING = "points"


@dataclass(frozen=True, kw_only=True)
class Expected:
    """What a study will take."""

    seconds: float  # of one processor, of a point, mean
    memory: float  # bytes, of one process
    disk: float  # bytes, of a point: its file and its share of the dataset


@dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """How a study is to be run."""

    workers: int | None = None  # None: as many as pay
    scheduler: str | None = None
    resume: bool = False
    keep_runs: bool = False
    quiet: bool = False


def pending_points(points: Points, folder: Folder) -> list[int]:
    """Points that have not been solved, each digest once."""
    first = {digest: i for i, digest in reversed(list(enumerate(points.digests)))}
    return sorted(i for digest, i in first.items() if folder.read(digest) is None)


def expected(points: Points, pending: list[int], tell: Callable[[str], None] | None = None) -> Expected:
    """Expected cost of the points from the plans of three of them; compiles their kernels first.

    Errors
    ------
    UsageError: no plan can be made of any of the three.
    """
    seconds, refused = [], ""
    for i in sorted({pending[0], pending[len(pending) // 2], pending[-1]}):
        try:
            scene, keep = points.scene(i), points.study.keep
            if needs_no_run(keep.quantities, keep.signals):
                began = time.process_time()
                rated(scene, keep.quantities)
                seconds.append(time.process_time() - began)
                continue
            programs_named(partial(make_plan, scene)).prepare(tell)
            began = time.process_time()
            plan = make_plan(scene)
            seconds.append(time.process_time() - began + plan.expected_seconds)
        except (RunFailed, UsageError) as error:
            refused = refused or f"{points.design.describe(i)}: {error}"
    if not seconds:
        raise UsageError(refused)
    return Expected(seconds=sum(seconds) / len(seconds), memory=_memory(), disk=_disk(points))


def _memory() -> float:
    """Largest of this process so far, bytes; nan on systems that do not tell."""
    try:
        import resource
    except ImportError:
        return nan
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _disk(points: Points) -> float:
    keep, scene = points.study.keep, points.scene(0)
    numerics, variables = scene.numerics, readable(scene)
    rate = 1e3 / numerics.output_interval_us if keep.signal_rate_kHz is None else keep.signal_rate_kHz
    rollers = scene.bearing.present
    columns = sum(rollers if variables[name].dimensions == PER_ROLLER else 1 for name in keep.signals)
    return POINT_FILE + 2.0 * 8.0 * columns * numerics.duration_ms * rate


def workers_for(options: StudyOptions, total: float) -> int:
    """Processes to start for so many seconds of work; 0: it is done in this one."""
    if options.workers is not None:
        return 0 if options.workers == 1 else options.workers
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return processors if processors > 1 and total > WORTH_PROCESSES else 0


def solve_points(
    points: Points, pending: list[int], folder: Folder, options: StudyOptions, total: float, stop: Callable[[], bool]
) -> dict[int, Solved]:
    """Solve points and keep them in the folder, until `stop` says so; those lost with their workers.

    Errors
    ------
    OSError: a point can't be kept; those before it are. UsageError: no scheduler, before anything is written; another
    study in the folder.
    """
    keep, lost = points.study.keep, {}
    wanted = Wanted(
        quantities=tuple(keep.quantities),
        signals=tuple(keep.signals),
        signal_rate=None if keep.signal_rate_kHz is None else 1e3 * keep.signal_rate_kHz,
        seconds=points.study.limits.seconds_per_point,
        runs=options.keep_runs,
    )
    with (
        _solver(options, total) as solve_all,
        folder.held(points, options.resume),
        count_display(SOLVING, len(pending), options.quiet) as count,
    ):

        def add(i: int, solved: Solved) -> None:
            folder.add(points.digests[i], solved)
            if solved.status == LOST:
                lost[i] = solved
            count()

        solve_all(((i, points.scene(i)) for i in pending), wanted, add, stop)
    for i, solved in lost.items():
        say(f"warning: {points.design.describe(i)}: {solved.text}; --resume tries it again")
    return lost


@contextmanager
def _solver(options: StudyOptions, total: float) -> Iterator[Callable[..., None]]:
    """What solves numbered scenes: a scheduler's workers, processes of this machine, or this one."""
    workers = workers_for(options, total)
    if options.scheduler is not None:
        with scheduler_client(options.scheduler) as client:
            yield partial(solve_on_cluster, client)
    elif workers:
        yield partial(solve_in_processes, workers)
    else:
        yield _solve_here


def _solve_here(scenes: Iterator[tuple[int, Scene]], wanted: Wanted, add, stop: Callable[[], bool]) -> None:
    for i, scene in scenes:
        if stop():
            return
        solved = solve(scene, wanted, stop)
        if solved is None:
            return
        add(i, solved)
