"""Meshes of a disc and of a ring for every kind of element, by the spacing of the surface nodes.

Nodes on the surface are equally spaced from the angle 0, middles of edges among them. `order` is the number of node
spacings along the edge of an element: 1, or 2 where edges have a middle node. Edges on the circles of a mesh are
curved where the element can be.
"""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import MeshQuad, MeshQuad2, MeshTri, MeshTri2

from meshes import Annulus, Disc, mesh_of
from meshes.refined import FRONTAL_DELAUNAY
from meshes.shapes import QUADRILATERAL, TRIANGLE, counter_clockwise, gmsh_session, used_points

SAME = 1e-9  # of a radius
BLOSSOM = 1  # gmsh's way of joining triangles that leaves none
MAPPED_UP_TO = 32  # corners on the surface
SECTOR_MULTIPLE = 8  # of the surface nodes of a ring, as the solver has them


def disc_layers(radius: float, spacing: float, order: int):
    """The solver's triangles: concentric layers, six corners more in each than in the one inside it."""
    disc = Disc(radius=radius, layers=max(1, round(2.0 * pi * radius / (6.0 * order * spacing))))
    mesh = mesh_of(disc)
    return _grid(mesh.points, mesh.cells, order, (radius,))


def disc_frontal(radius: float, spacing: float, order: int):
    """gmsh's Frontal-Delaunay triangles inside equally spaced surface nodes."""
    points, cells = _filled(radius, 4 * max(2, round(2.0 * pi * radius / (4.0 * order * spacing))), TRIANGLE)
    return _grid(points, cells, order, (radius,))


