"""Orders: spectra over the shaft's angle, in which the bearing's lines stay where they are while its speed changes.

Computed order tracking: a signal is resampled at equal angles of the shaft, and its spectrum taken as of any other; in
place of Hz then stands the order, cycles per turn of the shaft, and in place of s the turn.

Source: Fyfe and Munck, Analysis of computed order tracking, Mechanical Systems and Signal Processing 11 (1997) 187-205.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from lagrange.kinematics import kinematics, turned
from residual.errors import InputError
from residual.lines import named_peaks
from residual.record import FEWEST_SAMPLES, TIME_JITTER, Record
from residual.spectrum import (
    PASSAGE_SHARE,
    Peak,
    ShortTime,
    Spectrum,
    band_envelope,
    find_peaks,
    kinematic_lines,
    power_spectrum,
    short_time_spectrum,
)
from residual.vibration import ENVELOPE_FROM, ENVELOPE_TO, NARROWEST

FEWEST_TURNS = 1.0  # in fewer no order is resolved
SLOWEST = 1.0 / 8.0  # of the highest speed: below, so many samples go to one turn that nothing new is in them
DEGREE = 5  # of the spline through a signal's samples
TURNS_PER_PIECE = 10.0  # of short-time spectra: FTF, some 0.4, is then four bins off order 0
HIGHEST = 2.2  # times BPFI: as far as lines are looked for in short-time spectra


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """A part of a record in which the shaft turns on, and its equal angles."""

    part: slice  # of the record's samples
    time: np.ndarray  # (n_times,), s, of the part
    turn: np.ndarray  # (n_times,), rising, turns of the shaft at the samples
    angles: np.ndarray  # (n_angles,), turns, equally spaced
    lines: dict[str, float]  # orders, by the run's own cage

    @property
    def step(self) -> float:
        """Between angles, turns."""
        return float((self.angles[-1] - self.angles[0]) / (self.angles.size - 1))

    def resampled(self, signal: np.ndarray) -> np.ndarray:
        """A signal of the whole record, (n_record,), at the equal angles.

        Errors
        ------
        Angles are as near to each other as samples are where the shaft is slowest, so that nothing is folded down.
        """
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.turn, signal[self.part], k=DEGREE)(self.angles)

    def envelope(self, acceleration: np.ndarray) -> np.ndarray | None:
        """Envelope of an acceleration, (n_record,), above what rollers do by passing even at the highest speed."""
        interval = float(self.time[1] - self.time[0])
        fastest = float(np.gradient(self.turn, interval).max())  # 1/s
        inner, cage = self.lines["BPFI"] * fastest, self.lines["FTF"] * fastest
        found = band_envelope(acceleration, interval, ENVELOPE_FROM * inner, ENVELOPE_TO, cage)
        return None if found is None or found.high - found.low < NARROWEST * inner else found.level


@dataclass(frozen=True, kw_only=True)
class OrderSpectra:
    """Of one direction; `frequency` of spectra, peaks and levels is an order, a density is per order."""

    tracking: Tracking
    error: Spectrum  # of the error force, N²
    path: Spectrum  # of the hub's place, m²
    peaks: list[Peak]  # of that
    short_time: ShortTime | None  # of that, over turns; None: the record is too short
    envelope: Spectrum | None  # of the envelope of the measured acceleration, (m/s²)²; None: no band is free for it


def tracking_of(record: Record) -> Tracking | None:
    """The longest part of a record with equal angles; None where the speed stays, or the shaft hardly turns.

    What is slower than an eighth of the highest speed, or turns back, is left out.
    """
    if not record.varies_speed:
        return None
    speed = np.asarray(record.acting.speed)
    fast = np.sign(speed) * (np.abs(speed) >= SLOWEST * np.abs(speed).max())
    ends = np.concatenate([[0], 1 + np.flatnonzero(np.diff(fast)), [speed.size]])
    first, last = max(((a, b) for a, b in pairwise(ends) if fast[a] != 0.0), key=lambda e: e[1] - e[0])
    part = slice(int(first), int(last))
    time = record.time[part]
    turn = fast[first] * (turned(record.bearing, record.operation, time).shaft / (2.0 * np.pi))
    if time.size < FEWEST_SAMPLES or turn[-1] - turn[0] < FEWEST_TURNS:
        return None
    count = int(np.ceil((turn[-1] - turn[0]) / np.diff(turn).min())) + 1
    return Tracking(
        part=part, time=time, turn=turn, angles=np.linspace(turn[0], turn[-1], count),
        lines=_lines(record.samples(part), turn[-1] - turn[0]),
    )  # fmt: skip


def _lines(record: Record, turns: float) -> dict[str, float]:
    """Orders of the kinematic lines, by the run's own cage where it turns with the shaft."""
    ideal = kinematics(record.bearing, 2.0 * np.pi)
    seen = abs(record.cage_speed) * (record.time[-1] - record.time[0]) / turns
    found = kinematic_lines(replace(ideal, cage=seen))
    return found if "FTF" in found else kinematic_lines(ideal)


