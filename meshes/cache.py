"""Meshes on disk: shipped with the package for the built-in scene, made once by gmsh for any other.

An entry is found by a digest of everything the mesh depends on, and rebuilt when it can't be read, is not what was
written or not the mesh asked for.
"""

import hashlib
import io
from contextlib import suppress
from importlib import resources
from pathlib import Path

import numpy as np

from lagrange.files.input import user_cache
from lagrange.files.output import read_sealed, write_sealed
from meshes.graded import GradedDisc
from meshes.shapes import Disc, Mesh, Shape, expected_points, make

RECIPE = 3  # raise it when `shapes` makes other meshes of the same shape


def mesh_of(shape: Shape) -> Mesh:
    """The mesh of a shape: from the package, from the user's cache, or made by gmsh now.

    Errors: RuntimeError: it must be made and gmsh can't be loaded (the message says what to install).
    """
    name, folders = file_name(shape), [Path(str(resources.files("meshes"))) / "data"]
    with suppress(OSError):
        folders.append(cache_folder())
    for folder in folders:
        mesh = _read(folder / name, shape)
        if mesh is not None:
            return mesh
    mesh = make(shape)
    with suppress(OSError):  # a read-only home costs the next start a second of meshing, nothing else
        write(cache_folder() / name, mesh)
    return mesh


def file_name(shape: Shape) -> str:
    """File name of a shape's mesh; different for every shape and recipe."""
    digest = hashlib.sha256(f"{RECIPE} {shape!r}".encode()).hexdigest()[:16]
    return f"{type(shape).__name__.lower()}-{digest}.npy"


def cache_folder() -> Path:
    """Where meshes of this user are kept. OSError: it can't be made, or others can write there."""
    return user_cache("meshes")


def write(path: Path, mesh: Mesh) -> None:
    """Write a mesh's cells, atomically and sealed; its points follow from its shape."""
    file = io.BytesIO()
    np.save(file, mesh.cells.astype("<i4"), allow_pickle=False)
    write_sealed(path, file.getvalue())


def _read(path, shape):
    try:
        data = read_sealed(path)
        if data is None:
            return None
        found = np.load(io.BytesIO(data), allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    points = expected_points(shape)
    count = (shape.n_cells, 3) if isinstance(shape, Disc | GradedDisc) else (shape.sectors * shape.layers, 4)
    if found.shape != count or found.dtype != "<i4" or found.min() < 0 or found.max() >= len(points):
        return None
    cells = np.ascontiguousarray(found, dtype=np.int64)
    x, y = points[cells, 0], points[cells, 1]
    areas = np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)  # twice, corners counter-clockwise
    return Mesh(points=points, cells=cells) if np.all(areas > 0.0) else None
