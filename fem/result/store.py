"""The result file while a run writes it: what it holds, and where in it each number stands.

HDF5 lays the file out with room for all samples; the run then fills the numbers in by plain writes at known places, so
that the file's structure is never touched again. A process may die between any two writes and the file stays readable,
and a disk that fails is seen at once (HDF5 notices late, and then may crash). Each variable is one contiguous block.
It is HDF5's earliest format, whose headers carry no checksums: a counter in them changes by one write of eight aligned
bytes, which is made whole or not at all.

Samples are trusted up to the attribute `committed_samples`, which is written after the data it counts has reached the
disk. A killed run therefore leaves a readable file up to its last commit, with unused room behind; one that ends in any
other way leaves a file of exactly the samples it has.

Every variable has the attribute `checksum`: twice a number of samples and the CRC-32 of the variable up to there (as
little-endian doubles). The pair whose number is `committed_samples` holds; the other is the next one or the last one.
"""

import json
import os
import re
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import asdict
from functools import wraps
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import h5py
import numpy as np

from fem.result.run_file import lay_out, stored_samples, stored_values
from lagrange.axial.slices import write_slices
from lagrange.bearing import Bearing, Operation
from lagrange.columns import DERIVED, FORMAT_VERSION, OF_TILTED, PER_ROLLER, Column, columns_of
from lagrange.errors import UsageError
from lagrange.files import hdf5
from lagrange.files.output import BINARY, move_into_place, new_part, real_path, remove_left, replaced
from lagrange.scene.scene import Scene
from lagrange.surface import passages
from lagrange.surface.faults import labels
from lagrange.version import VERSION, source_digest

try:
    import fcntl
except ImportError:  # not a POSIX system: files are not locked there
    fcntl = None

if TYPE_CHECKING:
    from fem.solver.errors import Estimate
    from fem.solver.solver import Frame, Plan

COMMIT_SECONDS = 0.5  # of wall time between two commits
COMMIT_SHARE = 0.005  # of the wall time at most: a slow disk is asked less often
BLOCK = 4096  # samples copied at once
COMMITTED = "committed_samples"
MARK = 0x5EED_F00D_0000_0000  # plus a number: stands in a new file where a counter will be, to find the place
MARKED = re.compile(rb"(..)\0\0\x0d\xf0\xed\x5e", re.DOTALL)  # such a number's bytes

EVENTS = {  # columns of the group `events`: type, unit and meaning
    "time": ("<f8", "s", "instant"),
    "roller": ("<i8", "1", "roller"),
    "spall": ("<i8", "1", "spall, in the order of the attribute spalls"),
    "raceway": (object, "1", "whose contact passes the spall: inner, outer"),
    "kind": (object, "1", "entry, strike, exit"),
    "force": ("<f8", "N", "normal force of the contact"),
    "sliding_speed": ("<f8", "m/s", "roller's surface over the raceway's, along +theta"),
}
ESTIMATE = {  # meaning, and value of an `Estimate`
    "quantity": ("name of a quantity of interest", lambda each: each.quantity.name),
    "quantity_unit": ("unit of its value and error", lambda each: each.quantity.unit),
    "quantity_meaning": ("what it is", lambda each: each.quantity.meaning),
    "quantity_value": ("on the run's mesh", lambda each: each.quantity.value),
    "quantity_coarse_value": ("on the coarser mesh", lambda each: each.coarse_value),
    "quantity_error": ("estimated discretisation error of the value, not negative", lambda each: each.error),
}


def variables_of(scene: Scene) -> Mapping[str, Column]:
    """Columns of a run of this scene by name."""
    return columns_of("", *scene.parts)


def readable(scene: Scene) -> Mapping[str, Column]:
    """What a run of this scene can be asked for: its columns, and what is computed from them when it is read."""
    tilted_or_not = OF_TILTED if scene.axial is not None else DERIVED
    return {**variables_of(scene), **(tilted_or_not if scene.bearing.type == "roller" else {})}


def bytes_of_a_sample(scene: Scene) -> int:
    """What a sample takes in the file."""
    columns = variables_of(scene).values()
    return sum(8 * (scene.bearing.present if column.dimensions == PER_ROLLER else 1) for column in columns)


