"""The Lagrangian model on surfaces that are not perfect: statics, forces from one potential, energy."""

from dataclasses import replace

import numpy as np
import pytest

from lagrange import static_equilibrium
from lagrange.first_state import Problem
from lagrange.motion import State, accelerations, contact_energy, contact_state
from lagrange.surface.deviation import Turns
from tests.reference.compiled_motion import compiled, simulation
from tests.reference.forward_motion import simulate
from tests.reference.ideal import DOWN, HARRIS, PAPER, RUNNING, spall, wavy

STANDING = replace(RUNNING, speed=0.0, gravity=0.0)


# rigid rings, Harris' law, the roller on the load line sunk by h: hub and loads from the load line outwards, from an
# independent solution; m and N
SUNK = {
    1e-6: (4.4269e-6, 513.8, 596.6, 364.3, 65.1),
    2e-6: (4.7323e-6, 399.5, 642.5, 392.4, 70.1),
    3e-6: (5.0301e-6, 287.2, 687.6, 419.9, 75.0),
    5e-6: (5.5926e-6, 73.1, 773.5, 472.4, 84.4),
    8e-6: (5.7832e-6, 0.0, 802.9, 490.3, 87.6),
}


@pytest.mark.parametrize(("body", "angle"), [("outer_ring", DOWN), ("inner_ring", DOWN), ("roller", -DOWN)])
@pytest.mark.parametrize("depth", SUNK)
def test_statics_over_a_spall(depth, body, angle):
    hub, *loads = SUNK[depth]
    bearing = replace(PAPER, faults=(spall(body, angle, depth=depth),))
    found = static_equilibrium(bearing, STANDING, HARRIS, roller_mass=0.0)
    assert -found.y == pytest.approx(hub, rel=5e-4)
    np.testing.assert_allclose(found.inner_force[:4], loads, atol=0.2)


@pytest.mark.parametrize(("body", "unloads_from"), [("outer_ring", 0.530e-3), ("inner_ring", 0.425e-3)])
def test_a_roller_unloads_fully_from_a_width_on(body, unloads_from):
    for width, is_loaded in ((0.98 * unloads_from, True), (1.02 * unloads_from, False)):
        bearing = replace(PAPER, faults=(spall(body, DOWN, width=width),))
        found = static_equilibrium(bearing, STANDING, HARRIS, roller_mass=0.0)
        assert (found.inner_force[0] > 0.0) == is_loaded


def test_accelerations_are_the_gradient_of_the_energy():
    """Central differences of the contacts' energy by each coordinate, rollers on slopes of all four surfaces."""
    faults = (*wavy(), spall("outer_ring", DOWN), spall("inner_ring", DOWN + 0.45))
    bearing, operation = replace(PAPER, faults=faults), replace(RUNNING, gravity=0.0, radial_load=0.0)
    n, rng = 13, np.random.default_rng(3)
    start = np.concatenate([[1e-6, -12e-6], 0.023 + rng.uniform(-1e-6, 1e-6, n), DOWN + 0.015 + np.arange(n) * 0.47])

    def state(values):
        rest = np.zeros(n)
        return State(
            x=values[0], y=values[1], rho=values[2 : n + 2], theta=values[n + 2 :],
            x_rate=0.0, y_rate=0.0, rho_rate=rest, theta_rate=rest, turns=Turns(inner_ring=-0.01, rollers=0.2),
        )  # fmt: skip

    def energy(values):
        return contact_energy(HARRIS, contact_state(bearing, HARRIS, state(values)))

    contacts = contact_state(bearing, HARRIS, state(start))
    ax, ay, rho, theta = accelerations(bearing, operation, state(start), contacts)
    mass = bearing.roller_mass
    forces = np.concatenate(
        [[operation.inner_mass * ax, operation.inner_mass * ay], mass * rho, mass * start[2 : n + 2] ** 2 * theta]
    )
    steps = np.concatenate([np.full(n + 2, 1e-9), np.full(n, 1e-8)])
    gradient = [
        (energy(start + h * unit) - energy(start - h * unit)) / (2.0 * h)
        for h, unit in zip(steps, np.eye(2 * n + 2), strict=True)
    ]
    assert np.abs(contacts.outer_slope).max() > 0.01 and np.count_nonzero(forces[n + 2 :]) > 5
    np.testing.assert_allclose(forces[: n + 2], -np.array(gradient[: n + 2]), atol=2e-3, rtol=1e-4)
    np.testing.assert_allclose(forces[n + 2 :], -np.array(gradient[n + 2 :]), atol=2e-5, rtol=1e-4)


