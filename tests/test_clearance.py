"""From the unmounted to the operating clearance: fits, temperatures, spin, films; runs and pages with it."""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.interface import rating
from fem.rating.report import write_page
from fem.statics.exact_statics import reduced_bearing
from lagrange import BallBearing, contact_laws, static_equilibrium
from lagrange.bearing import Bearing
from lagrange.contact.hertz import Pair
from lagrange.fits import OperatingClearance, Tube, operating_clearance, spinning_growth
from lagrange.kinematics import kinematics
from lagrange.rating.life import Dimensions, dynamic_capacity
from lagrange.scene.bearing import FitTable
from lagrange.scene.scene import parse_scene_text, read_scene
from lagrange.surface.film import Lubricant, film_thickness, films
from residual.cli import main as check_main
from tests.reference.kit import STEEL, STEEL_ON_STEEL, sets

NU206 = Bearing(n_rollers=13, roller_radius=4.5e-3, roller_length=8.8e-3, inner_raceway_radius=18.75e-3,
                outer_raceway_radius=27.75e-3, bore_radius=15e-3, outside_radius=31e-3, **STEEL_ON_STEEL)  # fmt: skip
ALUMINIUM = {"housing_youngs_modulus_GPa": 70.0, "housing_poisson_ratio": 0.33, "housing_expansion_1_K": 23.8e-6}
SHAFT, HOUSING = {"shaft_interference_um": 10}, {"housing_interference_um": 10, "housing_outside_diameter_mm": 100}
FITTED = ("fit.shaft_interference_um=10", "fit.inner_ring_C=60", "fit.outer_ring_C=50")


def build_up(speed: float = 0.0, bearing: Bearing = NU206, **keys) -> OperatingClearance:
    """Of a bearing and keys of [fit]; speed in rad/s."""
    roller = spinning_growth(bearing.roller_radius, 0.0, bearing.roller, kinematics(bearing, speed).roller)
    return operating_clearance(bearing, FitTable(**keys).fit(), speed, roller)


def part(name: str, speed: float = 0.0, **keys) -> float:
    return 1e6 * build_up(speed, **keys).parts[name]


def scene(*settings: str):
    return read_scene(None, ("bearing.designation=NU206", *settings))


def lame_inner(u, bore, raceway, shaft_bore=0.0, nu=0.3):
    """Growth of the raceway as handbooks have it."""
    k = raceway / bore
    s = 1.0 - nu if shaft_bore == 0.0 else ((bore / shaft_bore) ** 2 + 1) / ((bore / shaft_bore) ** 2 - 1) - nu
    return 2.0 * u * k / ((k**2 - 1) * ((k**2 + 1) / (k**2 - 1) + 0.3 + s))


def lame_outer(u, outside, raceway, housing, ratio=1.0, nu=0.3):
    """`ratio`: modulus of the ring over the housing's."""
    k, h = outside / raceway, (housing / outside) ** 2
    return 2.0 * u * k / ((k**2 - 1) * ((k**2 + 1) / (k**2 - 1) - 0.3 + ratio * ((h + 1) / (h - 1) + nu)))


@pytest.mark.parametrize(("keys", "name", "handbook", "microns"), [
    (SHAFT, "shaft_fit", lame_inner(10, 30, 37.5), 8.000),
    (SHAFT | {"shaft_bore_mm": 15.0}, "shaft_fit", lame_inner(10, 30, 37.5, 15), 7.143),
    (HOUSING, "housing_fit", lame_outer(10, 62, 55.5, 100), 7.964),
    (HOUSING | ALUMINIUM, "housing_fit", lame_outer(10, 62, 55.5, 100, 3.0, 0.33), 5.460),
])  # fmt: skip
def test_fits_of_an_nu206_are_lames(keys, name, handbook, microns):
    found = -part(name, **keys)
    assert found == pytest.approx(handbook, rel=1e-6) and found == pytest.approx(microns, abs=5e-4)
    other = {"shaft_fit": "housing_fit", "housing_fit": "shaft_fit"}[name]
    assert part(other, **keys) == 0.0 == part("temperature", **keys) == part("speed", **keys)


