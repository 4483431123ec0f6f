"""Speed and load that change: their functions of time, what is refused, and the Lagrangian model under them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from fem.commands.run_fem import run_main
from fem.interface import simulate as run_scene
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.kinematics import turned
from lagrange.load_history import joined
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene, SceneError, parse_scene_text, read_scene
from residual.check_vibration import main as vibration_main
from residual.evaluation import evaluate
from tests.reference import compiled
from tests.reference.forward_motion import simulate
from tests.reference.kit import LOADS, RAMP, budget_terms, record_of, scene_with, stiffness_without_load

TURNING = ("operation.unbalance_g_mm=50", "operation.unbalance_deg=20", "operation.rotating_load_N=100")


def solved(scene, duration, **choices):
    """A Lagrangian run, a sample each 20 µs."""
    bearing = scene.ideal_bearing()
    return simulate(
        Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing), **choices), duration, 2e-5
    )


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


def test_the_shaft_turns_by_the_integral_of_its_speed(tmp_path):
    scene = scene_with(tmp_path, "numerics.duration_ms=8", speeds=RAMP)
    operation, bearing = scene.ideal_operation(), scene.ideal_bearing()
    assert operation.speed == pytest.approx(1000 * RPM)
    assert operation.history.speeds == pytest.approx((1000 * RPM, 6000 * RPM))
    expected = sum(quad(operation.history.speed, a, b)[0] for a, b in ((0.0, 2e-3), (2e-3, 6e-3), (6e-3, 7e-3)))
    way = turned(bearing, operation, 7e-3)
    assert way.shaft == pytest.approx(expected, rel=1e-10)
    assert way.cage / way.shaft == pytest.approx(9 / 23, rel=1e-12)  # 0.3913


def test_an_unbalance_is_a_mass_that_the_hub_must_accelerate(tmp_path):
    """Against differences of its own path; and rates of all loads against differences of the loads."""
    scene = scene_with(tmp_path, *TURNING, "numerics.duration_ms=8", speeds=RAMP, loads=LOADS)
    history = scene.ideal_operation().history
    alone = replace(history, rotating_load=0.0)
    h, times = 2e-6, np.array([0.5e-3, 3e-3, 5.1e-3])

    def moment(time):  # mass times place, 50 g mm, 20° from −y
        return 50e-6 * np.exp(1j * (history.turn(time) + np.radians(20.0 - 90.0)))

    acceleration = (moment(times + h) - 2.0 * moment(times) + moment(times - h)) / h**2
    x, y = alone.force(times)
    load_x, load_y = np.moveaxis(history.load(times), -1, 0)
    np.testing.assert_allclose(x - load_x + 1j * (y - load_y), -acceleration, rtol=1e-4)
    np.testing.assert_allclose(history.load(4e-3), (500.0, -2500.0), rtol=1e-12)  # a point of the table


STEP = "time_ms,x_N,y_N\n0,0,-1000\n1,400,-2000\n3,400,-2000\n"
HUB = 5.0  # kg, on springs alone
SPRINGS = (
    "operation.shaft=springs", "operation.shaft_stiffness_N_per_m=2e7", f"operation.inner_ring_and_shaft_kg={HUB}",
    "operation.gravity_m_s2=0", "numerics.duration_ms=3", "numerics.output_interval_us=10",
)  # fmt: skip


@pytest.mark.parametrize(
    ("model", "shape", "error"),
    [
        pytest.param("lagrange", "steps", 2e-3, marks=pytest.mark.slow),
        ("lagrange", "linear", 2e-6),
        pytest.param("reduced", "steps", 4e-3, marks=pytest.mark.slow),
        pytest.param("reduced", "linear", 5e-6, marks=pytest.mark.slow),
        pytest.param("fem", "steps", 4e-4, marks=pytest.mark.slow),
        pytest.param("fem", "linear", 1e-6, marks=pytest.mark.slow),
    ],
)
def test_a_hub_on_springs_answers_steps_and_ramps_as_an_oscillator(tmp_path, model, shape, error):
    """1 − cos ωt, t − sin ωt/ω; a step acts within half a time step of its time, ω Δt/2 = 10⁻³."""
    settings = ("bearing.clearance_um=900", f"model={model}", f"operation.load_table_shape={shape}")
    found = run_scene(scene_with(tmp_path, *SPRINGS, *settings, loads=STEP))
    time, stiffness = found["time"], 2e7
    omega, later = np.sqrt(stiffness / HUB), np.clip(time - 1e-3, 0.0, None)
    if shape == "steps":
        share = 1.0 - np.cos(omega * later)
    else:
        share = (time - np.sin(omega * time) / omega - later + np.sin(omega * later) / omega) / 1e-3
    unit = 1000.0 / stiffness
    np.testing.assert_allclose(found["inner_y"], -unit - unit * share, atol=error * unit)
    np.testing.assert_allclose(found["inner_x"], 0.4 * unit * share, atol=error * unit)


@pytest.mark.parametrize(
    ("model", "shape", "error"),
    [
        ("lagrange", "steps", 5e-5),
        ("lagrange", "linear", 1e-6),
        pytest.param("reduced", "steps", 1e-4, marks=pytest.mark.slow),
        pytest.param("fem", "steps", 1e-6, marks=pytest.mark.slow),
    ],
)
def test_steps_and_ramps_keep_the_account_of_energy(tmp_path, model, shape, error):
    settings = (f"model={model}", f"operation.load_table_shape={shape}", "operation.inner_ring_and_shaft_kg=0.5")
    found = run_scene(scene_with(tmp_path, *SPRINGS, *settings, loads=STEP))
    stored = sum(found[f"energy_{kind}"] for kind in ("kinetic", "elastic", "contact", "shaft"))
    left = stored + found["work_dissipated"] - found["work_external"]
    assert np.ptp(found["work_external"]) > 2e-3
    np.testing.assert_allclose(left, left[0], atol=error * np.ptp(found["work_external"]))


def test_ramps_are_straight_and_steps_hold(tmp_path):
    ramp = scene_with(tmp_path, "operation.speed_table_shape=linear", "numerics.duration_ms=8", speeds=RAMP)
    history = ramp.ideal_operation().history
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


@pytest.mark.parametrize(
    ("header", "factors"),
    [("time_s;x_kN;y_kN", (1e-3, 1e-3)), ("time [s];x [kN];y [kN]", (1e-3, 1e-3)),
     ("time [ms];x [N];y [N]", (1.0, 1.0)), ("time(s)\tx(N)\ty(N)", (1e-3, 1.0))],
)  # fmt: skip
def test_loads_may_be_in_other_units(tmp_path, header, factors):
    between = "\t" if "\t" in header else ";"
    rows, scale = [[0.0, 0.0, -2000.0], [2.0, 500.0, -1500.0], [10.0, -300.0, -2000.0]], (*factors, factors[1])
    text = "\n".join([header, *(between.join(f"{v * f:.9g}" for v, f in zip(row, scale, strict=True)) for row in rows)])
    own = scene_with(tmp_path, "numerics.duration_ms=8", loads=text).operation.read("load_table")
    np.testing.assert_allclose(np.column_stack(own), rows, rtol=1e-12)


@pytest.mark.parametrize(
    ("unit", "factor"), [("_1/min", 1.0), (" [rpm]", 1.0), ("_rad_s", RPM), (" [rad/s]", RPM)]
)
def test_speeds_may_be_in_other_units(tmp_path, unit, factor):
    text = f"time_ms,speed{unit}\n0,{1500.0 * factor:.12g}\n60,{3000.0 * factor:.12g}\n"
    scene = scene_with(tmp_path, speeds=text)
    assert scene.operation.speed_rpm == pytest.approx(1500.0, rel=1e-11)
    assert scene.ideal_operation().history.speeds[1] == pytest.approx(3000.0 * RPM, rel=1e-11)


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


def test_decimal_commas_have_a_key_beside_each_table(tmp_path):
    speeds, loads = (text.replace(",", ";").replace("1000", "1000,5") for text in (RAMP, LOADS + "12,1,-1000\n"))
    commas = ('operation.speed_table_decimal=","', 'operation.load_table_decimal=","')
    scene = scene_with(tmp_path, *commas, "numerics.duration_ms=8", speeds=speeds, loads=loads)
    assert scene.operation.speed_rpm == 1000.5
    assert scene.ideal_operation().history.load.c.shape[1] == 4
    np.testing.assert_allclose(scene.ideal_operation().history.load(12e-3), (1.0, -1000.5))
    assert parse_scene_text(scene.to_toml(), "again", scene.files) == scene
    with pytest.raises(SceneError, match=r"load_table_decimal: give load_table too"):
        scene_with(tmp_path, commas[1])
    with pytest.raises(SceneError, match=r"speed_rpm = '1\.500' is no number; with decimal = \",\" no point may stand"):
        scene_with(tmp_path, commas[0], speeds="time_ms;speed_rpm\n0;1.500\n60;2")
    with pytest.raises(SceneError, match="but commas are between its columns, too"):
        scene_with(tmp_path, commas[0], speeds=RAMP)


@pytest.mark.parametrize("text", BAD, ids=lambda text: BAD[text][:30])
def test_bad_tables_are_refused_by_name(text, tmp_path):
    with pytest.raises(SceneError) as caught:
        scene_with(tmp_path, "numerics.duration_ms=8", speeds=text)
    (line,) = str(caught.value).splitlines()
    assert 'speed_table = "speed_table.csv": ' in line and BAD[text] in line


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (("operation.speed_rpm=3000",), "speed_table.csv' is in its place; leave one of them out"),
        (("operation.speed_rpm=1000",), "operation.speed_rpm = 1000: operation.speed_table = "),
        (("operation.radial_load_N=0",), "operation.radial_load_N = 0: operation.load_table = "),
        (("operation.unbalance_deg=100",), "give unbalance_g_mm too"),
        (('contact.model="faceted"',), 'operation.speed_table: only with contact.model = "subgrid"'),
        (("operation.load_table_sha256=" + 64 * "0",), "another than the scene gives"),
        (("operation.load_table_content=x",), "unknown key; loads are read from a file"),
        (("lubricant.viscosity_Pa_s=0.02",), "[lubricant]: only at a steady speed, not with operation.speed_table"),
        (("operation.load_table=no.csv",), "can't be read: No such file or directory"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(settings, told, tmp_path):
    with pytest.raises(SceneError) as caught:
        scene_with(tmp_path, "numerics.duration_ms=8", *settings, speeds=RAMP, loads=LOADS)
    assert told in str(caught.value)


def test_a_value_in_a_file_that_contradicts_its_table_is_refused_and_one_that_is_varied(tmp_path):
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


def test_a_scene_s_text_and_its_files_give_it_back(tmp_path):
    scene = scene_with(tmp_path, *TURNING, "numerics.duration_ms=8", speeds=RAMP, loads=LOADS)
    text = scene.to_toml()
    assert parse_scene_text(text, "again", scene.files) == scene
    assert parse_scene_text(text, "shown").operation.speed_rpm == 1000.0
    with pytest.raises(SceneError, match="its text is not here"):
        parse_scene_text(text, "elsewhere", {})
    assert "table" not in Scene().to_toml() and "unbalance" not in Scene().to_toml()


def test_statics_hold_a_load_of_any_direction():
    """The load turned by so many roller pitches turns the answer."""
    bearing, operation = Scene().ideal_bearing(), replace(Scene().ideal_operation(), gravity=0.0)
    laws, pitch = contact_laws("harris", bearing), 2.0 * np.pi / bearing.n_rollers
    down = static_equilibrium(bearing, operation, laws)
    force = 2000.0 * np.exp(1j * (5 * pitch - 0.5 * np.pi))
    turned_load = replace(operation, side_load=force.real, radial_load=-force.imag)
    found = static_equilibrium(bearing, turned_load, laws)
    hub = (down.x + 1j * down.y) * np.exp(5j * pitch)
    assert found.x + 1j * found.y == pytest.approx(hub, rel=1e-9)
    np.testing.assert_allclose(found.inner_force, np.roll(down.inner_force, 5), atol=1e-6)


@pytest.mark.parametrize(
    "choices", [{}, {"angles": "free"}, {"damping": ContactDamping(constant=200.0), "start": "rest", "load_ramp": 5e-4}]
)
def test_energy_balances_under_everything_that_changes(choices, tmp_path):
    scene = scene_with(tmp_path, *TURNING, "numerics.duration_ms=8", speeds=RAMP, loads=LOADS)
    run = solved(scene, 5e-4, **choices)
    assert np.ptp(run.work_external) > 1e-3  # J
    assert np.abs(run.energy_error).max() < (1e-5 if "damping" in choices else 1e-7) * run.energy_contact.max()


def test_the_drive_gives_what_the_bodies_turn_with(tmp_path):
    """Without load: ½ J ω² of ring, shaft and rollers, and of the cage's turn, against formulas."""
    still = ("operation.radial_load_N=0", "operation.gravity_m_s2=0", "bearing.outer_raceway_diameter_mm=55.99")
    scene = scene_with(tmp_path, *still, "numerics.duration_ms=1", speeds="time_ms,speed_rpm\n0,-2000\n1,6000\n")
    run = solved(scene, 1e-3)
    speed = np.array([-2000.0, 6000.0]) * RPM
    roller, ring = 7850 * np.pi * 5e-3**2 * 0.01, 7850 * np.pi * (18e-3**2 - 12.5e-3**2) * 0.01
    inertia = 0.5 * ring * (12.5e-3**2 + 18e-3**2) + 0.5 * (0.078 - ring) * 12.5e-3**2
    inertia += 13 * 0.5 * roller * 5e-3**2 * (18 / 10) ** 2
    around = 13 * roller * (9 / 22.9975 * run.roller_rho[[0, -1], 0]) ** 2
    expected = 0.5 * np.diff((inertia + around) * speed**2)[0] + np.diff(run.energy_contact[[0, -1]])[0]
    assert run.work_external[-1] == pytest.approx(expected, rel=1e-6)
    angle = run.roller_theta[:, 0]  # it turns back at 0.25 ms
    assert abs(run.time[angle.argmin()] - 0.25e-3) < 2e-5
    assert np.interp(0.5e-3, run.time, angle) == pytest.approx(angle[0], abs=1e-12)


