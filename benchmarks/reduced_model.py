"""Speed of the reduced model beside finite elements: `python -m benchmarks.reduced_model`.

Processor time of the time loop for 60 ms, one thread, the lowest of some runs taken in turns; finite elements of 1 mm
for the first tenth of that. How the reduced model's step grows with the number of rollers.
"""

from math import pi, sin

from benchmarks import in_turns, paper_plan, timed
from fem.solver.row_state import RowState
from fem.solver.solver import Plan
from tests.measurements import markdown_table, program

TURNS = 15
ELEMENTS_MS = 6.0
ROLLERS = (8, 16, 24, 32)


def loop_seconds(plan: Plan) -> float:
    """Processor time of a plan's whole time loop, s."""
    state: RowState = plan.prepare()
    return timed(state.take_steps, plan.n_samples * plan.looks)[0]


def rollers_of(count: int) -> tuple[str, ...]:
    """Settings of a bearing with so many rollers of 10 mm and the paper's ring sections."""
    pitch = 1.1 * 10.0 / sin(pi / count)  # mm, ten per cent of room
    beyond = {"inner_raceway": -10.0, "outer_raceway": 10.0, "bore": -21.0, "outside": 19.0}
    sizes = (f"bearing.{name}_diameter_mm={pitch + more!r}" for name, more in beyond.items())
    usual = "cage.kind=none", "operation.inner_ring_and_shaft_kg=5", "operation.speed_rpm=1500"
    return f"bearing.rollers={count}", *sizes, *usual


def main():
    reduced, elements = paper_plan("model=reduced"), paper_plan(f"numerics.duration_ms={ELEMENTS_MS}")
    calls = {"reduced": lambda: loop_seconds(reduced), "elements": lambda: loop_seconds(elements)}
    found = [dict(turn) for turn in in_turns(calls, TURNS)]
    fast = min(turn["reduced"] for turn in found)
    slow = min(turn["elements"] for turn in found) * (reduced.n_samples - 1) / (elements.n_samples - 1)
    simulated = (reduced.n_samples - 1) * reduced.interval
    print(f"{simulated / fast:.2f} times faster than the bearing, {slow / fast:.0f} times than finite elements")
    rows = (("reduced", f"{fast:.4f} s"), ("finite elements, 1 mm", f"{slow:.2f} s"))
    whole, rows = markdown_table(("60 ms of the paper's bearing", "processor time"), rows), []
    for count in ROLLERS:
        plan = paper_plan("model=reduced", *rollers_of(count))
        step = min(loop_seconds(plan) for _ in range(TURNS)) / (plan.stride * plan.n_samples)
        rows.append((str(count), f"{1e6 * step:.3f}", f"{1e9 * step / count:.1f}"))
    yield "reduced", "Speed", whole, markdown_table(("rollers", "step, µs", "per roller, ns"), rows)


if __name__ == "__main__":
    program(__doc__, "benchmarks.reduced_model", main)
