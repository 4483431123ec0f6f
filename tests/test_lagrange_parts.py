"""The Lagrangian model's solution in parts: how it is cut, kept and taken back changes no bit."""

from dataclasses import replace

import numpy as np
import pytest

from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.integrate import BLOCK
from lagrange.scene.scene import Scene
from lagrange.simulate import Simulation, Verdict, simulate

PAPER = Scene().ideal_bearing()
RUNNING = Scene().ideal_operation()
INTERVAL = 1e-5  # s
N = 3 * BLOCK + 9  # samples: over several blocks of tabulated directions, not to a border
CASES = {
    "held angles": dict(),
    "free angles": dict(angles="free"),
    "from rest": dict(start="rest", load_ramp=1e-3),
    "damped": dict(start="rest", load_ramp=5e-4, damping=ContactDamping(constant=200.0)),
    "damped, free angles": dict(start="rest", damping=ContactDamping(constant=200.0), angles="free"),
}
NUMBERS = ("inner_x", "inner_ay", "roller_rho", "roller_theta", "inner_force", "energy_kinetic", "energy_error",
           "work_external", "work_dissipated")  # fmt: skip


def problem(operation=RUNNING, **choices):
    return Problem(bearing=PAPER, operation=operation, laws=contact_laws("harris", PAPER), **choices)


def in_parts(what, cuts, kept=False):
    """A solution cut after these samples; with `kept` each part goes on from what a file would hold of the last."""
    simulation, parts = Simulation(what, INTERVAL), []
    for first, last in zip((0, *cuts), (*cuts, N), strict=True):
        if kept:
            stored = {name: array.copy() for name, array in simulation.to_keep().items()}
            simulation = Simulation(what, INTERVAL)
            simulation.take_back(stored, first, 0)
        parts.append(simulation.advance(last - first))
    return {name: np.concatenate([getattr(part, name) for part in parts]) for name in NUMBERS}


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_a_solution_in_parts_is_the_whole_one(case, kept):
    whole = in_parts(problem(**CASES[case]), ())
    for cuts in ((1, 2, 63, 64, 65, 120), (BLOCK + 1,), tuple(range(17, N, 17))):
        found = in_parts(problem(**CASES[case]), cuts, kept)
        for name in NUMBERS:
            assert np.array_equal(found[name], whole[name]), (name, cuts)


def test_free_angles_turn_on_across_parts():
    """At 60 000 rpm a roller passes ±π on the way."""
    fast = problem(replace(RUNNING, speed=60000 * np.pi / 30, first_roller_angle=3.0), angles="free")
    whole = in_parts(fast, ())
    assert np.ptp(whole["roller_theta"][:, 0]) > np.pi / 2 and np.max(whole["roller_theta"][:, 0]) > np.pi
    assert np.all(np.abs(np.diff(whole["roller_theta"], axis=0)) < 0.1)
    found = in_parts(fast, tuple(range(10, N, 10)), kept=True)
    assert np.array_equal(found["roller_theta"], whole["roller_theta"])


def test_the_verdict_at_the_end_is_the_same_in_parts(monkeypatch):
    """Judged by the largest forces and errors of all parts: a step twelve times too long is found in either way."""
    monkeypatch.setattr("lagrange.step_size.STEP", 24.0)
    whole, parts = Simulation(problem(start="rest"), INTERVAL), Simulation(problem(start="rest"), INTERVAL)
    for simulation, cuts in ((whole, (N,)), (parts, (50, N - 50))):
        for count in cuts:
            simulation.advance(count)
    assert whole.verdict is parts.verdict is not Verdict.RESOLVED
    assert whole.sentence == parts.sentence
    parts.refine()
    assert parts.done == 0 and parts.time_step == 0.5 * whole.time_step


def test_an_overflow_keeps_what_came_before_it(monkeypatch):
    monkeypatch.setattr("lagrange.step_size.STEP", 400.0)
    simulation = Simulation(problem(start="rest", angles="free"), 2e-4)
    part = simulation.advance(400)
    assert simulation.trouble.startswith(f"the motion overflowed by t = {simulation.done * 2e-4:.4g} s")
    assert 0 < part.time.size == simulation.done < 400
    assert all(np.all(np.isfinite(getattr(part, name))) for name in NUMBERS)
    with pytest.raises(RuntimeError, match="overflowed"):
        simulate(PAPER, RUNNING, contact_laws("harris", PAPER), 400 * 2e-4, 2e-4, start="rest", angles="free")
