"""Candidates at equal error: tables and the plot."""

from pathlib import Path

import numpy as np

from benchmarks.elements.candidates import SOLVERS
from benchmarks.elements.measure import Point

QUANTITIES = {
    "compliance": "smooth pressure",
    "coupling": "coupling, calibrated",
    "frequencies": "frequencies, as stepped",
}
TOLERANCES = {"compliance": (0.03, 0.01), "coupling": (0.003, 0.001), "frequencies": (0.01, 0.003, 0.001)}
LISTED_MM = (2.0, 1.0, 0.5, 0.25)
HEADINGS = (
    "element", "spacing, mm", "degrees of freedom", "multiply-adds of K·u", "critical step, ns",
    "G multiply-adds per ms", *QUANTITIES.values(), "frequencies, step → 0", "ripple",
)  # fmt: skip
COLORS = {
    "P1": "#0072B2", "P1, Frontal-Delaunay": "#56B4E9", "P2": "#009E73", "P2 + bubble": "#7A8B00",
    "Q1": "#D55E00", "Q1, one point": "#E69F00", "Q2": "#882255", "S2": "#CC79A7",
}  # fmt: skip
MARKERS = dict(zip(COLORS, "osv^DPX<", strict=True))


def at_tolerance(points: list[Point], quantity: str, tolerance: float) -> tuple[float, float, bool] | None:
    """Cost and steps of one simulated millisecond at which an error stays within a tolerance.

    `points` are one candidate's, coarsest first. Between meshes both are interpolated along straight lines in
    logarithms; the error of a mesh counts as no smaller than that of any finer one, so an error that happens to pass
    through zero is no merit. True: the coarsest mesh is within the tolerance already, a coarser one might be.
    None: the finest is not.
    """
    error = np.maximum.accumulate([getattr(p, quantity) for p in points[::-1]])[::-1]
    within = np.flatnonzero(error <= tolerance)
    if not within.size:
        return None
    i = within[0]
    if i == 0:
        return points[0].cost, points[0].steps, True
    share = np.log(tolerance / error[i]) / np.log(error[i - 1] / error[i])
    fine, coarse = points[i], points[i - 1]
    return fine.cost * (coarse.cost / fine.cost) ** share, fine.steps * (coarse.steps / fine.steps) ** share, False


def ratio_rows(points: list[Point], body: str) -> list[list[str]]:
    """Heading, then per candidate the cost over that of the solver's element, (steps over steps), at equal error."""
    columns = [(quantity, tolerance) for quantity, several in TOLERANCES.items() for tolerance in several]
    rows = [[body, *[f"{QUANTITIES[quantity]}, {100 * tolerance:g} %" for quantity, tolerance in columns]]]
    mine = by_candidate(points, body)
    for name, some in mine.items():
        cells = []
        for quantity, tolerance in columns:
            found, ours = (at_tolerance(each, quantity, tolerance) for each in (some, mine[SOLVERS[body]]))
            if found is None or ours is None or ours[2]:
                cells.append("–")
            else:
                sign = "≤ " if found[2] else ""
                cells.append(f"{sign}{found[0] / ours[0]:.2f} ({found[1] / ours[1]:.2f})")
        rows.append([f"**{name}**" if name == SOLVERS[body] else name, *cells])
    return rows


def rows(points: list[Point], body: str) -> list[list[str]]:
    """Heading and figures of the listed sizes."""
    found = [list(HEADINGS)]
    for name, some in by_candidate(points, body).items():
        for p in some:
            if p.size_mm in LISTED_MM:
                found.append(
                    [
                        f"**{name}**" if name == SOLVERS[body] else name, f"{p.spacing_mm:.2f}", f"{p.freedom}",
                        f"{p.multiply_adds}", f"{1e9 * p.critical_step:.1f}", f"{1e-9 * p.cost:.3g}",
                        *[f"{100 * getattr(p, q):.2g} %" for q in (*QUANTITIES, "frequencies_still", "ripple")],
                    ]
                )  # fmt: skip
    return found


def by_candidate(points: list[Point], body: str) -> dict[str, list[Point]]:
    names = dict.fromkeys(p.candidate for p in points if p.body == body)
    return {name: [p for p in points if p.body == body and p.candidate == name] for name in names}


def plot(points: list[Point], path: Path) -> None:
    """Error against cost: a row for each quantity, a column for each body."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(3, 3, figsize=(11.0, 10.0), layout="constrained", sharex="col", sharey="row")
    for column, body in zip(panels.T, SOLVERS, strict=True):
        for axes, quantity in zip(column, QUANTITIES, strict=True):
            axes.axhspan(0.1, 1.0, color="0.93", zorder=0)
            for name, some in by_candidate(points, body).items():
                solvers = name == SOLVERS[body]
                x, y = [1e-9 * p.cost for p in some], [100.0 * getattr(p, quantity) for p in some]
                axes.loglog(
                    x, y, MARKERS[name] + "-", color=COLORS[name], label=name, markersize=4.5,
                    linewidth=2.8 if solvers else 1.2, zorder=3 if solvers else 2,
                )  # fmt: skip
                if solvers:
                    at = [p.size_mm for p in some].index(1.0)
                    axes.plot(x[at], y[at], "o", color="none", markeredgecolor="black", markersize=11, zorder=4)
                    axes.annotate(
                        "1 mm", (x[at], y[at]), xytext=(-8, -10), textcoords="offset points", ha="right", va="top",
                        fontsize=9, zorder=5, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
                    )  # fmt: skip
            axes.grid(True, color="0.88", zorder=0)
        column[0].set_title(f"{body} (solver: {SOLVERS[body]})", fontsize=11)
        column[-1].set_xlabel("G multiply-adds of K·u for 1 ms")
    for axes, words in zip(panels[:, 0], QUANTITIES.values(), strict=True):
        axes.set_ylabel(f"{words}:\nerror, %")
    handles = {}
    for axes in panels[0]:
        handles.update(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    figure.legend([handles[name] for name in COLORS], list(COLORS), loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=150)
