"""Figures of two checks laid over each other, and the paper's figures 4 and 6 to 11."""

from pathlib import Path

import numpy as np

from lagrange.bearing import BallBearing
from lagrange.contact.laws import Side, delta_star, raceway_curvature
from residual.evaluation import Direction, Evaluation
from residual.figures.saved import BLUE, ORANGE, RED, SavedFigure
from residual.figures.style import (
    beside_paper,
    legend_above,
    log_panel,
    mark_lines,
    name_slim,
    panels,
    panels_beside,
    save,
)
from residual.load_zone import angle_from_load, chosen_roller, load_zones, roller_radial
from residual.run_comparison import (
    ERROR_FORCE,
    INNER_X,
    INNER_Y,
    PEAK,
    ROLLER_ACCELERATION,
    ROLLER_RHO,
    ROLLER_VELOCITY,
    is_paper,
    named,
)
from residual.spectrum import power_spectrum

MOST_POINTS = 6000  # of loads over the angle


def against_figures(evaluation: Evaluation, other: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the hub's motion or, for two laws of one run, the errors; loads by angle; spectra."""
    laws = evaluation.record.source == other.record.source
    figure, axes = panels((2, 1, 2), 12.0, shares=(1.0, 1.0, 1.3, 1.0, 1.0))
    for each, name, colour, width in zip(
        (evaluation, other), named(evaluation, other), (BLUE, RED), (1.4, 0.8), strict=True
    ):
        t, style = each.record, {"color": colour, "linewidth": width, "label": name}
        for axis, d, place in zip(axes[:2], each.directions, (t.inner_x, t.inner_y), strict=True):
            axis.plot(1e3 * t.time, d.budget.error if laws else 1e6 * place, **style)
        _draw_loads(axes[2], each, style, laws)
        spectra = (
            [d.spectrum for d in each.directions]
            if laws
            else [power_spectrum(a, t.interval, min(each.lines.values(), default=0.0)) for a in each.hub_acceleration]
        )
        for axis, spectrum in zip(axes[3:], spectra, strict=True):
            log_panel(axis, spectrum.frequency[1:])
            axis.plot(spectrum.frequency[1:], np.maximum(spectrum.psd[1:], 1e-300), **style)
    of = ("error_x, N", "error_y, N") if laws else ("hub x, µm", "hub y, µm")
    for axis, label in zip((*axes[:2], *axes[3:]), (*of, *_spectra_of(laws)), strict=True):
        axis.set_ylabel(label)
        axis.margins(x=0.0)
    axes[1].set_xlabel("time, ms")
    axes[2].set(xlabel="roller's angle from the load line, degrees", ylabel="inner contact force, N")
    axes[2].set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45), ylim=(0.0, None))
    axes[4].set_xlabel("frequency, Hz")
    legend_above(axes[0], 2)
    what = "error forces" if laws else "motion of the hub"
    caption = (
        f"The {what} over time, forces of the inner contacts over the rollers' angle, and power spectral densities of "
        f"the {'error forces' if laws else 'acceleration of the hub'}, laid over each other."
    )
    return [save(figure, folder, "against", "Laid over each other", caption)]


def _spectra_of(laws: bool) -> tuple[str, str]:
    return ("PSD of error_x, N²/Hz", "PSD of error_y, N²/Hz") if laws else ("PSD, x, m²/s⁴/Hz", "PSD, y, m²/s⁴/Hz")


