"""A study to be tried quickly: two speeds, a millisecond each of the Lagrangian model."""

import numpy as np
import xarray

TWO_SPEEDS = """
[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
[parameters]
"operation.speed_rpm" = [1500, 3000]
[keep]
quantities = ["hub_mean_y"]
"""


BASE = """
[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
"""
GRID = (
    BASE
    + """
[sampling]
method = "grid"
[parameters]
"operation.speed_rpm" = [1500.0, 3000.0, 4500.0]
"bearing.outer_raceway_diameter_mm" = { from = 56.0, to = 56.02, count = 2 }
[keep]
quantities = ["hub_mean_y", "largest_force"]
signals = ["inner_ay", "inner_force"]
signal_rate_kHz = 25.0
"""
)


def same(one, other):
    """Whether two datasets hold the same bits but for the time that each point took."""
    with xarray.open_dataset(one) as a, xarray.open_dataset(other) as b:
        assert set(a.variables) == set(b.variables)
        a, b = a.load(), b.load()
    for name in set(a.variables) - {"seconds"}:
        mine, theirs = a[name].values, b[name].values
        assert mine.dtype == theirs.dtype and mine.shape == theirs.shape
        equal = mine.tobytes() == theirs.tobytes() if mine.dtype.kind != "O" else np.array_equal(mine, theirs)
        assert equal, name


def many(n):
    return GRID.replace("[1500.0, 3000.0, 4500.0]", f"{{ from = 1000.0, to = 5000.0, count = {n} }}")
