"""A figure that has been written, and the colours of curves: for all that shows figures without drawing any."""

import re
from dataclasses import dataclass
from pathlib import Path

WIDTH, DPI = 7.0, 150  # inches: about one page's text width, still legible when a phone shrinks it
LARGEST_SVG = 120_000  # bytes; beyond, pixels are embedded where they take less room
# Okabe and Ito's palette, distinguished by colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#7F7F7F",
)  # fmt: skip
# of Tol's muted palette (Paul Tol's Notes, SRON/EPS/TN/09-002), where eight colours are too few
INDIGO, OLIVE, WINE = "#332288", "#999933", "#882255"
TERM_COLOURS = {  # of the budget; other_forces stands in the place of ring_flexibility
    "error": "black", "contact_law": RED, "damping": PURPLE, "friction": GREEN, "cage": SKY, "ring_flexibility": BLUE,
    "other_forces": BLUE, "differentiation": GREY, "outer_ring": INDIGO, "shaft": ORANGE, "load_and_weight": OLIVE,
    "momentum": WINE,
}  # fmt: skip
LINE_COLOURS = {"FTF": PURPLE, "shaft": GREY, "outer ring": OLIVE, "BSF": ORANGE, "BPFO": RED, "BPFI": GREEN}


@dataclass(frozen=True, kw_only=True)
class SavedFigure:
    """A figure that has been written, with its title and caption."""

    name: str
    title: str
    caption: str
    png: Path
    svg: Path


def family(line: str) -> str:
    """Kinematic line that a harmonic or sideband belongs to: "3×BPFO", "2×BPFO+shaft" -> "BPFO"."""
    return re.split("[+−]", line)[0].rpartition("×")[2]
