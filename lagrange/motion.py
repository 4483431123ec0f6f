"""The N_b + 2 equations of motion (21)-(23), the θ equation the paper lacks, those of tilt, accelerations, energies.

Every function works on one instant or on many: hub quantities are (...,), those of the rolling elements
(..., n_rollers). y points up, the load W acts along −y. The signs are those of Lagrange's equations of T and V.
Inner ring and motor shaft move as one mass M = m_in + m_R. Rotation is kept apart: by the kinematics it follows from
the shaft's speed, and stands in no equation of motion.

A body's axis at the height z over the plane section is at its place there plus z times its slope: of a roller
a = τ e_r (the tilt τ moves the +z end outwards; guides keep it from skewing), of the hub b. Slopes are small.
A contact closes by δ − P(z) − ψ z, with ψ = (a − b)·n at the inner raceway, −a·e_r at the outer one; its energy U(δ, ψ)
gives the force Q = ∂U/∂δ and the moment M = −∂U/∂ψ = ∫ q z dz. Where the slopes have a part across the normal n, a
moment turns the contact's force: by M (u·t)/χ along t = e_z × n, without which no energy would be conserved.

Source: of tilts Lagrange's equations of T = ½ I_t |ȧ|² − ½ I_a w (a_x ȧ_y − a_y ȧ_x), w the spin, and V = Σ U; the
tests derive them by computer algebra. Equation (1) of docs/tilted_motion.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.axial.slices import Axial, alone, contact_slices
from lagrange.axial.table import TiltedContact, TiltedLaw, in_series
from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping, damper_force, tilted_damper
from lagrange.contact.laws import ContactLaws
from lagrange.equations import Overlaps, contact_resultant, error_forces, overlaps
from lagrange.kinematics import kinematics
from lagrange.surface.deviation import UNTURNED, Falls, SurfaceDeviation, Turns

Numbers = ndarray | float  # of many instants or of one


class Tilts(NamedTuple):
    """Slopes of the bodies' axes and their rates; rad, rad/s."""

    tilt: ndarray  # (..., n_rollers), τ
    tilt_rate: ndarray
    slope_x: Numbers  # (...,), of the hub, b
    slope_y: Numbers
    slope_x_rate: Numbers = 0.0
    slope_y_rate: Numbers = 0.0

    def as_sample(self) -> "Tilts":
        """Those of one instant as a sample, time first."""
        return Tilts(*(np.asarray(value)[None] for value in self))


class HubTilt(NamedTuple):
    """How the hub's axis stands: held at a slope, or free about it with an inertia, on the shaft's stiffness."""

    slope_x: float  # rad, at which the shaft's springs are slack
    slope_y: float
    inertia: float = 0.0  # kg m², about an axis across; 0: held
    stiffness: float = 0.0  # N m/rad

    @property
    def slope(self) -> ndarray:
        return np.array([self.slope_x, self.slope_y])

    @property
    def is_free(self) -> bool:
        return self.inertia > 0.0


def hub_tilt(operation: Operation, axial: Axial) -> HubTilt:
    """The hub's slope, b = −misalignment along y: its +z end goes towards the load."""
    inertia, stiffness = axial.hub_tilt_inertia or 0.0, axial.shaft_tilt_stiffness
    return HubTilt(slope_x=0.0, slope_y=-operation.misalignment, inertia=inertia, stiffness=stiffness)


def sliced_laws(bearing: Bearing, axial: Axial, laws: ContactLaws) -> tuple[TiltedLaw, ...]:
    """Contacts by slices that stand alone, each with its share of the whole length's law."""
    return tuple(map(alone, contact_slices(bearing, axial, laws)))


def roller_inertias(bearing: Bearing) -> tuple[float, float]:
    """I_t of a roller about an axis across its own, m (3 r² + L²)/12, and I_a about its own, ½ m r², kg m²."""
    m, r, length = bearing.roller_mass, bearing.roller_radius, bearing.roller_length
    return m * (3.0 * r**2 + length**2) / 12.0, 0.5 * m * r**2


