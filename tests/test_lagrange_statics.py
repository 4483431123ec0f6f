"""Statics against independent solutions and the literature's load distribution."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws
from lagrange.motion import State, contact_state, hub_equations, radial_equations
from lagrange.scene.scene import Scene
from lagrange.statics import static_equilibrium
from tests.reference.ideal import DGBB_209
from tests.reference.load_distribution import SJOVALL, stribeck_number

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
    bearing = replace(
        PAPER, n_rollers=n, outer_raceway_radius=PAPER.inner_raceway_radius + 2.0 * PAPER.roller_radius + clearance
    )
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


def test_unloaded_bearing_with_clearance_stays_put():
    bearing = replace(PAPER, outer_raceway_radius=0.02801)
    found = static_equilibrium(
        bearing, replace(STANDING, radial_load=0.0), contact_laws("harris", bearing), roller_mass=0.0,
        start=(1e-6, 2e-6),
    )  # fmt: skip
    assert (found.x, found.y) == (1e-6, 2e-6) and not found.inner_force.any()


def test_preload_carries_the_load_on_all_rollers():
    bearing = replace(PAPER, outer_raceway_radius=0.02798)
    found = static_equilibrium(bearing, STANDING, contact_laws("harris", bearing), roller_mass=0.0)
    assert np.all(found.inner_force > 0.0)
    squeezed = static_equilibrium(
        bearing, replace(STANDING, radial_load=0.0), contact_laws("harris", bearing), roller_mass=0.0
    )
    np.testing.assert_allclose(squeezed.inner_force, contact_laws("harris", bearing).inner.force(1e-5), rtol=1e-9)
