"""Static equilibrium of meshed bodies: the rollers at given angles, the hub and the rollers' radii free.

The contact model reduces the bodies to points of the contacts, which `contact_balance` balances."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fem.contacts.model import Model, Motion, Reduced, standing, unloaded
from fem.contacts.tilted import MeshedContact
from fem.elastic.outer_support import MOST_SETTLINGS, NOT_SETTLED, BoredRing
from fem.quantities import Quantity
from fem.statics import contact_balance as balances
from fem.statics.contact_balance import Condensed, Loads, NotFound, closed_forces
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange import Operation
from lagrange.motion import HubTilt
from lagrange.statics import Elastic, Statics


class Equilibrium(NamedTuple):
    """Positions, contact forces and elastic displacements; m and N."""

    hub: np.ndarray  # (2,)
    rho: np.ndarray  # (n_rollers,)
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray
    inner_ring: np.ndarray  # (n_rows, 2, n_sectors), polar, relative to the hub, in the ring's frame
    outer_ring: np.ndarray  # (n_rows, 2, n_sectors), polar
    rollers: np.ndarray  # (n_rollers, n_nodes, 2), in each roller's frame, about its centre of mass
    axes: Statics | None = None  # of rollers that tilt; None: axes stay parallel

    place = property(lambda self: np.concatenate([self.hub, self.rho]))
    forces = property(lambda self: np.concatenate([self.inner_force, self.outer_force]))


class Tilting(NamedTuple):
    """What balances a bearing of rollers that tilt in place of `contact_balance.balance`. Meshes bear no moments."""

    operation: Operation  # at an instant
    laws: tuple[MeshedContact, MeshedContact]  # inner and outer contacts
    hub: HubTilt
    near: Equilibrium  # of parallel axes
    ring: np.ndarray  # (2,), m, of the outer ring's centre

    def at(self, acting: Operation, ring: np.ndarray) -> "Tilting":
        """The same under what acts at an instant, with the outer ring's centre at a place, (2,), m."""
        return self._replace(operation=acting, ring=ring)

    def found(self, contacts: Condensed, place: np.ndarray) -> Statics:
        """The equilibrium near hub and radii at a place, (n_rollers + 2,), m. NotFound: there is none."""
        own = np.repeat([law.meshed for law in self.laws], contacts.bearing.n_rollers)
        between = contacts.compliance - np.diag(own)
        elastic = Elastic(between, np.zeros_like(between), contacts.closing)
        return balances.tilted_balance(contacts, self.operation, self.laws, self.hub, self.ring, place, elastic)


def equilibrium(
    model: Model, motion: Motion, loads: Loads, start: Equilibrium | None = None, tilted: Tilting | None = None
) -> Equilibrium:
    """Solve for the equilibrium under loads, of rollers that go round as fast as they do in the motion.

    start : one that is near
    tilted : contacts and operation of rollers that tilt; None: axes stay parallel

    Steady rotation acts as centrifugal load on rollers and ring. Friction and the rollers' balance along the raceway
    are left out: their angles are given.

    Errors: NotFound: no equilibrium. The contact balance is exact to about 1e-9 of the load.
    """
    reduced, place, pressed, axes = solved(model, motion, loads, start, tilted)
    inner_force, outer_force = reduced.sums(pressed).reshape(2, -1)
    inner_ring, outer_ring, rollers = reduced.fields(pressed)
    return Equilibrium(
        hub=place[:2], rho=place[2:], inner_force=inner_force, outer_force=outer_force, inner_ring=inner_ring,
        outer_ring=outer_ring, rollers=rollers, axes=axes,
    )  # fmt: skip


