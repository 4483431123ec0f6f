"""Elastic bodies by their modes: free vibration, impact, rocking."""

from functools import cache
from math import log, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv, jvp, yv, yvp

from fem.elastic import continuum, vibration
from fem.elastic.continuum import Section, kolosov, stick_approach
from lagrange import Bearing, Material

# ---- Exact free in-plane vibration of plane-strain discs and rings. u = ∇φ + curl ψ with φ = f(k_L r) cos nθ and ψ =
# g(k_T r) sin nθ, f and g Bessel functions of order n; the free circles want σ_rr = σ_rθ = 0, the held ones u = 0.
# Source: Love, A Treatise on the Mathematical Theory of Elasticity (4th ed. 1927), vibrations of a circular cylinder;
# Graff, Wave Motion in Elastic Solids (1975), section 8.2 with the axial wavenumber 0.

BESSEL = {"j": (jv, jvp), "y": (yv, yvp)}


def disc_frequency(n: int, low: float, high: float, material: Material) -> float:
    """The root ω R/c_T between two bounds of the free solid disc, n waves around."""
    return brentq(lambda x: np.linalg.det(surface_tractions(n, 1.0, x, material, "j")), low, high, xtol=1e-12)


def ring_frequencies(n: int, other: float, free: float, low: float, high: float, material: Material, held=False):
    """All ω, rad/s, between two bounds, n waves around, of a ring free on one circle and free, or held, on the other.

    Found as changes of sign on a grid of a thousandth of the upper one: two roots closer than that would be missed.
    """
    speed = sqrt(material.lame_mu / material.density)

    def determinant(omega):
        x, on_other = omega * free / speed, surface_displacements if held else surface_tractions
        rows = [on_other(n, other / free, x, material, "jy"), surface_tractions(n, 1.0, x, material, "jy")]
        matrix = np.concatenate(rows)
        return np.linalg.det(matrix / np.abs(matrix).max(axis=0))

    return _roots(determinant, np.arange(low, high, 1e-3 * high), rtol=1e-12)


def _roots(function, grid: np.ndarray, **error) -> list[float]:
    """Where a function changes its sign on a grid."""
    sign = np.sign([function(at) for at in grid])
    return [brentq(function, *grid[i : i + 2], **error) for i in np.flatnonzero(sign[:-1] != sign[1:])]


def surface_displacements(n, r, x, material, kinds):
    """u_r and u_θ at radius r of each potential; x = ω/c_T for unit radius."""
    k_l, k_t, columns = x / np.sqrt(material.lame_lambda / material.lame_mu + 2.0), x, []
    for f, df in (BESSEL[kind] for kind in kinds):
        columns.append([k_l * df(n, k_l * r), -n * f(n, k_l * r) / r])
        columns.append([n * f(n, k_t * r) / r, -k_t * df(n, k_t * r)])
    return np.array(columns).T


def surface_tractions(n, r, x, material, kinds):
    """σ_rr and σ_rθ (over μ) at radius r of each potential; x = ω/c_T for unit radius."""
    ratio, k_t, columns = material.lame_lambda / material.lame_mu, x, []
    k_l = x / np.sqrt(ratio + 2.0)
    for f, df in (BESSEL[kind] for kind in kinds):
        p, dp, ddp = f(n, k_l * r), k_l * df(n, k_l * r), k_l**2 * df(n, k_l * r, 2)
        # u_r = φ', u_θ = −n φ/r (times cos, sin); div u = −k_l² φ
        columns.append([-ratio * k_l**2 * p + 2.0 * ddp, -2.0 * n * (dp / r - p / r**2)])
        s, ds, dds = f(n, k_t * r), k_t * df(n, k_t * r), k_t**2 * df(n, k_t * r, 2)
        # u_r = n ψ/r, u_θ = −ψ'
        columns.append([2.0 * n * (ds / r - s / r**2), -dds + ds / r - n**2 * s / r**2])
    return np.array(columns).T


class Vibrations(NamedTuple):
    """`fem.elastic.vibration.Modes` of any number of waves around."""

    order: np.ndarray
    frequency: np.ndarray
    shape: np.ndarray
    carried: np.ndarray


RADIAL, AROUND = 0, 1


