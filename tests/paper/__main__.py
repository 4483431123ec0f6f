"""docs/measurements/paper.md: the paper's figures against ours, and runs with other contacts and samples.

`python -m tests.paper [FOLDER] [--write]`: runs are kept in FOLDER (default runs/paper-variants) and used again.
"""

from math import pi, sqrt
from pathlib import Path

import numpy as np

from lagrange import contact_laws
from lagrange.contact.hertz import delta_star
from lagrange.scene.scene import read_scene
from tests.measurements import DOCS, markdown_table, program
from tests.paper import variants as read_off
from tests.paper.variants import COARSE, Measured, Range, Variant, measure, record_of

NEAREST, SIDEWAYS = "soft-rest", "soft-facets-1"  # the runs drawn beside ours
POLYGONS = "less-soft-facets-1"
ROLLER = ("ρ′, mm/s", "ρ″, m/s²")
SIDES = ("(22) Harris, N", "(23) Harris, N", "(22) fitted, N", "(23) fitted, N", "y moves at, Hz")
SINK = 0.5 * abs(sum(read_off.INNER_Y))  # m, middle of the paper's y
_SCENE = read_scene()
_SPRING = _SCENE.operation.radial_load_N / SINK  # N/m
SINKING = sqrt(_SPRING / _SCENE.operation.inner_ring_and_shaft_kg) / (2.0 * pi)  # Hz, of the hub on it
# N, of the lowest roller by Harris' law if the hub's SINK is shared by its two contacts
HARRIS_FORCE = float(contact_laws("harris", _SCENE.ideal_bearing()).inner.force(np.array(0.5 * SINK)))
# Hz, at which the paper's velocity and acceleration of figure 7 belong together
RATTLE = read_off.ROLLER_ACCELERATION[1] / read_off.ROLLER_VELOCITY[1] / (2.0 * pi)
# F and δ* of figure 4. Source: Harris, Rolling Bearing Analysis, table of dimensionless quantities
HARRIS_POINTS = (
    (0.0, 1.0), (0.1075, 0.9974), (0.3204, 0.9761), (0.5916, 0.9077), (0.7332, 0.8394), (0.87366, 0.7169),
    (0.93657, 0.6112), (0.9729, 0.4960), (0.990902, 0.3745), (0.9973, 0.2705), (0.9998527, 0.11995),
)  # fmt: skip
PAPER = [  # its row among the runs
    "*the paper*", "−80 … 60", "−220 … −80", "−20 … 80", "−400 … 400", "−5000 … 5000", "6–7", "−3000 … 3000",
    "−1000 … 5000", "−3000 … 3000", "−1000 … 5000",
]  # fmt: skip
FITTED = """*Fitted*: with K and n of Q = K δⁿ identified on the run's own contact forces (`check-residual --law
fitted`). *Energy error*: of the balance, over the largest energy that bodies and contacts store."""


def text(value: float, digits: int = 3) -> str:
    """Write a number with a true minus sign, plain from 0.001 to 99 999."""
    shown = f"{value + 0.0:.{digits}g}"
    if "e" in shown and 1e-3 <= abs(value) < 1e5:
        shown = f"{value:.0f}"
    mantissa, _, exponent = shown.partition("e")
    return (f"{mantissa}e{int(exponent)}" if exponent else mantissa).replace("-", "−")


def span(ends: Range, scale: float = 1.0, zero: float = 0.0, digits: int = 3) -> str:
    return f"{text(scale * (ends[0] - zero), digits)} … {text(scale * (ends[1] - zero), digits)}"


def paper(folder: Path = Path("runs/paper-variants"), /):
    from tests.paper.figures import draw_records, draw_variants

    folder.mkdir(parents=True, exist_ok=True)
    runs, measured = {}, []
    for variant in read_off.VARIANTS:
        runs[variant.name] = record_of(variant, folder)
        measured.append((variant, measure(runs[variant.name])))
        print(variant.title, measured[-1][1], flush=True)
    fine = {variant.name: found for variant, found in measured}
    titles = {variant.name: variant.title for variant, _ in measured}
    sparse = {name: measure(runs[name], COARSE) for name in ("ours", NEAREST, SIDEWAYS)}
    drawn = [runs[name] for name in sparse]
    draw_records(DOCS / "paper.png", *drawn, (titles[NEAREST], titles[SIDEWAYS]))
    draw_variants(DOCS / "paper-variants.png", measured)

    yield "paper", "Figures", figures_table(fine, titles, sparse)
    options = [[v.title, " ".join(f"`--set {s}`" for s in v.settings) or "none"] for v, _ in measured]
    heads = ["run", "x, µm", "y, µm", "ρ − 23 mm, µm", *ROLLER, "loaded, usually", *SIDES, "energy error"]
    rows = [[*PAPER, f"{text(RATTLE, 4)} (fig. 7)", ""], *(run_row(*each) for each in measured)]
    settings = markdown_table(["run", "options of run-fem"], options)
    yield "paper", "Runs", FITTED, markdown_table(heads, rows), settings
    rows = [
        [titles[name], interval, span(m.velocity, 1e3), span(m.acceleration), *map(span, (*m.harris, *m.fitted)),
         text(m.frequency, 4)]
        for name in sparse for interval, m in (("10 µs", fine[name]), (f"{10 * COARSE} µs", sparse[name]))
    ]  # fmt: skip
    yield "paper", "Sparse samples", markdown_table(["run", "stored every", *ROLLER, *SIDES], rows)


