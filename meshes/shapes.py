"""gmsh makes the cross-sections: a disc of near-equilateral triangles, an annulus of equal sectors of quads."""

import itertools
import signal
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from meshes.graded import GradedAnnulus, GradedDisc, Row

TRIANGLE, QUADRILATERAL = 2, 3  # gmsh's element types
INITIAL_MESH_ONLY = 3  # gmsh's algorithm that adds no nodes to those of the boundary
# Thickness of a disc's outermost layer over the others': its nodes stand for half a layer only and would limit the step
RIM = 1.05


@dataclass(frozen=True, kw_only=True)
class Disc:
    """A disc of concentric rows of nodes, one layer of triangles apart; a row has six nodes fewer than the next.

    The surface has 6·layers nodes. With whole layers there is a node in the centre, six around it, and so on; with half
    of one there is a triangle in the centre, whose three nodes are the first row. All triangles are nearly equilateral,
    which gives the largest critical time step a mesh of that surface spacing can have.
    """

    radius: float  # m
    layers: float  # a multiple of ½

    surface_nodes = property(lambda self: round(6 * self.layers))

    @property
    def surface_spacing(self) -> float:
        """Arc between neighbouring surface nodes, m."""
        return 2.0 * pi * self.radius / self.surface_nodes

    @property
    def repeats(self) -> int:
        """How many times the mesh looks the same in one turn."""
        return 3 if self.surface_nodes % 6 else 6

    @property
    def rows(self) -> list[Row]:
        """Every concentric row, from the centre outwards."""
        counts = list(range(self.surface_nodes, 0, -6))[::-1]
        step = self.radius / (self.layers - 1.0 + RIM)
        radii = [step * count / 6 for count in counts[:-1]] + [self.radius]
        if self.repeats == 6:
            return [Row(0.0, 1), *map(Row, radii, counts)]
        # around a triangle a row lies across the gaps of the next
        last = len(counts) - 1
        return [Row(radii[k], counts[k], 0.5 * ((last - k) % 2)) for k in range(len(counts))]

    n_cells = property(lambda self: int(6 * self.layers**2))


@dataclass(frozen=True, kw_only=True)
class Annulus:
    """An annulus cut into equal sectors; node rows are concentric, the innermost first."""

    inner_radius: float  # m
    outer_radius: float  # m
    sectors: int
    layers: int  # radial element layers

    @property
    def radii(self) -> np.ndarray:
        """Radii of the rows of nodes, m, the innermost first."""
        return np.linspace(self.inner_radius, self.outer_radius, self.layers + 1)


Shape = Disc | GradedDisc | Annulus | GradedAnnulus


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A plane mesh. Points (n_points, 2), m; cells (n_cells, 3 or 4), counter-clockwise node indices."""

    points: np.ndarray
    cells: np.ndarray


def make(shape: Shape) -> Mesh:
    """Mesh a shape with gmsh; nodes ordered by radius, then by angle from 0.

    Errors: RuntimeError: gmsh can't be loaded or returned a mesh other than the shape asks for.
    """
    from scipy.spatial import cKDTree

    # a layer of the disc has the nodes of its two circles and no others between them
    is_round = isinstance(shape, Disc | GradedDisc)
    with gmsh_session(INITIAL_MESH_ONLY) as gmsh:
        (_draw_disc if is_round else _draw_annulus)(gmsh.model, shape)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(TRIANGLE if is_round else QUADRILATERAL)
    points, cells = used_points(tags, coordinates.reshape(-1, 3)[:, :2], nodes.reshape(-1, 3 if is_round else 4))
    wanted = expected_points(shape)
    distance, nearest = cKDTree(wanted).query(points)
    off = distance.max() > 1e-7 * np.abs(wanted).max()
    if off or len(points) != len(wanted) or np.unique(nearest).size != len(points):
        raise RuntimeError(
            f"gmsh returned {len(points)} nodes, up to {distance.max():.2e} m off, where {shape} has {len(wanted)}"
        )
    cells = counter_clockwise(wanted, nearest[cells])
    return Mesh(points=wanted, cells=cells[np.lexsort(cells.T[::-1])])


@contextmanager
def gmsh_session(algorithm: int):
    """A silent gmsh with an empty model, for as long as the context lasts; `algorithm` of its meshes in the plane.

    Errors: RuntimeError: gmsh can't be loaded.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise RuntimeError(
            f"gmsh can't be loaded ({error}); install its system libraries: apt-get install --no-install-recommends "
            "libgl1 libglu1-mesa libxft2 libxcursor1 libxinerama1 libgomp1"
        ) from None
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    # SIGINT and SIGTERM go back to those who listen: gmsh takes them for the system's defaults as it starts
    for number in (signal.SIGINT, signal.SIGTERM) if threading.current_thread() is threading.main_thread() else ():
        if (listener := signal.getsignal(number)) is not None:
            signal.signal(number, listener)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Algorithm", algorithm)
        yield gmsh
    finally:
        gmsh.finalize()


