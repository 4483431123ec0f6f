"""What a picture shows of the bodies: one mesh of triangles, displaced by the magnified displacement, with its stress.

Magnified is everything that differs from a bearing whose parts are undeformed and just touch: the elastic
displacement, the hub's, the rollers' along their radius, and the clearance. Gaps and overlaps then grow
alike, and a closed contact looks closed. The indentation below the grid is part of a contact's approach but
not of the mesh's displacement; it is drawn spread over the contact's patch, half on either side (all of it
on the elastic side where the other is rigid), or else bodies would seem to overlap.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from scipy.spatial import cKDTree

from fem.contacts.points import patch
from fem.elastic.bodies import DiscBody, RingBody
from fem.kernels.state import INNER, OUTER
from fem.pictures.recover import Instant
from fem.pictures.stress_below import BodyLoad, add_hertz, contact_loads, smooth_stress
from fem.solver.frames import rotated
from lagrange.bearing import Bearing
from lagrange.equations import touching_distances

MOST_LEVELS = 14  # of refinement
LARGEST_WEIGHT = 0.55  # of a patch: the quintic B-spline's peak, 66/120
ARCS = 16  # an outline's points for each surface node


def refined(
    data: np.ndarray, triangles: np.ndarray, wanted: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Split triangles until none is larger than wanted; no node is left hanging on an edge.

    scikit-fem refines too, but rebuilds the whole mesh at each level and doesn't tell what new nodes lie between; here
    all columns of nodal data are carried along.

    Parameters
    ----------
    data : (n_nodes, n_columns); the first two columns are the position, m; a new node has the mean of its edge's ends
    triangles : (n_triangles, 3)
    wanted : from middles, (n, 2), m, to the longest edge allowed there, (n,), m

    Returns
    -------
    data, triangles : as given, the old nodes first
    """
    settled = np.zeros((0, 3), dtype=triangles.dtype)  # small enough, which a neighbour's halved edge can undo
    for _ in range(MOST_LEVELS):
        (ax, ay), (bx, by), (cx, cy) = (data[corner, :2].T for corner in triangles.T)
        longest = np.maximum((bx - ax) ** 2 + (by - ay) ** 2, (cx - bx) ** 2 + (cy - by) ** 2)
        longest = np.sqrt(np.maximum(longest, (ax - cx) ** 2 + (ay - cy) ** 2))
        large = longest > wanted(np.column_stack([ax + bx + cx, ay + by + cy]) / 3.0)
        if not large.any():
            break
        split = np.unique(_edges(triangles[large], len(data)))
        reached = np.zeros(len(data), dtype=np.int8)
        reached[triangles[large]] = 1
        triangles = np.concatenate([triangles, settled])
        a, b, c = triangles.T
        touched = reached[a] + reached[b] + reached[c] > 1
        settled, triangles = triangles[~touched], triangles[touched]
        key = _edges(triangles, len(data))
        at = np.minimum(np.searchsorted(split, key), len(split) - 1)
        triangles = _children(triangles, split[at] == key, len(data) + at)
        data = np.concatenate([data, 0.5 * (data[split // len(data)] + data[split % len(data)])])
    return data, np.concatenate([triangles, settled])


def _edges(triangles: np.ndarray, n_nodes: int) -> np.ndarray:
    """One number for each edge, (n, 3), the same for both triangles at it; edge k joins corners k and k + 1."""
    other = np.roll(triangles, -1, axis=1)
    return np.minimum(triangles, other) * n_nodes + np.maximum(triangles, other)


def _children(triangles: np.ndarray, halved: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Four, three or two in place of a triangle with three, two or one halved edges."""
    count = halved.sum(axis=1)
    a, b, c = triangles[count == 3].T
    p, q, r = middle[count == 3].T
    new = [triangles[count == 0], *(np.column_stack(t) for t in ((a, p, r), (p, b, q), (r, q, c), (p, q, r)))]

    (a, b, c), (p, q, _) = _rotated(triangles, middle, count == 2, np.argmin(halved, axis=1) + 1)  # the last edge whole
    new += [np.column_stack(t) for t in ((p, b, q), (a, p, q), (a, q, c))]
    (a, b, c), (p, _, _) = _rotated(triangles, middle, count == 1, np.argmax(halved, axis=1))  # the first edge halved
    new += [np.column_stack(t) for t in ((a, p, c), (p, b, c))]
    return np.concatenate(new)


def _rotated(triangles, middle, chosen, first):
    """Corners and middles of the chosen triangles, counted from another corner on; each (3, n)."""
    order = (first[chosen, None] + np.arange(3)) % 3
    return (np.take_along_axis(array[chosen], order, axis=1).T for array in (triangles, middle))


# columns of the nodal data that refinement carries along
_LOCAL, _RADIUS, _CENTRE, _MOTION, _DENT = slice(0, 2), 2, slice(3, 5), slice(5, 7), slice(7, 9)
_STRESS, _POISSON, _BODY = slice(9, 12), 12, 13
_COLUMNS = 14


@dataclass(frozen=True, kw_only=True)
class DrawnBearing:
    """All bodies as one mesh; nodes of a body follow each other: inner ring, outer ring, rollers."""

    data: np.ndarray  # (n_nodes, _COLUMNS)
    triangles: np.ndarray  # (n_triangles, 3)
    cells: tuple[np.ndarray, ...]  # the finite elements' corners, of elastic bodies, for their edges
    circles: tuple[np.ndarray, ...]  # nodes of the outlines: bore, inner and outer raceway, outside, rollers
    loads: list[BodyLoad]
    spacing: float  # m, of a roller's surface nodes
    hub: np.ndarray  # (2,), m
    roller_reference: np.ndarray  # (n_rollers, 2), m, centres, undeformed and just touching
    roller_shift: np.ndarray  # (n_rollers, 2), m, from there

    @property
    def body(self) -> np.ndarray:
        """Number of each node's body: 0 inner ring, 1 outer ring, 2 + j roller j."""
        return np.rint(self.data[:, _BODY]).astype(int)

    @property
    def reference(self) -> np.ndarray:
        """Nodes of the undeformed bearing whose parts just touch, (n_nodes, 2), m; refined ones lie on the circles."""
        return self.data[:, _CENTRE] + self.local

    @property
    def local(self) -> np.ndarray:
        """The same from the bodies' centres."""
        local = self.data[:, _LOCAL]
        length = np.hypot(*local.T)[:, None]
        return np.where(length > 0.0, local / np.maximum(length, 1e-300) * self.data[:, _RADIUS, None], 0.0)

    @property
    def motion(self) -> np.ndarray:
        """Displacement from the reference, (n_nodes, 2), m."""
        return self.data[:, _MOTION]

    def points(self, magnification: float) -> np.ndarray:
        """Nodes as drawn, (n_nodes, 2), m."""
        return self.reference + magnification * (self.data[:, _MOTION] + self.data[:, _DENT])

    def outlines(self, magnification: float) -> list[np.ndarray]:
        """The bodies' circles as drawn, closed, m; in the order of `circles`."""
        share = np.arange(ARCS)[:, None] / ARCS
        found = []
        for circle in self.circles:
            near, far = self.data[circle, None], self.data[np.roll(circle, -1), None]
            between = ((1.0 - share) * near + share * far).reshape(-1, _COLUMNS)
            points = replace(self, data=between).points(magnification)
            found.append(np.concatenate([points, points[:1]]))
        return found

    @property
    def poisson_ratio(self) -> np.ndarray:
        return self.data[:, _POISSON]

    @property
    def smooth_stress(self) -> np.ndarray:
        """The mesh's less its patches' near the contacts, (n_nodes, 3), Pa; not a number in rigid bodies."""
        return self.data[:, _STRESS]

    def stress(self) -> np.ndarray:
        """Nodal stress with what lies below the grid, (n_nodes, 3), Pa."""
        stress = self.smooth_stress.copy()
        add_hertz(stress, self.local, self.body, self.loads)
        return stress

    @property
    def contact_points(self) -> np.ndarray:
        """Points of contact of all loads, in the reference, (n_loads, 2), m."""
        centres = np.concatenate([np.zeros((2, 2)), self.roller_reference])
        return np.array([item.load.point + centres[item.body] for item in self.loads]).reshape(-1, 2)

    def inner_edges(self) -> np.ndarray:
        """Edges of the finite elements but those on outlines, (n, 2) nodes."""
        edges = np.concatenate([np.stack([c, np.roll(c, -1, axis=1)], axis=-1).reshape(-1, 2) for c in self.cells])
        edges = np.unique(np.sort(edges, axis=1), axis=0)
        rim = np.zeros(len(self.data), dtype=bool)
        rim[np.concatenate(self.circles)] = True
        return edges[~rim[edges].all(axis=1)]

    def near(self, point: np.ndarray, distance: float) -> "DrawnBearing":
        """Only the triangles with a corner within a distance, m, of a point of the reference."""
        inside = np.hypot(*(self.reference - point).T) < distance
        return replace(self, triangles=self.triangles[inside[self.triangles].any(axis=1)])

    def refined(self, finest: float, coarsest: float, relative: float) -> "DrawnBearing":
        """The same with triangles no larger than `relative` times their distance from a contact, within limits, m."""
        centre = self.data[:, _CENTRE]
        placed = self.data.copy()
        placed[:, _LOCAL] += centre  # bodies lie apart; moved back below
        tree = cKDTree(self.contact_points) if self.loads else None

        def wanted(middles):
            if tree is None:
                return np.full(len(middles), coarsest)
            return np.clip(relative * tree.query(middles)[0], finest, coarsest)

        data, triangles = refined(placed, self.triangles, wanted)
        data[:, _LOCAL] -= data[:, _CENTRE]
        return replace(self, data=data, triangles=triangles)


def drawn_bearing(instant: Instant) -> DrawnBearing:
    """Bodies of an instant in the fixed axes, on the finite elements' nodes."""
    model, bearing = instant.model, instant.model.bearing
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    n = bearing.n_rollers
    reference = _roller_reference(instant)
    loads = contact_loads(instant)
    bodies = (inner, outer, *n * (disc,))
    apart = outer.cartesian(_clearance(outer, bearing), instant.outer_turn)
    local = [rotated(inner.points, instant.ring_turn), rotated(outer.points, instant.outer_turn) - apart]
    local += [rotated(disc.points, turn) for turn in instant.roller_turn]
    parts = []
    for number, (body, centre, motion, dent, stress) in enumerate(
        zip(bodies, [*np.zeros((2, 2)), *reference], body_motions(instant), _dents(instant),
            smooth_stress(instant, loads), strict=True)
    ):  # fmt: skip
        data = np.empty((len(motion), _COLUMNS))
        data[:, _LOCAL], data[:, _RADIUS], data[:, _CENTRE] = local[number], np.hypot(*local[number].T), centre
        data[:, _MOTION], data[:, _DENT] = motion, dent
        data[:, _STRESS] = np.nan if body.material.rigid else stress  # which has none: drawn without colour
        data[:, _POISSON], data[:, _BODY] = body.material.poisson_ratio, number
        parts.append(data)
    first = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    cells = [body.cells + start for body, start in zip(bodies, first, strict=False)]
    circles = []
    for k, ring in enumerate((inner, outer)):
        circles += [first[k] + np.arange(ring.n_sectors), first[k + 1] - ring.n_sectors + np.arange(ring.n_sectors)]
    circles += [np.arange(first[k + 1] - disc.shape.surface_nodes, first[k + 1]) for k in range(2, n + 2)]
    return DrawnBearing(
        data=np.concatenate(parts),
        triangles=np.concatenate([_halves(c) for c in cells]),
        cells=tuple(c for c, body in zip(cells, bodies, strict=True) if not body.material.rigid),
        circles=tuple(circles),
        loads=loads,
        spacing=disc.shape.surface_spacing,
        hub=instant.hub,
        roller_reference=reference,
        roller_shift=instant.centres - reference,
    )


def body_motions(instant: Instant) -> list[np.ndarray]:
    """Nodes' displacements from the reference, (n_nodes, 2), m, of inner ring, outer ring and rollers."""
    inner, outer = instant.model.inner_ring, instant.model.outer_ring
    shift = instant.centres - _roller_reference(instant)
    return [
        instant.hub + inner.cartesian(instant.inner_ring, instant.ring_turn),
        outer.cartesian(instant.outer_ring + _clearance(outer, instant.model.bearing), instant.outer_turn),
        *(shift[j] + rotated(instant.rollers[j], turn) for j, turn in enumerate(instant.roller_turn)),
    ]


def _roller_reference(instant: Instant) -> np.ndarray:
    """Where rollers just touch the inner raceway of the centred bearing, (n_rollers, 2), m."""
    touching, _ = touching_distances(instant.model.bearing)
    return touching * np.column_stack([np.cos(instant.outer_angle), np.sin(instant.outer_angle)])


def _clearance(outer: RingBody, bearing: Bearing) -> np.ndarray:
    """How far the outer ring lies outside a bearing whose parts just touch, (n_rows, 2, n_sectors), polar, m."""
    outward = np.zeros((outer.n_rows, 2, outer.n_sectors))
    outward[:, 0] = bearing.radial_clearance
    return outward


def _halves(cells: np.ndarray) -> np.ndarray:
    """Quadrilaterals as two triangles each; triangles as they are."""
    return cells if cells.shape[1] == 3 else np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])


def _dents(instant: Instant) -> list[np.ndarray]:
    """Indentation below the grid as it is drawn, (n_nodes, 2) of every body, m."""
    model, disc = instant.model, instant.model.roller
    inner, outer = model.inner_ring, model.outer_ring
    turned, inner_dent = instant.ring_turn, model.indentation(INNER, instant.inner_force)
    outer_turn, outer_dent = instant.outer_turn, model.indentation(OUTER, instant.outer_force)
    on_inner, on_outer = (_share(ring, disc) for ring in (inner, outer))
    dents = [
        inner.cartesian(_ring_dents(inner, instant.inner_angle - turned, -on_inner * inner_dent), turned),
        outer.cartesian(_ring_dents(outer, instant.outer_angle - outer_turn, on_outer * outer_dent), outer_turn),
    ]
    inner_dent, outer_dent = (1.0 - on_inner) * inner_dent, (1.0 - on_outer) * outer_dent
    for j, turn in enumerate(instant.roller_turn):
        dent = np.zeros((disc.n_nodes, 2))
        for angle, depth in ((instant.inner_angle[j] + pi, inner_dent[j]), (instant.outer_angle[j], outer_dent[j])):
            nodes, share = _patch_shape(disc.shape.surface_nodes, angle - turn)
            direction = np.array([np.cos(angle), np.sin(angle)])
            np.add.at(dent, disc.first_surface_node + nodes, -depth * np.outer(share, direction))
        dents.append(dent)
    return dents


def _share(ring: RingBody, disc: DiscBody) -> float:
    """How much of a contact's indentation is drawn on the ring: half, but nothing of it on a rigid body."""
    return 0.5 + 0.5 * (disc.material.rigid - ring.material.rigid)


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
