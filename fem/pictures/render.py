"""Pictures of a run, drawn off-screen; the same run and request give the same picture.

Call `fem.pictures.drawing_process.check_rendering` before importing this, or use it in a process of its own, as by
`fem.pictures.drawing_process`: where system libraries are missing, the renderer does not raise but ends the process.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from fem.pictures import bearing, closeup
from fem.pictures.bodies import drawn_bearing
from fem.pictures.canvas import ASPECT, INK, Canvas
from fem.pictures.look import Request, chosen_look
from fem.pictures.recover import StoredRun
from fem.pictures.target import MARK
from lagrange.files.output import replaced
from lagrange.messages import shown

SCALE_COLOURS, GREYS = 160, 32  # of a palette
NEARLY_WHITE = 248.0
PACKED = 1  # of PNG; 6 takes twice the time for a tenth less room


class Renderer:
    """Draws samples of a run with scales that fit all of those it is made for; use as a context manager.

    Errors
    ------
    UsageError: the request does not suit the run, the run is damaged.
    """

    def __init__(self, run: StoredRun, request: Request, samples: Sequence[int], pace: str = ""):
        self._run = run
        self._view = closeup if request.view == "close-up" else bearing
        self.look = chosen_look(run, request, samples, pace)
        self._canvas = Canvas(request.width, 2 * round(0.5 * request.width / ASPECT), self._view.views(self.look))

    @property
    def palette(self) -> np.ndarray:
        """Up to 256 colours that show these pictures well, (n, 3) bytes: the scale's, greys, marks and their edges."""
        mixed = [
            share * np.array(to_rgb(colour)) + (1.0 - share) * np.array(to_rgb(ground))
            for colour in bearing.COLOURS
            for ground in ("white", INK)
            for share in (1.0, 0.75, 0.5, 0.25)
        ]
        shades = colormaps[self.look.scale.colours](np.linspace(0.0, 1.0, SCALE_COLOURS))[:, :3]
        greys = np.repeat(np.linspace(0.0, 1.0, GREYS)[:, None], 3, axis=1)
        found = np.unique(np.rint(255.0 * np.concatenate([shades, greys, mixed])), axis=0)
        white_enough = found.min(axis=1) >= NEARLY_WHITE  # Pillow's nearest colour of white would be one of them
        return np.concatenate([found[~white_enough], [[255.0, 255.0, 255.0]]])

    def image(self, sample: int) -> np.ndarray:
        """(height, width, 3) bytes."""
        instant = self._run.instant(sample)
        self._canvas.clear()
        self._view.paint(self._canvas, instant, drawn_bearing(instant), self.look)
        return self._canvas.image()

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(self, *_) -> None:
        self._canvas.__exit__()


def draw(run: StoredRun, target: Path, request: Request, sample: int) -> None:
    """Write one picture as PNG; its text names the run and says what is shown.

    Errors
    ------
    OSError: `target` can't be written. UsageError: as `Renderer`.
    """
    with Renderer(run, request, [sample]) as renderer:
        image = renderer.image(sample)
        seen = "the whole bearing" if request.view == "bearing" else f"roller {renderer.look.roller} in its contacts"
    about = PngInfo()
    about.add_text("Software", MARK)
    about.add_itxt("Source", shown(run.path.name))
    about.add_itxt(
        "Description", f"{renderer.look.scale.title}, {seen} at {1e3 * run.times[sample]:.6g} ms; {run.scene.method}."
    )
    target = Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part:
        Image.fromarray(image).save(part, format="PNG", pnginfo=about, compress_level=PACKED)
