"""The dataset of a study: one NetCDF file with labelled dimensions, for xarray and whatever else reads NetCDF.

NetCDF, not Zarr: one file to hand on, the format of the result files, and nothing more to install: h5py writes it, HDF5
with dimension scales. What speaks for Zarr, many writers at once, is not needed: points have files of their own and one
process puts them together in pieces.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from math import nan
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fem.errors import UsageError
from fem.quantities import UNITS, labels
from fem.result.layout import readable
from fem.study.folder import MISSING, PROGRAM, Folder
from fem.study.solving import COMPLETE, LIBRARIES, Points, Solved
from fem.study.study_file import QUANTITIES
from lagrange.columns import PER_ROLLER
from lagrange.files.hdf5 import dimension, hdf5_to_write, label, variable
from lagrange.files.output import replaced
from lagrange.scene.keys import unit_of
from lagrange.version import VERSION

PIECE = 256  # points of signals held at once


def unit_of_key(key: str) -> str:
    """The unit that a key of the scene spells, as other variables have it: "1" where it spells none."""
    return unit_of(key) or "1"


def write_dataset(points: Points, folder: Folder, count: Callable[[], None] = lambda: None) -> dict[str, int]:
    """Write the dataset of all points that are done; how many there are of each status. `count`: after each point.

    Errors
    ------
    OSError: it can't be written; an earlier dataset stays.
    """
    with replaced(folder.dataset) as part, hdf5_to_write(part, track_order=True) as file:
        _lay_out(file, points)
        return _fill(file, points, folder, count)


def _lay_out(file, points: Points) -> None:
    """Dimensions, coordinates, attributes."""
    design, study = points.design, points.study
    if design.axes is None:
        for name, size in zip(design.dimensions, design.shape, strict=True):
            dimension(file, name, size)
    for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True)):
        values = [point[i] for point in design.points] if design.axes is None else list(design.axes[i])
        where = design.dimensions if design.axes is None else (name,)
        _variable(file, name, where, values, unit_of_key(key), f"scene key {key}")
    libraries = {name: version(name) for name in LIBRARIES}
    file.attrs.update(
        {
            "title": study.name,
            "program": PROGRAM,
            "program_version": VERSION,
            "program_digest": points.made_by,
            "libraries": json.dumps(libraries),
            "study": study.text,
            "scene": study.scene.to_toml(),
            "method": study.sampling.method,
            "seed": study.sampling.seed,
            "points": len(points),
            "sobol_base": design.base,
        }
    )


def _variable(file, name: str, where: tuple[str, ...], values, unit: str, meaning: str) -> None:
    words = any(isinstance(value, str) for value in values)
    data = np.array([("" if words else nan) if value is None else value for value in values])
    data = data.astype("i1") if data.dtype.kind == "b" else data
    shape = tuple(len(file[each]) if each != name else len(data) for each in where)
    variable(file, name, data.astype(object).reshape(shape) if words else data.reshape(shape), where, unit, meaning)


def _fill(file, points: Points, folder: Folder, count: Callable[[], None]) -> dict[str, int]:
    """Everything that the points tell; signals go to the disk in pieces."""
    design, keep, n = points.design, points.study.keep, len(points)
    numbers = {name: np.full(n, nan) for name in keep.quantities}
    status, text, seconds = np.full(n, MISSING, dtype=object), np.full(n, "", dtype=object), np.full(n, nan)
    marks: dict[str, list[Any]] = {name: [] for name in UNITS}
    signals = _Signals(file, points)
    variables = readable(points.scene(0))
    for i in range(n):
        solved = folder.read(points, i, variables)
        for name, value in labels(points.scene(i)).items():
            marks[name].append(value)
        if solved is not None:
            status[i], text[i], seconds[i] = solved.status, solved.text, solved.seconds
            for name, value in solved.quantities.items():
                numbers[name][i] = value
            if solved.status == COMPLETE:
                signals.add(i, solved)
        count()
    signals.flush()

    def put(name: str, values, unit: str, meaning: str) -> None:
        if name not in file:  # a parameter of the study tells it already
            _variable(file, name, design.dimensions, list(values), unit, meaning)

    for name, values in numbers.items():
        put(name, values, *QUANTITIES[name])
    for name, marked in marks.items():
        put(name, marked, UNITS[name], f"label: {name.replace('_', ' ')}")
    put("status", status, "1", f"status of the point: complete, failed, stopped (time limit) or {MISSING}")
    put("message", text, "1", "reason if the point is not complete")
    put("seconds", seconds, "s", "wall time of the point")
    names, counts = np.unique(status.astype(str), return_counts=True)
    return dict(zip(names.tolist(), counts.tolist(), strict=True))


class _Signals:
    """Signals on their way into the file, PIECE points at a time."""

    def __init__(self, file, points: Points):
        self._file, self._points = file, points
        self._waiting: list[tuple[int, Solved]] = []

    def add(self, i: int, solved: Solved) -> None:
        if solved.signals:
            self._waiting.append((i, solved))
        if len(self._waiting) >= PIECE:
            self.flush()

    def flush(self) -> None:
        if not self._waiting:
            return
        if "time" not in self._file:
            self._lay_out(self._waiting[0][1])
        shape = self._points.design.shape
        for i, solved in self._waiting:
            if any(values.shape != self._shapes[name] for name, values in solved.signals.items()):
                raise UsageError(
                    f"{self._points.design.describe(i)}: its signals have another length than those of other points; "
                    f"remove points/{self._points.digests[i]}.point, and --resume solves it again"
                )
            at = tuple(int(k) for k in np.unravel_index(i, shape))
            for name, values in solved.signals.items():
                self._file[name][at] = values
        self._waiting.clear()

    def _lay_out(self, first: Solved) -> None:
        """Room for the signals of all points, which are as long as the first one's."""
        file, design = self._file, self._points.design
        scene = self._points.scene(0)
        known = readable(scene)
        length = len(next(iter(first.signals.values())))
        self._shapes = {name: values.shape for name, values in first.signals.items()}
        time = first.signal_interval * np.arange(length)
        variable(file, "time", time, ("time",), "s", "time of the signals' samples")
        for name, values in first.signals.items():
            column = known[name]
            if column.dimensions == PER_ROLLER and "roller" not in file:
                dimension(file, "roller", values.shape[1])
            shape, chunks = (*design.shape, *values.shape), (*(1 for _ in design.shape), *values.shape)
            room = file.create_dataset(name, shape=shape, dtype="f8", chunks=chunks, fillvalue=nan)
            room.attrs["_FillValue"] = np.array([nan])
            label(file, name, (*design.dimensions, *column.dimensions), column.unit, column.meaning)


@dataclass(frozen=True, kw_only=True)
class Collected:
    """A dataset read back, signals left out: one entry a point, in the points' order."""

    quantities: dict[str, np.ndarray]  # (n_points,), float
    status: list[str]
    message: list[str]
    seconds: np.ndarray  # (n_points,), s
    attributes: dict[str, Any]

    @property
    def incomplete(self) -> Iterator[tuple[int, str, str]]:
        """Number, status and message of each point that is not complete."""
        for i, (status, text) in enumerate(zip(self.status, self.message, strict=True)):
            if status != COMPLETE:
                yield i, status, text


def read_dataset(path: Path, quantities: Iterable[str] = ()) -> Collected:
    """What a dataset says of its points."""
    with h5py.File(path, "r", locking=False) as file:
        return Collected(
            quantities={name: file[name][...].ravel() for name in quantities},
            status=file["status"].asstr()[...].ravel().tolist(),
            message=file["message"].asstr()[...].ravel().tolist(),
            seconds=file["seconds"][...].ravel(),
            attributes=dict(file.attrs),
        )
