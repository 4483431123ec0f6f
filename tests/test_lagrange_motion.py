"""Equations of motion against Lagrange's equations derived by computer algebra."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import fsolve

from lagrange.bearing import Operation
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws, steel_law
from lagrange.equations import approaches, contact_resultant, error_forces
from lagrange.kinematics import kinematics, roller_angles
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
from lagrange.scene.scene import Scene, parse_scene
from lagrange.statics import static_equilibrium
from tests.reference.continua import SJOVALL, stribeck_number
from tests.reference.forward_motion import derived_equations
from tests.reference.kit import DGBB_209

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


# Geometry (19), (26), (27) and equations (22), (23).


SCENE = parse_scene({"operation": {"gravity_m_s2": 0.0}}, "test")
BEARING_OF_RECORD = SCENE.ideal_bearing()
OPERATION_OF_RECORD = SCENE.ideal_operation()
LAW = steel_law("harris", BEARING_OF_RECORD.roller_length)


def test_paper_bearing_turns_as_its_kinematics_say():
    found = kinematics(BEARING_OF_RECORD, 2 * np.pi * 75.0)
    lines = {"shaft": 75.0, "FTF": 29.348, "BPFO": 381.52, "BPFI": 593.48, "BSF": 164.35}
    assert found.frequencies == pytest.approx(lines, rel=1e-4)
    # Harris: cage = shaft/2 (1 − d/D), spin = shaft/2 (D/d) (1 − (d/D)²)
    assert found.frequencies["FTF"] == pytest.approx(37.5 * (1 - 10 / 46))
    assert found.frequencies["BSF"] == pytest.approx(37.5 * 4.6 * (1 - (10 / 46) ** 2))
    assert found.frequencies["BPFO"] + found.frequencies["BPFI"] == pytest.approx(13 * 75.0)


def test_rolling_without_slip_at_both_raceways():
    found = kinematics(BEARING_OF_RECORD, -300.0)
    centre = found.cage * BEARING_OF_RECORD.pitch_radius  # speed of a roller's centre, clearance 0
    r = BEARING_OF_RECORD.roller_radius
    assert centre - found.roller * r == pytest.approx(-300.0 * BEARING_OF_RECORD.inner_raceway_radius)
    assert centre + found.roller * r == pytest.approx(0.0, abs=1e-12)


def test_centrifugal_force_and_masses_of_the_paper():
    speed = kinematics(BEARING_OF_RECORD, OPERATION_OF_RECORD.speed).cage
    assert 0.006 * BEARING_OF_RECORD.pitch_radius * speed**2 == pytest.approx(4.69, abs=0.01)
    assert BEARING_OF_RECORD.roller_mass == pytest.approx(0.006, rel=0.03)
    assert BEARING_OF_RECORD.radial_clearance == pytest.approx(0.0, abs=1e-15)


def test_distance_agrees_with_equation_19_in_polar_coordinates():
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-1e-4, 1e-4, (2, 50))
    rho = rng.uniform(0.0228, 0.0232, (50, 13))
    theta = rng.uniform(-np.pi, np.pi, (50, 13))
    state = approaches(BEARING_OF_RECORD, x, y, rho * np.cos(theta), rho * np.sin(theta))
    x, y = x[:, None], y[:, None]
    chi = np.sqrt(x**2 + y**2 + rho**2 - 2 * rho * (x * np.cos(theta) + y * np.sin(theta)))
    np.testing.assert_allclose(state.distance, chi, rtol=1e-12)
    np.testing.assert_allclose(state.inner, 0.018 + 0.005 - chi, atol=1e-15)
    np.testing.assert_allclose(state.outer, rho + 0.005 - 0.028, atol=1e-15)
    np.testing.assert_allclose(state.direction_x, (x - rho * np.cos(theta)) / chi, atol=1e-12)
    np.testing.assert_allclose(state.direction_y, (y - rho * np.sin(theta)) / chi, atol=1e-12)


def test_resultant_is_minus_the_gradient_of_the_potential():
    rng = np.random.default_rng(6)
    theta = roller_angles(BEARING_OF_RECORD, 0.2)
    rho = 0.023 + 1e-6 * rng.uniform(-1, 1, 13)
    roller_x, roller_y = (rho * np.cos(theta))[None], (rho * np.sin(theta))[None]

    def energy(x, y):
        return LAW.potential(
            approaches(BEARING_OF_RECORD, np.array([x]), np.array([y]), roller_x, roller_y).inner
        ).sum()

    x, y, step = 1e-6, -4e-6, 1e-10
    state = approaches(BEARING_OF_RECORD, np.array([x]), np.array([y]), roller_x, roller_y)
    force_x, force_y = contact_resultant(state, LAW.force(state.inner))
    assert -(energy(x + step, y) - energy(x - step, y)) / (2 * step) == pytest.approx(force_x[0], rel=1e-5)
    assert -(energy(x, y + step) - energy(x, y - step)) / (2 * step) == pytest.approx(force_y[0], rel=1e-5)


def static_bearing(first_angle):
    """Hub and rollers in equilibrium: rigid rings, massless rollers, by Newton; x, y, ρ."""
    theta = roller_angles(BEARING_OF_RECORD, first_angle)

    def unbalance(q):
        x, y, rho = q[:1] * 1e-6, q[1:2] * 1e-6, 0.023 + q[2:] * 1e-6
        state = approaches(BEARING_OF_RECORD, x, y, (rho * np.cos(theta))[None], (rho * np.sin(theta))[None])
        inner = LAW.force(state.inner)
        error_x, error_y = error_forces(OPERATION_OF_RECORD, 0.0, 0.0, *contact_resultant(state, inner))
        radial = state.inner - state.outer  # both contacts of a massless roller carry the same
        return np.concatenate([error_x / 1e3, error_y / 1e3, radial[0] * 1e6])

    q, _, status, message = fsolve(unbalance, np.r_[0.1, -4.0, -2.0 * np.sin(theta)], full_output=True, xtol=1e-13)
    assert status == 1, message
    x, y, rho = q[:1] * 1e-6, q[1:2] * 1e-6, 0.023 + q[2:] * 1e-6
    return x, y, (rho * np.cos(theta))[None], (rho * np.sin(theta))[None]


@pytest.mark.parametrize(
    ("first_angle", "loads"),
    [
        (-np.pi / 2, [629.7, 550.1, 550.1, 335.9, 335.9, 60.0, 60.0]),
        (-np.pi / 2 + np.pi / 13, [607.0, 607.0, 454.6, 454.6, 198.2, 198.2]),
    ],
)
def test_static_bearing_carries_the_load_without_error(first_angle, loads):
    """Rigid rings and Harris's law; the loads come from an independent solution."""
    x, y, roller_x, roller_y = static_bearing(first_angle)
    state = approaches(BEARING_OF_RECORD, x, y, roller_x, roller_y)
    force = LAW.force(state.inner)
    error_x, error_y = error_forces(OPERATION_OF_RECORD, 0.0, 0.0, *contact_resultant(state, force))
    assert abs(error_x[0]) < 1e-6 and abs(error_y[0]) < 1e-6
    np.testing.assert_allclose(np.sort(force[force > 1e-6])[::-1], loads, atol=0.15)
    angle = np.arctan2(roller_y, roller_x)
    assert np.sum(-force * np.sin(angle)) == pytest.approx(2000.0, rel=2e-3)
    if len(loads) == 7:
        assert -1e6 * y[0] == pytest.approx(4.115, abs=0.001)


