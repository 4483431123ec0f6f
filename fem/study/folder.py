"""A study's folder: what it is, a file for each point that is done, the dataset that is made of them, and its columns.

study.json     the study, its scene and the digest of each point: enough for dataset and page without solving
points/        a sealed file for each point, moved into place when it is whole
runs/          result files, where they are kept
study.nc       one NetCDF file with labelled dimensions, for xarray and whatever else reads NetCDF
study.html
"""

import io
import json
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from math import nan, prod
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import xarray
from pydantic import BaseModel, Field, ValidationError, model_validator

from fem.quantities import UNITS, labels
from fem.result.store import alone_in, readable
from fem.study.solving import COMPLETE, LIBRARIES, LOST, Points, Solved, program
from fem.study.study_file import QUANTITIES, Design, study_of
from lagrange.errors import UsageError
from lagrange.files.input import read_plain
from lagrange.files.output import read_sealed, replaced, write_sealed, write_whole
from lagrange.messages import engineering, say
from lagrange.scene.faults import printable
from lagrange.scene.keys import name_in_words, unit_of
from lagrange.scene.scene import parse_scene_text
from lagrange.version import VERSION

PROGRAM: Literal["run-study"] = "run-study"
MISSING = "missing"  # the status of a point that has not been solved
KEPT = "status", "text", "seconds", "quantities", "signal_interval"  # of a point beside its signals
SAME = "study", "listed", "scene", "files"  # in a study that is only resumed
BINS = 8  # of a parameter that takes a value of its own in each point
FEWEST = 2  # points
MOST_COLUMNS, MOST_LINES = 4, 12  # panels beside each other, lines in one
NOTHING = "-"  # the word of a cell that a list of points has left empty
Indices = tuple[np.ndarray, np.ndarray]  # Sobol's, of each parameter alone, and with all that it does with others
Value = bool | int | Annotated[float, Field(allow_inf_nan=False)] | str


class StudyRecord(BaseModel, extra="forbid", strict=True):
    """A study, its scene and the values and digests of its points."""

    program: Literal["run-study"] = PROGRAM
    version: str = "of an earlier version"
    name: str = Field(min_length=1)
    study: str
    listed: str | None
    scene: str
    files: dict[str, str]
    keys: tuple[str, ...] = Field(min_length=1)
    points: list[tuple[Value | None, ...]]
    axes: tuple[tuple[Value, ...], ...] | None
    base: int = Field(ge=0)
    digests: list[Annotated[str, Field(pattern="^[0-9a-f]{32}$")]] = Field(min_length=1)
    made_by: str

    @model_validator(mode="after")
    def _consistent(self):
        if any(len(point) != len(self.keys) for point in self.points) or len(self.points) != len(self.digests):
            raise ValueError("as many digests as points, of as many values as keys, are needed")
        if self.axes is not None and prod(len(axis) for axis in self.axes) != len(self.points):
            raise ValueError("axes: must make the points")
        return self


def _record_of(points):
    study = points.study
    return StudyRecord(
        version=VERSION, name=study.name, study=study.text, listed=study.listed, scene=study.scene.to_written_toml(),
        files=study.scene.files, **vars(points.design), digests=points.digests, made_by=points.made_by)  # fmt: skip


