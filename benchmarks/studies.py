"""What a study adds to its points, and what a second process gives: `python -m benchmarks.studies`, four minutes.

In this process: processor time of everything a study does with a point (validating, naming, keeping, collecting) but
for its simulation. With a process of its own: wall time from point to point once it has solved its first, less the time
that a point takes there. Two processes against one: points a second, of points that take about one; on a quiet machine
with two processors or more.
"""

import time
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from cyclopts import App

from fem.study import solving
from fem.study.folder import Folder, write_dataset
from fem.study.solving import Points, Processes, Solved, Wanted, checked_points, solve, solve_all
from fem.study.study_file import design_of, read_study
from tests.measurements import markdown_table

STUDY = """
[fixed]
model = "{model}"
"numerics.duration_ms" = {duration}
[parameters]
"operation.radial_load_N" = {{ from = 500.0, to = 3000.0, count = {count} }}
[keep]
quantities = ["hub_mean_y", "largest_force"]
signals = ["inner_ay"]
"""
SHORT, OF_A_SECOND = ("lagrange", 1.0), ("reduced", 200.0)


def points_of(folder: Path, model: str, duration: float, count: int) -> Points:
    path = folder / "study.toml"
    path.write_text(STUDY.format(model=model, duration=duration, count=count), encoding="utf-8")
    study = read_study(path)
    return checked_points(study, design_of(study))


def in_process(place: Path, count: int) -> dict[str, float]:
    """Processor time of a study's parts, s a point."""
    spent: dict[str, float] = {}
    simulated = solving.simulate

    @contextmanager
    def clocked(name: str):
        began = time.process_time()
        yield
        spent[name] = spent.get(name, 0.0) + time.process_time() - began

    def simulate(*given, **how):
        with clocked("simulation"):
            return simulated(*given, **how)

    with clocked("scenes validated and named"):
        points = points_of(place, *SHORT, count)
    folder, wanted = Folder(path=place / "study"), Wanted(keep=points.study.keep, seconds=600.0)
    folder.begin(points)
    solve(points.scene(0), wanted)  # compiles
    solving.simulate = simulate
    try:
        for i, digest in enumerate(points.digests):
            with clocked("solved but for its simulation"):
                solved = solve(points.scene(i), wanted)
            with clocked("kept"):
                folder.add(digest, solved)
    finally:
        solving.simulate = simulated
    with clocked("collected into the dataset"):
        write_dataset(points, folder)
    spent["solved but for its simulation"] -= spent["simulation"]
    return {name: seconds / count for name, seconds in spent.items()}


def in_processes(points: Points, count: int, warm: int) -> tuple[float, float]:
    """Wall time a point and the mean of what a point takes, s; of those that end after so many have."""
    ended: list[tuple[float, float]] = []

    def add(i: int, solved: Solved) -> None:
        assert solved.status == solving.COMPLETE, solved.text
        ended.append((time.perf_counter(), solved.seconds))

    scenes = ((i, points.scene(i)) for i in range(len(points)))
    solve_all(Processes(count, Wanted(keep=points.study.keep, seconds=600.0)), scenes, add, lambda: False)
    counted = ended[warm:]
    return (ended[-1][0] - ended[warm - 1][0]) / len(counted), sum(taken for _, taken in counted) / len(counted)


app = App(help=__doc__)


@app.default
def main(*, points: int = 300) -> None:
    """Measure and print, with so many short points, and a seventh of it long ones."""
    with TemporaryDirectory(prefix="studies-") as name:
        place = Path(name)
        spent = in_process(place, points)
        rows = [*spent.items(), ("what the study adds", sum(spent.values()) - spent["simulation"])]
        cells = [(name, f"{1e3 * seconds:.2f}") for name, seconds in rows]
        print(f"{points} short points in this process", markdown_table(("", "ms a point"), cells), sep="\n\n")
        each, taken = in_processes(points_of(place, *SHORT, points), 1, max(1, points // 5))
        print(
            f"one process: {1e3 * each:.1f} ms from point to point, of which {1e3 * taken:.1f} ms in its own call: "
            f"{1e3 * (each - taken):.1f} ms added"
        )
        long = points_of(place, *OF_A_SECOND, max(8, points // 7))
        (one, taken), (two, together) = (in_processes(long, count, 2 * count) for count in (1, 2))
        print(
            f"{len(long)} points of {taken:.2f} s (beside each other {together:.2f} s): {one:.3f} s a point with one "
            f"process, {two:.3f} s with two, {one / two:.2f} times as many"
        )


if __name__ == "__main__":
    app()
