"""Figures of the vibration of sensor, housing or hub, and of the cage."""

from pathlib import Path

import numpy as np

from lagrange.bearing import Cage
from lagrange.kinematics import OUTER_RING, kinematics, turned
from lagrange.messages import G
from residual.evaluation import Evaluation
from residual.figures.budget import middle
from residual.figures.saved import BLUE, GREEN, GREY, LINE_COLOURS, ORANGE, RED, SKY, SavedFigure, family
from residual.figures.style import legend_above, line_handles, log_panel, mark_lines, name_lines, panels, save
from residual.formatting import text
from residual.orders import SLOWEST
from residual.record import CageMotion, Record
from residual.spectrum import Spectrum
from residual.vibration import FaultLine, fault_lines

PASSAGES_SHOWN = 5.0
SPECTRUM_TO = 2.2  # times BPFI
HEADROOM = 1.05  # above the highest line
SHORTEST = 2e-3  # s, over which speeds of a cage are means


def vibration_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the spectra, and the envelopes if the record resolves their lines."""
    envelopes = [envelope_figure(evaluation, folder)] if evaluation.x.vibration.tells_lines else []
    return [acceleration_figure(evaluation, folder), *envelopes]


def acceleration_figure(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw amplitude spectra of the acceleration in both directions, in g."""
    figure, (axis,) = panels(1, 3.2, lines=1, x="frequency, Hz")
    for d, colour in zip(evaluation.directions, (SKY, BLUE), strict=True):
        spectrum = d.vibration.spectrum
        amplitude = np.maximum(spectrum.amplitude[1:] / G, np.finfo(float).tiny)
        axis.plot(spectrum.frequency[1:], amplitude, color=colour, linewidth=0.7, label=f"{d.vibration.body}, {d.name}")
    log_panel(axis, spectrum.frequency[1:])
    axis.set(ylabel="amplitude, g")
    legend_above(axis, 2)
    body = evaluation.y.vibration.body
    caption = f"Amplitude spectra, not rms, Δf = {text(spectrum.resolution, 3)} Hz."
    return save(figure, folder, f"{body}_spectrum", f"Spectra of the {body}'s acceleration", caption)


def envelope_figure(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the band of the acceleration with its envelope over a few passages, and the envelope's spectra."""
    figure, (upper, *axes) = panels((1, 2), 7.4, lines=2, shares=(0.85, 1.0, 1.0), x="frequency, Hz")
    found = [(d, d.vibration.envelope) for d in evaluation.directions if d.vibration.envelope is not None]
    loud, loudest = max(found, key=lambda each: each[0].vibration.level.rms)
    shown = middle(evaluation, PASSAGES_SHOWN)
    time = 1e3 * evaluation.record.time[shown]
    upper.plot(time, loudest.band[shown] / G, color=SKY, linewidth=0.6, label="acceleration in the band")
    upper.plot(time, loudest.level[shown] / G, color=BLUE, linewidth=0.8, label="its envelope")
    upper.margins(x=0.0)
    upper.set(xlabel="time, ms", ylabel=f"{loud.vibration.body}, {loud.name}, g")
    legend_above(upper, 2)
    top = SPECTRUM_TO * max(evaluation.lines[name] for name in ("BPFO", "BPFI"))
    slow = {name: evaluation.lines[name] for name in ("FTF", "shaft", OUTER_RING) if name in evaluation.lines}
    lines, families = slow | fault_lines(evaluation.lines), []
    for axis, (direction, envelope) in zip(axes, found, strict=True):
        families = mark_lines(axis, lines, 0.0, top)
        _draw_spectrum(axis, envelope.spectrum, direction.vibration.lines, top)
        axis.set_ylabel(f"{direction.vibration.body}, {direction.name}, g")
    handles = line_handles(families, evaluation.lines)
    legend_above(
        axes[0], 5, left=-0.06, handles=handles, handlelength=1.3, columnspacing=0.9, handletextpad=0.4, fontsize=9
    )
    body = evaluation.y.vibration.body
    caption = (
        f"Acceleration of the {loud.vibration.body} within {text(1e-3 * loudest.low, 3)} to "
        f"{text(1e-3 * loudest.high, 3)} kHz: in {loud.name} over {PASSAGES_SHOWN:g} roller "
        "passages with its envelope, and amplitude spectra of the "
        f"envelopes (Δf = {text(loudest.spectrum.resolution, 3)} Hz). Dashed: FTF, shaft, BPFO, BPFI; dotted: "
        "multiples, sidebands of BPFI by the shaft, and 2×BSF with sidebands by the cage. Dots: lines that are high "
        "above their floors, hollow where the record does not resolve them."
    )
    title = f"Envelope spectra of the {body}'s acceleration"
    return save(figure, folder, f"{body}_envelope", title, caption)


def _draw_spectrum(axis, spectrum: Spectrum, lines: list[FaultLine], top: float) -> None:
    """Draw one envelope's amplitudes and name the lines that are high above their floors."""
    inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= top)
    amplitude = spectrum.amplitude[inside] / G
    axis.plot(spectrum.frequency[inside], amplitude, color=BLUE, linewidth=1.0)
    highest, names = float(amplitude.max()), []
    for line in lines:
        if line.is_high and line.frequency <= top:
            colour = LINE_COLOURS[family(line.name)]
            sideband = "−" in line.name or "+" in line.name
            height = line.amplitude / G
            axis.plot(line.frequency, height, "o", color=colour, markersize=3.0 if sideband else 4.5,
                      markerfacecolor=colour if line.resolved else "white")  # fmt: skip
            names += [] if sideband else [(line.frequency, line.name, colour)]
            highest = max(highest, height)
    axis.set(xlim=(0.0, top), ylim=(0.0, HEADROOM * max(highest, np.finfo(float).tiny)))
    name_lines(axis, names)