def hub_axial_inertia(bearing: Bearing, operation: Operation) -> float:
    """Of inner ring and shaft about their axis, kg m²: the shaft a solid cylinder in the bore with what M has left."""
    ring = 0.5 * bearing.inner_ring_mass * (bearing.bore_radius**2 + bearing.inner_raceway_radius**2)
    radius = bearing.bore_radius or bearing.inner_raceway_radius
    return ring + 0.5 * max(operation.inner_mass - bearing.inner_ring_mass, 0.0) * radius**2


class Misalignments(NamedTuple):
    """How contacts are misaligned: ψ, rad, and the inner slopes' part across the normal, u·t, rad; (..., n_rollers)."""

    inner: ndarray
    outer: ndarray
    across: ndarray


def misalignments(found: Overlaps, tilts: Tilts) -> Misalignments:
    """ψ and u·t of contacts."""
    bx, by = np.asarray(tilts.slope_x)[..., None], np.asarray(tilts.slope_y)[..., None]
    out, around = tilts.tilt - (bx * found.cos + by * found.sin), bx * found.sin - by * found.cos
    radial, tangential = found.circle
    return Misalignments(out * radial + around * tangential, -tilts.tilt, around * radial - out * tangential)


def met(law: TiltedLaw, approach, slope, surface: SurfaceDeviation | None) -> TiltedContact:
    """`TiltedLaw.at` of contacts on a surface; None: a perfect circle."""
    if surface is None:
        return law.at(approach, slope)
    if surface.part is not None and law.has_part:
        return law.at(approach, slope, surface.part.sinkage, surface.compliance, surface.part.compliance)
    return in_series(law.at, approach, slope, surface.compliance) if surface.soft else law.at(approach, slope)


def falls(of: TiltedContact, surface: SurfaceDeviation | None) -> Falls:
    """By how much contacts' energies fall, over their forces, as a surface changes under them; None: a circle."""
    if surface is None:
        return Falls()
    over = 1.0 / np.where(of.force > 0.0, of.force, np.inf)
    return Falls(over * of.part, over * of.edges, over * of.part_edges)


class TiltedContacts(NamedTuple):
    """What tilted contacts have beside their forces; arrays (..., n_rollers)."""

    inner_moment: ndarray  # M, N m
    outer_moment: ndarray
    normal: tuple[ndarray, ndarray]  # of the inner contact, along e_r and e_t, as M acts on slopes
    dampers: tuple[Numbers, Numbers] = (0.0, 0.0)  # N m, the dampers' part of both moments
    lost: Numbers = 0.0  # W, in these

    @property
    def outwards(self) -> ndarray:
        """Moment of both contacts that tilts a roller outwards, N m."""
        return self.inner_moment * self.normal[0] - self.outer_moment

    @property
    def backwards(self) -> ndarray:
        """Moment of both contacts that skews a roller backwards, N m."""
        return -self.inner_moment * self.normal[1]

    def on_hub(self, cos, sin) -> tuple[ndarray, ndarray]:
        """Moment of the inner contacts on the hub's slope, along x and y, (...,), N m; angles of the rollers."""
        out, around = (-self.inner_moment * each for each in self.normal)
        return np.sum(out * cos - around * sin, axis=-1), np.sum(out * sin + around * cos, axis=-1)


@dataclass(frozen=True, kw_only=True)
class State:
    """Generalised coordinates and their rates. m, rad, m/s, rad/s."""

    x: Numbers  # (...,), centre of the inner ring
    y: Numbers
    rho: ndarray  # (..., n_rollers), polar coordinates of the rolling elements' centres
    theta: ndarray
    x_rate: Numbers
    y_rate: Numbers
    rho_rate: ndarray
    theta_rate: ndarray
    # (...,), where the outer ring's centre is, from which the other places are, and how fast a housing moves it
    ring_x: Numbers = 0.0
    ring_y: Numbers = 0.0
    ring_x_rate: Numbers = 0.0
    ring_y_rate: Numbers = 0.0
    turns: Turns = UNTURNED  # prescribed; matter where surfaces are not perfect
    tilts: Tilts | None = None  # None: axes stay parallel


