"""Contact laws against the literature; overlaps; a law of the scene's own in statics, runs, checks and ratings."""

import json
import re
from dataclasses import replace
from math import log, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

from fem.commands.run_fem import run_main
from fem.rating.answers import rating
from lagrange import static_equilibrium
from lagrange.contact.hertz import contact_pairs, delta_star, ellipticity, raceway_curvature
from lagrange.contact.laws import ROLLER_LAWS, PowerLaw, contact_laws, law_names, steel_law
from lagrange.equations import approaches, overlaps, touching_distances
from lagrange.scene.run import fitted_law
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from residual.cli import main as check_main
from tests.reference.kit import DGBB_209, PAPER, STEEL_207, refusal

THICK = replace(PAPER, outside_radius=0.038)  # 10 mm behind the outer raceway
LOADS = np.array([100.0, 200.0, 400.0, 628.0, 800.0, 1000.0])  # N
# µm, approach of one contact, evaluated by hand from each published formula: rollers of 10 x 10 mm, raceways of 36 and
# 56 mm, E = 210 GPa, ν = 0.3
PUBLISHED = {
    # Harris, Q = 7.86e4 L^(8/9) δ^(10/9), N and mm; Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8
    ("harris", "inner"): [0.393, 0.733, 1.368, 2.053, 2.552, 3.120],
    ("palmgren", "inner"): [0.384, 0.717, 1.337, 2.007, 2.495, 3.050],
    # ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9), half of δ
    ("iso16281", "outer"): [0.397, 0.741, 1.383, 2.075, 2.580, 3.154],
    # Johnson, Contact Mechanics 1985, 5.6; Tripp 1985
    ("johnson", "inner"): [0.387, 0.735, 1.394, 2.111, 2.635, 3.232],
    ("johnson", "outer"): [0.347, 0.656, 1.236, 1.862, 2.318, 2.836],
    # Houpert: δ_i = [Q c d_m^0.074/(0.2723 L)]^(1/1.074)
    ("houpert", "inner"): [0.378, 0.722, 1.376, 2.094, 2.624, 3.230],
    # Teutsch and Sauer 2004: δ_i = 3.17 (d_m/2)^0.08 (Q c/L)^0.92
    ("teutsch_sauer", "inner"): [0.394, 0.746, 1.412, 2.138, 2.671, 3.280],
}


@pytest.mark.parametrize(("name", "side"), PUBLISHED)
def test_approach_agrees_with_the_published_formula(name, side):
    law = getattr(contact_laws(name, THICK), side)
    np.testing.assert_allclose(1e6 * law.approach(LOADS), PUBLISHED[name, side], atol=6e-4)


def test_formulas_with_another_length():
    """The published expressions typed in again, N and mm, L = 14 mm; Brändlein's is half of both contacts."""
    forces = [steel_law(name, 0.014).force(2e-6) for name in ("harris", "iso16281")]
    expected = 7.86e4 * 14 ** (8 / 9) * 0.002 ** (10 / 9), 35948 * 14 ** (8 / 9) * 0.004 ** (10 / 9)
    assert forces == pytest.approx(expected, rel=1e-12)
    assert steel_law("palmgren", 0.014).approach(500.0) == pytest.approx(1e-3 * 3.84e-5 * 500**0.9 / 14**0.8, rel=1e-12)
    both = 1e-3 * (628.0 / (26200.0 * 14.0**0.92)) ** (1 / 1.08)
    assert steel_law("braendlein", 0.014).approach(628.0) == pytest.approx(both / 2, rel=1e-12)


def test_an_open_contact_has_no_stiffness_whatever_the_exponent():
    law = PowerLaw(name="soft", stiffness=2.0, exponent=0.9, source="none")
    np.testing.assert_array_equal(law.slope(np.array([-1.0, 0.0])), 0.0)
    assert law.slope(0.5) == pytest.approx(0.9 * 2.0 * 0.5**-0.1)


def test_johnson_of_two_materials_weighs_each_body():
    ceramic = replace(PAPER.roller, youngs_modulus=310e9, poisson_ratio=0.26)
    law = contact_laws("johnson", replace(PAPER, roller=ceramic))
    c1, c2 = (1 - 0.26**2) / 310e9, (1 - 0.3**2) / 210e9
    b = sqrt(4 * 628.0 * (c1 + c2) / (pi * 0.01 * (1 / 0.005 + 1 / 0.018)))
    expected = 2 * 628.0 / (pi * 0.01) * (c1 * (log(0.02 / b) - 0.5) + c2 * (log(0.072 / b) - 0.5))
    assert law.inner.approach(628.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ROLLER_LAWS)
