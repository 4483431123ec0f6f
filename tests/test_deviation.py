"""What rollers meet on imperfect surfaces: depths, soft edges, waves that move the hub."""

from dataclasses import replace
from functools import partial
from math import log

import numpy as np
import pytest

from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads, balance, first_guess
from fem.statics.exact_statics import exact_contacts
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import ContactLaws, PowerLaw
from lagrange.kinematics import kinematics, roller_angles
from lagrange.motion import State, accelerations, contact_energy, contact_state
from lagrange.scene.scene import Scene, read_scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.edges import Circles, Softened, softening
from lagrange.surface.faults import Spall, UnequalRoller, Waviness
from tests.reference.continua import EdgeContact

# What a roller reaches of imperfect surfaces: depths known in closed form, slopes, periodicity.

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


def sinkage(raceway, surfaces, angle, roller=3):
    return np.array([getattr(surfaces, raceway)(np.full(13, a), Turns()).sinkage[roller] for a in np.atleast_1d(angle)])


inner, outer = partial(sinkage, "inner"), partial(sinkage, "outer")


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


# Contacts at the edges of spalls: softer than on the sound surface, in one potential with all else.

LAWS = contact_laws("johnson", PAPER)
DOWN = -np.pi / 2


def deep(body, width=1e-3, depth=1e-4, edge_radius=1e-4):
    roller = 0 if body == "roller" else None
    return Spall(body=body, roller=roller, angle=0.0, width=width, depth=depth, edge_radius=edge_radius)


def yardstick(kind, spall):
    pair, law = contact_pairs(PAPER)[kind], LAWS[kind]
    half = spall.half_opening(PAPER.roller_radius)
    return EdgeContact(
        radius=pair.radii[0], roller_radius=PAPER.roller_radius, compliance=pair.line_compliance,
        level=0.5 * law.level, half_opening=half, edge_radius=spall.edge_radius, beside=0.4e-3,
    ), half, law  # fmt: skip


@pytest.mark.parametrize("kind", [0, 1])
def test_the_yardstick_is_hertz_contact_far_from_the_edge(kind):
    reference, half, law = yardstick(kind, deep("outer_ring"))
    for approach in (0.5e-6, 2e-6):
        force, pressure = reference.press(half + 0.15e-3, approach)
        assert force == pytest.approx(law.force(approach), rel=5e-4)
        assert pressure / PAPER.roller_length == pytest.approx(
            contact_pairs(PAPER)[kind].peak_pressure(force), rel=3e-3
        )


@pytest.mark.parametrize(
    ("body", "own", "other", "meeting", "curvature"),
    [("outer_ring", 0.028, 0.005, "bore", 1 / 0.005 - 1 / 0.028),
     ("inner_ring", 0.018, 0.005, "outside", 1 / 0.005 + 1 / 0.018),
     ("roller", 0.005, 0.028, "in_bore", 1 / 0.005 - 1 / 0.028)],
)  # fmt: skip
def test_an_edge_alone_has_its_own_curvature(body, own, other, meeting, curvature):
    """ΔB = ½ ln(ratio of the curvatures) where the contact lies on its edge, 0 beside the spall and in its middle."""
    spall = deep(body, width=2e-3)
    found = softening(spall, Circles(own, other, meeting, PAPER.roller_radius), np.array([0.0, 0.3e-3, 1.2e-3]) / own)
    with_other = 1e4 + (1.0 / other if meeting != "in_bore" else -1.0 / other)
    assert found[1] == pytest.approx(0.5 * log(with_other / curvature), abs=0.02)
    assert found[0] == found[2] == 0.0


@pytest.mark.parametrize(("body", "kind"), [("inner_ring", 0), ("outer_ring", 1)])
def test_forces_at_edges_are_those_of_half_planes(body, kind):
    """Measured: within 3.1 %, where the sinkage alone is off by up to 46 %."""
    spall = deep(body)
    reference, half, law = yardstick(kind, spall)
    places = half + np.array([60e-6, 20e-6, 0.0, -20e-6, -60e-6, -150e-6, -0.3e-3])
    angle = np.repeat(np.arcsin(places / abs(contact_pairs(PAPER)[kind].radii[0]))[:, None], 13, axis=1)
    met = getattr(profiles(replace(PAPER, faults=(spall,))), ("inner", "outer")[kind])(angle, Turns())
    for place, sinkage, soft in zip(places, met.sinkage[:, 0], met.compliance[:, 0], strict=True):
        for approach in (1e-6, 3e-6):
            exact, _ = reference.press(place, sinkage + approach)
            assert Softened(law=law, compliance=soft).force(approach) == pytest.approx(exact, rel=0.04)
    exact, _ = reference.press(half - 0.3e-3, met.sinkage[-1, 0] + 2e-6)
    assert law.force(2e-6) > 1.3 * exact


