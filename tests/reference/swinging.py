"""Further bodies of the time loops on springs and dashpots: a drive for one alone, and how it rings down."""

from itertools import pairwise

import numpy as np

from fem.elastic.reciprocal_mass import SECOND
from fem.kernels.elements.state import Drive

PEDESTAL = {"kind": "housing"}  # its defaults: 12.638 kg, 15.1e6 N/m, 2210.7 N s/m


def drive(dt: float, gravity: float = 0.0) -> Drive:
    arrays = {name: np.zeros(6) for name in ("hub", "velocity", "frame", "impulse", "moment", "sums")}
    numbers = {name: 0.0 for name in ("speed", "radial_load", "ramp")}
    return Drive(
        **arrays, **numbers, slowed=np.zeros((2, 2)), mass=1.0, late_mass=1.0, gravity=gravity, dt=dt,
        slowing=SECOND.at(dt).waves, calming=0.0,
    )  # fmt: skip


def ring_down(values: np.ndarray, dt: float) -> tuple[float, float]:
    """Undamped frequency, Hz, and damping ratio of a decaying oscillation, by its crossings of 0 and its peaks."""
    at = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    crossings = (at + values[at] / (values[at] - values[at + 1])) * dt
    damped = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    peaks = [values[a:b].max() for a, b in pairwise(at)]
    decrement = np.log(peaks[0] / peaks[-1]) / (len(peaks) - 1)
    zeta = decrement / np.hypot(2.0 * np.pi, decrement)
    return damped / np.sqrt(1.0 - zeta**2), zeta
