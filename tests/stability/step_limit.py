"""Where the time step's limit is, `python -m tests.stability.step_limit`: energy drift by step over critical step."""

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np

from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.errors import RunFailed
from lagrange.scene.scene import parse_scene
from tests.measurements import markdown_table
from tests.stability.random_scenes import random_scene

RATIOS = np.array((0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0, 1.0025, 1.005, 1.01, 1.015, 1.02, 1.04, 1.07, 1.1, 1.15,
                   1.2))  # fmt: skip
STRIDE = 50  # steps between samples, the same for all ratios
UNBOUNDED = 1.0  # of the stored energy: drift drawn for a run that was stopped
SAFE_SIDE = 0.15  # the true limit lies at most this far above the computed step
DURATION_MS = 3.0
NUMERICS = {"mesh_size_mm": 2.0, "duration_ms": DURATION_MS}
FEW = {
    "bearing": {
        "rollers": 5, "roller_diameter_mm": 20.0, "roller_length_mm": 20.0, "inner_raceway_diameter_mm": 30.0,
        "outer_raceway_diameter_mm": 69.98, "bore_diameter_mm": 15.0, "outside_diameter_mm": 90.0,
    },
    "operation": {"speed_rpm": -12_000.0, "radial_load_N": 15_000.0, "inner_ring_and_shaft_kg": 0.5},
    "cage": {"kind": "none"}, "contact": {"friction_coefficient": 0.3}, "numerics": NUMERICS,
}  # fmt: skip
SCENES = {
    "paper, 2 mm": {"numerics": NUMERICS}, "5 rollers, preload, 15 kN": FEW,
    "random scene 13 of seed 1": random_scene(1, 13, DURATION_MS),
}  # fmt: skip


def at_ratio(plan: ElementPlan, ratio: float, steps: int) -> ElementPlan:
    """The plan with its time step a ratio of the critical one, so many steps long."""
    return replace(plan, time_step=ratio * plan.critical_time_step, stride=STRIDE, n_samples=1 + steps // STRIDE)


def energy_drift(plan: ElementPlan) -> float:
    """Largest energy imbalance over the largest stored energy; NaN if the run stopped itself."""
    found: list[Samples] = []
    try:
        run(plan, found.append)
    except RunFailed:
        return nan
    samples = Samples.joined(found)
    return float(np.max(np.abs(samples.imbalance)) / np.max(samples["energy_elastic"] + samples["energy_contact"]))


def measured(path: Path) -> Iterator[str]:
    """The map in words and as a table; its picture is drawn, stopped runs as crosses at the top."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    axes.axvspan(1.0, 1.0 + SAFE_SIDE, color="0.92", label="safe side by less than 15 %")
    axes.axvline(1.0, color="0.4", linewidth=1.0)
    columns, verdicts = [], []
    for i, (name, tables) in enumerate(SCENES.items()):
        plan = make_plan(parse_scene(tables, "scene"))
        steps = int(1e-3 * DURATION_MS / plan.critical_time_step)  # the same simulated time or a little less
        drift = np.array([energy_drift(at_ratio(plan, ratio, steps)) for ratio in RATIOS])
        stopped = np.isnan(drift)
        columns.append(["stopped" if stops else f"{value:.1e}" for stops, value in zip(stopped, drift, strict=True)])
        first = np.append(np.flatnonzero(stopped), len(RATIOS))[0]
        good, bad = np.append(RATIOS, nan)[[first - 1, first]] if first else (nan, RATIOS[0])
        verdict = "safe side, by less than 15 %" if good >= 1.0 and bad <= 1.0 + SAFE_SIDE else "NOT AS CLAIMED"
        verdicts.append(f"{name}: the true limit lies between {good:g} and {bad:g} of the computed step: {verdict}")
        axes.semilogy(RATIOS, np.maximum(drift, 1e-12), "o-", color=f"C{i}", label=name, markersize=4)
        axes.semilogy(RATIOS[stopped], np.full(stopped.sum(), UNBOUNDED * 1.5**i), "x", color=f"C{i}")
    axes.set(xlabel="time step / computed critical step", ylabel="energy imbalance / stored energy")
    axes.set_title("Crosses: the run stopped itself", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    yield "Energy drift against time step over computed critical step"
    yield markdown_table(("step", *SCENES), zip((f"{ratio:g}" for ratio in RATIOS), *columns, strict=True))
    yield from (*verdicts, f"plot: {path}")


if __name__ == "__main__":
    print(*measured(Path("docs/stability.png")), sep="\n")
