"""A bearing made discrete: three kinds of body and the laws of their contacts."""

from dataclasses import dataclass
from math import pi, sqrt

from fem.bodies import DiscBody, RingBody, disc_body, ring_body
from fem.subgrid import ContactLaw, SurfaceCompliance, contact_law, disc_compliance, ring_compliance
from lagrange import Bearing
from meshes import bearing_shapes

# the sub-grid constants hold for any narrow contact; they are evaluated at this share of a roller's radius
REFERENCE_HALF_WIDTH = 0.01


@dataclass(frozen=True, kw_only=True)
class Model:
    """Everything about a bearing that its mesh decides."""

    bearing: Bearing
    roller: DiscBody
    inner_ring: RingBody
    outer_ring: RingBody
    roller_surface: SurfaceCompliance
    inner_surface: SurfaceCompliance
    outer_surface: SurfaceCompliance
    inner_law: ContactLaw  # inner raceway and roller
    outer_law: ContactLaw  # roller and outer raceway
    roller_law: ContactLaw  # two rollers

    @property
    def n_nodes(self) -> int:
        rings = sum(ring.n_rows * ring.n_sectors for ring in (self.inner_ring, self.outer_ring))
        return self.bearing.n_rollers * self.roller.n_nodes + rings

    @property
    def degrees_of_freedom(self) -> int:
        """Free ones: two per node off the held circles, two of the hub."""
        rings = sum((ring.n_rows - 1) * ring.n_sectors for ring in (self.inner_ring, self.outer_ring))
        return 2 * (self.bearing.n_rollers * self.roller.n_nodes + rings) + 2


def build_model(bearing: Bearing, mesh_size: float) -> Model:
    """Mesh, assemble and calibrate a bearing at a surface spacing, m."""
    shapes = bearing_shapes(bearing, mesh_size)
    thickness = bearing.roller_length
    roller = disc_body(shapes.roller, bearing.roller, thickness)
    inner = ring_body(shapes.inner_ring, bearing.inner_ring, thickness, held_inside=True)
    outer = ring_body(shapes.outer_ring, bearing.outer_ring, thickness, held_inside=False)
    half_width = REFERENCE_HALF_WIDTH * bearing.roller_radius
    roller_surface = disc_compliance(roller, thickness, half_width)
    inner_surface = ring_compliance(inner, thickness, half_width)
    outer_surface = ring_compliance(outer, thickness, half_width)
    radius = bearing.roller_radius
    return Model(
        bearing=bearing,
        roller=roller,
        inner_ring=inner,
        outer_ring=outer,
        roller_surface=roller_surface,
        inner_surface=inner_surface,
        outer_surface=outer_surface,
        inner_law=contact_law(inner_surface, roller_surface, 1.0 / (1.0 / radius + 1.0 / bearing.inner_raceway_radius)),
        outer_law=contact_law(roller_surface, outer_surface, 1.0 / (1.0 / radius - 1.0 / bearing.outer_raceway_radius)),
        roller_law=contact_law(roller_surface, roller_surface, 0.5 * radius),
    )


def peak_pressure(law: ContactLaw, force: float, thickness: float) -> float:
    """Hertz's maximum pressure, Pa: 2 Q / (π b L) (Johnson, Contact Mechanics, 1985, chapter 4)."""
    if force <= 0.0:
        return 0.0
    return 2.0 * force / (pi * sqrt(law.half_width_factor * force) * thickness)
