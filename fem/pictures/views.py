"""Pictures of a run, drawn off-screen: the whole bearing, or one roller and the stress below its two contacts.

The same run and request give the same picture. Call `fem.pictures.output.check_rendering` before importing this: where
system libraries are missing, the renderer does not raise but ends the process. Lengths on the page of the bearing are
in outside radii; those of a close-up's roller, whose outer raceway lies below, in roller radii, of its contacts in
half-widths of the widest one.
"""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from math import pi
from pathlib import Path

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from fem.pictures import bodies, canvas
from fem.pictures.bodies import Drawing, rounded_down, shear_peak
from fem.pictures.canvas import ASPECT, FAULT, INK, QUIET, View, arc, arrow
from fem.pictures.look import Request, chosen_look
from fem.pictures.output import MARK
from fem.pictures.recover import FIRST_ROLLER, Instant, StoredRun, unit_vector
from fem.pictures.stress_below import AT_DEPTH, LARGEST_SHEAR
from fem.solver.elements.arrays import rotated
from lagrange.bearing import load_factor
from lagrange.files.output import replaced
from lagrange.load_history import load_share
from lagrange.messages import shown
from lagrange.scene.faults import RPM
from lagrange.surface.faults import own_radius
from lagrange.surface.passages import spalls

TITLE, HEADING, TEXT, SMALL = 38.0, 26.0, 23.0, 19.0  # pixels of 1600
TIP = 7.8  # pixels: half the ends of a length bar
RELATIVE = 0.33  # triangles over their distance from the contact
OUTLINE, SPALL = 1.6, 3.5  # pixels
WIRE, FINEST_WIRES = (0.7, 0.12), 6.0  # pixels, opacity, drawn twice between elements; a finer mesh is not shown
HOUSING, LOAD_ZONE, SHAFT, FAINT, FORCE = "#e3e3e3", "#f5dca8", "#f4f4f4", "#8a8a8a", "#d7301f"
CAGE, ORBIT_DOT = "#c9b28a", "#0072b2"
PACKED = 1  # of PNG; 6 takes twice the time for a tenth less room


class Renderer(AbstractContextManager):
    """Draws samples of a run with scales that fit all of those it is made for; use as a context manager.
    UsageError: the request does not suit the run, the run is damaged."""

    def __init__(self, run: StoredRun, request: Request, samples: Sequence[int], pace: str = ""):
        self._run, self.look = run, chosen_look(run, request, samples, pace)
        self._paint, views = _paint_closeup, [CLOSEUP, ROLLER, *CONTACTS]
        if request.view == "bearing":
            self._paint, views = _paint_bearing, [PAGE, *_orbit_view(self.look)]
        self._canvas = canvas.Canvas(request.width, 2 * round(0.5 * request.width / ASPECT), views)

    def image(self, sample: int) -> np.ndarray:
        """(height, width, 3) bytes."""
        instant, look = self._run.instant(sample), self.look
        self._canvas.clear()
        self._paint(Drawing(instant, bodies.drawn_bearing(instant), look.magnification, look), *self._canvas.panels)
        return self._canvas.image()

    def __exit__(self, *_) -> None:
        self._canvas.plotter.close()


def draw(run: StoredRun, target: Path, request: Request, sample: int) -> None:
    """Write one picture as PNG; its text names the run and says what is shown. OSError: `target` can't be written.
    UsageError: as `Renderer`."""
    with Renderer(run, request, [sample]) as renderer:
        image, look = renderer.image(sample), renderer.look
    seen = "the whole bearing" if request.view == "bearing" else f"roller {look.roller} in its contacts"
    at, about = f"{1e3 * run.times[sample]:.6g} ms", PngInfo()
    about.add_text("Software", MARK)
    about.add_itxt("Source", shown(run.path.name))
    about.add_itxt("Description", f"{look.scale.title}, {seen} at {at}; {run.scene.method}.")
    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part:
        Image.fromarray(image).save(part, format="PNG", pnginfo=about, compress_level=PACKED)


# ---- what pictures of both kinds share


