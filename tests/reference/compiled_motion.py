"""Compiled runs of the Lagrangian model as trajectories, and their judge: `lagrange.simulate`, which shares no step."""

import numpy as np

from fem.solver.lagrangian_steps import CompiledIntegration
from lagrange.first_state import Problem
from lagrange.simulate import simulate
from lagrange.stepping import Simulation
from lagrange.trajectory import Trajectory

COMPARED = ("inner_x", "inner_y", "roller_rho", "inner_vy", "inner_ay", "roller_theta", "inner_force", "outer_force",
            "work_load", "work_cage", "work_dissipated", "housing_y", "housing_ay", "sensor_ay")  # fmt: skip
# m/s, m/s² and J, for motions of nanometres: 2e-5 of what a load of 2 kN makes of the hub; the reference's tolerance
FLOORS = {"inner_vy": 1e-7, "inner_ay": 0.5, "housing_ay": 0.5, "sensor_ay": 0.5, "work_cage": 1e-11}


def simulation(problem: Problem, interval: float = 1e-5, time_step: float | None = None) -> Simulation:
    """At its start."""
    return Simulation(problem, interval, CompiledIntegration, time_step)


def compiled(problem: Problem, count: int, interval: float = 1e-5, time_step: float | None = None) -> Trajectory:
    """The first samples, by compiled steps."""
    return simulation(problem, interval, time_step).advance(count)


def solved(bearing, operation, laws, duration: float, interval: float, **choices) -> Trajectory:
    """As `lagrange.simulate`, by compiled steps: for long motions."""
    problem = Problem(bearing=bearing, operation=operation, laws=laws, **choices)
    return compiled(problem, int(duration / interval + 1e-9) + 1, interval)


def reference(problem: Problem, count: int, interval: float = 1e-5) -> Trajectory:
    """The same by scipy."""
    given = {name: value for name, value in vars(problem).items() if name in Problem.__dataclass_fields__}
    return simulate(duration=(count - 1) * interval, interval=interval, **given)


def assert_right(problem: Problem, count: int = 31, interval: float = 1e-5, share: float = 2e-3) -> None:
    """Half the usual step makes the reference's motion, to this share of every quantity."""
    usual = simulation(problem, interval).time_step
    found, exact = compiled(problem, count, interval, 0.5 * usual), reference(problem, count, interval)
    assert np.count_nonzero(np.ptp(exact.inner_force, axis=0) > 1.0) > 1  # something happens
    for name in COMPARED:
        ours, right = (np.asarray(getattr(run, name)) for run in (found, exact))
        allowed = share * np.abs(right).max() + FLOORS.get(name, 0.0)
        np.testing.assert_allclose(ours, right, rtol=0.0, atol=allowed, err_msg=name)
