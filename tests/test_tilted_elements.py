"""Rollers that tilt on meshes: tables below the grid, equilibrium and motion against the reduced model, energy."""

import h5py
import numpy as np
import pytest

from fem.contacts.tilted import MeshedContact, tilted_slices, tilted_tables
from fem.errors import UsageError
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from fem.statics.reduced_bearing import kept_contacts
from lagrange.scene.scene import SceneError
from residual.evaluation import evaluate
from residual.sources import read_result
from tests.reference.going_on import assert_same_bits, rest_of_run
from tests.reference.tilted_runs import defects, missed, moved, scene

MISALIGNED = {"operation__misalignment_mrad": 1.0, "numerics__mesh_size_mm": 2.0}
PROFILED = {"roller_profile": "logarithmic", "coupling": False}
MESHED = 6e-10  # m/N, about that of the paper's bearing
HALF = {"width_mm": 1.0, "length_mm": 5.0, "z_mm": 2.5}
SURFACES = defects(HALF)


def test_a_table_below_the_grid_is_the_plane_law_less_the_meshes_compliance():
    found = scene("fem", {"roller_profile": "none", "coupling": False})
    bearing, axial = found.perfect_bearing(), found.ideal_axial()
    contacts, _ = kept_contacts(bearing)
    laws = contacts.inner_law, contacts.outer_law
    inner, outer = tilted_tables(bearing, axial, laws, 700.0, 1e-3, (MESHED, MESHED))
    force = np.array([100.0, 300.0, 700.0, 1500.0])
    for law, table in zip(laws, (inner, outer), strict=True):
        straight = table.at(law.approach(force) - MESHED * force, 0.0)
        assert straight.force == pytest.approx(force, rel=2e-4)
        assert straight.moment == pytest.approx(0.0, abs=1e-6)
    whole, step = MeshedContact(table=inner, meshed=MESHED), 1e-9
    approach, slope = laws[0].approach(force), 4e-4
    near = whole.at(approach, slope)
    further, steeper = whole.at(approach + step, slope), whole.at(approach, slope + step)
    assert near.force == pytest.approx((further.energy - near.energy) / step - 0.5 * step * near.stiffness, rel=1e-6)
    assert near.moment == pytest.approx((near.energy - steeper.energy) / step, rel=1e-4)
    assert near.stiffness == pytest.approx((further.force - near.force) / step, rel=5e-3)
    assert near.cross == pytest.approx((steeper.force - near.force) / step, rel=1e-3)
    assert near.tilt_stiffness == pytest.approx((near.moment - steeper.moment) / step, rel=1e-3)


def test_a_table_of_a_spalled_contact_below_the_grid_is_that_of_the_slices_that_are_left():
    found = scene("fem", {"slices": 10, "coupling": False}, spall=[HALF])
    bearing, axial = found.ideal_bearing(), found.ideal_axial()
    contacts, _ = kept_contacts(bearing)
    laws = contacts.inner_law, contacts.outer_law
    contact = MeshedContact(table=tilted_tables(bearing, axial, laws, 700.0, 1e-3, (MESHED, MESHED))[1], meshed=MESHED)
    slices, slope, step = tilted_slices(bearing, axial, laws)[1], np.array([0.0, 2e-4, -2e-4, 4e-4]), 1e-9
    approach = laws[1].approach(np.array([300.0, 700.0, 700.0, 1500.0]))
    for sunk in (np.zeros(4), np.full(4, 1e-3)):
        over, wanted = contact.at(approach, slope, sunk), slices.at(approach, slope, sunk)
        assert over.force == pytest.approx(wanted.force, rel=5e-4, abs=2e-4 * wanted.force.max())
        assert over.moment == pytest.approx(wanted.moment, abs=5e-4 * bearing.roller_length * wanted.force.max())
    sunk = np.full(4, 3e-7)
    over, deeper = contact.at(approach, slope, sunk), contact.at(approach, slope, sunk + step)
    assert over.part == pytest.approx((over.energy - deeper.energy) / step, rel=2e-3)
    assert np.all(over.part > 10.0)


