"""The balance of hub and rollers on elastic contacts: 3 n + 2 equations for Newton.

Every body is condensed to the compliance between its contacts; where that comes from (finite elements, exact series) is
not known here.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.subgrid import ContactLaw
from lagrange import Bearing

LOOSE_SPRING = 1.0  # N/m, keeps in place what no force holds (a roller in clearance); 1e-6 N per µm
MAX_NEWTON = 60
TETHER_DECADES = 9
# contacts open and close: solved with approaches rounded off over ever shorter lengths, in roller radii
SHARP = 1e-13  # leaves 1e-8 N at an open contact
FAINTEST = 1e-6  # N; a smaller force is what the rounding left
FINE_ROUNDING = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
ROUNDING = (1e-3, 1e-4, 1e-5, *FINE_ROUNDING)


class NotFound(RuntimeError):
    """No static equilibrium was found."""


class Loads(NamedTuple):
    """What the contacts must carry, and how the solver is eased on its way."""

    hub: float  # N, downwards
    gravity: float  # m/s²
    cage_speed: float  # rad/s
    rounding: float  # m, of the corner where a contact opens
    tether: float  # N/m, springs that hold hub and rollers near `anchor`
    anchor: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Condensed:
    """A bearing reduced to its contacts: inner ones first, then outer ones."""

    bearing: Bearing
    radial: np.ndarray  # (n_rollers, 2), unit, from the outer ring's centre to the rollers
    inner_law: ContactLaw  # of the approach that `compliance` leaves out
    outer_law: ContactLaw
    compliance: np.ndarray  # (2 n_rollers, 2 n_rollers), m/N
    growth: np.ndarray  # (2 n_rollers,), closing of each contact by other loads, m


def first_guess(bearing: Bearing, radial, load) -> np.ndarray:
    """Hub pushed down until rigid rollers would touch, everything at rest midway between the raceways."""
    n = bearing.n_rollers
    down = max(bearing.radial_clearance, 0.0) + (1e-7 * bearing.roller_radius if load > 0.0 else 0.0)
    hub = np.array([0.0, -down if load > 0.0 else 0.0])
    rho = bearing.pitch_radius + 0.5 * (radial @ hub)
    return np.concatenate([hub, rho, np.zeros(2 * n)])


def closed_forces(unknown: np.ndarray, n_rollers: int) -> np.ndarray:
    """The forces in a solution, (2 n_rollers,), N; what the rounding leaves at open contacts is 0."""
    forces = unknown[2 + n_rollers :]
    return np.where(forces > FAINTEST, forces, 0.0)


def balance(contacts: Condensed, loads: Loads, cold: bool) -> np.ndarray:
    """Hub, radii, inner and outer forces in equilibrium, (3 n_rollers + 2,): the quick ways first.

    Starts from `loads.anchor`; `cold` says that it is only a guess.

    Errors
    ------
    NotFound. The balance is exact to about 1e-9 of the load.
    """
    if not cold:
        try:
            return _newton(contacts, loads.anchor, loads)
        except NotFound:
            pass  # a contact opens or closes between the anchor and here
    try:
        return _rounded_off(contacts, loads.anchor, loads, ROUNDING if cold else FINE_ROUNDING)
    except NotFound:
        return _rounded_off(contacts, _settled(contacts, loads), loads, FINE_ROUNDING)


def _rounded_off(contacts, unknown, loads: Loads, roundings) -> np.ndarray:
    """The equilibrium by way of ever less rounded contacts."""
    for rounding in roundings:
        eased = loads._replace(rounding=rounding * contacts.bearing.roller_radius)
        unknown = _newton(contacts, unknown, eased)
    return _newton(contacts, unknown, loads)


def _settled(contacts, loads: Loads) -> np.ndarray:
    """A state near the equilibrium: pulled along by ever softer springs, as a slow motion would settle.

    A hub that rests on one roller in clearance is unstable and must roll over to the next, many contact widths away.
    """
    unknown = loads.anchor
    stiffest = max(loads.hub, 1.0) / (1e-6 * contacts.bearing.roller_radius)
    for tether in stiffest * 10.0 ** np.arange(0.0, -TETHER_DECADES, -0.5):
        for _ in range(3):
            eased = loads._replace(tether=tether, rounding=1e-6 * contacts.bearing.roller_radius, anchor=unknown)
            unknown = _newton(contacts, unknown, eased)
    return unknown


def _newton(contacts, unknown, loads: Loads) -> np.ndarray:
    """Newton's method with step halving on the norm of the residual, N."""
    exact = loads.rounding <= SHARP * contacts.bearing.roller_radius  # a stepping stone need not be
    enough = 1e-10 * loads.hub + 1e-9 if exact else 1e-4 * max(loads.hub, 1.0)
    # a roller that only a loose spring holds may flicker between touching and not
    tolerable = 100.0 * enough + 2.0 * LOOSE_SPRING * abs(contacts.bearing.radial_clearance)
    residual, jacobian = _system(contacts, unknown, loads)
    for _ in range(MAX_NEWTON):
        norm = np.linalg.norm(residual)
        if norm <= enough:
            return unknown
        step = np.linalg.solve(jacobian, -residual)
        length = 1.0
        while True:
            trial = unknown + length * step
            found, slopes = _system(contacts, trial, loads)
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


def _system(contacts: Condensed, unknown, loads: Loads):
    """Residual, N, and its Jacobian for hub, radii, inner and outer forces."""
    bearing, n, radial = contacts.bearing, contacts.bearing.n_rollers, contacts.radial
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
    closing = geometric + contacts.growth - contacts.compliance @ force
    wanted, stiffness = np.zeros(2 * n), np.zeros(2 * n)
    for k in range(2 * n):
        law = contacts.inner_law if k < n else contacts.outer_law
        length = np.hypot(closing[k], loads.rounding)
        rounded = 0.5 * (closing[k] + length)
        if rounded > 0.0:
            wanted[k] = law.force(rounded)
            stiffness[k] = law.stiffness(wanted[k]) * 0.5 * (1.0 + closing[k] / length)

    mass = bearing.roller_mass
    i_rho, i_in, i_out = 2 + np.arange(n), 2 + n + np.arange(n), 2 + 2 * n + np.arange(n)
    residual = np.zeros(2 + 3 * n)
    residual[:2] = -inner_force @ normal - np.array([0.0, loads.hub]) - LOOSE_SPRING * hub
    residual[i_rho] = (
        inner_force * along
        - outer_force
        + mass * (loads.cage_speed**2 * rho - loads.gravity * radial[:, 1])
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
    jacobian[2 + n :, 2 + n :] = np.eye(2 * n) + stiffness[:, None] * contacts.compliance
    jacobian[i_in, 0], jacobian[i_in, 1] = -stiffness[:n] * normal[:, 0], -stiffness[:n] * normal[:, 1]
    jacobian[i_in, i_rho] = stiffness[:n] * along
    jacobian[i_out, i_rho] = -stiffness[n:]
    return residual, jacobian
