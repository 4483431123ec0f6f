"""Equilibria of elastic rings and rollers, or of tilted rollers, over a pitch: stiffness, moments. SI."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.tilted import no_narrower, tilted_slices, too_narrow
from fem.statics.contact_balance import Loads, NotFound, balance, closed_forces, first_guess, hub_stiffness
from fem.statics.exact_statics import exact_contacts, exact_statics, reduced_bearing
from lagrange.axial.pressure import SHARP, profile_ends
from lagrange.axial.slices import Axial, Slices, contact_slices
from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.damping import UNDAMPED, ContactDamping
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import ContactLaws
from lagrange.kinematics import kinematics, roller_angles
from lagrange.motion import hub_tilt
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import SAMPLES, Pitch, Point, approach_rates, damping_matrix, mirrored, over_pitch
from lagrange.statics import Elastic, Placement, Statics, tilted_equilibrium
from lagrange.surface.deviation import UNTURNED

TILTED_SAMPLES = 16  # cage angles in a pitch


def _refuse_rigid(bearing):
    if bearing.roller.rigid or bearing.inner_ring.rigid or bearing.outer_ring.rigid:
        raise Unavailable("[bodies]: elastic rings need elastic bodies; one is rigid")


def elastic_pitch(
    bearing: Bearing, operation: Operation, damping: ContactDamping = UNDAMPED, samples: int = SAMPLES
) -> Pitch:
    """Of perfect surfaces under what loads the bearing, the outer ring held all around: the reduced model's contacts.
    Unavailable: balls, a rigid body, or no equilibrium. Weight and centrifugal force of rollers act, but their share of
    the stiffness is left out (`hub_stiffness`)."""
    if isinstance(bearing, BallBearing):
        raise Unavailable("elastic rings are implemented for rollers, not for balls")
    _refuse_rigid(bearing)
    bearing = replace(bearing, faults=())
    n, motion = bearing.n_rollers, kinematics(bearing, *operation.ring_speeds)
    model, loads = reduced_bearing(bearing, motion, operation.gravity), Loads.of(operation, motion.cage)

    def solve(angles, near):
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
        closed = forces > 0.0
        pressed = np.where(closed, forces, 1.0)
        soft = np.concatenate([contacts.inner_law.softness(pressed[:n]), contacts.outer_law.softness(pressed[n:])])
        stiff, both = np.zeros((2 * n, 2 * n)), np.ix_(closed, closed)
        stiff[both] = np.linalg.inv((contacts.compliance + np.diag(soft))[both])
        rates = approach_rates(bearing, angles, place[:2], place[2:])
        return Point(
            place=place[:2], rho=place[2:], inner_force=forces[:n], outer_force=forces[n:],
            stiffness=hub_stiffness(contacts, place, forces, None),
            damping=damping_matrix(rates, stiff, 1.0 / soft, forces, damping))  # fmt: skip

    return over_pitch(bearing, operation.first_roller_angle, solve, samples, mirrored(bearing, operation))


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltedPitch:
    """Equilibria of hub and tilted rollers over a pitch, with what their contacts are made of."""

    bearing: Bearing
    axial: Axial
    pitch: Pitch  # without damping
    statics: tuple[Statics, ...]  # by cage angle
    slices: tuple[Slices, Slices]

    @cached_property
    def loads(self) -> tuple[np.ndarray, np.ndarray]:
        """Forces of slices, inner and outer contact, (angles · n_rollers, n_slices), N."""
        inner, outer = (
            slices.forces(*np.concatenate([each.of_side(k) for each in self.statics], axis=1))
            for k, slices in enumerate(self.slices)
        )
        return inner, outer

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Force, N, of a whole roller at its most loaded slice's pressure, by raceway. Unavailable: a loaded edge."""
        found = {}
        pairs, ends = contact_pairs(self.bearing), profile_ends(self.bearing, self.axial)
        for pair, slices, loads, end in zip(pairs, self.slices, self.loads, ends, strict=False):
            if np.any(end.are_loaded(slices, slices.count * loads)):
                raise Unavailable(f"{SHARP}; forces and moments are sound")
            found[pair.kind] = slices.count * float(loads.max())
        return found

    # means over the pitch: (4, 4), of forces and moments by the hub's place and slope, x, y each; N/m, N, N m
    stiffness = property(lambda self: np.mean([each.stiffness for each in self.statics], axis=0))
    # that holds the shaft at its slope, in the plane of the load, N m; of the shaft, its +z end towards the load, rad
    moment = property(lambda self: float(np.mean([each.on_hub[1] for each in self.statics])))
    slope = property(lambda self: -float(np.mean([each.place[3] for each in self.statics])))

    @property
    def tilt_stiffness(self) -> float:  # ∂M/∂ψ in the plane of the load at a free hub, mean over the pitch, N m/rad
        found = []
        for each in self.statics:
            hub, cross, slope = each.stiffness[:2, :2], each.stiffness[:2, 2:], each.stiffness[2:, 2:]
            found.append((slope - cross.T @ np.linalg.solve(hub, cross))[1, 1])
        return float(np.mean(found))


