"""What a picture shows of every body: nodes displaced by the magnified displacement, and the stress in them.

Magnified is everything that differs from a bearing whose parts are undeformed and just touch: the elastic
displacement, the hub's, the rollers' along their radius, and the clearance. Gaps and overlaps then grow
alike, and a closed contact looks closed. The indentation below the grid is part of a contact's approach but
not of the mesh's displacement; it is drawn spread over the contact's patch, half on either side, or else
bodies would seem to overlap.
"""

from dataclasses import dataclass
from math import floor, log10, pi

import numpy as np

from fem.bodies import RingBody
from fem.recover import Instant, von_mises
from fem.subgrid import patch

LARGEST_SHARE = 0.03  # of the outside radius: the largest displacement as drawn
LARGEST_WEIGHT = 0.55  # of a patch: the quintic B-spline's peak, 66/120
STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)  # round magnifications, times a power of ten


@dataclass(frozen=True, kw_only=True)
class DrawnBody:
    """A mesh as it is drawn."""

    reference: np.ndarray  # (n_nodes, 2), m, undeformed, parts just touching
    displacement: np.ndarray  # (n_nodes, 2), m, from there, not magnified
    cells: np.ndarray
    stress: np.ndarray  # (n_nodes,), Pa, von Mises
    edges: tuple[slice, ...]  # nodes of its circles, the innermost first

    def points(self, magnification: float) -> np.ndarray:
        """Nodes as drawn, (n_nodes, 2), m."""
        return self.reference + magnification * self.displacement

    def outlines(self, magnification: float) -> list[np.ndarray]:
        """Its circles as drawn, closed, m."""
        points = self.points(magnification)
        return [np.concatenate([points[edge], points[edge][:1]]) for edge in self.edges]


@dataclass(frozen=True, kw_only=True)
class DrawnBearing:
    """All bodies; `rollers` in the order of the file."""

    inner_ring: DrawnBody
    outer_ring: DrawnBody
    rollers: tuple[DrawnBody, ...]
    hub: np.ndarray  # (2,), m
    roller_reference: np.ndarray  # (n_rollers, 2), m, centres
    roller_shift: np.ndarray  # (n_rollers, 2), m

    @property
    def bodies(self) -> tuple[DrawnBody, ...]:
        return (self.outer_ring, self.inner_ring, *self.rollers)

    @property
    def largest_displacement(self) -> float:
        return max(float(np.hypot(*body.displacement.T).max()) for body in self.bodies)


def drawn_bearing(instant: Instant) -> DrawnBearing:
    """Bodies of an instant in global axes."""
    model, bearing = instant.model, instant.model.bearing
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    inner_angle, outer_angle = instant.inner_angle, instant.outer_angle
    # indentation below the grid of one side, m; inward for a roller
    inner_dent = 0.5 * model.inner_law.approach(instant.inner_force) * (instant.inner_force > 0.0)
    outer_dent = 0.5 * model.outer_law.approach(instant.outer_force) * (instant.outer_force > 0.0)

    inner_dents = _ring_dents(inner, inner_angle - instant.ring_turn, -inner_dent)
    outer_dents = _ring_dents(outer, outer_angle, outer_dent)
    outer_dents[:, 0] += bearing.radial_clearance
    inner_body = _ring(inner, instant.inner_ring, inner_dents, instant.ring_turn, instant.hub, 0.0)
    outer_body = _ring(outer, instant.outer_ring, outer_dents, 0.0, np.zeros(2), -bearing.radial_clearance)

    touching = bearing.inner_raceway_radius + bearing.roller_radius
    radial = np.column_stack([np.cos(outer_angle), np.sin(outer_angle)])
    reference = touching * radial
    shift = instant.centres - reference
    rollers = []
    for j, displacement in enumerate(instant.rollers):
        dents = np.zeros((disc.n_nodes, 2))
        for angle, depth in ((inner_angle[j] + pi, inner_dent[j]), (outer_angle[j], outer_dent[j])):
            nodes, share = _patch_shape(disc.shape.surface_nodes, angle)
            direction = np.array([np.cos(angle), np.sin(angle)])
            np.add.at(dents, disc.first_surface_node + nodes, -depth * np.outer(share, direction))
        rollers.append(
            DrawnBody(
                reference=reference[j] + disc.points,
                displacement=shift[j] + displacement + dents,
                cells=disc.cells,
                stress=von_mises(disc.points, disc.cells, displacement, disc.material),
                edges=(slice(disc.first_surface_node, disc.n_nodes),),
            )
        )
    return DrawnBearing(
        inner_ring=inner_body,
        outer_ring=outer_body,
        rollers=tuple(rollers),
        hub=instant.hub,
        roller_reference=reference,
        roller_shift=shift,
    )


def chosen_magnification(drawn: DrawnBearing, outside_radius: float) -> float:
    """A round factor, at least 1, that draws the largest displacement LARGEST_SHARE of the radius or less."""
    largest = drawn.largest_displacement
    if largest <= 0.0:
        return 1.0
    wanted = max(1.0, LARGEST_SHARE * outside_radius / largest)
    decade = 10.0 ** floor(log10(wanted))
    return decade * max(step for step in STEPS if step * decade <= wanted * (1.0 + 1e-9))


def _ring(ring: RingBody, polar, extra, turn: float, shift, outward: float) -> DrawnBody:
    """A ring: its elastic displacement gives the stress; `extra` (polar, m) and `shift` are drawn as well."""
    angle = ring.angles + turn
    radial, around = np.stack([np.cos(angle), np.sin(angle)]), np.stack([-np.sin(angle), np.cos(angle)])

    def plane(vectors):  # (n_rows, 2, n_sectors), polar, to (n_nodes, 2)
        return np.moveaxis(vectors[:, 0, None] * radial + vectors[:, 1, None] * around, 1, 2).reshape(-1, 2)

    points = (ring.radii[:, None, None] * radial.T).reshape(-1, 2)
    return DrawnBody(
        reference=points + outward * np.tile(radial.T, (ring.n_rows, 1)),
        displacement=shift + plane(polar + extra),
        cells=ring.cells,
        stress=von_mises(points, ring.cells, plane(polar), ring.material),
        edges=(slice(0, ring.n_sectors), slice(len(points) - ring.n_sectors, len(points))),
    )


def _ring_dents(ring: RingBody, angles, depths) -> np.ndarray:
    """Radial displacement of a raceway's nodes at every contact, (n_rows, 2, n_sectors), m."""
    dents = np.zeros((ring.n_rows, 2, ring.n_sectors))
    for angle, depth in zip(angles, depths, strict=True):
        nodes, share = _patch_shape(ring.n_sectors, angle)
        np.add.at(dents, (ring.raceway_row, 0, nodes), depth * share)
    return dents


def _patch_shape(n_surface: int, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a patch and how much of the indentation each one shows: 1 at the contact."""
    nodes, weight, _ = patch(n_surface, angle)
    return nodes, weight / LARGEST_WEIGHT