@dataclass(frozen=True, kw_only=True)
class ContactState(Overlaps):
    """Geometry and forces of the contacts in a state, each (..., n_rollers); overlaps are δ_in (26) and δ_out (27)."""

    inner_force: ndarray  # N, >= 0, 0 outside the load zone: (24), (25)
    outer_force: ndarray
    inner_closing: ndarray  # m/s, rates of the overlaps, as bodies move and surfaces pass
    outer_closing: ndarray
    energy: ndarray  # J, of both contacts of a roller, ∫ Q dδ: (17)
    inner_passing: Numbers = 0.0  # m/s, the part of them by ring and rollers that turn on under the contact
    outer_passing: Numbers = 0.0
    inner_damper: Numbers = 0.0  # N, the dampers' part of the forces
    outer_damper: Numbers = 0.0
    tilted: TiltedContacts | None = None  # None: axes stay parallel


class StatedDampers(NamedTuple):
    """Dampers of contacts that have been found before, in place of those that rates give; (..., n_rollers)."""

    inner_force: ndarray  # N, at least as much as lets springs push
    outer_force: ndarray
    inner_moment: Numbers = 0.0  # N m, of contacts that tilt
    outer_moment: Numbers = 0.0


def contact_state(
    bearing: Bearing, laws: Sequence[TiltedLaw], state: State, damping: ContactDamping | StatedDampers = UNDAMPED
) -> ContactState:
    """Geometry and forces of every contact.

    laws : of tilted contacts where the state has tilts
    damping : of each closed contact, or what it has given; it never makes a contact pull

    Errors: round-off: forces to about 1e-14, relative, of exactly known coordinates; the last digit of ρ is 3e-18 m.

    Source: (18), (19), (24)-(27) of the paper.
    """
    turns, tilts = state.turns, state.tilts
    found = overlaps(bearing, state.x, state.y, state.rho, state.theta).on_surfaces(bearing, turns)
    at = None if tilts is None else misalignments(found, tilts)
    slopes = (0.0, 0.0) if at is None else at[:2]  # of inner and outer contacts
    springs = list(map(met, laws, (found.inner, found.outer), slopes, found.surfaces))
    found = found.at_contact(*map(falls, springs, found.surfaces))
    vx, vy = np.asarray(state.x_rate)[..., None], np.asarray(state.y_rate)[..., None]
    out = state.rho_rate - (vx * found.cos + vy * found.sin)  # the rollers' velocity from the hub's, along e_r and e_t
    around = state.rho * state.theta_rate - (vy * found.cos - vx * found.sin)
    speeds = turns.inner_ring_speed, turns.outer_ring_speed
    passing = [0.0 if surface is None else surface.passing(speed, turns.roller_speed)
               for surface, speed in zip(found.surfaces, speeds, strict=True)]  # fmt: skip
    closing = (-(found.radial * out + found.tangential * around) + passing[0],
        state.rho_rate - found.outer_slope * state.rho * state.theta_rate + passing[1],)  # fmt: skip
    dampers: Any = 0.0, 0.0
    moments: Any = 0.0, 0.0
    turning: Any = 0.0, 0.0  # rates of misalignments ψ, rad/s
    if isinstance(damping, StatedDampers):
        dampers = [damper_force(here.force, given, 1.0) for here, given in zip(springs, damping, strict=False)]
    elif damping.acts:
        if tilts is not None and at is not None:
            bx, by = np.asarray(tilts.slope_x_rate)[..., None], np.asarray(tilts.slope_y_rate)[..., None]
            (radial, tangential), outwards = found.circle, tilts.tilt_rate - (bx * found.cos + by * found.sin)
            skewing = state.theta_rate * tilts.tilt - (by * found.cos - bx * found.sin)
            passed = (around * radial - out * tangential) / found.distance
            turning = outwards * radial + skewing * tangential + at.across * passed, -tilts.tilt_rate
        tilting = zip(springs, closing, turning, strict=True)
        both = [tilted_damper(here, damping, rate, turn, bearing.roller_length) for here, rate, turn in tilting]
        dampers, moments = zip(*both, strict=True)
    inner_force, outer_force = (here.force + damper for here, damper in zip(springs, dampers, strict=True))
    tilted = None
    if at is not None:
        if isinstance(damping, StatedDampers):  # without a force there is no moment
            stated = zip((inner_force, outer_force), damping[2:], springs, strict=True)
            moments = [np.where(force > 0.0, given, -here.moment) for force, given, here in stated]
        tilted = TiltedContacts(inner_moment=springs[0].moment + moments[0],
            outer_moment=springs[1].moment + moments[1], normal=found.circle, dampers=tuple(moments),
            lost=-(moments[0] * turning[0] + moments[1] * turning[1]))  # fmt: skip
        push, closed = tilted.inner_moment * at.across / found.distance, inner_force > 0.0
        found = replace(found, aside=found.aside + np.where(closed, push / np.where(closed, inner_force, 1.0), 0.0))
    return ContactState(**vars(found), inner_force=inner_force, outer_force=outer_force,
        energy=springs[0].energy + springs[1].energy, inner_closing=closing[0], outer_closing=closing[1],
        inner_passing=passing[0], outer_passing=passing[1], inner_damper=dampers[0], outer_damper=dampers[1],
        tilted=tilted)  # fmt: skip


