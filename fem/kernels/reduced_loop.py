"""The time loop of the reduced and the Lagrangian model: leapfrog steps of rigid bodies on contacts without mass."""

# modules of parts, which give their code by being imported: see `rigid_parts`
from fem.kernels import reduced_cage  # noqa: F401
from fem.kernels.bodies import DONE, NOT_FINITE, lost
from fem.kernels.drive import (
    FORCE_X,
    FORCE_Y,
    RATE_X,
    RATE_Y,
    follow,
    load_at,
    radial_load_at,
    share_at,
    turn_at,
    with_side_load,
)
from fem.kernels.isolated_contacts import Isolated, find_isolated, isolated_damping, kick_isolated
from fem.kernels.jit import kernel, part, verb
from fem.kernels.reduced_contacts import corrected_forces, estimate_forces
from fem.kernels.reduced_damping import damping_coefficients
from fem.kernels.reduced_friction import press_neighbours
from fem.kernels.reduced_kick import kick
from fem.kernels.reduced_paces import drive_of, sections_of, short_steps, steps_of, take_pace
from fem.kernels.reduced_samples import note_beyond, write_energies, write_motion, write_works
from fem.kernels.reduced_surfaces import AGAIN, follow_angles
from fem.kernels.rigid_parts import (
    Step,
    accelerate_all,
    begin_all,
    drift_all,
    kick_all,
    note_all,
    parts_of,
    write_all,
)
from fem.kernels.state import LoadHistory
from fem.kernels.tilted_contacts import Tilted, find_tilted, kick_tilted


@kernel(nogil=True)
def advance_reduced(moving, drives, paces, first_row, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Rows are those of the finite elements, `sample_kernels.write_sample`. `moving`: bodies, compliance, forces and
    velocities before kicks. `drives`, `paces`: of steps of two lengths, see `reduced_paces`; else one drive, and None.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    bodies, compliance, forces, before = moving
    in_row, parts = sections_of(paces), parts_of(bodies, forces)
    for place in range(samples.shape[0] * in_row):
        section, drive, inside, count = first_row * in_row + place, drive_of(paces, drives), 0, steps_of(paces, stride)
        while inside < count:
            step = Step(bodies, compliance, forces, before, drive, (section * count + inside) * drive.dt)
            _remember(step)
            follow(drive.history, step.time, drive.dt)
            begin_all(parts, step)
            push = _find_forces(compliance, bodies, forces, drive, step.time, inside)
            load = load_at(drive.history, drive, step.time)
            _accelerate_hub(step, push, load)
            accelerate_all(parts, step, push)
            push = _kick_rollers(compliance, bodies, forces, drive, before)
            _kick_hub(step, push, load)
            kick_all(parts, step, push)
            note_all(parts, step)
            if inside == 0 and section % in_row == 0:
                out = samples[place // in_row]
                write_motion(bodies, forces, drive, before, out, step.time)
                write_energies(bodies, compliance, forces, drive, before, out)
                write_works(bodies, drive, before, out)
                note_beyond(bodies, forces)
                write_all(parts, step, out)
            if inside == 0:
                take_pace(paces, step, drives)
                drive, count = drive_of(paces, drives), steps_of(paces, stride)
            _work_load(bodies, before, drive, load)
            _change_ahead(drive.history, drive, before, step.time, load[1])
            _drift(bodies, drive.dt)
            drift_all(parts, Step(bodies, compliance, forces, before, drive, step.time))
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
def _remember(step):
    """Keep the velocities before a kick: a sample needs those of both half steps."""
    bodies, before = step.bodies, step.before
    for component in range(2):
        before.hub_velocity[component] = bodies.hub_velocity[component]
        for j in range(bodies.columns):
            before.velocity[component, j] = bodies.velocity[component, j]
    for j in range(bodies.columns):
        before.spin[j] = bodies.spin[j]


@part
def _accelerate_hub(step, push, load):
    """The hub's acceleration by contacts and load; `before` keeps the load, and the drive's work, for parts."""
    before, drive, mass = step.before, step.drive, step.bodies.hub_mass
    before.load[0], before.load[1], before.driven[0] = load[0], load[1], drive.sums[1]
    before.hub_acceleration[0] = with_side_load(drive.history, push[0], load[0]) / mass
    before.hub_acceleration[1] = (push[1] - load[1]) / mass - drive.gravity


@part
def _kick_hub(step, push, load):
    bodies, drive = step.bodies, step.drive
    over = drive.dt / bodies.hub_mass
    bodies.hub_velocity[0] += over * with_side_load(drive.history, push[0], load[0])
    bodies.hub_velocity[1] += over * (push[1] - load[1]) - drive.gravity * drive.dt


@part
def _work_load(bodies, before, drive, load):
    """Count the work of the load, by the velocities before and after the whole kick."""
    work = before.hub_velocity[1] + bodies.hub_velocity[1]
    drive.sums[0] -= 0.5 * drive.dt * load[1] * work
    work = before.hub_velocity[0] + bodies.hub_velocity[0]
    drive.sums[0] = with_side_load(drive.history, drive.sums[0], 0.5 * drive.dt * load[0] * work)


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
def _drift(bodies, dt):
    for component in range(2):
        bodies.hub[component] += dt * bodies.hub_velocity[component]
        for j in range(bodies.columns):
            bodies.centre[component, j] += dt * bodies.velocity[component, j]
    for j in range(bodies.columns):
        bodies.turn[j] += dt * bodies.spin[j]
