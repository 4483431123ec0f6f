"""Contact angle and rows: the section's loads, stiffness, frequencies and ratings are the bearing's, by cos α and i."""

import json
import re
from math import cos, pi, radians, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from fem.commands.run_fem import run_main
from fem.interface import statics
from fem.rating.answers import Case, Options, rating
from lagrange import contact_laws
from lagrange.contact.hertz import contact_pairs, raceway_curvature
from lagrange.kinematics import kinematics
from lagrange.rating.life import Dimensions, capacity_factor, dynamic_capacity, static_capacity
from lagrange.rating.reference_life import reference_life
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import Scene, parse_scene_text
from residual.cli import main as check_main
from residual.measured.diagnosis import Geometry

ZA_2115 = {  # catalogue data
    "rollers": 16, "rows": 2, "roller_diameter_mm": 8.4074, "roller_length_mm": 10.0, "pitch_diameter_mm": 71.501,
    "contact_angle_deg": 15.17, "bore_diameter_mm": 49.2125, "outside_diameter_mm": 93.0,
}  # fmt: skip
ACBB_218 = {  # Harris' angular-contact ball bearing
    "type": "ball", "rollers": 16, "roller_diameter_mm": 22.23, "pitch_diameter_mm": 125.26, "contact_angle_deg": 40.0,
    "inner_conformity": 0.5232, "outer_conformity": 0.5232, "bore_diameter_mm": 90.0, "outside_diameter_mm": 160.0,
}  # fmt: skip
STILL = {"radial_load_N": 13345.0, "speed_rpm": 0.0, "gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 8.0}


def scene(bearing, model="lagrange", law=None, **operation):
    options = {} if law is None else {"lagrange": {"law": law}}
    return Scene(model=model, bearing=bearing, operation=STILL | operation, **options)


def by_hand(bearing, laws, load, clearance=0.0, rows=1):
    """Radial displacement of the inner ring, m, loads of elements, N, and stiffness, N/m, of rigid rings in 3-D.

    Source: Harris, Rolling Bearing Analysis, chapter 7: approaches (δ_r cos ψ − P_d/2) cos α, F_r = i Σ Q cos α cos ψ.
    """
    alpha = bearing.contact_angle
    psi = 2.0 * pi * np.arange(bearing.n_rollers) / bearing.n_rollers

    def loads(displacement):
        approach = (displacement * np.cos(psi) - 0.5 * clearance) * cos(alpha)
        both = [brentq(lambda q, a=a: sum(law.approach(q) for law in laws) - a, 0.0, 1e7) if a > 0.0 else 0.0
                for a in approach]  # fmt: skip
        return np.array(both)

    def carried(displacement):
        return rows * float(np.sum(loads(displacement) * np.cos(psi))) * cos(alpha)

    found = brentq(lambda d: carried(d) - load, 1e-9, 1e-3, xtol=1e-15)
    step = 1e-4 * found
    return found, loads(found), (carried(found + step) - carried(found - step)) / (2.0 * step)


def test_catalogue_data_give_the_measured_bearing_s_lines():
    """Rexnord ZA-2115 at 2000 rpm: BPFO 236.40 Hz; FTF, BPFI and BSF by Harris' formulas."""
    bearing = Scene(bearing=ZA_2115).perfect_bearing()
    shaft, share = 2000.0 / 60.0, 8.4074 * cos(radians(15.17)) / 71.501
    found = kinematics(bearing, 2.0 * pi * shaft).frequencies
    assert found["BPFO"] == pytest.approx(236.40, abs=0.005)
    assert found["FTF"] == pytest.approx(0.5 * shaft * (1.0 - share), rel=1e-9)
    assert found["BPFI"] == pytest.approx(8.0 * shaft * (1.0 + share), rel=1e-9)
    assert found["BSF"] == pytest.approx(0.5 * shaft * 71.501 / 8.4074 * (1.0 - share**2), rel=1e-9)
    measured = Geometry.of(bearing).lines(shaft)  # check-vibration's
    assert {name: measured[name] for name in found} == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize("clearance_um", [0.0, 40.0])
def test_tapered_rollers_by_palmgren(clearance_um):
    """Loads, displacement and stiffness in both rows; δ_r = 7.68e-5/cos α Q^0.9/L^0.8 under the load.

    Source of the formula: Palmgren, Ball and Roller Bearing Engineering; N and mm.
    """
    bearing = ZA_2115 | {"clearance_um": clearance_um}
    case = scene(bearing, law="palmgren")
    section, found = case.perfect_bearing(), statics(case)
    u, loads, stiffness = by_hand(section, contact_laws("palmgren", section), 13345.0, 1e-6 * clearance_um, rows=2)
    np.testing.assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=1e-3, atol=0.5)
    assert -found.hub[1] / section.cosine == pytest.approx(u, rel=1e-3)
    closed = 1e-3 * 7.68e-5 / section.cosine * loads.max() ** 0.9 / 10.0**0.8 + 0.5e-6 * clearance_um
    assert u == pytest.approx(closed, rel=1e-6)
    assert found.stiffness == pytest.approx(stiffness, rel=5e-3)
    first = Case(case, Options()).pitch.stiffness[0]  # with a roller under the load
    assert first[1, 1] == pytest.approx(stiffness, rel=5e-3)


