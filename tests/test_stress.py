"""Stress from displacements, and what is read from it."""

from math import sqrt

import numpy as np
import pytest

from fem.elastic.bodies import max_shear, stress_operator, turned, von_mises
from lagrange import Material
from meshes import Annulus, Disc, mesh_of

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)


@pytest.mark.parametrize(
    "shape",
    [Disc(radius=5e-3, layers=3), Annulus(inner_radius=12.5e-3, outer_radius=18e-3, sectors=56, layers=3)],
)
@pytest.mark.parametrize(
    "gradient, mises, shear",
    [
        ([[1e-4, 0.0], [0.0, 0.0]], 2.0 * STEEL.lame_mu * 1e-4, STEEL.lame_mu * 1e-4),  # λ adds alike to all three
        ([[0.0, 1e-4], [0.0, 0.0]], sqrt(3.0) * STEEL.lame_mu * 1e-4, STEEL.lame_mu * 1e-4),
        ([[1e-4, 0.0], [0.0, 1e-4]], 2.0 * STEEL.lame_mu * 1e-4, 0.0),
        ([[0.0, 1e-4], [-1e-4, 0.0]], 0.0, 0.0),  # a rotation
    ],
)
def test_stress_of_a_uniform_strain_is_exact(shape, gradient, mises, shear):
    mesh = mesh_of(shape)
    displacement = mesh.points @ np.array(gradient).T
    stress = (stress_operator(mesh.points, mesh.cells, STEEL) @ displacement.ravel()).reshape(-1, 3)
    n = len(mesh.points)
    assert von_mises(stress, STEEL.poisson_ratio) == pytest.approx(np.full(n, mises), rel=1e-9, abs=1.0)
    assert max_shear(stress) == pytest.approx(np.full(n, shear), rel=1e-9, abs=1.0)


def test_a_turned_stress_is_the_tensor_rotated():
    rng = np.random.default_rng(3)
    stress, angle = rng.normal(size=(5, 3)), rng.uniform(-4.0, 4.0, 5)
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=1)
    tensor = np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=1)
    expected = rotation @ tensor @ np.swapaxes(rotation, 1, 2)
    found = turned(stress, angle)
    assert found[:, 0] == pytest.approx(expected[:, 0, 0])
    assert found[:, 1] == pytest.approx(expected[:, 1, 1])
    assert found[:, 2] == pytest.approx(expected[:, 0, 1])
    assert max_shear(found) == pytest.approx(max_shear(stress))
    assert von_mises(found, 0.3) == pytest.approx(von_mises(stress, 0.3))
