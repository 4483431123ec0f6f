"""How long a time step may be: from the stiffest mode, an element between its contacts."""

from math import ceil, inf, sqrt

import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.kinematics import kinematics
from lagrange.problem import Problem
from lagrange.profile import profiles

STEP = 2.0  # of 1/ω of the stiffest mode: its frequency then is 0.05 % off, the hub's 1e-6
DAMPED_STEP = 0.3
OVERLOAD = 2.0  # the stiffest mode is estimated at this many times the largest static force
LIMIT, DAMPED_LIMIT = 3.05, 2.0  # ω·step at which the six-stage scheme and the leapfrog become unstable
STABLE, DAMPED_STABLE = 2.8, 1.0  # ω·step that they may reach
LARGEST_DAMPING = 0.5  # of a step times the rate of the damper on an element
KNOTS_PER_STEP = 0.25  # of a surface's profile under a rolling contact; with one, energy over spalls is up to 4 % off
CAGE_STEP = 0.8  # of 1/ω of a cage with all contacts closed
TOGETHER = 2.0  # a spring between two bodies counts so often on each
SMALLEST_FORCE = 1e-3  # N, for the frequency of an unloaded element


def steps_per_sample(problem: Problem, interval: float, time_step: float | None = None) -> int:
    """Equal steps from sample to sample, `interval` s, before any refinement; `time_step`: s, at most."""
    longest = _longest_step(problem)
    if time_step is not None:
        longest = min(longest, time_step)
    return max(1, ceil(interval / longest * (1.0 - 1e-12)))


def fastest_mode(problem: Problem, inner_force: float, outer_force: float) -> float:
    """Angular frequency, rad/s, of an element between contacts that carry these forces, N, or of all together."""
    stiffness = [
        float(law.slope(law.approach(max(force, SMALLEST_FORCE))))
        for law, force in zip(problem.laws, (inner_force, outer_force), strict=True)
    ]
    alone = (sum(stiffness) / problem.bearing.roller_mass) ** 0.5
    alone = sqrt(alone**2 + _of_pocket(problem) ** 2)
    return max(alone, fastest_in_machine(problem.bearing, problem.operation, *stiffness))


def fastest_of_cage(problem: Problem) -> float:
    """Angular frequency, rad/s, of a free cage with all its contacts closed, at most; 0 without one."""
    cage, bearing = problem.free_cage, problem.bearing
    if cage is None:
        return 0.0
    light = 1.0 / cage.mass
    pockets = bearing.n_rollers * (light + bearing.pitch_radius**2 / cage.inertia)
    of_cage = TOGETHER * cage.stiffness * (pockets + (0.0 if cage.guidance == "rollers" else light))
    guiding, housing = inf, problem.operation.mounting.housing
    if cage.guidance == "inner_ring":
        guiding = problem.operation.inner_mass
    elif cage.guidance == "outer_ring" and housing is not None:
        guiding = housing.mass + bearing.outer_ring_mass
    return sqrt(max(of_cage, TOGETHER * cage.stiffness / guiding))


def _of_pocket(problem: Problem) -> float:
    """Angular frequency, rad/s, that a closed pocket of a free cage adds to an element's, in squares."""
    cage = problem.free_cage
    return 0.0 if cage is None else sqrt(TOGETHER * cage.stiffness / problem.bearing.roller_mass)


def fastest_in_machine(bearing: Bearing, operation: Operation, inner: float, outer: float) -> float:
    """Angular frequency, rad/s, of the fastest motion of hub, elements and housing along an axis.

    All contacts are closed and as stiff as these, N/m; 0 where nothing but the bearing holds the hub, and the ground
    the outer ring.
    """
    shaft, housing = operation.mounting.shaft, operation.mounting.housing
    if shaft is None and housing is None:
        return 0.0
    share = 0.5 * bearing.n_rollers  # of cos² around the bearing
    masses = np.array([operation.inner_mass, share * bearing.roller_mass, bearing.outer_ring_mass])
    a, b = share * inner, share * outer
    stiffness = np.array([[a, -a, 0.0], [-a, a + b, -b], [0.0, -b, b]])
    stiffness[0, 0] += 0.0 if shaft is None else shaft.stiffness
    if housing is None:
        masses, stiffness = masses[:2], stiffness[:2, :2]
    else:
        masses[2] += housing.mass
        stiffness[2, 2] += housing.stiffness
    return sqrt(float(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(masses, masses))).max()))


def critical_time_step(problem: Problem, *largest: float) -> float:
    """Step, s, at which the scheme becomes unstable under the largest inner and outer force, N; default: expected."""
    limit = DAMPED_LIMIT if problem.is_damped else LIMIT
    return limit / max(fastest_mode(problem, *(largest or 2 * [_expected_force(problem)])), fastest_of_cage(problem))


def _expected_force(problem: Problem) -> float:
    """The largest contact force to be expected, N."""
    bearing, operation = problem.bearing, problem.operation
    weight = operation.heaviest + operation.inner_mass * operation.gravity
    spin = bearing.roller_mass * bearing.pitch_radius * kinematics(bearing, operation.fastest).cage ** 2
    squeeze = float(problem.laws.inner.force(max(-0.5 * bearing.radial_clearance, 0.0)))  # of preload
    return OVERLOAD * (squeeze + spin + bearing.roller_mass * operation.gravity + 5.0 * weight / bearing.n_rollers)


def _longest_step(problem: Problem) -> float:
    force = _expected_force(problem)
    omega = fastest_mode(problem, force, force)
    passage, cage = _passage(problem), fastest_of_cage(problem)
    if cage > 0.0:
        passage = min(passage, CAGE_STEP / cage)
    if not problem.is_damped:
        return min(STEP / omega, passage)
    if not problem.damping.acts:  # dashpots of shaft and housing are exact at any step
        return min(DAMPED_STEP / omega, passage)
    dampers = sum(float(problem.damping.coefficient(force, law.slope(law.approach(force)))) for law in problem.laws)
    return min(DAMPED_STEP / omega, LARGEST_DAMPING * problem.bearing.roller_mass / dampers, passage)


def _passage(problem: Problem) -> float:
    """Time in which contacts roll over as many knots of a profile as a step may, s."""
    surfaces, ideal = profiles(problem.bearing), kinematics(problem.bearing, problem.operation.fastest)
    speed = abs(ideal.roller - ideal.cage) * problem.bearing.roller_radius
    return inf if surfaces is None or speed == 0.0 else KNOTS_PER_STEP * surfaces.shortest / speed
