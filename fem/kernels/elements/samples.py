"""What a sample stores, read off the state in the middle of a step: motion, forces, energies, works.

Off the hot path: once in a stride of steps.

Equation (10) of docs/method.md.
"""

from math import cos, sin

from fem.kernels import columns as sample
from fem.kernels.columns import CONTACT, DAMPED_BY_BODIES, DAMPED_BY_CONTACTS, DISSIPATED, N_SCALARS, WORK_DRIVE
from fem.kernels.drive import SPEED, is_turning, load_at, outer_axes, speed_of
from fem.kernels.elements import discs, rings
from fem.kernels.elements.bodies import prepare_others, write_others
from fem.kernels.elements.friction import spring_energy
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import Pair, RigidDisc
from fem.kernels.elements.tilted import SlicedLaw
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import cosine_and_sine, load_pair
from fem.kernels.lanes import WIDTH, load, splat, total
from fem.kernels.law import stored_energy
from fem.kernels.mounts import write_hub


@part(inlined=False)
def remember(bodies, drive, scratch):
    """Keep the velocities before a kick: a sample needs those of both half steps."""
    rollers, w = bodies.rollers, bodies.disc.w
    if drive.slowing > 0.0:
        rings.set_held_row(bodies.inner, drive, -1.0)
        prepare_others(bodies.others)
    for i in range(w.size):
        scratch.rollers_w[i] = w[i]
    for component in range(2):
        scratch.hub_velocity[component] = drive.velocity[component]
        for j in range(rollers.n):
            scratch.rollers_velocity[component, j] = rollers.velocity[component, j]
    _copy(bodies.inner.w, scratch.inner_w)
    _copy(bodies.outer.w, scratch.outer_w)


@part(inlined=False)
def _copy(source, target):
    """An assignment of slices would allocate, because they might overlap."""
    for row in range(source.shape[0]):
        for component in range(2):
            for k in range(source.shape[2]):
                target[row, component, k] = source[row, component, k]


@part(inlined=False)
def write_sample(bodies, groups, contacts, drive, scratch, out, time, moment):
    """Everything a sample stores, at the instant of the kick just made.

    Of the kick's works that part belongs to it which the forces did with the velocities before: leapfrog's energy
    changes by ½ dt v·(F + F') from one instant to the next. `moment`, N m s, is the kick's.
    """
    before, after, dt, rollers = scratch.hub_velocity, drive.velocity, drive.dt, bodies.rollers
    forces, friction, dampers = contacts.forces, contacts.friction, contacts.dampers
    damping, n = bodies.damping, rollers.n
    out[sample.TIME] = time
    write_hub(out, drive.hub, before, after, dt)
    out[sample.KINETIC] = kinetic_energy(bodies, drive, scratch)
    out[WORK_DRIVE] = _drive_work(bodies.inner, drive, scratch, time, moment)
    outer = None if drive.history is None else drive.history.outer
    if outer is not None:  # the same of what keeps the outer ring's speed
        angular, sums, speed = _changes(bodies.outer, scratch.outer_w)[0], outer.sums, outer.now[SPEED]
        weight = -drive.gravity * _ring_place(bodies.outer, outer.frame[1], outer.frame[2])[0]
        sums[1] += 0.5 * (weight + sums[2]) * (time - sums[3])
        sums[2], sums[3] = weight, time
        turned = outer.moment[1] - outer.moment[0] * dt
        given = 0.5 * angular - sums[0] - 0.5 * turned - sums[1] + _rim(bodies.outer) * speed
        out[WORK_DRIVE] += _trapezoid(outer.drive_work, sin(speed * dt) / dt, given)
    out[sample.ELASTIC] = elastic_energy(bodies, drive, scratch)  # after what needs the velocities before
    out[CONTACT] = 0.0
    add_contact_energy(groups, contacts, n, out)
    side_load, radial_load = load_at(drive, time)
    moved_x, moved_y = dt * before[0] + drive.slowed[0, 0], dt * before[1] + drive.slowed[0, 1]
    out[sample.WORK_LOAD] = drive.sums[0] - 0.5 * radial_load * moved_y + 0.5 * side_load * moved_x
    height = drive.mass * drive.hub[1]  # Σ m y of all that moves, kg m
    for j in range(n):
        height += rollers.total_mass * rollers.centre[1, j]
    (c, s), of_inner = outer_axes(drive), _ring_place(bodies.inner, drive.frame[1], drive.frame[2])[1]
    out[sample.WORK_GRAVITY] = -drive.gravity * (height + of_inner + _ring_place(bodies.outer, c, s)[1])
    rubbed = 0.0
    for row in range(friction.traction.shape[0]):
        for j in range(n):
            rubbed -= friction.traction[row, j] * friction.slip[row, j]
    stored = spring_energy(friction.shear, n)
    out[CONTACT] += stored
    out[DISSIPATED] = drive.sums[2] + 0.5 * dt * rubbed - stored
    out[DAMPED_BY_CONTACTS] = 0.0 if dampers is None else dampers.work[0]
    out[DAMPED_BY_BODIES] = 0.0 if damping is None else damping.work[0] - 0.25 * damping.work[1]  # see `damp_bodies`
    out[DISSIPATED] += out[DAMPED_BY_CONTACTS] + out[DAMPED_BY_BODIES]
    for j in range(n):
        at = N_SCALARS + j
        out[at + sample.X * n] = rollers.centre[0, j]
        out[at + sample.Y * n] = rollers.centre[1, j]
        out[at + sample.TURN * n] = rollers.turn[j] + rollers.lead[j]
        out[at + sample.SPIN * n] = rollers.spin[j]
        for row in range(3):
            force = forces.force[row, j]
            if dampers is not None:  # kicks never pull; they release residual energy, so this could be below 0
                force = max(force + dampers.force[row, j], 0.0)
            out[at + (sample.FORCE + row) * n] = force
        for row in range(2):
            out[at + (sample.TRACTION + row) * n] = friction.traction[row, j]
            if dampers is not None:
                out[at + (sample.DAMPER_FORCE + row) * n] = dampers.whole_force[row, j]
    write_others(bodies.others, drive, out)


