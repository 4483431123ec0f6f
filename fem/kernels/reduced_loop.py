"""The time loop of the reduced model: leapfrog steps of rigid bodies on elastic contacts without mass."""

from math import sqrt

from fem.kernels.cage_guide import given_beyond, push_ring_as_a_whole
from fem.kernels.cage_kernels import meet, rub
from fem.kernels.course_kernels import (
    FORCE_X,
    FORCE_Y,
    RATE_X,
    RATE_Y,
    follow,
    load_at,
    radial_load_at,
    share_at,
    speed_of,
    turn_at,
    with_aside,
)
from fem.kernels.ending import DONE, NOT_FINITE, lost
from fem.kernels.ground_dashpots import settle
from fem.kernels.jit import kernel, part, verb
from fem.kernels.law import contact_energy
from fem.kernels.other_bodies import add_motion, drift_body, kick_body
from fem.kernels.reduced_angles import AGAIN, follow_angles
from fem.kernels.reduced_contacts import estimate_forces, set_right, sweep_again
from fem.kernels.reduced_damping import damp_contacts, write_damping
from fem.kernels.reduced_friction import press_neighbours
from fem.kernels.reduced_housing import (
    TWELFTH,
    accelerate_ring,
    drift_ring,
    kick_ring,
    ring_place,
    ring_rates,
    settle_ring,
    write_ring,
)
from fem.kernels.reduced_kick import kick
from fem.kernels.reduced_modes import carried_by, drift_modes, kick_rings, vibration_energies
from fem.kernels.reduced_radiation import note_radiated, radiate, write_radiation
from fem.kernels.reduced_state import INNER, NEXT, OUTER
from fem.kernels.sample_kernels import (
    CONTACT,
    DISSIPATED,
    ELASTIC,
    HUB_AX,
    HUB_AY,
    HUB_VX,
    HUB_VY,
    HUB_X,
    HUB_Y,
    KINETIC,
    N_SCALARS,
    TIME,
    WORK_DRIVE,
    WORK_GRAVITY,
    WORK_LOAD,
)
from fem.kernels.shaft_kernels import pull
from fem.kernels.state import Course

TOUCHING = 1.05  # over a roller's diameter: centres further apart are out of each other's reach


