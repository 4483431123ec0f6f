"""Static equilibrium: the rollers at given angles, the hub and the rollers' radii free, the bodies elastic.

The contact model reduces the bodies to points of the contacts. One point each is balanced by `contact_balance`; of many
points, which push or stand open, never both, Newton's method finds the active set."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from fem.contacts.model import Model, Motion, PressurePoints, Reduced, standing, unloaded
from fem.contacts.tilted import MeshedContact
from fem.elastic.outer_support import MOST_SETTLINGS, NOT_SETTLED, BoredRing
from fem.quantities import Quantity
from fem.statics.contact_balance import (
    LOOSE_SPRING,
    Condensed,
    Loads,
    NotFound,
    balance,
    bare_of,
    closed_forces,
    first_guess,
    geometry,
    hub_spring,
    springs_of,
)
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange import Bearing, Operation
from lagrange.equations import overlaps
from lagrange.motion import HubTilt, TiltedLaws
from lagrange.statics import Elastic, Placement, TiltedStatics, tilted_equilibrium

MAX_NEWTON = 40
MAX_CLOSING = 100
ENOUGH = 1e-9  # of the load


def balance_pressures(
    bearing: Bearing, radial: np.ndarray, points: PressurePoints, loads: Loads, start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Hub and radii in equilibrium, (n_rollers + 2,), and the forces of all points, N.

    Parameters
    ----------
    radial : (n_rollers, 2), unit, from the outer ring's centre to the rollers; start : (n_rollers + 2,), m

    Errors
    ------
    NotFound: no equilibrium. The balance is exact to ENOUGH of the load.
    """
    n = bearing.n_rollers
    active = np.zeros(points.contact.size, dtype=bool)
    outward = bearing.roller_mass * (loads.cage_speed**2 * start[2:] - loads.gravity * radial[:, 1])
    applied = np.concatenate([[loads.side_load, -loads.hub], outward])
    springs, middle = springs_of(bearing, loads.spring)

    def system(place, active):
        overlap, directions = geometry(bearing, radial, place)
        force, slopes, active = _pressed(points, overlap, active)
        total = np.bincount(points.contact, force, minlength=2 * n)
        residual = applied - directions.T @ total - springs * (place - middle)
        jacobian = -directions.T @ slopes @ directions - np.diag(springs)
        return residual, jacobian + _turning(bearing, radial, place, total[:n]), force, active, overlap

    place = start
    residual, jacobian, force, active, overlap = system(place, active)
    size = float(np.hypot(loads.side_load, loads.hub))
    enough = ENOUGH * max(size, 1.0)
    for _ in range(MAX_NEWTON):
        norm = np.linalg.norm(residual)
        if norm <= enough:
            return place, force
        step, length = np.linalg.solve(jacobian, -residual), 1.0
        step[2:] = _in_reach(points, overlap, active, step[2:], residual[2:])
        while True:
            trial = place + length * step
            found = system(trial, active)
            if np.linalg.norm(found[0]) < norm or length < 1e-6:
                break
            length *= 0.5
        if length < 1e-6:
            break
        place, (residual, jacobian, force, active, overlap) = trial, found
    if norm > 100.0 * enough + 2.0 * LOOSE_SPRING * abs(bearing.radial_clearance):
        why = f"static equilibrium not found: residual {norm:.2e} N under {size:.4g} N, contacts resolved"
        raise NotFound(bare_of(bearing, radial, loads) or why)
    return place, force


def _in_reach(points: PressurePoints, overlap, active, step, force) -> np.ndarray:
    """Steps of the rollers, (n_rollers,), m; those of loose ones end where a contact bears their force.

    A roller that no point holds, because the mesh leaves open by a nanometre a contact that exact statics closes, has
    nothing but LOOSE_SPRING: by Newton's step its weight would send it through the rings, and the search along the step
    would hold all other bodies back with it.

    Parameters
    ----------
    overlap : (2 n_rollers,), m, of the contacts; force : (n_rollers,), N, outward, that is not balanced
    """
    n, found = step.size, step.copy()
    held = np.bincount(points.contact[active], minlength=2 * n).reshape(2, n).any(axis=0)
    for j in np.flatnonzero(~held):
        mine = np.flatnonzero(points.contact == (n + j if force[j] > 0.0 else j))
        left = overlap[points.contact[mine]] + points.closing[mine]
        first = mine[np.argmax(left)]
        most = points.compliance[first, first] * abs(force[j]) - float(left.max())
        found[j] = np.clip(step[j], -most, most)
    return found


