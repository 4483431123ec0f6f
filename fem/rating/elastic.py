"""Equilibria of elastic rings and rollers over a pitch of the rollers, by the reduced model's contacts. SI."""

from dataclasses import replace

import numpy as np

from fem.statics.contact_balance import Loads, NotFound, balance, closed_forces, first_guess, hub_stiffness
from fem.statics.reduced_bearing import reduced_bearing
from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping
from lagrange.kinematics import kinematics
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import SAMPLES, Pitch, Point, approach_rates, damping_matrix, over_pitch
from lagrange.surface.deviation import UNTURNED


def elastic_pitch(
    bearing: Bearing, operation: Operation, damping: ContactDamping = UNDAMPED, samples: int = SAMPLES
) -> Pitch:
    """Of perfect surfaces under what loads the bearing, the outer ring held all around.

    Errors
    ------
    Unavailable: balls, a rigid body, or no equilibrium. Weight and centrifugal force of rollers act, but their share of
    the stiffness is left out (`hub_stiffness`).
    """
    if isinstance(bearing, BallBearing):
        raise Unavailable("elastic rings are implemented for rollers, not for balls")
    if any(material.rigid for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring)):
        raise Unavailable("[bodies]: elastic rings need elastic bodies; one is rigid")
    bearing = replace(bearing, faults=())
    motion = kinematics(bearing, *operation.ring_speeds)
    model = reduced_bearing(bearing, motion, operation.gravity)
    loads = Loads.of(operation, motion.cage)

    def solve(angles: np.ndarray, near: Point | None) -> Point:
        contacts = model.at(angles, UNTURNED)
        if near is None:
            start, forces = first_guess(bearing, contacts.radial, loads.hub, loads.side_load), None
        else:
            start = np.concatenate([near.place, near.rho])
            forces = np.concatenate([near.inner_force, near.outer_force])
        try:
            place, forces = balance(contacts, loads, start, forces)
        except NotFound as error:
            raise Unavailable(str(error)) from None
        forces = closed_forces(forces)
        n, pressed = bearing.n_rollers, np.where(forces > 0.0, forces, 1.0)
        laws = contacts.inner_law, contacts.outer_law
        soft = np.concatenate([law.softness(q) for law, q in zip(laws, (pressed[:n], pressed[n:]), strict=True)])
        closed = forces > 0.0
        stiff = np.zeros((2 * n, 2 * n))
        stiff[np.ix_(closed, closed)] = np.linalg.inv((contacts.compliance + np.diag(soft))[np.ix_(closed, closed)])
        rates = approach_rates(bearing, angles, place[:2], place[2:])
        return Point(
            place=place[:2], rho=place[2:], inner_force=forces[:n], outer_force=forces[n:],
            stiffness=hub_stiffness(contacts, place, forces, None),
            damping=damping_matrix(rates, stiff, 1.0 / soft, forces, damping),
        )  # fmt: skip

    return over_pitch(bearing, operation.first_roller_angle, solve, samples)
