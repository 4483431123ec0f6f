"""Static equilibrium: the rollers at given angles, the hub and the rollers' radii free, the bodies elastic.

Each body is condensed to the compliance between its contacts; what is left is 3 N + 2 equations for Newton.
"""

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

import numpy as np

from fem.bodies import RingBody
from fem.model import Model
from fem.subgrid import disc_patch_force, ring_patch_force, ripple_at

LOOSE_SPRING = 1.0  # N/m, keeps in place what no force holds (a roller in clearance); 1e-6 N per µm
PATCH_PASSES = 3  # patches sit along the lines of centres, which the solution moves by microradians
MAX_NEWTON = 60
TETHER_DECADES = 9
# contacts open and close: solved with approaches rounded off over ever shorter lengths, in roller radii
SHARP = 1e-13  # leaves 1e-8 N at an open contact
FAINTEST = 1e-6  # N; a smaller force is what the rounding left
FINE_ROUNDING = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
ROUNDING = (1e-3, 1e-4, 1e-5, *FINE_ROUNDING)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Angles and angular speeds of an instant. rad, rad/s; arrays (n_rollers,)."""

    roller_angle: np.ndarray  # of the rollers' centres, from +x
    roller_turn: np.ndarray  # each roller's own frame
    ring_turn: float  # the inner ring's frame
    cage_speed: float
    roller_speed: float
    ring_speed: float


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
    RuntimeError: Newton's method did not converge. The contact balance is exact to about 1e-9 of the load.
    """
    bearing, n = model.bearing, model.bearing.n_rollers
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    cold = start is None
    if cold:
        unknown = _guess(model, radial, radial_load + weight)
    else:
        unknown = np.concatenate([start.hub, start.rho, start.inner_force, start.outer_force])
    for _ in range(PATCH_PASSES):
        patches = _patches(model, motion, gravity, radial, unknown[:2], unknown[2 : 2 + n])
        loads = _Loads(radial_load + weight, gravity, SHARP * bearing.roller_radius, 0.0, unknown)
        unknown = _solve(model, motion, radial, patches, loads, cold)
        cold = False
    forces = np.where(unknown[2 + n :] > FAINTEST, unknown[2 + n :], 0.0)
    inner_force, outer_force = forces[:n], forces[n:]
    inner_ring = patches.inner_growth - np.einsum("rckn,n->rck", patches.inner_response, inner_force)
    outer_ring = patches.outer_sag + np.einsum("rckn,n->rck", patches.outer_response, outer_force)
    rollers = patches.roller_growth[None, :] - (
        inner_force[:, None] * patches.roller_response[0].T + outer_force[:, None] * patches.roller_response[1].T
    )
    return Equilibrium(
        hub=unknown[:2].copy(),
        rho=unknown[2 : 2 + n].copy(),
        inner_force=inner_force.copy(),
        outer_force=outer_force.copy(),
        inner_ring=inner_ring,
        outer_ring=outer_ring,
        rollers=rollers.reshape(bearing.n_rollers, -1, 2),
    )


class NotFound(RuntimeError):
    """No static equilibrium was found."""


class _Loads(NamedTuple):
    hub: float  # N, downwards
    gravity: float
    rounding: float  # m, of the corner where a contact opens
    tether: float  # N/m, springs that hold hub and rollers near `anchor`
    anchor: np.ndarray


@dataclass(frozen=True, kw_only=True)
class _Patches:
    """Elastic responses to a unit force at every contact, and the compliances between contacts."""

    inner_response: np.ndarray  # (n_rows, 2, n_sectors, n_rollers)
    outer_response: np.ndarray
    roller_response: tuple[np.ndarray, np.ndarray]  # inner, outer contact; each (2 n_nodes, n_rollers)
    inner_growth: np.ndarray  # centrifugal load and own weight
    outer_sag: np.ndarray  # own weight
    roller_growth: np.ndarray  # (2 n_nodes,)
    compliance: np.ndarray  # (2 n_rollers, 2 n_rollers): inner contacts, then outer, m/N
    growth: np.ndarray  # (2 n_rollers,), closing of each contact by centrifugal load and weight, m


