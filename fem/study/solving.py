"""Points of a study, each a pure function from a scene to numbers, solved here, by processes or by a cluster's workers.

A process of this machine takes one point at a time through a pipe, and no port is opened. One that dies loses its
point, and one that hangs in compiled code is killed; another takes its place. Of a cluster few tasks are under way at a
time, so that neither this process nor the scheduler of dask.distributed ever holds the study; a worker that dies is the
scheduler's business, which gives its points to others.
"""

import asyncio
import hashlib
import json
import os
import signal
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from math import inf, nan
from multiprocessing import connection, get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from fem.interface import OF_CHECK, check_quantities, simulate, statics
from fem.quantities import OF_RATING, OF_STATICS
from fem.rating.answers import values_of
from fem.result.store import readable
from fem.solver.simulate import make_plan
from fem.solver.solver import sample_count
from fem.study.study_file import Design, KeepTable, Study
from lagrange.columns import PER_ROLLER
from lagrange.errors import RunFailed, UsageError
from lagrange.scene.scene import Scene, SceneError
from lagrange.version import source_digest

FORMAT = 2  # of a point's file
MOST_FAULTS = 10  # named at once
LIBRARIES = ("numpy", "scipy", "numba", "pydantic")
WORTH_PROCESSES = 60.0  # s of work: below, starting them takes longer than they save
POINT_FILE = 2500  # bytes, without signals
GRACE = 60.0  # s, beyond a point's limit: planning a fine mesh, or compiling on a new node
LOOK = 0.5  # s, between two looks at what has happened
RESTART = 60.0  # s, that a worker of a cluster may take to come back
AHEAD = 2  # tasks a thread of the cluster has in hand: one to solve, one to begin without waiting
FIRST_WORKER = 60.0  # s, that the first one may take to come
CONNECT = 20.0  # s
COUNTING = 2.0  # s, between two looks at how many workers there are
COMPLETE, FAILED, STOPPED, LOST = "complete", "failed", "stopped", "lost"
RATED = {  # answers of rate-bearing, and what turns them into SI
    "rating_life": ("L10r_Mrev", 1e6), "rating_peak_pressure": ("peak_pressure_MPa", 1e6),
    "rating_moment": ("tilting_moment_N_m", 1.0),
    "rating_tilt_stiffness": ("tilt_stiffness_N_m_per_rad", 1.0)}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Points:
    """All points of a study: their values, and the digest by which each is known on disk."""

    study: Study
    design: Design
    digests: list[str]
    made_by: str  # `program` that solves them, or has

    def __len__(self) -> int:
        return len(self.digests)

    def scene(self, i: int) -> Scene:
        """The scene of point i, made when asked for: ten thousand of them would take a gigabyte."""
        return self.study.scene.varied(self.design.changes(i))


def checked_points(study: Study, design: Design, count: Callable[[], None] = lambda: None) -> Points:
    """Validate every point; `count` is called after each. UsageError: names the first few points and keys refused."""
    digests, faults, keep = [], [], study.keep
    first: dict[str, object] = {}
    for i in range(len(design.points)):
        try:
            scene = study.scene.varied(design.changes(i))
            _check_signals(scene, keep, first)
        except (SceneError, UsageError) as error:
            reason = str(error).replace("\n", "; ").replace(f"{study.scene.name}: ", "")
            faults.append(f"{design.describe(i)}: {reason}")
            if len(faults) == MOST_FAULTS:
                break
            continue
        facts = [FORMAT, scene.to_toml(), sorted(scene.files), keep.model_dump(), program()]  # name a point's file
        digests.append(hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:32])
        count()
    if faults:
        raise UsageError("\n".join(faults))
    return Points(study=study, design=design, digests=digests, made_by=program())


