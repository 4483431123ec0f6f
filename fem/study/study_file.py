"""The study's file: TOML, validated; its faults are reported like those of a scene."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from fem.interface import OF_CHECK
from fem.quantities import OF_RATING, OF_RUN, OF_STATICS
from fem.study.parameters import Parameter, read_parameter
from fem.study.sampling import design_of
from lagrange.errors import UsageError
from lagrange.files.input import plain_text
from lagrange.scene.faults import Check, Table, all_faults, likely_of, printable
from lagrange.scene.files import load
from lagrange.scene.scene import Scene, SceneError, read_scene

LARGEST_FILE = 2**24  # bytes of a list of points
MOST_NAMES = 1000  # quantities, signals, keys of the scene
QUANTITIES = OF_RUN | OF_STATICS | OF_RATING | OF_CHECK  # unit and meaning by name
USUAL = ("hub_mean_x", "hub_mean_y", "largest_force", "mean_largest_force", "load_zone")


class SamplingTable(Table):
    method: Literal["grid", "zip", "lhs", "sobol", "list"] = "grid"
    samples: int | None = Field(None, ge=1, le=1_000_000)
    seed: int = Field(0, ge=0, le=2**63 - 1)
    indices: bool = False
    file: str | None = Field(None, min_length=1)

    def checks(self) -> tuple[Check, ...]:
        return self._count, self._power, self._points

    def _count(self) -> Iterator[str]:
        drawn = self.method in ("lhs", "sobol")
        if drawn and self.samples is None:
            yield f'samples: missing; method = "{self.method}" needs a number of samples'
        if not drawn and self.samples is not None:
            yield f'samples = {self.samples}: only for "lhs" and "sobol", not for "{self.method}"; leave it out'

    def _power(self) -> Iterator[str]:
        if self.indices and self.method != "sobol":
            yield f'indices = true: only for method = "sobol", not for "{self.method}"; leave it out'
        if self.method == "sobol" and self.samples is not None and self.samples & (self.samples - 1):
            near = 2 ** self.samples.bit_length()
            yield f"samples = {self.samples}: a Sobol sequence is uniform at powers of two; use {near // 2} or {near}"

    def _points(self) -> Iterator[str]:
        if (self.method == "list") != (self.file is not None):
            yield 'file: a CSV table of points goes with method = "list", and with no other'


def decimation(interval: float, rate: float | None) -> int:
    """One of so many samples, an interval apart, s, is kept at a rate, Hz, or at the next higher one; None: every."""
    return 1 if rate is None else max(1, int(1.0 / (rate * interval) + 1e-9))


class KeepTable(Table):
    quantities: list[str] = Field(list(USUAL), max_length=MOST_NAMES)
    signals: list[str] = Field([], max_length=MOST_NAMES)
    signal_rate_kHz: float | None = Field(None, ge=1e-6, le=1e6)

    def checks(self) -> tuple[Check, ...]:
        return self._known, self._twice, self._rate

    def _known(self) -> Iterator[str]:
        for name in self.quantities:
            if name not in QUANTITIES:
                hint = likely_of(name, QUANTITIES)
                yield f"quantities: {name!r} is unknown; " + (
                    f"did you mean {hint}?" if hint else f"known are {', '.join(QUANTITIES)}"
                )

    def _twice(self) -> Iterator[str]:
        for key, names in (("quantities", self.quantities), ("signals", self.signals)):
            for name in sorted({name for name in names if names.count(name) > 1}):
                yield f"{key}: {name!r} is there twice"

    def _rate(self) -> Iterator[str]:
        if self.signal_rate_kHz is not None and not self.signals:
            yield f"signal_rate_kHz = {self.signal_rate_kHz:g}: there are no signals; add some or leave it out"


class LimitsTable(Table):
    seconds_per_point: float = Field(3600.0, gt=0.0, le=1e7)


class StudyTable(Table):
    """A study as its file has it."""

    name: str | None = Field(None, min_length=1, max_length=100, pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    scene: str | None = Field(None, min_length=1)
    sampling: SamplingTable = SamplingTable()
    fixed: dict[str, Any] = Field({}, max_length=MOST_NAMES)  # by dotted key, before anything is varied
    parameters: dict[str, Any] = Field({}, max_length=MOST_NAMES)
    keep: KeepTable = KeepTable()
    limits: LimitsTable = LimitsTable()


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study: what is varied, from which scene on, and what is kept of each point."""

    name: str
    scene: Scene
    sampling: SamplingTable
    parameters: Mapping[str, Parameter]  # by dotted key of the scene; empty for method = "list"
    keep: KeepTable
    limits: LimitsTable
    text: str  # the study's own TOML
    listed: str | None = None  # text of the CSV table of points


def read_study(path: Path) -> Study:
    """The study of a TOML file; paths in it are from its own folder. Its scene may need keys that all points give.

    Errors
    ------
    UsageError, SceneError: unreadable, not TOML, unknown keys, impossible values; each with its key.
    """
    text = _text(path)
    table = _validated(path, text)
    found = study_of(path, text, None)
    listed = None if table.sampling.file is None else _text(path.parent / table.sampling.file)
    found, base = replace(found, listed=listed), None if table.scene is None else path.parent / table.scene
    try:
        scene = read_scene(base)
    except SceneError:  # it may lack what all points have
        scene = read_scene(base, changes=table.fixed | design_of(found).always)
    try:
        return replace(found, scene=scene.varied(table.fixed))
    except SceneError as error:
        raise UsageError(f"{path}: [fixed]: {error}") from None


def study_of(path: Path, text: str, listed: str | None) -> Study:
    """The study of a TOML text, with the built-in scene.

    Parameters
    ----------
    path : where the text stands, to be named in errors
    listed : text of the table of points, for method = "list"

    Errors
    ------
    UsageError.
    """
    table = _validated(path, text)
    with _named(path):
        parameters = {key: read_parameter(key, value) for key, value in table.parameters.items()}
    _check_methods(path, table, parameters)
    for key in parameters.keys() & table.fixed.keys():
        raise UsageError(f'{path}: "{key}" stands in [fixed] and in [parameters]; leave it in one of them')
    return Study(
        name=table.name or path.stem,
        scene=read_scene(),
        sampling=table.sampling,
        parameters=parameters,
        keep=table.keep,
        limits=table.limits,
        text=text,
        listed=listed,
    )


def _text(path: Path) -> str:
    try:
        return plain_text(path, LARGEST_FILE)
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from None


def _validated(path: Path, text: str) -> StudyTable:
    data = load(text, str(path))
    try:
        return StudyTable.model_validate(data)
    except ValidationError as error:
        raise UsageError("\n".join(f"{path}: {fault}" for fault in all_faults(error, StudyTable, data))) from None


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Name the file where a value of it can't be used."""
    try:
        yield
    except UsageError as error:
        raise UsageError(f"{path}: {printable(str(error))}") from None


def _check_methods(path: Path, table: StudyTable, parameters: Mapping[str, Parameter]) -> None:
    """Refuse parameters that the method can't take, before a scene is read."""
    method = table.sampling.method
    if method == "list" and parameters:
        raise UsageError(f'{path}: [parameters]: with method = "list" they are the columns of its file; leave them out')
    if method != "list" and not parameters:
        raise UsageError(f'{path}: [parameters]: empty; name a key of the scene and its values, "operation.speed_rpm"')
    with _named(path):
        for parameter in parameters.values():
            if method in ("grid", "zip"):
                parameter.axis(method)
            elif method != "list":
                parameter.drawn(np.array([0.5]))
