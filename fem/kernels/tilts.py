"""Tilt of rigid bodies in the time loop: of rollers, and of a hub whose slope may be free.

Rollers are guided against skew: the axis of one stays in the plane through the bearing's axis, a = τ n, n outward from
the outer ring's centre.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from fem.kernels.columns import CONTACT, INNER, KINETIC, OUTER, WORK_DRIVE
from fem.kernels.drive import SPEED, speed_of, with_outer
from fem.kernels.fields import room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum
from fem.kernels.lanes import WIDTH, count_from, load, select, splat, store, total
from fem.kernels.mounts import TWELFTH, rescale_kick


class Tilts(NamedTuple):
    """Slopes of the axes of rollers and hub."""

    tilt: state("columns")  # τ, rad
    rate: state("columns")  # rad/s, at t − dt/2
    before: state("columns")  # before the last kick
    slope: state("2")  # b of the hub, rad
    slope_rate: state("2")
    slope_before: state("2")
    pushed: room("columns")  # rad/s², by contacts where they are
    slope_pushed: room("2")
    furthest: state("3, lanes")  # by lane, the largest approaches of both rows' contacts, m, and misalignment, rad
    inertia: float  # kg m², of a roller about an axis across its own
    along: float  # kg m², of a roller about its own axis
    spin: tuple[float, float]  # turns of a roller in one of the shaft, and of the outer ring
    cage: tuple[float, float]  # turns of the rollers about the bearing's axis
    hub_over: float  # 1/(kg m²), of the hub about an axis across; 0: its slope is held
    hub_spin: float  # kg m², of the hub about its axis
    hub_stiffness: float  # N m/rad, of the shaft
    rest: tuple[float, float]  # rad, where that is slack
    column: int  # of a sample's row


class TiltedForces(NamedTuple):
    """Further state of tilted contacts to `ReducedForces`, for each row and roller."""

    moment: state("2, columns")  # N m, of the last kick
    slope: state("2, columns", np.nan)  # rad, own misalignment then
    energy: state("2, columns")  # J, then
    guess: state("2, haloed")  # N m, moments expected of this step
    gained: state("2, haloed")  # what they turn out beyond that
    met: room("4, 2, columns")  # own misalignment, energy, moment; ∂Q/∂ψ
    stiffness: room("2, columns")  # −∂M/∂ψ, N m/rad
    # see `tilted_contact`
    edges: state("4, 2, columns")  # compliance of edges, m/N; None: surfaces are perfect circles
    sunken: state("8, 2, columns")  # of the part of the length that spalls take; None: they take none


@part
def turn_axes(tilts, drive):
    """Turn the axes by a step. A hub that spins turns its slope's rate round (gyroscopic moment)."""
    dt = drive.dt
    for group in range(0, tilts.tilt.size, WIDTH):
        store(tilts.tilt, group, load(tilts.tilt, group) + dt * load(tilts.rate, group))
    if tilts.hub_over > 0.0:
        angle = tilts.hub_spin * tilts.hub_over * speed_of(drive) * dt
        c, s, half = cos(angle), sin(angle), 0.5 * dt
        x, y = tilts.slope_rate[0], tilts.slope_rate[1]
        u, v = c * x - s * y, c * y + s * x
        tilts.slope[0] += half * (x + u)
        tilts.slope[1] += half * (y + v)
        tilts.slope_rate[0], tilts.slope_rate[1] = u, v


@part
def push_axes(tilts, drive, moments):
    """Keep the hub's angular acceleration by moments on it, N m, x and y."""
    spin = tilts.hub_spin * speed_of(drive)
    x = moments[0] - tilts.hub_stiffness * (tilts.slope[0] - tilts.rest[0]) - spin * tilts.slope_rate[1]
    y = moments[1] - tilts.hub_stiffness * (tilts.slope[1] - tilts.rest[1]) + spin * tilts.slope_rate[0]
    tilts.slope_pushed[0], tilts.slope_pushed[1] = tilts.hub_over * x, tilts.hub_over * y


@part
def kick_hub_axis(tilts, drive, moments):
    """The hub's kick by moments on it, N m, the shaft's ahead as these are."""
    ahead, over = TWELFTH * drive.dt * drive.dt, drive.dt * tilts.hub_over
    for k in range(2):
        tilts.slope_before[k] = tilts.slope_rate[k]
        bent = tilts.slope[k] + ahead * tilts.slope_pushed[k] - tilts.rest[k]
        tilts.slope_rate[k] += over * (moments[k] - tilts.hub_stiffness * bent)


