"""An off-screen plane to draw on, seen along the bearing's axis.

Lengths in outside radii; fonts and line widths in pixels of a picture 1600 wide.
"""

import os
from pathlib import Path

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # no warning without display

import matplotlib  # for its fonts
import numpy as np
import pyvista as pv

FONT = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
BOLD = FONT.replace("DejaVuSans", "DejaVuSans-Bold")
FROM_FILE = 4  # VTK_FONT_FILE
REFERENCE_WIDTH = 1600.0
FINER = 2  # rendered that much finer, then averaged: anti-aliasing that does not depend on the driver
LARGEST_WINDOW = 8192  # pixels
INK = "#1a1a1a"


class Canvas:
    """A rectangle of the plane around `middle`, `tall` outside radii high; use as a context manager."""

    def __init__(self, width: int, height: int, middle: tuple[float, float], tall: float):
        self._finer = FINER if FINER * width <= LARGEST_WINDOW else 1
        self._size = width, height
        self._pixel = width * self._finer / REFERENCE_WIDTH
        self._plotter = pv.Plotter(
            off_screen=True, window_size=(width * self._finer, height * self._finer), lighting="none"
        )
        self._plotter.render_window.SetMultiSamples(0 if self._finer > 1 else 8)
        self._plotter.renderer.SetBackground(1.0, 1.0, 1.0)
        camera = self._plotter.camera
        camera.parallel_projection = True  # not by the plotter's methods: each of them renders
        camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_scale = 0.5 * tall
        camera.clipping_range = (1.0, 20.0)

    def fill(self, mesh: pv.PolyData, color: str) -> None:
        """An area of one colour."""
        self._add(mesh, color=color)

    def stroke(self, mesh: pv.PolyData, color: str, pixels: float) -> None:
        """A line."""
        self._add(mesh, color=color, line_width=pixels * self._pixel)

    def field(self, mesh: pv.PolyData, values: np.ndarray, limit: float, colours: str, edges: bool) -> None:
        """An area coloured by nodal values from 0 to `limit`."""
        wires = {
            "show_edges": True,
            "edge_color": "white",
            "edge_opacity": 0.25,
            "line_width": 0.7 * self._pixel,
        }
        self._add(
            mesh, scalars=values, clim=(0.0, limit), cmap=colours, n_colors=256, interpolate_before_map=True,
            show_scalar_bar=False, **(wires if edges else {}),
        )  # fmt: skip

    def text(
        self, text: str, x: float, y: float, size: float, color: str = INK, bold=False, align: str = "left"
    ) -> None:
        """Text whose left, center or right lies at (x, y), halfway up."""
        actor = pv.Text(text)
        actor.prop.SetFontFamily(FROM_FILE)
        actor.prop.SetFontFile(BOLD if bold else FONT)
        actor.prop.font_size = round(size * self._pixel)
        actor.prop.color = color
        actor.prop.justification_horizontal, actor.prop.justification_vertical = align, "center"
        actor.prop.SetLineSpacing(1.2)
        place = actor.GetPositionCoordinate()
        place.SetCoordinateSystemToWorld()
        place.SetValue(x, y, 0.0)
        self._plotter.add_actor(actor, render=False, reset_camera=False)

    def image(self) -> np.ndarray:
        """(height, width, 3) bytes."""
        (width, height), finer = self._size, self._finer
        pixels = np.asarray(self._plotter.screenshot(return_img=True))[..., :3]
        blocks = pixels.reshape(height, finer, width, finer, 3).astype(np.uint16)
        return (blocks.sum(axis=(1, 3)) // finer**2).astype(np.uint8)

    def _add(self, mesh: pv.PolyData, **how) -> None:
        self._plotter.add_mesh(mesh, lighting=False, render=False, reset_camera=False, **how)

    def __enter__(self) -> "Canvas":
        return self

    def __exit__(self, *_) -> None:
        self._plotter.close()
