"""Workers that a point holds: found by how long it has taken, and begun anew without it.

A point asks for its time limit several times a second, but not while it is planned, compiled or inside of other
compiled code. A worker that hangs there answers nobody, so that it is watched from outside: each point tells when it
begins, and long after its limit the worker's process is killed.
"""

import time
from contextlib import suppress
from typing import Any

GRACE = 60.0  # s, beyond the limit: planning a fine mesh, or compiling on a new node
RESTART = 60.0  # s, that a worker may take to come back


class Watch:
    """What the points of a client's study have told of their beginnings."""

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
