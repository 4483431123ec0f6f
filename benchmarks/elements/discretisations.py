"""Elements with lumped masses: from a mesh to the matrices an explicit solver needs.

Every mass is scaled to that of the exact circle, as the solver does it. Row sums lump wherever they are positive; where
they are not, the diagonal of the consistent mass scaled to the element's mass does (Hinton, Rock and Zienkiewicz,
Earthquake Eng. Struct. Dyn. 4, 245, 1976), or a bubble makes them positive.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementQuadS2,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    LinearForm,
)  # fmt: skip
from skfem.element import ElementTriP2B
from skfem.models.elasticity import linear_elasticity

from lagrange import Material

SOLVERS_QUADRATURE = 3  # 2 x 2 Gauss points
QUADRATURE = 6  # exact for the masses of elements of second order with straight edges
LOAD_QUADRATURE = 30  # the knots of a spline load lie anywhere on an edge


class ElementTriP2Bubble(ElementTriP2B):
    """Quadratic triangle with a bubble and a node in the middle: row sums of its mass are 1/20, 2/15 and 9/20.

    Source: Cohen, Joly, Roberts and Tordjman, SIAM J. Numer. Anal. 38, 2047 (2001), the element of second order.
    """

    doflocs = np.vstack([ElementTriP2B.doflocs[:6], [1.0 / 3.0, 1.0 / 3.0]])
    AT_MIDDLE = (-1.0 / 9.0, -1.0 / 9.0, -1.0 / 9.0, 4.0 / 9.0, 4.0 / 9.0, 4.0 / 9.0)  # of the quadratic functions

    def lbasis(self, X, i):
        value, gradient = super().lbasis(X, i)
        if i == 6:
            return value, gradient
        bubble, slope = super().lbasis(X, 6)
        return value - self.AT_MIDDLE[i] * bubble, gradient - self.AT_MIDDLE[i] * slope


ELEMENTS = {
    "P1": ElementTriP1, "P2": ElementTriP2, "P2 + bubble": ElementTriP2Bubble,
    "Q1": ElementQuad1, "Q1, one point": ElementQuad1, "Q2": ElementQuad2, "S2": ElementQuadS2,
}  # fmt: skip
DIAGONAL_SCALED = ("P2", "S2")


@dataclass(frozen=True, kw_only=True)
class Discrete:
    """A body made discrete; degree of freedom 2·i + k is component k of node i."""

    points: np.ndarray  # (n, 2), m
    stiffness: sparse.csr_array  # (2n, 2n), N/m
    mass: np.ndarray  # (n,), kg
    basis: Basis  # of the displacement, scikit-fem's numbering
    order: np.ndarray  # (2n,), scikit-fem's degree of freedom of each of ours

    def pressed(self, radius: float, pressure) -> np.ndarray:
        """Consistent nodal forces (2n,) of an inward line load p(θ), N/m of arc, on the circle of that radius.

        The mesh's boundary takes the load of the same angle of the circle, so its resultant is exact.
        """
        mesh = self.basis.mesh
        ends = np.hypot(*mesh.p[:, mesh.facets])
        on = np.flatnonzero(np.all(np.abs(ends - radius) < 1e-9 * radius, axis=0))
        edges = FacetBasis(mesh, self.basis.elem, facets=on, intorder=LOAD_QUADRATURE)

        def work(v, w):
            x, y = w.x
            r = np.hypot(x, y)
            arc = radius * np.abs(w.n[0] * x + w.n[1] * y) / r**2  # of the circle per length of the edge
            return -pressure(np.arctan2(y, x)) * arc * (v[0] * x + v[1] * y) / r

        return LinearForm(work).assemble(edges)[self.order]


def discretise(mesh, element: str, material: Material, thickness: float, area: float) -> Discrete:
    """Stiffness and lumped mass of a mesh; `area`, m², is the exact body's.

    Errors
    ------
    ValueError: a lumped mass is not positive.
    """
    scalar = ELEMENTS[element]()
    quadrature = SOLVERS_QUADRATURE if scalar.facet_dofs == 0 else QUADRATURE
    vector_basis = Basis(mesh, ElementVector(scalar), intorder=quadrature)
    order = _nodes(vector_basis).T.ravel()
    if element == "Q1, one point":
        stiffness = one_point_stiffness(vector_basis, material)
    else:
        stiffness = linear_elasticity(material.lame_lambda, material.lame_mu).assemble(vector_basis)
    scalar_basis = Basis(mesh, scalar, intorder=quadrature)
    lump = diagonal_scaled if element in DIAGONAL_SCALED else row_sums
    mass = lump(scalar_basis)[_nodes(scalar_basis)[0]]
    if not mass.min() > 0.0:
        raise ValueError(f"the lumped mass of {element} has entries of {mass.min():.2e} m², must be positive")
    return Discrete(
        points=vector_basis.doflocs[:, order[::2]].T,
        stiffness=sparse.csr_array(thickness * stiffness.tocsr()[order][:, order]),
        mass=mass * (material.density * thickness * area / mass.sum()),
        basis=vector_basis,
        order=order,
    )


def row_sums(basis: Basis) -> np.ndarray:
    """Of the consistent mass of unit density, (N,), m²; they need not be positive."""
    return np.asarray(BilinearForm(lambda u, v, _: u * v).assemble(basis).sum(axis=1)).ravel()


def diagonal_scaled(basis: Basis) -> np.ndarray:
    """Hinton, Rock and Zienkiewicz's lumped mass of unit density, (N,), m²."""
    local = np.array([np.sum(np.asarray(basis.basis[i][0]) ** 2 * basis.dx, axis=1) for i in range(basis.Nbfun)])
    local *= basis.dx.sum(axis=1) / local.sum(axis=0)
    return np.bincount(basis.element_dofs.ravel(), weights=local.ravel(), minlength=basis.N)


