"""Compiled runs of the Lagrangian model, and their judge, `forward_motion`, which shares no step with them."""

from math import ceil
from types import SimpleNamespace

import numpy as np

from fem.solver.rigid.lagrangian import LagrangianPlan
from fem.solver.rigid.state import LagrangianState
from fem.solver.solver import Samples
from lagrange import BallBearing
from lagrange.first_state import Problem
from lagrange.mounting import ENERGIES
from lagrange.step_size import longest_step
from tests.reference.forward_motion import simulate

COMPARED = ("inner_x", "inner_y", "roller_rho", "inner_vy", "inner_ay", "roller_theta", "inner_force", "outer_force",
            "work_external", "work_dissipated", "housing_y", "housing_ay", "sensor_ay")  # fmt: skip
# m/s, m/s² and J, for motions of nanometres: 2e-5 of what a load of 2 kN makes of the hub; the reference's tolerance
FLOORS = {"inner_vy": 1e-7, "inner_ay": 0.5, "housing_ay": 0.5, "sensor_ay": 0.5, "work_external": 1e-11}


class Motion:
    """A problem's motion under way."""

    def __init__(self, problem: Problem, interval: float = 1e-5, time_step: float | None = None):
        stride = ceil(interval / (longest_step(problem) if time_step is None else time_step) * (1.0 - 1e-12))
        kind = "ball" if isinstance(problem.bearing, BallBearing) else "roller"
        tilted = () if problem.axial is None else ("axial", *(("damping of tilt",) if problem.damping.acts else ()))
        scene = SimpleNamespace(
            cage=problem.cage,
            ideal_cage=lambda: problem.cage,
            model="lagrange",
            bearing=SimpleNamespace(type=kind),
            axial=problem.axial,
            parts=(*problem.operation.mounting.parts, *(() if problem.cage is None else ("cage",)), *tilted),
            numerics=SimpleNamespace(output_interval_us=1e6 * interval),
        )
        plan = LagrangianPlan(
            scene=scene,
            problem=problem,
            n_samples=10**6,
            stride=stride,
            sections=None,
            law_warning=None,
        )
        self.problem, self.state = problem, LagrangianState(plan)
        self.trouble: str | None = None

    @property
    def time_step(self) -> float:
        return self.state.plan.time_step

    def advance(self, count: int) -> SimpleNamespace:
        """The next samples by their names, their energy error, and a cage's by names of `CageSamples`."""
        blocks: list[Samples] = []
        end = self.state.done + count
        while self.state.done < end and self.trouble is None:
            block = self.state.advance(end - self.state.done)
            blocks += [] if block.samples is None else [block.samples]
            self.trouble = block.trouble
        found = Samples.joined(blocks)
        values = found.values
        cage = {name.removeprefix("cage_"): value for name, value in values.items() if name.startswith("cage_")}
        return SimpleNamespace(
            **values,
            energy_error=found.imbalance,
            energy_moved=values["energy_kinetic"] + sum(values[name] for name in ENERGIES if name in values),
            cage=SimpleNamespace(**cage),
            inner_damper=values["inner_damping_force"],
            outer_damper=values["outer_damping_force"],
            work_damping=values["work_damping_contact"],
            time_step=self.time_step,
            steps=round(values["time"][-1] / self.time_step),
        )

    def gone_on(self) -> "Motion":
        """Another one that goes on from what a checkpoint would keep of this."""
        arrays, numbers = self.state.to_keep()
        found = Motion(self.problem, self.state.plan.interval, self.time_step)
        found.state.done = self.state.done
        found.state.take_back({name: array.copy() for name, array in arrays.items()}, numbers)
        return found


simulation = Motion


def compiled(problem: Problem, count: int, interval: float = 1e-5, time_step: float | None = None) -> SimpleNamespace:
    """The first samples, by compiled steps."""
    return Motion(problem, interval, time_step).advance(count)


def solved(problem: Problem, duration: float, interval: float) -> SimpleNamespace:
    """As `tests.reference.forward_motion`, by compiled steps: for long motions."""
    return compiled(problem, int(duration / interval + 1e-9) + 1, interval)


def assert_right(
    problem: Problem, count: int = 31, interval: float = 1e-5, share: float = 2e-3, finer: float = 2.0
) -> None:
    """The usual step, so many times shorter, makes the reference's motion to this share of every quantity."""
    usual = Motion(problem, interval).time_step
    found = compiled(problem, count, interval, usual / finer)
    exact = simulate(problem, (count - 1) * interval, interval)
    assert np.count_nonzero(np.ptp(exact.inner_force, axis=0) > 1.0) > 1  # something happens
    for name in (name for name in COMPARED if hasattr(found, name)):
        ours, right = (np.asarray(getattr(run, name)) for run in (found, exact))
        allowed = share * np.abs(right).max() + FLOORS.get(name, 0.0)
        np.testing.assert_allclose(ours, right, rtol=0.0, atol=allowed, err_msg=name)
