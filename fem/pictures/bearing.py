"""The picture of the whole bearing. Lengths on the page are in outside radii."""

from dataclasses import dataclass
from math import asin

import numpy as np

from fem.pictures.bodies import DrawnBearing
from fem.pictures.canvas import (
    ASPECT,
    FAULT,
    INK,
    Canvas,
    Panel,
    View,
    arrow,
    cells,
    circle,
    disc,
    line,
    polygon,
    ring,
    segments,
    strip,
    turning_arrow,
)
from fem.pictures.legend import ORBIT_DOT, draw_legend, orbit_view
from fem.pictures.look import Look
from fem.pictures.recover import Instant
from fem.pictures.stress_below import FIRST_ROLLER
from fem.pictures.surfaces import Drawing, charts, holes, unequal_rollers

BAR = 0.34  # of a roller's radius: half a bar's width across the pitch circle
POINTS = 12  # of an arc
ROUND = 24  # points of a pocket's wall


def bars(instant: Instant) -> list[np.ndarray]:
    """Outlines of the cage's bars between the rollers, closed, (n, 2), m; none without a cage.

    They are drawn where they are: a cage's play is a thousand times the bodies' displacements, and is not magnified.
    """
    facts, bearing = instant.scene.ideal_cage(), instant.model.bearing
    if facts is None or instant.cage is None:
        return []
    n, pitch, half = bearing.pockets, bearing.pitch_radius, bearing.roller_radius + 0.5 * facts.pocket_clearance
    wide = BAR * bearing.roller_radius
    walls = [_wall(pitch, half, wide, facts.guidance == "rollers", side) for side in (1.0, -1.0)]
    first = instant.operation.first_roller_angle + instant.cage[2]
    found = []
    for j in range(n):
        start, end = first + 2.0 * np.pi * j / n, first + 2.0 * np.pi * (j + 1) / n
        before, after = _turned(walls[0], start), _turned(walls[1], end)
        outline = np.concatenate([before, _arc(before[-1], after[-1]), after[::-1], _arc(after[0], before[0])])
        found.append(instant.cage[:2] + outline)
    return found


