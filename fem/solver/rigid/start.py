"""Where a run of the reduced model begins: equilibrium, velocities, tables of rollers that tilt."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.tilted import no_narrower, slice_law, tilted_slices, tilted_tables, too_narrow
from fem.statics.contact_balance import (
    ROUND_OFF,
    Condensed,
    Loads,
    NotFound,
    balance,
    closed_forces,
    edge_compliances,
    first_guess,
    geometry,
    hub_spring,
    hub_stiffness,
    passing,
    standing_ring,
)
from fem.statics.reduced_bearing import ReducedBearing, reduced_bearing
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial import ContactTable, SpalledTable
from lagrange.axial.facts import Axial
from lagrange.axial.pressure import exerted, placed
from lagrange.axial.slices import steepest_slope
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.first_state import places_moving, tilts_moving, weight_on_springs
from lagrange.kinematics import kinematics, roller_angles, turned
from lagrange.mounting import HELD
from lagrange.statics import Elastic, Placement, TiltedStatics, tilted_equilibrium
from lagrange.surface.deviation import UNTURNED, Turns
from lagrange.tilt import TiltedLaws, Tilts, hub_tilt

NEWTON_STEPS = 20
NOWHERE = np.zeros(2)  # from the ground, m, an outer ring that it holds
LOOK_AHEAD = 1e-4  # of a roller's radius: how far contacts roll between the equilibria that give the velocities


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
    steady: bool  # forces hold every roller on its circle
    ring: np.ndarray  # (2,), of the outer ring's centre, from which all other places are
    warning: str | None = None  # on velocities that it starts without
    tilts: Tilts | None = None  # None: axes stay parallel
    inner_moment: np.ndarray | None = None  # (n_rollers,), N m
    outer_moment: np.ndarray | None = None


class Balanced(NamedTuple):
    """An equilibrium with rollers at their angles."""

    place: np.ndarray  # (n_rollers + 2,), m, hub and radii
    forces: np.ndarray  # (2 n_rollers,), N

    @property
    def hub(self) -> np.ndarray:
        return self.place[:2]


def equilibrium_start(model: ReducedBearing, operation: Operation) -> ReducedStart:
    """Static equilibrium at t = 0, with the velocities of `passing`. NotFound: no equilibrium."""
    bearing = model.bearing
    angle = roller_angles(bearing, operation.first_roller_angle)
    radial = np.array([np.cos(angle), np.sin(angle)])

    def force_at(where):
        return radial @ closed_forces(_balanced(model, operation, 0.0, ring=where).forces)[bearing.n_rollers :]

    ring = standing_ring(operation, weight_on_springs(bearing, operation), force_at)
    middle = _balanced(model, operation, 0.0, ring=ring)

    def stiffness() -> np.ndarray:
        return hub_stiffness(model.at(angle, UNTURNED), *middle, hub_spring(operation, ring))

    way = LOOK_AHEAD * bearing.roller_radius
    found, warning = passing(
        lambda time: _balanced(model, operation, time, middle, ring), stiffness, bearing, operation, way
    )
    rate = np.zeros_like(middle.place) if found is None else found.rate("place")
    return replace(_start(model, operation, middle.place, rate, middle.forces), ring=ring, warning=warning)


def rest_start(model: ReducedBearing, operation: Operation) -> ReducedStart:
    """Centred, in rolling motion; with preload, the equilibrium without load.

    Without preload no contact is strained but by what bodies grow as they spin.
    """
    bearing, n, alone = model.bearing, model.bearing.n_rollers, replace(operation.mounting, shaft=None)
    at_rest = replace(operation, mounting=alone)
    ring = standing_ring(at_rest, weight_on_springs(bearing, operation), lambda _: np.zeros(2))
    if bearing.radial_clearance < -ROUND_OFF * bearing.roller_radius:
        unloaded = replace(operation, radial_load=0.0, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
        place, forces = _balanced(model, unloaded, 0.0)
        return replace(_start(model, operation, place, np.zeros_like(place), forces), ring=ring)
    place = np.concatenate([np.zeros(2), np.full(n, bearing.pitch_radius)])
    angle = roller_angles(bearing, operation.first_roller_angle)
    contacts = model.at(angle, UNTURNED)
    edges = np.diag(edge_compliances(bearing, contacts.radial, place))
    contacts = replace(contacts, compliance=contacts.compliance + edges)
    forces = _forces_at(contacts, geometry(bearing, contacts.radial, place, UNTURNED)[0] + contacts.closing)
    return replace(_start(model, operation, place, np.zeros_like(place), forces, steady=False), ring=ring)


def standing_hub(model: ReducedBearing, operation: Operation) -> np.ndarray:
    """Hub of the bearing alone under the radial load, standing, weightless, (2,), m. NotFound: no equilibrium."""
    alone = replace(operation, speed=0.0, outer_speed=0.0, side_load=0.0, gravity=0.0, history=None, mounting=HELD)
    still = reduced_bearing(model.bearing, kinematics(model.bearing, 0.0))
    return _balanced(still, alone, 0.0).hub


def _forces_at(contacts: Condensed, overlap: np.ndarray) -> np.ndarray:
    """Forces, (2 n_rollers,), N, at overlaps, m: Newton's method on the contacts that are closed."""
    n, closed = contacts.bearing.n_rollers, np.flatnonzero(overlap > 0.0)
    laws = [contacts.inner_law if c < n else contacts.outer_law for c in closed]
    compliance = contacts.compliance[np.ix_(closed, closed)]
    force = np.array([float(slice_law(law, None).force(overlap[c])) for law, c in zip(laws, closed, strict=True)])
    for _ in range(NEWTON_STEPS):
        approach = np.array([float(law.approach(q)) for law, q in zip(laws, force, strict=True)])
        soft = np.array([float(law.softness(q)) for law, q in zip(laws, force, strict=True)])
        step = np.linalg.solve(compliance + np.diag(soft), overlap[closed] - compliance @ force - approach)
        force = np.maximum(force + step, 0.1 * force)
    found = np.zeros(2 * n)
    found[closed] = force
    return found


