"""Figures of a study's page, with the look of the report."""

import textwrap
from itertools import product

import matplotlib.pyplot as plt
import numpy as np
from pandas import DataFrame

from fem.study.folder import Column, Indices, Table
from lagrange.scene.keys import name_in_words
from residual.figures import LOOK, WIDTH, Drawing, finished
from residual.formatting import BLUE, GREY, ORANGE

CELL, TALL = 1.75, 1.9  # inches: a panel among many, one of a column
WIDE = 16.0  # largest over smallest value
MOST = 6  # rows, or columns, of a figure
MOST_TICKS = 4  # of a small axis
CLOUD = 3000  # points drawn one by one, at most


def study_figures(table: Table, indices: list[tuple[Column, Indices]]) -> list[Drawing]:
    """All that the study's points can show."""
    with plt.rc_context(LOOK):
        makers = (_lines,) if table.is_family else (_main_effects, _heat_map, _scatter_matrix)
        found = [figure for maker in makers for figure in maker(table)]
        return [*found, *_sobol_bars(table, indices)]


def _broken(column, wide=20):
    return textwrap.fill(column.label, wide)


def _name_words(axis, column):
    if column.words:
        axis.set_xticks(range(len(column.words)), column.words, rotation=40, ha="right")


def _lines(table):
    """Each quantity over one parameter, a line for each value of the second, a column for each of the third."""
    quantities = table.telling
    if not quantities:
        return
    ordered = sorted(table.parameters, key=lambda column: (bool(column.words), -len(np.unique(column.values))))
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
        _name_words(axis, x)
        if not x.words and _is_geometric(np.unique(x.values)):
            axis.set_xscale("log")
    over = x.meaning
    if lines is not none:
        axes[0, -1].legend(title=textwrap.fill(lines.label, 18), loc="upper left", bbox_to_anchor=(1.01, 1.0))
        over += f", a line for each {lines.meaning}"
    yield finished(figure, "lines", "Results", f"All points, over {over}.")


def _is_geometric(values):
    """Whether values have equal ratios, and so much apart that a logarithmic axis shows them better."""
    if len(values) < 3 or values[0] <= 0.0 or values[-1] < WIDE * values[0]:
        return False
    steps = np.diff(np.log(values))
    return np.allclose(steps, steps.mean(), rtol=0.05)


