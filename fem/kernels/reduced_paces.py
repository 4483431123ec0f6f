"""Two step lengths of rigid bodies: short ones near edges of spalls and while strikes die away, long ones beyond.

Time is cut into sections of one length each. At the border of two sections the last section's steps make their kick;
where the next one has steps of another length, velocities half a step away and positions are then changed to those that
belong to the same motion. Leapfrog's positions y are those of the motion less dt²/12 of the acceleration (see
`reduced_kick`), and its velocities before and after a kick v ∓ dt/2 of the acceleration, so y changes by
(dt² − dt'²)/12·a and v by ± (dt − dt')/2·a. Every force of that kick has worked in half of the old step and is to work
in half of the new one: sums of works that count whole steps are corrected for that, and nothing else need know.

What leapfrog conserves is the energy less dt²/12 Σ m (a·a − v·ȧ), as of vibrations (1 − ω² dt²/6) of theirs. Steps grow
only where that is next to nothing; so it shows how far strikes have died away, too.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.drive import TURN, outer_of, turn_at, with_outer, with_side_load
from fem.kernels.housing_kernels import Housing, Resonator
from fem.kernels.isolated_contacts import Isolated
from fem.kernels.jit import part, verb
from fem.kernels.lanes import WIDTH
from fem.kernels.prescribed_rollers import hold_anew
from fem.kernels.reduced_contacts import wrap
from fem.kernels.reduced_damping import damping_power
from fem.kernels.reduced_housing import TWELFTH, ring_rates
from fem.kernels.reduced_radiation import QUIET, radiated_power
from fem.kernels.reduced_state import INNER, OUTER
from fem.kernels.tilted_contacts import Tilted
from fem.kernels.tilts import unrest_of_tilts

NEAR, FAR = 0, 1  # paces, and places of what belongs to one
ON_INNER_RING, ON_OUTER_RING, INSIDE, OUTSIDE = range(4)  # `Arcs`: of rings, and of rollers in either contact


class Paces(NamedTuple):
    """How long steps are, and when."""

    counts: np.ndarray  # (2,), whole, steps of a section
    sections: int  # of a row
    now: np.ndarray  # (1,), whole: the pace of the section in hand
    made: np.ndarray  # (2,), whole, steps of all sections before
    where: np.ndarray  # (n_arcs, 2), whole: on what edges are, and on which roller
    arcs: np.ndarray  # (n_arcs, 2): rad, middle of the edges; cosine of the angle within which contacts are near
    calm: float  # J/s², of Σ m (a·a − v·ȧ) at most, for longer steps
    stiffness: float  # N/m, of contacts, about
    outward: float  # m/s², of rollers that fly
    smooth: bool  # whether circles are perfect beyond edges
    step: np.ndarray  # (2, 2, 3), a sensor's: see `Resonator`
    half_step: np.ndarray  # (2, 2, 3)


@part
def sections_of(paces):
    """Of a row."""
    return 1 if paces is None else paces.sections


@part
def steps_of(paces, stride):
    """Of the section that begins, if its steps are as long as those before; `stride` : of a row."""
    return stride if paces is None else paces.counts[paces.now[0]]


@part
def drive_of(paces, drives):
    """The drive with the pace's step."""
    return drives[0] if paces is None else drives[paces.now[0]]


@part
def short_steps(paces, stride, section, inside):
    """Number of a step, in short ones."""
    if paces is None:
        return section * stride + inside
    return section * paces.counts[NEAR] + inside * paces.counts[NEAR] // paces.counts[paces.now[0]]


@part
def take_pace(paces, bodies, compliance, forces, drives, before, time, acting, given):
    """Choose the pace of a section whose first kick has just been made, and change to it.

    `acting` : load along x and against y, N; `given` : J, the drive's work before the kick.
    """
    if paces is not None:
        if time > 0.0:
            paces.made[paces.now[0]] += paces.counts[paces.now[0]]
        _take(paces, bodies, compliance, forces, drives, before, (time, acting, given))


