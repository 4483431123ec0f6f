"""Contacts resolved by fine meshes or many modes."""

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import gmsh
import numpy as np
from scipy import sparse
from skfem import (
    Basis,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTri,
    asm,
    condense,
    solve,
)
from skfem.helpers import dot

from lagrange import Bearing
from lagrange.surface.faults import Spall
from tests.reference.modes import Body, Motion, body, separated
from tests.reference.quadratic import graded_circle, mesh_of_section, meshed, plane_strain_stiffness

# ---- A roller squeezed by two Hertz pressures, resolved: quadratic elements, a tenth of a half-width at the
# contacts.


def resolved_disc(radius, material, line_load, half_widths):
    """Stress along the axis of symmetry, from the lower contact to the upper one.

    `half_widths`: of the lower and the upper contact, m; `line_load`, N/m, on both. One half of the disc is meshed.
    Returns y, m, and σ_xx, σ_yy, Pa.
    """
    mesh = _half_disc(radius, half_widths)
    basis = Basis(mesh, ElementVector(ElementTriP2()))
    lam, mu = material.lame_lambda, material.lame_mu

    @LinearForm
    def pressure(v, w):
        x, y = w.x
        arc = radius * np.arctan2(np.abs(x), np.abs(y))
        b = np.where(y < 0.0, half_widths[0], half_widths[1])
        p = 2.0 * line_load / (np.pi * b) * np.sqrt(np.maximum(1.0 - (arc / b) ** 2, 0.0))
        return -p * dot(w.n, v)

    rim = mesh.facets_satisfying(lambda x: np.abs(np.hypot(*x) - radius) < 1e-3 * radius, boundaries_only=True)
    load = asm(pressure, FacetBasis(mesh, ElementVector(ElementTriP2()), facets=rim, intorder=8))
    axis = basis.get_dofs(lambda x: np.abs(x[0]) < 1e-12).all("u^1")
    middle = basis.get_dofs(lambda x: (np.abs(x[0]) < 1e-12) & (np.abs(x[1]) < 1e-12)).all("u^2")
    u = solve(*condense(plane_strain_stiffness(basis, material), load, D=np.concatenate([axis, middle])))

    gradient = basis.interpolate(u).grad
    strain = 0.5 * (gradient + np.swapaxes(gradient, 0, 1))
    linear = basis.with_element(ElementTriP1())
    on_axis = np.flatnonzero(np.abs(mesh.p[0]) < 1e-12)
    on_axis = on_axis[np.argsort(mesh.p[1, on_axis])]
    stress = [2.0 * mu * strain[i, i] + lam * (strain[0, 0] + strain[1, 1]) for i in (0, 1)]
    return mesh.p[1, on_axis], *(linear.project(s)[on_axis] for s in stress)


def _half_disc(radius, half_widths) -> MeshTri:
    """The half x >= 0 of a disc, its nodes closer together towards the contacts at the axis' ends."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo, field = gmsh.model.geo, gmsh.model.mesh.field
        centre, low, high, side = (geo.addPoint(x, y, 0.0) for x, y in ((0, 0), (0, -radius), (0, radius), (radius, 0)))
        arcs = geo.addCircleArc(low, centre, side), geo.addCircleArc(side, centre, high)
        geo.addPlaneSurface([geo.addCurveLoop([*arcs, geo.addLine(high, centre), geo.addLine(centre, low)])])
        geo.synchronize()
        sizes = []
        for end, b in zip((low, high), half_widths, strict=True):
            distance = field.add("Distance")
            field.setNumbers(distance, "PointsList", [end])
            sizes.append(field.add("MathEval"))
            field.setString(sizes[-1], "F", f"Max({0.1 * b}, Min(0.15 * F{distance}, {0.1 * radius}))")
        smallest = field.add("Min")
        field.setNumbers(smallest, "FieldsList", sizes)
        field.setAsBackgroundMesh(smallest)
        for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
            gmsh.option.setNumber(f"Mesh.{option}", 0)
        return mesh_of_section()
    finally:
        gmsh.finalize()


# ---- Roller and rings on meshes that resolve their contacts, the outer ring with a spall cut out of it. Fixed axes,
# the load along −y. The rings' far sides are held.

DOWN = -0.5 * pi
ARC = 0.45  # rad, of an edge that may be touched


@dataclass(frozen=True, kw_only=True)
class Fineness:
    """Lengths of elements' sides, m; nodes lie half as far apart."""

    edge: float = 3e-6  # outer ring at the spall's edges
    raceway: float = 10e-6
    roller: float = 4e-6  # finer than what it rolls on: the rings' nodes meet it anywhere between its own
    far_roller: float = 0.4e-3
    far: float = 1.0e-3
    cutoff: float = 0.7e6  # Hz, of modes


