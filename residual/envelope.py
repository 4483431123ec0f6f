"""Envelope spectrum, which shows how the vibration at the ring's resonance swells and fades.

Something that strikes once per roller makes the resonance ring each time: its frequency shows in the envelope of
the band around the resonance, not at low frequency itself.
"""

from dataclasses import dataclass

import numpy as np

from residual.moments import rms
from residual.spectrum import Spectrum, power_spectrum

BAND = (2.0**-0.5, 2.0**0.5)  # of the resonance: one octave around it
FILTER_ORDER = 4
TOP_OF_NYQUIST = 0.9
TRANSIENT = 6.0  # periods of the band's width, both ends together


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """Envelope of one signal in a band."""

    low: float  # Hz, the band
    high: float
    rms: float  # N, of the band itself
    level: np.ndarray  # (n_times,), N, the envelope
    spectrum: Spectrum  # of the envelope, its mean removed


def envelope(signal, interval: float, resonance: float, slowest_line: float = 0.0) -> Envelope | None:
    """Envelope around a resonance, Hz; None where the signal is too coarse or too short for it, or has none.

    Parameters
    ----------
    signal : ndarray, (n_times,), N
    interval : float, s

    Errors
    ------
    Zero-phase Butterworth filter, then the analytic signal. At either end about three periods of the band's width
    are transient; the spectrum's window hides them.
    """
    from scipy.signal import butter, hilbert, sosfiltfilt

    nyquist = 0.5 / interval
    low, high = resonance * BAND[0], min(resonance * BAND[1], TOP_OF_NYQUIST * nyquist)
    if resonance <= 0.0 or resonance >= high:
        return None
    signal = np.asarray(signal, dtype=float)
    if (high - low) * signal.size * interval < TRANSIENT:
        return None
    sections = butter(FILTER_ORDER, (low, high), "bandpass", fs=1.0 / interval, output="sos")
    band = sosfiltfilt(sections, signal - signal.mean(), padlen=min(signal.size - 1, 60))
    level = np.abs(hilbert(band))
    return Envelope(
        low=low, high=high, rms=rms(band), level=level,
        spectrum=power_spectrum(level, interval, slowest_line),
    )  # fmt: skip