def test_harris_angular_contact_ball_bearing():
    """Sums of curvatures of Harris' 218 bearing (γ = 0.1359), second hand; loads and stiffness by cos α."""
    case = scene(ACBB_218, radial_load_N=17800.0)
    bearing = case.perfect_bearing()
    inner, outer = (raceway_curvature(bearing, side) for side in ("inner", "outer"))
    assert [1e-3 * inner.sum, 1e-3 * outer.sum] == pytest.approx([0.108, 0.0832], abs=2e-4)
    share, groove = 22.23 * cos(radians(40.0)) / 125.26, 1.0 / 0.5232
    for found, term in ((inner, 2.0 * share / (1.0 - share)), (outer, -2.0 * share / (1.0 + share))):
        assert found.difference == pytest.approx((groove + term) / (4.0 - groove + term), rel=1e-9)  # Harris (2.29)
    assert bearing.roller_mass == pytest.approx(7850.0 * pi / 6.0 * 0.02223**3 * cos(radians(40.0)), rel=1e-12)
    u, loads, stiffness = by_hand(bearing, contact_laws("hertz", bearing), 17800.0)
    found = statics(case)
    np.testing.assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=2e-3, atol=1.0)
    assert -found.hub[1] / bearing.cosine == pytest.approx(u, rel=2e-3)
    assert found.stiffness == pytest.approx(stiffness, rel=5e-3)
    stribeck = 4.37 * 17800.0 / (16 * bearing.cosine)
    assert loads.max() == pytest.approx(stribeck, rel=0.02)  # of many balls


@pytest.mark.parametrize("bearing", [ZA_2115, ACBB_218], ids=["tapered rollers", "balls"])
def test_centrifugal_forces_act_by_their_component_along_the_contacts(bearing):
    """m ω² d_m/2 cos α on elements that carry no load, ω of the cage by Harris' kinematics."""
    case = scene(bearing, speed_rpm=6000.0)
    size, pitch, angle = (
        bearing["roller_diameter_mm"],
        bearing["pitch_diameter_mm"],
        radians(bearing["contact_angle_deg"]),
    )
    volume = pi / 6.0 * size**3 if bearing.get("type") == "ball" else pi / 4.0 * size**2 * 10.0  # mm³
    cage = 0.5 * 6000.0 * 2.0 * pi / 60.0 * (1.0 - size * cos(angle) / pitch)
    force = 7850e-9 * volume * cage**2 * 0.5e-3 * pitch * cos(angle)
    found = statics(case)
    unloaded = found.outer_force[found.inner_force == 0.0]
    assert unloaded.size and unloaded == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize("model", [pytest.param("fem", marks=pytest.mark.slow), "reduced", "lagrange"])
def test_radial_parts_of_all_rows_carry_load_and_weight(model):
    case = scene(ZA_2115, model, gravity_m_s2=9.81)
    found, angle = statics(case), case.perfect_bearing().contact_angle
    carried = 2.0 * np.sum(found.inner_force * -np.sin(found.roller_theta)) * cos(angle)
    assert carried == pytest.approx(13345.0 + 8.0 * 9.81, rel=1e-3)


def test_pressure_of_a_tapered_roller():
    """Curvatures 2/D and 2/D γ/(1 ∓ γ), Harris (2.28); p₀ = √(Q E* Σρ/(2π L)) × ... of Hertz's line contact."""
    bearing = Scene(bearing=ZA_2115).perfect_bearing()
    share, diameter = 8.4074 * cos(radians(15.17)) / 71.501, 8.4074e-3
    modulus = 0.5 * 210e9 / (1.0 - 0.3**2)
    for pair, of_raceway in zip(contact_pairs(bearing), (share / (1.0 - share), -share / (1.0 + share)), strict=False):
        curvature = 2.0 / diameter * (1.0 + of_raceway)
        assert pair.peak_pressure(1000.0) == pytest.approx(sqrt(1000.0 * modulus * curvature / (pi * 0.01)), rel=1e-6)


def test_two_rows_are_two_bearings():
    """Half the load each: the same forces; twice the stiffness; ratings by i^(7/9) and i."""
    sizes = {"rollers": 13, "clearance_um": 10.0}
    one, two = scene(sizes, radial_load_N=1000.0), scene(sizes | {"rows": 2}, radial_load_N=2000.0)
    np.testing.assert_allclose(statics(one).inner_force, statics(two).inner_force, rtol=1e-9)
    assert statics(two).stiffness == pytest.approx(2.0 * statics(one).stiffness, rel=1e-6)
    rows = [Dimensions.of(each.perfect_bearing()) for each in (one, two)]
    assert dynamic_capacity(rows[1]) == pytest.approx(2.0 ** (7 / 9) * dynamic_capacity(rows[0]))
    assert static_capacity(rows[1]) == pytest.approx(2.0 * static_capacity(rows[0]))
    cases = [Case(each, Options()) for each in (one, two)]
    lives = [reference_life(each.row, dynamic_capacity(each.row), each.rigid.loads) for each in cases]
    assert lives[1] == pytest.approx(2.0 ** (-8 / 9) * lives[0], rel=1e-9)


