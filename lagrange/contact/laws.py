"""Contact laws Q(δ) of a rolling element on a raceway, and the choice of a law by name."""

from dataclasses import dataclass
from functools import cached_property
from math import exp, inf, log, pi
from typing import Any, NamedTuple

import numpy as np

from lagrange.axial.table import TiltedContact
from lagrange.bearing import BallBearing, Bearing
from lagrange.contact.hertz import Side, ball_stiffness, compliances, contact_pairs

LOGARITHM_STEPS = 4  # of Newton's method from u = L + ln L, error 0.2 at most: 1e-2, 1e-5, 1e-11, round-off
SHALLOWEST = 1e-250  # m, keeps the logarithm of an open contact finite


class Line:
    """A law of contacts along parallel axes, and as one of contacts that may tilt, `lagrange.axial.table.TiltedLaw`."""

    has_part, last_approach = False, inf

    def force(self: Any, approach):
        """Contact force, N, >= 0."""
        return self._terms(approach)[1]

    def slope(self: Any, approach):
        """Contact stiffness dQ/dδ, N/m; 0 for an open contact."""
        return self._terms(approach)[2]

    def potential(self: Any, approach):
        """Energy stored in the contact, J."""
        return self._terms(approach)[0]

    def at(self: Any, approach, slope=0.0) -> TiltedContact:
        """Without a moment, whatever the slope."""
        (energy, force, stiffness), none = self._terms(approach), np.zeros(np.shape(approach))
        return TiltedContact(energy, force, none, stiffness, none, none)


@dataclass(frozen=True, kw_only=True)
class PowerLaw(Line):
    """Q = K δ^n for δ > 0, else 0: the load-zone condition (24), (25). δ in m, Q in N, of any shape."""

    name: str
    stiffness: float  # K, N/m^n
    exponent: float  # n
    source: str
    range: str = ""  # where the source says it holds

    def force(self, approach):
        return self.stiffness * np.maximum(approach, 0.0) ** self.exponent

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        return (np.asarray(force) / self.stiffness) ** (1.0 / self.exponent)

    def _terms(self, approach):
        """Energy, force and stiffness."""
        depth, n = np.asarray(approach, dtype=float), self.exponent
        # a fitted exponent may be below 1: no power of an open contact is taken
        inside = np.where(depth > 0.0, depth, 1.0)
        force = self.stiffness * inside**n
        return np.where(depth > 0.0, [force * inside / (n + 1.0), force, n * force / inside], 0.0)


@dataclass(frozen=True, kw_only=True)
class LogarithmicLaw(Line):
    """δ = S Q (B − ln Q), Q in N: the line contact of elastic cylinders.

    Beyond `largest_force` (half-width above half the roller's radius, far outside Hertz's theory) the law goes on along
    its tangent, so that an iteration may pass there.
    """

    name: str
    compliance: float  # S, m/N
    level: float  # B
    largest_force: float  # N
    source: str
    range: str = ""

    def approach(self, force):
        force = np.asarray(force, dtype=float)
        inside = np.clip(force, SHALLOWEST, self.largest_force)
        u = self.level - np.log(inside)
        return np.where(force > 0.0, self.compliance * (inside * u + (force - inside) * (u - 1.0)), 0.0)

    @cached_property
    def _largest_approach(self):
        return self.compliance * self.largest_force * (self.level - np.log(self.largest_force))

    def _terms(self, approach):
        """Energy, force, stiffness by u = B − ln Q: u − ln u = B + ln(S/δ), u > 1; by Newton's method, to round-off."""
        depth = np.asarray(approach, dtype=float)
        inside = np.minimum(np.maximum(depth, SHALLOWEST), self._largest_approach)  # np.clip is slow
        target = (self.level + np.log(self.compliance)) - np.log(inside)
        u = target + np.log(target)
        for _ in range(LOGARITHM_STEPS):
            u = u * (target + np.log(u) - 1.0) / (u - 1.0)
        force, beyond, slope = inside / (self.compliance * u), depth - inside, 1.0 / (self.compliance * (u - 1.0))
        energy = 0.5 * self.compliance * force**2 * (u - 0.5) + beyond * (force + 0.5 * beyond * slope)
        return np.where(depth > 0.0, [energy, force + beyond * slope, slope], 0.0)


