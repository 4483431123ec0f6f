"""From meshes far coarser than a contact to meshes that resolve it: `python -m tests.accuracy.crossover`.

Static hub displacement of the paper's bearing by both contact models, against the exact series; and what share of a
contact's approach the law below the grid still carries. Writes docs/crossover.md and docs/crossover.png.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fem.contacts.model import Model, Motion, standing
from fem.contacts.resolved import ResolvedModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import read_scene
from tests.measurements import DOCS, markdown_table, program
from tests.reference.contact_pressures import contact_pressures, layer_approach

SUBGRID_MM = (2.0, 1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.0105)
RESOLVED_MM = (0.03, 0.021, 0.015, 0.0105)


@dataclass(frozen=True, kw_only=True)
class Point:
    """Results of one mesh under one contact model."""

    model: str
    size_mm: float
    per_half_width: float  # surface spacing over the half-width of the most loaded inner contact
    degrees_of_freedom: int
    hub_error: float  # relative, signed
    force_error: float  # of any roller over the largest force
    below_grid: float  # share of the most loaded inner contact's approach
    layer: float  # approach in the layers of the most loaded roller over the hub's displacement


def measure(kind: str, size_mm: float) -> Point:
    """Solve the statics on one mesh."""
    scene = read_scene()
    bearing = scene.ideal_bearing()
    how = replace(scene.ideal_operation(), gravity=0.0)
    size = 1e-3 * size_mm
    exact = exact_statics(bearing, how.radial_load, how.first_roller_angle)
    force = float(exact.inner_force.max())
    widths = [pair.half_width(force) for pair in contact_pairs(bearing)[:2]]
    if kind == "resolved":
        model = ResolvedModel.build(bearing, size)
    elif size < SpreadModel.coarsest * max(widths):
        model = SpreadModel.of_force(bearing, size, force)
    else:
        model = SubgridModel.build(bearing, size)
    still = standing(bearing, how.first_roller_angle)
    found = equilibrium(model, still, Loads(how.radial_load))
    angles = roller_angles(bearing, how.first_roller_angle)
    whole = float(exact_contacts(bearing, angles).inner_law.approach(force))
    return Point(
        model=kind, size_mm=size_mm, per_half_width=size / widths[0], degrees_of_freedom=model.degrees_of_freedom,
        hub_error=float(found.hub[1] / exact.hub[1] - 1.0),
        force_error=float(np.abs(found.inner_force - exact.inner_force).max() / force),
        below_grid=_below(model, still, how.radial_load, force) / whole,
        layer=_in_layers(model, force) / abs(float(exact.hub[1])) if kind == "resolved" else 0.0,
    )  # fmt: skip


def _below(model: Model, still: Motion, load: float, force: float) -> float:
    """Approach that the term below the grid adds to the most loaded inner contact, m."""
    if not isinstance(model, SpreadModel):
        return float(model.inner_law.approach(force))
    law = model.inner_law
    found = max(contact_pressures(model, still, load)[: model.bearing.n_rollers], key=lambda p: p.pressure.sum())
    forces = found.pressure * law.spacing * law.pair.length
    return float(forces @ law.local_compliance(forces.size) @ forces / forces.sum())


def _in_layers(model: Model, force: float) -> float:
    return layer_approach(model.inner_law, force) + layer_approach(model.outer_law, force)


HEADINGS = (
    "contact", "mesh", "mesh / half-width", "degrees of freedom", "hub displacement", "loads", "below the grid",
    "in the layers",
)  # fmt: skip


def rows(points: list[Point]) -> list[list[str]]:
    """Cells of the table's rows."""
    return [
        [
            p.model, f"{p.size_mm:g} mm", f"{p.per_half_width:.3g}", f"{p.degrees_of_freedom}",
            f"{100 * p.hub_error:+.4f} %", f"{100 * p.force_error:.4f} %", f"{100 * p.below_grid:.1f} %",
            f"{100 * p.layer:.2f} %",
        ]
        for p in points
    ]  # fmt: skip


def plot(points: list[Point], path: Path) -> None:
    """Draw error and the sub-grid law's share against mesh size over half-width."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.5, 6.2), sharex=True, layout="constrained", height_ratios=[3, 2]
    )
    for kind, color, marker in (("subgrid", "#0072B2", "o"), ("resolved", "#D55E00", "s")):
        mine = [p for p in points if p.model == kind]
        x = [p.per_half_width for p in mine]
        upper.loglog(x, [100 * abs(p.hub_error) for p in mine], marker + "-", color=color, label=kind)
        lower.semilogx(x, [100 * p.below_grid for p in mine], marker + "-", color=color)
    mine = [p for p in points if p.model == "resolved"]
    upper.loglog(
        [p.per_half_width for p in mine], [100 * p.layer for p in mine], "--", color="#D55E00",
        label="resolved: what the contact layer yields",
    )  # fmt: skip
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
    lower.set(
        xlabel="surface spacing over contact half-width", ylabel="share of the approach\nbelow the grid, %",
        ylim=(-3, 85),
    )  # fmt: skip
    figure.savefig(path, dpi=160)


def measured() -> tuple[str, str]:
    """Words and table; the picture is drawn."""
    points = []
    for kind, sizes in (("subgrid", SUBGRID_MM), ("resolved", RESOLVED_MM)):
        for size in sizes:
            points.append(measure(kind, size))
            print(points[-1], flush=True)
    plot(points, DOCS / "crossover.png")
    return TEXT, markdown_table(HEADINGS, rows(points))


TEXT = """Paper's bearing, 2000 N, a roller on the load line, weightless, against the exact series. *Loads*: largest
error of a roller's load over the largest load. *Below the grid*: share of a contact's approach that the
sub-grid term carries at 628 N. *In the layers*: approach of the stiff layer between resolved surfaces over
the hub's displacement."""


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.crossover", ("crossover", "Static hub displacement by mesh", measured))
