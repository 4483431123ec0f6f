"""Flat shapes of a picture as pyvista meshes: discs, rings, arcs, arrows. z orders them."""

import numpy as np
import pyvista as pv

ARC_POINTS = 361


def polygon(points: np.ndarray, z: float) -> pv.PolyData:
    """A filled polygon, convex or not; (n, 2)."""
    face = np.concatenate([[len(points)], np.arange(len(points))])
    return pv.PolyData(_lifted(points, z), faces=face).triangulate()


def disc(centre, radius: float, z: float) -> pv.PolyData:
    """A filled circle."""
    return polygon(arc(centre, radius, 0.0, 2.0 * np.pi)[:-1], z)


def circle(centre, radius: float, z: float) -> pv.PolyData:
    """The outline of a circle."""
    return line(arc(centre, radius, 0.0, 2.0 * np.pi), z)


def ring(inner: float, outer: float, z: float, start: float = 0.0, end: float = 2.0 * np.pi) -> pv.PolyData:
    """The area between two circles about the origin, or a sector of it, rad."""
    return strip(*(arc((0.0, 0.0), radius, start, end) for radius in (inner, outer)), z)


def bar(corner, width: float, height: float, z: float) -> pv.PolyData:
    """A rectangle by its lower left corner."""
    return polygon(np.asarray(corner) + np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]), z)


def frame(corner, width: float, height: float, z: float) -> pv.PolyData:
    """The outline of a rectangle."""
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height], [0.0, 0.0]])
    return line(np.asarray(corner) + corners, z)


def border(middle: tuple[float, float], wide: float, tall: float, z: float) -> pv.PolyData:
    """The outline of a panel around its middle, just inside."""
    wide, tall = 0.994 * wide, 0.994 * tall
    return frame((middle[0] - 0.5 * wide, middle[1] - 0.5 * tall), wide, tall, z)


def segments(points: np.ndarray, pairs: np.ndarray, z: float) -> pv.PolyData:
    """Straight lines between pairs of points."""
    return pv.PolyData(_lifted(points, z), lines=np.column_stack([np.full(len(pairs), 2), pairs]).ravel())


def cells(points: np.ndarray, corners: np.ndarray, z: float | np.ndarray) -> pv.PolyData:
    """A mesh of triangles or quadrilaterals; z of all or of each point."""
    faces = np.column_stack([np.full(len(corners), corners.shape[1]), corners])
    return pv.PolyData(_lifted(points, z), faces=faces.ravel())


def line(points: np.ndarray, z: float) -> pv.PolyData:
    """An open polyline."""
    return pv.PolyData(_lifted(points, z), lines=np.concatenate([[len(points)], np.arange(len(points))]))


def strip(one: np.ndarray, other: np.ndarray, z: float) -> pv.PolyData:
    """The area between two lines of as many points."""
    k, n = np.arange(len(one) - 1), len(one)
    return cells(np.concatenate([one, other]), np.column_stack([k, n + k, n + k + 1, k + 1]), z)


def arc(centre, radius: float, start: float, end: float) -> np.ndarray:
    """Points along an arc, (ARC_POINTS, 2)."""
    angle = np.linspace(start, end, ARC_POINTS)
    return np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def arrow(tail, tip, width: float, z: float, border: float = 0.0) -> pv.PolyData:
    """A filled arrow of a given shaft width; `border` grows its outline on all sides."""
    tail, tip = np.asarray(tail, dtype=float), np.asarray(tip, dtype=float)
    length = float(np.hypot(*(tip - tail)))
    along = (tip - tail) / length
    across = np.array([-along[1], along[0]])
    half, head_half = 0.5 * width, 1.5 * width
    head = min(3.2 * width, 0.8 * length)
    head_half *= head / (3.2 * width)
    half = min(half, 0.5 * head_half)
    slope = np.hypot(head, head_half)
    # a border parallel to the head's sides moves its tip by border / sin(half angle)
    x = np.array([-border, length - head - border, length - head - border, length + border * slope / head_half])
    barb = head_half + border * (slope + head_half) / head
    y = np.array([half + border, half + border, barb, 0.0])
    x, y = np.concatenate([x, x[2::-1]]), np.concatenate([y, -y[2::-1]])
    return polygon(tail + np.outer(x, along) + np.outer(y, across), z)


def turning_arrow(
    centre, radius: float, start: float, end: float, width: float, z: float
) -> tuple[pv.PolyData, pv.PolyData]:
    """Shaft and head of an arrow bent about `centre`, from angle `start` to `end`."""
    head = np.sign(end - start) * 3.2 * width / radius
    edges = [arc(centre, radius + side * 0.5 * width, start, end - 0.98 * head) for side in (-1.0, 1.0)]
    shaft = strip(*edges, z)
    base = np.array([np.cos(end - head), np.sin(end - head)])
    tip = radius * np.array([np.cos(end), np.sin(end)])
    corners = np.array([(radius - 1.5 * width) * base, (radius + 1.5 * width) * base, tip])
    return shaft, polygon(np.asarray(centre) + corners, z)


def _lifted(points: np.ndarray, z: float | np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.full(len(points), z)])
