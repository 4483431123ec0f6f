"""Bearings of other kinds than a full row of radial rollers on a ring.

Contact angle and rows: the section's loads, stiffness, frequencies and ratings are the bearing's, by cos α and i.
Rollers that are missing from their pockets; a solid shaft as the inner ring.
"""

import re
from math import cos, pi, radians, sqrt, tan
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from fem.commands.rate_bearing import rate_main
from fem.commands.run_fem import run_main
from fem.elastic.bodies import disc_body
from fem.elastic.continuum import Section, cross_compliance, plane_compliance, shear_compliance
from fem.interface import simulate, statics
from fem.rating.answers import Case, Options, rating
from fem.solver.simulate import make_plan
from fem.statics.exact_statics import couplings_at, crossings_at, exact_statics, neighbours_of, reduced_bearing
from fem.study.study_file import read_parameter
from lagrange import contact_laws
from lagrange.contact.hertz import contact_pairs, raceway_curvature
from lagrange.kinematics import kinematics, roller_angles
from lagrange.rating.life import Dimensions, capacity_factor, dynamic_capacity, static_capacity
from lagrange.rating.reference_life import reference_life
from lagrange.rating.sources import Unavailable
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from meshes.shapes import Disc
from residual.cli import main as check_main
from residual.measured.diagnosis import Geometry
from tests.reference.kit import read_json, sets

ZA_2115 = {  # catalogue data
    "rollers": 16, "rows": 2, "roller_diameter_mm": 8.4074, "roller_length_mm": 10.0, "pitch_diameter_mm": 71.501,
    "contact_angle_deg": 15.17, "bore_diameter_mm": 49.2125, "outside_diameter_mm": 93.0,
}  # fmt: skip
ACBB_218 = {  # Harris' angular-contact ball bearing
    "type": "ball", "rollers": 16, "roller_diameter_mm": 22.23, "pitch_diameter_mm": 125.26, "contact_angle_deg": 40.0,
    "inner_conformity": 0.5232, "outer_conformity": 0.5232, "bore_diameter_mm": 90.0, "outside_diameter_mm": 160.0,
}  # fmt: skip
STILL = {"speed_rpm": 0.0, "gravity_m_s2": 0.0}
COSINE = cos(radians(15.17))
SHARE = 8.4074 * COSINE / 71.501


def angular(bearing, model="lagrange", law=None, **operation):
    options = {} if law is None else {"lagrange": {"law": law}}
    operation = STILL | {"radial_load_N": 13345.0, "inner_ring_and_shaft_kg": 8.0} | operation
    return Scene(model=model, bearing=bearing, operation=operation, **options)


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
    bearing, shaft = Scene(bearing=ZA_2115).perfect_bearing(), 2000.0 / 60.0
    found = kinematics(bearing, 2.0 * pi * shaft).frequencies
    assert found["BPFO"] == pytest.approx(236.40, abs=0.005)
    assert found["FTF"] == pytest.approx(0.5 * shaft * (1.0 - SHARE), rel=1e-9)
    assert found["BPFI"] == pytest.approx(8.0 * shaft * (1.0 + SHARE), rel=1e-9)
    assert found["BSF"] == pytest.approx(0.5 * shaft * 71.501 / 8.4074 * (1.0 - SHARE**2), rel=1e-9)
    measured = Geometry.of(bearing).lines(shaft)  # check-vibration's
    assert {name: measured[name] for name in found} == pytest.approx(found, rel=1e-9)
    bearing, modulus = Scene(bearing=ZA_2115).perfect_bearing(), 0.5 * 210e9 / (1.0 - 0.3**2)
    for pair, of_raceway in zip(contact_pairs(bearing), (SHARE / (1.0 - SHARE), -SHARE / (1.0 + SHARE)), strict=False):
        curvature = 2.0 / 8.4074e-3 * (1.0 + of_raceway)
        assert pair.peak_pressure(1000.0) == pytest.approx(sqrt(1000.0 * modulus * curvature / (pi * 0.01)), rel=1e-6)
    whole = Scene(bearing=ZA_2115)
    assert parse_scene_text(whole.to_toml(), "again").perfect_bearing() == whole.perfect_bearing()
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
    np.testing.assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=1e-3, atol=0.5)
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
    np.testing.assert_allclose(np.sort(found.inner_force), np.sort(loads), rtol=2e-3, atol=1.0)
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


