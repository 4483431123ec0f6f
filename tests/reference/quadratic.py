"""Bearings at rest by quadratic triangles: an independent solution."""

import itertools
from dataclasses import replace
from functools import cached_property, lru_cache
from math import asin, cos, pi, sin
from typing import NamedTuple

import gmsh
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri, MeshTri2
from skfem.helpers import dot
from skfem.models.elasticity import linear_elasticity

from fem.contacts.contact_law import NoLaw
from fem.elastic.continuum import ring_sections
from fem.statics.contact_balance import Condensed, Loads, NotFound, balance, closed_forces, first_guess, geometry
from lagrange import Bearing, Material
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from meshes.shapes import TRIANGLE, Mesh, counter_clockwise, gmsh_session, used_points

# ---- Triangles of a section that gmsh has been told, and their plane-strain stiffness: for yardsticks with own
# meshes.


def mesh_of_section() -> MeshTri:
    """Mesh what gmsh holds; nodes that no triangle has are left out."""
    gmsh.model.mesh.generate(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    used, cells = np.unique(gmsh.model.mesh.getElementsByType(2)[1], return_inverse=True)
    order = np.argsort(tags)
    points = coordinates.reshape(-1, 3)[order[np.searchsorted(tags[order], used)], :2]
    return MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.reshape(-1, 3).T))


def plane_strain_stiffness(basis: Basis, material: Material):
    """Stiffness of a section one metre long, N/m, sparse, (basis.N, basis.N)."""
    return linear_elasticity(material.lame_lambda, material.lame_mu).assemble(basis).tocsr()


# ---- Triangles whose boundary is given point by point: fine where bodies touch, coarse far from there.

GROWTH = 0.15  # of a boundary piece's length, per length away from what is fine


def graded_circle(radius: float, zones: list[tuple[float, float, float]], coarse: float) -> np.ndarray:
    """Angles around a circle from −π on, (n,), rad: `zones` of (first, last angle, spacing in m), `coarse` elsewhere.

    Zones are in order and apart from each other and from ±π.
    """
    found, before = [], zones[-1]
    end = zones[-1][1] - 2.0 * np.pi
    for first, last, fine in zones:
        found.append(_between(end, first, before[2] / radius, fine / radius, coarse / radius))
        found.append(np.linspace(first, last, max(2, round((last - first) * radius / fine) + 1)))
        end, before = last, (first, last, fine)
    return np.unique(np.concatenate(found))[1:]


def _between(first: float, last: float, at_first: float, at_last: float, most: float) -> np.ndarray:
    """Places from `first` to `last`, whose distances grow from both ends towards the middle."""
    left, right, steps = [first], [last], [at_first, at_last]
    while right[-1] - left[-1] > steps[0] + steps[1]:
        side = 0 if steps[0] <= steps[1] else 1
        steps[side] = min(most, (1.0 + GROWTH) * steps[side])
        (left, right)[side].append((left[-1] + steps[0], right[-1] - steps[1])[side])
    return np.array([*left, *right[::-1]])


