"""Tilt of rollers and the slope of the hub: kinematics, moments of contacts, equations of motion.

A body's axis at the height z over the plane section is at its place there plus z times its slope: of a roller
a = τ e_r (the tilt τ moves the +z end outwards; guides keep it from skewing), of the hub b. Slopes are small.
A contact closes by δ − P(z) − ψ z, with ψ = (a − b)·n at the inner raceway, −a·e_r at the outer one; its energy U(δ, ψ)
gives the force Q = ∂U/∂δ and the moment M = −∂U/∂ψ = ∫ q z dz. Where the slopes have a part across the normal n, a
moment turns the contact's force: by M (u·t)/χ along t = e_z × n, without which no energy would be conserved.

Source: Lagrange's equations of T = ½ I_t |ȧ|² − ½ I_a w (a_x ȧ_y − a_y ȧ_x), w the spin, and V = Σ U; the tests derive
them by computer algebra.

Equation (1) of docs/tilted_motion.md.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from lagrange.axial.slices import Axial, alone, contact_slices
from lagrange.axial.table import TiltedContact, TiltedLaw, in_series
from lagrange.bearing import Bearing, Operation
from lagrange.contact.damping import ContactDamping, tilted_damper
from lagrange.contact.laws import ContactLaws
from lagrange.equations import Overlaps
from lagrange.kinematics import kinematics
from lagrange.surface.deviation import Falls, SurfaceDeviation


class TiltedLaws(NamedTuple):
    """Contacts of a roller with either raceway."""

    inner: TiltedLaw
    outer: TiltedLaw


@dataclass(frozen=True, kw_only=True)
class Tilts:
    """Slopes of the bodies' axes and their rates; rad, rad/s."""

    tilt: np.ndarray  # (..., n_rollers), τ
    tilt_rate: np.ndarray
    slope_x: np.ndarray | float  # (...,), of the hub, b
    slope_y: np.ndarray | float
    slope_x_rate: np.ndarray | float = 0.0
    slope_y_rate: np.ndarray | float = 0.0

    def as_sample(self) -> "Tilts":
        """Those of one instant as a sample, time first."""
        return Tilts(**{name: np.asarray(value)[None] for name, value in vars(self).items()})


@dataclass(frozen=True, kw_only=True)
class HubTilt:
    """How the hub's axis stands: held at a slope, or free about it with an inertia, on the shaft's stiffness."""

    slope_x: float  # rad, at which the shaft's springs are slack
    slope_y: float
    inertia: float = 0.0  # kg m², about an axis across; 0: held
    stiffness: float = 0.0  # N m/rad

    @property
    def slope(self) -> np.ndarray:
        return np.array([self.slope_x, self.slope_y])

    @property
    def is_free(self) -> bool:
        return self.inertia > 0.0


def hub_tilt(operation: Operation, axial: Axial) -> HubTilt:
    """The hub's slope, b = −misalignment along y: its +z end goes towards the load."""
    inertia, stiffness = axial.hub_tilt_inertia or 0.0, axial.shaft_tilt_stiffness
    return HubTilt(slope_x=0.0, slope_y=-operation.misalignment, inertia=inertia, stiffness=stiffness)


def sliced_laws(bearing: Bearing, axial: Axial, laws: ContactLaws) -> TiltedLaws:
    """Contacts by slices that stand alone, each with its share of the whole length's law."""
    return TiltedLaws(*map(alone, contact_slices(bearing, axial, laws)))


class Misalignments(NamedTuple):
    """How contacts are misaligned: ψ, rad, and the inner slopes' part across the normal, u·t, rad; (..., n_rollers)."""

    inner: np.ndarray
    outer: np.ndarray
    across: np.ndarray


def roller_inertias(bearing: Bearing) -> tuple[float, float]:
    """I_t of a roller about an axis across its own, m (3 r² + L²)/12, and I_a about its own, ½ m r², kg m²."""
    m, r, length = bearing.roller_mass, bearing.roller_radius, bearing.roller_length
    return m * (3.0 * r**2 + length**2) / 12.0, 0.5 * m * r**2


