"""What gives all figures one look: style, colours, marks of kinematic lines, files in PNG and SVG."""

import re
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG

from residual.tick_labels import make_plain

WIDTH = 7.0  # inches; about one page's text width, still legible when a phone shrinks it
DPI = 170
SLIM = 8.5  # width of a panel over that of the slim axis at its right
# Okabe and Ito's palette, told apart by colour-blind readers
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#7F7F7F",
)  # fmt: skip
TERM_COLOURS = {
    "error": "black",
    "contact_law": RED,
    "friction": GREEN,
    "ring_flexibility": BLUE,
    "differentiation": GREY,
    "load_and_weight": ORANGE,
    "momentum": PURPLE,
}
LINE_COLOURS = {"FTF": PURPLE, "shaft": GREY, "BSF": ORANGE, "BPFO": RED, "BPFI": GREEN}
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.labelsize": 11,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "legend.fontsize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "residual",
    "svg.fonttype": "path",
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    "agg.path.chunksize": 20000,
    "axes.formatter.limits": (-4, 5),
    "axes.formatter.useoffset": False,
}


@dataclass(frozen=True, kw_only=True)
class SavedFigure:
    """A figure that has been written, with its title and caption."""

    name: str
    title: str
    caption: str
    png: Path
    svg: Path


def panels(n_rows: int, height: float, **keywords):
    """Make a figure of rows that share their x axis; the figure and its axes."""
    figure, axes = plt.subplots(n_rows, 1, figsize=(WIDTH, height), sharex=True, **keywords)
    axes = np.atleast_1d(axes)
    if n_rows > 1:
        figure.align_ylabels(axes)
    return figure, axes


def panels_beside(n_rows: int, height: float):
    """Make `panels` with a slim axis at the right of each row for `beside_paper`: figure, axes, slim axes."""
    figure, axes = plt.subplots(
        n_rows, 2, figsize=(WIDTH, height), sharex="col", width_ratios=(SLIM, 1.0), squeeze=False
    )
    for axis in axes[:, 1]:
        axis.yaxis.tick_right()
        axis.spines["left"].set_visible(False)
        axis.spines["right"].set_visible(True)
        axis.grid(visible=False)
        axis.set_xlim(0.0, 1.0)
        axis.set_xticks([])
    figure.align_ylabels(axes[:, 0])
    return figure, axes[:, 0], axes[:, 1]


def beside_paper(axis, paper: tuple[float, float], ours: np.ndarray) -> None:
    """Draw the range that the paper's figure shows as a band, and ours as a bar, on a scale of their own."""
    low, high = float(np.min(ours)), float(np.max(ours))
    bottom, top = min(low, paper[0]), max(high, paper[1])
    margin = 0.08 * (top - bottom)
    axis.axhspan(*paper, xmin=0.08, xmax=0.55, color=ORANGE, alpha=0.45, linewidth=0)
    thinnest = 0.012 * (top - bottom)  # a range of nanometres beside one of millimetres would not be seen
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), 0.5 * thinnest)
    axis.axhspan(middle - half, middle + half, xmin=0.62, xmax=0.95, color=BLUE, linewidth=0)
    axis.set_ylim(bottom - margin, top + margin)
    axis.locator_params(axis="y", nbins=4)
    axis.tick_params(axis="y", labelsize=8.5)


def name_slim(axis) -> None:
    """Write above the first slim axis what its band and its bar are."""
    for x, word, colour, side in ((-0.12, "paper", "#8A5A00", "left"), (1.12, "run", BLUE, "right")):
        axis.annotate(word, (x, 1.02), xycoords="axes fraction", fontsize=8.5, color=colour, va="bottom", ha=side)


def save(figure, folder: Path, name: str, title: str, caption: str) -> SavedFigure:
    """Write one figure as PNG and SVG, without a date, so that the same run gives the same files."""
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    make_plain(figure)
    figure.set_dpi(DPI)
    # a canvas' own printing draws once; `savefig` draws twice and lays the panels out in both
    FigureCanvasAgg(figure).print_png(png, metadata={"Software": None, "Title": title})
    figure.set_layout_engine("none")  # laid out by now
    FigureCanvasSVG(figure).print_svg(svg, metadata={"Date": None, "Title": title})
    plt.close(figure)
    return SavedFigure(name=name, title=title, caption=caption, png=png, svg=svg)


def legend_above(axis, columns: int, left: float = 0.0, **style) -> None:
    """Put an axis' legend above it, its left edge a share of the axis' width to the right of the axis' own."""
    axis.legend(loc="lower left", bbox_to_anchor=(left, 1.0), ncols=columns, **{"borderaxespad": 0.2, **style})


def family(line: str) -> str:
    """Kinematic line that a harmonic or sideband belongs to: "3×BPFO", "2×BPFO+shaft" -> "BPFO"."""
    return re.split("[+−]", line)[0].rpartition("×")[2]


def mark_lines(axis, lines: dict[str, float], low: float, high: float, labels: bool) -> list[str]:
    """Mark the kinematic lines within low … high, Hz, by vertical lines; the families drawn."""
    shown = sorted((f, name) for name, f in lines.items() if low <= f <= high)
    previous, level = -np.inf, 0
    for frequency, name in shown:
        axis.axvline(
            frequency,
            color=LINE_COLOURS[family(name)],
            linewidth=1.1 if family(name) == name else 0.8,
            linestyle=(0, (4, 2)) if family(name) == name else (0, (1, 2)),
            zorder=1,
        )
        if labels:
            level = 1 - level if frequency - previous < 0.1 * (high - low) else 0
            axis.annotate(
                name,
                (frequency, 1.02 + 0.065 * level),
                xycoords=("data", "axes fraction"),
                ha="center",
                va="bottom",
                fontsize=9.5,
                color=LINE_COLOURS[family(name)],
            )
            previous = frequency
    return list(dict.fromkeys(family(name) for _, name in shown))


def line_handles(families: list[str], lines: dict[str, float], unit: str = " Hz"):
    """Make the legend's entries of kinematic lines; no unit of orders."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=LINE_COLOURS[name], linestyle=(0, (4, 2)), label=f"{name} {lines[name]:.4g}{unit}")
        for name in families
    ]
