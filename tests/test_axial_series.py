"""Circular bodies under loads that vary along the axis: Navier's equations, the plane series, the half-space."""

from math import exp, log, pi

import numpy as np
import pytest

from fem.elastic.axial_series import (
    _fields,
    _scaled,
    axial_difference,
    axial_limit,
    harmonic_compliance,
    slice_compliance,
)
from fem.elastic.continuum import Section, hertz_approach, plane_compliance, ring_sections, roller_section
from tests.reference.bearings import STEEL, paper

PAPER = paper()
ROLLER, (INNER, OUTER) = roller_section(PAPER).squeezed, ring_sections(PAPER)
SOLID = Section(INNER.loaded, 0.0, STEEL)
UNIT = 1.0 / (pi * STEEL.plane_strain_modulus)  # m per N/m
STEP = 1e-5  # m, of differences


@pytest.mark.parametrize("decay", [False, True])
@pytest.mark.parametrize("n", [0, 1, 4])
def test_each_field_satisfies_navier_and_hooke(n, decay):
    """Differences of second order of the displacements at points of a cube, as good as their own error."""
    k, R, nu, orders = 600.0, 5e-3, STEEL.poisson_ratio, np.array([n])

    def displaced(point, which):
        x, y, z = point
        r, angle = np.hypot(x, y), np.arctan2(y, x)
        U, V, W = _fields(orders, k, r, nu, _scaled(orders, k, r, R, decay), decay)[0, :3, which]
        radial, around = U * np.cos(n * angle) * np.cos(k * z), V * np.sin(n * angle) * np.cos(k * z)
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * radial - s * around, s * radial + c * around, W * np.cos(n * angle) * np.sin(k * z)])

    at, axes = np.array([3.1e-3, 1.7e-3, 0.4e-3]), STEP * np.eye(3)
    for which in range(3):

        def u(*shifts, which=which):
            return displaced(at + sum(shifts), which)

        second = np.empty((3, 3, 3))  # ∂i ∂j u
        for i in range(3):
            for j in range(3):
                a, b = axes[i], axes[j]
                second[i, j] = (u(a, b) - u(a, -b) - u(-a, b) + u(-a, -b)) / (4.0 * STEP**2)
        laplacian = second[0, 0] + second[1, 1] + second[2, 2]
        swelling = np.array([sum(second[i, j, j] for j in range(3)) for i in range(3)])
        left = laplacian + swelling / (1.0 - 2.0 * nu)
        assert np.abs(left).max() < 2e-3 * np.abs(second).max()
        gradient = np.stack([(u(axes[i]) - u(-axes[i])) / (2.0 * STEP) for i in range(3)])
        strain = 0.5 * (gradient + gradient.T)
        stress = 2.0 * strain + 2.0 * nu / (1.0 - 2.0 * nu) * np.trace(strain) * np.eye(3)
        r, angle, z = np.hypot(*at[:2]), np.arctan2(at[1], at[0]), at[2]
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        traction = stress @ out
        rows = _fields(orders, k, r, nu, _scaled(orders, k, r, R, decay), decay)[0, 3:, which]
        known = (
            rows[0] * np.cos(n * angle) * np.cos(k * z),
            rows[1] * np.sin(n * angle) * np.cos(k * z),
            rows[2] * np.cos(n * angle) * np.sin(k * z),
        )
        found = traction @ out, traction @ np.array([-out[1], out[0], 0.0]), traction[2]
        assert found == pytest.approx(known, rel=1e-3, abs=1e-3 * np.abs(stress).max())


def test_long_waves_give_the_plane_series():
    n, k = np.array([2, 4, 6, 20]), 0.05  # 1/m: kR = 2.5e-4
    assert harmonic_compliance(ROLLER, n, k) == pytest.approx(plane_compliance(ROLLER, n), rel=1e-6)
    n = np.array([1, 2, 5, 20])
    for ring in (INNER, OUTER):
        assert harmonic_compliance(ring, n, k) == pytest.approx(plane_compliance(ring, n), rel=1e-6)
        assert axial_difference(ring, k) / UNIT == pytest.approx(0.0, abs=1e-5)
    assert axial_difference(ROLLER, 1.0) == pytest.approx(axial_limit(STEEL), rel=1e-4)
    assert axial_limit(STEEL) / UNIT == pytest.approx(0.1978, abs=5e-5)


def test_a_solid_shaft_is_a_cylinder_in_a_pulsating_band_and_a_beam():
    """Uniform around: Timoshenko and Goodier, Theory of Elasticity, 143; across, of long waves: q/(E I k⁴)."""
    from scipy.special import i0, i1

    a, nu = SOLID.loaded, STEEL.poisson_ratio
    for x in (0.02, 0.5, 3.0):
        swollen, bent = harmonic_compliance(SOLID, np.array([0, 1]), x / a)
        free = x * x * (i0(x) ** 2 - i1(x) ** 2) - 2.0 * (1.0 - nu) * i1(x) ** 2
        assert swollen == pytest.approx(a * (1.0 - nu) / STEEL.lame_mu * i1(x) ** 2 / free, rel=1e-9)
        if x < 0.1:
            assert bent == pytest.approx(4.0 * a / (STEEL.youngs_modulus * x**4), rel=x * x)


@pytest.mark.parametrize(
    "k, expected, within",
    [
        (pi / 10, (-0.3644, -0.4133, -0.2040), 0.0005),
        (pi / 5, (-1.4303, -1.3453, -0.8674), 0.0005),
        (pi, (-4.6530, -4.5389, -3.9678), 0.003),
    ],
)
def test_differences_of_the_papers_bodies(k, expected, within):
    """Of an independent prototype, 1/mm."""
    found = [axial_difference(body, 1e3 * k) / UNIT for body in (ROLLER, INNER, OUTER)]
    assert found == pytest.approx(expected, abs=within)


def test_short_waves_see_the_depth_that_the_plane_approach_implies():
    """K0 of a half-space under a line load cos kz less the plane approach under Hertz's pressure, at its centre."""
    k, half_width = 24e3, 1e-5
    for body in (ROLLER, INNER, OUTER, SOLID):
        depth = 0.25 * half_width * exp(0.5 * hertz_approach(body, half_width) / UNIT - 0.5)
        expected = -2.0 * (log(k * depth) + np.euler_gamma)
        assert axial_difference(body, k) / UNIT == pytest.approx(expected, abs=0.005)


def test_slices_know_each_other_as_a_half_space_has_it():
    """Own value 2 ln(h/ℓ) − 2 over π E' of narrow slices; 2 ln 2 of neighbours."""
    slices, length = 41, 10e-3
    h = length / slices
    found = slice_compliance(INNER, length, 2.0 * length, slices) * h / UNIT
    assert found == pytest.approx(found.T, abs=1e-9)
    assert found[20, 20] == pytest.approx(2.0 * log(h / 1.7334e-3) - 2.0, abs=0.06)
    assert found[20, 21] == pytest.approx(2.0 * log(2.0), abs=0.06)
