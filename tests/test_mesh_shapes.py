"""gmsh's cross-sections: nodes where the contact weights expect them, cells that tile the shape, bounded distortion."""

import os
import signal
from collections import Counter
from itertools import pairwise
from math import pi, sin, sqrt, tan

import numpy as np
import pytest

from lagrange.scene.scene import read_scene
from meshes import Annulus, Disc, Mesh, bearing_shapes, quality
from meshes.shapes import RIM, make

DISCS = [Disc(radius=0.005, layers=layers) for layers in (1.5, 2, 2.5, 3, 5.5, 7)]
RINGS = [
    Annulus(inner_radius=0.0125, outer_radius=0.018, sectors=56, layers=3),
    Annulus(inner_radius=0.028, outer_radius=0.0325, sectors=88, layers=2),
    Annulus(inner_radius=0.001, outer_radius=0.05, sectors=32, layers=5),
]


def cell_areas(mesh):
    x, y = np.moveaxis(mesh.points[mesh.cells], -1, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


def edges(mesh):
    """How often each edge is used, by its sorted nodes."""
    ends = np.stack([mesh.cells, np.roll(mesh.cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    return Counter(map(tuple, np.sort(ends, axis=1).tolist()))


def polygon_area(radius, corners):
    return 0.5 * corners * radius**2 * sin(2.0 * pi / corners)


@pytest.mark.parametrize("disc", DISCS)
def test_a_disc_has_six_more_nodes_in_every_layer_and_the_surface_last(disc):
    mesh = make(disc)
    whole = disc.layers == int(disc.layers)
    counts = [1 if whole else 3]
    while counts[-1] < 6 * disc.layers:
        counts.append(6 if counts == [1] else counts[-1] + 6)
    assert mesh.points.shape == (sum(counts), 2)
    assert mesh.cells.shape == ((6 if whole else 1) + sum(map(sum, pairwise(counts[whole:]))), 3)
    surface = mesh.points[-disc.surface_nodes :]
    # positions are closed-form; 1e-15 relative is the round-off of a cosine
    np.testing.assert_allclose(np.hypot(*surface.T), disc.radius, rtol=1e-15 * 4)
    angles = np.unwrap(np.arctan2(surface[:, 1], surface[:, 0]))
    np.testing.assert_allclose(angles, 2.0 * pi * np.arange(disc.surface_nodes) / disc.surface_nodes, atol=1e-14)
    assert disc.surface_spacing == pytest.approx(np.diff(angles).mean() * disc.radius, rel=1e-13)


@pytest.mark.parametrize("ring", RINGS)
def test_a_ring_has_equal_sectors_and_equidistant_rows(ring):
    mesh = make(ring)
    assert mesh.points.shape == ((ring.layers + 1) * ring.sectors, 2)
    assert mesh.cells.shape == (ring.layers * ring.sectors, 4)
    rows = mesh.points.reshape(ring.layers + 1, ring.sectors, 2)
    radii = np.hypot(rows[..., 0], rows[..., 1])
    wanted = np.linspace(ring.inner_radius, ring.outer_radius, ring.layers + 1)
    np.testing.assert_allclose(radii, np.repeat(wanted[:, None], ring.sectors, axis=1), rtol=4e-15)
    angles = np.unwrap(np.arctan2(rows[..., 1], rows[..., 0]), axis=1)
    np.testing.assert_allclose(
        angles, np.tile(2.0 * pi * np.arange(ring.sectors) / ring.sectors, (len(rows), 1)), atol=1e-13
    )


@pytest.mark.parametrize("shape", DISCS + RINGS)
def test_cells_tile_the_shape_without_holes_or_overlap(shape):
    mesh = make(shape)
    areas = cell_areas(mesh)
    assert areas.min() > 0.0, "cells run counter-clockwise"
    if isinstance(shape, Disc):
        wanted, rims, holes = polygon_area(shape.radius, shape.surface_nodes), shape.surface_nodes, 0
    else:
        wanted = polygon_area(shape.outer_radius, shape.sectors) - polygon_area(shape.inner_radius, shape.sectors)
        rims, holes = 2 * shape.sectors, 1
    assert areas.sum() == pytest.approx(wanted, rel=1e-12)  # summed round-off of a thousand cells
    count = edges(mesh)
    assert set(count.values()) == {1, 2}
    assert sum(n == 1 for n in count.values()) == rims
    assert len(mesh.points) - len(count) + len(mesh.cells) == 1 - holes, "Euler's formula"


def test_every_cell_of_a_ring_joins_neighbouring_rows_and_sectors():
    ring = RINGS[0]
    row, sector = np.divmod(make(ring).cells, ring.sectors)
    assert np.all(np.ptp(row, axis=1) == 1)
    apart = np.abs(sector[:, :, None] - sector[:, None, :])
    assert np.minimum(apart, ring.sectors - apart).max() == 1


@pytest.mark.parametrize("layers", [2, 3, 4, 5, 8, 13, 20, 2.5, 3.5, 4.5, 9.5, 20.5])
def test_triangles_of_a_disc_stay_near_equilateral(layers):
    disc = Disc(radius=0.005, layers=layers)
    found = quality(make(disc))
    whole = layers == int(layers)
    # the sharpest where wedges meet: a row of 6k nodes and one of 6 (k + 1), found 44.4° ... 47.6°, or a row's node and
    # the gap of the next, 2 atan(½·√3/2.5) = 38.2°; found at most 89.4°
    assert found.smallest_angle > (43.0 if whole else 38.0)
    assert found.largest_angle < 90.0
    # radial steps are R/(layers − 1 + RIM), arcs 2πR/(6 layers); a triangle's longest edge crosses a layer
    step = disc.radius / (layers - 1.0 + RIM)
    assert found.smallest_edge == pytest.approx(step if whole else 0.5 * sqrt(3.0) * step, rel=1e-12)
    assert found.largest_edge < 1.48 * step


@pytest.mark.parametrize("layers", [2, 3, 5, 1.5, 2.5, 4.5])
def test_a_disc_looks_the_same_turned_and_mirrored(layers):
    disc = Disc(radius=1.0, layers=layers)
    mesh = make(disc)

    def corners(points):
        """Triangles as sorted nodes of the mesh, by place."""
        index = {tuple(np.round(p, 9) + 0.0): i for i, p in enumerate(mesh.points)}
        node = np.array([index[tuple(np.round(p, 9) + 0.0)] for p in points])
        return set(map(tuple, np.sort(node[mesh.cells], axis=1).tolist()))

    turn = 2.0 * pi / disc.repeats
    turned = mesh.points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert corners(turned) == corners(mesh.points)
    assert corners(mesh.points * [1.0, -1.0]) == corners(mesh.points)


@pytest.mark.parametrize("ring", RINGS)
def test_quadrilaterals_of_a_ring_are_off_the_right_angle_by_half_a_sector(ring):
    found = quality(make(ring))
    assert found.smallest_angle == pytest.approx(90.0 - 180.0 / ring.sectors, abs=1e-9)
    assert found.largest_angle == pytest.approx(90.0 + 180.0 / ring.sectors, abs=1e-9)


def test_quality_measures_a_known_triangle_and_square():
    triangle = Mesh(points=np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0 * tan(pi / 6.0)]]), cells=np.array([[0, 1, 2]]))
    found = quality(triangle)
    assert (found.nodes, found.cells) == (3, 1)
    assert found.smallest_angle == pytest.approx(30.0, abs=1e-12)
    assert found.largest_angle == pytest.approx(90.0, abs=1e-12)
    assert found.smallest_edge == pytest.approx(2.0 * tan(pi / 6.0), rel=1e-14)
    assert found.largest_edge == pytest.approx(2.0 / np.cos(pi / 6.0), rel=1e-14)
    square = Mesh(points=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), cells=np.array([[0, 1, 2, 3]]))
    assert quality(square).smallest_angle == pytest.approx(90.0, abs=1e-12)


