"""An off-screen page of panels, each a rectangle of a plane seen from above, and the flat shapes on it.

Fonts and line widths are in pixels of a page 1600 wide.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib  # for its fonts and colour maps
import numpy as np
import pyvista as pv
from PIL import Image

from fem.pictures.drawing_process import rendering_failure
from lagrange.errors import UsageError

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # no warning without display

ASPECT = 4.0 / 3.0  # of a picture
FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
BOLD = FONT.replace("DejaVuSans", "DejaVuSans-Bold")
FROM_FILE = 4  # VTK_FONT_FILE
REFERENCE_WIDTH = 1600.0
FINER = 2  # rendered that much finer, then averaged: anti-aliasing that does not depend on the driver
LARGEST_WINDOW = 8192  # pixels
INK = "#1a1a1a"
NO_VALUE = "#c9c9c9"
FAULT = "#ff9900"  # of surfaces that are not perfect
Meshes = pv.PolyData | Sequence[pv.PolyData]


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
        self._canvas, self._index, self.view = canvas, index, view
        renderer = canvas._plotter.renderers[index]
        renderer.SetViewport(view.left, view.bottom, view.right, view.top)
        renderer.SetBackground(1.0, 1.0, 1.0)
        camera = renderer.camera
        camera.parallel_projection = True  # not by the plotter's methods: each of them renders
        middle = view.middle
        camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_scale = 0.5 * view.tall
        camera.clipping_range = (1.0, 20.0)

    @property
    def wide(self) -> float:
        """From the left to the right edge, in the plane's lengths."""
        view, (width, height) = self.view, self._canvas.size
        return view.tall * (view.right - view.left) * width / ((view.top - view.bottom) * height)

    def fill(self, meshes: Meshes, color: str, opacity: float = 1.0) -> None:
        """Areas of one colour."""
        self._add(_joined(meshes), color=color, opacity=opacity)

    def stroke(self, meshes: Meshes, color: str, pixels: float, opacity: float = 1.0) -> None:
        """Lines."""
        self._add(_joined(meshes), color=color, line_width=pixels * self._canvas.pixel, opacity=opacity)

    def field(self, mesh: pv.PolyData, values: np.ndarray, limits: tuple[float, float], colours: str) -> None:
        """An area coloured by nodal values; beyond the limits the ends' colours, where there is no value NO_VALUE."""
        self._add(
            mesh, scalars=values, clim=limits, cmap=colours, n_colors=256, interpolate_before_map=True,
            nan_color=NO_VALUE, show_scalar_bar=False,
        )  # fmt: skip

    def text(
        self, text: str, x: float, y: float, size: float, color: str = INK, bold=False, align: str = "left",
        backed=False,
    ) -> None:  # fmt: skip
        """Text whose left, center or right lies at (x, y), halfway up; `backed`: on white that shines through."""
        actor = pv.Text(text)
        actor.prop.SetFontFamily(FROM_FILE)
        actor.prop.SetFontFile(BOLD if bold else FONT)
        actor.prop.font_size = round(size * self._canvas.pixel)
        actor.prop.color = color
        actor.prop.justification_horizontal, actor.prop.justification_vertical = align, "center"
        if backed:
            actor.prop.background_color, actor.prop.background_opacity = "white", 0.75
        actor.prop.SetLineSpacing(1.2)
        place = actor.GetPositionCoordinate()
        place.SetCoordinateSystemToWorld()
        place.SetValue(x, y, 0.0)
        self._activate().add_actor(actor, render=False, reset_camera=False)

    def _activate(self) -> pv.Plotter:
        plotter = self._canvas._plotter
        plotter.subplot(0, self._index)
        return plotter

    def _add(self, mesh: pv.PolyData, **how) -> None:
        self._activate().add_mesh(mesh, lighting=False, render=False, reset_camera=False, **how)


class Canvas:
    """A page; later panels lie on top of earlier ones. Use as a context manager."""

    def __init__(self, width: int, height: int, views: Sequence[View]):
        self._finer = FINER if FINER * width <= LARGEST_WINDOW else 1
        self.size = width, height
        self.pixel = width * self._finer / REFERENCE_WIDTH
        self._plotter = pv.Plotter(
            off_screen=True, window_size=(width * self._finer, height * self._finer), lighting="none",
            shape=(1, len(views)), border=False,
        )  # fmt: skip
        self._plotter.render_window.SetMultiSamples(0 if self._finer > 1 else 8)
        self.panels = tuple(Panel(self, index, view) for index, view in enumerate(views))

    def clear(self) -> None:
        """An empty page again, for the next frame."""
        for renderer in self._plotter.renderers:
            renderer.clear_actors()

    def image(self) -> np.ndarray:
        """(height, width, 3) bytes. UsageError: the driver draws nothing."""
        self._plotter.render()
        pixels = np.ascontiguousarray(self._plotter.screenshot(return_img=True)[..., :3])
        if pixels.min() == pixels.max():
            raise UsageError(rendering_failure("the picture is blank"))
        return np.asarray(Image.fromarray(pixels).reduce(self._finer))

    def __enter__(self) -> "Canvas":
        return self

    def __exit__(self, *_) -> None:
        self._plotter.close()


