"""Forward solution of the equations of motion: the paper's model, solved.

Without damping a composition of fourth order that is symplectic, so the energy doesn't drift: Blanes and Moan's
Runge-Kutta-Nyström scheme of six stages (J. Comput. Appl. Math. 142, 2002). With damping the second-order leapfrog, the
damper's own flow in the middle of the step. The hub is one complex number x + iy; see `integrate` for the kernels.
"""

import warnings
from dataclasses import replace
from math import ceil, pi
from typing import Literal

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.energy import contact_energy, kinetic_energy, rotation_energy
from lagrange.integrate import FreeAngles, KinematicAngles, integrate
from lagrange.kinematics import kinematics, roller_angles
from lagrange.load_ramp import load_share
from lagrange.motion import State, accelerations, contact_state
from lagrange.raceway_laws import ContactLaws
from lagrange.statics import static_equilibrium
from lagrange.trajectory import Trajectory

STEP = 2.0  # of 1/ω of the stiffest mode: its frequency then is 0.05 % off, the hub's 1e-6
DAMPED_STEP = 0.3
OVERLOAD = 2.0  # the stiffest mode is estimated at this many times the largest static force
LIMIT, DAMPED_LIMIT = 3.05, 2.0  # ω·step at which the six-stage scheme and the leapfrog become unstable
STABLE, DAMPED_STABLE = 2.8, 1.0  # ω·step that they may reach
LARGEST_DAMPING = 0.5  # of a step times the rate of the damper on an element
SMALLEST_FORCE = 1e-3  # N, for the frequency of an unloaded element
DIFFERENCE = 1e-6  # s, for the velocities of the moving equilibrium
NO_MOVE = 1e-9  # m within that time, below which a jump doesn't matter
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-5 of it
REFINEMENTS = 3  # halvings of the step before a warning instead
ROUND_OFF = 1e-13  # of the kinetic energy


def simulate(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    duration: float,
    interval: float,
    *,
    start: Literal["equilibrium", "rest"] = "equilibrium",
    angles: Literal["kinematic", "free"] = "kinematic",
    damping: float = 0.0,
    load_ramp: float = 0.0,
    time_step: float | None = None,
) -> Trajectory:
    """Integrate (21)-(23), with the angles from kinematics (20) or free (the θ equation).

    Parameters
    ----------
    duration, interval : float, s; samples at 0, interval, … up to the duration
    start : "equilibrium": on the statics at the start, with the velocities of the equilibrium as it moves on;
        "rest": rings centred, contacts undeformed, elements at cage speed
    angles : "kinematic": θ̇ is the cage's, and the work of what holds it is accounted for; "free": no cage, no friction,
        nothing keeps the elements apart
    damping : float, N s/m, of every closed contact; never makes it pull
    load_ramp : float, s, over which the load grows from nothing, by half a cosine
    time_step : float, s, at most; default from the stiffest mode

    Returns
    -------
    Trajectory

    Errors
    ------
    Fourth order in the step while no contact opens or closes, where the law's kink lowers the order; second order with
    damping. The energy error stays below 5e-8 of the elastic energy over 0.06 s of the paper's bearing, 6e-6 when
    started from rest, every roller rattling.
    Where contacts rattle (clearance) the step is halved, up to three times, until the error is below 1 % of the energy
    they pass on; UserWarning if that isn't enough, or at once for a step of your own.
    ValueError: impossible arguments. RuntimeError: no equilibrium to start from; the step is too long for the forces.
    """
    if not (duration >= 0.0 and interval > 0.0 and damping >= 0.0 and load_ramp >= 0.0):
        raise ValueError(
            f"duration = {duration}, interval = {interval}, damping = {damping}, load_ramp = {load_ramp}: "
            "interval must be positive, the others at least 0"
        )
    if start not in ("equilibrium", "rest") or angles not in ("kinematic", "free"):
        raise ValueError(f"start = {start!r}, angles = {angles!r}: equilibrium or rest, kinematic or free")
    n_samples = int(duration / interval + 1e-9) + 1
    per_sample = steps_per_sample(bearing, operation, laws, interval, damping, time_step)
    system_type = KinematicAngles if angles == "kinematic" else FreeAngles
    state = _start(bearing, operation, laws, start, load_ramp)
    time = interval * np.arange(n_samples)
    for refinement in range(REFINEMENTS + 1):
        step = interval / per_sample
        system = system_type(bearing, operation, laws, load_ramp)
        record = integrate(system, system.pack(state), step, per_sample, n_samples, damping)
        trajectory = _complete(bearing, operation, laws, time, system.unpack(record, time), record, damping, load_ramp)
        omega = _fastest(bearing, laws, trajectory.inner_force.max(), trajectory.outer_force.max())
        trajectory = replace(
            trajectory,
            time_step=step,
            critical_time_step=(LIMIT if damping == 0.0 else DAMPED_LIMIT) / omega,
            steps=per_sample * (n_samples - 1),
        )
        resolved = omega * step < (STABLE if damping == 0.0 else DAMPED_STABLE)
        share = _energy_share(trajectory)
        if resolved and share <= ENERGY_TOLERANCE:
            return trajectory
        if time_step is not None or refinement == REFINEMENTS:
            break
        per_sample *= 2
    if not resolved:
        raise RuntimeError(
            f"the forces met make a mode of {omega / (2 * pi):.3g} Hz, too fast for the step of {step:.3g} s; "
            f"set time_step = {0.5 * STEP / omega:.2g} or less"
        )
    warnings.warn(
        f"contacts rattle: the step of {step:.3g} s changes the energy by {100 * share:.2g} % of what the contacts "
        f"pass on; set time_step = {step / 4:.2g} or less, or add damping",
        stacklevel=2,
    )
    return trajectory


