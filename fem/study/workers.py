"""Points solved by processes of this machine: each takes one at a time through a pipe, and no port is opened.

A process that dies loses its point, and one that hangs in compiled code is killed; another takes its place.
"""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any

from fem.commands.start_up import from_no_current_folder
from fem.study.solving import LOST, STOPPED, Solved, Wanted, solve
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
        with from_no_current_folder():
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
