"""Dampers of contacts, and damping of bodies in proportion to mass.

A contact's damper stands beside the law below the grid. It pushes as the law does, along W n, with a force that is
implicit in its own patches' velocity after the step, F = c v, so that none shortens the step, and with the law it never
pulls. Contacts of a raceway are solved for at once, or one after another where they share rigid bodies.

The rate is that of the law's approach. Velocities of nodes at a fixed patch tell how it changes in a kick; what the
patch's own way along the surfaces adds, which hardly changes from step to step, is the difference between how far the
approach went on the last way and what the nodes' velocities said then. Slopes of surfaces turn the force, as they
do the law's. Its work is that along the approach, by the mean of the forces at both ends of a way: what bodies lose, to
second order.

Of the whole approach of two bodies, of stiffness k, only a part is below the grid, of stiffness K: nodes carry the
rest. A damper c·(K/k)² beside the former takes the power of c beside the whole, and has its effect: of its force k/K
is what c would give, the rest makes up for what the law below the grid gives less.

Bodies are damped in what they do beside moving and turning as a whole. What moving as a whole is: of a ring whose held
row goes with hub or housing, moving with these, which take the reaction; of rollers and of a ring in play, the motion
that has the body's momentum and angular momentum.

Equation (1) of docs/damping.md.
"""

import numpy as np

from fem.kernels.drive import SPEED, OuterTurn, speed_of
from fem.kernels.elements import surfaces
from fem.kernels.elements.bodies import Bore
from fem.kernels.elements.contacts import first_surface, scatter_normal_forces
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import DiscSurface, Hub, Pair, RigidDisc, RingSurface
from fem.kernels.elements.surfaces import N_NODES
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import load_pair, maximum, minimum, store_pair
from fem.kernels.lanes import WIDTH, any_lane, count_from, gather, load, select, splat, store, total
from fem.kernels.law import STEEPEST, damping_coefficient
from fem.kernels.mounts import Housing


@part
def damp_contacts(groups, bodies, contacts, drive, later):
    """Forces of all contacts' dampers, and their impulses in this step.

    `later` : nodes of raceways are given these impulses with friction's
    """
    impulse, velocity = drive.impulse, drive.velocity
    impulse[0] = impulse[1] = 0.0  # the hub has had those of the laws
    _damp_all(groups, bodies.rollers, bodies.surface, contacts, drive.dt, later)
    velocity[0] += impulse[0] / drive.late_mass
    velocity[1] += impulse[1] / drive.late_mass
    drive.moment[1] += drive.hub[0] * impulse[1] - drive.hub[1] * impulse[0]


@part
def _damp(pair, rollers, disc, contacts, dt, later):
    dampers = contacts.dampers
    if pair.surface is None:
        for group in range(0, rollers.n, WIDTH):
            row = pair.row * rollers.columns + group
            left = load(dampers.left, row)
            if any_lane((load(contacts.forces.force, row) > 0.0) | (left == left)):
                _damp_in_turn(pair, rollers, disc, contacts, dt, group, min(group + WIDTH, rollers.n))
    elif contacts.friction.whole is None:
        _damp_eights(pair, rollers, disc, contacts, dt)
        if not later:
            scatter_normal_forces(pair, rollers, disc, contacts, dampers, dt)
    else:  # contacts share rigid bodies
        _damp_in_turn(pair, rollers, disc, contacts, dt, 0, rollers.n)


_damp_all = every(_damp, Pair)


