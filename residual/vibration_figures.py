"""Figure of the vibration of sensor, housing or hub: a few roller passages, and the spectrum of the envelope."""

from pathlib import Path

import numpy as np

from residual.colours import BLUE, LINE_COLOURS, SKY, family
from residual.envelope import Envelope
from residual.evaluation import Evaluation
from residual.figures import SavedFigure
from residual.panels import panels
from residual.plotting import legend_above, line_handles, mark_lines, save
from residual.spectrum import Spectrum
from residual.vibration import FaultLine, fault_lines
from residual.vibration_tables import whose
from residual.words import text

PASSAGES_SHOWN = 5.0
SPECTRUM_TO = 2.2  # times BPFI
BESIDE = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}  # keeps a name legible
HEADROOM = 1.22  # above the highest line, for its name


def vibration_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the figure, if the record tells lines of envelopes."""
    envelopes = [d.vibration.envelope for d in evaluation.directions if d.vibration.envelope is not None]
    return [envelope_figure(evaluation, envelopes, folder)] if evaluation.x.vibration.tells_lines else []


def envelope_figure(evaluation: Evaluation, envelopes: list[Envelope], folder: Path) -> SavedFigure:
    """Draw the band of the acceleration with its envelope over a few passages, and the envelope's spectra."""
    figure, (upper, *axes) = panels((1, 2), 7.4, lines=2, shares=(0.85, 1.0, 1.0))
    found = list(zip(evaluation.directions, envelopes, strict=True))
    loud, loudest = max(found, key=lambda each: each[0].vibration.rms)
    _draw_passages(upper, evaluation, f"{loud.vibration.body}, {loud.name}", loudest)
    top = SPECTRUM_TO * evaluation.lines["BPFI"]
    slow = {name: evaluation.lines[name] for name in ("FTF", "shaft")}
    lines, families = slow | fault_lines(evaluation.lines), []
    for axis, (direction, envelope) in zip(axes, found, strict=True):
        families = mark_lines(axis, lines, 0.0, top, labels=False)
        _draw_spectrum(axis, envelope.spectrum, direction.vibration.lines, top)
        axis.set_ylabel(f"{direction.vibration.body}, {direction.name}, m/s²")
    handles = line_handles(families, evaluation.lines)
    legend_above(
        axes[0], 5, left=-0.06, handles=handles, handlelength=1.3, columnspacing=0.9, handletextpad=0.4, fontsize=9
    )
    axes[1].set_xlabel("frequency, Hz")
    body = whose(evaluation)
    caption = (
        f"Acceleration of the {loud.vibration.body} within {text(1e-3 * loudest.low, 3)} to "
        f"{text(1e-3 * loudest.high, 3)} kHz: in {loud.name} over {PASSAGES_SHOWN:g} roller "
        "passages with its envelope, and amplitude spectra of the "
        f"envelopes (Δf = {text(loudest.spectrum.resolution, 3)} Hz). Dashed: FTF, shaft, BPFO, BPFI; dotted: "
        "multiples, sidebands of BPFI by the shaft, and 2×BSF with sidebands by the cage. Dots: lines that stand out, "
        "as in the table."
    )
    title = f"Envelope spectra of the {body}'s acceleration"
    return save(figure, folder, f"{body}_envelope", title, caption)


def _draw_passages(axis, evaluation: Evaluation, name: str, found: Envelope) -> None:
    """Draw the band and its envelope over some passages in the record's middle."""
    time = evaluation.record.time
    count = min(time.size, int(PASSAGES_SHOWN / evaluation.lines["BPFO"] / evaluation.record.interval) + 1)
    first = (time.size - count) // 2
    shown = slice(first, first + count)
    axis.plot(1e3 * time[shown], found.band[shown], color=SKY, linewidth=0.6, label="acceleration in the band")
    axis.plot(1e3 * time[shown], found.level[shown], color=BLUE, linewidth=0.8, label="its envelope")
    axis.margins(x=0.0)
    axis.set(xlabel="time, ms", ylabel=f"{name}, m/s²")
    legend_above(axis, 2)


def _draw_spectrum(axis, spectrum: Spectrum, lines: list[FaultLine], top: float) -> None:
    """Draw one envelope's amplitudes and name the lines that stand out of them."""
    inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
    amplitude = spectrum.amplitude[inside]
    axis.plot(spectrum.frequency[inside], amplitude, color=BLUE, linewidth=1.0)
    highest = float(amplitude.max())
    for line in lines:
        if line.stands_out and line.frequency <= top:
            colour = LINE_COLOURS[family(line.name)]
            sideband = "−" in line.name or "+" in line.name
            axis.plot(line.frequency, line.amplitude, "o", color=colour, markersize=3.0 if sideband else 4.5)
            if not sideband:
                axis.annotate(line.name, (line.frequency, line.amplitude), xytext=(0, 6), textcoords="offset points",
                              fontsize=9.5, color=colour, ha="center", bbox=BESIDE)  # fmt: skip
            highest = max(highest, line.amplitude)
    axis.set(xlim=(0.0, top), ylim=(0.0, HEADROOM * max(highest, np.finfo(float).tiny)))
