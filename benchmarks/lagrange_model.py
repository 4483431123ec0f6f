"""The Lagrangian model solved: `python -m benchmarks.lagrange_model`.

Processor time of 60 ms of the paper's bearing; how far the first 0.3 ms are from the reference,
`tests.reference.forward_motion`, and with half the step; the energy error.
"""

from dataclasses import replace

import numpy as np

from benchmarks import paper_plan, timed
from fem.solver.rigid.lagrangian import LagrangianPlan
from fem.solver.solver import Samples
from tests.measurements import markdown_table, program
from tests.reference.forward_motion import simulate

REPEATS = 7  # of which the fastest counts
DURATION, INTERVAL = 0.06, 1e-5  # s
SAMPLES = round(DURATION / INTERVAL) + 1
JUDGED = 30  # samples that are compared with the reference
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
        plan = paper_plan("model=lagrange", *sampled, *keys)
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


def speed():
    yield "lagrange", "Speed", solutions()


if __name__ == "__main__":
    program(__doc__, "benchmarks.lagrange_model", speed)
