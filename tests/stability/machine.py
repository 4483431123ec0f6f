"""Random bearings in random machines, through the executable: `python -m tests.stability.machine --scenes 200`.

Each has some of the tables of what stands around a bearing: damping, cage, housing with a fit, sensor, a shaft's
springs, unbalance, a rotating load, speed and load that change, a spall, waviness; 3 to 60 rollers of 3 to 50 mm,
steel, ceramic, polymer and what lies between, friction up to 1, up to 60 000 rpm and 50 kN (`machine_scenes`). Run-fem
must refuse a scene by name (2), stop with a reason (1), or be complete (0) with a result in which `judged.faults_of`
finds none.
"""

import csv
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import tomli_w
from cyclopts import App
from rich.console import Console

from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED
from tests.stability.judged import faults_of
from tests.stability.machine_scenes import MODELS, machine_scene, model_of

TIME_LIMIT = 600.0  # s of processor time of one scene; compiling takes most of it
ENDINGS = {0: COMPLETE, 1: STOPPED, 2: REFUSED}

app = App(help=__doc__)


def tried(seed: int, number: int, sets: int, models: tuple[str, ...]) -> tuple[str, str, str, float] | None:
    """Model, ending, what it said, seconds; None of a scene of another model."""
    model = model_of(seed, number, sets)
    if model not in models:
        return None
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        tables = machine_scene(seed, number, sets, folder)
        (folder / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
        done = forked.run(["run-fem", "scene.toml", "--output", "run.nc", "--quiet"], folder, TIME_LIMIT)
        ending, what = ENDINGS.get(done.code, FAILED), done.said
        if done.code and not done.said:
            ending = FAILED  # without a reason
        if "Traceback" in done.said or ending == FAILED:
            ending, what = FAILED, f"exit {done.code}: {done.said[-400:]}"
        elif ending == COMPLETE and (faults := faults_of(folder / "run.nc")):
            ending, what = FAILED, "; ".join(faults)
    return model, ending, " ".join(what.split()), time.perf_counter() - began


@app.default
def main(
    *,
    scenes: int = 200,
    seed: int = 1,
    first: int = 0,
    sets: int = 48,
    models: tuple[str, ...] = MODELS,
    output: Path | None = None,
    seconds: float = 1e9,
) -> None:
    """Run scenes and print how they ended.

    Parameters
    ----------
    scenes: how many
    seed: of all
    first: number of the first scene
    sets: of tables, each of which compiles a time loop of its own
    models: only scenes of these; the others are passed over
    output: CSV, a line a scene
    seconds: of wall time, after which no further scene begins
    """
    console, rows, until = Console(), [], time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as place:
        forked.preload([["run-fem", "--model", "lagrange", "--duration", "0.1", "--quiet"]], Path(place))
    for number in range(first, first + scenes):
        if time.monotonic() > until:
            break
        ended = tried(seed, number, sets, models)
        if ended is None:
            continue
        row = (number, *ended)
        rows.append(row)
        if row[2] == FAILED:
            console.print(f"{number} {row[1]} {row[3]}", soft_wrap=True, markup=False)
        if output is not None:
            with output.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
    counts = Counter((row[1], row[2]) for row in rows)
    endings = (COMPLETE, REFUSED, STOPPED, FAILED)
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    console.print(markdown_table(["model", *endings], table), soft_wrap=True)
    console.print(f"{len(rows)} scenes, seed {seed}")
    sys.exit(1 if any(row[2] == FAILED for row in rows) else 0)


if __name__ == "__main__":
    app()
