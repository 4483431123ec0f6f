"""The Lagrangian model as a solver: rigid bodies on contacts with laws of their own, in the time loop of rigid bodies.

Tractions and mesh energy are 0, the springs' energy is `energy_contact`. Friction, mesh and time step safety of the
scene play no part. No mesh; steps are compiled, and where none are taken no compiler is loaded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import ceil, inf, pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fem.errors import RunFailed
from fem.run_summary import largest_loads
from fem.solver.cautions import of_scene
from fem.solver.compiling import CompiledPlan
from fem.solver.guards import THROUGH, EnergyAccount, largest_forces, n_in_place, run_cautions, through_trouble
from fem.solver.lagrangian_start import Beginning, beginning
from fem.solver.pace import in_words, pace
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import ROUND_OFF, Block, Numbers, RunState, Samples, sample_count
from lagrange import Bearing, Operation, contact_laws, static_equilibrium
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import caution
from lagrange.first_state import Problem
from lagrange.mounting import HELD
from lagrange.scene.scene import Scene
from lagrange.scene.tables import MODEL_NAMES
from lagrange.step_size import critical_time_step, fastest_mode, longest_step

if TYPE_CHECKING:  # needs a compiler
    from fem.solver.lagrangian_steps import Steps

ARRAYS = 30  # per roller and sample of a block, at the most at a time
# one thread of a 2024 server core, a step of eight elements; only a guide
SECONDS_PER_EIGHT = {True: 0.2e-6, False: 0.2e-6}  # power law, other
DAMPED = 1.5  # times, dampers with them
ON_SURFACES = 2.0  # times, where these are not perfect circles
SECONDS_PER_SAMPLE = 0.2e-6  # and element
JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
STABLE = 1.4  # ω·step of the stiffest mode met; leapfrog is stable up to 2
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-6 of it
REFINEMENTS = 3  # halvings of the step before a warning instead
SURE = 1e-13  # of the kinetic energy: what it rounds to
MET = ("inner_force", "outer_force", "energy_contact", "energy_error", "least_moved", "largest_moved", "dissipated",
       "first_kinetic")  # fmt: skip


class Verdict(Enum):
    """How a step has resolved a motion from its start to its end, and what to say of it."""

    RESOLVED = ""
    TOO_FAST = (
        "the forces met make a mode of {frequency:.3g} Hz, too fast for the step of {step:.3g} s; "
        "set time_step = {stable_step:.2g} or less"
    )
    RATTLING = (
        "contacts rattle: the step of {step:.3g} s changes the energy by {percent:.2g} % of what the contacts pass on; "
        "set time_step = {quarter_step:.2g} or less, or add damping"
    )


class Ideal(NamedTuple):
    """What reading samples asks of a model and of a start."""

    bearing: Bearing
    angle: np.ndarray  # (n_rollers,), rad


@dataclass(frozen=True, kw_only=True)
class LagrangianPlan(CompiledPlan):
    """A problem and its time steps, before any refinement."""

    scene: Scene
    problem: Problem
    interval: float  # s, between samples
    n_samples: int
    stride: int  # steps between samples
    law_caution: str | None  # on law and material, which concern this run alone
    cautions: tuple[str, ...] = ()
    model_name = MODEL_NAMES["lagrange"]
    compiling_seconds = 5.0
    lacks = "rings that bend, elastic waves"

    @property
    def time_step(self) -> float:
        return self.interval / self.stride

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces that can be expected, s."""
        return critical_time_step(self.problem)

    @cached_property
    def begin(self) -> Beginning:
        """Errors: RunFailed, no equilibrium to start from."""
        try:
            return beginning(self.problem)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None

    @property
    def operation(self) -> Operation:
        return self.problem.operation

    @property
    def model(self) -> Ideal:
        return Ideal(self.problem.bearing, self.begin.angle)

    start, looks = model, 1

    @property
    def degrees_of_freedom(self) -> int:
        """N_b + 2, or 2 N_b + 2 where the angles are free; 2 more with a housing, 3 with a free cage."""
        more = 0 if self.problem.operation.mounting.housing is None else 2
        more += 0 if self.problem.free_cage is None else 3
        return (2 if self.problem.angles == "free" else 1) * self.problem.bearing.n_rollers + 2 + more

    @property
    def steps(self) -> int:
        return self.stride * (self.n_samples - 1)

    @property
    def expected_seconds(self) -> float:
        """Of all steps and samples, s, unless contacts rattle."""
        problem, n = self.problem, self.problem.bearing.n_rollers
        each = SECONDS_PER_EIGHT[isinstance(problem.laws.inner, PowerLaw)] * ceil(n / 8)
        each *= (ON_SURFACES if problem.bearing.faults else 1.0) * (DAMPED if problem.damping.acts else 1.0)
        return pace("lagrange") * (each * self.steps + SECONDS_PER_SAMPLE * self.n_samples * n)

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
            "samples": f"{self.n_samples}, one each {self.stride} steps",
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
        stride=max(1, ceil(interval / longest_step(problem) * (1.0 - 1e-12))),
        law_caution=caution(options.law, bearing),
        cautions=of_scene(scene, bearing, problem.operation, interval),
    )


