"""The time loop: leapfrog steps of the whole bearing."""

import fem.kernels.bore
import fem.kernels.disc_surface  # what contacts ask of each type of surface
import fem.kernels.housing_kernels  # and the loop of each further body
import fem.kernels.ring_surface
import fem.kernels.shaft
import fem.kernels.tilted_patches  # noqa: F401
from fem.kernels.bodies import DONE, NOT_FINITE, drift_others, end_kicks, kick_others, lost
from fem.kernels.body_damping import damp_bodies
from fem.kernels.cage import CagePair, rub_cage
from fem.kernels.contact_kernels import press_patches, push_neighbours, push_patches
from fem.kernels.damping_kernels import damp_contacts
from fem.kernels.drive import (
    clear_outer,
    follow,
    kick_hub,
    load_at,
    move_hub,
    note_outer,
    outer_of,
    step_of,
    turn_outer,
    with_side_load,
)
from fem.kernels.friction_solution import friction_contacts, pushes_later, slips_after, slips_before
from fem.kernels.jit import every, kernel, part
from fem.kernels.lane_functions import cosine_and_sine
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, fma
from fem.kernels.node_kernels import drift_nodes, kick_nodes, make_ready, slow_nodes
from fem.kernels.resolved_kernels import press_all_points
from fem.kernels.rigid_surfaces import settle, turn
from fem.kernels.sample_kernels import remember, write_sample

rub_cages = every(rub_cage, CagePair)


@part
def press_contacts(groups, bodies, contacts, drive, points):
    """Normal forces by the scene's contact model, and what they do to whole bodies; a run compiles the one it uses."""
    if points is None:
        press_patches(groups, bodies.rollers, bodies.surface, contacts, drive)
    else:
        press_all_points(groups, bodies.rollers, bodies.surface, contacts, drive)


@part
def push_surfaces(groups, bodies, contacts, drive, points):
    """The normal forces' impulses on surface nodes, where `press_contacts` has not given them already."""
    if contacts.dampers is not None and contacts.friction.whole is None:
        push_touching(groups, bodies, contacts, drive, contacts.dampers)  # the others with their dampers
    elif points is None or points.shift.shape[2] == 1:
        push_patches(groups, bodies.rollers, bodies.surface, contacts, None, drive.dt)
        settle(bodies.surface, bodies.rollers)


@part
def push_touching(groups, bodies, contacts, drive, dampers):
    """Impulses on surface nodes where rollers touch, if their dampers, which work one by one, need them given first."""
    if dampers is not None:
        push_neighbours(groups, bodies.rollers, bodies.surface, contacts, drive.dt)


@part
def kick(bodies, groups, contacts, drive, time, scratch):
    """Advance all velocities by one step at fixed positions, but for the rollers' turning as a whole (`drift`).

    Returns of this step the work of the load, J, and the moment on hub and ring about the origin other than the drive's
    and gravity's, N m s.
    """
    rollers, surface = bodies.rollers, bodies.surface
    follow(drive.history, time, drive.dt)
    _clear(rollers, drive)
    damp_bodies(bodies, drive, bodies.damping)
    press_contacts(groups, bodies, contacts, drive, contacts.points)
    friction, later = contacts.friction, False
    if friction.coefficient > 0.0:
        slips_before(groups, rollers, surface, contacts, scratch.still, drive.slowing == 0.0)
        later = pushes_later(friction, friction.whole)
    if later:
        push_touching(groups, bodies, contacts, drive, contacts.dampers)
    else:
        push_surfaces(groups, bodies, contacts, drive, contacts.points)
    _kick_rollers(rollers, drive)
    before_x, before = drive.velocity[0], drive.velocity[1]
    side_load, radial_load = load_at(drive.history, drive, time)
    moment = kick_hub(bodies.inner, drive, side_load, radial_load, scratch)
    kick_nodes(bodies, drive, scratch)
    kick_others(bodies.others, drive)
    rub_cages(groups, drive)
    for j in range(rollers.n):
        rollers.turn_kick[j] -= scratch.torque[j] / rollers.inertia
    damp_contacts(groups, bodies, contacts, contacts.dampers, drive, later)
    if friction.coefficient > 0.0:
        friction_contacts(groups, rollers, surface, contacts, drive, friction.overlapping, friction.whole, later)
    end_kicks(bodies.others, drive)
    make_ready(bodies, drive, scratch)
    slowed = drive.slowed
    moved_x = drive.dt * (before_x + drive.velocity[0]) + slowed[0, 0] + slowed[1, 0]
    moved_y = drive.dt * (before + drive.velocity[1]) + slowed[0, 1] + slowed[1, 1]
    work_load = -radial_load * 0.5 * moved_y  # friction may have moved a rigid hub
    work_load = with_side_load(drive.history, work_load, side_load * 0.5 * moved_x)
    return work_load, moment + drive.moment[1] - drive.moment[0] * drive.dt


