"""docs/paper.md: the paper's figures against ours in a table, and what was tried to make the paper's."""

from math import pi, sqrt

import numpy as np

from benchmarks.paper.supports import HALF_SUPPORT, Held
from benchmarks.paper.variants import COARSE, Measured, Range, Variant
from lagrange import contact_laws
from lagrange.ball_contact import delta_star
from lagrange.scene import read_scene
from residual import paper
from residual.figures import HARRIS_POINTS

MINUS = "−"
SINK = 0.5 * abs(sum(paper.INNER_Y))  # m, middle of the paper's y


def text(value: float, digits: int = 3) -> str:
    """A number with a true minus sign, plain from 0.001 to 99 999."""
    shown = f"{value + 0.0:.{digits}g}"
    if "e" in shown and 1e-3 <= abs(value) < 1e5:
        shown = f"{value:.0f}"
    mantissa, _, exponent = shown.partition("e")
    return (f"{mantissa}e{int(exponent)}" if exponent else mantissa).replace("-", MINUS)


def span(ends: Range, scale: float = 1.0, zero: float = 0.0, digits: int = 3) -> str:
    """A range."""
    return f"{text(scale * (ends[0] - zero), digits)} … {text(scale * (ends[1] - zero), digits)}"


def table(heads: list[str], rows: list[list[str]]) -> str:
    """A table in markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def sinking_frequency() -> float:
    """Of the hub on springs that let it sink by SINK under the load, Hz."""
    scene = read_scene().operation
    return sqrt(scene.radial_load_N / (scene.inner_ring_and_shaft_kg * SINK)) / (2.0 * pi)


def harris_force() -> float:
    """Force of the lowest roller by Harris' law if the hub's SINK is shared by its two contacts, N."""
    return float(contact_laws("harris", read_scene().ideal_bearing()).inner.force(np.array(0.5 * SINK)))


def rattle() -> float:
    """Frequency at which the paper's velocity and acceleration of figure 7 belong together, Hz."""
    return paper.ROLLER_ACCELERATION[1] / paper.ROLLER_VELOCITY[1] / (2.0 * pi)


def delta_star_error() -> float:
    """Largest deviation of δ* from Harris' table, which the paper's figure 4 plots, relative."""
    F, wanted = np.array(HARRIS_POINTS).T
    return float(np.max(np.abs(delta_star(F[1:-1]) / wanted[1:-1] - 1.0)))


def variant_rows(measured: list[tuple[Variant, Measured]]) -> list[list[str]]:
    """One row for each run."""
    rows = []
    for variant, m in measured:
        few, many = m.loaded
        rows.append([
            variant.title, span(m.x, 1e6), span(m.y, 1e6), span(m.rho, 1e6, 23e-3), span(m.velocity, 1e3),
            span(m.acceleration, 1.0, digits=2), f"{few}–{many}, {m.usual}",
            *(span(side, 1.0, digits=3) for side in m.harris), *(span(side, 1.0, digits=3) for side in m.fitted),
            text(m.frequency, 4),
        ])  # fmt: skip
    low = [
        "*the paper*", "−80 … 60", "−220 … −80", "−20 … 80", "−400 … 400", "−5000 … 5000", "6–7",
        "−3000 … 3000", "−1000 … 5000", "−3000 … 3000", "−1000 … 5000", f"about {text(rattle(), 2)} (fig. 7)",
    ]  # fmt: skip
    return [low, *rows]


def settings_rows(variants: list[Variant]) -> list[list[str]]:
    return [[v.title, " ".join(f"`--set {s}`" for s in v.settings) or "none"] for v in variants]


def support_rows(cases: list[Held]) -> list[list[str]]:
    return [
        [f"{c.outside_mm:g}", c.supports, span(c.x), span(c.y), f"{c.loaded[0]}–{c.loaded[1]}", text(c.widest)]
        for c in cases
    ]


def coarse_rows(pairs: list[tuple[str, Measured, Measured]]) -> list[list[str]]:
    rows = []
    for title, fine, coarse in pairs:
        for interval, m in (("10 µs", fine), (f"{10 * COARSE} µs", coarse)):
            rows.append([
                title, interval, span(m.velocity, 1e3), span(m.acceleration, 1.0), *(span(s) for s in m.harris),
                *(span(s) for s in m.fitted), text(m.frequency, 4),
            ])  # fmt: skip
    return rows


