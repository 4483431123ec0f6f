"""Contact angle and rows, rollers that are missing, a solid shaft as the inner ring; rings that both turn."""

import re
from dataclasses import replace
from math import cos, pi, radians, sqrt, tan
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from fem.commands.rate_bearing import rate_main
from fem.commands.run_fem import run_main
from fem.elastic.bodies import disc_body
from fem.elastic.continuum import Section, cross_compliance, plane_compliance, shear_compliance
from fem.interface import simulate, statics
from fem.rating.answers import Case, Options, rating
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from fem.statics.exact_statics import couplings_at, crossings_at, exact_statics
from fem.study.study_file import read_parameter
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.hertz import contact_pairs, raceway_curvature
from lagrange.fits import outer_growth
from lagrange.kinematics import OUTER_RING, kinematics, roller_angles, turned
from lagrange.rating.life import Dimensions, capacity_factor, dynamic_capacity, static_capacity
from lagrange.rating.reference_life import reference_life
from lagrange.rating.sources import Unavailable
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from lagrange.surface.deviation import Turns
from meshes.shapes import Disc
from residual.cli import main as check_main
from residual.evaluation import evaluate
from residual.fault_finding import find_faults
from residual.measured.diagnosis import Geometry
from residual.sources import read_result
from tests.reference.kit import PAPER, energy_left, missed, read_json, scene_with, sets

ZA_2115 = {  # catalogue data
    "rollers": 16, "rows": 2, "roller_diameter_mm": 8.4074, "roller_length_mm": 10.0, "pitch_diameter_mm": 71.501,
    "contact_angle_deg": 15.17, "bore_diameter_mm": 49.2125, "outside_diameter_mm": 93.0,
}  # fmt: skip
ACBB_218 = {  # Harris' angular-contact ball bearing
    "type": "ball", "rollers": 16, "roller_diameter_mm": 22.23, "pitch_diameter_mm": 125.26, "contact_angle_deg": 40.0,
    "inner_conformity": 0.5232, "outer_conformity": 0.5232, "bore_diameter_mm": 90.0, "outside_diameter_mm": 160.0,
}  # fmt: skip
slow = pytest.mark.slow
STILL = {"speed_rpm": 0.0, "gravity_m_s2": 0.0}
COSINE = cos(radians(15.17))
SHARE = 8.4074 * COSINE / 71.501


def angular(bearing, model="lagrange", law=None, **operation):
    operation = STILL | {"radial_load_N": 13345.0, "inner_ring_and_shaft_kg": 8.0} | operation
    return Scene(model=model, bearing=bearing, operation=operation, lagrange={} if law is None else {"law": law})


def by_hand(bearing, laws, load, clearance=0.0, rows=1):
    """Radial displacement of the inner ring, m, loads of elements, N, and stiffness, N/m, of rigid rings in 3-D.

    Source: Harris, Rolling Bearing Analysis, chapter 7: approaches (δ_r cos ψ − P_d/2) cos α, F_r = i Σ Q cos α cos ψ.
    """
    alpha, psi = bearing.contact_angle, 2.0 * pi * np.arange(bearing.n_rollers) / bearing.n_rollers

    def loads(displacement):
        approach = (displacement * np.cos(psi) - 0.5 * clearance) * cos(alpha)
        return np.array([brentq(lambda q, a=a: sum(law.approach(q) for law in laws) - a, 0.0, 1e7) if a > 0.0 else 0.0
                         for a in approach])  # fmt: skip

    def carried(displacement):
        return rows * float(np.sum(loads(displacement) * np.cos(psi))) * cos(alpha)

    found = brentq(lambda d: carried(d) - load, 1e-9, 1e-3, xtol=1e-15)
    step = 1e-4 * found
    return found, loads(found), (carried(found + step) - carried(found - step)) / (2.0 * step)


