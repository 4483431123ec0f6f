"""What a scene does not need it does not pay for: the same scene with each part left out and put in without effect.

And what rigid bodies, an approximation that a scene may ask for, save and change.
"""

import statistics
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from unittest import mock

import numpy as np
from rich.table import Table

from fem.solver.finite_elements import ElementPlan
from fem.solver.simulate import make_plan, run
from lagrange import contact_laws, simulate
from lagrange.scene import read_scene

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
        return mock.patch("fem.solver.arrays.REACH", self.reach) if self.reach else nullcontext()


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


# keys of [bodies]
RIGID = (("rollers",), ("inner_ring",), ("outer_ring",), ("inner_ring", "outer_ring"))


def skip_table(size_mm: float, pairs: int) -> Table:
    """Time loop without a part over the one with it, taken in turns, and how far their results differ."""
    table = Table(
        title=f"What a scene does not need: {size_mm:g} mm, {DURATION_MS:g} ms, {pairs} pairs in turns",
        title_justify="left",
    )
    for name in ("left out", "time over the same scene with it (median)", "lowest … highest", "largest difference"):
        table.add_column(name, justify="left" if name == "left out" else "right")
    base = (f"numerics.mesh_size_mm={size_mm}", f"numerics.duration_ms={DURATION_MS}")
    for skip in SKIPS:
        short = make_plan(read_scene(None, (*base, *skip.scene)))
        whole = make_plan(read_scene(None, (*base, *skip.scene, *skip.whole)))
        ratios = []
        whole.prepare()
        short.prepare()
        for _ in range(pairs):
            with skip.forced():
                longer, all_of_it = _timed(whole)
            shorter, without = _timed(short)
            ratios.append(shorter / longer)
        difference = max(_difference(without, all_of_it, names) for names in COMPARED)
        spread = f"{min(ratios):.3f} … {max(ratios):.3f}"
        table.add_row(skip.name, f"{statistics.median(ratios):.3f}", spread, f"{difference:.0e}" if difference else "0")
    table.add_section()
    for names in RIGID:
        _add_rigid(table, base, names, pairs)
    elastic = statistics.median(_timed(short)[0] for _ in range(3))
    rigid, worst = _rigid(size_mm, without)
    words = f"{rigid / elastic:.3f}"
    table.add_row("elastic bodies: --model lagrange, an approximation", words, "", f"{worst:.0e}")
    return table


def _add_rigid(table: Table, base: tuple[str, ...], names: tuple[str, ...], pairs: int) -> None:
    """A row: the scene with rigid bodies against the elastic one. Its steps may be longer, which the time counts in."""
    whole = make_plan(read_scene(None, base))
    plan = make_plan(read_scene(None, (*base, *(f'bodies.{name}="rigid"' for name in names))))
    plan.prepare()
    ratios = []
    for _ in range(pairs):
        longer, elastic = _timed(whole)
        shorter, rigid = _timed(plan)
        ratios.append(shorter / longer)
    worst = max(_difference(rigid, elastic, names) for names in COMPARED)
    words = " and ".join(name.replace("_", " ") for name in names)
    steps = f"{plan.time_step / whole.time_step:.2f} times as long a step"
    table.add_row(
        f"elasticity of {words}, an approximation; {steps}",
        f"{statistics.median(ratios):.3f}",
        f"{min(ratios):.3f} … {max(ratios):.3f}",
        f"{worst:.0e}",
    )


def _timed(plan: ElementPlan) -> tuple[float, dict[str, np.ndarray]]:
    """Processor time of the time loop, s, and its samples."""
    blocks = []
    began = time.thread_time()
    run(plan, blocks.append)
    taken = time.thread_time() - began
    names = [name for together in COMPARED for name in together]
    return taken, {name: np.concatenate([block[name] for block in blocks]) for name in names}


def _difference(found: dict[str, np.ndarray], wanted: dict[str, np.ndarray], names: tuple[str, ...]) -> float:
    largest = max(np.abs(wanted[name]).max() for name in names)
    return float(max(np.abs(found[name] - wanted[name]).max() for name in names) / largest)


def _rigid(size_mm: float, elastic: dict[str, np.ndarray]) -> tuple[float, float]:
    """Processor time of the Lagrangian model of the same scene, s, and its hub's mean height's relative error."""
    scene = read_scene(None, (f"numerics.mesh_size_mm={size_mm}", f"numerics.duration_ms={DURATION_MS}"))
    bearing = scene.ideal_bearing()
    began = time.thread_time()
    found = simulate(bearing, scene.ideal_operation(), contact_laws("harris", bearing), 1e-3 * DURATION_MS, 1e-5)
    taken = time.thread_time() - began
    return taken, abs(float(np.mean(found.inner_y)) / float(elastic["inner_y"].mean()) - 1.0)
