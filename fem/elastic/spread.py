"""Contacts on a mesh about as fine as they are wide: pressure points, each spread over a patch of the mesh.

Where the mesh is far coarser than a contact, one patch carries it all and Hertz's formula gives what the mesh can't
see (`subgrid`). Where it is finer, the pressure is found at points instead. The force q_j of a point is spread over a
patch like that one, the overlap at a point is read with the same patch, and what the mesh lacks between two points is

    G_ij = C − A ⟨ln|s − s'|⟩_ij − F(d_ij),    A = 2 / (π E' L),

for each body: the half-plane under cells of even pressure, C so that Hertz's pressure gets the exact approach of that
body (as in `subgrid`), less the finite elements' own answer F of one patch at the distance d of the other. G is the
term below the grid: it is all of a contact on a coarse mesh, has a range of four surface spacings, and vanishes as the
mesh is refined.
"""

from dataclasses import dataclass
from math import log, pi, sqrt

import numpy as np
from scipy.linalg import toeplitz

from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.continuum import disc_hertz_approach, ring_hertz_approach
from fem.elastic.subgrid import disc_patch_force, patch, ring_patch_force
from fem.kernels.state import INNER, OUTER, ROLLER
from lagrange import Bearing

POINTS_PER_HALF_WIDTH = 10  # at the largest static force
ONE_PATCH = 2.0  # least surface spacing over a contact's half-width at which one patch is far wider than the contact
SPAN = 3  # half-range of the points over that half-width: nine times that force
PLACES = 6  # on a roller's sextant, and
PLACES_PER_NODE = 8  # about which its softness is averaged
# ∬ p p' ln|s − s'| of two unit Hertz pressures of half-width 1, −ln 2 − ¼ (Johnson, Contact Mechanics, 1985, ch. 5)
HERTZ_LOG_MOMENT = -log(2.0) - 0.25
MEAN_BELOW_CENTRE = 0.25  # of A: by how much the pressure's mean displacement is less than the centre's, b²/8R


@dataclass(frozen=True, kw_only=True)
class SpreadLaw:
    """A pair of surfaces pressed together at points."""

    relative_radius: float  # R, m
    half_width_factor: float  # b²/Q = 4R/(π E* L), m²/N (Johnson, Contact Mechanics, 1985, ch. 4)
    spacing: float  # of the points, m
    radii: tuple[float, float]  # of side 0 and side 1, m; a bore's is negative
    thickness: float  # m
    lack: np.ndarray  # (n_points,), m/N, G by the distance in spacings

    is_one_point = False
    sagitta = None
    spreads = True

    def half_width(self, force: float) -> float:
        """Hertz half-width b, m."""
        return sqrt(self.half_width_factor * force)

    @property
    def most_points(self) -> int:
        """Points of a contact."""
        return self.lack.size

    def inverses(self) -> np.ndarray:
        """Inverses of G for 1, 2, ... neighbouring points, each by rows, one after the other; N/m."""
        return np.concatenate([np.linalg.inv(toeplitz(self.lack[:n])).ravel() for n in range(1, self.most_points + 1)])

    def local_compliance(self, n_points: int) -> np.ndarray:
        """What the mesh lacks between neighbouring points, (n_points, n_points), m/N."""
        return toeplitz(self.lack[:n_points])


def spread_laws(
    bearing: Bearing, roller: DiscBody, inner: RingBody, outer: RingBody, largest_force: float
) -> dict[int, SpreadLaw]:
    """Laws by kind of contact; the largest static force in N. Points stand as dense as the narrowest one needs."""
    length, r = bearing.roller_length, bearing.roller_radius
    radii = {INNER: (bearing.inner_raceway_radius, r), OUTER: (-bearing.outer_raceway_radius, r), ROLLER: (r, r)}
    sides = {INNER: (inner, roller), OUTER: (outer, roller), ROLLER: (roller, roller)}
    found = {}
    for kind in radii:
        unit = sum(_unit(body, length) for body in sides[kind])
        relative = 1.0 / sum(1.0 / radius for radius in radii[kind])
        spacing = sqrt(2.0 * relative * unit * largest_force) / POINTS_PER_HALF_WIDTH
        apart = spacing * np.arange(2 * SPAN * POINTS_PER_HALF_WIDTH)
        found[kind] = SpreadLaw(
            relative_radius=relative,
            half_width_factor=2.0 * relative * unit,
            spacing=spacing,
            radii=radii[kind],
            thickness=length,
            lack=sum(_lack(body, length, apart) for body in sides[kind]),
        )
    return found


