"""Contacts of pressure points: where they are, which nodes they push, what they add to the step's stiffness.

A patch of six nodes around a force carries it, or the two beside it. Contacts that the mesh resolves, those whose
points are spread over patches, and the one point of a penalty spring have this in common; `PointLaw` and `PointModel`
are what differs."""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, log2, pi
from typing import Any, ClassVar

import numpy as np
from scipy import sparse

from fem.contacts.contact_law import NoLaw
from fem.contacts.critical_step import EVENLY
from fem.contacts.model import KernelData, Model, Motion, Reduced, Unloaded
from fem.elastic.bodies import DiscBody, RingBody
from fem.kernels.fields import filled
from fem.kernels.patches import N_NODES, chord, first_node, weights
from fem.kernels.state import INNER, OUTER, Law, Points, Spread
from lagrange.contact.hertz import Pair

HERTZ_POINTS = 64
Shares = Callable[[np.ndarray, int], tuple[np.ndarray, np.ndarray]]  # `hats` or `patches`


def patch(n_surface: int, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, weights and angular offsets (contact minus node, rad) of the patch at an angle; each (6,)."""
    position = angle * n_surface / (2.0 * pi)
    base = int(np.floor(position))
    weight = np.array(weights(position - base))
    nodes = first_node(base) + np.arange(N_NODES)
    return nodes % n_surface, weight, (position - nodes) * (2.0 * pi / n_surface)


def ring_patch_force(ring: RingBody, angle: float) -> np.ndarray:
    """Nodal forces (n_rows, 2, n_sectors) of a unit force along the outward radius at `angle` of the raceway."""
    nodes, weight, offset = patch(ring.n_sectors, angle)
    force = np.zeros((ring.n_rows, 2, ring.n_sectors))
    np.add.at(force, (ring.raceway_row, 0, nodes), weight * np.cos(offset))
    np.add.at(force, (ring.raceway_row, 1, nodes), weight * np.sin(offset))
    return force


def disc_patch_force(disc: DiscBody, angle: float) -> np.ndarray:
    """Nodal forces (2 n_nodes,) of a unit force along the outward radius at `angle` of the surface."""
    nodes, weight, _ = patch(disc.shape.surface_nodes, angle)
    force = np.zeros((disc.n_nodes, 2))
    np.add.at(force, disc.first_surface_node + nodes, np.outer(weight, [np.cos(angle), np.sin(angle)]))
    return force.ravel()


def _tangential(weight: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Shares of a unit traction that the nodes of a patch carry, radial and counter-clockwise, (2, 6).

    See `fem.kernels.surfaces`: exact for the force and for its moment.
    """
    c, s = np.cos(offset), np.sin(offset)
    slope, scale = -weight @ s, 1.0 / (1.0 + weight @ c)
    return weight * scale * np.stack([slope * c - s, 1.0 + c + slope * s])


def ring_patch_traction(ring: RingBody, angle: float) -> np.ndarray:
    """Nodal forces (n_rows, 2, n_sectors) of a unit traction counter-clockwise along the raceway at `angle`."""
    nodes, weight, offset = patch(ring.n_sectors, angle)
    force = np.zeros((ring.n_rows, 2, ring.n_sectors))
    np.add.at(force[ring.raceway_row], (slice(None), nodes), _tangential(weight, offset))
    return force


def disc_patch_traction(disc: DiscBody, angle: float) -> np.ndarray:
    """Nodal forces (2 n_nodes,) of a unit traction counter-clockwise along the surface at `angle`."""
    nodes, weight, offset = patch(disc.shape.surface_nodes, angle)
    radial, around = _tangential(weight, offset)
    c, s = np.cos(angle - offset), np.sin(angle - offset)
    force = np.zeros((disc.n_nodes, 2))
    np.add.at(force, disc.first_surface_node + nodes, np.stack([radial * c - around * s, radial * s + around * c], 1))
    return force.ravel()


def patches(angle: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the patches around points at angles, (m,), and each node's share of each point, (m, n_angles)."""
    position = angle * n_nodes / (2.0 * pi)
    base = np.floor(position)
    weight = np.array([weights(beyond) for beyond in position - base])
    found = (first_node(0) + base[:, None].astype(int) + np.arange(N_NODES)) % n_nodes
    nodes, where = np.unique(found, return_inverse=True)
    share = np.zeros((nodes.size, angle.size))
    np.add.at(share, (where.ravel(), np.repeat(np.arange(angle.size), N_NODES)), weight.ravel())
    return nodes, share


def hats(angle: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """The two nodes beside each of some points instead; as `patches`."""
    position = angle * n_nodes / (2.0 * pi)
    base = np.floor(position).astype(int)
    beyond = position - base
    nodes = np.unique(np.concatenate([base, base + 1]) % n_nodes)
    share = np.zeros((nodes.size, angle.size))
    column = np.arange(angle.size)
    np.add.at(share, (np.searchsorted(nodes, base % n_nodes), column), 1.0 - beyond)
    np.add.at(share, (np.searchsorted(nodes, (base + 1) % n_nodes), column), beyond)
    return nodes, share


def ring_push(ring: RingBody, angle: np.ndarray, size: np.ndarray, shares: Shares) -> tuple[np.ndarray, np.ndarray]:
    """Raceway nodes and their polar forces under forces along the radius at angles: (m,), (2 m, n_angles)."""
    nodes, share = shares(angle, ring.n_sectors)
    off = angle[None, :] - (2.0 * pi / ring.n_sectors) * nodes[:, None]
    push = np.stack([share * np.cos(off), share * np.sin(off)], axis=1) * size
    return nodes, push.reshape(2 * nodes.size, -1)


def disc_push(disc: DiscBody, angle: np.ndarray, size: np.ndarray, shares: Shares) -> tuple[np.ndarray, np.ndarray]:
    """Surface nodes and their forces under forces along the outward radius at angles: (m,), (2 m, n_angles)."""
    nodes, share = shares(angle, disc.shape.surface_nodes)
    push = np.stack([share * np.cos(angle), share * np.sin(angle)], axis=1) * size
    return nodes, push.reshape(2 * nodes.size, -1)


def hertz_patch(
    n_surface: int, angle: float, half_width: float, shares: Shares
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A Hertz pressure of a half-width in rad as nodal forces: nodes, shares, and the contact's angle less theirs."""
    place = pi * np.arange(1, HERTZ_POINTS + 1) / (HERTZ_POINTS + 1)  # Gauss-Chebyshev points of the second kind
    nodes, share = shares(angle + half_width * np.cos(place), n_surface)
    offset = np.mod(angle - (2.0 * pi / n_surface) * nodes + pi, 2.0 * pi) - pi
    return nodes, share @ (2.0 / (HERTZ_POINTS + 1) * np.sin(place) ** 2), offset


POINTS_PER_NODE = 4  # of resolved contacts
CLOSED_NODES = 12  # of a contact closed over so many, the middle knows no end
SPAN = 3.0  # half-range of the time loop's points over the half-width at the largest static force
REACH = 2.0  # and of those of statics, over that at the expected force
FAINT = 0.05  # of the largest force: contacts expected to carry less get the points of this one


@dataclass(frozen=True, kw_only=True)
class PointLaw(NoLaw):
    """A pair of surfaces pressed together at points."""

    pair: Pair
    spacing: float  # of the points, m

    point_stiffness: ClassVar[float] = 0.0  # force per penetration of one point, N/m
    sagitta: ClassVar[tuple[float, float]] = (0.0, 0.0)  # of both sides' facets, m, negative in a bore

    def half_count(self, force: float, span: float) -> int:
        """Points on either side of the line of centres, up to `span` half-widths at a force, N."""
        return ceil(span * self.pair.half_width(force) / self.spacing)

    def most(self, largest_force: float) -> int:
        """Points on either side that the time loop needs at the largest static force, N."""
        return self.half_count(largest_force, SPAN)

    def places(self, half_count: int) -> np.ndarray:
        """Points along the tangent, m, from the line of centres, (2 half_count,), or as many as there may be."""
        return (np.arange(-half_count, half_count) + 0.5) * self.spacing

    def local_compliance(self, n_points: int) -> np.ndarray:
        """Compliance between neighbouring points beside the mesh's, (n_points, n_points), m/N."""
        raise NotImplementedError

    @staticmethod
    def spread(laws: tuple, n_points: int, n_rollers: int) -> Spread | None:
        """What the time loop needs of points whose forces are spread over patches; None where a layer resists."""
        return None


@dataclass(frozen=True, kw_only=True)
class PointModel(Model):
    """A bearing whose contacts are carried by points, without a law of the contact as a whole."""

    static_passes: ClassVar[int] = 2
    shares: ClassVar[Shares]  # of points among nodes
    nodes_beyond: ClassVar[float] = 3.0  # that the outermost points push beside those under them

    def places(self, forces: np.ndarray) -> list[np.ndarray]:
        """Points of each contact, m along the tangent, by expected forces, (2 n_rollers,), N."""
        n, faintest = self.bearing.n_rollers, FAINT * forces.max()
        halves = [self.laws[c // n].half_count(max(force, faintest), REACH) for c, force in enumerate(forces)]
        return [self.laws[c // n].places(max(2, half)) for c, half in enumerate(halves)]

    def beside(self, kind: int, on_ring: np.ndarray, on_roller: np.ndarray) -> np.ndarray:
        """Compliance between a contact's points, at angles on both bodies, beside the meshes', m/N."""
        return self.laws[kind].local_compliance(on_ring.size)

    def reduced(self, motion: Motion, free: Unloaded, place: np.ndarray, forces: np.ndarray) -> "PointResponses":
        n, disc, rings = self.bearing.n_rollers, self.roller, (self.inner_ring, self.outer_ring)
        line, each = motion.lines_of_centres(place), self.places(forces)
        across, contact = np.concatenate(each), np.repeat(np.arange(2 * n), [some.size for some in each])
        kind, j, turn = contact // n, contact % n, np.array(motion.ring_turns)
        radii = np.array([law.pair.radii for law in self.laws])[kind].T
        angles = np.arcsin(across / np.abs(radii))
        on_ring = line[contact] + angles[0] - turn[kind]
        on_roller = line[contact] + np.where(kind == INNER, pi - angles[1], angles[1]) - motion.roller_turn[j]
        rise = np.sum(radii * (1.0 - np.cos(angles)), axis=0)
        sectors = np.array([ring.n_sectors for ring in rings])[kind]
        for side, (angle, nodes) in enumerate(((on_ring, sectors), (on_roller, disc.shape.surface_nodes))):
            depth = np.array([getattr(law, "sagitta", (0.0, 0.0))[side] for law in self.laws])[kind]
            if depth.any():  # how far facets lie below the circle
                rise += depth * np.array([chord(x)[0] for x in np.mod(angle * nodes / (2.0 * pi), 1.0)])
        compliance, growth, loads = np.zeros((across.size, across.size)), np.zeros(across.size), []
        for c in range(2 * n):
            mine = np.flatnonzero(contact == c)
            compliance[np.ix_(mine, mine)] = self.beside(c // n, on_ring[mine], on_roller[mine])

        def load(mine: np.ndarray, body, pushed: tuple[np.ndarray, np.ndarray], field: np.ndarray) -> None:
            nodes, push = pushed
            compliance[np.ix_(mine, mine)] += push.T @ body.surface_influence(nodes) @ push
            growth[mine] += push.T @ field[nodes].ravel()
            loads.append((mine, nodes, push))

        for k, (ring, field) in enumerate(zip(rings, (free.inner_growth, free.outer_sag), strict=True)):
            mine = np.flatnonzero(kind == k)
            outward = (1.0 if k == INNER else -1.0) / np.cos(angles[0, mine])
            load(mine, ring, ring_push(ring, on_ring[mine], outward, self.shares), field[ring.raceway_row].T)
        swelling = free.roller_growth.reshape(-1, 2)[disc.first_surface_node :]
        for roller in range(n):
            mine = np.flatnonzero(j == roller)
            load(mine, disc, disc_push(disc, on_roller[mine], 1.0 / np.cos(angles[1, mine]), self.shares), swelling)
        return PointResponses(
            contact=contact, closing=growth - rise, compliance=compliance, across=across, bodies=(disc, *rings),
            loads=loads, free=free,
        )  # fmt: skip

    def springs(self, force: float) -> dict[str, sparse.csc_matrix]:
        """See `Model.springs`: the points' own stiffness over as many as lie over CLOSED_NODES nodes, at any force."""
        disc, half = self.roller, POINTS_PER_NODE * CLOSED_NODES // 2
        on_roller = []
        for kind, law in enumerate(self.laws):
            angle = law.places(half) / disc.shape.radius + 2.0 * pi * kind / 3.0
            nodes, push = disc_push(disc, angle, 1.0, self.shares)
            on_roller.append(_embedded(push, 2 * (disc.first_surface_node + nodes), 1, 2 * disc.n_nodes, law))
        found = {"roller": sparse.hstack(on_roller).tocsc()}
        for name, ring, law in (
            ("inner_ring", self.inner_ring, self.inner_law),
            ("outer_ring", self.outer_ring, self.outer_law),
        ):
            nodes, push = ring_push(ring, law.places(half) / ring.raceway_radius, 1.0, self.shares)
            first = ring.raceway_row * 2 * ring.n_sectors + nodes
            found[name] = _embedded(push, first, ring.n_sectors, 2 * ring.n_rows * ring.n_sectors, law)
        return found

    def kernel_data(self, largest_force: float) -> KernelData:
        """See `Model.kernel_data`: the points, and room for patches that hold every node under them."""
        found = points(self.laws, largest_force, self.bearing.n_rollers)
        units, pairs = self._patch_units(found), [law.pair for law in self.laws]
        return KernelData(
            laws=tuple(Law(0.0, 0.0, 0.0, pair.half_width_factor, 1.0 / pair.relative_radius) for pair in pairs),
            ripples=(np.zeros(0),) * 3,
            units=units,
            points=found,
            shear_levels=None,
            neighbourly=N_NODES * len(units),
            facet_depth=float(np.abs(found.sagitta).sum(axis=1).max()),
        )

    def _patch_units(self, found: Points) -> tuple[int, ...]:
        """As many entries as patches need units of six nodes: a power of two, as each is compiled for itself."""
        nodes = self.inner_ring.n_sectors, self.outer_ring.n_sectors, self.roller.shape.surface_nodes
        widest = max(
            2.0 * np.abs(found.shift[kind, side]).max() * count / (2.0 * pi)
            for (kind, side), count in zip(((INNER, 0), (OUTER, 0), (INNER, 1)), nodes, strict=True)
        )
        return (0,) * 2 ** max(0, ceil(log2((widest + self.nodes_beyond) / N_NODES)))

    def carried(self, kind: int, n_surface: int, angle: float, radius: float, force: float):
        """See `Model.carried`: Hertz's pressure over the points' nodes."""
        half_width = self.laws[kind].pair.half_width(abs(force))
        return hertz_patch(n_surface, angle, half_width / radius, self.shares)


@dataclass(frozen=True, kw_only=True)
class PointResponses(Reduced):
    """Points, and the nodes that they push."""

    across: np.ndarray  # (n_points,), m, from the line of centres along the tangent
    bodies: tuple[DiscBody, RingBody, RingBody]  # roller, inner and outer ring
    loads: list  # per ring and roller: (points, nodes, (2 nodes, points) nodal forces of unit forces)

    def fields(self, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        disc, *rings = self.bodies
        fields = []
        for ring, growth, (mine, nodes, push) in zip(
            rings, (self.free.inner_growth, self.free.outer_sag), self.loads[:2], strict=True
        ):
            nodal = np.zeros((ring.n_rows, 2, ring.n_sectors))
            nodal[ring.raceway_row][:, nodes] = -(push @ forces[mine]).reshape(-1, 2).T
            fields.append(growth + ring.held(nodal))
        n = len(self.loads) - 2
        nodal = np.zeros((disc.n_nodes, 2, n))
        for roller, (mine, nodes, push) in enumerate(self.loads[2:]):
            nodal[disc.first_surface_node + nodes, :, roller] = -(push @ forces[mine]).reshape(-1, 2)
        rollers = disc.relaxed(nodal.reshape(-1, n)) + self.free.roller_growth[:, None]
        return *fields, rollers.T.reshape(n, -1, 2).copy()


def points(laws: tuple[PointLaw, PointLaw, PointLaw], largest_force: float, n_rollers: int) -> Points:
    """The time loop's points, up to SPAN half-widths at the largest static force, N."""
    half = max(law.most(largest_force) for law in laws)
    n = laws[INNER].places(half).size
    shift, tangent, rise = np.zeros((3, 2, n)), np.zeros((3, 2, n)), np.zeros((3, n))
    for kind, law in enumerate(laws):
        for side, radius in enumerate(law.pair.radii):
            angle = np.arcsin(law.places(half) / abs(radius))
            # along t the points of a roller that faces side 0 lie clockwise about its own centre
            shift[kind, side] = -angle if side == 1 and kind != OUTER else angle
            tangent[kind, side] = np.sign(radius) * np.tan(angle)
            rise[kind] += radius * (1.0 - np.cos(angle))
    return filled(
        Points,
        {"pairs": len(laws), "n": n_rollers, "n_points": n},
        shift=shift,
        tangent=tangent,
        rise=rise,
        sagitta=np.array([law.sagitta for law in laws]),
        stiffness=np.array([law.point_stiffness for law in laws]),
        spread=laws[INNER].spread(laws, n, n_rollers),
    )


def surface_spacings(bodies: dict[str, Any]) -> dict[str, float]:
    """Distance of surface nodes of each body, m."""
    rings = {name: bodies[name] for name in ("inner_ring", "outer_ring")}
    return {
        "roller": bodies["roller"].shape.surface_spacing,
        **{name: 2.0 * pi * ring.raceway_radius / ring.n_sectors for name, ring in rings.items()},
    }


def _embedded(push: np.ndarray, first: np.ndarray, apart: int, size: int, law: PointLaw) -> sparse.csc_matrix:
    """Two components per node, `apart` from each other, put to their places among all degrees of freedom."""
    rows = np.stack([first, first + apart], axis=1).ravel()
    place = sparse.csc_matrix((np.ones(rows.size), (rows, np.arange(rows.size))), shape=(size, rows.size))
    own = np.linalg.inv(law.local_compliance(push.shape[1]))
    return place @ sparse.csc_matrix(push @ np.linalg.cholesky(EVENLY * own))