@pytest.mark.parametrize("model", [pytest.param("fem", marks=pytest.mark.slow), "reduced", "lagrange"])
def test_radial_parts_of_all_rows_carry_load_and_weight(model):
    found = statics(angular(ZA_2115, model, gravity_m_s2=9.81))
    carried = 2.0 * np.sum(found.inner_force * -np.sin(found.roller_theta)) * COSINE
    assert carried == pytest.approx(13345.0 + 8.0 * 9.81, rel=1e-3)


def test_ratings_of_a_contact_angle_and_of_two_rows():
    """Two rows: half the load each, the same forces; twice the stiffness; ratings by i^(7/9) and i.

    ISO 281 and ISO 76 with γ = D cos α/D_pw and (i L cos α)^(7/9); stresses and films know bodies' curvatures. Harris,
    table 7.4: F_r tan α/F_a = 0.7939 of rollers whose half is loaded.
    """
    sizes = {"rollers": 13, "clearance_um": 10.0}
    one, two = angular(sizes, radial_load_N=1000.0), angular(sizes | {"rows": 2}, radial_load_N=2000.0)
    np.testing.assert_allclose(statics(one).inner_force, statics(two).inner_force, rtol=1e-9)
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


# Rollers that are missing from their pockets: loads, couplings of elastic rings, kinematics, runs, ratings

HALF = "bearing.missing_rollers=[10, 11, 12, 0, 1, 2, 3]"


def lacking(missing, model="lagrange", law="harris", operation=STILL, **tables):
    bearing = {"clearance_um": 10.0, "missing_rollers": missing}
    return Scene(model=model, bearing=bearing, operation=operation, lagrange={"law": law}, **tables)


def test_loads_of_rigid_and_elastic_rings_with_rollers_missing():
    """The paper's bearing, 10 µm clearance, both contacts by ISO 16281's spring: 945.0 and 287.4 N, −12.417 µm.

    Source: an independent solution. By hand with Harris' law where the load is not over a pocket.
    """
    found = statics(lacking([0], law="iso16281"))
    loads = np.sort(found.inner_force)[::-1]
    np.testing.assert_allclose(loads[:5], [945.0, 945.0, 287.4, 287.4, 0.0], rtol=1e-3)
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
    np.testing.assert_allclose(found.hub, [across, -down(across)], rtol=1e-3, atol=2e-9)
    np.testing.assert_allclose(found.inner_force, carried(across, down(across))[0], rtol=2e-3, atol=0.2)
    whole = lacking([0, 5], "reduced")
    first, exact = Case(whole, Options()).elastic, exact_statics(whole.perfect_bearing(), 2000.0, -0.5 * pi)
    np.testing.assert_allclose(first.inner_force[0], exact.inner_force, rtol=1e-4, atol=0.02)
    np.testing.assert_allclose(first.place[0], exact.hub, rtol=1e-4, atol=1e-10)
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


@pytest.mark.parametrize("missing", [[1, 2, 3, 9], pytest.param([0, 1, 2, 3, 4, 5], marks=pytest.mark.slow)])
def test_neighbours_on_elastic_rings_are_as_far_as_their_pockets(missing):
    """Compliances between rollers, and by tractions, are the series' at the rollers' own angles."""
    bearing = lacking(missing, "reduced").perfect_bearing()
    rings = reduced_bearing(bearing, kinematics(bearing, 0.0)).rings
    found, at = neighbours_of(bearing, rings)
    angle, n = roller_angles(bearing, 0.0), bearing.n_rollers
    away = np.mod(angle[(np.arange(n) + found.distance[:, None]) % n] - angle + pi, 2.0 * pi) - pi
    met = at >= 0
    pushed, pulled = couplings_at(bearing, np.abs(away[met]))[:, 0], crossings_at(bearing, np.abs(away[met]))
    np.testing.assert_allclose(rings.along[:, at[met]], pushed, atol=1e-9 * np.abs(pushed).max())
    np.testing.assert_allclose(rings.crossed[:, at[met]], np.sign(away[met]) * pulled, atol=1e-9 * np.abs(pulled).max())
    assert np.all(np.abs(away[~met]) > np.abs(rings.distance).max() * 2.0 * pi / 13.0)


