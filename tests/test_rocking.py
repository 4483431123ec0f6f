"""Rollers that stick to both raceways: tangential springs against the exact vibration of discs between rings."""

import numpy as np
import pytest

from fem.elastic.tangential import disc_shear_compliance, ring_shear_compliance
from tests.accuracy.rocking import standing_plan, vibration
from tests.reference.bearings import STEEL
from tests.reference.rocking import disc_shear_receptance, ring_shear_receptance, sticking_modes

SLOW = 1e3  # rad/s; harmonics of some 100 kHz give way by 1e-5 more than at rest


def test_receptances_are_static_compliances_of_what_moves_slowly():
    for n in (2, 3, 8):
        static = disc_shear_compliance(np.array([n]), 0.005, STEEL)[0]
        assert disc_shear_receptance(n, 0.005, STEEL, SLOW) == pytest.approx(static, rel=1e-4)
    for radii in ((0.018, 0.0125), (0.028, 0.0325)):
        for n in (0, 1, 2, 13, 26):
            static = ring_shear_compliance(np.array([n]), *radii, STEEL)[0]
            assert ring_shear_receptance(n, *radii, STEEL, SLOW) == pytest.approx(static, rel=1e-4)


def test_a_slow_disc_moves_as_a_rigid_one():
    """Traction sin nθ: moment 2πR² of a uniform one on ½mR², force πR of one that varies once around on m."""
    mass = STEEL.density * np.pi * 0.005**2
    turning = disc_shear_receptance(0, 0.005, STEEL, SLOW) - disc_shear_compliance(np.array([0]), 0.005, STEEL)[0]
    assert turning == pytest.approx(-2.0 * np.pi * 0.005**3 / (0.5 * mass * 0.005**2 * SLOW**2), rel=1e-5)
    shifting = disc_shear_receptance(1, 0.005, STEEL, SLOW) - disc_shear_compliance(np.array([1]), 0.005, STEEL)[0]
    assert shifting == pytest.approx(-np.pi * 0.005 / (mass * SLOW**2), rel=1e-5)


@pytest.mark.parametrize(("mesh_size_mm", "limit"), [(2.0, 5e-3), pytest.param(1.0, 1.5e-3, marks=pytest.mark.slow)])
def test_rollers_that_stick_rock_and_shift_at_the_exact_frequencies(mesh_size_mm, limit):
    """Without springs they are 10 to 40 % too high, and fall with the mesh."""
    plan = standing_plan(mesh_size_mm)
    force = float(plan.start.equilibrium.inner_force.mean())
    wanted = sticking_modes(plan.model.bearing, force, 40e3, 75e3)
    assert len(wanted) == 2
    np.testing.assert_allclose(vibration(plan), wanted, rtol=limit)
