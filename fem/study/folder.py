"""A study's folder: what it is, a file for each point that is done, and what is made of them.

study.json     the study, its scene and the digest of each point: enough for dataset and page without solving
points/        a sealed file for each point, moved into place when it is whole
runs/          result files, where they are kept
study.nc, study.html
"""

import io
import json
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    ValidationError,
    model_validator,
)

from fem.errors import UsageError
from fem.result.durable import alone_in
from fem.result.layout import Variables
from fem.study.sampling import Design
from fem.study.solving import COMPLETE, LOST, Points, Solved
from fem.study.study_file import QUANTITIES, KeepTable, study_of
from lagrange.columns import PER_ROLLER
from lagrange.files.input import read_plain
from lagrange.files.output import read_sealed, write_sealed, write_whole
from lagrange.scene.faults import printable
from lagrange.scene.scene import parse_scene_text

PROGRAM: Literal["run-study"] = "run-study"
LARGEST = 1e100  # of a quantity in its unit: none was ever computed
LONGEST_NAME = 255
Text = Annotated[StrictStr, Field(pattern=r"^[^\x00]*$")]  # which HDF5 can hold
Key = Annotated[StrictStr, Field(pattern=r"^[^./\x00]+(\.[^./\x00]+)*$")]
Whole = Annotated[StrictInt, Field(ge=-(2**63), lt=2**63)]
Value = StrictBool | Whole | Annotated[StrictFloat, Field(allow_inf_nan=False)] | Text


