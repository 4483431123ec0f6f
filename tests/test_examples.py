"""Commented scenes, standard bearings, the schema: what a newcomer begins with."""

import json
import math
import re
from typing import get_args

import numpy as np
import pytest

from fem.commands.run_fem import EXAMPLES, run_main
from fem.solver.simulate import make_plan
from lagrange import BallBearing
from lagrange.kinematics import kinematics
from lagrange.scene.keys import key_tables
from lagrange.scene.scene import Scene, SceneError, parse_scene, parse_scene_text, parse_stored_scene, read_scene
from lagrange.scene.surfaces import SURFACES, SpallTable
from tests.reference.kit import assert_refused, refusal


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_written_can_be_read_and_is_not_written_over(name, here, capsys):
    path = here / f"{name}.toml"
    assert run_main(["--example", name]) == 0 and f"{name}.toml" in capsys.readouterr().out
    scene, text = read_scene(path), path.read_text(encoding="utf-8")
    assert scene.name == (name if name != "all" else "paper")
    assert name not in ("paper", "all") or scene == Scene()
    assert name != "faults" or [kind for kind in SURFACES if getattr(scene, kind)] == list(SURFACES[:3])
    assert text.startswith("# ") and max(map(len, text.splitlines())) <= 120
    path.write_text("mine", encoding="utf-8")
    assert run_main(["--example", name]) == 2 and path.read_text(encoding="utf-8") == "mine"
    assert run_main(["--example", name, "--output", "sub/other.toml"]) == 0
    assert read_scene("sub/other.toml") == scene


def test_every_key_and_table_of_the_scene_is_described_with_unit_and_limits(here):
    tables = key_tables()
    keys = {f"{table.name}.{key.name}": key for table in tables for key in table.keys}
    assert {"", "operation", "material.roller", "spall", "table"} <= {table.name for table in tables}
    undescribed = [name for name, key in keys.items() if not key.meaning]
    undescribed += [f"[{table.name}]" for table in tables if not table.meaning]
    assert not undescribed, "Field(..., description=...) of the key, or the docstring of the table's class"
    run_main(["--example", "all"])
    text = (here / "all.toml").read_text(encoding="utf-8")
    assert [key.name for key in keys.values() if not re.search(rf"^(# )?{key.name} =", text, re.M)] == []
    speed, size = keys["operation.speed_rpm"], keys["numerics.mesh_size_mm"]
    assert (speed.unit, speed.default, speed.limits) == ("rpm", 4500.0, "from -200 000 to 200 000")
    assert (size.unit, size.limits) == ("mm", "above 0 to 100") and keys["support.damping_N_s_m"].unit == "N s/m"
    assert keys["numerics.start"].limits == '"equilibrium", "rest"'
    assert keys["spall.width_mm"].default == 1.0 and keys["profile.file"].default is None


def test_no_key_takes_a_value_beyond_its_limits_or_of_another_kind():
    for table, key in ((each, key) for each in key_tables() for key in each.keys):
        whole, beyond = isinstance(key.default, int), [{"a": "table"}, *["other"] * key.limits.startswith('"')]
        for word, text in re.findall(r"(from|above|to|below) (-?\d[\d .e+-]*)", key.limits):
            bound, way = float(text.replace(" ", "")), {"from": -1, "above": 0, "to": 1, "below": 0}[word]
            beyond.append(int(bound) + way if whole else bound + 1e-3 * way * max(abs(bound), 1e-3))
        place = ".".join([table.name, *(["0"] if table.many else []), key.name]).lstrip(".")
        for value in beyond if key.name not in ("clearance_um", "pitch_diameter_mm") else ():  # of a raceway
            given = {key.name: value}
            for part in reversed(table.name.split(".") if table.name else ()):
                given = {part: [given] if table.many else given}
            assert_refused(given, f"scene.toml: {place} = ", ": must be ")


def test_keys_given_win_over_the_catalogues_and_a_clearance_gives_the_outer_raceway(here, capsys):
    scene = read_scene(None, ("bearing.designation=NU206", "bearing.rollers=12", "bearing.clearance_um=10", "name=own"))
    assert (scene.bearing.rollers, scene.name, scene.operation.speed_rpm) == (12, "own", 4500.0)
    assert scene.bearing.outer_raceway_diameter_mm == pytest.approx(55.51)
    scene = read_scene(None, ("bearing.designation=NU206", "bearing.outer_raceway_diameter_mm=55.53"))
    assert scene.bearing.outer_raceway_diameter_mm == 55.53
    run_main(["--example", "paper"])
    settings = ["--set", "bearing.clearance_um=20", "--set", "operation.inner_ring_and_shaft_kg=1"]
    assert run_main(["paper.toml", "--bearing", "NU206", *settings, "--model", "lagrange", "--dry-run"]) == 0
    assert "20.000 µm" in capsys.readouterr().out
    for given, diameter in ((25.0, 56.025), (0, 56.0), (-10.0, 55.99)):
        assert parse_scene({"bearing": {"clearance_um": given}}, "s").bearing.outer_raceway_diameter_mm == diameter
    ball = parse_scene({"bearing": {"type": "ball", "clearance_um": 12.0}}, "s")
    assert 2e6 * ball.ideal_bearing().radial_clearance == pytest.approx(12.0)


