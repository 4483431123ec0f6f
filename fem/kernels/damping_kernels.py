"""Dampers of contacts and of bodies.

A contact's damper stands beside the law below the grid. It pushes as the law does, along W n, with a force that is
implicit in its own patches' velocity after the step, F = c v, so that none shortens the step, and with the law it never
pulls. Contacts of a raceway are solved for at once, or one after another where they share rigid bodies.

The rate is that of the law's approach. Velocities of nodes at a fixed patch tell how it changes in a kick; what the
patch's own way along deformed surfaces adds, which hardly changes from step to step, is the difference between how
far the approach went on the last way and what the nodes' velocities said then.

Of the whole approach of two bodies, of stiffness k, only a part is below the grid, of stiffness K: nodes carry the
rest. A damper c·(K/k)² beside the former takes the power of c beside the whole, and is felt as that: of its force k/K
is what c would give, the rest makes up for what the law below the grid gives less.
"""

from fem.kernels.contact_kernels import next_roller, push_nodes
from fem.kernels.course_kernels import speed_of
from fem.kernels.jit import every, part, verb
from fem.kernels.lane_functions import larger, logarithm, smaller
from fem.kernels.lane_memory import gather, gather_pair, load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, total
from fem.kernels.law import STEEPEST
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import CONTACTS, DiscSurface, Hub, Neighbours, Raceway, RigidDisc, RingSurface
from fem.kernels.surfaces import first_weight, gather_seam, next_node, push, push_body, unseal


@verb
def velocity_out(surface, patches, side, j, nx, ny):
    """Velocity of a contact's patch out of its surface (of a rigid ring along n), m/s, and its mobility, 1/kg."""
    return 0.0, 0.0


@velocity_out.of(RingSurface)
def _of_ring(ring, patches, side, j, nx, ny):
    out, light, node = 0.0, 0.0, patches.start[side, j]
    for k in range(N_NODES * len(patches.units)):
        at, share = node + HALO, patches.weight[side, k, j]
        out += patches.along[side, k, j] * ring.w[ring.row, 0, at]
        out += patches.across[side, k, j] * ring.w[ring.row, 1, at]
        light += share * share
        node = next_node(node, ring.n_nodes)
    return out, light / ring.node_mass


@velocity_out.of(Hub)
def _of_hub(hub, patches, side, j, nx, ny):
    return hub.velocity[0] * nx + hub.velocity[1] * ny, 1.0 / hub.mass


@verb
def roller_out(disc, patches, side, j, column):
    """`velocity_out` of a patch of roller `column`, against its centre of mass."""


@roller_out.of(DiscSurface)
def _of_roller(disc, patches, side, j, column):
    out, light, node, columns = 0.0, 0.0, patches.start[side, j], disc.columns
    bx, by = patches.outward[side, 0, j], patches.outward[side, 1, j]
    for k in range(N_NODES * len(patches.units)):
        i, share = disc.first + node, patches.weight[side, k, j]
        at = i * 2 * columns + column
        out += share * (bx * disc.w[at] + by * disc.w[at + columns])
        light += share * share * disc.lightness[i]
        node = next_node(node, disc.n_nodes)
    return out, light


@roller_out.of(RigidDisc)
def _rigid_roller(disc, patches, side, j, column):
    return 0.0, 1.0 / disc.total_mass


@part
def _alone(j, impulse):
    """The first of eight contacts that contact j is among, and an impulse on it alone."""
    group = j - j % WIDTH
    return group, select(count_from(group) == j, impulse, 0.0)


@verb
def push_late(surface, patches, side, j, column, impulse, x, y):
    """`push` once bodies have had their kick; (x, y) is the impulse in fixed axes, N s. Returns its moment, N m s."""
    return 0.0


@push_late.of(RingSurface)
def _push_ring(ring, patches, side, j, column, impulse, x, y):
    group, given = _alone(j, impulse)
    unseal(ring)
    moment = total(push(ring, patches, side, group, given))
    gather_seam(ring)
    return moment


@push_late.of(DiscSurface)
def _push_disc(disc, patches, side, j, column, impulse, x, y):
    disc.impulse[0, column] += x
    disc.impulse[1, column] += y
    group, given = _alone(j, impulse)
    return push(disc, patches, side, group, given)


@push_late.of(Hub, RigidDisc)
def _push_rigid(body, patches, side, j, column, impulse, x, y):
    return push_body(body, column, x, y, 0.0)


