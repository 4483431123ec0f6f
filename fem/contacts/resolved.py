"""Contacts of pressure points on a layer that keeps the surfaces apart, or each spread over a patch of the mesh.

Where the mesh is far coarser than a contact, one patch carries it all and Hertz's formula gives what the mesh can't see
(`subgrid`). Where it is finer, the pressure is found at points instead. The force q_j of a point is spread over a patch
like that one, the overlap at a point is read with the same patch, and what the mesh lacks between two points is

    G_ij = C − A ⟨ln|s − s'|⟩_ij − F(d_ij),    A = 2 / (π E' L),

for each body: the half-plane under cells of even pressure, C so that Hertz's pressure gets the exact approach of that
body (as in `subgrid`), less the finite elements' own answer F of one patch at the distance d of the other. G is the
term below the grid: it is all of a contact on a coarse mesh, has a range of four surface spacings, and vanishes as the
mesh is refined.

For comparison there are contacts as ordinary codes have them on meshes too coarse for Hertz's: one penalty spring each
between the nodes around the line of centres, between the circles, or between facets, the chords from node to node."""

from dataclasses import dataclass
from math import log, pi
from typing import ClassVar

import numpy as np
from scipy.linalg import toeplitz

from fem.contacts import ONE_PATCH
from fem.contacts.model import Model, assembled_bodies
from fem.contacts.points import POINTS_PER_NODE, PointLaw, hats, hertz_patch, patch, patch_force, patches
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.continuum import hertz_approach
from fem.kernels.elements.state import Spread
from fem.kernels.elements.surfaces import N_NODES
from fem.kernels.fields import filled
from lagrange import Bearing
from lagrange.contact.hertz import contact_pairs, line_compliance
from meshes import bearing_shapes, graded_shapes

LAYER = 8.0  # stiffness of the layer times the surface spacing, over E*: see docs/crossover.md for what it costs
COARSEST = 0.6  # surface spacing over the half-width of a contact to be resolved
AGAINST = "inner_ring", "outer_ring", "roller"  # what a roller meets, by kind of contact


@dataclass(frozen=True, kw_only=True)
class ResolvedLaw(PointLaw):
    """A pair of surfaces with a layer between them."""

    layer: float  # pressure per penetration, Pa/m

    @property
    def point_stiffness(self) -> float:
        """Force per penetration of one point, N/m."""
        return self.layer * self.spacing * self.pair.length

    def local_compliance(self, n_points: int) -> np.ndarray:
        return np.eye(n_points) / self.point_stiffness


@dataclass(frozen=True, kw_only=True)
class ResolvedModel(Model):
    """Contacts whose points push the nodes beside them."""

    shapes: ClassVar = staticmethod(graded_shapes)
    shares: ClassVar = staticmethod(hats)
    coarsest: ClassVar[float] = COARSEST
    failure_hint: ClassVar[str] = (
        "pressure points reach as far as static loads need, and an impact may have made a contact wider: a coarser "
        "numerics.mesh_size_mm has no such limit; or "
    )
    stress_note: ClassVar[str] = "contacts resolved"

    @classmethod
    def build(cls, bearing: Bearing, mesh_size, largest_force=0.0, stiffness=0.0) -> Model:
        bodies = assembled_bodies(bearing, graded_shapes(bearing, mesh_size))
        return cls.of(bearing, bodies, resolved_laws(bearing, bodies))


def resolved_laws(bearing: Bearing, bodies: dict[str, DiscBody | RingBody]) -> list[ResolvedLaw]:
    """Laws by kind of contact; the finer of two surfaces counts."""
    found = []
    for pair, name in zip(contact_pairs(bearing), AGAINST, strict=True):
        spacing = min(bodies[name].surface_spacing, bodies["roller"].surface_spacing)
        found.append(ResolvedLaw(pair=pair, layer=LAYER * pair.modulus / spacing, spacing=spacing / POINTS_PER_NODE))
    return found


POINTS_PER_HALF_WIDTH = 10  # at the largest static force
SPAN = 3  # half-range of the points over that half-width: nine times that force
PLACES = 6  # on a roller's sextant, and
PLACES_PER_NODE = 8  # about which its softness is averaged
# ∬ p p' ln|s − s'| of two unit Hertz pressures of half-width 1, −ln 2 − ¼ (Johnson, Contact Mechanics, 1985, ch. 5)
HERTZ_LOG_MOMENT = -log(2.0) - 0.25
MEAN_BELOW_CENTRE = 0.25  # of A: by how much the pressure's mean displacement is less than the centre's, b²/8R


