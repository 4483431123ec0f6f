"""Speed and load that change, in every model, and the interval between samples: energy, budget, orbits, orders."""

import re
from dataclasses import replace
from itertools import pairwise

import h5py
import numpy as np
import pytest
from scipy.integrate import quad

from fem.commands.run_fem import run_main
from fem.interface import simulate as run_model
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads, balance
from fem.statics.exact_statics import exact_contacts
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.load_history import joined
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene, SceneError, parse_scene_text, read_scene
from lagrange.step_size import SAMPLES_OF_ROLLERS, SAMPLES_OF_THE_HUB, hub_frequency, roller_frequency
from residual.check_vibration import main as vibration_main
from residual.cli import main as check_main
from residual.evaluation import evaluate
from residual.sources import read_result
from tests.reference import compiled, kit
from tests.reference.forward_motion import simulate
from tests.reference.kit import LOADS, RAMP, budget_terms, record_of, scene_with, sets

TURNING = ("operation.unbalance_g_mm=50", "operation.unbalance_deg=20", "operation.rotating_load_N=100")
RUN_UP = "numerics.duration_ms=8"  # over all of RAMP and LOADS
MODELS = ("lagrange", "reduced", "fem")


def changing(folder, *settings, **more):
    return scene_with(folder, *TURNING, RUN_UP, *settings, **{"speeds": RAMP, "loads": LOADS} | more)


def problem(scene, **choices):
    bearing = scene.ideal_bearing()
    return Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing), **choices)


def solved(scene, duration, **choices):
    """A Lagrangian run of the reference, a sample each 20 µs."""
    return simulate(problem(scene, **choices), duration, 2e-5)


@pytest.mark.parametrize("seed", range(5))
def test_a_smooth_function_goes_through_its_points_and_nowhere_beyond_them(seed):
    random = np.random.default_rng(seed)
    time = np.cumsum(random.uniform(0.1, 1.0, 12))
    values = np.round(random.uniform(-3.0, 3.0, (12, 1)))  # with equal neighbours among them
    found = joined(time, values, "smooth")
    np.testing.assert_allclose(found(time), values, atol=1e-12)
    for (a, p), (b, q) in pairwise(zip(time, values[:, 0], strict=True)):
        between = found(np.linspace(a, b, 101))[:, 0]
        assert np.all(np.diff(between) * np.sign(q - p) >= -1e-12)
        np.testing.assert_allclose(between, np.clip(between, min(p, q), max(p, q)), atol=1e-12)
    for order in (1, 2):  # continuous at the points
        before, after = found(time[1:-1] - 1e-11, order), found(time[1:-1] + 1e-11, order)
        np.testing.assert_allclose(before, after, atol=1e-4)
    line = 2.0 - 3.0 * time
    np.testing.assert_allclose(joined(time, line[:, None], "smooth")(time + 0.01)[:-1, 0], line[:-1] - 0.03, atol=1e-12)