def _signed(value):  # A number with a true minus sign, and no negative zero
    return f"{value + 0.0:g}".replace("-", "−")


def _title(page, sketch, x, y, below, method_below=None):
    """Name, time, operation, model and damping; an animation's pace.
    `below` : how far below the title facts stand; `method_below`: and model and damping in a line of their own"""
    instant, bearing = sketch.instant, sketch.bearing
    scene, operation, ramp = instant.scene, instant.operation, 1e-3 * instant.scene.numerics.load_ramp_ms
    whole = load_factor(bearing) * operation.radial_load  # of the bearing
    load = f"W = {whole:.6g} N"
    if scene.numerics.start == "rest" and instant.time < ramp:
        load = f"W = {load_share(instant.time, ramp) * whole:.4g} N of {whole:.6g} N"
    rpm = round(operation.speed / RPM, 1) if scene.operation.speed_table else scene.operation.speed_rpm
    turning = f"n = {_signed(rpm)} rpm"
    if operation.outer_speed:
        turning += f" (outer ring {_signed(round(operation.outer_speed / RPM, 1))} rpm)"
    facts = [turning, load, f"{f'{bearing.rows} × ' if bearing.rows > 1 else ''}{scene.bearing.present} rollers"]
    if bearing.contact_angle:
        facts.append(f"section at {bearing.contact_angle_deg:.4g}°")
    if rigid := scene.bodies.rigid:
        facts.append("rigid rings" if len(rigid) == 2 else f"rigid {rigid[0].replace('_', ' ')}")
    method = scene.method + (", stress from its forces" if scene.model == "lagrange" else "")
    if method_below is None:
        facts.append(method)
    else:
        page.text(method, x, y - method_below, SMALL, QUIET)
    page.text(f"{scene.name}:  t = {1e3 * instant.time:.6g} ms", x, y, TITLE, bold=True)
    page.text("   ".join([*facts, sketch.look.pace]).rstrip(), x, y - below, HEADING)


def _length_bar(page, x, y, unit, longest=0.5, backed=False):
    """A bar of a round length; `unit`, mm, is what one length of the plane stands for; `backed`: on a white ground."""
    length, tip = rounded_down(longest * unit), TIP * page.view.pixel
    end = x + length / unit
    if backed:
        middle = 0.5 * (x + end) + 0.25 * tip, y
        page.fill(canvas.box(middle, 0.5 * (end - x) + 1.25 * tip, 2.0 * tip), "white", 0.75)
    lines = ((x, y), (end, y)), ((x, y - tip), (x, y + tip)), ((end, y - tip), (end, y + tip))
    page.stroke(np.array(lines), INK, 3.0)
    page.text(f"{length:g} mm", end + 2.0 * tip, y, TEXT, backed=backed)


def _texts(page, x, y, lines, size, apart):
    """Quiet lines, one below the other; the height of the next one."""
    for text in lines:
        page.text(text, x, y, size, QUIET)
        y -= apart
    return y


def _bodies(plane, sketch, fine, scale, unit, page=False, mesh=True):
    """Coloured bodies, their outlines, and the holes of spalls, which are returned.
    `unit` : m, a length of the panel; `page` : whether it shows the whole bearing: spalls as deep as rollers reach;
    `mesh` : whether edges of the finite elements are drawn, if they can be resolved"""
    values, is_roller = scale.values(fine), fine.body[fine.triangles[:, 0]] >= FIRST_ROLLER
    drawn, magnification, pixel = sketch.drawn, sketch.magnification, plane.view.pixel * unit
    for part in (~is_roller, is_roller):  # above: where one lies in a spall, magnified, it overlaps the ring
        if part.any():
            plane.field(fine.points(magnification), fine.triangles[part], values, scale)
    for cells in drawn.cells if mesh and drawn.spacing > FINEST_WIRES * pixel else ():
        plane.stroke(drawn.points(magnification)[np.column_stack([cells, cells[:, 0]])], "white", *WIRE)
    plane.stroke(drawn.outlines(magnification), INK, OUTLINE)
    holes = bodies.holes(sketch, OUTLINE * pixel, as_reached=page)
    for hole in holes:
        plane.strip(hole.top, hole.bottom, "white")
        plane.stroke(hole.edge, FAULT, SPALL)
    return holes


