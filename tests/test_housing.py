"""Housing, sensor and the springs of a shaft, in all models: ring-down, statics, energy, and the checker."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import expm

from fem.interface import simulate as run_scene
from fem.kernels.columns import DISSIPATED, KINETIC, WORK_GRAVITY
from fem.kernels.elements.bodies import drift_body, kick_body, write_body
from fem.kernels.jit import OPTIONS
from fem.kernels.mounts import Housing, Resonator, Shaft, late_mass
from fem.solver.rigid.reduced import make_plan as rigid_plan
from fem.solver.simulate import make_plan
from fem.solver.start import equilibrium_start
from fem.statics.exact_statics import reduced_bearing
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import ContactLaws, PowerLaw
from lagrange.errors import InputError
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.mounting import OF_HOUSING, Mounting, Sensor, from_outer_ring
from lagrange.mounting import Housing as HousingFacts
from lagrange.mounting import Shaft as ShaftFacts
from lagrange.scene.scene import Scene, parse_scene, parse_scene_text, read_scene
from residual.evaluation import evaluate
from residual.figures.run import energy_imbalance
from residual.record import relative
from residual.sources import read_result
from tests.reference import kit
from tests.reference.compiled import assert_right, compiled, simulation, solved
from tests.reference.forward_motion import simulate
from tests.reference.kit import PEDESTAL, assert_refused, budget_terms, drive, ring_down, whole_run, within
from tests.reference.synthetic_run import make_run, run_variables, write_result

SENSOR = Sensor(frequency=15e3, damping_ratio=0.05)  # the scene's defaults


def housing(dt: float, mass=12.638, stiffness=15.1e6, damping=2210.7) -> Housing:
    resonator = Resonator(np.zeros(2), SENSOR.step(dt).copy(), SENSOR.step(0.5 * dt).copy(), SENSOR.pull)
    zeros = {name: np.zeros(2) for name in ("place", "velocity", "before", "impulse", "drag")}
    return Housing(
        **zeros, slowed=np.zeros((2, 2)), dissipated=np.zeros(1), ring=None, line=np.zeros((2, 8)), sensor=resonator,
        mass=mass, late_mass=late_mass(mass, damping, dt), stiffness=stiffness, damping=damping, column=20,
    )  # fmt: skip


@njit(**OPTIONS)
def swing(body, drive, rows, by_itself):
    """A housing alone, or a mass on a shaft's springs: a row a step, as samples have them; the last entry its place."""
    for i in range(rows.shape[0]):
        kick_body(body, drive)
        write_body(body, drive, rows[i])
        if by_itself:
            rows[i, -1] = body.place[0]
        drift_body(body, drive)
        if by_itself:
            for k in range(2):
                body.place[k] += drive.dt * body.velocity[k]


def test_the_housing_rings_down_at_its_frequency_and_damping():
    """√(k/m)/2π = 173.97 Hz, c/2√(km) = 8.0 %."""
    body, rows = housing(1e-6), np.zeros((40_000, 26))
    body.place[0] = 1e-5
    swing(body, drive(1e-6), rows, False)
    frequency, zeta = ring_down(-rows[:, 20], 1e-6)
    assert frequency == pytest.approx(173.97, rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * 12.638)), rel=1e-3) == pytest.approx(0.080, rel=1e-3)


def test_its_energy_balances_and_a_large_damping_does_not_shorten_the_step():
    body, rows = housing(2e-6, damping=2e4), np.zeros((4000, 26))
    body.place[:] = 1e-5, 2e-5
    swing(body, drive(2e-6, 9.81), rows, False)
    stored = rows[:, KINETIC] + rows[:, 24]
    left = stored - rows[:, WORK_GRAVITY] + rows[:, DISSIPATED]
    assert np.ptp(stored) > 0.5 * stored[0] < np.ptp(rows[:, DISSIPATED])
    within(left, left[0], 1e-9 * stored[0])
    body = housing(1e-5, mass=0.1, damping=1e7)
    body.velocity[0] = 1.0
    swing(body, drive(1e-5), rows[:300], False)
    assert np.abs(body.velocity[0]) < 1.0