def test_the_shaft_turns_by_the_integral_of_its_speed_and_an_unbalance_is_an_accelerated_mass(tmp_path, capsys):
    scene = scene_with(tmp_path, RUN_UP, speeds=RAMP)
    operation, bearing = scene.ideal_operation(), scene.ideal_bearing()
    assert operation.speed == pytest.approx(1000 * RPM)
    assert operation.history.speeds == pytest.approx((1000 * RPM, 6000 * RPM))
    expected = sum(quad(operation.history.speed, a, b)[0] for a, b in ((0.0, 2e-3), (2e-3, 6e-3), (6e-3, 7e-3)))
    way = turned(bearing, operation, 7e-3)
    assert way.shaft == pytest.approx(expected, rel=1e-10)
    assert way.cage / way.shaft == pytest.approx(9 / 23, rel=1e-12)  # 0.3913
    assert run_main([str(tmp_path / "scene.toml"), "--model", "lagrange", "--duration", "8", "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "1000 to 6000 rpm" in out and "frequencies at 1000 rpm" in out and "BPFO 508.7 Hz" in out
    history = changing(tmp_path).ideal_operation().history
    h, times = 2e-6, np.array([0.5e-3, 3e-3, 5.1e-3])

    def moment(time):  # mass times place, 50 g mm, 20° from −y
        return 50e-6 * np.exp(1j * (history.turn(time) + np.radians(20.0 - 90.0)))

    acceleration = (moment(times + h) - 2.0 * moment(times) + moment(times - h)) / h**2
    x, y = replace(history, rotating_load=0.0).force(times)
    load_x, load_y = np.moveaxis(history.load(times), -1, 0)
    np.testing.assert_allclose(x - load_x + 1j * (y - load_y), -acceleration, rtol=1e-4)
    np.testing.assert_allclose(history.load(4e-3), (500.0, -2500.0), rtol=1e-12)  # a point of the table


STEP = "time_ms,x_N,y_N\n0,0,-1000\n1,400,-2000\n3,400,-2000\n"
HUB = 5.0  # kg, on springs alone
SPRINGS = (
    "operation.shaft=springs", "operation.shaft_stiffness_N_per_m=2e7", f"operation.inner_ring_and_shaft_kg={HUB}",
    "operation.gravity_m_s2=0", "numerics.duration_ms=3", "numerics.output_interval_us=10",
)  # fmt: skip


def cases(*rows, quick):
    return [row if row[:2] in quick else pytest.param(*row, marks=pytest.mark.slow) for row in rows]


@pytest.mark.parametrize(("model", "shape", "error"), cases(
    ("lagrange", "steps", 2e-3), ("lagrange", "linear", 2e-6), ("reduced", "steps", 4e-3), ("reduced", "linear", 5e-6),
    ("fem", "steps", 4e-4), ("fem", "linear", 1e-6), quick=[("lagrange", "linear")],
))  # fmt: skip
def test_a_hub_on_springs_answers_steps_and_ramps_as_an_oscillator(tmp_path, model, shape, error):
    """1 − cos ωt, t − sin ωt/ω; a step acts within half a time step of its time, ω Δt/2 = 10⁻³."""
    settings = ("bearing.clearance_um=900", f"model={model}", f"operation.load_table_shape={shape}")
    found = run_model(scene_with(tmp_path, *SPRINGS, *settings, loads=STEP))
    time, stiffness = found["time"], 2e7
    omega, later = np.sqrt(stiffness / HUB), np.clip(time - 1e-3, 0.0, None)
    if shape == "steps":
        share = 1.0 - np.cos(omega * later)
    else:
        share = (time - np.sin(omega * time) / omega - later + np.sin(omega * later) / omega) / 1e-3
    unit = 1000.0 / stiffness
    np.testing.assert_allclose(found["inner_y"], -unit - unit * share, atol=error * unit)
    np.testing.assert_allclose(found["inner_x"], 0.4 * unit * share, atol=error * unit)


@pytest.mark.parametrize(("model", "shape", "error"), cases(
    ("lagrange", "steps", 5e-5), ("lagrange", "linear", 1e-6), ("reduced", "steps", 1e-4), ("fem", "steps", 1e-6),
    quick=[("lagrange", "steps"), ("lagrange", "linear")],
))  # fmt: skip
def test_steps_and_ramps_keep_the_account_of_energy(tmp_path, model, shape, error):
    settings = (f"model={model}", f"operation.load_table_shape={shape}", "operation.inner_ring_and_shaft_kg=0.5")
    found = run_model(scene_with(tmp_path, *SPRINGS, *settings, loads=STEP))
    stored = sum(found[f"energy_{kind}"] for kind in ("kinetic", "elastic", "contact", "shaft"))
    left = stored + found["work_dissipated"] - found["work_external"]
    assert np.ptp(found["work_external"]) > 2e-3
    np.testing.assert_allclose(left, left[0], atol=error * np.ptp(found["work_external"]))


# Tables: how they may be written, and what is refused
def test_tables_have_shapes_and_units(tmp_path):
    history = scene_with(tmp_path, "operation.speed_table_shape=linear", RUN_UP, speeds=RAMP).ideal_operation().history
    np.testing.assert_allclose(history.speed(np.array([1e-3, 4e-3, 7e-3])) / RPM, [1250.0, 3250.0, 5500.0])
    assert history.turn(8e-3) == pytest.approx(RPM * 1e-3 * (2 * 1250 + 4 * 3250 + 2 * 5500))
    shape = ("operation.load_table_shape=steps", "numerics.duration_ms=3")
    held = scene_with(tmp_path, *shape, loads=STEP).ideal_operation()
    np.testing.assert_array_equal(held.history.load([0.0, 0.999e-3, 1e-3, 2.9e-3])[:, 1], [-1e3, -1e3, -2e3, -2e3])
    assert held.radial_load == 1000.0 and held.heaviest == pytest.approx(np.hypot(400.0, 2000.0))
    with pytest.raises(SceneError, match="speed_table_shape = 'steps': must be 'smooth' or 'linear'"):
        scene_with(tmp_path, "operation.speed_table_shape=steps", speeds=RAMP)
    with pytest.raises(SceneError, match=r"load_table_shape: give load_table too"):
        scene_with(tmp_path, shape[0])
    rows = [[0.0, 0.0, -2000.0], [2.0, 500.0, -1500.0], [10.0, -300.0, -2000.0]]
    for header, between, time, force in (
        ("time_s;x_kN;y_kN", ";", 1e-3, 1e-3), ("time [s];x [kN];y [kN]", ";", 1e-3, 1e-3),
        ("time [ms];x [N];y [N]", ";", 1.0, 1.0), ("time(s)\tx(N)\ty(N)", "\t", 1e-3, 1.0),
    ):  # fmt: skip
        cells = [[f"{t * time:.9g}", f"{x * force:.9g}", f"{y * force:.9g}"] for t, x, y in rows]
        text = "\n".join([header, *(between.join(row) for row in cells)])
        own = scene_with(tmp_path, RUN_UP, loads=text).operation.read("load_table")
        np.testing.assert_allclose(np.column_stack(own), rows, rtol=1e-12, err_msg=header)
    for unit, factor in (("_1/min", 1.0), (" [rpm]", 1.0), ("_rad_s", RPM), (" [rad/s]", RPM)):
        text = f"time_ms,speed{unit}\n0,{1500.0 * factor:.12g}\n60,{3000.0 * factor:.12g}\n"
        scene = scene_with(tmp_path, speeds=text)
        assert scene.operation.speed_rpm == pytest.approx(1500.0, rel=1e-11), unit
        assert scene.ideal_operation().history.speeds[1] == pytest.approx(3000.0 * RPM, rel=1e-11), unit


def test_decimal_commas_have_a_key_beside_each_table(tmp_path):
    speeds, loads = (text.replace(",", ";").replace("1000", "1000,5") for text in (RAMP, LOADS + "12,1,-1000\n"))
    commas = ('operation.speed_table_decimal=","', 'operation.load_table_decimal=","')
    scene = scene_with(tmp_path, *commas, RUN_UP, speeds=speeds, loads=loads)
    assert scene.operation.speed_rpm == 1000.5
    load = scene.ideal_operation().history.load
    assert load.c.shape[1] == 4
    np.testing.assert_allclose(load(12e-3), (1.0, -1000.5))
    assert parse_scene_text(scene.to_toml(), "again", scene.files) == scene
    with pytest.raises(SceneError, match=r"load_table_decimal: give load_table too"):
        scene_with(tmp_path, commas[1])
    with pytest.raises(SceneError, match=r"speed_rpm = '1\.500' is no number; with decimal = \",\" no point may stand"):
        scene_with(tmp_path, commas[0], speeds="time_ms;speed_rpm\n0;1.500\n60;2")
    with pytest.raises(SceneError, match="but commas are between its columns, too"):
        scene_with(tmp_path, commas[0], speeds=RAMP)


BAD = {
    "time_ms,speed_rpm\n0,1000\n5,2000\n5,3000\n9,1": "time_ms must rise by at least 0.001 from row to row: after 5",
    "time_ms,speed_rpm\n0,1000\n9,nan": "row 2 holds a value that is not finite",
    "time_ms,speed_rpm\n0,1000\n9,2e6": "speed_rpm = 2e+06 at 9 ms; at most 200000 either way",
    "time_ms,speed_rpm\n0,1000": "it holds 1 rows; at least 2 are needed",
    "time_ms,speed_rpm\n1,1000\n9,2000": "it begins at time_ms = 1, after the run; at most 0",
    "time_ms,speed_rpm\n0,1000\n5,2000": "it ends at time_ms = 5, before the run (numerics.duration_ms = 8)",
    "time_ms,rpm\n0,1000\n9,2000": "column speed_rpm is missing; its first line must name time_ms and speed_rpm",
    "time_ms,speed [m/s]\n0,1\n9,2": "column speed [m/s]: its unit must be one of rpm, 1/min, rad/s, as in speed_rpm",
    "time_ms,time_s,speed_rpm\n0,0,1\n9,9,2": "columns time_ms and time_s say the same thing; leave all but one out",
    "time_ms,speed_rpm\n0,fast\n9,2000": "line 2: speed_rpm = 'fast' is no number",
    "time_ms,speed_rpm\n0,1,500\n9,1,500": "line 2: 3 cells under 2 names; where commas",
    "time_ms;speed_rpm\n0;1,5\n9;2": "speed_rpm = '1,5' is no number; give decimal = \",\" if commas are decimal",
    "time_ms,speed_rpm\n0,1_000\n9,2000": "speed_rpm = '1_000' is no number; write digits 0 to 9",
    "time_ms,speed_rpm\n0,\u0661\n9,2000": "is no number; write digits 0 to 9",
    "time_ms,speed_rpm\nms,rpm\n0,1\n9,2000": "line 2: no numbers in it; a line of units",
    "Logger 7\ntime_ms,speed_rpm\n0,1\n9,2000": "the header comes after 1 other lines; begin those with #",
    "time_ms,speed_rpm\n" + 50_010 * "0,1\n": "more than 50000 rows",
    "#" + 5 * 2**20 * "x": "larger than 4 MiB; is it a table of speeds?",
}


@pytest.mark.parametrize("text", BAD, ids=lambda text: BAD[text][:30])
def test_bad_tables_are_refused_by_name(text, tmp_path):
    with pytest.raises(SceneError) as caught:
        scene_with(tmp_path, RUN_UP, speeds=text)
    (line,) = str(caught.value).splitlines()
    assert 'speed_table = "speed_table.csv": ' in line and BAD[text] in line


@pytest.mark.parametrize(("setting", "told"), [
    ("operation.speed_rpm=3000", "speed_table.csv' is in its place; leave one of them out"),
    ("operation.speed_rpm=1000", "operation.speed_rpm = 1000: operation.speed_table = "),
    ("operation.radial_load_N=0", "operation.radial_load_N = 0: operation.load_table = "),
    ("operation.unbalance_deg=100", "give unbalance_g_mm too"),
    ('contact.model="faceted"', 'operation.speed_table: only with contact.model = "subgrid"'),
    ("operation.load_table_sha256=" + 64 * "0", "another than the scene gives"),
    ("operation.load_table_content=x", "unknown key; loads are read from a file"),
    ("lubricant.viscosity_Pa_s=0.02", "[lubricant]: only at a steady speed, not with operation.speed_table"),
    ("operation.load_table=no.csv", "can't be read: No such file or directory"),
])  # fmt: skip
def test_contradictions_are_refused(setting, told, tmp_path):
    with pytest.raises(SceneError, match=re.escape(told)):
        scene_with(tmp_path, RUN_UP, setting, speeds=RAMP, loads=LOADS)


def test_values_beside_tables_are_refused_and_a_scene_s_text_and_its_files_give_it_back(tmp_path):
    (tmp_path / "speeds.csv").write_text(RAMP, encoding="utf-8")
    for key, told in (("speed_rpm = 3000", "starts at 1000; leave speed_rpm out"), ("speed_rpm = 1000", None)):
        text = f'[operation]\nspeed_table = "speeds.csv"\n{key}\n[numerics]\nduration_ms = 1\n'
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        if told is not None:
            with pytest.raises(SceneError, match=told):
                read_scene(tmp_path / "scene.toml")
    with pytest.raises(SceneError, match=r"speeds\.csv' is in its place"):
        read_scene(tmp_path / "scene.toml").varied({"operation.speed_rpm": 1000.0})
    np.savez(tmp_path / "noise.npz", acc=np.random.default_rng(1).normal(size=5000), rate=10_000.0)
    command = [str(tmp_path / "noise.npz"), "--unit", "g", "--scene", str(tmp_path / "scene.toml"), "--quiet"]
    assert vibration_main(command) == 2
    scene = changing(tmp_path)
    text = scene.to_toml()
    assert parse_scene_text(text, "again", scene.files) == scene
    assert parse_scene_text(text, "shown").operation.speed_rpm == 1000.0
    with pytest.raises(SceneError, match="its text is not here"):
        parse_scene_text(text, "elsewhere", {})


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("tables", [
    {"speeds": "time_ms,speed_rpm\n0,1e-6\n2,1.5e-6\n6,5e-6\n80,6e-6\n"},  # takes years to turn a little
    {"loads": "time_ms,x_N,y_N\n0,0,-2e-317\n2,500,-1e-317\n4,500,-2e-317\n100,-300,-2e-317\n"},
])  # fmt: skip
def test_tables_of_almost_nothing_are_planned(model, tables, tmp_path):
    scene_with(tmp_path, **tables)
    assert run_main([str(tmp_path / "scene.toml"), "--model", model, "--mesh-size", "2", "--dry-run"]) == 0


# The Lagrangian model and its checker under what changes
def test_statics_hold_a_load_of_any_direction_and_the_drive_gives_what_the_bodies_turn_with(tmp_path):
    """The load turned by so many roller pitches turns the answer.

    Without load: ½ J ω² of ring, shaft and rollers, and of the cage's turn, against formulas.
    """
    bearing, operation = kit.PAPER, replace(kit.RUNNING, gravity=0.0)
    pitch, down = 2.0 * np.pi / bearing.n_rollers, static_equilibrium(bearing, operation, kit.HARRIS)
    force = 2000.0 * np.exp(1j * (5 * pitch - 0.5 * np.pi))
    found = static_equilibrium(bearing, replace(operation, side_load=force.real, radial_load=-force.imag), kit.HARRIS)
    assert found.x + 1j * found.y == pytest.approx((down.x + 1j * down.y) * np.exp(5j * pitch), rel=1e-9)
    np.testing.assert_allclose(found.inner_force, np.roll(down.inner_force, 5), atol=1e-6)
    still = ("operation.radial_load_N=0", "operation.gravity_m_s2=0", "bearing.outer_raceway_diameter_mm=55.99")
    scene = scene_with(tmp_path, *still, "numerics.duration_ms=1", speeds="time_ms,speed_rpm\n0,-2000\n1,6000\n")
    run, speed = solved(scene, 1e-3), np.array([-2000.0, 6000.0]) * RPM
    roller, ring = 7850 * np.pi * 5e-3**2 * 0.01, 7850 * np.pi * (18e-3**2 - 12.5e-3**2) * 0.01
    inertia = 0.5 * ring * (12.5e-3**2 + 18e-3**2) + 0.5 * (0.078 - ring) * 12.5e-3**2
    inertia += 13 * 0.5 * roller * 5e-3**2 * (18 / 10) ** 2
    around = 13 * roller * (9 / 22.9975 * run.roller_rho[[0, -1], 0]) ** 2
    expected = 0.5 * np.diff((inertia + around) * speed**2)[0] + np.diff(run.energy_contact[[0, -1]])[0]
    assert run.work_external[-1] == pytest.approx(expected, rel=1e-6)
    angle = run.roller_theta[:, 0]  # it turns back at 0.25 ms
    assert abs(run.time[angle.argmin()] - 0.25e-3) < 2e-5
    assert np.interp(0.5e-3, run.time, angle) == pytest.approx(angle[0], abs=1e-12)


@pytest.mark.parametrize(
    "choices", [{}, {"angles": "free"}, {"damping": ContactDamping(constant=200.0), "start": "rest", "load_ramp": 5e-4}]
)
def test_energy_balances_under_everything_that_changes(choices, tmp_path):
    run = solved(changing(tmp_path), 5e-4, **choices)
    assert np.ptp(run.work_external) > 1e-3  # J
    assert np.abs(run.energy_error).max() < (1e-5 if "damping" in choices else 1e-7) * run.energy_contact.max()


def test_the_checker_knows_every_load_and_turns_forces_at_edges_by_the_spring_alone(tmp_path):
    """The model's own run leaves what differentiation leaves, and the budget adds up."""
    scene = changing(tmp_path, "damping.contact_N_s_m=100")
    found = evaluate(record_of(scene, solved(scene, 1e-3, damping=ContactDamping(constant=100.0))), "harris")
    for terms in budget_terms(found):
        assert np.abs(terms["ring_flexibility"]).max() < 1e-9 * 2000.0  # nothing of the load is missing
        assert np.ptp(found.record.acting.side_load) > 100.0
    spall = {"body": "inner_ring", "width_mm": 0.5, "angle_deg": 10.0}
    scene = Scene(model="lagrange", spall=[spall], damping={"hunt_crossley_s_m": 0.8}, operation={"speed_rpm": 9000.0})
    run = compiled.solved(problem(scene, damping=ContactDamping(hunt_crossley=0.8)), 2e-3, 2e-6)
    dampers = {name: getattr(run, name) for name in ("inner_damping_force", "outer_damping_force")}
    record = replace(record_of(scene, run), **dampers)
    for direction in evaluate(record).directions:
        assert np.abs(direction.budget.terms["ring_flexibility"]).max() < 1e-6  # N, of 2000: what no term explains


def circle(run, speed):
    """Amplitudes, m, of a hub's path that turn with the shaft and against it."""
    time, x, y = (run[name] if isinstance(run, dict) else getattr(run, name) for name in ("time", "inner_x", "inner_y"))
    window = np.sin(np.pi * time / time[-1]) ** 2
    place = (x + 1j * y) * window / window.sum()
    return [np.sum(place * np.exp(sign * 1j * speed * time)) for sign in (-1, 1)]


# Runs of every solver, each of which compiles loops of its own
UNBALANCED = """
bearing.outer_raceway_diameter_mm = 55.98
operation = {{ speed_rpm = {}, inner_ring_and_shaft_kg = {}, unbalance_g_mm = {}, radial_load_N = 0, gravity_m_s2 = 0 }}
numerics = {{ mesh_size_mm = 1, duration_ms = {}, output_interval_us = 20 }}
"""


@pytest.mark.parametrize(("model", "speed", "mass", "unbalance", "shaft", "error"), cases(
    ("lagrange", 40000, 5.0, 20, 0.0, 1e-3), ("lagrange", 40000, 5.0, 20, 2e8, 5e-3),
    ("reduced", 20000, 20.0, 40, 0.0, 5e-3), ("fem", 20000, 20.0, 40, 0.0, 5e-3), quick=[("lagrange", 40000)],
))  # fmt: skip
def test_an_unbalance_drives_a_circle_on_bearing_and_shaft(model, speed, mass, unbalance, shaft, error):
    """F/(k − M ω²), k by statics, of elastic bodies by exact series: without load it is the same in all directions."""
    duration = 2 * 60.0 / speed if model == "lagrange" else 9e-3
    scene = parse_scene_text(f'model = "{model}"' + UNBALANCED.format(speed, mass, unbalance, 1e3 * duration), "")
    if shaft:
        scene = scene.varied({"operation.shaft": "springs", "operation.shaft_stiffness_N_per_m": shaft})
    (bearing, operation), hub = (scene.ideal_bearing(), scene.ideal_operation()), []
    force, inertia = 1e-6 * unbalance * operation.speed**2, mass * operation.speed**2
    if model == "lagrange":
        run, still = compiled.solved(problem(scene), duration, 2e-5), replace(operation, history=None)
        for push in (-force, force):
            hub.append(static_equilibrium(bearing, replace(still, side_load=push), contact_laws("harris", bearing)).x)
    else:
        run = kit.whole_run(make_plan(scene)).values
        contacts = exact_contacts(bearing, roller_angles(bearing, operation.first_roller_angle))
        contacts = replace(contacts, closing=make_plan(scene.varied({"model": "reduced"})).model.contacts.closing)
        for push in (-force, force):
            hub.append(balance(contacts, Loads(0.0, 0.0, operation.speed * 9 / 22.995, push))[0][0])
    stiffness = 2.0 * force / (hub[1] - hub[0])
    assert stiffness > 1.2 * shaft
    assert 0.04 < inertia / stiffness < (0.1 if model == "lagrange" else 0.2)
    ahead, back = circle(run, operation.speed)
    assert abs(ahead) == pytest.approx(force / (stiffness - inertia), rel=error) and abs(back) < error * abs(ahead)
    if model == "lagrange":  # below resonance the heavy side flies out
        assert np.angle(ahead) == pytest.approx(-0.5 * np.pi, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_energy_balances_the_budget_adds_up_and_a_resumed_run_has_the_same_bits(model, tmp_path):
    smooth, keys = "time_ms,speed_rpm\n0,3000\n1,3200\n3,4500\n4,4700\n", ("numerics.mesh_size_mm=2", f"model={model}")
    scene = changing(tmp_path, "numerics.duration_ms=3", "operation.unbalance_g_mm=20", *keys, speeds=smooth)
    path = tmp_path / "run.nc"
    assert run_scene(scene, path, RunOptions(quiet=True)).code == 0
    found = evaluate(read_result(path), "harris")
    with h5py.File(path) as file:
        work, kinetic = file["work_external"][:], file["energy_kinetic"][:]
        stored = kinetic + file["energy_elastic"][:] + file["energy_contact"][:] + file["work_dissipated"][:]
        exchanged = np.maximum(np.abs(kinetic - kinetic[0]).max(), (file["energy_contact"][:]).max())
    assert np.ptp(work) > 1e-3  # J
    assert np.abs(stored - stored[0] - (work - work[0])).max() < 2e-3 * exchanged
    acting = found.record.acting
    for each, load in zip(budget_terms(found), (acting.side_load, acting.radial_load), strict=True):
        assert abs(each["ring_flexibility"] @ load) < 0.01 * (load @ load)  # nothing of the load is missing
    kit.assert_same_bits(*reversed(kit.rest_of_run(make_plan(scene), 37, 50)))


@pytest.mark.slow
@pytest.mark.parametrize("choices", [{}, {"angles": "free"}, {"start": "rest", "load_ramp": 5e-4}])
def test_compiled_steps_make_the_references_motion(choices, tmp_path):
    compiled.assert_right(problem(changing(tmp_path, "operation.unbalance_g_mm=20"), **choices), 61)


@pytest.mark.slow
def test_a_spalled_bearing_running_up_shows_its_lines_in_orders(tmp_path, capsys):
    """From 1000 to 5000 rpm: BPFO 5.087 in the envelope, it and FTF 0.3913 in the path."""
    speeds = "time_ms,speed_rpm\n0,1000\n300,1500\n700,4000\n1000,5000\n"
    more = '[[spall]]\nbody = "outer_ring"\n[[unequal_roller]]\ndiameter_deviation_um = 2.0\n'
    more += "[damping]\ncontact_N_s_m = 200.0"
    settings = "model=lagrange", "numerics.duration_ms=1000", "numerics.output_interval_us=20"
    scene, path = scene_with(tmp_path, *settings, speeds=speeds, more=more), tmp_path / "run.nc"
    assert run_scene(scene, path, RunOptions(quiet=True)).code == 0
    found = evaluate(read_result(path), "harris").y.orders
    assert (found.tracking.lines["BPFO"], found.tracking.lines["FTF"]) == pytest.approx((5.0870, 0.39130), abs=1e-4)
    named = {peak.line: peak.frequency for peak in found.peaks}
    assert (named["BPFO"], named["FTF"]) == pytest.approx((5.0870, 0.39130), abs=2e-3)
    above = (found.envelope.frequency > 3.0) & (found.envelope.frequency < 7.5)
    assert found.envelope.frequency[above][np.argmax(found.envelope.psd[above])] == pytest.approx(5.087, abs=0.03)
    assert vibration_main([str(path), "--quiet"]) == 2 and "needs a run at constant speed" in capsys.readouterr().err
    assert check_main([str(path), "--output", str(tmp_path / "report")]) == 0
    orders = kit.read_json(tmp_path / "report/summary.json")["orders"]
    assert "BPFO" in [peak["line"] for peak in orders["peaks_y"]] and (tmp_path / "report/orders.png").exists()
    assert orders["lines"]["FTF"] == pytest.approx(0.3913, abs=1e-4)


# The interval between samples that a scene gets which gives none
NU206 = "bearing.designation=NU206"


def interval(*settings):
    return read_scene(None, settings).numerics.output_interval_us


def test_the_papers_scene_keeps_its_ten_microseconds_and_a_result_spells_them_out(tmp_path):
    assert interval() == 10.0 and Scene().numerics.output_interval_us == 10.0
    assert interval("bearing.clearance_um=-5") == 10.0
    assert interval(NU206, "numerics.output_interval_us=20") == 20.0, "one that is given stays"
    still = ("operation.speed_rpm=0", "operation.radial_load_N=0", "operation.gravity_m_s2=0")
    assert interval(*still) == interval("bearing.clearance_um=20", *still) == 10.0, "nothing presses"
    scene = read_scene(None, (NU206,))
    assert parse_scene_text(scene.to_toml(), "again") == scene and "output_interval_us = 5.0" in scene.to_toml()
    heavy = scene.varied({"bearing.designation": "NU310", "bearing.clearance_um": 0.0})
    assert heavy.numerics.output_interval_us == 10.0  # a varied one gets its own
    scene = scene_with(tmp_path, "bearing.clearance_um=20", loads="time_ms,x_N,y_N\n0,0,-9\n100,0,-9\n")
    assert scene.numerics.output_interval_us == 5.0
    text = scene.to_toml().replace("output_interval_us = 5.0\n", "")  # of a table that is not at hand
    assert parse_scene_text(text, "without files").numerics.output_interval_us == 10.0


@pytest.mark.parametrize("struck", [
    ("bearing.clearance_um=1",), ("spall.0.angle_deg=14",), (NU206,), (NU206, "bearing.clearance_um=0"),
    (NU206, "bearing.clearance_um=-5"),
])  # fmt: skip
def test_rollers_that_are_struck_or_would_be_folded_are_followed(struck):
    scene = read_scene(None, struck)
    found = 1e-6 * scene.numerics.output_interval_us
    frequency = roller_frequency(scene.perfect_bearing(), scene.ideal_operation())
    assert found < 1e-5 and found * frequency * SAMPLES_OF_ROLLERS <= 1.0


def test_frequencies_are_those_of_palmgrens_contacts_and_a_light_hub_is_followed():
    """By hand: d = 3.84e-5 Q^0.9 / L^0.8 in mm, both contacts alike; the hub's is docs/supports.md's."""
    scene = read_scene()
    bearing, operation = scene.perfect_bearing(), scene.ideal_operation()
    ideal = kinematics(bearing, operation.speed)
    force = 5.0 * (2000.0 + 0.078 * 9.81) / 13 + bearing.roller_mass * (9.81 + bearing.pitch_radius * ideal.cage**2)
    stiffness = force / (0.9 * 1e-3 * 3.84e-5 * force**0.9 / 10.0**0.8)
    wanted = np.sqrt(2.0 * stiffness / bearing.roller_mass) / (2.0 * np.pi)
    assert roller_frequency(bearing, operation) == pytest.approx(wanted, rel=0.1)
    assert hub_frequency(bearing, operation) == pytest.approx(13.7e3, rel=0.1)
    light = read_scene(None, ("material.inner_ring.density_kg_m3=500", "operation.inner_ring_and_shaft_kg=0.004"))
    hub = hub_frequency(light.perfect_bearing(), light.ideal_operation())
    assert 1e-6 * light.numerics.output_interval_us * hub * SAMPLES_OF_THE_HUB <= 1.0 < 1e-5 * hub * SAMPLES_OF_THE_HUB


def test_runs_by_defaults_are_not_said_to_fold_and_within_what_differentiation_errs_by(tmp_path):
    slow = sets("operation.speed_rpm=1500", "operation.radial_load_N=3000", "bearing.clearance_um=0")
    slow += ["--bearing", "NU2206", "--model", "reduced", "--duration", "30"]
    default, path = ["--bearing", "NU206", "--duration", "12", "--mesh-size", "2"], tmp_path / "run.nc"
    for options in (slow, default):
        assert run_main([*options, "--quiet", "--force", "--output", str(path)]) == 0
        found = evaluate(read_result(path))
        assert not any("aliased" in note for note in found.notes)
    assert all(direction.balance.rms < direction.floor for direction in found.directions)
