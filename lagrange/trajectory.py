"""What a forward solution gives: motion, forces, energies and works at the stored samples."""

from dataclasses import dataclass, replace

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.cage_motion import CageRows, CageSamples, free_cage, holding_cage
from lagrange.contact.raceway_laws import ContactLaws
from lagrange.first_state import Problem
from lagrange.in_housing import held_energy
from lagrange.integrate import Record
from lagrange.load_history import load_share
from lagrange.motion import (
    contact_energy,
    contact_state,
    housing_accelerations,
    hub_equations,
    kinetic_energy,
    rotation_energy,
)
from lagrange.mounting import OF_HOUSING

TURN = 2.0 * np.pi
# of the first sample, see `Completion.read`; of all samples so far: the largest, or what the name says; J and N
FIRST = np.dtype([(name, float) for name in ("lift", "pull", "swing", "kinetic", "moved", "energy", "turning")])
MET = np.dtype([(name, float) for name in ("inner_force", "outer_force", "energy_contact", "energy_error",
                                           "least_moved", "largest_moved", "dissipated")])  # fmt: skip


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
    roller_spin: float | np.ndarray  # rad/s, from kinematics
    roller_turn: np.ndarray  # rad, that of all rollers
    inner_force: np.ndarray  # (n_times, n_rollers), N, >= 0
    outer_force: np.ndarray
    inner_damper: np.ndarray  # N, the dampers' part of them
    outer_damper: np.ndarray
    energy_kinetic: np.ndarray  # J, translations and the rotation of kinematics
    energy_contact: np.ndarray
    # J, of the springs that hold the shaft beside the bearing, and the housing; 0 where there are none
    energy_shaft: np.ndarray
    energy_support: np.ndarray
    energy_error: np.ndarray  # J, that the integration has made since the start: 0 in an exact solution
    work_load: np.ndarray  # J, since the start
    work_gravity: np.ndarray
    # of what keeps the angles to the kinematics, turns the bodies where surfaces are not perfect, and speeds them up
    work_cage: np.ndarray
    work_dissipated: np.ndarray  # by the contacts' dampers and the dashpots of shaft and housing
    work_damping: np.ndarray  # by the contacts' dampers alone
    cage: CageSamples | None  # of a bearing with one
    # of a housing that moves and of a sensor on it, else 0: m, m/s²; other places are in the fixed frame, but for
    # roller_rho and roller_theta, which are about the outer ring's centre
    housing_x: np.ndarray
    housing_y: np.ndarray
    housing_ax: np.ndarray
    housing_ay: np.ndarray
    sensor_ay: np.ndarray
    time_step: float  # s
    critical_time_step: float  # s, stability limit of the stiffest mode met
    steps: int

    @property
    def energy_moved(self) -> np.ndarray:
        """Of all that moves and of what holds it, J: what contacts exchange energy with."""
        return self.energy_kinetic + self.energy_shaft + self.energy_support

    @property
    def roller_x(self) -> np.ndarray:
        return self.housing_x[:, None] + self.roller_rho * np.cos(self.roller_theta)

    @property
    def roller_y(self) -> np.ndarray:
        return self.housing_y[:, None] + self.roller_rho * np.sin(self.roller_theta)

    @property
    def work_external(self) -> np.ndarray:
        """Of load, weights and cage since the start, J."""
        return self.work_load + self.work_gravity + self.work_cage


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
        bearing, operation, laws = problem.bearing, problem.operation, problem.laws
        state = self._system.unpack(record, time)
        if not self._system.holds_angles:
            state = replace(state, theta=self._unwrapped(state.theta))
        touch = contact_state(bearing, laws, state, problem.damping)
        share = load_share(time, problem.load_ramp)
        acting = operation.at(time)
        left_x, left_y = hub_equations(replace(acting, radial_load=0.0, side_load=0.0), state, touch, 0.0, 0.0)
        ax, ay = -(left_x - share * acting.side_load) / operation.inner_mass, -left_y / operation.inner_mass
        ay = ay - share * acting.radial_load / operation.inner_mass
        x, y = state.x + state.ring_x, state.y + state.ring_y  # in the fixed frame
        lift = operation.inner_mass * state.y + bearing.roller_mass * np.sum(state.rho * np.sin(state.theta), axis=1)
        pull = share * acting.radial_load * y - share * acting.side_load * x
        # 2 m ρ̇ ω of the held elements does m ω² Δ(ρ²); their contacts and weights do the rest
        swing = bearing.roller_mass * np.sum((state.rho * state.theta_rate) ** 2, axis=1)
        turning = rotation_energy(bearing, acting) + np.zeros_like(time)
        kinetic = kinetic_energy(bearing, operation, state) + turning
        contact = contact_energy(laws, touch)
        shaft, housing = operation.mounting.shaft, operation.mounting.housing
        bent = np.zeros_like(time) if shaft is None else 0.5 * shaft.stiffness * (x**2 + y**2)
        sprung, moved = np.zeros_like(time), dict.fromkeys(OF_HOUSING[:4], np.zeros_like(time))
        if housing is not None:
            lift = lift + _carried_mass(bearing, operation) * state.ring_y
            swing = swing + held_energy(bearing.roller_mass, state)
            sprung = 0.5 * housing.stiffness * (state.ring_x**2 + state.ring_y**2)
            speeding = housing_accelerations(bearing, operation, state, touch)
            moved = dict(zip(moved, (state.ring_x, state.ring_y, *speeding), strict=True))
        sensor = operation.mounting.sensor
        shown = np.zeros_like(time) if sensor is None else record.sensor @ sensor.pull
        dissipated, cage = record.dissipated + record.by_dashpots, None
        if problem.free_cage is not None:
            free = free_cage(bearing, problem.free_cage, state, CageRows.of(record.cage), self._system.first)
            cage, kinetic, contact, lift = free.samples, kinetic + free.kinetic, contact + free.stored, lift + free.lift
            dissipated = dissipated + free.dissipated
            ax, ay = ax + free.push[0] / operation.inner_mass, ay + free.push[1] / operation.inner_mass
            if housing is not None:
                of_ring = free.push_on_ring / (housing.mass + bearing.outer_ring_mass)
                moved["housing_ax"] = moved["housing_ax"] + of_ring[0]
                moved["housing_ay"] = moved["housing_ay"] + of_ring[1]
        elif problem.cage is not None:
            cage = holding_cage(bearing, operation, time, state, touch)
        energy = kinetic + contact + bent + sprung
        first = self.first
        if np.isnan(first["energy"]):
            first[()] = lift[0], pull[0], swing[0], kinetic[0], (kinetic + bent + sprung)[0], energy[0], turning[0]
        driven = record.held_work + (turning - first["turning"])
        nothing = np.zeros(state.rho.shape)
        part = dict(
            time=time,
            inner_x=x, inner_y=y, inner_ax=ax, inner_ay=ay,
            inner_vx=state.x_rate + state.ring_x_rate, inner_vy=state.y_rate + state.ring_y_rate,
            roller_rho=state.rho, roller_theta=state.theta,
            roller_rho_rate=state.rho_rate, roller_theta_rate=state.theta_rate,
            inner_force=touch.inner_force, outer_force=touch.outer_force,
            inner_damper=nothing + touch.inner_damper, outer_damper=nothing + touch.outer_damper,
            energy_kinetic=kinetic, energy_contact=contact, energy_shaft=bent, energy_support=sprung,
            work_load=record.ramp_work - (pull - first["pull"]),
            work_gravity=-operation.gravity * (lift - first["lift"]),
            work_cage=driven + swing - first["swing"] if self._system.holds_angles else driven,
            work_dissipated=dissipated, work_damping=record.dissipated, cage=cage,
            **moved, sensor_ay=shown,
        )  # fmt: skip
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
            last, wanted = angles[0], self._system.first + self._system.spacing
            shift = TURN * np.round((wanted - last) / TURN)
        change = np.diff(np.concatenate([last[None], angles]), axis=0)
        jumps = np.where(np.abs(change) < np.pi, 0.0, np.mod(change + np.pi, TURN) - np.pi - change)
        turned = np.concatenate([turns[None], jumps]).cumsum(axis=0)[1:]
        self.memory["angles"][:] = angles[-1], turned[-1], shift
        return angles + turned + shift


def _carried_mass(bearing: Bearing, operation: Operation) -> float:
    """All that stands on a housing's springs, kg."""
    housing = operation.mounting.housing
    carrying = 0.0 if housing is None else housing.mass + bearing.outer_ring_mass
    return operation.inner_mass + bearing.n_rollers * bearing.roller_mass + carrying
