"""Densities, peaks and bands in numpy alone, against scipy.signal's."""

import numpy as np
import pytest
from scipy import signal as scipy_signal

from residual.fourier import analytic_band, density, frequencies, peaks, pieces, prominence

STEP = 1e-5


@pytest.fixture(scope="module")
def noise():
    return np.random.default_rng(7).standard_normal(4001).cumsum()


@pytest.mark.parametrize("length", [400, 401, 4001])
def test_densities_are_welchs(noise, length):
    parts = pieces(noise, length, length - length // 2)
    found = density(parts - parts.mean(axis=1, keepdims=True), STEP).mean(axis=0)
    frequency, expected = scipy_signal.welch(noise, 1.0 / STEP, "hann", length)
    np.testing.assert_allclose(frequencies(length, STEP), frequency, rtol=1e-12)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * expected.max())


def test_peaks_and_their_prominences_are_scipys(noise):
    expected, about = scipy_signal.find_peaks(noise, prominence=0.0)
    found = peaks(noise)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose([prominence(noise, i) for i in found], about["prominences"], rtol=1e-12)


def test_a_band_is_butterworths_forwards_and_backwards(noise):
    signal = np.diff(noise)
    found = analytic_band(signal, STEP, 9e3, 18e3, 4)
    sections = scipy_signal.butter(4, (9e3, 18e3), "bandpass", fs=1.0 / STEP, output="sos")
    expected = scipy_signal.hilbert(scipy_signal.sosfiltfilt(sections, signal))
    inner = slice(100, -100)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found.real[inner], expected.real[inner], atol=1e-3 * scale)
    np.testing.assert_allclose(np.abs(found)[inner], np.abs(expected)[inner], atol=2e-2 * scale)  # its ends are joined


def test_a_tone_in_a_band_keeps_its_amplitude_and_one_outside_is_gone():
    time = STEP * np.arange(6001)
    inside = analytic_band(2.0 * np.cos(2.0 * np.pi * 13e3 * time), STEP, 9e3, 18e3, 4)
    outside = analytic_band(2.0 * np.cos(2.0 * np.pi * 3e3 * time), STEP, 9e3, 18e3, 4)
    np.testing.assert_allclose(np.abs(inside)[300:-300], 2.0, rtol=1e-3)
    assert np.abs(outside)[300:-300].max() < 2e-3
