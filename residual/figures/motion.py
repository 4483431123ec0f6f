"""Figures of loads, motion and energy, and of two checks overlaid."""

from pathlib import Path

import numpy as np

from lagrange import mounting
from lagrange.columns import ENERGIES
from lagrange.rating.sources import Unavailable
from residual.evaluation import Evaluation
from residual.figures.saved import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, SavedFigure
from residual.figures.style import COLOUR_BAR, DASHED, DOTS, colour_bar, legend_above, log_panel, panels, save
from residual.formatting import length, text
from residual.load_zone import QuasiStatic, chosen_roller, load_zones
from residual.record import angle_from_load
from residual.spectrum import power_spectrum
from residual.tables import named
from residual.tilt import along_rollers

MOST_POINTS = 20_000  # of a scatter plot: more hide each other
MOST_COMPARED = 6000  # the same of two
LAWS = ("error_x, N", "error_y, N", "PSD of error_x, N²/Hz", "PSD of error_y, N²/Hz")
RUNS = ("hub x, µm", "hub y, µm", "PSD, x, m²/s⁴/Hz", "PSD, y, m²/s⁴/Hz")
SHORT_ROW, LONG_ROW = 6, -0.13  # entries of a legend as wide as its axis; where a longer one begins
SMALLEST_TURN = 1e-3  # of a revolution: less is a standing bearing
FROM_LOAD = "roller's angle from the load line, degrees"
SHARP_STATED = (
    "Loaded ends of these profiles have an edge, where pressure has no limit: values there are averages over a slice."
)
ENERGY_CURVES = {
    "energy_kinetic": ("kinetic", BLUE),
    "energy_elastic": ("elastic", RED),
    "energy_contact": ("contact", PURPLE),
    "energy_support": ("support", SKY),
    "energy_shaft": ("shaft", ORANGE),
    "work_external": ("external work", GREEN),
    "work_dissipated": ("dissipated", GREY),
}


def orbit_figure(evaluation: Evaluation, statics: QuasiStatic | None, folder: Path) -> SavedFigure:
    """Draw the hub's path and that of the Lagrangian model's equilibria, each about its own middle."""
    t = evaluation.record
    figure, (axes,) = panels(1, 4.6, x="x without mean, µm", y=["y without mean, µm"])
    middle = 1e6 * np.array([t.inner_x.mean(), t.inner_y.mean()])
    axes.plot(1e6 * t.inner_x - middle[0], 1e6 * t.inner_y - middle[1], color=BLUE, linewidth=0.6, alpha=0.8,
              label="run")  # fmt: skip
    mean = f"x = {length(1e-6 * middle[0])}, y = {length(1e-6 * middle[1])}"
    caption = f"Path of the inner ring's centre about its mean, {mean}."
    if statics is not None:
        standing = 1e6 * np.array([statics.x[:-1].mean(), statics.y[:-1].mean()])
        axes.plot(1e6 * statics.x - standing[0], 1e6 * statics.y - standing[1], color=ORANGE, linewidth=2.0,
                  label=f"Lagrangian statics, {statics.law}")  # fmt: skip
        caption += (
            f" Thick: the equilibria of the Lagrangian model (rigid rings, law {statics.law}) over one roller passage, "
            f"about theirs, x = {length(1e-6 * standing[0])}, y = {length(1e-6 * standing[1])}."
        )
    axes.set_aspect("equal", adjustable="datalim")
    legend_above(axes, 2)
    return save(figure, folder, "orbit", "Orbit of the inner ring", caption)


