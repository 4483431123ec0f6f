"""The Lagrangian model solved, and the checker on its output: `python -m benchmarks.lagrange_model`, two minutes.

Processor time of 60 ms of the paper's bearing; how far the first 0.3 ms are from the reference,
`tests.reference.forward_motion`, and with half the step; the energy error. Then what the checker finds in
result files of the model: differentiation is all that may be left.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks import timed
from fem.commands.run_fem import run_main
from fem.solver.rigid.lagrangian import LagrangianPlan, make_plan
from fem.solver.solver import Samples
from lagrange.scene.scene import read_scene
from residual import evaluate, read_result
from tests.measurements import markdown_table, program
from tests.reference.forward_motion import simulate

REPEATS = 7  # of which the fastest counts
DURATION, INTERVAL = 0.06, 1e-5  # s
SAMPLES = round(DURATION / INTERVAL) + 1
JUDGED = 30  # samples that are compared with the reference
CHECKED_MS = 10.0
PRELOADED = "bearing.outer_raceway_diameter_mm=55.98"  # 20 µm: no contact opens
FROM_REST = ("numerics.start=rest", "numerics.load_ramp_ms=1")
SPALL = ('spall=[{body="outer_ring",width_mm=1.0,depth_um=100.0,edge_radius_mm=0.1,angle_deg=270.0}]',)
CASES = {
    "harris": (), "harris, free angles": ("lagrange.angles=free",), "johnson": ("lagrange.law=johnson",),
    "harris, from rest": FROM_REST, "harris, from rest, 200 N s/m": (*FROM_REST, "damping.contact_N_s_m=200"),
    "harris, 4000 N s/m": ("damping.contact_N_s_m=4000",), "harris, spall of 1 mm": SPALL,
    "harris, spall of 1 mm, 200 N s/m": (*SPALL, "damping.contact_N_s_m=200"),
}  # fmt: skip


def solve(plan: LagrangianPlan, count: int) -> Samples:
    """The first samples."""
    state, blocks = plan.first_state(), []
    while state.done < count:
        blocks.append(state.advance(count - state.done).samples)
    return Samples.joined(blocks)


def solutions() -> str:
    """Table with a row for each way to solve."""
    headings = (
        "law and options", "steps", "seconds", "than real time", "off the reference, m", "with half the step",
        "energy error over the contacts' energy",
    )  # fmt: skip
    rows = []
    for name, keys in CASES.items():
        sampled = f"numerics.output_interval_us={1e6 * INTERVAL:g}", f"numerics.duration_ms={1e3 * DURATION:g}"
        plan = make_plan(read_scene(None, ("model=lagrange", *sampled, *keys)))
        exact = simulate(plan.problem, JUDGED * INTERVAL, INTERVAL)
        plan.prepare()
        fast, run = min((timed(solve, plan, SAMPLES) for _ in range(REPEATS)), key=lambda found: found[0])
        off = [
            np.abs(solve(each, JUDGED + 1)["inner_y"] - exact.inner_y).max()
            for each in (plan, replace(plan, stride=2 * plan.stride))
        ]
        drift = np.abs(run.imbalance).max() / run["energy_contact"][run["time"] > 1e-3].mean()
        shown = f"{fast:.3f}", f"{DURATION / fast:.1f}", *(f"{each:.0e}" for each in off), f"{drift:.1e}"
        rows.append((name, str(plan.steps), *shown))
    return markdown_table(headings, rows)


def checked(interval_us: float, *settings: str) -> list[str]:
    """Cells of a row: the error forces that the checker finds in a file of the model, N."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ideal.nc"
        words = [word for setting in (f"numerics.output_interval_us={interval_us}", *settings)
                 for word in ("--set", setting)]  # fmt: skip
        arguments = ["--model", "lagrange", "--duration", str(CHECKED_MS), "--output", str(path), "--quiet", *words]
        assert run_main(arguments) == 0
        found = evaluate(read_result(path))
    cells, mass = [], found.record.operation.inner_mass
    for direction in found.directions:
        rest = np.max(np.abs(direction.budget.error - direction.budget.terms["differentiation"]))
        floor = mass * direction.floor.total
        inner = direction.budget.error[8:-8]  # where the stencil is central
        cells += [f"{np.sqrt(np.mean(inner**2)):.1e}", f"{floor:.1e}", f"{rest:.0e}"]
    return cells


def residuals() -> str:
    """Table with a row for each sampling interval."""
    headings = ("sampling", "x: rms", "stated floor", "all else", "y: rms", "stated floor", "all else")
    rows = (
        (f"{interval:g} µs{words}", *checked(interval, *settings))
        for words, settings in (("", ()), (", preloaded", (PRELOADED,)))
        for interval in (10.0, 5.0, 2.0)
    )
    return markdown_table(headings, rows)


def speed():
    yield "lagrange", "Speed", solutions()
    print("The checker on the model's own output, Harris' law, error forces in N", residuals(), sep="\n\n")


if __name__ == "__main__":
    program(__doc__, "benchmarks.lagrange_model", speed)
