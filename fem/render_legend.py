"""What stands beside the bearing: title, stress scale, magnification, force and length scales."""

from math import cos, floor, log10, pi

import numpy as np

from fem.model import peak_pressure
from fem.recover import Instant
from fem.render_canvas import Canvas
from fem.render_shapes import arrow, cells, line

EDGE, TOP = -1.18, 1.325  # of the title, in outside radii
COLUMN = 1.25  # left edge of the legend
TITLE, HEADING, TEXT = 38.0, 26.0, 23.0  # pixels of 1600
LINE = 0.088  # between lines of text
BAR = (0.20, 0.94, 0.08)  # bottom, top, width
QUIET = "#4d4d4d"
ROUND = (1.0, 2.0, 5.0)


def draw_legend(
    canvas: Canvas, instant: Instant, magnification: float, colours: str, limit: float, force_length: float,
    force_colour: str,
) -> None:  # fmt: skip
    """`limit`: end of the stress scale, Pa; `force_length`: outside radii per N, 0 without contact forces."""
    _title(canvas, instant)
    _stress_scale(canvas, colours, limit)
    y = _lines(canvas, BAR[0] - 0.12, ["mesh far field; Hertz peak", _hertz(instant)])
    y = _heading(canvas, f"Displacement × {magnification:g}", y)
    x, y_hub = (_signed(round(1e6 * value, 2)) for value in instant.hub)
    facts = [f"hub (dot): x = {x}, y = {y_hub} µm", "from the outer ring's centre (cross)"]
    clearance = 2e6 * instant.model.bearing.radial_clearance
    if abs(clearance) > 1e-6:
        name = "clearance" if clearance > 0.0 else "preload"
        facts.append(f"{name} {abs(clearance):.3g} µm, magnified too")
    y = _lines(canvas, y, facts)
    y = _heading(canvas, "Contact force on the rollers", y)
    if force_length > 0.0:
        largest = max(instant.inner_force.max(), instant.outer_force.max(), instant.roller_force.max())
        unit = rounded_down(float(largest))
        canvas.fill(arrow((COLUMN, y), (COLUMN + unit * force_length, y), 0.017, 0.4), force_colour)
        canvas.text(f"{unit:g} N     largest {largest:.0f} N", COLUMN + unit * force_length + 0.04, y, TEXT)
    else:
        canvas.text("none", COLUMN, y, TEXT)
    y -= 1.9 * LINE
    _length_scale(canvas, instant, y)


def rounded_down(value: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above a value > 0."""
    decade = 10.0 ** floor(log10(value))
    return decade * max(step for step in ROUND if step * decade <= value * (1.0 + 1e-12))


def _title(canvas: Canvas, instant: Instant) -> None:
    scene, operation = instant.scene, instant.operation
    canvas.text(f"{scene.name}:  t = {1e3 * instant.time:.6g} ms", EDGE, TOP, TITLE, bold=True)
    load, numerics = f"W = {operation.radial_load:g} N", scene.numerics
    if numerics.start == "rest" and 1e3 * instant.time < numerics.load_ramp_ms:
        share = 0.5 * (1.0 - cos(pi * 1e3 * instant.time / numerics.load_ramp_ms))
        load = f"W = {share * operation.radial_load:.4g} N of {operation.radial_load:g} N"
    facts = [f"n = {_signed(scene.operation.speed_rpm)} rpm", load, f"{scene.bearing.rollers} rollers"]
    if scene.model == "lagrange":
        facts.append("Lagrangian model, stress from its forces")
    canvas.text("   ".join(facts), EDGE, TOP - 0.105, HEADING)


def _stress_scale(canvas: Canvas, colours: str, limit: float) -> None:
    bottom, top, width = BAR
    canvas.text("von Mises stress, MPa", COLUMN, top + 0.09, HEADING, bold=True)
    y = np.linspace(bottom, top, 65)
    points = np.concatenate([np.column_stack([np.full(65, x), y]) for x in (COLUMN, COLUMN + width)])
    k = np.arange(64)
    canvas.field(
        cells(points, np.column_stack([k, 65 + k, 66 + k, k + 1]), 0.0),
        np.tile(np.linspace(0.0, limit, 65), 2), limit, colours, edges=False,
    )  # fmt: skip
    corners = [
        (COLUMN, bottom),
        (COLUMN + width, bottom),
        (COLUMN + width, top),
        (COLUMN, top),
        (COLUMN, bottom),
    ]
    canvas.stroke(line(np.array(corners), 0.1), QUIET, 1.2)
    for share in np.linspace(0.0, 1.0, _intervals(limit) + 1):
        at = bottom + share * (top - bottom)
        canvas.stroke(line(np.array([(COLUMN + width, at), (COLUMN + width + 0.02, at)]), 0.1), QUIET, 1.2)
        canvas.text(f"{1e-6 * share * limit:.4g}", COLUMN + width + 0.04, at, TEXT)


def _intervals(limit: float) -> int:
    """How many round intervals the scale is divided into."""
    for count in (5, 4, 3):
        step = limit / count
        if round(step / 10.0 ** floor(log10(step) + 1e-9), 6) in (1.0, 2.0, 3.0, 4.0, 5.0):
            return count
    return 4


def _signed(value: float) -> str:
    """A number with a true minus sign, and no negative zero."""
    return f"{value + 0.0:g}".replace("-", "−")


def _hertz(instant: Instant) -> str:
    """The largest Hertz pressure of all contacts and where it is."""
    model, thickness = instant.model, instant.model.bearing.roller_length
    found = [
        (peak_pressure(law, float(force.max()), thickness), int(force.argmax()), kind)
        for law, force, kind in (
            (model.inner_law, instant.inner_force, "inner"),
            (model.outer_law, instant.outer_force, "outer"),
            (model.roller_law, instant.roller_force, "next"),
        )
    ]
    pressure, roller, kind = max(found, key=lambda item: item[0])
    place = f" (roller {roller}, {kind})" if pressure > 0.0 else ""
    return f"p₀ = {1e-6 * pressure:.0f} MPa{place}"


def _length_scale(canvas: Canvas, instant: Instant, y: float) -> None:
    radius = 1e3 * instant.model.bearing.outside_radius  # mm
    unit = rounded_down(0.5 * radius)
    end = COLUMN + unit / radius
    canvas.stroke(line(np.array([(COLUMN, y), (end, y)]), 0.1), "#1a1a1a", 3.0)
    for x in (COLUMN, end):
        canvas.stroke(line(np.array([(x, y - 0.02), (x, y + 0.02)]), 0.1), "#1a1a1a", 3.0)
    canvas.text(f"{unit:g} mm", end + 0.04, y, TEXT)


def _heading(canvas: Canvas, text: str, y: float) -> float:
    canvas.text(text, COLUMN, y - 0.075, HEADING, bold=True)
    return y - 0.075 - 1.15 * LINE


def _lines(canvas: Canvas, y: float, lines: list[str]) -> float:
    for text in lines:
        canvas.text(text, COLUMN, y, TEXT, QUIET)
        y -= LINE
    return y
