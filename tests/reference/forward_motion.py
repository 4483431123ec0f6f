"""Lagrange's equations written again and solved by scipy."""

from functools import cache
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

from lagrange import motion as equations
from lagrange.columns import columns_of
from lagrange.first_state import Problem, sampled
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.mounting import PARTS
from lagrange.surface.deviation import Turns

# ---- Lagrange's equations derived from T and V by computer algebra, evaluated with 40 digits. T and V are typed in
# from the paper's (2), (3), (14)-(19), (26), (27); nothing of `lagrange` is used.

DIGITS = 40


class Coordinates:
    """So many, q, with their rates and second rates, and Lagrange's equations in them."""

    def __init__(self, n: int):
        self.q, self.rates, self.seconds = (sp.symbols(f"{name}:{n}") for name in "qva")

    def rate(self, of):
        return sum(of.diff(s) * v for s, v in zip(self.q, self.rates, strict=True))

    def equations(self, parameters, T, V, D, functions):
        """Left sides d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q + ∂D/∂q̇ in the order of q, of (parameters, q, q̇, q̈) as numbers."""
        left = [
            self.rate(T.diff(v)) + sum(T.diff(v, u) * a for u, a in zip(self.rates, self.seconds, strict=True))
            - T.diff(s) + V.diff(s) + D.diff(v) for s, v in zip(self.q, self.rates, strict=True)
        ]  # fmt: skip
        given = (parameters, self.q, self.rates, self.seconds)
        function = sp.lambdify(given, left, modules=[functions, "mpmath"], cse=True)

        def evaluate(*numbers):
            with mp.workdps(DIGITS):
                return [float(value) for value in function(*([mp.mpf(float(n)) for n in row] for row in numbers))]

        return evaluate


class Stored(sp.Function):
    """Energy of a contact by its depth, K = 1."""

    def fdiff(self, argindex=1):
        return Pushed(self.args[0])


class Pushed(sp.Function):
    """Force of a contact by its depth, K = 1; its values are numbers' alone."""


@cache
def derived_equations(n_rollers: int, exponent: float | sp.Rational, slices: tuple[tuple[float, float], ...] = ()):
    """Lagrange's equations as one function of (parameters, q, q̇, q̈), in the order of q = (x, y, ρ_1 … ρ_N, θ_1 … θ_N).

    Parameters are (m, M, g, W, r_in, r_out, r, K_in, K_out, d); D = ½ d Σ δ̇² of the closed contacts is Rayleigh's
    dissipation function of viscous dampers beside the springs; W is part of V, as W y.
    `slices` : their places along the rollers and drops; K is then a slice's, and instead of dampers rollers tilt and
    skew, and the hub tilts: q goes on with (τ, σ, b_x, b_y), and in place of d stand (I_t, I_a, w, I_h, J, Ω, k, b₀x,
    b₀y), J the hub's inertia about its axis. Slopes of the bodies' axes are typed in along x and y; spins enter as
    ½ I w (a_y ȧ_x − a_x ȧ_y).
    """
    usual, tilting = sp.symbols("m M g W r_in r_out r K_in K_out"), sp.symbols("I_t I_a w I_h J Omega k b0x b0y")
    (m, M, g, W, r_in, r_out, r, K_in, K_out), d, n = usual, sp.Symbol("d"), n_rollers
    I_t, I_a, w, I_h, J, speed, k, b0x, b0y = tilting if slices else 9 * (sp.Integer(0),)
    of = Coordinates(4 * n + 4 if slices else 2 * n + 2)
    rate, (x, y), (bx, by) = of.rate, of.q[:2], of.q[-2:]
    T, V, D = M * (rate(x) ** 2 + rate(y) ** 2) / 2, (M * g + W) * y, sp.Integer(0)
    T += (I_h * (rate(bx) ** 2 + rate(by) ** 2) + J * speed * (by * rate(bx) - bx * rate(by))) / 2
    V += k * ((bx - b0x) ** 2 + (by - b0y) ** 2) / 2
    for i in range(n):
        p, a, *turned = of.q[2 + i : -2 if slices else None : n]
        tilt, skew = turned or (0, 0)
        X, Y = p * sp.cos(a), p * sp.sin(a)
        ax, ay = tilt * sp.cos(a) + skew * sp.sin(a), tilt * sp.sin(a) - skew * sp.cos(a)
        T += m * (rate(X) ** 2 + rate(Y) ** 2) / 2
        if slices:
            T += (I_t * (rate(ax) ** 2 + rate(ay) ** 2) + I_a * w * (ay * rate(ax) - ax * rate(ay))) / 2
        V += m * g * Y
        for K, reach, sign, (sx, sy), (ux, uy) in (
            (K_in, r_in + r, -1, (X - x, Y - y), (ax - bx, ay - by)), (K_out, r_out - r, 1, (X, Y), (ax, ay)),
        ):  # fmt: skip
            chi = sp.sqrt(sx**2 + sy**2)
            for z, drop in slices or ((0, 0),):
                depth = sign * (chi - reach + (z * (ux * sx + uy * sy) / chi if z else 0)) - drop
                V += K * Stored(depth)
                D += 0 if slices else d * sp.Heaviside(depth) * rate(depth) ** 2 / 2
    power, parameters = sp.Rational(exponent), (*usual, *tilting) if slices else (*usual, d)
    return of.equations(parameters, T, V, D, {
        "Pushed": lambda depth: max(depth, mp.mpf(0)) ** (mp.mpf(power.p) / power.q),
        "Heaviside": lambda depth, at_zero=0: mp.mpf(depth > 0),
    })  # fmt: skip


