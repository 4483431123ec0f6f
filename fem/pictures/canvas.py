"""An off-screen page of panels, each a rectangle of a plane seen from above, and the flat shapes on it.

What is drawn later lies on top. Fonts and line widths are in pixels of a page 1600 wide.
"""

import os
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib  # for its fonts and colour maps
import numpy as np
import pyvista as pv
from matplotlib.patches import FancyArrow
from PIL import Image

from fem.pictures.output import rendering_failure
from lagrange.errors import UsageError

if TYPE_CHECKING:
    from fem.pictures.look import Scale

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # no warning without display

ASPECT = 4.0 / 3.0  # of a picture
FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
BOLD = FONT.replace("DejaVuSans", "DejaVuSans-Bold")
REFERENCE_WIDTH = 1600.0
FINER = 2  # rendered that much finer, then averaged: anti-aliasing that does not depend on the driver
LARGEST_WINDOW = 8192  # pixels
STEP = 1e-3  # in height, from what is drawn to what comes to lie on top of it
INK, QUIET = "#1a1a1a", "#4d4d4d"
NO_VALUE = "#c9c9c9"
FAULT = "#ff9900"  # of surfaces that are not perfect
ARC_POINTS, SHADES = 361, 256  # of a circle; of a scale
Shapes = np.ndarray | Sequence[np.ndarray]  # one, (n, 2), many of one length, (m, n, 2), or of any


@dataclass(frozen=True, kw_only=True)
class View:
    """A panel's place on the page, in shares from the lower left corner, and what it shows of its plane."""

    left: float = 0.0
    bottom: float = 0.0
    right: float = 1.0
    top: float = 1.0
    middle: tuple[float, float]
    tall: float  # from the lower to the upper edge, in the plane's lengths

    # of a page 1600 wide, in the plane's lengths
    pixel = property(lambda self: self.tall * ASPECT / (REFERENCE_WIDTH * (self.top - self.bottom)))


