"""What rollers meet on imperfect surfaces: depths, soft edges, waves that move the hub."""

from dataclasses import replace
from functools import partial
from math import log

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.statics.contact_balance import Loads, balance, first_guess
from fem.statics.exact_statics import exact_contacts
from lagrange import contact_laws, static_equilibrium
from lagrange.axial.table import in_series
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import ContactLaws, PowerLaw
from lagrange.kinematics import kinematics, roller_angles
from lagrange.motion import State, accelerations, contact_state
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.edges import Circles, softening
from lagrange.surface.faults import Spall, UnequalRoller, Waviness
from tests.reference.continua import EdgeContact
from tests.reference.kit import DOWN, HARRIS, PAPER, RUNNING, spall, wavy

# What a roller reaches of imperfect surfaces: depths known in closed form, slopes, periodicity.

MIDDLE = 0.3  # rad
# of the relative curvature of a roller in the raceways, 1/m
CURVATURES = {"outer_ring": 1.0 / 0.005 - 1.0 / 0.028, "inner_ring": 1.0 / 0.005 + 1.0 / 0.018}


def of_faults(*faults):
    return profiles(replace(PAPER, faults=faults))


def spalled(body, **changes):
    spall = dict(body=body, roller=3 if body == "roller" else None, angle=MIDDLE, width=1e-3, depth=1e-3,
                 edge_radius=0.1e-3)  # fmt: skip
    return of_faults(Spall(**(spall | changes)))


def wave(body, order, amplitude=1e-6, phase=0.0, roller=None):
    return Waviness(body=body, roller=roller, order=order, amplitude=amplitude, phase=phase)


def sinkage(raceway, surfaces, angle, roller=3):
    return np.array([getattr(surfaces, raceway)(np.full(13, a), Turns()).sinkage[roller] for a in np.atleast_1d(angle)])


inner, outer = partial(sinkage, "inner"), partial(sinkage, "outer")


@pytest.mark.parametrize("edge_radius", [pytest.param(0.0, marks=pytest.mark.slow), 0.1e-3])
@pytest.mark.parametrize(("width", "outside", "inside"), [
    # h = [r − √(r² − L²/4)] ∓ [R − √(R² − L²/4)] of a 10 mm roller in raceways of 56 and 36 mm
    (0.3e-3, 1.849e-6, 2.876e-6), (0.5e-3, 5.138e-6, 7.990e-6), (1.0e-3, 20.60e-6, 32.01e-6),
    (2.0e-3, 83.16e-6, 128.8e-6),
])  # fmt: skip
def test_a_roller_sinks_between_the_edges_of_a_gap(width, outside, inside, edge_radius):
    on_outer, on_inner, on_roller = (spalled(body, width=width, edge_radius=edge_radius) for body in
                                     ("outer_ring", "inner_ring", "roller"))  # fmt: skip
    found = outer(on_outer, MIDDLE), inner(on_inner, MIDDLE), outer(on_roller, MIDDLE), inner(on_roller, MIDDLE - np.pi)
    wanted = np.array([outside, inside, outside, inside])
    assert np.ravel(found) == pytest.approx(wanted, rel=0.01, abs=0.05e-6)
    assert outer(on_roller, MIDDLE, roller=4) == 0.0, "the others are left alone"


@pytest.mark.parametrize(("body", "radius"), [("outer_ring", 0.028), ("inner_ring", 0.018), ("roller", 0.005)])
def test_a_shallow_spall_has_a_flat_bottom_and_a_deep_one_none_that_is_reached(body, radius):
    at, across = inner if body == "inner_ring" else outer, np.linspace(-0.1e-3, 0.1e-3, 9) / radius
    assert_allclose(at(spalled(body, depth=5e-6), MIDDLE + across), 5e-6, atol=1e-9)
    if body == "outer_ring":
        assert at(spalled(body, depth=25e-6), MIDDLE) == pytest.approx(at(spalled(body), MIDDLE), rel=1e-4)