def meshed(loops: list[np.ndarray]) -> MeshTri:
    """Triangles inside the first of closed polygons, (n, 2), m, outside all others; polygons' sides are elements'."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo, curves = gmsh.model.geo, []
        for loop in loops:
            sizes = 0.5 * np.hypot(*(np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)).T)
            points = [geo.addPoint(x, y, 0.0, size) for (x, y), size in zip(loop, sizes, strict=True)]
            lines = [geo.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
            for line in lines:
                geo.mesh.setTransfiniteCurve(line, 2)
            curves.append(geo.addCurveLoop(lines))
        geo.addPlaneSurface(curves)
        geo.synchronize()
        return mesh_of_section()
    finally:
        gmsh.finalize()


# ---- Triangles as fine as a contact at chosen spots of a surface, growing with the distance from them.

FINEST = 0.25  # mesh size at the middle of a spot, over that at the half-width
REACH = 4.0  # half-length of a spot, over the half-width
COARSEST = 1.5  # largest mesh size, over depth / per_half_width
FRONTAL_DELAUNAY = 6  # gmsh's algorithm with the best triangles


class Spot:
    """Where a contact of about a half-width b, m, presses: elements as long as b/per_half_width at its edge.

    They grow in proportion to the distance, so a contact several times narrower or wider has as many elements at its
    own edge, about.
    """

    def __init__(self, *, half_width: float, per_half_width: float):
        self.half_width, self.per_half_width = half_width, per_half_width
        self.finest = FINEST * half_width / per_half_width  # mesh size in the middle, m
        self.growth = (1.0 - FINEST) / per_half_width  # of the mesh size per distance

    @cached_property
    def corners(self) -> np.ndarray:
        """Corner nodes along the tangent, m, symmetric about the 0 in the middle."""
        along = [0.0]
        while along[-1] < REACH * self.half_width:
            along.append(along[-1] + self.finest + self.growth * along[-1])
        return np.array([-x for x in along[:0:-1]] + along)


class RefinedDisc(NamedTuple):
    """A disc with spots at the angles 0 and π."""

    radius: float  # m
    spot: Spot


class RefinedSector(NamedTuple):
    """One of equal sectors of an annulus, from −π/sectors to π/sectors; its raceway has a spot at the angle 0.

    Nodes on its two straight sides lie at the same radii.
    """

    raceway_radius: float  # m
    held_radius: float  # m
    sectors: int
    spot: Spot


def refined_mesh(shape: RefinedDisc | RefinedSector) -> Mesh:
    """Mesh of straight triangles; where it is curved the corners lie on the circles.

    Errors
    ------
    RuntimeError: gmsh can't be loaded.
    ValueError: spots overlap.
    """
    with gmsh_session(FRONTAL_DELAUNAY) as gmsh:
        # the field alone sets the size; boundaries and points have no say
        for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
            gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
        (_draw_disc if isinstance(shape, RefinedDisc) else _draw_sector)(gmsh.model, shape)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(TRIANGLE)
    points, cells = used_points(tags, coordinates.reshape(-1, 3)[:, :2], nodes.reshape(-1, 3))
    return Mesh(points=points, cells=counter_clockwise(points, cells))


def _draw_disc(model, disc: RefinedDisc) -> None:
    centre, arc = model.geo.addPoint(0.0, 0.0, 0.0), model.geo.addCircleArc
    (right, (a, b)), (left, (c, d)) = (_spot(model, disc.spot, disc.radius, angle) for angle in (0.0, pi))
    loop = [*right, arc(b, centre, c), *left, arc(d, centre, a)]
    _fill(model, loop, disc.spot, [(disc.radius, 0.0), (-disc.radius, 0.0)], disc.radius)


def _draw_sector(model, ring: RefinedSector) -> None:
    centre, arc, half = model.geo.addPoint(0.0, 0.0, 0.0), model.geo.addCircleArc, pi / ring.sectors
    spot, ends = _spot(model, ring.spot, ring.raceway_radius, 0.0)
    if asin(ring.spot.corners[-1] / ring.raceway_radius) >= half:
        raise ValueError(f"spots {2.0 * ring.spot.corners[-1]:.2g} m wide overlap on a ring of {ring.sectors} sectors")
    raceway = [_point(model, ring.raceway_radius, angle) for angle in (-half, half)]
    held = [_point(model, ring.held_radius, angle) for angle in (-half, 0.0, half)]
    sides = [model.geo.addLine(held[0], raceway[0]), model.geo.addLine(held[2], raceway[1])]
    loop = [
        sides[0], arc(raceway[0], centre, ends[0]), *spot, arc(ends[1], centre, raceway[1]), -sides[1],
        arc(held[2], centre, held[1]), arc(held[1], centre, held[0]),
    ]  # fmt: skip
    model.geo.synchronize()
    c, s = cos(2.0 * half), sin(2.0 * half)
    model.mesh.setPeriodic(1, [sides[1]], [sides[0]], [c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    _fill(model, loop, ring.spot, [(ring.raceway_radius, 0.0)], abs(ring.raceway_radius - ring.held_radius))


def _point(model, radius: float, angle: float) -> int:
    return model.geo.addPoint(radius * cos(angle), radius * sin(angle), 0.0)


def _spot(model, spot: Spot, radius: float, angle: float) -> tuple[list[int], tuple[int, int]]:
    """Edges of one element each along a circle, counter-clockwise, and the points at their ends."""
    points = [_point(model, radius, angle + asin(along / radius)) for along in spot.corners]
    edges = [model.geo.addLine(a, b) for a, b in itertools.pairwise(points)]
    for edge in edges:
        model.geo.mesh.setTransfiniteCurve(edge, 2)
    return edges, (points[0], points[-1])


def _fill(model, loop: list[int], spot: Spot, middles: list[tuple[float, float]], depth: float) -> None:
    """One surface within a loop of curves; its mesh size grows with the distance from the spots."""
    model.geo.addPlaneSurface([model.geo.addCurveLoop(loop)])
    model.geo.synchronize()
    sizes = [f"{spot.finest!r}+{spot.growth!r}*sqrt((x-({x!r}))^2+(y-({y!r}))^2)" for x, y in middles]
    field, fields = model.mesh.field, []
    for size in (*sizes, repr(COARSEST * depth / spot.per_half_width)):
        fields.append(field.add("MathEval"))
        field.setString(fields[-1], "F", size)
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", fields)
    field.setAsBackgroundMesh(smallest)


# ---- Compliance of discs and rings between the nodes of their contacts, from quadratic elements on refined meshes.
# Displacements are linear in the forces on the nodes of one contact; by rotation the other contacts follow. Forces
# and displacements are along the line of centres, positive where a force pushes the surface in.

QUADRATURE = 4  # order; exact for the stiffness of straight triangles
HERMITIAN = {"SymmetricMode": True}  # SuperLU's way with positive definite matrices: half the fill
SAME = 1e-6  # of a radius: nodes this close to a circle or a side lie on it


def contact_nodes(spot: Spot) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of one contact along the tangent, (m,), m, and the length each stands for, (m,), m, by Simpson's rule."""
    along, length = np.zeros((2, 2 * len(spot.corners) - 1))
    along[::2], along[1::2] = spot.corners, 0.5 * (spot.corners[:-1] + spot.corners[1:])
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
    stiffness, (dofs, (x, y)) = thickness * plane_strain_stiffness(basis, material), _nodes(basis)
    modes = np.zeros((basis.N, 3))  # two translations and the rotation about the origin
    modes[dofs[0], 0] = modes[dofs[1], 1] = 1.0
    modes[dofs[0], 2], modes[dofs[1], 2] = -y, x
    weighted = BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis) @ modes
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
    stiffness, (free, tied) = thickness * plane_strain_stiffness(basis, material), _ties(basis, ring)
    pushed = _spot_nodes(basis, ring.raceway_radius, 0.0, ring.spot)
    force, found = np.zeros((basis.N, pushed.size)), []
    force[pushed, np.arange(pushed.size)] = 1.0
    force = free.T @ force  # no spot touches a side
    own, across = free.T @ stiffness @ free + tied.T @ stiffness @ tied, free.T @ stiffness @ tied
    for harmonic in range(ring.sectors // 2 + 1):
        phase = np.exp(2j * np.pi * harmonic / ring.sectors)
        matrix = (own + phase * across + np.conj(phase) * across.T).tocsc()
        factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=HERMITIAN)
        found.append(force.T @ factor.solve(force.astype(complex)))
    return np.fft.irfft(np.array(found), n=ring.sectors, axis=0)


