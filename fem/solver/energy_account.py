"""Energy exchanged by a run so far, and the energy error of its state."""

from itertools import accumulate

import numpy as np

from fem.solver.solver import Samples


class EnergyAccount:
    """What an energy balance is judged by, carried on from block to block.

    An imbalance counts from the start, so where energy is dissipated it grows without bound, however small each step's
    part is. The state's own error does not: it is dissipated with the rest of the energy. When a run has dissipated as
    much as it exchanges, E, 1/e of an earlier error is left,

        error(t + dt) = error(t) exp(−dD/E) + d(imbalance),

    which is the imbalance itself where nothing is dissipated, and E times the share of the dissipated energy that is
    missing where that share is steady. The criterion is the same for a second and for an hour, and for an error late in
    a long run and at its start.
    """

    def __init__(self):
        self.exchanged = 0.0  # J, the most so far
        self._error, self._imbalance, self._dissipated = 0.0, 0.0, 0.0  # J, of the last sample

    def samples(self, values: dict[str, np.ndarray], imbalance: np.ndarray, exchanged: np.ndarray) -> Samples:
        """The next samples, whose imbalance since the start and exchanged energy, (n,), J, are given.

        How samples are cut into blocks changes no bit of them.
        """
        exchanged = np.fmax.accumulate(np.fmax(exchanged, self.exchanged))
        found = Samples(values=values, imbalance=imbalance, exchanged=exchanged, error=np.zeros(len(imbalance)))
        dissipated = values["work_dissipated"]
        left = np.exp(-np.fmax(np.diff(dissipated, prepend=self._dissipated), 0.0) / found.passed_on)
        added = np.diff(imbalance, prepend=self._imbalance)
        steps = zip(left.tolist(), added.tolist(), strict=True)
        errors = accumulate(steps, lambda error, step: error * step[0] + step[1], initial=self._error)
        found.error[:] = list(errors)[1:]
        self.exchanged, self._error = float(exchanged[-1]), float(found.error[-1])
        self._imbalance, self._dissipated = float(imbalance[-1]), float(dissipated[-1])
        return found

    def to_keep(self) -> list[float]:
        """What runs on; `take_back` takes it back."""
        return [self.exchanged, self._error, self._imbalance, self._dissipated]

    def take_back(self, kept: list[float]) -> None:
        """Go on where another account stood."""
        self.exchanged, self._error, self._imbalance, self._dissipated = map(float, kept)
