"""Exact free in-plane vibration of plane-strain discs and rings.

u = ∇φ + curl ψ with φ = f(k_L r) cos nθ and ψ = g(k_T r) sin nθ, f and g Bessel functions of order n; the free
circles want σ_rr = σ_rθ = 0, the held ones u = 0.

Source: Love, A Treatise on the Mathematical Theory of Elasticity (4th ed. 1927), vibrations of a circular cylinder;
Graff, Wave Motion in Elastic Solids (1975), section 8.2 with the axial wavenumber 0.
"""

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv, jvp, yv, yvp

from fem.elastic import vibration
from fem.elastic.continuum import Section
from fem.elastic.vibration import Modes
from lagrange import Material


def disc_frequency(n: int, low: float, high: float, material: Material) -> float:
    """The root ω R/c_T between two bounds of the free solid disc, n waves around."""
    return brentq(lambda x: np.linalg.det(surface_tractions(n, 1.0, x, material, ("j",))), low, high, xtol=1e-12)


def ring_frequency(n: int, inner: float, outer: float, low: float, high: float, material: Material) -> float:
    """The root ω, rad/s, between two bounds of a ring free on both circles."""
    speed = np.sqrt(material.lame_mu / material.density)

    def determinant(omega):
        x = omega * outer / speed
        return _determinant(surface_tractions, n, inner / outer, x, material)

    return brentq(determinant, low, high, rtol=1e-12)


def held_ring_frequencies(n: int, held: float, free: float, high: float, material: Material) -> list[float]:
    """All ω, rad/s, below a bound, of a ring held on one circle and free on the other, n waves around.

    Found as changes of sign on a grid of high/1000: two roots closer than that would be missed.
    """
    speed = np.sqrt(material.lame_mu / material.density)

    def determinant(omega):
        x = omega * free / speed
        return _determinant(surface_displacements, n, held / free, x, material)

    grid = np.linspace(0.0, high, 1001)[10:]
    signs = np.sign([determinant(omega) for omega in grid])
    return [brentq(determinant, *grid[i : i + 2], rtol=1e-12) for i in np.flatnonzero(signs[:-1] != signs[1:])]


def _determinant(condition, n: int, r: float, x: float, material: Material) -> float:
    """Determinant for an annulus with a condition at radius r, free at radius 1, columns scaled to 1."""
    kinds = ("j", "y")
    matrix = np.concatenate([condition(n, r, x, material, kinds), surface_tractions(n, 1.0, x, material, kinds)])
    return np.linalg.det(matrix / np.abs(matrix).max(axis=0))


def surface_displacements(n, r, x, material, kinds):
    """u_r and u_θ at radius r of each potential; x = ω/c_T for unit radius."""
    k_l, k_t = x / np.sqrt(material.lame_lambda / material.lame_mu + 2.0), x
    columns = []
    for kind in kinds:
        f, df = (jv, jvp) if kind == "j" else (yv, yvp)
        columns.append([k_l * df(n, k_l * r), -n * f(n, k_l * r) / r])
        columns.append([n * f(n, k_t * r) / r, -k_t * df(n, k_t * r)])
    return np.array(columns).T


def surface_tractions(n, r, x, material, kinds):
    """σ_rr and σ_rθ (over μ) at radius r of each potential; x = ω/c_T for unit radius."""
    ratio = material.lame_lambda / material.lame_mu
    k_l, k_t = x / np.sqrt(ratio + 2.0), x
    columns = []
    for kind in kinds:
        f, df = (jv, jvp) if kind == "j" else (yv, yvp)
        p, dp, ddp = f(n, k_l * r), k_l * df(n, k_l * r), k_l**2 * df(n, k_l * r, 2)
        # u_r = φ', u_θ = −n φ/r (times cos, sin); div u = −k_l² φ
        columns.append([-ratio * k_l**2 * p + 2.0 * ddp, -2.0 * n * (dp / r - p / r**2)])
        s, ds, dds = f(n, k_t * r), k_t * df(n, k_t * r), k_t**2 * df(n, k_t * r, 2)
        # u_r = n ψ/r, u_θ = −ψ'
        columns.append([2.0 * n * (ds / r - s / r**2), -dds + ds / r - n**2 * s / r**2])
    return np.array(columns).T


def vibrations(section: Section, thickness: float, highest: float, hub: float | None = None) -> Modes:
    """All modes up to a frequency, rad/s, of a disc or ring so thick, m; but for a disc's rotation.

    `hub` : kg, of a rigid body that the held circle moves with; None: it does not move.
    """
    found = []
    for n in range(vibration.MOST_WAVES):
        frequency, into, carried = vibration._of_order(n, section, thickness, hub)
        some = (frequency > vibration.RIGID * highest) & (frequency <= highest)
        found += [(n, *mode) for mode in zip(frequency[some], into[some], carried[some], strict=True)]
        # a surface wave around a disc, or a layer's slowest wave, has its speed from below: none is left beyond
        if n > 2 and frequency[0] > highest:
            break
    table = np.array(found).reshape(-1, 4)
    order, frequency, shape, carried = table.T
    return Modes(order=order.astype(np.intp), frequency=frequency, shape=shape, carried=carried)