def one_point_stiffness(basis: Basis, material: Material) -> sparse.csr_matrix:
    """Bilinear quadrilaterals integrated at their centre, with an hourglass stiffness, of unit thickness, Pa.

    The hourglass pattern γ is orthogonal to linear fields (Flanagan and Belytschko, Int. J. Numer. Meth. Eng. 17, 679,
    1981); its stiffness is that of pure bending without parasitic shear, along the element's own axes (Belytschko and
    Bachrach, Comput. Meth. Appl. Mech. Eng. 54, 279, 1986), exact for rectangles.
    """
    corners = np.moveaxis(basis.mesh.p[:, basis.mesh.t], -1, 0)  # (cells, 2, 4)
    ksi, eta = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    pattern = ksi * eta
    jacobian = 0.25 * np.stack([corners @ ksi, corners @ eta], axis=1)  # (cells, ksi or eta, x or y)
    area = 4.0 * np.linalg.det(jacobian)
    gradient = np.linalg.solve(jacobian, np.broadcast_to(0.25 * np.array([ksi, eta]), (len(corners), 2, 4)))
    lame, mu = material.lame_lambda, material.lame_mu
    local = lame * np.einsum("cia,cjb->caibj", gradient, gradient)
    local += mu * np.einsum("cja,cib->caibj", gradient, gradient)
    local += mu * np.einsum("cka,ckb,ij->caibj", gradient, gradient, np.eye(2))
    local *= area[:, None, None, None, None]
    hourglass = 0.25 * (pattern - np.einsum("cij,j,cia->ca", corners, pattern, gradient))
    along, across = np.moveaxis(jacobian / np.linalg.norm(jacobian, axis=2)[:, :, None], 1, 0)
    first = along + across[:, ::-1] * [1.0, -1.0]  # halfway between ξ and η turned back by 90°
    first /= np.linalg.norm(first, axis=1)[:, None]
    axes = np.stack([first, first[:, ::-1] * [-1.0, 1.0]], axis=1)  # (cells, own axis, x or y)
    # ∫ (∂(ξη)/∂x)² along the own axes, of the parallelogram at the centre: ∫ ξ² = ∫ η² = 4/3
    own = np.linalg.inv(np.einsum("cki,cji->ckj", jacobian, axes))  # (cells, own axis, ksi or eta)
    bending = np.sum(own**2, axis=2) * area[:, None] / 3.0
    block = material.plane_strain_modulus * np.einsum("ci,cik,cil->ckl", bending, axes, axes)
    local += np.einsum("ca,ckl,cb->cakbl", hourglass, block, hourglass)
    dofs = basis.nodal_dofs[:, basis.mesh.t].transpose(2, 1, 0).reshape(len(corners), 8)
    rows, columns = np.repeat(dofs, 8, axis=1).ravel(), np.tile(dofs, (1, 8)).ravel()
    return sparse.coo_matrix((local.reshape(-1), (rows, columns)), shape=(basis.N, basis.N)).tocsr()


def _nodes(basis: Basis) -> np.ndarray:
    """Degrees of freedom of every node, (components, n): corners, middles of edges, middles of cells."""
    kinds = basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs
    return np.concatenate([dofs for dofs in kinds if dofs.size], axis=1)
