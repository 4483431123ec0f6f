"""Pressure points of contacts: where they are, which nodes they push, what they add to the step's stiffness.

Of contacts that the mesh resolves, of those whose points are spread over patches, and of the one point of a penalty
spring.
"""

from math import ceil, log2, pi
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.resolved import POINTS_PER_NODE, ResolvedLaw
from fem.elastic.spread import SpreadLaw
from fem.elastic.subgrid import patch
from fem.kernels.patches import N_NODES
from fem.kernels.state import INNER, OUTER, ROLLER, Points, Spread

if TYPE_CHECKING:
    from fem.elastic.model import Model

HERTZ_POINTS = 64
CLOSED_NODES = 12  # of a contact closed over so many, the middle knows no end
SPAN = 3.0  # half-range of the points over the half-width at the largest static force


def points(laws: dict[int, ResolvedLaw | SpreadLaw], largest_force: float, n_rollers: int) -> Points:
    """Where pressures are sampled, up to SPAN half-widths at the largest static force, N; or the one point."""
    if laws[INNER].is_one_point:
        return _points_at(laws, np.zeros((3, 2, 1)), np.zeros((3, 2, 1)), np.zeros((3, 1)), n_rollers)
    if laws[INNER].spreads:
        n = laws[INNER].lack.size // 2
    else:
        n = max(ceil(SPAN * law.half_width(largest_force) / law.spacing) for law in laws.values())
    shift, tangent, rise = np.zeros((3, 2, 2 * n)), np.zeros((3, 2, 2 * n)), np.zeros((3, 2 * n))
    for kind, law in laws.items():
        across = (np.arange(-n, n) + 0.5) * law.spacing
        for side, radius in enumerate(law.radii):
            angle = np.arcsin(across / abs(radius))
            # along t the points of a roller that faces side 0 lie clockwise about its own centre
            shift[kind, side] = -angle if side == 1 and kind != OUTER else angle
            tangent[kind, side] = np.sign(radius) * np.tan(angle)
            rise[kind] += radius * (1.0 - np.cos(angle))
    return _points_at(laws, shift, tangent, rise, n_rollers)


def _points_at(laws, shift: np.ndarray, tangent: np.ndarray, rise: np.ndarray, n_rollers: int) -> Points:
    n, spread = shift.shape[2], None
    if laws[INNER].spreads:
        spread = Spread(
            missing=np.stack([laws[kind].lack for kind in (INNER, OUTER, ROLLER)]),
            inverse=np.stack([laws[kind].inverses() for kind in (INNER, OUTER, ROLLER)]),
            closed=np.zeros((3, n_rollers, 2), dtype=np.int64),
            share=np.zeros(2 * n * N_NODES),
            slope=np.zeros(2 * N_NODES),
        )
    return Points(
        shift=shift,
        tangent=tangent,
        rise=rise,
        sagitta=np.array([laws[kind].sagitta or (0.0, 0.0) for kind in (INNER, OUTER, ROLLER)]),
        stiffness=np.array([0.0 if spread else laws[kind].point_stiffness for kind in (INNER, OUTER, ROLLER)]),
        energy=np.zeros((3, n_rollers)),
        before=np.full((3, n_rollers, 3, n), np.nan),
        residual=np.zeros((3, n_rollers)),
        closing=np.zeros(n),
        force=np.zeros(n),
        turning=np.zeros((3, n)),
        spread=spread,
    )


def stretch_for(resolved: Points, nodes: tuple[int, ...]) -> tuple[int, ...]:
    """Stretch of patches that hold every node under the points: a power of two, as each is compiled for itself."""
    widest = max(
        2.0 * np.abs(resolved.shift[kind, side]).max() * count / (2.0 * pi)
        for (kind, side), count in zip(((INNER, 0), (OUTER, 0), (INNER, 1)), nodes, strict=True)
    )
    beyond = 3.0 if resolved.spread is None else 3.0 + N_NODES
    return (0,) * 2 ** max(0, ceil(log2((widest + beyond) / N_NODES)))


def ring_push(ring: RingBody, angle: np.ndarray, size: np.ndarray, spread: bool) -> tuple[np.ndarray, np.ndarray]:
    """Raceway nodes and their polar forces under forces along the radius at angles: (m,), (2 m, n_angles).

    `spread`: over patches instead of between the two nodes around them.
    """
    nodes, share = (_patches if spread else _hats)(angle, ring.n_sectors)
    off = angle[None, :] - (2.0 * pi / ring.n_sectors) * nodes[:, None]
    push = np.stack([share * np.cos(off), share * np.sin(off)], axis=1) * size
    return nodes, push.reshape(2 * nodes.size, -1)


