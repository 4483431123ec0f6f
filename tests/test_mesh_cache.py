"""Meshes on disk: shipped ones need no gmsh, cached ones are made once, damaged ones are made again."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import meshes
from lagrange.scene.scene import read_scene
from meshes import Annulus, Disc, bearing_shapes, cache, mesh_of
from meshes.shapes import make
from tests.waiting import GIVE_UP

DISC = Disc(radius=0.0037, layers=3)  # of no shipped bearing
RING = Annulus(inner_radius=0.0111, outer_radius=0.0151, sectors=40, layers=2)
SHIPPED = Path(meshes.__file__).parent / "data"
ROOT = Path(meshes.__file__).parent.parent


def built_in_shapes(size_mm):
    shapes = bearing_shapes(read_scene().ideal_bearing(), 1e-3 * size_mm)
    return shapes.roller, shapes.inner_ring, shapes.outer_ring


def assert_same(found, wanted):
    assert found.points.tobytes() == wanted.points.tobytes()
    assert found.cells.tobytes() == wanted.cells.tobytes()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    place = tmp_path / "cache" / "meshes"
    monkeypatch.setattr(cache, "cache_folder", lambda: place)
    return place


@pytest.fixture
def meshed(monkeypatch):
    """Shapes that gmsh was asked for."""
    asked = []

    def counting(shape):
        asked.append(shape)
        return make(shape)

    monkeypatch.setattr(cache, "make", counting)
    return asked


@pytest.mark.parametrize("shape", [DISC, RING])
def test_the_same_shape_gives_the_same_file_bytes(shape, tmp_path):
    cache.write(tmp_path / "first.npy", make(shape))
    cache.write(tmp_path / "second.npy", make(shape))
    assert (tmp_path / "first.npy").read_bytes() == (tmp_path / "second.npy").read_bytes()


@pytest.mark.parametrize("shape", [DISC, RING])
def test_a_mesh_is_made_once_and_then_read(shape, folder, meshed):
    first, second = mesh_of(shape), mesh_of(shape)
    assert meshed == [shape]
    assert_same(second, first)
    assert [entry.name for entry in folder.iterdir()] == [cache.file_name(shape)]


def test_file_names_tell_shapes_and_recipes_apart(monkeypatch):
    names = {
        cache.file_name(shape)
        for shape in (DISC, RING, Disc(radius=0.0037, layers=4), Disc(radius=np.nextafter(0.0037, 1.0), layers=3))
    }
    assert len(names) == 4
    monkeypatch.setattr(cache, "RECIPE", cache.RECIPE + 1)
    assert cache.file_name(DISC) not in names


def entry_of_another_shape(good, path):
    cache.write(path, make(Disc(radius=0.0037, layers=2)))


def swapped_nodes(good, path):
    cells = np.load(path)
    cells[3] = cells[3][::-1]
    np.save(path, cells)


def node_of_no_mesh(good, path):
    cells = np.load(path)
    cells[0, 0] = 10_000
    np.save(path, cells)


def pickled(good, path):
    np.save(path, np.array([[{}]], dtype=object), allow_pickle=True)


def missing_cell(good, path):
    mesh = make(DISC)
    cache.write(path, type(mesh)(points=mesh.points, cells=mesh.cells[1:]))


DAMAGE = {
    "empty": lambda good, path: path.write_bytes(b""),
    "cut in the header": lambda good, path: path.write_bytes(good[:20]),
    "cut in the cells": lambda good, path: path.write_bytes(good[: 9 * len(good) // 10]),
    "binary garbage": lambda good, path: path.write_bytes(np.random.default_rng(1).bytes(4000)),
    "text": lambda good, path: path.write_text("nodes and cells\n"),
    "zeros": lambda good, path: path.write_bytes(b"\0" * len(good)),
    "another shape": entry_of_another_shape,
    "a cell the wrong way round": swapped_nodes,
    "a node that is not there": node_of_no_mesh,
    "a pickle": pickled,
    "a missing cell": missing_cell,
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_a_damaged_entry_is_made_again_and_mended(damage, folder, meshed):
    wanted = mesh_of(DISC)
    path = folder / cache.file_name(DISC)
    good = path.read_bytes()
    damage(good, path)
    assert path.read_bytes() != good
    assert_same(mesh_of(DISC), wanted)
    assert len(meshed) == 2
    assert path.read_bytes() == good
    assert len(list(folder.iterdir())) == 1


def test_a_failed_write_leaves_nothing_behind(folder, meshed, monkeypatch):
    def full_disc(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full_disc)
    assert_same(mesh_of(DISC), make(DISC))
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("refusal", [PermissionError(13, "Permission denied"), OSError(30, "Read-only file system")])
def test_a_read_only_cache_costs_a_meshing_and_nothing_else(refusal, folder, meshed, monkeypatch):
    def refuse(*_, **__):
        raise refusal

    monkeypatch.setattr("lagrange.files.output.write_whole", refuse)
    assert_same(mesh_of(DISC), make(DISC))
    assert_same(mesh_of(DISC), make(DISC))
    assert meshed == [DISC, DISC]


def test_a_cache_that_cannot_be_a_folder_costs_a_meshing_and_nothing_else(tmp_path, meshed, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path / "file" / "meshes")
    assert_same(mesh_of(DISC), make(DISC))
    assert meshed == [DISC]


def test_writers_of_the_same_entry_do_not_disturb_readers(folder):
    mesh = make(DISC)
    path = folder / cache.file_name(DISC)
    cache.write(path, mesh)
    with ThreadPoolExecutor(4) as pool:
        writing = [pool.submit(cache.write, path, mesh) for _ in range(20)]
        while not all(future.done() for future in writing):
            assert_same(cache._read(path, DISC), mesh)
        for future in writing:
            future.result()
    assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize("size_mm", [1.0, 2.0])
def test_shipped_meshes_are_what_gmsh_makes_now(size_mm, folder, meshed, tmp_path):
    for shape in built_in_shapes(size_mm):
        fresh = make(shape)
        assert_same(mesh_of(shape), fresh)
        cache.write(tmp_path / "fresh.npy", fresh)
        assert (SHIPPED / cache.file_name(shape)).read_bytes() == (tmp_path / "fresh.npy").read_bytes()
    assert meshed == []
    assert not folder.exists()


def test_no_mesh_is_shipped_that_the_built_in_scene_does_not_use():
    wanted = {cache.file_name(shape) for size in (1.0, 2.0) for shape in built_in_shapes(size)}
    assert {path.name for path in SHIPPED.glob("*.npy")} == wanted


def run_without_gmsh(code, tmp_path):
    """Run code where `import gmsh` fails as it does without libGLU."""
    fake = tmp_path / "fake"
    fake.mkdir()
    (fake / "gmsh.py").write_text('raise ImportError("libGLU.so.1: cannot open shared object file")\n')
    environment = dict(os.environ, PYTHONPATH=f"{fake}{os.pathsep}{ROOT}", XDG_CACHE_HOME=str(tmp_path / "xdg"))
    return subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=GIVE_UP
    )


def test_the_built_in_scene_needs_no_gmsh(tmp_path):
    code = """
import sys
from lagrange.scene.scene import read_scene
from meshes import bearing_shapes, mesh_of
for size in (1e-3, 2e-3):
    shapes = bearing_shapes(read_scene().ideal_bearing(), size)
    for shape in (shapes.roller, shapes.inner_ring, shapes.outer_ring):
        print(len(mesh_of(shape).points))
assert "gmsh" not in sys.modules
"""
    done = run_without_gmsh(code, tmp_path)
    assert done.returncode == 0, done.stderr
    counts = [int(line) for line in done.stdout.split()]
    assert counts == [len(make(shape).points) for size in (1.0, 2.0) for shape in built_in_shapes(size)]


def test_without_gmsh_another_bearing_says_what_to_install(tmp_path):
    code = "from meshes import Disc, mesh_of; mesh_of(Disc(radius=0.0037, layers=3))"
    done = run_without_gmsh(code, tmp_path)
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("RuntimeError: gmsh can't be loaded (libGLU.so.1: cannot open shared object file)")
    assert "apt-get install --no-install-recommends libgl1 libglu1-mesa libxft2" in last
