"""Where bodies whose elasticity has no mass begin: equilibrium, velocities, tables and slices of rollers that tilt."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.tilted import NOTHING, no_narrower, tilted_slices, tilted_tables, too_narrow
from fem.statics import contact_balance as statics
from fem.statics.contact_balance import Loads, hub_spring
from fem.statics.exact_statics import ReducedBearing, reduced_bearing
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial.pressure import exerted, placed
from lagrange.axial.slices import Axial, steepest_slope
from lagrange.axial.table import ContactTable, SpalledTable
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.first_state import passing, places_moving, tilts_moving, weight_on_springs
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.motion import Tilts, hub_tilt
from lagrange.mounting import HELD, ring_place
from lagrange.statics import Elastic, Statics
from lagrange.surface.deviation import Turns

NEWTON_STEPS = 30
NOWHERE = np.zeros(2)  # from the ground, m, an outer ring that it holds
LOOK_AHEAD = 1e-4  # of a roller's radius: how far contacts roll between the equilibria that give the velocities
Tables = tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]  # of the inner and the outer contacts
Laws = tuple[ContactLaw, ContactLaw]


@dataclass(frozen=True, kw_only=True)
class ReducedStart:
    """Positions, velocities and contact forces at t = 0; SI."""

    kinematics: Kinematics
    angle: np.ndarray  # (n_rollers,), rad
    hub: np.ndarray  # (2,)
    rho: np.ndarray  # (n_rollers,)
    hub_velocity: np.ndarray  # (2,)
    rho_rate: np.ndarray  # (n_rollers,)
    inner_force: np.ndarray  # (n_rollers,)
    outer_force: np.ndarray
    steady: bool = True  # forces hold every roller on its circle
    ring: np.ndarray  # (2,), of the outer ring's centre, from which all other places are
    warning: str | None = None  # on velocities that it starts without
    tilts: Tilts | None = None  # None: axes stay parallel
    inner_moment: np.ndarray | None = None  # (n_rollers,), N m
    outer_moment: np.ndarray | None = None

    place = property(lambda self: np.concatenate([self.hub, self.rho]))
    forces = property(lambda self: np.concatenate([self.inner_force, self.outer_force]))


class Balanced(NamedTuple):
    """An equilibrium with rollers at their angles."""

    place: np.ndarray  # (n_rollers + 2,), m, hub and radii
    forces: np.ndarray  # (2 n_rollers,), N

    hub = property(lambda self: self.place[:2])


def unloaded(operation: Operation) -> Operation:
    """Without load, weight and what changes them."""
    return replace(operation, radial_load=0.0, side_load=0.0, gravity=0.0, history=None)


def equilibrium_start(model: ReducedBearing, operation: Operation) -> ReducedStart:
    """Static equilibrium at t = 0, with the velocities of `passing`. NotFound: no equilibrium."""
    bearing, n, contacts = model.bearing, model.bearing.n_rollers, _contacts_at(model, operation, 0.0)

    def force_at(where):
        return statics.closed_forces(_balanced(model, operation, 0.0, ring=where).forces)[n:] @ contacts.radial

    ring = ring_place(operation.mounting, weight_on_springs(bearing, operation), force_at)
    middle = _balanced(model, operation, 0.0, ring=ring)
    found, warning = passing(
        lambda time: _balanced(model, operation, time, middle, ring),
        lambda: statics.hub_stiffness(contacts, *middle, hub_spring(operation, ring)),
        bearing, operation, LOOK_AHEAD * bearing.roller_radius,
    )  # fmt: skip
    return _start(model, operation, *middle, ring, found, warning=warning)


def rest_start(model: ReducedBearing, operation: Operation) -> ReducedStart:
    """Centred, in rolling motion; with preload, the equilibrium without load.

    Without preload no contact is strained but by what bodies grow as they spin.
    """
    bearing, n, alone = model.bearing, model.bearing.n_rollers, replace(operation.mounting, shaft=None)
    ring = ring_place(alone, weight_on_springs(bearing, operation), lambda _: np.zeros(2))
    if bearing.radial_clearance < -statics.ROUND_OFF * bearing.roller_radius:
        balanced = _balanced(model, replace(unloaded(operation), mounting=HELD), 0.0)
        return _start(model, operation, *balanced, ring)
    place = np.concatenate([np.zeros(2), np.full(n, bearing.pitch_radius)])
    held = statics.Held(_contacts_at(model, operation, 0.0), Loads(0.0), place, np.zeros(2 * n))
    law, closed, force = held.contacts.law, np.flatnonzero(held.overlap > 0.0), np.where(held.overlap > 0.0, 1.0, 0.0)
    own = held.compliance[np.ix_(closed, closed)]
    for _ in range(NEWTON_STEPS):  # on the contacts that are closed
        soft = own + np.diag(law.softness(np.where(force > 0.0, force, 1.0))[closed])
        left = held.through(place, force)[closed]
        force[closed] = np.maximum(force[closed] + np.linalg.solve(soft, left), 0.1 * force[closed])
    return _start(model, operation, place, force, ring, steady=False)


def standing_hub(model: ReducedBearing, operation: Operation) -> np.ndarray:
    """Hub of the bearing alone under the radial load, standing, weightless, (2,), m. NotFound: no equilibrium."""
    alone = replace(operation, speed=0.0, outer_speed=0.0, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
    return _balanced(reduced_bearing(model.bearing, kinematics(model.bearing, 0.0)), alone, 0.0).hub


def _contacts_at(model, operation, time):
    bearing = model.bearing
    angle = roller_angles(bearing, operation.first_roller_angle) + turned(bearing, operation, time).cage
    return model.at(angle, Turns.rolling(bearing, operation, time))


def _balanced(model, operation, time, middle=None, ring=NOWHERE):
    """Hub and radii, m, and forces, N, in equilibrium with rollers at their angles of a time, s; `middle`: one near."""
    contacts, cage = _contacts_at(model, operation, time), kinematics(model.bearing, *operation.ring_speeds).cage
    return Balanced(*statics.balance(contacts, Loads.of(operation.at(time), cage, ring), *(middle or ())))


def _start(model, operation, place, forces, ring, found=None, **more):
    bearing, n, forces = model.bearing, model.bearing.n_rollers, statics.closed_forces(forces)
    rate = np.zeros_like(place) if found is None else found.rate("place")
    return ReducedStart(
        kinematics=kinematics(bearing, *operation.ring_speeds),
        angle=roller_angles(bearing, operation.first_roller_angle), hub=place[:2], rho=place[2:], hub_velocity=rate[:2],
        rho_rate=rate[2:], inner_force=forces[:n], outer_force=forces[n:], ring=ring, **more,
    )  # fmt: skip


MOVING = 2.0  # times the force at rest: rollers that move tilt further


def tables_of(bearing: Bearing, operation: Operation, axial: Axial, laws: Laws, force: float, meshed=NOTHING) -> Tables:
    """Tables of both contacts, for forces at rest of so many N, by plane laws of the whole contacts.

    `meshed` : m/N, what meshes have of their compliances
    """
    slope = steepest_slope(bearing, axial, operation.misalignment, float(laws[0].approach(MOVING * force)))
    return tilted_tables(bearing, axial, laws, force, slope, meshed)


def tilted_start(
    model: ReducedBearing, operation: Operation, axial: Axial, tables: Tables, plane: ReducedStart
) -> ReducedStart:
    """Static equilibrium near that of parallel axes, with the velocities of passing through those before and after.

    A start from rest is that without the load, and stands.

    NotFound: no equilibrium.
    """
    operation, n = operation if plane.steady else unloaded(operation), model.bearing.n_rollers

    def balanced(time):
        return _tilted_at(model, operation, axial, tables, plane, time)

    now, found, warning = balanced(0.0), None, None
    if plane.steady:
        way = LOOK_AHEAD * model.bearing.roller_radius
        found, warning = passing(balanced, lambda: now.radial_stiffness, model.bearing, operation, way)
    rates = places_moving(now, found)
    return replace(
        plane, hub=now.hub, rho=now.rho, hub_velocity=rates[:2], rho_rate=rates[4 : 4 + n], inner_force=now.inner_force,
        outer_force=now.outer_force, warning=warning, inner_moment=now.inner_moment, outer_moment=now.outer_moment,
        tilts=tilts_moving(now, rates),
    )  # fmt: skip


def _tilted_at(model, operation, axial, laws, plane, time):
    """Equilibrium at a time, s, near that of parallel axes. NotFound."""
    contacts, n = _contacts_at(model, operation, time), model.bearing.n_rollers
    along = 12.0 / model.bearing.roller_length**2 * contacts.compliance
    along[range(n), range(n, 2 * n)] = along[range(n, 2 * n), range(n)] = 0.0  # rollers' own is in contacts' tables
    elastic, hub = Elastic(contacts.compliance, along, contacts.closing), hub_tilt(operation, axial)
    return statics.tilted_balance(contacts, operation.at(time), laws, hub, plane.ring, plane.place, elastic)


def check_slices(model: ReducedBearing, operation: Operation, axial: Axial, loaded: ReducedStart) -> None:
    """Refuse coupled slices that are too narrow at rest under the load, before tables are made for them.

    Where there are more than forces allow that are even along the rollers, fewer say how wide contacts are.

    UsageError: too narrow. NotFound: no equilibrium.
    """
    if axial.coupling:
        tried = no_narrower(model.bearing, axial, (loaded.inner_force, loaded.outer_force))
        slices = tilted_slices(model.bearing, tried, model.laws)
        check_narrow(model.bearing, axial, model.laws, _tilted_at(model, operation, tried, slices, loaded, 0.0), tried)


def check_narrow(bearing: Bearing, axial: Axial, laws: Laws, start: Statics, tried: Axial | None = None) -> None:
    """Refuse coupled slices that can't carry the largest forces of a start, naming the number that can. UsageError.

    `laws` : plane ones of whole contacts, inner and outer; `tried` : the slices of the start, None: the same
    """
    if not axial.coupling:
        return
    tried, widest = tried or axial, 0.0
    loads = (start.inner_force, start.inner_moment), (start.outer_force, start.outer_moment)
    slices = tilted_slices(bearing, tried, laws)
    for each, pair, (force, moment) in zip(slices, contact_pairs(bearing), loads, strict=False):
        j = int(force.argmax())
        if force[j] > 0.0:
            carried = each.forces(*placed(each, float(force[j]), float(exerted(each, force, moment)[j])))
            widest = max(widest, pair.half_width(tried.slices * float(carried.max())))
    if (reason := too_narrow(bearing, axial, widest)) is not None:
        raise UsageError(reason)
