"""Line-contact laws against the literature."""

import numpy as np
import pytest

from lagrange.contact.laws import STEEL_LAWS, PowerLaw, steel_law

LOADS = [100.0, 200.0, 400.0, 628.0, 800.0, 1000.0]  # N, on a roller of 10 mm
# µm, approach of one contact, evaluated by hand from each published formula
PUBLISHED = {
    "harris": [0.393, 0.733, 1.368, 2.053, 2.552, 3.120],  # Harris, Q = 7.86e4 L^(8/9) δ^(10/9), N and mm
    "palmgren": [
        0.384,
        0.717,
        1.337,
        2.007,
        2.495,
        3.050,
    ],  # Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8, N and mm
    "iso16281": [
        0.397,
        0.741,
        1.383,
        2.075,
        2.580,
        3.154,
    ],  # ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9), half of δ
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_approach_agrees_with_the_published_formula(name):
    law = steel_law(name, 0.010)
    np.testing.assert_allclose(1e6 * law.approach(LOADS), PUBLISHED[name], atol=6e-4)


def test_formulas_with_another_length():
    # the published expressions typed in again, N and mm, L = 14 mm
    assert steel_law("harris", 0.014).force(2e-6) == pytest.approx(
        7.86e4 * 14 ** (8 / 9) * 0.002 ** (10 / 9), rel=1e-12
    )
    assert steel_law("palmgren", 0.014).approach(500.0) == pytest.approx(1e-3 * 3.84e-5 * 500**0.9 / 14**0.8, rel=1e-12)
    assert steel_law("iso16281", 0.014).force(2e-6) == pytest.approx(
        35948 * 14 ** (8 / 9) * 0.004 ** (10 / 9), rel=1e-12
    )


@pytest.mark.parametrize("name", STEEL_LAWS)
def test_approach_inverts_force(name):
    law = steel_law(name, 0.012)
    depth = np.geomspace(1e-9, 1e-4, 30)
    np.testing.assert_allclose(law.approach(law.force(depth)), depth, rtol=1e-12)


@pytest.mark.parametrize("name", STEEL_LAWS)
def test_force_is_the_derivative_of_the_potential(name):
    law = steel_law(name, 0.010)
    depth = np.geomspace(1e-8, 1e-5, 20)
    step = 1e-4 * depth
    slope = (law.potential(depth + step) - law.potential(depth - step)) / (2 * step)
    np.testing.assert_allclose(slope, law.force(depth), rtol=1e-7)


@pytest.mark.parametrize("name", STEEL_LAWS)
def test_open_contact_never_pulls(name):
    law = steel_law(name, 0.010)
    gap = np.array([-1e-3, -1e-9, 0.0])
    assert np.all(law.force(gap) == 0.0) and np.all(law.potential(gap) == 0.0)


def test_an_open_contact_has_no_stiffness_whatever_the_exponent():
    law = PowerLaw(name="soft", stiffness=2.0, exponent=0.9, source="none")
    np.testing.assert_array_equal(law.slope(np.array([-1.0, 0.0])), 0.0)
    assert law.slope(0.5) == pytest.approx(0.9 * 2.0 * 0.5**-0.1)