@pytest.mark.parametrize("dt", [1e-7, 1e-5])
def test_the_sensor_rings_down_at_its_frequency_and_damping_whatever_the_step(dt):
    """15 000 Hz and 5.0 %; its own acceleration after a blow on the housing."""
    n, omega, zeta = round(2e-3 / dt), 2.0 * np.pi * 15e3, 0.05
    body, rows = housing(dt, mass=1e6, stiffness=1e-3, damping=0.0), np.zeros((n, 26))
    body.impulse[1] = 1e3
    swing(body, drive(dt), rows, False)
    shown, matrix = rows[1:, 25], np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])
    # the blow, spread over a step, leaves r and ṙ at its end, which then swing freely
    state, some = SENSOR.step(dt)[:, 2] * 1e-3 / dt, range(0, n - 1, max(1, n // 40))
    wanted = [SENSOR.pull @ expm(matrix * dt * (i + 0.5)) @ state for i in some]
    within(shown[list(some)], wanted, 1e-9 * np.abs(shown).max())
    if dt < 1e-6:
        assert ring_down(shown, dt) == pytest.approx((15e3, 0.05), rel=1e-3)


def test_the_sensor_shows_the_housings_acceleration_where_that_is_slow():
    """Amplified by 1/(1 − (f/f₀)²), 4.01e-2 % at 300 Hz; damping ratios change it by 4e-6."""
    step, state, shown = SENSOR.step(1e-6), np.zeros(2), []
    for i in range(10_000):
        state = step @ [*state, np.cos(2.0 * np.pi * 300.0 * (i + 0.5) * 1e-6)]
        shown.append(SENSOR.pull @ state)
    assert np.max(shown[5000:]) == pytest.approx(1.0 / (1.0 - (300.0 / 15e3) ** 2), rel=2e-5)


def test_places_are_taken_from_the_outer_ring_also_where_it_has_a_fit():
    samples = {"inner_x": np.array([3.0, 4.0]), "inner_y": np.array([0.0, 1.0])}
    assert [list(place) for place in from_outer_ring(samples, "inner")] == [[3.0, 4.0], [0.0, 1.0]]
    samples |= {"roller_x": np.ones((2, 3)), "roller_y": np.zeros((2, 3))}
    samples |= {"housing_x": np.array([1.0, 2.0]), "housing_y": np.array([5.0, 6.0])}
    x, y, roller_x, roller_y = from_outer_ring(samples, "inner", "roller")
    assert list(x) == [2.0, 2.0] and list(y) == [-5.0, -5.0]
    assert_array_equal(roller_x, [[0.0] * 3, [-1.0] * 3])
    assert_array_equal(roller_y, [[-5.0] * 3, [-6.0] * 3])
    samples |= {"outer_ring_x": np.array([2.0, 2.0]), "outer_ring_y": np.array([5.0, 5.0])}
    assert [list(place) for place in from_outer_ring(samples, "inner")] == [[1.0, 2.0], [-5.0, -4.0]]


STIFFNESS, DAMPING = 2e8, 400.0
SPRINGS = {"shaft": "springs", "shaft_stiffness_N_per_m": STIFFNESS, "shaft_damping_N_s_m": DAMPING}


@pytest.mark.parametrize(("tables", "words"), [
    ({"support": {"mass_kg": 3.0}}, ['mass_kg = 3: only with kind = "housing"']),
    ({"support": {"kind": "housng"}}, ["support.kind = 'housng'"]),
    ({"support": PEDESTAL | {"mass_kg": -1.0}}, ["support.mass_kg = -1.0", "0.001"]),
    ({"support": PEDESTAL | {"mas_kg": 1.0}}, ["support.mas_kg: unknown key; did you mean mass_kg?"]),
    ({"support": 3}, ["support = 3: must be a table"]),
    ({"sensor": {}}, ["[sensor]", '[support] with kind = "housing"']),
    ({"sensor": {"damping_ratio": 1.0}, "support": PEDESTAL}, ["sensor.damping_ratio = 1.0"]),
    ({"operation": {"shaft": "springs"}}, ['shaft = "springs" needs shaft_stiffness_N_per_m']),
    ({"operation": {"shaft_stiffness_N_per_m": 1e7}}, ['shaft_stiffness_N_per_m = 1e+07: only with shaft = "springs"']),
    ({"operation": {"shaft": "rigid", "shaft_damping_N_s_m": 10.0}},
     ['shaft_damping_N_s_m = 10: only with shaft = "springs"']),
    ({"operation": {"shaft": "springs", "shaft_stiffness_N_per_m": -1.0}},
     ["operation.shaft_stiffness_N_per_m = -1.0"]),
    ({"operation": {"shaft": "spring"}}, ["operation.shaft = 'spring'"]),
    ({"operation": SPRINGS, "contact": {"model": "faceted"}},
     ['operation.shaft = "springs": only with contact.model = "subgrid"']),
])  # fmt: skip
def test_what_makes_no_sense_is_refused_by_name(tables, words):
    assert_refused(tables, *words)


def test_the_tables_survive_as_text_and_absent_ones_are_not_in_it():
    plain = Scene().to_toml().replace("inner_ring_and_shaft_kg", "")
    assert not any(word in plain for word in ("[support]", "[sensor]", "shaft"))
    scene = parse_scene({"support": PEDESTAL, "sensor": {}, "operation": SPRINGS}, "")
    assert parse_scene_text(scene.to_toml(), "") == scene
    mounting = scene.mounting()
    assert mounting.housing.mass == 12.638 and mounting.sensor == SENSOR
    assert mounting.shaft == ShaftFacts(stiffness=STIFFNESS, damping=DAMPING)
    assert parse_scene({"operation": {"shaft": "rigid"}}, "").mounting() == Scene().mounting()


@pytest.mark.parametrize("fit", [{}, {"fit_clearance_um": 20.0}], ids=["held", "with play"])
def test_the_checker_knows_a_moving_outer_ring(tmp_path, fit):
    """A run in a housing that swings: the error of the same run at rest, and what it takes to swing the hub.

    With play it is the ring's place and acceleration; the housing's own motion is not that.
    """
    still, swinging = make_run(n_times=1001), make_run(n_times=1001, scene=parse_scene({"support": PEDESTAL | fit}, ""))
    with pytest.raises(
        InputError, match="missing outer_ring_x, outer_ring_y" if fit else "missing housing_x, housing_y"
    ):
        read_result(write_result(tmp_path / "bare.nc", swinging))
    variables, omega, time = run_variables(swinging), 2.0 * np.pi * 400.0, still.time
    moved, sunk = 3e-6 * np.cos(omega * time), -130e-6 if not fit else 0.0
    swings, nothing = -(omega**2) * moved, 0.0 * moved
    for name in ("inner_y", "roller_y"):
        variables[name] = (variables[name].T + moved + sunk).T
    variables["inner_ay"] = variables["inner_ay"] + swings
    swung = {"x": nothing, "y": moved + sunk, "ax": nothing, "ay": swings}
    if fit:
        variables |= {f"outer_ring_{name}": value for name, value in swung.items()}
        swung = dict.fromkeys(swung, 1e-3 + moved)
    variables |= {f"housing_{name}": value for name, value in swung.items()}
    variables["energy_support"] = 1e-3 + 2e-4 * np.sin(omega * time)
    before = evaluate(read_result(write_result(tmp_path / "still.nc", still)))
    after = evaluate(read_result(write_result(tmp_path / "moving.nc", swinging, variables)))
    force, inside = still.scene.ideal_operation().inner_mass * swings, slice(5, -5)  # one-sided stencils are less exact
    gained = after.y.budget.error - before.y.budget.error
    within(gained[inside], force[inside], 1e-4 * np.abs(force).max())
    within(after.x.budget.error, before.x.budget.error, 1e-6)
    assert "outer_ring" in budget_terms(after)[1] and "outer_ring" not in before.y.budget.terms
    gained = energy_imbalance(after.record.energies) - energy_imbalance(before.record.energies)
    within(gained, 2e-4 * np.sin(omega * time), 1e-12)
    # the differentiation of a cosine of 250 samples a period, by a scheme of sixth order
    assert 0.0 < np.abs(after.y.budget.terms["outer_ring"][inside]).max() < 1e-4 * np.abs(force).max()


def run_in_a_light_housing(**tables):
    """The paper's bearing for 3 ms in a light housing, hit by its load at once: the plan and its samples."""
    light = {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
    numerics = {"mesh_size_mm": 2.0, "duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.2}
    plan = make_plan(parse_scene({"support": light, "sensor": {}, "numerics": numerics} | tables, ""))
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
    housing, outward = plan.operation.mounting.housing, np.exp(1j * values["roller_theta"])
    mass = housing.mass + plan.model.outer_ring.total_mass
    push = np.sum((values["outer_force"] - 1j * values["outer_traction"]) * outward, axis=1)
    for axis, pushed in (("x", push.real), ("y", push.imag - mass * plan.operation.gravity)):
        place, inertia = values[f"housing_{axis}"], mass * values[f"housing_a{axis}"]
        left = pushed - housing.stiffness * place - housing.damping * np.gradient(place, values["time"]) - inertia
        assert np.std(left) < (0.01 if axis == "y" else 0.1) * np.std(inertia)


@pytest.mark.slow
@pytest.mark.parametrize("rigid", [(), ("outer_ring",)])
def test_the_housing_sags_by_load_and_weight_over_stiffness(rigid):
    tables = {"bodies": dict.fromkeys(rigid, "rigid"), "numerics": {"mesh_size_mm": 2.0}}
    tables |= {"operation": {"speed_rpm": 0.0}}
    plan, held = make_plan(parse_scene(tables | {"support": PEDESTAL}, "")), make_plan(parse_scene(tables, ""))
    housing, operation, bearing = plan.operation.mounting.housing, plan.operation, plan.model.bearing
    weight = operation.gravity * (operation.inner_mass + housing.mass + plan.model.outer_ring.total_mass)
    sag = (operation.radial_load + weight) / housing.stiffness
    of_rollers = bearing.n_rollers * bearing.roller_mass * operation.gravity / housing.stiffness
    # the rollers' angles are given in statics, so that only a part of their weight is on the raceways
    assert -plan.start.housing[1] == pytest.approx(sag + 0.5 * of_rollers, abs=0.6 * of_rollers)
    assert_array_equal(plan.start.equilibrium.hub, held.start.equilibrium.hub)


# What holds the shaft beside the bearing: statics, frequency and decay, energy, and what the checker makes of it.

PRELOADED = ("bearing.outer_raceway_diameter_mm=55.98", "operation.gravity_m_s2=0")
HEAVY = 20.0  # kg, of a hub beside which rollers weigh nothing
K = 1e8  # N/m, of a contact that is a linear spring
LINEAR = ContactLaws(*(PowerLaw(name="linear", source="", stiffness=K, exponent=1.0) for _ in range(2)))


def of_scene(*settings):
    scene = read_scene(None, settings)
    return scene.ideal_bearing(), scene.ideal_operation()


def held(operation, stiffness=STIFFNESS, damping=0.0):
    """An operation with springs beside the bearing."""
    return replace(operation, mounting=Mounting(shaft=ShaftFacts(stiffness=stiffness, damping=damping)))


def test_bearing_and_shaft_share_the_load_as_springs_do():
    """Rollers that are linear springs ½ K in series and weigh next to nothing, preloaded: N_b/2 · ½ K beside the
    shaft's."""
    bearing, operation = of_scene(*PRELOADED)
    light = replace(bearing, roller=replace(bearing.roller, density=7.85))
    found = static_equilibrium(light, held(replace(operation, speed=0.0)), LINEAR)
    of_bearing = 0.5 * bearing.n_rollers * 0.5 * K
    assert -found.y == pytest.approx(2000.0 / (of_bearing + STIFFNESS), rel=1e-3)  # contacts' normals turn a little
    carried = -np.sum(found.inner_force * np.sin(found.theta))
    assert carried / 2000.0 == pytest.approx(of_bearing / (of_bearing + STIFFNESS), rel=1e-3)


@pytest.mark.parametrize("ring", [(0.0, 0.0), (3e-6, -20e-6)])
def test_two_statics_that_share_nothing_balance_the_springs(ring):
    """Both carry what the springs leave of the load, wherever the outer ring stands, and in clearance."""
    bearing, operation = of_scene("operation.inner_ring_and_shaft_kg=5", "bearing.outer_raceway_diameter_mm=56.03")
    operation, load = held(operation, 3e7), 1j * (-2000.0 - 5 * 9.81)
    found = static_equilibrium(bearing, operation, contact_laws("harris", bearing), ring=ring)
    states = [(found.rho, found.theta, found.inner_force, found.x + 1j * found.y)]
    if ring == (0.0, 0.0):
        start = equilibrium_start(reduced_bearing(bearing, kinematics(bearing, operation.speed)), operation)
        states.append((start.rho, start.angle, start.inner_force, complex(*start.hub)))
    for (rho, angle, force, hub), error in zip(states, (1e-6, 1e-4), strict=False):
        outward = rho * np.exp(1j * angle) - hub
        pushed = -np.sum(force * outward / np.abs(outward)) - 3e7 * (hub + complex(*ring))
        assert abs(pushed + load) < error


@pytest.mark.parametrize("width", ["of one point", "of many"])
def test_contacts_of_elastic_bodies_share_the_load_with_the_springs(width):
    """What the finite elements' inner contacts carry is what the springs leave of load and weight."""
    soft, mesh, spring = (5.0, 2.2, 3e7) if width == "of one point" else (1.0, 0.8, 3e5)
    start = make_plan(read_scene(None, (
        f"material.youngs_modulus_GPa={soft}", f"numerics.mesh_size_mm={mesh}", "operation.radial_load_N=400",
        "operation.speed_rpm=0", "operation.shaft=springs", f"operation.shaft_stiffness_N_per_m={spring}",
        "operation.inner_ring_and_shaft_kg=5",
    ))).start  # fmt: skip
    found, hub = start.equilibrium, complex(*start.equilibrium.hub)
    outward = found.rho * np.exp(1j * start.angle) - hub
    pushed = -np.sum(found.inner_force * outward / np.abs(outward))
    assert pushed.imag > 40.0 and spring * abs(hub) > 4.0  # both carry some of it
    assert abs(pushed - spring * hub - 1j * (400.0 + 5 * 9.81)) < 0.01


def test_the_hub_swings_on_bearing_and_shaft_and_its_dashpots_take_what_they_should():
    """√((k_b + k_s)/M)/2π and c/2√(kM); within 0.1 %."""
    bearing, operation = of_scene(*PRELOADED, "operation.speed_rpm=0", f"operation.inner_ring_and_shaft_kg={HEAVY}")
    operation = held(replace(operation, radial_load=20.0), damping=6000.0)
    run = solved(Problem(bearing, operation, LINEAR, start="rest"), 8e-3, 1e-5)
    frequency, zeta = ring_down(run.inner_y - static_equilibrium(bearing, operation, LINEAR).y, 1e-5)
    stiffness = 0.5 * bearing.n_rollers * 0.5 * K + STIFFNESS
    assert frequency == pytest.approx(np.sqrt(stiffness / HEAVY) / (2.0 * np.pi), rel=1e-3)
    assert zeta == pytest.approx(6000.0 / (2.0 * np.sqrt(stiffness * HEAVY)), rel=2e-3)
    assert run.work_dissipated[-1] > 0.0 and np.all(run.work_damping == 0.0)
    assert np.abs(run.energy_error).max() < 1e-4 * np.ptp(run.energy_shaft)


def test_no_dashpot_shortens_the_step():
    """Nor is one too strong for it: 1e9 N s/m on a hub of 78 g."""
    bearing, operation = of_scene(*PRELOADED)
    weak, strong = (Problem(bearing, held(operation, damping=c), LINEAR, start="rest") for c in (1.0, 1e9))
    found, creep = compiled(strong, 21), 2000.0 / 1e9  # m/s, against next to no spring
    assert compiled(weak, 21).steps == found.steps
    for run in (found, simulate(strong, 2e-4, 1e-5)):
        assert run.inner_vy[-1] == pytest.approx(-creep, rel=1e-3)
        assert run.work_dissipated[-1] == pytest.approx(2000.0 * creep * 2e-4, rel=1e-2)


def test_an_unbalance_drives_a_circle_on_bearing_and_shaft():
    """F/(k − M ω²) below resonance, k of both by statics."""
    bearing, operation = of_scene(
        *PRELOADED, "operation.radial_load_N=0", "operation.speed_rpm=40000", "operation.inner_ring_and_shaft_kg=5",
        "operation.unbalance_g_mm=20", "operation.shaft=springs", f"operation.shaft_stiffness_N_per_m={STIFFNESS}",
    )  # fmt: skip
    force, laws = 20e-6 * operation.speed**2, contact_laws("harris", bearing)
    stiffness, inertia = kit.stiffness_without_load(bearing, operation, laws, force), 5.0 * operation.speed**2
    assert stiffness > 1.2 * STIFFNESS and inertia / stiffness > 0.04
    run = solved(Problem(bearing, operation, laws), 2 * 60.0 / 40000, 2e-5)
    window = np.sin(np.pi * run.time / run.time[-1]) ** 2
    place = (run.inner_x + 1j * run.inner_y) * window / window.sum()
    ahead = np.sum(place * np.exp(-1j * operation.speed * run.time))
    assert abs(ahead) == pytest.approx(force / (stiffness - inertia), rel=5e-3)


@pytest.mark.parametrize("choices", [{}, {"damping": ContactDamping(constant=200.0)}, {"angles": "free"}])
def test_the_checker_knows_springs_and_dashpots(choices):
    scene = read_scene(None, tuple(f"operation.{key}={value}" for key, value in SPRINGS.items()))
    bearing = scene.ideal_bearing()
    problem = Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing), start="rest", load_ramp=4e-4)
    run = simulate(replace(problem, **choices), 7.4e-4, 1e-5)
    damped = {"damping.contact_N_s_m": 200.0} if "damping" in choices else {}
    scene = scene.varied({"numerics.start": "rest", "numerics.load_ramp_ms": 0.4} | damped)
    found = evaluate(replace(kit.record_of(scene, run), inner_vx=run.inner_vx, inner_vy=run.inner_vy), "harris")
    assert np.ptp(run.energy_shaft) > 1e-4 and np.ptp(found.y.budget.terms["shaft"]) > 0.0
    for terms in budget_terms(found):
        assert np.abs(terms["ring_flexibility"]).max() < 1e-9 * 2000.0  # nothing is missing in the equations


@pytest.mark.parametrize("damping", [500.0, 2210.7, 1e9])
def test_the_time_loops_springs_and_dashpots(damping):
    """A mass on them alone: 173.97 Hz and c/2√(kM) within 0.1 %, and where its energy goes; none is too stiff."""
    rows, zeros = np.zeros((40_000, 20)), {name: np.zeros(2) for name in ("velocity", "before", "drag")}
    body = Shaft(
        place=np.array([1e-5, 0.0]), **zeros, stored=np.zeros(1), slowed=np.zeros((2, 2)), dissipated=np.zeros(1),
        mass=12.638, stiffness=15.1e6, damping=damping, column=17,
    )  # fmt: skip
    swing(body, drive(1e-6), rows, True)
    if damping == 1e9:
        assert np.abs(rows[:, -1]).max() <= 1e-5 * (1.0 + 1e-12)
        return
    frequency, zeta = ring_down(-rows[:, -1], 1e-6)
    assert frequency == pytest.approx(173.97, rel=1e-3)
    assert zeta == pytest.approx(damping / (2.0 * np.sqrt(15.1e6 * 12.638)), rel=1e-3)
    whole = 0.5 * 15.1e6 * 1e-10
    assert rows[:, 17].max() == pytest.approx(whole)  # at rest
    turning = np.flatnonzero(np.diff(np.sign(np.diff(rows[:, -1])))) + 1  # where it stands, all is in the springs
    assert_allclose(rows[turning, 17] + rows[turning, DISSIPATED], whole, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("choices", [{}, {"start": "rest", "load_ramp": 2e-4}, {"angles": "free"}])
@pytest.mark.parametrize("damping", [0.0, DAMPING])
def test_the_compiled_steps_make_the_references_motion(choices, damping):
    problem = Problem(kit.PAPER, held(kit.RUNNING, damping=damping), kit.HARRIS, **choices)
    assert_right(problem, share=5e-3, finer=8.0)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["reduced", "fem"])
def test_elastic_bodies_know_them(model):
    """Energy, what the run's own forces leave of the equations, and the share of the load as statics have it."""
    numerics = {"mesh_size_mm": 2.0, "duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.2}
    result = run_scene(parse_scene({"model": model, "operation": SPRINGS, "numerics": numerics}, ""))
    energies = result.energies
    exchanged = np.ptp(energies["energy_elastic"] + energies["energy_contact"])
    assert np.ptp(energies["energy_shaft"]) > 0.2 * exchanged and np.ptp(kit.energy_left(result)) < 1e-4 * exchanged
    for terms in budget_terms(result.residual()):
        assert np.std(terms["ring_flexibility"]) < (5.0 if model == "fem" else 0.1)  # inertia of an elastic ring


@pytest.mark.slow
def test_the_reduced_models_springs_are_stretched_by_the_place_that_its_samples_tell():
    """A light hub vibrates free of its rollers and its equations hold; by leapfrog's places they missed 5 mN."""
    operation = SPRINGS | {"speed_rpm": 20000.0, "inner_ring_and_shaft_kg": 0.1, "radial_load_N": 500.0}
    numerics = {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 1.0, "output_interval_us": 2.0}
    tables = {"bearing": {"outer_raceway_diameter_mm": 56.2}, "operation": operation, "numerics": numerics}
    result = run_scene(parse_scene({"model": "reduced", **tables}, ""))
    assert np.max(result["inner_force"]) == 0.0 and 0.1 * np.ptp(result["inner_ay"]) > 500.0
    for direction in result.residual().directions:
        assert np.max(np.abs(direction.budget.terms["ring_flexibility"])) < 1e-9 * 500.0


# The outer ring in a housing in the models of rigid bodies

LIGHT = HousingFacts(mass=0.5, stiffness=2e8, damping=4000.0)
SHAFT = ShaftFacts(stiffness=1e8, damping=300.0)
TO_THE_GROUND = {"shaft": "springs", "shaft_stiffness_N_per_m": 1e8, "shaft_damping_N_s_m": 300.0}
HIT = {"start": "rest", "load_ramp": 2e-4}
WAYS = {"held": {}, "free": {"angles": "free"}, "damped": {"damping": ContactDamping(constant=200.0)}}


def mounted(operation, housing=LIGHT, shaft=None):
    return replace(operation, mounting=Mounting(housing=housing, sensor=SENSOR, shaft=shaft))


def weighing(total, bearing, operation):
    """A pedestal that weighs so much, kg, with all that swings with it: elements along the radius alone."""
    rollers = 0.5 * bearing.n_rollers * bearing.roller_mass
    mass = total - bearing.outer_ring_mass - operation.inner_mass - rollers
    return HousingFacts(mass=mass, stiffness=15.1e6, damping=2210.7)


def assert_rings_down(place):
    """√(k/m)/2π = 173.97 Hz and c/2√(km) = 8.0 % of 12.638 kg, bearing and all, as a load comes on."""
    frequency, zeta = ring_down(place + 50.0 / 15.1e6, 5e-5)
    assert frequency == pytest.approx(173.97, rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * 12.638)), rel=1e-3)


def test_the_housing_rings_down_at_its_frequency_and_damping_between_rigid_bodies():
    scene = read_scene(None, (*PRELOADED, "operation.speed_rpm=0"))
    bearing, operation = scene.ideal_bearing(), replace(scene.ideal_operation(), radial_load=50.0)
    housed = mounted(operation, weighing(12.638, bearing, operation))
    problem = Problem(bearing, housed, contact_laws("harris", bearing), start="rest", load_ramp=3e-4)
    assert_rings_down(solved(problem, 0.024, 5e-5).housing_y[6:])


@pytest.mark.slow
def test_the_reduced_model_rings_down_with_its_housing():
    """Its rollers stick, and swing whole."""
    light = "material.roller.density_kg_m3=785"
    scene = read_scene(None, (*PRELOADED, light, "model=reduced", "operation.speed_rpm=0"))
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    mass = weighing(12.638, bearing, operation).mass - 0.5 * bearing.n_rollers * bearing.roller_mass
    changes = {"support.kind": "housing", "support.mass_kg": mass, "operation.radial_load_N": 50.0,
               "numerics.duration_ms": 25.0, "numerics.start": "rest", "numerics.load_ramp_ms": 0.0,
               "numerics.output_interval_us": 50.0}  # fmt: skip
    assert_rings_down(run_scene(scene.varied(changes)).values["housing_y"])


@pytest.mark.parametrize("shaft", [None, SHAFT])
def test_statics_carry_load_and_weights_by_the_springs_of_both_sides(shaft):
    """Both models' starts: load and weights at the springs, and the bearing's own forces between hub and ring."""
    operation, gravity = mounted(kit.RUNNING, shaft=shaft), kit.RUNNING.gravity
    state = Problem(kit.PAPER, operation, kit.HARRIS).first_state.state
    start = equilibrium_start(reduced_bearing(kit.PAPER, kinematics(kit.PAPER, operation.speed)), operation)
    hanging = operation.inner_mass + kit.PAPER.outer_ring_mass + LIGHT.mass
    for ring, hub in ((state.ring_y, state.y + state.ring_y), (start.ring[1], start.hub[1] + start.ring[1])):
        carried = -LIGHT.stiffness * ring - (0.0 if shaft is None else shaft.stiffness * hub)
        # rollers' angles are given, so that only a part of their weight and pull is on the raceways
        left = carried - operation.radial_load - gravity * hanging
        assert 0.0 < left < kit.PAPER.n_rollers * kit.PAPER.roller_mass * gravity
    assert shaft is not None or state.ring_y == pytest.approx(start.ring[1], rel=1e-3)


@pytest.mark.parametrize("shaft", [pytest.param(None, marks=pytest.mark.slow), SHAFT])
@pytest.mark.parametrize("way", ["free", *(pytest.param(way, marks=pytest.mark.slow) for way in ("held", "damped"))])
def test_energy_balances_in_a_housing_that_swings_between_rigid_bodies(way, shaft):
    """Of what swings; held angles take up work with the housing's velocity, and dashpots take what they should."""
    run = solved(Problem(kit.PAPER, mounted(kit.RUNNING, shaft=shaft), kit.HARRIS, **HIT, **WAYS[way]), 5e-4, 1e-5)
    exchanged = np.ptp(run.energy_support)
    assert exchanged > 3e-3 and run.work_dissipated[-1] > 1e-3
    assert np.abs(run.energy_error).max() < 2e-4 * exchanged


def test_the_work_of_held_angles_is_that_of_their_forces():
    """Without rattling the balance closes to the scheme's second order: a preloaded bearing on undamped springs."""
    scene = read_scene(None, PRELOADED[:1])
    bearing = replace(scene.ideal_bearing(), faults=kit.wavy())
    still = mounted(scene.ideal_operation(), replace(LIGHT, damping=0.0))
    problem = Problem(bearing=bearing, operation=still, laws=contact_laws("harris", bearing), **HIT)
    coarse, fine = (compiled(problem, 26, time_step=step) for step in (1e-6, 5e-7))
    errors = [np.abs(run.energy_error).max() for run in (coarse, fine)]
    assert errors[1] < 0.3 * errors[0] and errors[1] < 1e-6 * np.ptp(fine.work_external)


def test_contacts_springs_dashpots_and_weight_accelerate_the_housing_between_rigid_bodies():
    """By differences of its own path and of its velocity's, at every sample."""
    run = simulate(Problem(kit.PAPER, mounted(kit.RUNNING), kit.HARRIS, **HIT, angles="free"), 2e-4, 5e-7)
    mass, place = LIGHT.mass + run.bearing.outer_ring_mass, run.housing_x + 1j * run.housing_y
    velocity, acceleration = np.gradient(place, run.time), np.diff(place, 2) / 25e-14
    push = np.sum(run.outer_force * np.exp(1j * run.roller_theta), axis=1) - 1j * mass * kit.RUNNING.gravity
    left = (push - LIGHT.stiffness * place - LIGHT.damping * velocity)[1:-1] - mass * acceleration
    assert np.std(left) < 1e-3 * np.std(mass * acceleration)
    within((run.housing_ax + 1j * run.housing_ay)[1:-1], acceleration, 2e-3 * np.abs(acceleration).max())


EVERYTHING = (
    "operation.unbalance_g_mm=50", "operation.rotating_load_N=100", "operation.shaft=springs",
    "operation.shaft_stiffness_N_per_m=1e8", "operation.shaft_damping_N_s_m=300", "support.kind=housing",
    "support.mass_kg=0.5", "support.stiffness_N_per_m=2e8", "support.damping_N_s_m=4000",
    "sensor.frequency_Hz=15000", "damping.contact_N_s_m=100", "numerics.duration_ms=8", "numerics.start=rest",
    "numerics.load_ramp_ms=0.2",
)  # fmt: skip
FAULTS = (
    '[[spall]]\nbody = "outer_ring"\nangle_deg = 4.0\n[[waviness]]\nbody = "inner_ring"\norder = 12\n'
    "amplitude_um = 0.5\n[[unequal_roller]]\nroller = 3\ndiameter_deviation_um = 1.0\n"
)


def assert_terms_add_up(found, rest, names):
    """To the error, of which the equations themselves leave the rest, N, and in which all these take part."""
    for terms in budget_terms(found):
        assert np.abs(terms["ring_flexibility"]).max() < rest
        for name in names:
            assert np.ptp(terms[name]) > 0.0, name


@pytest.mark.parametrize(("settings", "speeds"), [
    pytest.param((), kit.RAMP, marks=pytest.mark.slow), (("lubricant.viscosity_Pa_s=0.02",), None)
])  # fmt: skip
def test_the_checkers_terms_sum_up_with_every_option_at_once(tmp_path, settings, speeds):
    """Housing, sensor, shaft, dampers, unbalance, rotating load, faults, tables; a film is of a steady speed only."""
    scene = kit.scene_with(tmp_path, *EVERYTHING, *settings, speeds=speeds, loads=kit.LOADS, more=FAULTS)
    bearing, damping = scene.ideal_bearing(), ContactDamping(constant=100.0)
    problem = Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing), **HIT, damping=damping)
    run = solved(problem, 5.4e-4, 1e-5)
    places = {name: getattr(run, name) for name in ("inner_x", "inner_y", "roller_x", "roller_y", *OF_HOUSING[:4])}
    found = evaluate(replace(  # as the checker would read it from a file
        kit.record_of(scene, run), inner_vx=run.inner_vx, inner_vy=run.inner_vy, inner_damping_force=run.inner_damper,
        outer_damping_force=run.outer_damper, **relative(places, OF_HOUSING[:4]),
    ), "harris")  # fmt: skip
    assert_terms_add_up(found, 1e-9 * 2000.0, ("differentiation", "outer_ring", "shaft", "damping"))


