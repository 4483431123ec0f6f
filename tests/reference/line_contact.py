"""Line contact of elastic cylinders: textbook formulas and the quasi-static impact they give.

Source: Johnson, Contact Mechanics (1985): half-width of section 4.2(c), approach of a disc squeezed by two opposite
line loads of section 5.6, creep of rolling cylinders of section 8.3 (Carter 1926).
"""

from math import log, pi, sqrt

from scipy.integrate import quad
from scipy.optimize import brentq


def half_width(line_load: float, relative_radius: float, contact_modulus: float) -> float:
    """b, m, of a load in N/m; 1/contact_modulus = Σ (1 − ν²)/E."""
    return sqrt(4.0 * line_load * relative_radius / (pi * contact_modulus))


def squeezed_disc_approach(line_load: float, radius: float, half_width: float, modulus: float) -> float:
    """Approach of one contact towards the centre of a disc, m; modulus E/(1 − ν²)."""
    return line_load / (pi * modulus) * (2.0 * log(4.0 * radius / half_width) - 1.0)


def carter_creep(traction_ratio: float, friction: float, half_width: float, relative_radius: float) -> float:
    """Creep (slip velocity over rolling speed) at a share of the limiting traction."""
    return friction * half_width / relative_radius * (1.0 - sqrt(1.0 - traction_ratio))


def impact_on_rigid_flat(speed: float, radius: float, length: float, mass: float, modulus: float):
    """Quasi-static impact of a cylinder: largest approach, m, largest force, N, contact time, s."""

    def approach(force):
        q = force / length
        return squeezed_disc_approach(q, radius, half_width(q, radius, modulus), modulus)

    def slope(force):  # dδ/dQ: b grows as sqrt(Q), which takes 1 off the bracket
        q = force / length
        return (2.0 * log(4.0 * radius / half_width(q, radius, modulus)) - 2.0) / (pi * modulus * length)

    def energy(force):
        return quad(lambda x: x * slope(x), 0.0, force, epsrel=1e-10)[0]

    kinetic = 0.5 * mass * speed**2
    top = brentq(lambda force: energy(force) - kinetic, 1e-6, 1e6)

    # t = 2 ∫ dδ/v; with Q = top (1 − s²) the root at the turning point goes
    def integrand(s):
        force = top * (1.0 - s * s)
        return slope(force) * 2.0 * s * top / sqrt(2.0 * (kinetic - energy(force)) / mass)

    time = 2.0 * quad(integrand, 1e-4, 1.0 - 1e-12, epsrel=1e-6, limit=200)[0]
    return approach(top), top, time
