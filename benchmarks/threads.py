"""Where threads pay: the time of a step on one thread and on more, in turns: `python -m benchmarks.threads`."""

import statistics
from functools import partial

import numba
from rich.console import Console

from benchmarks.measuring import in_turns, new_table, paper_plan
from fem.solver.simulate import run

MESHES_MM = (2.0, 1.0, 0.5, 0.25)
SECONDS = 0.5  # about, of each timing
TURNS = 5


def step_seconds(size_mm: float, threads: int, steps: int) -> float:
    """Wall time of a step of the paper's scene, s, over about so many steps."""
    threaded = f"numerics.threads={threads}"
    plan = paper_plan(size_mm, threaded)
    duration = 1e3 * plan.interval * max(2, round(steps / plan.stride))
    done = run(paper_plan(size_mm, threaded, f"numerics.duration_ms={duration!r}"), lambda samples: None)
    return done.wall / done.steps


def main() -> None:
    """Measure and print."""
    numbers = [n for n in (1, 2, 4, 8, 16) if n <= numba.config.NUMBA_NUM_THREADS]
    title = "Time of a step, µs, medians; in brackets over that of one thread"
    table = new_table(title, ("mesh", *(f"{n} threads" for n in numbers)))
    for size_mm in MESHES_MM:
        steps = round(SECONDS / step_seconds(size_mm, 1, 2000))
        calls = {n: partial(step_seconds, size_mm, n, steps) for n in numbers}
        found = list(in_turns(calls, TURNS))
        medians = {n: statistics.median(times[n] for times in found) for n in numbers}
        cells = [f"{1e6 * medians[n]:.2f} ({medians[n] / medians[1]:.2f})" for n in numbers]
        table.add_row(f"{size_mm:g} mm", *cells)
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
