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
        self.calls = 0
        self._log: list[tuple] = []  # ("write", file, place, bytes), ("sync",), ("move", file, path, content)
        self._fail_at = fail_at
        self._write, self._move, self._sync = fem.result.store.write_at, fem.result.store.move_into_place, os.fsync
        monkeypatch.setattr("fem.result.store.write_at", self._watched_write)
        monkeypatch.setattr("fem.result.store.move_into_place", self._watched_move)
        monkeypatch.setattr("os.fsync", self._watched_sync)

    def _attempt(self) -> None:
        if self._fail_at is not None and self.calls >= self._fail_at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.calls += 1

    def _watched_write(self, handle, data, place) -> None:
        self._attempt()
        self._log.append(("write", os.fstat(handle).st_ino, place, bytes(data)))
        self._write(handle, data, place)

    def _watched_sync(self, handle) -> None:
        self._attempt()
        self._log.append(("sync",))
        self._sync(handle)

    def _watched_move(self, old, new) -> None:
        self._attempt()
        self._log.append(("move", os.stat(old).st_ino, str(new), old.read_bytes()))
        self._move(old, new)

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