@kernel(nogil=True)
def advance_reduced(bodies, compliance, forces, drive, before, first_step, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Rows are those of the finite elements, `sample_kernels.write_sample`.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    step = first_step
    for row in range(samples.shape[0]):
        for inside in range(stride):
            time = step * drive.dt
            _remember(bodies, before)
            follow(drive.course, time, drive.dt)
            _meet_cage(bodies.cage, drive)
            if inside % AGAIN == 0:
                follow_angles(bodies, compliance, forces)
            estimate_forces(bodies, compliance, forces, drive, turn_at(drive.course, drive, time))
            sweep_again(bodies.vibrations, bodies, compliance, forces)
            hub_x, hub_y, ring_x, ring_y = set_right(bodies, compliance, forces)
            aside, radial_load = load_at(drive.course, drive, time)
            before.hub_acceleration[0] = with_aside(drive.course, hub_x, aside) / bodies.hub_mass
            before.hub_acceleration[1] = (hub_y - radial_load) / bodies.hub_mass - drive.gravity
            _hold_hub(bodies.shaft, before.hub_acceleration)
            accelerate_ring(bodies.housing, before, ring_x, ring_y, drive.gravity)
            given = drive.sums[1]
            press_neighbours(bodies, compliance, forces, drive, before, 2.0 * bodies.radius * TOUCHING)
            hub_x, hub_y, ring_x, ring_y = kick(bodies, compliance, forces, drive, before)
            kick_rings(bodies.vibrations, drive, aside, radial_load)
            over = drive.dt / bodies.hub_mass
            bodies.hub_velocity[0] += over * with_aside(drive.course, hub_x, aside)
            bodies.hub_velocity[1] += over * (hub_y - radial_load) - drive.gravity * drive.dt
            _pull_hub(bodies.shaft, before.hub_acceleration, drive.dt)
            kick_ring(bodies.housing, before, drive, ring_x, ring_y)
            _push_cage(bodies.cage, bodies, drive)
            radiate(forces.radiation, bodies, compliance, forces, before, drive)
            damp_contacts(forces.dampers, bodies, compliance, forces, before, drive)
            note_radiated(forces.radiation, bodies, forces, before, drive)
            if inside == 0:
                out = samples[row]
                _write_motion(bodies, forces, drive, before, out, time)
                _write_energies(bodies, compliance, forces, drive, before, out, (aside, radial_load))
                half, carried = 0.5 * drive.dt, carried_by(bodies.vibrations, 1)
                work = drive.sums[0] - half * radial_load * (before.hub_velocity[1] + carried[1])
                out[WORK_LOAD] = with_aside(drive.course, work, half * aside * (before.hub_velocity[0] + carried[0]))
                out[WORK_DRIVE] = 0.5 * (given + drive.sums[1])
                out[DISSIPATED] = drive.sums[2]
                write_damping(forces.dampers, bodies.n, out)
                write_radiation(forces.radiation, bodies.n, out)
                _note_beyond(bodies, forces)
                _write_cage(bodies.cage, drive, out)
                _write_shaft(bodies.shaft, drive, out)
                write_ring(bodies.housing, before, drive, out)
            past, next_ = carried_by(bodies.vibrations, 1), carried_by(bodies.vibrations, 2)
            work = before.hub_velocity[1] + bodies.hub_velocity[1]
            work += past[1] + next_[1]
            drive.sums[0] -= 0.5 * drive.dt * radial_load * work
            work = before.hub_velocity[0] + bodies.hub_velocity[0] + past[0] + next_[0]
            drive.sums[0] = with_aside(drive.course, drive.sums[0], 0.5 * drive.dt * aside * work)
            _change_ahead(drive.course, drive, before, time, radial_load)
            _drift(bodies, drive.dt)
            _drift_cage(bodies.cage, drive)
            _drift_shaft(bodies.shaft, drive)
            drift_ring(bodies.housing, drive)
            step += 1
            body = lost(bodies.hub_velocity, bodies)
            if body != -2:
                return NOT_FINITE, step, body
    return DONE, step, -2


@verb
def _change_ahead(course, drive, before, time, radial_load):
    """The potential of forces taken ahead changes with the load."""
    if time < drive.ramp:
        grown = radial_load_at(drive, time + drive.dt) - radial_load
        drive.sums[0] += drive.dt * drive.dt / 12.0 * before.hub_acceleration[1] * grown


@_change_ahead.of(Course)
def _change_all_ahead(course, drive, before, time, radial_load):
    now, more = course.now, share_at(drive, time + drive.dt)
    grown = more - share_at(drive, time)
    x = grown * now[FORCE_X] + more * drive.dt * now[RATE_X]
    y = grown * now[FORCE_Y] + more * drive.dt * now[RATE_Y]
    a = before.hub_acceleration
    drive.sums[0] -= drive.dt * drive.dt / 12.0 * (a[0] * x + a[1] * y)


@part
def _hold_hub(shaft, acceleration):
    """The shaft's springs accelerate the hub."""
    if shaft is not None:
        for k in range(2):
            acceleration[k] -= shaft.stiffness / shaft.mass * shaft.place[k]


@part
def _pull_hub(shaft, acceleration, dt):
    """The shaft's kick, its springs ahead as the contacts' forces are: see `reduced_contacts.kick`."""
    if shaft is not None:
        ahead, place = TWELFTH * dt * dt, shaft.place
        pull(shaft, dt, place[0] + ahead * acceleration[0], place[1] + ahead * acceleration[1])


@part
def _write_shaft(shaft, drive, out):
    if shaft is not None:
        add_motion(shaft, drive, out, KINETIC)


@part
def _drift_shaft(shaft, drive):
    if shaft is not None:
        drift_body(shaft, drive)


@part
def _meet_cage(cage, drive):
    if cage is not None:
        meet(cage, speed_of(drive.course, drive), drive.dt)


@part
def _push_cage(cage, bodies, drive):
    """The cage's kick, and its forces on rollers and hub."""
    if cage is None:
        return
    riders, over = cage.riders, 1.0 / bodies.mass
    for component in range(2):
        for j in range(bodies.n):
            bodies.velocity[component, j] += riders.body_impulse[component, j] * over
            riders.body_impulse[component, j] = 0.0
    push_ring_as_a_whole(cage.ring)
    kick_body(cage.cage, drive)
    rub(cage, drive.dt)
    for j in range(bodies.n):
        bodies.spin[j] += riders.turn_kick[j]
        riders.turn_kick[j] = 0.0
    _turn_drive(cage.ring, drive)
    if cage.ring is not None:
        settle(bodies.shaft, drive.dt)
        settle_ring(bodies.housing, drive.dt)


@part
def _turn_drive(ring, drive):
    """The drive's work against what rubs on the inner ring."""
    if ring is not None:
        drive.sums[1] -= ring.speed[0] * ring.rubbed[2]


@part
def _write_cage(cage, drive, out):
    if cage is not None:
        add_motion(cage.cage, drive, out, KINETIC)


@part
def _drift_cage(cage, drive):
    if cage is not None:
        drift_body(cage.cage, drive)


@part
def _remember(bodies, before):
    """Keep the velocities before a kick: a sample needs those of both half steps."""
    for component in range(2):
        before.hub_velocity[component] = bodies.hub_velocity[component]
        for j in range(bodies.columns):
            before.velocity[component, j] = bodies.velocity[component, j]
    for j in range(bodies.columns):
        before.spin[j] = bodies.spin[j]


@part
def _drift(bodies, dt):
    for component in range(2):
        bodies.hub[component] += dt * bodies.hub_velocity[component]
        for j in range(bodies.columns):
            bodies.centre[component, j] += dt * bodies.velocity[component, j]
    for j in range(bodies.columns):
        bodies.turn[j] += dt * bodies.spin[j]
    drift_modes(bodies.vibrations, bodies.columns, dt)


@part(inlined=False)
def _write_motion(bodies, forces, drive, before, out, time):
    """Places are those that forces and accelerations of the sample belong to: leapfrog's, dt²/12 of these ahead.

    By leapfrog's own a shaft's springs would miss the hub's balance by k dt²/12 of its acceleration.
    """
    out[TIME] = time
    ahead, a = TWELFTH * drive.dt * drive.dt, before.hub_acceleration
    x, y = carried_by(bodies.vibrations, 0)
    out[HUB_X], out[HUB_Y] = bodies.hub[0] + ahead * a[0] + x, bodies.hub[1] + ahead * a[1] + y
    x, y = carried_by(bodies.vibrations, 1)
    vx, vy = before.hub_velocity[0] + x, before.hub_velocity[1] + y
    x, y = carried_by(bodies.vibrations, 2)
    wx, wy = bodies.hub_velocity[0] + x, bodies.hub_velocity[1] + y
    out[HUB_VX], out[HUB_VY] = 0.5 * (vx + wx), 0.5 * (vy + wy)
    out[HUB_AX], out[HUB_AY] = (wx - vx) / drive.dt, (wy - vy) / drive.dt
    n = bodies.n
    for j in range(n):
        at = N_SCALARS + j
        out[at] = bodies.centre[0, j] + ahead * before.acceleration[0, j]
        out[at + n] = bodies.centre[1, j] + ahead * before.acceleration[1, j]
        out[at + 2 * n] = bodies.turn[j]
        out[at + 3 * n] = 0.5 * (before.spin[j] + bodies.spin[j])
        for row in range(3):
            out[at + (4 + row) * n] = forces.force[row, j]
        for row in range(2):
            out[at + (7 + row) * n] = forces.traction[row, j]


@part(inlined=False)
def _note_beyond(bodies, forces):
    """Keep the most that kicks have given the hub beyond forces: as contacts open and close, or repay energy."""
    x, y = given_beyond(bodies.cage)
    for j in range(bodies.n):
        more = _beyond(forces.dampers, forces.force[INNER, j], forces.kick[INNER, j], j)
        x -= more * forces.normal[INNER, 0, j]
        y -= more * forces.normal[INNER, 1, j]
    forces.beyond[0] = max(forces.beyond[0], sqrt(x * x + y * y))


@part
def _beyond(dampers, Q, P, j):
    """What a kick P gives beyond the force Q that a sample holds, N, each with the damper's."""
    if dampers is None:
        return P - Q
    F = dampers.force[INNER, j]
    return P + F - max(Q + F, 0.0)


@part
def _curved(bodies, forces, drive, before, row, j):
    """Part of the energy that steps along a chord conserve, J: the force times half the rise between chord and circle.

    Work at both ends of a step, along normals that turn by v dt/ρ, is the force's times the change of its overlap but
    for ¼·(v² dt²/ρ)·(the change of the force).
    """
    nx, ny = forces.normal[row, 0, j], forces.normal[row, 1, j]
    x, y = bodies.centre[0, j], bodies.centre[1, j]
    vx, vy = before.velocity[0, j] + bodies.velocity[0, j], before.velocity[1, j] + bodies.velocity[1, j]
    if row == INNER:
        x, y = x - bodies.hub[0], y - bodies.hub[1]
        vx -= before.hub_velocity[0] + bodies.hub_velocity[0]
        vy -= before.hub_velocity[1] + bodies.hub_velocity[1]
    else:
        ring_x, ring_y = ring_place(bodies.housing)
        past, next_ = ring_rates(bodies.housing)
        x, y = x - ring_x, y - ring_y
        vx, vy = vx - (past[0] + next_[0]), vy - (past[1] + next_[1])
    along = 0.5 * drive.dt * (vy * nx - vx * ny)
    risen = 0.25 * along * along / (x * nx + y * ny) * forces.force[row, j]
    return -risen if row == INNER else risen


@part
def _yet_to_give(bodies, forces, drive, row, j):
    """What a kick gives beyond its force has worked on the way here; in the step ahead it works once more, J."""
    beyond = forces.kick[row, j] - forces.force[row, j]
    if beyond == 0.0:
        return 0.0
    vx, vy = bodies.velocity[0, j], bodies.velocity[1, j]
    if row == INNER:
        vx, vy = bodies.hub_velocity[0] - vx, bodies.hub_velocity[1] - vy
    else:
        ring_vx, ring_vy = ring_rates(bodies.housing)[1]
        vx, vy = vx - ring_vx, vy - ring_vy
    return 0.5 * drive.dt * beyond * (vx * forces.normal[row, 0, j] + vy * forces.normal[row, 1, j])


@part(inlined=False)
def _write_energies(bodies, compliance, forces, drive, before, out, acting):
    """Kinetic energy as leapfrog conserves it, ½ v(t − dt/2)·M·v(t + dt/2), and all elastic energy as the contacts'.

    `acting`: load along x and against y, N.
    """
    aside, radial_load = acting
    hub, mass, n = bodies.hub_velocity, bodies.mass, bodies.n
    kinetic = bodies.hub_mass * (before.hub_velocity[0] * hub[0] + before.hub_velocity[1] * hub[1])
    ax, ay = before.hub_acceleration[0], before.hub_acceleration[1]
    pull = bodies.hub_mass * drive.gravity + radial_load
    pulled = bodies.hub_mass * (ax * ax + ay * ay) + 2.0 * pull * ay
    pulled = with_aside(drive.course, pulled, -2.0 * aside * ax)
    height, stored = bodies.hub_mass * bodies.hub[1], 0.0
    for j in range(n):
        for component in range(2):
            kinetic += mass * before.velocity[component, j] * bodies.velocity[component, j]
            pulled += mass * before.acceleration[component, j] ** 2
        pulled += 2.0 * mass * drive.gravity * before.acceleration[1, j]
        kinetic += bodies.inertia * before.spin[j] * bodies.spin[j]
        height += mass * bodies.centre[1, j]
        stored += _stored(compliance.inner, compliance, forces, INNER, j, forces.bracket)
        stored += _stored(compliance.outer, compliance, forces, OUTER, j, forces.bracket)
        stored += _stored(compliance.between, compliance, forces, NEXT, j, None)
        stored += compliance.across * forces.force[INNER, j] * forces.force[OUTER, j]
        for row in range(2):
            stored += _curved(bodies, forces, drive, before, row, j) - _yet_to_give(bodies, forces, drive, row, j)
        for row in range(2):
            stored += forces.lifted[0, row, j] * forces.force[row, j]
            if forces.force[row, j] > 0.0:
                for k in range(compliance.felt[row, 1]):
                    i = j + compliance.distance[k]
                    i = i + n if i < 0 else i - n if i >= n else i
                    stored += 0.5 * forces.along[row, k, j] * forces.force[row, j] * forces.force[row, i]
    vibrating, strained = vibration_energies(bodies.vibrations, n, bodies.columns)
    out[KINETIC] = 0.5 * kinetic + vibrating
    out[ELASTIC] = strained
    # forces f from outside take the contacts ahead as well: what steps conserve holds dt²/24 Σ (m a − 2f)·a more
    out[CONTACT] = stored + drive.dt * drive.dt / 24.0 * pulled
    out[WORK_GRAVITY] = -drive.gravity * height


@part
def _stored(law, compliance, forces, row, j, brackets):
    """Energy of one contact's own law, J, and of its traction."""
    T, B = forces.traction[row, j], law.B
    if forces.force[row, j] == 0.0:
        return 0.0
    if brackets is not None:
        B = brackets[row, j]
    return contact_energy(forces.force[row, j], law.A, B, law.Q_line) + 0.5 * compliance.tangential[row] * T * T
