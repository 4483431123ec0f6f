"""Which shapes a bearing needs at a mesh size."""

from dataclasses import dataclass
from math import pi

from lagrange import Bearing
from meshes.shapes import Annulus, Disc

SECTOR_MULTIPLE = 8  # sectors fill whole vector registers


@dataclass(frozen=True, kw_only=True)
class BearingShapes:
    """One shape per kind of body."""

    roller: Disc
    inner_ring: Annulus
    outer_ring: Annulus


def bearing_shapes(bearing: Bearing, mesh_size: float) -> BearingShapes:
    """Shapes whose surface spacing is the nearest possible to `mesh_size`, m.

    A roller's surface has a multiple of 6 nodes (12 at least), a raceway a multiple of 8.
    """
    return BearingShapes(
        roller=Disc(
            radius=bearing.roller_radius,
            layers=max(2, round(2.0 * pi * bearing.roller_radius / (6.0 * mesh_size))),
        ),
        inner_ring=_ring(bearing.bore_radius, bearing.inner_raceway_radius, bearing.inner_raceway_radius, mesh_size),
        outer_ring=_ring(bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_raceway_radius, mesh_size),
    )


def _ring(inner: float, outer: float, raceway: float, mesh_size: float) -> Annulus:
    sectors = SECTOR_MULTIPLE * max(4, round(2.0 * pi * raceway / (SECTOR_MULTIPLE * mesh_size)))
    return Annulus(
        inner_radius=inner,
        outer_radius=outer,
        sectors=sectors,
        layers=max(2, round((outer - inner) / mesh_size)),
    )
