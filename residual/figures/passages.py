"""Figures of spalls: passages of all rollers over one, and the findings of a search."""

from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection

from lagrange.surface.faults import Spall
from lagrange.surface.passages import Passage, SpallEvent, find_passages, spall_events, spalls
from residual.evaluation import Evaluation
from residual.fault_finding import FaultSearch, Near, SinkageMap
from residual.figures.saved import BLUE, GREEN, GREY, ORANGE, RED, SKY, SavedFigure
from residual.figures.style import COLOUR_BAR, DASHED, RIGHT, colour_bar, legend_above, panels, save
from residual.formatting import text
from residual.interpretation import body_name, reported_angle
from residual.record import Record

MOST_SPALLS = 3  # figures: of those struck hardest
MOST_PASSAGES = 150  # in one of them: more hide each other
MEAN_POINTS = 401
SHOWN = 2.6  # half-widths on either side of the middle
BESIDE = 0.4e-3  # m, shown on either side of a spall found
MICRO = 1e6


def passage_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the passages over the scene's spalls, where the record holds contact forces and rollers pass any."""
    record = evaluation.record
    if record.inner_force is None or record.outer_force is None:
        return []
    found: dict[int, list[Passage]] = {}
    for passage in find_passages(record.bearing, record.operation, *_samples(record)):
        first, last = passage.angle[0] / passage.half_width, passage.angle[-1] / passage.half_width
        whole = abs(first) > 1.0 and abs(last) > 1.0 and first * last < 0.0  # in at one edge and out at the other
        if whole and np.any(passage.force > 0.0):
            found.setdefault(passage.spall, []).append(passage)
    hardest = sorted(found, key=lambda spall: -max(passage.force.max() for passage in found[spall]))[:MOST_SPALLS]
    return [_overlay(evaluation, spall, found[spall], folder) for spall in sorted(hardest)]


def _samples(record: Record):
    """How `find_passages` reads a record, and how many samples it has."""
    turn = np.broadcast_to(record.turns.rollers, record.roller_x.shape)
    columns = {
        "time": record.time, "inner_x": record.inner_x, "inner_y": record.inner_y, "roller_x": record.roller_x,
        "roller_y": record.roller_y, "roller_turn": turn, "roller_spin": np.gradient(turn, record.time, axis=0),
        "inner_force": record.inner_force, "outer_force": record.outer_force,
    }  # fmt: skip
    return (lambda start, stop: {name: values[start:stop] for name, values in columns.items()}), record.time.size


def _onward(passage: Passage) -> np.ndarray:
    """Angles from the middle on the roller's way, rad, (n,)."""
    return np.sign(passage.angle[-1] - passage.angle[0]) * passage.angle


