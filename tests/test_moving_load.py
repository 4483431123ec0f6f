"""Loads that roll along surfaces: inertia of the material that flows through a contact makes it softer."""

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from fem.elastic.continuum import (
    FASTEST,
    PRESSURE,
    Section,
    annulus_modes,
    annulus_weights,
    kolosov,
    moving_softening,
    plane_compliance,
)
from fem.errors import UsageError
from fem.interface import simulate
from lagrange import Material
from lagrange.scene.scene import parse_scene

SOFT = Material(youngs_modulus=50e9, poisson_ratio=0.3, density=10_600.0)
SHEAR_WAVE = (SOFT.lame_mu / SOFT.density) ** 0.5


def gained(n, radius, held, material, speed):
    """Share of a short wave's compliance that its inertia adds to it, to first order, as it runs along a still ring.

    A pressure p cos n(θ − vt/R) moves the static field along; the work of its inertia, ρ (n v/R)² ∫ (U² + V²) r dr,
    is taken from that of the pressure.
    """
    t, kappa = held / radius, kolosov(material)
    weights = annulus_weights(n, t, kappa, PRESSURE)
    at, parts = leggauss(400)
    places = 0.5 * (1.0 + t) + 0.5 * (1.0 - t) * at
    work = 0.0
    for r, part in zip(places, 0.5 * (1.0 - t) * parts, strict=True):
        u, v = (np.sum(annulus_modes(n, r, t, kappa)[:, row] * weights, axis=1) for row in (0, 1))
        work += part * r * (u**2 + v**2) * (radius / (2.0 * material.lame_mu)) ** 2
    inertia = material.density * (n * speed / radius) ** 2 * work * radius
    return inertia / plane_compliance(Section(radius, held, material), n)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.45])
def test_slow_loads_gain_what_the_inertia_of_a_static_field_asks_for(poisson_ratio):
    material = Material(youngs_modulus=50e9, poisson_ratio=poisson_ratio, density=10_600.0)
    speed = 0.02 * (material.lame_mu / material.density) ** 0.5
    (wave,) = gained(np.array([150]), 0.1, 0.06, material, speed)
    assert moving_softening(material, speed) - 1.0 == pytest.approx(wave, rel=0.02)  # curvature: 1/n


def test_a_load_at_rest_gains_nothing_and_a_faster_one_more():
    found = [moving_softening(SOFT, share * SHEAR_WAVE) for share in (0.0, 1e-9, 0.1, -0.1, 0.3, 0.4)]
    assert found[:2] == pytest.approx([1.0, 1.0], abs=1e-15)
    assert found[2] == found[3]
    assert 1.0 < found[2] < found[4] < found[5]
    # Rayleigh's function by itself, v/c₂ = 0.4 and (c₂/c₁)² = 2/7
    shear, pressure = np.sqrt(1.0 - 0.16), np.sqrt(1.0 - 0.16 * 2.0 / 7.0)
    by_hand = 0.16 * pressure / (4.0 * shear * pressure - (1.0 + shear**2) ** 2) / 0.7
    assert found[5] == pytest.approx(by_hand, rel=1e-12)


def test_a_load_nearly_as_fast_as_waves_is_refused():
    with pytest.raises(UsageError, match=r"shear waves travel at 1[0-9]+"):
        moving_softening(SOFT, 1.01 * FASTEST * SHEAR_WAVE)


def test_soft_rings_that_turn_fast_give_way_as_finite_elements_say():
    """A hub on contacts that roll at 107 m/s along an outer ring whose shear waves travel at 1.3 km/s."""
    scene = {
        "bearing": {
            "rollers": 30, "roller_diameter_mm": 34.0, "roller_length_mm": 45.0, "inner_raceway_diameter_mm": 303.0,
            "outer_raceway_diameter_mm": 371.1, "bore_diameter_mm": 126.0, "outside_diameter_mm": 476.0,
        },
        "material": {
            "density_kg_m3": 10_600.0, "roller": {"youngs_modulus_GPa": 275.0},
            "inner_ring": {"youngs_modulus_GPa": 45.0}, "outer_ring": {"youngs_modulus_GPa": 50.0},
        },
        "operation": {"speed_rpm": 12_000.0, "radial_load_N": 15_000.0, "inner_ring_and_shaft_kg": 29.0},
        "contact": {"friction_coefficient": 0.0},
        "numerics": {"mesh_size_mm": 2.8, "duration_ms": 4.0},
    }  # fmt: skip
    elements, reduced = (simulate(parse_scene(scene | {"model": model}, "scene")) for model in ("fem", "reduced"))
    assert reduced["inner_y"].mean() == pytest.approx(elements["inner_y"].mean(), rel=1e-3)
