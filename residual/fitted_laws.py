"""Contact laws beyond Q(δ) of one contact: coupled to its neighbours, or with a damper beside the spring."""

from dataclasses import dataclass

import numpy as np

from lagrange.contact.damping import ContactDamping, damper_force
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import LogarithmicLaw
from lagrange.surface.edges import softened

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
    """Q = max(Q_0(δ) + d δ̇, 0) where δ > 0, else 0: a damper beside a contact's spring."""

    spring: PowerLaw | LogarithmicLaw  # Q_0
    damping: ContactDamping  # d

    @property
    def name(self) -> str:
        return self.spring.name

    @property
    def source(self) -> str:
        return f"{self.spring.source}, damping {self.damping.words}"

    def slope(self, approach):
        """dQ/dδ of a contact, N/m."""
        return self.spring.slope(approach)


Law = PowerLaw | LogarithmicLaw | DampedLaw


def law_force(law: Law, approach, closing_speed, compliance=0.0) -> np.ndarray:
    """Contact forces, N, (..., n_rollers), at approaches, m, that grow at a speed, m/s; `compliance` of edges, m/N."""
    spring, damper = spring_and_damper(law, approach, closing_speed, compliance)
    return spring + damper


def spring_and_damper(law: Law, approach, closing_speed, compliance=0.0) -> tuple[np.ndarray, np.ndarray | float]:
    """The same, springs' and dampers' apart."""
    spring = softened(law.spring if isinstance(law, DampedLaw) else law, compliance)
    force = spring.force(approach)
    if not isinstance(law, DampedLaw):
        return force, 0.0
    coefficient = law.damping.coefficient(force, spring.slope(approach))
    return force, damper_force(force, closing_speed, coefficient)


def neighbours(force) -> np.ndarray:
    """Sum Q_{j−1} + Q_{j+1} of the neighbours of every contact, rollers along the last axis."""
    return np.roll(force, 1, axis=-1) + np.roll(force, -1, axis=-1)
