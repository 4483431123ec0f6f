"""Starts in clearance under light loads: hubs that one roller carries, nothing holds, or loads lead around."""

from dataclasses import replace

import numpy as np
import pytest

from fem.interface import simulate
from fem.solver.rigid.lagrangian import make_plan
from fem.solver.rigid.reduced import make_plan as reduced_plan
from fem.solver.start import equilibrium_start
from fem.statics.contact_balance import hub_stiffness
from lagrange.first_state import Problem, followed
from lagrange.kinematics import kinematics
from lagrange.scene.scene import parse_scene
from lagrange.statics import static_equilibrium
from lagrange.surface.deviation import UNTURNED
from tests.reference.forward_motion import simulate as integrated

CLOSE = 0.01  # of the largest force, between the same starts


def problem_of(tables) -> Problem:
    return make_plan(parse_scene({"model": "lagrange", **tables}, "scene")).problem


def light(bearing, load, more=None, **operation):
    """A scene's tables: a standard bearing, or a table, under a load, N."""
    table = bearing if isinstance(bearing, dict) else {"designation": bearing}
    return {"bearing": table, "operation": {"radial_load_N": load, **operation}} | (more or {})


WIDE, WEIGHTLESS = {"clearance_um": 40.0}, {"gravity_m_s2": 0.0}
LIGHT = {
    "NU206": light("NU206", 200.0), "NU205": light("NU205", 150.0),
    "NU212": light("NU212", 300.0, inner_ring_and_shaft_kg=3.0), "clearance": light(WIDE, 100.0),
    "soft shaft": light(WIDE, 100.0, shaft="springs", shaft_stiffness_N_per_m=2e4),
    "balls": light({"type": "ball", "clearance_um": 20.0}, 20.0),
    "few balls": light({"type": "ball", "rollers": 7, "clearance_um": 30.0}, 5.0),
    "free angles": light("NU206", 200.0, {"lagrange": {"angles": "free"}}),
    "housing": light("NU206", 200.0, {"support": {"kind": "housing"}}),
    "three rollers": light({"rollers": 3, "clearance_um": 10.0}, 500.0),
    "vertical shaft": light("NU206", 0.0, unbalance_g_mm=200.0, unbalance_deg=30.0, **WEIGHTLESS),
    "no load": light("NU206", 0.0, **WEIGHTLESS),
    "turning load": light("NU206", 0.0, rotating_load_N=100.0, **WEIGHTLESS),
}  # fmt: skip


@pytest.mark.parametrize("name", LIGHT)
def test_a_light_start_does_not_shock_the_bearing(name):
    """Beside `solve_ivp`, from the same start, and from its place with a hub that stands: largest contact forces."""
    numerics = {"numerics": {"duration_ms": 0.4, "output_interval_us": 2.0}}
    problem, still = problem_of(LIGHT[name]), problem_of(LIGHT[name])
    start = problem.first_state
    standing = replace(start.state, x_rate=0.0, y_rate=0.0, rho_rate=np.zeros(problem.bearing.n_rollers))
    vars(still)["first_state"] = start._replace(state=standing)
    run = simulate(parse_scene({"model": "lagrange", **LIGHT[name], **numerics}, "scene"))
    own = max(run["inner_force"].max(), run["outer_force"].max())
    found = (integrated(of, 4e-4, 2e-6) for of in (problem, still))
    same, quiet = (max(run.inner_force.max(), run.outer_force.max()) for run in found)
    assert own == pytest.approx(same, rel=CLOSE) and own < (1.0 + CLOSE) * quiet


def test_a_hub_balanced_on_one_roller_starts_without_velocity_and_the_run_says_so():
    """Bounds: by another integration 5.23 × 0.92 µm and 246 N; a jump taken for a velocity made 70 µm and 6381 N."""
    scene = LIGHT["NU206"] | {"model": "lagrange", "numerics": {"duration_ms": 20.0}}
    run = simulate(parse_scene(scene, "scene"))
    assert abs(run["inner_vx"][0]) < 1e-6 and np.ptp(run["inner_x"]) == pytest.approx(5.23e-6, rel=0.02)
    assert np.ptp(run["inner_y"]) == pytest.approx(0.92e-6, rel=0.02)
    assert max(run["inner_force"].max(), run["outer_force"].max()) == pytest.approx(246.0, rel=0.02)
    assert any("starts at rest" in sentence for sentence in run.warnings)


