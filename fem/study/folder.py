"""A study's folder: what it is, a file for each point that is done, and what is made of them.

study.json     the study, its scene and the digest of each point: enough for dataset and page without solving
points/        a sealed file for each point, moved into place when it is whole
runs/          result files, where they are kept
study.nc, study.html
"""

import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from fem.errors import UsageError
from fem.result.layout import Variables
from fem.study.facts import PROGRAM, StudyFacts, read_point
from fem.study.points import Points
from fem.study.sampling import Design
from fem.study.solving import LOST, Solved
from fem.study.study_file import study_of
from lagrange.output_files import write_whole
from lagrange.plain_files import read_plain
from lagrange.scene import parse_scene_text
from lagrange.sealed import read_sealed, write_sealed

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
        """The study and its points, as they were when it was begun or last gone on with.

        Errors
        ------
        UsageError, SceneError: there is none, or it is damaged.
        """
        try:
            facts = StudyFacts.model_validate_json(read_plain(self._about))
        except OSError as error:
            raise UsageError(f"{self.path}: no study: {error.strerror} (study.json)") from None
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            told = f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": ")
            raise UsageError(f"{self._about}: damaged, or not of this version: {told}") from None
        study = study_of(self._about, facts.study, facts.listed)
        scene = parse_scene_text(facts.scene, f"{self._about}: scene", facts.files)
        return Points(
            study=replace(study, name=facts.name, scene=scene),
            design=Design(keys=facts.keys, points=facts.points, axes=facts.axes, base=facts.base),
            digests=facts.digests,
            made_by=facts.made_by,
        )

    def run(self, digest: str) -> Path:
        """A point's result file."""
        return self.path / "runs" / f"{digest}.nc"

    def _point(self, digest: str) -> Path:
        return self.path / "points" / f"{digest}.point"

    def refuse_foreign(self, resume: bool) -> None:
        """Refuse a folder that holds something else, or a study that is to go on without `resume`: UsageError."""
        if self.path.exists() and not self.path.is_dir():
            raise UsageError(f"{self.path}: is a file, not a folder; choose another --output")
        if self._about.exists() and not resume:
            raise UsageError(f"{self.path}: holds a study; --resume goes on with it, or choose another --output")
        if not self._about.exists() and self.path.exists() and any(self.path.iterdir()):
            raise UsageError(f"{self.path}: not empty and no study; choose another --output or empty it")

    def begin(self, points: Points) -> None:
        """Write what the study is.

        Errors
        ------
        OSError: it can't be written.
        """
        with self._named():
            (self.path / "points").mkdir(parents=True, exist_ok=True)
            write_whole(self._about, json.dumps(_facts(points), ensure_ascii=False).encode())

    def done(self, digest: str) -> bool:
        """Whether a point has been solved, well or not."""
        try:
            return read_sealed(self._point(digest)) is not None
        except OSError:
            return False

    def add(self, digest: str, solved: Solved) -> None:
        """Keep what became of a point; of one lost with its worker nothing, so that it is tried again.

        Errors
        ------
        OSError: it can't be written.
        """
        if solved.status == LOST:
            return
        facts = {
            "status": solved.status,
            "text": solved.text,
            "seconds": solved.seconds,
            "quantities": dict(solved.quantities),
            "signal_interval": solved.signal_interval,
        }
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
            return None if data is None else read_point(data, points.study.keep, variables)
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


def _facts(points: Points) -> dict[str, Any]:
    study, design = points.study, points.design
    return {
        "program": PROGRAM,
        "name": study.name,
        "study": study.text,
        "listed": study.listed,
        "scene": study.scene.to_written_toml(),
        "files": study.scene.files,
        "keys": design.keys,
        "points": design.points,
        "axes": design.axes,
        "base": design.base,
        "digests": points.digests,
        "made_by": points.made_by,
    }
