"""A bearing made discrete: three kinds of body and the laws of their contacts."""

from dataclasses import dataclass
from math import pi, sqrt

from fem.elastic.bodies import DiscBody, RingBody, disc_body, ring_body
from fem.elastic.resolved import ResolvedLaw, penalty_laws, resolved_laws
from fem.elastic.rigid import rigid_body
from fem.elastic.spread import SpreadLaw, spread_laws
from fem.elastic.subgrid import (
    ContactLaw,
    SurfaceCompliance,
    contact_law,
    disc_compliance,
    ring_compliance,
    unmeshed_disc,
)
from fem.kernels.state import INNER, OUTER, ROLLER
from lagrange import Bearing
from meshes import BearingShapes, bearing_shapes, graded_shapes

# the sub-grid constants hold for any narrow contact; they are evaluated at this share of a roller's radius
REFERENCE_HALF_WIDTH = 0.01


@dataclass(frozen=True, kw_only=True)
class Model:
    """Everything about a bearing that its mesh decides."""

    bearing: Bearing
    roller: DiscBody
    inner_ring: RingBody
    outer_ring: RingBody
    inner_law: ContactLaw | SpreadLaw | ResolvedLaw  # inner raceway and roller
    outer_law: ContactLaw | SpreadLaw | ResolvedLaw  # roller and outer raceway
    roller_law: ContactLaw | SpreadLaw | ResolvedLaw  # two rollers
    # of contacts below the grid only
    roller_surface: SurfaceCompliance | None = None
    inner_surface: SurfaceCompliance | None = None
    outer_surface: SurfaceCompliance | None = None

    @property
    def is_resolved(self) -> bool:
        """Whether pressure points carry the contacts, or a spring between nodes, and not a law below the grid."""
        return self.roller_surface is None

    @property
    def n_nodes(self) -> int:
        """Of the elastic bodies."""
        rings = sum(ring.n_rows * ring.n_sectors for ring in self._elastic_rings)
        return self.bearing.n_rollers * (0 if self.roller.material.rigid else self.roller.n_nodes) + rings

    @property
    def degrees_of_freedom(self) -> int:
        """Free ones: two per node off the held circles, two of the hub, three of a rigid roller."""
        rings = sum((ring.n_rows - 1) * ring.n_sectors for ring in self._elastic_rings)
        of_a_roller = 3 if self.roller.material.rigid else 2 * self.roller.n_nodes
        return self.bearing.n_rollers * of_a_roller + 2 * rings + 2

    @property
    def _elastic_rings(self) -> list[RingBody]:
        return [ring for ring in (self.inner_ring, self.outer_ring) if not ring.material.rigid]


def build_model(bearing: Bearing, mesh_size: float) -> Model:
    """Mesh, assemble and calibrate a bearing at a surface spacing, m, with contacts below the grid."""
    roller, inner, outer = _bodies(bearing, bearing_shapes(bearing, mesh_size))
    thickness = bearing.roller_length
    half_width = REFERENCE_HALF_WIDTH * bearing.roller_radius
    roller_surface = disc_compliance(roller, thickness, half_width)
    inner_surface = ring_compliance(inner, thickness, half_width)
    outer_surface = ring_compliance(outer, thickness, half_width)
    radius, between = bearing.roller_radius, roller_surface
    if bearing.roller.rigid:  # two of them need a compliance to meet with: their material's own
        between = unmeshed_disc(radius, bearing.roller.elastic, thickness, half_width)
    return Model(
        bearing=bearing,
        roller=roller,
        inner_ring=inner,
        outer_ring=outer,
        inner_law=contact_law(inner_surface, roller_surface, 1.0 / (1.0 / radius + 1.0 / bearing.inner_raceway_radius)),
        outer_law=contact_law(roller_surface, outer_surface, 1.0 / (1.0 / radius - 1.0 / bearing.outer_raceway_radius)),
        roller_law=contact_law(between, between, 0.5 * radius),
        roller_surface=roller_surface,
        inner_surface=inner_surface,
        outer_surface=outer_surface,
    )


def build_resolved_model(bearing: Bearing, mesh_size: float) -> Model:
    """Mesh and assemble a bearing at a surface spacing, m, finer than its contacts."""
    bodies = _bodies(bearing, graded_shapes(bearing, mesh_size))
    return _pressed(bearing, bodies, resolved_laws(bearing, _spacings(*bodies)))


def build_spread_model(bearing: Bearing, mesh_size: float, largest_force: float) -> Model:
    """Mesh and assemble a bearing at a surface spacing, m, about as wide as its contacts; their largest force in N."""
    bodies = _bodies(bearing, graded_shapes(bearing, mesh_size))
    return _pressed(bearing, bodies, spread_laws(bearing, *bodies, largest_force))


def build_penalty_model(bearing: Bearing, mesh_size: float, stiffness: float, faceted: bool) -> Model:
    """Mesh and assemble a bearing at a surface spacing, m, with the contacts of `penalty_laws`; stiffness in N/m."""
    bodies = _bodies(bearing, bearing_shapes(bearing, mesh_size))
    return _pressed(bearing, bodies, penalty_laws(bearing, _spacings(*bodies), stiffness, faceted))


def _spacings(roller: DiscBody, inner: RingBody, outer: RingBody) -> dict[str, float]:
    """Of surface nodes, m."""
    return {
        "roller": roller.shape.surface_spacing,
        "inner_ring": 2.0 * pi * inner.raceway_radius / inner.n_sectors,
        "outer_ring": 2.0 * pi * outer.raceway_radius / outer.n_sectors,
    }


def _pressed(
    bearing: Bearing, bodies: tuple[DiscBody, RingBody, RingBody], laws: dict[int, SpreadLaw | ResolvedLaw]
) -> Model:
    roller, inner, outer = bodies
    return Model(
        bearing=bearing,
        roller=roller,
        inner_ring=inner,
        outer_ring=outer,
        inner_law=laws[INNER],
        outer_law=laws[OUTER],
        roller_law=laws[ROLLER],
    )


def _bodies(bearing: Bearing, shapes: BearingShapes) -> tuple[DiscBody, RingBody, RingBody]:
    thickness = bearing.roller_length
    bodies = (
        disc_body(shapes.roller, bearing.roller.elastic, thickness),
        ring_body(shapes.inner_ring, bearing.inner_ring.elastic, thickness, held_inside=True),
        ring_body(shapes.outer_ring, bearing.outer_ring.elastic, thickness, held_inside=False),
    )
    materials = bearing.roller, bearing.inner_ring, bearing.outer_ring
    return tuple(rigid_body(body) if material.rigid else body for body, material in zip(bodies, materials, strict=True))


def peak_pressure(law: ContactLaw | SpreadLaw | ResolvedLaw, force: float, thickness: float) -> float:
    """Hertz's maximum pressure, Pa: 2 Q / (π b L) (Johnson, Contact Mechanics, 1985, chapter 4)."""
    if force <= 0.0:
        return 0.0
    return 2.0 * force / (pi * sqrt(law.half_width_factor * force) * thickness)