def precession_stiffness(bearing: Bearing, speeds):
    """Stiffness against tilt of guided rollers that go round at cage speed, I_a w Ω − I_t Ω², N m/rad.

    `speeds` : of both rings, rad/s
    """
    (across, along), turning = roller_inertias(bearing), kinematics(bearing, *speeds)
    return along * turning.roller * turning.cage - across * turning.cage**2


def hub_axial_inertia(bearing: Bearing, operation: Operation) -> float:
    """Of inner ring and shaft about their axis, kg m²: the shaft a solid cylinder in the bore with what M has left."""
    ring = 0.5 * bearing.inner_ring_mass * (bearing.bore_radius**2 + bearing.inner_raceway_radius**2)
    radius = bearing.bore_radius or bearing.inner_raceway_radius
    return ring + 0.5 * max(operation.inner_mass - bearing.inner_ring_mass, 0.0) * radius**2


def misalignments(found: Overlaps, tilts: Tilts) -> Misalignments:
    """ψ and u·t of contacts."""
    bx, by = np.asarray(tilts.slope_x)[..., None], np.asarray(tilts.slope_y)[..., None]
    out, around = tilts.tilt - (bx * found.cos + by * found.sin), bx * found.sin - by * found.cos
    radial, tangential = found.circle
    return Misalignments(out * radial + around * tangential, -tilts.tilt, around * radial - out * tangential)


@dataclass(frozen=True, kw_only=True)
class TiltedContacts:
    """What tilted contacts have beside their forces; arrays (..., n_rollers)."""

    inner_moment: np.ndarray  # M, N m
    outer_moment: np.ndarray
    energy: np.ndarray  # J, of both contacts of a roller
    at: Misalignments
    normal: tuple[np.ndarray, np.ndarray]  # of the inner contact, along e_r and e_t, as M acts on slopes
    falls: tuple[Falls, Falls] = (Falls(), Falls())
    met: tuple[TiltedContact, ...] = ()  # the springs, inner and outer
    dampers: tuple[np.ndarray | float, np.ndarray | float] = (0.0, 0.0)  # N m, the dampers' part of both moments
    lost: np.ndarray | float = 0.0  # W, in these

    def damped(self, damping: ContactDamping, closing, turning, length: float):
        """The contacts with their dampers' moments, and the dampers' forces, N, inner and outer.

        `closing`, `turning` : rates of approaches, m/s, and misalignments, rad/s, of both; `length` : m, of rollers
        """
        inner, outer = (tilted_damper(self.met[k], damping, closing[k], turning[k], length) for k in (0, 1))
        lost = -(inner[1] * turning[0] + outer[1] * turning[1])
        return replace(self.with_moments(inner[1], outer[1]), lost=lost), inner[0], outer[0]

    def with_moments(self, inner, outer) -> "TiltedContacts":
        """The contacts with these moments of their dampers, N m."""
        moments = {"inner_moment": self.inner_moment + inner, "outer_moment": self.outer_moment + outer}
        return replace(self, **moments, dampers=(inner, outer))

    def turned(self, found: Overlaps, inner_force) -> Overlaps:
        """Overlaps with the directions that moments give inner contacts' forces, N."""
        push, closed = self.inner_moment * self.at.across / found.distance, inner_force > 0.0
        return replace(found, aside=found.aside + np.where(closed, push / np.where(closed, inner_force, 1.0), 0.0))

    @property
    def outwards(self) -> np.ndarray:
        """Moment of both contacts that tilts a roller outwards, N m."""
        return self.inner_moment * self.normal[0] - self.outer_moment

    @property
    def backwards(self) -> np.ndarray:
        """Moment of both contacts that skews a roller backwards, N m."""
        return -self.inner_moment * self.normal[1]

    def on_hub(self, cos, sin) -> tuple[np.ndarray, np.ndarray]:
        """Moment of the inner contacts on the hub's slope, along x and y, (...,), N m; angles of the rollers."""
        out, around = (-self.inner_moment * each for each in self.normal)
        return np.sum(out * cos - around * sin, axis=-1), np.sum(out * sin + around * cos, axis=-1)


