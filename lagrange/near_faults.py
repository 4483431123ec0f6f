"""When contacts are near faults: elsewhere circles are perfect, and steps may be longer."""

from math import pi

import numpy as np

from lagrange.kinematics import turned
from lagrange.problem import Problem
from lagrange.profile import Profile, Turns, profiles
from lagrange.step_size import contact_speed

GIVE = 0.05  # of a roller's radius: further than twice the clearance and this no elastic contact lets a hub go


def near_faults(problem: Problem, first: int, count: int, section: float) -> np.ndarray:
    """Whether a contact comes near a fault in each of so many sections of time from the first on, (count,).

    Elements are held at kinematic angles; `section` in s. A hub that is out of the middle sees them under other angles:
    that is in the margin, with the way of contacts in half a section.
    """
    bearing, operation, surfaces = problem.bearing, problem.operation, profiles(problem.bearing)
    found = np.zeros(count, dtype=bool)
    if surfaces is None:
        return found
    time = (first + np.arange(count) + 0.5) * section
    turns = Turns.rolling(bearing, operation, time[:, None])
    spacing = 2.0 * pi * np.arange(bearing.n_rollers) / bearing.n_rollers
    at = operation.first_roller_angle + spacing + turned(bearing, operation, time[:, None]).cage
    margin = 0.5 * section * contact_speed(problem) + GIVE * bearing.roller_radius + surfaces.deepest
    margin += 2.0 * abs(bearing.radial_clearance)
    met = (
        (surfaces.inner_ring, at - turns.inner_ring, bearing.inner_raceway_radius),
        (surfaces.rollers_inside, at + pi - turns.rollers, bearing.roller_radius),
        (surfaces.outer_ring, at, bearing.outer_raceway_radius),
        (surfaces.rollers_outside, at - turns.rollers, bearing.roller_radius),
    )
    for profile, angle, radius in met:
        if profile is not None:
            found |= _near(profile, angle, margin / radius)
    return found


def _near(profile: Profile, angle: np.ndarray, margin: float) -> np.ndarray:
    """Whether any contact at angles along a body, (n_times, n_rollers), rad, is within a margin, rad, of an arc."""
    found = np.zeros(len(angle), dtype=bool)
    for row, middle, half in profile.arcs:
        met = angle[:, profile.row == row]
        away = np.abs(np.mod(met - middle + pi, 2.0 * pi) - pi)
        found |= np.any(away < half + margin, axis=1)
    return found
