"""Short-time spectra: levels, where and when a burst is found."""

import numpy as np
import pytest

from residual.spectrum import MOST_COLUMNS, short_time_spectrum

STEP, PASSING = 1e-5, 381.5  # s, Hz


def test_white_noise_has_its_density_everywhere():
    record = np.random.default_rng(1).standard_normal(20_000)
    found = short_time_spectrum(record, STEP, PASSING)
    inner = found.psd[1:-1]  # the outermost bins lack the other half of the window
    assert inner.mean() == pytest.approx(2.0 * STEP, rel=0.02)
    np.testing.assert_allclose(inner.mean(axis=1), 2.0 * STEP, rtol=0.35)


def test_a_burst_is_found_at_its_time_and_frequency_with_its_power():
    time = STEP * np.arange(6001)
    burst = np.where((time > 0.02) & (time < 0.03), 3.0 * np.sin(2 * np.pi * 9000.0 * time), 0.0)
    found = short_time_spectrum(burst, STEP, PASSING)
    resolution = found.frequency[1]
    power = found.psd.sum(axis=0) * resolution
    assert power.max() == pytest.approx(4.5, rel=0.01)
    loud = found.time[power > 2.25]
    assert (loud[0], loud[-1]) == pytest.approx((0.02, 0.03), abs=0.5 * found.length)
    assert abs(found.frequency[np.argmax(found.psd.sum(axis=1))] - 9000.0) <= resolution
    quiet = power[(found.time < 0.02 - found.length) | (found.time > 0.03 + found.length)]
    assert quiet.max() < 1e-6


def test_windows_are_half_a_passage_and_stay_within_the_record():
    found = short_time_spectrum(np.arange(6001.0), STEP, PASSING)
    assert found.length == pytest.approx(0.5 / PASSING, abs=STEP)
    assert found.time[0] >= 0.5 * found.length - STEP and found.time[-1] <= 0.06 - 0.5 * found.length + STEP
    assert found.psd.shape == (found.frequency.size, found.time.size)


def test_long_records_are_thinned_but_never_skip_samples():
    found = short_time_spectrum(np.zeros(200_000), STEP, PASSING)
    hop = found.time[1] - found.time[0]
    assert hop <= 0.5 * found.length + 1e-12
    short = short_time_spectrum(np.zeros(20_000), STEP, PASSING)
    assert short.time.size <= MOST_COLUMNS + 60


def test_a_standing_bearing_has_windows_of_the_record_and_a_short_record_none():
    assert short_time_spectrum(np.zeros(6400), STEP).length == pytest.approx(200 * STEP)
    assert short_time_spectrum(np.zeros(100), STEP, PASSING) is None
