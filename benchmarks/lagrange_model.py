"""The Lagrangian model solved, and the checker on its output: `python -m benchmarks.lagrange_model`, half a minute.

Processor time and energy error of 60 ms of the paper's bearing; then what the checker finds in result files of the
model: differentiation is all that may be left.
"""

import statistics
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.measuring import new_table, timed
from fem.cli import run_main
from lagrange import Trajectory, contact_laws, simulate
from lagrange.scene import read_scene
from residual import evaluate, read_result

REPEATS = 3
DURATION, INTERVAL = 0.06, 1e-5  # s
CHECKED_MS = 10.0
PRELOADED = "bearing.outer_raceway_diameter_mm=55.98"  # 20 µm: no contact opens
CASES = {
    "harris": {},
    "harris, free angles": {"angles": "free"},
    "johnson": {},
    "harris, from rest": {"start": "rest", "load_ramp": 1e-3},
    "harris, from rest, 200 N s/m": {"start": "rest", "load_ramp": 1e-3, "damping": 200.0},
}


def solve(name: str, options: dict) -> tuple[Trajectory, float]:
    """Solve the paper's bearing for 60 ms; the trajectory and the median processor time, s."""
    scene = read_scene()
    bearing = scene.ideal_bearing()
    laws = contact_laws(name.partition(",")[0], bearing)
    solve_once = partial(simulate, bearing, scene.ideal_operation(), laws, DURATION, INTERVAL, **options)
    found = [timed(solve_once) for _ in range(REPEATS)]
    return found[-1][1], statistics.median(seconds for seconds, _ in found)


def solutions() -> Table:
    """Table with a row for each way to solve."""
    headings = ("law and options", "steps", "time, s", "energy error over the contacts' energy")
    table = new_table("60 ms of the paper's bearing, a sample every 10 µs", headings)
    for name, options in CASES.items():
        run, seconds = solve(name, options)
        drift = np.max(np.abs(run.energy_error)) / run.energy_contact[run.time > 1e-3].mean()
        table.add_row(name, str(run.steps), f"{seconds:.2f}", f"{drift:.1e}")
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