# ---- the whole bearing

PAGE = View(middle=(0.525, 0.085), tall=2.64)
FINEST = 0.5  # pixels of a page 1600 wide: the smallest triangles
COARSEST = 0.012  # of the outside radius: larger triangles would show as corners of a circle
BAR = 0.34  # of a roller's radius: half a cage's bar across the pitch circle
BAR_POINTS, WALL_POINTS = 12, 24  # of an arc, of a pocket's wall
HOUSING_RADIUS, THINNEST_HOUSING = 1.09, 0.01
ARROW_WIDTH, HALO = 0.017, 4.0  # outside radii; pixels, of white around arrows
NAME = 18.0  # pixels
DOT = 0.62, 0.09  # radius at which a roller's mark lies and its size, of the roller's radius
EDGE, TOP = -1.18, 1.325  # of the title, outside radii
COLUMN, LINE = 1.25, 0.085  # left edge of the legend, between its lines
COLOUR_BAR = 0.47, 1.00, 0.08  # bottom, top, width
ORBIT = 1.25, -1.19, 0.46  # left, bottom, size
ORBIT_MARGIN = 1.35  # of the orbit's extent


def _orbit_view(look):
    """The inset's place on the page, and its plane: the orbit, µm. None where the hub does not move."""
    if look.orbit is None:
        return []
    left, bottom, size = ORBIT
    wide, tall = PAGE.tall * ASPECT, PAGE.tall
    x, y = (left - PAGE.middle[0]) / wide + 0.5, (bottom - PAGE.middle[1]) / tall + 0.5
    low, high = look.orbit.min(axis=0), look.orbit.max(axis=0)
    middle, extent = tuple(0.5 * (low + high)), ORBIT_MARGIN * max(high - low)
    return [View(left=x, bottom=y, right=x + size / wide, top=y + size / tall, middle=middle, tall=extent)]


def _paint_bearing(sketch, page, *inset):
    drawn, look, bearing, unit = sketch.drawn, sketch.look, sketch.bearing, sketch.bearing.outside_radius
    plane = page.placed(lambda points: np.asarray(points) / unit)  # for lengths in m
    _housing(page, sketch)
    plane.fill(arc(sketch.hub, bearing.core_radius), SHAFT)
    if cage := bars(sketch.instant):
        plane.fill(cage, CAGE)
        plane.stroke([np.concatenate([bar, bar[:1]]) for bar in cage], INK, OUTLINE)
    fine = drawn.refined(FINEST * PAGE.pixel * unit, COARSEST * unit, RELATIVE)
    names = [(hole.name, hole.place) for hole in _bodies(plane, sketch, fine, look.scale, unit, page=True)]
    plane.stroke(arc(sketch.hub, bearing.core_radius), INK, OUTLINE)
    for chart in bodies.charts(sketch):
        plane.stroke(chart.circle, "white", 1.0, opacity=0.8)
        plane.stroke(chart.curve, FAULT, 2.5)
        names.append((chart.name, chart.place))
    for roller, name in bodies.unequal_rollers(sketch):
        plane.stroke(arc(roller.centre, roller.radius), FAULT, 4.0)
        names.append((name, roller.name_place()))
    for name, place in names:
        plane.text(name, *place, NAME, backed=True, align="center")
    _dots(plane, sketch)
    _shaft(page, sketch, sketch.hub / unit, bearing.core_radius / unit)
    arrows = []
    for item in drawn.loads:
        vector = look.arrow_length * bearing.roller_length * item.load.force / unit
        if item.body >= FIRST_ROLLER and np.hypot(*vector) >= 0.5 * ARROW_WIDTH:
            tail = (sketch.centres[item.body - FIRST_ROLLER] + item.load.point) / unit
            arrows.append(arrow(tail, tail + vector, ARROW_WIDTH))
    if arrows:
        page.stroke(arrows, "white", HALO)
        page.fill(arrows, FORCE)
    _legend(page, sketch)
    for panel in inset:
        _orbit(page, panel, sketch)


