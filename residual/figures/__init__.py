"""One look for all figures: style, panels, legends, colour bars, marks of kinematic lines, labels of ticks, files.

Imports matplotlib. Panels stand at fixed places, in inches, because layouts that measure labels take most of a figure's
time. So do matplotlib's mathematical labels of ticks, in whose place stands plain text.
"""

import re
import zlib
from base64 import b64encode
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogFormatterSciNotation, NullLocator, ScalarFormatter
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from residual.formatting import LINE_COLOURS, RAISED, family

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

WIDTH, DPI = 7.0, 150  # inches: about one page's text width, still legible when a phone shrinks it
LARGEST_SVG = 120_000  # bytes; beyond, pixels are embedded where they take less room
LEFT, RIGHT, SCALE = 0.86, 0.22, 1.0  # inches beside panels: for tick labels and names; half a label; a colour bar
BELOW, BETWEEN = 0.52, 0.17  # tick labels and the axis' name; panels that share their x axis
MARGIN, LINE = 0.1, 0.2  # above panels, and for each line of text there
NAME_BESIDE, NAME_BELOW = 0.68, 0.36  # of axes, from the panel to the name's middle
MOST_STEPS = 5  # between ticks of a y axis; each tick is five artists, and ticks take half of a figure's time
LETTER, ROW = 0.014, 0.11  # of a panel: width of a name's letter, height of a row of names
FROM_LOAD = "roller's angle from the load line, degrees"
BESIDE = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}  # keeps a name legible
DASHED, DOTTED = (0, (4, 2)), (0, (1, 2))
SMALL = {"handlelength": 1.3, "columnspacing": 0.9, "handletextpad": 0.4, "fontsize": 9}  # a legend of many lines
# PNG about as large as at level 6 by default, in a third of the time
PACKED: dict[str, Any] = {"compress_level": 1, "compress_type": zlib.Z_RLE}
STYLE: "dict[RcKeyType, Any]" = {
    "font.family": "DejaVu Sans", "font.size": 11, "axes.titlesize": 11, "axes.labelsize": 11, "xtick.labelsize": 10,
    "ytick.labelsize": 10, "legend.fontsize": 9.5, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#E3E3E3", "grid.linewidth": 0.7, "axes.axisbelow": True, "lines.linewidth": 1.1,
    "legend.frameon": False, "text.hinting": "none",  # at this resolution as legible, and quicker
    "svg.hashsalt": "residual", "svg.fonttype": "path", "path.simplify": True, "path.simplify_threshold": 0.3,
    "agg.path.chunksize": 20000, "axes.formatter.limits": (-4, 5), "axes.formatter.useoffset": False}  # fmt: skip
LOOK: dict[Any, Any] = {**STYLE, "figure.constrained_layout.use": True, "font.size": 9, "axes.labelsize": 9}


class Drawing(NamedTuple):
    """A figure and what its page says of it; `address` once it has been written, as a page embeds it."""

    name: str  # of its files
    title: str
    caption: str
    figure: Any
    address: str = ""


def panels(rows, height: float, *, lines: float = 1, shares=None, left=LEFT, right=RIGHT, x="", y=(), **keywords):
    """Make a figure of panels below each other; the figure and its axes.

    rows : int, panels that share their x axis; or a tuple of such numbers, for groups with x axes of their own
    height, left, right : float, inches, of the figure and beside the panels
    lines : lines of text, as of a legend, above the first panel of a group
    shares : heights of the panels over each other's; None: equal ones
    x, y : names of the x axis, or of each group's, and of the y axes; FROM_LOAD goes around the bearing
    keywords : of each panel, as `projection`
    """
    groups, names = ((rows,), (x,)) if isinstance(rows, int) else (rows, x)
    above, count = MARGIN + LINE * lines, sum(groups)
    shares = np.ones(count) if shares is None else np.asarray(shares, dtype=float)
    room = height - len(groups) * (above + BELOW) - (count - len(groups)) * BETWEEN
    figure, top, wide = Figure(figsize=(WIDTH, height)), height, WIDTH - left - right
    for size, name in zip(groups, names, strict=True):
        top, first = top - above, None
        for row in range(size):
            high = room * shares[len(figure.axes)] / shares.sum()
            place = left / WIDTH, (top - high) / height, wide / WIDTH, high / height
            axis = figure.add_axes(place, sharex=first, xmargin=0.0, **keywords)
            first = first or axis
            if axis.name == "rectilinear":  # names of axes at fixed places
                axis.locator_params(axis="y", nbins=MOST_STEPS)
                axis.yaxis.set_label_coords(-NAME_BESIDE / wide, 0.5)
                axis.xaxis.set_label_coords(0.5, -NAME_BELOW / high)
            axis.tick_params(labelbottom=row == size - 1)
            if name == FROM_LOAD:
                axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45))
            top -= high + (BETWEEN if row < size - 1 else BELOW)
        axis.set_xlabel(name)
    for axis, name in zip(figure.axes, y, strict=False):
        axis.set_ylabel(name)
    return figure, np.array(figure.axes)


