"""A page of panels, each a rectangle of a plane seen from above, and the flat shapes on it; drawn by matplotlib.

Fonts and line widths are in pixels of a page 1600 wide.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection, TriMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

ASPECT = 4.0 / 3.0  # of a picture
DPI = 100
POINTS = 72.0 / DPI  # points a pixel
REFERENCE_WIDTH = 1600.0
INK = "#1a1a1a"
NO_VALUE = "#c9c9c9"
FAULT = "#ff9900"  # of surfaces that are not perfect


class Shape(NamedTuple):
    """A polygon or a line of points, (n, 2); larger z lie above smaller ones."""

    points: np.ndarray
    z: float


Shapes = Shape | Sequence[Shape]


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
    """A rectangle of a page; `wide` : from its left to its right edge, in the plane's lengths."""

    def __init__(self, canvas: "Canvas", view: View):
        self.view, self._pixel = view, canvas.pixel
        width, height = canvas.size
        self.wide = view.tall * (view.right - view.left) * width / ((view.top - view.bottom) * height)
        (x, y), half, up = view.middle, 0.5 * self.wide, 0.5 * view.tall
        self._axes = canvas.figure.add_axes(
            (view.left, view.bottom, view.right - view.left, view.top - view.bottom),
            xlim=(x - half, x + half), ylim=(y - up, y + up), xticks=(), yticks=(),
        )  # fmt: skip
        self._axes.spines[:].set_visible(False)

    def fill(self, shapes: Shapes, color: str, opacity: float = 1.0) -> None:
        """Areas of one colour."""
        paths, z = _joined(shapes)
        self._axes.add_collection(PolyCollection(paths, facecolors=color, linewidths=0, alpha=opacity, zorder=z))

    def stroke(self, shapes: Shapes, color: str, pixels: float, opacity: float = 1.0) -> None:
        """Lines."""
        paths, z = _joined(shapes)
        width = POINTS * pixels * self._pixel
        self._axes.add_collection(LineCollection(paths, colors=color, linewidths=width, alpha=opacity, zorder=z))

    def field(
        self, points: np.ndarray, triangles: np.ndarray, values: np.ndarray, norm: Normalize, colours: str
    ) -> None:
        """Triangles coloured by nodal values, later ones above; where there is no value NO_VALUE."""
        colour_map = colormaps[colours].with_extremes(bad=NO_VALUE)
        mesh = TriMesh(Triangulation(*points.T, triangles), norm=norm, cmap=colour_map)
        mesh.set_array(np.ma.masked_invalid(values))
        mesh.set_zorder(0.0)
        self._axes.add_collection(mesh, autolim=False)

    def scale(
        self, norm: Normalize, colours: str, ticks: Sequence[float], corner: tuple[float, float], width: float,
        height: float, size: float,
    ) -> None:  # fmt: skip
        """A bar of colours with its ticks, above its lower left corner; `size` : of the labels."""
        bar = self._axes.inset_axes((*corner, width, height), transform=self._axes.transData)
        drawn = self._axes.figure.colorbar(ScalarMappable(norm, colours), cax=bar, ticks=ticks, format="%.4g")
        drawn.minorticks_off()
        bar.tick_params(labelsize=POINTS * size * self._pixel, colors=INK)

    def text(
        self, text: str, x: float, y: float, size: float, color: str = INK, bold=False, align: str = "left",
        backed=False,
    ) -> None:  # fmt: skip
        """Text whose left, center or right lies at (x, y), halfway up; `backed`: on white that shines through."""
        ground = dict(facecolor="white", edgecolor="none", alpha=0.75, pad=1.0) if backed else None
        self._axes.text(
            x, y, text, fontsize=POINTS * size * self._pixel, color=color, ha=align,
            va="center_baseline", weight="bold" if bold else "normal", bbox=ground, clip_on=True, zorder=1.0,
            parse_math=False,
        )  # fmt: skip


