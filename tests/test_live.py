"""The reduced model played live: the run is the solver's, values are the scene's, frames are for those who wait.

Its server to those who shall use it, to those who shall not, and to Ctrl-C; the page in a real browser.
"""

import asyncio
import http.client
import json
import re
import signal
import socket
import subprocess
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager, suppress
from queue import Queue
from threading import Thread
from types import SimpleNamespace
from urllib.parse import urlsplit

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from fem.commands.run_fem import live_main
from fem.live import player as player_module
from fem.live import server as server_module
from fem.live.player import MOST_PLACES, Player, Record, changed, controls, values_of
from fem.live.ratings import ANGLES, LEFT_OUT, Wanted, rate
from fem.live.server import LiveServer, Pace, make_page
from fem.rating.answers import Case, Options, Rating
from fem.rating.sheet import missing, sheet
from fem.solver.simulate import make_plan
from fem.solver.solver import Samples
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.rating.sources import LINEARISED, TILTED
from lagrange.scene.scene import SceneError, parse_scene_text, read_scene
from tests.reference.kit import environment, sets, started_as
from tests.waiting import GIVE_UP, assert_readable, coloured_pixels, open_page


def scene_of(*settings: str):
    return read_scene(None, ("model=reduced", *settings))


@pytest.fixture
def player():
    return Player(scene_of())


MACHINE = ("support.kind=housing", "sensor.frequency_Hz=12000", "damping.contact_time_us=12.5")
OF_MACHINE = {"contact_time_us", "mass_kg", "stiffness_N_per_m", "damping_N_s_m", "frequency_Hz", "damping_ratio"}


@pytest.mark.parametrize(("settings", "some"), [
    ((), {"speed_rpm": -1200.0}), ((), {"radial_load_N": 123.0}), ((), {"clearance_um": -13.0}),
    ((), {"friction_coefficient": 0.0}), ((), {"speed_rpm": 900.0, "clearance_um": 7.5}),
    ((), {"outer_ring_spall_mm": 0.4, "outer_ring_spall_deg": -30.0}),
    ((), {"inner_ring_spall_mm": 0.3, "roller_spall_mm": 1.0}),
    (("bearing.outer_raceway_diameter_mm=56.0123456789", "spall.0.width_mm=0.7"), {"clearance_um": 40.0}),
    (MACHINE, {"contact_time_us": 25.0}), (MACHINE, {"mass_kg": 3.0, "stiffness_N_per_m": 1e8}),
    (MACHINE, {"damping_N_s_m": 500.0}), (MACHINE, {"frequency_Hz": 2e4, "damping_ratio": 0.1}),
    (MACHINE, {"contact_time_us": 0.0}),
    (("axial.slices=11", "operation.misalignment_mrad=1.0"), {"misalignment_mrad": -0.4}),
])  # fmt: skip
def test_values_are_those_of_the_scene_they_are_put_into_and_its_own_leave_it_as_it_was(settings, some):
    scene = scene_of(*settings)
    assert changed(scene, values_of(scene)) == scene
    values = values_of(scene) | some
    assert values_of(changed(scene, values)) == values
    shown = {control.key for control in controls(scene)}
    assert shown & OF_MACHINE == (OF_MACHINE if settings == MACHINE else set())
    assert shown >= some.keys() and ("misalignment_mrad" in shown) == ("misalignment_mrad" in some)


def test_spalls_and_a_cage_that_the_scene_does_not_give_change_apart():
    scene = scene_of("spall.0.body=inner_ring", "spall.1.width_mm=0.5", "spall.1.depth_um=30")
    values = values_of(scene)
    assert (values["inner_ring_spall_mm"], values["outer_ring_spall_mm"], values["roller_spall_mm"]) == (1.0, 0.5, 0.0)
    found = changed(scene, values | {"outer_ring_spall_mm": 0.8, "outer_ring_spall_deg": 12.0, "roller_spall_mm": 0.6})
    assert [(s.body, s.width_mm, s.roller) for s in found.spall] == [
        ("inner_ring", 1.0, None), ("outer_ring", 0.8, None), ("roller", 0.6, 0)]  # fmt: skip
    assert (found.spall[1].depth_um, found.spall[1].angle_deg) == (30.0, 12.0)
    assert [s.body for s in changed(scene, values | {"inner_ring_spall_mm": 0.0}).spall] == ["outer_ring"]
    assert "roller_spall_mm" not in values_of(scene_of("bearing.missing_rollers=[2]"))  # not both in a scene
    still = {"friction_coefficient": 0.0}
    scene = scene_of("bearing.designation=NU206")
    own = scene_of("bearing.designation=NU206", "cage.pocket_clearance_mm=0.2")
    assert scene.cage is not None and changed(scene, values_of(scene)).cage == scene.cage
    assert changed(scene, values_of(scene) | still).cage is None and changed(own, values_of(own)).cage == own.cage


