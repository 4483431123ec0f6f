"""What makes the surfaces of a bearing imperfect: spalls, waviness, unequal rollers, measured heights. Facts, SI.

Angles of rings are counter-clockwise from +x at t = 0 and turn with the ring; those of a roller are in its own frame,
whose axes are the fixed ones at t = 0. `roller` is a roller's number, None on a ring.
"""

import json
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from math import sqrt
from typing import Literal, NamedTuple

import numpy as np

from lagrange.errors import exceeds
from lagrange.files.tables import rising

ANGLE, HEIGHT = "angle_deg", "height_um"
FEWEST_POINTS = 16
FULL_TURN = 360.0
AGAIN = 1e-6  # degrees, µm: two values that are the same
LARGEST_GAP = 3.0  # times the usual distance of two angles


class HeightTable(NamedTuple):
    """Heights around one turn; arrays (n_points,)."""

    angle: np.ndarray  # rad, rising, less than a turn from first to last
    height: np.ndarray  # m, positive where material is added


@lru_cache(maxsize=16)
def height_table(text: str, decimal: str = ".") -> HeightTable:
    """The heights of a table's text with this decimal sign.

    ValueError, a sentence on the text: columns missing or twice, a row that can't be read, too few or too many
    points, angles that do not rise, more than a turn, a gap, also at the seam, or two heights there.
    """
    angle, height = rising(text, (ANGLE, HEIGHT), decimal, FEWEST_POINTS).T
    steps = np.diff(angle)
    seam = FULL_TURN - (angle[-1] - angle[0])
    if abs(seam) <= AGAIN:
        if abs(height[-1] - height[0]) > AGAIN:
            raise ValueError(
                f"it does not close: {HEIGHT} is {height[0]:g} at {angle[0]:g} degrees and {height[-1]:g} a turn on"
            )
        angle, height, steps = angle[:-1], height[:-1], steps[:-1]
        seam = FULL_TURN - (angle[-1] - angle[0])
    if seam <= 0.0:
        raise ValueError(f"{ANGLE} goes from {angle[0]:g} to {angle[-1]:g}, more than a turn")
    gaps, usual = np.append(steps, seam), float(np.median(steps))
    if gaps.max() > LARGEST_GAP * usual:
        at = int(gaps.argmax())
        where = "at the seam, " if at == len(steps) else ""
        raise ValueError(
            f"a gap of {gaps[at]:.4g} degrees {where}after {angle[at]:g}, where points are usually {usual:.4g} apart "
            f"(at most {LARGEST_GAP:g} times that)"
        )
    return HeightTable(angle=np.radians(angle), height=1e-6 * height)


Body = Literal["outer_ring", "inner_ring", "roller"]


@dataclass(frozen=True, kw_only=True)
class Spall:
    """A hole in a surface, with a flat bottom and rounded edges."""

    body: Body
    roller: int | None
    angle: float  # rad, of its middle
    width: float  # m, from edge to edge, of the sharp-edged gap into which a roller sinks as deeply
    depth: float  # m
    edge_radius: float  # m, 0: sharp
    along: tuple[float, float] | None = None  # m, from and to which z along a roller that may tilt; None: all of it

    def is_part(self, bearing) -> bool:
        """Whether it takes a part of the rollers' length."""
        half = 0.5 * bearing.roller_length
        return self.along is not None and bool(exceeds(half, -self.along[0]) or exceeds(half, self.along[1]))

    def half_opening(self, roller_radius: float) -> float:
        """From the middle to where the surface leaves its circle, m.

        A roller of radius r turns about a rounded edge's centre at the distance r + e. It sinks by c²/(2(r + e)) where
        between sharp edges it does by (w/2)²/(2r): c = w/2 √(1 + e/r). With the raceways' own curvature the two
        agree to 0.6 % for e = 0.02 r.
        """
        return 0.5 * self.width * sqrt(1.0 + self.edge_radius / roller_radius)


@dataclass(frozen=True, kw_only=True)
class Waviness:
    """Crests and valleys around a body: amplitude · cos(order · angle + phase), positive where material is added."""

    body: Body
    roller: int | None
    order: int
    amplitude: float  # m
    phase: float  # rad


@dataclass(frozen=True, kw_only=True)
class UnequalRoller:
    """A roller larger than the others, in its contacts with both raceways."""

    roller: int
    diameter_deviation: float  # m

    body: Body = "roller"


@dataclass(frozen=True, kw_only=True)
class MeasuredSurface:
    """Heights around a body as they were measured."""

    body: Body
    roller: int | None
    angle: float  # rad, of the table's angle 0
    file: str
    sha256: str  # of the table's text: tables are known by it
    table: HeightTable = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Film:
    """A lubricant's film on a raceway, as thick everywhere: no fault, but surfaces meet that much earlier."""

    body: Body
    thickness: float  # m

    roller: None = None


Fault = Spall | Waviness | UnequalRoller | MeasuredSurface | Film


def labels(faults: tuple[Fault, ...]) -> str:
    """The faults as JSON, a list of objects: `kind`, and what the class of that name holds but for tables, SI."""
    kinds = {Spall: "spall", Waviness: "waviness", UnequalRoller: "unequal_roller", MeasuredSurface: "profile"}
    facts = [{"kind": kinds[type(fault)]} | asdict(fault) for fault in faults if not isinstance(fault, Film)]
    return json.dumps([{name: value for name, value in fact.items() if name != "table"} for fact in facts])


def own_radius(bearing, fault) -> float:
    """Radius of the circle of a bearing that a fault, or a table of one, is in, m."""
    radii = {"inner_ring": bearing.inner_raceway_radius, "outer_ring": bearing.outer_raceway_radius}
    return radii.get(fault.body, bearing.roller_radius)


def thickness(bearing, body: Body) -> float:
    """Of a body under its surface, m: of a ring, or a roller's radius."""
    rings = {"inner_ring": bearing.inner_raceway_radius - bearing.bore_radius,
        "outer_ring": bearing.outside_radius - bearing.outer_raceway_radius}  # fmt: skip
    return rings.get(body, bearing.roller_radius)
