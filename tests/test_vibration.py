"""Modes of discs and rings against exact frequencies and exact static series."""

from functools import cache

import numpy as np
import pytest

from fem.elastic.continuum import Section, plane_compliance
from fem.elastic.vibration import inertia
from lagrange import Material
from tests.reference.disc_impact import LARGEST_N, disc_modes
from tests.reference.free_vibration import disc_frequency, held_ring_frequencies, vibrations

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
RADIUS, LENGTH = 5e-3, 10e-3
DISC, INNER, OUTER = (Section(*radii, STEEL) for radii in ((RADIUS, 0.0), (18e-3, 12.5e-3), (28e-3, 32.5e-3)))
RINGS = ((INNER, 0.03), (OUTER, None))  # and the hub that moves with the held circle, kg
HIGH = 2.0 * np.pi * 500e3
SURE = 60.0 * HIGH / np.pi  # rad/s: what DEGREE resolves is far below


def test_an_ovalling_disc_has_loves_frequency():
    modes = vibrations(DISC, LENGTH, HIGH)
    root = disc_frequency(2, 2.2, 2.5, STEEL) * np.sqrt(STEEL.lame_mu / STEEL.density) / RADIUS
    assert modes.frequency[modes.order == 2][0] == pytest.approx(root, rel=1e-9)
    assert np.all(modes.carried == 0.0)


@pytest.mark.parametrize("ring", [INNER, OUTER])
@pytest.mark.parametrize("n", [2, 5])
def test_held_rings_have_all_frequencies_of_bessels_functions(ring, n):
    modes = vibrations(ring, LENGTH, HIGH)
    wanted = held_ring_frequencies(n, ring.held, ring.loaded, HIGH, STEEL)
    np.testing.assert_allclose(modes.frequency[modes.order == n], wanted, rtol=1e-9)


def test_a_ring_on_a_heavy_hub_is_a_held_ring_and_a_light_hub_takes_part():
    held, heavy, light = (vibrations(INNER, LENGTH, HIGH, hub) for hub in (None, 1e6, 0.03))
    one = [modes.frequency[modes.order == 1] for modes in (held, heavy, light)]
    np.testing.assert_allclose(one[1], one[0], rtol=1e-6)
    assert one[2][0] > 1.05 * one[0][0]  # both ends of the spring move
    assert np.all(heavy.carried**2 < 1e-5) and np.abs(light.carried[light.order == 1]).max() > 1.0


@cache
def all_modes():
    """What can be resolved of a disc and of both rings."""
    return [(body, vibrations(body, LENGTH, SURE, hub)) for body, hub in ((DISC, None), *RINGS)]


@pytest.mark.parametrize("n", [0, 1, 2, 7])
def test_modes_carry_the_exact_static_displacement_but_for_what_is_faster(n):
    line = 1.0 / (np.pi * LENGTH) * (0.5 if n == 0 else 1.0)  # pressure of a line force, over harmonic and radius
    for body, modes in all_modes():
        some = modes.order == n
        carried = np.sum(((modes.shape + modes.carried)[some] / modes.frequency[some]) ** 2)
        # a line force moves a surface by Σ 1/ω² of its modes: the rest falls as 1/highest frequency
        assert 0.94 < carried / (plane_compliance(body, np.array([n]))[0] * line / body.loaded) < 1.0


def test_the_inertia_of_a_disc_is_that_of_its_exact_modes():
    found, slowest = inertia(DISC, LENGTH)
    scale = np.sqrt(STEEL.lame_mu / STEEL.density) / RADIUS
    exact = 0.0
    for n in range(LARGEST_N + 1):
        roots, compliance = disc_modes(n, STEEL)
        exact += np.sum(compliance / (STEEL.lame_mu * LENGTH) / (roots * scale) ** 2)
    # what the reference lacks, more than 16 waves around, is as 1/16² of what it has; measured 0.5 %
    assert exact < found < 1.01 * exact
    assert slowest == pytest.approx(disc_frequency(2, 2.2, 2.5, STEEL) * scale, rel=1e-9)


@pytest.mark.parametrize(("ring", "hub"), RINGS)
def test_the_inertia_of_a_ring_is_that_of_all_its_modes(ring, hub):
    modes = vibrations(ring, LENGTH, 2.0 * np.pi * 2e6, hub)
    found, slowest = inertia(ring, LENGTH, hub)
    assert found == pytest.approx(np.sum((modes.shape / modes.frequency**2) ** 2), rel=0.02)
    assert slowest == pytest.approx(modes.frequency.min(), rel=1e-12)