def test_catalogue_data_give_the_measured_bearing_s_lines_and_pressures():
    """Rexnord ZA-2115 at 2000 rpm: BPFO 236.40 Hz; FTF, BPFI and BSF by Harris' formulas.

    Curvatures 2/D and 2/D γ/(1 ∓ γ), Harris (2.28); p₀ = √(Q E* Σρ/(2π L)) × ... of Hertz's line contact.
    """
    whole, shaft = Scene(bearing=ZA_2115), 2000.0 / 60.0
    bearing = whole.perfect_bearing()
    found = kinematics(bearing, 2.0 * pi * shaft).frequencies
    assert found["BPFO"] == pytest.approx(236.40, abs=0.005)
    assert found["FTF"] == pytest.approx(0.5 * shaft * (1.0 - SHARE), rel=1e-9)
    assert found["BPFI"] == pytest.approx(8.0 * shaft * (1.0 + SHARE), rel=1e-9)
    assert found["BSF"] == pytest.approx(0.5 * shaft * 71.501 / 8.4074 * (1.0 - SHARE**2), rel=1e-9)
    measured = Geometry.of(bearing).lines(shaft)  # check-vibration's
    assert {name: measured[name] for name in found} == pytest.approx(found, rel=1e-9)
    modulus = 0.5 * 210e9 / (1.0 - 0.3**2)
    for pair, of_raceway in zip(contact_pairs(bearing), (SHARE / (1.0 - SHARE), -SHARE / (1.0 + SHARE)), strict=False):
        curvature = 2.0 / 8.4074e-3 * (1.0 + of_raceway)
        assert pair.peak_pressure(1000.0) == pytest.approx(sqrt(1000.0 * modulus * curvature / (pi * 0.01)), rel=1e-6)
    assert parse_scene_text(whole.to_toml(), "again").perfect_bearing() == bearing
    wider = whole.varied({"bearing.clearance_um": 20.0}).perfect_bearing()
    assert 2e6 * wider.radial_clearance / wider.cosine == pytest.approx(20.0, abs=1e-5)
    assert 2e3 * wider.pitch_radius == pytest.approx(71.501, abs=1e-8)


@pytest.mark.parametrize("clearance_um", [0.0, 40.0])
def test_tapered_rollers_by_palmgren(clearance_um):
    """Loads, displacement and stiffness in both rows; δ_r = 7.68e-5/cos α Q^0.9/L^0.8 under the load.

    Source of the formula: Palmgren, Ball and Roller Bearing Engineering; N and mm.
    """
    case = angular(ZA_2115 | {"clearance_um": clearance_um}, law="palmgren")
    section, found = case.perfect_bearing(), statics(case)
    u, loads, stiffness = by_hand(section, contact_laws("palmgren", section), 13345.0, 1e-6 * clearance_um, rows=2)
    assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=1e-3, atol=0.5)
    assert -found.hub[1] / section.cosine == pytest.approx(u, rel=1e-3)
    closed = 1e-3 * 7.68e-5 / section.cosine * loads.max() ** 0.9 / 10.0**0.8 + 0.5e-6 * clearance_um
    assert u == pytest.approx(closed, rel=1e-6)
    first = Case(case, Options()).pitch.stiffness[0]  # with a roller under the load
    assert [found.stiffness, first[1, 1]] == pytest.approx([stiffness] * 2, rel=5e-3)


def test_harris_angular_contact_ball_bearing():
    """Sums of curvatures of Harris' 218 bearing (γ = 0.1359), second hand; loads and stiffness by cos α."""
    case = angular(ACBB_218, radial_load_N=17800.0)
    bearing = case.perfect_bearing()
    inner, outer = (raceway_curvature(bearing, side) for side in ("inner", "outer"))
    assert [1e-3 * inner.sum, 1e-3 * outer.sum] == pytest.approx([0.108, 0.0832], abs=2e-4)
    share, groove = 22.23 * cos(radians(40.0)) / 125.26, 1.0 / 0.5232
    for found, term in ((inner, 2.0 * share / (1.0 - share)), (outer, -2.0 * share / (1.0 + share))):
        assert found.difference == pytest.approx((groove + term) / (4.0 - groove + term), rel=1e-9)  # Harris (2.29)
    assert bearing.roller_mass == pytest.approx(7850.0 * pi / 6.0 * 0.02223**3 * cos(radians(40.0)), rel=1e-12)
    u, loads, stiffness = by_hand(bearing, contact_laws("hertz", bearing), 17800.0)
    found = statics(case)
    assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=2e-3, atol=1.0)
    assert -found.hub[1] / bearing.cosine == pytest.approx(u, rel=2e-3)
    assert found.stiffness == pytest.approx(stiffness, rel=5e-3)
    assert loads.max() == pytest.approx(4.37 * 17800.0 / (16 * bearing.cosine), rel=0.02)  # Stribeck's, of many balls


