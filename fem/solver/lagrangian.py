"""The Lagrangian model as a solver: the ideal bearing's own solution in the form of the finite elements'.

Rigid bodies on contact springs: tractions and mesh energy are 0, the springs' energy is `energy_contact`. Friction,
mesh and time step safety of the scene play no part. No mesh; steps are compiled, and where none are taken no compiler
is loaded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from fem.errors import RunFailed
from fem.run_summary import largest_loads
from fem.solver.cautions import of_scene
from fem.solver.compiling import CompiledPlan
from fem.solver.guards import THROUGH, EnergyAccount, largest_forces, n_in_place, run_cautions, through_trouble
from fem.solver.pace import in_words, pace
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import ROUND_OFF, Block, Numbers, RunState, Samples, sample_count
from lagrange import Trajectory, contact_laws, static_equilibrium
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import caution
from lagrange.first_state import Problem
from lagrange.mounting import HELD
from lagrange.scene.scene import Scene
from lagrange.scene.tables import MODEL_NAMES
from lagrange.step_size import Steps, critical_time_step, steps_of
from lagrange.stepping import ALL_DRIFTS, ENERGY_TOLERANCE, Integration, Simulation, Verdict

ARRAYS = 30  # per roller and sample of a block, at the most at a time
# one thread of a 2024 server core, forces of eight elements once; only a guide
SECONDS_PER_EIGHT = {True: 0.1e-6, False: 0.2e-6}  # power law, other
DAMPED = 1.5  # times, dampers with them
ON_SURFACES = 3.0  # times, where these are not perfect circles
NEAR_SHARE = 0.2  # of the time in which a contact is near one of a few faults
SECONDS_PER_SAMPLE = 0.2e-6  # and element, for energies and works
JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
SAME = ("time", "inner_x", "inner_y", "inner_vx", "inner_vy", "inner_ax", "inner_ay", "roller_x", "roller_y",
        "roller_rho", "roller_theta", "inner_force", "outer_force", "energy_kinetic", "energy_contact",
        "work_external", "work_dissipated")  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class LagrangianPlan(CompiledPlan):
    """A problem and its time steps, before any refinement."""

    scene: Scene
    problem: Problem
    interval: float  # s, between samples
    n_samples: int
    least_steps: Steps  # before any refinement
    law_caution: str | None  # on law and material, which concern this run alone
    cautions: tuple[str, ...] = ()
    model_name = MODEL_NAMES["lagrange"]
    compiling_seconds = 5.0
    lacks = "rings that bend, elastic waves"

    @property
    def steps_per_sample(self) -> int:
        return self.least_steps.per_sample

    @property
    def time_step(self) -> float:
        return self.interval / self.steps_per_sample

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces that can be expected, s."""
        return critical_time_step(self.problem)

    @property
    def degrees_of_freedom(self) -> int:
        """N_b + 2, or 2 N_b + 2 where the angles are free; 2 more with a housing, 3 with a free cage."""
        more = 0 if self.problem.operation.mounting.housing is None else 2
        more += 0 if self.problem.free_cage is None else 3
        return (2 if self.problem.angles == "free" else 1) * self.problem.bearing.n_rollers + 2 + more

    @property
    def steps(self) -> int:
        return self.steps_per_sample * (self.n_samples - 1)

    @property
    def expected_seconds(self) -> float:
        """Of all steps and samples, s, unless contacts rattle."""
        problem = self.problem
        plan = self.least_steps
        near = NEAR_SHARE if plan.looks else 1.0
        times = near * plan.near * (ON_SURFACES if problem.bearing.faults else 1.0) + (1.0 - near) * plan.far
        times *= plan.sections * (self.n_samples - 1) * ceil(problem.bearing.n_rollers / 8)
        if problem.damping.acts:
            times *= DAMPED
        elif not (problem.is_damped or plan.leaps):
            times *= len(ALL_DRIFTS)
        looked_at = SECONDS_PER_SAMPLE * self.n_samples * problem.bearing.n_rollers
        steps = times * SECONDS_PER_EIGHT[isinstance(problem.laws.inner, PowerLaw)]
        return pace("lagrange") * (steps + looked_at)

    def static_hub(self) -> np.ndarray:
        problem = self.problem
        alone = replace(problem.operation, side_load=0.0, gravity=0.0, course=None, mounting=HELD)
        still = static_equilibrium(problem.bearing, alone, problem.laws, roller_mass=0.0)
        return np.array([still.x, still.y])

    def prepare(self, tell: Callable[[str], None] | None = None) -> None:
        if self.n_samples > 1:
            super().prepare(tell)

    def first_state(self) -> "LagrangianState":
        return LagrangianState(self)

    @property
    def integration(self) -> type[Integration]:
        """What takes the steps; the start alone needs none, and no compiler."""
        if self.n_samples == 1:
            return Integration
        from fem.solver.lagrangian_steps import CompiledIntegration

        return CompiledIntegration

    @property
    def remarks(self) -> tuple[str, ...]:
        return (*(() if self.law_caution is None else (self.law_caution,)), *super().remarks)

    def versions(self) -> dict[str, str]:
        return {"numpy": np.__version__, **super().versions()}

    def rows(self) -> dict[str, str]:
        options, problem = self.scene.lagrange, self.problem
        try:
            statics = static_equilibrium(problem.bearing, problem.operation, problem.laws)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None
        memory = 8e-6 * ARRAYS * (problem.bearing.n_rollers + 1) * min(self.n_samples, LARGEST_BLOCK)
        return {
            "degrees of freedom": f"{self.degrees_of_freedom} ({options.angles} angles)",
            "contact law": f"{options.law}, {problem.laws.inner.range}",
            "damping of a contact": problem.damping.words,
            **problem.operation.mounting.rows,
            "time step": f"{1e6 * self.time_step:.3g} µs, halved where contacts rattle "
            f"({self.time_step / self.critical_time_step:.2f} of the critical {1e6 * self.critical_time_step:.3g} µs)",
            "steps": f"{self.steps} for {1e3 * (self.n_samples - 1) * self.interval:g} ms",
            "samples": f"{self.n_samples}, one each {self.steps_per_sample} steps",
            "memory of a block of samples": f"{memory:.1f} MB",
            "expected time": in_words("lagrange", self.expected_seconds),
            "largest static forces": largest_loads(
                problem.bearing, statics.inner_force.max(), statics.outer_force.max()
            ),
        }


