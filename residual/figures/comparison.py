"""Figures of two checks laid over each other, and the paper's figures 4 and 6 to 11."""

from pathlib import Path

import numpy as np

from lagrange.bearing import BallBearing
from lagrange.contact.laws import Side, delta_star, raceway_curvature
from residual import run_comparison as paper
from residual.evaluation import Direction, Evaluation
from residual.figures.saved import BLUE, ORANGE, RED, SavedFigure
from residual.figures.style import DOTS, beside_paper, legend_above, log_panel, mark_lines, panels, panels_beside, save
from residual.load_zone import chosen_roller, load_zones, roller_radial
from residual.spectrum import power_spectrum
from residual.tables import load_words

MOST_POINTS = 6000  # of loads over the angle
LAWS = ("error_x, N", "error_y, N", "PSD of error_x, N²/Hz", "PSD of error_y, N²/Hz")
RUNS = ("hub x, µm", "hub y, µm", "PSD, x, m²/s⁴/Hz", "PSD, y, m²/s⁴/Hz")


def against_figures(evaluation: Evaluation, other: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the hub's motion or, for two laws of one run, the errors; loads by angle; spectra."""
    laws = evaluation.record.source == other.record.source
    figure, axes = panels((2, 1, 2), 12.0, shares=(1.0, 1.0, 1.3, 1.0, 1.0), x="frequency, Hz")
    curves = [*axes[:2], *axes[3:]]
    for each, name, colour, width in zip(
        (evaluation, other), paper.named(evaluation, other), (BLUE, RED), (1.4, 0.8), strict=True
    ):
        t, style = each.record, {"color": colour, "linewidth": width, "label": name}
        for axis, d, place in zip(axes[:2], each.directions, (t.inner_x, t.inner_y), strict=True):
            axis.plot(1e3 * t.time, d.budget.error if laws else 1e6 * place, **style)
        force = each.budget.law_force if laws else each.force  # of two laws theirs, of two runs their own
        rows = slice(None, None, max(1, force.size // MOST_POINTS))
        axes[2].plot(np.degrees(t.from_load)[rows].ravel(), force[rows].ravel(), color=colour, label=name, **DOTS)
        slowest = min(each.lines.values(), default=0.0)
        spectra = (
            [d.spectrum for d in each.directions]
            if laws
            else [power_spectrum(a, t.interval, slowest) for a in each.hub_acceleration]
        )
        for axis, spectrum in zip(axes[3:], spectra, strict=True):
            log_panel(axis, spectrum.frequency[1:])
            axis.plot(spectrum.frequency[1:], np.maximum(spectrum.psd[1:], 1e-300), **style)
    for axis, label in zip(curves, LAWS if laws else RUNS, strict=True):
        axis.set_ylabel(label)
        axis.margins(x=0.0)
    axes[1].set_xlabel("time, ms")
    axes[2].set(xlabel="roller's angle from the load line, degrees", ylabel="inner contact force, N")
    axes[2].set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45), ylim=(0.0, None))
    legend_above(axes[0], 2)
    what, of = ("error forces", "error forces") if laws else ("motion of the hub", "acceleration of the hub")
    caption = (
        f"The {what} over time, forces of the inner contacts over the rollers' angle, and power spectral densities of "
        f"the {of}, laid over each other."
    )
    return [save(figure, folder, "against", "Laid over each other", caption)]


def point_contact(bearing: BallBearing, folder: Path) -> SavedFigure:
    """Draw figure 4: δ* of a point contact over the curvature difference, a ball bearing's two contacts marked."""
    # close to F = 1 the curve falls steeply: as many points there as elsewhere
    difference = 1.0 - np.concatenate([np.linspace(1.0, 1e-2, 150), np.geomspace(1e-2, 1e-6, 60)[1:]])
    figure, (axes,) = panels(1, 3.8, x="curvature difference F(ρ)", y=["δ*"])
    axes.plot(difference, delta_star(difference), color=BLUE, label="δ*(F), by elliptic integrals")
    points = []
    raceways: tuple[tuple[Side, str, str], ...] = ("inner", RED, "o"), ("outer", ORANGE, "s")
    for side, colour, mark in raceways:
        curvature = raceway_curvature(bearing, side)
        F, value = curvature.difference, delta_star(curvature.difference)
        axes.plot(F, value, color=colour, marker=mark, linestyle="none", markersize=7, label=f"{side} raceway")
        points.append(f"{side} raceway Σρ = {1e-3 * curvature.sum:.4g} mm⁻¹, F = {F:.4f}, δ* = {value:.4f}")
    caption = f"Dimensionless approach of a point contact, equations (4) to (8): {'; '.join(points)}."
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.02))
    axes.legend(loc="lower left")
    return save(figure, folder, "fig04", "Fig. 4: approach of a point contact", caption)


