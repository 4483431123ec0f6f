"""Contact laws Q(δ) of one contact that need no raceway: empirical ones of rollers, Hertz of a ball in a groove.

Laws that know the raceways or the material are in `raceway_laws`. Hertz's point contact is that of equations (4) to
(11) of the paper for any material; the constants 2.79e-4 and 2.15e5 that Harris and the paper print (N, mm) belong to
E = 207 GPa, ν = 0.3 on both sides.
"""

from dataclasses import dataclass
from math import exp, pi
from typing import Literal

import numpy as np

from lagrange.bearing import BallBearing, Material

STEEL_LENGTH_EXPONENT = 8.0 / 9.0
STEEL_RANGE = "steel on steel, rollers with relieved ends, loads of rolling bearings"


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """Q = K δ^n for δ > 0, else 0: the load-zone condition (24), (25). δ in m, Q in N."""

    name: str
    stiffness: float  # K, N/m^n
    exponent: float  # n
    source: str
    range: str = ""  # where the source says it holds

    def force(self, approach):
        """Contact force, N, >= 0, of an approach (any shape), m."""
        return self.stiffness * np.maximum(approach, 0.0) ** self.exponent

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        return (np.asarray(force) / self.stiffness) ** (1.0 / self.exponent)

    def slope(self, approach):
        """Contact stiffness dQ/dδ, N/m; 0 for an open contact."""
        depth = np.asarray(approach, dtype=float)
        closed = depth > 0.0
        # a fitted exponent may be below 1: no power of an open contact is taken
        power = np.where(closed, depth, 1.0) ** (self.exponent - 1.0)
        return np.where(closed, self.exponent * self.stiffness * power, 0.0)

    def potential(self, approach):
        """Energy stored in the contact, J."""
        n = self.exponent
        return self.stiffness * np.maximum(approach, 0.0) ** (n + 1.0) / (n + 1.0)


def _steel_law(name: str, in_mm: float, exponent: float, source: str) -> PowerLaw:
    """A law of steel bearings whose stiffness is in N/mm^n."""
    return PowerLaw(name=name, stiffness=in_mm * 1e3**exponent, exponent=exponent, source=source, range=STEEL_RANGE)


