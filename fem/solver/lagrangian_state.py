"""A run of the Lagrangian model: its steps, its samples, and how it restarts."""

from typing import TYPE_CHECKING, Any

import numpy as np

from fem.kernels.sample_kernels import CONTACT, KINETIC, N_SCALARS, WORK_DRIVE
from fem.solver.guards import n_in_place, through_trouble
from fem.solver.lagrangian_arrays import bodies_of, contact_forces, contacts_of
from fem.solver.rigid.lagrangian import ENERGY_TOLERANCE, Judge, Verdict
from fem.solver.rigid_arrays import outer_drive
from fem.solver.rigid_state import RigidState
from fem.solver.solver import Block, Numbers, Samples
from lagrange.equations import THROUGH
from lagrange.first_state import Problem
from lagrange.kinematics import turned
from lagrange.motion import State, StatedDampers, contact_state, hub_equations, rotation_energy
from lagrange.mounting import from_outer_ring
from lagrange.surface.deviation import Turns
from lagrange.tilt import Tilts

if TYPE_CHECKING:
    from fem.solver.rigid.lagrangian import LagrangianPlan

MOST_HALVINGS = 3  # of the step, before a warning instead


class LagrangianState(RigidState):
    """A run that restarts with half the step where contacts have rattled, or bodies gone through one another."""

    plan: "LagrangianPlan"

    @property
    def most_halvings(self) -> int:
        return MOST_HALVINGS

    def arrays_of(self, plan: "LagrangianPlan"):
        problem = plan.problem
        drive = outer_drive(problem.bearing, problem.operation, plan.time_step, problem.load_ramp)
        return bodies_of(plan), contacts_of(problem, plan.reach), contact_forces(plan), drive

    def _begin(self) -> None:
        super()._begin()
        self.judge = Judge(self.plan.problem, self.plan.time_step)
        self._base = np.full(2, np.nan)  # J, from rows' kinetic and contacts' energy to those of the first sample

    def judged(self, block: Block) -> Block:
        at_end = self.done == self.plan.n_samples and block.trouble is None
        if not (at_end or self._came_apart) or self.judge.verdict is Verdict.RESOLVED:
            return block
        if self.may_restart:
            return self.restart(block.samples, self.judge.sentence.partition(";")[0])
        if self.judge.verdict is Verdict.TOO_FAST:
            return Block(samples=block.samples, trouble=self.judge.sentence)
        return block  # still worth having where contacts only rattle: see `notices`

    def velocity_trouble(self, step: int, body: int, n_good: int) -> str:
        time = self.plan.interval * (self.done + n_good)
        return f"the motion overflowed by t = {time:.4g} s; lower time_step"

    def sound_part(self, looked: Samples, trouble: str | None) -> tuple[int, str | None]:
        bearing = self.plan.problem.bearing
        self.judge.meet(looked)
        self.imbalance = float(looked.relative_error()[-1])
        in_place = n_in_place(bearing, THROUGH * bearing.roller_radius, looked)
        self._came_apart = in_place < len(looked) and trouble is None
        if self._came_apart:
            trouble = through_trouble(self.plan.problem.bearing, self.plan.time_step, looked, in_place)
        return in_place, trouble

    @property
    def warnings(self) -> tuple[str, ...]:
        found = self.judge.warnings(self._largest)
        if self._missed <= ENERGY_TOLERANCE * self._passed_on:
            return found
        return (
            *found,
            f"the energy balance is off by up to {100.0 * self._missed / self._passed_on:.2g} % of the largest "
            f"exchanged energy: the step of {1e6 * self.plan.time_step:.3g} µs is too long for impacts and dampers; "
            "single impacts are off by as much",
        )

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        return super().outcome_attributes | {"critical_time_step": self.judge.critical_time_step}

    @property
    def notices(self) -> tuple[str, ...]:
        at_end = 0 < self.done == self.plan.n_samples
        return (self.judge.sentence,) if at_end and self.judge.verdict is Verdict.RATTLING else ()

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = self.judge.to_keep()
        if self.done <= 1:  # as `StartState` does, whose run may go on
            return arrays, numbers | self.restarts
        moving = super().to_keep()
        return moving[0] | arrays | {"base": self._base}, moving[1] | numbers

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        if self.done > 1:
            super().take_back(arrays, numbers)
            self._base = arrays["base"]
            self.judge.take_back(arrays, numbers)
            return
        self.take_restarts(numbers)
        if self.done == 1:
            self.done = 0
            super(RigidState, self).advance(1)

    def read(self, rows: np.ndarray) -> Samples:
        """Samples of rows: with the energy of what turns, held rollers exactly on their rays, and the start's own."""
        plan, problem = self.plan, self.plan.problem
        time, first = plan.interval * np.arange(self.done, self.done + len(rows)), self.done == 0
        turning = rotation_energy(problem.bearing, problem.operation.at(time))
        rows[:, KINETIC] += turning
        rows[:, WORK_DRIVE] += turning
        if first:
            start = plan.begin.samples
            at_start = np.array([start["energy_kinetic"][0], start["energy_contact"][0]])
            self._base = at_start - rows[0, [KINETIC, CONTACT]]
        rows[:, KINETIC] += self._base[0]
        rows[:, CONTACT] += self._base[1]
        if problem.angles == "kinematic":
            self._put_on_rays(rows, time)
        samples = self.reader.read(rows)
        if problem.angles == "kinematic":
            samples["roller_theta"][:] = self._angles(time)
        self._balance(samples)
        if first:
            for name, value in plan.begin.samples.items():
                samples[name][0] = value[0]
        return samples

    def _balance(self, samples: Samples) -> None:
        """Forces of the laws at the samples' own places, and the hub's accelerations by these.

        Steps take forces a little ahead, and give the hub what keeps the energy where contacts open and close.
        """
        problem, time = self.plan.problem, samples["time"]
        bearing, operation = problem.bearing, problem.operation
        x, y = from_outer_ring(samples.values, "inner")
        ring_x, ring_y = samples["inner_x"] - x, samples["inner_y"] - y
        nothing = np.zeros(samples["roller_rho"].shape)
        state = State(
            x=x, y=y, rho=samples["roller_rho"], theta=samples["roller_theta"], x_rate=samples["inner_vx"],
            y_rate=samples["inner_vy"], rho_rate=nothing, theta_rate=nothing, ring_x=ring_x, ring_y=ring_y,
            turns=Turns.rolling(bearing, operation, time[:, None]), tilts=_tilts(problem, samples),
        )  # fmt: skip
        names = [f"{side}_damping_{kind}" for kind in ("force", "moment") for side in ("inner", "outer")]
        given = StatedDampers(*(samples[name] for name in names if name in samples.values))
        touch = contact_state(bearing, problem.contacts, state, given)
        samples["inner_damping_force"][:], samples["outer_damping_force"][:] = touch.inner_damper, touch.outer_damper
        samples["inner_force"][:], samples["outer_force"][:] = touch.inner_force, touch.outer_force
        if touch.tilted is not None:
            samples["inner_moment"][:] = touch.tilted.inner_moment
            samples["outer_moment"][:] = touch.tilted.outer_moment
            for name, moment in zip(names[2:], touch.tilted.dampers, strict=True):
                if name in samples.values:
                    samples[name][:] = moment
        left = hub_equations(problem.acting(time), state, touch, 0.0, 0.0)
        for axis, without in zip("xy", left, strict=True):
            of_cage: Any = 0.0
            if problem.free_cage is not None and problem.free_cage.guidance == "inner_ring":
                of_cage = samples[f"cage_guidance_{axis}"]
            samples[f"inner_a{axis}"][:] = -(without + of_cage) / operation.inner_mass

    def _angles(self, time: np.ndarray) -> np.ndarray:
        problem = self.plan.problem
        return self.plan.begin.angle + np.reshape(turned(problem.bearing, problem.operation, time).cage, (-1, 1))

    def _put_on_rays(self, rows: np.ndarray, time: np.ndarray) -> None:
        n = self.plan.problem.bearing.n_rollers
        ring = np.zeros((2, len(rows), 1))
        if self.bodies.housing is not None:
            column = self.bodies.housing.column
            ring[:] = rows[:, [column, column + 1]].T[:, :, None]
        x, y = rows[:, N_SCALARS : N_SCALARS + n], rows[:, N_SCALARS + n : N_SCALARS + 2 * n]
        rho, theta = np.hypot(x - ring[0], y - ring[1]), self._angles(time)
        x[:], y[:] = ring[0] + rho * np.cos(theta), ring[1] + rho * np.sin(theta)


def _tilts(problem: Problem, samples: Samples) -> Tilts | None:
    """Slopes of samples; None: axes stay parallel."""
    if problem.axial is None:
        return None
    tilt, nothing = samples["roller_tilt"], np.zeros(samples["roller_tilt"].shape)
    return Tilts(
        tilt=tilt, tilt_rate=nothing,
        slope_x=samples["inner_slope_x"], slope_y=samples["inner_slope_y"],
    )  # fmt: skip
