"""How far rollers, and rings on a stiff hub, grow as they spin: exact solutions in plane strain."""

from math import pi, sqrt

import numpy as np

from lagrange.bearing import Bearing, Material
from lagrange.kinematics import Kinematics

SLOW = 1e-4  # (ωr/c)², c the waves' speed: below, carrying around what has grown adds 2e-5 of it at most


def growths(bearing: Bearing, motion: Kinematics) -> tuple[float, float]:
    """How much the radii of the inner raceway and of free rollers grow as they spin, m."""
    inner = spinning_growth(bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring, motion.shaft)
    return inner, spinning_growth(bearing.roller_radius, 0.0, bearing.roller, motion.roller)


def outer_growth(bearing: Bearing, motion: Kinematics) -> float:
    """The same of the outer raceway, in a ring that is held around its outside, m."""
    return spinning_growth(bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring, motion.outer_ring)


def spinning_growth(radius: float, held_radius: float, material: Material, speed: float) -> float:
    """Radial displacement, m, of a free circle of a body that spins at a speed, rad/s.

    `held_radius`, m: a circle that does not give; 0: a solid disc. What has grown is carried around, too, where that
    matters. Errors: 2e-5 of the growth.

    Source: Timoshenko and Goodier, Theory of Elasticity, section 32, in plane strain: u = a r + b/r − ρω² r³/8(λ+2μ).
    """
    if material.rigid:
        return 0.0
    mu, lame = material.lame_mu, material.lame_lambda
    if material.density * (speed * radius) ** 2 > SLOW * (lame + 2.0 * mu):
        return _carried_growth(radius, held_radius, material, speed)
    cubic = -material.density * speed**2 / (8.0 * (lame + 2.0 * mu))
    # σ_rr = (λ + 2μ) u' + λ u/r, nothing at `radius`
    stress = [2.0 * (lame + mu), -2.0 * mu / radius**2, (3.0 * (lame + 2.0 * mu) + lame) * cubic * radius**2]
    if held_radius == 0.0:
        a, b = -stress[2] / stress[0], 0.0
    else:
        matrix = [stress[:2], [held_radius, 1.0 / held_radius]]
        a, b = np.linalg.solve(matrix, [-stress[2], -cubic * held_radius**3])
    return float(a * radius + b / radius + cubic * radius**3)


def _carried_growth(radius: float, held_radius: float, material: Material, speed: float) -> float:
    """`spinning_growth` with (λ+2μ)(u'' + u'/r − u/r²) = −ρω²(r + u): r + u is a combination of J₁(kr) and Y₁(kr)."""
    from scipy.special import j0, j1, y0, y1  # takes its time to load, and most bodies are slow

    mu, lame = material.lame_mu, material.lame_lambda
    k = abs(speed) * sqrt(material.density / (lame + 2.0 * mu))

    def reaches(r):
        """r + u of two solutions, near r and 1/r where k is small."""
        return np.array([2.0 / k * j1(k * r), -0.5 * pi * k * y1(k * r)])

    def slope(r):
        return np.array([2.0 * j0(k * r), -0.5 * pi * k**2 * y0(k * r)]) - reaches(r) / r

    stress = (lame + 2.0 * mu) * slope(radius) + lame / radius * reaches(radius)
    if held_radius == 0.0:
        weights = np.array([2.0 * (lame + mu) / stress[0], 0.0])
    else:
        weights = np.linalg.solve([stress, reaches(held_radius)], [2.0 * (lame + mu), held_radius])
    return float(weights @ reaches(radius) - radius)