def sinkages(bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of the sinkage under each contact of surfaces that are not perfect."""
    met = zip(("inner", "outer"), passages.surfaces_met(bearing, operation, samples), strict=True)
    return {f"{side}_sinkage": at.sinkage + at.part_sinkage for side, at in met}


def events_of(
    bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray], count: int
) -> list[passages.SpallEvent]:
    """Events of the first `count` samples of a run, or of its open result file.

    They follow from the samples alone, whichever solver these come from, and are found when a run ends: they are the
    same however often it was interrupted and resumed."""
    names = [name for name in (*passages.COLUMNS, *passages.HOUSING) if name in samples]
    part = lambda start, stop: {name: samples[name][start:stop] for name in names}  # noqa: E731
    return passages.spall_events(passages.find_passages(bearing, operation, part, count))


@contextmanager
def alone_in(folder: Path, wait: bool = True) -> Iterator[None]:
    """Hold a folder while a file in it is examined and exchanged, so that no other run does the same in between.

    Without effect on file systems that can't lock a folder. BlockingIOError: another holds it, and `wait` is False."""
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        if not _locked(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB)):
            raise BlockingIOError(f"{folder}: in use")
        yield
    finally:
        os.close(handle)


def _locked(handle, how):
    """Lock a file or folder; False where another has locked it. True on file systems without locks."""
    with suppress(OSError):
        try:
            fcntl.flock(handle, how)
        except BlockingIOError:
            return False
    return True


