"""What --dry-run expects of a run beside what it takes: `python -m benchmarks.expected_time`.

Processor time of the time loop, each scene once, after a run that compiles. `by a piece` is what --dry-run tells where
the loop is compiled; `by constants` what it tells before, with the pace that a machine's first runs leave: here the
median of a model's scenes.
"""

import statistics
import time

from benchmarks import new_table
from fem.solver.compiling import pace, seconds_by_trial
from fem.solver.simulate import make_plan, size_of_block
from lagrange.scene.scene import read_scene
from tests.measurements import program

NU206, NU216 = 'bearing={designation="NU206"}', 'bearing={designation="NU216"}'
COARSE = "numerics.mesh_size_mm=2", "numerics.duration_ms=10"
SCENES = {
    "fem": {
        "2 mm, 20 ms": ("numerics.mesh_size_mm=2", "numerics.duration_ms=20"),
        "1 mm, 10 ms": ("numerics.duration_ms=10",),
        "0.5 mm, 3 ms": ("numerics.mesh_size_mm=0.5", "numerics.duration_ms=3"),
        "NU 206, 2 mm, 10 ms": (NU206, *COARSE), "NU 216, 2 mm, 10 ms": (NU216, *COARSE),
        "frictionless, 2 mm, 10 ms": ("contact.friction_coefficient=0", *COARSE),
    },
    "reduced": {
        "200 ms": ("numerics.duration_ms=200",),
        "NU 206, 200 ms": (NU206, "numerics.duration_ms=200"),
        "NU 216, 100 ms": (NU216, "numerics.duration_ms=100"),
    },
    "lagrange": {
        "200 ms": ("numerics.duration_ms=200",),
        "NU 206, 200 ms": (NU206, "numerics.duration_ms=200"),
        "Johnson's law, 100 ms": ("lagrange.law=johnson", "numerics.duration_ms=100"),
    },
}  # fmt: skip


def measured(model: str, settings: tuple[str, ...], rest: float) -> tuple[float, float, float]:
    """Time to expect by the plan's own constants and by a piece of the run, and that of the run, s of the processor."""
    plan = make_plan(read_scene(None, (f"model={model}", *settings)))
    plan.prepare()
    by_piece = seconds_by_trial(plan)
    state, size = plan.first_state(), 1
    while state.done < plan.n_samples:
        time.sleep(rest)
        before, done = state.processor, state.done
        if state.advance(min(size, plan.n_samples - done)).trouble is not None:
            raise RuntimeError(f"{model}, {settings}: the run fails")
        size = size_of_block(size, state.done - done, state.processor - before)
    return plan.expected_seconds / pace(model), by_piece, state.processor


def main(*models: str, rest: float = 0.0):
    """Measure models, all of them if none is named.

    Parameters
    ----------
    rest: seconds of sleep between blocks of samples, for a machine that counts to a busy process what others take
    """
    rows, worst = [], 1.0
    for model in models or SCENES:
        found = {name: measured(model, settings, rest) for name, settings in SCENES[model].items()}
        own = statistics.median(took / constants for constants, _, took in found.values())
        for name, (constants, piece, took) in found.items():
            worst = max(worst, piece / took, took / piece)
            rows.append((f"{model}, {name}", f"{took:.2g}", f"{piece:.2g}", f"{piece / took:.2f}",
                         f"{own * constants / took:.2f}"))  # fmt: skip
    headings = ("scene", "took, s", "by a piece, s", "over what it took", "by constants, over that")
    table = new_table("Time to expect of the time loop, processor time", headings, rows)
    yield "performance", "Estimated run time", table
    print(f"by a piece off by a factor of {worst:.2f} at most")


if __name__ == "__main__":
    program(__doc__, "benchmarks.expected_time", main)
