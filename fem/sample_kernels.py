"""What a sample stores, read off the state in the middle of a step: motion, forces, energies, works.

Off the hot path: once in a stride of steps.
"""

from math import cos

from fem import disc_kernels, ring_kernels
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


@kernel
def remember(rollers, inner, outer, drive, scratch):
    """Keep the velocities before a kick: a sample needs those of both half steps."""
    scratch.rollers_w[:] = rollers.w
    scratch.rollers_velocity[:] = rollers.velocity
    scratch.inner_w[:] = inner.w
    scratch.outer_w[:] = outer.w
    scratch.hub_velocity[:] = drive.velocity


@kernel
def write_sample(rollers, inner, outer, contacts, drive, scratch, out, time, load, work, friction):
    """Everything a sample stores, at the instant of the kick just made; half of its works belong to it."""
    before, after, dt = scratch.hub_velocity, drive.velocity, drive.dt
    out[TIME] = time
    out[HUB_X], out[HUB_Y] = drive.hub[0], drive.hub[1]
    out[HUB_VX], out[HUB_VY] = 0.5 * (before[0] + after[0]), 0.5 * (before[1] + after[1])
    out[HUB_AX], out[HUB_AY] = (after[0] - before[0]) / dt, (after[1] - before[1]) / dt
    out[KINETIC] = kinetic_energy(rollers, inner, outer, drive, scratch)
    elastic, moment = elastic_energy(rollers, inner, outer, drive, scratch)
    out[ELASTIC] = elastic
    out[FRAME_MOMENT] = moment
    out[CONTACT] = contacts_energy(contacts, rollers.n, contacts.resolved)
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
def kinetic_energy(rollers, inner, outer, drive, scratch):
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
def elastic_energy(rollers, inner, outer, drive, scratch):
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
def contacts_energy(contacts, n, resolved):
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