def curves(axis, x, *rows, legend=0, **about) -> None:
    """Draw curves over x, each by its values, its colour, a label, and its width or all of its style.

    `legend` : its columns above; `about` : the axis
    """
    for values, colour, label, style in ((*row, *(None, 0.9)[len(row) - 2 :]) for row in rows):
        look = style if isinstance(style, dict) else {"linewidth": style}
        axis.plot(x, values, color=colour, label=label, **look)
    axis.set(**about)
    if legend:
        legend_above(axis, legend)


def colour_bar(drawn, axes, label: str, **keywords) -> None:
    """Add the scale of colours at the right of panels that leave room there, as by `right=SCALE`."""
    figure, boxes = axes[0].figure, [axis.get_position() for axis in axes]
    inch = 1.0 / figure.get_size_inches()[0]
    low, high = min(box.y0 for box in boxes), max(box.y1 for box in boxes)
    place = figure.add_axes((boxes[0].x1 + 0.12 * inch, low, 0.15 * inch, high - low))
    figure.colorbar(drawn, cax=place, label=label, **keywords).minorticks_off()


def legend_above(axis, columns: int, left: float = 0.0, **style) -> None:
    """Put an axis' legend above it, its left edge a share of the axis' width to the right of the axis' own.

    Of so many columns at most, as many as the figure is wide for.
    """
    figure, style = axis.figure, {"borderaxespad": 0.2, **style}
    for ncols in range(columns, 0, -1):
        legend = axis.legend(loc="lower left", bbox_to_anchor=(left, 1.0), ncols=ncols, **style)
        if legend.get_window_extent(FigureCanvasAgg(figure).get_renderer()).x1 <= figure.bbox.x1:
            return


def name_lines(axis, names: list[tuple[float, str, str]]) -> None:
    """Write names at frequencies, each with its colour, within a panel's upper edge, in rows where they are near."""
    low, high = axis.get_xlim()
    ends: list[float] = []  # of the rows, from above
    for frequency, name, colour in sorted(names):
        half = 0.5 * LETTER * len(name) * (high - low)
        middle = min(max(frequency, low + half), high - half)
        row = next((k for k, end in enumerate(ends) if middle - half > end), len(ends))
        ends[row:] = [middle + half, *ends[row + 1 :]]
        axis.annotate(name, (middle, 1.0 - ROW * row), xycoords=("data", "axes fraction"), ha="center", va="top",
                      fontsize=9.5, color=colour, bbox=BESIDE)  # fmt: skip
    axis.set_ylim(top=axis.get_ylim()[1] / (1.0 - ROW * len(ends)))


def log_panel(axis, frequency: np.ndarray) -> None:
    """Make both axes logarithmic, the x axis from the first to the last of some frequencies."""
    axis.set(xscale="log", yscale="log", xlim=(frequency[0], frequency[-1]))
    axis.yaxis.set_minor_locator(NullLocator())


def without_minor_ticks(axis) -> None:
    """Leave out the small ticks of logarithmic axes: each is five artists, and takes as long as a curve."""
    axis.xaxis.set_minor_locator(NullLocator())
    axis.yaxis.set_minor_locator(NullLocator())


