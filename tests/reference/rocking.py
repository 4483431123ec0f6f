"""Exact free vibrations of rollers that stick to both raceways, and roll and shift along them all alike.

A roller meets the raceways at opposite ends of a diameter, with tangential motions v_i, v_o of its surface by tractions
T_i, T_o, all counter-clockwise, at a frequency:

    v_i = D T_i + X T_o,   v_o = X T_i + D T_o,   and the rings'   −G_i T_i = v_i,   −G_o T_o = v_o

D is what one traction does, D + X what two equal ones do. Each is a sum over harmonics: the static one under a traction
that sticks (`fem.elastic.continuum`), and what inertia changes of its lower harmonics, by Bessel functions; a free
disc moves as a whole in the harmonics 0 and 1. With all rollers alike a ring has the harmonics that are multiples of
their number. Motion along the line of centres is symmetric about it and has no part in this.
"""

from math import pi

import numpy as np
from scipy.optimize import brentq

from fem.elastic.continuum import Section, ring_sections, roller_section, shear_compliance, stick_approach
from lagrange import Bearing
from tests.reference.free_vibration import surface_displacements, surface_tractions

HARMONICS = 30  # what inertia changes of them falls as 1/n³


def shear_receptance(section: Section, n: int, omega: float) -> float:
    """Tangential displacement of a held ring or a free disc per traction sin nθ at a frequency, rad/s; m/Pa."""
    loaded, held, material, _ = section
    x, kinds = omega * loaded / np.sqrt(material.lame_mu / material.density), ("j", "y") if held else ("j",)
    conditions, wanted = surface_tractions(n, 1.0, x, material, kinds), [0.0, 1.0]
    if held:
        conditions = np.concatenate([surface_displacements(n, held / loaded, x, material, kinds), conditions])
        wanted = [0.0, 0.0, *wanted]
    scale = np.abs(conditions).max(axis=0)
    weights = np.linalg.solve(conditions / scale, wanted) / scale
    around = float(surface_displacements(n, 1.0, x, material, kinds)[1] @ weights)
    return section.convexity * loaded / material.lame_mu * around


def inertial(section: Section, omega: float) -> float:
    """What contacts that stick move more at a frequency, rad/s, than at rest, m per N/m of each."""
    found = 0.0
    for n in range(0, HARMONICS, section.loads):
        more = shear_receptance(section, n, omega) - float(shear_compliance(section, np.array([n]))[0])
        found += section.loads / (pi * section.loaded) * (0.5 if n == 0 else 1.0) * more
    return found


def sticking_modes(bearing: Bearing, force: float, low: float = 20e3, high: float = 100e3) -> list[float]:
    """Frequencies between two bounds, Hz, with a normal force, N, on every contact: shifting, then rocking.

    Found as changes of sign on a grid of 500 Hz: two as close as that would be missed.
    """
    one, two = roller_section(bearing), roller_section(bearing).squeezed
    rings = [ring._replace(loads=bearing.n_rollers) for ring in ring_sections(bearing)]
    static = np.empty((2, 2))
    for i, (ring, sign) in enumerate(zip(rings, (1.0, -1.0), strict=True)):
        curvature = 1.0 / bearing.roller_radius + sign / ring.loaded
        softness = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / ring.material.plane_strain_modulus
        half_width = np.sqrt(4.0 * force * softness / (pi * curvature * bearing.roller_length))
        static[i, i] = stick_approach(one, half_width) + stick_approach(ring, half_width)
        static[i, 1 - i] = stick_approach(two, half_width) - stick_approach(one, half_width)

    def determinant(frequency: float) -> float:
        omega = 2.0 * pi * frequency
        own, both = inertial(one, omega), inertial(two, omega)
        on_rings = np.diag([inertial(ring, omega) for ring in rings])
        matrix = static + on_rings + np.array([[own, both - own], [both - own, own]])
        return np.linalg.det(matrix * bearing.roller.plane_strain_modulus)

    grid = np.arange(low, high, 500.0)
    values = np.array([determinant(frequency) for frequency in grid])
    crossings = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    roots = [brentq(determinant, *grid[i : i + 2], rtol=1e-10) for i in crossings]
    return [root for root in roots if abs(determinant(root)) < 1e-3 * np.median(np.abs(values))]  # the rest are poles