class StudyRecord(BaseModel):
    """A study, its scene and the values and digests of its points; validated, as anybody may have made the file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    program: Literal["run-study"]
    name: Text = Field(min_length=1, max_length=LONGEST_NAME)
    study: str
    listed: str | None
    scene: str
    files: dict[str, str]
    keys: tuple[Key, ...] = Field(min_length=1)
    points: list[tuple[Value | None, ...]]
    axes: tuple[tuple[Value, ...], ...] | None
    base: int = Field(ge=0)
    digests: list[Annotated[str, Field(pattern="^[0-9a-f]{32}$")]] = Field(min_length=1)
    made_by: Text = Field(max_length=LONGEST_NAME)

    @model_validator(mode="after")
    def _consistent(self):
        n, d = len(self.points), len(self.keys)
        if len(set(self.keys)) < d:
            raise ValueError("keys: one is there twice")
        if len(self.digests) != n or any(len(point) != d for point in self.points):
            raise ValueError("as many digests as points, of as many values as keys, are needed")
        if self.axes is not None and (len(self.axes) != d or prod(len(axis) for axis in self.axes) != n):
            raise ValueError("axes: must make the points")
        if self.base and self.base * (d + 2) != n:
            raise ValueError("base: must make the points")
        return self


class PointRecord(BaseModel):
    """What became of a point; validated likewise."""

    model_config = ConfigDict(extra="forbid", strict=True)

    digest: str  # of the point: a file under another name is not taken as that point's
    status: Literal["complete", "failed", "stopped"]
    text: Text
    seconds: float = Field(ge=0.0)
    quantities: dict[str, float]
    signal_interval: float = Field(ge=0.0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _possible(self):
        for name, value in self.quantities.items():
            if name not in QUANTITIES or abs(value) > LARGEST:
                raise ValueError(f"quantities.{name[:LONGEST_NAME]} = {value:g}: was never computed")
        return self


def read_point(data: bytes, digest: str, keep: KeepTable, variables: Variables) -> Solved:
    """A point out of its file's data.

    Parameters
    ----------
    keep : what the study keeps of each point
    variables : dimensions, unit and meaning of what may be a signal

    Errors
    ------
    ValueError, KeyError, OSError, zipfile.BadZipFile and more: damage has no end.
    """
    with _arrays(data) as arrays:
        facts = _facts(arrays, digest)
        signals = {name: arrays[name] for name in arrays.files if name != "facts"}
    wanted = set(keep.signals) if facts.status == COMPLETE else set()
    if not set(facts.quantities) <= set(keep.quantities) or set(signals) != wanted:
        raise ValueError("other quantities or signals than the study's")
    for name, values in signals.items():
        if values.dtype != np.float64 or values.ndim != (2 if variables[name].dimensions == PER_ROLLER else 1):
            raise ValueError(f"{name}: no signal")
    if len({len(values) for values in signals.values()}) > 1:
        raise ValueError("signals of several lengths")
    return Solved(signals=signals, **facts.model_dump(exclude={"digest"}))


def _arrays(data: bytes) -> np.lib.npyio.NpzFile:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(member.file_size for member in archive.infolist()) > len(data):
            raise ValueError("packed, which no point's file is")
    return np.load(io.BytesIO(data), allow_pickle=False)


def _facts(arrays: np.lib.npyio.NpzFile, digest: str) -> PointRecord:
    facts = PointRecord.model_validate_json(arrays["facts"].tobytes())
    if facts.digest != digest:
        raise ValueError("another point's")
    return facts


def _record_of(points: Points) -> StudyRecord:
    """UsageError: a name or value that no dataset can hold."""
    study, design = points.study, points.design
    try:
        return StudyRecord(
            program=PROGRAM,
            name=study.name,
            study=study.text,
            listed=study.listed,
            scene=study.scene.to_written_toml(),
            files=study.scene.files,
            keys=design.keys,
            points=design.points,
            axes=design.axes,
            base=design.base,
            digests=points.digests,
            made_by=points.made_by,
        )
    except ValidationError as error:
        raise UsageError(f"{study.name}: {_first(error)}") from None


def _first(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    return printable(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": "))


MISSING = "missing"  # the status of a point that has not been solved


@dataclass(frozen=True, kw_only=True)
class Folder:
    """Where a study is kept."""

    path: Path

    @property
    def dataset(self) -> Path:
        return self.path / "study.nc"

    @property
    def page(self) -> Path:
        return self.path / "study.html"

    @property
    def _about(self) -> Path:
        return self.path / "study.json"

    def points(self) -> Points:
        """The study and its points, as they were when it was begun or last resumed.

        Errors
        ------
        UsageError, SceneError: there is none, or it is damaged.
        """
        facts = self._record()
        study = study_of(self._about, facts.study, facts.listed)
        scene = parse_scene_text(facts.scene, f"{self._about}: scene", facts.files)
        return Points(
            study=replace(study, name=facts.name, scene=scene),
            design=Design(keys=facts.keys, points=facts.points, axes=facts.axes, base=facts.base),
            digests=facts.digests,
            made_by=facts.made_by,
        )

    def _record(self) -> StudyRecord:
        """What study.json says. UsageError: there is none, or it is damaged."""
        try:
            return StudyRecord.model_validate_json(read_plain(self._about))
        except OSError as error:
            raise UsageError(f"{self.path}: no study: {error.strerror} (study.json)") from None
        except ValidationError as error:
            raise UsageError(f"{self._about}: damaged, or not of this version: {_first(error)}") from None

    def run(self, digest: str) -> Path:
        """A point's result file."""
        return self.path / "runs" / f"{digest}.nc"

    def _point(self, digest: str) -> Path:
        return self.path / "points" / f"{digest}.point"

    def refuse_foreign(self, points: Points, resume: bool) -> None:
        """Refuse a folder that holds something else, or a study that is not to go on: UsageError."""
        if self.path.exists() and not self.path.is_dir():
            raise UsageError(f"{self.path}: is a file, not a folder; choose another --output")
        self._refuse_begun(points, resume)
        if not self._about.exists() and self.path.exists() and any(self.path.iterdir()):
            raise UsageError(f"{self.path}: not empty and no study; choose another --output or empty it")

    def _refuse_begun(self, points: Points, resume: bool) -> None:
        if not self._about.exists():
            return
        if not resume:
            raise UsageError(f"{self.path}: holds a study; --resume goes on with it, or choose another --output")
        earlier, now = self._record(), _record_of(points)
        is_same = all(getattr(earlier, name) == getattr(now, name) for name in ("study", "listed", "scene", "files"))
        if not is_same and (earlier.keys != now.keys or not set(earlier.digests) & set(now.digests)):
            raise UsageError(
                f"{self.path}: holds another study, none of whose points is one of this study; choose another --output"
            )

    @contextmanager
    def held(self, points: Points, resume: bool) -> Iterator[None]:
        """Begin a study, or go on with it, and let nobody else do so meanwhile.

        Errors
        ------
        OSError: it can't be written. UsageError: another run works in the folder, or has begun a study there.
        """
        with self._named():
            (place := self.path / "points").mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:
            try:
                stack.enter_context(alone_in(place, wait=False))
            except BlockingIOError:
                raise UsageError(
                    f"{self.path}: another run-study works there; wait for its end, or choose another --output"
                ) from None
            self._refuse_begun(points, resume)
            self.begin(points)
            yield

    def begin(self, points: Points) -> None:
        """Write what the study is. OSError: it can't be written."""
        with self._named():
            (self.path / "points").mkdir(parents=True, exist_ok=True)
            write_whole(self._about, _record_of(points).model_dump_json().encode())

    def done(self, digest: str) -> bool:
        """Whether a point has been solved, well or not."""
        try:
            with _arrays(read_sealed(self._point(digest)) or b"") as arrays:
                return bool(_facts(arrays, digest))
        except Exception:  # an archive can be damaged in more ways than there are errors to name here
            return False

    def add(self, digest: str, solved: Solved) -> None:
        """Keep what became of a point; of one lost with its worker nothing, so that it is tried again.

        Errors
        ------
        OSError: it can't be written.
        """
        if solved.status == LOST:
            return
        facts = {name: getattr(solved, name) for name in PointRecord.model_fields if name != "digest"}
        facts["digest"] = digest
        archive = io.BytesIO()
        arrays: dict[str, Any] = {"facts": np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8), **solved.signals}
        np.savez(archive, **arrays)
        with self._named():
            if solved.run is not None:
                self.run(digest).parent.mkdir(exist_ok=True)
                write_whole(self.run(digest), solved.run)
            write_sealed(self._point(digest), archive.getvalue())

    def read(self, points: Points, i: int, variables: Variables) -> Solved | None:
        """What became of point i; None: not solved yet, or its file is damaged. `variables`: which may be signals."""
        try:
            data = read_sealed(self._point(points.digests[i]))
            return None if data is None else read_point(data, points.digests[i], points.study.keep, variables)
        except Exception:  # an archive can be damaged in more ways than there are errors to name here
            return None

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Say what to do where the disk fails."""
        try:
            yield
        except OSError as error:
            raise OSError(
                error.errno, f"{error.strerror}; finished points are kept, --resume goes on", str(self.path)
            ) from None
