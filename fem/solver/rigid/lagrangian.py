"""The Lagrangian model as a solver: rigid bodies that touch by laws of their own.

Tractions and mesh energy are 0, the springs' energy is `energy_contact`; friction, mesh and time step safety of the
scene play no part. Where no steps are taken no compiler is loaded.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np

from fem.solver.compiling import pace
from fem.solver.guards import EnergyAccount, Judge, largest_forces
from fem.solver.limits import of_scene
from fem.solver.rigid.plan import RigidPlan, sections_of
from fem.solver.solver import Block, RunState, sample_count
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.laws import warning
from lagrange.errors import RunFailed
from lagrange.first_state import Problem, sampled
from lagrange.kinematics import fastest_kinematics, kinematics
from lagrange.motion import State, contact_state, housing_accelerations, hub_equations, radial_equations
from lagrange.mounting import HELD, Housing, Shaft
from lagrange.scene.scene import MODEL_NAMES, Scene
from lagrange.step_size import critical_time_step, longest_step
from lagrange.surface.deviation import Turns

TWELFTH = 1.0 / 12.0  # as `fem.kernels.bodies.TWELFTH`, which needs a compiler
KEPT = "turns", "tilts"  # of a state: no arrays
NONE_HERE = "inner_traction", "outer_traction", "roller_roller_force", "roller_turn"
WORKS = "energy_elastic", "work_external", "work_dissipated", "work_damping_contact", "work_damping_bodies"


class Moving(NamedTuple):
    """A body at t = 0 in the fixed frame: the hub or the outer ring, (2,), or rollers, (2, n_rollers)."""

    place: np.ndarray  # m
    velocity: np.ndarray  # m/s
    acceleration: np.ndarray  # m/s²
    pushed: np.ndarray  # m/s², by contacts and weight, of held rollers along their rays

    def behind(self, dt: float, mass: float = 1.0, springs: "Housing | Shaft | None" = None):
        """Place, of steps that take forces dt²/12 of the acceleration ahead, and velocity half a step, s, before.

        `springs` : whose dashpots act on the mass, kg, by the velocity at the end of that
        """
        slowed = 1.0 + 0.5 * dt * (0.0 if springs is None else springs.damping) / mass
        return self.place - TWELFTH * dt**2 * self.pushed, self.velocity - 0.5 * dt * self.acceleration / slowed


class Beginning(NamedTuple):
    """Motion at t = 0, and its sample, by the result file's names."""

    angle: np.ndarray  # (n_rollers,), rad
    hub: Moving
    rollers: Moving
    ring: Moving  # the outer one
    samples: dict[str, np.ndarray]  # (1,) and (1, n_rollers)


def beginning(problem: Problem) -> Beginning:
    """The start of a problem. RuntimeError: no equilibrium."""
    bearing, operation, held = problem.bearing, problem.operation, problem.angles == "kinematic"
    state, m = replace(problem.first_state.state, turns=Turns.rolling(bearing, operation, 0.0)), bearing.roller_mass
    touch, history = contact_state(bearing, problem.contacts, state, problem.damping), operation.history
    ring = np.array([state.ring_x, state.ring_y])
    ring_acceleration = np.array(housing_accelerations(bearing, operation, state, touch))
    radial = np.array([np.cos(state.theta), np.sin(state.theta)])
    around = np.array([-radial[1], radial[0]])
    outwards = -radial_equations(bearing, operation, state, touch, state.rho * state.theta_rate**2) / m
    aside = touch.inner_force * touch.tangential + touch.outer_force * touch.outer_slope
    along = aside / m - operation.gravity * np.cos(state.theta)
    gain = 0.0 if history is None else float(kinematics(bearing, *history.ring_speeds(0.0, 1)).cage)
    if held:
        along = ring_acceleration @ around + 2.0 * state.rho_rate * state.theta_rate + state.rho * gain
    coordinates = {name: np.asarray(value)[None] for name, value in vars(state).items() if name not in KEPT}
    alone = State(**coordinates, turns=state.turns, tilts=None if state.tilts is None else state.tilts.as_sample())
    per_roller, spin = np.zeros((1, bearing.n_rollers)), kinematics(bearing, *operation.ring_speeds).roller
    samples = sampled(problem, np.zeros(1), alone) | dict.fromkeys(NONE_HERE, per_roller)
    samples |= dict.fromkeys(WORKS, np.zeros(1)) | {"roller_spin": per_roller + spin}
    of_hub = -np.array(hub_equations(problem.acting(0.0), state, touch, 0.0, 0.0)) / operation.inner_mass
    hub = Moving(np.array([state.x, state.y]) + ring, np.array([state.x_rate, state.y_rate]), of_hub, of_hub)
    velocity = state.rho_rate * radial + state.rho * state.theta_rate * around
    whole = outwards * radial + along * around
    rollers = Moving(ring[:, None] + state.rho * radial, velocity, whole, outwards * radial if held else whole)
    of_ring = Moving(ring, np.zeros(2), ring_acceleration, ring_acceleration)
    return Beginning(angle=state.theta, hub=hub, rollers=rollers, ring=of_ring, samples=samples)


