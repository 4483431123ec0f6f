"""A bearing made discrete: bodies and contacts, what every contact model answers, what statics give and need."""

from dataclasses import dataclass
from math import ceil, inf, log2, pi
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy import sparse

from fem.contacts.points import POINTS_PER_NODE, Shares, hertz_patch, points, push
from fem.elastic.bodies import DiscBody, RingBody, disc_body, rigid_body, ring_body
from fem.kernels.columns import INNER, OUTER
from fem.kernels.elements.state import Points
from fem.kernels.elements.surfaces import N_NODES, chord
from fem.kernels.law import Law
from lagrange import Bearing
from lagrange.kinematics import roller_angles
from lagrange.surface.deviation import Turns
from meshes import BearingShapes, bearing_shapes

# what of a spring k counts on each of two elastic bodies; on an elastic one that meets a rigid one, and on the latter
EVENLY, LIGHT, HEAVY = 2.0, 10.0 / 9.0, 10.0
CLOSED_NODES = 12  # of a contact closed over so many, the middle knows no end
REACH = 2.0  # and of those of statics, over that at the expected force
FAINT = 0.05  # of the largest force: contacts expected to carry less get the points of this one
GROWN_PASSES = 2  # each leaves ρω²r²/(λ + 2μ) of what growth was off by, some 0.3 % at most


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Angles and angular speeds of an instant. rad, rad/s; arrays (n_rollers,)."""

    roller_angle: np.ndarray  # of the rollers' centres, from +x
    roller_turn: np.ndarray  # each roller's own frame
    ring_turn: float = 0.0  # the inner ring's frame
    cage_speed: float = 0.0
    roller_speed: float = 0.0
    ring_speed: float = 0.0
    outer_turn: float = 0.0  # of the outer ring
    outer_speed: float = 0.0

    @property
    def radial(self) -> np.ndarray:
        """Unit vectors from the outer ring's centre to the rollers, (n_rollers, 2)."""
        return np.column_stack([np.cos(self.roller_angle), np.sin(self.roller_angle)])

    @property
    def around(self) -> np.ndarray:
        """Unit vectors along the rollers' path, counter-clockwise, (n_rollers, 2)."""
        return np.column_stack([-np.sin(self.roller_angle), np.cos(self.roller_angle)])

    @property
    def turns(self) -> Turns:
        """Rotation of the bodies, from which the place on a surface with defects follows."""
        return Turns(inner_ring=self.ring_turn, rollers=self.roller_turn, outer_ring=self.outer_turn)


def standing(bearing: Bearing, first_roller_angle: float) -> Motion:
    """Nothing turns; the first roller's angle from +x, rad."""
    return Motion(roller_angle=roller_angles(bearing, first_roller_angle), roller_turn=np.zeros(bearing.n_rollers))


class Unloaded(NamedTuple):
    """What the bodies of finite elements do without forces at their contacts."""

    inner_growth: np.ndarray  # (n_rows, 2, n_sectors), m, by centrifugal load and own weight
    outer_sag: np.ndarray  # (n_rows, 2, n_sectors), m, by own weight, by how it is held and by centrifugal load
    roller_growth: np.ndarray  # (2 n_nodes,), m


