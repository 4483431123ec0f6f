"""The scene's [[spall]], [[waviness]] and [[unequal_roller]]: units, faults, overrides, round trip."""

from math import pi, radians

import pytest

from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from lagrange.surface.faults import Spall, UnequalRoller, Waviness
from tests.reference.refusals import assert_refused, refusal

ALL = """
[[spall]]
body = "outer_ring"
angle_deg = 10.0
width_mm = 2.0
depth_um = 50.0
edge_radius_mm = 0.2

[[spall]]
body = "roller"
roller = 3

[[waviness]]
order = 14
phase_deg = 30.0

[[unequal_roller]]
roller = 5
diameter_deviation_um = -2.0
"""


def test_surfaces_in_si():
    """Angles of rings count from the load direction, −y, those of rollers in their own frame."""
    first, second, wave, unequal = parse_scene_text(ALL, "s").ideal_bearing().faults
    assert isinstance(first, Spall) and isinstance(wave, Waviness)
    assert first.angle == pytest.approx(radians(10.0) - pi / 2)
    assert (first.width, first.depth, first.edge_radius) == pytest.approx((2e-3, 50e-6, 0.2e-3))
    assert (second.body, second.roller, second.angle) == ("roller", 3, 0.0)
    # a crest of the wave lies where 14·(angle from the load) + 30° = 0
    assert wave.order * (radians(-30.0 / 14.0) - pi / 2) + wave.phase == pytest.approx(0.0, abs=1e-12)
    assert unequal == UnequalRoller(roller=5, diameter_deviation=pytest.approx(-2e-6))


def test_round_trip_and_absent_tables():
    scene = parse_scene_text(ALL, "s")
    assert parse_scene_text(scene.to_toml(), "again") == scene
    assert not any(word in Scene().to_toml() for word in ("spall", "waviness", "unequal"))
    assert Scene().ideal_bearing().faults == ()


def test_overrides_reach_tables_by_their_number():
    scene = read_scene(None, ("spall.0.width_mm=2", "spall.1.angle_deg=20.0", "spall.0.depth_um=30"))
    assert [(spall.width_mm, spall.depth_um, spall.angle_deg) for spall in scene.spall] == [
        (2.0, 30.0, 0.0), (1.0, 100.0, 20.0),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("override", "word"),
    [
        ("spall.0=2", "must be a table, [[spall]]"),
        ("spall.width_mm=2", "[[spall]]"),
        (f"spall.{'9' * 5000}.width_mm=2", "none of 0 tables"),
    ],
)
def test_overrides_that_miss_are_refused(override, word):
    assert_refused([override], "spall", word)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[spal]]", ["spal", "did you mean spall?"]),
        ("spall = 3", ["spall = 3", "[[spall]]"]),
        ('[[spall]]\nbody = "cage"', ["spall.0.body = 'cage'", "'outer_ring', 'inner_ring' or 'roller'"]),
        ('[[spall]]\nbody = "roller"', ["roller = 0"]),
        ("[[spall]]\nroller = 3", ["spall.0", "roller = 3", 'only with body = "roller"']),
        ("[[unequal_roller]]\nroller = 13", ["unequal_roller.0.roller = 13", "from 0 to 12"]),
        ("[[unequal_roller]]\n[[unequal_roller]]", ["roller = 0", "2 times"]),
        ("[[spall]]\nwidth_mm = 9.0", ["spall.0.width_mm = 9", "at most 8"]),
        ("[[spall]]\nwidth_mm = 0.01", ["spall.0.width_mm = 0.01", "at least 0.0176"]),
        ("[[spall]]\ndepth_um = 4600.0", ["spall.0.depth_um = 4600", "through the body"]),
        ("[[spall]]\nangle_deg = 359\n[[spall]]", ["spall.0 and spall.1 overlap", "1 degrees", "2.07"]),
        ("[[waviness]]\norder = 1000", ["waviness.0.amplitude_um = 0.5", "order = 1000", "valleys"]),
        ("[[waviness]]\namplitude_um = 51.0", ["amplitude_um = 51", "at most 50"]),
        ("[[unequal_roller]]\ndiameter_deviation_um = -51.0", ["= -51", "at most 50"]),
        ('[[waviness]]\n[contact]\nmodel = "penalty"', ["[[waviness]]", '"penalty"']),
        ('[lubricant]\n[bearing]\ntype = "ball"', ["[lubricant]", "of line contacts"]),
        ("[[spall]]\n" * 201, ["spall = [", "at most 200"]),
    ],
)
def test_every_fault_is_named(text, words):
    assert_refused(text, *words)


def test_faults_of_several_tables_are_told_at_once():
    message = refusal('[[spall]]\nwidth_mm = "a"\n[[spall]]\nroller = 1\nz = 3\n[operation]\nspeed_rpm = true')
    for words in ("spall.0.width_mm = 'a'", "spall.1.z: unknown key", "spall.1: roller = 1", "operation.speed_rpm"):
        assert words in message


def test_spalls_of_different_bodies_do_not_overlap():
    text = '[[spall]]\n[[spall]]\nbody = "inner_ring"\n[[spall]]\nbody = "roller"\nroller = 0\n'
    text += '[[spall]]\nbody = "roller"\nroller = 1'
    assert len(parse_scene_text(text, "s").spall) == 4