def disc_quads(radius: float, spacing: float, order: int):
    """Quadrilaterals inside equally spaced surface nodes: coarse ones mapped, fine ones joined triangles (Blossom).

    Each where it gives the larger cells; gmsh's coarse ones also have corners of 180° on the circle.
    """
    corners = 4 * max(1, round(2.0 * pi * radius / (4.0 * order * spacing)))
    if corners <= MAPPED_UP_TO:
        points, cells = _mapped(radius, corners // 4)
    else:
        points, cells = _filled(radius, corners, QUADRILATERAL)
    return _grid(points, counter_clockwise(points, cells), order, (radius,))


def _mapped(radius: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """A square of n x n cells in a layer of 4n; every inner node is at the mean of its neighbours."""
    square = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    rim = np.concatenate([square[:-1, n], square[n, :0:-1], square[:0:-1, 0], square[0, :-1]])  # from the lower right
    surface = square.size + np.arange(4 * n)
    layer = np.stack([rim, surface], axis=1)
    cells = np.concatenate([_lattice(square), _lattice(np.concatenate([layer, layer[:1]]))])
    points = np.zeros((square.size + 4 * n, 2))
    angle = 2.0 * pi * (np.arange(4 * n) - 0.5 * n) / (4 * n)
    points[surface] = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    first, second = MeshQuad(points.T.copy(), cells.T.copy()).facets
    joined = sparse.coo_array((np.ones(first.size), (first, second)), (len(points), len(points))).tocsr()
    joined = joined + joined.T
    laplacian = sparse.diags_array(joined.sum(axis=1)) - joined
    inner = square.ravel()
    points[inner] = splu(laplacian[inner][:, inner].tocsc()).solve(joined[inner] @ points)
    return points, cells


def _lattice(nodes: np.ndarray) -> np.ndarray:
    """Quadrilaterals between the nodes of a lattice."""
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=-1).reshape(-1, 4)


def _filled(radius: float, surface_nodes: int, kind: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2), m, and cells of a disc with so many corners on its surface."""
    size = 2.0 * radius * sin(pi / surface_nodes)
    with gmsh_session(FRONTAL_DELAUNAY) as gmsh:
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", BLOSSOM)
        centre = gmsh.model.geo.addPoint(0.0, 0.0, 0.0)
        angles = [0.5 * pi * quarter for quarter in range(4)]
        ends = [gmsh.model.geo.addPoint(radius * cos(a), radius * sin(a), 0.0, size) for a in angles]
        arcs = [gmsh.model.geo.addCircleArc(ends[i - 1], centre, ends[i]) for i in range(4)]
        for arc in arcs:
            gmsh.model.geo.mesh.setTransfiniteCurve(arc, surface_nodes // 4 + 1)
        surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(arcs)])
        if kind == QUADRILATERAL:
            gmsh.model.geo.mesh.setRecombine(2, surface)
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(2)
        if kind == QUADRILATERAL and gmsh.model.mesh.getElementsByType(TRIANGLE)[1].size:
            raise RuntimeError(f"gmsh left triangles between quadrilaterals in a disc of {surface_nodes} surface nodes")
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(kind)
    corners = 3 if kind == TRIANGLE else 4
    points, cells = used_points(tags, coordinates.reshape(-1, 3)[:, :2], nodes.reshape(-1, corners))
    return points, counter_clockwise(points, cells)


def ring_quads(inner: float, outer: float, raceway: float, spacing: float, order: int):
    """The solver's quadrilaterals: equal sectors, equally thick layers."""
    sectors, layers = _ring_counts(inner, outer, raceway, spacing, order, 1.0)
    mesh = mesh_of(Annulus(inner_radius=inner, outer_radius=outer, sectors=sectors, layers=layers))
    return _grid(mesh.points, mesh.cells, order, np.linspace(inner, outer, layers + 1))


def ring_triangles(inner: float, outer: float, raceway: float, spacing: float, order: int):
    """Near-equilateral triangles: every other row of nodes is turned by half a sector, layers are √3/2 spacings thick.

    All sectors are equal here as well.
    """
    sectors, layers = _ring_counts(inner, outer, raceway, spacing, order, 0.5 * np.sqrt(3.0))
    radii = np.linspace(inner, outer, layers + 1)
    # the row on the raceway is not turned, so that its nodes are where the quadrilaterals' are
    turned = (np.arange(layers + 1) - (0 if raceway == inner else layers)) % 2
    angle = 2.0 * pi * (np.arange(sectors) + 0.5 * turned[:, None]) / sectors
    points = (radii[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)).reshape(-1, 2)
    here = np.arange(sectors)
    ahead = (here + 1) % sectors
    cells = []
    for row in range(layers):
        low, high = row * sectors, (row + 1) * sectors
        if turned[row]:  # the node above k lies behind the node k
            cells += [(low + here, high + ahead, high + here), (low + here, low + ahead, high + ahead)]
        else:
            cells += [(low + here, low + ahead, high + here), (low + ahead, high + ahead, high + here)]
    cells = np.concatenate([np.column_stack(some) for some in cells])
    return _grid(points, counter_clockwise(points, cells), order, radii)


def _ring_counts(inner, outer, raceway, spacing, order, slenderness) -> tuple[int, int]:
    """Sectors and layers of elements."""
    multiple = SECTOR_MULTIPLE // order
    sectors = multiple * max(4, round(2.0 * pi * raceway / (multiple * order * spacing)))
    return sectors, max(2 // order, round((outer - inner) / (slenderness * order * spacing)))


def _grid(points, cells, order, circles):
    """scikit-fem's mesh; of order 2 with the edges along the circles curved."""
    p, t = np.ascontiguousarray(points.T), np.ascontiguousarray(cells.T)
    straight = MeshTri(p, t) if len(t) == 3 else MeshQuad(p, t)
    if order == 1:
        return straight
    curved = (MeshTri2 if len(t) == 3 else MeshQuad2).from_mesh(straight)
    ends = np.hypot(*straight.p[:, straight.facets])
    middles = curved.dofs.facet_dofs[0]
    places = curved.doflocs.copy()
    for circle in circles:
        on = middles[np.all(np.abs(ends - circle) < SAME * circle, axis=0)]
        places[:, on] *= circle / np.hypot(*places[:, on])
    if len(t) == 4:  # the middle follows the edges, as a serendipity element maps it
        corners, edges = curved.dofs.nodal_dofs[0, straight.t], middles[straight.t2f]
        places[:, curved.dofs.interior_dofs[0]] = 0.5 * places[:, edges].sum(axis=1) - 0.25 * places[:, corners].sum(
            axis=1
        )
    return replace(curved, doflocs=places)
