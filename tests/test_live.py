"""The reduced model played live: the run is the solver's, values are the scene's, frames are for those who wait."""

import json
from queue import Queue

import numpy as np
import pytest

from fem.commands.run_live import live_main
from fem.errors import UsageError
from fem.live import player as player_module
from fem.live import playing as playing_module
from fem.live.controls import Values, sliders
from fem.live.messages import Pace, frame_message, read_wish
from fem.live.player import MOST_PLACES, Player, Record
from fem.live.playing import Playing
from fem.live.server import make_page
from fem.solver.simulate import make_plan
from fem.solver.solver import Samples
from lagrange.contact.raceway_laws import contact_pairs
from lagrange.scene.scene import SceneError, read_scene
from tests.reference.live_server import SECONDS

REDUCED = "model=reduced"


def scene_of(*settings: str):
    return read_scene(None, (REDUCED, *settings))


@pytest.fixture
def player() -> Player:
    return Player(scene_of())


def changed(values: Values, **some: float) -> Values:
    return values.model_copy(update=some)


def test_values_of_a_scene_put_back_leave_it_as_it_was():
    scene = scene_of("bearing.outer_raceway_diameter_mm=56.0123456789", "spall.0.width_mm=0.7")
    assert Values.of(scene).put_into(scene) == scene


@pytest.mark.parametrize("some", [
    {"speed_rpm": -1200.0}, {"radial_load_N": 123.0}, {"clearance_um": -13.0}, {"clearance_um": 40.0},
    {"friction_coefficient": 0.0}, {"spall_width_mm": 0.4}, {"speed_rpm": 900.0, "clearance_um": 7.5},
])  # fmt: skip
def test_values_are_those_of_the_scene_they_are_put_into(some):
    scene = scene_of()
    values = changed(Values.of(scene), **some)
    assert Values.of(values.put_into(scene)) == values


def test_a_shaft_whose_rollers_tilt_has_a_slope_to_be_changed():
    scene = scene_of("axial.slices=11", "operation.misalignment_mrad=1.0")
    assert Values.of(scene).put_into(scene) == scene
    values = changed(Values.of(scene), misalignment_mrad=-0.4)
    assert values.put_into(scene).operation.misalignment_mrad == -0.4
    shown = {slider.key: slider for slider in sliders(scene)}
    assert (shown["misalignment_mrad"].low, shown["misalignment_mrad"].high) == (-3.0, 3.0)
    assert "misalignment_mrad" not in {slider.key for slider in sliders(scene_of())}


@pytest.mark.slow  # compiles a loop
def test_pressures_along_rollers_are_those_of_their_forces_and_moments():
    player = Player(scene_of("axial.slices=11", "operation.misalignment_mrad=1.0"))
    player.advance(3)
    frame = json.loads(frame_message(player, None).text)["frame"]
    pressure, force = 1e6 * np.array(frame["pressures"]), np.array(frame["inner"])
    pair = contact_pairs(player.bearing)[0]
    by_hertz = pressure**2 * np.pi * pair.relative_radius * pair.length / 11 / pair.modulus
    assert by_hertz.sum(axis=1) == pytest.approx(force, abs=2e-3 * force.max())
    moment = by_hertz @ player.scene.ideal_axial().centres(player.bearing)
    assert moment == pytest.approx(player.now["inner_moment"], abs=2e-3 * np.abs(moment).max())
    assert make_page(player.scene, "ws://x").text.count('id="pressure"') == 1


def test_the_outer_rings_first_spall_is_the_one_that_changes():
    scene = scene_of("spall.0.body=inner_ring", "spall.1.width_mm=0.5", "spall.1.depth_um=30")
    values = Values.of(scene)
    assert values.spall_width_mm == 0.5
    wider = changed(values, spall_width_mm=0.8).put_into(scene)
    assert [(s.body, s.width_mm) for s in wider.spall] == [("inner_ring", 1.0), ("outer_ring", 0.8)]
    assert wider.spall[1].depth_um == 30.0
    assert [s.body for s in changed(values, spall_width_mm=0.0).put_into(scene).spall] == ["inner_ring"]


MACHINE = ("support.kind=housing", "sensor.frequency_Hz=12000", "damping.contact_time_us=12.5")


@pytest.mark.parametrize("some", [
    {"contact_time_us": 25.0}, {"mass_kg": 3.0, "stiffness_N_per_m": 1e8}, {"damping_N_s_m": 500.0},
    {"frequency_Hz": 2e4, "damping_ratio": 0.1}, {"contact_time_us": 0.0},
])  # fmt: skip
def test_damping_housing_and_sensor_have_controls_where_the_scene_has_them(some):
    scene = scene_of(*MACHINE)
    shown = {slider.key: slider for slider in sliders(scene)}
    assert {"contact_time_us", "mass_kg", "stiffness_N_per_m", "damping_N_s_m", "frequency_Hz"} <= set(shown)
    assert not {"contact_N_s_m", "mass_kg", "frequency_Hz"} & {slider.key for slider in sliders(scene_of())}
    values = changed(Values.of(scene), **some)
    assert Values.of(values.put_into(scene)) == values
    assert Values.of(scene).put_into(scene) == scene
    page = make_page(scene, "ws://here").text
    assert 'id="mass_kg"' in page and "Sensor&#39;s frequency" in page and "(of the sensor)" in page