def solved(
    model: Model, motion: Motion, loads: Loads, start: Equilibrium | None = None, tilted: Tilting | None = None
) -> tuple[Reduced, np.ndarray, np.ndarray, Statics | None]:
    """The bearing reduced to points, hub and radii, the forces of the points, and what tilts, in equilibrium."""
    bearing, loads, axes = model.bearing, loads._replace(cage_speed=motion.cage_speed), None
    if start is not None:
        if isinstance(model.outer_ring, BoredRing):
            model = _settled(model, start.outer_ring)
        place, forces, pressed = start.place, start.forces, start.forces
    else:
        place, forces, pressed = balances.first_guess(bearing, motion.radial, loads.hub, loads.side_load), None, None
        if not model.has_law:
            place, forces = balances.balance(exact_contacts(bearing, motion.roller_angle), loads)
            pressed = forces
    free = unloaded(model, motion, loads.gravity)
    passes = model.static_passes if start is None else max(1, model.static_passes - 1)  # from near one less will do
    for turn in range(MOST_SETTLINGS):
        reduced = model.reduced(motion, free, place, forces)
        contacts = Condensed(
            bearing=bearing, radial=motion.radial, inner_law=model.inner_law, outer_law=model.outer_law,
            compliance=reduced.compliance, closing=reduced.closing, turns=motion.turns, contact=reduced.contact,
        )  # fmt: skip
        if tilted is None:
            near = pressed if pressed is not None and pressed.size == reduced.contact.size else None
            place, pressed = balances.balance(contacts, loads, place, near)
        else:
            axes = tilted.found(contacts, place)
            place = np.concatenate([axes.place[:2], axes.rho])
            pressed = np.concatenate([axes.inner_force, axes.outer_force])
        pressed = closed_forces(pressed)
        forces = reduced.sums(pressed)
        found = _settled(model, reduced.fields(pressed)[1]) if isinstance(model.outer_ring, BoredRing) else model
        if found is not model:
            model, free = found, unloaded(found, motion, loads.gravity)
        elif turn + 1 >= passes:
            return reduced, place, pressed, axes
    raise NotFound(NOT_SETTLED)


def _settled(model, outer_ring):
    """The model with an outer ring that touches its bore where its displacement, (n_rows, 2, n_sectors), m, says so."""
    ring = model.outer_ring.settled(outer_ring)
    return model if ring is model.outer_ring else replace(model, outer_ring=ring)


def static_quantities(model: Model, operation: Operation, tilted: Tilting | None = None) -> list[Quantity]:
    """Quantities of the bearing at rest under load and weight, rollers where the scene puts them.

    `tilted` : where rollers tilt. NotFound: no equilibrium.
    """
    loads = Loads.of(operation if tilted is None else tilted.operation, ring=np.zeros(2))
    found = equilibrium(model, standing(model.bearing, operation.first_roller_angle), loads, tilted=tilted)
    total, force = float(found.inner_force.sum()), float(found.inner_force.max())
    share = force / total if total > 0.0 else 0.0
    return [
        Quantity("static_hub_x", "m", "hub at rest, x", float(found.hub[0])),
        Quantity("static_hub_y", "m", "hub at rest, y", float(found.hub[1])),
        Quantity("static_largest_force", "N", "largest force on the inner raceway, at rest", force),
        Quantity("static_largest_share", "1", "its share of all forces on the inner raceway", share),
    ]


def static_equilibrium(model: Model, operation: Operation) -> Equilibrium:
    """Under the radial load alone: standing, weightless, frictionless. NotFound: none."""
    still = standing(model.bearing, operation.first_roller_angle)
    return equilibrium(model, still, Loads(operation.radial_load))


def static_error(model: Model, operation: Operation) -> tuple[float, float]:
    """How far the finite elements of a scene are from exact elasticity under its load, weightless and frictionless.

    Relative error of the hub's displacement; largest error of a roller's load over the largest. NotFound.
    """
    exact = exact_statics(model.bearing, operation.radial_load, operation.first_roller_angle)
    found = static_equilibrium(model, operation)
    missed = np.abs(found.inner_force - exact.inner_force).max() / exact.inner_force.max()
    return float(np.linalg.norm(found.hub - exact.hub) / np.linalg.norm(exact.hub)), float(missed)
