"""A forward solution by compiled steps, from sample to sample: how a run is cut into parts changes no bit of it.

`fem.solver.lagrangian_steps` takes the steps: without damping a composition of fourth order that is symplectic, so the
energy doesn't drift (Blanes and Moan's Runge-Kutta-Nyström scheme of six stages, J. Comput. Appl. Math. 142, 2002);
with damping the second-order leapfrog. `lagrange.simulate` is their reference.
"""

from dataclasses import dataclass, replace
from enum import Enum
from math import pi
from typing import Any, NamedTuple

import numpy as np

from lagrange.cage_motion import CageRows, first_row, row_width
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.motion import State
from lagrange.step_size import (
    DAMPED_STABLE,
    STABLE,
    STEP,
    Steps,
    critical_time_step,
    fastest_mode,
    near_faults,
    steps_of,
)
from lagrange.surface.deviation import Turns
from lagrange.trajectory import Trajectory, energy_of, loaded, quantities

ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-5 of it
REFINEMENTS = 3  # halvings of the step before a warning instead
ROUND_OFF = 1e-13  # of the kinetic energy


TURN = 2.0 * np.pi
# of the first sample, see `Completion.read`; of all samples so far: the largest, or what the name says; J and N
FIRST = np.dtype([(name, float) for name in ("lift", "pull", "swing", "kinetic", "moved", "energy", "turning")])
MET = np.dtype([(name, float) for name in ("inner_force", "outer_force", "energy_contact", "energy_error",
                                           "least_moved", "largest_moved", "dissipated")])  # fmt: skip
# Blanes and Moan 2002, RKN scheme of order 4 with six stages: kicks b, drifts a, of which half are independent
KICKS = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)
DRIFTS = (0.245298957184271, 0.604872665711080)
ALL_KICKS = (*KICKS, 1.0 - 2.0 * sum(KICKS), *KICKS[::-1])
LEAP_KICKS, LEAP_DRIFTS = (0.5, 0.5), (1.0,)  # of second order; better for its costs where steps follow a profile
ALL_DRIFTS = (*DRIFTS, 0.5 - sum(DRIFTS), 0.5 - sum(DRIFTS), *DRIFTS[::-1])
MOTION = "hub", "elements", "works", "housing"  # of `Integration.memory`
OF_CAGE = "cage."  # begins names in it of a free cage's arrays, which kinds of steps have of their own
FARTHEST = 1e50  # m and m/s: energies of such a motion are still numbers


class Packed(NamedTuple):
    """Hub z, ż, complex, in a housing of it and of the outer ring, (2,); elements q, q̇, (n_rollers,)."""

    z: complex | np.ndarray
    z_rate: complex | np.ndarray
    q: np.ndarray
    q_rate: np.ndarray


