"""Triangles as fine as a contact at chosen spots of a surface, growing with the distance from them."""

import itertools
from dataclasses import dataclass
from functools import cached_property
from math import asin, cos, pi, sin

import numpy as np

from meshes.shapes import TRIANGLE, Mesh, counter_clockwise, gmsh_session, used_points

FINEST = 0.25  # mesh size at the middle of a spot, over that at the half-width
REACH = 4.0  # half-length of a spot, over the half-width
COARSEST = 1.5  # largest mesh size, over depth / per_half_width
FRONTAL_DELAUNAY = 6  # gmsh's algorithm with the best triangles


@dataclass(frozen=True, kw_only=True)
class Spot:
    """Where a contact of about a half-width b presses: elements as long as b/per_half_width at its edge.

    They grow in proportion to the distance, so a contact several times narrower or wider has as many elements at its
    own edge, about.
    """

    half_width: float  # b, m
    per_half_width: float

    @property
    def finest(self) -> float:
        """Mesh size in the middle, m."""
        return FINEST * self.half_width / self.per_half_width

    @property
    def growth(self) -> float:
        """Growth of the mesh size per distance."""
        return (1.0 - FINEST) / self.per_half_width

    @cached_property
    def corners(self) -> np.ndarray:
        """Corner nodes along the tangent, m, symmetric about the 0 in the middle."""
        along = [0.0]
        while along[-1] < REACH * self.half_width:
            along.append(along[-1] + self.finest + self.growth * along[-1])
        return np.array([-x for x in along[:0:-1]] + along)


@dataclass(frozen=True, kw_only=True)
class RefinedDisc:
    """A disc with spots at the angles 0 and π."""

    radius: float  # m
    spot: Spot


@dataclass(frozen=True, kw_only=True)
class RefinedSector:
    """One of equal sectors of an annulus, from −π/sectors to π/sectors; its raceway has a spot at the angle 0.

    Nodes on its two straight sides lie at the same radii.
    """

    raceway_radius: float  # m
    held_radius: float  # m
    sectors: int
    spot: Spot


def refined_mesh(shape: RefinedDisc | RefinedSector) -> Mesh:
    """Mesh of straight triangles; where it is curved the corners lie on the circles.

    Errors
    ------
    RuntimeError: gmsh can't be loaded.
    ValueError: spots overlap.
    """
    with gmsh_session(FRONTAL_DELAUNAY) as gmsh:
        # the field alone sets the size; boundaries and points have no say
        for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
        (_draw_disc if isinstance(shape, RefinedDisc) else _draw_sector)(gmsh.model, shape)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(TRIANGLE)
    points, cells = used_points(tags, coordinates.reshape(-1, 3)[:, :2], nodes.reshape(-1, 3))
    return Mesh(points=points, cells=counter_clockwise(points, cells))


def _draw_disc(model, disc: RefinedDisc) -> None:
    centre = model.geo.addPoint(0.0, 0.0, 0.0)
    right, right_ends = _spot(model, disc.spot, disc.radius, 0.0)
    left, left_ends = _spot(model, disc.spot, disc.radius, pi)
    loop = [
        *right,
        model.geo.addCircleArc(right_ends[1], centre, left_ends[0]),
        *left,
        model.geo.addCircleArc(left_ends[1], centre, right_ends[0]),
    ]
    _fill(model, loop, disc.spot, [(disc.radius, 0.0), (-disc.radius, 0.0)], disc.radius)


def _draw_sector(model, ring: RefinedSector) -> None:
    centre = model.geo.addPoint(0.0, 0.0, 0.0)
    half = pi / ring.sectors
    spot, ends = _spot(model, ring.spot, ring.raceway_radius, 0.0)
    if asin(ring.spot.corners[-1] / ring.raceway_radius) >= half:
        raise ValueError(f"spots {2.0 * ring.spot.corners[-1]:.2g} m wide overlap on a ring of {ring.sectors} sectors")
    raceway = [_point(model, ring.raceway_radius, angle) for angle in (-half, half)]
    held = [_point(model, ring.held_radius, angle) for angle in (-half, 0.0, half)]
    sides = [model.geo.addLine(held[0], raceway[0]), model.geo.addLine(held[2], raceway[1])]
    loop = [
        sides[0],
        model.geo.addCircleArc(raceway[0], centre, ends[0]),
        *spot,
        model.geo.addCircleArc(ends[1], centre, raceway[1]),
        -sides[1],
        model.geo.addCircleArc(held[2], centre, held[1]),
        model.geo.addCircleArc(held[1], centre, held[0]),
    ]
    model.geo.synchronize()
    c, s = cos(2.0 * half), sin(2.0 * half)
    model.mesh.setPeriodic(1, [sides[1]], [sides[0]], [c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    depth = abs(ring.raceway_radius - ring.held_radius)
    _fill(model, loop, ring.spot, [(ring.raceway_radius, 0.0)], depth)


def _point(model, radius: float, angle: float) -> int:
    return model.geo.addPoint(radius * cos(angle), radius * sin(angle), 0.0)


def _spot(model, spot: Spot, radius: float, angle: float) -> tuple[list[int], tuple[int, int]]:
    """Edges of one element each along a circle, counter-clockwise, and the points at their ends."""
    points = [_point(model, radius, angle + asin(along / radius)) for along in spot.corners]
    edges = [model.geo.addLine(a, b) for a, b in itertools.pairwise(points)]
    for edge in edges:
        model.geo.mesh.setTransfiniteCurve(edge, 2)
    return edges, (points[0], points[-1])


def _fill(model, loop: list[int], spot: Spot, middles: list[tuple[float, float]], depth: float) -> None:
    """One surface within a loop of curves; its mesh size grows with the distance from the spots."""
    model.geo.addPlaneSurface([model.geo.addCurveLoop(loop)])
    model.geo.synchronize()
    largest = COARSEST * depth / spot.per_half_width
    sizes = [f"{spot.finest!r}+{spot.growth!r}*sqrt((x-({x!r}))^2+(y-({y!r}))^2)" for x, y in middles]
    fields = []
    for size in (*sizes, repr(largest)):
        fields.append(model.mesh.field.add("MathEval"))
        model.mesh.field.setString(fields[-1], "F", size)
    smallest = model.mesh.field.add("Min")
    model.mesh.field.setNumbers(smallest, "FieldsList", fields)
    model.mesh.field.setAsBackgroundMesh(smallest)
