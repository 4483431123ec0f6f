"""Equivalent loads by X and Y of ISO 281 and ISO 76; least loads and axial limits of flanges by makers. N, mm, 1/min.

Two mirrored rows, back to back or face to face, have the factors of double rows; rows that are alike those of one.
"""

from math import tan
from typing import NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing
from lagrange.rating.life import static_factor


class Factors(NamedTuple):
    """P = F_r + Y1 F_a up to F_a = e F_r, beyond it P = X F_r + Y F_a."""

    e: float
    Y1: float
    X: float
    Y: float

    def load(self, radial: np.ndarray, axial: float) -> np.ndarray:
        """P, N."""
        axial = abs(axial)
        return np.where(axial <= self.e * radial, radial + self.Y1 * axial, self.X * radial + self.Y * axial)


PRESSED = (0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89)  # F_a/(i Z D_w²), MPa: axial loads of the tables
ONE_ROW = (  # α, °; e, Y1, X, Y: at these axial loads, or at any
    (5.0, (0.19, 0.22, 0.26, 0.28, 0.30, 0.34, 0.38, 0.42, 0.44), 0.0, 0.56,
     (2.30, 1.99, 1.71, 1.55, 1.45, 1.31, 1.15, 1.04, 1.00)),
    (10.0, (0.29, 0.32, 0.36, 0.38, 0.40, 0.44, 0.49, 0.54, 0.54), 0.0, 0.46,
     (1.88, 1.71, 1.52, 1.41, 1.34, 1.23, 1.10, 1.01, 1.00)),
    (15.0, (0.38, 0.40, 0.43, 0.46, 0.47, 0.50, 0.55, 0.56, 0.56), 0.0, 0.44,
     (1.47, 1.40, 1.30, 1.23, 1.19, 1.12, 1.02, 1.00, 1.00)),
    (20.0, 0.57, 0.0, 0.43, 1.00), (25.0, 0.68, 0.0, 0.41, 0.87), (30.0, 0.80, 0.0, 0.39, 0.76),
    (35.0, 0.95, 0.0, 0.37, 0.66), (40.0, 1.14, 0.0, 0.35, 0.57), (45.0, 1.34, 0.0, 0.33, 0.50))  # fmt: skip
MIRRORED = (
    (5.0, (0.23, 0.26, 0.30, 0.34, 0.36, 0.40, 0.45, 0.50, 0.52),
     (2.78, 2.40, 2.07, 1.87, 1.75, 1.58, 1.39, 1.26, 1.21), 0.78,
     (3.74, 3.23, 2.78, 2.52, 2.36, 2.13, 1.87, 1.69, 1.63)),
    (10.0, ONE_ROW[1][1], (2.18, 1.98, 1.76, 1.63, 1.55, 1.42, 1.27, 1.17, 1.16), 0.75,
     (3.06, 2.78, 2.47, 2.29, 2.18, 2.00, 1.79, 1.64, 1.63)),
    (15.0, ONE_ROW[2][1], (1.65, 1.57, 1.46, 1.38, 1.34, 1.26, 1.14, 1.12, 1.12), 0.72,
     (2.39, 2.28, 2.11, 2.00, 1.93, 1.82, 1.66, 1.63, 1.63)),
    (20.0, 0.57, 1.09, 0.70, 1.63), (25.0, 0.68, 0.92, 0.67, 1.41), (30.0, 0.80, 0.78, 0.63, 1.24),
    (35.0, 0.95, 0.66, 0.60, 1.07), (40.0, 1.14, 0.55, 0.57, 0.93), (45.0, 1.34, 0.47, 0.54, 0.81))  # fmt: skip
FLANGED = {True: Factors(0.2, 0.0, 0.92, 0.6), False: Factors(0.3, 0.0, 0.92, 0.4)}  # series 10, 2, 3, 4; others


def factors(bearing: Bearing, static: float, axial: float, mirrored: bool = False, series: str = "2") -> Factors:
    """Of ISO 281:2007 tables 3 and 7, linear between their values; of flanged cylindrical rollers SKF's.

    static : C0, N, of all rows; series : of `dimension_series`
    """
    if not isinstance(bearing, BallBearing):
        if bearing.contact_angle == 0.0:
            return FLANGED[series in ("10", "2", "3", "4")]
        slope = tan(bearing.contact_angle)
        return Factors(1.5 * slope, *((0.45 / slope, 0.67, 0.67 / slope) if mirrored else (0.0, 0.4, 0.4 / slope)))
    # one of two mirrored rows carries the axial load
    gamma, loaded = bearing.roller_radius / bearing.pitch_radius, 2.0 if mirrored else 1.0
    pressed = loaded * static_factor(gamma) * abs(axial) / static * bearing.cosine
    rows = [[np.interp(pressed, PRESSED[: np.size(cell)], np.atleast_1d(cell)) for cell in row]
            for row in (MIRRORED if mirrored else ONE_ROW)]  # fmt: skip
    angles, *columns = np.transpose(rows)
    return Factors(*(float(np.interp(bearing.contact_angle_deg, angles, column)) for column in columns))


STATIC_ANGLES = 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0
STATIC_AXIAL = 0.52, 0.50, 0.46, 0.42, 0.38, 0.33, 0.29, 0.26, 0.22  # Y0 of one row


def static_load(bearing: Bearing, radial: np.ndarray, axial: np.ndarray, mirrored: bool = False) -> np.ndarray:
    """P0 = max(X0 F_r + Y0 F_a, F_r) of ISO 76, N."""
    angle = bearing.contact_angle_deg
    if isinstance(bearing, BallBearing):
        x, y = (0.6, 0.5) if angle == 0.0 else (0.5, float(np.interp(angle, STATIC_ANGLES, STATIC_AXIAL)))
    else:
        x, y = (1.0, 0.0) if angle == 0.0 else (0.5, 0.22 / tan(bearing.contact_angle))
    twice = 2.0 if mirrored else 1.0
    return np.maximum(twice * (x * radial + y * np.abs(axial)), radial)


LEAST = {True: 0.01, False: 0.02}  # load over C, of balls and of rollers


def least_load(capacity: float, balls: bool) -> float:
    """Radial load, N, below which elements may skid: makers' rule of thumb, C/100 of balls, C/50 of rollers."""
    return LEAST[balls] * capacity


def flange_limit(static: float, bore: float, outside: float, speed: float, radial: float, series: str = "2") -> float:
    """Axial load, N, that flanges of cylindrical rollers carry for long with oil, for π B (d + D) up to 50 000 mm².

    The least of 0.5 F_r, 0.0023 D^1.7 kN (series 2: 0.0045 D^1.5), and by heat (1.5 C0 10⁴)/(n (d + D)) − 0.15 F_r, C0
    and F_r in kN; with grease 1 for 1.5, 0.1 for 0.15.

    Source: SKF, single row cylindrical roller bearings, dynamic axial load carrying capacity.
    """
    strength = 4.5 * outside**1.5 if series == "2" else 2.3 * outside**1.7
    heat = 1.5e4 * static / (max(abs(speed), 1.0) * (bore + outside)) - 0.15 * radial
    return max(min(0.5 * radial, strength, heat), 0.0)