def _joined(meshes: Meshes) -> pv.PolyData:
    if isinstance(meshes, pv.PolyData):
        return meshes
    first, *others = meshes
    return first.append_polydata(*others) if others else first


# Flat shapes of a picture as pyvista meshes: discs, rings, arcs, arrows. z orders them.
ARC_POINTS = 361


def polygon(points: np.ndarray, z: float) -> pv.PolyData:
    """A filled polygon, convex or not; (n, 2)."""
    face = np.concatenate([[len(points)], np.arange(len(points))])
    return pv.PolyData(_lifted(points, z), faces=face).triangulate()


def disc(centre, radius: float, z: float) -> pv.PolyData:
    """A filled circle."""
    return polygon(arc(centre, radius, 0.0, 2.0 * np.pi)[:-1], z)


def circle(centre, radius: float, z: float) -> pv.PolyData:
    """The outline of a circle."""
    return line(arc(centre, radius, 0.0, 2.0 * np.pi), z)


def ring(inner: float, outer: float, z: float, start: float = 0.0, end: float = 2.0 * np.pi) -> pv.PolyData:
    """The area between two circles about the origin, or a sector of it, rad."""
    return strip(*(arc((0.0, 0.0), radius, start, end) for radius in (inner, outer)), z)


def _corners(corner, width: float, height: float) -> np.ndarray:
    return np.asarray(corner) + np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def bar(corner, width: float, height: float, z: float) -> pv.PolyData:
    """A rectangle by its lower left corner."""
    return polygon(_corners(corner, width, height), z)


def frame(corner, width: float, height: float, z: float) -> pv.PolyData:
    """The outline of a rectangle."""
    return line(_corners(corner, width, height)[[0, 1, 2, 3, 0]], z)


def border(middle: tuple[float, float], wide: float, tall: float, z: float) -> pv.PolyData:
    """The outline of a panel around its middle, just inside."""
    wide, tall = 0.994 * wide, 0.994 * tall
    return frame((middle[0] - 0.5 * wide, middle[1] - 0.5 * tall), wide, tall, z)


def segments(points: np.ndarray, pairs: np.ndarray, z: float) -> pv.PolyData:
    """Straight lines between pairs of points."""
    return pv.PolyData(_lifted(points, z), lines=np.column_stack([np.full(len(pairs), 2), pairs]).ravel())


def cells(points: np.ndarray, corners: np.ndarray, z: float | np.ndarray) -> pv.PolyData:
    """A mesh of triangles or quadrilaterals; z of all or of each point."""
    faces = np.column_stack([np.full(len(corners), corners.shape[1]), corners])
    return pv.PolyData(_lifted(points, z), faces=faces.ravel())


def line(points: np.ndarray, z: float) -> pv.PolyData:
    """An open polyline."""
    return pv.PolyData(_lifted(points, z), lines=np.concatenate([[len(points)], np.arange(len(points))]))


def strip(one: np.ndarray, other: np.ndarray, z: float) -> pv.PolyData:
    """The area between two lines of as many points."""
    k, n = np.arange(len(one) - 1), len(one)
    return cells(np.concatenate([one, other]), np.column_stack([k, n + k, n + k + 1, k + 1]), z)


def arc(centre, radius: float, start: float, end: float) -> np.ndarray:
    """Points along an arc, (ARC_POINTS, 2)."""
    angle = np.linspace(start, end, ARC_POINTS)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def arrow(tail, tip, width: float, z: float, border: float = 0.0) -> pv.PolyData:
    """A filled arrow of a given shaft width; `border` grows its outline on all sides."""
    tail, tip = np.asarray(tail, dtype=float), np.asarray(tip, dtype=float)
    length = float(np.hypot(*(tip - tail)))
    along = (tip - tail) / length
    across = np.array([-along[1], along[0]])
    half, head_half = 0.5 * width, 1.5 * width
    head = min(3.2 * width, 0.8 * length)
    head_half *= head / (3.2 * width)
    half = min(half, 0.5 * head_half)
    slope = np.hypot(head, head_half)
    # a border parallel to the head's sides moves its tip by border / sin(half angle)
    x = np.array([-border, length - head - border, length - head - border, length + border * slope / head_half])
    barb = head_half + border * (slope + head_half) / head
    y = np.array([half + border, half + border, barb, 0.0])
    x, y = np.concatenate([x, x[2::-1]]), np.concatenate([y, -y[2::-1]])
    return polygon(tail + np.outer(x, along) + np.outer(y, across), z)


def turning_arrow(
    centre, radius: float, start: float, end: float, width: float, z: float
) -> tuple[pv.PolyData, pv.PolyData]:
    """Shaft and head of an arrow bent about `centre`, from angle `start` to `end`."""
    head = np.sign(end - start) * 3.2 * width / radius
    edges = [arc(centre, radius + side * 0.5 * width, start, end - 0.98 * head) for side in (-1.0, 1.0)]
    shaft = strip(*edges, z)
    base = np.array([np.cos(end - head), np.sin(end - head)])
    tip = radius * np.array([np.cos(end), np.sin(end)])
    corners = np.array([(radius - 1.5 * width) * base, (radius + 1.5 * width) * base, tip])
    return shaft, polygon(np.asarray(centre) + corners, z)


def _lifted(points: np.ndarray, z: float | np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), z)])