REFUSED = [
    ({"radial_load_N": -5.0}, "operation.radial_load_N = -5.0: must be greater"),
    ({"speed_rpm": 1e6}, "operation.speed_rpm"),
    ({"clearance_um": 5000.0}, "too large"),
    ({"clearance_um": -500.0}, "preload"),
    ({"friction_coefficient": 2.0}, "friction_coefficient = 2.0"),
    ({"spall_width_mm": -1.0}, "width_mm = -1.0"),
    ({"spall_width_mm": 50.0}, "too wide"),
]


@pytest.mark.parametrize(("some", "words"), REFUSED)
def test_values_that_are_no_scene_are_refused_by_the_scene(some, words):
    scene = scene_of()
    with pytest.raises(SceneError, match="^these values: .*" + words):
        changed(Values.of(scene), **some).put_into(scene)


def test_a_load_that_the_model_refuses_leaves_the_run_as_it_was(player):
    before = player.plan
    with pytest.raises(UsageError, match="beyond Hertz's theory"):
        player.change(changed(player.values, radial_load_N=2e6))
    assert player.plan is before and player.values.radial_load_N == 2000.0
    assert player.advance(5) == 5


def test_sliders_hold_the_scenes_own_values():
    for settings in ((), ("bearing.outer_raceway_diameter_mm=57.9", "operation.speed_rpm=-30000"),
                     ("operation.radial_load_N=0", "operation.speed_rpm=0", "spall.0.width_mm=5")):  # fmt: skip
        scene = scene_of(*settings)
        values = Values.of(scene).model_dump()
        for slider in sliders(scene):
            assert slider.low <= values[slider.key] <= slider.high and slider.high - slider.low > slider.step


def test_what_is_played_is_the_solvers_run_whatever_it_is_cut_into(player):
    plan = make_plan(scene_of("numerics.output_interval_us=10", "numerics.duration_ms=100000"))
    wanted = plan.first_state().advance(401).samples
    for count in (1, 7, 392):
        assert player.advance(count) == count
    for name in ("time", "inner_x", "inner_ay", "roller_theta", "outer_force"):
        assert player.now[name].tobytes() == wanted[name][400].tobytes(), name
    assert player.turn[3] == pytest.approx(np.trapezoid(wanted["roller_spin"][:, 3], wanted["time"]), rel=0.01)