@pytest.mark.slow  # compiles a loop
def test_pressures_along_rollers_are_those_of_their_forces_and_moments():
    player = Player(scene_of("axial.slices=11", "operation.misalignment_mrad=1.0"))
    player.advance(3)
    frame = player.frame()
    pressure, force = 1e6 * np.array(frame["pressures"]), np.array(frame["inner"])
    pair = contact_pairs(player.bearing)[0]
    by_hertz = pressure**2 * np.pi * pair.relative_radius * pair.length / 11 / pair.modulus
    assert by_hertz.sum(axis=1) == pytest.approx(force, abs=2e-3 * force.max())
    moment = by_hertz @ player.scene.ideal_axial().centres(player.bearing)
    assert moment == pytest.approx(player.now["inner_moment"], abs=2e-3 * np.abs(moment).max())
    assert make_page(player, "ws://x")[0].count('id="pressure"') == 1


@pytest.mark.parametrize(("some", "words"), [
    ({"radial_load_N": -5.0}, "^these values: operation.radial_load_N = -5.0: must be greater"),
    ({"speed_rpm": 1e6}, "operation.speed_rpm"), ({"clearance_um": 5000.0}, "too large"),
    ({"clearance_um": -500.0}, "preload"), ({"friction_coefficient": 2.0}, "friction_coefficient = 2.0"),
    ({"outer_ring_spall_mm": -1.0}, "width_mm = -1.0"), ({"inner_ring_spall_mm": 50.0}, "too wide"),
    ({"radial_load_N": 2e6}, "beyond Hertz's theory"), (None, "values: give speed_rpm, "),
])  # fmt: skip
def test_values_that_are_no_scene_are_refused_and_leave_the_run_as_it_was(some, words, player):
    before, values = player.plan, values_of(player.scene)
    with pytest.raises((SceneError, UsageError), match=words):
        player.change({"speed_rpm": 100.0} if some is None else values | some)
    assert player.plan is before and values_of(player.scene) == values and player.advance(5) == 5


def test_the_page_has_the_controls_of_the_scene_and_sliders_hold_its_own_values():
    page, _ = make_page(Player(scene_of(*MACHINE)), "ws://here")
    assert 'id="mass_kg"' in page and "Sensor&#39;s frequency" in page and "(of the sensor)" in page
    for settings in ((), ("bearing.outer_raceway_diameter_mm=57.9", "operation.speed_rpm=-30000"),
                     ("operation.radial_load_N=0", "operation.speed_rpm=0", "spall.0.width_mm=5")):  # fmt: skip
        scene = scene_of(*settings)
        values = values_of(scene)
        for slider in controls(scene):
            assert slider.low <= values[slider.key] <= slider.high and slider.high - slider.low > slider.step


