"""The picture of a whole bearing at one instant, drawn off-screen; the same instant gives the same picture.

Call `fem.rendering_probe.check_rendering` before importing this: where system libraries are missing, the
renderer does not raise but ends the process.
"""

from math import floor, log10
from pathlib import Path

import numpy as np
from PIL import Image

from fem.recover import Instant
from fem.render_bodies import DrawnBearing, chosen_magnification, drawn_bearing
from fem.render_canvas import INK, Canvas
from fem.render_legend import draw_legend
from fem.render_shapes import arrow, cells, circle, disc, line, ring, turning_arrow

ASPECT = 4.0 / 3.0
MIDDLE, TALL = (0.525, 0.085), 2.64  # what is seen, in outside radii
COLOURS = "viridis"
HOUSING, SHAFT, FAINT, FORCE = "#e3e3e3", "#f4f4f4", "#8a8a8a", "#d7301f"
HOUSING_RADIUS = 1.09
OUTLINE = 1.5  # pixels
ARROW_WIDTH = 0.017
LONGEST_ARROW = 0.85  # of a roller's radius
# round ends of the stress scale, times a power of ten
LIMITS = (1.0, 1.2, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def draw(instant: Instant, target: Path, *, magnification: float | None = None, width: int = 1600) -> None:
    """Write the picture as PNG, `width` pixels wide; magnification None: chosen.

    Errors
    ------
    OSError: `target` can't be written.
    """
    image = picture(instant, magnification, width)
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(image).save(target, format="PNG")


def picture(instant: Instant, magnification: float | None = None, width: int = 1600) -> np.ndarray:
    """The picture, (height, width, 3) bytes."""
    drawn = drawn_bearing(instant)
    if magnification is None:
        magnification = chosen_magnification(drawn, instant.model.bearing.outside_radius)
    limit = stress_limit(drawn)
    with Canvas(width, round(width / ASPECT), MIDDLE, TALL) as canvas:
        _draw_bodies(canvas, instant, drawn, magnification, limit)
        _draw_shaft(canvas, instant, drawn, magnification)
        length = _draw_forces(canvas, instant, drawn, magnification)
        draw_legend(canvas, instant, magnification, COLOURS, limit, length, FORCE)
        return canvas.image()


def stress_limit(drawn: DrawnBearing) -> float:
    """Round end of the stress scale, Pa: nothing lies beyond it."""
    largest = max(float(body.stress.max()) for body in drawn.bodies)
    if largest <= 0.0:
        return 1e6
    decade = 10.0 ** floor(log10(largest))
    return decade * min(end for end in LIMITS if end * decade >= largest)


def _draw_bodies(canvas: Canvas, instant: Instant, drawn: DrawnBearing, magnification: float, limit: float) -> None:
    scale = 1.0 / instant.model.bearing.outside_radius
    inside = scale * float(np.hypot(*drawn.outer_ring.outlines(magnification)[1].T).mean())
    canvas.fill(ring(inside - 0.01, HOUSING_RADIUS, -0.02), HOUSING)
    canvas.stroke(circle((0.0, 0.0), HOUSING_RADIUS, -0.01), FAINT, OUTLINE)
    for k, body in enumerate(drawn.bodies):
        mesh = cells(scale * body.points(magnification), body.cells, 0.001 * k)
        canvas.field(mesh, body.stress, limit, COLOURS, edges=True)
        for outline in body.outlines(magnification):
            canvas.stroke(line(scale * outline, 0.1), INK, OUTLINE)
    middle = 0.5 * (inside + HOUSING_RADIUS)
    for j, centre in enumerate(drawn.roller_reference):
        x, y = middle * centre / np.hypot(*centre)
        canvas.text(str(j), x, y, 19.0, "#4d4d4d", align="center")


def _draw_shaft(canvas: Canvas, instant: Instant, drawn: DrawnBearing, magnification: float) -> None:
    """The hub as a disc, with its centre, the outer ring's centre, the load and the sense of rotation."""
    scale = 1.0 / instant.model.bearing.outside_radius
    hub, bore = scale * magnification * drawn.hub, scale * instant.model.bearing.bore_radius
    size = min(27.0, 75.0 * bore)
    canvas.fill(disc(hub, bore, 0.05), SHAFT)
    canvas.stroke(circle(hub, bore, 0.06), INK, OUTLINE)
    arm = 0.16 * bore
    canvas.stroke(line(np.array([[-arm, 0.0], [arm, 0.0]]), 0.2), FAINT, 1.5)
    canvas.stroke(line(np.array([[0.0, -arm], [0.0, arm]]), 0.2), FAINT, 1.5)
    operation = instant.operation
    if operation.radial_load > 0.0:
        tip = hub + np.array([0.0, -0.80 * bore])
        canvas.fill(arrow(hub, tip, 0.075 * bore, 0.3), INK)
        canvas.text("W", hub[0] + 0.16 * bore, hub[1] - 0.55 * bore, size, bold=True)
    canvas.fill(disc(hub, 0.05 * bore, 0.31), INK)
    if operation.speed != 0.0:
        ends = (0.28, 0.72) if operation.speed > 0.0 else (0.72, 0.28)
        for mesh in turning_arrow(hub, 0.78 * bore, np.pi * ends[0], np.pi * ends[1], 0.05 * bore, 0.3):
            canvas.fill(mesh, INK)
        canvas.text("n", hub[0], hub[1] + 0.56 * bore, size, bold=True, align="center")


def _draw_forces(canvas: Canvas, instant: Instant, drawn: DrawnBearing, magnification: float) -> float:
    """Arrows from the contacts into the rollers; returns their length per force, outside radii per N."""
    bearing = instant.model.bearing
    scale = 1.0 / bearing.outside_radius
    largest = max(float(np.max(force)) for force in (instant.inner_force, instant.outer_force, instant.roller_force))
    if largest <= 0.0:
        return 0.0
    length = LONGEST_ARROW * bearing.roller_radius * scale / largest
    for tails, forces in contact_forces(instant):
        centres = drawn.roller_reference + magnification * drawn.roller_shift
        for centre, tail, force in zip(centres, tails, forces, strict=True):
            vector = length * force
            if np.hypot(*vector) < 0.5 * ARROW_WIDTH:
                continue
            start = scale * (centre + tail)
            canvas.fill(arrow(start, start + vector, ARROW_WIDTH, 0.40, border=0.25 * ARROW_WIDTH), "white")
            canvas.fill(arrow(start, start + vector, ARROW_WIDTH, 0.41), FORCE)
    return length


def contact_forces(instant: Instant) -> list[tuple[np.ndarray, np.ndarray]]:
    """By kind of contact: where it acts on the rollers, m from the centre, and the force with traction, N."""
    radius = instant.model.bearing.roller_radius
    inner, outer = _directions(instant.inner_angle), _directions(instant.outer_angle)
    following = np.roll(instant.centres, -1, axis=0) - instant.centres
    ahead = following / np.hypot(*following.T)[:, None]
    pushed = instant.roller_force[:, None] * ahead
    return [
        (
            -radius * inner[0],
            instant.inner_force[:, None] * inner[0] + instant.inner_traction[:, None] * inner[1],
        ),
        (
            radius * outer[0],
            -instant.outer_force[:, None] * outer[0] + instant.outer_traction[:, None] * outer[1],
        ),
        (radius * ahead, -pushed),
        (-radius * np.roll(ahead, 1, axis=0), np.roll(pushed, 1, axis=0)),
    ]


def _directions(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radial and counter-clockwise unit vectors, each (n, 2)."""
    return np.column_stack([np.cos(angle), np.sin(angle)]), np.column_stack([-np.sin(angle), np.cos(angle)])