FINE = Fineness()


class Surface(NamedTuple):
    """Contact nodes of a body in order along its surface."""

    body: Body
    position: np.ndarray  # (n, 2), m, on the true surface, not on the polygon
    node: np.ndarray  # (n,), of the body's contact nodes
    angle: np.ndarray  # (n,), rad, seen from the circle's centre; rising


def surface(of: Body, near: float, profile) -> Surface:
    """Nodes on the side of the direction `near`, rad; `profile`: radius at angles from there, rad, m."""
    away = np.angle(np.exp(1j * (np.arctan2(of.points[:, 1], of.points[:, 0]) - near)))
    node = np.flatnonzero(np.abs(away) < 1.0)
    node = node[np.argsort(away[node])]
    angle = away[node] + near
    radius = profile(away[node])
    position = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return Surface(body=of, position=position, node=node, angle=angle)


def on_circle(radius: float, angle: np.ndarray) -> np.ndarray:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def roller_body(bearing: Bearing, lower: float, upper: float, fine: Fineness) -> Body:
    """The roller with fine zones of half-lengths `lower` and `upper`, m, below and above."""
    r = bearing.roller_radius
    zones = [(DOWN - lower / r, DOWN + lower / r, fine.roller), (-DOWN - upper / r, -DOWN + upper / r, fine.roller)]
    rim = on_circle(r, graded_circle(r, zones, fine.far_roller))
    sizes = [(DOWN, lower / r), (-DOWN, upper / r)]

    def touched(x):
        angle = np.arctan2(x[1], x[0])
        return np.any([np.abs(angle - at) <= within + 1e-9 for at, within in sizes], axis=0)

    return body(meshed([rim]), bearing.roller, bearing.roller_length, fine.cutoff, touched, mass=bearing.roller_mass)


def inner_body(bearing: Bearing, half: float, fine: Fineness) -> Body:
    """The inner ring, touched within `half`, m, of its lowest point; its bore is held."""
    R, bore = bearing.inner_raceway_radius, bearing.bore_radius
    rim = on_circle(R, graded_circle(R, [(DOWN - half / R, DOWN + half / R, fine.raceway)], fine.far))
    hole = on_circle(bore, np.linspace(-pi, pi, round(2.0 * pi * bore / fine.far), endpoint=False))

    def touched(x):
        return (np.hypot(*x) > 0.5 * (R + bore)) & (np.abs(np.arctan2(x[1], x[0]) - DOWN) * R <= half + 1e-9)

    def held(x):
        return np.hypot(*x) < bore * (1.0 + 1e-9)

    return body(meshed([rim, hole]), bearing.inner_ring, bearing.roller_length, fine.cutoff, touched, held)


def bare_depth(spall: Spall | None, opening: float, chord: np.ndarray) -> np.ndarray:
    """How far the bare profile lies outside the raceway's circle, m, at places along the chord from its middle."""
    if spall is None:
        return np.zeros_like(chord)
    inside, e = np.clip(opening - np.abs(chord), 0.0, None), spall.edge_radius
    arc = np.where(inside < e, e - np.sqrt(np.maximum(e * e - np.minimum(inside, e) ** 2, 0.0)), np.inf)
    return np.minimum(arc, spall.depth)


