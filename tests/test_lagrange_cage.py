"""A cage in the Lagrangian model: what holds kinematic angles; a free one among free elements."""

from dataclasses import replace

import numpy as np
import pytest

from fem.interface import simulate
from fem.solver.simulate import make_plan
from lagrange import contact_laws
from lagrange.first_state import Problem, sampled
from lagrange.motion import State
from lagrange.scene.scene import Scene, parse_scene
from tests.accuracy.cage import caged
from tests.reference.budgets import budget_terms
from tests.reference.forward_motion import simulate as reference
from tests.reference.going_on import assert_same_bits, rest_of_run

FREE = {"angles": "free"}
GUIDED = {"guidance": "inner_ring", "guidance_clearance_mm": 0.05, "pocket_clearance_mm": 0.1}


def test_the_kinematic_cage_gives_what_the_angles_need():
    """Rollers that touch the outer raceway alone: along the pitch circle weight and Coriolis' force, and no other."""
    scene = parse_scene({"cage": {}, "bearing": {"outer_raceway_diameter_mm": 56.2}}, "scene")
    bearing = scene.ideal_bearing()
    operation = replace(scene.ideal_operation(), radial_load=0.0, gravity=9.81, speed=1000.0)
    problem = Problem(
        bearing=bearing, operation=operation, laws=contact_laws("harris", bearing), cage=scene.ideal_cage(),
        start="rest",
    )  # fmt: skip
    run = reference(problem, 39e-5, 1e-5)
    far = run.inner_force == 0.0
    expected = bearing.roller_mass * (
        9.81 * np.cos(run.roller_theta) + 2.0 * run.roller_rho_rate * run.roller_theta_rate
    )
    assert far.mean() > 0.5
    assert np.ptp(expected) > 0.1
    np.testing.assert_allclose(run.cage.force[far], expected[far], atol=1e-12)
    np.testing.assert_allclose(run.cage.angle, run.cage.speed * run.time, atol=1e-12)


def test_without_the_table_nothing_is_told_of_a_cage():
    scene = Scene()
    bearing = scene.ideal_bearing()
    problem = Problem(bearing=bearing, operation=scene.ideal_operation(), laws=contact_laws("harris", bearing))
    assert reference(problem, 1e-5, 1e-5).cage is None


def test_a_free_cage_holds_rollers_that_begin_beyond_its_play():
    """Springs at the start by hand: a round pocket that a sunk roller has left, and a hub beyond its bore's play."""
    scene = parse_scene({"cage": {"guidance": "rollers", "pocket_clearance_mm": 0.002}, "lagrange": FREE}, "scene")
    bearing, cage, laws = scene.ideal_bearing(), scene.ideal_cage(), contact_laws("harris", scene.ideal_bearing())

    def start(cage):
        problem = Problem(bearing, scene.ideal_operation(), laws, cage=cage, angles="free")
        state = problem.first_state.state
        one = {name: np.asarray(value)[None] for name, value in vars(state).items() if name not in ("turns", "tilts")}
        return state, *(sampled(each, np.zeros(1), State(**one)) for each in (problem, replace(problem, cage=None)))

    state, found, bare = start(cage)
    off = state.rho - bearing.pitch_radius
    depth = np.maximum(np.abs(off) - 1e-6, 0.0)
    assert depth.max() > 5e-7
    np.testing.assert_allclose(found["cage_radial_force"][0], -np.sign(off) * cage.stiffness * depth)
    stored = 0.5 * cage.stiffness * np.sum(depth**2)
    assert found["energy_contact"] - bare["energy_contact"] == pytest.approx(stored, rel=1e-6)
    state, found, bare = start(replace(cage, guidance="inner_ring", guidance_clearance=4e-6))
    push = cage.stiffness * (np.hypot(state.x, state.y) - 2e-6)
    assert np.hypot(found["cage_guidance_x"], found["cage_guidance_y"]) == pytest.approx(push)
    upwards = found["inner_ay"] - bare["inner_ay"]
    assert upwards == pytest.approx(-found["cage_guidance_y"] / scene.ideal_operation().inner_mass, rel=1e-6)


