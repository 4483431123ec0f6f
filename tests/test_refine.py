"""Refined triangles of a picture."""

import numpy as np
import pytest

from fem.pictures.bodies import refined
from meshes import Disc, mesh_of


@pytest.fixture(scope="module")
def finer():
    mesh = mesh_of(Disc(radius=5e-3, layers=5))
    contact = np.array([5e-3, 0.0])

    def wanted(middles):
        return np.maximum(0.2 * np.hypot(*(middles - contact).T), 2e-5)

    plane = np.column_stack([mesh.points, mesh.points @ [3.0, -2.0] + 1.0])
    return mesh, wanted, *refined(plane, mesh.cells, wanted)


def _areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_triangles_are_as_small_as_wanted(finer):
    _, wanted, data, triangles = finer
    corners = data[triangles, :2]
    longest = np.hypot(*(corners - np.roll(corners, 1, axis=1)).transpose(2, 0, 1)).max(axis=1)
    assert np.all(longest <= wanted(corners.mean(axis=1)))
    assert longest.min() < 2e-5 and longest.max() > 5e-4  # fine at the contact only


def test_the_same_area_is_covered_once(finer):
    mesh, _, data, triangles = finer
    areas = _areas(data[:, :2], triangles)
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(_areas(mesh.points, mesh.cells).sum(), rel=1e-12)


def test_no_node_hangs_on_an_edge(finer):
    mesh, _, data, triangles = finer
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    lone = data[edges[count == 1], :2].mean(axis=1)
    rim = mesh.points[-30:]
    normals = rim + np.roll(rim, -1, axis=0)  # every edge at one triangle only lies on a chord of the circle
    normals /= np.hypot(*normals.T)[:, None]
    height = np.max(lone @ normals.T, axis=1)
    assert height == pytest.approx(np.full(len(lone), 5e-3 * np.cos(np.pi / 30)), rel=1e-9)


def test_columns_are_carried_along(finer):
    mesh, _, data, _ = finer
    assert np.array_equal(data[: len(mesh.points), :2], mesh.points)
    assert data[:, 2] == pytest.approx(data[:, :2] @ [3.0, -2.0] + 1.0)
