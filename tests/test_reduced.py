"""The reduced model against exact statics, linear modes, balances of energy and momentum, and what it refuses."""

import dataclasses
import tomllib

import numpy as np
import pytest
from scipy.linalg import eigh

from fem.elastic.continuum import ring_sections, roller_section, stick_approach
from fem.errors import UsageError
from fem.kernels.rigid.state import INNER, OUTER
from fem.solver.rigid.reduced import ReducedPlan
from fem.solver.rigid.state import slowest_vibration
from fem.solver.simulate import make_plan
from fem.statics.exact_statics import exact_contacts, exact_statics
from fem.statics.reduced_bearing import tangential_compliance
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import parse_scene, read_scene
from tests.reference.free_vibration import disc_frequency
from tests.reference.reduced_runs import CLEARANCE, STILL, plan_of, samples_of
from tests.reference.whole_run import whole_run

PRELOAD = ("bearing.outer_raceway_diameter_mm=55.99", "operation.radial_load_N=0", "operation.gravity_m_s2=0")


def frequency(time, values, near: float) -> float:
    """Of a vibration, Hz, near a known one: how far its phase runs ahead from the record's first half to its second."""
    half = len(time) // 2
    turned = values * np.exp(-2j * np.pi * near * time)
    first, second = (np.sum(np.hanning(half) * part) for part in (turned[:half], turned[half : 2 * half]))
    return near + np.angle(second / first) / (2.0 * np.pi * (time[half] - time[0]))


@pytest.mark.parametrize("settings", [(), ("bearing.rollers=8", "operation.first_roller_deg=11"), CLEARANCE, (
    "bearing.rollers=17", "bearing.roller_diameter_mm=6", "bearing.outer_raceway_diameter_mm=48",
    "material.roller.youngs_modulus_GPa=300", "operation.radial_load_N=700",
)])  # fmt: skip
def test_a_standing_bearing_is_the_exact_series(settings):
    more = "operation.gravity_m_s2=0", "numerics.output_interval_us=2"
    scene = read_scene(None, ("model=reduced", *settings, *STILL, *more))
    plan = make_plan(scene)
    operation = plan.operation
    exact = exact_statics(scene.ideal_bearing(), operation.radial_load, operation.first_roller_angle)
    np.testing.assert_allclose(plan.start.hub, exact.hub, rtol=0.0, atol=1e-9 * np.abs(exact.hub).max())
    np.testing.assert_allclose(plan.start.inner_force, exact.inner_force, rtol=0.0, atol=1e-7 * operation.radial_load)
    found = samples_of(plan, count=3)
    # an equilibrium stays one, until rollers without friction set off along the raceways
    assert np.abs(found["inner_y"] - exact.hub[1]).max() < 1e-6 * abs(exact.hub[1])
    assert np.abs(found["inner_force"] - exact.inner_force).max() < 1e-5 * operation.radial_load


def modes(plan) -> np.ndarray:
    """Natural frequencies, Hz, of hub and rollers in the plane, frictionless, by dense matrices of the series."""
    bearing, start = plan.model.bearing, plan.start
    n, m = bearing.n_rollers, bearing.roller_mass
    contacts = exact_contacts(bearing, roller_angles(bearing, plan.operation.first_roller_angle))
    closed = np.flatnonzero(np.concatenate([start.inner_force, start.outer_force]) > 0.0)
    force = np.concatenate([start.inner_force, start.outer_force])
    soft = contacts.compliance.copy()
    for c in range(2 * n):
        law = contacts.inner_law if c < n else contacts.outer_law
        soft[c, c] += law.softness(max(force[c], 1e-3))
    centre = start.rho[:, None] * np.column_stack([np.cos(start.angle), np.sin(start.angle)])
    inner = (centre - start.hub) / np.linalg.norm(centre - start.hub, axis=1)[:, None]
    outer = centre / start.rho[:, None]
    rise = np.zeros((2 * n, 2 + 2 * n))  # of overlaps by hub and rollers
    for j in range(n):
        rise[j, :2], rise[j, 2 + 2 * j : 4 + 2 * j] = inner[j], -inner[j]
        rise[n + j, 2 + 2 * j : 4 + 2 * j] = outer[j]
    stiff = rise[closed].T @ np.linalg.solve(soft[np.ix_(closed, closed)], rise[closed])
    for j in range(n):  # forces turn with their normals
        own, hub = slice(2 + 2 * j, 4 + 2 * j), slice(0, 2)
        turn = (np.eye(2) - np.outer(inner[j], inner[j])) * start.inner_force[j] / np.linalg.norm(centre[j] - start.hub)
        for a, b, sign in ((own, own, -1.0), (hub, hub, -1.0), (own, hub, 1.0), (hub, own, 1.0)):
            stiff[a, b] += sign * turn
        stiff[own, own] += (np.eye(2) - np.outer(outer[j], outer[j])) * start.outer_force[j] / start.rho[j]
    mass = np.diag([plan.operation.inner_mass] * 2 + [m] * (2 * n))
    values = eigh(stiff, mass, eigvals_only=True)
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)


