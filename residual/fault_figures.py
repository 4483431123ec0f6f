"""Figure of a search for spalls: bodies' maps, and what rollers do near each spall beside what perfect circles tell."""

from pathlib import Path

import numpy as np

from residual.colours import BLUE, GREEN, ORANGE, RED
from residual.fault_finding import FaultSearch, Near
from residual.fault_tables import named, told_angle
from residual.figures import SavedFigure
from residual.panels import panels
from residual.plotting import legend_above, save
from residual.sinkage_maps import SinkageMap

BESIDE = 0.4e-3  # m, shown on either side of a spall
MICRO = 1e6


def fault_figures(search: FaultSearch, folder: Path) -> list[SavedFigure]:
    """Draw the search; nothing where no map was made."""
    return [_drawn(search, folder)] if search.maps else []


def _drawn(search: FaultSearch, folder: Path) -> SavedFigure:
    found = search.found
    rows = max(1, 2 * len(found))
    figure, axes = panels((1,) * rows, 3.3 * rows)
    for k, each in enumerate(found):
        _draw_map(axes[2 * k], each.seen, BLUE)
        middle, half = told_angle(each.place, each.angle), np.degrees(0.5 * each.width / each.place.radius)
        axes[2 * k].axvspan(middle - half, middle + half, color=RED, alpha=0.25, linewidth=0, label="the spall found")
        _draw_passages(axes[2 * k + 1], search, k)
    caption = (
        "Above: median of how deep rollers find the surface around the body, from all passages. Below: what three "
        "samples of a roller differ from its equation of motion by, in every passage, on perfect circles and with the "
        "spall found. Shaded: its width, darker the 95 % intervals of its edges."
    )
    if not found:
        caption = "Median of how deep rollers find the surface around each ring: no place stands out."
        for ring, colour in zip((m for m in search.maps if m.place.roller is None), (BLUE, GREEN), strict=False):
            _draw_map(axes[0], ring, colour)
    for axis in axes[::2]:
        axis.set(ylabel="sinkage, µm", xlabel="angle in the body's own frame, degrees")
        axis.set_xlim(-180.0, 180.0)
    for axis in axes:
        legend_above(axis, 3)
    return save(figure, folder, "fault_search", "Passages by the body's own angle", caption)


def _draw_map(axis, each: SinkageMap, colour: str) -> None:
    """Draw a map around the body."""
    angle = np.array([told_angle(each.place, a) for a in each.angle])
    order = np.argsort(angle)
    axis.plot(angle[order], MICRO * each.height[order], color=colour, linewidth=0.9, label=named(each.place))


def _draw_passages(axis, search: FaultSearch, k: int) -> None:
    """Draw what three samples differ from the equation of motion by, without and with the spalls found."""
    each, rest = search.found[k], [other.spalled for i, other in enumerate(search.found) if i != k]
    half, aside = 0.5 * each.width, 0.5 * each.width_error
    axis.axvspan(-1e3 * half, 1e3 * half, color=RED, alpha=0.12, linewidth=0)
    for edge in (-half, half):
        axis.axvspan(1e3 * (edge - aside), 1e3 * (edge + aside), color=RED, alpha=0.2, linewidth=0)
    near = Near(search.motion, search.contact, each.place, each.angle, half + BESIDE, rest)
    without, with_it = near.samples.over([(each.place, np.array([each.spall * (1.0, 0.0, 1.0), each.spall])), *rest])
    for missed, colour, label in ((without, ORANGE, "perfect circles"), (with_it, BLUE, "with the spall found")):
        axis.plot(1e3 * near.beyond, MICRO * missed, ".", color=colour, markersize=3.0, label=label)
    axis.margins(x=0.0)
    axis.set(xlabel="contact from the spall's middle, mm", ylabel="from the equation of motion, µm")
