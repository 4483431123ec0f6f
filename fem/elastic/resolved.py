"""Laws of contacts that the mesh resolves: the layer that keeps the surfaces apart.

And, for comparison, the ordinary contact of a mesh too coarse for it: one penalty spring, straight or between facets.
"""

import sys
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from fem.kernels.state import INNER, OUTER, ROLLER
from lagrange import Bearing, Material

LAYER = 8.0  # stiffness of the layer times the surface spacing, over E*: see docs/verification.md for what it costs
POINTS_PER_NODE = 4


@dataclass(frozen=True, kw_only=True)
class ResolvedLaw:
    """A pair of surfaces in resolved contact."""

    relative_radius: float  # R, m
    half_width_factor: float  # b²/Q = 4R/(π E* L), m²/N (Johnson, Contact Mechanics, 1985, ch. 4)
    layer: float  # pressure per penetration, Pa/m
    spacing: float  # of the points, m
    radii: tuple[float, float]  # of side 0 and side 1, m; a bore's is negative
    thickness: float  # m
    sagitta: tuple[float, float] | None = None  # None: many points on circles; else one, its facets' sagittas h²/8R, m

    spreads = False  # points act on the nodes beside them, not on patches
    most_points = sys.maxsize  # any number

    def half_width(self, force: float) -> float:
        """Hertz half-width b, m."""
        return sqrt(self.half_width_factor * force)

    @property
    def is_one_point(self) -> bool:
        """Whether it is a penalty spring between nodes."""
        return self.sagitta is not None

    @property
    def point_stiffness(self) -> float:
        """Force per penetration of one point, N/m."""
        return self.layer * self.spacing * self.thickness

    def local_compliance(self, n_points: int) -> np.ndarray:
        """The layer's compliance between neighbouring points, (n_points, n_points), m/N."""
        return np.eye(n_points) / self.point_stiffness

    def layer_approach(self, force: float) -> float:
        """What the layer adds to the approach, m: the mean of its deflection weighted with Hertz's pressure."""
        return 8.0 / (3.0 * pi) * 2.0 * force / (pi * self.half_width(force) * self.thickness) / self.layer


def resolved_law(radii: tuple[float, float], materials: tuple[Material, Material], thickness: float, spacing: float):
    """Law of two circles; `spacing` is the finer of the two surfaces', m."""
    modulus = 1.0 / sum(1.0 / material.plane_strain_modulus for material in materials)
    relative = 1.0 / sum(1.0 / radius for radius in radii)
    return ResolvedLaw(
        relative_radius=relative,
        half_width_factor=4.0 * relative / (pi * modulus * thickness),
        layer=LAYER * modulus / spacing,
        spacing=spacing / POINTS_PER_NODE,
        radii=radii,
        thickness=thickness,
    )


def resolved_laws(bearing: Bearing, spacings: dict[str, float]) -> dict[int, ResolvedLaw]:
    """Laws by kind of contact; `spacings` of the surfaces by body, m."""
    roller, inner, outer = bearing.roller, bearing.inner_ring, bearing.outer_ring
    r, length = bearing.roller_radius, bearing.roller_length
    finest = {name: min(spacings[name], spacings["roller"]) for name in ("roller", "inner_ring", "outer_ring")}
    return {
        INNER: resolved_law((bearing.inner_raceway_radius, r), (inner, roller), length, finest["inner_ring"]),
        OUTER: resolved_law((-bearing.outer_raceway_radius, r), (outer, roller), length, finest["outer_ring"]),
        ROLLER: resolved_law((r, r), (roller.elastic, roller.elastic), length, finest["roller"]),
    }


def penalty_laws(
    bearing: Bearing, spacings: dict[str, float], stiffness: float, faceted: bool
) -> dict[int, ResolvedLaw]:
    """Laws by kind of contact: each a spring of a stiffness, N/m, between the nodes around the line of centres.

    With `faceted` surfaces the chords between nodes are in contact instead of the circles; `spacings` by body, m.
    """
    on = {INNER: ("inner_ring", "roller"), OUTER: ("outer_ring", "roller"), ROLLER: ("roller", "roller")}
    found = {}
    for kind, law in resolved_laws(bearing, spacings).items():
        chords = [spacings[body] ** 2 / (8.0 * radius) for body, radius in zip(on[kind], law.radii, strict=True)]
        spacing = POINTS_PER_NODE * law.spacing
        found[kind] = replace(
            law,
            layer=stiffness / (spacing * law.thickness),
            spacing=spacing,
            sagitta=tuple(chords) if faceted else (0.0, 0.0),
        )
    return found