class Panel:
    """One renderer of a page."""

    def __init__(self, canvas: "Canvas", index: int, view: View):
        self._canvas, self._index, self.view, self._place = canvas, index, view, np.asarray
        (width, height), renderer = canvas.size, canvas.plotter.renderers[index]
        # from the left to the right edge, in the plane's lengths
        self.wide = view.tall * (view.right - view.left) * width / ((view.top - view.bottom) * height)
        renderer.SetViewport(view.left, view.bottom, view.right, view.top)
        renderer.SetBackground(1.0, 1.0, 1.0)
        camera = renderer.camera
        camera.parallel_projection = True  # not by the plotter's methods: each of them renders
        camera.focal_point, camera.position, camera.up = (*view.middle, 0.0), (*view.middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_scale, camera.clipping_range = 0.5 * view.tall, (1.0, 20.0)

    def placed(self, place: Callable[[np.ndarray], np.ndarray]) -> "Panel":
        """The same panel for points, (n, 2), that `place` takes to its plane."""
        panel = copy(self)
        panel._place = place
        return panel

    def fill(self, polygons: Shapes, color: str, opacity: float = 1.0) -> None:
        """Areas of one colour, convex or not; their outlines may be closed."""
        shapes = [polygons] if isinstance(polygons, np.ndarray) else polygons
        shapes = [shape[: -1 if np.allclose(shape[0], shape[-1]) else None] for shape in shapes]
        self._add(self._mesh(shapes, "faces").triangulate(), color=color, opacity=opacity)

    def stroke(self, lines: Shapes, color: str, pixels: float, opacity: float = 1.0) -> None:
        """Open polylines."""
        self._add(self._mesh(lines, "lines"), color=color, line_width=pixels * self._canvas.pixel, opacity=opacity)

    def strip(self, one: np.ndarray, other: np.ndarray, color: str) -> None:
        """The area between two lines of as many points."""
        self._add(self._mesh(_between(one, other), "faces"), color=color)

    def field(self, points: np.ndarray, triangles: np.ndarray, values: np.ndarray, scale: "Scale") -> None:
        """Triangles coloured by nodal values; beyond the scale's limits the ends' colours, without a value NO_VALUE."""
        mesh = pv.PolyData.from_regular_faces(self._lifted(points), triangles)
        self._colour(mesh, np.ma.filled(scale.norm(values), np.nan), scale)

    def colour_bar(self, scale: "Scale", left: float, bottom: float, top: float, width: float) -> None:
        """The colours of a scale, its ticks at their right."""
        pixel, right, height = self.view.pixel, left + width, np.linspace(bottom, top, SHADES + 1)
        edges = (np.column_stack([np.full(SHADES + 1, x), height]) for x in (left, right))
        self._colour(self._mesh(_between(*edges), "faces"), np.linspace(0.0, 1.0, SHADES), scale)
        self.stroke(box((left + 0.5 * width, 0.5 * (bottom + top)), 0.5 * width, 0.5 * (top - bottom)), QUIET, 1.2)
        for share, label in scale.ticks():
            y = bottom + share * (top - bottom)
            self.stroke(np.array([(right, y), (right + 9.0 * pixel, y)]), QUIET, 1.2)
            self.text(label, right + 18.0 * pixel, y, 23.0)

    def text(self, text: str, x: float, y: float, size: float, color=INK, bold=False, align="left", backed=False):
        """Text whose left, center or right lies at (x, y), halfway up; `backed`: on white that shines through."""
        actor, ground = pv.Text(text), {"background_color": "white", "background_opacity": 0.75} if backed else {}
        actor.prop = pv.TextProperty(
            color=color, font_file=BOLD if bold else FONT, font_size=round(size * self._canvas.pixel),
            justification_horizontal=align, justification_vertical="center", **ground,
        )  # fmt: skip
        place = actor.GetPositionCoordinate()
        place.SetCoordinateSystemToWorld()
        place.SetValue(*self._place(np.array([[x, y]]))[0], 0.0)
        self._plotter().add_actor(actor, render=False, reset_camera=False)

    def frame(self) -> None:
        """The panel's outline, just inside."""
        self.stroke(box(self.view.middle, 0.497 * self.wide, 0.497 * self.view.tall), QUIET, 1.5)

    def _mesh(self, shapes, kind):
        if isinstance(shapes, np.ndarray) and shapes.ndim == 2:
            shapes = [shapes]
        points, sizes = np.concatenate(shapes), np.array([len(shape) for shape in shapes])
        cells = np.insert(np.arange(len(points)), np.cumsum(sizes) - sizes, sizes)
        return pv.PolyData(self._lifted(points), **{kind: cells})

    def _lifted(self, points):
        return np.column_stack([self._place(points), np.full(len(points), self._canvas.height)])

    def _plotter(self):
        self._canvas.plotter.subplot(0, self._index)
        return self._canvas.plotter

    def _colour(self, mesh, shares, scale):
        self._add(
            mesh, scalars=shares, clim=(0.0, 1.0), cmap=scale.colours, n_colors=SHADES, interpolate_before_map=True,
            nan_color=NO_VALUE, show_scalar_bar=False,
        )  # fmt: skip

    def _add(self, mesh, **how):
        self._plotter().add_mesh(mesh, lighting=False, render=False, reset_camera=False, **how)
        self._canvas.height += STEP


class Canvas:
    """A page; later panels lie on top of earlier ones. Frames of a film share one: new ones take twice as long."""

    def __init__(self, width: int, height: int, views: Sequence[View]):
        self._finer = FINER if FINER * width <= LARGEST_WINDOW else 1
        self.size, self.height = (width, height), 0.0
        self.pixel = width * self._finer / REFERENCE_WIDTH
        self.plotter = pv.Plotter(
            off_screen=True, window_size=(width * self._finer, height * self._finer), lighting="none",
            shape=(1, len(views)), border=False,
        )  # fmt: skip
        self.plotter.render_window.SetMultiSamples(0 if self._finer > 1 else 8)
        self.panels = tuple(Panel(self, index, view) for index, view in enumerate(views))

    def clear(self) -> None:
        """An empty page again, for the next frame."""
        self.height = 0.0
        for renderer in self.plotter.renderers:
            renderer.clear_actors()

    def image(self) -> np.ndarray:
        """(height, width, 3) bytes. UsageError: the driver draws nothing."""
        self.plotter.render()
        pixels = np.ascontiguousarray(self.plotter.screenshot(return_img=True)[..., :3])
        if pixels.min() == pixels.max():
            raise UsageError(rendering_failure("the picture is blank"))
        return np.asarray(Image.fromarray(pixels).reduce(self._finer))


# Points of shapes, (n, 2); outlines are closed


def _between(one, other):  # quadrilaterals, (n − 1, 4, 2), between two lines
    return np.stack([one[:-1], other[:-1], other[1:], one[1:]], axis=1)


def arc(centre, radius: float, start: float = 0.0, end: float = 2.0 * np.pi) -> np.ndarray:
    """An arc, or a circle."""
    angle = np.linspace(start, end, ARC_POINTS)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def box(middle, half_wide: float, half_tall: float) -> np.ndarray:
    """A rectangle's outline."""
    return np.asarray(middle) + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * [half_wide, half_tall]


def cross(middle, arm: float) -> list[np.ndarray]:
    """Two lines, along x and y."""
    return [np.asarray(middle) + np.array([[-arm, 0.0], [arm, 0.0]])[:, way] for way in ([0, 1], [1, 0])]


def arrow(tail, tip, width: float) -> np.ndarray:
    """An arrow of a given shaft width, thinner where it is short."""
    along = np.subtract(tip, tail)
    head = min(3.2 * width, 0.8 * float(np.hypot(*along)))
    wide = 3.0 * head / 3.2
    shape = FancyArrow(*tail, *along, width=min(width, 0.5 * wide), head_width=wide, head_length=head,
                       length_includes_head=True)  # fmt: skip
    return shape.get_xy()


def turning_arrow(panel: Panel, centre, radius: float, start: float, end: float, width: float) -> None:
    """Draw an arrow bent about `centre`, from angle `start` to `end`."""
    head = np.sign(end - start) * 3.2 * width / radius
    panel.strip(*(arc(centre, radius + side * 0.5 * width, start, end - 0.98 * head) for side in (-1.0, 1.0)), INK)
    base, tip = (np.array([np.cos(angle), np.sin(angle)]) for angle in (end - head, end))
    corners = [(radius - 1.5 * width) * base, (radius + 1.5 * width) * base, radius * tip]
    panel.fill(np.asarray(centre) + np.array(corners), INK)
