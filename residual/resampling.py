"""Resampling of irregular samples at equal steps."""

from pathlib import Path

import numpy as np

from residual.errors import InputError
from residual.record import FEWEST_SAMPLES, TIME_JITTER

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
        f"{time.size} samples every {even:.4g} s, motion by a spline of degree {SPLINE_DEGREE}, forces by straight lines"
    )
