"""Two step lengths for bearings with spalls, for the reduced model's time loop: how long, and where which."""

from dataclasses import dataclass, replace
from math import ceil, inf, pi
from typing import TYPE_CHECKING

import numpy as np

from fem.kernels.reduced_paces import INSIDE, ON_INNER_RING, ON_OUTER_RING, OUTSIDE, Paces
from fem.kernels.reduced_state import ReducedDrive
from lagrange import Bearing, Kinematics, kinematics
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.reduced import ReducedPlan

WAY = 0.02  # of a spall with its edges, that contacts go in a section at most: what is looked at no more often
REACH = 2.0  # sections' ways, from which on a contact is near
WORTH = 0.7  # of the steps of one length, that those of two must come down to
CALM = 3e-5  # of the energy of load and strike: what a change to longer steps may miss
STEADY = 4.0  # times what rollers on their circles have of that: less is no vibration
AFTER = 1.3  # times the way near edges: steps stay short while strikes die away
INSTANTS = 400  # of a turn of the cage, by which the share of short steps is told


@dataclass(frozen=True, kw_only=True)
class Sections:
    """Steps of one length each."""

    count: int  # of a row
    near: int  # steps of a section near edges, or while strikes die away
    far: int  # of any other
    share: float  # of sections near edges, about
    margin: float  # m, beyond edges, from which on contacts are near
    strike: float  # J, of a roller that falls into a spall

    def finer(self, times: int) -> "Sections":
        """With so many times as many steps."""
        return replace(self, near=times * self.near, far=times * self.far)

    @property
    def mean(self) -> float:
        """Steps of a section, about."""
        return self.share * self.near + (1.0 - self.share) * self.far


def sections_of(bearing: Bearing, ideal: Kinematics, row: float, short: float, long: float) -> Sections | None:
    """How rows of a time, s, are cut; None: steps of one length do as well.

    Parameters
    ----------
    ideal : at the fastest speed
    short, long : s, the longest steps near edges and elsewhere
    """
    arcs, speed = list(_spalls(bearing)), abs(ideal.cage) * bearing.outer_raceway_radius
    if not arcs or speed == 0.0 or short >= long:
        return None
    fall = max(np.abs(np.diff(profile.coefficients)).max() / profile.spacing for _, profile, _, _ in arcs) * speed
    ways = (2.0 * half * radius for _, _, (_, _, half), radius in arcs)
    count = ceil(row / max(WAY * min(ways) / speed, long))
    section = row / count
    near, far = ceil(section / short * (1.0 - 1e-12)), ceil(section / long * (1.0 - 1e-12))
    margin = REACH * section * speed
    share = min(1.0, AFTER * _share_near(bearing, ideal, margin))
    strike = float(0.5 * bearing.roller_mass * fall**2)
    found = Sections(count=count, near=near, far=far, share=share, margin=margin, strike=strike)
    return found if found.mean <= WORTH * near else None


def _spalls(bearing: Bearing):
    """Body, profile, (roller, middle and half, rad), radius, m, of every spall in every contact that it comes into."""
    surfaces = profiles(bearing)
    if surfaces is None:
        return
    bodies = (
        (ON_INNER_RING, surfaces.inner_ring, bearing.inner_raceway_radius),
        (ON_OUTER_RING, surfaces.outer_ring, bearing.outer_raceway_radius),
        (INSIDE, surfaces.rollers_inside, bearing.roller_radius),
        (OUTSIDE, surfaces.rollers_outside, bearing.roller_radius),
    )
    for body, profile, radius in bodies:
        if profile is not None:
            for spall in profile.spalls:
                yield body, profile, spall, radius


def _share_near(bearing: Bearing, ideal: Kinematics, margin: float) -> float:
    """Share of the time in which a contact is near an edge, of rollers that roll."""
    time = np.arange(INSTANTS)[:, None] / INSTANTS * (2.0 * pi / abs(ideal.cage))
    at = 2.0 * pi * np.arange(bearing.n_rollers) / bearing.n_rollers + ideal.cage * time
    contact = {
        ON_INNER_RING: at - ideal.shaft * time,
        ON_OUTER_RING: at,
        INSIDE: at + pi - ideal.roller * time,
        OUTSIDE: at - ideal.roller * time,
    }
    near = np.zeros(INSTANTS, dtype=bool)
    for body, _, (roller, middle, half), radius in _spalls(bearing):
        met = contact[body] if roller is None else contact[body][:, roller, None]
        away = np.abs(np.mod(met - middle + pi, 2.0 * pi) - pi)
        near |= np.any(away < half + margin / radius, axis=1)
    return float(near.mean())


def time_along_a_wave(bearing: Bearing, ideal: Kinematics) -> float:
    """Time in which contacts roll over the shortest knot that all but spalls need, s."""
    surfaces, speed = profiles(bearing), abs(ideal.cage) * bearing.outer_raceway_radius
    return inf if surfaces is None or speed == 0.0 else surfaces.shortest_of_waves / speed


def paces_of(plan: "ReducedPlan", drive: ReducedDrive) -> tuple[tuple[ReducedDrive, ...], Paces | None]:
    """The drive at every pace of a plan, and when which; None: there is one."""
    found, long, bearing = plan.sections, plan.long_step, plan.model.bearing
    if found is None:
        return (drive,), None
    where = [(body, 0 if spall[0] is None else spall[0]) for body, _, spall, _ in _spalls(bearing)]
    arcs = [
        (middle, np.cos(min(half + found.margin / radius, pi))) for _, _, (_, middle, half), radius in _spalls(bearing)
    ]
    smooth = profiles(bearing).shortest_of_waves == inf
    sensor, steps = plan.operation.mounting.sensor, (drive.dt, long)
    none, outward = np.zeros((2, 2, 3)), bearing.pitch_radius * kinematics(bearing, plan.operation.fastest).cage ** 2
    steady = STEADY * bearing.n_rollers * bearing.roller_mass * outward**2
    paces = Paces(
        counts=np.array([found.near, found.far], dtype=np.intp),
        sections=found.count,
        now=np.zeros(1, dtype=np.intp),
        made=np.zeros(2, dtype=np.intp),
        where=np.array(where, dtype=np.intp),
        arcs=np.array(arcs),
        stiffness=float(2.0 * bearing.roller_mass / plan.critical_time_step**2),
        outward=float(outward),
        calm=float(steady + 12.0 * CALM * (plan.static_energy + found.strike) / long**2),
        smooth=smooth,
        step=none if sensor is None else np.array([sensor.step(dt) for dt in steps]),
        half_step=none if sensor is None else np.array([sensor.step(0.5 * dt) for dt in steps]),
    )
    return (drive, drive._replace(dt=float(long), looks=not smooth)), paces