def make_plan(scene: Scene) -> LagrangianPlan:
    """Samples and steps of a scene."""
    options, numerics, bearing = scene.lagrange, scene.numerics, scene.ideal_bearing()
    interval = 1e-6 * numerics.output_interval_us
    problem = Problem(
        bearing=bearing,
        operation=scene.ideal_operation(),
        laws=contact_laws(options.law, bearing),
        start=numerics.start,
        angles=options.angles,
        damping=scene.damping.contacts,
        load_ramp=1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0,
        cage=scene.ideal_cage(),
    )
    return LagrangianPlan(
        scene=scene,
        problem=problem,
        interval=interval,
        n_samples=sample_count(scene),
        least_steps=steps_of(problem, interval),
        law_caution=caution(options.law, bearing),
        cautions=of_scene(scene, bearing, problem.operation, interval),
    )


class LagrangianState(RunState):
    """A simulation under way. At its end it begins again with half the step where contacts have rattled."""

    def __init__(self, plan: LagrangianPlan):
        super().__init__(plan)
        try:
            self._simulation = Simulation(plan.problem, plan.interval, plan.integration)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None
        self.account = EnergyAccount()
        self.missed, self._round_off = 0.0, 0.0  # J, the largest energy error so far, and what kinetic energy rounds to
        self._largest = np.zeros(3)  # N, so far: see `largest_forces`
        self._start = np.zeros(2)  # N, largest force of the first sample and within JUDGED of it

    @property
    def steps_per_sample(self) -> int:
        return self._simulation.steps_per_sample

    def take_steps(self, count: int) -> None:
        """Advance by so many samples, which nobody looks at."""
        self._simulation.advance(count)

    def advance(self, most: int) -> Block:
        simulation = self._simulation
        with self.timed():
            part = simulation.advance(most)
            samples = None if part is None else self._samples(part)
        begun, self.done = self.done, simulation.done
        if samples is not None:
            bearing = self.plan.problem.bearing
            in_place = n_in_place(bearing, THROUGH * bearing.roller_radius, samples)
            if in_place < len(samples) and not self._may_begin_again:
                self.done = begun + in_place
                return Block(samples=samples.first(in_place), trouble=self._trouble_of(samples, in_place))
            self.imbalance = float(samples.relative_error()[-1])
            self.missed = max(self.missed, float(np.max(np.abs(samples.error))))
            self._round_off = max(self._round_off, ROUND_OFF * float(np.max(np.abs(samples["energy_kinetic"]))))
            self._largest = np.fmax(self._largest, largest_forces(samples))
            self._judge_start(samples)
        if simulation.trouble is not None or self.done < self.plan.n_samples or simulation.verdict is Verdict.RESOLVED:
            return Block(samples=samples, trouble=simulation.trouble)
        if not simulation.can_be_refined:  # still worth having where contacts only rattle: see `remarks`
            too_fast = simulation.verdict is Verdict.TOO_FAST
            return Block(samples=samples, trouble=simulation.sentence if too_fast else None)
        reason = simulation.sentence.partition(";")[0]
        self.void_steps += self.progress.steps
        self.done, self.imbalance, self.account, self._largest = 0, 0.0, EnergyAccount(), np.zeros(3)
        self.missed, self._round_off = 0.0, 0.0
        self._start = np.zeros(2)
        simulation.refine()
        return Block(samples=samples, begins_again=f"{reason}; the run begins again with half of it")

    def _judge_start(self, samples: Samples) -> None:
        """Keep the largest contact forces at the start and soon after it."""
        forces = np.fmax(samples["inner_force"].max(axis=1), samples["outer_force"].max(axis=1))
        if samples["time"][0] == 0.0:
            self._start[0] = forces[0]
        self._start[1] = forces[samples["time"] <= JUDGED].max(initial=self._start[1])

    @property
    def _shocked(self) -> tuple[str, ...]:
        """A sentence where a steady load's equilibrium does not last: energy can't show a start that is wrong."""
        problem, (first, soon) = self.plan.problem, self._start
        steady = problem.operation.course is None and not problem.bearing.faults
        if problem.start != "equilibrium" or not steady or soon <= SHOCKED * first:
            return ()
        return (
            f"within {1e3 * JUDGED:g} ms of the start a contact carries {soon:.4g} N, {soon / first:.2g} times the "
            "largest static force: the motion does not begin as the equilibrium moves; leave out the beginning "
            "(check-residual --start), or give the contacts damping",
        )

    @property
    def _may_begin_again(self) -> bool:
        """Whether it will at its end, because the step is too long for what has happened so far."""
        return self._simulation.can_be_refined and self._simulation.verdict is not Verdict.RESOLVED

    def _trouble_of(self, samples: Samples, at: int) -> str:
        """Why bodies are in one another: by the step, or by the scene."""
        simulation = self._simulation
        if simulation.trouble is not None:
            return simulation.trouble
        if simulation.verdict is Verdict.TOO_FAST:
            return simulation.sentence
        return through_trouble(simulation.time_step, samples, at)

    def _samples(self, part: Trajectory) -> Samples:
        """A part of the solution by the result file's names."""
        gained = np.abs(part.energy_moved - self._simulation.first_moved_energy)
        per_time, per_roller = np.zeros(part.time.shape), np.zeros(part.roller_rho.shape)
        absent = {name: per_roller for name in ("inner_traction", "outer_traction", "roller_roller_force")}
        problem = self.plan.problem
        return self.account.samples(
            {name: getattr(part, name) for name in SAME}
            | absent
            | {
                "roller_spin": per_roller + np.reshape(part.roller_spin, (-1, 1)),
                "roller_turn": per_roller + part.roller_turn[:, None],
                "energy_elastic": per_time,
                "inner_damping_force": part.inner_damper,
                "outer_damping_force": part.outer_damper,
                "work_damping_contact": part.work_damping,
                "work_damping_bodies": per_time,
            }
            | {name: getattr(part, name) for name in problem.operation.mounting.columns}
            | ({} if part.cage is None else {f"cage_{name}": value for name, value in vars(part.cage).items()}),
            part.energy_error,
            np.fmax(part.energy_contact, gained),
        )

    @property
    def cautions(self) -> tuple[str, ...]:
        """On contacts too wide for their laws; energy off by much of what is exchanged, if little of all passed on."""
        wide = () if self.plan.scene.bearing.type == "ball" else run_cautions(self.plan.problem.bearing, self._largest)
        caution = self.plan.problem.first_state.caution
        wide = (*(() if caution is None else (caution,)), *self._shocked, *wide)
        if self.missed <= ENERGY_TOLERANCE * max(self.account.exchanged, self._round_off):
            return wide
        share = 100.0 * self.missed / max(self.account.exchanged, self._round_off)
        return (
            *wide,
            f"the energy is off by up to {share:.2g} % of the largest that was exchanged: impacts and dampers "
            f"are short beside the step of {1e6 * self._simulation.time_step:.3g} µs; "
            "single impacts are no better",
        )

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        step, critical = self._simulation.time_step, self._simulation.critical_time_step
        return super().outcome_attributes | {"time_step": step, "critical_time_step": critical}

    @property
    def remarks(self) -> tuple[str, ...]:
        simulation = self._simulation
        at_end = 0 < self.done == self.plan.n_samples
        return (simulation.sentence,) if at_end and simulation.verdict is Verdict.RATTLING else ()

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        numbers = {
            "refinements": self._simulation.refinements,
            "account": self.account.to_keep(),
            "missed": self.missed,
            "round_off": self._round_off,
        }
        return self._simulation.to_keep() | {"largest": self._largest, "start": self._start}, numbers

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        self._largest, self._start = arrays["largest"], arrays["start"]
        self._simulation.take_back(arrays, self.done, int(numbers["refinements"]))
        self.account.take_back(numbers["account"])
        self.missed, self._round_off = float(numbers["missed"]), float(numbers["round_off"])
