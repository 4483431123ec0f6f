"""Surfaces that are not perfect as pictures show them: holes, and roundness charts of waves, names of both.

Where spalls are is cut out of the bodies, magnified along the radius as displacements are: in the picture of the whole
bearing as deep as rollers reach, so that a roller that has sunk in does not overlap it, in a close-up as they are.
Waves and measured heights are far too low for that; they are drawn around a circle within the body, by a factor of
their own.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import asin, pi

import numpy as np

from fem.pictures.bodies import DrawnBearing
from fem.pictures.recover import Instant
from fem.pictures.scale import rounded_down
from lagrange.bearing import Bearing
from lagrange.surface.deviation import Profiles, profiles
from lagrange.surface.edges import outline
from lagrange.surface.faults import Body, MeasuredSurface, UnequalRoller, Waviness, own_radius, thickness
from lagrange.surface.passages import spalls

HOLE_POINTS = 241
AROUND = np.linspace(0.0, 2.0 * pi, 1441)  # rad
DEEPEST, STEEPEST = 0.5, 1.5  # of a body's thickness, of its width: a hole's depth in a picture of the whole bearing
NAME_BESIDE = 0.1  # of the outside radius, from the edge of a ring's hole to the middle of its name
NAME_AT = 0.3  # of a roller's radius, from its centre to a name
CHART = 0.22  # of a body's thickness, that the largest height takes in a chart
CHART_AT = 0.62  # of a roller's radius; in rings the middle
SHALLOWEST = 1e-12  # m, of a surface that is drawn


@dataclass(frozen=True, kw_only=True)
class Circle:
    """A body's surface as a picture draws it; lengths in m."""

    body: Body
    roller: int | None
    centre: np.ndarray  # (2,)
    radius: float
    turn: float  # rad, of the body's own frame
    into: float  # 1.0: material lies outside the circle, −1.0: inside
    thickness: float  # of the body

    def points(self, angle: np.ndarray, inwards) -> np.ndarray:
        """At angles in the body's frame, rad, so deep in its material, m; (n, 2)."""
        direction = angle + self.turn
        unit = np.column_stack([np.cos(direction), np.sin(direction)])
        return self.centre + (self.radius + self.into * np.broadcast_to(inwards, angle.shape))[:, None] * unit

    def point(self, angle: float, inwards: float) -> np.ndarray:
        """One of them, (2,), m."""
        return self.points(np.array([angle]), inwards)[0]

    @property
    def name_place(self) -> np.ndarray:
        """Where a roller's names stand, (2,), m: across from the dot that shows its turn."""
        return self.point(pi, (1.0 - NAME_AT) * self.radius)


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """An instant and its bodies as a picture magnifies their displacements."""

    instant: Instant
    drawn: DrawnBearing
    magnification: float

    @property
    def bearing(self) -> Bearing:
        return self.instant.model.bearing

    @property
    def hub(self) -> np.ndarray:
        """Where the hub is drawn, (2,), m."""
        return self.magnification * self.drawn.hub

    @property
    def centres(self) -> np.ndarray:
        """Where the rollers' centres are drawn, (n_rollers, 2), m."""
        return self.drawn.roller_reference + self.magnification * self.drawn.roller_shift

    def circle(self, body: Body, roller: int | None) -> Circle:
        """A raceway, or a roller's surface."""
        bearing = self.bearing
        if body == "outer_ring":
            radius = bearing.outer_raceway_radius + (self.magnification - 1.0) * bearing.radial_clearance
            place = dict(centre=np.zeros(2), radius=radius, turn=self.instant.outer_turn, into=1.0)
        elif body == "inner_ring":
            turn = self.instant.ring_turn
            place = dict(centre=self.hub, radius=bearing.inner_raceway_radius, turn=turn, into=-1.0)
        else:
            turn = float(self.instant.roller_turn[roller])
            place = dict(centre=self.centres[roller], radius=bearing.roller_radius, turn=turn, into=-1.0)
        return Circle(body=body, roller=roller, thickness=thickness(bearing, body), **place)


@dataclass(frozen=True, kw_only=True)
class Hole:
    """What a spall takes out of a picture."""

    top: np.ndarray  # (n, 2), m, where it opens, or where a body reaches into it
    bottom: np.ndarray  # (n, 2), m, as far as no body reaches
    edge: np.ndarray  # (n, 2), m, the whole bottom
    name: str
    place: np.ndarray  # (2,), m, of the name


@dataclass(frozen=True, kw_only=True)
class Chart:
    """Heights around a circle in a body, magnified."""

    circle: np.ndarray  # (n, 2), m
    curve: np.ndarray  # (n, 2), m
    name: str
    place: np.ndarray  # (2,), m