@pytest.mark.parametrize("bearing", [ZA_2115, ACBB_218], ids=["tapered rollers", "balls"])
def test_centrifugal_forces_act_by_their_component_along_the_contacts(bearing):
    """m ω² d_m/2 cos α on elements that carry no load, ω of the cage by Harris' kinematics."""
    size, pitch, angle = (bearing[f"{key}"] for key in ("roller_diameter_mm", "pitch_diameter_mm", "contact_angle_deg"))
    volume = pi / 6.0 * size**3 if bearing.get("type") == "ball" else pi / 4.0 * size**2 * 10.0  # mm³
    cage = 0.5 * 6000.0 * 2.0 * pi / 60.0 * (1.0 - size * cos(radians(angle)) / pitch)
    force = 7850e-9 * volume * cage**2 * 0.5e-3 * pitch * cos(radians(angle))
    found = statics(angular(bearing, speed_rpm=6000.0))
    unloaded = found.outer_force[found.inner_force == 0.0]
    assert unloaded.size and unloaded == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize("model", [pytest.param("fem", marks=slow), "reduced", "lagrange"])
def test_radial_parts_of_all_rows_carry_load_and_weight(model):
    found = statics(angular(ZA_2115, model, gravity_m_s2=9.81))
    carried = 2.0 * np.sum(found.inner_force * -np.sin(found.roller_theta)) * COSINE
    assert carried == pytest.approx(13345.0 + 8.0 * 9.81, rel=1e-3)


def test_ratings_of_a_contact_angle_and_of_two_rows():
    """ISO 281 and ISO 76 with γ = D cos α/D_pw and (i L cos α)^(7/9), so that two rows of half the load each have
    i^(7/9) and i; Harris, table 7.4: F_r tan α/F_a = 0.7939 of rollers whose half is loaded."""
    sizes = {"rollers": 13, "clearance_um": 10.0}
    one, two = angular(sizes, radial_load_N=1000.0), angular(sizes | {"rows": 2}, radial_load_N=2000.0)
    assert_allclose(statics(one).inner_force, statics(two).inner_force, rtol=1e-9)
    assert statics(two).stiffness == pytest.approx(2.0 * statics(one).stiffness, rel=1e-6)
    rows = [Dimensions.of(each.perfect_bearing()) for each in (one, two)]
    assert dynamic_capacity(rows[1]) == pytest.approx(2.0 ** (7 / 9) * dynamic_capacity(rows[0]))
    assert static_capacity(rows[1]) == pytest.approx(2.0 * static_capacity(rows[0]))
    cases = [Case(each, Options()) for each in (one, two)]
    lives = [reference_life(each.row, dynamic_capacity(each.row), each.rigid.loads) for each in cases]
    assert lives[1] == pytest.approx(2.0 ** (-8 / 9) * lives[0], rel=1e-9)
    row = Dimensions.of(Scene(bearing=ZA_2115).perfect_bearing())
    assert row.gamma == pytest.approx(SHARE, rel=1e-9)
    size = (2 * 10.0 * COSINE) ** (7 / 9) * 16**0.75 * 8.4074 ** (29 / 27)
    assert dynamic_capacity(row) == pytest.approx(1.1 * capacity_factor(row.gamma) * size, rel=1e-9)
    assert static_capacity(row) == pytest.approx(44 * (1 - row.gamma) * 2 * 16 * 10.0 * 8.4074 * COSINE, rel=1e-9)
    found = Case(angular(ZA_2115 | {"clearance_um": 30.0}), Options())
    assert found.load == pytest.approx(13345.0) and found.clearance_parts["given"] == pytest.approx(30.0, abs=1e-5)
    carried = 2.0 * COSINE * np.sum(found.rigid.of_rollers * np.cos(2.0 * pi * np.arange(16) / 16))
    assert carried == pytest.approx(13345.0, rel=1e-6)
    in_machine = np.sqrt(np.linalg.eigvalsh(found.pitch.mean) / 8.0) / (2.0 * pi)
    assert found.frequencies() == pytest.approx(in_machine, rel=1e-9)
    warnings = " ".join(rating(angular(ZA_2115 | {"rows": 1, "clearance_um": 0.0})).warnings)
    force = float(re.search(r"axial force of (\S+) N", warnings)[1])
    assert force == pytest.approx(13345.0 * tan(radians(15.17)) / 0.7939, rel=5e-3)