def outer_body(bearing: Bearing, spall: Spall | None, half: float, fine: Fineness) -> Body:
    """The outer ring, touched within `half`, m, of its lowest point; its outside is held.

    The spall, in the lowest point, is cut out of the mesh.
    """
    R, outside = bearing.outer_raceway_radius, bearing.outside_radius
    if spall is None:
        angles = graded_circle(R, [(DOWN - half / R, DOWN + half / R, fine.raceway)], fine.far)
        rim = on_circle(R, angles)
    else:
        rim = _spalled_rim(R, spall, spall.half_opening(bearing.roller_radius), half, fine)
    lateral = np.linspace(-pi, pi, round(2.0 * pi * outside / fine.far), endpoint=False)

    def touched(x):
        near = np.abs(np.arctan2(x[1], x[0]) - DOWN) * R <= half + 1e-9
        opening = 0.0 if spall is None else spall.half_opening(bearing.roller_radius)
        arc = 0.0 if spall is None else spall.edge_radius * np.sin(ARC)
        on_top = np.hypot(*x) < R + (0.0 if spall is None else spall.edge_radius * (1.0 - np.cos(ARC))) + 1e-9
        return near & (np.abs(x[0]) >= opening - arc - 1e-9) & on_top

    def held(x):
        return np.hypot(*x) > outside * np.cos(0.51 * fine.far / outside) - 1e-9

    return body(
        meshed([on_circle(outside, lateral), rim]), bearing.outer_ring, bearing.roller_length, fine.cutoff, touched,
        held,
    )  # fmt: skip


def _spalled_rim(R: float, spall: Spall, opening: float, half: float, fine: Fineness) -> np.ndarray:
    """Points of the raceway, the spall's edges and bottom, which is at most as deep as the edges' radius."""
    e, deepest = spall.edge_radius, np.arccos(max(0.0, 1.0 - spall.depth / spall.edge_radius))
    steps, turned = [], 0.0
    while turned < deepest:
        steps.append(fine.edge / e if turned < ARC else min(1.2 * steps[-1], 0.2))
        turned += steps[-1]
    arc = np.concatenate([[0.0], np.cumsum(steps)]) * deepest / turned
    outward = np.cumsum([fine.edge] * round(30e-6 / fine.edge))
    while outward[-1] < half - opening:
        size = outward[-1] - outward[-2]
        outward = np.append(outward, outward[-1] + min(fine.raceway, 1.1 * size))
    inward = opening - e * np.sin(arc)
    floor = np.linspace(-inward[-1], inward[-1], 2 * max(2, round(inward[-1] / 30e-6)) + 1)[1:-1]
    chord = np.concatenate([opening + outward[::-1], inward])
    depth = np.concatenate([np.zeros(outward.size), e * (1.0 - np.cos(arc))])
    chord, depth = np.concatenate([-chord, floor, chord[::-1]]), np.concatenate(
        [depth, np.full(floor.size, spall.depth), depth[::-1]])  # fmt: skip
    turn, beyond = np.arcsin(chord / R), outward[-1] - outward[-2]
    rest = graded_circle(R, [(DOWN + turn[0], DOWN + turn[-1], beyond)], fine.far)
    rest = rest[(rest < DOWN + turn[0] - 1e-9) | (rest > DOWN + turn[-1] + 1e-9)]
    angle = np.concatenate([rest, DOWN + turn])
    radius = np.concatenate([np.full(rest.size, R), R + depth])
    order = np.argsort(angle)
    return radius[order, None] * on_circle(1.0, angle[order])


# ---- A roller that crosses a spall, resolved: every body meshed, the spall with it, contacts node by node, in
# motion. The roller is free, without friction and without spin (a disc's answer does not depend on it).

