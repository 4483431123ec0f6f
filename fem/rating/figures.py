"""Figures of rating.html, with the look of the report."""

from contextlib import suppress
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from fem.rating.answers import Case, positive
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.rating.axial_load import rigid_loads
from lagrange.rating.life import FRICTION, power_loss
from lagrange.rating.reference_life import positions
from lagrange.rating.sources import Unavailable
from residual.figures import LOOK, WIDTH, Drawing, finished
from residual.formatting import BLUE, GREEN, GREY, ORANGE, RED

FEW = 12  # cage angles in a pitch, where curves are means
LOADS = np.array([0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0])  # of the scene's
PRELOAD, PLAY = -0.0025, 0.006  # of a roller's diameter: clearances of the figure of lives
TILTED = 4e-3  # rad
FASTER = 2.0  # times the scene's speed
UM, PER_UM = 1e6, 1e-6


def rating_figures(case: Case) -> list[Drawing]:
    """All that a scene allows."""
    found = []
    with plt.rc_context(LOOK):
        for maker in (_clearance, _rows, _load_zone, _stiffness, _load_deflection, _life, _misalignment, _friction):
            try:
                found.append(maker(case))
            except Unavailable:
                plt.close("all")  # the page's table has the reason
    return found


def _contacts(case):
    """Whether elastic, words, equilibria and colour of what there is: elastic rings, rigid ones on a law."""
    found = []
    rigid = f"rigid rings, {case.laws.inner.name}"
    for elastic, words, colour in (True, "elastic rings", BLUE), (False, rigid, ORANGE):
        with suppress(Unavailable):
            found.append((elastic, words, case.elastic if elastic else case.lagrangian, colour))
    return found


def _clearance(case):  # parts of the operating clearance, one hanging from the other
    found = case.build_up
    figure, axis = plt.subplots(figsize=(WIDTH, 2.7))
    rows, level = found.rows(), 0.0
    for place, ((_, label, _), part) in enumerate(zip(rows, [*found.parts.values(), found.total], strict=True)):
        whole, step = place in (0, len(rows) - 1), UM * part
        start = 0.0 if whole else level
        axis.bar(place, step, bottom=start, width=0.6, color=BLUE if whole else RED if part < 0.0 else GREEN)
        axis.annotate(label, (place, max(start, start + step)), (0, 3), textcoords="offset points", ha="center")
        level = start + step
    axis.axhline(0.0, color=GREY, linewidth=0.9)
    axis.set_xticks(range(len(rows)), [words.replace(" ", "\n", 1) for words, *_ in rows], fontsize=8)
    axis.set(ylabel="diametral clearance, µm")
    axis.margins(y=0.15)
    remarks = "; ".join(f"{words}: {remark}" for words, _, remark in rows if remark)
    caption = f"From unmounted to operating clearance; below 0: preload. {remarks}".strip()
    return finished(figure, "clearance", "Operating clearance", caption)


def _rows(case):  # under axial load: loads around the load, and contact angles or loads along a roller
    rows, colours = case.in_space.rows, (BLUE, ORANGE, GREEN, RED)
    place = np.degrees(np.angle(1j * np.exp(1j * roller_angles(case.bearing, case.operation.first_roller_angle))))
    figure, (loads, others) = plt.subplots(1, 2, figsize=(WIDTH, 2.9))
    width = 300.0 / case.bearing.pockets / len(rows)
    for number, (row, colour) in enumerate(zip(rows, colours, strict=False)):
        words, at = f"row {number + 1}" if len(rows) > 1 else "", place + width * (number - 0.5 * (len(rows) - 1))
        loads.bar(at, row.loads, width=width, color=colour, label=words)
        if case.balls:
            others.plot(place[row.loads > 0], np.degrees(row.angle[row.loads > 0]), "o", markersize=4, color=colour)
            continue
        most, x = np.argmax(row.loads), positions(case.row)
        for contact, style in ("inner", "-"), ("outer", "--"):
            along = getattr(row, contact)[most] / (case.row.length / x.size)
            others.plot(x, along, style, color=colour, label=f"{words} {contact} raceway")
    loads.set(xlabel="angle from the load, °", ylabel="load of an element, N", xlim=(-180, 180))
    loads.set_xticks([-180, -90, 0, 90, 180])
    if case.balls:
        others.set(xlabel="angle from the load, °", ylabel="contact angle, °", xlim=(-180, 180))
        others.set_xticks([-180, -90, 0, 90, 180])
    else:
        others.set(xlabel="along the most loaded roller, mm", ylabel="load per length, N/mm", ylim=(0, None))
        others.legend(fontsize=7.5)
    if len(rows) > 1:
        loads.legend(fontsize=7.5)
    caption = "Under radial load, axial load and moment or tilt; rigid rings, at the first angle of the cage."
    return finished(figure, "rows", "Loads of rolling elements", caption)