@verb
def out_of_surface(surface, patches, side, group, column):
    """`velocity_out` of eight patches on surfaces with nodes, of a roller against its centre of mass; of others 0."""
    return splat(0.0), splat(0.0)


@out_of_surface.of(RingSurface)
def _eight_of_ring(ring, patches, side, group, column):
    at, columns, width = first_weight(patches, side, group), patches.columns, ring.w.shape[2]
    first = 2 * ring.row * width + HALO
    out, light, node = splat(0.0), splat(0.0), load(patches.start, side * columns + group)
    for k in range(N_NODES * len(patches.units)):
        j = at + k * columns
        radial, around = gather_pair(ring.w, node + first, width)
        share = load(patches.weight, j)
        out += load(patches.along, j) * radial + load(patches.across, j) * around
        light += share * share
        node = next_node(node, ring.n_nodes)
    return out, light * (1.0 / ring.node_mass)


@out_of_surface.of(DiscSurface)
def _eight_of_rollers(disc, patches, side, group, column):
    at, columns, first = first_weight(patches, side, group), patches.columns, 2 * side * patches.columns
    x, y, light, node = splat(0.0), splat(0.0), splat(0.0), load(patches.start, side * columns + group)
    column = column + 2 * columns * disc.first
    for k in range(N_NODES * len(patches.units)):
        share = load(patches.weight, at + k * columns)
        vx, vy = gather_pair(disc.w, node * (2 * columns) + column, columns)
        x += share * vx
        y += share * vy
        light += share * share * gather(disc.lightness, node + disc.first)
        node = next_node(node, disc.n_nodes)
    return x * load(patches.outward, first + group) + y * load(patches.outward, first + columns + group), light


@verb
def damp(pair, rollers, disc, contacts, dampers, dt, whole, later):
    """Damp a pair's closed contacts. `whole` : of `Friction`; not None where contacts share rigid bodies.

    `later` : nodes of raceways are given these impulses with friction's, see `friction_solution.pushes_later`.
    """


@damp.of(Raceway)
def _damp_raceway(raceway, rollers, disc, contacts, dampers, dt, whole, later):
    if whole is None:
        _damp_eights(raceway, rollers, disc, contacts, dampers, dt)
        if not later:
            push_nodes(raceway, rollers, disc, contacts, dampers, dt)
    else:
        _damp_in_turn(raceway, rollers, disc, contacts, dampers, dt)


@part
def _damp_eights(raceway, rollers, disc, contacts, dampers, dt):
    """Eight contacts at once; nodes have not been given the law's kick yet, and are to be given both together."""
    forces, patches, columns, sign = contacts.forces, contacts.patches, rollers.columns, raceway.sign
    side, impulse, velocity = 2 * raceway.row, rollers.node_impulse, rollers.velocity
    before, after = splat(0.0), splat(0.0)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        Q, P = load(forces.force, row), load(forces.kick, row)
        closed = Q > 0.0
        if not any_lane(closed):
            for array in (dampers.force, dampers.felt, dampers.left, dampers.known):
                store(array, row, splat(0.0))
            continue
        nx, ny = load(patches.normal, side * columns + group), load(patches.normal, (side + 1) * columns + group)
        ring, ring_light = out_of_surface(raceway.surface, patches, side, group, 0)
        own, own_light = out_of_surface(disc, patches, side + 1, group, count_from(group))
        mobility = (ring_light + own_light) * dt
        rate = sign * (ring - load(velocity, group) * nx - load(velocity, columns + group) * ny) + own - mobility * P
        known = load(dampers.known, row) > 0.0
        behind = select(known, load(dampers.rate, row), rate)
        passing = select(known, behind - load(dampers.left, row), 0.0)
        c, felt = _coefficient(raceway, dampers, select(closed, smaller(Q, raceway.law.Q_line), 1.0))
        F = select(closed, larger(c * (rate + passing) / (1.0 + c * mobility), -P), 0.0)
        left = rate - mobility * F
        before += F * behind
        after += F * (left + passing)
        store(dampers.force, row, F)
        store(dampers.felt, row, felt * F)
        store(dampers.left, row, select(closed, left, 0.0))
        store(dampers.known, row, select(closed, 1.0, 0.0))
        given = F * (sign * dt)
        store(impulse, group, load(impulse, group) + given * nx)
        store(impulse, columns + group, load(impulse, columns + group) + given * ny)
    dampers.work[0] += 0.5 * dt * total(before)
    dampers.work[1] += 0.5 * dt * total(after)


