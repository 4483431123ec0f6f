"""Entry, strike and exit of rollers over spalls: from made-up passages, from runs of every kind of solver."""

from dataclasses import replace
from math import asin, pi, sqrt

import h5py
import numpy as np
import pytest

from fem.result.checkpoint import checkpoint_path, save_checkpoint
from fem.result.store import ResultFile
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from lagrange.scene.scene import Scene, read_scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.passages import COLUMNS, Passage, find_passages, spall_events
from tests.reference.kit import whole_run

HALF = 0.01  # rad
RUNNING = Scene().ideal_operation()


def passage(force_of, interval=1e-6, first=-3.0, last=3.0):
    """Rolled over at HALF in 50 µs, from so many half-widths to so many; the force by the time from the middle, µs."""
    time = np.arange(round((last - first) * 50e-6 / interval) + 1) * interval
    angle = HALF * (first + time / 50e-6)
    force = np.array([force_of(50.0 * a / HALF) for a in angle])
    return Passage(spall=0, raceway="outer", roller=4, half_width=HALF, first=0, time=time, angle=angle, force=force,
                   sliding=0.0 * time)  # fmt: skip


def struck_at(t, peak=900.0, before=300.0):
    """Carries `before`, is released at −40 µs and struck at t by half a sine of 20 µs; 200 N rattle before."""

    def force(x):
        if x < -40.0:
            return before
        small = 200.0 * np.cos(pi * (x + 20.0) / 10.0) if abs(x + 20.0) < 5.0 else 0.0
        return max(small, peak * np.cos(pi * (x - t) / 20.0)) if abs(x - t) < 10.0 else small

    return force


@pytest.mark.parametrize("at", [0.0, 33.3, 61.0])
@pytest.mark.parametrize("interval", [1e-6, 2e-6])
def test_a_strike_is_the_first_large_peak_after_the_release(at, interval):
    found = {event.kind: event for event in spall_events([passage(struck_at(at), interval)])}
    assert list(found) == (["entry", "strike", "exit"] if at < 50.0 else ["entry", "exit", "strike"])
    assert [found[kind].time for kind in ("entry", "exit")] == pytest.approx([100e-6, 200e-6], abs=1e-12)
    assert found["entry"].force == pytest.approx(300.0)
    assert found["strike"].time == pytest.approx((150.0 + at) * 1e-6, abs=0.1e-6)
    assert found["strike"].force == pytest.approx(900.0, rel=0.01)


def test_no_strike_where_a_roller_is_not_released_turns_back_or_the_run_ends_before_it_is_known():
    struck, both = struck_at(30.0), ["entry", "exit"]
    cases = (
        (lambda x: 300.0 + 60.0 * np.sin(0.1 * x), {}, both), (lambda x: 0.0, {}, both),
        (lambda x: 300.0 if x < -40.0 else max(0.0, 900.0 - 50.0 * abs(x + 15.0)), {}, both),
        (struck, {"last": 1.9}, both), (struck, {"first": -0.9}, ["exit"]), (struck, {"last": 0.0}, ["entry"]),
    )  # fmt: skip
    for force, limits, kinds in cases:
        assert [event.kind for event in spall_events([passage(force, **limits)])] == kinds
    # who turns back leaves by the edge of the entry, and steps may be wider than the spall
    there_and_back = np.concatenate([np.linspace(-2.0, 0.5, 6), np.linspace(0.0, -2.0, 5)]) * HALF
    wide = HALF * np.array([-2.5, 2.5])
    for angle, times in ((there_and_back, [2.0, 8.0]), (wide, [0.3, 0.7])):
        row = np.ones(len(angle))
        found = spall_events([Passage(
            spall=0, raceway="inner", roller=0, half_width=HALF, first=0, time=np.arange(len(angle)) * 1.0, angle=angle,
            force=row, sliding=row)])  # fmt: skip
        assert [event.kind for event in found] == ["entry", "exit"]
        assert [event.time for event in found] == pytest.approx(times)


ONE = ("numerics.output_interval_us=2", "spall.0.width_mm=0.5")
WHERE = {
    "outer": ('spall.0.body="outer_ring"', "spall.0.angle_deg=1"),
    "inner": ('spall.0.body="inner_ring"', "spall.0.angle_deg=-2"),
    "roller": ('spall.0.body="roller"', "spall.0.roller=2", "spall.0.angle_deg=30"),
}