class Canvas:
    """An empty page of panels; later ones lie on top of earlier ones."""

    def __init__(self, width: int, height: int, views: Sequence[View]):
        self.size, self.pixel = (width, height), width / REFERENCE_WIDTH
        self.figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        self.panels = tuple(Panel(self, view) for view in views)

    def image(self) -> np.ndarray:
        """(height, width, 3) bytes."""
        drawn = FigureCanvasAgg(self.figure)
        drawn.draw()
        return np.asarray(drawn.buffer_rgba())[..., :3].copy()


def _joined(shapes: Shapes) -> tuple[list[np.ndarray], float]:
    """Points of all, and how high the highest lies."""
    found = [shapes] if isinstance(shapes, Shape) else shapes
    return [shape.points for shape in found], max(shape.z for shape in found)


# Flat shapes of a picture: discs, rings, arcs, arrows.
ARC_POINTS = 361


def disc(centre, radius: float, z: float) -> Shape:
    """A circle, to be filled or stroked."""
    return Shape(arc(centre, radius, 0.0, 2.0 * np.pi), z)


def ring(inner: float, outer: float, z: float, start: float = 0.0, end: float = 2.0 * np.pi) -> Shape:
    """The area between two circles about the origin, or a sector of it, rad."""
    return strip(*(arc((0.0, 0.0), radius, start, end) for radius in (inner, outer)), z)


def bar(corner, width: float, height: float, z: float) -> Shape:
    """A rectangle by its lower left corner."""
    x, y = corner
    return line([(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)], z)


def border(middle: tuple[float, float], wide: float, tall: float, z: float) -> Shape:
    """The outline of a panel around its middle, just inside."""
    wide, tall = 0.994 * wide, 0.994 * tall
    return bar((middle[0] - 0.5 * wide, middle[1] - 0.5 * tall), wide, tall, z)


def segments(points: np.ndarray, pairs: np.ndarray, z: float) -> list[Shape]:
    """Straight lines between pairs of points."""
    return [Shape(ends, z) for ends in points[pairs]]


def line(points: Sequence, z: float) -> Shape:
    """An open polyline."""
    return Shape(np.asarray(points), z)


def strip(one: np.ndarray, other: np.ndarray, z: float) -> Shape:
    """The area between two lines."""
    return Shape(np.concatenate([one, other[::-1]]), z)


def arc(centre, radius: float, start: float, end: float) -> np.ndarray:
    """Points along an arc, (ARC_POINTS, 2)."""
    angle = np.linspace(start, end, ARC_POINTS)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def arrow(tail, tip, width: float, z: float) -> Shape:
    """A filled arrow of a given shaft width."""
    tail, tip = np.asarray(tail, dtype=float), np.asarray(tip, dtype=float)
    length = float(np.hypot(*(tip - tail)))
    along = (tip - tail) / length
    head = min(3.2 * width, 0.8 * length)
    barb = 1.5 * head / 3.2
    half, neck = min(0.5 * width, 0.5 * barb), length - head
    x = np.array([0.0, neck, neck, length, neck, neck, 0.0, 0.0])
    y = np.array([half, half, barb, 0.0, -barb, -half, -half, half])
    return Shape(tail + np.outer(x, along) + np.outer(y, [-along[1], along[0]]), z)


def turning_arrow(centre, radius: float, start: float, end: float, width: float, z: float) -> tuple[Shape, Shape]:
    """Shaft and head of an arrow bent about `centre`, from angle `start` to `end`."""
    head = np.sign(end - start) * 3.2 * width / radius
    edges = [arc(centre, radius + side * 0.5 * width, start, end - 0.98 * head) for side in (-1.0, 1.0)]
    shaft = strip(*edges, z)
    base = np.array([np.cos(end - head), np.sin(end - head)])
    tip = radius * np.array([np.cos(end), np.sin(end)])
    corners = np.array([(radius - 1.5 * width) * base, (radius + 1.5 * width) * base, tip])
    return shaft, Shape(np.asarray(centre) + corners, z)