def test_a_shallow_spall_s_bottom_is_as_stiff_as_the_raceway():
    places = np.array([0.0, 0.1e-3]) / 0.028
    assert np.abs(softening(deep("outer_ring", depth=2e-6), Circles(0.028, 0.005, "bore", 0.005), places)).max() < 0.01


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_a_law_in_series_with_a_compliance(law):
    plain, depth = contact_laws(law, PAPER).outer, np.array([-1e-6, 0.0, 1e-9, 1e-6, 5e-6])
    soft = Softened(law=plain, compliance=1e-9)
    force = soft.force(depth)
    assert np.all(force[:2] == 0.0)
    np.testing.assert_allclose(soft.approach(force[2:]), depth[2:], rtol=1e-13)
    ahead, behind = soft.force(depth * 1.0001), soft.force(depth * 0.9999)
    np.testing.assert_allclose(soft.slope(depth[2:]), (ahead - behind)[2:] / (2e-4 * depth[2:]), rtol=1e-6)
    energy = soft.potential(depth * 1.0001) - soft.potential(depth * 0.9999)
    np.testing.assert_allclose(force[2:], energy[2:] / (2e-4 * depth[2:]), rtol=1e-6)


@pytest.mark.parametrize("law", ["harris", "johnson"])
def test_forces_at_edges_are_the_gradient_of_the_energy(law):
    """Rollers 20 µm and more beside the edge of a spall, on raceways and on a roller, by every coordinate."""
    faults = tuple(replace(deep(body), angle=angle) for body, angle in
                   (("outer_ring", DOWN), ("inner_ring", DOWN + 0.4735), ("roller", 0.3)))  # fmt: skip
    bearing, laws, n = replace(PAPER, faults=faults), contact_laws(law, PAPER), 13
    operation = replace(Scene().ideal_operation(), gravity=0.0, radial_load=0.0)
    track = PAPER.outer_raceway_radius - PAPER.roller_radius
    angle = DOWN + 0.0175 + np.arange(n) * 2 * np.pi / n
    start = np.concatenate([[1e-6, -4e-6], np.full(n, track + 2e-6), angle])
    turns = Turns(inner_ring=0.0, rollers=DOWN + 0.0175 - 0.3 - 0.0895)

    def state(values):
        rest = np.zeros(n)
        return State(x=values[0], y=values[1], rho=values[2 : n + 2], theta=values[n + 2 :], x_rate=0.0, y_rate=0.0,
                     rho_rate=rest, theta_rate=rest, turns=turns)  # fmt: skip

    def energy(values):
        return contact_energy(laws, contact_state(bearing, laws, state(values)))

    contacts = contact_state(bearing, laws, state(start))
    assert contacts.outer_compliance[0] > 1e-10 and contacts.outer_force[0] > 100.0
    assert contacts.inner_compliance[1] > 1e-10 and contacts.inner_force[1] > 50.0
    ax, ay, rho, theta = accelerations(bearing, operation, state(start), contacts)
    mass = bearing.roller_mass
    forces = np.concatenate([[operation.inner_mass * ax, operation.inner_mass * ay], mass * rho])
    moments = mass * start[2 : n + 2] ** 2 * theta
    steps = np.concatenate([np.full(n + 2, 1e-9), np.full(n, 1e-8)])
    gradient = np.array([
        (energy(start + h * unit) - energy(start - h * unit)) / (2.0 * h)
        for h, unit in zip(steps, np.eye(2 * n + 2), strict=True)
    ])  # fmt: skip
    np.testing.assert_allclose(forces, -gradient[: n + 2], atol=2e-3, rtol=1e-4)
    np.testing.assert_allclose(moments, -gradient[n + 2 :], atol=2e-5, rtol=1e-4)


@pytest.mark.parametrize(("body", "angle"), [("outer_ring", 3.0), ("inner_ring", -5.0)])
def test_energy_is_balanced_over_soft_edges_in_the_reduced_model(body, angle):
    """Both edges are crossed under load; measured 3e-5 at most."""
    settings = (
        'model="reduced"', f'spall.0.body="{body}"', f"spall.0.angle_deg={angle}", "spall.0.width_mm=0.4",
        "numerics.duration_ms=0.8", "numerics.output_interval_us=1",
    )  # fmt: skip
    plan = make_plan(read_scene(None, settings))
    block = plan.first_state().advance(plan.n_samples)
    assert block.trouble is None
    assert np.abs(block.samples.relative_error()).max() < 2e-4


# Which waves move the hub: selection by the order and the number of rollers (Wardle 1988), under uniform preload.
#
# Statics at many places of the ring, which is the motion of low speed: the hub's path holds the lines of the spectrum.

PRELOADED = replace(PAPER, outer_raceway_radius=PAPER.outer_raceway_radius - 1e-6)
STANDING = replace(Scene().ideal_operation(), speed=0.0, gravity=0.0, radial_load=0.0)
LINEAR = ContactLaws(*(2 * [PowerLaw(name="linear", stiffness=3e8, exponent=1.0, source="")]))
TURNING = replace(STANDING, speed=1.0)  # rad/s
IDEAL = kinematics(PAPER, 1.0)
A = 1e-8  # m, a fiftieth of the contacts' approach δ; slopes of order n have a part n δ/χ in what follows
TIMES = np.linspace(0.0, 40.0, 9)  # shaft angle, rad


