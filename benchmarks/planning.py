"""What it takes to plan a scene after others: `python -m benchmarks.planning`, half a minute.

Processor time from a scene to the first state of its run, the median of some. The bearing stays as it is; each plan has
another load, another speed, a spall elsewhere, or a spall of another width, whose edges are found anew.
"""

import random
from collections.abc import Callable

from benchmarks import timed
from fem.solver.simulate import make_plan
from lagrange.scene.scene import read_scene
from tests.measurements import markdown_table, program

MODELS = {
    "Lagrangian": ("model=lagrange",), "reduced": ("model=reduced",),
    "finite elements, 1 mm": ("numerics.mesh_size_mm=1",), "finite elements, 2 mm": ("numerics.mesh_size_mm=2",),
}  # fmt: skip
PLANS = 25


def spall(body: str, angle: float, width: float) -> dict[str, float | str]:
    found = {"spall.0.body": body, "spall.0.angle_deg": angle, "spall.0.width_mm": width}
    return found | ({"spall.0.roller": 3} if body == "roller" else {})


CHANGES: dict[str, Callable[[random.Random], dict[str, float | str]]] = {
    "load": lambda rng: {"operation.radial_load_N": rng.uniform(800.0, 3000.0)},
    "speed": lambda rng: {"operation.speed_rpm": rng.uniform(1000.0, 4500.0)},
    "spall of a ring, elsewhere": lambda rng: spall("outer_ring", rng.uniform(-40.0, 40.0), 1.0),
    "of a roller, elsewhere": lambda rng: spall("roller", rng.uniform(-180.0, 180.0), 1.0),
    "of a ring, another width": lambda rng: spall("outer_ring", rng.uniform(-40.0, 40.0), rng.uniform(0.6, 2.0)),
    "of a roller, another width": lambda rng: spall("roller", rng.uniform(-180.0, 180.0), rng.uniform(0.6, 2.0)),
}


def main():
    rows, bases = [], [read_scene(None, (*settings, "numerics.duration_ms=5")) for settings in MODELS.values()]
    for base in bases:
        make_plan(base).prepare()
    for name, change in CHANGES.items():
        cells = []
        for base in bases:
            rng = random.Random(f"{name}, {base.model}, {base.numerics.mesh_size_mm}")
            make_plan(base.varied(change(rng))).first_state()
            scenes = [base.varied(change(rng)) for _ in range(PLANS)]
            times = sorted(timed(lambda scene: make_plan(scene).first_state(), scene)[0] for scene in scenes)
            cells.append(f"{1e3 * times[PLANS // 2]:.1f} ({1e3 * times[0]:.1f} … {1e3 * times[-1]:.1f})")
        rows.append([name, *cells])
    words = f"Medians of {PLANS} plans, ms of processor time from a scene to its run's first state (least … most)."
    yield "performance", "Planning one scene after another", words, markdown_table(("another", *MODELS), rows)


if __name__ == "__main__":
    program(__doc__, "benchmarks.planning", main)
