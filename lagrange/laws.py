"""Empirical line-contact laws Q(δ) of ONE roller-raceway contact: steel on steel, the roller's length alone matters.

Laws that know the raceways or the material are in `raceway_laws`; those of balls in `ball_contact`.
"""

from dataclasses import dataclass

import numpy as np

STEEL_LENGTH_EXPONENT = 8.0 / 9.0
STEEL_RANGE = "steel on steel, rollers with relieved ends, loads of rolling bearings"


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


def _steel_law(name: str, in_mm: float, exponent: float, source: str) -> PowerLaw:
    """A law of steel bearings whose stiffness is in N/mm^n."""
    return PowerLaw(name=name, stiffness=in_mm * 1e3**exponent, exponent=exponent, source=source, range=STEEL_RANGE)


def harris(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway, equations (12), (13) of the paper: Q = 7.86e4 L^(8/9) δ^(10/9) in N and mm.

    Source: Harris, Rolling Bearing Analysis; an empirical law for crowned steel rollers.
    """
    exponent = 10.0 / 9.0
    in_mm = 7.86e4 * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    return _steel_law(
        "harris", in_mm, exponent, "Harris, Rolling Bearing Analysis, Q = 78 600 L^(8/9) δ^(10/9), N and mm"
    )


def palmgren(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway: δ = 3.84e-5 Q^0.9 / L^0.8 in N and mm.

    Source: Palmgren, Ball and Roller Bearing Engineering (3rd ed. 1959).
    """
    exponent = 1.0 / 0.9
    in_mm = ((1e3 * roller_length) ** 0.8 / 3.84e-5) ** exponent
    return _steel_law("palmgren", in_mm, exponent, "Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8")


def iso16281(roller_length: float) -> PowerLaw:
    """Half of the approach of both contacts in series: Q = 35948 L^(8/9) δ^(10/9) for the two together, N and mm.

    Source: ISO/TS 16281:2008, spring constant of a roller with line contact.
    """
    exponent = 10.0 / 9.0
    in_mm = 35948.0 * 2.0**exponent * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    source = "ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9) for both contacts together"
    return _steel_law("iso16281", in_mm, exponent, source)


def braendlein(roller_length: float) -> PowerLaw:
    """Half of the approach of both contacts in series: Q = 26200 L^0.92 δ^1.08 for the two together, N and mm.

    Source: Brändlein, Eschmann, Hasbargen, Weigand, Die Wälzlagerpraxis (3rd ed. 1995), as quoted by others; not
    checked in the text.
    """
    exponent = 1.08
    in_mm = 26200.0 * 2.0**exponent * (1e3 * roller_length) ** 0.92
    source = "Brändlein et al. 1995 (second hand), Q = 26200 L^0.92 δ^1.08 for both contacts together"
    return _steel_law("braendlein", in_mm, exponent, source)


LAWS = {"harris": harris, "palmgren": palmgren, "iso16281": iso16281, "braendlein": braendlein}


def roller_law(name: str, roller_length: float) -> PowerLaw:
    """The named law for rollers of the given length, m: one of the laws that need no more than it.

    Errors
    ------
    ValueError: an unknown name; the message lists the known ones. `raceway_laws.contact_laws` knows more, from the
    whole bearing.
    """
    if name not in LAWS:
        raise ValueError(f"unknown contact law {name!r}; known: {', '.join(sorted(LAWS))}")
    return LAWS[name](roller_length)