def tilted_contacts(laws: TiltedLaws, found: Overlaps, tilts: Tilts) -> tuple[TiltedContacts, np.ndarray, np.ndarray]:
    """What the contacts have beside their forces; both forces, N."""
    at, (on_inner, on_outer) = misalignments(found, tilts), found.surfaces
    inner, outer = met(laws.inner, found.inner, at.inner, on_inner), met(laws.outer, found.outer, at.outer, on_outer)
    more = TiltedContacts(
        inner_moment=inner.moment, outer_moment=outer.moment, energy=inner.energy + outer.energy, at=at,
        normal=found.circle, met=(inner, outer), falls=(falls(inner, on_inner), falls(outer, on_outer)),
    )  # fmt: skip
    return more, inner.force, outer.force


def turning_speeds(
    contacts: TiltedContacts, tilts: Tilts, theta_rate, found: Overlaps, apart
) -> tuple[np.ndarray, np.ndarray]:
    """Rates of misalignments ψ, rad/s, of inner and outer contacts.

    `apart` : m/s, at which rollers' centres leave the hub, along e_r and e_t
    """
    vx, vy = np.asarray(tilts.slope_x_rate)[..., None], np.asarray(tilts.slope_y_rate)[..., None]
    out = tilts.tilt_rate - (vx * found.cos + vy * found.sin)
    around = theta_rate * tilts.tilt - (vy * found.cos - vx * found.sin)
    radial, tangential = contacts.normal
    passing = (apart[1] * radial - apart[0] * tangential) / found.distance
    return out * radial + around * tangential + contacts.at.across * passing, -tilts.tilt_rate


def met(law: TiltedLaw, approach, slope, surface: SurfaceDeviation | None):
    """`TiltedLaw.at` of contacts on a surface; None: a perfect circle."""
    if surface is None:
        return law.at(approach, slope)
    if surface.part is not None and law.has_part:
        return law.at(approach, slope, surface.part.sinkage, surface.compliance, surface.part.compliance)
    return in_series(law.at, approach, slope, surface.compliance) if surface.soft else law.at(approach, slope)


def falls(of, surface: SurfaceDeviation | None) -> Falls:
    """By how much contacts' energies fall, over their forces, as a surface changes under them; None: a circle."""
    if surface is None:
        return Falls()
    over = 1.0 / np.where(of.force > 0.0, of.force, np.inf)
    return Falls(over * of.part, over * of.edges, over * of.part_edges)


def tilt_equations(
    bearing: Bearing, operation: Operation, state: Any, contacts: Any, tilt_acc, theta_acc
) -> tuple[np.ndarray, np.ndarray]:
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


def tilt_energy(bearing: Bearing, hub: HubTilt, tilts: Tilts, theta_rate) -> np.ndarray:
    """½ I_t |ȧ|² of the rollers and ½ I_h |ḃ|² of the hub, J, (...,)."""
    across, _ = roller_inertias(bearing)
    rollers = 0.5 * across * np.sum(tilts.tilt_rate**2 + (theta_rate * tilts.tilt) ** 2, axis=-1)
    return rollers + 0.5 * hub.inertia * (np.asarray(tilts.slope_x_rate) ** 2 + np.asarray(tilts.slope_y_rate) ** 2)


def shaft_tilt_energy(hub: HubTilt, tilts: Tilts) -> np.ndarray:
    """Of the shaft's stiffness against tilt, J, (...,)."""
    x, y = np.asarray(tilts.slope_x) - hub.slope_x, np.asarray(tilts.slope_y) - hub.slope_y
    return 0.5 * hub.stiffness * (x**2 + y**2)