@dataclass(frozen=True, kw_only=True)
class SpreadLaw(PointLaw):
    """A pair of surfaces with the compliance that the mesh lacks between points."""

    missing_compliance: np.ndarray  # (n_points,), m/N, G by the distance in spacings

    def most(self, largest_force: float) -> int:
        return self.missing_compliance.size // 2

    def places(self, half_count: int) -> np.ndarray:
        """See `PointLaw.places`: no more than compliances are known for."""
        return super().places(min(half_count, self.missing_compliance.size // 2))

    def local_compliance(self, n_points: int) -> np.ndarray:
        return toeplitz(self.missing_compliance[:n_points])

    @staticmethod
    def spread(laws: tuple, n_points: int, n_rollers: int) -> Spread:
        missing = np.stack([law.missing_compliance for law in laws])
        counts = range(1, missing.shape[1] + 1)  # of neighbouring points: G's inverses by rows, one after the other
        inverse = [np.concatenate([np.linalg.inv(law.local_compliance(n)).ravel() for n in counts]) for law in laws]
        sizes = {"pairs": 3, "n": n_rollers, "n_points": n_points}
        return filled(Spread, sizes, missing=missing, inverse=np.stack(inverse))


@dataclass(frozen=True, kw_only=True)
class SpreadModel(ResolvedModel):
    """Contacts whose points push patches of nodes, and what the mesh lacks between them."""

    shares: ClassVar = staticmethod(patches)
    nodes_beyond: ClassVar[float] = 3.0 + N_NODES
    coarsest: ClassVar[float] = ONE_PATCH
    is_made_for_a_force: ClassVar[bool] = True
    stress_note: ClassVar[None] = None

    @classmethod
    def build(cls, bearing: Bearing, mesh_size, largest_force=0.0, stiffness=0.0) -> Model:
        bodies = assembled_bodies(bearing, graded_shapes(bearing, mesh_size))
        laws = []
        for pair, name in zip(contact_pairs(bearing), AGAINST, strict=True):
            spacing = pair.half_width(largest_force) / POINTS_PER_HALF_WIDTH  # as dense as each one's width needs
            apart = spacing * np.arange(2 * SPAN * POINTS_PER_HALF_WIDTH)
            missing = sum(_missing_compliance(bodies[body], pair.length, apart) for body in (name, "roller"))
            laws.append(SpreadLaw(pair=pair, spacing=spacing, missing_compliance=missing))
        return cls.of(bearing, bodies, laws)

    def smeared(self, spacing: float, half_width: float) -> float:
        """See `Model.smeared`: pressure smeared out by a patch is about a patch with the sum of the variances."""
        return 0.5 * float(np.hypot(2.0 * spacing, np.sqrt(3.0) * half_width))  # (2h)²/12 and b²/4


def _missing_compliance(body, thickness, apart):
    """G of one body at distances `apart`, m/N."""
    unit, cell = line_compliance(body.material, thickness), apart[1]
    section = body.section.squeezed if isinstance(body, DiscBody) else body.section
    width = 0.01 * section.loaded  # any narrow one
    constant = hertz_approach(section, width) / thickness + unit * (log(width) + HERTZ_LOG_MOMENT - MEAN_BELOW_CENTRE)

    def twice(x):
        """Second antiderivative of ln|x|."""
        size = np.abs(x)
        return 0.5 * size**2 * np.log(np.where(size > 0.0, size, 1.0)) - 0.75 * size**2

    # mean of ln|s − s'| over two cells as wide as the distances' spacing
    logarithm = (twice(apart + cell) - 2.0 * twice(apart) + twice(apart - cell)) / cell**2
    return constant - unit * logarithm - _answer(body, apart)


def _answer(body, apart):
    """Mean motion of a patch at distances from a unit force, of a disc one of two opposite ones, m/N; over places."""
    disc, n = isinstance(body, DiscBody), body.n_surface
    first = np.unique(np.arange(PLACES) * (n // body.shape.repeats) // PLACES) if disc else np.zeros(1)
    angles = 2.0 * pi / n * (first[:, None] + np.arange(PLACES_PER_NODE) / PLACES_PER_NODE).ravel()
    loads = np.stack([patch_force(body, angle) for angle in angles], axis=-1)
    if disc:
        loads += np.stack([patch_force(body, angle + pi) for angle in angles], axis=-1)
    motion = (body.relaxed if disc else body.held)(loads).reshape(-1, angles.size)[body.surface_places(np.arange(n))]
    motion, found = motion.reshape(n, 2, -1), np.zeros(apart.size)
    for k, angle in enumerate(angles):
        for i, there in enumerate(angle + apart / body.section.loaded):
            on, weight, offset = patch(n, there)
            turn = there if disc else offset
            found[i] += weight @ (motion[on, 0, k] * np.cos(turn) + motion[on, 1, k] * np.sin(turn))
    return found / angles.size


@dataclass(frozen=True, kw_only=True)
class SpringLaw(ResolvedLaw):
    """A pair of surfaces with one point, whose layer is as stiff as the spring."""

    sagitta: tuple[float, float]  # of both sides' facets, m, negative in a bore; 0: circles

    def places(self, half_count: int) -> np.ndarray:
        return np.zeros(1)


@dataclass(frozen=True, kw_only=True)
class PenaltyModel(Model):
    """Contacts of one spring each, between circles."""

    shares: ClassVar = staticmethod(hats)
    static_passes: ClassVar[int] = 6  # facets may leave the hub room to move by milliradians
    stress_note: ClassVar[str] = "forces on two nodes"
    facet: ClassVar[float] = 0.0  # share of the facets' sagittas h²/8R that is there

    @classmethod
    def build(cls, bearing: Bearing, mesh_size, largest_force=0.0, stiffness=0.0) -> Model:
        bodies, found = assembled_bodies(bearing, bearing_shapes(bearing, mesh_size)), []
        for law, name in zip(resolved_laws(bearing, bodies), AGAINST, strict=True):
            spacing, sides = POINTS_PER_NODE * law.spacing, zip((name, "roller"), law.pair.radii, strict=True)
            sagitta = tuple(cls.facet * bodies[side].surface_spacing ** 2 / (8.0 * radius) for side, radius in sides)
            layer = stiffness / (spacing * law.pair.length)
            found.append(SpringLaw(pair=law.pair, layer=layer, spacing=spacing, sagitta=sagitta))
        return cls.of(bearing, bodies, found)

    def carried(self, kind: int, n_surface: int, angle: float, radius: float, force: float):
        """See `Model.carried`: the nodes beside the point, whatever the force."""
        return hertz_patch(n_surface, angle, 0.0, self.shares)

    def give(self, load: float) -> float:
        """See `Model.give`: a soft spring deflects more than steel."""
        return 2.0 * load / self.inner_law.point_stiffness


class FacetedModel(PenaltyModel):
    """The same between facets."""

    facet: ClassVar[float] = 1.0
