"""The result file while a run writes it.

Samples are trusted up to the attribute `committed_samples`, which is written after the data it counts has reached the
disk (where it stands: `layout`). A killed run therefore leaves a readable file up to its last commit, with unused room
behind; one that ends in any other way leaves a file of exactly the samples it has.
"""

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from fem.result.durable import alone_in, open_locked, write_at
from fem.result.earlier import check_earlier, refuse_foreign, refuse_if_in_use
from fem.result.later_columns import events_of, sinkages, write_events, write_scene_files
from fem.result.layout import Places, create, variables_of
from lagrange.axial.slices import write_slices
from lagrange.columns import FORMAT_VERSION
from lagrange.errors import UsageError
from lagrange.files.hdf5 import checksum, hdf5_to_write, text_checksum
from lagrange.files.output import move_into_place, new_part, real_path, remove_left
from lagrange.surface.faults import labels
from lagrange.surface.passages import SpallEvent, spalls
from lagrange.version import VERSION, source_digest

if TYPE_CHECKING:
    from fem.solver.frames import Frame
    from fem.solver.solver import Plan

COMMIT_SECONDS = 0.5  # of wall time between two commits
COMMIT_SHARE = 0.005  # of the wall time at most: a slow disk is asked less often
BLOCK = 4096  # samples copied at once


@dataclass(frozen=True, kw_only=True)
class Stored:
    """How far a result file had come when its run's state was saved."""

    samples: int
    checksums: dict[str, int]  # of each variable's first `samples`


def nothing_stored(plan: "Plan") -> Stored:
    """Of a run that has not begun."""
    return Stored(samples=0, checksums=dict.fromkeys(variables_of(plan.scene), 0))


class WriteFailed(OSError):
    """The result file can't be written any more; what it has committed stays."""


