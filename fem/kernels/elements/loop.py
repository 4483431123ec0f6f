"""The time loop: leapfrog steps of the whole bearing.

`kick` in physical lines: CONTACT FORCES (`contacts`, `points`), FRICTION (`friction`), THE CAGE (`fem.kernels.cage`).
"""

from fem.kernels.cage import CagePair, meet, rub
from fem.kernels.drive import STEP, follow, is_turning, load_at, outer_axes, speed_of, step_of
from fem.kernels.elements import bodies as further
from fem.kernels.elements import discs, rings
from fem.kernels.elements.contacts import press_patches, push_neighbours, push_patches
from fem.kernels.elements.damping import damp_bodies, damp_contacts
from fem.kernels.elements.friction import friction_contacts, slips_after, slips_before
from fem.kernels.elements.points import press_all_points
from fem.kernels.elements.samples import remember, write_sample
from fem.kernels.elements.state import RigidDisc
from fem.kernels.jit import every, kernel, part
from fem.kernels.lane_functions import cosine_and_sine, load_pair, store_pair
from fem.kernels.lanes import WIDTH, fma, load, store
from fem.kernels.mounts import DONE, NOT_FINITE, lost


@part
def _meet_cage(pair, drive):
    meet(pair, speed_of(drive), drive.dt)


@part
def _rub_cage(pair, drive):
    """The end of a kick: dashpots and friction of a cage's contacts."""
    rub(pair, drive.dt)
    ring = pair.ring
    if ring is not None:
        if ring.turns:
            drive.moment[1] += ring.place[0] * ring.rubbed[1] - ring.place[1] * ring.rubbed[0] + ring.rubbed[2]


meet_cages, rub_cages = every(_meet_cage, CagePair), every(_rub_cage, CagePair)


@part
def press_contacts(groups, bodies, contacts, drive):
    """Normal forces by the scene's contact model, and what they do to whole bodies; a run compiles the one it uses."""
    meet_cages(groups, drive)  # before impulses through nodes, which it would take for its rollers' own
    if contacts.points is None:
        press_patches(groups, bodies.rollers, bodies.surface, contacts, drive)
    else:
        press_all_points(groups, bodies.rollers, bodies.surface, contacts, drive)


@part
def push_surfaces(groups, bodies, contacts, drive):
    """The normal forces' impulses on surface nodes, where `press_contacts` has not given them already."""
    rollers, points = bodies.rollers, contacts.points
    if contacts.dampers is not None and contacts.friction.whole is None:  # the others with their dampers
        push_neighbours(groups, rollers, bodies.surface, contacts, drive.dt)
    elif points is None or points.shift.shape[2] == 1:
        push_patches(groups, rollers, bodies.surface, contacts, None, drive.dt)
        if isinstance(bodies.surface, RigidDisc):  # where they act on whole bodies
            for component in range(2):
                for j in range(rollers.n):
                    rollers.body_impulse[component, j] += rollers.node_impulse[component, j]
                    rollers.node_impulse[component, j] = 0.0


