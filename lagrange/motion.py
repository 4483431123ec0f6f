"""The N_b + 2 equations of motion (21)-(23), the θ equation the paper lacks, accelerations from them, and energies.

Every function works on one instant or on many: hub quantities are (...,), those of the rolling elements
(..., n_rollers). y points up, the load W acts along −y. The signs are those of Lagrange's equations of T and V.
Inner ring and motor shaft move as one mass M = m_in + m_R. Rotation is kept apart: by the kinematics it follows from
the shaft's speed, and stands in no equation of motion.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping, damper_force
from lagrange.contact.laws import ContactLaws
from lagrange.equations import Overlaps, contact_resultant, error_forces, overlaps
from lagrange.kinematics import kinematics
from lagrange.surface.deviation import UNTURNED, Turns
from lagrange.surface.edges import softened
from lagrange.tilt import TiltedContacts, TiltedLaws, Tilts, hub_axial_inertia, tilted_contacts, turning_speeds


@dataclass(frozen=True, kw_only=True)
class State:
    """Generalised coordinates and their rates. m, rad, m/s, rad/s."""

    x: np.ndarray | float  # (...,), centre of the inner ring
    y: np.ndarray | float
    rho: np.ndarray  # (..., n_rollers), polar coordinates of the rolling elements' centres
    theta: np.ndarray
    x_rate: np.ndarray | float
    y_rate: np.ndarray | float
    rho_rate: np.ndarray
    theta_rate: np.ndarray
    # (...,), where the outer ring's centre is, from which the other places are, and how fast a housing moves it
    ring_x: np.ndarray | float = 0.0
    ring_y: np.ndarray | float = 0.0
    ring_x_rate: np.ndarray | float = 0.0
    ring_y_rate: np.ndarray | float = 0.0
    turns: Turns = UNTURNED  # prescribed; matter where surfaces are not perfect
    tilts: Tilts | None = None  # None: axes stay parallel


@dataclass(frozen=True, kw_only=True)
class ContactState(Overlaps):
    """Geometry and forces of the contacts in a state, each (..., n_rollers); overlaps are δ_in (26) and δ_out (27)."""

    inner_force: np.ndarray  # N, >= 0, 0 outside the load zone: (24), (25)
    outer_force: np.ndarray
    inner_closing: np.ndarray  # m/s, rates of the overlaps, as bodies move and surfaces pass
    outer_closing: np.ndarray
    inner_passing: np.ndarray | float = 0.0  # m/s, the part of them by ring and rollers that turn on under the contact
    outer_passing: np.ndarray | float = 0.0
    inner_damper: np.ndarray | float = 0.0  # N, the dampers' part of the forces
    outer_damper: np.ndarray | float = 0.0
    tilted: TiltedContacts | None = None  # None: axes stay parallel


class StatedDampers(NamedTuple):
    """Dampers of contacts that have been found before, in place of those that rates give; (..., n_rollers)."""

    inner_force: np.ndarray  # N, at least as much as lets springs push
    outer_force: np.ndarray
    inner_moment: np.ndarray | float = 0.0  # N m, of contacts that tilt
    outer_moment: np.ndarray | float = 0.0


def contact_state(
    bearing: Bearing, laws: ContactLaws | TiltedLaws, state: State, damping: ContactDamping | StatedDampers = UNDAMPED
) -> ContactState:
    """Geometry and forces of every contact.

    Parameters
    ----------
    laws : of tilted contacts where the state has tilts
    damping : of each closed contact, or what it has given; it never makes a contact pull

    Errors
    ------
    Round-off: forces to about 1e-14 relative, of exactly known coordinates; the last digit of ρ itself is 3e-18 m.

    Source: (18), (19), (24)-(27) of the paper.
    """
    turns, tilts = state.turns, state.tilts
    found = overlaps(bearing, state.x, state.y, state.rho, state.theta).on_surfaces(bearing, turns)
    tilted: TiltedContacts | None = None
    own: list[Any] = []  # laws, and below pairs, of inner and outer contacts
    passing: tuple[Any, Any] = (0.0, 0.0)
    dampers: tuple[Any, Any] = (0.0, 0.0)
    if isinstance(laws, TiltedLaws):
        if tilts is None:
            raise ValueError("contacts of tilted rollers ask for a state with tilts")
        tilted, *forces = tilted_contacts(laws, found, tilts)
        found = found.at_contact(*tilted.falls)
    else:
        own = [softened(laws.inner, found.inner_compliance), softened(laws.outer, found.outer_compliance)]
        forces = [own[0].force(found.inner), own[1].force(found.outer)]
        found = found.at_force(*forces)
    inner, outer = found.surfaces
    if inner is not None and outer is not None:
        passing = (
            inner.passing(turns.inner_ring_speed, turns.roller_speed),
            outer.passing(turns.outer_ring_speed, turns.roller_speed),
        )
    vx, vy = np.asarray(state.x_rate)[..., None], np.asarray(state.y_rate)[..., None]
    along, across = vx * found.cos + vy * found.sin, vy * found.cos - vx * found.sin
    apart = state.rho_rate - along, state.rho * state.theta_rate - across
    closing = (
        -(found.radial * apart[0] + found.tangential * apart[1]) + passing[0],
        state.rho_rate - found.outer_slope * state.rho * state.theta_rate + passing[1],
    )
    if isinstance(damping, StatedDampers):
        dampers = damper_force(forces[0], damping.inner_force, 1.0), damper_force(forces[1], damping.outer_force, 1.0)
    elif damping.acts and tilted is not None and tilts is not None:
        turning = turning_speeds(tilted, tilts, state.theta_rate, found, apart)
        tilted, *dampers = tilted.damped(damping, closing, turning, bearing.roller_length)
    elif damping.acts:
        slopes = own[0].slope(found.inner), own[1].slope(found.outer)
        dampers = tuple(
            damper_force(force, speed, damping.coefficient(force, slope))
            for force, speed, slope in zip(forces, closing, slopes, strict=True)
        )
    inner_force, outer_force = forces[0] + dampers[0], forces[1] + dampers[1]
    if tilted is not None:
        if isinstance(damping, StatedDampers):  # without a force there is no moment
            tilted = tilted.with_moments(
                np.where(inner_force > 0.0, damping.inner_moment, -tilted.inner_moment),
                np.where(outer_force > 0.0, damping.outer_moment, -tilted.outer_moment),
            )
        found = tilted.turned(found, inner_force)
    return ContactState(
        **vars(found), inner_force=inner_force, outer_force=outer_force,
        inner_closing=closing[0], outer_closing=closing[1], inner_passing=passing[0], outer_passing=passing[1],
        inner_damper=dampers[0], outer_damper=dampers[1], tilted=tilted,
    )  # fmt: skip


def radial_equations(
    bearing: Bearing, operation: Operation, state: State, contacts: ContactState, rho_acceleration
) -> np.ndarray:
    """Left sides of (21), N, (..., n_rollers): m ρ̈ − m ρ θ̇² + m g sin θ − Q_in ∂χ/∂ρ + Q_out."""
    m = bearing.roller_mass
    inertia = m * (rho_acceleration - state.rho * state.theta_rate**2 + operation.gravity * contacts.sin)
    return inertia - contacts.inner_force * contacts.radial + contacts.outer_force


def angular_equations(
    bearing: Bearing, operation: Operation, state: State, contacts: ContactState, theta_acceleration
) -> np.ndarray:
    """Left sides of the θ equations, N m, (..., n_rollers): the moment a cage must give; 0 for a free element.

    m ρ² θ̈ + 2 m ρ ρ̇ θ̇ + m g ρ cos θ − Q_in ρ (x sin θ − y cos θ)/χ, on perfect surfaces; else the slopes' parts too.
    """
    m, rho = bearing.roller_mass, state.rho
    inertia = rho * theta_acceleration + 2.0 * state.rho_rate * state.theta_rate
    weight = operation.gravity * contacts.cos
    aside = contacts.inner_force * contacts.tangential + contacts.outer_force * contacts.outer_slope
    return rho * (m * (inertia + weight) - aside)


def hub_equations(operation: Operation, state: State, contacts: ContactState, x_acceleration, y_acceleration):
    """Left sides of (22) and of (23) with the load moved over, N, each (...,); 0 in a motion of the model.

    Accelerations are those in the fixed frame.
    The operation's loads may be of the same shape: `Operation.at`. A shaft's springs and dashpots act beside the load.
    """
    shaft, held = operation.mounting.shaft, (0.0, 0.0)
    if shaft is not None:
        held = (
            shaft.force(state.x + state.ring_x, state.x_rate + state.ring_x_rate),
            shaft.force(state.y + state.ring_y, state.y_rate + state.ring_y_rate),
        )
    pushed = contact_resultant(contacts, contacts.inner_force)
    return error_forces(operation, x_acceleration, y_acceleration, *pushed, held)


def housing_accelerations(bearing: Bearing, operation: Operation, state: State, contacts: ContactState):
    """Ẍ, Ÿ of the outer ring, m/s², each (...,), by contacts and its housing's springs, dashpots, weight; 0 without."""
    housing = operation.mounting.housing
    if housing is None:
        return 0.0, 0.0
    mass = housing.mass + bearing.outer_ring_mass
    x = np.sum(contacts.outer_force * (contacts.cos + contacts.outer_slope * contacts.sin), axis=-1)
    y = np.sum(contacts.outer_force * (contacts.sin - contacts.outer_slope * contacts.cos), axis=-1)
    held_x = housing.stiffness * state.ring_x + housing.damping * state.ring_x_rate
    held_y = housing.stiffness * state.ring_y + housing.damping * state.ring_y_rate
    return (x - held_x) / mass, (y - held_y) / mass - operation.gravity


