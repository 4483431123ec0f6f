"""Derivatives and spectra of a uniformly sampled signal: stencils, power density, peaks, envelope; levels.

Units are those of an error force, N; of an acceleration read m/s² for N. Something that strikes once per roller makes a
resonance ring each time: its frequency shows in the envelope of a band that holds the resonance, not at low frequency.

The integrator's own three-point second difference is useless for a check: at the integrator's step it returns the
scheme itself, whatever the error in time. The stencils here are wider, so the balance they give is a test. Near the
ends they keep their points and move off centre; the outermost sample takes five points only. For the 13 kHz mode of the
paper's inner ring, sampled every 10 µs, the central stencil of order 6 errs by 0.05 %, the next ones by 0.4 and 2 %,
the outermost by 43 % and with 4 times the noise; at 3 kHz it errs by 0.5 %. Seven points there would err by 23 % and
carry 14 times the noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from math import factorial
from typing import NamedTuple

import numpy as np

from lagrange.kinematics import OUTER_RING, Kinematics

ORDERS = (4, 6, 8)  # of differentiation
END_POINTS = 5  # of the stencil at the outermost samples
NOISE_BINS, MEAN_SQUARE = 1.5, 0.375  # of the Hann window: its noise bandwidth, bins, and the mean of its squares
MAIN_LOBE = 2.0  # half-width of the Hann window's main lobe, in bins: nearer than this two lines are one peak
SLOWEST = 1e-6  # Hz, of a shaft that has lines: with one turn in twelve days the bearing as good as stands
LOWEST = 1e-9  # Hz, of a line: numbers next to nothing make others infinite
HARMONICS = {"shaft": 3, OUTER_RING: 3, "FTF": 1, "BSF": 1, "BPFO": 5, "BPFI": 5}
# of the slowest line: a longer signal is averaged (Welch) instead of resolved further
REVOLUTIONS_PER_SEGMENT = 40
FALSE_PEAKS = 0.01  # expected number of peaks that noise alone would show, had it a known background
DYNAMIC_RANGE = 1e-8  # peaks this far below the largest are leakage or round-off
MOST_PEAKS = 12  # of a spectrum
PROMINENCE = 4.0  # a peak stands at least this factor above the saddles beside it
MOST_OTHERS = 2  # lines that a peak may be too: a record that tells hardly any apart would name them all
BACKGROUND_BINS = 61  # width of the running median
FILTER_ORDER, TOP_OF_NYQUIST = 4, 0.9
TRANSIENT = 6.0  # periods of the band's width, both ends together
SHORTEST = 0.01  # periods of the band's lower edge in a record: of slower ones there is no filter in double precision


def _weights(first, last, derivative):
    """Weights at 0 on the nodes first … last, unit spacing: derivatives of Lagrange's polynomials, whole numbers."""
    nodes, weights = np.arange(first, last + 1.0), []
    for k, node in enumerate(nodes):
        others = np.delete(nodes, k)
        weights.append(factorial(derivative) * np.poly(others)[-1 - derivative] / np.prod(node - others))
    return np.array(weights)


