"""Data of the page's player: where the hub and the rollers are and what rollers carry, frame by frame."""

import json

import numpy as np

from lagrange.kinematics import turned
from residual.evaluation import Evaluation
from residual.interactive import _rounded
from residual.record import Record

MOST_FRAMES = 400
MOST_NUMBERS = 16_000  # of all rollers and frames: some 100 kB
FRAMES_PER_PASSAGE = 12.0  # rollers move by a twelfth of their pitch from frame to frame
PATH_POINTS = 1500  # of the hub's path


def player_json(evaluation: Evaluation) -> str:
    """Write geometry, mm, and frames as JSON that may stand inside a script element.

    The frames are the record's last, of as many roller passages as fit; of a standing bearing all of it.
    """
    t, bearing, shown = evaluation.record, evaluation.record.bearing, _shown(evaluation)
    path = slice(None, None, -(-t.time.size // PATH_POINTS))
    data = {
        "rings": [float(f"{1e3 * r:.6g}") for r in (
            bearing.bore_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius, bearing.outside_radius
        )],
        "roller": float(f"{1e3 * bearing.roller_radius:.6g}"),
        "load": _load(t, shown),
        "time": _rounded(1e3 * t.time[shown], 6),
        "turn": _rounded(np.mod(turned(bearing, t.operation, t.time[shown]).shaft, 2.0 * np.pi), 4),
        "hub": [_rounded(1e6 * t.inner_x[shown], 5), _rounded(1e6 * t.inner_y[shown], 5)],
        "angle": [_rounded(row, 5) for row in np.arctan2(t.roller_y[shown], t.roller_x[shown])],
        "force": [_rounded(row, 4) for row in evaluation.force[shown]],
        "path": [_rounded(1e6 * t.inner_x[path], 5), _rounded(1e6 * t.inner_y[path], 5)],
    }  # fmt: skip
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _load(record: Record, shown: np.ndarray) -> list[list[float]]:
    """The hub's load and weight along x and y in each frame, shares of the largest; 0 where there is none."""
    load = np.array(record.whole_load)
    largest = float(np.hypot(*load).max())
    return [_rounded(row, 4) for row in load[:, shown] / (largest if largest > 0.0 else 1.0)]


def _shown(evaluation: Evaluation) -> np.ndarray:
    """Samples that become frames."""
    t = evaluation.record
    frames = max(2, min(MOST_FRAMES, MOST_NUMBERS // (2 * t.bearing.n_rollers)))
    passing = evaluation.lines.get("BPFO", 0.0)
    step = 1.0 / (FRAMES_PER_PASSAGE * passing * t.interval) if passing > 0.0 else t.time.size / frames
    frames = min(frames, int((t.time.size - 1) / max(step, 1.0)) + 1)
    return t.time.size - 1 - np.round(max(step, 1.0) * np.arange(frames)[::-1]).astype(int)
