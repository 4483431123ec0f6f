"""Meshes with fields on them, written by meshio in formats that other programs read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lagrange.files.output import replaced
from meshes.shapes import Mesh

# by a file name's ending: meshio's formats that keep triangles beside quadrilaterals, and fields of any width
FORMATS = {f".{name}": {"file_format": name} for name in ("vtu", "vtk", "xdmf", "med")}
FORMATS[".xdmf"]["data_format"] = "XML"  # in one file


def write_fields(
    path: Path, points: np.ndarray, blocks: Sequence[np.ndarray], point_data: Mapping[str, np.ndarray],
    cell_data: Mapping[str, Sequence[np.ndarray]],
) -> None:  # fmt: skip
    """Write a plane mesh with its fields, atomically, in the format of the name's ending.

    points : (n_points, 2), m; blocks : cells of one kind each, (n_cells, 3) or (n_cells, 4)
    point_data : (n_points,) or (n_points, k); cell_data : one array for each block
    """
    import meshio

    kinds = {3: "triangle", 4: "quad"}
    mesh = meshio.Mesh(
        np.column_stack([points, np.zeros(len(points))]), [(kinds[cells.shape[1]], cells) for cells in blocks],
        point_data=dict(point_data), cell_data={name: list(values) for name, values in cell_data.items()},
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    with replaced(path) as part:
        meshio.write(part, mesh, **FORMATS[path.suffix.lower()])


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
        nodes=len(mesh.points), cells=len(mesh.cells), smallest_edge=float(edge.min()), largest_edge=float(edge.max()),
        smallest_angle=float(angle.min()), largest_angle=float(angle.max()),
    )  # fmt: skip
