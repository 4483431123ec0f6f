"""Figures of spectra: of error forces and their terms, of vibration, over the shaft's angle, of measured records."""

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import LogNorm

from lagrange.kinematics import OUTER_RING
from lagrange.messages import G
from residual import figures as look
from residual.evaluation import Evaluation
from residual.figures import SCALE, SMALL, Drawing, colour_bar, curves, legend_above, log_panel, mark_lines, panels
from residual.formatting import BLUE, GREEN, GREY, LINE_COLOURS, ORANGE, RED, SKY, TERM_COLOURS, family, text
from residual.measured.diagnosis import DEEP
from residual.measured.judged import PASSES_IN_BAND, SMOOTHING, Entry, Judged
from residual.spectrum import rms
from residual.vibration import HIGHEST, HUB, fault_lines

TINY = np.finfo(float).tiny
PASSAGES_SHOWN, PASSES_SHOWN = 5.0, 8.0  # of a run's and of a record's acceleration
BINS_PER_DECADE = 120
TERM_RANGE, ORDERS_RANGE, PATH_RANGE = 1e-9, 1e-8, 1e-9  # of densities shown
USUAL_TERMS, ROOM_FOR_A_TERM, INCHES_OF_A_SHARE = 4, 0.4, 1.6  # more terms take more room for their bars
NAMES = 1.2  # inches, of terms beside their bars
SPECTRUM_TO, LINES_TO = 2.2, 3.2  # times BPFI: of runs' and records' vibration
HEADROOM = 1.05  # above the highest line
OF_RECORDS = 0.05  # of the width of a record's spectrum or a series, on either side
MARKED = ("FTF", "shaft", OUTER_RING, "BPFO", "BPFI")
TURNS_PER_PIECE, FEWEST_PIECES = 10.0, 4  # of a map of orders: FTF, some 0.4, is then four bins off order 0
ON_MAP = ("FTF", "BPFO", "BPFI", "BSF")
MOST_POINTS = 4000  # of a record's curve: beyond, the largest of neighbours
LEFT_LEGEND = {"left": -0.06, **SMALL}


def whole(e: Evaluation) -> Drawing:
    figure, axes = panels(2, 6.4, lines=2, x="frequency, Hz", y=[f"PSD of error_{axis}, N²/Hz" for axis in "xy"])
    marked = []  # directions whose resonance is within the panel
    for axis, d in zip(axes, e.directions, strict=True):
        f, psd = d.spectrum.frequency[1:], d.spectrum.psd[1:]
        log_panel(axis, f)
        curves(axis, f, (np.maximum(psd, 1e-300), BLUE))
        top = max(psd.max(), 1e-30)
        axis.set_ylim(max(np.percentile(psd, 2) / 3.0, 1e-14 * top), 12.0 * top)
        handles = mark_lines(axis, e.lines, f[0], f[-1])
        if 0.0 < d.resonance < f[-1]:
            mark = axis.axvline(d.resonance, color=SKY, linewidth=5.0, alpha=0.4, zorder=0)
            marked.append(d)
        for peak in d.peaks:
            colour = SKY if any(HUB in name for name in peak.also) else "black"
            colour = LINE_COLOURS[family(peak.line)] if peak.line else colour
            axis.plot(peak.frequency, 2.2 * peak.psd, marker="v", markersize=6, color=colour, linestyle="none",
                      markerfacecolor=colour if peak.resolved else "white", clip_on=False)  # fmt: skip
    if marked:
        resonances = ", ".join(f"{d.name} {1e-3 * d.resonance:.3g}" for d in marked)
        mark.set_label(f"hub on its contacts ≈ {resonances} kHz")
        handles.append(mark)
    legend_above(axes[0], 3, handles=handles, columnspacing=1.4)
    return Drawing("whole_spectra", "Spectra of the error forces",
        f"One-sided power spectral densities of the error forces up to the Nyquist frequency, {f[-1] / 1e3:.4g} kHz. "
        "Dashed: kinematic lines; dotted: their harmonics. Triangles: peaks that stand out of the background, hollow "
        f"where zero frequency or another line lies within {2 * e.x.spectrum.resolution:.3g} Hz.", figure)  # fmt: skip


def budget(e: Evaluation) -> list[Drawing | None]:
    """The errors' terms over time and as spectra; none without contact forces."""
    x, y = e.budget.x.terms, e.budget.y.terms
    acting = {name: name.replace("_", " ") for name in x if np.any(x[name]) or np.any(y[name])}
    return [_terms(e, acting), _term_spectra(e, acting)] if x else []