# ---- Forward solution of the equations of motion (21)-(23), written as they stand in `lagrange.motion` and left to
# scipy. The reference of the compiled Lagrangian model: it shares geometry, laws and equations with it, but no step,
# no scheme and no account of energy. Beside hub, outer ring and rolling elements the unknowns are the works of load,
# held angles and dampers, and a sensor's motion, so that the energy balances to the tolerance.

RELATIVE = 1e-7  # error of a step, of each unknown; and absolute:
PLACE, RATE, WORK = 1e-14, 1e-9, 1e-12  # m, m/s, J
LONGEST = 1e-5  # s, a step: no contact closes and opens within one
STIFF = 1e7  # 1/s, of a dashpot on its mass, from which on an implicit scheme is faster
WORKS = 4  # of the load; of what holds the angles and drives the bodies; lost in contacts' dampers; in dashpots


class Motion:
    """A problem as a first-order system: hub and outer ring, x and y, ρ − pitch radius, θ − the kinematic angle; their
    rates; where rollers tilt their tilts, the hub's slope and the rates of these; four works, J; a sensor's r and its
    rate."""

    def __init__(self, problem: Problem):
        self.problem, self.n = problem, problem.bearing.n_rollers
        self.first = roller_angles(problem.bearing, problem.operation.first_roller_angle)
        self.held = problem.angles == "kinematic"

    @property
    def start(self) -> np.ndarray:
        """The unknowns at t = 0."""
        s, ideal = self.problem.first_state.state, kinematics(self.problem.bearing, *self.problem.operation.ring_speeds)
        places = s.x, s.y, s.ring_x, s.ring_y, *(s.rho - self.problem.bearing.pitch_radius), *np.zeros(self.n)
        rates = s.x_rate, s.y_rate, s.ring_x_rate, s.ring_y_rate, *s.rho_rate, *(s.theta_rate - ideal.cage)
        t = s.tilts
        tilts: tuple = () if t is None else (
            *t.tilt, t.slope_x, t.slope_y, *t.tilt_rate, t.slope_x_rate, t.slope_y_rate
        )  # fmt: skip
        return np.array([*places, *rates, *tilts, *np.zeros(WORKS + 2)])

    @property
    def tolerance(self) -> np.ndarray:
        """Absolute errors of the unknowns that a step may make."""
        axes = np.ones(self.n) / self.problem.bearing.pitch_radius
        ways = np.array([1.0, 1.0, 1.0, 1.0, *np.ones(self.n), *axes])
        angles = np.full(0 if self.problem.axial is None else self.n + 2, 1.0 / self.problem.bearing.roller_length)
        tilts = *(PLACE * angles), *(RATE * angles)
        return np.array([*(PLACE * ways), *(RATE * ways), *tilts, *np.full(WORKS, WORK), PLACE, RATE])

    def _tilts(self, unknowns: np.ndarray) -> equations.Tilts | None:
        if self.problem.axial is None:
            return None
        n = self.n
        tilt, (bx, by), rate, (vx, vy) = np.split(unknowns[8 + 4 * n : 12 + 6 * n], [n, n + 2, 2 * n + 2])
        return equations.Tilts(tilt=tilt.T, tilt_rate=rate.T, slope_x=bx, slope_y=by, slope_x_rate=vx, slope_y_rate=vy)

    def state(self, time, unknowns: np.ndarray) -> equations.State:
        """Generalised coordinates at a time, s, or of unknowns, (n_unknowns, n_times), at times, (n_times,)."""
        bearing, operation, n = self.problem.bearing, self.problem.operation, self.n
        when = np.asarray(time)[..., None]
        (x, y, ring_x, ring_y), rho, off = np.split(unknowns[: 4 + 2 * n], [4, 4 + n])
        (vx, vy, ring_vx, ring_vy), rho_rate, off_rate = np.split(unknowns[4 + 2 * n : 8 + 4 * n], [4, 4 + n])
        return equations.State(
            x=x, y=y, rho=bearing.pitch_radius + rho.T,
            theta=self.first + turned(bearing, operation, when).cage + off.T, x_rate=vx, y_rate=vy, rho_rate=rho_rate.T,
            theta_rate=kinematics(bearing, *operation.at(when).ring_speeds).cage + off_rate.T,
            ring_x=ring_x, ring_y=ring_y, ring_x_rate=ring_vx, ring_y_rate=ring_vy,
            turns=Turns.rolling(bearing, operation, when), tilts=self._tilts(unknowns),
        )  # fmt: skip

    def rate(self, time: float, unknowns: np.ndarray) -> np.ndarray:
        """Rates of the unknowns: equations (21)-(23), the θ equation, those of housing and sensor; powers, W."""
        problem, n, places = self.problem, self.n, 4 + 2 * self.n
        bearing, history = problem.bearing, problem.operation.history
        state, acting = self.state(time, unknowns), problem.acting(time)
        touch = equations.contact_state(bearing, problem.contacts, state, problem.damping)
        ring = equations.housing_accelerations(bearing, acting, state, touch)
        x, y, rho, theta = equations.accelerations(bearing, acting, state, touch, ring)
        gain = 0.0 if history is None else float(kinematics(bearing, *history.ring_speeds(time, 1)).cage)
        vx, vy = state.x_rate + state.ring_x_rate, state.y_rate + state.ring_y_rate
        driven = np.sum(touch.inner_force * touch.inner_passing + touch.outer_force * touch.outer_passing)
        if self.held:
            force = bearing.roller_mass * state.rho * (gain - theta)  # θ̈ is that of elements which nothing holds
            along = state.ring_y_rate * np.cos(state.theta) - state.ring_x_rate * np.sin(state.theta)
            driven += np.sum(force * (state.rho * state.theta_rate + along))
        lost = np.sum(touch.inner_damper * touch.inner_closing + touch.outer_damper * touch.outer_closing)
        lost += 0.0 if touch.tilted is None else np.sum(touch.tilted.lost)
        shaft, housing, sensor = acting.mounting.shaft, acting.mounting.housing, acting.mounting.sensor
        dashed = 0.0 if shaft is None else shaft.damping * (vx**2 + vy**2)
        dashed += 0.0 if housing is None else housing.damping * (state.ring_x_rate**2 + state.ring_y_rate**2)
        r, r_rate = unknowns[-2:]
        found = np.empty_like(unknowns)
        tilts, hub = state.tilts, problem.hub_tilt
        if tilts is not None and hub is not None:
            inertia, first = equations.roller_inertias(bearing)[0], 2 * places
            if not self.held:  # guides push back on what turns rollers: m ρ² θ̈ = … + τ (guide's moment)
                turning = bearing.roller_mass * state.rho**2
                _, guide = equations.tilt_equations(bearing, acting, state, touch, 0.0, 0.0)
                theta = (turning * theta + tilts.tilt * guide) / (turning + inertia * tilts.tilt**2)
            left, guide = equations.tilt_equations(bearing, acting, state, touch, 0.0, gain if self.held else theta)
            driven -= np.sum(state.theta_rate * tilts.tilt * guide) if self.held else 0.0
            found[first : first + n + 2] = unknowns[first + n + 2 : first + 2 * n + 4]
            found[first + n + 2 : first + 2 * n + 2] = -left / inertia
            slopes = np.array(equations.hub_slope_equations(bearing, acting, hub, state, touch, 0.0, 0.0))
            found[first + 2 * n + 2 : first + 2 * n + 4] = -slopes / hub.inertia if hub.is_free else 0.0
        found[:places] = unknowns[places : 2 * places]
        found[places : places + 4] = x - ring[0], y - ring[1], *ring
        found[places + 4 : places + 4 + n] = rho
        found[places + 4 + n : 2 * places] = 0.0 if self.held else theta - gain
        found[-WORKS - 2 : -2] = acting.side_load * vx - acting.radial_load * vy, driven, lost, dashed
        found[-2:] = (r_rate, sensor.pull @ (r, r_rate) - ring[1]) if sensor is not None else (0.0, 0.0)
        return found


