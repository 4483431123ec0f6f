"""Roller and rings on meshes that resolve their contacts, the outer ring with a spall cut out of it.

Fixed axes, the load along −y. The rings' far sides are held.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from lagrange import Bearing
from lagrange.surface.faults import Spall
from tests.reference.graded_mesh import graded_circle, meshed
from tests.reference.modal_bodies import Body, body

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
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
    return Surface(
        body=of, position=np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1), node=node, angle=angle
    )


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


def outer_body(bearing: Bearing, spall: Spall | None, half: float, fine: Fineness, hollow: bool = True) -> Body:
    """The outer ring, touched within `half`, m, of its lowest point; its outside is held.

    The spall, in the lowest point, is cut out of the mesh; `hollow = False`: its material stays, with points on the
    circle, and only the gap knows of it.
    """
    R, outside = bearing.outer_raceway_radius, bearing.outside_radius
    if spall is None:
        angles = graded_circle(R, [(DOWN - half / R, DOWN + half / R, fine.raceway)], fine.far)
        rim = on_circle(R, angles)
    else:
        rim = _spalled_rim(R, spall, spall.half_opening(bearing.roller_radius), half, fine, hollow)
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
        meshed([on_circle(outside, lateral), rim]),
        bearing.outer_ring,
        bearing.roller_length,
        fine.cutoff,
        touched,
        held,
    )


def _spalled_rim(R: float, spall: Spall, opening: float, half: float, fine: Fineness, hollow: bool) -> np.ndarray:
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
    radius = np.concatenate([np.full(rest.size, R), R + (depth if hollow else 0.0 * depth)])
    order = np.argsort(angle)
    return radius[order, None] * on_circle(1.0, angle[order])
