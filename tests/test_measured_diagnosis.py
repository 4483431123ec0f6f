"""Verdicts on records whose truth is known; kinematics and depth against independent values."""

from collections import Counter

import numpy as np
import pytest

from residual.errors import InputError
from residual.measured.diagnosis import BODIES, Geometry, diagnose
from residual.measured.envelope import envelope_spectrum
from residual.measured.signals import Signal
from tests.reference.synthetic_record import drawn, synthetic_record

SKF_6205 = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
SHAFT = 29.95  # Hz


def record(fault, strength=1.0, seed=3, **keywords):
    return synthetic_record(np.random.default_rng(seed), SKF_6205, SHAFT, fault, strength, **keywords)


def noise(seed=1, duration=2.0, rate=25_600.0):
    return np.random.default_rng(seed).standard_normal(int(duration * rate))


def signal(values, rate=25_600.0):
    return Signal(name="made", values=values, rate=rate, unit="")


def test_lines_are_those_of_the_catalogue():
    """Multiples of the shaft's frequency that CWRU's Bearing Data Center gives for the drive end, SKF 6205."""
    lines = SKF_6205.lines(1.0)
    for name, multiple in {"BPFO": 3.5848, "BPFI": 5.4152, "2×BSF": 4.7135, "FTF": 0.39828}.items():
        assert lines[name] == pytest.approx(multiple, rel=2e-4)


def test_contact_angle_moves_lines():
    """Rexnord ZA-2115 at 2000 rpm: 236.4 Hz as the IMS data set's readers give."""
    geometry = Geometry(
        elements=16, element_diameter=8.4074e-3, pitch_diameter=71.501e-3, contact_angle=np.radians(15.17)
    )
    assert geometry.lines(2000.0 / 60.0)["BPFO"] == pytest.approx(236.4, abs=0.05)


@pytest.mark.parametrize("depth", [0.3, 0.6])
def test_depth_of_noise_is_a_quarter_of_pi_of_that_of_its_power(depth):
    """Noise whose power swells by 1 + d cos: bins that far apart correlate by d/2, their phases alone by π/4 of that.

    Source: the correlation of two complex Gaussian numbers of which only the phases are kept, π/4 ρ (1 + ρ²/8 + ...).
    """
    time = np.arange(102_400) / 25_600.0
    values = noise(duration=4.0) * np.sqrt(1.0 + depth * np.cos(2.0 * np.pi * 107.0 * time))
    spectrum = envelope_spectrum(values, 25_600.0, 1.0, 1000.0)
    assert spectrum.modulation(np.array([107.0]))[0] == pytest.approx(0.25 * np.pi * depth, abs=0.02)


def test_noise_of_few_turns_is_hardly_ever_a_line():
    """Its own comb is taken out of the spectrum that it is compared with, without making that calmer."""
    found = [diagnose(signal(noise(seed, duration=0.25)), SKF_6205, SHAFT).verdict for seed in range(30)]
    assert found.count("none") >= 26 and "trace" not in found


def test_tones_leave_no_lines():
    """Prewhitening makes loud tones of one family, as of an inverter, as faint as noise."""
    time = np.arange(51_200) / 25_600.0
    tones = sum(30.0 * np.cos(2.0 * np.pi * (4000.0 + k * 107.0) * time) for k in range(-5, 6))
    assert diagnose(signal(noise() + tones), SKF_6205, SHAFT).verdict == "none"


@pytest.mark.parametrize("fault", BODIES)
def test_fault_is_found_with_its_line(fault):
    truth = record(fault)
    found = diagnose(truth.signal, SKF_6205, SHAFT)
    assert found.verdict == BODIES[fault]
    assert found.findings[0].found == pytest.approx(truth.line, rel=3e-3)


@pytest.mark.parametrize("fault", BODIES)
def test_speed_four_percent_off_is_found(fault):
    truth = record(fault, speed_error=0.04)
    found = diagnose(truth.signal, SKF_6205, SHAFT, 0.05)
    assert found.verdict == BODIES[fault]
    assert found.shaft == pytest.approx(truth.shaft, rel=0.012)


def test_verdict_does_not_depend_on_the_unit():
    truth = record("BPFO")
    twice = diagnose(signal(1e4 * truth.signal.values), SKF_6205, SHAFT)
    once = diagnose(truth.signal, SKF_6205, SHAFT)
    assert twice.verdict == once.verdict
    assert twice.findings[0].found == once.findings[0].found


def test_faint_line_is_a_trace():
    found = diagnose(record("BPFO", 0.22).signal, SKF_6205, SHAFT)
    assert found.verdict == "trace"
    assert 0.0 < found.findings[0].depth < 0.2


