"""Stress from nodal displacement, and what is read from it. A stress is (..., 3): xx, yy, xy, Pa; zz = ν (xx + yy)."""

import numpy as np
from scipy import sparse

from lagrange import Material

TRIANGLE = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]), 0.5
QUADRILATERAL = 0.25 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]), 4.0  # bilinear, at the centre


def stress_operator(points: np.ndarray, cells: np.ndarray, material: Material) -> sparse.csr_matrix:
    """Matrix from nodal displacements to nodal stresses in plane strain: the elements' ones, averaged by area.

    Parameters
    ----------
    points : (n_nodes, 2), m; cells : (n_cells, 3 or 4)

    Returns
    -------
    csr_matrix, (3 n_nodes, 2 n_nodes), Pa/m, of vectors with the node as slow index

    Errors
    ------
    Exact for a uniform strain. One stress per element, at its centre: on a surface it lags half an element behind.
    """
    n_nodes, corners = len(points), cells.shape[1]
    shape, size = TRIANGLE if corners == 3 else QUADRILATERAL
    jacobian = np.einsum("kci,kj->cij", np.moveaxis(points[cells], 1, 0), shape)
    gradient = np.einsum("kj,cji->cki", shape, np.linalg.inv(jacobian))
    lame_lambda, lame_mu = material.lame_lambda, material.lame_mu
    gx, gy = gradient[..., 0], gradient[..., 1]  # (cell, corner)
    per_cell = np.empty((len(cells), 3, corners, 2))
    per_cell[:, 0, :, 0], per_cell[:, 0, :, 1] = (lame_lambda + 2.0 * lame_mu) * gx, lame_lambda * gy
    per_cell[:, 1, :, 0], per_cell[:, 1, :, 1] = lame_lambda * gx, (lame_lambda + 2.0 * lame_mu) * gy
    per_cell[:, 2, :, 0], per_cell[:, 2, :, 1] = lame_mu * gy, lame_mu * gx

    area = size * np.linalg.det(jacobian)
    total = np.bincount(cells.ravel(), np.repeat(area, corners), n_nodes)
    share = area[:, None] / total[cells]  # (cell, node averaged to)
    values = share[:, :, None, None, None] * per_cell[:, None]
    rows = 3 * cells[:, :, None, None, None] + np.arange(3)[:, None, None]
    columns = 2 * cells[:, None, None, :, None] + np.arange(2)
    rows, columns = np.broadcast_arrays(rows, columns)
    return sparse.csr_matrix(
        (values.ravel(), (rows.ravel(), columns.ravel())), shape=(3 * n_nodes, 2 * n_nodes)
    )  # fmt: skip


def turned(stress: np.ndarray, angle) -> np.ndarray:
    """The same stress in axes from which the given ones are turned by `angle`, rad, counter-clockwise."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    c, s = np.cos(2.0 * np.asarray(angle)), np.sin(2.0 * np.asarray(angle))
    half, xy = half * c - xy * s, half * s + xy * c
    return np.stack([mean + half, mean - half, xy], axis=-1)


def von_mises(stress: np.ndarray, poisson_ratio) -> np.ndarray:
    """Von Mises stress in plane strain, Pa."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    zz = poisson_ratio * (xx + yy)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * xy**2)


def max_shear(stress: np.ndarray) -> np.ndarray:
    """Largest shear stress in the plane, half the difference of its principal stresses, Pa."""
    xx, yy, xy = np.moveaxis(stress, -1, 0)
    return np.hypot(0.5 * (xx - yy), xy)
