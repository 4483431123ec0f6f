"""Figures of a run: motion, loads, pressures, energy, cage, passages over spalls, and two checks overlaid."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from lagrange import mounting
from lagrange.columns import ENERGIES
from lagrange.kinematics import kinematics, turned
from lagrange.surface.passages import Passage, find_passages, spall_events, spalls
from residual import figures as look
from residual.evaluation import Evaluation
from residual.fault_finding import FaultSearch, Near
from residual.figures import DASHED, FROM_LOAD, SCALE, Drawing, colour_bar, curves, legend_above, panels, spectra
from residual.findings import body_name, named, reported_angle
from residual.formatting import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, length, text
from residual.load_zone import along_rollers, chosen_roller, load_zones
from residual.record import angle_from_load
from residual.spectrum import power_spectrum
from residual.vibration import SLOWEST

MOST_POINTS, MOST_COMPARED = 20_000, 6000  # of a scatter plot, of one of two runs: more hide each other
DOTS: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 2.5, "rasterized": True}
SHORT_ROW, LONG_ROW = 6, -0.13  # entries of a legend as wide as its axis; where a longer one begins
SMALLEST_TURN = 1e-3  # of a revolution: less is a standing bearing
SHORTEST = 2e-3  # s, over which speeds of a cage are means
MOST_SPALLS, MOST_PASSAGES = 3, 150  # figures, of those struck hardest; passages in one: more hide each other
MEAN_POINTS, SHOWN = 401, 2.6  # half-widths on either side of the middle
OF_PATHS = 0.05  # of a path's width, on either side
BESIDE_SPALL = 0.4e-3  # m, shown on either side of a spall found
SHARP = "Loaded ends of these profiles have an edge, where pressure has no limit: values there are means over a slice."
ENERGY_CURVES = {
    "energy_kinetic": ("kinetic", BLUE), "energy_elastic": ("elastic", RED), "energy_contact": ("contact", PURPLE),
    "energy_support": ("support", SKY), "energy_shaft": ("shaft", ORANGE), "work_external": ("external work", GREEN),
    "work_dissipated": ("dissipated", GREY)}  # fmt: skip


def draw_figures(
    e: Evaluation, folder: Path, other: Evaluation | None, found: FaultSearch | None, equations: bool
) -> dict[str, list[Drawing]]:
    """Draw all figures for which the run has data into a folder; by groups of the page."""
    with matplotlib.rc_context(look.STYLE):
        drawn: dict[str, list[Drawing | None]] = {
            "against": [] if other is None else [against(e, other)],
            "motion": [
                history(e, equations), orbit(e), load_distribution(e), passage(e), loads(e),
                tilt(e), pressure(e), energy(e), cage(e),
            ],
            "vibration": [spectra.acceleration(e), spectra.envelope(e), spectra.orders(e), *passages(e)],
            "search": [] if found is None else [search(found)]}  # fmt: skip
        if equations:
            drawn["spectra"] = [spectra.whole(e)]
            drawn["budget"] = spectra.budget(e)
        methods = {group: method_sentence(e, other if group == "against" else None) for group in drawn}
        return {
            group: [look.save(each._replace(caption=each.caption + methods[group]), folder) for each in rows if each]
            for group, rows in drawn.items()
        }


def method_sentence(e: Evaluation, other: Evaluation | None) -> str:
    """Model and damping of the run that figures show, and of what it is compared with; of a table from elsewhere ""."""
    runs = [each.record for each in (e, other) if each is not None]
    return "".join(dict.fromkeys(f" Run {run.name}: {run.scene.method}." for run in runs if run.attributes))


def history(e: Evaluation, equations: bool) -> Drawing:
    t, loaded, time = e.record, e.budget.loaded, 1e3 * e.record.time
    j = chosen_roller(loaded, e.chatter)
    rho = t.rho[:, j] - t.bearing.pitch_radius
    shown = {"hub x, µm": 1e6 * t.inner_x, "hub y, µm": 1e6 * t.inner_y, f"ρ of roller {j}, µm": 1e6 * rho}
    if equations:
        shown |= {f"error_{d.name}, N": d.budget.error for d in e.directions}
    figure, axes = panels(len(shown), 1.0 + 1.4 * len(shown), lines=0, x="time, ms", y=shown)
    for axis, values in zip(axes, shown.values(), strict=True):
        curves(axis, time, (values, BLUE))
    for first, last in load_zones(loaded[:, j], e.chatter):
        axes[2].axvspan(time[first], time[last], color=ORANGE, alpha=0.18, linewidth=0)
    return Drawing("history", "Motion over time",
        f"Centre of the inner ring; radial place ρ of roller {j} beyond the pitch radius, shaded where its inner "
        f"contact is closed (load zone){'; error forces, 0 for a perfect model' if equations else ''}.",
        figure)  # fmt: skip


def orbit(e: Evaluation) -> Drawing:
    t, statics = e.record, e.statics
    figure, (axes,) = panels(1, 4.6, x="x without mean, µm", y=["y without mean, µm"])
    x, y = t.inner_x.mean(), t.inner_y.mean()
    curves(axes, 1e6 * (t.inner_x - x), (1e6 * (t.inner_y - y), BLUE, "run", {"linewidth": 0.6, "alpha": 0.8}))
    axes.margins(x=OF_PATHS)
    caption = f"Path of the inner ring's centre about its mean, x = {length(x)}, y = {length(y)}."
    if statics is not None:
        x, y, name = statics.x[:-1].mean(), statics.y[:-1].mean(), f"Lagrangian statics, {statics.law}"
        curves(axes, 1e6 * (statics.x - x), (1e6 * (statics.y - y), ORANGE, name, 2.0))
        caption += (
            f" Thick: the equilibria of the Lagrangian model (rigid rings, law {statics.law}) over one roller passage, "
            f"about theirs, x = {length(x)}, y = {length(y)}."
        )
    axes.set_aspect("equal", adjustable="datalim")
    legend_above(axes, 2)
    return Drawing("orbit", "Orbit of the inner ring", caption, figure)


def load_distribution(e: Evaluation) -> Drawing:
    force, statics = e.force, e.statics
    figure, (axes,) = panels(1, 5.2, projection="polar")
    axes.set_theta_zero_location("S")
    name = f"law {e.law.name}, approaches of the run" if e.record.inner_force is None else "run"
    _dots(axes, e.record.from_load, (force, BLUE, name))
    caption = "Force of the inner raceway on the rollers over their angle from the load line, all rollers and times"
    if statics is not None:
        curves(axes, statics.angle, (statics.force, ORANGE, f"Lagrangian statics, {statics.law}", 1.8))
        caption += (
            f"; line: the static equilibria of the Lagrangian model. Largest: {text(force.max())} N in the run, "
            f"{text(statics.force.max())} N in the statics"
        )
    axes.set_ylim(bottom=0.0)
    axes.set_rlabel_position(112.5)
    axes.text(0.46, 0.515, "N", color=GREY, fontsize=9, transform=axes.transAxes)
    axes.set_thetagrids(np.arange(0, 360, 45), [f"{a}°" for a in "0 45 90 135 180 −135 −90 −45".split()])
    axes.legend(loc="lower left", bbox_to_anchor=(-0.35, -0.02), markerscale=5)
    return Drawing("load_distribution", "Load distribution", f"{caption}.", figure)


def _dots(axis, angle, *rows, most=MOST_POINTS):
    some = slice(None, None, max(1, angle.size // most))
    drawn = [(np.asarray(values)[some].ravel(), colour, label, DOTS) for values, colour, label in rows]
    curves(axis, angle[some].ravel(), *drawn)


def loads(e: Evaluation) -> Drawing:
    own, budget, contacts = e.record.inner_force, e.budget, e.budget.contacts
    angle = np.degrees(angle_from_load(np.arctan2(-contacts.direction_y, -contacts.direction_x)))
    names = ["inner contact force, N", "run − law, closed contacts, N"]
    figure, axes = panels(*((1, 3.8) if own is None else (2, 5.6)), x=FROM_LOAD, y=names)
    _dots(axes[0], angle, (budget.law_force, RED, f"law: {e.law.name}"))
    caption = (
        "Contact force between the inner ring and each roller, all rollers and times, over the roller's angle from "
        "the load line (counter-clockwise)."
    )
    if own is not None:
        _dots(axes[0], angle, (own, BLUE, "run's own contact force"))
        _dots(axes[1], angle, (np.where(budget.loaded, own - budget.law_force, np.nan), PURPLE, None))
        caption += " Below: run minus law, closed contacts."
    axes[0].set_ylim(bottom=0.0)
    axes[0].legend(loc="upper left", markerscale=5)
    return Drawing("loads", "Loads of the rollers", caption, figure)


def tilt(e: Evaluation) -> Drawing | None:
    t, angle = e.record, np.degrees(e.record.from_load)
    if e.tilt is None:
        return None
    figure, axes = panels(2, 5.0, x=FROM_LOAD, y=["tilt, mrad", "moment of a contact, N m"])
    _dots(axes[0], angle, (1e3 * np.asarray(t.roller_tilt), BLUE, None))
    _dots(axes[1], angle, (t.inner_moment, BLUE, "inner raceway"), (t.outer_moment, ORANGE, "outer raceway"))
    axes[1].legend(loc="upper left", markerscale=5)
    x, y = (text(1e3 * np.asarray(each).mean()) for each in (t.inner_slope_x, t.inner_slope_y))
    return Drawing("tilt", "Tilt and moments of the rollers",
        "Tilt of each roller (its +z end outwards is positive) and the moments of its contacts, all rollers "
        f"and times; they differ by the roller's inertia alone. Mean slope of the shaft: {x} mrad in x, {y} mrad in y.",
        figure)  # fmt: skip


def pressure(e: Evaluation) -> Drawing | None:
    """Pressures over both raceways and along the most loaded rollers; None where the source has none."""
    found = None if e.tilt is None else along_rollers(e.record)
    if found is None:
        return None
    x, y = (FROM_LOAD, "along the axis z, mm"), ["inner: z, mm", "outer: z, mm", "pressure, MPa"]
    figure, axes = panels((2, 1), 6.8, lines=0, shares=(1.0, 1.0, 1.6), right=SCALE, x=x, y=y)
    z, angle = 1e3 * found.place, np.degrees(found.angle)
    ends = np.append(z - 0.5 * (z[1] - z[0]), -z[0] + 0.5 * (z[1] - z[0]))  # of slices
    shown = np.ma.masked_equal(1e-6 * found.around, 0.0)
    for axis, values in zip(axes, shown, strict=False):
        image = axis.pcolormesh(angle, z, values.T, vmin=0.0, vmax=shown.max(), cmap="viridis",
                                shading="nearest", rasterized=True)  # fmt: skip
        axis.grid(visible=False)
    colour_bar(image, axes[:2], "pressure, MPa")
    for j, colour, *sides in zip(found.rollers, (BLUE, ORANGE, GREEN), *found.along, strict=False):
        for values, line, label in zip(sides, ("-", DASHED), (f"roller {j}", None), strict=True):
            axes[2].step(ends, 1e-6 * np.append(values, values[-1]), where="post", color=colour, linestyle=line,
                         label=label)  # fmt: skip
    axes[2].plot([], [], color=GREY, linestyle=DASHED, label="outer")
    axes[2].set_ylim(bottom=0.0)
    axes[2].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.0, handletextpad=0.5)
    peak = [text(1e-6 * each.max()) for each in found.around]
    caption = (
        "Pressure on both raceways, unrolled: at every angle the contact with the largest force. Below: pressure along "
        f"the most loaded rollers at {text(1e3 * found.time)} ms, when a contact has the largest moment, by slices. "
    )
    caption += SHARP if found.edges else f"Largest: {peak[0]} MPa (inner raceway), {peak[1]} MPa (outer)."
    return Drawing("pressure", "Pressure along the rollers", caption, figure)


def energy(e: Evaluation) -> Drawing | None:
    time, energies = 1e3 * e.record.time, e.record.energies
    if not set(ENERGIES) <= set(energies):
        return None
    figure, axes = panels(2, 4.8, x="time, ms", y=["change, mJ", "imbalance, µJ"])
    rows = [(1e3 * (energies[key] - energies[key][0]), colour, label, 1.1)
            for key, (label, colour) in ENERGY_CURVES.items() if key in energies]  # fmt: skip
    curves(axes[0], time, *rows)
    legend_above(axes[0], len(rows), 0.0 if len(rows) <= SHORT_ROW else LONG_ROW, columnspacing=0.9, handlelength=1.1)
    imbalance = energy_imbalance(energies)
    scale = np.mean(energies["energy_elastic"] + energies["energy_contact"])
    scale += np.ptp(energies["work_dissipated"])  # an imbalance accumulates, as this does
    curves(axes[1], time, (1e6 * imbalance, "black", None, 1.1))
    caption = (
        "Energies and works since the first sample shown. Imbalance: all energies − external work + dissipated, as "
        "changes"
    )
    if scale > 0.0:
        share = text(100.0 * np.abs(imbalance).max() / scale, 2)
        caption += f"; at most {share} % of the mean strain energy and the dissipated energy together"
    return Drawing("energy", "Energy balance of the run", f"{caption}.", figure)


def energy_imbalance(energies) -> np.ndarray:
    """Change of the energies minus external work plus dissipation since the first sample, J, (n_times,)."""
    total = energies["energy_kinetic"] + energies["energy_elastic"] + energies["energy_contact"]
    total = total + sum(energies[name] for name in mounting.ENERGIES if name in energies)
    total = total - energies["work_external"] + energies["work_dissipated"]
    return total - total[0]


def passage(e: Evaluation) -> Drawing | None:
    """Forces on one roller through the load zone; None where it never passes or the source holds no forces."""
    t, budget = e.record, e.budget
    j = chosen_roller(budget.loaded, e.chatter)
    zones = load_zones(budget.loaded[:, j], e.chatter)
    angle = np.degrees(np.unwrap(t.from_load[:, j]))
    if not zones or t.inner_force is None or np.ptp(angle) < 360.0 * SMALLEST_TURN:
        return None
    first, last = max(zones, key=lambda zone: zone[1] - zone[0])
    margin = (last - first) // 12
    shown = slice(max(0, first - margin), last + margin + 1)
    place = angle[shown] - 360.0 * np.round(angle[(first + last) // 2] / 360.0)
    dashed = {"linewidth": 1.1, "linestyle": (0, (5, 2))}
    normal: list[tuple] = [
        (t.inner_force, BLUE, "inner raceway", 1.1), (t.outer_force, RED, "outer raceway", dashed),
        (budget.law_force, GREY, f"law {e.law.name}, inner", 0.9)]  # fmt: skip
    tangential = [(t.inner_traction, BLUE, None, 0.9), (t.outer_traction, RED, None, 0.9)]
    below = all(of is not None for of, *_ in tangential)
    figure, axes = panels(1 + below, 3.4 + 1.8 * below, y=["normal force, N", "traction on the roller, N"])
    for axis, rows in zip(axes, (normal, tangential), strict=False):
        curves(axis, place, *((of[shown, j], *look) for of, *look in rows if of is not None))
    legend_above(axes[0], 3)
    axes[0].set_ylim(bottom=0.0)
    caption = (
        f"Roller {j} on its way through the load zone, {text(1e3 * t.time[first])} to {text(1e3 * t.time[last])} ms: "
        "normal forces of both raceways (the outer one also carries the centrifugal force) and the force by the law "
        f"for the same approach{'; below: tractions, positive counter-clockwise' if below else ''}."
    )
    axes[-1].set_xlabel(FROM_LOAD)
    return Drawing("passage", f"Roller {j} through the load zone", caption, figure)


def against(e: Evaluation, other: Evaluation) -> Drawing:
    laws = e.record.source == other.record.source
    over_time, density, what, of = ("hub {}, µm", "PSD, {}, m²/s⁴/Hz", "motion of the hub", "acceleration of the hub")
    if laws:
        over_time, density, what, of = ("error_{}, N", "PSD of error_{}, N²/Hz", "error forces", "error forces")
    names = [*map(over_time.format, "xy"), "inner contact force, N", *map(density.format, "xy")]
    x_names = ("time, ms", FROM_LOAD, "frequency, Hz")
    figure, axes = panels((2, 1, 2), 12.0, shares=(1.0, 1.0, 1.3, 1.0, 1.0), x=x_names, y=names)
    for each, name, colour, width in zip((e, other), named(e, other), (BLUE, RED), (1.4, 0.8), strict=True):
        t, style = each.record, (colour, name, width)
        force = each.budget.law_force if laws else each.force  # of two laws theirs, of two runs their own
        _dots(axes[2], np.degrees(t.from_load), (force, colour, name), most=MOST_COMPARED)
        slowest = min(each.lines.values(), default=0.0)
        pairs = zip(each.directions, t.inner, each.hub_acceleration, strict=True)
        for i, (d, place, acceleration) in enumerate(pairs):
            curves(axes[i], 1e3 * t.time, (d.budget.error if laws else 1e6 * place, *style))
            spectrum = d.spectrum if laws else power_spectrum(acceleration, t.interval, slowest)
            look.log_panel(axes[3 + i], spectrum.frequency[1:])
            curves(axes[3 + i], spectrum.frequency[1:], (np.maximum(spectrum.psd[1:], 1e-300), *style))
    axes[2].set_ylim(bottom=0.0)
    legend_above(axes[0], 2)
    return Drawing("against", "Comparison",
        f"The {what} over time, forces of the inner contacts over the rollers' angle, and power spectral densities of "
        f"the {of}, overlaid.", figure)  # fmt: skip


def cage(e: Evaluation) -> Drawing | None:
    """The cage's path, forces and slip; None where the run has none."""
    t, own, facts = e.record, e.record.cage, e.record.scene.ideal_cage()
    if own is None or facts is None:
        return None
    names = ["y, µm", "largest force, N", "slip, %"]
    figure, (path, forces, slips) = panels((1, 2), 8.4, shares=(1.6, 1.0, 1.0), x=("x, µm", "time, ms"), y=names)
    x, y = (t.inner_x, t.inner_y) if facts.guidance == "inner_ring" else (0.0, 0.0)
    play = facts.pocket_clearance if facts.guidance_clearance is None else facts.guidance_clearance
    curves(path, 1e6 * (own.x - x), (1e6 * (own.y - y), BLUE, None, 0.7))
    path.add_patch(Circle((0.0, 0.0), 5e5 * play, fill=False, color=GREY, linewidth=0.8, linestyle="--"))
    path.margins(x=OF_PATHS)
    path.set_aspect("equal", adjustable="datalim")
    guided = np.hypot(own.guidance_x, own.guidance_y)
    rows = [
        (np.maximum(own.force, 0.0).max(axis=1), BLUE, "rear wall, pushes forward"),
        (np.minimum(own.force, 0.0).min(axis=1), RED, "front wall, holds back"), (guided, GREEN, "guide")]  # fmt: skip
    curves(forces, 1e3 * t.time, *[(*row, 0.8) for row in rows[: 3 if guided.any() else 2]], legend=3)
    caption = (
        "Above: path of the cage's centre about that of the bearing, or of the inner ring where that guides it; "
        "dashed: the circle that its clearance leaves. Middle: the largest force of all "
        f"pockets along the pitch circle at each time, at most {text(np.abs(own.force).max())} N."
    )
    if t.operation.fastest:  # slip against rolling at the shaft's speed of the same time
        reach = max(1, min(round(SHORTEST / t.interval), (t.time.size - 1) // 2))
        seconds = reach * t.interval
        ideal = np.ravel(turned(t.bearing, t.operation, t.time).cage) + np.zeros(t.time.size)
        angles = ideal, t.theta.mean(axis=1), own.angle
        rolling, *speeds = ((angle[reach:] - angle[:-reach]) / seconds for angle in angles)
        rolling = np.where(np.abs(rolling) >= SLOWEST * np.abs(rolling).max(), rolling, np.nan)
        rollers, cages = (100.0 * (1.0 - speed / rolling) for speed in speeds)
        middle = 5e2 * (t.time[reach:] + t.time[:-reach])
        curves(slips, middle, (rollers, ORANGE, "rollers"), (cages, BLUE, "cage"))
        slips.legend(loc="upper right", ncols=2, frameon=True, framealpha=0.8, edgecolor="none")
        mean = kinematics(t.bearing, *t.mean_speeds).cage
        whole = f"the {'cage turns less than once' if mean else 'motion reverses'} and has no mean slip"
        if mean and t.orbits >= 1.0:
            slip = text(100.0 * (1.0 - own.speed(t.interval) / mean), 2)
            whole = f"of the cage over the whole record {slip} %"
        caption += (
            f" Below: slip of the cage and of the rollers (their mean), {text(1e3 * seconds)} ms at a time, "
            f"where the shaft turns with at least an eighth of its highest speed; {whole}."
        )
    return Drawing("cage", "The cage", caption, figure)


def passages(e: Evaluation) -> Iterator[Drawing]:
    """Passages over the scene's spalls, where the record holds contact forces and rollers pass any."""
    record, found = e.record, dict[int, list[Passage]]()
    if record.inner_force is None or record.outer_force is None:
        return
    turn = np.broadcast_to(record.turns.rollers, record.roller_x.shape)
    columns = {"roller_turn": turn, "roller_spin": np.gradient(turn, record.time, axis=0)}
    for name in "time inner_x inner_y roller_x roller_y inner_force outer_force".split():
        columns[name] = getattr(record, name)

    def rows(start, stop):
        return {name: values[start:stop] for name, values in columns.items()}

    for each in find_passages(record.bearing, record.operation, rows, record.time.size):
        first, last = each.angle[0] / each.half_width, each.angle[-1] / each.half_width
        whole = abs(first) > 1.0 and abs(last) > 1.0 and first * last < 0.0  # in at one edge and out at the other
        if whole and np.any(each.force > 0.0):
            found.setdefault(each.spall, []).append(each)
    hardest = sorted(found, key=lambda spall: -max(each.force.max() for each in found[spall]))[:MOST_SPALLS]
    yield from (_overlay(e, spall, found[spall]) for spall in sorted(hardest))


def _overlay(e, number, found):
    record, spall = e.record, spalls(e.record.bearing)[number]
    found = found[:: -(-len(found) // MOST_PASSAGES)]
    half = np.degrees(found[0].half_width)
    loud = max(e.directions, key=lambda direction: direction.vibration.level.rms).name
    acceleration = e.hub_acceleration["xy".index(loud)]
    right, style = look.RIGHT, dict[str, Any](colors=SKY)
    if spall.body != "outer_ring":  # then it is passed at all places
        middle = [each.first + np.argmin(np.abs(each.angle)) for each in found]
        place = np.abs(np.degrees(record.from_load[middle, [each.roller for each in found]]))
        right, style = SCALE, {"array": place, "cmap": "viridis", "clim": (0.0, 180.0)}
    names = ["contact force, N", f"hub's acceleration, {loud}, m/s²"]
    figure, axes = panels(2, 5.6, right=right, x="angle from the spall's middle, on the way, °", y=names)
    angles = [np.degrees(np.sign(each.angle[-1] - each.angle[0]) * each.angle) for each in found]
    grid = SHOWN * half * np.linspace(-1.0, 1.0, MEAN_POINTS)
    quantities = [each.force for each in found], [acceleration[each.first :][: each.time.size] for each in found]
    for axis, values in zip(axes, quantities, strict=True):
        lines = [np.column_stack(line) for line in zip(angles, values, strict=True)]
        drawn = axis.add_collection(LineCollection(lines, linewidths=0.6, alpha=0.6, **style))
        rising = [line[np.argsort(line[:, 0])] for line in lines]
        mean = np.mean([np.interp(grid, *line.T) for line in rising], axis=0)
        curves(axis, grid, (mean, "black", f"mean of {len(found)} passages", 1.4))
        for edge in (-half, half):
            axis.axvline(edge, color=GREY, linestyle=DASHED, linewidth=1.0, zorder=1)
        axis.autoscale_view()
    caption = (
        f"Passages over the {text(1e3 * spall.width)} mm wide spall on {body_name(spall)}, over the contact's angle "
        "from its middle: force of the contact and acceleration of the hub. Dashed: the spall's edges, "
        f"{text(half, 3)}° away."
    )
    strikes = [  # angle, degrees, and force, N
        (np.interp(event.time, each.time, angle), event.force)
        for angle, each in zip(angles, found, strict=True) for event in spall_events([each]) if event.kind == "strike"
    ]  # fmt: skip
    if strikes:
        at, forces = np.transpose(strikes)
        axes[0].plot(at, forces, "o", color=RED, markersize=3.0, label="strikes", zorder=5)
        caption += (
            f" Dots: impacts, the first large peak after a roller was released; their medians are "
            f"{np.median(forces):.0f} N and {text(0.5 + 0.5 * np.median(at) / half, 2)} of the crossing from the entry."
        )
    legend_above(axes[0], 3)
    axes[0].set(ylim=(0.0, None), xlim=(-SHOWN * half, SHOWN * half))
    if right == SCALE:
        colour_bar(drawn, axes, "roller's place, ° from the load line")
    return Drawing(f"passages_{number}", f"Passages over spall {number}", caption, figure)


def search(made: FaultSearch) -> Drawing | None:
    """Maps of a search for spalls, and passages over those found; None where no map was made."""
    if not made.maps:
        return None
    rows = max(1, 2 * len(made.found))
    names = "angle in the body's own frame, degrees", "contact from the spall's middle, mm"
    beside = ["sinkage, µm", "from the equation of motion, µm"]
    figure, axes = panels((1,) * rows, 3.3 * rows, x=(names * rows)[:rows], y=beside * rows)
    caption = "Median of how deep rollers find the surface around each ring: no place stands out."
    maps = [(axes[2 * k], each.seen, BLUE) for k, each in enumerate(made.found)]
    if not made.found:
        rings = (each for each in made.maps if each.place.roller is None)
        maps = [(axes[0], ring, colour) for ring, colour in zip(rings, (BLUE, GREEN), strict=False)]
    for axis, seen, colour in maps:
        angle = np.array([reported_angle(seen.place, a) for a in seen.angle])
        order = np.argsort(angle)
        curves(axis, angle[order], (1e6 * seen.height[order], colour, body_name(seen.place)))
    for k, each in enumerate(made.found):
        caption = (
            "Above: median of how deep rollers find the surface around the body, from all passages. Below: difference "
            "of three samples of a roller from its equation of motion, in every passage, on perfect circles and with "
            "the spall found. Shaded: its width, darker the 95 % intervals of its edges."
        )
        middle, turn = reported_angle(each.place, each.angle), np.degrees(0.5 * each.width / each.place.radius)
        upper, lower = axes[2 * k : 2 * k + 2]
        upper.axvspan(middle - turn, middle + turn, color=RED, alpha=0.25, linewidth=0, label="the spall found")
        half, aside = 0.5 * each.width, 0.5 * each.width_error
        for at, wide, alpha in (0.0, half, 0.12), (-half, aside, 0.2), (half, aside, 0.2):
            lower.axvspan(1e3 * (at - wide), 1e3 * (at + wide), color=RED, alpha=alpha, linewidth=0)
        rest = [other.spalled for i, other in enumerate(made.found) if i != k]
        near = Near(made.motion, each.place, each.angle, half + BESIDE_SPALL, rest)
        missed = near.samples.over([(each.place, np.array([each.spall * (1.0, 0.0, 1.0), each.spall])), *rest])
        dots = {"linestyle": "none", "marker": ".", "markersize": 3.0}
        circles = (1e6 * missed[0], ORANGE, "perfect circles", dots)
        curves(lower, 1e3 * near.beyond, circles, (1e6 * missed[1], BLUE, "with the spall found", dots))
    for axis in axes[::2]:
        axis.set_xlim(-180.0, 180.0)
    for axis in axes:
        legend_above(axis, 3)
    return Drawing("fault_search", "Passages by the body's own angle", caption, figure)
