"""The cage as a rigid body in the plane: a fact of the bearing, beside its rings and rollers."""

from dataclasses import dataclass
from math import inf, pi, sin
from typing import Literal

from lagrange.bearing import Bearing

Guidance = Literal["rollers", "inner_ring", "outer_ring"]


@dataclass(frozen=True, kw_only=True)
class Cage:
    """A rigid ring with one pocket for each roller, equally spaced; SI.

    Guided by rollers it has round pockets, which hold them along the radius too. Guided by a ring its pockets have flat
    walls across the pitch circle, and its bore meets the inner ring, or its outside the outer one, at the radius of
    that ring's raceway.
    """

    mass: float
    inertia: float  # kg m², about its centre
    pocket_clearance: float  # m, on both sides of a roller together
    guidance: Guidance
    guidance_clearance: float | None  # m, of diameters; None: rollers guide it
    stiffness: float  # N/m, of every contact of the cage
    damping: float  # N s/m, of every closed contact; never makes one pull
    friction_coefficient: float
    drag_torque: float  # N m, against the cage's rotation


def thin_ring_inertia(bearing: Bearing, mass: float) -> float:
    """Of a ring with all its mass on the pitch circle, kg m²."""
    return mass * bearing.pitch_radius**2


def room_between_rollers(bearing: Bearing) -> float:
    """Between the surfaces of neighbouring rollers on the pitch circle, m; infinite for a single one."""
    if bearing.n_rollers == 1:
        return inf
    return 2.0 * (bearing.pitch_radius * sin(pi / bearing.n_rollers) - bearing.roller_radius)
