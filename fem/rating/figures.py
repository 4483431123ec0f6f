"""Figures of rating.html, with the look of the report."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from fem.rating.case import Case, positive
from fem.study.figures import Figure, finished
from lagrange.contact.hertz import contact_pairs
from lagrange.rating.friction import palmgren_torque, power_loss, skf_torque
from lagrange.rating.reference_life import rigid_loads
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import Pitch
from residual.figures import STYLE, WIDTH
from residual.formatting import BLUE, GREEN, GREY, ORANGE, RED

FEW = 12  # cage angles in a pitch, where curves are means
LOADS = np.array([0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0])  # of the scene's
PRELOAD, PLAY = -0.0025, 0.006  # of a roller's diameter: clearances of the figure of lives
TILTED = 4e-3  # rad
FASTER = 2.0  # times the scene's speed
UM = 1e6
PER_UM = 1e-6


def rating_figures(case: Case) -> list[Figure]:
    """All that a scene allows."""
    look: dict[Any, Any] = {**STYLE, "figure.constrained_layout.use": True, "font.size": 9, "axes.labelsize": 9}
    makers = _clearance, _load_zone, _stiffness, _load_deflection, _life, _misalignment, _friction
    with plt.rc_context(look):
        return [figure for maker in makers for figure in _possible(maker, case)]


def _possible(maker: Callable[[Case], Figure], case: Case) -> Iterator[Figure]:
    try:
        yield maker(case)
    except Unavailable:
        plt.close("all")  # the page's table has the reason


def _contacts(case: Case) -> Iterator[tuple[str, Pitch, str]]:
    """Words, equilibria and colour of what there is: elastic rings, rigid ones on a law."""
    for name, words, colour in (
        ("elastic", "elastic rings", BLUE),
        ("lagrangian", f"rigid rings, {case.laws.inner.name}", ORANGE),
    ):
        try:
            yield words, getattr(case, name), colour
        except Unavailable:
            continue


def _clearance(case: Case) -> Figure:
    """Parts of the operating clearance, one hanging from the other."""
    found = case.build_up
    figure, axis = plt.subplots(figsize=(WIDTH, 2.7))
    rows, level = found.rows(), 0.0
    for place, ((_, label, _), part) in enumerate(zip(rows, [*found.parts.values(), found.total], strict=True)):
        whole = place in (0, len(rows) - 1)
        start, step = (0.0, UM * part) if whole else (level, UM * part)
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


def _load_zone(case: Case) -> Figure:
    """Roller loads and pressures around the load."""
    row, inner = case.row, contact_pairs(case.bearing)[0]
    figure, (loads, pressures) = plt.subplots(1, 2, figsize=(WIDTH, 2.9))
    curves = [
        (words, pitch.theta.ravel(), pitch.inner_force.ravel(), colour) for words, pitch, colour in _contacts(case)
    ]
    turned = 2.0 * np.pi / row.rollers * np.arange(FEW) / FEW
    load = positive(case.static_load, "no load, no load zone")
    rigid = [case.rigid_at(at, load=load) for at in turned]
    angles = np.add.outer(turned, 2.0 * np.pi * np.arange(row.rollers) / row.rollers) - 0.5 * np.pi
    curves.append(("ISO/TS 16281", angles.ravel(), np.concatenate([each.of_rollers for each in rigid]), GREY))
    for words, theta, force, colour in curves:
        degrees = np.degrees(np.angle(1j * np.exp(1j * theta)))  # from the load's direction, −y
        order = np.argsort(degrees)
        loads.plot(degrees[order], force[order], color=colour, label=words)
        pressure = [PER_UM * inner.peak_pressure(float(q)) for q in force[order]]
        pressures.plot(degrees[order], pressure, color=colour)
    for axis, label in ((loads, "load of a roller, N"), (pressures, "Hertz pressure, MPa")):
        axis.set(xlabel="angle from the load, °", ylabel=label, xlim=(-180, 180), ylim=(0, None))
        axis.set_xticks([-180, -90, 0, 90, 180])
    figure.legend(loc="outside upper center", ncols=3, fontsize=7.5)
    caption = f"At {case.static_load:.4g} N, at all angles of the cage; pressures of the inner raceway, no profile."
    return finished(figure, "load-zone", "Load zone", caption)


def _stiffness(case: Case) -> Figure:
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6))
    found = list(_contacts(case))
    if not found:
        raise Unavailable("no equilibrium")
    for words, pitch, colour in found:
        share = np.append(pitch.turned, case.bearing.period) / case.bearing.period
        for axis, (i, j) in zip(axes, ((1, 1), (0, 0), (0, 1)), strict=True):
            values = PER_UM * np.append(pitch.stiffness[:, i, j], pitch.stiffness[0, i, j])
            axis.plot(share, values, color=colour, label=words)
            if i == j:
                axis.axhline(PER_UM * pitch.mean[i, j], color=colour, linestyle=":", linewidth=0.9)
    for axis, name in zip(axes, ("kyy, along the load", "kxx, across it", "kxy"), strict=True):
        axis.set(xlabel="cage angle over a pitch", title=f"{name}, N/µm", xlim=(0, 1))
    axes[0].legend(fontsize=7.5)
    caption = f"Rollers pass: stiffness in equilibrium at {case.static_load:.4g} N. Dotted: means over the pitch."
    return finished(figure, "stiffness", "Stiffness over a pitch", caption)


def _load_deflection(case: Case) -> Figure:
    operation = case.on_bearing
    if not case.static_load > 0.0:
        raise Unavailable("no load, no curve")
    figure, axis = plt.subplots(figsize=(WIDTH, 2.9))
    share = LOADS[:, None]

    def curve(solve: Callable[..., Pitch]) -> np.ndarray:
        rows = []
        for part in LOADS:
            weight = operation.inner_mass * operation.gravity
            load = part * (operation.radial_load + weight) - weight
            pitch = solve(replace(operation, radial_load=load, side_load=part * operation.side_load))
            rows.append(np.hypot(*pitch.place.mean(axis=0)))
        return UM * np.array(rows)

    for words, _, colour in _contacts(case):
        under = case.elastic_under if colour == BLUE else case.lagrangian_under
        found = curve(lambda each, under=under: under(each, FEW))
        axis.plot(found, share[:, 0] * case.static_load, "o-", markersize=3, color=colour, label=words)
    axis.set(xlabel="displacement of the hub, µm", ylabel="load, N", xlim=(0, None), ylim=(0, None))
    axis.legend(fontsize=7.5)
    caption = "Means over a pitch. The curve starts at the radial clearance, half the diametral one."
    return finished(figure, "load-deflection", "Load and deflection", caption)


def _life(case: Case) -> Figure:
    row, load = case.row, case.section_load
    own = 2e3 * case.bearing.radial_clearance
    clearances = np.union1d(np.linspace(PRELOAD, PLAY, 35) * row.diameter, [own])
    figure, axis = plt.subplots(figsize=(WIDTH, 2.9))
    for share, colour in ((0.5, GREEN), (1.0, BLUE), (2.0, RED)):
        lives = [case.reference_life(rigid_loads(row, share * load, s).loads) for s in clearances]
        axis.plot(1e3 * clearances / row.cosine, lives, color=colour, label=f"{share * case.some_load:.0f} N")
    axis.axvline(1e3 * own / row.cosine, color=GREY, linestyle="--", linewidth=0.9, label="scene")
    axis.set(xlabel="diametral clearance, µm (below 0: preload)", ylabel="L10r, 10⁶ revolutions", yscale="log")
    axis.legend(fontsize=7.5)
    caption = (
        "ISO/TS 16281, rigid rings: a small preload spreads the load over more rollers and lengthens life; a larger "
        "one shortens it."
    )
    return finished(figure, "life", "Life over load and clearance", caption)


def _misalignment(case: Case) -> Figure:
    tilts = np.linspace(0.0, TILTED, 25)
    figure, axis = plt.subplots(figsize=(WIDTH, 2.9))
    curves: list[tuple[bool | None, str, str, str]] = [
        (True, "logarithmic profile", BLUE, "-"),
        (False, "straight rollers", RED, "-"),
    ]
    if case.axial is not None:
        curves.append((None, "the scene's profiles", GREEN, "--"))
        axis.axvline(1e3 * abs(case.operation.misalignment), color=GREY, linestyle=":", linewidth=0.9)
    for profile, words, colour, style in curves:
        lives = [case.reference_life(case.rigid_at(slope=tilt, profile=profile).loads) for tilt in tilts]
        axis.plot(1e3 * tilts, lives, color=colour, linestyle=style, label=words)
    axis.set(xlabel="misalignment, mrad", ylabel="L10r, 10⁶ revolutions", yscale="log", xlim=(0, None))
    axis.legend(fontsize=7.5)
    caption = "ISO/TS 16281, rigid rings, misaligned in the plane of the load."
    return finished(figure, "misalignment", "Life over misalignment", caption)


def _friction(case: Case) -> Figure:
    _ = case.torques
    fastest = FASTER * case.rpm if case.rpm > 0.0 else 1000.0
    speeds, viscosity = np.linspace(0.0, fastest, 60), case.viscosity
    figure, (torques, heat) = plt.subplots(1, 2, figsize=(WIDTH, 2.7))
    for words, model, colour in (("SKF", skf_torque, BLUE), ("Palmgren", palmgren_torque, ORANGE)):
        total = np.array([case.torque(model, float(n)).total for n in speeds])
        torques.plot(speeds, total, color=colour, label=words)
        heat.plot(speeds, [power_loss(m, float(n)) for m, n in zip(total, speeds, strict=True)], color=colour)
    for axis, label in ((torques, "frictional torque, N mm"), (heat, "heat, W")):
        axis.axvline(case.rpm, color=GREY, linestyle="--", linewidth=0.9)
        axis.set(xlabel="speed, 1/min", ylabel=label, xlim=(0, fastest), ylim=(0, None))
    torques.legend(fontsize=7.5)
    caption = f"At {viscosity:.3g} mm²/s; dashed: the rated speed. Friction is uncertain by at least ±30 %."
    return finished(figure, "friction", "Friction over speed", caption)
