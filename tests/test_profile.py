"""What a roller reaches of imperfect surfaces: depths known in closed form, slopes, periodicity."""

from dataclasses import replace

import numpy as np
import pytest

from lagrange.scene.scene import Scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.faults import Spall, UnequalRoller, Waviness

PAPER = Scene().ideal_bearing()
MIDDLE = 0.3  # rad
# m: sinkage of a 10 mm roller between the edges of a sharp gap in raceways of 56 and 36 mm, from
# h = [r − √(r² − L²/4)] ∓ [R − √(R² − L²/4)]
SHARP_GAPS = {
    0.3e-3: (1.849e-6, 2.876e-6),
    0.5e-3: (5.138e-6, 7.990e-6),
    1.0e-3: (20.60e-6, 32.01e-6),
    2.0e-3: (83.16e-6, 128.8e-6),
}


def spalled(body, **changes):
    spall = dict(body=body, roller=3 if body == "roller" else None, angle=MIDDLE, width=1e-3, depth=1e-3,
                 edge_radius=0.1e-3)  # fmt: skip
    return profiles(replace(PAPER, faults=(Spall(**(spall | changes)),)))


def inner(surfaces, angle, roller=3):
    return np.array([surfaces.inner(np.full(13, a), Turns()).sinkage[roller] for a in np.atleast_1d(angle)])


def outer(surfaces, angle, roller=3):
    return np.array([surfaces.outer(np.full(13, a), Turns()).sinkage[roller] for a in np.atleast_1d(angle)])


@pytest.mark.parametrize("edge_radius", [pytest.param(0.0, marks=pytest.mark.slow), 0.1e-3])
@pytest.mark.parametrize("width", SHARP_GAPS)
def test_a_roller_sinks_between_the_edges_of_a_gap(width, edge_radius):
    """Whatever the body with the gap, within 1 % or 0.05 µm."""
    outside, inside = SHARP_GAPS[width]
    shape = dict(width=width, edge_radius=edge_radius)
    on_roller = spalled("roller", **shape)
    for found, expected in (
        (outer(spalled("outer_ring", **shape), MIDDLE), outside),
        (inner(spalled("inner_ring", **shape), MIDDLE), inside),
        (outer(on_roller, MIDDLE), outside),
        (inner(on_roller, MIDDLE - np.pi), inside),
    ):
        assert found == pytest.approx(expected, rel=0.01, abs=0.05e-6)


def test_a_roller_between_two_edges_does_not_reach_the_bottom():
    shallow, deep = (outer(spalled("outer_ring", depth=depth), MIDDLE) for depth in (25e-6, 1e-3))
    assert shallow == pytest.approx(deep, rel=1e-4)


@pytest.mark.parametrize("body", ["outer_ring", "inner_ring", "roller"])
def test_a_shallow_spall_has_a_flat_bottom(body):
    found = spalled(body, depth=5e-6)
    x = MIDDLE + np.linspace(-0.1e-3, 0.1e-3, 9) / {"outer_ring": 0.028, "inner_ring": 0.018, "roller": 0.005}[body]
    values = inner(found, x) if body == "inner_ring" else outer(found, x)
    np.testing.assert_allclose(values, 5e-6, atol=1e-9)


def test_entry_is_the_arc_of_a_roller_turning_about_the_edge():
    """On a sharp edge the centre goes round the edge in a circle of radius r: x²/2 (1/r − 1/R) below its path."""
    found = spalled("outer_ring", edge_radius=0.0)
    beyond = np.array([0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3])
    expected = 0.5 * beyond**2 * (1.0 / 0.005 - 1.0 / 0.028)
    for side in (-1.0, 1.0):
        angle = MIDDLE + side * (0.5e-3 - beyond) / 0.028
        np.testing.assert_allclose(outer(found, angle), expected, rtol=0.01, atol=0.02e-6)


def test_brute_force_never_gets_deeper_nor_stops_short():
    """Rollers put into the bare profile at random: the circle touches it and cuts it nowhere."""
    found, r, R = spalled("outer_ring", depth=15e-6), 0.005, 0.028
    spall = Spall(body="outer_ring", roller=None, angle=0.0, width=1e-3, depth=15e-6, edge_radius=0.1e-3)
    half = spall.half_opening(r)
    rng = np.random.default_rng(1)
    x = np.linspace(-2e-3, 2e-3, 400_001)
    into = np.clip(half - np.abs(x), 0.0, 0.1e-3)
    bare = np.minimum(0.1e-3 - np.sqrt(0.1e-3**2 - into**2), 15e-6)  # the depth below the raceway
    px, py = (R + bare) * np.sin(x / R), (R + bare) * np.cos(x / R)
    for at in rng.uniform(-0.6e-3, 0.6e-3, 12) / R:
        rho = R - r + outer(found, MIDDLE + at)[0]
        gap = np.hypot(px - rho * np.sin(at), py - rho * np.cos(at)).min() - r
        assert abs(gap) < 0.05e-6