@pytest.mark.parametrize(
    ("changes", "remedy"),
    [
        ({"contact.model": "penalty"}, 'only with contact.model = "subgrid"'),
        ({"bodies.rollers": "rigid"}, "whose slices are those of elastic bodies"),
        ({"damping.contact_N_s_m": 10.0}, "leave one of them out"),
    ],
)
def test_parts_that_meshes_lack_with_tilt_are_refused_by_name(changes, remedy):
    with pytest.raises(SceneError, match=remedy):
        scene("fem").varied(changes)


def test_a_misaligned_run_on_meshes_stands_as_the_reduced_model_and_balances(tmp_path):
    found, path = scene("fem", PROFILED, **MISALIGNED, numerics__duration_ms=0.4), tmp_path / "tilted.nc"
    start, other = make_plan(found).start, make_plan(scene("reduced", PROFILED, **MISALIGNED)).start
    assert start.equilibrium.hub[1] == pytest.approx(other.hub[1], rel=1.5e-3)  # 1e-3 of it without tilt, too
    axes, most = start.equilibrium.axes, other.inner_moment.max()
    assert axes.inner_moment == pytest.approx(other.inner_moment, abs=5e-3 * most)
    loaded = other.inner_force > 50.0
    assert axes.tilt[loaded] == pytest.approx(other.tilts.tilt[loaded], rel=1e-2)
    run_scene(found, path, RunOptions(quiet=True))
    with h5py.File(path) as file:
        assert file["inner_moment"][0] == pytest.approx(axes.inner_moment, abs=1e-4 * most)
        assert missed({name: file[name][:] for name in file}) < 1e-6
    checked = evaluate(read_result(path))
    assert checked.tilt.error == pytest.approx(checked.tilt.contact_law + checked.tilt.balance, abs=1e-12)
    assert checked.tilt.balance.std() < 1e-2 * most


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [{}, {"support__kind": "points"}, {"support__kind": "bore", "support__fit_clearance_um": 10.0}],
    ids=["held", "points", "bore"],
)
def test_straight_rollers_without_slope_move_as_those_of_the_plane_mesh(keys):
    straight = {"roller_profile": "none", "coupling": False}
    coarse = {"numerics__mesh_size_mm": 2.0} | keys
    solid, plane = moved(scene("fem", straight, **coarse)), moved(scene("fem", None, **coarse))
    assert missed(solid) < 1e-6
    assert solid["inner_y"] == pytest.approx(plane["inner_y"], rel=2e-4)
    heavy = plane["inner_force"] > 300.0
    assert solid["inner_force"][heavy] == pytest.approx(plane["inner_force"][heavy], rel=2e-4)


@pytest.mark.slow
def test_motion_on_meshes_is_that_of_the_reduced_model():
    profiled = {"roller_profile": "logarithmic", "slices": 21}
    changes = {"operation__misalignment_mrad": 1.0, "numerics__duration_ms": 20.0}
    mesh, series = moved(scene("fem", profiled, **changes)), moved(scene("reduced", profiled, **changes))
    assert mesh["inner_y"].mean() == pytest.approx(series["inner_y"].mean(), rel=5e-4)
    assert mesh["inner_y"].std() == pytest.approx(series["inner_y"].std(), rel=1e-2)
    for name in ("inner_moment", "outer_moment"):
        for moment in (np.mean, np.std, np.max):
            assert moment(mesh[name]) == pytest.approx(moment(series[name]), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [
        {"bearing__missing_rollers": [2]},
        {"operation__outer_ring_speed_rpm": -3000.0, "lubricant__viscosity_Pa_s": 0.02},
    ],
)
def test_missing_rollers_films_and_a_turning_outer_ring_move_on_meshes_as_in_the_reduced_model(keys):
    changes = MISALIGNED | keys | {"numerics__duration_ms": 5.0}
    found, series = scene("fem", PROFILED, **changes), moved(scene("reduced", PROFILED, **changes))
    assert make_plan(found).start.warning is None
    mesh = moved(found)
    assert missed(mesh) < 1e-6
    assert mesh["inner_y"].mean() == pytest.approx(series["inner_y"].mean(), rel=1.5e-3)
    for side in ("inner", "outer"):
        force, moment = series[f"{side}_force"], series[f"{side}_moment"]
        assert mesh[f"{side}_force"] == pytest.approx(force, abs=3e-3 * force.max())
        assert mesh[f"{side}_moment"] == pytest.approx(moment, abs=1.5e-2 * moment.max())


