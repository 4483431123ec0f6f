"""Contact laws that know the bearing: raceway radii, ring thickness, material; and the choice of a law by name.

Line contact of two circles is Hertz's. Source: Johnson, Contact Mechanics (1985), chapter 4.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from math import exp, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Material, OwnLaw
from lagrange.contact.laws import LAWS, PowerLaw, Side, ball_law


def line_compliance(material: Material, length: float) -> float:
    """A = 2/(π E' L) of one body, m/N: factor of ln Q in half its approach; 0 of a rigid one."""
    return 2.0 / (pi * material.plane_strain_modulus * length)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two bodies that may touch: side 0 is the ring, or roller j; side 1 the roller, or roller j + 1."""

    kind: str  # inner, outer (raceway) or roller
    radii: tuple[float, float]  # m; a bore's is negative
    materials: tuple[Material, Material]
    length: float  # m, of the line of contact
    cosine: float = 1.0  # of the contact angle: circles of a section are that much more curved than bodies

    @property
    def relative_radius(self) -> float:
        """R, m: 1/R is the sum of both curvatures."""
        return 1.0 / sum(self.cosine / radius for radius in self.radii)

    @property
    def modulus(self) -> float:
        """E*, Pa: 1/E* is the sum of both 1/E'."""
        return 1.0 / sum(1.0 / material.plane_strain_modulus for material in self.materials)

    @property
    def line_compliance(self) -> float:
        """A of both bodies, m/N."""
        return sum(line_compliance(material, self.length) for material in self.materials)

    @property
    def half_width_factor(self) -> float:
        """b²/Q = 4R/(π E* L) = 2RA, m²/N."""
        return 2.0 * self.relative_radius * self.line_compliance

    def half_width(self, force: float) -> float:
        """Half-width b, m, of the contact under a force, N."""
        return sqrt(self.half_width_factor * force)

    def peak_pressure(self, force: float) -> float:
        """Largest pressure p₀ = 2 Q/(π b L), Pa, under a force, N."""
        return 2.0 * force / (pi * self.half_width(force) * self.length) if force > 0.0 else 0.0


def contact_pairs(bearing: Bearing) -> tuple[Pair, Pair, Pair]:
    """Inner raceway and roller, outer raceway and roller, two rollers.

    Two rigid rollers meet with their material's compliance: they would have none otherwise.
    """
    r, roller = bearing.roller_radius, bearing.roller
    inner, outer, rollers = (
        Pair(kind=kind, radii=(radius, r), materials=materials, length=bearing.roller_length, cosine=bearing.cosine)
        for kind, radius, materials in (
            ("inner", bearing.inner_raceway_radius, (bearing.inner_ring, roller)),
            ("outer", -bearing.outer_raceway_radius, (bearing.outer_ring, roller)),
            ("roller", r, (roller.elastic, roller.elastic)),
        )
    )
    return inner, outer, rollers


NEWTON_STEPS = 4  # from u = L + ln L, error 0.2 at most: 1e-2, 1e-5, 1e-11, round-off
STEEL = (190e9, 220e9)  # Pa, Young's modulus of bearing steels
SHALLOWEST = 1e-250  # m, keeps the logarithm of an open contact finite


@dataclass(frozen=True, kw_only=True)
class LogarithmicLaw:
    """δ = S Q (B − ln Q), Q in N: the line contact of elastic cylinders. Same methods as `PowerLaw`.

    Beyond `largest_force` (half-width above half the roller's radius, far outside Hertz's theory) the law goes on along
    its tangent, so that an iteration may pass there.
    """

    name: str
    compliance: float  # S, m/N
    level: float  # B
    largest_force: float  # N
    source: str
    range: str = ""

    def force(self, approach):
        """Contact force, N, >= 0, of an approach (any shape), m, by Newton's method to round-off."""
        depth = np.asarray(approach, dtype=float)
        inside = np.minimum(np.maximum(depth, SHALLOWEST), self._largest_approach)  # np.clip is slow
        u = self._bracket(inside)
        beyond = depth > self._largest_approach
        force = inside / u
        if np.any(beyond):
            force = force + np.where(beyond, depth - inside, 0.0) / (u - 1.0)
        force = force / self.compliance
        return np.where(depth > 0.0, force, 0.0)

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        force = np.asarray(force, dtype=float)
        inside = np.clip(force, SHALLOWEST, self.largest_force)
        u = self.level - np.log(inside)
        beyond = np.maximum(force - self.largest_force, 0.0)
        return np.where(force > 0.0, self.compliance * (inside * u + beyond * (u - 1.0)), 0.0)

    def slope(self, approach):
        """Contact stiffness dQ/dδ, N/m; 0 for an open contact."""
        depth = np.asarray(approach, dtype=float)
        u = self._bracket(np.clip(depth, SHALLOWEST, self._largest_approach))
        return np.where(depth > 0.0, 1.0 / (self.compliance * (u - 1.0)), 0.0)

    def potential(self, approach):
        """Energy stored in the contact, J."""
        depth = np.asarray(approach, dtype=float)
        inside = np.clip(depth, SHALLOWEST, self._largest_approach)
        u = self._bracket(inside)
        force = inside / (self.compliance * u)
        beyond = np.maximum(depth - self._largest_approach, 0.0)
        energy = 0.5 * self.compliance * force**2 * (u - 0.5)
        energy += beyond * (force + 0.5 * beyond / (self.compliance * (u - 1.0)))
        return np.where(depth > 0.0, energy, 0.0)

    @cached_property
    def _largest_approach(self):
        return self.compliance * self.largest_force * (self.level - np.log(self.largest_force))

    @cached_property
    def _log_scale(self):
        return self.level + np.log(self.compliance)

    def _bracket(self, depth):
        """u = B − ln Q of a depth: u − ln u = L = B + ln(S/δ), the root above 1."""
        target = self._log_scale - np.log(depth)
        u = target + np.log(target)
        for _ in range(NEWTON_STEPS):
            u = u * (target + np.log(u) - 1.0) / (u - 1.0)
        return u


class ContactLaws(NamedTuple):
    """The laws of a rolling element's two contacts."""

    inner: PowerLaw | LogarithmicLaw
    outer: PowerLaw | LogarithmicLaw


def johnson(bearing: Bearing, side: Side) -> LogarithmicLaw:
    """Elastic cylinder between raceways; the same as Tripp's.

    δ = 2 Q/(π L) {c_1 [ln(4 R1/b) − ½] + c_2 [ln(4 R2/b) − ½]}, b = sqrt(4 Q (c_1 + c_2)/(π L Σρ)), c = (1 − ν²)/E.
    The outer ring, of thickness t behind the raceway, has ln(2 t/b) − ν/(2(1 − ν)) in its bracket instead: the approach
    of a point at depth t in a half-space.

    Source: Johnson, Contact Mechanics (1985), 5.6; Tripp, Hertzian Contact in Two and Three Dimensions, NASA
    (1985).
    Range: plane strain, unrelieved ends, b well below R and t; the inner ring as a solid cylinder.
    """
    R1, length = bearing.element_radius, bearing.roller_length
    ring = bearing.inner_ring if side == "inner" else bearing.outer_ring
    c1, c2 = _compliance(bearing.roller), _compliance(ring)
    inner_pair, outer_pair, _ = contact_pairs(bearing)
    if side == "inner":
        b_squared = inner_pair.half_width_factor  # of 1 N
        ring_term = log(4.0 * bearing.inner_raceway_radius / bearing.cosine) - 0.5
    else:
        b_squared = outer_pair.half_width_factor
        thickness, nu = bearing.outside_radius - bearing.outer_raceway_radius, ring.poisson_ratio
        ring_term = log(2.0 * thickness) - 0.5 * nu / (1.0 - nu)
    compliance = (c1 + c2) / (pi * length)
    level = 2.0 * (c1 * (log(4.0 * R1) - 0.5) + c2 * ring_term) / (c1 + c2) - log(b_squared)
    return LogarithmicLaw(
        name="johnson",
        compliance=compliance,
        level=level,
        # at b = R1/2, but never near the maximum of δ(Q), which a thin ring brings closer
        largest_force=min((0.5 * R1) ** 2 / b_squared, exp(level - 2.0)),
        source=f"Johnson 1985, Tripp 1985: line contact of elastic cylinders, {side} raceway",
        range="plane strain; contact width small against roller and ring",
    )


def houpert(bearing: Bearing, side: Side) -> PowerLaw:
    """Power law fitted to the elastic line contact: Q = 0.2723 L δ^1.074/(c d_m^0.074), c = (1 − ν²)/E, N and mm.

    Source: Houpert, An Engineering Approach to Hertzian Contact Elasticity, ASME J. Tribology 123 (2001), second hand;
    the inner raceway's form, used here for both raceways.
    """
    exponent = 1.074
    compliance = _mean_compliance(bearing, side)
    return PowerLaw(
        name="houpert",
        # homogeneous in length: the same in m
        stiffness=0.2723 * bearing.roller_length / (compliance * (2.0 * bearing.pitch_radius) ** 0.074),
        exponent=exponent,
        source="Houpert 2001, Q = 0.2723 L δ^1.074/(c d_m^0.074); the inner raceway's, used for both",
        range="line contact of rolling bearings, any elastic material",
    )


def teutsch_sauer(bearing: Bearing, side: Side) -> PowerLaw:
    """Power law fitted to the elastic line contact: δ = 3.17 (d_m/2)^0.08 (Q c/L)^0.92, c = (1 − ν²)/E, N and mm.

    Source: Teutsch and Sauer, An Alternative Slicing Technique to Consider Pressure Concentrations in Non-Hertzian Line
    Contacts, ASME J. Tribology 126 (2004); the inner raceway's form, used here for both raceways.
    """
    exponent = 1.0 / 0.92
    factor = 3.17 * bearing.pitch_radius**0.08 * (_mean_compliance(bearing, side) / bearing.roller_length) ** 0.92
    return PowerLaw(
        name="teutsch_sauer",
        stiffness=factor**-exponent,
        exponent=exponent,
        source="Teutsch and Sauer 2004, δ = 3.17 (d_m/2)^0.08 (Q c/L)^0.92; the inner raceway's, used for both",
        range="line contact of rolling bearings, any elastic material",
    )


def _compliance(material: Material) -> float:
    """c = (1 − ν²)/E, 1/Pa."""
    return 1.0 / material.plane_strain_modulus


def _mean_compliance(bearing: Bearing, side: Side) -> float:
    """c of a contact of two materials: Hertz's theory knows only their sum."""
    ring = bearing.inner_ring if side == "inner" else bearing.outer_ring
    return 0.5 * (_compliance(bearing.roller) + _compliance(ring))


def _by_length(law: Callable[[float], PowerLaw], bearing: Bearing, side: Side) -> PowerLaw:
    return law(bearing.roller_length)


ROLLER_LAWS: dict[str, Callable[[Bearing, Side], PowerLaw | LogarithmicLaw]] = {
    **{name: partial(_by_length, law) for name, law in LAWS.items()},
    "johnson": johnson,
    "houpert": houpert,
    "teutsch_sauer": teutsch_sauer,
}
BALL_LAWS = {"hertz": ball_law}


OWN = "power"  # name of the bearing's own law
MISFIT = 0.05  # of a force, above which a fitted law is no good


def law_names(bearing: Bearing) -> tuple[str, ...]:
    """Names of all laws for a bearing's rolling elements, the usual one first."""
    return tuple(_known_laws(bearing))


def _known_laws(bearing: Bearing) -> dict[str, Callable[[Side], PowerLaw | LogarithmicLaw]]:
    """All laws for a bearing's rolling elements, its own too."""
    found: dict[str, Callable[[Side], PowerLaw | LogarithmicLaw]]
    if isinstance(bearing, BallBearing):
        found = {name: partial(law, bearing) for name, law in BALL_LAWS.items()}
    else:
        found = {name: partial(law, bearing) for name, law in ROLLER_LAWS.items()}
    return found if bearing.own_law is None else found | {OWN: partial(own_law, bearing.own_law)}


def own_law(law: OwnLaw, side: Side) -> PowerLaw:
    """A bearing's own law on one raceway."""
    stiffness = law.inner_stiffness if side == "inner" else law.outer_stiffness
    return PowerLaw(
        name=OWN,
        stiffness=stiffness,
        exponent=law.exponent,
        source=f"the scene's own, Q = {stiffness:.4g} N/m^n · δ^n, n = {law.exponent:.4g}",
        range=f"K = {law.inner_stiffness:.4g} and {law.outer_stiffness:.4g} N/m^n, n = {law.exponent:.4g}, {law.range}",
    )


def warning(name: str, bearing: Bearing) -> str | None:
    """Why a law is no good for a bearing; None where it is.

    The empirical laws know the roller's length alone: they are measurements on steel. A fitted law may be far from its
    table.
    """
    if name == OWN and bearing.own_law is not None and bearing.own_law.misfit > MISFIT:
        return f"the contact law power is {bearing.own_law.range}: no power law is near that table"
    if name not in LAWS:
        return None
    bodies = {"roller": bearing.roller, "inner ring": bearing.inner_ring, "outer ring": bearing.outer_ring}
    other = [f"the {body} is rigid" if material.rigid else f"the {body} has {1e-9 * material.youngs_modulus:.4g} GPa"
             for body, material in bodies.items()
             if material.rigid or not STEEL[0] <= material.youngs_modulus <= STEEL[1]]  # fmt: skip
    if not other:
        return None
    return (
        f"the contact law {name} was measured on steel, but {', '.join(other)}; johnson, houpert and "
        "teutsch_sauer know the material"
    )


def contact_laws(name: str, bearing: Bearing) -> ContactLaws:
    """The named laws of both contacts of a rolling element.

    Parameters
    ----------
    name : a key of ROLLER_LAWS, or of BALL_LAWS ("hertz") for a `BallBearing`; "tripp" is "johnson", "power" the
        bearing's own

    Errors
    ------
    ValueError: an unknown name, or a law that isn't for this bearing's rolling elements; the message lists the known.
    """
    known = _known_laws(bearing)
    kind = "balls" if isinstance(bearing, BallBearing) else "rollers"
    law = known.get("johnson" if name == "tripp" else name)
    if law is None and name == OWN:
        raise ValueError(
            'law = "power": the scene has no law of its own, or its file is not at hand; give '
            "lagrange.contact_stiffness_N_per_m_n and contact_exponent, or law_table"
        )
    if law is None:
        raise ValueError(f"unknown contact law {name!r} for {kind}; known: {', '.join(sorted(known))}")
    return ContactLaws(inner=law("inner"), outer=law("outer"))
