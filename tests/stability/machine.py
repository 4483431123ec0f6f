"""Random bearings in random machines, through the command: `python -m tests.stability.machine --scenes 200`.

Each has some of the tables of what stands around a bearing: damping, cage, housing with a fit, sensor, a shaft's
springs, unbalance, a rotating load, speed and load that change, faults of surfaces; 3 to 60 rollers, or balls, of 3 to
50 mm, at an angle, in rows, with one missing, on a solid shaft, in an outer ring that turns, tilted, with a law of
their own; steel, ceramic, polymer and what lies between, friction up to 1, up to 60 000 rpm and 50 kN
(`machine_scenes`). Run-fem must refuse a scene by name (2), stop with a reason (1), or be complete (0) with a result in
which `judged.faults_of` finds none.
"""

import csv
import os
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import tomli_w
from cyclopts import App
from rich.console import Console

from fem.commands.run_fem import run_main
from tests.measurements import markdown_table
from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED, Lost, Worker
from tests.stability.judged import faults_of
from tests.stability.machine_scenes import MODELS, machine_scene, model_of

TIME_LIMIT = 600.0  # s of processor time of one scene; compiling takes most of it
TOGETHER = 20  # scenes of a set
ENDINGS = {0: COMPLETE, 1: STOPPED, 2: REFUSED}

app = App(help=__doc__)


class Row(NamedTuple):
    """How a scene ended; a line of the file."""

    number: int
    model: str
    ending: str
    what: str
    seconds: float  # of processor time


def tried(seed: int, number: int, sets: int, axial: bool) -> Row:
    """One scene, by the command's function, in this process, which has the kernels of those before."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        tables = machine_scene(seed, number, sets, folder, axial)
        (folder / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
        code, said = _run_fem([str(folder / "scene.toml"), "--output", str(folder / "run.nc"), "--quiet"], folder)
        ending, what = ENDINGS.get(code, FAILED), said
        if code and not said:
            ending = FAILED  # without a reason
        if "Traceback" in said or ending == FAILED:
            ending, what = FAILED, f"exit {code}: {said[-400:]}"
        elif ending == COMPLETE and (faults := faults_of(folder / "run.nc")):
            ending, what = FAILED, "; ".join(faults)
        what = " ".join(what.replace(f"{folder}/", "").split())
    return Row(number, tables["model"], ending, what, time.process_time() - began)


def _run_fem(words: list[str], folder: Path) -> tuple[int, str]:
    """Exit code, and what was said on both outputs."""
    kept = [os.dup(number) for number in (1, 2)]
    with (folder / "said").open("w+b") as output:
        for number in (1, 2):
            os.dup2(output.fileno(), number)
        try:
            code = run_main(words)
        except Exception:
            code, trace = 1, traceback.format_exc()
            output.write(trace.encode())
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, back in zip((1, 2), kept, strict=True):
                os.dup2(back, number)
                os.close(back)
    return code, (folder / "said").read_text(encoding="utf-8", errors="replace")


@app.default
def main(
    *,
    scenes: int = 200,
    seed: int = 1,
    first: int = 0,
    sets: int = 48,
    models: tuple[str, ...] = MODELS,
    axial: bool = False,
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
    axial: each scene has that table
    output: CSV, a line a scene; scenes that it holds are counted, and not run again
    seconds: of wall time, after which no further scene begins
    """
    console, rows, until = Console(), list[Row](), time.monotonic() + seconds
    if output is not None and output.exists():
        with output.open(newline="", encoding="utf-8") as file:
            rows = [Row(int(row[0]), row[1], row[2], row[3], float(row[4])) for row in csv.reader(file)]
    wanted = {*range(first, first + scenes)} - {row.number for row in rows}
    worker, before = Worker(tried), -1
    # a set's scenes together, because the first of them loads its kernels, but not so many that other sets wait long
    for number in sorted(wanted, key=lambda number: (number // (TOGETHER * sets), number % sets, number)):
        model = model_of(seed, number, sets)
        if model not in models:
            continue
        if time.monotonic() > until:
            break
        if number % sets != before:
            worker.close()  # with the memory of a set's kernels and runs
            before = number % sets
        try:
            row = worker.do(seed, number, sets, axial, limit=TIME_LIMIT)
        except Lost as error:
            row = Row(number, model, FAILED, str(error), TIME_LIMIT)
        rows.append(row)
        if row.ending == FAILED:
            console.print(f"{number} {model} {row.what}", soft_wrap=True, markup=False)
        if output is not None:
            with output.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
    worker.close()
    counts = Counter((row.model, row.ending) for row in rows)
    endings = (COMPLETE, REFUSED, STOPPED, FAILED)
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    console.print(markdown_table(["model", *endings], table), soft_wrap=True)
    console.print(f"{len(rows)} scenes, seed {seed}")
    sys.exit(1 if any(row.ending == FAILED for row in rows) else 0)


if __name__ == "__main__":
    app()
