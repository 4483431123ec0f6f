"""docs/elements.md."""

from benchmarks.elements.candidates import SOLVERS
from benchmarks.elements.compare import ratio_rows, rows
from benchmarks.elements.measure import Point


def page(points: list[Point], commit: str) -> str:
    """The page with its tables."""
    return TEXT.format(
        commit=commit,
        ratios="\n\n".join(_markdown(ratio_rows(points, body)) for body in SOLVERS),
        figures="\n\n".join(f"### {body.capitalize()}\n\n{_markdown(rows(points, body))}" for body in SOLVERS),
    )


def _markdown(cells: list[list[str]]) -> str:
    lines = [cells[0], ["---"] * len(cells[0]), *cells[1:]]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


TEXT = """# Which elements?

Would other elements or meshes give an explicit step less work per error? Tried on the paper's roller and rings
(steel, 10 mm long, the roller free, the rings held on their other circle) against exact values. Made at commit
{commit} by

```sh
python -m benchmarks.elements      # some minutes
```

## What is compared

* **Elements.** P1, P2 triangles; Q1, Q2 (nine nodes), S2 (eight nodes) quadrilaterals; P2 with a bubble; Q1
  integrated at one point, with the hourglass stiffness of pure bending. Second order follows the circles. In bold
  what the solver has.
* **Masses.** Row sums where they are positive: P1, Q1, Q2, P2 with a bubble. They vanish at the corners of P2 and are
  negative, a twelfth of the cell, at those of S2: these two take the scaled diagonal of the consistent mass (HRZ).
  The total is the exact circle's; the solver's roller keeps its correction of the rim.
* **Meshes.** Roller: the solver's concentric layers (P1, P2), Frontal-Delaunay triangles, quadrilaterals, coarse ones
  mapped and fine ones joined from Frontal-Delaunay triangles by Blossom. Rings: the solver's sectors, and
  near-equilateral triangles, every other row turned by half a sector. All are given by the spacing of their surface
  nodes, middles of edges included.
* **Cost.** Multiply-adds of K·u, four for every pair of coupled nodes, times the steps of one simulated millisecond
  at 0.9 of the critical step 2/ω_max of that body alone. Bytes don't count: sixteen rollers share a matrix and equal
  sectors share a row of coefficients. The rings' mirror symmetry, which halves their work in the solver, would halve
  it for all of them. Moving a node is left out: 16 multiply-adds in a roller, by which second order gains up to
  another fifth there.
* **Smooth pressure.** Compliance under a cubic B-spline of pressure of half-width 2 mm, averaged by itself, without
  the solver's calibration; the roller squeezed by two. Errors: rms over 24 places, against the series of
  `fem.elastic.continuum`.
* **Coupling, calibrated.** What is left when compliance in place is calibrated, as the solver does it: how far its
  patch of six surface nodes moves another one, a pitch further on a ring, a quarter round a squeezed roller, against
  two Hertz contacts; error over the exact approach.
* **Ripple.** Peak to peak of the compliance under that patch as it travels, over the exact approach: what the
  calibration has to take away.
* **Frequencies.** The 7 lowest of the roller (n = 2, 1, 3 twice, 0), 13 of a ring (0, and 1 to 6 twice), rms error
  against the roots of the exact equations, *as stepped* with leapfrog's own error at that step, and of the mesh alone
  (step → 0).

![Error against cost; grey: errors of 0.1 to 1 %, circle: the solver's mesh of 1 mm](elements.png)

## Cost at equal error

Multiply-adds over those of the solver's element, in brackets steps over its steps; between meshes by straight lines
in logarithms. ≤: the coarsest mesh tried is good enough. –: the solver's coarsest mesh is (the outer ring's couplings
are below 0.04 % on every mesh), or a finest one is not.

{ratios}

## What it shows

* **No element allows a longer step at equal surface spacing** but Q1 with one point, by 3 % at most. Second order has
  a step a sixth to a half shorter and up to 2.3 times the work per node: it can only win by coarser meshes.
* **Static answers, calibrated:** the width of the patch decides, that is the spacing of the surface nodes, not the
  element. On rollers nothing is more than a third cheaper than P1 at 0.1 to 0.3 % and second order is dearer, up to
  3.4 times; on the inner ring only Q1 with one point is cheaper (0.6), its frequencies 1.6 times as far off.
* **Frequencies:** at 1 % nothing beats the solver's P1 on rollers. At 0.3 % Q2 costs a third, at 0.1 % a sixth, with
  0.6 and 0.5 of the steps; P2 with a bubble 0.6 and 0.3. On the rings Q2 costs a quarter or less from 0.3 % down.
  Scaled diagonals cost P2 and S2 their order: only row sums that are an exact enough quadrature keep it.
* **Luck of signs:** lumped masses lower frequencies and leapfrog raises them. P2 on the outer ring owes most of its
  place to that (1 mm: 0.08 % of the mesh alone, 0.007 % as stepped), and so do its P1 and the coarsest Q2 there. In
  the rings the step is by far the larger error of Q2 from 0.1 % down.
* **Compliance without calibration:** second order wins early, at 1 % by factors of two to six. The solver has no use
  for it: that is the error its calibration removes.
* **Would a change pay? Not for what this program is for.** Its results are nearly static: with frequencies 0.3 to 0.7
  % off, a mesh of 1 mm has the hub's mean and the varying compliance within about 0.02 %, one of 2 mm within 0.1 %
  ([work_precision.md](work_precision.md)). On 2 mm contacts and friction, which no element makes cheaper, are more
  than half of a step ([performance.md](performance.md)). The bearing's step is the shortest of its bodies', so
  rollers and both rings would have to change together. Who wants spectra above 100 kHz to better than 0.3 % would
  gain: Q2 in all three bodies, three to six times less arithmetic in the rollers, half to two thirds of the steps.
* **What the figures can't show.** The patch wants equal surface nodes. Middles and corners of second-order edges
  weigh differently: as the patch travels compliance ripples by 2 to 5 % (rings now 0.2 %, roller 1 to 2 % along a
  sextant), with a period of two nodes that the calibration would have to carry, or the patch would need weights of
  its own. Rows of 9, 15 and 25 blocks in place of about 7 everywhere make uneven loops; a ring's stencil would have
  four kinds of nodes in place of one. Quadrilaterals in a disc need care: gmsh's coarse ones have corners of 180° on
  the circle, mapped fine ones shrink inside.
* **What it would take on the rollers:** their kernel takes any rows of 2 x 2 blocks. New would be meshes with middle
  nodes, quadratic assembly with exact masses, patch weights for quadratic edges with a calibration of period two,
  stress recovery, pictures and export for nine-node cells.

## Figures

{figures}
"""