class ContactLaws(NamedTuple):
    """The laws of a rolling element's two contacts."""

    inner: PowerLaw | LogarithmicLaw
    outer: PowerLaw | LogarithmicLaw


STEEL_RANGE = "steel on steel, rollers with relieved ends, loads of rolling bearings"
FITTED_RANGE = "line contact of rolling bearings, any elastic material"
# measured on steel, they know the roller's length alone: K, l, n of Q = K L^l δ^n in N and mm, source
STEEL_LAWS = {
    # equations (12), (13) of the paper; of crowned rollers
    "harris": (7.86e4, 8 / 9, 10 / 9, "Harris, Rolling Bearing Analysis, Q = 78 600 L^(8/9) δ^(10/9), N and mm"),
    # Ball and Roller Bearing Engineering (3rd ed.)
    "palmgren": (3.84e-5 ** (-1 / 0.9), 8 / 9, 1 / 0.9, "Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8"),
    # half of the approach of both contacts in series
    "iso16281": (
        35948.0 * 2.0 ** (10 / 9), 8 / 9, 10 / 9, "ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9) for both contacts together"
    ),
    # likewise; Brändlein, Eschmann, Hasbargen, Weigand, Die Wälzlagerpraxis (3rd ed.)
    "braendlein": (
        26200.0 * 2.0**1.08, 0.92, 1.08,
        "Brändlein et al. 1995 (second hand), Q = 26200 L^0.92 δ^1.08 for both contacts together",
    ),
}  # fmt: skip


def steel_law(name: str, roller_length: float) -> PowerLaw:
    """One of STEEL_LAWS for rollers of a length, m."""
    factor, by_length, n, source = STEEL_LAWS[name]
    K = factor * (1e3 * roller_length) ** by_length * 1e3**n
    return PowerLaw(name=name, stiffness=K, exponent=n, source=source, range=STEEL_RANGE)


def johnson(bearing: Bearing, side: Side) -> LogarithmicLaw:
    """Elastic cylinder between raceways; the same as Tripp's.

    δ = 2 Q/(π L) {c_1 [ln(4 R1/b) − ½] + c_2 [ln(4 R2/b) − ½]}, b = sqrt(4 Q (c_1 + c_2)/(π L Σρ)), c = (1 − ν²)/E.
    The outer ring, of thickness t behind the raceway, has ln(2 t/b) − ν/(2(1 − ν)) in its bracket instead: the approach
    of a point at depth t in a half-space.

    Source: Johnson, Contact Mechanics (1985), 5.6; Tripp, Hertzian Contact in Two and Three Dimensions, NASA (1985).
    Range: plane strain, unrelieved ends, b well below R and t; the inner ring as a solid cylinder.
    """
    R1, (c1, c2) = bearing.element_radius, compliances(bearing, side)
    b_squared = contact_pairs(bearing)[side == "outer"].half_width_factor  # of 1 N
    if side == "inner":
        ring_term = log(4.0 * bearing.inner_raceway_radius / bearing.cosine) - 0.5
    else:
        thickness, nu = bearing.outside_radius - bearing.outer_raceway_radius, bearing.outer_ring.poisson_ratio
        ring_term = log(2.0 * thickness) - 0.5 * nu / (1.0 - nu)
    level = 2.0 * (c1 * (log(4.0 * R1) - 0.5) + c2 * ring_term) / (c1 + c2) - log(b_squared)
    return LogarithmicLaw(
        name="johnson", compliance=(c1 + c2) / (pi * bearing.roller_length), level=level,
        # at b = R1/2, but never near the maximum of δ(Q), which a thin ring brings closer
        largest_force=min((0.5 * R1) ** 2 / b_squared, exp(level - 2.0)),
        source=f"Johnson 1985, Tripp 1985: line contact of elastic cylinders, {side} raceway",
        range="plane strain; contact width small against roller and ring")  # fmt: skip


OWN = "power"  # name of the bearing's own law
MISFIT = 0.05  # of a force, above which a fitted law is no good
STEEL = (190e9, 220e9)  # Pa, Young's modulus of bearing steels
ROLLER_LAWS = (*STEEL_LAWS, "johnson", "houpert", "teutsch_sauer")
BALL_LAWS = ("hertz",)