def _turning(bearing: Bearing, radial, place, inner_force) -> np.ndarray:
    """Change of the balance as the inner contacts' normals turn, (n_rollers + 2, n_rollers + 2), N/m."""
    at = overlaps(bearing, place[0], place[1], place[2:], np.arctan2(radial[:, 1], radial[:, 0]))
    ways = np.zeros((len(radial), 2 + len(radial)))  # along the contacts' tangents
    ways[:, 0], ways[:, 1] = -at.direction_y, at.direction_x
    ways[range(len(radial)), range(2, 2 + len(radial))] = at.direction_y * at.cos - at.direction_x * at.sin
    return ways.T @ (inner_force / at.distance * ways.T).T


def _pressed(points: PressurePoints, overlap: np.ndarray, active: np.ndarray):
    """Forces of all points, N, their derivative to the contacts' overlaps summed by contact, and the active points."""
    count, overlap = overlap.size, overlap[points.contact] + points.closing
    for _ in range(MAX_CLOSING):
        i = np.flatnonzero(active)
        force = np.zeros(overlap.size)
        factor = lu_factor(points.compliance[np.ix_(i, i)]) if i.size else None
        if i.size:
            force[i] = lu_solve(factor, overlap[i])
        left = overlap - points.compliance @ force
        found = np.where(active, force > 0.0, left > 0.0)
        if np.array_equal(found, active):
            break
        active = found
    else:
        raise NotFound(f"static equilibrium not found: contacts still open and close after {MAX_CLOSING} steps")
    slopes = np.zeros((count, count))
    if i.size:
        spread = np.zeros((i.size, count))
        spread[np.arange(i.size), points.contact[i]] = 1.0
        slopes = spread.T @ lu_solve(factor, spread)
    return force, slopes, active


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
    axes: TiltedStatics | None = None  # of rollers that tilt; None: axes stay parallel


@dataclass(frozen=True, kw_only=True)
class TiltedBalance:
    """What balances a bearing of rollers that tilt in place of `contact_balance.balance`. Meshes bear no moments."""

    operation: Operation  # at an instant
    laws: tuple[MeshedContact, MeshedContact]  # inner and outer
    hub: HubTilt
    ring: np.ndarray  # (2,), m, of the outer ring's centre

    def found(self, contacts: Condensed, place: np.ndarray) -> TiltedStatics:
        """The equilibrium near hub and radii at a place, (n_rollers + 2,), m. NotFound: there is none."""
        theta = np.arctan2(contacts.radial[:, 1], contacts.radial[:, 0])
        known = np.repeat([law.meshed for law in self.laws], theta.size)
        between = contacts.compliance - np.diag(known)
        elastic, start = Elastic(between, np.zeros_like(between), contacts.closing), (place[:2], place[2:])
        laws, placement = TiltedLaws(*self.laws), Placement(theta, self.ring, contacts.turns)
        try:
            return tilted_equilibrium(contacts.bearing, self.operation, laws, self.hub, placement, start, elastic)
        except RuntimeError as error:
            raise NotFound(str(error)) from None


def equilibrium(
    model: Model, motion: Motion, loads: Loads, start: Equilibrium | None = None, tilted: TiltedBalance | None = None
) -> Equilibrium:
    """Solve for the equilibrium under loads, of rollers that go round as fast as they do in the motion.

    Parameters
    ----------
    start : one that is near
    tilted : contacts and operation of rollers that tilt; None: axes stay parallel

    Steady rotation acts as centrifugal load on rollers and ring. Friction and the rollers' balance along the raceway
    are left out: their angles are given.

    Errors
    ------
    NotFound: no equilibrium. The contact balance is exact to about 1e-9 of the load.
    """
    loads = loads._replace(cage_speed=motion.cage_speed)
    reduced, place, pressed, axes = _solved(model, motion, loads, start, tilted)
    inner_force, outer_force = _sums(reduced, pressed, model.bearing.n_rollers).reshape(2, -1)
    inner_ring, outer_ring, rollers = reduced.fields(pressed)
    return Equilibrium(
        hub=place[:2].copy(), rho=place[2:].copy(), inner_force=inner_force.copy(), outer_force=outer_force.copy(),
        inner_ring=inner_ring, outer_ring=outer_ring, rollers=rollers, axes=axes,
    )  # fmt: skip


