"""The bodies' own part of a step, shared out among threads: each takes a share of the nodes of every body.

`team` is None for one thread, which then is compiled without a trace of threads; else an array with an entry for each.
Sums over nodes are made by share and then added in order, so that a number of threads always gives the same bits.
"""

from typing import NamedTuple

import numpy as np
from numba import prange

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.jit import kernel


class Nodes(NamedTuple):
    """What a share reads and writes of a body; numba's parallel loops take arrays and numbers only."""

    table: np.ndarray  # −dt·M⁻¹K, of a ring or of the rollers
    u: np.ndarray
    w: np.ndarray
    radii: np.ndarray  # of a ring's rows; of the rollers' points
    first: int
    end: int


@kernel(forceinline=True)
def _nodes(ring):
    return Nodes(ring.table, ring.u, ring.w, ring.radii, ring.first_row, ring.last_row)


@kernel(forceinline=True)
def _disc(rollers):
    return Nodes(rollers.blocks, rollers.u, rollers.w, rollers.points, 0, rollers.mass.size)


@kernel(forceinline=True)
def kick_bodies(rollers, inner, outer, drive, scratch, team):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    bore, line, torque, gravity = scratch.bore, scratch.line, scratch.torque, drive.gravity
    if gravity > 0.0:  # in the frames' axes
        g = -gravity * drive.dt
        c, s = drive.ring[1], drive.ring[2]
        ring_kernels.set_rigid(bore, 0, inner.cosines, inner.sines, s * g, c * g)
        ring_kernels.set_rigid(line, 0, outer.cosines, outer.sines, 0.0, g)
    disc, one, other, columns = _disc(rollers), _nodes(inner), _nodes(outer), rollers.columns
    starts, neighbours, mass = rollers.starts, rollers.neighbours, rollers.mass
    if team is None:
        _kick_share(disc, starts, neighbours, mass, columns, one, other, gravity, bore, line, torque, 0, 1)
    else:
        n = team.size
        _kick_shares(disc, starts, neighbours, mass, columns, one, other, gravity, bore, line, torque, n)
        _add_up(torque, columns, n)


@kernel(parallel=True)
def _kick_shares(disc, starts, neighbours, mass, columns, inner, outer, gravity, bore, line, torque, shares):
    for share in prange(shares):
        _kick_share(disc, starts, neighbours, mass, columns, inner, outer, gravity, bore, line, torque, share, shares)


@kernel(forceinline=True)
def _kick_share(disc, starts, neighbours, mass, columns, inner, outer, gravity, bore, line, torque, share, shares):
    first, end = _part(disc, share, shares)
    disc_kernels.kick(
        starts, neighbours, disc.table, mass, disc.u, disc.w, columns, torque, first, end, share * columns
    )
    first, end = _part(inner, share, shares)
    _kick_ring(inner, bore, gravity, first, end)
    first, end = _part(outer, share, shares)
    _kick_ring(outer, line, gravity, first, end)


@kernel(forceinline=True)
def _kick_ring(ring, weight, gravity, first, end):
    if gravity > 0.0:
        ring_kernels.kick_and_add(ring.table, ring.u, ring.w, weight, first, end)
    else:
        ring_kernels.kick(ring.table, ring.u, ring.w, first, end)


@kernel(forceinline=True)
def drift_bodies(rollers, inner, outer, drive, scratch, cosine, sine, team):
    """Move all nodes by a step; `cosine`, `sine` of the inner ring's turn; the rollers' lead in `scratch.torque`."""
    disc, one, other, columns = _disc(rollers), _nodes(inner), _nodes(outer), rollers.columns
    mass, kick, lead, dt, speed = rollers.mass, rollers.turn_kick, scratch.torque, drive.dt, drive.speed
    c, s, shift = scratch.cosine, scratch.sine, scratch.shift
    if team is None:
        _drift_share(disc, mass, columns, kick, c, s, shift, lead, one, other, dt, speed, cosine, sine, 0, 1)
    else:
        n = team.size
        _drift_shares(disc, mass, columns, kick, c, s, shift, lead, one, other, dt, speed, cosine, sine, n)
        _add_up(lead, columns, n)


@kernel(parallel=True)
def _drift_shares(disc, mass, columns, kick, c, s, shift, lead, inner, outer, dt, speed, cosine, sine, shares):
    for share in prange(shares):
        _drift_share(disc, mass, columns, kick, c, s, shift, lead, inner, outer, dt, speed, cosine, sine, share, shares)


@kernel(forceinline=True)
def _drift_share(disc, mass, columns, kick, c, s, shift, lead, inner, outer, dt, speed, cosine, sine, share, shares):
    first, end = _part(disc, share, shares)
    disc_kernels.drift(
        disc.radii, mass, disc.u, disc.w, columns, dt, kick, c, s, shift[0], shift[1], lead, first, end,
        share * columns,
    )  # fmt: skip
    first, end = _part(outer, share, shares)
    ring_kernels.drift_still(outer.u, outer.w, dt, first, end)
    first, end = _part(inner, share, shares)
    if speed == 0.0:
        ring_kernels.drift_still(inner.u, inner.w, dt, first, end)
    else:
        ring_kernels.drift(inner.u, inner.w, inner.radii, dt, cosine, sine, first, end)


@kernel(forceinline=True)
def _part(body, share, shares):
    """The rows or nodes of a share: the first and the one after the last."""
    count = body.end - body.first
    return body.first + count * share // shares, body.first + count * (share + 1) // shares


@kernel(forceinline=True)
def _add_up(sums, columns, shares):
    """Sums of all shares into the first one's."""
    for at in range(columns, columns * shares):
        sums[at % columns] += sums[at]
