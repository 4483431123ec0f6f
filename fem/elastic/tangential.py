"""Exact plane-strain series of rings and rollers under tangential tractions.

The tangential half of `continuum`, with its conventions: displacement per unit line load, along the push, relative to
what the body does as a whole.
"""

from math import pi, sqrt

import numpy as np

from fem.elastic.continuum import TRACTION, Section, annulus_surface, apart, hertz_centre, kolosov
from fem.errors import UsageError
from lagrange.bearing import Material

FASTEST = 0.5  # of the speed of shear waves; Rayleigh's wave, at which nothing is steady, is at 0.87 and more


def moving_softening(material: Material, speed: float) -> float:
    """Displacement under a load that moves along a half-plane in steady motion, over that under one at rest; >= 1.

    1 + 0.74 (v/c₂)² of slow ones, c₂ the speed of shear waves: 1e-6 in the paper's bearing, per cents in soft ones that
    turn fast.

    Parameters
    ----------
    speed : float, m/s, of the load along the surface

    Errors
    ------
    Of bodies of finite size: what it takes their waves to settle, and their slowest harmonics.
    UsageError: a speed beyond FASTEST.

    Source: Cole and Huth, J. Appl. Mech. 25 (1958) 433.
    """
    if material.rigid:
        return 1.0
    squared = material.density * speed**2 / material.lame_mu  # (v/c₂)²
    if squared > FASTEST**2:
        raise UsageError(
            f"operation.speed_rpm: contacts roll at {abs(speed):.4g} m/s along a surface whose shear waves travel at "
            f"{abs(speed) / sqrt(squared):.4g} m/s; the reduced model takes at most {FASTEST:g} of that: a lower speed "
            'or a stiffer material, or model = "fem"'
        )
    slow = material.lame_mu / (material.lame_lambda + 2.0 * material.lame_mu)  # (c₂/c₁)²
    pressure = sqrt(1.0 - slow * squared)
    product = pressure * sqrt(1.0 - squared)
    # Rayleigh's function 4 √(1 − (v/c₁)²) √(1 − (v/c₂)²) − (2 − (v/c₂)²)² over (v/c₂)², without the difference
    rayleigh = 4.0 * (slow * squared - 1.0 - slow) / (1.0 + product) + 4.0 - squared
    return pressure / rayleigh / (1.0 - material.poisson_ratio)


def shear_compliance(section: Section, n: np.ndarray) -> np.ndarray:
    """Tangential surface displacement per unit tangential traction sin nθ on the loaded circle.

    Parameters and errors as of `continuum.plane_compliance`; m/Pa. For n = 0 a uniform traction, which accelerates a
    disc's rotation.
    """
    n = np.asarray(n)
    if section.held == 0.0:
        return _disc_shear_compliance(section, n)
    t, convexity = section.held / section.loaded, section.convexity
    mu, kappa = section.material.lame_mu, kolosov(section.material)
    found = np.empty(n.shape)
    found[n == 0] = abs(1.0 / t**2 - 1.0) / (2.0 * mu)
    far, near = apart(n, t)
    found[far] = (kappa / (n[far] + convexity) + 1.0 / (n[far] - convexity)) / (4.0 * mu)
    found[near] = convexity * annulus_surface(n[near], t, kappa, TRACTION)[:, 1] / (2.0 * mu)
    return section.loaded * found


def _disc_shear_compliance(disc: Section, n: np.ndarray) -> np.ndarray:
    """The same of a free solid disc, without its mean motion.

    Source: Muskhelishvili's potentials for n >= 2; for n = 0 and 1 the polynomials r³ and r² cos θ, r² sin θ that
    balance a uniform angular and linear acceleration.
    """
    material = disc.material
    mu, lame, kappa = material.lame_mu, material.lame_lambda, kolosov(material)
    found = (kappa / (n + 1.0) + 1.0 / np.where(n < 2, 1, n - 1)) / (4.0 * mu)
    found[n == 0] = 1.0 / (6.0 * mu)
    found[n == 1] = 0.75 / mu - lame / (4.0 * mu * (lame + mu))
    return disc.loaded * found


def cross_compliance(section: Section, n: np.ndarray) -> np.ndarray:
    """Displacement cos nθ into a body per unit tangential traction sin nθ on the loaded circle.

    Parameters and errors as of `continuum.plane_compliance`; m/Pa. By Betti it is also the displacement along sin nθ
    under a pressure cos nθ.
    """
    n = np.asarray(n)
    if section.held == 0.0:
        return _disc_cross_compliance(section, n)
    t, convexity = section.held / section.loaded, section.convexity
    mu, kappa = section.material.lame_mu, kolosov(section.material)
    found = np.zeros(n.shape)
    far, near = apart(n, t)
    found[far] = (1.0 / (n[far] - convexity) - kappa / (n[far] + convexity)) / (4.0 * mu)
    found[near] = -annulus_surface(n[near], t, kappa, TRACTION)[:, 0] / (2.0 * mu)
    return section.loaded * found


def _disc_cross_compliance(disc: Section, n: np.ndarray) -> np.ndarray:
    """The same of a free solid disc, without its mean motion.

    Source: as of `_disc_shear_compliance`; n = 1 by Betti from `continuum.plane_compliance`.
    """
    kappa = kolosov(disc.material)
    found = 1.0 / np.where(n < 2, 1, n - 1) - kappa / (n + 1.0)
    found[n == 0] = 0.0
    found[n == 1] = 0.5 * (1.0 - kappa)
    return disc.loaded / (4.0 * disc.material.lame_mu) * found


def shear_approach(section: Section, half_width: float) -> float:
    """Tangential displacement under the centre of each semi-elliptic traction, m per N/m."""
    return hertz_centre(shear_compliance, section, half_width)


def stick_approach(section: Section, half_width: float) -> float:
    """Tangential displacement of each contact that sticks all over, m per N/m.

    The traction of a contact that sticks rises to its edges, 1/sqrt(b² − x²); under it a flat surface moves evenly, by
    1/(π E') less than the centre under a semi-ellipse.

    Source: Mindlin, J. Appl. Mech. 16 (1949) 259; Johnson, Contact Mechanics (1985), sections 2.8 and 7.2.
    """
    return shear_approach(section, half_width) - 1.0 / (pi * section.material.plane_strain_modulus)
