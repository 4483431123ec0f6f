"""Two circles pressed together along a line: which they are, and Hertz's theory of their contact.

Source: Johnson, Contact Mechanics (1985), chapter 4.
"""

from dataclasses import dataclass
from math import pi, sqrt

from lagrange.bearing import Bearing, Material


def line_compliance(material: Material, length: float) -> float:
    """A = 2/(π E' L) of one body, m/N: what ln Q is multiplied by in half its approach; 0 of a rigid one."""
    return 2.0 / (pi * material.plane_strain_modulus * length)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two bodies that may touch: side 0 is the ring, or roller j; side 1 the roller, or roller j + 1."""

    kind: str  # inner, outer (raceway) or roller
    radii: tuple[float, float]  # m; a bore's is negative
    materials: tuple[Material, Material]
    length: float  # m, of the line of contact

    @property
    def relative_radius(self) -> float:
        """R, m: 1/R is the sum of both curvatures."""
        return 1.0 / sum(1.0 / radius for radius in self.radii)

    @property
    def modulus(self) -> float:
        """E*, Pa: 1/E* is the sum of both 1/E'."""
        return 1.0 / sum(1.0 / material.plane_strain_modulus for material in self.materials)

    @property
    def line_compliance(self) -> float:
        """A of both bodies, m/N."""
        return sum(line_compliance(material, self.length) for material in self.materials)

    @property
    def half_width_factor(self) -> float:
        """b²/Q = 4R/(π E* L) = 2RA, m²/N."""
        return 2.0 * self.relative_radius * self.line_compliance

    def half_width(self, force: float) -> float:
        """Half-width b, m, of the contact under a force, N."""
        return sqrt(self.half_width_factor * force)

    def peak_pressure(self, force: float) -> float:
        """Largest pressure p₀ = 2 Q/(π b L), Pa, under a force, N."""
        return 2.0 * force / (pi * self.half_width(force) * self.length) if force > 0.0 else 0.0


def contact_pairs(bearing: Bearing) -> tuple[Pair, Pair, Pair]:
    """Inner raceway and roller, outer raceway and roller, two rollers.

    Two rigid rollers meet with their material's compliance: they would have none otherwise.
    """
    r, roller = bearing.roller_radius, bearing.roller
    inner, outer, rollers = (
        Pair(kind=kind, radii=(radius, r), materials=materials, length=bearing.roller_length)
        for kind, radius, materials in (
            ("inner", bearing.inner_raceway_radius, (bearing.inner_ring, roller)),
            ("outer", -bearing.outer_raceway_radius, (bearing.outer_ring, roller)),
            ("roller", r, (roller.elastic, roller.elastic)),
        )
    )
    return inner, outer, rollers
