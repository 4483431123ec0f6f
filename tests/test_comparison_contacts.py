"""Contacts as other programs have them on a coarse mesh: penalty springs between circles, or between facets."""

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.contacts.model import standing
from fem.contacts.resolved import FacetedModel, PenaltyModel
from fem.kernels.patches import CORNER, chord
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.scene.run import STIFF_PENALTY
from lagrange.scene.scene import Scene, parse_scene, parse_scene_text
from tests.reference.bearings import LOAD, ON_A_ROLLER, arrays, copies, operation, paper
from tests.reference.compiled import press_contacts
from tests.reference.whole_run import whole_run

MESH_MM = 2.0


def model(stiffness, faceted, mesh_mm=MESH_MM):
    return (FacetedModel if faceted else PenaltyModel).of_stiffness(paper(), 1e-3 * mesh_mm, stiffness)


def hub(a_model):
    return equilibrium(a_model, standing(a_model.bearing, ON_A_ROLLER), Loads(LOAD)).hub


# geometry -------------------------------------------------------------------------------------------------------


def test_a_facet_is_deepest_in_its_middle_and_smooth_at_its_ends():
    beyond = (np.arange(20_000) + 0.5) / 20_000
    depth, slope = np.array([chord(t) for t in beyond]).T
    assert depth.max() == pytest.approx(chord(0.5)[0]) and depth.max() == pytest.approx(1.0, abs=2.0 * CORNER**2)
    assert depth.mean() == pytest.approx(2.0 / 3.0, abs=1e-8), "rounding the corners moves no mean"
    change = np.diff(np.append(depth, depth[0])) * beyond.size
    np.testing.assert_allclose(change, 0.5 * (slope + np.append(slope[1:], slope[0])), atol=2e-3)
    assert np.abs(np.diff(np.append(slope, slope[0]))).max() < 0.02, "no jump, at the node neither"


def test_sagittas_are_those_of_the_meshes_own_chords():
    """h²/8R, to its own relative error h²/R²/48; in a bore the chord lies on the other side of the circle."""
    found = model(STIFF_PENALTY, faceted=True)
    disc, inner, outer = found.roller, found.inner_ring, found.outer_ring

    def below_the_circle(points):
        middle = 0.5 * (points + np.roll(points, -1, axis=0))
        return np.hypot(*points.T).mean() - np.hypot(*middle.T)

    surface = disc.points[disc.first_surface_node :]
    inside = inner.points.reshape(inner.n_rows, -1, 2)[-1]
    bore = outer.points.reshape(outer.n_rows, -1, 2)[0]
    for law, side, points, sign in (
        (found.inner_law, 0, inside, 1.0), (found.outer_law, 0, bore, -1.0),
        (found.inner_law, 1, surface, 1.0), (found.outer_law, 1, surface, 1.0), (found.roller_law, 0, surface, 1.0),
    ):  # fmt: skip
        np.testing.assert_allclose(below_the_circle(points), sign * law.sagitta[side], rtol=6e-3)
    assert model(STIFF_PENALTY, faceted=False).inner_law.sagitta == (0.0, 0.0)


# the spring -----------------------------------------------------------------------------------------------------


def test_the_hub_sinks_by_the_springs_compliance():
    """Two springs in series under each loaded roller, δ = y cos ψ: y = 2 W / (k Σ cos² ψ) over the lower half.

    A tenth of a millimetre turns the normals by half a per cent.
    """
    angle = 2.0 * np.pi * np.arange(13) / 13
    share = np.sum(np.maximum(np.cos(angle), 0.0) ** 2)
    soft, softer = hub(model(2e7, faceted=False)), hub(model(1e7, faceted=False))
    assert soft[1] - softer[1] == pytest.approx(2.0 * LOAD / share * (1e-7 - 0.5e-7), rel=8e-3)


def test_the_step_limit_knows_the_spring():
    limits = [critical_time_step(model(k, faceted=False), 650.0) for k in (1e7, 1e11, 1e12)]
    assert limits[0] > 10.0 * limits[2]
    assert limits[1] / limits[2] == pytest.approx(np.sqrt(10.0), rel=0.02)


@pytest.mark.slow  # a time loop of its own to compile
@pytest.mark.parametrize("faceted", [False, True])
def test_the_start_carries_the_load_on_the_same_springs(faceted):
    how = operation(speed=0.0, gravity=0.0)
    found = model(STIFF_PENALTY, faceted)
    wanted = equilibrium(found, standing(found.bearing, how.first_roller_angle), Loads(how.radial_load))
    state = copies(arrays(found, how, 1e-8))
    press_contacts(state)
    np.testing.assert_allclose(state.contacts.forces.force[0, :13], wanted.inner_force, rtol=0.0, atol=1e-6 * LOAD)
    np.testing.assert_allclose(state.contacts.forces.force[1, :13], wanted.outer_force, rtol=0.0, atol=1e-6 * LOAD)
    if faceted:  # 2 mm facets leave gaps far wider than contacts yield
        assert np.count_nonzero(wanted.inner_force) <= 4 and wanted.hub[1] < -50e-6


# motion ---------------------------------------------------------------------------------------------------------


def moved(name, stiffness, friction):
    scene = parse_scene(
        {
            "contact": {"model": name, "penalty_stiffness_N_per_m": stiffness, "friction_coefficient": friction},
            "numerics": {"mesh_size_mm": MESH_MM, "duration_ms": 2.0, "time_step_safety": 0.45},
        },
        "test",
    )
    found = whole_run(make_plan(scene))
    return found, np.abs(found.imbalance).max() / found.exchanged[-1]


@pytest.mark.slow  # two time loops of their own to compile
@pytest.mark.parametrize(("name", "limit"), [("penalty", 1e-3), ("faceted", 3e-3)])
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_runs_balance_their_energy(name, limit, friction):
    """Facets throw rollers about at several m/s, and friction takes twenty times what the contacts store."""
    values, imbalance = moved(name, STIFF_PENALTY, friction)
    assert imbalance < limit
    force = np.hstack([values[f"{kind}_force"] for kind in ("inner", "outer", "roller_roller")])
    stored = np.sum(force**2, axis=1) / (2.0 * STIFF_PENALTY)
    np.testing.assert_allclose(values["energy_contact"], stored, rtol=1e-9, atol=1e-12)
    spread = np.ptp(values["inner_y"])
    assert (spread > 50e-6) if name == "faceted" else (spread < 5e-6)


# scenes ---------------------------------------------------------------------------------------------------------


def test_only_comparison_models_have_a_spring():
    assert Scene().contact.model == "subgrid" and "penalty" not in Scene().to_toml()
    stiff = parse_scene({"contact": {"model": "faceted"}}, "s")
    assert stiff.contact.penalty_stiffness_N_per_m == STIFF_PENALTY
    assert parse_scene_text(stiff.to_toml(), "again") == stiff


def test_no_error_is_estimated_for_a_comparison_model(capsys):
    assert run_main(["--set", "contact.model=penalty", "--estimate-error", "--dry-run", "--mesh-size", "2"]) in (0, 2)
    assert run_main(["--set", "contact.model=penalty", "--estimate-error", "--mesh-size", "1"]) == 2
    assert "comparison only" in capsys.readouterr().err