def test_the_hub_vibrates_as_the_exact_compliances_say_and_steps_err_in_fourth_order():
    settings = (*PRELOAD, *STILL, "numerics.output_interval_us=10")
    errors = []
    for stride in (2, 4):
        plan = plan_of(*settings, stride=stride)

        def push(state):
            state.bodies.hub_velocity[:] = 0.0, 1e-6  # a tenth of a nanometre

        found = samples_of(plan, push, count=4000)
        known = modes(plan)
        # the preloaded bearing's hub moves alike in x and y: its frequency is the lowest but rigid motions'
        wanted = known[known > 1e3][0]
        errors.append(frequency(found["time"], found["inner_y"] - plan.start.hub[1], wanted) / wanted - 1.0)
    turn = (2.0 * np.pi * wanted * 5e-6) ** 2
    assert abs(errors[0]) < turn**2 / 480.0  # Numerov's; leapfrog alone errs by turn/24, fifty times that
    assert abs(errors[1]) < abs(errors[0]) / 8.0


def test_a_roller_that_sticks_rocks_on_its_tangential_compliances():
    """Spin and travel along the raceway: M v̇ = −S T, T = k·slip path; preloaded, standing, the hub heavy."""
    plan = plan_of(
        *PRELOAD,
        "operation.speed_rpm=0",
        "operation.inner_ring_and_shaft_kg=1000",
        "contact.friction_coefficient=1",
        "numerics.output_interval_us=2",
    )
    bearing, soft = plan.model.bearing, plan.tangential[:2]
    m, r = bearing.roller_mass, bearing.roller_radius

    def spin(state):
        state.bodies.spin[3] = 1e-6 / r

    found = samples_of(dataclasses.replace(plan, stride=4), spin, count=400)
    slips = np.array([[1.0, -r], [1.0, r]])  # of the inner and outer contact by travel and spin
    stiff = slips.T @ np.diag(1.0 / soft) @ slips
    wanted = np.sqrt(eigh(stiff, np.diag([m, 0.5 * m * r * r]), eigvals_only=True)) / (2.0 * np.pi)
    spins = found["roller_spin"][:, 3]
    spectrum = np.abs(np.fft.rfft((spins - spins.mean()) * np.hanning(400), 40_000))
    at = np.fft.rfftfreq(40_000, found["time"][1])
    # Carter's creep gives way as well, at full slip of 1e-4 m/s and more: it damps but hardly moves the frequency
    assert at[np.argmax(spectrum)] == pytest.approx(wanted[1], rel=0.02)


@pytest.mark.parametrize(
    ("settings", "limit"),
    [((), 1e-6), (("contact.friction_coefficient=0",), 1e-6), (("numerics.start=rest",), 1e-5), (CLEARANCE, 5e-4),
     (("numerics.start=rest", "numerics.load_ramp_ms=0.05"), 5e-4)],
)  # fmt: skip
def test_energy_balances(settings, limit):
    found = samples_of(plan_of(*settings, "numerics.duration_ms=20"))
    assert np.abs(found["imbalance"]).max() < limit * found["exchanged"][-1]


def test_rollers_that_nothing_loads_press_outwards_with_their_centrifugal_force_from_the_first_step():
    plan = plan_of(*CLEARANCE, *(PRELOAD[1:]), "operation.speed_rpm=20000", "numerics.duration_ms=1")
    bearing, cage = plan.model.bearing, plan.start.kinematics.cage
    force = samples_of(plan)["outer_force"]
    np.testing.assert_allclose(force, bearing.roller_mass * cage**2 * plan.start.rho.mean(), rtol=1e-3)


