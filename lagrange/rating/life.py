"""Ratings of ISO 281 and ISO 76: capacities, lives, duty cycles; friction by two models, heat. N, mm, 1/min, mm²/s.

Lives are in 10⁶ revolutions, torques of a cylindrical roller bearing with a cage in N mm, heat in W. The two models of
friction differ by a quarter or so: no number of friction is better than ±30 %.
"""

from dataclasses import dataclass
from math import asin, exp, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing
from lagrange.contact.laws import STEEL
from lagrange.errors import exceeds
from lagrange.rating.sources import Unavailable

OF_CAGED = 1.1  # b_m of cylindrical, tapered and machined needle roller bearings, ISO 281 table 6
REDUCTION = 0.83  # λ, of radial roller bearings: pressures along real contact lines are uneven
FASTEST = 1e6  # mm/min, speed times pitch diameter: above limiting speeds of rolling bearings in catalogues
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
        """Of a bearing. Unavailable: it has balls, lacks rollers, or is not of steel."""
        if isinstance(bearing, BallBearing):
            raise Unavailable("computed for rollers; this one has balls")
        if bearing.missing:
            raise Unavailable("computed for complete bearings; rollers of this one are missing")
        _refuse_other_than_steel(bearing)
        return cls(rollers=bearing.n_rollers, diameter=2e3 * bearing.element_radius, length=1e3 * bearing.roller_length,
            pitch=2e3 * bearing.pitch_radius, cosine=bearing.cosine, rows=bearing.rows)  # fmt: skip


def _refuse_other_than_steel(bearing):
    for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring):
        if not STEEL[0] <= material.youngs_modulus <= STEEL[1]:
            raise Unavailable(
                f"ratings are those of bearing steel; a body has {1e-9 * material.youngs_modulus:.4g} GPa; give "
                "bearing.dynamic_load_rating_N and static_load_rating_N"
            )


def speed_warning(bearing: Bearing, rpm: float) -> str | None:
    """A sentence where a ring's speed, 1/min, is beyond those of catalogues, n d_m up to FASTEST."""
    factor = rpm * 2e3 * bearing.pitch_radius
    if not exceeds(factor, FASTEST):
        return None
    return f"n d_m is {factor:.2g} mm/min, beyond {FASTEST:.2g}: catalogues' limiting speeds are lower"


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


def fatigue_load_limit(static: float, pitch: float, balls: bool = False) -> float:
    """C_u of ISO 281 annex B, simplified, N, by C_0r, N, and D_pw, mm."""
    return static / (22.0 if balls else 8.2) * min(1.0, (MEDIUM / pitch) ** (0.5 if balls else 0.3))


OF_DEEP_GROOVES = 1.3  # b_m of deep-groove ball bearings, ISO 281 table 1
BALL_REDUCTION = 0.95  # λ, of them
TWO_DEEP_ROWS = 0.90 / 0.95  # λ of two rows of deep grooves over that
GROOVE = 0.52  # of the ball's diameter, the groove's radius to which both standards rate
LARGE_BALL = 25.4  # mm, beyond which C grows by D_w^1.4
# f_0 of ISO 76 table 1 by hundredths of γ, from 0
STATIC_FACTORS = (14.7, 14.9, 15.1, 15.3, 15.5, 15.7, 15.9, 16.1, 16.3, 16.5, 16.4, 16.1, 15.9, 15.6, 15.4, 15.2, 14.9,
    14.7, 14.4, 14.2, 14.0, 13.7, 13.5, 13.2, 13.0, 12.8, 12.5, 12.3, 12.1, 11.8, 11.6, 11.4, 11.2, 10.9, 10.7, 10.5,
    10.3, 10.0, 9.8, 9.6, 9.4,)  # fmt: skip


