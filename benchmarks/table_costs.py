"""What tables of a scene cost, one at a time: `python -m benchmarks.table_costs`. Each compiles its own time loop.

Tables that are absent cost nothing: what belongs to them is a type of its own in the time loop (`benchmarks.skips`
has what a scene without them leaves out).
"""

import statistics
import tempfile
from functools import partial
from pathlib import Path

from cyclopts import App

from benchmarks.measuring import in_turns, paper_plan, spread, timed
from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import run
from tests.measurements import markdown_table, publish

DURATION_MS = 5.0
HOUSING = ('support.kind="housing"',)
CAGE = ("cage.pocket_clearance_mm=0.1",)
COSTS: dict[str, tuple[str, ...]] = {
    "`[damping]` of contacts": ("damping.contact_N_s_m=1000",),
    "`[cage]` guided by rollers": CAGE,
    "by the inner ring": (*CAGE, 'cage.guidance="inner_ring"', "cage.guidance_clearance_mm=0.1"),
    "by the outer ring": (*CAGE, 'cage.guidance="outer_ring"', "cage.guidance_clearance_mm=0.1"),
    "`[support]`: housing": HOUSING,
    "housing and `[sensor]`": (*HOUSING, "sensor.frequency_Hz=15000"),
    "springs of the shaft": ('operation.shaft="springs"', "operation.shaft_stiffness_N_per_m=1e7"),
    "unbalance": ("operation.unbalance_g_mm=10",),
    "tables of speed and load": (
        'operation.speed_table="{folder}/ramp.csv"',
        'operation.load_table="{folder}/load.csv"',
    ),
    "`[lubricant]`": ("lubricant.viscosity_Pa_s=0.02",),
}
FILES = {"ramp.csv": "time_ms,speed_rpm\n0,5000\n5,5200\n", "load.csv": "time_ms,x_N,y_N\n0,0,-2000\n5,100,-2000\n"}

app = App(help=__doc__)


def seconds_of_a_step(plan: ElementPlan) -> float:
    """Processor time of a run's time loop over its steps."""
    taken, _ = timed(run, plan, lambda block: None)
    return taken / plan.steps


def cost_row(size_mm: float, pairs: int, name: str, folder: Path) -> tuple[str, ...]:
    """Cells of a table's row: time of a step with it over that of the paper's scene, and how long the step is.

    `folder` : of speed and load tables
    """
    duration = f"numerics.duration_ms={DURATION_MS}"
    plain = paper_plan(size_mm, duration)
    with_it = paper_plan(size_mm, duration, *(setting.format(folder=folder) for setting in COSTS[name]))
    calls = {"plain": partial(seconds_of_a_step, plain), "with it": partial(seconds_of_a_step, with_it)}
    for call in calls.values():  # compiles
        call()
    ratios = [found["with it"] / found["plain"] for found in in_turns(calls, pairs)]
    more = f"{100.0 * (statistics.median(ratios) - 1.0):+.0f} %"
    return name, more, spread(ratios, 2), f"{with_it.time_step / plain.time_step:.2f}"


@app.default
def main(*, size_mm: float = 1.0, pairs: int = 7, only: tuple[str, ...] = (), write: bool = False) -> None:
    """Print a table.

    Parameters
    ----------
    size_mm: of the mesh
    pairs: of runs in turns, of which medians are taken
    only: tables whose names hold one of these words
    write: the section of docs/measurements/performance.md
    """
    tables = [name for name in COSTS if not only or any(word in name for word in only)]
    headings = ("table", "a step takes", "lowest … highest ratio", "its length over the plain one")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for file, text in FILES.items():
            (folder / file).write_text(text, encoding="utf-8")
        rows = []
        for name in tables:
            rows.append(cost_row(size_mm, pairs, name, folder))
            print(*rows[-1], sep=" | ", flush=True)
    words = (
        f"5 ms of the paper's scene on {size_mm:g} mm, with and without one table in turns, processor time over steps, "
        "medians."
    )
    command = f"python -m benchmarks.table_costs --pairs {pairs}"
    publish("performance", "Cost of scene tables", command, words, markdown_table(headings, rows), write=write)


if __name__ == "__main__":
    app()