@part
def kick(bodies, groups, contacts, drive, time, scratch):
    """Advance all velocities by one step at fixed positions, but for the rollers' turning as a whole (`drift`).

    Returns of this step the work of the load, J, and the moment on hub and ring about the origin other than the drive's
    and gravity's, N m s.
    """
    rollers, surface, friction, inner = bodies.rollers, bodies.surface, contacts.friction, bodies.inner
    slowed, dt, outer = drive.slowed, drive.dt, None if drive.history is None else drive.history.outer
    velocity, impulse, hub = drive.velocity, drive.impulse, drive.hub
    follow(drive, time)
    rollers.node_impulse[:] = 0.0
    rollers.body_impulse[:] = 0.0
    rollers.turn_kick[:] = 0.0
    drive.impulse[:] = 0.0
    drive.moment[:] = 0.0
    if outer is not None:
        outer.moment[0] = outer.moment[1] = 0.0
    if bodies.damping is not None:
        damp_bodies(bodies, drive, bodies.damping)
    press_contacts(groups, bodies, contacts, drive)
    later = False  # whether the normal forces' impulses on nodes are given with the tractions': no spring needs them
    if friction.coefficient > 0.0:
        slips_before(groups, rollers, surface, contacts, scratch.still, drive.slowing == 0.0)
        if friction.shear is not None:
            later = friction.whole is None
    if not later:
        push_surfaces(groups, bodies, contacts, drive)
    elif contacts.dampers is not None:  # where rollers touch these work one by one, and need the impulses first
        push_neighbours(groups, rollers, surface, contacts, dt)
    lightness = 1.0 / rollers.total_mass
    for j in range(rollers.n):
        rollers.velocity[0, j] += rollers.body_impulse[0, j] * lightness
        rollers.velocity[1, j] += rollers.body_impulse[1, j] * lightness - drive.gravity * dt
    before_x, before_y = velocity[0], velocity[1]
    side_load, radial_load = load_at(drive, time)
    # the hub: contacts, the reaction of the ring's held row, load along x and against y, weight; the moment about the
    # origin of contacts and load on it
    rings.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = rings.resultant(scratch.bore, inner.cosines, inner.sines)
    c, s, node_mass = drive.frame[1], drive.frame[2], inner.row_mass[inner.held]
    moment = hub[0] * (impulse[1] - radial_load * dt) - hub[1] * impulse[0] + -hub[1] * side_load * dt
    velocity[0] += (node_mass * (c * x - s * y) + impulse[0] + side_load * dt) / drive.mass
    velocity[1] += (node_mass * (s * x + c * y) + impulse[1] - radial_load * dt) / drive.mass - drive.gravity * dt
    _kick_nodes(bodies, drive, scratch)
    further.kick_others(bodies.others, drive)
    rub_cages(groups, drive)
    for j in range(rollers.n):
        rollers.turn_kick[j] -= scratch.torque[j] / rollers.inertia
    if contacts.dampers is not None:
        damp_contacts(groups, bodies, contacts, drive, later)
        further.take_all_late(bodies.others)
    if friction.coefficient > 0.0:
        friction_contacts(groups, rollers, surface, contacts, drive)
    further.end_kicks(bodies.others, drive)
    _make_ready(bodies, drive, scratch)
    moved_x = dt * (before_x + velocity[0]) + slowed[0, 0] + slowed[1, 0]
    moved_y = dt * (before_y + velocity[1]) + slowed[0, 1] + slowed[1, 1]
    work_load = -radial_load * 0.5 * moved_y + side_load * 0.5 * moved_x  # friction may have moved a rigid hub
    return work_load, moment + drive.moment[1] - drive.moment[0] * dt


@part
def _kick_nodes(bodies, drive, scratch):
    """Internal forces' and gravity's kicks of all nodes; the rollers' second-order torque in `scratch.torque`."""
    inner, outer = bodies.inner, bodies.outer
    discs.kick(bodies.disc, bodies.disc.w, bodies.rollers.columns, scratch.torque)
    g, c, s = -drive.gravity * drive.dt, drive.frame[1], drive.frame[2]  # in the frames' axes
    rings.set_rigid(scratch.bore, 0, inner.cosines, inner.sines, s * g, c * g)
    c, s = outer_axes(drive)
    rings.set_rigid(scratch.line, 0, outer.cosines, outer.sines, s * g, c * g)
    rings.kick(inner.table, inner.u, inner.w, scratch.bore, inner.first_row, inner.last_row)
    rings.kick(outer.table, outer.u, outer.w, scratch.line, outer.first_row, outer.last_row)


