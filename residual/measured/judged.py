"""A judged record: its verdict with levels, the width of the damage and the mean pulse of its strikes.

The width follows from the lag between a rolling element's entry into the damage and its strike on the far edge. The lag
shows as a side peak of the envelope's autocorrelation. It is sought in three bands of the prewhitened record, three
parts of it and with two smoothings. A width is stated only where these agree, with each other and with the same of the
record as it is: in that an inverter's tones beat, and prewhitening echoes strong strikes, each in its own alone. The
lag is a share of the time in which the element would roll across, because it strikes before its centre is over the far
edge: 0.83 in measured records of known widths, 0.70 to 0.96, which gives the interval.

Source: N. Sawalhi, R. B. Randall, Vibration response of spalled rolling element bearings, Mech. Syst. Signal Process.
25 (2011) 846-870.
"""

from math import cos, pi
from typing import NamedTuple

import numpy as np
from scipy import fft
from scipy.ndimage import gaussian_filter1d

from residual.measured.diagnosis import Diagnosis, Geometry, Prewhitened, Verdict
from residual.measured.signals import Signal
from residual.spectrum import Level, Spectrum, maxima, prominence

# of widths
RINGS = {"outer_ring": 1.0, "inner_ring": -1.0}  # sign of an element's radius in its raceway's
SHARE, LEAST_SHARE, MOST_SHARE = 0.83, 0.70, 0.96  # of the rolling time, until the strike
BANDS, PARTS = 3, 3
SMOOTHINGS = (0.01, 0.02)  # of the time between strikes, standard deviation of a Gaussian
LOWEST, PASSES_IN_BAND = 500.0, 8.0  # Hz, where bands of strikes begin: at least, and times the line
TOP = 0.45  # of the rate
PROMINENCE = 0.02  # of a side peak, over the autocorrelation at no lag
LONGEST, NEAREST = 0.5, 3.0  # of the time between strikes; smoothings from no lag
AGREE, FEWEST_AGREEING = 0.08, 7  # of the median, and of the nine bands and parts
AGREE_RAW, FEWEST_RAW = 0.1, 6  # the same of the record that is not prewhitened: true lags show in both
NARROWEST = 1.3e-3  # m: lags of narrower damage drown in the ringing
WIDEST = 3.6e-3  # m: no wider damage of known width was measured
# of the mean pulse
SMOOTHING = 0.01  # of the time between strikes, standard deviation of a Gaussian, to find them
BEFORE, AFTER = 0.3, 0.7  # of the time between strikes, about its highest
HALF = 0.5  # of the height over the background, where a pulse's length is measured


class Width(NamedTuple):
    """A width, or the reason why there is none."""

    value: float | None = None  # m
    low: float | None = None  # m
    high: float | None = None  # m
    reason: str | None = None


def damage_width(signal: Signal, geometry: Geometry, diagnosis: Diagnosis) -> Width:
    """The width of the damage of a damaged ring, along its raceway.

    Measured records of 2.05 to 3.28 mm are found within a tenth; the interval is that of the share, not of this record.
    """
    sign, line = RINGS.get(diagnosis.verdict), diagnosis.findings[0].found
    if sign is None:
        return Width(reason="no ring was found damaged")
    if geometry.orders:
        return Width(reason="the bearing is given by its orders, without sizes")
    if signal.records > 1:
        return Width(reason="records that are pooled are too short")
    whitened = Prewhitened.of(signal)
    lags = _lags(whitened.transform[0], whitened.size, signal.rate, line)
    found = np.isfinite(lags)
    if not found.any():
        return Width(reason="no second pulse follows an impact, as entry and exit would give")
    median = float(np.median(lags[found]))
    agree = found & (np.abs(lags / median - 1.0) <= AGREE)
    places = int(agree.any(axis=2).sum())
    if places < FEWEST_AGREEING:
        few = f"{places} of {BANDS * PARTS} estimates ({FEWEST_AGREEING} needed)"
        return Width(reason=f"entry-to-impact times agree in only {few}")
    own = _lags(fft.rfft(signal.values[: whitened.size]), whitened.size, signal.rate, line)
    raw = np.abs(own / median - 1.0) <= AGREE_RAW
    if raw.any(axis=2).sum() < FEWEST_RAW:
        echo = "the prewhitened record has a lag that the record itself has not: an echo of the prewhitening"
        return Width(reason=echo)
    raceway = geometry.pitch_diameter + sign * geometry.element_diameter * cos(geometry.contact_angle)
    speed = pi * raceway * line / geometry.elements  # m/s, of the contact along the raceway
    value = float(np.median(lags[agree])) * speed / SHARE
    if not NARROWEST <= value <= WIDEST:
        why = f"below {1e3 * NARROWEST:g} mm they may come from ringing"
        why = why if value < NARROWEST else "no measured record tells whether they are right beyond 3.3 mm"
        return Width(reason=f"the lags give {1e3 * value:.2g} mm; {why}")
    return Width(value, value * SHARE / MOST_SHARE, value * SHARE / LEAST_SHARE)


