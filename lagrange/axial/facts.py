"""What a scene says of the third dimension."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lagrange.axial.profile import Profile
from lagrange.bearing import Bearing


@dataclass(frozen=True, kw_only=True)
class Axial:
    """Rollers, raceways and shaft along the axis. SI."""

    roller: Profile
    inner_raceway: Profile
    outer_raceway: Profile
    slices: int  # of a roller, equally wide
    coupling: bool  # whether neighbouring slices know each other
    ring_width: float  # m, of both rings
    skew: Literal["guided", "free"]
    hub_tilt_inertia: float | None = None  # kg m², about an axis across the shaft's; None: its slope is prescribed
    shaft_tilt_stiffness: float = 0.0  # N m/rad, of the shaft, against its slope

    @property
    def has_free_slope(self) -> bool:
        """Whether the hub's slope moves, and is not prescribed."""
        return self.hub_tilt_inertia is not None

    def centres(self, bearing: Bearing) -> np.ndarray:
        """z of the slices' middles from the roller's middle, (slices,), m."""
        return (np.arange(self.slices) + 0.5 - 0.5 * self.slices) * bearing.roller_length / self.slices

    def drops(self, bearing: Bearing) -> np.ndarray:
        """Drop of roller and raceway together at the slices' middles, inner and outer contact, (2, slices), m."""
        z = self.centres(bearing)
        return np.stack([self.roller.drop(z, bearing) + p.drop(z, bearing)
                         for p in (self.inner_raceway, self.outer_raceway)])  # fmt: skip