class System:
    """The coordinates in which steps are taken, beside the hub z = x + iy.

    With kinematic angles q = (ρ_1 … ρ_N), real; with free ones the elements are complex too, in Cartesian coordinates,
    so that no force depends on a velocity. In a housing that moves z has two entries, the hub from the ring's centre
    and the ring, and all other places are from there.
    """

    def __init__(self, problem: Problem):
        self.problem, bearing, housing = problem, problem.bearing, problem.operation.mounting.housing
        self.n, self.mass = bearing.n_rollers, bearing.roller_mass
        self.holds_angles = problem.angles == "kinematic"
        self.dtype = float if self.holds_angles else complex
        self.ring_mass = np.inf if housing is None else housing.mass + bearing.outer_ring_mass
        self.ideal = kinematics(bearing, problem.operation.speed)
        self.angles = roller_angles(bearing, problem.operation.first_roller_angle)

    def pack(self, state: State) -> Packed:
        z: Any = complex(state.x, state.y)
        z_rate: Any = complex(state.x_rate, state.y_rate)
        if np.isfinite(self.ring_mass):
            z = np.array([z, complex(state.ring_x, state.ring_y)])
            z_rate = np.array([z_rate, complex(state.ring_x_rate, state.ring_y_rate)])
        if self.holds_angles:
            return Packed(z, z_rate, state.rho, state.rho_rate)
        turn = np.exp(1j * state.theta)
        return Packed(z, z_rate, state.rho * turn, (state.rho_rate + 1j * state.rho * state.theta_rate) * turn)

    def unpack(self, record: "Record", time: np.ndarray) -> State:
        """Stored samples at their times, s, as generalised coordinates; free angles are in (−π, π]."""
        bearing, operation, when = self.problem.bearing, self.problem.operation, time[:, None]
        ring: dict[str, np.ndarray] = {}
        z, z_rate = record.z, record.z_rate
        if z.ndim == 2:
            (z, at), (z_rate, rate) = z.T, z_rate.T
            ring = dict(ring_x=at.real, ring_y=at.imag, ring_x_rate=rate.real, ring_y_rate=rate.imag)
        if self.holds_angles:
            rho, rho_rate = record.q, record.q_rate
            theta = self.angles + turned(bearing, operation, when).cage
            theta_rate = np.zeros_like(theta) + kinematics(bearing, operation.at(when).speed).cage
        else:
            rho, theta = np.abs(record.q), np.angle(record.q)
            along = record.q_rate * record.q.conj() / rho
            rho_rate, theta_rate = along.real, along.imag / rho
        return State(
            x=z.real, y=z.imag, rho=rho, theta=theta, x_rate=z_rate.real, y_rate=z_rate.imag, rho_rate=rho_rate,
            theta_rate=theta_rate, turns=Turns.rolling(bearing, operation, when), **ring,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Record:
    """Stored samples; the works are integrals taken along with the steps."""

    z: np.ndarray  # (n_times,), or in a housing that moves (n_times, 2): from the outer ring's centre, and that
    z_rate: np.ndarray
    q: np.ndarray  # (n_times, n_rollers)
    q_rate: np.ndarray
    held_work: np.ndarray  # J, of contacts and weights against the held angles; 0 where none are held
    ramp_work: np.ndarray  # J, minus the integral of the hub's place times the load's rate
    dissipated: np.ndarray  # J, by contacts' dampers
    by_dashpots: np.ndarray  # J, dissipated by what holds shaft and housing
    sensor: np.ndarray  # (n_times, 2), r, m, and ṙ, m/s, of a sensor on the housing
    cage: np.ndarray  # (n_times, width), of a free cage, see `cage_motion.CageRows`; no columns without one

    def sound(self) -> "Record":
        """The samples before the first whose motion is no number, or too large for its energies to be numbers."""
        motion = np.column_stack([self.z, self.z_rate, self.q, self.q_rate])  # of one or of two columns each
        with np.errstate(over="ignore", invalid="ignore"):
            lost = ~np.all(np.abs(motion) < FARTHEST, axis=1)
        count = int(np.argmax(lost)) if lost.any() else len(lost)
        return Record(**{name: values[:count] for name, values in vars(self).items()})


class Integration:
    """Steps of a system from one sample to the next, `interval` s apart; the start is the first sample.

    `memory` is all that the next steps need, arrays that are changed in place: hub and elements, their rates and
    accelerations after the last step; the works of held angles, of the ramp, of the dampers and of dashpots, and the
    power that holds the angles; of a housing its sensor's motion and what `lagrange.in_housing` calls S. Before the
    first step accelerations and power are not known yet.
    """

    def __init__(self, system, start: Packed, interval: float, steps: Steps, damping: ContactDamping):
        self._system, self._steps, self._damping = system, steps, damping
        self._section = interval / steps.sections
        self.done = 0  # samples
        self.memory = {
            "hub": np.array([start.z, start.z_rate, 0.0 * start.z], dtype=complex),
            "elements": np.array([start.q, start.q_rate, 0.0 * start.q], dtype=system.dtype),
            "works": np.zeros(5),
            "housing": np.zeros(4),
        }

    def advance(self, count: int) -> Record:
        """The next so many samples; fewer where numbers overflow."""
        z = np.empty((2, count, *self.memory["hub"].shape[1:]), dtype=complex)
        sensor = np.zeros((count, 2))
        q = np.empty((2, count, self._system.n), dtype=self._system.dtype)
        works = np.zeros((4, count))
        there = int(self.done == 0 < count)
        cage = np.empty((count, row_width(self._system.n, self._system.problem.free_cage)))
        if there:
            hub, elements, sums, senses = (self.memory[name] for name in MOTION)
            z[:, 0], q[:, 0], works[:, 0], sensor[0] = hub[:2], elements[:2], sums[:4], senses[:2]
            if cage.size:
                cage[0] = first_row(self._system.n, self._system.ideal.cage)
        empty = z[:, there:], q[:, there:], works[:, there:], sensor[there:], cage[there:]
        there += self._fill(self.done + there, *empty)
        record = Record(
            z=z[0, :there], z_rate=z[1, :there], q=q[0, :there], q_rate=q[1, :there],
            held_work=works[0, :there], ramp_work=works[1, :there], dissipated=works[2, :there],
            by_dashpots=works[3, :there], sensor=sensor[:there], cage=cage[:there],
        ).sound()  # fmt: skip
        self.done += len(record.z)
        return record

    def _near(self, done: int, count: int) -> np.ndarray:
        """Whether contacts are near faults in the sections of so many samples after `done`, (count, sections)."""
        sections, steps = self._steps.sections, self._steps
        if not steps.looks:
            return np.ones((count, sections), dtype=bool)
        found = near_faults(self._system.problem, (done - 1) * sections, count * sections, self._section)
        return found.reshape(count, sections)

    @property
    def _scheme(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Kicks and drifts of a step without damping."""
        return (LEAP_KICKS, LEAP_DRIFTS) if self._steps.leaps else (ALL_KICKS, ALL_DRIFTS)

    def _fill(
        self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray, sensor: np.ndarray, cage: np.ndarray
    ) -> int:
        """Take the steps to the samples after `done`, fill these arrays with them, and keep the memory.

        Parameters
        ----------
        z, q : ndarray, (2, n_times) and (2, n_times, n_rollers), of hub and elements, and their rates
        works : ndarray, (4, n_times), J, of held angles, of the ramp, of the dampers and of dashpots
        sensor : ndarray, (n_times, 2)
        cage : ndarray, (n_times, width), of a free cage

        Returns
        -------
        Samples filled: fewer where the last is no number any more.
        """
        return 0


class Completion:
    """Adds forces, accelerations, energies and works to stored samples, which come in order and in parts.

    How they are cut into parts changes no bit. `memory` is all that runs on from part to part: what the first sample
    had, the extremes `met` so far, and of free angles the last sample's before they were unwrapped, their turns since
    the first one, and the shift of all, rad.
    """

    def __init__(self, problem: Problem, system):
        self._problem, self._system = problem, system
        self.first, self.met = np.full((), np.nan, dtype=FIRST), np.zeros((), dtype=MET)
        self.met["least_moved"], self.met["largest_moved"] = np.inf, -np.inf
        angles = np.zeros((3, problem.bearing.n_rollers))
        self.memory = {"first": self.first, "met": self.met, "angles": angles}

    def read(self, record: Record, time: np.ndarray) -> dict[str, np.ndarray]:
        """Quantities of the next samples, at least one, by the trajectory's names; `time` in s."""
        problem = self._problem
        bearing, operation = problem.bearing, problem.operation
        state = self._system.unpack(record, time)
        if not self._system.holds_angles:
            state = replace(state, theta=self._unwrapped(state.theta))
        rows = None if problem.free_cage is None else CageRows.of(record.cage)
        part, lift, turning = quantities(
            problem, time, state, record.dissipated, record.by_dashpots, record.sensor, rows
        )
        acting = loaded(problem, time)
        pull = acting.radial_load * part["inner_y"] - acting.side_load * part["inner_x"]
        # 2 m ρ̇ ω of the held elements does m ω² Δ(ρ²); their contacts and weights do the rest
        swing = bearing.roller_mass * np.sum((state.rho * state.theta_rate) ** 2, axis=1)
        if operation.mounting.housing is not None:
            swing = swing + held_energy(bearing.roller_mass, state)
        energy, kinetic, first = energy_of(part), part["energy_kinetic"], self.first
        if np.isnan(first["energy"]):
            still = part["energy_shaft"] + part["energy_support"]
            first[()] = lift[0], pull[0], swing[0], kinetic[0], (kinetic + still)[0], energy[0], turning[0]
        driven = record.held_work + (turning - first["turning"])
        part |= dict(
            work_load=record.ramp_work - (pull - first["pull"]),
            work_gravity=-operation.gravity * (lift - first["lift"]),
            work_cage=driven + swing - first["swing"] if self._system.holds_angles else driven,
        )
        external = part["work_load"] + part["work_gravity"] + part["work_cage"]
        part["energy_error"] = energy - first["energy"] - external + part["work_dissipated"]
        self._meet(part)
        return part

    def _meet(self, part: dict[str, np.ndarray]) -> None:
        """Take further samples into account in what has been met."""
        met, moved = self.met, part["energy_kinetic"] + part["energy_shaft"] + part["energy_support"]
        for name in ("inner_force", "outer_force", "energy_contact", "energy_error"):
            met[name] = np.maximum(met[name], np.abs(part[name]).max())
        met["least_moved"] = np.minimum(met["least_moved"], moved.min())
        met["largest_moved"] = np.maximum(met["largest_moved"], moved.max())
        met["dissipated"] = part["work_dissipated"][-1]

    def _unwrapped(self, angles: np.ndarray) -> np.ndarray:
        """Angles in (−π, π] as they run on, rad, (n_times, n_rollers); the first sample's are the operation's."""
        last, turns, shift = self.memory["angles"]
        if np.isnan(self.first["energy"]):
            last, wanted = angles[0], self._system.angles
            shift = TURN * np.round((wanted - last) / TURN)
        change = np.diff(np.concatenate([last[None], angles]), axis=0)
        jumps = np.where(np.abs(change) < np.pi, 0.0, np.mod(change + np.pi, TURN) - np.pi - change)
        turned = np.concatenate([turns[None], jumps]).cumsum(axis=0)[1:]
        self.memory["angles"][:] = angles[-1], turned[-1], shift
        return angles + turned + shift


def held_energy(mass: float, state: State):
    """What the work against held angles has beside its integrals, J, (...,); `mass` of an element, kg."""
    cos, sin = np.cos(state.theta), np.sin(state.theta)
    x, y = (np.asarray(rate)[..., None] for rate in (state.ring_x_rate, state.ring_y_rate))
    along = y * cos - x * sin
    return mass * np.sum(2.0 * state.rho * state.theta_rate * along + 0.5 * along**2, axis=-1)


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


class Simulation:
    """A forward solution that advances sample by sample, from its start; its state can be kept and taken back.

    How it is cut into parts changes no bit of it. At its end ask for the `verdict`: where the step was too long for
    what it met, `refine` begins the whole motion again with half of it.

    Parameters
    ----------
    interval : s, between samples
    integration : what takes the steps
    time_step : s, at most; default from the stiffest mode, and then it may be refined

    Errors
    ------
    RuntimeError: no equilibrium to start from.
    """

    def __init__(
        self,
        problem: Problem,
        interval: float,
        integration: type[Integration],
        time_step: float | None = None,
    ):
        self.problem, self.interval, self._kind = problem, interval, integration
        self.refinements = 0
        self._least = steps_of(problem, interval, time_step)
        self._most_refinements = REFINEMENTS if time_step is None else 0
        self._start = problem.first_state.state
        self._begin()

    def _begin(self) -> None:
        problem = self.problem
        system = System(problem)
        start = system.pack(self._start)
        steps = self._least.finer(2**self.refinements)
        self._integration = self._kind(system, start, self.interval, steps, problem.damping)
        self._completion = Completion(problem, system)
        self.trouble: str | None = None  # why it can't go on

    @property
    def steps_per_sample(self) -> int:
        return self._least.finer(2**self.refinements).per_sample

    @property
    def time_step(self) -> float:
        return self.interval / self.steps_per_sample

    @property
    def critical_time_step(self) -> float:
        """Step, s, at which the scheme becomes unstable under the forces met so far; before any, those expected."""
        return critical_time_step(self.problem, *(self._largest_forces if self.done else ()))

    @property
    def _largest_forces(self) -> tuple[float, float]:
        met = self._completion.met
        return float(met["inner_force"]), float(met["outer_force"])

    @property
    def done(self) -> int:
        """Samples from the start, which is the first."""
        return self._integration.done

    @property
    def first_moved_energy(self) -> float:
        """`Trajectory.energy_moved` of the first sample, J."""
        return float(self._completion.first["moved"])

    def advance(self, count: int) -> Trajectory | None:
        """The next samples, at most so many; None, or fewer and `trouble`, where numbers overflow."""
        first = self.done
        record = self._integration.advance(count)
        found = len(record.z)
        if found < count:
            self.trouble = (
                f"the motion overflowed by t = {(first + found) * self.steps_per_sample * self.time_step:.4g} s; "
                "lower time_step"
            )
        if not found:
            return None
        time, problem = self.interval * np.arange(first, first + found), self.problem
        part: dict[str, Any] = self._completion.read(record, time)  # fields of a trajectory by their names
        return Trajectory(
            **part, bearing=problem.bearing, operation=problem.operation, laws=problem.laws,
            roller_spin=kinematics(problem.bearing, problem.operation.at(time).speed).roller,
            roller_turn=np.asarray(turned(problem.bearing, problem.operation, time).roller),
            time_step=self.time_step, critical_time_step=self.critical_time_step,
            steps=self.steps_per_sample * (self.done - 1),
        )  # fmt: skip

    @property
    def verdict(self) -> Verdict:
        """How the step has resolved the motion so far; its last word is at the end."""
        stable = DAMPED_STABLE if self.problem.is_damped or self._least.leaps else STABLE
        longest = self.time_step * self._least.near / self._least.far
        if not fastest_mode(self.problem, *self._largest_forces) * longest < stable:
            return Verdict.TOO_FAST
        return Verdict.RESOLVED if self._energy_share() <= ENERGY_TOLERANCE else Verdict.RATTLING

    @property
    def sentence(self) -> str:
        """The verdict with its numbers."""
        omega, step = fastest_mode(self.problem, *self._largest_forces), self.time_step
        return self.verdict.value.format(
            frequency=omega / (2 * pi), step=step, stable_step=0.5 * STEP / omega, percent=100 * self._energy_share(),
            quarter_step=step / 4,
        )  # fmt: skip

    @property
    def can_be_refined(self) -> bool:
        return self.refinements < self._most_refinements

    def refine(self) -> None:
        """Begin again with half the step."""
        self.refinements += 1
        self._begin()

    def _energy_share(self) -> float:
        """Largest energy error, of the energy that contacts and dampers took and motion gained or lost."""
        met = self._completion.met
        if met["energy_error"] <= ROUND_OFF * float(self._completion.first["kinetic"]):
            return 0.0
        moved = met["energy_contact"] + (met["largest_moved"] - met["least_moved"]) + met["dissipated"]
        return float(met["energy_error"] / moved)

    def to_keep(self) -> dict[str, np.ndarray]:
        """All that the rest of the motion needs beside `done` and `refinements`, as arrays."""
        return self._integration.memory | self._completion.memory

    def take_back(self, arrays: dict[str, np.ndarray], done: int, refinements: int) -> None:
        """Go on where another simulation of the same problem stopped.

        Errors
        ------
        ValueError, KeyError: not what `to_keep` gives.
        """
        if not 0 <= refinements <= self._most_refinements:
            raise ValueError(f"{refinements} refinements")
        self.refinements = refinements
        self._begin()
        self._integration.done = done
        for name, memory in self.to_keep().items():
            if done > 1 or not name.startswith(OF_CAGE):  # steps of another kind may have kept a start
                memory[...] = arrays[name]