def _main_effects(table):
    parameters, quantities = table.parameters[:MOST], table.telling[:MOST]
    if not parameters or not quantities:
        return
    rows, columns = len(quantities), len(parameters)
    size = max(WIDTH, CELL * columns), 1.0 + CELL * rows
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False, sharex="col", sharey="row")
    for (row, quantity), (column, parameter) in product(enumerate(quantities), enumerate(parameters)):
        axis, effect = axes[row, column], table.effect(parameter, quantity)
        some = slice(None, None, 1 + len(quantity.values) // CLOUD)
        axis.plot(parameter.values[some], quantity.values[some], ".", color=GREY, markersize=3, alpha=0.5)
        if effect is not None:
            axis.plot(effect.at, effect.mean, "o-", color=BLUE, markersize=4)
            if columns > 1:
                axis.set_title(f"{100.0 * effect.share:.0f} %", fontsize=8.5, loc="right")
        _name_words(axis, parameter)
        axis.set(ylabel=_broken(quantity) if column == 0 else "", xlabel=_broken(parameter) if row == rows - 1 else "")
    caption = "Grey: every point. Blue: means of points with the same value of the parameter, or in the same eighth of "
    caption += "the points." + (" Above: share of variance." if columns > 1 else "")
    yield finished(figure, "main-effects", "Main effects", caption)


def _heat_map(table):
    """Two parameters that explain most, of each quantity; means over all others."""
    quantities = [column for column in table.telling if len(table.strongest(column)) > 1][:4]
    if not quantities:
        return
    columns = min(2, len(quantities))
    rows = -(-len(quantities) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(WIDTH, 0.6 + 2.6 * rows), squeeze=False)
    for axis in axes.flat[len(quantities) :]:
        axis.set_visible(False)
    for axis, quantity in zip(axes.flat, quantities, strict=False):
        (x, _), (y, _) = table.strongest(quantity)[:2]
        found = DataFrame({"x": x.values, "y": y.values, "value": quantity.values})
        found = found[np.isfinite(found).all(axis=1)]
        sides = (axis.xaxis, x), (axis.yaxis, y)
        if found.x.nunique() * found.y.nunique() <= 2 * len(found):
            mean = found.pivot_table("value", "y", "x")
            drawn = axis.pcolormesh(range(mean.shape[1]), range(len(mean)), mean, shading="nearest", cmap="viridis")
            for (side, column), at in zip(sides, (mean.columns, mean.index), strict=True):
                some = np.unique(np.linspace(0, at.size - 1, min(at.size, MOST_TICKS)).round().astype(int))
                side.set_ticks(some, [column.words[int(at[k])] if column.words else f"{at[k]:.5g}" for k in some])
        else:
            drawn = axis.scatter(found.x, found.y, c=found.value, s=10, cmap="viridis")
            for side, column in sides:
                if column.words:
                    side.set_ticks(range(len(column.words)), column.words)
        axis.grid(visible=False)
        axis.set(xlabel=x.label, ylabel=y.label, title=_broken(quantity, 36))
        figure.colorbar(drawn, ax=axis)
    caption = "Each quantity over its two strongest parameters, averaged over all others."
    yield finished(figure, "heat-map", "Two parameters at a time", caption)


def _scatter_matrix(table):
    parameters = table.parameters[:3]
    columns = [*parameters, *table.telling[:4]]
    n = len(columns)
    if n < 3 or table.complete.sum() < 3:
        return
    figure, axes = plt.subplots(n, n, figsize=(max(WIDTH, 1.35 * n), 1.2 * n))
    some = np.flatnonzero(table.complete)[:: 1 + int(table.complete.sum()) // CLOUD]
    for (row, y), (column, x) in product(enumerate(columns), enumerate(columns)):
        axis = axes[row, column]
        if row == column:
            values = x.values[np.isfinite(x.values)]
            axis.hist(values, bins=12, color=BLUE if row < len(parameters) else ORANGE)
            axis.set_yticks([])
        else:
            axis.plot(x.values[some], y.values[some], ".", color=GREY, markersize=2)
        axis.tick_params(labelsize=6.5, labelbottom=row == n - 1, labelleft=column == 0 and row > 0)
        axis.locator_params(nbins=3)
        axis.set_xlabel(_broken(x, 16) if row == n - 1 else "", fontsize=7)
        axis.set_ylabel(_broken(y, 16) if column == 0 else "", fontsize=7)
    caption = "Complete points. Diagonal: histograms of parameters (blue) and quantities (orange)."
    yield finished(figure, "scatter-matrix", "Scatter matrix", caption)


def _sobol_bars(table, indices):
    if not indices:
        return
    names = [textwrap.fill(name_in_words(name), 12) for name in table.points.design.names]
    at = np.arange(len(names))
    figure, axes = plt.subplots(len(indices), 1, figsize=(WIDTH, 0.8 + 1.3 * len(indices)), squeeze=False, sharex=True)
    for axis, (quantity, (first, total)) in zip(axes[:, 0], indices, strict=True):
        axis.bar(at - 0.2, first, 0.4, color=BLUE, label="alone")
        axis.bar(at + 0.2, total, 0.4, color=ORANGE, label="with others")
        axis.set(ylabel=textwrap.fill(quantity.meaning, 16), ylim=(min(0.0, first.min()), 1.05))
        axis.set_xticks(at, names)
    axes[0, 0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    caption = "Share of a quantity's variance due to a parameter alone, and including its interactions (Saltelli 2010, "
    yield finished(figure, "sobol-indices", "Sobol indices", caption + "scipy.stats.sobol_indices).")