@pytest.mark.slow  # these compile loops of the Lagrangian model that no other test has
@pytest.mark.parametrize("cage", [{"pocket_clearance_mm": 0.1}, GUIDED | {"drag_torque_N_m": 0.05}])
def test_energy_balances_with_a_free_cage(cage):
    found = caged("lagrange", 30.0, cage, lagrange=FREE)
    assert found.trouble is None
    assert found.imbalance < 1e-4
    assert 0.0 < sum(found.values[f"cage_work_{name}"][-1] for name in ("dashpots", "friction", "drag"))


@pytest.mark.slow
def test_drag_brakes_cage_and_elements_as_one_body_in_both_rigid_models():
    """Nothing drives them without friction on the raceways: T = (I + n m R²) α; a steep law and the reduced model's."""
    cage = {"pocket_clearance_mm": 0.02, "friction_coefficient": 0.0, "drag_torque_N_m": 0.05, "damping_N_s_m": 100.0}
    scene = {"contact": {"friction_coefficient": 0.0}, "operation": {"gravity_m_s2": 0.0}}
    for model, more in (("lagrange", {"lagrange": FREE | {"law": "johnson"}}), ("reduced", {})):
        found = caged(model, 20.0, cage, **scene, **more)
        bearing, facts = found.scene.ideal_bearing(), found.scene.ideal_cage()
        together = facts.inertia + bearing.n_rollers * bearing.roller_mass * bearing.pitch_radius**2
        slowing = -np.polyfit(found.values["time"], found.values["cage_speed"], 1)[0]
        assert slowing == pytest.approx(0.05 / together, rel=0.01), model


@pytest.mark.slow
def test_elements_keep_their_distance_within_the_clearance():
    found = caged("lagrange", 60.0, {"pocket_clearance_mm": 0.1}, lagrange=FREE)
    deepest = np.hypot(found.values["cage_force"], found.values["cage_radial_force"]).max() / 1e8
    assert 2e-5 < found.spacing < 1e-4 + 2.0 * deepest


IN_HOUSING = {"support": {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}}


@pytest.mark.slow
@pytest.mark.parametrize("guidance", ["rollers", "inner_ring", "outer_ring"])
def test_the_checker_knows_a_free_cage_in_a_housing(guidance):
    """Its terms add up, the hub's momentum and the housing's balance, and so does the energy."""
    guide = {"guidance": guidance} | ({} if guidance == "rollers" else {"guidance_clearance_mm": 0.02})
    tables = {
        "model": "lagrange", "lagrange": FREE, "cage": {"pocket_clearance_mm": 0.1} | guide,
        "numerics": {"duration_ms": 5.0, "start": "rest", "load_ramp_ms": 0.2},
    }  # fmt: skip
    result = simulate(parse_scene(tables | IN_HOUSING, ""))
    for terms in budget_terms(result.residual()):
        assert np.abs(terms["ring_flexibility"]).max() < 1e-9 * 2000.0
        assert ("cage" in terms) == (guidance == "inner_ring") or np.all(terms["cage"] == 0.0)
    bearing, theta = result.scene.ideal_bearing(), result["roller_theta"]
    pushed = np.sum(result["outer_force"] * np.sin(theta), axis=1)
    pushed -= result["cage_guidance_y"] if guidance == "outer_ring" else 0.0
    mass, place = 0.5 + bearing.outer_ring_mass, result["housing_y"]
    left = pushed - mass * (result["housing_ay"] + 9.81) - 2e8 * place
    damped = 4000.0 * np.gradient(place, result["time"])
    assert np.std(left - damped) < 0.02 * np.std(mass * result["housing_ay"])
    assert guidance == "rollers" or np.abs(result["cage_guidance_y"]).max() > 10.0
    assert abs(result.energies["work_dissipated"][-1]) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("more", [{}, IN_HOUSING])
def test_a_free_cage_goes_on_bit_for_bit(more):
    tables = {
        "model": "lagrange",
        "lagrange": FREE,
        "cage": GUIDED | {"drag_torque_N_m": 0.5},
        "numerics": {"duration_ms": 2.0},
    } | more
    plan = make_plan(parse_scene(tables, "scene"))
    expected, found = rest_of_run(plan, 100, 101)
    assert np.abs(expected.values["cage_force"]).max() > 1.0
    assert_same_bits(found, expected)
