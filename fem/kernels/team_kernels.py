"""The bodies' own part of a step, shared out among threads: each takes a share of the nodes of every body.

`team` is None for one thread, which then is compiled without a trace of threads; else an array with an entry for each.
Sums over nodes are made by share and then added in order, so that a number of threads always gives the same bits.
"""

from typing import NamedTuple

import numpy as np
from numba import prange

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.course_kernels import is_turning
from fem.kernels.jit import kernel, part


class Nodes(NamedTuple):
    """What a share reads and writes of a ring."""

    table: np.ndarray  # −dt·M⁻¹K
    u: np.ndarray
    w: np.ndarray
    radii: np.ndarray
    first: int
    end: int


class Turn(NamedTuple):
    """The inner ring's turn in a step."""

    cosine: float
    sine: float
    turns: bool


@part
def _nodes(ring):
    return Nodes(ring.table, ring.u, ring.w, ring.radii, ring.first_row, ring.last_row)


@part
def kick_bodies(bodies, drive, scratch, team):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    bore, line, weighs = scratch.bore, scratch.line, drive.gravity > 0.0
    if weighs:  # in the frames' axes
        g = -drive.gravity * drive.dt
        c, s = drive.frame[1], drive.frame[2]
        ring_kernels.set_rigid(bore, 0, bodies.inner.cosines, bodies.inner.sines, s * g, c * g)
        ring_kernels.set_rigid(line, 0, bodies.outer.cosines, bodies.outer.sines, 0.0, g)
    disc, inner, outer, columns = bodies.disc, _nodes(bodies.inner), _nodes(bodies.outer), bodies.rollers.columns
    if team is None:
        _kick_share((disc, inner, outer), columns, scratch.torque, (bore, line), weighs, 0, 1)
    else:
        _kick_shares(disc, inner, outer, columns, scratch.torque, (bore, line), weighs, team.size)
        _add_up(scratch.torque, columns, team.size)


@kernel(parallel=True)
def _kick_shares(disc, inner, outer, columns, torque, weight, weighs, shares):
    for share in prange(shares):
        _kick_share((disc, inner, outer), columns, torque, weight, weighs, share, shares)


@part
def _kick_share(nodes, columns, torque, weight, weighs, share, shares):
    disc, inner, outer = nodes
    first, end = _part(0, disc.mass.size, share, shares)
    disc_kernels.kick(disc, disc.w, columns, torque, first, end, share * columns)
    first, end = _part(inner.first, inner.end, share, shares)
    _kick_ring(inner, weight[0], weighs, first, end)
    first, end = _part(outer.first, outer.end, share, shares)
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
    disc, inner, outer, columns = bodies.disc, _nodes(bodies.inner), _nodes(bodies.outer), bodies.rollers.columns
    turns = disc_kernels.Turns(
        bodies.rollers.turn_kick,
        scratch.cosine,
        scratch.sine,
        scratch.shift[0],
        scratch.shift[1],
        bodies.rollers.swelling,
    )
    turn = Turn(cosine, sine, is_turning(drive.course, drive))
    if team is None:
        _drift_share((disc, inner, outer), columns, drive.dt, scratch.torque, (turns, turn), 0, 1)
    else:
        _drift_shares(disc, inner, outer, columns, drive.dt, scratch.torque, turns, turn, team.size)
        _add_up(scratch.torque, columns, team.size)
        _add_up_swelling(turns.swelling, columns, team.size)


@kernel(parallel=True)
def _drift_shares(disc, inner, outer, columns, dt, lead, turns, turn, shares):
    # nine arguments: numba's parallel loops take tuples, but none of tuples
    for share in prange(shares):
        _drift_share((disc, inner, outer), columns, dt, lead, (turns, turn), share, shares)


@part
def _drift_share(nodes, columns, dt, lead, turning, share, shares):
    (disc, inner, outer), (turns, turn) = nodes, turning
    first, end = _part(0, disc.mass.size, share, shares)
    disc_kernels.drift(disc, turns, columns, dt, lead, first, end, share * columns)
    first, end = _part(outer.first, outer.end, share, shares)
    ring_kernels.drift_still(outer.u, outer.w, dt, first, end)
    first, end = _part(inner.first, inner.end, share, shares)
    if turn.turns:
        ring_kernels.drift(inner.u, inner.w, inner.radii, dt, turn.cosine, turn.sine, first, end)
    else:
        ring_kernels.drift_still(inner.u, inner.w, dt, first, end)


@part
def _part(first, end, share, shares):
    """The rows or nodes of a share: the first and the one after the last."""
    count = end - first
    return first + count * share // shares, first + count * (share + 1) // shares


@part
def _add_up_swelling(swelling, columns, shares):
    if swelling is not None:
        _add_up(swelling, columns, shares)


@part
def _add_up(sums, columns, shares):
    """Sums of all shares into the first one's."""
    for at in range(columns, columns * shares):
        sums[at % columns] += sums[at]