def tilted_pitch(
    bearing: Bearing, axial: Axial, operation: Operation, laws: ContactLaws | None = None, samples: int = TILTED_SAMPLES
) -> TiltedPitch:
    """Of perfect surfaces, weights of rollers and their centrifugal forces left out.
    `laws` : of rigid rings, whose slices stand alone; None: elastic rings and rollers
    Unavailable: a rigid body among elastic ones, no equilibrium, slices narrower than their contacts."""
    bearing = replace(bearing, faults=())
    down = operation.radial_load + operation.inner_mass * operation.gravity
    still = replace(operation, speed=0.0, gravity=0.0, radial_load=down)
    if laws is not None or not axial.coupling:
        return _tilted_pitch(bearing, axial, still, laws, samples)
    try:
        plane = exact_statics(bearing, float(np.hypot(still.side_load, down)), operation.first_roller_angle)
    except NotFound as error:
        raise Unavailable(str(error)) from None
    tried = no_narrower(bearing, axial, (plane.inner_force, plane.outer_force))
    for these, angles in ((tried, 1), (axial, samples)):
        answer = _tilted_pitch(bearing, these, still, laws, angles)
        pairs = zip(contact_pairs(bearing), answer.loads, strict=False)
        widest = max(pair.half_width(these.slices * float(loads.max())) for pair, loads in pairs)
        if (reason := too_narrow(bearing, axial, widest)) is not None:
            raise Unavailable(reason)
    return answer


def _tilted_pitch(bearing, axial, still, laws, samples):
    """Whatever the slices' width. Unavailable."""
    hub, found, elastic = hub_tilt(still, axial), [], None
    try:
        if laws is not None:
            slices = contact_slices(bearing, replace(axial, coupling=False), laws)
        else:
            _refuse_rigid(bearing)
            contacts = exact_contacts(bearing, roller_angles(bearing, still.first_roller_angle))
            curves = cast(tuple[ContactLaw, ContactLaw], (contacts.inner_law, contacts.outer_law))
            slices, compliance = tilted_slices(bearing, axial, curves), contacts.compliance
            elastic = Elastic(compliance, np.zeros(compliance.shape), np.zeros(2 * bearing.n_rollers))

        def solve(angles: np.ndarray, near: Point | None) -> Point:
            start = _pushed(bearing, slices[0], still, angles) if near is None else (near.place, near.rho)
            now = tilted_equilibrium(bearing, still, slices, hub, Placement(angles), start, elastic)
            found.append(now)
            return Point(
                place=now.place[:2], rho=now.rho, inner_force=now.inner_force, outer_force=now.outer_force,
                stiffness=now.radial_stiffness, damping=np.zeros((2, 2)))  # fmt: skip

        pitch = over_pitch(bearing, still.first_roller_angle, solve, samples)
    except (RuntimeError, NotFound) as error:
        raise Unavailable(str(error)) from None
    return TiltedPitch(bearing=bearing, axial=axial, pitch=pitch, statics=tuple(found), slices=slices)


def _pushed(bearing, slices, operation, angle):
    """The hub where one roller carries the load, and radii of rollers midway."""
    load = np.array([float(operation.side_load), -float(operation.radial_load)])
    size = max(float(np.hypot(*load)), 1e-3)
    deep = max(float(slices.approach_under(0.5 * size, 0.0)), 0.0)
    hub = (max(bearing.radial_clearance, 0.0) + 2.0 * deep) * load / size
    return hub, bearing.pitch_radius + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]) @ hub
