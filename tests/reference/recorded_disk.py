"""A disk that remembers what a run writes to its result file, can lose power at any moment, and can fail."""

import errno
import itertools
import os

import numpy as np

import fem.result.store

SECTOR = 512  # bytes a disk writes whole


class RecordedDisk:
    """Watches the solver's own writes, syncs and moves; they are made all the same.

    Give `fail_at` to have the call of that number, and all after it, fail for want of room.
    """

    def __init__(self, monkeypatch, fail_at: int | None = None):
        self.calls, self._fail_at = 0, fail_at
        self._log: list[tuple] = []  # ("write", file, place, bytes), ("sync",), ("move", file, path, content)
        for name, told in (
            ("fem.result.store.write_at", lambda handle, data, at: ("write", os.fstat(handle).st_ino, at, bytes(data))),
            ("fem.result.store.move_into_place", lambda a, b: ("move", os.stat(a).st_ino, str(b), a.read_bytes())),
            ("os.fsync", lambda handle: ("sync",)), ("os.posix_fallocate", lambda *_: ("claim",)),
        ):  # fmt: skip
            module, _, function = name.rpartition(".")
            real = getattr(os if module == "os" else fem.result.store, function)
            monkeypatch.setattr(name, lambda *given, real=real, told=told: self._watched(real, told, given))

    def _watched(self, real, told, given) -> None:
        if self._fail_at is not None and self.calls >= self._fail_at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.calls += 1
        self._log.append(told(*given))
        real(*given)

    def after_kills(self, path):
        """The content of a file after each write, which a killed process leaves."""
        there, content = None, None
        for kind, *what in self._log:
            if kind == "move" and what[1] == str(path):
                there, content = what[0], bytearray(what[2])
            elif kind == "write" and what[0] == there:
                _put(content, *what[1:])
            if content is not None:
                yield bytes(content)

    def after_power_cuts(self, path, numbers: np.random.Generator, tries: int):
        """The content of a file after power cuts, any of the sectors since the last sync on the disk or not."""
        there, synced, since = None, None, []
        for kind, *what in self._log:
            if kind == "move" and what[1] == str(path):
                there, synced, since = what[0], bytearray(what[2]), []
            elif kind == "write" and what[0] == there:
                since += _sectors(*what[1:])
            if synced is None:
                continue
            for _ in range(tries):
                content = synced.copy()
                for place, data in since:
                    if numbers.random() < 0.5:
                        _put(content, place, data)
                yield bytes(content)
            if kind == "sync":
                for place, data in since:
                    _put(synced, place, data)
                since = []


def _sectors(place: int, data: bytes):
    """Cut a write into the pieces that a disk makes whole."""
    borders = [place, *range(place - place % SECTOR + SECTOR, place + len(data), SECTOR), place + len(data)]
    return [(a, data[a - place : b - place]) for a, b in itertools.pairwise(borders)]


def _put(content: bytearray, place: int, data: bytes) -> None:
    content[place : place + len(data)] = data