def test_what_is_played_is_the_solvers_run_and_other_values_begin_one_with_roller_0_where_it_was(player, monkeypatch):
    plan = make_plan(scene_of("numerics.output_interval_us=10", "numerics.duration_ms=100000"))
    wanted = plan.first_state().advance(401).samples
    for count in (1, 7, 392):
        assert player.advance(count) == count
    for name in ("time", "inner_x", "inner_ay", "roller_theta", "outer_force"):
        assert player.now[name].tobytes() == wanted[name][400].tobytes(), name
    assert player.turn[3] == pytest.approx(np.trapezoid(wanted["roller_spin"][:, 3], wanted["time"]), rel=0.01)
    player.advance(2345)
    before = float(player.now["roller_theta"][0])
    player.change(values_of(player.scene) | {"radial_load_N": 500.0, "clearance_um": 10.0})
    turned = (float(player.now["roller_theta"][0]) - before + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(turned) < 1e-9 and player.now["time"] == 0.0
    assert player.facts()["given"]["radial_load_N"] == 2000.0 and player.facts()["values"]["radial_load_N"] == 500.0
    monkeypatch.setattr(player_module, "LONGEST_MS", 1.0)
    player.change(values_of(player.scene))
    assert player.advance(250) == 250
    assert player.now["time"] == pytest.approx(0.5e-3)  # a run of 1 ms, another, half a third
    assert player.warnings() == ()
    monkeypatch.setattr(player_module, "LIMIT", 1e-12)
    assert player.warnings() == (player_module.UNBALANCED,) and player.frame()["balanced"] is False


def test_frames_show_forces_that_carry_the_load_and_a_cage_where_its_pockets_are(player):
    operation, carried = player.scene.ideal_operation(), []
    for _ in range(20):  # over half a passage of the rollers
        player.advance(13)
        frame = player.frame()
        assert min(frame["angle"]) >= -np.pi and max(frame["angle"]) <= np.pi
        carried.append(np.dot(frame["outer"], np.cos(frame["angle"])))
    rollers = player.bearing.n_rollers * player.bearing.roller_mass
    weight = (operation.inner_mass + rollers) * operation.gravity
    assert np.mean(carried) == pytest.approx(operation.radial_load + weight, rel=2e-3)
    assert frame["hub"][1] == pytest.approx(1e6 * player.now["inner_y"], abs=1e-3) and -5.0 < frame["hub"][1] < -2.0
    player = Player(scene_of("bearing.designation=NU206", "operation.first_roller_deg=10"))
    player.advance(400)
    frame, facts = player.frame(), player.facts()
    apart = 2.0 * np.pi / facts["pockets"]
    ahead = np.remainder(np.array(frame["angle"]) - 0.5 * np.pi - frame["cage"], apart)
    assert np.minimum(ahead, apart - ahead).max() < 0.01  # play in a pocket, and of the cage
    assert Player(scene_of()).frame()["cage"] is None  # the paper's bearing has none


def recorded(*parts, name="inner_ay"):  # samples of one column, the rest 0
    record = Record(1e-5)
    for values in parts:
        zeros = dict.fromkeys(("inner_x", "inner_y", "inner_ax", "inner_ay"), np.zeros(len(values)))
        of_energy = dict.fromkeys(("imbalance", "exchanged", "error"), np.ones(len(values)))
        record.add(Samples(values=zeros | {name: values}, **of_energy))
    return record


def test_spectra_show_amplitudes_at_their_lines_envelopes_depths_of_swells_and_orbits_are_given_once_not_too_finely():
    """Of a carrier of 5 m/s² that swells by 0.4 at BPFO the envelope has a line of 2 m/s² there, and none elsewhere.
    Of five small rollers 2×BSF lies far above BPFI."""
    time = 1e-5 * np.arange(10_000)
    record = recorded(*np.array_split(3.0 + 2.0 * np.sin(2.0 * np.pi * 380.0 * time), 7))
    frequency, (x, y) = record.spectrum()
    assert record.length == pytest.approx(0.1)
    assert y.max() == pytest.approx(2.0, rel=1e-6) and frequency[np.argmax(y)] == pytest.approx(380.0, rel=0.03)
    assert x.max() == 0.0 and np.all(np.diff(frequency) > 0.0)
    assert y[(frequency < 300.0) | (frequency > 500.0)].max() < 1e-3
    record = recorded(np.arange(1700.0), name="inner_x")
    x, _ = record.orbit()
    assert 0.5 * MOST_PLACES < x.size <= MOST_PLACES and x[0] == 0.0 and x[-1] > 1690.0
    assert record.orbit().shape == (2, 0)
    time, lines = 1e-5 * np.arange(20_000), {"BPFO": 238.0, "BPFI": 350.0, "2×BSF": 215.0}
    carrier, swell = np.cos(2.0 * np.pi * 8e3 * time), 1.0 + 0.4 * np.cos(2.0 * np.pi * 235.0 * time)  # slips by 1.3 %
    assert recorded(carrier[:3000]).envelope(lines)[1].size == 0  # 7 passes
    record = recorded(5.0 * swell * carrier + 90.0)
    step, amplitude, found = record.envelope(lines)
    assert found["BPFO"] == pytest.approx(2.0, rel=0.02) and step == pytest.approx(5.0)
    assert max(found["BPFI"], found["2×BSF"]) < 0.02
    assert step * np.argmax(amplitude) == pytest.approx(235.0, abs=0.1)
    assert record.envelope(dict.fromkeys(lines, 0.0))[1].size == 0  # the bearing stands
    player = Player(scene_of("bearing.rollers=5", "bearing.roller_diameter_mm=3", "bearing.clearance_um=5"))
    player.advance(5000)
    lines, envelope = player.fault_lines(), player.frame()["envelope"]
    assert lines["2×BSF"] > 2.3 * lines["BPFI"] and envelope["lines"].keys() == lines.keys()
    assert envelope["bin"] * len(envelope["amplitude"]) > lines["2×BSF"]


@pytest.mark.parametrize(("words", "told"), [
    ("--set bearing.type=ball", 'bearing.type = "ball"'), ("--set operation.speed_rpm=fast", "operation.speed_rpm"),
    ("--set output.fields_every_ms=1", "no mesh and no fields"), ("--bearing 6205", 'bearing.type = "ball"'),
])  # fmt: skip
def test_a_scene_that_can_not_be_played_is_refused_by_name(words, told, capsys):
    assert live_main(words.split()) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and told in error


WORK = 0.56  # s of steps for a second in real time, as measured for the paper's bearing
MAKING, DRAWING = 0.005, 0.015  # s of a frame, here and in the browser with the way there and back
PASSED, INTERVAL = 4.0, 1e-5  # s


class Clock(asyncio.SelectorEventLoop):
    """An event loop that does not wait: its time goes to when something is due."""

    now = 1e3

    def time(self):
        return self.now

    monotonic = time

    def _run_once(self):
        if not self._ready and self._scheduled:
            self.now = max(self.now, self._scheduled[0].when())
        super()._run_once()


@pytest.mark.parametrize(("work", "slowness"), [(WORK, 1.0), (WORK, 50.0), (10.0 * WORK, 50.0), (10.0 * WORK, 1.0)])
def test_a_page_gets_20_frames_a_second_at_the_pace_asked_for_or_slower(work, slowness, monkeypatch):
    clock, page, frames, done = Clock(), object(), [], []

    def advance(count, is_late):
        before = sum(done)
        while sum(done) < before + count and not is_late():
            done.append(min(10, before + count - sum(done)))
            clock.now += work * done[-1] * INTERVAL
        return sum(done) - before

    def frame():
        clock.now += MAKING
        return {}

    def hear(viewers, text):
        if "frame" in json.loads(text):
            frames.append(text)
            clock.call_later(DRAWING, server._hear, page, '{"frame": true}')

    async def now(work, *arguments):
        return work(*arguments)

    async def watch():
        server._loop, server._changed = clock, asyncio.Event()
        server._changed.set()
        with suppress(TimeoutError):
            await asyncio.wait_for(server._play(), PASSED)

    plan = SimpleNamespace(interval=INTERVAL)
    server = LiveServer(SimpleNamespace(plan=plan, given=None, facts=dict, advance=advance, frame=frame))
    monkeypatch.setattr(server_module, "time", clock)
    monkeypatch.setattr(server_module, "broadcast", hear)
    server._in_thread, server._pace, server._viewers = now, Pace(slowness=slowness), {page: True}
    with ThreadPoolExecutor(1) as thread:
        thread.submit(clock.run_until_complete, watch()).result()  # a browser of other tests has a loop in this one
    clock.close()
    simulated = sum(done) * INTERVAL
    if work > slowness:
        assert len(frames) >= 17.0 * PASSED and simulated < 0.2 * PASSED
    else:
        assert len(frames) >= 20.0 * PASSED and simulated * slowness == pytest.approx(PASSED, rel=0.03)


class Served:
    """A server that runs; its address is http://127.0.0.1:port/token/."""

    def __init__(self, address):
        parts = urlsplit(address)
        self.port, self.path, self.host = parts.port, parts.path, parts.netloc
        self.origin = f"http://{self.host}"

    def connected(self, origin="", path=None):
        """A viewer's connection; as a page of this server unless told otherwise."""
        address = f"ws://{self.host}{self.path + 'live' if path is None else path}"
        return connect(address, origin=self.origin if origin == "" else origin, open_timeout=GIVE_UP, proxy=None)


@pytest.fixture(scope="module")
def live():
    server, addresses = LiveServer(Player(scene_of())), Queue()
    thread = Thread(target=lambda: asyncio.run(server.run(addresses.put)), daemon=True)
    thread.start()
    try:
        yield Served(addresses.get(timeout=GIVE_UP))
    finally:
        server.end()
        thread.join(GIVE_UP)
        assert not thread.is_alive()


def told(viewer, kind):  # the next message of a kind
    while True:
        message = json.loads(viewer.recv(timeout=GIVE_UP))
        if kind in message:
            return message[kind]


def ask(viewer, **wish):
    viewer.send(json.dumps(wish))


def frame_of(viewer, **wish):
    ask(viewer, frame=True, **wish)
    return told(viewer, "frame")


def answer(live, method="GET", path=None, body=None, **headers):
    """Status, headers and text that a request gets; a header that is None is left out."""
    with closing(http.client.HTTPConnection(live.host, timeout=GIVE_UP)) as connection:
        connection.putrequest(method, live.path if path is None else path, skip_host=True)
        sent = {"Host": live.host, "Content-Length": body and str(len(body))} | headers
        for name, value in sent.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders(body and body.encode())
        response = connection.getresponse()
        return response.status, response.headers, response.read().decode()


def test_the_page_is_whole_may_load_nothing_and_is_forbidden_without_token_or_by_another_name_method_or_origin(live):
    status, headers, text = answer(live)
    assert status == 200 and headers["Content-Type"] == "text/html; charset=utf-8"
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; ") and "unsafe" not in policy and "frame-ancestors 'none'" in policy
    assert headers["Cache-Control"] == "no-store" and headers["Referrer-Policy"] == "no-referrer"
    assert "Access-Control-Allow-Origin" not in headers and "uPlot" in text and live.path.strip("/") not in text
    assert answer(live, Host=f"localhost:{live.port}")[0] == 200  # this machine's other name
    # Of a site whose name was made to resolve to this machine, too.
    own = live.path[:-1]
    for path in ("/", "/live", "/wrong/", "/wrong/live", "//", own, f"{own}/?a", f"{own}x/", f"{own}/../", f"/x{own}/",
                 f"{own}/favicon.ico"):  # fmt: skip
        assert answer(live, path=path)[::2] == (403, "403 Forbidden\n"), path
    for host in (None, "", "evil.example", "127.0.0.1", "127.0.0.1:1", f"evil.example:{live.port}"):
        assert answer(live, Host=host)[0] == 403, host
    for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "TRACE"):
        assert answer(live, method)[0] == 405, method
    wrong = ["http://evil.example", "null", f"https://127.0.0.1:{live.port}", "http://127.0.0.1"]
    assert all(answer(live, Origin=origin)[0] == 403 for origin in wrong)
    for origin, path in (*((origin, None) for origin in (*wrong, None)), ("", "/live"), ("", "/wrong/live")):
        with pytest.raises(InvalidStatus) as refused:
            live.connected(origin, path)
        assert refused.value.response.status_code == 403
    # what has a body or is no request
    with pytest.raises((http.client.BadStatusLine, ConnectionError)):
        answer(live, "POST", body="speed=1")
    with socket.create_connection(("127.0.0.1", live.port), timeout=GIVE_UP) as door:
        door.sendall(b"\x16\x03\x01\x02\x00\r\n\r\n")
        assert b"200" not in door.recv(1000)
    assert answer(live)[0] == 200
    with pytest.raises(OSError):  # 127.0.0.2 is this machine as well: who listens everywhere answers there
        socket.create_connection(("127.0.0.2", live.port), timeout=GIVE_UP)


