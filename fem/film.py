"""Frames made into a film: MP4 by ffmpeg, which imageio-ffmpeg brings along, or an animated GIF by Pillow."""

import itertools
import os
from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

KINDS = (".mp4", ".gif")
QUALITY = "18"  # x264's constant rate factor; text stays sharp
GIF_COLOURS = 255


def write_film(target: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """Write the images, (height, width, 3) bytes, heights and widths even, as a film; whole or not at all.

    Errors
    ------
    OSError: it can't be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.stem}.part{target.suffix}")
    try:
        (_write_gif if target.suffix.lower() == ".gif" else _write_mp4)(part, images, frames_per_second)
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)


def _write_mp4(target: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    first = next(images)
    height, width, _ = first.shape
    writer = imageio_ffmpeg.write_frames(
        str(target), (width, height), fps=frames_per_second, codec="libx264", quality=None, macro_block_size=2,
        output_params=["-crf", QUALITY, "-movflags", "+faststart", "-fflags", "+bitexact"], ffmpeg_log_level="error",
    )  # fmt: skip
    try:
        writer.send(None)
        writer.send(np.ascontiguousarray(first))
        for image in images:
            writer.send(np.ascontiguousarray(image))
    finally:
        writer.close()


def _write_gif(target: Path, images: Iterator[np.ndarray], frames_per_second: float) -> None:
    """One palette for all frames, that of the first, so that colours keep their meaning."""
    first = next(images)
    palette = Image.fromarray(first).quantize(GIF_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    frames = (
        Image.fromarray(image).quantize(palette=palette, dither=Image.Dither.NONE)
        for image in itertools.chain([first], images)
    )
    next(frames).save(
        target, format="GIF", save_all=True, append_images=frames, duration=round(1e3 / frames_per_second), loop=0,
        optimize=False,
    )  # fmt: skip
