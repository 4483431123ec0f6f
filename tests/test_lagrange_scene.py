"""The scene file: units, faults, round trip."""

import math

import pytest

from fem.solver.simulate import make_plan
from lagrange.scene.scene import Scene, SceneError, parse_scene, parse_scene_text, read_scene
from lagrange.scene.surfaces import SpallTable


def fault(text):
    with pytest.raises(SceneError) as caught:
        parse_scene_text(text, "s.toml")
    return str(caught.value)


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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[operation]\nspeed_rmp = 1.0", ["operation.speed_rmp", "did you mean speed_rpm?"]),
        ("[operatoin]\nspeed_rpm = 1.0", ["operatoin", "did you mean operation?"]),
        ("[contact]\nzzz = 1", ["contact.zzz", "known here: model, penalty_stiffness_N_per_m, friction_coefficient"]),
        ("[operation]\naxial_load_N = 1", ["axial_load_N: not in this program: axial loads; see docs/limits"]),
        ("[bearing]\ncrown_um = 1", ["did you mean axial.crown_um?"]),
        ("[bearing]\nroller_bore_diameter_mm = 5", ["not in this program: hollow rollers; see docs/limits"]),
        ("[operation]\ntemperature = 1", ["not in this program: temperature"]),
        ("[support]\nfit_clearence_um = 1", ["did you mean fit_clearance_um?"]),
        ("[bearing]\nrollers = 2", ["bearing.rollers = 2", "3"]),
        ("[bearing]\nrollers = 12.5", ["bearing.rollers = 12.5"]),
        ('[bearing]\nrollers = "13"', ["bearing.rollers = '13'"]),
        ("[bearing]\nrollers = 15", ["rollers = 15", "at most 14"]),
        (
            "[bearing]\nbore_diameter_mm = 36.0",
            ["bore_diameter_mm = 36.0", "inner_raceway_diameter_mm = 36.0"],
        ),
        ("[bearing]\noutside_diameter_mm = 50.0", ["outside_diameter_mm = 50.0"]),
        ("[bearing]\nouter_raceway_diameter_mm = 55.9", ["preload", "outer_raceway_diameter_mm = 55.9"]),
        ("[bearing]\nouter_raceway_diameter_mm = 60.0", ["too large", "outer_raceway_diameter_mm = 60.0"]),
        ("[operation]\nspeed_rpm = nan", ["operation.speed_rpm = nan"]),
        ("[operation]\nradial_load_N = -1.0", ["operation.radial_load_N = -1.0", "0"]),
        (
            "[operation]\ninner_ring_and_shaft_kg = 0.01",
            ["inner_ring_and_shaft_kg = 0.01", "elastic inner ring"],
        ),
        ("[material]\npoisson_ratio = 0.5", ["material.poisson_ratio = 0.5", "0.45"]),
        ("[numerics]\ntime_step_safety = 1.0", ["numerics.time_step_safety = 1.0", "less than 1"]),
        ("[numerics]\nmesh_size_mm = 9.0", ["mesh_size_mm = 9.0", "too coarse"]),
        ('[numerics]\nstart = "hot"', ["numerics.start = 'hot'", "equilibrium", "rest"]),
        ('name = "../etc"', ["name = '../etc'"]),
        ("name = ", ["not valid TOML"]),
        ("operation.radial_load_N = 3,5", ["not valid TOML", "radial_load_N = 3,5: decimals take a point"]),
        ("bearing.designation = NU206", ["not valid TOML", "designation = NU206: texts take quotes"]),
        ('[fit]\nshaft = "k5"', ["fit.shaft: unknown key; did you mean shaft_interference_um?"]),
    ],
)
def test_faults_name_file_key_value_and_limit(text, words):
    message = fault(text)
    for word in ["s.toml", *words]:
        assert word in message, message


def test_all_faults_are_told_at_once():
    message = fault("[operation]\nspeed_rmp = 1.0\nradial_load_N = -5.0\n[contact]\nfriction_coefficient = 2.0")
    assert len(message.splitlines()) == 3
    for word in ("speed_rmp", "radial_load_N = -5.0", "friction_coefficient = 2.0"):
        assert word in message


def test_a_byte_order_mark_is_no_part_of_the_scene(tmp_path):
    """Editors on Windows write one."""
    path = tmp_path / "scene.toml"
    path.write_text('name = "marked"\n', encoding="utf-8-sig")
    assert read_scene(path).name == "marked"


def test_override_on_the_command_line():
    scene = read_scene(None, ("operation.speed_rpm=3000.0", "name=fast", "bearing.rollers=12"))
    assert (scene.operation.speed_rpm, scene.name, scene.bearing.rollers) == (3000.0, "fast", 12)


@pytest.mark.parametrize("override", ["speed", "=3", "operation.=3", "name.first=1", "operation.speed_rpm=fast"])
def test_bad_overrides_are_refused(override):
    with pytest.raises(SceneError, match=r"--set|name|speed_rpm"):
        read_scene(None, ("name=x", override))


def test_unreadable_files_are_refused(tmp_path):
    binary = tmp_path / "b.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path, word in (
        (tmp_path / "none.toml", "no such file; run-fem --example"),
        (tmp_path, "can't be read"),
        (binary, "UTF-8"),
    ):
        with pytest.raises(SceneError, match=word):
            read_scene(path)


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


def test_results_that_spell_out_one_thread_are_read_and_more_are_refused():
    assert parse_scene({"numerics": {"threads": 1}}, "stored") == read_scene()
    with pytest.raises(SceneError, match=r"numerics.threads: unknown key"):
        parse_scene({"numerics": {"threads": 2}}, "new")


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
