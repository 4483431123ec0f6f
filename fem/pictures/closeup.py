"""The picture of one roller between its raceways, and of the stress below its two contacts.

Turned so that the outer raceway lies below. The main panel's plane is in roller radii, the contacts' in half-widths of
the widest contact.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.elastic.bodies import max_shear
from fem.pictures.bodies import DrawnBearing
from fem.pictures.canvas import ASPECT, FAULT, INK, Canvas, Panel, View, border, cells, line, segments, strip
from fem.pictures.legend import HEADING, QUIET, TEXT, draw_length, draw_scale, draw_title, signed
from fem.pictures.look import Look
from fem.pictures.recover import Instant
from fem.pictures.scale import Scale
from fem.pictures.stress_below import AT_DEPTH, FIRST_ROLLER, LARGEST_SHEAR, BodyLoad, hertz_stress
from fem.pictures.surfaces import Drawing, holes
from fem.solver.frames import rotated
from lagrange.surface.faults import own_radius
from lagrange.surface.passages import spalls

DEPTHS = np.linspace(0.0, 2.0, 401)[1:]  # half-widths
ACROSS = np.linspace(-1.0, 1.0, 41)
FITTED_WITHIN = 2.2  # node spacings: there the smooth part is a straight function of position


@dataclass(frozen=True, kw_only=True)
class ShearPeak:
    """The largest shear stress below one contact of one body, and what Hertz's theory says of the contact."""

    shear: float  # Pa, in the plane
    depth: float  # m
    across: float  # m, from the contact's middle, along the surface
    pressure: float  # Hertz's p₀, Pa
    half_width: float  # b, m


def shear_peak(drawn: DrawnBearing, item: BodyLoad) -> ShearPeak:
    """Search a fine grid: the mesh's smooth part, fitted around the contact, and Hertz's field.

    A mesh that resolves the contact is searched itself, node by node.
    """
    load = item.load
    b = load.half_width
    along = np.array([load.inward[1], -load.inward[0]])
    if item.is_resolved:
        from_contact = drawn.local - load.point
        near = np.flatnonzero((drawn.body == item.body) & (np.hypot(*from_contact.T) < DEPTHS[-1] * b))
        depth, across = from_contact[near] @ load.inward, from_contact[near] @ along
        shear = max_shear(drawn.smooth_stress[near])
    else:
        depth, across = (b * grid.ravel() for grid in np.meshgrid(DEPTHS, ACROSS))
        points = load.point + depth[:, None] * load.inward + across[:, None] * along
        shear = max_shear(_smooth(drawn, item, points) + hertz_stress(points, load))
    k = int(np.argmax(shear))
    pressure = 2.0 * float(np.hypot(*load.force)) / (pi * b)
    return ShearPeak(
        shear=float(shear[k]), depth=float(depth[k]), across=float(across[k]), pressure=pressure, half_width=b
    )


def _smooth(drawn: DrawnBearing, item: BodyLoad, points: np.ndarray) -> np.ndarray:
    """The mesh's part of the stress, (n, 3), Pa, by least squares from the nodes around a contact."""
    at = np.flatnonzero(drawn.body == item.body)
    nodes = drawn.local[at] - item.load.point
    near = np.hypot(*nodes.T) < FITTED_WITHIN * item.spacing
    matrix = np.column_stack([np.ones(near.sum()), nodes[near] / item.spacing])
    coefficients = np.linalg.lstsq(matrix, drawn.smooth_stress[at[near]], rcond=None)[0]
    return np.column_stack([np.ones(len(points)), (points - item.load.point) / item.spacing]) @ coefficients


PAGE = View(middle=(2.0 / 3.0, 0.5), tall=1.0)
MAIN = View(left=0.0, bottom=0.0, right=0.50, top=0.885, middle=(0.0, 0.0), tall=3.25)
CONTACTS = (  # inner, outer
    View(left=0.61, bottom=0.574, right=0.86, top=0.574 + 1.0 / 3.0, middle=(0.0, 0.0), tall=7.0),
    View(left=0.61, bottom=0.102, right=0.86, top=0.102 + 1.0 / 3.0, middle=(0.0, 0.0), tall=7.0),
)
VIEWS = [PAGE, MAIN, *CONTACTS]
PIXEL = MAIN.tall / (1200.0 * (MAIN.top - MAIN.bottom))  # of a page 1600 wide, roller radii
FINEST, COARSEST = 0.003, 0.06  # of a roller's radius: triangles of the main panel
RELATIVE = 0.33  # triangles over their distance from the contact
FINEST_BELOW, RELATIVE_BELOW = 0.06, 0.12  # of a half-width, of the distance from the contact: of a contact's panel
REACH = 2.6  # roller radii around the roller's centre that the main panel can see
OUTLINE, WIRE, FINEST_WIRES = 1.8, 0.7, 6.0  # pixels; a finer mesh is not shown
BARS = (0.685, 0.22, 0.72), (1.172, 0.24, 0.74)  # left, bottom and top of the main panel's scale, of the contacts'
BAR_WIDTH = 0.020
SMALL = 20.0  # pixels
CROSS = 0.16  # half the size of a mark