@pytest.mark.parametrize("side", ["inner", "outer"])
def test_methods_of_a_law_belong_together(name, side):
    law = getattr(contact_laws(name, PAPER), side)
    depth = np.geomspace(1e-12, 3e-4, 60).reshape(3, 20)  # johnson: past its range, along the tangent
    step = 1e-4 * depth
    np.testing.assert_allclose(law.approach(law.force(depth)), depth, rtol=1e-12)
    for method, derivative, within in ((law.potential, law.force, 1e-7), (law.force, law.slope, 1e-4)):
        rise = (method(depth + step) - method(depth - step)) / (2 * step)
        np.testing.assert_allclose(rise, derivative(depth), rtol=within)
    for method in (law.force, law.slope, law.potential):
        assert np.all(method(np.array([-1e-3, -1e-12, 0.0])) == 0.0)
    assert law.approach(0.0) == 0.0 and law.source and law.range


def test_johnson_is_smooth_where_its_tangent_takes_over():
    law = contact_laws("johnson", PAPER).outer
    edge = float(law.approach(law.largest_force))
    below, above = law.force(edge * (1 - 1e-9)), law.force(edge * (1 + 1e-9))
    assert above - below == pytest.approx(2e-9 * edge * law.slope(edge), rel=1e-3)
    assert law.largest_force > 1e5  # N, far above any load of this bearing


# Hertz point contact against Harris' table and constants


# Harris, Rolling Bearing Analysis (4th ed. 2001), table 6.1: F(ρ), δ*
HARRIS = [(0.0, 1.0), (0.1075, 0.9974), (0.3204, 0.9761), (0.4795, 0.9429), (0.5916, 0.9077), (0.6716, 0.8733),
    (0.7332, 0.8394), (0.7948, 0.7961), (0.83495, 0.7602), (0.87366, 0.7169), (0.90999, 0.6636), (0.93657, 0.6112),
    (0.95738, 0.5551), (0.9729, 0.4960), (0.983797, 0.4352), (0.990902, 0.3745), (0.995112, 0.3176), (0.9973, 0.2705),
    (0.9981847, 0.2427), (0.9989156, 0.2106), (0.9994785, 0.17167), (0.9998527, 0.11995)]  # fmt: skip


def test_delta_star_agrees_with_harris_table_and_falls_from_circle_to_line():
    difference, published = np.transpose(HARRIS)
    np.testing.assert_allclose([delta_star(F) for F in difference], published, rtol=0.0, atol=3e-4)
    differences = np.concatenate([[0.0, 1e-7, 0.99e-5, 1.01e-5, 1e-4], np.linspace(0.01, 0.999999, 50)])
    values = np.array([delta_star(F) for F in differences])
    assert np.all(np.diff(values) < 1e-14) and values[0] == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("ratio", [1.05, 2.0, 8.0, 50.0])
def test_ellipticity_fulfils_hertz_conditions_by_quadrature(ratio):
    """The two curvatures of the gap are to each other as two integrals over the ellipse (Hertz 1881)."""

    # A, B ∝ ∫ ds / ((a² + s) sqrt((a² + s)(b² + s) s)), substituted s = tan²
    def curvature(own, other):
        return quad(
            lambda p: np.cos(p) ** 2 / (own**2 * np.cos(p) ** 2 + np.sin(p) ** 2) ** 1.5
            / (other**2 * np.cos(p) ** 2 + np.sin(p) ** 2) ** 0.5, 0.0, np.pi / 2, epsabs=1e-13, limit=200,
        )[0]  # fmt: skip

    along, across = curvature(ratio, 1.0), curvature(1.0, ratio)
    assert ellipticity((across - along) / (across + along)) == pytest.approx(ratio, rel=1e-8)


@pytest.mark.parametrize("difference", [-0.1, 1.0, float("nan")])
def test_impossible_curvature_difference_is_refused(difference):
    with pytest.raises(ValueError, match="curvature difference"):
        ellipticity(difference)


def stiffness(bearing, side="inner"):
    return getattr(contact_laws("hertz", bearing), side).stiffness