def test_nonsense_is_told_so_and_ends_nothing(live):
    with live.connected() as viewer:
        for text in ("", "{", "[]", "7", '{"more": 1}', '{"pace": {"slowness": 0.5}}', '{"pace": {"slowness": 1e9}}',
                     '{"values": 1}', '{"values": {"speed_rpm": 1}}', '{"frame": "yes"}', b"\xff", b"\x00",
                     '{"values": {"speed_rpm": NaN}}', '{"rate": {"bearing": 7}}', '{"rate": {"more": 1.0}}',
                     '{"rate": {"viscosity_mm2_s": -1.0}}'):  # fmt: skip
            viewer.send(text)
            assert told(viewer, "refused")
        assert frame_of(viewer)["outer"]
    with live.connected() as viewer, pytest.raises(ConnectionClosed):
        viewer.send("x" * 100_000)
        told(viewer, "refused")
    assert answer(live)[0] == 200


def test_what_one_viewer_changes_all_see_and_what_is_refused_changes_nothing(live):
    with live.connected() as one, live.connected() as other:
        values = told(one, "bearing")["values"]
        told(other, "bearing")
        ask(one, values=values | {"radial_load_N": -1.0})
        assert "operation.radial_load_N = -1.0" in told(one, "refused")
        ask(one, values=values | {"radial_load_N": 700.0})
        for viewer in (one, other):
            assert told(viewer, "bearing")["values"] == values | {"radial_load_N": 700.0}
            assert sum(frame_of(viewer)["outer"]) > 700.0
        ask(other, pace={"slowness": 200.0, "playing": False})
        assert told(one, "pace") == {"slowness": 200.0, "playing": False}
    with live.connected() as late:  # finds what is played, and where it stands
        assert told(late, "bearing")["values"]["radial_load_N"] == 700.0 and told(late, "pace")["playing"] is False
        assert sum(told(late, "frame")["outer"]) > 700.0


