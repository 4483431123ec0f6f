"""The time loop: leapfrog steps of the whole bearing, and the quantities a sample stores."""

from math import cos, pi, sin

from fem import disc_kernels, ring_kernels
from fem.contact_kernels import contact_impulses, friction_contacts, slips
from fem.jit import kernel
from fem.ring_kernels import HALO
from fem.subgrid import contact_energy

# columns of a sample: the hub, the energies, then blocks of n_rollers
(
    TIME,
    HUB_X,
    HUB_Y,
    HUB_VX,
    HUB_VY,
    HUB_AX,
    HUB_AY,
    KINETIC,
    ELASTIC,
    CONTACT,
    WORK_LOAD,
    WORK_GRAVITY,
    WORK_DRIVE,
    DISSIPATED,
    FRAME_MOMENT,
) = range(15)
N_SCALARS = 15
BLOCKS = (
    "roller_x",
    "roller_y",
    "roller_turn",
    "roller_spin",
    "inner_force",
    "outer_force",
    "roller_roller_force",
    "inner_traction",
    "outer_traction",
)

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
    """Advance all velocities by one step at fixed positions; returns the step's works (load, drive, friction), J."""
    dt = drive.dt
    rollers.impulse[:] = 0.0
    rollers.tilt[:] = 0.0
    drive.impulse[:] = 0.0
    drive.ring[3] = 0.0
    contact_impulses(rollers, inner, outer, contacts, drive, scratch.slope, contacts.resolved)
    if drive.friction > 0.0:
        slips(rollers, inner, outer, contacts, drive, contacts.slip)
    for j in range(rollers.n):
        rollers.velocity[j, 0] += rollers.tilt[j, 0] / rollers.total_mass
        rollers.velocity[j, 1] += rollers.tilt[j, 1] / rollers.total_mass - drive.gravity * dt

    # the hub, by the reaction of the ring's held row
    bore_r, bore_t = scratch.bore[0], scratch.bore[1]
    bore_r[:] = 0.0
    bore_t[:] = 0.0
    ring_kernels.row_force(inner.table, inner.u, inner.held, bore_r, bore_t)
    x, y, moment = ring_kernels.resultant(bore_r, bore_t, inner.cosines, inner.sines)
    c, s = drive.ring[1], drive.ring[2]
    node_mass = inner.row_mass[inner.held]
    load = load_at(drive, time)
    before_y = drive.velocity[1]
    drive.velocity[0] += (node_mass * (c * x - s * y) + drive.impulse[0]) / drive.mass
    drive.velocity[1] += (node_mass * (s * x + c * y) + drive.impulse[1] - load * dt) / drive.mass - drive.gravity * dt

    disc_kernels.kick(
        rollers.starts,
        rollers.neighbours,
        rollers.blocks,
        rollers.points,
        rollers.mass,
        rollers.u,
        rollers.w,
        rollers.columns,
        rollers.turn_kick,
        scratch.torque,
    )
    for j in range(rollers.n):  # the internal forces' second-order torque is taken back at the next kick
        rollers.turn_kick[j] = -scratch.torque[j] / rollers.inertia
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
    # the drive turns the held row against the ring's moment and the frame against the contacts'
    work_drive = drive.speed * (drive.ring[3] * dt - node_mass * moment * inner.radii[inner.held])
    return work_load, work_drive, dissipated


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
                _remember(rollers, inner, outer, drive, scratch)
            load, work, friction = kick(rollers, inner, outer, contacts, drive, time, scratch)
            if inside == 0:
                _sample(rollers, inner, outer, contacts, drive, scratch, samples[row], time, load, work, friction)
            drive.work[0] += load
            drive.work[1] += work
            drive.work[2] += friction
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


@kernel
def _remember(rollers, inner, outer, drive, scratch):
    scratch.rollers_w[:] = rollers.w
    scratch.rollers_velocity[:] = rollers.velocity
    scratch.inner_w[:] = inner.w
    scratch.outer_w[:] = outer.w
    scratch.hub_velocity[:] = drive.velocity


@kernel
def _sample(rollers, inner, outer, contacts, drive, scratch, out, time, load, work, friction):
    """Everything a sample stores, at the instant of the kick just made; half of its works belong to it."""
    before, after, dt = scratch.hub_velocity, drive.velocity, drive.dt
    out[TIME] = time
    out[HUB_X], out[HUB_Y] = drive.hub[0], drive.hub[1]
    out[HUB_VX], out[HUB_VY] = 0.5 * (before[0] + after[0]), 0.5 * (before[1] + after[1])
    out[HUB_AX], out[HUB_AY] = (after[0] - before[0]) / dt, (after[1] - before[1]) / dt
    out[KINETIC] = _kinetic(rollers, inner, outer, drive, scratch)
    elastic, moment = _elastic(rollers, inner, outer, drive, scratch)
    out[ELASTIC] = elastic
    out[FRAME_MOMENT] = moment
    out[CONTACT] = _contact_energy(contacts, rollers.n, contacts.resolved)
    out[WORK_LOAD] = drive.work[0] + 0.5 * load
    out[WORK_GRAVITY] = -drive.gravity * _weighted_height(rollers, inner, outer, drive)
    out[WORK_DRIVE] = drive.work[1] + 0.5 * work
    out[DISSIPATED] = drive.work[2] + 0.5 * friction
    n = rollers.n
    for j in range(n):
        at = N_SCALARS + j
        out[at] = rollers.centre[j, 0]
        out[at + n] = rollers.centre[j, 1]
        out[at + 2 * n] = rollers.turn[j] + rollers.lead[j]
        out[at + 3 * n] = rollers.spin[j]
        for kind in range(3):
            out[at + (4 + kind) * n] = contacts.force[kind, j]
        for kind in range(2):
            out[at + (7 + kind) * n] = contacts.traction[kind, j]