def test_other_values_begin_a_run_with_roller_0_where_it_was(player):
    player.advance(2345)
    before = float(player.now["roller_theta"][0])
    player.change(changed(player.values, radial_load_N=500.0, clearance_um=10.0))
    turned = (float(player.now["roller_theta"][0]) - before + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(turned) < 1e-9 and player.now["time"] == 0.0
    assert player.given_values.radial_load_N == 2000.0 and player.values.radial_load_N == 500.0


def test_a_run_that_has_come_to_its_end_restarts(player, monkeypatch):
    monkeypatch.setattr(player_module, "LONGEST_MS", 1.0)
    player.change(player.values)
    assert player.advance(250) == 250
    assert player.now["time"] == pytest.approx(0.5e-3)  # a run of 1 ms, another, half a third


def test_a_run_whose_energy_does_not_balance_is_warned_of(player, monkeypatch):
    player.advance(100)
    assert player.warnings == ()
    monkeypatch.setattr(player_module, "LIMIT", 1e-12)
    assert player.warnings == (player_module.UNBALANCED,)
    assert json.loads(frame_message(player, None).text)["frame"]["balanced"] is False


def test_forces_of_a_frame_carry_the_load(player):
    """Over half a passage of the rollers, whose places count from the load on."""
    operation = player.scene.ideal_operation()
    carried = []
    for _ in range(20):
        player.advance(13)
        frame = json.loads(frame_message(player, None).text)["frame"]
        assert min(frame["angle"]) >= -np.pi and max(frame["angle"]) <= np.pi
        carried.append(np.dot(frame["outer"], np.cos(frame["angle"])))
    rollers = player.bearing.n_rollers * player.bearing.roller_mass
    weight = (operation.inner_mass + rollers) * operation.gravity
    assert np.mean(carried) == pytest.approx(operation.radial_load + weight, rel=2e-3)
    assert frame["hub"][1] == pytest.approx(1e6 * player.now["inner_y"], abs=1e-3) and -5.0 < frame["hub"][1] < -2.0


def samples_of(**values: np.ndarray) -> Samples:
    n = len(next(iter(values.values())))
    zeros = {name: np.zeros(n) for name in ("inner_x", "inner_y", "inner_ax", "inner_ay")}
    return Samples(values=zeros | values, imbalance=np.zeros(n), exchanged=np.ones(n), error=np.zeros(n))


def test_a_spectrum_shows_the_amplitude_of_a_line_at_its_frequency():
    time = 1e-5 * np.arange(10_000)
    record = Record(1e-5)
    for part in np.array_split(3.0 + 2.0 * np.sin(2.0 * np.pi * 380.0 * time), 7):
        record.add(samples_of(inner_ay=part))
    frequency, (x, y) = record.spectrum()
    assert record.length == pytest.approx(0.1)
    assert y.max() == pytest.approx(2.0, rel=1e-6) and frequency[np.argmax(y)] == pytest.approx(380.0, rel=0.03)
    assert x.max() == 0.0 and np.all(np.diff(frequency) > 0.0)
    far = (frequency < 300.0) | (frequency > 500.0)
    assert y[far].max() < 1e-3


def test_an_envelope_shows_the_depth_of_a_swell_at_its_line():
    """Of a carrier of 5 m/s² that swells by 0.4 at BPFO the envelope has a line of 2 m/s² there, and none elsewhere."""
    time, lines = 1e-5 * np.arange(20_000), {"BPFO": 238.0, "BPFI": 350.0, "2×BSF": 215.0}
    record = Record(1e-5)
    record.add(samples_of(inner_ay=np.cos(2.0 * np.pi * 8e3 * time[:3000])))
    assert record.envelope(lines)[1].size == 0  # 7 passes
    swell = 1.0 + 0.4 * np.cos(2.0 * np.pi * 235.0 * time)  # slips by 1.3 %
    record = Record(1e-5)
    record.add(samples_of(inner_ay=5.0 * swell * np.cos(2.0 * np.pi * 8e3 * time) + 90.0))
    step, amplitude, found = record.envelope(lines)
    assert found["BPFO"] == pytest.approx(2.0, rel=0.02) and step == pytest.approx(5.0)
    assert max(found["BPFI"], found["2×BSF"]) < 0.02
    assert step * np.argmax(amplitude) == pytest.approx(235.0, abs=0.1)
    assert record.envelope(dict.fromkeys(lines, 0.0))[1].size == 0  # the bearing stands


def test_an_orbit_is_given_once_and_not_too_finely():
    record = Record(1e-5)
    record.add(samples_of(inner_x=np.arange(1700.0)))
    x, _ = record.orbit()
    assert 0.5 * MOST_PLACES < x.size <= MOST_PLACES and x[0] == 0.0 and x[-1] > 1690.0
    assert record.orbit().shape == (2, 0)


@pytest.mark.parametrize("text", [
    "", "{", "[]", "7", '{"more": 1}', '{"pace": {"slowness": 0.5}}', '{"pace": {"slowness": 1e9}}',
    '{"values": {"speed_rpm": 1}}', '{"frame": "yes"}', b"\xff",
    json.dumps({"values": Values.of(read_scene()).model_dump() | {"speed_rpm": float("nan")}}),
])  # fmt: skip
def test_what_is_no_wish_is_told_in_a_sentence(text):
    with pytest.raises(UsageError):
        read_wish(text)


def test_frames_are_made_for_those_who_wait_and_no_others(player):
    messages = Queue()
    playing = Playing(player, messages.put, messages.put)
    playing.start()

    def next_frame():
        while (message := messages.get(timeout=SECONDS)).kind != "frame":
            pass
        return json.loads(message.text)["frame"]

    playing.change_pace(Pace(slowness=50.0, playing=False))
    playing.ask_for_frame()
    first = next_frame()  # a paused run shows where it stands
    playing.ask_for_frame()
    playing.ask_for_step()
    second = next_frame()
    assert second["time"] - first["time"] == pytest.approx(1.0)  # ms: a twentieth of a second at 1/50
    playing.change_pace(Pace(slowness=500.0))
    for _ in range(2):
        playing.ask_for_frame()
        third = next_frame()
        assert third["time"] > second["time"]
        second = third
    playing.end()
    playing.join(SECONDS)
    left = [messages.get_nowait() for _ in range(messages.qsize())]
    assert not playing.is_alive() and not [message for message in left if message.kind == "frame"]


def test_a_run_that_nobody_watches_stands_still(player, monkeypatch):
    monkeypatch.setattr(playing_module, "PATIENCE", 0.0)
    messages = Queue()
    playing = Playing(player, messages.put, messages.put)
    playing.start()
    playing.ask_for_frame()
    while (message := messages.get(timeout=SECONDS)).kind != "frame":
        pass
    playing.end()
    playing.join(SECONDS)
    assert 1e3 * player.now["time"] == pytest.approx(json.loads(message.text)["frame"]["time"]) and messages.empty()


@pytest.mark.parametrize(("setting", "words"), [
    ("bearing.type=ball", 'bearing.type = "ball"'), ("operation.speed_rpm=fast", "operation.speed_rpm"),
    ("output.fields_every_ms=1", "has no mesh and no fields"),
])  # fmt: skip
def test_a_scene_that_can_not_be_played_is_refused_by_name(setting, words, capsys):
    assert live_main(["--set", setting]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and words in error
    assert live_main(["--bearing", "6205"]) == 2 and 'bearing.type = "ball"' in capsys.readouterr().err
