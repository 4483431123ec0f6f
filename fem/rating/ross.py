"""Bearing coefficients over speed for rotordynamics: CSV, and ROSS' own element.

The axes are ROSS': x to the right, y up, against the load, z along the shaft. A file is read back by

    import ross
    from fem.rating.ross import read_coefficients

    element = ross.BearingElement(n=0, **read_coefficients("NU206-ross.csv"))
"""

import io
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fem.rating.answers import Rating
from lagrange.files.input import columns, plain_text
from lagrange.files.output import write_whole
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import Pitch, lagrangian_pitch

if TYPE_CHECKING:
    import ross

SPEEDS, BEYOND = 7, 1.5  # of the shaft, from 0 to so many times the scene's
SAMPLES = 32  # cage angles in a pitch
NAMES = "kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy"
LONGEST = 1_000_000  # bytes


@dataclass(frozen=True, kw_only=True)
class Coefficients:
    """Means over a pitch by the shaft's speed."""

    frequency: np.ndarray  # (n,), rad/s
    stiffness: np.ndarray  # (n, 2, 2), N/m
    damping: np.ndarray  # (n, 2, 2), N s/m

    def table(self) -> np.ndarray:
        """(n, 9): frequency, then by NAMES."""
        n = len(self.frequency)
        return np.column_stack([self.frequency, self.stiffness.reshape(n, 4), self.damping.reshape(n, 4)])


def coefficients(rating: Rating) -> Coefficients:
    """Of the scene's contacts and dampers, from rest to half as fast again as the scene's shaft.

    Errors
    ------
    Unavailable: no equilibrium.
    """
    case = rating.case
    fastest = BEYOND * abs(case.operation.speed)
    speeds = np.linspace(0.0, fastest, SPEEDS) if fastest > 0.0 else np.zeros(1)
    found = [_at(case, float(speed)) for speed in speeds]
    return Coefficients(
        frequency=speeds,
        stiffness=np.stack([pitch.mean for pitch in found]),
        damping=np.stack([pitch.damping.mean(axis=0) for pitch in found]),
    )


def _at(case, speed: float) -> Pitch:
    operation = replace(case.on_bearing, speed=speed)
    if case.scene.model == "lagrange":
        try:
            return lagrangian_pitch(case.bearing, operation, case.laws, case.scene.damping.contacts, SAMPLES)
        except RuntimeError as error:
            raise Unavailable(str(error)) from None
    _ = case.elastic  # refuses what it can't take
    from fem.rating.elastic import elastic_pitch

    return elastic_pitch(case.bearing, operation, case.scene.damping.contacts, SAMPLES)


def write_coefficients(path: Path, found: Coefficients) -> None:
    """A CSV file; OSError."""
    text = io.StringIO()
    np.savetxt(text, found.table(), delimiter=",", header=",".join(("frequency", *NAMES)), comments="", fmt="%.9g")
    write_whole(path, text.getvalue().encode())


def read_coefficients(path: str | Path) -> dict[str, np.ndarray]:
    """Keyword arguments of ross.BearingElement, (n,) each. ValueError: the file can't be read."""
    names = "frequency", *NAMES
    return dict(zip(names, columns(plain_text(path, LONGEST), names).T.copy(), strict=True))


def bearing_element(rating: Rating, node: int) -> "ross.BearingElement":
    """ROSS' element at a node of its rotor; needs ross-rotordynamics."""
    import ross

    table = coefficients(rating).table().T.copy()
    return ross.BearingElement(n=node, **dict(zip(("frequency", *NAMES), table, strict=True)))
