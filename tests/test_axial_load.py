"""Rows under axial load and tilting moment: reference values, energy, limits, random load cases."""

import json
from dataclasses import replace
from math import acos, cos, pi, radians, sin, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from fem.commands.rate_bearing import rate_main
from fem.rating.answers import rating
from fem.rating.ross import read_coefficients
from lagrange import Material, contact_laws
from lagrange.bearing import BallBearing, Bearing, Operation, RowLoads
from lagrange.rating.axial_load import at_rest, balanced, rigid_loads, rows_of
from lagrange.rating.life import Dimensions
from lagrange.rating.reference_life import ball_reference_life
from lagrange.rating.sources import Unavailable
from lagrange.scene.scene import read_scene
from lagrange.statics import static_equilibrium

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
GIVEN = RowLoads(None, 0.0, 0.0, None, 0.0, None, 0.0)


def bearing(elements, diameter, pitch, clearance=0.0, degrees=0.0, length=None, rows=1, grooves=(0.52, 0.53)):
    """Balls without a length; mm, diametral clearance."""
    across = cos(radians(degrees))
    inner, outer = (0.5e-3 * (pitch + sign * (diameter + 0.5 * clearance) * across) for sign in (-1, 1))
    same = {"n_rollers": elements, "roller_radius": 0.5e-3 * diameter * across, "inner_raceway_radius": inner,
        "roller_length": 1e-3 * (length or diameter), "outer_raceway_radius": outer, "bore_radius": 0.7 * inner,
        "outside_radius": 1.2 * outer, "roller": STEEL, "inner_ring": STEEL, "outer_ring": STEEL,
        "contact_angle": radians(degrees), "rows": rows}  # fmt: skip
    if length:
        return Bearing(**same)
    inner, outer = (1e-3 * groove * diameter for groove in grooves)
    return BallBearing(**same, inner_groove_radius=inner, outer_groove_radius=outer)


def solve(of, radial=0.0, axial=0.0, moment=None, side=0.0, **given):
    """Loads in N, N mm."""
    moment = None if moment is None else 1e-3 * moment
    given = GIVEN._replace(axial_load=axial, moment=moment, **given)
    return at_rest(of, np.array([side, -radial]), given, laws_of(of), -0.5 * pi)


def laws_of(of):
    return contact_laws("hertz" if isinstance(of, BallBearing) else "iso16281", of)


def angles_of(of):
    return -0.5 * pi + 2.0 * pi * np.arange(of.n_rollers) / of.n_rollers


DEEP, STEEP, TAPERED = bearing(9, 11.906, 60, 0.02), bearing(14, 12.7, 70, 0.0, 40), bearing(17, 13, 83, 0.0, 14, 22)
MIRRORED = {"arrangement": "back_to_back", "row_distance": 0.024}


@pytest.mark.parametrize(
    ("clearance", "radial", "axial", "moment", "displaced", "tilt", "life"),
    [(0.0, 1000, 0, 0, (15.1101, 0), 0, 13_163.019), (0.0, 0, 1000, 0, (0, 133.5381), 0, 2222.7318),
     (0.01, 1000, 0, 0, (21.223, 0), 0, 10_795.7948), (0.01, 0, 1000, 0, (0, 149.1717), 0, 3115.8781),
     (0.01, 1000, 1000, 0, (19.5923, 146.4603), 2.6872, 1630.5367), (0.0, 0, 0, 1000, None, 3.6957, 785_144.7521),
     (0.01, 1000, 1000, 1000, (19.7144, 146.3084), 2.7239, 1627.7479)],
)  # fmt: skip
def test_rows_free_to_tilt_agree_with_a_commercial_program(clearance, radial, axial, moment, displaced, tilt, life):
    """Of github.com/minzhun/ISO16281, Test_BallBearing.py: C = 23 400 N, moments about the direction of the load."""
    of = bearing(7, 11.5, 43.5, clearance)
    load = np.array([0.0, -radial, axial, 0.0, moment])
    found = balanced(rows_of(of, GIVEN, laws_of(of), angles_of(of)), load, [True] * 5, np.zeros(5))
    radially, axially = 1e3 * np.hypot(*found.hub[:2]), 1e3 * found.hub[2]
    assert displaced is None or (radially, axially) == pytest.approx(displaced, rel=2e-4, abs=1e-3)
    assert 1e3 * np.hypot(*found.hub[3:]) == pytest.approx(tilt, rel=2e-4, abs=1e-9)
    assert ball_reference_life(of, 23_400.0, found.rows[0].loads[None]) == pytest.approx(life, rel=5e-4)


