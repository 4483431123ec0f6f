"""What a picture's colours mean: the quantity, its colour map, its scale and the ticks beside it."""

from dataclasses import dataclass
from math import floor, log10
from typing import Literal

import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator

from fem.elastic.bodies import max_shear, von_mises
from fem.pictures.bodies import DrawnBearing

Field = Literal["von-mises", "max-shear", "displacement"]
FIELDS = {  # title, unit, its size in SI, colours, fit for colour-blind eyes
    "von-mises": ("Von Mises stress", "MPa", 1e6, "viridis"),
    "max-shear": ("Max. shear stress", "MPa", 1e6, "viridis"),
    "displacement": ("Displacement", "µm", 1e-6, "cividis"),
}
FAINTEST = 1.0 / 500.0  # of the end of a logarithmic scale
ROUND = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10])  # intervals of a linear scale
ROUND_TIMES = LogLocator(subs=(1.0, 2.0, 5.0))


@dataclass(frozen=True, kw_only=True)
class Scale:
    """From a quantity in its unit to colours, up to a round number."""

    field: Field
    largest: float  # Pa or m, that must be on it
    logarithmic: bool

    @property
    def title(self) -> str:
        return FIELDS[self.field][0]

    @property
    def unit(self) -> str:
        return FIELDS[self.field][1]

    @property
    def colours(self) -> str:
        return FIELDS[self.field][3]

    @property
    def end(self) -> float:
        """In its unit."""
        return float(ROUND.tick_values(0.0, self.largest / FIELDS[self.field][2] or 1.0)[-1])

    @property
    def limits(self) -> tuple[float, float]:
        """Values at the colour map's ends."""
        return (log10(FAINTEST * self.end), log10(self.end)) if self.logarithmic else (0.0, self.end)

    def values(self, drawn: DrawnBearing) -> np.ndarray:
        """The nodes' values, to be coloured between `limits`."""
        found = quantity(self.field, drawn) / FIELDS[self.field][2]
        return np.log10(np.maximum(found, 1e-3 * FAINTEST * self.end)) if self.logarithmic else found

    def ticks(self) -> list[tuple[float, str]]:
        """Share of the bar's length and label."""
        low, high = self.limits
        if self.logarithmic:
            values = ROUND_TIMES.tick_values(FAINTEST * self.end, self.end)
            places = np.log10(values)
        else:
            places = values = ROUND.tick_values(0.0, self.end)
        shares = (places - low) / (high - low)
        inside = (shares > -1e-9) & (shares < 1.0 + 1e-9)
        return [(share, f"{value:.4g}") for share, value in zip(shares[inside], values[inside], strict=True)]


def quantity(field: Field, drawn: DrawnBearing) -> np.ndarray:
    """Nodal values, Pa or m."""
    if field == "displacement":
        return np.hypot(*drawn.motion.T)
    stress = drawn.stress()
    return von_mises(stress, drawn.poisson_ratio) if field == "von-mises" else max_shear(stress)


def rounded_down(value: float, steps: tuple[float, ...] = (1.0, 2.0, 5.0, 10.0)) -> float:
    """The largest step times a power of ten that is not above a value > 0."""
    decade = 10.0 ** floor(log10(value))
    return decade * max(step for step in steps if step * decade <= value * (1.0 + 1e-12))