SPEED = 150.0 * pi  # rad/s, of the shaft, and what rolling without slip makes of it; the rollers' first angles
CAGE = 0.5 * SPEED * 18.0 / 23.0
SPIN, FIRST = -CAGE * 23.0 / 5.0, -0.5 * pi + 2.0 * pi * np.arange(13) / 13


def passages_of(bearing, operation, samples, count):
    def rows(start, stop):
        return {name: samples[name][start:stop] for name in COLUMNS}

    return find_passages(bearing, operation, rows, count)


def rolling(body, interval, count):
    """Passages of rollers that roll without slip on the pitch circle."""
    time = interval * np.arange(count)
    angle = FIRST + CAGE * time[:, None]
    samples = dict.fromkeys(COLUMNS, np.ones((count, 13))) | dict(
        time=time, inner_x=0.0 * time, inner_y=0.0 * time, roller_x=0.023 * np.cos(angle),
        roller_y=0.023 * np.sin(angle), roller_turn=SPIN * time[:, None] + 0.0 * angle,
        roller_spin=SPIN + 0.0 * angle)  # fmt: skip
    bearing = read_scene(None, (*ONE, *WHERE[body])).ideal_bearing()
    return passages_of(bearing, replace(RUNNING, speed=SPEED), samples, count)


def crossings(body, duration):
    """When which rollers cross the edges of the spall, rolling: half a width beside its middle; s, by time."""
    if body == "roller":
        ways = [(2, np.radians(30.0) - FIRST[2] - turned, CAGE - SPIN, 5e-3) for turned in (0.0, pi)]
    else:
        middle, turn, radius = (1.0, CAGE, 28e-3) if body == "outer" else (-2.0, CAGE - SPEED, 18e-3)
        ways = [(j, np.radians(middle) - 0.5 * pi - FIRST[j], turn, radius) for j in range(13)]
    found = []
    for j, away, turn, radius in ways:
        for lap in range(-10, 11):
            centre, half = (away + 2.0 * pi * lap) / turn, asin(0.25e-3 / radius) / abs(turn)
            found += [(t, j) for t in (centre - half, centre + half) if 0.0 <= t <= duration]
    return sorted(found)


@pytest.mark.parametrize("interval", [2e-6, 30e-6])
@pytest.mark.parametrize("body", WHERE)
def test_entries_and_exits_lie_half_a_width_beside_the_middle(body, interval):
    """On the geometry of rolling, typed in again: the outer ring stands, the inner one overtakes the rollers."""
    count = round(12e-3 / interval)
    events = [event for event in spall_events(rolling(body, interval, count)) if event.kind != "strike"]
    expected = crossings(body, (count - 1) * interval)
    assert len(events) == len(expected) > 6
    np.testing.assert_allclose([event.time for event in events], [t for t, _ in expected], atol=1e-10)
    assert [event.roller for event in events] == [j for _, j in expected]
    assert {event.raceway for event in events} == ({"inner", "outer"} if body == "roller" else {body})
    assert max(abs(event.sliding_speed) for event in events) < 1e-3  # 5 m/s are rolled over


@pytest.mark.parametrize("depth_um", [1000.0, 2.0])
def test_a_slow_light_roller_strikes_where_the_geometry_stops_it(depth_um):
    """Half the crossing of a deep spall; 1 − x/w on a flat bottom, x = √(2d/(1/r − 1/R)); Lagrangian model.

    Rollers are pressed by 20 times their weight, the hub lies on others, contacts are damped, a tenth of the speed.
    """
    scene = read_scene(None, (
        "model=lagrange", "spall.0.width_mm=1", f"spall.0.depth_um={depth_um}", "spall.0.angle_deg=29.2",
        "spall.0.edge_radius_mm=0", "operation.speed_rpm=450", "operation.radial_load_N=0",
        "operation.gravity_m_s2=200", "bearing.outer_raceway_diameter_mm=56.1", "numerics.duration_ms=3.5",
        "numerics.output_interval_us=2", "damping.contact_N_s_m=1000",
    ))  # fmt: skip
    plan = make_plan(scene)
    passages = passages_of(scene.ideal_bearing(), scene.ideal_operation(), whole_run(plan), plan.n_samples)
    found = {event.kind: event for event in spall_events(passages) if event.roller == 1}
    crossing = found["exit"].time - found["entry"].time
    assert crossing == pytest.approx(1e-3 / (0.5 * 450 * 2 * pi / 60 * 36.0 / 46.05 * 28.05e-3), rel=2e-3)
    share = max(0.5, 1.0 - sqrt(2e-6 * depth_um / (1.0 / 5e-3 - 1.0 / 28.05e-3)) / 1e-3)
    assert (found["strike"].time - found["entry"].time) / crossing == pytest.approx(share, abs=0.01)