def views(look: Look) -> list[View]:
    """Panels: the page, the roller, its inner and its outer contact."""
    return VIEWS


def paint(canvas: Canvas, instant: Instant, drawn: DrawnBearing, look: Look) -> None:
    """Draw an instant on an empty page."""
    page, main, *contacts = canvas.panels
    scene = _Roller(instant=instant, drawn=drawn, magnification=look.magnification, look=look)
    draw_title(page, instant, look, 0.02, 0.97, (0.042, 0.071))
    _roller(main, scene)
    for panel, kind in zip(contacts, ("inner", "outer"), strict=True):
        over = scene.is_over_a_spall(kind)
        peaks = [] if over else [(item, shear_peak(drawn, item)) for item in scene.loads(kind) if not item.is_rigid]
        _contact(panel, scene, kind, peaks)
        _facts(page, panel.view, scene, kind, peaks)
    _scales(page, scene)


@dataclass(frozen=True, kw_only=True)
class _Roller(Drawing):
    """What is drawn, and how the plane is turned."""

    look: Look

    @property
    def radius(self) -> float:
        return self.bearing.roller_radius

    @property
    def centre(self) -> np.ndarray:
        return self.drawn.roller_reference[self.look.roller]

    def contact(self, kind: str) -> np.ndarray:
        """Where the roller touches a raceway, m."""
        angle = self.direction(kind) + np.pi * (kind == "inner")
        return self.centre + self.radius * np.array([np.cos(angle), np.sin(angle)])

    def direction(self, kind: str) -> float:
        """From the ring's centre to the roller's, rad."""
        return (self.instant.inner_angle if kind == "inner" else self.instant.outer_angle)[self.look.roller]

    def loads(self, kind: str) -> list[BodyLoad]:
        """The contact's two loads, on the ring and on the roller; none where it is open."""
        return [item for item in self.drawn.loads if (item.kind, item.roller) == (kind, self.look.roller)]

    def is_over_a_spall(self, kind: str) -> bool:
        """Whether the contact's line of centres meets a spall: then its edges carry the force."""
        j, bearing, direction = self.look.roller, self.bearing, self.direction(kind)
        on_ring = direction - (self.instant.ring_turn if kind == "inner" else self.instant.outer_turn)
        on_roller = direction + np.pi * (kind == "inner") - self.instant.roller_turn[j]
        for spall in spalls(bearing):
            if spall.body == f"{kind}_ring" or spall.roller == j:
                angle = on_ring if spall.roller is None else on_roller
                beyond = abs((angle - spall.angle + np.pi) % (2.0 * np.pi) - np.pi)
                if beyond < spall.half_opening(bearing.roller_radius) / own_radius(bearing, spall):
                    return True
        return False

    def placed(self, points: np.ndarray, origin: np.ndarray, unit: float) -> np.ndarray:
        """Points in a panel's plane: the outer raceway below."""
        return rotated(points - origin, -0.5 * np.pi - self.instant.outer_angle[self.look.roller]) / unit

    def show(self, panel: Panel, fine: DrawnBearing, scale: Scale, origin: np.ndarray, unit: float) -> None:
        """Coloured bodies and their outlines."""
        points = self.placed(fine.points(self.magnification), origin, unit)
        panel.field(cells(points, fine.triangles, 0.0), scale.values(fine), scale.limits, scale.colours)
        outlines = [line(self.placed(o, origin, unit), 0.1) for o in self.drawn.outlines(self.magnification)]
        panel.stroke(outlines, INK, OUTLINE)
        margin = OUTLINE * unit * panel.view.tall / (1200.0 * (panel.view.top - panel.view.bottom))
        for hole in holes(self, margin, as_reached=False):
            top, bottom, edge = (self.placed(points, origin, unit) for points in (hole.top, hole.bottom, hole.edge))
            panel.fill(strip(top, bottom, 0.11), "white")
            panel.stroke(line(edge, 0.115), FAULT, 2.0 * OUTLINE)