@kernel
def _kinetic(rollers, inner, outer, drive, scratch):
    """½ v(t − dt/2)·M·v(t + dt/2): with ½ uᵀKu the energy leapfrog conserves exactly.

    Less ½ (1 − cos ω dt) Σ m X·a of the bodies that turn: their forces turn with them within a step.
    """
    total, dt = 0.0, drive.dt
    columns, n = rollers.columns, rollers.n
    for i in range(rollers.mass.size):
        for component in range(2):
            at = (2 * i + component) * columns
            x = rollers.points[2 * i + component]
            for j in range(n):
                before, after = scratch.rollers_w[at + j], rollers.w[at + j]
                total += rollers.mass[i] * before * after
                total -= rollers.mass[i] * (1.0 - cos(rollers.spin[j] * dt)) * x * (after - before) / dt
    for j in range(n):
        for component in range(2):
            before = scratch.rollers_velocity[j, component]
            after = rollers.velocity[j, component] + rollers.impulse[j, component] / rollers.total_mass
            total += rollers.total_mass * before * after
    total += _ring_kinetic(inner, scratch.inner_w) + _ring_kinetic(outer, scratch.outer_w)
    outward = 0.0
    for row in range(inner.first_row, inner.last_row):
        for k in range(HALO, HALO + inner.n_sectors):
            gained = inner.w[row, 0, k] - scratch.inner_w[row, 0, k]
            outward += inner.row_mass[row] * inner.radii[row] * gained
    total -= (1.0 - cos(drive.speed * dt)) * outward / dt
    before, after = scratch.hub_velocity, drive.velocity
    total += drive.mass * (before[0] * after[0] + before[1] * after[1])
    rim = drive.speed * inner.radii[inner.held]
    total += inner.row_mass[inner.held] * inner.n_sectors * rim * rim
    return 0.5 * total


@kernel
def _ring_kinetic(ring, before):
    total = 0.0
    for row in range(ring.first_row, ring.last_row):
        part = 0.0
        for component in range(2):
            for k in range(HALO, HALO + ring.n_sectors):
                part += before[row, component, k] * ring.w[row, component, k]
        total += ring.row_mass[row] * part
    return total


@kernel
def _elastic(rollers, inner, outer, drive, scratch):
    """Energy ½ uᵀKu of all bodies, J, and the moment Σ u x f that the inner ring's turning frame exerts, N m."""
    total = 0.0
    dt = drive.dt
    columns, n = rollers.columns, rollers.n
    scratch.rollers_w[:] = 0.0
    scratch.still[:] = 0.0
    disc_kernels.kick(
        rollers.starts,
        rollers.neighbours,
        rollers.blocks,
        rollers.points,
        rollers.mass,
        rollers.u,
        scratch.rollers_w,
        columns,
        scratch.still,
        scratch.torque,
    )
    for i in range(rollers.mass.size):
        for component in range(2):
            at = (2 * i + component) * columns
            for j in range(n):
                total -= rollers.mass[i] / dt * rollers.u[at + j] * scratch.rollers_w[at + j]
    moment = 0.0
    scratch.inner_w[:] = 0.0
    ring_kernels.kick(inner.table, inner.u, scratch.inner_w, 0, inner.radii.size)
    for row in range(inner.radii.size):
        m = inner.row_mass[row] / dt
        for k in range(HALO, HALO + inner.n_sectors):
            ur, ut = inner.u[row, 0, k], inner.u[row, 1, k]
            fr, ft = scratch.inner_w[row, 0, k], scratch.inner_w[row, 1, k]
            total -= m * (ur * fr + ut * ft)
            moment += m * (ur * ft - ut * fr)
    scratch.outer_w[:] = 0.0
    ring_kernels.kick(outer.table, outer.u, scratch.outer_w, outer.first_row, outer.last_row)
    for row in range(outer.first_row, outer.last_row):
        m = outer.row_mass[row] / dt
        for component in range(2):
            for k in range(HALO, HALO + outer.n_sectors):
                total -= m * outer.u[row, component, k] * scratch.outer_w[row, component, k]
    return 0.5 * total, moment


@kernel
def _contact_energy(contacts, n, resolved):
    """Energy below the grid, or in the layers, of all contacts, J; the ripples' share is ½·ripple·Q²."""
    if resolved is not None:
        return resolved.energy.sum()
    total = 0.0
    for kind in range(3):
        for j in range(n):
            Q = contacts.force[kind, j]
            if Q > 0.0:
                total += contact_energy(Q, contacts.A[kind], contacts.bracket[kind, j], contacts.Q_line[kind])
    return total


@kernel
def _weighted_height(rollers, inner, outer, drive):
    """Σ m y of all that moves, kg m."""
    total = (drive.mass - inner.n_sectors * inner.row_mass[inner.held]) * drive.hub[1]
    for j in range(rollers.n):
        total += rollers.total_mass * rollers.centre[j, 1]
    total += _ring_height(inner, drive.ring[1], drive.ring[2]) + _ring_height(outer, 1.0, 0.0)
    return total


@kernel
def _ring_height(ring, c, s):
    total = 0.0
    for row in range(ring.radii.size):
        for k in range(HALO, HALO + ring.n_sectors):
            x = ring.u[row, 0, k] * ring.cosines[k] - ring.u[row, 1, k] * ring.sines[k]
            y = ring.u[row, 0, k] * ring.sines[k] + ring.u[row, 1, k] * ring.cosines[k]
            total += ring.row_mass[row] * (s * x + c * y)
    return total
