"""A record by quarters: whether its beginning is a transient, and where to start instead."""

from dataclasses import dataclass

import numpy as np

from residual.record import Record
from residual.spectrum import rms

QUARTERS = 4
PASSAGES = 2.0  # of rollers in a quarter: in less, what varies is the passage itself
SETTLED = 1.5  # quarters alike differ by no more than this factor
SMALLEST = 1e-9  # m: a hub that moves less stands still


@dataclass(frozen=True, kw_only=True)
class Quarters:
    """What varies in each quarter of a record, each (QUARTERS,)."""

    start: np.ndarray  # s, of the run's time
    hub: dict[str, np.ndarray]  # m, standard deviations of x and y
    error: dict[str, np.ndarray]  # N, rms of error_x and error_y
    settled: int | None  # first quarter from which the hub moves alike; None: it still changes in the last two

    @property
    def note(self) -> str | None:
        """What to do about a transient; None where there is none."""
        if self.settled == 0:
            return None
        widths = "; ".join(
            f"{name} {', '.join(f'{1e9 * value:.3g}' for value in values)} nm" for name, values in self.hub.items()
        )
        moves = f"how far the hub swings changes over the quarters of the record (standard deviations of {widths})"
        if self.settled is None:
            return f"{moves}: it has not settled by the end; simulate longer"
        return f"{moves}: the beginning is a transient; --start {1e3 * self.start[self.settled]:.4g} leaves it out"


def quarters(record: Record, errors: dict[str, np.ndarray], passing: float) -> Quarters | None:
    """Split a record; None where a quarter is too short to tell.

    Parameters
    ----------
    errors : error forces by direction, N, each (n_times,)
    passing : Hz, the ball-pass frequency; 0: nothing passes
    """
    parts = np.array_split(np.arange(record.time.size), QUARTERS)
    if passing <= 0.0 or parts[0].size * record.interval * passing < PASSAGES:
        return None
    hub = {name: np.array([values[part].std() for part in parts]) for name, values in
           (("x", record.inner_x), ("y", record.inner_y))}  # fmt: skip
    swing = np.hypot(hub["x"], hub["y"])  # of both directions together: the lesser may wander as it likes
    return Quarters(
        start=record.time[[part[0] for part in parts]],
        hub=hub,
        error={name: np.array([rms(values[part]) for part in parts]) for name, values in errors.items()},
        settled=_settled(swing),
    )


def _settled(swing: np.ndarray) -> int | None:
    """First quarter from which all swings are alike; None if the last two are not."""
    if swing.max() < SMALLEST:
        return 0
    for first in range(QUARTERS - 1):
        if swing[first:].max() <= SETTLED * swing[first:].min():
            return first
    return None