def test_an_unbalance_drives_a_circle():
    """F/(k − M ω²), k by statics: a preloaded bearing without load has the same stiffness in all directions."""
    scene = read_scene(None, (
        "bearing.outer_raceway_diameter_mm=55.98", "operation.radial_load_N=0", "operation.gravity_m_s2=0",
        "operation.speed_rpm=40000", "operation.inner_ring_and_shaft_kg=5", "operation.unbalance_g_mm=20",
    ))  # fmt: skip
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    force, laws = 20e-6 * operation.speed**2, contact_laws("harris", bearing)
    stiffness, inertia = stiffness_without_load(bearing, operation, laws, force), 5.0 * operation.speed**2
    assert 0.05 < inertia / stiffness < 0.1
    run = solved(scene, 2 * 60.0 / 40000)
    window = np.sin(np.pi * run.time / run.time[-1]) ** 2
    place = (run.inner_x + 1j * run.inner_y) * window / window.sum()
    ahead, back = (np.sum(place * np.exp(sign * 1j * operation.speed * run.time)) for sign in (-1, 1))
    assert abs(ahead) == pytest.approx(force / (stiffness - inertia), rel=1e-3)
    assert np.angle(ahead) == pytest.approx(-0.5 * np.pi, abs=1e-3)  # below resonance the heavy side flies out
    assert abs(back) < 1e-3 * abs(ahead)


