"""Frictional torque of a cylindrical roller bearing with a cage by two models, heat, and a first temperature.

N, mm, 1/min, mm²/s; torque in N mm, heat in W. The two models differ by a quarter or so: no number of friction is
better than ±30 %.
"""

from dataclasses import dataclass
from math import asin, exp, pi, sqrt

from lagrange.limits import exceeds
from lagrange.rating.life import Dimensions
from lagrange.rating.sources import Unavailable

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


@dataclass(frozen=True, kw_only=True)
class Torque:
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


def power_loss(torque: float, speed: float) -> float:
    """Heat, W, of a torque, N mm, at a speed, 1/min."""
    return 1e-3 * torque * abs(speed) * 2.0 * pi / 60.0


def conductance(bore: float, outside: float, width: float) -> float:
    """Heat that leaves a bearing per K above its surroundings, W/K: the reference heat flow of ISO 15312, 50 K."""
    surface = pi * width * (bore + outside)
    flow = HEAT_FLOW if surface <= LARGEST_SURFACE else HEAT_FLOW * (surface / LARGEST_SURFACE) ** -0.34
    return flow * surface / HEATED