@part(inlined=False)
def _take(paces, bodies, compliance, forces, drives, before, instant):
    now, time = paces.now[0], instant[0]
    drive = drives[now]
    pace = FAR
    outer_turn = with_outer(outer_of(drive.history), 0.0, 1.0, TURN)
    if _near_edges(paces, bodies, forces, turn_at(drive.history, drive, time), outer_turn):
        pace = NEAR
    elif now == NEAR and _struck(forces.radiation):
        pace = NEAR
    elif now == NEAR and not _unrest(paces, bodies, compliance, forces, before, drive.dt) < paces.calm:
        pace = NEAR
    if pace != now:
        _change(bodies, compliance, forces, before, drive, drives[pace], instant)
        _change_sensor(bodies.housing, paces, pace, drives[pace].dt)
        paces.now[0] = pace
        if pace == FAR and paces.smooth:
            _smooth(compliance, bodies, forces)


@part
def _struck(radiation):
    """Whether a contact has just closed; without waves that is not noted."""
    if radiation is None:
        return False
    return radiation.state[0] != QUIET


@part
def _near_edges(paces, bodies, forces, turn, outer_turn):
    for k in range(paces.where.shape[0]):
        body, middle, within = paces.where[k, 0], paces.arcs[k, 0], paces.arcs[k, 1]
        row = INNER if body == ON_INNER_RING or body == INSIDE else OUTER
        sign = -1.0 if body == INSIDE else 1.0
        first, end = 0, bodies.n
        if body == INSIDE or body == OUTSIDE:
            first, end = paces.where[k, 1], paces.where[k, 1] + 1
            middle += bodies.turn[first]
        elif body == ON_INNER_RING:
            middle += turn
        else:
            middle += outer_turn
        c, s = np.cos(middle), np.sin(middle)
        for j in range(first, end):
            if sign * (forces.normal[row, 0, j] * c + forces.normal[row, 1, j] * s) >= within:
                return True
    return False


@part
def _unrest(paces, bodies, compliance, forces, before, dt):
    """Σ m (a·a − v·ȧ), J/s²: of vibrations twice ω² times their energy, whatever their phase.

    Rollers that fly have that yet to come, by the speed at which they will strike the outer raceway.
    """
    next_ = ring_rates(bodies.housing)[1]
    hub, ring = before.hub_acceleration, before.ring_acceleration
    found = bodies.hub_mass * (hub[0] * hub[0] + hub[1] * hub[1])
    found += _mass_of(bodies.housing) * (ring[0] * ring[0] + ring[1] * ring[1])
    for j in range(bodies.n):
        ax, ay = before.acceleration[0, j], before.acceleration[1, j]
        found += bodies.mass * (ax * ax + ay * ay)
        vx, vy = bodies.velocity[0, j], bodies.velocity[1, j]
        outward = (vx - next_[0]) * forces.normal[OUTER, 0, j] + (vy - next_[1]) * forces.normal[OUTER, 1, j]
        inward = (bodies.hub_velocity[0] - vx) * forces.normal[INNER, 0, j]
        inward += (bodies.hub_velocity[1] - vy) * forces.normal[INNER, 1, j]
        found += paces.stiffness * (outward * outward + 2.0 * paces.outward * max(-forces.approach[OUTER, j], 0.0))
        for row in range(2):
            stiffness = forces.stiffness[row, j]
            if stiffness > 0.0:
                rate = _force_rate(compliance, forces, row, j, dt, inward if row == INNER else outward)
                found += rate * rate / stiffness
    return found + unrest_of_tilts(bodies.tilts, forces, bodies.n)


@verb
def _force_rate(compliance, forces, row, j, dt, closing):
    """Of a contact that closes at a speed, m/s; N/s."""
    return (forces.guess[row, forces.halo + j] - forces.force[row, j]) / dt


@_force_rate.of(Isolated)
def _force_rate_alone(compliance, forces, row, j, dt, closing):
    return forces.stiffness[row, j] * closing


@_force_rate.of(Tilted)
def _force_rate_tilted(compliance, forces, row, j, dt, closing):
    if compliance.between is None:
        return forces.stiffness[row, j] * closing
    return (forces.guess[row, forces.halo + j] - forces.force[row, j]) / dt


