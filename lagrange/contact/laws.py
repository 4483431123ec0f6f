"""Contact laws Q(δ) of a rolling element on a raceway, and the choice of a law by name."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np

from lagrange.bearing import BallBearing, Bearing
from lagrange.contact.hertz import Side, ball_stiffness, compliances, contact_pairs

NEWTON_STEPS = 4  # from u = L + ln L, error 0.2 at most: 1e-2, 1e-5, 1e-11, round-off
SHALLOWEST = 1e-250  # m, keeps the logarithm of an open contact finite


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """Q = K δ^n for δ > 0, else 0: the load-zone condition (24), (25). δ in m, Q in N."""

    name: str
    stiffness: float  # K, N/m^n
    exponent: float  # n
    source: str
    range: str = ""  # where the source says it holds

    def force(self, approach):
        """Contact force, N, >= 0, of an approach (any shape), m."""
        return self.stiffness * np.maximum(approach, 0.0) ** self.exponent

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        return (np.asarray(force) / self.stiffness) ** (1.0 / self.exponent)

    def slope(self, approach):
        """Contact stiffness dQ/dδ, N/m; 0 for an open contact."""
        depth = np.asarray(approach, dtype=float)
        closed = depth > 0.0
        # a fitted exponent may be below 1: no power of an open contact is taken
        power = np.where(closed, depth, 1.0) ** (self.exponent - 1.0)
        return np.where(closed, self.exponent * self.stiffness * power, 0.0)

    def potential(self, approach):
        """Energy stored in the contact, J."""
        n = self.exponent
        return self.stiffness * np.maximum(approach, 0.0) ** (n + 1.0) / (n + 1.0)


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

    def _bracket(self, depth):
        """u = B − ln Q of a depth: u − ln u = L = B + ln(S/δ), the root above 1."""
        target = (self.level + np.log(self.compliance)) - np.log(depth)
        u = target + np.log(target)
        for _ in range(NEWTON_STEPS):
            u = u * (target + np.log(u) - 1.0) / (u - 1.0)
        return u


class ContactLaws(NamedTuple):
    """The laws of a rolling element's two contacts."""

    inner: PowerLaw | LogarithmicLaw
    outer: PowerLaw | LogarithmicLaw


class Published(NamedTuple):
    """A power law of rollers as it is printed, Q = K L^l δ^n in N and mm."""

    factor: float  # K
    by_length: float  # l
    exponent: float  # n
    source: str


STEEL_RANGE = "steel on steel, rollers with relieved ends, loads of rolling bearings"
STEEL_LAWS = {  # measured on steel: they know the roller's length alone
    # equations (12), (13) of the paper; of crowned rollers
    "harris": Published(
        7.86e4, 8 / 9, 10 / 9, "Harris, Rolling Bearing Analysis, Q = 78 600 L^(8/9) δ^(10/9), N and mm"
    ),
    "palmgren": Published(
        3.84e-5 ** (-1 / 0.9), 8 / 9, 1 / 0.9, "Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8"
    ),  # Ball and Roller Bearing Engineering (3rd ed.)
    # half of the approach of both contacts in series
    "iso16281": Published(
        35948.0 * 2.0 ** (10 / 9), 8 / 9, 10 / 9, "ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9) for both contacts together"
    ),
    "braendlein": Published(  # likewise; Brändlein, Eschmann, Hasbargen, Weigand, Die Wälzlagerpraxis (3rd ed.)
        26200.0 * 2.0**1.08, 0.92, 1.08,
        "Brändlein et al. 1995 (second hand), Q = 26200 L^0.92 δ^1.08 for both contacts together",
    ),
}  # fmt: skip


def steel_law(name: str, roller_length: float) -> PowerLaw:
    """One of STEEL_LAWS for rollers of a length, m."""
    law = STEEL_LAWS[name]
    stiffness = law.factor * (1e3 * roller_length) ** law.by_length * 1e3**law.exponent
    return PowerLaw(name=name, stiffness=stiffness, exponent=law.exponent, source=law.source, range=STEEL_RANGE)


def houpert(bearing: Bearing, side: Side) -> PowerLaw:
    """Power law fitted to the elastic line contact, c = (1 − ν²)/E of both bodies' mean; homogeneous in length.

    Source: Houpert, An Engineering Approach to Hertzian Contact Elasticity, ASME J. Tribology 123 (2001), second hand.
    """
    c = 0.5 * sum(compliances(bearing, side))
    return PowerLaw(
        name="houpert", stiffness=0.2723 * bearing.roller_length / (c * (2.0 * bearing.pitch_radius) ** 0.074),
        exponent=1.074, source="Houpert 2001, Q = 0.2723 L δ^1.074/(c d_m^0.074); the inner raceway's, used for both",
        range=FITTED_RANGE,
    )  # fmt: skip


def teutsch_sauer(bearing: Bearing, side: Side) -> PowerLaw:
    """The same by another fit.

    Source: Teutsch and Sauer, An Alternative Slicing Technique to Consider Pressure Concentrations in Non-Hertzian Line
    Contacts, ASME J. Tribology 126 (2004).
    """
    c = 0.5 * sum(compliances(bearing, side))
    return PowerLaw(
        name="teutsch_sauer",
        stiffness=(3.17 * bearing.pitch_radius**0.08 * (c / bearing.roller_length) ** 0.92) ** (-1.0 / 0.92),
        exponent=1.0 / 0.92,
        source="Teutsch and Sauer 2004, δ = 3.17 (d_m/2)^0.08 (Q c/L)^0.92; the inner raceway's, used for both",
        range=FITTED_RANGE,
    )  # fmt: skip


