"""A free elastic disc thrown at a rigid frictionless flat: its exact vibration modes driven by a Hertz contact.

The displacement at the contact is the static one (Johnson's, for two opposite line loads, less what the far load does)
with the share of the lowest modes replaced by these modes' motion. Nothing is meshed.

Source: Johnson, Contact Mechanics (1985), 5.6; Michell's series for the disc (Timoshenko and Goodier, Theory of
Elasticity, chapter 4); modes as in `free_vibration`.
"""

from dataclasses import dataclass
from functools import cache
from math import log, pi, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv, jvp

from lagrange import Material
from tests.reference.free_vibration import surface_tractions

LARGEST_N = 16  # waves around
LARGEST_ROOT = 40.0  # ω R/c_T
ROOT_SPACING = 0.02  # of the search
TIME_STEP = 2e-9  # s
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


@dataclass(frozen=True, kw_only=True)
class Impact:
    """Numbers that describe an impact."""

    force: float  # largest, N
    duration: float  # s
    rebound: float  # speed of the centre of mass after over before


@cache
def disc_modes(n: int, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Roots ω R/c_T of n waves around, and each mode's static compliance at the surface, times μ and length.

    The compliance is U²/(M ω²) with U the radial displacement at the surface, M the modal mass.
    """

    def condition(x):
        tractions = surface_tractions(n, 1.0, x, material, ("j",))
        return tractions[0, 0] if n == 0 else np.linalg.det(tractions)  # at n = 0 torsion stands apart

    at = np.arange(max(0.3, 0.5 * n if n > 2 else 0.0), LARGEST_ROOT, ROOT_SPACING)
    values = np.array([condition(x) for x in at])
    crossings = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    roots = np.array([brentq(condition, at[i], at[i + 1], xtol=1e-12) for i in crossings])
    return roots, np.array([_compliance(n, x, material) for x in roots])


def _compliance(n: int, x: float, material: Material) -> float:
    r = np.append(0.5 * (NODES + 1.0), 1.0)
    a, b = _mixture(n, x, material)
    k_l, k_t = x / sqrt(material.lame_lambda / material.lame_mu + 2.0), x
    radial = a * k_l * jvp(n, k_l * r) + b * n * jv(n, k_t * r) / r
    tangential = -a * n * jv(n, k_l * r) / r - b * k_t * jvp(n, k_t * r)
    square = (radial**2 + tangential**2)[:-1]
    mass = pi * (2.0 if n == 0 else 1.0) * np.sum(0.5 * WEIGHTS * r[:-1] * square)
    return radial[-1] ** 2 / (mass * x**2)


def _mixture(n: int, x: float, material: Material) -> tuple[float, float]:
    """Shares of the two potentials in a mode: the null vector of the tractions."""
    if n == 0:
        return 1.0, 0.0
    tractions = surface_tractions(n, 1.0, x, material, ("j",))
    scale = np.abs(tractions).max(axis=0)
    a, b = np.linalg.svd(tractions / scale)[2][-1] / scale
    return float(a), float(b)


def static_compliance(n: int, material: Material) -> float:
    """All modes of n waves together, as `disc_modes` gives them: Michell's series for cos nθ, the mean motion apart."""
    kappa = 3.0 - 4.0 * material.poisson_ratio
    bracket = 0.5 * (kappa - 1.0) if n == 1 else kappa / (n + 1.0) + 1.0 / (n - 1.0)
    return bracket / (4.0 * pi * (2.0 if n == 0 else 1.0))


def _far_load(material: Material) -> float:
    """Σ (−1)^n of the static compliances: displacement under one load by the opposite one, times μ and length."""
    kappa = 3.0 - 4.0 * material.poisson_ratio
    # Σ_{n≥2} (−1)^n/(n+1) = ln 2 − ½ and Σ_{n≥2} (−1)^n/(n−1) = ln 2
    tail = (kappa * (log(2.0) - 0.5) + log(2.0)) / (4.0 * pi)
    return static_compliance(0, material) - static_compliance(1, material) + tail


def thrown_at_flat(speed: float, radius: float, length: float, material: Material) -> Impact:
    """Follow a disc from its first touch at `speed`, m/s, until it leaves.

    Errors
    ------
    0.1 % of force and time, by the modes left out and the time step.
    """
    families = [disc_modes(n, material) for n in range(LARGEST_N + 1)]
    roots = np.concatenate([family[0] for family in families])
    compliance = np.concatenate([family[1] for family in families]) / (material.lame_mu * length)
    omega = roots * sqrt(material.lame_mu / material.density) / radius
    mass = material.density * pi * radius**2 * length
    modulus = material.plane_strain_modulus
    moving = compliance.sum() + _far_load(material) / (material.lame_mu * length)

    def at_rest(force):
        """Displacement of all that follows at once, m, and its slope."""
        bracket = 2.0 * log(4.0 * radius) - log(4.0 * force * radius / (pi * modulus * length))
        unit = 1.0 / (pi * modulus * length)
        return force * (unit * (bracket - 1.0) - moving), unit * (bracket - 2.0) - moving

    turn, dt = np.exp(-1j * omega * TIME_STEP), TIME_STEP
    state = np.zeros(omega.size, dtype=complex)  # displacement of each mode + i rate/ω
    depth, rate, force, steps, largest = 0.0, speed, 1e-3, 0, 0.0
    while True:
        closing = depth - state.real.sum()
        force = _force(closing, at_rest, force) if closing > 0.0 else 0.0
        if force == 0.0 and rate < 0.0:
            return Impact(force=largest, duration=steps * dt, rebound=-rate / speed)
        largest = max(largest, force)
        rate -= force / mass * dt
        depth += rate * dt
        state = (state + 1j * omega * compliance * force * dt) * turn
        steps += 1


def _force(closing: float, law, guess: float) -> float:
    """Force of a law δ(Q), by Newton's method."""
    force = max(guess, 1e-6)
    for _ in range(60):
        value, slope = law(force)
        new = max(force - (value - closing) / slope, 0.1 * force)
        if abs(new - force) <= 1e-10 * new:
            return new
        force = new
    raise RuntimeError(f"no force for an approach of {closing:.3e} m")
