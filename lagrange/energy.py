"""Kinetic and potential energy: equations (2), (3), (14)-(17) of the paper.

The paper's sums over inner ring, motor and rolling elements; inner ring and motor shaft move as one mass
M = m_in + m_R. Rotation is kept apart: by the kinematics it follows from the shaft's speed, and no equation
of motion feels it.
"""

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.kinematics import kinematics
from lagrange.motion import ContactState, State
from lagrange.raceway_laws import ContactLaws


def kinetic_energy(bearing: Bearing, operation: Operation, state: State) -> np.ndarray:
    """T of the translations, J, (...,): ½ M (ẋ² + ẏ²) + Σ ½ m (ρ̇² + ρ² θ̇²). Source: (2), (14).

    In a housing that moves hub and elements move with it, and it has its own with the outer ring.
    """
    hub = np.asarray(state.x_rate) ** 2 + np.asarray(state.y_rate) ** 2
    elements = np.sum(state.rho_rate**2 + (state.rho * state.theta_rate) ** 2, axis=-1)
    alone = 0.5 * (operation.inner_mass * hub + bearing.roller_mass * elements)
    housing = operation.mounting.housing
    if housing is None:
        return alone
    x, y = np.asarray(state.ring_x_rate), np.asarray(state.ring_y_rate)
    cos, sin, around = np.cos(state.theta), np.sin(state.theta), state.rho * state.theta_rate
    along_x = bearing.roller_mass * np.sum(state.rho_rate * cos - around * sin, axis=-1)
    along_y = bearing.roller_mass * np.sum(state.rho_rate * sin + around * cos, axis=-1)
    along_x, along_y = along_x + operation.inner_mass * state.x_rate, along_y + operation.inner_mass * state.y_rate
    carried = operation.inner_mass + bearing.n_rollers * bearing.roller_mass
    carrying = housing.mass + bearing.outer_ring_mass
    return alone + along_x * x + along_y * y + 0.5 * (carried + carrying) * (x**2 + y**2)


def rotation_energy(bearing: Bearing, operation: Operation):
    """Energy of shaft and rolling elements turning about their own axes, J, at the operation's speed, of its shape.

    The shaft is taken as a solid cylinder in the bore, with the mass that the inner ring leaves of M.
    """
    turning = kinematics(bearing, operation.speed)
    share = 0.4 if isinstance(bearing, BallBearing) else 0.5
    element = share * bearing.roller_mass * bearing.roller_radius**2
    ring = 0.5 * bearing.inner_ring_mass * (bearing.bore_radius**2 + bearing.inner_raceway_radius**2)
    shaft = 0.5 * max(operation.inner_mass - bearing.inner_ring_mass, 0.0) * bearing.bore_radius**2
    return 0.5 * ((ring + shaft) * turning.shaft**2 + bearing.n_rollers * element * turning.roller**2)


def contact_energy(laws: ContactLaws, contacts: ContactState) -> np.ndarray:
    """V_contact, J, (...,): ∫ Q dδ of every contact, K δ^(n+1)/(n+1) of a power law. Source: (17)."""
    own = contacts.laws(laws)
    return np.sum(own.inner.potential(contacts.inner) + own.outer.potential(contacts.outer), axis=-1)


def gravity_energy(bearing: Bearing, operation: Operation, state: State) -> np.ndarray:
    """V of the weights, J, (...,): M g y + Σ m g ρ sin θ. Source: (3), (14)."""
    elements = np.sum(state.rho * np.sin(state.theta), axis=-1)
    return operation.gravity * (operation.inner_mass * np.asarray(state.y) + bearing.roller_mass * elements)


def potential_energy(
    bearing: Bearing, operation: Operation, laws: ContactLaws, state: State, contacts: ContactState
) -> np.ndarray:
    """V, J, (...,): contacts and weights; the load W is a generalised force, not part of it. Source: (3)."""
    return contact_energy(laws, contacts) + gravity_energy(bearing, operation, state)
