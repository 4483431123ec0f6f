"""Samples of the loop of rigid bodies: places, motion and energies as its steps conserve them.

Inlined in the time loop, though only samples need them: a call makes some compiled loops move all their arrays'
descriptions about the stack, in every step, which takes as long as the step.
"""

from math import sqrt

from fem.kernels import columns as sample
from fem.kernels.columns import INNER, OUTER, ROLLER
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair
from fem.kernels.lanes import WIDTH, count_from, load, select, splat, store, total
from fem.kernels.mounts import TWELFTH, ring_place, ring_rates
from fem.kernels.rigid.contacts import along_ring, law_energy, wrap


@part
def write_motion(step, out):
    """Places are those that forces and accelerations of the sample belong to: leapfrog's, dt²/12 of these ahead.

    By leapfrog's own a shaft's springs would miss the hub's balance by k dt²/12 of its acceleration.
    """
    bodies, forces, drive, before = step.bodies, step.forces, step.drive, step.before
    out[sample.TIME] = step.time
    ahead, a = TWELFTH * drive.dt * drive.dt, before.hub_acceleration
    out[sample.HUB_X], out[sample.HUB_Y] = bodies.hub[0] + ahead * a[0], bodies.hub[1] + ahead * a[1]
    vx, vy = before.hub_velocity[0], before.hub_velocity[1]
    wx, wy = bodies.hub_velocity[0], bodies.hub_velocity[1]
    out[sample.HUB_VX], out[sample.HUB_VY] = 0.5 * (vx + wx), 0.5 * (vy + wy)
    out[sample.HUB_AX], out[sample.HUB_AY] = (wx - vx) / drive.dt, (wy - vy) / drive.dt
    n = bodies.n
    for j in range(n):
        at = sample.N_SCALARS + j
        out[at + sample.X * n] = bodies.centre[0, j] + ahead * before.acceleration[0, j]
        out[at + sample.Y * n] = bodies.centre[1, j] + ahead * before.acceleration[1, j]
        out[at + sample.TURN * n] = bodies.turn[j]
        out[at + sample.SPIN * n] = 0.5 * (before.spin[j] + bodies.spin[j])
        for row in range(3):
            out[at + (sample.FORCE + row) * n] = forces.force[row, j]
        for row in range(2):
            out[at + (sample.TRACTION + row) * n] = forces.traction[row, j]


@part
def write_works(step, out):
    """Works of load and drive up to the instant of the kick, and what friction has dissipated."""
    drive, before = step.drive, step.before
    half = 0.5 * drive.dt
    work = drive.sums[0] - half * before.load[1] * before.hub_velocity[1]
    more = half * before.load[0] * before.hub_velocity[0]
    out[sample.WORK_LOAD] = work + more
    out[sample.WORK_DRIVE] = 0.5 * (before.driven[0] + drive.sums[1])
    out[sample.DISSIPATED] = drive.sums[2]
    out[sample.DAMPED_BY_CONTACTS] = out[sample.DAMPED_BY_BODIES] = 0.0


@part
def note_beyond(bodies, forces):
    """Keep the most that kicks have given the hub beyond forces: as contacts open and close, or repay energy."""
    x, y, pair = 0.0, 0.0, bodies.cage
    if pair is not None:
        if pair.ring is not None and pair.cage.guide is not None:
            if pair.ring.turns:
                more = pair.cage.guide.kick[0] - pair.cage.guide.force[0]
                x, y = more * pair.cage.guide.normal[0, 0], more * pair.cage.guide.normal[1, 0]
    for j in range(bodies.n):
        # What a kick P gives beyond the force Q that a sample holds, N, each with the damper's.
        Q = forces.force[INNER, j]
        P = forces.kick[INNER, j]
        if forces.dampers is None:
            more = P - Q
        else:
            F = forces.dampers.force[INNER, j]
            more = P + F - max(Q + F, 0.0)
        x -= more * forces.normal[INNER, 0, j]
        y -= more * forces.normal[INNER, 1, j]
    forces.beyond[0] = max(forces.beyond[0], sqrt(x * x + y * y))


@part
def write_energies(step, out):
    """Kinetic energy as leapfrog conserves it, ½ v(t − dt/2)·M·v(t + dt/2), and all elastic energy as the contacts'."""
    bodies, contacts, forces, drive, before = step.bodies, step.contacts, step.forces, step.drive, step.before
    side_load, radial_load = before.load
    hub, n, columns = bodies.hub_velocity, bodies.n, bodies.columns
    moving, spinning, pushed, lifted, stored = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if contacts.coupling is not None:  # leave in `gained`, which the next step fills anew, what raceways feel around
        _repeat(forces.force, forces.gained, forces, n, columns)
        if contacts.tilted is not None:
            _repeat(forces.tilted.moment, forces.tilted.gained, forces, n, columns)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        square = load(before.velocity, group) * load(bodies.velocity, group)
        square += load(before.velocity, at) * load(bodies.velocity, at)
        moving += select(there, square, 0.0)
        spinning += select(there, load(before.spin, group) * load(bodies.spin, group), 0.0)
        ax, ay = load_pair(before.acceleration, group, columns)
        pushed += select(there, ax * ax + ay * ay + 2.0 * drive.gravity * ay, 0.0)
        lifted += select(there, load(bodies.centre, at), 0.0)
        stored += select(there, _contact_energy(step, group), 0.0)
    kinetic = bodies.hub_mass * (before.hub_velocity[0] * hub[0] + before.hub_velocity[1] * hub[1])
    kinetic += bodies.mass * total(moving)
    if bodies.prescribed is None:
        kinetic += bodies.inertia * total(spinning)
    ax, ay = before.hub_acceleration[0], before.hub_acceleration[1]
    pull = bodies.hub_mass * drive.gravity + radial_load
    pulled = bodies.hub_mass * (ax * ax + ay * ay) + 2.0 * pull * ay + bodies.mass * total(pushed)
    pulled = pulled + -2.0 * side_load * ax
    out[sample.KINETIC] = 0.5 * kinetic
    out[sample.ELASTIC] = 0.0
    # forces f from outside take the contacts ahead as well: what steps conserve holds dt²/24 Σ (m a − 2f)·a more
    out[sample.CONTACT] = total(stored) + drive.dt * drive.dt / 24.0 * pulled
    out[sample.WORK_GRAVITY] = -drive.gravity * (bodies.hub_mass * bodies.hub[1] + bodies.mass * total(lifted))


