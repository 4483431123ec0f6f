"""The scene file: units, faults, round trip."""

import math

import pytest

from fem.solver.simulate import make_plan
from lagrange.scene.scene import Scene, SceneError, parse_scene, parse_scene_text, parse_stored_scene, read_scene
from lagrange.scene.surfaces import SpallTable


def test_defaults_are_the_papers_bearing_in_si():
    scene = Scene()
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    assert bearing.n_rollers == 13
    assert (bearing.roller_radius, bearing.inner_raceway_radius) == pytest.approx((0.005, 0.018))
    assert bearing.outer_raceway_radius == pytest.approx(0.028)
    assert operation.speed == pytest.approx(2 * math.pi * 75.0)
    assert operation.first_roller_angle == pytest.approx(-math.pi / 2)  # on the load line
    assert bearing.roller.youngs_modulus == pytest.approx(210e9)


def test_round_trip_keeps_every_value():
    scene = parse_scene(
        {
            "name": "other",
            "bearing": {"rollers": 11, "roller_diameter_mm": 10.01, "outer_raceway_diameter_mm": 56.03},
            "material": {"roller": {"density_kg_m3": 3200.0}},
            "numerics": {"start": "rest"},
        },
        "test",
    )
    assert parse_scene_text(scene.to_toml(), "again") == scene
    assert parse_scene_text(Scene().to_toml(), "again") == Scene()


def test_override_of_one_body_leaves_the_others():
    scene = parse_scene({"material": {"youngs_modulus_GPa": 200.0, "roller": {"youngs_modulus_GPa": 310.0}}}, "t")
    bearing = scene.ideal_bearing()
    assert (bearing.roller.youngs_modulus, bearing.inner_ring.youngs_modulus) == (310e9, 200e9)
    assert bearing.roller.poisson_ratio == 0.3


def test_a_byte_order_mark_is_no_part_of_the_scene(tmp_path):
    """Editors on Windows write one."""
    path = tmp_path / "scene.toml"
    path.write_text('name = "marked"\n', encoding="utf-8-sig")
    assert read_scene(path).name == "marked"


def test_override_on_the_command_line():
    scene = read_scene(None, ("operation.speed_rpm=3000.0", "name=fast", "bearing.rollers=12"))
    assert (scene.operation.speed_rpm, scene.name, scene.bearing.rollers) == (3000.0, "fast", 12)


@pytest.mark.parametrize(
    "tables",
    [
        {"bearing": {"type": "ball", "inner_conformity": None}},
        {"support": {"kind": "points", "width_mm": None}},
        {"support": {"kind": "housing", "mass_kg": None}},
    ],
)
def test_none_from_python_where_a_kind_needs_a_value_is_refused(tables):
    with pytest.raises(SceneError, match="leave None out"):
        parse_scene(tables, "scene")


def test_a_stored_scene_of_an_earlier_version_is_to_be_run_again():
    with pytest.raises(SceneError, match="run the scene again"):
        parse_stored_scene("[numerics]\nthreads = 1\n", "run.nc")


def test_a_scene_that_is_not_there_is_named_with_what_is(tmp_path):
    (tmp_path / "motor.toml").touch()
    with pytest.raises(SceneError, match=r"motor\.tml: no such file; did you mean .*motor\.toml\?"):
        read_scene(tmp_path / "motor.tml")
    with pytest.raises(SceneError, match="run-fem --example NU206 writes one to begin with"):
        read_scene(tmp_path / "elsewhere" / "pump.toml")


@pytest.mark.parametrize("diameter", [1.0, 10.0, 60.0, 100.0])
@pytest.mark.parametrize("speed", [1.0, 30_000.0])
@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_sizes_speed_and_load_alone_are_a_scene_of_any_size(diameter, speed, model):
    """The paper's bearing, larger and smaller; a surface may be no faster than linear elasticity bears."""
    sizes = {"roller_diameter": 1.0, "roller_length": 1.0, "inner_raceway_diameter": 3.6, "bore_diameter": 2.5,
             "outside_diameter": 6.5, "outer_raceway_diameter": 5.6}  # fmt: skip
    settings = [f"bearing.{key}_mm={factor * diameter}" for key, factor in sizes.items()]
    load, speed = 20.0 * diameter**2, min(speed, 3e5 / diameter)
    scene = read_scene(None, (*settings, f"model={model}", f"operation.speed_rpm={speed}",
                              f"operation.radial_load_N={load}"))  # fmt: skip
    assert scene.numerics.mesh_size_mm == pytest.approx(0.1 * diameter)
    assert scene.operation.inner_ring_and_shaft_kg > scene.perfect_bearing().inner_ring_mass
    assert diameter != 10.0 or scene.operation.inner_ring_and_shaft_kg == 0.078
    make_plan(scene)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"operation": {"spede_rpm": 3}}, "Scene: operation.spede_rpm: unknown key; did you mean speed_rpm?"),
        ({"operatoin": {}}, "Scene: operatoin: unknown key; did you mean operation?"),
        (
            {"bearing": {"rollers": "x"}, "spall": [SpallTable(body="outer_ring", width_mm=1.0)]},
            "bearing.rollers = 'x'",
        ),
    ],
)
def test_a_scene_from_python_tells_its_faults_as_a_file_does(given, told):
    with pytest.raises(SceneError) as error:
        Scene(**given)
    assert told in str(error.value)


def test_a_table_from_python_tells_its_faults_too():
    with pytest.raises(SceneError, match=r"SpallTable: widht_mm: unknown key; did you mean width_mm\?"):
        SpallTable(body="outer_ring", widht_mm=1.0)
