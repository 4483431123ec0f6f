"""scikit-fem assembles stiffness and lumped mass of a mesh: plane strain times the thickness."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from skfem import Basis, BilinearForm, ElementQuad1, ElementTriP1, ElementVector, MeshQuad, MeshTri
from skfem.models.elasticity import linear_elasticity

from lagrange import Material
from meshes import Mesh


@dataclass(frozen=True, kw_only=True)
class Assembled:
    """Matrices of one body; degree of freedom 2·i + k is component k of node i."""

    stiffness: sparse.csr_matrix  # (2n, 2n), N/m
    mass: np.ndarray  # (n,), kg, row sums of the consistent mass matrix


def assemble(mesh: Mesh, material: Material, thickness: float) -> Assembled:
    """Stiffness and lumped mass of a plane mesh.

    Triangles are linear, quadrilaterals bilinear with 2 x 2 Gauss points. The thickness, m, enters here once:
    masses are kg and forces N everywhere after.

    Source: scikit-fem's linear elasticity with the three-dimensional Lamé constants, which is plane strain.
    """
    points, cells = np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cells.T)
    if mesh.cells.shape[1] == 3:
        grid, scalar, order = MeshTri(points, cells), ElementTriP1(), 2
    else:
        grid, scalar, order = MeshQuad(points, cells), ElementQuad1(), 3
    form = linear_elasticity(material.lame_lambda, material.lame_mu)
    vector_basis = Basis(grid, ElementVector(scalar), intorder=order)
    scalar_basis = Basis(grid, scalar, intorder=order)
    stiffness = thickness * form.assemble(vector_basis).tocsr()
    mass = BilinearForm(lambda u, v, _: u * v).assemble(scalar_basis)
    return Assembled(
        stiffness=stiffness[_node_major(vector_basis)][:, _node_major(vector_basis)],
        mass=material.density * thickness * np.asarray(mass.sum(axis=1)).ravel(),
    )


def _node_major(basis: Basis) -> np.ndarray:
    return basis.nodal_dofs.T.ravel()
