"""Heights of a surface around its circle, as an instrument has measured them: a text table of angles and heights.

One header line with the columns angle_deg and height_um; others are left out. Commas, tabs or semicolons: the header
tells. Lines that start with # are comments.
"""

import csv
import hashlib
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

ANGLE, HEIGHT = "angle_deg", "height_um"
LARGEST_FILE = 4 * 2**20  # bytes
MOST_POINTS = 50_000
FEWEST_POINTS = 16
LONGEST_LINE = 1000  # characters
FULL_TURN = 360.0
AGAIN = 1e-6  # degrees, µm: two values that are the same
LARGEST_GAP = 3.0  # times the usual distance of two angles


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightTable:
    """Heights around one turn; arrays (n_points,)."""

    angle: np.ndarray  # rad, rising, less than a turn from first to last
    height: np.ndarray  # m, positive where material is added


def digest(text: str) -> str:
    """By which a table's text is known again: its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()


@lru_cache(maxsize=16)
def height_table(text: str) -> HeightTable:
    """The heights of a table's text.

    Errors
    ------
    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too few or too many points,
    angles that do not rise, more than a turn, a gap, also at the seam, or two heights there.
    """
    angle, height = _columns(text)
    if not FEWEST_POINTS <= len(angle) <= MOST_POINTS:
        raise ValueError(f"it holds {len(angle)} points; at least {FEWEST_POINTS} and at most {MOST_POINTS} are taken")
    steps = np.diff(angle)
    if np.any(steps <= 0.0):
        at = int(np.argmax(steps <= 0.0))
        raise ValueError(f"{ANGLE} must rise from row to row: after {angle[at]:g} comes {angle[at + 1]:g}")
    seam = FULL_TURN - (angle[-1] - angle[0])
    if abs(seam) <= AGAIN:
        if abs(height[-1] - height[0]) > AGAIN:
            raise ValueError(
                f"it does not close: {HEIGHT} is {height[0]:g} at {angle[0]:g} degrees and {height[-1]:g} a turn on"
            )
        angle, height, steps = angle[:-1], height[:-1], steps[:-1]
        seam = FULL_TURN - (angle[-1] - angle[0])
    if seam <= 0.0:
        raise ValueError(f"{ANGLE} goes from {angle[0]:g} to {angle[-1]:g}, more than a turn")
    gaps, usual = np.append(steps, seam), float(np.median(steps))
    if gaps.max() > LARGEST_GAP * usual:
        at = int(gaps.argmax())
        where = "at the seam, " if at == len(steps) else ""
        raise ValueError(
            f"a gap of {gaps[at]:.4g} degrees {where}after {angle[at]:g}, where points are usually {usual:.4g} apart "
            f"(at most {LARGEST_GAP:g} times that)"
        )
    return HeightTable(angle=np.radians(angle), height=1e-6 * height)


def delimiter_of(header: str) -> str:
    """Tab or semicolon where a header has one, else comma."""
    return next((character for character in "\t;" if character in header), ",")


def _columns(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Degrees and µm, as they stand there."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) > MOST_POINTS + 2 or any(len(line) > LONGEST_LINE for line in lines):
        raise ValueError(f"more than {MOST_POINTS} rows, or a row of more than {LONGEST_LINE} characters")
    delimiter = delimiter_of(lines[0]) if lines else ","
    header = [name.strip() for name in next(csv.reader(lines[:1], delimiter=delimiter), [])]
    for name in (ANGLE, HEIGHT):
        if header.count(name) != 1:
            what = "missing" if name not in header else "there twice"
            raise ValueError(f"column {name} is {what}; its first line must name {ANGLE} and {HEIGHT}")
    wanted = [header.index(ANGLE), header.index(HEIGHT)]
    rows = []
    for number, row in enumerate(csv.reader(lines[1:], delimiter=delimiter), 1):
        try:
            rows.append([float(row[k]) for k in wanted])
        except (ValueError, IndexError):
            raise ValueError(f"row {number} below the header can't be read: two numbers are needed") from None
    found = np.array(rows).reshape(-1, 2)
    if not np.all(np.isfinite(found)) or np.any(np.abs(found[:, 0]) > 10.0 * FULL_TURN):
        raise ValueError(f"a value is not finite, or no {ANGLE} of a turn")
    return found[:, 0], found[:, 1]
