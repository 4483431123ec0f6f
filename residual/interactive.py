"""Data of the spectra for the page's own plot, which can be zoomed."""

import json

import numpy as np

from residual.colours import LINE_COLOURS, family
from residual.evaluation import Evaluation
from residual.exports import accelerations
from residual.spectrum import Spectrum, power_spectrum

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