def _unit(body: DiscBody | RingBody, thickness: float) -> float:
    """A = 2/(π E' L) of one body, m/N."""
    return 2.0 / (pi * body.material.plane_strain_modulus * thickness)


def _lack(body: DiscBody | RingBody, thickness: float, apart: np.ndarray) -> np.ndarray:
    """G of one body at distances, m/N."""
    unit = _unit(body, thickness)
    if isinstance(body, DiscBody):
        width = 0.01 * body.shape.radius  # any narrow one
        exact = disc_hertz_approach(body.shape.radius, body.material, width) / thickness
        found = _disc_answer(body, apart)
    else:
        width = 0.01 * body.raceway_radius
        held = float(body.radii[body.held_row])
        exact = ring_hertz_approach(body.raceway_radius, held, body.material, width) / thickness
        found = _ring_answer(body, apart)
    constant = exact + unit * (log(width) + HERTZ_LOG_MOMENT - MEAN_BELOW_CENTRE)
    return constant - unit * _cells_log(apart) - found


def _cells_log(apart: np.ndarray) -> np.ndarray:
    """Mean of ln|s − s'| over two cells as wide as the distances' spacing."""
    width = apart[1]

    def twice(x):  # second antiderivative of ln|x|
        size = np.abs(x)
        return 0.5 * size**2 * np.log(np.where(size > 0.0, size, 1.0)) - 0.75 * size**2

    return (twice(apart + width) - 2.0 * twice(apart) + twice(apart - width)) / width**2


def _disc_answer(disc: DiscBody, apart: np.ndarray) -> np.ndarray:
    """Mean motion of a patch at distances from one of two opposite unit forces, m/N; mean over places."""
    nodes = disc.shape.surface_nodes
    first = np.unique(np.arange(PLACES) * (nodes // disc.shape.repeats) // PLACES)
    angles = 2.0 * pi / nodes * (first[:, None] + np.arange(PLACES_PER_NODE) / PLACES_PER_NODE).ravel()
    loads = np.stack([disc_patch_force(disc, a) + disc_patch_force(disc, a + pi) for a in angles], axis=-1)
    motion = disc.relaxed(loads)
    surface = motion.reshape(disc.n_nodes, 2, -1)[disc.first_surface_node :]
    found = np.zeros(apart.size)
    for k, angle in enumerate(angles):
        for i, there in enumerate(angle + apart / disc.shape.radius):
            on, weight, _ = patch(nodes, there)
            found[i] += weight @ (surface[on, 0, k] * np.cos(there) + surface[on, 1, k] * np.sin(there))
    return found / angles.size


def _ring_answer(ring: RingBody, apart: np.ndarray) -> np.ndarray:
    """Mean motion of a patch at distances from a unit force, m/N; mean over places."""
    angles = 2.0 * pi / ring.n_sectors * np.arange(PLACES_PER_NODE) / PLACES_PER_NODE
    motion = ring.held(np.stack([ring_patch_force(ring, a) for a in angles], axis=-1))[ring.raceway_row]
    found = np.zeros(apart.size)
    for k, angle in enumerate(angles):
        for i, there in enumerate(angle + apart / ring.raceway_radius):
            nodes, weight, offset = patch(ring.n_sectors, there)
            found[i] += weight @ (motion[0, nodes, k] * np.cos(offset) + motion[1, nodes, k] * np.sin(offset))
    return found / angles.size
