"""The bodies' own part of a step: kicks by internal forces and gravity, and the motion, of all nodes."""

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.course_kernels import is_turning
from fem.kernels.jit import part


@part
def kick_nodes(bodies, drive, scratch):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    inner, outer = bodies.inner, bodies.outer
    disc_kernels.kick(bodies.disc, bodies.disc.w, bodies.rollers.columns, scratch.torque)
    if drive.gravity > 0.0:  # in the frames' axes
        g = -drive.gravity * drive.dt
        c, s = drive.frame[1], drive.frame[2]
        ring_kernels.set_rigid(scratch.bore, 0, inner.cosines, inner.sines, s * g, c * g)
        ring_kernels.set_rigid(scratch.line, 0, outer.cosines, outer.sines, 0.0, g)
        ring_kernels.kick_and_add(inner.table, inner.u, inner.w, scratch.bore, inner.first_row, inner.last_row)
        ring_kernels.kick_and_add(outer.table, outer.u, outer.w, scratch.line, outer.first_row, outer.last_row)
    else:
        ring_kernels.kick(inner.table, inner.u, inner.w, inner.first_row, inner.last_row)
        ring_kernels.kick(outer.table, outer.u, outer.w, outer.first_row, outer.last_row)


@part
def drift_nodes(bodies, drive, scratch, cosine, sine):
    """Move all nodes by a step; `cosine`, `sine` of the inner ring's turn; the rollers' lead in `scratch.torque`."""
    rollers, inner, outer = bodies.rollers, bodies.inner, bodies.outer
    turns = disc_kernels.Turns(
        rollers.turn_kick, scratch.cosine, scratch.sine, scratch.shift[0], scratch.shift[1], rollers.swelling
    )
    disc_kernels.drift(bodies.disc, turns, rollers.columns, drive.dt, scratch.torque)
    ring_kernels.drift_still(outer.u, outer.w, drive.dt, outer.first_row, outer.last_row)
    if is_turning(drive.course, drive):
        first, end = inner.first_row, inner.last_row
        ring_kernels.drift(inner.u, inner.w, inner.radii, drive.dt, cosine, sine, first, end)
    else:
        ring_kernels.drift_still(inner.u, inner.w, drive.dt, inner.first_row, inner.last_row)
