"""The time loop: leapfrog steps of the whole bearing."""

from math import cos, pi, sin

from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.contact_kernels import contact_forces, push_nodes
from fem.kernels.friction_kernels import friction_contacts, grips, slips
from fem.kernels.jit import kernel
from fem.kernels.sample_kernels import remember, write_sample

DONE, NOT_FINITE = 0, 1
FASTEST = 1e5  # m/s; no body is faster unless the run has blown up


@kernel(forceinline=True)
def load_at(drive, time):
    """Radial load, N, ramped up by half a cosine."""
    if time >= drive.ramp:
        return drive.load
    return drive.load * 0.5 * (1.0 - cos(pi * time / drive.ramp))


@kernel(forceinline=True)
def kick(rollers, inner, outer, contacts, drive, time, scratch):
    """Advance all velocities by one step at fixed positions, but for the rollers' turning as a whole (`drift`).

    Returns of this step the work of the load, J, the moment on hub and ring about the origin other than the drive's and
    gravity's, N m s, and the dissipated work, J.
    """
    dt = drive.dt
    rollers.impulse[:] = 0.0
    rollers.tilt[:] = 0.0
    drive.impulse[:] = 0.0
    rollers.turn_kick[:] = 0.0
    drive.ring[3] = 0.0
    drive.ring[4] = 0.0
    contact_forces(rollers, inner, outer, contacts, drive, scratch.slope, contacts.resolved)
    if drive.friction > 0.0:
        grips(rollers, contacts)
        slips(rollers, inner, outer, contacts, scratch.still, contacts.slip)
    push_nodes(rollers, inner, outer, contacts, drive, contacts.resolved)
    for j in range(rollers.n):
        rollers.velocity[j, 0] += rollers.tilt[j, 0] / rollers.total_mass
        rollers.velocity[j, 1] += rollers.tilt[j, 1] / rollers.total_mass - drive.gravity * dt

    # the hub, by the reaction of the ring's held row
    bore_r, bore_t = scratch.bore[0], scratch.bore[1]
    bore_r[:] = 0.0
    bore_t[:] = 0.0
    ring_kernels.row_force(inner.table, inner.u, inner.held, bore_r, bore_t)
    x, y = ring_kernels.resultant(bore_r, bore_t, inner.cosines, inner.sines)
    c, s = drive.ring[1], drive.ring[2]
    node_mass = inner.row_mass[inner.held]
    load = load_at(drive, time)
    before_y = drive.velocity[1]
    moment = drive.hub[0] * (drive.impulse[1] - load * dt) - drive.hub[1] * drive.impulse[0]
    drive.velocity[0] += (node_mass * (c * x - s * y) + drive.impulse[0]) / drive.mass
    drive.velocity[1] += (node_mass * (s * x + c * y) + drive.impulse[1] - load * dt) / drive.mass - drive.gravity * dt

    disc_kernels.kick(
        rollers.starts,
        rollers.neighbours,
        rollers.blocks,
        rollers.mass,
        rollers.u,
        rollers.w,
        rollers.columns,
        scratch.torque,
    )
    for j in range(rollers.n):  # the internal forces' second-order torque is taken back
        rollers.turn_kick[j] -= scratch.torque[j] / rollers.inertia
    ring_kernels.kick(inner.table, inner.u, inner.w, inner.first_row, inner.last_row)
    ring_kernels.kick(outer.table, outer.u, outer.w, outer.first_row, outer.last_row)
    if drive.gravity > 0.0:
        g = -drive.gravity * dt
        ring_kernels.accelerate(
            inner.w, inner.cosines, inner.sines, s * g, c * g, scratch.bore, inner.first_row, inner.last_row
        )
        ring_kernels.accelerate(
            outer.w, outer.cosines, outer.sines, 0.0, g, scratch.line, outer.first_row, outer.last_row
        )
    dissipated = 0.0
    if drive.friction > 0.0:
        dissipated = friction_contacts(rollers, inner, outer, contacts, drive, scratch.slip)
    work_load = -load * dt * 0.5 * (before_y + drive.velocity[1])
    return work_load, moment + drive.ring[4] - drive.ring[3] * dt, dissipated


@kernel(forceinline=True)
def drift(rollers, inner, outer, drive, scratch):
    """Advance all positions by one step."""
    dt = drive.dt
    for j in range(rollers.n):
        c, s = rollers.cosine[j], rollers.sine[j]
        px, py = rollers.impulse[j, 0] / rollers.total_mass, rollers.impulse[j, 1] / rollers.total_mass
        scratch.shift[0, j], scratch.shift[1, j] = c * px + s * py, c * py - s * px
        scratch.cosine[j], scratch.sine[j] = cos(rollers.increment[j]), sin(rollers.increment[j])
        rollers.velocity[j, 0] += px
        rollers.velocity[j, 1] += py
        rollers.centre[j, 0] += dt * rollers.velocity[j, 0]
        rollers.centre[j, 1] += dt * rollers.velocity[j, 1]
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
    )
    for j in range(rollers.n):
        rollers.turn[j] += rollers.increment[j]
        rollers.cosine[j], rollers.sine[j] = cos(rollers.turn[j]), sin(rollers.turn[j])
        lead = scratch.torque[j] / rollers.inertia
        turned = rollers.increment[j] + lead - rollers.lead[j]
        rollers.spin[j] = turned / dt
        rollers.increment[j] = turned + lead
        rollers.lead[j] = lead

    drive.hub[0] += dt * drive.velocity[0]
    drive.hub[1] += dt * drive.velocity[1]
    ring_kernels.drift_still(outer.u, outer.w, dt, outer.first_row, outer.last_row)
    if drive.speed == 0.0:
        ring_kernels.drift_still(inner.u, inner.w, dt, inner.first_row, inner.last_row)
    else:
        step = drive.speed * dt
        ring_kernels.drift(inner.u, inner.w, inner.radii, dt, cos(step), sin(step), inner.first_row, inner.last_row)
        drive.ring[0] += step
        drive.ring[1], drive.ring[2] = cos(drive.ring[0]), sin(drive.ring[0])
    c, s = drive.ring[1], drive.ring[2]
    x, y = c * drive.hub[0] + s * drive.hub[1], c * drive.hub[1] - s * drive.hub[0]
    ring_kernels.set_rigid(inner.u[inner.held, 0], inner.u[inner.held, 1], inner.cosines, inner.sines, x, y)


@kernel(nogil=True)
def advance(rollers, inner, outer, contacts, drive, scratch, first_step, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    step = first_step
    for row in range(samples.shape[0]):
        for inside in range(stride):
            time = step * drive.dt
            if inside == 0:
                remember(rollers, inner, outer, drive, scratch)
            work, moment, dissipated = kick(rollers, inner, outer, contacts, drive, time, scratch)
            if inside == 0:
                load = load_at(drive, time)
                write_sample(rollers, inner, outer, contacts, drive, scratch, samples[row], time, load, moment)
            drive.sums[0] += work
            drive.sums[1] += moment
            drive.sums[2] += dissipated
            drift(rollers, inner, outer, drive, scratch)
            step += 1
            body = _lost(rollers, drive)
            if body != -2:
                return NOT_FINITE, step, body
    return DONE, step, -2


@kernel(forceinline=True)
def _lost(rollers, drive):
    """The first body whose velocity is not a number or absurd, or −2."""
    if not abs(drive.velocity[0]) + abs(drive.velocity[1]) < FASTEST:
        return -1
    for j in range(rollers.n):
        if not abs(rollers.velocity[j, 0]) + abs(rollers.velocity[j, 1]) < FASTEST:
            return j
    return -2
