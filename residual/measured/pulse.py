"""The pulse that a strike leaves in a record: the mean power about the highest of each pass of a rolling element."""

from dataclasses import dataclass

import numpy as np

LOWEST, PASSES_IN_BAND = 500.0, 8.0  # Hz, where the band begins: at least, and times the line
SMOOTHING = 0.01  # of the time between strikes, standard deviation of a Gaussian, to find them
BEFORE, AFTER = 0.3, 0.7  # of the time between strikes, about its highest
HALF = 0.5  # of the height over the background, where a pulse's length is measured


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
