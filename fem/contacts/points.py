"""Contacts of pressure points: where they are, which nodes they push, what they add to the step's stiffness.

A patch of six nodes around a force carries it, or the two beside it. Contacts that the mesh resolves, those whose
points are spread over patches, and the one point of a penalty spring have this in common; `PointLaw` and `model.Model`
are what differs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import ceil, pi
from typing import ClassVar

import numpy as np

from fem.contacts.contact_law import NoLaw
from fem.elastic.bodies import DiscBody, RingBody
from fem.kernels.columns import INNER, OUTER
from fem.kernels.elements.state import Points, Spread
from fem.kernels.elements.surfaces import N_NODES, first_node, weights
from fem.kernels.fields import filled
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


def patch_force(body: DiscBody | RingBody, angle: float) -> np.ndarray:
    """Nodal forces of a unit force along the outward radius at an angle of the surface, as all nodes' vectors are.

    Of a ring (n_rows, 2, n_sectors), polar, of a disc (2 n_nodes,).
    """
    nodes, weight, offset = patch(body.n_surface, angle)
    return _on_surface(body, nodes, weight * np.stack([np.cos(offset), np.sin(offset)]), angle - offset)


def patch_traction(body: DiscBody | RingBody, angle: float) -> np.ndarray:
    """The same of a unit traction counter-clockwise along the surface.

    See `fem.kernels.elements.surfaces`: exact for the force and for its moment.
    """
    nodes, weight, offset = patch(body.n_surface, angle)
    c, s = np.cos(offset), np.sin(offset)
    slope, scale = -weight @ s, 1.0 / (1.0 + weight @ c)
    return _on_surface(body, nodes, weight * scale * np.stack([slope * c - s, 1.0 + c + slope * s]), angle - offset)


def _on_surface(body, nodes, polar, at):
    """Forces of surface nodes at some angles, (2, m), radial and counter-clockwise, among those of all nodes."""
    if isinstance(body, RingBody):
        force = np.zeros((body.n_rows, 2, body.n_sectors))
    else:
        force, c, s = np.zeros(2 * body.n_nodes), np.cos(at), np.sin(at)
        polar = np.stack([polar[0] * c - polar[1] * s, polar[0] * s + polar[1] * c])
    np.add.at(force.reshape(-1), body.surface_places(nodes), polar.T.ravel())
    return force


def _shares(angle, n_nodes, first, weigh):
    """Nodes around points at angles, (m,), and each node's share of each point, (m, n_angles)."""
    position = angle * n_nodes / (2.0 * pi)
    base = np.floor(position)
    weight = np.array([weigh(beyond) for beyond in position - base])
    found = (first + base[:, None].astype(int) + np.arange(weight.shape[1])) % n_nodes
    nodes, where = np.unique(found, return_inverse=True)
    share = np.zeros((nodes.size, angle.size))
    np.add.at(share, (where.ravel(), np.repeat(np.arange(angle.size), weight.shape[1])), weight.ravel())
    return nodes, share


patches = partial(_shares, first=first_node(0), weigh=weights)  # of the patches around some points
hats = partial(_shares, first=0, weigh=lambda beyond: (1.0 - beyond, beyond))  # of the two nodes beside each instead


def push(body: DiscBody | RingBody, angle: np.ndarray, size, shares: Shares) -> tuple[np.ndarray, np.ndarray]:
    """Surface nodes and their forces under forces along the outward radius at angles: (m,), (2 m, n_angles).

    Polar of a ring, x and y of a disc.
    """
    nodes, share = shares(angle, body.n_surface)
    off = angle - (2.0 * pi / body.n_surface * nodes[:, None] if isinstance(body, RingBody) else 0.0)
    return nodes, (np.stack([share * np.cos(off), share * np.sin(off)], axis=1) * size).reshape(2 * nodes.size, -1)


def hertz_patch(
    n_surface: int, angle: float, half_width: float, shares: Shares
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A Hertz pressure of a half-width in rad as nodal forces: nodes, shares, and the contact's angle less theirs."""
    place = pi * np.arange(1, HERTZ_POINTS + 1) / (HERTZ_POINTS + 1)  # Gauss-Chebyshev points of the second kind
    nodes, share = shares(angle + half_width * np.cos(place), n_surface)
    offset = np.mod(angle - (2.0 * pi / n_surface) * nodes + pi, 2.0 * pi) - pi
    return nodes, share @ (2.0 / (HERTZ_POINTS + 1) * np.sin(place) ** 2), offset


POINTS_PER_NODE = 4  # of resolved contacts
SPAN = 3.0  # half-range of the time loop's points over the half-width at the largest static force


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
        Points, {"pairs": len(laws), "n": n_rollers, "n_points": n}, shift=shift, tangent=tangent, rise=rise,
        sagitta=np.array([law.sagitta for law in laws]), stiffness=np.array([law.point_stiffness for law in laws]),
        spread=laws[INNER].spread(laws, n, n_rollers),
    )  # fmt: skip