def test_a_run_numbers_its_rollers_and_is_sound(here):
    keys = ("bearing.missing_rollers=[4, 0]", "bearing.clearance_um=10", "numerics.duration_ms=1", "cage.mass_kg=0.02")
    assert run_main(["--model", "lagrange", "--output", "run.nc", "--quiet", *sets(*keys)]) == 0
    with h5py.File("run.nc") as file:
        np.testing.assert_array_equal(file["roller"], [1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12])
    assert check_main(["run.nc", "--no-figures", "--quiet", "--output", "checked"]) == 0
    summary = read_json("checked/summary.json")
    assert summary["error_y"]["rms_N"] < 0.5 and summary["loaded_rollers"]["max"] <= 5


@pytest.mark.slow
def test_models_agree_while_pockets_pass_the_load():
    """2 ms, in which an empty pocket leaves the load zone: hub and loads of both elastic models, and energy."""
    tables = {"operation": {"speed_rpm": 4500.0}, "numerics": {"duration_ms": 2.0}}
    reduced, fem = (simulate(lacking([0, 4], model, **tables)) for model in ("reduced", "fem"))
    np.testing.assert_allclose(reduced["inner_y"], fem["inner_y"], atol=0.01e-6)
    np.testing.assert_allclose(reduced["inner_force"], fem["inner_force"], atol=2.0)
    names = "energy_kinetic", "energy_elastic", "energy_contact", "work_dissipated"
    balance = sum(reduced[name] for name in names) - reduced["work_external"]
    assert np.ptp(balance) < 1e-6 * float(np.max(reduced["energy_contact"]))


@pytest.mark.parametrize(
    ("model", "more"),
    [("lagrange", ()), ("reduced", ()), ("fem", ("numerics.mesh_size_mm=2",)), ("lagrange", ("axial.slices=5",))],
)
def test_nothing_carries_the_hub_where_rollers_are_missing_over_half_a_turn(model, more, here, capsys):
    """A run that falls into it, and its rating, say so."""
    arguments = ["--model", model, "--duration", "0", "--output", "run.nc", *sets(HALF, *more)]
    assert run_main(arguments) in (1, 2)
    error = capsys.readouterr().err
    assert "nothing carries the hub" in error and "missing over 222 degrees" in error
    assert "radial_load" not in error and "law" not in error
    turned = sets("operation.first_roller_deg=180")
    assert run_main([*arguments, *turned]) == 0
    if (model, more) == ("lagrange", ()):
        falls = ["--model", "lagrange", "--duration", "30", "--output", "falls.nc", *sets(HALF), *turned]
        assert run_main(falls) == 1
        assert "nothing carries the hub" in capsys.readouterr().err
        assert rate_main([*sets(HALF), *turned, "--quiet"]) == 0
        assert "nothing carries the hub" in read_json(next(here.glob("*-rating.json")))["reasons"]["stiffness_N_per_m"]


# A solid shaft as the inner ring: a disc on which its load acts all over, under contact loads

NEEDLES = {
    "rollers": 18, "roller_diameter_mm": 3.0, "roller_length_mm": 10.0, "inner_raceway_diameter_mm": 25.0,
    "clearance_um": 20.0, "bore_diameter_mm": 0.0, "outside_diameter_mm": 37.0,
}  # fmt: skip


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
    np.testing.assert_allclose((4.0 * meshed(80.0) - meshed(40.0)) / 3.0, exact, atol=1e-3 * np.abs(exact).max())


