"""Dampers of contacts.

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

Equation (1) of docs/damping.md.
"""

import numpy as np

from fem.kernels.bodies import take_all_late
from fem.kernels.contact_kernels import first_surface, next_roller, scatter_normal_forces
from fem.kernels.jit import every, part, verb
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, total
from fem.kernels.law import STEEPEST, damping_coefficient
from fem.kernels.patches import N_NODES
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import DiscSurface, Hub, Pair, RigidDisc, RingSurface
from fem.kernels.surfaces import (
    accumulate_ghost_nodes,
    clear_ghost_nodes,
    fill_ghost_nodes,
    next_node,
    out_of_surface,
    push_body,
    scatter_normal_force,
)


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
    return hub.velocity[0] * nx + hub.velocity[1] * ny, 1.0 / hub.late_mass


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
        light += share * share * disc.inverse_mass[i]
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
    """`scatter_normal_force` once bodies have had their kick; (x, y): fixed axes, N s. Returns its moment."""
    return 0.0


@push_late.of(RingSurface)
def _push_ring(ring, patches, side, j, column, impulse, x, y):
    group, given = _alone(j, impulse)
    clear_ghost_nodes(ring)
    moment = total(scatter_normal_force(ring, patches, side, group, given))
    accumulate_ghost_nodes(ring)
    return moment


@push_late.of(DiscSurface)
def _push_disc(disc, patches, side, j, column, impulse, x, y):
    disc.impulse[0, column] += x
    disc.impulse[1, column] += y
    group, given = _alone(j, impulse)
    return scatter_normal_force(disc, patches, side, group, given)


@push_late.of(Hub, RigidDisc)
def _push_rigid(body, patches, side, j, column, impulse, x, y):
    return push_body(body, column, x, y, 0.0)


@part
def damp(pair, rollers, disc, contacts, dampers, dt, whole, later):
    """Damp a pair's closed contacts. `whole` : of `Friction`; not None where contacts share rigid bodies.

    `later` : nodes of raceways are given these impulses with friction's, see `friction_solution.pushes_later`.
    """
    if pair.surface is None:
        for group in range(0, rollers.n, WIDTH):
            row = pair.row * rollers.columns + group
            left = load(dampers.left, row)
            if any_lane((load(contacts.forces.force, row) > 0.0) | (left == left)):
                _damp_in_turn(pair, rollers, disc, contacts, dampers, dt, group, min(group + WIDTH, rollers.n))
    elif whole is None:
        _damp_eights(pair, rollers, disc, contacts, dampers, dt)
        if not later:
            scatter_normal_forces(pair, rollers, disc, contacts, dampers, dt)
    else:
        _damp_in_turn(pair, rollers, disc, contacts, dampers, dt, 0, rollers.n)


@part
def _damp_eights(raceway, rollers, disc, contacts, dampers, dt):
    """Eight contacts at once; nodes have not been given the law's kick yet, and are to be given both together."""
    forces, patches, columns, sign = contacts.forces, contacts.patches, rollers.columns, raceway.sign
    side, impulse, velocity = 2 * raceway.row, rollers.node_impulse, rollers.velocity
    taken, ring_x, ring_y, moment = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    fill_ghost_nodes(raceway.surface)
    for group in range(0, rollers.n, WIDTH):
        row = raceway.row * columns + group
        Q, P, left = load(forces.force, row), load(forces.kick, row), load(dampers.left, row)
        closed = Q > 0.0
        if not any_lane(closed | (left == left)):
            continue
        nx, ny = load(patches.normal, side * columns + group), load(patches.normal, (side + 1) * columns + group)
        ring, ring_light = out_of_surface(raceway.surface, patches, side, group)
        own, own_light = out_of_surface(disc, patches, side + 1, group)
        out, mobility = sign * ring + own, (ring_light + own_light) * dt
        rate = out - sign * (load(velocity, group) * nx + load(velocity, columns + group) * ny) - mobility * P
        behind, last = load(dampers.rate, row), load(dampers.force, row)
        passing = behind - left
        passing = select(passing == passing, passing, 0.0)
        level = _level(raceway.law, select(closed, Q, 1.0), load(forces.approach, row), load(forces.bracket, row))
        c, felt = _coefficient(raceway, dampers, minimum(Q, raceway.law.Q_line), level)
        F = select(closed, maximum(c * (rate + passing) / (1.0 + c * mobility), -P), 0.0)
        taken += select(behind == behind, (last + F) * behind, 0.0)
        store(dampers.force, row, F)
        store(dampers.felt, row, felt * F)
        store(dampers.left, row, select(closed, rate - mobility * F, np.nan))
        given = F * (sign * dt)
        store(impulse, group, load(impulse, group) + given * nx)
        store(impulse, columns + group, load(impulse, columns + group) + given * ny)
        aside = F * load(dampers.along, row) * dt
        _push_rollers_aside(rollers, group, aside * ny, -(aside * nx), F * load(dampers.second, row) * dt)
        ring_x -= aside * ny
        ring_y += aside * nx
        moment -= F * load(dampers.first, row)
    dampers.work[0] += 0.5 * dt * total(taken)
    raceway.impulse[0] += total(ring_x)
    raceway.impulse[1] += total(ring_y)
    raceway.moment[0] += total(moment)


