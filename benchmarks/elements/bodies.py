"""The paper's roller and rings: their exact compliance, coupling and frequencies."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import pi

import numpy as np

from benchmarks.elements.discretisations import Discrete
from benchmarks.verification.elastic_bodies import exact_disc_frequencies
from benchmarks.verification.shapes import LENGTH, STEEL, paper
from fem.elastic import continuum
from tests.reference.free_vibration import held_ring_frequencies

HALF_WIDTH = 0.002  # of the smooth pressure, m
HARMONICS = np.arange(400)  # a spline so wide on both sides needs some 15 R/a
NARROW = 0.01  # half-width of a Hertz contact over the roller's radius
NARROW_HARMONICS = np.arange(20_000)
RING_WAVES = range(7)  # around a ring, of the modes that are compared


@dataclass(frozen=True, kw_only=True)
class Body:
    """A roller, free, or a ring, held on its other circle."""

    name: str
    raceway: float  # radius of the loaded surface, m
    held: float | None  # radius, m

    @property
    def circles(self) -> tuple[float, float]:
        """Inner and outer radius, m."""
        return (0.0, self.raceway) if self.held is None else tuple(sorted((self.held, self.raceway)))

    @property
    def area(self) -> float:
        inner, outer = self.circles
        return pi * (outer**2 - inner**2)

    @property
    def outward(self) -> float:
        """Direction of a load along the radius: −1 into a convex surface."""
        return 1.0 if self.held and self.held > self.raceway else -1.0

    def free(self, discrete: Discrete) -> np.ndarray:
        """Degrees of freedom that move."""
        radius = np.hypot(*discrete.points.T)
        is_free = np.ones(radius.size, dtype=bool) if self.held is None else np.abs(radius - self.held) > 1e-9
        return np.flatnonzero(np.repeat(is_free, 2))

    @property
    def loads(self) -> tuple[float, ...]:
        """Angles of the loads, rad: a roller is squeezed by two, a ring pushed by one."""
        return (0.0, pi) if self.held is None else (0.0,)

    @property
    def apart(self) -> float:
        """Angle from a load to where its coupling is looked at, rad: a quarter of a roller, a pitch on a ring."""
        return 0.5 * pi if self.held is None else 2.0 * pi / paper().n_rollers

    def exact_compliance(self) -> float:
        """Displacement under one of the loads, a smooth pressure, averaged by it, m/N."""
        return self._displacement(continuum.cubic_bspline_patch(HARMONICS, HALF_WIDTH, self.raceway), 0.0)

    def exact_coupling(self) -> float:
        """Displacement at `apart` from a load, m/N, both Hertz's pressures of half-width NARROW·(roller's radius)."""
        half_width = NARROW * paper().roller_radius
        return self._displacement(continuum.hertz_patch(NARROW_HARMONICS, half_width, self.raceway), self.apart)

    def exact_approach(self) -> float:
        """Displacement under the middle of one of the loads, such Hertz pressures, m/N."""
        half_width = NARROW * paper().roller_radius
        if self.held is None:
            return continuum.disc_hertz_approach(self.raceway, STEEL, half_width) / LENGTH
        return continuum.ring_hertz_approach(self.raceway, self.held, STEEL, half_width) / LENGTH

    def _displacement(self, load: np.ndarray, angle: float) -> float:
        n = np.arange(load.size)
        if self.held is None:
            series = continuum.disc_harmonic_compliance(n, self.raceway, STEEL)
        else:
            series = continuum.ring_harmonic_compliance(n, self.raceway, self.held, STEEL)
        parts = [continuum.patch_displacement(series, load, load, self.raceway, angle - at) for at in self.loads]
        return sum(parts) / LENGTH

    @cached_property
    def exact_frequencies(self) -> np.ndarray:
        """The lowest ω, rad/s, above rigid motions, ascending."""
        if self.held is None:
            return exact_disc_frequencies() * np.sqrt(STEEL.lame_mu / STEEL.density) / self.raceway
        highest = 4.0 * STEEL.dilatational_wave_speed / abs(self.raceway - self.held)
        lowest = [held_ring_frequencies(n, self.held, self.raceway, highest, STEEL)[0] for n in RING_WAVES]
        return np.sort(np.repeat(lowest, [1] + [2] * (len(lowest) - 1)))


@cache
def paper_bodies() -> tuple[Body, Body, Body]:
    bearing = paper()
    return (
        Body(name="roller", raceway=bearing.roller_radius, held=None),
        Body(name="inner ring", raceway=bearing.inner_raceway_radius, held=bearing.bore_radius),
        Body(name="outer ring", raceway=bearing.outer_raceway_radius, held=bearing.outside_radius),
    )
