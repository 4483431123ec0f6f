"""The contact law below the grid: finite elements plus law give the exact approach wherever the contact sits."""

from dataclasses import replace

import numpy as np
import pytest

from fem.contacts.points import disc_patch_traction, ring_patch_force, ring_patch_traction
from fem.contacts.subgrid import disc_surface_compliance, rigid_surface, ring_surface_compliance, shear_level
from fem.elastic.bodies import disc_body
from fem.elastic.continuum import hertz_approach, stick_approach
from fem.kernels.law import ripple_at
from lagrange import Material
from meshes import Disc
from tests.reference.bearings import LENGTH, STEEL, disc, ring
from tests.reference.line_contact import half_width, squeezed_disc_approach
from tests.verification.contact_statics import POSITIONS, law_on_rigid, squeezed

RADIUS = 0.005
CALIBRATED_AT = 5e-5  # half-width b, m, as `fem.contacts.subgrid` does for this roller
FORCES = np.array([100.0, 200.0, 400.0, 628.0, 800.0, 1000.0])
MODULUS = 210e9 / (1.0 - 0.3**2)


@pytest.mark.parametrize("layers", [3, 5, 10])
def test_a_squeezed_disc_has_johnsons_approach_at_every_position(layers):
    body = disc(RADIUS, layers)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    law = law_on_rigid(surface, RADIUS)
    positions = np.array(POSITIONS) * layers / 5.0
    grid = np.array([squeezed(body, surface, position) for position in positions])
    for force in FORCES:
        q = force / LENGTH
        b = half_width(q, RADIUS, MODULUS)
        assert law.pair.half_width(force) == pytest.approx(b, rel=1e-12)
        found = grid * force + law.approach(force)
        # Johnson's formula is the limit b << R; its next term is O(b/R) of a bracket of about 14, 0.05 % at b/R = 0.013
        np.testing.assert_allclose(found, squeezed_disc_approach(q, RADIUS, b, MODULUS), rtol=1e-3)
        # measured spread 1e-4: between its knots the ripple's spline is off by h⁴ of a short wave
        assert np.ptp(found) < 5e-4 * found.mean()
    # without the ripple the same contact is softer at some places than at others
    assert surface.spread > 5e-3


def test_the_calibration_holds_for_other_half_widths():
    body = disc(RADIUS, 5)
    laws = [
        law_on_rigid(disc_surface_compliance(body, LENGTH, b), RADIUS) for b in (CALIBRATED_AT, CALIBRATED_AT / 10.0)
    ]
    # the O(b/R) that is left out, 0.3 b/R of a bracket of about 2
    assert laws[0].B == pytest.approx(laws[1].B, abs=0.01)
    assert laws[0].A == laws[1].A == pytest.approx(2.0 / (np.pi * MODULUS * LENGTH), rel=1e-14)


@pytest.mark.parametrize("held_inside", [True, False])
@pytest.mark.parametrize("scale", [1, 2])
def test_a_held_ring_has_the_exact_approach_at_every_position(held_inside, scale):
    body = (
        ring(0.0125, 0.018, 56 * scale, 3 * scale, True)
        if held_inside
        else ring(0.028, 0.0325, 88 * scale, 2 * scale, False)
    )
    surface = ring_surface_compliance(body, LENGTH, CALIBRATED_AT)
    law = law_on_rigid(surface, body.raceway_radius)
    force = 500.0
    for position in (0.0, 0.19, 0.5, 7.7, body.n_sectors - 0.4):
        load = ring_patch_force(body, 2.0 * np.pi * position / body.n_sectors)
        grid = np.vdot(load, body.held(load)) + ripple_at(np.mod(position, 1.0), surface.ripple)[0]
        exact = hertz_approach(body.section, law.pair.half_width(force)) / LENGTH
        # b differs fourfold from the calibration's; O(b/R)
        assert grid * force + law.approach(force) == pytest.approx(exact * force, rel=1e-3)


def missing_shear(surface, radius, force):
    """What the mesh lacks of a contact's tangential compliance, m/N, against a rigid plane."""
    pair = law_on_rigid(surface, radius).pair
    return surface.unit * (shear_level(surface, rigid_surface(1.0), pair) - 0.5 * np.log(force)), pair.half_width(force)


@pytest.mark.parametrize("layers", [3, 5, 10])
def test_a_disc_that_sticks_has_the_exact_tangential_compliance_at_every_position(layers):
    body = disc(RADIUS, layers)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    for force in (30.0, 628.0):
        below, b = missing_shear(surface, RADIUS, force)
        exact = stick_approach(body.section, b) / LENGTH
        found = []
        for position in np.array(POSITIONS) * layers / 5.0:
            load = disc_patch_traction(body, 2.0 * np.pi * position / body.shape.surface_nodes)
            found.append(float(load @ body.relaxed(load)) + below)
        # the mesh is softer at some places than at others, which the level, a mean, does not follow
        np.testing.assert_allclose(found, exact, rtol=0.012)
        assert np.mean(found) == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("held_inside", [True, False])
