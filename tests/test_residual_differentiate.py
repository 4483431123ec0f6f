"""Stencils: order, exactness, error floor."""

import numpy as np
import pytest

from residual.differentiate import ORDERS, derivative, floor, response, stencil

OMEGA = 2 * np.pi * 40.0


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [1, 2])
def test_stencil_is_exact_for_polynomials_up_to_its_order(order, which):
    t = np.linspace(-1.0, 1.0, 21)
    for power in range(order + which):
        exact = np.polynomial.polynomial.polyder([0] * power + [1], which)
        found = derivative(t**power, t[1] - t[0], which, order)
        inner = slice(order // 2, -(order // 2)) if power > order else slice(1, -1) if power > 4 else slice(None)
        np.testing.assert_allclose(found[inner], np.polynomial.polynomial.polyval(t, exact)[inner], atol=2e-11)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("which", [1, 2])
def test_observed_order_is_the_nominal_one(order, which):
    steps = 0.1 / np.array([40, 60, 80])
    errors = []
    for step in steps:
        t = step * np.arange(round(0.1 / step) + 1)
        exact = OMEGA * np.cos(OMEGA * t) if which == 1 else -(OMEGA**2) * np.sin(OMEGA * t)
        found = derivative(np.sin(OMEGA * t), step, which, order)
        half = order // 2
        errors.append(np.max(np.abs(found - exact)[half:-half]) / OMEGA**which)
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.25)


def test_known_weights_of_order_six():
    # Fornberg 1988, table 1
    expected = [1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90]
    np.testing.assert_allclose(stencil(6), expected, rtol=0, atol=1e-14)
    assert stencil(8).sum() == pytest.approx(0.0, abs=1e-13)


def test_stencil_is_not_the_integrators_own():
    """A leapfrog trajectory's own second difference is its acceleration exactly: no test. This differs."""
    dt, omega = 1e-3, 600.0
    x = np.empty(400)
    x[0], x[1] = 1.0, 1.0 - 0.5 * (omega * dt) ** 2
    for i in range(1, 399):
        x[i + 1] = 2 * x[i] - x[i - 1] - (omega * dt) ** 2 * x[i]
    own = np.diff(x, 2) / dt**2 + omega**2 * x[1:-1]
    ours = derivative(x, dt)[3:-3] + omega**2 * x[3:-3]
    assert np.max(np.abs(own)) < 1e-6 * omega**2
    assert np.sqrt(np.mean(ours**2)) > 1e-2 * omega**2 * np.sqrt(0.5)


def test_response_is_the_gain_on_a_sine():
    dt, frequency = 1e-5, 13.2e3
    t = dt * np.arange(500)
    record = np.sin(2 * np.pi * frequency * t)
    found = derivative(record, dt, order=6)
    exact = -((2 * np.pi * frequency) ** 2) * record[3:-3]
    # the mean taken off the record does not matter: the weights add up to zero
    np.testing.assert_allclose(found[3:-3], response(frequency, dt) * exact, atol=1e-8 * np.max(np.abs(exact)))
    assert abs(1 - response(frequency, dt)) < 6e-4


@pytest.mark.parametrize("order", [4, 6, 8])
def test_response_is_1_far_below_the_sampling_frequency(order):
    np.testing.assert_allclose(response([0.0, 1e-12, 1e-6, 1.0], 1e-5, order), 1.0, rtol=1e-12)


def test_round_off_floor_bounds_the_error_of_positions_stored_in_single_precision():
    eps, step = float(np.finfo(np.float32).eps), 1e-5
    exact = 4e-6 * np.sin(OMEGA * step * np.arange(4000))
    stored = exact.astype(np.float32).astype(float)
    noise = np.abs(derivative(stored, step) - derivative(exact, step))[1:-1]
    bound = floor(stored, step, eps=eps).round_off
    assert 0.05 * bound < noise.max() <= bound


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("tones", [(8e3,), (300.0, 13e3, 40e3)])
def test_truncation_floor_is_the_true_error(order, tones):
    step = 1e-5
    t = step * np.arange(6001)
    record, exact = np.zeros_like(t), np.zeros_like(t)
    for tone in tones:
        omega = 2 * np.pi * tone
        record += np.sin(omega * t) / omega
        exact -= omega * np.sin(omega * t)
    error = (derivative(record, step, order=order) - exact)[order:-order]
    assert floor(record, step, order).truncation == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.03)


def test_white_noise_is_magnified_as_the_weights_say():
    rng = np.random.default_rng(1)
    found = derivative(1e-9 * rng.standard_normal(20000), 1e-5)
    expected = 1e-9 * np.linalg.norm(stencil(6)) / 1e-10
    assert np.std(found) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("which", [1, 2])
def test_ends_are_good_for_slow_motion_and_not_much_noisier(which):
    step, omega = 1e-5, 2 * np.pi * 1e3
    t = step * np.arange(200)
    found = derivative(np.cos(omega * t), step, which)
    exact = -omega * np.sin(omega * t) if which == 1 else -(omega**2) * np.cos(omega * t)
    assert np.max(np.abs(found - exact)) < 3e-4 * omega**which
    impulse_gain = [np.linalg.norm([derivative(row, 1.0)[i] for row in np.eye(15)]) for i in (0, 1, 2, -1)]
    assert impulse_gain == pytest.approx([14.0, 3.6, 2.9, 14.0], rel=0.01)


def test_several_columns():
    t = np.linspace(0.0, 1.0, 50)
    found = derivative(np.stack([t**2, t**3], axis=1), t[1], order=4)
    np.testing.assert_allclose(found, np.stack([2 + 0 * t, 6 * t], axis=1), atol=1e-9)


@pytest.mark.parametrize("bad", [{"order": 5}, {"order": 2}, {"derivative": 3}])
def test_unknown_stencils_are_refused(bad):
    with pytest.raises(ValueError, match="must be"):
        derivative(np.zeros(20), 1.0, **bad)


def test_too_short_a_record_is_refused():
    with pytest.raises(ValueError, match="too few"):
        derivative(np.zeros(6), 1.0, order=6)