@pytest.mark.parametrize("compliance", [plane_compliance, shear_compliance, cross_compliance])
def test_only_the_resultant_feels_a_narrow_bore(compliance):
    """From n = 2 on a bore a thousandth as wide changes nothing; n = 1 knows where the resultant goes."""
    steel, n = solid(model="lagrange").perfect_bearing().inner_ring, np.arange(1, 60)
    whole, bored = (compliance(Section(0.0125, held, steel), n) for held in (0.0, 1.25e-5))
    np.testing.assert_allclose(bored[1:], whole[1:], rtol=1e-5)
    assert abs(bored[0] / whole[0] - 1.0) > 0.1


@pytest.mark.parametrize("model", ["reduced", "lagrange", pytest.param("fem", marks=pytest.mark.slow)])
def test_models_rest_on_a_solid_shaft(model):
    """Reduced model: the exact series, meshes with a rigid core near it; rigid rings do not know the bore at all."""
    scene = solid(model=model, numerics={"mesh_size_mm": 0.5} if model == "fem" else {})
    found, exact = statics(scene), exact_statics(scene.perfect_bearing(), 2000.0, -0.5 * pi)
    if model == "reduced":
        np.testing.assert_allclose(found.inner_force, exact.inner_force, rtol=1e-4, atol=0.05)
        assert found.hub[1] == pytest.approx(exact.hub[1], rel=1e-4)
        rated = rating(scene.varied({"operation.speed_rpm": 3000.0}))
        assert rated["stiffness_N_per_m"][1, 1] > 0.0 and rated["L10r_elastic_Mrev"] > 0.0
    elif model == "fem":
        assert found.hub[1] == pytest.approx(exact.hub[1], rel=0.01)
        np.testing.assert_allclose(found.inner_force, exact.inner_force, atol=0.03 * exact.inner_force.max())
        assert any("rigid core" in warning for warning in make_plan(scene).warnings)
    else:
        bored = statics(scene.varied({"bearing.bore_diameter_mm": 10.0}))
        np.testing.assert_array_equal(found.inner_force, bored.inner_force)


LACKING = {"bearing": {"missing_rollers": [1]}}
REFUSED = {
    "thrust bearings": ({"bearing": ZA_2115 | {"contact_angle_deg": 60.0}}, "less than or equal to 45"),
    "two pitches": ({"bearing": ZA_2115 | {"inner_raceway_diameter_mm": 63.0}}, "already give the pitch"),
    "an angle's spall": ({"bearing": ZA_2115, "spall": [{"body": "roller", "roller": 1}]}, "turn faster than those"),
    "an angle's fit": ({"bearing": ZA_2115, "support": {"kind": "bore"}}, "only for rings whose contacts are radial"),
    "an angle's springs": ({"bearing": ZA_2115, "contact": {"model": "penalty"}}, "as curved as bodies"),
    "none such": ({"bearing": {"missing_rollers": [13]}}, "there is no roller 13"),
    "twice": ({"bearing": {"missing_rollers": [1, 1]}}, "a number is there twice"),
    "nearly all": ({"bearing": {"missing_rollers": list(range(11))}}, "leaves 2 rollers; at least 3"),
    "unequal": (LACKING | {"unequal_roller": [{"roller": 2}]}, "not together with bearing.missing_rollers"),
    "a spall": (LACKING | {"spall": [{"body": "roller", "roller": 2}]}, "not together with bearing.missing_rollers"),
    "a number": ({"bearing": {"missing_rollers": 3}}, "missing_rollers = 3"),
    "a shaft with fits": (
        {"bearing": NEEDLES, "model": "reduced", "fit": {"shaft_interference_um": 5.0}}, "bore_diameter_mm = 0"),
    "a shaft's springs": ({"bearing": NEEDLES, "contact": {"model": "penalty"}}, "held at its bore"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    tables, words = REFUSED[case]
    with pytest.raises(SceneError, match=re.escape(words)):
        Scene(operation=STILL | {"inner_ring_and_shaft_kg": 8.0}, **tables)
