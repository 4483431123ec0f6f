"""The Lagrangian model's bodies and contacts for the time loop of rigid bodies: arrays, steps, samples."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fem.kernels.bodies import DONE
from fem.kernels.fields import filled
from fem.kernels.isolated_contacts import Isolated, PowerConstants
from fem.kernels.lanes import WIDTH
from fem.kernels.prescribed_rollers import Prescribed
from fem.kernels.reduced_loop import advance_reduced
from fem.kernels.reduced_state import UNEVEN, Before, ReducedDrive, ReducedForces, RigidBodies
from fem.kernels.sample_kernels import CONTACT, KINETIC, N_SCALARS, WORK_DRIVE
from fem.kernels.state import Law
from fem.solver.cage_arrays import cage_state, pair_of_rigid
from fem.solver.guards import good_rows
from fem.solver.lagrangian_start import Beginning
from fem.solver.part_arrays import course_arrays, housing_of, raceway_profiles, rigid_dampers, springs_on
from fem.solver.run_arrays import changing_arrays
from fem.solver.samples import SampleReader, row_width
from fem.solver.solver import Samples
from lagrange import kinematics
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import LogarithmicLaw
from lagrange.equations import touching_distances
from lagrange.first_state import Problem
from lagrange.kinematics import turned
from lagrange.motion import State, contact_state, hub_equations, rotation_energy
from lagrange.mounting import from_outer_ring
from lagrange.surface.deviation import Turns, profiles
from lagrange.trajectory import loaded

TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken, see `reduced_kick`


class Machine(NamedTuple):
    """All arguments of the time loop."""

    bodies: RigidBodies
    compliance: Isolated
    forces: ReducedForces
    drive: ReducedDrive
    before: Before


class Steps:
    """A motion under way, half a step behind in velocity; `plan` : a `LagrangianPlan`, of its steps' length."""

    def __init__(self, plan, begin: Beginning):
        self._plan, self._begin = plan, begin
        self.machine = _machine(plan, begin)
        self._reader = SampleReader(plan)
        self._base: np.ndarray | None = None  # J, of rows: kinetic and contacts' energy to those of the first sample
        self._width = row_width(plan.problem.bearing.n_rollers, plan.scene.ideal_cage(), plan.operation.mounting)

    def named_arrays(self) -> dict[str, np.ndarray]:
        """All that a run changes and the next steps need, as views."""
        machine = self.machine
        places = {"bodies": machine.bodies, "forces": machine.forces, "drive": machine.drive}
        found: dict[str, np.ndarray] = {}
        for place, group in places.items():
            found |= changing_arrays(group, place)
        return found

    def to_keep(self) -> dict[str, np.ndarray]:
        """What a checkpoint keeps; `take_back` takes it back."""
        base = np.full(2, np.nan) if self._base is None else self._base
        return self.named_arrays() | {f"reader.{k}": v for k, v in self._reader.to_keep().items()} | {"base": base}

    def take_back(self, arrays: dict[str, np.ndarray], done: int) -> None:
        """Go on where other steps of the same plan stood after so many samples."""
        for name, own in self.named_arrays().items():
            own[...] = arrays[name]
        self._reader.take_back({name: arrays[f"reader.{name}"] for name in self._reader.to_keep()}, done)
        self._base = arrays["base"]

    def take(self, first: int, count: int) -> tuple[Samples | None, bool]:
        """The samples from one on, and whether the motion goes on; fewer, or None, where velocities are no numbers."""
        rows = np.zeros((count, self._width))
        machine = self.machine
        moving = machine.bodies, machine.compliance, machine.forces, (machine.drive,), machine.before
        status, _, _ = advance_reduced(*moving, None, first, self._plan.stride, rows)
        if status != DONE:
            rows = rows[: good_rows(rows)]
        return (self._read(rows, first) if len(rows) else None), status == DONE

    def _read(self, rows: np.ndarray, first: int) -> Samples:
        """Samples of rows: with the energy of what turns, and held rollers exactly on their rays."""
        problem = self._plan.problem
        time = self._plan.interval * np.arange(first, first + len(rows))
        turning = rotation_energy(problem.bearing, problem.operation.at(time))
        rows[:, KINETIC] += turning
        rows[:, WORK_DRIVE] += turning
        if self._base is None:
            start = self._begin.samples
            at_start = np.array([start["energy_kinetic"][0], start["energy_contact"][0]])
            self._base = at_start - rows[0, [KINETIC, CONTACT]]
        rows[:, KINETIC] += self._base[0]
        rows[:, CONTACT] += self._base[1]
        if problem.angles == "kinematic":
            self._put_on_rays(rows, time)
        samples = self._reader.read(rows)
        if problem.angles == "kinematic":
            samples["roller_theta"][:] = self._angles(time)
        self._balance(samples)
        return samples

    def _balance(self, samples: Samples) -> None:
        """Forces of the laws at the samples' own places, and the hub's accelerations by these.

        Steps take forces a little ahead, and give the hub what keeps the energy where contacts open and close.
        """
        problem, time = self._plan.problem, samples["time"]
        bearing, operation = problem.bearing, problem.operation
        x, y = from_outer_ring(samples.values, "inner")
        ring_x, ring_y = samples["inner_x"] - x, samples["inner_y"] - y
        nothing = np.zeros(samples["roller_rho"].shape)
        state = State(
            x=x, y=y, rho=samples["roller_rho"], theta=samples["roller_theta"], x_rate=samples["inner_vx"],
            y_rate=samples["inner_vy"], rho_rate=nothing, theta_rate=nothing, ring_x=ring_x, ring_y=ring_y,
            turns=Turns.rolling(bearing, operation, time[:, None]),
        )  # fmt: skip
        touch = contact_state(bearing, problem.laws, state)
        inner, outer = touch.inner_force > 0.0, touch.outer_force > 0.0
        samples["inner_damping_force"][:] = np.where(
            inner, np.maximum(samples["inner_damping_force"], -touch.inner_force), 0.0
        )
        samples["outer_damping_force"][:] = np.where(
            outer, np.maximum(samples["outer_damping_force"], -touch.outer_force), 0.0
        )
        samples["inner_force"][:] = touch.inner_force + samples["inner_damping_force"]
        samples["outer_force"][:] = touch.outer_force + samples["outer_damping_force"]
        touch = replace(touch, inner_force=samples["inner_force"])
        left = hub_equations(loaded(problem, time), state, touch, 0.0, 0.0)
        for axis, without in zip("xy", left, strict=True):
            of_cage: Any = 0.0
            if problem.free_cage is not None and problem.free_cage.guidance == "inner_ring":
                of_cage = samples[f"cage_guidance_{axis}"]
            samples[f"inner_a{axis}"][:] = -(without + of_cage) / operation.inner_mass

    def _angles(self, time: np.ndarray) -> np.ndarray:
        problem = self._plan.problem
        return self._begin.angle + np.reshape(turned(problem.bearing, problem.operation, time).cage, (-1, 1))

    def _put_on_rays(self, rows: np.ndarray, time: np.ndarray) -> None:
        n = self._plan.problem.bearing.n_rollers
        ring = np.zeros((2, len(rows), 1))
        if self.machine.bodies.housing is not None:
            column = self.machine.bodies.housing.column
            ring[:] = rows[:, [column, column + 1]].T[:, :, None]
        x, y = rows[:, N_SCALARS : N_SCALARS + n], rows[:, N_SCALARS + n : N_SCALARS + 2 * n]
        rho, theta = np.hypot(x - ring[0], y - ring[1]), self._angles(time)
        x[:], y[:] = ring[0] + rho * np.cos(theta), ring[1] + rho * np.sin(theta)


