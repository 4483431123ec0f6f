"""The bodies' own part of a step: kicks by internal forces and gravity, and the motion, of all nodes."""

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.bodies import calm_others, prepare_others, remember_slowed, slow_others
from fem.kernels.drive import STEP, is_turning, outer_axes, outer_of, speed_of
from fem.kernels.jit import part
from fem.kernels.lane_functions import cosine_and_sine
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH


@part
def kick_nodes(bodies, drive, scratch):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    inner, outer = bodies.inner, bodies.outer
    disc_kernels.kick(bodies.disc, bodies.disc.w, bodies.rollers.columns, scratch.torque)
    if drive.gravity > 0.0:  # in the frames' axes
        g = -drive.gravity * drive.dt
        c, s = drive.frame[1], drive.frame[2]
        ring_kernels.set_rigid(scratch.bore, 0, inner.cosines, inner.sines, s * g, c * g)
        c, s = outer_axes(outer_of(drive.history))
        ring_kernels.set_rigid(scratch.line, 0, outer.cosines, outer.sines, s * g, c * g)
        ring_kernels.kick_and_add(inner.table, inner.u, inner.w, scratch.bore, inner.first_row, inner.last_row)
        ring_kernels.kick_and_add(outer.table, outer.u, outer.w, scratch.line, outer.first_row, outer.last_row)
    else:
        ring_kernels.kick(inner.table, inner.u, inner.w, inner.first_row, inner.last_row)
        ring_kernels.kick(outer.table, outer.u, outer.w, outer.first_row, outer.last_row)


@part
def make_ready(bodies, drive, scratch):
    """Give held rows and halos of w what the stencil needs, and find the hub's share in the step to come."""
    if drive.slowing > 0.0:
        inner = bodies.inner
        set_held_row(inner, drive, 1.0)
        prepare_others(bodies.others)
        ring_kernels.wrap_all(bodies.outer.w)
        ring_kernels.wrap_all(inner.w)
        if drive.calming > 0.0:
            _calm_rings(bodies, drive, scratch)
        ring_kernels.row_force(inner.slowed, inner.calmed, inner.held, scratch.bore)
        x, y = ring_kernels.resultant(scratch.bore, inner.cosines, inner.sines)
        c, s, share = drive.frame[1], drive.frame[2], inner.row_mass[inner.held] / drive.mass
        remember_slowed(drive.slowed, share * (c * x - s * y), share * (s * x + c * y))
    slow_others(bodies.others, drive)


@part
def _calm_rings(bodies, drive, scratch):
    inner, outer = bodies.inner, bodies.outer
    step = speed_of(drive.history, drive) * drive.dt
    # `grown` is that of γ dt², along a chord
    ahead = (1.0 - cosine_and_sine(step)[0]) / drive.dt * drive.calming / drive.slowing
    ring_kernels.calm(inner.calming, inner.w, inner.calmed, inner.grown, ahead, inner.first_row, inner.last_row)
    ring_kernels.calm(outer.calming, outer.w, outer.calmed, outer.grown, 0.0, outer.first_row, outer.last_row)
    ring_kernels.calm_held(inner, drive.mass, scratch.bore)
    calm_others(bodies.others)


@part
def slow_nodes(bodies, drive, scratch):
    """Do to the rollers' nodes what the reciprocal mass does; find the velocities of all surfaces' nodes.

    `scratch.cosine` : of the rollers' turns in the step to come
    """
    rollers, slowing = bodies.rollers, drive.slowing
    if slowing > 0.0:
        disc_kernels.slow_waves(
            bodies.disc, scratch.cosine, rollers.columns, slowing, drive.calming, drive.dt, scratch.torque
        )
        for j in range(rollers.n):
            rollers.turn_kick[j] -= slowing / rollers.inertia * scratch.torque[j]
        for ring in (bodies.inner, bodies.outer):
            ring_kernels.find_velocities(ring.slowed, ring.calmed, ring.w, ring.v, drive.dt, ring.raceway)


@part
def drift_nodes(bodies, drive, scratch, cosine, sine):
    """Move all nodes by a step; `cosine`, `sine` of the inner ring's turn; the rollers' lead in `scratch.torque`.

    Where masses are not lumped all is ready for the stencil to be applied to rings' w (`make_ready`), and is no more
    after.
    """
    rollers, inner, outer, turn_kick = bodies.rollers, bodies.inner, bodies.outer, bodies.rollers.turn_kick
    slowing, dt = drive.slowing, drive.dt
    turns = disc_kernels.Turns(
        turn_kick, scratch.cosine, scratch.sine, scratch.shift[0], scratch.shift[1], rollers.swelling
    )
    disc_kernels.drift(bodies.disc, turns, rollers.columns, dt, scratch.torque)
    _drift_outer(outer_of(drive.history), outer, dt, slowing)
    if is_turning(drive.history, drive):
        first, end = inner.first_row, inner.last_row
        if slowing > 0.0:
            ring_kernels.slow_waves(inner.slowed, inner.u, inner.calmed, first, end, inner.raceway)
            ring_kernels.unwrap(inner.w, inner.raceway)
        motion, rows = (inner.u, inner.w, inner.v), (first, end, inner.raceway)
        ring_kernels.drift(motion, inner.radii, inner.grown, dt, (cosine, sine), rows)
    else:
        _drift_still(inner, dt, slowing)


@part
def _drift_outer(turning, ring, dt, slowing):
    """The outer ring's nodes; where it turns masses are lumped."""
    if turning is None:
        _drift_still(ring, dt, slowing)
    else:
        motion, rows = (ring.u, ring.w, ring.v), (ring.first_row, ring.last_row, ring.raceway)
        ring_kernels.drift(motion, ring.radii, ring.grown, dt, cosine_and_sine(turning.now[STEP]), rows)


@part
def _drift_still(ring, dt, slowing):
    if slowing > 0.0:
        motion, rows = (ring.u, ring.w, ring.v), (ring.first_row, ring.last_row, ring.raceway)
        ring_kernels.drift_slowed(ring.slowed, motion, ring.calmed, dt, rows)
        ring_kernels.unwrap(ring.w, ring.raceway)
    else:
        ring_kernels.drift_still(ring.u, ring.w, dt, ring.first_row, ring.last_row)


@part
def set_held_row(inner, drive, half):
    """Give the inner ring's held row the hub's velocity, `half` a step after a kick (−1: before it): along a chord."""
    c, s, vx, vy = drive.frame[1], drive.frame[2], drive.velocity[0], drive.velocity[1]
    width, speed = inner.cosines.size, speed_of(drive.history, drive)
    at = 2 * inner.held * width
    ring_kernels.set_rigid(inner.w, at, inner.cosines, inner.sines, c * vx + s * vy, c * vy - s * vx)
    ahead, rim = 0.5 * half * drive.dt * speed, speed * inner.radii[inner.held]
    inward, around = ahead * rim, (1.0 - 0.5 * ahead * ahead) * rim
    for k in range(at, at + width, WIDTH):
        store(inner.w, k, load(inner.w, k) - inward)
        store(inner.w, k + width, load(inner.w, k + width) + around)
