"""Elastic bodies of quadratic triangles that touch without friction, node by node, in motion.

A body moves by its lowest modes; what all others add to the motion of the nodes that may be touched follows at once, as
in statics. A step is a small linear complementarity problem: gaps and forces are not negative, and one of the two is
zero. Nothing stands between the nodes and the surfaces: what a contact yields is what the elements yield.

Source: Rubin, AIAA J. 13 (1975) 995 (residual flexibility); Hintermüller, Ito and Kunisch, SIAM J. Optim. 13 (2002) 865
(active sets).
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri
from skfem.helpers import dot

from lagrange import Material
from tests.reference.triangles import plane_strain_stiffness

SHIFT = (2.0 * pi * 2e3) ** 2  # 1/s²: bodies are held by as much of their mass, far below any mode that is left out
AT_ONCE = 32  # unit forces solved for
MOST_TURNS = 40  # of the active set; 2 to 6 are usual


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A body as its contact nodes feel it."""

    points: np.ndarray  # (n_contact, 2), m, contact nodes as meshed
    omega: np.ndarray  # (n_modes,), rad/s; 0 of rigid ones
    shapes: np.ndarray  # (2 n_contact, n_modes), x and y of each node, 1/√kg
    residual: np.ndarray  # (2 n_contact, 2 n_contact), m/N
    translation: np.ndarray  # (n_modes, 2), √kg: modes' parts in moving along x and y by 1
    mass: float  # kg


def body(
    mesh: MeshTri, material: Material, length: float, cutoff: float, touched, held=None, mass: float | None = None
) -> Body:
    """Assemble a body and find its modes up to `cutoff`, Hz; `touched`, `held`: which of points, (2, n), may be, are.

    `mass` : kg, of the circle that the polygon stands for; None: as meshed
    """
    basis = Basis(mesh, ElementVector(ElementTriP2()))

    @BilinearForm
    def inertia(u, v, w):
        return dot(u, v)

    K, M = length * plane_strain_stiffness(basis, material), material.density * length * inertia.assemble(basis)
    x, along_x = basis.doflocs, np.zeros(basis.N, dtype=bool)
    along_x[basis.get_dofs(elements=np.arange(mesh.nelements)).all("u^1")] = True
    free, rim = np.ones(basis.N, dtype=bool), np.zeros(basis.N, dtype=bool)
    if held is not None:
        free[held(x)] = False
    rim[basis.get_dofs(mesh.boundary_facets()).all()] = True
    at = rim & touched(x)
    first, second = (k[np.lexsort(np.round(x[:, k], 12))] for k in map(np.flatnonzero, (at & along_x, at & ~along_x)))
    contact = (np.cumsum(free) - 1)[np.stack([first, second], axis=1)].ravel()
    K, M = K[free][:, free].tocsc(), M[free][:, free].tocsc()
    unit = np.stack([along_x, ~along_x], axis=1).astype(float)[free]
    if mass is not None:
        M = M * (mass / float(unit[:, 0] @ (M @ unit[:, 0])))
    factor = splu(
        (K + SHIFT * M).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    omega, modes = _modes(K, M, factor, 2.0 * pi * cutoff, float(basis.dx.sum()), material)
    return Body(
        points=x[:, first].T.copy(),
        omega=omega,
        shapes=modes[contact],
        residual=_residual(factor, contact, omega, modes),
        translation=modes.T @ (M @ unit),
        mass=float(unit[:, 0] @ (M @ unit[:, 0])),
    )


def _modes(K, M, factor, cutoff: float, area: float, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies up to `cutoff`, rad/s, and modes of unit mass."""
    speeds = material.dilatational_wave_speed, np.sqrt(material.lame_mu / material.density)
    expected = area * cutoff**2 / (4.0 * pi) * sum(speed**-2 for speed in speeds)  # Weyl's law
    count = round(1.1 * expected) + 20
    inverse = LinearOperator(K.shape, matvec=factor.solve)
    start = np.random.default_rng(0).standard_normal(K.shape[0])  # ARPACK's own would differ from call to call
    squares, modes = eigsh(K, count, M, sigma=-SHIFT, OPinv=inverse, v0=start)
    if squares.max() < cutoff**2:
        raise RuntimeError(f"{count} modes end below the cutoff")
    kept = squares < cutoff**2
    squares = np.where(squares < 1e-3 * SHIFT, 0.0, squares)  # rigid motions, but for round-off
    return np.sqrt(squares[kept]), modes[:, kept]


def _residual(factor, contact: np.ndarray, omega: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Displacement of contact nodes by forces on them, without what the modes have of it."""
    found = []
    for first in range(0, contact.size, AT_ONCE):
        some = contact[first : first + AT_ONCE]
        force = np.zeros((modes.shape[0], some.size))
        force[some, np.arange(some.size)] = 1.0
        found.append(factor.solve(force)[contact])
    shapes = modes[contact]
    whole = np.concatenate(found, axis=1) - (shapes / (omega**2 + SHIFT)) @ shapes.T
    return 0.5 * (whole + whole.T)


class Motion:
    """A body's modes in time, by the trapezoidal rule; `still`: at rest, with steps that find equilibrium."""

    def __init__(self, of: Body, step: float, still: bool = False):
        self.body, self.step, self.still = of, step, still
        inertia = 1.0 / step**2 if still else 4.0 / step**2
        self.answer = 1.0 / (inertia + of.omega**2)
        self.inertia = inertia
        self.compliance = of.residual + (of.shapes * self.answer) @ of.shapes.T
        n = of.omega.size
        self.q, self.v, self.a, self.load = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
        self.stored = 0.0  # J, beside the modes

    def expect(self) -> None:
        """Where the step would end if nothing touched."""
        self.drifted = self.q if self.still else self.q + self.step * self.v + 0.25 * self.step**2 * self.a
        self.expected = self.answer * (self.inertia * self.drifted + self.load)

    @property
    def expected_moves(self) -> np.ndarray:
        """Of contact nodes, (n_contact, 2), m."""
        return (self.body.shapes @ self.expected).reshape(-1, 2)

    def advance(self, force: np.ndarray) -> None:
        """Take the step with forces on the contact nodes, (2 n_contact,), N."""
        self.q = self.expected + self.answer * (force @ self.body.shapes)
        k = np.flatnonzero(force)
        self.stored = 0.5 * float(force[k] @ self.body.residual[np.ix_(k, k)] @ force[k])
        if not self.still:
            new = (self.q - self.drifted) * self.inertia
            self.v, self.a = self.v + 0.5 * self.step * (self.a + new), new

    def mean(self, q: np.ndarray) -> np.ndarray:
        """Motion of the centre of mass, (2,), m."""
        return q @ self.body.translation / self.body.mass

    @property
    def energy(self) -> tuple[float, float]:
        """Kinetic and elastic, J."""
        return 0.5 * float(self.v @ self.v), 0.5 * float(np.sum((self.body.omega * self.q) ** 2)) + self.stored


def separated(gap: np.ndarray, compliance: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Forces, (n,), N, >= 0, under which no gap, (n,), m, is negative; `active`: where to expect them."""
    for _ in range(MOST_TURNS):
        force = np.zeros(gap.size)
        k = np.flatnonzero(active)
        if k.size:
            force[k] = np.linalg.solve(compliance[np.ix_(k, k)], -gap[k])
        left = gap + compliance[:, k] @ force[k]
        changed = np.where(active, force > 0.0, left < 0.0)
        if np.array_equal(changed, active):
            return force
        active = changed
    lower = cholesky(compliance, lower=True)
    return nnls(lower.T, solve_triangular(lower, -gap, lower=True))[0]