class Folder:
    """Where a study is kept."""

    def __init__(self, path: Path):
        self.path, self.dataset, self.page = path, path / "study.nc", path / "study.html"
        self._about = path / "study.json"

    def run(self, digest: str) -> Path:
        """A point's result file."""
        return self.path / "runs" / f"{digest}.nc"

    def _point(self, digest):
        return self.path / "points" / f"{digest}.point"

    def points(self) -> Points:
        """The study and its points as begun or last resumed. UsageError, SceneError: no study, or a damaged one."""
        facts = self._record()
        study = study_of(self._about, facts.study, facts.listed)
        scene = parse_scene_text(facts.scene, f"{self._about}: scene", facts.files)
        return Points(
            study=study._replace(name=facts.name, scene=scene),
            design=Design(keys=facts.keys, points=facts.points, axes=facts.axes, base=facts.base),
            digests=facts.digests, made_by=facts.made_by)  # fmt: skip

    def _record(self):
        try:
            return StudyRecord.model_validate_json(read_plain(self._about))
        except OSError as error:
            raise UsageError(f"{self.path}: no study: {error.strerror} (study.json)") from None
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            fault = printable(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": "))
            raise UsageError(f"{self._about}: damaged, or not of this version: {fault}") from None

    def other_program(self) -> str:
        """In words, which other program has begun the study or resumed it last; "" where it was this one."""
        record, this = self._record(), f"{VERSION}, program {program()}"
        begun = f"{record.version}, program {record.made_by}"
        same = record.made_by == program()
        return "" if same else f"{self.path}: begun by {PROGRAM} {begun}; this is {PROGRAM} {this}"

    def pending(self, points: Points) -> list[int]:
        """Points that have not been solved, each digest once."""
        first = {digest: i for i, digest in reversed(list(enumerate(points.digests)))}
        return sorted(i for digest, i in first.items() if self.read(digest) is None)

    def refuse_foreign(self, points: Points, resume: bool) -> None:
        """Refuse a folder that holds something else, or a study that is not to go on: UsageError."""
        if self.path.exists() and not self.path.is_dir():
            raise UsageError(f"{self.path}: is a file, not a folder; choose another --output")
        self._refuse_begun(points, resume)
        if not self._about.exists() and self.path.exists() and any(self.path.iterdir()):
            raise UsageError(f"{self.path}: not empty and no study; choose another --output or empty it")

    def _refuse_begun(self, points, resume):
        if not self._about.exists():
            return
        if not resume:
            raise UsageError(f"{self.path}: holds a study; --resume goes on with it, or choose another --output")
        earlier, now = self._record(), _record_of(points)
        is_same = all(getattr(earlier, name) == getattr(now, name) for name in SAME)
        if not is_same and (earlier.keys != now.keys or not set(earlier.digests) & set(now.digests)):
            raise UsageError(
                f"{self.path}: holds another study, none of whose points is one of this study; choose another --output"
            )

    @contextmanager
    def held(self, points: Points, resume: bool) -> Iterator[None]:
        """Begin a study, or go on with it, and let nobody else do so meanwhile. OSError: it can't be written.
        UsageError: another run works in the folder, or has begun a study there."""
        with self._naming():
            (place := self.path / "points").mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:
            try:
                stack.enter_context(alone_in(place, wait=False))
            except BlockingIOError:
                raise UsageError(
                    f"{self.path}: another run-study works there; wait for its end, or choose another --output"
                ) from None
            self._refuse_begun(points, resume)
            if self._about.exists() and (other := self.other_program()):
                say(f"warning: {other}; all points are solved again")
            self.begin(points)
            yield

    def begin(self, points: Points) -> None:
        """Write what the study is. OSError: it can't be written."""
        with self._naming():
            (self.path / "points").mkdir(parents=True, exist_ok=True)
            write_whole(self._about, _record_of(points).model_dump_json().encode())

    def read(self, digest: str) -> Solved | None:
        """What became of a point; None: not solved yet, or its file is damaged."""
        try:
            with np.load(io.BytesIO(read_sealed(self._point(digest)) or b"")) as arrays:
                signals = {name: arrays[name] for name in arrays.files}
            facts = json.loads(signals.pop("facts").tobytes())
            return Solved(signals=signals, **facts["solved"]) if facts["digest"] == digest else None
        except (OSError, LookupError, TypeError, ValueError, EOFError, zipfile.BadZipFile):
            return None

    def add(self, digest: str, solved: Solved) -> None:
        """Keep what became of a point; of one lost with its worker nothing, so that it is tried again. OSError: it
        can't be written."""
        if solved.status == LOST:
            return
        facts = {"digest": digest, "solved": {name: getattr(solved, name) for name in KEPT}}
        archive = io.BytesIO()
        arrays: dict[str, Any] = {"facts": np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8), **solved.signals}
        np.savez(archive, **arrays)
        with self._naming():
            if solved.run is not None:
                self.run(digest).parent.mkdir(exist_ok=True)
                write_whole(self.run(digest), solved.run)
            write_sealed(self._point(digest), archive.getvalue())

    @contextmanager
    def _naming(self):  # say what to do where the disk fails
        try:
            yield
        except OSError as error:
            reason = f"{error.strerror}; finished points are kept, --resume goes on"
            raise OSError(error.errno, reason, str(self.path)) from None


