"""Compliance of discs and rings between the nodes of their contacts, from quadratic elements on refined meshes.

Displacements are linear in the forces on the nodes of one contact; by rotation the other contacts follow. Forces and
displacements are along the line of centres, positive where a force pushes the surface in.
"""

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri, MeshTri2
from skfem.helpers import dot
from skfem.models.elasticity import linear_elasticity

from lagrange import Material
from tests.reference.refined_mesh import RefinedDisc, RefinedSector, Spot, refined_mesh

QUADRATURE = 4  # order; exact for the stiffness of straight triangles
HERMITIAN = {"SymmetricMode": True}  # SuperLU's way with positive definite matrices: half the fill
SAME = 1e-6  # of a radius: nodes this close to a circle or a side lie on it


def contact_nodes(spot: Spot) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of one contact along the tangent, (m,), m, and the length each stands for, (m,), m, by Simpson's rule."""
    along = np.empty(2 * len(spot.corners) - 1)
    along[::2] = spot.corners
    along[1::2] = 0.5 * (spot.corners[:-1] + spot.corners[1:])
    length = np.zeros(along.size)
    edges = np.diff(spot.corners)
    length[1::2] = edges * (4.0 / 6.0)
    length[:-1:2] += edges / 6.0
    length[2::2] += edges / 6.0
    return along, length


