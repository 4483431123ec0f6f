"""Exact free vibrations of rollers that stick to both raceways, and roll and shift along them all alike.

A roller meets the raceways at opposite ends of a diameter, with tangential motions v_i, v_o of its surface by tractions
T_i, T_o, all counter-clockwise, at a frequency:

    v_i = D T_i + X T_o,   v_o = X T_i + D T_o,   and the rings'   −G_i T_i = v_i,   −G_o T_o = v_o

D is what one traction does, D + X what two equal ones do. Each is a sum over harmonics: the static one under a traction
that sticks (`fem.elastic.tangential`), and what inertia changes of its lower harmonics, by Bessel functions; a free
disc moves as a whole in the harmonics 0 and 1. With all rollers alike a ring has the harmonics that are multiples of
their number. Motion along the line of centres is symmetric about it and has no part in this.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import pi

import numpy as np
from scipy.optimize import brentq

from fem.elastic.continuum import hertz_centre
from fem.elastic.tangential import disc_shear_compliance, ring_shear_compliance
from lagrange import Bearing, Material
from tests.reference.free_vibration import surface_displacements, surface_tractions

HARMONICS = 30  # what inertia changes of them falls as 1/n³


def disc_shear_receptance(n: int, radius: float, material: Material, omega: float) -> float:
    """Tangential displacement of a free disc per tangential traction sin nθ at a frequency, m/Pa."""
    x = omega * radius / np.sqrt(material.lame_mu / material.density)
    tractions = surface_tractions(n, 1.0, x, material, ("j",))
    scale = np.abs(tractions).max(axis=0)
    weights = np.linalg.solve(tractions / scale, [0.0, 1.0]) / scale
    return radius / material.lame_mu * float(surface_displacements(n, 1.0, x, material, ("j",))[1] @ weights)


def ring_shear_receptance(n: int, loaded: float, held: float, material: Material, omega: float) -> float:
    """The same of a ring on its loaded circle, the other one held; radii in m."""
    x, kinds = omega * loaded / np.sqrt(material.lame_mu / material.density), ("j", "y")
    conditions = np.concatenate(
        [surface_displacements(n, held / loaded, x, material, kinds), surface_tractions(n, 1.0, x, material, kinds)]
    )
    scale = np.abs(conditions).max(axis=0)
    weights = np.linalg.solve(conditions / scale, [0.0, 0.0, 0.0, 1.0]) / scale
    around = float(surface_displacements(n, 1.0, x, material, kinds)[1] @ weights)
    return np.sign(loaded - held) * loaded / material.lame_mu * around


@dataclass(frozen=True, kw_only=True)
class Surface:
    """Evenly spaced contacts of a body that stick, all pushed alike."""

    radius: float  # m
    material: Material
    patches: int
    compliance: Callable[[np.ndarray], np.ndarray]  # of harmonics, static, m/Pa
    receptance: Callable[..., float]  # of a harmonic, at `omega`
    convexity: float = 1.0

    def static(self, half_width: float) -> float:
        """Motion, m per N/m of each, that does not accelerate anything; it sticks: less than a semi-ellipse moves."""
        found = hertz_centre(
            self.compliance, self.radius, self.material, half_width, self.patches, self.convexity
        )  # fmt: skip
        return found - 1.0 / (pi * self.material.plane_strain_modulus)

    def inertial(self, omega: float) -> float:
        """What it moves more at a frequency, rad/s."""
        found = 0.0
        for n in range(0, HARMONICS, self.patches):
            more = self.receptance(n, omega=omega) - float(self.compliance(np.array([n]))[0])
            found += self.patches / (pi * self.radius) * (0.5 if n == 0 else 1.0) * more
        return found


def _disc(radius: float, material: Material, patches: int) -> Surface:
    how = {"radius": radius, "material": material}
    compliance, receptance = partial(disc_shear_compliance, **how), partial(disc_shear_receptance, **how)
    return Surface(**how, patches=patches, compliance=compliance, receptance=receptance)


def _ring(loaded: float, held: float, material: Material, patches: int) -> Surface:
    return Surface(
        radius=loaded,
        material=material,
        patches=patches,
        compliance=partial(ring_shear_compliance, loaded_radius=loaded, held_radius=held, material=material),
        receptance=partial(ring_shear_receptance, loaded=loaded, held=held, material=material),
        convexity=np.sign(loaded - held),
    )


def sticking_modes(bearing: Bearing, force: float, low: float = 20e3, high: float = 100e3) -> list[float]:
    """Frequencies between two bounds, Hz, with a normal force, N, on every contact: shifting, then rocking.

    Found as changes of sign on a grid of 500 Hz: two as close as that would be missed.
    """
    one, two = (_disc(bearing.roller_radius, bearing.roller, patches) for patches in (1, 2))
    rings = (
        _ring(bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring, bearing.n_rollers),
        _ring(bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring, bearing.n_rollers),
    )
    static = np.empty((2, 2))
    for i, (ring, sign) in enumerate(zip(rings, (1.0, -1.0), strict=True)):
        curvature = 1.0 / bearing.roller_radius + sign / ring.radius
        softness = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / ring.material.plane_strain_modulus
        half_width = np.sqrt(4.0 * force * softness / (pi * curvature * bearing.roller_length))
        static[i, i] = one.static(half_width) + ring.static(half_width)
        static[i, 1 - i] = two.static(half_width) - one.static(half_width)

    def determinant(frequency: float) -> float:
        omega = 2.0 * pi * frequency
        own, both = one.inertial(omega), two.inertial(omega)
        on_rings = np.diag([ring.inertial(omega) for ring in rings])
        matrix = static + on_rings + np.array([[own, both - own], [both - own, own]])
        return np.linalg.det(matrix * bearing.roller.plane_strain_modulus)

    grid = np.arange(low, high, 500.0)
    values = np.array([determinant(frequency) for frequency in grid])
    crossings = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    roots = [brentq(determinant, *grid[i : i + 2], rtol=1e-10) for i in crossings]
    return [root for root in roots if abs(determinant(root)) < 1e-3 * np.median(np.abs(values))]  # the rest are poles
