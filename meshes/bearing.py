"""Which shapes a bearing needs at a mesh size."""

from dataclasses import dataclass
from math import pi

from lagrange import Bearing
from meshes.graded import GradedAnnulus, GradedDisc, graded_disc
from meshes.shapes import Annulus, Disc

SECTOR_MULTIPLE = 8  # sectors fill whole vector registers


@dataclass(frozen=True, kw_only=True)
class BearingShapes:
    """One shape per kind of body."""

    roller: Disc | GradedDisc
    inner_ring: Annulus | GradedAnnulus
    outer_ring: Annulus | GradedAnnulus


def bearing_shapes(bearing: Bearing, mesh_size: float) -> BearingShapes:
    """Shapes whose surface spacing is the nearest possible to `mesh_size`, m.

    A roller's surface has a multiple of 3 nodes (12 at least), a raceway a multiple of 8.
    """
    radius, inner, outer = bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius
    return BearingShapes(
        roller=Disc(radius=radius, layers=max(2.0, 0.5 * round(2.0 * pi * radius / (3.0 * mesh_size)))),
        inner_ring=_ring(bearing.core_radius, inner, inner, mesh_size),
        outer_ring=_ring(outer, bearing.outside_radius, outer, mesh_size),
    )


def graded_shapes(bearing: Bearing, mesh_size: float) -> BearingShapes:
    """Shapes of that surface spacing, m, whose meshes coarsen away from the raceways."""
    inner, outer = bearing.inner_raceway_radius, bearing.outer_raceway_radius
    inside, outside = _sectors(inner, mesh_size), _sectors(outer, mesh_size)
    return BearingShapes(
        roller=graded_disc(bearing.roller_radius, mesh_size),
        inner_ring=GradedAnnulus(
            inner_radius=bearing.core_radius, outer_radius=inner, sectors=inside, raceway_outside=True),
        outer_ring=GradedAnnulus(
            inner_radius=outer, outer_radius=bearing.outside_radius, sectors=outside, raceway_outside=False),
    )  # fmt: skip


def _sectors(raceway, mesh_size):
    return SECTOR_MULTIPLE * max(4, round(2.0 * pi * raceway / (SECTOR_MULTIPLE * mesh_size)))


def _ring(inner, outer, raceway, mesh_size):
    layers = max(2, round((outer - inner) / mesh_size))
    return Annulus(inner_radius=inner, outer_radius=outer, sectors=_sectors(raceway, mesh_size), layers=layers)