def ball_capacity_factor(gamma: float) -> float:
    """f_c of ISO 281 for deep-groove ball bearings with grooves of 0.52 D_w, N and mm.

    f_c = 98.0665 · 0.41 λ · (2r/(2r − D))^0.41 γ^0.3 (1 − γ)^1.39/(1 + γ)^(1/3) · {1 + X^(10/3)}^(−3/10),
    X = 1.04 ((1 − γ)/(1 + γ))^1.72

    Source: ISO/TR 1281-1; its table 2 (46.7, 55.5, 59.6, 59.9 at γ = 0.05, 0.10, 0.16, 0.20) is met within 0.1 %.
    """
    ratio = (1.0 - gamma) / (1.0 + gamma)
    groove = (2.0 * GROOVE / (2.0 * GROOVE - 1.0)) ** 0.41
    geometry = gamma**0.3 * (1.0 - gamma) ** 1.39 / (1.0 + gamma) ** (1 / 3)
    return 98.0665 * 0.41 * BALL_REDUCTION * groove * geometry * (1.0 + (1.04 * ratio**1.72) ** (10 / 3)) ** -0.3


def ball_dynamic_capacity(balls: int, diameter: float, pitch: float, cosine: float = 1.0, rows: int = 1) -> float:
    """C_r of ISO 281 of a deep-groove or angular-contact ball bearing, N; mm."""
    size = diameter**1.8 if diameter <= LARGE_BALL else 3.647 * diameter**1.4
    reduction = TWO_DEEP_ROWS if rows > 1 and cosine == 1.0 else 1.0
    factor = reduction * OF_DEEP_GROOVES * ball_capacity_factor(diameter * cosine / pitch)
    return factor * (rows * cosine) ** 0.7 * balls ** (2 / 3) * size


def static_factor(gamma: float) -> float:
    """f_0 of ISO 76 for deep-groove ball bearings, N/mm²; its table between hundredths of γ, at most 0.4."""
    return float(np.interp(100.0 * gamma, range(len(STATIC_FACTORS)), STATIC_FACTORS))


def ball_static_capacity(balls: int, diameter: float, pitch: float, cosine: float = 1.0, rows: int = 1) -> float:
    """C_0r of ISO 76, N; mm: the largest contact stress is then 4200 MPa."""
    return static_factor(diameter * cosine / pitch) * rows * balls * diameter**2 * cosine


OPEN_GROOVES = 0.52, 0.53  # of a ball's diameter, inner and outer: ISO 281 rates to grooves of at most these radii
ROUNDING = 1e-6


class Basic(NamedTuple):
    """Basic ratings of a bearing, of rollers or balls, all rows together."""

    dynamic: float  # C
    static: float  # C0
    fatigue: float  # C_u
    pitch: float  # D_pw

    @classmethod
    def of(cls, bearing: Bearing, **known: float) -> "Basic":
        """By ISO 281 and ISO 76, or as `known` by fields; C_u follows C0.

        Unavailable: not complete; without known C and C0 not of steel, or of grooves wider than the standard rates."""
        if bearing.missing:
            raise Unavailable("ratings are those of complete bearings; rollers of this one are missing")
        if not {"dynamic", "static"} <= known.keys():
            known = dict(zip(("dynamic", "static"), _capacities(bearing), strict=True)) | known
        pitch, balls = 2e3 * bearing.pitch_radius, isinstance(bearing, BallBearing)
        return cls(**{"fatigue": fatigue_load_limit(known["static"], pitch, balls), "pitch": pitch} | known)


def _capacities(bearing):
    """C and C0 by the standards."""
    if not isinstance(bearing, BallBearing):
        row = Dimensions.of(bearing)
        return dynamic_capacity(row), static_capacity(row)
    _refuse_other_than_steel(bearing)
    diameter = 2e3 * bearing.element_radius
    grooves = bearing.inner_groove_radius, bearing.outer_groove_radius
    for side, groove, most in zip(("inner", "outer"), grooves, OPEN_GROOVES, strict=True):
        if 1e3 * groove > (most + ROUNDING) * diameter:
            raise Unavailable(
                f"ratings are those of an {side} groove radius up to {most:g} of the ball's diameter; this one has "
                f"{1e3 * groove / diameter:.4g}; give bearing.dynamic_load_rating_N and static_load_rating_N"
            )
    sizes = bearing.n_rollers, diameter, 2e3 * bearing.pitch_radius, bearing.cosine, bearing.rows
    return ball_dynamic_capacity(*sizes), ball_static_capacity(*sizes)