def page(
    measured: list[tuple[Variant, Measured]], cases: list[Held], pairs: list[tuple[str, Measured, Measured]]
) -> str:
    """The whole page."""
    by = {variant.name: m for variant, m in measured}
    ours, soft, facets = by["ours"], by["soft-rest"], by["soft-facets-0.7"]
    polygon = by["soft-facets-1"]
    hanging = next(c for c in cases if c.supports == "top" and c.outside_mm == min(c.outside_mm for c in cases))
    alone = next(c for c in cases if c.supports == "top" and c.outside_mm == max(c.outside_mm for c in cases))
    figures = table(
        ["figure", "quantity", "paper", "ours", "why they differ, and the run that shows it"],
        [
            ["4", "δ* over F of a point contact", "Harris' curve", f"the same, within {text(100 * delta_star_error(), 2)} %",
             "no difference"],
            ["6", "y of the inner ring, µm", "−220 … −80", span(ours.y, 1e6),
             f"contacts forty times too soft: *soft penalty, load ramped*: {span(soft.y, 1e6)} with {soft.usual} rollers loaded"],
            ["6", "x of the inner ring, µm", "−80 … 60", span(ours.x, 1e6),
             f"polygons: *facets of 0.7 mm* on soft contacts: {span(facets.x, 1e6)}; the soft penalty alone only {span(soft.x, 1e6)}"],
            ["7", "ρ of one roller, mm", "22.98 … 23.08", span(ours.rho, 1e3, digits=6),
             f"the roller takes half the hub's way: *soft penalty, load ramped*: {span(soft.rho, 1e3, digits=5)}"],
            ["7", "ρ′, mm/s", "−400 … 400", span(ours.velocity, 1e3),
             f"the hub swings on soft contacts, at {text(soft.frequency, 4)} Hz in the same run: {span(soft.velocity, 1e3)}"],
            ["7", "ρ″, m/s²", "−5000 … 5000", span(ours.acceleration),
             f"as ρ′: {text(rattle(), 3)} Hz joins the paper's two ranges. The same run has {span(soft.acceleration, digits=2)}, of rollers that "
             "hit the rings undamped, stored every 10 µs"],
            ["text", "rollers loaded", "6–7", f"{ours.loaded[0]}–{ours.loaded[1]}",
             "no difference; it rules out clearance and a ring held at one point"],
            ["8", "left side of (22), N", "−3000 … 3000", span(ours.harris[0]),
             f"*facets of 1 mm, 2e7 N/m*, with the law fitted to that run's forces: {span(polygon.fitted[0])}. "
             "Harris' law on any trajectory that fits figure 6 gives tens of kN (below)"],
            ["9", "left side of (23), N", "−1000 … 5000", span(ours.harris[1]), f"the same: {span(polygon.fitted[1])}"],
            ["10, 11", "peak below 300 Hz", "22 Hz", f"{text(ours.peaks[0], 3)} and {text(ours.peaks[1], 3)} Hz: the first bins",
             "0.06 s have bins 16.7 Hz apart: drift and the cage's 29.3 Hz are one hump there in every run ([spectra](spectra.md)); "
             f"no variant has a line of its own at 22 Hz. Nearest: {text(soft.peaks[0], 3)} and {text(soft.peaks[1], 3)} Hz, bins too"],
        ],
    )  # fmt: skip
    return TEMPLATE.format(
        COARSE,
        figures=figures,
        sink=text(1e6 * SINK),
        frequency=text(sinking_frequency(), 4),
        rattle=text(rattle(), 4),
        harris=text(1e-3 * harris_force()),
        soft_frequency=text(soft.frequency, 4),
        soft_y=span(soft.y, 1e6),
        variants=table(
            ["run", "x, µm", "y, µm", "ρ − 23 mm, µm", "ρ′, mm/s", "ρ″, m/s²", "loaded, usually", "(22) Harris, N",
             "(23) Harris, N", "(22) fitted, N", "(23) fitted, N", "y moves at, Hz"],
            variant_rows(measured),
        ),  # fmt: skip
        settings=table(["run", "options of run-fem"], settings_rows([variant for variant, _ in measured])),
        supports=table(
            ["outside diameter, mm", "held", "x, µm", "y, µm", "rollers loaded", "raceway moves, µm"], support_rows(cases)
        ),
        half=text(2e3 * HALF_SUPPORT),
        alone=span(alone.y),
        hanging=span(hanging.y),
        hanging_loaded=f"{hanging.loaded[0]}–{hanging.loaded[1]}",
        clearance=span(by["clearance"].y, 1e6),
        clearance_loaded=f"{by['clearance'].loaded[0]}–{by['clearance'].loaded[1]}",
        facets_2=span(by["facets-2"].y, 1e6),
        facets_2_cage=text(by["facets-2"].cage, 2),
        facets_2_loaded=by["facets-2"].usual,
        facets_half=span(by["facets-0.5"].y, 1e6),
        facets_half_x=span(by["facets-0.5"].x, 1e6),
        soft_half_x=span(by["soft-facets-0.5"].x, 1e6),
        soft_facets_x=span(facets.x, 1e6),
        soft_facets_rho=span(facets.rho, 1e6, 23e-3),
        coarse=table(
            ["run", "stored every", "ρ′, mm/s", "ρ″, m/s²", "(22) Harris, N", "(23) Harris, N", "(22) fitted, N",
             "(23) fitted, N", "y moves at, Hz"],
            coarse_rows(pairs),
        ),  # fmt: skip
    )


