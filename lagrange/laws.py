"""Line-contact laws Q(δ) of ONE roller-raceway contact."""

from dataclasses import dataclass

import numpy as np

STEEL_LENGTH_EXPONENT = 8.0 / 9.0


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """Q = K δ^n for δ > 0, else 0: the load-zone condition (24), (25). δ in m, Q in N."""

    name: str
    stiffness: float  # K, N/m^n
    exponent: float  # n
    source: str

    def force(self, approach):
        """Contact force, N, >= 0, of an approach (any shape), m."""
        return self.stiffness * np.maximum(approach, 0.0) ** self.exponent

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        return (np.asarray(force) / self.stiffness) ** (1.0 / self.exponent)

    def potential(self, approach):
        """Energy stored in the contact, J."""
        n = self.exponent
        return self.stiffness * np.maximum(approach, 0.0) ** (n + 1.0) / (n + 1.0)


def _from_millimetres(stiffness: float, exponent: float) -> float:
    """N/mm^n to N/m^n."""
    return stiffness * 1e3**exponent


def harris(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway, equations (12), (13) of the paper: Q = 7.86e4 L^(8/9) δ^(10/9) in N and mm.

    Source: Harris, Rolling Bearing Analysis; an empirical law for crowned steel rollers.
    """
    exponent = 10.0 / 9.0
    in_mm = 7.86e4 * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    return PowerLaw(
        name="harris",
        stiffness=_from_millimetres(in_mm, exponent),
        exponent=exponent,
        source="Harris, Rolling Bearing Analysis, Q = 7.86e4 L^(8/9) δ^(10/9)",
    )


def palmgren(roller_length: float) -> PowerLaw:
    """Steel roller on steel raceway: δ = 3.84e-5 Q^0.9 / L^0.8 in N and mm.

    Source: Palmgren, Ball and Roller Bearing Engineering (3rd ed. 1959).
    """
    exponent = 1.0 / 0.9
    in_mm = ((1e3 * roller_length) ** 0.8 / 3.84e-5) ** exponent
    return PowerLaw(
        name="palmgren",
        stiffness=_from_millimetres(in_mm, exponent),
        exponent=exponent,
        source="Palmgren 1959, δ = 3.84e-5 Q^0.9 / L^0.8",
    )


def iso16281(roller_length: float) -> PowerLaw:
    """Half of the approach of both contacts in series: Q = 35948 L^(8/9) δ^(10/9) for the two together, N and mm.

    Source: ISO/TS 16281:2008, spring constant of a roller with line contact.
    """
    exponent = 10.0 / 9.0
    in_mm = 35948.0 * 2.0**exponent * (1e3 * roller_length) ** STEEL_LENGTH_EXPONENT
    return PowerLaw(
        name="iso16281",
        stiffness=_from_millimetres(in_mm, exponent),
        exponent=exponent,
        source="ISO/TS 16281, Q = 35948 L^(8/9) δ^(10/9) for both contacts together",
    )


LAWS = {"harris": harris, "palmgren": palmgren, "iso16281": iso16281}


def roller_law(name: str, roller_length: float) -> PowerLaw:
    """The named law for rollers of the given length, m.

    Errors
    ------
    ValueError: an unknown name; the message lists the known ones.
    """
    if name not in LAWS:
        raise ValueError(f"unknown contact law {name!r}; known: {', '.join(sorted(LAWS))}")
    return LAWS[name](roller_length)
