"""Contact models: each of a scene's names has one, all answer the same questions, none solves statics twice."""

from typing import get_args

import numpy as np
import pytest

from fem.contacts import MODELS
from fem.contacts.model import Model
from fem.contacts.resolved import FacetedModel, PenaltyModel, ResolvedModel, SpreadModel
from fem.contacts.subgrid import SubgridModel
from fem.kernels.state import INNER, OUTER, ROLLER
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan
from fem.statics import exact_statics as expected_forces
from lagrange.scene.run import ContactTable
from lagrange.scene.scene import parse_scene
from tests.reference.bearings import paper, soft

LOAD = 650.0
BUILT = {
    "subgrid": lambda: SubgridModel.build(paper(), 2e-3),
    "spread": lambda: SpreadModel.of_force(soft(), 6e-4, LOAD),
    "resolved": lambda: ResolvedModel.build(soft(), 3e-4),
    "penalty": lambda: PenaltyModel.of_stiffness(paper(), 2e-3, 1e8),
    "faceted": lambda: FacetedModel.of_stiffness(paper(), 2e-3, 1e8),
}
every_model = pytest.mark.parametrize("name", BUILT)


def built(name) -> Model:
    return BUILT[name]()


def scene(contact="subgrid", mesh_size=2.0, modulus=210.0):
    tables = {
        "contact": {"model": contact},
        "numerics": {"mesh_size_mm": mesh_size, "duration_ms": 0.0},
        "material": {"youngs_modulus_GPa": modulus},
    }
    return parse_scene(tables, "test")


def test_every_name_of_the_scene_has_a_model():
    assert set(MODELS) == set(get_args(ContactTable.model_fields["model"].annotation))


@pytest.mark.parametrize(
    ("contact", "mesh_size", "modulus", "kind"),
    [
        ("subgrid", 2.0, 210.0, SubgridModel),
        ("subgrid", 0.6, 5.0, SpreadModel),
        ("penalty", 2.0, 210.0, PenaltyModel),
        ("faceted", 2.0, 210.0, FacetedModel),
    ],
)
def test_a_scene_gets_its_model(contact, mesh_size, modulus, kind):
    assert type(model_of(scene(contact, mesh_size, modulus))) is kind


@every_model
def test_the_kernels_get_what_they_know_and_no_more(name):
    """A law below the grid with its ripples, or points; of every pair its half-width."""
    model = built(name)
    given = model.kernel_data(LOAD)
    assert (given.points is None) == (name == "subgrid") == all(law.A > 0.0 for law in given.laws)
    assert all((ripple.size > 0) == (name == "subgrid") for ripple in given.ripples)
    for law, known in zip(model.laws, given.laws, strict=True):
        assert known.half_width_factor == law.pair.half_width_factor
        assert known.curvature * law.pair.relative_radius == pytest.approx(1.0, rel=1e-15)


@every_model
@pytest.mark.parametrize("kind", [INNER, OUTER, ROLLER])
def test_nodes_carry_a_whole_contact_around_its_middle(name, kind):
    """Shares sum to 1 and their first moment is that of the contact: neither force nor moment is lost."""
    nodes, share, offset = built(name).carried(kind, 60, 1.234, 5e-3, LOAD)
    assert share.sum() == pytest.approx(1.0, rel=1e-12)
    assert share @ offset == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.mod(nodes * (2.0 * np.pi / 60.0) + offset, 2.0 * np.pi), 1.234, rtol=1e-12)


@every_model
def test_springs_push_each_body_at_every_contact(name):
    """Forces of a column balance those of the contact: outward on the roller, radial on a ring."""
    model = built(name)
    springs = model.springs(10.0 * LOAD)
    assert springs["roller"].shape[0] == 2 * model.roller.n_nodes
    for ring in ("inner_ring", "outer_ring"):
        body = getattr(model, ring)
        on = springs[ring].toarray().reshape(body.n_rows, 2, body.n_sectors, -1)
        assert np.abs(np.delete(on, body.raceway_row, axis=0)).max() == 0.0
        assert np.abs(on[body.raceway_row, 0]).max() > 0.0


def test_only_soft_springs_may_give_way():
    for name in BUILT:
        assert (built(name).give(2000.0) > 0.0) == (name in ("penalty", "faceted"))
    assert built("penalty").give(2000.0) == pytest.approx(2.0 * 2000.0 / 1e8, rel=1e-12)


@pytest.mark.parametrize(
    ("contact", "mesh_size", "modulus", "most"), [("subgrid", 2.0, 210.0, 0), ("subgrid", 0.6, 5.0, 1)]
)
def test_exact_statics_of_a_scene_are_solved_once_at_most(contact, mesh_size, modulus, most, monkeypatch):
    calls = []
    solve = expected_forces.exact_statics
    monkeypatch.setattr(expected_forces, "exact_statics", lambda *args: calls.append(args) or solve(*args))
    make_plan(scene(contact, mesh_size, modulus))
    assert len(calls) == most