class ResultFile:
    """Appends samples; use as a context manager.

    Errors
    ------
    UsageError: another program has the file open; it is not what was stored. OSError: no room on the disk, a folder
    or an earlier file that can't be written; an earlier file stays as it was. WriteFailed, later: the disk fails.
    """

    def __init__(
        self, path: Path, plan: "Plan", setup_seconds: float, resume: Stored | None = None, **attributes: float | str
    ):
        """A new file in the place of any earlier one, or one that goes on after what was stored.

        `attributes` are those that the run has found out, in place of the plan's.
        """
        self._path = real_path(path)
        self._attributes = _attributes(plan, setup_seconds) | attributes
        self._plan = plan
        self._bearing, self._operation = plan.scene.ideal_bearing(), plan.scene.ideal_operation()
        self._variables = variables_of(plan.scene)
        self._handle: int | None = None
        self._events: list[SpallEvent] | None = None  # known when the run has ended, on bearings with spalls
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with alone_in(self._path.parent):
            refuse_if_in_use(self._path)
            if resume is None:
                refuse_foreign(self._path)
                self._begin(plan.n_samples, nothing_stored(plan))
            else:
                frames = frames_of(resume.samples, plan.frame_stride)
                check_earlier(self._path, tuple(self._variables), resume.samples, frames)
                self._begin(plan.n_samples, resume)

    def _begin(self, capacity: int, stored: Stored) -> None:
        """Put a new file with the samples stored in the earlier one in its place, and go on with it.

        While the files change places neither is open, as not every system allows that.
        """
        capacity = max(1, capacity)  # HDF5 gives nothing no place
        with self._named(), ExitStack() as undo:
            remove_left(self._path)
            part = new_part(self._path)
            undo.callback(part.unlink, missing_ok=True)
            places = create(
                part, self._bearing.pocket, capacity, self._attributes, self._variables, self._further(capacity)
            )
            handle = open_locked(part)
            try:
                if stored.samples and self._copy(handle, places, stored.samples) != stored.checksums:
                    raise UsageError(f"{self._path}: damaged: its samples are not those that were written; start again")
                for name, place in places.checksum.items():
                    write_at(handle, _integers(stored.samples, stored.checksums[name], -1, 0), place)
                write_at(handle, _integers(stored.samples), places.committed)
                os.fsync(handle)
            finally:
                os.close(handle)
            goes_on = self._handle is not None
            self._close()
            try:
                move_into_place(part, self._path)
            except OSError:
                if goes_on:
                    self._handle = open_locked(self._path)
                raise
            self._handle = open_locked(self._path)
            undo.pop_all()
        self._places = places
        self._count, self._checksums = stored.samples, dict(stored.checksums)
        self._in_force = 0  # which of a variable's two checksums holds
        self._committed, self._committed_at, self._commit_cost = stored.samples, time.monotonic(), 0.0

    def _close(self) -> None:
        """Let go of the file, if there is one."""
        if self._handle is not None:
            os.close(self._handle)
        self._handle = None

    def _copy(self, handle: int, places: Places, count: int) -> dict[str, int]:
        """Copy the first samples of the file in place; gives the checksums of what was copied."""
        checksums = dict.fromkeys(self._variables, 0)
        with h5py.File(self._path, "r", locking=False) as earlier:
            for name in self._variables:
                for start in range(0, count, BLOCK):
                    block = earlier[name][start : min(start + BLOCK, count)]
                    write_at(handle, _doubles(block), places.start[name] + start * places.width[name])
                    checksums[name] = checksum(block, checksums[name])
            for name in places.of_frames:
                frames, width = earlier[name], places.width[name]
                if frames.dtype.itemsize * prod(frames.shape[1:]) != width:
                    raise UsageError(f"{self._path}: damaged: {name} is of another mesh; start again without --resume")
                for index in range(frames_of(count, self._plan.frame_stride)):
                    write_at(handle, frames[index].tobytes(), places.start[name] + index * width)
        return checksums

    def _further(self, capacity: int) -> Callable[[h5py.File], list[str]]:
        """What makes room for the frames of so many samples, and writes the events where they are known."""

        def further(file: h5py.File) -> list[str]:
            write_scene_files(file, self._plan.scene)
            if self._plan.scene.axial is not None and self._plan.scene.model != "lagrange":
                from fem.statics.tilted_pressures import scene_slices  # loads meshes' modules

                write_slices(file, scene_slices(self._plan.scene))
            if self._events is not None:
                write_events(file, self._bearing, self._events)
            if not self._plan.frame_stride:
                return []
            from fem.result.fields import lay_out  # other runs need none of the finite elements behind it

            return lay_out(file, self._plan.model, frames_of(capacity, self._plan.frame_stride))

        return further

    def keep(self, frame: "Frame") -> None:
        """Write the fields of a sample to come."""
        from fem.result.fields import stored_values

        if frame.sample >= self._plan.n_samples:
            return
        index = frame.sample // self._plan.frame_stride
        with self._named():
            for name, data in stored_values(self._plan.model, frame).items():
                write_at(self._handle, data, self._places.start[name] + index * self._places.width[name])

    @property
    def committed(self) -> int:
        """Samples that are on the disk."""
        return self._committed

    @property
    def is_in_place(self) -> bool:
        """Whether the file still stands where it was made: nobody has moved or removed it."""
        try:
            return self._handle is not None and os.path.samestat(os.fstat(self._handle), os.stat(self._path))
        except OSError:
            return False

    @property
    def stored(self) -> Stored:
        """What is in the file; on the disk after a `commit`."""
        return Stored(samples=self._count, checksums=dict(self._checksums))

    def append(self, samples: Mapping[str, np.ndarray]) -> None:
        """Add samples by variable; committed when COMMIT_SECONDS have gone by."""
        if not self._variables.keys() <= samples.keys():
            samples = {**samples, **sinkages(self._bearing, self._operation, samples)}
        with self._named():
            for name in self._variables:
                place = self._places.start[name] + self._count * self._places.width[name]
                write_at(self._handle, _doubles(samples[name]), place)
                self._checksums[name] = checksum(samples[name], self._checksums[name])
            self._count += len(samples["time"])
        if time.monotonic() - self._committed_at > max(COMMIT_SECONDS, self._commit_cost / COMMIT_SHARE):
            self.commit()

    def commit(self) -> None:
        """Bring the data to the disk, then say that it is there."""
        if self._count == self._committed:
            return
        began = time.monotonic()
        spare = 1 - self._in_force
        with self._named():
            for name, place in self._places.checksum.items():
                write_at(self._handle, _integers(self._count, self._checksums[name]), place + 16 * spare)
            os.fsync(self._handle)
            write_at(self._handle, _integers(self._count), self._places.committed)
            os.fsync(self._handle)
        self._in_force, self._committed, self._committed_at = spare, self._count, time.monotonic()
        self._commit_cost = self._committed_at - began

    def restart(self, **attributes: float | str) -> None:
        """Put an empty file with these attributes in this one's place; the samples so far are void."""
        self._attributes |= attributes
        self._replace(self._plan.n_samples, nothing_stored(self._plan))

    def _replace(self, capacity: int, stored: Stored) -> None:
        with self._named(), alone_in(self._path.parent):
            self._begin(capacity, stored)

    def finish(self, status: str, **attributes: float | str) -> None:
        """Write the outcome and the events, in a new file without unused room that takes this one's place."""
        self.commit()
        if spalls(self._bearing):
            with self._named(), h5py.File(self._path, "r", locking=False) as file:
                self._events = events_of(self._bearing, self._operation, file, self._count)
        outcome = dict(attributes, status=status)
        self._attributes |= outcome
        try:
            self._replace(self._count, self.stored)
        except WriteFailed:  # no room for two of them
            if not self.is_in_place:
                raise
            with self._named(), hdf5_to_write(self._path, "r+") as file:
                for name, value in outcome.items():
                    file.attrs.modify(name, value)
                if self._events is not None:
                    write_events(file, self._bearing, self._events)

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Name the file when the disk fails."""
        try:
            yield
        except (OSError, RuntimeError) as error:  # HDF5's own come as either
            number = getattr(error, "errno", None) or 0
            reason = getattr(error, "strerror", None) or str(error)
            if "HDF5" in reason or "(" in reason:  # its words, with addresses
                reason = os.strerror(number) if number else reason.partition(" (")[0]
            raise WriteFailed(number, reason, str(self._path)) from error

    def __enter__(self) -> "ResultFile":
        return self

    def __exit__(self, *_) -> None:
        self._close()


def frames_of(samples: int, stride: int) -> int:
    """How many frames belong to so many samples."""
    return -(-samples // stride) if stride else 0


def _doubles(values: np.ndarray) -> bytes:
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def _integers(*values: int) -> bytes:
    return np.array(values, dtype="<i8").tobytes()


def _attributes(plan: "Plan", setup_seconds: float) -> dict[str, object]:
    scene = plan.scene.to_toml()
    truth = {"faults": labels(plan.scene.ideal_bearing().faults)} if plan.scene.has_faults else {}
    return truth | dict(
        format_version=FORMAT_VERSION,
        program="run-fem",
        program_version=VERSION,
        source=source_digest(),
        scene=scene,
        scene_checksum=text_checksum(scene),
        mesh_nodes=plan.mesh_nodes,
        degrees_of_freedom=plan.degrees_of_freedom,
        time_step=plan.time_step,
        critical_time_step=plan.critical_time_step,
        steps=0,
        wall_seconds=0.0,
        setup_seconds=setup_seconds,
        warnings="\n".join(plan.warnings),
        status="running",
    )
