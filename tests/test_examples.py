"""Commented scenes, standard bearings, the schema: what a newcomer begins with."""

import json
import tomllib
from math import asin, pi
from typing import get_args

import pytest

from fem.commands.run_fem import EXAMPLES, run_main
from lagrange.catalogue import bearing_keys, designations, inner_ring_and_shaft
from lagrange.scene.keys import key_tables
from lagrange.scene.scene import Scene, SceneError, parse_scene, read_scene
from lagrange.scene.surfaces import SURFACES
from tests.measurements import DOCS, markdown_table

BEARING_COLUMNS = {
    "bore_diameter_mm": "bore, mm",
    "outside_diameter_mm": "outside, mm",
    "inner_raceway_diameter_mm": "inner raceway, mm",
    "clearance_um": "clearance, µm",
    "rollers": "rollers",
    "roller_diameter_mm": "their diameter, mm",
    "roller_length_mm": "their length, mm",
}


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


@pytest.mark.parametrize("name", designations())
def test_a_standard_bearing_is_a_bearing(name):
    scene = read_scene(None, (f"bearing.designation={name}",))
    bearing, keys = scene.ideal_bearing(), bearing_keys(name)
    assert scene.name == name
    assert 2e6 * bearing.radial_clearance == pytest.approx(keys["clearance_um"])
    assert scene.operation.inner_ring_and_shaft_kg == inner_ring_and_shaft(name) > bearing.inner_ring_mass
    most = pi / asin(bearing.roller_radius / bearing.pitch_radius)
    assert 0.75 * most < bearing.n_rollers < 0.85 * most
    assert parse_scene(tomllib.loads(scene.to_toml()), "again") == scene


def test_the_page_of_bearings_has_the_catalogues_values():
    """docs/bearings.md; to write it anew: print what this compares."""
    rows = []
    for name in designations():
        keys = bearing_keys(name)
        sizes = [f"{keys[key]:g}" for key in BEARING_COLUMNS]
        rows.append([name, *sizes, f"{inner_ring_and_shaft(name):g}"])
    assert markdown_table(["", *BEARING_COLUMNS.values(), "inner ring and shaft, kg"], rows) in (
        DOCS / "bearings.md"
    ).read_text(encoding="utf-8")


# kN, SKF's General Catalogue (2006), pages 522 to 537; those of its class Explorer rate better steel
DYNAMIC_RATINGS = {"NU204": 25.1, "NU205": 28.6}
EXPLORER_RATINGS = {
    "NU206": 44.0, "NU207": 56.0, "NU208": 62.0, "NU209": 69.5, "NU210": 73.5, "NU211": 96.5, "NU212": 108.0,
    "NU213": 122.0, "NU214": 137.0, "NU215": 150.0, "NU216": 160.0,
}  # fmt: skip


def dynamic_rating(name):
    """ISO 281, kN: b_m f_c L^(7/9) Z^(3/4) D^(29/27), b_m = 1.1, f_c by the formula that its table is made of."""
    keys = bearing_keys(name)
    length, rollers, diameter = (keys[key] for key in ("roller_length_mm", "rollers", "roller_diameter_mm"))
    share = diameter / (keys["inner_raceway_diameter_mm"] + diameter)
    rings = (1.04 * ((1.0 - share) / (1.0 + share)) ** (143 / 108)) ** (9 / 2)
    factor = 207.9 * 0.83 * share ** (2 / 9) * (1.0 - share) ** (29 / 27) / (1.0 + share) ** 0.25
    factor *= (1.0 + rings) ** (-2 / 9)
    return 1.1e-3 * factor * length ** (7 / 9) * rollers**0.75 * diameter ** (29 / 27)


def test_the_estimates_reproduce_the_dynamic_ratings():
    """Rollers' number and length were found from static ratings alone."""
    for name, rating in DYNAMIC_RATINGS.items():
        assert dynamic_rating(name) == pytest.approx(rating, rel=0.01)
    assert {*DYNAMIC_RATINGS, *EXPLORER_RATINGS} == set(designations())
    better = [rating / dynamic_rating(name) for name, rating in EXPLORER_RATINGS.items()]
    assert max(better) - min(better) < 0.02 and min(better) > 1.13


def test_bearings_with_the_same_rollers_have_them_equally_long():
    for one, other in (("NU204", "NU205"), ("NU209", "NU210")):
        one, other = bearing_keys(one), bearing_keys(other)
        assert one["roller_diameter_mm"] == other["roller_diameter_mm"]
        assert one["roller_length_mm"] == other["roller_length_mm"]


@pytest.mark.parametrize(
    ("written", "clearance"),
    [("NU 206", 32.5), ("nu206", 32.5), ("NU206ECP", 32.5), ("NU 206 ECP/C3", 47.5), ("NU206-C2", 12.5),
     ("NU206ECJ/C4", 62.5), ("NU206EC5", 82.5), ("NU206/CN", 32.5)],
)  # fmt: skip
def test_a_designation_is_known_as_people_write_it(written, clearance):
    """Clearances: the middles of ISO 5753-1's groups for bores over 24 up to 30 mm."""
    scene = read_scene(None, (f"bearing.designation='{written}'",))
    assert scene.name == "NU206" and scene.bearing.bore_diameter_mm == 30.0
    assert 2e6 * scene.ideal_bearing().radial_clearance == pytest.approx(clearance)
    assert parse_scene(tomllib.loads(scene.to_toml()), "again") == scene


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
        (["designation=NU306"], "'NU306': not in the table; known are NU204"),
        (["designation='6205'"], "of another bearing leave it out and give rollers, roller_diameter_mm"),
        (["designation=XYZ"], "known are NU204"),
        (["designation=NU206", "type=ball"], "a roller bearing"),
    ],
)
def test_bearings_that_contradict_themselves_are_refused(settings, words):
    with pytest.raises(SceneError, match="bearing") as caught:
        read_scene(None, tuple(f"bearing.{setting}" for setting in settings))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("setting", "likely"),
    [
        ("speed_rpm=0", "did you mean operation.speed_rpm?"),
        ("rollers=9", "did you mean bearing.rollers or bodies.rollers?"),
        ("numerics.radial_load_N=3", "did you mean operation.radial_load_N?"),
    ],
)
def test_a_key_of_another_table_is_named_with_it(setting, likely):
    with pytest.raises(SceneError) as caught:
        read_scene(None, (setting,))
    assert likely in str(caught.value) and len(str(caught.value).splitlines()) == 1


def test_the_schema_knows_every_key_and_no_other(capsys):
    assert run_main(["--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["additionalProperties"] is False
    assert set(schema["properties"]) == set(Scene.model_fields)
    speed = schema["$defs"]["OperationTable"]["properties"]["speed_rpm"]
    assert (speed["type"], speed["default"], speed["maximum"]) == ("number", 4500.0, 200_000.0)
    assert schema["properties"]["model"]["enum"] == list(get_args(Scene.model_fields["model"].annotation))
    assert "content" not in schema["$defs"]["ProfileTable"]["properties"]  # no key of the file
