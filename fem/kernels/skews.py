"""Rollers that are free to skew, in the time loop: their axes, what turns and stops them; `sliced_friction`: tractions.

A roller's axis a has both its slopes, a = τ e_r − σ e_t, in a frame that does not turn. A guide, as of a flange or a
cage's pocket, is an elastic stop that lets the skew σ play.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.fields import given, room, state
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine, maximum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, count_from, select, splat, total, with_sign
from fem.kernels.law import kick_by_energy, released
from fem.kernels.rigid_parts import TWELFTH

SHORTEST = 1e-13  # rad, of a skew's change, by which work is divided


class Skews(NamedTuple):
    """Axes of rollers that are free to skew."""

    axis: state("2, columns")  # a, rad
    rate: state("2, columns")  # rad/s, at t − dt/2
    before: state("2, columns")  # before the last kick
    pushed: room("2, columns")  # rad/s², by contacts where they are
    rubbed: room("4, columns")  # N m, by tractions: on the roller's axis, and on the hub's
    slid: room("4, columns")  # tractions times z, N m, and along the axis, N, of the inner and the outer contact
    share: room("slices, columns")  # of slices of a contact
    traction: state("2, slices, 2, columns")  # N, on slices, along the pitch circle and along the axis
    beyond: state("columns", np.nan)  # rad, skew beyond the play; NaN: not known
    held: state("columns")  # N m, by the guide
    kick: state("columns")  # N m, what its last kick gave
    residual: state("columns")  # J: see `law.kick_force`
    place: given("slices")  # m, z of the slices' middles
    drop: given("2, slices")  # m
    gyration: float  # inertia of a roller about its axis over that about an axis across
    lateral: float  # stiffness of a contact along the axis over that across it, of creep and of stick
    play: float  # rad, either way
    guide: float  # N m/rad


@part
def drift_skews(skews, bodies, drive):
    """Turn the axes; rollers that spin turn the rates of theirs round (gyroscopic moment). None: there are none."""
    if skews is not None:
        columns, half = bodies.columns, 0.5 * drive.dt
        for group in range(0, bodies.n, WIDTH):
            at = columns + group
            c, s = cosine_and_sine(load(bodies.spin, group) * (skews.gyration * drive.dt))
            x, y = load(skews.rate, group), load(skews.rate, at)
            u, v = c * x - s * y, c * y + s * x
            store(skews.axis, group, load(skews.axis, group) + half * (x + u))
            store(skews.axis, at, load(skews.axis, at) + half * (y + v))
            store(skews.rate, group, u)
            store(skews.rate, at, v)


@part
def push_skews(skews, tilts, group, normals, moments):
    """Keep the angular accelerations of eight axes by contacts."""
    (ix, iy, ox, oy), (M_i, M_o), over = normals, moments, 1.0 / tilts.inertia
    store(skews.pushed, group, over * (M_i * ix - M_o * ox))
    store(skews.pushed, skews.axis.shape[1] + group, over * (M_i * iy - M_o * oy))


@part
def kick_skews(skews, tilts, drive, group, normals, moments):
    """The kick of eight axes by contacts, guides and tractions; what the guides push rollers along +θ, N m."""
    (ix, iy, ox, oy), (M_i, M_o) = normals, moments
    columns, over = skews.axis.shape[1], drive.dt / tilts.inertia
    at = columns + group
    ax, ay = load(skews.axis, group), load(skews.axis, at)
    skew = ax * oy - ay * ox
    beyond = absolute(skew) - skews.play
    held = skews.guide * maximum(beyond, 0.0)
    before, last = load(skews.beyond, group), load(skews.held, group)
    work = 0.5 * (held * maximum(beyond, 0.0) - last * maximum(before, 0.0))
    given, left, open_ = load(skews.kick, group), load(skews.residual, group), splat(0.0)
    P, left = kick_by_energy(before, last, given, left, beyond, held, work, open_)
    P, left = released(last, held, P, left, (beyond - before, open_), SHORTEST)
    store(skews.beyond, group, beyond)
    store(skews.held, group, held)
    store(skews.kick, group, P)
    store(skews.residual, group, left)
    back = P * with_sign(splat(1.0), -skew)
    x = M_i * ix - M_o * ox + back * oy + load(skews.rubbed, group)
    y = M_i * iy - M_o * oy - back * ox + load(skews.rubbed, at)
    rx, ry = load(skews.rate, group), load(skews.rate, at)
    store(skews.before, group, rx)
    store(skews.before, at, ry)
    store(skews.rate, group, rx + over * x)
    store(skews.rate, at, ry + over * y)
    return back * (ax * ox + ay * oy)


@part
def write_skews(skews, tilts, bodies, forces, drive, out):
    """A sample's tilts, skews, what tractions and guides give; see `tilts`."""
    n, columns, at, ahead = bodies.n, bodies.columns, tilts.column, TWELFTH * drive.dt * drive.dt
    moving, pushed, stored = splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        square = load(skews.before, group) * load(skews.rate, group)
        square += load(skews.before, columns + group) * load(skews.rate, columns + group)
        moving += select(there, square, 0.0)
        px, py = load(skews.pushed, group), load(skews.pushed, columns + group)
        pushed += select(there, px * px + py * py, 0.0)
        held = load(skews.held, group)
        stored += select(there, held * maximum(load(skews.beyond, group), 0.0), 0.0)
    for j in range(n):
        ox, oy = forces.normal[1, 0, j], forces.normal[1, 1, j]
        ax, ay = skews.axis[0, j] + ahead * skews.pushed[0, j], skews.axis[1, j] + ahead * skews.pushed[1, j]
        skew = ax * oy - ay * ox
        out[at + j], out[at + n + j] = ax * ox + ay * oy, skew
        further = at + 4 * n + 2 + j
        for k in range(4):
            out[further + k * n] = skews.slid[k, j]
        out[further + 4 * n] = -skews.held[j] if skew > 0.0 else skews.held[j]
    return tilts.inertia * total(moving), tilts.inertia * total(pushed), 0.5 * total(stored), 0.0
