"""Geometry (19), (26), (27) and equations (22), (23)."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from lagrange.bearing import Operation
from lagrange.contact.laws import steel_law
from lagrange.equations import approaches, contact_resultant, error_forces
from lagrange.kinematics import kinematics, roller_angles
from lagrange.scene.scene import parse_scene

SCENE = parse_scene({"operation": {"gravity_m_s2": 0.0}}, "test")
BEARING = SCENE.ideal_bearing()
OPERATION = SCENE.ideal_operation()
LAW = steel_law("harris", BEARING.roller_length)


def test_paper_bearing_turns_as_its_kinematics_say():
    found = kinematics(BEARING, 2 * np.pi * 75.0)
    lines = {"shaft": 75.0, "FTF": 29.348, "BPFO": 381.52, "BPFI": 593.48, "BSF": 164.35}
    assert found.frequencies == pytest.approx(lines, rel=1e-4)
    # Harris: cage = shaft/2 (1 − d/D), spin = shaft/2 (D/d) (1 − (d/D)²)
    assert found.frequencies["FTF"] == pytest.approx(37.5 * (1 - 10 / 46))
    assert found.frequencies["BSF"] == pytest.approx(37.5 * 4.6 * (1 - (10 / 46) ** 2))
    assert found.frequencies["BPFO"] + found.frequencies["BPFI"] == pytest.approx(13 * 75.0)


def test_rolling_without_slip_at_both_raceways():
    found = kinematics(BEARING, -300.0)
    centre = found.cage * BEARING.pitch_radius  # speed of a roller's centre, clearance 0
    r = BEARING.roller_radius
    assert centre - found.roller * r == pytest.approx(-300.0 * BEARING.inner_raceway_radius)
    assert centre + found.roller * r == pytest.approx(0.0, abs=1e-12)


def test_centrifugal_force_and_masses_of_the_paper():
    speed = kinematics(BEARING, OPERATION.speed).cage
    assert 0.006 * BEARING.pitch_radius * speed**2 == pytest.approx(4.69, abs=0.01)
    assert BEARING.roller_mass == pytest.approx(0.006, rel=0.03)
    assert BEARING.radial_clearance == pytest.approx(0.0, abs=1e-15)


def test_distance_agrees_with_equation_19_in_polar_coordinates():
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-1e-4, 1e-4, (2, 50))
    rho = rng.uniform(0.0228, 0.0232, (50, 13))
    theta = rng.uniform(-np.pi, np.pi, (50, 13))
    state = approaches(BEARING, x, y, rho * np.cos(theta), rho * np.sin(theta))
    x, y = x[:, None], y[:, None]
    chi = np.sqrt(x**2 + y**2 + rho**2 - 2 * rho * (x * np.cos(theta) + y * np.sin(theta)))
    np.testing.assert_allclose(state.distance, chi, rtol=1e-12)
    np.testing.assert_allclose(state.inner, 0.018 + 0.005 - chi, atol=1e-15)
    np.testing.assert_allclose(state.outer, rho + 0.005 - 0.028, atol=1e-15)
    np.testing.assert_allclose(state.direction_x, (x - rho * np.cos(theta)) / chi, atol=1e-12)
    np.testing.assert_allclose(state.direction_y, (y - rho * np.sin(theta)) / chi, atol=1e-12)


def test_resultant_is_minus_the_gradient_of_the_potential():
    rng = np.random.default_rng(6)
    theta = roller_angles(BEARING, 0.2)
    rho = 0.023 + 1e-6 * rng.uniform(-1, 1, 13)
    roller_x, roller_y = (rho * np.cos(theta))[None], (rho * np.sin(theta))[None]

    def energy(x, y):
        return LAW.potential(approaches(BEARING, np.array([x]), np.array([y]), roller_x, roller_y).inner).sum()

    x, y, step = 1e-6, -4e-6, 1e-10
    state = approaches(BEARING, np.array([x]), np.array([y]), roller_x, roller_y)
    force_x, force_y = contact_resultant(state, LAW.force(state.inner))
    assert -(energy(x + step, y) - energy(x - step, y)) / (2 * step) == pytest.approx(force_x[0], rel=1e-5)
    assert -(energy(x, y + step) - energy(x, y - step)) / (2 * step) == pytest.approx(force_y[0], rel=1e-5)


def static_bearing(first_angle):
    """Hub and rollers in equilibrium: rigid rings, massless rollers, by Newton; x, y, ρ."""
    theta = roller_angles(BEARING, first_angle)

    def unbalance(q):
        x, y, rho = q[:1] * 1e-6, q[1:2] * 1e-6, 0.023 + q[2:] * 1e-6
        state = approaches(BEARING, x, y, (rho * np.cos(theta))[None], (rho * np.sin(theta))[None])
        inner = LAW.force(state.inner)
        error_x, error_y = error_forces(OPERATION, 0.0, 0.0, *contact_resultant(state, inner))
        radial = state.inner - state.outer  # both contacts of a massless roller carry the same
        return np.concatenate([error_x / 1e3, error_y / 1e3, radial[0] * 1e6])

    q, _, status, message = fsolve(unbalance, np.r_[0.1, -4.0, -2.0 * np.sin(theta)], full_output=True, xtol=1e-13)
    assert status == 1, message
    x, y, rho = q[:1] * 1e-6, q[1:2] * 1e-6, 0.023 + q[2:] * 1e-6
    return x, y, (rho * np.cos(theta))[None], (rho * np.sin(theta))[None]


@pytest.mark.parametrize(
    ("first_angle", "loads"),
    [
        (-np.pi / 2, [629.7, 550.1, 550.1, 335.9, 335.9, 60.0, 60.0]),
        (-np.pi / 2 + np.pi / 13, [607.0, 607.0, 454.6, 454.6, 198.2, 198.2]),
    ],
)
def test_static_bearing_carries_the_load_without_error(first_angle, loads):
    """Rigid rings and Harris's law; the loads come from an independent solution."""
    x, y, roller_x, roller_y = static_bearing(first_angle)
    state = approaches(BEARING, x, y, roller_x, roller_y)
    force = LAW.force(state.inner)
    error_x, error_y = error_forces(OPERATION, 0.0, 0.0, *contact_resultant(state, force))
    assert abs(error_x[0]) < 1e-6 and abs(error_y[0]) < 1e-6
    np.testing.assert_allclose(np.sort(force[force > 1e-6])[::-1], loads, atol=0.15)
    angle = np.arctan2(roller_y, roller_x)
    assert np.sum(-force * np.sin(angle)) == pytest.approx(2000.0, rel=2e-3)
    if len(loads) == 7:
        assert -1e6 * y[0] == pytest.approx(4.115, abs=0.001)


def test_errors_have_the_signs_of_equations_22_and_23():
    operation = Operation(speed=0.0, radial_load=100.0, inner_mass=2.0, gravity=10.0, first_roller_angle=0.0)
    error_x, error_y = error_forces(operation, np.array([3.0]), np.array([4.0]), np.array([5.0]), np.array([7.0]))
    assert error_x[0] == 2 * 3 - 5
    assert error_y[0] == 2 * 4 + 2 * 10 - 7 + 100
    lifted = error_forces(operation, 0.0, 0.0, 0.0, np.array([120.0]))[1]  # contacts carry load and weight
    assert lifted[0] == 0.0
