"""The comparison of elements: the solver's own among them, patch tests, masses, orders against exact values."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from skfem import Basis, ElementQuad1, ElementVector, MeshQuad

sys.path.insert(0, str(Path(__file__).parent / "reference"))
from bearings import LENGTH, STEEL, disc, own_folder, ring

from benchmarks.elements.bodies import paper_bodies
from benchmarks.elements.candidates import ON_DISC, ON_RING, SOLVERS, build
from benchmarks.elements.compare import at_tolerance
from benchmarks.elements.discretisations import ELEMENTS, diagonal_scaled, one_point_stiffness, row_sums
from benchmarks.elements.grids import ring_quads, ring_triangles
from benchmarks.elements.measure import Point, measure

ROLLER, INNER, OUTER = paper_bodies()
EVERY = [(ROLLER, name) for name in ON_DISC] + [(INNER, name) for name in ON_RING]
every_candidate = pytest.mark.parametrize("body, name", EVERY, ids=[f"{body.name}, {name}" for body, name in EVERY])


@pytest.fixture(autouse=True)
def folder():
    with own_folder():
        yield


def disc_step(body):
    mass = np.repeat(body.mass, 2)
    return 2.0 / np.sqrt(eigh(body.stiffness.toarray(), np.diag(mass), eigvals_only=True)[-1])


def ring_step(body):
    keep = (2 * body.free_rows[:, None] + np.arange(2)).ravel()
    stiffness = body.harmonic_stiffness(np.arange(body.n_sectors))[:, keep][:, :, keep]
    scale = 1.0 / np.sqrt(np.repeat(body.row_mass[body.free_rows], 2))
    return 2.0 / np.sqrt(np.linalg.eigvalsh(scale[:, None] * stiffness * scale).max())


@pytest.mark.parametrize(
    "body, own_step",
    [
        (ROLLER, lambda: disc_step(disc(0.005, 5))),
        (INNER, lambda: ring_step(ring(0.0125, 0.018, 112, 6, True))),
        (OUTER, lambda: ring_step(ring(0.028, 0.0325, 176, 4, False))),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_solver_elements_have_the_solver_bodies_critical_step(body, own_step):
    found = measure(body, SOLVERS[body.name], 1.0)
    assert found.critical_step == pytest.approx(own_step(), rel=1e-6)  # Lanczos' tolerance


@every_candidate
def test_uniform_strain_leaves_inner_nodes_in_balance(body, name):
    discrete = build(body, name, 2e-3)
    gradient = np.array([[1e-4, -2e-5], [5e-5, -7e-5]])
    force = (discrete.stiffness @ (discrete.points @ gradient.T).ravel()).reshape(-1, 2)
    radius = np.hypot(*discrete.points.T)
    inside = np.all(np.abs(radius[:, None] - body.circles) > 1e-6, axis=1)
    assert inside.any()
    assert np.abs(force[inside]).max() < 1e-11 * np.abs(force).max()


@every_candidate
def test_rigid_turn_costs_nothing_and_masses_are_the_body(body, name):
    discrete = build(body, name, 2e-3)
    turn = np.column_stack([-discrete.points[:, 1], discrete.points[:, 0]]).ravel()
    scale = np.abs(discrete.stiffness).max() * np.abs(turn).max()
    assert np.abs(discrete.stiffness @ turn).max() < 1e-13 * scale
    assert discrete.mass.min() > 0.0
    assert discrete.mass.sum() == pytest.approx(STEEL.density * LENGTH * body.area, rel=1e-13)


def test_row_sums_lump_what_they_can():
    # over the area of an element; a corner is shared by six triangles or four quadrilaterals, an edge by two
    for name, corner, middle in (("P2", 0.0, 1.0 / 3.0), ("P2 + bubble", 1.0 / 20.0, 2.0 / 15.0)):
        basis = Basis(ring_triangles(0.02, 0.03, 0.03, 1e-3, 2), ELEMENTS[name](), intorder=6)
        local = row_sums(basis) / np.median(basis.dx.sum(axis=1))
        assert np.median(local[basis.nodal_dofs]) == pytest.approx(6.0 * corner, rel=0.1, abs=1e-3)
        assert np.median(local[basis.facet_dofs]) == pytest.approx(2.0 * middle, rel=0.1)
    for name, corner in (("Q2", 1.0 / 36.0), ("S2", -1.0 / 12.0)):
        basis = Basis(ring_quads(0.02, 0.03, 0.03, 1e-3, 2), ELEMENTS[name](), intorder=6)
        local = row_sums(basis) / np.median(basis.dx.sum(axis=1))
        assert np.median(local[basis.nodal_dofs]) == pytest.approx(4.0 * corner, rel=0.1)
        assert diagonal_scaled(basis).min() > 0.0
        assert diagonal_scaled(basis).sum() == pytest.approx(row_sums(basis).sum(), rel=1e-12)


def test_one_point_rectangle_bends_as_a_beam():
    """Energy of u_x = x·y over a rectangle turned by 30°: ½ E' ∫ y², Timoshenko's bending without parasitic shear."""
    a, b = 0.003, 0.001
    flat = np.array([[-a, a, a, -a], [-b, -b, b, b]])
    c, s = np.cos(0.5), np.sin(0.5)
    turn = np.array([[c, -s], [s, c]])
    basis = Basis(MeshQuad(turn @ flat, np.array([[0], [1], [2], [3]])), ElementVector(ElementQuad1()))
    u = np.zeros(8)
    u[basis.nodal_dofs] = turn @ np.array([flat[0] * flat[1], np.zeros(4)])
    energy = 0.5 * u @ one_point_stiffness(basis, STEEL) @ u
    assert energy == pytest.approx(0.5 * STEEL.plane_strain_modulus * 2.0 * a * 2.0 * b**3 / 3.0, rel=1e-12)


@pytest.mark.parametrize(
    "body, name, quantity, order",
    [
        (ROLLER, "P1", "frequencies_still", 1.7),
        (ROLLER, "P2 + bubble", "frequencies_still", 3.5),
        (ROLLER, "P1", "coupling", 1.8),
        (INNER, "Q1", "frequencies_still", 1.8),
        (INNER, "Q1, one point", "frequencies_still", 1.8),
        (INNER, "Q2", "frequencies_still", 3.5),
        (INNER, "P2 + bubble", "frequencies_still", 3.5),
        (OUTER, "Q2", "frequencies_still", 3.5),
    ],
)
def test_errors_against_exact_values_fall_at_the_order_of_the_element(body, name, quantity, order):
    coarse, fine = (measure(body, name, size) for size in (1.0, 0.5))
    ratio = getattr(coarse, quantity) / getattr(fine, quantity)
    assert np.log(ratio) / np.log(coarse.spacing_mm / fine.spacing_mm) > order


@pytest.mark.parametrize("name, order", [("P1", 1.6), ("Q1", 1.6), ("P2", 2.8), ("Q2", 2.8)])
def test_compliance_under_a_smooth_pressure_converges_to_the_series(name, order):
    coarse, fine = (measure(ROLLER, name, size) for size in (0.5, 0.25))
    found = np.log(coarse.compliance / fine.compliance) / np.log(coarse.spacing_mm / fine.spacing_mm)
    assert found > order


def point(spacing, error):
    return Point(
        body="", candidate="", size_mm=spacing, spacing_mm=spacing, freedom=1, multiply_adds=round(1e6 / spacing**2),
        critical_step=1e-7 * spacing, compliance=error, frequencies=0.0, frequencies_still=0.0, ripple=0.0,
        coupling=0.0,
    )  # fmt: skip


def test_cost_at_a_tolerance():
    points = [point(spacing, 0.01 * spacing**2) for spacing in (2.0, 1.0, 0.5)]
    cost, steps, is_bound = at_tolerance(points, "compliance", 0.02)
    assert not is_bound
    assert cost == pytest.approx(points[1].cost * 2.0**-1.5, rel=1e-5)
    assert steps == pytest.approx(points[1].steps * 2.0**-0.5, rel=1e-12)
    assert at_tolerance(points, "compliance", 0.1) == (points[0].cost, points[0].steps, True)
    assert at_tolerance(points, "compliance", 1e-3) is None
    # an error that passes through zero on the middle mesh
    lucky = [points[0], point(1.0, 1e-6), points[2]]
    assert at_tolerance(lucky, "compliance", 1e-3) is None