def _load_zone(case):  # roller loads and pressures around the load
    row, inner = case.row, contact_pairs(case.bearing)[0]
    load = positive(case.static_load, "there is no load zone")
    turned = 2.0 * np.pi / row.rollers * np.arange(FEW) / FEW
    rigid = np.concatenate([case.rigid_at(at, load=load).of_rollers for at in turned])
    angles = np.add.outer(turned, 2.0 * np.pi * np.arange(row.rollers) / row.rollers) - 0.5 * np.pi
    curves = [(words, p.theta.ravel(), p.inner_force.ravel(), colour) for _, words, p, colour in _contacts(case)]
    figure, (loads, pressures) = plt.subplots(1, 2, figsize=(WIDTH, 2.9))
    for words, theta, force, colour in (*curves, ("ISO/TS 16281", angles.ravel(), rigid, GREY)):
        degrees = np.degrees(np.angle(1j * np.exp(1j * theta)))  # from the load's direction, −y
        order = np.argsort(degrees)
        pressure = [PER_UM * inner.peak_pressure(float(q)) for q in force[order]]
        loads.plot(degrees[order], force[order], color=colour, label=words)
        pressures.plot(degrees[order], pressure, color=colour)
    for axis, label in ((loads, "load of a roller, N"), (pressures, "Hertz pressure, MPa")):
        axis.set(xlabel="angle from the load, °", ylabel=label, xlim=(-180, 180), ylim=(0, None))
        axis.set_xticks([-180, -90, 0, 90, 180])
    figure.legend(loc="outside upper center", ncols=3, fontsize=7.5)
    caption = f"At {case.static_load:.4g} N, at all angles of the cage; pressures of the inner raceway, no profile."
    return finished(figure, "load-zone", "Load zone", caption)


def _stiffness(case):
    if not (found := _contacts(case)):
        raise Unavailable("no equilibrium")
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6))
    names = ((1, 1), "kyy, along the load"), ((0, 0), "kxx, across it"), ((0, 1), "kxy")
    for axis, ((i, j), name) in zip(axes, names, strict=True):
        for _, words, pitch, colour in found:
            share = np.append(pitch.turned, case.bearing.period) / case.bearing.period
            values = PER_UM * np.append(pitch.stiffness[:, i, j], pitch.stiffness[0, i, j])
            axis.plot(share, values, color=colour, label=words)
            if i == j:
                axis.axhline(PER_UM * pitch.mean[i, j], color=colour, linestyle=":", linewidth=0.9)
        axis.set(xlabel="cage angle over a pitch", title=f"{name}, N/µm", xlim=(0, 1))
    axes[0].legend(fontsize=7.5)
    caption = f"Rollers pass: stiffness in equilibrium at {case.static_load:.4g} N. Dotted: means over the pitch."
    return finished(figure, "stiffness", "Stiffness over a pitch", caption)


def _load_deflection(case):
    acting, found = case.on_bearing, _contacts(case)
    if not (found and case.static_load > 0.0):
        raise Unavailable("no load or no equilibrium, no curve")
    figure, axis = plt.subplots(figsize=(WIDTH, 2.9))
    for elastic, words, _, colour in found:
        places = []
        for part in LOADS:
            load = part * (acting.radial_load + case.weight) - case.weight
            operation = replace(acting, radial_load=load, side_load=part * acting.side_load)
            places.append(UM * np.hypot(*case.under(operation, elastic, FEW).place.mean(axis=0)))
        axis.plot(places, LOADS * case.static_load, "o-", markersize=3, color=colour, label=words)
    axis.set(xlabel="displacement of the hub, µm", ylabel="load, N", xlim=(0, None), ylim=(0, None))
    axis.legend(fontsize=7.5)
    caption = "Means over a pitch. The curve starts at the radial clearance, half the diametral one."
    return finished(figure, "load-deflection", "Load and deflection", caption)


