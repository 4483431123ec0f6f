"""Runs of rigid bodies in their time loop: their arrays, what restarts them, samples and warnings, what is kept."""

import hashlib
from abc import abstractmethod
from math import inf, pi

import numpy as np

from fem.kernels.cage import Riders
from fem.kernels.columns import CONTACT, KINETIC, N_SCALARS, WORK_DRIVE
from fem.kernels.fields import at_line
from fem.kernels.lanes import WIDTH
from fem.kernels.law import Law
from fem.kernels.rigid import paces
from fem.kernels.rigid import state as kernels
from fem.kernels.rigid.loop import advance_rigid
from fem.kernels.rigid.rays import Prescribed
from fem.kernels.rigid.state import Contacts, ReducedDrive, ReducedForces, RigidBodies
from fem.kernels.tilts import TiltedForces
from fem.solver import guards, parts
from fem.solver.parts import filled
from fem.solver.rigid.plan import RigidPlan, spalls_met
from fem.solver.row_state import RowState, collect_arrays, row_width
from fem.solver.solver import ROUND_OFF, Block, Numbers
from fem.solver.start import Tables
from fem.statics.exact_statics import neighbours_of
from lagrange import Bearing
from lagrange.axial.slices import Axial, contact_tables, steepest_slope
from lagrange.contact.laws import PowerLaw
from lagrange.equations import THROUGH, touching_distances
from lagrange.first_state import Problem
from lagrange.fits import growths, outer_growth
from lagrange.kinematics import kinematics, kinematics_met, turned
from lagrange.motion import State, StatedDampers, Tilts, contact_state, hub_equations, rotation_energy
from lagrange.mounting import from_outer_ring
from lagrange.step_size import expected_force
from lagrange.surface.deviation import Turns, profiles

STILL = np.zeros(2)
BODIES = {"inner_ring": paces.ON_INNER_RING, "outer_ring": paces.ON_OUTER_RING, "inside": paces.INSIDE,
          "outside": paces.OUTSIDE}  # fmt: skip
CALM = 3e-5  # of the energy of load and strike: what a change to longer steps may miss
STEADY = 4.0  # times what rollers on their circles have of that: less is no vibration