def test_the_record_s_equations_hold_on_imperfect_surfaces():
    """Accelerations of the solution against differences of its own velocities."""
    bearing = replace(PAPER, faults=wavy())
    run = simulate(Problem(bearing, RUNNING, HARRIS), 2e-4, 1e-6)
    v = run.inner_vy
    slope = (8.0 * (v[3:-1] - v[1:-3]) - (v[4:] - v[:-4])) / 12e-6
    assert np.std(run.inner_ay) > 1.0
    np.testing.assert_allclose(run.inner_ay[2:-2], slope, atol=1e-3 * np.abs(run.inner_ay).max())


def test_the_first_state_moves_with_the_equilibrium():
    """A wavy ring turning under the load moves the hub from the start on: no transient of its own mode is left."""
    bearing = replace(PAPER, faults=wavy())
    operation = replace(RUNNING, speed=RUNNING.speed / 20.0)
    run = simulate(Problem(bearing, operation, HARRIS), 1e-3, 1e-5)
    every = slice(None, None, 10)

    def at_rest(time, theta, x, y):
        turns = Turns(inner_ring=operation.speed * time, rollers=run.roller_spin * time)
        return static_equilibrium(bearing, operation, HARRIS, angles=theta, start=(x, y), turns=turns).y

    samples = zip(run.time[every], run.roller_theta[every], run.inner_x[every], run.inner_y[every], strict=True)
    slow = np.array([at_rest(*sample) for sample in samples])
    assert np.ptp(slow) > 10e-9
    np.testing.assert_allclose(run.inner_y[every], slow, atol=0.5e-9)


@pytest.mark.parametrize(
    ("body", "angle"), [("outer_ring", DOWN + 0.05), ("inner_ring", DOWN - 0.08), ("roller", DOWN + 0.25)]
)
def test_energy_of_compiled_steps_is_balanced_over_a_spall_and_the_strike(body, angle):
    """Of second order in the step where the kink in the spall's middle and the strike are crossed."""
    problem = Problem(bearing=replace(PAPER, faults=(spall(body, angle),)), operation=RUNNING, laws=HARRIS)
    errors = []
    for step in (2.5e-7, 1.25e-7):
        run = compiled(problem, 61, time_step=step)
        errors.append(np.abs(run.energy_error).max() / run.energy_contact.max())
        # the roller was unloaded and struck
        assert run.outer_force[:, 0].min() == 0.0
    assert errors[0] < 1e-3 and errors[1] < 1e-4 and errors[1] < errors[0] / 3.0


@pytest.mark.parametrize("angles", ["kinematic", "free"])
def test_a_run_in_parts_has_the_same_bits(angles):
    """Cut at any sample, its memory kept and taken back."""
    bearing = replace(PAPER, faults=(*wavy(), spall("outer_ring", DOWN + 0.02)))
    problem = Problem(bearing=bearing, operation=RUNNING, laws=HARRIS, angles=angles)
    whole, first = compiled(problem, 8), simulation(problem)
    first.advance(3)
    found = first.gone_on().advance(5)
    for name in ("inner_y", "roller_rho", "work_external", "energy_error"):
        assert np.array_equal(getattr(found, name), getattr(whole, name)[3:])
