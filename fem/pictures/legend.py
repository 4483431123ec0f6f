"""What stands beside a picture: title, colour scale, magnification, force and length scales, the hub's orbit."""

from math import pi

import numpy as np

from fem.pictures.canvas import INK, Canvas, Panel, View, arrow, bar, border, cells, disc, frame, line
from fem.pictures.look import Look
from fem.pictures.recover import Instant
from fem.pictures.scale import Scale, rounded_down
from fem.pictures.surfaces import chart_factor
from lagrange.load_history import load_share
from lagrange.scene.operation import RPM
from lagrange.section import load_factor
from lagrange.surface.passages import spalls

TITLE, HEADING, TEXT, SMALL = 38.0, 26.0, 23.0, 19.0  # pixels of 1600
QUIET, ORBIT_DOT = "#4d4d4d", "#0072b2"
# places in outside radii
EDGE, TOP = -1.18, 1.325  # of the title
COLUMN = 1.25  # left edge of the legend
LINE = 0.085  # between lines of text
BAR = (0.47, 1.00, 0.08)  # bottom, top, width
ORBIT = (1.25, -1.19, 0.46)  # left, bottom, size
TIP = 0.0065  # of a page's height: half the ends of a length bar
ORBIT_MARGIN = 1.35  # of the orbit's extent


def draw_legend(canvas: Canvas, instant: Instant, look: Look, force_colour: str) -> None:
    """Beside a whole bearing."""
    page = canvas.panels[0]
    draw_title(page, instant, look, EDGE, TOP, (0.105,))
    page.text(f"{look.scale.title}, {look.scale.unit}", COLUMN, BAR[1] + 0.10, HEADING, bold=True)
    draw_scale(page, look.scale, COLUMN, *BAR)
    y = _lines(page, BAR[0] - 0.12, scale_notes(instant, look.scale))
    y = _heading(page, f"Displacement × {look.magnification:g}", y)
    x, y_hub = (signed(round(1e6 * value, 2)) for value in instant.hub)
    bore, clearance = instant.scene.mounting().bore, 2.0 * instant.model.bearing.radial_clearance
    facts = [f"hub (dot): x = {x}, y = {y_hub} µm"]
    facts.append(f"from the {'outer ring' if bore is None else 'bore'}'s centre (cross)")
    gaps = [] if bore is None else [("play in the bore" if bore.clearance >= 0.0 else "press fit", bore.clearance)]
    if abs(clearance) > 1e-12:
        gaps.append(("clearance" if clearance > 0.0 else "preload", clearance))
    facts += [f"{name} {1e6 * abs(gap):.3g} µm, magnified too" for name, gap in gaps]
    y = _lines(page, y, facts + _surface_notes(instant))
    y = _heading(page, "Contact force on the rollers", y)
    largest = max(instant.inner_force.max(), instant.outer_force.max(), instant.roller_force.max())
    if largest > 0.0:
        unit = rounded_down(look.largest_force)
        end = COLUMN + unit * look.arrow_length
        page.fill(arrow((COLUMN, y), (end, y), 0.017, 0.4), force_colour)
        page.text(f"{unit:g} N     largest {largest:.0f} N", end + 0.04, y, TEXT)
    else:
        page.text("none", COLUMN, y, TEXT)
    y -= LINE
    if look.load_zone is not None:
        start, end = look.load_zone
        wide = np.degrees((end - start) % (2.0 * pi))
        page.text(f"shaded: load zone, {wide:.0f}°", COLUMN, y, TEXT, QUIET)
    y -= 1.4 * LINE
    draw_length(page, COLUMN, y, 1e3 * instant.model.bearing.outside_radius)
    if look.orbit is not None:
        _orbit(canvas, instant, look)


def _surface_notes(instant: Instant) -> list[str]:
    """Lines on the surfaces that are not perfect."""
    bearing, found = instant.model.bearing, []
    if spalls(bearing):
        found.append("spalls: depth that rollers reach")
    factor = chart_factor(bearing)
    return found if factor is None else [*found, f"heights from white circles × {factor:g}"]


def draw_title(page: Panel, instant: Instant, look: Look, x: float, y: float, lines: tuple[float, ...]) -> None:
    """Name, time, operation, model and damping; an animation's pace.

    `lines` : how far below the title facts stand, and model and damping where they have a line of their own
    """
    scene, operation = instant.scene, instant.operation
    page.text(f"{scene.name}:  t = {1e3 * instant.time:.6g} ms", x, y, TITLE, bold=True)
    bearing, numerics = instant.model.bearing, scene.numerics
    whole = load_factor(bearing) * operation.radial_load  # of the bearing
    load = f"W = {whole:.6g} N"
    if numerics.start == "rest" and 1e3 * instant.time < numerics.load_ramp_ms:
        share = load_share(instant.time, 1e-3 * numerics.load_ramp_ms)
        load = f"W = {share * whole:.4g} N of {whole:.6g} N"
    rpm = round(operation.speed / RPM, 1) if scene.operation.speed_table else scene.operation.speed_rpm
    turning = f"n = {signed(rpm)} rpm"
    if operation.outer_speed:
        turning += f" (outer ring {signed(round(operation.outer_speed / RPM, 1))} rpm)"
    rows = "" if bearing.rows == 1 else f"{bearing.rows} × "
    facts = [turning, load, f"{rows}{scene.bearing.present} rollers"]
    if bearing.contact_angle:
        facts.append(f"section at {bearing.contact_angle_deg:.4g}°")
    if scene.bodies.rigid:
        both = len(scene.bodies.rigid) == 2
        facts.append("rigid rings" if both else f"rigid {scene.bodies.rigid[0].replace('_', ' ')}")
    method = scene.method + (", stress from its forces" if scene.model == "lagrange" else "")
    pace = [look.pace] if look.pace else []
    below, *further = lines
    page.text("   ".join([*facts, *pace] if further else [*facts, method, *pace]), x, y - below, HEADING)
    for at in further:
        page.text(method, x, y - at, SMALL, QUIET)


