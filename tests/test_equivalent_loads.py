"""Equivalent loads, reliability and reference lives against catalogues, worked examples and other programs."""

from math import cos, radians, tan

import numpy as np
import pytest
from scipy.optimize import brentq, root
from scipy.special import ellipe, ellipk

from lagrange.rating import equivalent, life
from lagrange.rating import reference_life as rl
from lagrange.rating.life import Dimensions
from lagrange.scene.scene import read_scene

ROW = Dimensions(rollers=13, diameter=10.0, length=10.0, pitch=46.0)


def balls(number=7, diameter=11.5, pitch=43.5, angle=0.0, rows=1):
    keys = (
        f"type='ball',rollers={number},roller_diameter_mm={diameter},pitch_diameter_mm={pitch},roller_length_mm=15,"
        f"bore_diameter_mm=20,outside_diameter_mm={pitch + 2.2 * diameter},contact_angle_deg={angle},rows={rows}"
    )
    return read_scene(None, (f"bearing={{{keys}}}", "model=lagrange")).perfect_bearing()


def rollers(angle):
    keys = (f"rollers=16,roller_diameter_mm=8,roller_length_mm=10,pitch_diameter_mm=70,contact_angle_deg={angle},"
            "bore_diameter_mm=40,outside_diameter_mm=100")  # fmt: skip
    return read_scene(None, (f"bearing={{{keys}}}", "model=lagrange")).perfect_bearing()


@pytest.mark.parametrize(("angle", "mirrored", "e", "y1", "x", "y"), [
    (25.0, False, 0.68, 0.0, 0.41, 0.87), (30.0, False, 0.80, 0.0, 0.39, 0.76), (40.0, False, 1.14, 0.0, 0.35, 0.57),
    (40.0, True, 1.14, 0.55, 0.57, 0.93), (30.0, True, 0.80, 0.78, 0.63, 1.24), (25.0, True, 0.68, 0.92, 0.67, 1.41),
])  # fmt: skip
def test_angular_contact_has_the_makers_factors_of_one_row_and_of_pairs(angle, mirrored, e, y1, x, y):
    """SKF's and NSK's: of 40° P = 0.35 F_r + 0.57 F_a, in pairs F_r + 0.55 F_a and 0.57 F_r + 0.93 F_a."""
    found = equivalent.factors(balls(14, 12.7, 70.0, angle, 1 + mirrored), 30e3, 3e3, mirrored)
    assert found == pytest.approx((e, y1, x, y))


@pytest.mark.parametrize(("angle", "mirrored", "pressed", "factors"), [
    (15.0, False, 0.357, (0.40, 0.0, 0.44, 1.40)), (15.0, False, 1.43, (0.47, 0.0, 0.44, 1.19)),
    (15.0, True, 3.57, (0.55, 1.14, 0.72, 1.66)), (10.0, False, 0.175, (0.29, 0.0, 0.46, 1.88)),
    (12.5, False, 1.41, (0.435, 0.0, 0.45, 1.265)),
])  # fmt: skip
def test_small_contact_angles_have_factors_of_the_axial_load_over_static_capacity(angle, mirrored, pressed, factors):
    """f0 i F_a/C0 of the tables of 15° spindle bearings; 10° beside it, and halfway between the two angles."""
    bearing = balls(16, 9.5, 60.0, angle, 1 + mirrored)
    static = life.Basic.of(bearing).static
    f0 = life.static_factor(bearing.roller_radius / bearing.pitch_radius)
    found = equivalent.factors(bearing, static, pressed * static / (f0 * (1 + mirrored)), mirrored)
    assert found == pytest.approx(factors, abs=0.006)


def test_factors_meet_at_their_limit_and_loads_are_even_in_the_axial_load():
    """P = F_r at F_a = e F_r, of pairs (1 + Y1 e) F_r, as far as the standard rounds."""
    for bearing, mirrored in ((balls(), False), *((balls(14, 12.7, 70.0, angle, 1 + pair), bool(pair))
                              for angle in (10, 15, 17, 20, 33, 45) for pair in (0, 1)), (rollers(14), False),
                              (rollers(14), True)):  # fmt: skip
        for axial in (10.0, 500.0, 2e3, 20e3):
            found = equivalent.factors(bearing, 30e3, axial, mirrored)
            assert found.X + found.Y * found.e == pytest.approx(1.0 + found.Y1 * found.e, rel=0.021)
            assert found.load(700.0, -axial) == found.load(700.0, axial) >= 0.98 * found.X * 700.0
    assert equivalent.static_load(balls(), 1000.0, 3000.0) == pytest.approx(0.6 * 1000 + 0.5 * 3000)
    assert equivalent.static_load(balls(angle=40), 1000.0, -5000.0) == pytest.approx(0.5 * 1000 + 0.26 * 5000)
    assert equivalent.static_load(balls(angle=40, rows=2), 1000.0, 5000.0, True) == pytest.approx(1000 + 0.52 * 5000)
    assert equivalent.static_load(rollers(14), 100.0, 900.0) == pytest.approx(50 + 0.22 / tan(radians(14)) * 900)
    assert equivalent.static_load(balls(), 1000.0, 10.0) == 1000.0


