"""A figure of the cage: its centre's path, its pockets' forces, its slip."""

from pathlib import Path

import numpy as np

from lagrange.cage import Cage
from lagrange.kinematics import kinematics, turned
from residual.cage import CageMotion
from residual.colours import BLUE, GREEN, GREY, ORANGE, RED
from residual.evaluation import Evaluation
from residual.figures import SavedFigure
from residual.orders import SLOWEST
from residual.panels import panels
from residual.plotting import legend_above, save
from residual.record import Record
from residual.words import text

SHORTEST = 2e-3  # s, over which speeds are means


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
    mean = kinematics(t.bearing, t.mean_speed).cage
    if mean == 0.0:
        return f"{sentence}; the motion reverses and has no mean slip."
    return f"{sentence}; of the cage over the whole record {text(100.0 * (1.0 - cage.speed(t.interval) / mean), 2)} %."