def _columns_for(n_rollers):
    """Lanes for so many rollers, in whole registers."""
    return -(-n_rollers // WIDTH) * WIDTH


def _rigid_bodies(bearing, operation, cage, dt, placed, **of_model):
    """Everything that moves; `of_model` : fields that only the model knows.

    cage : one that moves freely
    placed : where bodies are as the loop begins, half a step behind in velocity; m and m/s from the ground: `angle`,
        (n_rollers,), rad; `hub` and `hub_velocity`, (2,); `centre` and `velocity`, (2, n_rollers); `ring` and
        `ring_velocity`, (2,), of the outer ring in its housing; `cage` and `cage_velocity`, (2,), of a free cage
    """
    n, mounting, columns = bearing.n_rollers, operation.mounting, _columns_for(bearing.n_rollers)
    hub, hub_velocity, mass = placed["hub"].copy(), placed["hub_velocity"].copy(), float(operation.inner_mass)
    housing = parts.housing_of(mounting, bearing.outer_ring_mass, None, placed["ring"], dt, row_width(n, None))
    if housing is not None:
        housing.velocity[:] = placed["ring_velocity"]
    bodies = filled(
        RigidBodies, {"columns": columns}, hub=hub, hub_velocity=hub_velocity, hub_mass=mass, housing=housing,
        shaft=parts.springs_on(mounting, hub, hub_velocity, np.zeros((2, 2)), mass, n), mass=bearing.roller_mass,
        radius=bearing.roller_radius, n=n, columns=columns, cage=None, **of_model,
    )  # fmt: skip
    bodies.centre[:, :n], bodies.velocity[:, :n] = placed["centre"], placed["velocity"]
    if cage is None:
        return bodies
    speed = kinematics(bearing, *operation.ring_speeds).cage
    state = parts.cage_state(bearing, cage, placed["angle"], speed, row_width(n, None, mounting))
    state.motion[:2, :2] = placed["cage"], placed["cage_velocity"]
    unused = {name: np.zeros_like(bodies.velocity) for name in ("node_impulse", "body_impulse")}
    riders = filled(Riders, {}, bodies, **unused, turn_kick=np.zeros_like(bodies.spin), swelling=None)
    guide = bodies.hub, bodies.hub_velocity, np.zeros(2), mass
    around = None if housing is None else (housing.place, housing.velocity, housing.impulse, housing.mass)
    return bodies._replace(cage=parts.cage_pair(state, cage, riders, guide, around, operation.speed))


def _coupling_of(model, relaxation_factor, tangential):
    """Compliances along the rings, by each roller's neighbours; `tangential` : (3,), m/N, of contacts that stick."""
    bearing, rings, columns = model.bearing, model.rings, _columns_for(model.bearing.n_rollers)
    found, at = neighbours_of(bearing, rings)
    pocket = np.arange(columns)
    pocket[: bearing.n_rollers] = np.array(bearing.pocket) - bearing.pocket[0]
    apart, compliances = 2.0 * np.pi / bearing.pockets * pocket, found._asdict()
    for name in ("along", "steep", "bent", "crossed"):  # (..., neighbours, columns) of (..., pockets)
        values = getattr(rings, name)
        compliances[name] = at_line(np.zeros((*values.shape[:-1], at.shape[0], columns)))
        compliances[name][..., : at.shape[1]] = np.where(at >= 0, values[..., at], 0.0)
    return kernels.Coupling(
        between=model.between.constants, across=model.across, relaxation_factor=relaxation_factor, **compliances,
        apart=np.array([np.cos(apart), np.sin(apart)]), tangential=tangential,
    )  # fmt: skip


def _contact_forces(bearing, contacts, forces, moments, damping, absent, radiation):
    """Contacts under a start's forces, N, and, where they tilt, moments, N m, of inner and outer ones, (n_rollers,).

    `absent` : accounts that are not kept. Where contacts are not coupled what neighbours tell each other has no room.
    """
    n, coupling, columns, halo = bearing.n_rollers, contacts.coupling, _columns_for(bearing.n_rollers), 0
    if coupling is None:
        sizes, known = {"haloed": 0, "neighbours": 0}, {"first": np.full((2, columns), np.nan)}
        known |= {"tilt": np.zeros((2, 0)), "lifted": np.zeros((2, 2, 0))}
    else:
        halo, known = int(np.abs(coupling.distance).max(initial=0)), {"along": at_line(coupling.along)}
        sizes = {"haloed": columns + 2 * halo, "neighbours": coupling.distance.size}
    sizes |= {"columns": columns, "lanes": WIDTH}
    dampers = filled(kernels.ReducedDampers, sizes, law=damping) if damping.acts else None
    around = np.arange(-halo, n + halo) % n

    def begun(name, group, sides):
        """With what contacts have at the start, and expect, where others do: in their guess."""
        for i, values in enumerate(sides):
            getattr(group, name)[i, :n] = values
            if coupling is not None:
                group.guess[i, : around.size] = values[around]
        return group

    absent += () if profiles(bearing) is not None else kernels.UNEVEN
    own = {"radiation": radiation, "halo": halo, "dampers": dampers}
    found = begun("force", filled(ReducedForces, sizes, **own, **known, **dict.fromkeys(absent)), forces)
    if coupling is None:
        found.estimate[:2, :n] = found.force[:2, :n]
    if contacts.tilted is None:
        return found
    missing = {"sunken": contacts.tilted.part, "edges": found.slope}
    missing = {name: None for name, there in missing.items() if there is None}
    tilted = begun("moment", filled(TiltedForces, sizes, **missing), moments)
    if dampers is not None:
        reach, length = bearing.inner_raceway_radius + bearing.roller_radius, bearing.roller_length
        dampers = dampers._replace(tilted=filled(kernels.TiltedDampers, sizes, over_reach=1.0 / reach, length=length))
    return found._replace(tilted=tilted, dampers=dampers)


def _paces_of(plan, drive):
    """The drive at every pace of a plan, and when which; None: there is one."""
    found, long, bearing = plan.sections, plan.long_step, plan.bearing
    if found is None:
        return (drive,), None
    spalls = list(spalls_met(bearing))
    arcs = [(middle, np.cos(min(half + found.margin / radius, pi))) for _, _, (_, middle, half), radius in spalls]
    smooth, sensor = profiles(bearing).shortest_of_waves == inf, plan.operation.mounting.sensor
    steps = {} if sensor is None else {"step": (drive.dt, long), "half_step": (0.5 * drive.dt, 0.5 * long)}
    of_sensor = {name: np.array([sensor.step(t) for t in times]) for name, times in steps.items()}
    outward = bearing.pitch_radius * np.abs(kinematics_met(bearing, plan.operation).cage).max() ** 2
    steady = STEADY * bearing.n_rollers * bearing.roller_mass * outward**2
    pace = filled(
        paces.Paces, {}, counts=np.array([found.near, found.far], dtype=np.intp), sections=found.count,
        now=np.zeros(1, dtype=np.intp), made=np.zeros(2, dtype=np.intp),
        where=np.array([(BODIES[body], spall[0] or 0) for body, _, spall, _ in spalls], dtype=np.intp),
        arcs=np.array(arcs), stiffness=2.0 * bearing.roller_mass / plan.critical_time_step**2, outward=outward,
        calm=steady + 12.0 * CALM * (plan.static_energy + found.strike) / long**2, smooth=smooth,
        **dict.fromkeys(("step", "half_step"), np.zeros((2, 2, 3))) | of_sensor,
    )  # fmt: skip
    return (drive, drive._replace(dt=float(long), looks=not smooth)), pace


def _law_constants(law):
    """A law as kernels take it."""
    if isinstance(law, PowerLaw):
        return filled(kernels.PowerConstants, {}, law)
    # S Q (B − ln Q) is 2S Q (½B − ½ ln Q); widths play no part
    return Law(2.0 * law.compliance, 0.5 * law.level, law.largest_force, half_width_factor=0.0, curvature=0.0)


def _numbers(group):
    """Every number of a tuple and of those in it, in order."""
    for entry in group:
        if isinstance(entry, tuple):
            yield from _numbers(entry)
        else:
            yield np.ravel(np.asarray(entry, dtype=float))


MOST_DOUBLINGS = 4  # of the force that tables go to


class RigidState(RowState):
    """Rigid bodies and contacts. A run whose steps turn out too long restarts with half of them, one whose contacts
    leave their tables with tables up to twice the force."""

    most_halvings: int

    def __init__(self, plan: RigidPlan):
        self._whole, self.restarts = plan, {"halvings": 0, "doublings": 0}  # how often the run has restarted
        super().__init__(plan)

    @abstractmethod
    def start_arrays(self, plan) -> None:
        """Set bodies, contacts, their forces and the drive to a plan's start, by `_assemble`."""

    def begin(self):
        self.plan = plan = self._whole.reaching(2 ** self.restarts["doublings"]).halved(self.restarts["halvings"])
        super().begin()
        self.start_arrays(plan)
        self.drives, self.paces = _paces_of(plan, self.drive)
        self._before = filled(kernels.Before, {"columns": self.bodies.columns})

    def _assemble(
        self, plan, bodies, tilts, tables, forces, moments, damping, absent, drive, radiation=None, grown=(0.0, 0.0),
        **of_contacts,
    ):  # fmt: skip
        """What bodies, contacts and drive need of a plan; `tables` None: axes stay parallel.

        `grown` : m, by which the distances of touching at the inner ring and at the outer one are larger
        """
        bearing, operation, columns, tilted = plan.bearing, plan.operation, bodies.columns, None
        if tables is not None:
            axes = parts.axes_at(bearing, operation, plan.axial, plan.scene.ideal_cage(), tilts, columns)
            bodies, (laws, rests) = bodies._replace(tilts=axes), parts.laws_of(tables)
            part = None if rests[0] is None else parts.surfaces_of(bearing, columns, of_part=True)
            known = {"tables": laws, "rests": rests, "part": part, "share": 12.0 / float(bearing.roller_length) ** 2}
            tilted = filled(kernels.TiltedContacts, {}, **known, length=bearing.roller_length)
        (reach, track), surfaces = touching_distances(bearing), parts.surfaces_of(bearing, columns)._asdict()
        touching = {"reach": float(reach + grown[0]), "track": float(track + grown[1])}
        self.bodies, self.contacts = bodies, Contacts(**touching, **surfaces, **of_contacts, tilted=tilted)
        self.forces = _contact_forces(bearing, self.contacts, forces, moments, damping, absent, radiation)
        raceway, step = bearing.inner_raceway_radius, plan.time_step
        self.drive = filled(ReducedDrive, {}, operation, **drive, dt=step, inner_radius=raceway)

    def advance(self, most):
        block = super().advance(most)
        tables = () if self.contacts.tilted is None else self.contacts.tilted.tables
        if block.trouble is not None or (beyond := parts.beyond_tables(self.bodies.tilts, tables)) is None:
            return self.judged(block)
        doublings = self.restarts["doublings"]
        reason = parts.LESS if doublings == MOST_DOUBLINGS else self.plan.too_far(2 ** (doublings + 1))
        if reason is not None:
            return block._replace(trouble=f"{beyond}; {reason}")
        return self.restart(block, f"{beyond}; the run restarts with tables up to twice the force", "doublings")

    @abstractmethod
    def judged(self, block: Block) -> Block:
        """The block, or the restart that it takes."""

    def restart(self, block: Block, why: str, way: str = "halvings") -> Block:
        """The block that makes all samples so far void, of a run that is at its start again."""
        why += "; the run restarts with half of it" if way == "halvings" else ""
        self.restarts[way] += 1
        self.void_steps += self.progress.steps
        self.done, self.imbalance = 0, 0.0
        self.begin()
        return Block(samples=block.samples, restarts=why)

    def step_rows(self, first, stride, rows):
        moving = self.bodies, self.contacts, self.forces, self._before
        return advance_rigid(moving, self.drives, self.paces, first // stride, stride, rows)

    @property
    def progress(self):
        found = super().progress
        if self.paces is None:
            return found
        made = int(self.paces.made.sum())
        left = round(found.steps_left * made / found.steps) if found.steps else round(self.plan.steps)
        speed = (self.void_steps + made) / found.wall if found.wall > 0.0 else 0.0
        return found._replace(steps=made, steps_left=left, speed=speed)

    @property
    def outcome_attributes(self):
        found = super().outcome_attributes | {"time_step": self.plan.time_step}
        return found if self.paces is None else found | {"long_step": self.plan.long_step}

    def named_arrays(self):
        every = collect_arrays({"bodies": self.bodies, "forces": self.forces, "drive": self.drive})
        of_paces = {} if self.paces is None else {"paces.now": self.paces.now, "paces.made": self.paces.made}
        return {name: array for name, (array, given) in every.items() if not given} | of_paces

    def digest(self):
        # without surfaces, which follow from the scene that checkpoints hold
        waves, fixed = self.forces.radiation, self.contacts._replace(ring_profiles=(), roller_profiles=())
        fixed = fixed if waves is None else (*fixed, waves.inertia, waves.settling)
        return hashlib.sha256(np.concatenate([*_numbers(fixed)]).tobytes()).hexdigest()

    def to_keep(self):
        arrays, numbers = super().to_keep()
        return arrays, numbers | self.restarts

    def take_back(self, arrays, numbers):
        self.take_restarts(numbers)
        super().take_back(arrays, numbers)

    def take_restarts(self, numbers: Numbers) -> None:
        """Stand at the start with the step and the tables that another state of the same plan had."""
        found = {name: int(numbers[name]) for name in self.restarts}
        if not (0 <= found["halvings"] <= self.most_halvings and 0 <= found["doublings"] <= MOST_DOUBLINGS):
            raise ValueError(f"{found['halvings']} halvings of the step, {found['doublings']} doublings of tables")
        self.restarts = found
        self.begin()


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

    def begin(self):
        super().begin()
        self.worst, self.hub_sums = np.zeros(1), np.zeros(6)  # J, the largest energy error of samples so far

    def start_arrays(self, plan):
        scene, model, start, operation, dt = plan.scene, plan.model, plan.start, plan.operation, plan.time_step
        bearing, waves, axial = model.bearing, plan.waves, plan.axial
        radial = np.array([np.cos(start.angle), np.sin(start.angle)])
        around = np.array([-radial[1], radial[0]])
        cage, half = start.kinematics.cage, 0.5 * dt if start.steady else 0.0
        placed = {
            "angle": start.angle, "hub": start.hub + start.ring, "hub_velocity": start.hub_velocity,
            # steps take forces dt²/12 of the acceleration ahead, inwards on a circle; so far out they are static ones
            "centre": (1.0 + (half * cage) ** 2 / 3.0) * start.rho * radial + start.ring[:, None],
            "velocity": start.rho_rate * radial + cage * start.rho * around + half * cage**2 * start.rho * radial,
            "ring": start.ring, "ring_velocity": STILL, "cage": start.ring + plan.seat, "cage_velocity": STILL,
        }  # fmt: skip
        inertia = 0.5 * bearing.roller_mass * bearing.roller_radius**2
        bodies = _rigid_bodies(bearing, operation, scene.ideal_cage(), dt, placed, inertia=inertia)
        bodies.spin[: bearing.n_rollers] = start.kinematics.roller
        absent, radiation = ("ahead", "cut"), None  # rollers that tilt have accounts of their own
        if axial is None:
            absent = () if plan.strikes else ("ahead", "cut", "taken")
            known = {"inertia": waves.inertia, "settling": 1.0 / waves.slowest, "state": np.zeros(1, dtype=np.intp)}
            radiation = filled(kernels.Radiation, {"columns": bodies.columns}, **known)
        inner, roller = growths(bearing, kinematics(bearing, 1.0))
        growth = inner + roller, roller, outer_growth(bearing, kinematics(bearing, 0.0, 1.0))
        history = parts.history_arrays(bearing, operation, growth)
        drive = {"ramp": scene.load_ramp, "friction": scene.friction_coefficient, "history": history}
        self._assemble(
            plan, bodies, start.tilts, plan.tables, (start.inner_force, start.outer_force),
            (start.inner_moment, start.outer_moment), scene.damping.contacts, absent, drive, radiation,
            (model.inner_growth + model.roller_growth, model.outer_growth - model.roller_growth),
            inner=model.inner_law.constants, outer=model.outer_law.constants, sag=model.sag,
            coupling=_coupling_of(model, plan.relaxation_factor, plan.tangential),
        )  # fmt: skip

    def judged(self, block):
        samples, lost = block.samples, block.trouble is not None
        if samples is not None and len(samples):
            lost = lost or self._loses_energy(samples)
            guards.add_samples(self.hub_sums, samples)
        if not lost or self.restarts["halvings"] == self.most_halvings:
            return block
        if self._out_of_place and self.restarts["halvings"] and abs(self.imbalance) <= LIMIT:
            return block  # no fault of the steps: with shorter ones, too, and while energy balances
        reason = f"energy does not balance to {LIMIT:g} of what is exchanged"
        reason = "the bearing comes apart" if self._out_of_place else reason
        return self.restart(block, f"{reason} with steps of {1e6 * self.plan.time_step:.3g} µs")

    def _loses_energy(self, samples):
        """Whether the run's energy is, or by its end will be, off by more than LIMIT of what is exchanged.

        Before the end that is taken to grow in proportion to the time, from what the load stores in contacts at rest
        where less has been exchanged: but for one of 444 random bearings, runs that end well stay 14 % below.
        """
        worst = np.fmax(np.maximum.accumulate(np.abs(samples.error)), self.worst)
        self.worst[0] = worst[-1]
        if self.done == self.plan.n_samples:
            return bool(worst[-1] > LIMIT * float(samples.exchanged[-1]))
        share = np.arange(self.done - len(samples) + 1, self.done + 1) / self.plan.n_samples
        least = np.fmax(self.plan.static_energy, ROUND_OFF * np.abs(samples["energy_kinetic"]))
        return bool(np.any(worst * share > LIMIT * np.fmax(samples.exchanged, least)))

    @property
    def shock(self) -> float:
        """The most that a force has changed in a vibration of the bodies' own, over the largest force."""
        now = self.drives[0 if self.paces is None else self.paces.now[0]]
        rate = float(self.forces.fastest.max()) / now.dt
        return rate * slowest_vibration(self.plan.bearing) / max(float(self.largest.max()), 1e-30)

    @property
    def warnings(self):
        found, plan, mounting = list(super().warnings), self.plan, self.plan.operation.mounting
        if (shock := self.shock) >= SHOCK:
            off = "tens of per cent" if shock > HARD_SHOCK else "several per cent"
            return (
                *found,
                "impacts excite elastic waves, which the reduced model represents only in part: individual peak forces "
                f'may be off by {off}; for peak forces use model = "fem"',
            )
        if mounting.shaft is None and mounting.housing is None:  # else they are what the hub vibrates by
            found.append(guards.vibration_warning(plan.bearing, plan.operation.inner_mass, self.hub_sums))
        found.append(guards.law_warning(plan.model.contacts, self.largest))
        most, largest = float(self.forces.beyond[0]), float(self.largest[0])
        if most > BEYOND * largest > 0.0:  # without a force there is nothing to compare with
            key = "output_interval_us" if plan.stride == 1 else "time_step_safety"  # what makes steps shorter
            found.append(
                f"when contacts open or close, the energy-conserving step gives the hub up to {most:.3g} N more or "
                f"less than the contacts' forces ({100.0 * most / largest:.2g} % of the largest on the inner ring), "
                f"and the momentum balance is off by as much; lower numerics.{key}"
            )
        return tuple(filter(None, found))

    def kept_arrays(self):
        return super().kept_arrays() | {"hub_sums": self.hub_sums, "worst": self.worst}

    def check(self):
        bodies, n = self.bodies, self.bodies.n
        from_hub = np.hypot(*(bodies.centre[:, :n] - bodies.hub[:, None]))
        ring = STILL if bodies.housing is None else bodies.housing.place
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

    most_halvings = 3  # before a warning instead

    def begin(self):
        super().begin()
        self.judge = guards.Judge(self.plan.problem, self.plan.time_step)
        self.base = np.full(2, np.nan)  # J, from rows' kinetic and contacts' energy to those of the first sample

    def start_arrays(self, plan):
        problem, begin, dt, cage = plan.problem, plan.begin, plan.time_step, plan.scene.ideal_cage()
        bearing, operation, axial = problem.bearing, problem.operation, problem.axial
        n, mounting = bearing.n_rollers, operation.mounting
        of_ring = 1.0 if mounting.housing is None else mounting.housing.mass + bearing.outer_ring_mass
        falling = np.array([0.0, 0.5 * dt * operation.gravity])
        placed = {"angle": begin.angle, "cage": begin.ring.place, "cage_velocity": falling}
        placed["hub"], placed["hub_velocity"] = begin.hub.behind(dt, float(operation.inner_mass), mounting.shaft)
        placed["centre"], placed["velocity"] = begin.rollers.behind(dt)
        placed["ring"], placed["ring_velocity"] = begin.ring.behind(dt, of_ring, mounting.housing)
        held, rays = problem.angles == "kinematic", np.zeros((2, _columns_for(n)))
        rays[:, :n] = np.cos(begin.angle), np.sin(begin.angle)
        by_shaft, by_outer = kinematics(bearing, 1.0), kinematics(bearing, 0.0, 1.0)
        prescribed = filled(
            Prescribed, {}, spin=by_shaft.roller, cage=by_shaft.cage, spin_by_outer=by_outer.roller,
            cage_by_outer=by_outer.cage, first=rays if held else None, force=np.zeros(rays.shape[1]), work=np.zeros(2),
            column=row_width(n, None, mounting) if held and cage is not None else -1,
        )  # fmt: skip
        free = None if problem.free_cage is None else cage
        # their spin is prescribed
        bodies = _rigid_bodies(bearing, operation, free, dt, placed, inertia=np.inf, prescribed=prescribed)
        (inner, outer), tables, absent = (None, None), None, ("ahead", "cut")
        if axial is None:
            (inner, outer), absent = map(_law_constants, problem.laws), ("taken",)
        else:
            tables = tables_of(problem, axial, plan.reach)
        at_start = {name: value[0] for name, value in begin.samples.items()}
        pressed, moments = (
            tuple(at_start.get(f"{side}_{kind}") for side in ("inner", "outer")) for kind in ("force", "moment")
        )
        ramp = {"ramp": problem.load_ramp, "friction": 0.0, "history": parts.history_arrays(bearing, operation)}
        self._assemble(
            plan, bodies, problem.first_state.state.tilts, tables, pressed, moments, problem.damping, absent, ramp,
            inner=inner, outer=outer,
        )  # fmt: skip

    def judged(self, block):
        at_end = self.done == self.plan.n_samples and block.trouble is None
        if not (at_end or self._out_of_place):
            return block
        too_fast = self.judge.too_fast
        if (trouble := too_fast or self.judge.rattling) is None:
            return block
        if self.restarts["halvings"] < self.most_halvings:
            return self.restart(block, trouble.partition(";")[0])
        # still worth having where contacts only rattle: see `notices`
        return block if too_fast is None else Block(samples=block.samples, trouble=too_fast)

    def velocity_trouble(self, step, body, n_good):
        time = self.plan.interval * (self.done + n_good)
        return f"the motion overflowed by t = {time:.4g} s; lower time_step"

    def sound_part(self, looked, trouble):
        bearing = self.plan.bearing
        self.judge.meet(looked)
        self.imbalance = float(looked.relative_error()[-1])
        in_place = guards.n_in_place(bearing, THROUGH * bearing.roller_radius, looked)
        self._out_of_place = in_place < len(looked) and trouble is None
        if self._out_of_place:
            hint = "use a lighter load, more or larger rollers or a stiffer material"
            reason = "rigid bodies have gone through one another", hint
            trouble = guards.place_trouble(bearing, self.plan.time_step, looked, in_place, *reason)
        return in_place, trouble

    @property
    def warnings(self):
        found, error, energy_scale = self.judge.warnings(self.largest), self.energy_error[0], self.energy_scale[0]
        if error > guards.ENERGY_TOLERANCE * energy_scale:
            found += (
                f"the energy balance is off by up to {100.0 * error / energy_scale:.2g} % of the largest exchanged "
                f"energy: the step of {1e6 * self.plan.time_step:.3g} µs is too long for impacts and dampers; single "
                "impacts are off by as much",
            )
        return found

    @property
    def outcome_attributes(self):
        return super().outcome_attributes | {"critical_time_step": self.judge.critical_time_step}

    @property
    def notices(self):
        if not 0 < self.done == self.plan.n_samples or self.judge.too_fast is not None:
            return ()
        return () if (said := self.judge.rattling) is None else (said,)

    def to_keep(self):
        if self.done <= 1:  # as `StartState` does, whose run may go on
            return {}, self.restarts
        arrays, numbers = super().to_keep()
        return arrays | {"to_first": self.base}, numbers | {"met": self.judge.met}

    def take_back(self, arrays, numbers):
        if self.done > 1:
            super().take_back(arrays, numbers)
            self.base[:], met = arrays["to_first"], numbers["met"]
            self.judge.met = {name: float(met[name]) for name in self.judge.met}
            return
        self.take_restarts(numbers)
        if self.done == 1:
            self.done = 0
            super(RigidState, self).advance(1)

    def read(self, rows):
        """Samples of rows: with the energy of what turns, held rollers exactly on their rays, and the start's own."""
        plan, problem, start = self.plan, self.plan.problem, self.plan.begin.samples
        time, first = plan.interval * np.arange(self.done, self.done + len(rows)), self.done == 0
        turning = rotation_energy(problem.bearing, problem.operation.at(time))
        rows[:, KINETIC] += turning
        rows[:, WORK_DRIVE] += turning
        if first:
            at_start = np.array([start["energy_kinetic"][0], start["energy_contact"][0]])
            self.base[:] = at_start - rows[0, [KINETIC, CONTACT]]
        rows[:, KINETIC] += self.base[0]
        rows[:, CONTACT] += self.base[1]
        held = problem.angles == "kinematic"
        if held:
            theta = plan.begin.angle + np.reshape(turned(problem.bearing, problem.operation, time).cage, (-1, 1))
            n, ring = problem.bearing.n_rollers, np.zeros((2, len(rows), 1))
            if self.bodies.housing is not None:
                column = self.bodies.housing.column
                ring[:] = rows[:, [column, column + 1]].T[:, :, None]
            x, y = rows[:, N_SCALARS : N_SCALARS + n], rows[:, N_SCALARS + n : N_SCALARS + 2 * n]
            rho = np.hypot(x - ring[0], y - ring[1])
            x[:], y[:] = ring[0] + rho * np.cos(theta), ring[1] + rho * np.sin(theta)
        samples = self.reader.read(rows)
        if held:
            samples["roller_theta"][:] = theta
        self._balance(samples)
        for name, value in start.items() if first else ():
            samples[name][0] = value[0]
        return samples

    def _balance(self, samples):
        """Forces of the laws at the samples' own places, and the hub's accelerations by these.

        Steps take forces a little ahead, and give the hub what keeps the energy where contacts open and close.
        """
        problem, time, tilts = self.plan.problem, samples["time"], None
        bearing, operation = problem.bearing, problem.operation
        x, y = from_outer_ring(samples.values, "inner")
        ring_x, ring_y = samples["inner_x"] - x, samples["inner_y"] - y
        nothing = np.zeros(samples["roller_rho"].shape)
        if problem.axial is not None:
            slopes = {axis: samples[f"inner_{axis}"] for axis in ("slope_x", "slope_y")}
            tilts = Tilts(tilt=samples["roller_tilt"], tilt_rate=nothing, **slopes)
        state = State(
            x=x, y=y, rho=samples["roller_rho"], theta=samples["roller_theta"], x_rate=samples["inner_vx"],
            y_rate=samples["inner_vy"], rho_rate=nothing, theta_rate=nothing, ring_x=ring_x, ring_y=ring_y,
            turns=Turns.rolling(bearing, operation, time[:, None]), tilts=tilts,
        )  # fmt: skip
        names = [f"{side}_damping_{kind}" for kind in ("force", "moment") for side in ("inner", "outer")]
        given = StatedDampers(*(samples[name] for name in names if name in samples.values))
        touch = contact_state(bearing, problem.contacts, state, given)
        recorded = {"inner_force": touch.inner_force, "outer_force": touch.outer_force}
        dampers = touch.inner_damper, touch.outer_damper
        if touch.tilted is not None:
            recorded |= {"inner_moment": touch.tilted.inner_moment, "outer_moment": touch.tilted.outer_moment}
            dampers += tuple(touch.tilted.dampers)
        recorded |= zip(names, dampers, strict=False)
        left = hub_equations(problem.acting(time), state, touch, 0.0, 0.0)
        guided = problem.free_cage is not None and problem.free_cage.guidance == "inner_ring"
        for axis, without in zip("xy", left, strict=True):
            of_cage = samples[f"cage_guidance_{axis}"] if guided else 0.0
            recorded[f"inner_a{axis}"] = -(without + of_cage) / operation.inner_mass
        for name in recorded.keys() & samples.values.keys():
            samples[name][:] = recorded[name]


def tables_of(problem: Problem, axial: Axial, times: float = 1.0) -> Tables:
    """Tables made of the slices that the reference has, up to a few times the largest static force, or `times` that."""
    bearing, laws, force = problem.bearing, problem.laws, times * expected_force(problem)
    slope = steepest_slope(bearing, axial, problem.operation.misalignment, float(laws[0].approach(force)))
    return contact_tables(bearing, axial, laws, force, slope)