def test_a_run_of_two_tapered_rows_is_sound_and_says_what_it_is_of(here, capsys):
    text = "".join(f"{key} = {value}\n" for key, value in ZA_2115.items())
    Path("za.toml").write_text(f'name = "za"\nmodel = "lagrange"\n[bearing]\n{text}[operation]\nspeed_rpm = 2000\n')
    for options in (["--dry-run"], ["--output", "za.nc", "--duration", "1"]):
        assert run_main(["za.toml", *options]) == 0
        assert "of one of 2 rows" in re.sub(r"\s+", " ", capsys.readouterr().out)
    assert check_main(["za.nc", "--no-figures", "--quiet", "--output", "checked"]) == 0
    assert read_json("checked/summary.json")["error_y"]["rms_N"] < 1.0
    page = Path("checked/report.html").read_text(encoding="utf-8")
    on_the_section = f"2000 rpm, 2000 N on the bearing ({1000.0 / COSINE:.0f} N on its plane section) along −y"
    assert "plane section" in page.lower() and on_the_section in page


def lacking(missing, model="lagrange", law="harris", operation=STILL, **tables):
    bearing = {"clearance_um": 10.0, "missing_rollers": missing}
    return Scene(model=model, bearing=bearing, operation=operation, lagrange={"law": law}, **tables)


def test_loads_of_rigid_and_elastic_rings_with_rollers_missing():
    """The paper's bearing, 10 µm clearance, both contacts by ISO 16281's spring: 945.0 and 287.4 N, −12.417 µm.

    Source: an independent solution. By hand with Harris' law where the load is not over a pocket.
    """
    found = statics(lacking([0], law="iso16281"))
    loads = np.sort(found.inner_force)[::-1]
    assert_allclose(loads[:5], [945.0, 945.0, 287.4, 287.4, 0.0], rtol=1e-3)
    assert 1e6 * found.hub[1] == pytest.approx(-12.417, rel=1e-3)
    assert len(loads) == 12 and np.min(np.abs(found.roller_theta + 0.5 * pi)) > 0.4
    whole = lacking([0, 2])
    bearing, found = whole.perfect_bearing(), statics(whole)
    law, psi = contact_laws("harris", bearing).inner, 2.0 * pi * np.array(bearing.pocket) / 13.0

    def carried(across, y):
        loads = law.force(0.5 * np.maximum(np.array([across, y]) @ [np.sin(psi), np.cos(psi)] - 5e-6, 0.0))
        return loads, loads @ np.sin(psi), loads @ np.cos(psi)

    def down(across):
        return brentq(lambda y: carried(across, y)[2] - 2000.0, 1e-9, 1e-3)

    across = brentq(lambda x: carried(x, down(x))[1], -2e-5, 2e-5)
    assert_allclose(found.hub, [across, -down(across)], rtol=1e-3, atol=2e-9)
    assert_allclose(found.inner_force, carried(across, down(across))[0], rtol=2e-3, atol=0.2)
    whole = lacking([0, 5], "reduced")
    first, exact = Case(whole, Options()).elastic, exact_statics(whole.perfect_bearing(), 2000.0, -0.5 * pi)
    assert_allclose(first.inner_force[0], exact.inner_force, rtol=1e-4, atol=0.02)
    assert_allclose(first.place[0], exact.hub, rtol=1e-4, atol=1e-10)
    assert first.turned[-1] > 1.9 * pi  # means are over a turn of the cage


def test_kinematics_are_those_of_the_pockets_and_a_scene_with_some_missing_may_be_varied():
    bearing, full = lacking([0, 4]).perfect_bearing(), lacking([]).perfect_bearing()
    assert bearing.full == full and bearing.n_rollers == 11 and bearing.pockets == 13
    assert kinematics(bearing, 100.0) == kinematics(full, 100.0) and Geometry.of(bearing) == Geometry.of(full)
    np.testing.assert_array_equal(roller_angles(bearing, 0.3), np.delete(roller_angles(full, 0.3), [0, 4]))
    assert parse_scene_text(lacking([4, 0]).to_toml(), "again").perfect_bearing() == bearing
    assert lacking([]).varied({"bearing.missing_rollers.0": 3}).bearing.missing_rollers == [3]
    assert lacking([1]).varied({"bearing.missing_rollers": [2, 5]}).perfect_bearing().missing == (2, 5)
    assert read_scene(None, ("bearing.missing_rollers=[7]",)).bearing.present == 12
    assert read_parameter("bearing.missing_rollers.0", [0, 1, 2]).axis("grid") == (0, 1, 2)
    with pytest.raises(Unavailable, match="rollers of this one are missing"):
        Dimensions.of(lacking([3]).perfect_bearing())


