"""Static equilibrium: the rollers at given angles, the hub and the rollers' radii free, the bodies elastic.

Each body is condensed to the compliance between its contacts; `contact_balance` does the rest.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.elastic.model import Model
from fem.elastic.subgrid import disc_patch_force, ring_patch_force
from fem.kernels.law import ripple_at
from fem.statics.contact_balance import Condensed, Loads, balance, closed_forces, first_guess
from lagrange import Bearing
from lagrange.kinematics import roller_angles

PATCH_PASSES = 3  # patches sit along the lines of centres, which the solution moves by microradians


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Angles and angular speeds of an instant. rad, rad/s; arrays (n_rollers,)."""

    roller_angle: np.ndarray  # of the rollers' centres, from +x
    roller_turn: np.ndarray  # each roller's own frame
    ring_turn: float  # the inner ring's frame
    cage_speed: float
    roller_speed: float
    ring_speed: float


def standing(bearing: Bearing, first_roller_angle: float) -> Motion:
    """Nothing turns; the first roller's angle from +x, rad."""
    return Motion(
        roller_angle=roller_angles(bearing, first_roller_angle),
        roller_turn=np.zeros(bearing.n_rollers),
        ring_turn=0.0,
        cage_speed=0.0,
        roller_speed=0.0,
        ring_speed=0.0,
    )


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """Positions, contact forces and elastic displacements; m and N."""

    hub: np.ndarray  # (2,)
    rho: np.ndarray  # (n_rollers,)
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub, in the ring's frame
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), in each roller's frame, about its centre of mass


def static_equilibrium(
    model: Model, motion: Motion, radial_load: float, weight: float, gravity: float, start: Equilibrium | None = None
) -> Equilibrium:
    """Solve for the equilibrium under a load, N, and the weight, N, of hub and inner ring.

    Steady rotation acts as centrifugal load on rollers and ring. Friction and the rollers' balance along the raceway
    are left out: their angles are given.

    Errors
    ------
    NotFound: no equilibrium. The contact balance is exact to about 1e-9 of the load.
    """
    bearing, n = model.bearing, model.bearing.n_rollers
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    if start is None:
        position = first_guess(bearing, radial, radial_load + weight)
    else:
        position = np.concatenate([start.hub, start.rho])
    loads = Loads(radial_load + weight, gravity, motion.cage_speed)
    for _ in range(PATCH_PASSES):
        patches = patch_responses(model, motion, gravity, radial, position[:2], position[2:])
        contacts = Condensed(
            bearing=bearing,
            radial=radial,
            inner_law=model.inner_law,
            outer_law=model.outer_law,
            compliance=patches.compliance,
            growth=patches.growth,
        )
        position, forces = balance(contacts, loads, position)
    forces = closed_forces(forces)
    inner_force, outer_force = forces[:n], forces[n:]
    inner_ring = patches.inner_growth - np.einsum("rckn,n->rck", patches.inner_response, inner_force)
    outer_ring = patches.outer_sag + np.einsum("rckn,n->rck", patches.outer_response, outer_force)
    rollers = patches.roller_growth[None, :] - (
        inner_force[:, None] * patches.roller_response[0].T + outer_force[:, None] * patches.roller_response[1].T
    )
    return Equilibrium(
        hub=position[:2].copy(),
        rho=position[2:].copy(),
        inner_force=inner_force.copy(),
        outer_force=outer_force.copy(),
        inner_ring=inner_ring,
        outer_ring=outer_ring,
        rollers=rollers.reshape(bearing.n_rollers, -1, 2),
    )


@dataclass(frozen=True, kw_only=True)
class PatchResponses:
    """Elastic responses to a unit force at every contact, and the compliances between contacts."""

    inner_response: np.ndarray  # (n_rows, 2, n_sectors, n_rollers)
    outer_response: np.ndarray
    roller_response: tuple[np.ndarray, np.ndarray]  # inner, outer contact; each (2 n_nodes, n_rollers)
    inner_growth: np.ndarray  # centrifugal load and own weight
    outer_sag: np.ndarray  # own weight
    roller_growth: np.ndarray  # (2 n_nodes,)
    compliance: np.ndarray  # (2 n_rollers, 2 n_rollers): inner contacts, then outer, m/N
    growth: np.ndarray  # (2 n_rollers,), closing of each contact by centrifugal load and weight, m


def patch_responses(model: Model, motion: Motion, gravity: float, radial, hub, rho) -> PatchResponses:
    """With rollers in directions `radial`, (n_rollers, 2), at radii `rho`, (n_rollers,), m, and the hub at `hub`, m."""
    n = model.bearing.n_rollers
    inner, outer, disc = model.inner_ring, model.outer_ring, model.roller
    to_roller = radial * rho[:, None] - hub
    inner_angle = np.arctan2(to_roller[:, 1], to_roller[:, 0])
    outer_angle = motion.roller_angle
    inner_load = np.stack([ring_patch_force(inner, a - motion.ring_turn) for a in inner_angle], axis=-1)
    outer_load = np.stack([ring_patch_force(outer, a) for a in outer_angle], axis=-1)
    near = np.stack([disc_patch_force(disc, a) for a in inner_angle + pi - motion.roller_turn], axis=-1)
    far = np.stack([disc_patch_force(disc, a) for a in outer_angle - motion.roller_turn], axis=-1)
    inner_response, outer_response = inner.held(inner_load), outer.held(outer_load)
    responses = disc.relaxed(near), disc.relaxed(far)

    compliance = np.zeros((2 * n, 2 * n))
    compliance[:n, :n] = np.einsum("rcki,rckj->ij", inner_load, inner_response)
    compliance[n:, n:] = np.einsum("rcki,rckj->ij", outer_load, outer_response)
    j = np.arange(n)
    for row, load in enumerate((near, far)):
        for column, response in enumerate(responses):
            compliance[row * n + j, column * n + j] += np.einsum("di,di->i", load, response)
    compliance[j, j] += _ripples(model.inner_surface, inner_angle - motion.ring_turn, inner.n_sectors)
    compliance[j, j] += _ripples(model.roller_surface, inner_angle + pi - motion.roller_turn, disc.shape.surface_nodes)
    compliance[n + j, n + j] += _ripples(model.outer_surface, outer_angle, outer.n_sectors)
    compliance[n + j, n + j] += _ripples(
        model.roller_surface, outer_angle - motion.roller_turn, disc.shape.surface_nodes
    )

    inner_growth = inner.held(inner.body_load(gravity, motion.ring_turn, motion.ring_speed))
    outer_sag = outer.held(outer.body_load(gravity))
    # a roller's weight is a uniform load and so deforms it only through its contacts
    roller_growth = disc.relaxed(motion.roller_speed**2 * (disc.mass[:, None] * disc.points).ravel())
    growth = np.concatenate(
        [
            np.einsum("rcki,rck->i", inner_load, inner_growth) + near.T @ roller_growth,
            far.T @ roller_growth - np.einsum("rcki,rck->i", outer_load, outer_sag),
        ]
    )
    return PatchResponses(
        inner_response=inner_response,
        outer_response=outer_response,
        roller_response=responses,
        inner_growth=inner_growth,
        outer_sag=outer_sag,
        roller_growth=roller_growth,
        compliance=compliance,
        growth=growth,
    )


def _ripples(surface, angles, nodes) -> np.ndarray:
    positions = np.mod(angles * nodes / (2.0 * pi), nodes)
    return np.array([ripple_at(position, surface.ripple)[0] for position in positions])