@part
def _damp_in_turn(raceway, rollers, disc, contacts, dampers, dt):
    """One contact after another, each with what those before have given: they share rigid bodies."""
    patches, row, sign, moment = contacts.patches, raceway.row, raceway.sign, 0.0
    for j in range(rollers.n):
        if not contacts.forces.force[row, j] > 0.0:
            _let_go(dampers, row, j)
            continue
        nx, ny = patches.normal[row, 0, j], patches.normal[row, 1, j]
        ring, ring_light = velocity_out(raceway.surface, patches, 2 * row, j, nx, ny)
        own, own_light = roller_out(disc, patches, 2 * row + 1, j, j)
        rate = sign * (ring - rollers.velocity[0, j] * nx - rollers.velocity[1, j] * ny) + own
        given = dt * _damper_force(raceway, contacts.forces, dampers, j, rate, ring_light + own_light, dt)
        x, y = sign * given * nx, sign * given * ny
        moment += push_late(raceway.surface, patches, 2 * row, j, j, -sign * given, -x, -y)
        push_late(disc, patches, 2 * row + 1, j, j, -given, x, y)
    raceway.moment[1] += moment


@damp.of(Neighbours)
def _damp_neighbours(pair, rollers, disc, contacts, dampers, dt, whole, later):
    patches, row, velocity = contacts.patches, pair.row, rollers.velocity
    for j in range(rollers.n):
        if not contacts.forces.force[row, j] > 0.0:
            _let_go(dampers, row, j)
            continue
        i, nx, ny = next_roller(j, rollers.n), patches.normal[row, 0, j], patches.normal[row, 1, j]
        own, own_light = roller_out(disc, patches, 2 * row, j, j)
        other, other_light = roller_out(disc, patches, 2 * row + 1, j, i)
        rate = own + other - (velocity[0, i] - velocity[0, j]) * nx - (velocity[1, i] - velocity[1, j]) * ny
        given = dt * _damper_force(pair, contacts.forces, dampers, j, rate, own_light + other_light, dt)
        x, y = given * nx, given * ny
        push_late(disc, patches, 2 * row, j, j, -given, -x, -y)
        push_late(disc, patches, 2 * row + 1, j, i, -given, x, y)


_damp_all = every(damp, *CONTACTS)


@part
def damp_contacts(groups, bodies, contacts, dampers, dt, later):
    """Forces of all contacts' dampers, and their impulses in this step; None: there are none. `later`: see `damp`."""
    if dampers is not None:
        dampers.work[0] += dampers.work[1]
        dampers.work[1] = 0.0
        whole = contacts.friction.whole
        _damp_all(groups, bodies.rollers, bodies.surface, contacts, dampers, dt, whole, later)


@part
def _let_go(dampers, row, j):
    """An open contact is not damped."""
    dampers.force[row, j] = 0.0
    dampers.felt[row, j] = 0.0
    dampers.left[row, j] = 0.0
    dampers.known[row, j] = 0.0


@part
def _coefficient(pair, dampers, Q):
    """N s/m beside the law below the grid under forces, N, scalars or lanes; what of that is beside the whole."""
    law, half = pair.law, 0.5 * logarithm(Q) + 0.5
    below, whole = larger(law.B - half, STEEPEST), larger(dampers.whole[pair.row] - half, STEEPEST)
    over = 1.0 / (below * whole)
    softer, stiffness = whole * whole * over, below * over / law.A
    c = dampers.constant + dampers.time * stiffness + 1.5 * dampers.hunt_crossley * Q
    return c * softer * softer, below * below * over


@part
def _damper_force(pair, forces, dampers, j, rate, mobility, dt):
    """Force of a contact's damper, N. `rate` : m/s, by the nodes' velocities before it; `mobility` : 1/kg."""
    row = pair.row
    c, felt = _coefficient(pair, dampers, min(forces.force[row, j], pair.law.Q_line))
    passing, behind = 0.0, rate
    if dampers.known[row, j] > 0.0:
        behind = dampers.rate[row, j]
        passing = behind - dampers.left[row, j]
    rate += passing
    force = max(c * rate / (1.0 + c * mobility * dt), -forces.kick[row, j])
    left = rate - mobility * dt * force
    dampers.work[0] += 0.5 * dt * force * behind
    dampers.work[1] += 0.5 * dt * force * left
    dampers.force[row, j], dampers.felt[row, j] = force, force * felt
    dampers.left[row, j], dampers.known[row, j] = left - passing, 1.0
    return force