def _patches(model: Model, motion: Motion, gravity: float, radial, hub, rho) -> _Patches:
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

    weight = _weight(inner, gravity, motion.ring_turn)
    weight[:, 0] += (motion.ring_speed**2 * inner.row_mass * inner.radii)[:, None]
    inner_growth = inner.held(weight)
    outer_sag = outer.held(_weight(outer, gravity, 0.0))
    # a roller's weight is a uniform load and so deforms it only through its contacts
    roller_growth = disc.relaxed(motion.roller_speed**2 * (disc.mass[:, None] * disc.points).ravel())
    growth = np.concatenate(
        [
            np.einsum("rcki,rck->i", inner_load, inner_growth) + near.T @ roller_growth,
            far.T @ roller_growth - np.einsum("rcki,rck->i", outer_load, outer_sag),
        ]
    )
    return _Patches(
        inner_response=inner_response,
        outer_response=outer_response,
        roller_response=responses,
        inner_growth=inner_growth,
        outer_sag=outer_sag,
        roller_growth=roller_growth,
        compliance=compliance,
        growth=growth,
    )


def _weight(ring: RingBody, gravity: float, turn: float) -> np.ndarray:
    """Nodal weights of a ring, (n_rows, 2, n_sectors), polar, N; `turn` of its frame, rad."""
    angle = ring.angles + turn
    down = -gravity * np.stack([np.sin(angle), np.cos(angle)])
    return ring.row_mass[:, None, None] * down


def _ripples(surface, angles, nodes) -> np.ndarray:
    positions = np.mod(angles * nodes / (2.0 * pi), nodes)
    return np.array([ripple_at(position, surface.ripple)[0] for position in positions])


def _guess(model: Model, radial, load) -> np.ndarray:
    """Hub pushed down until rigid rollers would touch, everything at rest midway between the raceways."""
    bearing, n = model.bearing, model.bearing.n_rollers
    down = max(bearing.radial_clearance, 0.0) + (1e-7 * bearing.roller_radius if load > 0.0 else 0.0)
    hub = np.array([0.0, -down if load > 0.0 else 0.0])
    rho = bearing.pitch_radius + 0.5 * (radial @ hub)
    return np.concatenate([hub, rho, np.zeros(2 * n)])


def _solve(model, motion, radial, patches, loads: _Loads, cold: bool) -> np.ndarray:
    """The equilibrium, from the state `loads.anchor`: the quick ways first."""
    system = model, motion, radial, patches
    if not cold:
        try:
            return _newton(*system, loads.anchor, loads)
        except NotFound:
            pass  # a contact opens or closes between the anchor and here
    try:
        return _rounded_off(*system, loads.anchor, loads, ROUNDING if cold else FINE_ROUNDING)
    except NotFound:
        return _rounded_off(*system, _settled(*system, loads), loads, FINE_ROUNDING)


def _rounded_off(model, motion, radial, patches, unknown, loads: _Loads, roundings) -> np.ndarray:
    """The equilibrium by way of ever less rounded contacts."""
    for rounding in roundings:
        eased = loads._replace(rounding=rounding * model.bearing.roller_radius)
        unknown = _newton(model, motion, radial, patches, unknown, eased)
    return _newton(model, motion, radial, patches, unknown, loads)


def _settled(model, motion, radial, patches, loads: _Loads) -> np.ndarray:
    """A state near the equilibrium: pulled along by ever softer springs, as a slow motion would settle.

    A hub that rests on one roller in clearance is unstable and must roll over to the next, many contact widths away.
    """
    unknown = loads.anchor
    stiffest = max(loads.hub, 1.0) / (1e-6 * model.bearing.roller_radius)
    for tether in stiffest * 10.0 ** np.arange(0.0, -TETHER_DECADES, -0.5):
        for _ in range(3):
            eased = loads._replace(tether=tether, rounding=1e-6 * model.bearing.roller_radius, anchor=unknown)
            unknown = _newton(model, motion, radial, patches, unknown, eased)
    return unknown