@pytest.mark.slow
def test_the_checkers_terms_sum_up_with_a_cage_and_a_film_too(tmp_path):
    """The reduced model's run, whose kicks are means over a step: 0.1 % of the largest force is not in the terms."""
    result = run_scene(kit.scene_with(
        tmp_path, *EVERYTHING, "cage.pocket_clearance_mm=0.1", "cage.guidance=inner_ring", "cage.mass_kg=0.02",
        "cage.guidance_clearance_mm=0.02", "cage.stiffness_N_per_m=1e8", "model=reduced", "cage.drag_torque_N_m=0.5",
        "lubricant.viscosity_Pa_s=0.02", "numerics.output_interval_us=2", loads=kit.LOADS, more=FAULTS,
    ))  # fmt: skip
    names = "differentiation", "outer_ring", "shaft", "contact_law", "damping", "friction", "cage"
    assert_terms_add_up(result.residual(), 1e-3 * result.values["inner_force"].max(), names)


@pytest.mark.slow
@pytest.mark.parametrize("shaft", [None, SHAFT])
@pytest.mark.parametrize("faults", [(), kit.wavy()])
@pytest.mark.parametrize("way", WAYS)
def test_the_compiled_steps_make_the_references_motion_between_rigid_bodies(way, faults, shaft):
    bearing = replace(kit.PAPER, faults=faults)
    problem = Problem(bearing, mounted(kit.RUNNING, shaft=shaft), contact_laws("harris", bearing), **HIT, **WAYS[way])
    assert_right(problem, share=5e-3, finer=8.0)


