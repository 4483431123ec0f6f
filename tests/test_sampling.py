"""The interval between samples that a scene gets which gives none."""

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from lagrange.step_size import SAMPLES_OF_ROLLERS, SAMPLES_OF_THE_HUB, hub_frequency, roller_frequency
from residual.evaluation import evaluate
from residual.sources import read_result

NU206 = 'bearing={designation="NU206"}'
SPALL = "spall.0.angle_deg=14"
SLOW = {"bearing.designation": "NU310", "bearing.clearance_um": 0.0}  # heavy rollers
STRUCK = [("bearing.clearance_um=1",), (SPALL,), (NU206,)]
FOLDED = [(NU206, "bearing.clearance_um=0"), (NU206, "bearing.clearance_um=-5")]


def interval(*settings):
    return read_scene(None, settings).numerics.output_interval_us


def test_the_papers_scene_keeps_its_ten_microseconds():
    assert interval() == 10.0 and Scene().numerics.output_interval_us == 10.0
    assert interval("bearing.clearance_um=-5") == 10.0
    assert interval(NU206, "numerics.output_interval_us=20") == 20.0, "one that is given stays"
    still = ("operation.speed_rpm=0", "operation.radial_load_N=0", "operation.gravity_m_s2=0")
    assert interval(*still) == interval("bearing.clearance_um=20", *still) == 10.0, "nothing presses"


@pytest.mark.parametrize("struck", STRUCK + FOLDED)
def test_rollers_that_are_struck_or_would_be_folded_are_followed(struck):
    scene = read_scene(None, struck)
    found = 1e-6 * scene.numerics.output_interval_us
    frequency = roller_frequency(scene.perfect_bearing(), scene.ideal_operation())
    assert found < 1e-5 and found * frequency * SAMPLES_OF_ROLLERS <= 1.0


def test_a_light_hub_on_stiff_contacts_is_followed():
    light = "material.inner_ring.density_kg_m3=500", "operation.inner_ring_and_shaft_kg=0.004"
    scene = read_scene(None, light)
    hub = hub_frequency(scene.perfect_bearing(), scene.ideal_operation())
    assert 1e-6 * scene.numerics.output_interval_us * hub * SAMPLES_OF_THE_HUB <= 1.0 < 1e-5 * hub * SAMPLES_OF_THE_HUB


def test_the_scene_in_a_result_spells_it_out_and_a_varied_one_gets_its_own():
    scene = read_scene(None, (NU206,))
    again = parse_scene_text(scene.to_toml(), "again")
    assert again == scene and "output_interval_us = 5.0" in scene.to_toml()
    assert scene.varied(SLOW).numerics.output_interval_us == 10.0


def test_a_table_that_is_not_at_hand_leaves_the_default(tmp_path):
    (tmp_path / "load.csv").write_text("time_ms,x_N,y_N\n0,0,-9\n100,0,-9\n", encoding="utf-8")
    (tmp_path / "a.toml").write_text('operation.load_table = "load.csv"\nbearing.clearance_um = 20', encoding="utf-8")
    scene = read_scene(tmp_path / "a.toml")
    assert scene.numerics.output_interval_us == 5.0
    text = scene.to_toml().replace("output_interval_us = 5.0\n", "")
    assert parse_scene_text(text, "without files").numerics.output_interval_us == 10.0


def test_frequencies_are_those_of_palmgrens_contacts():
    """By hand: d = 3.84e-5 Q^0.9 / L^0.8 in mm, both contacts alike; the hub's is docs/supports.md's."""
    scene = read_scene()
    bearing, operation = scene.perfect_bearing(), scene.ideal_operation()
    ideal = kinematics(bearing, operation.speed)
    force = 5.0 * (2000.0 + 0.078 * 9.81) / 13 + bearing.roller_mass * (9.81 + bearing.pitch_radius * ideal.cage**2)
    stiffness = force / (0.9 * 1e-3 * 3.84e-5 * force**0.9 / 10.0**0.8)
    wanted = np.sqrt(2.0 * stiffness / bearing.roller_mass) / (2.0 * np.pi)
    assert roller_frequency(bearing, operation) == pytest.approx(wanted, rel=0.1)
    assert hub_frequency(bearing, operation) == pytest.approx(13.7e3, rel=0.1)


def test_without_clearance_defaults_are_not_said_to_fold(tmp_path):
    slow = "--set operation.speed_rpm=1500 --set operation.radial_load_N=3000 --set bearing.clearance_um=0".split()
    options = ["--bearing", "NU2206", "--model", "reduced", "--duration", "30", *slow, "--quiet"]
    for name, given in (("default", []), ("coarse", ["--set", "numerics.output_interval_us=10"])):
        assert run_main([*options, *given, "--output", str(tmp_path / f"{name}.nc")]) == 0
        notes = evaluate(read_result(tmp_path / f"{name}.nc")).notes
        assert any("aliased" in note for note in notes) == bool(given)


def test_an_nu_206_by_defaults_is_within_what_differentiation_errs_by(tmp_path):
    path = tmp_path / "a.nc"
    options = ["--bearing", "NU206", "--duration", "12", "--mesh-size", "2", "--quiet"]
    assert run_main([*options, "--output", str(path)]) == 0
    found = evaluate(read_result(path))
    assert not any("aliased" in note for note in found.notes)
    for direction, floor in zip(found.directions, found.floors, strict=True):
        assert direction.balance.rms < floor