def _machine(plan, begin: Beginning) -> Machine:
    problem: Problem = plan.problem
    n = problem.bearing.n_rollers
    columns = -(-n // WIDTH) * WIDTH
    bodies = _bodies(plan, begin, columns)
    before = filled(Before, {"columns": columns})
    return Machine(bodies, _contacts(problem, columns), _forces(problem, begin, columns), _drive(plan), before)


def _bodies(plan, begin: Beginning, columns: int) -> RigidBodies:
    """Everything that moves: half a step behind in velocity, and where forces a little ahead are those of the start."""
    problem: Problem = plan.problem
    bearing, operation, dt = problem.bearing, problem.operation, plan.time_step
    n, half, ahead = bearing.n_rollers, 0.5 * dt, TWELFTH * dt**2
    centre, velocity = np.zeros((2, 2, columns))
    centre[:, :n] = begin.centre - ahead * begin.pushed
    velocity[:, :n] = begin.velocity - half * begin.acceleration
    mass, mounting = float(operation.inner_mass), operation.mounting
    ring = begin.ring - ahead * begin.ring_acceleration
    hub = begin.hub - ahead * begin.hub_acceleration
    hub_velocity = begin.hub_velocity - _gained(begin.hub_acceleration, half, mass, mounting.shaft)
    housing = housing_of(operation.mounting, bearing.outer_ring_mass, None, ring, dt, row_width(n, None))
    if housing is not None:
        housing.velocity[:] = -_gained(begin.ring_acceleration, half, housing.mass, mounting.housing)
    of_cage, cage = row_width(n, None, operation.mounting), plan.scene.ideal_cage()
    held, ideal = problem.angles == "kinematic", kinematics(bearing, 1.0)
    bodies = RigidBodies(
        hub=hub,
        hub_velocity=hub_velocity,
        centre=centre,
        velocity=velocity,
        turn=np.zeros(columns),
        spin=np.zeros(columns),
        hub_mass=mass,
        mass=float(bearing.roller_mass),
        inertia=np.inf,  # their spin is prescribed
        radius=float(bearing.roller_radius),
        vibrations=None,
        n=n,
        columns=columns,
        cage=None,
        shaft=springs_on(operation.mounting, hub, hub_velocity, np.zeros((2, 2)), mass, n),
        housing=housing,
        prescribed=Prescribed(
            spin=float(ideal.roller),
            cage=float(ideal.cage),
            first=_padded(np.array([np.cos(begin.angle), np.sin(begin.angle)]), columns) if held else None,
            force=np.zeros(columns),
            work=np.zeros(2),
            column=of_cage if held and cage is not None else -1,
        ),
    )
    if problem.free_cage is None:
        return bodies
    state = cage_state(bearing, cage, begin.angle, kinematics(bearing, operation.speed).cage, of_cage)
    state.motion[0, :2] = begin.ring
    state.motion[1, 1] = half * operation.gravity
    return bodies._replace(cage=pair_of_rigid(state, cage, bodies, float(operation.speed)))


def _gained(acceleration: np.ndarray, half: float, mass: float, springs) -> np.ndarray:
    """Velocity that a body gains in half a step, s, with its dashpot's share at the end of it."""
    return half * acceleration / (1.0 + half * (0.0 if springs is None else springs.damping) / mass)


def _padded(values: np.ndarray, columns: int) -> np.ndarray:
    return np.concatenate([values, np.zeros((2, columns - values.shape[1]))], axis=1)


def _contacts(problem: Problem, columns: int) -> Isolated:
    reach, track = touching_distances(problem.bearing)
    inner, outer = raceway_profiles(problem.bearing, columns)
    return Isolated(
        inner=_constants(problem.laws.inner),
        outer=_constants(problem.laws.outer),
        reach=float(reach),
        track=float(track),
        ring_profiles=(inner["profile"], outer["profile"]),
        roller_profiles=(inner["roller_profiles"], outer["roller_profiles"]),
    )


def _constants(law) -> PowerConstants | Law:
    """A law as kernels take it."""
    if isinstance(law, PowerLaw):
        return PowerConstants(stiffness=float(law.stiffness), exponent=float(law.exponent))
    if isinstance(law, LogarithmicLaw):  # S Q (B − ln Q) is 2S Q (½B − ½ ln Q); widths play no part
        A, B = float(2.0 * law.compliance), float(0.5 * law.level)
        return Law(A=A, B=B, Q_line=float(law.largest_force), half_width_factor=0.0, curvature=0.0)
    raise TypeError(f"{type(law).__name__}: no compiled form of such a law; see `isolated_contacts.law_force`")


def _forces(problem: Problem, begin: Beginning, columns: int) -> ReducedForces:
    """Contacts under the start's forces; what neighbours tell each other has no room."""
    uneven, nothing = profiles(problem.bearing) is not None, np.zeros((2, 0))
    found = filled(
        ReducedForces,
        {"columns": columns, "haloed": 0, "lanes": WIDTH, "neighbours": 0},
        first=np.full((2, columns), np.nan),
        tilt=nothing,
        lifted=np.zeros((2, 2, 0)),
        radiation=None,
        taken=None,
        halo=0,
        dampers=rigid_dampers(problem.damping, columns),
        **dict.fromkeys(() if uneven else UNEVEN),
    )
    for row, force in enumerate((begin.samples["inner_force"], begin.samples["outer_force"])):
        found.force[row, : problem.bearing.n_rollers] = found.estimate[row, : problem.bearing.n_rollers] = force[0]
    return found


def _drive(plan) -> ReducedDrive:
    problem: Problem = plan.problem
    return filled(
        ReducedDrive,
        {},
        speed=float(problem.operation.speed),
        gravity=float(problem.operation.gravity),
        dt=float(plan.time_step),
        radial_load=float(problem.operation.radial_load),
        ramp=float(problem.load_ramp),
        friction=0.0,
        inner_radius=float(problem.bearing.inner_raceway_radius),
        course=course_arrays(problem.bearing, problem.operation),
    )
