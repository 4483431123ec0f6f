"""Exact plane-strain series of rings and rollers under tangential tractions.

The tangential half of `continuum`, with its conventions: displacement per unit line load, along the push, relative to
what the body does as a whole.
"""

from math import log, pi, sqrt

import numpy as np

from fem.elastic.continuum import DECOUPLED, annulus_modes, hertz_centre, kolosov
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


def disc_shear_compliance(n: np.ndarray, radius: float, material: Material) -> np.ndarray:
    """Tangential displacement of a free solid disc per unit tangential traction sin nθ, without its mean motion.

    Parameters
    ----------
    n : ndarray of int, >= 0; for n = 0 a uniform traction, which accelerates the disc's rotation

    Returns
    -------
    ndarray, shape of n, m/Pa

    Errors: round-off.

    Source: Muskhelishvili's potentials for n >= 2; for n = 0 and 1 the polynomials r³ and r² cos θ, r² sin θ that
    balance a uniform angular and linear acceleration.
    """
    n = np.asarray(n)
    mu, lame, kappa = material.lame_mu, material.lame_lambda, kolosov(material)
    found = (kappa / (n + 1.0) + 1.0 / np.where(n < 2, 1, n - 1)) / (4.0 * mu)
    found[n == 0] = 1.0 / (6.0 * mu)
    found[n == 1] = 0.75 / mu - lame / (4.0 * mu * (lame + mu))
    return radius * found


def disc_cross_compliance(n: np.ndarray, radius: float, material: Material) -> np.ndarray:
    """Displacement cos nθ into a free solid disc, without its mean motion, per unit tangential traction sin nθ, m/Pa.

    Errors: round-off. Source: as of `disc_shear_compliance`; n = 1 by Betti from `continuum.disc_harmonic_compliance`.
    """
    n = np.asarray(n)
    kappa = kolosov(material)
    found = 1.0 / np.where(n < 2, 1, n - 1) - kappa / (n + 1.0)
    found[n == 0] = 0.0
    found[n == 1] = 0.5 * (1.0 - kappa)
    return radius / (4.0 * material.lame_mu) * found


def ring_shear_compliance(n: np.ndarray, loaded_radius: float, held_radius: float, material: Material) -> np.ndarray:
    """Tangential displacement of an annulus, fixed on one circle, per unit tangential traction sin nθ on the other.

    Parameters and errors as of `continuum.ring_harmonic_compliance`; m/Pa.
    """
    n = np.asarray(n)
    if held_radius == 0.0:
        return disc_shear_compliance(n, loaded_radius, material)
    t = held_radius / loaded_radius
    mu, kappa = material.lame_mu, kolosov(material)
    found = np.empty(n.shape)
    found[n == 0] = abs(1.0 / t**2 - 1.0) / (2.0 * mu)
    far = _decoupled(n, t)
    convexity = 1 if t < 1.0 else -1
    found[far] = (kappa / (n[far] + convexity) + 1.0 / (n[far] - convexity)) / (4.0 * mu)
    near = n[(n > 0) & ~far]
    if near.size:
        around = np.sum(annulus_modes(near, 1.0, t, kappa)[:, 1, :] * _sheared(near, t, kappa), axis=1)
        found[(n > 0) & ~far] = np.sign(1.0 - t) * around / (2.0 * mu)
    return loaded_radius * found


def ring_cross_compliance(n: np.ndarray, loaded_radius: float, held_radius: float, material: Material) -> np.ndarray:
    """Displacement cos nθ into an annulus, fixed on one circle, per unit tangential traction sin nθ on the other.

    Parameters and errors as of `continuum.ring_harmonic_compliance`; m/Pa. By Betti it is also the
    displacement along sin nθ under a pressure cos nθ.
    """
    n = np.asarray(n)
    if held_radius == 0.0:
        return disc_cross_compliance(n, loaded_radius, material)
    t = held_radius / loaded_radius
    mu, kappa = material.lame_mu, kolosov(material)
    convexity = 1 if t < 1.0 else -1
    found = np.zeros(n.shape)
    far = _decoupled(n, t)
    found[far] = (1.0 / (n[far] - convexity) - kappa / (n[far] + convexity)) / (4.0 * mu)
    near = n[(n > 0) & ~far]
    if near.size:
        out = np.sum(annulus_modes(near, 1.0, t, kappa)[:, 0, :] * _sheared(near, t, kappa), axis=1)
        found[(n > 0) & ~far] = -out / (2.0 * mu)
    return loaded_radius * found


def _decoupled(n: np.ndarray, t: float) -> np.ndarray:
    """Whether harmonics of a ring do not feel the circle that is held, t loaded radii from the centre."""
    return (n > 1) & (2.0 * np.log(np.maximum(n, 1)) - 2.0 * n * abs(log(t)) < log(DECOUPLED))


def _sheared(n: np.ndarray, t: float, kappa: float) -> np.ndarray:
    """Weights, (n_n, 4), of the annulus modes for σ_rθ = sin nθ on radius 1, n >= 1, with radius t fixed."""
    conditions = np.concatenate((annulus_modes(n, t, t, kappa)[:, :2], annulus_modes(n, 1.0, t, kappa)[:, 2:]), axis=1)
    return np.linalg.solve(conditions, np.array([0.0, 0.0, 0.0, 1.0]).reshape(1, 4, 1))[..., 0]


def disc_shear_approach(radius: float, material: Material, half_width: float) -> float:
    """Tangential displacement under the centre of a semi-elliptic traction on a free disc, m per N/m."""
    return hertz_centre(lambda n: disc_shear_compliance(n, radius, material), radius, material, half_width, 1, 1.0)


def ring_shear_approach(loaded_radius: float, held_radius: float, material: Material, half_width: float) -> float:
    """Tangential displacement under the centre of a semi-elliptic traction on a ring held on its other circle."""

    def compliance(n):
        return ring_shear_compliance(n, loaded_radius, held_radius, material)

    convexity = 1.0 if loaded_radius > held_radius else -1.0
    return hertz_centre(compliance, loaded_radius, material, half_width, 1, convexity)


def disc_stick_approach(radius: float, material: Material, half_width: float) -> float:
    """Tangential displacement of a contact on a free disc that sticks all over, m per N/m.

    The traction of a contact that sticks rises to its edges, 1/sqrt(b² − x²); under it a flat surface moves evenly, by
    1/(π E') less than the centre under a semi-ellipse.

    Source: Mindlin, J. Appl. Mech. 16 (1949) 259; Johnson, Contact Mechanics (1985), sections 2.8 and 7.2.
    """
    return disc_shear_approach(radius, material, half_width) - 1.0 / (pi * material.plane_strain_modulus)


def ring_stick_approach(loaded_radius: float, held_radius: float, material: Material, half_width: float) -> float:
    """As `disc_stick_approach`, of a ring held on its other circle."""
    less = 1.0 / (pi * material.plane_strain_modulus)
    return ring_shear_approach(loaded_radius, held_radius, material, half_width) - less
