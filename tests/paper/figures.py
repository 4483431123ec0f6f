"""docs/paper.png: our figures 6 to 11 beside the paper's ranges; docs/paper-variants.png: every variant's ranges."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from residual import Record, evaluate
from residual.figures import STYLE
from residual.formatting import BLUE, GREEN, GREY, ORANGE, RED
from residual.load_zone import chosen_roller
from residual.spectrum import power_spectrum
from tests.paper import variants as read_off
from tests.paper.variants import BAND, SKIPPED, Measured, Variant, left_sides, radial

RANGE = dict(color=ORANGE, alpha=0.35, linewidth=0)
LOAD = 2000.0  # N
ROWS = (  # the paper's figure, name, unit per SI unit, the paper's range
    (6, "x of the inner\nring, µm", 1e6, read_off.INNER_X), (6, "y of the inner\nring, µm", 1e6, read_off.INNER_Y),
    (7, "ρ − 23 mm of\none roller, µm", 1e6, tuple(r - 23e-3 for r in read_off.ROLLER_RHO)),
    (7, "ρ′, mm/s", 1e3, read_off.ROLLER_VELOCITY), (7, "ρ″, m/s²", 1.0, read_off.ROLLER_ACCELERATION),
    (8, "left side\nof (22), N", 1.0, read_off.ERROR_FORCE),
    (9, "left side\nof (23), N", 1.0, tuple(LOAD + r for r in read_off.ERROR_FORCE)),
)  # fmt: skip
FACETED_ROWS = (0, 5, 6)
COLUMNS = (  # name, quantity, unit per SI unit, its row above, where the axis is straight
    ("x, µm", "x", 1e6, 0, 1.0), ("y, µm", "y", 1e6, 1, 1.0), ("ρ − 23 mm, µm", "rho", 1e6, 2, 1.0),
    ("ρ′, mm/s", "velocity", 1e3, 3, 10.0), ("ρ″, m/s²", "acceleration", 1.0, 4, 100.0),
    ("(22), N", "fitted", 1.0, 5, 10.0),
)  # fmt: skip


def _records(found: Record, law: str) -> tuple[np.ndarray, list[np.ndarray]]:
    """Time, ms, and the quantities of ROWS over it."""
    late = slice(int(np.searchsorted(found.time, SKIPPED)), None)
    checked = evaluate(found, law=law, start=SKIPPED)
    rho = [radial(found, chosen_roller(checked.budget.loaded, 1), order)[late] for order in range(3)]
    places = found.inner_x[late], found.inner_y[late], rho[0] - 23e-3, rho[1], rho[2]
    return 1e3 * found.time[late], [*places, *left_sides(checked)]


def draw_records(path: Path, ours: Record, soft: Record, facets: Record, titles: tuple[str, str]) -> None:
    """Draw each of the paper's figures: ours at its own scale; at the paper's, ours and two comparison runs.

    Left sides are with Harris' law for ours, with the fitted one for the others; the run on facets, which rattles, is
    drawn in x and the left sides.
    """
    with plt.rc_context(STYLE | {"font.size": 9.5, "axes.labelsize": 9.5, "legend.fontsize": 9}):
        figure, axes = plt.subplots(len(ROWS) + 1, 2, figsize=(8.4, 12.6), height_ratios=[1.0] * len(ROWS) + [1.25])
        time, mine = _records(ours, "harris")
        other_time, other = _records(soft, "fitted")
        third_time, third = _records(facets, "fitted")
        for row, ((left, right), (number, name, scale, band)) in enumerate(zip(axes[:-1], ROWS, strict=True)):
            a, b, c = (scale * of[row] for of in (mine, other, third))
            left.plot(time, a, color=BLUE, linewidth=0.7)
            left.set_ylabel(f"Fig. {number}\n{name}")
            low, high = scale * np.array(band)
            right.axhspan(low, high, label="range of the paper's figure", **RANGE)
            if row in FACETED_ROWS:
                right.plot(third_time, c, color=GREEN, linewidth=0.35, label=titles[1])
            right.plot(other_time, b, color=RED, linewidth=0.35, label=titles[0])
            right.plot(time, a, color=BLUE, linewidth=1.2, label="this program's default")
            # the band and, as far as three times its width, the values
            shown, size = np.concatenate([b, c]) if row in FACETED_ROWS else b, high - low
            bottom, top = max(min(low, shown.min()), low - size), min(max(high, shown.max()), high + size)
            right.set_ylim(bottom - 0.08 * size, top + 0.08 * size)
            for axis in (left, right):
                axis.margins(x=0.0)
                axis.set_xlim(0.0, 60.0)
                axis.tick_params(labelbottom=number == 9)
                axis.locator_params(axis="y", nbins=4)
        axes[0, 0].set_title("this program's default, its own scale", fontsize=10)
        axes[0, 1].set_title("at the scale of the paper's figures", fontsize=10)
        for axis, number, side in zip(axes[-1], (10, 11), (-2, -1), strict=True):
            for sides, run, colour in ((mine, ours, BLUE), (other, soft, RED), (third, facets, GREEN)):
                found = power_spectrum(sides[side], run.interval)
                inside = (found.frequency > 0.0) & (found.frequency <= BAND)
                axis.semilogy(found.frequency[inside], found.psd[inside], color=colour, marker=".", markersize=4)
            axis.axvline(read_off.PEAK, color=ORANGE, alpha=0.6, linewidth=5)
            axis.set(xlim=(0.0, BAND), xlabel=f"frequency, Hz (Fig. {number}: left side of ({number + 12}))")
            axis.set_ylabel("density, N²/Hz" if number == 10 else "")
            axes[-2, number - 10].set_xlabel("time, ms")
        axes[-1, 0].annotate("the paper's 22 Hz", (28, 0.03), xycoords=("data", "axes fraction"), color="#8A5A00")
        figure.align_ylabels(axes[:, 0])
        legend = figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside upper center", ncols=2)
        for line in legend.get_lines():
            line.set_linewidth(2.0)
        _save(figure, path)


def draw_variants(path: Path, measured: list[tuple[Variant, Measured]]) -> None:
    """Draw a row for each variant, a column for each quantity, the paper's ranges as bands."""
    count = len(measured)
    with plt.rc_context(STYLE | {"font.size": 9, "axes.labelsize": 9.5, "xtick.labelsize": 8.5}):
        figure, axes = plt.subplots(1, len(COLUMNS), figsize=(11.0, 0.36 * count + 1.5), sharey=True)
        rows = np.arange(count)[::-1]
        for axis, (name, field, scale, row, straight) in zip(axes, COLUMNS, strict=True):
            low, high = scale * np.array(ROWS[row][-1])
            axis.axvspan(low, high, **RANGE)
            for at, (_, found) in zip(rows, measured, strict=True):
                value = found.fitted[0] if field == "fitted" else getattr(found, field)
                value = scale * (np.array(value) - (23e-3 if field == "rho" else 0.0))
                axis.plot(value, [at, at], color=BLUE, linewidth=4.5, solid_capstyle="butt")
                axis.plot(value, [at, at], color=BLUE, marker="|", markersize=8, linestyle="none", markeredgewidth=1.5)
            axis.set_xscale("symlog", linthresh=straight)
            ends = [v for v in axis.get_xlim() if v]
            decade = 10.0 ** np.floor(np.log10(max(np.abs(ends))))
            wanted = (-decade, 0.0, decade) if ends[-1] > 0.0 else (-decade, -0.1 * decade, 0.0)
            axis.set_xticks([t for t in wanted if ends[0] <= t <= max(ends[-1], 0.0)])
            axis.axvline(0.0, color=GREY, linewidth=0.7)
            axis.set_xlabel(name)
            axis.minorticks_off()
        axes[0].set_yticks(rows, [variant.title for variant, _ in measured])
        axes[0].set_ylim(-0.7, count - 0.3)
        title = "Ranges over 60 ms (bars) and of the paper's figures (bands); axes logarithmic on both sides of 0"
        figure.suptitle(title, fontsize=10)
        _save(figure, path)


def _save(figure, path: Path) -> None:
    figure.savefig(path, dpi=130, metadata={"Software": None})
    plt.close(figure)