def _newton(model, motion, radial, patches, unknown, loads: _Loads) -> np.ndarray:
    """Newton's method with step halving on the norm of the residual, N."""
    exact = loads.rounding <= SHARP * model.bearing.roller_radius  # a stepping stone need not be
    enough = 1e-10 * loads.hub + 1e-9 if exact else 1e-4 * max(loads.hub, 1.0)
    # a roller that only a loose spring holds may flicker between touching and not
    tolerable = 100.0 * enough + 2.0 * LOOSE_SPRING * abs(model.bearing.radial_clearance)
    residual, jacobian = _system(model, motion, radial, patches, unknown, loads)
    for _ in range(MAX_NEWTON):
        norm = np.linalg.norm(residual)
        if norm <= enough:
            return unknown
        step = np.linalg.solve(jacobian, -residual)
        length = 1.0
        while True:
            trial = unknown + length * step
            found, slopes = _system(model, motion, radial, patches, trial, loads)
            if np.linalg.norm(found) < norm or length < 1e-6:
                break
            length *= 0.5
        if length < 1e-6 and (not exact or norm <= tolerable):
            return unknown
        unknown, residual, jacobian = trial, found, slopes
    if exact and norm > tolerable:
        raise NotFound(
            f"static equilibrium not found: residual {norm:.2e} N after {MAX_NEWTON} steps under {loads.hub:.4g} N"
        )
    return unknown


def _system(model: Model, motion: Motion, radial, patches: _Patches, unknown, loads: _Loads):
    """Residual, N, and its Jacobian for hub, radii, inner and outer forces."""
    bearing, n = model.bearing, model.bearing.n_rollers
    hub, rho = unknown[:2], unknown[2 : 2 + n]
    force = unknown[2 + n :]
    inner_force, outer_force = force[:n], force[n:]
    to_roller = radial * rho[:, None] - hub
    distance = np.hypot(to_roller[:, 0], to_roller[:, 1])
    normal = to_roller / distance[:, None]
    along = np.sum(normal * radial, axis=1)
    geometric = np.concatenate(
        [
            bearing.inner_raceway_radius + bearing.roller_radius - distance,
            rho + bearing.roller_radius - bearing.outer_raceway_radius,
        ]
    )
    closing = geometric + patches.growth - patches.compliance @ force
    wanted, stiffness = np.zeros(2 * n), np.zeros(2 * n)
    for k in range(2 * n):
        law = model.inner_law if k < n else model.outer_law
        length = np.hypot(closing[k], loads.rounding)
        rounded = 0.5 * (closing[k] + length)
        if rounded > 0.0:
            wanted[k] = law.force(rounded)
            stiffness[k] = law.stiffness(wanted[k]) * 0.5 * (1.0 + closing[k] / length)

    mass = model.roller.total_mass
    i_rho, i_in, i_out = 2 + np.arange(n), 2 + n + np.arange(n), 2 + 2 * n + np.arange(n)
    residual = np.zeros(2 + 3 * n)
    residual[:2] = -inner_force @ normal - np.array([0.0, loads.hub]) - LOOSE_SPRING * hub
    residual[i_rho] = (
        inner_force * along
        - outer_force
        + mass * (motion.cage_speed**2 * rho - loads.gravity * radial[:, 1])
        - LOOSE_SPRING * (rho - bearing.pitch_radius)
    )
    residual[: 2 + n] -= loads.tether * (unknown - loads.anchor)[: 2 + n]
    residual[2 + n :] = force - wanted

    jacobian = np.zeros((2 + 3 * n, 2 + 3 * n))
    jacobian[0, 0] = jacobian[1, 1] = -LOOSE_SPRING
    jacobian[0, i_in], jacobian[1, i_in] = -normal[:, 0], -normal[:, 1]
    for j in range(n):  # the normals turn with the hub and the radii: force times (1 − n nᵀ)/χ
        turn = (np.eye(2) - np.outer(normal[j], normal[j])) * (inner_force[j] / distance[j])
        jacobian[:2, :2] += turn
        jacobian[:2, 2 + j] -= turn @ radial[j]
        jacobian[2 + j, :2] -= turn @ radial[j]
        jacobian[2 + j, 2 + j] += radial[j] @ turn @ radial[j]
    # the centrifugal force's own growth is left out: a roller in clearance would be sent the wrong way
    jacobian[i_rho, i_rho] -= LOOSE_SPRING
    jacobian[i_rho, i_in], jacobian[i_rho, i_out] = along, -1.0
    i_held = np.arange(2 + n)
    jacobian[i_held, i_held] -= loads.tether
    jacobian[2 + n :, 2 + n :] = np.eye(2 * n) + stiffness[:, None] * patches.compliance
    jacobian[i_in, 0], jacobian[i_in, 1] = -stiffness[:n] * normal[:, 0], -stiffness[:n] * normal[:, 1]
    jacobian[i_in, i_rho] = stiffness[:n] * along
    jacobian[i_out, i_rho] = -stiffness[n:]
    return residual, jacobian
