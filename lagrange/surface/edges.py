"""How circles meet spalls: how far they sink, and how much softer contacts are at edges.

Two circles that roll on each other come nearer than their radii allow where the one has a hole: to what the other can
reach of the surface, its morphological closing. The distance of their centres is least, or in a bore greatest, where
the other circle touches the edge of the hole or its bottom. Equation (1) of docs/surfaces.md.

At an edge two half-planes are pressed together over the gap between the circle and the bare profile. The roller's
approach is that of a sound contact under the same force, and the sinkage, and the force times a compliance A·ΔB, with
the A of Hertz's law δ = A Q (B − ½ ln Q): on an edge of radius e alone ΔB = ½ ln(1 + R/e), where half the contact hangs
over the edge ½. In series with a law the compliance c gives δ = δ_law(Q) + c Q. Equation (3) of docs/surfaces.md.
"""

from functools import lru_cache
from math import asin, ceil, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy import ndarray

from lagrange.surface.faults import MeasuredSurface, Spall

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
    meeting: str  # of the first: it is a "bore", lies "in_bore" or "outside" of the other
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

    def half_angle(self, spall: Spall) -> float:
        """From a spall's middle to where its edges begin, rad."""
        return asin(spall.half_opening(self.roller) / self.own)

    def surface(self, depth: ndarray) -> ndarray:
        """Radii of points so deep below the own circle, m."""
        return self.own + depth if self.meeting == "bore" else self.own - depth

    def room(self, surface: ndarray, beyond: ndarray) -> ndarray:
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


def sinkage(spall: Spall, circles: Circles, angle) -> ndarray:
    """How far the centre of a circle gets beyond where a perfect surface would stop it, m, >= 0, at angles, rad.

    angle : ndarray, (n,), of the line of centres from the spall's middle

    Errors: The edge's arc is taken at points: below 1e-4 of the sinkage.
    """
    at, depth = outline(spall, spall.half_opening(circles.roller))
    surface, turned = circles.surface(depth), np.arcsin(at / circles.own)
    angle = np.asarray(angle)[:, None]
    least = np.zeros(len(angle)) + np.inf
    for piece in np.array_split(np.arange(at.size), PIECES):  # each rises to one highest point, if it has one
        some = piece[::STRIDE]
        nearest = STRIDE * circles.room(surface[some], angle - turned[some]).argmin(axis=1)
        around = piece[np.clip(nearest[:, None] + np.arange(1 - STRIDE, STRIDE), 0, piece.size - 1)]
        least = np.minimum(least, circles.room(surface[around], angle - turned[around]).min(axis=1))
    return np.maximum(least, 0.0)


