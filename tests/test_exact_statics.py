"""The finite elements converge to the mesh-free yardstick."""

from fem.statics.exact_statics import exact_statics
from tests.reference.bearings import HALF_PITCH, LOAD, paper
from tests.verification.contact_statics import at_rest


def test_the_elements_converge_to_the_yardstick():
    exact = -exact_statics(paper(), LOAD, HALF_PITCH).hub[1]
    error = [abs(-at_rest(paper(), size, HALF_PITCH, LOAD).hub[1] / exact - 1.0) for size in (2e-3, 1e-3, 0.5e-3)]
    assert error[0] > error[1] > error[2]
    assert error[0] < 1.2e-3 and error[2] < 1e-4