@part
def _repeat(array, gained, forces, n, columns):
    for row in range(2):
        for group in range(0, n, WIDTH):
            store(gained, row * gained.shape[1] + forces.halo + group, load(array, row * columns + group))
        wrap(gained, row, n, forces.halo)


@part
def _contact_energy(step, group):
    """Energy of eight rollers' contacts, as steps conserve it, J: of laws, between contacts, of tractions."""
    contacts, forces, columns = step.contacts, step.forces, step.bodies.columns
    coupling, tilted = contacts.coupling, contacts.tilted
    if tilted is None:
        own = _stored(contacts.inner, forces, group) + _stored(contacts.outer, forces, columns + group)
    else:
        own = load(forces.tilted.energy, group) + load(forces.tilted.energy, columns + group)
        if coupling is not None:
            M_i, M_o = load_pair(forces.tilted.moment, group, columns)
            more = 0.5 * along_ring(coupling, forces, forces.tilted.gained, INNER, group) * M_i
            more += 0.5 * along_ring(coupling, forces, forces.tilted.gained, OUTER, group) * M_o
            own += more * tilted.share
    for row in range(2):
        own += _curved(step, row, group) - _yet_to_give(step, row, group)
    if coupling is not None:
        own += coupling.across * load(forces.force, group) * load(forces.force, columns + group)
        for row in range(2):
            at = row * columns + group
            Q, T = load(forces.force, at), load(forces.traction, at)
            others = load(forces.lifted, at) + 0.5 * along_ring(coupling, forces, forces.gained, row, group)
            own += others * Q + select(Q > 0.0, (0.5 * coupling.tangential[row]) * T * T, 0.0)
        at = ROLLER * columns + group
        Q, T = load(forces.force, at), load(forces.traction, at)
        energy = law_energy(coupling.between, Q, load(forces.approach, at), None)
        own += select(Q > 0.0, energy + (0.5 * coupling.tangential[ROLLER]) * T * T, 0.0)
    return own


@part
def _stored(law, forces, at):
    Q, approach = load(forces.force, at), load(forces.approach, at)
    soft = None if forces.soft_before is None else load(forces.soft_before, at)
    return select(Q > 0.0, law_energy(law, Q, approach, soft), 0.0)


@part
def _curved(step, row, group):
    """Part of the energy that steps along a chord conserve, J: the force times half the rise between chord and circle.

    Work at both ends of a step, along normals that turn by v dt/ρ, is the force's times the change of its overlap but
    for ¼·(v² dt²/ρ)·(the change of the force). Of eight contacts.
    """
    bodies, forces, before = step.bodies, step.forces, step.before
    columns = bodies.columns
    nx, ny = load_pair(forces.normal, 2 * row * columns + group, columns)
    x, y = load_pair(bodies.centre, group, columns)
    vx = load(before.velocity, group) + load(bodies.velocity, group)
    vy = load(before.velocity, columns + group) + load(bodies.velocity, columns + group)
    if row == INNER:
        x, y = x - bodies.hub[0], y - bodies.hub[1]
        vx = vx - (before.hub_velocity[0] + bodies.hub_velocity[0])
        vy = vy - (before.hub_velocity[1] + bodies.hub_velocity[1])
    else:
        ring_x, ring_y = ring_place(bodies.housing)
        past, next_ = ring_rates(bodies.housing)
        x, y = x - ring_x, y - ring_y
        vx, vy = vx - (past[0] + next_[0]), vy - (past[1] + next_[1])
    along = (0.5 * step.drive.dt) * (vy * nx - vx * ny)
    risen = 0.25 * along * along / (x * nx + y * ny) * load(forces.force, row * columns + group)
    return -risen if row == INNER else risen


@part
def _yet_to_give(step, row, group):
    """What kicks give beyond their forces has worked on the way here; in the step ahead it works once more, J."""
    bodies, forces, columns = step.bodies, step.forces, step.bodies.columns
    beyond = load(forces.kick, row * columns + group) - load(forces.force, row * columns + group)
    vx, vy = load_pair(bodies.velocity, group, columns)
    if row == INNER:
        vx, vy = bodies.hub_velocity[0] - vx, bodies.hub_velocity[1] - vy
    else:
        ring_vx, ring_vy = ring_rates(bodies.housing)[1]
        vx, vy = vx - ring_vx, vy - ring_vy
    nx, ny = load_pair(forces.normal, 2 * row * columns + group, columns)
    return (0.5 * step.drive.dt) * beyond * (vx * nx + vy * ny)