@pytest.mark.parametrize("size_mm", [0.3, 0.5, 1.0, 2.0])
def test_a_bearings_shapes_have_the_surface_spacing_asked_for(size_mm):
    bearing, size = read_scene().ideal_bearing(), 1e-3 * size_mm
    shapes = bearing_shapes(bearing, size)
    assert (shapes.inner_ring.sectors % 8, shapes.outer_ring.sectors % 8) == (0, 0)
    # rounding to 6 or 8 nodes more or less
    assert shapes.roller.surface_spacing == pytest.approx(size, rel=3.0 / shapes.roller.surface_nodes + 0.01)
    for ring, raceway in (
        (shapes.inner_ring, bearing.inner_raceway_radius),
        (shapes.outer_ring, bearing.outer_raceway_radius),
    ):
        assert 2.0 * pi * raceway / ring.sectors == pytest.approx(size, rel=4.0 / ring.sectors + 0.01)
        assert (ring.outer_radius - ring.inner_radius) / ring.layers == pytest.approx(size, rel=0.2)
    assert (shapes.inner_ring.inner_radius, shapes.inner_ring.outer_radius) == (
        bearing.bore_radius,
        bearing.inner_raceway_radius,
    )
    assert (shapes.outer_ring.inner_radius, shapes.outer_ring.outer_radius) == (
        bearing.outer_raceway_radius,
        bearing.outside_radius,
    )


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
