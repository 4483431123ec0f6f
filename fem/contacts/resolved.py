"""Contacts that the mesh resolves: pressure points on a layer that keeps the surfaces apart."""

from dataclasses import dataclass
from math import pi
from typing import ClassVar

import numpy as np

from fem.contacts.model import Model, assembled_bodies, named
from fem.contacts.patch import hats
from fem.contacts.points import POINTS_PER_NODE, PointLaw, PointModel, surface_spacings
from lagrange import Bearing
from lagrange.pair import contact_pairs
from meshes import graded_shapes

LAYER = 8.0  # stiffness of the layer times the surface spacing, over E*: see docs/crossover.md for what it costs
COARSEST = 0.6  # surface spacing over the half-width of a contact to be resolved
WIDE = "pressure points reach as far as static loads need, and an impact may have made a contact wider"


@dataclass(frozen=True, kw_only=True)
class ResolvedLaw(PointLaw):
    """A pair of surfaces with a layer between them."""

    layer: float  # pressure per penetration, Pa/m

    @property
    def point_stiffness(self) -> float:
        """Force per penetration of one point, N/m."""
        return self.layer * self.spacing * self.pair.length

    def local_compliance(self, n_points: int) -> np.ndarray:
        """See `PointLaw.local_compliance`: the layer's, each point for itself."""
        return np.eye(n_points) / self.point_stiffness

    def layer_approach(self, force: float) -> float:
        """What the layer adds to the approach, m: the mean of its deflection weighted with Hertz's pressure."""
        pair = self.pair
        return 8.0 / (3.0 * pi) * 2.0 * force / (pi * pair.half_width(force) * pair.length) / self.layer


@dataclass(frozen=True, kw_only=True)
class ResolvedModel(PointModel):
    """Contacts whose points push the nodes beside them."""

    shapes: ClassVar = staticmethod(graded_shapes)
    shares: ClassVar = staticmethod(hats)
    coarsest: ClassVar[float] = COARSEST
    failure_hint: ClassVar[str] = f"{WIDE}: a coarser numerics.mesh_size_mm has no such limit; or "
    stress_note: ClassVar[str] = "contacts resolved"

    @classmethod
    def build(cls, bearing: Bearing, mesh_size: float, expected=None, contact=None) -> Model:
        """See `Model.build`; nothing but the mesh size is asked for."""
        bodies = assembled_bodies(bearing, graded_shapes(bearing, mesh_size))
        return cls(bearing=bearing, **bodies, **named(resolved_laws(bearing, surface_spacings(bodies))))


def resolved_laws(bearing: Bearing, spacings: dict[str, float]) -> list[ResolvedLaw]:
    """Laws by kind of contact; `spacings` of the surface nodes by body, m: the finer of two surfaces counts."""
    found = []
    for pair, body in zip(contact_pairs(bearing), ("inner_ring", "outer_ring", "roller"), strict=True):
        spacing = min(spacings[body], spacings["roller"])
        found.append(ResolvedLaw(pair=pair, layer=LAYER * pair.modulus / spacing, spacing=spacing / POINTS_PER_NODE))
    return found
