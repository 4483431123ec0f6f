"""How results depend on mesh, step, interval and the processor: `python -m tests.accuracy.convergence SECTION`."""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from itertools import pairwise
from math import log2, nan, pi
from pathlib import Path

import h5py
import numpy as np

from fem.contacts.model import standing
from fem.contacts.resolved import ResolvedModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.quantities import moving_quantities
from fem.result.store import ResultFile
from fem.solver.errors import NEEDED
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium, static_quantities
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import Scene, read_scene
from residual.cli import main as check_main
from tests.measurements import DOCS, markdown_table, program
from tests.reference.continua import contact_pressures, layer_approach

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


def pyplot():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def orders():
    """Observed orders in mesh size, time step and output interval.

    Mesh and step are refined together, as users do; shares of the critical step make the halves exact. Statics are held
    against the exact series, too. Draws docs/convergence.png.
    """
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
    figure, panels = pyplot().subplots(1, 3, figsize=(11.0, 4.2), layout="constrained", sharey=True)
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


SUBGRID_MM = (2.0, 1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.0105)
RESOLVED_MM = (0.03, 0.021, 0.015, 0.0105)
CROSSOVER = """Paper's bearing, 2000 N, a roller on the load line, weightless, against the exact series. *Loads*:
largest error of a roller's load over the largest load. *Below the grid*: share of a contact's approach that the
sub-grid term carries at 628 N. *In the layers*: approach of the stiff layer between resolved surfaces over
the hub's displacement."""


def at_rest(kind: str, size_mm: float) -> tuple[float, ...]:
    """The statics on one mesh: spacing over half-width of the most loaded inner contact, degrees of freedom, errors in
    % of the hub (signed) and of any roller's load over the largest, share of the approach below the grid and of the
    hub's displacement in the layers of the most loaded roller, %."""
    chosen = read_scene()
    bearing, how, size = chosen.ideal_bearing(), replace(chosen.ideal_operation(), gravity=0.0), 1e-3 * size_mm
    exact = exact_statics(bearing, how.radial_load, how.first_roller_angle)
    force = float(exact.inner_force.max())
    widths = [pair.half_width(force) for pair in contact_pairs(bearing)[:2]]
    if kind == "resolved":
        model = ResolvedModel.build(bearing, size)
    elif size < SpreadModel.coarsest * max(widths):
        model = SpreadModel.of_force(bearing, size, force)
    else:
        model = SubgridModel.build(bearing, size)
    still, law = standing(bearing, how.first_roller_angle), model.inner_law
    found = equilibrium(model, still, Loads(how.radial_load))
    whole = float(exact_contacts(bearing, roller_angles(bearing, how.first_roller_angle)).inner_law.approach(force))
    if isinstance(model, SpreadModel):  # m, that the term below the grid adds to the most loaded inner contact
        inner = contact_pressures(model, still, how.radial_load)[: bearing.n_rollers]
        forces = max(inner, key=lambda p: p.pressure.sum()).pressure * law.spacing * law.pair.length
        below = float(forces @ law.local_compliance(forces.size) @ forces / forces.sum())
    else:
        below = float(law.approach(force))
    layers = sum(layer_approach(each, force) for each in (law, model.outer_law)) if kind == "resolved" else 0.0
    worst = float(np.abs(found.inner_force - exact.inner_force).max() / force)
    shares = float(found.hub[1] / exact.hub[1] - 1.0), worst, below / whole, layers / abs(float(exact.hub[1]))
    return size / widths[0], model.degrees_of_freedom, *(100.0 * share for share in shares)


