"""A load that rolls along a surface: the material that flows through a contact has inertia, and gives way by more."""

from math import sqrt

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
