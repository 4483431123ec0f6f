"""The housing of the outer ring and the sensor on it: ring-down, sag, energy, and what the checker makes of them."""

import numpy as np
import pytest
from numba import njit
from scipy.linalg import expm

from fem.kernels.columns import DISSIPATED, KINETIC, WORK_GRAVITY
from fem.kernels.elements.bodies import drift_body, kick_body, write_body
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Housing, Resonator, late_mass
from fem.solver.simulate import make_plan
from lagrange.mounting import Sensor, from_outer_ring
from lagrange.scene.scene import parse_scene, parse_scene_text
from residual.errors import InputError
from residual.evaluation import evaluate
from residual.figures.run import energy_imbalance
from residual.sources import read_result
from tests.reference.budgets import budget_terms
from tests.reference.refusals import assert_refused
from tests.reference.swinging import PEDESTAL, drive, ring_down
from tests.reference.synthetic_run import make_run, run_variables, write_result
from tests.reference.whole_run import whole_run

SENSOR: dict = {}  # its defaults: 15 kHz, 5 %


def housing(dt: float, mass=12.638, stiffness=15.1e6, damping=2210.7) -> Housing:
    sensor = Sensor(frequency=15e3, damping_ratio=0.05)
    resonator = Resonator(np.zeros(2), sensor.step(dt).copy(), sensor.step(0.5 * dt).copy(), sensor.pull)
    return Housing(
        place=np.zeros(2), velocity=np.zeros(2), before=np.zeros(2), impulse=np.zeros(2), drag=np.zeros(2),
        slowed=np.zeros((2, 2)), dissipated=np.zeros(1), ring=None, line=np.zeros((2, 8)), sensor=resonator, mass=mass,
        late_mass=late_mass(mass, damping, dt), stiffness=stiffness, damping=damping, column=20,
    )  # fmt: skip


@njit(**OPTIONS)
def swing(body, drive, rows):
    """The housing alone: a row a step, as samples have them."""
    for i in range(rows.shape[0]):
        kick_body(body, drive)
        write_body(body, drive, rows[i])
        drift_body(body, drive)


def test_the_housing_rings_down_at_its_frequency_and_damping():
    """√(k/m)/2π = 173.97 Hz, c/2√(km) = 8.0 %."""
    dt = 1e-6
    body = housing(dt)
    body.place[0] = 1e-5
    rows = np.zeros((40_000, 26))
    swing(body, drive(dt), rows)
    frequency, zeta = ring_down(-rows[:, 20], dt)
    assert frequency == pytest.approx(173.97, rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * 12.638)), rel=1e-3)
    assert zeta == pytest.approx(0.080, rel=1e-3)


def test_its_energy_balances_as_its_dashpots_take_it_and_its_weight_gives_it():
    dt = 2e-6
    body, rows = housing(dt, damping=2e4), np.zeros((4000, 26))
    body.place[:] = 1e-5, 2e-5
    swing(body, drive(dt, 9.81), rows)
    stored = rows[:, KINETIC] + rows[:, 24]
    left = stored - rows[:, WORK_GRAVITY] + rows[:, DISSIPATED]
    assert np.ptp(stored) > 0.5 * stored[0]
    np.testing.assert_allclose(left, left[0], rtol=0.0, atol=1e-9 * stored[0])
    assert np.ptp(rows[:, DISSIPATED]) > 0.5 * stored[0]


def test_a_large_damping_does_not_shorten_the_step():
    dt = 1e-5
    body, rows = housing(dt, mass=0.1, damping=1e7), np.zeros((300, 26))
    body.velocity[0] = 1.0
    swing(body, drive(dt), rows)
    assert np.abs(body.velocity[0]) < 1.0


