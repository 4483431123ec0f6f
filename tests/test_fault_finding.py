"""Spalls found from trajectories alone: the parts against known geometry, and whole searches of short runs."""

import json
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from fem.commands.run_fem import run_main
from fem.solver.simulate import make_plan
from lagrange.errors import InputError
from lagrange.scene.scene import read_scene
from lagrange.surface.edges import Circles, sinkage
from lagrange.surface.faults import Spall
from residual import fault_finding
from residual.cli import main
from residual.fault_finding import Place, SinkageMap, ThreeSamples, find_faults, roller_motion
from residual.figures import save
from residual.figures.run import search
from residual.findings import reported_angle, search_sentences, unseen, unseen_in_words
from residual.record import Record
from tests.reference.kit import PAPER, RUNNING, sets, whole_run

OUTER = Place(body="outer_ring", roller=None, radius=28e-3)
PLACES = ("inner_x", "inner_y", "roller_x", "roller_y")


def recorded(*settings, noise=0.0, milliseconds=40):
    """Record of a run of the reduced model: trajectories only, by its own integration of the rollers' spins."""
    sampled = "numerics.output_interval_us=10", f"numerics.duration_ms={milliseconds}"
    scene = read_scene(None, ("model=reduced", *sampled, *settings))
    found, rng = whole_run(make_plan(scene)), np.random.default_rng(5)
    values = {name: found[name] + noise * rng.standard_normal(found[name].shape) for name in PLACES}
    turn = cumulative_trapezoid(found["roller_spin"], found["time"], axis=0, initial=0.0)
    return Record(name="run", source="run.nc", scene=scene, time=found["time"], roller_turn=turn, **values)


@pytest.mark.parametrize(("meeting", "own", "sign"), [("bore", 28e-3, -1.0), ("outside", 18e-3, 1.0)])
@pytest.mark.parametrize("width", [0.3e-3, 1e-3, 3e-3])
def test_a_roller_sinks_over_an_edge_as_the_closed_profile_says(meeting, own, sign, width):
    """`lagrange.surface.edges` closes the profile point by point; the search has a closed form."""
    spall = Spall(body="outer_ring", roller=None, angle=0.0, width=width, depth=1e-3, edge_radius=1e-4)
    half = spall.half_opening(5e-3)
    along = np.linspace(0.0, half, 50)
    expected = sinkage(spall, Circles(own, 5e-3, meeting, 5e-3), along / own)
    found = fault_finding.edge_sinkage(half - along, 5e-3, own, sign)
    np.testing.assert_allclose(found, expected, rtol=0.03, atol=0.01 * expected.max())


def flat_motion(aside, inner, outer):
    """One roller's motion along circles at rest: how far beside the pitch circle, and overlaps, (n,), m; no pull."""
    none = np.zeros((aside.size, 1))
    names = "outer_angle", "inner_angle", "inner_turn", "outer_turn", "roller_turn"
    return fault_finding.RollerMotion(
        bearing=PAPER, operation=replace(RUNNING, gravity=0.0), law=lambda overlap: 4e8 * overlap, load=none.T[[0, 0]],
        interval=1e-5, rho=PAPER.pitch_radius + aside[:, None], inner=inner[:, None], outer=outer[:, None],
        **dict.fromkeys(names, none))  # fmt: skip