def approach_constant(bearing):
    """C of equation (8), from the law's stiffness, K = (C δ*)^(-3/2) Σρ^(-1/2)."""
    curvature = raceway_curvature(bearing, "inner")
    return (stiffness(bearing) * curvature.sum**0.5) ** (-2 / 3) / delta_star(curvature.difference)


def test_constants_and_curvatures_of_the_209_bearing_are_harris():
    """Σρ = 0.202 and 0.138 mm⁻¹, F = 0.940 and 0.912; the printed constants belong to 207 GPa.

    Equation (8): δ = 2.79e-4 δ* Q^(2/3) Σρ^(1/3), mm and N; (11): K = 2.15e5 Σρ^(-1/2) δ*^(-3/2).
    """
    assert 1e4 * approach_constant(DGBB_209) == pytest.approx(2.79e-4, rel=1e-3)
    for side, total, difference in (("inner", 0.202, 0.940), ("outer", 0.138, 0.912)):
        found = raceway_curvature(DGBB_209, side)
        assert (1e-3 * found.sum, found.difference) == pytest.approx((total, difference), abs=5e-4)
        printed = 2.15e5 * (1e-3 * found.sum) ** -0.5 * delta_star(found.difference) ** -1.5
        assert 1e-3**1.5 * stiffness(DGBB_209, side) == pytest.approx(printed, rel=4e-3)


def test_stiffness_scales_with_the_contact_modulus_and_is_that_of_two_spheres():
    soft = replace(STEEL_207, youngs_modulus=103.5e9)
    for bodies, times in ((("roller", "inner_ring"), 2.0), (("roller",), 1.5)):
        softer = replace(DGBB_209, **dict.fromkeys(bodies, soft))
        assert stiffness(softer) == pytest.approx(stiffness(DGBB_209) / times, rel=1e-12)
    # Q = 4/3 E* sqrt(R) δ^1.5 in the limit of a raceway that is a ball: F = 0
    radius, e_star = DGBB_209.roller_radius, 0.5 * STEEL_207.plane_strain_modulus
    sphere = approach_constant(DGBB_209) ** -1.5 * (4.0 / radius) ** -0.5
    assert sphere == pytest.approx(4 / 3 * e_star * (radius / 2) ** 0.5, rel=1e-12)