SHORT = ("model=lagrange", *ONE, "spall.0.angle_deg=2", "numerics.duration_ms=0.34")


def everything(path):
    with h5py.File(path) as file:
        names = "inner_sinkage", "outer_sinkage", "roller_turn", *(f"events/{name}" for name in file["events"])
        return {name: file[name][:].tolist() for name in names}


def test_a_run_that_was_stopped_and_resumed_has_the_same_events(tmp_path):
    whole, broken, scene = tmp_path / "whole.nc", tmp_path / "broken.nc", read_scene(None, SHORT)
    run_scene(scene, whole, RunOptions(quiet=True))
    plan = make_plan(scene)
    state = plan.first_state()
    with ResultFile(broken, plan, 0.0) as store:
        while state.done < 85:  # 170 µs
            store.append(state.advance(85 - state.done).samples)
        store.commit()
        save_checkpoint(broken, state, store.stored)
        store.finish("interrupted")
    assert checkpoint_path(broken).is_file() and everything(broken)["events/kind"] == [b"entry"]
    run_scene(scene, broken, RunOptions(quiet=True, resume=True))
    assert everything(broken) == everything(whole)
    assert everything(whole)["events/kind"] == [b"entry", b"strike", b"exit"]


def test_sinkages_are_those_under_the_contacts_and_perfect_scenes_have_none(tmp_path):
    path = tmp_path / "run.nc"
    scene = read_scene(None, (*SHORT, 'waviness.0.body="roller"', "waviness.0.roller=5", "waviness.0.order=4"))
    run_scene(scene, path, RunOptions(quiet=True))
    surfaces = profiles(scene.ideal_bearing())
    with h5py.File(path) as file:
        theta, time = file["roller_theta"][:], file["time"][:]
        assert file["outer_sinkage"].attrs["units"] == "m"
        outer, inner = file["outer_sinkage"][:], file["inner_sinkage"][:]
        sinkage = surfaces.outer(theta, Turns(rollers=file["roller_turn"][:])).sinkage
        np.testing.assert_allclose(outer, sinkage, atol=1e-15)
        assert outer.max() == pytest.approx(5.14e-6, abs=0.3e-6)  # a gap of 0.5 mm, whose kink samples miss
        on_roller = theta[:, 5] + pi - file["roller_turn"][:, 5]
        np.testing.assert_allclose(inner[:, 5], -0.5e-6 * np.cos(4 * on_roller), atol=2e-9)
        assert not np.any(np.delete(inner, 5, axis=1)) and time[-1] == pytest.approx(0.34e-3)
    path = tmp_path / "perfect.nc"
    run_scene(read_scene(None, ("model=lagrange", "numerics.duration_ms=0.1")), path, RunOptions(quiet=True))
    with h5py.File(path) as file:
        assert not {"events", "inner_sinkage", "outer_sinkage", "roller_turn"} & set(file)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["fem", "reduced"])
@pytest.mark.parametrize("body", WHERE)
def test_elastic_bodies_enter_and_leave_where_rolling_says(model, body, tmp_path):
    """Within an output interval, 2 µs: creep is slower."""
    path = tmp_path / "run.nc"
    settings = (f"model={model}", "numerics.mesh_size_mm=2", "numerics.duration_ms=2", "waviness.0.amplitude_um=1e-6",
                "unequal_roller.0.diameter_deviation_um=1e-6")  # fmt: skip
    run_scene(read_scene(None, (*ONE, *WHERE[body], *settings)), path, RunOptions(quiet=True))
    with h5py.File(path) as file:
        events = {name: column[:] for name, column in file["events"].items()}
    edges, expected = events["kind"] != b"strike", crossings(body, 2e-3)
    assert edges.sum() == len(expected) > 1
    np.testing.assert_allclose(events["time"][edges], [t for t, _ in expected], atol=2e-6)
    assert events["roller"][edges].tolist() == [j for _, j in expected]
