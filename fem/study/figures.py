"""Figures of a study's page, with the look of the report."""

import base64
import io
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from fem.study.effects import Column, Effect, Indices, Table
from lagrange.scene.keys import name_in_words
from residual.figures.saved import BLUE, DPI, GREY, LARGEST_SVG, ORANGE, WIDTH
from residual.figures.style import STYLE, make_plain

CELL, TALL = 1.75, 1.9  # inches: a panel among many, one of a column
WIDE = 16.0  # largest over smallest value
MOST = 6  # rows, or columns, of a figure
MOST_TICKS = 4  # of a small axis
CLOUD = 3000  # points drawn one by one, at most


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure as it stands in the page."""

    name: str
    title: str
    caption: str
    address: str


def study_figures(table: Table, indices: list[tuple[Column, Indices]]) -> list[Figure]:
    """All that the study's points can show."""
    look: dict[Any, Any] = {**STYLE, "figure.constrained_layout.use": True, "font.size": 9, "axes.labelsize": 9}
    with plt.rc_context(look):
        makers = (_lines,) if table.is_family else (_main_effects, _heat_map, _scatter_matrix)
        found = [figure for maker in makers for figure in maker(table)]
        return [*found, *_sobol_bars(table, indices)]


def _lines(table: Table) -> Iterator[Figure]:
    """Each quantity over one parameter, a line for each value of the second, a column for each of the third."""
    quantities = table.telling
    if not quantities:
        return
    ordered = sorted(table.parameters, key=lambda each: (bool(each.words), -len(np.unique(each.values))))
    none = Column(name="", unit="1", meaning="", values=np.zeros(len(table.complete)))
    x, lines, beside = (*ordered, none, none)[:3]
    at_lines, columns = np.unique(lines.values), np.unique(beside.values)
    size = max(WIDTH, 0.4 * WIDTH * len(columns)), 0.4 + TALL * len(quantities)
    figure, axes = plt.subplots(len(quantities), len(columns), figsize=size, squeeze=False, sharex=True, sharey="row")
    shades = plt.get_cmap("viridis")(np.linspace(0.0, 0.75, len(at_lines)))
    for (row, quantity), (column, third) in product(enumerate(quantities), enumerate(columns)):
        axis = axes[row, column]
        for second, shade in zip(at_lines, shades, strict=True):
            here = np.isfinite(quantity.values) & (lines.values == second) & (beside.values == third)
            points = np.array([x.values[here], quantity.values[here]])[:, np.argsort(x.values[here])]
            axis.plot(*points, "o-", color=shade, markersize=3.5, label=lines.shown(second))
        title = textwrap.fill(quantity.meaning, 84 // len(columns))
        if beside is not none and row == 0:
            title = f"{beside.label}: {beside.shown(third)}\n{title}"
        axis.set_title(title, loc="left", fontsize=9.5)
        axis.set_ylabel(quantity.unit if column == 0 and quantity.unit != "1" else "")
        axis.set_xlabel(x.label if row == len(quantities) - 1 else "")
        if x.words:
            axis.set_xticks(range(len(x.words)), x.words, rotation=40, ha="right")
        elif _is_geometric(np.unique(x.values)):
            axis.set_xscale("log")
    over = x.meaning
    if lines is not none:
        axes[0, -1].legend(title=textwrap.fill(lines.label, 18), loc="upper left", bbox_to_anchor=(1.01, 1.0))
        over += f", a line for each {lines.meaning}"
    yield finished(figure, "lines", "Results", f"All points, over {over}.")


def _is_geometric(values: np.ndarray) -> bool:
    """Whether values have equal ratios, and so much apart that a logarithmic axis shows them better."""
    if len(values) < 3 or values[0] <= 0.0 or values[-1] < WIDE * values[0]:
        return False
    return bool(np.allclose(np.diff(np.log(values)), np.log(values[-1] / values[0]) / (len(values) - 1), rtol=0.05))


def _main_effects(table: Table) -> Iterator[Figure]:
    parameters, quantities = table.parameters[:MOST], table.telling[:MOST]
    if not parameters or not quantities:
        return
    size = max(WIDTH, CELL * len(parameters)), 1.0 + CELL * len(quantities)
    figure, axes = plt.subplots(
        len(quantities), len(parameters), figsize=size, squeeze=False, sharex="col", sharey="row"
    )
    for (row, quantity), (column, parameter) in product(enumerate(quantities), enumerate(parameters)):
        axis, effect = axes[row, column], table.effect(parameter, quantity)
        some = slice(None, None, 1 + len(quantity.values) // CLOUD)
        axis.plot(parameter.values[some], quantity.values[some], ".", color=GREY, markersize=3, alpha=0.5)
        if effect is not None:
            axis.plot(effect.at, effect.mean, "o-", color=BLUE, markersize=4)
        if effect is not None and len(parameters) > 1:
            axis.set_title(_percent(effect), fontsize=8.5, loc="right")
        if parameter.words:
            axis.set_xticks(range(len(parameter.words)), parameter.words, rotation=40, ha="right")
        if column == 0:
            axis.set_ylabel(_broken(quantity))
        if row == len(quantities) - 1:
            axis.set_xlabel(_broken(parameter))
    yield finished(
        figure,
        "main-effects",
        "Main effects",
        "Grey: every point. Blue: means of points with the same value of the parameter, or in the same eighth of the "
        "points." + (" Above: share of variance." if len(parameters) > 1 else ""),
    )


def _percent(effect: Effect) -> str:
    return f"{100.0 * effect.share:.0f} %"


def _heat_map(table: Table) -> Iterator[Figure]:
    """Two parameters that explain most, of each quantity; means over all others."""
    quantities = [each for each in table.telling if len(table.strongest(each)) > 1][:4]
    if len(table.parameters) < 2 or not quantities:
        return
    columns = min(2, len(quantities))
    rows = -(-len(quantities) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(WIDTH, 0.6 + 2.6 * rows), squeeze=False)
    for axis, quantity in zip(axes.ravel(), quantities, strict=False):
        (x, _), (y, _) = table.strongest(quantity)[:2]
        known = np.isfinite(quantity.values) & np.isfinite(x.values) & np.isfinite(y.values)
        at_x, at_y = np.unique(x.values[known]), np.unique(y.values[known])
        if len(at_x) * len(at_y) <= known.sum() * 2:
            total = np.full((len(at_y), len(at_x)), np.nan)
            for (j, b), (i, a) in product(enumerate(at_y), enumerate(at_x)):
                here = known & (x.values == a) & (y.values == b)
                total[j, i] = quantity.values[here].mean() if here.any() else np.nan
            drawn = axis.pcolormesh(range(len(at_x)), range(len(at_y)), total, shading="nearest", cmap="viridis")
            _levels(axis.xaxis, x, at_x)
            _levels(axis.yaxis, y, at_y)
        else:
            drawn = axis.scatter(x.values[known], y.values[known], c=quantity.values[known], s=10, cmap="viridis")
            for side, column in ((axis.xaxis, x), (axis.yaxis, y)):
                if column.words:
                    side.set_ticks(range(len(column.words)), column.words)
        axis.grid(visible=False)
        axis.set(xlabel=x.label, ylabel=y.label, title=_broken(quantity, 36))
        figure.colorbar(drawn, ax=axis)
    for axis in axes.ravel()[len(quantities) :]:
        axis.set_visible(False)
    yield finished(
        figure,
        "heat-map",
        "Two parameters at a time",
        "Each quantity over its two strongest parameters, averaged over all others.",
    )


def _levels(axis, column: Column, at: np.ndarray) -> None:
    """Ticks of a parameter that takes some values, at their numbers."""
    chosen = np.unique(np.linspace(0, len(at) - 1, min(len(at), MOST_TICKS)).round().astype(int))
    axis.set_ticks(chosen, [column.words[int(at[i])] if column.words else f"{at[i]:.5g}" for i in chosen])


def _scatter_matrix(table: Table) -> Iterator[Figure]:
    columns = [*table.parameters[:3], *table.telling[:4]]
    if len(columns) < 3 or table.complete.sum() < 3:
        return
    n = len(columns)
    figure, axes = plt.subplots(n, n, figsize=(max(WIDTH, 1.35 * n), 1.2 * n))
    some = np.flatnonzero(table.complete)[:: 1 + int(table.complete.sum()) // CLOUD]
    for (row, y), (column, x) in product(enumerate(columns), enumerate(columns)):
        axis = axes[row, column]
        if row == column:
            values = x.values[np.isfinite(x.values)]
            axis.hist(values, bins=12, color=BLUE if row < len(table.parameters[:3]) else ORANGE)
            axis.set_yticks([])
        else:
            axis.plot(x.values[some], y.values[some], ".", color=GREY, markersize=2)
        axis.tick_params(labelsize=6.5, labelbottom=row == n - 1, labelleft=column == 0 and row > 0)
        axis.locator_params(nbins=3)
        if row == n - 1:
            axis.set_xlabel(_broken(x, 16), fontsize=7)
        if column == 0:
            axis.set_ylabel(_broken(y, 16), fontsize=7)
    yield finished(
        figure,
        "scatter-matrix",
        "Scatter matrix",
        "Complete points. Diagonal: histograms of parameters (blue) and quantities (orange).",
    )


def _sobol_bars(table: Table, indices: list[tuple[Column, Indices]]) -> Iterator[Figure]:
    if not indices:
        return
    names = [name_in_words(name) for name in table.points.design.names]
    figure, axes = plt.subplots(len(indices), 1, figsize=(WIDTH, 0.8 + 1.3 * len(indices)), squeeze=False, sharex=True)
    for axis, (quantity, found) in zip(axes[:, 0], indices, strict=True):
        at = np.arange(len(names))
        axis.bar(at - 0.2, found.first, 0.4, color=BLUE, label="alone")
        axis.bar(at + 0.2, found.total, 0.4, color=ORANGE, label="with others")
        axis.set(ylabel=textwrap.fill(quantity.meaning, 16), ylim=(min(0.0, found.first.min()), 1.05))
        axis.set_xticks(at, [textwrap.fill(name, 12) for name in names])
    axes[0, 0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    yield finished(
        figure,
        "sobol-indices",
        "Sobol indices",
        "Share of a quantity's variance due to a parameter alone, and including its interactions (Saltelli 2010, "
        "scipy.stats.sobol_indices).",
    )


def _broken(column: Column, wide: int = 20) -> str:
    """Meaning and unit in lines short enough for a small panel."""
    return textwrap.fill(column.label, wide)


def finished(figure, name: str, title: str, caption: str) -> Figure:
    """A figure as text that goes into a page, and closed."""
    make_plain(figure)
    vectors, pixels = io.BytesIO(), io.BytesIO()
    figure.savefig(vectors, format="svg", metadata={"Date": None})
    kind, data = "svg+xml", vectors.getvalue()
    if len(data) > LARGEST_SVG:
        figure.savefig(pixels, format="png", dpi=DPI, metadata={"Software": None})
        kind, data = "png", pixels.getvalue()
    plt.close(figure)
    address = f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"
    return Figure(name=name, title=title, caption=caption, address=address)