def test_forces_of_the_samples_are_the_hubs_and_rollers_accelerations():
    plan = plan_of("numerics.duration_ms=5", "numerics.output_interval_us=2")
    found = samples_of(plan)
    bearing, operation = plan.model.bearing, plan.operation
    x, y = found["roller_x"] - found["inner_x"][:, None], found["roller_y"] - found["inner_y"][:, None]
    nx, ny = x / np.hypot(x, y), y / np.hypot(x, y)
    push, along = found["inner_force"], found["inner_traction"]
    on_hub = -np.sum(push * nx - along * ny, axis=1), -np.sum(push * ny + along * nx, axis=1)
    down = operation.radial_load + operation.inner_mass * operation.gravity
    # samples have forces, kicks those of the energy balance beside: of second order in the step
    assert np.abs(operation.inner_mass * found["inner_ax"] - on_hub[0])[1:].max() < 1e-4 * down
    assert np.abs(operation.inner_mass * found["inner_ay"] - on_hub[1] + down)[1:].max() < 1e-4 * down
    ox, oy = found["roller_x"] / found["roller_rho"], found["roller_y"] / found["roller_rho"]
    force = push * ny + along * nx - found["outer_force"] * oy + found["outer_traction"] * ox
    speed = np.gradient(found["roller_y"], found["time"], axis=0)
    acceleration = np.gradient(speed, found["time"], axis=0)
    loaded = bearing.roller_mass * (acceleration + operation.gravity)
    assert np.abs(loaded - force)[3:-3].max() < 0.005 * push.max()


def test_places_of_the_samples_are_those_that_their_forces_belong_to():
    """What the laws and all compliances make of the forces is how far the bodies overlap, the hub vibrating by 2 µm."""
    plan = plan_of(*PRELOAD, *STILL, "numerics.output_interval_us=2")
    given = plan.first_state().contacts

    def push(state):
        state.bodies.hub_velocity[:] = 0.0, 0.1

    found = samples_of(plan, push, count=200)
    inner, outer = found["inner_force"], found["outer_force"]
    away = np.hypot(*(found[f"roller_{axis}"] - found[f"inner_{axis}"][:, None] for axis in "xy"))
    for law, Q, other, row, overlap in (
        (given.inner, inner, outer, INNER, given.reach - away),
        (given.outer, outer, inner, OUTER, found["roller_rho"] - given.track),
    ):
        assert 0.0 < Q.min() < 0.9 * Q.max() < 0.9 * law.Q_line
        coupling = given.coupling
        neighbours = zip(coupling.along[row, :, 0], coupling.distance, strict=True)
        felt = coupling.across * other + sum(along * np.roll(Q, -distance, axis=1) for along, distance in neighbours)
        missed = overlap - felt - law.A * Q * (law.B - 0.5 * np.log(Q))
        assert np.abs(missed).max() < 3e-4 * np.ptp(overlap)  # a hundredth by places of leapfrog's own


def test_tractions_stay_below_coulombs_limit_and_rollers_roll():
    plan = plan_of("numerics.duration_ms=20")
    found = samples_of(plan)
    for row in ("inner", "outer"):
        assert np.all(np.abs(found[f"{row}_traction"]) <= 0.1 * found[f"{row}_force"] * (1.0 + 1e-9))
    cage = np.polyfit(found["time"], found["roller_theta"].mean(axis=1), 1)[0]
    # creep of a bearing that transmits no torque: parts in ten thousand (kinematics are of undeformed circles)
    assert cage == pytest.approx(plan.start.kinematics.cage, rel=3e-3)
    assert np.all(np.diff(found["work_dissipated"]) > -1e-9)