def radial_equations(
    bearing: Bearing, operation: Operation, state: State, contacts: ContactState, rho_acceleration
) -> ndarray:
    """Left sides of (21), N, (..., n_rollers): m ρ̈ − m ρ θ̇² + m g sin θ − Q_in ∂χ/∂ρ + Q_out."""
    m = bearing.roller_mass
    inertia = m * (rho_acceleration - state.rho * state.theta_rate**2 + operation.gravity * contacts.sin)
    return inertia - contacts.inner_force * contacts.radial + contacts.outer_force


def angular_equations(
    bearing: Bearing, operation: Operation, state: State, contacts: ContactState, theta_acceleration
) -> ndarray:
    """Left sides of the θ equations, N m, (..., n_rollers): the moment a cage must give; 0 for a free element.

    m ρ² θ̈ + 2 m ρ ρ̇ θ̇ + m g ρ cos θ − Q_in ρ (x sin θ − y cos θ)/χ, on perfect surfaces; else the slopes' parts too.
    """
    m, rho = bearing.roller_mass, state.rho
    inertia = rho * theta_acceleration + 2.0 * state.rho_rate * state.theta_rate
    aside = contacts.inner_force * contacts.tangential + contacts.outer_force * contacts.outer_slope
    return rho * (m * (inertia + operation.gravity * contacts.cos) - aside)


def hub_equations(operation: Operation, state: State, contacts: ContactState, x_acceleration, y_acceleration):
    """Left sides of (22) and of (23) with the load moved over, N, each (...,); 0 in a motion of the model.

    Accelerations are those in the fixed frame.
    The operation's loads may be of the same shape: `Operation.at`. A shaft's springs and dashpots act beside the load.
    """
    shaft, (place, rate) = operation.mounting.shaft, _ring(state)
    place, rate = place + state.x + 1j * state.y, rate + state.x_rate + 1j * state.y_rate
    held = 0j if shaft is None else shaft.force(place, rate)
    pushed = contact_resultant(contacts, contacts.inner_force)
    return error_forces(operation, x_acceleration, y_acceleration, *pushed, (held.real, held.imag))


def _ring(state):
    """Place, m, and velocity, m/s, of the outer ring as x + iy, (...,)."""
    return state.ring_x + 1j * state.ring_y, state.ring_x_rate + 1j * state.ring_y_rate


