"""How far a circle sinks into a spall: what it can reach of the surface, its morphological closing.

Two circles that roll on each other come nearer than their radii allow where the one has a hole. The distance of their
centres is least, or in a bore greatest, where the other circle touches the edge of the hole or its bottom.

Equation (1) of docs/surfaces.md.
"""

from math import ceil, pi, sqrt
from typing import Literal, NamedTuple

import numpy as np

from lagrange.surface.faults import MeasuredSurface, Spall

Meeting = Literal["bore", "in_bore", "outside"]  # the holed circle is a bore, lies in a bore, lies beside the other
POINTS = 800  # of each rounded edge; on the bottom and on either side half as many
PIECES, STRIDE = 8, 16  # of an outline; in each every so many points are looked at, then all around the best
BESIDE = 0.2  # of half the opening, of the sound surface on either side
UNSEEN = 1e-9  # m, that a circle sinks between two points of a measured surface: a parabola finds most of it
NO_HEIGHT = 1e-30  # m: slopes of lesser heights would overflow where monotone cubics take their harmonic mean
WINDOW = 1.2  # times the way on which a circle over the deepest point could touch the highest one


class Circles(NamedTuple):
    """A circle whose surface is not perfect, and the one that rolls over it."""

    own: float  # m, radius of the first
    other: float  # m, of the second
    meeting: Meeting
    roller: float  # m, of the one that is the rolling element's

    @property
    def curvature(self) -> float:
        """1/R of the sound contact, 1/m: the sum of both circles' curvatures, a bore's negative."""
        own, other = 1.0 / self.own, 1.0 / self.other
        return own + other if self.meeting == "outside" else abs(own - other)

    @property
    def points_around(self) -> int:
        """How many points of a measured surface must be looked at, so that the other circle sinks by UNSEEN between."""
        return ceil(2.0 * pi * self.own / sqrt(8.0 * UNSEEN / self.curvature))

    def surface(self, depth: np.ndarray) -> np.ndarray:
        """Radii of points so deep below the own circle, m."""
        return self.own + depth if self.meeting == "bore" else self.own - depth

    def room(self, surface: np.ndarray, beyond: np.ndarray) -> np.ndarray:
        """How far points at radii `surface`, m, let the centres come nearer than perfect surfaces do, m.

        `beyond` : rad, of the line of centres from the points; beside the other circle the room is infinite
        """
        along, across = surface * np.cos(beyond), surface * np.sin(beyond)
        reach = np.sqrt(np.maximum(self.other**2 - across**2, 0.0))
        if self.meeting == "bore":
            found = (along - reach) - (self.own - self.other)
        elif self.meeting == "in_bore":
            found = (reach - along) - (self.other - self.own)
        else:
            found = (self.own + self.other) - (along + reach)
        return np.where(np.abs(across) < self.other, found, np.inf)


def sinkage(spall: Spall, circles: Circles, angle) -> np.ndarray:
    """How far the centre of a circle gets beyond where a perfect surface would stop it, m, >= 0, at angles, rad.

    Parameters
    ----------
    angle : ndarray, (n,), of the line of centres from the spall's middle

    Errors
    ------
    The edge's arc is taken at points: below 1e-4 of the sinkage.
    """
    at, depth = outline(spall, spall.half_opening(circles.roller))
    surface, turned = circles.surface(depth), np.arcsin(at / circles.own)
    angle = np.asarray(angle)[:, None]
    least = np.full(len(angle), np.inf)
    for piece in np.array_split(np.arange(at.size), PIECES):  # each rises to one highest point, if it has one
        some = piece[::STRIDE]
        nearest = STRIDE * circles.room(surface[some], angle - turned[some]).argmin(axis=1)
        around = piece[np.clip(nearest[:, None] + np.arange(1 - STRIDE, STRIDE), 0, piece.size - 1)]
        found = circles.room(surface[around], angle - turned[around])
        least = np.minimum(least, found.min(axis=1))
    return np.maximum(least, 0.0)


def measured_sinkage(found: MeasuredSurface, circles: Circles, n: int) -> np.ndarray:
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
    count = angle.size * ceil(circles.points_around / angle.size)  # evenly spaced points are among them
    at = angle[0] + turn * np.arange(count + 1) / count
    ends = slice(-3, None), slice(0, 3)  # slopes of monotone cubics know three points
    angle = np.concatenate([angle[ends[0]] - turn, angle, angle[ends[1]] + turn])
    height = np.concatenate([height[ends[0]], height, height[ends[1]]])
    depth = -PchipInterpolator(angle, height)(at[:-1])
    surface = circles.surface(depth)

    def room_at(k):
        return circles.room(surface[(np.arange(count) + k) % count], turn * k / count)

    reach = WINDOW * sqrt(2.0 * np.ptp(depth) / circles.curvature) / circles.own
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
