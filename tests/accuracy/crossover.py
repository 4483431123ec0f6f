"""From meshes far coarser than a contact to meshes that resolve it: `python -m tests.accuracy.crossover`.

Static hub displacement of the paper's bearing by both contact models, against the exact series; and what share of a
contact's approach the law below the grid still carries. Writes docs/crossover.md and docs/crossover.png.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.contacts.model import standing
from fem.contacts.resolved import ResolvedModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import read_scene
from tests.measurements import DOCS, markdown_table, program
from tests.reference.continua import contact_pressures, layer_approach

SUBGRID_MM = (2.0, 1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.0105)
RESOLVED_MM = (0.03, 0.021, 0.015, 0.0105)
COLOURS = {"subgrid": ("#0072B2", "o-"), "resolved": ("#D55E00", "s-")}
HEADINGS = (
    "contact", "mesh", "mesh / half-width", "degrees of freedom", "hub displacement", "loads", "below the grid",
    "in the layers",
)  # fmt: skip


class Point(NamedTuple):
    """Results of one mesh under one contact model."""

    model: str
    size_mm: float
    per_half_width: float  # surface spacing over the half-width of the most loaded inner contact
    degrees_of_freedom: int
    hub_error: float  # %, signed
    force_error: float  # %, of any roller over the largest force
    below_grid: float  # %, share of the most loaded inner contact's approach
    layer: float  # %, approach in the layers of the most loaded roller over the hub's displacement


def measure(kind: str, size_mm: float) -> Point:
    """Solve the statics on one mesh."""
    scene = read_scene()
    bearing, how, size = scene.ideal_bearing(), replace(scene.ideal_operation(), gravity=0.0), 1e-3 * size_mm
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
    return Point(
        kind, size_mm, size / widths[0], model.degrees_of_freedom, 100.0 * float(found.hub[1] / exact.hub[1] - 1.0),
        100.0 * float(np.abs(found.inner_force - exact.inner_force).max() / force), 100.0 * below / whole,
        100.0 * layers / abs(float(exact.hub[1])),
    )  # fmt: skip


def plot(points: list[Point], path: Path) -> None:
    """Draw error and the sub-grid law's share against mesh size over half-width."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.5, 6.2), sharex=True, layout="constrained", height_ratios=[3, 2]
    )
    for kind, (color, style) in COLOURS.items():
        mine = [p for p in points if p.model == kind]
        x = [p.per_half_width for p in mine]
        upper.loglog(x, [abs(p.hub_error) for p in mine], style, color=color, label=kind)
        lower.semilogx(x, [p.below_grid for p in mine], style, color=color)
    yields = "resolved: what the contact layer yields"
    upper.loglog(x, [p.layer for p in mine], "--", color=color, label=yields)
    for axes in (upper, lower):
        axes.axvline(1.0, color="0.6", linestyle="--")
        axes.grid(True, color="0.9")
    upper.annotate("mesh = half-width", (1.0, upper.get_ylim()[0]), rotation=90, color="0.4", ha="right", va="bottom")
    upper.axvline(SpreadModel.coarsest, color="0.6", linestyle=":")
    upper.annotate(
        "one patch a contact, uniform mesh →\n← pressure points, mesh coarser inside",
        (SpreadModel.coarsest, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points",
        color="0.4", fontsize=8, ha="center", va="bottom",
    )  # fmt: skip
    upper.set(ylabel="static hub displacement,\nerror against exact series, %")
    upper.legend(frameon=False)
    below = "share of the approach\nbelow the grid, %"
    lower.set(xlabel="surface spacing over contact half-width", ylabel=below, ylim=(-3, 85))
    figure.savefig(path, dpi=160)


def measured() -> tuple[str, str]:
    """Words and table; the picture is drawn."""
    points, rows = [], []
    for kind, sizes in (("subgrid", SUBGRID_MM), ("resolved", RESOLVED_MM)):
        for size in sizes:
            p = measure(kind, size)
            points.append(p)
            rows.append([kind, f"{size:g} mm", f"{p.per_half_width:.3g}", str(p.degrees_of_freedom),
                         f"{p.hub_error:+.4f} %", f"{p.force_error:.4f} %", f"{p.below_grid:.1f} %",
                         f"{p.layer:.2f} %"])  # fmt: skip
            print(p, flush=True)
    plot(points, DOCS / "crossover.png")
    return TEXT, markdown_table(HEADINGS, rows)


TEXT = """Paper's bearing, 2000 N, a roller on the load line, weightless, against the exact series. *Loads*: largest
error of a roller's load over the largest load. *Below the grid*: share of a contact's approach that the
sub-grid term carries at 628 N. *In the layers*: approach of the stiff layer between resolved surfaces over
the hub's displacement."""


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.crossover", ("crossover", "Static hub displacement by mesh", measured))
