"""Rating lives of ISO 281, and of duty cycles. N, mm, 1/min, mm²/s; lives in 10⁶ revolutions."""

from dataclasses import dataclass

import numpy as np

from lagrange.limits import exceeds
from lagrange.rating.sources import Unavailable

EXPONENT = 10.0 / 3.0  # of roller bearings
OF_BALLS = 3.0
RELIABILITY = {90.0: 1.0, 95.0: 0.64, 96.0: 0.55, 97.0: 0.47, 98.0: 0.37, 99.0: 0.25, 99.5: 0.175, 99.9: 0.093}
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


def reliability_factor(percent: float) -> float:
    """a1 of a reliability, %. Unavailable: one that the standard does not list."""
    if percent not in RELIABILITY:
        raise Unavailable(f"reliability {percent:g} %: the standard lists {', '.join(f'{p:g}' for p in RELIABILITY)} %")
    return RELIABILITY[percent]


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

    def __post_init__(self):
        columns = self.loads, self.speeds, self.shares
        if not (len(self.loads) and all(np.shape(column) == np.shape(self.loads) for column in columns)):
            raise ValueError("a duty cycle needs at least one step with load, speed and share of time each")
        for name, column in zip(("load", "share of time"), (self.loads, self.shares), strict=True):
            if not (np.all(np.isfinite(column)) and np.all(column >= 0.0)):
                raise ValueError(f"a duty cycle's {name} must be a number of at least 0")
        if not np.all(np.isfinite(self.speeds)):
            raise ValueError("a duty cycle's speed must be a number")
        for name, column in zip(("load", "speed", "share of time"), columns, strict=True):
            if not np.all((column == 0.0) | ((LEAST <= np.abs(column)) & (np.abs(column) <= MOST))):
                raise ValueError(f"a duty cycle's {name} must be 0 or from {LEAST:g} to {MOST:g}")
        if not np.sum(self._turns) > 0.0:
            raise ValueError("a duty cycle must turn: every step has no speed or no share of time")

    @property
    def _turns(self) -> np.ndarray:
        return np.abs(self.speeds) * self.shares

    @property
    def speed(self) -> float:
        """Mean, 1/min."""
        return float(np.sum(self._turns) / np.sum(self.shares))

    @property
    def load(self) -> float:
        """P of rollers, N: the constant load of the same life, by Palmgren and Miner's sum of damage."""
        return self.load_by(EXPONENT)

    def load_by(self, exponent: float) -> float:
        """The same by another exponent of life."""
        return float((np.sum(self._turns * self.loads**exponent) / np.sum(self._turns)) ** (1.0 / exponent))

    @property
    def largest_load(self) -> float:
        return float(np.max(self.loads))