def test_errors_have_the_signs_of_equations_22_and_23():
    operation = Operation(speed=0.0, radial_load=100.0, inner_mass=2.0, gravity=10.0, first_roller_angle=0.0)
    error_x, error_y = error_forces(operation, np.array([3.0]), np.array([4.0]), np.array([5.0]), np.array([7.0]))
    assert error_x[0] == 2 * 3 - 5
    assert error_y[0] == 2 * 4 + 2 * 10 - 7 + 100
    lifted = error_forces(operation, 0.0, 0.0, 0.0, np.array([120.0]))[1]  # contacts carry load and weight
    assert lifted[0] == 0.0


# Statics against independent solutions and the literature's load distribution.


PAPER = Scene().ideal_bearing()
RUNNING = Scene().ideal_operation()
STANDING = replace(RUNNING, speed=0.0, gravity=0.0)


def unbalance(bearing, operation, laws, found, cage):
    """Largest left side of (21)-(23) at rest in the turning frame, N."""
    zero = np.zeros(bearing.n_rollers)
    state = State(
        x=found.x, y=found.y, rho=found.rho, theta=found.theta,
        x_rate=0.0, y_rate=0.0, rho_rate=zero, theta_rate=zero + cage,
    )  # fmt: skip
    touch = contact_state(bearing, laws, state)
    radial = radial_equations(bearing, operation, state, touch, zero)
    return max(np.max(np.abs(hub_equations(operation, state, touch, 0.0, 0.0))), np.max(np.abs(radial)))


