"""The approach of a contact as a whole by its force: δ = A Q (B − ½ ln Q), or none.

Equation (3) of docs/method.md.
"""

from dataclasses import dataclass
from math import exp, inf, log
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lagrange.contact.hertz import Pair

if TYPE_CHECKING:
    from fem.kernels.law import Law

STEEPEST = 0.25  # the one of `fem.kernels.law`, which loads a compiler: ratings do without
LOAD_MARGIN = 10.0  # critical steps take contacts to be as stiff as at this many times the largest static force


@dataclass(frozen=True, kw_only=True)
class ContactLaw:
    """Approach of a pair of bodies: δ = A Q (B − ½ ln Q), a straight line above Q_line."""

    A: float  # m/N
    B: float
    Q_line: float  # N; beyond, the mesh is finer than the contact
    pair: Pair

    @classmethod
    def of_level(cls, A: float, B: float, pair: Pair) -> "ContactLaw":
        """The law that goes straight on where its bracket has shrunk to STEEPEST above a half."""
        return cls(A=A, B=B, Q_line=exp(2.0 * (B - 0.5 - STEEPEST)), pair=pair)

    @classmethod
    def of_approach(cls, approach: float, half_width: float, pair: Pair) -> "ContactLaw":
        """The law with an approach, m/N, known at a half-width, m."""
        A = pair.line_compliance
        return cls.of_level(A, approach / A + log(half_width) - 0.5 * log(pair.half_width_factor), pair)

    @property
    def constants(self) -> "Law":
        """The law as kernels take it."""
        from fem.kernels.law import Law

        return Law(self.A, self.B, self.Q_line, self.pair.half_width_factor, 1.0 / self.pair.relative_radius)

    def approach(self, force):
        """Approach, m, of a force, N, >= 0."""
        low = np.minimum(force, self.Q_line)
        bracket = self.B - 0.5 * np.log(np.maximum(low, 1e-300))
        return self.A * (low * bracket + STEEPEST * (force - low))

    def energy(self, force):
        """Stored energy, J, of a force, N, >= 0: ∫ Q dδ = Q δ − ∫ δ dQ."""
        low = np.minimum(force, self.Q_line)
        return 0.5 * force * self.approach(force) - 0.125 * self.A * low * (2.0 * force - low)

    def stiffness(self, force: float) -> float:
        """dQ/dδ, N/m, at a force, N, > 0."""
        return 1.0 / float(self.softness(force))

    def softness(self, force):
        """dδ/dQ, m/N, at a force, N, > 0."""
        return self.A * np.maximum(self.B - 0.5 * np.log(force) - 0.5, STEEPEST)


class NoLaw:
    """The law of a contact whose every compliance is between points of its surfaces."""

    Q_line: ClassVar[float] = inf  # N: no force is too large for it

    @staticmethod
    def approach(force):
        """None, m, of any force, N."""
        return np.zeros_like(force)

    softness = approach