def test_a_paused_run_goes_on_by_steps_of_a_twentieth_of_a_second_and_stands_while_nobody_asks(live):
    with live.connected() as viewer:
        ask(viewer, pace={"slowness": 50.0, "playing": False}, values=told(viewer, "bearing")["values"], frame=True)
        told(viewer, "bearing")  # of the new run
        assert told(viewer, "frame")["time"] == 0.0
        for time in (1.0, 2.0):
            assert frame_of(viewer, step=True)["time"] == pytest.approx(time)
        last = frame_of(viewer, pace={"slowness": 50.0, "playing": True})["time"]
    with live.connected() as late:
        assert told(late, "frame")["time"] == last and frame_of(late)["time"] > last


TAPERED = (
    "bearing.pitch_diameter_mm=46", "bearing.contact_angle_deg=14", "bearing.rollers=17",
    "bearing.roller_diameter_mm=7", "bearing.roller_length_mm=12", "bearing.clearance_um=10",
    "bearing.bore_diameter_mm=30", "bearing.outside_diameter_mm=62", "operation.radial_load_N=3000",
)  # fmt: skip
OIL = 1e-6 * 20.0 * 870.0  # Pa s, of 20 mm²/s
OILED = ("lubricant.viscosity_Pa_s=0.02",)


@pytest.mark.parametrize(("given", "wanted", "settings"), [
    ((), {}, ()),
    (TAPERED, {"speed_rpm": 900.0, "viscosity_mm2_s": 20.0},
     (*TAPERED, "operation.speed_rpm=900", f"lubricant.viscosity_Pa_s={OIL}")),
    (("operation.radial_load_N=800",), {"bearing": "nu 206 ecp", "clearance_um": 15.0, "viscosity_mm2_s": 20.0},
     ("bearing.designation=nu 206 ecp", "bearing.clearance_um=15", "operation.radial_load_N=800",
      f"lubricant.viscosity_Pa_s={OIL}")),
    (OILED, {"bearing": "6206/C3", "radial_load_N": 500.0},
     ('bearing.designation="6206/C3"', "operation.radial_load_N=500")),
    ((), {"bearing": "NU206", "misalignment_mrad": 0.5},
     ("bearing.designation=NU206", "operation.misalignment_mrad=0.5", "axial.slices=11")),
    (TAPERED, {"axial_load_N": 1500.0}, (*TAPERED, "operation.axial_load_N=1500")),
    ((), {"bearing": "6206", "axial_load_N": -900.0, "misalignment_mrad": 1.0},
     ('bearing.designation="6206"', "operation.axial_load_N=-900", "operation.misalignment_mrad=1.0")),
])  # fmt: skip
def test_a_slider_s_answers_are_those_of_rate_bearing_to_the_same_scene(given, wanted, settings):
    scene = read_scene(None, ("model=lagrange", *settings))
    viscosity = 1e6 * 0.02 / 870.0 if given == OILED else None  # of balls, which have no [lubricant]
    case = Case(scene, Options(viscosity=viscosity))
    whole, found = Rating(case, LEFT_OUT), rate(scene_of(*given), Wanted(**wanted))
    over_a_pitch = {answer.meaning for answer in whole.answers.values() if answer.source in (LINEARISED, TILTED)}
    assert found["missing"] == missing(whole) and found["blocks"].keys() == sheet(whole).keys()
    for block, lines in sheet(whole).items():
        shown = {meaning: value for meaning, value, *_ in found["blocks"][block]}
        assert list(shown) == [line.meaning for line in lines]
        for line in lines:
            assert line.meaning in over_a_pitch or shown[line.meaning] == line.value, line
    few = Case(scene, Options(angles=ANGLES)).stiffness
    assert np.diag(few) == pytest.approx(np.diag(whole["stiffness_N_per_m"]), rel=0.03)
    assert parse_scene_text(found["toml"], "saved").perfect_bearing() == scene.perfect_bearing()
    load, angle = np.array(found["picture"]["load"]), np.array(found["picture"]["angle"])
    inclined = np.cos(np.radians(whole["contact_angle_range_deg"] or [np.degrees(case.bearing.contact_angle)])).mean()
    radial = scene.operation.radial_load_N + case.weight
    assert load @ np.cos(angle) * inclined == pytest.approx(radial, rel=0.01)
    for key, (low, high, _) in found["ends"].items():
        assert low <= found["values"][key] <= high


