"""Compiled steps of the Lagrangian model: they make the reference's motion, of second order, in any parts."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from fem.kernels.jit import kernel
from fem.kernels.lane_functions import exponential
from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import BALL_LAWS, ROLLER_LAWS, ContactLaws
from lagrange.first_state import Problem
from tests.reference.compiled_motion import COMPARED, assert_right, compiled, simulation
from tests.reference.ideal import DGBB_209, DOWN, PAPER, PRELOADED, RUNNING, spall, wavy

N = 101  # samples
PARTS = (*(name for name in COMPARED if name[:7] not in ("housing", "sensor_")), "energy_error")
STARTS = {
    "in equilibrium": {},
    "from rest": dict(start="rest", load_ramp=4e-4),
    "free": dict(angles="free"),
    "damped": dict(damping=ContactDamping(constant=200.0), start="rest", load_ramp=4e-4),
    "damped, free": dict(damping=ContactDamping(constant=200.0), start="rest", angles="free"),
    "damped by a time": dict(damping=ContactDamping(time=2e-6), start="rest", load_ramp=4e-4),
    "Hunt and Crossley": dict(damping=ContactDamping(hunt_crossley=1.0), start="rest", load_ramp=4e-4),
}


def problem(bearing=PAPER, law="harris", operation=RUNNING, **choices):
    return Problem(bearing=bearing, operation=operation, laws=contact_laws(law, bearing), **choices)


@pytest.mark.parametrize("law", [name for name in ROLLER_LAWS if name != "harris"])
def test_every_law_of_rollers(law):
    assert_right(problem(law=law))


@pytest.mark.parametrize("law", BALL_LAWS)
def test_every_law_of_balls(law):
    assert_right(problem(DGBB_209, law, replace(RUNNING, radial_load=8900.0, inner_mass=0.5)), interval=2e-5)


@pytest.mark.parametrize("start", STARTS)
def test_every_way_to_move(start):
    assert_right(problem(**STARTS[start]), share=5e-3)


@pytest.mark.parametrize("count", [3, 8, 9])
def test_any_number_of_rollers(count):
    """Lanes that are left over change nothing."""
    assert_right(problem(replace(PAPER, n_rollers=count)))


def test_beyond_a_law_s_range_it_goes_on_along_its_tangent():
    laws = ContactLaws(*(replace(law, largest_force=300.0) for law in contact_laws("johnson", PAPER)))
    assert_right(replace(problem(), laws=laws))  # 630 N at most


def test_on_surfaces_that_are_not_perfect():
    assert_right(problem(replace(PAPER, faults=wavy())))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "angles", "damping", "faults"),
    [*product(("harris", "johnson"), ("kinematic", "free"), (0.0, 1000.0), ("waves", "spall", "all"))],
)
def test_every_law_and_way_to_move_on_surfaces(law, angles, damping, faults):
    strike = spall("outer_ring", DOWN + 0.02)
    faults = {"waves": wavy(), "spall": (strike,), "all": (*wavy(), strike)}[faults]
    what = problem(replace(PAPER, faults=faults), law, angles=angles, damping=ContactDamping(constant=damping))
    assert_right(what, 26, share=2e-2 if damping else 2e-3)  # what dampers give jumps as a strike begins


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.parametrize("start", STARTS)
def test_a_solution_in_parts_has_the_bits_of_the_whole(start, kept):
    """Cut at any sample, and with `kept` gone on with from what a file would hold; the first by what takes no step."""
    what = problem(**STARTS[start])
    whole, going, parts = compiled(what, N), simulation(what), []
    for count in (1, 1, 62, 2, N - 66):
        going = going.gone_on() if kept else going
        parts.append(going.advance(count))
    for name in PARTS:
        found = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(found, getattr(whole, name)), name


def test_free_angles_turn_on_across_parts():
    """At 60 000 rpm a roller passes ±π on the way."""
    fast = problem(operation=replace(RUNNING, speed=60000 * np.pi / 30, first_roller_angle=3.0), angles="free")
    whole, going = compiled(fast, N).roller_theta, simulation(fast)
    assert np.max(whole[:, 0]) > np.pi and np.all(np.abs(np.diff(whole, axis=0)) < 0.1)
    found = np.concatenate([going.advance(count).roller_theta for count in (1, 30, 30, N - 61)])
    assert np.array_equal(found, whole)


def test_an_overflow_keeps_what_came_before_it():
    """On surfaces, where a place that is no number must not become one in memory."""
    going = simulation(problem(replace(PAPER, faults=wavy()), start="rest"), 1e-2, 1e-2)
    part = going.advance(2000)
    assert going.trouble.startswith("the motion overflowed by t = ")
    assert 0 < part.time.size == going.state.done < 2000
    assert all(np.all(np.isfinite(getattr(part, name))) for name in PARTS)


@pytest.mark.parametrize("damping", [0.0, 200.0])
def test_they_are_of_second_order_at_least(damping):
    """Every contact closed: the forces are smooth, and undamped the largest part of the error is of fourth order."""
    what = problem(PRELOADED, start="rest", damping=ContactDamping(constant=damping))

    def final(step):
        run = compiled(what, 11, 2e-5, step)
        assert run.inner_force.min() > 0.0
        return np.concatenate([run.inner_y, run.roller_rho.ravel()])

    steps = 8e-7 / np.array([1, 2, 4])
    errors = [np.abs(final(step) - final(5e-8)).max() for step in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8


def test_exponential():
    x = np.concatenate([np.linspace(-690.0, 690.0, 997), [0.0, 1e-300, -1e-17, 0.3465, -0.3466]])
    found = np.array([_exponential(each) for each in x])
    np.testing.assert_allclose(found, np.exp(x), rtol=4e-16, atol=0.0)


@kernel
def _exponential(x):
    return exponential(x)
