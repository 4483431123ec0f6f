"""How a picture, or every frame of a film, is drawn: what is asked for, and the scales that follow from the run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fem.pictures.bodies import body_motions
from fem.pictures.recover import StoredRun
from fem.pictures.scale import Field, Scale, rounded_down
from fem.pictures.stress_below import LARGEST_SHEAR
from lagrange import Bearing
from lagrange.errors import UsageError

LARGEST_SHARE = 0.03  # of the outside radius: the largest displacement as drawn
STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)  # round magnifications, times a power of ten
LARGEST_MAGNIFICATION = 1e4  # beyond, nanometres would be shown as if they mattered
LOOKED_AT = 5  # frames of an animation that decide its magnification
LONGEST_ARROW = 0.85  # of a roller's radius
MOST_ORBIT_POINTS = 4000
LARGEST_MISES = 0.56  # of p₀, under a line contact in plane strain with ν = 0.3


@dataclass(frozen=True, kw_only=True)
class Request:
    """What a user wants to see; None: chosen and stated in the picture."""

    view: Literal["bearing", "close-up"] = "bearing"
    field: Field | None = None
    magnification: float | None = None
    roller: int | None = None  # of a close-up
    width: int = 1600  # pixels


@dataclass(frozen=True, kw_only=True)
class Look:
    """Everything that does not change from frame to frame."""

    scale: Scale
    contact_scale: Scale  # of a close-up's contacts
    magnification: float
    largest_force: float  # N
    arrow_length: float  # outside radii per N
    orbit: np.ndarray | None  # (n, 2), µm, of the hub; None: it does not move
    load_zone: tuple[float, float] | None  # rad
    roller: int  # of a close-up
    half_width: float  # m, of the widest contact
    pace: str  # how fast an animation shows the run; "" in a picture


def chosen_look(run: StoredRun, request: Request, samples: Sequence[int], pace: str = "") -> Look:
    """Scales that fit all the samples.

    Errors
    ------
    UsageError: no such roller.
    """
    forces = run.contact_forces(samples)
    largest = float(forces.max())
    some = np.unique(np.linspace(0, len(samples) - 1, LOOKED_AT).round().astype(int))
    motions = (motion for k in some for motion in body_motions(run.instant(samples[k])))
    displacement = max(float(np.hypot(*motion.T).max()) for motion in motions)
    model = run.model
    half_width = max(law.pair.half_width(max(largest, 1e-3)) for law in (model.inner_law, model.outer_law))
    scale, contact_scale = _scales(request, run, largest, displacement)
    magnification = request.magnification
    if magnification is None:
        outside = model.bearing.outside_radius
        magnification = 1.0 if request.view == "close-up" else chosen_magnification(displacement, outside)
    orbit = 1e6 * run.orbit[:: max(1, len(run.orbit) // MOST_ORBIT_POINTS)]
    return Look(
        scale=scale,
        contact_scale=contact_scale,
        magnification=magnification,
        largest_force=largest,
        arrow_length=_arrow_length(model.bearing, largest),
        orbit=orbit if np.ptp(orbit, axis=0).max() > 0.0 else None,
        load_zone=run.load_zone,
        roller=_roller(request, forces),
        half_width=half_width,
        pace=pace,
    )


def _roller(request: Request, forces: np.ndarray) -> int:
    n = forces.shape[-1]
    if request.roller is None:
        return int(np.argmax(forces[:, 0].max(axis=0)))
    if not 0 <= request.roller < n:
        raise UsageError(f"--roller {request.roller}: the run has rollers 0 to {n - 1}")
    return request.roller


def _scales(request: Request, run: StoredRun, force: float, displacement: float) -> tuple[Scale, Scale]:
    """Scales of the picture and of a close-up's contacts."""
    field = request.field or ("max-shear" if request.view == "close-up" else "von-mises")
    if field == "displacement":
        return (Scale(field=field, largest=displacement, logarithmic=False),) * 2
    pressure = max(law.pair.peak_pressure(max(force, 1e-3)) for law in (run.model.inner_law, run.model.outer_law))
    largest = pressure * (LARGEST_MISES if field == "von-mises" else LARGEST_SHEAR)
    of_body, of_contacts = (Scale(field=field, largest=largest, logarithmic=each) for each in (True, False))
    return of_body, of_contacts


def _arrow_length(bearing: Bearing, largest: float) -> float:
    return LONGEST_ARROW * bearing.roller_radius / bearing.outside_radius / largest if largest > 0.0 else 0.0


def chosen_magnification(largest: float, outside_radius: float) -> float:
    """A round factor, at least 1, that draws the largest displacement, m, LARGEST_SHARE of the radius or less."""
    if largest <= 0.0:
        return 1.0
    wanted = min(max(1.0, LARGEST_SHARE * outside_radius / largest), LARGEST_MAGNIFICATION)
    return rounded_down(wanted, STEPS)
