"""The roller that figures and tables of a single one are of, and its radial motion."""

import numpy as np

from residual.budget import load_zones
from residual.differentiate import derivative
from residual.record import Record


def chosen_roller(loaded: np.ndarray, bridge: int) -> int:
    """The roller that passes through the load zone most often, whole passes first."""

    def merit(j):
        zones = load_zones(loaded[:, j], bridge)
        whole = sum(first > 0 and last < loaded.shape[0] - 1 for first, last in zones)
        return len(zones), whole, int(loaded[:, j].sum())

    return max(range(loaded.shape[1]), key=merit)


def roller_radial(record: Record, j: int, order: int):
    """Radial position ρ of one roller, m, its velocity, m/s, and its acceleration, m/s²."""
    rho = np.hypot(record.roller_x[:, j], record.roller_y[:, j])
    interval = record.interval
    return rho, derivative(rho, interval, 1, order), derivative(rho, interval, 2, order)
