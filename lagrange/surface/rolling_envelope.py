"""How far a circle sinks into a spall: what it can reach of the surface, its morphological closing.

Two circles that roll on each other come nearer than their radii allow where the one has a hole. The distance of their
centres is least, or in a bore greatest, where the other circle touches the edge of the hole or its bottom.

Equation (1) of docs/surfaces.md.
"""

from math import ceil, pi, sqrt
from typing import Literal

import numpy as np

from lagrange.surface.faults import MeasuredSurface, Spall

Meeting = Literal["bore", "in_bore", "outside"]  # the holed circle is a bore, lies in a bore, lies beside the other
POINTS = 800  # of each rounded edge; on the bottom and on either side half as many
PIECES, STRIDE = 8, 16  # of an outline; in each every so many points are looked at, then all around the best
BESIDE = 0.2  # of half the opening, of the sound surface on either side
UNSEEN = 1e-9  # m, that a circle sinks between two points of a measured surface: a parabola finds most of it
NO_HEIGHT = 1e-30  # m: slopes of lesser heights would overflow where monotone cubics take their harmonic mean
WINDOW = 1.2  # times the way on which a circle over the deepest point could touch the highest one


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
    at, depth = outline(spall, spall.half_opening(roller_radius))
    surface, turned = own + depth if meeting == "bore" else own - depth, np.arcsin(at / own)
    angle = np.asarray(angle)[:, None]
    least = np.full(len(angle), np.inf)
    for piece in np.array_split(np.arange(at.size), PIECES):  # each rises to one highest point, if it has one
        some = piece[::STRIDE]
        nearest = STRIDE * _room(surface[some], angle - turned[some], own, other, meeting).argmin(axis=1)
        around = piece[np.clip(nearest[:, None] + np.arange(1 - STRIDE, STRIDE), 0, piece.size - 1)]
        found = _room(surface[around], angle - turned[around], own, other, meeting)
        least = np.minimum(least, found.min(axis=1))
    return np.maximum(least, 0.0)


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
    return _room(surface, angle[:, None] - np.arcsin(at / own), own, other, meeting)


def measured_sinkage(found: MeasuredSurface, own: float, other: float, meeting: Meeting, n: int) -> np.ndarray:
    """The same around a measured surface, at n angles from 0 on, (n,), m; negative over what stands out.

    Between the points of the table the surface neither rises above nor falls below them (Fritsch and Carlson's
    monotone cubics), and its sinkage is a spline between angles at which it is found. A circle touches where the
    parabola through the three points that leave the least room has its vertex.

    Errors
    ------
    A wave of m points loses up to 5/m² of its amplitude where its crest lies between two points.
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    turn, angle, height = 2.0 * pi, found.table.angle + found.angle, found.table.height
    height = np.where(np.abs(height) < NO_HEIGHT, 0.0, height)
    count = angle.size * ceil(points_around(own, other, meeting) / angle.size)  # evenly spaced points are among them
    at = angle[0] + turn * np.arange(count + 1) / count
    ends = slice(-3, None), slice(0, 3)  # slopes of monotone cubics know three points
    angle = np.concatenate([angle[ends[0]] - turn, angle, angle[ends[1]] + turn])
    height = np.concatenate([height[ends[0]], height, height[ends[1]]])
    depth = -PchipInterpolator(angle, height)(at[:-1])
    surface = own + depth if meeting == "bore" else own - depth

    def room_at(k):
        return _room(surface[(np.arange(count) + k) % count], turn * k / count, own, other, meeting)

    reach = WINDOW * sqrt(2.0 * np.ptp(depth) / curvature(own, other, meeting)) / own
    steps = min(ceil(reach / turn * count), count // 4)
    least, nearest = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
    for k in range(-steps, steps + 1):
        found_here = room_at(k)
        nearer = found_here < least
        least[nearer], nearest[nearer] = found_here[nearer], k
    before, after = room_at(nearest - 1), room_at(nearest + 1)
    bend = before - 2.0 * least + after
    between = np.where(bend > 0.0, (before - after) ** 2 / np.where(bend > 0.0, 8.0 * bend, 1.0), 0.0)
    sunk = least - np.minimum(between, UNSEEN)  # more is of no parabola: an edge
    closed = CubicSpline(at, np.append(sunk, sunk[0]), bc_type="periodic")
    return closed(at[0] + np.mod(turn * np.arange(n) / n - at[0], turn))


def points_around(own: float, other: float, meeting: Meeting) -> int:
    """How many points of a measured surface a circle must be held against, so that it sinks by UNSEEN between two."""
    return ceil(2.0 * pi * own / sqrt(8.0 * UNSEEN / curvature(own, other, meeting)))


def curvature(own: float, other: float, meeting: Meeting) -> float:
    """1/R of the sound contact, 1/m: the sum of both circles' curvatures, a bore's negative."""
    return 1.0 / own + 1.0 / other if meeting == "outside" else abs(1.0 / own - 1.0 / other)


def _room(surface, beyond, own: float, other: float, meeting: Meeting) -> np.ndarray:
    """How far points at radii `surface`, m, let the centres of the circles come nearer than perfect surfaces do, m.

    `beyond` : rad, of the line of centres from the points
    """
    along, across = surface * np.cos(beyond), surface * np.sin(beyond)
    reach = np.sqrt(np.maximum(other**2 - across**2, 0.0))
    if meeting == "bore":
        found = (along - reach) - (own - other)
    elif meeting == "in_bore":
        found = (reach - along) - (other - own)
    else:
        found = (own + other) - (along + reach)
    return np.where(np.abs(across) < other, found, np.inf)


def outline(spall: Spall, opening: float) -> tuple[np.ndarray, np.ndarray]:
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
