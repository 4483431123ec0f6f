"""Densities, prominent peaks and bands of a signal, in numpy alone.

Importing scipy.signal, which the tests hold these against, would take a third of a report's time.
"""

import numpy as np

EDGE = 60  # samples mirrored at either end of a signal that is filtered


def hann(length: int) -> np.ndarray:
    """Hann window for spectra, (length,): periodic, 0 at its first sample."""
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)


def pieces(signal: np.ndarray, length: int, hop: int) -> np.ndarray:
    """View of a signal's pieces of one length, each `hop` samples after the last, (n_pieces, length)."""
    return np.lib.stride_tricks.sliding_window_view(signal, length)[::hop]


def density(pieces: np.ndarray, interval: float) -> np.ndarray:
    """One-sided power spectral densities of pieces under Hann's window, N²/Hz, (n_pieces, n_frequencies)."""
    length = pieces.shape[1]
    window = hann(length)
    psd = np.abs(np.fft.rfft(pieces * window, axis=1)) ** 2 * (interval / np.sum(window**2))
    psd[:, 1 : (length + 1) // 2] *= 2.0  # what stands at negative frequencies
    return psd


def frequencies(length: int, interval: float) -> np.ndarray:
    """Of the densities of pieces of so many samples, Hz, (n_frequencies,)."""
    return np.fft.rfftfreq(length, interval)


def peaks(level: np.ndarray) -> np.ndarray:
    """Indices of all maxima with a neighbour on either side; of a flat top its first sample."""
    return 1 + np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] >= level[2:]))


def prominence(level: np.ndarray, at: int) -> float:
    """Height of a peak over the higher of the two saddles that part it from anything higher, or from the ends."""
    saddles = []
    for side in (level[:at][::-1], level[at + 1 :]):
        higher = np.flatnonzero(side > level[at])
        saddles.append(side[: higher[0] if higher.size else None].min())
    return float(level[at] - max(saddles))


def analytic_band(signal: np.ndarray, interval: float, low: float, high: float, order: int) -> np.ndarray:
    """Analytic signal of a band, Hz, complex, (n_times,): its real part the signal in the band, its size the envelope.

    Errors
    ------
    Gain of a digital Butterworth band-pass of that order run forwards and backwards, without a shift in time. Both ends
    are mirrored about their last sample; within some periods of the band's width they are transient all the same.
    """
    edge = min(EDGE, signal.size - 1)
    before = 2.0 * signal[0] - signal[edge:0:-1]
    after = 2.0 * signal[-1] - signal[-2 : -edge - 2 : -1]
    extended = np.concatenate([before, signal, after])
    length = extended.size + 4 * edge  # zeros between the ends, which a transform joins
    spectrum = np.fft.fft(extended, length)
    warped = np.tan(np.pi * interval * np.append(np.fft.rfftfreq(length, interval)[1:], [low, high]))
    inside, (start, stop) = warped[:-2], warped[-2:]
    gain = np.zeros(length)  # 0 at negative frequencies
    gain[1 : inside.size + 1] = 2.0 / (1.0 + ((inside**2 - start * stop) / (inside * (stop - start))) ** (2 * order))
    return np.fft.ifft(spectrum * gain)[edge : edge + signal.size]
