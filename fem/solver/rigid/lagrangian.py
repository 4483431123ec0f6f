"""Plans of rigid bodies in one time loop, without a compiler: two step lengths, and the Lagrangian model.

Bearings with spalls take steps of two lengths. The Lagrangian model's rigid bodies touch by laws of their own:
tractions and mesh energy are 0, the springs' energy is `energy_contact`; friction, mesh and time step safety of the
scene play no part. Where no steps are taken no compiler is loaded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf, pi
from typing import NamedTuple

import numpy as np

from fem.quantities import largest_loads
from fem.solver.compiling import CompiledPlan, in_words, pace
from fem.solver.guards import ASTRAY, EnergyAccount, largest_forces, run_warnings
from fem.solver.limits import of_scene
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import Block, Numbers, RunState, Samples, sample_count
from lagrange import Bearing, Kinematics, contact_laws, static_equilibrium
from lagrange.contact.laws import warning
from lagrange.errors import RunFailed
from lagrange.first_state import Problem, sampled
from lagrange.kinematics import fastest_kinematics, kinematics, roller_angles
from lagrange.motion import State, contact_state, housing_accelerations, hub_equations, radial_equations
from lagrange.mounting import HELD, Housing, Shaft
from lagrange.scene.scene import MODEL_NAMES, Scene
from lagrange.step_size import critical_time_step, fastest_mode, longest_step
from lagrange.surface.deviation import Turns, profiles

TWELFTH = 1.0 / 12.0  # as `fem.kernels.bodies.TWELFTH`, which needs a compiler
ARRAYS = 30  # per roller and sample of a block, at the most at a time
WAY = 0.02  # of a spall with its edges, that contacts go in a section at most: what is looked at no more often
REACH = 2.0  # sections' ways, from which on a contact is near
WORTH = 0.7  # of the steps of one length, that those of two must come down to
AFTER = 1.3  # times the way near edges: steps stay short while strikes die away
INSTANTS = 400  # of a turn of the cage, by which the share of short steps is found


@dataclass(frozen=True, kw_only=True)
class Sections:
    """Steps of one length each."""

    count: int  # of a row
    near: int  # steps of a section near edges, or while strikes die away
    far: int  # of any other
    share: float  # of sections near edges, about
    margin: float  # m, beyond edges, from which on contacts are near
    strike: float  # J, of a roller that falls into a spall

    mean = property(lambda self: self.share * self.near + (1.0 - self.share) * self.far)  # Steps of a section, about


def sections_of(bearing: Bearing, ideal: Kinematics, row: float, short: float, long: float) -> Sections | None:
    """How rows of a time, s, are cut; None: steps of one length do as well.

    ideal : at the fastest speed
    short, long : s, the longest steps near edges and elsewhere
    """
    arcs, turning = list(spalls_met(bearing)), abs(ideal.cage - ideal.outer_ring)
    speed = turning * bearing.outer_raceway_radius
    if not arcs or speed == 0.0 or short >= long:
        return None
    fall = max(np.abs(np.diff(profile.coefficients)).max() / profile.spacing for _, profile, _, _ in arcs) * speed
    ways = (2.0 * half * radius for _, _, (_, _, half), radius in arcs)
    count = ceil(row / max(WAY * min(ways) / speed, long))
    section = row / count
    steps, margin = [ceil(section / step * (1.0 - 1e-12)) for step in (short, long)], REACH * section * speed
    # share of the time in which a contact is near an edge, of rollers that roll
    time = np.arange(INSTANTS)[:, None] / INSTANTS * (2.0 * pi / turning)
    at = roller_angles(bearing, 0.0) + ideal.cage * time
    contact = {
        "inner_ring": at - ideal.shaft * time, "outer_ring": at - ideal.outer_ring * time,
        "inside": at + pi - ideal.roller * time, "outside": at - ideal.roller * time,
    }  # fmt: skip
    near = np.zeros(INSTANTS, dtype=bool)
    for body, _, (roller, middle, half), radius in arcs:
        met = contact[body] if roller is None else contact[body][:, roller, None]
        away = np.abs(np.mod(met - middle + pi, 2.0 * pi) - pi)
        near |= np.any(away < half + margin / radius, axis=1)
    share, strike = min(1.0, AFTER * float(near.mean())), float(0.5 * bearing.roller_mass * fall**2)
    found = Sections(count=count, near=steps[0], far=steps[1], share=share, margin=margin, strike=strike)
    return found if found.mean <= WORTH * found.near else None


def spalls_met(bearing: Bearing):
    """Body, profile, (roller, middle and half, rad), radius, m, of every spall in every contact that it comes into."""
    if (surfaces := profiles(bearing)) is None:
        return
    bodies = (
        ("inner_ring", surfaces.inner_ring, bearing.inner_raceway_radius),
        ("outer_ring", surfaces.outer_ring, bearing.outer_raceway_radius),
        ("inside", surfaces.rollers_inside, bearing.roller_radius),
        ("outside", surfaces.rollers_outside, bearing.roller_radius),
    )
    for body, profile, radius in bodies:
        for spall in () if profile is None else profile.spalls:
            yield body, profile, spall, radius


@dataclass(frozen=True, kw_only=True)
class RigidPlan(CompiledPlan):
    """A plan for the time loop of rigid bodies: steps of one length, or of two where spalls are.

    It has `bearing`, `operation`, `axial` (None: axes stay parallel) and `first_angle`, (n_rollers,), rad; and
    `reaching(times)`, the same whose tables of contacts that tilt go to so many times the force.
    """

    scene: Scene
    n_samples: int
    stride: int  # steps between samples, the shortest ones
    looks: int = 1  # at the energy per sample
    sections: Sections | None  # of two step lengths; None: of one
    warnings: tuple[str, ...] = ()
    unwatched = inf  # steps between two looks at the most

    def changed(self, **changes):
        """The same but for these."""
        return replace(self, **changes)

    def halved(self, times: int):
        """The same with a step halved so many times, and looks that are frequent enough."""
        finer, looks, stride, cut = 2**times, self.looks, self.stride * 2**times, self.sections
        while stride > looks * self.unwatched and finer > 1:  # and divide the stride all the way
            looks, finer = 2 * looks, finer // 2
        cut = cut and replace(cut, near=finer * cut.near, far=finer * cut.far)
        return self.changed(stride=stride, looks=looks, sections=cut)

    def too_far(self, times: int) -> str | None:
        """Why tables of contacts that tilt can't go to so many times the force, and what to do; None: they can."""
        return None

    time_step = property(lambda self: self.interval / self.stride)

    @property
    def long_step(self) -> float:
        """Away from edges of spalls, s."""
        cut = self.sections
        return self.time_step if cut is None else self.interval / (self.looks * cut.count * cut.far)

    @property
    def steps(self) -> int:
        """Of the run; of two lengths, about."""
        cut = self.sections
        return round((self.stride if cut is None else self.looks * cut.count * cut.mean) * (self.n_samples - 1))

    def step_rows(self, more: str = "") -> dict[str, str]:
        """What --dry-run shows of the steps; `more` : on their length."""
        critical, step, about, most = self.critical_time_step, self.long_step, "", ""
        length = f"{1e6 * step:.3g} µs{more} ({step / critical:.2f} of the critical {1e6 * critical:.3g} µs)"
        if self.sections is not None:
            about, most = "about ", " at most"
            length += f", {1e6 * self.time_step:.3g} µs near edges and until impacts have decayed"
        block = 8e-6 * ARRAYS * (self.bearing.n_rollers + 1) * min(self.n_samples, LARGEST_BLOCK)
        return {
            "time step": length,
            "steps": f"{about}{self.steps} for {1e3 * (self.n_samples - 1) * self.interval:g} ms",
            "samples": f"{self.n_samples}, one every {self.stride} steps{most}",
            "memory of a block of samples": f"{block:.1f} MB",
        }


JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
STABLE = 1.4  # ω·step of the stiffest mode met; leapfrog is stable up to 2
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-6 of it
SURE = 1e-13  # of the kinetic energy: what it rounds to
MET = ("inner_force", "outer_force", "energy_contact", "energy_error", "least_moved", "largest_moved", "dissipated",
       "first_kinetic", "first_force", "soon_force")  # fmt: skip


class Judge:
    """What the samples of a run have met so far, of a problem and a step, s."""

    def __init__(self, problem: Problem, step: float):
        self._problem, self._step = problem, step
        # forces, N: the largest, of the first sample, and within JUDGED of it; energies, J
        self.met = dict.fromkeys(MET, 0.0) | {"least_moved": inf, "largest_moved": -inf}

    def meet(self, samples: Samples) -> None:
        """Take the next samples into account."""
        met, names = self.met, ("energy_kinetic", "energy_shaft", "energy_support")
        moved = np.sum([samples[name] for name in names if samples.get(name) is not None], axis=0)
        forces = np.fmax(samples["inner_force"].max(axis=1), samples["outer_force"].max(axis=1))
        for name in ("inner_force", "outer_force", "energy_contact"):
            met[name] = max(met[name], float(np.abs(samples[name]).max()))
        met["energy_error"] = max(met["energy_error"], float(np.abs(samples.imbalance).max()))
        met["least_moved"] = min(met["least_moved"], float(moved.min()))
        met["largest_moved"] = max(met["largest_moved"], float(moved.max()))
        met["dissipated"] = float(samples["work_dissipated"][-1])
        if samples["time"][0] == 0.0:
            met["first_kinetic"], met["first_force"] = float(samples["energy_kinetic"][0]), float(forces[0])
        met["soon_force"] = float(forces[samples["time"] <= JUDGED].max(initial=met["soon_force"]))

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces so far, s."""
        return critical_time_step(self._problem, self.met["inner_force"], self.met["outer_force"])

    @property
    def too_fast(self) -> str | None:
        """A sentence where the stiffest mode under the largest forces so far is too fast for the step."""
        omega = fastest_mode(self._problem, self.met["inner_force"], self.met["outer_force"])
        if omega * self._step < STABLE:
            return None
        return (
            f"the forces met make a mode of {omega / (2 * pi):.3g} Hz, too fast for the step of {self._step:.3g} s; "
            f"set time_step = {0.5 * STABLE / omega:.2g} or less"
        )

    @property
    def rattling(self) -> str | None:
        """A sentence where the energy errs by much of what contacts and dampers took and motion gained or lost."""
        met, step = self.met, self._step
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
        problem, first, soon = self._problem, self.met["first_force"], self.met["soon_force"]
        bearing, found = problem.bearing, [problem.first_state.warning]
        steady = problem.operation.is_steady and not bearing.faults
        if problem.start == "equilibrium" and steady and soon > SHOCKED * first:  # energy can't show a wrong start
            found.append(
                f"within {1e3 * JUDGED:g} ms of the start a contact carries {soon:.4g} N, "
                f"{soon / first if first else inf:.2g} times the largest static force: the motion does not "
                "start in equilibrium; leave out the beginning (check-residual --start), or add contact damping"
            )
        # a law that is softer than Hertz's lets bodies overlap far
        sides = zip(("inner", "outer"), problem.laws, largest.tolist(), strict=False)
        depth, side = max((float(law.approach(force)), side) for side, law, force in sides)
        most, wide = ASTRAY * bearing.roller_radius, run_warnings(bearing, largest)
        if not wide and depth > most:
            found.append(
                f"the largest force makes bodies overlap by {1e3 * depth:.3g} mm on the {side} raceway, which is no "
                f"small approach (at most {1e3 * most:.3g} mm here): places and forces near such contacts are not to "
                "be trusted; take a stiffer contact law or a lighter load"
            )
        return (*(sentence for sentence in found if sentence), *wide)


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
    place, velocity = (
        ring[:, None] + state.rho * radial,
        state.rho_rate * radial + state.rho * state.theta_rate * around,
    )
    pushed = outwards * radial + (0.0 if held else 1.0) * along * around
    rollers = Moving(place, velocity, outwards * radial + along * around, pushed)
    of_ring = Moving(ring, np.zeros(2), ring_acceleration, ring_acceleration)
    return Beginning(angle=state.theta, hub=hub, rollers=rollers, ring=of_ring, samples=samples)


class StartState(RunState):
    """A run of the first sample alone, which takes no steps."""

    plan: "LagrangianPlan"

    def __init__(self, plan: "LagrangianPlan"):
        super().__init__(plan)
        self._judge, self._largest = Judge(plan.problem, plan.time_step), np.zeros(3)
        _ = plan.begin

    def advance(self, most: int) -> Block:
        start = self.plan.begin.samples
        samples = EnergyAccount().samples(dict(start), np.zeros(1), start["energy_contact"])
        self._judge.meet(samples)
        self._largest, self.done = largest_forces(samples), 1
        return Block(samples=samples)

    warnings = property(lambda self: self._judge.warnings(self._largest))

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        more = {"time_step": self.plan.time_step, "critical_time_step": self._judge.critical_time_step}
        return super().outcome_attributes | more

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        return {}, {"halvings": 0, "doublings": 0}  # as a run does that has taken its first sample

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
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

    def changed(self, **changes) -> "LagrangianPlan":
        found = replace(self, **changes)
        found.__dict__["begin"] = self.begin
        return found

    def reaching(self, times: int) -> "LagrangianPlan":
        return self.changed(reach=times * self.reach)

    static_energy = property(lambda self: float(self.begin.samples["energy_contact"][0]))  # Of contacts at the start, J

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
    def degrees_of_freedom(self) -> int:
        """N_b + 2, or 2 N_b + 2 where the angles are free; 2 more with a housing, 3 with a free cage.

        Rollers that tilt have one more each, a hub whose slope is free two.
        """
        problem, n, hub = self.problem, self.bearing.n_rollers, self.problem.hub_tilt
        found = 2 + (2 * n if problem.angles == "free" else n) + (0 if problem.free_cage is None else 3)
        found += 0 if hub is None else n + (2 if hub.is_free else 0)
        return found + (0 if self.operation.mounting.housing is None else 2)

    @property
    def expected_seconds(self) -> float:
        """Of all steps and samples, s, unless contacts rattle."""
        n, damped = self.bearing.n_rollers, self.problem.damping.acts
        each = SECONDS_PER_EIGHT * ceil(n / 8) * (ON_SURFACES if self.bearing.faults else 1.0)
        each *= DAMPED if damped else 1.0
        return pace("lagrange") * (each * self.steps + SECONDS_PER_SAMPLE * self.n_samples * n)

    def static_hub(self) -> np.ndarray:
        alone = replace(self.operation, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
        still = static_equilibrium(self.bearing, alone, self.problem.laws, roller_mass=0.0)
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
        options, problem, tilts = self.scene.lagrange, self.problem, self.axial is not None
        try:
            found = static_equilibrium(self.bearing, self.operation, problem.laws)
        except RuntimeError as error:
            raise RunFailed(str(error)) from None
        forces = vars(found) if not tilts else self.begin.samples
        largest = forces["inner_force"].max(), forces["outer_force"].max()
        return {
            "degrees of freedom": f"{self.degrees_of_freedom} ({options.angles} angles)",
            "contact law": f"{options.law}, {problem.laws.inner.range}", "damping of a contact": problem.damping.words,
            **self.operation.mounting.rows, **self.step_rows(", halved where contacts rattle"),
            "expected time": in_words("lagrange", self.expected_seconds),
            "largest static forces": largest_loads(self.bearing, *largest, tilts=tilts),
        }  # fmt: skip


def make_plan(scene: Scene) -> LagrangianPlan:
    """Samples and steps of a scene."""
    options, numerics, bearing = scene.lagrange, scene.numerics, scene.ideal_bearing()
    interval = 1e-6 * numerics.output_interval_us
    problem = Problem(
        bearing=bearing, operation=scene.ideal_operation(), laws=contact_laws(options.law, bearing),
        start=numerics.start, angles=options.angles, damping=scene.damping.contacts,
        load_ramp=1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0, cage=scene.ideal_cage(),
        axial=scene.ideal_axial(),
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
