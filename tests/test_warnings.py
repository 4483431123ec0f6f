"""What a plan warns of: pressures that steel does not bear, samples too seldom; told everywhere a user looks."""

import json
import re
from math import pi, sqrt

import h5py
import pytest

from fem.commands.run_fem import run_main
from fem.solver.simulate import make_plan
from fem.solver.warnings import of_scene
from lagrange.scene.scene import SceneError, read_scene
from residual.cli import main as check_main
from residual.sources import read_result

COARSE = "numerics.mesh_size_mm=2"
ISO_76 = 4e9  # Pa, ISO 76:2006, roller bearings


def hertz_pressure(force):
    """Line contact of roller and inner raceway: p0 = sqrt(Q E* / (π R L)) (Johnson, Contact Mechanics, 1985, 4.2)."""
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    radius = 1.0 / (1.0 / 5e-3 + 1.0 / 18e-3)
    return sqrt(force * modulus / (pi * radius * 10e-3))


def plan_of(*settings):
    return make_plan(read_scene(None, (COARSE, *settings)))


@pytest.mark.parametrize("load", [40e3, 52e3, 55e3, 70e3])
def test_a_pressure_above_the_static_rating_is_warned_of(load):
    plan = plan_of(f"operation.radial_load_N={load}")
    pressure = hertz_pressure(plan.start.equilibrium.inner_force.max())
    assert abs(pressure - ISO_76) > 0.002 * ISO_76  # the load is not chosen on the edge
    assert bool(plan.warnings) == (pressure > ISO_76)
    if plan.warnings:
        assert f"{1e-6 * pressure:.0f} MPa" in plan.warnings[0]
        assert "ISO 76" in plan.warnings[0] and "4000 MPa" in plan.warnings[0]


def test_the_largest_preload_a_scene_may_have_is_warned_of_in_stiff_bodies_only():
    """Beyond 0.5 % of the roller's diameter the scene refuses it; at 500 GPa that is too much already."""
    preload = ("bearing.outer_raceway_diameter_mm=55.951", "operation.radial_load_N=0")
    assert not plan_of(*preload).warnings
    assert "the preload" in plan_of(*preload, "material.youngs_modulus_GPa=500").warnings[0]


@pytest.mark.parametrize(("interval", "warned"), [(10.0, False), (30.0, False), (50.0, True), (1000.0, True)])
def test_samples_that_can_not_follow_the_hub_are_warned_of(interval, warned):
    """The hub of the paper's bearing swings at about 13.6 kHz on its contacts: 37 µs."""
    plan = plan_of(f"numerics.output_interval_us={interval}")
    assert bool(plan.warnings) == warned
    if warned:
        assert f"numerics.output_interval_us = {interval:g}" in plan.warnings[0]


def test_a_warning_is_told_wherever_a_user_looks(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "2", "--duration", "1", "--set", "operation.radial_load_N=60000", "--output", str(path)]
    assert run_main([*options, "--dry-run"]) == 0
    assert "Warning: the largest static force" in capsys.readouterr().out
    assert run_main(options) == 0
    out, error = capsys.readouterr()
    assert (out + error).lower().count("warning: the largest static force") == 1
    with h5py.File(path) as file:
        assert "ISO 76" in file.attrs["warnings"]
    assert any("ISO 76" in note for note in read_result(path).notes)
    assert check_main([str(path), "--output", str(tmp_path / "report")]) == 0
    assert "ISO 76" in capsys.readouterr().err
    summary = json.loads((tmp_path / "report" / "summary.json").read_text(encoding="utf-8"))
    assert any("ISO 76" in note for note in summary["notes"])


@pytest.mark.parametrize(("radius_mm", "warned"), [(0.1, True), (0.2, False), (0.0, True)])
def test_an_edge_that_steel_does_not_bear_is_warned_of(radius_mm, warned):
    """628 N on a rounded edge against the roller: p0 = sqrt(Q E*/(π R L)), 4.9 GPa at 0.1 mm and 3.5 at 0.2."""
    often = "numerics.output_interval_us=1", "damping.contact_time_us=12.5"
    found = plan_of("spall.0.angle_deg=14", f"spall.0.edge_radius_mm={radius_mm}", *often).warnings
    assert bool(found) == warned
    if radius_mm > 0.0 and warned:
        radius = 1.0 / (1.0 / 5e-3 + 1e3 / radius_mm)
        force = plan_of().start.equilibrium.outer_force.max()
        pressure = sqrt(force * 210e9 / (2.0 * (1.0 - 0.3**2)) / (pi * radius * 10e-3))
        assert f"{1e-6 * pressure:.0f} MPa" in found[0]


@pytest.mark.parametrize(("interval", "warned"), [(1.5, False), (10.0, True)])
@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
def test_samples_that_miss_a_strike_are_warned_of(interval, warned, model):
    """After a strike forces peak each 20 µs in runs of all three models: nine samples are 2.2 µs apart."""
    found = plan_of(
        "spall.0.angle_deg=14", "spall.0.edge_radius_mm=0.5", f"numerics.output_interval_us={interval}",
        f"model={model}", "damping.contact_time_us=12.5",
    ).warnings  # fmt: skip
    assert bool(found) == warned
    if warned:
        assert "[[spall]]" in found[0]
        assert float(found[0].split("at most ")[1]) == pytest.approx(2.0, rel=0.15)


