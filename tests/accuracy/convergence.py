"""Observed orders in mesh size, time step and output interval: `python -m tests.accuracy.convergence`.

The paper's bearing. Each series halves one choice and keeps the others; an order is log₂ of the ratio of successive
changes, a limit is Richardson's extrapolation of the last two. Statics are also held against the exact series. Writes
docs/convergence.md and docs/convergence.png.
"""

import itertools
import json
import tempfile
from dataclasses import dataclass
from math import log2, pi
from pathlib import Path

import h5py
import numpy as np

from fem.quantities import moving_quantities
from fem.result.store import ResultFile
from fem.solver.errors import NEEDED
from fem.solver.simulate import make_plan, run
from fem.statics.equilibrium import static_quantities
from fem.statics.exact_statics import exact_statics
from lagrange.scene.scene import Scene, read_scene
from residual.cli import main as check_main
from tests.measurements import DOCS, markdown_table, program

RECORD_MS = 12.0
# surface spacings that divide the roller's circumference by 18, 36, 72, 144
MESHES_MM = tuple(10.0 * pi / nodes for nodes in (18, 36, 72, 144))
STEP_SHARES = (1.0, 0.5, 0.25, 0.125)  # of the largest step
INTERVALS_US = (8.0, 4.0, 2.0, 1.0)
COARSE_MM = MESHES_MM[0]
LAW = "johnson"
# in steady running the errors of step and interval drown in round-off: a sudden load makes the hub ring, a preload
# keeps every contact closed, since a contact that opens a step later is an error of no order
SUDDEN = (
    "bearing.outer_raceway_diameter_mm=55.98", "contact.friction_coefficient=0", "operation.radial_load_N=1000",
    "numerics.start=rest", "numerics.load_ramp_ms=0.05", "numerics.duration_ms=2",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Series:
    """Values of one quantity along a series of halvings, coarsest first."""

    name: str
    unit: str
    values: tuple[float, ...]
    exact: float | None = None

    @property
    def changes(self) -> np.ndarray:
        return np.abs(np.diff(self.values))

    @property
    def orders(self) -> list[float]:
        """Orders between successive changes, or between true errors where the exact value is known."""
        steps = np.abs(np.array(self.values) - self.exact) if self.exact is not None else self.changes
        return [log2(a / b) if a > 0.0 and b > 0.0 else float("nan") for a, b in itertools.pairwise(steps)]

    @property
    def limit(self) -> float:
        """The exact value, or the one extrapolated with the last order observed."""
        if self.exact is not None:
            return self.exact
        order = self.orders[-1]
        gain = 2.0**order - 1.0
        if not gain > 0.5:  # no convergence to speak of: the last value is all there is
            return self.values[-1]
        return self.values[-1] + (self.values[-1] - self.values[-2]) / gain


def scene(*overrides: str) -> Scene:
    return read_scene(None, ("operation.gravity_m_s2=0", f"numerics.duration_ms={RECORD_MS}", *overrides))


def measure(chosen: Scene, folder: Path, statics: bool) -> dict[str, tuple[float, str]]:
    """Run once; value and unit of every quantity of interest and of the error forces, by name."""
    plan = make_plan(chosen)
    path = folder / "run.nc"
    with ResultFile(path, plan, 0.0) as store:
        seen = run(plan, store.append)
        store.finish("complete", steps=seen.steps, wall_seconds=seen.wall)
    with h5py.File(path) as file:
        record = {name: file[name][:] for name in NEEDED}
    quantities = moving_quantities(record)
    if statics:  # x is 0 by symmetry
        quantities = static_quantities(plan.model, plan.operation)[1:] + quantities
    found = {each.name: (each.value, each.unit) for each in quantities}
    report = folder / "report"
    if check_main([str(path), "--law", LAW, "--output", str(report)]) != 0:
        raise RuntimeError(f"check-residual failed on {path}")
    summary = json.loads((report / "summary.json").read_text())
    for axis in "xy":
        for figure in ("mean", "rms"):
            found[f"residual_{figure}_{axis}"] = summary[f"error_{axis}"][f"{figure}_N"], "N"
        found[f"differentiation_rms_{axis}"] = summary[f"budget_{axis}"]["differentiation"], "N"
    return found


def series(scenes: list[Scene], exact: dict[str, float] | None = None) -> list[Series]:
    """Measure all quantities along a list of scenes."""
    runs = []
    for chosen in scenes:
        with tempfile.TemporaryDirectory() as folder:
            runs.append(measure(chosen, Path(folder), exact is not None))
    known = exact or {}
    return [
        Series(name=name, unit=unit, values=tuple(one[name][0] for one in runs), exact=known.get(name))
        for name, (_, unit) in runs[0].items()
    ]


def in_mesh_size() -> list[Series]:
    """Refine mesh and step together, as users do."""
    base = scene()
    how = base.ideal_operation()
    found = exact_statics(base.ideal_bearing(), how.radial_load, how.first_roller_angle)
    exact = {
        "static_hub_y": float(found.hub[1]), "static_largest_force": float(found.inner_force.max()),
        "static_largest_share": float(found.inner_force.max() / found.inner_force.sum()),
    }  # fmt: skip
    return series([scene(f"numerics.mesh_size_mm={size}") for size in MESHES_MM], exact)


def in_time_step() -> list[Series]:
    """Halve the step under a sudden load on the coarsest mesh; shares of the critical step make the halves exact."""
    plan = make_plan(scene(f"numerics.mesh_size_mm={COARSE_MM}", *SUDDEN))
    largest = plan.time_step / plan.critical_time_step
    options = [f"numerics.time_step_safety={largest * share * (1.0 + 1e-9)}" for share in STEP_SHARES]
    return series([scene(f"numerics.mesh_size_mm={COARSE_MM}", *SUDDEN, option) for option in options])


def in_output_interval() -> list[Series]:
    """Halve the interval of the checker's finite differences under a sudden load on the coarsest mesh."""
    options = [f"numerics.output_interval_us={interval}" for interval in INTERVALS_US]
    return series([scene(f"numerics.mesh_size_mm={COARSE_MM}", *SUDDEN, option) for option in options])


def table(title: str, steps: list[str], found: list[Series]) -> list[list[str]]:
    """Make the heading and the rows: values, orders, limit."""
    rows = [[title, "unit", *steps, "orders", "limit"]]
    for one in found:
        orders = ", ".join("-" if np.isnan(order) else f"{order:.1f}" for order in one.orders)
        scale, unit = (1e6, "µm") if one.unit == "m" else (1.0, one.unit)
        values = [f"{scale * value:.7g}" for value in one.values]
        limit = f"{scale * one.limit:.7g}" + (" (exact)" if one.exact is not None else "")
        rows.append([one.name, unit, *values, orders, limit])
    return rows


def plot(found: list[tuple[str, list[float], list[Series]]], path: Path) -> None:
    """Draw the distance from the limit against mesh size, step and interval."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown = {
        "static_hub_y": ("hub at rest", "#0072B2", "o"), "hub_mean_y": ("hub, mean", "#56B4E9", "s"),
        "hub_std_x": ("varying compliance, x", "#009E73", "^"), "largest_force": ("largest load", "#D55E00", "v"),
        "cage_speed": ("cage speed", "#CC79A7", "D"), "residual_mean_y": ("mean error force, y", "#E69F00", "P"),
        "residual_rms_x": ("rms error force, x", "0.35", "X"),
    }  # fmt: skip
    figure, panels = plt.subplots(1, 3, figsize=(11.0, 4.2), layout="constrained", sharey=True)
    for axes, (label, steps, parts) in zip(panels, found, strict=True):
        for one in parts:
            if one.name not in shown:
                continue
            name, color, marker = shown[one.name]
            off = 100.0 * np.abs(np.array(one.values) / one.limit - 1.0)
            drawn = off[:-1] if one.exact is None else off  # the last one makes the limit
            axes.loglog(steps[: len(drawn)], drawn, marker + "-", color=color, label=name, markersize=5)
        ends = np.array([min(steps), max(steps)])
        axes.loglog(ends, 1e-1 * (ends / ends[1]) ** 2, ":", color="0.5")
        axes.annotate("order 2", (ends[1], 1e-1), color="0.4", ha="right", va="bottom")
        axes.set(xlabel=label, ylim=(1e-6, 30.0))
        axes.set_xticks(steps, [f"{step:.3g}" for step in steps])
        axes.minorticks_off()
        axes.grid(True, color="0.9")
    panels[0].set_ylabel("distance from the limit, %")
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=7, frameon=False, fontsize=8
    )
    figure.savefig(path, dpi=160)


def measured() -> tuple[str, ...]:
    """Words and tables; the picture is drawn."""
    mesh, step, interval = in_mesh_size(), in_time_step(), in_output_interval()
    steps = {
        "mesh size": ("mesh size, mm", MESHES_MM, "{:.3g} mm", mesh),
        "time step": ("time step over the largest", STEP_SHARES, "{:g} of the largest", step),
        "output interval": ("output interval, µs", INTERVALS_US, "{:g} µs", interval),
    }
    plot([(label, list(sizes), parts) for label, sizes, _, parts in steps.values()], DOCS / "convergence.png")
    tables = [table(title, list(map(words.format, sizes)), found) for title, (_, sizes, words, found) in steps.items()]
    return TEXT.format(record=RECORD_MS, law=LAW), *(markdown_table(rows[0], rows[1:]) for rows in tables)


TEXT = """The paper's bearing (13 rollers of 10 mm, 2000 N, 4500 rpm, friction 0.1), weightless, {record:g} ms. Each
table halves one choice. Orders are log₂ of the ratio of successive changes, or of true errors where the
limit is exact (series for every body, `fem.statics.exact_statics`). `residual_*` are mean and rms of the
error forces of `check-residual --law {law}`, `differentiation_rms_*` the part that its finite differences
make. The mesh carries its time step with it. The series of step and interval start at rest, preloaded,
under a load that comes within 0.05 ms."""


if __name__ == "__main__":
    heading = "Mesh size, time step and output interval"
    program(__doc__, "tests.accuracy.convergence", ("convergence", heading, measured))
