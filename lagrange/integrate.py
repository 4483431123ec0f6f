"""Time stepping: kernels in plain numpy, kept lean because a run makes some 1e5 evaluations.

A system holds positions q and velocities v as arrays and gives the accelerations at frozen positions. With kinematic
angles q = (ρ_1 … ρ_N), real, beside the hub z = x + iy; with free angles the elements are complex too, in Cartesian
coordinates, so that no force depends on a velocity and the scheme stays explicit.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lagrange.kinematics import kinematics
from lagrange.laws import PowerLaw
from lagrange.load_ramp import load_share, load_share_rate
from lagrange.motion import State

# Blanes and Moan 2002, RKN scheme of order 4 with six stages: kicks b, drifts a
KICKS = (0.0829844064174052, 0.396309801498368, -0.0390563049223486)
DRIFTS = (0.245298957184271, 0.604872665711080)
BLOCK = 64  # samples whose directions are tabulated at a time


class Packed(NamedTuple):
    """Hub z, ż, complex; elements q, q̇, (n_rollers,)."""

    z: complex
    z_rate: complex
    q: np.ndarray
    q_rate: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Record:
    """Stored samples; the works are integrals taken along with the steps."""

    z: np.ndarray  # (n_times,)
    z_rate: np.ndarray
    q: np.ndarray  # (n_times, n_rollers)
    q_rate: np.ndarray
    cage_work: np.ndarray | None  # J, of contacts and weights against the held angles
    ramp_work: np.ndarray  # J, ∫ Ẇ y dt
    dissipated: np.ndarray  # J


class _System:
    """What both kinds of angles share."""

    def __init__(self, bearing, operation, laws, load_ramp):
        self.mass, self.inner_mass = bearing.roller_mass, operation.inner_mass
        self.gravity, self.load, self.ramp = operation.gravity, operation.radial_load, load_ramp
        self.cage = kinematics(bearing, operation.speed).cage
        self.n = bearing.n_rollers
        # constants as whole arrays: numpy takes 0.4 µs to bring a number into an operation, as long as the operation
        self.reach = np.full(self.n, bearing.inner_raceway_radius + bearing.roller_radius)
        self.track = np.full(self.n, bearing.outer_raceway_radius - bearing.roller_radius)
        self.zeros = np.zeros((2, self.n))
        self.first = operation.first_roller_angle
        self.spacing = 2.0 * np.pi * np.arange(self.n) / self.n
        self.depth, self.force = np.empty((2, self.n)), np.empty((2, self.n))
        self.depth_inner, self.depth_outer = self.depth
        self.force_inner, self.force_outer = self.force
        self.laws = laws
        self.stacked = _stacked(laws)
        self.power = None
        if isinstance(self.stacked, PowerLaw):
            self.power, self.constants = self.stacked.exponent, self.stacked.stiffness + self.zeros

    def law_forces(self):
        """Forces of the depths, N; both stay in buffers, row 0 inner, row 1 outer."""
        if self.power is not None:
            np.maximum(self.depth, self.zeros, out=self.depth)
            np.power(self.depth, self.power, out=self.force)
            np.multiply(self.force, self.constants, out=self.force)
        elif self.stacked is not None:
            self.force[:] = self.stacked.force(self.depth)
        else:
            self.force_inner[:] = self.laws.inner.force(self.depth_inner)
            self.force_outer[:] = self.laws.outer.force(self.depth_outer)

    def hub_pull(self, time: float) -> float:
        """Acceleration of the hub by load and weight along −y, m/s²."""
        share = 1.0 if time >= self.ramp else float(load_share(time, self.ramp))
        return self.gravity + share * self.load / self.inner_mass

    def ramp_power(self, time: float, y: float) -> float:
        """Ẇ y, W."""
        return self.load * float(load_share_rate(time, self.ramp)) * y if time < self.ramp else 0.0


class KinematicAngles(_System):
    """Elements on rays that turn with the cage; q = ρ."""

    holds_angles = True
    dtype = float

    def __init__(self, bearing, operation, laws, load_ramp):
        super().__init__(bearing, operation, laws, load_ramp)
        self.cage_squared = np.full(self.n, self.cage**2)
        self.per_mass = np.full(self.n, 1.0 / self.mass)
        self.fall = np.full(self.n, self.gravity)
        self.cage_weight = self.cage * self.mass * self.gravity

    def directions(self, times):
        """exp(−iθ), (n_times, n_rollers)."""
        return np.exp(-1j * (self.first + self.spacing + self.cage * times[:, None]))

    def pack(self, state: State) -> Packed:
        return Packed(complex(state.x, state.y), complex(state.x_rate, state.y_rate), state.rho, state.rho_rate)

    def unpack(self, record: Record, time) -> State:
        theta = self.first + self.spacing + self.cage * time[:, None]
        return State(
            x=record.z.real, y=record.z.imag, rho=record.q, theta=theta,
            x_rate=record.z_rate.real, y_rate=record.z_rate.imag,
            rho_rate=record.q_rate, theta_rate=np.full_like(theta, self.cage),
        )  # fmt: skip

    def accelerations(self, time, z, q, turn):
        """Of hub and elements, and the power that the held angles take up, W; `turn` is exp(−iθ)."""
        line = q - z * turn  # from hub to element, in the element's own frame
        distance = np.abs(line)
        np.subtract(self.reach, distance, out=self.depth_inner)
        np.subtract(q, self.track, out=self.depth_outer)
        self.law_forces()
        self.line, self.distance = line, distance
        push = self.force_inner / distance * line
        on_hub = -complex(np.vdot(turn, push))  # vdot conjugates: back to the fixed frame
        q_acc = push.real - self.force_outer
        q_acc *= self.per_mass
        q_acc += self.cage_squared * q
        power = self.held_power(z, on_hub)
        if self.gravity > 0.0:
            q_acc += self.fall * turn.imag
            power += self.cage_weight * float(q.dot(turn.real))
        return on_hub / self.inner_mass - 1j * self.hub_pull(time), q_acc, power

    def held_power(self, z: complex, on_hub: complex) -> float:
        """Power that held angles take up from forces on the hub, W: their moment times the cage's speed."""
        return self.cage * (z.real * on_hub.imag - z.imag * on_hub.real)

    def damper(self, z_rate, q_rate, q, z, turn, damping):
        """Accelerations of hub and elements by the dampers, the loss and the power held angles take up, W.

        At the positions last seen by `accelerations`.
        """
        # the line's rate in the turning frame; the frame's own turn moves only the hub in it
        rate = q_rate - (z_rate - 1j * self.cage * z) * turn
        unit = self.line / self.distance
        closing = -(rate * unit.conj()).real
        inner = _no_pull(damping * closing, self.force_inner)
        outer = _no_pull(damping * q_rate, self.force_outer)
        push = inner * unit
        on_hub = -complex(np.vdot(turn, push))
        loss = np.dot(inner, closing) + np.dot(outer, q_rate)
        return on_hub / self.inner_mass, (push.real - outer) / self.mass, loss, self.held_power(z, on_hub)


