"""The time loop: leapfrog steps of the whole bearing."""

from math import cos, pi, sin

from fem.kernels import ring_kernels
from fem.kernels.contact_kernels import contact_forces, push_nodes
from fem.kernels.friction_kernels import friction_contacts, grips, slips
from fem.kernels.jit import kernel
from fem.kernels.lane_functions import cosine_and_sine
from fem.kernels.rigid_kernels import turn_whole
from fem.kernels.sample_kernels import remember, write_sample
from fem.kernels.simd import WIDTH, fma, load, store
from fem.kernels.team_kernels import drift_bodies, kick_bodies

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
        grips(rollers, inner, outer, contacts, drive)
        slips(rollers, inner, outer, contacts, drive, scratch.still, contacts.slip)
    push_nodes(rollers, inner, outer, contacts, drive, contacts.resolved)
    velocity, tilt, lightness = rollers.velocity, rollers.tilt, 1.0 / rollers.total_mass
    for j in range(rollers.n):
        velocity[0, j] += tilt[0, j] * lightness
        velocity[1, j] += tilt[1, j] * lightness - drive.gravity * dt

    # the hub, by the reaction of the ring's held row
    ring_kernels.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = ring_kernels.resultant(scratch.bore, inner.cosines, inner.sines)
    c, s = drive.ring[1], drive.ring[2]
    node_mass = inner.row_mass[inner.held]
    load = load_at(drive, time)
    before_y = drive.velocity[1]
    moment = drive.hub[0] * (drive.impulse[1] - load * dt) - drive.hub[1] * drive.impulse[0]
    drive.velocity[0] += (node_mass * (c * x - s * y) + drive.impulse[0]) / drive.mass
    drive.velocity[1] += (node_mass * (s * x + c * y) + drive.impulse[1] - load * dt) / drive.mass - drive.gravity * dt

    kick_bodies(rollers, inner, outer, drive, scratch, scratch.team)
    for j in range(rollers.n):  # the internal forces' second-order torque is taken back
        rollers.turn_kick[j] -= scratch.torque[j] / rollers.inertia
    dissipated = 0.0
    if drive.friction > 0.0:
        dissipated = friction_contacts(rollers, inner, outer, contacts, drive, scratch.slip)
    work_load = -load * dt * 0.5 * (before_y + drive.velocity[1])
    return work_load, moment + drive.ring[4] - drive.ring[3] * dt, dissipated


@kernel(forceinline=True)
def drift(rollers, inner, outer, drive, scratch):
    """Advance all positions by one step."""
    dt, columns, over = drive.dt, rollers.columns, 1.0 / rollers.total_mass
    impulse, velocity, centre, shift = rollers.impulse, rollers.velocity, rollers.centre, scratch.shift
    for j in range(0, rollers.n, WIDTH):
        c, s = load(rollers.cosine, j), load(rollers.sine, j)
        px, py = load(impulse, j) * over, load(impulse, columns + j) * over
        store(shift, j, c * px + s * py)
        store(shift, columns + j, c * py - s * px)
        step_c, step_s = cosine_and_sine(load(rollers.increment, j))
        store(scratch.cosine, j, step_c)
        store(scratch.sine, j, step_s)
        vx, vy = load(velocity, j) + px, load(velocity, columns + j) + py
        store(velocity, j, vx)
        store(velocity, columns + j, vy)
        store(centre, j, fma(dt, vx, load(centre, j)))
        store(centre, columns + j, fma(dt, vy, load(centre, columns + j)))
    step = drive.speed * dt
    drift_bodies(rollers, inner, outer, drive, scratch, cos(step), sin(step), scratch.team)
    if len(rollers.rigid) > 0:
        turn_whole(rollers, dt, scratch.torque)
    for j in range(0, rollers.n, WIDTH):
        increment = load(rollers.increment, j)
        turn = load(rollers.turn, j) + increment
        c, s = cosine_and_sine(turn)
        lead = load(scratch.torque, j) * (1.0 / rollers.inertia)
        turned = increment + lead - load(rollers.lead, j)
        store(rollers.turn, j, turn)
        store(rollers.cosine, j, c)
        store(rollers.sine, j, s)
        store(rollers.spin, j, turned * (1.0 / dt))
        store(rollers.increment, j, turned + lead)
        store(rollers.lead, j, lead)

    drive.hub[0] += dt * drive.velocity[0]
    drive.hub[1] += dt * drive.velocity[1]
    if drive.speed != 0.0:
        drive.ring[0] += step
        drive.ring[1], drive.ring[2] = cos(drive.ring[0]), sin(drive.ring[0])
    c, s = drive.ring[1], drive.ring[2]
    x, y = c * drive.hub[0] + s * drive.hub[1], c * drive.hub[1] - s * drive.hub[0]
    ring_kernels.set_rigid(inner.u, 2 * inner.held * inner.cosines.size, inner.cosines, inner.sines, x, y)


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
        if not abs(rollers.velocity[0, j]) + abs(rollers.velocity[1, j]) < FASTEST:
            return j
    return -2