def test_entry_is_the_arc_of_a_roller_turning_about_the_edge():
    """On a sharp edge the centre goes round the edge in a circle of radius r: x²/2 (1/r − 1/R) below its path."""
    found, beyond = spalled("outer_ring", edge_radius=0.0), np.array([0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3])
    for side in (-1.0, 1.0):
        angle = MIDDLE + side * (0.5e-3 - beyond) / 0.028
        assert_allclose(outer(found, angle), 0.5 * beyond**2 * CURVATURES["outer_ring"], rtol=0.01, atol=0.02e-6)


def test_brute_force_never_gets_deeper_nor_stops_short():
    found, r, R = spalled("outer_ring", depth=15e-6), 0.005, 0.028
    spall = Spall(body="outer_ring", roller=None, angle=0.0, width=1e-3, depth=15e-6, edge_radius=0.1e-3)
    x = np.linspace(-2e-3, 2e-3, 400_001)
    into = np.clip(spall.half_opening(r) - np.abs(x), 0.0, 0.1e-3)
    bare = np.minimum(0.1e-3 - np.sqrt(0.1e-3**2 - into**2), 15e-6)  # the depth below the raceway
    profile = (R + bare) * np.exp(1j * x / R)
    for at in np.random.default_rng(1).uniform(-0.6e-3, 0.6e-3, 12) / R:
        rho = R - r + outer(found, MIDDLE + at)[0]
        assert abs(np.abs(profile - rho * np.exp(1j * at)).min() - r) < 0.05e-6


def test_waves_and_sizes_add_up_and_profiles_turn_with_their_bodies():
    """At every contact a larger roller takes half of its diameter's deviation."""
    larger, angle = UnequalRoller(roller=2, diameter_deviation=1e-6), np.linspace(-4.0, 4.0, 57)
    on_ring = wave("inner_ring", 12, 0.5e-6, 0.4), wave("inner_ring", 7, 0.2e-6)
    surfaces = of_faults(*on_ring, wave("roller", 2, 0.3e-6, roller=2), larger)
    ring = -0.5e-6 * np.cos(12 * angle + 0.4) - 0.2e-6 * np.cos(7 * angle)
    on_roller = -0.5e-6 - 0.3e-6 * np.cos(2 * angle)
    assert_allclose(inner(surfaces, angle, roller=1), ring, atol=1e-12)
    assert_allclose(inner(surfaces, angle, roller=2), ring + on_roller, atol=1e-12)
    assert_allclose(outer(surfaces, angle, roller=2), on_roller, atol=1e-12)
    turning = of_faults(wave("inner_ring", 3), wave("roller", 2, roller=0))
    found = turning.inner(np.full(13, 0.7), Turns(inner_ring=0.2, rollers=-0.5)).sinkage
    assert found[1] == pytest.approx(-1e-6 * np.cos(3 * 0.5), abs=1e-12)
    assert found[0] - found[1] == pytest.approx(-1e-6 * np.cos(2 * 1.2), abs=1e-12)
    assert profiles(PAPER) is None, "perfect bearings have none"


def test_slopes_are_derivatives():
    """Of the stored function itself, so that forces are the gradient of a potential; against central differences."""
    surfaces, step = of_faults(
        Spall(body="inner_ring", roller=None, angle=0.1, width=1e-3, depth=1e-4, edge_radius=0.1e-3),
        Spall(body="roller", roller=0, angle=3.3, width=0.5e-3, depth=1e-4, edge_radius=0.0),
    ), 2e-7  # fmt: skip
    for angle in np.linspace(0.06, 0.2, 301):
        before, here, after = (surfaces.inner(np.full(13, angle) + s, Turns()) for s in (-step, 0.0, step))
        # a central difference errs by step times the curvature's jump at a knot
        assert_allclose(here.slope, (after.sinkage - before.sinkage) / (2.0 * step), atol=1e-5 * 2e-3)


@pytest.mark.parametrize("body", CURVATURES)
@pytest.mark.parametrize("depth", [1e-4, 20e-6, 5e-6, 1e-6])
def test_a_roller_meets_the_rising_edge_where_its_bottom_lets_it(depth, body):
    """From entry on, at max(½, 1 − x/L) of the width L, x = √(2d/(1/r ∓ 1/R)) of a flat bottom of depth d."""
    found, width = spalled(body, depth=depth, edge_radius=0.0), 1e-3
    radius, at = (0.028, outer) if body == "outer_ring" else (0.018, inner)
    places = np.linspace(-0.5, 0.5, 2001)
    sunk = at(found, MIDDLE + places * width / radius)
    expected = max(0.5, 1.0 - np.sqrt(2.0 * depth / CURVATURES[body]) / width)
    comes_up = 0.5 + places[sunk > sunk.max() - 1e-8][-1]  # by 10 nm, on the edge's arc a hundredth of the width later
    assert comes_up == pytest.approx(expected, abs=0.02)


