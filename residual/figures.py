"""A figure of a report that has been written, and its curves."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A line, or dots, of a figure."""

    panel: str  # name of its y axis
    name: str
    points: np.ndarray  # (n, 2), x and y in the units of the axes


@dataclass(frozen=True, kw_only=True)
class SavedFigure:
    """A figure that has been written, with its title and caption."""

    name: str
    title: str
    caption: str
    png: Path
    svg: Path
    curves: tuple[Curve, ...] = ()  # what it shows
