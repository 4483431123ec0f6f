"""Equations of motion against Lagrange's equations derived by computer algebra."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws
from lagrange.motion import (
    State,
    accelerations,
    angular_equations,
    contact_energy,
    contact_state,
    hub_equations,
    kinetic_energy,
    radial_equations,
    rotation_energy,
)
from lagrange.scene.scene import Scene
from tests.reference.ideal import DGBB_209
from tests.reference.lagrange_equations import derived_equations

N = 3
BEARING = replace(Scene().ideal_bearing(), n_rollers=N)
OPERATION = Scene().ideal_operation()
ROUND_OFF = 1e-12  # of the contact forces and inertia terms in an equation


def laws(exponent):
    """Different inner and outer, with the size of real ones."""
    real = contact_laws("harris", BEARING).inner
    at_1_um = real.force(1e-6)
    return ContactLaws(
        *(
            PowerLaw(name="test", stiffness=k * at_1_um / 1e-6**exponent, exponent=exponent, source="")
            for k in (1.0, 1.3)
        )
    )


def random_state(rng, shape=()):
    """Approaches of ± some 0.1 mm: open and closed contacts."""
    wide = (*shape, N)
    return State(
        x=rng.uniform(-1e-4, 1e-4, shape), y=rng.uniform(-1e-4, 1e-4, shape),
        rho=BEARING.pitch_radius + rng.uniform(-2e-4, 2e-4, wide), theta=rng.uniform(-np.pi, np.pi, wide),
        x_rate=rng.uniform(-1.0, 1.0, shape), y_rate=rng.uniform(-1.0, 1.0, shape),
        rho_rate=rng.uniform(-1.0, 1.0, wide), theta_rate=rng.uniform(-400.0, 400.0, wide),
    )  # fmt: skip


def parameters(pair, damping):
    b, o = BEARING, OPERATION
    radii = b.inner_raceway_radius, b.outer_raceway_radius, b.roller_radius
    return (b.roller_mass, o.inner_mass, o.gravity, o.radial_load, *radii, pair.inner.stiffness, pair.outer.stiffness,
            damping)  # fmt: skip


@pytest.mark.parametrize("damping", [0.0, 20.0], ids=["undamped", "damped"])
@pytest.mark.parametrize("exponent", [sp.Rational(10, 9), sp.Rational(3, 2)], ids=["rollers", "balls"])
def test_equations_are_those_that_computer_algebra_derives(exponent, damping):
    derive = derived_equations(N, exponent)
    # the float nearest 10/9 isn't 10/9: 3e-17·ln δ off, below round-off
    pair = laws(float(exponent))
    rng = np.random.default_rng(7)
    worst, closed = 0.0, 0
    for _ in range(100):
        state = random_state(rng)
        ax, ay = rng.uniform(-1e5, 1e5, 2)
        rho_acc, theta_acc = rng.uniform(-1e5, 1e5, N), rng.uniform(-1e6, 1e6, N)
        expected = np.array(
            derive(
                parameters(pair, damping),
                [state.x, state.y, *state.rho, *state.theta],
                [state.x_rate, state.y_rate, *state.rho_rate, *state.theta_rate],
                [ax, ay, *rho_acc, *theta_acc],
            )
        )
        touch = contact_state(BEARING, pair, state, ContactDamping(constant=damping))
        assert np.all((touch.inner_force > 0.0) == (touch.inner > 0.0))  # no damper pulled: D knows no such limit
        found = np.concatenate([
            hub_equations(OPERATION, state, touch, ax, ay),
            radial_equations(BEARING, OPERATION, state, touch, rho_acc),
            angular_equations(BEARING, OPERATION, state, touch, theta_acc),
        ])  # fmt: skip
        forces = touch.inner_force + touch.outer_force + BEARING.roller_mass * np.abs(rho_acc)
        total = np.sum(forces) + OPERATION.inner_mass * abs(ax) + OPERATION.radial_load
        scale = np.concatenate([[total, total], forces, state.rho * forces])
        worst = max(worst, np.max(np.abs(found - expected) / scale))
        closed += np.sum(touch.inner > 0) + np.sum(touch.outer > 0)
    assert worst < ROUND_OFF
    assert 150 < closed < 450  # of 600: open and closed contacts are both met


def test_accelerations_fulfil_all_equations():
    state = random_state(np.random.default_rng(8), (20,))
    touch = contact_state(BEARING, laws(10 / 9), state)
    ax, ay, rho_acc, theta_acc = accelerations(BEARING, OPERATION, state, touch)
    force = np.max(touch.inner_force)
    assert np.max(np.abs(hub_equations(OPERATION, state, touch, ax, ay))) < 1e-12 * force
    assert np.max(np.abs(radial_equations(BEARING, OPERATION, state, touch, rho_acc))) < 1e-12 * force
    assert np.max(np.abs(angular_equations(BEARING, OPERATION, state, touch, theta_acc))) < 1e-13 * force


@pytest.mark.parametrize(("exponent", "excess"), [(10 / 9, 1 / 18), (1.5, 0.25)])
def test_printed_form_makes_the_radial_force_too_large(exponent, excess):
    """The paper prints (21) with V = Σ ½ k δ² of the secant stiffness k = Q/δ: a force of ½ (Q + δ dQ/dδ)."""
    pair = laws(exponent)
    approach = np.random.default_rng(9).uniform(0.0, 2e-5, 20)
    for law in pair:
        printed = 0.5 * (law.force(approach) + approach * law.slope(approach))
        np.testing.assert_allclose(printed - law.force(approach), excess * law.force(approach), rtol=1e-9, atol=1e-9)


def test_damped_contacts_lose_power_and_never_pull():
    rng = np.random.default_rng(10)
    pair, state = laws(1.5), random_state(rng, (500,))
    plain = contact_state(BEARING, pair, state)
    touch = contact_state(BEARING, pair, state, damping=ContactDamping(constant=500.0))
    assert np.all(touch.inner_force >= 0.0) and np.all(touch.outer_force >= 0.0)
    assert np.all(touch.inner_force[plain.inner <= 0.0] == 0.0)
    # rates of the approaches by moving the state a little
    step = 1e-9
    moved = replace(
        state, x=state.x + step * state.x_rate, y=state.y + step * state.y_rate, rho=state.rho + step * state.rho_rate,
        theta=state.theta + step * state.theta_rate,
    )  # fmt: skip
    later = contact_state(BEARING, pair, moved)
    for side in ("inner", "outer"):
        rate = (getattr(later, side) - getattr(plain, side)) / step
        extra = getattr(touch, f"{side}_force") - getattr(plain, f"{side}_force")
        assert np.all(extra * rate >= -1e-3 * np.abs(extra))
        free = (getattr(touch, f"{side}_force") > 0.0) & (np.abs(rate) > 0.1)
        np.testing.assert_allclose(extra[free], 500.0 * rate[free], rtol=1e-3)


@pytest.mark.parametrize(("bearing", "share"), [(BEARING, 1 / 2), (DGBB_209, 2 / 5)], ids=["rollers", "balls"])
def test_rotation_energy_done_by_hand(bearing, share):
    operation = replace(OPERATION, speed=100.0, inner_mass=bearing.inner_ring_mass + 0.02)
    a, b, r = bearing.bore_radius, bearing.inner_raceway_radius, bearing.roller_radius
    spin = 50.0 * b / r  # about its own axis, in the fixed frame
    elements = bearing.n_rollers * share * bearing.roller_mass * r**2 * spin**2 / 2
    shaft = (bearing.inner_ring_mass * (a**2 + b**2) / 2 + 0.02 * a**2 / 2) * 100.0**2 / 2
    assert rotation_energy(bearing, operation) == pytest.approx(elements + shaft, rel=1e-12)


def test_energies_of_a_state_done_by_hand():
    pair = laws(10 / 9)
    depth = 2e-6
    zero = np.zeros(N)
    state = State(
        x=0.0, y=0.0, rho=zero + BEARING.outer_raceway_radius - BEARING.roller_radius + depth,
        theta=np.array([0.0, np.pi / 2, np.pi]),
        x_rate=3.0, y_rate=4.0, rho_rate=zero + 1.0, theta_rate=zero + 100.0,
    )  # fmt: skip
    touch = contact_state(BEARING, pair, state)
    m, M = BEARING.roller_mass, OPERATION.inner_mass
    rho = state.rho[0]
    expected = 12.5 * M + 1.5 * m * (1.0 + (100.0 * rho) ** 2)
    assert kinetic_energy(BEARING, OPERATION, state) == pytest.approx(expected, rel=1e-14)
    stored = 3 * pair.outer.stiffness * depth ** (19 / 9) * 9 / 19
    assert contact_energy(pair, touch) == pytest.approx(stored, rel=1e-10)
