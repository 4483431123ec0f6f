"""Overlap of circles in each of its forms, and Hertz's pair against Johnson's formulas."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from lagrange.contact.hertz import contact_pairs
from lagrange.equations import overlaps, polar_overlaps, touching_distances
from lagrange.scene.scene import Scene

PAPER = Scene().ideal_bearing()


def positions():
    """Hub and rollers off their places by micrometres, (200,), m and rad."""
    random = np.random.default_rng(3)
    x, y = 5e-6 * random.standard_normal((2, 200))
    return x, y, PAPER.pitch_radius + 5e-6 * random.standard_normal(200), random.uniform(0.0, 2.0 * pi, 200)


def test_all_forms_agree_to_round_off():
    x, y, rho, theta = positions()
    cos, sin = np.cos(theta), np.sin(theta)
    plain = overlaps(PAPER, x, y, rho * cos, rho * sin, rho)
    polar = polar_overlaps(PAPER, rho, x * cos + y * sin, y * cos - x * sin)
    reach, track = touching_distances(PAPER)
    for inner, outer in ((polar.inner, polar.outer), (reach - plain.distance, rho - track)):
        np.testing.assert_allclose(inner, plain.inner, rtol=0.0, atol=4.0 * np.finfo(float).eps * reach)
        np.testing.assert_allclose(outer, plain.outer, rtol=0.0, atol=4.0 * np.finfo(float).eps * track)
    np.testing.assert_allclose(-(plain.direction_x * cos + plain.direction_y * sin), polar.radial, atol=1e-12)
    np.testing.assert_allclose(plain.direction_x * sin - plain.direction_y * cos, polar.tangential, atol=1e-12)


def test_directions_are_the_derivatives_of_the_inner_overlap():
    x, y, rho, theta = positions()
    step = 1e-7

    def inner(dx, dy):
        return overlaps(PAPER, x + dx, y + dy, rho * np.cos(theta), rho * np.sin(theta), rho).inner

    found = overlaps(PAPER, x, y, rho * np.cos(theta), rho * np.sin(theta), rho)
    np.testing.assert_allclose((inner(-step, 0.0) - inner(step, 0.0)) / (2.0 * step), found.direction_x, atol=1e-8)
    np.testing.assert_allclose((inner(0.0, -step) - inner(0.0, step)) / (2.0 * step), found.direction_y, atol=1e-8)


def test_a_roller_that_touches_has_no_overlap():
    reach, track = touching_distances(PAPER)
    assert polar_overlaps(PAPER, reach, 0.0, 0.0).inner == pytest.approx(0.0, abs=1e-17)
    assert polar_overlaps(PAPER, track, 0.0, 0.0).outer == pytest.approx(0.0, abs=1e-17)


@pytest.mark.parametrize(
    ("kind", "radius"), [(0, 1.0 / (1.0 / 5e-3 + 1.0 / 18e-3)), (1, 1.0 / (200.0 - 1.0 / 28e-3)), (2, 2.5e-3)]
)
def test_a_pair_has_johnsons_half_width_and_pressure(kind, radius):
    """b² = 4QR/(πE*L), p₀ = sqrt(QE*/(πRL)) (Johnson, Contact Mechanics, 1985, (4.43), (4.45))."""
    pair, force = contact_pairs(PAPER)[kind], 628.0
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    assert pair.relative_radius == pytest.approx(radius, rel=1e-14)
    assert pair.modulus == pytest.approx(modulus, rel=1e-14)
    assert pair.half_width(force) == pytest.approx(sqrt(4.0 * force * radius / (pi * modulus * 10e-3)), rel=1e-14)
    assert pair.peak_pressure(force) == pytest.approx(sqrt(force * modulus / (pi * radius * 10e-3)), rel=1e-14)
    assert pair.peak_pressure(0.0) == 0.0


def test_a_rigid_body_adds_no_compliance_but_two_rigid_rollers_have_their_materials():
    rigid = replace(PAPER, roller=replace(PAPER.roller, rigid=True))
    (inner, _, between), (soft, _, same) = contact_pairs(rigid), contact_pairs(PAPER)
    assert inner.modulus == pytest.approx(2.0 * soft.modulus, rel=1e-14)
    assert between == same
