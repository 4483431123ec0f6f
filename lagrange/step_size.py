"""How long steps and sampling intervals may be: from the stiffest mode, a cage's impacts and profiles of surfaces."""

from math import inf, pi, sqrt

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.laws import contact_laws
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics_met
from lagrange.surface.deviation import profiles
from lagrange.surface.faults import Waviness, own_radius

INTERVALS = (1e-5, 8e-6, 5e-6, 4e-6, 2.5e-6, 2e-6, 1.6e-6, 1.25e-6, 1e-6, 5e-7, 2e-7, 1e-7)  # s; rates of whole kHz
SAMPLES_OF_ROLLERS = 3.0  # a period: more than Nyquist's two, because their stiffness is estimated
SAMPLES_OF_GRADUAL = 2.0  # a period of rollers without clearance: those that fold are followed as if struck
LIGHT = 0.05  # of the largest load: rollers without clearance vibrate where they take up theirs
SAMPLES_OF_THE_HUB = 5.0  # a period: a stencil of order 6 then reads 4 % of its acceleration too low
CLEARANCE = 1e-9  # of a roller's radius: less is the rounding of diameters


def fitting_interval(bearing: Bearing, operation: Operation, longest: float) -> float:
    """Interval between samples, s, at which neither the hub nor struck rollers vibrate beyond the Nyquist frequency.

    Rollers are struck that come through a clearance or a fault of a surface, and then vibrate between their two
    contacts. In a perfect bearing without clearance they take up their load gradually and vibrate less, which shows
    where it is folded: where the longest interval has no two samples a period of a lightly loaded roller.

    bearing : with its faults, without films
    longest : s, above which a warning of the bearing's faults would follow

    Errors: Contacts are taken as stiff as under five times a roller's mean load: frequencies are right within some 20
    %. The rings' own modes, at 150 kHz and more, are not followed.
    """
    rate = SAMPLES_OF_THE_HUB * hub_frequency(bearing, operation)
    struck = bearing.faults or bearing.radial_clearance > CLEARANCE * bearing.roller_radius
    if struck or SAMPLES_OF_GRADUAL * INTERVALS[0] * roller_frequency(bearing, operation, LIGHT) > 1.0:
        rate = max(rate, SAMPLES_OF_ROLLERS * roller_frequency(bearing, operation))
    fitting = (interval for interval in INTERVALS if interval * rate <= 1.0 and interval <= longest)
    return next(fitting, INTERVALS[-1])


def wave_interval(bearing: Bearing, operation: Operation) -> float:
    """The longest interval between samples, s, that shows contacts pass over waves; infinite without any."""
    speed = contact_speed(bearing, operation)
    waves = [pi * own_radius(bearing, f) / f.order for f in bearing.faults if isinstance(f, Waviness)]
    return min(waves) / speed if waves and speed > 0.0 else inf


def roller_frequency(bearing: Bearing, operation: Operation, share: float = 1.0) -> float:
    """Of a roller between its two contacts, Hz, where it bears this share of the largest load."""
    return sqrt(sum(_stiffness(bearing, operation, share)) / bearing.roller_mass) / (2.0 * pi)


def hub_frequency(bearing: Bearing, operation: Operation) -> float:
    """Of the inner ring and its shaft on the contacts of the load zone: a half circle, with preload a whole one, Hz."""
    inner, outer = _stiffness(bearing, operation)
    preloaded = bearing.radial_clearance < -CLEARANCE * bearing.roller_radius
    share = 0.5 if preloaded else 0.25  # of all rollers' stiffness, along one direction
    in_series = inner * outer / (inner + outer) if inner + outer > 0.0 else 0.0  # soft laws without any load
    return sqrt(share * bearing.n_rollers * in_series / operation.inner_mass) / (2.0 * pi)


def _stiffness(bearing, operation, share=1.0):
    """Of the inner and the outer contact under this share of the largest load, about five times the mean one, N/m."""
    cage = np.abs(kinematics_met(bearing, operation).cage).max()
    force = share * 5.0 * (operation.heaviest + operation.inner_mass * operation.gravity) / bearing.n_rollers
    force += bearing.roller_mass * (bearing.pitch_radius * cage**2 + operation.gravity)
    laws = contact_laws("hertz" if isinstance(bearing, BallBearing) else "johnson", bearing)
    return _slopes(laws, force, force)


def _slopes(laws, *forces):
    """Stiffness of the inner and the outer contact under forces, N, N/m."""
    return [float(law.slope(law.approach(force))) for law, force in zip(laws, forces, strict=True)]


