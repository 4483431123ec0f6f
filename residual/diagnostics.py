"""Figures that the paper lacks: what the error is made of, the rollers' loads, the energy balance."""

from pathlib import Path

import numpy as np

from residual.evaluation import Evaluation
from residual.moments import rms
from residual.plotting import (
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    RED,
    TERM_COLOURS,
    WIDTH,
    SavedFigure,
    legend_above,
    panels,
    plt,
    save,
)
from residual.sources import ENERGIES
from residual.words import words

MOST_POINTS = 20_000  # of a scatter plot: more hide each other


def budget_figure(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the error's terms over time, and their rms."""
    t, budget = evaluation.record, evaluation.budget
    terms = {
        d.name: {"error": d.budget.error, **{name: d.budget.terms[name] for name in budget.acting_terms},
                 "momentum": d.budget.momentum}
        for d in evaluation.directions
    }  # fmt: skip
    acting = budget.acting_terms
    figure = plt.figure(figsize=(WIDTH, 8.4))
    grid = figure.add_gridspec(3, 1, height_ratios=(1.0, 1.0, 1.25))
    upper = figure.add_subplot(grid[0])
    axes = [upper, figure.add_subplot(grid[1], sharex=upper)]
    upper.tick_params(labelbottom=False)
    for axis, direction in zip(axes, evaluation.directions, strict=True):
        for name in ("error", *acting):
            axis.plot(1e3 * t.time, terms[direction.name][name], color=TERM_COLOURS[name], label=words(name),
                      linewidth=1.4 if name == "error" else 0.9)  # fmt: skip
        axis.set_ylabel(f"terms of error_{direction.name}, N")
        axis.margins(x=0.0)
    legend_above(axes[0], 5, left=-0.1, columnspacing=1.0, handlelength=1.3)
    axes[1].set_xlabel("time, ms")
    bars = figure.add_subplot(grid[2])
    names = ["error", *acting, "momentum"]
    position = np.arange(len(names))[::-1]
    for offset, direction, shade in ((0.19, "x", 1.0), (-0.19, "y", 0.5)):
        values = [rms(terms[direction][name]) for name in names]
        colours = [TERM_COLOURS[name] for name in names]
        drawn = bars.barh(position + offset, values, height=0.34, color=colours, alpha=shade)
        texts = [f"{direction}: {v:.3g} N" for v in values]
        bars.bar_label(drawn, texts, padding=4, fontsize=8.5)
    bars.set_xscale("log")
    everything = [v for found in terms.values() for v in map(rms, found.values()) if v > 0.0]
    top = max(everything, default=1.0)
    bars.set_xlim(max(min(everything, default=0.1) / 2.0, 1e-5 * top), 8.0 * top)
    bars.set_yticks(
        position, [words(n).replace(" ", "\n", 1) + ("\nbalance" if n == "momentum" else "") for n in names]
    )
    bars.set_xlabel("rms, N (dark: x, light: y)")
    bars.grid(axis="y", visible=False)
    caption = (
        "What the error forces are made of; the terms add up to the error sample by sample. Momentum balance: the "
        "error with the run's own contact forces in place of the law, = differentiation + ring flexibility."
    )
    return save(figure, folder, "budget", "Budget of the error forces", caption)


def roller_loads(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the law's and the run's inner contact forces over the roller's angle from the load line."""
    t, budget = evaluation.record, evaluation.budget
    stride = max(1, budget.law_force.size // MOST_POINTS)
    rows = slice(None, None, stride)
    away = np.arctan2(-budget.contacts.direction_y[rows], -budget.contacts.direction_x[rows]) + 0.5 * np.pi
    angle = np.degrees((away + np.pi) % (2.0 * np.pi) - np.pi)
    told = t.inner_force is not None
    figure, axes = panels(2 if told else 1, 5.6 if told else 3.8)
    axis = axes[0]
    style = {"linestyle": "none", "marker": ".", "markersize": 2.5, "rasterized": True}
    axis.plot(angle.ravel(), budget.law_force[rows].ravel(), color=RED, label=f"law: {evaluation.law.name}", **style)
    if told:
        axis.plot(angle.ravel(), t.inner_force[rows].ravel(), color=BLUE, label="run's own contact force", **style)
        closed = budget.loaded[rows]
        miss = (t.inner_force - budget.law_force)[rows]
        axes[1].plot(angle[closed], miss[closed], color=PURPLE, **style)
        axes[1].set_ylabel("run − law, closed contacts, N")
    axis.set_ylabel("inner contact force, N")
    axes[-1].set_xlabel("roller's angle from the load line, degrees")
    axis.set_xlim(-180.0, 180.0)
    axis.set_xticks(np.arange(-180, 181, 45))
    axis.set_ylim(bottom=0.0)
    axis.legend(loc="upper left", markerscale=5)
    caption = (
        "Contact force between the inner ring and each roller, all rollers and times, over the roller's angle from "
        "the load line (counter-clockwise)."
    ) + (" Below: how far the law misses the closed contacts." if told else "")
    return save(figure, folder, "loads", "Loads of the rollers", caption)


def energy_balance(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the changes of energies and works since the first sample, and what does not add up."""
    t = evaluation.record
    names = {
        "energy_kinetic": ("kinetic", BLUE),
        "energy_elastic": ("elastic", RED),
        "energy_contact": ("contact", PURPLE),
        "work_external": ("external work", GREEN),
        "work_dissipated": ("dissipated", GREY),
    }
    figure, axes = panels(2, 4.8)
    for key, (label, colour) in names.items():
        change = t.energies[key] - t.energies[key][0]
        axes[0].plot(1e3 * t.time, 1e3 * change, label=label, color=colour)
    axes[0].margins(x=0.0)
    axes[0].set_ylabel("change, mJ")
    legend_above(axes[0], 5, columnspacing=1.2)
    imbalance = energy_imbalance(t.energies)
    scale = float(np.mean(t.energies["energy_elastic"] + t.energies["energy_contact"]))
    axes[1].plot(1e3 * t.time, 1e6 * imbalance, color="black")
    axes[1].set(xlabel="time, ms", ylabel="imbalance, µJ")
    share = (
        f"; at most {100 * np.max(np.abs(imbalance)) / scale:.2g} % of the mean strain energy" if scale > 0.0 else ""
    )
    caption = (
        "Energies and works since the first sample shown. Imbalance: kinetic + elastic + contact − external work + "
        f"dissipated, all as changes{share}."
    )
    return save(figure, folder, "energy", "Energy balance of the run", caption)


def energy_imbalance(energies) -> np.ndarray:
    """Change of the energies minus external work plus dissipation since the first sample, J, (n_times,)."""
    total = energies["energy_kinetic"] + energies["energy_elastic"] + energies["energy_contact"]
    total = total - energies["work_external"] + energies["work_dissipated"]
    return total - total[0]


def extra_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw those figures that the run has the data for."""
    drawn = []
    if evaluation.budget.x.terms:
        drawn.append(budget_figure(evaluation, folder))
    drawn.append(roller_loads(evaluation, folder))
    if set(ENERGIES) <= set(evaluation.record.energies):
        drawn.append(energy_balance(evaluation, folder))
    return drawn