@pytest.mark.parametrize(
    ("of", "radial", "axial", "displaced", "largest", "least", "angles", "moment"),
    [(DEEP, 2000, 1000, (9.218, 48.72 + 108.66), 938.9, 40.6, (14.83, 15.27), 15_883),
     (DEEP, 500, 2000, (1.826, 71.27 + 108.66), 874.0, 648.6, (17.04, 17.14), 4517),
     (STEEP, 0, 5000, (0.0, 20.44), 540.2, 540.2, (41.384, 41.384), 0),
     (STEEP, 3000, 5000, (13.056, 19.04), 1166.8, 47.9, (40.54, 42.07), 89_743),
     (TAPERED, 20_000, 8000, (9.891, 35.77), 4679, 0, (14, 14), 206_942),
     (TAPERED, 5000, 8000, (2.162, 40.78), 2564.9, 1362.8, (14, 14), 51_736),
     (TAPERED, 0, 8000, (0.0, 40.96), 1945.2, 1945.2, (14, 14), 0)],
)  # fmt: skip
def test_rows_held_from_tilting_agree_with_another_calculation(
    of, radial, axial, displaced, largest, least, angles, moment
):
    """ISO/TS 16281 in another program: approaches of all elements by scipy's fsolve."""
    found = solve(of, radial, axial)
    row = found.rows[0]
    assert (-1e3 * found.hub[1], 1e3 * found.hub[2]) == pytest.approx(displaced, rel=2e-3, abs=1e-6)
    assert (row.loads.max(), row.loads.min()) == pytest.approx((largest, least), rel=2e-3, abs=0.2)
    loaded = np.degrees(row.angle[row.loads > 0.0])
    assert (loaded.min(), loaded.max()) == pytest.approx(angles, rel=2e-3)
    assert -found.force[3] == pytest.approx(moment, rel=2e-3, abs=1e-3)


CASES = [(DEEP, {}), (STEEP, {}), (TAPERED, {}), (bearing(13, 10, 46, 0.02, length=10), {"flange_height": 2e-3}),
    (bearing(14, 12.7, 70, 0.0, 40, rows=2), MIRRORED | {"preload": 500.0}),
    (bearing(17, 13, 83, 0.01, 14, 22, rows=2), MIRRORED | {"arrangement": "face_to_face"})]  # fmt: skip
NAMES = "deep groove", "angular contact", "tapered", "flanged", "balls back to back", "rollers face to face"


@pytest.mark.parametrize(("of", "given"), CASES, ids=NAMES)
def test_loads_are_the_gradient_of_the_energy_and_stiffness_that_of_loads(of, given):
    rows = rows_of(of, GIVEN._replace(axial_load=1.0, **given), laws_of(of), angles_of(of))
    hub = np.array([4e-3, -0.02, 4e-3, 4e-4, -3e-4])
    steps = 1e-6 * np.diag([1.0, 1.0, 1.0, 0.03, 0.03])
    for row in rows:
        here, ahead, behind = row.at(hub), *([row.at(hub + sign * step) for step in steps] for sign in (1, -1))
        energy = [(a.energy - b.energy) / (2 * step.max()) for a, b, step in zip(ahead, behind, steps, strict=True)]
        forces = [(a.force - b.force) / (2 * step.max()) for a, b, step in zip(ahead, behind, steps, strict=True)]
        assert here.energy > 0.0
        assert here.force == pytest.approx(energy, rel=1e-6, abs=1e-6 * np.abs(here.force).max())
        assert here.stiffness == pytest.approx(np.array(forces), rel=1e-6, abs=1e-6 * np.abs(here.stiffness).max())
        assert np.array_equal(here.stiffness, here.stiffness.T) or here.stiffness == pytest.approx(here.stiffness.T)


@pytest.mark.parametrize("axial", [0.0, 1e-4])
def test_without_axial_load_balls_are_in_the_plane_equilibrium(axial):
    """At a small load: in the plane the hub's displacement over the radius turns the contacts."""
    of, operation = bearing(7, 11.5, 43.5), Operation(speed=0.0, radial_load=30.0, inner_mass=0.0, gravity=0.0,
        first_roller_angle=-0.5 * pi)  # fmt: skip
    plane = static_equilibrium(of, operation, contact_laws("hertz", of))
    found = solve(of, 30.0, axial)
    assert 1e-3 * found.hub[1] == pytest.approx(plane.hub[1], rel=1e-4)
    assert found.rows[0].loads == pytest.approx(plane.inner_force, rel=1e-4, abs=1e-2)
    assert 1e3 * found.stiffness[1, 1] == pytest.approx(plane.stiffness[1, 1], rel=1e-4)


