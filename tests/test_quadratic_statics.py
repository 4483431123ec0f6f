"""Statics on refined quadratic meshes: meshes, compliances of single bodies, and the whole bearing."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fem.statics.contact_balance import NotFound
from lagrange.surface.faults import UnequalRoller
from meshes import quality
from tests.reference.bearings import LENGTH, LOAD, STEEL, paper
from tests.reference.line_contact import half_width, squeezed_disc_approach
from tests.reference.quadratic_elements import contact_nodes, disc_spot_compliance, ring_spot_compliance
from tests.reference.quadratic_statics import quadratic_statics
from tests.reference.refined_mesh import RefinedDisc, RefinedSector, Spot, refined_mesh
from tests.reference.resolved_bearing import RESOLVED

B = 5e-5  # m
SPOT = Spot(half_width=B, per_half_width=4)
OTHER = Spot(half_width=0.8 * B, per_half_width=4)  # the same contact on another mesh


def pressed_by_hertz(spot):
    """Shares of a Hertz pressure of half-width B on the nodes of a spot."""
    along, length = contact_nodes(spot)
    share = length * np.sqrt(np.maximum(0.0, 1.0 - (along / B) ** 2))
    return share / share.sum()


# meshes and compliances -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape",
    [
        RefinedDisc(radius=0.005, spot=SPOT),
        RefinedSector(raceway_radius=0.018, held_radius=0.0125, sectors=13, spot=SPOT),
        RefinedSector(raceway_radius=0.028, held_radius=0.0325, sectors=3, spot=SPOT),
    ],
)
def test_meshes_are_as_fine_as_the_contact_and_their_triangles_fair(shape):
    mesh = refined_mesh(shape)
    found = quality(mesh)
    assert found.smallest_angle > 30.0 and found.largest_angle < 120.0
    assert found.smallest_edge < 1.05 * SPOT.finest
    assert found.largest_edge > 100.0 * SPOT.finest, "coarse away from the contact"
    edges = np.diff(SPOT.corners)
    at_rim = edges[np.searchsorted(SPOT.corners, B) - 1]
    assert at_rim == pytest.approx(B / 4.0, rel=0.2)


def test_node_lengths_integrate_quadratics():
    along, length = contact_nodes(SPOT)
    end = along[-1]
    assert length.sum() == pytest.approx(2.0 * end, rel=1e-12)
    assert length @ along**2 == pytest.approx(2.0 / 3.0 * end**3, rel=1e-12)


def test_a_squeezed_disc_gives_way_as_johnson_says():
    own, other = disc_spot_compliance(RefinedDisc(radius=0.005, spot=SPOT), STEEL, LENGTH)
    np.testing.assert_allclose(own, own.T, atol=1e-10 * own.max())
    share, along = pressed_by_hertz(SPOT), contact_nodes(SPOT)[0]
    width = 2.0 * np.sqrt(share @ along**2)  # of the pressure as the nodes have it: 0.8 % off B
    # a mean weighted with the pressure: the middle sinks in by q/(2πE') more
    q = 1.0 / LENGTH
    middle = share @ (own + other[:, ::-1]) @ share + 0.5 * q / (np.pi * STEEL.plane_strain_modulus)
    exact = squeezed_disc_approach(q, 0.005, width, STEEL.plane_strain_modulus)
    assert middle == pytest.approx(exact, rel=2e-4)


@pytest.mark.slow
def test_a_ring_is_the_same_cut_into_other_sectors():
    shape = {"raceway_radius": 0.018, "held_radius": 0.0125}
    of_four = ring_spot_compliance(RefinedSector(sectors=4, spot=SPOT, **shape), STEEL, LENGTH)
    of_eight = ring_spot_compliance(RefinedSector(sectors=8, spot=OTHER, **shape), STEEL, LENGTH)
    four = pressed_by_hertz(SPOT) @ of_four @ pressed_by_hertz(SPOT)
    eight = pressed_by_hertz(OTHER) @ of_eight @ pressed_by_hertz(OTHER)
    np.testing.assert_allclose(four, eight[::2], atol=2e-3 * four[0])
    np.testing.assert_allclose(four[1:], eight[2::2], rtol=2e-3)
    np.testing.assert_allclose(of_eight[3], of_eight[-3].T, atol=1e-9 * of_eight[0].max())


# the whole bearing ----------------------------------------------------------------------------------------------


@cache
def at_rest(place, per_half_width):
    return quadratic_statics(paper(), LOAD, RESOLVED[place][0], per_half_width)


@pytest.mark.parametrize("place", RESOLVED)
def test_the_papers_bearing_rests_as_another_code_finds(place):
    _, microns, loads = RESOLVED[place]
    found = at_rest(place, 4.0)
    assert -1e6 * found.hub[1] == pytest.approx(microns, rel=5e-4)
    assert abs(found.hub[0]) < 1e-5 * abs(found.hub[1])
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][:7], loads, atol=1e-3 * max(loads))


def test_bodies_push_or_stand_apart_and_carry_the_load():
    found = at_rest("on a roller", 4.0)
    pressure = np.array([found.inner_pressure, found.outer_pressure])
    assert pressure.min() == 0.0 and found.gap.min() > -1e-15
    assert np.abs(found.gap[pressure > 0.0]).max() < 1e-15
    angle = -0.5 * np.pi + 2.0 * np.pi * np.arange(13) / 13
    centres = found.rho[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) - found.hub
    normal = centres / np.linalg.norm(centres, axis=1)[:, None]
    np.testing.assert_allclose(found.inner_force @ normal, [0.0, -LOAD], atol=1e-5)
    np.testing.assert_allclose(found.outer_force, found.inner_force, atol=1e-4)


def test_pressures_are_hertzs():
    """Ellipse of p0 = 2Q/(πbL) over ±b (Johnson, Contact Mechanics, 1985, chapter 4); nodes beside its rim apart."""
    found = at_rest("on a roller", 4.0)
    for forces, pressures, curvature in (
        (found.inner_force, found.inner_pressure, 1.0 / 0.005 + 1.0 / 0.018),
        (found.outer_force, found.outer_pressure, 1.0 / 0.005 - 1.0 / 0.028),
    ):
        q = forces[0] / LENGTH
        b = half_width(q, 1.0 / curvature, 0.5 * STEEL.plane_strain_modulus)
        peak = 2.0 * q / (np.pi * b)
        inside, outside = np.abs(found.across) < 0.8 * b, np.abs(found.across) > 1.2 * b
        ellipse = peak * np.sqrt(1.0 - (found.across[inside] / b) ** 2)
        np.testing.assert_allclose(pressures[0, inside], ellipse, atol=0.03 * peak)
        assert pressures[0].max() == pytest.approx(peak, rel=0.01)
        assert not pressures[0, outside].any()


def test_a_mesh_made_for_other_contacts_is_refused():
    with pytest.raises(ValueError, match="radial load 0 N"):
        quadratic_statics(paper(), 0.0, 0.0)
    with pytest.raises(NotFound, match="wider than"):  # preload, not the load, makes the contacts
        quadratic_statics(paper(outer_raceway_radius=0.027995), 1.0, 0.0, 2.0)


def test_surfaces_that_are_not_circles_are_refused():
    faulty = replace(paper(), faults=(UnequalRoller(roller=0, diameter_deviation=1e-6),))
    with pytest.raises(ValueError, match="perfect circles"):
        quadratic_statics(faulty, LOAD, -np.pi / 2)
