"""Resolution and noise of a table's positions, from the positions alone, and the error forces that they make.

A second derivative multiplies noise by the squared sampling rate, a contact law by its stiffness; what they make of it
is no property of the bearing.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from residual.budget import Budget
from residual.differentiate import stencil
from residual.fitted_laws import Law
from residual.record import Record
from residual.words import length, text

DIFFERENCES = 8  # order: of motion a hundred times slower than the sampling nothing is left, of white noise all
NORMAL = 1.4826  # standard deviation over median magnitude
WHOLE = 0.02  # of a step: gaps between rounded numbers are multiples of it but for their own round-off
ENOUGH = 20_000  # samples that show a step
ROUND_OFF = 64 * float(np.finfo(float).eps)  # relative: steps below are those of stored numbers
WITHIN = 2.0  # times the noise floor: an error no larger may be noise, whose rms is estimated


@dataclass(frozen=True, kw_only=True)
class PositionNoise:
    """Errors of a table's positions, m rms of one coordinate, and of the forces computed from them, N rms."""

    step: float  # m, to which positions are rounded; 0: finer than shows
    hub: tuple[float, float]  # m, along x and y
    roller: float  # m
    inertia: tuple[float, float]  # N, of the inertia force along x and y
    law: tuple[float, float]  # N, of the resultant of a law's forces

    @property
    def error(self) -> tuple[float, float]:
        """Floor of error_x and error_y, N rms."""
        x, y = (float(np.hypot(*pair)) for pair in zip(self.inertia, self.law, strict=True))
        return x, y

    @property
    def balance(self) -> float:
        """Floor of the momentum balance, which takes no law's forces, N rms of both directions."""
        return float(np.hypot(*self.inertia))

    @property
    def source(self) -> str:
        """The cause in words."""
        if self.step > 0.0 and self.step / np.sqrt(12.0) >= 0.5 * max(*self.hub, self.roller):
            return f"their rounding to {length(self.step, 3)}"
        hub, roller = length(max(self.hub), 2), length(self.roller, 2)
        return f"noise, or vibration too fast for the sampling (hub {hub} rms, rollers {roller})"

    @property
    def note(self) -> str:
        """The floor in words."""
        x, y = self.error
        return (
            f"the table's positions err by {self.source}: that alone makes an error force of about {text(x, 2)} N rms "
            f"in x and {text(y, 2)} N in y (at most {text(max(self.inertia), 2)} N by differentiation, "
            f"{text(max(self.law), 2)} N by the contact law); smaller residuals are no findings; positions with more "
            "digits and less noise lower it"
        )


def position_noise(record: Record, law: Law, budget: Budget, order: int) -> PositionNoise | None:
    """Determine what positions of a table err by; None for a run of ours, which holds them to round-off.

    Errors
    ------
    Noise is told by the highest frequencies of the table, where vibration beyond its sampling stands too; noise whose
    spectrum falls with frequency is underestimated. Rounding is taken as an error of step/√12, white unless positions
    change more seldom than from sample to sample.
    """
    if record.attributes:
        return None
    x, y = record.roller_x, record.roller_y
    rollers = max(rounding_step(x), rounding_step(y), rounding_step(np.hypot(x, y)))
    steps = [rounding_step(place) if np.ptp(place) > 0.0 else rollers for place in (record.inner_x, record.inner_y)]
    white = [float(noise_level(place)) for place in (record.inner_x, record.inner_y)]
    hub_x, hub_y = (max(noise, step / np.sqrt(12.0)) for noise, step in zip(white, steps, strict=True))
    roller = max(float(np.median(noise_level(place))) for place in (x, y))
    roller = max(roller, rollers / np.sqrt(12.0))
    mass_rate = record.operation.inner_mass / record.interval**2  # N/m
    weights = stencil(order)
    gain = float(np.linalg.norm(weights))
    jump = float(np.linalg.norm(np.cumsum(weights)))  # of a step from one sample to the next
    inertia_x, inertia_y = (
        mass_rate * max(noise * gain, step * min(gain / np.sqrt(12.0), jump * np.sqrt(np.mean(np.diff(place) != 0.0))))
        for place, noise, step in zip((record.inner_x, record.inner_y), white, steps, strict=True)
    )
    slope = law.slope(budget.contacts.inner)
    along = budget.contacts.direction_x, budget.contacts.direction_y
    shared = [[np.mean(np.sum(slope * a * b, axis=1) ** 2) for b in along] for a in along]  # (N/m)²
    each = [np.mean(np.sum((slope * a) ** 2, axis=1)) for a in along]
    law_x, law_y = (
        float(np.sqrt(of_x * hub_x**2 + of_y * hub_y**2 + single * roller**2))
        for (of_x, of_y), single in zip(shared, each, strict=True)
    )
    return PositionNoise(
        step=max(*steps, rollers), hub=(hub_x, hub_y), roller=roller, inertia=(inertia_x, inertia_y),
        law=(law_x, law_y),
    )  # fmt: skip


def noise_level(places: np.ndarray) -> np.ndarray:
    """Rms of the white noise in signals, (n_times, ...), by differences of a high order; in their unit, (...).

    Source: differences that leave no trend, J. von Neumann et al., Annals of Mathematical Statistics 12 (1941) 153.
    """
    left = np.diff(places, n=DIFFERENCES, axis=0)
    return NORMAL * np.median(np.abs(left), axis=0) / np.sqrt(comb(2 * DIFFERENCES, DIFFERENCES))


def rounding_step(places: np.ndarray) -> float:
    """Step to which values are rounded, by the gaps between them, in their unit; 0 where none shows."""
    values = np.unique(places[:ENOUGH])
    size = float(np.abs(values).max(initial=0.0))
    gaps = np.diff(values)
    gaps = gaps[gaps > ROUND_OFF * size]
    if gaps.size == 0:
        return 0.0
    step = float(gaps.min())
    counts = gaps / step
    return step if np.all(np.abs(counts - np.round(counts)) < WHOLE) else 0.0
