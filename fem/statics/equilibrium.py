"""Static equilibrium: the rollers at given angles, the hub and the rollers' radii free, the bodies elastic.

The contact model reduces the bodies to points of the contacts; `contact_balance` and `pressure_balance` do the rest.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fem.contacts.model import Model, Motion, Reduced, standing, unloaded
from fem.contacts.tilted import MeshedContact
from fem.elastic.outer_support import MOST_SETTLINGS, NOT_SETTLED, BoredRing
from fem.quantities import Quantity
from fem.statics.contact_balance import (
    Condensed,
    Loads,
    NotFound,
    balance,
    closed_forces,
    first_guess,
    hub_spring,
)
from fem.statics.exact_statics import exact_contacts, exact_statics
from fem.statics.pressure_balance import balance_pressures
from lagrange import Operation
from lagrange.tilt import HubTilt, TiltedLaws
from lagrange.tilted_statics import Elastic, Placement, TiltedStatics, tilted_equilibrium


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
    model: Model,
    motion: Motion,
    loads: Loads,
    start: Equilibrium | None = None,
    tilted: TiltedBalance | None = None,
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
        if model.is_sized_by_forces:
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
    """Forces of the contacts, inner and then outer ones, (2 n_rollers,), N."""
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
    total = float(found.inner_force.sum())
    share = float(found.inner_force.max()) / total if total > 0.0 else 0.0
    force = float(found.inner_force.max())
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
    return StaticError(
        hub=float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)),
        largest_force=float(np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()),
    )


def static_equilibrium(model: Model, operation: Operation) -> Equilibrium:
    """Under the radial load alone: standing, weightless, frictionless. NotFound: none."""
    still = standing(model.bearing, operation.first_roller_angle)
    return equilibrium(model, still, Loads(operation.radial_load))
