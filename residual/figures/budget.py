"""Figures of the errors' terms: over time, stacked over a few roller passages, and as spectra."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from residual.evaluation import Evaluation
from residual.figures.saved import GREY, TERM_COLOURS, SavedFigure
from residual.figures.style import DASHED, legend_above, log_panel, panels, save, without_minor_ticks
from residual.formatting import term_label, text
from residual.spectrum import Spectrum, rms

PASSAGES_SHOWN = 2.0
BINS_PER_DECADE = 120
DYNAMIC_RANGE = 1e-9  # of a spectrum's plot
NEAR = 1.7  # times a frequency: names of lines would overlap
USUAL_TERMS, ROOM_FOR_A_TERM, INCHES_OF_A_SHARE = 4, 0.4, 1.6  # more terms take more room for their bars
NAMES = 1.2  # inches, of terms beside their bars


def budget_figure(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the error's terms over time, and their rms."""
    time, acting = 1e3 * evaluation.record.time, evaluation.budget.acting_terms
    more = ROOM_FOR_A_TERM * max(0, len(acting) - USUAL_TERMS)
    shares = 1.0, 1.0, 1.4 + more / INCHES_OF_A_SHARE
    figure, (*axes, bars) = panels(
        (2, 1), 8.4 + more, lines=2, shares=shares, left=NAMES, x="rms, N (full colour: x, faint: y)"
    )
    names = ["error", *acting, "momentum"]
    position, colours, sizes = np.arange(len(names))[::-1], [TERM_COLOURS[name] for name in names], []
    for axis, d, offset, shade in zip(axes, evaluation.directions, (0.19, -0.19), (1.0, 0.5), strict=True):
        terms = {"error": d.budget.error, **{name: d.budget.terms[name] for name in acting}}
        for name, values in terms.items():
            axis.plot(time, values, color=TERM_COLOURS[name], label=term_label(name),
                      linewidth=1.4 if name == "error" else 0.9)  # fmt: skip
        axis.set_ylabel(f"terms of error_{d.name}, N")
        axis.margins(x=0.0)
        widths = [*map(rms, terms.values()), 0.0 if d.balance is None else d.balance.rms]
        drawn = bars.barh(position + offset, widths, height=0.34, color=colours, alpha=shade)
        bars.bar_label(drawn, [f"{d.name}: {text(v, 3)} N" for v in widths], padding=4, fontsize=8.5)
        sizes += widths
    legend_above(axes[0], 5, left=-0.1, columnspacing=1.0, handlelength=1.3)
    axes[1].set_xlabel("time, ms")
    bars.set_xscale("log")
    without_minor_ticks(bars)
    everything = [v for v in sizes if v > 0.0]
    top = max(everything, default=1.0)
    bars.set_xlim(max(min(everything, default=0.1) / 2.0, 1e-5 * top), 8.0 * top)
    bars.set_yticks(
        position, [term_label(n).replace(" ", "\n", 1) + ("\nbalance" if n == "momentum" else "") for n in names]
    )
    bars.grid(axis="y", visible=False)
    caption = (
        "What the error forces are made of; the terms add up to the error sample by sample. Momentum balance: the "
        "error with the run's own contact forces in place of the law, = differentiation + ring flexibility."
    )
    return save(figure, folder, "budget", "Budget of the error forces", caption)