def law_names(bearing: Bearing) -> tuple[str, ...]:
    """Names of all laws for a bearing's rolling elements, the usual one first."""
    names = BALL_LAWS if isinstance(bearing, BallBearing) else ROLLER_LAWS
    return names if bearing.own_law is None else (*names, OWN)


def contact_laws(name: str, bearing: Bearing) -> ContactLaws:
    """The named laws of both contacts of a rolling element.

    name : of `law_names`; "tripp" is "johnson", "power" the bearing's own

    ValueError: an unknown name, or a law that isn't for this bearing's rolling elements; the message lists the known.
    """
    known, name = law_names(bearing), "johnson" if name == "tripp" else name
    if name == OWN and name not in known:
        raise ValueError('law = "power": the scene has no law of its own, or its file is not at hand; give '
            "lagrange.contact_stiffness_N_per_m_n and contact_exponent, or law_table")  # fmt: skip
    if name not in known:
        kind = "balls" if isinstance(bearing, BallBearing) else "rollers"
        raise ValueError(f"unknown contact law {name!r} for {kind}; known: {', '.join(sorted(known))}")
    return ContactLaws(_law(name, bearing, "inner"), _law(name, bearing, "outer"))


def _law(name, bearing, side):
    """One of `law_names`. Those fitted to the elastic line contact have c = (1 − ν²)/E of both bodies' mean.

    Sources: Houpert, An Engineering Approach to Hertzian Contact Elasticity, ASME J. Tribology 123 (2001), second hand;
    Teutsch and Sauer, An Alternative Slicing Technique to Consider Pressure Concentrations in Non-Hertzian Line
    Contacts, ASME J. Tribology 126 (2004).
    """
    if name in STEEL_LAWS:
        return steel_law(name, bearing.roller_length)
    if name == "johnson":
        return johnson(bearing, side)
    if name == OWN and (own := bearing.own_law) is not None:
        K, n = own.inner_stiffness if side == "inner" else own.outer_stiffness, own.exponent
        source = f"the scene's own, Q = {K:.4g} N/m^n · δ^n, n = {n:.4g}"
        of = f"K = {own.inner_stiffness:.4g} and {own.outer_stiffness:.4g} N/m^n, n = {n:.4g}, {own.range}"
    elif isinstance(bearing, BallBearing):  # elastic, smooth, dry
        K, n, source = ball_stiffness(bearing, side), 1.5, "Hertz 1881, point contact, Q = K δ^(3/2)"
        of = "elastic; contact ellipse small against the ball and inside the groove"
    else:
        c, L, radius = 0.5 * sum(compliances(bearing, side)), bearing.roller_length, bearing.pitch_radius
        if name == "houpert":
            K, n = 0.2723 * L / (c * (2.0 * radius) ** 0.074), 1.074
            source = "Houpert 2001, Q = 0.2723 L δ^1.074/(c d_m^0.074)"
        else:
            K, n = (3.17 * radius**0.08 * (c / L) ** 0.92) ** (-1.0 / 0.92), 1.0 / 0.92
            source = "Teutsch and Sauer 2004, δ = 3.17 (d_m/2)^0.08 (Q c/L)^0.92"
        source, of = f"{source}; the inner raceway's, used for both", FITTED_RANGE
    return PowerLaw(name=name, stiffness=K, exponent=n, source=source, range=of)


def warning(name: str, bearing: Bearing) -> str | None:
    """Why a law is no good for a bearing; None where it is.

    The empirical laws are measurements on steel. A fitted law may be far from its table.
    """
    if name == OWN and bearing.own_law is not None and bearing.own_law.misfit > MISFIT:
        return f"the contact law power is {bearing.own_law.range}: no power law fits that table"
    bodies = {"roller": bearing.roller, "inner ring": bearing.inner_ring, "outer ring": bearing.outer_ring}
    other = [f"the {body} is rigid" if material.rigid else f"the {body} has {1e-9 * material.youngs_modulus:.4g} GPa"
             for body, material in bodies.items()
             if material.rigid or not STEEL[0] <= material.youngs_modulus <= STEEL[1]]  # fmt: skip
    if name not in STEEL_LAWS or not other:
        return None
    return (f"the contact law {name} was measured on steel, but {', '.join(other)}; johnson, houpert and teutsch_sauer "
        "include the material")  # fmt: skip