@part(inlined=False)
def _drive_work(inner, drive, scratch, time, moment):
    """Work of what keeps the shaft's speed, J, up to a constant: speed times the moment on ring and hub it must give.

    That is the change of their angular momentum about the origin less the moment of all other forces; gravity's,
    a smooth one, is summed at samples only.
    """
    if not is_turning(drive):
        return 0.0
    before, after = scratch.hub_velocity, drive.velocity
    angular = drive.mass * (drive.hub[0] * (before[1] + after[1]) - drive.hub[1] * (before[0] + after[0]))
    angular += _changes(inner, scratch.inner_w)[0]
    weight = -drive.gravity * (drive.mass * drive.hub[0] + _ring_place(inner, drive.frame[1], drive.frame[2])[0])
    drive.sums[3] += 0.5 * (weight + drive.sums[4]) * (time - drive.sums[5])
    drive.sums[4], drive.sums[5] = weight, time
    given = 0.5 * angular - drive.sums[1] - 0.5 * moment - drive.sums[3]
    speed = speed_of(drive)
    rate = sin(speed * drive.dt) / drive.dt
    if drive.history is None:
        return rate * given
    return _trapezoid(drive.history.drive_work, rate, given + _rim(inner) * speed)


@part(inlined=False)
def _changes(ring, before):
    """Of a ring's free nodes, by both half steps: twice their angular momentum about the frame's origin, N m s; twice
    their kinetic energy, J; and Σ m X times what their radial velocities have gained in a kick, kg m²/s."""
    angular, kinetic, outward = splat(0.0), splat(0.0), splat(0.0)
    for row in range(ring.first_row, ring.last_row):
        width, mass = ring.cosines.size, ring.row_mass[row]
        for k in range(2 * row * width + HALO, (2 * row + 1) * width - HALO, WIDTH):
            (x, y), (a, b) = load_pair(ring.u, k, width), load_pair(before, k, width)
            x, (p, q) = x + ring.radii[row], load_pair(ring.w, k, width)
            angular += mass * (x * (b + q) - y * (a + p))
            kinetic += mass * (a * p + b * q)
            outward += mass * ring.radii[row] * (p - a)
    return total(angular), total(kinetic), total(outward)


@part
def _rim(ring):
    """Moment of inertia of a ring's held row, kg m²."""
    return ring.row_mass[ring.held] * ring.n_sectors * ring.radii[ring.held] * ring.radii[ring.held]


@part
def _trapezoid(work, rate, given):
    """Work of a drive, J, up to now: `work` is it, the last rate, 1/s, and what had been given then, N m s."""
    if work[1] == work[1]:  # not the first
        work[0] += 0.5 * (work[1] + rate) * (given - work[2])
    work[1], work[2] = rate, given
    return work[0]


