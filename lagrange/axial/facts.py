"""What a scene says of the third dimension."""

from dataclasses import dataclass

import numpy as np

from lagrange.axial.profile import Profile
from lagrange.bearing import Bearing
from lagrange.limits import ROUND_OFF
from lagrange.surface.faults import Spall


@dataclass(frozen=True, kw_only=True)
class Axial:
    """Rollers, raceways and shaft along the axis. SI."""

    roller: Profile
    inner_raceway: Profile
    outer_raceway: Profile
    slices: int  # of a roller, equally wide
    coupling: bool  # whether neighbouring slices know each other
    ring_width: float  # m, of both rings
    hub_tilt_inertia: float | None = None  # kg m², about an axis across the shaft's; None: its slope is prescribed
    shaft_tilt_stiffness: float = 0.0  # N m/rad, of the shaft, against its slope

    @property
    def has_free_slope(self) -> bool:
        """Whether the hub's slope moves, and is not prescribed."""
        return self.hub_tilt_inertia is not None

    def centres(self, bearing: Bearing) -> np.ndarray:
        """z of the slices' middles from the roller's middle, (slices,), m."""
        return centres(bearing.roller_length, self.slices)

    def drops(self, bearing: Bearing) -> np.ndarray:
        """Drop of roller and raceway together at the slices' middles, inner and outer contact, (2, slices), m."""
        z = self.centres(bearing)
        return np.stack([self.roller.drop(z, bearing) + p.drop(z, bearing)
                         for p in (self.inner_raceway, self.outer_raceway)])  # fmt: skip

    def parts(self, bearing: Bearing) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Which slices spalls of part of the length let sink, inner and outer contact, (slices,) each; None: no such.

        A spall takes the slices whose middles it goes over. All that one raceway's contacts meet take the same.
        """
        inner, outer = (self._part(bearing, {ring, "roller"}) for ring in ("inner_ring", "outer_ring"))
        return inner, outer

    def _part(self, bearing: Bearing, bodies: set[str]) -> np.ndarray | None:
        for fault in bearing.faults:
            if isinstance(fault, Spall) and fault.is_part(bearing) and fault.body in bodies:
                return slices_over(bearing, self.slices, fault)
        return None


def centres(length: float, slices: int) -> np.ndarray:
    """z of the middles of equal slices of a length from its middle, (slices,)."""
    return (np.arange(slices) + 0.5 - 0.5 * slices) * length / slices


def slices_over(bearing: Bearing, slices: int, spall: Spall) -> np.ndarray:
    """Which slices of a roller have their middles over a spall, (slices,)."""
    z, (first, last) = centres(bearing.roller_length, slices), spall.along or (-np.inf, np.inf)
    near = ROUND_OFF * bearing.roller_length
    return (z >= first - near) & (z <= last + near)
