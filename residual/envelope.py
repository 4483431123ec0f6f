"""Envelope spectrum, which shows how the vibration in a band swells and fades.

Something that strikes once per roller makes a resonance ring each time: its frequency shows in the envelope of a band
that holds the resonance, not at low frequency itself. Units are the signal's: N of an error force, m/s² of an
acceleration.
"""

from dataclasses import dataclass

import numpy as np

from residual.moments import rms
from residual.spectrum import Spectrum, power_spectrum

BAND = (2.0**-0.5, 2.0**0.5)  # of the resonance: one octave around it
FILTER_ORDER = 4
TOP_OF_NYQUIST = 0.9
TRANSIENT = 6.0  # periods of the band's width, both ends together
SHORTEST = 0.01  # periods of the band's lower edge in a record: of slower ones there is no filter in double precision


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """Envelope of one signal in a band."""

    low: float  # Hz, the band
    high: float
    rms: float  # of the band itself
    band: np.ndarray  # (n_times,), the signal in the band
    level: np.ndarray  # (n_times,), the envelope
    spectrum: Spectrum  # of the envelope, its mean removed


def envelope(signal, interval: float, resonance: float, slowest_line: float = 0.0) -> Envelope | None:
    """Envelope around a resonance, Hz; None where the signal is too coarse or too short for it, or has none."""
    if resonance <= 0.0 or resonance >= TOP_OF_NYQUIST * 0.5 / interval:
        return None
    return band_envelope(signal, interval, resonance * BAND[0], resonance * BAND[1], slowest_line)


def band_envelope(signal, interval: float, low: float, high: float, slowest_line: float = 0.0) -> Envelope | None:
    """Envelope of a band, Hz, up to 0.9 of the Nyquist frequency; None where the signal is too coarse or too short.

    Parameters
    ----------
    signal : ndarray, (n_times,)
    interval : float, s

    Errors
    ------
    Zero-phase Butterworth filter, then the analytic signal. At either end about three periods of the band's width
    are transient; the spectrum's window hides them.
    """
    from scipy.signal import butter, hilbert, sosfiltfilt

    signal = np.asarray(signal, dtype=float)
    high = min(high, TOP_OF_NYQUIST * 0.5 / interval)
    duration = signal.size * interval
    if (high - low) * duration < TRANSIENT or low * duration < SHORTEST:
        return None
    sections = butter(FILTER_ORDER, (low, high), "bandpass", fs=1.0 / interval, output="sos")
    band = sosfiltfilt(sections, signal - signal.mean(), padlen=min(signal.size - 1, 60))
    level = np.abs(hilbert(band))
    return Envelope(
        low=low, high=high, rms=rms(band), band=band, level=level,
        spectrum=power_spectrum(level, interval, slowest_line),
    )  # fmt: skip