LEAP = 0.5  # of 1/ω of the stiffest mode, by forces a little ahead: its frequency is 0.01 % off
KNOTS_PER_LEAP = 0.25  # of a surface's profile under a rolling contact
CAGE_STEP = 0.8  # of 1/ω of a cage with all contacts closed
OVERLOAD = 2.0  # the stiffest mode is estimated at this many times the largest static force
TOGETHER = 2.0  # a spring between two bodies counts so often on each
SMALLEST_FORCE = 1e-3  # N, for the frequency of an unloaded element


def fastest_mode(problem: Problem, inner_force: float, outer_force: float) -> float:
    """Angular frequency, rad/s, of an element between contacts that carry these forces, N, or of all together."""
    stiffness = _slopes(problem.laws, max(inner_force, SMALLEST_FORCE), max(outer_force, SMALLEST_FORCE))
    pocket = 0.0 if problem.free_cage is None else TOGETHER * problem.free_cage.stiffness
    alone = sqrt((sum(stiffness) + pocket) / problem.bearing.roller_mass)
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


def fastest_in_machine(bearing: Bearing, operation: Operation, inner: float, outer: float) -> float:
    """Angular frequency, rad/s, of the fastest motion of hub, elements and housing along an axis.

    All contacts are closed and as stiff as these, N/m; 0 where the bearing alone holds the hub, the ground its ring.
    """
    shaft, housing = operation.mounting.shaft, operation.mounting.housing
    if shaft is None and housing is None:
        return 0.0
    share = 0.5 * bearing.n_rollers  # of cos² around the bearing
    of_ring = inf if housing is None else housing.mass + bearing.outer_ring_mass  # held by the ground
    masses = np.array([operation.inner_mass, share * bearing.roller_mass, of_ring])
    a, b = share * inner, share * outer
    stiffness = np.array([[a, -a, 0.0], [-a, a + b, -b], [0.0, -b, b]])
    stiffness[0, 0] += 0.0 if shaft is None else shaft.stiffness
    stiffness[2, 2] += 0.0 if housing is None else housing.stiffness
    return sqrt(float(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(masses, masses))).max()))


def critical_time_step(problem: Problem, *largest: float) -> float:
    """Step, s, at which leapfrog becomes unstable under the largest inner and outer force, N; default: expected."""
    return 2.0 / max(fastest_mode(problem, *(largest or 2 * [expected_force(problem)])), fastest_of_cage(problem))


def longest_step(problem: Problem, spalls: bool = True) -> float:
    """The longest step of leapfrog, s, that resolves the stiffest mode, a cage's impacts and profiles of surfaces.

    `spalls` : whether a contact is near one's edges.
    """
    cage, surfaces, force = fastest_of_cage(problem), profiles(problem.bearing), expected_force(problem)
    speed = contact_speed(problem.bearing, problem.operation)
    longest = min(LEAP / fastest_mode(problem, force, force), inf if cage == 0.0 else CAGE_STEP / cage)
    if surfaces is not None and speed > 0.0:
        shortest = surfaces.shortest if spalls else surfaces.shortest_of_waves
        longest = min(longest, KNOTS_PER_LEAP * shortest / speed)
    housing, bearing = problem.operation.mounting.housing, problem.bearing
    if housing is not None and problem.damping.acts:  # it feels them after all else, each alone
        law = problem.laws.outer
        coefficient = float(problem.damping.coefficient(force, law.slope(law.approach(force))))
        longest = min(longest, 2.0 * (housing.mass + bearing.outer_ring_mass) / (bearing.n_rollers * coefficient))
    return longest


def expected_force(problem: Problem) -> float:
    """The largest contact force to be expected, N."""
    bearing, operation = problem.bearing, problem.operation
    weight = operation.heaviest + operation.inner_mass * operation.gravity
    spin = bearing.roller_mass * bearing.pitch_radius * np.abs(kinematics_met(bearing, operation).cage).max() ** 2
    squeeze = float(problem.laws.inner.force(max(-0.5 * bearing.radial_clearance, 0.0)))  # of preload
    return OVERLOAD * (squeeze + spin + bearing.roller_mass * operation.gravity + 5.0 * weight / bearing.n_rollers)


def contact_speed(bearing: Bearing, operation: Operation) -> float:
    """Of contacts along the surfaces at the highest speed of the run, m/s."""
    ideal = kinematics_met(bearing, operation)
    return float(np.abs(ideal.roller - ideal.cage).max()) * bearing.roller_radius