@pytest.mark.parametrize(("settings", "words"), [
    ("bearing.clearance_um=20 bearing.outer_raceway_diameter_mm=56.0", "clearance_um = 20 and outer_raceway_diameter"),
    ("bearing.clearance_um=-300", "preload"), ("bearing.clearance_um=3000", "too large"),
    ("bearing.clearance_um=wide", "bearing.clearance_um = 'wide'"),
    ("bearing.designation=NU402", "for another bearing leave it out and give rollers, roller_diameter_mm"),
    ("bearing.designation=NU206 bearing.type=ball", "'NU206': not with type = \"ball\""),
    ("bearing.designation='6205' bearing.type=roller", "'6205': not with type = \"roller\""),
    ("speed_rpm=0", "mean operation.speed_rpm?"), ("rollers=9", "did you mean bearing.rollers or bodies.rollers?"),
    ("numerics.radial_load_N=3", "did you mean operation.radial_load_N?"),
])  # fmt: skip
def test_bearings_that_contradict_themselves_and_keys_of_another_table_are_refused(settings, words):
    told = refusal(settings.split())
    assert words in told and len(told.splitlines()) == 1


def test_the_schema_knows_every_key_and_no_other(capsys):
    assert run_main(["--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["additionalProperties"] is False and set(schema["properties"]) == set(Scene.model_fields)
    speed = schema["$defs"]["OperationTable"]["properties"]["speed_rpm"]
    assert (speed["type"], speed["default"], speed["maximum"]) == ("number", 4500.0, 200_000.0)
    assert schema["properties"]["model"]["enum"] == list(get_args(Scene.model_fields["model"].annotation))
    assert "content" not in schema["$defs"]["ProfileTable"]["properties"]  # no key of the file


@pytest.mark.parametrize(("name", "rpm"), [("NU206", 2900), ("NU206", 1800), ("spindle", 15000), ("faults", 4500)])
def test_an_example_lasts_long_enough_to_part_its_rings_lines_from_its_rollers(here, name, rpm):
    """Two lines are two peaks from twice the resolution on (Hann window)."""
    run_main(["--example", name])
    scene = read_scene(f"{name}.toml", (f"operation.speed_rpm={rpm}",))
    lines = kinematics(scene.ideal_bearing(), scene.ideal_operation().speed).frequencies
    gap = abs(np.subtract(2.0 * lines["BSF"], [lines["BPFO"], lines["BPFI"]])).min()
    assert 1e-3 * scene.numerics.duration_ms * gap >= 2.0


ABSENT = "damping penalty spall waviness unequal fit lubricant axial support sensor shaft_st table unbalance conformity"
TABLES = (  # of which a scene's text must say all
    {"damping": {"contact_time_us": 12.0}}, {"contact": {"model": "faceted"}}, {"bodies": {"inner_ring": "rigid"}},
    {"lubricant": {"viscosity_Pa_s": 0.02}}, {"spall": [{"angle_deg": 10.0}, {"body": "roller", "roller": 3}]},
    {"waviness": [{"order": 14}], "unequal_roller": [{"roller": 5, "diameter_deviation_um": -2.0}]},
)  # fmt: skip


def test_defaults_are_the_papers_bearing_round_trips_keep_every_value_and_an_override_leaves_other_bodies(tmp_path):
    bearing, operation = Scene().ideal_bearing(), Scene().ideal_operation()
    radii = bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius
    assert bearing.n_rollers == 13 and radii == pytest.approx((0.005, 0.018, 0.028))
    assert operation.speed == pytest.approx(2 * math.pi * 75.0)
    assert operation.first_roller_angle == pytest.approx(-math.pi / 2)  # on the load line
    assert bearing.roller.youngs_modulus == pytest.approx(210e9)
    moduli, path = {"youngs_modulus_GPa": 200.0, "roller": {"youngs_modulus_GPa": 310.0}}, tmp_path / "scene.toml"
    sizes = {"rollers": 11, "outer_raceway_diameter_mm": 56.03}
    other = {"name": "other", "bearing": sizes, "material": moduli, "numerics": {"start": "rest"}}
    assert not [word for word in ABSENT.split() if word in Scene().to_toml()]
    for each in (*(parse_scene(tables, "test") for tables in (other, *TABLES)), Scene(), balls()):
        path.write_text(each.to_toml(), encoding="utf-8-sig")  # a byte order mark, which editors on Windows write
        assert parse_scene_text(each.to_toml(), "again") == each == read_scene(path)
    bearing = parse_scene(other, "test").ideal_bearing()
    assert (bearing.roller.youngs_modulus, bearing.inner_ring.youngs_modulus) == (310e9, 200e9)
    assert bearing.roller.poisson_ratio == 0.3


@pytest.mark.parametrize(("table", "keys", "none"), [
    ("bearing", {"type": "ball"}, "inner_conformity"), ("support", {"kind": "points"}, "width_mm"),
    ("support", {"kind": "housing"}, "mass_kg"),
])  # fmt: skip
def test_none_from_python_is_a_key_that_is_not_given(table, keys, none):
    assert parse_scene({table: keys | {none: None}}, "scene") == parse_scene({table: keys}, "scene")


def test_a_scene_that_is_not_there_or_of_an_earlier_version_is_named_with_what_to_do(tmp_path):
    (tmp_path / "motor.toml").touch()
    with pytest.raises(SceneError, match=r"motor\.tml: no such file; did you mean .*motor\.toml\?"):
        read_scene(tmp_path / "motor.tml")
    with pytest.raises(SceneError, match="run-fem --example NU206 writes one to begin with"):
        read_scene(tmp_path / "elsewhere" / "pump.toml")
    with pytest.raises(SceneError, match="run the scene again"):
        parse_stored_scene("[numerics]\nthreads = 1\n", "run.nc")


@pytest.mark.parametrize("diameter", [1.0, 10.0, 60.0, 100.0])
@pytest.mark.parametrize("speed", [1.0, 30_000.0])
@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_sizes_speed_and_load_alone_are_a_scene_of_any_size(diameter, speed, model):
    """The paper's bearing, larger and smaller; a surface may be no faster than linear elasticity bears."""
    sizes = {"roller_diameter": 1.0, "roller_length": 1.0, "inner_raceway_diameter": 3.6, "bore_diameter": 2.5,
             "outside_diameter": 6.5, "outer_raceway_diameter": 5.6}  # fmt: skip
    settings = [f"bearing.{key}_mm={factor * diameter}" for key, factor in sizes.items()]
    settings += [f"model={model}", f"operation.speed_rpm={min(speed, 3e5 / diameter)}"]
    scene = read_scene(None, (*settings, f"operation.radial_load_N={20.0 * diameter**2}"))
    assert scene.numerics.mesh_size_mm == pytest.approx(0.1 * diameter)
    assert scene.operation.inner_ring_and_shaft_kg > scene.perfect_bearing().inner_ring_mass
    assert diameter != 10.0 or scene.operation.inner_ring_and_shaft_kg == 0.078
    make_plan(scene)


@pytest.mark.parametrize(("make", "told"), [
    (lambda: Scene(operation={"spede_rpm": 3}), r"Scene: operation.spede_rpm: unknown .*mean speed_rpm\?"),
    (lambda: Scene(operatoin={}), r"Scene: operatoin: unknown key; did you mean operation\?"),
    (lambda: Scene(bearing={"rollers": "x"}, spall=[SpallTable(width_mm=1.0)]), "bearing.rollers = 'x'"),
    (lambda: SpallTable(widht_mm=1.0), r"SpallTable: widht_mm: unknown key; did you mean width_mm\?"),
])  # fmt: skip
def test_tables_from_python_tell_their_faults_as_a_file_does(make, told):
    with pytest.raises(SceneError, match=told):
        make()


def balls(**changes):
    sizes = dict(roller_diameter_mm=12.7, roller_length_mm=19.0, inner_raceway_diameter_mm=52.291,
                 outer_raceway_diameter_mm=77.706, bore_diameter_mm=45.0, outside_diameter_mm=85.0)  # fmt: skip
    bearing = {"type": "ball", "rollers": 9, **sizes, **changes}
    return parse_scene({"bearing": bearing, "operation": {"inner_ring_and_shaft_kg": 0.5}}, "s.toml")


def test_balls_in_si_have_the_grooves_of_the_standard_their_own_law_and_need_no_mesh_size():
    """ISO 281 rates grooves of 0.52 and 0.53 of the ball's diameter."""
    scene, bearing = balls(), balls().ideal_bearing()
    assert isinstance(bearing, BallBearing) and bearing.n_rollers == 9
    found = bearing.roller_radius, bearing.inner_groove_radius, bearing.outer_groove_radius
    assert found == pytest.approx((6.35e-3, 6.604e-3, 6.731e-3))
    assert balls(inner_conformity=0.515).ideal_bearing().inner_groove_radius == pytest.approx(0.515 * 12.7e-3)
    assert not isinstance(Scene().ideal_bearing(), BallBearing)
    assert scene.lagrange.law == "hertz" and Scene().lagrange.law == "harris"
    assert "inner_conformity = 0.52" in scene.to_toml()
    balls(roller_diameter_mm=6.0, inner_raceway_diameter_mm=65.6)
    small = {"roller_diameter_mm": 1.0, "inner_raceway_diameter_mm": 75.7}
    assert balls(**small).numerics.mesh_size_mm == 1.0
    assert balls(type="roller", **small).numerics.mesh_size_mm == 0.1  # a tenth of a roller
