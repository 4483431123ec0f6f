"""The time loop of the reduced and the Lagrangian model: leapfrog steps of rigid bodies on contacts without mass."""

from fem.kernels.bodies import DONE, NOT_FINITE, add_motion, drift_body, lost
from fem.kernels.cage import meet
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
    with_side_load,
)
from fem.kernels.jit import kernel, part
from fem.kernels.rigid.contacts import find_forces
from fem.kernels.rigid.dampers import damp, note_damped, write_damped
from fem.kernels.rigid.kick import kick_contacts
from fem.kernels.rigid.mounts import accelerate_ring, kick_cage, kick_ring, kick_shaft, write_ring
from fem.kernels.rigid.paces import NEAR, take_pace
from fem.kernels.rigid.rays import hold, note_rays, roll, write_rays
from fem.kernels.rigid.samples import note_beyond, write_energies, write_motion, write_works
from fem.kernels.rigid.state import Step
from fem.kernels.rigid.strikes import note_radiated, radiate, write_radiated
from fem.kernels.sample_kernels import KINETIC
from fem.kernels.tilts import turn_axes, write_axes


@kernel(nogil=True)
def advance_rigid(moving, drives, paces, first_row, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Rows are those of the finite elements, `sample_kernels.write_sample`. `moving`: bodies, contacts, forces and
    velocities before kicks. `drives`, `paces`: of steps of two lengths, see `paces`; else one drive, and None.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    bodies, contacts, forces, before = moving
    in_row = 1 if paces is None else paces.sections
    for place in range(samples.shape[0] * in_row):
        section, inside = first_row * in_row + place, 0
        drive, count = (drives[0], stride) if paces is None else (drives[paces.now[0]], paces.counts[paces.now[0]])
        while inside < count:
            step = Step(bodies, contacts, forces, before, drive, (section * count + inside) * drive.dt)
            _remember(step)
            follow(drive.history, step.time, drive.dt)
            if bodies.cage is not None:
                meet(bodies.cage, speed_of(drive.history, drive), drive.dt)
            if bodies.prescribed is not None:
                roll(bodies.prescribed, step)
            push = find_forces(step, inside)
            load = load_at(drive.history, drive, step.time)
            _accelerate(step, push, load)
            push = kick_contacts(step)
            _kick(step, push, load)
            if forces.radiation is not None:
                note_radiated(forces.radiation, step)
            if bodies.prescribed is not None:
                note_rays(bodies.prescribed, step)
            if forces.dampers is not None:
                note_damped(forces.dampers, step)
            if inside == 0 and section % in_row == 0:
                _write(step, samples[place // in_row])
            if paces is not None:
                if inside == 0:
                    take_pace(paces, step, drives)
                    drive, count = drives[paces.now[0]], paces.counts[paces.now[0]]
            _work_load(bodies, before, drive, load)
            _change_ahead(drive, before, step.time, load[1])
            _drift(bodies, drive)
            inside += 1
            body = lost(bodies.hub_velocity, bodies)
            if body != -2:
                count = stride if paces is None else paces.counts[NEAR]  # in short steps
                short = inside if paces is None else inside * count // paces.counts[paces.now[0]]
                return NOT_FINITE, section * count + short, body
    return DONE, 0, -2


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
def _accelerate(step, push, load):
    """Accelerations of hub and outer ring by all that has a potential; `before` keeps load and drive's work."""
    bodies, before, drive, mass = step.bodies, step.before, step.drive, step.bodies.hub_mass
    before.load[0], before.load[1], before.driven[0] = load[0], load[1], drive.sums[1]
    before.hub_acceleration[0] = with_side_load(drive.history, push[0], load[0]) / mass
    before.hub_acceleration[1] = (push[1] - load[1]) / mass - drive.gravity
    if bodies.shaft is not None:
        for k in range(2):
            before.hub_acceleration[k] -= bodies.shaft.stiffness / bodies.shaft.mass * bodies.shaft.place[k]
    if bodies.housing is not None:
        accelerate_ring(bodies.housing, step, push)


@part
def _kick(step, push, load):
    """Kick the hub by contacts and load, N, then all other bodies and what acts on these, in their order."""
    bodies, forces, drive = step.bodies, step.forces, step.drive
    over = drive.dt / bodies.hub_mass
    bodies.hub_velocity[0] += over * with_side_load(drive.history, push[0], load[0])
    bodies.hub_velocity[1] += over * (push[1] - load[1]) - drive.gravity * drive.dt
    if bodies.shaft is not None:
        kick_shaft(bodies.shaft, step)
    if bodies.housing is not None:
        kick_ring(bodies.housing, step, push)
    if bodies.cage is not None:
        kick_cage(bodies.cage, step)
    if forces.radiation is not None:
        radiate(forces.radiation, step)
    if bodies.prescribed is not None:
        hold(bodies.prescribed, bodies, drive, step.time)
    if forces.dampers is not None:
        damp(forces.dampers, step)


@part
def _write(step, out):
    bodies, forces, drive = step.bodies, step.forces, step.drive
    write_motion(step, out)
    write_energies(step, out)
    write_works(step, out)
    note_beyond(bodies, forces)
    if bodies.shaft is not None:
        add_motion(bodies.shaft, drive, out, KINETIC)
    if bodies.housing is not None:
        write_ring(bodies.housing, step, out)
    if bodies.cage is not None:
        add_motion(bodies.cage.cage, drive, out, KINETIC)
    if bodies.tilts is not None:
        write_axes(bodies.tilts, bodies, forces, drive, out)
    if forces.radiation is not None:
        write_radiated(forces.radiation, step, out)
    if bodies.prescribed is not None:
        write_rays(bodies.prescribed, step, out)
    if forces.dampers is not None:
        write_damped(forces.dampers, step, out)


@part
def _work_load(bodies, before, drive, load):
    """Count the work of the load, by the velocities before and after the whole kick."""
    work = before.hub_velocity[1] + bodies.hub_velocity[1]
    drive.sums[0] -= 0.5 * drive.dt * load[1] * work
    work = before.hub_velocity[0] + bodies.hub_velocity[0]
    drive.sums[0] = with_side_load(drive.history, drive.sums[0], 0.5 * drive.dt * load[0] * work)


@part
def _change_ahead(drive, before, time, radial_load):
    """The potential of forces taken ahead changes with the load."""
    a, history = before.hub_acceleration, drive.history
    if history is None:
        if time < drive.ramp:
            grown = radial_load_at(drive, time + drive.dt) - radial_load
            drive.sums[0] += drive.dt * drive.dt / 12.0 * a[1] * grown
    else:
        now, more = history.now, share_at(drive, time + drive.dt)
        grown = more - share_at(drive, time)
        x = grown * now[FORCE_X] + more * drive.dt * now[RATE_X]
        y = grown * now[FORCE_Y] + more * drive.dt * now[RATE_Y]
        drive.sums[0] -= drive.dt * drive.dt / 12.0 * (a[0] * x + a[1] * y)


@part
def _drift(bodies, drive):
    """Move all bodies on by a step."""
    for component in range(2):
        bodies.hub[component] += drive.dt * bodies.hub_velocity[component]
        for j in range(bodies.columns):
            bodies.centre[component, j] += drive.dt * bodies.velocity[component, j]
    for j in range(bodies.columns):
        bodies.turn[j] += drive.dt * bodies.spin[j]
    if bodies.shaft is not None:
        drift_body(bodies.shaft, drive)
    if bodies.housing is not None:
        drift_body(bodies.housing, drive)
    if bodies.cage is not None:
        drift_body(bodies.cage.cage, drive)
    if bodies.tilts is not None:
        turn_axes(bodies.tilts, drive)
