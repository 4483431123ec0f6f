"""Stresses of a line contact: Hertz's pressure and what it makes below the surface. SI."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from lagrange.bearing import BallBearing, Bearing
from lagrange.columns import DERIVED
from lagrange.contact.hertz import Pair, contact_pairs
from lagrange.rating.sources import Unavailable

PERMITTED = 4000e6  # Pa, at ISO 76's C0: roller and raceway then keep 1e-4 of the roller's diameter
PERMITTED_OF_BALLS = 4200e6  # Pa, the same of balls
FATIGUE = 1500e6  # Pa, at ISO 281's C_u, of usual bearing steels
DEPTHS = np.linspace(0.0, 3.0, 30_001)  # over the half-width


@dataclass(frozen=True, kw_only=True)
class LineContact:
    """One contact under its force; m, Pa."""

    peak_pressure: float
    half_width: float
    largest_shear: float
    shear_depth: float
    largest_von_mises: float
    von_mises_depth: float


def stress_below(depth, poisson_ratio: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """σ_x, σ_y, σ_z over the peak pressure on the line of symmetry, at depths over the half-width.

    Plane strain along y.

    σ_x = −(1 + 2z²)/√(1 + z²) + 2z, σ_z = −1/√(1 + z²), σ_y = ν (σ_x + σ_z)

    Source: Johnson, Contact Mechanics (1985), (4.49).
    """
    z = np.asarray(depth, dtype=float)
    root = np.sqrt(1.0 + z * z)
    across, down = 2.0 * z - (1.0 + 2.0 * z * z) / root, -1.0 / root
    return across, poisson_ratio * (across + down), down


@cache
def _largest(poisson_ratio: float) -> tuple[float, float, float, float]:
    """Largest shear and von Mises stress over the peak pressure, each with its depth over the half-width."""
    x, y, z = stress_below(DEPTHS, poisson_ratio)
    shear = 0.5 * np.abs(x - z)
    mises = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2))
    rows = [(float(each.max()), float(DEPTHS[each.argmax()])) for each in (shear, mises)]
    return *rows[0], *rows[1]


def hertz_columns(bearing: Bearing, samples: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of `lagrange.columns.DERIVED` from a run's contact forces, each (n_times, n_rollers).

    b² = 4 R Q/(π E* L), p₀ = 2 Q/(π b L), R of the perfect circles: at edges of spalls pressures are higher.

    Errors
    ------
    Unavailable: the contacts of balls are points.

    Source: Johnson, Contact Mechanics (1985), (4.43) to (4.45).
    """
    if isinstance(bearing, BallBearing):
        raise Unavailable("Hertz pressures of runs are those of line contacts; this bearing has balls")
    found = {}
    for pair, side in zip(contact_pairs(bearing), ("inner", "outer"), strict=False):
        width = np.sqrt(pair.half_width_factor * samples[f"{side}_force"])
        found[f"{side}_half_width"] = width
        found[f"{side}_peak_pressure"] = 2.0 / (np.pi * pair.length * pair.half_width_factor) * width  # Q = b² / factor
    return {name: found[name] for name in DERIVED}


def line_contact(pair: Pair, force: float) -> LineContact:
    """Stresses of a pair under a force, N; the depths are those in steel of the ring's Poisson ratio."""
    pressure, width = pair.peak_pressure(force), pair.half_width(force)
    shear, shear_at, mises, mises_at = _largest(pair.materials[0].poisson_ratio)
    return LineContact(
        peak_pressure=pressure, half_width=width, largest_shear=shear * pressure, shear_depth=shear_at * width,
        largest_von_mises=mises * pressure, von_mises_depth=mises_at * width,
    )  # fmt: skip