@pytest.mark.slow
def test_a_spall_of_half_the_length_moves_rollers_on_meshes_as_in_the_reduced_model():
    profiled = {"roller_profile": "logarithmic", "slices": 20}
    changes = MISALIGNED | {"spall": [HALF], "numerics__duration_ms": 12.0}
    plans = [make_plan(scene(model, profiled, **changes)) for model in ("fem", "reduced")]
    start, other = plans[0].start.equilibrium, plans[1].start  # a roller stands over the spall
    assert start.inner_force == pytest.approx(other.inner_force, abs=5e-4 * other.inner_force.max())
    assert start.axes.outer_moment == pytest.approx(other.outer_moment, abs=2e-3 * other.outer_moment.max())
    mesh, series = (moved(scene(model, profiled, **changes)) for model in ("fem", "reduced"))
    assert missed(mesh) < 3e-5  # that of the reduced model is 1e-5
    # a dozen strikes, in which meshes have waves that the reduced model lacks: 1.7 % of the hub's deviation in 20 ms
    for name, error in {"inner_y": 5e-3, "outer_force": 5e-3, "inner_moment": 2e-2, "outer_moment": 2e-2}.items():
        assert mesh[name].mean() == pytest.approx(series[name].mean(), rel=error), name
        assert mesh[name].std() == pytest.approx(series[name].std(), rel=2e-2), name


HOUSING = {
    "support__kind": "housing", "support__mass_kg": 12.0, "support__stiffness_N_per_m": 1.5e7,
    "support__damping_N_s_m": 2200.0,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"bearing__outer_raceway_diameter_mm": 56.02, "contact__friction_coefficient": 0.0},  # rollers rattle
        {"axial__hub_tilt_inertia_kg_m2": 1e-3, "axial__shaft_tilt_stiffness_N_m_rad": 1e4},
        {"numerics__start": "rest"},
        {"cage__mass_kg": 0.02},
        {"operation__shaft": "springs", "operation__shaft_stiffness_N_per_m": 1e7},
        {"operation__unbalance_g_mm": 50.0},
    ],
)
def test_energy_balances_on_meshes(changes):
    samples = moved(scene("fem", {"roller_profile": "logarithmic"}, **MISALIGNED | changes, numerics__duration_ms=5.0))
    assert missed(samples) < 5e-6


@pytest.mark.slow
def test_energy_balances_on_meshes_over_spalls_of_half_the_length_with_damped_bodies():
    changes = MISALIGNED | SURFACES | {"damping__bodies_1_s": 500.0, "numerics__duration_ms": 5.0}
    assert missed(moved(scene("fem", {"slices": 20}, **changes))) < 1e-5  # that of the plane section with spalls


@pytest.mark.slow
def test_a_run_that_goes_on_has_the_bits_of_one_that_was_not_stopped():
    plan = make_plan(scene("fem", PROFILED, **MISALIGNED))
    assert_same_bits(*reversed(rest_of_run(plan, 20, 31)))


@pytest.mark.slow
def test_meshes_that_resolve_contacts_are_refused():
    with pytest.raises(UsageError, match="use a larger numerics"):
        make_plan(scene("fem", numerics__mesh_size_mm=0.1))
