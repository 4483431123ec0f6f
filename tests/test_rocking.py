"""Rollers that stick to both raceways: tangential springs against the exact vibration of discs between rings."""

import numpy as np
import pytest

from fem.elastic.continuum import Section, shear_compliance
from tests.accuracy.rocking import standing_plan, vibration
from tests.reference.bearings import STEEL
from tests.reference.rocking import shear_receptance, sticking_modes

SLOW = 1e3  # rad/s; harmonics of some 100 kHz give way by 1e-5 more than at rest


def moved_more(section, n):
    """By a slow traction than by one at rest, and by this, m/Pa."""
    static = shear_compliance(section, np.array([n]))[0]
    return shear_receptance(section, n, SLOW) - static, static


@pytest.mark.parametrize(
    ("radii", "waves"),
    [((0.005, 0.0), (2, 3, 8)), ((0.018, 0.0125), (0, 1, 2, 13, 26)), ((0.028, 0.0325), (0, 1, 2, 13, 26))],
)
def test_receptances_are_static_compliances_of_what_moves_slowly(radii, waves):
    for n in waves:
        more, static = moved_more(Section(*radii, STEEL), n)
        assert abs(more) < 1e-4 * static


def test_a_slow_disc_moves_as_a_rigid_one():
    """Traction sin nθ: moment 2πR² of a uniform one on ½mR², force πR of one that varies once around on m."""
    disc, mass = Section(0.005, 0.0, STEEL), STEEL.density * np.pi * 0.005**2
    turning, shifting = (moved_more(disc, n)[0] for n in (0, 1))
    assert turning == pytest.approx(-2.0 * np.pi * 0.005**3 / (0.5 * mass * 0.005**2 * SLOW**2), rel=1e-5)
    assert shifting == pytest.approx(-np.pi * 0.005 / (mass * SLOW**2), rel=1e-5)


@pytest.mark.parametrize(("mesh_size_mm", "limit"), [(2.0, 5e-3), pytest.param(1.0, 1.5e-3, marks=pytest.mark.slow)])
def test_rollers_that_stick_rock_and_shift_at_the_exact_frequencies(mesh_size_mm, limit):
    """Without springs they are 10 to 40 % too high, and fall with the mesh."""
    plan = standing_plan(mesh_size_mm)
    force = float(plan.start.equilibrium.inner_force.mean())
    wanted = sticking_modes(plan.model.bearing, force, 40e3, 75e3)
    assert len(wanted) == 2
    np.testing.assert_allclose(vibration(plan), wanted, rtol=limit)