@part
def _make_ready(bodies, drive, scratch):
    """Give held rows and halos of w what the stencil needs, and find the hub's share in the step to come."""
    inner, outer = bodies.inner, bodies.outer
    if drive.slowing > 0.0:
        rings.set_held_row(inner, drive, 1.0)
        further.prepare_others(bodies.others)
        rings.wrap_all(outer.w)
        rings.wrap_all(inner.w)
        if drive.calming > 0.0:
            step = speed_of(drive) * drive.dt
            # `grown` is that of γ dt², along a chord
            ahead = (1.0 - cosine_and_sine(step)[0]) / drive.dt * drive.calming / drive.slowing
            rings.calm(inner.calming, inner.w, inner.calmed, inner.grown, ahead, inner.first_row, inner.last_row)
            rings.calm(outer.calming, outer.w, outer.calmed, outer.grown, 0.0, outer.first_row, outer.last_row)
            rings.calm_held(inner, drive.mass, scratch.bore)
            further.calm_others(bodies.others)
        rings.row_force(inner.slowed, inner.calmed, inner.held, scratch.bore)
        x, y = rings.resultant(scratch.bore, inner.cosines, inner.sines)
        c, s, share = drive.frame[1], drive.frame[2], inner.row_mass[inner.held] / drive.mass
        further.remember_slowed(drive.slowed, share * (c * x - s * y), share * (s * x + c * y))
    further.slow_others(bodies.others, drive)


@part
def slide(bodies, groups, contacts, drive, scratch):
    """Slow the fastest waves, and find how surfaces slip in the step to come.

    Returns the work that friction takes at this kick in the steps before and after it, J.
    """
    rollers, taken, slowing = bodies.rollers, 0.0, drive.slowing
    for j in range(0, rollers.n, WIDTH):
        c, s = cosine_and_sine(load(rollers.increment, j))
        store(scratch.cosine, j, c)
        store(scratch.sine, j, s)
    if slowing > 0.0:
        columns, calming = rollers.columns, drive.calming
        discs.slow_waves(bodies.disc, scratch.cosine, columns, slowing, calming, drive.dt, scratch.torque)
        for j in range(rollers.n):
            rollers.turn_kick[j] -= slowing / rollers.inertia * scratch.torque[j]
        for ring in (bodies.inner, bodies.outer):
            rings.find_velocities(ring.slowed, ring.calmed, ring.w, ring.v, drive.dt, ring.raceway)
    if contacts.friction.coefficient > 0.0:
        taken = slips_after(groups, rollers, bodies.surface, contacts, drive.dt, slowing == 0.0)
    return 0.5 * drive.dt * taken


