"""How far a circle sinks into a spall: what it can reach of the surface, its morphological closing.

Two circles that roll on each other come nearer than their radii allow where the one has a hole. The distance of their
centres is least, or in a bore greatest, where the other circle touches the edge of the hole or its bottom.
"""

from typing import Literal

import numpy as np

from lagrange.faults import Spall

Meeting = Literal["bore", "in_bore", "outside"]  # the holed circle is a bore, lies in a bore, lies beside the other
POINTS = 800  # of each rounded edge; on the bottom and on either side half as many
BESIDE = 0.2  # of half the opening, of the sound surface on either side


def sinkage(spall: Spall, roller_radius: float, own: float, other: float, meeting: Meeting, angle) -> np.ndarray:
    """How far the centre of a circle gets beyond where a perfect surface would stop it, m, >= 0, at angles, rad.

    Parameters
    ----------
    own, other : radius of the circle with the spall and of the circle that rolls over it, m
    angle : ndarray, (n,), of the line of centres from the spall's middle

    Errors
    ------
    The edge's arc is taken at points: below 1e-4 of the sinkage.
    """
    at, depth = _outline(spall, spall.half_opening(roller_radius))
    return np.maximum(room(at, depth, own, other, meeting, np.asarray(angle)).min(axis=1), 0.0)


def room(at: np.ndarray, depth: np.ndarray, own: float, other: float, meeting: Meeting, angle: np.ndarray):
    """Way of a circle, along the line of centres, from a perfect surface to points of a profile, m; inf past its side.

    Parameters
    ----------
    at, depth : (n_points,), m, along the chord and below the perfect circle
    angle : (n,), rad, of the line of centres

    Returns
    -------
    ndarray, (n, n_points)
    """
    surface = own + depth if meeting == "bore" else own - depth
    beyond = angle[:, None] - np.arcsin(at / own)
    along, across = surface * np.cos(beyond), surface * np.sin(beyond)
    reach = np.sqrt(np.maximum(other**2 - across**2, 0.0))
    if meeting == "bore":
        found = (along - reach) - (own - other)
    elif meeting == "in_bore":
        found = (reach - along) - (other - own)
    else:
        found = (own + other) - (along + reach)
    return np.where(np.abs(across) < other, found, np.inf)


def deepest(spall: Spall, own: float, other: float, meeting: Meeting) -> float:
    """Sinkage between the sharp edges of a gap of the spall's width, m: a greater depth changes nothing."""

    def rise(radius):
        return radius - np.sqrt(radius**2 - 0.25 * spall.width**2)

    return float(rise(other) + rise(own) if meeting == "outside" else abs(rise(other) - rise(own)))


def _outline(spall: Spall, opening: float) -> tuple[np.ndarray, np.ndarray]:
    """Places beside the spall's middle, along the chord, and their depths, m."""
    rounding = min(spall.edge_radius, opening)
    steepest = np.arccos(max(0.0, 1.0 - spall.depth / spall.edge_radius)) if spall.edge_radius > 0.0 else 0.0
    if spall.edge_radius > 0.0:
        steepest = min(steepest, np.arcsin(rounding / spall.edge_radius))
    turned = np.linspace(0.0, steepest, POINTS)
    arc = opening - spall.edge_radius * np.sin(turned)
    arc_depth = spall.edge_radius * (1.0 - np.cos(turned))
    bottom = np.linspace(0.0, arc[-1], POINTS // 2, endpoint=False)
    beside = np.linspace(opening, (1.0 + BESIDE) * opening, POINTS // 2)
    half = np.concatenate([bottom, arc, beside])
    bottom_depth = spall.depth if rounding == spall.edge_radius else min(spall.depth, arc_depth[-1])
    depth = np.concatenate([np.full(bottom.size, bottom_depth), arc_depth, np.zeros(beside.size)])
    return np.concatenate([-half[::-1], half]), np.concatenate([depth[::-1], depth])