def _check_signals(scene, keep, first):
    """Refuse signals that a point does not have, or that do not fit beside those of the first point."""
    count, numerics, rate = sample_count(scene), scene.numerics, keep.signal_rate_kHz
    if count < 2 and not all(name.startswith(("first_", "static_", "rating_")) for name in keep.quantities):
        raise UsageError(
            "numerics.duration_ms = 0: a run at rest has only the quantities first_…, static_… and rating_…; keep no "
            "others, or run longer"
        )
    if not keep.signals:
        return
    known, interval = readable(scene), numerics.output_interval_us
    for name in keep.signals:
        if name not in known or name == "time":
            raise UsageError(f"keep.signals: {name!r} is no signal of this point; it has {', '.join(known)}")
    one_of = keep.one_of(1e-6 * interval)
    sizes: dict[str, object] = {"numerics.duration_ms": numerics.duration_ms}
    sizes["numerics.output_interval_us"] = round(one_of * interval, 6)
    if any(known[name].dimensions == PER_ROLLER for name in keep.signals):
        sizes["bearing.rollers"] = scene.bearing.present
    for key, value in sizes.items():
        if first.setdefault(key, value) != value:
            raise UsageError(
                f"{key} = {value}: signals must have the same length in every point; the first one has {first[key]}; "
                "fix it in [fixed]"
            )
    if one_of > 1 and count <= one_of:
        raise UsageError(
            f"keep.signal_rate_kHz = {rate:g}: keeps one of {one_of} samples, but the run has {count}; "
            "use a higher rate, or run longer (numerics.duration_ms)"
        )
    stored = 1e3 / interval  # kHz
    if rate is not None and rate > stored * (1.0 + 1e-9):
        raise UsageError(
            f"keep.signal_rate_kHz = {rate:g}: samples are stored at {stored:g} kHz "
            "(numerics.output_interval_us); at most that"
        )