def _housing(page, sketch):
    look, unit, bore = sketch.look, sketch.bearing.outside_radius, sketch.instant.scene.mounting().bore
    if bore is None:
        inside = float(np.hypot(*sketch.drawn.outlines(sketch.magnification)[3][0])) / unit - 0.01
    else:  # as magnified as the ring in it, and never all of the housing
        inside = min(1.0 + 0.5 * sketch.magnification * bore.clearance / unit, HOUSING_RADIUS - THINNEST_HOUSING)
    zones = [(HOUSING, 0.0, 2.0 * pi)]
    if look.load_zone is not None:
        start, end = look.load_zone
        zones.append((LOAD_ZONE, start, end + 2.0 * pi * (end < start)))
    for colour, start, end in zones:
        page.strip(*(arc((0.0, 0.0), radius, start, end) for radius in (inside, HOUSING_RADIUS)), colour)
    page.stroke(arc((0.0, 0.0), HOUSING_RADIUS), FAINT, OUTLINE)
    middle = 0.5 * (max(inside + 0.01, 1.0) + HOUSING_RADIUS)
    for j, centre in enumerate(sketch.drawn.roller_reference):
        page.text(str(j), *(middle * centre / np.hypot(*centre)), SMALL, QUIET, align="center")


def bars(instant: Instant) -> list[np.ndarray]:
    """Outlines of the cage's bars between the rollers, (n, 2), m; none without a cage.
    They are drawn where they are: a cage's play is a thousand times the bodies' displacements, and is not magnified."""
    facts, bearing = instant.scene.ideal_cage(), instant.model.bearing
    if facts is None or instant.cage is None:
        return []
    half, wide = bearing.roller_radius + 0.5 * facts.pocket_clearance, BAR * bearing.roller_radius
    across = np.linspace(-wide, wide, WALL_POINTS)
    ahead = np.full(WALL_POINTS, half)
    if facts.guidance == "rollers":  # round pockets
        ahead = np.sqrt(np.maximum(half**2 - across**2, 0.0))
    wall = bearing.pitch_radius + across + 1j * ahead  # of a pocket, from inside to outside; its roller on the x axis
    between = np.exp(2j * pi / bearing.pockets)
    before, after = wall, np.conj(wall) * between  # of the pocket behind, of the one in front
    arcs = (np.geomspace(*ends, BAR_POINTS) for ends in ((before[-1], after[-1]), (after[0], before[0])))
    bar = np.concatenate([before, next(arcs), after[::-1], next(arcs)])
    first = np.exp(1j * (instant.operation.first_roller_angle + instant.cage[2]))
    turned = (bar * first * between**j for j in range(bearing.pockets))
    return [instant.cage[:2] + np.column_stack([each.real, each.imag]) for each in turned]


def _dots(plane, sketch):  # dots that turn with the rollers and the rings that turn
    instant, bearing = sketch.instant, sketch.bearing
    if not any(instant.operation.ring_speeds):
        return
    places = [
        *(sketch.centres + DOT[0] * bearing.roller_radius * unit_vector(instant.roller_turn)),
        sketch.hub + 0.5 * (bearing.core_radius + bearing.inner_raceway_radius) * unit_vector(instant.ring_turn),
    ]
    if instant.operation.outer_speed != 0.0:
        middle = 0.5 * (bearing.outer_raceway_radius + bearing.outside_radius)
        places.append(middle * unit_vector(instant.outer_turn))
    for size, colour in ((1.35, INK), (1.0, "white")):
        plane.fill([arc(place, size * DOT[1] * bearing.roller_radius) for place in places], colour)


