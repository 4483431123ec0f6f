"""The Lagrangian model as a solver: rigid bodies on contacts with laws of their own, in the time loop of rigid bodies.

Tractions and mesh energy are 0, the springs' energy is `energy_contact`. Friction, mesh and time step safety of the
scene play no part. No mesh; steps are compiled, and where none are taken no compiler is loaded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf, pi
from typing import NamedTuple

import numpy as np

from fem.quantities import largest_loads
from fem.solver.compiling import in_words, pace
from fem.solver.guards import ASTRAY, EnergyAccount, largest_forces, run_warnings
from fem.solver.rigid.plan import RigidPlan, sections_of
from fem.solver.solver import Block, Numbers, RunState, Samples, sample_count
from fem.solver.warnings import of_scene
from lagrange import Bearing, Operation, contact_laws, static_equilibrium
from lagrange.contact.laws import warning
from lagrange.errors import RunFailed
from lagrange.first_state import Problem
from lagrange.kinematics import fastest_kinematics, kinematics
from lagrange.motion import State, contact_state, housing_accelerations, hub_equations, radial_equations
from lagrange.mounting import HELD
from lagrange.samples import sampled
from lagrange.scene.scene import MODEL_NAMES, Scene
from lagrange.step_size import critical_time_step, fastest_mode, longest_step
from lagrange.surface.deviation import Turns

JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
STABLE = 1.4  # ω·step of the stiffest mode met; leapfrog is stable up to 2
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-6 of it
SURE = 1e-13  # of the kinetic energy: what it rounds to
MET = ("inner_force", "outer_force", "energy_contact", "energy_error", "least_moved", "largest_moved", "dissipated",
       "first_kinetic")  # fmt: skip


class Judge:
    """What the samples of a run have met so far, of a problem and a step, s."""

    def __init__(self, problem: Problem, step: float):
        self._problem, self._step = problem, step
        self._start = np.zeros(2)  # N, largest force of the first sample and within JUDGED of it
        self._met = dict.fromkeys(MET, 0.0) | {"least_moved": inf, "largest_moved": -inf}

    def meet(self, samples: Samples) -> None:
        """Take the next samples into account."""
        met, names = self._met, ("energy_kinetic", "energy_shaft", "energy_support")
        moved = np.sum([samples[name] for name in names if samples.get(name) is not None], axis=0)
        for name in ("inner_force", "outer_force", "energy_contact"):
            met[name] = max(met[name], float(np.abs(samples[name]).max()))
        met["energy_error"] = max(met["energy_error"], float(np.abs(samples.imbalance).max()))
        met["least_moved"] = min(met["least_moved"], float(moved.min()))
        met["largest_moved"] = max(met["largest_moved"], float(moved.max()))
        met["dissipated"] = float(samples["work_dissipated"][-1])
        forces = np.fmax(samples["inner_force"].max(axis=1), samples["outer_force"].max(axis=1))
        if samples["time"][0] == 0.0:
            met["first_kinetic"] = float(samples["energy_kinetic"][0])
            self._start[0] = forces[0]
        self._start[1] = forces[samples["time"] <= JUDGED].max(initial=self._start[1])

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces so far, s."""
        return critical_time_step(self._problem, *self._largest)

    @property
    def _largest(self) -> tuple[float, float]:
        return self._met["inner_force"], self._met["outer_force"]

    @property
    def too_fast(self) -> str | None:
        """A sentence where the stiffest mode under the largest forces so far is too fast for the step."""
        omega, step = fastest_mode(self._problem, *self._largest), self._step
        if omega * step < STABLE:
            return None
        return (
            f"the forces met make a mode of {omega / (2 * pi):.3g} Hz, too fast for the step of {step:.3g} s; set "
            f"time_step = {0.5 * STABLE / omega:.2g} or less"
        )

    @property
    def rattling(self) -> str | None:
        """A sentence where the energy errs by much of what contacts and dampers took and motion gained or lost."""
        met, step = self._met, self._step
        if met["energy_error"] <= SURE * met["first_kinetic"]:
            return None
        moved = met["largest_moved"] - met["least_moved"]
        share = met["energy_error"] / (met["energy_contact"] + moved + met["dissipated"])
        if share <= ENERGY_TOLERANCE:
            return None
        return (
            f"contacts rattle: the step of {step:.3g} s changes the energy by {100 * share:.2g} % of what the contacts "
            f"pass on; set time_step = {step / 4:.2g} or less, or add damping"
        )

    def warnings(self, largest: np.ndarray) -> tuple[str, ...]:
        """Sentences on a start that does not last, and contacts too wide for their laws; `largest` : (3,), N."""
        problem = self._problem
        of_start = problem.first_state.warning
        wide = run_warnings(problem.bearing, largest) or self._deep(largest)
        return (*(() if of_start is None else (of_start,)), *self._shocked, *wide)

    def _deep(self, largest: np.ndarray) -> tuple[str, ...]:
        """A sentence where a law that is softer than Hertz's lets bodies overlap far; `largest` : (3,), N."""
        sides = zip(("inner", "outer"), self._problem.laws, largest.tolist(), strict=False)
        depth, side = max((float(law.approach(force)), side) for side, law, force in sides)
        most = ASTRAY * self._problem.bearing.roller_radius
        if depth <= most:
            return ()
        return (
            f"the largest force makes bodies overlap by {1e3 * depth:.3g} mm on the {side} raceway, which is no small "
            f"approach (at most {1e3 * most:.3g} mm here): places and forces near such contacts are not to be trusted; "
            "take a stiffer contact law or a lighter load",
        )

    @property
    def _shocked(self) -> tuple[str, ...]:
        """A sentence where a steady load's equilibrium does not last: energy can't show a start that is wrong."""
        problem, (first, soon) = self._problem, self._start
        steady = problem.operation.is_steady and not problem.bearing.faults
        if problem.start != "equilibrium" or not steady or soon <= SHOCKED * first:
            return ()
        return (
            f"within {1e3 * JUDGED:g} ms of the start a contact carries {soon:.4g} N, {soon / first:.2g} times the "
            "largest static force: the motion does not start in equilibrium; leave out the beginning (check-residual "
            "--start), or add contact damping",
        )

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        """What a checkpoint keeps."""
        return {"start": self._start}, {"met": dict(self._met)}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        """Go on from what another judge of the same plan kept."""
        self._start = arrays["start"]
        self._met = {name: float(numbers["met"][name]) for name in MET}


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


