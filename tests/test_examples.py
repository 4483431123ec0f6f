"""Commented scenes, standard bearings, the schema: what a newcomer begins with."""

import json
from typing import get_args

import numpy as np
import pytest

from fem.commands.run_fem import EXAMPLES, run_main
from lagrange.kinematics import kinematics
from lagrange.scene.keys import key_tables
from lagrange.scene.scene import Scene, parse_scene, read_scene
from lagrange.scene.surfaces import SURFACES
from tests.reference.refusals import assert_refused, refusal


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_written_can_be_read_and_is_not_written_over(name, here, capsys):
    assert run_main(["--example", name]) == 0
    assert f"{name}.toml" in capsys.readouterr().out
    scene = read_scene(here / f"{name}.toml")
    assert scene.name == (name if name != "all" else "paper")
    text = (here / f"{name}.toml").read_text(encoding="utf-8")
    assert text.startswith("# ") and max(map(len, text.splitlines())) <= 120
    (here / f"{name}.toml").write_text("mine", encoding="utf-8")
    assert run_main(["--example", name]) == 2
    assert (here / f"{name}.toml").read_text(encoding="utf-8") == "mine"
    assert run_main(["--example", name, "--output", "sub/other.toml"]) == 0
    assert read_scene("sub/other.toml") == scene


@pytest.mark.parametrize("name", ["paper", "all"])
def test_the_papers_scene_and_that_of_every_key_are_the_default_one(name, here):
    run_main(["--example", name])
    assert read_scene(f"{name}.toml") == Scene()


def test_every_key_and_table_of_the_scene_is_described(here):
    tables = key_tables()
    named = {table.name for table in tables}
    assert {"", "operation", "material.roller", "spall", "table"} <= named
    undescribed = [f"{table.name}.{key.name}" for table in tables for key in table.keys if not key.meaning]
    undescribed += [f"[{table.name}]" for table in tables if not table.meaning]
    assert not undescribed, "Field(..., description=...) of the key, or the docstring of the table's class"
    run_main(["--example", "all"])
    lines = (here / "all.toml").read_text(encoding="utf-8").splitlines()
    for key in (key for table in tables for key in table.keys):
        assert any(line.removeprefix("# ").startswith(f"{key.name} =") for line in lines), key.name


def test_keys_are_told_with_unit_and_limits():
    keys = {f"{table.name}.{key.name}": key for table in key_tables() for key in table.keys}
    speed, size = keys["operation.speed_rpm"], keys["numerics.mesh_size_mm"]
    assert (speed.unit, speed.default, speed.limits) == ("rpm", 4500.0, "from -200 000 to 200 000")
    assert (size.unit, size.limits) == ("mm", "above 0 to 100")
    assert keys["support.damping_N_s_m"].unit == "N s/m"
    assert keys["numerics.start"].limits == '"equilibrium", "rest"'
    assert keys["spall.width_mm"].default == 1.0 and keys["profile.file"].default is None


def test_the_fault_example_has_three_kinds_of_faults(here):
    run_main(["--example", "faults"])
    scene = read_scene("faults.toml")
    assert [name for name in SURFACES if getattr(scene, name)] == ["spall", "waviness", "unequal_roller"]


def test_keys_given_win_over_the_catalogues():
    scene = read_scene(None, ("bearing.designation=NU206", "bearing.rollers=12", "bearing.clearance_um=10", "name=own"))
    assert (scene.bearing.rollers, scene.name) == (12, "own")
    assert scene.bearing.outer_raceway_diameter_mm == pytest.approx(55.51)
    scene = read_scene(None, ("bearing.designation=NU206", "bearing.outer_raceway_diameter_mm=55.53"))
    assert scene.bearing.outer_raceway_diameter_mm == 55.53


def test_the_option_puts_a_standard_bearing_in_place_of_the_scenes(here, capsys):
    run_main(["--example", "paper"])
    settings = ["--set", "bearing.clearance_um=20", "--set", "operation.inner_ring_and_shaft_kg=1"]
    assert run_main(["paper.toml", "--bearing", "NU206", *settings, "--model", "lagrange", "--dry-run"]) == 0
    assert "20.000 µm" in capsys.readouterr().out


def test_a_clearance_is_another_way_to_give_the_outer_raceway():
    for given, diameter in ((25.0, 56.025), (0, 56.0), (-10.0, 55.99)):
        assert parse_scene({"bearing": {"clearance_um": given}}, "s").bearing.outer_raceway_diameter_mm == diameter
    ball = parse_scene({"bearing": {"type": "ball", "clearance_um": 12.0}}, "s")
    assert 2e6 * ball.ideal_bearing().radial_clearance == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["clearance_um=20", "outer_raceway_diameter_mm=56.0"], "clearance_um = 20 and outer_raceway_diameter_mm = 56"),
        (["clearance_um=-300"], "preload"),
        (["clearance_um=3000"], "too large"),
        (["clearance_um=wide"], "bearing.clearance_um = 'wide'"),
        (["designation=NU402"], "of another bearing leave it out and give rollers, roller_diameter_mm"),
        (["designation=NU206", "type=ball"], "'NU206': not with type = \"ball\""),
        (["designation='6205'", "type=roller"], "'6205': not with type = \"roller\""),
    ],
)
def test_bearings_that_contradict_themselves_are_refused(settings, words):
    assert_refused([f"bearing.{setting}" for setting in settings], "bearing", words)


@pytest.mark.parametrize(
    ("setting", "likely"),
    [
        ("speed_rpm=0", "did you mean operation.speed_rpm?"),
        ("rollers=9", "did you mean bearing.rollers or bodies.rollers?"),
        ("numerics.radial_load_N=3", "did you mean operation.radial_load_N?"),
    ],
)
def test_a_key_of_another_table_is_named_with_it(setting, likely):
    told = refusal([setting])
    assert likely in told and len(told.splitlines()) == 1


def test_the_schema_knows_every_key_and_no_other(capsys):
    assert run_main(["--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == set(Scene.model_fields)
    speed = schema["$defs"]["OperationTable"]["properties"]["speed_rpm"]
    assert (speed["type"], speed["default"], speed["maximum"]) == ("number", 4500.0, 200_000.0)
    assert schema["properties"]["model"]["enum"] == list(get_args(Scene.model_fields["model"].annotation))
    assert "content" not in schema["$defs"]["ProfileTable"]["properties"]  # no key of the file


@pytest.mark.parametrize(
    ("name", "rpm"), [("NU206", 2900.0), ("NU206", 1800.0), ("spindle", 15000.0), ("faults", 4500.0)]
)
def test_an_example_lasts_long_enough_to_part_its_rings_lines_from_its_rollers(here, name, rpm):
    """Two lines are two peaks from twice the resolution on (Hann window)."""
    run_main(["--example", name])
    scene = read_scene(f"{name}.toml", (f"operation.speed_rpm={rpm}",))
    lines = kinematics(scene.ideal_bearing(), scene.ideal_operation().speed).frequencies
    gap = abs(np.subtract(2.0 * lines["BSF"], [lines["BPFO"], lines["BPFI"]])).min()
    assert 1e-3 * scene.numerics.duration_ms * gap >= 2.0