def test_a_ring_that_sticks_has_the_exact_tangential_compliance_at_every_position(held_inside):
    body = ring(0.0125, 0.018, 56, 3, True) if held_inside else ring(0.028, 0.0325, 88, 2, False)
    below, b = missing_shear(ring_surface_compliance(body, LENGTH, CALIBRATED_AT), body.raceway_radius, 500.0)
    exact = stick_approach(body.section, b) / LENGTH
    for position in (0.0, 0.19, 0.5, 7.7, body.n_sectors - 0.4):
        load = ring_patch_traction(body, 2.0 * np.pi * position / body.n_sectors)
        assert np.vdot(load, body.held(load)) + below == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("angle", [0.0, 1.234, -2.5])
def test_a_patchs_traction_has_the_force_and_the_moment_of_one_on_the_circle(angle):
    body, along = disc(RADIUS, 3), np.array([-np.sin(angle), np.cos(angle)])
    load = disc_patch_traction(body, angle).reshape(-1, 2)
    np.testing.assert_allclose(load.sum(axis=0), along, atol=1e-14)
    moment = np.sum(body.points[:, 0] * load[:, 1] - body.points[:, 1] * load[:, 0])
    assert moment == pytest.approx(RADIUS, rel=1e-12)
    hoop = ring(0.0125, 0.018, 56, 3, True)
    load = ring_patch_traction(hoop, angle)
    np.testing.assert_allclose(hoop.cartesian(load).sum(axis=0), along, atol=1e-14)
    assert load[:, 1].sum(axis=1) @ hoop.radii == pytest.approx(0.018, rel=1e-12)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_law_scales_with_modulus_and_length(factor):
    body = disc(RADIUS, 3)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    soft = replace(STEEL, youngs_modulus=factor * 210e9)
    other = disc_surface_compliance(
        replace(body, material=soft, stiffness=factor * body.stiffness), LENGTH, CALIBRATED_AT
    )
    assert other.missing == pytest.approx(surface.missing / factor, rel=1e-9)
    assert other.unit == pytest.approx(surface.unit / factor, rel=1e-14)
    assert law_on_rigid(other, RADIUS, soft).pair.half_width_factor * factor == pytest.approx(
        law_on_rigid(surface, RADIUS).pair.half_width_factor, rel=1e-12
    )


def test_similar_rollers_have_similar_laws():
    """Twice the size at the same length: the same compliance, half-widths larger by the square root of two."""
    small, large = disc(RADIUS, 4), disc_body(Disc(radius=2.0 * RADIUS, layers=4), STEEL, LENGTH)
    laws = [
        law_on_rigid(disc_surface_compliance(body, LENGTH, 0.01 * body.shape.radius), body.shape.radius)
        for body in (small, large)
    ]
    assert laws[1].A == laws[0].A
    # ln b enters with b²/Q = 2 R A: at the same Q/R the approach over Q is the same
    assert laws[1].B == pytest.approx(laws[0].B + 0.5 * np.log(2.0), abs=1e-9)


def test_poissons_ratio_matters_only_through_the_plane_strain_modulus_in_johnsons_formula():
    material = Material(youngs_modulus=100e9, poisson_ratio=0.2, density=3000.0)
    body = disc(RADIUS, 5, material)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    law, force = law_on_rigid(surface, RADIUS, material), 300.0
    modulus = 100e9 / (1.0 - 0.04)
    b = half_width(force / LENGTH, RADIUS, modulus)
    wanted = squeezed_disc_approach(force / LENGTH, RADIUS, b, modulus)
    assert squeezed(body, surface, 1.2) * force + law.approach(force) == pytest.approx(wanted, rel=1e-3)


def test_the_ripple_goes_through_its_samples_and_is_smooth():
    surface = disc_surface_compliance(disc(RADIUS, 3), LENGTH, CALIBRATED_AT)
    period = surface.ripple.size / 8.0
    assert period == 3.0
    value = np.array([ripple_at(x, surface.ripple) for x in np.linspace(0.0, 18.0, 18 * 40 + 1)])
    np.testing.assert_allclose(value[: 3 * 40], value[3 * 40 : 6 * 40], atol=1e-9 * np.abs(value).max())
    assert np.abs(value[: 3 * 40 : 5, 0].mean()) < 1e-12 * np.abs(value[:, 0]).max()  # at the knots, zero mean
    step = 1e-6
    for x in (0.3, 1.0, 2.999, 17.9):
        difference = (ripple_at(x + step, surface.ripple)[0] - ripple_at(x - step, surface.ripple)[0]) / (2.0 * step)
        assert ripple_at(x, surface.ripple)[1] == pytest.approx(difference, rel=1e-6, abs=1e-18)
