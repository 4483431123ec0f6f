"""An off-screen page of panels to draw on, each a rectangle of a plane seen from above.

Fonts and line widths are in pixels of a page 1600 wide.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # no warning without display

import matplotlib  # for its fonts and colour maps
import numpy as np
import pyvista as pv
from matplotlib.colors import Colormap
from PIL import Image

from fem.errors import UsageError
from fem.pictures.rendering_probe import trouble

FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
BOLD = FONT.replace("DejaVuSans", "DejaVuSans-Bold")
FROM_FILE = 4  # VTK_FONT_FILE
REFERENCE_WIDTH = 1600.0
FINER = 2  # rendered that much finer, then averaged: anti-aliasing that does not depend on the driver
LARGEST_WINDOW = 8192  # pixels
INK = "#1a1a1a"
NO_VALUE = "#c9c9c9"
FAULT = "#ff9900"  # of surfaces that are not perfect


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

    def fill(self, meshes: pv.PolyData | Sequence[pv.PolyData], color: str, opacity: float = 1.0) -> None:
        """Areas of one colour."""
        self._add(_joined(meshes), color=color, opacity=opacity)

    def stroke(
        self, meshes: pv.PolyData | Sequence[pv.PolyData], color: str, pixels: float, opacity: float = 1.0
    ) -> None:
        """Lines."""
        self._add(_joined(meshes), color=color, line_width=pixels * self._canvas.pixel, opacity=opacity)

    def field(
        self, mesh: pv.PolyData, values: np.ndarray, limits: tuple[float, float], colours: str | Colormap
    ) -> None:
        """An area coloured by nodal values; beyond the limits the ends' colours, where there is no value NO_VALUE."""
        size = colours.N if isinstance(colours, Colormap) else 256
        self._add(
            mesh, scalars=values, clim=limits, cmap=colours, n_colors=size, interpolate_before_map=True,
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
        """(height, width, 3) bytes.

        Errors
        ------
        UsageError: the driver draws nothing.
        """
        self._plotter.render()
        pixels = np.ascontiguousarray(self._plotter.screenshot(return_img=True)[..., :3])
        if pixels.min() == pixels.max():
            raise UsageError(trouble("the picture is blank"))
        return np.asarray(Image.fromarray(pixels).reduce(self._finer))

    def __enter__(self) -> "Canvas":
        return self

    def __exit__(self, *_) -> None:
        self._plotter.close()


def _joined(meshes: pv.PolyData | Sequence[pv.PolyData]) -> pv.PolyData:
    if isinstance(meshes, pv.PolyData):
        return meshes
    first, *others = meshes
    return first.append_polydata(*others) if others else first