class FreeAngles(_System):
    """Elements free to move along the raceways; q = x + iy of their centres."""

    holds_angles = False
    dtype = complex

    def directions(self, times):
        """Nothing to tabulate."""
        return np.zeros(times.size)

    def pack(self, state: State) -> Packed:
        turn = np.exp(1j * state.theta)
        rate = (state.rho_rate + 1j * state.rho * state.theta_rate) * turn
        return Packed(complex(state.x, state.y), complex(state.x_rate, state.y_rate), state.rho * turn, rate)

    def unpack(self, record: Record, time) -> State:
        rho, theta = np.abs(record.q), np.unwrap(np.angle(record.q), axis=0)
        theta += 2.0 * np.pi * np.round((self.first + self.spacing - theta[0]) / (2.0 * np.pi))
        along = record.q_rate * record.q.conj() / rho
        return State(
            x=record.z.real, y=record.z.imag, rho=rho, theta=theta,
            x_rate=record.z_rate.real, y_rate=record.z_rate.imag, rho_rate=along.real, theta_rate=along.imag / rho,
        )  # fmt: skip

    def accelerations(self, time, z, q, turn):
        """Of hub and elements; no power is taken up by anything that holds angles."""
        line = q - z
        distance, rho = np.abs(line), np.abs(q)
        np.subtract(self.reach, distance, out=self.depth_inner)
        np.subtract(rho, self.track, out=self.depth_outer)
        self.law_forces()
        self.line, self.distance, self.rho = line, distance, rho
        push = self.force_inner / distance * line
        q_acc = (push - self.force_outer / rho * q) / self.mass - 1j * self.gravity
        return -complex(push.sum()) / self.inner_mass - 1j * self.hub_pull(time), q_acc, 0.0

    def damper(self, z_rate, q_rate, q, z, turn, damping):
        """Accelerations of hub and elements by the dampers, the loss and the power held angles take up, W.

        At the positions last seen by `accelerations`.
        """
        unit, out = self.line / self.distance, q / self.rho
        closing = -((q_rate - z_rate) * unit.conj()).real
        opening = (q_rate * out.conj()).real
        inner = _no_pull(damping * closing, self.force_inner)
        outer = _no_pull(damping * opening, self.force_outer)
        push = inner * unit
        loss = np.dot(inner, closing) + np.dot(outer, opening)
        return -push.sum() / self.inner_mass, (push - outer * out) / self.mass, loss, 0.0


def _stacked(laws):
    """One law for both rows of depths, constants as columns, where the two are of one kind; else None."""
    inner, outer = laws
    if type(inner) is not type(outer):
        return None
    if isinstance(inner, PowerLaw):
        if inner.exponent != outer.exponent:
            return None
        names = ("stiffness",)
    else:
        names = ("compliance", "level", "largest_force")
    return replace(inner, **{name: np.array([[getattr(law, name)] for law in laws]) for name in names})


def _no_pull(damper_force, spring_force):
    """The damper's force where spring and damper together push, else what takes the spring's away."""
    return np.where(spring_force > 0.0, np.maximum(damper_force, -spring_force), 0.0)


