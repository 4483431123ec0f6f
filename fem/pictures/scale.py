"""What a picture's colours mean: the quantity, its colour map, its scale and the ticks beside it."""

from dataclasses import dataclass
from math import ceil, floor, log10
from typing import Literal

import numpy as np

from fem.elastic.stress import max_shear, von_mises
from fem.pictures.bodies import DrawnBearing

Field = Literal["von-mises", "max-shear", "displacement"]
TITLES = {
    "von-mises": ("Von Mises stress", "MPa"),
    "max-shear": ("Max. shear stress", "MPa"),
    "displacement": ("Displacement", "µm"),
}
COLOURS = {"von-mises": "viridis", "max-shear": "viridis", "displacement": "cividis"}  # fit for colour-blind eyes
ROUND_ENDS = (1.0, 1.2, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
ROUND = (1.0, 2.0, 5.0, 10.0)
FAINTEST = 1.0 / 500.0  # of the end of a logarithmic scale


@dataclass(frozen=True, kw_only=True)
class Scale:
    """From a quantity in its unit to colours."""

    field: Field
    colours: str
    end: float  # MPa or µm
    unit: float  # Pa or m per one of the scale
    logarithmic: bool = False

    @property
    def title(self) -> str:
        return TITLES[self.field][0]

    @property
    def unit_name(self) -> str:
        return TITLES[self.field][1]

    @property
    def limits(self) -> tuple[float, float]:
        """Values at the colour map's ends."""
        return (log10(FAINTEST * self.end), log10(self.end)) if self.logarithmic else (0.0, self.end)

    def values(self, drawn: DrawnBearing) -> np.ndarray:
        """The nodes' values, to be coloured between `limits`."""
        found = quantity(self.field, drawn) / self.unit
        return np.log10(np.maximum(found, 1e-3 * FAINTEST * self.end)) if self.logarithmic else found

    def ticks(self) -> list[tuple[float, str]]:
        """Share of the bar's length and label."""
        if self.logarithmic:
            low, high = self.limits
            decades = range(ceil(low - 1e-9), floor(high) + 1)
            values = [f * 10.0**k for k in (ceil(low) - 1, *decades) for f in (1.0, 2.0, 5.0)]
            return [
                ((log10(v) - low) / (high - low), f"{v:.4g}") for v in values if low - 1e-9 <= log10(v) <= high + 1e-9
            ]
        n = _intervals(self.end)
        return [(k / n, f"{k / n * self.end:.4g}") for k in range(n + 1)]


def quantity(field: Field, drawn: DrawnBearing) -> np.ndarray:
    """Nodal values, Pa or m."""
    if field == "displacement":
        return np.hypot(*drawn.motion.T)
    stress = drawn.stress()
    return von_mises(stress, drawn.poisson_ratio) if field == "von-mises" else max_shear(stress)


def linear_scale(field: Field, end: float) -> Scale:
    """From 0 to a round number not below `end`, Pa or m."""
    unit = 1e-6 if field == "displacement" else 1e6
    return Scale(field=field, colours=COLOURS[field], end=rounded_up(end / unit), unit=unit)


def logarithmic_scale(field: Field, end: float) -> Scale:
    """Up to a round number not below `end`, Pa."""
    return Scale(field=field, colours=COLOURS[field], end=rounded_up(1e-6 * end), unit=1e6, logarithmic=True)


def rounded_up(value: float) -> float:
    """A round number not below a value; 1 for 0."""
    if value <= 0.0:
        return 1.0
    decade = 10.0 ** floor(log10(value))
    return decade * min(end for end in ROUND_ENDS if end * decade >= value * (1.0 - 1e-12))


def rounded_down(value: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above a value > 0."""
    decade = 10.0 ** floor(log10(value))
    return decade * max(step for step in ROUND if step * decade <= value * (1.0 + 1e-12))


def _intervals(limit: float) -> int:
    """How many round intervals the scale is divided into."""
    for count in (5, 4, 3):
        step = limit / count
        if round(step / 10.0 ** floor(log10(step) + 1e-9), 6) in (1.0, 2.0, 3.0, 4.0, 5.0):
            return count
    return 4
