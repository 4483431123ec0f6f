"""Contact laws beyond Q(δ) of one contact: coupled to its neighbours, or with a damper beside the spring."""

from dataclasses import dataclass

import numpy as np

from lagrange.laws import PowerLaw
from lagrange.motion import damped
from lagrange.raceway_laws import LogarithmicLaw
from lagrange.softened import softened

FIXED_POINT_STEPS = 60  # gain 0.5: round-off


@dataclass(frozen=True, kw_only=True)
class CoupledLaw(PowerLaw):
    """Q_j = K max(δ_j − c (Q_{j−1} + Q_{j+1}), 0)^n: contacts of one ring feel their neighbours through the ring.

    `force` and `slope` take the rollers along the last axis, in their order around the bearing.
    """

    coupling: float  # c, m/N; negative: a neighbour's load adds to this contact's

    def force(self, approach):
        """Contact forces, N, >= 0, (..., n_rollers), by iteration to round-off."""
        force = super().force(approach)
        for _ in range(FIXED_POINT_STEPS):
            previous, force = force, super().force(approach - self.coupling * neighbours(force))
            if np.max(np.abs(force - previous), initial=0.0) <= 1e-12 * np.max(force, initial=0.0):
                break
        return force

    def slope(self, approach):
        """dQ/dδ of a contact, N/m, its neighbours' loads held."""
        return super().slope(approach - self.coupling * neighbours(self.force(approach)))


@dataclass(frozen=True, kw_only=True)
class DampedLaw:
    """Q = max(Q_0(δ) + d δ̇, 0) where δ > 0, else 0: a viscous damper beside a contact's spring."""

    spring: PowerLaw | LogarithmicLaw  # Q_0
    damping: float  # d, N s/m

    @property
    def name(self) -> str:
        return self.spring.name

    @property
    def source(self) -> str:
        return f"{self.spring.source}, damping {self.damping:.4g} N s/m"

    def slope(self, approach):
        """dQ/dδ of a contact, N/m."""
        return self.spring.slope(approach)


Law = PowerLaw | LogarithmicLaw | DampedLaw


def law_force(law: Law, approach, closing_speed, compliance=0.0) -> np.ndarray:
    """Contact forces, N, (..., n_rollers), at approaches, m, that grow at a speed, m/s; `compliance` of edges, m/N."""
    if isinstance(law, DampedLaw):
        return damped(softened(law.spring, compliance).force(approach), closing_speed, law.damping)
    return softened(law, compliance).force(approach)


def neighbours(force) -> np.ndarray:
    """Sum Q_{j−1} + Q_{j+1} of the neighbours of every contact, rollers along the last axis."""
    return np.roll(force, 1, axis=-1) + np.roll(force, -1, axis=-1)
