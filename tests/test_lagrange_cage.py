"""A cage in the Lagrangian model: what holds kinematic angles; a free one among free elements."""

from dataclasses import replace

import numpy as np
import pytest

from fem.interface import simulate
from fem.solver.simulate import make_plan
from lagrange import contact_laws
from lagrange import simulate as reference
from lagrange.cage_motion import CageRows, free_cage
from lagrange.first_state import Problem
from lagrange.motion import State
from lagrange.scene.scene import Scene, parse_scene
from tests.accuracy.cage import caged
from tests.reference.budgets import budget_terms
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


@pytest.mark.parametrize("guidance", [{}, {"guidance": "outer_ring", "guidance_clearance_mm": 0.05}])
def test_springs_of_a_free_cage_are_the_gradient_of_their_energy(guidance):
    """And the cage's own force is against those on elements and ground: by differences of the stored energy."""
    scene = parse_scene({"cage": {"pocket_clearance_mm": 0.02, **guidance}}, "scene")
    bearing, cage, n = scene.ideal_bearing(), scene.ideal_cage(), scene.ideal_bearing().n_rollers
    theta = 2.0 * np.pi * np.arange(n) / n + np.random.default_rng(3).uniform(-1e-3, 1e-3, n)
    place = np.array([4e-5, -3e-5, 0.2e-3])

    def found(place, theta):
        state = State(
            x=np.zeros(1), y=np.zeros(1), rho=np.full((1, n), bearing.pitch_radius), theta=theta[None],
            x_rate=0.0, y_rate=0.0, rho_rate=np.zeros((1, n)), theta_rate=np.zeros((1, n)),
        )  # fmt: skip
        rows = CageRows(
            place=place[None], rate=np.zeros((1, 3)), lost=np.zeros((1, 3)), guide=np.zeros((1, 2)),
            pockets=np.zeros((1, 2, n)),
        )  # fmt: skip
        return free_cage(bearing, cage, state, rows, 0.0)

    step, samples = 1e-9, found(place, theta).samples
    assert np.count_nonzero(samples.force) > 3
    change = np.array(
        [found(place + step * e, theta).stored - found(place - step * e, theta).stored for e in np.eye(3)]
    )
    on_cage = -change[:, 0] / (2.0 * step)
    at = place[2] + 2.0 * np.pi * np.arange(n) / n
    c, s = np.cos(at), np.sin(at)
    fx = samples.radial_force[0] * c - samples.force[0] * s
    fy = samples.radial_force[0] * s + samples.force[0] * c
    np.testing.assert_allclose(on_cage[0], samples.guidance_x[0] - fx.sum(), rtol=1e-5)
    np.testing.assert_allclose(on_cage[1], samples.guidance_y[0] - fy.sum(), rtol=1e-5)
    x, y = bearing.pitch_radius * np.cos(theta) - place[0], bearing.pitch_radius * np.sin(theta) - place[1]
    np.testing.assert_allclose(on_cage[2], -(x * fy - y * fx).sum(), rtol=1e-5)


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