def receptance(section: Section, n: int, omega: float, way: int) -> float:
    """Displacement of a held ring's or a free disc's circle per traction of n waves on it, both RADIAL, outwards of a
    disc, or AROUND, at a frequency, rad/s; m/Pa."""
    loaded, held, material, _ = section
    x, kinds = omega * loaded / np.sqrt(material.lame_mu / material.density), "jy" if held else "j"
    conditions, wanted = surface_tractions(n, 1.0, x, material, kinds), np.eye(2)[way]
    if held:
        conditions = np.concatenate([surface_displacements(n, held / loaded, x, material, kinds), conditions])
        wanted = np.append([0.0, 0.0], wanted)
    scale = np.abs(conditions).max(axis=0)
    weights = np.linalg.solve(conditions / scale, wanted) / scale
    moved = float(surface_displacements(n, 1.0, x, material, kinds)[way] @ weights)
    return section.convexity * loaded / material.lame_mu * moved


def vibrations(section: Section, thickness: float, highest: float, hub: float | None = None) -> Vibrations:
    """All modes up to a frequency, rad/s, of a disc or ring so thick, m; but for a disc's rotation.

    `hub` : kg, of a rigid body that the held circle moves with; None: it does not move.
    """
    found = []
    for n in range(vibration.MOST_WAVES):
        frequency, into, carried = vibration.modes_of(n, section, thickness, hub)
        some = (frequency > vibration.RIGID * highest) & (frequency <= highest)
        found += [(n, *mode) for mode in zip(frequency[some], into[some], carried[some], strict=True)]
        # a surface wave around a disc, or a layer's slowest wave, has its speed from below: none is left beyond
        if n > 2 and frequency[0] > highest:
            break
    return Vibrations(*np.array(found).reshape(-1, 4).T)


def pressed_ring(inner: float, outer: float, material: Material, bed: float, interference: float) -> tuple:
    """Pressure, Pa, and how far raceway and outside of a ring move, m, that is larger than its bore by so much, m.

    `bed` : of the bore, Pa/m. Source: Timoshenko and Goodier (1970), section 28 (Lamé), plane strain.
    """
    modulus, area = material.youngs_modulus / (1.0 - material.poisson_ratio**2), outer**2 - inner**2
    ratio = material.poisson_ratio / (1.0 - material.poisson_ratio)
    outside = outer / modulus * ((outer**2 + inner**2) / area - ratio)
    pressure = interference / (outside + 1.0 / bed)
    return pressure, -2.0 * inner * outer**2 / (modulus * area) * pressure, -outside * pressure


# ---- A free elastic disc thrown at a rigid frictionless flat: its exact vibration modes driven by a Hertz contact.
# The displacement at the contact is the static one (Johnson's, for two opposite line loads, less what the far load
# does) with the share of the lowest modes replaced by these modes' motion. Nothing is meshed. Source: Johnson,
# Contact Mechanics (1985), 5.6; Michell's series for the disc (Timoshenko and Goodier, Theory of Elasticity, chapter
# 4); modes as above.

LARGEST_N = 16  # waves around
LARGEST_ROOT = 40.0  # ω R/c_T
ROOT_SPACING = 0.02  # of the search
TIME_STEP = 2e-9  # s


class Impact(NamedTuple):
    """Numbers that describe an impact."""

    force: float  # largest, N
    duration: float  # s
    rebound: float  # speed of the centre of mass after over before


