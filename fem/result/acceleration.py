"""Accelerations as a measuring card would record them: filtered, at a lower rate, as CSV, WAV or MAT."""

import io
import struct
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from lagrange.errors import UsageError
from lagrange.files.output import replaced, write_whole
from lagrange.messages import G
from lagrange.scene.scene import Scene

WAV_REMARK = b"render-fem\0\0"  # of even length
OVER_BAND = 2.56  # rate over the band that is kept, the custom of analysers
STOPPED = 80.0  # dB, by which what would fold into the band is lowered
MOST_TAPS = 2_000_000  # of the filter
MOST_PARTS = 10_000  # of the ratio of rates


@dataclass(frozen=True, kw_only=True)
class Accelerations:
    """Of hub, housing and sensor, by the result file's names."""

    rate: int  # Hz
    values: dict[str, np.ndarray]  # (n,), m/s²

    @property
    def time(self) -> np.ndarray:
        """(n,), s."""
        return np.arange(len(next(iter(self.values.values())))) / self.rate


def channels(scene: Scene) -> tuple[str, ...]:
    """What a run of a scene has of them."""
    return "inner_ax", "inner_ay", *(name for name in scene.mounting().columns if name.endswith(("_ax", "_ay")))


def accelerations(scene: Scene, column: Callable[[str], np.ndarray]) -> Accelerations:
    """Accelerations of a run at the scene's rate, [output] acceleration_Hz; `column` gives a variable by its name.

    A linear-phase filter, its delay taken off, keeps all below the rate over OVER_BAND within 0.01 %, and lowers by
    STOPPED what would fold into that band. Beyond its ends the record counts as 0, for half the filter's length.

    Errors
    ------
    UsageError: the rate is not below that of the samples, or no ratio of small whole numbers to it. What lies above
    half the rate of the samples has folded already as they were taken.
    """
    rate, interval = scene.output.acceleration_Hz, scene.numerics.output_interval_us
    ratio = Fraction(rate * interval * 1e-6).limit_denominator(MOST_PARTS)
    if ratio >= 1:
        raise UsageError(
            f"output.acceleration_Hz = {rate}: samples every {interval:g} µs are too coarse; store more often, "
            f"numerics.output_interval_us below {1e6 / rate:.4g}, or use a lower rate"
        )
    if ratio == 0 or abs(float(ratio) / (rate * interval * 1e-6) - 1.0) > 1e-9:
        raise UsageError(
            f"output.acceleration_Hz = {rate}: no ratio of small whole numbers to one sample every {interval:g} µs; "
            "change one of them"
        )
    from scipy import signal

    up, down = ratio.numerator, ratio.denominator
    width = 2.0 * (1.0 - 2.0 / OVER_BAND)  # from the band to what folds into its end, over half the new rate
    taps, beta = signal.kaiserord(STOPPED, width / down)
    if taps > MOST_TAPS:
        raise UsageError(f"output.acceleration_Hz = {rate}: too low for samples every {interval:g} µs")
    window = signal.firwin(taps | 1, 1.0 / down, window=("kaiser", beta))
    values = {name: signal.resample_poly(column(name), up, down, window=window) for name in channels(scene)}
    return Accelerations(rate=rate, values=values)


def write_accelerations(target: Path, found: Accelerations) -> None:
    """Write them as a file's name asks: CSV in m/s² and in g, WAV in m/s² (32-bit floating point)."""
    if target.suffix.lower() == ".wav":
        write_whole(target, _wav(found))
        return
    columns = {"time_s": found.time}
    for name, values in found.values.items():
        columns |= {f"{name}_m_s2": values, f"{name}_g": values / G}
    with replaced(target) as part:
        np.savetxt(part, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")


def _wav(found: Accelerations) -> bytes:
    """A WAV file with a list of remarks at its end, which names the program.

    Source: Microsoft and IBM, Multimedia Programming Interface and Data Specifications 1.0 (1991), RIFF, INFO list.
    """
    from scipy.io import wavfile

    wavfile.write(file := io.BytesIO(), found.rate, np.column_stack(list(found.values.values())).astype(np.float32))
    remark = b"INFOISFT" + struct.pack("<I", len(WAV_REMARK)) + WAV_REMARK
    data = file.getvalue() + b"LIST" + struct.pack("<I", len(remark)) + remark
    return data[:4] + struct.pack("<I", len(data) - 8) + data[8:]
