"""Run time against error, every model: `python -m benchmarks.work_precision`, some twenty minutes.

Four scenes of the paper's bearing: steady running, a load that comes within 50 µs, rattling in clearance, a spall. Each
is run by the rigid bodies of Lagrange's equations, by the reduced model and by finite elements from 3 to 0.25 mm; the
finest is the reference. Contacts that meshes resolve are there for the static error of the paper's scene. Times are
processor times of the time loop on one thread, scaled to 60 ms. Writes work_precision.md and work_precision.png.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import welch

from benchmarks import timed
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from fem.statics.exact_statics import exact_statics
from lagrange.scene.scene import parse_scene
from tests.measurements import DOCS, markdown_table, program

SIZES_MM = (3.0, 2.0, 1.5, 1.0, 0.75, 0.5, 0.25)
RESOLVED_MM = (0.03, 0.024)
LAWS = ("harris", "johnson")
RECORD_MS, RESOLVED_RECORD_MS, FULL_MS = 10.0, 0.01, 60.0
INTERVAL_US = 5.0
PAPER_CPU_HOURS = 300.0  # Rubio et al. 2007: "at least 300 hours of CPU simulation time"
BANDS = ((0.0, 5e3), (5e3, 20e3), (20e3, 50e3))  # Hz, of the hub's acceleration
STEADY = "steady"
SCENES = {
    STEADY: {},
    "load within 50 µs": {"numerics": {"start": "rest", "load_ramp_ms": 0.05}},
    "rattling": {"bearing": {"outer_raceway_diameter_mm": 56.04}, "operation": {"radial_load_N": 200.0}},
    "spall of 1 mm": {"spall": [{"body": "outer_ring", "angle_deg": 0.0, "width_mm": 1.0}]},
}
QUANTITIES = ("mean y", "std y", "std x", "largest load", *(f"{low / 1e3:g}-{high / 1e3:g} kHz" for low, high in BANDS))
LINES = QUANTITIES[:4]  # drawn


@dataclass(frozen=True, kw_only=True)
class Point:
    """Cost and results of one model in one scene."""

    kind: str  # lagrange, reduced, subgrid, resolved
    name: str
    degrees_of_freedom: int
    step: float  # s
    seconds: float  # for 60 ms
    static_error: float  # of the hub
    imbalance: float  # largest, of the exchanged energy
    found: dict[str, float]  # by quantity; empty: the record is too short


def points(scene: str, sizes: tuple[float, ...], resolved: tuple[float, ...]) -> Iterator[Point]:
    """Every model of a scene, the finest mesh below the grid last but for resolved ones."""
    for law in LAWS:
        yield measured("lagrange", f"rigid, {law}", scene, {"model": "lagrange", "lagrange": {"law": law}})
    yield measured("reduced", "reduced", scene, {"model": "reduced"})
    for size in sizes:
        yield measured("subgrid", f"{size:g} mm", scene, {"numerics": {"mesh_size_mm": size}})
    for size in resolved if scene == STEADY else ():
        numerics = {"mesh_size_mm": size, "duration_ms": RESOLVED_RECORD_MS, "output_interval_us": 1.0}
        how = {"contact": {"model": "resolved"}, "numerics": numerics}
        yield measured("resolved", f"{size:g} mm, resolved", scene, how)


def measured(kind: str, name: str, scene: str, settings: dict) -> Point:
    """Run a scene with some settings."""
    numerics = {"duration_ms": RECORD_MS, "output_interval_us": INTERVAL_US}
    tables: dict = {"numerics": numerics}
    for more in (SCENES[scene], settings):
        for key, value in more.items():
            tables[key] = tables.get(key, {}) | value if isinstance(value, dict) else value
    plan = make_plan(parse_scene(tables, name))
    plan.prepare()
    kept: list = []
    spent, _ = timed(lambda: run(plan, kept.append, restart=lambda reason: kept.clear()))
    record = 1e-3 * tables["numerics"]["duration_ms"]
    operation, bearing = plan.scene.ideal_operation(), plan.scene.ideal_bearing()
    exact = exact_statics(bearing, operation.radial_load, operation.first_roller_angle).hub
    exchanged = max(float(block.exchanged[-1]) for block in kept)
    return Point(
        kind=kind, name=name, degrees_of_freedom=plan.degrees_of_freedom, step=plan.time_step,
        seconds=spent * 1e-3 * FULL_MS / record,
        static_error=float(np.linalg.norm(plan.static_hub() - exact) / np.linalg.norm(exact)),
        imbalance=max(float(np.abs(block.imbalance).max()) for block in kept) / exchanged,
        found={} if kind == "resolved" else quantities(kept),
    )  # fmt: skip


def quantities(blocks: list) -> dict[str, float]:
    """What is compared, SI."""
    values = Samples.joined(blocks)
    x, y = values["inner_x"], values["inner_y"]
    largest = max(values[name].max() for name in ("inner_force", "outer_force"))
    found = [y.mean(), y.std(), x.std(), largest]
    frequency, psd = 0.0, 0.0
    for axis in ("inner_ax", "inner_ay"):
        frequency, density = welch(values[axis], fs=1e6 / INTERVAL_US, nperseg=len(x) // 2)
        psd = psd + density
    found += [float(np.sqrt(psd[(frequency >= low) & (frequency < high)].sum())) for low, high in BANDS]
    return dict(zip(QUANTITIES, found, strict=True))


def off(point: Point, finest: Point, name: str) -> float:
    """Relative difference of a quantity from the finest mesh's."""
    return abs(point.found[name] / finest.found[name] - 1.0)


