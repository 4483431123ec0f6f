"""The bodies' own part of a step, shared out among threads: each takes a share of the nodes of every body.

`team` is None for one thread, which then is compiled without a trace of threads; else an array with an entry for each.
Sums over nodes are made by share and then added in order, so that a number of threads always gives the same bits.
"""

from numba import prange

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.jit import kernel


@kernel(forceinline=True)
def kick_bodies(rollers, inner, outer, drive, scratch, team):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    if drive.gravity > 0.0:  # in the frames' axes
        g = -drive.gravity * drive.dt
        c, s = drive.ring[1], drive.ring[2]
        ring_kernels.set_rigid(scratch.bore[0], scratch.bore[1], inner.cosines, inner.sines, s * g, c * g)
        ring_kernels.set_rigid(scratch.line[0], scratch.line[1], outer.cosines, outer.sines, 0.0, g)
    if team is None:
        _kick_share(rollers, inner, outer, drive.gravity, scratch.bore, scratch.line, scratch.torque, 0, 1)
    else:
        _kick_shares(rollers, inner, outer, drive.gravity, scratch.bore, scratch.line, scratch.torque, team.size)
        _add_up(scratch.torque, rollers.columns, team.size)


@kernel(parallel=True)
def _kick_shares(rollers, inner, outer, gravity, bore, line, torque, shares):
    for share in prange(shares):
        _kick_share(rollers, inner, outer, gravity, bore, line, torque, share, shares)


@kernel(forceinline=True)
def _kick_share(rollers, inner, outer, gravity, bore, line, torque, share, shares):
    n = rollers.mass.size
    disc_kernels.kick(
        rollers.starts,
        rollers.neighbours,
        rollers.blocks,
        rollers.mass,
        rollers.u,
        rollers.w,
        rollers.columns,
        torque,
        n * share // shares,
        n * (share + 1) // shares,
        share * rollers.columns,
    )
    first, end = _rows(inner, share, shares)
    ring_kernels.kick(inner.table, inner.u, inner.w, first, end)
    if gravity > 0.0:
        ring_kernels.accelerate(inner.w, bore, first, end)
    first, end = _rows(outer, share, shares)
    ring_kernels.kick(outer.table, outer.u, outer.w, first, end)
    if gravity > 0.0:
        ring_kernels.accelerate(outer.w, line, first, end)


@kernel(forceinline=True)
def drift_bodies(rollers, inner, outer, drive, scratch, cosine, sine, team):
    """Move all nodes by a step; `cosine`, `sine` of the inner ring's turn; the rollers' lead in `scratch.torque`."""
    if team is None:
        _drift_share(rollers, inner, outer, drive.dt, drive.speed, scratch, cosine, sine, 0, 1)
    else:
        _drift_shares(rollers, inner, outer, drive.dt, drive.speed, scratch, cosine, sine, team.size)
        _add_up(scratch.torque, rollers.columns, team.size)


@kernel(parallel=True)
def _drift_shares(rollers, inner, outer, dt, speed, scratch, cosine, sine, shares):
    for share in prange(shares):
        _drift_share(rollers, inner, outer, dt, speed, scratch, cosine, sine, share, shares)


@kernel(forceinline=True)
def _drift_share(rollers, inner, outer, dt, speed, scratch, cosine, sine, share, shares):
    n = rollers.mass.size
    disc_kernels.drift(
        rollers.points,
        rollers.mass,
        rollers.u,
        rollers.w,
        rollers.columns,
        dt,
        rollers.turn_kick,
        scratch.cosine,
        scratch.sine,
        scratch.shift[0],
        scratch.shift[1],
        scratch.torque,
        n * share // shares,
        n * (share + 1) // shares,
        share * rollers.columns,
    )
    first, end = _rows(outer, share, shares)
    ring_kernels.drift_still(outer.u, outer.w, dt, first, end)
    first, end = _rows(inner, share, shares)
    if speed == 0.0:
        ring_kernels.drift_still(inner.u, inner.w, dt, first, end)
    else:
        ring_kernels.drift(inner.u, inner.w, inner.radii, dt, cosine, sine, first, end)


@kernel(forceinline=True)
def _rows(ring, share, shares):
    """The free rows of a share: the first and the one after the last."""
    rows = ring.last_row - ring.first_row
    return ring.first_row + rows * share // shares, ring.first_row + rows * (share + 1) // shares


@kernel(forceinline=True)
def _add_up(sums, columns, shares):
    """Sums of all shares into the first one's."""
    for at in range(columns, columns * shares):
        sums[at % columns] += sums[at]