def test_the_checker_knows_every_load(tmp_path):
    """The model's own run leaves what differentiation leaves, and the budget adds up."""
    scene = scene_with(
        tmp_path, *TURNING, "numerics.duration_ms=8", "damping.contact_N_s_m=100", speeds=RAMP, loads=LOADS
    )
    found = evaluate(record_of(scene, solved(scene, 1e-3, damping=ContactDamping(constant=100.0))), "harris")
    for terms in budget_terms(found):
        assert np.abs(terms["ring_flexibility"]).max() < 1e-9 * 2000.0  # nothing of the load is missing
        assert np.ptp(found.record.acting.side_load) > 100.0


@pytest.mark.parametrize("model", ["lagrange", "reduced", "fem"])
@pytest.mark.parametrize(
    "tables",
    [
        {"speeds": "time_ms,speed_rpm\n0,1e-6\n2,1.5e-6\n6,5e-6\n80,6e-6\n"},  # takes years to turn a little
        {"loads": "time_ms,x_N,y_N\n0,0,-2e-317\n2,500,-1e-317\n4,500,-2e-317\n100,-300,-2e-317\n"},
    ],
)
def test_tables_of_almost_nothing_are_planned(model, tables, tmp_path):
    scene_with(tmp_path, **tables)
    assert run_main([str(tmp_path / "scene.toml"), "--model", model, "--mesh-size", "2", "--dry-run"]) == 0


def test_the_checker_turns_forces_at_edges_by_the_spring_alone():
    spall = {"body": "inner_ring", "width_mm": 0.5, "angle_deg": 10.0}
    scene = Scene(model="lagrange", spall=[spall], damping={"hunt_crossley_s_m": 0.8}, operation={"speed_rpm": 9000.0})
    bearing = scene.ideal_bearing()
    damping = ContactDamping(hunt_crossley=0.8)
    run = compiled.solved(
        Problem(bearing, scene.ideal_operation(), contact_laws("harris", bearing), damping=damping), 2e-3, 2e-6
    )
    record = replace(record_of(scene, run), inner_damping_force=run.inner_damper, outer_damping_force=run.outer_damper)
    for direction in evaluate(record).directions:
        assert np.abs(direction.budget.terms["ring_flexibility"]).max() < 1e-6  # N, of 2000: what no term explains
