"""The picture of the run that render-fem has drawn beside it, for the report."""

import base64
from dataclasses import dataclass
from pathlib import Path

from PIL import Image, UnidentifiedImageError

LARGEST = 2_000_000  # bytes


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG as a data address."""

    address: str
    caption: str


def picture_of(run: Path) -> Picture | None:
    """Read `<run>.png` beside a result file, if it is of that run, as its text says, and not older."""
    path = run.with_suffix(".png")
    try:
        if path.stat().st_mtime < run.stat().st_mtime or path.stat().st_size > LARGEST:
            return None
        with Image.open(path) as image:
            told = dict(getattr(image, "text", {}))
        if told.get("Source") != run.name:
            return None
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    except (OSError, UnidentifiedImageError):
        return None
    return Picture(address=f"data:image/png;base64,{data}", caption=told.get("Description", ""))