def write_dataset(points: Points, folder: Folder, count: Callable[[], None] = lambda: None) -> xarray.Dataset:
    """The dataset of all points that are done, which is written too; `count`: after each point. OSError: it can't be
    written; an earlier dataset stays. UsageError: signals of several lengths."""
    design, study, n = points.design, points.study, len(points)
    rows, signals = list[dict[str, Any]](), dict[str, np.ndarray]()
    interval, known = 0.0, readable(points.scene(0))
    for i, digest in enumerate(points.digests):
        solved = folder.read(digest) or Solved(status=MISSING, seconds=nan)
        row: dict[str, Any] = {name: float(solved.quantities.get(name, nan)) for name in study.keep.quantities}
        row |= dict(status=solved.status, message=solved.text, seconds=solved.seconds)
        rows.append(labels(points.scene(i)) | row)
        for name in study.keep.signals if solved.status == COMPLETE else ():
            values = solved.signals[name]
            if name not in signals:
                signals[name] = np.full((n, *values.shape), nan)
            if (room := signals[name]).shape[1:] != values.shape:
                raise UsageError(
                    f"{design.describe(i)}: its signals have another length than those of other points; "
                    f"remove points/{digest}.point, and --resume solves it again"
                )
            room[i], interval = values, solved.signal_interval
        count()
    variables: dict[str, tuple] = {}

    def put(name, values, unit, meaning, further=()):
        """A variable of the points; a parameter of the study may tell it already."""
        data = values if isinstance(values, np.ndarray) else _array(values)
        data, about = data.reshape(*design.shape, *data.shape[1:]), {"units": unit, "long_name": meaning}
        variables.setdefault(name, ((*design.dimensions, *further), data, about))

    for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True)):
        unit, meaning = unit_of(key) or "1", f"scene key {key}"
        if design.axes is None:
            put(name, [point[i] for point in design.points], unit, meaning)
        else:
            variables[name] = name, _array(list(design.axes[i])), {"units": unit, "long_name": meaning}
    described = {name: QUANTITIES[name] for name in study.keep.quantities}
    described |= {name: (unit, f"label: {name.replace('_', ' ')}") for name, unit in UNITS.items()} | {
        "status": ("1", f"status of the point: complete, failed, stopped (time limit) or {MISSING}"),
        "message": ("1", "reason if the point is not complete"), "seconds": ("s", "wall time of the point"),
    }  # fmt: skip
    for name, (unit, meaning) in described.items():
        put(name, [row[name] for row in rows], unit, meaning)
    for name, values in signals.items():
        put(name, values, known[name].unit, known[name].meaning, known[name].dimensions)
    if signals:
        time = interval * np.arange(next(iter(signals.values())).shape[1])
        variables["time"] = "time", time, {"units": "s", "long_name": "time of the signals' samples"}
    attributes = {
        "title": study.name, "program": PROGRAM, "program_version": VERSION, "program_digest": points.made_by,
        "libraries": json.dumps({name: version(name) for name in LIBRARIES}), "study": study.text,
        "scene": study.scene.to_toml(), "method": study.sampling.method, "seed": study.sampling.seed, "points": n,
        "sobol_base": design.base}  # fmt: skip
    dataset = xarray.Dataset(variables, attrs=attributes)
    with replaced(folder.dataset) as part:
        try:
            dataset.to_netcdf(part, engine="netcdf4")
        except RuntimeError as error:  # the library's, of a disk that fails
            raise OSError(f"can't be written: {error}") from None
    return dataset


def _array(values):  # numbers, NaN for None; or words, "" for None
    words = any(isinstance(value, str) for value in values)
    data = np.array([("" if words else nan) if value is None else value for value in values])
    return data.astype(object if words else "i1" if data.dtype.kind == "b" else data.dtype)


def incomplete(dataset: xarray.Dataset) -> Iterator[tuple[int, str, str]]:
    """Number, status and message of each point that is not complete."""
    for i, (status, text) in enumerate(zip(dataset.status.values.flat, dataset.message.values.flat, strict=True)):
        if status != COMPLETE:
            yield i, status, text


@dataclass(frozen=True, eq=False)
class Column:
    """A parameter or a quantity of all points."""

    name: str  # in the dataset
    unit: str
    meaning: str  # in words
    values: np.ndarray  # (n_points,), float; of words their number among `words`
    words: tuple[str, ...] = ()  # in their order; empty of numbers

    label = property(lambda self: self.meaning if self.unit in ("1", "") else f"{self.meaning}, {self.unit}")
    levels = property(lambda self: np.unique(self.values[np.isfinite(self.values)]))  # that it takes, each once

    def shown(self, value: float) -> str:
        """A value for people, without its unit."""
        if not np.isfinite(value):
            return NOTHING
        return self.words[int(value)] if self.words else f"{value:.4g}".replace("-", "−")


class Effect(NamedTuple):
    """Means of a quantity over the points that share a parameter's value, or lie in the same bin of it."""

    at: np.ndarray  # (n_levels,), the parameter
    mean: np.ndarray  # (n_levels,), the quantity
    share: float  # of the quantity's variance that these means explain, 0 … 1; of drawn points see `Table.is_adjusted`


