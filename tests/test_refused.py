"""Scenes that are refused: with words that name the key, its value, and the limit or what to do."""

import pytest

from fem.solver.simulate import make_plan
from lagrange.errors import UsageError
from lagrange.scene.checks import check_motion
from lagrange.scene.scene import parse_scene_text, read_scene
from tests.reference.kit import assert_refused

TAPERED = ("bearing={rollers=16, rows=2, roller_diameter_mm=8.4074, roller_length_mm=10, pitch_diameter_mm=71.501, "
           "contact_angle_deg=15.17, bore_diameter_mm=49.2125, outside_diameter_mm=93}")  # fmt: skip
NEEDLES = (  # on a solid shaft
    "bearing={rollers=18, roller_diameter_mm=3, roller_length_mm=10, inner_raceway_diameter_mm=25, clearance_um=20, "
    "bore_diameter_mm=0, outside_diameter_mm=37}"
)
ONE_LACKS, SPRINGS = "bearing.missing_rollers=[1]", ("operation.shaft=springs", "operation.shaft_stiffness_N_per_m=2e8")
IS_MISSING = "not together with bearing.missing_rollers"
TURNS = "operation.outer_ring_speed_rpm"
BY_SUBJECT = {  # settings of all rows, None: rows have a scene's text; settings of a row, and words
    "a cage": (("cage={}",), [
        (("cage.guidance=rollers", "cage.guidance_clearance_mm=0.3"), "only with guidance"),
        ("cage.pocket_clearance_mm=1.2", "a bar of the cage has to stand between them"),
        ("cage.mas_kg=0.1", "did you mean mass_kg?"), ("cage.mass_kg=0.0", "cage.mass_kg = 0.0: must be greater"),
    ]),
    "a housing": ((), [
        ("support.mass_kg=3", 'mass_kg = 3: only with kind = "housing"'),
        ("support.kind=housng", "support.kind = 'housng'"), ("support=3", "support = 3: must be a table"),
        (("support.kind=housing", "support.mass_kg=-1.0"), "support.mass_kg = -1.0", "0.001"),
        (("support.kind=housing", "support.mas_kg=1"), "support.mas_kg: unknown key; did you mean mass_kg?"),
        ("sensor={}", "[sensor]", '[support] with kind = "housing"'),
        (("support.kind=housing", "sensor.damping_ratio=1.0"), "sensor.damping_ratio = 1.0"),
    ]),
    "a shaft": ((), [
        ("operation.shaft=springs", 'shaft = "springs" needs shaft_stiffness_N_per_m'),
        ("operation.shaft_stiffness_N_per_m=1e7", 'shaft_stiffness_N_per_m = 1e+07: only with shaft = "springs"'),
        (("operation.shaft=rigid", "operation.shaft_damping_N_s_m=10"),
         'shaft_damping_N_s_m = 10: only with shaft = "springs"'),
        ((SPRINGS[0], "operation.shaft_stiffness_N_per_m=-1.0"), "operation.shaft_stiffness_N_per_m = -1.0"),
        ("operation.shaft=spring", "operation.shaft = 'spring'"),
        ((*SPRINGS, "contact.model=faceted"), 'operation.shaft = "springs": only with contact.model = "subgrid"'),
    ]),
    "a bore": (("support.kind=bore",), [
        ("support.mass_kg=1", 'mass_kg = 1: only with kind = "housing", not "bore"'),
        (("support.kind=housing", "support.bore_stiffness_N_per_mm3=9"), "only with fit_clearance_um"),
        ("support.bore_stiffness_N_per_mm3=0", "support.bore_stiffness_N_per_mm3"),
        ("support.fit_clearance_um=140", "outside diameter, 65 mm; between -130 and 130"),
        ("model=lagrange", "fit_clearance_um = 0", '"lagrange"'), ("sensor={}", "[sensor]"),
        ("model=reduced", "fit_clearance_um = 0", '"reduced"'), ("bodies.outer_ring=rigid", "elastic outer ring"),
        ("contact.model=resolved", "fit_clearance_um", '"resolved"'),
        ("cage.guidance=outer_ring", 'cage.guidance = "outer_ring"'),
    ]),
    "points": (("support.kind=points",), [
        ("support.fit_clearance_um=1", 'only with kind = "housing" or "bore"', '"points"'),
        ("support.angles_deg=[]", "support.angles_deg"), ("support.width_mm=0", "support.width_mm"),
        ("support.angles_deg=[400]", "angles_deg.0 = 400", "360"),
        ("support.mass_kg=1", 'mass_kg = 1: only with kind = "housing", not "points"'),
        (("support.kind=housing", "support.width_mm=1"), 'width_mm = 1: only with kind = "points"'),
        ("model=lagrange", 'support.kind = "points": only with model = "fem"', '"lagrange"'),
        ("bodies.outer_ring=rigid", "rigid outer ring"), ("sensor={}", "[sensor]"),
        ("contact.model=resolved", '"resolved"'),
    ]),
    "an outer ring that turns": (("operation.outer_ring_speed_rpm=600",), [
        ("support.kind=housing", TURNS, 'only with support.kind = "held", not with "housing"'),
        (("support.kind=points", "model=fem"), TURNS, 'not with "points"'),
        ("fit.inner_ring_C=30", TURNS, "not with [fit], whose housing stands still"),
        ("cage.guidance=outer_ring", TURNS, 'cage.guidance = "outer_ring": not with operation'),
        (("model=fem", "contact.model=resolved"), TURNS, 'only with contact.model = "subgrid"'),
    ]),
    "surfaces": ((), [
        ("spall.0=2", "spall", "must be a table, [[spall]]"), ("spall.width_mm=2", "[[spall]]"),
        (f"spall.{'9' * 5000}.width_mm=2", "spall", "none of 0 tables"),
    ]),
    "surfaces in a scene's text": (None, [
        ("[[spal]]", "spal", "did you mean spall?"), ("spall = 3", "spall = 3", "[[spall]]"),
        ('[[spall]]\nbody = "cage"', "spall.0.body = 'cage'", "'outer_ring', 'inner_ring' or 'roller'"),
        ('[[spall]]\nbody = "roller"', "roller = 0"),
        ("[[spall]]\nroller = 3", "spall.0", "roller = 3", 'only with body = "roller"'),
        ("[[unequal_roller]]\nroller = 13", "unequal_roller.0.roller = 13", "from 0 to 12"),
        ("[[unequal_roller]]\n[[unequal_roller]]", "roller = 0", "2 times"),
        ("[[spall]]\nwidth_mm = 9.0", "spall.0.width_mm = 9", "at most 8"),
        ("[[spall]]\nwidth_mm = 0.01", "spall.0.width_mm = 0.01", "at least 0.0176"),
        ("[[spall]]\ndepth_um = 4600.0", "spall.0.depth_um = 4600", "through the body"),
        ("[[spall]]\nangle_deg = 359\n[[spall]]", "spall.0 and spall.1 overlap", "1 degrees", "2.07"),
        ("[[waviness]]\norder = 1000", "waviness.0.amplitude_um = 0.5", "order = 1000", "valleys"),
        ("[[waviness]]\namplitude_um = 51.0", "amplitude_um = 51", "at most 50"),
        ("[[unequal_roller]]\ndiameter_deviation_um = -51.0", "= -51", "at most 50"),
        ('[[waviness]]\n[contact]\nmodel = "penalty"', "[[waviness]]", '"penalty"'),
        ("[[spall]]\n" * 201, "spall = [", "at most 200"),
        ('[[spall]]\nwidth_mm = "a"\n[[spall]]\nroller = 1\nz = 3\n[operation]\nspeed_rpm = true',
         "spall.0.width_mm = 'a'", "spall.1.z: unknown key", "spall.1: roller = 1", "operation.speed_rpm"),
    ]),
    "fits and films": (("bearing.designation=NU206",), [
        ("fit.shaft_interference_um=70", "more than 0.002 of the diameter, 30 mm; between -60 and 60"),
        ("fit.housing_interference_um=200", "more than 0.002 of the diameter, 62 mm"),
        ("fit.shaft_bore_mm=30", "must be below bearing.bore_diameter_mm = 30"),
        ("fit.housing_outside_diameter_mm=62", "must be above bearing.outside_diameter_mm = 62"),
        (("fit.shaft_interference_um=60", "fit.inner_ring_C=80"),
         "more preload than the model bears (at least -45 µm); less interference, or more clearance: unmounted 32"),
        (("fit.outer_ring_C=400", "fit.ring_expansion_1_K=1e-4", "fit.housing_expansion_1_K=1e-4"),
         "too large a clearance"),
        (("fit.inner_ring_C=-150", "fit.shaft_C=500"), "of interference in operation, more than 0.002 of the diameter"),
        ("fit.shaft_interferenc_um=1", "did you mean shaft_interference_um"),
        ("fit.temperature_C=50", "temperatures computed from heat ([fit] has given ones)"),
        ("bearing.shaft_interference_um=5", "did you mean fit.shaft_interference_um"),
        (("support.kind=bore", "fit.housing_interference_um=5"), "fit.housing_interference_um = 5: not with the",
         "of an outer ring that its housing does not hold"),
        ("lubricant.viscosity_Pa_s=0", "lubricant.viscosity_Pa_s = 0"),
        (("bearing.designation='6205'", "lubricant={}"), "[lubricant]: films are those of line contacts"),
        (("contact.model=penalty", "lubricant.viscosity_Pa_s=0.02"), "[lubricant]", '"penalty"'),
    ]),
    "other kinds of bearings": (("operation.inner_ring_and_shaft_kg=8",), [
        ((TAPERED, "bearing.contact_angle_deg=60"), "less than or equal to 45"),
        ((TAPERED, "bearing.inner_raceway_diameter_mm=63"), "already give the pitch"),
        ((TAPERED, 'spall=[{body="roller", roller=1}]'), "turn faster than those"),
        ((TAPERED, "support.kind=bore"), "only for rings whose contacts are radial"),
        ((TAPERED, "contact.model=penalty"), "as curved as bodies"),
        ("bearing.missing_rollers=[13]", "there is no roller 13"),
        ("bearing.missing_rollers=[1, 1]", "a number is there twice"),
        ("bearing.missing_rollers=[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]", "leaves 2 rollers; at least 3"),
        ((ONE_LACKS, "unequal_roller=[{roller=2}]"), IS_MISSING), ("bearing.missing_rollers=3", "rollers = 3"),
        ((ONE_LACKS, 'spall=[{body="roller", roller=2}]'), IS_MISSING),
        ((NEEDLES, "model=reduced", "fit.shaft_interference_um=5"), "bore_diameter_mm = 0"),
        ((NEEDLES, "contact.model=penalty"), "held at its bore"),
    ]),
    "axial loads and pairs": (("bearing.rows=2", "bearing.contact_angle_deg=15"), [
        (("bearing.designation=NU206", "bearing.rows=1", "bearing.contact_angle_deg=0", "operation.axial_load_N=500"),
         "operation.axial_load_N = 500: NU206 has no flanges on both rings", "NJ or NUP, or bearing.flange_height_mm"),
        (("bearing.contact_angle_deg=0", "bearing.flange_height_mm=2"), "flange_height_mm = 2: of one row"),
        (("operation.moment_N_m=1", "operation.misalignment_mrad=0"), "misalignment_mrad = 0: the tilt follows from"),
        (("bearing.rows=1", "bearing.arrangement=back_to_back"), 'arrangement = "back_to_back"', "not with rows = 1"),
        ("bearing.arrangement=back_to_back", "needs the distance of its rows, e.g. row_distance_mm = 15"),
        ("bearing.preload_N=1", "give arrangement too"),
        ("bearing.static_load_rating_N=0", "static_load_rating_N = 0: must be greater than 0"),
    ]),
    "tilt on meshes": (("axial.slices=11",), [
        ("contact.model=penalty", 'only with contact.model = "subgrid"'),
        ("bodies.rollers=rigid", "whose slices are those of elastic bodies"),
        ("damping.contact_N_s_m=10", "leave one of them out"),
    ]),
    "fields": ((), [
        ("output.fields_every_ms=0.005", "output.fields_every_ms = 0.005 must not be below", "0.01 ms"),
    ]),
}  # fmt: skip