def test_flanges_carry_what_the_maker_says():
    """SKF: 0.5 F_r; 0.0045 D^1.5 kN, of wider series 0.0023 D^1.7; heat. NUP 312, C0 120 kN, d 60, D 130 mm."""
    limit = equivalent.flange_limit
    assert limit(120e3, 60.0, 130.0, 500.0, 10e3, "3") == 5000.0
    assert limit(120e3, 60.0, 130.0, 100.0, 80e3, "3") == pytest.approx(2.3 * 130.0**1.7)
    assert limit(120e3, 60.0, 130.0, 100.0, 80e3, "2") == pytest.approx(4.5 * 130.0**1.5)
    assert limit(120e3, 60.0, 130.0, 3000.0, 10e3, "3") == pytest.approx(1e3 * (1.5 * 120e4 / (3000.0 * 190.0) - 1.5))
    assert limit(120e3, 60.0, 130.0, 20000.0, 10e3) == 0.0
    assert (equivalent.least_load(30e3, balls=True), equivalent.least_load(30e3, balls=False)) == (300.0, 600.0)


def test_reliability_is_the_distribution_behind_the_standards_factors():
    """ISO 281:2007 table 12 rounds what ISO/TR 1281-2's distribution gives; all bearings reach 0.05 L10."""
    for percent, rounded in life.RELIABILITY.items():
        assert life.reliability_factor(percent) == rounded
        assert life.reliability(rounded) == pytest.approx(percent, abs=0.1)
        assert life.reliability_factor(percent - 1e-9) == pytest.approx(rounded, abs=0.0051)
    assert life.reliability(1.0) == pytest.approx(90.0) and life.reliability(0.05) == 100.0
    assert life.reliability(life.reliability_factor(98.5)) == pytest.approx(98.5)
    assert life.reliability(2.0) == pytest.approx(73.4, abs=0.05) and life.reliability(60.0) < 1e-9


def test_required_capacity_of_worked_examples():
    """NSK, Rolling Bearings (E1102), 5.7, example 2: 3000 N, 1900 1/min, 10 000 h: 31 380 N of balls; NTN, Ball and
    Roller Bearings (2202), 4.6, example 3: 200 kN, 450 1/min, 20 000 h: 1313 kN of rollers; factors by nomogram."""
    turns = life.revolutions(10_000.0, -1900.0)
    assert turns == pytest.approx(1140.0) and life.in_hours(turns, 1900.0) == pytest.approx(10_000.0)
    assert life.required_capacity(3000.0, turns, life.OF_BALLS) == pytest.approx(31_380, rel=2e-3)
    assert life.required_capacity(200e3, life.revolutions(20_000.0, 450.0)) == pytest.approx(1_313e3, rel=6e-3)


def ball_loads(clearance, radial, axial, moment, d=11.5, pitch=43.5, f=(0.52, 0.53)):
    """N, of seven balls: ISO/TS 16281 (1) to (18), with its moment of half the pitch diameter."""
    span, soft = (sum(f) - 1.0) * d, 0.0
    for k, side in zip(f, (1.0, -1.0), strict=True):
        curved = side * d / pitch / (1.0 - side * d / pitch)
        sums, share = 2.0 / d * (2.0 + curved - 0.5 / k), (curved + 0.5 / k) / (2.0 + curved - 0.5 / k)

        def of_ellipse(chi, share=share):
            modulus = 1.0 - chi**-2
            return 1.0 - 2.0 / (chi**2 - 1.0) * (ellipk(modulus) / ellipe(modulus) - 1.0) - share

        chi = brentq(of_ellipse, 1.01, 100.0)
        soft += ellipk(1.0 - chi**-2) * (sums / (chi**2 * ellipe(1.0 - chi**-2))) ** (1 / 3)
    stiff, cosine = 1.48 * 210e3 / 0.91 * soft**-1.5, 1.0 - clearance / (2.0 * span)
    around, arm = np.cos(2.0 * np.pi * np.arange(7) / 7), 0.5 * pitch + (f[0] - 0.5) * d * cosine

    def at(hub):
        u, v = span * cosine + hub[0] * around, span * np.sqrt(1.0 - cosine**2) + hub[1] + arm * hub[2] * around
        return stiff * np.maximum(np.hypot(u, v) - span, 0.0) ** 1.5, np.arctan2(v, u)

    def left(hub):
        loads, angle = at(hub)
        out, along = loads * np.cos(angle), loads * np.sin(angle)
        return out @ around - radial, along.sum() - axial, along @ around - moment / (0.5 * pitch)

    start = [0.01, 0.02 if axial or moment else 0.0, 1e-3 if moment else 0.0]
    return at(root(left, start, tol=1e-12).x)[0]


