"""Rollers that roll without slip: their spin is prescribed, and rays that turn with the cage may hold their angles.

A held roller's centre stays on its ray about the outer ring's centre. Each step gives it the impulse along the pitch
circle with which it drifts onto the ray of the next instant; its power is what the cage works.

Source: SHAKE and RATTLE; Hairer, Lubich and Wanner, Geometric Numerical Integration (2006), chapter VII.1.4.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from fem.kernels.cage import N_CAGE_SCALARS
from fem.kernels.columns import WORK_DRIVE
from fem.kernels.drive import SPEED, STEP, TURN, follow, speed_of, step_of, turn_at, with_outer
from fem.kernels.jit import part
from fem.kernels.lanes import WIDTH, load, splat, store, total
from fem.kernels.mounts import ring_place, ring_rates


class Prescribed(NamedTuple):
    """Rotation of rollers by the shaft's, and the rays that hold them."""

    spin: float  # turns of a roller about its own centre in one of the shaft
    cage: float  # turns of the rays
    spin_by_outer: float  # turns of a roller in one of the outer ring
    cage_by_outer: float  # turns of the rays
    first: np.ndarray | None  # (2, columns), cosine and sine of the rays' angles at t = 0; None: rollers are free
    force: np.ndarray  # (columns,), N, of the last kick on the rollers along +θ
    work: np.ndarray  # (2,), J, done by these up to the last kick; and after it in that step
    column: int  # of a sample's row, the cage's first; < 0: no cage is reported


@part
def roll(prescribed, step):
    """Turn the rollers as they roll."""
    bodies, drive = step.bodies, step.drive
    more = prescribed.spin_by_outer
    turn = splat(with_outer(drive, prescribed.spin * turn_at(drive, step.time), more, TURN))
    spin = splat(with_outer(drive, prescribed.spin * speed_of(drive), more, SPEED))
    for group in range(0, bodies.n, WIDTH):
        store(bodies.turn, group, turn)
        store(bodies.spin, group, spin)
        store(step.before.spin, group, spin)
        store(prescribed.force, group, splat(0.0))


@part
def take_moment(prescribed, drive, moment):
    """The work of what keeps eight rollers' spin against a moment, N m, in a step."""
    if prescribed is not None:
        spin = prescribed.spin * speed_of(drive)
        spin = with_outer(drive, spin, prescribed.spin_by_outer, SPEED)
        drive.sums[1] -= spin * drive.dt * total(moment)


@part
def along_ray(prescribed, ox, oy, ax, ay):
    """Accelerations of eight rollers, m/s², less what the rays take of them; `ox`, `oy`: outward along the rays."""
    if prescribed is None:
        return ax, ay
    if prescribed.first is None:
        return ax, ay
    out = ax * ox + ay * oy
    return out * ox, out * oy


@part
def hold(prescribed, bodies, drive, time):
    """Give rollers the impulse along the pitch circle that lets them drift onto the rays of the next instant."""
    if prescribed is None:
        return
    first = prescribed.first
    if first is None:
        return
    columns, dt, more = bodies.columns, drive.dt, prescribed.cage_by_outer
    step = with_outer(drive, prescribed.cage * step_of(drive), more, STEP)
    angle = with_outer(drive, prescribed.cage * turn_at(drive, time), more, TURN)
    c, s, c_step, s_step = cos(angle), sin(angle), cos(step), sin(step)
    ring_x, ring_y = ring_place(bodies.housing)
    ring_vx, ring_vy = ring_rates(bodies.housing)[1]
    ring_x, ring_y, over = ring_x + dt * ring_vx, ring_y + dt * ring_vy, -1.0 / (dt * c_step)
    for group in range(0, bodies.n, WIDTH):
        first_c, first_s = load(first, group), load(first, columns + group)
        ex, ey = c * first_c - s * first_s, s * first_c + c * first_s
        next_x, next_y = c_step * ex - s_step * ey, s_step * ex + c_step * ey
        vx, vy = load(bodies.velocity, group), load(bodies.velocity, columns + group)
        x = load(bodies.centre, group) + dt * vx - ring_x
        y = load(bodies.centre, columns + group) + dt * vy - ring_y
        gained = over * (y * next_x - x * next_y)
        store(bodies.velocity, group, vx - gained * ey)
        store(bodies.velocity, columns + group, vy + gained * ex)
        store(prescribed.force, group, load(prescribed.force, group) + gained * (bodies.mass / dt))


@part
def note_rays(prescribed, step):
    """Add the work of the rays at the velocities before and after the whole kick."""
    if prescribed.first is not None:
        bodies, half = step.bodies, 0.5 * step.drive.dt
        prescribed.work[0] += prescribed.work[1] + half * _power(prescribed, bodies, step.forces, step.before.velocity)
        prescribed.work[1] = half * _power(prescribed, bodies, step.forces, bodies.velocity)


@part
def _power(prescribed, bodies, forces, velocity):
    """Of what the rays give all rollers under these velocities, W."""
    columns, found = bodies.columns, splat(0.0)
    for group in range(0, bodies.n, WIDTH):
        ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
        vx, vy = load(velocity, group), load(velocity, columns + group)
        found += load(prescribed.force, group) * (vy * ox - vx * oy)
    return total(found)


@part
def change_rays(prescribed, step, change):
    if prescribed.first is not None:
        follow(change.drive, step.time)
        hold(prescribed, step.bodies, change.drive, step.time)
        prescribed.work[1] = 0.5 * change.drive.dt * _power(prescribed, step.bodies, step.forces, step.bodies.velocity)


@part
def write_rays(prescribed, step, out):
    """The rays' work, and a cage that they stand for: its place, turn, speed and forces."""
    drive = step.drive
    out[WORK_DRIVE] += prescribed.work[0]
    if prescribed.column >= 0:
        at = prescribed.column
        out[at], out[at + 1] = ring_place(step.bodies.housing)
        more = prescribed.cage_by_outer
        out[at + 2] = with_outer(drive, prescribed.cage * turn_at(drive, step.time), more, TURN)
        out[at + 3] = with_outer(drive, prescribed.cage * speed_of(drive), more, SPEED)
        for j in range(step.bodies.n):
            out[at + N_CAGE_SCALARS + j] = prescribed.force[j]