# Contacts at the edges of spalls: softer than on the sound surface, in one potential with all else.


@pytest.mark.parametrize(("body", "kind"), [("inner_ring", 0), ("outer_ring", 1)])
def test_forces_at_edges_are_those_of_half_planes_which_are_hertz_contacts_far_from_them(body, kind):
    """Measured: within 3.1 %, where the sinkage alone is off by up to 46 %."""
    fault, pair, law = spall(body), contact_pairs(PAPER)[kind], contact_laws("johnson", PAPER)[kind]
    half = fault.half_opening(PAPER.roller_radius)
    reference = EdgeContact(radius=pair.radii[0], roller_radius=PAPER.roller_radius, compliance=pair.line_compliance,
        level=0.5 * law.level, half_opening=half, edge_radius=fault.edge_radius, beside=0.4e-3)  # fmt: skip
    for approach in (0.5e-6, 2e-6):
        force, pressure = reference.press(half + 0.15e-3, approach)
        assert force == pytest.approx(law.force(approach), rel=5e-4)
        assert pressure / PAPER.roller_length == pytest.approx(pair.peak_pressure(force), rel=3e-3)
    places = half + np.array([60e-6, 20e-6, 0.0, -20e-6, -60e-6, -150e-6, -0.3e-3])
    angle = np.repeat(np.arcsin(places / abs(pair.radii[0]))[:, None], 13, axis=1)
    met = getattr(of_faults(fault), ("inner", "outer")[kind])(angle, Turns())
    for place, sunk, soft in zip(places, met.sinkage[:, 0], met.compliance[:, 0], strict=True):
        for approach in (1e-6, 3e-6):
            exact, _ = reference.press(place, sunk + approach)
            assert in_series(law.at, approach, 0.0, soft).force == pytest.approx(exact, rel=0.04)
    assert law.force(2e-6) > 1.3 * reference.press(half - 0.3e-3, met.sinkage[-1, 0] + 2e-6)[0]


@pytest.mark.parametrize(("body", "own", "other", "meeting"), [
    ("outer_ring", 0.028, 0.005, "bore"), ("inner_ring", 0.018, 0.005, "outside"), ("roller", 0.005, 0.028, "in_bore"),
])  # fmt: skip
def test_an_edge_alone_has_its_own_curvature_and_a_shallow_bottom_that_of_the_raceway(body, own, other, meeting):
    """ΔB = ½ ln(ratio of the curvatures) where the contact lies on its edge, 0 beside the spall and in its middle."""
    circles = Circles(own, other, meeting, PAPER.roller_radius)
    found = softening(spall(body, width=2e-3), circles, np.array([0.0, 0.3e-3, 1.2e-3]) / own)
    with_other = 1e4 + (1.0 / other if meeting != "in_bore" else -1.0 / other)
    curvature = CURVATURES["inner_ring" if body == "inner_ring" else "outer_ring"]
    assert found[1] == pytest.approx(0.5 * log(with_other / curvature), abs=0.02)
    assert found[0] == found[2] == 0.0
    if body == "outer_ring":
        assert np.abs(softening(spall(body, depth=2e-6), circles, np.array([0.0, 0.1e-3]) / own)).max() < 0.01


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_a_law_in_series_with_a_compliance(law):
    plain, depth = contact_laws(law, PAPER).outer, np.array([-1e-6, 0.0, 1e-9, 1e-6, 5e-6])
    soft = partial(in_series, plain.at, slope=0.0, compliance=1e-9)
    found, closed = soft(depth), depth[2:]
    assert np.all(found.force[:2] == 0.0)
    assert_allclose(plain.approach(found.force[2:]) + 1e-9 * found.force[2:], closed, rtol=1e-13)
    more, less = soft(closed * 1.0001), soft(closed * 0.9999)
    for of, derivative in (("force", found.stiffness), ("energy", found.force)):
        change = (getattr(more, of) - getattr(less, of)) / (2e-4 * closed)
        assert_allclose(derivative[2:], change, rtol=1e-6)