@part
def _clear(rollers, drive):
    rollers.node_impulse[:] = 0.0
    rollers.body_impulse[:] = 0.0
    rollers.turn_kick[:] = 0.0
    drive.impulse[:] = 0.0
    drive.moment[:] = 0.0
    clear_outer(outer_of(drive.history))


@part
def _kick_rollers(rollers, drive):
    """Impulses on whole rollers, and their weight."""
    velocity, impulse, lightness = rollers.velocity, rollers.body_impulse, 1.0 / rollers.total_mass
    for j in range(rollers.n):
        velocity[0, j] += impulse[0, j] * lightness
        velocity[1, j] += impulse[1, j] * lightness - drive.gravity * drive.dt


@part
def slide(bodies, groups, contacts, drive, scratch):
    """Slow the fastest waves, and find how surfaces slip in the step to come.

    Returns the work that friction takes at this kick in the steps before and after it, J.
    """
    rollers, taken = bodies.rollers, 0.0
    for j in range(0, rollers.n, WIDTH):
        c, s = cosine_and_sine(load(rollers.increment, j))
        store(scratch.cosine, j, c)
        store(scratch.sine, j, s)
    slow_nodes(bodies, drive, scratch)
    if contacts.friction.coefficient > 0.0:
        taken = slips_after(groups, rollers, bodies.surface, contacts, drive.dt, drive.slowing == 0.0)
    return 0.5 * drive.dt * taken


@part
def drift(bodies, drive, scratch):
    """Advance all positions by one step."""
    dt, rollers = drive.dt, bodies.rollers
    _move_rollers(rollers, dt, scratch)
    step = step_of(drive.history, drive)
    cosine, sine = cosine_and_sine(step)
    drift_nodes(bodies, drive, scratch, cosine, sine)
    turn(bodies.surface, rollers, dt, scratch.torque)
    _turn_rollers(rollers, dt, scratch)
    move_hub(bodies.inner, drive, step)
    turn_outer(outer_of(drive.history))
    drift_others(bodies.others, drive)


@part
def _move_rollers(rollers, dt, scratch):
    """Move the centres of mass; what that is in the rollers' frames to `scratch`."""
    columns, over = rollers.columns, 1.0 / rollers.total_mass
    impulse, velocity, centre, shift = rollers.node_impulse, rollers.velocity, rollers.centre, scratch.shift
    for j in range(0, rollers.n, WIDTH):
        c, s = load(rollers.cosine, j), load(rollers.sine, j)
        px, py = load(impulse, j) * over, load(impulse, columns + j) * over
        store(shift, j, c * px + s * py)
        store(shift, columns + j, c * py - s * px)
        vx, vy = load(velocity, j) + px, load(velocity, columns + j) + py
        store(velocity, j, vx)
        store(velocity, columns + j, vy)
        store(centre, j, fma(dt, vx, load(centre, j)))
        store(centre, columns + j, fma(dt, vy, load(centre, columns + j)))


@part
def _turn_rollers(rollers, dt, scratch):
    """Turn the rollers' frames; `scratch.torque` holds inertia times the angle by which bodies lead them."""
    for j in range(0, rollers.n, WIDTH):
        increment = load(rollers.increment, j)
        angle = load(rollers.turn, j) + increment
        c, s = cosine_and_sine(angle)
        lead = load(scratch.torque, j) * (1.0 / rollers.inertia)
        turned = increment + lead - load(rollers.lead, j)
        store(rollers.turn, j, angle)
        store(rollers.cosine, j, c)
        store(rollers.sine, j, s)
        store(rollers.spin, j, turned * (1.0 / dt))
        store(rollers.increment, j, turned + lead)
        store(rollers.lead, j, lead)


@kernel(nogil=True)
def advance(bodies, groups, contacts, drive, scratch, first_step, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    `groups`: tuples of pairs of bodies; those of a group are of one type.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    step = first_step
    for row in range(samples.shape[0]):
        for inside in range(stride):
            time = step * drive.dt
            if inside == 0:
                remember(bodies, drive, scratch)
            work, moment = kick(bodies, groups, contacts, drive, time, scratch)
            if inside == 0:
                write_sample(bodies, groups, contacts, drive, scratch, samples[row], time, moment)
            drive.sums[0] += work
            drive.sums[1] += moment
            note_outer(outer_of(drive.history), drive.dt)
            drive.sums[2] += slide(bodies, groups, contacts, drive, scratch)
            drift(bodies, drive, scratch)
            step += 1
            body = lost(drive.velocity, bodies.rollers)
            if body != -2:
                return NOT_FINITE, step, body
    return DONE, step, -2
