"""The outer ring in a housing in the models of rigid bodies: ring-down, statics, energy, sensor, and the checker."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fem.interface import simulate as run_scene
from fem.solver.rigid.reduced import make_plan
from fem.solver.start import equilibrium_start
from fem.statics.exact_statics import reduced_bearing
from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.mounting import OF_HOUSING, Housing, Mounting, Sensor, Shaft
from lagrange.scene.scene import parse_scene, read_scene
from residual.evaluation import evaluate
from residual.record import relative
from tests.reference import kit
from tests.reference.compiled import assert_right, compiled, simulation, solved
from tests.reference.forward_motion import simulate
from tests.reference.kit import HARRIS, PAPER, PEDESTAL, RUNNING, budget_terms, ring_down, scene_with, wavy, within

LIGHT = Housing(mass=0.5, stiffness=2e8, damping=4000.0)
SENSOR = Sensor(frequency=15e3, damping_ratio=0.05)
SHAFT = Shaft(stiffness=1e8, damping=300.0)
SPRINGS = {"shaft": "springs", "shaft_stiffness_N_per_m": 1e8, "shaft_damping_N_s_m": 300.0}
PRELOADED = ("bearing.outer_raceway_diameter_mm=55.98", "operation.gravity_m_s2=0")
HIT = {"start": "rest", "load_ramp": 2e-4}
WAYS = {"held": {}, "free": {"angles": "free"}, "damped": {"damping": ContactDamping(constant=200.0)}}


def mounted(operation, housing=LIGHT, shaft=None):
    return replace(operation, mounting=Mounting(housing=housing, sensor=SENSOR, shaft=shaft))


def weighing(total, bearing, operation):
    """A pedestal that weighs so much, kg, with all that swings with it: elements along the radius alone."""
    rollers = 0.5 * bearing.n_rollers * bearing.roller_mass
    mass = total - bearing.outer_ring_mass - operation.inner_mass - rollers
    return Housing(mass=mass, stiffness=15.1e6, damping=2210.7)


def assert_rings_down(place):
    """√(k/m)/2π = 173.97 Hz and c/2√(km) = 8.0 % of 12.638 kg, bearing and all, as a load comes on."""
    frequency, zeta = ring_down(place + 50.0 / 15.1e6, 5e-5)
    assert frequency == pytest.approx(173.97, rel=1e-3)
    assert zeta == pytest.approx(2210.7 / (2.0 * np.sqrt(15.1e6 * 12.638)), rel=1e-3)


def test_the_housing_rings_down_at_its_frequency_and_damping():
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
    operation, gravity = mounted(RUNNING, shaft=shaft), RUNNING.gravity
    state = Problem(PAPER, operation, HARRIS).first_state.state
    start = equilibrium_start(reduced_bearing(PAPER, kinematics(PAPER, operation.speed)), operation)
    hanging = operation.inner_mass + PAPER.outer_ring_mass + LIGHT.mass
    for ring, hub in ((state.ring_y, state.y + state.ring_y), (start.ring[1], start.hub[1] + start.ring[1])):
        carried = -LIGHT.stiffness * ring - (0.0 if shaft is None else shaft.stiffness * hub)
        # rollers' angles are given, so that only a part of their weight and pull is on the raceways
        left = carried - operation.radial_load - gravity * hanging
        assert 0.0 < left < PAPER.n_rollers * PAPER.roller_mass * gravity
    assert shaft is not None or state.ring_y == pytest.approx(start.ring[1], rel=1e-3)


@pytest.mark.parametrize("shaft", [pytest.param(None, marks=pytest.mark.slow), SHAFT])
@pytest.mark.parametrize("way", ["free", *(pytest.param(way, marks=pytest.mark.slow) for way in ("held", "damped"))])
def test_energy_balances_in_a_housing_that_swings(way, shaft):
    """Of what swings; held angles take up work with the housing's velocity, and dashpots take what they should."""
    run = solved(Problem(PAPER, mounted(RUNNING, shaft=shaft), HARRIS, **HIT, **WAYS[way]), 5e-4, 1e-5)
    exchanged = np.ptp(run.energy_support)
    assert exchanged > 3e-3 and run.work_dissipated[-1] > 1e-3
    assert np.abs(run.energy_error).max() < 2e-4 * exchanged


