"""Whole runs with a cage, given or by default; momenta and energy of elements and a free cage."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.interface import simulate as run_scene
from fem.solver.simulate import make_plan
from lagrange import contact_laws
from lagrange.catalogue import elements
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.mounting import HELD, Housing, Mounting
from lagrange.rating.life import dynamic_capacity
from lagrange.scene.scene import parse_scene
from tests.reference.compiled import compiled, simulation
from tests.reference.kit import RAMP, assert_same_bits, balance_of, caged, rest_of_run, scene_with

pytestmark = pytest.mark.slow  # each compiles a time loop
GUIDED = {"guidance": "inner_ring", "guidance_clearance_mm": 0.05, "pocket_clearance_mm": 0.1, "drag_torque_N_m": 0.5}
COARSE = {"mesh_size_mm": 2.0}


@pytest.mark.parametrize(("model", "limit"), [("fem", 1e-5), ("reduced", 1e-3)])
@pytest.mark.parametrize("cage", [{"pocket_clearance_mm": 0.1}, GUIDED], ids=["rollers", "inner_ring"])
def test_energy_balances_with_a_cage_and_a_run_goes_on_bit_for_bit(model, limit, cage):
    """Finite elements: friction's work is off by how much the rollers swell and bend, 2e-6; contacts by less."""
    found = caged(model, 12.0, cage, numerics=COARSE)
    assert found.imbalance < limit
    lost = sum(found.values[f"cage_work_{name}"][-1] for name in ("dashpots", "friction", "drag"))
    assert 0.0 < lost < found.values["work_dissipated"][-1]
    if cage is GUIDED:
        tables = {"model": model, "cage": cage, "numerics": {"duration_ms": 2.0, **COARSE}}
        expected, found = rest_of_run(make_plan(parse_scene(tables, "scene")), 100, 101)
        assert np.ptp(expected["cage_x"]) > 0.0
        assert_same_bits(found, expected)


@pytest.mark.parametrize(("speed", "limit"), [(1000.0, 1e-7), (20000.0, 1e-4)])
def test_the_first_kicks_give_what_contacts_press_with(speed, limit):
    """In equilibrium, of the largest force: no contact owes energy before the first step."""
    numerics = {"output_interval_us": 1.0, "duration_ms": 0.1}
    tables = {"model": "reduced", "cage": {}, "operation": {"speed_rpm": speed}, "numerics": numerics}
    state = make_plan(parse_scene(tables, "")).first_state()
    for _ in range(6):
        state.advance(1)
        assert np.abs(state.forces.kick[:2] - state.forces.force[:2]).max() < limit * state.forces.force.max()


def test_rollers_keep_their_distance_and_the_cage_turns_with_them_at_ftf_less_creep():
    found = caged("reduced", 340.0, {"pocket_clearance_mm": 0.1})
    deepest = np.hypot(found.values["cage_force"], found.values["cage_radial_force"]).max() / 1e8  # m, into walls
    assert 2e-5 < found.spacing < 1e-4 + 2.0 * deepest
    assert abs(found.slip(0.0) - found.slip(0.0, "rollers")) < 1e-4
    free = caged("reduced", 100.0, {}, operation={"gravity_m_s2": 0.0})  # without drag and weight
    assert 0.0 <= free.slip(0.0, "rollers") < 1e-3  # Carter: full slip at 1.3e-3


