"""Two circular bodies pressed together without Hertz's theory: pressures on strips, the gap closed at each.

Displacements are those of whole bodies by their angular harmonics, so that what differs from Hertz's theory is the
shape of the pressure and of the bodies' own displacement across the contact. The gap is a parabola.
"""

from collections.abc import Callable

import numpy as np

Compliance = Callable[[np.ndarray], np.ndarray]  # of n waves around, m/Pa

PER_STRIP = 40  # harmonics, of the waves that a strip's width has


def approach(
    sides: tuple[tuple[float, Compliance], ...], relative_radius: float, line_load: float, reach: float, strips: int
) -> float:
    """Approach, m, under a load, N/m, of bodies that are a radius, m, and a compliance each.

    `reach`, m: half of what strips cover, more than the contact. Errors: of second order in a strip's width.
    """
    width = 2.0 * reach / strips
    x = (np.arange(strips) + 0.5) * width - reach
    near = sum(_influence(radius, compliance, width, strips) for radius, compliance in sides)
    i = np.arange(strips)
    influence = near[np.abs(i[:, None] - i)]
    gap = (x**2 + width**2 / 12.0) / (2.0 * relative_radius)  # means over strips
    closed = np.ones(strips, dtype=bool)
    while True:
        n = int(closed.sum())
        system = np.ones((n + 1, n + 1))
        system[:n, :n], system[:n, n], system[n, n] = influence[np.ix_(closed, closed)], -1.0, 0.0
        *loads, found = np.linalg.solve(system, [*-gap[closed], line_load])
        pulling = np.flatnonzero(closed)[np.array(loads) < 0.0]
        if not pulling.size:
            return float(found)
        closed[pulling] = False


def _influence(radius: float, compliance: Compliance, width: float, strips: int) -> np.ndarray:
    """Mean displacement of strips, so many away, under a unit line load spread over one, m per N/m."""
    n = np.arange(int(PER_STRIP * radius / width) + 1)
    amplitude = compliance(n) * np.sinc(n * width / (2.0 * np.pi * radius)) ** 2
    amplitude[0] *= 0.5
    return np.cos(np.outer(np.arange(strips) * width / radius, n)) @ amplitude / (np.pi * radius)
