"""Meshes, matrices and kernels on disk: made once, damaged ones made again; what gmsh's meshes are."""

import io
import os
import shutil
import signal
import subprocess
import sys
import zipfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from math import pi, sin, sqrt, tan
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

import fem.kernels
import meshes
from fem.elastic.cache import LARGEST, kept
from fem.kernels.kernel_folder import cache_folder, digest, version
from lagrange.files.output import write_sealed
from meshes import Annulus, Disc, Mesh, bearing_shapes, cache, mesh_of, quality
from meshes.shapes import RIM, make
from tests.reference.kit import PAPER
from tests.waiting import GIVE_UP

DISC = Disc(radius=0.0037, layers=3)  # of no shipped bearing
RING = Annulus(inner_radius=0.0111, outer_radius=0.0151, sectors=40, layers=2)
SHIPPED = Path(meshes.__file__).parent / "data"
ROOT = Path(meshes.__file__).parent.parent


def built_in_shapes():
    found = [bearing_shapes(PAPER, size) for size in (1e-3, 2e-3)]
    return [shape for shapes in found for shape in (shapes.roller, shapes.inner_ring, shapes.outer_ring)]


def assert_same(found, wanted):
    assert found.points.tobytes() == wanted.points.tobytes() and found.cells.tobytes() == wanted.cells.tobytes()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    place = tmp_path / "cache" / "meshes"
    monkeypatch.setattr(cache, "cache_folder", lambda: place)
    return place


@pytest.fixture
def meshed(monkeypatch):
    asked = []
    monkeypatch.setattr(cache, "make", lambda shape: asked.append(shape) or make(shape))
    return asked


@pytest.mark.parametrize("shape", [DISC, RING])
def test_a_mesh_is_made_once_and_then_read_and_always_the_same_bytes(shape, folder, meshed, tmp_path):
    first, second = mesh_of(shape), mesh_of(shape)
    assert meshed == [shape] and [entry.name for entry in folder.iterdir()] == [cache.file_name(shape)]
    assert_same(second, first)
    for name in ("first.npy", "second.npy"):
        cache.write(tmp_path / name, make(shape))
    assert (tmp_path / "first.npy").read_bytes() == (tmp_path / "second.npy").read_bytes()


def test_file_names_tell_shapes_and_recipes_apart(monkeypatch):
    shapes = DISC, RING, Disc(radius=0.0037, layers=4), Disc(radius=np.nextafter(0.0037, 1.0), layers=3)
    names = {cache.file_name(shape) for shape in shapes}
    assert len(names) == 4
    monkeypatch.setattr(cache, "RECIPE", cache.RECIPE + 1)
    assert cache.file_name(DISC) not in names


def changed(cells, at, value):
    cells = cells.copy()
    cells[at] = value
    return cells


