"""What the report's page plays and plots: the run's picture, its spectra, its motion frame by frame."""

import base64
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from lagrange.kinematics import turned
from residual.evaluation import Evaluation
from residual.exports import accelerations
from residual.figures.curves import LINE_COLOURS, family
from residual.record import Record
from residual.spectrum import Spectrum, power_spectrum

LARGEST = 2_000_000  # bytes


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG as a data address."""

    address: str
    caption: str


def picture_of(run: Path) -> Picture | None:
    """Read `<run>.png` beside a result file, if it is of that run, as its text says, and not older."""
    path = run.with_suffix(".png")
    try:
        if path.stat().st_mtime < run.stat().st_mtime or path.stat().st_size > LARGEST:
            return None
        with Image.open(path) as image:
            told = dict(getattr(image, "text", {}))
        if told.get("Source") != run.name:
            return None
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    except (OSError, UnidentifiedImageError):
        return None
    return Picture(address=f"data:image/png;base64,{data}", caption=told.get("Description", ""))


# Data of the spectra for the page's own plot, which can be zoomed.


MOST_POINTS = 6000  # of one curve; beyond, only a bin's highest neighbours are kept
ALL_BELOW = 2000.0  # Hz: here every bin is kept
DIGITS = 4


def spectra_json(evaluation: Evaluation, equations: bool = True) -> str:
    """Write frequencies, Hz, densities and kinematic lines as JSON that may stand inside a script element.

    Densities are of the error forces, N²/Hz, or without the equations of the hub's acceleration, m²/s⁴/Hz.
    """
    found = [direction.spectrum for direction in evaluation.directions]
    if not equations:
        slowest, interval = min(evaluation.lines.values(), default=0.0), evaluation.record.interval
        found = [power_spectrum(signal, interval, slowest) for signal in accelerations(evaluation)]
    kept = _kept(*found)
    spectra = {direction.name: each.psd[kept] for direction, each in zip(evaluation.directions, found, strict=True)}
    top = max(float(psd.max()) for psd in spectra.values())
    data = {
        "frequency": _rounded(found[0].frequency[kept], 7),
        **{axis: _rounded(np.maximum(psd, 1e-16 * top), DIGITS) for axis, psd in spectra.items()},
        "lines": [
            {"name": name, "frequency": float(f"{frequency:.7g}"), "colour": LINE_COLOURS[family(name)]}
            for name, frequency in sorted(evaluation.lines.items(), key=lambda line: ("×" in line[0], line[1]))
        ],
        "names": ["error_x", "error_y"] if equations else ["x", "y"],
        "unit": "N²/Hz" if equations else "m²/s⁴/Hz",
        "resolution": float(f"{found[0].resolution:.6g}"),
    }
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _kept(x: Spectrum, y: Spectrum) -> np.ndarray:
    """Choose the bins to show: all of a short record; of a long one those below ALL_BELOW and each group's highest."""
    n = x.frequency.size
    if n - 1 <= MOST_POINTS:
        return np.arange(1, n)
    low = np.flatnonzero((x.frequency > 0.0) & (x.frequency <= ALL_BELOW))[:MOST_POINTS]
    rest = np.arange(low[-1] + 1 if low.size else 1, n)
    groups = np.array_split(rest, min(rest.size, MOST_POINTS // 2))
    peaks = [group[np.argmax(psd[group])] for group in groups for psd in (x.psd, y.psd)]
    return np.unique(np.concatenate([low, peaks]))


def _rounded(values: np.ndarray, digits: int) -> list[float]:
    return [float(f"{value:.{digits}g}") for value in values]


# Data of the page's player: where the hub and the rollers are and what rollers carry, frame by frame.


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
