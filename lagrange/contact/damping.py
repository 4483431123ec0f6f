"""Dampers beside the springs of contacts: how many N s/m a contact has, by its force and stiffness.

Three laws, of which a bearing has one: a constant, F = d δ̇; a time, F = τ K δ̇ with the contact's own stiffness
K = dQ/dδ; and Hunt and Crossley's, Q (1 + 3/2 α δ̇), F = 3/2 α Q δ̇. None makes a contact pull.

Source: Krämer, Dynamics of Rotors and Foundations (1993), for the time, second hand; Hunt and Crossley, Coefficient of
Restitution Interpreted as Damping in Vibroimpact, ASME J. Applied Mechanics 42 (1975).
"""

from typing import NamedTuple

import numpy as np


class ContactDamping(NamedTuple):
    """How contacts damp; the sum of what the three laws give. A fitted constant may be negative, within its error."""

    constant: float = 0.0  # d, N s/m
    time: float = 0.0  # τ, s
    hunt_crossley: float = 0.0  # α, s/m

    @property
    def acts(self) -> bool:
        return self != UNDAMPED

    def coefficient(self, force, stiffness):
        """N s/m, of contacts under spring forces, N, that are so stiff, N/m; any shape. Time loops compile it too."""
        return self.constant + self.time * stiffness + 1.5 * self.hunt_crossley * force

    @property
    def words(self) -> str:
        """What it is, for people."""
        if self.time > 0.0:
            return f"{1e6 * self.time:.4g} µs times its stiffness"
        if self.hunt_crossley > 0.0:
            return f"Hunt–Crossley {self.hunt_crossley:.4g} s/m"
        return f"{self.constant:.4g} N s/m"


UNDAMPED = ContactDamping()


def damper_force(spring_force, closing_speed, coefficient):
    """Force of dampers, N, beside springs that push: spring and damper together never pull; 0 of open contacts."""
    return np.where(spring_force > 0.0, np.maximum(coefficient * closing_speed, -spring_force), 0.0)


def tilted_damper(met, damping: ContactDamping, closing_speed, turning_speed, length: float):
    """Force, N, and moment, N m, of the dampers of contacts along a length, m, whose slices damp as they are stiff.

    D = c/K ∂²U/∂(δ, ψ)²: what acts on δ and ψ is F = c (δ̇ + z ψ̇) and M = −z F − c/K (−∂M/∂ψ − z² K) ψ̇, z = ∂Q/∂ψ/K.

    Parameters
    ----------
    met : `lagrange.axial.table.TiltedContact` of the springs
    closing_speed, turning_speed : δ̇, m/s, and ψ̇, rad/s, of its shape
    """
    coefficient = damping.coefficient(met.force, met.stiffness)
    softness = np.where(met.force > 0.0, 1.0 / np.where(met.force > 0.0, met.stiffness, 1.0), 0.0)
    lever = met.cross * softness
    force = damper_force(met.force, closing_speed + lever * turning_speed, coefficient)
    turning = coefficient * (met.tilt_stiffness * softness - lever**2)
    most = 0.5 * length * np.maximum(met.force + force, 0.0)
    return force, np.clip(-turning * turning_speed, -most, most) - lever * force
