"""Figures of spectra: of error forces, of envelopes, over time, and over the shaft's angle."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from residual.evaluation import Direction, Evaluation
from residual.figures.saved import BLUE, LINE_COLOURS, SKY, SavedFigure, family
from residual.figures.style import (
    COLOUR_BAR,
    RIGHT,
    colour_bar,
    legend_above,
    line_handles,
    log_panel,
    mark_lines,
    panels,
    save,
    without_minor_ticks,
)
from residual.formatting import text
from residual.lines import HUB
from residual.orders import HIGHEST, OrderSpectra, Tracking
from residual.spectrum import ShortTime, short_time_spectrum

DYNAMIC_RANGE = 1e-7  # of a short-time spectrum's plot
LEAST_BINS = 20  # of an envelope's spectrum, of a record shorter than a passage
ENVELOPE_BAND = 3.3  # times the ball-pass frequency of the inner ring
SHORT_TIME_RANGE, RANGE = 1e-8, 1e-9  # of a density's plot over orders
ON_MAP = ("FTF", "BPFO", "BPFI", "BSF")


def whole_spectra(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the densities up to the Nyquist frequency on logarithmic axes, kinematic lines and peaks marked."""
    names = [f"PSD of error_{axis}, N²/Hz" for axis in "xy"]
    figure, axes = panels(2, 6.4, lines=2, x="frequency, Hz", y=names)
    handles, marked, mark = [], [], None
    for axis, direction in zip(axes, evaluation.directions, strict=True):
        f, psd = direction.spectrum.frequency[1:], direction.spectrum.psd[1:]
        log_panel(axis, f)
        axis.plot(f, np.maximum(psd, 1e-300), color=BLUE, linewidth=0.9)
        top = max(psd.max(), 1e-30)
        axis.set_ylim(max(np.percentile(psd, 2) / 3.0, 1e-14 * top), 12.0 * top)
        handles = line_handles(mark_lines(axis, evaluation.lines, f[0], f[-1]), evaluation.lines)
        if 0.0 < direction.resonance < f[-1]:
            mark = axis.axvline(direction.resonance, color=SKY, linewidth=5.0, alpha=0.4, zorder=0)
            marked.append(direction)
        for peak in direction.peaks:
            unnamed = SKY if any(HUB in name for name in peak.also) else "black"
            colour = LINE_COLOURS[family(peak.line)] if peak.line else unnamed
            axis.plot(peak.frequency, 2.2 * peak.psd, marker="v", markersize=6, color=colour, linestyle="none",
                      markerfacecolor=colour if peak.resolved else "white", clip_on=False)  # fmt: skip
    if mark is not None:
        mark.set_label(f"hub on its contacts ≈ {_resonances(marked)}")
        handles.append(mark)
    legend_above(axes[0], 3, handles=handles, columnspacing=1.4)
    caption = (
        f"One-sided power spectral densities of the error forces up to the Nyquist frequency, {f[-1] / 1e3:.4g} kHz. "
        "Dashed: kinematic lines; dotted: their harmonics. Triangles: peaks that stand out of the background, hollow "
        f"where zero frequency or another line lies within {2 * evaluation.x.spectrum.resolution:.3g} Hz."
    )
    return save(figure, folder, "whole_spectra", "Spectra of the error forces", caption)


def _resonances(directions: Iterable[Direction]) -> str:
    """The ring's resonances in some directions, in words."""
    return ", ".join(f"{d.name} {1e-3 * d.resonance:.3g}" for d in directions) + " kHz"


def envelope_figure(evaluation: Evaluation, folder: Path) -> SavedFigure | None:
    """Draw the spectra of the envelopes of the bands around the ring's resonances; None where there are none."""
    found = [(d, d.envelope) for d in evaluation.directions if d.envelope is not None]
    if not found:
        return None
    names = [f"envelope PSD, {direction.name}, N²/Hz" for direction, _ in found]
    figure, axes = panels(len(found), 0.6 + 2.4 * len(found), lines=2, x="frequency, Hz", y=names)
    finest = max(float(envelope.spectrum.frequency[1]) for _, envelope in found)
    top = max(ENVELOPE_BAND * evaluation.lines.get("BPFI", 1000.0), LEAST_BINS * finest)
    parts, families = [], []
    for axis, (direction, envelope) in zip(axes, found, strict=True):
        spectrum = envelope.spectrum
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
        axis.semilogy(spectrum.frequency[inside], spectrum.psd[inside], color=BLUE, linewidth=1.0)
        without_minor_ticks(axis)
        axis.set_xlim(0.0, top)
        families = mark_lines(axis, evaluation.lines, 0.0, top)
        parts.append(
            f"{direction.name}, {envelope.low / 1e3:.3g} to {envelope.high / 1e3:.3g} kHz: {text(envelope.rms, 3)}"
        )
    legend_above(axes[0], 3, handles=line_handles(families, evaluation.lines))
    caption = (
        "Spectra of the envelope of the error force in an octave around the resonance of the ring on its contacts, "
        f"{_resonances(d for d, _ in found)}. Rms of the bands, N: {'; '.join(parts)}. A line means that the resonance "
        "is amplitude-modulated at that frequency."
    )
    return save(figure, folder, "envelope", "Envelope spectra around the ring's resonances", caption)


