"""Where threads pay: time of a step on one thread and on more, in turns: `python -m benchmarks.threads`."""

import statistics

import numba
from rich.console import Console
from rich.table import Table

from fem.solver.simulate import make_plan, run
from lagrange.scene import read_scene

MESHES_MM = (2.0, 1.0, 0.5, 0.25)
SECONDS = 0.5  # about, of each timing
TURNS = 5


def step_seconds(size_mm: float, threads: int, steps: int) -> float:
    """Wall time of a step of the paper's scene, s, over about so many steps."""
    scene = read_scene(None, _sets(size_mm, threads))
    stride = make_plan(scene).stride
    samples = max(2, round(steps / stride))
    duration = 1e-3 * scene.numerics.output_interval_us * samples
    plan = make_plan(read_scene(None, (*_sets(size_mm, threads), f"numerics.duration_ms={duration!r}")))
    done = run(plan, lambda samples: None)
    return done.wall / done.steps


def _sets(size_mm: float, threads: int) -> tuple[str, str]:
    return f"numerics.mesh_size_mm={size_mm!r}", f"numerics.threads={threads}"


def main() -> None:
    """Measure and print."""
    numbers = [n for n in (1, 2, 4, 8, 16) if n <= numba.config.NUMBA_NUM_THREADS]
    table = Table(title="Time of a step, µs, medians; in brackets over that of one thread")
    for heading in ("mesh", *(f"{n} threads" for n in numbers)):
        table.add_column(heading, justify="right")
    for size_mm in MESHES_MM:
        rough = step_seconds(size_mm, 1, 2000)
        found = {n: [] for n in numbers}
        for _ in range(TURNS):
            for n in numbers:
                found[n].append(step_seconds(size_mm, n, round(SECONDS / rough)))
        medians = {n: statistics.median(times) for n, times in found.items()}
        cells = [f"{1e6 * medians[n]:.2f} ({medians[n] / medians[1]:.2f})" for n in numbers]
        table.add_row(f"{size_mm:g} mm", *cells)
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
