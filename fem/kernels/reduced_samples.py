"""Samples of the reduced model: places, motion and energies as its steps conserve them.

Inlined in the time loop, though only samples need them: a call makes some compiled loops move all their arrays'
descriptions about the stack, in every step, which takes as long as the step.
"""

from math import sqrt

from fem.kernels.cage import given_beyond
from fem.kernels.drive import with_side_load
from fem.kernels.isolated_contacts import Isolated, isolated_energy
from fem.kernels.jit import part, verb
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, count_from, select, splat, total
from fem.kernels.law import stored_energy
from fem.kernels.reduced_contacts import coupled_approach, wrap
from fem.kernels.reduced_housing import ring_place, ring_rates
from fem.kernels.reduced_state import INNER, NEXT, OUTER
from fem.kernels.rigid_parts import TWELFTH
from fem.kernels.sample_kernels import (
    CONTACT,
    DAMPED_BY_BODIES,
    DAMPED_BY_CONTACTS,
    DISSIPATED,
    ELASTIC,
    FORCE,
    HUB_AX,
    HUB_AY,
    HUB_VX,
    HUB_VY,
    HUB_X,
    HUB_Y,
    KINETIC,
    N_SCALARS,
    SPIN,
    TIME,
    TRACTION,
    TURN,
    WORK_DRIVE,
    WORK_GRAVITY,
    WORK_LOAD,
    X,
    Y,
)
from fem.kernels.tilted_contacts import Tilted, repeat_moments, tilted_energy


@part
def write_motion(bodies, forces, drive, before, out, time):
    """Places are those that forces and accelerations of the sample belong to: leapfrog's, dt²/12 of these ahead.

    By leapfrog's own a shaft's springs would miss the hub's balance by k dt²/12 of its acceleration.
    """
    out[TIME] = time
    ahead, a = TWELFTH * drive.dt * drive.dt, before.hub_acceleration
    out[HUB_X], out[HUB_Y] = bodies.hub[0] + ahead * a[0], bodies.hub[1] + ahead * a[1]
    vx, vy = before.hub_velocity[0], before.hub_velocity[1]
    wx, wy = bodies.hub_velocity[0], bodies.hub_velocity[1]
    out[HUB_VX], out[HUB_VY] = 0.5 * (vx + wx), 0.5 * (vy + wy)
    out[HUB_AX], out[HUB_AY] = (wx - vx) / drive.dt, (wy - vy) / drive.dt
    n = bodies.n
    for j in range(n):
        at = N_SCALARS + j
        out[at + X * n] = bodies.centre[0, j] + ahead * before.acceleration[0, j]
        out[at + Y * n] = bodies.centre[1, j] + ahead * before.acceleration[1, j]
        out[at + TURN * n] = bodies.turn[j]
        out[at + SPIN * n] = 0.5 * (before.spin[j] + bodies.spin[j])
        for row in range(3):
            out[at + (FORCE + row) * n] = forces.force[row, j]
        for row in range(2):
            out[at + (TRACTION + row) * n] = forces.traction[row, j]


@part
def write_works(bodies, drive, before, out):
    """Works of load and drive up to the instant of the kick, and what friction has dissipated."""
    half = 0.5 * drive.dt
    work = drive.sums[0] - half * before.load[1] * before.hub_velocity[1]
    more = half * before.load[0] * before.hub_velocity[0]
    out[WORK_LOAD] = with_side_load(drive.history, work, more)
    out[WORK_DRIVE] = 0.5 * (before.driven[0] + drive.sums[1])
    out[DISSIPATED] = drive.sums[2]
    out[DAMPED_BY_CONTACTS] = out[DAMPED_BY_BODIES] = 0.0


@part
def note_beyond(bodies, forces):
    """Keep the most that kicks have given the hub beyond forces: as contacts open and close, or repay energy."""
    x, y = given_beyond(bodies.cage)
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
def _curved(bodies, forces, drive, before, row, group):
    """Part of the energy that steps along a chord conserve, J: the force times half the rise between chord and circle.

    Work at both ends of a step, along normals that turn by v dt/ρ, is the force's times the change of its overlap but
    for ¼·(v² dt²/ρ)·(the change of the force). Of eight contacts.
    """
    columns = bodies.columns
    nx, ny = _normals(forces, row, columns, group)
    x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
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
    along = (0.5 * drive.dt) * (vy * nx - vx * ny)
    risen = 0.25 * along * along / (x * nx + y * ny) * load(forces.force, row * columns + group)
    return -risen if row == INNER else risen


@part
def _yet_to_give(bodies, forces, drive, row, group):
    """What kicks give beyond their forces has worked on the way here; in the step ahead it works once more, J."""
    columns = bodies.columns
    beyond = load(forces.kick, row * columns + group) - load(forces.force, row * columns + group)
    vx, vy = load(bodies.velocity, group), load(bodies.velocity, columns + group)
    if row == INNER:
        vx, vy = bodies.hub_velocity[0] - vx, bodies.hub_velocity[1] - vy
    else:
        ring_vx, ring_vy = ring_rates(bodies.housing)[1]
        vx, vy = vx - ring_vx, vy - ring_vy
    nx, ny = _normals(forces, row, columns, group)
    return (0.5 * drive.dt) * beyond * (vx * nx + vy * ny)


@part
def _normals(forces, row, columns, group):
    return load(forces.normal, 2 * row * columns + group), load(forces.normal, (2 * row + 1) * columns + group)