def harris(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway, equations (12), (13) of the paper: Q = 7.86e4 L^(8/9) δ^(10/9) in N and mm.

    Source: Harris, Rolling Bearing Analysis; an empirical law for crowned steel rollers.
    """
    exponent = 10.0 / 9.0
    in_mm = 7.86e4 * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    return _steel_law(
        "harris", in_mm, exponent, "Harris, Rolling Bearing Analysis, Q = 78 600 L^(8/9) δ^(10/9), N and mm"
    )


def palmgren(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway: δ = 3.84e-5 Q^0.9 / L^0.8 in N and mm.

    Source: Palmgren, Ball and Roller Bearing Engineering (3rd ed. 1959).
    """
    exponent = 1.0 / 0.9
    in_mm = ((1e3 * roller_length) ** 0.8 / 3.84e-5) ** exponent
    return _steel_law("palmgren", in_mm, exponent, "Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8")


def iso16281(roller_length: float) -> PowerLaw:
    """Half of the approach of both contacts in series: Q = 35948 L^(8/9) δ^(10/9) for the two together, N and mm.

    Source: ISO/TS 16281:2008, spring constant of a roller with line contact.
    """
    exponent = 10.0 / 9.0
    in_mm = 35948.0 * 2.0**exponent * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    source = "ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9) for both contacts together"
    return _steel_law("iso16281", in_mm, exponent, source)


def braendlein(roller_length: float) -> PowerLaw:
    """Half of the approach of both contacts in series: Q = 26200 L^0.92 δ^1.08 for the two together, N and mm.

    Source: Brändlein, Eschmann, Hasbargen, Weigand, Die Wälzlagerpraxis (3rd ed. 1995), as quoted by others; not
    checked in the text.
    """
    exponent = 1.08
    in_mm = 26200.0 * 2.0**exponent * (1e3 * roller_length) ** 0.92
    source = "Brändlein et al. 1995 (second hand), Q = 26200 L^0.92 δ^1.08 for both contacts together"
    return _steel_law("braendlein", in_mm, exponent, source)


LAWS = {"harris": harris, "palmgren": palmgren, "iso16281": iso16281, "braendlein": braendlein}


def roller_law(name: str, roller_length: float) -> PowerLaw:
    """The named law for rollers of the given length, m: one of the laws that need no more than it.

    Errors
    ------
    ValueError: an unknown name; the message lists the known ones. `raceway_laws.contact_laws` knows more, from the
    whole bearing.
    """
    if name not in LAWS:
        raise ValueError(f"unknown contact law {name!r}; known: {', '.join(sorted(LAWS))}")
    return LAWS[name](roller_length)


Side = Literal["inner", "outer"]
NEARLY_CIRCULAR = 1e-5  # below this F, F = 3 m/8 is more exact than the elliptic integrals' difference
LONGEST_ELLIPSE = 18.0  # ln κ: F = 1 − 1e-14, next to a line contact
BISECTIONS = 60  # to the last digit of ln κ


@dataclass(frozen=True, kw_only=True)
class Curvature:
    """Principal curvatures of two bodies in point contact; 1 across, 2 along the axis, 1/m, concave < 0."""

    ball_1: float  # ρ_A1
    ball_2: float  # ρ_A2
    raceway_1: float  # ρ_B1, the rolling direction
    raceway_2: float  # ρ_B2, the groove

    @property
    def sum(self) -> float:
        """Σρ, 1/m: equation (4)."""
        return self.ball_1 + self.ball_2 + self.raceway_1 + self.raceway_2

    @property
    def difference(self) -> float:
        """F(ρ), 0 (circle) to 1 (line): equation (5)."""
        return abs((self.ball_1 - self.ball_2) + (self.raceway_1 - self.raceway_2)) / self.sum


def raceway_curvature(bearing: BallBearing, side: Side) -> Curvature:
    """Curvatures of ball and raceway: equations (6) and (7); of a section's raceway cos α/R."""
    ball, cosine = 1.0 / bearing.element_radius, bearing.cosine
    if side == "inner":
        return Curvature(
            ball_1=ball,
            ball_2=ball,
            raceway_1=cosine / bearing.inner_raceway_radius,
            raceway_2=-1.0 / bearing.inner_groove_radius,
        )
    return Curvature(
        ball_1=ball,
        ball_2=ball,
        raceway_1=-cosine / bearing.outer_raceway_radius,
        raceway_2=-1.0 / bearing.outer_groove_radius,
    )


def ellipticity(difference: float) -> float:
    """Ratio κ >= 1 of the contact ellipse's axes from the curvature difference F(ρ).

    Errors
    ------
    ValueError: F outside [0, 1). κ to 1e-10 relative (the integrals' difference cancels); below F = 1e-5 a series,
    to 1e-5 of κ − 1.

    Source: Harris, Rolling Bearing Analysis, Hertz's theory: F = [(κ²+1)E − 2K]/[(κ²−1)E], m = 1 − 1/κ².
    """
    if not 0.0 <= difference < 1.0:
        raise ValueError(f"curvature difference F = {difference:.6g}: must be at least 0 and below 1 (a line contact)")
    if difference < NEARLY_CIRCULAR:
        return (1.0 - 8.0 / 3.0 * difference) ** -0.5
    low, high = 0.5 * NEARLY_CIRCULAR, LONGEST_ELLIPSE
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if _difference(middle) < difference:
            low = middle
        else:
            high = middle
    return exp(0.5 * (low + high))


def _elliptic_integrals(p):
    """Complete integrals K and E of m = 1 − p, p = 1/κ²; exact for p near 0 too."""
    from scipy.special import ellipe, ellipkm1  # 0.1 s to import, and only balls need it

    return ellipkm1(p), ellipe(1.0 - p)


def _difference(log_ratio: float) -> float:
    """F of an ellipse with ln κ."""
    p = exp(-2.0 * log_ratio)
    K, E = _elliptic_integrals(p)
    return ((1.0 + p) * E - 2.0 * p * K) / ((1.0 - p) * E)


def delta_star(difference):
    """Dimensionless approach δ*(F), figure 4 of the paper; F a number or an array.

    Errors
    ------
    ValueError: F outside [0, 1). About 1e-12 relative; Harris' printed table agrees to its last digit, 3e-4.

    Source: Harris, Rolling Bearing Analysis: δ* = (2K/π)(π/(2κ²E))^(1/3).
    """
    p = np.array([ellipticity(float(F)) for F in np.ravel(difference)]).reshape(np.shape(difference)) ** -2.0
    K, E = _elliptic_integrals(p)
    value = 2.0 / pi * K * (0.5 * pi * p / E) ** (1.0 / 3.0)
    return float(value) if np.ndim(difference) == 0 else value


def approach_constant(ball: Material, raceway: Material) -> float:
    """C of equation (8), δ = C δ* Q^(2/3) Σρ^(1/3), in N and m: C = (3 c/2)^(2/3)/2, c = Σ (1 − ν²)/E, Pa^(-2/3).

    The printed 2.79e-4 is 1e4 of it (N, mm).
    """
    compliance = 1.0 / ball.plane_strain_modulus + 1.0 / raceway.plane_strain_modulus
    return 0.5 * (1.5 * compliance) ** (2.0 / 3.0)


def contact_ellipse(bearing: BallBearing, side: Side, force: float) -> tuple[float, float]:
    """Semi-axes of a ball's contact on a raceway under a force, N: the longer and the shorter one, m.

    Source: Hertz 1881; Harris, Rolling Bearing Analysis: a* = (2κ²E/π)^(1/3), b* = a*/κ, over (3 Q c/(2 Σρ))^(1/3).
    """
    curvature = raceway_curvature(bearing, side)
    ring = bearing.inner_ring if side == "inner" else bearing.outer_ring
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / ring.plane_strain_modulus
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


def ball_law(bearing: BallBearing, side: Side) -> PowerLaw:
    """Q = K δ^(3/2) of one ball on one raceway: equations (9) to (11), K = (C δ*)^(-3/2) Σρ^(-1/2), N/m^1.5.

    Source: Hertz 1881; Harris, Rolling Bearing Analysis. Range: elastic, smooth, dry, contact ellipse small against the
    ball and inside the groove.
    """
    curvature = raceway_curvature(bearing, side)
    constant = approach_constant(bearing.roller, bearing.inner_ring if side == "inner" else bearing.outer_ring)
    return PowerLaw(
        name="hertz",
        stiffness=(constant * delta_star(curvature.difference)) ** -1.5 * curvature.sum**-0.5,
        exponent=1.5,
        source="Hertz 1881, point contact, Q = K δ^(3/2)",
        range="elastic; contact ellipse small against the ball and inside the groove",
    )
