"""Mean, rms and the like of a signal."""

from dataclasses import dataclass

import numpy as np


def rms(signal) -> float:
    """Root of the mean square, in the signal's unit."""
    return float(np.sqrt(np.mean(signal**2)))


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """Mean, rms, standard deviation and largest magnitude of one signal, N."""

    mean: float
    rms: float
    std: float
    max_abs: float

    @classmethod
    def of(cls, signal: np.ndarray) -> "Statistics":
        return cls(
            mean=float(np.mean(signal)), rms=rms(signal), std=float(np.std(signal)),
            max_abs=float(np.max(np.abs(signal))),
        )  # fmt: skip