def integrate(system, start: Packed, step: float, per_sample: int, n_samples: int, damping: float) -> Record:
    """Advance and store every `per_sample` steps; the start is the first sample.

    Errors
    ------
    RuntimeError: numbers overflowed, with the time of the first bad sample.
    """
    z = np.empty(n_samples, dtype=complex)
    z_rate = np.empty(n_samples, dtype=complex)
    q = np.empty((n_samples, system.n), dtype=system.dtype)
    q_rate = np.empty_like(q)
    works = np.zeros((3, n_samples))
    z[0], z_rate[0], q[0], q_rate[0] = start
    advance = _leapfrog if damping > 0.0 else _blanes_moan
    state = (start.z, start.z_rate, np.array(start.q, dtype=system.dtype), np.array(start.q_rate, dtype=system.dtype))
    totals = (0.0, 0.0, 0.0)
    for first in range(0, n_samples - 1, BLOCK):
        last = min(first + BLOCK, n_samples - 1)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # told below
            samples = list(advance(system, state, totals, step, per_sample, first, last, damping))
        for k, (at_sample, works_so_far) in enumerate(samples, first + 1):
            z[k], z_rate[k], q[k], q_rate[k] = at_sample
            works[:, k] = works_so_far
        state, totals = samples[-1]
        if not np.isfinite(z[last]):
            bad = int(np.argmin(np.isfinite(z[: last + 1])))
            raise RuntimeError(f"the motion overflowed by t = {bad * per_sample * step:.4g} s; lower time_step")
    return Record(
        z=z, z_rate=z_rate, q=q, q_rate=q_rate,
        cage_work=works[0] if system.holds_angles else None, ramp_work=works[1], dissipated=works[2],
    )  # fmt: skip


def _blanes_moan(system, state, totals, step, per_sample, first, last, damping):
    """Six-stage symplectic steps of fourth order; gives state and works after each sample."""
    kicks = [*KICKS, 1.0 - 2.0 * sum(KICKS), *KICKS[::-1]]
    drifts = [*DRIFTS, 0.5 - sum(DRIFTS), 0.5 - sum(DRIFTS), *DRIFTS[::-1]]
    at = np.cumsum(drifts)
    steps = np.arange(first * per_sample, last * per_sample)
    times = step * (steps[:, None] + at).ravel()
    turns = system.directions(times)
    times = times.tolist()
    whole = np.ones(system.n, dtype=system.dtype)
    pairs = [(step * a, step * a * whole, step * b, step * b * whole) for a, b in zip(drifts, kicks[1:], strict=True)]
    begin, begin_all = step * kicks[0], step * kicks[0] * whole
    z, z_rate, q, q_rate = state
    held, ramped, lost = totals
    time = step * first * per_sample
    accelerations, ramping = system.accelerations, system.ramp > 0.0
    z_acc, q_acc, power = accelerations(time, z, q, system.directions(np.array([time]))[0])
    i = 0
    for _ in range(first, last):
        for _ in range(per_sample):
            z_rate = z_rate + begin * z_acc
            q_rate = q_rate + begin_all * q_acc
            held += begin * power
            if ramping:
                ramped += begin * system.ramp_power(time, z.imag)
            for drift, drift_all, kick, kick_all in pairs:
                z = z + drift * z_rate
                q = q + drift_all * q_rate
                time = times[i]
                z_acc, q_acc, power = accelerations(time, z, q, turns[i])
                i += 1
                z_rate = z_rate + kick * z_acc
                q_rate = q_rate + kick_all * q_acc
                held += kick * power
                if ramping:
                    ramped += kick * system.ramp_power(time, z.imag)
        yield (z, z_rate, q, q_rate), (held, ramped, lost)


def _leapfrog(system, state, totals, step, per_sample, first, last, damping):
    """Drift, kick, damp, kick, drift; second order. The damper's flow by the midpoint rule at frozen positions."""
    steps = np.arange(first * per_sample, last * per_sample)
    times = step * (steps + 0.5)
    turns = system.directions(times)
    times = times.tolist()
    z, z_rate, q, q_rate = state
    held, ramped, lost = totals
    half = 0.5 * step
    i = 0
    for _ in range(first, last):
        for _ in range(per_sample):
            z = z + half * z_rate
            q = q + half * q_rate
            z_acc, q_acc, power = system.accelerations(times[i], z, q, turns[i])
            z_rate, q_rate = z_rate + half * z_acc, q_rate + half * q_acc
            held += step * power
            if system.ramp > 0.0:
                ramped += step * system.ramp_power(times[i], z.imag)
            z_slow, q_slow, _, _ = system.damper(z_rate, q_rate, q, z, turns[i], damping)
            z_slow, q_slow, loss, taken = system.damper(
                z_rate + half * z_slow, q_rate + half * q_slow, q, z, turns[i], damping
            )
            z_rate, q_rate = z_rate + step * z_slow, q_rate + step * q_slow
            lost += step * loss
            held += step * taken
            z_rate, q_rate = z_rate + half * z_acc, q_rate + half * q_acc
            z = z + half * z_rate
            q = q + half * q_rate
            i += 1
        yield (z, z_rate, q, q_rate), (held, ramped, lost)
