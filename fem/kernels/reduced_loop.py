"""The time loop of the reduced model: leapfrog steps of rigid bodies on elastic contacts without mass."""

from fem.kernels.bodies import DONE, NOT_FINITE, add_motion, drift_body, kick_body, lost
from fem.kernels.cage import push_ring_as_a_whole
from fem.kernels.cage_kernels import meet, rub
from fem.kernels.drive import (
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
    with_side_load,
)
from fem.kernels.isolated_contacts import Isolated, find_isolated, isolated_damping, kick_isolated
from fem.kernels.jit import kernel, part, verb
from fem.kernels.prescribed_rollers import hold, note_held, prescribe, write_held
from fem.kernels.reduced_contacts import corrected_forces, estimate_forces, gauss_seidel_sweeps
from fem.kernels.reduced_damping import (
    damp_contacts,
    damping_coefficients,
    note_damped,
    write_damped_moments,
    write_damping,
)
from fem.kernels.reduced_friction import press_neighbours
from fem.kernels.reduced_housing import (
    TWELFTH,
    accelerate_ring,
    drift_ring,
    kick_ring,
    settle_ring,
    write_ring,
)
from fem.kernels.reduced_kick import kick
from fem.kernels.reduced_modes import carried_by, drift_modes, kick_rings
from fem.kernels.reduced_paces import drive_of, sections_of, short_steps, steps_of, take_pace
from fem.kernels.reduced_radiation import note_radiated, radiate, write_radiation
from fem.kernels.reduced_samples import note_beyond, write_energies, write_motion
from fem.kernels.reduced_surfaces import AGAIN, follow_angles
from fem.kernels.sample_kernels import (
    DISSIPATED,
    KINETIC,
    WORK_DRIVE,
    WORK_LOAD,
)
from fem.kernels.shaft import pull, settle
from fem.kernels.state import LoadHistory
from fem.kernels.tilted_contacts import Tilted, find_tilted, kick_tilted
from fem.kernels.tilts import drift_tilts, write_tilts


