"""Measured heights around one turn of a surface, from columns angle_deg and height_um."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lagrange.files.tables import MOST_ROWS, columns

ANGLE, HEIGHT = "angle_deg", "height_um"
FEWEST_POINTS = 16
FULL_TURN = 360.0
AGAIN = 1e-6  # degrees, µm: two values that are the same
LARGEST_GAP = 3.0  # times the usual distance of two angles


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightTable:
    """Heights around one turn; arrays (n_points,)."""

    angle: np.ndarray  # rad, rising, less than a turn from first to last
    height: np.ndarray  # m, positive where material is added


@lru_cache(maxsize=16)
def height_table(text: str, decimal: str = ".") -> HeightTable:
    """The heights of a table's text with this decimal sign.

    Errors
    ------
    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too few or too many points,
    angles that do not rise, more than a turn, a gap, also at the seam, or two heights there.
    """
    found = columns(text, (ANGLE, HEIGHT), decimal)
    if not np.all(np.isfinite(found)) or np.any(np.abs(found[:, 0]) > 10.0 * FULL_TURN):
        raise ValueError(f"a value is not finite, or no {ANGLE} of a turn")
    angle, height = found.T
    if not FEWEST_POINTS <= len(angle) <= MOST_ROWS:
        raise ValueError(f"it holds {len(angle)} points; at least {FEWEST_POINTS} and at most {MOST_ROWS} are taken")
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