REFUSED = {("bearing", "NU20"): "NU204 to NU220", ("radial_load_N", -1.0): "radial_load_N = -1.0",
           ("axial_load_N", 10.0): "axial_load_N = 10: the bearing has no flanges"}  # fmt: skip


def test_who_asks_for_ratings_gets_those_of_the_last_wish_alone_and_a_refusal_in_a_sentence(live):
    with live.connected() as one, live.connected() as other:
        for load in (500.0, 600.0, 700.0, 800.0):
            ask(one, rate={"radial_load_N": load})
        answers = [told(one, "rating")]
        while answers[-1]["values"]["radial_load_N"] < 800.0:
            answers.append(told(one, "rating"))
        assert len(answers) <= 4 and answers[-1]["values"]["clearance_um"] == 0.0
        for (key, value), words in REFUSED.items():
            ask(one, rate={key: value})
            assert words in told(one, "unrated")
        ask(one, rate={"bearing": "NU206"})
        assert told(one, "rating")["name"] == "NU206"
        ask(other, pace={"slowness": 50.0, "playing": True}, frame=True)
        kinds = []
        while "frame" not in kinds:
            kinds += json.loads(other.recv(timeout=GIVE_UP))
        assert not {"rating", "unrated"} & set(kinds)


@contextmanager
def command_served(*arguments):
    """Process and address of a `run-live`, which nothing but Ctrl-C ends before the test does."""
    program, pipe = [*started_as("run-live"), *arguments], subprocess.PIPE
    with subprocess.Popen(program, env=environment(), stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield process, process.stdout.readline().split()[1]
            assert process.poll() in (None, 130), process.communicate()[1]
        finally:
            process.terminate()


def test_ctrl_c_ends_it_with_a_viewer_watching_who_answers_nothing():
    with command_served() as (process, address):
        served = Served(address)
        with socket.create_connection(("127.0.0.1", served.port), timeout=GIVE_UP) as viewer:
            request = (
                f"GET {served.path}live HTTP/1.1\r\nHost: {served.host}\r\nOrigin: {served.origin}\r\n"
                "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
            )
            viewer.sendall(request.encode())
            assert viewer.recv(12) == b"HTTP/1.1 101"
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=GIVE_UP)
    assert process.returncode == 130 and error == "interrupted\n" and len(served.path.strip("/")) > 20