def test_ratings_of_a_contact_angle():
    """ISO 281 and ISO 76 with γ = D cos α/D_pw and (i L cos α)^(7/9); stresses and films know bodies' curvatures."""
    row = Dimensions.of(Scene(bearing=ZA_2115).perfect_bearing())
    cosine = cos(radians(15.17))
    assert row.gamma == pytest.approx(8.4074 * cosine / 71.501, rel=1e-9)
    size = (2 * 10.0 * cosine) ** (7 / 9) * 16**0.75 * 8.4074 ** (29 / 27)
    assert dynamic_capacity(row) == pytest.approx(1.1 * capacity_factor(row.gamma) * size, rel=1e-9)
    assert static_capacity(row) == pytest.approx(44 * (1 - row.gamma) * 2 * 16 * 10.0 * 8.4074 * cosine, rel=1e-9)
    found = Case(scene(ZA_2115 | {"clearance_um": 30.0}), Options())
    assert found.load == pytest.approx(13345.0) and found.clearance_parts["given"] == pytest.approx(30.0, abs=1e-5)
    carried = 2.0 * cosine * np.sum(found.rigid.of_rollers * np.cos(2.0 * pi * np.arange(16) / 16))
    assert carried == pytest.approx(13345.0, rel=1e-6)
    in_machine = np.sqrt(np.linalg.eigvalsh(found.pitch.mean) / 8.0) / (2.0 * pi)
    assert found.frequencies() == pytest.approx(in_machine, rel=1e-9)


def test_a_radial_load_makes_an_axial_force():
    """Harris, table 7.4: F_r tan α/F_a = 0.7939 of rollers whose half is loaded."""
    found = rating(scene(ZA_2115 | {"rows": 1, "clearance_um": 0.0}))
    warning = next(each for each in found.warnings if "axial force" in each)
    force = float(re.search(r"axial force of (\S+) N", warning)[1])
    assert force == pytest.approx(13345.0 * tan(radians(15.17)) / 0.7939, rel=5e-3)


def test_a_run_is_sound_and_says_what_it_is_of(tmp_path, capsys):
    text = "".join(f"{key} = {value}\n" for key, value in ZA_2115.items())
    (tmp_path / "za.toml").write_text(
        f'name = "za"\nmodel = "lagrange"\n[bearing]\n{text}[operation]\nspeed_rpm = 2000\n'
    )
    run = str(tmp_path / "za.nc")
    assert run_main([str(tmp_path / "za.toml"), "--dry-run"]) == 0
    assert "of one of 2 rows" in re.sub(r"\s+", " ", capsys.readouterr().out)
    assert run_main([str(tmp_path / "za.toml"), "--output", run, "--set", "numerics.duration_ms=1"]) == 0
    assert "of one of 2 rows" in re.sub(r"\s+", " ", capsys.readouterr().out)
    assert check_main([run, "--no-figures", "--quiet", "--output", str(tmp_path / "checked")]) == 0
    summary = json.loads((tmp_path / "checked" / "summary.json").read_text(encoding="utf-8"))
    assert (
        summary["error_y"]["rms_N"] < 1.0
        and "plane section" in (tmp_path / "checked" / "report.html").read_text().lower()
    )
    section = 2000.0 / (2.0 * cos(radians(15.17)))
    page = (tmp_path / "checked" / "report.html").read_text(encoding="utf-8")
    assert f"2000 rpm, 2000 N on the bearing ({section:.0f} N on its plane section) along −y" in page


def test_a_written_scene_is_read_back():
    whole = Scene(bearing=ZA_2115)
    again = parse_scene_text(whole.to_toml(), "again")
    assert again.perfect_bearing() == whole.perfect_bearing()
    wider = whole.varied({"bearing.clearance_um": 20.0}).perfect_bearing()
    assert 2e6 * wider.radial_clearance / wider.cosine == pytest.approx(20.0, abs=1e-5)
    assert 2e3 * wider.pitch_radius == pytest.approx(71.501, abs=1e-8)


REFUSED = {
    "thrust bearings": ({"bearing": ZA_2115 | {"contact_angle_deg": 60.0}}, "less than or equal to 45"),
    "two pitches": ({"bearing": ZA_2115 | {"inner_raceway_diameter_mm": 63.0}}, "already give the pitch"),
    "a roller's spall": ({"bearing": ZA_2115, "spall": [{"body": "roller", "roller": 1}]}, "turn faster than those"),
    "a fit": ({"bearing": ZA_2115, "support": {"kind": "bore"}}, "only for rings whose contacts are radial"),
    "springs": ({"bearing": ZA_2115, "contact": {"model": "penalty"}}, "as curved as bodies"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    tables, told = REFUSED[case]
    with pytest.raises(SceneError, match=re.escape(told)):
        Scene(operation=STILL, **tables)
