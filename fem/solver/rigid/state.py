"""Runs of rigid bodies in their time loop: what restarts them, their arrays, samples and warnings, what is kept."""

import hashlib
from abc import abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.kernels.bodies import TWELFTH
from fem.kernels.fields import filled
from fem.kernels.rigid.loop import advance_rigid
from fem.kernels.rigid.rays import Prescribed
from fem.kernels.rigid.state import Before, Contacts, Radiation, ReducedDrive, ReducedForces, RigidBodies
from fem.kernels.sample_kernels import CONTACT, KINETIC, N_SCALARS, WORK_DRIVE
from fem.solver.guards import n_in_place, through_trouble
from fem.solver.parts import LESS, axes_at, beyond_tables, surfaces_of
from fem.solver.rigid.arrays import (
    STILL,
    Placed,
    columns_for,
    contact_forces,
    coupling_of,
    law_constants,
    outer_drive,
    paces_of,
    rigid_bodies,
    tilted_contacts,
)
from fem.solver.rigid.lagrangian import ENERGY_TOLERANCE, Judge, LagrangianPlan
from fem.solver.row_state import RowState, changing_arrays
from fem.solver.samples import SampleReader, row_width
from fem.solver.solver import ROUND_OFF, Block, Numbers, Progress, Samples
from fem.solver.validity import add_samples, law_warning, no_sums, vibration_warning
from lagrange import Bearing
from lagrange.axial import ContactTable, SpalledTable, contact_tables
from lagrange.axial.facts import Axial
from lagrange.axial.slices import steepest_slope
from lagrange.equations import THROUGH, touching_distances
from lagrange.first_state import Problem
from lagrange.fits import growths, outer_growth
from lagrange.kinematics import kinematics, turned
from lagrange.motion import State, StatedDampers, contact_state, hub_equations, rotation_energy
from lagrange.mounting import from_outer_ring
from lagrange.step_size import expected_force
from lagrange.surface.deviation import Turns
from lagrange.tilt import Tilts

if TYPE_CHECKING:
    from fem.solver.rigid.reduced import ReducedPlan

MOST_DOUBLINGS = 4  # of the force that tables go to


