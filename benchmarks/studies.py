"""What a study adds to its points, and what a second worker gives: `python -m benchmarks.studies`, four minutes.

In this process: processor time of everything a study does with a point (validating, naming, keeping, collecting) but
for its simulation. With dask: wall time from point to point once a worker has solved its first, less the time that a
point takes there. Two workers against one: points a second, of points that take about one; on a quiet machine with
two processors or more. `--points N` takes fewer.
"""

import argparse
import time
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from benchmarks.measuring import new_table
from fem.study import solving
from fem.study.dataset import write_dataset
from fem.study.folder import Folder
from fem.study.sampling import design_of
from fem.study.solving import Points, Solved, Wanted, checked_points, solve
from fem.study.study_file import read_study
from fem.study.workers import solve_on_cluster

POINTS, LONG_POINTS = 300, 40
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


def wanted_of(points: Points) -> Wanted:
    keep = points.study.keep
    return Wanted(quantities=tuple(keep.quantities), signals=tuple(keep.signals), signal_rate=None, seconds=600.0,
                  runs=False)  # fmt: skip


@contextmanager
def clocked(found: dict[str, float], name: str):
    began = time.process_time()
    yield
    found[name] = found.get(name, 0.0) + time.process_time() - began


def in_process(place: Path, count: int) -> dict[str, float]:
    """Processor time of a study's parts, s a point."""
    found: dict[str, float] = {}
    simulated = solving.simulate

    def simulate(*given, **how):
        with clocked(found, "simulation"):
            return simulated(*given, **how)

    with clocked(found, "scenes validated and named"):
        points = points_of(place, *SHORT, count)
    folder, wanted = Folder(path=place / "study"), wanted_of(points)
    folder.begin(points)
    solve(points.scene(0), wanted)  # compiles
    solving.simulate = simulate
    try:
        for i, digest in enumerate(points.digests):
            with clocked(found, "solved but for its simulation"):
                solved = solve(points.scene(i), wanted)
            with clocked(found, "kept"):
                folder.add(digest, solved)
    finally:
        solving.simulate = simulated
    with clocked(found, "collected into the dataset"):
        write_dataset(points, folder)
    found["solved but for its simulation"] -= found["simulation"]
    return {name: seconds / count for name, seconds in found.items()}


def with_dask(points: Points, workers: int, warm: int) -> tuple[float, float]:
    """Wall time a point and the mean of what a point takes, s; of those that end after so many have."""
    ended: list[tuple[float, float]] = []

    def add(i: int, solved: Solved) -> None:
        assert solved.status == solving.COMPLETE, solved.text
        ended.append((time.perf_counter(), solved.seconds))

    scenes = ((i, points.scene(i)) for i in range(len(points)))
    solve_on_cluster(workers, scenes, wanted_of(points), add, lambda: False)
    counted = ended[warm:]
    return (ended[-1][0] - ended[warm - 1][0]) / len(counted), sum(taken for _, taken in counted) / len(counted)


def in_folder(measure: Callable[[Path], None]) -> None:
    with TemporaryDirectory(prefix="studies-") as folder:
        measure(Path(folder))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=POINTS, help="short points; of long ones a seventh of it")
    count = parser.parse_args().points
    console = Console(highlight=False)

    def overheads(place: Path) -> None:
        found = in_process(place, count)
        table = new_table(f"{count} short points in this process", ("", "ms a point"))
        for name, seconds in found.items():
            table.add_row(name, f"{1e3 * seconds:.2f}")
        own = sum(seconds for name, seconds in found.items() if name != "simulation")
        table.add_row("what the study adds", f"{1e3 * own:.2f}")
        console.print(table)
        each, taken = with_dask(points_of(place, *SHORT, count), 1, count // 5)
        console.print(
            f"with dask, one worker: {1e3 * each:.1f} ms from point to point, of which {1e3 * taken:.1f} ms in the "
            f"worker's own call: {1e3 * (each - taken):.1f} ms added"
        )

    def speed_up(place: Path) -> None:
        points = points_of(place, *OF_A_SECOND, max(8, count * LONG_POINTS // POINTS))
        (one, taken), (two, together) = (with_dask(points, workers, 2 * workers) for workers in (1, 2))
        console.print(
            f"{len(points)} points of {taken:.2f} s (beside each other {together:.2f} s): {one:.3f} s a point with one "
            f"worker, {two:.3f} s with two, {one / two:.2f} times as many"
        )

    in_folder(overheads)
    in_folder(speed_up)


if __name__ == "__main__":
    main()