def _life(case):
    case.refuse_space()
    row, load, own = case.row, case.section_load, 2e3 * case.bearing.radial_clearance
    clearances = np.union1d(np.linspace(PRELOAD, PLAY, 35) * row.diameter, [own])
    curves = []
    for share, colour in ((0.5, GREEN), (1.0, BLUE), (2.0, RED)):
        lives = [case.reference_life(rigid_loads(row, share * load, s).loads) for s in clearances]
        curves.append((lives, colour, "-", f"{share * case.load:.0f} N"))
    mark = 1e3 * own / row.cosine, {"linestyle": "--", "label": "scene"}
    caption = (
        "ISO/TS 16281, rigid rings: a small preload spreads the load over more rollers and lengthens life; a larger "
        "one shortens it."
    )
    x = 1e3 * clearances / row.cosine, "diametral clearance, µm (below 0: preload)"
    return _lives(*x, curves, mark, ("life", "Life over load and clearance", caption))


def _misalignment(case):
    tilts, curves, mark = np.linspace(0.0, TILTED, 25), [], None
    kinds: list[tuple] = [(True, BLUE, "-", "logarithmic profile"), (False, RED, "-", "straight rollers")]
    if case.axial is not None:
        kinds.append((None, GREEN, "--", "the scene's profiles"))
        mark = 1e3 * abs(case.operation.misalignment), {"linestyle": ":"}
    for profile, *look in kinds:
        lives = [case.reference_life(case.rigid_at(slope=tilt, profile=profile).loads) for tilt in tilts]
        curves.append((lives, *look))
    caption = "ISO/TS 16281, rigid rings, misaligned in the plane of the load."
    about = "misalignment", "Life over misalignment", caption
    return _lives(1e3 * tilts, "misalignment, mrad", curves, mark, about)


def _lives(x, label, curves, mark, about):
    """Lives over x, with a line at the scene's."""
    figure, axis = plt.subplots(figsize=(WIDTH, 2.9))
    for lives, colour, style, words in curves:
        axis.plot(x, lives, color=colour, linestyle=style, label=words)
    if mark is not None:
        axis.axvline(mark[0], color=GREY, linewidth=0.9, **mark[1])
    left = {"xlim": (0, None)} if x[0] == 0.0 else {}
    axis.set(xlabel=label, ylabel="L10r, 10⁶ revolutions", yscale="log", **left)
    axis.legend(fontsize=7.5)
    return finished(figure, *about)


def _friction(case):
    _ = case.torques
    fastest = FASTER * case.rpm if case.rpm > 0.0 else 1000.0
    speeds, viscosity = np.linspace(0.0, fastest, 60), case.viscosity
    figure, (torques, heat) = plt.subplots(1, 2, figsize=(WIDTH, 2.7))
    for model, words, colour in zip(FRICTION.values(), ("SKF", "Palmgren"), (BLUE, ORANGE), strict=True):
        total = np.array([case.torque(model, float(n)).total for n in speeds])
        torques.plot(speeds, total, color=colour, label=words)
        heat.plot(speeds, [power_loss(m, float(n)) for m, n in zip(total, speeds, strict=True)], color=colour)
    for axis, label in ((torques, "frictional torque, N mm"), (heat, "heat, W")):
        axis.axvline(case.rpm, color=GREY, linestyle="--", linewidth=0.9)
        axis.set(xlabel="speed, 1/min", ylabel=label, xlim=(0, fastest), ylim=(0, None))
    torques.legend(fontsize=7.5)
    caption = f"At {viscosity:.3g} mm²/s; dashed: the rated speed. Friction is uncertain by at least ±30 %."
    return finished(figure, "friction", "Friction over speed", caption)