# one thread of a 2024 server core, a step of eight elements; only a guide
SECONDS_PER_EIGHT = 0.2e-6
DAMPED = 1.5  # times, dampers with them
ON_SURFACES = 2.0  # times, where these are not perfect circles
SECONDS_PER_SAMPLE = 0.2e-6  # and element


class Ideal(NamedTuple):
    """What reading samples asks of a model and of a start."""

    bearing: Bearing
    angle: np.ndarray  # (n_rollers,), rad


@dataclass(frozen=True, kw_only=True)
class LagrangianPlan(RigidPlan):
    """A problem and its time steps, before any refinement."""

    problem: Problem
    law_warning: str | None  # on law and material, which concern this run alone
    reach: int = 1  # times the usual, forces up to which tables of tilted contacts go
    model_name = MODEL_NAMES["lagrange"]
    compiling_seconds = 5.0
    lacks = "bending of the rings, elastic waves"

    def halved(self, times: int) -> "LagrangianPlan":
        """The same with a step halved so many times."""
        finer = 2**times
        return self._beginning(
            replace(self, stride=self.stride * finer, sections=self.sections and self.sections.finer(finer))
        )

    def reaching(self, times: int) -> "LagrangianPlan":
        return self._beginning(replace(self, reach=times * self.reach))

    def _beginning(self, plan: "LagrangianPlan") -> "LagrangianPlan":
        plan.__dict__["begin"] = self.begin
        return plan

    @property
    def static_energy(self) -> float:
        """Of contacts at the start, J."""
        return float(self.begin.samples["energy_contact"][0])

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

    start = model

    @property
    def degrees_of_freedom(self) -> int:
        """N_b + 2, or 2 N_b + 2 where the angles are free; 2 more with a housing, 3 with a free cage.

        Rollers that tilt have one more each, a hub whose slope is free two.
        """
        more = 0 if self.problem.operation.mounting.housing is None else 2
        more += 0 if self.problem.free_cage is None else 3
        hub = self.problem.hub_tilt
        more += 0 if hub is None else self.problem.bearing.n_rollers + (2 if hub.is_free else 0)
        return (2 if self.problem.angles == "free" else 1) * self.problem.bearing.n_rollers + 2 + more

    @property
    def expected_seconds(self) -> float:
        """Of all steps and samples, s, unless contacts rattle."""
        problem, n = self.problem, self.problem.bearing.n_rollers
        each = SECONDS_PER_EIGHT * ceil(n / 8)
        each *= (ON_SURFACES if problem.bearing.faults else 1.0) * (DAMPED if problem.damping.acts else 1.0)
        return pace("lagrange") * (each * self.steps + SECONDS_PER_SAMPLE * self.n_samples * n)

    def static_hub(self) -> np.ndarray:
        problem = self.problem
        alone = replace(problem.operation, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
        still = static_equilibrium(problem.bearing, alone, problem.laws, roller_mass=0.0)
        return np.array([still.x, still.y])

    def prepare(self, tell: Callable[[str], None] | None = None) -> RunState:
        return self.first_state() if self.n_samples == 1 else super().prepare(tell)

    def first_state(self) -> RunState:
        if self.n_samples == 1:
            return StartState(self)
        from fem.solver.rigid.state import LagrangianState  # needs a compiler

        return LagrangianState(self)

    @property
    def notices(self) -> tuple[str, ...]:
        return (*(() if self.law_warning is None else (self.law_warning,)), *super().notices)

    def versions(self) -> dict[str, str]:
        return {"numpy": np.__version__, **super().versions()}

    def rows(self) -> dict[str, str]:
        options, problem = self.scene.lagrange, self.problem
        try:
            statics = static_equilibrium(problem.bearing, problem.operation, problem.laws)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None
        largest = statics.inner_force.max(), statics.outer_force.max()
        if problem.axial is not None:
            largest = self.begin.samples["inner_force"].max(), self.begin.samples["outer_force"].max()
        return {
            "degrees of freedom": f"{self.degrees_of_freedom} ({options.angles} angles)",
            "contact law": f"{options.law}, {problem.laws.inner.range}",
            "damping of a contact": problem.damping.words,
            **problem.operation.mounting.rows,
            **self.step_rows(", halved where contacts rattle"),
            "expected time": in_words("lagrange", self.expected_seconds),
            "largest static forces": largest_loads(problem.bearing, *largest, tilts=problem.axial is not None),
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
        axial=scene.ideal_axial(),
    )
    steps, sections = ceil(interval / longest_step(problem) * (1.0 - 1e-12)), None
    if problem.damping.acts:  # contacts without dampers vibrate on after a strike
        fastest = fastest_kinematics(bearing, problem.operation)
        sections = sections_of(bearing, fastest, interval, longest_step(problem), longest_step(problem, spalls=False))
    return LagrangianPlan(
        scene=scene,
        problem=problem,
        n_samples=sample_count(scene),
        stride=max(1, steps) if sections is None else sections.count * sections.near,
        sections=sections,
        law_warning=warning(options.law, bearing),
        warnings=of_scene(scene, bearing, problem.operation, interval),
    )