def _balanced(model, operation, time, middle=None, ring=NOWHERE) -> Balanced:
    """Hub and radii, m, and forces, N, in equilibrium with rollers at their angles of a time, s; `middle`: one near."""
    bearing, acting = model.bearing, operation.at(time)
    angle = roller_angles(bearing, operation.first_roller_angle) + turned(bearing, operation, time).cage
    contacts = model.at(angle, Turns.rolling(bearing, operation, time))
    load, side_load = float(acting.radial_load) + operation.inner_mass * operation.gravity, float(acting.side_load)
    start, near = (first_guess(bearing, contacts.radial, load, side_load), None) if middle is None else middle
    cage = kinematics(bearing, *operation.ring_speeds).cage
    spring = hub_spring(operation, ring)
    return Balanced(*balance(contacts, Loads(load, operation.gravity, cage, side_load, spring), start, near))


def _start(model, operation, place, rate, forces, steady=True) -> ReducedStart:
    n, forces = model.bearing.n_rollers, closed_forces(forces)
    return ReducedStart(
        kinematics=kinematics(model.bearing, *operation.ring_speeds),
        angle=roller_angles(model.bearing, operation.first_roller_angle),
        hub=place[:2],
        rho=place[2:],
        hub_velocity=rate[:2],
        rho_rate=rate[2:],
        inner_force=forces[:n],
        outer_force=forces[n:],
        steady=steady,
        ring=np.zeros(2),
    )


MOVING = 2.0  # times the force at rest: rollers that move tilt further


