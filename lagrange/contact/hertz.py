"""Hertz's contacts of a bearing: lines between rollers and raceways, ellipses of balls in grooves, stresses below.

The point contact is that of equations (4) to (11) of the paper for any material; the constants 2.79e-4 and 2.15e5 that
Harris and the paper print (N, mm) belong to E = 207 GPa, ν = 0.3 on both sides.

Source: Hertz 1881; Johnson, Contact Mechanics (1985), chapter 4; Harris, Rolling Bearing Analysis.
"""

from collections.abc import Mapping
from math import exp, pi, sqrt
from typing import Literal, NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.bearing import BallBearing, Bearing, Material
from lagrange.columns import DERIVED
from lagrange.rating.sources import Unavailable

Side = Literal["inner", "outer"]
NEARLY_CIRCULAR = 1e-5  # below this F, F = 3 m/8 is more exact than the elliptic integrals' difference
LONGEST_ELLIPSE = 18.0  # ln κ: F = 1 − 1e-14, next to a line contact


def line_compliance(material: Material, length: float) -> float:
    """A = 2/(π E' L) of one body, m/N: factor of ln Q in half its approach; 0 of a rigid one."""
    return 2.0 / (pi * material.plane_strain_modulus * length)


def compliances(bearing: Bearing, side: Side) -> tuple[float, float]:
    """c = (1 − ν²)/E of rolling elements and of a ring, 1/Pa."""
    ring = bearing.inner_ring if side == "inner" else bearing.outer_ring
    return 1.0 / bearing.roller.plane_strain_modulus, 1.0 / ring.plane_strain_modulus


class Pair(NamedTuple):
    """Two bodies that may touch: side 0 is the ring, or roller j; side 1 the roller, or roller j + 1."""

    kind: str  # inner, outer (raceway) or roller
    radii: tuple[float, float]  # m; a bore's is negative
    materials: tuple[Material, Material]
    length: float  # m, of the line of contact
    cosine: float = 1.0  # of the contact angle: circles of a section are that much more curved than bodies

    @property
    def relative_radius(self) -> float:
        """R, m: 1/R is the sum of both curvatures."""
        return 1.0 / sum(self.cosine / radius for radius in self.radii)

    @property
    def modulus(self) -> float:
        """E*, Pa: 1/E* is the sum of both 1/E'."""
        return 1.0 / sum(1.0 / material.plane_strain_modulus for material in self.materials)

    @property
    def line_compliance(self) -> float:
        """A of both bodies, m/N."""
        return sum(line_compliance(material, self.length) for material in self.materials)

    @property
    def half_width_factor(self) -> float:
        """b²/Q = 4R/(π E* L) = 2RA, m²/N."""
        return 2.0 * self.relative_radius * self.line_compliance

    def half_width(self, force: float) -> float:
        """Half-width b, m, of the contact under a force, N."""
        return sqrt(self.half_width_factor * force)

    def peak_pressure(self, force: float) -> float:
        """Largest pressure p₀ = 2 Q/(π b L), Pa, under a force, N."""
        return 2.0 * force / (pi * self.half_width(force) * self.length) if force > 0.0 else 0.0


def contact_pairs(bearing: Bearing) -> tuple[Pair, Pair, Pair]:
    """Inner raceway and roller, outer raceway and roller, two rollers.

    Two rigid rollers meet with their material's compliance: they would have none otherwise.
    """
    r, roller, both = bearing.roller_radius, bearing.roller, bearing.roller.elastic
    sides = (
        ("inner", bearing.inner_raceway_radius, (bearing.inner_ring, roller)),
        ("outer", -bearing.outer_raceway_radius, (bearing.outer_ring, roller)),
        ("roller", r, (both, both)),
    )
    length, cosine = bearing.roller_length, bearing.cosine
    inner, outer, between = (Pair(kind=kind, radii=(radius, r), materials=materials, length=length, cosine=cosine)
        for kind, radius, materials in sides)  # fmt: skip
    return inner, outer, between