def simulate(problem: Problem, duration: float, interval: float) -> SimpleNamespace:
    """Integrate (21)-(23), with the angles from kinematics (20) or free (the θ equation).

    Parameters
    ----------
    duration, interval : float, s; samples at 0, interval, … up to the duration

    Returns
    -------
    Columns by the result file's names, 0 of a housing, a shaft's springs and a sensor that are not there, those of a
    cage under `cage`; rates of the coordinates; works, J; the energy that the integration has made since the start, and
    its steps.

    Errors
    ------
    Dormand and Prince's scheme of eighth order, of fifth by Radau where a dashpot is stiff; a step makes RELATIVE
    of the velocities. Over 2 ms of the paper's bearing the energy is off by 4e-11 of the elastic energy, by 5e-9 where
    all contacts rattle, and by 7e-6 where they strike after a fall of 20 µm.
    A free cage is none of it: its Coulomb friction is no smooth function of the motion.
    RuntimeError: no equilibrium to start from; the integrator finds no step.
    """
    assert problem.free_cage is None
    bearing, operation = problem.bearing, problem.operation
    motion, time = Motion(problem), interval * np.arange(int(duration / interval + 1e-9) + 1)
    shaft, housing, sensor = (getattr(operation.mounting, part) for part in ("shaft", "housing", "sensor"))
    stiff = max(0.0 if part is None else part.damping for part in (shaft, housing)) > STIFF * operation.inner_mass
    found = solve_ivp(
        motion.rate, (0.0, time[-1]), motion.start, "Radau" if stiff else "DOP853", dense_output=True, rtol=RELATIVE,
        atol=motion.tolerance, max_step=LONGEST,
    )  # fmt: skip
    if not found.success:
        raise RuntimeError(found.message)
    unknowns = found.sol(time) if time.size > 1 else motion.start[:, None]
    load, driven, by_contacts, by_dashpots = unknowns[-WORKS - 2 : -2]
    state, zero = motion.state(time, unknowns), np.zeros(time.size)
    part: dict[str, Any] = dict.fromkeys(columns_of(*PARTS), zero) | sampled(problem, time, state)
    if sensor is not None:
        part["sensor_ay"] = unknowns[-2:].T @ sensor.pull
    cage = {name.removeprefix("cage_"): value for name, value in part.items() if name.startswith("cage_")}
    lift = operation.inner_mass * state.y + bearing.roller_mass * np.sum(state.rho * np.sin(state.theta), axis=1)
    if housing is not None:
        carrying = housing.mass + bearing.outer_ring_mass
        lift = lift + (operation.inner_mass + bearing.n_rollers * bearing.roller_mass + carrying) * state.ring_y
    rotation = equations.rotation_energy(bearing, operation.at(time)) + zero
    work_gravity, work_cage = -operation.gravity * (lift - lift[0]), driven + rotation - rotation[0]
    energy = sum(part[f"energy_{name}"] for name in ("kinetic", "contact", "shaft", "support"))
    work_external, lost = load + work_gravity + work_cage, by_contacts + by_dashpots
    return SimpleNamespace(
        **part, cage=SimpleNamespace(**cage) if cage else None, roller_rho_rate=state.rho_rate,
        roller_theta_rate=state.theta_rate, work_cage=work_cage, work_external=work_external, work_dissipated=lost,
        work_damping=by_contacts, energy_error=energy - energy[0] - work_external + lost,
        roller_spin=kinematics(bearing, *operation.at(time).ring_speeds).roller,
        steps=found.t.size - 1 if time.size > 1 else 0,
    )  # fmt: skip
