"""Figure of a run whose speed changes: order spectra of the hub, and how they follow the shaft."""

from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from residual.colours import BLUE
from residual.evaluation import Evaluation
from residual.figures import SavedFigure
from residual.orders import HIGHEST, OrderSpectra, Tracking
from residual.panels import COLOUR_BAR, RIGHT, colour_bar, panels
from residual.plotting import legend_above, line_handles, mark_lines, save
from residual.short_time import ShortTime
from residual.words import text

SHORT_TIME_RANGE, RANGE = 1e-8, 1e-9  # of a density's plot
ON_MAP = ("FTF", "BPFO", "BPFI", "BSF")


def order_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the figure, if the speed changes and the record is long enough."""
    x, y = evaluation.x.orders, evaluation.y.orders
    return [] if x is None or y is None else [order_spectrum(x, y, evaluation.y.vibration.body, folder)]


def order_spectrum(x: OrderSpectra, y: OrderSpectra, body: str, folder: Path) -> SavedFigure:
    """Draw order spectra of the hub's path and of the envelope of a body's acceleration, and the path's over time."""
    tracking, short, unit = x.tracking, y.short_time, 1e12  # µm²
    shown = [("path x, µm²", x.path, unit), ("path y, µm²", y.path, unit)]
    if y.envelope is not None:
        shown.append(("envelope y, (m/s²)²", y.envelope, 1.0))
    rows = (len(shown),) if short is None else (len(shown), 1)
    figure, axes = panels(rows, 0.6 + 2.0 * sum(rows), right=RIGHT if short is None else COLOUR_BAR)
    top, families = HIGHEST * tracking.lines["BPFI"], []
    for axis, (name, spectrum, scale) in zip(axes, shown, strict=False):
        families = mark_lines(axis, tracking.lines, 0.0, top, labels=False)
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
        psd = np.maximum(scale * spectrum.psd[inside], 1e-300)
        axis.semilogy(spectrum.frequency[inside], psd, color=BLUE, linewidth=0.9)
        axis.set(xlim=(0.0, top), ylim=(RANGE * psd.max(), 10.0 * psd.max()), ylabel=f"{name}/order")
    axes[len(shown) - 1].set_xlabel("order, per turn of the shaft")
    handles = line_handles(families, tracking.lines, "")
    legend_above(axes[0], 5, left=-0.06, handles=handles, handlelength=1.3, columnspacing=0.9, fontsize=9)
    if short is not None:
        _draw_map(axes[-1], tracking, short)
    low, high = (text(60.0 * speed, 4) for speed in speed_range(tracking))
    caption = (
        f"Order spectra (power spectral densities) of the hub's path, and of the envelope of the "
        f"{body}'s acceleration, "
        f"resampled at {tracking.angles.size} equal angles of the shaft while it turns with {low} to {high} rpm (Δ = "
        f"{text(x.path.resolution, 2)} orders). Dashed: kinematic lines by the run's own cage, which stay where they "
        "are in orders; dotted: multiples."
    )
    if short is not None:
        caption += (
            f" Below, the path's y along the record: Hann windows of {text(short.length, 3)} turns; what follows the "
            "shaft is horizontal."
        )
    return save(figure, folder, "orders", "Order spectra of the hub", caption)


def speed_range(tracking: Tracking) -> tuple[float, float]:
    """Lowest and highest speed of the part that is tracked, 1/s."""
    speed = np.gradient(tracking.turn, tracking.time)
    return float(speed.min()), float(speed.max())


def _draw_map(axis, tracking: Tracking, short: ShortTime) -> None:
    """Draw orders over time."""
    time = 1e3 * np.interp(tracking.turn[0] + short.time, tracking.turn, tracking.time)
    top = 10.0 ** np.ceil(np.log10(max(1e12 * float(short.psd.max()), 1e-30)))
    image = axis.pcolormesh(
        time, short.frequency, np.maximum(1e12 * short.psd, 1e-300), norm=LogNorm(top * SHORT_TIME_RANGE, top),
        cmap="viridis", shading="nearest", rasterized=True,
    )  # fmt: skip
    colour_bar(image, [axis], "path y, µm²/order", extend="min")
    for line in ON_MAP:
        axis.annotate(line, (0.004, tracking.lines[line]), xycoords=("axes fraction", "data"), color="white",
                      fontsize=8.5, va="center")  # fmt: skip
    axis.set(xlabel="time, ms", ylabel="order", ylim=(0.0, HIGHEST * tracking.lines["BPFI"]))
    axis.grid(visible=False)
