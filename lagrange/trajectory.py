"""What a forward solution gives: motion, forces, energies and works at the stored samples."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.cage_motion import CageRows, CageSamples, free_cage, holding_cage
from lagrange.contact.raceway_laws import ContactLaws
from lagrange.first_state import Problem
from lagrange.load_history import load_share
from lagrange.motion import (
    State,
    contact_energy,
    contact_state,
    housing_accelerations,
    hub_equations,
    kinetic_energy,
    rotation_energy,
)
from lagrange.mounting import OF_HOUSING
from lagrange.tilt import TiltSamples, shaft_tilt_energy, tilt_energy


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
    tilt: TiltSamples | None  # of rollers that tilt
    time_step: float  # s
    critical_time_step: float  # s, stability limit of the stiffest mode met
    steps: int

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


def quantities(
    problem: Problem, time: np.ndarray, state: State, by_contacts, by_dashpots, sensor, rows: CageRows | None = None
) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Columns that follow from motion and losses at samples, under the trajectory's names, but for the works done.

    Parameters
    ----------
    by_contacts, by_dashpots : ndarray, (n_times,), J, that dampers of contacts and of what holds shaft and housing take
    sensor : ndarray, (n_times, 2), r, m, and its rate, m/s, of a sensor on the housing
    rows : of a free cage

    Returns
    -------
    These; mass times height of all that moves, kg m; energy of the bodies' own rotation, J; (n_times,) each.
    """
    bearing, operation, laws = problem.bearing, problem.operation, problem.laws
    touch = contact_state(bearing, problem.contacts, state, problem.damping)
    acting = loaded(problem, time)
    left_x, left_y = hub_equations(acting, state, touch, 0.0, 0.0)
    ax, ay = -left_x / operation.inner_mass, -left_y / operation.inner_mass
    x, y = state.x + state.ring_x, state.y + state.ring_y  # in the fixed frame
    lift = operation.inner_mass * state.y + bearing.roller_mass * np.sum(state.rho * np.sin(state.theta), axis=1)
    rotation = rotation_energy(bearing, operation.at(time)) + np.zeros_like(time)
    kinetic = kinetic_energy(bearing, operation, state) + rotation
    contact = contact_energy(laws, touch)
    tilt, hub_axis = None, problem.hub_tilt
    if hub_axis is not None and state.tilts is not None and touch.tilted is not None:
        kinetic = kinetic + tilt_energy(bearing, hub_axis, state.tilts, state.theta_rate)
        contact = contact + shaft_tilt_energy(hub_axis, state.tilts)
        tilt = TiltSamples.of(state.tilts, touch.tilted)
    shaft, housing = operation.mounting.shaft, operation.mounting.housing
    bent = np.zeros_like(time) if shaft is None else 0.5 * shaft.stiffness * (x**2 + y**2)
    sprung: Any = np.zeros_like(time)
    moved: dict[str, Any] = dict.fromkeys(OF_HOUSING[:4], np.zeros_like(time))
    if housing is not None:
        lift = lift + _carried_mass(bearing, operation) * state.ring_y
        sprung = 0.5 * housing.stiffness * (state.ring_x**2 + state.ring_y**2)
        speeding = housing_accelerations(bearing, operation, state, touch)
        moved = dict(zip(moved, (state.ring_x, state.ring_y, *speeding), strict=True))
    dissipated, cage = by_contacts + by_dashpots, None
    if rows is not None and problem.free_cage is not None:
        free = free_cage(bearing, problem.free_cage, state, rows, operation.first_roller_angle)
        cage, kinetic, contact, lift = free.samples, kinetic + free.kinetic, contact + free.stored, lift + free.lift
        dissipated = dissipated + free.dissipated
        ax, ay = ax + free.push[0] / operation.inner_mass, ay + free.push[1] / operation.inner_mass
        if housing is not None:
            of_ring = free.push_on_ring / (housing.mass + bearing.outer_ring_mass)
            moved["housing_ax"] = moved["housing_ax"] + of_ring[0]
            moved["housing_ay"] = moved["housing_ay"] + of_ring[1]
    elif problem.cage is not None:
        cage = holding_cage(bearing, operation, time, state, touch)
    on_sensor, nothing = operation.mounting.sensor, np.zeros(state.rho.shape)
    part = dict(
        time=time,
        inner_x=x, inner_y=y, inner_ax=ax, inner_ay=ay,
        inner_vx=state.x_rate + state.ring_x_rate, inner_vy=state.y_rate + state.ring_y_rate,
        roller_rho=state.rho, roller_theta=state.theta,
        roller_rho_rate=state.rho_rate, roller_theta_rate=state.theta_rate,
        inner_force=touch.inner_force, outer_force=touch.outer_force,
        inner_damper=nothing + touch.inner_damper, outer_damper=nothing + touch.outer_damper,
        energy_kinetic=kinetic, energy_contact=contact, energy_shaft=bent, energy_support=sprung,
        work_dissipated=dissipated, work_damping=by_contacts, cage=cage, tilt=tilt,
        **moved, sensor_ay=np.zeros_like(time) if on_sensor is None else sensor @ on_sensor.pull,
    )  # fmt: skip
    return part, lift, rotation


def loaded(problem: Problem, time) -> Operation:
    """What acts at a time, s, or at times, (n_times,), with the ramp's share of the load."""
    acting, share = problem.operation.at(time), load_share(time, problem.load_ramp)
    return replace(acting, radial_load=share * acting.radial_load, side_load=share * acting.side_load)


def energy_of(part: dict[str, np.ndarray]) -> np.ndarray:
    """Of all that moves and is bent, J, (n_times,)."""
    return part["energy_kinetic"] + part["energy_contact"] + part["energy_shaft"] + part["energy_support"]


def _carried_mass(bearing: Bearing, operation: Operation) -> float:
    """All that stands on a housing's springs, kg."""
    housing = operation.mounting.housing
    carrying = 0.0 if housing is None else housing.mass + bearing.outer_ring_mass
    return operation.inner_mass + bearing.n_rollers * bearing.roller_mass + carrying