def _lags(transform, size, rate, line):
    """Lags of the envelope's most prominent side peaks, s, (BANDS, PARTS, smoothings); nan where there is none."""
    lags = np.full((BANDS, PARTS, len(SMOOTHINGS)), np.nan)
    low, high = max(LOWEST, PASSES_IN_BAND * line), TOP * rate
    if low >= high:
        return lags
    edges = np.geomspace(low, high, BANDS + 1)
    frequency = fft.rfftfreq(size, 1.0 / rate)
    for i in range(BANDS):
        inside = (frequency >= edges[i]) & (frequency < edges[i + 1])
        envelope = np.abs(fft.ifft(np.where(inside, transform, 0.0), size))
        for j, part in enumerate(np.array_split(envelope, PARTS)):
            count = fft.next_fast_len(2 * part.size, real=True)
            spectrum = fft.rfft(part - part.mean(), count)
            for k, smoothing in enumerate(share / line * rate for share in SMOOTHINGS):  # samples
                gauss = np.exp(-0.5 * (2.0 * np.pi * fft.rfftfreq(count) * smoothing) ** 2)
                correlation = fft.irfft(np.abs(spectrum * gauss) ** 2, count)[: int(LONGEST / line * rate)]
                if correlation.size < 3 or not correlation[0] > 0.0:
                    continue
                far = [lag for lag in maxima(correlation) if lag > NEAREST * smoothing]
                clear, lag = max(((prominence(correlation, lag), lag) for lag in far), default=(0.0, 0))
                if clear >= PROMINENCE * correlation[0]:
                    lags[i, j, k] = lag
    return lags / rate


class Pulse(NamedTuple):
    """Mean power about a strike."""

    time: np.ndarray  # (n_times,), s, from the highest
    power: np.ndarray  # (n_times,), over the record's mean
    length: float  # s, for which it stands above half its height over the background

    @property
    def contrast(self) -> float:
        return float(self.power.max() / max(self.power.min(), np.finfo(float).tiny))


def mean_pulse(values: np.ndarray, rate: float, line: float) -> Pulse | None:
    """The mean pulse of a record, (n_times,), at a line, Hz; None: the rate leaves no band above it.

    The highest power of each pass is taken for its strike: noise alone has a pulse too, of the smoothing's length.
    """
    low, period = max(LOWEST, PASSES_IN_BAND * line), rate / line
    if low >= 0.4 * rate:
        return None
    size = fft.prev_fast_len(values.size, real=True)
    band = np.where(fft.rfftfreq(size, 1.0 / rate) >= low, fft.rfft(values[:size]), 0.0)
    power = np.abs(fft.ifft(2.0 * band, size)) ** 2
    smooth, around = gaussian_filter1d(power, SMOOTHING * period), np.arange(-int(BEFORE * period), int(AFTER * period))
    starts = (np.arange(1, int(size / period) - 1) * period).astype(int)
    strikes = np.array([start + int(np.argmax(smooth[start : start + int(period)])) for start in starts])
    mean = smooth[np.add.outer(strikes, around)].mean(axis=0) / power.mean()
    above = mean >= mean.min() + HALF * (mean.max() - mean.min())
    return Pulse(around / rate, mean, float(np.count_nonzero(above)) / rate)


class Judged(NamedTuple):
    """A signal with its levels and verdict."""

    signal: Signal
    spectrum: Spectrum  # of the signal itself
    diagnosis: Diagnosis
    shaft: float  # Hz, nominal
    width: Width
    pulse: Pulse | None  # about strikes of the most prominent part
    level: Level
    velocity: float | None  # mm/s rms in ISO 20816's band; None: of no acceleration

    @property
    def notes(self) -> list[str]:
        """What is wrong with the record, and what it does not resolve."""
        return [*self.signal.notes, *self.diagnosis.notes]


class Entry(NamedTuple):
    """A record of a series by its numbers, as summary.json has them; without depths the reason why it can't be used."""

    record: str
    reason: str | None = None
    verdict: Verdict = "none"
    rms: float = np.nan
    unit: str | None = None
    kurtosis: float | None = None
    crest: float | None = None
    velocity_mm_s: float | None = None
    speed_rpm: float = np.nan  # as found
    depths: dict[str, float] | None = None  # by the line of a part
    prominent: str | None = None  # the part's line that stands out; others' depths hold some of that
    records: int = 1  # that were pooled
