"""Pictures and films of a run; the same run and request give the same ones."""

import mmap
from collections.abc import Iterator, Sequence
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from fem.errors import UsageError
from fem.pictures import bearing, closeup
from fem.pictures.bodies import drawn_bearing
from fem.pictures.canvas import ASPECT, INK, Canvas
from fem.pictures.look import Request, chosen_look
from fem.pictures.recover import StoredRun
from lagrange.files.output import refuse_special, replaced
from lagrange.messages import shown

MARK = "render-fem"  # in files that have room for a remark
FIELDS = b"von_mises", b"max_shear"  # of meshes with fields, in whatever format
MARKS = {
    ".csv": (b"time_s,inner_ax_m_s2",),
    **dict.fromkeys((".png", ".gif", ".mp4", ".wav"), (MARK.encode(),)),
}


def refuse_foreign(target: Path, force: bool) -> None:
    """Refuse to write where a file stands that this program has not written as such an export.

    Errors
    ------
    UsageError. OSError: it can't be read, or is no plain file.
    """
    refuse_special(target)
    if not force and target.exists() and not _is_ours(target):
        raise UsageError(
            f"{target}: is there already and no export of render-fem; --force replaces it, or name another file"
        )


def _is_ours(path: Path) -> bool:
    """Whether a file of this ending holds what ours hold; an empty one may go."""
    if path.stat().st_size == 0:
        return True
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return all(data.find(mark) >= 0 for mark in MARKS.get(path.suffix.lower(), FIELDS))


SCALE_COLOURS, GREYS = 160, 32  # of a palette
NEARLY_WHITE = 248.0
PACKED = 1  # of PNG; 6 takes twice the time for a tenth less room


class Renderer:
    """Draws samples of a run with scales that fit all of those it is made for.

    Errors
    ------
    UsageError: the request does not suit the run, the run is damaged.
    """

    def __init__(self, run: StoredRun, request: Request, samples: Sequence[int], pace: str = ""):
        self._run = run
        self._view = closeup if request.view == "close-up" else bearing
        self.look = chosen_look(run, request, samples, pace)
        self._size = request.width, 2 * round(0.5 * request.width / ASPECT)

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
        canvas = Canvas(*self._size, self._view.views(self.look))
        self._view.paint(canvas, instant, drawn_bearing(instant), self.look)
        return canvas.image()


def draw(run: StoredRun, target: Path, request: Request, sample: int) -> None:
    """Write one picture as PNG; its text names the run and says what is shown.

    Errors
    ------
    OSError: `target` can't be written. UsageError: as `Renderer`.
    """
    renderer = Renderer(run, request, [sample])
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


QUALITY = "18"  # x264's constant rate factor; text stays sharp


def write_film(
    target: Path, images: Iterator[np.ndarray], frames_per_second: float, palette: np.ndarray
) -> None:  # fmt: skip
    """Write the images, (height, width, 3) bytes, heights and widths even, as a film; whole or not at all.

    Parameters
    ----------
    palette : (n, 3), bytes, n up to 256: the colours of a GIF

    Errors
    ------
    OSError: it can't be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as part:
        if target.suffix.lower() == ".gif":
            _write_gif(part, images, frames_per_second, palette)
        else:
            _write_mp4(part, images, frames_per_second)


def _write_mp4(target: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    first = next(images)
    height, width, _ = first.shape
    writer = imageio_ffmpeg.write_frames(
        str(target), (width, height), fps=frames_per_second, codec="libx264", quality=None, macro_block_size=2,
        output_params=["-crf", QUALITY, "-movflags", "+faststart", "-fflags", "+bitexact",
                       "-metadata", f"comment={MARK}", "-f", "mp4"],
        ffmpeg_log_level="error",
    )  # fmt: skip
    try:
        writer.send(None)
        writer.send(np.ascontiguousarray(first))
        for image in images:
            writer.send(np.ascontiguousarray(image))
    finally:
        writer.close()


def _write_gif(target: Path, images: Iterator[np.ndarray], frames_per_second: float, palette: np.ndarray) -> None:
    """One palette for all frames, so that colours keep their meaning."""
    colours = Image.new("P", (1, 1))
    colours.putpalette(palette.astype(np.uint8).tobytes())
    frames = (Image.fromarray(image).quantize(palette=colours, dither=Image.Dither.NONE) for image in images)
    next(frames).save(
        target, format="GIF", save_all=True, append_images=frames, duration=round(1e3 / frames_per_second), loop=0,
        optimize=False, comment=MARK.encode(),
    )  # fmt: skip