def test_a_cage_under_its_own_weight_is_driven_from_the_shorter_arm():
    """Its centre hangs d below the bearing's, loaded rollers below that drive it: faster by up to d over the pitch."""
    found = caged("reduced", 340.0, {"pocket_clearance_mm": 0.1, "friction_coefficient": 0.0})
    hangs = -found.values["cage_y"][len(found.values["time"]) // 10 :].mean() / 0.023
    assert 1e-3 < hangs < 2.2e-3 and -hangs < found.slip(0.0) < -0.5 * hangs


def drag_runs(shares, duration=4.0):
    """Of shares of the drag that rollers bear: a roller's force, N, and of the late half of its run every column."""
    # a heavy cage falls softly into tight pockets, and a heavy hub does not whirl by the friction of sliding rollers
    stiff = {"pocket_clearance_mm": 0.002, "damping_N_s_m": 1000.0, "friction_coefficient": 0.0, "mass_kg": 1.0}
    heavy = {"radial_load_N": 0.0, "gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 1000.0}
    scene = {"bearing": {"outer_raceway_diameter_mm": 55.99}, "contact": {"friction_coefficient": 0.1}}
    scene |= {"operation": heavy}
    still = caged("reduced", 0.1, stiff, **scene).values
    limit = 0.1 * float((still["inner_force"] + still["outer_force"])[0].mean())
    for share in shares:
        cage = stiff | {"drag_torque_N_m": share * limit * 13 * 0.5 * (0.018 + 0.027995)}
        values = caged("reduced", duration, cage, **scene).values
        yield share * limit, values, {name: value[len(values["time"]) // 2 :] for name, value in values.items()}


def test_frictionless_pockets_share_the_drag_and_rollers_slide_from_twice_the_friction_of_a_contact_on():
    """Equally between the raceways; F = 2 μ Q within 2 %: by the cage's slowing down, in a straight line from sliding
    rollers back to none."""
    for force, _, late in drag_runs((0.25, 0.5, 0.9)):
        assert_allclose([late["inner_traction"], late["outer_traction"]], 0.5 * force, rtol=2e-3)
    slowing = [-np.polyfit(late["time"], late["cage_speed"], 1)[0] for _, _, late in drag_runs((1.05, 1.2))]
    assert slowing[0] > 1e3  # rad/s²
    assert 1.05 - 0.15 * slowing[0] / (slowing[1] - slowing[0]) == pytest.approx(1.0, abs=0.02)
    ((_, held, _),) = drag_runs((0.97,), 8.0)
    assert held["cage_speed"][-1] == pytest.approx(held["cage_speed"][0], rel=2e-3)


def test_many_rollers_under_light_load_slip_more_than_loaded_ones():
    bearing = {"rollers": 23, "inner_raceway_diameter_mm": 70.0, "outer_raceway_diameter_mm": 90.01,
               "bore_diameter_mm": 55.0, "outside_diameter_mm": 105.0}  # fmt: skip
    cage = {"guidance": "outer_ring", "guidance_clearance_mm": 0.05, "drag_torque_N_m": 0.3}
    operations = ({"speed_rpm": 1e4, "radial_load_N": load, "inner_ring_and_shaft_kg": 0.5} for load in (50.0, 2000.0))
    light, loaded = (caged("reduced", 150.0, cage, bearing=bearing, operation=how).slip(0.5) for how in operations)
    assert light > 2e-3 and light > 2.0 * loaded > 0.0  # 0.2 %: where published slips begin


@pytest.mark.parametrize(("model", "limit"), [("fem", 1e-5), ("reduced", 5e-4), ("lagrange", 1e-6)])
def test_a_ring_that_speeds_up_rubs_on_its_cage(tmp_path, model, limit):
    """With the shaft's speed of every step; the reduced model's rattling rollers cost 2e-4 guided by rollers, too."""
    shorter = ("numerics.time_step_safety=0.5",) if model == "reduced" else ()  # rattling in flat pockets
    scene = scene_with(
        tmp_path, "cage.guidance=inner_ring", "cage.guidance_clearance_mm=0.02", "cage.pocket_clearance_mm=0.2",
        "cage.friction_coefficient=0.3", "cage.mass_kg=0.02", "cage.stiffness_N_per_m=1e8", "numerics.duration_ms=8",
        f"model={model}", "lagrange.angles=free", "numerics.mesh_size_mm=2", *shorter, speeds=RAMP,
    )  # fmt: skip
    result = run_scene(scene)
    values = result.values
    assert values["cage_work_friction"][-1] > 1e-3
    assert np.hypot(values["cage_guidance_x"], values["cage_guidance_y"]).max() > 1.0
    assert balance_of(result) < limit
    if model != "lagrange":  # whose raceways don't drive rollers
        followed = kinematics(scene.ideal_bearing(), 6000.0 * np.pi / 30.0).cage
        assert values["cage_speed"][-1] == pytest.approx(followed, rel=0.03)  # six times that of the start
    if model == "reduced":  # whose works end a step later
        assert_same_bits(*rest_of_run(make_plan(scene), 20, 10)[::-1])


@pytest.mark.parametrize(("model", "limit"), [("fem", 1e-5), ("reduced", 1e-4)])
def test_an_outer_ring_in_a_housing_guides_its_cage(model, limit):
    """The guide's force is the housing's too: its equation of motion, and the balance of energies.

    Over means of 0.1 ms: waves in the ring of finite elements are faster.
    """
    result = run_scene(parse_scene({
        "model": model,
        "support": {"kind": "housing", "mass_kg": 0.5, "stiffness_N_per_m": 2e8, "damping_N_s_m": 4000.0},
        "cage": {"guidance": "outer_ring", "guidance_clearance_mm": 0.02, "pocket_clearance_mm": 0.2, "mass_kg": 0.2},
        "numerics": {"duration_ms": 3.0, "start": "rest", "load_ramp_ms": 0.2, "output_interval_us": 2.0, **COARSE},
    }, ""))  # fmt: skip
    assert balance_of(result) < limit
    values, mass = result.values, 0.5 + result.scene.ideal_bearing().outer_ring_mass
    angle = values["roller_theta"]
    push = np.sum(values["outer_force"] * np.sin(angle) - values["outer_traction"] * np.cos(angle), axis=1)
    place, inertia, guide = values["housing_y"], mass * values["housing_ay"], -values["cage_guidance_y"]
    rest = push + guide - mass * 9.81 - 2e8 * place - 4000.0 * np.gradient(place, values["time"]) - inertia
    inertia, guide, rest = (np.std(np.convolve(force, np.full(50, 0.02), "valid")) for force in (inertia, guide, rest))
    assert guide > 0.1 * inertia and rest < 0.01 * inertia


BEARINGS = "NU204", "N206", "NJ306", "NU1006", "NU2210", "NA4906", "NU316", "NU220"
SPEEDS = (300.0, 8), (1500.0, 5), (3000.0, 3), (9000.0, 2)  # rpm, per cent of the dynamic rating as load


@pytest.mark.parametrize(("number", "designation"), list(enumerate(BEARINGS)))
def test_rollers_in_the_default_cage_orbit_as_rolling(number, designation):
    """Within −0.1 to +0.25 %, the cage's own slip with them: over two turns, at two speeds and loads each."""
    for rpm, share in (SPEEDS[number % 4], SPEEDS[(number + 2) % 4]):
        operation = {"speed_rpm": rpm, "radial_load_N": 0.01 * share * dynamic_capacity(elements(designation).row)}
        scene = parse_scene({"model": "reduced", "bearing": {"designation": designation}, "operation": operation}, "")
        pitch = 2e6 * scene.perfect_bearing().pitch_radius  # µm
        turn = 2e3 * np.pi / kinematics(scene.ideal_bearing(), scene.ideal_operation().speed).cage  # ms
        changes = {"bearing.clearance_um": 3.5e-4 * pitch, "numerics.duration_ms": 30.0 + 2.0 * turn}
        found = run_scene(scene.varied(changes))
        late, ideal = found.time > 0.03, kinematics(scene.ideal_bearing(), scene.ideal_operation().speed).cage
        for angle in (found["roller_theta"].mean(axis=1)[late], found["cage_angle"][late]):
            speed = np.ptp(angle) / np.ptp(found.time[late])
            assert -1e-3 < speed / ideal - 1.0 < 2.5e-3, (designation, rpm)
        assert abs(found.quantities["cage_slip"].value) < 2.5e-3


# Elements and a free cage: momenta and energy

GUIDES = {
    "rollers": {}, "inner ring": {"guidance": "inner_ring", "guidance_clearance_mm": 0.01},
    "outer ring": {"guidance": "outer_ring", "guidance_clearance_mm": 0.01},
}  # fmt: skip


def problem(guide, mounting=HELD, operation=None, **cage):
    """The paper's bearing, eight of its rollers, at rest under its load at once, among pockets that soon touch."""
    tables = {"pocket_clearance_mm": 0.01, "drag_torque_N_m": 0.05, "friction_coefficient": 0.2} | cage
    scene = parse_scene({"cage": GUIDES[guide] | tables}, "scene")
    bearing = replace(scene.ideal_bearing(), n_rollers=8)
    running = replace(scene.ideal_operation(), mounting=mounting, **(operation or {}))
    return Problem(
        bearing=bearing, operation=running, laws=contact_laws("harris", bearing), start="rest", angles="free",
        cage=scene.ideal_cage(), damping=ContactDamping(constant=0.0),
    )  # fmt: skip


def touch(run, guide):
    """Whether pockets push, and so does the guide."""
    return np.abs(run.cage.force).max() > 1.0 and (guide == "rollers" or np.abs(run.cage.guidance_y).max() > 1.0)


def momentum(going):
    """Of all that moves, half a step before, N s, x + iy"""
    bodies = going.state.bodies
    moving = (
        (bodies.hub_mass, bodies.hub_velocity), (bodies.housing.mass, bodies.housing.velocity),
        (bodies.cage.cage.mass, bodies.cage.cage.motion[1]), (bodies.mass, bodies.velocity[:, : bodies.n].sum(axis=1)),
    )  # fmt: skip
    return sum(mass * complex(velocity[0], velocity[1]) for mass, velocity in moving)


@pytest.mark.parametrize("guide", GUIDES)
def test_momentum_of_hub_elements_cage_and_housing_is_what_the_load_gives(guide):
    """Springs to the ground are next to nothing: every force but the load has its counterpart, though places are from a
    ring that accelerates."""
    slack = Mounting(housing=Housing(mass=0.5, stiffness=1e-9, damping=0.0))
    what = problem(guide, slack, operation={"gravity": 0.0})
    going = simulation(what)
    start = momentum(going)
    run = going.advance(41)
    pushed = -1j * what.operation.radial_load * 41e-5  # steps go on up to the next sample
    assert np.count_nonzero(np.abs(run.cage.force).max(axis=0) > 1.0) > 2 and touch(run, guide)
    assert abs(momentum(going) - start - pushed) < 1e-11 * abs(pushed)


def test_angular_momentum_of_a_free_cage_and_elements_is_conserved():
    """Frictionless, without drag, weight or load, the hub out of reach: pockets alone turn cage and elements."""
    nothing = {"gravity": 0.0, "radial_load": 0.0}
    what = problem("rollers", operation=nothing, drag_torque_N_m=0.0, friction_coefficient=0.0)
    what = replace(what, bearing=replace(what.bearing, outer_raceway_radius=0.029))
    going = simulation(what)
    bodies = going.state.bodies
    centre, velocity, motion = bodies.centre[:, :8], bodies.velocity[:, :8], bodies.cage.cage.motion
    velocity += 0.5 * np.array([np.cos(2.5 * np.arange(8)), np.sin(2.5 * np.arange(8))])  # m/s, this way and that

    def turning():
        rollers = bodies.mass * np.sum(centre[0] * velocity[1] - centre[1] * velocity[0])
        cage = what.cage.mass * (motion[0, 0] * motion[1, 1] - motion[0, 1] * motion[1, 0])
        return rollers + cage + what.cage.inertia * motion[1, 2]

    before = turning()
    run = going.advance(41)
    assert np.abs(run.cage.force).max() > 10.0 and not run.inner_force.any() and not run.outer_force.any()
    assert turning() == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("guide", GUIDES)
@pytest.mark.parametrize("mounting", [HELD, Mounting(housing=Housing(mass=0.5, stiffness=2e8, damping=4000.0))])
def test_the_energy_balances(guide, mounting):
    run = compiled(replace(problem(guide, mounting), start="equilibrium"), 61)
    moved = np.ptp(run.energy_moved) + run.energy_contact.max()
    for name in ("dashpots", "friction", "drag"):
        assert getattr(run.cage, f"work_{name}")[-1] > 1e-7 * moved
    assert np.abs(run.energy_error).max() < 1e-4 * moved


@pytest.mark.parametrize("guide", GUIDES)
def test_a_housing_that_hardly_moves_is_the_ground(guide):
    """Its places go with 1/mass; those of hub and cage, seen from it, as well. A large weight makes the cage fall."""
    free, off = {"gravity": 2000.0}, []
    ground = compiled(problem(guide, operation=free), 21)
    assert touch(ground, guide)
    for mass in (1e7, 1e8):
        held = Mounting(housing=Housing(mass=mass, stiffness=mass * 1e6, damping=0.0))
        run = compiled(problem(guide, held, operation=free), 21)
        hub, cage = run.inner_y - run.housing_y - ground.inner_y, run.cage.y - run.housing_y - ground.cage.y
        off.append(max(np.abs(hub).max(), np.abs(cage).max()))
    assert 5.0 < off[0] / off[1] < 20.0 and off[1] < 1e-9