@part
def _going_round(tilts, drive):
    """Stiffness against tilt of rollers that go round, I_a w Ω − I_t Ω², N m/rad, and I_t Ω²."""
    speed = speed_of(drive)
    cage = with_outer(drive, tilts.cage[0] * speed, tilts.cage[1], SPEED)
    whirl = tilts.inertia * cage * cage
    return tilts.along * with_outer(drive, tilts.spin[0] * speed, tilts.spin[1], SPEED) * cage - whirl, whirl


@part
def kick_axes(tilts, drive, group, moments):
    """The kick of eight rollers by moments that tilt them outwards, N m."""
    rate, back = load(tilts.rate, group), _going_round(tilts, drive)[0] * load(tilts.tilt, group)
    store(tilts.before, group, rate)
    store(tilts.rate, group, rate + (moments - back) * (drive.dt / tilts.inertia))


@part
def note_furthest(tilts, row, approach, slope):
    furthest, columns = tilts.furthest, tilts.furthest.shape[1]
    store(furthest, row * columns, maximum(load(furthest, row * columns), approach))
    store(furthest, 2 * columns, maximum(load(furthest, 2 * columns), slope))


@part
def unrest_of_tilts(tilts, forces, n):
    """Σ I (τ̈² − τ̇ d³τ/dt³), J/s², of rollers and hub: see `rigid.paces`."""
    found = 0.0
    for j in range(n):
        stiffness = forces.tilted.stiffness[INNER, j] + forces.tilted.stiffness[OUTER, j]
        found += tilts.inertia * tilts.pushed[j] * tilts.pushed[j] + stiffness * tilts.rate[j] * tilts.rate[j]
    if tilts.hub_over > 0.0:
        pushed = tilts.slope_pushed[0] * tilts.slope_pushed[0] + tilts.slope_pushed[1] * tilts.slope_pushed[1]
        found += pushed / tilts.hub_over
    return found


@part
def change_axes(tilts, n, change):
    """Slopes of the axes of guided rollers and hub, as all other motions."""
    for j in range(n):
        tilts.tilt[j] += change.shift * tilts.pushed[j]
        rescale_kick(tilts.before, tilts.rate, j, change.back)
    for k in range(2):
        tilts.slope[k] += change.shift * tilts.slope_pushed[k]
        rescale_kick(tilts.slope_before, tilts.slope_rate, k, change.back)


@part
def write_axes(tilts, bodies, forces, drive, out):
    """A sample's columns, and what tilts add to energies and to the drive's work, J."""
    n, at, ahead = bodies.n, tilts.column, TWELFTH * drive.dt * drive.dt
    for j in range(n):
        out[at + 2 * n + j], out[at + 3 * n + j] = forces.tilted.moment[INNER, j], forces.tilted.moment[OUTER, j]
    moving, pushed, aslant = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        there, tilt = count_from(group) < n, load(tilts.tilt, group)
        moving += select(there, load(tilts.before, group) * load(tilts.rate, group), 0.0)
        pushed += select(there, load(tilts.pushed, group) * load(tilts.pushed, group), 0.0)
        aslant += select(there, tilt * tilt, 0.0)
    for j in range(n):
        out[at + j] = tilts.tilt[j] + ahead * tilts.pushed[j]
        out[at + n + j] = 0.0
    # guides and cage give what going round with a tilt takes, beside contacts
    precession, whirl = _going_round(tilts, drive)
    turning = 0.5 * whirl * total(aslant)
    out[WORK_DRIVE] += turning - 0.5 * precession * total(aslant)
    kinetic, more, stored = tilts.inertia * total(moving), tilts.inertia * total(pushed), 0.0
    for k in range(2):
        place = tilts.slope[k] + ahead * tilts.slope_pushed[k]
        out[at + 4 * n + k] = place
        stored += 0.5 * tilts.hub_stiffness * (place - tilts.rest[k]) * (place - tilts.rest[k])
        if tilts.hub_over > 0.0:
            kinetic += tilts.slope_before[k] * tilts.slope_rate[k] / tilts.hub_over
            more += tilts.slope_pushed[k] * tilts.slope_pushed[k] / tilts.hub_over
    out[KINETIC] += 0.5 * kinetic + turning
    out[CONTACT] += stored + drive.dt * drive.dt / 24.0 * more
