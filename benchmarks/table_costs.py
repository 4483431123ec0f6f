"""What tables of a scene cost, one at a time: `python -m benchmarks.table_costs`. Each compiles its own time loop.

Tables that are absent cost nothing: what belongs to them is a type of its own in the time loop. A scene does not pay
either for what it does not need (`python -m benchmarks.throughput` prints that table): the same scene with each part
left out and put in without effect; and what rigid bodies, an approximation that a scene may ask for, save and change.
"""

import statistics
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest import mock

import numpy as np

from benchmarks import in_turns, paper_plan, spread, timed
from fem.solver.simulate import run
from fem.solver.solver import Plan, Samples
from tests.measurements import markdown_table, program

DURATION_MS = 5.0
HOUSING = ('support.kind="housing"',)
CAGE = ("cage.pocket_clearance_mm=0.1",)
TABLES = 'operation.speed_table="{folder}/ramp.csv"', 'operation.load_table="{folder}/load.csv"'
COSTS: dict[str, tuple[str, ...]] = {
    "`[damping]` of contacts": ("damping.contact_N_s_m=1000",),
    "`[cage]` guided by rollers": CAGE,
    "by the inner ring": (*CAGE, 'cage.guidance="inner_ring"', "cage.guidance_clearance_mm=0.1"),
    "by the outer ring": (*CAGE, 'cage.guidance="outer_ring"', "cage.guidance_clearance_mm=0.1"),
    "`[support]`: housing": HOUSING,
    "housing and `[sensor]`": (*HOUSING, "sensor.frequency_Hz=15000"),
    "springs of the shaft": ('operation.shaft="springs"', "operation.shaft_stiffness_N_per_m=1e7"),
    "unbalance": ("operation.unbalance_g_mm=10",),
    "tables of speed and load": TABLES,
    "`[lubricant]`": ("lubricant.viscosity_Pa_s=0.02",),
}
FILES = {"ramp.csv": "time_ms,speed_rpm\n0,5000\n5,5200\n", "load.csv": "time_ms,x_N,y_N\n0,0,-2000\n5,100,-2000\n"}

NOTHING = 1e-30  # of friction, of gravity, of speed: too little to change a digit, enough to be computed
EVERYWHERE = 1e3  # of a roller's radius: every pair is in reach
COMPARED = (("inner_x", "inner_y"), ("roller_x", "roller_y"), ("inner_force", "outer_force"))  # relative to both


@dataclass(frozen=True)
class Skip:
    """A scene that leaves a part of the work out, and the same one that does it all."""

    name: str
    scene: tuple[str, ...]
    whole: tuple[str, ...] = ()
    reach: float | None = None

    def forced(self) -> AbstractContextManager:
        return mock.patch("fem.solver.elements.arrays.REACH", self.reach) if self.reach else nullcontext()


def _usual(size_mm):
    return f"numerics.mesh_size_mm={size_mm!r}", f"numerics.duration_ms={DURATION_MS}"


def _with(key: str, value: float) -> tuple[str, ...]:
    return (f"{key}={value!r}",)


FRICTION, GRAVITY, SPEED = "contact.friction_coefficient", "operation.gravity_m_s2", "operation.speed_rpm"
SKIPS = (
    Skip("no friction", _with(FRICTION, 0.0), _with(FRICTION, NOTHING)),
    Skip("no gravity", _with(GRAVITY, 0.0), _with(GRAVITY, NOTHING)),
    Skip("shaft at rest", _with(SPEED, 0.0), _with(SPEED, NOTHING)),
    Skip("pairs out of reach, neighbouring rollers among them", (), (), EVERYWHERE),
    Skip("no fields stored (else every 0.1 ms)", (), ("output.fields_every_ms=0.1",)),
    Skip("nothing left out: how exact the ratios are", ()),
)
RIGID = (("rollers",), ("inner_ring",), ("outer_ring",), ("inner_ring", "outer_ring"))  # keys of [bodies]


