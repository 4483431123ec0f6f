"""Strikes of rolling elements in a record: the mean pulse that they leave, and the width of a ring's damage.

The width follows from the lag between a rolling element's entry into the damage and its strike on the far edge.

The lag shows as a side peak of the envelope's autocorrelation. It is sought in three bands of the prewhitened record,
three parts of it and with two smoothings. A width is stated only where these agree, with each other and with the same
of the record as it is: in that an inverter's tones beat, and prewhitening echoes strong strikes, each in its own alone.
The lag is a share of the time in which the element would roll across, because it strikes before its centre is over the
far edge: 0.83 in measured records of known widths, 0.70 to 0.96, which gives the interval.

Source of the principle: N. Sawalhi, R. B. Randall, Vibration response of spalled rolling element bearings, Mech. Syst.
Signal Process. 25 (2011) 846-870.
"""

from dataclasses import dataclass
from math import cos, pi

import numpy as np

from residual.measured.diagnosis import Diagnosis, Geometry
from residual.measured.envelope import prewhitened
from residual.measured.signals import Signal

RINGS = {"outer_ring": 1.0, "inner_ring": -1.0}  # sign of an element's radius in its raceway's
SHARE, LEAST_SHARE, MOST_SHARE = 0.83, 0.70, 0.96  # of the rolling time, until the strike
BANDS, PARTS = 3, 3
SMOOTHINGS = (0.01, 0.02)  # of the time between strikes, standard deviation of a Gaussian
LOWEST, PASSES_IN_BAND = 500.0, 8.0  # Hz, where bands of strikes begin: at least, and times the line
TOP = 0.45  # of the rate
PROMINENCE = 0.02  # of a side peak, over the autocorrelation at no lag
LONGEST = 0.5  # of the time between strikes
NEAREST = 3.0  # smoothings from no lag
AGREE, FEWEST_AGREEING = 0.08, 7  # of the median, and of the nine bands and parts
AGREE_RAW, FEWEST_RAW = 0.1, 4  # the same of the record that is not prewhitened: true lags show in both
NARROWEST = 1.3e-3  # m: lags of narrower damage drown in the ringing
# of the mean pulse
SMOOTHING = 0.01  # of the time between strikes, standard deviation of a Gaussian, to find them
BEFORE, AFTER = 0.3, 0.7  # of the time between strikes, about its highest
HALF = 0.5  # of the height over the background, where a pulse's length is measured


@dataclass(frozen=True, kw_only=True)
class Width:
    """A width, or the reason why there is none."""

    value: float | None  # m
    low: float | None  # m
    high: float | None  # m
    reason: str | None


def damage_width(signal: Signal, geometry: Geometry, diagnosis: Diagnosis) -> Width:
    """The width of the damage of a damaged ring, along its raceway.

    Errors
    ------
    Measured records of 2.05 to 3.28 mm are found within a tenth; the interval is that of the share, not of this record.
    """
    sign = RINGS.get(diagnosis.verdict)
    if sign is None:
        return _none("no ring was found damaged")
    line = diagnosis.findings[0].found
    lags = _lags(prewhitened(signal.values), signal.rate, line)
    found = np.isfinite(lags)
    if not found.any():
        return _none("no second pulse follows an impact, as entry and exit would give")
    median = float(np.median(lags[found]))
    agree = found & (np.abs(lags / median - 1.0) <= AGREE)
    places = int(agree.any(axis=2).sum())
    if places < FEWEST_AGREEING:
        return _none(
            f"entry-to-impact times agree in only {places} of {BANDS * PARTS} estimates ({FEWEST_AGREEING} needed)"
        )
    raw = np.abs(_lags(signal.values, signal.rate, line) / median - 1.0) <= AGREE_RAW
    if raw.any(axis=2).sum() < FEWEST_RAW:
        return _none("the prewhitened record has a lag that the record itself has not: an echo of the prewhitening")
    raceway = geometry.pitch_diameter + sign * geometry.element_diameter * cos(geometry.contact_angle)
    speed = pi * raceway * line / geometry.elements  # m/s, of the contact along the raceway
    value = float(np.median(lags[agree])) * speed / SHARE
    if value < NARROWEST:
        return _none(f"the lags give {1e3 * value:.2g} mm; below {1e3 * NARROWEST:g} mm they may come from ringing")
    return Width(value=value, low=value * SHARE / MOST_SHARE, high=value * SHARE / LEAST_SHARE, reason=None)