def accelerations(
    bearing: Bearing, operation: Operation, state: State, contacts: ContactState, ring_acceleration=(0.0, 0.0)
):
    """ẍ, ÿ, (...,), m/s²; ρ̈, m/s², and θ̈ of free elements, rad/s², (..., n_rollers).

    The equations are linear in the accelerations, and each holds one of them. With angles from kinematics (20) leave
    θ̈ unused: it is what the element would do without a cage, and m ρ (ω̇ − θ̈) the force along the pitch circle that
    keeps it from that. ẍ, ÿ are those in the fixed frame; ρ̈, θ̈ are about the outer ring's centre, whose own
    Ẍ, Ÿ, (...,), m/s², are `ring_acceleration`.
    """
    error_x, error_y = hub_equations(operation, state, contacts, 0.0, 0.0)
    x, y = (np.asarray(each)[..., None] for each in ring_acceleration)
    cos, sin, m, hub = contacts.cos, contacts.sin, bearing.roller_mass, operation.inner_mass
    radial = radial_equations(bearing, operation, state, contacts, x * cos + y * sin)
    angular = angular_equations(bearing, operation, state, contacts, (y * cos - x * sin) / state.rho)
    return -error_x / hub, -error_y / hub, -radial / m, -angular / (m * state.rho**2)


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
    """Energy of rings, shaft and rolling elements turning about their own axes, J, at the operation's speeds.

    The shaft is taken as a solid cylinder in the bore, with the mass that the inner ring leaves of M; one that is the
    inner ring as wide as its raceway.
    """
    turning = kinematics(bearing, *operation.ring_speeds)
    element = (0.4 if isinstance(bearing, BallBearing) else 0.5) * bearing.roller_mass * bearing.roller_radius**2
    outer = 0.5 * bearing.outer_ring_mass * (bearing.outer_raceway_radius**2 + bearing.outside_radius**2)
    hub = hub_axial_inertia(bearing, operation)
    inside = 0.5 * (hub * turning.shaft**2 + bearing.n_rollers * element * turning.roller**2)
    return inside + 0.5 * outer * turning.outer_ring**2


def contact_energy(laws: ContactLaws, contacts: ContactState) -> np.ndarray:
    """V_contact, J, (...,): ∫ Q dδ of every contact, K δ^(n+1)/(n+1) of a power law. Source: (17)."""
    if contacts.tilted is not None:
        return np.sum(contacts.tilted.energy, axis=-1)
    inner, outer = softened(laws.inner, contacts.inner_compliance), softened(laws.outer, contacts.outer_compliance)
    return np.sum(inner.potential(contacts.inner) + outer.potential(contacts.outer), axis=-1)
