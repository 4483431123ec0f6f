"""A scene does not pay for what it does not need: the same scene with each part left out and put in without effect.

And what rigid bodies, an approximation that a scene may ask for, save and change.
"""

import statistics
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from unittest import mock

import numpy as np
from rich.table import Table

from benchmarks.measuring import in_turns, new_table, paper_plan, spread, timed
from fem.solver.elements.plan import ElementPlan
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.scene.scene import read_scene

NOTHING = 1e-30  # of friction, of gravity, of speed: too little to change a digit, enough to be computed
EVERYWHERE = 1e3  # of a roller's radius: every pair is in reach
DURATION_MS = 5.0
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


def skip_table(size_mm: float, pairs: int) -> Table:
    """Table of the time loop without a part over the one with it, in turns, and of how far their results differ."""
    headings = ("left out", "time over the same scene with it (median)", "lowest … highest", "largest difference")
    table = new_table(
        f"What a scene does not need: {size_mm:g} mm, {DURATION_MS:g} ms, {pairs} pairs in turns", headings
    )
    duration = f"numerics.duration_ms={DURATION_MS}"
    for skip in SKIPS:
        short = paper_plan(size_mm, duration, *skip.scene)
        whole = paper_plan(size_mm, duration, *skip.scene, *skip.whole)
        table.add_row(skip.name, *_compared(short, whole, pairs, skip.forced))
    table.add_section()
    elastic = paper_plan(size_mm, duration)
    for names in RIGID:  # steps may be longer, which the time counts in
        rigid = paper_plan(size_mm, duration, *(f'bodies.{name}="rigid"' for name in names))
        words = " and ".join(name.replace("_", " ") for name in names)
        steps = f"{rigid.time_step / elastic.time_step:.2f} times as long a step"
        table.add_row(f"elasticity of {words}, an approximation; {steps}", *_compared(rigid, elastic, pairs))
    table.add_row("elastic bodies: --model lagrange, an approximation", *_against_lagrange(elastic))
    return table


def _compared(
    short: ElementPlan, whole: ElementPlan, pairs: int, forced: Callable[[], AbstractContextManager] = nullcontext
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


def _run(plan: ElementPlan) -> tuple[float, Samples]:
    """Processor time of the time loop, s, and its samples."""
    blocks = []
    taken, _ = timed(run, plan, blocks.append)
    return taken, Samples.joined(blocks)


def _difference(found: Samples, wanted: Samples, names: tuple[str, ...]) -> float:
    largest = max(np.abs(wanted[name]).max() for name in names)
    return float(max(np.abs(found[name] - wanted[name]).max() for name in names) / largest)


def _against_lagrange(elastic: ElementPlan) -> tuple[str, str, str]:
    """Cells of the Lagrangian model's row: time over the elastic bodies', relative error of the hub's mean height."""
    plan = make_plan(read_scene(None, ("model=lagrange", f"numerics.duration_ms={DURATION_MS}")))
    plan.prepare()
    taken, found = timed(plan.first_state().advance, plan.n_samples)
    runs = [_run(elastic) for _ in range(3)]
    ratio = taken / statistics.median(seconds for seconds, _ in runs)
    worst = abs(float(found.samples["inner_y"].mean()) / float(runs[0][1]["inner_y"].mean()) - 1.0)
    return f"{ratio:.3f}", "", f"{worst:.0e}"
