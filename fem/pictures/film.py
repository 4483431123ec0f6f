"""Frames made into a film: MP4 by ffmpeg, which imageio-ffmpeg brings along, or an animated GIF by Pillow."""

from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

from fem.pictures.target import MARK
from lagrange.files.output import replaced

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
