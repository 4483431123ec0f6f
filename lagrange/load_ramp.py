"""A load that grows from nothing by half a cosine, without a jump in its rate."""

from math import pi

import numpy as np


def load_share(time, ramp: float):
    """Share of the load that acts at a time, s, 0 to 1; any shape. Without a ramp (0 s) all of it."""
    time = np.asarray(time, dtype=float)
    if ramp <= 0.0:
        return np.ones_like(time)
    return 0.5 * (1.0 - np.cos(pi * np.clip(time / ramp, 0.0, 1.0)))


def load_share_rate(time, ramp: float):
    """Rate of `load_share`, 1/s."""
    time = np.asarray(time, dtype=float)
    if ramp <= 0.0:
        return np.zeros_like(time)
    return 0.5 * pi / ramp * np.sin(pi * np.clip(time / ramp, 0.0, 1.0))