class Curvature(NamedTuple):
    """Principal curvatures of two bodies in point contact."""

    sum: float  # Σρ, 1/m: equation (4)
    difference: float  # F(ρ), 0 (circle) to 1 (line): equation (5)


def raceway_curvature(bearing: BallBearing, side: Side) -> Curvature:
    """Curvatures of ball and raceway: equations (6) and (7); of a section's raceway cos α/R, a groove's concave."""
    inner, ball = side == "inner", 1.0 / bearing.element_radius
    along = bearing.cosine / (bearing.inner_raceway_radius if inner else -bearing.outer_raceway_radius)
    across = -1.0 / (bearing.inner_groove_radius if inner else bearing.outer_groove_radius)
    total = ball + ball + along + across
    return Curvature(total, abs(along - across) / total)


def ellipticity(difference: float) -> float:
    """Ratio κ >= 1 of the contact ellipse's axes from the curvature difference F(ρ).

    ValueError: F outside [0, 1). κ to 1e-10 relative (the integrals' difference cancels); below F = 1e-5 a
    series, to 1e-5 of κ − 1.

    Source: Harris, Rolling Bearing Analysis, Hertz's theory: F = [(κ²+1)E − 2K]/[(κ²−1)E], m = 1 − 1/κ².
    """
    from scipy.optimize import brentq

    if not 0.0 <= difference < 1.0:
        raise ValueError(f"curvature difference F = {difference:.6g}: must be at least 0 and below 1 (a line contact)")
    if difference < NEARLY_CIRCULAR:
        return (1.0 - 8.0 / 3.0 * difference) ** -0.5

    def missed(log_ratio):
        p = exp(-2.0 * log_ratio)
        K, E = _elliptic_integrals(p)
        return ((1.0 + p) * E - 2.0 * p * K) / ((1.0 - p) * E) - difference

    low, high = 0.5 * NEARLY_CIRCULAR, LONGEST_ELLIPSE
    return exp(high if missed(high) <= 0.0 else brentq(missed, low, high, xtol=1e-15))


def _elliptic_integrals(p):
    """Complete integrals K and E of m = 1 − p, p = 1/κ²; exact for p near 0 too."""
    from scipy.special import ellipe, ellipkm1  # 0.1 s to import, and only balls need it

    return ellipkm1(p), ellipe(1.0 - p)


def delta_star(difference: float) -> float:
    """Dimensionless approach δ*(F), figure 4 of the paper.

    ValueError: F outside [0, 1). About 1e-12 relative; Harris' printed table agrees to its last digit, 3e-4.

    Source: Harris, Rolling Bearing Analysis: δ* = (2K/π)(π/(2κ²E))^(1/3).
    """
    p = ellipticity(difference) ** -2.0
    K, E = _elliptic_integrals(p)
    return float(2.0 / pi * K * (0.5 * pi * p / E) ** (1.0 / 3.0))


def ball_stiffness(bearing: BallBearing, side: Side) -> float:
    """K of Q = K δ^(3/2) of one ball on one raceway: equations (8) to (11), K = (C δ*)^(-3/2) Σρ^(-1/2), N/m^1.5.

    C = (3 c/2)^(2/3)/2 with c = Σ (1 − ν²)/E in N and m; the printed 2.79e-4 is 1e4 of it (N, mm).
    """
    curvature = raceway_curvature(bearing, side)
    constant = 0.5 * (1.5 * sum(compliances(bearing, side))) ** (2.0 / 3.0)
    return (constant * delta_star(curvature.difference)) ** -1.5 * curvature.sum**-0.5


def contact_ellipse(bearing: BallBearing, side: Side, force: float) -> tuple[float, float]:
    """Semi-axes of a ball's contact on a raceway under a force, N: the longer and the shorter one, m.

    Source: Hertz 1881; Harris, Rolling Bearing Analysis: a* = (2κ²E/π)^(1/3), b* = a*/κ, over (3 Q c/(2 Σρ))^(1/3).
    """
    curvature, compliance = raceway_curvature(bearing, side), sum(compliances(bearing, side))
    ratio = ellipticity(curvature.difference)
    _, E = _elliptic_integrals(ratio**-2.0)
    longer = (2.0 * ratio**2 * E / np.pi * 1.5 * force * compliance / curvature.sum) ** (1.0 / 3.0)
    return longer, longer / ratio