def _shaft(page, sketch, hub, bore):
    """The hub's centre, the outer ring's centre, the load and how both rings turn."""
    operation, size = sketch.instant.operation, min(27.0, 75.0 * bore)
    page.stroke(canvas.cross((0.0, 0.0), 0.16 * bore), FAINT, 1.5)
    if operation.radial_load > 0.0:
        page.fill(arrow(hub, hub + np.array([0.0, -0.80 * bore]), 0.075 * bore), INK)
        page.text("W", hub[0] + 0.16 * bore, hub[1] - 0.55 * bore, size, bold=True)
    page.fill(arc(hub, 0.05 * bore), INK)
    for speed, centre, radius, low, width in (
        (operation.speed, hub, 0.78 * bore, 0.28, 0.05 * bore),
        (operation.outer_speed, (0.0, 0.0), HOUSING_RADIUS + 0.035, 0.42, 0.016),
    ):
        if speed != 0.0:
            ends = (pi * low, pi * (1.0 - low))[:: 1 if speed > 0.0 else -1]
            canvas.turning_arrow(page, centre, radius, *ends, width)
    if operation.speed != 0.0:
        page.text("n", hub[0], hub[1] + 0.56 * bore, size, bold=True, align="center")


def _legend(page, sketch):
    instant, look, bearing = sketch.instant, sketch.look, sketch.bearing
    _title(page, sketch, EDGE, TOP, 0.105)
    page.text(f"{look.scale.title}, {look.scale.unit}", COLUMN, COLOUR_BAR[1] + 0.10, HEADING, bold=True)
    page.colour_bar(look.scale, COLUMN, *COLOUR_BAR)
    forces = instant.inner_force, instant.outer_force, instant.roller_force
    if look.scale.field == "displacement":
        notes = ["from undeformed parts that just touch", ""]
    else:
        note = instant.model.stress_note
        pressure, roller, kind = max(
            (law.pair.peak_pressure(float(force.max())), int(force.argmax()), kind)
            for law, force, kind in zip(instant.model.laws, forces, ("inner", "outer", "next"), strict=True)
        )  # Hertz's, the largest of all contacts
        place = f" (roller {roller}, {kind})" if pressure > 0.0 else ""
        notes = [f"of the mesh, {note}," if note else "with Hertz's stress below the grid,"]
        notes.append(f"p₀ = {1e-6 * pressure:.0f} MPa{place}")
    bore, clearance = instant.scene.mounting().bore, 2.0 * bearing.radial_clearance
    x, y_hub = (_signed(round(1e6 * value, 2)) for value in instant.hub)
    facts = [f"hub (dot): x = {x}, y = {y_hub} µm", f"from the {'bore' if bore else 'outer ring'}'s centre (cross)"]
    gaps = [(bore.clearance, "play in the bore", "press fit")] if bore else []
    if abs(clearance) > 1e-12:
        gaps.append((clearance, "clearance", "preload"))
    facts += [f"{open_ if gap >= 0.0 else tight} {1e6 * abs(gap):.3g} µm, magnified too" for gap, open_, tight in gaps]
    if spalls(bearing):
        facts.append("spalls: depth that rollers reach")
    if (factor := bodies.chart_factor(bearing)) is not None:
        facts.append(f"heights from white circles × {factor:g}")
    y = _texts(page, COLUMN, COLOUR_BAR[0] - 0.12, notes, TEXT, LINE)
    for heading, lines in ((f"Displacement × {look.magnification:g}", facts), ("Contact force on the rollers", ())):
        page.text(heading, COLUMN, y - 0.055, HEADING, bold=True)
        y = _texts(page, COLUMN, y - 0.055 - 1.15 * LINE, lines, TEXT, LINE)
    if (largest := max(force.max() for force in forces)) > 0.0:
        force = rounded_down(look.largest_force)
        end = COLUMN + force * look.arrow_length / bearing.outside_radius
        page.fill(arrow((COLUMN, y), (end, y), ARROW_WIDTH), FORCE)
        page.text(f"{force:g} N     largest {largest:.0f} N", end + 0.04, y, TEXT)
    else:
        page.text("none", COLUMN, y, TEXT)
    if look.load_zone is not None:
        start, end = look.load_zone
        wide = np.degrees((end - start) % (2.0 * pi))
        page.text(f"shaded: load zone, {wide:.0f}°", COLUMN, y - LINE, TEXT, QUIET)
    _length_bar(page, COLUMN, y - 2.4 * LINE, 1e3 * bearing.outside_radius)