def assert_gradient(faults, laws, start, turns):
    """Accelerations without loads, at hub, radii and angles of 13 rollers, by central differences of the energy."""
    bearing, operation, n = replace(PAPER, faults=faults), replace(RUNNING, gravity=0.0, radial_load=0.0), 13

    def at(values):
        rest = np.zeros(n)
        state = State(x=values[0], y=values[1], rho=values[2 : n + 2], theta=values[n + 2 :], x_rate=0.0, y_rate=0.0,
                      rho_rate=rest, theta_rate=rest, turns=turns)  # fmt: skip
        return state, contact_state(bearing, laws, state)

    state, contacts = at(start)
    ax, ay, rho, theta = accelerations(bearing, operation, state, contacts)
    forces = [operation.inner_mass * ax, operation.inner_mass * ay, *(bearing.roller_mass * rho)]
    moments = bearing.roller_mass * state.rho**2 * theta
    steps = np.diag([*np.full(n + 2, 1e-9), *np.full(n, 1e-8)])
    energy = [[at(start + sign * h)[1].energy.sum() for h in steps] for sign in (1.0, -1.0)]
    gradient = np.subtract(*energy) / (2.0 * steps.max(axis=1))
    assert_allclose(forces, -gradient[: n + 2], atol=2e-3, rtol=1e-4)
    assert_allclose(moments, -gradient[n + 2 :], atol=2e-5, rtol=1e-4)
    return contacts, moments


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_forces_at_edges_are_the_gradient_of_the_energy(law):
    """Rollers 20 µm and more beside the edge of a spall, on raceways and on a roller, by every coordinate."""
    faults = spall("outer_ring", DOWN), spall("inner_ring", DOWN + 0.4735), spall("roller", 0.3)
    start = np.concatenate([[1e-6, -4e-6], np.full(13, 0.023002), DOWN + 0.0175 + np.arange(13) * 2 * np.pi / 13])
    turns = Turns(inner_ring=0.0, rollers=DOWN + 0.0175 - 0.3 - 0.0895)
    contacts, _ = assert_gradient(faults, contact_laws(law, PAPER), start, turns)
    assert contacts.compliances[1][0] > 1e-10 and contacts.outer_force[0] > 100.0
    assert contacts.compliances[0][1] > 1e-10 and contacts.inner_force[1] > 50.0


def test_forces_on_slopes_of_all_four_surfaces_are_the_gradient_of_the_energy():
    places = 0.023 + np.random.default_rng(3).uniform(-1e-6, 1e-6, 13)
    start = np.concatenate([[1e-6, -12e-6], places, DOWN + 0.015 + np.arange(13) * 0.47])
    faults = *wavy(), spall("outer_ring", DOWN), spall("inner_ring", DOWN + 0.45)
    contacts, moments = assert_gradient(faults, HARRIS, start, Turns(inner_ring=-0.01, rollers=0.2))
    assert np.abs(contacts.outer_slope).max() > 0.01 and np.count_nonzero(moments) > 5


# Which waves move the hub: selection by the order and the number of rollers (Wardle 1988), under uniform preload.
# Statics at many places of the ring, which is the motion of low speed: the hub's path holds the lines of the spectrum.

PRELOADED = replace(PAPER, outer_raceway_radius=PAPER.outer_raceway_radius - 1e-6)
STANDING = replace(RUNNING, speed=0.0, gravity=0.0, radial_load=0.0)
LINEAR = ContactLaws(*(2 * [PowerLaw(name="linear", stiffness=3e8, exponent=1.0, source="")]))
IDEAL = kinematics(PAPER, 1.0)
A = 1e-8  # m, a fiftieth of the contacts' approach δ; slopes of order n have a part n δ/χ in what follows
TIMES = np.linspace(0.0, 40.0, 9)  # shaft angle, rad
BPFI = 13 * (IDEAL.shaft - IDEAL.cage)


