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

BAND_COLOUR = dict(color=ORANGE, alpha=0.35, linewidth=0)
LOAD = 2000.0  # N
# name, unit per SI unit, the paper's range
ROWS = (
    ("x of the inner\nring, µm", 1e6, read_off.INNER_X), ("y of the inner\nring, µm", 1e6, read_off.INNER_Y),
    ("ρ − 23 mm of\none roller, µm", 1e6, tuple(r - 23e-3 for r in read_off.ROLLER_RHO)),
    ("ρ′, mm/s", 1e3, read_off.ROLLER_VELOCITY), ("ρ″, m/s²", 1.0, read_off.ROLLER_ACCELERATION),
    ("left side\nof (22), N", 1.0, read_off.ERROR_FORCE),
    ("left side\nof (23), N", 1.0, tuple(LOAD + r for r in read_off.ERROR_FORCE)),
)  # fmt: skip
FIGURES = (6, 6, 7, 7, 7, 8, 9)
FACETED_ROWS = (0, 5, 6)


def _records(found: Record, law: str) -> tuple[np.ndarray, list[np.ndarray]]:
    """Time, ms, and the quantities of ROWS over it."""
    first = int(np.searchsorted(found.time, SKIPPED))
    checked = evaluate(found, law=law, start=SKIPPED)
    j = chosen_roller(checked.budget.loaded, 1)
    rho = [radial(found, j, order)[first:] for order in range(3)]
    x, y = left_sides(checked)
    return 1e3 * found.time[first:], [
        found.inner_x[first:], found.inner_y[first:], rho[0] - 23e-3, rho[1], rho[2], x, y
    ]  # fmt: skip


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
        for row, ((left, right), (name, scale, band), number, a, b) in enumerate(
            zip(axes[:-1], ROWS, FIGURES, mine, other, strict=True)
        ):
            left.plot(time, scale * a, color=BLUE, linewidth=0.7)
            left.set_ylabel(f"Fig. {number}\n{name}")
            low, high = scale * np.array(band)
            right.axhspan(low, high, label="range of the paper's figure", **BAND_COLOUR)
            if row in FACETED_ROWS:
                right.plot(third_time, scale * third[row], color=GREEN, linewidth=0.35, label=titles[1])
            right.plot(other_time, scale * b, color=RED, linewidth=0.35, label=titles[0])
            right.plot(time, scale * a, color=BLUE, linewidth=1.2, label="this program's default")
            shown = [scale * b, scale * third[row]] if row in FACETED_ROWS else [scale * b]
            right.set_ylim(*_limits(low, high, np.concatenate(shown)))
            for axis in (left, right):
                axis.margins(x=0.0)
                axis.set_xlim(0.0, 60.0)
                axis.tick_params(labelbottom=number == 9)
                axis.locator_params(axis="y", nbins=4)
        axes[0, 0].set_title("this program's default, its own scale", fontsize=10)
        axes[0, 1].set_title("at the scale of the paper's figures", fontsize=10)
        for axis in axes[-2]:
            axis.set_xlabel("time, ms")
        _spectra(axes[-1], mine, ours.interval, BLUE)
        _spectra(axes[-1], other, soft.interval, RED)
        _spectra(axes[-1], third, facets.interval, GREEN)
        for axis, number in zip(axes[-1], (10, 11), strict=True):
            axis.axvline(read_off.PEAK, color=ORANGE, alpha=0.6, linewidth=5)
            axis.set(xlim=(0.0, BAND), xlabel=f"frequency, Hz (Fig. {number}: left side of ({number + 12}))")
            axis.set_ylabel("density, N²/Hz" if number == 10 else "")
        axes[-1, 0].annotate("the paper's 22 Hz", (28, 0.03), xycoords=("data", "axes fraction"), color="#8A5A00")
        figure.align_ylabels(axes[:, 0])
        legend = figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside upper center", ncols=2)
        for line in legend.get_lines():
            line.set_linewidth(2.0)
        _save(figure, path)


def _spectra(axes, records: list[np.ndarray], interval: float, colour: str) -> None:
    for axis, record in zip(axes, records[-2:], strict=True):
        found = power_spectrum(record, interval)
        inside = (found.frequency > 0.0) & (found.frequency <= BAND)
        axis.semilogy(found.frequency[inside], found.psd[inside], color=colour, marker=".", markersize=4)


def _limits(low: float, high: float, values: np.ndarray) -> tuple[float, float]:
    """Limits that show the band and, as far as three times its width, the values."""
    size = high - low
    bottom = max(min(low, values.min()), low - size)
    top = min(max(high, values.max()), high + size)
    return bottom - 0.08 * size, top + 0.08 * size


COLUMNS = (
    ("x, µm", "x", 1e6, 0, 1.0), ("y, µm", "y", 1e6, 1, 1.0), ("ρ − 23 mm, µm", "rho", 1e6, 2, 1.0),
    ("ρ′, mm/s", "velocity", 1e3, 3, 10.0), ("ρ″, m/s²", "acceleration", 1.0, 4, 100.0),
    ("(22), N", "fitted", 1.0, 5, 10.0),
)  # fmt: skip


def draw_variants(path: Path, measured: list[tuple[Variant, Measured]]) -> None:
    """Draw a row for each variant, a column for each quantity, the paper's ranges as bands."""
    count = len(measured)
    with plt.rc_context(STYLE | {"font.size": 9, "axes.labelsize": 9.5, "xtick.labelsize": 8.5}):
        figure, axes = plt.subplots(1, len(COLUMNS), figsize=(11.0, 0.36 * count + 1.5), sharey=True)
        rows = np.arange(count)[::-1]
        for axis, (name, field, scale, row, straight) in zip(axes, COLUMNS, strict=True):
            low, high = scale * np.array(ROWS[row][2])
            axis.axvspan(low, high, **BAND_COLOUR)
            for at, (_, found) in zip(rows, measured, strict=True):
                value = getattr(found, field)
                value = value[0] if field == "fitted" else value
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