@pytest.mark.parametrize("amplitude", [0.0, 1e-6])
def test_three_samples_tell_how_deep_a_surface_lies_under_a_roller_that_rattles(amplitude):
    """Against the exact vibration of a mass between two springs, the outer 2 µm deeper: nothing is missed once the
    sinkage is right.

    Up to 0.1 of the amplitude: leapfrog's vibration is 2 % too fast, over two half periods.
    """
    phase = np.sqrt(2.0 * 4e8 / PAPER.roller_mass) * 1e-5
    aside = 1e-6 + amplitude * np.cos(phase * np.arange(60) + 0.3)
    motion = flat_motion(aside, 5e-6 - aside, 5e-6 + aside)
    samples = ThreeSamples(motion, np.arange(1, 59), np.zeros(58, dtype=int))
    assert motion.stride == 1 and np.abs(samples.over([], (0.0, 2e-6))).max() < 0.1 * amplitude + 1e-12
    share = 2.0 * (1.0 - np.cos(phase))
    np.testing.assert_allclose(samples.over([])[0], share * 1e-6, rtol=0.03, atol=0.1 * amplitude)
    # in flight between both contacts, without a pull, it goes straight on and misses nothing
    aside = 1e-6 * np.linspace(-1.0, 1.0, 20)
    samples = ThreeSamples(flat_motion(aside, -5e-6 - aside, -5e-6 + aside), np.arange(1, 19), np.zeros(18, dtype=int))
    assert np.abs(samples.over([])).max() < 1e-15


TWO = [("outer_ring", None, 15.0, 0.6), ("inner_ring", None, 100.0, 1.2)]


@pytest.mark.parametrize("spalls", [
    pytest.param([("outer_ring", None, 20.0, 0.6)], id="outer ring"),
    pytest.param([("roller", 4, 140.0, 0.8)], id="roller"),
    pytest.param([("inner_ring", None, -75.0, 0.6)], id="inner ring", marks=pytest.mark.slow),
    pytest.param(TWO, id="two", marks=pytest.mark.slow),
])  # fmt: skip
def test_spalls_are_found_in_noise_on_their_own_bodies_and_drawn(spalls, tmp_path):
    """Within what docs/fault_finding.md states of random runs: 1° and 10 % of the width; body, roller, degrees, mm."""
    settings = []
    for k, (body, roller, angle, width) in enumerate(spalls):
        settings += [f"spall.{k}.body={body}", f"spall.{k}.angle_deg={angle}", f"spall.{k}.width_mm={width}"]
        settings += [] if roller is None else [f"spall.{k}.roller={roller}"]
    searched = find_faults(recorded(*settings, noise=10e-9))
    save(search(searched), tmp_path)
    assert (tmp_path / "fault_search.png").stat().st_size > 10_000
    assert len(searched.found) == len(spalls) and not searched.says_more
    found = {(each.place.body, each.place.roller): each for each in searched.found}
    for body, roller, angle, width in spalls:
        told = found[body, roller]
        off = abs(reported_angle(told.place, told.angle) - angle)
        assert off < 1.0 and told.width == pytest.approx(1e-3 * width, rel=0.1)
        if len(spalls) == 1:
            assert off < 1.5 * np.degrees(told.angle_error) and abs(told.width - 1e-3 * width) < 1.5 * told.width_error
    assert len(spalls) == 1 or "No other spall found" in " ".join(search_sentences(searched))


SOUND = {
    "perfect": (), "wavy ring": ("waviness.0.order=16", "waviness.0.amplitude_um=0.8"), "wavy and unequal rollers":
    ("waviness.0.body=roller", "waviness.0.roller=2", "waviness.0.order=5", "unequal_roller.0.roller=7"),
}  # fmt: skip


@pytest.mark.parametrize("surfaces", SOUND)
def test_surfaces_without_a_spall_have_none(surfaces):
    made = find_faults(recorded(*SOUND[surfaces], noise=10e-9))
    assert made.found == () and "No spall found" in search_sentences(made)[0]