def comb(frequency, seed=5):
    """Noise with strong pulses at a frequency."""
    time = np.arange(51_200) / 25_600.0
    return noise(seed) * (1.0 + 3.0 * (np.mod(time * frequency, 1.0) < 0.1))


def test_multiple_of_the_mains_is_uncertain():
    geometry = Geometry(elements=8, element_diameter=10e-3, pitch_diameter=50e-3)  # BPFO 3.2 times the shaft
    found = diagnose(signal(comb(150.0)), geometry, 150.0 / 3.2)
    assert found.verdict == "uncertain"
    assert "multiple of the mains" in found.reasons[1]


def test_multiple_of_the_shaft_is_uncertain():
    geometry = Geometry(elements=8, element_diameter=12.5e-3, pitch_diameter=50e-3)  # BPFO 3 times the shaft
    time = np.arange(51_200) / 25_600.0
    swell = 1.0 + sum(0.4 * np.cos(2.0 * np.pi * k * 31.0 * time) for k in (1, 2, 3, 6, 9))
    found = diagnose(signal(noise() * np.maximum(swell, 0.1)), geometry, 31.0)
    assert found.verdict == "uncertain"
    assert "multiple of the shaft" in found.reasons[1]


def test_bodies_whose_lines_the_speed_does_not_tell_apart_are_told():
    geometry = Geometry(elements=16, element_diameter=8.4e-3, pitch_diameter=71.5e-3)
    notes = diagnose(signal(noise()), geometry, 33.3, 0.06).notes
    assert any("BPFI and 2×BSF lie within the tolerance" in note for note in notes)


def test_sidebands_of_a_slow_cage_are_said_to_be_unresolved():
    geometry = Geometry(elements=16, element_diameter=8.4e-3, pitch_diameter=71.5e-3)
    notes = diagnose(signal(noise(duration=1.0)), geometry, 4.0).notes
    assert any("Sidebands of the cage" in note for note in notes)


@pytest.mark.parametrize(
    ("shaft", "tolerance", "words"),
    [(0.0, 0.01, "--speed 0"), (30.0, 0.5, "--speed-tolerance"), (1.0, 0.01, "passes"), (2000.0, 0.01, "sampled at")],
)
def test_unusable_speeds_are_refused(shaft, tolerance, words):
    with pytest.raises(InputError, match=words):
        diagnose(signal(noise()), SKF_6205, shaft, tolerance)


def test_confusion_matrix_of_drawn_records():
    """Bearings, speeds and faults by chance, half of them healthy: no one accused wrongly, deep faults found."""
    rng, matrix = np.random.default_rng(11), Counter()
    for k in range(24):
        truth, geometry, shaft = drawn(rng, k % 2 == 0, 0.03, duration=1.5)
        found = diagnose(truth.signal, geometry, shaft, 0.03)
        true = "healthy" if k % 2 == 0 else BODIES[truth.fault]
        deep = found.findings[0].depth >= 0.2
        matrix[true, found.verdict] += 1
        assert found.verdict in ("trace", "uncertain", "none", true)
        if true != "healthy" and deep:
            matrix["deep", found.verdict == true] += 1
    assert matrix["deep", True] >= 0.9 * (matrix["deep", True] + matrix["deep", False])
    assert matrix["deep", True] >= 8


def test_skirt_of_a_line_beyond_the_tolerance_accuses_nobody():
    """A comb just outside the range of 2×BSF, nearer than the record resolves."""
    geometry = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3)
    expected = geometry.lines(2000.0 / 60.0)["2×BSF"]
    pulses = comb(1.024 * expected)[: int(0.3 * 25_600)]
    assert diagnose(signal(pulses), geometry, 2000.0 / 60.0).verdict in ("none", "uncertain")


def test_strikes_with_sidebands_of_the_cage_alone_are_an_outer_rings():
    """A simulated run repeats nearly once a turn of the cage: most lines beside the fault's are its sidebands."""
    geometry, rng = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3), np.random.default_rng(8)
    lines = geometry.lines(45.0)
    time = np.arange(25_600) / 25_600.0
    swell = 1.0 + 0.5 * np.cos(2.0 * np.pi * lines["FTF"] * time)
    values = rng.standard_normal(time.size) * (0.2 + 3.0 * swell * (np.mod(time * lines["BPFO"], 1.0) < 0.1))
    assert diagnose(signal(values), geometry, 45.0).verdict == "outer_ring"


@pytest.mark.parametrize(("duration", "few"), [(0.25, True), (1.0, False)])
def test_few_turns_of_the_shaft_are_noted_where_nothing_stands_out(duration, few):
    found = diagnose(signal(noise(seed=2, duration=duration)), SKF_6205, SHAFT)
    assert found.verdict == "none" and any("turns of the shaft" in note for note in found.notes) == few