def tilt_equations(
    bearing: Bearing, operation: Operation, state: Any, contacts: Any, tilt_acc, theta_acc
) -> tuple[ndarray, ndarray]:
    """Left sides of the equations of tilt and of skew, N m, (..., n_rollers): moments that something else must give.

    tilt: I_t (τ̈ − θ̇²τ) + I_a w θ̇τ − M_in n·e_r + M_out
    skew: −I_t (2θ̇τ̇ + θ̈τ) + I_a w τ̇ + M_in n·e_t

    The second is the moment of the guides on a roller, which rolls without slip at the spin w.
    """
    across, along = roller_inertias(bearing)
    t, omega = state.tilts, state.theta_rate
    turning = along * np.asarray(kinematics(bearing, *operation.ring_speeds).roller)[..., None]
    return (
        across * (tilt_acc - omega**2 * t.tilt) + turning * omega * t.tilt - contacts.tilted.outwards,
        turning * t.tilt_rate - across * (2.0 * omega * t.tilt_rate + theta_acc * t.tilt) - contacts.tilted.backwards,
    )


def hub_slope_equations(bearing: Bearing, operation: Operation, hub: HubTilt, state: Any, contacts: Any, x_acc, y_acc):
    """Left sides of the equations of the hub's slope along x and y, N m, each (...,): 0 where nothing else holds it.

    I_h b̈ + I_ha Ω (ḃ_y, −ḃ_x) + k (b − b₀) + Σ M_in n; of a hub whose slope is held what the shaft must give.
    """
    t, turning = state.tilts, hub_axial_inertia(bearing, operation) * np.asarray(operation.speed)
    on_x, on_y = contacts.tilted.on_hub(np.cos(state.theta), np.sin(state.theta))
    x = hub.inertia * x_acc + turning * t.slope_y_rate + hub.stiffness * (t.slope_x - hub.slope_x)
    y = hub.inertia * y_acc - turning * t.slope_x_rate + hub.stiffness * (t.slope_y - hub.slope_y)
    return x - on_x, y - on_y


def housing_accelerations(bearing: Bearing, operation: Operation, state: State, contacts: ContactState):
    """Ẍ, Ÿ of the outer ring, m/s², each (...,), by contacts and its housing's springs, dashpots, weight; 0 without."""
    housing = operation.mounting.housing
    if housing is None:
        return 0.0, 0.0
    (place, rate), outwards = _ring(state), contacts.cos + 1j * contacts.sin
    pushed = np.sum(contacts.outer_force * (1.0 - 1j * contacts.outer_slope) * outwards, axis=-1)
    held = housing.stiffness * place + housing.damping * rate
    found = (pushed - held) / (housing.mass + bearing.outer_ring_mass)
    return found.real, found.imag - operation.gravity


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


def kinetic_energy(bearing: Bearing, operation: Operation, state: State, hub: HubTilt | None = None) -> ndarray:
    """T of the translations, J, (...,): ½ M (ẋ² + ẏ²) + Σ ½ m (ρ̇² + ρ² θ̇²), and of tilts. Source: (2), (14).

    In a housing that moves hub and elements move with it, and it has its own with the outer ring. Of rollers that tilt
    ½ I_t |ȧ|², and of the `hub` ½ I_h |ḃ|².
    """
    t, housing, ring = state.tilts, operation.mounting.housing, np.asarray(_ring(state)[1])
    rollers = (state.rho_rate + 1j * state.rho * state.theta_rate) * np.exp(1j * state.theta) + ring[..., None]
    found = 0.5 * operation.inner_mass * np.abs(state.x_rate + 1j * state.y_rate + ring) ** 2
    found = found + 0.5 * bearing.roller_mass * np.sum(np.abs(rollers) ** 2, axis=-1)
    if housing is not None:
        found = found + 0.5 * (housing.mass + bearing.outer_ring_mass) * np.abs(ring) ** 2
    if hub is None or t is None:
        return found
    turning = np.sum(t.tilt_rate**2 + (state.theta_rate * t.tilt) ** 2, axis=-1)
    slope = np.square(t.slope_x_rate) + np.square(t.slope_y_rate)
    return found + 0.5 * (roller_inertias(bearing)[0] * turning + hub.inertia * slope)


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