@pytest.fixture(scope="module")
def address():
    with command_served() as (_, served):
        yield served


@pytest.fixture(scope="module")
def page(browser, address, request):
    """The page of a width. Tests leave it as they found it."""
    with open_page(browser, address, request.param) as page:
        wait_for_frames(page)
        yield page
        assert page.complaints == []


GROUNDS = "all => all.map(e => getComputedStyle(e).backgroundColor)"
everywhere = pytest.mark.parametrize("page", [390, 1280], indirect=True)
on_a_desk = pytest.mark.parametrize("page", [1280], indirect=True)


def wait_for_frames(page, count=3):
    seen = page.evaluate("() => window.live ? window.live.frames : 0")
    page.wait_for_function("least => window.live && window.live.frames >= least", arg=seen + count)


def set_value(page, key, value):
    page.locator(f"#{key}-typed").fill(f"{value:g}")
    page.locator(f"#{key}-typed").press("Tab")
    wait_for_value(page, key, value)


def wait_for_value(page, key, value):
    page.wait_for_function("([key, value]) => window.live.bearing().values[key] === value", arg=[key, value])


def coloured(page, canvas):  # pixels that are orange or brown, as loads are
    return coloured_pixels(page, canvas, "r > 120 && r > 1.4 * b")[0]


@everywhere
def test_all_is_drawn_and_read_and_nothing_comes_from_elsewhere(page, address):
    assert [url for url in page.asked if not url.startswith(("data:", "blob:"))] == [address]
    assert_readable(page, "p, label, dt, dd, button, small, figcaption", 12.0)
    assert coloured(page, "#bearing") > 2000 and coloured(page, "#zone canvas") > 50
    for name in ("bearing", "zone .plot", "orbit .plot", "spectrum .plot", "envelope .plot"):
        box = page.locator(f"#{name}").bounding_box()
        assert box["width"] > 250 and box["height"] > 150
    page.wait_for_function("() => document.querySelector('#record').textContent.includes('Hz')")
    assert page.locator("#factor").inner_text().startswith("1/")
    assert page.locator("#loaded").inner_text().endswith("of 13")
    assert page.locator("#cautions").is_hidden() and page.locator("#refused").is_hidden()
    ticks = "[[0, 2e-4, 4e-4], [-2.5, 0, 2.5], [0, 500, 1000]].map(v => charts.plain(null, v, 0, 0, v[1] - v[0]))"
    shown = page.evaluate(ticks)  # those of an envelope of thousandths of g were 0, 0, 0
    assert shown == [["0.0000", "0.0002", "0.0004"], ["−2.5", "0.0", "2.5"], ["0", "500", "1000"]]


@on_a_desk
def test_sliders_and_boxes_change_the_bearing_refusals_are_explained_and_shocks_of_a_spall_warned_of(page):
    page.locator("#speed_rpm").fill("3000")
    wait_for_value(page, "speed_rpm", 3000)
    assert page.locator("#speed_rpm-typed").input_value() == "3000"
    page.locator("#clearance_um-typed").fill("12.5")  # half written while another value comes back
    page.evaluate("live.send({ values: { ...live.bearing().values, friction_coefficient: 0.2 } })")
    wait_for_value(page, "friction_coefficient", 0.2)
    page.locator("#clearance_um-typed").press("Tab")
    wait_for_value(page, "clearance_um", 12.5)
    with page.expect_download() as saved:
        page.get_by_text("Save this scene").click()
    scene = read_scene(saved.value.path())
    assert scene.operation.speed_rpm == 3000.0 and scene.bearing.outer_raceway_diameter_mm == 56.0125
    assert scene.model == "reduced" and scene.numerics.duration_ms == 60.0
    page.get_by_role("button", name="Reset").click()
    wait_for_value(page, "speed_rpm", 4500)
    assert page.evaluate("window.live.bearing().values.clearance_um") == 0
    page.locator("#radial_load_N-typed").fill("-5")
    page.locator("#radial_load_N-typed").press("Tab")
    refused = page.locator("#refused")
    refused.wait_for()
    assert "operation.radial_load_N = -5.0: must be greater than or equal to 0" in refused.inner_text()
    assert page.locator("#radial_load_N-typed").input_value() == "2000"
    wait_for_frames(page)
    set_value(page, "radial_load_N", 2500)
    refused.wait_for(state="hidden")
    set_value(page, "outer_ring_spall_mm", 0.8)
    page.locator("#cautions").wait_for()
    page.wait_for_function("() => document.querySelector('#cautions').textContent.includes('elastic waves')")
    page.get_by_role("button", name="Reset").click()
    wait_for_value(page, "outer_ring_spall_mm", 0)
    wait_for_value(page, "radial_load_N", 2000)
    page.locator("#cautions").wait_for(state="hidden")


