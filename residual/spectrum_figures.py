"""Figures of the error forces' spectra: up to the Nyquist frequency, of envelopes, and over time."""

from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm

from residual.colours import BLUE, LINE_COLOURS, SKY, family
from residual.envelope import Envelope
from residual.evaluation import Direction, Evaluation
from residual.figures import SavedFigure
from residual.lines import HUB
from residual.panels import COLOUR_BAR, colour_bar, panels
from residual.plotting import legend_above, line_handles, log_panel, mark_lines, save, without_minor_ticks
from residual.short_time import short_time_spectrum
from residual.words import text

DYNAMIC_RANGE = 1e-7  # of a short-time spectrum's plot
ENVELOPE_BAND = 3.3  # times the ball-pass frequency of the inner ring


def whole_spectra(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the densities up to the Nyquist frequency on logarithmic axes, kinematic lines and peaks marked."""
    figure, axes = panels(2, 6.4, lines=2)
    handles, resonances = [], {}
    for axis, direction in zip(axes, evaluation.directions, strict=True):
        f, psd = direction.spectrum.frequency[1:], direction.spectrum.psd[1:]
        log_panel(axis, f)
        axis.plot(f, np.maximum(psd, 1e-300), color=BLUE, linewidth=0.9)
        top = max(psd.max(), 1e-30)
        axis.set_ylim(max(np.percentile(psd, 2) / 3.0, 1e-14 * top), 12.0 * top)
        handles = line_handles(mark_lines(axis, evaluation.lines, f[0], f[-1], labels=False), evaluation.lines)
        if 0.0 < direction.resonance < f[-1]:
            mark = axis.axvline(direction.resonance, color=SKY, linewidth=5.0, alpha=0.4, zorder=0)
            resonances[direction.name] = mark
        for peak in direction.peaks:
            unnamed = SKY if any(HUB in name for name in peak.also) else "black"
            colour = LINE_COLOURS[family(peak.line)] if peak.line else unnamed
            mark = axis.plot(peak.frequency, 2.2 * peak.psd, marker="v", markersize=6, color=colour,
                             markerfacecolor=colour if peak.resolved else "white", linestyle="none")  # fmt: skip
            mark[0].set_clip_on(False)
        axis.set_ylabel(f"PSD of error_{direction.name}, N²/Hz")
    axes[1].set_xlabel("frequency, Hz")
    if resonances:
        mark = next(iter(resonances.values()))
        mark.set_label(f"hub on its contacts ≈ {_resonances(evaluation, tuple(resonances))}")
        handles.append(mark)
    legend_above(axes[0], 3, handles=handles, columnspacing=1.4)
    caption = (
        f"One-sided power spectral densities of the error forces up to the Nyquist frequency, {f[-1] / 1e3:.4g} kHz. "
        "Dashed: kinematic lines; dotted: their harmonics. Triangles: peaks that stand out of the background, hollow "
        f"where zero frequency or another line lies within {2 * evaluation.x.spectrum.resolution:.3g} Hz."
    )
    return save(figure, folder, "whole_spectra", "Spectra of the error forces", caption)


def _resonances(evaluation: Evaluation, names: tuple[str, ...]) -> str:
    """The ring's resonances in these directions, in words."""
    told = [f"{d.name} {1e-3 * d.resonance:.3g}" for d in evaluation.directions if d.name in names]
    return f"{', '.join(told)} kHz"


def envelope_figure(evaluation: Evaluation, found: list[tuple[Direction, Envelope]], folder: Path) -> SavedFigure:
    """Draw the spectra of the envelopes of the bands around the ring's resonances."""
    figure, axes = panels(len(found), 0.6 + 2.4 * len(found), lines=2)
    top = ENVELOPE_BAND * evaluation.lines.get("BPFI", 1000.0)
    parts = []
    families = []
    for axis, (direction, envelope) in zip(axes, found, strict=True):
        spectrum = envelope.spectrum
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
        axis.semilogy(spectrum.frequency[inside], spectrum.psd[inside], color=BLUE, linewidth=1.0)
        without_minor_ticks(axis)
        axis.set_ylabel(f"envelope PSD, {direction.name}, N²/Hz")
        axis.set_xlim(0.0, top)
        families = mark_lines(axis, evaluation.lines, 0.0, top, labels=False)
        parts.append(
            f"{direction.name}, {envelope.low / 1e3:.3g} to {envelope.high / 1e3:.3g} kHz: {text(envelope.rms, 3)}"
        )
    legend_above(axes[0], 3, handles=line_handles(families, evaluation.lines))
    axes[-1].set_xlabel("frequency, Hz")
    told = _resonances(evaluation, tuple(direction.name for direction, _ in found))
    caption = (
        "Spectra of the envelope of the error force in an octave around the resonance of the ring on its contacts, "
        f"{told}. Rms of the bands, N: {'; '.join(parts)}. A line here means that the vibration at the resonance "
        "swells at that frequency."
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
    figure, axes = panels(2, 6.0, lines=0, right=COLOUR_BAR)
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
        axis.set(ylabel="frequency, kHz", ylim=(0.0, frequency[-1]))
        axis.grid(visible=False)
    axes[1].set_xlabel("time, ms")
    length = found[0].length
    caption = (
        f"Short-time power spectral density of the error forces: Hann windows of {1e3 * length:.3g} ms"
        + (", half a roller passage" if passing > 0.0 else "")
        + f", which tell apart {2e-3 / length:.2g} kHz in frequency and {0.5e3 * length:.2g} ms in time."
        + (
            " Dashed: the ring's resonance on its contacts."
            if any(d.resonance > 0.0 for d in evaluation.directions)
            else ""
        )
    )
    return save(figure, folder, "short_time", "Short-time spectra of the error forces", caption)


def spectrum_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw those figures that the run has the data for."""
    drawn = [whole_spectra(evaluation, folder)]
    envelopes = [(d, d.envelope) for d in evaluation.directions if d.envelope is not None]
    if envelopes:
        drawn.append(envelope_figure(evaluation, envelopes, folder))
    short_time = short_time_figure(evaluation, folder)
    return drawn if short_time is None else [*drawn, short_time]
