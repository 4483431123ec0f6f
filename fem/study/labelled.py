"""Signals of a study with their labels, for whoever trains on them: tar shards or Parquet, and a datasheet.

A shard is a plain tar file in the order that WebDataset reads: of point 12 `000012.json`, its labels, and
`000012.sensor_ay.npy`, a signal in SI. A Parquet file has a row for each point. Only complete points are in either.
"""

import io
import json
import tarfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np

from fem.errors import UsageError
from fem.study.dataset import PIECE
from fem.study.solving import COMPLETE
from lagrange.files.output import replaced, write_whole
from lagrange.version import VERSION

Form = Literal["shards", "parquet"]
POINTS_A_SHARD = 1000
OF_RUNNING = ("status", "message", "seconds")  # of the dataset, and no labels
DATASHEET = "DATASHEET.md"
PARQUET = "signals.parquet"


@dataclass(frozen=True, kw_only=True)
class Column:
    """A variable of the dataset."""

    name: str
    unit: str
    meaning: str
    values: np.ndarray  # (n_points,) of a label


class Labelled:
    """Labels and signals of a dataset's complete points."""

    def __init__(self, file: h5py.File):
        status = file["status"]
        design = tuple(dimension[0].name for dimension in status.dims)
        self.shape, self.attributes = status.shape, dict(file.attrs)
        statuses = status.asstr()[...].ravel()
        self.counts = Counter(statuses.tolist())
        self.points = np.flatnonzero(statuses == COMPLETE)
        self.labels: list[Column] = []
        self.signals: list[h5py.Dataset] = []
        self.time = file["time"][...] if "time" in file else np.empty(0)
        for name, data in file.items():
            if name in OF_RUNNING or data.attrs.get("units") is None:
                continue
            dimensions = tuple(d[0].name if len(d) else data.name for d in data.dims)
            if dimensions == design or (len(dimensions) == 1 and dimensions[0] in design):
                self.labels.append(_label(name, data, design, dimensions, self.shape))
            elif dimensions[: len(design)] == design:
                self.signals.append(data)

    def facts(self, i: int) -> dict[str, Any]:
        """Labels of a point; null where it has none."""
        found = {}
        for column in self.labels:
            value = column.values[i]
            value = value.item() if hasattr(value, "item") else value
            found[column.name] = None if value != value or value == "" else value
        return found

    def signal(self, data: h5py.Dataset, points: np.ndarray) -> np.ndarray:
        """One signal of points, (n_points, n_times) or (n_points, n_times, n_rollers), float32."""
        return np.array([data[np.unravel_index(i, self.shape)] for i in points], dtype=np.float32)


def _label(name: str, data: h5py.Dataset, design: tuple[str, ...], dimensions: tuple[str, ...], shape) -> Column:
    values = data.asstr()[...] if h5py.check_string_dtype(data.dtype) else data[...]
    if dimensions != design:  # a parameter of a grid
        along = [1] * len(design)
        along[design.index(dimensions[0])] = -1
        values = np.broadcast_to(values.reshape(along), shape)
    return Column(name=name, unit=data.attrs["units"], meaning=data.attrs["long_name"], values=values.ravel())


def write_labelled(dataset: Path, form: Form, count: Callable[[], None] = lambda: None) -> list[Path]:
    """Write a dataset's signals and labels beside it, with a datasheet; the files.

    Errors
    ------
    UsageError: the study keeps no signals, no point is complete. OSError: it can't be written.
    """
    with h5py.File(dataset, "r", locking=False) as file:
        data = Labelled(file)
        if not data.signals:
            raise UsageError(
                f'--export {form}: the study keeps no signals; add them, as [keep] signals = ["sensor_ay"]'
            )
        if not data.points.size:
            raise UsageError(f"--export {form}: no point is complete")
        write = _write_shards if form == "shards" else _write_parquet
        files = write(data, dataset.parent, count)
        write_whole(dataset.parent / DATASHEET, datasheet(data, files).encode())
    return [*files, dataset.parent / DATASHEET]


def _write_shards(data: Labelled, folder: Path, count: Callable[[], None]) -> list[Path]:
    """Tar files of so many points; the same dataset gives the same bytes."""
    files = []
    for first in range(0, data.points.size, POINTS_A_SHARD):
        files.append(folder / f"signals-{first // POINTS_A_SHARD:05d}.tar")
        with replaced(files[-1]) as part, tarfile.TarFile(part, "w", format=tarfile.USTAR_FORMAT) as archive:
            for i in data.points[first : first + POINTS_A_SHARD].tolist():
                _add(archive, f"{i:06d}.json", json.dumps(data.facts(i), allow_nan=False).encode())
                for signal in data.signals:
                    buffer = io.BytesIO()
                    np.save(buffer, data.signal(signal, np.array([i]))[0])
                    _add(archive, f"{i:06d}.{signal.name.strip('/')}.npy", buffer.getvalue())
                count()
    return files