def holes(drawing: Drawing, margin: float, as_reached: bool) -> list[Hole]:
    """The spalls of an instant.

    Parameters
    ----------
    margin : m, from a circle's outline, which a hole takes away with it
    as_reached : whether they are as deep as rollers reach, or as they are
    """
    bearing, found = drawing.bearing, []
    for spall in spalls(bearing):
        circle, factor = drawing.circle(spall.body, spall.roller), drawing.magnification
        own = own_radius(bearing, spall)
        half = asin(spall.half_opening(bearing.roller_radius) / own)
        angle = spall.angle + half * np.linspace(-1.0, 1.0, HOLE_POINTS)
        if as_reached:
            depth = _sinkage(profiles(replace(bearing, faults=(spall,))), spall.body, spall.roller, angle)
            most = min(DEEPEST * circle.thickness, STEEPEST * spall.width)
            factor = _hole_factor(factor, float(depth.max()), most)
        else:
            at, below = outline(spall, spall.half_opening(bearing.roller_radius))
            order = np.argsort(at, kind="stable")
            depth = np.interp(own * np.sin(angle - spall.angle), at[order], below[order])
        depth = np.clip(factor * depth, 0.0, circle.thickness)
        met, times = _met(drawing, circle, angle), "" if factor == drawing.magnification else f", × {factor:g}"
        middle = 0.5 * circle.thickness
        beside = spall.angle + half + NAME_BESIDE * bearing.outside_radius / (own + circle.into * middle)
        found.append(
            Hole(
                top=circle.points(angle, np.maximum(met, -margin)),
                bottom=circle.points(angle, np.maximum(depth, met)),
                edge=circle.points(angle, depth),
                name=f"spall {1e3 * spall.width:.3g} mm{times}",
                place=circle.point(beside, middle) if spall.roller is None else circle.name_place,
            )
        )
    return found


def _hole_factor(magnification: float, deepest: float, most: float) -> float:
    """How often a hole is magnified: as displacements are, or a round factor that draws it `most` deep or less, m."""
    return magnification if magnification * deepest <= most else rounded_down(most / deepest)


def charts(drawing: Drawing) -> list[Chart]:
    """Charts of all surfaces with waves or measured heights."""
    made, factor = [], chart_factor(drawing.bearing)
    for body, roller, height, name in _heights(drawing.bearing):
        circle = drawing.circle(body, roller)
        depth = 0.5 * circle.thickness if roller is None else (1.0 - CHART_AT) * circle.radius
        place = circle.point(0.5 * pi - circle.turn, depth) if roller is None else circle.name_place
        curve = circle.points(AROUND, depth - factor * height)
        made.append(Chart(circle=circle.points(AROUND, depth), curve=curve, name=name, place=place))
    return made


def chart_factor(bearing: Bearing) -> float | None:
    """How often charts magnify heights; None where there are none."""
    found = list(_heights(bearing))
    highest = max((float(np.abs(height).max()) for *_, height, _ in found), default=0.0)
    if highest < SHALLOWEST:
        return None
    return rounded_down(CHART * min(thickness(bearing, body) for body, *_ in found) / highest)


def _heights(bearing: Bearing) -> Iterator[tuple[Body, int | None, np.ndarray, str]]:
    """Surfaces with waves or measured heights: these as rollers meet them, m, at the angles AROUND; and a name."""
    for body, roller in dict.fromkeys((fault.body, fault.roller) for fault in bearing.faults):
        faults = [fault for fault in bearing.faults if (fault.body, fault.roller) == (body, roller)]
        if waves := tuple(fault for fault in faults if isinstance(fault, Waviness | MeasuredSurface)):
            alone = profiles(replace(bearing, faults=waves))
            yield body, roller, -_sinkage(alone, body, roller, AROUND), ", ".join(_wave_name(wave) for wave in waves)


def unequal_rollers(drawing: Drawing) -> list[tuple[Circle, str]]:
    """Rollers of another size as drawn, and by how much they are larger."""
    found = []
    for fault in drawing.bearing.faults:
        if isinstance(fault, UnequalRoller):
            sign = "+" if fault.diameter_deviation > 0.0 else "−"
            name = f"Ø {sign}{abs(1e6 * fault.diameter_deviation):.3g} µm"
            found.append((drawing.circle("roller", fault.roller), name))
    return found


def _met(drawing: Drawing, circle: Circle, angle: np.ndarray) -> np.ndarray:
    """How deep other bodies reach into a circle's material along its radii, m; negative where they end before it."""
    if circle.roller is None:
        others = [drawing.circle("roller", j) for j in range(drawing.bearing.n_rollers)]
    else:
        others = [drawing.circle(body, None) for body in ("inner_ring", "outer_ring")]
    deepest = np.full_like(angle, -np.inf)
    unit = circle.points(angle, 0.0) - circle.centre
    unit /= np.hypot(*unit.T)[:, None]
    for other in others:
        to_centre = circle.centre - other.centre
        along = unit @ to_centre
        inside = along**2 - (to_centre @ to_centre - other.radius**2)
        root = np.sqrt(np.maximum(inside, 0.0))
        is_entered = circle.into < 0.0 and other.into < 0.0  # two discs: the ray comes to the other one from outside
        end = -along - root if is_entered else -along + root
        hit = (inside > 0.0) & (end > 0.0)
        deepest = np.maximum(deepest, np.where(hit, circle.into * (end - circle.radius), -np.inf))
    return deepest


def _sinkage(surfaces: Profiles, body: Body, roller: int | None, angle: np.ndarray) -> np.ndarray:
    """What rollers reach of a body at angles of its frame, rad; of rollers themselves what the outer raceway does."""
    own = {"inner_ring": surfaces.inner_ring, "outer_ring": surfaces.outer_ring}
    profile = own.get(body, surfaces.rollers_outside)
    every = np.repeat(angle[:, None], profile.row.size, axis=1)
    met = profile.at(every)
    sunk = met.sinkage if met.part is None else met.sinkage + met.part.sinkage
    return sunk[:, roller or 0]


def _wave_name(wave: Waviness | MeasuredSurface) -> str:
    if isinstance(wave, MeasuredSurface):
        return "measured"
    return f"order {wave.order}, {1e6 * wave.amplitude:.3g} µm"
