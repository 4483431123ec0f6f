"""Short-time spectrum: how the error force's spectrum changes along the record."""

from dataclasses import dataclass

import numpy as np

from residual.spectrum import WINDOW

PASSAGE_SHARE = 0.5  # of a roller passage: what happens once per roller is told apart
RECORD_SHARE = 1.0 / 32.0  # of the signal, where nothing passes
FEWEST_IN_WINDOW = 32  # samples
MOST_COLUMNS = 800  # a figure's panel is 750 pixels wide; windows overlap by at least half


@dataclass(frozen=True, kw_only=True)
class ShortTime:
    """Spectra of overlapping pieces of one signal."""

    time: np.ndarray  # (n_pieces,), s, their middles, from the signal's first sample
    frequency: np.ndarray  # (n_frequencies,), Hz
    psd: np.ndarray  # (n_frequencies, n_pieces), N²/Hz, one-sided
    length: float  # s, of a piece


def short_time_spectrum(signal, interval: float, passing: float = 0.0) -> ShortTime | None:
    """Short-time spectrum of a signal, its mean removed; None where the signal is too short for it.

    Parameters
    ----------
    signal : ndarray, (n_times,), N
    interval : float, s
    passing : Hz, the ball-pass frequency; 0: nothing passes

    Errors
    ------
    A piece of length T tells apart 2/T in frequency and T/2 in time; pieces that reach beyond the signal are left out.
    """
    from scipy.signal import ShortTimeFFT

    signal = np.asarray(signal, dtype=float)
    duration = PASSAGE_SHARE / passing if passing > 0.0 else RECORD_SHARE * signal.size * interval
    length = max(FEWEST_IN_WINDOW, round(duration / interval))
    if signal.size < 4 * length:
        return None
    hop = max(1, min(length // 2, signal.size // MOST_COLUMNS))
    transform = ShortTimeFFT.from_window(
        WINDOW, 1.0 / interval, length, length - hop, fft_mode="onesided2X", scale_to="psd"
    )
    first, last = transform.lower_border_end[1], transform.upper_border_begin(signal.size)[1]
    psd = transform.spectrogram(signal - signal.mean(), p0=first, p1=last)
    return ShortTime(
        time=transform.t(signal.size, first, last), frequency=transform.f, psd=psd, length=length * interval
    )