def _terms(e, acting):
    more = ROOM_FOR_A_TERM * max(0, len(acting) - USUAL_TERMS)
    shares, x = (1.0, 1.0, 1.4 + more / INCHES_OF_A_SHARE), ("time, ms", "rms, N (full colour: x, faint: y)")
    names = [f"terms of error_{axis}, N" for axis in "xy"]
    figure, (*axes, bars) = panels((2, 1), 8.4 + more, lines=2, shares=shares, left=NAMES, x=x, y=names)
    labels = {"error": "error", **acting, "momentum": "momentum balance"}
    position, colours, sizes = np.arange(len(labels))[::-1], [TERM_COLOURS[name] for name in labels], []
    for axis, d, offset, shade in zip(axes, e.directions, (0.19, -0.19), (1.0, 0.5), strict=True):
        rows = [(d.budget.error, "black", "error", 1.4)]
        rows += [(d.budget.terms[name], TERM_COLOURS[name], label, 0.9) for name, label in acting.items()]
        curves(axis, 1e3 * e.record.time, *rows)
        widths = [*(rms(row[0]) for row in rows), 0.0 if d.balance is None else d.balance.rms]
        drawn = bars.barh(position + offset, widths, height=0.34, color=colours, alpha=shade)
        bars.bar_label(drawn, [f"{d.name}: {text(v, 3)} N" for v in widths], padding=4, fontsize=8.5)
        sizes += [v for v in widths if v > 0.0]
    legend_above(axes[0], 5, left=-0.1, columnspacing=1.0, handlelength=1.3)
    top = max(sizes, default=1.0)
    bars.set(xscale="log", xlim=(max(min(sizes, default=0.1) / 2.0, 1e-5 * top), 8.0 * top))
    look.without_minor_ticks(bars)
    bars.set_yticks(position, [label.replace(" ", "\n", 1) for label in labels.values()])
    bars.grid(axis="y", visible=False)
    return Drawing("budget", "Budget of the error forces",
        "What the error forces are made of; the terms add up to the error sample by sample. Momentum balance: the "
        "error with the run's own contact forces in place of the law, = differentiation + ring flexibility.",
        figure)  # fmt: skip


def _term_spectra(e, acting):
    figure, axes = panels(2, 6.4, lines=3, x="frequency, Hz", y=[f"PSD, {axis}, N²/Hz" for axis in "xy"])
    for axis, d in zip(axes, e.directions, strict=True):
        f, psd = _by_decade(d.spectrum)
        log_panel(axis, f)
        curves(axis, f, (psd, "black", "error", {"linewidth": 2.6, "alpha": 0.35}))
        for name, label in acting.items():
            at, density = _by_decade(d.term_spectra[name])
            curves(axis, at, (density, TERM_COLOURS[name], label))
        top = max(psd.max(), 1e-30)
        axis.set_ylim(TERM_RANGE * top, 10.0 * top)
        terms, _ = axis.get_legend_handles_labels()
        lines = mark_lines(axis, {name: line for name, line in e.lines.items() if "×" not in name}, f[0], f[-1])
    legend_above(axes[0], 4, handles=[*terms, *lines], columnspacing=1.2, handlelength=1.4)
    return Drawing("budget_spectra", "Spectra of the budget's terms",
        "One-sided power spectral density of each term and of the error, averaged over "
        f"{BINS_PER_DECADE} bins a decade where the record resolves more. Dashed: kinematic lines. Terms are not "
        "independent: where two of them cancel, the error lies below both.", figure)  # fmt: skip


def _by_decade(spectrum):
    """Mean frequency and density in bins of equal width on a logarithmic axis, for a curve to look at."""
    f, psd = spectrum.frequency[1:], spectrum.psd[1:]
    bins = np.unique(np.floor(BINS_PER_DECADE * np.log10(f)), return_inverse=True)[1]
    count = np.bincount(bins)
    return np.bincount(bins, f) / count, np.maximum(np.bincount(bins, psd) / count, 1e-300)


def acceleration(e: Evaluation) -> Drawing:
    figure, (axis,) = panels(1, 3.2, x="frequency, Hz", y=["amplitude, g"])
    for d, colour in zip(e.directions, (SKY, BLUE), strict=True):
        spectrum, frequency = d.vibration.spectrum, d.vibration.spectrum.frequency[1:]
        amplitude = np.maximum(spectrum.amplitude[1:] / G, TINY)
        curves(axis, frequency, (amplitude, colour, f"{d.vibration.body}, {d.name}", 0.7))
    log_panel(axis, frequency)
    legend_above(axis, 2)
    body = e.y.vibration.body
    caption = f"Amplitude spectra, not rms, Δf = {text(spectrum.resolution, 3)} Hz."
    return Drawing(f"{body}_spectrum", f"Spectra of the {body}'s acceleration", caption, figure)