def crossover():
    """From meshes far coarser than a contact to meshes that resolve it: the paper's bearing at rest by both models.

    Against the exact series; and what share of a contact's approach the law below the grid still carries.
    """
    plt, rows = pyplot(), []
    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.5, 6.2), sharex=True, layout="constrained", height_ratios=[3, 2]
    )
    for kind, sizes, color, style in (
        ("subgrid", SUBGRID_MM, "#0072B2", "o-"), ("resolved", RESOLVED_MM, "#D55E00", "s-"),
    ):  # fmt: skip
        points = [at_rest(kind, size) for size in sizes]
        rows += [
            [kind, f"{size:g} mm", f"{per:.3g}", str(freedom), f"{hub:+.4f} %", f"{force:.4f} %", f"{below:.1f} %",
             f"{layer:.2f} %"]
            for size, (per, freedom, hub, force, below, layer) in zip(sizes, points, strict=True)
        ]  # fmt: skip
        x, _, hub, _, below, layer = zip(*points, strict=True)
        upper.loglog(x, np.abs(hub), style, color=color, label=kind)
        lower.semilogx(x, below, style, color=color)
    upper.loglog(x, layer, "--", color=color, label="resolved: what the contact layer yields")
    for axes in (upper, lower):
        axes.axvline(1.0, color="0.6", linestyle="--")
        axes.grid(True, color="0.9")
    upper.annotate("mesh = half-width", (1.0, upper.get_ylim()[0]), rotation=90, color="0.4", ha="right", va="bottom")
    upper.axvline(SpreadModel.coarsest, color="0.6", linestyle=":")
    upper.annotate(
        "one patch a contact, uniform mesh →\n← pressure points, mesh coarser inside", (SpreadModel.coarsest, 1.0),
        xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points", color="0.4", fontsize=8,
        ha="center", va="bottom",
    )  # fmt: skip
    upper.set(ylabel="static hub displacement,\nerror against exact series, %")
    upper.legend(frameon=False)
    below = "share of the approach\nbelow the grid, %"
    lower.set(xlabel="surface spacing over contact half-width", ylabel=below, ylim=(-3, 85))
    figure.savefig(DOCS / "crossover.png", dpi=160)
    heads = ("contact", "mesh", "mesh / half-width", "degrees of freedom", "hub displacement", "loads",
             "below the grid", "in the layers")  # fmt: skip
    yield "crossover", "Static hub displacement by mesh", CROSSOVER, markdown_table(heads, rows)


# LLVM's names: the least of all 64-bit processors; with AVX2 and fused products (2013); with AVX-512 (2017)
PROCESSORS = {"x86-64": "SSE2", "x86-64-v3": "AVX2", "x86-64-v4": "AVX-512"}
COLUMNS = {"inner_x": "hub x", "inner_y": "hub y", "inner_force": "inner loads", "roller_spin": "spins"}


def processors():
    """One run compiled for processors of three kinds, about a minute each.

    The processor at hand must know what is asked of it. Results repeat bit for bit on one processor; sums are fused and
    grouped differently on another, and contacts make of that what they make of any round-off. Compared with the
    plainest.
    """
    runs, rows = {}, []
    with tempfile.TemporaryDirectory() as folder:
        for name in PROCESSORS:
            path = f"{folder}/{name}.nc"
            words = ["--quiet", "--mesh-size", "2", "--duration", "5", "--output", path]
            environment = os.environ | {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
            start = "from fem.commands.entry import run_fem; run_fem()"
            subprocess.run([sys.executable, "-c", start, *words], env=environment, check=True)
            with h5py.File(path) as file:
                runs[name] = {column: file[column][:] for column in COLUMNS}
    plainest = runs[next(iter(PROCESSORS))]
    for name, values in runs.items():
        apart = [np.abs(values[c] - plainest[c]).max() / np.abs(plainest[c]).max() for c in COLUMNS]
        rows.append([f"{PROCESSORS[name]} ({name})", *(f"{value:.1g}" for value in apart)])
    words = "5 ms of the paper's bearing, 2 mm, largest differences over the largest value."
    yield "reliability", "Processors", words, markdown_table(["compiled for", *COLUMNS.values()], rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.convergence", orders, crossover, processors)
