"""Profiles: how far surfaces fall off from a straight generator, along the axis."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing
from lagrange.limits import exceeds

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