@everywhere
def test_ratings_follow_their_sliders_on_a_tab_of_their_own(page):
    page.get_by_role("tab", name="Motion").focus()
    page.keyboard.press("ArrowRight")
    page.locator("#tiles dd").first.wait_for()
    tab = page.get_by_role("tab", name="Ratings")
    assert page.url.endswith("#ratings") and tab.get_attribute("aria-selected") == "true"
    assert page.locator("#motion").is_hidden() and page.locator("#blocks h2").all_text_contents()[1:] == [
        "bearing", "loads", "lives", "stresses", "stiffness", "friction and film"]  # fmt: skip
    page.locator("#designation").fill("NU206")
    page.locator("#designation").press("Tab")
    page.wait_for_function("() => ratings.found().name === 'NU206'")
    page.locator("#rated-viscosity_mm2_s-typed").fill("20")
    page.evaluate("ratings.hear.rating(ratings.found())")
    page.locator("#rated-viscosity_mm2_s-typed").press("Tab")
    page.wait_for_function("() => ratings.found().values.viscosity_mm2_s === 20")
    page.locator("#rated-radial_load_N").fill("3000")
    page.wait_for_function("() => ratings.found().values.radial_load_N === 3000")
    assert page.locator("#blocks").get_by_text("44000 N").count() == 1
    assert coloured(page, "#section") > 200 and "of 13 under load" in page.locator("#section-says").inner_text()
    assert_readable(page, "p, label, dt, dd, button, small", 12.0)
    frames = page.evaluate("window.live.frames")
    page.locator("#designation").fill("NU20")
    page.locator("#designation").press("Tab")
    page.locator("#unrated").wait_for()
    assert "NU204 to NU220" in page.locator("#unrated").inner_text()
    assert page.locator("#blocks").get_by_text("44000 N").count() == 1
    page.get_by_role("button", name="Reset").click()
    page.locator("#unrated").wait_for(state="hidden")
    assert page.evaluate("window.live.frames") == frames  # the run stands while nobody looks
    page.get_by_role("tab", name="Motion").click()
    wait_for_frames(page)


@on_a_desk
def test_it_can_be_paused_slowed_down_and_taken_step_by_step(page):
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    page.locator("#slowness").fill("6")
    page.wait_for_function("() => document.querySelector('#factor').textContent === '1/100'")
    assert page.locator("#pace").inner_text().endswith("a twentieth of a second at 1/100.")
    page.get_by_role("button", name="Reset").click()
    page.wait_for_function("() => window.live.frame().time === 0")  # a paused run shows where it stands
    for wanted in (0.5, 1.0):  # ms
        page.get_by_role("button", name="Step").click()
        page.wait_for_function("wanted => window.live.frame().time > wanted - 0.1", arg=wanted)
        assert page.evaluate("window.live.frame().time") == pytest.approx(wanted)
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("() => window.live.frame().time > 2")
    assert page.locator("#pace").inner_text().startswith("One second here is")
    page.locator("#slowness").fill("5")


def test_the_bearing_stays_in_view_beside_many_controls_and_is_dark_where_all_is(browser):
    spalls = ("spall.0.width_mm=0.5", "spall.1.body=inner_ring", "spall.2.body=roller", "spall.2.roller=1")
    with command_served(*sets("support.kind=housing", *spalls)) as (_, address):
        for width, controls_at in ((1280, "0"), (390, "document.querySelector('#mass_kg').offsetTop - 500")):
            with open_page(browser, address, width, color_scheme="dark") as page:
                wait_for_frames(page)
                page.evaluate(f"window.scrollTo(0, {controls_at})")
                box = page.locator("#bearing").bounding_box()
                assert box["y"] >= -1.0 and box["y"] + box["height"] <= 800.0 and coloured(page, "#bearing") > 500
                grounds = page.locator("body, .card").evaluate_all(GROUNDS)
                assert max(int(part) for ground in grounds for part in re.findall(r"\d+", ground)) < 60
                bodies = page.evaluate("live.bearing().spalls.map(spall => spall.body)")
                assert bodies == ["outer_ring", "inner_ring", "roller"]


@pytest.mark.slow  # another server and page
def test_the_page_says_when_the_program_has_ended(browser):
    with ExitStack() as held:
        with command_served() as (_, address):
            page = held.enter_context(open_page(browser, address))
            wait_for_frames(page, 1)
        page.locator("#ended").wait_for()
        assert "The program or the connection has ended" in page.locator("#ended").inner_text()
