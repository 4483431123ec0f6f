"""What charts show of the past: the hub's orbit since the last frame, the spectrum of an acceleration."""

from collections.abc import Container

import numpy as np

from fem.solver.solver import Samples
from lagrange.mounting import from_outer_ring

LONGEST = 2**15  # samples that a spectrum is of
SHORTEST = 256
LOWEST, HIGHEST = 20.0, 20e3  # Hz, of the spectrum shown; beyond, bodies without mass are not those of steel
BANDS = 300
MOST_PLACES = 500  # of an orbit, a frame


def measured(names: Container[str]) -> tuple[str, str]:
    """Accelerations, x and y, that an accelerometer would show: of sensor, housing or hub, whichever there is first."""
    x = next(name for name in ("housing_ax", "inner_ax") if name in names)
    return x, next(name for name in ("sensor_ay", "housing_ay", "inner_ay") if name in names)


class Record:
    """The last samples of a run."""

    def __init__(self, interval: float):
        self._interval = interval  # s, between samples
        self._acceleration = np.zeros((2, 0))
        self._orbit = np.zeros((2, 0))

    def add(self, samples: Samples) -> None:
        """Take the next samples."""
        acceleration = np.array([samples[name] for name in measured(samples.values)])
        self._acceleration = np.concatenate([self._acceleration, acceleration], axis=1)[:, -LONGEST:]
        place = np.array(from_outer_ring(samples, "inner"))
        self._orbit = np.concatenate([self._orbit, place], axis=1)[:, -LONGEST:]

    def orbit(self) -> np.ndarray:
        """Places of the hub since the last call, at most MOST_PLACES, evenly chosen, (2, n), m."""
        way, self._orbit = self._orbit, np.zeros((2, 0))
        return way[:, :: -(-way.shape[1] // MOST_PLACES) or 1]

    @property
    def length(self) -> float:
        """Time that the spectrum is of, s."""
        return self._acceleration.shape[1] * self._interval

    def spectrum(self) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes of the measured acceleration, (2, n), m/s², x and y, by frequencies, (n,), Hz.

        Each is the highest of its band, BANDS of equal ratio; none where the record is too short.
        """
        if self._acceleration.shape[1] < SHORTEST:
            return np.zeros(0), np.zeros((2, 0))
        from scipy.signal import periodogram  # costs a second to import

        frequency, power = periodogram(
            self._acceleration, 1.0 / self._interval, window="hann", detrend="constant", scaling="spectrum"
        )
        shown = (frequency >= LOWEST) & (frequency <= HIGHEST)
        frequency, amplitude = frequency[shown], np.sqrt(2.0 * power[:, shown])
        band = np.floor(np.log(frequency / LOWEST) / np.log(HIGHEST / LOWEST) * BANDS)
        first = np.flatnonzero(np.diff(band, prepend=-1.0))
        last = np.append(first[1:], frequency.size) - 1
        return np.sqrt(frequency[first] * frequency[last]), np.maximum.reduceat(amplitude, first, axis=1)