@cache
def disc_modes(n: int, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Roots ω R/c_T of n waves around, and each mode's static compliance at the surface, times μ and length.

    The compliance, a residue of the receptance, is U²/(M ω²) with U the radial displacement at the surface, M the modal
    mass; a line load has 1/π of each wave, half as much of none.
    """

    def condition(x):
        tractions = surface_tractions(n, 1.0, x, material, "j")
        return tractions[0, 0] if n == 0 else np.linalg.det(tractions)  # at n = 0 torsion stands apart

    grid = np.arange(max(0.3, 0.5 * n if n > 2 else 0.0), LARGEST_ROOT, ROOT_SPACING)
    roots = np.array(_roots(condition, grid, xtol=1e-12))
    disc, speed, unit = Section(1.0, 0.0, material), sqrt(material.lame_mu / material.density), material.lame_mu / pi
    near = [[(1.0 - share**2) * receptance(disc, n, share * root * speed, RADIAL) for share in (1.0 - 1e-5, 1.0 + 1e-5)]
            for root in roots]  # fmt: skip
    return roots, np.mean(near, axis=1) * (0.5 * unit if n == 0 else unit)


def static_compliance(n: int, material: Material) -> float:
    """All modes of n waves together, as `disc_modes` gives them: Michell's series for cos nθ, the mean motion apart."""
    kappa = kolosov(material)
    bracket = 0.5 * (kappa - 1.0) if n == 1 else kappa / (n + 1.0) + 1.0 / (n - 1.0)
    return bracket / (4.0 * pi * (2.0 if n == 0 else 1.0))


def _far_load(material: Material) -> float:
    """Σ (−1)^n of the static compliances: displacement under one load by the opposite one, times μ and length."""
    # Σ_{n≥2} (−1)^n/(n+1) = ln 2 − ½ and Σ_{n≥2} (−1)^n/(n−1) = ln 2
    tail = (kolosov(material) * (log(2.0) - 0.5) + log(2.0)) / (4.0 * pi)
    return static_compliance(0, material) - static_compliance(1, material) + tail


def thrown_at_flat(speed: float, radius: float, length: float, material: Material) -> Impact:
    """Follow a disc from its first touch at `speed`, m/s, until it leaves.

    Errors
    ------
    0.1 % of force and time, by the modes left out and the time step.
    """
    roots, compliance = (np.concatenate(of) for of in zip(*(disc_modes(n, material) for n in range(LARGEST_N + 1)),
                                                          strict=True))  # fmt: skip
    compliance = compliance / (material.lame_mu * length)
    omega = roots * sqrt(material.lame_mu / material.density) / radius
    mass, modulus = material.density * pi * radius**2 * length, material.plane_strain_modulus
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


# ---- Exact free vibrations of rollers that stick to both raceways, and roll and shift along them all alike. A roller
# meets the raceways at opposite ends of a diameter, with tangential motions v_i, v_o of its surface by tractions T_i,
# T_o, all counter-clockwise, at a frequency: v_i = D T_i + X T_o, v_o = X T_i + D T_o, and the rings' −G_i T_i = v_i,
# −G_o T_o = v_o D is what one traction does, D + X what two equal ones do. Each is a sum over harmonics: the static
# one under a traction that sticks (`fem.elastic.continuum`), and what inertia changes of its lower harmonics, by
# Bessel functions; a free disc moves as a whole in the harmonics 0 and 1. With all rollers alike a ring has the
# harmonics that are multiples of their number. Motion along the line of centres is symmetric about it and has no part
# in this.

HARMONICS = 30  # what inertia changes of them falls as 1/n³


def inertial(section: Section, omega: float) -> float:
    """What contacts that stick move more at a frequency, rad/s, than at rest, m per N/m of each."""
    found = 0.0
    for n in range(0, HARMONICS, section.loads):
        more = receptance(section, n, omega, AROUND) - float(continuum.shear_compliance(section, np.array([n]))[0])
        found += section.loads / (pi * section.loaded) * (0.5 if n == 0 else 1.0) * more
    return found


def sticking_modes(bearing: Bearing, force: float, low: float = 20e3, high: float = 100e3) -> list[float]:
    """Frequencies between two bounds, Hz, with a normal force, N, on every contact: shifting, then rocking.

    Found as changes of sign on a grid of 500 Hz: two as close as that would be missed.
    """
    one, two, static = continuum.roller_section(bearing), continuum.roller_section(bearing).squeezed, np.empty((2, 2))
    rings = [section._replace(loads=bearing.n_rollers) for section in continuum.ring_sections(bearing)]
    for i, (section, sign) in enumerate(zip(rings, (1.0, -1.0), strict=True)):
        curvature = 1.0 / bearing.roller_radius + sign / section.loaded
        softness = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / section.material.plane_strain_modulus
        half_width = np.sqrt(4.0 * force * softness / (pi * curvature * bearing.roller_length))
        static[i, i] = stick_approach(one, half_width) + stick_approach(section, half_width)
        static[i, 1 - i] = stick_approach(two, half_width) - stick_approach(one, half_width)

    def determinant(frequency: float) -> float:
        omega = 2.0 * pi * frequency
        own, both = inertial(one, omega), inertial(two, omega)
        matrix = static + np.diag([inertial(section, omega) for section in rings])
        matrix = matrix + np.array([[own, both - own], [both - own, own]])
        return np.linalg.det(matrix * bearing.roller.plane_strain_modulus)

    grid = np.arange(low, high, 500.0)
    usual = np.median(np.abs([determinant(frequency) for frequency in grid]))
    roots = _roots(determinant, grid, rtol=1e-10)
    return [root for root in roots if abs(determinant(root)) < 1e-3 * usual]  # the rest are poles
