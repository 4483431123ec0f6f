"""What a forward solution gives: motion, forces, energies and works at the stored samples."""

from dataclasses import asdict, dataclass, replace

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.energy import contact_energy, kinetic_energy, rotation_energy
from lagrange.integrate import Record
from lagrange.load_ramp import load_share
from lagrange.motion import accelerations, contacts
from lagrange.problem import Problem
from lagrange.raceway_laws import ContactLaws

TURN = 2.0 * np.pi
FIRST = ("lift", "pull", "swing", "kinetic", "energy")  # of the first sample, see `Completion.read`


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """A forward solution or a part of it. SI; (n_times,) unless said, (n_times, n_rollers) for the rolling elements."""

    bearing: Bearing
    operation: Operation
    laws: ContactLaws
    time: np.ndarray
    inner_x: np.ndarray
    inner_y: np.ndarray
    inner_vx: np.ndarray
    inner_vy: np.ndarray
    inner_ax: np.ndarray
    inner_ay: np.ndarray
    roller_rho: np.ndarray  # (n_times, n_rollers)
    roller_theta: np.ndarray  # rad, unwrapped
    roller_rho_rate: np.ndarray
    roller_theta_rate: np.ndarray
    roller_spin: float  # rad/s, from kinematics
    inner_force: np.ndarray  # (n_times, n_rollers), N, >= 0
    outer_force: np.ndarray
    energy_kinetic: np.ndarray  # J, translations and the constant rotation
    energy_contact: np.ndarray
    energy_error: np.ndarray  # J, that the integration has made since the start: 0 in an exact solution
    work_load: np.ndarray  # J, since the start
    work_gravity: np.ndarray
    work_cage: np.ndarray  # of what keeps the angles to the kinematics; 0 with free angles
    work_dissipated: np.ndarray  # by the contacts' dampers
    time_step: float  # s
    critical_time_step: float  # s, stability limit of the stiffest mode met
    steps: int

    @property
    def roller_x(self) -> np.ndarray:
        return self.roller_rho * np.cos(self.roller_theta)

    @property
    def roller_y(self) -> np.ndarray:
        return self.roller_rho * np.sin(self.roller_theta)

    @property
    def work_external(self) -> np.ndarray:
        """Of load, weights and cage since the start, J."""
        return self.work_load + self.work_gravity + self.work_cage


@dataclass(kw_only=True)
class Extremes:
    """What a solution has met so far."""

    inner_force: float = 0.0  # N, largest
    outer_force: float = 0.0
    contact_energy: float = 0.0  # J, largest
    least_kinetic: float = np.inf
    largest_kinetic: float = -np.inf
    energy_error: float = 0.0  # J, largest, of either sign
    dissipated: float = 0.0  # J, until now

    def see(self, part: dict[str, np.ndarray]) -> None:
        """Take further samples into account, by the trajectory's names."""
        for name, low, high in (
            ("inner_force", None, "inner_force"),
            ("outer_force", None, "outer_force"),
            ("energy_contact", None, "contact_energy"),
            ("energy_kinetic", "least_kinetic", "largest_kinetic"),
            ("energy_error", None, "energy_error"),
        ):
            values = np.abs(part[name])
            setattr(self, high, float(np.maximum(getattr(self, high), values.max())))
            if low is not None:
                setattr(self, low, float(np.minimum(getattr(self, low), values.min())))
        self.dissipated = float(part["work_dissipated"][-1])


