"""An off-screen page of panels, each a rectangle of a plane seen from above, and the flat shapes on it.

What is drawn later lies on top. Fonts and line widths are in pixels of a page 1600 wide.
"""

import os
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path

import matplotlib  # for its fonts and colour maps
import numpy as np
import pyvista as pv
from PIL import Image

from fem.pictures.output import rendering_failure
from lagrange.errors import UsageError

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # no warning without display

ASPECT = 4.0 / 3.0  # of a picture
FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
BOLD = FONT.replace("DejaVuSans", "DejaVuSans-Bold")
FROM_FILE = 4  # VTK_FONT_FILE
REFERENCE_WIDTH = 1600.0
FINER = 2  # rendered that much finer, then averaged: anti-aliasing that does not depend on the driver
LARGEST_WINDOW = 8192  # pixels
STEP = 1e-3  # in height, from what is drawn to what comes to lie on top of it
INK, QUIET = "#1a1a1a", "#4d4d4d"
NO_VALUE = "#c9c9c9"
FAULT = "#ff9900"  # of surfaces that are not perfect
ARC_POINTS = 361
Shapes = np.ndarray | Sequence[np.ndarray]  # (n, 2) each


@dataclass(frozen=True, kw_only=True)
class View:
    """A panel's place on the page, in shares from the lower left corner, and what it shows of its plane."""

    left: float = 0.0
    bottom: float = 0.0
    right: float = 1.0
    top: float = 1.0
    middle: tuple[float, float]
    tall: float  # from the lower to the upper edge, in the plane's lengths


