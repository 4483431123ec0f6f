"""Points solved by the workers of a scheduler of dask.distributed.

A task is a pure function of its scene. Few are under way at a time, so that neither this process nor the scheduler ever
holds the study; a worker that dies is the scheduler's business, which gives its points to others; one that hangs is
killed (`Watch`).
"""

import asyncio
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any

from fem.errors import UsageError
from fem.study.solving import LOST, STOPPED, Solved, Wanted, program, solve
from fem.study.workers import GRACE, HUNG, LOOK
from lagrange.scene.scene import Scene

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


def tell_begun(topic: str, point: int) -> None:
    """Tell the client's watch that a worker begins a point."""
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(topic, {"point": point, "worker": worker.address})


AHEAD = 2  # tasks a thread of the cluster has in hand: one to solve, one to begin without waiting
FIRST_WORKER = 60.0  # s, that the first one may take to come
CONNECT = 20.0  # s
COUNTING = 2.0  # s, between two looks at how many workers there are


def task(point: int, scene: Scene, wanted: Wanted, expected_program: str, topic: str) -> Solved | None:
    """What a worker does for one point."""
    tell_begun(topic, point)
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
        for future in _ended(under_way):
            i = under_way.pop(future)
            watch.forget(i)
            add(i, _outcome(future))
        for i in _given_up(under_way, watch):
            add(i, Solved(status=STOPPED, seconds=wanted.seconds, text=HUNG.format(wanted.seconds)))


def _ended(under_way: dict[Any, int]) -> list[Any]:
    """Tasks that have come to an end, some time after this look at the latest."""
    from distributed import wait

    try:
        return list(wait(list(under_way), timeout=LOOK, return_when="FIRST_COMPLETED").done)
    except TimeoutError:
        return []


def _given_up(under_way: dict[Any, int], watch: Watch) -> Iterator[int]:
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