DAMAGE = {  # to the file of a mesh: another mesh, array or bytes, or how much of it is left
    "empty": lambda mesh: b"", "cut in the header": lambda mesh: 0.005, "cut in the cells": lambda mesh: 0.9,
    "text": lambda mesh: b"nodes and cells\n", "zeros": lambda mesh: b"\0" * 1000,
    "binary garbage": lambda mesh: np.random.default_rng(1).bytes(4000),
    "another shape": lambda mesh: make(Disc(radius=0.0037, layers=2)),
    "a cell the wrong way round": lambda mesh: changed(mesh.cells, 3, mesh.cells[3][::-1]),
    "a node that is not there": lambda mesh: changed(mesh.cells, (0, 0), 10_000),
    "a pickle": lambda mesh: np.array([[{}]], dtype=object),
    "a missing cell": lambda mesh: Mesh(points=mesh.points, cells=mesh.cells[1:]),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_entry_is_made_again_and_mended(damage, folder, meshed):
    wanted, path = mesh_of(DISC), folder / cache.file_name(DISC)
    good, what = path.read_bytes(), DAMAGE[damage](wanted)
    if isinstance(what, Mesh):
        cache.write(path, what)
    elif isinstance(what, np.ndarray):
        np.save(path, what, allow_pickle=True)
    else:
        path.write_bytes(what if isinstance(what, bytes) else good[: int(what * len(good))])
    assert path.read_bytes() != good
    assert_same(mesh_of(DISC), wanted)
    assert len(meshed) == 2 and path.read_bytes() == good and len(list(folder.iterdir())) == 1


@pytest.mark.parametrize(("place", "refusal"), [
    ("os.replace", OSError(28, "No space left on device")),
    ("lagrange.files.output.write_whole", PermissionError(13, "Permission denied")),
    ("lagrange.files.output.write_whole", OSError(30, "Read-only file system")), (None, None),  # a file is in its way
])  # fmt: skip
def test_a_cache_that_cannot_be_written_costs_a_meshing(place, refusal, folder, meshed, monkeypatch, tmp_path):
    def refuse(*_, **__):
        raise refusal

    if place is None:
        (tmp_path / "cache").write_text("in the way")
    else:
        monkeypatch.setattr(place, refuse)
    for _ in range(2):
        assert_same(mesh_of(DISC), make(DISC))
    assert meshed == [DISC, DISC] and (not folder.exists() or list(folder.iterdir()) == [])


def test_writers_of_the_same_entry_do_not_disturb_readers(folder):
    mesh, path = make(DISC), folder / cache.file_name(DISC)
    cache.write(path, mesh)
    with ThreadPoolExecutor(4) as pool:
        writing = [pool.submit(cache.write, path, mesh) for _ in range(20)]
        while not all(future.done() for future in writing):
            assert_same(cache._read(path, DISC), mesh)
        for future in writing:
            future.result()
    assert len(list(folder.iterdir())) == 1


def test_shipped_meshes_are_what_gmsh_makes_now_and_all_are_used(folder, meshed, tmp_path):
    for shape in built_in_shapes():
        fresh = make(shape)
        assert_same(mesh_of(shape), fresh)
        cache.write(tmp_path / "fresh.npy", fresh)
        assert (SHIPPED / cache.file_name(shape)).read_bytes() == (tmp_path / "fresh.npy").read_bytes()
    assert meshed == [] and not folder.exists()
    assert {path.name for path in SHIPPED.glob("*.npy")} == {cache.file_name(shape) for shape in built_in_shapes()}


def test_the_built_in_scene_needs_no_gmsh_and_another_bearing_says_what_to_install(tmp_path):
    """Where `import gmsh` fails as it does without libGLU."""
    (fake := tmp_path / "fake").mkdir()
    (fake / "gmsh.py").write_text('raise ImportError("libGLU.so.1: cannot open shared object file")\n')
    environment = dict(os.environ, PYTHONPATH=f"{fake}{os.pathsep}{ROOT}", XDG_CACHE_HOME=str(tmp_path / "xdg"))
    how = {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True, "timeout": GIVE_UP}
    code = """
import sys
from lagrange.scene.scene import read_scene
from meshes import Disc, bearing_shapes, mesh_of
for size in (1e-3, 2e-3):
    shapes = bearing_shapes(read_scene().ideal_bearing(), size)
    for shape in (shapes.roller, shapes.inner_ring, shapes.outer_ring):
        print(len(mesh_of(shape).points))
assert "gmsh" not in sys.modules
mesh_of(Disc(radius=0.0037, layers=3))
"""
    done = subprocess.run([sys.executable, "-c", code], **how)
    assert [int(line) for line in done.stdout.split()] == [len(make(shape).points) for shape in built_in_shapes()]
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("RuntimeError: gmsh can't be loaded (libGLU.so.1: cannot open shared object file)")
    assert "apt-get install --no-install-recommends libgl1 libglu1-mesa libxft2" in last


# Results kept on disk: made once, and made anew where the file is damaged or the folder can't be written
@pytest.fixture
def folder_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("meshes.cache.cache_folder", lambda: tmp_path / "meshes")
    return tmp_path / "kept"


def maker(size=3):
    return mock.Mock(side_effect=lambda: {"a": np.arange(size, dtype=float), "b": np.array(2.5)})


def test_results_are_made_once_by_kind_and_key_and_large_ones_not_kept(folder_kept):
    make = maker()
    for kind, key in 2 * (("some", "key"), ("some", "other"), ("more", "key")):
        found = kept(kind, key, make)
        assert found["a"].tolist() == [0.0, 1.0, 2.0] and float(found["b"]) == 2.5
    assert make.call_count == 3
    kept("large", "key", maker(size=int(LARGEST / 8) + 1))
    assert len(list(folder_kept.rglob("*.npz"))) == 3


@pytest.mark.parametrize("damage", [b"", b"no archive", "flipped", "sealed", "in the way"])
def test_a_damaged_result_is_made_anew_and_a_folder_that_cannot_be_written_costs_time_only(folder_kept, damage):
    make = maker()
    if damage == "in the way":
        folder_kept.write_text("a file where the folder should be")
    kept("some", "key", make)
    if damage != "in the way":
        (path,) = folder_kept.iterdir()
        data = bytearray(path.read_bytes())
        data[len(data) // 3] ^= 255
        if damage == "sealed":
            with zipfile.ZipFile(archive := io.BytesIO(), "w") as file:
                file.writestr("a.npy", b"no array")
            write_sealed(path, archive.getvalue())
        else:
            path.write_bytes(bytes(data) if damage == "flipped" else damage)
    for _ in range(2 if damage != "in the way" else 1):
        assert kept("some", "key", make)["a"].tolist() == [0.0, 1.0, 2.0]
        assert make.call_count == 2, "the damaged entry has been replaced"


def test_a_change_of_any_module_makes_kernels_anew(tmp_path):
    folder = tmp_path / "kernels"
    shutil.copytree(Path(fem.kernels.__file__).parent, folder, ignore=shutil.ignore_patterns("__pycache__"))
    found, modules = {digest(folder)}, sorted(folder.rglob("*.py"))
    assert cache_folder().name == version() and {version().removesuffix("-checked")} == found
    for module in modules:
        text = module.read_bytes()
        module.write_bytes(text + b"\n# changed")
        found.add(digest(folder))
        module.write_bytes(text)
    assert len(found) == 1 + len(modules) > 20
    (folder / "new.py").write_text("")
    assert digest(folder) not in found


# gmsh's cross-sections: nodes where the contact weights expect them, cells that tile the shape, bounded
DISCS = [Disc(radius=0.005, layers=layers) for layers in (1.5, 2, 2.5, 3, 5.5, 7)]
RINGS = [
    Annulus(inner_radius=inner, outer_radius=outer, sectors=sectors, layers=layers)
    for inner, outer, sectors, layers in ((0.0125, 0.018, 56, 3), (0.028, 0.0325, 88, 2), (0.001, 0.05, 32, 5))
]


@pytest.mark.parametrize("shape", DISCS + RINGS)
def test_cells_tile_the_shape_without_holes_or_overlap(shape):
    mesh, disc = make(shape), isinstance(shape, Disc)
    x, y = np.moveaxis(mesh.points[mesh.cells], -1, 0)
    areas = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    around, layers = (shape.surface_nodes if disc else shape.sectors), shape.layers
    rims, holes = (around, 0) if disc else (2 * around, 1)
    square = shape.radius**2 if disc else shape.outer_radius**2 - shape.inner_radius**2
    wanted = 0.5 * around * square * sin(2.0 * pi / around)  # of polygons
    assert areas.min() > 0.0, "cells run counter-clockwise"
    assert areas.sum() == pytest.approx(wanted, rel=1e-12)  # summed round-off of a thousand cells
    ends = np.stack([mesh.cells, np.roll(mesh.cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    count = Counter(map(tuple, np.sort(ends, axis=1).tolist()))  # how often each edge is used
    assert set(count.values()) == {1, 2} and sum(n == 1 for n in count.values()) == rims
    assert len(mesh.points) - len(count) + len(mesh.cells) == 1 - holes, "Euler's formula"
    # where contact weights expect them: a disc's surface last, a ring's rows from the inside, each from angle 0 on
    radii = [shape.radius] if disc else np.linspace(shape.inner_radius, shape.outer_radius, layers + 1)
    places = np.outer(radii, np.exp(2j * pi * np.arange(around) / around)).ravel()
    np.testing.assert_allclose(mesh.points[-places.size :] @ [1.0, 1j], places, rtol=0.0, atol=1e-14 * radii[-1])
    inside = 1.0 + 3.0 * layers * (layers + 1.0) if layers == int(layers) else 3.0 * (layers + 0.5) ** 2
    assert len(mesh.points) == (inside if disc else places.size) and mesh.cells.shape[1] == (3 if disc else 4)
    if disc:
        assert shape.surface_spacing == pytest.approx(2.0 * pi * shape.radius / around, rel=1e-13)
    else:  # off the right angle by half a sector
        found = quality(mesh)
        wanted = 90.0 - 180.0 / around, 90.0 + 180.0 / around
        assert (found.smallest_angle, found.largest_angle) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("layers", [2, 3, 4, 5, 8, 13, 20, 1.5, 2.5, 3.5, 4.5, 9.5, 20.5])
def test_triangles_of_a_disc_stay_near_equilateral_and_look_the_same_turned_and_mirrored(layers):
    disc = Disc(radius=0.005, layers=layers)
    mesh, whole = make(disc), layers == int(layers)
    found = quality(mesh)
    # the sharpest where wedges meet: a row of 6k nodes and one of 6 (k + 1), found 44.4° ... 47.6°, or a row's node and
    # the gap of the next, 2 atan(½·√3/2.5) = 38.2°; found at most 89.4°
    # radial steps are R/(layers − 1 + RIM), arcs 2πR/(6 layers); a triangle's longest edge crosses a layer
    step = disc.radius / (layers - 1.0 + RIM)
    if layers > 1.5:
        assert found.smallest_angle > (43.0 if whole else 38.0) and found.largest_angle < 90.0
        assert found.smallest_edge == pytest.approx(step if whole else 0.5 * sqrt(3.0) * step, rel=1e-12)
        assert found.largest_edge < 1.48 * step
    places, turn = [tuple(np.round(p / disc.radius, 9) + 0.0) for p in mesh.points], 2.0 * pi / disc.repeats
    index = {place: i for i, place in enumerate(places)}

    def corners(points):
        """Triangles as sorted nodes of the mesh, by place."""
        node = np.array([index[tuple(np.round(p / disc.radius, 9) + 0.0)] for p in points])
        return set(map(tuple, np.sort(node[mesh.cells], axis=1).tolist()))

    turned = mesh.points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert corners(turned) == corners(mesh.points * [1.0, -1.0]) == corners(mesh.points)


def test_quality_measures_a_known_triangle_and_square():
    height = 2.0 * tan(pi / 6.0)
    found = quality(Mesh(points=np.array([[0.0, 0.0], [2.0, 0.0], [0.0, height]]), cells=np.array([[0, 1, 2]])))
    told = found.nodes, found.cells, found.smallest_angle, found.largest_angle
    assert told == pytest.approx((3, 1, 30.0, 90.0), abs=1e-12)
    assert (found.smallest_edge, found.largest_edge) == pytest.approx((height, 2.0 / np.cos(pi / 6.0)), rel=1e-14)
    square = Mesh(points=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), cells=np.array([[0, 1, 2, 3]]))
    assert quality(square).smallest_angle == pytest.approx(90.0, abs=1e-12)


@pytest.mark.parametrize("size_mm", [0.3, 0.5, 1.0, 2.0])
def test_a_bearings_shapes_have_the_surface_spacing_asked_for(size_mm):
    size, shapes = 1e-3 * size_mm, bearing_shapes(PAPER, 1e-3 * size_mm)
    inner, outer = shapes.inner_ring, shapes.outer_ring
    # rounding to 6 or 8 nodes more or less
    assert shapes.roller.surface_spacing == pytest.approx(size, rel=3.0 / shapes.roller.surface_nodes + 0.01)
    for ring, raceway in ((inner, PAPER.inner_raceway_radius), (outer, PAPER.outer_raceway_radius)):
        assert ring.sectors % 8 == 0
        assert 2.0 * pi * raceway / ring.sectors == pytest.approx(size, rel=4.0 / ring.sectors + 0.01)
        assert (ring.outer_radius - ring.inner_radius) / ring.layers == pytest.approx(size, rel=0.2)
    assert (inner.inner_radius, inner.outer_radius) == (PAPER.bore_radius, PAPER.inner_raceway_radius)
    assert (outer.inner_radius, outer.outer_radius) == (PAPER.outer_raceway_radius, PAPER.outside_radius)


@pytest.mark.skipif(os.name != "posix", reason="POSIX signals")
def test_meshing_leaves_signals_with_those_who_listen():
    """gmsh sets SIGTERM to its default as it starts, unseen by Python's signal module."""
    heard = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: heard.append(number))
    try:
        make(DISCS[1])
        os.kill(os.getpid(), signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert heard == [signal.SIGTERM]
