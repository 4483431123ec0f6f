"""The critical time step of leapfrog with the reciprocal mass, the contacts' stiffness in it.

Equation (9) of docs/method.md.
"""

from dataclasses import replace
from math import ceil, inf, log2, sqrt

import numpy as np
from scipy import sparse

from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.model import EVENLY, HEAVY, Model
from fem.elastic.bodies import DiscBody
from fem.elastic.cache import kept
from fem.elastic.outer_support import BoredRing, LooseRing
from fem.elastic.reciprocal_mass import LUMPED, ReciprocalMass
from lagrange.mounting import HELD, Mounting

# times that a bore's springs count: a node then swings on its own by at most 0.29 rad in a step. Nodes meet and leave
# the bore all the time, and in larger steps what each meeting misses of the energy is more than the next kicks repay
FINELY = 40.0
RUNGS = 8  # an octave of forces: under the next rung's the paper's bearing has a step that is at most 1e-3 shorter
LANCZOS_TOLERANCE = 1e-6  # of ω²; with 1e-4 the fastest of a ring's clustered modes is missed by up to 1e-3
STEP_TOLERANCE = 2e-3  # of the step, where contacts shorten it
# times a body's step with lumped masses, where slowed waves and springs are at their worst
LOOKED_AT = 1.5, 1.65, 2.0, 2.25, 2.5
CLOSE = 0.02  # of 4, in which that is found by so few looks


def critical_time_step(
    model: Model, largest_force: float, mounting: Mounting = HELD, hub_mass: float = inf, further: float = 0.0,
    mass: ReciprocalMass = LUMPED, sticks: bool = True,
) -> float:  # fmt: skip
    """Longest stable step, s, of all bodies with every contact closed at LOAD_MARGIN times `largest_force`, N.

    0 where `mass` does not make every body's as long as is worth it.

    Of a body with waves A = M⁻¹K and springs S on its surface, steps of dt have ω² of q(dt² A)(A + S), which must stay
    below 4/dt², and dt² A below its reach (`reciprocal_mass`). A spring k between two bodies is counted as 2k on
    each: k (a + b)² <= 2k a² + 2k b², so no coupled mode is faster than the fastest body. Where one of them is
    rigid, and moves with its whole mass, as LIGHT k on the other and HEAVY k on itself, which is as true. Where a
    contact `sticks` its tangential spring counts likewise; creep and dashpots are implicit and do not. A housing's
    own springs k on its mass m add at most k/m to any ω², and so do a shaft's on the mass, kg, that moves with the
    hub; of both the larger counts. `further`, 1/s², is added too.

    Errors: Lanczos approaches the largest ω² from below; its tolerance is added.
    """
    bodies = [(body.shape, body.material) for body in (model.roller, model.inner_ring, model.outer_ring)]
    perfect = replace(model.bearing, faults=())  # what surfaces lack makes no contact stiffer
    housing, shaft, ring = mounting.housing, mounting.shaft, model.outer_ring
    of_shaft = 0.0 if shaft is None else shaft.stiffness / hub_mass
    of_mount = further + max(0.0 if housing is None else housing.stiffness / housing.mass, of_shaft)
    # one held at points counts as free
    outside = ring.stiffness if isinstance(ring, BoredRing) else isinstance(ring, LooseRing)
    carried = housing, shaft, None if shaft is None else hub_mass, further, outside
    key = repr((type(model).__name__, perfect, bodies, model.laws, largest_force, mass, sticks, *carried))
    force = LOAD_MARGIN * max(largest_force, 1.0)
    found = kept("step", key, lambda: {"critical": np.array(_found(model, force, housing, of_mount, mass, sticks))})
    return float(found["critical"])


def next_rung(force: float) -> float:
    """The least of some forces that is not below this one, N: scenes under other loads mostly share their step."""
    return 2.0 ** (ceil(RUNGS * log2(max(force, 1.0))) / RUNGS)