@dataclass(frozen=True, kw_only=True)
class Reduced:
    """A bearing of finite elements reduced to points that carry its contacts' forces, and the nodes that they push."""

    contact: np.ndarray  # (n_points,), whose point it is: inner contacts first, then outer ones
    closing: np.ndarray  # (n_points,), m, by other loads, less how far the surfaces lie apart when the contact touches
    compliance: np.ndarray  # (n_points, n_points), m/N
    free: Unloaded
    across: np.ndarray  # (n_points,), m, from the line of centres along the tangent
    bodies: tuple[DiscBody, RingBody, RingBody]  # roller, inner and outer ring
    loads: list  # per ring and roller: points, `surface_places` of nodes, (2 nodes, points) forces of unit forces there

    def sums(self, forces: np.ndarray) -> np.ndarray:
        """Forces of contacts, (2 n_rollers,), N, by those of points."""
        return np.bincount(self.contact, forces, minlength=2 * (len(self.loads) - 2))

    def fields(self, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Displacements under the points' forces, N: both rings', polar, and the rollers', (n_rollers, n_nodes, 2)."""
        (disc, *rings), free, fields = self.bodies, (self.free.inner_growth, self.free.outer_sag), []
        for ring, growth, (mine, places, pushed) in zip(rings, free, self.loads, strict=False):
            nodal = np.zeros((ring.n_rows, 2, ring.n_sectors))
            nodal.reshape(-1)[places] = -(pushed @ forces[mine])
            fields.append(growth + ring.held(nodal))
        n = len(self.loads) - 2
        nodal = np.zeros((2 * disc.n_nodes, n))
        for roller, (mine, places, pushed) in enumerate(self.loads[2:]):
            nodal[places, roller] = -(pushed @ forces[mine])
        rollers = disc.relaxed(nodal) + self.free.roller_growth[:, None]
        return *fields, rollers.T.reshape(n, -1, 2).copy()


def unloaded(model, motion: Motion, gravity: float) -> Unloaded:
    """The bodies in motion. A roller's weight is a uniform load: it deforms only through contacts."""
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    mass, roller = np.repeat(disc.mass, 2), np.zeros(2 * disc.mass.size)
    for _ in range(1 + GROWN_PASSES):  # what spins carries around what it has grown by
        roller = disc.relaxed(motion.roller_speed**2 * mass * (disc.points.ravel() + roller))
    sag = outer.sag(gravity)
    if motion.outer_speed != 0.0 or motion.outer_turn != 0.0:
        sag = _spun(outer, motion.outer_speed) + outer.held(outer.body_load(gravity, motion.outer_turn))
    growth = _spun(inner, motion.ring_speed) + inner.held(inner.body_load(gravity, motion.ring_turn))
    return Unloaded(inner_growth=growth, outer_sag=sag, roller_growth=roller)


def _spun(ring, speed):
    """Growth of a ring that turns at a speed, rad/s, (n_rows, 2, n_sectors), m."""
    load, found = ring.body_load(0.0, 0.0, speed), np.zeros((ring.n_rows, 2, ring.n_sectors))
    for _ in range(1 + GROWN_PASSES):
        found = ring.held(load + speed**2 * ring.row_mass[:, None, None] * found)
    return found


class KernelData(NamedTuple):
    """Constants of a contact model for the time loop; laws and ripples by kind of contact."""

    laws: tuple[Law, ...]
    ripples: tuple[np.ndarray, ...]  # of the raceways and the rollers; empty without a law below the grid
    units: tuple[int, ...]  # of `Patches`
    neighbourly: float  # surface nodes; contacts as near as that push nodes of each other's
    facet_depth: float = 0.0  # m, by which both surfaces of a contact may lie below their circles
    points: Points | None = None
    shear_levels: tuple[float, ...] | None = None  # of `Shear`, by kind; None: no tangential springs
    whole_levels: tuple[float, ...] | None = None  # by kind, of `Dampers`; None: there can't be any


@dataclass(frozen=True, kw_only=True)
class Model:
    """Everything about a bearing that its mesh and its contact model decide. A contact model is a class of its own.

    `kind` of contact is INNER, OUTER or ROLLER, the place of its law in `laws`.
    """

    bearing: Bearing
    roller: DiscBody
    inner_ring: RingBody
    outer_ring: RingBody
    inner_law: Any  # of inner raceway and roller; has a `pair`, `approach` and `softness`
    outer_law: Any  # of outer raceway and roller
    roller_law: Any  # of two rollers

    shapes: ClassVar = staticmethod(bearing_shapes)  # of the bodies at a surface spacing, m
    coarsest: ClassVar[float] = inf  # surface spacing over a half-width at which the model is still good
    # a law below the grid, with tangential springs, of a contact as a whole on any surfaces; else points, on perfect
    # circles, that stand as wide as forces make contacts
    has_law: ClassVar[bool] = False
    is_made_for_a_force: ClassVar[bool] = False  # points stand where the largest static force needs them
    static_passes: ClassVar[int] = 2  # contacts sit along the lines of centres, which the solution moves
    shares: ClassVar[Shares]  # of points among nodes
    nodes_beyond: ClassVar[float] = 3.0  # that the outermost points push beside those under them
    failure_hint: ClassVar[str] = ""  # what else to try where velocities are lost
    stress_note: ClassVar[str | None] = None  # how the mesh carries contacts, where pictures add nothing to its stress

    @classmethod
    def build(cls, bearing: Bearing, mesh_size: float, largest_force: float = 0.0, stiffness: float = 0.0) -> "Model":
        """Mesh and assemble a bearing at a surface spacing, m.

        For the largest static force of a contact, N, with springs of a stiffness, N/m, where models have such.
        """
        raise NotImplementedError

    def places(self, forces: np.ndarray) -> list[np.ndarray]:
        """Points of each contact, m along the tangent, by expected forces, (2 n_rollers,), N."""
        laws, faintest = np.repeat(self.laws[:2], self.bearing.n_rollers), FAINT * forces.max()
        halves = [law.half_count(max(force, faintest), REACH) for law, force in zip(laws, forces, strict=True)]
        return [law.places(max(2, half)) for law, half in zip(laws, halves, strict=True)]

    def beside(self, kind: int, on_ring: np.ndarray, on_roller: np.ndarray) -> np.ndarray:
        """Compliance between a contact's points, at angles on both bodies, beside the meshes', m/N."""
        return self.laws[kind].local_compliance(on_ring.size)

    def reduced(self, motion: Motion, free: Unloaded, place: np.ndarray, forces: np.ndarray) -> Reduced:
        """The bearing reduced to its contacts with hub and radii at `place`, (n_rollers + 2,), m.

        `free` : motion of the bodies without contact forces
        `forces` : (2 n_rollers,), N, expected, of inner contacts and then of outer ones; not asked for by all models
        """
        n, disc, rings = self.bearing.n_rollers, self.roller, (self.inner_ring, self.outer_ring)
        to_roller, each = motion.radial * place[2:, None] - place[:2], self.places(forces)
        line = np.concatenate([np.arctan2(to_roller[:, 1], to_roller[:, 0]), motion.roller_angle])
        across, contact = np.concatenate(each), np.repeat(np.arange(2 * n), [some.size for some in each])
        kind, j, turn = contact // n, contact % n, np.array([motion.ring_turn, motion.outer_turn])
        radii = np.array([law.pair.radii for law in self.laws])[kind].T
        angles = np.arcsin(across / np.abs(radii))
        on_ring = line[contact] + angles[0] - turn[kind]
        on_roller = line[contact] + np.where(kind == INNER, pi - angles[1], angles[1]) - motion.roller_turn[j]
        rise = np.sum(radii * (1.0 - np.cos(angles)), axis=0)
        sectors = np.array([ring.n_surface for ring in rings])[kind]
        for side, (angle, nodes) in enumerate(((on_ring, sectors), (on_roller, disc.n_surface))):
            depth = np.array([getattr(law, "sagitta", (0.0, 0.0))[side] for law in self.laws])[kind]
            if depth.any():  # how far facets lie below the circle
                rise += depth * np.array([chord(x)[0] for x in np.mod(angle * nodes / (2.0 * pi), 1.0)])
        compliance, growth, loads = np.zeros((across.size, across.size)), np.zeros(across.size), []
        for c in range(2 * n):
            mine = np.flatnonzero(contact == c)
            compliance[np.ix_(mine, mine)] = self.beside(c // n, on_ring[mine], on_roller[mine])

        def load(mine, body, angle, size, field):
            nodes, pushed = push(body, angle[mine], size, self.shares)
            places = body.surface_places(nodes)
            compliance[np.ix_(mine, mine)] += pushed.T @ body.surface_influence(nodes) @ pushed
            growth[mine] += pushed.T @ field.ravel()[places]
            loads.append((mine, places, pushed))

        for k, (ring, field) in enumerate(zip(rings, (free.inner_growth, free.outer_sag), strict=True)):
            mine = np.flatnonzero(kind == k)
            outward = (1.0 if k == INNER else -1.0) / np.cos(angles[0, mine])
            load(mine, ring, on_ring, outward, field)
        for roller in range(n):
            mine = np.flatnonzero(j == roller)
            load(mine, disc, on_roller, 1.0 / np.cos(angles[1, mine]), free.roller_growth)
        return Reduced(
            contact=contact, closing=growth - rise, compliance=compliance, across=across, bodies=(disc, *rings),
            loads=loads, free=free,
        )  # fmt: skip

    def springs(self, force: float, sticks: bool = False) -> dict[str, sparse.csc_matrix]:
        """Closed contacts on each kind of body at a force, N: columns that make `column @ column.T` a stiffness, N/m.

        A roller has one contact of each kind, apart from each other. Of points those over CLOSED_NODES nodes. Where
        contacts stick, their tangential springs too, if the model has such.
        """
        half = POINTS_PER_NODE * CLOSED_NODES // 2

        def on(body, kind, angle=0.0):
            """A contact's, at an angle of a body."""
            law = self.laws[kind]
            nodes, pushed = push(body, angle + law.places(half) / body.section.loaded, 1.0, self.shares)
            found = sparse.lil_matrix((body.points.size, pushed.shape[1]))
            own = np.linalg.inv(law.local_compliance(pushed.shape[1]))
            found[body.surface_places(nodes)] = pushed @ np.linalg.cholesky(EVENLY * own)
            return found.tocsc()

        on_roller = [on(self.roller, kind, 2.0 * pi * kind / 3.0) for kind in range(3)]
        rings = {"inner_ring": on(self.inner_ring, INNER), "outer_ring": on(self.outer_ring, OUTER)}
        return {"roller": sparse.hstack(on_roller).tocsc()} | rings

    def kernel_data(self, largest_force: float) -> KernelData:
        """What the time loop needs; with room for contacts wider than the largest static force, N, makes them."""
        found, pairs = points(self.laws, largest_force, self.bearing.n_rollers), [law.pair for law in self.laws]
        nodes = self.inner_ring.n_surface, self.outer_ring.n_surface, self.roller.n_surface
        places = zip(((INNER, 0), (OUTER, 0), (INNER, 1)), nodes, strict=True)
        widest = max(np.abs(found.shift[at]).max() * count / pi for at, count in places)
        # as many entries as patches need units of six nodes: a power of two, as each is compiled for itself
        units = (0,) * 2 ** max(0, ceil(log2((widest + self.nodes_beyond) / N_NODES)))
        return KernelData(
            laws=tuple(Law(0.0, 0.0, 0.0, pair.half_width_factor, 1.0 / pair.relative_radius) for pair in pairs),
            ripples=(np.zeros(0),) * 3, units=units, points=found, neighbourly=N_NODES * len(units),
            facet_depth=float(np.abs(found.sagitta).sum(axis=1).max()),
        )  # fmt: skip

    def carried(self, kind: int, n_surface: int, angle: float, radius: float, force: float):
        """Nodes of a surface that carry a contact force, N, at an angle, their shares, and the angle less theirs."""
        half_width = self.laws[kind].pair.half_width(abs(force))
        return hertz_patch(n_surface, angle, half_width / radius, self.shares)

    def stiffnesses(self, force: float, sticks: bool) -> np.ndarray:
        """Stiffnesses of an inner, an outer and a roller's contact, (3,), N/m, at a force, N; bodies may be rigid.

        Where contacts stick it is the larger of the normal and the tangential one.
        """
        raise NotImplementedError

    def smeared(self, spacing: float, half_width: float) -> float | None:
        """Node spacing, m, of the patch that pictures exchange for Hertz's pressure; None: the mesh has that."""
        return None

    def indentation(self, kind: int, force: np.ndarray) -> np.ndarray:
        """Part of the approach, m, under forces, N, that no node shows."""
        return np.zeros_like(force)

    def give(self, load: float) -> float:
        """Deflection of a sound contact under the load at the hub, N, beyond that of elastic bodies, m."""
        return 0.0

    laws = property(lambda self: (self.inner_law, self.outer_law, self.roller_law))  # by kind of contact

    @classmethod
    def of(cls, bearing: Bearing, bodies: dict[str, DiscBody | RingBody], laws, **more: Any) -> "Model":
        """From bodies by name and laws by kind of contact."""
        named = zip(("inner_law", "outer_law", "roller_law"), laws, strict=True)
        return cls(bearing=bearing, **bodies, **dict(named), **more)

    @property
    def n_nodes(self) -> int:
        """Number of nodes of all elastic bodies."""
        rings = sum(len(ring.points) for ring in self._elastic_rings)
        return self.bearing.n_rollers * (0 if self.roller.material.rigid else self.roller.n_nodes) + rings

    @property
    def degrees_of_freedom(self) -> int:
        """Number of free ones: two per node off the held circles, two of the hub, three of a rigid roller."""
        of_a_roller = 3 if self.roller.material.rigid else 2 * self.roller.n_nodes
        rings = sum(ring.n_free_nodes for ring in self._elastic_rings)
        return self.bearing.n_rollers * of_a_roller + 2 * rings + 2

    @property
    def _elastic_rings(self):
        return [ring for ring in (self.inner_ring, self.outer_ring) if not ring.material.rigid]


def assembled_bodies(bearing: Bearing, shapes: BearingShapes) -> dict[str, DiscBody | RingBody]:
    """Bodies as the entries of a `Model`."""
    thickness = bearing.roller_length
    bodies = {
        "roller": disc_body(shapes.roller, bearing.roller.elastic, thickness),
        "inner_ring": ring_body(shapes.inner_ring, bearing.inner_ring.elastic, thickness, held_inside=True),
        "outer_ring": ring_body(shapes.outer_ring, bearing.outer_ring.elastic, thickness, held_inside=False),
    }
    return {name: rigid_body(body) if getattr(bearing, name).rigid else body for name, body in bodies.items()}