def _over_time(evaluation: Evaluation, height: float, names, values, ranges):
    """Draw quantities over time, each with the paper's range at its right where the run is of its bearing."""
    make = panels_beside if paper.is_paper(evaluation.record.scene) else panels
    figure, axes, *slim = make(len(values), height, x="time, ms", y=names)
    for k, value in enumerate(values):
        axes[k].plot(1e3 * evaluation.record.time, value, color=BLUE, linewidth=0.9 if len(values) == 1 else None)
        if slim:
            beside_paper(slim[0][k], ranges[k], value)
    return figure, axes, bool(slim)


def inner_ring_motion(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw figure 6: x and y of the inner ring's centre."""
    t = evaluation.record
    names = [f"{name} of the inner ring, µm" for name in "xy"]
    ranges = [tuple(1e6 * np.array(read_off)) for read_off in (paper.INNER_X, paper.INNER_Y)]
    figure, _, is_paper = _over_time(evaluation, 4.6, names, (1e6 * t.inner_x, 1e6 * t.inner_y), ranges)
    caption = "Centre of the inner ring."
    if is_paper:
        caption += " At the right the range of the paper's figure 6: x −80 … +60 µm, y −220 … −80 µm."
    return save(figure, folder, "fig06", "Fig. 6: motion of the inner ring", caption)


def roller_motion(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw figure 7: radial position, velocity and acceleration of one roller, load zones shaded."""
    time, loaded = 1e3 * evaluation.record.time, evaluation.budget.loaded
    j = chosen_roller(loaded, evaluation.chatter)
    values = [1e3 * value for value in roller_radial(evaluation.record, j, evaluation.order)]
    ranges = [
        tuple(1e3 * np.array(each)) for each in (paper.ROLLER_RHO, paper.ROLLER_VELOCITY, paper.ROLLER_ACCELERATION)
    ]
    names = ("ρ, mm", "dρ/dt, mm/s", "d²ρ/dt², mm/s²")
    figure, axes, is_paper = _over_time(evaluation, 6.2, names, values, ranges)
    for first, last in load_zones(loaded[:, j], evaluation.chatter):
        for axis in axes:
            axis.axvspan(time[first], time[last], color=ORANGE, alpha=0.18, linewidth=0)
        if last - first > 0.06 * time.size:
            middle = 0.5 * (time[first] + time[last])
            axes[0].annotate("load zone", (middle, 1.02), xycoords=("data", "axes fraction"), ha="center",
                             va="bottom", fontsize=9.5, color="#8A5A00")  # fmt: skip
    caption = (
        f"Radial position ρ of roller {j} about the outer ring's centre, its velocity and acceleration; shaded: inner "
        "contact closed (load zone)."
    )
    if is_paper:
        caption += (
            " At the right the range of the paper's figure 7: ρ 22.98 … 23.08 mm, ±400 mm/s, ±5·10⁶ mm/s²; it marks "
            "the load zone twice."
        )
    return save(figure, folder, "fig07", f"Fig. 7: radial motion of roller {j}", caption)


def error_signal(evaluation: Evaluation, folder: Path, direction: Direction) -> SavedFigure:
    """Draw figure 8 or 9: the left side of (22), or of (23) with its sign flipped."""
    value, load = direction.budget.error, evaluation.record.acting.radial_load
    number, equation, level, label = 8, "22", 0.0, "left side of (22), N"
    caption = "Left side of equation (22): 0 N for a perfect model (dashed)."
    if direction.name == "y":
        number, equation, level, label = 9, "23", float(np.mean(load)), "−(left side of (23)), N"
        value = load - value
        caption = (
            "Left side of equation (23) with its sign flipped: for a perfect model the load W, "
            f"{load_words(evaluation.record.bearing, level)} (dashed)."
        )
    around = (level + paper.ERROR_FORCE[0], level + paper.ERROR_FORCE[1])
    figure, (axis,), is_paper = _over_time(evaluation, 3.4, [label], [value], [around])
    if is_paper:
        caption += f" At the right the range of the paper's figure {number}: ±3000 N around {level:g} N."
    mean = float(np.mean(value))
    axis.lines[0].set_label(f"equation ({equation})")
    axis.axhline(level, color="black", linewidth=1.1, linestyle=(0, (5, 3)), label=f"perfect model: {level:g} N")
    axis.axhline(mean, color=RED, linewidth=1.1, label=f"mean: {mean:.4g} N")
    legend_above(axis, 3, columnspacing=1.5)
    return save(figure, folder, f"fig{number:02}", f"Fig. {number}: error force in {direction.name}", caption)


def spectrum_low(evaluation: Evaluation, folder: Path, direction: Direction) -> SavedFigure:
    """Draw figure 10 or 11: power spectral density up to 300 Hz, on linear axes."""
    spectrum, name, step = direction.spectrum, direction.name, direction.spectrum.resolution
    number, equation, height = (10, "22", "2.5·10¹⁰") if name == "x" else (11, "23", "1.5·10⁷")
    inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= paper.PAPER_BAND + step)
    figure, (axis,) = panels(1, 3.6, lines=2, x="frequency, Hz", y=[f"PSD of error_{name}, N²/Hz"])
    axis.plot(spectrum.frequency[inside], spectrum.psd[inside], color=BLUE, marker="o", markersize=3.5)
    axis.set_xlim(0.0, paper.PAPER_BAND)
    seen = float(spectrum.psd[inside & (spectrum.frequency <= paper.PAPER_BAND)].max(initial=0.0))
    axis.set_ylim(0.0, 1.1 * seen or None)  # a line just beyond the band would flatten what is in it
    axis.yaxis.get_offset_text().set_x(-0.08)  # clear of the first line's name
    mark_lines(axis, evaluation.lines, 0.0, paper.PAPER_BAND, labels=True)
    caption = (
        f"One-sided power spectral density of the error force in {name}, equation ({equation}), 0-300 Hz; one dot "
        f"per frequency bin, Δf = {step:.4g} Hz, Hann window: two lines nearer than {2 * step:.3g} Hz are one peak, "
        f"and a peak below {2 * step:.3g} Hz can't be distinguished from drift."
    )
    if paper.is_paper(evaluation.record.scene):
        axis.axvspan(paper.PEAK - 2.0, paper.PEAK + 2.0, color=ORANGE, alpha=0.45, linewidth=0, zorder=0)
        caption += f" Shaded: the paper's peak near {paper.PEAK:g} Hz, of height {height} (unit not given)."
    return save(figure, folder, f"fig{number}", f"Fig. {number}: spectrum of error_{name}, 0-300 Hz", caption)


def paper_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw all of the paper's figures, in order; figure 4 is of balls."""
    bearing = evaluation.record.bearing
    drawn = [point_contact(bearing, folder)] if isinstance(bearing, BallBearing) else []
    drawn += [inner_ring_motion(evaluation, folder), roller_motion(evaluation, folder)]
    drawn += [error_signal(evaluation, folder, direction) for direction in evaluation.directions]
    return drawn + [spectrum_low(evaluation, folder, direction) for direction in evaluation.directions]