def test_clearances_by_temperatures_and_spin():
    """Rollers and inner ring hotter than the outer one: 11.5e-6 · 55.5 mm · 10 K, in the rule of thumb halfway.

    A thin ring by its hoop stress: the paper's raceway, 36 mm, at 4500 and 20 000 rpm. A ring pressed on a shaft of its
    steel as one disc, and one that has come loose as a ring alone: Timoshenko and Goodier, section 32.
    """
    found = build_up(inner_ring_C=30.0, rollers_C=30.0)
    assert 1e6 * found.temperature == pytest.approx(-6.3825, rel=1e-9)
    assert 1e6 * found.rule_of_thumb == pytest.approx(-5.3475, rel=1e-9)
    assert build_up(inner_ring_C=30.0).temperature == pytest.approx(found.rule_of_thumb, rel=1e-9)
    both = build_up(inner_ring_C=70.0, outer_ring_C=70.0, bearing=replace(NU206, outer_raceway_radius=27.77e-3))
    assert both.temperature == pytest.approx(50 * 11.5e-6 * 40e-6, rel=1e-6)  # the clearance itself grows
    assert part("temperature", roller_expansion_1_K=3.2e-6, rollers_C=70.0) == pytest.approx(-2 * 9e3 * 3.2e-6 * 50)
    found = build_up(**HOUSING, **ALUMINIUM, outer_ring_C=60.0, inner_ring_C=60.0)
    left = 10.0 - 40.0 * (23.8e-6 - 11.5e-6) * 62e3
    assert 1e6 * found.housing_interference == pytest.approx(left, rel=1e-9) and left < 0.0
    assert found.housing_pressure == 0.0
    assert found.housing_fit + found.temperature == pytest.approx(0.0, abs=1e-12)  # nothing of the fit is left
    cold = build_up(**SHAFT, shaft_C=10.0)
    assert 1e6 * cold.shaft_interference == pytest.approx(10.0 - 10.0 * 11.5e-6 * 30e3)
    assert 1e6 * cold.temperature == pytest.approx(lame_inner(3.45, 30, 37.5), rel=1e-6)
    speeds = np.array([4500.0, 20_000.0]) * np.pi / 30.0
    thin = Tube(inside=35.99e-3, outside=36e-3, material=STEEL)
    np.testing.assert_allclose([1e6 * thin.spun(36e-3, w) for w in speeds], [0.0968, 1.912], rtol=1e-3)
    paper = replace(NU206, inner_raceway_radius=18e-3, bore_radius=12.5e-3)
    assert 1e6 * build_up(speeds[0], paper).thin_ring == pytest.approx(-0.0968, rel=1e-3)
    speed, ends = 15_000 * np.pi / 30.0, 2.0 * NU206.inner_raceway_radius
    rollers = 4e6 * spinning_growth(NU206.roller_radius, 0.0, STEEL, kinematics(NU206, speed).roller)
    disc = 1e6 * STEEL.density * speed**2 * ends**3 * (1.0 - STEEL.poisson_ratio) / (16.0 * STEEL.youngs_modulus)
    assert part("speed", speed, **SHAFT) == pytest.approx(-disc - rollers, rel=1e-9)
    loose = build_up(speed, shaft_interference_um=0.1)
    free = Tube(inside=30e-3, outside=ends, material=STEEL).spun(ends, speed)
    assert loose.shaft_pressure == 0.0 and loose.shaft_interference < 0.0
    assert 1e6 * (loose.speed + loose.shaft_fit) == pytest.approx(-1e6 * free - rollers, rel=1e-9)
    assert disc < 0.5e6 * free


@pytest.mark.parametrize("model", ["lagrange", "reduced", "fem"])
def test_runs_have_the_clearance_in_operation(model):
    """Elastic models let their bodies grow as they spin: with that they have it."""
    found = scene(*FITTED, "operation.speed_rpm=15000", f"model={model}", "lubricant={}")
    told, bearing = found.operating_clearance(), found.ideal_bearing()
    left = 2.0 * bearing.radial_clearance - 2.0 * sum(film.thickness for film in bearing.faults)
    if model != "lagrange":
        motion = kinematics(bearing, found.ideal_operation().speed)
        reduced = reduced_bearing(found.perfect_bearing(), motion)
        left -= 2.0 * (reduced.inner_growth + 2.0 * reduced.roller_growth)
    assert left == pytest.approx(told.total, abs=5e-10)
    assert told.film < -0.5e-6 and told.total < told.given - 10e-6


def test_a_scene_without_fits_is_what_it_was():
    plain = scene()
    assert plain.perfect_bearing() == plain.unmounted_bearing() and plain.operating_clearance() is None
    cold = scene("fit.shaft_interference_um=0", "operation.speed_rpm=0")
    assert cold.perfect_bearing() == plain.perfect_bearing()
    again = parse_scene_text(scene(*FITTED).to_toml(), "again")
    assert again.operating_clearance() == scene(*FITTED).operating_clearance()
    balls = read_scene(None, ("bearing.type=ball", "model=lagrange", *FITTED)).perfect_bearing()
    assert isinstance(balls, BallBearing)
    assert scene("support.kind=bore", "fit.inner_ring_C=40").operating_clearance().temperature < 0.0  # allowed


