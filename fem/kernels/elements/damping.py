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

from fem.kernels import lanes
from fem.kernels.drive import SPEED, OuterTurn, speed_of
from fem.kernels.elements import surfaces
from fem.kernels.elements.bodies import Bore
from fem.kernels.elements.contacts import first_surface, scatter_normal_forces, share_nodes, share_out
from fem.kernels.elements.rings import HALO
from fem.kernels.elements.state import Hub, Pair, RigidDisc
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import load_pair, maximum, minimum, next_rollers
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
    """Contacts of a raceway eight at once: their nodes are to be given the law's kick and the dampers' together.

    Those that share rigid bodies, or rollers, come one after another, after the law's kick, each with what those before
    have given.
    """
    forces, patches, dampers, sign, law = contacts.forces, contacts.patches, contacts.dampers, pair.sign, pair.law
    side, columns, n, velocity, surface = 2 * pair.row, rollers.columns, rollers.n, rollers.velocity, pair.surface
    count = 1 if surface is None or contacts.friction.whole is not None else WIDTH
    for group in range(0, n, WIDTH):
        row, number = pair.row * columns + group, count_from(group)
        for j in range(group, min(group + WIDTH, n), count):
            Q, P, left = load(forces.force, row), load(forces.kick, row), load(dampers.left, row)
            chosen = (number >= j) & (number < j + count)
            closed = chosen & (Q > 0.0)
            if not any_lane(closed | (chosen & (left == left))):
                continue
            nx, ny = load_pair(patches.normal, side * columns + group, columns)
            vx, vy = load_pair(velocity, group, columns)
            if surface is None:
                x, y = lanes.gather_pair(velocity, next_rollers(group, n), columns)
                vx, vy = x - vx, y - vy
            surfaces.ghost_nodes(first_surface(pair, disc), surfaces.FILL)
            first, light = surfaces.out_of_surface(first_surface(pair, disc), patches, side, group, nx, ny)
            second, own_light = surfaces.out_of_surface(disc, patches, side + 1, group, nx, ny)
            rate, mobility = sign * first + second - sign * (vx * nx + vy * ny), (light + own_light) * dt
            if count == WIDTH:
                rate = rate - mobility * P
            behind, last = load(dampers.rate, row), load(dampers.force, row)
            passing = behind - left
            passing = select(passing == passing, passing, 0.0)
            # B − ½ ln Q, from what the law, whose level is `bracket` at this place, makes of an approach
            level = load(forces.approach, row) / (law.A * select(closed, Q, 1.0)) + (law.B - load(forces.bracket, row))
            c, share = _coefficient(pair, dampers, minimum(Q, law.Q_line), level)
            F = select(closed, maximum(c * (rate + passing) / (1.0 + c * mobility), -P), 0.0)
            dampers.work[0] += 0.5 * dt * total(select(chosen & (behind == behind), (last + F) * behind, 0.0))
            store(dampers.force, row, select(chosen, F, last))
            store(dampers.whole_force, row, select(chosen, share * F, load(dampers.whole_force, row)))
            store(dampers.left, row, select(chosen, select(closed, rate - mobility * F, np.nan), left))
            given, along = F * (sign * dt), F * load(dampers.along, row) * dt
            x, y = given * nx, given * ny
            share_nodes(pair, rollers, disc, group, x, y)
            if count == 1:
                px, py, i = total(x), total(y), j
                if surface is None:
                    i = j + 1 if j + 1 < n else 0
                moment = _push_late(first_surface(pair, disc), patches, side, group, j, -given, -px, -py)
                _push_late(disc, patches, side + 1, group, i, given * -sign, px, py)
                if surface is not None:
                    pair.moment[1] += moment
            x, y, turning = along * ny, -(along * nx), F * (dt / rollers.inertia)
            share_out(velocity, pair, group, n, x * (1.0 / rollers.total_mass), y * (1.0 / rollers.total_mass))
            if surface is not None:
                lanes.scatter_add(rollers.turn_kick, group, turning * load(dampers.second, row))
                pair.impulse[0] -= total(x)
                pair.impulse[1] -= total(y)
                pair.moment[0] -= total(F * load(dampers.first, row))
            else:
                lanes.scatter_add(rollers.turn_kick, next_rollers(group, n), turning * load(dampers.second, row))
                lanes.scatter_add(rollers.turn_kick, group, turning * load(dampers.first, row))
    if surface is not None and count == WIDTH and not later:
        scatter_normal_forces(pair, rollers, disc, contacts, dampers, dt)


_damp_all = every(_damp, Pair)


@part
def _push_late(surface, patches, side, group, column, given, x, y):
    """`surfaces.scatter_force` along b once bodies have had their kick; (x, y): fixed axes, N s. Returns its moment."""
    if isinstance(surface, Hub) or isinstance(surface, RigidDisc):
        return surfaces.push_body(surface, column, x, y, 0.0)
    surfaces.ghost_nodes(surface, surfaces.CLEAR)
    moment = total(surfaces.scatter_force(surface, patches, side, group, given, None))
    surfaces.ghost_nodes(surface, surfaces.GIVE)
    return moment


@part
def _coefficient(pair, dampers, Q, level):
    """N s/m beside the law below the grid under forces, N, of eight contacts; what of that is beside the whole.

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
    width, lost, back_x, back_y = ring.cosines.size, splat(0.0), splat(0.0), splat(0.0)
    for row in range(ring.first_row, ring.last_row):
        at, mass = 2 * row * width, ring.row_mass[row]
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            own_p = p + speed * y - (whole_x * e + whole_y * f)
            own_q = q - speed * x - (whole_y * e - whole_x * f)
            store(ring.w, at + k, p - damping.share * own_p)
            store(ring.w, at + width + k, q - damping.share * own_q)
            lost += mass * (own_p * own_p + own_q * own_q)
            back_x += mass * (own_p * e - own_q * f)
            back_y += mass * (own_p * f + own_q * e)
    damping.work[0] += damping.share * total(lost)
    return damping.share * total(back_x), damping.share * total(back_y)


@part(inlined=False)
def _whole_motion(ring, half):
    """Speed, rad/s, and velocity at the frame's origin, m/s, by a free ring's momentum and angular momentum."""
    width, mass, size, turning = ring.cosines.size, 0.0, splat(0.0), splat(0.0)
    place_x, place_y, moved_x, moved_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for row in range(ring.first_row, ring.last_row):
        at, m = 2 * row * width, ring.row_mass[row]
        mass += m * ring.n_sectors
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            size += m * (x * x + y * y)
            turning += m * (x * q - y * p)
            place_x, place_y = place_x + m * (x * e - y * f), place_y + m * (x * f + y * e)
            moved_x, moved_y = moved_x + m * (p * e - q * f), moved_y + m * (p * f + q * e)
    over, x, y = 1.0 / mass, total(place_x), total(place_y)
    vx, vy = total(moved_x), total(moved_y)
    speed = (total(turning) - over * (x * vy - y * vx)) / (total(size) - over * (x * x + y * y))
    return speed, over * (vx + speed * y), over * (vy - speed * x)
