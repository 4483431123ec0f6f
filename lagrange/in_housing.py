"""Hub and elements in a housing that moves: what its motion adds to the accelerations of `lagrange.systems`.

All places are from the outer ring's centre, which the housing carries, so that contacts are as on the ground; that
frame does not turn, but it accelerates, and takes as much from every body's acceleration. z is an array of two: the hub
from the ring's centre, and the ring.

Free elements obey Newton's laws, and so does the whole. What holds kinematic angles turns about the ring's centre and
stands outside: its forces on the elements, N_j along the circle, have no counterpart on hub or ring. Their power is

    Σ N_j (ω ρ_j + t_j·Ż),    N_j = m (2 ρ̇_j ω + ρ_j ω̇ + t_j·(Z̈ + g e_y)) − the contacts' force along t_j

Its terms of the first kind are those on the ground but for Z̈; all that goes with ρ̇_j or is a rate of the state is
integrated by parts, which leaves S·Ż − L·Z̈ with S and L of positions alone, and what `held_energy` tells of a state.
Around at least three equally spaced elements Σ (r·Ż)(t·Ż) = 0 and Σ (t·Ż)² = ½ N_b |Ż|².
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lagrange.mounting import flow
from lagrange.systems import FreeAngles, KinematicAngles, Packed

if TYPE_CHECKING:
    from lagrange.first_state import Problem
    from lagrange.motion import State


class _InHousing:
    """To stand before `KinematicAngles` or `FreeAngles`: z is (hub from the ring's centre, ring)."""

    dashpot_rate: float

    def __init__(self, problem):
        super().__init__(problem)
        housing = problem.operation.mounting.housing
        self.ring_mass = housing.mass + problem.bearing.outer_ring_mass
        self.ring_spring_rate = housing.stiffness / self.ring_mass
        self.ring_dashpot_rate = housing.damping / self.ring_mass
        self.carries = self.holds_angles
        self.shift, self.lever = 0j, 0j  # S and L, N and kg m/s

    def pack(self, state):
        found = super().pack(state)
        ring, rate = complex(state.ring_x, state.ring_y), complex(state.ring_x_rate, state.ring_y_rate)
        return Packed(np.array([found.z, ring]), np.array([found.z_rate, rate]), found.q, found.q_rate)

    def unpack(self, record, time):
        (z, ring), (z_rate, ring_rate) = record.z.T, record.z_rate.T
        return replace(
            super().unpack(replace(record, z=z, z_rate=z_rate), time),
            ring_x=ring.real, ring_y=ring.imag, ring_x_rate=ring_rate.real, ring_y_rate=ring_rate.imag,
        )  # fmt: skip

    def own_axes(self, vector, turn):
        """A vector of the fixed axes in the elements' own coordinates."""
        return (vector * turn).real if self.holds_angles else vector

    def accelerations(self, time, z, q, turn):
        hub, ring = z
        hub_acc, q_acc, power = super().accelerations(time, hub, q, turn)
        on_ring = complex(np.dot(self.force_outer, self.outward(turn)))
        ring_acc = on_ring / self.ring_mass - self.ring_spring_rate * ring - 1j * self.gravity
        if self.holds_angles:
            around = complex(np.vdot(turn, q)) * self.mass  # Σ m ρ r
            along = complex(np.vdot(turn, self.contacts_along(self.push, self.force_outer)))
            self.lever = 1j * self.cage * around
            self.shift = (2.0 * self.cage**2 - 1j * self.cage_gain) * around - 1j * along
            self.shift += 0.5j * self.n * self.mass * self.gravity
            power -= (ring_acc.conjugate() * self.lever).real
        self.turn = turn
        hub_acc -= ring_acc + self.spring_rate * ring
        return np.array([hub_acc, ring_acc]), q_acc - self.own_axes(ring_acc, turn), power

    def carried_power(self, z_rate, z_acc, seconds: float) -> float:
        """S·Ż of a kick so long, just made, W."""
        return float(((z_rate[1] - 0.5 * seconds * z_acc[1]).conjugate() * self.shift).real)

    def damper(self, z_rate, q_rate, q, z, turn, coefficients):
        hub_acc, q_acc, loss, taken = super().damper(z_rate[0], q_rate, q, z[0], turn, coefficients)
        push, outer = self.damped
        ring_acc = complex(np.dot(outer, self.outward(turn))) / self.ring_mass
        if self.holds_angles:
            along = complex(np.vdot(turn, self.contacts_along(push, outer)))
            taken -= float((z_rate[1].conjugate() * 1j * along).real + (ring_acc.conjugate() * self.lever).real)
        return np.array([hub_acc - ring_acc, ring_acc]), q_acc - self.own_axes(ring_acc, turn), loss, taken

    @property
    def has_dashpots(self) -> bool:
        return self.dashpot_rate > 0.0 or self.ring_dashpot_rate > 0.0

    def slowed(self, z_rate, z_acc, q_rate, seconds):
        hub, of_hub = flow(self.dashpot_rate, self.inner_mass, z_rate[0] + z_rate[1], z_acc[0] + z_acc[1], seconds)
        ring, of_ring = flow(self.ring_dashpot_rate, self.ring_mass, z_rate[1], z_acc[1], seconds)
        change = complex(ring - z_rate[1])
        held = float((change.conjugate() * (0.5 * seconds * self.shift - self.lever)).real)
        q_rate = q_rate - self.own_axes(change, self.turn)
        return np.array([hub - ring, ring]), q_rate, of_hub + of_ring, held

    def change_power(self, time, z):
        return super().change_power(time, complex(z[0] + z[1]))


class KinematicInHousing(_InHousing, KinematicAngles):
    """Elements on rays that turn with the cage about the outer ring's centre."""


class FreeInHousing(_InHousing, FreeAngles):
    """Free elements; q from the outer ring's centre."""


def system_of(problem: "Problem"):
    """What moves in a problem."""
    if problem.operation.mounting.housing is None:
        return (KinematicAngles if problem.angles == "kinematic" else FreeAngles)(problem)
    return (KinematicInHousing if problem.angles == "kinematic" else FreeInHousing)(problem)


def held_energy(mass: float, state: "State"):
    """What the work against held angles has beside its integrals, J, (...,): see above; `mass` of an element, kg."""
    cos, sin = np.cos(state.theta), np.sin(state.theta)
    x, y = (np.asarray(rate)[..., None] for rate in (state.ring_x_rate, state.ring_y_rate))
    along = y * cos - x * sin
    return mass * np.sum(2.0 * state.rho * state.theta_rate * along + 0.5 * along**2, axis=-1)