@part
def drift(bodies, drive, scratch):
    """Advance all positions by one step.

    Where masses are not lumped all is ready for the stencil to be applied to rings' w (`_make_ready`), and is no more
    after.
    """
    dt, rollers, inner, outer, slowing = drive.dt, bodies.rollers, bodies.inner, bodies.outer, drive.slowing
    columns, over, shift, hub, frame = rollers.columns, 1.0 / rollers.total_mass, scratch.shift, drive.hub, drive.frame
    for j in range(0, rollers.n, WIDTH):  # centres of mass; what that is in the rollers' frames to `shift`
        c, s = load(rollers.cosine, j), load(rollers.sine, j)
        px, py = load_pair(rollers.node_impulse, j, columns)
        px, py = px * over, py * over
        store_pair(shift, j, columns, c * px + s * py, c * py - s * px)
        vx, vy = load_pair(rollers.velocity, j, columns)
        vx, vy = vx + px, vy + py
        store_pair(rollers.velocity, j, columns, vx, vy)
        x, y = load_pair(rollers.centre, j, columns)
        store_pair(rollers.centre, j, columns, fma(dt, vx, x), fma(dt, vy, y))
    step, outer_turn = step_of(drive), None if drive.history is None else drive.history.outer
    cosine, sine = cosine_and_sine(step)
    turns = discs.Turns(rollers.turn_kick, scratch.cosine, scratch.sine, shift[0], shift[1], rollers.swelling)
    discs.drift(bodies.disc, turns, columns, dt, scratch.torque)
    if outer_turn is None:
        _drift_still(outer, dt, slowing)
    else:  # masses are lumped
        motion, rows = (outer.u, outer.w, outer.v), (outer.first_row, outer.last_row, outer.raceway)
        rings.drift(motion, outer.radii, outer.grown, dt, cosine_and_sine(outer_turn.now[STEP]), rows)
    if is_turning(drive):
        first, end = inner.first_row, inner.last_row
        if slowing > 0.0:
            rings.slow_waves(inner.slowed, inner.u, inner.calmed, first, end, inner.raceway)
            rings.unwrap(inner.w, inner.raceway)
        motion, rows = (inner.u, inner.w, inner.v), (first, end, inner.raceway)
        rings.drift(motion, inner.radii, inner.grown, dt, (cosine, sine), rows)
    else:
        _drift_still(inner, dt, slowing)
    if isinstance(bodies.surface, RigidDisc):
        for j in range(0, rollers.n, WIDTH):
            store(scratch.torque, j, load(rollers.turn_kick, j) * (rollers.inertia * dt))
    for j in range(0, rollers.n, WIDTH):  # frames; `torque` holds inertia times the angle by which bodies lead them
        increment, lead = load(rollers.increment, j), load(scratch.torque, j) * (1.0 / rollers.inertia)
        angle, turned = load(rollers.turn, j) + increment, increment + lead - load(rollers.lead, j)
        c, s = cosine_and_sine(angle)
        store(rollers.turn, j, angle)
        store(rollers.cosine, j, c)
        store(rollers.sine, j, s)
        store(rollers.spin, j, turned * (1.0 / dt))
        store(rollers.increment, j, turned + lead)
        store(rollers.lead, j, lead)
    hub[0] += dt * drive.velocity[0] + drive.slowed[1, 0]
    hub[1] += dt * drive.velocity[1] + drive.slowed[1, 1]
    if is_turning(drive):
        frame[0] += step
        frame[1], frame[2] = cosine_and_sine(frame[0])
    hub_x, hub_y = frame[1] * hub[0] + frame[2] * hub[1], frame[1] * hub[1] - frame[2] * hub[0]
    rings.set_rigid(inner.u, 2 * inner.held * inner.cosines.size, inner.cosines, inner.sines, hub_x, hub_y)
    if outer_turn is not None:
        outer_turn.frame[0] += outer_turn.now[STEP]
        outer_turn.frame[1], outer_turn.frame[2] = cosine_and_sine(outer_turn.frame[0])
    further.drift_others(bodies.others, drive)


@part
def _drift_still(ring, dt, slowing):
    if slowing > 0.0:
        motion, rows = (ring.u, ring.w, ring.v), (ring.first_row, ring.last_row, ring.raceway)
        rings.drift_slowed(ring.slowed, motion, ring.calmed, dt, rows)
        rings.unwrap(ring.w, ring.raceway)
    else:
        rings.drift_still(ring.u, ring.w, dt, ring.first_row, ring.last_row)


@kernel(nogil=True)
def advance(bodies, groups, contacts, drive, scratch, first_step, stride, samples):
    """Fill `samples`, one row each `stride` steps, starting with the state as it is; leaves the state after them.

    `groups`: tuples of pairs of bodies; those of a group are of one type.

    Returns (status, step, body): DONE, or NOT_FINITE with the step and the body (roller j, or −1 the hub).
    """
    step, outer = first_step, None if drive.history is None else drive.history.outer
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
            if outer is not None:  # moments of contacts on the outer ring's nodes, and on its frame
                outer.sums[0] += outer.moment[1] - outer.moment[0] * drive.dt
            drive.sums[2] += slide(bodies, groups, contacts, drive, scratch)
            drift(bodies, drive, scratch)
            step += 1
            body = lost(drive.velocity, bodies.rollers)
            if body != -2:
                return NOT_FINITE, step, body
    return DONE, step, -2
