"""Bodies as the time loop wants them, a disc in rows of 2 x 2 blocks, a ring as one sector's stencil; their stress.

A stress is (..., 3): xx, yy, xy, Pa; zz = ν (xx + yy). Bodies declared rigid are the limit E → ∞ of elastic ones: they
keep shape, mass and, for what is drawn and stored, the mesh; all that is asked of their elasticity is 0.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from fem.elastic.cache import kept
from fem.elastic.continuum import Section
from lagrange import Material
from meshes import Annulus, Disc, GradedAnnulus, GradedDisc, Mesh, mesh_of

TRIANGLE = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]), 0.5
QUADRILATERAL = 0.25 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 4.0  # bilinear, at the centre


def stress_operator(points: np.ndarray, cells: np.ndarray, material: Material) -> sparse.csr_matrix:
    """Matrix from nodal displacements to nodal stresses in plane strain: the elements' ones, averaged by area.

    points : (n_nodes, 2), m; cells : (n_cells, 3 or 4)

    Returns: csr_matrix, (3 n_nodes, 2 n_nodes), Pa/m, of vectors with the node as slow index; 0 where it is rigid

    Errors: exact for a uniform strain. One stress per element, at its centre: on a surface it lags half an element
    behind.
    """
    n_nodes, corners = len(points), cells.shape[1]
    if material.rigid:
        return sparse.csr_matrix((3 * n_nodes, 2 * n_nodes))
    shape, size = TRIANGLE if corners == 3 else QUADRILATERAL
    jacobian = np.einsum("kci,kj->cij", np.moveaxis(points[cells], 1, 0), shape)
    gradient = np.einsum("kj,cji->cki", shape, np.linalg.inv(jacobian))
    lame_lambda, lame_mu = material.lame_lambda, material.lame_mu
    gx, gy = gradient[..., 0], gradient[..., 1]  # (cell, corner)
    stiff = lame_lambda + 2.0 * lame_mu
    of_x, of_y = (stiff * gx, lame_lambda * gx, lame_mu * gy), (lame_lambda * gy, stiff * gy, lame_mu * gx)
    per_cell = np.moveaxis(np.array([of_x, of_y]), (0, 1), (3, 1))  # (cell, stress, corner, component)
    area = size * np.linalg.det(jacobian)
    total = np.bincount(cells.ravel(), np.repeat(area, corners), n_nodes)
    share = area[:, None] / total[cells]  # (cell, node averaged to)
    values = share[:, :, None, None, None] * per_cell[:, None]
    rows = 3 * cells[:, :, None, None, None] + np.arange(3)[:, None, None]
    columns = 2 * cells[:, None, None, :, None] + np.arange(2)
    rows, columns = (each.ravel() for each in np.broadcast_arrays(rows, columns))
    return sparse.csr_matrix((values.ravel(), (rows, columns)), shape=(3 * n_nodes, 2 * n_nodes))


def turned(stress: np.ndarray, angle) -> np.ndarray:
    """The same stress in axes from which the given ones are turned by `angle`, rad, counter-clockwise."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    mean, turning = 0.5 * (xx + yy), (0.5 * (xx - yy) + 1j * xy) * np.exp(2j * np.asarray(angle))
    return np.stack([mean + turning.real, mean - turning.real, turning.imag], axis=-1)


def von_mises(stress: np.ndarray, poisson_ratio) -> np.ndarray:
    """Von Mises stress in plane strain, Pa."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    zz = poisson_ratio * (xx + yy)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2)


def max_shear(stress: np.ndarray) -> np.ndarray:
    """Largest shear stress in the plane, half the difference of its principal stresses, Pa."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    return np.hypot(0.5 * (xx - yy), xy)


RESPONSES = 32  # of a disc's surface to unit forces, solved at once