def load_distribution(evaluation: Evaluation, statics: QuasiStatic | None, folder: Path) -> SavedFigure:
    """Draw the inner contact force around the bearing in polar coordinates, the load downwards."""
    force = evaluation.force
    stride = max(1, force.size // MOST_POINTS)
    figure, (axes,) = panels(1, 5.2, projection="polar")
    axes.set_theta_zero_location("S")
    angle = evaluation.record.from_load[::stride]
    has_forces = evaluation.record.inner_force is not None
    name = "run" if has_forces else f"law {evaluation.law.name}, approaches of the run"
    axes.plot(angle.ravel(), force[::stride].ravel(), color=BLUE, label=name, **DOTS)
    caption = "Force of the inner raceway on the rollers over their angle from the load line, all rollers and times"
    if statics is not None:
        axes.plot(statics.angle, statics.force, color=ORANGE, linewidth=1.8, label=f"Lagrangian statics, {statics.law}")
        most, static = float(force.max()), float(statics.force.max())
        caption += (
            f"; line: the static equilibria of the Lagrangian model. Largest: {text(most)} N in the run, "
            f"{text(static)} N in the statics"
        )
    axes.set_ylim(bottom=0.0)
    axes.set_rlabel_position(112.5)
    axes.annotate("N", (0.5, 0.5), xycoords="axes fraction", fontsize=9, color=GREY, xytext=(-14, 6),
                  textcoords="offset points")  # fmt: skip
    axes.set_thetagrids(np.arange(0, 360, 45), [f"{a}°" for a in ("0", "45", "90", "135", "180", "−135", "−90", "−45")])
    axes.legend(loc="lower left", bbox_to_anchor=(-0.35, -0.02), markerscale=5)
    return save(figure, folder, "load_distribution", "Load distribution", caption + ".")


def roller_loads(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the law's and the run's inner contact forces over the roller's angle from the load line."""
    own, budget, contacts = evaluation.record.inner_force, evaluation.budget, evaluation.budget.contacts
    rows = slice(None, None, max(1, budget.law_force.size // MOST_POINTS))
    angle = np.degrees(angle_from_load(np.arctan2(-contacts.direction_y[rows], -contacts.direction_x[rows])))
    figure, axes = panels(
        1 if own is None else 2, 3.8 if own is None else 5.6, x=FROM_LOAD, y=["inner contact force, N"]
    )
    axis = axes[0]
    axis.plot(angle.ravel(), budget.law_force[rows].ravel(), color=RED, label=f"law: {evaluation.law.name}", **DOTS)
    caption = (
        "Contact force between the inner ring and each roller, all rollers and times, over the roller's angle from "
        "the load line (counter-clockwise)."
    )
    if own is not None:
        axis.plot(angle.ravel(), own[rows].ravel(), color=BLUE, label="run's own contact force", **DOTS)
        closed = budget.loaded[rows]
        axes[1].plot(angle[closed], (own - budget.law_force)[rows][closed], color=PURPLE, **DOTS)
        axes[1].set_ylabel("run − law, closed contacts, N")
        caption += " Below: run minus law, closed contacts."
    axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45), ylim=(0.0, None))
    axis.legend(loc="upper left", markerscale=5)
    return save(figure, folder, "loads", "Loads of the rollers", caption)


def tilt_figure(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw tilts of rollers and moments of their contacts over the roller's angle from the load line."""
    t = evaluation.record
    rows = slice(None, None, max(1, t.from_load.size // MOST_POINTS))
    angle = np.degrees(t.from_load[rows]).ravel()
    figure, axes = panels(2, 5.0, x=FROM_LOAD, y=["tilt, mrad", "moment of a contact, N m"])
    axes[0].plot(angle, 1e3 * np.asarray(t.roller_tilt)[rows].ravel(), color=BLUE, label="tilt", **DOTS)
    for name, moment, colour in (("inner", t.inner_moment, BLUE), ("outer", t.outer_moment, ORANGE)):
        axes[1].plot(angle, np.asarray(moment)[rows].ravel(), color=colour, label=f"{name} raceway", **DOTS)
    axes[1].set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45))
    axes[1].legend(loc="upper left", markerscale=5)
    slope = [1e3 * float(np.asarray(each).mean()) for each in (t.inner_slope_x, t.inner_slope_y)]
    caption = (
        f"Tilt of each roller (its +z end outwards is positive) and the moments of its contacts, all rollers "
        "and times; they differ by the roller's inertia alone. "
        f"Mean slope of the shaft: {text(slope[0])} mrad in x, {text(slope[1])} mrad in y."
    )
    return save(figure, folder, "tilt", "Tilt and moments of the rollers", caption)


def pressure_figure(evaluation: Evaluation, folder: Path) -> SavedFigure | None:
    """Draw pressures over both raceways and along the most loaded rollers; None where the source has none."""
    try:
        found = along_rollers(evaluation.record)
    except Unavailable:  # said among the ratings
        return None
    if found is None:
        return None
    figure, axes = panels((2, 1), 6.8, lines=0, shares=(1.0, 1.0, 1.6), right=COLOUR_BAR)
    z, angle = 1e3 * found.place, np.degrees(found.angle)
    ends = np.append(z - 0.5 * (z[1] - z[0]), -z[0] + 0.5 * (z[1] - z[0]))  # of slices
    shown = np.ma.masked_equal(1e-6 * found.around, 0.0)
    for axis, side, pressure in zip(axes, ("inner", "outer"), shown, strict=False):
        image = axis.pcolormesh(angle, z, pressure.T, vmin=0.0, vmax=float(shown.max()), cmap="viridis",
                                shading="nearest", rasterized=True)  # fmt: skip
        axis.set(ylabel=f"{side}: z, mm", xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45))
        axis.grid(visible=False)
    axes[1].set_xlabel(FROM_LOAD)
    colour_bar(image, axes[:2], "pressure, MPa")
    for j, colour, inner, outer in zip(found.rollers, (BLUE, ORANGE, GREEN), *found.along, strict=False):
        for pressure, line, label in ((inner, "-", f"roller {j}"), (outer, DASHED, None)):
            axes[2].step(ends, 1e-6 * np.append(pressure, pressure[-1]), where="post", color=colour, linestyle=line,
                         label=label)  # fmt: skip
    axes[2].plot([], [], color=GREY, linestyle=DASHED, label="outer")
    axes[2].set(xlabel="along the axis z, mm", ylabel="pressure, MPa", ylim=(0.0, None), xlim=(ends[0], ends[-1]))
    axes[2].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.0, handletextpad=0.5)
    peak = [text(1e-6 * float(each.max())) for each in found.around]
    caption = (
        "Pressure on both raceways, unrolled: at every angle the contact with the largest force. Below: pressure along "
        f"the most loaded rollers at {text(1e3 * found.time)} ms, when a contact has the largest moment, by slices. "
    )
    caption += SHARP_STATED if found.edges else f"Largest: {peak[0]} MPa (inner raceway), {peak[1]} MPa (outer)."
    return save(figure, folder, "pressure", "Pressure along the rollers", caption)


def energy_balance(evaluation: Evaluation, folder: Path) -> SavedFigure:
    """Draw the changes of energies and works since the first sample, and what does not add up."""
    t = evaluation.record
    figure, axes = panels(2, 4.8, x="time, ms", y=["change, mJ", "imbalance, µJ"])
    shown = {key: style for key, style in ENERGY_CURVES.items() if key in t.energies}
    for key, (label, colour) in shown.items():
        axes[0].plot(1e3 * t.time, 1e3 * (t.energies[key] - t.energies[key][0]), label=label, color=colour)
    left = 0.0 if len(shown) <= SHORT_ROW else LONG_ROW
    legend_above(axes[0], len(shown), left, columnspacing=0.9, handlelength=1.1)
    imbalance = energy_imbalance(t.energies)
    scale = float(np.mean(t.energies["energy_elastic"] + t.energies["energy_contact"]))
    scale += float(np.ptp(t.energies["work_dissipated"]))  # an imbalance accumulates, as this does
    axes[1].plot(1e3 * t.time, 1e6 * imbalance, color="black")
    share = (
        f"; at most {text(100.0 * float(np.abs(imbalance).max()) / scale, 2)} % of the mean strain energy and "
        "the dissipated energy together"
        if scale > 0.0
        else ""
    )
    caption = (
        "Energies and works since the first sample shown. Imbalance: all energies − external work + dissipated, as "
        f"changes{share}."
    )
    return save(figure, folder, "energy", "Energy balance of the run", caption)


def energy_imbalance(energies) -> np.ndarray:
    """Change of the energies minus external work plus dissipation since the first sample, J, (n_times,)."""
    total = energies["energy_kinetic"] + energies["energy_elastic"] + energies["energy_contact"]
    total = total + sum(energies[name] for name in mounting.ENERGIES if name in energies)
    total = total - energies["work_external"] + energies["work_dissipated"]
    return total - total[0]


def passage_figure(evaluation: Evaluation, folder: Path) -> SavedFigure | None:
    """Draw the forces on one roller through the load zone; None where it never passes or the source holds no forces."""
    t, budget = evaluation.record, evaluation.budget
    j = chosen_roller(budget.loaded, evaluation.chatter)
    zones = load_zones(budget.loaded[:, j], evaluation.chatter)
    angle = np.degrees(np.unwrap(t.from_load[:, j]))
    if not zones or t.inner_force is None or np.ptp(angle) < 360.0 * SMALLEST_TURN:
        return None
    first, last = max(zones, key=lambda zone: zone[1] - zone[0])
    margin = (last - first) // 12
    shown = slice(max(0, first - margin), last + margin + 1)
    place = angle[shown] - 360.0 * np.round(angle[(first + last) // 2] / 360.0)
    tractions = [each for each in (t.inner_traction, t.outer_traction) if each is not None]
    tangential = len(tractions) == 2
    names = ["normal force, N", "traction on the roller, N"]
    figure, axes = panels(2 if tangential else 1, 5.2 if tangential else 3.4, x=FROM_LOAD, y=names)
    axes[0].plot(place, t.inner_force[shown, j], color=BLUE, label="inner raceway")
    if t.outer_force is not None:
        axes[0].plot(place, t.outer_force[shown, j], color=RED, linestyle=(0, (5, 2)), label="outer raceway")
    law = f"law {evaluation.law.name}, inner"
    axes[0].plot(place, budget.law_force[shown, j], color=GREY, linewidth=0.9, label=law)
    axes[0].set_ylim(bottom=0.0)
    legend_above(axes[0], 3)
    caption = (
        f"Roller {j} on its way through the load zone, {text(1e3 * t.time[first])} to {text(1e3 * t.time[last])} ms: "
        "normal forces of both raceways (the outer one also carries the centrifugal force) and the force by the law "
        "for the same approach"
    )
    if tangential:
        for traction, colour, name in zip(tractions, (BLUE, RED), ("inner", "outer"), strict=True):
            axes[1].plot(place, traction[shown, j], color=colour, linewidth=0.9, label=name)
        caption += "; below: tractions, positive counter-clockwise"
    axes[-1].margins(x=0.0)
    return save(figure, folder, "passage", f"Roller {j} through the load zone", caption + ".")


def history_figure(evaluation: Evaluation, equations: bool, folder: Path) -> SavedFigure:
    """Draw the hub's place, one roller's radial place, and the error forces over time."""
    t, loaded = evaluation.record, evaluation.budget.loaded
    j = chosen_roller(loaded, evaluation.chatter)
    curves = {"hub x, µm": 1e6 * t.inner_x, "hub y, µm": 1e6 * t.inner_y}
    rho = np.hypot(t.roller_x[:, j], t.roller_y[:, j]) - t.bearing.pitch_radius
    curves[f"ρ of roller {j}, µm"] = 1e6 * rho
    if equations:
        curves |= {f"error_{d.name}, N": d.budget.error for d in evaluation.directions}
    time, count = 1e3 * t.time, len(curves)
    figure, axes = panels(count, 1.0 + 1.4 * count, lines=0, x="time, ms", y=list(curves))
    for axis, values in zip(axes, curves.values(), strict=True):
        axis.plot(time, values, color=BLUE, linewidth=0.9)
    for first, last in load_zones(loaded[:, j], evaluation.chatter):
        axes[2].axvspan(time[first], time[last], color=ORANGE, alpha=0.18, linewidth=0)
    errors = "; error forces, 0 for a perfect model" if equations else ""
    caption = (
        f"Centre of the inner ring; radial place ρ of roller {j} beyond the pitch radius, shaded where its inner "
        f"contact is closed (load zone){errors}."
    )
    return save(figure, folder, "history", "Motion over time", caption)


def against_figures(evaluation: Evaluation, other: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the hub's motion or, for two laws of one run, the errors; loads by angle; spectra."""
    laws = evaluation.record.source == other.record.source
    figure, axes = panels((2, 1, 2), 12.0, shares=(1.0, 1.0, 1.3, 1.0, 1.0), x="frequency, Hz")
    curves = [*axes[:2], *axes[3:]]
    for each, name, colour, width in zip(
        (evaluation, other), named(evaluation, other), (BLUE, RED), (1.4, 0.8), strict=True
    ):
        t, style = each.record, {"color": colour, "linewidth": width, "label": name}
        for axis, d, place in zip(axes[:2], each.directions, (t.inner_x, t.inner_y), strict=True):
            axis.plot(1e3 * t.time, d.budget.error if laws else 1e6 * place, **style)
        force = each.budget.law_force if laws else each.force  # of two laws theirs, of two runs their own
        rows = slice(None, None, max(1, force.size // MOST_COMPARED))
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
        f"the {of}, overlaid."
    )
    return [save(figure, folder, "against", "Comparison", caption)]


def motion_figures(
    evaluation: Evaluation, equations: bool, statics: QuasiStatic | None, folder: Path
) -> list[SavedFigure]:
    """Draw those figures that the run has the data for."""
    drawn = [history_figure(evaluation, equations, folder), orbit_figure(evaluation, statics, folder)]
    drawn.append(load_distribution(evaluation, statics, folder))
    passage = passage_figure(evaluation, folder)
    drawn += [] if passage is None else [passage]
    drawn.append(roller_loads(evaluation, folder))
    if evaluation.tilt is not None:
        drawn += filter(None, [tilt_figure(evaluation, folder), pressure_figure(evaluation, folder)])
    if set(ENERGIES) <= set(evaluation.record.energies):
        drawn.append(energy_balance(evaluation, folder))
    return drawn
