"""Widths of records with an entry and a strike of known lag, and reasons where there is none."""

from math import pi

import numpy as np
import pytest
from scipy.signal import fftconvolve

from residual.measured.diagnosis import Geometry, diagnose
from residual.measured.signals import Signal
from residual.measured.strikes import damage_width

GEOMETRY = Geometry(elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3)
SHAFT, RATE = 20.0, 51_200.0  # Hz


def judged(name, width, seed=2):
    """The width of a record whose strikes lag 0.83 of the rolling time behind entries; 0: strikes alone."""
    rng, line = np.random.default_rng(seed), GEOMETRY.lines(SHAFT)[name]
    raceway = GEOMETRY.pitch_diameter + GEOMETRY.element_diameter * (1.0 if name == "BPFO" else -1.0)
    lag = 0.83 * width / (pi * raceway * line / GEOMETRY.elements)
    strikes = 0.01 + np.cumsum(1.0 / line * (1.0 + 0.007 * rng.standard_normal(int(0.97 * line))))  # slip
    size = np.maximum(0.1, np.cos(2.0 * pi * SHAFT * strikes)) if name == "BPFI" else np.ones(strikes.size)
    train = np.zeros(int(RATE))
    for when, share in ((strikes, 1.0), (strikes - lag, 0.7 if width else 0.0)):
        np.add.at(train, np.rint(when * RATE).astype(int), share * size)
    time = np.arange(400) / RATE
    pulse = sum(np.exp(-time * f) * np.sin(2.0 * pi * f * time) for f in (1500.0, 4000.0, 12_000.0))
    values = fftconvolve(train, pulse)[: train.size] + 0.15 * rng.standard_normal(train.size)
    signal = Signal(name="made", values=values - values.mean(), rate=RATE, unit="")
    return damage_width(signal, GEOMETRY, diagnose(signal, GEOMETRY, SHAFT))


@pytest.mark.parametrize("name", ["BPFO", "BPFI"])
def test_width_that_is_told_is_that_of_the_lag(name):
    """And from 2.6 mm on it is told."""
    widths = np.arange(1.4e-3, 3.7e-3, 0.4e-3)
    found = [judged(name, width) for width in widths]
    told = np.array([np.nan if each.value is None else each.value for each in found])
    assert np.all(np.isfinite(told[widths > 2.5e-3]))
    np.testing.assert_allclose(told[np.isfinite(told)], widths[np.isfinite(told)], rtol=0.04)
    last = found[-1]
    assert (last.low, last.high) == pytest.approx((last.value * 0.83 / 0.96, last.value * 0.83 / 0.70))
    assert all((each.value is None) == (each.reason is not None) for each in found)


@pytest.mark.parametrize("width", [0.0, 0.3e-3, 1.0e-3])
def test_narrow_damage_has_a_reason_and_no_width(width):
    found = judged("BPFO", width)
    assert (found.value, found.low, found.high) == (None, None, None)
    assert found.reason


def test_noise_has_no_width():
    values = np.random.default_rng(1).standard_normal(51_200)
    signal = Signal(name="noise", values=values, rate=RATE, unit="")
    assert damage_width(signal, GEOMETRY, diagnose(signal, GEOMETRY, SHAFT)).reason == "no ring was found damaged"
