"""Two step lengths of rigid bodies: short ones near edges of spalls and while strikes die away, long ones beyond.

Time is cut into sections of one length each. At the border of two sections the last section's steps make their kick;
where the next one has steps of another length, velocities half a step away and positions are then changed to those that
belong to the same motion. Leapfrog's positions y are those of the motion less dt²/12 of the acceleration (see
`kick`), and its velocities before and after a kick v ∓ dt/2 of the acceleration, so y changes by
(dt² − dt'²)/12·a and v by ± (dt − dt')/2·a. Every force of that kick has worked in half of the old step and is to work
in half of the new one: sums of works that count whole steps are corrected for that, and nothing else need know.

What leapfrog conserves is the energy less dt²/12 Σ m (a·a − v·ȧ), as of vibrations (1 − ω² dt²/6) of theirs. Steps grow
only where that is next to nothing; so it shows how far strikes have died away, too.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.columns import INNER, OUTER
from fem.kernels.drive import TURN, turn_at, with_outer
from fem.kernels.jit import part
from fem.kernels.lanes import WIDTH
from fem.kernels.mounts import TWELFTH, rescale_kick, ring_rates
from fem.kernels.rigid.contacts import wrap
from fem.kernels.rigid.dampers import change_damped
from fem.kernels.rigid.rays import change_rays
from fem.kernels.rigid.state import Change
from fem.kernels.rigid.strikes import QUIET, change_radiated
from fem.kernels.tilts import change_axes, unrest_of_tilts

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


@part(inlined=False)
def take_pace(paces, step, drives):
    """Choose the pace of a section whose first kick has just been made, and change to it."""
    if step.time > 0.0:
        paces.made[paces.now[0]] += paces.counts[paces.now[0]]
    bodies, forces, drive = step.bodies, step.forces, step.drive
    now, pace = paces.now[0], FAR
    outer_turn = with_outer(drive, 0.0, 1.0, TURN)
    if _near_edges(paces, bodies, forces, turn_at(drive, step.time), outer_turn):
        pace = NEAR
    elif now == NEAR and not _unrest(paces, step) < paces.calm:
        pace = NEAR
    elif forces.radiation is not None:
        if now == NEAR and forces.radiation.state[0] != QUIET:  # a contact has just closed
            pace = NEAR
    if pace != now:
        new, dt = drives[pace], drives[pace].dt
        shift, back = TWELFTH * (drive.dt * drive.dt - dt * dt), 0.5 * (1.0 - dt / drive.dt)
        _change(step, Change(new, shift, back, paces.step[pace], paces.half_step[pace]))
        paces.now[0] = pace


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
def _unrest(paces, step):
    """Σ m (a·a − v·ȧ), J/s²: of vibrations twice ω² times their energy, whatever their phase.

    Rollers that fly have that yet to come, by the speed at which they will strike the outer raceway.
    """
    bodies, forces, before = step.bodies, step.forces, step.before
    next_ = ring_rates(bodies.housing)[1]
    hub, ring = before.hub_acceleration, before.ring_acceleration
    found = bodies.hub_mass * (hub[0] * hub[0] + hub[1] * hub[1])
    if bodies.housing is not None:
        found += bodies.housing.mass * (ring[0] * ring[0] + ring[1] * ring[1])
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
                if step.contacts.coupling is None:
                    rate = stiffness * (inward if row == INNER else outward)
                else:
                    rate = (forces.guess[row, forces.halo + j] - forces.force[row, j]) / step.drive.dt
                found += rate * rate / stiffness
    if bodies.tilts is not None:
        found += unrest_of_tilts(bodies.tilts, forces, bodies.n)
    return found


@part
def _change(step, change):
    bodies, forces, before, old, new = step.bodies, step.forces, step.before, step.drive, change.drive
    sums = old.sums
    for k in range(2):
        moved = change.shift * before.hub_acceleration[k]
        bodies.hub[k] += moved
        moved += 0.5 * old.dt * before.hub_velocity[k]
        rescale_kick(before.hub_velocity, bodies.hub_velocity, k, change.back)
        moved -= 0.5 * new.dt * before.hub_velocity[k]  # what the new step's half will count beside
        sums[0] += (1.0 - 2.0 * k) * before.load[k] * moved  # the load against y
        for j in range(bodies.n):
            bodies.centre[k, j] += change.shift * before.acceleration[k, j]
            rescale_kick(before.velocity[k], bodies.velocity[k], j, change.back)
    for j in range(bodies.n):
        rescale_kick(before.spin, bodies.spin, j, change.back)
    sums[1] -= change.back * (sums[1] - before.driven[0])
    ratio = new.dt / old.dt
    if step.contacts.coupling is not None:  # what is expected of forces and moments in the next step
        for row in range(2):
            for j in range(bodies.n):
                last, at = forces.force[row, j], forces.halo + j
                forces.guess[row, at] = max(last + ratio * (forces.guess[row, at] - last), 0.0)
            wrap(forces.guess, row, bodies.n, forces.halo)
            if step.contacts.tilted is not None:
                for j in range(bodies.n):
                    last, at = forces.tilted.moment[row, j], forces.halo + j
                    forces.tilted.guess[row, at] = last + ratio * (forces.tilted.guess[row, at] - last)
                wrap(forces.tilted.guess, row, bodies.n, forces.halo)
        for lane in range(WIDTH):
            forces.fastest[lane] *= ratio
    if forces.ahead is not None:
        for row in range(2):
            for j in range(bodies.n):
                forces.ahead[0, row, j] *= ratio * ratio
    shaft = bodies.shaft
    if shaft is not None:
        for k in range(2):
            moved = old.dt * shaft.before[k] - new.dt * before.hub_velocity[k]
            shaft.dissipated[0] -= 0.5 * shaft.drag[k] * moved
            shaft.before[k] = before.hub_velocity[k]
    housing = bodies.housing
    if housing is not None:  # its motion as the hub's, and then that of a sensor on it: from half an old step before to
        # half a new one before, there and back under one acceleration
        for k in range(2):
            housing.place[k] += change.shift * before.ring_acceleration[k]
            moved = old.dt * housing.before[k]
            rescale_kick(housing.before, housing.velocity, k, change.back)
            housing.dissipated[0] -= 0.5 * housing.drag[k] * (moved - new.dt * housing.before[k])
        sensor = housing.sensor
        if sensor is not None:
            pushed = (housing.velocity[1] - housing.before[1]) / new.dt
            motion, half, whole = sensor.motion, sensor.half_step, change.half_step
            x = half[0, 0] * motion[0] + half[0, 1] * motion[1] + (half[0, 2] - whole[0, 2]) * pushed
            y = half[1, 0] * motion[0] + half[1, 1] * motion[1] + (half[1, 2] - whole[1, 2]) * pushed
            size = whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0]
            motion[0] = (whole[1, 1] * x - whole[0, 1] * y) / size
            motion[1] = (whole[0, 0] * y - whole[1, 0] * x) / size
            for i in range(2):
                for k in range(3):
                    sensor.step[i, k], sensor.half_step[i, k] = change.step[i, k], change.half_step[i, k]
    if bodies.cage is not None:  # works of its contacts' last step end by its next velocities, and so does its drag's
        cage = bodies.cage.cage
        for i in range(3):
            rescale_kick(cage.motion[2], cage.motion[1], i, change.back)
        cage.drag[0] *= new.dt / old.dt
    if bodies.tilts is not None:
        change_axes(bodies.tilts, bodies.n, change)
    if forces.radiation is not None:
        change_radiated(forces.radiation, step, new.dt)
    if bodies.prescribed is not None:
        change_rays(bodies.prescribed, step, change)
    if forces.dampers is not None:
        change_damped(forces.dampers, step, change)
