"""The dataset of a study: one NetCDF file with labelled dimensions, for xarray and whatever else reads NetCDF."""

import json
from collections.abc import Callable, Iterator
from importlib.metadata import version
from math import nan

import numpy as np
import xarray

from fem.quantities import UNITS, labels
from fem.result.layout import readable
from fem.study.folder import MISSING, PROGRAM, Folder
from fem.study.solving import COMPLETE, LIBRARIES, Points
from fem.study.study_file import QUANTITIES
from lagrange.errors import UsageError
from lagrange.files.output import replaced
from lagrange.scene.keys import unit_of
from lagrange.version import VERSION

STATUS = f"status of the point: complete, failed, stopped (time limit) or {MISSING}"


def unit_of_key(key: str) -> str:
    """The unit that a key of the scene spells, as other variables have it: "1" where it spells none."""
    return unit_of(key) or "1"


def write_dataset(points: Points, folder: Folder, count: Callable[[], None] = lambda: None) -> xarray.Dataset:
    """The dataset of all points that are done, which is written too; `count`: after each point.

    Errors
    ------
    OSError: it can't be written; an earlier dataset stays. UsageError: signals of several lengths.
    """
    found = collected(points, folder, count)
    with replaced(folder.dataset) as part:
        try:
            found.to_netcdf(part, engine="netcdf4")
        except RuntimeError as error:  # the library's, of a disk that fails
            raise OSError(f"can't be written: {error}") from None
    return found


def collected(points: Points, folder: Folder, count: Callable[[], None]) -> xarray.Dataset:
    """Values of parameters, and all that the points tell."""
    design, study, n = points.design, points.study, len(points)
    numbers = {name: np.full(n, nan) for name in study.keep.quantities}
    status, message, seconds = [MISSING] * n, [""] * n, np.full(n, nan)
    marks = []
    signals: dict[str, np.ndarray] = {}
    interval, known = 0.0, readable(points.scene(0))
    for i in range(n):
        marks.append(labels(points.scene(i)))
        if (solved := folder.read(points.digests[i])) is not None:
            status[i], message[i], seconds[i] = solved.status, solved.text, solved.seconds
            for name in numbers.keys() & solved.quantities.keys():
                numbers[name][i] = solved.quantities[name]
            for name in study.keep.signals if solved.status == COMPLETE else ():
                values = solved.signals[name]
                if name not in signals:
                    signals[name] = np.full((n, *values.shape), nan)
                if (room := signals[name]).shape[1:] != values.shape:
                    raise UsageError(
                        f"{design.describe(i)}: its signals have another length than those of other points; "
                        f"remove points/{points.digests[i]}.point, and --resume solves it again"
                    )
                room[i], interval = values, solved.signal_interval
        count()
    variables: dict[str, tuple] = {}

    def put(name: str, values, unit: str, meaning: str, further: tuple[str, ...] = ()) -> None:
        """A variable of the points; a parameter of the study may tell it already."""
        data = values if isinstance(values, np.ndarray) else _array(values)
        data, about = data.reshape(*design.shape, *data.shape[1:]), {"units": unit, "long_name": meaning}
        variables.setdefault(name, ((*design.dimensions, *further), data, about))

    for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True)):
        about = unit_of_key(key), f"scene key {key}"
        if design.axes is None:
            put(name, [point[i] for point in design.points], *about)
        else:
            variables[name] = name, _array(list(design.axes[i])), dict(zip(("units", "long_name"), about, strict=True))
    for name, values in numbers.items():
        put(name, values, *QUANTITIES[name])
    for name, unit in UNITS.items():
        put(name, [mark[name] for mark in marks], unit, f"label: {name.replace('_', ' ')}")
    put("status", status, "1", STATUS)
    put("message", message, "1", "reason if the point is not complete")
    put("seconds", seconds, "s", "wall time of the point")
    for name, values in signals.items():
        put(name, values, known[name].unit, known[name].meaning, known[name].dimensions)
    if signals:
        time = interval * np.arange(next(iter(signals.values())).shape[1])
        variables["time"] = "time", time, {"units": "s", "long_name": "time of the signals' samples"}
    attributes = {
        "title": study.name,
        "program": PROGRAM,
        "program_version": VERSION,
        "program_digest": points.made_by,
        "libraries": json.dumps({name: version(name) for name in LIBRARIES}),
        "study": study.text,
        "scene": study.scene.to_toml(),
        "method": study.sampling.method,
        "seed": study.sampling.seed,
        "points": n,
        "sobol_base": design.base,
    }
    return xarray.Dataset(variables, attrs=attributes)


def _array(values: list) -> np.ndarray:
    """Numbers, NaN for None; or words, "" for None."""
    words = any(isinstance(value, str) for value in values)
    data = np.array([("" if words else nan) if value is None else value for value in values])
    return data.astype(object if words else "i1" if data.dtype.kind == "b" else data.dtype)


def incomplete(found: xarray.Dataset) -> Iterator[tuple[int, str, str]]:
    """Number, status and message of each point that is not complete."""
    for i, (status, text) in enumerate(zip(found.status.values.flat, found.message.values.flat, strict=True)):
        if status != COMPLETE:
            yield i, status, text
