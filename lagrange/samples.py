"""Samples of the Lagrangian model: the result file's columns that follow from a motion, with those of a cage."""

import numpy as np

from lagrange.bearing import Cage
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics
from lagrange.motion import (
    ContactState,
    State,
    accelerations,
    contact_energy,
    contact_state,
    housing_accelerations,
    hub_equations,
    kinetic_energy,
    rotation_energy,
)
from lagrange.tilt import shaft_tilt_energy, tilt_energy


def sampled(problem: Problem, time: np.ndarray, state: State) -> dict[str, np.ndarray]:
    """Columns by the result file's names, but for works, and what a sensor shows; those of `problem`'s parts.

    Parameters
    ----------
    time : (n_times,), s; of a free cage 0 alone, where it is concentric and turns with the elements
    """
    bearing, operation, shaft = problem.bearing, problem.operation, problem.operation.mounting.shaft
    zero, per_roller, housing = np.zeros(time.size), np.zeros(state.rho.shape), operation.mounting.housing
    touch = contact_state(bearing, problem.contacts, state, problem.damping)
    left = hub_equations(problem.acting(time), state, touch, 0.0, 0.0)
    x, y = zero + state.x + state.ring_x, zero + state.y + state.ring_y  # in the fixed frame
    found = dict(
        time=time,
        inner_x=x, inner_y=y, inner_ax=-left[0] / operation.inner_mass, inner_ay=-left[1] / operation.inner_mass,
        inner_vx=zero + state.x_rate + state.ring_x_rate, inner_vy=zero + state.y_rate + state.ring_y_rate,
        roller_x=np.reshape(state.ring_x, (-1, 1)) + state.rho * np.cos(state.theta),
        roller_y=np.reshape(state.ring_y, (-1, 1)) + state.rho * np.sin(state.theta),
        roller_rho=state.rho, roller_theta=state.theta, inner_force=touch.inner_force, outer_force=touch.outer_force,
        inner_damping_force=per_roller + touch.inner_damper, outer_damping_force=per_roller + touch.outer_damper,
        energy_kinetic=kinetic_energy(bearing, operation, state) + rotation_energy(bearing, operation.at(time)),
        energy_contact=contact_energy(problem.laws, touch),
    )  # fmt: skip
    hub_axis, tilts, tilted = problem.hub_tilt, state.tilts, touch.tilted
    if hub_axis is not None and tilts is not None and tilted is not None:
        found["energy_kinetic"] = found["energy_kinetic"] + tilt_energy(bearing, hub_axis, tilts, state.theta_rate)
        found["energy_contact"] = found["energy_contact"] + shaft_tilt_energy(hub_axis, tilts)
        found |= dict(
            roller_tilt=tilts.tilt, roller_skew=per_roller, inner_moment=tilted.inner_moment,
            outer_moment=tilted.outer_moment, inner_slope_x=zero + tilts.slope_x, inner_slope_y=zero + tilts.slope_y,
        )  # fmt: skip
        if problem.damping.acts:
            found["inner_damping_moment"], found["outer_damping_moment"] = (per_roller + m for m in tilted.dampers)
    if shaft is not None:
        found["energy_shaft"] = 0.5 * shaft.stiffness * (x**2 + y**2)
    if housing is not None:
        ax, ay = housing_accelerations(bearing, operation, state, touch)
        found |= dict(housing_x=zero + state.ring_x, housing_y=zero + state.ring_y, housing_ax=ax, housing_ay=ay)
        found["energy_support"] = 0.5 * housing.stiffness * (found["housing_x"] ** 2 + found["housing_y"] ** 2)
    if operation.mounting.sensor is not None:
        found["sensor_ay"] = zero
    if problem.free_cage is not None:
        _add_free_cage(found, problem, problem.free_cage, state)
    elif problem.cage is not None:
        _add_cage(found, state, _holding_force(problem, time, state, touch), per_roller)
        found["cage_angle"] = state.theta[:, 0] - operation.first_roller_angle
    return found


def _add_cage(found: dict[str, np.ndarray], state: State, force: np.ndarray, outward: np.ndarray) -> None:
    """A cage's columns where nothing guides it: `force`, `outward` : (n_times, n_rollers), N, on the elements."""
    zero = np.zeros_like(found["time"])
    still = "angle", "guidance_x", "guidance_y", "work_dashpots", "work_friction", "work_drag"
    found |= {f"cage_{name}": zero for name in still} | dict(
        cage_x=zero + state.ring_x, cage_y=zero + state.ring_y, cage_speed=zero + state.theta_rate[:, 0],
        cage_force=force, cage_radial_force=outward, cage_moment=np.zeros_like(force),
    )  # fmt: skip


def _add_free_cage(found: dict[str, np.ndarray], problem: Problem, cage: Cage, state: State) -> None:
    """The columns of a free cage at the start: its springs push rollers, or a guiding ring, that lie off its play."""
    bearing, operation, nothing = problem.bearing, problem.operation, np.zeros_like(state.rho)
    off = state.rho - bearing.pitch_radius if cage.guidance == "rollers" else nothing
    depth = np.maximum(np.abs(off) - 0.5 * cage.pocket_clearance, 0.0)
    _add_cage(found, state, nothing, -np.sign(off) * cage.stiffness * depth)
    kinetic = 0.5 * cage.inertia * found["cage_speed"] ** 2
    kinetic = kinetic + 0.5 * cage.mass * (np.square(state.ring_x_rate) + np.square(state.ring_y_rate))
    found["energy_kinetic"] = found["energy_kinetic"] + kinetic
    stored = np.sum(depth**2, axis=1)
    if cage.guidance == "inner_ring" and cage.guidance_clearance is not None:
        away = np.hypot(state.x, state.y)
        deep = np.maximum(away - 0.5 * cage.guidance_clearance, 0.0)
        for axis, place in (("x", state.x), ("y", state.y)):
            push = cage.stiffness * deep * place / np.where(away > 0.0, away, 1.0)  # towards the hub's centre
            found[f"cage_guidance_{axis}"] = push
            found[f"inner_a{axis}"] = found[f"inner_a{axis}"] - push / operation.inner_mass
        stored = stored + deep**2
    found["energy_contact"] = found["energy_contact"] + 0.5 * cage.stiffness * stored


def _holding_force(problem: Problem, time: np.ndarray, state: State, touch: ContactState) -> np.ndarray:
    """Forces along θ, (n_times, n_rollers), N, by which a cage holds the elements at the angles of kinematics."""
    bearing, operation = problem.bearing, problem.operation
    history = operation.history  # that of the run's start: it says how the cage speeds up
    gain = 0.0 if history is None else kinematics(bearing, *history.ring_speeds(time[:, None], 1)).cage
    ring = housing_accelerations(bearing, operation, state, touch)
    *_, free = accelerations(bearing, operation, state, touch, ring)
    return bearing.roller_mass * state.rho * (gain - free)