def test_the_other_way_round_is_the_mirror_image():
    one, other = (
        samples_of(plan_of(f"operation.speed_rpm={speed}", "numerics.duration_ms=3")) for speed in ("4500", "-4500")
    )
    np.testing.assert_allclose(other["inner_y"], one["inner_y"], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(other["inner_x"], -one["inner_x"], rtol=0.0, atol=1e-12)


def test_rollers_that_meet_exchange_their_momentum():
    """Two rollers in clearance, without load, sent against each other: equal masses swap velocities."""
    plan = plan_of(*PRELOAD[1:], *STILL, "bearing.outer_raceway_diameter_mm=56.2", "bearing.rollers=13",
                   "numerics.start=rest", "bearing.roller_diameter_mm=10")  # fmt: skip
    bearing = plan.model.bearing
    rho, r = bearing.pitch_radius, bearing.roller_radius

    def send(state):
        before = plan.start.angle[1] - 2.0 * np.arcsin((r + 0.5e-6) / rho)
        state.bodies.centre[:, 0] = rho * np.cos(before), rho * np.sin(before)
        way = state.bodies.centre[:, 1] - state.bodies.centre[:, 0]
        state.bodies.velocity[:, 0] = 0.2 * way / np.linalg.norm(way)

    found = samples_of(dataclasses.replace(plan, stride=10), send, count=8)
    spacing = np.hypot(
        found["roller_x"][:, 1] - found["roller_x"][:, 0], found["roller_y"][:, 1] - found["roller_y"][:, 0]
    )
    assert found["roller_roller_force"][:, 0].max() > 1.0 and spacing[-1] > 2.0 * r
    speed = np.hypot(np.diff(found["roller_x"], axis=0), np.diff(found["roller_y"], axis=0)) / found["time"][1]
    assert speed[-1, 1] == pytest.approx(0.2, rel=1e-3) and speed[-1, 0] < 1e-3
    assert np.abs(found["imbalance"]).max() < 1e-3 * found["exchanged"][-1]  # as `fem.solver.rigid.state.LIMIT`


@pytest.mark.parametrize(("setting", "word"), [
    ("bodies.inner_ring=rigid", 'bodies.inner_ring = "rigid"'),
    ("contact.model=resolved numerics.mesh_size_mm=0.03", 'contact.model = "resolved"'),
    ("bearing.type=ball", 'bearing.type = "ball"'),
    ("operation.radial_load_N=2e6", "beyond Hertz's theory"),
    ("operation.speed_rpm=200000 material.youngs_modulus_GPa=20", "centrifugal load"),
])  # fmt: skip
def test_what_it_cannot_do_is_refused_by_name(setting, word):
    with pytest.raises(UsageError, match=word):
        plan_of(*setting.split())


def scene_with(tables: str, **numerics) -> ReducedPlan:
    data, numerics = tomllib.loads(tables), {"output_interval_us": 10.0} | numerics
    return make_plan(parse_scene(data | {"model": "reduced", "numerics": numerics}, "scene"))


@pytest.mark.parametrize(("tables", "limit"), [
    ('[[waviness]]\nbody = "inner_ring"\norder = 12\namplitude_um = 0.5', 1e-5),
    pytest.param('[[waviness]]\nbody = "outer_ring"\norder = 7\namplitude_um = 0.5', 1e-5, marks=pytest.mark.slow),
    pytest.param('[[waviness]]\nbody = "roller"\nroller = 3\norder = 6\namplitude_um = 0.5', 1e-5,
                 marks=pytest.mark.slow),
    pytest.param("[[unequal_roller]]\nroller = 1\ndiameter_deviation_um = 2.0", 1e-5, marks=pytest.mark.slow),
    ('[[spall]]\nbody = "outer_ring"\nangle_deg = 4.0\nwidth_mm = 1.0\ndepth_um = 100.0', 1e-3),
])  # fmt: skip
def test_energy_balances_on_surfaces_that_are_not_perfect(tables, limit):
    """Slopes of surfaces push rollers, turn them and load the drive: all of it is in the balance, or none fits."""
    found = samples_of(scene_with(tables, duration_ms=6.0))
    assert np.abs(found["imbalance"]).max() < limit * found["exchanged"][-1]
    perfect = samples_of(plan_of("numerics.duration_ms=6"))
    assert np.abs(found["inner_y"] - perfect["inner_y"]).max() > 1e-8  # and they do something


@pytest.mark.slow  # a time loop of its own to compile
def test_a_wave_of_the_inner_ring_moves_a_preloaded_hub_as_in_finite_elements():
    tables = (
        '[bearing]\nouter_raceway_diameter_mm = 55.98\n[operation]\nradial_load_N = 0.0\ngravity_m_s2 = 0.0\n'
        '[[waviness]]\nbody = "inner_ring"\norder = 12\namplitude_um = 0.5'
    )  # fmt: skip
    found = []
    for model in ("fem", "reduced"):
        data = tomllib.loads(tables) | {"model": model, "numerics": {"duration_ms": 3.0, "mesh_size_mm": 2.0}}
        found.append(whole_run(make_plan(parse_scene(data, "scene")))["inner_x"])
    assert found[0].max() == pytest.approx(0.5e-6, rel=0.1)  # the wave's amplitude, for a rigid hub and many rollers
    assert np.abs(found[1] - found[0]).max() < 0.01 * found[0].max()


def test_soft_rings_hang_by_their_weight_as_in_finite_elements():
    """What a ring's weight leaves of a preloaded hub's place: half a per cent of these 42 nm, left out."""
    soft = [f"material.{body}.youngs_modulus_GPa=3" for body in ("inner_ring", "outer_ring", "roller")]
    settings = (*soft, *STILL, "bearing.clearance_um=-40", "operation.radial_load_N=0")
    hub, found = make_plan(read_scene(None, settings)).start.equilibrium.hub, plan_of(*settings).start.hub
    assert -45e-9 < hub[1] < -40e-9
    assert found[1] == pytest.approx(hub[1], rel=5e-4)


@pytest.mark.parametrize("force", [10.0, 1e3, 1e4])
def test_tangential_compliance_goes_with_the_half_widths_logarithm(force):
    """Against the series of rings and rollers for the half-width itself."""
    bearing = read_scene(None, ()).ideal_bearing()
    found, pairs = tangential_compliance(bearing, force), contact_pairs(bearing)
    widths = [pair.half_width(force) for pair in pairs]
    rollers = [stick_approach(roller_section(bearing), width) for width in widths]
    others = [stick_approach(ring, width) for ring, width in zip(ring_sections(bearing), widths[:2], strict=True)]
    wanted = np.add(rollers, [*others, rollers[2]]) / bearing.roller_length
    np.testing.assert_allclose(found, wanted, rtol=1e-3)


def test_the_slowest_vibration_is_a_rollers_ovalling():
    """Love's frequency equation of a free disc, two waves around, in plane strain."""
    bearing = plan_of().model.bearing
    root = disc_frequency(2, 2.2, 2.5, bearing.roller)  # ω R/c_T
    exact = 2.0 * np.pi * bearing.roller_radius / (root * np.sqrt(bearing.roller.lame_mu / bearing.roller.density))
    assert slowest_vibration(bearing) == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("damage", ["centre", "turn"])
def test_a_state_that_kernels_cannot_take_is_refused(damage):
    plan = scene_with('[[waviness]]\nbody = "roller"\nroller = 3\norder = 6\namplitude_um = 0.5', duration_ms=1.0)
    arrays, numbers = plan.first_state().to_keep()
    arrays = {name: array.copy() for name, array in arrays.items()}
    arrays[f"bodies.{damage}"][..., 3] = 0.0 if damage == "centre" else 1e300
    with pytest.raises(ValueError, match="outside the bearing"):
        plan.first_state().take_back(arrays, numbers)


def test_rows_of_contacts_are_those_of_the_samples():
    assert (INNER, OUTER) == (0, 1)


def test_loads_and_hub_of_a_running_bearing_are_those_of_finite_elements():
    """Two independent discretisations, of other equations: series without mass, and meshes with it (2 mm: 0.2 %)."""
    found = []
    for model in ("fem", "reduced"):
        plan = make_plan(read_scene(None, (f"model={model}", "numerics.mesh_size_mm=2", "numerics.duration_ms=4")))
        found.append(whole_run(plan))
    fine, reduced = found
    assert np.abs(reduced["inner_y"] - fine["inner_y"]).max() < 3e-3 * np.abs(fine["inner_y"]).max()
    assert np.abs(reduced["inner_force"] - fine["inner_force"]).max() < 5e-3 * fine["inner_force"].max()
    np.testing.assert_allclose(reduced["roller_theta"], fine["roller_theta"], rtol=0.0, atol=1e-5)
    assert np.abs(reduced["roller_spin"] / fine["roller_spin"] - 1.0).max() < 1e-4


def test_an_estimate_of_its_error_runs_finite_elements_beside_it():
    plan = plan_of("numerics.duration_ms=2", "numerics.mesh_size_mm=2")
    estimate = plan.error_estimate()
    assert "finite elements of 2 mm" in estimate.title
    found = {each.quantity.name: each for each in estimate.find(whole_run(plan).values)}
    assert found["hub_mean_y"].relative < 3e-3 and found["largest_force"].relative < 3e-3
    assert found["cage_speed"].relative < 1e-4
    with pytest.raises(UsageError, match="exact series itself"):
        plan_of("numerics.duration_ms=0").error_estimate()


THIN = """
[bearing]
rollers = 4
roller_diameter_mm = 3.1423
roller_length_mm = 3.857
inner_raceway_diameter_mm = 4.2146
outer_raceway_diameter_mm = 10.6093
bore_diameter_mm = 2.9746
outside_diameter_mm = 15.05
[operation]
speed_rpm = 19000
radial_load_N = 1100
inner_ring_and_shaft_kg = 2e-3
shaft = "springs"
shaft_stiffness_N_per_m = 1.5e7
[material.roller]
youngs_modulus_GPa = 3.6
[material.inner_ring]
youngs_modulus_GPa = 3.6
[numerics]
mesh_size_mm = 0.5
"""


def test_contacts_beyond_the_range_of_their_law_do_not_decide_on_the_step():
    """Under ten times the largest static force the law's two contacts of a roller would push one another in."""
    plan = make_plan(parse_scene(tomllib.loads(THIN) | {"model": "reduced"}, "thin"))
    rocking = 4.0 / float(plan.tangential.min()) / plan.model.bearing.roller_mass
    shaft = plan.operation.mounting.shaft.stiffness / plan.operation.inner_mass
    assert 0.1 < plan.critical_time_step * 0.5 * np.sqrt(max(rocking, shaft)) < 1.0