@kernel(nogil=True)
def advance_reduced(bodies, compliance, forces, drives, before, paces, first_row, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Rows are those of the finite elements, `sample_kernels.write_sample`. `drives`, `paces`: of steps of two lengths,
    see `reduced_paces`; else one drive, and None.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    in_row = sections_of(paces)
    for place in range(samples.shape[0] * in_row):
        section, drive, inside, count = first_row * in_row + place, drive_of(paces, drives), 0, steps_of(paces, stride)
        while inside < count:
            time = (section * count + inside) * drive.dt
            _remember(bodies, before)
            follow(drive.history, time, drive.dt)
            prescribe(bodies.prescribed, bodies, before, drive, time)
            _meet_cage(bodies.cage, drive)
            hub_x, hub_y, ring_x, ring_y = _find_forces(compliance, bodies, forces, drive, time, inside)
            side_load, radial_load = load_at(drive.history, drive, time)
            before.hub_acceleration[0] = with_side_load(drive.history, hub_x, side_load) / bodies.hub_mass
            before.hub_acceleration[1] = (hub_y - radial_load) / bodies.hub_mass - drive.gravity
            _hold_hub(bodies.shaft, before.hub_acceleration)
            accelerate_ring(bodies.housing, before, ring_x, ring_y, drive.gravity)
            given = drive.sums[1]
            hub_x, hub_y, ring_x, ring_y = _kick_rollers(compliance, bodies, forces, drive, before)
            kick_rings(bodies.vibrations, drive, side_load, radial_load)
            over = drive.dt / bodies.hub_mass
            bodies.hub_velocity[0] += over * with_side_load(drive.history, hub_x, side_load)
            bodies.hub_velocity[1] += over * (hub_y - radial_load) - drive.gravity * drive.dt
            _pull_hub(bodies.shaft, before.hub_acceleration, drive.dt)
            kick_ring(bodies.housing, before, drive, ring_x, ring_y)
            _push_cage(bodies.cage, bodies, drive)
            radiate(forces.radiation, bodies, compliance, forces, before, drive)
            hold(bodies.prescribed, bodies, drive, time)
            _damp(forces.dampers, bodies, compliance, forces, before, drive, time)
            note_held(bodies.prescribed, bodies, forces, before, drive)
            note_radiated(forces.radiation, bodies, forces, before, drive)
            if inside == 0 and section % in_row == 0:
                out = samples[place // in_row]
                write_motion(bodies, forces, drive, before, out, time)
                write_energies(bodies, compliance, forces, drive, before, out, (side_load, radial_load))
                half, carried = 0.5 * drive.dt, carried_by(bodies.vibrations, 1)
                work = drive.sums[0] - half * radial_load * (before.hub_velocity[1] + carried[1])
                out[WORK_LOAD] = with_side_load(
                    drive.history, work, half * side_load * (before.hub_velocity[0] + carried[0])
                )
                out[WORK_DRIVE] = 0.5 * (given + drive.sums[1])
                out[DISSIPATED] = drive.sums[2]
                write_damping(forces.dampers, bodies.n, out)
                write_radiation(forces.radiation, bodies.n, out)
                note_beyond(bodies, forces)
                _write_cage(bodies.cage, drive, out)
                _write_shaft(bodies.shaft, drive, out)
                write_ring(bodies.housing, before, drive, out)
                write_held(bodies.prescribed, bodies, drive, time, out)
                write_tilts(bodies.tilts, bodies, forces, drive, out)
                write_damped_moments(forces.dampers, bodies, out)
            if inside == 0:
                take_pace(paces, bodies, compliance, forces, drives, before, time, (side_load, radial_load), given)
                drive, count = drive_of(paces, drives), steps_of(paces, stride)
            past, next_ = carried_by(bodies.vibrations, 1), carried_by(bodies.vibrations, 2)
            work = before.hub_velocity[1] + bodies.hub_velocity[1]
            work += past[1] + next_[1]
            drive.sums[0] -= 0.5 * drive.dt * radial_load * work
            work = before.hub_velocity[0] + bodies.hub_velocity[0] + past[0] + next_[0]
            drive.sums[0] = with_side_load(drive.history, drive.sums[0], 0.5 * drive.dt * side_load * work)
            _change_ahead(drive.history, drive, before, time, radial_load)
            _drift(bodies, drive.dt)
            drift_tilts(bodies.tilts, bodies, drive)
            _drift_cage(bodies.cage, drive)
            _drift_shaft(bodies.shaft, drive)
            drift_ring(bodies.housing, drive)
            inside += 1
            body = lost(bodies.hub_velocity, bodies)
            if body != -2:
                return NOT_FINITE, short_steps(paces, stride, section, inside), body
    return DONE, 0, -2


@verb
def _find_forces(compliance, bodies, forces, drive, time, inside):
    """Forces of all contacts of raceways; their sums on hub and outer ring, N."""
    if inside % AGAIN == 0:
        follow_angles(bodies, compliance, forces)
    estimate_forces(bodies, compliance, forces, drive, turn_at(drive.history, drive, time))
    gauss_seidel_sweeps(bodies.vibrations, bodies, compliance, forces)
    return corrected_forces(bodies, compliance, forces)


@verb
def _kick_rollers(compliance, bodies, forces, drive, before):
    """The rollers' kick by all contacts; what these give hub and outer ring, N."""
    press_neighbours(bodies, compliance, forces, drive, before)
    return kick(bodies, compliance, forces, drive, before)


_find_forces.of(Isolated)(find_isolated)
_kick_rollers.of(Isolated)(kick_isolated)
_find_forces.of(Tilted)(find_tilted)
_kick_rollers.of(Tilted)(kick_tilted)
damping_coefficients.of(Isolated)(isolated_damping)


@part
def _damp(dampers, bodies, compliance, forces, before, drive, time):
    """The contacts' dampers, after which rays hold rollers once more."""
    if dampers is not None:
        damp_contacts(dampers, bodies, compliance, forces, before, drive)
        hold(bodies.prescribed, bodies, drive, time)
        note_damped(dampers, bodies, forces, before, drive)


@verb
def _change_ahead(history, drive, before, time, radial_load):
    """The potential of forces taken ahead changes with the load."""
    if time < drive.ramp:
        grown = radial_load_at(drive, time + drive.dt) - radial_load
        drive.sums[0] += drive.dt * drive.dt / 12.0 * before.hub_acceleration[1] * grown


@_change_ahead.of(LoadHistory)
def _change_all_ahead(history, drive, before, time, radial_load):
    now, more = history.now, share_at(drive, time + drive.dt)
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
        meet(cage, speed_of(drive.history, drive), drive.dt)


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
    _turn_rollers(bodies.prescribed, cage, drive)
    _turn_drive(cage.ring, drive)
    if cage.ring is not None:
        settle(bodies.shaft, drive.dt)
        settle_ring(bodies.housing, drive.dt)


@part
def _turn_rollers(prescribed, pair, drive):
    """The work of what keeps the rollers' spin against what rubs on them in the pockets."""
    if prescribed is not None:
        riders, pockets = pair.riders, pair.cage.pockets
        for j in range(riders.n):
            drive.sums[1] += drive.dt * pockets.given[1, j] * riders.radius * riders.spin[j]


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
    drift_modes(bodies.vibrations, dt)
