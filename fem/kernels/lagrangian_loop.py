"""The time loop of the Lagrangian model: compositions and leapfrog, on lanes."""

from math import pi, sin

from fem.kernels.drive import FORCE_X, FORCE_Y, RATE_X, RATE_Y, follow, share_at
from fem.kernels.jit import kernel, part, verb
from fem.kernels.lagrangian_cage import drift_cage, kick_cage, meet_cage, rub_cage, write_cage
from fem.kernels.lagrangian_forces import accelerate, damp, speeds_of
from fem.kernels.lagrangian_housing import (
    drift_housing,
    kick_housing,
    place_of_ring,
    push_damped,
    sense,
    slow,
    velocity_of_ring,
)
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, fma, splat
from fem.kernels.state import Course

HELD, RAMPED, DISSIPATED, DASHPOTS, POWER = range(5)  # of `IdealMotion.works`


@kernel(nogil=True)
def advance_lagrangian(motion, bearing, dampers, clock, rows):
    """Fill rows with the samples after those that are done, and leave the motion at the last.

    By the clock's scheme, by leapfrog where it has none: with dampers, the shaft's dashpots, a cage.

    Returns the number of rows filled: fewer where the hub's place is no number any more.
    """
    for row in range(rows.works.shape[0]):
        first = (clock.done + row - 1) * clock.sections
        for at in range(0, motion.force.size, WIDTH):  # a sample's bits do not depend on where the last call ended
            store(motion.force, at, splat(0.0))
        for section in range(first - (first == 0), first + clock.sections):
            # a step of no length, before the first section, finds the accelerations at the start
            near = 1 if section < 0 else clock.near[row, section - first]
            count = 1 if section < 0 else clock.counts[near]
            length = 0.0 if section < 0 else clock.lengths[near]
            _look(bearing.surfaces, near)
            for number in range(section * count, (section + 1) * count):
                _step(clock.kicks, motion, bearing, dampers, clock, near, number, length)
        for k in range(2):
            if not motion.hub[0, k] - motion.hub[0, k] == 0.0:
                return row
        _write(motion, row, rows)
    return rows.works.shape[0]


@part
def _write(motion, row, rows):
    for i in range(2):
        for k in range(2):
            rows.hub[row, i, k] = motion.hub[i, k]
    size = 2 * motion.elements[0].size
    for at in range(0, size, WIDTH):
        store(rows.elements, row * size + at, load(motion.elements, at))
    _write_housing(motion.housing, row, rows)
    for i in range(POWER):
        rows.works[row, i] = motion.works[i]
    write_cage(motion.cage, row, rows.cage)


@part
def _write_housing(housing, row, rows):
    if housing is not None:
        for i in range(2):
            rows.sensor[row, i] = housing.sensor[i]
            for k in range(2):
                rows.housing[row, i, k] = housing.motion[i, k]


@part
def _look(surfaces, near):
    """Let contacts look for what surfaces lack, or not."""
    if surfaces is not None:
        surfaces.near[0] = near


@part
def _step(kicks, motion, bearing, dampers, clock, near, number, length):
    if kicks is None:
        _damped(motion, bearing, dampers, near, number, length)
    else:
        _composed(motion, bearing, clock.kicks, clock.drifts, near, number, length)


@part
def _composed(motion, bearing, kicks, drifts, near, number, length):
    """Kicks and drifts of a symplectic scheme."""
    way, n, before = 0.0, drifts.size, velocity_of_ring(motion.housing)
    for stage in range(n):
        _kick(motion, bearing, length * kicks[stage], length * (number + way))
        _drift(motion, length * drifts[stage])
        way += drifts[stage]
        motion.works[POWER] = accelerate(motion, bearing, None, length * (number + way))
    _kick(motion, bearing, length * kicks[n], length * (number + way))
    sense(motion.housing, before, near, length)