@pytest.mark.parametrize("dt", [1e-7, 1e-5])
def test_the_sensor_rings_down_at_its_frequency_and_damping_whatever_the_step(dt):
    """15 000 Hz and 5.0 %; its own acceleration after a blow on the housing."""
    n = round(2e-3 / dt)
    body, rows = housing(dt, mass=1e6, stiffness=1e-3, damping=0.0), np.zeros((n, 26))
    body.impulse[1] = 1e3
    swing(body, drive(dt), rows)
    shown = rows[1:, 25]
    sensor = Sensor(frequency=15e3, damping_ratio=0.05)
    omega, zeta = 2.0 * np.pi * 15e3, 0.05
    matrix = np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])
    # the blow, spread over a step, leaves r and ṙ at its end, which then swing freely
    state = sensor.step(dt)[:, 2] * 1e-3 / dt
    wanted = [sensor.pull @ expm(matrix * dt * (i + 0.5)) @ state for i in range(0, n - 1, max(1, n // 40))]
    np.testing.assert_allclose(shown[:: max(1, n // 40)], wanted, rtol=0.0, atol=1e-9 * np.abs(shown).max())
    if dt < 1e-6:
        frequency, damping = ring_down(shown, dt)
        assert frequency == pytest.approx(15e3, rel=1e-3)
        assert damping == pytest.approx(0.05, rel=1e-3)


def test_the_sensor_shows_the_housings_acceleration_where_that_is_slow():
    """Amplified by 1/(1 − (f/f₀)²), 4.01e-2 % at 300 Hz; damping ratios change it by 4e-6."""
    sensor, dt, omega = Sensor(frequency=15e3, damping_ratio=0.05), 1e-6, 2.0 * np.pi * 300.0
    step, state = sensor.step(dt), np.zeros(2)
    shown = []
    for i in range(10_000):
        state = step @ [*state, np.cos(omega * (i + 0.5) * dt)]
        shown.append(sensor.pull @ state)
    assert np.max(shown[5000:]) == pytest.approx(1.0 / (1.0 - (300.0 / 15e3) ** 2), rel=2e-5)


def test_places_are_taken_from_the_outer_ring():
    samples = {"inner_x": np.array([3.0, 4.0]), "inner_y": np.array([0.0, 1.0])}
    assert [list(place) for place in from_outer_ring(samples, "inner")] == [[3.0, 4.0], [0.0, 1.0]]
    samples |= {"roller_x": np.ones((2, 3)), "roller_y": np.zeros((2, 3))}
    samples |= {"housing_x": np.array([1.0, 2.0]), "housing_y": np.array([5.0, 6.0])}
    x, y, roller_x, roller_y = from_outer_ring(samples, "inner", "roller")
    assert list(x) == [2.0, 2.0] and list(y) == [-5.0, -5.0]
    np.testing.assert_array_equal(roller_x, [[0.0] * 3, [-1.0] * 3])
    np.testing.assert_array_equal(roller_y, [[-5.0] * 3, [-6.0] * 3])


@pytest.mark.parametrize(("tables", "words"), [
    ({"support": {"mass_kg": 3.0}}, ['mass_kg = 3.0: only with kind = "housing"']),
    ({"support": {"kind": "housng"}}, ["support.kind = 'housng'"]),
    ({"support": PEDESTAL | {"mass_kg": -1.0}}, ["support.mass_kg = -1.0", "0.001"]),
    ({"support": PEDESTAL | {"mas_kg": 1.0}}, ["support.mas_kg: unknown key; did you mean mass_kg?"]),
    ({"support": 3}, ["support = 3: must be a table"]),
    ({"sensor": {}}, ["[sensor]", '[support] with kind = "housing"']),
    ({"sensor": {"damping_ratio": 1.0}, "support": PEDESTAL}, ["sensor.damping_ratio = 1.0"]),
])  # fmt: skip
def test_what_makes_no_sense_is_refused_by_name(tables, words):
    assert_refused(tables, *words)


def test_the_tables_survive_as_text_and_absent_ones_are_not_in_it():
    assert "[support]" not in parse_scene({}, "").to_toml() and "[sensor]" not in parse_scene({}, "").to_toml()
    scene = parse_scene({"support": PEDESTAL, "sensor": SENSOR}, "")
    assert parse_scene_text(scene.to_toml(), "") == scene
    assert scene.mounting().housing.mass == 12.638 and scene.mounting().sensor.frequency == 15e3


def test_the_checker_knows_a_moving_outer_ring(tmp_path):
    """A run in a housing that swings: the error of the same run at rest, and what it takes to swing the hub."""
    scene = parse_scene({"support": PEDESTAL}, "")
    still = make_run(n_times=1001)
    swinging = make_run(n_times=1001, scene=scene)
    variables, omega, amplitude = run_variables(swinging), 2.0 * np.pi * 400.0, 3e-6
    moved = amplitude * np.cos(omega * still.time)
    swings = -(omega**2) * moved
    for name in ("inner_y", "roller_y"):
        variables[name] = (variables[name].T + moved - 130e-6).T
    variables["inner_ay"] = variables["inner_ay"] + swings
    variables |= {"housing_x": 0.0 * moved, "housing_y": moved - 130e-6, "housing_ax": 0.0 * moved}
    variables["housing_ay"] = swings
    variables["energy_support"] = 1e-3 + 2e-4 * np.sin(omega * still.time)
    before = evaluate(read_result(write_result(tmp_path / "still.nc", still)))
    after = evaluate(read_result(write_result(tmp_path / "moving.nc", swinging, variables)))
    force = still.scene.ideal_operation().inner_mass * swings
    inside = slice(5, -5)  # one-sided stencils at the ends are less exact
    gained = after.y.budget.error - before.y.budget.error
    np.testing.assert_allclose(gained[inside], force[inside], rtol=0.0, atol=1e-4 * np.abs(force).max())
    np.testing.assert_allclose(after.x.budget.error, before.x.budget.error, rtol=0.0, atol=1e-6)
    assert "outer_ring" in budget_terms(after)[1] and "outer_ring" not in before.y.budget.terms
    gained = energy_imbalance(after.record.energies) - energy_imbalance(before.record.energies)
    np.testing.assert_allclose(gained, 2e-4 * np.sin(omega * still.time), rtol=0.0, atol=1e-12)
    # the differentiation of a cosine of 250 samples a period, by a scheme of sixth order
    assert 0.0 < np.abs(after.y.budget.terms["outer_ring"][inside]).max() < 1e-4 * np.abs(force).max()


def test_a_run_in_a_housing_without_its_places_is_refused(tmp_path):
    swinging = make_run(n_times=101, scene=parse_scene({"support": PEDESTAL}, ""))
    with pytest.raises(InputError, match="missing housing_x, housing_y"):
        read_result(write_result(tmp_path / "run.nc", swinging))


def run_in_a_light_housing(**tables):
    """The paper's bearing for 3 ms in a light housing, hit by its load at once: the plan and its samples."""
    light = {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
    numerics = {"mesh_size_mm": 2.0, "duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.2}
    plan = make_plan(parse_scene({"support": light, "sensor": SENSOR, "numerics": numerics} | tables, ""))
    return plan, whole_run(plan)


@pytest.mark.slow
def test_energy_balances_in_a_housing_that_swings():
    """Within 4e-9 J of 21 mJ; the same bearing on the ground: 1.3e-9 J of 3.6 mJ, as much of it."""
    _, values = run_in_a_light_housing()
    assert np.ptp(values["energy_support"]) > 5e-3 and values["work_dissipated"][-1] > 5e-3, "it swings and is damped"
    assert np.abs(values.imbalance).max() < 3e-7 * np.ptp(values["energy_support"])


@pytest.mark.slow
def test_contacts_springs_dashpots_and_weight_accelerate_the_housing():
    """With a rigid ring: M ẍ = ΣQ n + ΣT t − k x − c ẋ, at every sample, but for the difference that gives ẋ."""
    plan, values = run_in_a_light_housing(bodies={"outer_ring": "rigid"})
    housing, angle = plan.operation.mounting.housing, values["roller_theta"]
    mass = housing.mass + plan.model.outer_ring.total_mass
    normal, along = values["outer_force"], values["outer_traction"]
    pushed = {
        "x": np.sum(normal * np.cos(angle) + along * np.sin(angle), axis=1),
        "y": np.sum(normal * np.sin(angle) - along * np.cos(angle), axis=1) - mass * plan.operation.gravity,
    }
    for axis, push in pushed.items():
        place, inertia = values[f"housing_{axis}"], mass * values[f"housing_a{axis}"]
        left = push - housing.stiffness * place - housing.damping * np.gradient(place, values["time"]) - inertia
        assert np.std(left) < (0.01 if axis == "y" else 0.1) * np.std(inertia)


@pytest.mark.slow
@pytest.mark.parametrize("rigid", [(), ("outer_ring",)])
def test_the_housing_sags_by_load_and_weight_over_stiffness(rigid):
    tables = {"bodies": dict.fromkeys(rigid, "rigid"), "numerics": {"mesh_size_mm": 2.0}}
    tables |= {"operation": {"speed_rpm": 0.0}}
    plan, held = make_plan(parse_scene(tables | {"support": PEDESTAL}, "")), make_plan(parse_scene(tables, ""))
    housing, operation, bearing = plan.operation.mounting.housing, plan.operation, plan.model.bearing
    ring = housing.mass + plan.model.outer_ring.total_mass
    weight = operation.gravity * (operation.inner_mass + ring)
    sag = (operation.radial_load + weight) / housing.stiffness
    of_rollers = bearing.n_rollers * bearing.roller_mass * operation.gravity / housing.stiffness
    # the rollers' angles are given in statics, so that only a part of their weight is on the raceways
    assert -plan.start.housing[1] == pytest.approx(sag + 0.5 * of_rollers, abs=0.6 * of_rollers)
    np.testing.assert_array_equal(plan.start.equilibrium.hub, held.start.equilibrium.hub)
