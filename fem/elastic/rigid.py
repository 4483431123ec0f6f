"""Bodies declared rigid: the limit E → ∞ of an elastic one, with the same shape and mass.

They keep the mesh for what is drawn and stored; the time loop has no nodes of theirs. Whatever is asked of their
elasticity is 0.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy import sparse

from fem.elastic.bodies import DiscBody, RingBody


class _Unstrained:
    """A body without stress."""

    @property
    def stress(self) -> sparse.csr_matrix:
        n = len(self.points)
        return sparse.csr_matrix((3 * n, 2 * n))


@dataclass(frozen=True, kw_only=True)
class RigidDisc(_Unstrained, DiscBody):
    """A roller that keeps its shape."""

    def relaxed(self, force: np.ndarray) -> np.ndarray:
        return np.zeros_like(force)


@dataclass(frozen=True, kw_only=True)
class RigidRing(_Unstrained, RingBody):
    """A ring that moves as its held circle does."""

    def held(self, force: np.ndarray) -> np.ndarray:
        return np.zeros_like(force)

    @property
    def polar_inertia(self) -> float:
        """½ m (r_inner² + r_outer²), kg m²."""
        return 0.5 * self.total_mass * float(self.radii[0] ** 2 + self.radii[-1] ** 2)


def rigid_body(body: DiscBody | RingBody) -> RigidDisc | RigidRing:
    """The rigid body of an elastic one's shape and mass."""
    own = {field.name: getattr(body, field.name) for field in fields(body)}
    own["material"] = replace(body.material, rigid=True)
    if isinstance(body, DiscBody):
        return RigidDisc(**own | {"stiffness": sparse.csr_matrix(body.stiffness.shape)})
    return RigidRing(**own | {"stencil": np.zeros_like(body.stencil)})
