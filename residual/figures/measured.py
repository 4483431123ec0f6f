"""Figures of a measured record: its envelope's lines, its spectrum, and an excerpt in time."""

from pathlib import Path

import numpy as np
from matplotlib import rc_context

from lagrange.kinematics import OUTER_RING
from residual.figures.saved import BLUE, GREEN, GREY, ORANGE, RED, SavedFigure
from residual.figures.style import (
    BESIDE,
    STYLE,
    legend_above,
    line_handles,
    mark_lines,
    panels,
    save,
    without_minor_ticks,
)
from residual.formatting import text
from residual.measured.checks import Check, Judged
from residual.measured.diagnosis import DEEP
from residual.measured.strikes import PASSES_IN_BAND, SMOOTHING, Pulse
from residual.measured.trend import Trend

PASSES_SHOWN = 8.0
LINES_TO = 3.2  # times BPFI
MARKED = ("FTF", "shaft", OUTER_RING, "BPFO", "BPFI")
MOST_POINTS = 4000  # of a curve: beyond, the largest of neighbours


def measured_figures(check: Check, folder: Path) -> list[SavedFigure]:
    """Draw the envelope's spectrum, the record's spectrum and an excerpt, and where a line stands out its pulse."""
    with rc_context(STYLE):
        drawn = [_envelope(check, folder), _record(check, folder)]
        if check.record.pulse is not None and check.record.diagnosis.findings[0].stands_out:
            drawn.append(_pulse(check, check.record.pulse, folder))
        return drawn


def _envelope(check: Check, folder: Path) -> SavedFigure:
    """Depth of modulation over frequency, or over turns of the shaft where two records are compared."""
    found = check.record.diagnosis
    judged = [check.record] if check.other is None else [check.record, check.other]
    figure, axes = panels(len(judged), 3.2 + 2.2 * (len(judged) - 1), lines=1)
    by_turns, deepest = len(judged) > 1, 0.0
    for axis, each in zip(axes, judged, strict=True):
        spectrum, unit = each.diagnosis.spectrum, each.diagnosis.shaft if by_turns else 1.0
        lines = {name: line / unit for name, line in each.diagnosis.lines.items()}
        marked = {name: lines[name] for name in MARKED if lines.get(name)} | {"2×BSF": lines["2×BSF"]}
        best = each.diagnosis.findings[0]
        marked |= {line.name: line.found / unit for line in best.lines}
        top = LINES_TO * max(lines["BPFO"], lines["BPFI"], lines["2×BSF"])
        families = mark_lines(axis, marked, 0.0, top, labels=False)
        frequency, depth = _thinned(spectrum.frequency / unit, spectrum.depth, top)
        axis.plot(frequency, depth, color=BLUE, linewidth=0.9)
        if best.stands_out:
            inside = [line for line in best.lines if line.found / unit <= top]
            axis.plot([line.found / unit for line in inside], [line.depth for line in inside], "o", color="black",
                      markersize=3.5)  # fmt: skip
        axis.set(xlim=(0.0, top), ylabel="modulation depth")
        deepest = max(deepest, float(depth[frequency * unit > 3.0 * spectrum.resolution].max()))
        if by_turns:
            axis.text(0.99, 0.97, each.signal.name, transform=axis.transAxes, ha="right", va="top", fontsize=9.5,
                      bbox=BESIDE)  # fmt: skip
        if axis is axes[0]:
            handles = line_handles(families, lines, "" if by_turns else " Hz")
            legend_above(axis, 5, left=-0.06, handles=handles, handlelength=1.3, columnspacing=0.9, handletextpad=0.4,
                         fontsize=9)  # fmt: skip
    for axis in axes:  # both records by one scale
        axis.set_ylim(0.0, 1.15 * deepest)
    axes[-1].set_xlabel("cycles per turn of the shaft" if by_turns else "frequency, Hz")
    caption = (
        f"Squared envelope of the prewhitened record, Δf = {text(found.spectrum.resolution, 3)} Hz. Dashed: kinematic "
        f"lines at the speed as found; dotted: harmonics of {found.findings[0].name}, 2×BSF. Dots: lines that stand "
        "out."
    )
    return save(figure, folder, "envelope", "Lines in the envelope", caption)