def cage_figure(evaluation: Evaluation, folder: Path) -> SavedFigure | None:
    """Draw the cage's path, forces and slip; None where the run has none."""
    t, facts = evaluation.record, evaluation.record.scene.ideal_cage()
    if t.cage is None or facts is None:
        return None
    figure, (path, forces, slips) = panels((1, 2), 8.4, shares=(1.6, 1.0, 1.0))
    about = (t.inner_x, t.inner_y) if facts.guidance == "inner_ring" else (0.0, 0.0)
    _path(path, t.cage.x - about[0], t.cage.y - about[1], facts)
    time = 1e3 * t.time
    forward, backward = np.maximum(t.cage.force, 0.0), np.maximum(-t.cage.force, 0.0)
    forces.plot(time, forward.max(axis=1), color=BLUE, linewidth=0.8, label="rear wall, pushes forward")
    forces.plot(time, -backward.max(axis=1), color=RED, linewidth=0.8, label="front wall, holds back")
    guided = np.hypot(t.cage.guidance_x, t.cage.guidance_y)
    if guided.any():
        forces.plot(time, guided, color=GREEN, linewidth=0.8, label="guide")
    forces.set_ylabel("largest force, N")
    legend_above(forces, 3)
    caption = (
        "Above: path of the cage's centre about that of the bearing, or of the inner ring where that guides it; "
        "dashed: the circle that its clearance leaves. Middle: the largest force of all "
        f"pockets along the pitch circle at each time, at most {text(float(np.abs(t.cage.force).max()))} N."
    )
    if t.operation.fastest:
        caption += _slips(slips, t, t.cage)
    slips.set(xlabel="time, ms", ylabel="slip, %")
    return save(figure, folder, "cage", "The cage", caption)


def _path(axes, x, y, facts: Cage) -> None:
    play = facts.pocket_clearance if facts.guidance_clearance is None else facts.guidance_clearance
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(1e6 * x, 1e6 * y, color=BLUE, linewidth=0.7)
    axes.plot(5e5 * play * np.cos(turn), 5e5 * play * np.sin(turn), color=GREY, linewidth=0.8, linestyle="--")
    axes.set(xlabel="x, µm", ylabel="y, µm")
    axes.set_aspect("equal", adjustable="datalim")


def _slips(axes, t: Record, cage: CageMotion) -> str:
    """Slip of cage and rollers against rolling at the shaft's speed of the same time; gives the caption's sentence."""
    reach = max(1, min(round(SHORTEST / t.interval), (t.time.size - 1) // 2))
    rollers = np.unwrap(np.arctan2(t.roller_y, t.roller_x), axis=0).mean(axis=1)
    middle = 1e3 * 0.5 * (t.time[reach:] + t.time[:-reach])
    ideal = np.ravel(turned(t.bearing, t.operation, t.time).cage) + np.zeros(t.time.size)
    rolling = (ideal[reach:] - ideal[:-reach]) / (reach * t.interval)
    rolling = np.where(np.abs(rolling) >= SLOWEST * np.abs(rolling).max(), rolling, np.nan)
    for angle, colour, name in ((rollers, ORANGE, "rollers"), (cage.angle, BLUE, "cage")):
        speed = (angle[reach:] - angle[:-reach]) / (reach * t.interval)
        axes.plot(middle, 100.0 * (1.0 - speed / rolling), color=colour, linewidth=0.9, label=name)
    axes.legend(loc="upper right", ncols=2, frameon=True, framealpha=0.8, edgecolor="none")
    sentence = (
        f" Below: slip of the cage and of the rollers (their mean), {text(1e3 * reach * t.interval)} ms at a time, "
        "where the shaft turns with at least an eighth of its highest speed"
    )
    mean = kinematics(t.bearing, *t.mean_speeds).cage
    if mean == 0.0:
        return f"{sentence}; the motion reverses and has no mean slip."
    if t.orbits < 1.0:
        return f"{sentence}; the cage turns less than once and has no mean slip."
    return f"{sentence}; of the cage over the whole record {text(100.0 * (1.0 - cage.speed(t.interval) / mean), 2)} %."