@pytest.mark.parametrize(("clearance", "load", "lives"), [
    (0.0, (1000, 0, 0), 13_163.019), (0.0, (0, 1000, 0), 2222.7318), (0.01, (1000, 0, 0), 10_795.7948),
    (0.01, (0, 1000, 0), 3115.8781), (0.01, (1000, 1000, 0), 1630.5367),
])  # fmt: skip
def test_reference_lives_of_balls_are_those_of_a_commercial_program(clearance, load, lives):
    """7 balls of 11.5 mm on 43.5 mm, C = 23 400 N: github.com/minzhun/ISO16281, Test_BallBearing.py."""
    found = rl.ball_reference_life(balls(), 23_400.0, ball_loads(clearance, *load)[None])
    assert found == pytest.approx(lives, rel=1e-3)


@pytest.mark.parametrize("angle", [15.0, 40.0])
def test_reference_lives_of_a_half_loaded_row_are_those_of_the_equivalent_load_at_any_contact_angle(angle):
    """F_r = Z cos α mean(Q cos φ), and (Q_c/Q_e)^(10/3) ~ (C/F_r)^(10/3): the capacity of a ball has cos α, so that
    L10r/L10 depends on D cos α/D_pw alone. Two rows that share a load live as one with i^0.7 of its capacity."""
    around = np.maximum(np.cos(2.0 * np.pi * np.arange(200) / 200.0), 0.0)
    lives = []
    for row in (balls(200, 0.6 / cos(radians(angle)), 60.0, angle), balls(200, 0.6, 60.0)):
        loads = 10.0 * around**1.5
        radial = row.cosine * float(loads @ np.cos(2.0 * np.pi * np.arange(200) / 200.0))
        lives.append(rl.ball_reference_life(row, 1e4, loads[None]) / life.basic_life(1e4, radial, 3.0))
    assert lives[0] == pytest.approx(lives[1], rel=1e-6) and 0.9 < lives[0] < 1.1
    loads = np.tile(around**1.5, (2, 1))
    pair, one = (rl.ball_reference_life(balls(200, 0.6, 60.0, rows=n), 1e4 * n**0.7, loads[:n] / n) for n in (2, 1))
    assert pair == pytest.approx(2.0 ** (0.7 * 3.0) * one, rel=1e-9)


def test_rings_that_stand_against_the_load_weigh_the_largest_ball_load_more():
    loads = np.array([[1000.0, 500.0, 100.0, 0.0, 0.0, 100.0, 500.0]])
    of = {turning: rl.ball_reference_life(balls(), 23_400.0, loads, turning=turning)
          for turning in (("inner",), ("outer",), ("inner", "outer"))}  # fmt: skip
    assert of["outer",] < of["inner",] < of["inner", "outer"]
    with pytest.raises(life.Unavailable, match="without load"):
        rl.ball_reference_life(balls(), 23_400.0, 0.0 * loads)


def test_modified_lives_of_laminae_weigh_each_by_its_own_load():
    """ISO 16281:2025 (31): of a half-loaded row without clearance and profile the load of every lamina is 0.323/0.378
    of F_r, less what its edges are stressed more."""
    capacity, met = life.dynamic_capacity(ROW), []
    loads = rl.rigid_loads(ROW, 2000.0, profile=False).loads
    basic = rl.reference_life(ROW, capacity, loads)
    assert rl.reference_life(ROW, capacity, loads, a_iso=lambda load: 3.0) == pytest.approx(3.0 * basic)
    found = rl.reference_life(ROW, capacity, loads, a_iso=lambda load: met.append(load) or 1.0 + 2000.0 / load)
    assert len(met) == rl.LAMINAE and met[20] == pytest.approx(2000.0 * 0.323 / 0.378, rel=0.02)
    edges = rl.edge_factor() / rl.edge_factor()[20]
    assert met == pytest.approx(list(met[20] * edges), rel=1e-6) and basic < found
    tilted = rl.rigid_loads(ROW, 2000.0, tilt=4e-3).loads
    short = rl.reference_life(ROW, capacity, tilted, a_iso=lambda load: 1.0 + 2000.0 / load)
    assert short < found and short > rl.reference_life(ROW, capacity, tilted)