SETTLING, SETTLINGS = 1e-4, 12  # s, of a step that finds equilibrium; how many
NEAR = 0.5e-6  # m, of gaps looked at in a step: bodies at 1 m/s come nearer by 0.1 µm
ROOM = 0.1e-3  # m, of fine mesh beyond where contacts' middles get


class Crossing(NamedTuple):
    """A roller between two rings, as they lie at the start."""

    roller: Body
    lower: Surface  # of the roller, where it meets the outer ring
    upper: Surface
    outer: Surface
    inner: Surface  # from the hub
    radius: float  # m, of the roller
    hub: np.ndarray  # (2,), m, which stays
    start: np.ndarray  # (2,), m, of the roller's centre, undeformed
    swing: float  # rad/s, of the roller's centre about the outer ring's


def crossing(
    bearing: Bearing, spall: Spall | None, hub, ahead: float, beyond: float, swing: float, fine: Fineness = FINE
) -> Crossing:
    """Mesh all; the roller starts `ahead`, m along the raceway, of the load line and gets as far as `beyond`."""
    R, Ri, r = bearing.outer_raceway_radius, bearing.inner_raceway_radius, bearing.roller_radius
    most, opening = max(ahead, beyond), 0.0 if spall is None else spall.half_opening(r)
    lower, upper = (way + ROOM for way in (max(opening, most * r / R), most * r / R))
    roller = roller_body(bearing, lower, upper, fine)
    inner = inner_body(bearing, most * Ri / R + 1.5 * ROOM, fine)
    outer = outer_body(bearing, spall, most + 1.5 * ROOM, fine)

    def profile(away):
        return R + bare_depth(spall, opening, R * np.sin(away))

    direction = DOWN - ahead / R
    along = np.array([np.cos(direction), np.sin(direction)])
    return Crossing(
        roller=roller, lower=surface(roller, DOWN, lambda away: np.full_like(away, r)),
        upper=surface(roller, -DOWN, lambda away: np.full_like(away, r)), outer=surface(outer, DOWN, profile),
        inner=surface(inner, DOWN, lambda away: np.full_like(away, Ri)), radius=r, hub=np.asarray(hub, dtype=float),
        start=0.5 * (R + float(along @ hub) + Ri) * along, swing=swing,
    )  # fmt: skip


class Gaps(NamedTuple):
    """Between the roller and those nodes of a ring that come near it, and how nodes' moves change them."""

    node: np.ndarray  # (n,), in the ring's surface
    gap: np.ndarray  # (n,), m
    normal: np.ndarray  # (n, 2), from the roller's centre
    by_roller: sparse.csr_matrix  # (n, 2 n_contact)
    by_ring: sparse.csr_matrix


def gaps(ring: Surface, moved: np.ndarray, roller: Surface, strained: np.ndarray, centre, near: float) -> Gaps:
    """Where nodes of a ring, `moved` (n, 2), m, come within `near`, m, of the roller around `centre`.

    `strained` : (n_contact, 2), m, of the roller's contact nodes about its centre
    """
    away = ring.position - centre
    distance = np.hypot(*away.T)
    normal = away / distance[:, None]
    angle = np.arctan2(normal[:, 1], normal[:, 0])
    at = np.clip(np.searchsorted(roller.angle, angle), 1, roller.angle.size - 1)
    beyond = (angle - roller.angle[at - 1]) / (roller.angle[at] - roller.angle[at - 1])
    share = np.stack([1.0 - beyond, beyond], axis=1)
    pair = np.stack([roller.node[at - 1], roller.node[at]], axis=1)
    met = np.einsum("ij,ijk->ik", share, strained[pair])
    gap = distance - np.hypot(*roller.position[0]) + np.sum(normal * (moved - met), axis=1)
    k = np.flatnonzero((beyond >= 0.0) & (beyond <= 1.0) & (gap < near))
    axes, starts = np.arange(2), 2 * np.arange(k.size + 1)
    on_ring = (2 * ring.node[k, None] + axes).ravel()
    on_roller = (2 * pair[k, :, None] + axes).ravel()
    weights = -(share[k, :, None] * normal[k, None, :]).ravel()
    return Gaps(
        node=k, gap=gap[k], normal=normal[k],
        by_roller=sparse.csr_matrix((weights, on_roller, 2 * starts), (k.size, strained.size)),
        by_ring=sparse.csr_matrix((normal[k].ravel(), on_ring, starts), (k.size, 2 * len(ring.body.points))),
    )  # fmt: skip