def test_a_run_numbers_its_rollers_and_is_sound(here):
    keys = ("bearing.missing_rollers=[4, 0]", "bearing.clearance_um=10", "numerics.duration_ms=1", "cage.mass_kg=0.02")
    assert run_main(["--model", "lagrange", "--output", "run.nc", "--quiet", *sets(*keys)]) == 0
    with h5py.File("run.nc") as file:
        np.testing.assert_array_equal(file["roller"], [1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12])
    assert check_main(["run.nc", "--no-figures", "--quiet", "--output", "checked"]) == 0
    summary = read_json("checked/summary.json")
    assert summary["error_y"]["rms_N"] < 0.5 and summary["loaded_rollers"]["max"] <= 5


@slow
def test_models_agree_while_pockets_pass_the_load():
    tables = {"operation": {"speed_rpm": 4500.0}, "numerics": {"duration_ms": 2.0}}
    reduced, fem = (simulate(lacking([0, 4], model, **tables)) for model in ("reduced", "fem"))
    assert_allclose(reduced["inner_y"], fem["inner_y"], atol=0.01e-6)
    assert_allclose(reduced["inner_force"], fem["inner_force"], atol=2.0)
    assert np.ptp(energy_left(reduced.energies)) < 1e-6 * float(np.max(reduced["energy_contact"]))


@pytest.mark.parametrize(("model", "more"), [
    ("lagrange", ()), ("reduced", ()), ("fem", ("numerics.mesh_size_mm=2",)), ("lagrange", ("axial.slices=5",)),
], ids=["lagrange", "reduced", "fem", "slices"])  # fmt: skip
def test_nothing_carries_the_hub_where_rollers_are_missing_over_half_a_turn(model, more, here, capsys):
    half = sets("bearing.missing_rollers=[10, 11, 12, 0, 1, 2, 3]")
    arguments = ["--model", model, "--duration", "0", "--output", "run.nc", *half, *sets(*more)]
    assert run_main(arguments) in (1, 2)
    error = capsys.readouterr().err
    assert "nothing carries the hub" in error and "missing over 222 degrees" in error
    assert "radial_load" not in error and "law" not in error
    turned = sets("operation.first_roller_deg=180")
    assert run_main([*arguments, *turned]) == 0
    if (model, more) == ("lagrange", ()):
        falls = ["--model", "lagrange", "--duration", "30", "--output", "falls.nc", *half, *turned]
        assert run_main(falls) == 1
        assert "nothing carries the hub" in capsys.readouterr().err
        assert rate_main([*half, *turned, "--quiet"]) == 0
        assert "nothing carries the hub" in read_json(next(here.glob("*-rating.json")))["reasons"]["stiffness_N_per_m"]


NEEDLES = {"rollers": 18, "roller_diameter_mm": 3.0, "roller_length_mm": 10.0, "inner_raceway_diameter_mm": 25.0,
           "clearance_um": 20.0, "bore_diameter_mm": 0.0, "outside_diameter_mm": 37.0}  # fmt: skip


def solid(**tables):
    return Scene(bearing=NEEDLES, operation=STILL | {"radial_load_N": 2000.0}, **tables)


