"""Spectra: amplitude, Parseval, peaks, names, resolution."""

import numpy as np
import pytest

from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene
from residual.spectrum import find_peaks, kinematic_lines, power_spectrum
from tests.reference.synthetic_run import paper_lines

STEP = 1e-5


def tone(frequency, amplitude=1.0, duration=0.06, phase=0.3):
    t = STEP * np.arange(round(duration / STEP))
    return amplitude * np.cos(2 * np.pi * frequency * t + phase)


def test_integral_of_the_density_is_the_variance():
    """Exactly so for a record whose lines lie on bins; a density off by the usual factor 2 fails."""
    duration = 0.1
    record = 3.0 + tone(400, 5.0, duration) + tone(1230, 2.0, duration) + tone(20e3, 1.0, duration)
    spectrum = power_spectrum(record, STEP)
    assert np.sum(spectrum.psd) * spectrum.resolution == pytest.approx(np.var(record), rel=1e-9)


def test_white_noise_has_the_density_of_its_variance_over_nyquist():
    rng = np.random.default_rng(0)
    record = rng.standard_normal(2**17)
    spectrum = power_spectrum(record, STEP)
    assert np.mean(spectrum.psd[1:-1]) == pytest.approx(1.0 / (0.5 / STEP), rel=0.02)


@pytest.mark.parametrize("frequency", [381.5, 1000.0, 7321.7])
def test_tone_is_found_with_its_frequency_and_rms(frequency):
    spectrum = power_spectrum(tone(frequency, 10.0), STEP)
    peak = find_peaks(spectrum, {})[0]
    assert peak.frequency == pytest.approx(frequency, rel=1e-3)
    assert peak.rms == pytest.approx(10.0 / np.sqrt(2), rel=5e-3)


def test_band_rms_separates_two_tones():
    spectrum = power_spectrum(tone(500, 3.0) + tone(4000, 8.0), STEP)
    assert spectrum.band_rms(300, 700) == pytest.approx(3 / np.sqrt(2), rel=5e-3)
    assert spectrum.band_rms(3800, 4200) == pytest.approx(8 / np.sqrt(2), rel=5e-3)


def test_paper_bearing_lines():
    lines = paper_lines()
    expected = {"shaft": 75.0, "FTF": 29.35, "BSF": 164.35, "BPFO": 381.5, "BPFI": 593.5, "2×BPFO": 763.04}
    for name, frequency in expected.items():
        assert lines[name] == pytest.approx(frequency, abs=0.03)


@pytest.mark.parametrize(
    ("frequency", "duration", "line", "resolved"),
    [
        (381.5, 0.06, "BPFO", True),
        (593.5, 0.06, "BPFI", True),
        (763.0, 0.06, "2×BPFO", True),
        (75.0, 0.06, "shaft", True),
        (22.0, 0.06, "FTF", False),  # Δf = 16.7 Hz: 1.3 bins from zero frequency, 7 Hz from the cage
        (29.35, 0.06, "FTF", False),  # still within two bins of zero frequency
        (22.0, 1.0, None, True),  # a longer record parts it from both
        (157.0, 0.06, "2×shaft", False),  # half-way between 2×shaft and BSF
        (500.0, 0.06, None, True),
    ],
)
def test_peak_names_and_resolution(frequency, duration, line, resolved):
    rng = np.random.default_rng(4)
    record = tone(frequency, 10.0, duration)
    record += 0.01 * rng.standard_normal(record.size)
    peak = find_peaks(power_spectrum(record, STEP), paper_lines())[0]
    assert (peak.line, peak.resolved) == (line, resolved)


def test_noise_alone_shows_hardly_any_peak():
    found = 0
    for seed in range(40):
        record = np.random.default_rng(seed).standard_normal(6001)
        found += len(find_peaks(power_spectrum(record, STEP), {}))
    assert found <= 8  # one in ten spectra or so


def test_weak_tone_stands_out_of_coloured_noise():
    rng = np.random.default_rng(2)
    noise = np.cumsum(rng.standard_normal(6001)) * 0.02
    peaks = find_peaks(power_spectrum(noise + tone(5000, 0.1, 0.06001), STEP), {})
    assert any(p.frequency == pytest.approx(5000, abs=2.0) for p in peaks)


def test_silence_has_no_peaks():
    assert find_peaks(power_spectrum(np.zeros(100), STEP), paper_lines()) == []


def test_standing_bearing_has_no_lines():
    scene = Scene()
    assert kinematic_lines(kinematics(scene.ideal_bearing(), 0.0)) == {}


def test_long_record_is_averaged_and_keeps_the_rms():
    record = tone(381.5, 10.0, 4.0)
    spectrum = power_spectrum(record, STEP, slowest_line=29.35)
    assert spectrum.segments > 1
    assert spectrum.resolution == pytest.approx(29.35 / 40, rel=1e-3)
    assert find_peaks(spectrum, paper_lines())[0].rms == pytest.approx(10 / np.sqrt(2), rel=5e-3)