EXPONENT = 10.0 / 3.0  # of roller bearings
OF_BALLS = 3.0
RELIABILITY = {  # a1 as the standard rounds it
    90.0: 1.0, 95.0: 0.64, 96.0: 0.55, 97.0: 0.47, 98.0: 0.37, 99.0: 0.25, 99.2: 0.22, 99.4: 0.19, 99.6: 0.16,
    99.8: 0.12, 99.9: 0.093, 99.92: 0.087, 99.94: 0.08, 99.95: 0.077}  # fmt: skip
CERTAIN = 0.05  # of L10, which all bearings reach: C_γ of ISO/TR 1281-2
SCATTER = 1.5  # e, Weibull's exponent
KAPPA = 0.1, 4.0  # a_ISO is given between; beyond the upper one it stays
LARGEST = 50.0  # a_ISO
SLOW = 1000.0  # 1/min, below which ν1 has another formula
MINUTES = 1e6 / 60.0  # hours of a million revolutions at 1/min


def basic_life(capacity: float, load: float, exponent: float = EXPONENT) -> float:
    """L10 = (C/P)^(10/3), of balls (C/P)³, 10⁶ revolutions. Unavailable: there is no load."""
    if not load > 0.0:
        raise Unavailable("without load the rating life is infinite")
    return (capacity / load) ** exponent


def in_hours(life: float, speed: float) -> float:
    """A life, 10⁶ revolutions, in hours at a speed, 1/min. Unavailable: it stands."""
    if speed == 0.0:
        raise Unavailable("the bearing does not turn")
    return life * MINUTES / abs(speed)


def revolutions(hours: float, speed: float) -> float:
    """A life in hours at a speed, 1/min, in 10⁶ revolutions."""
    return hours * abs(speed) / MINUTES


def reliability_factor(percent: float) -> float:
    """a1 of a reliability, %, from 90 to 99.95: the standard's, between its values by the distribution behind them."""
    scatter = (log(100.0 / percent) / log(1.0 / 0.9)) ** (1.0 / SCATTER)
    return RELIABILITY.get(percent, CERTAIN + (1.0 - CERTAIN) * scatter)


def reliability(ratio: float) -> float:
    """Share of bearings, %, that reach a life, over the life that nine of ten reach: S = exp(−ln(1/0.9) x^1.5),
    x = (L/L10 − 0.05)/0.95. Source: ISO/TR 1281-2, three-parameter Weibull distribution."""
    return 100.0 * exp(log(0.9) * (max(ratio - CERTAIN, 0.0) / (1.0 - CERTAIN)) ** SCATTER)


def required_capacity(load: float, life: float, exponent: float = EXPONENT) -> float:
    """C, N, that has a life, 10⁶ revolutions, under P, N."""
    return load * life ** (1.0 / exponent)


def reference_viscosity(speed: float, pitch: float) -> float:
    """ν1, mm²/s, that a bearing of D_pw, mm, needs at a speed, 1/min. Unavailable: it stands."""
    n = abs(speed)
    if n == 0.0:
        raise Unavailable("the bearing does not turn: no film forms")
    return (45000.0 * n**-0.83 if exceeds(SLOW, n) else 4500.0 * n**-0.5) * pitch**-0.5


