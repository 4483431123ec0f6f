"""What a picture shows of bodies and surfaces: a mesh of triangles, displaced and with its stress; holes and charts.

Magnified is everything that differs from a bearing whose parts are undeformed and just touch: the elastic
displacement, the hub's, the rollers' along their radius, and the clearance. Gaps and overlaps then grow
alike, and a closed contact looks closed. The indentation below the grid is part of a contact's approach but
not of the mesh's displacement; it is drawn spread over the contact's patch, half on either side (all of it
on the elastic side where the other is rigid), or else bodies would seem to overlap.

Where spalls are is cut out of the bodies, magnified along the radius as displacements are: in the picture of the whole
bearing as deep as rollers reach, so that a roller that has sunk in does not overlap it, in a close-up as they are.
Waves and measured heights are far too low for that; they are drawn around a circle within the body, by a factor of
their own.
"""

from collections.abc import Callable
from dataclasses import replace
from math import asin, pi
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fem.contacts.points import patch
from fem.elastic.bodies import max_shear, von_mises
from fem.kernels.columns import ROLLER
from fem.pictures.recover import FIRST_ROLLER, OUTER_RING, Instant, unit_vector
from fem.pictures.stress_below import BodyLoad, add_hertz, contact_loads, hertz_stress, smooth_stress
from fem.solver.elements.arrays import rotated
from lagrange.bearing import Bearing
from lagrange.equations import touching_distances
from lagrange.surface.deviation import profiles
from lagrange.surface.edges import outline
from lagrange.surface.faults import Body, MeasuredSurface, UnequalRoller, Waviness, own_radius, thickness
from lagrange.surface.passages import spalls

MOST_LEVELS = 14  # of refinement
LARGEST_WEIGHT = 0.55  # of a patch: the quintic B-spline's peak, 66/120
ARCS = 16  # an outline's points for each surface node
HOLE_POINTS = 241
AROUND = np.linspace(0.0, 2.0 * pi, 1441)  # rad
DEEPEST, STEEPEST = 0.5, 1.5  # of a body's thickness, of its width: a hole's depth in a picture of the whole bearing
NAME_BESIDE = 0.1  # of the outside radius, from the edge of a ring's hole to the middle of its name
NAME_AT = 0.3  # of a roller's radius, from its centre to a name
DEPTHS = np.linspace(0.0, 2.0, 401)[1:]  # half-widths, of the search for the largest shear
ACROSS = np.linspace(-1.0, 1.0, 41)
FITTED_WITHIN = 2.2  # node spacings: there the smooth part is a straight function of position
CHART = 0.22  # of a body's thickness, that the largest height takes in a chart
CHART_AT = 0.62  # of a roller's radius; in rings the middle
SHALLOWEST = 1e-12  # m, of a surface that is drawn


def rounded_down(value: float, steps: tuple[float, ...] = (1.0, 2.0, 5.0, 10.0)) -> float:
    """The largest step times a power of ten that is not above a value > 0."""
    decade = 10.0 ** np.floor(np.log10(value))
    return decade * max(step for step in steps if step * decade <= value * (1.0 + 1e-12))


