"""Equations of motion against Lagrange's equations derived by computer algebra; statics against independent ones."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import sympy as sp

from lagrange import motion
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws
from lagrange.statics import static_equilibrium
from tests.reference.continua import SJOVALL, stribeck_number
from tests.reference.forward_motion import derived_equations
from tests.reference.kit import DGBB_209, DOWN, HARRIS, PAPER, RUNNING

N = 3
BEARING = replace(PAPER, n_rollers=N)
STANDING = replace(RUNNING, speed=0.0, gravity=0.0)
ROUND_OFF = 1e-12  # of the contact forces and inertia terms in an equation


def power_law(stiffness, exponent):
    return PowerLaw(name="test", stiffness=stiffness, exponent=exponent, source="")


def laws(exponent):
    at_1_um = HARRIS.inner.force(1e-6)
    return ContactLaws(*(power_law(k * at_1_um / 1e-6**exponent, exponent) for k in (1.0, 1.3)))


def random_state(rng, shape=()):
    wide = (*shape, N)
    return motion.State(x=rng.uniform(-1e-4, 1e-4, shape), y=rng.uniform(-1e-4, 1e-4, shape),
        rho=BEARING.pitch_radius + rng.uniform(-2e-4, 2e-4, wide), theta=rng.uniform(-np.pi, np.pi, wide),
        x_rate=rng.uniform(-1.0, 1.0, shape), y_rate=rng.uniform(-1.0, 1.0, shape),
        rho_rate=rng.uniform(-1.0, 1.0, wide), theta_rate=rng.uniform(-400.0, 400.0, wide))  # fmt: skip


def left_sides(pair, state, ax, ay, rho_acc, theta_acc, damping=0.0):
    touch = motion.contact_state(BEARING, pair, state, ContactDamping(constant=damping))
    hub, of = motion.hub_equations(RUNNING, state, touch, ax, ay), (BEARING, RUNNING, state, touch)
    return touch, [*hub, motion.radial_equations(*of, rho_acc), motion.angular_equations(*of, theta_acc)]


@pytest.mark.parametrize("damping", [0.0, 20.0], ids=["undamped", "damped"])
@pytest.mark.parametrize("exponent", [sp.Rational(10, 9), sp.Rational(3, 2)], ids=["rollers", "balls"])
def test_equations_are_those_that_computer_algebra_derives(exponent, damping):
    derive = derived_equations(N, exponent)
    # the float nearest 10/9 isn't 10/9: 3e-17·ln δ off, below round-off
    pair, rng, b, o = laws(float(exponent)), np.random.default_rng(7), BEARING, RUNNING
    radii, stiffnesses = (b.inner_raceway_radius, b.outer_raceway_radius, b.roller_radius), [k.stiffness for k in pair]
    parameters = b.roller_mass, o.inner_mass, o.gravity, o.radial_load, *radii, *stiffnesses, damping
    worst, closed = 0.0, 0
    for _ in range(100):
        state = random_state(rng)
        acc = [*rng.uniform(-1e5, 1e5, 2), rng.uniform(-1e5, 1e5, N), rng.uniform(-1e6, 1e6, N)]
        places = [state.x, state.y, *state.rho, *state.theta]
        rates = [state.x_rate, state.y_rate, *state.rho_rate, *state.theta_rate]
        expected = np.array(derive(parameters, places, rates, np.hstack(acc)))
        touch, found = left_sides(pair, state, *acc, damping)
        assert np.all((touch.inner_force > 0.0) == (touch.inner > 0.0))  # no damper pulled: D knows no such limit
        forces = touch.inner_force + touch.outer_force + b.roller_mass * np.abs(acc[2])
        total = np.sum(forces) + o.inner_mass * abs(acc[0]) + o.radial_load
        scale = np.hstack([total, total, forces, state.rho * forces])
        worst = max(worst, np.max(np.abs(np.hstack(found) - expected) / scale))
        closed += np.sum(touch.inner > 0) + np.sum(touch.outer > 0)
    assert worst < ROUND_OFF
    assert 150 < closed < 450  # of 600: open and closed contacts are both met


def test_accelerations_fulfil_all_equations():
    state = random_state(np.random.default_rng(8), (20,))
    touch = motion.contact_state(BEARING, laws(10 / 9), state)
    _, left = left_sides(laws(10 / 9), state, *motion.accelerations(BEARING, RUNNING, state, touch))
    for found, allowed in zip(left, (1e-12, 1e-12, 1e-12, 1e-13), strict=True):
        assert np.max(np.abs(found)) < allowed * np.max(touch.inner_force)


def test_damped_contacts_lose_power_and_never_pull():
    pair, state, step = laws(1.5), random_state(np.random.default_rng(10), (500,)), 1e-9
    plain = motion.contact_state(BEARING, pair, state)
    touch = motion.contact_state(BEARING, pair, state, damping=ContactDamping(constant=500.0))
    assert np.all(touch.inner_force[plain.inner <= 0.0] == 0.0)
    # rates of the approaches by moving the state a little
    moves = {name: getattr(state, name) + step * getattr(state, f"{name}_rate") for name in ("x", "y", "rho", "theta")}
    later = motion.contact_state(BEARING, pair, replace(state, **moves))
    for side in ("inner", "outer"):
        rate, force = (getattr(later, side) - getattr(plain, side)) / step, getattr(touch, f"{side}_force")
        extra, free = force - getattr(plain, f"{side}_force"), (force > 0.0) & (np.abs(rate) > 0.1)
        assert np.all(force >= 0.0) and np.all(extra * rate >= -1e-3 * np.abs(extra))
        np.testing.assert_allclose(extra[free], 500.0 * rate[free], rtol=1e-3)


@pytest.mark.parametrize(("bearing", "share"), [(BEARING, 1 / 2), (DGBB_209, 2 / 5)], ids=["rollers", "balls"])
def test_rotation_energy_done_by_hand(bearing, share):
    operation = replace(RUNNING, speed=100.0, inner_mass=bearing.inner_ring_mass + 0.02)
    a, b, r = bearing.bore_radius, bearing.inner_raceway_radius, bearing.roller_radius
    spin = 50.0 * b / r  # about its own axis, in the fixed frame
    elements = bearing.n_rollers * share * bearing.roller_mass * r**2 * spin**2 / 2
    shaft = (bearing.inner_ring_mass * (a**2 + b**2) / 2 + 0.02 * a**2 / 2) * 100.0**2 / 2
    assert motion.rotation_energy(bearing, operation) == pytest.approx(elements + shaft, rel=1e-12)


def test_energies_of_a_state_done_by_hand():
    pair, depth, zero = laws(10 / 9), 2e-6, np.zeros(N)
    rho = BEARING.outer_raceway_radius - BEARING.roller_radius + depth
    state = motion.State(x=0.0, y=0.0, rho=zero + rho, theta=np.array([0.0, np.pi / 2, np.pi]), x_rate=3.0, y_rate=4.0,
                  rho_rate=zero + 1.0, theta_rate=zero + 100.0)  # fmt: skip
    expected = 12.5 * RUNNING.inner_mass + 1.5 * BEARING.roller_mass * (1.0 + (100.0 * rho) ** 2)
    assert motion.kinetic_energy(BEARING, RUNNING, state) == pytest.approx(expected, rel=1e-14)
    stored = 3 * pair.outer.stiffness * depth ** (19 / 9) * 9 / 19
    assert motion.contact_state(BEARING, pair, state).energy.sum() == pytest.approx(stored, rel=1e-10)


# Statics against independent solutions and the literature's load distribution.


def unbalance(bearing, operation, laws, found, cage):
    """Largest left side of (21)-(23) at rest in the turning frame, N."""
    zero = np.zeros(bearing.n_rollers)
    state = motion.State(x=found.x, y=found.y, rho=found.rho, theta=found.theta, x_rate=0.0, y_rate=0.0, rho_rate=zero,
                  theta_rate=zero + cage)  # fmt: skip
    touch = motion.contact_state(bearing, laws, state)
    radial = motion.radial_equations(bearing, operation, state, touch, zero)
    return np.abs(np.hstack([*motion.hub_equations(operation, state, touch, 0.0, 0.0), radial])).max()


@pytest.mark.parametrize(("first_angle", "loads", "approach"), [
    (DOWN, [629.7, 550.1, 550.1, 335.9, 335.9, 60.0, 60.0], 4.115),
    (DOWN + np.pi / 13, [607.0, 607.0, 454.6, 454.6, 198.2, 198.2], 4.10),
])  # fmt: skip
def test_papers_bearing_with_harris_law(first_angle, loads, approach):
    """Rigid rings, massless rollers; the loads come from an independent solution."""
    found = static_equilibrium(PAPER, replace(STANDING, first_roller_angle=first_angle), HARRIS, roller_mass=0.0)
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][: len(loads)], loads, atol=0.15)
    assert np.sum(found.inner_force > 0.0) == len(loads)
    assert -1e6 * found.y == pytest.approx(approach, abs=0.001 if approach == 4.115 else 0.01)
    np.testing.assert_allclose(found.inner_force, found.outer_force, atol=1e-6)


@pytest.mark.parametrize(
    ("bearing", "name", "printed"), [(PAPER, "harris", 4.08), (DGBB_209, "hertz", 4.37)], ids=["line", "point"]
)
def test_stribeck_number_of_many_elements_without_clearance(bearing, name, printed):
    track = bearing.inner_raceway_radius + 2.0 * bearing.roller_radius
    many = replace(bearing, n_rollers=200, outer_raceway_radius=track)
    laws = contact_laws(name, many)
    found = static_equilibrium(many, STANDING, laws, roller_mass=0.0)
    number = 200 * found.inner_force.max() / STANDING.radial_load
    assert number == pytest.approx(printed, abs=0.008)
    assert number == pytest.approx(stribeck_number(laws.inner.exponent), rel=1e-4)


@pytest.mark.parametrize("epsilon", SJOVALL)
@pytest.mark.parametrize(("exponent", "column"), [(1.5, 0), (1.1, 1)], ids=["point", "line"])
def test_load_distribution_with_clearance_or_preload(epsilon, exponent, column):
    """J_r = F/(Z Q_max) at ε = ½ (1 − clearance/deflection): the load is sought that gives ε."""
    deflection, n = 10e-6, 180
    clearance = deflection * (1.0 - 2.0 * epsilon)
    track = PAPER.inner_raceway_radius + 2.0 * PAPER.roller_radius + clearance
    bearing = replace(PAPER, n_rollers=n, outer_raceway_radius=track)
    law, cosine = power_law(600.0 / 2e-6**exponent, exponent), np.cos(2.0 * np.pi * np.arange(n) / n)
    load = np.sum(law.force(np.maximum(deflection * cosine - clearance, 0.0) / 2.0) * cosine)
    found = static_equilibrium(bearing, replace(STANDING, radial_load=load), ContactLaws(law, law), roller_mass=0.0)
    assert -found.y == pytest.approx(deflection, rel=2e-3)
    assert load / (n * found.inner_force.max()) == pytest.approx(SJOVALL[epsilon][column], abs=3e-4)


def test_ball_loads_are_those_of_springs_in_series():
    """209 deep-groove bearing, 15 µm diametral clearance, 8900 N: 4536 N on the lowest ball.

    Source: Harris, Rolling Bearing Analysis, example of the 209 bearing, second hand.
    """
    laws = contact_laws("hertz", DGBB_209)
    found = static_equilibrium(DGBB_209, replace(STANDING, radial_load=8900.0), laws, roller_mass=0.0)
    assert found.inner_force.max() == pytest.approx(4536.0, rel=2e-3) and np.sum(found.inner_force > 0.0) == 5
    # the same by hand, along the fixed directions of the balls, which turn by up to 60 µm/32 mm
    series, cosines = sum(law.stiffness ** (-2 / 3) for law in laws) ** -1.5, np.cos(found.theta - DOWN)
    force = series * np.maximum(-found.y * cosines - DGBB_209.radial_clearance, 0.0) ** 1.5
    np.testing.assert_allclose(found.inner_force, force, atol=3.0)
    assert np.sum(force * cosines) == pytest.approx(8900.0, rel=2e-3)


@pytest.mark.parametrize("name", ["harris", "johnson"])
def test_running_bearing_fulfils_the_equations_of_motion(name):
    laws = contact_laws(name, PAPER)
    found = static_equilibrium(PAPER, RUNNING, laws)
    assert unbalance(PAPER, RUNNING, laws, found, 0.5 * RUNNING.speed * 18.0 / 23.0) < 1e-5
    assert PAPER.roller_mass == pytest.approx(0.006, rel=0.03)  # the paper's: 4.69 N
    # centrifugal force, more or less the weight
    np.testing.assert_allclose(found.outer_force[found.inner_force == 0.0], 4.78, atol=0.08)


def test_any_clearance_preload_and_load_has_an_equilibrium():
    for clearance, load, speed, angle in product(
        [-2e-5, 0.0, 1e-6, 1e-4], [0.0, 1e-3, 50.0, 20000.0], [0.0, RUNNING.speed], [DOWN, 0.3]
    ):
        bearing = replace(PAPER, outer_raceway_radius=PAPER.outer_raceway_radius + clearance)
        operation = replace(RUNNING, radial_load=load, speed=speed, first_roller_angle=angle)
        found = static_equilibrium(bearing, operation, HARRIS)
        worst = unbalance(bearing, operation, HARRIS, found, 0.5 * speed * 0.018 / bearing.pitch_radius)
        assert worst < 1e-6 + 1e-9 * (load + np.sum(found.inner_force)), (clearance, load, speed, angle)


def test_without_load_a_clearance_stays_put_and_a_preload_squeezes_all_rollers():
    unloaded, loose = replace(STANDING, radial_load=0.0), replace(PAPER, outer_raceway_radius=0.02801)
    found = static_equilibrium(loose, unloaded, HARRIS, roller_mass=0.0, start=(1e-6, 2e-6))
    assert (found.x, found.y) == (1e-6, 2e-6) and not found.inner_force.any()
    still = static_equilibrium(loose, replace(RUNNING, radial_load=0.0, gravity=0.0), HARRIS)
    assert np.hypot(still.x, still.y) < 1e-20 and np.all(still.outer_force > 1.0)  # rollers go out and push it nowhere
    tight = replace(PAPER, outer_raceway_radius=0.02798)
    assert np.all(static_equilibrium(tight, STANDING, HARRIS, roller_mass=0.0).inner_force > 0.0)
    squeezed = static_equilibrium(tight, unloaded, HARRIS, roller_mass=0.0)
    np.testing.assert_allclose(squeezed.inner_force, HARRIS.inner.force(1e-5), rtol=1e-9)
