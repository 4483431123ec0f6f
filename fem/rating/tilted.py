"""Equilibria of tilted rollers over a pitch: stiffness against displacement and slope, moments, pressures. SI."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.contacts.tilted import tilted_slices, too_narrow
from fem.statics.contact_balance import NotFound
from fem.statics.exact_statics import exact_contacts
from lagrange.axial import Axial
from lagrange.axial.pressure import SHARP, pressures, sharp_ends
from lagrange.axial.slices import Slices
from lagrange.axial.statics import TiltedBearing, TiltedStatics
from lagrange.axial.tabulate import contact_slices
from lagrange.bearing import Bearing, Operation
from lagrange.contact.raceway_laws import ContactLaws, contact_pairs
from lagrange.kinematics import roller_angles
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import Pitch, Point, over_pitch

SAMPLES = 16  # cage angles in a pitch


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltedPitch:
    """Equilibria of hub and tilted rollers over a pitch, with what their contacts are made of."""

    bearing: Bearing
    axial: Axial
    pitch: Pitch  # without damping
    statics: tuple[TiltedStatics, ...]  # by cage angle
    slices: tuple[Slices, Slices]

    @cached_property
    def loads(self) -> tuple[np.ndarray, np.ndarray]:
        """Forces of slices, inner and outer contact, (angles · n_rollers, n_slices), N."""
        inner, outer = (
            slices.forces(*(np.concatenate([getattr(each, name)[k] for each in self.statics])
                            for name in ("approach", "slope")))
            for k, slices in enumerate(self.slices)
        )  # fmt: skip
        return inner, outer

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Force, N, that a whole roller would bear at the pressure of its most loaded slice, by raceway.

        Errors
        ------
        Unavailable: an edge is loaded.
        """
        found = {}
        pairs, sharp = contact_pairs(self.bearing), sharp_ends(self.bearing, self.axial)
        for pair, slices, loads, edge in zip(pairs, self.slices, self.loads, sharp, strict=False):
            if edge and np.any(loads[:, [0, -1]] > 0.0):
                raise Unavailable(f"{SHARP}; forces and moments are sound")
            found[pair.kind] = slices.count * float(loads.max())
        return found

    @property
    def stiffness(self) -> np.ndarray:
        """(4, 4), of forces and moments by the hub's place and slope, x, y each, mean over the pitch; N/m, N, N m."""
        return np.mean([each.stiffness for each in self.statics], axis=0)

    @property
    def tilt_stiffness(self) -> float:
        """∂M/∂ψ in the plane of the load at a free hub, mean over the pitch, N m/rad."""
        found = []
        for each in self.statics:
            hub, cross, slope = each.stiffness[:2, :2], each.stiffness[:2, 2:], each.stiffness[2:, 2:]
            found.append((slope - cross.T @ np.linalg.solve(hub, cross))[1, 1])
        return float(np.mean(found))

    @property
    def moment(self) -> float:
        """That holds the shaft at its slope, in the plane of the load, mean over the pitch, N m."""
        return -float(np.mean([each.hub_moment[1] for each in self.statics]))

    @property
    def slope(self) -> float:
        """Of the shaft, its +z end towards the load, mean over the pitch, rad."""
        return -float(np.mean([each.hub_slope[1] for each in self.statics]))

    def pressures(self, angle: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Along the rollers at a cage angle: z, (n_slices,), m; inner and outer, (n_rollers, n_slices), Pa."""
        at, pairs = self.statics[angle], contact_pairs(self.bearing)
        inner, outer = (
            pressures(slices, pair, at.approach[k], at.slope[k])
            for k, (slices, pair) in enumerate(zip(self.slices, pairs[:2], strict=True))
        )
        return self.slices[0].place, inner, outer


def tilted_pitch(
    bearing: Bearing, axial: Axial, operation: Operation, laws: ContactLaws | None = None, samples: int = SAMPLES
) -> TiltedPitch:
    """Of perfect surfaces, weights of rollers and their centrifugal forces left out.

    Parameters
    ----------
    laws : of rigid rings, whose slices stand alone; None: elastic rings and rollers

    Errors
    ------
    Unavailable: a rigid body among elastic ones, no equilibrium, slices narrower than their contacts.
    """
    bearing = replace(bearing, faults=())
    down = float(operation.radial_load) + operation.inner_mass * operation.gravity
    load = float(operation.side_load), -down
    misalignment, first = operation.misalignment, roller_angles(bearing, operation.first_roller_angle)
    stiffness = axial.shaft_tilt_stiffness if axial.has_free_slope else None
    found: list[TiltedStatics] = []
    try:
        slices, compliance = contacts_of(bearing, axial, laws, first)

        def solve(angles: np.ndarray, near: Point | None) -> Point:
            standing = TiltedBearing(
                bearing=bearing, angle=angles, slices=slices, load=load, shaft_tilt_stiffness=stiffness,
                compliance=compliance,
            )  # fmt: skip
            still = standing.equilibrium((0.0, -misalignment))
            found.append(still)
            return Point(
                place=still.hub, rho=still.rho, inner_force=still.force[0], outer_force=still.force[1],
                stiffness=_hub(still.stiffness, stiffness), damping=np.zeros((2, 2)),
            )  # fmt: skip

        pitch = over_pitch(bearing, operation.first_roller_angle, solve, samples)
    except (RuntimeError, NotFound) as error:
        raise Unavailable(str(error)) from None
    answer = TiltedPitch(bearing=bearing, axial=axial, pitch=pitch, statics=tuple(found), slices=slices)
    if laws is None and axial.coupling:
        pairs = zip(contact_pairs(bearing), answer.loads, strict=False)
        widest = max(pair.half_width(axial.slices * float(loads.max())) for pair, loads in pairs)
        if (reason := too_narrow(bearing, axial, widest)) is not None:
            raise Unavailable(reason)
    return answer


def _hub(whole: np.ndarray, shaft: float | None) -> np.ndarray:
    """Stiffness of the hub's place, (2, 2), N/m, as a free slope follows."""
    if shaft is None:
        return whole[:2, :2]
    return whole[:2, :2] - whole[:2, 2:] @ np.linalg.solve(whole[2:, 2:], whole[2:, :2])


def contacts_of(
    bearing: Bearing, axial: Axial, laws: ContactLaws | None, angle: np.ndarray
) -> tuple[tuple[Slices, Slices], np.ndarray | None]:
    """Slices of both contacts, and elastic couplings."""
    if laws is not None:
        return contact_slices(bearing, replace(axial, coupling=False), laws), None
    if any(material.rigid for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring)):
        raise Unavailable("[bodies]: a body is rigid, and elastic rings take elastic bodies")
    contacts = exact_contacts(bearing, angle)
    curves = cast(tuple[ContactLaw, ContactLaw], (contacts.inner_law, contacts.outer_law))
    return tilted_slices(bearing, axial, curves), contacts.compliance