def _record(check: Check, folder: Path) -> SavedFigure:
    """Spectrum of each record, and an excerpt of the first."""
    figure, (upper, lower) = panels((1, 1), 6.2, lines=1)
    shared = check.other is None or check.other.signal.unit == check.record.signal.unit
    for judged, colour in ((check.record, BLUE), (check.other, ORANGE)):
        if judged is not None:
            frequency, amplitude = _thinned(judged.spectrum.frequency[1:], judged.spectrum.amplitude[1:], np.inf)
            amplitude = amplitude if shared else amplitude / judged.level.rms
            upper.plot(frequency, amplitude, color=colour, linewidth=0.7, label=judged.signal.name,
                       zorder=3.0 if judged is check.record else 2.0)  # fmt: skip
    unit = check.record.signal.unit or "own unit"
    label = f"amplitude, {unit}" if shared else "amplitude over rms"
    upper.set(xscale="log", yscale="log", xlabel="frequency, Hz", ylabel=label)
    without_minor_ticks(upper)
    legend_above(upper, 2)
    time, values = _excerpt(check.record)
    lower.plot(1e3 * time, values, color=BLUE, linewidth=0.7)
    lower.margins(x=0.0)
    lower.set(xlabel="time, ms", ylabel=unit)
    caption = (
        f"Above: amplitude spectrum of the record. Below: {PASSES_SHOWN:g} passes of rolling elements over a point of "
        "the outer ring, about the largest value."
    )
    return save(figure, folder, "record", "Spectrum and excerpt of the record", caption)


def trend_figure(trend: Trend, folder: Path) -> SavedFigure:
    """Draw depths of lines and the level over a series."""
    with rc_context(STYLE):
        figure, (upper, lower) = panels(2, 4.6, lines=1)
        used = [(k, entry) for k, entry in enumerate(trend.entries, 1) if entry.depths is not None]
        places = np.array([k for k, _ in used])
        for name, colour in (("BPFO", RED), ("BPFI", GREEN), ("2×BSF", ORANGE)):
            depths = [entry.depths[name] for _, entry in used if entry.depths is not None]
            upper.plot(places, depths, "o-", color=colour, markersize=3.5, linewidth=1.0, label=name)
        upper.axhline(DEEP, color=GREY, linestyle="--", linewidth=0.9)
        upper.set(ylabel="modulation depth", ylim=(0.0, None))
        legend_above(upper, 3)
        lower.plot(places, [entry.rms for _, entry in used], "o-", color=BLUE, markersize=3.5, linewidth=1.0)
        lower.set(xlabel="record of the series", ylabel=f"rms, {used[0][1].unit or 'own unit'}", ylim=(0.0, None))
        caption = (
            f"Above: modulation depth of each part's line, all harmonics; dashed: {DEEP:g}, the least for damage. "
            "Below: level of the record."
        )
        return save(figure, folder, "trend", "Growth over the series", caption)


def _pulse(check: Check, own: Pulse, folder: Path) -> SavedFigure:
    """Mean power about a strike, of one record or of both."""
    figure, (axis,) = panels(1, 3.0, lines=1)
    other = None if check.other is None else check.other.pulse
    for pulse, judged, colour in ((own, check.record, BLUE), (other, check.other, ORANGE)):
        if pulse is not None and judged is not None:
            axis.plot(1e3 * pulse.time, pulse.power, color=colour, linewidth=1.1, label=judged.signal.name)
    axis.margins(x=0.0)
    axis.set(xlabel="time from the highest power, ms", ylabel="power over its mean", ylim=(0.0, None))
    legend_above(axis, 2)
    caption = (
        f"Power of the band above {text(PASSES_IN_BAND, 2)} {check.part} (500 Hz at least), the mean over all passes "
        f"at {check.part}, set at the highest of each; smoothed over {text(100.0 * SMOOTHING, 2)} % of a pass. "
        f"It stands above half its height for {text(1e3 * own.length, 3)} ms"
    )
    caption += "." if other is None else f", the other for {text(1e3 * other.length, 3)} ms."
    return save(figure, folder, "pulse", "Pulse of an impact", caption)


def _excerpt(judged: Judged) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and values about the record's largest magnitude."""
    signal = judged.signal
    count = min(signal.values.size, int(PASSES_SHOWN / judged.diagnosis.lines["BPFO"] * signal.rate) + 1)
    middle = int(np.argmax(np.abs(signal.values)))
    first = min(max(0, middle - count // 2), signal.values.size - count)
    return (first + np.arange(count)) / signal.rate, signal.values[first : first + count]


def _thinned(x: np.ndarray, y: np.ndarray, top: float) -> tuple[np.ndarray, np.ndarray]:
    """A curve up to `top`, its highest points kept."""
    keep = x <= top
    x, y = x[keep], y[keep]
    each = max(1, int(np.ceil(x.size / MOST_POINTS)))
    count = x.size // each
    if each == 1:
        return x, y
    index = np.arange(count) * each + np.argmax(y[: count * each].reshape(count, each), axis=1)
    return x[index], y[index]
