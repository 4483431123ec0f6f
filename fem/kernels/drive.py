"""The hub: its kick and its motion; speed and load as a run goes on.

Speed and load as a run goes on. Where they stay the history is None: then nothing of this is compiled.

`follow` looks a time up; all else reads what it has found: what belongs to the step in hand.
"""

from math import cos, pi, sin

import numpy as np

from fem.kernels import ring_kernels
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine

# entries of `LoadHistory.now`; the first ones of `OuterTurn.now` too
TURN, SPEED, GAIN, JERK, STEP, FORCE_X, FORCE_Y, RATE_X, RATE_Y = range(9)
N_NOW = 9
N_OUTER_NOW = 5


@part
def follow(history, time, dt):
    """Look a time up, s, and how far the shaft turns in the step from there."""
    if history is not None:
        _follow_turn(history.now, history.turn_knots, history.turn, time, dt)
        if history.outer is not None:
            _follow_turn(history.outer.now, history.outer.turn_knots, history.outer.turn, time, dt)
        _find_force(history, time)


@part
def _follow_turn(now, knots, c, time, dt):
    """How far a ring has turned, how fast, and how far it turns in the step from there."""
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
def _find_force(history, time):
    """`lagrange.load_history.LoadHistory.force` and its rate."""
    now, c = history.now, history.load
    k, t = _piece(history.load_knots, time)
    speed, gain = now[SPEED], now[GAIN]
    heavy, (with_ring, at_speed) = now[TURN] + history.unbalance_angle, _carrying_load(history.outer, now)
    hc, hs, turning = cos(heavy), sin(heavy), with_ring + history.rotating_load_angle
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
def _carrying_load(outer, now):
    """How far the ring has turned with which a load turns, rad, and how fast it turns, rad/s."""
    if outer is None:
        return now[TURN], now[SPEED]
    if outer.carries_load:
        return outer.now[TURN], outer.now[SPEED]
    return now[TURN], now[SPEED]


@part
def radial_load_at(drive, time):
    """Radial load that stays, N, ramped up by half a cosine."""
    return drive.radial_load * share_at(drive, time)


@part
def load_at(history, drive, time):
    """Load along +x and along −y, N; without a history the first means nothing and is not to be used."""
    if history is None:
        return 0.0, radial_load_at(drive, time)
    share = share_at(drive, time)
    return share * history.now[FORCE_X], -share * history.now[FORCE_Y]


@part
def share_at(drive, time):
    """Share of the load that acts: `lagrange.load_history.load_share`."""
    if time >= drive.ramp:
        return 1.0
    return 0.5 * (1.0 - cos(pi * time / drive.ramp))


@part
def with_side_load(history, value, more):
    """A value with what the load along x adds to it, where there can be one."""
    if history is None:
        return value
    return value + more


@part
def speed_of(history, drive):
    """Of the shaft, rad/s."""
    if history is None:
        return drive.speed
    return history.now[SPEED]


@part
def turn_at(history, drive, time):
    """How far the shaft has turned, rad."""
    if history is None:
        return drive.speed * time
    return history.now[TURN]


@part
def step_of(history, drive):
    """How far it turns in this step, rad."""
    if history is None:
        return drive.speed * drive.dt
    return history.now[STEP]


@part
def is_turning(history, drive):
    """Whether it turns at all."""
    if history is None:
        return drive.speed != 0.0
    return True


@part
def outer_of(history):
    """The outer ring's turning; None where it stands still."""
    if history is None:
        return None
    return history.outer


@part
def with_outer(outer, value, share, entry):
    """A turn or speed with what the outer ring's adds, a share of an entry of `OuterTurn.now`."""
    if outer is None:
        return value
    return value + share * outer.now[entry]


@part
def outer_speed_of(outer):
    """Of the outer ring, rad/s."""
    if outer is None:
        return 0.0
    return outer.now[SPEED]


@part
def outer_axes(outer):
    """Cosine and sine of the outer ring's turn."""
    if outer is None:
        return 1.0, 0.0
    return outer.frame[1], outer.frame[2]


@part
def turn_outer(outer):
    """Turn the outer ring's frame by a step."""
    if outer is not None:
        outer.frame[0] += outer.now[STEP]
        outer.frame[1], outer.frame[2] = cosine_and_sine(outer.frame[0])


@part
def clear_outer(outer):
    """Forget the last step's moments on the outer ring."""
    if outer is not None:
        outer.moment[0] = outer.moment[1] = 0.0


@part
def note_outer(outer, dt):
    """Count a step's moments on the outer ring."""
    if outer is not None:
        outer.sums[0] += moment_on(outer, dt)


@part
def moment_on(outer, dt):
    """Of contacts on the outer ring in a step, N m s: those on its nodes, and that on its frame."""
    return outer.moment[1] - outer.moment[0] * dt


@part
def kick_hub(inner, drive, side_load, radial_load, scratch):
    """The hub's kick by contacts, the reaction of the ring's held row, load along x and against y, and weight.

    Returns the moment about the origin of contacts and load on the hub, N m s.
    """
    dt, hub, velocity, impulse = drive.dt, drive.hub, drive.velocity, drive.impulse
    ring_kernels.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = ring_kernels.resultant(scratch.bore, inner.cosines, inner.sines)
    c, s = drive.frame[1], drive.frame[2]
    node_mass = inner.row_mass[inner.held]
    moment = hub[0] * (impulse[1] - radial_load * dt) - hub[1] * impulse[0]
    moment = with_side_load(drive.history, moment, -hub[1] * side_load * dt)
    pushed = with_side_load(drive.history, node_mass * (c * x - s * y) + impulse[0], side_load * dt)
    velocity[0] += pushed / drive.mass
    velocity[1] += (node_mass * (s * x + c * y) + impulse[1] - radial_load * dt) / drive.mass - drive.gravity * dt
    return moment


@part
def move_hub(inner, drive, step):
    """Move the hub and turn it by `step`, rad, and the inner ring's held row with it."""
    hub, frame = drive.hub, drive.frame
    hub[0] += drive.dt * drive.velocity[0] + drive.slowed[1, 0]
    hub[1] += drive.dt * drive.velocity[1] + drive.slowed[1, 1]
    if is_turning(drive.history, drive):
        frame[0] += step
        frame[1], frame[2] = cosine_and_sine(frame[0])
    c, s = frame[1], frame[2]
    x, y = c * hub[0] + s * hub[1], c * hub[1] - s * hub[0]
    ring_kernels.set_rigid(inner.u, 2 * inner.held * inner.cosines.size, inner.cosines, inner.sines, x, y)
