"""Triangles of a section that gmsh has been told, and their plane-strain stiffness: for yardsticks with own meshes."""

import gmsh
import numpy as np
from skfem import Basis, BilinearForm, MeshTri
from skfem.helpers import ddot, eye, sym_grad, trace

from lagrange import Material


def mesh_of_section() -> MeshTri:
    """Mesh what gmsh holds; nodes that no triangle has are left out."""
    gmsh.model.mesh.generate(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(2)
    used, cells = np.unique(nodes, return_inverse=True)
    order = np.argsort(tags)
    points = coordinates.reshape(-1, 3)[order[np.searchsorted(tags[order], used)], :2]
    return MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.reshape(-1, 3).T))


def plane_strain_stiffness(basis: Basis, material: Material):
    """Stiffness of a section one metre long, N/m, sparse, (basis.N, basis.N)."""
    lam, mu = material.lame_lambda, material.lame_mu

    @BilinearForm
    def stiffness(u, v, w):
        e = sym_grad(u)
        return ddot(2.0 * mu * e + lam * eye(trace(e), 2), sym_grad(v))

    return stiffness.assemble(basis)
