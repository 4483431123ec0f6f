"""Surfaces that are not perfect circles, for the time loops."""

from math import inf
from typing import Any

import numpy as np

from fem.kernels.lanes import WIDTH
from fem.kernels.state import RingProfile, RollerProfiles
from fem.solver.cache_lines import at_line
from lagrange import Bearing, Kinematics
from lagrange.profile import Profile, profiles


def raceway_profiles(bearing: Bearing, columns: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the inner and the outer `Raceway` know of surfaces that are not perfect.

    Both raceways have a profile where one has, and so one type and one code.
    """
    surfaces = profiles(bearing)
    if surfaces is None:
        nothing = {"profile": None, "roller_profiles": None}
        return nothing, nothing
    rings, rollers = (surfaces.inner_ring, surfaces.outer_ring), (surfaces.rollers_inside, surfaces.rollers_outside)
    on_rings, on_rollers = (None, None), (None, None)
    if any(ring is not None for ring in rings):
        on_rings = tuple(_ring_profile(ring) for ring in rings)
    if all(roller is not None for roller in rollers):
        on_rollers = tuple(_roller_profiles(roller, columns) for roller in rollers)
    return tuple(
        {"profile": ring, "roller_profiles": roller} for ring, roller in zip(on_rings, on_rollers, strict=True)
    )


def time_along_a_knot(bearing: Bearing, ideal: Kinematics) -> float:
    """Time in which contacts roll over the shortest knot of a profile, s; infinite on perfect circles, or standing."""
    surfaces = profiles(bearing)
    speed = abs(ideal.cage) * bearing.outer_raceway_radius  # of contacts along every surface
    return inf if surfaces is None or speed == 0.0 else surfaces.shortest / speed


def _ring_profile(profile: Profile | None) -> RingProfile:
    sinkage = np.zeros(WIDTH) if profile is None else profile.coefficients[0]
    soft = profile is not None and profile.compliance is not None
    return RingProfile(
        sinkage=at_line(sinkage), compliance=at_line(profile.compliance[0] if soft else np.zeros_like(sinkage))
    )


def _roller_profiles(profile: Profile, columns: int) -> RollerProfiles:
    first = np.zeros(columns, dtype=np.int64)
    first[: profile.row.size] = profile.row * profile.coefficients.shape[1]
    soft = np.zeros_like(profile.coefficients) if profile.compliance is None else profile.compliance
    return RollerProfiles(sinkage=at_line(profile.coefficients), compliance=at_line(soft), first=at_line(first))