def disc_push(disc: DiscBody, angle: np.ndarray, size: np.ndarray, spread: bool) -> tuple[np.ndarray, np.ndarray]:
    """Surface nodes and their forces under forces along the outward radius at angles: (m,), (2 m, n_angles).

    `spread` as in `ring_push`.
    """
    nodes, share = (_patches if spread else _hats)(angle, disc.shape.surface_nodes)
    push = np.stack([share * np.cos(angle), share * np.sin(angle)], axis=1) * size
    return nodes, push.reshape(2 * nodes.size, -1)


def point_springs(model: "Model") -> dict[str, sparse.csc_matrix]:
    """Columns √2·load, each times the root of the points' own stiffness, of closed contacts on each kind of body.

    A roller has one of each kind, apart from each other.
    """
    disc, laws = model.roller, (model.inner_law, model.outer_law, model.roller_law)
    on_roller = []
    for kind, law in enumerate(laws):
        angle = _closed(law, disc.shape.radius) + 2.0 * pi * kind / 3.0
        nodes, push = disc_push(disc, angle, 1.0, law.spreads)
        on_roller.append(_embedded(push, 2 * (disc.first_surface_node + nodes), 1, 2 * disc.n_nodes, law))
    found = {"roller": sparse.hstack(on_roller).tocsc()}
    for name, ring, law in (
        ("inner_ring", model.inner_ring, model.inner_law),
        ("outer_ring", model.outer_ring, model.outer_law),
    ):
        nodes, push = ring_push(ring, _closed(law, ring.raceway_radius), 1.0, law.spreads)
        first = ring.raceway_row * 2 * ring.n_sectors + nodes
        found[name] = _embedded(push, first, ring.n_sectors, 2 * ring.n_rows * ring.n_sectors, law)
    return found


def _closed(law: ResolvedLaw | SpreadLaw, radius: float) -> np.ndarray:
    """Angles of as many points as lie over CLOSED_NODES nodes; the one point of a penalty contact, on a node."""
    if law.is_one_point:
        return np.zeros(1)
    half = min(POINTS_PER_NODE * CLOSED_NODES, law.most_points) // 2
    return (np.arange(-half, half) + 0.5) * law.spacing / radius


def _embedded(push: np.ndarray, first: np.ndarray, apart: int, size: int, law) -> sparse.csc_matrix:
    """Two components per node, `apart` from each other, put to their places among all degrees of freedom."""
    rows = np.stack([first, first + apart], axis=1).ravel()
    place = sparse.csc_matrix((np.ones(rows.size), (rows, np.arange(rows.size))), shape=(size, rows.size))
    own = np.linalg.inv(law.local_compliance(push.shape[1]))
    return place @ sparse.csc_matrix(push @ np.linalg.cholesky(2.0 * own))


def hertz_patch(
    n_surface: int, angle: float, half_width: float, spread: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A Hertz pressure of a half-width in rad as nodal forces: nodes, shares, and the contact's angle less theirs.

    `spread` as in `ring_push`.
    """
    place = pi * np.arange(1, HERTZ_POINTS + 1) / (HERTZ_POINTS + 1)  # Gauss-Chebyshev points of the second kind
    nodes, share = (_patches if spread else _hats)(angle + half_width * np.cos(place), n_surface)
    offset = np.mod(angle - (2.0 * pi / n_surface) * nodes + pi, 2.0 * pi) - pi
    return nodes, share @ (2.0 / (HERTZ_POINTS + 1) * np.sin(place) ** 2), offset


def _patches(angle: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """As `_hats`, of patches around the points."""
    found = [patch(n_nodes, a) for a in angle]
    nodes, where = np.unique(np.concatenate([nodes for nodes, _, _ in found]), return_inverse=True)
    share = np.zeros((nodes.size, angle.size))
    np.add.at(share, (where, np.repeat(np.arange(angle.size), N_NODES)), np.concatenate([w for _, w, _ in found]))
    return nodes, share


def _hats(angle: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Surface nodes around points at angles, (m,), and each node's share of each point, (m, n_angles)."""
    position = angle * n_nodes / (2.0 * pi)
    base = np.floor(position).astype(int)
    beyond = position - base
    nodes = np.unique(np.concatenate([base, base + 1]) % n_nodes)
    share = np.zeros((nodes.size, angle.size))
    column = np.arange(angle.size)
    np.add.at(share, (np.searchsorted(nodes, base % n_nodes), column), 1.0 - beyond)
    np.add.at(share, (np.searchsorted(nodes, (base + 1) % n_nodes), column), beyond)
    return nodes, share