@pytest.mark.parametrize(
    ("first_angle", "loads", "approach"),
    [
        (-np.pi / 2, [629.7, 550.1, 550.1, 335.9, 335.9, 60.0, 60.0], 4.11),
        (-np.pi / 2 + np.pi / 13, [607.0, 607.0, 454.6, 454.6, 198.2, 198.2], 4.10),
    ],
)
def test_papers_bearing_with_harris_law(first_angle, loads, approach):
    """Rigid rings, massless rollers; the loads come from an independent solution."""
    found = static_equilibrium(
        PAPER, replace(STANDING, first_roller_angle=first_angle), contact_laws("harris", PAPER), roller_mass=0.0
    )
    np.testing.assert_allclose(np.sort(found.inner_force)[::-1][: len(loads)], loads, atol=0.15)
    assert np.sum(found.inner_force > 0.0) == len(loads)
    assert -1e6 * found.y == pytest.approx(approach, abs=0.01)
    np.testing.assert_allclose(found.inner_force, found.outer_force, atol=1e-6)


@pytest.mark.parametrize(
    ("bearing", "name", "printed"), [(PAPER, "harris", 4.08), (DGBB_209, "hertz", 4.37)], ids=["line", "point"]
)
def test_stribeck_number_of_many_elements_without_clearance(bearing, name, printed):
    track = bearing.inner_raceway_radius + 2.0 * bearing.roller_radius
    many = replace(bearing, n_rollers=1000, outer_raceway_radius=track)
    laws = contact_laws(name, many)
    found = static_equilibrium(many, STANDING, laws, roller_mass=0.0)
    number = 1000 * found.inner_force.max() / STANDING.radial_load
    assert number == pytest.approx(printed, abs=0.008)
    assert number == pytest.approx(stribeck_number(laws.inner.exponent), rel=1e-4)


@pytest.mark.parametrize("epsilon", SJOVALL)
@pytest.mark.parametrize(("exponent", "column"), [(1.5, 0), (1.1, 1)], ids=["point", "line"])
def test_load_distribution_with_clearance_or_preload(epsilon, exponent, column):
    """J_r = F/(Z Q_max) at ε = ½ (1 − clearance/deflection): the load is sought that gives ε."""
    deflection, n = 10e-6, 360
    clearance = deflection * (1.0 - 2.0 * epsilon)
    track = PAPER.inner_raceway_radius + 2.0 * PAPER.roller_radius + clearance
    bearing = replace(PAPER, n_rollers=n, outer_raceway_radius=track)
    law = PowerLaw(name="test", stiffness=600.0 / 2e-6**exponent, exponent=exponent, source="")
    psi = 2.0 * np.pi * np.arange(n) / n
    approach = np.maximum(deflection * np.cos(psi) - clearance, 0.0)
    load = np.sum(law.force(approach / 2.0) * np.cos(psi))
    found = static_equilibrium(bearing, replace(STANDING, radial_load=load), ContactLaws(law, law), roller_mass=0.0)
    assert -found.y == pytest.approx(deflection, rel=2e-3)
    assert load / (n * found.inner_force.max()) == pytest.approx(SJOVALL[epsilon][column], abs=3e-4)


