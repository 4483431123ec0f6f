"""Run time against error on the paper's bearing: `python -m benchmarks.work_precision`, a quarter of an hour.

Three models of one scene: the rigid bodies of Lagrange's equations, finite elements with contacts below the grid, and
finite elements that resolve the contacts. Static error against the exact series; dynamic errors against the finest mesh
below the grid. Times are the time loop's, one thread, median of repeats, scaled from a short record to 60 ms: close
other programs. Writes work_precision.md and work_precision.png.
"""

import statistics
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cyclopts import App
from rich.console import Console

from benchmarks.measuring import markdown_table, new_table, paper_plan, timed
from fem.solver.simulate import make_plan, run
from fem.statics.exact_statics import exact_statics
from fem.statics.quantities import moving_quantities
from fem.statics.static_error import static_error
from lagrange import contact_laws, simulate, static_equilibrium
from lagrange.scene import read_scene

DOCS = Path(__file__).parent.parent / "docs"
SIZES_MM = (3.0, 2.0, 1.5, 1.0, 0.75, 0.5, 0.25)
RESOLVED_MM = (0.03, 0.024)
LAWS = ("harris", "iso16281", "johnson")
RECORD_MS, RESOLVED_RECORD_MS = 4.0, 0.01
FULL_MS = 60.0
REPEATS = 3
PAPER_CPU_HOURS = 300.0  # Rubio et al. 2007: "at least 300 hours of CPU simulation time"
COMPARED = ("hub_mean_y", "hub_std_x", "largest_force")


@dataclass(frozen=True, kw_only=True)
class Point:
    """Cost and results of one model."""

    kind: str  # lagrange, subgrid, resolved
    name: str
    degrees_of_freedom: int
    step_ns: float
    seconds: float  # for 60 ms
    static_error: float
    moving: dict[str, float] | None  # by name of the quantity; None: the record is too short


def finite_elements(kind: str, size_mm: float) -> Point:
    """Run the scene on one mesh."""
    record = RECORD_MS if kind == "subgrid" else RESOLVED_RECORD_MS
    interval = "numerics.output_interval_us=1" if kind == "resolved" else "numerics.output_interval_us=10"
    plan = paper_plan(size_mm, f"contact.model={kind}", f"numerics.duration_ms={record}", interval)
    walls = []
    for _ in range(REPEATS if kind == "subgrid" and size_mm > 0.3 else 1):
        kept = []
        walls.append(run(plan, kept.append).wall)
    samples = {name: np.concatenate([block[name] for block in kept]) for name in kept[0].values}
    moving = {each.name: each.value for each in moving_quantities(samples)}
    return Point(
        kind=kind,
        name=f"{size_mm:g} mm" + (", contacts resolved" if kind == "resolved" else ""),
        degrees_of_freedom=plan.model.degrees_of_freedom,
        step_ns=1e9 * plan.time_step,
        seconds=statistics.median(walls) * FULL_MS / record,
        static_error=static_error(plan.model, plan.operation).hub,
        moving=moving if kind == "subgrid" else None,
    )


def rigid_bodies(law: str) -> Point:
    """Solve Lagrange's equations under one contact law."""
    scene = read_scene()
    bearing, how = scene.ideal_bearing(), scene.ideal_operation()
    laws = contact_laws(law, bearing)
    solved = [
        timed(simulate, bearing, how, laws, 1e-3 * FULL_MS, 1e-5, clock=time.perf_counter) for _ in range(REPEATS)
    ]
    found = solved[-1][1]
    first = found.time <= 1e-3 * RECORD_MS * (1.0 + 1e-9)
    samples = {
        name: getattr(found, name)[first] for name in ("time", "inner_x", "inner_y", "inner_force", "roller_theta")
    }
    exact = exact_statics(bearing, how.radial_load, how.first_roller_angle)
    still = static_equilibrium(bearing, how, laws, roller_mass=0.0)
    return Point(
        kind="lagrange",
        name=f"rigid bodies, {law}",
        degrees_of_freedom=bearing.n_rollers + 2,
        step_ns=1e9 * found.time_step,
        seconds=statistics.median(wall for wall, _ in solved),
        static_error=abs(still.y / float(exact.hub[1]) - 1.0),
        moving={each.name: each.value for each in moving_quantities(samples)},
    )


def rows(points: list[Point], finest: Point) -> list[list[str]]:
    """Cells of the table's rows; dynamic errors against the finest mesh below the grid."""

    def off(point: Point, name: str) -> str:
        if point is finest:
            return "reference"
        if point.moving is None:
            return "-"
        return f"{100 * abs(point.moving[name] / finest.moving[name] - 1):.2g} %"

    return [
        [
            p.name, f"{p.degrees_of_freedom}", f"{p.step_ns:.3g}", _readable(p.seconds),
            f"{100 * p.static_error:.2g} %", *(off(p, name) for name in COMPARED),
        ]
        for p in points
    ]  # fmt: skip