def _orbit(page, inset, sketch):
    left, bottom, size = ORBIT
    x, y, tall = left + size + 0.04, bottom + size - 0.05, inset.view.tall
    page.text("Hub's orbit", x, y, HEADING, bold=True)
    inset.stroke(sketch.look.orbit, "#7f7f7f", 1.2)
    inset.fill(arc(1e6 * sketch.instant.hub, 0.035 * tall), ORBIT_DOT)
    inset.frame()
    length = rounded_down(0.5 * tall)
    y -= 1.3 * LINE
    page.stroke(np.array([(x, y), (x + length / tall * size, y)]), INK, 3.0)
    page.text(f"{length:g} µm", x, y - 0.9 * LINE, TEXT)
    page.text("whole run; dot: now", x, y - 1.9 * LINE, TEXT, QUIET)


# ---- one roller between its raceways

CLOSEUP = View(middle=(2.0 / 3.0, 0.5), tall=1.0)
ROLLER = View(left=0.0, bottom=0.0, right=0.50, top=0.885, middle=(0.0, 0.0), tall=3.25)
CONTACTS = tuple(  # inner, outer
    View(left=0.61, bottom=bottom, right=0.86, top=bottom + 1.0 / 3.0, middle=(0.0, 0.0), tall=7.0)
    for bottom in (0.574, 0.102)
)
FINEST_ROLLER, COARSEST_ROLLER = 0.003, 0.06  # of a roller's radius: triangles of its panel
FINEST_BELOW, RELATIVE_BELOW = 0.06, 0.12  # of a half-width, of the distance from the contact: of a contact's panel
REACH = 2.6  # roller radii around the roller's centre that its panel can see
BARS = (0.685, 0.22, 0.72), (1.172, 0.24, 0.74)  # left, bottom and top of the roller's scale, of the contacts'
BAR_WIDTH = 0.020
FACTS, FACTS_APART = 20.0, 0.027  # pixels, of the page's height
CROSS = 0.16  # half the size of a mark


def _paint_closeup(sketch, page, main, *contacts):
    look = sketch.look
    _title(page, sketch, 0.02, 0.97, 0.042, 0.071)
    _roller(main, sketch)
    for panel, kind in zip(contacts, ("inner", "outer"), strict=True):
        _contact(page, panel, sketch, kind)
    page.text(look.scale.title, BARS[0][0], 0.965, HEADING, bold=True)
    for scale, (x, bottom, top) in zip((look.scale, look.contact_scale), BARS, strict=True):
        page.text(scale.unit, x, top + 0.035, HEADING, bold=True)
        page.colour_bar(scale, x, bottom, top, BAR_WIDTH)
    if look.scale.field != "displacement":
        lines = ["half plane:", f"{LARGEST_SHEAR:.3f} p₀,", f"{AT_DEPTH:.2f} b deep"]
        _texts(page, BARS[1][0], BARS[1][1] - 0.035, lines, FACTS, FACTS_APART)


def _direction(sketch, kind):  # from the ring's centre to the roller's, rad
    return getattr(sketch.instant, f"{kind}_angle")[sketch.look.roller]


def _is_over_a_spall(sketch, kind):
    """Whether the contact's line of centres meets a spall: then its edges carry the force."""
    j, bearing, instant, direction = sketch.look.roller, sketch.bearing, sketch.instant, _direction(sketch, kind)
    on_ring = direction - (instant.ring_turn if kind == "inner" else instant.outer_turn)
    on_roller = direction + pi * (kind == "inner") - instant.roller_turn[j]
    for spall in spalls(bearing):
        if spall.body == f"{kind}_ring" or spall.roller == j:
            angle = on_ring if spall.roller is None else on_roller
            beyond = abs((angle - spall.angle + pi) % (2.0 * pi) - pi)
            if beyond < spall.half_opening(bearing.roller_radius) / own_radius(bearing, spall):
                return True
    return False