def test_samples_that_miss_waves_are_warned_of():
    """Order 200 on the inner ring: a wave of 0.57 mm passes in 110 µs, seen by two samples of 55 µs."""
    found = plan_of(
        "waviness.0.order=200", "waviness.0.amplitude_um=0.01", "numerics.output_interval_us=30",
    ).warnings  # fmt: skip
    assert not found
    found = plan_of(
        "waviness.0.order=400", "waviness.0.amplitude_um=0.01", "numerics.output_interval_us=30",
    ).warnings  # fmt: skip
    assert "[[waviness]]" in found[0] and "at most 27.4" in found[0]


@pytest.mark.parametrize(
    ("value", "sound", "words"),
    [
        ("bearing.clearance_um=1500", "bearing.clearance_um=90", "clearance, 1500 µm, is 17 %"),
        ("operation.radial_load_N=3", "operation.radial_load_N=0", "radial_load_N = 3 is below a thousandth"),
        ("operation.speed_rpm=60000", "operation.speed_rpm=20000", "n d_m is 2.8e+06"),  # 46.5 mm
    ],
)
def test_values_in_other_units_are_warned_of(value, sound, words):
    """C0 of NU 206 is 36.5 kN by ISO 76, C5 by ISO 5753-1 65 to 90 µm."""
    found = {}
    for setting in (value, sound):
        scene = read_scene(None, ('bearing={designation="NU206"}', setting))
        found[setting] = of_scene(scene, scene.perfect_bearing(), scene.ideal_operation(), 1e-6)
    assert len(found[value]) == 1 and words in found[value][0] and not found[sound]


FAULTS = (
    ("spall.0.body=outer_ring", "spall.0.width_mm=1.2", "spall.0.edge_radius_mm=0.5"),
    ("spall.0.body=roller", "spall.0.roller=3", "spall.0.edge_radius_mm=0.5"),
    ("waviness.0.order=4000", "waviness.0.amplitude_um=1e-5", "operation.speed_rpm=9000"),
)


@pytest.mark.parametrize("faults", FAULTS)
@pytest.mark.parametrize(("bearing", "model"), [("NU204", "lagrange"), ("NU206", "reduced"), ("NU216", "lagrange")])
def test_no_warning_follows_from_the_interval_that_the_program_chooses(bearing, model, faults):
    scene = read_scene(None, (f"bearing.designation={bearing}", f"model={model}", *faults))
    assert scene.numerics.output_interval_us < 5.0
    assert not [sentence for sentence in make_plan(scene).warnings if "output_interval_us" in sentence]


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("model", ["reduced", "lagrange", "fem"])
def test_a_spall_or_a_housing_without_damping_is_told_of_with_the_key(model, damped):
    housing = "mass_kg=12.0,stiffness_N_per_m=15e6,damping_N_s_m=0.0"
    settings = [f"model={model}", "spall.0.edge_radius_mm=0.5", f'support={{kind="housing",{housing}}}']
    settings += ["damping.contact_time_us=2.5"] if damped else []
    told = [sentence for sentence in plan_of(*settings).warnings if "damping.contact_time_us" in sentence]
    assert len(told) == (0 if damped else 1)
    assert damped or ("[[spall]]" in told[0] and "housing" in told[0])
    assert not [sentence for sentence in plan_of(f"model={model}").warnings if "damping" in sentence]


@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_a_default_duration_without_a_passage_gives_the_time_of_a_turn(model):
    """At 1 rpm the cage turns with 0.5 (1 − d/D) of that, by kinematics: 60/(0.5 · 36/46) s a turn."""
    slow = (f"model={model}", "operation.speed_rpm=1")
    (told,) = [sentence for sentence in plan_of(*slow).warnings if "duration_ms" in sentence]
    assert float(re.search(r"one turn takes ([\d.e+]+) ms", told)[1]) == pytest.approx(
        1e3 * 60.0 / (0.5 * 36 / 46), rel=5e-3
    )
    for given in ((*slow, "numerics.duration_ms=1"), (f"model={model}",), (f"model={model}", "operation.speed_rpm=0")):
        assert not [sentence for sentence in plan_of(*given).warnings if "duration_ms" in sentence]


def test_the_lagrangian_model_warns_of_missed_waves_as_the_others_do():
    found = plan_of(
        "model=lagrange", "waviness.0.order=400", "waviness.0.amplitude_um=0.01", "numerics.output_interval_us=30",
    ).warnings  # fmt: skip
    assert len(found) == 1 and "[[waviness]]" in found[0] and "at most 27.4" in found[0]


@pytest.mark.parametrize(
    ("excited", "takes_none"),
    [(("support.kind=housing", "support.damping_N_s_m=0"), "contact.model=penalty")],
)  # fmt: skip
def test_damping_is_not_asked_for_where_it_would_be_refused(excited, takes_none):
    assert [each for each in plan_of(*excited).warnings if "contact_time_us" in each]
    assert not [each for each in plan_of(*excited, takes_none).warnings if "contact_time_us" in each]
    with pytest.raises(SceneError, match="leave one of them out"):
        read_scene(None, (*excited, takes_none, "damping.contact_time_us=12.5"))
