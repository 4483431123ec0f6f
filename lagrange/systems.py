"""What moves: the accelerations of hub and elements, in plain numpy, kept lean: a run makes some 1e5 evaluations.

A system holds positions q and velocities v as arrays and gives the accelerations at frozen positions. With kinematic
angles q = (ρ_1 … ρ_N), real, beside the hub z = x + iy; with free angles the elements are complex too, in Cartesian
coordinates, so that no force depends on a velocity and the scheme stays explicit.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lagrange.contact.damping import ContactDamping, damper_force
from lagrange.contact.laws import PowerLaw
from lagrange.equations import touching_distances
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics, turned
from lagrange.load_history import load_share, load_share_rate
from lagrange.motion import State
from lagrange.mounting import flow
from lagrange.surface.deviation import Profiles, Turns, profiles
from lagrange.surface.edges import softened


class Packed(NamedTuple):
    """Hub z, ż, complex; elements q, q̇, (n_rollers,)."""

    z: complex
    z_rate: complex
    q: np.ndarray
    q_rate: np.ndarray


class _System:
    """What both kinds of angles share."""

    def __init__(self, problem: Problem):
        self.problem = problem
        bearing, operation, laws = problem.bearing, problem.operation, problem.laws
        self.mass, self.inner_mass = bearing.roller_mass, operation.inner_mass
        self.gravity, self.load, self.ramp = operation.gravity, operation.radial_load, problem.load_ramp
        self.course = operation.course
        shaft = operation.mounting.shaft
        self.spring_rate = 0.0 if shaft is None else shaft.stiffness / self.inner_mass  # 1/s²
        self.dashpot_rate = 0.0 if shaft is None else shaft.damping / self.inner_mass  # 1/s
        self.ideal = kinematics(bearing, operation.speed)
        self.cage, self.cage_gain = self.ideal.cage, 0.0
        self.surfaces = profiles(bearing)
        # whether power goes with a velocity, of held angles in a housing that moves, and by what: see `in_housing`
        self.carries, self.shift = False, 0j
        self.n = bearing.n_rollers
        # constants as whole arrays: numpy takes 0.4 µs to bring a number into an operation, as long as the operation
        self.reach, self.track = (np.full(self.n, distance) for distance in touching_distances(bearing))
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

    def surface_forces(self, surfaces: Profiles, time: float, inward, outward, distance) -> None:
        """Forces on such surfaces, at directions of the elements from both rings' centres, rad; as `law_forces`."""
        turns = Turns.rolling(self.problem.bearing, self.problem.operation, time)
        inner, outer = surfaces.inner(inward, turns), surfaces.outer(outward, turns)
        self.depth_inner -= inner.sinkage
        self.depth_outer -= outer.sinkage
        if not (inner.soft or outer.soft):
            self.law_forces()
        else:
            self.force_inner[:] = softened(self.laws.inner, inner.compliance).force(self.depth_inner)
            self.force_outer[:] = softened(self.laws.outer, outer.compliance).force(self.depth_outer)
        self.met_inner, self.met_outer = inner.under(self.force_inner), outer.under(self.force_outer)
        self.aside = 1.0 + 1j * self.met_inner.slope / distance  # turns the line of centres to the inner force

    def damper_coefficients(self, damping: ContactDamping):
        """N s/m of the inner and the outer contacts, at the positions last seen by `accelerations`."""
        if not damping.follows_forces:
            return damping.constant, damping.constant
        soft = (0.0, 0.0) if self.surfaces is None else (self.met_inner.compliance, self.met_outer.compliance)
        forces = self.force_inner, self.force_outer
        return tuple(
            damping.coefficient(force, softened(law, compliance).slope(depth))
            for force, law, compliance, depth in zip(forces, self.laws, soft, self.depth, strict=True)
        )

    def passing(self, frame: float):
        """Rates at which inner and outer contacts close in a frame that turns, rad/s, as surfaces pass them, m/s."""
        ring, roller = self.ideal.shaft - frame, self.ideal.roller - frame
        return self.met_inner.passing(ring, roller), self.met_outer.passing(-frame, roller)

    def drive_power(self, frame: float) -> float:
        """Power that turning bodies under the contacts takes, W."""
        inner, outer = self.passing(frame)
        return float(self.force_inner.dot(inner) + self.force_outer.dot(outer))

    def follow(self, time: float) -> None:
        """Speeds of a time, s, where they change."""
        if self.course is not None:
            bearing = self.problem.bearing
            self.ideal = kinematics(bearing, float(self.course.speed(time)))
            self.cage = self.ideal.cage
            self.cage_gain = kinematics(bearing, float(self.course.speed(time, 1))).cage

    def cage_turn(self, times):
        """How far the cage has turned since t = 0, rad."""
        if self.course is None:
            return self.cage * times
        return turned(self.problem.bearing, self.problem.operation, times).cage

    def hub_pull(self, time: float) -> complex:
        """Acceleration of the hub by load and weight, turned by −90 degrees: along −y it is real, m/s²."""
        share = 1.0 if time >= self.ramp else float(load_share(time, self.ramp))
        if self.course is None:
            return self.gravity + share * self.load / self.inner_mass
        x, y = self.course.force(time)
        return self.gravity + share * (1j * float(x) - float(y)) / self.inner_mass

    def hub_acceleration(self, on_hub: complex, z: complex, time: float) -> complex:
        """Of the hub by its contacts' force, N, the shaft's springs, load and weight, m/s²."""
        found = on_hub / self.inner_mass - 1j * self.hub_pull(time)
        if self.spring_rate > 0.0:
            found -= self.spring_rate * z
        return found

    @property
    def has_dashpots(self) -> bool:
        """Whether what holds the shaft takes energy."""
        return self.dashpot_rate > 0.0

    def slowed(self, z_rate, z_acc, q_rate, seconds: float):
        """Velocities of hub and elements after so long a kick, just made, had the shaft's dashpots acted as well.

        And what these take, J, and what held angles take up from that.
        """
        hub, lost = flow(self.dashpot_rate, self.inner_mass, z_rate, z_acc, seconds)
        return hub, q_rate, lost, 0.0

    @property
    def load_changes(self) -> bool:
        return self.ramp > 0.0 or self.course is not None

    def change_power(self, time: float, z: complex) -> float:
        """Power of the load's change at a standing hub, W: minus its rate times the hub's place."""
        if self.course is None:
            return self.load * float(load_share_rate(time, self.ramp)) * z.imag if time < self.ramp else 0.0
        share, rate = float(load_share(time, self.ramp)), float(load_share_rate(time, self.ramp))
        (x, y), (x_rate, y_rate) = self.course.force(time), self.course.force_rate(time)
        return -float((rate * x + share * x_rate) * z.real + (rate * y + share * y_rate) * z.imag)