@dataclass(frozen=True)
class Table:
    """A study's points as columns."""

    points: Points
    parameters: list[Column]  # those that take more than one value
    quantities: list[Column]
    complete: np.ndarray  # (n_points,), bool

    telling = property(lambda self: [column for column in self.quantities if len(column.levels) > 1])  # that differ
    # Whether points are samples of distributions. Shares are then adjusted for the number of groups (R̄²): means over k
    # groups of n drawn points explain (k − 1)/(n − 1) of a variance that has nothing to do with the parameter. A grid
    # has no such chance in it: its shares are the variance of the means over that of all points.
    is_adjusted = property(lambda self: self.points.design.axes is None)

    @property
    def is_family(self) -> bool:
        """Whether lines over one parameter show every point: a grid of few parameters, or one parameter alone."""
        columns, lines, *_ = [1, 1, *sorted(len(np.unique(column.values)) for column in self.parameters)][-3:]
        is_small = len(self.parameters) <= 3 and columns <= MOST_COLUMNS and lines <= MOST_LINES
        return len(self.parameters) == 1 or (is_small and not self.is_adjusted)

    def effect(self, parameter: Column, quantity: Column) -> Effect | None:
        """The effect of a parameter on a quantity; None where too few points tell of it."""
        known = np.isfinite(quantity.values) & np.isfinite(parameter.values)
        x, y = parameter.values[known], quantity.values[known]
        if len(y) < FEWEST or not np.ptp(y) > 0.0:
            return None
        levels, group = np.unique(x, return_inverse=True)
        if self.is_adjusted and len(levels) > BINS:
            edges = np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)[1:-1])
            _, group = np.unique(np.searchsorted(edges, x, side="right"), return_inverse=True)
            levels = np.bincount(group, x) / np.bincount(group)
        count = np.bincount(group)
        mean, n, k = np.bincount(group, y) / count, len(y), len(count)
        share = float(np.sum(count * (mean - y.mean()) ** 2) / np.sum((y - y.mean()) ** 2))
        if self.is_adjusted and n > k:
            share = max(0.0, 1.0 - (1.0 - share) * (n - 1) / (n - k))
        return Effect(levels, mean, share)

    def strongest(self, quantity: Column) -> list[tuple[Column, float]]:
        """Parameters with the shares of the quantity's variance that they explain, the largest first."""
        effects = ((parameter, self.effect(parameter, quantity)) for parameter in self.parameters)
        return sorted(((each, effect.share) for each, effect in effects if effect), key=lambda found: -found[1])

    def sobol_indices(self, quantity: Column) -> Indices | None:
        """Of a quantity, (n_parameters,) each; None where the study was not sampled for them, or points are missing.
        Errors: of the order of 1/√base; small ones may come out negative.
        Source: Saltelli et al., Computer Physics Communications 181 (2010), by scipy.stats.sobol_indices."""
        n, d = self.points.design.base, len(self.points.design.keys)
        if not n or not np.isfinite(quantity.values).all() or not np.ptp(quantity.values) > 0.0:
            return None
        from scipy import stats

        f_A, f_B, *f_AB = quantity.values.reshape(d + 2, 1, n)
        found = stats.sobol_indices(func={"f_A": f_A, "f_B": f_B, "f_AB": np.array(f_AB)}, n=n)
        return np.ravel(found.first_order), np.ravel(found.total_order)


def table_of(points: Points, dataset: xarray.Dataset) -> Table:
    """Columns of a study from its dataset; quantities in the unit that engineers read."""
    design, quantities = points.design, []
    parameters = [
        _column(name, unit_of(key), name_in_words(name), [point[i] for point in design.points])
        for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True))
    ]
    for name in points.study.keep.quantities:
        unit, meaning = QUANTITIES[name]
        factor, engineers = engineering(unit)
        quantities.append(_column(name, engineers or unit, meaning, (factor * dataset[name].values.ravel()).tolist()))
    return Table(
        points=points, parameters=[column for column in parameters if len(column.levels) > 1], quantities=quantities,
        complete=dataset.status.values.ravel() == COMPLETE)  # fmt: skip


def _column(name, unit, meaning, values):
    wordy = any(isinstance(value, str | bool) for value in values)
    given = [NOTHING if value is None else str(value) for value in values]
    words = tuple(dict.fromkeys(given)) if wordy else ()
    numbers = [words.index(value) for value in given] if words else values  # None becomes NaN
    return Column(name=name, unit=unit, meaning=meaning, values=np.array(numbers, dtype=float), words=words)