def test_contacts_on_a_shaft_are_those_of_a_meshed_disc():
    """Displacements by loads and tractions elsewhere on it, of second order in two meshes: 0.1 % of the largest."""
    bearing, sixths = solid(model="lagrange").perfect_bearing(), np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0])  # of 60°

    def meshed(layers):
        """Displacement into the shaft, less its mean motion, by a load and a traction at angle 0, (2, n_angles)."""
        shape = Disc(radius=bearing.inner_raceway_radius, layers=layers)
        disc = disc_body(shape, bearing.inner_ring, bearing.roller_length)
        surface = np.arange(disc.first_surface_node, disc.n_nodes)
        outward = disc.points[surface] / bearing.inner_raceway_radius
        force = np.zeros((disc.n_nodes, 2, 2))
        force[surface[0], :, 0], force[surface[0], :, 1] = -outward[0], (-outward[0, 1], outward[0, 0])
        moved = disc.relaxed(force.reshape(-1, 2)).reshape(-1, 2, 2)[surface]
        return -np.einsum("nc,ncf->fn", outward, moved)[:, np.round(layers * sixths).astype(int)]

    angle = pi / 3.0 * sixths
    exact = np.array([couplings_at(bearing, angle)[0, 0], crossings_at(bearing, angle)[0]])
    assert_allclose((4.0 * meshed(80.0) - meshed(40.0)) / 3.0, exact, atol=1e-3 * np.abs(exact).max())


@pytest.mark.parametrize("compliance", [plane_compliance, shear_compliance, cross_compliance])
def test_only_the_resultant_feels_a_narrow_bore(compliance):
    """From n = 2 on a bore a thousandth as wide changes nothing; n = 1 knows where the resultant goes."""
    steel, n = solid(model="lagrange").perfect_bearing().inner_ring, np.arange(1, 60)
    whole, bored = (compliance(Section(0.0125, held, steel), n) for held in (0.0, 1.25e-5))
    assert_allclose(bored[1:], whole[1:], rtol=1e-5)
    assert abs(bored[0] / whole[0] - 1.0) > 0.1


@pytest.mark.parametrize("model", ["reduced", "lagrange", pytest.param("fem", marks=slow)])
def test_models_rest_on_a_solid_shaft(model):
    scene = solid(model=model, numerics={"mesh_size_mm": 0.5} if model == "fem" else {})
    found, exact = statics(scene), exact_statics(scene.perfect_bearing(), 2000.0, -0.5 * pi)
    if model == "reduced":
        assert_allclose(found.inner_force, exact.inner_force, rtol=1e-4, atol=0.05)
        assert found.hub[1] == pytest.approx(exact.hub[1], rel=1e-4)
        rated = rating(scene.varied({"operation.speed_rpm": 3000.0}))
        assert rated["stiffness_N_per_m"][1, 1] > 0.0 and rated["L10r_elastic_Mrev"] > 0.0
    elif model == "fem":
        assert found.hub[1] == pytest.approx(exact.hub[1], rel=0.01)
        assert_allclose(found.inner_force, exact.inner_force, atol=0.03 * exact.inner_force.max())
        assert any("rigid core" in warning for warning in make_plan(scene).warnings)
    else:
        bored = statics(scene.varied({"bearing.bore_diameter_mm": 10.0}))
        np.testing.assert_array_equal(found.inner_force, bored.inner_force)


SPALL = {"width_mm": 1.0, "depth_um": 20.0}


def turning(inner, outer, load=0.0, rotating=None, model="lagrange", friction=0.1, **tables):
    """A weightless scene, speeds in rpm; `rotating` : N, a load that turns with the outer ring."""
    operation = {"speed_rpm": inner, "outer_ring_speed_rpm": outer, "radial_load_N": load, "gravity_m_s2": 0.0}
    if rotating is not None:
        operation |= {"rotating_load_N": rotating, "rotating_load_with": "outer_ring"}
    numerics = {"duration_ms": 1.0, "mesh_size_mm": 2.0, "output_interval_us": 20.0}
    friction = {"friction_coefficient": 0.0 if model == "lagrange" else friction}
    return Scene(model=model, operation=operation, numerics=numerics, contact=friction, **tables)


