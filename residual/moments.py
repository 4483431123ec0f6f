"""Mean, rms and the like of a record."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """Of one record, N."""

    mean: float
    rms: float
    std: float
    max_abs: float

    @classmethod
    def of(cls, record: np.ndarray) -> "Statistics":
        return cls(
            mean=float(np.mean(record)),
            rms=float(np.sqrt(np.mean(record**2))),
            std=float(np.std(record)),
            max_abs=float(np.max(np.abs(record))),
        )