def _turned(panel, sketch, origin, unit):
    """A panel for points in m from an origin: the outer raceway below."""
    turn = -0.5 * pi - _direction(sketch, "outer")
    return panel.placed(lambda points: rotated(points - origin, turn) / unit)


def _roller(main, sketch):  # the whole roller, with the mesh and the bodies' names
    drawn, radius, j = sketch.drawn, sketch.bearing.roller_radius, sketch.look.roller
    centre = drawn.roller_reference[j]
    plane = _turned(main, sketch, centre, radius)
    fine = drawn.near(centre, REACH * radius).refined(FINEST_ROLLER * radius, COARSEST_ROLLER * radius, RELATIVE)
    _bodies(plane, sketch, fine, sketch.look.scale, radius)
    left, tall = -0.48 * main.wide, ROLLER.tall
    angle = (np.degrees(_direction(sketch, "outer")) + 90.0 + 180.0) % 360.0 - 180.0
    name = f"roller {j}, {_signed(round(angle, 1))}° from the load"
    main.text("inner ring", left, 0.47 * tall, TEXT, backed=True)
    main.text("outer ring", left, -0.41 * tall, TEXT, backed=True)
    main.text(name, 0.0, 0.0, TEXT, backed=True, align="center")
    _length_bar(main, left + 0.02, -0.46 * tall, 1e3 * radius, backed=True)


def _contact(page, panel, sketch, kind):
    """The field around one contact, how wide it is, where the shear is largest; and the numbers around its panel."""
    b, j, drawn, view = sketch.look.half_width, sketch.look.roller, sketch.drawn, panel.view
    angle, tall = _direction(sketch, kind) + pi * (kind == "inner"), view.tall
    point = drawn.roller_reference[j] + sketch.bearing.roller_radius * unit_vector(angle)
    near = drawn.near(point, 1.5 * drawn.spacing + tall * b)
    fine = near.refined(FINEST_BELOW * b, 0.5 * drawn.spacing, RELATIVE_BELOW)
    _bodies(_turned(panel, sketch, point, b), sketch, fine, sketch.look.contact_scale, b, mesh=False)
    panel.frame()
    _length_bar(panel, -0.46 * panel.wide, -0.44 * tall, 1e3 * b, longest=2.0, backed=True)
    force, left = getattr(sketch.instant, f"{kind}_force")[j], ASPECT * view.left
    page.text(f"{kind.capitalize()} contact: {force:.0f} N", left, view.top + 0.022, HEADING, bold=True)
    lines, over = ["open"] if force <= 0.0 else [], _is_over_a_spall(sketch, kind)
    if force > 0.0 and over:
        lines = ["over a spall: its edge carries the force,", "below which the stress is not shown"]
    for item in () if over else drawn.loads:
        if (item.kind, item.roller) != (kind, j) or item.is_rigid:
            continue
        peak = shear_peak(drawn, item)
        if not lines:
            lines.append(f"p₀ = {1e-6 * peak.pressure:.0f} MPa   2b = {2e6 * peak.half_width:.0f} µm")
        name, depth = "roller" if item.body >= FIRST_ROLLER else "ring", peak.depth / peak.half_width
        lines.append(f"+ {name}: shear {peak.shear / peak.pressure:.3f} p₀, {depth:.2f} b deep")
        upright = rotated(item.load.inward, -0.5 * pi - _direction(sketch, "outer"))[1]  # ±1, of the inward normal
        half = peak.half_width / b
        panel.stroke(np.array([[-half, 0.0], [half, 0.0]]), "white", 5.0)
        for colour, pixels in ((INK, 5.0), ("white", 2.5)):
            panel.stroke(canvas.cross((0.0, upright * peak.depth / b), CROSS), colour, pixels)
    _texts(page, left, view.bottom - 0.021, lines, FACTS, FACTS_APART)