def _draw_loads(axis, each: Evaluation, style: dict, laws: bool) -> None:
    """Draw forces over the angle from the load line: of two laws theirs, of two runs their own."""
    force = each.budget.law_force if laws else each.force
    stride = max(1, force.size // MOST_POINTS)
    angle = np.degrees(angle_from_load(np.arctan2(each.record.roller_y, each.record.roller_x)))[::stride]
    axis.plot(angle.ravel(), force[::stride].ravel(), color=style["color"], linestyle="none", marker=".",
              markersize=2.5, rasterized=True, label=style["label"])  # fmt: skip


# The paper's figures 4 and 6 to 11, in its order and with its axes; its ranges beside runs of its bearing.


PAPER_BAND = 300.0  # Hz, the frequency axis of figures 10 and 11


def _panels(evaluation: Evaluation, n_rows: int, height: float):
    """Make a figure, its axes, and slim axes for the paper's ranges: None where the run is of another bearing."""
    if not is_paper(evaluation.record.scene):
        return *panels(n_rows, height), None
    figure, axes, slim = panels_beside(n_rows, height)
    name_slim(slim[0])
    return figure, axes, slim


def point_contact(bearing: BallBearing, folder: Path) -> SavedFigure:
    """Draw figure 4: δ* of a point contact over the curvature difference, a ball bearing's two contacts marked."""
    # close to F = 1 the curve falls steeply: as many points there as elsewhere
    difference = 1.0 - np.concatenate([np.linspace(1.0, 1e-2, 150), np.geomspace(1e-2, 1e-6, 60)[1:]])
    figure, axes = panels(1, 3.8)
    axes[0].plot(difference, delta_star(difference), color=BLUE, label="δ*(F), by elliptic integrals")
    points = []
    raceways: tuple[tuple[Side, str, str], ...] = ("inner", RED, "o"), ("outer", ORANGE, "s")
    for side, colour, mark in raceways:
        curvature = raceway_curvature(bearing, side)
        F, value = curvature.difference, delta_star(curvature.difference)
        axes[0].plot(F, value, color=colour, marker=mark, linestyle="none", markersize=7, label=f"{side} raceway")
        points.append(f"{side} raceway Σρ = {1e-3 * curvature.sum:.4g} mm⁻¹, F = {F:.4f}, δ* = {value:.4f}")
    caption = f"Dimensionless approach of a point contact, equations (4) to (8): {'; '.join(points)}."
    axes[0].set(xlabel="curvature difference F(ρ)", ylabel="δ*", xlim=(0.0, 1.0), ylim=(0.0, 1.02))
    axes[0].legend(loc="lower left")
    return save(figure, folder, "fig04", "Fig. 4: approach of a point contact", caption)


def inner_ring_motion(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw figure 6: x and y of the inner ring's centre."""
    t = evaluation.record
    figure, axes, slim = _panels(evaluation, 2, 4.6)
    for axis, name, value in ((axes[0], "x", t.inner_x), (axes[1], "y", t.inner_y)):
        axis.plot(1e3 * t.time, 1e6 * value, color=BLUE)
        axis.set_ylabel(f"{name} of the inner ring, µm")
        axis.margins(x=0.0)
    axes[-1].set_xlabel("time, ms")
    caption = "Centre of the inner ring."
    if slim is not None:
        for axis, read_off, value in zip(slim, (INNER_X, INNER_Y), (t.inner_x, t.inner_y), strict=True):
            beside_paper(axis, tuple(1e6 * np.array(read_off)), 1e6 * value)
        caption += " At the right the range of the paper's figure 6: x −80 … +60 µm, y −220 … −80 µm."
    return save(figure, folder, "fig06", "Fig. 6: motion of the inner ring", caption)


def roller_motion(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw figure 7: radial position, velocity and acceleration of one roller, load zones shaded."""
    t, order = evaluation.record, evaluation.order
    loaded = evaluation.budget.loaded
    bridge = evaluation.chatter
    j = chosen_roller(loaded, bridge)
    rho, velocity, acceleration = roller_radial(t, j, order)
    figure, axes, slim = _panels(evaluation, 3, 6.2)
    values = (rho, velocity, acceleration)
    for axis, value in zip(axes, values, strict=True):
        axis.plot(1e3 * t.time, 1e3 * value, color=BLUE)
    labels = ("ρ, mm", "dρ/dt, mm/s", "d²ρ/dt², mm/s²")
    zones = load_zones(loaded[:, j], bridge)
    for axis, label in zip(axes, labels, strict=True):
        axis.set_ylabel(label)
        axis.margins(x=0.0)
        for first, last in zones:
            axis.axvspan(1e3 * t.time[first], 1e3 * t.time[last], color=ORANGE, alpha=0.18, linewidth=0)
    span = t.time.size
    for first, last in zones:
        if last - first > 0.06 * span:
            middle = 0.5e3 * (t.time[first] + t.time[last])
            axes[0].annotate("load zone", (middle, 1.02), xycoords=("data", "axes fraction"), ha="center",
                             va="bottom", fontsize=9.5, color="#8A5A00")  # fmt: skip
    axes[-1].set_xlabel("time, ms")
    caption = (
        f"Radial position ρ of roller {j} about the outer ring's centre, its velocity and acceleration; shaded: inner "
        "contact closed (load zone)."
    )
    if slim is not None:
        ranges = (ROLLER_RHO, ROLLER_VELOCITY, ROLLER_ACCELERATION)
        for axis, read_off, value in zip(slim, ranges, values, strict=True):
            beside_paper(axis, tuple(1e3 * np.array(read_off)), 1e3 * value)
        caption += (
            " At the right the range of the paper's figure 7: ρ 22.98 … 23.08 mm, ±400 mm/s, ±5·10⁶ mm/s²; it marks "
            "the load zone twice."
        )
    return save(figure, folder, "fig07", f"Fig. 7: radial motion of roller {j}", caption)


def error_signal(evaluation: Evaluation, folder: Path, direction: Direction) -> SavedFigure:
    """Draw figure 8 or 9: the left side of (22), or of (23) with its sign flipped."""
    t, error = evaluation.record, direction.budget.error
    load, level = t.acting.radial_load, 0.0
    if direction.name == "x":
        name, number, value = "fig08", "22", error
        label, title = "left side of (22), N", "Fig. 8: error force in x"
        caption = "Left side of equation (22): 0 N for a perfect model (dashed)."
    else:
        name, number, value, level = "fig09", "23", load - error, float(np.mean(load))
        label, title = "−(left side of (23)), N", "Fig. 9: error force in y"
        caption = (
            f"Left side of equation (23) with its sign flipped: the load W = {level:g} N for a perfect model (dashed)."
        )
    figure, axes, slim = _panels(evaluation, 1, 3.4)
    if slim is not None:
        beside_paper(slim[0], (level + ERROR_FORCE[0], level + ERROR_FORCE[1]), value)
        figure_number = name.removeprefix("fig0")
        caption += f" At the right the range of the paper's figure {figure_number}: ±3000 N around {level:g} N."
    axes[0].plot(1e3 * t.time, value, color=BLUE, linewidth=0.9, label=f"equation ({number})")
    axes[0].axhline(level, color="black", linewidth=1.1, linestyle=(0, (5, 3)), label=f"perfect model: {level:g} N")
    mean = float(np.mean(value))
    axes[0].axhline(mean, color=RED, linewidth=1.1, label=f"mean: {mean:.4g} N")
    axes[0].set(xlabel="time, ms", ylabel=label)
    axes[0].margins(x=0.0)
    legend_above(axes[0], 3, columnspacing=1.5)
    return save(figure, folder, name, title, caption)


def spectrum_low(evaluation: Evaluation, folder: Path, direction: Direction) -> SavedFigure:
    """Draw figure 10 or 11: power spectral density up to 300 Hz, on linear axes."""
    spectrum, axis_name = direction.spectrum, direction.name
    name, equation = ("fig10", "22") if axis_name == "x" else ("fig11", "23")
    inside = (spectrum.frequency > 0.0) & (spectrum.frequency <= PAPER_BAND + spectrum.resolution)
    figure, axes = panels(1, 3.6, lines=2)
    axis = axes[0]
    axis.plot(spectrum.frequency[inside], spectrum.psd[inside], color=BLUE, marker="o", markersize=3.5)
    axis.set_xlim(0.0, PAPER_BAND)
    axis.set_ylim(bottom=0.0)
    axis.yaxis.get_offset_text().set_x(-0.08)  # clear of the first line's name
    mark_lines(axis, evaluation.lines, 0.0, PAPER_BAND, labels=True)
    axis.set(xlabel="frequency, Hz", ylabel=f"PSD of error_{axis_name}, N²/Hz")
    low = spectrum.resolution
    caption = (
        f"One-sided power spectral density of the error force in {axis_name}, equation ({equation}), 0-300 Hz; one dot "
        f"per frequency bin, Δf = {low:.4g} Hz, Hann window: two lines nearer than {2 * low:.3g} Hz are one peak, and "
        f"a peak below {2 * low:.3g} Hz can't be told from drift."
    )
    if is_paper(evaluation.record.scene):
        axis.axvspan(PEAK - 2.0, PEAK + 2.0, color=ORANGE, alpha=0.45, linewidth=0, zorder=0)
        caption += (
            f" Shaded: the paper's peak near {PEAK:g} Hz, of height "
            f"{'2.5·10¹⁰' if axis_name == 'x' else '1.5·10⁷'} (unit not given)."
        )
    number = name.removeprefix("fig")
    return save(figure, folder, name, f"Fig. {number}: spectrum of error_{axis_name}, 0-300 Hz", caption)


def paper_figures(evaluation: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw all of the paper's figures, in order; figure 4 is of balls."""
    bearing = evaluation.record.bearing
    drawn = [point_contact(bearing, folder)] if isinstance(bearing, BallBearing) else []
    drawn += [inner_ring_motion(evaluation, folder), roller_motion(evaluation, folder)]
    drawn += [error_signal(evaluation, folder, direction) for direction in evaluation.directions]
    return drawn + [spectrum_low(evaluation, folder, direction) for direction in evaluation.directions]