class StartState(RunState):
    """A run of the first sample alone, which takes no steps."""

    plan: "LagrangianPlan"

    def __init__(self, plan: "LagrangianPlan"):
        super().__init__(plan)
        self._judge, self._largest = Judge(plan.problem, plan.time_step), np.zeros(3)
        _ = plan.begin

    def advance(self, most):
        start = self.plan.begin.samples
        samples = EnergyAccount().samples(dict(start), np.zeros(1), start["energy_contact"])
        self._judge.meet(samples)
        self._largest, self.done = largest_forces(samples), 1
        return Block(samples=samples)

    warnings = property(lambda self: self._judge.warnings(self._largest))

    @property
    def outcome_attributes(self):
        more = {"time_step": self.plan.time_step, "critical_time_step": self._judge.critical_time_step}
        return super().outcome_attributes | more

    def to_keep(self):
        return {}, {"halvings": 0, "doublings": 0}  # as a run does that has taken its first sample

    def take_back(self, arrays, numbers):
        if self.done:
            self.advance(1)


# one thread of a 2024 server core, a step of eight elements; only a guide
SECONDS_PER_EIGHT = 0.2e-6
DAMPED = 1.5  # times, dampers with them
ON_SURFACES = 2.0  # times, where these are not perfect circles
SECONDS_PER_SAMPLE = 0.2e-6  # and element


@dataclass(frozen=True, kw_only=True)
class LagrangianPlan(RigidPlan):
    """A problem and its time steps, before any refinement."""

    problem: Problem
    law_warning: str | None  # on law and material, which concern this run alone
    reach: int = 1  # times the usual, forces up to which tables of tilted contacts go
    bearing = property(lambda self: self.problem.bearing)
    operation = property(lambda self: self.problem.operation)
    axial = property(lambda self: self.problem.axial)
    first_angle = property(lambda self: self.begin.angle)
    model_name = MODEL_NAMES["lagrange"]
    compiling_seconds = 5.0
    lacks = "bending of the rings, elastic waves"

    def changed(self, **changes):
        found = replace(self, **changes)
        found.__dict__["begin"] = self.begin
        return found

    def reaching(self, times: int) -> "LagrangianPlan":
        return self.changed(reach=times * self.reach)

    static_energy = property(lambda self: float(self.begin.samples["energy_contact"][0]))  # Of contacts at the start, J

    @property
    def critical_time_step(self):
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
    def degrees_of_freedom(self):
        """N_b + 2, or 2 N_b + 2 where the angles are free; 2 more with a housing, 3 with a free cage.

        Rollers that tilt have one more each, a hub whose slope is free two.
        """
        problem, n, hub = self.problem, self.bearing.n_rollers, self.problem.hub_tilt
        found = 2 + (2 * n if problem.angles == "free" else n) + 3 * (problem.free_cage is not None)
        found += 0 if hub is None else n + 2 * hub.is_free
        return found + 2 * (self.operation.mounting.housing is not None)

    @property
    def expected_seconds(self):
        """Of all steps and samples, s, unless contacts rattle."""
        n = self.bearing.n_rollers
        each = SECONDS_PER_EIGHT * ceil(n / 8) * (ON_SURFACES if self.bearing.faults else 1.0)
        each *= DAMPED if self.problem.damping.acts else 1.0
        return pace("lagrange") * (each * self.steps + SECONDS_PER_SAMPLE * self.n_samples * n)

    def static_hub(self):
        alone = replace(self.operation, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
        still = static_equilibrium(self.bearing, alone, self.problem.laws, roller_mass=0.0)
        return np.array([still.x, still.y])

    def prepare(self, tell=None):
        return self.first_state() if self.n_samples == 1 else super().prepare(tell)

    def first_state(self):
        if self.n_samples == 1:
            return StartState(self)
        from fem.solver.rigid.state import LagrangianState  # needs a compiler

        return LagrangianState(self)

    @property
    def notices(self):
        return (*(() if self.law_warning is None else (self.law_warning,)), *super().notices)

    def versions(self):
        return {"numpy": np.__version__, **super().versions()}

    def rows(self):
        options, problem = self.scene.lagrange, self.problem
        try:
            found = static_equilibrium(self.bearing, self.operation, problem.laws)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None
        forces = found._asdict() if self.axial is None else self.begin.samples
        return {
            "degrees of freedom": f"{self.degrees_of_freedom} ({options.angles} angles)",
            "contact law": f"{options.law}, {problem.laws.inner.range}", "damping of a contact": problem.damping.words,
            **self.operation.mounting.rows, **self.step_rows(", halved where contacts rattle"),
            **self.time_and_forces(forces["inner_force"], forces["outer_force"]),
        }  # fmt: skip


def make_plan(scene: Scene) -> LagrangianPlan:
    """Samples and steps of a scene."""
    options, numerics, bearing = scene.lagrange, scene.numerics, scene.ideal_bearing()
    interval = 1e-6 * numerics.output_interval_us
    problem = Problem(
        bearing=bearing, operation=scene.ideal_operation(), laws=contact_laws(options.law, bearing),
        start=numerics.start, angles=options.angles, damping=scene.damping.contacts,
        load_ramp=scene.load_ramp, cage=scene.ideal_cage(), axial=scene.ideal_axial(),
    )  # fmt: skip
    longest, sections = longest_step(problem), None
    if problem.damping.acts:  # contacts without dampers vibrate on after a strike
        fastest = fastest_kinematics(bearing, problem.operation)
        sections = sections_of(bearing, fastest, interval, longest, longest_step(problem, spalls=False))
    steps = ceil(interval / longest * (1.0 - 1e-12))
    return LagrangianPlan(
        scene=scene, problem=problem, n_samples=sample_count(scene),
        stride=max(1, steps) if sections is None else sections.count * sections.near, sections=sections,
        law_warning=warning(options.law, bearing), warnings=of_scene(scene, bearing, problem.operation, interval),
    )  # fmt: skip