@dataclass(frozen=True, kw_only=True)
class DiscBody:
    """An elastic roller, free in the plane; all rollers of a bearing share it.

    The surface nodes are the last ones, equally spaced from angle 0.
    """

    shape: Disc | GradedDisc
    material: Material
    points: np.ndarray  # (n_nodes, 2), m
    cells: np.ndarray
    mass: np.ndarray  # (n_nodes,), kg
    stiffness: sparse.csr_matrix  # (2 n_nodes, 2 n_nodes), N/m

    n_nodes = property(lambda self: len(self.mass))
    section = property(lambda self: Section(self.shape.radius, 0.0, self.material))  # The circle itself, without a mesh
    n_surface = property(lambda self: self.shape.surface_nodes)
    surface_spacing = property(lambda self: self.shape.surface_spacing)
    first_surface_node = property(lambda self: self.n_nodes - self.n_surface)
    total_mass = property(lambda self: float(self.mass.sum()))
    polar_inertia = property(lambda self: float(self.mass @ np.sum(self.points**2, axis=1)))  # Σ m |X|², kg m²

    def blocks(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness in 2 x 2 blocks: row starts (n_nodes + 1,), column nodes (n_blocks,), blocks (n_blocks, 2, 2)."""
        rows = self.stiffness.tobsr((2, 2))
        rows.sort_indices()
        return rows.indptr.astype(np.int64), rows.indices.astype(np.int64), rows.data

    @cached_property
    def _factor(self):
        from scipy.sparse.linalg import splu  # takes its time to load, and the reduced model needs no meshes

        # rigid motions are held by three Lagrange multipliers: no mean displacement, no mean rotation
        constraint = sparse.csc_matrix(rigid_modes(self.points) * np.repeat(self.mass, 2)[:, None])
        return splu(sparse.bmat([[self.stiffness, constraint], [constraint.T, None]], format="csc"))

    @cached_property
    def stress(self) -> sparse.csr_matrix:
        """From nodal displacements to nodal stresses: `fem.elastic.bodies.stress_operator`."""
        return stress_operator(self.points, self.cells, self.material)

    def relaxed(self, force: np.ndarray) -> np.ndarray:
        """Displacement, (2 n_nodes, ...), m, of the freely accelerating disc under nodal forces, N (inertia relief).

        Mass-weighted mean displacement and rotation are zero; the resultant is carried by uniform and rotational
        inertia.
        """
        if self.material.rigid:
            return np.zeros_like(force)
        modes, mass = rigid_modes(self.points), np.repeat(self.mass, 2)
        weighted = modes * mass[:, None]
        acceleration = np.linalg.solve(modes.T @ weighted, modes.T @ force)
        balanced = force - weighted @ acceleration
        zeros = np.zeros((3, *force.shape[1:]))
        return self._factor.solve(np.concatenate([balanced, zeros]))[: force.shape[0]]

    _responses = cached_property(lambda self: {})  # motion of all surface nodes by unit forces, by blocks of these, m/N

    def surface_places(self, nodes: np.ndarray) -> np.ndarray:
        """Places of both components of surface nodes, (2 m,), in a vector of all nodes'."""
        return (2 * (self.first_surface_node + np.asarray(nodes))[:, None] + np.arange(2)).ravel()

    def surface_influence(self, nodes: np.ndarray) -> np.ndarray:
        """Compliance between surface nodes, (2 m, 2 m), m/N, of the freely accelerating disc; x and y of each node."""
        first = 2 * self.first_surface_node
        dofs = self.surface_places(nodes) - first
        blocks, found, known = dofs // RESPONSES, np.empty((len(dofs), len(dofs))), self._responses
        for block in np.unique(blocks).tolist():
            if block not in known:  # solved by the block, and therefore the same bits whatever was asked for before
                pushed = np.arange(block * RESPONSES, min((block + 1) * RESPONSES, 2 * self.n_surface))
                force = np.zeros((2 * self.n_nodes, len(pushed)))
                force[first + pushed, np.arange(len(pushed))] = 1.0
                known[block] = self.relaxed(force)[first:].T.copy()
            mine = np.flatnonzero(blocks == block)
            found[mine] = known[block][np.ix_(dofs[mine] - block * RESPONSES, dofs)]
        return found


def rigid_modes(points: np.ndarray) -> np.ndarray:
    """Two translations and the rotation about the origin, (2n, 3)."""
    modes = np.zeros((len(points), 2, 3))
    modes[:, 0, 0] = modes[:, 1, 1] = 1.0
    modes[:, 0, 2], modes[:, 1, 2] = -points[:, 1], points[:, 0]
    return modes.reshape(-1, 3)


def disc_body(shape: Disc | GradedDisc, material: Material, thickness: float) -> DiscBody:
    """Assemble a roller of the circle's mass; that of a `Disc` also has the circle's polar moment of inertia.

    The mass the polygon lacks is spread over all nodes.

    Errors: Polar inertia of a `GradedDisc`: at most 1e-3 too large on meshes finer than a fiftieth of the radius.
    """
    mesh, stiffness, mass = _assembled(shape, material, thickness, shape.radius**2)
    if isinstance(shape, Disc):
        mass = _end_corrected(mass, mesh.points, shape)
    return DiscBody(
        shape=shape, material=material, points=mesh.points, cells=mesh.cells, mass=mass, stiffness=stiffness
    )


def _assembled(shape, material, thickness, square):
    """Mesh, stiffness, and masses of nodes that are the circles' together; `square` : their area over π, m²."""
    mesh = mesh_of(shape)

    def make():
        stiffness, mass = assemble(mesh, material, thickness)
        return {"data": stiffness.data, "indices": stiffness.indices, "indptr": stiffness.indptr, "mass": mass}

    found = kept("matrices", repr((shape, material, thickness)), make)
    size = 2 * len(mesh.points)
    stiffness = sparse.csr_matrix((found["data"], found["indices"], found["indptr"]), shape=(size, size))
    full = material.density * thickness * np.pi * square
    return mesh, stiffness, found["mass"] * (full / found["mass"].sum())


class Assembled(NamedTuple):
    """Matrices of one body; degree of freedom 2·i + k is component k of node i."""

    stiffness: sparse.csr_matrix  # (2n, 2n), N/m
    mass: np.ndarray  # (n,), kg, row sums of the consistent mass matrix


def assemble(mesh: Mesh, material: Material, thickness: float) -> Assembled:
    """Stiffness and lumped mass of a plane mesh.

    Triangles are linear, quadrilaterals bilinear with 2 x 2 Gauss points. The thickness, m, enters here once:
    masses are kg and forces N everywhere after.

    Source: scikit-fem's linear elasticity with the three-dimensional Lamé constants, which is plane strain.
    """
    import skfem  # takes its time to load
    from skfem.models.elasticity import linear_elasticity

    points, cells = np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cells.T)
    if mesh.cells.shape[1] == 3:
        grid, scalar, order = skfem.MeshTri(points, cells), skfem.ElementTriP1(), 2
    else:
        grid, scalar, order = skfem.MeshQuad(points, cells), skfem.ElementQuad1(), 3
    vectors = skfem.Basis(grid, skfem.ElementVector(scalar), intorder=order)
    stiffness = thickness * linear_elasticity(material.lame_lambda, material.lame_mu).assemble(vectors).tocsr()
    mass = skfem.BilinearForm(lambda u, v, _: u * v).assemble(skfem.Basis(grid, scalar, intorder=order))
    by_node = vectors.nodal_dofs.T.ravel()
    lumped = material.density * thickness * np.asarray(mass.sum(axis=1)).ravel()
    return Assembled(stiffness[by_node][:, by_node], lumped)