def skip_table(size_mm: float, pairs: int) -> str:
    """Table of the time loop without a part over the one with it, in turns, and of how far their results differ."""
    headings = ("left out", "time over the same scene with it (median)", "lowest … highest", "largest difference")
    rows, usual = [], _usual(size_mm)
    for skip in SKIPS:
        short, whole = paper_plan(*usual, *skip.scene), paper_plan(*usual, *skip.scene, *skip.whole)
        rows.append((skip.name, *_compared(short, whole, pairs, skip.forced)))
    elastic = paper_plan(*usual)
    for names in RIGID:  # steps may be longer, which the time counts in
        rigid = paper_plan(*usual, *(f'bodies.{name}="rigid"' for name in names))
        words = " and ".join(name.replace("_", " ") for name in names)
        steps = f"{rigid.time_step / elastic.time_step:.2f} times as long a step"
        rows.append((f"elasticity of {words}, an approximation; {steps}", *_compared(rigid, elastic, pairs)))
    rigid = paper_plan(*usual, "model=lagrange")
    rows.append(("elastic bodies: --model lagrange, an approximation", *_compared(rigid, elastic, pairs)))
    return markdown_table(headings, rows)


def _compared(
    short: Plan, whole: Plan, pairs: int, forced: Callable[[], AbstractContextManager] = nullcontext
) -> tuple[str, str, str]:
    """Cells of a row: median and spread of the ratios of the two plans' times, largest difference of their results."""
    whole.prepare()
    short.prepare()

    def run_whole() -> tuple[float, Samples]:
        with forced():
            return _run(whole)

    ratios = []
    for found in in_turns({"whole": run_whole, "short": partial(_run, short)}, pairs):
        (longer, wanted), (shorter, got) = found["whole"], found["short"]
        ratios.append(shorter / longer)
    difference = max(_difference(got, wanted, names) for names in COMPARED)
    return f"{statistics.median(ratios):.3f}", spread(ratios), f"{difference:.0e}" if difference else "0"


def _run(plan: Plan) -> tuple[float, Samples]:
    """Processor time of the time loop, s, and its samples."""
    blocks = []
    taken, _ = timed(run, plan, blocks.append)
    return taken, Samples.joined(blocks)


def _difference(found: Samples, wanted: Samples, names: tuple[str, ...]) -> float:
    largest = max(np.abs(wanted[name]).max() for name in names)
    return float(max(np.abs(found[name] - wanted[name]).max() for name in names) / largest)


def seconds_of_a_step(plan: Plan) -> float:
    """Processor time of a run's time loop over its steps."""
    taken, _ = timed(run, plan, lambda block: None)
    return taken / plan.steps


def cost_row(size_mm: float, pairs: int, name: str, folder: Path) -> tuple[str, ...]:
    """Cells of a table's row: time of a step with it over that of the paper's scene, and how long the step is.

    `folder` : of speed and load tables
    """
    usual = _usual(size_mm)
    plain, with_it = paper_plan(*usual), paper_plan(*usual, *(each.format(folder=folder) for each in COSTS[name]))
    calls = {"plain": partial(seconds_of_a_step, plain), "with it": partial(seconds_of_a_step, with_it)}
    for call in calls.values():  # compiles
        call()
    ratios = [found["with it"] / found["plain"] for found in in_turns(calls, pairs)]
    more = f"{100.0 * (statistics.median(ratios) - 1.0):+.0f} %"
    return name, more, spread(ratios, 2), f"{with_it.time_step / plain.time_step:.2f}"


def main(*, size_mm: float = 1.0, pairs: int = 7, only: tuple[str, ...] = ()):
    """Print a table.

    Parameters
    ----------
    size_mm: of the mesh
    pairs: of runs in turns, of which medians are taken
    only: tables whose names hold one of these words
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
    yield "performance", "Cost of scene tables", words, markdown_table(headings, rows)


if __name__ == "__main__":
    program(__doc__, "benchmarks.table_costs", main)