def stencil(order: int, derivative: int = 2) -> np.ndarray:
    """Weights of the central stencil, (order + 1,), for a unit interval. ValueError: an order other than 4, 6, 8."""
    if order not in ORDERS:
        raise ValueError(f"order = {order}: must be one of {', '.join(map(str, ORDERS))}")
    return _weights(-(order // 2), order // 2, derivative)


def derivative(signal, interval: float, derivative: int = 2, order: int = 6) -> np.ndarray:
    """First or second time derivative of a signal, (n_times, ...), of any unit; in unit/s or unit/s².

    Motion is taken relative to its mean first, so that round-off scales with the motion and not with the position.

    Truncation O(interval^order) where the signal is smooth, one or two orders less in the last order/2 samples at
    either end; at a kink (a contact opening or closing) the order drops. Round-off and truncation are estimated by
    `floor`. ValueError: fewer than order + 1 samples.
    """
    signal, weights, half = np.asarray(signal, dtype=float), stencil(order, derivative), order // 2
    n_times = signal.shape[0]
    if n_times < order + 1:
        raise ValueError(f"{n_times} samples are too few for a stencil of order {order}: at least {order + 1}")
    motion = signal - signal.mean(axis=0)
    result = np.zeros_like(motion)
    for offset, weight in enumerate(weights):
        result[half : n_times - half] += weight * motion[offset : offset + n_times - order]
    for i in range(half):
        last = order - i if i else END_POINTS - 1
        near_end = _weights(-i, last, derivative)
        result[i] = np.tensordot(near_end, motion[: i + last + 1], axes=1)
        result[-1 - i] = (-1.0) ** derivative * np.tensordot(near_end, motion[::-1][: i + last + 1], axes=1)
    return result / interval**derivative


def response(frequency, interval: float, order: int = 6) -> np.ndarray:
    """Gain of the second derivative's stencil over the exact −ω² at `frequency`, Hz; 1 is perfect."""
    turns = np.asarray(frequency, dtype=float) * interval
    # 1 − cos as sines: no cancellation at frequencies far below the sampling's
    return sum(weight * (k * np.sinc(k * turns)) ** 2 for k, weight in enumerate(stencil(order)[order // 2 :]))


class Floor(NamedTuple):
    """Error that the differentiation itself makes, in the unit of the second derivative."""

    round_off: float  # bound: Σ|c| eps max|x − mean| / interval²
    truncation: float  # rms, of the central stencil


def floor(signal, interval: float, order: int = 6, eps: float = np.finfo(float).eps) -> Floor:
    """Estimate the error of the second derivative of one signal, (n_times,), stored with a relative precision `eps`.

    Truncation is what the stencil's gain takes from the derivative's own spectrum: right to a few per cent where the
    signal is sampled finely enough. Motion beyond the Nyquist frequency it can't know, nor order/2 samples at each end.
    """
    signal = np.asarray(signal, dtype=float)
    spectrum = power_spectrum(derivative(signal, interval, order=order), interval)
    gain = response(spectrum.frequency[1:], interval, order)
    missed = spectrum.psd[1:] * ((1.0 - gain) / gain) ** 2
    size = np.max(np.abs(signal if eps > 1e-10 else signal - signal.mean()))
    round_off = np.sum(np.abs(stencil(order))) * eps * size / interval**2
    return Floor(round_off, np.sqrt(np.sum(missed) * spectrum.resolution))


def rms(signal) -> float:
    """Root of the mean square, in the signal's unit."""
    return np.sqrt(np.mean(signal**2))


class Level(NamedTuple):
    """Size and shape of a vibration, its mean removed, in its unit."""

    rms: float
    peak: float
    crest: float | None  # peak over rms; None without any vibration
    kurtosis: float | None  # fourth moment over squared variance: 3 of Gaussian noise

    @classmethod
    def of(cls, signal: np.ndarray) -> "Level":
        level, peak = rms(signal), np.max(np.abs(signal))
        return cls(level, peak, *((peak / level, np.mean((signal / level) ** 4)) if level else (None, None)))


class Statistics(NamedTuple):
    """Mean, rms, standard deviation and largest magnitude of one signal, N."""

    mean: float
    rms: float
    std: float
    max_abs: float

    @classmethod
    def of(cls, signal: np.ndarray) -> "Statistics":
        return cls(np.mean(signal), rms(signal), np.std(signal), np.max(np.abs(signal)))


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral density."""

    frequency: np.ndarray  # (n_frequencies,), Hz
    psd: np.ndarray  # (n_frequencies,), N²/Hz
    resolution: float  # 1/(length of a segment), Hz
    segments: int  # 1: the whole signal as one periodogram

    @property
    def amplitude(self) -> np.ndarray:
        """Amplitudes, (n_frequencies,), N: of a line in a bin's middle that line's, up to 15 % less between bins."""
        return np.sqrt(2.0 * NOISE_BINS * self.psd * self.resolution)

    @property
    def has_peaks(self) -> bool:
        return bool(self.psd.size >= 5 and np.max(self.psd) > 0.0)

    @property
    def level(self) -> np.ndarray:
        """Logarithm of the density, (n_frequencies,), of nothing too."""
        return np.log(np.maximum(self.psd, np.max(self.psd) * 1e-30))

    def smooth(self, level: np.ndarray) -> np.ndarray:
        """Smooth part of a logarithmic spectrum: a power law plus a running median of the rest."""
        from scipy.ndimage import median_filter

        octaves = np.log(np.maximum(self.frequency, self.frequency[1]))
        trend = np.polyval(np.polyfit(octaves[1:], level[1:], 1), octaves)
        return trend + median_filter(level - trend, size=min(BACKGROUND_BINS, level.size), mode="reflect")

    @cached_property
    def smooth_background(self) -> np.ndarray:
        """Mean density of the smooth background, N²/Hz, (n_frequencies,): what is there without any line."""
        from scipy.special import chdtri

        if not self.has_peaks:
            return np.zeros_like(self.psd)
        freedom = 2.0 * self.segments
        return np.exp(self.smooth(self.level)) * freedom / chdtri(freedom, 0.5)

    def band_rms(self, low: float, high: float) -> float:
        """Rms of the signal in the band low … high, Hz, in N: the root of the density's sum over its bins."""
        inside = (self.frequency >= low) & (self.frequency <= high)
        return np.sqrt(np.sum(self.psd[inside]) * self.resolution)


def maxima(values: np.ndarray) -> np.ndarray:
    """Indices of those above both neighbours."""
    return 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:]))


def prominence(values: np.ndarray, at: int) -> float:
    """Height of a maximum over the higher of the saddles between it and what is higher, or the end, on either side."""
    higher = np.flatnonzero(values > values[at])
    low, high = higher[higher < at].max(initial=0), higher[higher > at].min(initial=values.size - 1)
    return float(values[at] - max(values[low : at + 1].min(), values[at : high + 1].min()))


class Peak(NamedTuple):
    """A peak that stands out of the smooth background."""

    frequency: float  # Hz, interpolated between bins
    psd: float  # N²/Hz, of the highest bin
    rms: float  # N, of the main lobe
    resolved: bool  # no other line, nor zero frequency, within the main lobe
    line: str | None  # kinematic line within the resolution
    also: tuple[str, ...] = ()  # what else it may be: other lines within the resolution, the hub on its contacts


def kinematic_lines(kinematics: Kinematics) -> dict[str, float]:
    """Kinematic lines and their harmonics, Hz, by name: "BPFO", "2×BPFO", ...

    Shaft and a turning outer ring to 3×, ball passes to 5×: what vibration analysts look for in a bearing without
    lubrication or misalignment. Of a bearing that as good as stands there are none.
    """
    found = kinematics.frequencies
    if max(found["shaft"], found.get(OUTER_RING, 0.0)) < SLOWEST:
        return {}
    return {name if k == 1 else f"{k}×{name}": k * frequency for name, frequency in found.items()
            if frequency > LOWEST for k in range(1, HARMONICS[name] + 1)}  # fmt: skip


def power_spectrum(signal, interval: float, slowest_line: float = 0.0) -> Spectrum:
    """One-sided power spectral density of a signal, (n_times,), N, its mean removed, with a Hann window.

    The whole signal is one periodogram, for the finest resolution, unless it is longer than two segments of
    40 periods of `slowest_line`, Hz; then such segments are averaged (Welch, half overlapped).

    The integral is the variance weighted by the squared window: equal to the variance for a stationary
    signal. A bin half-way off a line reads up to 30 % low in density; the rms over the main lobe does not.
    """
    signal = np.asarray(signal, dtype=float)
    length = n = signal.size
    if slowest_line > 0.0:
        wanted = int(np.ceil(REVOLUTIONS_PER_SEGMENT / slowest_line / interval))
        length = wanted if n >= 2 * wanted else n
    return averaged([signal], interval, length)


def averaged(records: Sequence[np.ndarray], interval: float, count: int, padding: int = 1) -> Spectrum:
    """Mean density of the half-overlapping segments of so many samples of records, the mean of each removed.

    `padding` : times its length that a segment has with the zeros behind it: so many bins for one of the resolution
    """
    window, size, total = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count), padding * count, np.zeros(1)
    pieces = [record[start : start + count] for record in records
              for start in range(0, record.size - count + 1, count - count // 2)]  # fmt: skip
    for piece in pieces:
        total = total + np.abs(np.fft.rfft(window * (piece - piece.mean()), size)) ** 2
    psd = 2.0 * interval / (MEAN_SQUARE * count * len(pieces)) * total
    psd[[0, -1] if size % 2 == 0 else [0]] *= 0.5  # which have no negative frequency
    return Spectrum(np.arange(psd.size) / (size * interval), psd, 1.0 / (count * interval), len(pieces))


def find_peaks(spectrum: Spectrum, lines: dict[str, float]) -> list[Peak]:
    """Find significant peaks, highest first.

    A peak must exceed the smooth background by more than exponentially distributed bins of noise do, and
    stand clear of its neighbours by a factor 4. Noise alone shows a peak in about one of twenty spectra. A peak lies
    between its highest bin and the higher neighbour, where a Hann-windowed line would: by (2a − 1)/(a + 1) of a bin for
    the amplitude ratio a.

    Frequency: a few thousandths of a bin for an isolated line; a line nearer to zero frequency or to another line than
    two bins can't be distinguished from it and has `resolved` False.

    Source: T. Grandke, Interpolation algorithms for discrete Fourier transforms of weighted signals, IEEE
    Trans. Instrum. Meas. 32 (1983) 350-355.
    """
    psd, step, peaks = spectrum.psd, spectrum.resolution, list[Peak]()
    if not spectrum.has_peaks:
        return peaks
    level = spectrum.level
    level[0] = min(level[0], level[1])  # zero frequency is removed, not a valley
    background = spectrum.smooth(level)
    factor = np.log2(psd.size / FALSE_PEAKS) ** (1.0 / np.sqrt(spectrum.segments))
    around = np.pad(level, 1, constant_values=level.min() - 1.0)
    at = maxima(around) - 1
    at = at[(level[at] > background[at] + np.log(factor)) & (psd[at] > DYNAMIC_RANGE * psd.max()) & (at > 0)]
    clear = (i for i in at[np.argsort(psd[at])[::-1]].tolist() if prominence(around, i + 1) >= np.log(PROMINENCE))
    for i in islice(clear, MOST_PEAKS):
        frequency = i * step
        if i + 1 < psd.size:
            left, right = (psd[i - 1] if i > 1 else 0.0), psd[i + 1]
            ratio = np.sqrt(max(left, right) / psd[i])
            offset = max(0.0, (2.0 * ratio - 1.0) / (ratio + 1.0))
            frequency = (i + (offset if right >= left else -offset)) * step
        near = sorted((abs(value - frequency), name) for name, value in lines.items())
        names = [name for distance, name in near if distance <= step]
        alone = not any(distance < MAIN_LOBE * step and name not in names[:1] for distance, name in near)
        peaks.append(Peak(
            frequency, psd[i], spectrum.band_rms((i - 2.5) * step, (i + 2.5) * step),
            alone and frequency >= MAIN_LOBE * step, next(iter(names), None), tuple(names[1 : 1 + MOST_OTHERS]),
        ))  # fmt: skip
    return peaks


class Envelope(NamedTuple):
    low: float  # Hz, the band
    high: float
    rms: float  # of the band itself
    band: np.ndarray  # (n_times,), the signal in the band
    level: np.ndarray  # (n_times,), the envelope
    spectrum: Spectrum  # of the envelope, its mean removed


def band_envelope(signal, interval: float, low: float, high: float, slowest_line: float = 0.0) -> Envelope | None:
    """Envelope of a band, Hz, up to 0.9 of the Nyquist frequency; None where the signal is too coarse or too short.

    Zero-phase Butterworth filter, then the analytic signal. At either end about three periods of the band's width
    are transient; the spectrum's window hides them.
    """
    from scipy.signal import butter, hilbert, sosfiltfilt

    signal, high = np.asarray(signal, dtype=float), min(high, TOP_OF_NYQUIST * 0.5 / interval)
    duration = signal.size * interval
    if (high - low) * duration < TRANSIENT or low * duration < SHORTEST:
        return None
    sections = butter(FILTER_ORDER, (low, high), "bandpass", fs=1.0 / interval, output="sos")
    band = sosfiltfilt(sections, signal - signal.mean(), padlen=min(signal.size - 1, 60))
    level = np.abs(hilbert(band))
    return Envelope(low, high, rms(band), band, level, power_spectrum(level, interval, slowest_line))
