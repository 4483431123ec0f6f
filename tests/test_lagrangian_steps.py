"""Compiled steps of the Lagrangian model against their reference, `lagrange.integrate.NumpyIntegration`.

Both take the same steps, so that they differ by round-off and what the motion makes of it: far less than the reference
itself changes with half its step.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from fem.kernels.jit import kernel
from fem.kernels.lane_functions import exponential
from fem.solver.lagrangian_steps import CompiledIntegration
from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.contact.raceway_laws import BALL_LAWS, ROLLER_LAWS, ContactLaws
from lagrange.first_state import Problem
from lagrange.integrate import NumpyIntegration
from lagrange.scene.scene import Scene
from lagrange.simulate import Simulation
from tests.test_lagrange_ball_contact import DGBB_209
from tests.test_lagrange_surfaces import DOWN, spall, wavy

PAPER = Scene().ideal_bearing()
RUNNING = Scene().ideal_operation()
INTERVAL = 1e-5  # s
N = 101  # samples
SHARE = 1e-2  # of the step's error: what the two may differ by; they do by some 1e-5 of it, rarely by 1e-3
ROUND_OFF = 1e-14  # of the largest value, of places of the pitch radius: for what the step does not change
PLACES = ("inner_x", "inner_y", "roller_rho")
COMPARED = (*PLACES, "inner_vy", "inner_ay", "roller_theta", "inner_force", "outer_force",
            "work_load", "work_cage", "work_dissipated")  # fmt: skip
STARTS = {
    "in equilibrium": {},
    "from rest": dict(start="rest", load_ramp=5e-4),
    "free": dict(angles="free"),
    "damped": dict(damping=ContactDamping(constant=200.0), start="rest", load_ramp=5e-4),
    "damped by a time": dict(damping=ContactDamping(time=2e-6), start="rest", load_ramp=5e-4),
    "Hunt and Crossley": dict(damping=ContactDamping(hunt_crossley=1.0), start="rest", load_ramp=5e-4),
}


def problem(bearing=PAPER, law="harris", operation=RUNNING, **choices):
    return Problem(bearing=bearing, operation=operation, laws=contact_laws(law, bearing), **choices)


def assert_same_within_the_step_s_error(what, interval=INTERVAL):
    found = Simulation(what, interval, integration=CompiledIntegration).advance(N)
    reference, halved = Simulation(what, interval), Simulation(what, interval)
    halved.refine()
    expected, finer = reference.advance(N), halved.advance(N)
    assert found.steps == expected.steps == finer.steps // 2
    assert np.count_nonzero(np.ptp(expected.inner_force, axis=0) > 1.0) > 1  # something happens
    for name in COMPARED:
        ours, theirs, nearer = (getattr(run, name) for run in (found, expected, finer))
        scale = what.bearing.pitch_radius if name in PLACES else np.abs(theirs).max()
        allowed = SHARE * np.abs(theirs - nearer).max() + ROUND_OFF * scale
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=allowed, err_msg=name)


@pytest.mark.parametrize("law", [name for name in ROLLER_LAWS if name != "harris"])
def test_every_law_of_rollers(law):
    assert_same_within_the_step_s_error(problem(law=law))


@pytest.mark.parametrize("law", BALL_LAWS)
def test_every_law_of_balls(law):
    operation = replace(RUNNING, radial_load=8900.0, inner_mass=0.5)
    assert_same_within_the_step_s_error(problem(DGBB_209, law, operation), 2e-5)


@pytest.mark.parametrize("start", STARTS)
def test_every_way_to_move(start):
    assert_same_within_the_step_s_error(problem(**STARTS[start]))


@pytest.mark.parametrize("count", [3, 8, 9])
def test_any_number_of_rollers(count):
    """Lanes that are left over change nothing."""
    assert_same_within_the_step_s_error(problem(replace(PAPER, n_rollers=count)))


def test_beyond_a_law_s_range_it_goes_on_along_its_tangent():
    laws = ContactLaws(*(replace(law, largest_force=300.0) for law in contact_laws("johnson", PAPER)))
    assert_same_within_the_step_s_error(replace(problem(), laws=laws))  # 630 N at most


def test_on_surfaces_that_are_not_perfect():
    assert_same_within_the_step_s_error(problem(replace(PAPER, faults=wavy())))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "angles", "damping", "faults"),
    [*product(("harris", "johnson"), ("kinematic", "free"), (0.0, 1000.0), ("waves", "spall", "all"))],
)
def test_every_law_and_way_to_move_on_surfaces(law, angles, damping, faults):
    strike = spall("outer_ring", DOWN + 0.02)
    faults = {"waves": wavy(), "spall": (strike,), "all": (*wavy(), strike)}[faults]
    what = problem(replace(PAPER, faults=faults), law, angles=angles, damping=ContactDamping(constant=damping))
    assert_same_within_the_step_s_error(what)


@pytest.mark.parametrize("start", STARTS)
def test_a_solution_in_parts_has_the_bits_of_the_whole(start):
    what = problem(**STARTS[start])
    whole = Simulation(what, INTERVAL, integration=CompiledIntegration).advance(N)
    done, parts, kept = 0, [], None
    for count in (1, 1, 62, 2, N - 66):
        simulation = Simulation(what, INTERVAL, integration=CompiledIntegration)
        if kept is not None:
            simulation.take_back(kept, done, 0)
        parts.append(simulation.advance(count))
        done, kept = done + count, {name: array.copy() for name, array in simulation.to_keep().items()}
    for name in (*COMPARED, "energy_error"):
        found = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(found, getattr(whole, name)), name


def test_numpy_s_start_is_gone_on_with():
    """What is kept of a run that has taken no step yet."""
    whole = Simulation(problem(), INTERVAL, integration=CompiledIntegration).advance(N)
    begun, rest = (
        Simulation(problem(), INTERVAL, integration=kind) for kind in (NumpyIntegration, CompiledIntegration)
    )
    begun.advance(1)
    rest.take_back(begun.to_keep(), 1, 0)
    assert np.array_equal(rest.advance(N - 1).inner_y, whole.inner_y[1:])


def test_an_overflow_keeps_what_came_before_it(monkeypatch):
    """On surfaces, where a place that is no number must not become one in memory."""
    for bound in ("_longest_step", "_passage"):
        monkeypatch.setattr(f"lagrange.step_size.{bound}", lambda problem: 1e-2)
    what = problem(replace(PAPER, faults=wavy()), start="rest")
    simulation = Simulation(what, 1e-2, integration=CompiledIntegration)
    part = simulation.advance(2000)
    assert simulation.trouble.startswith(f"the motion overflowed by t = {simulation.done * 1e-2:.4g} s")
    assert 0 < part.time.size == simulation.done < 2000
    assert all(np.all(np.isfinite(getattr(part, name))) for name in COMPARED)


@pytest.mark.parametrize(("damping", "order"), [(0.0, 4.0), (200.0, 2.0)])
def test_they_are_of_their_scheme_s_order(damping, order):
    """Every contact closed: the forces are smooth."""
    bearing = replace(PAPER, outer_raceway_radius=0.02799)
    what = problem(bearing, start="rest", damping=ContactDamping(constant=damping))

    def final(step):
        run = Simulation(what, 2e-5, step, integration=CompiledIntegration).advance(11)
        assert run.inner_force.min() > 0.0
        return np.concatenate([run.inner_y, run.roller_rho.ravel()])

    steps = 8e-7 / np.array([1, 2, 4])
    errors = [np.abs(final(step) - final(5e-8)).max() for step in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.2)


def test_exponential():
    x = np.concatenate([np.linspace(-690.0, 690.0, 997), [0.0, 1e-300, -1e-17, 0.3465, -0.3466]])
    found = np.array([_exponential(each) for each in x])
    np.testing.assert_allclose(found, np.exp(x), rtol=4e-16, atol=0.0)


@kernel
def _exponential(x):
    return exponential(x)