def _none(reason: str) -> Width:
    return Width(value=None, low=None, high=None, reason=reason)


def _lags(values: np.ndarray, rate: float, line: float) -> np.ndarray:
    """Lags of the envelope's most prominent side peaks, s, (BANDS, PARTS, smoothings); nan where there is none."""
    from scipy import fft

    lags = np.full((BANDS, PARTS, len(SMOOTHINGS)), np.nan)
    low, high = max(LOWEST, PASSES_IN_BAND * line), TOP * rate
    if low >= high:
        return lags
    edges = np.geomspace(low, high, BANDS + 1)
    transform = fft.fft(values[: fft.prev_fast_len(values.size)])
    frequency = fft.fftfreq(transform.size, 1.0 / rate)
    for i in range(BANDS):
        inside = (frequency >= edges[i]) & (frequency < edges[i + 1])
        envelope = np.abs(fft.ifft(np.where(inside, transform, 0.0)))
        for j, part in enumerate(np.array_split(envelope, PARTS)):
            for k, smoothing in enumerate(SMOOTHINGS):
                lags[i, j, k] = _side_peak(part, smoothing / line * rate, LONGEST / line * rate)
    return lags / rate


def _side_peak(envelope: np.ndarray, smoothing: float, longest: float) -> float:
    """Lag of the most prominent side peak of an envelope's autocorrelation, samples; nan: none."""
    from scipy import fft
    from scipy.signal import find_peaks

    size = fft.next_fast_len(2 * envelope.size, real=True)
    transform = fft.rfft(envelope - envelope.mean(), size)
    gauss = np.exp(-0.5 * (2.0 * np.pi * fft.rfftfreq(size) * smoothing) ** 2)
    correlation = fft.irfft(np.abs(transform * gauss) ** 2, size)[: int(longest)]
    if correlation.size < 3 or not correlation[0] > 0.0:
        return float("nan")
    at, facts = find_peaks(correlation / correlation[0], prominence=PROMINENCE)
    far = at > NEAREST * smoothing
    return float(at[far][np.argmax(facts["prominences"][far])]) if far.any() else float("nan")


@dataclass(frozen=True, kw_only=True, eq=False)
class Pulse:
    """Mean power about a strike."""

    time: np.ndarray  # (n_times,), s, from the highest
    power: np.ndarray  # (n_times,), over the record's mean
    length: float  # s, for which it stands above half its height over the background

    @property
    def contrast(self) -> float:
        """Highest power over the lowest."""
        return float(self.power.max() / max(self.power.min(), np.finfo(float).tiny))


def mean_pulse(values: np.ndarray, rate: float, line: float) -> Pulse | None:
    """The mean pulse of a record, (n_times,), at a line, Hz; None: the rate leaves no band above it.

    Errors
    ------
    The highest power of each pass is taken for its strike: noise alone has a pulse too, of the smoothing's length.
    """
    from scipy import fft
    from scipy.ndimage import gaussian_filter1d

    low = max(LOWEST, PASSES_IN_BAND * line)
    if low >= 0.4 * rate:
        return None
    size = fft.prev_fast_len(values.size, real=True)
    transform = fft.rfft(values[:size])
    band = np.zeros(size, dtype=complex)
    above = fft.rfftfreq(size, 1.0 / rate) >= low
    band[: transform.size][above] = 2.0 * transform[above]
    power = np.abs(fft.ifft(band)) ** 2
    period = rate / line
    smooth = gaussian_filter1d(power, SMOOTHING * period)
    before, after = int(BEFORE * period), int(AFTER * period)
    starts = (np.arange(1, int(size / period) - 1) * period).astype(int)
    strikes = np.array([start + int(np.argmax(smooth[start : start + int(period)])) for start in starts])
    mean = smooth[np.add.outer(strikes, np.arange(-before, after))].mean(axis=0) / power.mean()
    above = mean >= mean.min() + HALF * (mean.max() - mean.min())
    return Pulse(time=np.arange(-before, after) / rate, power=mean, length=float(np.count_nonzero(above)) / rate)