def _roller(main: Panel, scene: _Roller) -> None:
    """The whole roller, with the mesh and the bodies' names."""
    look, drawn, radius, centre = scene.look, scene.drawn, scene.radius, scene.centre
    fine = drawn.near(centre, REACH * radius).refined(FINEST * radius, COARSEST * radius, RELATIVE)
    scene.show(main, fine, look.scale, centre, radius)
    if drawn.spacing > FINEST_WIRES * PIXEL * radius:
        wires = segments(scene.placed(drawn.points(scene.magnification), centre, radius), drawn.inner_edges(), 0.05)
        main.stroke(wires, "white", WIRE, opacity=0.25)
    left, tall = -0.48 * main.wide, MAIN.tall
    angle = (np.degrees(scene.instant.outer_angle[look.roller]) + 90.0 + 180.0) % 360.0 - 180.0
    main.text("inner ring", left, 0.47 * tall, TEXT, backed=True)
    main.text("outer ring", left, -0.41 * tall, TEXT, backed=True)
    name = f"roller {look.roller}, {signed(round(angle, 1))}° from the load"
    main.text(name, 0.0, 0.0, TEXT, backed=True, align="center")
    draw_length(main, left + 0.02, -0.46 * tall, 1e3 * radius, backed=True)


def _contact(panel: Panel, scene: _Roller, kind: str, peaks: list[tuple[BodyLoad, ShearPeak]]) -> None:
    """The field around one contact, how wide it is, and where the shear is largest."""
    b, point = scene.look.half_width, scene.contact(kind)
    spacing = scene.instant.model.roller.shape.surface_spacing
    near = scene.drawn.near(point, 1.5 * spacing + CONTACTS[0].tall * b)
    fine = near.refined(FINEST_BELOW * b, 0.5 * spacing, RELATIVE_BELOW)
    scene.show(panel, fine, scene.look.contact_scale, point, b)
    panel.stroke(border((0.0, 0.0), panel.wide, panel.view.tall, 0.5), QUIET, 1.5)
    draw_length(panel, -0.46 * panel.wide, -0.44 * panel.view.tall, 1e3 * b, longest=2.0, backed=True)
    for item, peak in peaks:
        down = scene.placed(point + item.load.inward, point, 1.0)[1]  # the inward normal is upright in the panel
        half, y = peak.half_width / b, down * peak.depth / b
        panel.stroke(line(np.array([[-half, 0.0], [half, 0.0]]), 0.2), "white", 5.0)
        for colour, pixels, z in ((INK, 5.0, 0.3), ("white", 2.5, 0.4)):
            arms = (np.array([[-CROSS, y], [CROSS, y]]), np.array([[0.0, y - CROSS], [0.0, y + CROSS]]))
            panel.stroke([line(arm, z) for arm in arms], colour, pixels)


def _facts(page: Panel, view: View, scene: _Roller, kind: str, peaks: list[tuple[BodyLoad, ShearPeak]]) -> None:
    """Beside a contact's panel: its force, pressure and width, and the largest shear on either side."""
    left, bottom = ASPECT * view.left, view.bottom
    force = getattr(scene.instant, f"{kind}_force")[scene.look.roller]
    page.text(f"{kind.capitalize()} contact: {force:.0f} N", left, view.top + 0.022, HEADING, bold=True)
    lines = ["open"]
    if force > 0.0 and not peaks and scene.is_over_a_spall(kind):
        lines = ["over a spall: its edge carries the force,", "below which the stress is not shown"]
    if peaks:
        lines = [f"p₀ = {1e-6 * peaks[0][1].pressure:.0f} MPa   2b = {2e6 * peaks[0][1].half_width:.0f} µm"]
        for item, peak in peaks:
            name, depth = "roller" if item.body >= FIRST_ROLLER else "ring", peak.depth / peak.half_width
            lines.append(f"+ {name}: shear {peak.shear / peak.pressure:.3f} p₀, {depth:.2f} b deep")
    _small_lines(page, left, bottom - 0.021, lines)


def _scales(page: Panel, scene: _Roller) -> None:
    """Colour bars of the main panel and of the contacts, and what theory says of the shear."""
    look = scene.look
    page.text(look.scale.title, BARS[0][0], 0.965, HEADING, bold=True)
    for scale, (x, bottom, top) in zip((look.scale, look.contact_scale), BARS, strict=True):
        page.text(scale.unit, x, top + 0.035, HEADING, bold=True)
        draw_scale(page, scale, x, bottom, top, BAR_WIDTH)
    if look.scale.field != "displacement":
        lines = ["half plane:", f"{LARGEST_SHEAR:.3f} p₀,", f"{AT_DEPTH:.2f} b deep"]
        _small_lines(page, BARS[1][0], BARS[1][1] - 0.035, lines)


def _small_lines(page: Panel, x: float, y: float, lines: list[str]) -> None:
    for k, text in enumerate(lines):
        page.text(text, x, y - 0.027 * k, SMALL, QUIET)