@verb
def _mass_of(housing):
    """Of a housing with its ring, kg."""
    return 0.0


@_mass_of.of(Housing)
def _mass_of_housing(housing):
    return housing.mass


@part
def _change(bodies, compliance, forces, before, old, new, instant):
    """Change from one step to another at the instant of a kick that the old one has made: time, load, drive's work."""
    dt, next_, sums, (time, acting, given) = old.dt, new.dt, old.sums, instant
    ratio = next_ / dt
    back, shift = 0.5 * (1.0 - ratio), TWELFTH * (dt * dt - next_ * next_)
    damped = damping_power(forces.dampers, bodies, forces, old)
    radiated = radiated_power(forces.radiation, bodies, forces)
    for k in range(2):
        moved = shift * before.hub_acceleration[k]
        bodies.hub[k] += moved
        moved += 0.5 * dt * before.hub_velocity[k]
        _turn_back(before.hub_velocity, bodies.hub_velocity, k, back)
        moved -= 0.5 * next_ * before.hub_velocity[k]  # what the new step's half will count beside
        if k == 0:
            sums[0] = with_side_load(old.history, sums[0], acting[0] * moved)
        else:
            sums[0] -= acting[1] * moved
    for k in range(2):
        for j in range(bodies.n):
            bodies.centre[k, j] += shift * before.acceleration[k, j]
            _turn_back(before.velocity[k], bodies.velocity[k], j, back)
    for j in range(bodies.n):
        _turn_back(before.spin, bodies.spin, j, back)
    _change_tilts(bodies.tilts, bodies.n, shift, back)
    hold_anew(bodies.prescribed, bodies, forces, new, time)
    sums[1] -= back * (sums[1] - given)
    _change_shaft(bodies.shaft, dt, next_, before.hub_velocity)
    _change_housing(bodies.housing, before, dt, next_, shift)
    _change_cage(bodies.cage, back, ratio)
    _change_forces(compliance, forces, bodies.n, ratio)
    _change_ahead(forces.ahead, bodies.n, ratio)
    damped = next_ * damping_power(forces.dampers, bodies, forces, new) - dt * damped
    _change_damping(forces.dampers, damped)
    radiated = next_ * radiated_power(forces.radiation, bodies, forces) - dt * radiated
    _change_radiation(forces.radiation, radiated)


@part
def _turn_back(before, after, k, back):
    gained = after[k] - before[k]
    before[k] += back * gained
    after[k] -= back * gained


@verb
def _change_forces(compliance, forces, n, ratio):
    """What is expected of forces in the next step; contacts that know nothing of each other expect nothing."""
    for row in range(2):
        for j in range(n):
            Q, at = forces.force[row, j], forces.halo + j
            forces.guess[row, at] = max(Q + ratio * (forces.guess[row, at] - Q), 0.0)
        wrap(forces.guess, row, n, forces.halo)
    for lane in range(WIDTH):
        forces.fastest[lane] *= ratio


@_change_forces.of(Isolated)
def _change_no_forces(compliance, forces, n, ratio):
    pass


@_change_forces.of(Tilted)
def _change_tilted_forces(compliance, forces, n, ratio):
    _change_expected(compliance.between, forces, n, ratio)


@part
def _change_expected(between, forces, n, ratio):
    """Forces and moments that tell each other what to expect; None: they do not."""
    if between is None:
        return
    for row in range(2):
        for j in range(n):
            Q, M, at = forces.force[row, j], forces.tilted.moment[row, j], forces.halo + j
            forces.guess[row, at] = max(Q + ratio * (forces.guess[row, at] - Q), 0.0)
            forces.tilted.guess[row, at] = M + ratio * (forces.tilted.guess[row, at] - M)
        wrap(forces.guess, row, n, forces.halo)
        wrap(forces.tilted.guess, row, n, forces.halo)
    for lane in range(WIDTH):
        forces.fastest[lane] *= ratio


