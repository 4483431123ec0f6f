"""How a picture, or every frame of a film, is drawn: what is asked for, and the scales that follow from the run."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, MaxNLocator

from fem.pictures.bodies import DrawnBearing, body_motions, rounded_down
from fem.pictures.recover import StoredRun
from fem.pictures.stress_below import LARGEST_SHEAR
from lagrange.errors import UsageError

LARGEST_SHARE = 0.03  # of the outside radius: the largest displacement as drawn
STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)  # round magnifications, times a power of ten
LARGEST_MAGNIFICATION = 1e4  # beyond, nanometres would be shown as if they mattered
LOOKED_AT = 5  # frames of an animation that decide its magnification
LONGEST_ARROW = 0.85  # of a roller's radius
MOST_ORBIT_POINTS = 4000
LARGEST_MISES = 0.56  # of p₀, under a line contact in plane strain with ν = 0.3
Field = Literal["von-mises", "max-shear", "displacement"]
FIELDS = {  # title, unit, its size in SI, colours, fit for colour-blind eyes
    "von-mises": ("Von Mises stress", "MPa", 1e6, "viridis"),
    "max-shear": ("Max. shear stress", "MPa", 1e6, "viridis"),
    "displacement": ("Displacement", "µm", 1e-6, "cividis"),
}
FAINTEST = 1.0 / 500.0  # of the end of a logarithmic scale
ROUND = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10])  # intervals of a linear scale
ROUND_TIMES = LogLocator(subs=(1.0, 2.0, 5.0))


class Scale:
    """From a quantity in its unit to colours, up to a round number that is not below `largest`, Pa or m."""

    def __init__(self, field: Field, largest: float, logarithmic: bool):
        self.field = field
        self.title, self.unit, self._size, self.colours = FIELDS[field]
        self.end = float(ROUND.tick_values(0.0, largest / self._size or 1.0)[-1])  # in its unit
        self.limits = (FAINTEST * self.end if logarithmic else 0.0), self.end
        norm, self._locator = (LogNorm, ROUND_TIMES) if logarithmic else (Normalize, ROUND)
        self.norm = norm(*self.limits)

    def ticks(self) -> list[tuple[float, str]]:
        """Share of the bar's length and label."""
        ticks = self._locator.tick_values(*self.limits)
        shares = self.norm(np.maximum(ticks, 1e-3 * self.limits[0]))
        inside = (ticks >= 0.0) & (shares > -1e-9) & (shares < 1.0 + 1e-9)
        return [(float(share), f"{tick:.4g}") for share, tick in zip(shares[inside], ticks[inside], strict=True)]

    def values(self, drawn: DrawnBearing) -> np.ndarray:
        """The nodes' values in the scale's unit, above 0."""
        return np.maximum(drawn.quantity(self.field) / self._size, 1e-3 * FAINTEST * self.end)


class Request(NamedTuple):
    """What a user wants to see; None: chosen and stated in the picture."""

    view: Literal["bearing", "close-up"] = "bearing"
    field: Field | None = None
    magnification: float | None = None
    roller: int | None = None  # of a close-up
    width: int = 1600  # pixels


class Look(NamedTuple):
    """Everything that does not change from frame to frame."""

    scale: Scale
    contact_scale: Scale  # of a close-up's contacts
    magnification: float
    largest_force: float  # N
    arrow_length: float  # m of the bearing per N
    orbit: np.ndarray | None  # (n, 2), µm, of the hub; None: it does not move
    load_zone: tuple[float, float] | None  # rad
    roller: int  # of a close-up
    half_width: float  # m, of the widest contact
    pace: str  # how fast an animation shows the run; "" in a picture


def chosen_look(run: StoredRun, request: Request, samples: Sequence[int], pace: str = "") -> Look:
    """Scales that fit all the samples. UsageError: no such roller."""
    forces, model, roller = run.contact_forces(samples), run.model, request.roller
    largest, n = float(forces.max()), forces.shape[-1]
    if roller is not None and not 0 <= roller < n:
        raise UsageError(f"--roller {roller}: the run has rollers 0 to {n - 1}")
    some = np.unique(np.linspace(0, len(samples) - 1, LOOKED_AT).round().astype(int))
    motions = (motion for k in some for motion in body_motions(run.instant(samples[k])))
    displacement = max(float(np.hypot(*motion.T).max()) for motion in motions)
    pairs, pressing = (model.inner_law.pair, model.outer_law.pair), max(largest, 1e-3)
    closeup = request.view == "close-up"
    field = request.field or ("max-shear" if closeup else "von-mises")
    if field == "displacement":
        scales = (Scale(field, displacement, logarithmic=False),) * 2
    else:
        share = LARGEST_MISES if field == "von-mises" else LARGEST_SHEAR
        most = share * max(pair.peak_pressure(pressing) for pair in pairs)
        scales = Scale(field, most, logarithmic=True), Scale(field, most, logarithmic=False)
    magnification = request.magnification
    if magnification is None:
        magnification = 1.0 if closeup else chosen_magnification(displacement, model.bearing.outside_radius)
    orbit = 1e6 * run.orbit[:: max(1, len(run.orbit) // MOST_ORBIT_POINTS)]
    return Look(
        scale=scales[0], contact_scale=scales[1], magnification=magnification, largest_force=largest,
        arrow_length=LONGEST_ARROW * model.bearing.roller_radius / largest if largest > 0.0 else 0.0,
        orbit=orbit if np.ptp(orbit, axis=0).max() > 0.0 else None, load_zone=run.load_zone,
        roller=int(np.argmax(forces[:, 0].max(axis=0))) if roller is None else roller,
        half_width=max(pair.half_width(pressing) for pair in pairs), pace=pace,
    )  # fmt: skip


def chosen_magnification(largest: float, outside_radius: float) -> float:
    """A round factor, at least 1, that draws the largest displacement, m, LARGEST_SHARE of the radius or less."""
    if largest <= 0.0:
        return 1.0
    wanted = min(max(1.0, LARGEST_SHARE * outside_radius / largest), LARGEST_MAGNIFICATION)
    return rounded_down(wanted, STEPS)
