"""Rings and rollers under tangential tractions, and spinning, against Navier's equations and closed forms."""

from math import log

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import solve_bvp

from fem.elastic.continuum import Section, cross_compliance, shear_approach, shear_compliance
from lagrange import Material
from lagrange.fits import SLOW, spinning_growth
from tests.reference.polar_navier import PolarNavier

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
SOFT = Material(youngs_modulus=3e9, poisson_ratio=0.45, density=1200.0)
RADIUS, INNER, OUTER = 0.005, (0.018, 0.0125), (0.028, 0.0325)


def sheared_ring(n, loaded, held, material):
    """Displacement along the traction, and into the ring, m/Pa."""
    t = held / loaded
    problem = PolarNavier(n, min(1.0, t), max(1.0, t), 48, material)
    U, V, *_ = problem.blocks(t)
    out, around, s_rr, s_rt, *_ = problem.blocks(1.0)
    coefficients = problem.solve([(U, 0.0), (V, 0.0), (s_rr, 0.0), (s_rt, np.sign(1.0 - t))])
    along, outwards = (around @ coefficients)[0], (out @ coefficients)[0]
    return along * loaded / material.lame_mu, -np.sign(1.0 - t) * outwards * loaded / material.lame_mu


def sheared_disc(n, radius, material):
    """n = 1 has a uniform body force and zero mean displacement."""
    problem = PolarNavier(n, 0.0, 1.0, 24, material)
    _, around, s_rr, s_rt, *_ = problem.blocks(1.0)
    conditions, force = [(s_rr, 0.0), (s_rt, 1.0)], (0.0, 0.0)
    if n == 1:
        x, weight = legendre.leggauss(40)
        r = 0.5 * (1.0 + x)
        U, V, *_ = problem.blocks(r)
        conditions.append((((weight * r)[:, None] * (U - V)).sum(axis=0), 0.0))
        force = (1.0, -1.0)  # along +x, against the traction's resultant −π R τ x̂ on the area π R²
    coefficients = problem.solve(conditions, force)
    return (around @ coefficients)[0] * radius / material.lame_mu


@pytest.mark.parametrize("material", [STEEL, SOFT])
@pytest.mark.parametrize("ring", [INNER, OUTER, (0.02, 0.005)])
def test_a_sheared_ring_agrees_with_navier_equations(ring, material):
    n = np.array([0, 1, 2, 3, 5, 8, 13, 20])
    along, inwards = np.transpose([sheared_ring(k, *ring, material) for k in n])
    np.testing.assert_allclose(shear_compliance(Section(*ring, material), n), along, rtol=1e-8)
    np.testing.assert_allclose(cross_compliance(Section(*ring, material), n), inwards, rtol=1e-8, atol=1e-20)


@pytest.mark.parametrize("ring", [INNER, OUTER])
def test_narrow_tractions_press_a_surface_down_ahead_of_them(ring):
    """A half-plane by (1 − 2ν)(1 + ν)/2E: Johnson, Contact Mechanics (1985), section 2.5."""
    n = np.array([2000, 20000])
    found = cross_compliance(Section(*ring, STEEL), n) * n / ring[0]  # Σ sin(nθ)/n = π/2, so all alike
    wanted = (1.0 - 2.0 * 0.3) * (1.0 + 0.3) / STEEL.youngs_modulus
    assert np.all(np.abs(-found / wanted - 1.0) < 4.0 / n)  # the circle's curvature adds a share 1/n
    assert np.all(found < 0.0)  # sin nθ lags a quarter of a wave behind cos nθ: down ahead of a pull along +θ


@pytest.mark.parametrize("material", [STEEL, SOFT])
def test_a_sheared_disc_agrees_with_navier_equations_and_inertia_relief(material):
    n = np.array([1, 2, 3, 4, 7, 12])
    found = shear_compliance(Section(RADIUS, 0.0, material), n)
    np.testing.assert_allclose(found, [sheared_disc(k, RADIUS, material) for k in n], rtol=1e-8)