def test_a_vanishing_contact_angle_has_the_load_distribution_of_none():
    of = bearing(13, 10, 46, 0.02, 1e-5, length=10)
    distribution = rigid_loads(Dimensions.of(of), 5000.0, 0.02, 1e-3)
    found = solve(of, 5000.0, tilt=1e-3)
    assert found.rows[0].inner == pytest.approx(distribution.loads, rel=1e-4, abs=0.05)
    assert abs(found.force[3]) == pytest.approx(abs(distribution.moment), rel=1e-4)


@pytest.mark.parametrize("degrees", [15.0, 25.0, 40.0])
def test_centred_thrust_agrees_with_harris_closed_form(degrees):
    """F_a/(Z K A^1.5) = sin α (cos α°/cos α − 1)^1.5, Harris (4th ed. 2001), (7.33)."""
    of, thrust, angle = bearing(14, 12.7, 70, 0.0, degrees), 5000.0, radians(degrees)
    found = solve(of, 0.0, thrust)
    (row,) = rows_of(of, GIVEN, laws_of(of), np.zeros(1))
    closed = brentq(
        lambda a: 14 * row.law.stiffness * row.span**1.5 * sin(a) * (cos(angle) / cos(a) - 1.0) ** 1.5 - thrust,
        angle,
        1.5,
    )
    assert found.rows[0].angle == pytest.approx(closed, rel=1e-3)
    assert found.rows[0].loads == pytest.approx(thrust / (14 * sin(closed)), rel=1e-3)


def test_flanges_tilt_rollers_until_raceways_bear_the_couple():
    """The hub's axial load times the arm is what the raceways' pressures turn rollers with: moments about them."""
    of, height = bearing(13, 10, 46, 0.02, length=10), 2e-3
    found = solve(of, 5000.0, 1000.0, flange_height=height)
    row, x = found.rows[0], (np.arange(40) - 19.5) * 10 / 40
    assert found.force[:3] == pytest.approx([0.0, -5000.0, 1000.0], abs=1e-6)
    couples = row.outer @ x - row.inner @ x
    assert couples.sum() == pytest.approx(1000.0 * (10.0 - 2.0), rel=1e-9)
    assert row.inner.sum(axis=1) == pytest.approx(row.outer.sum(axis=1), abs=1e-6)
    assert row.loads @ np.cos(2 * pi * np.arange(13) / 13) == pytest.approx(5000.0)
    assert row.inner.max() > solve(of, 5000.0).rows[0].inner.max()


def test_preload_and_stiffness_of_a_pair_are_those_of_two_rows_by_hand():
    """Back to back the lines of contact spread: it holds a tilt better by (distance of pressure centres)²."""
    pair = replace(STEEP, rows=2)
    spread = {}
    for arrangement in ("back_to_back", "face_to_face"):
        found = solve(pair, arrangement=arrangement, row_distance=0.024, preload=500.0)
        thrusts = [row.loads @ np.sin(row.angle) for row in found.rows]
        assert thrusts == pytest.approx([500.0, -500.0], rel=1e-6)
        spread[arrangement] = found.stiffness[3, 3]
    alone = solve(STEEP, 0.0, 500.0)
    assert found.stiffness[2, 2] == pytest.approx(2.0 * alone.stiffness[2, 2], rel=1e-6)
    assert found.stiffness[1, 1] == pytest.approx(2.0 * alone.stiffness[1, 1], rel=1e-6)
    reach = 35.0 * tan(acos(cos(alone.rows[0].angle[0])))
    expected = ((12.0 + reach) / (12.0 - reach)) ** 2
    assert spread["back_to_back"] > 0.3 * expected * spread["face_to_face"] > spread["face_to_face"]


def test_a_row_that_slides_open_names_the_least_axial_load():
    with pytest.raises(Unavailable, match="40000 N of radial load need 9973 N of axial load at least"):
        solve(TAPERED, 40_000.0, 8000.0)


def test_random_load_cases_of_all_kinds_have_one_equilibrium_from_wherever_they_start():
    draw = np.random.default_rng(53)
    for case in range(500):
        of, given = CASES[case % len(CASES)]
        radial, side, axial = draw.uniform(0.0, 8000.0), draw.uniform(-2000.0, 2000.0), draw.uniform(-4000.0, 4000.0)
        if of.contact_angle and of.rows == 1:
            axial = np.copysign(1.3 * np.hypot(radial, side) * tan(of.contact_angle) + abs(axial), axial)
        tilts = case % 3 == 0 and (of.rows == 2 or not of.contact_angle)
        moment, kept = draw.uniform(-3e4, 3e4) if tilts else None, 5 if tilts else 3
        found, load = (
            solve(of, radial, axial, moment, side, **given),
            np.array([side, -radial, axial, moment or 0.0, 0.0]),
        )
        assert found.force[:kept] == pytest.approx(load[:kept], abs=1e-5), case
        if case % 5 == 0:
            start = np.zeros(5)
            start[:kept] = (draw.normal(size=5) * [0.1, 0.1, 0.1, 1e-3, 1e-3])[:kept]
            rows = rows_of(of, GIVEN._replace(axial_load=axial, **given), laws_of(of), angles_of(of))
            again = balanced(rows, load, np.arange(5) < kept, start)
            assert again.hub == pytest.approx(found.hub, rel=1e-6, abs=1e-9), case


