"""Speed and load as a run goes on. Where they stay the history is None: then nothing of this is compiled.

`follow` looks a time up; all else reads what it has found: what belongs to the step in hand. `drive` is that of either
loop, or whatever else has a `history` and the `speed` without one.
"""

from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from fem.kernels.fields import given, state
from fem.kernels.jit import part

# entries of `LoadHistory.now`; the first ones of `OuterTurn.now` too
TURN, SPEED, GAIN, JERK, STEP, FORCE_X, FORCE_Y, RATE_X, RATE_Y = range(9)
N_NOW = 9
N_OUTER_NOW = 5


class OuterTurn(NamedTuple):
    """An outer ring that turns about its fixed centre: how, as `LoadHistory` has it of the shaft, and what turns it."""

    turn_knots: given("n + 1")  # s
    turn: given("n, powers")  # rad
    now: state("n_outer_now")  # what `follow` found last
    frame: state("3")  # its turn, cosine and sine
    moment: state("2")  # of this step, by contacts: on the frame, N m; on nodes about the origin, N m s
    sums: state("4")  # N m s so far: of contacts, of gravity; that of gravity, N m, and at which time, s
    drive_work: state("3")  # as `LoadHistory` has it
    radius: float  # m, of the raceway
    speed: float  # rad/s, at t = 0
    growth: float  # m s², of the raceway's radius by the square of its speed; see `LoadHistory`
    carries_load: bool  # the load that turns turns with it


class LoadHistory(NamedTuple):
    """Speed and load as they go on: polynomials of the time since a knot, by powers; see `lagrange.load_history`."""

    turn_knots: given("n + 1")  # s
    turn: given("n, powers")  # rad, of the shaft
    load_knots: given("m + 1")  # s
    load: given("m, powers, 2")  # N, along x and y
    now: state("n_now")  # what `follow` found last
    drive_work: state("3")  # J, of the drive, up to a sample; and its speed, 1/s, and what it has given, N m s
    unbalance: float  # kg m
    unbalance_angle: float  # rad from +x at t = 0
    rotating_load: float  # N
    rotating_load_angle: float  # rad
    growth: float  # m s², of a free inner ring's and a roller's radii together, by the square of the shaft's speed
    roller_growth: float  # m s², of a roller's
    outer: OuterTurn | None = None  # None: the outer ring stands still


@part
def follow(drive, time):
    """Look a time up, s, and how far rings turn in the step from there; force and rate are those of
    `lagrange.load_history.LoadHistory.force`."""
    history = drive.history
    if history is not None:
        _follow_turn(history.now, history.turn_knots, history.turn, time, drive.dt)
        if history.outer is not None:
            _follow_turn(history.outer.now, history.outer.turn_knots, history.outer.turn, time, drive.dt)
        now, c = history.now, history.load
        k, t = _piece(history.load_knots, time)
        speed, gain, heavy = now[SPEED], now[GAIN], now[TURN] + history.unbalance_angle
        turned, at_speed = now[TURN], now[SPEED]  # of the ring with which a load turns
        if history.outer is not None:
            if history.outer.carries_load:
                turned, at_speed = history.outer.now[TURN], history.outer.now[SPEED]
        hc, hs, turning = cos(heavy), sin(heavy), turned + history.rotating_load_angle
        rx, ry = history.rotating_load * cos(turning), history.rotating_load * sin(turning)
        for axis in range(2):
            force, rate = 0.0, 0.0
            for n in range(c.shape[1] - 1, -1, -1):
                rate = rate * t + force
                force = force * t + c[k, n, axis]
            now[FORCE_X + axis], now[RATE_X + axis] = force, rate
        out, back = history.unbalance * speed * speed, history.unbalance * gain
        now[FORCE_X] += out * hc + back * hs + rx
        now[FORCE_Y] += out * hs - back * hc + ry
        out, ahead = 3.0 * history.unbalance * speed * gain, history.unbalance * (speed * speed * speed - now[JERK])
        now[RATE_X] += out * hc - ahead * hs - at_speed * ry
        now[RATE_Y] += out * hs + ahead * hc + at_speed * rx


@part
def _follow_turn(now, knots, c, time, dt):
    k, t = _piece(knots, time)
    turn, speed, gain, jerk = 0.0, 0.0, 0.0, 0.0
    for n in range(c.shape[1] - 1, -1, -1):  # Horner, of the polynomial and its derivatives
        jerk = jerk * t + 3.0 * gain
        gain = gain * t + 2.0 * speed
        speed = speed * t + turn
        turn = turn * t + c[k, n]
    now[TURN], now[SPEED], now[GAIN], now[JERK] = turn, speed, gain, jerk
    k, t = _piece(knots, time + dt)
    after = 0.0
    for n in range(c.shape[1] - 1, -1, -1):
        after = after * t + c[k, n]
    now[STEP] = after - turn


@part
def _piece(knots, time):
    """The polynomial of a time and the time since its knot; the first and the last go on beyond the ends.

    At a knot it is the one that begins there: a step's load.
    """
    k = min(max(np.searchsorted(knots, time, side="right") - 1, 0), knots.size - 2)
    return k, time - knots[k]


@part
def share_at(drive, time):
    """Share of the load that acts, ramped up by half a cosine: `lagrange.load_history.load_share`."""
    if time >= drive.ramp:
        return 1.0
    return 0.5 * (1.0 - cos(pi * time / drive.ramp))


@part
def load_at(drive, time):
    """Load along +x and along −y, N."""
    share, history = share_at(drive, time), drive.history
    if history is None:
        return 0.0, drive.radial_load * share
    return share * history.now[FORCE_X], -share * history.now[FORCE_Y]


@part
def speed_of(drive):
    """Of the shaft, rad/s."""
    return drive.speed if drive.history is None else drive.history.now[SPEED]


@part
def turn_at(drive, time):
    """How far the shaft has turned, rad."""
    return drive.speed * time if drive.history is None else drive.history.now[TURN]


@part
def step_of(drive):
    """How far it turns in this step, rad."""
    return drive.speed * drive.dt if drive.history is None else drive.history.now[STEP]


@part
def is_turning(drive):
    """Whether it turns at all."""
    return drive.speed != 0.0 if drive.history is None else True


@part
def with_outer(drive, value, share, entry):
    """A turn or speed with what the outer ring's adds, a share of an entry of `OuterTurn.now`."""
    if drive.history is not None:
        if drive.history.outer is not None:
            return value + share * drive.history.outer.now[entry]
    return value


@part
def outer_axes(drive):
    """Cosine and sine of the outer ring's turn."""
    if drive.history is not None:
        if drive.history.outer is not None:
            return drive.history.outer.frame[1], drive.history.outer.frame[2]
    return 1.0, 0.0
