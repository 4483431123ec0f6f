"""The critical time step of leapfrog, 2/ω_max, with the contacts' stiffness in it."""

from math import sqrt

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from fem.bodies import DiscBody, RingBody
from fem.model import Model
from fem.subgrid import ContactLaw, disc_patch_force, ring_patch_force

LOAD_MARGIN = 10.0  # contacts are as stiff as at this many times the largest static force
LANCZOS_TOLERANCE = 1e-4  # relative, of ω²; the found value is that much too low at most


def critical_time_step(model: Model, largest_force: float) -> float:
    """2/ω_max, s, of all bodies with every contact closed at LOAD_MARGIN times `largest_force`, N.

    A spring k between two bodies is counted as 2k on each: k (a + b)² <= 2k a² + 2k b², so no coupled mode is
    faster than the fastest body. Friction is implicit and does not count.

    Errors
    ------
    Lanczos approaches ω_max² from below; its tolerance is added.
    """
    force = LOAD_MARGIN * max(largest_force, 1.0)
    inner, outer, between = (_stiffness(law, force) for law in (model.inner_law, model.outer_law, model.roller_law))
    fastest = max(
        _disc_limit(model.roller, [inner, outer, between]),
        _ring_limit(model.inner_ring, inner),
        _ring_limit(model.outer_ring, outer),
    )
    return 2.0 / sqrt(fastest * (1.0 + LANCZOS_TOLERANCE))


def _stiffness(law: ContactLaw, force: float) -> float:
    return law.stiffness(min(force, law.Q_line))


def _disc_limit(disc: DiscBody, stiffnesses: list[float]) -> float:
    """Largest ω², 1/s², of a disc with springs on separate patches of its surface."""
    scale = 1.0 / np.sqrt(np.repeat(disc.mass, 2))
    angles = 2.0 * np.pi * np.arange(len(stiffnesses)) / len(stiffnesses)
    patches = np.stack([disc_patch_force(disc, angle) for angle in angles], axis=1)

    def apply(vector):
        u = scale * vector.ravel()
        springs = patches @ (2.0 * np.asarray(stiffnesses) * (patches.T @ u))
        return scale * (disc.stiffness @ u + springs)

    return _largest(apply, scale.size)


def _ring_limit(ring: RingBody, stiffness: float) -> float:
    """Largest ω², 1/s², of a held ring with a spring on one patch."""
    rows = ring.free_rows
    scale = 1.0 / np.sqrt(ring.row_mass[rows])[:, None, None]
    load = ring_patch_force(ring, 0.0)

    def apply(vector):
        u = np.zeros((ring.n_rows, 2, ring.n_sectors))
        u[rows] = scale * vector.reshape(len(rows), 2, ring.n_sectors)
        force = ring.force(u) + 2.0 * stiffness * np.vdot(load, u) * load
        return (scale * force[rows]).ravel()

    return _largest(apply, 2 * len(rows) * ring.n_sectors)


def _largest(apply, size: int) -> float:
    operator = LinearOperator((size, size), matvec=apply, dtype=float)
    start = np.random.default_rng(0).standard_normal(size)  # seeded: the same scene gets the same step
    return float(eigsh(operator, k=1, which="LA", v0=start, tol=LANCZOS_TOLERANCE, return_eigenvectors=False)[0])
