"""How long steps and sampling intervals may be: from the stiffest mode, and from when contacts are near faults."""

from dataclasses import dataclass, replace
from math import ceil, inf, pi, sqrt

import numpy as np

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.contact.raceway_laws import contact_laws
from lagrange.first_state import Problem
from lagrange.kinematics import kinematics, turned
from lagrange.surface.deviation import Profile, Turns, profiles
from lagrange.surface.faults import Waviness, own_radius

INTERVALS = (1e-5, 8e-6, 5e-6, 4e-6, 2.5e-6, 2e-6, 1.6e-6, 1.25e-6, 1e-6, 5e-7, 2e-7, 1e-7)  # s; rates of whole kHz
SAMPLES_OF_ROLLERS = 3.0  # a period: more than Nyquist's two, because their stiffness is estimated
SAMPLES_OF_THE_HUB = 5.0  # a period: a stencil of order 6 then reads 4 % of its acceleration too low
CLEARANCE = 1e-9  # of a roller's radius: less is the rounding of diameters


def fitting_interval(bearing: Bearing, operation: Operation, longest: float) -> float:
    """Interval between samples, s, at which neither the hub nor struck rollers vibrate beyond the Nyquist frequency.

    Rollers are struck that come through a clearance or a fault of a surface, and then vibrate between their two
    contacts. In a perfect bearing without clearance they touch as they come into the load zone, and hardly vibrate.

    Parameters
    ----------
    bearing : with its faults, without films
    longest : s, above which a warning of the bearing's faults would follow

    Errors
    ------
    Contacts are taken as stiff as under five times a roller's mean load: frequencies are right within some 20 %. The
    rings' own modes, at 150 kHz and more, are not followed.
    """
    rate = SAMPLES_OF_THE_HUB * hub_frequency(bearing, operation)
    if bearing.faults or bearing.radial_clearance > CLEARANCE * bearing.roller_radius:
        rate = max(rate, SAMPLES_OF_ROLLERS * roller_frequency(bearing, operation))
    fitting = (interval for interval in INTERVALS if interval * rate <= 1.0 and interval <= longest)
    return next(fitting, INTERVALS[-1])


def wave_interval(bearing: Bearing, operation: Operation) -> float:
    """The longest interval between samples, s, that shows contacts pass over waves; infinite without any."""
    ideal = kinematics(bearing, operation.fastest)
    speed = abs(ideal.roller - ideal.cage) * bearing.roller_radius
    waves = [pi * own_radius(bearing, f) / f.order for f in bearing.faults if isinstance(f, Waviness)]
    return min(waves) / speed if waves and speed > 0.0 else inf


def roller_frequency(bearing: Bearing, operation: Operation) -> float:
    """Of a roller between its two contacts where the load is largest, Hz."""
    return sqrt(sum(_stiffness(bearing, operation)) / bearing.roller_mass) / (2.0 * pi)


def hub_frequency(bearing: Bearing, operation: Operation) -> float:
    """Of the inner ring and its shaft on the contacts of the load zone: a half circle, with preload a whole one, Hz."""
    inner, outer = _stiffness(bearing, operation)
    preloaded = bearing.radial_clearance < -CLEARANCE * bearing.roller_radius
    share = 0.5 if preloaded else 0.25  # of all rollers' stiffness, along one direction
    in_series = inner * outer / (inner + outer) if inner + outer > 0.0 else 0.0  # soft laws without any load
    return sqrt(share * bearing.n_rollers * in_series / operation.inner_mass) / (2.0 * pi)


def _stiffness(bearing: Bearing, operation: Operation) -> tuple[float, float]:
    """Of the inner and the outer contact of the roller with the largest load, about five times the mean one, N/m."""
    cage = kinematics(bearing, operation.fastest).cage
    force = 5.0 * (operation.heaviest + operation.inner_mass * operation.gravity) / bearing.n_rollers
    force += bearing.roller_mass * (bearing.pitch_radius * cage**2 + operation.gravity)
    laws = contact_laws("hertz" if isinstance(bearing, BallBearing) else "johnson", bearing)
    inner, outer = (float(law.slope(law.approach(force))) for law in laws)
    return inner, outer


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


LEAP = 0.5  # of 1/ω of the stiffest mode, by forces a little ahead: its frequency is 0.01 % off
KNOTS_PER_LEAP = 0.25  # of a surface's profile under a rolling contact


def leapfrog_limit(problem: Problem, *largest: float) -> float:
    """Step, s, at which leapfrog becomes unstable under the largest inner and outer force, N; default: expected."""
    return 2.0 / max(fastest_mode(problem, *(largest or 2 * [_expected_force(problem)])), fastest_of_cage(problem))


def longest_step(problem: Problem) -> float:
    """The longest step of leapfrog, s, that resolves the stiffest mode, a cage's impacts and profiles of surfaces."""
    cage, surfaces, speed = fastest_of_cage(problem), profiles(problem.bearing), contact_speed(problem)
    longest = min(LEAP / _stiffest(problem), inf if cage == 0.0 else CAGE_STEP / cage)
    if surfaces is not None and speed > 0.0:
        longest = min(longest, KNOTS_PER_LEAP * surfaces.shortest / speed)
    housing, bearing = problem.operation.mounting.housing, problem.bearing
    if housing is not None and problem.damping.acts:  # it feels them after all else, each alone
        force, law = _expected_force(problem), problem.laws.outer
        coefficient = float(problem.damping.coefficient(force, law.slope(law.approach(force))))
        longest = min(longest, 2.0 * (housing.mass + bearing.outer_ring_mass) / (bearing.n_rollers * coefficient))
    return longest


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