@pytest.fixture(scope="module")
def rated(tmp_path_factory):
    """By the command: a deep-groove bearing free to tilt under both loads, with page and coefficients."""
    folder = tmp_path_factory.mktemp("axial")
    loads = "radial_load_N=1000 axial_load_N=1000 moment_N_m=0 gravity_m_s2=0"
    sizes = ("type=ball rollers=7 roller_diameter_mm=11.5 pitch_diameter_mm=43.5 clearance_um=10 bore_diameter_mm=25 "
             "dynamic_load_rating_N=23400")  # fmt: skip
    keys = [f"operation.{load}" for load in loads.split()] + [f"bearing.{size}" for size in sizes.split()]
    options = [option for key in keys for option in ("--set", key)]
    assert rate_main([*options, "--output", str(folder), "--ross", str(folder / "ross.csv"), "--quiet"]) == 0
    (file,) = folder.glob("*.json")
    return json.loads(file.read_text(encoding="utf-8")), folder


def test_the_command_says_where_the_hub_is_and_how_stiff(rated):
    """The fifth row above."""
    answers, folder = rated
    x, y, z = answers["hub_displacement_um"]
    assert (x, -y, z) == pytest.approx((0.0, 19.592, 146.46), rel=2e-3, abs=1e-6)
    assert answers["hub_tilt_mrad"] == pytest.approx(2.687, rel=2e-3)
    assert answers["L10r_Mrev"] * (23_400 / answers["C_N"]) ** 3 == pytest.approx(1630.5, rel=5e-3)
    stiffness = np.array(answers["stiffness_5x5"])
    assert stiffness == pytest.approx(stiffness.T, rel=1e-9, abs=1.0)
    radial = stiffness - stiffness[:, 2:] @ np.linalg.solve(stiffness[2:, 2:], stiffness[2:])
    assert np.array(answers["stiffness_N_per_m"]) == pytest.approx(radial[:2, :2], rel=1e-9, abs=1.0)
    assert read_coefficients(folder / "ross.csv")["kyy"] == pytest.approx(radial[1, 1], rel=1e-6)
    assert answers["moment_on_hub_N_m"] is None
    assert "free to tilt" in answers["reasons"]["moment_on_hub_N_m"]
    assert "Loads of rolling elements" in (folder / "rating.html").read_text(encoding="utf-8")


def test_a_mirrored_pair_is_rated_under_the_scene_s_own_loads():
    sizes = "type=ball rollers=14 roller_diameter_mm=12.7 pitch_diameter_mm=70 contact_angle_deg=40 rows=2"
    pair = "arrangement=back_to_back row_distance_mm=18 preload_N=300"
    loads = "radial_load_N=2000 axial_load_N=1500 moment_N_m=20 inner_ring_and_shaft_kg=2 gravity_m_s2=10"
    keys = [f"bearing.{key}" for key in f"{sizes} {pair}".split()] + [f"operation.{key}" for key in loads.split()]
    found = rating(read_scene(None, keys))
    assert [found[f"{name}_N"] for name in ("radial_load", "axial_load", "weight")] == pytest.approx([2000, 1500, 20])
    assert found.case.balance.force == pytest.approx([0.0, -2020.0, 1500.0, 20e3, 0.0], abs=1e-5)
    assert found["contact_angle_range_deg"][0] < 40.0 < found["contact_angle_range_deg"][1]


def test_a_pair_whose_other_row_is_open_lives_as_the_row_alone():
    sizes = "rollers=17 roller_diameter_mm=13 roller_length_mm=22 pitch_diameter_mm=83 contact_angle_deg=14"
    loads = "radial_load_N=4000 axial_load_N=5000 gravity_m_s2=0"
    keys = [f"bearing.{key}" for key in sizes.split()] + [f"operation.{key}" for key in loads.split()]
    pair = ("bearing.rows=2", "bearing.arrangement=back_to_back", "bearing.row_distance_mm=30")
    alone, both = rating(read_scene(None, keys)), rating(read_scene(None, (*keys, *pair)))
    assert not both.case.balance.rows[1].loads.any()
    assert both["L10r_Mrev"] == pytest.approx(alone["L10r_Mrev"], rel=1e-9)