def test_balls_and_rollers_keep_their_own_laws_and_unknown_names_list_the_known():
    assert contact_laws("tripp", PAPER) == contact_laws("johnson", PAPER)
    assert [law.exponent for law in contact_laws("hertz", DGBB_209)] == [1.5, 1.5]
    assert DGBB_209.roller_mass == pytest.approx(7850 * np.pi / 6 * 12.7e-3**3)
    known = "braendlein, harris, houpert, iso16281, johnson, palmgren, teutsch_sauer"
    for name, bearing, told in (
        ("hooke", PAPER, f"'hooke' for rollers; known: {known}"),
        ("hertz", PAPER, f"'hertz' for rollers; known: {known}"),
        ("harris", DGBB_209, "'harris' for balls; known: hertz"),
        ("power", parse_scene_text('lagrange.law_table = "law.csv"', "scene").ideal_bearing(), "not at hand"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=told):
            contact_laws(name, bearing)
    with pytest.raises(ValueError, match="outer groove radius"):
        replace(DGBB_209, outer_groove_radius=6.3e-3)


# Overlap of circles in each of its forms, and Hertz's pair against Johnson's formulas


def test_overlaps_are_those_of_plain_distances_and_directions_their_derivatives():
    random, step, round_off = np.random.default_rng(3), 1e-7, 4.0 * np.finfo(float).eps
    x, y = 5e-6 * random.standard_normal((2, 200))
    rho, theta = PAPER.pitch_radius + 5e-6 * random.standard_normal((200, 1)), random.uniform(0.0, 2.0 * pi, (200, 1))
    reach, track = touching_distances(PAPER)

    def at(dx=0.0, dy=0.0):
        return overlaps(PAPER, x + dx, y + dy, rho, theta)

    roller_x, roller_y = rho * np.cos(theta), rho * np.sin(theta)
    plain = np.hypot(roller_x - x[:, None], roller_y - y[:, None])
    for found in (at(), approaches(PAPER, x, y, roller_x, roller_y)):
        np.testing.assert_allclose(found.distance, plain, rtol=1e-12)
        np.testing.assert_allclose(found.inner, reach - plain, rtol=0.0, atol=round_off * reach)
        np.testing.assert_allclose(found.outer, rho - track, rtol=0.0, atol=round_off * track)
        np.testing.assert_allclose((at(-step).inner - at(step).inner) / (2.0 * step), found.direction_x, atol=1e-8)
        away = at(0.0, -step).inner - at(0.0, step).inner
        np.testing.assert_allclose(away / (2 * step), found.direction_y, atol=1e-8)
    for touching, side in ((reach, "inner"), (track, "outer")):
        found = overlaps(PAPER, 0.0, 0.0, np.array([touching]), np.zeros(1))
        assert getattr(found, side) == pytest.approx(0.0, abs=1e-17)


@pytest.mark.parametrize(
    ("kind", "radius"), [(0, 1.0 / (1.0 / 5e-3 + 1.0 / 18e-3)), (1, 1.0 / (200.0 - 1.0 / 28e-3)), (2, 2.5e-3)]
)
def test_a_pair_has_johnsons_half_width_and_pressure(kind, radius):
    """b² = 4QR/(πE*L), p₀ = sqrt(QE*/(πRL)) (Johnson, Contact Mechanics, 1985, (4.43), (4.45))."""
    pair, force = contact_pairs(PAPER)[kind], 628.0
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    assert pair.relative_radius == pytest.approx(radius, rel=1e-14)
    assert pair.modulus == pytest.approx(modulus, rel=1e-14)
    assert pair.half_width(force) == pytest.approx(sqrt(4.0 * force * radius / (pi * modulus * 10e-3)), rel=1e-14)
    assert pair.peak_pressure(force) == pytest.approx(sqrt(force * modulus / (pi * radius * 10e-3)), rel=1e-14)
    assert pair.peak_pressure(0.0) == 0.0


# A contact law of the scene's own: given, or fitted to a table; in statics, runs, checks and ratings


EXPONENT = 10.0 / 9.0
K = 7.86e4 * 9.6 ** (8.0 / 9.0) * 1e3**EXPONENT  # N/m^n, of a roller of 9.6 mm, as Harris gives it in N and mm
SIZES = {"rollers": 14, "roller_diameter_mm": 10.0, "roller_length_mm": 9.6, "inner_raceway_diameter_mm": 54.9947,
    "clearance_um": 40.6, "bore_diameter_mm": 45.0, "outside_diameter_mm": 85.0}  # fmt: skip
OWN = {"law": "power", "contact_stiffness_N_per_m_n": [K, K], "contact_exponent": EXPONENT}
STILL = {"radial_load_N": 4450.0, "speed_rpm": 0.0, "gravity_m_s2": 0.0}
FORCES = np.array([10.0, 50.0, 200.0, 500.0, 1000.0, 2000.0, 3000.0])


def table(force=FORCES, noise=0.0, header="force [kN]; approach [um]"):
    approach = 1e6 * (force / K) ** (1.0 / EXPONENT) * (1.0 + noise * (-1.0) ** np.arange(len(force)))
    rows = [f"{1e-3 * q:.10g}; {d:.10g}" for q, d in zip(force, approach, strict=True)]
    return "\n".join(["# of a test rig", header, "0; 0", *rows])


def test_harris_209_bearing_by_its_own_law():
    """Fourteen rollers in 40.6 µm clearance: 32.11 µm, 1959 and 1382 N, 473 and 67 N/µm; Harris' integral has 1915 N.

    Source: the bearing and K of Harris, Rolling Bearing Analysis, its example of the 209 cylindrical roller bearing;
    equilibrium of discrete rollers by an independent solution.
    """
    scene = Scene(bearing=SIZES, lagrange=OWN, operation=STILL)
    bearing = scene.ideal_bearing()
    found = static_equilibrium(bearing, scene.ideal_operation(), contact_laws("power", bearing), roller_mass=0.0)
    assert -1e6 * found.y == pytest.approx(32.11, rel=1e-3)
    loads = np.sort(found.inner_force)[::-1][:5]
    np.testing.assert_allclose(loads, [1959.0, 1382.0, 1382.0, 0.0, 0.0], rtol=1e-3)
    np.testing.assert_allclose(np.diag(1e-6 * found.stiffness), [67.0, 473.0], rtol=3e-3)


def test_raceways_may_differ_and_balls_may_have_it():
    own = {"contact_stiffness_N_per_m_n": [1e10, 2e10], "contact_exponent": 1.5}
    scene = Scene(bearing={"type": "ball"}, lagrange=own)
    laws = contact_laws(scene.lagrange.law, scene.ideal_bearing())
    assert scene.lagrange.law == "power" and law_names(scene.ideal_bearing()) == ("hertz", "power")
    np.testing.assert_allclose([law.force(1e-6) for law in laws], [10.0, 20.0])
    assert laws.inner.exponent == 1.5


def test_a_table_gives_constants_and_how_near_they_are():
    exact, noisy = fitted_law(table()), fitted_law(table(noise=0.01))
    assert exact.inner_stiffness == exact.outer_stiffness == pytest.approx(K, rel=1e-7)
    assert exact.exponent == pytest.approx(EXPONENT, rel=1e-8) and exact.misfit < 1e-8
    # approaches off by 1 % to and fro are forces off by n times as much, in the mean over the line
    assert noisy.misfit == pytest.approx(0.01 * EXPONENT, rel=0.3)
    assert "from 10 to 3000 N" in noisy.range and re.search(r"1\.\d % rms, 1\.\d % at most", noisy.range)
    same = fitted_law(table(header="force_kN; approach_um"))
    assert same.inner_stiffness == exact.inner_stiffness


def test_a_run_its_check_and_its_rating_with_a_table(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "law.csv").write_text(table(), encoding="utf-8")
    keys = "".join(f"{key} = {value}\n" for key, value in SIZES.items())
    text = f'name = "209"\nmodel = "lagrange"\n[bearing]\n{keys}[lagrange]\nlaw_table = "law.csv"\n'
    (tmp_path / "209.toml").write_text(text + "[operation]\nradial_load_N = 4450\n", encoding="utf-8")
    assert run_main(["209.toml", "--dry-run", "--set", "numerics.duration_ms=0.5"]) == 0
    assert "forces differ by" in capsys.readouterr().out
    assert run_main(["209.toml", "--output", "209.nc", "--quiet", "--set", "numerics.duration_ms=0.5"]) == 0
    (tmp_path / "law.csv").unlink()  # the result file holds it
    assert check_main(["209.nc", "--law", "power", "--compare-laws", "--no-figures", "--output", "checked"]) == 0
    summary = json.loads((tmp_path / "checked" / "summary.json").read_text(encoding="utf-8"))
    assert summary["law"] == "power" and summary["error_y"]["rms_N"] < 1.0
    assert "power (in use)" in capsys.readouterr().out
    (tmp_path / "law.csv").write_text(table(), encoding="utf-8")
    rated = rating(read_scene("209.toml", ("operation.gravity_m_s2=0",))).answers
    assert "power" in rated["stiffness_contacts"].value
    lowest, _ = rated["stiffness_range_N_per_m"].value  # with a roller under the load: little of their own weight
    assert np.diag(lowest) == pytest.approx([67.0e6, 473.0e6], rel=3e-3)


REFUSED = {"which": ({"law": "power"}, None, "needs contact_stiffness_N_per_m_n = "),
    "half of it": ({"contact_stiffness_N_per_m_n": [1e9, 1e9]}, None, "give both, or neither"),
    "of one raceway": ({"contact_stiffness_N_per_m_n": [1e9], "contact_exponent": 1.1}, None, "at least 2 items"),
    "negative": ({"contact_stiffness_N_per_m_n": [1e9, -1.0], "contact_exponent": 1.1}, None, "equal to 1000"),
    "softening": ({"contact_stiffness_N_per_m_n": [1e9, 1e9], "contact_exponent": 0.9}, None, "greater than or equal"),
    "twice": ({"contact_stiffness_N_per_m_n": [1e9, 1e9], "contact_exponent": 1.1}, table(), "are fitted to it"),
    "no units": ({}, table(header="force; approach"), "column force: its unit must be one of N, mN, kN, lbf"),
    "one row": ({}, table(FORCES[:1]), "at least 3 different approaches"),
    "exchanged": ({}, table(header="approach [um]; force [kN]"), "are the columns exchanged"),
    "pulling": ({}, table().replace("0.5;", "-0.5;"), "must both be above 0")}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case, tmp_path, monkeypatch):
    keys, text, told = REFUSED[case]
    monkeypatch.chdir(tmp_path)
    overrides = [f"lagrange.{key}={json.dumps(value)}" for key, value in keys.items()]
    if text is not None:
        (tmp_path / "law.csv").write_text(text, encoding="utf-8")
        overrides += ['lagrange.law_table="law.csv"']
    assert told in refusal(overrides)