class Panel:
    """One renderer of a page."""

    def __init__(self, canvas: "Canvas", index: int, view: View):
        self._canvas, self._index, self.view, self._place = canvas, index, view, np.asarray
        renderer = canvas.plotter.renderers[index]
        renderer.SetViewport(view.left, view.bottom, view.right, view.top)
        renderer.SetBackground(1.0, 1.0, 1.0)
        camera = renderer.camera
        camera.parallel_projection = True  # not by the plotter's methods: each of them renders
        camera.focal_point, camera.position, camera.up = (*view.middle, 0.0), (*view.middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_scale = 0.5 * view.tall
        camera.clipping_range = (1.0, 20.0)

    def placed(self, place: Callable[[np.ndarray], np.ndarray]) -> "Panel":
        """The same panel for points, (n, 2), that `place` takes to its plane."""
        panel = copy(self)
        panel._place = place
        return panel

    @property
    def wide(self) -> float:
        """From the left to the right edge, in the plane's lengths."""
        view, (width, height) = self.view, self._canvas.size
        return view.tall * (view.right - view.left) * width / ((view.top - view.bottom) * height)

    def fill(self, polygons: Shapes, color: str, opacity: float = 1.0) -> None:
        """Areas of one colour, convex or not."""
        self._add(self._outlined(polygons, "faces").triangulate(), color=color, opacity=opacity)

    def stroke(self, lines: Shapes, color: str, pixels: float, opacity: float = 1.0) -> None:
        """Open polylines."""
        self._add(self._outlined(lines, "lines"), color=color, line_width=pixels * self._canvas.pixel, opacity=opacity)

    def strip(self, one: np.ndarray, other: np.ndarray, color: str) -> None:
        """The area between two lines of as many points."""
        k, n = np.arange(len(one) - 1), len(one)
        self._add(self._mesh(np.concatenate([one, other]), np.column_stack([k, n + k, n + k + 1, k + 1])), color=color)

    def edges(self, points: np.ndarray, pairs: np.ndarray, pixels: float, opacity: float) -> None:
        """White lines between pairs of points."""
        width = pixels * self._canvas.pixel
        self._add(self._mesh(points, pairs, "lines"), color="white", line_width=width, opacity=opacity)

    def field(self, points: np.ndarray, corners: np.ndarray, values, limits, colours: str, height=0.0) -> None:
        """Cells coloured by nodal values; beyond the limits the ends' colours, where there is no value NO_VALUE.

        `height` : of nodes over others, less than STEP
        """
        self._add(
            self._mesh(points, corners, height=height), scalars=values, clim=limits, cmap=colours, n_colors=256,
            interpolate_before_map=True, nan_color=NO_VALUE, show_scalar_bar=False,
        )  # fmt: skip

    def text(self, text: str, x: float, y: float, size: float, color=INK, bold=False, align="left", backed=False):
        """Text whose left, center or right lies at (x, y), halfway up; `backed`: on white that shines through."""
        actor = pv.Text(text)
        actor.prop.SetFontFamily(FROM_FILE)
        actor.prop.SetFontFile(BOLD if bold else FONT)
        actor.prop.font_size = round(size * self._canvas.pixel)
        actor.prop.color = color
        actor.prop.justification_horizontal, actor.prop.justification_vertical = align, "center"
        if backed:
            actor.prop.background_color, actor.prop.background_opacity = "white", 0.75
        place = actor.GetPositionCoordinate()
        place.SetCoordinateSystemToWorld()
        place.SetValue(*self._place(np.array([[x, y]]))[0], 0.0)
        self._activate().add_actor(actor, render=False, reset_camera=False)

    def frame(self) -> None:
        """The panel's outline, just inside."""
        self.stroke(box(self.view.middle, 0.497 * self.wide, 0.497 * self.view.tall), QUIET, 1.5)

    def _outlined(self, shapes: Shapes, kind: str) -> pv.PolyData:
        shapes = [shapes] if isinstance(shapes, np.ndarray) else list(shapes)
        ends = np.cumsum([len(shape) for shape in shapes])
        cells = [part for shape, end in zip(shapes, ends, strict=True)
                 for part in ([len(shape)], np.arange(end - len(shape), end))]  # fmt: skip
        return pv.PolyData(self._lifted(np.concatenate(shapes)), **{kind: np.concatenate(cells)})

    def _mesh(self, points: np.ndarray, corners: np.ndarray, kind: str = "faces", height=0.0) -> pv.PolyData:
        cells = np.column_stack([np.full(len(corners), corners.shape[1]), corners]).ravel()
        return pv.PolyData(self._lifted(points, height), **{kind: cells})

    def _lifted(self, points: np.ndarray, height=0.0) -> np.ndarray:
        return np.column_stack([self._place(points), np.full(len(points), self._canvas.height + height)])

    def _activate(self) -> pv.Plotter:
        self._canvas.plotter.subplot(0, self._index)
        return self._canvas.plotter

    def _add(self, mesh: pv.PolyData, **how) -> None:
        self._activate().add_mesh(mesh, lighting=False, render=False, reset_camera=False, **how)
        self._canvas.height += STEP


class Canvas:
    """A page; later panels lie on top of earlier ones. Use as a context manager."""

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


def arrow(tail, tip, width: float, border: float = 0.0) -> np.ndarray:
    """An arrow of a given shaft width; `border` grows its outline on all sides."""
    tail, tip = np.asarray(tail, dtype=float), np.asarray(tip, dtype=float)
    length = float(np.hypot(*(tip - tail)))
    along = (tip - tail) / length
    across = np.array([-along[1], along[0]])
    head = min(3.2 * width, 0.8 * length)
    head_half = 1.5 * width * head / (3.2 * width)
    half = min(0.5 * width, 0.5 * head_half)
    slope = np.hypot(head, head_half)
    # a border parallel to the head's sides moves its tip by border / sin(half angle)
    x = np.array([-border, length - head - border, length - head - border, length + border * slope / head_half])
    barb = head_half + border * (slope + head_half) / head
    y = np.array([half + border, half + border, barb, 0.0])
    x, y = np.concatenate([x, x[2::-1]]), np.concatenate([y, -y[2::-1]])
    return tail + np.outer(x, along) + np.outer(y, across)


def turning_arrow(panel: Panel, centre, radius: float, start: float, end: float, width: float) -> None:
    """Draw an arrow bent about `centre`, from angle `start` to `end`."""
    head = np.sign(end - start) * 3.2 * width / radius
    panel.strip(*(arc(centre, radius + side * 0.5 * width, start, end - 0.98 * head) for side in (-1.0, 1.0)), INK)
    base, tip = (np.array([np.cos(angle), np.sin(angle)]) for angle in (end - head, end))
    corners = [(radius - 1.5 * width) * base, (radius + 1.5 * width) * base, radius * tip]
    panel.fill(np.asarray(centre) + np.array(corners), INK)
