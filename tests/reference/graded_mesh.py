"""Triangles whose boundary is given point by point: fine where bodies touch, coarse far from there."""

import gmsh
import numpy as np
from skfem import MeshTri

from tests.reference.triangles import mesh_of_section

GROWTH = 0.15  # of a boundary piece's length, per length away from what is fine


def graded_circle(radius: float, zones: list[tuple[float, float, float]], coarse: float) -> np.ndarray:
    """Angles around a circle from −π on, (n,), rad: `zones` of (first, last angle, spacing in m), `coarse` elsewhere.

    Zones are in order and apart from each other and from ±π.
    """
    found: list[np.ndarray] = []
    bounds = [(-np.pi - (np.pi - zones[-1][1]), zones[-1][2]), *((z[0], z[2]) for z in zones)]
    for (_, spacing), (first, last, fine) in zip(bounds, zones, strict=False):
        start = found[-1][-1] if found else zones[-1][1] - 2.0 * np.pi
        found.append(_between(start, first, spacing / radius, fine / radius, coarse / radius))
        found.append(np.linspace(first, last, max(2, round((last - first) * radius / fine) + 1)))
    return np.unique(np.concatenate(found))[1:]


def _between(first: float, last: float, at_first: float, at_last: float, most: float) -> np.ndarray:
    """Places from `first` to `last`, whose distances grow from both ends towards the middle."""
    left, right, steps = [first], [last], [at_first, at_last]
    while right[-1] - left[-1] > steps[0] + steps[1]:
        if steps[0] <= steps[1]:
            steps[0] = min(most, (1.0 + GROWTH) * steps[0])
            left.append(left[-1] + steps[0])
        else:
            steps[1] = min(most, (1.0 + GROWTH) * steps[1])
            right.append(right[-1] - steps[1])
    return np.array([*left, *right[::-1]])


def meshed(loops: list[np.ndarray]) -> MeshTri:
    """Triangles inside the first of closed polygons, (n, 2), m, outside all others; polygons' sides are elements'."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        curves = []
        for loop in loops:
            sizes = 0.5 * np.hypot(*(np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)).T)
            points = [geo.addPoint(x, y, 0.0, size) for (x, y), size in zip(loop, sizes, strict=True)]
            lines = [geo.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
            for line in lines:
                geo.mesh.setTransfiniteCurve(line, 2)
            curves.append(geo.addCurveLoop(lines))
        geo.addPlaneSurface(curves)
        geo.synchronize()
        return mesh_of_section()
    finally:
        gmsh.finalize()