def refined(
    data: np.ndarray, triangles: np.ndarray, wanted: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Split triangles, (n, 3), until none is larger than wanted; no node is left hanging on an edge.
    scikit-fem refines too, but rebuilds the whole mesh at each level and doesn't tell what new nodes lie between; here
    all columns of nodal data, (n_nodes, n_columns), are carried along. The first two are the position, m; a new node,
    behind the old ones, has the mean of its edge's ends.
    `wanted` : from middles, (n, 2), m, to the longest edge allowed there, (n,), m"""
    settled = triangles[:0]  # small enough, which a neighbour's halved edge can undo

    def edges_of(triangles):
        """One number for each edge, (n, 3), the same for both triangles at it; edge k joins corners k and k + 1."""
        other = np.roll(triangles, -1, axis=1)
        return np.minimum(triangles, other) * len(data) + np.maximum(triangles, other)

    for _ in range(MOST_LEVELS):
        corners = data[triangles, :2]
        longest = np.sqrt(((corners - np.roll(corners, -1, axis=1)) ** 2).sum(axis=2).max(axis=1))
        large = longest > wanted(corners.mean(axis=1))
        if not large.any():
            break
        split = np.unique(edges_of(triangles[large]))
        triangles = np.concatenate([triangles, settled])
        key = edges_of(triangles)
        at = np.minimum(np.searchsorted(split, key), len(split) - 1)
        halved = split[at] == key
        touched = halved.any(axis=1)
        settled, triangles = triangles[~touched], triangles[touched]
        triangles = _children(triangles, halved[touched], len(data) + at[touched])
        data = np.concatenate([data, 0.5 * (data[split // len(data)] + data[split % len(data)])])
    return data, np.concatenate([triangles, settled])


def _children(triangles, halved, middle):
    """Four, three or two in place of a triangle with three, two or one halved edges."""
    count = halved.sum(axis=1)
    # counted from the corner after the whole edge, or from the halved edge on
    first = np.choose(count, [0, np.argmax(halved, axis=1), np.argmin(halved, axis=1) + 1, 0])
    order = (first[:, None] + np.arange(3)) % 3
    # corners 0, 1, 2, and 3, 4, 5 the middles of the edges from them
    places = np.concatenate([np.take_along_axis(each, order, axis=1) for each in (triangles, middle)], axis=1)
    children = {3: [0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5], 2: [3, 1, 4, 0, 3, 4, 0, 4, 2], 1: [0, 3, 2, 3, 1, 2]}
    return np.concatenate([places[count == n][:, new].reshape(-1, 3) for n, new in children.items()])


# columns of the nodal data that refinement carries along
_LOCAL, _RADIUS, _CENTRE, _MOTION, _DENT = slice(0, 2), 2, slice(3, 5), slice(5, 7), slice(7, 9)
_STRESS, _POISSON, _BODY = slice(9, 12), 12, 13
_COLUMNS = 14


class DrawnBearing(NamedTuple):
    """All bodies as one mesh; nodes of a body follow each other: inner ring, outer ring, rollers."""

    data: np.ndarray  # (n_nodes, _COLUMNS)
    triangles: np.ndarray  # (n_triangles, 3)
    cells: tuple[np.ndarray, ...]  # the finite elements' corners, of elastic bodies
    circles: tuple[np.ndarray, ...]  # nodes of the outlines: bore, inner and outer raceway, outside, rollers
    loads: list[BodyLoad]
    spacing: float  # m, of a roller's surface nodes
    roller_reference: np.ndarray  # (n_rollers, 2), m, centres, undeformed and just touching

    body = property(lambda self: np.rint(self.data[:, _BODY]).astype(int))  # number of each node's body
    # the mesh's stress less its patches' near the contacts, (n_nodes, 3), Pa; not a number in rigid bodies
    smooth_stress = property(lambda self: self.data[:, _STRESS])
    # nodes of the undeformed bearing whose parts just touch, (n_nodes, 2), m; refined ones lie on the circles
    reference = property(lambda self: self.data[:, _CENTRE] + self.local)

    @property
    def local(self) -> np.ndarray:  # the same from the bodies' centres
        local = self.data[:, _LOCAL]
        length = np.maximum(np.hypot(*local.T), 1e-300)
        return local * (self.data[:, _RADIUS] / length)[:, None]

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
            points = self._replace(data=between).points(magnification)
            found.append(np.concatenate([points, points[:1]]))
        return found

    def stress(self) -> np.ndarray:
        """Nodal stress with what lies below the grid, (n_nodes, 3), Pa."""
        stress = self.smooth_stress.copy()
        add_hertz(stress, self.local, self.body, self.loads)
        return stress

    def quantity(self, field: str) -> np.ndarray:
        """Nodal values of "von-mises" or "max-shear", Pa, or of "displacement" from the reference, m."""
        if field == "displacement":
            return np.hypot(*self.data[:, _MOTION].T)
        stress = self.stress()
        return von_mises(stress, self.data[:, _POISSON]) if field == "von-mises" else max_shear(stress)

    def near(self, point: np.ndarray, distance: float) -> "DrawnBearing":
        """Only the triangles with a corner within a distance, m, of a point of the reference."""
        inside = np.hypot(*(self.reference - point).T) < distance
        return self._replace(triangles=self.triangles[inside[self.triangles].any(axis=1)])

    def refined(self, finest: float, coarsest: float, relative: float) -> "DrawnBearing":
        """The same with triangles no larger than `relative` times their distance from a contact, within limits, m."""
        placed = self.data.copy()
        placed[:, _LOCAL] += self.data[:, _CENTRE]  # bodies lie apart; moved back below
        centres = np.concatenate([np.zeros((2, 2)), self.roller_reference])
        contacts = [item.load.point + centres[item.body] for item in self.loads]
        tree = cKDTree(contacts) if contacts else None

        def wanted(middles):
            if tree is None:
                return np.full(len(middles), coarsest)
            return np.clip(relative * tree.query(middles)[0], finest, coarsest)

        data, triangles = refined(placed, self.triangles, wanted)
        data[:, _LOCAL] -= data[:, _CENTRE]
        return self._replace(data=data, triangles=triangles)


def drawn_bearing(instant: Instant) -> DrawnBearing:
    """Bodies of an instant in the fixed axes, on the finite elements' nodes."""
    model, surfaces, reference = instant.model, instant.surfaces, roller_reference(instant)
    loads = contact_loads(instant)
    local = [rotated(body.points, turn) for body, _, _, turn in surfaces]
    local[OUTER_RING] = local[OUTER_RING] - model.outer_ring.cartesian(_clearance(instant), instant.outer_turn)
    columns = zip(surfaces, local, [*np.zeros((2, 2)), *reference], body_motions(instant), _dents(instant),
                  smooth_stress(instant, loads), strict=True)  # fmt: skip
    parts, cells, circles, first = [], [], [], 0
    for number, ((body, _, nodes, _), at, centre, motion, dent, stress) in enumerate(columns):
        data = np.empty((len(at), _COLUMNS))
        data[:, _LOCAL], data[:, _RADIUS], data[:, _CENTRE] = at, np.hypot(*at.T), centre
        data[:, _MOTION], data[:, _DENT] = motion, dent
        data[:, _STRESS] = np.nan if body.material.rigid else stress  # which has none: drawn without colour
        data[:, _POISSON], data[:, _BODY] = body.material.poisson_ratio, number
        circles += [first + np.arange(nodes)] * (number < FIRST_ROLLER)
        circles.append(first + len(at) - nodes + np.arange(nodes))
        parts.append(data)
        cells.append(body.cells + first)
        first += len(at)
    halves = [c[:, corners] for c in cells for corners in ([0, 1, 2], [0, 2, 3])[: c.shape[1] - 2]]
    return DrawnBearing(
        data=np.concatenate(parts), triangles=np.concatenate(halves),
        cells=tuple(c for c, surface in zip(cells, surfaces, strict=True) if not surface.body.material.rigid),
        circles=tuple(circles), loads=loads, spacing=model.roller.shape.surface_spacing, roller_reference=reference,
    )  # fmt: skip


def body_motions(instant: Instant) -> list[np.ndarray]:
    """Nodes' displacements from the reference, (n_nodes, 2), m, of inner ring, outer ring and rollers."""
    inner, outer = instant.model.inner_ring, instant.model.outer_ring
    shift = instant.centres - roller_reference(instant)
    return [
        instant.hub + inner.cartesian(instant.inner_ring, instant.ring_turn),
        outer.cartesian(instant.outer_ring + _clearance(instant), instant.outer_turn),
        *(shift[j] + rotated(instant.rollers[j], turn) for j, turn in enumerate(instant.roller_turn)),
    ]


def roller_reference(instant: Instant) -> np.ndarray:
    """Where rollers just touch the inner raceway of the centred bearing, (n_rollers, 2), m."""
    return touching_distances(instant.model.bearing)[0] * unit_vector(instant.outer_angle)


def _clearance(instant):
    """How far the outer ring lies outside a bearing whose parts just touch, (n_rows, 2, n_sectors), polar, m."""
    outward = np.zeros((instant.model.outer_ring.n_rows, 2, instant.model.outer_ring.n_sectors))
    outward[:, 0] = instant.model.bearing.radial_clearance
    return outward


def _dents(instant):
    """Indentation below the grid as it is drawn, (n_nodes, 2) of every body, m: whole at the contact."""
    model, surfaces, disc = instant.model, instant.surfaces, instant.model.roller
    of_rings, forces = (model.inner_ring, model.outer_ring), (instant.inner_force, instant.outer_force)
    depths = [model.indentation(kind, force) / LARGEST_WEIGHT for kind, force in enumerate(forces)]
    dents = [np.zeros((ring.n_rows, 2, ring.n_sectors)) for ring in of_rings]
    dents += [np.zeros((disc.n_nodes, 2)) for _ in instant.roller_turn]
    for kind, j, number, angle, *_ in instant.sides():
        if kind == ROLLER:
            continue
        body, radius, n_surface, turn = surfaces[number]
        nodes, weight, _ = patch(n_surface, angle - turn)
        on_ring = 0.5 + 0.5 * (disc.material.rigid - of_rings[kind].material.rigid)  # half, but nothing on a rigid body
        if number < FIRST_ROLLER:
            outward = -np.sign(radius) * on_ring * depths[kind][j] * weight
            np.add.at(dents[number], (body.raceway_row, 0, nodes), outward)
        else:
            inward = -(1.0 - on_ring) * depths[kind][j] * np.outer(weight, unit_vector(angle))
            np.add.at(dents[number], disc.first_surface_node + nodes, inward)
    of_inner, of_outer, *of_rollers = dents
    inner, outer = of_rings
    return [inner.cartesian(of_inner, instant.ring_turn), outer.cartesian(of_outer, instant.outer_turn), *of_rollers]


class ShearPeak(NamedTuple):
    """The largest shear stress below one contact of one body, and what Hertz's theory says of the contact."""

    shear: float  # Pa, in the plane
    depth: float  # m
    pressure: float  # Hertz's p₀, Pa
    half_width: float  # b, m


def shear_peak(drawn: DrawnBearing, item: BodyLoad) -> ShearPeak:
    """Search a fine grid: the mesh's smooth part, fitted around the contact, and Hertz's field.
    A mesh that resolves the contact is searched itself, node by node."""
    load, b, at = item.load, item.load.half_width, np.flatnonzero(drawn.body == item.body)
    nodes, smooth = drawn.local[at] - load.point, drawn.smooth_stress[at]
    distance = np.hypot(*nodes.T)
    if item.is_resolved:
        near = distance < DEPTHS[-1] * b
        depth, shear = nodes[near] @ load.inward, max_shear(smooth[near])
    else:
        depth, across = (b * grid.ravel() for grid in np.meshgrid(DEPTHS, ACROSS))
        places, near = np.outer(depth, load.inward), distance < FITTED_WITHIN * item.spacing
        places += np.outer(across, [load.inward[1], -load.inward[0]])
        matrix, wanted = (np.column_stack([np.ones(len(x)), x / item.spacing]) for x in (nodes[near], places))
        fitted = wanted @ np.linalg.lstsq(matrix, smooth[near], rcond=None)[0]
        shear = max_shear(fitted + hertz_stress(load.point + places, load))
    k = int(np.argmax(shear))
    return ShearPeak(float(shear[k]), float(depth[k]), 2.0 * float(np.hypot(*load.force)) / (pi * b), b)


class Circle(NamedTuple):
    """A body's surface as a picture draws it; lengths in m."""

    roller: int | None  # None: a raceway
    centre: np.ndarray  # (2,)
    radius: float
    turn: float  # rad, of the body's own frame
    into: float  # 1.0: material lies outside the circle, −1.0: inside
    thickness: float  # of the body

    def points(self, angle: np.ndarray, inwards) -> np.ndarray:
        """At angles in the body's frame, rad, so deep in its material, m; (n, 2)."""
        radius = self.radius + self.into * np.broadcast_to(inwards, angle.shape)
        return self.centre + radius[:, None] * unit_vector(angle + self.turn)

    def name_place(self, angle: float = pi, inwards: float | None = None) -> np.ndarray:
        """Where a name stands, (2,), m; of a roller across from the dot that shows its turn."""
        return self.points(np.array([angle]), (1.0 - NAME_AT) * self.radius if inwards is None else inwards)[0]


class Drawing(NamedTuple):
    """An instant and its bodies as a picture magnifies their displacements."""

    instant: Instant
    drawn: DrawnBearing
    magnification: float
    look: Any = None  # `fem.pictures.look.Look` of a picture

    bearing = property(lambda self: self.instant.model.bearing)
    hub = property(lambda self: self.magnification * self.instant.hub)  # where the hub is drawn, (2,), m

    @property
    def centres(self) -> np.ndarray:  # where the rollers' centres are drawn, (n_rollers, 2), m
        reference = self.drawn.roller_reference
        return reference + self.magnification * (self.instant.centres - reference)

    def circle(self, body: Body, roller: int | None) -> Circle:
        """A raceway, or a roller's surface."""
        bearing, instant = self.bearing, self.instant
        if body == "outer_ring":
            radius = bearing.outer_raceway_radius + (self.magnification - 1.0) * bearing.radial_clearance
            centre, turn = np.zeros(2), instant.outer_turn
        elif body == "inner_ring":
            radius, centre, turn = bearing.inner_raceway_radius, self.hub, instant.ring_turn
        else:
            radius, centre, turn = bearing.roller_radius, self.centres[roller], float(instant.roller_turn[roller])
        return Circle(roller, centre, radius, turn, 1.0 if body == "outer_ring" else -1.0, thickness(bearing, body))


class Hole(NamedTuple):
    """What a spall takes out of a picture; (n, 2), m."""

    top: np.ndarray  # where it opens, or where a body reaches into it
    bottom: np.ndarray  # as far as no body reaches
    edge: np.ndarray  # the whole bottom
    name: str
    place: np.ndarray  # (2,), of the name


class Chart(NamedTuple):
    """Heights around a circle in a body, magnified; (n, 2), m."""

    circle: np.ndarray
    curve: np.ndarray
    name: str
    place: np.ndarray  # (2,), of the name


def holes(drawing: Drawing, margin: float, as_reached: bool) -> list[Hole]:
    """The spalls of an instant.
    `margin` : m, from a circle's outline, which a hole takes away with it; `as_reached` : whether they are as deep as
    rollers reach, or as they are"""
    bearing, made = drawing.bearing, []
    for spall in spalls(bearing):
        circle, factor, times = drawing.circle(spall.body, spall.roller), drawing.magnification, ""
        own, opening = own_radius(bearing, spall), spall.half_opening(bearing.roller_radius)
        half, middle = asin(opening / own), 0.5 * circle.thickness
        angle = spall.angle + half * np.linspace(-1.0, 1.0, HOLE_POINTS)
        if as_reached:  # magnified as displacements are, or by a round factor that draws it so deep or less
            depth = _sinkage(bearing, (spall,), spall.body, spall.roller, angle)
            most, deepest = min(DEEPEST * circle.thickness, STEEPEST * spall.width), float(depth.max())
            if factor * deepest > most:
                factor = rounded_down(most / deepest)
                times = f", × {factor:g}"
        else:
            at, below = outline(spall, opening)
            order = np.argsort(at, kind="stable")
            depth = np.interp(own * np.sin(angle - spall.angle), at[order], below[order])
        depth, entered = np.clip(factor * depth, 0.0, circle.thickness), _entered(drawing, circle, angle)
        lines = (circle.points(angle, in_) for in_ in (np.maximum(entered, -margin), np.maximum(depth, entered), depth))
        place = circle.name_place()
        if spall.roller is None:
            beside = NAME_BESIDE * bearing.outside_radius / (own + circle.into * middle)
            place = circle.name_place(spall.angle + half + beside, middle)
        made.append(Hole(*lines, f"spall {1e3 * spall.width:.3g} mm{times}", place))
    return made


def charts(drawing: Drawing) -> list[Chart]:
    """Charts of all surfaces with waves or measured heights."""
    made, factor = [], chart_factor(drawing.bearing)
    for body, roller, height, name in _heights(drawing.bearing) if factor is not None else ():
        circle = drawing.circle(body, roller)
        depth, place = (1.0 - CHART_AT) * circle.radius, circle.name_place()
        if roller is None:
            depth = 0.5 * circle.thickness
            place = circle.name_place(0.5 * pi - circle.turn, depth)
        made.append(Chart(circle.points(AROUND, depth), circle.points(AROUND, depth - factor * height), name, place))
    return made


def chart_factor(bearing: Bearing) -> float | None:
    """How often charts magnify heights; None where there are none."""
    heights = list(_heights(bearing))
    highest = max((float(np.abs(height).max()) for *_, height, _ in heights), default=0.0)
    if highest < SHALLOWEST:
        return None
    return rounded_down(CHART * min(thickness(bearing, body) for body, *_ in heights) / highest)


def _heights(bearing):
    """Surfaces with waves or measured heights: these as rollers meet them, m, at the angles AROUND; and a name."""
    waves: dict[tuple[Body, int | None], list] = {}
    for fault in bearing.faults:
        if isinstance(fault, Waviness | MeasuredSurface):
            waves.setdefault((fault.body, fault.roller), []).append(fault)
    for place, faults in waves.items():
        names = ("measured" if isinstance(wave, MeasuredSurface) else
                 f"order {wave.order}, {1e6 * wave.amplitude:.3g} µm" for wave in faults)  # fmt: skip
        yield *place, -_sinkage(bearing, tuple(faults), *place, AROUND), ", ".join(names)


def unequal_rollers(drawing: Drawing) -> list[tuple[Circle, str]]:
    """Rollers of another size as drawn, and by how much they are larger."""
    deviations = {f.roller: 1e6 * f.diameter_deviation for f in drawing.bearing.faults if isinstance(f, UnequalRoller)}
    return [
        (drawing.circle("roller", roller), f"Ø {'+' if larger > 0.0 else '−'}{abs(larger):.3g} µm")
        for roller, larger in deviations.items()
    ]


def _entered(drawing, circle, angle):
    """How deep other bodies reach into a circle's material along its radii, m; negative where they end before it."""
    others = [drawing.circle(body, None) for body in ("inner_ring", "outer_ring")]
    if circle.roller is None:
        others = [drawing.circle("roller", j) for j in range(drawing.bearing.n_rollers)]
    deepest, unit = np.full_like(angle, -np.inf), unit_vector(angle + circle.turn)
    for other in others:
        to_centre = circle.centre - other.centre
        along = unit @ to_centre
        inside = along**2 - (to_centre @ to_centre - other.radius**2)
        # of two discs the ray comes to the other one from outside
        way = -1.0 if circle.into < 0.0 and other.into < 0.0 else 1.0
        end = -along + way * np.sqrt(np.maximum(inside, 0.0))
        hit = (inside > 0.0) & (end > 0.0)
        deepest = np.maximum(deepest, np.where(hit, circle.into * (end - circle.radius), -np.inf))
    return deepest


def _sinkage(bearing, faults, body, roller, angle):
    """What rollers reach of a body with these faults at angles of its frame, rad; of rollers what the outer does."""
    surfaces = profiles(replace(bearing, faults=faults))
    own = {"inner_ring": surfaces.inner_ring, "outer_ring": surfaces.outer_ring}
    profile = own.get(body, surfaces.rollers_outside)
    around = np.repeat(angle[:, None], profile.row.size, axis=1)
    sunk = [each.at(around)[0] for each in (profile, profile.part) if each is not None]
    return sum(sunk)[:, roller or 0]