def envelope(e: Evaluation) -> Drawing | None:
    """The band of the acceleration with its envelope over a few passages, and the envelope's spectra.

    None where the record resolves none of their lines.
    """
    if not any(line.resolved for line in e.x.vibration.lines):
        return None
    found = [(d, d.vibration.envelope) for d in e.directions if d.vibration.envelope is not None]
    loud, loudest = max(found, key=lambda each: each[0].vibration.level.rms)
    t, body, names = e.record, e.y.vibration.body, [f"{d.vibration.body}, {d.name}, g" for d in (loud, *e.directions)]
    figure, (upper, *axes) = panels(
        (1, 2), 7.4, lines=2, shares=(0.85, 1.0, 1.0), x=("time, ms", "frequency, Hz"), y=names)  # fmt: skip
    n = min(t.time.size, int(PASSAGES_SHOWN / e.lines["BPFO"] / t.interval) + 1)
    shown = slice((t.time.size - n) // 2, (t.time.size + n) // 2)
    band = loudest.band[shown] / G, SKY, "acceleration in the band", 0.6
    curves(upper, 1e3 * t.time[shown], band, (loudest.level[shown] / G, BLUE, "its envelope", 0.8), legend=2)
    top = SPECTRUM_TO * max(e.lines[name] for name in ("BPFO", "BPFI"))
    lines = {name: e.lines[name] for name in MARKED[:3] if name in e.lines} | fault_lines(e.lines)
    for axis, (d, each) in zip(axes, found, strict=True):
        handles = mark_lines(axis, lines, 0.0, top, of=e.lines)
        frequency = each.spectrum.frequency
        inside = (frequency > 0.0) & (frequency <= top)
        amplitude = each.spectrum.amplitude[inside] / G
        curves(axis, frequency[inside], (amplitude, BLUE, None, 1.0), xlim=(0.0, top))
        highest, high = amplitude.max(), []
        for line in (line for line in d.vibration.lines if line.is_high and line.frequency <= top):
            colour, height, sideband = LINE_COLOURS[family(line.name)], line.amplitude / G, {*line.name} & {*"−+"}
            axis.plot(line.frequency, height, "o", color=colour, markersize=3.0 if sideband else 4.5,
                      markerfacecolor=colour if line.resolved else "white")  # fmt: skip
            high += [] if sideband else [(line.frequency, line.name, colour)]
            highest = max(highest, height)
        axis.set_ylim(0.0, HEADROOM * max(highest, TINY))
        look.name_lines(axis, high)
    legend_above(axes[0], 5, handles=handles, **LEFT_LEGEND)
    return Drawing(f"{body}_envelope", f"Envelope spectra of the {body}'s acceleration",
        f"Acceleration of the {loud.vibration.body} within {text(1e-3 * loudest.low, 3)} to "
        f"{text(1e-3 * loudest.high, 3)} kHz: in {loud.name} over {PASSAGES_SHOWN:g} roller "
        "passages with its envelope, and amplitude spectra of the "
        f"envelopes (Δf = {text(loudest.spectrum.resolution, 3)} Hz). Dashed: FTF, shaft, BPFO, BPFI; dotted: "
        "multiples, sidebands of BPFI by the shaft, and 2×BSF with sidebands by the cage. Dots: lines that are high "
        "above their floors, hollow where the record does not resolve them.", figure)  # fmt: skip


def orders(e: Evaluation) -> Drawing | None:
    """Order spectra of the hub's path and of the envelope of a body's acceleration, and the path's over time.

    None where the speed stays, or the record is too short.
    """
    x, y, body = e.x.orders, e.y.orders, e.y.vibration.body
    if x is None or y is None:
        return None
    tracking = x.tracking
    shown = [("path x, µm²", x.path, 1e12), ("path y, µm²", y.path, 1e12)]
    if y.envelope is not None:
        shown.append(("envelope y, (m/s²)²", y.envelope, 1.0))
    over, names = tracking.ring, [*(f"{name}/order" for name, *_ in shown), "order"]
    x_names = f"order, per turn of the {over}", f"turns of the {over}"
    figure, axes = panels((len(shown), 1), 2.6 + 2.0 * len(shown), right=SCALE, x=x_names, y=names)
    top = HIGHEST * max(tracking.lines["BPFO"], tracking.lines["BPFI"])
    for axis, (_, spectrum, scale) in zip(axes, shown, strict=False):
        handles = mark_lines(axis, tracking.lines, 0.0, top, "")
        inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
        psd = np.maximum(scale * spectrum.psd[inside], 1e-300)
        limits = {"xlim": (0.0, top), "ylim": (PATH_RANGE * psd.max(), 10.0 * psd.max())}
        curves(axis, spectrum.frequency[inside], (psd, BLUE), yscale="log", **limits)
    legend_above(axes[0], 5, handles=handles, **LEFT_LEGEND)
    # the path along the record
    axis, place, step = axes[-1], 1e6 * tracking.resampled(e.record.inner_y), tracking.angles[1] - tracking.angles[0]
    length = min(round(TURNS_PER_PIECE / step), place.size // FEWEST_PIECES)
    pieces = {"NFFT": length, "Fs": 1.0 / step, "noverlap": length * 7 // 8, "detrend": "mean"}
    psd, *_, image = axis.specgram(place, scale="linear", **pieces)
    most = 10.0 ** np.ceil(np.log10(max(psd.max(), 1e-30)))
    image.set_norm(LogNorm(most * ORDERS_RANGE, most))
    colour_bar(image, [axis], "path y, µm²/order", extend="min")
    for line in (name for name in ON_MAP if name in tracking.lines):
        axis.annotate(line, (0.004, tracking.lines[line]), xycoords=("axes fraction", "data"), color="white",
                      fontsize=8.5, va="center")  # fmt: skip
    axis.set_ylim(0.0, top)
    axis.grid(visible=False)
    speed = 60.0 * np.gradient(tracking.turn, tracking.time)
    low, high = text(speed.min(), 4), text(speed.max(), 4)
    return Drawing("orders", "Order spectra of the hub",
        f"Order spectra (power spectral densities) of the hub's path, and of the envelope of the {body}'s "
        f"acceleration, resampled at {tracking.angles.size} equal angles of the {over} while it turns with "
        f"{low} to {high} rpm (Δ = {text(x.path.resolution, 2)} orders). Dashed: kinematic lines by the run's own "
        "cage, which stay where they are in orders; dotted: multiples. Below, the path's y along the record: Hann "
        f"windows of {text(length * step, 3)} turns; what follows the {over} is horizontal.", figure)  # fmt: skip


def measured_figures(record: Judged, other: Judged | None, folder: Path) -> list[Drawing]:
    with rc_context(look.STYLE):
        drawn = (each(record, other) for each in (_modulation, _record, _pulse))
        return [look.save(each, folder) for each in drawn if each is not None]


def _modulation(record, other):
    found, judged = record.diagnosis, [record] if other is None else [record, other]
    by_turns, deepest, n = len(judged) > 1, 0.0, len(judged)
    x = "cycles per turn of the shaft" if by_turns else "frequency, Hz"
    figure, axes = panels(n, 1.0 + 2.2 * n, x=x, y=["modulation depth"] * n)
    for axis, each in zip(axes, judged, strict=True):
        spectrum, unit = each.diagnosis.spectrum, each.diagnosis.shaft if by_turns else 1.0
        lines = {name: line / unit for name, line in each.diagnosis.lines.items()}
        best = each.diagnosis.findings[0]
        marked = {name: lines[name] for name in MARKED if lines.get(name)} | {"2×BSF": lines["2×BSF"]}
        marked |= {line.name: line.found / unit for line in best.lines}
        top = LINES_TO * max(lines["BPFO"], lines["BPFI"], lines["2×BSF"])
        handles = mark_lines(axis, marked, 0.0, top, "" if by_turns else " Hz", of=lines)
        frequency, depth = _thinned(spectrum.frequency / unit, spectrum.depth, top)
        curves(axis, frequency, (depth, BLUE), xlim=(0.0, top))
        if best.stands_out:
            dots = [(line.found / unit, line.depth) for line in best.lines if line.found / unit <= top]
            axis.plot(*zip(*dots, strict=True), "o", color="black", markersize=3.5)
        deepest = max(deepest, depth[frequency * unit > 3.0 * spectrum.resolution].max())
        if by_turns:
            axis.text(0.99, 0.97, each.signal.name, transform=axis.transAxes, ha="right", va="top", fontsize=9.5,
                      bbox=look.BESIDE)  # fmt: skip
        if axis is axes[0]:
            legend_above(axis, 5, handles=handles, **LEFT_LEGEND)
    for axis in axes:  # both records by one scale
        axis.set_ylim(0.0, 1.15 * deepest)
    return Drawing("envelope", "Lines in the envelope",
        f"Squared envelope of the prewhitened record, Δf = {text(found.spectrum.resolution, 3)} Hz. Dashed: kinematic "
        f"lines at the speed as found; dotted: harmonics of {found.findings[0].name}, 2×BSF. Dots: lines that stand "
        "out.", figure)  # fmt: skip


def _record(own, other):
    unit, signal = own.signal.unit or "own unit", own.signal
    shared = other is None or other.signal.unit == own.signal.unit
    names = [f"amplitude, {unit}" if shared else "amplitude over rms", unit]
    figure, (upper, lower) = panels((1, 1), 6.2, x=("frequency, Hz", "time, ms"), y=names)
    for judged, colour in ((own, BLUE), (other, ORANGE)):
        if judged is not None:
            frequency, amplitude = _thinned(judged.spectrum.frequency[1:], judged.spectrum.amplitude[1:], np.inf)
            amplitude = amplitude if shared else amplitude / judged.level.rms
            style = {"linewidth": 0.7, "zorder": 3.0 if judged is own else 2.0}
            curves(upper, frequency, (amplitude, colour, judged.signal.name, style))
    upper.set(xscale="log", yscale="log")
    upper.margins(x=OF_RECORDS)
    look.without_minor_ticks(upper)
    legend_above(upper, 2)
    count = min(signal.values.size, int(PASSES_SHOWN / own.diagnosis.lines["BPFO"] * signal.rate) + 1)
    first = min(max(0, np.argmax(np.abs(signal.values)) - count // 2), signal.values.size - count)
    curves(lower, 1e3 * (first + np.arange(count)) / signal.rate, (signal.values[first:][:count], BLUE, None, 0.7))
    return Drawing("record", "Spectrum and excerpt of the record",
        f"Above: amplitude spectrum of the record. Below: {PASSES_SHOWN:g} passes of rolling elements over a point of "
        "the outer ring, about the largest value.", figure)  # fmt: skip


def _pulse(record, beside):
    """Mean power about a strike, of one record or of both; None where no line stands out."""
    own, other, part = record.pulse, None if beside is None else beside.pulse, record.diagnosis.findings[0]
    if own is None or not part.stands_out:
        return None
    figure, (axis,) = panels(1, 3.0, x="time from the highest power, ms", y=["power over its mean"])
    for pulse, judged, colour in ((own, record, BLUE), (other, beside, ORANGE)):
        if pulse is not None and judged is not None:
            curves(axis, 1e3 * pulse.time, (pulse.power, colour, judged.signal.name, 1.1))
    axis.set_ylim(bottom=0.0)
    legend_above(axis, 2)
    also = "" if other is None else f", the other for {text(1e3 * other.length, 3)} ms"
    return Drawing("pulse", "Pulse of an impact",
        f"Power of the band above {text(PASSES_IN_BAND, 2)} {part.name} (500 Hz at least), the mean over all passes "
        f"at {part.name}, set at the highest of each; smoothed over {text(100.0 * SMOOTHING, 2)} % of a pass. "
        f"It stands above half its height for {text(1e3 * own.length, 3)} ms{also}.", figure)  # fmt: skip


def trend_figure(entries: list[Entry], folder: Path) -> Drawing:
    with rc_context(look.STYLE):
        used = [(k, entry) for k, entry in enumerate(entries, 1) if entry.depths is not None]
        names = ["modulation depth", f"rms, {used[0][1].unit or 'own unit'}"]
        figure, (upper, lower) = panels(2, 4.6, x="record of the series", y=names)
        places, style = [k for k, _ in used], {"marker": "o", "markersize": 3.5, "linewidth": 1.0}
        depths = [entry.depths for _, entry in used if entry.depths is not None]
        colours = {"BPFO": RED, "BPFI": GREEN, "2×BSF": ORANGE}.items()
        rows = [([each[name] for each in depths], colour, name, style) for name, colour in colours]
        curves(upper, places, *rows, legend=3, ylim=(0.0, None))
        upper.axhline(DEEP, color=GREY, linestyle="--", linewidth=0.9)
        curves(lower, places, ([entry.rms for _, entry in used], BLUE, None, style), ylim=(0.0, None))
        upper.margins(x=OF_RECORDS)
        caption = (
            f"Above: modulation depth of each part's line, all harmonics; dashed: {DEEP:g}, the least for damage. "
            "Below: level of the record."
        )
        return look.save(Drawing("trend", "Growth over the series", caption, figure), folder)


def _thinned(x, y, top):
    x, y = x[x <= top], y[x <= top]
    each = max(1, -(-x.size // MOST_POINTS))
    if each == 1:
        return x, y
    count = x.size // each
    index = np.arange(count) * each + np.argmax(y[: count * each].reshape(count, each), axis=1)
    return x[index], y[index]
