"""Figure of a search for spalls: a body's map, and passages laid over each other by the body's own angle."""

from pathlib import Path

import numpy as np

from residual.colours import BLUE, GREEN, GREY, ORANGE, RED, SKY
from residual.fault_finding import FaultSearch, FoundSpall
from residual.fault_tables import named, told_angle
from residual.figures import SavedFigure
from residual.panels import panels
from residual.plotting import legend_above, save
from residual.sinkage_maps import SinkageMap

PASSAGES_SHOWN = 8
MICRO = 1e6


def fault_figures(search: FaultSearch, folder: Path) -> list[SavedFigure]:
    """Draw the search; nothing where no map was made."""
    return [_drawn(search, folder)] if search.maps else []


def _drawn(search: FaultSearch, folder: Path) -> SavedFigure:
    found = search.found
    rows = 1 if found is None else 2
    figure, axes = panels((1,) * rows, 3.3 * rows)
    whole = [m for m in search.maps if not m.rested]
    shown = [m for m in whole if (m.place.roller is None if found is None else m.place == found.place)]
    for each, colour in zip(shown, (BLUE, GREEN), strict=False):
        _draw_map(axes[0], each, colour)
    axes[0].set(ylabel="sinkage, µm", xlabel="angle in the body's own frame, degrees")
    axes[0].set_xlim(-180.0, 180.0)
    caption = "Median of what rollers sink by around each ring: no place stands out."
    if found is not None:
        middle, half = told_angle(found.place, found.angle), np.degrees(0.5 * found.width / found.place.radius)
        axes[0].axvspan(middle - half, middle + half, color=RED, alpha=0.25, linewidth=0, label="the spall found")
        _draw_passages(axes[1], found)
        caption = (
            f"Above: median of what rollers sink by around {named(found.place)}, from all passages. Below: "
            f"{min(PASSAGES_SHOWN, found.response.chosen.first.size)} of the passages that the spall was matched to; "
            "dots as recorded, lines as rollers would move over the spall found. Shaded: its width, darker the 95 % "
            "intervals of its edges. Each passage begins at its own level."
        )
    legend_above(axes[0], 3)
    return save(figure, folder, "fault_search", "Passages by the body's own angle", caption)


def _draw_map(axis, each: SinkageMap, colour: str) -> None:
    """Draw a map around the body."""
    angle = np.array([told_angle(each.place, a) for a in each.angle])
    order = np.argsort(angle)
    axis.plot(angle[order], MICRO * each.height[order], color=colour, linewidth=0.9, label=named(each.place))


def _draw_passages(axis, found: FoundSpall) -> None:
    """Draw recorded and modelled paths of some passages, by how far the contact is from the spall's middle."""
    response = found.response
    paths = response.paths(found.spall[None])[0]
    half, aside = 0.5 * found.width, 0.5 * found.width_error
    axis.axvspan(-1e3 * half, 1e3 * half, color=RED, alpha=0.12, linewidth=0)
    for edge in (-half, half):
        axis.axvspan(1e3 * (edge - aside), 1e3 * (edge + aside), color=RED, alpha=0.2, linewidth=0)
    colours = (BLUE, ORANGE, GREEN, SKY, GREY)
    for k in range(min(PASSAGES_SHOWN, len(paths))):
        beyond = np.mod(response.angle[k, :: response.steps] - found.angle + np.pi, 2.0 * np.pi) - np.pi
        at, colour = 1e3 * found.place.radius * beyond, colours[k % len(colours)]
        level = np.median(response.path[k][: len(at) // 4])
        axis.plot(at, MICRO * (response.path[k] - level), ".", color=colour, markersize=3.5)
        axis.plot(at, MICRO * (paths[k] - level), color=colour, linewidth=0.9)
    axis.margins(x=0.0)
    axis.set(xlabel="contact from the spall's middle, mm", ylabel="roller, radially outward, µm")