@cache
def program() -> str:
    """Digest of the program's own code and of its libraries' versions."""
    libraries = [f"{name} {version(name)}" for name in LIBRARIES]
    return hashlib.sha256("\0".join([source_digest(), *libraries]).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Wanted:
    """What is kept of each point."""

    keep: KeepTable
    seconds: float  # the most that a point may take
    runs: bool = False  # result files too

    # whether all that is kept are ratings of the scene
    needs_no_run = property(lambda s: set(s.keep.quantities) <= set(OF_RATING) and not s.keep.signals and not s.runs)


class Solved(NamedTuple):
    """What became of a point."""

    status: str  # COMPLETE, FAILED (numerically, or refused), STOPPED (by its time limit), LOST (with its worker)
    text: str = ""  # why it is not complete
    seconds: float = 0.0  # wall time
    quantities: Mapping[str, float] = {}
    signals: Mapping[str, np.ndarray] = {}  # (n_times, …), decimated
    signal_interval: float = 0.0  # s
    run: bytes | None = None  # the result file


def solve(scene: Scene, wanted: Wanted, stop: Callable[[], bool] = lambda: False) -> Solved | None:
    """Simulate a scene and keep what is wanted; a failure is kept with its reason. None: `stop` said so."""
    began, status = time.monotonic(), FAILED
    spent = lambda: time.monotonic() - began  # noqa: E731
    try:
        if wanted.needs_no_run:
            return Solved(quantities=rated(scene, wanted.keep.quantities), status=COMPLETE, seconds=spent())
        result = simulate(scene, stop=lambda: stop() or spent() > wanted.seconds)
        if result.status == COMPLETE:
            return Solved(**_kept(result, wanted), status=COMPLETE, seconds=spent())
        if stop():
            return None
        reached = 1e3 * float(result.time[-1]) if len(result.time) else 0.0
        status = STOPPED
        reason = f"stopped at {reached:.4g} ms: limits.seconds_per_point = {wanted.seconds:g} s were over"
    except (RunFailed, UsageError, SceneError) as error:
        reason = str(error)
    except MemoryError:
        reason = "not enough memory"
    except Exception as error:  # a study of thousands is not to end by one point; the text says what is wrong
        reason = f"{type(error).__name__}: {error}"
    return Solved(status=status, text=reason, seconds=spent())


def _kept(result, wanted):
    """Quantities, signals, decimated by a whole number after a filter without phase, and the file of a run."""
    keep, known = wanted.keep, {name: found.value for name, found in result.quantities.items()}
    if not OF_CHECK.keys().isdisjoint(keep.quantities):
        known |= {quantity.name: quantity.value for quantity in check_quantities(result.residual())}
    if not OF_STATICS.keys().isdisjoint(keep.quantities):
        known["static_stiffness"] = statics(result.scene).stiffness
    known |= rated(result.scene, keep.quantities)
    interval = 1e-6 * result.scene.numerics.output_interval_us
    one_of, signals, run = keep.one_of(interval), {name: result[name] for name in keep.signals}, None
    if one_of > 1:
        from scipy.signal import decimate

        signals = {name: decimate(values, one_of, ftype="fir", axis=0) for name, values in signals.items()}
    if wanted.runs:
        with TemporaryDirectory(prefix="run-study-") as folder:
            run = result.save(Path(folder) / "run.nc").read_bytes()
    return dict(
        quantities={name: float(known[name]) for name in keep.quantities if name in known}, run=run,
        signals={name: np.ascontiguousarray(values) for name, values in signals.items()},
        signal_interval=one_of * interval)  # fmt: skip


def rated(scene: Scene, names: Collection[str]) -> dict[str, float]:
    """Those of OF_RATING; NaN of what can't be rated."""
    wanted = {name: RATED[name] for name in names if name in OF_RATING}
    answers = values_of(scene, {answer for answer, _ in wanted.values()})
    return {name: factor * answers[answer] for name, (answer, factor) in wanted.items()}


class StudyOptions(NamedTuple):
    """How a study is to be run."""

    workers: int | None = None  # None: as many as pay
    scheduler: str | None = None
    resume: bool = False
    keep_runs: bool = False
    quiet: bool = False

    def processes(self, total: float) -> int:
        """How many to start for so many seconds of work; 0: it is done in this one."""
        if self.workers is not None:
            return 0 if self.workers == 1 else self.workers
        processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return processors if processors > 1 and total > WORTH_PROCESSES else 0


class Expected(NamedTuple):
    """What a study will take."""

    seconds: float  # of one processor, of a point, mean
    memory: float  # bytes, of one process; nan on systems that do not tell
    disk: float  # bytes, of a point: its file and its share of the dataset


def expected(points: Points, pending: list[int], tell: Callable[[str], None] | None = None) -> Expected:
    """Cost of points by plans of three of them, whose kernels are compiled first. UsageError: none can be planned."""
    seconds, refused, keep, memory = [], "", points.study.keep, nan
    for i in sorted({pending[0], pending[len(pending) // 2], pending[-1]}):
        try:
            scene, run = points.scene(i), 0.0
            if Wanted(keep=keep, seconds=inf).needs_no_run:
                began = time.process_time()
                rated(scene, keep.quantities)
            else:
                make_plan(scene).prepare(tell)
                began = time.process_time()
                run = make_plan(scene).expected_seconds
            seconds.append(time.process_time() - began + run)
        except (RunFailed, UsageError) as error:
            refused = refused or f"{points.design.describe(i)}: {error}"
    if not seconds:
        raise UsageError(refused)
    with suppress(ImportError):
        import resource

        memory = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    scene = points.scene(0)
    variables, rate = readable(scene), keep.signal_rate_kHz or 1e3 / scene.numerics.output_interval_us
    per_roller = [variables[name].dimensions == PER_ROLLER for name in keep.signals]
    columns = sum(scene.bearing.present if each else 1 for each in per_roller)
    disk = POINT_FILE + 2.0 * 8.0 * columns * scene.numerics.duration_ms * rate
    return Expected(seconds=sum(seconds) / len(seconds), memory=memory, disk=disk)


def solve_all(
    solver: "Solver", scenes: Iterator[tuple[int, Scene]], add: Callable[[int, Solved], None], stop: Callable[[], bool]
) -> None:
    """Solve numbered scenes, hand what became of each to `add` as they end. OSError: `add`'s, or no process starts."""
    ended: list[tuple[int, Solved]] = []
    following = next(scenes, None)
    try:
        while True:
            stopped = stop()
            while not stopped and following is not None and solver.has_room():
                solver.begin(*following)
                following = next(scenes, None)
            for point, solved in ended:
                add(point, solved)
            if stopped or not solver.busy:
                return
            ended = list(solver.ended())
    finally:
        solver.close()


class Solver:
    """Solves points: in this process one at a time, else as its kinds do."""

    def __init__(self, wanted: Wanted, stop: Callable[[], bool] = lambda: False):
        self.wanted, self._stop = wanted, stop
        self.busy: dict[Any, Any] = {}  # what is under way

    def has_room(self) -> bool:
        return not self.busy

    def begin(self, point: int, scene: Scene) -> None:
        self.busy[point] = scene

    def ended(self) -> Iterator[tuple[int, Solved]]:
        point, scene = self.busy.popitem()
        solved = solve(scene, self.wanted, self._stop)
        if solved is not None:
            yield point, solved

    def hung(self) -> Solved:
        limit = f"limits.seconds_per_point = {self.wanted.seconds:g} s were long over"
        text = f"hung in compiled code: its worker was killed, {limit}"
        return Solved(status=STOPPED, seconds=self.wanted.seconds, text=text)

    def close(self) -> None:
        """End what is still under way."""


def serve(pipe: connection.Connection) -> None:
    """Solve what comes, until the study has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of a terminal: the study hears it and decides
    with suppress(EOFError, OSError):
        while True:
            pipe.send(solve(*pipe.recv()))


class Processes(Solver):
    """Processes of this machine, started when they are needed; point and start of those busy by their pipes."""

    def __init__(self, count: int, wanted: Wanted):
        super().__init__(wanted)
        self._count, self._idle = count, list[Any]()
        self._processes: dict[Any, Any] = {}  # by their pipes

    def has_room(self) -> bool:
        return len(self.busy) < self._count

    def begin(self, point: int, scene: Scene) -> None:
        if not self._idle:
            context = get_context("spawn")  # a fork would inherit the locks of threads that it lacks
            ours, theirs = context.Pipe()
            self._processes[ours] = context.Process(target=serve, args=(theirs,), daemon=True)
            self._processes[ours].start()
            theirs.close()
            self._idle.append(ours)
        pipe = self._idle.pop()
        self.busy[pipe] = point, time.monotonic()
        with suppress(OSError):  # it has died, which its pipe tells
            pipe.send((scene, self.wanted))

    def ended(self) -> Iterator[tuple[int, Solved]]:
        ready: list[Any] = connection.wait(list(self.busy), LOOK)
        for pipe in ready:
            point, _ = self.busy.pop(pipe)
            try:
                yield point, pipe.recv()
                self._idle.append(pipe)
            except (EOFError, OSError):
                text = f"its process died (exit code {self._kill(pipe)}), as where memory is short"
                yield point, Solved(status=LOST, text=text)
        for pipe, (point, began) in list(self.busy.items()):
            if time.monotonic() - began > self.wanted.seconds + GRACE:
                del self.busy[pipe]
                self._kill(pipe)
                yield point, self.hung()

    def _kill(self, pipe):
        process = self._processes.pop(pipe)
        process.kill()
        process.join()
        pipe.close()
        return process.exitcode

    def close(self) -> None:
        for pipe in list(self._processes):
            self._kill(pipe)


def task(point: int, scene: Scene, wanted: Wanted, expected_program: str, topic: str) -> Solved | None:
    """What a worker of a cluster does for one point."""
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(topic, {"point": point, "worker": worker.address})  # for the client's watch
    if program() != expected_program:
        return Solved(status=LOST, text="the worker has another version of the program or of its libraries")
    return solve(scene, wanted)


class Cluster(Solver):
    """Workers of a scheduler, and how long their points have taken.
    A point asks for its time limit several times a second, but not while it is planned, compiled or inside of other
    compiled code. A worker that hangs there answers nobody, so that it is watched from outside: each point tells when
    it begins, and long after its limit the worker's process is killed."""

    def __init__(self, client: Any, wanted: Wanted):
        super().__init__(wanted)  # busy: points by task
        self._client, self._topic = client, f"run-study {client.id}"
        self._begun: dict[int, tuple[str, float]] = {}  # by point: its worker's address, and when
        self._room, self._counted = 0, -inf
        client.subscribe_topic(self._topic, self._note)

    def _note(self, event):
        self._begun[event[1]["point"]] = event[1]["worker"], time.monotonic()

    def has_room(self) -> bool:
        now = time.monotonic()
        if now - self._counted > COUNTING:
            self._room, self._counted = AHEAD * max(1, sum(self._client.nthreads().values())), now
        return len(self.busy) < self._room

    def begin(self, point: int, scene: Scene) -> None:
        future = self._client.submit(task, point, scene, self.wanted, program(), self._topic, pure=False)
        self.busy[future] = point

    def ended(self) -> Iterator[tuple[int, Solved]]:
        from distributed import wait

        with suppress(TimeoutError):
            for future in wait(list(self.busy), timeout=LOOK, return_when="FIRST_COMPLETED").done:
                point = self.busy.pop(future)
                self._begun.pop(point, None)
                if future.status == "finished":
                    yield point, future.result() or Solved(status=LOST, text="the worker was stopped")
                else:  # one whose worker has died again and again
                    reason = future.exception() if future.status == "error" else future.status
                    text = f"its worker was lost: {type(reason).__name__}: {reason}"
                    yield point, Solved(status=LOST, text=text)
        latest = time.monotonic() - self.wanted.seconds - GRACE
        for future, point in list(self.busy.items()):
            worker, began = self._begun.get(point, ("", inf))
            if began < latest and not future.done():
                del self.busy[future], self._begun[point]
                future.cancel()  # or it would be restarted elsewhere
                with suppress(OSError, TimeoutError):  # the worker may have gone by itself
                    try:  # its process is killed; its nanny starts another, and what waited there is solved elsewhere
                        self._client.restart_workers([worker], timeout=RESTART, raise_for_error=False)
                    except ValueError:  # without a nanny it is given up: nobody here can kill it
                        self._client.retire_workers([worker])
                yield point, self.hung()


@contextmanager
def scheduler_client(where: str) -> Iterator[Any]:
    """A client of the scheduler at an address. UsageError: it does not answer or has no workers."""
    from distributed import Client
    from distributed.comm import connect

    async def knock():  # greet what is there, and leave: a client would wait for its answer without end
        await (await connect(where, timeout=CONNECT)).close()

    try:
        with ThreadPoolExecutor(1) as apart:  # here a loop may be running: a notebook's
            apart.submit(lambda: asyncio.run(asyncio.wait_for(knock(), CONNECT))).result()
        client = Client(where, timeout=CONNECT)
    except Exception as error:  # whatever dask says of addresses and of what it finds there
        reason = str(error) or "nothing was said in time"
        raise UsageError(f"--scheduler {where}: does not answer: {reason}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=FIRST_WORKER)
        except TimeoutError:
            raise UsageError(
                f"--scheduler {where}: no worker came in {FIRST_WORKER:g} s; start some: "
                f"dask worker {where} --nthreads 1"
            ) from None
        yield client