def _overlay(evaluation: Evaluation, number: int, found: list[Passage], folder: Path) -> SavedFigure:
    """Draw force and hub's acceleration over the angle from one spall's middle."""
    record, spall = evaluation.record, spalls(evaluation.record.bearing)[number]
    found = found[:: -(-len(found) // MOST_PASSAGES)]
    loud = max(evaluation.directions, key=lambda direction: direction.vibration.level.rms).name
    acceleration = evaluation.hub_acceleration["xy".index(loud)]
    place = None
    if spall.body != "outer_ring":  # then it is passed at all places
        middle = [passage.first + int(np.argmin(np.abs(passage.angle))) for passage in found]
        place = np.abs(np.degrees(record.from_load[middle, [passage.roller for passage in found]]))
    names = ["contact force, N", f"hub's acceleration, {loud}, m/s²"]
    right = RIGHT if place is None else COLOUR_BAR
    figure, axes = panels(2, 5.6, right=right, x="angle from the spall's middle, on the way, °", y=names)
    _draw_lines(axes[0], found, [passage.force for passage in found], place)
    accelerations = [acceleration[each.first : each.first + each.time.size] for each in found]
    drawn = _draw_lines(axes[1], found, accelerations, place)
    strikes = [event for event in spall_events(found) if event.kind == "strike"]
    at = [np.degrees(_angle_at(found, event)) for event in strikes]
    if strikes:
        forces = [event.force for event in strikes]
        axes[0].plot(at, forces, "o", color=RED, markersize=3.0, label="strikes", zorder=5)
    legend_above(axes[0], 3)
    half = float(np.degrees(found[0].half_width))
    axes[0].set(ylim=(0.0, None), xlim=(-SHOWN * half, SHOWN * half))
    if place is not None:
        colour_bar(drawn, axes, "roller's place, ° from the load line")
    caption = _caption(spall, found, strikes, at)
    return save(figure, folder, f"passages_{number}", f"Passages over spall {number}", caption)


def _draw_lines(axis, found: list[Passage], rows: list[np.ndarray], place: np.ndarray | None):
    """Draw a quantity of each passage, coloured by the roller's place, and its mean."""
    angles = [np.degrees(_onward(passage)) for passage in found]
    style = dict(colors=SKY) if place is None else dict(array=place, cmap="viridis", clim=(0.0, 180.0))
    lines = [np.column_stack(line) for line in zip(angles, rows, strict=True)]
    drawn = axis.add_collection(LineCollection(lines, linewidths=0.6, alpha=0.6, **style))
    half = float(np.degrees(found[0].half_width))
    grid = SHOWN * half * np.linspace(-1.0, 1.0, MEAN_POINTS)
    rising = [np.argsort(angle) for angle in angles]
    every = [np.interp(grid, angle[k], row[k]) for angle, row, k in zip(angles, rows, rising, strict=True)]
    axis.plot(grid, np.mean(every, axis=0), color="black", linewidth=1.4, label=f"mean of {len(found)} passages")
    for edge in (-half, half):
        axis.axvline(edge, color=GREY, linestyle=DASHED, linewidth=1.0, zorder=1)
    axis.autoscale_view()
    return drawn


def _caption(spall: Spall, found: list[Passage], strikes: list[SpallEvent], at: list[float]) -> str:
    half = float(np.degrees(found[0].half_width))
    caption = (
        f"Passages over the {text(1e3 * spall.width)} mm wide spall on {body_name(spall)}, over the contact's angle "
        "from its middle: force of the contact and acceleration of the hub. Dashed: the spall's edges, "
        f"{text(half, 3)}° away."
    )
    if strikes:
        force, share = np.median([event.force for event in strikes]), 0.5 + 0.5 * np.median(at) / half
        caption += (
            f" Dots: impacts, the first large peak after a roller was released; their medians are {force:.0f} N and "
            f"{text(float(share), 2)} of the crossing from the entry."
        )
    return caption


def _angle_at(found: list[Passage], event: SpallEvent) -> float:
    """Angle of an event from the middle, on the roller's way, rad."""
    passage = next(
        passage
        for passage in found
        if (passage.roller, passage.raceway) == (event.roller, event.raceway)
        and passage.time[0] <= event.time <= passage.time[-1]
    )
    return float(np.interp(event.time, passage.time, _onward(passage)))


def fault_figures(search: FaultSearch, folder: Path) -> list[SavedFigure]:
    """Draw the search; nothing where no map was made."""
    found = search.found
    if not search.maps:
        return []
    rows = max(1, 2 * len(found))
    figure, axes = panels((1,) * rows, 3.3 * rows)
    for k, each in enumerate(found):
        _draw_map(axes[2 * k], each.seen, BLUE)
        middle, half = reported_angle(each.place, each.angle), np.degrees(0.5 * each.width / each.place.radius)
        axes[2 * k].axvspan(middle - half, middle + half, color=RED, alpha=0.25, linewidth=0, label="the spall found")
        _draw_passages(axes[2 * k + 1], search, k)
    caption = (
        "Above: median of how deep rollers find the surface around the body, from all passages. Below: difference of "
        "three samples of a roller from its equation of motion, in every passage, on perfect circles and with the "
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
    return [save(figure, folder, "fault_search", "Passages by the body's own angle", caption)]


def _draw_map(axis, each: SinkageMap, colour: str) -> None:
    """Draw a map around the body."""
    angle = np.array([reported_angle(each.place, a) for a in each.angle])
    order = np.argsort(angle)
    axis.plot(angle[order], MICRO * each.height[order], color=colour, linewidth=0.9, label=body_name(each.place))


def _draw_passages(axis, search: FaultSearch, k: int) -> None:
    """Draw the mismatch of three samples with the equation of motion, without and with the spalls found."""
    each, rest = search.found[k], [other.spalled for i, other in enumerate(search.found) if i != k]
    half, aside = 0.5 * each.width, 0.5 * each.width_error
    axis.axvspan(-1e3 * half, 1e3 * half, color=RED, alpha=0.12, linewidth=0)
    for edge in (-half, half):
        axis.axvspan(1e3 * (edge - aside), 1e3 * (edge + aside), color=RED, alpha=0.2, linewidth=0)
    near = Near(search.motion, each.place, each.angle, half + BESIDE, rest)
    without, with_it = near.samples.over([(each.place, np.array([each.spall * (1.0, 0.0, 1.0), each.spall])), *rest])
    for missed, colour, label in ((without, ORANGE, "perfect circles"), (with_it, BLUE, "with the spall found")):
        axis.plot(1e3 * near.beyond, MICRO * missed, ".", color=colour, markersize=3.0, label=label)
    axis.margins(x=0.0)
    axis.set(xlabel="contact from the spall's middle, mm", ylabel="from the equation of motion, µm")
