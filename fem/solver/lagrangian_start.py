"""The start of the Lagrangian model: its sample, and the accelerations that its first steps need. No compiler."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.solver.guards import EnergyAccount, largest_forces
from fem.solver.lagrangian_judge import Judge
from fem.solver.solver import Block, Numbers, RunState
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.motion import State, contact_state, housing_accelerations, hub_equations, radial_equations
from lagrange.samples import sampled
from lagrange.surface.deviation import Turns

if TYPE_CHECKING:
    from fem.solver.lagrangian import LagrangianPlan

KEPT = "turns", "tilts"  # of a state: no arrays
WORKS = "energy_elastic", "work_external", "work_dissipated", "work_damping_contact", "work_damping_bodies"


@dataclass(frozen=True, kw_only=True)
class Beginning:
    """Motion at t = 0 in the fixed frame, m, m/s, m/s², and its sample, by the result file's names."""

    angle: np.ndarray  # (n_rollers,), rad
    hub: np.ndarray  # (2,)
    hub_velocity: np.ndarray  # (2,)
    hub_acceleration: np.ndarray  # (2,)
    centre: np.ndarray  # (2, n_rollers)
    velocity: np.ndarray  # (2, n_rollers)
    acceleration: np.ndarray  # (2, n_rollers)
    pushed: np.ndarray  # (2, n_rollers), by contacts and weight, of held rollers along their rays
    ring: np.ndarray  # (2,), of the outer ring
    ring_acceleration: np.ndarray  # (2,)
    samples: dict[str, np.ndarray]  # (1,) and (1, n_rollers)


def beginning(problem: Problem) -> Beginning:
    """The start of a problem.

    Errors
    ------
    RuntimeError: no equilibrium.
    """
    bearing, operation, held = problem.bearing, problem.operation, problem.angles == "kinematic"
    state = replace(problem.first_state.state, turns=Turns.rolling(bearing, operation, 0.0))
    touch = contact_state(bearing, problem.contacts, state, problem.damping)
    hub_acceleration = -np.array(hub_equations(problem.acting(0.0), state, touch, 0.0, 0.0)) / operation.inner_mass
    ring = np.array([state.ring_x, state.ring_y])
    ring_acceleration = np.array(housing_accelerations(bearing, operation, state, touch))
    radial = np.array([np.cos(state.theta), np.sin(state.theta)])
    around = np.array([-radial[1], radial[0]])
    m = bearing.roller_mass
    outwards = -radial_equations(bearing, operation, state, touch, state.rho * state.theta_rate**2) / m
    aside = touch.inner_force * touch.tangential + touch.outer_force * touch.outer_slope
    along = aside / m - operation.gravity * np.cos(state.theta)
    history = operation.history
    gain = 0.0 if history is None else float(kinematics(bearing, *history.ring_speeds(0.0, 1)).cage)
    if held:
        along = ring_acceleration @ around + 2.0 * state.rho_rate * state.theta_rate + state.rho * gain
    pushed = outwards * radial + (0.0 if held else 1.0) * along * around
    return Beginning(
        angle=state.theta,
        hub=np.array([state.x, state.y]) + ring,
        hub_velocity=np.array([state.x_rate, state.y_rate]),
        hub_acceleration=hub_acceleration,
        centre=ring[:, None] + state.rho * radial,
        velocity=state.rho_rate * radial + state.rho * state.theta_rate * around,
        acceleration=outwards * radial + along * around,
        pushed=pushed,
        ring=ring,
        ring_acceleration=ring_acceleration,
        samples=_samples(problem, state),
    )


def _samples(problem: Problem, state: State) -> dict[str, np.ndarray]:
    """The first sample."""
    coordinates = {name: np.asarray(value)[None] for name, value in vars(state).items() if name not in KEPT}
    alone = State(**coordinates, turns=state.turns, tilts=None if state.tilts is None else state.tilts.as_sample())
    found, per_roller = sampled(problem, np.zeros(1), alone), np.zeros((1, problem.bearing.n_rollers))
    found |= dict.fromkeys(("inner_traction", "outer_traction", "roller_roller_force", "roller_turn"), per_roller)
    spin = kinematics(problem.bearing, *problem.operation.ring_speeds).roller
    return found | dict.fromkeys(WORKS, np.zeros(1)) | {"roller_spin": per_roller + spin}


class StartState(RunState):
    """A run of the first sample alone, which takes no steps."""

    plan: "LagrangianPlan"

    def __init__(self, plan: "LagrangianPlan"):
        super().__init__(plan)
        self._judge, self._largest = Judge(plan.problem, plan.time_step), np.zeros(3)
        _ = plan.begin

    @property
    def steps_per_sample(self) -> int:
        return self.plan.stride

    def advance(self, most: int) -> Block:
        start = self.plan.begin.samples
        samples = EnergyAccount().samples(dict(start), np.zeros(1), start["energy_contact"])
        self._judge.meet(samples)
        self._largest, self.done = largest_forces(samples), 1
        return Block(samples=samples)

    @property
    def warnings(self) -> tuple[str, ...]:
        return self._judge.warnings(self._largest)

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        more = {"time_step": self.plan.time_step, "critical_time_step": self._judge.critical_time_step}
        return super().outcome_attributes | more

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = self._judge.to_keep()
        return arrays, numbers | {"halvings": 0, "doublings": 0}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        if self.done:
            self.advance(1)
