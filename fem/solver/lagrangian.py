"""The Lagrangian model as a solver: rigid bodies on contacts with laws of their own, in the time loop of rigid bodies.

Tractions and mesh energy are 0, the springs' energy is `energy_contact`. Friction, mesh and time step safety of the
scene play no part. No mesh; steps are compiled, and where none are taken no compiler is loaded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np

from fem.errors import RunFailed
from fem.run_summary import largest_loads
from fem.solver.lagrangian_start import Beginning, StartState, beginning
from fem.solver.pace import in_words, pace
from fem.solver.sections import RigidPlan, sections_of
from fem.solver.solver import RunState, sample_count
from fem.solver.warnings import of_scene
from lagrange import Bearing, Operation, contact_laws, static_equilibrium
from lagrange.contact.laws import PowerLaw, warning
from lagrange.first_state import Problem
from lagrange.kinematics import fastest_kinematics
from lagrange.mounting import HELD
from lagrange.scene.scene import Scene
from lagrange.scene.tables import MODEL_NAMES
from lagrange.step_size import critical_time_step, longest_step

# one thread of a 2024 server core, a step of eight elements; only a guide
SECONDS_PER_EIGHT = {True: 0.2e-6, False: 0.2e-6}  # power law, other
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
    lacks = "rings that bend, elastic waves"

    def halved(self, times: int) -> "LagrangianPlan":
        """The same with a step halved so many times."""
        finer = 2**times
        return self._beginning(
            replace(self, stride=self.stride * finer, sections=self.sections and self.sections.finer(finer))
        )

    def reaching(self, times: int) -> "LagrangianPlan":
        return self._beginning(replace(self, reach=times * self.reach))

    def _beginning(self, plan: "LagrangianPlan") -> "LagrangianPlan":
        """Another plan that begins as this one."""
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
        each = SECONDS_PER_EIGHT[isinstance(problem.laws.inner, PowerLaw)] * ceil(n / 8)
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
        from fem.solver.lagrangian_state import LagrangianState  # needs a compiler

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