def tables_of(
    model: ReducedBearing, operation: Operation, axial: Axial, force: float
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:
    """Tables of both contacts, for forces at rest of so many N."""
    bearing, laws = model.bearing, (model.inner_law, model.outer_law)
    slope = steepest_slope(bearing, axial, operation.misalignment, float(laws[0].approach(MOVING * force)))
    return tilted_tables(bearing, axial, laws, force, slope)


def tilted_start(
    model: ReducedBearing,
    operation: Operation,
    axial: Axial,
    tables: tuple[ContactTable | SpalledTable, ContactTable | SpalledTable],
    plane: ReducedStart,
) -> ReducedStart:
    """Static equilibrium near that of parallel axes, with the velocities of passing through those before and after.

    A start from rest is that without the load, and stands.

    Errors
    ------
    NotFound: no equilibrium.
    """
    bearing, n = model.bearing, model.bearing.n_rollers
    if not plane.steady:
        operation = replace(operation, radial_load=0.0, side_load=0.0, gravity=0.0, history=None)

    def balanced(time: float) -> TiltedStatics:
        return _tilted_at(model, operation, axial, TiltedLaws(*tables), plane, time)

    now = balanced(0.0)
    found, warning = None, None
    if plane.steady:
        way = LOOK_AHEAD * bearing.roller_radius
        found, warning = passing(balanced, lambda: now.radial_stiffness, bearing, operation, way)
    rates = np.zeros(4 + 2 * n) if found is None else places_moving(found.before, now, found.after, found.time)
    return replace(
        plane,
        hub=now.hub, rho=now.rho, hub_velocity=rates[:2], rho_rate=rates[4 : 4 + n],
        inner_force=now.inner_force, outer_force=now.outer_force, warning=warning,
        inner_moment=now.inner_moment, outer_moment=now.outer_moment, tilts=tilts_moving(now, rates),
    )  # fmt: skip


def _tilted_at(
    model: ReducedBearing, operation: Operation, axial: Axial, laws: TiltedLaws, plane: ReducedStart, time: float
) -> TiltedStatics:
    """Equilibrium at a time, s, near that of parallel axes. NotFound."""
    bearing, share = model.bearing, 12.0 / model.bearing.roller_length**2
    angle = roller_angles(bearing, operation.first_roller_angle) + turned(bearing, operation, time).cage
    contacts = model.at(angle, UNTURNED)
    elastic = Elastic(contacts.compliance, share * _along(contacts.compliance), contacts.closing)
    placement = Placement(angle, plane.ring, Turns.rolling(bearing, operation, time))
    acting, start = operation.at(time), (plane.hub, plane.rho)
    try:
        return tilted_equilibrium(bearing, acting, laws, hub_tilt(operation, axial), placement, start, elastic)
    except RuntimeError as error:
        raise NotFound(str(error)) from None


def check_slices(model: ReducedBearing, operation: Operation, axial: Axial, loaded: ReducedStart) -> None:
    """Refuse coupled slices that are too narrow at rest under the load, before tables are made for them.

    Where there are more than forces allow that are even along the rollers, fewer say how wide contacts are.

    Errors
    ------
    UsageError: too narrow. NotFound: no equilibrium.
    """
    if not axial.coupling:
        return
    bearing, laws = model.bearing, (model.inner_law, model.outer_law)
    tried = no_narrower(bearing, axial, (loaded.inner_force, loaded.outer_force))
    slices = TiltedLaws(*tilted_slices(bearing, tried, laws))
    still = _tilted_at(model, operation, tried, slices, loaded, 0.0)
    if (reason := too_narrow(bearing, axial, _widest_contact(bearing, tried, laws, still))) is not None:
        raise UsageError(reason)


def narrow_slices(
    bearing: Bearing, axial: Axial, laws: tuple[ContactLaw, ContactLaw], start: TiltedStatics
) -> str | None:
    """Why coupled slices can't carry the largest forces of a start, with the number that can; None: they do.

    `laws` : plane ones of whole contacts, inner and outer
    """
    return too_narrow(bearing, axial, _widest_contact(bearing, axial, laws, start)) if axial.coupling else None


def _widest_contact(bearing: Bearing, axial: Axial, laws: tuple[ContactLaw, ContactLaw], start: TiltedStatics) -> float:
    widest, slices = 0.0, tilted_slices(bearing, axial, laws)
    loads = (start.inner_force, start.inner_moment), (start.outer_force, start.outer_moment)
    for each, pair, (force, moment) in zip(slices, contact_pairs(bearing), loads, strict=False):
        j = int(force.argmax())
        if force[j] > 0.0:
            held = exerted(each, force, moment)[j]
            carried = each.forces(*placed(each, float(force[j]), float(held)))
            widest = max(widest, pair.half_width(axial.slices * float(carried.max())))
    return widest


def _along(compliance: np.ndarray) -> np.ndarray:
    """Of the rings alone, (2 n, 2 n), m/N: rollers' own squeezing by moments is in their contacts' tables."""
    n = compliance.shape[0] // 2
    found = compliance.copy()
    found[range(n), range(n, 2 * n)] = found[range(n, 2 * n), range(n)] = 0.0
    return found