def _wall(pitch: float, half: float, wide: float, is_round: bool, side: float) -> np.ndarray:
    """A pocket's front (1) or rear (−1) wall from inside to outside, (ROUND, 2), m; its roller on the x axis."""
    across = np.linspace(-wide, wide, ROUND)
    ahead = np.sqrt(np.maximum(half**2 - across**2, 0.0)) if is_round else np.full(ROUND, half)
    return np.column_stack([pitch + across, side * ahead])


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _arc(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The way about the cage's centre from one point to another on about the same circle."""
    radius, first = np.hypot(*start), np.arctan2(start[1], start[0])
    turn = asin(np.clip((start[0] * end[1] - start[1] * end[0]) / (np.hypot(*start) * np.hypot(*end)), -1.0, 1.0))
    angle = first + np.linspace(0.0, turn, POINTS)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


PAGE = View(middle=(0.525, 0.085), tall=2.64)
PIXEL = PAGE.tall * ASPECT / 1600.0  # of a page 1600 wide, outside radii
FINEST = 0.5  # pixels of a page 1600 wide: the smallest triangles
COARSEST = 0.012  # of the outside radius: larger triangles would show as corners of a circle
RELATIVE = 0.33  # triangles over their distance from the contact
HOUSING, LOAD_ZONE, SHAFT, FAINT, FORCE = "#e3e3e3", "#f5dca8", "#f4f4f4", "#8a8a8a", "#d7301f"
CAGE = "#c9b28a"
COLOURS = HOUSING, LOAD_ZONE, SHAFT, FORCE, ORBIT_DOT, FAULT, CAGE
BEHIND = -0.005  # the cage, behind rings and rollers, where these are magnified into it
HOUSING_RADIUS, THINNEST_HOUSING = 1.09, 0.01
OUTSIDE = 3  # of a drawn bearing's circles
OUTLINE, WIRE, FINEST_WIRES = 1.5, 0.7, 6.0  # pixels; a finer mesh is not shown
ARROW_WIDTH = 0.017
ROLLERS_ABOVE = 0.01
NAME = 18.0  # pixels of a page 1600 wide
MARK = 0.62, 0.09  # radius at which a roller's mark lies and its size, of the roller's radius


@dataclass(frozen=True, kw_only=True)
class _Whole(Drawing):
    """What is drawn, and where."""

    page: Panel
    look: Look

    @property
    def scale(self) -> float:
        """Lengths on the page, outside radii, over those of the bearing, m."""
        return 1.0 / self.bearing.outside_radius


def views(look: Look) -> list[View]:
    """Panels: the page, and the orbit where the run has one."""
    return [PAGE] + ([] if look.orbit is None else [orbit_view(PAGE, look.orbit)])


def paint(canvas: Canvas, instant: Instant, drawn: DrawnBearing, look: Look) -> None:
    """Draw an instant on an empty page."""
    whole = _Whole(instant=instant, drawn=drawn, magnification=look.magnification, page=canvas.panels[0], look=look)
    for draw in (_housing, _bodies, _cage, _surfaces, _marks, _shaft, _forces):
        draw(whole)
    draw_legend(canvas, instant, look, FORCE)


def _housing(whole: _Whole) -> None:
    page, look, scale, bore = whole.page, whole.look, whole.scale, whole.instant.scene.mounting().bore
    if bore is None:
        inside = scale * float(np.hypot(*whole.drawn.outlines(whole.magnification)[OUTSIDE][0])) - 0.01
    else:  # as magnified as the ring in it, and never all of the housing
        inside = min(1.0 + 0.5 * scale * whole.magnification * bore.clearance, HOUSING_RADIUS - THINNEST_HOUSING)
    page.fill(ring(inside, HOUSING_RADIUS, -0.03), HOUSING)
    if look.load_zone is not None:
        start, end = look.load_zone
        end += 2.0 * np.pi * (end < start)
        page.fill(ring(inside, HOUSING_RADIUS, -0.02, start, end), LOAD_ZONE)
    page.stroke(circle((0.0, 0.0), HOUSING_RADIUS, -0.01), FAINT, OUTLINE)
    middle = 0.5 * (max(inside + 0.01, 1.0) + HOUSING_RADIUS)
    for j, centre in enumerate(whole.drawn.roller_reference):
        x, y = middle * centre / np.hypot(*centre)
        page.text(str(j), x, y, 19.0, "#4d4d4d", align="center")


def _bodies(whole: _Whole) -> None:
    page, drawn, magnification, scale = whole.page, whole.drawn, whole.magnification, whole.scale
    colours = whole.look.scale
    fine = drawn.refined(FINEST * PIXEL / scale, COARSEST / scale, RELATIVE)
    height = ROLLERS_ABOVE * (fine.body >= FIRST_ROLLER)  # where one lies in a spall, magnified, it overlaps the ring
    bodies = cells(scale * fine.points(magnification), fine.triangles, height)
    page.field(bodies, colours.values(fine), colours.limits, colours.colours)
    if drawn.spacing > FINEST_WIRES * PIXEL / scale:
        wires = segments(scale * drawn.points(magnification), drawn.inner_edges(), 0.05)
        page.stroke(wires, "white", WIRE, opacity=0.22)
    page.stroke([line(scale * outline, 0.1) for outline in drawn.outlines(magnification)], INK, OUTLINE)


def _cage(whole: _Whole) -> None:
    found = [whole.scale * outline for outline in bars(whole.instant)]
    if found:
        whole.page.fill([polygon(outline, BEHIND) for outline in found], CAGE)
        whole.page.stroke([line(np.concatenate([outline, outline[:1]]), BEHIND) for outline in found], INK, OUTLINE)


def _surfaces(whole: _Whole) -> None:
    """Holes where spalls are, roundness charts of waves, and the names of both and of unequal rollers."""
    page, scale, names = whole.page, whole.scale, []
    for hole in holes(whole, OUTLINE * PIXEL / scale, as_reached=True):
        page.fill(strip(scale * hole.top, scale * hole.bottom, 0.11), "white")
        page.stroke(line(scale * hole.edge, 0.115), FAULT, 3.5)
        names.append((hole.name, hole.place))
    for chart in charts(whole):
        page.stroke(line(scale * chart.circle, 0.11), "white", 1.0, opacity=0.8)
        page.stroke(line(scale * chart.curve, 0.115), FAULT, 2.5)
        names.append((chart.name, chart.place))
    for roller, name in unequal_rollers(whole):
        page.stroke(circle(scale * roller.centre, scale * roller.radius, 0.115), FAULT, 4.0)
        names.append((name, roller.name_place))
    for name, place in names:
        page.text(name, *(scale * place), NAME, backed=True, align="center")


def _marks(whole: _Whole) -> None:
    """Dots that turn with the rollers and the rings that turn."""
    instant, bearing, scale = whole.instant, whole.bearing, whole.scale
    if not any(instant.operation.ring_speeds):
        return
    turns = np.column_stack([np.cos(instant.roller_turn), np.sin(instant.roller_turn)])
    places = [*(scale * (whole.centres + MARK[0] * bearing.roller_radius * turns))]
    radius = 0.5 * (bearing.core_radius + bearing.inner_raceway_radius)
    turn = np.array([np.cos(instant.ring_turn), np.sin(instant.ring_turn)])
    places.append(scale * (radius * turn + whole.hub))
    if instant.operation.outer_speed != 0.0:
        radius = 0.5 * (bearing.outer_raceway_radius + bearing.outside_radius)
        places.append(scale * radius * np.array([np.cos(instant.outer_turn), np.sin(instant.outer_turn)]))
    size = MARK[1] * bearing.roller_radius * scale
    whole.page.fill([disc(place, 1.35 * size, 0.12) for place in places], INK)
    whole.page.fill([disc(place, size, 0.13) for place in places], "white")


def _shaft(whole: _Whole) -> None:
    """The hub as a disc, with its centre, the outer ring's centre, the load and how both rings turn."""
    page, operation = whole.page, whole.instant.operation
    hub, bore = whole.scale * whole.hub, whole.scale * whole.bearing.core_radius
    size = min(27.0, 75.0 * bore)
    page.fill(disc(hub, bore, 0.05), SHAFT)
    page.stroke(circle(hub, bore, 0.06), INK, OUTLINE)
    arm = 0.16 * bore
    page.stroke(
        [line(np.array([[-arm, 0.0], [arm, 0.0]]), 0.2), line(np.array([[0.0, -arm], [0.0, arm]]), 0.2)], FAINT, 1.5
    )
    if operation.radial_load > 0.0:
        tip = hub + np.array([0.0, -0.80 * bore])
        page.fill(arrow(hub, tip, 0.075 * bore, 0.3), INK)
        page.text("W", hub[0] + 0.16 * bore, hub[1] - 0.55 * bore, size, bold=True)
    page.fill(disc(hub, 0.05 * bore, 0.31), INK)
    if operation.speed != 0.0:
        ends = (0.28, 0.72) if operation.speed > 0.0 else (0.72, 0.28)
        page.fill(turning_arrow(hub, 0.78 * bore, np.pi * ends[0], np.pi * ends[1], 0.05 * bore, 0.3), INK)
        page.text("n", hub[0], hub[1] + 0.56 * bore, size, bold=True, align="center")
    if operation.outer_speed != 0.0:
        ends = (0.42, 0.58) if operation.outer_speed > 0.0 else (0.58, 0.42)
        middle = HOUSING_RADIUS + 0.035
        page.fill(turning_arrow((0.0, 0.0), middle, np.pi * ends[0], np.pi * ends[1], 0.016, 0.3), INK)


def _forces(whole: _Whole) -> None:
    """Arrows from the contacts into the rollers."""
    arrows = []
    for tails, forces in contact_forces(whole.instant):
        for start, vector in zip(whole.scale * (whole.centres + tails), whole.look.arrow_length * forces, strict=True):
            if np.hypot(*vector) >= 0.5 * ARROW_WIDTH:
                arrows.append((start, start + vector))
    if arrows:
        whole.page.fill([arrow(*ends, ARROW_WIDTH, 0.40, border=0.25 * ARROW_WIDTH) for ends in arrows], "white")
        whole.page.fill([arrow(*ends, ARROW_WIDTH, 0.41) for ends in arrows], FORCE)


def contact_forces(instant: Instant) -> list[tuple[np.ndarray, np.ndarray]]:
    """Where each kind of contact acts on the rollers, m from the centre, and the force with traction, N."""
    radius = instant.model.bearing.roller_radius
    inner, outer = _directions(instant.inner_angle), _directions(instant.outer_angle)
    ahead, _ = _directions(instant.next_angle)
    pushed = instant.roller_force[:, None] * ahead
    return [
        (-radius * inner[0], instant.inner_force[:, None] * inner[0] + instant.inner_traction[:, None] * inner[1]),
        (radius * outer[0], -instant.outer_force[:, None] * outer[0] + instant.outer_traction[:, None] * outer[1]),
        (radius * ahead, -pushed),
        (-radius * np.roll(ahead, 1, axis=0), np.roll(pushed, 1, axis=0)),
    ]


def _directions(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radial and counter-clockwise unit vectors, each (n, 2)."""
    return np.column_stack([np.cos(angle), np.sin(angle)]), np.column_stack([-np.sin(angle), np.cos(angle)])