@pytest.mark.parametrize(("inner", "outer"), [(1000.0, 0.0), (0.0, 600.0), (3000.0, -2000.0), (900.0, 900.0)])
def test_lines_of_two_rings_are_harris_ones(inner, outer):
    bearing = replace(PAPER, outer_raceway_radius=28e-3)  # no clearance
    share, half = bearing.roller_radius / bearing.pitch_radius, 0.5 * bearing.n_rollers
    ni, no = inner / 60.0, outer / 60.0
    found = kinematics(bearing, inner * RPM, outer * RPM).frequencies
    lines = Geometry.of(bearing, (inner, outer)).lines((abs(inner) or abs(outer)) / 60.0)
    apart = half * abs(ni - no)
    wanted = {"FTF": abs(0.5 * (ni * (1.0 - share) + no * (1.0 + share))), "BPFO": apart * (1.0 - share),
              "BPFI": apart * (1.0 + share), "BSF": 0.5 * abs(ni - no) * (1.0 - share**2) / share}  # fmt: skip
    for name, value in wanted.items():
        assert (found[name], lines[name]) == pytest.approx((value, value), rel=1e-9, abs=1e-9), name
    assert found.get(OUTER_RING, 0.0) == pytest.approx(abs(no))
    rolling = kinematics(bearing, 314.0, -120.0)  # surfaces roll without slip on both raceways
    centre, around = rolling.cage * bearing.pitch_radius, rolling.roller * bearing.roller_radius
    assert centre - around == pytest.approx(314.0 * bearing.inner_raceway_radius, rel=1e-12)
    assert centre + around == pytest.approx(-120.0 * bearing.outer_raceway_radius, rel=1e-12)