def _basis(mesh, circles: tuple[float, ...]) -> Basis:
    """Quadratic elements; the middles of edges between corners on a circle lie on it."""
    straight = MeshTri(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cells.T))
    curved, edges = MeshTri2.from_mesh(straight), straight.boundary_facets()
    radius = np.hypot(*straight.p[:, straight.facets[:, edges]])
    middles, points = curved.dofs.facet_dofs[0, edges], curved.doflocs.copy()
    for circle in circles:
        on = middles[np.all(np.abs(radius - circle) < SAME * circle, axis=0)]
        points[:, on] *= circle / np.hypot(*points[:, on])
    return Basis(replace(curved, doflocs=points), ElementVector(ElementTriP2()), intorder=QUADRATURE)


def _nodes(basis: Basis) -> tuple[np.ndarray, np.ndarray]:
    """Degrees of freedom of every node, corners then middles of edges, (2, n_nodes), and where they are."""
    dofs = np.concatenate([basis.nodal_dofs, basis.facet_dofs], axis=1)
    return dofs, basis.doflocs[:, dofs[0]]


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
    unknown = ~held
    unknown[second] = False
    columns = dofs[:, unknown].T.ravel()
    free = sparse.csr_matrix((np.ones(columns.size), (columns, np.arange(columns.size))), (basis.N, columns.size))
    c, s = np.cos(2.0 * half), np.sin(2.0 * half)
    turned = sparse.csr_matrix((basis.N, basis.N), dtype=float).tolil()
    for i, turn in enumerate(((c, -s), (s, c))):
        for j in range(2):
            turned[dofs[i, second], dofs[j, first]] = turn[j]
    return free, turned.tocsr() @ free


# ---- Statics of the whole bearing on locally refined meshes of quadratic elements: the yardstick with elements of
# its own. No law below the grid, no layer, no assumed pressure: nodes of the two surfaces lie opposite each other and
# push or stand open (Signorini). Undeformed gaps are those of exact circles.

STRIBECK = 5.0  # largest roller load times the number of rollers over the bearing's load, about (Stribeck 1907)