def order_spectra(tracking: Tracking, error: np.ndarray, path: np.ndarray, acceleration: np.ndarray) -> OrderSpectra:
    """Order spectra of signals of the whole record: an error force, N, the hub's place, m, an acceleration, m/s²."""
    lines, step = tracking.lines, tracking.step
    slowest, place = lines["FTF"], tracking.resampled(path)
    spectrum, envelope = power_spectrum(place, step, slowest), tracking.envelope(acceleration)
    return OrderSpectra(
        tracking=tracking, error=power_spectrum(tracking.resampled(error), step, slowest), path=spectrum,
        peaks=named_peaks(find_peaks(spectrum, lines), spectrum, lines, 0.0, 0.0),
        short_time=_short_time(place, step, HIGHEST * lines["BPFI"]),
        envelope=None if envelope is None else power_spectrum(tracking.resampled(envelope), step, slowest),
    )  # fmt: skip


def _short_time(values: np.ndarray, step: float, highest: float) -> ShortTime | None:
    """Short-time spectrum up to an order, after a filter against what lies above."""
    from scipy.signal import decimate

    fewer = max(1, int(0.5 / (1.5 * highest * step)))
    if fewer > 1:
        values, step = decimate(values, fewer, ftype="fir"), step * fewer
    return short_time_spectrum(values, step, PASSAGE_SHARE / TURNS_PER_PIECE)


# Resampling of irregular samples at equal steps.


SPLINE_DEGREE = 7  # of the spline: smoother than the highest order of differentiation needs
LARGEST_GAP = 10.0  # of the median interval: nothing is made up across more
FORCES = ("inner_force", "outer_force", "inner_traction", "outer_traction")  # with kinks: straight lines


DECIMALS = range(13)  # of time stamps, in s
COARSEST = 0.5  # last place over the interval: a row that is missing then can't pass as rounding
ROUNDED = 0.75  # of their last place: half for rounding, the rest for the fit of a few stamps


def even_clock(time: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Times of an even clock whose stamps were rounded, with a note; None: they are even, or no such clock's."""
    if time.size < FEWEST_SAMPLES or not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
        return None
    count = np.arange(time.size)
    mean = (time[-1] - time[0]) / (time.size - 1)
    if np.max(np.abs(np.diff(time) - mean)) <= TIME_JITTER * mean:
        return None
    centred = count - count.mean()
    interval = float(centred @ (time - time.mean()) / (centred @ centred))
    even = time.mean() + interval * centred
    for place in (10.0**-k for k in DECIMALS):
        if np.max(np.abs(time / place - np.round(time / place))) < 1e-3:  # of stamps as floats: 1e-3 of a place
            if place > COARSEST * interval or np.max(np.abs(time - even)) > ROUNDED * place:
                return None
            return even, f"the time stamps are rounded to {place:g} s; an even clock of {interval:.9g} s is taken"
    return None


def evenly_sampled(path: Path, arrays: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], str | None]:
    """Bring arrays to as many equal steps, with a note; unchanged and None where the steps are equal already.

    Errors
    ------
    InputError: time falls or stands, a gap of more than ten intervals, too few samples. Vibration above a quarter of
    the mean sampling rate is not to be trusted afterwards.
    """
    from scipy.interpolate import make_interp_spline

    time = arrays["time"]
    steps = np.diff(time)
    if time.size < FEWEST_SAMPLES or not np.all(np.isfinite(time)):
        return arrays, None  # refused with the other checks
    even = (time[-1] - time[0]) / (time.size - 1)
    if np.any(steps <= 0.0):
        i = int(np.argmax(steps <= 0.0))
        raise InputError(f"{path}: time does not rise after sample {i} ({time[i]:.9g} s); sort it, --resample can't")
    if np.max(np.abs(steps - even)) <= TIME_JITTER * even:
        return arrays, None
    if np.max(steps) > LARGEST_GAP * np.median(steps):
        i = int(np.argmax(steps))
        raise InputError(
            f"{path}: a gap of {steps[i]:.4g} s after sample {i}, {steps[i] / np.median(steps):.3g} intervals long; "
            f"--resample bridges at most {LARGEST_GAP:g}"
        )
    equal = np.linspace(time[0], time[-1], time.size)
    result = {"time": equal}
    for name, value in arrays.items():
        if name in FORCES:
            result[name] = np.column_stack([np.interp(equal, time, column) for column in value.T])
        elif name != "time":
            if not np.all(np.isfinite(value)):
                raise InputError(f"{path}: {name} holds values that are not finite; leave those samples out")
            middle = value.mean(axis=0)
            result[name] = middle + make_interp_spline(time, value - middle, k=SPLINE_DEGREE)(equal)
    return result, (
        f"the sampling was irregular (intervals {steps.min():.4g} to {steps.max():.4g} s) and has been resampled to "
        f"{time.size} samples every {even:.4g} s, motion by a spline of degree {SPLINE_DEGREE}, "
        "forces by straight lines"
    )