@part
def _damped(motion, bearing, dampers, near, number, length):
    """Drift, kick, damp, kick, drift; second order."""
    half, time, works = 0.5 * length, length * (number + 0.5), motion.works
    before = velocity_of_ring(motion.housing)
    _drift(motion, half)
    drift_cage(motion.cage, half)
    works[POWER] = accelerate(motion, bearing, dampers, time)
    _, shaft, spin = speeds_of(bearing.course, bearing)
    meet_cage(motion.cage, shaft, spin, length)
    _kick(motion, bearing, half, time)
    kick_cage(motion.cage, motion, bearing, length)
    _slow(motion, bearing, half)
    _damp_contacts(dampers, motion, bearing, length)
    _kick(motion, bearing, half, time)
    _slow(motion, bearing, half)
    works[HELD] += rub_cage(motion.cage, motion, bearing, shaft, before, length)
    sense(motion.housing, before, near, length)
    _drift(motion, half)
    drift_cage(motion.cage, half)


@part
def _damp_contacts(dampers, motion, bearing, length):
    """The dampers' flow by the midpoint rule at frozen positions."""
    if dampers is not None:
        for ahead in (0.0, 0.5 * length):
            loss, taken = damp(motion, bearing, dampers, ahead)
        _push(motion.hub, dampers.hub, length, motion.elements, dampers.elements)
        push_damped(motion.housing, length)
        motion.works[DISSIPATED] += length * loss
        motion.works[HELD] += length * taken


@part
def _slow(motion, bearing, seconds):
    """The dashpots of shaft and housing in a kick so long, just made."""
    lost, held = slow(bearing.springs, motion.housing, motion, bearing, seconds)
    motion.works[DASHPOTS] += lost
    motion.works[HELD] += held


@part
def _kick(motion, bearing, seconds, time):
    """Accelerate for so many seconds; the works go along."""
    hub, elements, works = motion.hub, motion.elements, motion.works
    _push(hub, hub[2], seconds, elements, elements[2])
    works[HELD] += seconds * works[POWER] + kick_housing(motion.housing, seconds)
    _change_load(bearing.course, bearing, motion, works, seconds, time)


@verb
def _change_load(course, bearing, motion, works, seconds, time):
    """The work of the load's change: minus its rate times the hub's place."""
    if time < bearing.ramp:
        works[RAMPED] += seconds * bearing.radial_load * _share_rate(bearing, time) * _hub_place(motion, 1)


@_change_load.of(Course)
def _change_all_load(course, bearing, motion, works, seconds, time):
    follow(course, time, 0.0)  # what was found last may be lost where a run goes on
    share, rate, now = share_at(bearing, time), 0.0, course.now
    if time < bearing.ramp:
        rate = _share_rate(bearing, time)
    power = (rate * now[FORCE_X] + share * now[RATE_X]) * _hub_place(motion, 0)
    power += (rate * now[FORCE_Y] + share * now[RATE_Y]) * _hub_place(motion, 1)
    works[RAMPED] -= seconds * power


@part
def _hub_place(motion, k):
    """Along an axis in the fixed frame, m."""
    return motion.hub[0, k] + place_of_ring(motion.housing, k)


@part
def _share_rate(bearing, time):
    """`lagrange.load_history.load_share_rate` while the load grows, 1/s."""
    return 0.5 * pi / bearing.ramp * sin(pi * time / bearing.ramp)


@part
def _push(hub, of_hub, seconds, elements, of_elements):
    """Change velocities by accelerations, (2,) and (1 or 2, columns)."""
    for k in range(2):
        hub[1, k] += seconds * of_hub[k]
    size = of_elements.size
    for at in range(0, size, WIDTH):
        store(elements, size + at, fma(seconds, load(of_elements, at), load(elements, size + at)))


@part
def _drift(motion, seconds):
    hub, elements = motion.hub, motion.elements
    for k in range(2):
        hub[0, k] += seconds * hub[1, k]
    drift_housing(motion.housing, seconds)
    size = elements[0].size
    for at in range(0, size, WIDTH):
        store(elements, at, fma(seconds, load(elements, size + at), load(elements, at)))
