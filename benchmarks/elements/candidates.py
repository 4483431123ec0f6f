"""Which element on which mesh is tried on which body."""

from dataclasses import replace

from benchmarks.elements import grids
from benchmarks.elements.bodies import Body
from benchmarks.elements.discretisations import Discrete, discretise
from benchmarks.verification.shapes import LENGTH, STEEL, disc

SECOND_ORDER = ("P2", "P2 + bubble", "Q2", "S2")

ON_DISC = {
    "P1": (grids.disc_layers, "P1"),
    "P1, Frontal-Delaunay": (grids.disc_frontal, "P1"),
    "P2": (grids.disc_layers, "P2"),
    "P2 + bubble": (grids.disc_layers, "P2 + bubble"),
    "Q1": (grids.disc_quads, "Q1"),
    "Q1, one point": (grids.disc_quads, "Q1, one point"),
    "Q2": (grids.disc_quads, "Q2"),
    "S2": (grids.disc_quads, "S2"),
}
ON_RING = {
    "P1": (grids.ring_triangles, "P1"),
    "P2": (grids.ring_triangles, "P2"),
    "P2 + bubble": (grids.ring_triangles, "P2 + bubble"),
    "Q1": (grids.ring_quads, "Q1"),
    "Q1, one point": (grids.ring_quads, "Q1, one point"),
    "Q2": (grids.ring_quads, "Q2"),
    "S2": (grids.ring_quads, "S2"),
}
SOLVERS = {"roller": "P1", "inner ring": "Q1", "outer ring": "Q1"}
SIZES_MM = (3.0, 2.0, 1.5, 1.0, 0.75, 0.5, 0.35, 0.25, 0.2)  # of the surface spacing


def candidates(body: Body) -> dict:
    """Mesh maker and element by name."""
    return ON_DISC if body.held is None else ON_RING


def build(body: Body, candidate: str, size: float) -> Discrete:
    """A candidate whose surface nodes are about `size`, m, apart."""
    make, element = candidates(body)[candidate]
    shape = (body.raceway,) if body.held is None else (*body.circles, body.raceway)
    mesh = make(*shape, size, 2 if element in SECOND_ORDER else 1)
    discrete = discretise(mesh, element, STEEL, LENGTH, body.area)
    if body.held is None and candidate == SOLVERS[body.name]:
        # the solver moves mass from the surface inwards, which its modes gain from
        layers = len(mesh.boundary_facets()) // 6
        discrete = replace(discrete, mass=disc(body.raceway, layers).mass)
    return discrete