def life_modification(kappa: float, ratio: float, balls: bool = False) -> float:
    """a_ISO of radial roller bearings, or radial ball bearings, by κ and e_C C_u/P, at most 50.

    a_ISO = 0.1 [1 − (1.5859 − c/κ^m) (e_C C_u/P)^0.4]^−9.185
    of balls 0.1 [1 − (2.5671 − c/κ^m)^0.83 (e_C C_u/P)^(1/3)]^−9.3

    Source: ISO 281:2007, (34) to (36), of balls (31) to (33). Unavailable: κ below 0.1.
    """
    if kappa < KAPPA[0]:
        raise Unavailable(f"κ = {kappa:.3g}: a_ISO is not given below {KAPPA[0]:g}")
    kappa = min(kappa, KAPPA[1])
    m = 0.054381 if kappa < 0.4 else 0.19087 if kappa < 1.0 else 0.071739
    if balls:
        left = 1.0 - (2.5671 - (2.2649 if kappa < 0.4 else 1.9987) / kappa**m) ** 0.83 * ratio ** (1 / 3)
    else:
        left = 1.0 - (1.5859 - (1.3993 if kappa < 0.4 else 1.2348) / kappa**m) * ratio**0.4
    return min(0.1 * left ** (-9.3 if balls else -9.185), LARGEST) if left > 0.0 else LARGEST


def contamination_factor(kappa: float, pitch: float) -> float:
    """e_C of oil lubrication with an in-line filter, β6(c) ≥ 200, D_pw in mm: ISO 281:2007 annex A."""
    largest = min(0.0864 * kappa**0.68 * pitch**0.55, 1.0)
    return largest * (1.0 - 0.5663 / pitch ** (1.0 / 3.0))


LEAST, MOST = 1e-12, 1e12  # of what is not 0 in a duty cycle


@dataclass(frozen=True, kw_only=True)
class DutyCycle:
    """Loads, N, speeds, 1/min, and shares of time of steps that recur, (n,) each."""

    loads: np.ndarray
    speeds: np.ndarray
    shares: np.ndarray  # any unit; their sum is the whole
    axial_loads: np.ndarray | None = None  # beside the loads; None: the scene's

    def __post_init__(self):
        columns = {"load": self.loads, "speed": self.speeds, "share of time": self.shares}
        columns |= {} if self.axial_loads is None else {"axial load": self.axial_loads}
        if not (len(self.loads) and all(np.shape(column) == np.shape(self.loads) for column in columns.values())):
            raise ValueError("a duty cycle needs at least one step with load, speed and share of time each")
        for name, column in columns.items():
            signed = name in ("speed", "axial load")
            if not np.all(np.isfinite(column)) or (not signed and np.any(column < 0.0)):
                least = "" if signed else " of at least 0"
                raise ValueError(f"a duty cycle's {name} must be a number{least}")
            if not np.all((column == 0.0) | ((LEAST <= np.abs(column)) & (np.abs(column) <= MOST))):
                raise ValueError(f"a duty cycle's {name} must be 0 or from {LEAST:g} to {MOST:g}")
        if not np.sum(self.turns) > 0.0:
            raise ValueError("a duty cycle must turn: every step has no speed or no share of time")

    @property
    def turns(self) -> np.ndarray:
        return np.abs(self.speeds) * self.shares

    @property
    def speed(self) -> float:
        """Mean, 1/min."""
        return float(np.sum(self.turns) / np.sum(self.shares))

    def load(self, exponent: float = EXPONENT) -> float:
        """The constant load of the same life, N, by Palmgren and Miner's sum of damage."""
        return float((np.sum(self.turns * self.loads**exponent) / np.sum(self.turns)) ** (1.0 / exponent))


ROLLING = {"10": 1.12e-6, "2": 1.09e-6, "22": 1.40e-6, "3": 1.09e-6, "23": 1.48e-6}  # R1 by dimension series
SLIDING = 0.0015  # S2
FILM, BOUNDARY = 0.02, 0.15  # sliding friction coefficients of full film and of none
REPLENISHMENT, CAGED = 3e-8, 5.1  # K_rs of an oil bath or jet, K_z
BATH = {"10": 2.2, "2": 2.2, "22": 3.0, "3": 2.2, "23": 4.0}  # Palmgren's f0
LOADED = {"10": 2e-4, "2": 3e-4, "22": 4e-4, "3": 3.5e-4, "23": 4e-4}  # and f1
SLENDER = 2.5  # length over diameter, of needles at least
STEADY = 2000.0  # ν n, mm²/s/min, below which M0 does not depend on it
HEAT_FLOW, HEATED = 0.016, 50.0  # W/mm², at so many K above the surroundings
LARGEST_SURFACE = 50_000.0  # mm², for which that heat flow holds


