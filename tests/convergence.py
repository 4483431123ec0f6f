"""How results depend on mesh, step and interval: `python -m tests.convergence`.

Mesh and step are refined together, as users do; shares of the critical step make the halves exact. Statics are held
against the exact series, too. Draws docs/convergence.png.
"""

import json
import tempfile
from itertools import pairwise
from math import log2, nan, pi
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
ORDERS = f"""The paper's bearing (13 rollers of 10 mm, 2000 N, 4500 rpm, friction 0.1), weightless, {RECORD_MS:g} ms.
Each table halves one choice. Orders are log₂ of the ratio of successive changes, or of true errors where the
limit is exact (series for every body, `fem.statics.exact_statics`). `residual_*` are mean and rms of the
error forces of `check-residual --law {LAW}`, `differentiation_rms_*` the part that its finite differences
make. The mesh carries its time step with it. The series of step and interval start at rest, preloaded,
under a load that comes within 0.05 ms."""


def series(name: str, unit: str, values: np.ndarray, exact: float | None) -> tuple[list[str], float]:
    """Cells of a quantity along a series of halvings, coarsest first: name, unit, values, orders, limit; the limit.

    Orders are those between successive changes, or between true errors where the exact value is known. Else the limit
    is Richardson's, extrapolated from the last two with the last order observed.
    """
    steps = np.abs(np.diff(values) if exact is None else values - exact)
    orders, limit = [log2(a / b) if a > 0.0 and b > 0.0 else nan for a, b in pairwise(steps)], exact
    if exact is None:
        gain = 2.0 ** orders[-1] - 1.0
        limit = values[-1] + (values[-1] - values[-2]) / gain if gain > 0.5 else values[-1]  # else no convergence
    scale, unit = (1e6, "µm") if unit == "m" else (1.0, unit)
    numbers, told = [f"{scale * value:.7g}" for value in (*values, limit)], "" if exact is None else " (exact)"
    words = ", ".join("-" if np.isnan(order) else f"{order:.1f}" for order in orders)
    return [name, unit, *numbers[:-1], words, numbers[-1] + told], limit


def scene(*overrides: str) -> Scene:
    return read_scene(None, ("operation.gravity_m_s2=0", f"numerics.duration_ms={RECORD_MS}", *overrides))


def quantities(chosen: Scene, statics: bool) -> dict[str, tuple[float, str]]:
    """Run once; value and unit of every quantity of interest and of the error forces, by name."""
    plan = make_plan(chosen)
    with tempfile.TemporaryDirectory() as folder:
        path, report = Path(folder) / "run.nc", Path(folder) / "report"
        with ResultFile(path, plan, 0.0) as store:
            seen = run(plan, store.append)
            store.finish("complete", steps=seen.steps, wall_seconds=seen.wall)
        with h5py.File(path) as file:
            found = moving_quantities({name: file[name][:] for name in NEEDED})
        if check_main([str(path), "--law", LAW, "--output", str(report)]) != 0:
            raise RuntimeError(f"check-residual failed on {path}")
        summary = json.loads((report / "summary.json").read_text())
    if statics:  # x is 0 by symmetry
        found = static_quantities(plan.model, plan.operation)[1:] + found
    told = {each.name: (each.value, each.unit) for each in found}
    for axis in "xy":
        for figure in ("mean", "rms"):
            told[f"residual_{figure}_{axis}"] = summary[f"error_{axis}"][f"{figure}_N"], "N"
        told[f"differentiation_rms_{axis}"] = summary[f"budget_{axis}"]["differentiation"], "N"
    return told


def orders():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    how = scene().ideal_operation()
    at_rest = exact_statics(scene().ideal_bearing(), how.radial_load, how.first_roller_angle)
    largest, sudden = float(at_rest.inner_force.max()), make_plan(scene(*SUDDEN))
    exact = {
        "static_hub_y": float(at_rest.hub[1]), "static_largest_force": largest,
        "static_largest_share": largest / float(at_rest.inner_force.sum()),
    }  # fmt: skip
    safety = sudden.time_step / sudden.critical_time_step * (1.0 + 1e-9)
    choices = (  # title, label of its panel, sizes, how they are written, setting, known limits
        ("mesh size", "mesh size, mm", MESHES_MM, "{:.3g} mm", lambda x: (f"numerics.mesh_size_mm={x}",), exact),
        ("time step", "time step over the largest", STEP_SHARES, "{:g} of the largest",
         lambda x: (*SUDDEN, f"numerics.time_step_safety={safety * x}"), {}),
        ("output interval", "output interval, µs", INTERVALS_US, "{:g} µs",
         lambda x: (*SUDDEN, f"numerics.output_interval_us={x}"), {}),
    )  # fmt: skip
    figure, panels = plt.subplots(1, 3, figsize=(11.0, 4.2), layout="constrained", sharey=True)
    tables = []
    for axes, (title, panel, sizes, words, setting, known) in zip(panels, choices, strict=True):
        runs = [quantities(scene(*setting(size)), bool(known)) for size in sizes]
        rows = []
        for name, (_, unit) in runs[0].items():
            values = np.array([one[name][0] for one in runs])
            cells, limit = series(name, unit, values, known.get(name))
            rows.append(cells)
            if name in SHOWN:
                label, color, marker = SHOWN[name]
                off = 100.0 * np.abs(values / limit - 1.0)
                drawn = off if name in known else off[:-1]  # the last one makes the limit
                axes.loglog(sizes[: len(drawn)], drawn, marker + "-", color=color, label=label, markersize=5)
        heads = [title, "unit", *map(words.format, sizes), "orders", "limit"]
        tables.append(markdown_table(heads, rows))
        ends = np.array([min(sizes), max(sizes)])
        axes.loglog(ends, 1e-1 * (ends / ends[1]) ** 2, ":", color="0.5")
        axes.annotate("order 2", (ends[1], 1e-1), color="0.4", ha="right", va="bottom")
        axes.set(xlabel=panel, ylim=(1e-6, 30.0))
        axes.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
        axes.minorticks_off()
        axes.grid(True, color="0.9")
    panels[0].set_ylabel("distance from the limit, %")
    handles = panels[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=7, frameon=False, fontsize=8)
    figure.savefig(DOCS / "convergence.png", dpi=160)
    yield "convergence", "Mesh size, time step and output interval", ORDERS, *tables


if __name__ == "__main__":
    program(__doc__, "tests.convergence", orders)
