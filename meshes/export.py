"""Meshes with fields on them, written by meshio in formats that other programs read."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from lagrange.output_files import replaced

# those of meshio's formats that keep triangles beside quadrilaterals, and fields with any number of components
FORMATS = {
    ".vtu": {"file_format": "vtu"},
    ".vtk": {"file_format": "vtk"},
    ".xdmf": {"file_format": "xdmf", "data_format": "XML"},  # in one file
    ".med": {"file_format": "med"},
}


def known_suffixes() -> tuple[str, ...]:
    """File name endings that `write_fields` takes."""
    return tuple(FORMATS)


def write_fields(
    path: Path,
    points: np.ndarray,
    blocks: Sequence[np.ndarray],
    point_data: Mapping[str, np.ndarray],
    cell_data: Mapping[str, Sequence[np.ndarray]],
) -> None:
    """Write a plane mesh with its fields, atomically, in the format of the name's ending.

    Parameters
    ----------
    points : (n_points, 2), m; blocks : cells of one kind each, (n_cells, 3) or (n_cells, 4)
    point_data : (n_points,) or (n_points, k); cell_data : one array for each block
    """
    import meshio

    kinds = {3: "triangle", 4: "quad"}
    mesh = meshio.Mesh(
        np.column_stack([points, np.zeros(len(points))]),
        [(kinds[cells.shape[1]], cells) for cells in blocks],
        point_data=dict(point_data),
        cell_data={name: list(values) for name, values in cell_data.items()},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with replaced(path) as part:
        meshio.write(part, mesh, **FORMATS[path.suffix.lower()])
