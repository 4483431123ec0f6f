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
from pydantic import BaseModel, Field, ValidationError, model_validator

from fem.result.durable import alone_in
from fem.study.sampling import Design
from fem.study.solving import LOST, Points, Solved
from fem.study.study_file import study_of
from lagrange.errors import UsageError
from lagrange.files.input import read_plain
from lagrange.files.output import read_sealed, write_sealed, write_whole
from lagrange.scene.faults import printable
from lagrange.scene.scene import parse_scene_text

PROGRAM: Literal["run-study"] = "run-study"
KEPT = "status", "text", "seconds", "quantities", "signal_interval"  # of a point beside its signals
Value = bool | int | Annotated[float, Field(allow_inf_nan=False)] | str


class StudyRecord(BaseModel, extra="forbid", strict=True):
    """A study, its scene and the values and digests of its points."""

    program: Literal["run-study"] = PROGRAM
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


def _record_of(points: Points) -> StudyRecord:
    study, design = points.study, points.design
    return StudyRecord(
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
            first = error.errors(include_url=False)[0]
            fault = printable(f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": "))
            raise UsageError(f"{self._about}: damaged, or not of this version: {fault}") from None

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

    def read(self, digest: str) -> Solved | None:
        """What became of a point; None: not solved yet, or its file is damaged."""
        try:
            with np.load(io.BytesIO(read_sealed(self._point(digest)) or b"")) as arrays:
                found = {name: arrays[name] for name in arrays.files}
            facts = json.loads(found.pop("facts").tobytes())
            return Solved(signals=found, **facts["solved"]) if facts["digest"] == digest else None
        except (OSError, LookupError, TypeError, ValueError, EOFError, zipfile.BadZipFile):
            return None

    def add(self, digest: str, solved: Solved) -> None:
        """Keep what became of a point; of one lost with its worker nothing, so that it is tried again.

        Errors
        ------
        OSError: it can't be written.
        """
        if solved.status == LOST:
            return
        facts = {"digest": digest, "solved": {name: getattr(solved, name) for name in KEPT}}
        archive = io.BytesIO()
        arrays: dict[str, Any] = {"facts": np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8), **solved.signals}
        np.savez(archive, **arrays)
        with self._named():
            if solved.run is not None:
                self.run(digest).parent.mkdir(exist_ok=True)
                write_whole(self.run(digest), solved.run)
            write_sealed(self._point(digest), archive.getvalue())

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Say what to do where the disk fails."""
        try:
            yield
        except OSError as error:
            raise OSError(
                error.errno, f"{error.strerror}; finished points are kept, --resume goes on", str(self.path)
            ) from None