def run_row(variant: Variant, m: Measured) -> list[str]:
    return [
        variant.title, span(m.x, 1e6), span(m.y, 1e6), span(m.rho, 1e6, 23e-3), span(m.velocity, 1e3),
        span(m.acceleration, 1.0, digits=2), f"{m.loaded[0]}–{m.loaded[1]}, {m.usual}",
        *map(span, (*m.harris, *m.fitted)), text(m.frequency, 4),
        f"{100 * m.imbalance:.2g} %" if m.imbalance > 1e-5 else "below 0.001 %",
    ]  # fmt: skip


def figures_table(run: dict[str, Measured], titles: dict[str, str], sparse: dict[str, Measured]) -> str:
    """The paper's figures, ours, and the run that makes such numbers."""
    ours, soft, facets, polygon = (run[name] for name in ("ours", NEAREST, SIDEWAYS, POLYGONS))
    stepped, coarse = run["soft"], sparse[SIDEWAYS]
    F, wanted = np.array(HARRIS_POINTS).T
    off = float(np.max(np.abs(np.array([delta_star(f) for f in F[1:-1]]) / wanted[1:-1] - 1.0)))
    return markdown_table(
        ["figure", "quantity", "paper", "ours", "what makes such numbers, and the run that shows it"],
        [
            ["4", "δ* over F of a point contact", "Harris' curve",
             f"the same within {text(100 * off, 2)} %", "no difference"],
            ["6", "y of the inner ring, µm", "−220 … −80", span(ours.y, 1e6),
             f"contacts forty times too soft. *{titles[NEAREST]}*: {span(soft.y, 1e6)}, {soft.usual} rollers loaded"],
            ["6", "x of the inner ring, µm", "−80 … 60", span(ours.x, 1e6),
             f"polygons. *{titles[SIDEWAYS]}*: {span(facets.x, 1e6)}; the soft penalty without them "
             f"{span(soft.x, 1e6)}"],
            ["7", "ρ of one roller, mm", "22.98 … 23.08", span(ours.rho, 1e3, digits=6),
             f"it takes half the hub's way. *{titles['soft']}*: {span(stepped.rho, 1e3, digits=5)}; with the load "
             f"ramped up {span(soft.rho, 1e3, digits=5)}, as nothing damps rollers outside the load zone"],
            ["7", "ρ′, mm/s", "−400 … 400", span(ours.velocity, 1e3),
             f"the hub swings on soft contacts. *{titles[NEAREST]}*: {span(soft.velocity, 1e3)}, "
             f"at {text(soft.frequency, 4)} Hz, and about the paper's in its first load zone (picture)"],
            ["7", "ρ″, m/s²", "−5000 … 5000", span(ours.acceleration),
             f"as ρ′: the paper's two ranges belong together at {text(RATTLE, 3)} Hz. The same run: "
             f"{span(soft.acceleration, digits=2)}, of rollers that hit the rings; with a sample every "
             f"{10 * COARSE} µs only {span(sparse[NEAREST].acceleration, digits=2)}"],
            ["text", "rollers loaded", "6–7", f"{ours.loaded[0]}–{ours.loaded[1]}",
             "no difference; it rules out clearance, and a ring held at one point"],
            ["8", "left side of (22), N", "−3000 … 3000", span(ours.harris[0]),
             f"not for certain. With Harris' law *{titles['soft']}* has {span(stepped.harris[0])}, but its (23) is "
             f"wrong; with the law fitted to the run's forces *{titles[SIDEWAYS]}*, stored every {10 * COARSE} µs, has "
             f"{span(coarse.fitted[0])}, *{titles[POLYGONS]}* {span(polygon.fitted[0])}"],
            ["9", "left side of (23), N", "−1000 … 5000", span(ours.harris[1]),
             f"as figure 8: the fitted law gives {span(coarse.fitted[1])} and {span(polygon.fitted[1])}; "
             "Harris' law tens of kN in every run that fits figure 6 without clearance (below)"],
            ["10, 11", "peak below 300 Hz", "22 Hz",
             f"{text(ours.peaks[0], 3)} and {text(ours.peaks[1], 3)} Hz, the first bins",
             "bins are 16.7 Hz apart: drift and the cage's 29.3 Hz are one hump there ([spectra](../spectra.md)). No "
             f"variant has a line of its own at 22 Hz; nearest: {text(soft.peaks[0], 3)} and "
             f"{text(soft.peaks[1], 3)} Hz, bins too"],
        ],
    )  # fmt: skip


if __name__ == "__main__":
    program(__doc__, "tests.paper", paper)
