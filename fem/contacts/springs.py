"""Contacts for comparison, as ordinary codes have them on meshes too coarse for Hertz's: one penalty spring each.

It acts between the nodes around the line of centres: between the circles, or between facets, the chords from node to
node.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fem.contacts.model import Model, assembled_bodies, named
from fem.contacts.patch import hats, hertz_patch
from fem.contacts.points import POINTS_PER_NODE, PointModel, surface_spacings
from fem.contacts.resolved import ResolvedLaw, resolved_laws
from lagrange import Bearing
from meshes import bearing_shapes


@dataclass(frozen=True, kw_only=True)
class SpringLaw(ResolvedLaw):
    """A pair of surfaces with one point, whose layer is as stiff as the spring."""

    sagitta: tuple[float, float]  # of both sides' facets, m, negative in a bore; 0: circles

    def places(self, half_count: int) -> np.ndarray:
        """See `PointLaw.places`: on the line of centres."""
        return np.zeros(1)


@dataclass(frozen=True, kw_only=True)
class PenaltyModel(PointModel):
    """Contacts of one spring each, between circles."""

    shares: ClassVar = staticmethod(hats)
    static_passes: ClassVar[int] = 6  # facets may leave the hub room to move by milliradians
    stress_note: ClassVar[str] = "forces on two nodes"
    facet: ClassVar[float] = 0.0  # share of the facets' sagittas h²/8R that is there

    @classmethod
    def build(cls, bearing: Bearing, mesh_size: float, expected, contact) -> Model:
        """See `Model.build`; the springs' stiffness is the scene's."""
        return cls.of_stiffness(bearing, mesh_size, contact.penalty_stiffness_N_per_m)

    @classmethod
    def of_stiffness(cls, bearing: Bearing, mesh_size: float, stiffness: float) -> Model:
        """Mesh and assemble a bearing at a surface spacing, m, with springs of a stiffness, N/m."""
        bodies, found = assembled_bodies(bearing, bearing_shapes(bearing, mesh_size)), []
        spacings = surface_spacings(bodies)
        for law, body in zip(resolved_laws(bearing, spacings), ("inner_ring", "outer_ring", "roller"), strict=True):
            h, pair, spacing = (spacings[body], spacings["roller"]), law.pair, POINTS_PER_NODE * law.spacing
            layer = stiffness / (spacing * pair.length)
            sagitta = tuple(cls.facet * h[side] ** 2 / (8.0 * pair.radii[side]) for side in (0, 1))
            found.append(SpringLaw(pair=pair, layer=layer, spacing=spacing, sagitta=sagitta))
        return cls(bearing=bearing, **bodies, **named(found))

    def carried(self, kind: int, n_surface: int, angle: float, radius: float, force: float):
        """See `Model.carried`: the nodes beside the point, whatever the force."""
        return hertz_patch(n_surface, angle, 0.0, self.shares)

    def give(self, load: float) -> float:
        """See `Model.give`: a soft spring deflects more than steel."""
        return 2.0 * load / self.inner_law.point_stiffness


class FacetedModel(PenaltyModel):
    """The same between facets."""

    facet: ClassVar[float] = 1.0