def stacked_terms(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the terms less their means, stacked, over two roller passages in the middle of the record."""
    shown = middle(evaluation, PASSAGES_SHOWN)
    time = 1e3 * evaluation.record.time[shown]
    figure, axes = panels(2, 5.6, x="time, ms", y=[f"error_{axis} without mean, N" for axis in "xy"])
    means = []
    for axis, direction in zip(axes, evaluation.directions, strict=True):
        terms = {name: direction.budget.terms[name] for name in evaluation.budget.acting_terms}
        total = direction.budget.error
        values = np.array([v[shown] - v.mean() for v in terms.values()])
        style = {"colors": [TERM_COLOURS[name] for name in terms], "alpha": 0.75, "linewidth": 0}
        axis.stackplot(time, np.maximum(values, 0.0), labels=[term_label(name) for name in terms], **style)
        axis.stackplot(time, np.minimum(values, 0.0), **style)
        axis.plot(time, total[shown] - total.mean(), color="black", linewidth=1.2, label="error")
        mean = ", ".join(f"{term_label(name)} {text(v.mean(), 3, evaluation.noise)}" for name, v in terms.items())
        means.append(f"in {direction.name} {mean}")
    legend_above(axes[0], 5, left=-0.08, columnspacing=1.0, handlelength=1.2)
    caption = (
        "The terms of the error forces stacked, positive upward and negative downward, each without its mean over the "
        "record; the black line, their sum, is the error without its mean. Middle of the record, "
        f"{PASSAGES_SHOWN:g} roller passages where the bearing turns. Means, N: {'; '.join(means)}."
    )
    return save(figure, folder, "budget_stacked", "Terms of the error forces, stacked", caption)


def middle(evaluation: Evaluation, passages: float) -> slice:
    """Samples of some roller passages in the middle of the record; all of them for a standing bearing."""
    t, passing = evaluation.record, evaluation.lines.get("BPFO", 0.0)
    if passing == 0.0:
        return slice(None)
    n = min(t.time.size, int(passages / passing / t.interval) + 1)
    first = (t.time.size - n) // 2
    return slice(first, first + n)


def budget_spectra(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the density of every term beside the error's."""
    figure, axes = panels(2, 6.4, lines=3, x="frequency, Hz", y=[f"PSD, {axis}, N²/Hz" for axis in "xy"])
    for axis, direction in zip(axes, evaluation.directions, strict=True):
        f, psd = _thinned(direction.spectrum)
        log_panel(axis, f)
        axis.plot(f, psd, color="black", linewidth=2.6, alpha=0.35, label="error")
        for name in evaluation.budget.acting_terms:
            spectrum = direction.term_spectra[name]
            axis.plot(*_thinned(spectrum), color=TERM_COLOURS[name], linewidth=0.9, label=term_label(name))
        top = max(float(psd.max()), 1e-30)
        axis.set_ylim(DYNAMIC_RANGE * top, 10.0 * top)
        lines = {n: at for n, at in evaluation.lines.items() if "×" not in n and f[0] <= at <= f[-1]}
        for line, frequency in lines.items():
            axis.axvline(frequency, color=GREY, linestyle=DASHED, linewidth=0.9, zorder=0)
            if direction is evaluation.x:
                axis.annotate(line, (frequency, 1.01), xycoords=("data", "axes fraction"), fontsize=9, va="bottom",
                              ha=_side(frequency, lines.values()), color="#555555")  # fmt: skip
    legend_above(axes[0], 4, borderaxespad=1.6, columnspacing=1.2, handlelength=1.4)
    caption = (
        "One-sided power spectral density of each term and of the error, averaged over "
        f"{BINS_PER_DECADE} bins a decade where the record resolves more. Terms are not independent: where two of them "
        "cancel, the error lies below both."
    )
    return save(figure, folder, "budget_spectra", "Spectra of the budget's terms", caption)


def _side(frequency: float, others: Iterable[float]) -> str:
    """Where a line's name is set on a logarithmic axis: away from a neighbour that is too near for both."""
    near = [other for other in others if 1.0 < max(other / frequency, frequency / other) < NEAR]
    if not near:
        return "center"
    return "right" if min(near, key=lambda other: abs(other - frequency)) > frequency else "left"


def _thinned(spectrum: Spectrum) -> tuple[np.ndarray, np.ndarray]:
    """Average frequency and density in bins of equal width on a logarithmic axis, for a curve to look at."""
    f, psd = spectrum.frequency[1:], spectrum.psd[1:]
    bins = np.unique(np.floor(BINS_PER_DECADE * np.log10(f)), return_inverse=True)[1]
    count = np.bincount(bins)
    return np.bincount(bins, f) / count, np.maximum(np.bincount(bins, psd) / count, 1e-300)


def budget_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw those figures that the run has the data for."""
    if not evaluation.budget.x.terms:
        return []
    return [draw(evaluation, folder) for draw in (budget_figure, stacked_terms, budget_spectra)]