def test_ball_loads_of_harris_example():
    """209 deep-groove bearing, 15 µm diametral clearance, 8900 N: 4536 N on the lowest ball.

    Source: Harris, Rolling Bearing Analysis, example of the 209 bearing, second hand.
    """
    found = static_equilibrium(
        DGBB_209, replace(STANDING, radial_load=8900.0), contact_laws("hertz", DGBB_209), roller_mass=0.0
    )
    assert found.inner_force.max() == pytest.approx(4536.0, rel=2e-3)
    assert np.sum(found.inner_force > 0.0) == 5
    # the same by hand: springs in series along the fixed directions of the balls
    laws = contact_laws("hertz", DGBB_209)
    series = sum(law.stiffness ** (-2 / 3) for law in laws) ** -1.5
    cosines = np.cos(found.theta + np.pi / 2)
    force = series * np.maximum(-found.y * cosines - DGBB_209.radial_clearance, 0.0) ** 1.5
    # the directions turn by up to 60 µm/32 mm
    np.testing.assert_allclose(found.inner_force, force, atol=3.0)
    assert np.sum(force * cosines) == pytest.approx(8900.0, rel=2e-3)


@pytest.mark.parametrize("name", ["harris", "johnson"])
def test_running_bearing_fulfils_the_equations_of_motion(name):
    laws = contact_laws(name, PAPER)
    found = static_equilibrium(PAPER, RUNNING, laws)
    cage = 0.5 * RUNNING.speed * 18.0 / 23.0
    assert unbalance(PAPER, RUNNING, laws, found, cage) < 1e-5
    # centrifugal force, more or less the weight
    np.testing.assert_allclose(found.outer_force[found.inner_force == 0.0], 4.78, atol=0.08)


def test_any_clearance_preload_and_load_has_an_equilibrium():
    for clearance, load, speed, angle in product(
        [-2e-5, 0.0, 1e-6, 1e-4], [0.0, 1e-3, 50.0, 20000.0], [0.0, RUNNING.speed], [-np.pi / 2, 0.3]
    ):
        bearing = replace(PAPER, outer_raceway_radius=PAPER.outer_raceway_radius + clearance)
        laws = contact_laws("harris", bearing)
        operation = replace(RUNNING, radial_load=load, speed=speed, first_roller_angle=angle)
        found = static_equilibrium(bearing, operation, laws)
        worst = unbalance(bearing, operation, laws, found, 0.5 * speed * 0.018 / bearing.pitch_radius)
        assert worst < 1e-6 + 1e-9 * (load + np.sum(found.inner_force))


def test_without_load_a_clearance_stays_put_and_a_preload_squeezes_all_rollers():
    unloaded, loose = replace(STANDING, radial_load=0.0), replace(PAPER, outer_raceway_radius=0.02801)
    laws = contact_laws("harris", loose)
    found = static_equilibrium(loose, unloaded, laws, roller_mass=0.0, start=(1e-6, 2e-6))
    assert (found.x, found.y) == (1e-6, 2e-6) and not found.inner_force.any()
    tight = replace(PAPER, outer_raceway_radius=0.02798)
    assert np.all(static_equilibrium(tight, STANDING, laws, roller_mass=0.0).inner_force > 0.0)
    squeezed = static_equilibrium(tight, unloaded, laws, roller_mass=0.0)
    np.testing.assert_allclose(squeezed.inner_force, laws.inner.force(1e-5), rtol=1e-9)
