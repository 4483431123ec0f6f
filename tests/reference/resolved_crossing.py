"""A roller that crosses a spall, resolved: every body meshed, the spall with it, contacts node by node, in motion.

The roller is free, without friction and without spin (a disc's answer does not depend on it).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from lagrange import Bearing
from lagrange.surface.faults import Spall
from tests.reference.modal_bodies import Body, Motion, separated
from tests.reference.resolved_bodies import (
    DOWN,
    FINE,
    Fineness,
    Surface,
    bare_depth,
    inner_body,
    outer_body,
    roller_body,
    surface,
)

SETTLING, SETTLINGS = 1e-4, 12  # s, of a step that finds equilibrium; how many
NEAR = 0.5e-6  # m, of gaps looked at in a step: bodies at 1 m/s come nearer by 0.1 µm
ROOM = 0.1e-3  # m, of fine mesh beyond where contacts' middles get


@dataclass(frozen=True, kw_only=True, eq=False)
class Crossing:
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
    bearing: Bearing, spall: Spall | None, hub, ahead: float, beyond: float, swing: float,
    fine: Fineness = FINE, hollow: bool = True,
) -> Crossing:  # fmt: skip
    """Mesh all; the roller starts `ahead`, m along the raceway, of the load line and gets as far as `beyond`.

    `hollow = False`: the spall's material stays, with points on the circle, and only the gap knows of it.
    """
    R, Ri, r = bearing.outer_raceway_radius, bearing.inner_raceway_radius, bearing.roller_radius
    most, opening = max(ahead, beyond), 0.0 if spall is None else spall.half_opening(r)
    lower, upper = (way + ROOM for way in (max(opening, most * r / R), most * r / R))
    roller = roller_body(bearing, lower, upper, fine)
    inner = inner_body(bearing, most * Ri / R + 1.5 * ROOM, fine)
    outer = outer_body(bearing, spall, most + 1.5 * ROOM, fine, hollow)

    def profile(away):
        return R + bare_depth(spall, opening, R * np.sin(away))

    direction = DOWN - ahead / R
    along = np.array([np.cos(direction), np.sin(direction)])
    return Crossing(
        roller=roller,
        lower=surface(roller, DOWN, lambda away: np.full_like(away, r)),
        upper=surface(roller, -DOWN, lambda away: np.full_like(away, r)),
        outer=surface(outer, DOWN, profile),
        inner=surface(inner, DOWN, lambda away: np.full_like(away, Ri)),
        radius=r,
        hub=np.asarray(hub, dtype=float),
        start=0.5 * (R + float(along @ hub) + Ri) * along,
        swing=swing,
    )


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
        node=k,
        gap=gap[k],
        normal=normal[k],
        by_roller=sparse.csr_matrix((weights, on_roller, 2 * starts), (k.size, strained.size)),
        by_ring=sparse.csr_matrix((normal[k].ravel(), on_ring, starts), (k.size, 2 * len(ring.body.points))),
    )


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