def _found(model, force, housing, of_mount, mass, sticks):
    springs, ring = model.springs(force, sticks), model.outer_ring
    if isinstance(ring, BoredRing):
        springs["outer_ring"] = sparse.hstack([springs["outer_ring"], ring.springs(FINELY)])
        of_mount += 0.0 if housing is None else HEAVY * 0.5 * ring.n_sectors * ring.stiffness / housing.mass
    elastic = [name for name in springs if not getattr(model, name).material.rigid]
    steps: list[float] = []
    for name in elastic:
        step = _longest_step(*_waves(getattr(model, name), springs[name]), of_mount, mass, min(steps, default=inf))
        if step == 0.0:
            return 0.0  # without looking at the others, which takes its time on fine meshes
        steps.append(step)
    if isinstance(ring, BoredRing):
        steps.append(2.0 / sqrt(FINELY * ring.stiffness / ring.row_mass[ring.held_row]))
    if len(elastic) < len(springs):
        # largest ω², 1/s², or more, of the bodies that move as a whole; the inner ring's without the shaft's mass
        inner, outer, between = model.stiffnesses(force, sticks)
        roller, limits = model.roller, []
        if roller.material.rigid:  # a disc along its surface turns, too
            lightness = (1.0 + 2.0 * sticks) / roller.total_mass
            limits.append((HEAVY * (inner + outer) + 2.0 * EVENLY * between) * lightness)
        if model.inner_ring.material.rigid:
            limits.append(model.bearing.n_rollers * HEAVY * inner / model.inner_ring.total_mass)
        if ring.material.rigid and housing is not None:
            limits.append(model.bearing.n_rollers * HEAVY * outer / (housing.mass + ring.total_mass))
        steps.extend(2.0 / sqrt(limit + of_mount) for limit in limits)
    return min(steps)


def _waves(body, springs):
    """A, of a body, and what S is the square of, both scaled by 1/√mass on either side.

    Of a held ring; held at points, of a free one, which is not less.
    """
    if isinstance(body, DiscBody):
        stiffness, mass, held = body.stiffness, np.repeat(body.mass, 2), springs
    else:
        free = (2 * body.n_sectors * body.free_rows[:, None] + np.arange(2 * body.n_sectors)).ravel()
        mass = np.repeat(body.row_mass[body.free_rows], 2 * body.n_sectors)
        stiffness, held = body.matrix[free][:, free], springs.tocsr()[free]
    scale = sparse.diags(1.0 / np.sqrt(mass))
    return (scale @ stiffness @ scale).tocsr(), (scale @ held).tocsr()


def _longest_step(waves, springs, further, mass, at_most=inf):
    """Largest stable step, s, of waves A and springs S = `springs`·`springs`ᵀ, with `further` added to any ω².

    No longer than `at_most`. 0 if `mass` does not make it as long as is worth it, nor that long. All shorter steps must
    be stable, too, and what exceeds 4 first rises with the step and then may fall.
    """
    from scipy.optimize import brentq  # a step that is kept need not load it
    from scipy.sparse.linalg import LinearOperator, eigs, eigsh

    # seeded, so that the same scene gets the same step
    how = {"k": 1, "v0": np.random.default_rng(0).standard_normal(waves.shape[0]), "return_eigenvectors": False}

    def operator(apply):
        return LinearOperator(waves.shape, matvec=lambda u: apply(u.ravel()), dtype=float)

    def largest(apply):
        return float(eigsh(operator(apply), which="LA", tol=LANCZOS_TOLERANCE, **how)[0]) * (1.0 + LANCZOS_TOLERANCE)

    def excess(dt):
        """By how much dt² ω² of q(dt² A)(A + S) is above 4, nearly."""
        slowing = mass.at(dt)

        def slowed(u):
            found = waves @ u + springs @ (springs.T @ u)
            return found - slowing.waves * (waves @ (found - slowing.velocities * (waves @ found)))

        found = eigs(operator(slowed), which="LM", tol=0.1 * STEP_TOLERANCE, **how)[0].real
        return dt**2 * (found * (1.0 + 0.1 * STEP_TOLERANCE) + further) - (4.0 - CLOSE)

    # of the lumped mass: slowing makes no wave faster
    sure = 2.0 / sqrt(largest(lambda u: waves @ u + springs @ (springs.T @ u)) + further)
    if mass.share == 0.0:
        return sure
    longest = min(at_most, sqrt(mass.reach / largest(lambda u: waves @ u)))
    least, stable = min(mass.worth * sure, at_most), 0.0
    if longest < least:
        return 0.0
    for dt in sorted({min(times * sure, longest) for times in LOOKED_AT} | {longest}):
        if excess(dt) > 0.0:
            if dt <= least:
                return 0.0
            found = (1.0 - STEP_TOLERANCE) * brentq(excess, stable, dt, rtol=STEP_TOLERANCE)
            return found if found >= least else 0.0
        stable = dt
    return stable