def test_the_work_of_held_angles_is_that_of_their_forces():
    """Without rattling the balance closes to the scheme's second order: a preloaded bearing on undamped springs."""
    scene = read_scene(None, PRELOADED[:1])
    bearing = replace(scene.ideal_bearing(), faults=wavy())
    still = mounted(scene.ideal_operation(), replace(LIGHT, damping=0.0))
    problem = Problem(bearing=bearing, operation=still, laws=contact_laws("harris", bearing), **HIT)
    coarse, fine = (compiled(problem, 26, time_step=step) for step in (1e-6, 5e-7))
    errors = [np.abs(run.energy_error).max() for run in (coarse, fine)]
    assert errors[1] < 0.3 * errors[0] and errors[1] < 1e-6 * np.ptp(fine.work_external)


def test_contacts_springs_dashpots_and_weight_accelerate_the_housing():
    """By differences of its own path and of its velocity's, at every sample."""
    run = simulate(Problem(PAPER, mounted(RUNNING), HARRIS, **HIT, angles="free"), 2e-4, 5e-7)
    mass, place = LIGHT.mass + run.bearing.outer_ring_mass, run.housing_x + 1j * run.housing_y
    velocity, acceleration = np.gradient(place, run.time), np.diff(place, 2) / 25e-14
    push = np.sum(run.outer_force * np.exp(1j * run.roller_theta), axis=1) - 1j * mass * RUNNING.gravity
    left = (push - LIGHT.stiffness * place - LIGHT.damping * velocity)[1:-1] - mass * acceleration
    assert np.std(left) < 1e-3 * np.std(mass * acceleration)
    within((run.housing_ax + 1j * run.housing_ay)[1:-1], acceleration, 2e-3 * np.abs(acceleration).max())


def test_the_sensor_shows_what_its_equation_says():
    """r̈ + 2ζω ṙ + ω² r = −Ÿ, integrated again from the housing's acceleration."""
    run, omega = simulate(Problem(PAPER, mounted(RUNNING), HARRIS, **HIT), 4e-4, 1e-6), 2.0 * np.pi * SENSOR.frequency

    def rate(time, state):
        r, r_rate = state
        return r_rate, -np.interp(time, run.time, run.housing_ay) - 0.1 * omega * r_rate - omega**2 * r

    found = solve_ivp(rate, (0.0, 4e-4), (0.0, 0.0), t_eval=run.time, rtol=1e-8, atol=1e-16, max_step=1e-6).y
    wanted = -(omega**2) * found[0] - 0.1 * omega * found[1]
    within(run.sensor_ay, wanted, 2e-3 * np.abs(wanted).max())


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
    scene = scene_with(tmp_path, *EVERYTHING, *settings, speeds=speeds, loads=kit.LOADS, more=FAULTS)
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
    result = run_scene(scene_with(
        tmp_path, *EVERYTHING, "cage.pocket_clearance_mm=0.1", "cage.guidance=inner_ring", "cage.mass_kg=0.02",
        "cage.guidance_clearance_mm=0.02", "cage.stiffness_N_per_m=1e8", "model=reduced", "cage.drag_torque_N_m=0.5",
        "lubricant.viscosity_Pa_s=0.02", "numerics.output_interval_us=2", loads=kit.LOADS, more=FAULTS,
    ))  # fmt: skip
    names = "differentiation", "outer_ring", "shaft", "contact_law", "damping", "friction", "cage"
    assert_terms_add_up(result.residual(), 1e-3 * result.values["inner_force"].max(), names)


@pytest.mark.slow
@pytest.mark.parametrize("shaft", [None, SHAFT])
@pytest.mark.parametrize("faults", [(), wavy()])
@pytest.mark.parametrize("way", WAYS)
def test_the_compiled_steps_make_the_references_motion(way, faults, shaft):
    bearing = replace(PAPER, faults=faults)
    problem = Problem(bearing, mounted(RUNNING, shaft=shaft), contact_laws("harris", bearing), **HIT, **WAYS[way])
    assert_right(problem, share=5e-3, finer=8.0)


@pytest.mark.slow
def test_a_solution_in_parts_has_the_bits_of_the_whole():
    problem = Problem(PAPER, mounted(RUNNING, replace(LIGHT, damping=0.0)), HARRIS, **HIT)
    whole, first = compiled(problem, 90), simulation(problem)
    first.advance(70)
    rest = first.gone_on().advance(20)
    for name in ("inner_y", "housing_y", "sensor_ay", "work_external", "energy_error"):
        np.testing.assert_array_equal(getattr(rest, name), getattr(whole, name)[70:])


@pytest.mark.slow
@pytest.mark.parametrize("more", [{}, {"damping": {"contact_N_s_m": 200.0}, "operation": SPRINGS}])
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
        plan = make_plan(parse_scene(tables | {"support": PEDESTAL, "numerics": numerics}, ""))
        kit.assert_same_bits(*kit.rest_of_run(plan, 20, 10)[::-1])