def _open_locked(path):
    """Open a file to write it, where others may read it but see by its lock that it is in use; the handle."""
    handle = os.open(path, os.O_RDWR | BINARY)
    if fcntl is not None:
        _locked(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    return handle


def write_at(handle: int, data: bytes, place: int) -> None:
    """Write all of it there. OSError: the disk fails."""
    view = memoryview(data)
    os.lseek(handle, place, os.SEEK_SET)  # pwrite is not on every system
    while view:
        view = view[os.write(handle, view) :]


def _claim(path, size=None):
    """Reserve bytes of a file, None: all it has, so that writing them later can't fail for want of room."""
    with open(path, "r+b") as file:
        size = os.fstat(file.fileno()).st_size if size is None else size
        if hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(file.fileno(), 0, size)
            except OSError as error:
                raise OSError(error.errno, f"{error.strerror}: {size / 1e6:.3g} MB are needed") from None


class Stored(NamedTuple):
    """How far a result file had come when its run's state was saved."""

    samples: int = 0
    checksums: Mapping[str, int] = {}  # of each variable's first `samples`, unless there are none


class Places(NamedTuple):
    """Where numbers stand in a result file: bytes from its start."""

    start: dict[str, int]  # of each variable: its first sample, or frame of fields
    width: dict[str, int]  # bytes of one sample, or frame, of it
    checksum: dict[str, int]  # two pairs of int64: samples, CRC-32
    committed: int  # int64
    of_frames: list[str]  # variables that frames of fields are of


class WriteFailed(OSError):
    """The result file can't be written any more; what it has committed stays."""


def _naming_the_file(method):  # writeFailed with the file's name, when the disk fails
    @wraps(method)
    def named(self, *arguments, **options):
        try:
            return method(self, *arguments, **options)
        except WriteFailed:
            raise
        except (OSError, RuntimeError) as error:  # HDF5's own come as either
            number, reason = getattr(error, "errno", None) or 0, getattr(error, "strerror", None) or str(error)
            if "HDF5" in reason or "(" in reason:  # its words, with addresses
                reason = os.strerror(number) if number else reason.partition(" (")[0]
            raise WriteFailed(number, reason, str(self.path)) from error

    return named


class ResultFile(AbstractContextManager):
    """Appends samples; use as a context manager.
    UsageError: another program has the file open; it is not what was stored. OSError: no room on the disk, a folder or
    an earlier file that can't be written; an earlier file stays as it was. WriteFailed, later: the disk fails."""

    def __init__(
        self, path: Path, plan: "Plan", setup_seconds: float, resume: Stored | None = None, **attributes: float | str
    ):
        """A new file in the place of any earlier one, or one that goes on after what was stored.
        `attributes` are those that the run has found out, in place of the plan's."""
        self.path, self._plan, scene = real_path(path), plan, plan.scene
        self._variables = variables_of(scene)
        self._surfaces = scene.ideal_bearing(), scene.ideal_operation()
        self._attributes = {
            **({"faults": labels(self._surfaces[0].faults)} if scene.has_faults else {}),
            "format_version": FORMAT_VERSION, "program": "run-fem", "program_version": VERSION,
            "source": source_digest(),  # of the program's own code
            "scene": scene.to_toml(), "scene_checksum": hdf5.text_checksum(scene.to_toml()),
            "mesh_nodes": plan.mesh_nodes, "degrees_of_freedom": plan.degrees_of_freedom,
            "time_step": plan.time_step, "critical_time_step": plan.critical_time_step,  # s; with all contacts closed
            "steps": 0, "wall_seconds": 0.0, "setup_seconds": setup_seconds,  # wall: of the time loop, setup: before it
            "warnings": "\n".join(plan.warnings), "status": "running",
            **attributes,
        }  # fmt: skip
        self._handle: int | None = None
        self._events: list[passages.SpallEvent] | None = None  # known when the run has ended, on bearings with spalls
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with alone_in(self.path.parent):
            self._check_place(resume)
            self._begin(plan.n_samples, resume or Stored())

    def _check_place(self, resume):
        """Refuse what is open elsewhere or no plain file, what can't have been a result, as the scene itself, and to go
        on with a file that does not hold the samples of the variables, and the frames, that were stored. UsageError."""
        path, start, other = self.path, b"", "name another with --output"
        if path.exists():
            if not path.is_file():
                raise UsageError(f"{path}: is not a plain file; {other}")
            with open(path, "r+b") as file:
                if fcntl is not None and not _locked(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB):
                    raise UsageError(f"{path}: is in use, by another run or a program that reads it; {other}")
                start = file.read(len(hdf5.SIGNATURE))
        elif resume is not None:
            raise UsageError(f"{path}: not found, though its checkpoint is there; start again without --resume")
        if resume is None:
            if start not in (b"", hdf5.SIGNATURE):
                raise UsageError(f"{path}: is no result file (HDF5) and is not replaced; {other}")
            return
        try:
            with h5py.File(path, "r", locking=False) as file:
                if int(file.attrs[COMMITTED]) < resume.samples:
                    raise hdf5.Damaged(f"its checkpoint counts {resume.samples} samples, it holds fewer")
                for name in self._variables:
                    hdf5.check_array(file, name, resume.samples)
                if frames := self._frames(resume.samples):
                    if len(stored_samples(file, resume.samples)) != frames:
                        raise hdf5.Damaged(f"its checkpoint counts {frames} frames of fields, it holds others")
        except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
            raise UsageError(f"{path}: can't be resumed ({error}); start again without --resume") from None

    @_naming_the_file
    def _begin(self, capacity, stored):
        """Put a new file with the samples stored in the earlier one in its place, and go on with it.

        While the files change places neither is open, as not every system allows that."""
        with ExitStack() as undo:
            remove_left(self.path)
            part = new_part(self.path)
            undo.callback(part.unlink, missing_ok=True)
            places = self._lay_out(part, max(1, capacity))  # HDF5 gives nothing no place
            checksums, handle = {name: stored.checksums.get(name, 0) for name in self._variables}, _open_locked(part)
            try:
                if stored.samples and self._copy(handle, places, stored.samples) != checksums:
                    raise UsageError(f"{self.path}: damaged: its samples are not those that were written; start again")
                for name, place in places.checksum.items():
                    write_at(handle, _integers(stored.samples, checksums[name], -1, 0), place)
                write_at(handle, _integers(stored.samples), places.committed)
                os.fsync(handle)
            finally:
                os.close(handle)
            goes_on = self._handle is not None
            self.close()
            try:
                move_into_place(part, self.path)
            finally:
                if goes_on or not part.exists():
                    self._handle = _open_locked(self.path)
            undo.pop_all()
        self._places, self._count, self._checksums = places, stored.samples, checksums
        self._in_force = 0  # which of a variable's two checksums holds
        self.committed = stored.samples  # on the disk
        self._committed_at, self._commit_cost = time.monotonic(), 0.0

    def _lay_out(self, path, capacity):
        """A new file with room for so many samples, times NaN until they are written; with events where they are known.
        OSError: the disk has not enough room."""
        scene, variables = self._plan.scene, self._variables
        _claim(path, capacity * bytes_of_a_sample(scene))  # before HDF5 tries, which would name no reason
        with hdf5.hdf5_to_write(path, libver="earliest") as file:
            rollers = np.array(self._surfaces[0].pocket, dtype=np.int64)
            hdf5.variable(file, "roller", rollers, ("roller",), "1", "roller, counted along +theta")
            for number, (name, column) in enumerate(variables.items(), start=1):
                shape = (capacity, len(rollers))[: len(column.dimensions)]
                hdf5.new_block(file, name, shape, "<f8", np.nan if name == "time" else None)
                hdf5.label(file, name, column.dimensions, column.unit, column.meaning)
                file[name].attrs[hdf5.CHECKSUM] = np.array([MARK + number, 0, 0, 0], dtype="<i8")
            file.attrs.update({**self._attributes, COMMITTED: MARK})
            for number, text in enumerate(scene.files.values()):  # so that the result can be read without them
                name, content = hdf5.SCENE_FILE.format(number), np.frombuffer(text.encode(), dtype=np.uint8)
                about = {"units": "1", "long_name": "text of a file that the scene names, UTF-8"}
                file.create_dataset(name, data=content).attrs.update(about)
            if scene.axial is not None and scene.model != "lagrange":
                from fem.statics.tilted_pressures import scene_slices  # loads meshes' modules

                write_slices(file, scene_slices(scene))
            self._write_events(file)
            of_frames = []
            if self._plan.frame_stride:
                of_frames = lay_out(file, self._plan.model, self._frames(capacity))
            start = {name: file[name].id.get_offset() for name in (*variables, *of_frames)}
            size = {name: file[name].nbytes for name in start}
            width = {name: size[name] // len(file[name]) for name in start}
        _claim(path)
        marks, at = {}, 0  # places of all marks by number, which stand between the blocks of samples
        with open(path, "rb") as file:
            for end, length in sorted([*((start[name], size[name]) for name in start), (path.stat().st_size, 0)]):
                file.seek(at)
                for found in MARKED.finditer(file.read(end - at)):
                    marks[int.from_bytes(found[1], "little")] = at + found.start()
                at = end + length
        checksum = {name: marks[number] for number, name in enumerate(variables, start=1)}
        return Places(start, width, checksum, marks[0], of_frames)

    def _write_events(self, file):
        """The group `events`, one row an event; its attribute `spalls` tells what they are, SI."""
        if self._events is None:
            return
        group = file.create_group("events")
        group.attrs["spalls"] = json.dumps([asdict(spall) for spall in passages.spalls(self._surfaces[0])])
        hdf5.variable(group, "event", np.arange(len(self._events), dtype="<i8"), ("event",), "1", "event, by time")
        for name, (kind, unit, meaning) in EVENTS.items():
            values = np.array([getattr(event, name) for event in self._events], dtype=kind)
            hdf5.variable(group, name, values, ("event",), unit, meaning)

    def _copy(self, handle, places, count):
        """Copy the first samples of the file in place; gives the checksums of what was copied."""
        checksums = dict.fromkeys(self._variables, 0)
        with h5py.File(self.path, "r", locking=False) as earlier:
            for name in self._variables:
                for start in range(0, count, BLOCK):
                    block = earlier[name][start : min(start + BLOCK, count)]
                    write_at(handle, _doubles(block), places.start[name] + start * places.width[name])
                    checksums[name] = hdf5.checksum(block, checksums[name])
            for name in places.of_frames:
                frames, width = earlier[name], places.width[name]
                if frames.dtype.itemsize * prod(frames.shape[1:]) != width:
                    raise UsageError(f"{self.path}: damaged: {name} is of another mesh; start again without --resume")
                for index in range(self._frames(count)):
                    write_at(handle, frames[index].tobytes(), places.start[name] + index * width)
        return checksums

    def _frames(self, samples):  # how many frames belong to so many samples
        stride = self._plan.frame_stride
        return -(-samples // stride) if stride else 0

    @_naming_the_file
    def keep(self, frame: "Frame") -> None:
        """Write the fields of a sample to come."""
        if frame.sample < self._plan.n_samples:
            index = frame.sample // self._plan.frame_stride
            for name, data in stored_values(self._plan.model, frame).items():
                write_at(self._handle, data, self._places.start[name] + index * self._places.width[name])

    @property
    def is_in_place(self) -> bool:  # whether the file still stands where it was made: nobody has moved or removed it
        with suppress(OSError):
            return self._handle is not None and os.path.samestat(os.fstat(self._handle), os.stat(self.path))
        return False

    stored = property(lambda self: Stored(samples=self._count, checksums=dict(self._checksums)))

    @_naming_the_file
    def append(self, samples: Mapping[str, np.ndarray]) -> None:
        """Add samples by variable; committed when COMMIT_SECONDS have gone by."""
        if not self._variables.keys() <= samples.keys():
            samples = {**samples, **sinkages(*self._surfaces, samples)}
        for name in self._variables:
            place = self._places.start[name] + self._count * self._places.width[name]
            write_at(self._handle, _doubles(samples[name]), place)
            self._checksums[name] = hdf5.checksum(samples[name], self._checksums[name])
        self._count += len(samples["time"])
        if time.monotonic() - self._committed_at > max(COMMIT_SECONDS, self._commit_cost / COMMIT_SHARE):
            self.commit()

    @_naming_the_file
    def commit(self) -> None:
        """Bring the data to the disk, then say that it is there."""
        if self._count == self.committed:
            return
        began, spare = time.monotonic(), 1 - self._in_force
        for name, place in self._places.checksum.items():
            write_at(self._handle, _integers(self._count, self._checksums[name]), place + 16 * spare)
        os.fsync(self._handle)
        write_at(self._handle, _integers(self._count), self._places.committed)
        os.fsync(self._handle)
        self._in_force, self.committed, self._committed_at = spare, self._count, time.monotonic()
        self._commit_cost = self._committed_at - began

    @_naming_the_file
    def restart(self, **attributes: float | str) -> None:
        """Put an empty file with these attributes in this one's place; the samples so far are void."""
        self._attributes |= attributes
        with alone_in(self.path.parent):
            self._begin(self._plan.n_samples, Stored())

    @_naming_the_file
    def finish(self, status: str, **attributes: float | str) -> None:
        """Write the outcome and the events, in a new file without unused room that takes this one's place."""
        self.commit()
        if passages.spalls(self._surfaces[0]):
            with h5py.File(self.path, "r", locking=False) as file:
                self._events = events_of(*self._surfaces, file, self._count)
        outcome = dict(attributes, status=status)
        self._attributes |= outcome
        try:
            with alone_in(self.path.parent):
                self._begin(self._count, self.stored)
        except WriteFailed:  # no room for two of them
            if not self.is_in_place:
                raise
            with hdf5.hdf5_to_write(self.path, "r+") as file:
                for name, value in outcome.items():
                    file.attrs.modify(name, value)
                self._write_events(file)

    def close(self) -> None:
        """Let go of the file."""
        if self._handle is not None:
            os.close(self._handle)
        self._handle = None

    def __exit__(self, *_) -> None:
        self.close()


def _doubles(values):
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def _integers(*values):
    return np.array(values, dtype="<i8").tobytes()


def write_estimates(path: Path, found: "list[Estimate]", coarse_mesh_size: float) -> None:
    """Add error estimates to a finished result file, which is exchanged for one that has them.
    `coarse_mesh_size` : of the coarser run, m
    OSError: no room for a second file; the first stays as it is."""
    path = real_path(path)
    with alone_in(path.parent), replaced(path, durable=True) as part:
        shutil.copyfile(path, part)
        with hdf5.hdf5_to_write(part, "r+") as file:
            for name in reversed(ESTIMATE):  # of an earlier estimate
                if name in file:
                    del file[name]
            for name, (meaning, value) in ESTIMATE.items():
                values = [value(estimate) for estimate in found]
                words = isinstance(values[0], str)
                values = np.array(values, dtype=object if words else float)
                hdf5.variable(file, name, values, ("quantity",), "1" if words else "see quantity_unit", meaning)
            file.attrs["coarse_mesh_size"] = coarse_mesh_size
