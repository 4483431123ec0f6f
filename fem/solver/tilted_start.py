"""Where a run of the reduced model with rollers that tilt begins: tables of its contacts, equilibrium, velocities."""

from dataclasses import replace
from math import inf

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.tilted import no_narrower, tilted_slices, tilted_tables, too_narrow
from fem.errors import UsageError
from fem.solver.reduced_start import LOOK_AHEAD, ReducedStart
from fem.statics.contact_balance import NotFound
from fem.statics.reduced_bearing import ReducedBearing
from lagrange import Bearing, Operation
from lagrange.axial import ContactTable, SpalledTable
from lagrange.axial.facts import Axial
from lagrange.axial.pressure import exerted, placed
from lagrange.axial.tabulate import steepest_slope
from lagrange.contact.hertz import contact_pairs
from lagrange.first_state import JUMP, JUMPS, SOFT, followed, places_moving, surface_speed
from lagrange.kinematics import roller_angles, turned
from lagrange.load_history import LONGEST_LOOK, SLOWEST
from lagrange.surface.deviation import UNTURNED, Turns
from lagrange.tilt import TiltedLaws, Tilts, hub_tilt
from lagrange.tilted_statics import Elastic, Placement, TiltedStatics, tilted_equilibrium

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
        return _balanced(model, operation, axial, TiltedLaws(*tables), plane, time)

    now, rates, warning = balanced(0.0), np.zeros(4 + 2 * n), None
    speed = surface_speed(bearing, operation)
    if speed > SLOWEST and plane.steady:
        if followed(now.radial_stiffness, bearing, operation)[0].size < 2:
            warning = SOFT
        else:
            ahead = min(LOOK_AHEAD * bearing.roller_radius / speed, inf if operation.history is None else LONGEST_LOOK)
            found = places_moving(balanced(-ahead), now, balanced(ahead), ahead)
            rates, warning = (found, None) if np.hypot(*found[:2]) <= JUMP * speed else (rates, JUMPS)
    return replace(
        plane,
        hub=now.place[:2], rho=now.rho, hub_velocity=rates[:2], rho_rate=rates[4 : 4 + n],
        inner_force=now.inner_force, outer_force=now.outer_force, warning=warning,
        inner_moment=now.inner_moment, outer_moment=now.outer_moment,
        tilts=Tilts(
            tilt=now.tilt, tilt_rate=rates[4 + n :],
            slope_x=now.place[2], slope_y=now.place[3], slope_x_rate=rates[2], slope_y_rate=rates[3],
        ),
    )  # fmt: skip


def _balanced(
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
    still = _balanced(model, operation, tried, slices, loaded, 0.0)
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
    """Half-width of the most loaded slice's contact, m."""
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
