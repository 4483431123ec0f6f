"""The bodies' own part of a step, shared out among threads: each takes a share of the nodes of every body.

`team` is None for one thread, which then is compiled without a trace of threads; else an array with an entry for each.
Sums over nodes are made by share and then added in order, so that a number of threads always gives the same bits.
"""

from typing import NamedTuple

import numpy as np
from numba import prange

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.jit import kernel, part


class Nodes(NamedTuple):
    """What a share reads and writes of a body; numba's parallel loops take arrays and numbers only."""

    table: np.ndarray  # −dt·M⁻¹K, of a ring or of the rollers
    u: np.ndarray
    w: np.ndarray
    radii: np.ndarray  # of a ring's rows; of the rollers' points
    first: int
    end: int


class Steps(NamedTuple):
    """What a share needs of a step; arrays over rollers are (columns,) or a multiple of it."""

    starts: np.ndarray  # rows of the rollers' matrix
    neighbours: np.ndarray
    mass: np.ndarray
    torque: np.ndarray  # filled by share
    columns: int
    dt: float


class Turns(NamedTuple):
    """How bodies turn and move as a whole in a step."""

    kick: np.ndarray  # (columns,), rad/s, of the rollers
    cosine: np.ndarray  # (columns,), of the rollers' frames' turn
    sine: np.ndarray
    shift_x: np.ndarray  # (columns,), m/s, of the rollers' centres of mass, in their frames
    shift_y: np.ndarray
    ring_cosine: float  # of the inner ring's turn
    ring_sine: float
    turns: bool  # the inner ring


@part
def _of_ring(ring):
    return Nodes(ring.table, ring.u, ring.w, ring.radii, ring.first_row, ring.last_row)


@part
def _of_disc(disc):
    return Nodes(disc.blocks, disc.u, disc.w, disc.points, 0, disc.mass.size)


@part
def _steps(bodies, drive, scratch):
    disc = bodies.disc
    return Steps(disc.starts, disc.neighbours, disc.mass, scratch.torque, bodies.rollers.columns, drive.dt)


@part
def kick_bodies(bodies, drive, scratch, team):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    bore, line, weighs = scratch.bore, scratch.line, drive.gravity > 0.0
    if weighs:  # in the frames' axes
        g = -drive.gravity * drive.dt
        c, s = drive.frame[1], drive.frame[2]
        ring_kernels.set_rigid(bore, 0, bodies.inner.cosines, bodies.inner.sines, s * g, c * g)
        ring_kernels.set_rigid(line, 0, bodies.outer.cosines, bodies.outer.sines, 0.0, g)
    nodes = (_of_disc(bodies.disc), _of_ring(bodies.inner), _of_ring(bodies.outer))
    steps = _steps(bodies, drive, scratch)
    if team is None:
        _kick_share(nodes[0], nodes[1], nodes[2], steps, (bore, line), weighs, 0, 1)
    else:
        _kick_shares(nodes[0], nodes[1], nodes[2], steps, (bore, line), weighs, team.size)
        _add_up(scratch.torque, steps.columns, team.size)


@kernel(parallel=True)
def _kick_shares(disc, inner, outer, steps, weight, weighs, shares):
    for share in prange(shares):
        _kick_share(disc, inner, outer, steps, weight, weighs, share, shares)


@part
def _kick_share(disc, inner, outer, steps, weight, weighs, share, shares):
    first, end = _part(disc, share, shares)
    disc_kernels.kick(
        steps.starts, steps.neighbours, disc.table, steps.mass, disc.u, disc.w, steps.columns, steps.torque, first, end,
        share * steps.columns,
    )  # fmt: skip
    first, end = _part(inner, share, shares)
    _kick_ring(inner, weight[0], weighs, first, end)
    first, end = _part(outer, share, shares)
    _kick_ring(outer, weight[1], weighs, first, end)


@part
def _kick_ring(ring, weight, weighs, first, end):
    if weighs:
        ring_kernels.kick_and_add(ring.table, ring.u, ring.w, weight, first, end)
    else:
        ring_kernels.kick(ring.table, ring.u, ring.w, first, end)


@part
def drift_bodies(bodies, drive, scratch, cosine, sine, team):
    """Move all nodes by a step; `cosine`, `sine` of the inner ring's turn; the rollers' lead in `scratch.torque`."""
    nodes = (_of_disc(bodies.disc), _of_ring(bodies.inner), _of_ring(bodies.outer))
    steps = _steps(bodies, drive, scratch)
    turns = Turns(
        bodies.rollers.turn_kick, scratch.cosine, scratch.sine, scratch.shift[0], scratch.shift[1], cosine, sine,
        drive.speed != 0.0,
    )  # fmt: skip
    if team is None:
        _drift_share(nodes[0], nodes[1], nodes[2], steps, turns, 0, 1)
    else:
        _drift_shares(nodes[0], nodes[1], nodes[2], steps, turns, team.size)
        _add_up(scratch.torque, steps.columns, team.size)


@kernel(parallel=True)
def _drift_shares(disc, inner, outer, steps, turns, shares):
    for share in prange(shares):
        _drift_share(disc, inner, outer, steps, turns, share, shares)


@part
def _drift_share(disc, inner, outer, steps, turns, share, shares):
    first, end = _part(disc, share, shares)
    disc_kernels.drift(
        disc.radii, steps.mass, disc.u, disc.w, steps.columns, steps.dt, turns.kick, turns.cosine, turns.sine,
        turns.shift_x, turns.shift_y, steps.torque, first, end, share * steps.columns,
    )  # fmt: skip
    first, end = _part(outer, share, shares)
    ring_kernels.drift_still(outer.u, outer.w, steps.dt, first, end)
    first, end = _part(inner, share, shares)
    if turns.turns:
        ring_kernels.drift(inner.u, inner.w, inner.radii, steps.dt, turns.ring_cosine, turns.ring_sine, first, end)
    else:
        ring_kernels.drift_still(inner.u, inner.w, steps.dt, first, end)


@part
def _part(body, share, shares):
    """The rows or nodes of a share: the first and the one after the last."""
    count = body.end - body.first
    return body.first + count * share // shares, body.first + count * (share + 1) // shares


@part
def _add_up(sums, columns, shares):
    """Sums of all shares into the first one's."""
    for at in range(columns, columns * shares):
        sums[at % columns] += sums[at]
