"""What a scene says of the third dimension: profiles, how far surfaces fall off along the axis, slices, the shaft."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing
from lagrange.errors import ROUND_OFF, exceeds
from lagrange.surface.faults import Spall

Kind = Literal["none", "logarithmic", "crowned", "lundberg", "measured"]
LONG = 2.5  # L_we/D_we beyond which the middle of the standard's profile is straight


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Drop of one surface along the roller's length, from its middle. SI."""

    kind: Kind = "none"
    crown: float = 0.0  # m, drop of "crowned" at the roller's ends
    load: float = 0.0  # N, for which a "lundberg" profile makes the pressure even
    place: tuple[float, ...] = ()  # m from the middle, of "measured", rising
    depth: tuple[float, ...] = ()  # m, there

    def drop(self, z, bearing: Bearing) -> np.ndarray:
        """P(z), m, >= 0, shape of z; infinite at the ends of logarithmic profiles.

        Parameters
        ----------
        z : m, from the roller's middle

        Source: ISO/TS 16281:2008 (42) to (44); Lundberg 1939, P = Q/(π E* L) ln[1/(1 − (2z/L)²)].
        """
        z = np.asarray(z, dtype=float)
        length = bearing.roller_length
        if self.kind == "logarithmic":
            return logarithmic_drop(z, length, 2.0 * bearing.roller_radius)
        if self.kind == "crowned":
            return self.crown * (2.0 * z / length) ** 2
        if self.kind == "lundberg":
            return self.load * _even_drop(bearing) * _falling(2.0 * z / length)
        if self.kind == "measured":
            return np.interp(z, self.place, self.depth)
        return np.zeros(z.shape)

    @property
    def knees(self) -> np.ndarray:
        """Where a measured profile bends outwards, m, and by how much, rad, (2, n)."""
        bend = np.diff(np.diff(self.depth) / np.diff(self.place))
        return np.array([self.place[1:-1], bend])[:, bend > 0.0] if self.place else np.zeros((2, 0))

    def even_load(self, bearing: Bearing) -> float:
        """Of a roller, N, whose pressure is even up to the ends; 0 of profiles without a logarithm."""
        if self.kind == "logarithmic":
            near = 1e-9  # of half the length, from the end
            drop = self.drop(0.5 * bearing.roller_length * (1.0 - near * np.array([1.0, np.e])), bearing)
            return float(drop[0] - drop[1]) / _even_drop(bearing)
        return self.load if self.kind == "lundberg" else 0.0


def _even_drop(bearing: Bearing) -> float:
    """1/(π E* L), m/N: of Lundberg's profile, by its load."""
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / bearing.inner_ring.plane_strain_modulus
    return compliance / (np.pi * bearing.roller_length)


def logarithmic_drop(x, length: float, diameter: float) -> np.ndarray:
    """P(x) of the standard's logarithmic profile, in the unit of x, length and diameter.

    Source: ISO/TS 16281:2008 (42), of long rollers (43), (44).
    """
    x = np.asarray(x, dtype=float)
    if not exceeds(length, LONG * diameter):
        return 0.00035 * diameter * _falling(2.0 * x / length)
    straight = length - LONG * diameter
    return 0.0005 * diameter * _falling(np.maximum(2.0 * np.abs(x) - straight, 0.0) / (LONG * diameter))


def _falling(share: np.ndarray) -> np.ndarray:
    """ln[1/(1 − s²)]; infinite from s = 1 on."""
    with np.errstate(divide="ignore"):
        return -np.log(np.maximum(1.0 - share**2, 0.0))


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
        raceways = self.inner_raceway, self.outer_raceway
        return np.stack([self.roller.drop(z, bearing) + raceway.drop(z, bearing) for raceway in raceways])

    def parts(self, bearing: Bearing) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Which slices spalls of part of the length let sink, inner and outer contact, (slices,) each; None: no such.

        A spall takes the slices whose middles it goes over. All that one raceway's contacts meet take the same.
        """
        spalls = [fault for fault in bearing.faults if isinstance(fault, Spall) and fault.is_part(bearing)]

        def part(ring: str) -> np.ndarray | None:
            found = (slices_over(bearing, self.slices, each) for each in spalls if each.body in (ring, "roller"))
            return next(found, None)

        return part("inner_ring"), part("outer_ring")


def centres(length: float, slices: int) -> np.ndarray:
    """z of the middles of equal slices of a length from its middle, (slices,)."""
    return (np.arange(slices) + 0.5 - 0.5 * slices) * length / slices


def slices_over(bearing: Bearing, slices: int, spall: Spall) -> np.ndarray:
    """Which slices of a roller have their middles over a spall, (slices,)."""
    z, (first, last) = centres(bearing.roller_length, slices), spall.along or (-np.inf, np.inf)
    near = ROUND_OFF * bearing.roller_length
    return (z >= first - near) & (z <= last + near)