def short_time_figure(evaluation: Evaluation, folder: Path) -> SavedFigure | None:
    """Draw how the errors' spectra change along the record; None for a record too short for it."""
    t = evaluation.record
    passing = evaluation.lines.get("BPFO", 0.0)
    tried = [short_time_spectrum(d.budget.error, t.interval, passing) for d in evaluation.directions]
    found = [spectrum for spectrum in tried if spectrum is not None]
    if len(found) < len(tried):
        return None
    figure, axes = panels(2, 6.0, lines=0, right=COLOUR_BAR, x="time, ms", y=["frequency, kHz"] * 2)
    for axis, direction, spectrum in zip(axes, evaluation.directions, found, strict=True):
        time, frequency = 1e3 * (t.time[0] + spectrum.time), 1e-3 * spectrum.frequency
        top = 10.0 ** np.ceil(np.log10(max(spectrum.psd.max(), 1e-30)))
        half = 0.5 * (time[1] - time[0]), 0.5 * frequency[1]
        image = axis.imshow(
            spectrum.psd, norm=LogNorm(top * DYNAMIC_RANGE, top), cmap="viridis", origin="lower", aspect="auto",
            extent=(time[0] - half[0], time[-1] + half[0], -half[1], frequency[-1] + half[1]), interpolation="nearest",
        )  # fmt: skip
        colour_bar(image, [axis], f"PSD of error_{direction.name}, N²/Hz", extend="min")
        if 0.0 < direction.resonance < spectrum.frequency[-1]:
            axis.axhline(1e-3 * direction.resonance, color="white", linestyle=(0, (4, 3)), linewidth=1.0)
        axis.set_ylim(0.0, frequency[-1])
        axis.grid(visible=False)
    length, half_passage = found[0].length, ", half a roller passage" if passing > 0.0 else ""
    caption = (
        f"Short-time power spectral density of the error forces: Hann windows of {1e3 * length:.3g} ms{half_passage}, "
        f"which resolve {2e-3 / length:.2g} kHz in frequency and {0.5e3 * length:.2g} ms in time."
    )
    if any(d.resonance > 0.0 for d in evaluation.directions):
        caption += " Dashed: the ring's resonance on its contacts."
    return save(figure, folder, "short_time", "Short-time spectra of the error forces", caption)


def spectrum_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw those figures that the run has the data for."""
    drawn = (draw(evaluation, folder) for draw in (whole_spectra, envelope_figure, short_time_figure))
    return [figure for figure in drawn if figure is not None]


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
    top, families = HIGHEST * max(tracking.lines["BPFO"], tracking.lines["BPFI"]), []
    for axis, (name, spectrum, scale) in zip(axes, shown, strict=False):
        families = mark_lines(axis, tracking.lines, 0.0, top)
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
        psd = np.maximum(scale * spectrum.psd[inside], 1e-300)
        axis.semilogy(spectrum.frequency[inside], psd, color=BLUE, linewidth=0.9)
        axis.set(xlim=(0.0, top), ylim=(RANGE * psd.max(), 10.0 * psd.max()), ylabel=f"{name}/order")
    axes[len(shown) - 1].set_xlabel(f"order, per turn of the {tracking.ring}")
    handles = line_handles(families, tracking.lines, "")
    legend_above(axes[0], 5, left=-0.06, handles=handles, handlelength=1.3, columnspacing=0.9, fontsize=9)
    if short is not None:
        _draw_map(axes[-1], tracking, short)
    speed = 60.0 * np.gradient(tracking.turn, tracking.time)
    low, high = text(float(speed.min()), 4), text(float(speed.max()), 4)
    caption = (
        f"Order spectra (power spectral densities) of the hub's path, and of the envelope of the {body}'s "
        f"acceleration, resampled at {tracking.angles.size} equal angles of the {tracking.ring} while it turns with "
        f"{low} to {high} rpm (Δ = {text(x.path.resolution, 2)} orders). Dashed: kinematic lines by the run's own "
        "cage, which stay where they are in orders; dotted: multiples."
    )
    if short is not None:
        caption += (
            f" Below, the path's y along the record: Hann windows of {text(short.length, 3)} turns; what follows the "
            f"{tracking.ring} is horizontal."
        )
    return save(figure, folder, "orders", "Order spectra of the hub", caption)


def _draw_map(axis, tracking: Tracking, short: ShortTime) -> None:
    """Draw orders over time."""
    time = 1e3 * np.interp(tracking.turn[0] + short.time, tracking.turn, tracking.time)
    top = 10.0 ** np.ceil(np.log10(max(1e12 * float(short.psd.max()), 1e-30)))
    image = axis.pcolormesh(
        time, short.frequency, np.maximum(1e12 * short.psd, 1e-300), norm=LogNorm(top * SHORT_TIME_RANGE, top),
        cmap="viridis", shading="nearest", rasterized=True,
    )  # fmt: skip
    colour_bar(image, [axis], "path y, µm²/order", extend="min")
    for line in (name for name in ON_MAP if name in tracking.lines):
        axis.annotate(line, (0.004, tracking.lines[line]), xycoords=("axes fraction", "data"), color="white",
                      fontsize=8.5, va="center")  # fmt: skip
    axis.set(
        xlabel="time, ms", ylabel="order", ylim=(0.0, HIGHEST * max(tracking.lines["BPFO"], tracking.lines["BPFI"]))
    )
    axis.grid(visible=False)