class LagrangianState(RunState):
    """A simulation under way. At its end it begins again with half the step where contacts have rattled."""

    plan: LagrangianPlan

    def __init__(self, plan: LagrangianPlan):
        super().__init__(plan)
        self._whole, self._refinements = plan, 0
        _ = plan.begin
        self._begin()

    def _begin(self) -> None:
        self.plan = replace(self._whole, stride=self._whole.stride * 2**self._refinements)
        self.plan.__dict__["begin"] = self._whole.begin
        self._steps: Steps | None = None  # none has been taken
        self.exchanged = 0.0  # J
        self.missed, self._round_off = 0.0, 0.0  # J, the largest energy error so far, and what kinetic energy rounds to
        self._largest = np.zeros(3)  # N, so far: see `largest_forces`
        self._start = np.zeros(2)  # N, largest force of the first sample and within JUDGED of it
        self._met = dict.fromkeys(MET, 0.0) | {"least_moved": inf, "largest_moved": -inf}

    @property
    def steps_per_sample(self) -> int:
        return self.plan.stride

    @property
    def steps(self) -> "Steps":
        if self._steps is None:
            from fem.solver.lagrangian_steps import Steps

            self._steps = Steps(self.plan, self.plan.begin)
        return self._steps

    def take_steps(self, count: int) -> None:
        """Advance by so many samples, which nobody looks at."""
        self.steps.take(self.done, count)

    def advance(self, most: int) -> Block:
        with self.timed():
            samples, goes_on = self._next(most)
        plan, trouble = self.plan, None
        if not goes_on:
            time = plan.interval * (self.done + (0 if samples is None else len(samples)))
            trouble = f"the motion overflowed by t = {time:.4g} s; lower time_step"
        if samples is not None:
            bearing = plan.problem.bearing
            in_place = n_in_place(bearing, THROUGH * bearing.roller_radius, samples)
            self._meet(samples)
            if in_place < len(samples) and not self._may_begin_again:
                self.done += in_place
                return Block(samples=samples.first(in_place), trouble=trouble or self._trouble_of(samples, in_place))
            self.done += len(samples)
            self.imbalance = float(samples.relative_error()[-1])
            self.exchanged = float(samples.exchanged[-1])
            self.missed = max(self.missed, float(np.max(np.abs(samples.error))))
            self._round_off = max(self._round_off, ROUND_OFF * float(np.max(np.abs(samples["energy_kinetic"]))))
            self._largest = np.fmax(self._largest, largest_forces(samples))
            self._judge_start(samples)
        if trouble is not None or self.done < plan.n_samples or self._verdict is Verdict.RESOLVED:
            return Block(samples=samples, trouble=trouble)
        if not self._can_be_refined:  # still worth having where contacts only rattle: see `remarks`
            return Block(samples=samples, trouble=self._sentence if self._verdict is Verdict.TOO_FAST else None)
        reason = self._sentence.partition(";")[0]
        self.void_steps += self.progress.steps
        self._refinements += 1
        self.done, self.imbalance = 0, 0.0
        self._begin()
        return Block(samples=samples, begins_again=f"{reason}; the run begins again with half of it")

    def _next(self, most: int) -> tuple[Samples | None, bool]:
        """The next samples, and whether the motion goes on; the first one is the plan's, which takes no steps."""
        start = self.plan.begin.samples
        if self.done == 0:
            exchanged = start["energy_contact"]
            return EnergyAccount().samples(dict(start), np.zeros(1), exchanged), True
        if self.done == 1:
            most += 1
        samples, goes_on = self.steps.take(self.done - (self.done == 1), most)
        if self.done == 1 and samples is not None:
            samples = samples.after(1) if len(samples) > 1 else None
        return samples, goes_on

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

    def _meet(self, samples: Samples) -> None:
        """Take samples into account in what has been met."""
        met, names = self._met, ("energy_kinetic", "energy_shaft", "energy_support")
        moved = np.sum([samples[name] for name in names if samples.get(name) is not None], axis=0)
        for name in ("inner_force", "outer_force", "energy_contact"):
            met[name] = max(met[name], float(np.abs(samples[name]).max()))
        met["energy_error"] = max(met["energy_error"], float(np.abs(samples.imbalance).max()))
        met["least_moved"] = min(met["least_moved"], float(moved.min()))
        met["largest_moved"] = max(met["largest_moved"], float(moved.max()))
        met["dissipated"] = float(samples["work_dissipated"][-1])
        if samples["time"][0] == 0.0:
            met["first_kinetic"] = float(samples["energy_kinetic"][0])

    @property
    def _energy_share(self) -> float:
        """Largest energy error, of the energy that contacts and dampers took and motion gained or lost."""
        met = self._met
        if met["energy_error"] <= SURE * met["first_kinetic"]:
            return 0.0
        return met["energy_error"] / (
            met["energy_contact"] + (met["largest_moved"] - met["least_moved"]) + met["dissipated"]
        )

    @property
    def _fastest(self) -> float:
        """Angular frequency of the stiffest mode under the largest forces so far, rad/s."""
        return fastest_mode(self.plan.problem, self._met["inner_force"], self._met["outer_force"])

    @property
    def _verdict(self) -> Verdict:
        """How the step has resolved the motion so far; its last word is at the end."""
        if not self._fastest * self.plan.time_step < STABLE:
            return Verdict.TOO_FAST
        return Verdict.RESOLVED if self._energy_share <= ENERGY_TOLERANCE else Verdict.RATTLING

    @property
    def _sentence(self) -> str:
        """The verdict with its numbers."""
        omega, step = self._fastest, self.plan.time_step
        return self._verdict.value.format(
            frequency=omega / (2 * pi), step=step, stable_step=0.5 * STABLE / omega, percent=100 * self._energy_share,
            quarter_step=step / 4,
        )  # fmt: skip

    @property
    def _can_be_refined(self) -> bool:
        return self._refinements < REFINEMENTS

    @property
    def _may_begin_again(self) -> bool:
        """Whether it will at its end, because the step is too long for what has happened so far."""
        return self._can_be_refined and self._verdict is not Verdict.RESOLVED

    def _trouble_of(self, samples: Samples, at: int) -> str:
        """Why bodies are in one another: by the step, or by the scene."""
        if self._verdict is Verdict.TOO_FAST:
            return self._sentence
        return through_trouble(self.plan.time_step, samples, at)

    @property
    def cautions(self) -> tuple[str, ...]:
        """On contacts too wide for their laws; energy off by much of what is exchanged, if little of all passed on."""
        wide = () if self.plan.scene.bearing.type == "ball" else run_cautions(self.plan.problem.bearing, self._largest)
        caution = self.plan.problem.first_state.caution
        wide = (*(() if caution is None else (caution,)), *self._shocked, *wide)
        if self.missed <= ENERGY_TOLERANCE * max(self.exchanged, self._round_off):
            return wide
        share = 100.0 * self.missed / max(self.exchanged, self._round_off)
        return (
            *wide,
            f"the energy is off by up to {share:.2g} % of the largest that was exchanged: impacts and dampers "
            f"are short beside the step of {1e6 * self.plan.time_step:.3g} µs; "
            "single impacts are no better",
        )

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        largest = (self._met["inner_force"], self._met["outer_force"]) if self.done else ()
        critical = critical_time_step(self.plan.problem, *largest)
        return super().outcome_attributes | {"time_step": self.plan.time_step, "critical_time_step": critical}

    @property
    def remarks(self) -> tuple[str, ...]:
        at_end = 0 < self.done == self.plan.n_samples
        return (self._sentence,) if at_end and self._verdict is Verdict.RATTLING else ()

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        numbers = {
            "refinements": self._refinements,
            "exchanged": self.exchanged,
            "met": dict(self._met),
            "missed": self.missed,
            "round_off": self._round_off,
        }
        arrays = {"largest": self._largest, "start": self._start}
        return arrays | (self.steps.to_keep() if self.done > 1 else {}), numbers

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        refinements = int(numbers["refinements"])
        if not 0 <= refinements <= REFINEMENTS:
            raise ValueError(f"{refinements} refinements")
        self._refinements = refinements
        self._begin()
        self._largest, self._start = arrays["largest"], arrays["start"]
        self._met = {name: float(numbers["met"][name]) for name in MET}
        if self.done > 1:
            self.steps.take_back(arrays, self.done)
        self.exchanged = float(numbers["exchanged"])
        self.missed, self._round_off = float(numbers["missed"]), float(numbers["round_off"])
