"""Meshes on disk: shipped with the package for the built-in scene, made once by gmsh for any other.

An entry is found by a digest of everything the mesh depends on, written beside its place and moved there, and
rebuilt when it can't be read or is not the mesh asked for.
"""

import hashlib
import os
import tempfile
from importlib import resources
from pathlib import Path

import numpy as np

from meshes.graded import GradedDisc
from meshes.shapes import Disc, Mesh, Shape, expected_points, make

RECIPE = 1  # raise it when `shapes` makes other meshes of the same shape


def mesh_of(shape: Shape) -> Mesh:
    """The mesh of a shape: from the package, from the user's cache, or made by gmsh now.

    Errors
    ------
    RuntimeError: it must be made and gmsh can't be loaded (the message says what to install).
    """
    name = file_name(shape)
    for folder in (_shipped(), cache_folder()):
        mesh = _read(folder / name, shape)
        if mesh is not None:
            return mesh
    mesh = make(shape)
    try:
        write(cache_folder() / name, mesh)
    except OSError:
        pass  # a read-only home costs the next start a second of meshing, nothing else
    return mesh


def file_name(shape: Shape) -> str:
    """File name of a shape's mesh; different for every shape and recipe."""
    digest = hashlib.sha256(f"{RECIPE} {shape!r}".encode()).hexdigest()[:16]
    return f"{type(shape).__name__.lower()}-{digest}.msh"


def cache_folder() -> Path:
    """Where meshes of this user are kept."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("roller-bearing-fem")) / "meshes"


def _shipped() -> Path:
    return Path(str(resources.files("meshes"))) / "data"


def write(path: Path, mesh: Mesh) -> None:
    """Write a mesh with meshio (Gmsh format 2.2, text: the same mesh gives the same bytes), atomically."""
    import meshio

    kind = "triangle" if mesh.cells.shape[1] == 3 else "quad"
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".msh")
    os.close(handle)
    try:
        points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
        tags = [np.ones(len(mesh.cells), dtype=np.int32)]
        whole = meshio.Mesh(points, [(kind, mesh.cells)], cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
        meshio.write(temporary, whole, file_format="gmsh22", binary=False)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def _read(path: Path, shape: Shape) -> Mesh | None:
    """The mesh in a file, or None where there is none or it is not the one asked for."""
    if not os.access(path, os.R_OK):
        return None
    import meshio

    try:
        found = meshio.read(path, file_format="gmsh")
        cells = np.ascontiguousarray(found.cells[0].data, dtype=np.int64)
        points = np.ascontiguousarray(found.points[:, :2])
    except (Exception, SystemExit):  # meshio raises, or exits on, whatever a damaged file makes of it
        return None
    wanted = expected_points(shape)
    if points.shape != wanted.shape or not np.allclose(points, wanted, rtol=0.0, atol=1e-12 * np.abs(wanted).max()):
        return None
    round_ = isinstance(shape, Disc | GradedDisc)
    corners, count = (3, shape.n_cells) if round_ else (4, shape.sectors * shape.layers)
    if cells.shape != (count, corners) or cells.min() < 0 or cells.max() >= len(points):
        return None
    return Mesh(points=wanted, cells=cells)