@part(inlined=False)
def kinetic_energy(bodies, drive, scratch):
    """½ w(t − dt/2)·M·v(t + dt/2): with ½ uᵀKu the energy leapfrog conserves exactly.

    v = w − γ dt² M⁻¹K·w is what nodes move at. Less ½ (1 − cos ω dt) Σ m X·a of the bodies that turn: their forces turn
    with them within a step.
    """
    rollers, disc, inner, moving = bodies.rollers, bodies.disc, bodies.inner, splat(0.0)
    outer = None if drive.history is None else drive.history.outer
    dt, columns, n = drive.dt, rollers.columns, rollers.n
    for j in range(0, n, WIDTH):
        cosine, _ = cosine_and_sine(load(rollers.spin, j) * dt)
        turned, kick = (1.0 - cosine) * (1.0 / dt), load(rollers.turn_kick, j)
        for i in range(disc.mass.size):
            at, x, y = 2 * i * columns + j, disc.points[2 * i], disc.points[2 * i + 1]
            bx, by = load_pair(scratch.rollers_w, at, columns)
            ax, ay = load_pair(disc.w, at, columns)
            outward = x * (ax - bx) + y * (ay - by)
            around = x * by - y * bx  # what turning as a whole will still add to the velocities after
            moving += disc.mass[i] * (bx * ax + by * ay - turned * outward + kick * around)
    found = total(moving)
    for j in range(n):
        if isinstance(bodies.surface, RigidDisc):
            found += rollers.inertia * rollers.spin[j] * (rollers.spin[j] + rollers.turn_kick[j])
        for component in range(2):
            before = scratch.rollers_velocity[component, j]
            after = rollers.velocity[component, j] + rollers.node_impulse[component, j] / rollers.total_mass
            found += rollers.total_mass * before * after
    _, of_inner, gained = _changes(inner, scratch.inner_w)
    _, of_outer, gained_o = _changes(bodies.outer, scratch.outer_w)
    before, after, speed = scratch.hub_velocity, drive.velocity, speed_of(drive)
    found += of_inner + of_outer + _rim(inner) * speed * speed - (1.0 - cos(speed * dt)) * gained / dt
    found += drive.mass * (before[0] * after[0] + before[1] * after[1])
    if drive.slowing > 0.0:  # −dt wᵀKw of velocities before and the calmed ones after a kick, ready for the stencil
        if drive.calming > 0.0:
            discs.calm(disc, columns, drive.calming)
        power = discs.strain_power(disc, disc.calmed, scratch.rollers_w, columns, n)
        power += _ring_power(inner, inner.calmed, scratch.inner_w, scratch.bore)
        power += _ring_power(bodies.outer, bodies.outer.calmed, scratch.outer_w, scratch.line)
        found += drive.slowing / dt * power
    if outer is not None:  # its held row, and how its forces turn with it
        turning = outer.now[SPEED]
        found += _rim(bodies.outer) * turning * turning - (1.0 - cos(turning * dt)) * gained_o / dt
    return 0.5 * found


@part(inlined=False)
def elastic_energy(bodies, drive, scratch):
    """Energy ½ uᵀKu of all bodies, J; the held rows move with hub or housing."""
    disc, inner, outer = bodies.disc, bodies.inner, bodies.outer
    power = discs.strain_power(disc, disc.u, disc.u, bodies.rollers.columns, bodies.rollers.n)
    power += _ring_power(inner, inner.u, inner.u, scratch.bore) + _ring_power(outer, outer.u, outer.u, scratch.line)
    return -0.5 / drive.dt * power


@part(inlined=False)
def _ring_power(ring, field, other, line):
    """−dt otherᵀK·field of all rows of a ring; `line` : (2, width), room."""
    found, width = splat(0.0), ring.cosines.size
    for row in range(ring.radii.size):
        rings.row_force(ring.table, field, row, line)
        at, mass = 2 * row * width, ring.row_mass[row]
        for k in range(HALO, HALO + ring.n_sectors, WIDTH):
            found += mass * (load(other, at + k) * load(line, k) + load(other, at + width + k) * load(line, width + k))
    return total(found)


@part
def _add_contact_energy(pair, contacts, n, out):
    """Add the energy below the grid, or in the layers, of a pair's contacts; the ripples' share is ½·ripple·Q²."""
    forces, law, points = contacts.forces, pair.law, contacts.points
    for j in range(n):
        Q = forces.force[pair.row, j]
        if points is not None:
            out[CONTACT] += points.energy[pair.row, j]
        elif Q > 0.0:
            if isinstance(law, SlicedLaw):
                out[CONTACT] += law.axes.tilted.energy[pair.row, j]
            else:
                out[CONTACT] += stored_energy(Q, forces.approach[pair.row, j], law.A, law.Q_line)


add_contact_energy = every(_add_contact_energy, Pair)


@part(inlined=False)
def _ring_place(ring, c, s):
    """Σ m x and Σ m y of the free nodes, kg m; c, s of the ring's turn."""
    x, y = splat(0.0), splat(0.0)
    for row in range(ring.first_row, ring.last_row):
        at, mass = 2 * row * ring.cosines.size, ring.row_mass[row]
        for k in range(HALO, HALO + ring.n_sectors, WIDTH):
            a, b = load_pair(ring.u, at + k, ring.cosines.size)
            cosine, sine = load(ring.cosines, k), load(ring.sines, k)
            x += mass * (a * cosine - b * sine)
            y += mass * (a * sine + b * cosine)
    sum_x, sum_y = total(x), total(y)
    return c * sum_x - s * sum_y, s * sum_x + c * sum_y