class RigidState(RowState):
    """Rigid bodies and contacts. A run whose steps turn out too long restarts with half of them, one whose contacts
    leave their tables with tables up to twice the force.

    Its plan has `halved(times)`, the same with so many halvings of the step, `reaching(times)`, the same whose tables
    of contacts that tilt go to so many times the force, and `sections` of two step lengths.
    """

    most_halvings: int

    def __init__(self, plan):
        super().__init__(plan)
        self._whole, self._halvings, self._doublings = plan, 0, 0
        self._begin()

    @abstractmethod
    def arrays_of(self, plan) -> tuple[RigidBodies, tuple, ReducedForces, ReducedDrive]:
        """Bodies, contacts and their forces, and what acts from outside, at a plan's start."""

    def _begin(self) -> None:
        self.plan = plan = self._whole.reaching(2**self._doublings).halved(self._halvings)
        self.reader = SampleReader(plan)
        self._largest, self._missed, self._passed_on = np.zeros(3), 0.0, 0.0
        self.bodies, self.contacts, self.forces, self.drive = self.arrays_of(plan)
        self.drives, self.paces = paces_of(plan, self.drive)
        self._before = filled(Before, {"columns": self.bodies.columns})

    def advance(self, most: int) -> Block:
        block = super().advance(most)
        tables = () if self.contacts.tilted is None else self.contacts.tilted.tables
        if block.trouble is None and (beyond := beyond_tables(self.bodies.tilts, tables)) is not None:
            return self._further(block, beyond)
        return self.judged(block)

    @abstractmethod
    def judged(self, block: Block) -> Block:
        """The block, or the restart that it takes."""

    def _further(self, block: Block, beyond: str) -> Block:
        """The restart with tables that go further, or the end where they cannot."""
        reason = LESS if self._doublings == MOST_DOUBLINGS else self.plan.too_far(2 ** (self._doublings + 1))
        if reason is not None:
            return replace(block, trouble=f"{beyond}; {reason}")
        self._doublings += 1
        return self._again(block.samples, f"{beyond}; the run restarts with tables up to twice the force")

    @property
    def may_restart(self) -> bool:
        """Whether a halving is left."""
        return self._halvings < self.most_halvings

    def restart(self, samples: Samples | None, reason: str) -> Block:
        """The block that makes all samples so far void, of a run that is at its start again with half the step."""
        self._halvings += 1
        return self._again(samples, f"{reason}; the run restarts with half of it")

    def _again(self, samples: Samples | None, why: str) -> Block:
        self.void_steps += self.progress.steps
        self.done, self.imbalance = 0, 0.0
        self._begin()
        return Block(samples=samples, restarts=why)

    def step_rows(self, first: int, stride: int, rows: np.ndarray) -> tuple[int, int, int]:
        moving = self.bodies, self.contacts, self.forces, self._before
        return advance_rigid(moving, self.drives, self.paces, first // stride, stride, rows)

    @property
    def progress(self) -> Progress:
        found = super().progress
        if self.paces is None:
            return found
        made = int(self.paces.made.sum())
        left = round(found.steps_left * made / found.steps) if found.steps else round(self.plan.steps)
        speed = (self.void_steps + made) / found.wall if found.wall > 0.0 else 0.0
        return replace(found, steps=made, steps_left=left, speed=speed)

    @property
    def outcome_attributes(self) -> dict[str, float | str]:
        found = super().outcome_attributes | {"time_step": self.plan.time_step}
        return found if self.paces is None else found | {"long_step": self.plan.long_step}

    def named_arrays(self) -> dict[str, np.ndarray]:
        found: dict[str, np.ndarray] = {}
        for place, group in (("bodies", self.bodies), ("forces", self.forces), ("drive", self.drive)):
            found |= changing_arrays(group, place)
        return found if self.paces is None else found | {"paces.now": self.paces.now, "paces.made": self.paces.made}

    @property
    def fixed(self) -> tuple:
        """Compliances of the contacts, without surfaces, which follow from the scene that checkpoints hold."""
        return self.contacts._replace(ring_profiles=(), roller_profiles=())

    def digest(self) -> str:
        return hashlib.sha256(np.concatenate([*_numbers(self.fixed)]).tobytes()).hexdigest()

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = super().to_keep()
        return arrays, numbers | self.restarts

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        self.take_restarts(numbers)
        super().take_back(arrays, numbers)

    @property
    def restarts(self) -> Numbers:
        """How often the run has restarted, by reason."""
        return {"halvings": self._halvings, "doublings": self._doublings}

    def take_restarts(self, numbers: Numbers) -> None:
        """Stand at the start with the step and the tables that another state of the same plan had."""
        halvings, doublings = int(numbers["halvings"]), int(numbers["doublings"])
        if not (0 <= halvings <= self.most_halvings and 0 <= doublings <= MOST_DOUBLINGS):
            raise ValueError(f"{halvings} halvings of the step, {doublings} doublings of tables")
        self._halvings, self._doublings = halvings, doublings
        self._begin()


def _numbers(group: tuple):
    """Every number of a tuple and of those in it, in order."""
    for entry in group:
        if isinstance(entry, tuple):
            yield from _numbers(entry)
        else:
            yield np.ravel(np.asarray(entry, dtype=float))


LIMIT = 1e-3  # of the exchanged energy: what a run's balance may be off by
MOST_TURN = 1e6  # rad, that `lane_functions.cosine_and_sine` takes


# of the largest force in one vibration of the bodies: beyond, forces of random bearings were off by up to 6 %, beyond
# a half by up to a factor of 2; below both by 2 % at most
SHOCK, HARD_SHOCK = 0.075, 0.5
BEYOND = 1e-3  # of the largest force on the inner ring: what kicks may give beyond forces before a run says so


class ReducedState(RigidState):
    """Rigid bodies and contacts. A run whose energy will not balance to LIMIT restarts with half the step.

    What opens and closes at once is all that takes such steps: rollers that rattle without friction.
    """

    most_halvings = 6

    def arrays_of(self, plan: "ReducedPlan"):
        scene, model, operation, start, dt = plan.scene, plan.model, plan.operation, plan.start, plan.time_step
        bearing, numerics, axial, free = model.bearing, scene.numerics, scene.ideal_axial(), scene.ideal_cage()
        radial = np.array([np.cos(start.angle), np.sin(start.angle)])
        around = np.array([-radial[1], radial[0]])
        cage, half = start.kinematics.cage, 0.5 * dt if start.steady else 0.0
        placed = Placed(
            angle=start.angle,
            hub=start.hub + start.ring,
            hub_velocity=start.hub_velocity,
            # steps take forces dt²/12 of the acceleration ahead, inwards on a circle; so far out they are static ones
            centre=(1.0 + (half * cage) ** 2 / 3.0) * start.rho * radial + start.ring[:, None],
            velocity=start.rho_rate * radial + cage * start.rho * around + half * cage**2 * start.rho * radial,
            ring=start.ring,
            ring_velocity=STILL,
            cage=start.ring + plan.seat,
            cage_velocity=STILL,
        )
        inertia = float(0.5 * bearing.roller_mass * bearing.roller_radius**2)
        bodies = rigid_bodies(bearing, operation, free, placed, dt, inertia=inertia)
        bodies.spin[: bearing.n_rollers] = start.kinematics.roller
        columns, tilted = bodies.columns, None
        if axial is not None:
            bodies = bodies._replace(tilts=axes_at(bearing, operation, axial, free, start.tilts, columns))
            tilted = tilted_contacts(plan.tables, bearing, columns)
        reach, track = touching_distances(bearing)
        contacts = Contacts(
            inner=model.inner_law.constants,
            outer=model.outer_law.constants,
            reach=float(reach + model.inner_growth + model.roller_growth),
            track=float(track - model.roller_growth + model.outer_growth),
            **surfaces_of(bearing, columns),
            sag=model.sag,
            coupling=coupling_of(model, plan.relaxation_factor, plan.tangential),
            tilted=tilted,
        )
        absent, radiation = ("ahead", "cut"), None  # rollers that tilt have accounts of their own
        if tilted is None:
            absent = () if plan.strikes else ("ahead", "cut", "taken")
            known = {"inertia": plan.waves.inertia, "settling": 1.0 / plan.waves.slowest}
            radiation = filled(Radiation, {"columns": columns}, state=np.zeros(1, dtype=np.intp), **known)
        pressed, moments = (start.inner_force, start.outer_force), (start.inner_moment, start.outer_moment)
        forces = contact_forces(bearing, contacts, pressed, moments, scene.damping.contacts, absent, radiation)
        inner, roller = growths(bearing, kinematics(bearing, 1.0))
        growth = inner + roller, roller, outer_growth(bearing, kinematics(bearing, 0.0, 1.0))
        ramp = 1e-3 * numerics.load_ramp_ms if numerics.start == "rest" else 0.0
        drive = outer_drive(bearing, operation, dt, ramp, float(scene.friction_coefficient), growth)
        return bodies, contacts, forces, drive

    def _begin(self) -> None:
        super()._begin()
        self._worst = 0.0  # J, the largest energy error of samples so far
        self._hub_sums = no_sums()

    def judged(self, block: Block) -> Block:
        samples = block.samples
        lost = block.trouble is not None
        if samples is not None and len(samples):
            lost = lost or self._loses_energy(samples)
            add_samples(self._hub_sums, samples)
        if not (lost and self.may_restart):
            return block
        if self._came_apart and self._halvings and abs(self.imbalance) <= LIMIT:
            return block  # no fault of the steps: with shorter ones, too, and while energy balances
        reason = f"energy does not balance to {LIMIT:g} of what is exchanged"
        if self._came_apart:
            reason = "the bearing comes apart"
        return self.restart(samples, f"{reason} with steps of {1e6 * self.plan.time_step:.3g} µs")

    def _loses_energy(self, samples: Samples) -> bool:
        """Whether the run's energy is, or by its end will be, off by more than LIMIT of what is exchanged.

        Before the end that is taken to grow in proportion to the time, from what the load stores in contacts at rest
        where less has been exchanged: but for one of 444 random bearings, runs that end well stay 14 % below.
        """
        worst = np.fmax(np.maximum.accumulate(np.abs(samples.error)), self._worst)
        self._worst = float(worst[-1])
        if self.done == self.plan.n_samples:
            return self._worst > LIMIT * float(samples.exchanged[-1])
        share = np.arange(self.done - len(samples) + 1, self.done + 1) / self.plan.n_samples
        least = np.fmax(self.plan.static_energy, ROUND_OFF * np.abs(samples["energy_kinetic"]))
        return bool(np.any(worst * share > LIMIT * np.fmax(samples.exchanged, least)))

    @property
    def shock(self) -> float:
        """The most that a force has changed in a vibration of the bodies' own, over the largest force."""
        now = self.drives[0 if self.paces is None else self.paces.now[0]]
        rate = float(self.forces.fastest.max()) / now.dt
        return rate * slowest_vibration(self.plan.model.bearing) / max(float(self._largest.max()), 1e-30)

    @property
    def warnings(self) -> tuple[str, ...]:
        found = super().warnings
        if self.shock < SHOCK:
            return found + self._slow_hub + self._stiff_laws + self._unequal_kicks
        off = "tens of per cent" if self.shock > HARD_SHOCK else "several per cent"
        return (
            *found,
            "impacts excite elastic waves, which the reduced model represents only in part: individual peak forces may "
            f'be off by {off}; for peak forces use model = "fem"',
        )

    @property
    def _slow_hub(self) -> tuple[str, ...]:
        """A sentence where the rings' mass changes the hub's vibration."""
        plan, mounting = self.plan, self.plan.operation.mounting
        if mounting.shaft is not None or mounting.housing is not None:  # then they are not what the hub vibrates by
            return ()
        said = vibration_warning(plan.model.bearing, plan.operation.inner_mass, self._hub_sums)
        return () if said is None else (said,)

    @property
    def _stiff_laws(self) -> tuple[str, ...]:
        """A sentence where contacts became so wide that their laws are too stiff."""
        said = law_warning(self.plan.model.contacts, self._largest)
        return () if said is None else (said,)

    @property
    def _unequal_kicks(self) -> tuple[str, ...]:
        """A sentence on samples whose forces are not what the hub was given, if they are off by more than BEYOND."""
        most, largest = float(self.forces.beyond[0]), float(self._largest[0])
        if most <= BEYOND * largest or largest == 0.0:  # without a force there is nothing to compare with
            return ()
        key = "output_interval_us" if self.plan.stride == 1 else "time_step_safety"  # what makes steps shorter
        return (
            f"when contacts open or close, the energy-conserving step gives the hub up to {most:.3g} N more or less "
            f"than the contacts' forces ({100.0 * most / largest:.2g} % of the largest on the inner ring), and the "
            f"momentum balance is off by as much; lower numerics.{key}",
        )

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = super().to_keep()
        return arrays | {"hub_sums": self._hub_sums}, numbers | {"worst": self._worst}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        super().take_back(arrays, numbers)
        self._worst, self._hub_sums = float(numbers["worst"]), arrays["hub_sums"]

    @property
    def fixed(self) -> tuple:
        waves = self.forces.radiation
        return super().fixed if waves is None else (*super().fixed, waves.inertia, waves.settling)

    def check(self) -> None:
        bodies, n = self.bodies, self.bodies.n
        from_hub = np.hypot(*(bodies.centre[:, :n] - bodies.hub[:, None]))
        ring = np.zeros(2) if bodies.housing is None else bodies.housing.place
        nearest = min(from_hub.min(), np.hypot(*(bodies.centre[:, :n] - ring[:, None])).min())
        uneven = self.forces.slope is not None  # then kernels look up surfaces by how far bodies have turned
        if nearest < bodies.radius or (uneven and np.abs(bodies.turn).max() > MOST_TURN):
            raise ValueError("rollers outside the bearing, or turned too far")
        if self.forces.radiation is not None and np.any(self.forces.radiation.owed < 0.0):
            raise ValueError("contacts with a negative energy loss to waves")


def slowest_vibration(bearing: Bearing) -> float:
    """Period, s, of the slowest free vibration of a roller, or of a ring through its thickness.

    A disc's ovalling takes 5.1 radii of the dilatational wave's way at a Poisson's ratio of 0.3, by the exact
    frequency equation (its source is in the tests); a layer that is held on one side takes four thicknesses.
    """
    ways = (
        (5.1 * bearing.roller_radius, bearing.roller),
        (4.0 * (bearing.inner_raceway_radius - bearing.bore_radius), bearing.inner_ring),
        (4.0 * (bearing.outside_radius - bearing.outer_raceway_radius), bearing.outer_ring),
    )
    return max(way / material.dilatational_wave_speed for way, material in ways)


class LagrangianState(RigidState):
    """A run that restarts with half the step where contacts have rattled, or bodies gone through one another."""

    plan: LagrangianPlan

    most_halvings = 3  # before a warning instead

    def arrays_of(self, plan: LagrangianPlan):
        def gained(acceleration: np.ndarray, half: float, mass: float, springs) -> np.ndarray:
            """Velocity that a body gains in half a step, s, with its dashpot's share at the end of it."""
            return half * acceleration / (1.0 + half * (0.0 if springs is None else springs.damping) / mass)

        problem, begin, dt = plan.problem, plan.begin, plan.time_step
        bearing, operation = problem.bearing, problem.operation
        half, ahead, mounting = 0.5 * dt, TWELFTH * dt**2, operation.mounting
        ring_velocity = np.zeros(2)
        if mounting.housing is not None:
            mass = mounting.housing.mass + bearing.outer_ring_mass
            ring_velocity = -gained(begin.ring_acceleration, half, mass, mounting.housing)
        placed = Placed(
            angle=begin.angle,
            hub=begin.hub - ahead * begin.hub_acceleration,
            hub_velocity=begin.hub_velocity
            - gained(begin.hub_acceleration, half, float(operation.inner_mass), mounting.shaft),
            centre=begin.centre - ahead * begin.pushed,
            velocity=begin.velocity - half * begin.acceleration,
            ring=begin.ring - ahead * begin.ring_acceleration,
            ring_velocity=ring_velocity,
            cage=begin.ring,
            cage_velocity=np.array([0.0, half * operation.gravity]),
        )
        n, held, ideal = bearing.n_rollers, problem.angles == "kinematic", kinematics(bearing, 1.0)
        by_outer = kinematics(bearing, 0.0, 1.0)
        rays = np.zeros((2, columns_for(n)))
        rays[:, :n] = np.cos(begin.angle), np.sin(begin.angle)
        shown = held and plan.scene.ideal_cage() is not None
        prescribed = Prescribed(
            spin=float(ideal.roller),
            cage=float(ideal.cage),
            spin_by_outer=float(by_outer.roller),
            cage_by_outer=float(by_outer.cage),
            first=rays if held else None,
            force=np.zeros(columns_for(n)),
            work=np.zeros(2),
            column=row_width(n, None, mounting) if shown else -1,
        )
        of_model = {"inertia": np.inf, "prescribed": prescribed}  # their spin is prescribed
        free = None if problem.free_cage is None else plan.scene.ideal_cage()
        bodies = rigid_bodies(bearing, operation, free, placed, dt, **of_model)
        columns, axial, tilts, laws = bodies.columns, problem.axial, problem.first_state.state.tilts, (None, None)
        tilted, (reach, track) = None, touching_distances(bearing)
        if axial is None:
            laws = law_constants(problem.laws.inner), law_constants(problem.laws.outer)
        else:
            bodies = bodies._replace(tilts=axes_at(bearing, operation, axial, plan.scene.ideal_cage(), tilts, columns))
            tilted = tilted_contacts(tables_of(problem, axial, plan.reach), bearing, columns)
        contacts = Contacts(*laws, float(reach), float(track), **surfaces_of(bearing, columns), tilted=tilted)
        at_start = {name: value[0] for name, value in begin.samples.items()}
        pressed, moments = (
            tuple(at_start.get(f"{side}_{kind}") for side in ("inner", "outer")) for kind in ("force", "moment")
        )
        absent = ("taken",) if tilted is None else ("ahead", "cut")
        forces = contact_forces(bearing, contacts, pressed, moments, problem.damping, absent)
        return bodies, contacts, forces, outer_drive(bearing, operation, dt, problem.load_ramp)

    def _begin(self) -> None:
        super()._begin()
        self.judge = Judge(self.plan.problem, self.plan.time_step)
        self._base = np.full(2, np.nan)  # J, from rows' kinetic and contacts' energy to those of the first sample

    def judged(self, block: Block) -> Block:
        at_end = self.done == self.plan.n_samples and block.trouble is None
        if not (at_end or self._came_apart):
            return block
        too_fast = self.judge.too_fast
        if (trouble := too_fast or self.judge.rattling) is None:
            return block
        if self.may_restart:
            return self.restart(block.samples, trouble.partition(";")[0])
        # still worth having where contacts only rattle: see `notices`
        return block if too_fast is None else Block(samples=block.samples, trouble=too_fast)

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
        if not 0 < self.done == self.plan.n_samples or self.judge.too_fast is not None:
            return ()
        return () if (said := self.judge.rattling) is None else (said,)

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


def tables_of(
    problem: Problem, axial: Axial, times: float = 1.0
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:
    """Tables made of the slices that the reference has, up to a few times the largest static force, or `times` that."""
    bearing, laws, force = problem.bearing, (problem.laws.inner, problem.laws.outer), times * expected_force(problem)
    slope = steepest_slope(bearing, axial, problem.operation.misalignment, float(laws[0].approach(force)))
    return contact_tables(bearing, axial, laws, force, slope)