def test_a_loaded_start_keeps_the_velocity_of_its_equilibrium_and_says_nothing():
    problem = problem_of({"operation": {"radial_load_N": 2000.0, "first_roller_deg": 5.0}})
    (state, warning), shift = problem.first_state, 1e-5
    angles, given = state.theta, (problem.bearing, problem.operation, problem.laws)
    ahead, behind = (static_equilibrium(*given, angles=angles + way * state.theta_rate) for way in (shift, -shift))
    assert warning is None and state.x_rate == pytest.approx((ahead.x - behind.x) / (2.0 * shift), rel=1e-3)
    assert state.y_rate == pytest.approx((ahead.y - behind.y) / (2.0 * shift), rel=1e-3)


@pytest.mark.parametrize("load", [300.0, 2000.0])
def test_stiffness_at_a_start_is_what_loads_find(load):
    """Of statics of rigid rings and of elastic bodies, by equilibria under other loads."""
    tables, more = light({}, load, first_roller_deg=10.0, **WEIGHTLESS), 1e-4 * load

    def softness(place, operation):
        def under(across, down):
            return np.array(place(replace(operation, side_load=across, radial_load=load + down)))

        pulls = ((more, 0.0), (0.0, -more))
        return np.column_stack([under(x, y) - under(-x, -y) for x, y in pulls]) / (2.0 * more)

    problem = problem_of(tables)

    def rigid(operation):
        found = static_equilibrium(problem.bearing, operation, problem.laws)
        return found.x, found.y

    stiffness = static_equilibrium(problem.bearing, problem.operation, problem.laws).stiffness
    np.testing.assert_allclose(stiffness @ softness(rigid, problem.operation), np.eye(2), atol=2e-3)

    plan = reduced_plan(parse_scene({"model": "reduced", **tables}, "scene"))
    start = equilibrium_start(plan.model, plan.operation)
    place, forces = np.concatenate([start.hub, start.rho]), np.concatenate([start.inner_force, start.outer_force])
    stiffness = hub_stiffness(plan.model.at(start.angle, UNTURNED), place, forces, None)
    elastic = softness(lambda operation: equilibrium_start(plan.model, operation).hub, plan.operation)
    np.testing.assert_allclose(stiffness @ elastic, np.eye(2), atol=2e-3)


def test_a_hub_follows_only_what_holds_it():
    problem = problem_of({})
    bearing, operation = problem.bearing, problem.operation
    limit = operation.inner_mass * (bearing.n_rollers * kinematics(bearing, operation.speed).cage) ** 2
    assert followed(np.diag([1.01 * limit, 2.0 * limit]), bearing, operation)[0].size == 2
    values, directions = followed(np.diag([0.99 * limit, 2.0 * limit]), bearing, operation)
    assert values == pytest.approx([2.0 * limit])
    np.testing.assert_allclose(np.abs(directions), [[0.0], [1.0]])
    assert followed(np.diag([-1.0, 0.0]), bearing, replace(operation, speed=0.0))[0].size == 0


def test_the_reduced_model_starts_still_where_its_hub_cannot_follow():
    plan = reduced_plan(parse_scene({"model": "reduced", **LIGHT["NU212"]}, "scene"))
    assert np.all(plan.start.hub_velocity == 0.0) and np.all(plan.start.rho_rate == 0.0)
    assert any("starts at rest" in sentence for sentence in plan.warnings)


def test_a_start_that_shocks_the_bearing_is_told_of(monkeypatch):
    """A hub at 0.9 m/s, as a jump between two equilibria once gave it, strikes with v √(k M): far above the load."""
    scene = parse_scene({"model": "lagrange", **LIGHT["NU206"], "numerics": {"duration_ms": 1.0}}, "scene")

    def shocks():
        return [sentence for sentence in simulate(scene).warnings if "largest static force" in sentence]

    assert not shocks()
    right = Problem.first_state.func

    def wrong(problem):
        found = right(problem)
        return found._replace(state=replace(found.state, x_rate=-0.9))

    monkeypatch.setattr(Problem, "first_state", property(wrong))
    (told,) = shocks()
    assert "within 0.5 ms of the start" in told