def test_a_spall_on_one_roller_leaves_the_others_alone():
    found = spalled("roller")
    assert outer(found, MIDDLE, roller=3) > 20e-6
    assert outer(found, MIDDLE, roller=4) == 0.0


def test_waves_and_sizes_add_up():
    """At every contact a larger roller takes half of its diameter's deviation."""
    faults = (
        Waviness(body="inner_ring", roller=None, order=12, amplitude=0.5e-6, phase=0.4),
        Waviness(body="inner_ring", roller=None, order=7, amplitude=0.2e-6, phase=0.0),
        Waviness(body="roller", roller=2, order=2, amplitude=0.3e-6, phase=0.0),
        UnequalRoller(roller=2, diameter_deviation=1e-6),
    )
    surfaces, angle = profiles(replace(PAPER, faults=faults)), np.linspace(-4.0, 4.0, 57)
    ring = -0.5e-6 * np.cos(12 * angle + 0.4) - 0.2e-6 * np.cos(7 * angle)
    np.testing.assert_allclose(inner(surfaces, angle, roller=1), ring, atol=1e-12)
    on_roller = -0.5e-6 - 0.3e-6 * np.cos(2 * angle)
    np.testing.assert_allclose(inner(surfaces, angle, roller=2), ring + on_roller, atol=1e-12)
    np.testing.assert_allclose(outer(surfaces, angle, roller=2), on_roller, atol=1e-12)


def test_profiles_turn_with_their_bodies():
    faults = (
        Waviness(body="inner_ring", roller=None, order=3, amplitude=1e-6, phase=0.0),
        Waviness(body="roller", roller=0, order=2, amplitude=1e-6, phase=0.0),
    )
    surfaces, direction = profiles(replace(PAPER, faults=faults)), np.full(13, 0.7)
    found = surfaces.inner(direction, Turns(inner_ring=0.2, rollers=-0.5)).sinkage
    assert found[1] == pytest.approx(-1e-6 * np.cos(3 * 0.5), abs=1e-12)
    assert found[0] - found[1] == pytest.approx(-1e-6 * np.cos(2 * 1.2), abs=1e-12)


def test_slopes_are_derivatives():
    """Of the stored function itself, so that forces are the gradient of a potential; against central differences."""
    faults = (
        Spall(body="inner_ring", roller=None, angle=0.1, width=1e-3, depth=1e-4, edge_radius=0.1e-3),
        Spall(body="roller", roller=0, angle=3.3, width=0.5e-3, depth=1e-4, edge_radius=0.0),
    )
    surfaces, step = profiles(replace(PAPER, faults=faults)), 2e-7
    for angle in np.linspace(0.06, 0.2, 301):
        direction = np.full(13, angle)
        before, here, after = (surfaces.inner(direction + s, Turns()) for s in (-step, 0.0, step))
        difference = (after.sinkage - before.sinkage) / (2.0 * step)
        # a central difference errs by step times the curvature's jump at a knot
        np.testing.assert_allclose(here.slope, difference, atol=1e-5 * 2e-3)


def test_perfect_bearings_have_no_profiles():
    assert profiles(PAPER) is None


@pytest.mark.parametrize(
    ("body", "curvature"), [("outer_ring", 1.0 / 0.005 - 1.0 / 0.028), ("inner_ring", 1.0 / 0.005 + 1.0 / 0.018)]
)
@pytest.mark.parametrize("depth", [1e-4, 20e-6, 5e-6, 1e-6])
def test_a_roller_meets_the_rising_edge_where_its_bottom_lets_it(depth, body, curvature):
    """From entry on, at max(½, 1 − x/L) of the width L, x = √(2d/(1/r ∓ 1/R)) of a flat bottom of depth d."""
    found, width = spalled(body, depth=depth, edge_radius=0.0), 1e-3
    radius, at = (0.028, outer) if body == "outer_ring" else (0.018, inner)
    places = np.linspace(-0.5, 0.5, 2001)
    sunk = at(found, MIDDLE + places * width / radius)
    expected = max(0.5, 1.0 - np.sqrt(2.0 * depth / curvature) / width)
    comes_up = 0.5 + places[sunk > sunk.max() - 1e-8][-1]  # by 10 nm, on the edge's arc a hundredth of the width later
    assert comes_up == pytest.approx(expected, abs=0.02)
