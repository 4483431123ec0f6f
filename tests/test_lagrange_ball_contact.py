"""Hertz point contact against Harris' table and constants."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from lagrange.contact.hertz import delta_star, ellipticity, raceway_curvature
from lagrange.contact.laws import ball_law, contact_laws
from lagrange.scene.scene import Scene
from tests.reference.ideal import DGBB_209, STEEL_207

# Harris, Rolling Bearing Analysis (4th ed. 2001), table 6.1: F(ρ), δ*
HARRIS = [
    (0.0, 1.0), (0.1075, 0.9974), (0.3204, 0.9761), (0.4795, 0.9429), (0.5916, 0.9077), (0.6716, 0.8733),
    (0.7332, 0.8394), (0.7948, 0.7961), (0.83495, 0.7602), (0.87366, 0.7169), (0.90999, 0.6636), (0.93657, 0.6112),
    (0.95738, 0.5551), (0.9729, 0.4960), (0.983797, 0.4352), (0.990902, 0.3745), (0.995112, 0.3176),
    (0.9973, 0.2705), (0.9981847, 0.2427), (0.9989156, 0.2106), (0.9994785, 0.17167), (0.9998527, 0.11995),
]  # fmt: skip


@pytest.mark.parametrize(("difference", "published"), HARRIS)
def test_delta_star_agrees_with_harris_table(difference, published):
    assert delta_star(difference) == pytest.approx(published, abs=3e-4)


def test_delta_star_of_arrays_falls_from_circle_to_line():
    differences = np.concatenate([[0.0, 1e-7, 0.99e-5, 1.01e-5, 1e-4], np.linspace(0.01, 0.999999, 50)])
    values = delta_star(differences)
    assert values.shape == differences.shape
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


def approach_constant(bearing, side="inner"):
    """C of equation (8), from the law's stiffness, K = (C δ*)^(-3/2) Σρ^(-1/2)."""
    curvature = raceway_curvature(bearing, side)
    return (ball_law(bearing, side).stiffness * curvature.sum**0.5) ** (-2 / 3) / delta_star(curvature.difference)


def test_printed_constants_belong_to_207_gpa():
    # equation (8): δ = 2.79e-4 δ* Q^(2/3) Σρ^(1/3), mm and N; (11): K = 2.15e5 Σρ^(-1/2) δ*^(-3/2)
    assert 1e4 * approach_constant(DGBB_209) == pytest.approx(2.79e-4, rel=1e-3)
    for side in ("inner", "outer"):
        curvature = raceway_curvature(DGBB_209, side)
        printed = 2.15e5 * (1e-3 * curvature.sum) ** -0.5 * delta_star(curvature.difference) ** -1.5
        assert 1e-3**1.5 * ball_law(DGBB_209, side).stiffness == pytest.approx(printed, rel=4e-3)


def test_curvatures_of_the_209_bearing():
    """Harris: Σρ = 0.202 and 0.138 mm⁻¹, F = 0.940 and 0.912."""
    inner, outer = raceway_curvature(DGBB_209, "inner"), raceway_curvature(DGBB_209, "outer")
    assert (1e-3 * inner.sum, 1e-3 * outer.sum) == pytest.approx((0.202, 0.138), abs=5e-4)
    assert (inner.difference, outer.difference) == pytest.approx((0.940, 0.912), abs=5e-4)


def test_stiffness_scales_with_the_contact_modulus():
    soft = replace(STEEL_207, youngs_modulus=103.5e9)
    both = replace(DGBB_209, roller=soft, inner_ring=soft)
    one = replace(DGBB_209, roller=soft)
    hard = ball_law(DGBB_209, "inner").stiffness
    assert ball_law(both, "inner").stiffness == pytest.approx(hard / 2, rel=1e-12)
    assert ball_law(one, "inner").stiffness == pytest.approx(hard / 1.5, rel=1e-12)


def test_sphere_on_sphere_is_hertz_closed_form():
    """Q = 4/3 E* sqrt(R) δ^1.5 in the limit of a raceway that is a ball: F = 0."""
    radius = DGBB_209.roller_radius
    constant = approach_constant(DGBB_209)
    stiffness = constant**-1.5 * (4.0 / radius) ** -0.5
    e_star = 0.5 * STEEL_207.plane_strain_modulus
    assert stiffness == pytest.approx(4 / 3 * e_star * (radius / 2) ** 0.5, rel=1e-12)


def test_balls_and_rollers_keep_their_own_laws():
    laws = contact_laws("hertz", DGBB_209)
    assert laws.inner.exponent == laws.outer.exponent == 1.5
    assert DGBB_209.roller_mass == pytest.approx(7850 * np.pi / 6 * 12.7e-3**3)
    with pytest.raises(ValueError, match="'harris' for balls; known: hertz"):
        contact_laws("harris", DGBB_209)
    with pytest.raises(ValueError, match="'hertz' for rollers; known: braendlein, harris"):
        contact_laws("hertz", Scene().ideal_bearing())
    with pytest.raises(ValueError, match="outer groove radius"):
        replace(DGBB_209, outer_groove_radius=6.3e-3)