def _solved(
    model: Model, motion: Motion, loads: Loads, start: Equilibrium | None, tilted: TiltedBalance | None = None
) -> tuple[Reduced, np.ndarray, np.ndarray, TiltedStatics | None]:
    """The bearing reduced to points, hub and radii, the forces of the points, and what tilts, in equilibrium."""
    bearing, radial, forces, gravity, axes = model.bearing, motion.radial, None, loads.gravity, None
    if start is not None:
        if isinstance(model.outer_ring, BoredRing):
            model = _settled(model, start.outer_ring)
        place = np.concatenate([start.hub, start.rho])
        forces = np.concatenate([start.inner_force, start.outer_force])
    else:
        place = first_guess(bearing, radial, loads.hub, loads.side_load)
        if not model.has_law:
            place, forces = balance(exact_contacts(bearing, motion.roller_angle), loads, place)
    free = unloaded(model, motion, gravity)
    passes = model.static_passes if start is None else max(1, model.static_passes - 1)  # from near one less will do
    for turn in range(MOST_SETTLINGS):
        reduced = model.reduced(motion, free, place, forces)
        if reduced.contact.size == 2 * bearing.n_rollers:
            # one point each: laws of the contact as a whole, and facets which leave load to three rollers
            contacts = Condensed(
                bearing=bearing, radial=radial, inner_law=model.inner_law, outer_law=model.outer_law,
                compliance=reduced.compliance, closing=reduced.closing, turns=motion.turns,
            )  # fmt: skip
            if tilted is None:
                place, pressed = balance(contacts, loads, place, forces)
            else:
                axes = tilted.found(contacts, place)
                place = np.concatenate([axes.place[:2], axes.rho])
                pressed = np.concatenate([axes.inner_force, axes.outer_force])
            pressed = closed_forces(pressed)
        else:
            place, pressed = balance_pressures(bearing, radial, reduced, loads, place)
        forces = _sums(reduced, pressed, bearing.n_rollers)
        found = _settled(model, reduced.fields(pressed)[1]) if isinstance(model.outer_ring, BoredRing) else model
        if found is not model:
            model, free = found, unloaded(found, motion, gravity)
        elif turn + 1 >= passes:
            return reduced, place, pressed, axes
    raise NotFound(NOT_SETTLED)


def _settled(model: Model, outer_ring: np.ndarray) -> Model:
    """The model with an outer ring that touches its bore where its displacement, (n_rows, 2, n_sectors), m, says so."""
    ring = model.outer_ring.settled(outer_ring)
    return model if ring is model.outer_ring else replace(model, outer_ring=ring)


def _sums(reduced: Reduced, pressed: np.ndarray, n_rollers: int) -> np.ndarray:
    return np.bincount(reduced.contact, pressed, minlength=2 * n_rollers)


def static_quantities(model: Model, operation: Operation, tilted: TiltedBalance | None = None) -> list[Quantity]:
    """Quantities of the bearing at rest under load and weight, rollers where the scene puts them.

    `tilted` : where rollers tilt

    Errors
    ------
    NotFound: no equilibrium.
    """
    if tilted is None:
        loads = Loads.of(operation)._replace(spring=hub_spring(operation, np.zeros(2)))
    else:
        loads = Loads.of(tilted.operation)
    found = equilibrium(model, standing(model.bearing, operation.first_roller_angle), loads, tilted=tilted)
    total, force = float(found.inner_force.sum()), float(found.inner_force.max())
    share = force / total if total > 0.0 else 0.0
    return [
        Quantity("static_hub_x", "m", "hub at rest, x", float(found.hub[0])),
        Quantity("static_hub_y", "m", "hub at rest, y", float(found.hub[1])),
        Quantity("static_largest_force", "N", "largest force on the inner raceway, at rest", force),
        Quantity("static_largest_share", "1", "its share of all forces on the inner raceway", share),
    ]


class StaticError(NamedTuple):
    """The mesh against the series, standing, weightless and frictionless."""

    hub: float  # relative error of the hub's displacement
    largest_force: float  # largest error of a roller's load over the largest load


def static_error(model: Model, operation: Operation) -> StaticError:
    """How far the finite elements of a scene are from exact elasticity under its load. NotFound: no equilibrium."""
    exact = exact_statics(model.bearing, operation.radial_load, operation.first_roller_angle)
    found = static_equilibrium(model, operation)
    missed = np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()
    return StaticError(float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)), float(missed))


def static_equilibrium(model: Model, operation: Operation) -> Equilibrium:
    """Under the radial load alone: standing, weightless, frictionless. NotFound: none."""
    still = standing(model.bearing, operation.first_roller_angle)
    return equilibrium(model, still, Loads(operation.radial_load))
