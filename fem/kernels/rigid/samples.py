"""Samples of the loop of rigid bodies: places, motion and energies as its steps conserve them.

Inlined in the time loop, though only samples need them: a call makes some compiled loops move all their arrays'
descriptions about the stack, in every step, which takes as long as the step.
"""

from math import sqrt

from fem.kernels import columns as sample
from fem.kernels.columns import INNER, ROLLER
from fem.kernels.jit import part
from fem.kernels.lane_functions import load_pair
from fem.kernels.lanes import WIDTH, count_from, load, select, splat, store, total
from fem.kernels.mounts import TWELFTH, ring_place, ring_rates, write_hub
from fem.kernels.rigid.contacts import along_rings, law_energy, wrap


@part
def write_motion(step, out):
    """Places are those that forces and accelerations of the sample belong to: leapfrog's, dt²/12 of these ahead.

    By leapfrog's own a shaft's springs would miss the hub's balance by k dt²/12 of its acceleration.
    """
    bodies, forces, drive, before = step.bodies, step.forces, step.drive, step.before
    half = 0.5 * drive.dt  # works of load and drive up to the instant of the kick, and what friction has dissipated
    work = drive.sums[0] - half * before.load[1] * before.hub_velocity[1]
    out[sample.WORK_LOAD] = work + half * before.load[0] * before.hub_velocity[0]
    out[sample.WORK_DRIVE], out[sample.DISSIPATED] = 0.5 * (before.driven[0] + drive.sums[1]), drive.sums[2]
    out[sample.DAMPED_BY_CONTACTS] = out[sample.DAMPED_BY_BODIES] = 0.0
    out[sample.TIME] = step.time
    ahead, a = TWELFTH * drive.dt * drive.dt, before.hub_acceleration
    place = bodies.hub[0] + ahead * a[0], bodies.hub[1] + ahead * a[1]
    write_hub(out, place, before.hub_velocity, bodies.hub_velocity, drive.dt)
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
def note_beyond(bodies, forces):
    """Keep the most that kicks have given the hub beyond forces: as contacts open and close, or repay energy."""
    x, y, pair = 0.0, 0.0, bodies.cage
    if pair is not None:
        if pair.ring is not None and pair.cage.guide is not None:
            if pair.ring.turns:
                more = pair.cage.guide.kick[0] - pair.cage.guide.force[0]
                x, y = -more * pair.cage.guide.normal[0, 0], -more * pair.cage.guide.normal[1, 0]
    for j in range(bodies.n):
        # what a kick gives beyond the force that a sample holds, N, each with the damper's
        F = 0.0 if forces.dampers is None else forces.dampers.force[INNER, j]
        more = forces.kick[INNER, j] + F - max(forces.force[INNER, j] + F, 0.0)
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
        for row in range(2):
            for group in range(0, n, WIDTH):
                here, to = row * columns + group, row * forces.gained.shape[1] + forces.halo + group
                store(forces.gained, to, load(forces.force, here))
                if contacts.tilted is not None:
                    store(forces.tilted.gained, to, load(forces.tilted.moment, here))
            wrap(forces.gained, row, n, forces.halo)
            if contacts.tilted is not None:
                wrap(forces.tilted.gained, row, n, forces.halo)
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
            turn_i, turn_o = along_rings(coupling, forces, forces.tilted.gained, group)
            own += (0.5 * turn_i * M_i + 0.5 * turn_o * M_o) * tilted.share
    for row in range(2):
        own += _by_steps(step, row, group)
    if coupling is not None:
        Q_i, Q_o = load_pair(forces.force, group, columns)
        less_i, less_o = along_rings(coupling, forces, forces.gained, group)
        lift_i, lift_o = load_pair(forces.lifted, group, columns)
        own += coupling.across * Q_i * Q_o + (lift_i + 0.5 * less_i) * Q_i + (lift_o + 0.5 * less_o) * Q_o
        for row in range(2):
            Q, T = load(forces.force, row * columns + group), load(forces.traction, row * columns + group)
            own += select(Q > 0.0, (0.5 * coupling.tangential[row]) * T * T, 0.0)
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
def _by_steps(step, row, group):
    """What energies of eight contacts that steps conserve have beside those of laws, J.

    The force times half the rise between chord and circle: work at both ends of a step, along normals that turn by
    v dt/ρ, is the force's times the change of its overlap but for ¼·(v² dt²/ρ)·(the change of the force). And what
    kicks give beyond their forces has worked on the way here; in the step ahead it works once more.
    """
    bodies, forces, before, half = step.bodies, step.forces, step.before, 0.5 * step.drive.dt
    columns, place, (past, next_) = bodies.columns, ring_place(bodies.housing), ring_rates(bodies.housing)
    at, sign = row * columns + group, 1.0
    if row == INNER:
        hub, was, now, sign = bodies.hub, before.hub_velocity, bodies.hub_velocity, -1.0
        place, past, next_ = (hub[0], hub[1]), (was[0], was[1]), (now[0], now[1])
    nx, ny = load_pair(forces.normal, 2 * row * columns + group, columns)
    x, y = load_pair(bodies.centre, group, columns)
    vx, vy = load_pair(before.velocity, group, columns)
    wx, wy = load_pair(bodies.velocity, group, columns)
    wx, wy, Q = wx - next_[0], wy - next_[1], load(forces.force, at)
    along = half * ((vy - past[1] + wy) * nx - (vx - past[0] + wx) * ny)
    risen = 0.25 * along * along / ((x - place[0]) * nx + (y - place[1]) * ny) * Q
    return sign * (risen - half * (load(forces.kick, at) - Q) * (wx * nx + wy * ny))
