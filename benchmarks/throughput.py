"""How near the time loop is to the machine's limit: `python -m benchmarks.throughput`.

One thread, its processor time, medians, the paper's scene. Close other programs: they take cache and clock.
"""

import os
import sys
import time
from dataclasses import dataclass

import numpy as np
from cyclopts import App
from rich.console import Console
from rich.table import Table

from benchmarks import footprint, machine, phases
from benchmarks.measuring import new_table, paper_plan, timed
from benchmarks.skips import skip_table
from fem.solver.elements.plan import ElementPlan
from tests.measurements import publish

SIZES_MM = (2.0, 1.0, 0.5, 0.25)
FULL_S = 0.06
KERNELS = ("rollers' forces", "rings' forces")


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """Measurements on one mesh."""

    size_mm: float
    plan: ElementPlan
    setup: float  # s
    phases: dict[str, float]  # s per step
    step: float  # s
    work: phases.Work
    state_bytes: int

    @property
    def freedom(self) -> int:
        return self.plan.model.degrees_of_freedom

    @property
    def full(self) -> float:
        """Time for 0.06 s of the bearing, s."""
        return FULL_S / self.plan.time_step * self.step


def measure(size_mm: float) -> Mesh:
    """Time one mesh of the paper's scene."""
    setup, plan = timed(paper_plan, size_mm, clock=time.perf_counter)
    plan.prepare()
    return Mesh(
        size_mm=size_mm,
        plan=plan,
        setup=setup,
        phases=phases.time_phases(plan),
        step=phases.step_seconds(plan),
        work=phases.least_work(plan),
        state_bytes=phases.state_bytes(plan),
    )


def ceilings(found: machine.Machine) -> Table:
    title = "Ceilings of this machine, one thread, medians"
    table = new_table(title, ("", "size", "read, GB/s", "read and write, GB/s"))
    table.add_row("multiply-adds in registers", "", f"{1e-9 * found.fma_rate:.1f} G/s", "")
    for level in found.read_rate:
        size = found.cache_bytes.get(level)
        room = f"{size >> 10} KiB" if size else ""
        table.add_row(level, room, f"{1e-9 * found.read_rate[level]:.0f}", f"{1e-9 * found.update_rate[level]:.0f}")
    return table


def phase_table(meshes: list[Mesh], found: machine.Machine) -> Table:
    title = "Time of a step, µs (ns per degree of freedom)"
    table = new_table(title, ("phase", *(f"{mesh.size_mm:g} mm" for mesh in meshes)))

    def row(name, values, digits=2, style=None):
        cells = [f"{1e6 * v:.{digits}f} ({1e9 * v / m.freedom:.3f})" for v, m in zip(values, meshes, strict=True)]
        table.add_row(name, *cells, style=style)

    for name in meshes[0].phases:
        row(name, [m.phases[name] for m in meshes])
    table.add_section()
    row("sum of the phases", [sum(m.phases.values()) for m in meshes])
    row("whole step, measured", [m.step for m in meshes], style="bold")
    floors = [m.work.floor(found) for m in meshes]
    row("floor", [f[0] for f in floors])
    table.add_row("ceiling that binds", *[f[1] for f in floors])
    table.add_row("whole step over floor", *[f"{m.step / f[0]:.1f}" for m, f in zip(meshes, floors, strict=True)])
    for name in KERNELS:
        shares = [m.work.operations[name] / m.phases[name] for m in meshes]
        table.add_row(
            f"{name}: share of the arithmetic ceiling", *[f"{100 * s / found.fma_rate:.0f} %" for s in shares]
        )
    return table


def size_table(meshes: list[Mesh]) -> Table:
    headings = (
        "mesh, mm", "degrees of freedom", "step, ns", "ns/DOF/step", "0.06 s take, s", "set-up, s", "B/DOF"
    )  # fmt: skip
    rows = (
        (
            f"{m.size_mm:g}", f"{m.freedom}", f"{1e9 * m.plan.time_step:.1f}", f"{1e9 * m.step / m.freedom:.2f}",
            f"{m.full:.2f}", f"{m.setup:.1f}", f"{m.state_bytes / m.freedom:.0f}",
        )
        for m in meshes
    )  # fmt: skip
    return new_table("The paper's scene", headings, rows)


def exponent(meshes: list[Mesh]) -> float:
    """Exponent with which the time for a fixed simulated time grows over the degrees of freedom."""
    return float(np.polyfit(np.log([m.freedom for m in meshes]), np.log([m.full for m in meshes]), 1)[0])


COMMAND = "python -m benchmarks.throughput"

app = App(help=__doc__)


@app.default
def main(*, sizes: tuple[float, ...] = SIZES_MM, pairs: int = 7, skips: bool = True, write: bool = False) -> None:
    """Measure ceilings, phases, growth and what is skipped.

    Parameters
    ----------
    sizes
        surface node distances, mm
    pairs
        pairs of runs per line of the skip table
    skips
        measure the skip table
    write
        the sections of docs/measurements/performance.md
    """
    console = Console(width=None if sys.stdout.isatty() else 150, highlight=False)
    console.print(f"one thread of {os.cpu_count()}")
    found = machine.measure()
    publish("performance", "Ceilings of the machine", COMMAND, ceilings(found), write=write)
    meshes = [measure(size) for size in sizes]
    publish("performance", "Time of a step", COMMAND, phase_table(meshes, found), write=write)
    rows = []
    if len(meshes) > 1:
        fine = [m for m in meshes if m.size_mm <= 1.0]
        power = "time grows as DOF to the power, all meshes (explicit limit in 2D: 1.5)"
        rows.append((power, f"{exponent(meshes):.2f}"))
        if len(fine) > 1 and len(fine) < len(meshes):
            rows.append(("from 1 mm down", f"{exponent(fine):.2f}"))
        few, many = (footprint.peak_bytes(size) for size in (max(sizes), min(sizes)))
        each = (many[1] - few[1]) / (many[0] - few[0])
        rows.append((f"peak memory of a process at {max(sizes):g} mm, MB", f"{few[1] / 1e6:.0f}"))
        rows.append(("memory per degree of freedom more, B", f"{each:.0f}"))
    wall, processor = footprint.start_seconds()
    rows.append(("a whole run of one sample at 1 mm, caches warm, s", f"{wall:.2f}"))
    rows.append(("the same, processor time, s", f"{processor:.2f}"))
    growth = new_table("Growth and memory", ("quantity", "found"), rows)
    publish("performance", "Growth with the mesh", COMMAND, size_table(meshes), growth, write=write)
    if skips:
        publish("performance", "Cost of physics", COMMAND, skip_table(1.0, pairs), write=write)


if __name__ == "__main__":
    app()
