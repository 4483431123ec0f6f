"""Load ratings: ISO 281 dynamic, ISO 76 static, fatigue load limit. mm and N."""

from dataclasses import dataclass

from lagrange.bearing import BallBearing, Bearing
from lagrange.contact.raceway_laws import STEEL
from lagrange.rating.sources import Unavailable

OF_CAGED = 1.1  # b_m of cylindrical, tapered and machined needle roller bearings, ISO 281 table 6
REDUCTION = 0.83  # λ, of radial roller bearings: pressures along real contact lines are uneven
MEDIUM = 100.0  # mm, D_pw beyond which the fatigue load limit falls


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """Of rows of rollers, by the standards' letters; mm."""

    rollers: int  # Z
    diameter: float  # D_we
    length: float  # L_we
    pitch: float  # D_pw
    cosine: float = 1.0  # cos α
    rows: int = 1  # i

    @property
    def gamma(self) -> float:
        """γ = D_we cos α/D_pw."""
        return self.diameter * self.cosine / self.pitch

    @classmethod
    def of(cls, bearing: Bearing) -> "Dimensions":
        """Of a bearing. Unavailable: it has balls, or is not of steel."""
        if isinstance(bearing, BallBearing):
            raise Unavailable("ratings are those of roller bearings; this one has balls")
        for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring):
            if not STEEL[0] <= material.youngs_modulus <= STEEL[1]:
                raise Unavailable(
                    f"ratings are those of bearing steel; a body has {1e-9 * material.youngs_modulus:.4g} GPa"
                )
        return cls(
            rollers=bearing.n_rollers,
            diameter=2e3 * bearing.element_radius,
            length=1e3 * bearing.roller_length,
            pitch=2e3 * bearing.pitch_radius,
            cosine=bearing.cosine,
            rows=bearing.rows,
        )


def capacity_factor(gamma: float) -> float:
    """f_c of ISO 281 for radial roller bearings, N and mm.

    f_c = 0.483 B1 · 0.377 λ · γ^(2/9) (1 − γ)^(29/27)/(1 + γ)^(1/4) · {1 + X^(9/2)}^(−2/9),
    X = 1.04 ((1 − γ)/(1 + γ))^(143/108)

    Source: ISO/TR 1281-1, formula 34; 0.483 B1 = 551.13373 N.
    """
    ratio = (1.0 - gamma) / (1.0 + gamma)
    geometry = gamma ** (2 / 9) * (1.0 - gamma) ** (29 / 27) / (1.0 + gamma) ** 0.25
    return 551.13373 * 0.377 * REDUCTION * geometry * (1.0 + (1.04 * ratio ** (143 / 108)) ** 4.5) ** (-2 / 9)


def dynamic_capacity(row: Dimensions) -> float:
    """C_r of ISO 281, N: the load with a basic rating life of a million revolutions."""
    size = (row.rows * row.length * row.cosine) ** (7 / 9) * row.rollers**0.75 * row.diameter ** (29 / 27)
    return OF_CAGED * capacity_factor(row.gamma) * size


def static_capacity(row: Dimensions) -> float:
    """C_0r of ISO 76, N: the largest contact stress is then 4000 MPa."""
    return 44.0 * (1.0 - row.gamma) * row.rows * row.rollers * row.length * row.diameter * row.cosine


def fatigue_load_limit(row: Dimensions) -> float:
    """C_u of ISO 281 annex B, simplified, N."""
    return static_capacity(row) / 8.2 * min(1.0, (MEDIUM / row.pitch) ** 0.3)