class KinematicAngles(_System):
    """Elements on rays that turn with the cage; q = ρ."""

    holds_angles = True
    dtype = float

    def __init__(self, problem: Problem):
        super().__init__(problem)
        self.cage_squared = np.full(self.n, self.cage**2)  # of a steady one
        self.per_mass = np.full(self.n, 1.0 / self.mass)
        self.fall = np.full(self.n, self.gravity)
        self.cage_weight = self.cage * self.mass * self.gravity

    def follow(self, time: float) -> None:
        super().follow(time)
        if self.course is not None:
            self.cage_squared = np.full(self.n, self.cage**2)
            self.cage_weight = self.cage * self.mass * self.gravity

    def directions(self, times):
        """exp(−iθ), (n_times, n_rollers)."""
        return np.exp(-1j * (self.first + self.spacing + self.cage_turn(times[:, None])))

    def pack(self, state: State) -> Packed:
        return Packed(complex(state.x, state.y), complex(state.x_rate, state.y_rate), state.rho, state.rho_rate)

    def unpack(self, record, time) -> State:
        """Stored samples of an `integrate.Record` at their times, s, as generalised coordinates."""
        bearing, operation = self.problem.bearing, self.problem.operation
        theta = self.first + self.spacing + self.cage_turn(time[:, None])
        cage = kinematics(bearing, operation.at(time[:, None]).speed).cage
        return State(
            x=record.z.real, y=record.z.imag, rho=record.q, theta=theta,
            x_rate=record.z_rate.real, y_rate=record.z_rate.imag,
            rho_rate=record.q_rate, theta_rate=np.zeros_like(theta) + cage,
            turns=Turns.rolling(bearing, operation, time[:, None]),
        )  # fmt: skip

    def accelerations(self, time, z, q, turn):
        """Of hub and elements, and the power that the held angles take up, W; `turn` is exp(−iθ)."""
        self.follow(time)
        line = q - z * turn  # from hub to element, in the element's own frame
        distance = np.abs(line)
        np.subtract(self.reach, distance, out=self.depth_inner)
        np.subtract(q, self.track, out=self.depth_outer)
        if self.surfaces is None:
            self.law_forces()
        else:
            outward = self.first + self.spacing + self.cage_turn(time)
            self.surface_forces(self.surfaces, time, outward + np.angle(line), outward, distance)
            self.met_at = q
        self.line, self.distance = line, distance
        self.push = push = self.force_inner / distance * line
        if self.surfaces is not None:
            push *= self.aside
        on_hub = -complex(np.vdot(turn, push))  # vdot conjugates: back to the fixed frame
        q_acc = push.real - self.force_outer
        q_acc *= self.per_mass
        q_acc += self.cage_squared * q
        power = self.held_power(z, on_hub)
        if self.surfaces is not None:
            power += self.drive_power(self.cage)
        if self.gravity > 0.0:
            q_acc += self.fall * turn.imag
            power += self.cage_weight * float(q.dot(turn.real))
        if self.cage_gain != 0.0:  # of the elements' angular momentum; the rest of that is in `Completion`
            power -= self.mass * self.cage * self.cage_gain * float(q.dot(q))
        return self.hub_acceleration(on_hub, z, time), q_acc, power

    def outward(self, turn):
        """Directions of the outer contacts' forces on the outer ring, at the positions last seen."""
        found = turn.conj()
        return found if self.surfaces is None else found * (1.0 - 1j * self.met_outer.slope / self.met_at)

    def contacts_along(self, push, outer):
        """Contacts' forces on the elements along the circle, N: of inner ones, along own axes, and of outer ones."""
        if self.surfaces is None:
            return push.imag
        return push.imag + outer * self.met_outer.slope / self.met_at

    def held_power(self, z: complex, on_hub: complex) -> float:
        """Power that held angles take up from forces on the hub, W: their moment times the cage's speed."""
        return self.cage * (z.real * on_hub.imag - z.imag * on_hub.real)

    def damper(self, z_rate, q_rate, q, z, turn, coefficients):
        """Accelerations of hub and elements by the dampers, the loss and the power held angles take up, W.

        At the positions last seen by `accelerations`.
        """
        # the line's rate in the turning frame; the frame's own turn moves only the hub in it
        rate = q_rate - (z_rate - 1j * self.cage * z) * turn
        unit, opening, driven = self.line / self.distance, q_rate, 0.0
        if self.surfaces is not None:
            unit = unit * self.aside
        closing = -(rate * unit.conj()).real
        if self.surfaces is not None:
            inner_passing, outer_passing = self.passing(self.cage)
            closing, opening = closing + inner_passing, opening + outer_passing
        inner = damper_force(self.force_inner, closing, coefficients[0])
        outer = damper_force(self.force_outer, opening, coefficients[1])
        if self.surfaces is not None:
            driven = np.dot(inner, inner_passing) + np.dot(outer, outer_passing)
        push = inner * unit
        self.damped = push, outer
        on_hub = -complex(np.vdot(turn, push))
        loss = np.dot(inner, closing) + np.dot(outer, opening)
        return on_hub / self.inner_mass, (push.real - outer) / self.mass, loss, self.held_power(z, on_hub) + driven


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

    def unpack(self, record, time) -> State:
        """Stored samples of an `integrate.Record` as generalised coordinates; angles in (−π, π]."""
        rho, theta = np.abs(record.q), np.angle(record.q)
        along = record.q_rate * record.q.conj() / rho
        return State(
            x=record.z.real, y=record.z.imag, rho=rho, theta=theta,
            x_rate=record.z_rate.real, y_rate=record.z_rate.imag, rho_rate=along.real, theta_rate=along.imag / rho,
            turns=Turns.rolling(self.problem.bearing, self.problem.operation, time[:, None]),
        )  # fmt: skip

    def accelerations(self, time, z, q, turn):
        """Of hub and elements, and the power that turning bodies takes where surfaces are not perfect, W."""
        self.follow(time)
        line = q - z
        distance, rho = np.abs(line), np.abs(q)
        np.subtract(self.reach, distance, out=self.depth_inner)
        np.subtract(rho, self.track, out=self.depth_outer)
        if self.surfaces is None:
            self.law_forces()
        else:
            self.surface_forces(self.surfaces, time, np.angle(line), np.angle(q), distance)
        self.line, self.distance, self.out, power = line, distance, q / rho, 0.0
        push, back = self.force_inner / distance * line, self.force_outer / rho * q
        if self.surfaces is not None:
            outer_aside = 1.0 - 1j * self.met_outer.slope / rho
            self.out *= outer_aside
            push, back, power = push * self.aside, back * outer_aside, self.drive_power(0.0)
        q_acc = (push - back) / self.mass - 1j * self.gravity
        return self.hub_acceleration(-complex(push.sum()), z, time), q_acc, power

    def outward(self, turn):
        """Directions of the outer contacts' forces on the outer ring, at the positions last seen."""
        return self.out

    def damper(self, z_rate, q_rate, q, z, turn, coefficients):
        """Accelerations of hub and elements by the dampers, the loss and the power held angles take up, W.

        At the positions last seen by `accelerations`.
        """
        unit, out, driven = self.line / self.distance, self.out, 0.0
        if self.surfaces is not None:
            unit = unit * self.aside
        closing = -((q_rate - z_rate) * unit.conj()).real
        opening = (q_rate * out.conj()).real
        if self.surfaces is not None:
            inner_passing, outer_passing = self.passing(0.0)
            closing, opening = closing + inner_passing, opening + outer_passing
        inner = damper_force(self.force_inner, closing, coefficients[0])
        outer = damper_force(self.force_outer, opening, coefficients[1])
        if self.surfaces is not None:
            driven = float(np.dot(inner, inner_passing) + np.dot(outer, outer_passing))
        push = inner * unit
        self.damped = push, outer
        loss = np.dot(inner, closing) + np.dot(outer, opening)
        # Python's own complex number, as in the other accelerations: a stored state goes on with the same arithmetic
        return complex(-push.sum() / self.inner_mass), (push - outer * out) / self.mass, loss, driven


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
