"""Observed orders in mesh size, time step and output interval: `python -m tests.accuracy.convergence`.

The paper's bearing. Each series halves one choice and keeps the others; an order is log₂ of the ratio of successive
changes, a limit is Richardson's extrapolation of the last two. Statics are also held against the exact series. Writes
docs/convergence.md and docs/convergence.png.
"""

import json
import tempfile
from dataclasses import dataclass
from itertools import pairwise
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

RECORD_MS, LAW = 12.0, "johnson"
# surface spacings that divide the roller's circumference by 18, 36, 72, 144
MESHES_MM = tuple(10.0 * pi / nodes for nodes in (18, 36, 72, 144))
STEP_SHARES = (1.0, 0.5, 0.25, 0.125)  # of the largest step
INTERVALS_US = (8.0, 4.0, 2.0, 1.0)
# in steady running the errors of step and interval drown in round-off: a sudden load makes the hub ring, a preload
# keeps every contact closed, since a contact that opens a step later is an error of no order
SUDDEN = (
    f"numerics.mesh_size_mm={MESHES_MM[0]}", "bearing.outer_raceway_diameter_mm=55.98",
    "contact.friction_coefficient=0", "operation.radial_load_N=1000", "numerics.start=rest",
    "numerics.load_ramp_ms=0.05", "numerics.duration_ms=2",
)  # fmt: skip
SHOWN = {  # label, colour, marker
    "static_hub_y": ("hub at rest", "#0072B2", "o"), "hub_mean_y": ("hub, mean", "#56B4E9", "s"),
    "hub_std_x": ("varying compliance, x", "#009E73", "^"), "largest_force": ("largest load", "#D55E00", "v"),
    "cage_speed": ("cage speed", "#CC79A7", "D"), "residual_mean_y": ("mean error force, y", "#E69F00", "P"),
    "residual_rms_x": ("rms error force, x", "0.35", "X"),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Series:
    """Values of one quantity along a series of halvings, coarsest first."""

    name: str
    unit: str
    values: np.ndarray
    exact: float | None

    @property
    def orders(self) -> list[float]:
        """Orders between successive changes, or between true errors where the exact value is known."""
        steps = np.abs(np.diff(self.values) if self.exact is None else self.values - self.exact)
        return [log2(a / b) if a > 0.0 and b > 0.0 else float("nan") for a, b in pairwise(steps)]

    @property
    def limit(self) -> float:
        """The exact value, or the one extrapolated with the last order observed."""
        if self.exact is not None:
            return self.exact
        before, last = self.values[-2:]
        gain = 2.0 ** self.orders[-1] - 1.0
        return last + (last - before) / gain if gain > 0.5 else last  # else no convergence to speak of

    @property
    def cells(self) -> list[str]:
        """Name, unit, values, orders, limit."""
        orders = ", ".join("-" if np.isnan(order) else f"{order:.1f}" for order in self.orders)
        scale, unit = (1e6, "µm") if self.unit == "m" else (1.0, self.unit)
        limit = f"{scale * self.limit:.7g}" + ("" if self.exact is None else " (exact)")
        return [self.name, unit, *(f"{scale * value:.7g}" for value in self.values), orders, limit]


def scene(*overrides: str) -> Scene:
    return read_scene(None, ("operation.gravity_m_s2=0", f"numerics.duration_ms={RECORD_MS}", *overrides))


def measure(chosen: Scene, folder: Path, statics: bool) -> dict[str, tuple[float, str]]:
    """Run once; value and unit of every quantity of interest and of the error forces, by name."""
    plan, path = make_plan(chosen), folder / "run.nc"
    with ResultFile(path, plan, 0.0) as store:
        seen = run(plan, store.append)
        store.finish("complete", steps=seen.steps, wall_seconds=seen.wall)
    with h5py.File(path) as file:
        quantities = moving_quantities({name: file[name][:] for name in NEEDED})
    if statics:  # x is 0 by symmetry
        quantities = static_quantities(plan.model, plan.operation)[1:] + quantities
    found = {each.name: (each.value, each.unit) for each in quantities}
    if check_main([str(path), "--law", LAW, "--output", str(folder / "report")]) != 0:
        raise RuntimeError(f"check-residual failed on {path}")
    summary = json.loads((folder / "report" / "summary.json").read_text())
    for axis in "xy":
        for figure in ("mean", "rms"):
            found[f"residual_{figure}_{axis}"] = summary[f"error_{axis}"][f"{figure}_N"], "N"
        found[f"differentiation_rms_{axis}"] = summary[f"budget_{axis}"]["differentiation"], "N"
    return found


def series(settings: list[tuple[str, ...]], exact: dict[str, float]) -> list[Series]:
    """Measure all quantities along a list of scenes; statics too where exact values are known."""
    runs = []
    for each in settings:
        with tempfile.TemporaryDirectory() as folder:
            runs.append(measure(scene(*each), Path(folder), bool(exact)))
    return [
        Series(name=name, unit=unit, values=np.array([one[name][0] for one in runs]), exact=exact.get(name))
        for name, (_, unit) in runs[0].items()
    ]


def plot(found: list[tuple[str, tuple[float, ...], list[Series]]], path: Path) -> None:
    """Draw the distance from the limit against mesh size, step and interval."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(11.0, 4.2), layout="constrained", sharey=True)
    for axes, (label, steps, parts) in zip(panels, found, strict=True):
        for one in (each for each in parts if each.name in SHOWN):
            name, color, marker = SHOWN[one.name]
            off = 100.0 * np.abs(one.values / one.limit - 1.0)
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
    handles = panels[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=7, frameon=False, fontsize=8)
    figure.savefig(path, dpi=160)


def measured() -> tuple[str, ...]:
    """Words and tables; the picture is drawn.

    Mesh and step are refined together, as users do; shares of the critical step make the halves exact.
    """
    how = scene().ideal_operation()
    found = exact_statics(scene().ideal_bearing(), how.radial_load, how.first_roller_angle)
    largest, sudden = float(found.inner_force.max()), make_plan(scene(*SUDDEN))
    exact = {
        "static_hub_y": float(found.hub[1]), "static_largest_force": largest,
        "static_largest_share": largest / float(found.inner_force.sum()),
    }  # fmt: skip
    safety = sudden.time_step / sudden.critical_time_step * (1.0 + 1e-9)
    rows = (  # title, label of its panel, sizes, how they are written, setting, known limits
        ("mesh size", "mesh size, mm", MESHES_MM, "{:.3g} mm", lambda x: (f"numerics.mesh_size_mm={x}",), exact),
        ("time step", "time step over the largest", STEP_SHARES, "{:g} of the largest",
         lambda x: (*SUDDEN, f"numerics.time_step_safety={safety * x}"), {}),
        ("output interval", "output interval, µs", INTERVALS_US, "{:g} µs",
         lambda x: (*SUDDEN, f"numerics.output_interval_us={x}"), {}),
    )  # fmt: skip
    drawn, tables = [], []
    for title, label, sizes, words, setting, known in rows:
        parts = series([setting(size) for size in sizes], known)
        drawn.append((label, sizes, parts))
        tables.append(markdown_table([title, "unit", *map(words.format, sizes), "orders", "limit"],
                                     [one.cells for one in parts]))  # fmt: skip
    plot(drawn, DOCS / "convergence.png")
    return TEXT.format(record=RECORD_MS, law=LAW), *tables


TEXT = """The paper's bearing (13 rollers of 10 mm, 2000 N, 4500 rpm, friction 0.1), weightless, {record:g} ms. Each
table halves one choice. Orders are log₂ of the ratio of successive changes, or of true errors where the
limit is exact (series for every body, `fem.statics.exact_statics`). `residual_*` are mean and rms of the
error forces of `check-residual --law {law}`, `differentiation_rms_*` the part that its finite differences
make. The mesh carries its time step with it. The series of step and interval start at rest, preloaded,
under a load that comes within 0.05 ms."""


if __name__ == "__main__":
    heading = "Mesh size, time step and output interval"
    program(__doc__, "tests.accuracy.convergence", ("convergence", heading, measured))