def test_the_plan_the_report_and_the_rating_tell_the_same(here, capsys):
    text = 'name = "own"\nmodel = "lagrange"\nnumerics.duration_ms = 2\nbearing.designation = "NU206"\n'
    text += "[lubricant]\n[fit]\nshaft_interference_um = 10\ninner_ring_C = 60\n"
    Path("own.toml").write_text(text, encoding="utf-8")
    found = read_scene("own.toml")
    rows = found.operating_clearance().rows()
    assert run_main(["own.toml", "--dry-run"]) == 0
    shown = capsys.readouterr().out
    assert run_main(["own.toml", "--quiet"]) == 0
    assert check_main(["runs/own.nc", "--no-figures", "--quiet"]) == 0
    report = Path("runs/own-residual/report.html").read_text(encoding="utf-8")
    for words, number, _ in rows:
        assert re.search(rf"{words.split()[0]}\S* .*{re.escape(number)}", shown), words
        assert f"<td>{number}</td>" in report
    rated = rating(found)
    parts = rated["operating_clearance_parts_um"]
    assert sum(parts.values()) == pytest.approx(rated["operating_clearance_um"], abs=1e-5)
    assert rated["operating_clearance_um"] == pytest.approx(float(rows[-1][1]), abs=1e-3)
    assert parts["shaft_fit"] == pytest.approx(-8.0) and rated["fit_pressure_MPa"]["housing"] == 0.0
    cold = dynamic_capacity(Dimensions.of(scene().perfect_bearing()))
    assert rated["catalogue"]["C"]["ISO_N"] == pytest.approx(cold, rel=1e-12)  # not of warm, wide rings
    write_page(Path("rating.html"), rated)
    assert '<figure id="clearance">' in Path("rating.html").read_text(encoding="utf-8")


MINERAL_OIL = Lubricant(viscosity=0.01, pressure_viscosity=2.2e-8, traction_coefficient=0.05)
LUBRICATED = read_scene(None, ("lubricant.viscosity_Pa_s=0.02",))


def test_films_have_the_formulas_thickness_and_act_as_preload_in_statics():
    """Rollers of 16 mm, raceways of 64 and 96 mm at 524 rad/s, 4800 N, E' = 228 GPa: 0.3925 and 0.4673 µm.

    The formula's own arithmetic, done apart from the program. Of the paper's bearing at its largest load, 628.5 N, with
    0.02 Pa s and 2·10⁻⁸ 1/Pa 0.376 and 0.455 µm; by the power −0.13 a load 2 % off hardly matters. Films take up gap as
    raceways do that are nearer to each other: same loads, same place of the hub.
    """
    steel = replace(LUBRICATED.ideal_bearing().roller, youngs_modulus=228e9 * (1.0 - 0.3**2), poisson_ratio=0.3)
    rolling = 524.0 * (80.0**2 - 16.0**2) / (4.0 * 80.0) * 1e-3  # m/s, of the contacts over either raceway
    for raceway, micrometres in ((0.032, 0.3925), (-0.048, 0.4673)):
        pair = Pair(kind="test", radii=(raceway, 0.008), materials=(steel, steel), length=0.016)
        assert film_thickness(pair, rolling, 4800.0, MINERAL_OIL) == pytest.approx(1e-6 * micrometres, rel=3e-4)
    found = {film.body: film.thickness for film in LUBRICATED.ideal_bearing().faults}
    assert found == pytest.approx({"inner_ring": 0.376e-6, "outer_ring": 0.455e-6}, rel=0.01)
    assert films(read_scene().ideal_bearing(), replace(LUBRICATED.ideal_operation(), speed=0.0), MINERAL_OIL) == ()
    filmed, operation = LUBRICATED.ideal_bearing(), LUBRICATED.ideal_operation()
    inner, outer = (film.thickness for film in filmed.faults)
    dry = replace(filmed, faults=())
    nearer = replace(dry, outer_raceway_radius=dry.outer_raceway_radius - inner - outer)
    laws = contact_laws("harris", dry)
    one, other, bare = (static_equilibrium(bearing, operation, laws) for bearing in (filmed, nearer, dry))
    np.testing.assert_allclose(one.inner_force, other.inner_force, rtol=1e-4, atol=1e-3)
    assert one.y == pytest.approx(other.y, rel=1e-4)
    assert abs(one.y) < abs(bare.y) - 0.3 * (inner + outer)
    assert one.inner_force[0] < bare.inner_force[0] and one.inner_force[3] > 2.0 * bare.inner_force[3]
    assert (LUBRICATED.friction_coefficient, read_scene().friction_coefficient) == (0.05, 0.1)


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
@pytest.mark.parametrize("speed", ["0", "3000"])
def test_rings_that_stand_or_turn_as_one_run_without_a_film(model, speed, tmp_path):
    keys = (f"model={model}", f"operation.speed_rpm={speed}", f"operation.outer_ring_speed_rpm={speed}",
            "lubricant.viscosity_Pa_s=0.02", "numerics.mesh_size_mm=2", "numerics.duration_ms=0.05")  # fmt: skip
    assert run_main(["--quiet", "--output", str(tmp_path / "run.nc"), *sets(*keys)]) == 0
    with h5py.File(tmp_path / "run.nc") as file:
        assert file.attrs["status"] == "complete" and "inner_sinkage" not in file
