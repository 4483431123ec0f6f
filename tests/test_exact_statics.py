"""The mesh-free yardstick, and the finite elements held against it on bearings of many shapes."""

import numpy as np
import pytest

from fem.exact_statics import exact_statics
from lagrange import Bearing
from tests.test_equilibrium import BEARINGS, BETWEEN, ON_A_ROLLER, RESOLVED, STEEL_ON_STEEL, fair_load, paper, solve

SHAPES = {
    **BEARINGS,
    "thin rings": paper(bore_radius=0.0155, outside_radius=0.0305),
    "many rollers": Bearing(
        n_rollers=31, roller_radius=0.004, roller_length=0.012, inner_raceway_radius=0.045,
        outer_raceway_radius=0.053, bore_radius=0.037, outside_radius=0.06, **STEEL_ON_STEEL,
    ),
}  # fmt: skip
every_shape = pytest.mark.parametrize("bearing", SHAPES.values(), ids=SHAPES.keys())
at_two_angles = pytest.mark.parametrize("first", [ON_A_ROLLER, ON_A_ROLLER + 0.07], ids=["on a roller", "aside"])


@pytest.mark.parametrize(("first", "microns", "loads"), RESOLVED, ids=["on a roller", "between rollers"])
def test_the_yardstick_agrees_with_resolved_finite_elements(first, microns, loads):
    """Independent statics on locally refined quadratic meshes, converged to 0.02 %."""
    found = exact_statics(paper(), 2000.0, first)
    assert -1e6 * found.hub[1] == pytest.approx(microns, rel=4e-4)
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][:7], loads, atol=0.15)


@at_two_angles
@every_shape
def test_hub_and_loads_agree_with_the_yardstick_at_1_and_2_mm(bearing, first):
    """Mesh sizes scaled with the roller: 1 mm and 2 mm on 10 mm."""
    load = fair_load(bearing)
    exact = exact_statics(bearing, load, first)
    for share, tolerance in ((0.2, 2e-3), (0.4, 7e-3)):
        found = solve(bearing, share * bearing.roller_radius, first, load)
        assert np.linalg.norm(found.hub - exact.hub) < tolerance * np.linalg.norm(exact.hub)
        assert np.abs(found.inner_force - exact.inner_force).max() < tolerance * exact.inner_force.max()


def test_the_elements_converge_to_the_yardstick():
    exact = -exact_statics(paper(), 2000.0, BETWEEN).hub[1]
    error = [abs(-solve(paper(), size, BETWEEN).hub[1] / exact - 1.0) for size in (2e-3, 1e-3, 0.5e-3)]
    assert error[0] > error[1] > error[2]
    assert error[0] < 1.2e-3 and error[2] < 1e-4
