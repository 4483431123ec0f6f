"""Where the time step's limit is: energy drift against time step over computed critical step."""

from dataclasses import dataclass, replace
from math import nan
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.errors import RunFailed
from lagrange.scene.scene import Scene, parse_scene
from tests.stability.random_scenes import random_scene

RATIOS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0, 1.0025, 1.005, 1.01, 1.015, 1.02, 1.04, 1.07, 1.1, 1.15, 1.2)
DURATION_MS = 3.0
STRIDE = 50  # steps between samples, the same for all ratios
UNBOUNDED = 1.0  # of the stored energy: drift drawn for a run that was stopped
SAFE_SIDE = 0.15  # the true limit lies at most this far above the computed step


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Drift of one scene at every ratio, NaN where the run was stopped."""

    name: str
    ratios: np.ndarray
    drift: np.ndarray  # of the stored energy

    @property
    def limit(self) -> tuple[float, float]:
        """The largest ratio that ran to its end below the first that did not, and that one (NaN: none)."""
        bad = np.flatnonzero(np.isnan(self.drift))
        if not len(bad):
            return float(self.ratios[-1]), nan
        return float(self.ratios[bad[0] - 1]) if bad[0] else nan, float(self.ratios[bad[0]])


def scenes() -> dict[str, Scene]:
    """The paper's bearing, a heavily preloaded one of few thick rollers, and a random soft one at speed."""
    numerics = {"mesh_size_mm": 2.0, "duration_ms": DURATION_MS}
    few = {
        "bearing": {
            "rollers": 5,
            "roller_diameter_mm": 20.0,
            "roller_length_mm": 20.0,
            "inner_raceway_diameter_mm": 30.0,
            "outer_raceway_diameter_mm": 69.98,
            "bore_diameter_mm": 15.0,
            "outside_diameter_mm": 90.0,
        },
        "operation": {"speed_rpm": -12_000.0, "radial_load_N": 15_000.0, "inner_ring_and_shaft_kg": 0.5},
        "cage": {"kind": "none"},
        "contact": {"friction_coefficient": 0.3},
        "numerics": numerics,
    }
    return {
        "paper, 2 mm": parse_scene({"numerics": numerics}, "paper"),
        "5 rollers, preload, 15 kN": parse_scene(few, "few"),
        "random scene 13 of seed 1": parse_scene(random_scene(1, 13, DURATION_MS), "random"),
    }


def at_ratio(plan: ElementPlan, ratio: float, steps: int) -> ElementPlan:
    """The plan with its time step a ratio of the critical one, so many steps long."""
    return replace(plan, time_step=ratio * plan.critical_time_step, stride=STRIDE, n_samples=1 + steps // STRIDE)


def energy_drift(plan: ElementPlan) -> float:
    """Largest energy imbalance over the largest stored energy; NaN if the run stopped itself."""
    largest = [0.0, 1e-300]

    def watch(samples: Samples) -> None:
        if len(samples):
            largest[0] = max(largest[0], float(np.max(np.abs(samples.imbalance))))
            largest[1] = max(largest[1], float(np.max(samples["energy_elastic"] + samples["energy_contact"])))

    try:
        run(plan, watch)
    except RunFailed:
        return nan
    return largest[0] / largest[1]


def measure(name: str, scene: Scene, ratios=RATIOS) -> Curve:
    """Drift of a scene at every ratio, over the same simulated time or a little less."""
    plan = make_plan(scene)
    steps = int(1e-3 * scene.numerics.duration_ms / plan.critical_time_step)
    drift = [energy_drift(at_ratio(plan, ratio, steps)) for ratio in ratios]
    return Curve(name=name, ratios=np.asarray(ratios), drift=np.asarray(drift))


def show(console: Console, plot: Path) -> list[Curve]:
    """Measure, print and draw the map."""
    curves = [measure(name, scene) for name, scene in scenes().items()]
    table = Table(title="Energy drift against time step over computed critical step", title_justify="left")
    table.add_column("step", justify="right")
    for curve in curves:
        table.add_column(curve.name, justify="right")
    for i, ratio in enumerate(RATIOS):
        cells = ["stopped" if np.isnan(c.drift[i]) else f"{c.drift[i]:.1e}" for c in curves]
        table.add_row(f"{ratio:g}", *cells)
    console.print(table)
    for curve in curves:
        good, bad = curve.limit
        verdict = "safe side, by less than 15 %" if good >= 1.0 and bad <= 1.0 + SAFE_SIDE else "NOT AS CLAIMED"
        console.print(f"{curve.name}: the true limit lies between {good:g} and {bad:g} of the computed step: {verdict}")
    draw(curves, plot)
    console.print(f"plot: {plot}")
    return curves


def draw(curves: list[Curve], path: Path) -> None:
    """Draw the drift on a logarithmic axis, stopped runs as crosses at the top."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    axes.axvspan(1.0, 1.0 + SAFE_SIDE, color="0.92", label="safe side by less than 15 %")
    axes.axvline(1.0, color="0.4", linewidth=1.0)
    for i, curve in enumerate(curves):
        colour = f"C{i}"
        axes.semilogy(curve.ratios, np.maximum(curve.drift, 1e-12), "o-", color=colour, label=curve.name, markersize=4)
        stopped = curve.ratios[np.isnan(curve.drift)]
        axes.semilogy(stopped, np.full(len(stopped), UNBOUNDED * 1.5**i), "x", color=colour)
    axes.set_xlabel("time step / computed critical step")
    axes.set_ylabel("energy imbalance / stored energy")
    axes.set_title("Crosses: the run stopped itself", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    show(Console(width=140), Path("docs/stability.png"))