def measured_sinkage(found: MeasuredSurface, circles: Circles, n: int) -> ndarray:
    """The same around a measured surface, at n angles from 0 on, (n,), m; negative over what stands out.

    Between the points of the table the surface neither rises above nor falls below them (Fritsch and Carlson's
    monotone cubics), and its sinkage is a spline between angles at which it is found. A circle touches where the
    parabola through the three points that leave the least room has its vertex.

    Errors: A wave of m points loses up to 5/m² of its amplitude where its crest lies between two points.
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    turn, angle, height = 2.0 * pi, found.table.angle + found.angle, found.table.height
    count = angle.size * ceil(circles.points_around / angle.size)  # evenly spaced points are among them
    at = angle[0] + turn * np.arange(count + 1) / count
    # slopes of monotone cubics know three points
    angle = np.concatenate([angle[-3:] - turn, angle, angle[:3] + turn])
    height = np.concatenate([height[-3:], height, height[:3]])
    depth = -PchipInterpolator(angle, np.where(np.abs(height) < NO_HEIGHT, 0.0, height))(at[:-1])
    surface = circles.surface(depth)

    def room_at(k):
        return circles.room(surface[(np.arange(count) + k) % count], turn * k / count)

    way = WINDOW * sqrt(2.0 * np.ptp(depth) / circles.curvature) / circles.own
    steps = min(ceil(way / turn * count), count // 4)
    least, nearest = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
    for k in range(-steps, steps + 1):
        here = room_at(k)
        nearest[here < least] = k
        least = np.minimum(here, least)
    before, after = room_at(nearest - 1), room_at(nearest + 1)
    bend = before - 2.0 * least + after
    between = np.where(bend > 0.0, (before - after) ** 2 / np.where(bend > 0.0, 8.0 * bend, 1.0), 0.0)
    sunk = least - np.minimum(between, UNSEEN)  # more is of no parabola: an edge
    closed = CubicSpline(at, np.append(sunk, sunk[0]), bc_type="periodic")
    return closed(at[0] + np.mod(turn * np.arange(n) / n - at[0], turn))


def outline(spall: Spall, opening: float) -> tuple[ndarray, ndarray]:
    """Places beside the spall's middle, along the chord, and their depths, m."""
    edge, steepest, bottom_depth = spall.edge_radius, 0.0, spall.depth
    if edge > 0.0:
        steepest = min(np.arccos(max(0.0, 1.0 - spall.depth / edge)), np.arcsin(min(edge, opening) / edge))
    turned = np.linspace(0.0, steepest, POINTS)
    arc, arc_depth = opening - edge * np.sin(turned), edge * (1.0 - np.cos(turned))
    if edge > opening:
        bottom_depth = min(bottom_depth, arc_depth[-1])
    bottom = np.linspace(0.0, arc[-1], POINTS // 2, endpoint=False)
    beside = np.linspace(opening, (1.0 + BESIDE) * opening, POINTS // 2)
    half = np.concatenate([bottom, arc, beside])
    depth = np.concatenate([np.full(bottom.size, bottom_depth), arc_depth, np.zeros(beside.size)])
    return np.concatenate([-half[::-1], half]), np.concatenate([depth[::-1], depth])


HALF_WIDTHS = np.array([0.007, 0.014])  # over R, of the sound contacts: 0.4 and 0.8 GPa of steel; ΔB is their mean's
SHARPEST = 1e-3  # of the roller's radius: sharper edges are as soft as one of 5 µm, or nothing would bound it
BEYOND = 1.1  # half-widths beyond the opening: there a contact still is sound
POSITIONS = 24  # on either side of where the edge begins, 24 more between there and the middle
CELLS = 12  # of the narrower half-width, and of that on an edge alone
GROWTH = 1.15  # of cells away from an edge
IN_REACH = 2.0  # of b²/R: cells with a wider gap are none of the contact's
MOST_TURNS = 60  # of the search for the cells in contact; 3 to 8 are usual


def softening(spall: Spall, circles: Circles, angle) -> ndarray:
    """ΔB, >= 0, at angles of the line of centres from the spall's middle, (n,), rad; 0 far from it.

    Errors: The half-planes' own, (b/R)². Cells change ΔB by 0.02 at most. By the force ΔB changes, see
    `docs/surfaces.md`. In the spall's middle, on both edges, contacts may be stiffer than sound ones: that is left out.
    """
    from scipy.interpolate import PchipInterpolator  # half a second to import, and only spalls need it

    edge = max(spall.edge_radius, SHARPEST * circles.roller)
    at, found = _table(spall.half_opening(circles.roller), spall.depth, edge, circles)
    return np.maximum(PchipInterpolator(at, found)(np.minimum(np.abs(angle), at[-1])), 0.0)


def reach(spall: Spall, circles: Circles) -> float:
    """Angle from the spall's middle from which on contacts are sound, rad."""
    return asin((spall.half_opening(circles.roller) + BEYOND * HALF_WIDTHS[-1] / circles.curvature) / circles.own)


@lru_cache(maxsize=64)
def _table(opening, depth, edge, circles):
    """Angles from the middle of a spall of half an opening, a depth and an edge's radius, m, and ΔB; 0 at the last."""
    radius = 1.0 / circles.curvature
    widths = HALF_WIDTHS * radius
    width = BEYOND * widths[-1]
    near = np.linspace(max(opening - width, 0.0), opening + width, 2 * POSITIONS)
    # on both edges the contact changes within δ·R/(w/2), the closer to the middle the wider the spall
    apart = np.geomspace(0.2 * widths[0] ** 2 / opening, near[0] if near[0] > 0.0 else width, POSITIONS)
    angle = np.arcsin(np.unique(np.concatenate([[0.0], apart[apart < near[0]], near])) / circles.own)
    # bounds of cells along the chord, m: fine where the edges begin
    coarse = widths[0] / CELLS
    fine = min(coarse, widths[0] * np.sqrt(edge / (edge + radius)) / CELLS)
    last = (BEYOND + 2.0 * np.sqrt(IN_REACH)) * widths[-1]
    steps = [fine] * (2 * CELLS)
    while sum(steps) < max(last, opening):
        steps.append(min(coarse, GROWTH * steps[-1]))
    outward = np.concatenate([[0.0], np.cumsum(steps)])
    inward = outward[1:][outward[1:] < opening - 0.5 * fine]
    half = np.concatenate([opening - inward[::-1], opening + outward[outward < last]])
    cells = np.concatenate([-half[::-1], half])
    middle = 0.5 * (cells[1:] + cells[:-1])
    inside = np.maximum(opening - np.abs(middle), 0.0)
    arc = np.where(inside < edge, edge - np.sqrt(np.maximum(edge**2 - inside**2, 0.0)), np.inf)
    gaps = circles.room(circles.surface(np.minimum(arc, depth)), angle[:, None] - np.arcsin(middle / circles.own))
    found = _approaches(gaps, cells, 0.5 * widths**2 / radius)
    return angle, np.maximum((found - found[:, -1:]).mean(axis=0), 0.0)


def _approaches(gaps, cells, units):
    """Approaches over the least gap, over A·Q, (n_units, n_positions), up to numbers that are the same for all.

    `units` : A·Q, m, rising; the force Q that makes a half-width b on the sound surface has A·Q = b²/(2R)
    """
    found, pressed = np.empty((len(units), len(gaps))), np.zeros((len(units), gaps.shape[1]), dtype=bool)
    for i, gap in enumerate(gaps):
        above = gap - gap.min()
        widest = np.flatnonzero(above < 2.0 * IN_REACH * units[-1])
        # displacement at the middle of cells by a unit force spread over each, over A; another unit of length would
        # add a number to all of it, and to all approaches
        bounds = np.union1d(widest, widest + 1)
        apart = cells[bounds] - 0.5 * (cells[widest] + cells[widest + 1])[:, None]
        integral, low = apart * (np.log(np.abs(apart)) - 1.0), np.searchsorted(bounds, widest)
        influence = (integral[:, low] - integral[:, low + 1]) / (cells[widest + 1] - cells[widest])
        for k, unit in enumerate(units):
            inside = np.flatnonzero(above[widest] < 2.0 * IN_REACH * unit)
            in_reach = widest[inside]
            beyond = above[in_reach] / unit
            start = pressed[k][in_reach]
            found[k, i], closed = _press(beyond, influence[np.ix_(inside, inside)], start)
            pressed[k] = False
            pressed[k, in_reach] = closed
    return found


def _press(gap, influence, closed):
    """Approach under a unit force, and the cells that carry it; `closed` to begin with, (n,)."""
    if not closed.any():
        closed = gap < 0.5
    for _ in range(MOST_TURNS):
        k = np.flatnonzero(closed)
        matrix = np.ones((k.size + 1, k.size + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1, -1] = influence[np.ix_(k, k)], -1.0, 0.0
        *force, approach = np.linalg.solve(matrix, np.append(-gap[k], 1.0))
        pushing = np.zeros(gap.size, dtype=bool)
        pushing[k] = np.array(force) > 0.0
        changed = np.where(closed, pushing, gap + influence[:, k] @ force < approach)
        if np.array_equal(changed, closed):
            break
        closed = changed if changed.any() else gap <= gap.min()
    return float(approach), closed