def _readable(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds < 3600.0 else f"{seconds / 3600.0:.2g} h"


HEADINGS = (
    "model", "degrees of freedom", "step, ns", "time for 60 ms", "static hub error", "hub mean",
    "varying compliance x", "largest load",
)  # fmt: skip
COLOURS = {"lagrange": "#009E73", "subgrid": "#0072B2", "resolved": "#D55E00"}
LABELS = {
    "lagrange": "rigid bodies (Lagrange)",
    "subgrid": "finite elements, contacts below the grid",
    "resolved": "finite elements, contacts resolved",
}


def plot(points: list[Point], finest: Point, path: Path) -> None:
    """Draw the error against the time, with the paper's cost."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 4.8), layout="constrained")
    for kind, color in COLOURS.items():
        mine = [p for p in points if p.kind == kind]
        line = "o-" if kind != "lagrange" else "o"
        axes.loglog(
            [p.seconds for p in mine], [100 * p.static_error for p in mine], line, color=color, label=LABELS[kind]
        )
        for p in mine:
            text = p.name.removeprefix("rigid bodies, ").removesuffix(", contacts resolved")
            aside = (6, -9) if text == "harris" else (6, 4)  # two laws lie close together
            axes.annotate(text, (p.seconds, 100 * p.static_error), textcoords="offset points", xytext=aside, fontsize=8)
    mine = [p for p in points if p.kind == "subgrid" and p is not finest]
    error = [100 * abs(p.moving["hub_mean_y"] / finest.moving["hub_mean_y"] - 1.0) for p in mine]
    axes.loglog([p.seconds for p in mine], error, "s--", color="#56B4E9", label="the same, mean of y in motion")
    axes.axvline(3600 * PAPER_CPU_HOURS, color="0.4", linestyle=":")
    axes.annotate(
        "the 2007 simulation:\n300 CPU hours", (3600 * PAPER_CPU_HOURS, 5.0), textcoords="offset points",
        xytext=(-6, 0), ha="right", color="0.3",
    )  # fmt: skip
    axes.set(xlabel="time for 60 ms on one thread, s", ylabel="error of the hub's displacement, %")
    axes.grid(True, color="0.9")
    axes.legend(frameon=False, loc="lower right", fontsize=8)
    figure.savefig(path, dpi=160)


app = App(help=__doc__)


@app.default
def main(
    *, sizes: tuple[float, ...] = SIZES_MM, resolved: tuple[float, ...] = RESOLVED_MM, output: Path = DOCS
) -> None:
    """Measure, print, write.

    Parameters
    ----------
    sizes
        of meshes with contacts below the grid, mm; the last, the finest, is the reference of what moves
    resolved
        of meshes that resolve the contacts, mm, at most 0.03
    output
        folder of the table and the plot
    """
    make_plan(read_scene())  # load everything before the first clock starts
    subgrid = [finite_elements("subgrid", size) for size in sizes]
    points = [
        *(rigid_bodies(law) for law in LAWS), *subgrid, *(finite_elements("resolved", size) for size in resolved)
    ]  # fmt: skip
    cells = rows(points, subgrid[-1])
    Console(width=150).print(new_table("Work and precision, the paper's bearing, one thread", HEADINGS, cells))
    plot(points, subgrid[-1], output / "work_precision.png")
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    (output / "work_precision.md").write_text(TEXT.format(table=markdown_table(HEADINGS, cells), commit=commit))


TEXT = """# Work and precision

The paper's bearing (13 rollers of 10 mm, 2000 N, 4500 rpm, friction 0.1), one thread. Made at commit {commit} by

```sh
python -m benchmarks.work_precision
```

{table}

* *time*: of the time loop, median of three, scaled to 60 ms from a record of 4 ms, of 0.01 ms with resolved contacts.
  The rigid bodies' is that of their whole 60 ms. The 2007 simulation took at least 300 CPU hours.
* *static hub error*: against the exact series for every body (`fem.statics.exact_statics`), which agrees with an
  independent solution on resolved quadratic meshes within 0.03 %. The rigid bodies' is that of their contact law.
* *hub mean*, *varying compliance* (standard deviation of x), *largest load*: over the first 4 ms, against the finest
  mesh.
* *contacts resolved*: no law below the grid; what is left is mostly the layer between the surfaces
  ([crossover.md](crossover.md)).

![Error against time](work_precision.png)
"""


if __name__ == "__main__":
    app()