def test_the_outer_ring_turns_by_the_integral_of_its_table_and_a_load_with_either_ring(tmp_path):
    (tmp_path / "ring.csv").write_text("time_ms,speed_rpm\n0,600\n4,1200\n", encoding="utf-8")
    text = '[operation]\nouter_ring_speed_table = "ring.csv"\nouter_ring_speed_table_shape = "linear"\nspeed_rpm = 0\n'
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    scene = read_scene(tmp_path / "scene.toml", ("numerics.duration_ms=4",))
    operation = scene.ideal_operation()
    assert scene.operation.outer_ring_speed_rpm == 600.0
    assert operation.ring_speeds == pytest.approx((0.0, 600.0 * RPM))
    assert turned(scene.ideal_bearing(), operation, 4e-3).outer_ring == pytest.approx(900.0 * RPM * 4e-3, rel=1e-12)
    assert operation.fastest == pytest.approx(1200.0 * RPM)
    assert operation.at(2e-3).outer_speed == pytest.approx(900.0 * RPM)
    with_outer = turning(1000.0, -500.0, 0.0, 100.0)
    quarter = 0.25 * 60.0 / 500.0  # s, of a turn clockwise, from −y to −x
    assert with_outer.ideal_operation().history.force(quarter) == pytest.approx((-100.0, 0.0), abs=1e-9)
    with_inner = with_outer.varied({"operation.rotating_load_with": "inner_ring"}).ideal_operation()
    assert with_inner.history.force(0.5 * quarter) == pytest.approx((100.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("model", ["lagrange", "reduced"])
def test_a_load_that_turns_with_a_ring_that_stands_stands(tmp_path, model):
    """600 N at 90° from the load's direction push the hub to +x throughout, beside a table of loads too."""
    turns = "operation.rotating_load_N=600", "operation.rotating_load_deg=90", "operation.rotating_load_with=outer_ring"
    aside, down = (f"time_ms,x_N,y_N\n0,{side},-2000\n2,{side},-2000\n" for side in (600, 0))
    found = []
    for load, loads in (((), aside), (turns, None), (turns, down)):
        result = simulate(scene_with(tmp_path, f"model={model}", "numerics.duration_ms=2", *load, loads=loads))
        found.append((result["inner_x"], result["inner_y"]))
    assert found[0][0].min() > 1e-6
    assert_allclose(found[1:], np.array(2 * [found[0]]), rtol=0, atol=1e-12)


def test_a_spall_turns_with_the_outer_ring():
    scene = turning(0.0, 600.0, 2000.0, spall=[SPALL | {"body": "outer_ring", "angle_deg": -30.0}])
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    time = np.radians(30.0) / (600.0 * RPM)  # when it lies under the load, and roller 0 with it
    angles = -0.5 * np.pi + 2.0 * np.pi * np.arange(bearing.n_rollers) / bearing.n_rollers
    there = {"angles": angles, "turns": Turns.rolling(bearing, operation, time)}
    met, sound = (static_equilibrium(each, operation.at(time), contact_laws("harris", bearing), **there).outer_force[0]
                  for each in (bearing, replace(bearing, faults=())))  # fmt: skip
    assert met < 0.9 * sound


def test_a_raceway_held_around_its_outside_grows_as_elasticity_says():
    """By the equation of a spinning ring, integrated as a boundary value problem."""
    steel, speed = PAPER.outer_ring, 3000.0
    stiff, lame = steel.lame_lambda + 2.0 * steel.lame_mu, steel.lame_lambda

    def rates(r, state):
        return np.array([state[1], state[0] / r**2 - state[1] / r - steel.density * speed**2 * (r + state[0]) / stiff])

    def ends(inside, outside):
        return np.array([stiff * inside[1] + lame * inside[0] / PAPER.outer_raceway_radius, outside[0]])

    places = np.linspace(PAPER.outer_raceway_radius, PAPER.outside_radius, 50)
    found = solve_bvp(rates, ends, places, np.zeros((2, places.size)), tol=1e-9)
    assert outer_growth(PAPER, kinematics(PAPER, 0.0, speed)) == pytest.approx(float(found.sol(places[0])[0]), rel=1e-4)


@slow
@pytest.mark.parametrize(("model", "body"), [("lagrange", "outer_ring"), ("lagrange", "inner_ring"), ("reduced", None),
                                             ("fem", None)])  # fmt: skip
def test_runs_are_those_seen_from_the_other_ring(model, body):
    """But for centrifugal forces, 2e-8 of the load at 6 rpm."""
    scene = {"model": model} | ({} if body is None else {"spall": [SPALL | {"body": body, "angle_deg": 0.3}]})
    # a load of next to nothing, so that all of them take steps of histories
    seen = simulate(turning(12.0, 0.0, 2000.0, **scene).varied({"operation.rotating_load_N": 1e-9}))
    for inner, outer in ((0.0, -12.0), (6.0, -6.0)):
        found = simulate(turning(inner, outer, 0.0, 2000.0, **scene))
        for name in ("inner_force", "outer_force"):
            assert np.abs(found[name] - seen[name]).max() < 1e-6 * seen["inner_force"].max()


@slow
@pytest.mark.parametrize("model", ["lagrange", "reduced", "fem"])
def test_energy_balances_while_rings_turn_against_each_other(model):
    spall = [SPALL | {"body": "outer_ring", "angle_deg": -1.0}]
    scene = turning(3000.0, -2000.0, 2000.0, model=model, spall=spall)
    found = simulate(scene.varied({"damping.contact_time_us": 1.0})).values
    assert np.ptp(found["work_external"]) > 1e-6  # J
    assert missed(found) < 1e-4


@slow
@pytest.mark.parametrize(("model", "error"), [("lagrange", 2e-4), ("reduced", 1e-3), ("fem", 1e-6)])
def test_in_a_bearing_that_turns_as_a_whole_rollers_are_pressed_outwards_alone(model, error):
    """Reduced model: its start is 8e-4 off, as with the inner ring alone; rigid bodies' statics are exact."""
    scene = turning(6000.0, 6000.0, model=model, friction=0.0)
    pull, found = scene.ideal_bearing().roller_mass * scene.ideal_operation().speed ** 2, simulate(scene).values
    assert_allclose(found["outer_force"], pull * found["roller_rho"], rtol=error)
    assert not found["inner_force"].any()
    if model == "lagrange":
        assert_allclose((still := statics(scene)).outer_force, pull * still.roller_rho, rtol=1e-9)


@slow
def test_a_planet_wheels_spall_is_found_and_its_line_modulated_by_the_rings_turning(tmp_path):
    spall = [SPALL | {"body": "outer_ring", "angle_deg": 40.0, "depth_um": 50.0}]
    with_clearance = {"bearing": {"designation": "NU206"}}  # without, the unloaded side rattles as hard
    scene = turning(0.0, 600.0, 2000.0, spall=spall, damping={"contact_time_us": 1.0}, **with_clearance)
    path, longer = tmp_path / "planet.nc", {"numerics.duration_ms": 300.0, "numerics.output_interval_us": 20.0}
    assert run_scene(scene.varied(longer), path, RunOptions(quiet=True)).code == 0
    record = read_result(path)
    (spall,) = find_faults(record).found
    assert spall.place.body == "outer_ring" and spall.width == pytest.approx(1e-3, rel=0.1)
    assert (np.degrees(spall.angle) + 90.0) % 360.0 == pytest.approx(40.0, abs=1.0)
    lines = {line.name: line.amplitude for line in evaluate(record, "harris").y.vibration.lines}
    for side in ("BPFO−outer ring", "BPFO+outer ring"):
        assert 0.3 * lines["BPFO"] < lines[side] < 1.2 * lines["BPFO"]