@part
def damp_bodies(bodies, drive, damping):
    """Take their share from the velocities that bodies have beside moving and turning as a whole; None: nothing.

    Of a held ring that is the motion against hub or ground, which feel the reaction. A velocity shrinks by exp(−a dt) a
    step, and the work that takes is what the energy of leapfrog, ½ v(t − dt/2)·M·v(t + dt/2), loses.
    """
    if damping is not None:
        _damp_rollers(bodies.disc, bodies.rollers, damping, drive.dt)
        _damp_inner(bodies.inner, drive, damping)
        _damp_outer(bodies.outer, damping)


@part(inlined=False)
def _damp_rollers(disc, rollers, damping, dt):
    """Places half a step back, where the velocities are, make what turns rigidly turn without any loss."""
    points, mass, u, w, columns, half = disc.points, disc.mass, disc.u, disc.w, rollers.columns, 0.5 * dt
    lost = splat(0.0)
    for j in range(0, rollers.n, WIDTH):
        around, size = splat(0.0), splat(0.0)
        for i in range(mass.size):
            at = 2 * i * columns + j
            vx, vy = load(w, at), load(w, at + columns)
            x = gather(points, 2 * i) + load(u, at) - half * vx
            y = gather(points, 2 * i + 1) + load(u, at + columns) - half * vy
            around += mass[i] * (x * vy - y * vx)
            size += mass[i] * (x * x + y * y)
        spin = around / size
        for i in range(mass.size):
            at = 2 * i * columns + j
            vx, vy = load(w, at), load(w, at + columns)
            x = gather(points, 2 * i) + load(u, at) - half * vx
            y = gather(points, 2 * i + 1) + load(u, at + columns) - half * vy
            own_x, own_y = vx + spin * y, vy - spin * x
            store(w, at, vx - damping.share * own_x)
            store(w, at + columns, vy - damping.share * own_y)
            lost += mass[i] * (own_x * own_x + own_y * own_y)
    damping.work[0] += damping.loss * total(lost)


@part(inlined=False)
def _damp_inner(ring, drive, damping):
    c, s, half, width = drive.frame[1], drive.frame[2], 0.5 * drive.dt, ring.cosines.size
    speed = speed_of(drive.course, drive)
    hub_x, hub_y = drive.hub[0] - half * drive.velocity[0], drive.hub[1] - half * drive.velocity[1]
    x, y = drive.velocity[0] + speed * hub_y, drive.velocity[1] - speed * hub_x
    hub_x, hub_y = c * x + s * y, c * y - s * x
    lost, back_x, back_y = 0.0, 0.0, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_lost, part_x, part_y = splat(0.0), splat(0.0), splat(0.0)
        at = 2 * row * width
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            own_p = p + speed * y - (hub_x * e + hub_y * f)
            own_q = q - speed * x - (hub_y * e - hub_x * f)
            store(ring.w, at + k, p - damping.share * own_p)
            store(ring.w, at + width + k, q - damping.share * own_q)
            part_lost += own_p * own_p + own_q * own_q
            part_x += own_p * e - own_q * f
            part_y += own_p * f + own_q * e
        lost += ring.row_mass[row] * total(part_lost)
        back_x += ring.row_mass[row] * total(part_x)
        back_y += ring.row_mass[row] * total(part_y)
    back = damping.share / drive.mass
    drive.velocity[0] += back * (c * back_x - s * back_y)
    drive.velocity[1] += back * (s * back_x + c * back_y)
    damping.work[0] += damping.loss * lost


@part(inlined=False)
def _damp_outer(ring, damping):
    width, lost = ring.cosines.size, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_lost = splat(0.0)
        for at in range(2 * row * width, 2 * (row + 1) * width, width):
            for k in range(at + HALO, at + width - HALO, WIDTH):
                p = load(ring.w, k)
                store(ring.w, k, p - damping.share * p)
                part_lost += p * p
        lost += ring.row_mass[row] * total(part_lost)
    damping.work[0] += damping.loss * lost
