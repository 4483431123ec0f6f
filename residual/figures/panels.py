"""Where panels stand in a figure, in inches: layouts that measure labels take most of a figure's time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

WIDTH = 7.0  # inches; about one page's text width, still legible when a phone shrinks it
LEFT, RIGHT = 0.86, 0.14  # beside panels: tick labels and the axis' name; half a tick label
BELOW, BETWEEN = 0.52, 0.17  # tick labels and the axis' name; panels that share their x axis
MARGIN, LINE = 0.1, 0.2  # above panels, and for each line of text there
NAME_BESIDE, NAME_BELOW = 0.68, 0.36  # of axes, from the panel to the name's middle
SLIM, SLIM_GAP, SLIM_LABELS = 0.6, 0.12, 0.5  # axes for the paper's ranges
MOST_STEPS = 5  # between ticks of a y axis; each tick is five artists, and ticks take half of a figure's time
COLOUR_BAR = 1.0  # at the right of panels with a scale of colours


def panels(rows, height: float, *, lines: float = 1, shares=None, left=LEFT, right=RIGHT, **keywords):
    """Make a figure of panels below each other; the figure and its axes, (n_rows,).

    Parameters
    ----------
    rows : int, panels that share their x axis; or a tuple of such numbers, for groups with x axes of their own
    height : float, inches, of the figure
    lines : lines of text, as of a legend, above the first panel of a group
    shares : heights of the panels over each other's; None: equal ones
    left, right : float, inches, beside the panels
    keywords : of each panel, as `projection`
    """
    groups = (rows,) if isinstance(rows, int) else rows
    above = MARGIN + LINE * lines
    count = sum(groups)
    shares = np.ones(count) if shares is None else np.asarray(shares, dtype=float)
    room = height - len(groups) * (above + BELOW) - (count - len(groups)) * BETWEEN
    figure, top = Figure(figsize=(WIDTH, height)), height
    axes: list[Axes] = []
    for size in groups:
        top -= above
        first = None
        for row in range(size):
            high = room * shares[len(axes)] / shares.sum()
            axis = _panel(figure, (left, top - high, WIDTH - left - right, high), sharex=first, **keywords)
            first = axis if first is None else first
            axis.tick_params(labelbottom=row == size - 1)
            axes.append(axis)
            top -= high + (BETWEEN if row < size - 1 else BELOW)
    return figure, np.array(axes)


def _panel(figure, place, **keywords):
    """One panel at left, bottom, width, height, inches, with the names of its axes at fixed places."""
    width, height = figure.get_size_inches()
    left, bottom, wide, high = place
    axis = figure.add_axes((left / width, bottom / height, wide / width, high / height), **keywords)
    if axis.name == "rectilinear":
        axis.locator_params(axis="y", nbins=MOST_STEPS)
        axis.yaxis.set_label_coords(-NAME_BESIDE / wide, 0.5)
        axis.xaxis.set_label_coords(0.5, -NAME_BELOW / high)
    return axis


def beside(axis, width: float, gap: float):
    """Add an axis at the right of another, of its height; width and gap in inches."""
    figure, box = axis.figure, axis.get_position()
    inch = 1.0 / figure.get_size_inches()[0]
    return figure.add_axes((box.x1 + gap * inch, box.y0, width * inch, box.height))


def panels_beside(n_rows: int, height: float, lines: float = 1):
    """Make `panels` with a slim axis at the right of each row for `beside_paper`: figure, axes, slim axes."""
    figure, axes = panels(n_rows, height, lines=lines, right=SLIM_GAP + SLIM + SLIM_LABELS)
    slim = [beside(axis, SLIM, SLIM_GAP) for axis in axes]
    for axis in slim:
        axis.yaxis.tick_right()
        axis.spines["left"].set_visible(False)
        axis.spines["right"].set_visible(True)
        axis.grid(visible=False)
        axis.set_xlim(0.0, 1.0)
        axis.set_xticks([])
    return figure, axes, slim


def colour_bar(drawn, axes, label: str, **keywords) -> None:
    """Add the scale of colours at the right of panels that leave room there, as by `right=COLOUR_BAR`."""
    figure, boxes = axes[0].figure, [axis.get_position() for axis in axes]
    inch = 1.0 / figure.get_size_inches()[0]
    low, high = min(box.y0 for box in boxes), max(box.y1 for box in boxes)
    place = figure.add_axes((boxes[0].x1 + 0.12 * inch, low, 0.15 * inch, high - low))
    figure.colorbar(drawn, cax=place, label=label, **keywords).minorticks_off()