@part
def _damp_eights(raceway, rollers, disc, contacts, dt):
    """Eight contacts at once; nodes have not been given the law's kick yet, and are to be given both together."""
    forces, patches, dampers, sign = contacts.forces, contacts.patches, contacts.dampers, raceway.sign
    side, columns, velocity, over = 2 * raceway.row, rollers.columns, rollers.velocity, 1.0 / rollers.total_mass
    taken, ring_x, ring_y, moment = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    surfaces.fill_ghost_nodes(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        Q, P, left = load(forces.force, row), load(forces.kick, row), load(dampers.left, row)
        closed = Q > 0.0
        if not any_lane(closed | (left == left)):
            continue
        nx, ny = load_pair(patches.normal, side * columns + group, columns)
        vx, vy = load_pair(velocity, group, columns)
        ring, ring_light = surfaces.out_of_surface(raceway.surface, patches, side, group)
        own, own_light = surfaces.out_of_surface(disc, patches, side + 1, group)
        out, mobility = sign * ring + own, (ring_light + own_light) * dt
        rate = out - sign * (vx * nx + vy * ny) - mobility * P
        behind, last = load(dampers.rate, row), load(dampers.force, row)
        passing = behind - left
        passing = select(passing == passing, passing, 0.0)
        level = _level(raceway.law, select(closed, Q, 1.0), load(forces.approach, row), load(forces.bracket, row))
        c, whole = _coefficient(raceway, dampers, minimum(Q, raceway.law.Q_line), level)
        F = select(closed, maximum(c * (rate + passing) / (1.0 + c * mobility), -P), 0.0)
        taken += select(behind == behind, (last + F) * behind, 0.0)
        store(dampers.force, row, F)
        store(dampers.whole_force, row, whole * F)
        store(dampers.left, row, select(closed, rate - mobility * F, np.nan))
        given, along = F * (sign * dt), F * load(dampers.along, row) * dt
        x, y = load_pair(rollers.node_impulse, group, columns)
        store_pair(rollers.node_impulse, group, columns, x + given * nx, y + given * ny)
        store_pair(velocity, group, columns, vx + along * ny * over, vy + -(along * nx) * over)
        turned = F * load(dampers.second, row) * dt
        store(rollers.turn_kick, group, load(rollers.turn_kick, group) + turned * (1.0 / rollers.inertia))
        ring_x -= along * ny
        ring_y += along * nx
        moment -= F * load(dampers.first, row)
    dampers.work[0] += 0.5 * dt * total(taken)
    raceway.impulse[0] += total(ring_x)
    raceway.impulse[1] += total(ring_y)
    raceway.moment[0] += total(moment)


@part
def _damp_in_turn(pair, rollers, disc, contacts, dt, first, end):
    """One contact after another, each with what those before have given: they share rigid bodies, or rollers."""
    patches, dampers, forces, velocity = contacts.patches, contacts.dampers, contacts.forces, rollers.velocity
    row, sign, moment, law = pair.row, pair.sign, 0.0, pair.law
    for j in range(first, end):
        if not forces.force[row, j] > 0.0:
            if dampers.force[row, j] != 0.0:
                dampers.work[0] += 0.5 * dt * dampers.force[row, j] * dampers.rate[row, j]
            dampers.force[row, j], dampers.whole_force[row, j], dampers.left[row, j] = 0.0, 0.0, np.nan
            continue
        nx, ny = patches.normal[row, 0, j], patches.normal[row, 1, j]
        if pair.surface is not None:
            i = j
            ring, ring_light = _velocity_out(pair.surface, patches, 2 * row, j, j, nx, ny)
            other = sign * (ring - velocity[0, j] * nx - velocity[1, j] * ny)
        else:
            i = j + 1 if j + 1 < rollers.n else 0
            other, ring_light = _velocity_out(disc, patches, 2 * row, j, j, nx, ny)
            other -= (velocity[0, i] - velocity[0, j]) * nx + (velocity[1, i] - velocity[1, j]) * ny
        own, own_light = _velocity_out(disc, patches, 2 * row + 1, j, i, nx, ny)
        rate, mobility, Q = other + own, ring_light + own_light, forces.force[row, j]
        level = _level(law, Q, forces.approach[row, j], forces.bracket[row, j])
        c, whole = _coefficient(pair, dampers, min(Q, law.Q_line), level)
        behind = dampers.rate[row, j]
        passing = behind - dampers.left[row, j]
        if not passing == passing:
            passing = 0.0
        F = max(c * (rate + passing) / (1.0 + c * mobility * dt), -forces.kick[row, j])
        if behind == behind:
            dampers.work[0] += 0.5 * dt * (dampers.force[row, j] + F) * behind
        dampers.force[row, j], dampers.whole_force[row, j] = F, F * whole
        dampers.left[row, j] = rate - mobility * dt * F
        given = dt * F
        x, y = sign * given * nx, sign * given * ny
        moment += _push_late(first_surface(pair, disc), patches, 2 * row, j, j, -sign * given, -x, -y)
        _push_late(disc, patches, 2 * row + 1, j, i, -given, x, y)
        along = given * dampers.along[row, j]
        _push_whole_roller(rollers, i, along * ny, -along * nx, given * dampers.second[row, j])
        if pair.surface is not None:
            pair.impulse[0] -= along * ny
            pair.impulse[1] += along * nx
            pair.moment[0] -= F * dampers.first[row, j]
        else:
            _push_whole_roller(rollers, j, -along * ny, along * nx, given * dampers.first[row, j])
    if pair.surface is not None:
        pair.moment[1] += moment


@part
def _velocity_out(surface, patches, side, j, column, nx, ny):
    """Velocity of a contact's patch out of its surface, m/s, and its mobility, 1/kg: of roller `column` against its
    centre of mass, of a rigid ring along n."""
    out, light, node = 0.0, 0.0, patches.start[side, j]
    if isinstance(surface, Hub):
        return surface.velocity[0] * nx + surface.velocity[1] * ny, 1.0 / surface.late_mass
    if isinstance(surface, RigidDisc):
        return 0.0, 1.0 / surface.total_mass
    if isinstance(surface, RingSurface):
        for k in range(N_NODES * len(patches.units)):
            at, share = node + HALO, patches.weight[side, k, j]
            out += patches.along[side, k, j] * surface.w[surface.row, 0, at]
            out += patches.across[side, k, j] * surface.w[surface.row, 1, at]
            light += share * share
            node = select(node >= surface.n_nodes - 1, 0, node + 1)
        return out, light / surface.node_mass
    if isinstance(surface, DiscSurface):
        bx, by, columns = patches.outward[side, 0, j], patches.outward[side, 1, j], surface.columns
        for k in range(N_NODES * len(patches.units)):
            i, share = surface.first + node, patches.weight[side, k, j]
            at = i * 2 * columns + column
            out += share * (bx * surface.w[at] + by * surface.w[at + columns])
            light += share * share * surface.inverse_mass[i]
            node = select(node >= surface.n_nodes - 1, 0, node + 1)
    return out, light


@part
def _push_late(surface, patches, side, j, column, impulse, x, y):
    """`surfaces.scatter_force` along b once bodies have had their kick; (x, y): fixed axes, N s. Returns its moment."""
    if isinstance(surface, Hub) or isinstance(surface, RigidDisc):
        return surfaces.push_body(surface, column, x, y, 0.0)
    group = j - j % WIDTH
    given = select(count_from(group) == j, impulse, 0.0)
    if isinstance(surface, RingSurface):
        surfaces.clear_ghost_nodes(surface)
        moment = total(surfaces.scatter_force(surface, patches, side, group, given, None))
        surfaces.accumulate_ghost_nodes(surface)
        return moment
    if isinstance(surface, DiscSurface):
        surface.impulse[0, column] += x
        surface.impulse[1, column] += y
        surfaces.scatter_force(surface, patches, side, group, given, None)
    return 0.0


@part
def _push_whole_roller(rollers, j, x, y, around):
    """An impulse, N s, on roller j as a whole, and one that turns it, N m s."""
    rollers.velocity[0, j] += x / rollers.total_mass
    rollers.velocity[1, j] += y / rollers.total_mass
    rollers.turn_kick[j] += around / rollers.inertia


@part
def _level(law, Q, approach, bracket):
    """B − ½ ln Q, from what the law below the grid, whose level is `bracket` at this place, makes of an approach, m."""
    return approach / (law.A * Q) + (law.B - bracket)


@part
def _coefficient(pair, dampers, Q, level):
    """N s/m beside the law below the grid under forces, N, scalars or lanes; what of that is beside the whole.

    `level` : B − ½ ln Q; of forces beyond the law's line whatever is below that at its beginning.
    """
    law, below = pair.law, maximum(level - 0.5, STEEPEST)
    whole = maximum(below + (dampers.whole[pair.row] - law.B), STEEPEST)
    over = 1.0 / (below * whole)
    softer, stiffness = whole * whole * over, below * over * (1.0 / law.A)
    return damping_coefficient(dampers.law, Q, stiffness) * softer * softer, below * below * over


# damping of bodies


@part
def damp_bodies(bodies, drive, damping):
    """Take their share from the velocities that bodies have beside moving and turning as a whole.

    Of a velocity v₀ before a kick and v₁ after it, of such motion, a share s = 1 − exp(−a dt) of v₀ is taken. From one
    kick to the next the energy of leapfrog, ½ v₀·M·v₁ + V, thereby loses ½ s v₁·M·(v₀ + v₁). The sum of that is of
    s v₀·M·v₀ over all kicks, less a quarter of the last one's, but for ¼ s (v₁ − v₀)·M·(v₁ − v₀), of third order in dt.
    """
    before, half, outer, around = damping.work[0], 0.5 * drive.dt, bodies.outer, damping.around
    _damp_rollers(bodies.disc, bodies.rollers, damping, drive.dt)
    c, s, speed, velocity = drive.frame[1], drive.frame[2], speed_of(drive), drive.velocity
    hub_x, hub_y = drive.hub[0] - half * velocity[0], drive.hub[1] - half * velocity[1]
    x, y = velocity[0] + speed * hub_y, velocity[1] - speed * hub_x
    x, y = _damp_ring(bodies.inner, damping, half, speed, c * x + s * y, c * y - s * x)
    velocity[0] += (c * x - s * y) / drive.mass
    velocity[1] += (s * x + c * y) / drive.mass
    if isinstance(around, OuterTurn):
        _damp_ring(outer, damping, half, around.now[SPEED], 0.0, 0.0)
    elif isinstance(around, Housing):
        x, y = _damp_ring(outer, damping, half, 0.0, around.velocity[0], around.velocity[1])
        around.impulse[0] += x
        around.impulse[1] += y
    elif isinstance(around, Bore):
        speed, x, y = _whole_motion(outer, half)
        _damp_ring(outer, damping, half, speed, x, y)
    else:  # a ring on the ground has no motion but its own
        _damp_ring(outer, damping, half, 0.0, 0.0, 0.0)
    damping.work[1] = damping.work[0] - before


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
    damping.work[0] += damping.share * total(lost)


@part(inlined=False)
def _damp_ring(ring, damping, half, speed, whole_x, whole_y):
    """Damp a ring's nodes but for what turns at a speed, rad/s, and moves at a velocity, m/s, in the ring's frame.

    `half` : s, half a step back, to where the velocities are. Returns the reaction, N s.
    """
    width, lost, back_x, back_y = ring.cosines.size, 0.0, 0.0, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_lost, part_x, part_y = splat(0.0), splat(0.0), splat(0.0)
        at = 2 * row * width
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            own_p = p + speed * y - (whole_x * e + whole_y * f)
            own_q = q - speed * x - (whole_y * e - whole_x * f)
            store(ring.w, at + k, p - damping.share * own_p)
            store(ring.w, at + width + k, q - damping.share * own_q)
            part_lost += own_p * own_p + own_q * own_q
            part_x += own_p * e - own_q * f
            part_y += own_p * f + own_q * e
        lost += ring.row_mass[row] * total(part_lost)
        back_x += ring.row_mass[row] * total(part_x)
        back_y += ring.row_mass[row] * total(part_y)
    damping.work[0] += damping.share * lost
    return damping.share * back_x, damping.share * back_y


@part(inlined=False)
def _whole_motion(ring, half):
    """Speed, rad/s, and velocity at the frame's origin, m/s, by a free ring's momentum and angular momentum."""
    width, mass, size, turning = ring.cosines.size, 0.0, 0.0, 0.0
    place_x, place_y, moved_x, moved_y = 0.0, 0.0, 0.0, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_size, part_turning, at, of_node = splat(0.0), splat(0.0), 2 * row * width, ring.row_mass[row]
        part_x, part_y, part_vx, part_vy = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            part_size += x * x + y * y
            part_turning += x * q - y * p
            part_x, part_y = part_x + (x * e - y * f), part_y + (x * f + y * e)
            part_vx, part_vy = part_vx + (p * e - q * f), part_vy + (p * f + q * e)
        mass, size = mass + of_node * ring.n_sectors, size + of_node * total(part_size)
        turning += of_node * total(part_turning)
        place_x, place_y = place_x + of_node * total(part_x), place_y + of_node * total(part_y)
        moved_x, moved_y = moved_x + of_node * total(part_vx), moved_y + of_node * total(part_vy)
    over = 1.0 / mass
    turning -= over * (place_x * moved_y - place_y * moved_x)
    speed = turning / (size - over * (place_x * place_x + place_y * place_y))
    return speed, over * (moved_x + speed * place_y), over * (moved_y - speed * place_x)
