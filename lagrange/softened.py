"""A contact law with a linear compliance in series: δ = δ_law(Q) + c Q, as at the edges of spalls."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lagrange.laws import PowerLaw
from lagrange.raceway_laws import LogarithmicLaw

MOST_STEPS = 60  # of Newton's method; 3 to 6 are usual
SETTLED = 1e-10  # of the approach: what is left is of its square
SLOWEST = 0.1  # of itself: what the law's own approach keeps in a step, at least


def softened(law: PowerLaw | LogarithmicLaw, compliance: np.ndarray | float) -> "PowerLaw | LogarithmicLaw | Softened":
    """The law itself where the compliance, m/N, is the number 0."""
    return law if isinstance(compliance, float) and compliance == 0.0 else Softened(law=law, compliance=compliance)


def pressed(law: "PowerLaw | LogarithmicLaw | Softened", approach) -> tuple[np.ndarray, np.ndarray]:
    """Forces, N, and stiffnesses, N/m, of approaches, m."""
    return law.pressed(approach) if isinstance(law, Softened) else (law.force(approach), law.slope(approach))


@dataclass(frozen=True, kw_only=True, eq=False)
class Softened:
    """Same methods as `PowerLaw`, with approaches and forces that go with the compliances' shape."""

    law: PowerLaw | LogarithmicLaw
    compliance: np.ndarray | float  # c, m/N, >= 0

    def force(self, approach):
        """Contact force, N, >= 0, of an approach, m."""
        return self.law.force(self._own(approach))

    def approach(self, force):
        """Approach, m, of a contact force, N, >= 0."""
        return self.law.approach(force) + self.compliance * np.asarray(force)

    def slope(self, approach):
        """Contact stiffness dQ/dδ, N/m; 0 for an open contact."""
        return self.pressed(approach)[1]

    def pressed(self, approach):
        """Contact force, N, and stiffness, N/m, of an approach, m: in half the time of asking for one and the other."""
        own = self._own(approach)
        slope = self.law.slope(own)
        return self.law.force(own), slope / (1.0 + self.compliance * slope)

    def potential(self, approach):
        """Energy stored in contact and compliance, J."""
        own = self._own(approach)
        return self.law.potential(own) + 0.5 * self.compliance * self.law.force(own) ** 2

    def _own(self, approach):
        """The law's share of an approach, m, by Newton's method to round-off; all of it where it is open."""
        approach = np.asarray(approach, dtype=float)
        own = approach + 0.0 * self.compliance
        for _ in range(MOST_STEPS):
            too_far = own + self.compliance * self.law.force(own) - approach
            step = too_far / (1.0 + self.compliance * self.law.slope(own))
            own = np.where(own > 0.0, np.maximum(own - step, SLOWEST * own), own)
            if np.all(np.abs(step) <= SETTLED * np.abs(own)):
                break
        return own


class SoftenedLaws(NamedTuple):
    """The laws of a rolling element's two contacts, softened where edges are."""

    inner: PowerLaw | LogarithmicLaw | Softened
    outer: PowerLaw | LogarithmicLaw | Softened
