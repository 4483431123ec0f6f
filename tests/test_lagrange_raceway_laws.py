"""Laws that know the bearing, against the literature."""

from dataclasses import replace
from math import log, pi, sqrt

import numpy as np
import pytest

from lagrange.contact.laws import ROLLER_LAWS, contact_laws
from lagrange.scene.scene import Scene

PAPER = Scene().ideal_bearing()
THICK = replace(PAPER, outside_radius=0.038)  # 10 mm behind the outer raceway
LOADS = np.array([100.0, 200.0, 400.0, 628.0, 800.0, 1000.0])  # N
# µm, from the published formulas, rollers of 10 x 10 mm, raceways of 36 and 56 mm, E = 210 GPa, ν = 0.3
PUBLISHED = {
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


def test_braendlein_is_half_of_both_contacts():
    law = contact_laws("braendlein", PAPER).outer
    both = 1e-3 * (628.0 / (26200.0 * 10.0**0.92)) ** (1 / 1.08)  # N, mm
    assert law.approach(628.0) == pytest.approx(both / 2, rel=1e-12)


def test_johnson_of_two_materials_weighs_each_body():
    ceramic = replace(PAPER.roller, youngs_modulus=310e9, poisson_ratio=0.26)
    bearing = replace(PAPER, roller=ceramic)
    law = contact_laws("johnson", bearing).inner
    c1, c2 = (1 - 0.26**2) / 310e9, (1 - 0.3**2) / 210e9
    b = sqrt(4 * 628.0 * (c1 + c2) / (pi * 0.01 * (1 / 0.005 + 1 / 0.018)))
    expected = 2 * 628.0 / (pi * 0.01) * (c1 * (log(0.02 / b) - 0.5) + c2 * (log(0.072 / b) - 0.5))
    assert law.approach(628.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ROLLER_LAWS)
@pytest.mark.parametrize("side", ["inner", "outer"])
def test_methods_of_a_law_belong_together(name, side):
    law = getattr(contact_laws(name, PAPER), side)
    depth = np.geomspace(1e-12, 3e-4, 60).reshape(3, 20)  # johnson: past its range, along the tangent
    np.testing.assert_allclose(law.approach(law.force(depth)), depth, rtol=1e-12)
    step = 1e-4 * depth
    rise = (law.potential(depth + step) - law.potential(depth - step)) / (2 * step)
    np.testing.assert_allclose(rise, law.force(depth), rtol=1e-7)
    rise = (law.force(depth + step) - law.force(depth - step)) / (2 * step)
    np.testing.assert_allclose(rise, law.slope(depth), rtol=1e-4)
    gap = np.array([-1e-3, -1e-12, 0.0])
    for method in (law.force, law.slope, law.potential):
        assert np.all(method(gap) == 0.0)
    assert law.approach(0.0) == 0.0
    assert law.source and law.range


def test_johnson_is_smooth_where_its_tangent_takes_over():
    law = contact_laws("johnson", PAPER).outer
    edge = float(law.approach(law.largest_force))
    below, above = law.force(edge * (1 - 1e-9)), law.force(edge * (1 + 1e-9))
    assert above - below == pytest.approx(2e-9 * edge * law.slope(edge), rel=1e-3)
    assert law.largest_force > 1e5  # N, far above any load of this bearing


def test_tripp_is_johnson_and_unknown_names_list_the_known():
    assert contact_laws("tripp", PAPER) == contact_laws("johnson", PAPER)
    known = "braendlein, harris, houpert, iso16281, johnson, palmgren, teutsch_sauer"
    with pytest.raises(ValueError, match=f"'hooke' for rollers; known: {known}"):
        contact_laws("hooke", PAPER)