def hub(faults, laws, cage):
    """x + iy of the hub as the cage turns, and ring and rollers with it, rolling, (n_times,), m."""
    bearing = replace(PRELOADED, faults=faults)
    path, near = [], (0.0, 0.0)
    for time in TIMES:
        angles = roller_angles(bearing, 0.1) + cage * time
        turns = Turns.rolling(PAPER, TURNING, time)
        found = static_equilibrium(bearing, STANDING, laws, angles=angles, roller_mass=0.0, start=near, turns=turns)
        near = found.x, found.y
        path.append(complex(*near))
    return np.array(path)


def wave(body, order, roller=None):
    return (Waviness(body=body, roller=roller, order=order, amplitude=A, phase=0.2),)


@pytest.mark.parametrize("law", ["linear", "harris"])
@pytest.mark.parametrize("order", [1, 2, 11, 12, 13, 14, 15, 25, 26, 27])
def test_orders_of_the_inner_ring_that_move_the_hub(order, law):
    """Those next to multiples of the number of rollers, by their amplitude (the rigid linear limit); no others."""
    laws = LINEAR if law == "linear" else contact_laws("harris", PRELOADED)
    moved = np.abs(hub(wave("inner_ring", order), laws, IDEAL.cage))
    if order % 13 in (1, 12):
        np.testing.assert_allclose(moved, A, rtol=2e-3)
    else:
        # a law that is not linear couples the order with itself
        assert moved.max() < (1e-6 if law == "linear" else 3e-3) * A


def test_the_hub_circles_at_the_frequencies_of_the_orders():
    """k BPFI ∓ f_shaft: 12 at BPFI − f_s backwards, 14 at BPFI + f_s forwards, with rad of the shaft as time."""
    bpfi = 13 * (IDEAL.shaft - IDEAL.cage)
    for order, speed in ((12, -(bpfi - IDEAL.shaft)), (14, bpfi + IDEAL.shaft)):
        path = hub(wave("inner_ring", order), LINEAR, IDEAL.cage)
        turned = path * np.exp(-1j * speed * TIMES)
        np.testing.assert_allclose(turned, turned[0], atol=2e-3 * A)


@pytest.mark.parametrize("order", [11, 12, 13, 14])
def test_orders_of_the_outer_ring(order):
    """At BPFO: the rollers carry the wave over to the hub."""
    path = hub(wave("outer_ring", order), LINEAR, IDEAL.cage)
    if order in (12, 14):
        speed = 13 * IDEAL.cage * (1.0 if order == 12 else -1.0)
        turned = path * np.exp(-1j * speed * TIMES)
        np.testing.assert_allclose(np.abs(path), A, rtol=2e-3)
        np.testing.assert_allclose(turned, turned[0], atol=2e-3 * A)
    else:
        assert np.abs(path).max() < 1e-6 * A


@pytest.mark.parametrize("order", [12, 13, 14, 15])
def test_elastic_rings_obey_the_same_selection(order):
    """By symmetry, whatever the law and the rings' stiffness: exact series of elastic bodies."""
    bearing = replace(PRELOADED, faults=wave("inner_ring", order))
    contacts = exact_contacts(bearing, roller_angles(bearing, 0.1))
    place, _ = balance(contacts, Loads(0.0), first_guess(bearing, contacts.radial, 0.0))
    moved = np.hypot(place[0], place[1])
    if order in (12, 14):
        assert 0.5 * A < moved < 1.5 * A
    else:
        assert moved < 2e-3 * A


def test_even_orders_of_a_roller_move_the_hub_at_twice_its_spin():
    """2 BSF ± FTF: 2nd order on one roller squeezes it twice a turn, in the direction that turns with the cage."""
    path = hub(wave("roller", 2, roller=0), LINEAR, IDEAL.cage)
    direction = np.exp(-1j * (IDEAL.cage * TIMES + 0.1))
    along = path * direction
    assert np.abs(along.imag).max() < 1e-3 * A
    # both contacts of the roller give way at the same time, half of the rollers' stiffness around: 4 A/13
    angle = IDEAL.cage * TIMES + 0.1 - IDEAL.roller * TIMES
    np.testing.assert_allclose(along.real, -4.0 / 13.0 * A * np.cos(2.0 * angle + 0.2), atol=2e-3 * A)


def test_an_unequal_roller_moves_the_hub_at_the_cage_frequency():
    """By 2 Δd/Z in the linear rigid limit, 0.154 µm per µm (Yhland 1992), away from the roller."""
    faults = (UnequalRoller(roller=4, diameter_deviation=A),)
    path = hub(faults, LINEAR, IDEAL.cage)
    direction = np.exp(1j * (0.1 + 2 * np.pi * 4 / 13 + IDEAL.cage * TIMES))
    np.testing.assert_allclose(path, -2.0 / 13.0 * A * direction, atol=1e-3 * A)