@pytest.mark.parametrize("subject", BY_SUBJECT)
def test_scenes_that_make_no_sense_are_refused_by_name(subject):
    common, rows = BY_SUBJECT[subject]
    for given, *words in rows:
        own = [given] if isinstance(given, str) else given
        assert_refused(given if common is None else [*common, *own], *words)


def test_a_scene_with_an_axial_load_is_read_back_in_si():
    keys = ("bearing={rows=2, contact_angle_deg=15, arrangement='face_to_face', row_distance_mm=20, preload_N=100}",
            "operation={axial_load_N=-500, misalignment_mrad=1}", "model=lagrange")  # fmt: skip
    scene = read_scene(None, keys)
    assert scene.row_loads() == ("face_to_face", 0.02, 100.0, None, -500.0, None, 0.001)
    assert parse_scene_text(scene.to_toml(), "again") == scene
    check_motion(read_scene(None, ("operation={axial_load_N=0, moment_N_m=0}",)))  # 0 is no load
    bearings = [read_scene(None, (f"bearing.designation={name}",)).bearing for name in ("NU206", "NJ206")]
    assert [each.flange_height_mm for each in bearings] == [None, pytest.approx(0.2 * 9.0)]


@pytest.mark.parametrize(("settings", "told"), [
    ("model=reduced bodies.inner_ring=rigid", 'bodies.inner_ring = "rigid"'),
    ("model=reduced contact.model=resolved numerics.mesh_size_mm=0.03", 'contact.model = "resolved"'),
    ("model=reduced bearing.type=ball", 'bearing.type = "ball"'),
    ("model=reduced operation.radial_load_N=2e6", "beyond Hertz's theory"),
    ("model=reduced operation.speed_rpm=200000 material.youngs_modulus_GPa=20", "centrifugal load"),
    ("support.kind=bore numerics.mesh_size_mm=0.05", r"support\.fit_clearance_um.*mesh_size_mm = 0\.05"),
    ("support.kind=points numerics.mesh_size_mm=0.05", r"support\.kind.*mesh_size_mm = 0\.05"),
    ("spall.0.width_mm=1 numerics.mesh_size_mm=0.05", r"\[\[spall\]\].*numerics.mesh_size_mm = 0.05.*at least"),
    pytest.param("axial.slices=11 numerics.mesh_size_mm=0.1", "use a larger numerics", marks=pytest.mark.slow),
])  # fmt: skip
def test_what_a_model_and_its_mesh_can_not_do_is_refused_by_name(settings, told):
    with pytest.raises(UsageError, match=told):
        make_plan(read_scene(None, tuple(settings.split())))