def rows(found: list[Point], finest: Point) -> list[list[str]]:
    """Cells of a scene's table."""
    return [
        [
            p.name, f"{p.degrees_of_freedom}", f"{1e9 * p.step:.3g}", _readable(p.seconds),
            f"{100 * p.static_error:.2g} %",
            *("reference" if p is finest else f"{100 * off(p, finest, q):.2g} %" if p.found else "-"
              for q in QUANTITIES),
            f"{p.imbalance:.0e}",
        ]
        for p in found
    ]  # fmt: skip


def _readable(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds < 3600.0 else f"{seconds / 3600.0:.2g} h"


HEADINGS = ("model", "degrees of freedom", "step, ns", "time for 60 ms", "static hub error", *QUANTITIES, "energy")
MARKERS = dict(zip(LINES, "os^D", strict=True))
COLOURS = {"lagrange": "#009E73", "reduced": "#CC79A7", "subgrid": "#0072B2"}
LABELS = {"lagrange": "rigid bodies (Lagrange)", "reduced": "reduced", "subgrid": "finite elements"}


def plot(scenes: dict[str, list[Point]], finest: dict[str, Point], path: Path) -> None:
    """Draw each scene's errors against the time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke

    apart = [withStroke(linewidth=2.0, foreground="white")]  # names from lines
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 7.5), sharex=True, sharey=True, layout="constrained")
    for axes, (scene, found) in zip(panels.flat, scenes.items(), strict=True):
        for kind, colour in COLOURS.items():
            mine = [p for p in found if p.kind == kind and p is not finest[scene]]
            for name, marker in MARKERS.items():
                error = [100 * off(p, finest[scene], name) for p in mine]
                line = "-" if kind == "subgrid" else "none"
                axes.loglog(
                    [p.seconds for p in mine], error, ls=line, marker=marker, color=colour, lw=0.8, ms=5, alpha=0.85
                )
            for i, p in enumerate(mine):
                errors = [100 * off(p, finest[scene], name) for name in LINES]
                above = kind == "lagrange"  # their markers lie over the reduced model's
                points = 6 if above else -11 - 8 * (i % 2 if kind == "subgrid" else 0)  # coarse meshes stand close
                side = ("right", "left")[i % 2] if above else "center"
                axes.annotate(
                    p.name.removeprefix("rigid, "), (p.seconds, max(errors) if above else min(errors)),
                    textcoords="offset points", xytext=({"right": 4, "left": -4}.get(side, 0), points), fontsize=7,
                    ha=side, color=colour, path_effects=apart,
                )  # fmt: skip
        axes.axvline(1e-3 * FULL_MS, color="0.5", linestyle=":")
        axes.set_title(scene, fontsize=10)
        axes.grid(True, color="0.92")
    (left, right), (bottom, top) = panels[0, 0].get_xlim(), panels[0, 0].get_ylim()
    panels[0, 0].set(xlim=(0.6 * left, 1.4 * right), ylim=(0.2 * bottom, 3.0 * top))  # room for names
    panels[0, 0].annotate(
        "real time", (1e-3 * FULL_MS, 0.98), xycoords=("data", "axes fraction"), rotation=90, ha="right", va="top",
        fontsize=8, color="0.4",
    )  # fmt: skip
    for axes in panels[1]:
        axes.set_xlabel("processor time for 60 ms, s", fontsize=10)
    figure.supylabel("difference from finite elements of 0.25 mm, %", fontsize=10)
    keys = [Line2D([], [], color=colour, marker="o", ls="", label=LABELS[kind]) for kind, colour in COLOURS.items()]
    keys += [Line2D([], [], color="0.4", marker=marker, ls="", label=name) for name, marker in MARKERS.items()]
    figure.legend(handles=keys, loc="outside upper center", ncols=len(keys), frameon=False, fontsize=8)
    figure.savefig(path, dpi=160)


def main(*, sizes: tuple[float, ...] = SIZES_MM, resolved: tuple[float, ...] = RESOLVED_MM, output: Path = DOCS):
    """Measure, print and draw.

    Parameters
    ----------
    sizes: of meshes with contacts below the grid, mm; the last, the finest, is the reference
    resolved: of meshes that resolve the contacts, mm, at most 0.03
    output: folder of the plot
    """
    scenes: dict[str, list[Point]] = {}
    finest = {}
    for scene in SCENES:
        scenes[scene] = list(points(scene, sizes, resolved))
        finest[scene] = [p for p in scenes[scene] if p.kind == "subgrid"][-1]
        cells = rows(scenes[scene], finest[scene])
        yield "work_precision", f"{scene[0].upper()}{scene[1:]}", markdown_table(HEADINGS, cells)
    plot(scenes, finest, output / "work_precision.png")


if __name__ == "__main__":
    program(__doc__, "benchmarks.work_precision", main)
