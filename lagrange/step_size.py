"""How long a time step may be: from the stiffest mode, an element between its contacts."""

from dataclasses import dataclass, replace
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
# of a surface's profile under a rolling contact, with dampers; energy over spalls is off by their square
KNOTS_PER_STEP, KNOTS_PER_UNDAMPED_STEP = 0.25, 0.08
CAGE_STEP = 0.8  # of 1/ω of a cage with all contacts closed
TOGETHER = 2.0  # a spring between two bodies counts so often on each
SMALLEST_FORCE = 1e-3  # N, for the frequency of an unloaded element


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Equal steps in each section of a sample.

    Where sections are looked at, those without a contact near a fault are on perfect circles: their steps are cheap
    and, where dampers end what faults begin, longer. Undamped contacts rattle after a fault as they do over it.
    """

    sections: int  # of a sample
    near: int  # steps of a section with a contact near a fault, or of every one that is not looked at
    far: int  # of another
    looks: bool
    leaps: bool  # whether undamped steps are so short that a scheme of second order is better for its costs

    @classmethod
    def equal(cls, count: int) -> "Steps":
        """So many from sample to sample, by the scheme of fourth order where nothing is damped."""
        return cls(sections=1, near=count, far=count, looks=False, leaps=False)

    @property
    def per_sample(self) -> int:
        """At most."""
        return self.sections * self.near

    @property
    def counts(self) -> tuple[int, int]:
        """Of steps in a section far from faults, and near."""
        return self.far, self.near

    def finer(self, times: int) -> "Steps":
        """So many times as many."""
        return replace(self, near=times * self.near, far=times * self.far)


def steps_of(problem: Problem, interval: float, time_step: float | None = None) -> Steps:
    """Steps from sample to sample, `interval` s, before any refinement; `time_step`: s, at most."""
    smooth, passage, omega = _longest_step(problem), _passage(problem), _stiffest(problem)
    if time_step is not None:
        smooth = min(smooth, time_step)
    surfaces = profiles(problem.bearing)
    looks = problem.angles == "kinematic" and surfaces is not None and surfaces.leave_perfect_arcs
    sections = _count(interval, STEP / omega) if looks else 1
    section = interval / sections
    near = _count(section, min(smooth, passage))
    return Steps(
        sections=sections,
        near=near,
        far=_count(section, smooth) if looks and problem.is_damped else near,
        looks=looks,
        leaps=not problem.is_damped and passage < min(smooth, DAMPED_STEP / omega),
    )


def _count(whole: float, longest: float) -> int:
    """Equal steps of a time, s."""
    return max(1, ceil(whole / longest * (1.0 - 1e-12)))


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


def _stiffest(problem: Problem) -> float:
    """Angular frequency, rad/s, of the stiffest mode under the largest force to be expected."""
    force = _expected_force(problem)
    return fastest_mode(problem, force, force)


def _longest_step(problem: Problem) -> float:
    """On perfect circles, s."""
    force, omega, cage = _expected_force(problem), _stiffest(problem), fastest_of_cage(problem)
    longest = inf if cage == 0.0 else CAGE_STEP / cage
    if not problem.is_damped:
        return min(STEP / omega, longest)
    if not problem.damping.acts:  # dashpots of shaft and housing are exact at any step
        return min(DAMPED_STEP / omega, longest)
    dampers = sum(float(problem.damping.coefficient(force, law.slope(law.approach(force)))) for law in problem.laws)
    return min(DAMPED_STEP / omega, LARGEST_DAMPING * problem.bearing.roller_mass / dampers, longest)


def _passage(problem: Problem) -> float:
    """Time in which contacts roll over as many knots of a profile as a step may, s."""
    surfaces, speed = profiles(problem.bearing), contact_speed(problem)
    if surfaces is None or speed == 0.0:
        return inf
    return (KNOTS_PER_STEP if problem.is_damped else KNOTS_PER_UNDAMPED_STEP) * surfaces.shortest / speed


def contact_speed(problem: Problem) -> float:
    """Of contacts along the surfaces at the highest speed of the run, m/s."""
    ideal = kinematics(problem.bearing, problem.operation.fastest)
    return abs(ideal.roller - ideal.cage) * problem.bearing.roller_radius