def mark_lines(axis, lines: dict[str, float], low: float, high: float, unit: str = " Hz", of=None) -> list[Line2D]:
    """Mark the kinematic lines within low … high by vertical lines; the legend's entries of the families drawn.

    `unit` : of the entries' numbers, none of orders; `of` : the families' own lines, where `lines` lack some
    """
    shown = sorted((f, name) for name, f in lines.items() if low <= f <= high)
    for frequency, name in shown:
        width, style = (1.1, DASHED) if family(name) == name else (0.8, DOTTED)
        axis.axvline(frequency, color=LINE_COLOURS[family(name)], linewidth=width, linestyle=style, zorder=1)
    of = of or lines
    return [Line2D([], [], color=LINE_COLOURS[name], linestyle=DASHED, label=f"{name} {of[name]:.4g}{unit}")
            for name in dict.fromkeys(family(name) for _, name in shown)]  # fmt: skip


def save(drawing: Drawing, folder: Path) -> Drawing:
    """Write a figure as PNG and SVG, without a date, so that the same run gives the same files.

    A page embeds its vectors, unless they are many and take more room than pixels.
    """
    name, title, _, figure, _ = drawing
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    make_plain(figure)
    # room for legends above, with every panel where it is
    (width, height), renderer = figure.get_size_inches(), FigureCanvasAgg(figure).get_renderer()
    legends = [legend for axis in figure.axes if (legend := axis.get_legend()) is not None]
    top = max((legend.get_window_extent(renderer).y1 / figure.dpi for legend in legends), default=0.0)
    if top > height:
        boxes = [axis.get_position(original=True) for axis in figure.axes]
        figure.set_size_inches(width, top)
        for axis, box in zip(figure.axes, boxes, strict=True):
            axis.set_position((box.x0, box.y0 * height / top, box.width, box.height * height / top))
    figure.set_dpi(DPI)
    # a canvas' own drawing and printing draw once each, `savefig` twice
    canvas, about = FigureCanvasAgg(figure), PngInfo()
    canvas.draw()
    about.add_text("Title", title)
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").save(png, pnginfo=about, **PACKED)
    FigureCanvasSVG(figure).print_svg(svg, metadata={"Date": None, "Title": title})
    kind, data, pixels = "svg+xml", svg.read_bytes(), png.read_bytes()
    if len(data) > max(LARGEST_SVG, len(pixels)):
        kind, data = "png", pixels
    return drawing._replace(figure=None, address=f"data:image/{kind};base64,{b64encode(data).decode('ascii')}")


def finished(figure: Figure, name: str, title: str, caption: str) -> Drawing:
    """A figure of pyplot in `LOOK` as text that goes into a page, and closed."""
    from matplotlib import pyplot as plt

    figure.draw_without_rendering()  # lays it out
    figure.set_layout_engine("none")  # once
    with TemporaryDirectory() as folder:
        found = save(Drawing(name, title, caption, figure), Path(folder))
    plt.close(figure)
    return found


def plain(label: str) -> str:
    r"""A label without marks of mathematics: "$\mathdefault{2\times10^{-3}}$" -> "2×10⁻³", "1e−5" -> "×10⁻⁵"."""
    label = label.replace(r"\times", "×").replace(r"\mathdefault", "")
    label = re.sub(r"10\^\{([-−]?\d+)\}", lambda found: "10" + found[1].translate(RAISED), label)
    label = re.sub(r"^1e([-−]?)\+?(\d+)$", lambda found: "×10" + (found[1] + found[2]).translate(RAISED), label)
    return re.sub(r"[${}\\]", "", label)


class PlainScalar(ScalarFormatter):
    """Numbers with one power of ten for all."""

    def get_offset(self) -> str:
        return plain(super().get_offset())


class PlainLog(LogFormatterSciNotation):
    def __call__(self, x, pos=None) -> str:
        return plain(super().__call__(x, pos))


def make_plain(figure) -> None:
    """Give every axis of a figure plain labels, but those with labels of their own."""
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        if type(axis.get_major_formatter()) is ScalarFormatter:
            axis.set_major_formatter(PlainScalar())
        for name in ("major", "minor"):
            if type(getattr(axis, f"get_{name}_formatter")()) is LogFormatterSciNotation:
                getattr(axis, f"set_{name}_formatter")(PlainLog(labelOnlyBase=name == "major"))
