"""Random scenes with spalls, waves and unequal rollers: `python -m tests.stability.random_surfaces`.

Even numbers are the paper's bearing, odd ones bearings of `random_scenes`; finite elements of 1 ms, of 2 mm or coarser.
Each scene must be complete, with every number finite, bodies in their places, forces that push and energy balanced
within 1 % of what was exchanged; or be refused, or stop, with a reason.
"""

import sys
import time
from collections import Counter
from typing import Any

import numpy as np
from cyclopts import App
from rich.console import Console

from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED, Worker
from tests.stability.random_scenes import random_scene

DURATION = 1.0  # ms
BUDGET = 1e8  # of a random bearing: degrees of freedom times steps of 5 ms

app = App(help=__doc__)


def random_surfaces(rng: np.random.Generator, rollers: int, diameter: float) -> dict[str, list[dict[str, Any]]]:
    """Tables of up to three spalls and waves on any bodies, and of one unequal roller; in proportion to rollers, mm."""
    size = diameter / 10.0

    def body() -> dict[str, Any]:
        name = str(rng.choice(["outer_ring", "inner_ring", "roller"]))
        return {"body": name} | ({"roller": int(rng.integers(0, rollers))} if name == "roller" else {})

    spalls = [
        body() | {
            "angle_deg": 60.0 * k + rng.uniform(-20.0, 20.0), "width_mm": size * rng.uniform(0.2, 2.5),
            "depth_um": size * 10.0 ** rng.uniform(0.0, 3.0),
            "edge_radius_mm": size * float(rng.choice([0.0, 0.02, 0.1, rng.uniform(0.0, 0.3)])),
        }
        for k in range(rng.integers(1, 4))
    ]  # fmt: skip
    waves = [
        body() | {"order": int(rng.integers(1, 25)), "amplitude_um": size * 10.0 ** rng.uniform(-2.0, -0.3)}
        for _ in range(rng.integers(1, 4))
    ]
    unequal = {
        "roller": int(rng.integers(0, rollers)), "diameter_deviation_um": size * rng.uniform(-5.0, 5.0)
    }  # fmt: skip
    return {"spall": spalls, "waviness": waves, "unequal_roller": [unequal]}


def surface_scene(seed: int, number: int) -> dict[str, Any]:
    """Tables of scene `number` of a seed."""
    rng = np.random.default_rng([seed, number, 2])
    if number % 2:
        scene = random_scene(seed, number, DURATION, BUDGET)
        bearing = scene["bearing"]
        return scene | random_surfaces(rng, bearing["rollers"], bearing["roller_diameter_mm"])
    scene = {
        "bearing": {"outer_raceway_diameter_mm": 56.0 + float(rng.choice([0.0, 0.02, -0.01, 0.05]))},
        "operation": {
            "speed_rpm": float(rng.choice([-4500, 1000, 4500, 10000])),
            "radial_load_N": float(rng.choice([0, 500, 2000, 6000])),
        },
        "numerics": {
            "start": str(rng.choice(["equilibrium", "rest"])), "load_ramp_ms": 0.3, "mesh_size_mm": 2.0,
            "duration_ms": DURATION,
        },
    }  # fmt: skip
    return scene | random_surfaces(rng, 13, 10.0)


@app.default
def main(*, count: int = 200, seed: int = 1, first: int = 0) -> None:
    """Run random scenes and say how they ended.

    Parameters
    ----------
    count
        how many scenes
    seed
        of the draw; scene `number` of a seed is always the same
    first
        number of the first scene
    """
    console, worker, outcomes = Console(highlight=False, soft_wrap=True), Worker(), []
    began = time.perf_counter()
    for number in range(first, first + count):
        outcome = worker(seed, number, surface_scene(seed, number))
        outcomes.append(outcome)
        if outcome.ending in (STOPPED, FAILED):
            console.print(f"{number}: {outcome.ending}: {outcome.what}")
    worker.close()
    counts = Counter(outcome.ending for outcome in outcomes)
    console.print(", ".join(f"{counts[ending]} {ending}" for ending in (COMPLETE, REFUSED, STOPPED, FAILED)))
    if off := [outcome.imbalance for outcome in outcomes if outcome.ending == COMPLETE]:
        console.print(
            f"energy imbalance of the complete, of the exchanged energy: median {np.median(off):.1e}, nine in ten "
            f"below {np.quantile(off, 0.9):.1e}, largest {max(off):.1e}"
        )
    for ending in sorted({outcome.what for outcome in outcomes if outcome.ending == REFUSED}):
        console.print(f"refused: {ending}")
    console.print(f"{time.perf_counter() - began:.0f} s of wall time")
    sys.exit(counts[FAILED] > 0)


if __name__ == "__main__":
    app()