def hub(fault, laws=LINEAR):
    """x + iy of the hub as the cage turns, and ring and rollers with it, rolling, (n_times,), m."""
    bearing, path, near = replace(PRELOADED, faults=(fault,)), [], (0.0, 0.0)
    for time in TIMES:
        turns = Turns.rolling(PAPER, replace(STANDING, speed=1.0), time)
        given = {"angles": roller_angles(bearing, 0.1) + IDEAL.cage * time, "turns": turns, "start": near}
        found = static_equilibrium(bearing, STANDING, laws, roller_mass=0.0, **given)
        near = found.x, found.y
        path.append(complex(*near))
    return np.array(path)


@pytest.mark.parametrize("law", ["linear", "harris"])
@pytest.mark.parametrize("order", [1, 2, 11, 12, 13, 14, 15, 25, 26, 27])
def test_orders_of_the_inner_ring_that_move_the_hub(order, law):
    """Those next to multiples of the number of rollers, by their amplitude (the rigid linear limit); no others."""
    laws = LINEAR if law == "linear" else contact_laws("harris", PRELOADED)
    moved = np.abs(hub(wave("inner_ring", order, A, 0.2), laws))
    if order % 13 in (1, 12):
        assert_allclose(moved, A, rtol=2e-3)
    else:  # a law that is not linear couples the order with itself
        assert moved.max() < (1e-6 if law == "linear" else 3e-3) * A


@pytest.mark.parametrize(("body", "order", "speed"), [
    # k BPFI ∓ f_shaft: 12 at BPFI − f_s backwards, 14 at BPFI + f_s forwards, with rad of the shaft as time
    ("inner_ring", 12, IDEAL.shaft - BPFI), ("inner_ring", 14, BPFI + IDEAL.shaft),
    # at BPFO: the rollers carry the wave over to the hub
    ("outer_ring", 12, 13 * IDEAL.cage), ("outer_ring", 14, -13 * IDEAL.cage),
    ("outer_ring", 11, None), ("outer_ring", 13, None),
])  # fmt: skip
def test_the_hub_circles_at_the_frequencies_of_the_orders(body, order, speed):
    path = hub(wave(body, order, A, 0.2))
    if speed is None:
        assert np.abs(path).max() < 1e-6 * A
        return
    turned = path * np.exp(-1j * speed * TIMES)
    assert_allclose(np.abs(path), A, rtol=2e-3)
    assert_allclose(turned, turned[0], atol=2e-3 * A)


@pytest.mark.parametrize("order", [12, 13, 14, 15])
def test_elastic_rings_obey_the_same_selection(order):
    """By symmetry, whatever the law and the rings' stiffness: exact series of elastic bodies."""
    bearing = replace(PRELOADED, faults=(wave("inner_ring", order, A, 0.2),))
    contacts = exact_contacts(bearing, roller_angles(bearing, 0.1))
    place, _ = balance(contacts, Loads(0.0), first_guess(bearing, contacts.radial, 0.0))
    moved = np.hypot(place[0], place[1])
    assert 0.5 * A < moved < 1.5 * A if order in (12, 14) else moved < 2e-3 * A


def test_a_wavy_roller_moves_the_hub_at_twice_its_spin_and_an_unequal_one_at_the_cage_frequency():
    """2 BSF ± FTF: 2nd order on one roller squeezes it twice a turn, in the direction that turns with the cage.

    2 Δd/Z in the linear rigid limit, 0.154 µm per µm (Yhland 1992), away from the unequal roller.
    """
    cage = IDEAL.cage * TIMES + 0.1
    along = hub(wave("roller", 2, A, 0.2, roller=0)) * np.exp(-1j * cage)
    assert np.abs(along.imag).max() < 1e-3 * A
    # both contacts of the roller give way at the same time, half of the rollers' stiffness around: 4 A/13
    assert_allclose(along.real, -4.0 / 13.0 * A * np.cos(2.0 * (cage - IDEAL.roller * TIMES) + 0.2), atol=2e-3 * A)
    path = hub(UnequalRoller(roller=4, diameter_deviation=A))
    assert_allclose(path, -2.0 / 13.0 * A * np.exp(1j * (cage + 2 * np.pi * 4 / 13)), atol=1e-3 * A)
