"""Sizes and angles of a mesh."""

from dataclasses import dataclass

import numpy as np

from meshes.shapes import Mesh


@dataclass(frozen=True, kw_only=True)
class Quality:
    """Quality of one mesh: counts, edge lengths in m, angles in degrees."""

    nodes: int
    cells: int
    smallest_edge: float
    largest_edge: float
    smallest_angle: float
    largest_angle: float


def quality(mesh: Mesh) -> Quality:
    """Measure a mesh."""
    corner = mesh.points[mesh.cells]
    ahead = np.roll(corner, -1, axis=1) - corner
    back = np.roll(corner, 1, axis=1) - corner
    edge = np.hypot(*np.moveaxis(ahead, -1, 0))
    cross = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    angle = np.degrees(np.arctan2(cross, np.sum(ahead * back, axis=-1)))
    return Quality(
        nodes=len(mesh.points),
        cells=len(mesh.cells),
        smallest_edge=float(edge.min()),
        largest_edge=float(edge.max()),
        smallest_angle=float(angle.min()),
        largest_angle=float(angle.max()),
    )
