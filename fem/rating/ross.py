"""Bearing coefficients over speed for rotordynamics, as CSV.

The axes are ROSS': x to the right, y up, against the load, z along the shaft. A file is read back by

    import ross
    from fem.rating.ross import read_coefficients

    element = ross.BearingElement(n=0, **read_coefficients("NU206-ross.csv"))
"""

import io
from contextlib import suppress
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.rating.answers import Rating
from lagrange.files.input import plain_text
from lagrange.files.output import write_whole
from lagrange.files.tables import columns
from lagrange.scene.faults import RPM

SPEEDS, BEYOND = 7, 1.5  # of the shaft, from 0 to so many times the scene's
SAMPLES = 32  # cage angles in a pitch
NAMES = "kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy", "kzz"
HEADER = "speed_rad_per_s", *(f"{name}_{'N' if name[0] == 'k' else 'N_s'}_per_m" for name in NAMES)
LONGEST = 1_000_000  # bytes


class Coefficients(NamedTuple):
    """Means over a pitch by the shaft's speed."""

    speed: np.ndarray  # (n,), rad/s
    stiffness: np.ndarray  # (n, 2, 2), N/m
    damping: np.ndarray  # (n, 2, 2), N s/m
    axial: np.ndarray  # (n,), N/m, stiffness; 0 in the plane


def coefficients(rating: Rating) -> Coefficients:
    """Of contacts and dampers, from rest to half as fast again as the scene's shaft. Unavailable: no equilibrium.
    Under axial load, moment or preload the same at all speeds, and undamped."""
    case, elastic = rating.case, rating.scene.model != "lagrange"
    none = np.zeros(SPEEDS)
    if not case.in_plane:
        axial, fastest = 1e3 * case.balance.condensed(2)[0, 0], BEYOND * max(abs(case.operation.speed), RPM)
        radial, speeds = np.broadcast_to(case.stiffness, (SPEEDS, 2, 2)), np.linspace(0.0, fastest, SPEEDS)
        return Coefficients(speeds, radial, 0.0 * radial, none + axial)
    if elastic:
        _ = case.elastic  # refuses what it can't take
    fastest = BEYOND * abs(case.operation.speed)
    speeds = np.linspace(0.0, fastest, SPEEDS) if fastest > 0.0 else np.zeros(1)
    found = [case.plane_under(replace(case.on_bearing, speed=float(speed)), elastic, SAMPLES) for speed in speeds]
    damping = [pitch.damping.mean(axis=0) for pitch in found]
    return Coefficients(speeds, np.stack([pitch.mean for pitch in found]), np.stack(damping), none[: len(speeds)])


def write_coefficients(path: Path, found: Coefficients) -> None:
    """A CSV file; OSError."""
    n, text = len(found.speed), io.StringIO()
    table = np.column_stack([found.speed, found.stiffness.reshape(n, 4), found.damping.reshape(n, 4), found.axial])
    np.savetxt(text, table, delimiter=",", header=",".join(HEADER), comments="", fmt="%.9g")
    write_whole(path, text.getvalue().encode())


def read_coefficients(path: str | Path) -> dict[str, np.ndarray]:
    """Keyword arguments of the installed ross.BearingElement (n,) each. ValueError: the file can't be read.
    The shaft's speed is `speed`. Before version 3 ROSS calls it `frequency`, which since then is that of the whirl."""
    taken = {"speed", "kzz"}
    with suppress(ImportError):
        import ross

        taken = set(signature(ross.BearingElement).parameters)
    speed = "speed" if "speed" in taken else "frequency"
    found = dict(zip((speed, *NAMES), columns(plain_text(path, LONGEST), HEADER).T.copy(), strict=True))
    return found if "kzz" in taken else {name: values for name, values in found.items() if name != "kzz"}
