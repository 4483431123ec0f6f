"""The cage in the picture of the whole bearing: its bars between the rollers, where they are.

Its play is a thousand times the bodies' displacements, and is not magnified.
"""

from math import asin

import numpy as np

from fem.pictures.recover import Instant

BAR = 0.34  # of a roller's radius: half a bar's width across the pitch circle
POINTS = 12  # of an arc
ROUND = 24  # points of a pocket's wall


def bars(instant: Instant) -> list[np.ndarray]:
    """Outlines of the cage's bars, closed, (n, 2), m; none without a cage."""
    facts, bearing = instant.scene.ideal_cage(), instant.model.bearing
    if facts is None or instant.cage is None:
        return []
    n, pitch, half = bearing.n_rollers, bearing.pitch_radius, bearing.roller_radius + 0.5 * facts.pocket_clearance
    wide = BAR * bearing.roller_radius
    walls = [_wall(pitch, half, wide, facts.guidance == "rollers", side) for side in (1.0, -1.0)]
    first = instant.operation.first_roller_angle + instant.cage[2]
    found = []
    for j in range(n):
        start, end = first + 2.0 * np.pi * j / n, first + 2.0 * np.pi * (j + 1) / n
        before, after = _turned(walls[0], start), _turned(walls[1], end)
        outline = np.concatenate([before, _arc(before[-1], after[-1]), after[::-1], _arc(after[0], before[0])])
        found.append(instant.cage[:2] + outline)
    return found


def _wall(pitch: float, half: float, wide: float, is_round: bool, side: float) -> np.ndarray:
    """A pocket's front (1) or rear (−1) wall from inside to outside, (ROUND, 2), m; its roller on the x axis."""
    across = np.linspace(-wide, wide, ROUND)
    ahead = np.sqrt(np.maximum(half**2 - across**2, 0.0)) if is_round else np.full(ROUND, half)
    return np.column_stack([pitch + across, side * ahead])


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _arc(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The way about the cage's centre from one point to another on about the same circle."""
    radius, first = np.hypot(*start), np.arctan2(start[1], start[0])
    turn = asin(np.clip((start[0] * end[1] - start[1] * end[0]) / (np.hypot(*start) * np.hypot(*end)), -1.0, 1.0))
    angle = first + np.linspace(0.0, turn, POINTS)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])
