"""The Lagrangian model solved, and the checker on its output: `python -m benchmarks.lagrange_model`, two minutes.

Processor time of 60 ms of the paper's bearing; how far the first 0.3 ms are from the reference, `lagrange.simulate`,
and with half the step; the energy error. Then what the checker finds in result files of the model:
differentiation is all that may be left.
"""

import tempfile
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.measuring import new_table, timed
from fem.commands.run_fem import run_main
from fem.solver.lagrangian_steps import CompiledIntegration
from lagrange import Trajectory, contact_laws, simulate
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.scene.scene import read_scene
from lagrange.step_size import steps_of
from lagrange.stepping import Simulation, System
from lagrange.surface.faults import Spall
from residual import evaluate, read_result

REPEATS = 7  # of which the fastest counts
DURATION, INTERVAL = 0.06, 1e-5  # s
SAMPLES = round(DURATION / INTERVAL) + 1
JUDGED = 30  # samples that are compared with the reference
CHECKED_MS = 10.0
PRELOADED = "bearing.outer_raceway_diameter_mm=55.98"  # 20 µm: no contact opens
FROM_REST = {"start": "rest", "load_ramp": 1e-3}
SPALL = Spall(body="outer_ring", roller=None, angle=-0.5 * pi, width=1e-3, depth=1e-4, edge_radius=1e-4)
CASES = {
    "harris": {},
    "harris, free angles": {"angles": "free"},
    "johnson": {},
    "harris, from rest": FROM_REST,
    "harris, from rest, 200 N s/m": FROM_REST | {"damping": ContactDamping(constant=200.0)},
    "harris, 4000 N s/m": {"damping": ContactDamping(constant=4000.0)},
    "harris, spall of 1 mm": {"faults": (SPALL,)},
    "harris, spall of 1 mm, 200 N s/m": {"faults": (SPALL,), "damping": ContactDamping(constant=200.0)},
}


def problem_of(name: str, faults: tuple = (), **options) -> Problem:
    """The paper's bearing under the law that a case's name begins with."""
    scene = read_scene()
    bearing = replace(scene.ideal_bearing(), faults=faults)
    laws = contact_laws(name.partition(",")[0], bearing)
    return Problem(bearing=bearing, operation=scene.ideal_operation(), laws=laws, **options)


def solve(problem: Problem, samples: int = SAMPLES, time_step: float | None = None) -> Trajectory:
    """The first samples by compiled steps, from the start to the energies."""
    return Simulation(replace(problem), INTERVAL, CompiledIntegration, time_step).advance(samples)


def steps_alone(problem: Problem) -> float:
    """Processor time of the compiled steps of 60 ms, s."""
    system = System(problem)
    start, steps = system.pack(problem.first_state.state), steps_of(problem, INTERVAL)
    return timed(CompiledIntegration(system, start, INTERVAL, steps, problem.damping).advance, SAMPLES)[0]


def solutions() -> Table:
    """Table with a row for each way to solve."""
    headings = (
        "law and options", "steps", "seconds", "its steps, s", "steps than real time", "off the reference, m",
        "with half the step", "energy error over the contacts' energy",
    )  # fmt: skip
    table = new_table("60 ms of the paper's bearing, a sample every 10 µs", headings)
    for name, options in CASES.items():
        problem = problem_of(name, **options)
        options = {key: value for key, value in options.items() if key != "faults"}
        fast, run = min((timed(solve, problem) for _ in range(REPEATS)), key=lambda found: found[0])
        steps = min(steps_alone(problem) for _ in range(REPEATS))
        exact = simulate(problem.bearing, problem.operation, problem.laws, JUDGED * INTERVAL, INTERVAL, **options)
        off = [
            np.abs(solve(problem, JUDGED + 1, step).inner_y - exact.inner_y).max()
            for step in (None, 0.5 * run.time_step)
        ]
        drift = np.max(np.abs(run.energy_error)) / run.energy_contact[run.time > 1e-3].mean()
        table.add_row(
            name, str(run.steps), f"{fast:.3f}", f"{steps:.3f}", f"{DURATION / steps:.1f}",
            *(f"{each:.0e}" for each in off), f"{drift:.1e}",
        )  # fmt: skip
    return table


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


def residuals() -> Table:
    """Table with a row for each sampling interval."""
    headings = ("sampling", "x: rms", "stated floor", "all else", "y: rms", "stated floor", "all else")
    rows = (
        (f"{interval:g} µs{words}", *checked(interval, *settings))
        for words, settings in (("", ()), (", preloaded", (PRELOADED,)))
        for interval in (10.0, 5.0, 2.0)
    )
    return new_table("The checker on the model's own output, Harris' law, error forces in N", headings, rows)


if __name__ == "__main__":
    console = Console(width=120, highlight=False)
    console.print(solutions())
    console.print(residuals())