def draw_scale(page: Panel, scale: Scale, x: float, bottom: float, top: float, width: float) -> None:
    """The colour bar with its ticks."""
    unit = 0.0005 * page.view.tall
    n = 65
    y = np.linspace(bottom, top, n)
    points = np.concatenate([np.column_stack([np.full(n, at), y]) for at in (x, x + width)])
    k = np.arange(n - 1)
    low, high = scale.limits
    page.field(
        cells(points, np.column_stack([k, n + k, n + k + 1, k + 1]), 0.0),
        np.tile(np.linspace(low, high, n), 2), scale.limits, scale.colours,
    )  # fmt: skip
    page.stroke(frame((x, bottom), width, top - bottom, 0.1), QUIET, 1.2)
    ticks = scale.ticks()
    at = [bottom + share * (top - bottom) for share, _ in ticks]
    page.stroke([line(np.array([(x + width, y), (x + width + 15 * unit, y)]), 0.1) for y in at], QUIET, 1.2)
    for y, (_, label) in zip(at, ticks, strict=True):
        page.text(label, x + width + 30 * unit, y, TEXT)


def scale_notes(instant: Instant, scale: Scale) -> list[str]:
    """Two lines on what the colours show."""
    if scale.field == "displacement":
        return ["from undeformed parts that just touch", ""]
    note = instant.model.stress_note
    return [f"of the mesh, {note}," if note else "with Hertz's stress below the grid,", hertz(instant)]


def signed(value: float) -> str:
    """A number with a true minus sign, and no negative zero."""
    return f"{value + 0.0:g}".replace("-", "−")


def hertz(instant: Instant) -> str:
    """The largest Hertz pressure of all contacts and where it is."""
    forces = instant.inner_force, instant.outer_force, instant.roller_force
    contacts = zip(instant.model.laws, forces, ("inner", "outer", "next"), strict=True)
    found = [(law.pair.peak_pressure(float(force.max())), int(force.argmax()), kind) for law, force, kind in contacts]
    pressure, roller, kind = max(found, key=lambda item: item[0])
    place = f" (roller {roller}, {kind})" if pressure > 0.0 else ""
    return f"p₀ = {1e-6 * pressure:.0f} MPa{place}"


def draw_length(page: Panel, x: float, y: float, unit: float, longest: float = 0.5, backed: bool = False) -> None:
    """A bar of a round length; `unit`, mm, is what one length of the plane stands for; `backed`: on a white ground."""
    length = rounded_down(longest * unit)
    end, tip = x + length / unit, TIP * page.view.tall / (page.view.top - page.view.bottom)
    if backed:
        page.fill(bar((x - tip, y - 2.0 * tip), end - x + 2.5 * tip, 4.0 * tip, 0.09), "white", opacity=0.75)
    page.stroke([line(np.array([(x, y), (end, y)]), 0.1),
                 *(line(np.array([(at, y - tip), (at, y + tip)]), 0.1) for at in (x, end))], INK, 3.0)  # fmt: skip
    page.text(f"{length:g} mm", end + 2.0 * tip, y, TEXT, backed=backed)


def orbit_view(page: View, orbit: np.ndarray) -> View:
    """The inset's place on a page 4 wide and 3 high, and its plane: the orbit, µm."""
    left, bottom, size = ORBIT
    wide, tall = page.tall * 4.0 / 3.0, page.tall
    x, y = (left - page.middle[0]) / wide + 0.5, (bottom - page.middle[1]) / tall + 0.5
    low, high = orbit.min(axis=0), orbit.max(axis=0)
    extent = ORBIT_MARGIN * max(high - low)
    return View(
        left=x, bottom=y, right=x + size / wide, top=y + size / tall,
        middle=(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])), tall=extent,
    )  # fmt: skip


def _orbit(canvas: Canvas, instant: Instant, look: Look) -> None:
    page, inset = canvas.panels[:2]
    left, bottom, size = ORBIT
    page.text("Hub's orbit", left + size + 0.04, bottom + size - 0.05, HEADING, bold=True)
    inset.stroke(line(look.orbit, 0.0), "#7f7f7f", 1.2)
    inset.fill(disc(1e6 * instant.hub, 0.035 * inset.view.tall, 0.1), ORBIT_DOT)
    inset.stroke(border(inset.view.middle, inset.wide, inset.view.tall, 0.2), QUIET, 1.5)
    unit = rounded_down(0.5 * inset.view.tall)
    length = unit / inset.view.tall * size
    at = bottom + size - 0.05 - 1.3 * LINE
    page.stroke(line(np.array([(left + size + 0.04, at), (left + size + 0.04 + length, at)]), 0.1), INK, 3.0)
    page.text(f"{unit:g} µm", left + size + 0.04, at - 0.9 * LINE, TEXT)
    page.text("whole run; dot: now", left + size + 0.04, at - 1.9 * LINE, TEXT, QUIET)


def _heading(page: Panel, text: str, y: float) -> float:
    page.text(text, COLUMN, y - 0.055, HEADING, bold=True)
    return y - 0.055 - 1.15 * LINE


def _lines(page: Panel, y: float, lines: list[str]) -> float:
    for text in lines:
        page.text(text, COLUMN, y, TEXT, QUIET)
        y -= LINE
    return y
