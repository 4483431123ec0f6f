"""What files of a study's folder tell: anybody may have made them, so they are validated as a scene is."""

import io
import zipfile
from math import prod
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictFloat, StrictInt, StrictStr, model_validator

from fem.result.layout import PER_ROLLER, Variables
from fem.study.solving import COMPLETE, Solved
from fem.study.study_file import QUANTITIES, KeepTable

PROGRAM = "run-study"
LARGEST = 1e100  # of a quantity in its unit: none was ever computed
LONGEST_NAME = 255
Value = StrictBool | StrictInt | Annotated[StrictFloat, Field(allow_inf_nan=False)] | StrictStr


class StudyFacts(BaseModel):
    """A study, its scene and the values and digests of its points."""

    model_config = ConfigDict(extra="forbid", strict=True)

    program: Literal["run-study"]
    name: str = Field(min_length=1, max_length=LONGEST_NAME)
    study: str
    listed: str | None
    scene: str
    files: dict[str, str]
    keys: tuple[str, ...] = Field(min_length=1)
    points: list[tuple[Value | None, ...]]
    axes: tuple[tuple[Value, ...], ...] | None
    base: int = Field(ge=0)
    digests: list[Annotated[str, Field(pattern="^[0-9a-f]{32}$")]] = Field(min_length=1)
    made_by: str = Field(max_length=LONGEST_NAME)

    @model_validator(mode="after")
    def _consistent(self):
        n, d = len(self.points), len(self.keys)
        if len(self.digests) != n or any(len(point) != d for point in self.points):
            raise ValueError("as many digests as points, of as many values as keys, are needed")
        if self.axes is not None and (len(self.axes) != d or prod(len(axis) for axis in self.axes) != n):
            raise ValueError("axes: must make the points")
        if self.base and self.base * (d + 2) != n:
            raise ValueError("base: must make the points")
        return self


class PointFacts(BaseModel):
    """What became of a point."""

    model_config = ConfigDict(extra="forbid", strict=True)

    status: Literal["complete", "failed", "stopped"]
    text: str
    seconds: float = Field(ge=0.0)
    quantities: dict[str, float]
    signal_interval: float = Field(ge=0.0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _possible(self):
        for name, value in self.quantities.items():
            if name not in QUANTITIES or abs(value) > LARGEST:
                raise ValueError(f"quantities.{name[:LONGEST_NAME]} = {value:g}: was never computed")
        return self


def read_point(data: bytes, keep: KeepTable, variables: Variables) -> Solved:
    """A point out of its file's data.

    Parameters
    ----------
    keep : what the study keeps of each point
    variables : dimensions, unit and meaning of what may be a signal

    Errors
    ------
    ValueError, KeyError, OSError, zipfile.BadZipFile and more: damage has no end.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(member.file_size for member in archive.infolist()) > len(data):
            raise ValueError("packed, which no point's file is")
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        facts = PointFacts.model_validate_json(arrays["facts"].tobytes())
        signals = {name: arrays[name] for name in arrays.files if name != "facts"}
    wanted = set(keep.signals) if facts.status == COMPLETE else set()
    if not set(facts.quantities) <= set(keep.quantities) or set(signals) != wanted:
        raise ValueError("other quantities or signals than the study's")
    for name, values in signals.items():
        if values.dtype != np.float64 or values.ndim != (2 if variables[name][0] == PER_ROLLER else 1):
            raise ValueError(f"{name}: no signal")
    if len({len(values) for values in signals.values()}) > 1:
        raise ValueError("signals of several lengths")
    return Solved(signals=signals, **facts.model_dump())