def _add(archive: tarfile.TarFile, name: str, content: bytes) -> None:
    entry = tarfile.TarInfo(name)
    entry.size = len(content)
    archive.addfile(entry, io.BytesIO(content))


def _write_parquet(data: Labelled, folder: Path, count: Callable[[], None]) -> list[Path]:
    """One file, a group of rows for so many points; units and meanings are in the columns' metadata."""
    import pyarrow as pa
    from pyarrow import parquet

    facts = [data.facts(i) for i in data.points.tolist()]
    fields = [
        pa.field(c.name, pa.array([row[c.name] for row in facts]).type, metadata={"unit": c.unit, "meaning": c.meaning})
        for c in data.labels
    ]
    for signal in data.signals:
        kind = pa.float32()
        for size in reversed(signal.shape[len(data.shape) :]):
            kind = pa.list_(kind, size)
        about = {"unit": signal.attrs["units"], "meaning": signal.attrs["long_name"]}
        fields.append(pa.field(signal.name.strip("/"), kind, metadata=about))
    schema = pa.schema(fields, metadata={"sampling_rate_Hz": f"{_rate(data):.9g}"})
    path = folder / PARQUET
    with replaced(path) as part, parquet.ParquetWriter(part, schema, compression="zstd") as writer:
        for first in range(0, data.points.size, PIECE):
            points = data.points[first : first + PIECE]
            columns = [pa.array([row[c.name] for row in facts[first : first + PIECE]]) for c in data.labels]
            for signal in data.signals:
                values = data.signal(signal, points)
                column = pa.array(values.ravel())
                for size in reversed(values.shape[1:]):
                    column = pa.FixedSizeListArray.from_arrays(column, size)
                columns.append(column)
            writer.write_table(pa.table(columns, schema=schema))
            for _ in points:
                count()
    return [path]


def _rate(data: Labelled) -> float:
    return 1.0 / float(data.time[1] - data.time[0]) if data.time.size > 1 else 0.0


def datasheet(data: Labelled, files: list[Path]) -> str:
    """What the data are, where they come from and what they are not, as Gebru et al. ask (Datasheets for Datasets)."""
    about = data.attributes
    left = ", ".join(f"{count} {status}" for status, count in data.counts.items() if status != COMPLETE)
    lines = [
        f"# Datasheet of {about['title']}", "",
        f"Simulated vibration of a roller bearing, made by run-study {about['program_version']}; datasheet by version "
        f"{VERSION}.", "",
        "## Composition", "",
        f"{data.points.size} complete points of {sum(data.counts.values())}" + (f" ({left}, left out)" if left else "")
        + f", {data.time.size} samples each at {_rate(data):.6g} Hz, in {', '.join(path.name for path in files)}. "
        "Signals are 32-bit floating point in SI; null marks a label that a point does not have.", "",
        "| signal | unit | meaning |", "|---|---|---|",
        *(f"| {s.name.strip('/')} | {s.attrs['units']} | {s.attrs['long_name']} |" for s in data.signals), "",
        "| label | unit | meaning | values |", "|---|---|---|---|",
        *(f"| {c.name} | {c.unit} | {c.meaning} | {_span(c, data.points)} |" for c in data.labels), "",
        "## Collection", "",
        f"Points by the method \"{about['method']}\", seed {about['seed']}. Every point is a scene solved by the model "
        "that it names; the same study, program and libraries give the same numbers.", "",
        "## What the signals are not", "",
        "* Signals of a model: the housing is as simple as the scene has it, there is no noise, no neighbouring "
        "machine, and no sensor but the scene's.",
        "* One damage a label, made as the scene describes it; real damage is rough and grows.",
        "* Not split: points that share a parameter are alike, so split by parameter, not at random, to learn how "
        "well a method carries over.",
        "* A method that does well here has not been shown to do well on a machine.", "",
        "## Study", "", "```toml", str(about["study"]).strip(), "```", "", "## Scene", "", "```toml",
        str(about["scene"]).strip(), "```", "",
    ]  # fmt: skip
    return "\n".join(lines)


def _span(column: Column, points: np.ndarray) -> str:
    """Range of numbers, or how many there are of each word."""
    values = column.values[points]
    if values.dtype.kind not in "fiu":
        return ", ".join(f"{word or 'null'}: {count}" for word, count in sorted(Counter(values.tolist()).items()))
    finite = values[np.isfinite(values)]
    if not finite.size:
        return "null"
    nulls = values.size - finite.size
    return f"{finite.min():.6g} … {finite.max():.6g}" + (f", null: {nulls}" if nulls else "")