class Completion:
    """Adds forces, accelerations, energies and works to stored samples, which come in order and in parts.

    How they are cut into parts changes no bit.
    """

    def __init__(self, problem: Problem, system):
        self._problem, self._system = problem, system
        self.first: dict[str, float] = {}  # of the first sample, from which works and errors are counted; J
        self.extremes = Extremes()
        # of free angles, rad: the last sample's before they were unwrapped, their turns since the first, all's shift
        self._angles = np.zeros((3, problem.bearing.n_rollers))

    def to_keep(self) -> tuple[dict[str, np.ndarray], dict[str, dict[str, float]]]:
        """All that runs on from part to part, as arrays and numbers; `take_back` goes on from it."""
        return {"angles": self._angles}, {"first": self.first, "extremes": asdict(self.extremes)}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: dict[str, dict[str, float]]) -> None:
        """Go on where another completion of the same problem stopped."""
        self._angles = arrays["angles"]
        kept = numbers["first"]
        self.first = {name: float(kept[name]) for name in FIRST} if kept else {}
        self.extremes = Extremes(**{name: float(numbers["extremes"][name]) for name in asdict(Extremes())})

    def read(self, record: Record, time: np.ndarray) -> dict[str, np.ndarray]:
        """Quantities of the next samples, at least one, by the trajectory's names; `time` in s."""
        problem = self._problem
        bearing, operation, laws = problem.bearing, problem.operation, problem.laws
        state = self._system.unpack(record, time)
        if not self._system.holds_angles:
            state = replace(state, theta=self._unwrapped(state.theta))
        touch = contacts(bearing, laws, state, problem.damping)
        share = load_share(time, problem.load_ramp)
        ax, ay, _, _ = accelerations(bearing, replace(operation, radial_load=0.0), state, touch)
        ay = ay - share * operation.radial_load / operation.inner_mass
        lift = operation.inner_mass * state.y + bearing.roller_mass * np.sum(state.rho * np.sin(state.theta), axis=1)
        pull = share * operation.radial_load * state.y
        # 2 m ρ̇ ω of the held elements does m ω² Δ(ρ²); their contacts and weights do the rest
        swing = bearing.roller_mass * np.sum((state.rho * state.theta_rate) ** 2, axis=1)
        kinetic = kinetic_energy(bearing, operation, state) + rotation_energy(bearing, operation)
        contact = contact_energy(laws, touch)
        energy = kinetic + contact
        if not self.first:
            self.first = {
                name: float(values[0]) for name, values in zip(FIRST, (lift, pull, swing, kinetic, energy), strict=True)
            }
        first = self.first
        held = self._system.holds_angles
        part = dict(
            time=time,
            inner_x=state.x, inner_y=state.y, inner_vx=state.x_rate, inner_vy=state.y_rate, inner_ax=ax, inner_ay=ay,
            roller_rho=state.rho, roller_theta=state.theta,
            roller_rho_rate=state.rho_rate, roller_theta_rate=state.theta_rate,
            inner_force=touch.inner_force, outer_force=touch.outer_force,
            energy_kinetic=kinetic, energy_contact=contact,
            work_load=record.ramp_work - (pull - first["pull"]),
            work_gravity=-operation.gravity * (lift - first["lift"]),
            work_cage=record.held_work + swing - first["swing"] if held else np.zeros_like(time),
            work_dissipated=record.dissipated,
        )  # fmt: skip
        external = part["work_load"] + part["work_gravity"] + part["work_cage"]
        part["energy_error"] = energy - first["energy"] - external + record.dissipated
        self.extremes.see(part)
        return part

    def _unwrapped(self, angles: np.ndarray) -> np.ndarray:
        """Angles in (−π, π] as they run on, rad, (n_times, n_rollers); the first sample's are the operation's."""
        last, turns, shift = self._angles
        if not self.first:
            last, wanted = angles[0], self._system.first + self._system.spacing
            shift = TURN * np.round((wanted - last) / TURN)
        change = np.diff(np.concatenate([last[None], angles]), axis=0)
        jumps = np.where(np.abs(change) < np.pi, 0.0, np.mod(change + np.pi, TURN) - np.pi - change)
        turned = np.concatenate([turns[None], jumps]).cumsum(axis=0)[1:]
        self._angles = np.array([angles[-1], turned[-1], shift])
        return angles + turned + shift
