"""The critical time step of leapfrog, 2/ω_max, with the contacts' stiffness in it."""

from collections.abc import Iterator
from dataclasses import replace
from math import ceil, inf, log2, sqrt

import numpy as np
from scipy import sparse

from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.model import Model
from fem.elastic.bodies import DiscBody, RingBody
from fem.elastic.bored import BoredRing
from fem.elastic.kept import kept
from fem.elastic.supported import LooseRing
from lagrange.mounting import HELD, Housing, Mounting

# what of a spring k counts on each of two elastic bodies; on an elastic one that meets a rigid one, and on the latter
EVENLY, LIGHT, HEAVY = 2.0, 10.0 / 9.0, 10.0
# times that a bore's springs count: a node then swings on its own by at most 0.29 rad in a step. Nodes meet and leave
# the bore all the time, and in larger steps what each meeting misses of the energy is more than the next kicks repay
FINELY = 40.0
RUNGS = 8  # an octave of forces: under the next rung's the paper's bearing has a step that is at most 1e-3 shorter
LANCZOS_TOLERANCE = 1e-6  # of ω²; with 1e-4 the fastest of a ring's clustered modes is missed by up to 1e-3


def critical_time_step(model: Model, largest_force: float, mounting: Mounting = HELD, hub_mass: float = inf) -> float:
    """2/ω_max, s, of all bodies with every contact closed at LOAD_MARGIN times `largest_force`, N.

    A spring k between two bodies is counted as 2k on each: k (a + b)² <= 2k a² + 2k b², so no coupled mode is
    faster than the fastest body. Where one of them is rigid, and moves with its whole mass, as LIGHT k on the other and
    HEAVY k on itself, which is as true. Friction, its springs and dashpots are implicit and do not count. A housing's
    own springs k on its mass m add at most k/m to any ω², and so do a shaft's on the mass, kg, that moves with the hub;
    of both the larger counts.

    Errors
    ------
    Lanczos approaches ω_max² from below; its tolerance is added.
    """
    bodies = [(body.shape, body.material) for body in (model.roller, model.inner_ring, model.outer_ring)]
    perfect = replace(model.bearing, faults=())  # what surfaces lack makes no contact stiffer
    housing, shaft = mounting.housing, mounting.shaft
    carried = tuple(part for part in (housing, shaft) if part is not None)
    of_mount = 0.0 if housing is None else housing.stiffness / housing.mass
    if shaft is not None:
        of_mount, carried = max(of_mount, shaft.stiffness / hub_mass), (*carried, hub_mass)
    if isinstance(model.outer_ring, BoredRing):
        carried = (*carried, model.outer_ring.stiffness)
    elif isinstance(model.outer_ring, LooseRing):  # held at points: all of it counts as free
        carried = (*carried, "free outer ring")
    key = repr((type(model).__name__, perfect, bodies, model.laws, largest_force, *carried))
    found = kept("step", key, lambda: {"critical": np.array(_found(model, largest_force, housing, of_mount))})
    return float(found["critical"])


def next_rung(force: float) -> float:
    """The least of some forces that is not below this one, N: scenes under other loads mostly share their step."""
    return 2.0 ** (ceil(RUNGS * log2(max(force, 1.0))) / RUNGS)


def _found(model: Model, largest_force: float, housing: Housing | None, of_mount: float) -> float:
    force = LOAD_MARGIN * max(largest_force, 1.0)
    springs, ring = model.springs(force), model.outer_ring
    if isinstance(ring, BoredRing):
        springs["outer_ring"] = sparse.hstack([springs["outer_ring"], ring.springs(FINELY)])
        of_mount += 0.0 if housing is None else HEAVY * 0.5 * ring.n_sectors * ring.stiffness / housing.mass
    limits = {"roller": _disc_limit, "inner_ring": _ring_limit, "outer_ring": _ring_limit}
    elastic = [name for name in limits if not getattr(model, name).material.rigid]
    found = [limits[name](getattr(model, name), springs[name]) for name in elastic]
    if len(elastic) < len(limits):
        found.extend(_rigid_limits(model, force, housing))
    return 2.0 / sqrt(max(found) * (1.0 + LANCZOS_TOLERANCE) + of_mount)


def _rigid_limits(model: Model, force: float, housing: Housing | None) -> Iterator[float]:
    """Largest ω², 1/s², or more, of the bodies that move as a whole; the inner ring's without the shaft's mass."""
    inner, outer, between = model.stiffnesses(force)
    if model.roller.material.rigid:
        yield (HEAVY * (inner + outer) + 2.0 * EVENLY * between) / model.roller.total_mass
    if model.inner_ring.material.rigid:
        yield model.bearing.n_rollers * HEAVY * inner / model.inner_ring.total_mass
    if model.outer_ring.material.rigid and housing is not None:
        yield model.bearing.n_rollers * HEAVY * outer / (housing.mass + model.outer_ring.total_mass)


def _disc_limit(disc: DiscBody, springs: sparse.csc_matrix) -> float:
    """Largest ω², 1/s², of a disc on springs."""
    return _largest(disc.stiffness, springs, 1.0 / np.sqrt(np.repeat(disc.mass, 2)))


def _ring_limit(ring: RingBody, springs: sparse.csc_matrix) -> float:
    """Largest ω², 1/s², of a held ring on springs; held at points, of a free one, which is not less."""
    free = (2 * ring.n_sectors * ring.free_rows[:, None] + np.arange(2 * ring.n_sectors)).ravel()
    stiffness, springs = ring.matrix[free][:, free].tocsr(), springs[free]
    scale = 1.0 / np.sqrt(np.repeat(ring.row_mass[ring.free_rows], 2 * ring.n_sectors))
    return _largest(stiffness, springs, scale)


def _largest(stiffness: sparse.csr_matrix, springs: sparse.csc_matrix, scale: np.ndarray) -> float:
    """Largest eigenvalue of stiffness, springs with it, scaled by 1/√mass on either side."""
    from scipy.sparse.linalg import LinearOperator, eigsh  # takes its time to load, and a step that is kept needs none

    def apply(vector):
        u = scale * vector.ravel()
        return scale * (stiffness @ u + springs @ (springs.T @ u))

    operator = LinearOperator((scale.size, scale.size), matvec=apply, dtype=float)
    start = np.random.default_rng(0).standard_normal(scale.size)  # seeded: the same scene gets the same step
    return float(eigsh(operator, k=1, which="LA", v0=start, tol=LANCZOS_TOLERANCE, return_eigenvectors=False)[0])