def _end_corrected(mass, points, disc):
    """Masses with an eighth, about, of the surface nodes' on the next row, which makes the polar inertia ½ m R².

    Row sums integrate like the trapezoidal rule, exactly but for its end: surface nodes stand for mass that lies
    inside of them. Taken back where it arises it also halves the error of the disc's modes; spread over all nodes it
    would not.

    Source: after Gregory's end correction of the trapezoidal rule, weights 1/2, 1, … → 5/12, 13/12, …
    """
    surface, below = disc.rows[-1], disc.rows[-2]
    edge = len(mass) - surface.nodes
    on_surface, on_below = slice(edge, None), slice(edge - below.nodes, edge)
    excess = mass @ np.sum(points**2, axis=1) - 0.5 * mass.sum() * disc.radius**2
    moved, found = excess / (surface.radius**2 - below.radius**2), mass.copy()
    found[on_surface] *= 1.0 - moved / mass[on_surface].sum()
    found[on_below] *= 1.0 + moved / mass[on_below].sum()
    return found


@dataclass(frozen=True, kw_only=True)
class RingBody:
    """An elastic ring of equal sectors, held on one circle and loaded on the other.

    In polar components (u_r, u_θ) the stiffness of every sector is the same, so one row of coefficients per node row
    is the whole matrix: force on (row i, sector k) = −Σ stencil[i, i'−i+1, d+1] · u(i', k+d), i' = i−1..i+1, d = −1..1.
    """

    shape: Annulus | GradedAnnulus
    material: Material
    points: np.ndarray
    cells: np.ndarray
    radii: np.ndarray  # (n_rows,), m
    row_mass: np.ndarray  # (n_rows,), kg, of one node
    stencil: np.ndarray  # (n_rows, 3, 3, 2, 2), N/m
    held_row: int  # 0 (inner ring) or n_rows − 1 (outer ring)

    warnings = property(lambda self: ())  # Sentences where the mesh holds the ring otherwise than the scene asks for
    n_rows = property(lambda self: len(self.radii))
    n_sectors = property(lambda self: self.shape.sectors)
    raceway_row = property(lambda self: self.n_rows - 1 - self.held_row)
    raceway_radius = property(lambda self: float(self.radii[self.raceway_row]))
    n_surface = n_sectors
    surface_spacing = property(lambda self: 2.0 * np.pi * self.raceway_radius / self.n_sectors)

    @property
    def section(self) -> Section:
        """The ring itself, without a mesh."""
        return Section(self.raceway_radius, float(self.radii[self.held_row]), self.material)

    free_rows = property(lambda self: np.delete(np.arange(self.n_rows), self.held_row))

    @property
    def free_places(self) -> np.ndarray:
        """Places of the free components among the rows of `matrix`."""
        return (2 * self.n_sectors * self.free_rows[:, None] + np.arange(2 * self.n_sectors)).ravel()

    polar_inertia = property(lambda self: 0.5 * self.total_mass * float(self.radii[0] ** 2 + self.radii[-1] ** 2))
    n_free_nodes = property(lambda self: self.free_places.size // 2)
    total_mass = property(lambda self: float(self.n_sectors * self.row_mass.sum()))
    angles = property(lambda self: 2.0 * np.pi * np.arange(self.n_sectors) / self.n_sectors)

    @cached_property
    def stress(self) -> sparse.csr_matrix:
        """From nodal displacements in the ring's axes to nodal stresses: `fem.elastic.bodies.stress_operator`."""
        return stress_operator(self.points, self.cells, self.material)

    def cartesian(self, polar: np.ndarray, turn: float = 0.0) -> np.ndarray:
        """Vectors (n_rows, 2, n_sectors) in polar components as (n_nodes, 2) in x and y, the ring turned by `turn`."""
        found = (polar[:, 0] + 1j * polar[:, 1]) * np.exp(1j * (self.angles + turn))
        return np.stack([found.real, found.imag], axis=-1).reshape(-1, 2)

    def polar(self, vectors: np.ndarray, turn: float = 0.0) -> np.ndarray:
        """The inverse of `cartesian`."""
        found = (vectors.reshape(self.n_rows, -1, 2) @ [1.0, 1j]) * np.exp(-1j * (self.angles + turn))
        return np.stack([found.real, found.imag], axis=1)

    def body_load(self, gravity: float, turn: float = 0.0, speed: float = 0.0) -> np.ndarray:
        """Weight and centrifugal force of every node, (n_rows, 2, n_sectors), polar, N, in a frame turned by `turn`."""
        angle = self.angles + turn
        load = -gravity * self.row_mass[:, None, None] * np.stack([np.sin(angle), np.cos(angle)])
        load[:, 0] += (speed**2 * self.row_mass * self.radii)[:, None]
        return load

    def force(self, displacement: np.ndarray) -> np.ndarray:
        """K·u, N; both (n_rows, 2, n_sectors), polar."""
        return (self.matrix @ displacement.ravel()).reshape(displacement.shape)

    @cached_property
    def matrix(self) -> sparse.csc_matrix:
        """Stiffness of the ring held nowhere, N/m; rows (node row, component, sector), polar."""
        n = self.n_sectors
        circulants = [sparse.eye_array(n).tocsr()[(np.arange(n) + shift) % n] for shift in (-1, 0, 1)]
        blocks = [sparse.kron(np.moveaxis(self._blocks[d], 1, 2).reshape(2 * self.n_rows, -1), circulants[d])
                  for d in range(3)]  # fmt: skip
        return sparse.csc_matrix(sum(blocks))

    @cached_property
    def _blocks(self):
        """By shift of the sector, what couples rows: (3, n_rows, n_rows, 2, 2), N/m."""
        found = np.zeros((3, self.n_rows, self.n_rows, 2, 2))
        for row in range(self.n_rows):
            for other in range(max(0, row - 1), min(self.n_rows, row + 2)):
                found[:, row, other] = self.stencil[row, other - row + 1]
        return found

    def harmonic_stiffness(self, harmonics: np.ndarray) -> np.ndarray:
        """Stiffness acting on u(i, k) = û(i) exp(2πi·m·k/n_sectors), (n_harmonics, 2 n_rows, 2 n_rows), complex."""
        phase = np.exp(2j * np.pi * np.outer(harmonics, [-1, 0, 1]) / self.n_sectors)
        matrix = np.einsum("md,dijab->miajb", phase, self._blocks)
        return matrix.reshape(len(harmonics), 2 * self.n_rows, 2 * self.n_rows)

    @cached_property
    def _harmonic_compliance(self):
        keep = (2 * self.free_rows[:, None] + np.arange(2)).ravel()
        return np.linalg.inv(self.harmonic_stiffness(np.arange(self.n_sectors // 2 + 1))[:, keep][:, :, keep])

    def held(self, force: np.ndarray) -> np.ndarray:
        """Displacement of the held ring under nodal forces; both (n_rows, 2, n_sectors, ...), polar, m and N."""
        if self.material.rigid:
            return np.zeros_like(force)
        rows = self.free_rows
        spectrum = np.fft.rfft(force[rows], axis=2)  # (rows, 2, harmonic, ...)
        stacked = np.moveaxis(spectrum, 2, 0).reshape(spectrum.shape[2], 2 * len(rows), -1)
        solved = (self._harmonic_compliance @ stacked).reshape(spectrum.shape[2], len(rows), 2, *force.shape[3:])
        displacement = np.zeros_like(force)
        displacement[rows] = np.fft.irfft(np.moveaxis(solved, 0, 2), n=self.n_sectors, axis=2)
        return displacement

    def sag(self, gravity: float) -> np.ndarray:
        """Displacement of a ring that does not turn, by its weight and by how it is held, (n_rows, 2, n_sectors), m."""
        return self.held(self.body_load(gravity))

    def rested(self, force: np.ndarray) -> np.ndarray:
        """Displacement under all nodal forces that act on the ring; both (n_rows, 2, n_sectors), polar, m and N."""
        return self.held(force)

    @cached_property
    def _raceway_kernel(self):
        """Motion of every raceway node by a unit force on node 0, (component moved, component pushed, n_sectors)."""
        force = np.zeros((self.n_rows, 2, self.n_sectors, 2))
        force[self.raceway_row, 0, 0, 0] = force[self.raceway_row, 1, 0, 1] = 1.0
        return np.moveaxis(self.held(force)[self.raceway_row], 1, 2)

    def surface_places(self, nodes: np.ndarray) -> np.ndarray:
        """As `DiscBody.surface_places`, of raceway nodes among the rows of `matrix`."""
        first = 2 * self.n_sectors * self.raceway_row + np.asarray(nodes)
        return (first[:, None] + self.n_sectors * np.arange(2)).ravel()

    def surface_influence(self, nodes: np.ndarray) -> np.ndarray:
        """Compliance between raceway nodes, (2 m, 2 m), m/N; polar components of each node."""
        nodes = np.asarray(nodes)
        apart = (nodes[:, None] - nodes[None, :]) % self.n_sectors
        found = self._raceway_kernel[:, :, apart]  # (component moved, component pushed, node moved, node pushed)
        return found.transpose(2, 0, 3, 1).reshape(2 * nodes.size, 2 * nodes.size)


def ring_body(shape: Annulus | GradedAnnulus, material: Material, thickness: float, held_inside: bool) -> RingBody:
    """Assemble a ring and reduce it to one sector.

    Errors: RuntimeError: the mesh's sectors are not equal to 1e-9.
    """
    square = shape.outer_radius**2 - shape.inner_radius**2
    mesh, stiffness, lumped = _assembled(shape, material, thickness, square)
    rows, sectors = shape.layers + 1, shape.sectors
    stencil = _sector_stencil(stiffness, rows, sectors, 0)
    elsewhere = _sector_stencil(stiffness, rows, sectors, sectors // 3)
    mass = lumped.reshape(rows, sectors)
    spread = np.abs(stencil - elsewhere).max() / np.abs(stencil).max()
    if spread > 1e-9 or np.ptp(mass, axis=1).max() > 1e-9 * mass.max():
        raise RuntimeError(f"the sectors of {shape} differ by {spread:.1e}: the mesh is not rotation-invariant")
    mirrored = stencil[:, :, ::-1] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return RingBody(
        shape=shape, material=material, points=mesh.points, cells=mesh.cells, radii=shape.radii,
        row_mass=mass.mean(axis=1), stencil=0.5 * (stencil + mirrored), held_row=0 if held_inside else rows - 1,
    )  # fmt: skip


def _sector_stencil(stiffness, rows, sectors, sector):
    """Coefficients of one sector's nodes in polar components, (rows, 3, 3, 2, 2)."""
    angle = 2.0 * np.pi * (sector + np.arange(-1, 2)) / sectors
    c, s = np.cos(angle), np.sin(angle)
    polar, stencil = np.moveaxis(np.array([[c, -s], [s, c]]), 2, 0), np.zeros((rows, 3, 3, 2, 2))
    for row in range(rows):
        node = row * sectors + sector
        line = stiffness[2 * node : 2 * node + 2].toarray().reshape(2, rows, sectors, 2)
        for other in range(max(0, row - 1), min(rows, row + 2)):
            near = line[:, other, (sector + np.arange(-1, 2)) % sectors]  # (component, shift, component)
            stencil[row, other - row + 1] = np.einsum("ba,bsc,scd->sad", polar[1], near, polar)
    return stencil


def rigid_body(body: DiscBody | RingBody) -> DiscBody | RingBody:
    """The rigid body of an elastic one's shape and mass: a ring moves as its held circle does."""
    ring = isinstance(body, RingBody)
    none = {"stencil": 0.0 * body.stencil} if ring else {"stiffness": sparse.csr_matrix(body.stiffness.shape)}
    return replace(body, material=replace(body.material, rigid=True), **none)