def ball_pressure(bearing: BallBearing, side: Side, force: float) -> float:
    """Hertz's peak pressure of a ball on a raceway under a force, N: 3 Q/(2 π a b), Pa.

    Source: Johnson, Contact Mechanics (1985), (4.24).
    """
    longer, shorter = contact_ellipse(bearing, side, force)
    return 1.5 * force / (pi * longer * shorter) if force > 0.0 else 0.0


PERMITTED = 4000e6  # Pa, at ISO 76's C0: roller and raceway then keep 1e-4 of the roller's diameter
PERMITTED_OF_BALLS = 4200e6  # Pa, the same of balls
FATIGUE = 1500e6  # Pa, at ISO 281's C_u, of usual bearing steels
DEPTHS = np.linspace(0.0, 3.0, 30_001)  # over the half-width


class LineContact(NamedTuple):
    """One contact under its force; m, Pa."""

    peak_pressure: float
    half_width: float
    largest_shear: float
    shear_depth: float
    largest_von_mises: float
    von_mises_depth: float


def stress_below(depth, poisson_ratio: float) -> tuple[ndarray, ndarray, ndarray]:
    """σ_x, σ_y, σ_z over the peak pressure on the line of symmetry, at depths over the half-width.

    Plane strain along y.

    σ_x = −(1 + 2z²)/√(1 + z²) + 2z, σ_z = −1/√(1 + z²), σ_y = ν (σ_x + σ_z)

    Source: Johnson, Contact Mechanics (1985), (4.49).
    """
    z = np.asarray(depth, dtype=float)
    root = np.sqrt(1.0 + z * z)
    across, down = 2.0 * z - (1.0 + 2.0 * z * z) / root, -1.0 / root
    return across, poisson_ratio * (across + down), down


def hertz_columns(bearing: Bearing, samples: Mapping[str, ndarray]) -> dict[str, ndarray]:
    """Columns of `lagrange.columns.DERIVED` from a run's contact forces, each (n_times, n_rollers).

    b² = 4 R Q/(π E* L), p₀ = 2 Q/(π b L), R of the perfect circles: at edges of spalls pressures are higher.

    Unavailable: the contacts of balls are points.

    Source: Johnson, Contact Mechanics (1985), (4.43) to (4.45).
    """
    if isinstance(bearing, BallBearing):
        raise Unavailable("Hertz pressures of runs are those of line contacts; this bearing has balls")
    found = {}
    for pair in contact_pairs(bearing)[:2]:
        width = np.sqrt(pair.half_width_factor * samples[f"{pair.kind}_force"])
        found[f"{pair.kind}_half_width"] = width
        found[f"{pair.kind}_peak_pressure"] = 2.0 / (np.pi * pair.length * pair.half_width_factor) * width  # Q = b²/...
    return {name: found[name] for name in DERIVED}


def line_contact(pair: Pair, force: float) -> LineContact:
    """Stresses of a pair under a force, N; the depths are those in steel of the ring's Poisson ratio."""
    pressure, width = pair.peak_pressure(force), pair.half_width(force)
    x, y, z = stress_below(DEPTHS, pair.materials[0].poisson_ratio)
    shear, mises = 0.5 * np.abs(x - z), np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2))
    (shear, shear_at), (mises, mises_at) = ((float(s.max()), float(DEPTHS[s.argmax()])) for s in (shear, mises))
    return LineContact(
        peak_pressure=pressure, half_width=width, largest_shear=shear * pressure, shear_depth=shear_at * width,
        largest_von_mises=mises * pressure, von_mises_depth=mises_at * width)  # fmt: skip