class QuadraticStatics(NamedTuple):
    """A bearing at rest: hub position, m, contact forces, N, and pressures."""

    hub: np.ndarray  # (2,)
    rho: np.ndarray  # (n_rollers,), m
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray
    across: np.ndarray  # (n_nodes,), m, nodes of every contact from its line of centres along the ring's tangent
    inner_pressure: np.ndarray  # (n_rollers, n_nodes), Pa
    outer_pressure: np.ndarray
    gap: np.ndarray  # (2, n_rollers, n_nodes), m, between the deformed surfaces of inner and of outer contacts


def quadratic_statics(
    bearing: Bearing, radial_load: float, first_roller_angle: float, per_half_width: float = 5.0
) -> QuadraticStatics:
    """Equilibrium of standing, weightless, frictionless elastic bodies under a load along −y, N; angle in rad from +x.

    Rollers stay at their angles. Element edges at the rim of a contact are half-width/per_half_width long.

    Errors
    ------
    Of the mesh: 4e-4 with the default, 1e-4 at 8 elements per half-width. Of the theory: pressures push along the line
    of centres; along each surface's own normal the hub would sink by 3e-4 more (the paper's bearing). Influences are
    those at the rollers' angles, from which lines of centres differ by the hub's displacement over the pitch radius.
    ValueError: the load is not positive; surfaces that are not perfect circles.
    NotFound: no equilibrium, or contacts several times wider than the load makes one expect.
    """
    if not radial_load > 0.0:
        raise ValueError(f"radial load {radial_load:g} N: the mesh is made for the contacts of a load > 0")
    if bearing.faults:
        raise ValueError("bearing.faults: the contacts of these meshes lie on perfect circles; leave the faults out")
    n, angle = bearing.n_rollers, roller_angles(bearing, first_roller_angle)
    radial = np.column_stack([np.cos(angle), np.sin(angle)])
    half_width = contact_pairs(bearing)[0].half_width(STRIBECK * radial_load / n)  # it only scales the mesh
    spot = Spot(half_width=half_width, per_half_width=per_half_width)
    along, length = contact_nodes(spot)
    # how far circles fall apart beside the line of centres, m
    roller, inner, outer = (along**2 / (R + np.sqrt(R**2 - along**2)) for R in (
        bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius))  # fmt: skip
    points = Condensed(
        bearing=bearing, radial=radial, inner_law=NoLaw(), outer_law=NoLaw(),
        contact=np.repeat(np.arange(2 * n), along.size), compliance=_compliance(bearing, half_width, per_half_width),
        closing=-np.concatenate([np.tile(fall, n) for fall in (roller + inner, roller - outer)]),
    )  # fmt: skip
    area = length * bearing.roller_length
    place, force = balance(points, Loads(radial_load), first_guess(bearing, radial, radial_load))
    force = closed_forces(force)
    overlap = geometry(bearing, radial, place)[0]
    pressed = force.reshape(2, n, -1)
    if (pressed[..., [0, -1]] > 0.0).any():
        raise NotFound(f"contacts are wider than the {along[-1]:.2g} m that the mesh resolves to either side")
    (inner_force, outer_force), (inner_pressure, outer_pressure) = pressed.sum(axis=2), pressed / area
    gap = (points.compliance @ force - overlap[points.contact] - points.closing).reshape(pressed.shape)
    return QuadraticStatics(
        hub=place[:2], rho=place[2:], inner_force=inner_force, outer_force=outer_force, across=along,
        inner_pressure=inner_pressure, outer_pressure=outer_pressure, gap=gap,
    )  # fmt: skip


@lru_cache(maxsize=1)  # wherever the rollers stand
def _compliance(bearing: Bearing, half_width: float, per_half_width: float) -> np.ndarray:
    """Between the nodes of all contacts, inner ones first, (2 n m, 2 n m), m/N."""
    spot = Spot(half_width=half_width, per_half_width=per_half_width)
    n, m, length = bearing.n_rollers, contact_nodes(spot)[0].size, bearing.roller_length
    found, j = np.zeros((2, n, m, 2, n, m)), np.arange(n)
    for kind, (raceway, held, material, _) in enumerate(ring_sections(bearing)):
        ring = ring_spot_compliance(RefinedSector(raceway, held, n, spot), material, length)
        for k in range(n):
            found[kind, j, :, kind, k] = ring[(j - k) % n]
    own, other = disc_spot_compliance(RefinedDisc(bearing.roller_radius, spot), bearing.roller, length)
    # the roller counts its nodes as the outer raceway does, and against the inner one
    found[1, j, :, 1, j] += own
    found[0, j, :, 0, j] += own[::-1, ::-1]
    found[1, j, :, 0, j] += other[:, ::-1]
    found[0, j, :, 1, j] += other[::-1]
    found.flags.writeable = False
    return found.reshape(2 * n * m, 2 * n * m)