class Run:
    """The crossing in steps."""

    def __init__(self, of: Crossing, step: float):
        self.of = of
        self.roller, self.outer, self.inner = (Motion(b, step) for b in (of.roller, of.outer.body, of.inner.body))
        self.pushed = [np.zeros(ring.node.size, dtype=bool) for ring in (of.outer, of.inner)]
        self.pressures = [np.zeros(ring.node.size) for ring in (of.outer, of.inner)]  # N, on each node

    def settle(self) -> np.ndarray:
        """Find the equilibrium of the roller on its orbit and set it going; forces as `advance` has them."""
        moving = self.roller, self.outer, self.inner
        still = [Motion(motion.body, SETTLING, still=True) for motion in moving]
        self.roller, self.outer, self.inner = still
        still[0].load = self.of.roller.translation @ (self.of.swing**2 * self.of.start)
        for _ in range(SETTLINGS):
            forces = self.advance(near=np.inf)
        centre, swing = self.centre, self.of.swing
        self.roller, self.outer, self.inner = moving
        for motion, found in zip(moving, still, strict=True):
            motion.q, motion.stored = found.q, found.stored
        self.throw(swing * np.array([-centre[1], centre[0]]))
        self.roller.a = self.roller.body.translation @ (-(swing**2) * centre)
        return forces

    def throw(self, velocity: np.ndarray) -> None:
        """Give the roller a velocity, (2,), m/s."""
        self.roller.v = self.roller.body.translation @ velocity

    @property
    def centre(self) -> np.ndarray:
        """Of the roller's mass, (2,), m."""
        return self.of.start + self.roller.mean(self.roller.q)

    @property
    def energy(self) -> np.ndarray:
        """Kinetic and elastic, J, of roller, outer and inner ring, (3, 2)."""
        return np.array([motion.energy for motion in (self.roller, self.outer, self.inner)])

    def advance(self, near: float = NEAR) -> np.ndarray:
        """Take a step; forces of the outer and the inner raceway on the roller, (2, 2), N."""
        of, rings = self.of, (self.outer, self.inner)
        for motion in (self.roller, *rings):
            motion.expect()
        shift = self.roller.mean(self.roller.expected)
        strained = self.roller.expected_moves - shift
        below = gaps(of.outer, self.outer.expected_moves[of.outer.node], of.lower, strained, of.start + shift, near)
        above = gaps(
            of.inner, self.inner.expected_moves[of.inner.node], of.upper, strained, of.start + shift - of.hub, near
        )
        both = sparse.vstack([below.by_roller, above.by_roller]).tocsr()
        compliance = both @ (both @ self.roller.compliance).T
        n = below.node.size
        parts = slice(0, n), slice(n, None)
        for part, found, ring in zip(parts, (below, above), rings, strict=True):
            compliance[part, part] += found.by_ring @ (found.by_ring @ ring.compliance).T
        active = [pushed[found.node] for pushed, found in zip(self.pushed, (below, above), strict=True)]
        force = separated(np.concatenate([below.gap, above.gap]), compliance, np.concatenate(active))
        self.roller.advance(both.T @ force)
        for k, (part, found, ring) in enumerate(zip(parts, (below, above), rings, strict=True)):
            ring.advance(found.by_ring.T @ force[part])
            self.pressures[k][:] = 0.0
            self.pressures[k][found.node] = force[part]
            self.pushed[k] = self.pressures[k] > 0.0
        return -np.array([below.normal.T @ force[parts[0]], above.normal.T @ force[parts[1]]])