class Torque(NamedTuple):
    """Parts that depend on the oil's flow and on the load, N mm."""

    rolling: float  # SKF: M_rr; Palmgren: M0
    sliding: float  # SKF: M_sl; Palmgren: M1

    @property
    def total(self) -> float:
        return self.rolling + self.sliding


def caged_cylinders(row: Dimensions) -> None:
    """Unavailable: the models' constants are not those of the bearing."""
    if row.cosine < 1.0:
        other = "a contact angle"
    elif (row.rollers + 1) * asin(min(row.diameter / row.pitch, 1.0)) > pi:
        other = "a full complement of rollers"
    elif exceeds(row.length, SLENDER * row.diameter):
        other = "needles"
    else:
        return
    raise Unavailable(f"constants of friction are those of cylindrical rollers in a cage; this bearing has {other}")


def skf_torque(bore: float, outside: float, load: float, speed: float, viscosity: float, series: str = "2") -> Torque:
    """SKF's M = φ_ish φ_rs M_rr + M_sl, without axial load, seals and drag.

    M_rr = R1 d_m^2.41 F^0.31 (ν n)^0.6, M_sl = S2 d_m F μ_sl, μ_sl = f_bl 0.15 + (1 − f_bl) 0.02,
    f_bl = exp(−2.6e-8 (n ν)^1.4 d_m), φ_ish = 1/(1 + 1.84e-9 (n d_m)^1.28 ν^0.64),
    φ_rs = exp(−K_rs ν n (d + D) √(K_z/(2 (D − d))))

    Source: SKF Rolling Bearings catalogue, friction.
    """
    mean, n = 0.5 * (bore + outside), abs(speed)
    flow = viscosity * n
    shear_heating = 1.0 / (1.0 + 1.84e-9 * (n * mean) ** 1.28 * viscosity**0.64)
    starvation = exp(-REPLENISHMENT * flow * (bore + outside) * sqrt(CAGED / (2.0 * (outside - bore))))
    rolling = ROLLING[series] * mean**2.41 * load**0.31 * flow**0.6
    boundary = exp(-2.6e-8 * flow**1.4 * mean)
    sliding = SLIDING * mean * load * (boundary * BOUNDARY + (1.0 - boundary) * FILM)
    return Torque(rolling=shear_heating * starvation * rolling, sliding=sliding)


def palmgren_torque(
    bore: float, outside: float, load: float, speed: float, viscosity: float, series: str = "2"
) -> Torque:
    """Palmgren's M0 + M1: M0 = f0 (ν n)^(2/3) d_m³ 1e-7, or f0 160 d_m³ 1e-7 below ν n = 2000; M1 = f1 F d_m."""
    mean, flow = 0.5 * (bore + outside), viscosity * abs(speed)
    factor = 160.0 if exceeds(STEADY, flow) else flow ** (2.0 / 3.0)
    return Torque(rolling=1e-7 * BATH[series] * factor * mean**3, sliding=LOADED[series] * load * mean)


FRICTION = {"skf": skf_torque, "palmgren": palmgren_torque}


def power_loss(torque: float, speed: float) -> float:
    """Heat, W, of a torque, N mm, at a speed, 1/min."""
    return 1e-3 * torque * abs(speed) * 2.0 * pi / 60.0


def conductance(bore: float, outside: float, width: float) -> float:
    """Heat that leaves a bearing per K above its surroundings, W/K: the reference heat flow of ISO 15312, 50 K."""
    surface = pi * width * (bore + outside)
    flow = HEAT_FLOW if surface <= LARGEST_SURFACE else HEAT_FLOW * (surface / LARGEST_SURFACE) ** -0.34
    return flow * surface / HEATED