@part
def write_energies(bodies, compliance, forces, drive, before, out):
    """Kinetic energy as leapfrog conserves it, ½ v(t − dt/2)·M·v(t + dt/2), and all elastic energy as the contacts'."""
    side_load, radial_load = before.load
    hub, n, columns = bodies.hub_velocity, bodies.n, bodies.columns
    moving, spinning, pushed, lifted, stored = splat(0.0), splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    _repeat_forces(compliance, forces, n, columns)
    for group in range(0, n, WIDTH):
        there, at = count_from(group) < n, columns + group
        square = load(before.velocity, group) * load(bodies.velocity, group)
        square += load(before.velocity, at) * load(bodies.velocity, at)
        moving += select(there, square, 0.0)
        spinning += select(there, load(before.spin, group) * load(bodies.spin, group), 0.0)
        ax, ay = load(before.acceleration, group), load(before.acceleration, at)
        pushed += select(there, ax * ax + ay * ay + 2.0 * drive.gravity * ay, 0.0)
        lifted += select(there, load(bodies.centre, at), 0.0)
        own = _contact_energy(compliance, bodies, forces, drive, before, group)
        stored += select(there, own, 0.0)
    kinetic = bodies.hub_mass * (before.hub_velocity[0] * hub[0] + before.hub_velocity[1] * hub[1])
    kinetic += bodies.mass * total(moving) + _turning(bodies.prescribed, bodies.inertia, total(spinning))
    ax, ay = before.hub_acceleration[0], before.hub_acceleration[1]
    pull = bodies.hub_mass * drive.gravity + radial_load
    pulled = bodies.hub_mass * (ax * ax + ay * ay) + 2.0 * pull * ay + bodies.mass * total(pushed)
    pulled = with_side_load(drive.history, pulled, -2.0 * side_load * ax)
    out[KINETIC] = 0.5 * kinetic
    out[ELASTIC] = 0.0
    # forces f from outside take the contacts ahead as well: what steps conserve holds dt²/24 Σ (m a − 2f)·a more
    out[CONTACT] = total(stored) + drive.dt * drive.dt / 24.0 * pulled
    out[WORK_GRAVITY] = -drive.gravity * (bodies.hub_mass * bodies.hub[1] + bodies.mass * total(lifted))


@part
def _turning(prescribed, inertia, squares):
    """Twice the energy of rollers that turn by the forces on them, J."""
    return inertia * squares if prescribed is None else 0.0


@verb
def _contact_energy(compliance, bodies, forces, drive, before, group):
    """Energy of eight rollers' contacts, as steps conserve it, J."""
    columns = bodies.columns
    own = compliance.across * load(forces.force, group) * load(forces.force, columns + group)
    for row in range(2):
        own += _curved(bodies, forces, drive, before, row, group) - _yet_to_give(bodies, forces, drive, row, group)
        others = load(forces.lifted, row * columns + group)
        others += 0.5 * coupled_approach(compliance, forces, forces.gained, row, group)
        own += others * load(forces.force, row * columns + group)
    own += _stored(compliance.inner, compliance, forces, INNER, columns, group)
    own += _stored(compliance.outer, compliance, forces, OUTER, columns, group)
    return own + _stored(compliance.between, compliance, forces, NEXT, columns, group)


@_contact_energy.of(Isolated)
def _isolated_energy(compliance, bodies, forces, drive, before, group):
    own = isolated_energy(compliance, forces, bodies.columns, group)
    for row in range(2):
        own += _curved(bodies, forces, drive, before, row, group) - _yet_to_give(bodies, forces, drive, row, group)
    return own


@_contact_energy.of(Tilted)
def _tilted_energy(compliance, bodies, forces, drive, before, group):
    own = tilted_energy(compliance, forces, bodies.columns, group)
    for row in range(2):
        own += _curved(bodies, forces, drive, before, row, group) - _yet_to_give(bodies, forces, drive, row, group)
    return own + _elastic_energy(compliance.between, compliance, forces, bodies.columns, group)


@part
def _elastic_energy(between, compliance, forces, columns, group):
    """Of eight rollers' bodies between contacts, of rollers that meet and of tractions, J."""
    if between is None:
        return splat(0.0)
    own = compliance.across * load(forces.force, group) * load(forces.force, columns + group)
    for row in range(2):
        at = row * columns + group
        others = load(forces.lifted, at) + 0.5 * coupled_approach(compliance, forces, forces.gained, row, group)
        T = load(forces.traction, at)
        rubbing = (0.5 * compliance.tangential[row]) * T * T
        own += others * load(forces.force, at) + select(load(forces.force, at) > 0.0, rubbing, 0.0)
    return own + _stored(between, compliance, forces, NEXT, columns, group)


@verb
def _repeat_forces(compliance, forces, n, columns):
    """Leave in `gained`, which the next step fills anew, the forces that raceways feel around."""
    _repeat_around(forces, n, columns)


@part
def _repeat_around(forces, n, columns):
    for row in range(2):
        for group in range(0, n, WIDTH):
            Q = load(forces.force, row * columns + group)
            store(forces.gained, row * forces.gained.shape[1] + forces.halo + group, Q)
        wrap(forces.gained, row, n, forces.halo)


@_repeat_forces.of(Isolated)
def _repeat_nothing(compliance, forces, n, columns):
    pass


@_repeat_forces.of(Tilted)
def _repeat_all(compliance, forces, n, columns):
    if compliance.between is not None:
        _repeat_around(forces, n, columns)
        repeat_moments(compliance.between, forces, n, columns)


@part
def _stored(law, compliance, forces, row, columns, group):
    """Energy of eight contacts' own law, J, as kicks take it, and of their tractions."""
    at = row * columns + group
    Q, T = load(forces.force, at), load(forces.traction, at)
    energy = stored_energy(Q, load(forces.approach, at), law.A, law.Q_line) + (0.5 * compliance.tangential[row]) * T * T
    return select(Q > 0.0, energy, 0.0)