def steps_per_sample(
    bearing: Bearing,
    operation: Operation,
    laws: ContactLaws,
    interval: float,
    damping: float = 0.0,
    time_step: float | None = None,
) -> int:
    """Equal steps that `simulate` takes from sample to sample, before any refinement; arguments as there."""
    longest = _longest_step(bearing, operation, laws, damping)
    if time_step is not None:
        longest = min(longest, time_step)
    return max(1, ceil(interval / longest * (1.0 - 1e-12)))


def _energy_share(trajectory: Trajectory) -> float:
    """Largest energy error, of the energy that contacts and dampers took and motion gained or lost."""
    error = float(np.max(np.abs(trajectory.energy_error)))
    if error <= ROUND_OFF * trajectory.energy_kinetic[0]:
        return 0.0
    moved = np.max(trajectory.energy_contact) + np.ptp(trajectory.energy_kinetic) + trajectory.work_dissipated[-1]
    return error / float(moved)


def _fastest(bearing: Bearing, laws: ContactLaws, inner_force: float, outer_force: float) -> float:
    """Angular frequency of an element between its contacts, rad/s."""
    stiffness = sum(
        float(law.slope(law.approach(max(force, SMALLEST_FORCE))))
        for law, force in zip(laws, (inner_force, outer_force), strict=True)
    )
    return (stiffness / bearing.roller_mass) ** 0.5


def _longest_step(bearing: Bearing, operation: Operation, laws: ContactLaws, damping: float) -> float:
    """Time step from the stiffest mode: an element under the largest force that can be expected."""
    weight = operation.radial_load + operation.inner_mass * operation.gravity
    spin = bearing.roller_mass * bearing.pitch_radius * kinematics(bearing, operation.speed).cage ** 2
    squeeze = float(laws.inner.force(max(-0.5 * bearing.radial_clearance, 0.0)))  # of preload
    force = OVERLOAD * (squeeze + spin + bearing.roller_mass * operation.gravity + 5.0 * weight / bearing.n_rollers)
    omega = _fastest(bearing, laws, force, force)
    if damping == 0.0:
        return STEP / omega
    return min(DAMPED_STEP / omega, LARGEST_DAMPING * bearing.roller_mass / (2.0 * damping))


def _start(bearing: Bearing, operation: Operation, laws: ContactLaws, start: str, load_ramp: float) -> State:
    """State at t = 0."""
    theta = roller_angles(bearing, operation.first_roller_angle)
    cage = kinematics(bearing, operation.speed).cage
    zero = np.zeros(bearing.n_rollers)
    if start == "rest":
        return State(
            x=0.0, y=0.0, rho=zero + bearing.pitch_radius, theta=theta,
            x_rate=0.0, y_rate=0.0, rho_rate=zero, theta_rate=zero + cage,
        )  # fmt: skip
    if load_ramp > 0.0:
        operation = replace(operation, radial_load=0.0)
    now = static_equilibrium(bearing, operation, laws, angles=theta)
    before, after = (
        static_equilibrium(bearing, operation, laws, angles=theta + cage * shift, start=(now.x, now.y))
        for shift in (-DIFFERENCE, DIFFERENCE)
    )
    earlier, middle, later = (np.array([s.x, s.y, *s.rho]) for s in (before, now, after))
    rates = (later - earlier) / (2.0 * DIFFERENCE)
    bend, move = np.abs(later + earlier - 2.0 * middle), np.abs(later - earlier)
    if np.any((bend > 0.5 * move) & (np.maximum(bend, move) > NO_MOVE)):
        rates[:] = 0.0  # the equilibrium jumps here: a ring in clearance that tips from roller to roller
    return State(
        x=now.x, y=now.y, rho=now.rho, theta=theta,
        x_rate=rates[0], y_rate=rates[1], rho_rate=rates[2:], theta_rate=zero + cage,
    )  # fmt: skip


def _complete(bearing, operation, laws, time, state: State, record, damping: float, load_ramp: float) -> Trajectory:
    """Forces, accelerations, energies and works of the stored states."""
    touch = contact_state(bearing, laws, state, damping)
    share = load_share(time, load_ramp)
    ax, ay, _, _ = accelerations(bearing, replace(operation, radial_load=0.0), state, touch)
    ay = ay - share * operation.radial_load / operation.inner_mass
    lift = operation.inner_mass * state.y + bearing.roller_mass * np.sum(state.rho * np.sin(state.theta), axis=1)
    pull = share * operation.radial_load * state.y
    # 2 m ρ̇ ω of the held elements does m ω² Δ(ρ²); their contacts and weights do the rest
    swing = bearing.roller_mass * np.sum((state.rho * state.theta_rate) ** 2, axis=1)
    held = record.cage_work is not None
    return Trajectory(
        bearing=bearing, operation=operation, laws=laws, time=time,
        inner_x=state.x, inner_y=state.y, inner_vx=state.x_rate, inner_vy=state.y_rate, inner_ax=ax, inner_ay=ay,
        roller_rho=state.rho, roller_theta=state.theta,
        roller_rho_rate=state.rho_rate, roller_theta_rate=state.theta_rate,
        roller_spin=kinematics(bearing, operation.speed).roller,
        inner_force=touch.inner_force, outer_force=touch.outer_force,
        energy_kinetic=kinetic_energy(bearing, operation, state) + rotation_energy(bearing, operation),
        energy_contact=contact_energy(laws, touch),
        work_load=record.ramp_work - (pull - pull[0]),
        work_gravity=-operation.gravity * (lift - lift[0]),
        work_cage=record.cage_work + swing - swing[0] if held else np.zeros_like(time),
        work_dissipated=record.dissipated,
        time_step=0.0, critical_time_step=0.0, steps=0,
    )  # fmt: skip