def disc_spot_compliance(disc: RefinedDisc, material: Material, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Compliance of a free disc between the nodes of one spot, and from the other spot to this, (m, m) each, m/N.

    The disc accelerates freely under its forces (inertia relief); displacements are relative to its centre of mass.
    Either spot counts its nodes counter-clockwise.
    """
    basis = _basis(refined_mesh(disc), (disc.radius,))
    stiffness = thickness * _stiffness(basis, material)
    mass = BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis)
    modes = _rigid_modes(basis)
    weighted = mass @ modes
    pushed = [_spot_nodes(basis, disc.radius, angle, disc.spot) for angle in (0.0, np.pi)]
    force = np.zeros((basis.N, pushed[0].size))
    force[pushed[0], np.arange(pushed[0].size)] = -1.0
    force -= weighted @ np.linalg.solve(modes.T @ weighted, modes.T @ force)
    bordered = sparse.bmat([[stiffness, weighted], [weighted.T, None]], format="csc")
    found = splu(bordered).solve(np.concatenate([force, np.zeros((3, force.shape[1]))]))
    return -found[pushed[0]], found[pushed[1]]


def ring_spot_compliance(ring: RefinedSector, material: Material, thickness: float) -> np.ndarray:
    """Compliance of a ring held on its other circle, (n_sectors, m, m), m/N.

    Entry [k] is the displacement of a spot by forces on the spot k sectors behind it (clockwise).

    Displacements of sector k in its own axes are Σ û exp(2πi·h·k/n) over harmonics h, and each harmonic is a problem of
    one sector whose sides are tied by u₊ = exp(2πi·h/n) R(2π/n) u₋ (Thomas, J. Sound Vib. 66, 585, 1979).
    """
    basis = _basis(refined_mesh(ring), (ring.raceway_radius, ring.held_radius))
    stiffness = thickness * _stiffness(basis, material)
    free, tied = _ties(basis, ring)
    pushed = _spot_nodes(basis, ring.raceway_radius, 0.0, ring.spot)
    force = np.zeros((basis.N, pushed.size))
    force[pushed, np.arange(pushed.size)] = 1.0
    force = free.T @ force  # no spot touches a side
    own = free.T @ stiffness @ free + tied.T @ stiffness @ tied
    across = free.T @ stiffness @ tied
    found = []
    for harmonic in range(ring.sectors // 2 + 1):
        phase = np.exp(2j * np.pi * harmonic / ring.sectors)
        matrix = own + phase * across + np.conj(phase) * across.T
        factor = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=HERMITIAN)
        found.append(force.T @ factor.solve(force.astype(complex)))
    return np.fft.irfft(np.array(found), n=ring.sectors, axis=0)


def _basis(mesh, circles: tuple[float, ...]) -> Basis:
    """Quadratic elements; the middles of edges between corners on a circle lie on it."""
    straight = MeshTri(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cells.T))
    curved = MeshTri2.from_mesh(straight)
    edges = straight.boundary_facets()
    radius = np.hypot(*straight.p[:, straight.facets[:, edges]])
    middles = curved.dofs.facet_dofs[0, edges]
    points = curved.doflocs.copy()
    for circle in circles:
        on = middles[np.all(np.abs(radius - circle) < SAME * circle, axis=0)]
        points[:, on] *= circle / np.hypot(*points[:, on])
    return Basis(replace(curved, doflocs=points), ElementVector(ElementTriP2()), intorder=QUADRATURE)


def _stiffness(basis: Basis, material: Material) -> sparse.csr_matrix:
    """Plane strain, of unit thickness, Pa."""
    return linear_elasticity(material.lame_lambda, material.lame_mu).assemble(basis).tocsr()


def _nodes(basis: Basis) -> tuple[np.ndarray, np.ndarray]:
    """Degrees of freedom of every node, corners then middles of edges, (2, n_nodes), and where they are."""
    dofs = np.concatenate([basis.nodal_dofs, basis.facet_dofs], axis=1)
    return dofs, basis.doflocs[:, dofs[0]]


def _rigid_modes(basis: Basis) -> np.ndarray:
    """Two translations and the rotation about the origin, (N, 3)."""
    (x_dofs, y_dofs), (x, y) = _nodes(basis)
    modes = np.zeros((basis.N, 3))
    modes[x_dofs, 0] = modes[y_dofs, 1] = 1.0
    modes[x_dofs, 2], modes[y_dofs, 2] = -y, x
    return modes


def _spot_nodes(basis: Basis, radius: float, angle: float, spot: Spot) -> np.ndarray:
    """Degrees of freedom along x, (m,), of a spot's nodes, counter-clockwise."""
    dofs, (x, y) = _nodes(basis)
    off = np.mod(np.arctan2(y, x) - angle + np.pi, 2.0 * np.pi) - np.pi
    end = np.arcsin(spot.corners[-1] / radius)
    on = np.flatnonzero((np.abs(np.hypot(x, y) - radius) < 1e-9 * radius) & (np.abs(off) < end + SAME))
    return dofs[0, on[np.argsort(off[on])]]


def _ties(basis: Basis, ring: RefinedSector) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """From the unknowns, nodes off the held circle and off one side, to those nodes and to the nodes of that side."""
    dofs, (x, y) = _nodes(basis)
    radius, angle, half = np.hypot(x, y), np.arctan2(y, x), np.pi / ring.sectors
    held = np.abs(radius - ring.held_radius) < SAME * ring.held_radius
    sides = [np.flatnonzero(~held & (np.abs(angle - side) < SAME)) for side in (-half, half)]
    first, second = (side[np.argsort(radius[side])] for side in sides)
    if first.size != second.size or not np.allclose(radius[first], radius[second], rtol=SAME):
        raise RuntimeError("the nodes on the two sides of a sector differ")
    unknown = np.ones(x.size, dtype=bool)
    unknown[held] = unknown[second] = False
    columns = dofs[:, unknown].T.ravel()
    free = sparse.csr_matrix((np.ones(columns.size), (columns, np.arange(columns.size))), (basis.N, columns.size))
    c, s = np.cos(2.0 * half), np.sin(2.0 * half)
    turned = sparse.csr_matrix((basis.N, basis.N), dtype=float).tolil()
    turned[dofs[0, second], dofs[0, first]], turned[dofs[0, second], dofs[1, first]] = c, -s
    turned[dofs[1, second], dofs[0, first]], turned[dofs[1, second], dofs[1, first]] = s, c
    return free, turned.tocsr() @ free
