"""Points solved by processes of this machine, or by the workers of a scheduler of dask.distributed.

A process takes one point at a time through a pipe, and no port is opened. One that dies loses its point, and one that
hangs in compiled code is killed; another takes its place. Of a cluster few tasks are under way at a time, so that
neither this process nor the scheduler ever holds the study; a worker that dies is the scheduler's business, which gives
its points to others; one that hangs is killed (`Watch`).
"""

import asyncio
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any

from fem.study.solving import LOST, STOPPED, Solved, Wanted, program, solve
from lagrange.errors import UsageError
from lagrange.scene.scene import Scene

GRACE = 60.0  # s, beyond the limit: planning a fine mesh, or compiling on a new node
LOOK = 0.5  # s, between two looks at what has happened
HUNG = "hung in compiled code: its worker was killed, limits.seconds_per_point = {:g} s were long over"


class Worker:
    """A process, and the point that it solves."""

    def __init__(self) -> None:
        context = get_context("spawn")  # a fork would inherit the locks of threads that it lacks
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()

    def begin(self, point: int, scene: Scene, wanted: Wanted) -> None:
        self.point, self.began = point, time.monotonic()
        with suppress(OSError):  # it has died, which its pipe tells
            self.pipe.send((scene, wanted))

    def kill(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


def serve(pipe: Connection) -> None:
    """Solve what comes, until the study has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of a terminal: the study hears it and decides
    with suppress(EOFError, OSError):
        while True:
            pipe.send(solve(*pipe.recv()))


def solve_in_processes(
    count: int,
    scenes: Iterator[tuple[int, Scene]],
    wanted: Wanted,
    add: Callable[[int, Solved], None],
    stop: Callable[[], bool],
) -> None:
    """Solve numbered scenes in so many processes and hand what became of each to `add`, in the order in which they end.

    Errors
    ------
    OSError: `add`'s, or no process can be started.
    """
    idle: list[Worker] = []
    busy: dict[Any, Worker] = {}  # by pipe
    ended: list[tuple[int, Solved]] = []
    following = next(scenes, None)
    try:
        while True:
            stopped = stop()
            while not stopped and following is not None and len(busy) < count:
                worker = idle.pop() if idle else Worker()
                busy[worker.pipe] = worker
                worker.begin(*following, wanted)
                following = next(scenes, None)
            for point, solved in ended:
                add(point, solved)
            if stopped or not busy:
                return
            ended = [*_ended(busy, idle), *_given_up(busy, wanted)]
    finally:
        for worker in (*idle, *busy.values()):
            worker.kill()


def _ended(busy: dict[Any, Worker], idle: list[Worker]) -> Iterator[tuple[int, Solved]]:
    for pipe in wait(list(busy), LOOK):
        worker = busy.pop(pipe)
        try:
            yield worker.point, worker.pipe.recv()
            idle.append(worker)
        except (EOFError, OSError):
            worker.kill()
            text = f"its process died (exit code {worker.process.exitcode}), as where memory is short"
            yield worker.point, Solved(status=LOST, text=text)


def _given_up(busy: dict[Any, Worker], wanted: Wanted) -> Iterator[tuple[int, Solved]]:
    for worker in list(busy.values()):
        if time.monotonic() - worker.began > wanted.seconds + GRACE:
            del busy[worker.pipe]
            worker.kill()
            yield worker.point, Solved(status=STOPPED, seconds=wanted.seconds, text=HUNG.format(wanted.seconds))


RESTART = 60.0  # s, that a worker may take to come back


class Watch:
    """Finds unresponsive workers by how long their points have taken.

    A point asks for its time limit several times a second, but not while it is planned, compiled or inside of other
    compiled code. A worker that hangs there answers nobody, so that it is watched from outside: each point tells when
    it begins, and long after its limit the worker's process is killed.
    """

    def __init__(self, client: Any, seconds: float):
        self.topic = f"run-study {client.id}"
        self._client, self._most = client, seconds + GRACE
        self._begun: dict[int, tuple[str, float]] = {}  # by point: its worker's address, and when
        client.subscribe_topic(self.topic, self._note)

    def _note(self, event: tuple[float, dict[str, Any]]) -> None:
        self._begun[event[1]["point"]] = event[1]["worker"], time.monotonic()

    def forget(self, point: int) -> None:
        """The point has ended."""
        self._begun.pop(point, None)

    def overdue(self) -> dict[int, str]:
        """Points that have taken too long, and their workers' addresses."""
        now = time.monotonic()
        return {i: where for i, (where, began) in list(self._begun.items()) if now - began > self._most}

    def restart(self, worker: str) -> None:
        """Kill a worker's process; its nanny starts another, and what waited there is solved elsewhere.

        One without a nanny is given up: nobody here can kill it.
        """
        with suppress(OSError, TimeoutError):  # it may have gone by itself
            try:
                self._client.restart_workers([worker], timeout=RESTART, raise_for_error=False)
            except ValueError:
                self._client.retire_workers([worker])


AHEAD = 2  # tasks a thread of the cluster has in hand: one to solve, one to begin without waiting
FIRST_WORKER = 60.0  # s, that the first one may take to come
CONNECT = 20.0  # s
COUNTING = 2.0  # s, between two looks at how many workers there are


def task(point: int, scene: Scene, wanted: Wanted, expected_program: str, topic: str) -> Solved | None:
    """What a worker does for one point."""
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(topic, {"point": point, "worker": worker.address})  # for the client's watch
    if program() != expected_program:
        return Solved(status=LOST, text="the worker has another version of the program or of its libraries")
    return solve(scene, wanted)


def solve_on_cluster(
    client: Any,
    scenes: Iterator[tuple[int, Scene]],
    wanted: Wanted,
    add: Callable[[int, Solved], None],
    stop: Callable[[], bool],
) -> None:
    """Solve numbered scenes and hand what became of each to `add`, in the order in which they end.

    Errors
    ------
    OSError: `add`'s.
    """
    under_way: dict[Any, int] = {}
    watch = Watch(client, wanted.seconds)
    room, counted = 0, -COUNTING
    left = True
    while not stop():
        if time.monotonic() - counted > COUNTING:
            room, counted = AHEAD * max(1, sum(client.nthreads().values())), time.monotonic()
        while left and len(under_way) < room:
            following = next(scenes, None)
            left = following is not None
            if following is not None:
                i, scene = following
                under_way[client.submit(task, i, scene, wanted, program(), watch.topic, pure=False)] = i
        if not under_way:
            return
        for future in _ended_tasks(under_way):
            i = under_way.pop(future)
            watch.forget(i)
            add(i, _outcome(future))
        for i in _overdue_tasks(under_way, watch):
            add(i, Solved(status=STOPPED, seconds=wanted.seconds, text=HUNG.format(wanted.seconds)))


def _ended_tasks(under_way: dict[Any, int]) -> list[Any]:
    """Tasks that have come to an end, some time after this look at the latest."""
    from distributed import wait

    try:
        return list(wait(list(under_way), timeout=LOOK, return_when="FIRST_COMPLETED").done)
    except TimeoutError:
        return []


def _overdue_tasks(under_way: dict[Any, int], watch: Watch) -> Iterator[int]:
    """Points that hang, taken from those under way and from their workers."""
    late = watch.overdue()
    for future, i in list(under_way.items()):
        if i in late and not future.done():
            del under_way[future]
            future.cancel()  # or it would be restarted elsewhere
            watch.forget(i)
            watch.restart(late[i])
            yield i


def _outcome(future) -> Solved:
    """What became of a task; of one whose worker has died again and again, that it is lost."""
    if future.status == "finished":
        found = future.result()
        return found if found is not None else Solved(status=LOST, text="the worker was stopped")
    reason = future.exception() if future.status == "error" else future.status
    return Solved(status=LOST, text=f"its worker was lost: {type(reason).__name__}: {reason}")


@contextmanager
def scheduler_client(where: str) -> Iterator[Any]:
    """A client of the scheduler at an address. UsageError: it does not answer or has no workers."""
    from distributed import Client

    try:
        with ThreadPoolExecutor(1) as apart:  # here a loop may be running: a notebook's
            apart.submit(asyncio.run, asyncio.wait_for(_knock(where), CONNECT)).result()
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


async def _knock(scheduler: str) -> None:
    """Greet what is at an address, and leave: a client would wait for its answer without end."""
    from distributed.comm import connect

    comm = await connect(scheduler, timeout=CONNECT)
    await comm.close()