TEMPLATE = """# The paper's figures and ours

Rubio, García Prada, Castejón and Laniado (IFToMM, 2007) show figures of a commercial finite-element program that differ from this program's
by up to two orders of magnitude. The paper does not tell mesh, contact stiffness, sampling or supports, so each of these was
tried here, on its bearing, load and speed, for its 60 ms. All numbers on this page come from `python -m benchmarks.paper`, which makes it.

![Figures 6 to 11, ours and the paper's ranges](paper.png)

*Left: the default. Right: at the paper's scale, with the range of its figure as a band, and the run that comes nearest to most of them.
The left sides are with Harris' law for the default, with the law fitted to the run's own forces for the other.*

{figures}

Ranges are read off the paper's axes; ours leave out the first millisecond. (23) is drawn with its sign turned, around the load, as in the paper.

## What explains most of it: contacts that are too soft

The paper's y of −{sink} µm and the rattle in its figure 7 are one number. A hub that sinks by y under the load W on nearly linear springs swings at
√(W / (M y)) / 2π = {frequency} Hz, without damping for as long as the record lasts. The velocities and accelerations of figure 7
belong together at ρ″/ρ′ = {rattle} Hz. The penalty run sinks and swings so: with 8.3e6 N/m per contact, a fortieth of
Hertz's, and the load ramped up in 0.4 ms, y moves within {soft_y} µm at {soft_frequency} Hz, and as many rollers are loaded as in the paper.
Penalty stiffness is a numerical choice, so a value this low would come from a program's setting and not from steel.

Clearance would let the hub down as far ({clearance} µm with 0.28 mm), but leaves {clearance_loaded} rollers loaded, not 6–7.

## What it leaves: the sideways motion

A soft, smooth contact moves the hub in x by less than half of what the paper shows. Polygons do more: a facet of
length h lies h²/8R below its circle, 6 µm for h = 0.5 mm on the roller and 100 µm for 2 mm, against a Hertz approach of 2 µm. Rollers rattle over them and roll
unsteadily. With stiff contacts facets alone don't fit: those of 2 mm give y = {facets_2} µm, but usually {facets_2_loaded} loaded
roller(s), and a cage slowed to {facets_2_cage} Hz; those of 0.5 mm give y = {facets_half} µm, x = {facets_half_x} µm. On soft contacts facets of 0.5 mm give
x = {soft_half_x} µm and of 0.7 mm {soft_facets_x} µm, the paper's ± 70; but then ρ spreads over {soft_facets_rho} µm, more than in the paper,
for nothing damps the rollers here.

## What doesn't fit together in the paper

With y = −{sink} µm shared by the two contacts of the lowest roller, Harris' law (12) asks {harris} kN of that roller alone, against a load of 2 kN.
So figures 8 and 9, within ± 3000 N, can't be (22) and (23) with Harris' law and the displacements of figures 6 and 7 in a bearing
without clearance. All runs with soft or faceted contacts show that: with Harris' law their left sides reach tens to
hundreds of kN, with a law fitted to each run's own forces tens of N to some kN (table). That figures 8 and 9 used some such law is a guess.

## Every run

![Ranges of all runs](paper-variants.png)

{variants}

*fitted*: with K and n of Q = K δⁿ identified on the run's own contact forces (`check-residual --law fitted`), and (22) in the picture is that one.

{settings}

## An outer ring held at few points

Statics of the finite elements (1 mm) with the ring's outside held over {half} mm around each point, elsewhere free; the rollers at four places of a pitch.
The paper gives no outside diameter.

{supports}

Two or three points cost some micrometres. A ring hung up at one point of its top sinks by {alone} µm, and one of only 2 mm thickness
by {hanging} µm: as far as in the paper, but it closes around the rollers and loads {hanging_loaded} of them. A run can't have such
supports: the outer ring of this program is held all around.

## Samples stored too seldom

The paper's curves may stand on a few hundred samples. Taking every {0}th of ours:

{coarse}

Where the motion is smooth this changes next to nothing, and it makes none of the paper's numbers out of the default run. Where it rattles, differences of
samples so far apart are not the accelerations any more: at 2.5 kHz the record's Nyquist frequency is near the hub's own.

## What was not reproduced

* All ranges in one run. The soft penalty has y, ρ, ρ′ and the number of rollers; facets on it have x; facets with a fitted law have (22) and (23).
* A line at 22 Hz.
* Units and heights of the spectra: the paper gives no unit.

The comparison contacts are `[contact] model = "penalty"` and `"faceted"` ([README](../README.md#scene-file)). Their energy balances to better than 1 %
(`tests/test_comparison_contacts.py`), the default's to 1e-6. Sagittas are taken on the line of centres; corners are rounded over 2 % of a facet.
"""