def test_a_uniform_traction_twists_a_disc_that_speeds_up():
    """σ_rθ = μ r d(v/r)/dr grows as r² where the body force does as r; the mean rotation is taken out."""
    r = np.linspace(0.0, RADIUS, 2001)
    twist = np.concatenate([[0.0], np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(r))]) / (STEEL.lame_mu * RADIUS**2)
    around = r * twist
    around -= r * np.trapezoid(around * r**2, r) / np.trapezoid(r**3, r)
    found = shear_compliance(Section(RADIUS, 0.0, STEEL), np.array([0]))[0]
    assert found == pytest.approx(around[-1], rel=1e-5)


@pytest.mark.parametrize("radii", [(RADIUS, 0.0), INNER, OUTER])
def test_narrow_tractions_move_a_surface_as_pressures_do_a_half_plane(radii):
    """Halving the width adds (2/πE′) ln 2 (Johnson, Contact Mechanics, section 2.8)."""
    section = Section(*radii, STEEL)
    added = shear_approach(section, 2e-5) - shear_approach(section, 4e-5)
    assert added == pytest.approx(2.0 / (np.pi * STEEL.plane_strain_modulus) * log(2.0), rel=1e-3)


def test_a_spinning_disc_and_ring_grow_as_in_timoshenko():
    """Timoshenko and Goodier, section 32, with E/(1−ν²) and ν/(1−ν) for plane strain; what has grown adds 10⁻⁵."""
    speed, rho = 2000.0, STEEL.density
    E, nu = STEEL.youngs_modulus / (1 - 0.3**2), 0.3 / 0.7
    wanted = (1.0 - nu) / (4.0 * E) * rho * speed**2 * RADIUS**3
    assert spinning_growth(RADIUS, 0.0, STEEL, speed) == pytest.approx(wanted, rel=1e-5)
    # a thin hoop carried by a rigid hub of half its radius grows less than one that is free, by ρω²r³/E
    outer, held = 0.018, 0.0125
    free = rho * speed**2 * outer**3 / E
    assert 0.0 < spinning_growth(outer, held, STEEL, speed) < free
    a = spinning_growth(outer, held, STEEL, speed)
    assert spinning_growth(outer, held, STEEL, 2.0 * speed) == pytest.approx(4.0 * a, rel=1e-4)


@pytest.mark.parametrize("held", [0.0, 0.0125], ids=["disc", "ring on a hub"])
def test_what_has_grown_is_carried_around(held):
    """The equation of motion by collocation, at 360 m/s: 0.05 and 0.2 % beyond what ρω²r alone gives."""
    radius, speed, mu, lame = 0.018, 2e4, SOFT.lame_mu, SOFT.lame_lambda
    stiff = lame + 2.0 * mu

    def rates(r, state):
        u, slope = state
        return np.array([slope, u / r**2 - slope / r - SOFT.density * speed**2 * (r + u) / stiff])

    def ends(first, last):  # a disc's middle is u/r = u'
        centre = first[0] - from_ * first[1] if held == 0.0 else first[0]
        return np.array([centre, stiff * last[1] + lame * last[0] / radius])

    from_ = held or 1e-4 * radius
    r = np.linspace(from_, radius, 200)
    exact = solve_bvp(rates, ends, r, np.array([1e-7 * r / radius, np.full(r.size, 1e-7 / radius)]), tol=1e-9)
    assert exact.success
    found = spinning_growth(radius, held, SOFT, speed)
    assert found == pytest.approx(exact.y[0, -1], rel=1e-6)
    assert found > 1.0004 * 1e6 * spinning_growth(radius, held, SOFT, 1e-3 * speed)


@pytest.mark.parametrize("held", [0.0, 0.0125], ids=["disc", "ring on a hub"])
def test_growth_does_not_jump_where_what_has_grown_begins_to_be_carried_around(held):
    radius = 0.018
    limit = (SLOW * (SOFT.lame_lambda + 2.0 * SOFT.lame_mu) / SOFT.density) ** 0.5 / radius
    slow, fast = (spinning_growth(radius, held, SOFT, share * limit) / share**2 for share in (0.9999, 1.0001))
    assert slow < fast < slow * (1.0 + 2e-5)