def johnson(bearing: Bearing, side: Side) -> LogarithmicLaw:
    """Elastic cylinder between raceways; the same as Tripp's.

    δ = 2 Q/(π L) {c_1 [ln(4 R1/b) − ½] + c_2 [ln(4 R2/b) − ½]}, b = sqrt(4 Q (c_1 + c_2)/(π L Σρ)), c = (1 − ν²)/E.
    The outer ring, of thickness t behind the raceway, has ln(2 t/b) − ν/(2(1 − ν)) in its bracket instead: the approach
    of a point at depth t in a half-space.

    Source: Johnson, Contact Mechanics (1985), 5.6; Tripp, Hertzian Contact in Two and Three Dimensions, NASA
    (1985).
    Range: plane strain, unrelieved ends, b well below R and t; the inner ring as a solid cylinder.
    """
    R1, (c1, c2) = bearing.element_radius, compliances(bearing, side)
    pair = contact_pairs(bearing)[side == "outer"]
    if side == "inner":
        ring_term = log(4.0 * bearing.inner_raceway_radius / bearing.cosine) - 0.5
    else:
        thickness, nu = bearing.outside_radius - bearing.outer_raceway_radius, bearing.outer_ring.poisson_ratio
        ring_term = log(2.0 * thickness) - 0.5 * nu / (1.0 - nu)
    b_squared = pair.half_width_factor  # of 1 N
    level = 2.0 * (c1 * (log(4.0 * R1) - 0.5) + c2 * ring_term) / (c1 + c2) - log(b_squared)
    return LogarithmicLaw(
        name="johnson",
        compliance=(c1 + c2) / (pi * bearing.roller_length),
        level=level,
        # at b = R1/2, but never near the maximum of δ(Q), which a thin ring brings closer
        largest_force=min((0.5 * R1) ** 2 / b_squared, exp(level - 2.0)),
        source=f"Johnson 1985, Tripp 1985: line contact of elastic cylinders, {side} raceway",
        range="plane strain; contact width small against roller and ring",
    )


def ball_law(bearing: BallBearing, side: Side) -> PowerLaw:
    """Hertz's law of one ball on one raceway: elastic, smooth, dry, contact ellipse inside the groove."""
    return PowerLaw(
        name="hertz", stiffness=ball_stiffness(bearing, side), exponent=1.5,
        source="Hertz 1881, point contact, Q = K δ^(3/2)",
        range="elastic; contact ellipse small against the ball and inside the groove",
    )  # fmt: skip


def own_law(bearing: Bearing, side: Side) -> PowerLaw:
    """A bearing's own law on one raceway."""
    law = bearing.own_law
    assert law is not None
    stiffness = law.inner_stiffness if side == "inner" else law.outer_stiffness
    return PowerLaw(
        name=OWN, stiffness=stiffness, exponent=law.exponent,
        source=f"the scene's own, Q = {stiffness:.4g} N/m^n · δ^n, n = {law.exponent:.4g}",
        range=f"K = {law.inner_stiffness:.4g} and {law.outer_stiffness:.4g} N/m^n, n = {law.exponent:.4g}, {law.range}",
    )  # fmt: skip


OWN = "power"  # name of the bearing's own law
MISFIT = 0.05  # of a force, above which a fitted law is no good
STEEL = (190e9, 220e9)  # Pa, Young's modulus of bearing steels
FITTED_RANGE = "line contact of rolling bearings, any elastic material"
ROLLER_LAWS = (*STEEL_LAWS, "johnson", "houpert", "teutsch_sauer")
BALL_LAWS = ("hertz",)
_FORMULAS: dict[str, Callable[[Any, Side], PowerLaw | LogarithmicLaw]] = {
    "johnson": johnson, "houpert": houpert, "teutsch_sauer": teutsch_sauer, "hertz": ball_law, OWN: own_law,
}  # fmt: skip


def law_names(bearing: Bearing) -> tuple[str, ...]:
    """Names of all laws for a bearing's rolling elements, the usual one first."""
    names = BALL_LAWS if isinstance(bearing, BallBearing) else ROLLER_LAWS
    return names if bearing.own_law is None else (*names, OWN)


def contact_laws(name: str, bearing: Bearing) -> ContactLaws:
    """The named laws of both contacts of a rolling element.

    Parameters
    ----------
    name : of `law_names`; "tripp" is "johnson", "power" the bearing's own

    Errors
    ------
    ValueError: an unknown name, or a law that isn't for this bearing's rolling elements; the message lists the known.
    """
    known, name = law_names(bearing), "johnson" if name == "tripp" else name
    if name == OWN and name not in known:
        raise ValueError(
            'law = "power": the scene has no law of its own, or its file is not at hand; give '
            "lagrange.contact_stiffness_N_per_m_n and contact_exponent, or law_table"
        )
    if name not in known:
        kind = "balls" if isinstance(bearing, BallBearing) else "rollers"
        raise ValueError(f"unknown contact law {name!r} for {kind}; known: {', '.join(sorted(known))}")
    if name in STEEL_LAWS:
        return ContactLaws(*2 * [steel_law(name, bearing.roller_length)])
    return ContactLaws(_FORMULAS[name](bearing, "inner"), _FORMULAS[name](bearing, "outer"))


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
    return (
        f"the contact law {name} was measured on steel, but {', '.join(other)}; johnson, houpert and teutsch_sauer "
        "include the material"
    )