@pytest.mark.slow
def test_a_solution_in_parts_has_the_bits_of_the_whole():
    problem = Problem(kit.PAPER, mounted(kit.RUNNING, replace(LIGHT, damping=0.0)), kit.HARRIS, **HIT)
    whole, first = compiled(problem, 90), simulation(problem)
    first.advance(70)
    rest = first.gone_on().advance(20)
    for name in ("inner_y", "housing_y", "sensor_ay", "work_external", "energy_error"):
        np.testing.assert_array_equal(getattr(rest, name), getattr(whole, name)[70:])


@pytest.mark.slow
@pytest.mark.parametrize("more", [{}, {"damping": {"contact_N_s_m": 200.0}, "operation": TO_THE_GROUND}])
def test_the_reduced_model_in_a_light_housing(more):
    """Energy, what the run's own forces leave of (22), (23), the housing's own equation; and it goes on bit for bit."""
    light = PEDESTAL | {"mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0}
    numerics = {"duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.2, "output_interval_us": 2.0}
    tables = {"model": "reduced", "numerics": numerics, "support": light, "sensor": {}} | more
    result = run_scene(parse_scene(tables, ""))
    assert np.ptp(kit.energy_left(result)) < 1e-4 * np.ptp(result.energies["energy_support"])
    for terms in budget_terms(result.residual()):
        assert np.std(terms["ring_flexibility"]) < 0.5
    values, mass = result.values, 0.5 + result.scene.ideal_bearing().outer_ring_mass
    angle, place, inertia = values["roller_theta"], values["housing_y"], mass * values["housing_ay"]
    push = np.sum(values["outer_force"] * np.sin(angle) - values["outer_traction"] * np.cos(angle), axis=1)
    rest = push - mass * 9.81 - 2e8 * place - 4000.0 * np.gradient(place, values["time"]) - inertia
    assert np.std(rest) < 0.01 * np.std(inertia)
    if more:
        numerics.pop("output_interval_us")
        plan = rigid_plan(parse_scene(tables | {"support": PEDESTAL, "numerics": numerics}, ""))
        kit.assert_same_bits(*kit.rest_of_run(plan, 20, 10)[::-1])
