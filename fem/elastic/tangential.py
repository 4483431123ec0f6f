"""Exact plane-strain series of rings and rollers under tangential tractions, and how far they grow as they spin.

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


SLOW = 1e-4  # (ωr/c)², c the waves' speed: below, carrying around what has grown adds 2e-5 of it at most


def disc_shear_compliance(n: np.ndarray, radius: float, material: Material) -> np.ndarray:
    """Tangential displacement of a free solid disc per unit tangential traction sin nθ, less its mean motion.

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


def ring_shear_compliance(n: np.ndarray, loaded_radius: float, held_radius: float, material: Material) -> np.ndarray:
    """Tangential displacement of an annulus, fixed on one circle, per unit tangential traction sin nθ on the other.

    Parameters and errors as of `continuum.ring_harmonic_compliance`; m/Pa.
    """
    n = np.asarray(n)
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

    Parameters and errors as of `continuum.ring_harmonic_compliance`; m/Pa. By Betti it is also what a pressure cos nθ
    moves the surface by along sin nθ.
    """
    n = np.asarray(n)
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