def _circle(model, centre, row, parts):
    """A circle of equally spaced nodes as `parts` arcs; returns the arcs and their start points."""
    angles = [2.0 * pi * (part / parts + row.shift / row.nodes) for part in range(parts)]
    points = [model.geo.addPoint(row.radius * cos(a), row.radius * sin(a), 0.0) for a in angles]
    arcs = [model.geo.addCircleArc(points[i], centre, points[(i + 1) % parts]) for i in range(parts)]
    for arc in arcs:
        model.geo.mesh.setTransfiniteCurve(arc, row.nodes // parts + 1)
    return arcs, points


def _draw_disc(model, disc):
    """Concentric circles of nodes; the annuli between them are triangulated without further nodes."""
    centre = model.geo.addPoint(0.0, 0.0, 0.0)
    rows = [row for row in disc.rows if row.nodes > 1]
    arcs, points = _circle(model, centre, rows[0], disc.repeats)
    if rows[0].nodes == 3:
        model.geo.addPlaneSurface([model.geo.addCurveLoop(arcs)])
    else:
        spokes = [model.geo.addLine(centre, point) for point in points]
        for i, arc in enumerate(arcs):
            side = model.geo.addCurveLoop([spokes[i], arc, -spokes[(i + 1) % len(spokes)]])
            model.geo.addPlaneSurface([side])
        for spoke in spokes:
            model.geo.mesh.setTransfiniteCurve(spoke, 2)
    inner_loop = model.geo.addCurveLoop(arcs)
    for row in rows[1:]:
        arcs, _ = _circle(model, centre, row, disc.repeats)
        loop = model.geo.addCurveLoop(arcs)
        model.geo.addPlaneSurface([loop, inner_loop])
        inner_loop = loop
    model.geo.synchronize()


def _draw_annulus(model, ring):
    """Four quadrants of one layer of quads between each row of nodes and the next."""
    centre = model.geo.addPoint(0.0, 0.0, 0.0)
    circles = [_circle(model, centre, Row(radius, ring.sectors), 4) for radius in ring.radii]
    for (inside, start), (outside, end) in itertools.pairwise(circles):
        spokes = [model.geo.addLine(start[i], end[i]) for i in range(4)]
        for i, spoke in enumerate(spokes):
            model.geo.mesh.setTransfiniteCurve(spoke, 2)
            loop = model.geo.addCurveLoop([spoke, outside[i], -spokes[(i + 1) % 4], -inside[i]])
            surface = model.geo.addPlaneSurface([loop])
            model.geo.mesh.setTransfiniteSurface(surface)
            model.geo.mesh.setRecombine(2, surface)
    model.geo.synchronize()


def expected_points(shape: Shape) -> np.ndarray:
    """Where the nodes of a shape belong, (n_points, 2), m: by radius, then by angle from 0."""
    is_round = isinstance(shape, Disc | GradedDisc)
    rows = shape.rows if is_round else [Row(radius, shape.sectors) for radius in shape.radii]
    radius = np.concatenate([np.full(row.nodes, row.radius) for row in rows])
    angle = np.concatenate([2.0 * pi * (np.arange(row.nodes) + row.shift) / row.nodes for row in rows])
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def used_points(tags, points, cells) -> tuple[np.ndarray, np.ndarray]:
    """gmsh's nodes and cells without the nodes no cell uses (arc centres); cells by index in place of tag."""
    index = np.full(int(tags.max()) + 1, -1)
    index[tags] = np.arange(tags.size)
    used, cells = np.unique(index[cells.astype(np.int64)], return_inverse=True)
    return points[used], cells


def counter_clockwise(points, cells):
    """Cells counter-clockwise, starting at their smallest node: the same mesh gives the same array."""
    first, second, third = (points[cells[:, k]] for k in range(3))
    (ax, ay), (bx, by) = (second - first).T, (third - first).T
    cells = np.where((ax * by - ay * bx < 0.0)[:, None], cells[:, ::-1], cells)
    start = np.argmin(cells, axis=1)
    return cells[np.arange(len(cells))[:, None], (np.arange(cells.shape[1]) + start[:, None]) % cells.shape[1]]
