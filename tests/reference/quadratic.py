"""Elastic bodies of quadratic triangles that touch without friction, node by node: at rest, vibrating, in motion.

The yardstick with elements of its own (scikit-fem's, scipy's solvers): no law below a grid, no layer, no assumed
pressure. Gaps and forces of nodes are not negative, and one of the two is zero: what a contact yields is what the
elements yield. Sources: Rubin, AIAA J. 13 (1975) 995 (residual flexibility); Hintermüller, Ito and Kunisch, SIAM J.
Optim. 13 (2002) 865 (active sets).
"""

from functools import lru_cache
from math import pi
from typing import NamedTuple

import gmsh
import numpy as np
from scipy import sparse
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem import Basis, BilinearForm, ElementTriP1, ElementTriP2, ElementVector, FacetBasis, LinearForm, MeshTri
from skfem.helpers import dot
from skfem.models.elasticity import linear_elasticity

from lagrange import Bearing, Material
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.surface.faults import Spall
from tests.reference.continua import separated

# ---- Triangles whose boundary is given point by point: fine where bodies touch, coarse far from there.

GROWTH = 0.15  # of a side's length, per length away from what is fine
SAMPLES = 400_001  # of lengths around a circle


def graded(places: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Points from the first to the last of places, as far apart as `length` at each of them says."""
    steps = cumulative_trapezoid(1.0 / length, places, initial=0.0)
    return np.interp(np.linspace(0.0, steps[-1], round(steps[-1]) + 1), steps, places)


def around(radius: float, zones: list[tuple[float, float, float]], coarse: float) -> np.ndarray:
    """Angles of points around a circle, rad; `zones` : middle, rad, half-length and spacing, m; `coarse` elsewhere."""
    angle, length = np.linspace(-pi, pi, SAMPLES), np.full(SAMPLES, coarse)
    for middle, half, fine in zones:
        away = radius * np.abs(np.angle(np.exp(1j * (angle - middle))))
        length = np.minimum(length, fine + GROWTH * np.maximum(away - half, 0.0))
    return graded(angle, length / radius)[1:]


def on_circle(radius, angle) -> np.ndarray:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def meshed(loops: list[np.ndarray], length: str = "") -> MeshTri:
    """Triangles inside the first of closed polygons, (n, 2), m, outside all others; polygons' sides are elements'.

    `length` : of sides inside, of x and y, as gmsh reads it; else they grow from the polygons' own
    """
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo, curves = gmsh.model.geo, []
        for loop in loops:
            sides = 0.5 * np.hypot(*(np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)).T)
            points = [geo.addPoint(x, y, 0.0, side) for (x, y), side in zip(loop, sides, strict=True)]
            lines = [geo.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
            for line in lines:
                geo.mesh.setTransfiniteCurve(line, 2)
            curves.append(geo.addCurveLoop(lines))
        geo.addPlaneSurface(curves)
        geo.synchronize()
        if length:
            for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
                gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
            field = gmsh.model.mesh.field.add("MathEval")
            gmsh.model.mesh.field.setString(field, "F", length)
            gmsh.model.mesh.field.setAsBackgroundMesh(field)
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        used, cells = np.unique(gmsh.model.mesh.getElementsByType(2)[1], return_inverse=True)
    finally:
        gmsh.finalize()
    order = np.argsort(tags)
    nodes = coordinates.reshape(-1, 3)[order[np.searchsorted(tags[order], used)], :2]
    return MeshTri(np.ascontiguousarray(nodes.T), np.ascontiguousarray(cells.reshape(-1, 3).T))


# ---- One body: its matrices, how it yields at rest, its vibrations.

SHIFT = (2.0 * pi * 2e3) ** 2  # 1/s², below 0, around which the slowest modes are found
AT_ONCE = 32  # unit forces solved for
SYMMETRIC = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}


class Section:
    """A body of a length, m, meshed as `meshed` says; nodes on a circle of radius `held`, m, are held.

    points, (n, 2), m, of the other nodes; rim, (n,), whether they lie on a loop; stiffness and mass, (2 n, 2 n), of x
    and y of each; rigid, (2 n, 3), its motions as a whole; rows of these unknowns among those of the basis
    """

    def __init__(self, loops: list[np.ndarray], material: Material, length: float, held=None, inside: str = ""):
        mesh = meshed(loops, inside)
        self.basis, self.material, self.length = Basis(mesh, ElementVector(ElementTriP2())), material, length
        dofs = np.concatenate([self.basis.nodal_dofs, self.basis.facet_dofs], axis=1)
        points, rim = self.basis.doflocs[:, dofs[0]].T, np.zeros(dofs.shape[1], dtype=bool)
        rim[mesh.boundary_nodes()] = rim[mesh.nvertices + mesh.boundary_facets()] = True
        free = np.ones(len(points), dtype=bool)
        if held is not None:  # middles of sides lie inside the circle
            free = ~rim | (np.abs(np.hypot(*points.T) / held - 1.0) > 0.01)
        self.points, self.rim, self.rows = points[free], rim[free], dofs[:, free].T.ravel()
        stiffness = linear_elasticity(material.lame_lambda, material.lame_mu).assemble(self.basis)
        mass = BilinearForm(lambda u, v, _: dot(u, v)).assemble(self.basis)
        own, density = np.ix_(self.rows, self.rows), material.density
        self.stiffness, self.mass = length * stiffness[own].tocsc(), density * length * mass[own].tocsc()
        x, y = self.points.T
        self.rigid = np.column_stack([np.tile(np.eye(2), (len(x), 1)), np.stack([-y, x], axis=1).ravel()])
        self.held, pins, ends = held is not None, np.zeros(2 * len(x)), np.argsort(x)[[0, -1]]
        if not self.held:  # three springs, which loads that are balanced by inertia do not stretch
            pins[[2 * ends[0], 2 * ends[0] + 1, 2 * ends[1] + 1]] = self.stiffness.diagonal().mean()
        self.factor = splu((self.stiffness + sparse.diags(pins)).tocsc(), **SYMMETRIC)

    def at_rest(self, force: np.ndarray) -> np.ndarray:
        """Displacement by forces, (2 n, k); a free body speeds up as a whole, and is seen from its centre of mass."""
        if self.held:
            return self.factor.solve(force)
        heavy = self.mass @ self.rigid
        whole = np.linalg.inv(self.rigid.T @ heavy)
        u = self.factor.solve(force - heavy @ (whole @ (self.rigid.T @ force)))
        return u - self.rigid @ (whole @ (heavy.T @ u))

    def influence(self, pushed: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """Displacement, m/N, of some unknowns at rest by unit forces on others."""
        found = []
        for some in np.array_split(pushed, pushed.size // AT_ONCE + 1):
            force = np.zeros((self.rows.size, some.size))
            force[some, np.arange(some.size)] = 1.0
            found.append(self.at_rest(force)[moved])
        return np.concatenate(found, axis=1)

    def vibrations(self, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
        """Angular frequencies up to `cutoff`, rad/s, 0 of rigid motions, and shapes of unit mass, (2 n, n_modes)."""
        of, area = self.material, self.rigid[:, 0] @ self.mass @ self.rigid[:, 0] / self.material.density / self.length
        squared_speeds = of.dilatational_wave_speed**2, of.lame_mu / of.density
        count = round(1.1 * area * cutoff**2 / (4.0 * pi) * sum(1.0 / c2 for c2 in squared_speeds)) + 20  # Weyl's law
        start = np.random.default_rng(0).standard_normal(self.rows.size)  # ARPACK's own would differ from call to call
        factor = splu((self.stiffness + SHIFT * self.mass).tocsc(), **SYMMETRIC)
        inverse = LinearOperator(self.stiffness.shape, matvec=factor.solve)
        squares, shapes = eigsh(self.stiffness, count, self.mass, sigma=-SHIFT, OPinv=inverse, v0=start)
        assert squares.max() > cutoff**2, f"{count} modes end below the cutoff"
        kept = squares < cutoff**2
        return np.sqrt(np.where(squares < 1e-3 * SHIFT, 0.0, squares)[kept]), shapes[:, kept]


# ---- A roller squeezed by two Hertz pressures: the stress inside.


def resolved_disc(radius, material, line_load, half_widths):
    """Along the axis of symmetry from the lower contact to the upper one: y, m, and σ_xx, σ_yy, Pa.

    `half_widths`: of the lower and the upper contact, m; `line_load`, N/m, on both.
    """
    ends = [(side, b) for side, b in zip((-1.0, 1.0), half_widths, strict=True)]
    rim = on_circle(radius, around(radius, [(side * 0.5 * pi, 1.5 * b, 0.1 * b) for side, b in ends], 0.1 * radius))
    inside = [f"{0.05 * b!r}+{GROWTH}*Sqrt(x^2+(y-({side * radius!r}))^2)" for side, b in ends]
    disc = Section([rim], material, 1.0, inside=f"Min(Min({inside[0]},{inside[1]}),{0.1 * radius!r})")

    @LinearForm
    def pressure(v, w):
        x, y = w.x
        share = radius * np.arctan2(np.abs(x), np.abs(y)) / np.where(y < 0.0, *half_widths)
        p = 2.0 * line_load / np.pi / np.where(y < 0.0, *half_widths) * np.sqrt(np.maximum(1.0 - share**2, 0.0))
        return -p * dot(w.n, v)

    load = pressure.assemble(FacetBasis(disc.basis.mesh, disc.basis.elem, intorder=8))
    u = disc.basis.zeros()
    u[disc.rows] = disc.at_rest(load[disc.rows, None])[:, 0]
    gradient = disc.basis.interpolate(u).grad
    strain, linear = 0.5 * (gradient + np.swapaxes(gradient, 0, 1)), disc.basis.with_element(ElementTriP1())
    away = np.geomspace(0.01 * min(half_widths), radius, 600)
    y = np.concatenate([away - radius, radius - away[-2::-1]])
    stress = [2.0 * material.lame_mu * strain[i, i] + material.lame_lambda * np.trace(strain) for i in (0, 1)]
    return y, *(linear.interpolator(linear.project(s))(np.stack([0.0 * y, y])) for s in stress)


# ---- Bodies that must balance loads: they stand on springs until these carry nothing (proximal points).

BALANCED = 1e-10  # of all forces


def balanced(gaps, compliance: np.ndarray, load: np.ndarray, place: np.ndarray, spring: float):
    """Forces on nodes, N, and places, m, of what moves as a whole, at which they carry a load, N.

    `gaps` : of places, the nodes' undeformed gaps, m, and by how much places close them; `spring`, N/m
    """
    force = np.zeros(len(compliance))
    for _ in range(100):
        gap, closing = gaps(place)
        on_springs = compliance + closing @ closing.T / spring
        force = separated(gap - closing @ load / spring, on_springs, force > 0.0)
        left = load - closing.T @ force
        place = place + left / spring
        if np.abs(left).max() < BALANCED * max(force.sum(), 1.0):
            return force, place
    raise RuntimeError("no equilibrium")


def ring_in_bore(radii: tuple[float, float], material: Material, bed: float, play: float, forces, n_points: int):
    """Pressure, Pa, and outward displacement, m, of the outside at angles 2πi/n, of a ring in a bore.

    The bore pushes by bed, Pa/m · (displacement − play), never pulls, without friction. Forces are (radius, m, angle,
    N per m of length outwards).
    """
    outside = 2.0 * pi / n_points * np.arange(n_points)
    inside = np.unique(np.round(np.append(outside, [angle % (2.0 * pi) for _, angle, _ in forces]), 9))
    ring = Section([on_circle(radii[1], outside), on_circle(radii[0], inside)], material, 1.0)
    distance, turn = np.hypot(*ring.points.T), np.mod(np.arctan2(*ring.points[:, ::-1].T) + 1e-9, 2.0 * pi)
    at = np.flatnonzero(ring.rim & (distance > 0.5 * sum(radii)))
    at = at[np.argsort(turn[at])]  # corners, and middles of sides
    normal, load = ring.points[at] / distance[at, None], np.zeros((len(ring.points), 2))
    for radius, angle, force in forces:
        load[np.argmin(np.hypot(*(ring.points - on_circle(radius, angle)).T))] += on_circle(force, angle)
    pushed = np.zeros((len(ring.points), 2, at.size))
    pushed[at, :, np.arange(at.size)] = normal
    moved = ring.at_rest(np.column_stack([load.ravel(), pushed.reshape(-1, at.size)])).reshape(-1, 2, 1 + at.size)
    moved = np.einsum("ia,iaj->ij", normal, moved[at])
    area = 2.0 * pi / n_points * radii[1] * np.tile([1.0 / 3.0, 2.0 / 3.0], n_points)
    force, place = balanced(
        lambda place: (play - moved[:, 0] - normal @ place, normal), np.diag(1.0 / (bed * area)) + moved[:, 1:],
        load.sum(axis=0), np.zeros(2), 1e-3 * bed * radii[1],
    )  # fmt: skip
    return (force / area)[::2], (moved[:, 0] - moved[:, 1:] @ force + normal @ place)[::2]


# ---- The whole bearing at rest on meshes refined where one of its rollers touches; undeformed gaps are those of exact
# circles, and forces and displacements of a contact are along its line of centres.

FINEST, REACH = 0.25, 4.0  # side in the middle of a contact, over that at its edge; what is fine, over the half-width
STRIBECK = 5.0  # largest roller load times the number of rollers over the bearing's load, about (Stribeck 1907)
LOOSE = 1.0  # 1/m, of the load: springs that hold hub and rollers where they were last
ASIDE = 1e-9  # m, where the hub starts, lest it stay balanced on a single roller


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


def contact_nodes(half_width: float, per_half_width: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of one contact along the tangent, (m,), m, corners and middles of sides by turns, and the length that each
    stands for, (m,), m, by Simpson's rule; sides at the half-width, m, are half-width/per_half_width long."""
    corners = [0.0]
    while corners[-1] < REACH * half_width:
        corners.append(corners[-1] + (FINEST * half_width + (1.0 - FINEST) * corners[-1]) / per_half_width)
    corners = np.array([-x for x in corners[:0:-1]] + corners)
    along, length = np.zeros((2, 2 * corners.size - 1))
    along[::2], along[1::2] = corners, 0.5 * (corners[:-1] + corners[1:])
    sides = np.diff(corners)
    length[1::2] = sides * (4.0 / 6.0)
    length[:-1:2] += sides / 6.0
    length[2::2] += sides / 6.0
    return along, length


def spot_compliance(
    radius: float, held: float | None, material: Material, length: float, spot: tuple[float, float], spots: int
) -> np.ndarray:
    """Of a disc, or of a ring held on another circle, between nodes of contacts all around, (spots, m, m), m/N.

    Entry [k] is the displacement of one contact's nodes by forces on the contact k places behind it (clockwise), either
    counting its nodes counter-clockwise. `spot` : as `contact_nodes` has it
    """
    along, finest, growth = contact_nodes(*spot)[0], FINEST * spot[0] / spot[1], (1.0 - FINEST) / spot[1]
    end, depth = np.arcsin(along[-1] / radius), radius if held is None else abs(held - radius)
    away, coarse = np.linspace(end, 2.0 * pi - end, SAMPLES), min(0.05 * radius, depth / 6.0)
    sides = np.minimum(finest + growth * 2.0 * radius * np.sin(0.5 * away), coarse)
    rest = graded(away, sides / radius)[1:-1]
    loops = [on_circle(radius, np.concatenate([np.arcsin(along[::2] / radius), rest]))]
    if held is not None:
        loops.insert(int(held < radius), on_circle(held, around(held, [], coarse)))
    inside = f"Min({finest!r}+{growth!r}*Sqrt((x-{radius!r})^2+y^2),{depth / 5.0!r})"
    body = Section(loops, material, length, held, inside)
    rim = np.flatnonzero(body.rim)
    angle = np.arctan2(*body.points[rim, ::-1].T)
    rim, angle = rim[np.argsort(angle)], np.sort(angle)
    pushed = rim[np.abs(angle) < end + 1e-9]
    assert np.allclose(body.points[pushed, 1], along, atol=1e-6 * along[-1])
    x, y = (body.influence(2 * pushed, 2 * rim + axis) for axis in (0, 1))
    moved = CubicSpline(np.append(angle, angle[0] + 2.0 * pi), np.append(x + 1j * y, x[:1] + 1j * y[:1], axis=0),
                        bc_type="periodic")  # fmt: skip
    places = angle[np.abs(angle) < end + 1e-9]
    turns = 2.0 * pi / spots * np.arange(spots)
    return np.array([(moved(places + turn) * np.exp(-1j * turn)).real for turn in turns])


@lru_cache(maxsize=1)  # wherever the rollers stand
def _compliance(bearing: Bearing, half_width: float, per_half_width: float) -> np.ndarray:
    """Between the nodes of all contacts, inner ones first, (2 n m, 2 n m), m/N."""
    spot = half_width, per_half_width
    n, m, length = bearing.n_rollers, contact_nodes(*spot)[0].size, bearing.roller_length
    found, j = np.zeros((2, n, m, 2, n, m)), np.arange(n)
    for kind, (raceway, held, material) in enumerate((
        (bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring),
        (bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring),
    )):  # fmt: skip
        ring = spot_compliance(raceway, held, material, length, spot, n)
        for k in range(n):
            found[kind, j, :, kind, k] = ring[(j - k) % n]
    own, other = spot_compliance(bearing.roller_radius, None, bearing.roller, length, spot, 2)
    # the roller counts its nodes as the outer raceway does, and against the inner one
    found[1, j, :, 1, j] += own
    found[0, j, :, 0, j] += own[::-1, ::-1]
    found[1, j, :, 0, j] += other[:, ::-1]
    found[0, j, :, 1, j] += other[::-1]
    found.flags.writeable = False
    return found.reshape(2 * n * m, 2 * n * m)


def quadratic_statics(
    bearing: Bearing, radial_load: float, first_roller_angle: float, per_half_width: float = 5.0
) -> QuadraticStatics:
    """Equilibrium of standing, weightless, frictionless elastic bodies under a load along −y, N; angle in rad from +x.

    Rollers stay at their angles.

    Errors
    ------
    Of the mesh: 4e-4 with the default, 1e-4 at 8 elements per half-width. Of the theory: pressures push along the line
    of centres; along each surface's own normal the hub would sink by 3e-4 more (the paper's bearing). Influences are
    those at the rollers' angles, from which lines of centres differ by the hub's displacement over the pitch radius.
    """
    n, radial = bearing.n_rollers, on_circle(1.0, roller_angles(bearing, first_roller_angle))
    half_width = contact_pairs(bearing)[0].half_width(STRIBECK * radial_load / n)  # it only scales the mesh
    along, length = contact_nodes(half_width, per_half_width)
    compliance = _compliance(bearing, half_width, per_half_width)
    r, inner, outer = bearing.roller_radius, bearing.inner_raceway_radius, bearing.outer_raceway_radius
    falls = [along**2 / (R + np.sqrt(R**2 - along**2)) for R in (r, inner, outer)]  # beside the line of centres, m
    fall = np.concatenate([np.tile(falls[0] + falls[1], n), np.tile(falls[0] - falls[2], n)])
    load, j = np.append([0.0, -radial_load], np.zeros(n)), np.arange(n)

    def gaps(place):
        to_roller = place[2:, None] * radial - place[:2]
        distance, closing = np.hypot(*to_roller.T), np.zeros((2 * n, 2 + n))
        closing[:n, :2] = to_roller / distance[:, None]
        closing[j, 2 + j], closing[n + j, 2 + j] = -np.sum(closing[:n, :2] * radial, axis=1), 1.0
        overlap = np.concatenate([inner + r - distance, place[2:] + r - outer])
        return fall - np.repeat(overlap, along.size), np.repeat(closing, along.size, axis=0)

    start = np.append([-ASIDE, 0.0], np.full(n, bearing.pitch_radius))
    force, place = balanced(gaps, compliance, load, start, LOOSE * radial_load)
    pressed, area = force.reshape(2, n, -1), length * bearing.roller_length
    assert not pressed[..., [0, -1]].any(), f"contacts are wider than the {along[-1]:.2g} m that the mesh resolves"
    return QuadraticStatics(
        hub=place[:2], rho=place[2:], inner_force=pressed[0].sum(axis=1), outer_force=pressed[1].sum(axis=1),
        across=along, inner_pressure=pressed[0] / area, outer_pressure=pressed[1] / area,
        gap=(gaps(place)[0] + compliance @ force).reshape(pressed.shape),
    )  # fmt: skip


# ---- Bodies in motion by their lowest vibrations; what all others add to the motion of the nodes that may be touched
# follows at once, as in statics. A step is a small linear complementarity problem.


class Body(NamedTuple):
    """A body as its contact nodes feel it."""

    points: np.ndarray  # (n_contact, 2), m, contact nodes as meshed, by their angle
    omega: np.ndarray  # (n_modes,), rad/s; 0 of rigid ones
    shapes: np.ndarray  # (2 n_contact, n_modes), x and y of each node, 1/√kg
    residual: np.ndarray  # (2 n_contact, 2 n_contact), m/N
    translation: np.ndarray  # (n_modes, 2), √kg: modes' parts in moving along x and y by 1
    mass: float  # kg


def body(of: Section, cutoff: float, zones) -> Body:
    """With modes up to a frequency, Hz; `zones` : middles and half-lengths, rad, of what may be touched."""
    angle, at = np.arctan2(*of.points[:, ::-1].T), of.rim.copy()
    at &= np.any([np.abs(angle - middle) <= half for middle, half in zones], axis=0)
    at = np.flatnonzero(at)[np.argsort(angle[at])]
    contact, (omega, modes) = (2 * at[:, None] + np.arange(2)).ravel(), of.vibrations(2.0 * pi * cutoff)
    shapes, elastic = modes[contact], omega > 0.0
    known = (shapes[:, elastic] / omega[elastic] ** 2) @ shapes[:, elastic].T
    residual, unit = of.influence(contact, contact) - known, of.mass @ of.rigid[:, :2]
    return Body(
        points=of.points[at], omega=omega, shapes=shapes, residual=0.5 * (residual + residual.T),
        translation=modes.T @ unit, mass=float(of.rigid[:, 0] @ unit[:, 0]),
    )  # fmt: skip


class Motion:
    """A body's modes in time, by the trapezoidal rule; `still`: at rest, with steps that find equilibrium."""

    def __init__(self, of: Body, step: float, still: bool = False):
        self.body, self.step, self.still = of, step, still
        self.inertia = (1.0 if still else 4.0) / step**2
        self.answer = 1.0 / (self.inertia + of.omega**2)
        self.compliance = of.residual + (of.shapes * self.answer) @ of.shapes.T
        self.q, self.v, self.a, self.load = np.zeros((4, of.omega.size))
        self.stored = 0.0  # J, beside the modes

    def expect(self) -> np.ndarray:
        """Where contact nodes, (n_contact, 2), m, would be after the step if nothing touched."""
        self.drifted = self.q if self.still else self.q + self.step * self.v + 0.25 * self.step**2 * self.a
        self.expected = self.answer * (self.inertia * self.drifted + self.load)
        return (self.body.shapes @ self.expected).reshape(-1, 2)

    def advance(self, force: np.ndarray) -> None:
        """Take the step with forces on the contact nodes, (2 n_contact,), N."""
        self.q, k = self.expected + self.answer * (force @ self.body.shapes), np.flatnonzero(force)
        self.stored = 0.5 * float(force[k] @ self.body.residual[np.ix_(k, k)] @ force[k])
        if not self.still:
            new = (self.q - self.drifted) * self.inertia
            self.v, self.a = self.v + 0.5 * self.step * (self.a + new), new

    def mean(self, q: np.ndarray) -> np.ndarray:
        """Motion of the centre of mass, (2,), m."""
        return q @ self.body.translation / self.body.mass

    @property
    def energy(self) -> float:
        """Kinetic and elastic, J."""
        return 0.5 * float(self.v @ self.v + np.sum((self.body.omega * self.q) ** 2)) + self.stored


# ---- A roller between rings, or on one, that it meets anywhere between its own nodes. It is free, without friction and
# without spin (a disc's answer does not depend on it).

SETTLING, SETTLINGS = 1e-4, 12  # s, of a step that finds equilibrium; how many
NEAR = 0.5e-6  # m, of gaps looked at in a step: bodies at 1 m/s come nearer by 0.1 µm


class Run:
    """The roller in steps; `rings`: bodies and where their contact nodes lie, (n, 2), m, on the true surface."""

    def __init__(self, roller: Body, radius: float, rings: list[tuple[Body, np.ndarray]], start, step: float):
        self.radius, self.start, places = radius, np.asarray(start, dtype=float), [at for _, at in rings]
        self.places, self.ends = np.concatenate(places), np.cumsum([len(at) for at in places])[:-1]
        self.pressure = np.zeros(len(self.places))  # N, on each of the rings' nodes
        self.angle = np.arctan2(*roller.points[:, ::-1].T)
        self._take([Motion(each, step) for each in (roller, *(ring for ring, _ in rings))])

    def _take(self, motions: list[Motion]) -> None:
        self.motions, self.compliance = motions, block_diag(*(motion.compliance for motion in motions[1:]))

    def settle(self, swing: float = 0.0) -> np.ndarray:
        """Find the equilibrium of the roller that runs around the origin at `swing`, rad/s, and set it going; forces as
        `advance` has them."""
        moving, still = self.motions, [Motion(motion.body, SETTLING, still=True) for motion in self.motions]
        translation = moving[0].body.translation
        still[0].load = translation @ (swing**2 * self.start)
        self._take(still)
        for _ in range(SETTLINGS):
            forces = self.advance(near=np.inf)
        for motion, found in zip(moving, still, strict=True):
            motion.q, motion.stored = found.q, found.stored
        self._take(moving)
        moving[0].v = translation @ (swing * np.array([-self.centre[1], self.centre[0]]))
        moving[0].a = translation @ (-(swing**2) * self.centre)
        return forces

    @property
    def centre(self) -> np.ndarray:
        """Of the roller's mass, (2,), m."""
        return self.start + self.motions[0].mean(self.motions[0].q)

    def advance(self, near: float = NEAR) -> np.ndarray:
        """Take a step, looking at gaps below `near`, m; forces of the rings on the roller, (n_rings, 2), N."""
        roller, *rings = self.motions
        moves, shift, axes = roller.expect(), roller.mean(roller.expected), np.arange(2)
        away, strained = self.places - self.start - shift, moves - shift  # about the roller's centre
        away += np.concatenate([ring.expect() for ring in rings])
        distance = np.hypot(*away.T)
        normal = away / distance[:, None]
        toward = np.arctan2(normal[:, 1], normal[:, 0])
        after = np.clip(np.searchsorted(self.angle, toward), 1, self.angle.size - 1)
        pair, width = np.stack([after - 1, after], axis=1), self.angle[after] - self.angle[after - 1]
        beyond = (toward - self.angle[after - 1]) / width
        share = np.stack([1.0 - beyond, beyond], axis=1)
        gap = distance - self.radius - np.sum(normal * np.einsum("ij,ijk->ik", share, strained[pair]), axis=1)
        k = np.flatnonzero((beyond >= 0.0) & (beyond <= 1.0) & (width < 0.1) & (gap < near))  # none between the zones
        starts, weights = 2 * np.arange(k.size + 1), -(share[k, :, None] * normal[k, None, :]).ravel()
        on_roller, on_ring = (2 * pair[k, :, None] + axes).ravel(), (2 * k[:, None] + axes).ravel()
        by_roller = sparse.csr_matrix((weights, on_roller, 2 * starts), (k.size, strained.size))
        by_ring = sparse.csr_matrix((normal[k].ravel(), on_ring, starts), (k.size, self.places.size))
        compliance = by_roller @ (by_roller @ roller.compliance).T + by_ring @ (by_ring @ self.compliance).T
        force = separated(gap[k], compliance, self.pressure[k] > 0.0)
        self.pressure[:] = 0.0
        self.pressure[k] = force
        pushes = [by_roller.T @ force, *np.split(by_ring.T @ force, 2 * self.ends)]
        for motion, pushed in zip(self.motions, pushes, strict=True):
            motion.advance(pushed)
        return -np.array([part.sum(axis=0) for part in np.split(self.pressure[:, None] * normal, self.ends)])


# ---- A roller that crosses a spall at the lowest point of the outer ring: every body meshed, the spall cut out of the
# mesh. Fixed axes, the load along −y; the rings' far sides are held, the hub stays.

DOWN = -0.5 * pi
ARC = 0.45  # rad, of an edge that may be touched
ROOM = 0.1e-3  # m, of fine mesh beyond where contacts' middles get


class Fineness(NamedTuple):
    """Lengths of elements' sides, m; nodes lie half as far apart."""

    edge: float = 3e-6  # outer ring at the spall's edges
    raceway: float = 10e-6
    roller: float = 4e-6  # finer than what it rolls on: the rings' nodes meet it anywhere between its own
    far_roller: float = 0.2e-3
    far: float = 1.0e-3
    cutoff: float = 0.7e6  # Hz, of modes


FINE = Fineness()


def roller_body(bearing: Bearing, lower: float, upper: float, fine: Fineness) -> Body:
    """The roller, touched within half-lengths `lower` and `upper`, m, below and above."""
    r, zones = bearing.roller_radius, [(DOWN, lower, fine.roller), (-DOWN, upper, fine.roller)]
    section = Section([on_circle(r, around(r, zones, fine.far_roller))], bearing.roller, bearing.roller_length)
    return body(section, fine.cutoff, [(middle, half / r) for middle, half, _ in zones])


def bare_depth(spall: Spall | None, opening: float, chord: np.ndarray) -> np.ndarray:
    """How far the bare profile lies outside the raceway's circle, m, at places along the chord from its middle."""
    if spall is None:
        return np.zeros_like(chord)
    inside, e = np.clip(opening - np.abs(chord), 0.0, spall.edge_radius), spall.edge_radius
    return np.where(inside < e, np.minimum(e - np.sqrt(e * e - inside**2), spall.depth), spall.depth)


def crossing(
    bearing: Bearing, spall: Spall | None, hub, ahead: float, beyond: float, step: float, fine: Fineness = FINE
) -> Run:
    """The roller starts `ahead`, m along the raceway, of the load line and gets as far as `beyond`; `hub`, (2,), m."""
    R, Ri, r = bearing.outer_raceway_radius, bearing.inner_raceway_radius, bearing.roller_radius
    most, opening, least = max(ahead, beyond), 0.0, 0.0
    half, inner_half = most + 1.5 * ROOM, most * Ri / R + 1.5 * ROOM
    zones = [(DOWN, half, fine.raceway)]
    if spall is not None:
        opening = spall.half_opening(r)
        least = opening - spall.edge_radius * np.sin(ARC)
        zones += [(DOWN + side * np.arcsin(opening / R), 0.45 * spall.edge_radius, fine.edge) for side in (-1.0, 1.0)]

    def profile(angle):
        return R + np.where(np.sin(angle) < 0.0, bare_depth(spall, opening, R * np.cos(angle)), 0.0)

    def ring(loop, held, material, touched) -> tuple[Body, np.ndarray]:
        """And the angles of its contact nodes."""
        far = on_circle(held, around(held, [], fine.far))
        section = Section([loop, far] if held < R else [far, loop], material, bearing.roller_length, held)
        found = body(section, fine.cutoff, touched)
        return found, np.arctan2(*found.points[:, ::-1].T)

    angle = around(R, zones, fine.far)
    sides = [(DOWN + side * 0.5 * (half + least) / R, 0.5 * (half - least) / R) for side in (-1.0, 1.0)]
    outer, seen = ring(on_circle(profile(angle), angle), bearing.outside_radius, bearing.outer_ring, sides)
    rim = on_circle(Ri, around(Ri, [(DOWN, inner_half, fine.raceway)], fine.far))
    inner, under = ring(rim, bearing.bore_radius, bearing.inner_ring, [(DOWN, inner_half / Ri)])
    roller = roller_body(bearing, max(opening, most * r / R) + ROOM, most * r / R + ROOM, fine)
    rings = [(outer, on_circle(profile(seen), seen)), (inner, on_circle(Ri, under) + hub)]
    along = on_circle(1.0, DOWN - ahead / R)
    return Run(roller, r, rings, 0.5 * (R + float(along @ hub) + Ri) * along, step)