@part
def _change_tilts(tilts, n, shift, back):
    """Slopes of the axes of guided rollers and hub, as all other motions."""
    if tilts is not None:
        for j in range(n):
            tilts.tilt[j] += shift * tilts.pushed[j]
            _turn_back(tilts.before, tilts.rate, j, back)
        for k in range(2):
            tilts.slope[k] += shift * tilts.slope_pushed[k]
            _turn_back(tilts.slope_before, tilts.slope_rate, k, back)


@part
def _change_ahead(ahead, n, ratio):
    if ahead is not None:
        for row in range(2):
            for j in range(n):
                ahead[0, row, j] *= ratio * ratio


@part
def _change_damping(dampers, more):
    if dampers is not None:
        dampers.work[1] += more


@part
def _change_radiation(radiation, more):
    if radiation is not None:
        radiation.work[1] += more


@part
def _change_cage(pair, back, ratio):
    """Works of its contacts' last step end by its next velocities, and so does its drag's."""
    if pair is not None:
        motion = pair.cage.motion
        for i in range(3):
            motion[1, i] -= back * (motion[1, i] - motion[2, i])
        pair.cage.drag[0] *= ratio


@part
def _change_shaft(shaft, dt, next_, velocity):
    """`velocity` : the hub's half a new step before."""
    if shaft is not None:
        for k in range(2):
            shaft.dissipated[0] -= 0.5 * shaft.drag[k] * (dt * shaft.before[k] - next_ * velocity[k])
            shaft.before[k] = velocity[k]


@verb
def _change_housing(housing, before, dt, next_, shift):
    """The housing's motion, as the hub's."""


@_change_housing.of(Housing)
def _change_of_housing(housing, before, dt, next_, shift):
    for k in range(2):
        housing.place[k] += shift * before.ring_acceleration[k]
        moved = dt * housing.before[k]
        _turn_back(housing.before, housing.velocity, k, 0.5 * (1.0 - next_ / dt))
        housing.dissipated[0] -= 0.5 * housing.drag[k] * (moved - next_ * housing.before[k])


@verb
def _change_sensor(housing, paces, pace, dt):
    """That of a sensor on it, once the housing's has changed."""


@_change_sensor.of(Housing)
def _change_sensor_on(housing, paces, pace, dt):
    _sense_anew(housing.sensor, paces, pace, (housing.velocity[1] - housing.before[1]) / dt)


@verb
def _sense_anew(sensor, paces, pace, pushed):
    """From half an old step before to half a new one before: there and back under the acceleration `pushed`, m/s²."""


@_sense_anew.of(Resonator)
def _sense_by(sensor, paces, pace, pushed):
    motion, half, whole = sensor.motion, sensor.half_step, paces.half_step[pace]
    x = half[0, 0] * motion[0] + half[0, 1] * motion[1] + (half[0, 2] - whole[0, 2]) * pushed
    y = half[1, 0] * motion[0] + half[1, 1] * motion[1] + (half[1, 2] - whole[1, 2]) * pushed
    size = whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0]
    motion[0] = (whole[1, 1] * x - whole[0, 1] * y) / size
    motion[1] = (whole[0, 0] * y - whole[1, 0] * x) / size
    for i in range(2):
        for k in range(3):
            sensor.step[i, k], sensor.half_step[i, k] = paces.step[pace, i, k], paces.half_step[pace, i, k]


@verb
def _smooth(compliance, bodies, forces):
    """What contacts meet on perfect circles, which nothing looks up."""
    for j in range(bodies.columns):
        forces.bracket_now[INNER, j], forces.bracket_now[OUTER, j] = compliance.inner.B, compliance.outer.B
        for i in range(4):
            forces.slope[i, j] = forces.softening[i, j] = 0.0


@_smooth.of(Tilted)
def _smooth_tilted(compliance, bodies, forces):
    pass  # they look it up, and find nothing


@_smooth.of(Isolated)
def _smooth_alone(compliance, bodies, forces):
    for j in range(bodies.columns):
        forces.bracket_now[INNER, j] = forces.bracket_now[OUTER, j] = 0.0
        for i in range(4):
            forces.slope[i, j] = 0.0
