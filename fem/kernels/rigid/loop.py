"""The time loop of the reduced and the Lagrangian model: leapfrog steps of rigid bodies on contacts without mass.

CONTACT FORCES are found in `contacts` and given in `kick`, FRICTION is in `friction`, THE CAGE in `fem.kernels.cage`.
"""

from fem.kernels import mounts
from fem.kernels.cage import drift_cage, kick_cage, meet, rub, write_cage
from fem.kernels.columns import CONTACT
from fem.kernels.drive import FORCE_X, FORCE_Y, RATE_X, RATE_Y, follow, load_at, share_at, speed_of
from fem.kernels.jit import kernel, part
from fem.kernels.mounts import TWELFTH
from fem.kernels.rigid.contacts import find_forces
from fem.kernels.rigid.dampers import damp, note_damped, write_damped
from fem.kernels.rigid.kick import kick_contacts
from fem.kernels.rigid.paces import NEAR, take_pace
from fem.kernels.rigid.rays import hold, note_rays, roll, write_rays
from fem.kernels.rigid.samples import note_beyond, write_energies, write_motion
from fem.kernels.rigid.state import Step
from fem.kernels.rigid.strikes import note_radiated, radiate, write_radiated
from fem.kernels.tilts import turn_axes, write_axes


@kernel(nogil=True)
def advance_rigid(moving, drives, paces, first_row, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    Rows are those of the finite elements, `columns`. `moving`: bodies, contacts, forces and velocities before kicks.
    `drives`, `paces`: of steps of two lengths, see `paces`; else one drive, and None.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    bodies, contacts, forces, before = moving
    in_row = 1 if paces is None else paces.sections
    for place in range(samples.shape[0] * in_row):
        section, inside = first_row * in_row + place, 0
        drive, count = (drives[0], stride) if paces is None else (drives[paces.now[0]], paces.counts[paces.now[0]])
        while inside < count:
            step = Step(bodies, contacts, forces, before, drive, (section * count + inside) * drive.dt)
            for component in range(2):  # velocities before the kick: a sample needs those of both half steps
                before.hub_velocity[component] = bodies.hub_velocity[component]
                for j in range(bodies.columns):
                    before.velocity[component, j] = bodies.velocity[component, j]
            for j in range(bodies.columns):
                before.spin[j] = bodies.spin[j]
            follow(drive, step.time)
            if bodies.cage is not None:
                meet(bodies.cage, speed_of(drive), drive.dt)
            if bodies.prescribed is not None:
                roll(bodies.prescribed, step)
            push = find_forces(step, inside)
            load = load_at(drive, step.time)
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
            _work_load(bodies, before, drive, load, step.time)
            _drift(bodies, drive)
            inside += 1
            body = mounts.lost(bodies.hub_velocity, bodies)
            if body != -2:
                count = stride if paces is None else paces.counts[NEAR]  # in short steps
                short = inside if paces is None else inside * count // paces.counts[paces.now[0]]
                return mounts.NOT_FINITE, section * count + short, body
    return mounts.DONE, 0, -2


@part
def _accelerate(step, push, load):
    """Accelerations of hub and outer ring by all that has a potential; `before` keeps load and drive's work.

    `push` : N, of the raceways' contacts on hub and outer ring: x, y, x, y.
    """
    bodies, before, drive, shaft, housing = step.bodies, step.before, step.drive, step.bodies.shaft, step.bodies.housing
    before.load[0], before.load[1], before.driven[0] = load[0], load[1], drive.sums[1]
    before.hub_acceleration[0] = (push[0] + load[0]) / bodies.hub_mass
    before.hub_acceleration[1] = (push[1] - load[1]) / bodies.hub_mass - drive.gravity
    if shaft is not None:
        for k in range(2):
            before.hub_acceleration[k] -= shaft.stiffness / shaft.mass * shaft.place[k]
    if housing is not None:
        pull, ring = housing.stiffness, before.ring_acceleration
        ring[0] = (push[2] - pull * housing.place[0]) / housing.mass
        ring[1] = (push[3] - pull * housing.place[1]) / housing.mass - drive.gravity


@part
def _kick(step, push, load):
    """Kick the hub by contacts and load, N, then all other bodies and what acts on these, in their order.

    Springs of shaft and housing are taken ahead as the contacts' forces are: see `kick`.
    """
    bodies, forces, drive, before = step.bodies, step.forces, step.drive, step.before
    dt, shaft, housing = drive.dt, bodies.shaft, bodies.housing
    over, ahead, acceleration = dt / bodies.hub_mass, TWELFTH * dt * dt, before.hub_acceleration
    bodies.hub_velocity[0] += over * (push[0] + load[0])
    bodies.hub_velocity[1] += over * (push[1] - load[1]) - drive.gravity * dt
    if shaft is not None:
        mounts.kick_shaft(shaft, dt, shaft.place[0] + ahead * acceleration[0], shaft.place[1] + ahead * acceleration[1])
    if housing is not None:
        ahead = ahead * housing.stiffness
        housing.impulse[0] += dt * (push[2] - ahead * before.ring_acceleration[0])
        housing.impulse[1] += dt * (push[3] - ahead * before.ring_acceleration[1])
        mounts.kick_housing(housing, drive)
    if bodies.cage is not None:
        _kick_cage(bodies.cage, bodies, drive)
    if forces.radiation is not None:
        radiate(forces.radiation, step)
    hold(bodies.prescribed, bodies, drive, step.time)
    if forces.dampers is not None:
        damp(forces.dampers, step)


@part
def _kick_cage(pair, bodies, drive):
    """The cage's kick, and its forces on rollers and guiding ring, whose dashpots take their share of it."""
    riders, over, ring = pair.riders, 1.0 / bodies.mass, pair.ring
    for component in range(2):
        for j in range(bodies.n):
            bodies.velocity[component, j] += riders.body_impulse[component, j] * over
            riders.body_impulse[component, j] = 0.0
    if ring is not None:
        for k in range(2):
            ring.velocity[k] += ring.impulse[k] / ring.mass
            ring.impulse[k] = 0.0
    kick_cage(pair.cage, drive)
    rub(pair, drive.dt)
    for j in range(bodies.n):
        bodies.spin[j] += riders.turn_kick[j]
        riders.turn_kick[j] = 0.0
    if bodies.prescribed is not None:  # the work of what keeps the rollers' spin against what rubs on them
        for j in range(bodies.n):
            drive.sums[1] += drive.dt * pair.cage.pockets.given[1, j] * riders.radius * riders.spin[j]
    if ring is not None:
        drive.sums[1] -= ring.speed[0] * ring.rubbed[2]
        mounts.settle(bodies.shaft, drive.dt)
        mounts.settle(bodies.housing, drive.dt)


@part
def _write(step, out):
    bodies, forces, drive = step.bodies, step.forces, step.drive
    write_motion(step, out)
    write_energies(step, out)
    note_beyond(bodies, forces)
    if bodies.shaft is not None:
        mounts.write_shaft(bodies.shaft, drive, out)
    housing = bodies.housing
    if housing is not None:  # the place that the springs' force is taken at, and what steps conserve beside
        mounts.write_housing(housing, drive, out)
        square, at, a = drive.dt * drive.dt, housing.column, step.before.ring_acceleration
        out[CONTACT] += square / 24.0 * housing.mass * (a[0] * a[0] + a[1] * a[1] + 2.0 * drive.gravity * a[1])
        x, y = housing.place[0] + TWELFTH * square * a[0], housing.place[1] + TWELFTH * square * a[1]
        out[at + mounts.PLACE_X], out[at + mounts.PLACE_Y] = x, y
        out[at + mounts.STORED] = 0.5 * housing.stiffness * (x * x + y * y)
    if bodies.cage is not None:
        write_cage(bodies.cage.cage, drive, out)
    if bodies.tilts is not None:
        write_axes(bodies.tilts, bodies, forces, drive, out)
    if forces.radiation is not None:
        write_radiated(forces.radiation, step, out)
    if bodies.prescribed is not None:
        write_rays(bodies.prescribed, step, out)
    if forces.dampers is not None:
        write_damped(forces.dampers, step, out)


@part
def _work_load(bodies, before, drive, load, time):
    """Count the work of the load, by the velocities before and after the whole kick.

    The potential of forces taken ahead changes with the load.
    """
    sums, dt, a, history = drive.sums, drive.dt, before.hub_acceleration, drive.history
    sums[0] -= 0.5 * dt * load[1] * (before.hub_velocity[1] + bodies.hub_velocity[1])
    sums[0] += 0.5 * dt * load[0] * (before.hub_velocity[0] + bodies.hub_velocity[0])
    if history is None:
        if time < drive.ramp:
            grown = drive.radial_load * share_at(drive, time + dt) - load[1]
            sums[0] += dt * dt / 12.0 * a[1] * grown
    else:
        now, more = history.now, share_at(drive, time + dt)
        grown = more - share_at(drive, time)
        x = grown * now[FORCE_X] + more * dt * now[RATE_X]
        y = grown * now[FORCE_Y] + more * dt * now[RATE_Y]
        sums[0] -= dt * dt / 12.0 * (a[0] * x + a[1] * y)


@part
def _drift(bodies, drive):
    for component in range(2):
        bodies.hub[component] += drive.dt * bodies.hub_velocity[component]
        for j in range(bodies.columns):
            bodies.centre[component, j] += drive.dt * bodies.velocity[component, j]
    for j in range(bodies.columns):
        bodies.turn[j] += drive.dt * bodies.spin[j]
    if bodies.shaft is not None:
        mounts.drift_shaft(bodies.shaft, drive)
    if bodies.housing is not None:
        mounts.drift_housing(bodies.housing, drive)
    if bodies.cage is not None:
        drift_cage(bodies.cage.cage, drive)
    if bodies.tilts is not None:
        turn_axes(bodies.tilts, drive)