def test_the_search_sees_neither_surfaces_nor_forces_and_refuses_what_stands_or_is_sampled_too_coarsely():
    """What it finds is the same to the last digit with the scene's tables and forces as without and with wrong ones."""
    told = recorded("spall.0.width_mm=0.5", "spall.0.angle_deg=10", milliseconds=30)
    keys = "model=reduced", "numerics.duration_ms=30"
    plain, wrong = read_scene(None, keys), read_scene(None, (*keys, "spall.0.body=inner_ring"))
    forces = np.full_like(told.roller_x, 1e3)
    misled = replace(told, scene=wrong, inner_force=forces, outer_force=forces, attributes={"faults": "[]"})
    (first,) = find_faults(told).found
    for record in (replace(told, scene=plain), misled):
        (found,) = find_faults(record).found
        np.testing.assert_array_equal(found.spall, first.spall)
        assert (found.angle_error, found.width_error) == (first.angle_error, first.width_error)
    assert roller_motion(told).bearing == roller_motion(replace(told, scene=plain)).bearing
    rolled = roller_motion(replace(told, roller_turn=None)).roller_turn  # of a table: on the outer raceway
    np.testing.assert_allclose(rolled[:1000], told.roller_turn[:1000], atol=2e-3)
    operation = plain.operation.model_copy(update={"speed_rpm": 0.0})
    with pytest.raises(InputError, match="the bearing stands"):
        find_faults(replace(told, scene=plain.model_copy(update={"operation": operation})))
    with pytest.raises(InputError, match=r"mm from sample to sample.*store more often"):
        find_faults(replace(told.samples(slice(None, None, 10)), roller_turn=None))


def test_only_the_deepest_place_of_a_map_that_stands_out_does_and_arcs_that_were_not_seen_are_told_as_scenes_count():
    """Of a ring from the load's direction: NaN from +x to +y is 90° to 180°; across ±180° it is cut in two."""
    angle = 2.0 * np.pi * (np.arange(3000) + 0.5) / 3000
    height = 1e-6 * np.cos(40 * angle)
    assert SinkageMap(place=OUTER, height=height).deepest[1] == pytest.approx(1.0, rel=0.01)
    height[1200:1210] = 8e-6
    where, ratio = SinkageMap(place=OUTER, height=height).deepest
    assert ratio == pytest.approx(8.0, rel=0.01) and where == pytest.approx(angle[1200], abs=0.01)

    height = np.where(np.arange(360) < 90, np.nan, 0.0)
    assert unseen(SinkageMap(place=OUTER, height=height)) == [(90.0, 180.0)]
    assert unseen(SinkageMap(place=OUTER, height=np.roll(height, 45))) == [(-180.0, -135.0), (135.0, 180.0)]
    roller = Place(body="roller", roller=3, radius=5e-3)
    assert unseen(SinkageMap(place=roller, height=height)) == [(0.0, 90.0)]
    assert reported_angle(OUTER, radians(-90.0)) == pytest.approx(0.0)
    height = np.where(np.arange(360) % 10 < 5, np.nan, 0.0)  # every 10° an arc of 5°
    height[90:130] = np.nan  # from the load's direction 180 to 225°, cut in two at ±180°
    told = unseen_in_words(SinkageMap(place=OUTER, height=height))
    assert told.count(" to ") == 4 and "−180 to −135°" in told and told.endswith("; and 28 shorter arcs)")
    assert unseen_in_words(SinkageMap(place=OUTER, height=np.zeros(360))) == ""


@pytest.mark.usefixtures("plain_report")
def test_the_command_prints_and_writes_what_it_found(tmp_path, capsys):
    path, folder = tmp_path / "run.nc", tmp_path / "run-residual"
    spalled = "numerics.output_interval_us=10", "spall.0.width_mm=0.6", "spall.0.angle_deg=20"
    assert run_main([*sets("model=reduced", *spalled), "--duration", "20", "--output", str(path), "--quiet"]) == 0
    assert main([str(path), "--find-faults"]) == 0
    assert "Found a spall on the outer ring" in capsys.readouterr().out
    (spall,) = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["faults"]
    (left, right), (low, high) = spall["angle_interval_deg"], spall["width_interval_mm"]
    assert (spall["body"], spall["roller"]) == ("outer_ring", None) and left < 20.0 < right and low < 0.6 < high
    assert '<h2 id="spalls">' in (folder / "report.html").read_text(encoding="utf-8")
    assert main([str(path), "--quiet"]) == 0
    assert "faults" not in json.loads((folder / "summary.json").read_text(encoding="utf-8"))