@part
def _push_rollers_aside(rollers, group, x, y, around):
    """Impulses, N s, on eight rollers as a whole, and those that turn them, N m s."""
    columns, velocity, over = rollers.columns, rollers.velocity, 1.0 / rollers.total_mass
    store(velocity, group, load(velocity, group) + x * over)
    store(velocity, columns + group, load(velocity, columns + group) + y * over)
    store(rollers.turn_kick, group, load(rollers.turn_kick, group) + around * (1.0 / rollers.inertia))


@part
def _damp_in_turn(pair, rollers, disc, contacts, dampers, dt, first, end):
    """One contact after another, each with what those before have given: they share rigid bodies, or rollers."""
    patches, velocity, row, sign, moment = contacts.patches, rollers.velocity, pair.row, pair.sign, 0.0
    for j in range(first, end):
        if not contacts.forces.force[row, j] > 0.0:
            _let_go(dampers, row, j, dt)
            continue
        nx, ny = patches.normal[row, 0, j], patches.normal[row, 1, j]
        if pair.surface is not None:
            i = j
            ring, ring_light = velocity_out(pair.surface, patches, 2 * row, j, nx, ny)
            other = sign * (ring - velocity[0, j] * nx - velocity[1, j] * ny)
        else:
            i = next_roller(j, rollers.n)
            other, ring_light = roller_out(disc, patches, 2 * row, j, j)
            other -= (velocity[0, i] - velocity[0, j]) * nx + (velocity[1, i] - velocity[1, j]) * ny
        own, own_light = roller_out(disc, patches, 2 * row + 1, j, i)
        given = dt * _damper_force(pair, contacts.forces, dampers, j, other + own, ring_light + own_light, dt)
        x, y = sign * given * nx, sign * given * ny
        moment += push_late(first_surface(pair, disc), patches, 2 * row, j, j, -sign * given, -x, -y)
        push_late(disc, patches, 2 * row + 1, j, i, -given, x, y)
        aside = given * dampers.along[row, j]
        _push_roller_aside(rollers, i, aside * ny, -aside * nx, given * dampers.second[row, j])
        if pair.surface is not None:
            pair.impulse[0] -= aside * ny
            pair.impulse[1] += aside * nx
            pair.moment[0] -= dampers.force[row, j] * dampers.first[row, j]
        else:
            _push_roller_aside(rollers, j, -aside * ny, aside * nx, given * dampers.first[row, j])
    if pair.surface is not None:
        pair.moment[1] += moment


@part
def _push_roller_aside(rollers, j, x, y, around):
    """An impulse, N s, on roller j as a whole, and one that turns it, N m s."""
    rollers.velocity[0, j] += x / rollers.total_mass
    rollers.velocity[1, j] += y / rollers.total_mass
    rollers.turn_kick[j] += around / rollers.inertia


_damp_all = every(damp, Pair)


@part
def damp_contacts(groups, bodies, contacts, dampers, drive, later):
    """Forces of all contacts' dampers, and their impulses in this step; None: there are none. `later`: see `damp`."""
    if dampers is not None:
        impulse, velocity = drive.impulse, drive.velocity
        impulse[0] = impulse[1] = 0.0  # the hub has had those of the laws
        _damp_all(groups, bodies.rollers, bodies.surface, contacts, dampers, drive.dt, contacts.friction.whole, later)
        velocity[0] += impulse[0] / drive.late_mass
        velocity[1] += impulse[1] / drive.late_mass
        drive.moment[1] += drive.hub[0] * impulse[1] - drive.hub[1] * impulse[0]
        take_all_late(bodies.others)


@part
def _let_go(dampers, row, j, dt):
    """An open contact is not damped."""
    if dampers.force[row, j] != 0.0:
        dampers.work[0] += 0.5 * dt * dampers.force[row, j] * dampers.rate[row, j]
    dampers.force[row, j] = 0.0
    dampers.felt[row, j] = 0.0
    dampers.left[row, j] = np.nan


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


@part
def _damper_force(pair, forces, dampers, j, rate, mobility, dt):
    """Force of a contact's damper, N. `rate` : m/s, by the nodes' velocities before it; `mobility` : 1/kg."""
    row, Q = pair.row, forces.force[pair.row, j]
    level = _level(pair.law, Q, forces.approach[row, j], forces.bracket[row, j])
    c, felt = _coefficient(pair, dampers, min(Q, pair.law.Q_line), level)
    behind = dampers.rate[row, j]
    passing = behind - dampers.left[row, j]
    if not passing == passing:
        passing = 0.0
    force = max(c * (rate + passing) / (1.0 + c * mobility * dt), -forces.kick[row, j])
    if behind == behind:
        dampers.work[0] += 0.5 * dt * (dampers.force[row, j] + force) * behind
    dampers.force[row, j], dampers.felt[row, j] = force, force * felt
    dampers.left[row, j] = rate - mobility * dt * force
    return force
