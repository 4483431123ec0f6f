"""Forces of the reduced model's contacts at given positions.

The approach of a raceway's contact under its own law and the forces on other contacts of its bodies:

    approach = overlap of the circles − across·(force on the roller's other contact) − Σ along_k·(force k rollers away)
               − Σ crossed_k·(traction k rollers away)

Those forces are extrapolated from the last steps (predictor), the law gives force and stiffness, and two linear sweeps
correct them (corrector): the error left is the square of a few hundredths of the predictor's. In rings of soft material
with many rollers a neighbour's compliance is as large as a contact's own, and whole load zones would gain and lose
force alternately: there the increments that neighbours use are multiplied by a relaxation factor
(`fem.solver.rigid.reduced.relaxation_factor`).

Equation (1) of docs/reduced.md.
"""

from math import cos, sin

from fem.kernels.drive import SPEED, on_outer, outer_of
from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import cosine_and_sine, logarithm, maximum
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, select, splat, square_root, total
from fem.kernels.law import STEEPEST, distant_force
from fem.kernels.reduced_housing import ring_place
from fem.kernels.reduced_state import INNER, OUTER
from fem.kernels.state import LoadHistory
from fem.kernels.surfaces import lowered_ring, lowered_rollers

NEAR = 0.03  # of a force: a step of third order no longer leaves a hundredth of its cube, less than sweeps do


@part
def wrap(array, row, n, halo):
    """Repeat a ring's first and last contacts beyond its ends."""
    for k in range(halo):
        array[row, halo - 1 - k] = array[row, halo + n - 1 - k]
        array[row, halo + n + k] = array[row, halo + k]


@part
def coupled_approach(compliance, forces, array, row, group):
    """Approach of eight contacts, m, that forces along their ring take away."""
    found, to, columns = splat(0.0), _place(forces, row, group), forces.normal.shape[2]
    for k in range(compliance.felt[row, 1]):
        Q = load(array, to + compliance.distance[k])
        found += load(forces.along, (row * compliance.distance.size + k) * columns + group) * Q
    return found


@part
def raceway_tilt(compliance, forces, row, group):
    """How fast the approach of eight contacts grows along their ring by the forces guessed, m/rad."""
    found, to, columns = splat(0.0), _place(forces, row, group), forces.normal.shape[2]
    for k in range(compliance.felt[row, 0]):
        Q = load(forces.guess, to + compliance.distance[k])
        found += load(forces.steep, (row * compliance.distance.size + k) * columns + group) * Q
    return found


@part
def lift(compliance, forces, drive, row, group):
    """Approach of eight contacts, m, that tractions along their ring, of the last step, take away."""
    found = splat(0.0)
    if drive.friction > 0.0:
        to = _place(forces, row, group)
        for k in range(compliance.crossing[row]):
            # Compliance of eight contacts by a neighbour's traction, m/N.
            if compliance.spacing is None:
                crossed = splat(compliance.crossed[row, k])
            else:
                shape = compliance.spacing.crossed.shape
                crossed = load(compliance.spacing.crossed, (row * shape[1] + k) * shape[2] + group)
            found += load(forces.pulled, to + compliance.distance[k]) * crossed
        store(forces.lifted, row * forces.normal.shape[2] + group, found)
    return found


@part
def _place(forces, row, group):
    """Of eight contacts in an array with a halo."""
    return row * forces.guess.shape[1] + forces.halo + group


@part
def level(law, brackets, at):
    """B of eight contacts."""
    if brackets is None:
        return splat(law.B)
    return load(brackets, at)


@part
def _force(law, B, approach, guess):
    """Forces of eight approaches, N, and their stiffness, N/m, 0 of open contacts.

    From a good guess one step of third order, from a fair one two, from any other `law.distant_force`.
    """
    known = guess > 0.0
    Q, stiffness, step = _nearer(law, B, approach, select(known, guess, 1.0))
    rough = known & ((absolute(step) >= NEAR) | (Q >= law.Q_line))
    if any_lane(rough):
        Q, stiffness, step = _nearer(law, B, approach, select(known, maximum(Q, 0.1 * guess), 1.0))
        rough = known & ((absolute(step) >= NEAR) | (Q >= law.Q_line))
    found, stiffness = select(known, Q, 0.0), select(known, stiffness, 0.0)
    if any_lane(rough | ((guess <= 0.0) & (approach > 0.0))):
        found = distant_force(approach, law.A, B, law.Q_line, guess)
        closed = found > 0.0
        soft = select(closed, approach, 1.0) / select(closed, found, 1.0) - 0.5 * law.A
        stiffness = select(closed, 1.0 / maximum(soft, STEEPEST * law.A), 0.0)
    return found, stiffness


@part
def _nearer(law, B, approach, Q):
    """Forces of eight approaches by a step of third order from forces Q > 0, their stiffness, and the step over Q."""
    bracket = B - 0.5 * logarithm(Q)
    relative = 1.0 / (law.A * Q * (bracket - 0.5))  # stiffness over force
    step = (approach - law.A * Q * bracket) * relative
    stiffness = relative * Q
    bend = 0.5 * law.A * stiffness * step
    return Q + Q * step * (1.0 + 0.5 * bend), stiffness * (1.0 + bend), step


@part
def both_forces(inner, outer, by_inner, by_outer, guess_inner, guess_outer):
    """A roller's two forces, each with the other's change; `by_`: stiffness times what a newton on the other does."""
    beyond_inner, beyond_outer = inner - guess_inner, outer - guess_outer
    more = by_inner * (by_outer * beyond_inner - beyond_outer) / (1.0 - by_inner * by_outer)
    return inner + more, outer - by_outer * (beyond_inner + more)


@part
def estimate_forces(bodies, compliance, forces, drive, turn):
    """Forces by the guess: their approach, stiffness and normals; and what they gain with a roller's other contact.

    `turn` : rad, of the inner ring.
    """
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    inner, outer = compliance.inner, compliance.outer
    reach, track = touching(drive.history, compliance, drive)
    ring_x, ring_y = ring_place(bodies.housing)
    for group in range(0, n, WIDTH):
        there = count_from(group) < n
        x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
        from_x, from_y = x - ring_x, y - ring_y + compliance.sag[1]
        out = square_root(select(there, from_x * from_x + from_y * from_y, 1.0))
        over_o = 1.0 / out
        from_x, from_y = select(there, from_x * over_o, 1.0), select(there, from_y * over_o, 0.0)
        store_pair(forces.normal, 2 * columns + group, columns, from_x, from_y)
        x, y = x - bodies.hub[0], y - bodies.hub[1] + compliance.sag[0]
        away = square_root(select(there, x * x + y * y, 1.0))
        over_i = 1.0 / away
        store_pair(forces.normal, group, columns, select(there, x * over_i, 1.0), select(there, y * over_i, 0.0))
        at = halo + group
        guess_i, guess_o = load(forces.guess, at), load(forces.guess, width + at)
        guess_i, guess_o = select(there, guess_i, 0.0), select(there, guess_o, 0.0)
        first_i = reach - away - across * guess_o - coupled_approach(compliance, forces, forces.guess, INNER, group)
        first_o = out - track - across * guess_i - coupled_approach(compliance, forces, forces.guess, OUTER, group)
        first_i -= lift(compliance, forces, drive, INNER, group)
        first_o -= lift(compliance, forces, drive, OUTER, group)
        tilt_i, tilt_o = raceway_tilt(compliance, forces, INNER, group), raceway_tilt(compliance, forces, OUTER, group)
        store_pair(forces.tilt, group, columns, tilt_i * over_i, tilt_o * over_o)
        if forces.taken is not None:
            store_pair(forces.taken, group, columns, (reach - away - first_i), (out - track - first_o))
        first_i, first_o = _lowered(
            bodies,
            compliance,
            forces,
            group,
            (turn, drive.looks, outer_of(drive.history)),
            first_i,
            first_o,
            forces.slope,
        )
        first_i, first_o = select(there, first_i, -1.0), select(there, first_o, -1.0)
        B_i, B_o = level(inner, forces.bracket_now, group), level(outer, forces.bracket_now, columns + group)
        Q_i, stiff_i = _force(inner, B_i, first_i, guess_i)
        Q_o, stiff_o = _force(outer, B_o, first_o, guess_o)
        store_pair(forces.first, group, columns, first_i, first_o)
        store_pair(forces.estimate, group, columns, Q_i, Q_o)
        store_pair(forces.stiffness, group, columns, stiff_i, stiff_o)
        Q_i, Q_o = both_forces(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
        store_pair(
            forces.gained,
            at,
            width,
            compliance.relaxation_factor * (Q_i - guess_i),
            compliance.relaxation_factor * (Q_o - guess_o),
        )
    wrap(forces.gained, INNER, n, halo)
    wrap(forces.gained, OUTER, n, halo)


@verb
def touching(history, compliance, drive):
    """Distances from hub and centre, m, at which rollers touch the rings, grown by their spin."""
    return compliance.reach, compliance.track


@touching.of(LoadHistory)
def _touching_now(history, compliance, drive):
    more = history.now[SPEED] * history.now[SPEED] - drive.speed * drive.speed
    reach, track = compliance.reach + history.growth * more, compliance.track - history.roller_growth * more
    outer = history.outer
    if outer is None:
        return reach, track
    # where the outer ring turns rollers spin by the difference of both surfaces' speeds, and it grows
    ratio = outer.radius / drive.inner_radius
    now, first = history.now[SPEED] - ratio * outer.now[SPEED], drive.speed - ratio * outer.speed
    spun = history.roller_growth * (now * now - first * first - more)  # beyond what the shaft alone makes of it
    grown = outer.growth * (outer.now[SPEED] * outer.now[SPEED] - outer.speed * outer.speed)
    return reach + spun, track - spun + grown


@part
def _lowered(bodies, compliance, forces, group, where, inner, outer, slope):
    """Approaches of eight rollers on surfaces that are not perfect circles; laws' brackets and slopes are kept.

    `where` : turn of the inner ring, rad; whether any contact is where they are not; how the outer ring turns
    """
    if slope is None:
        return inner, outer
    turn, looks, turning = where
    if not looks:
        return inner, outer
    columns = bodies.columns
    ring, own, ring_o, own_o = met_surfaces(slope, bodies, compliance, forces, group, turn, turning)
    store_pair(slope, group, columns, ring[1] + own[1], own[1])
    store_pair(slope, 2 * columns + group, columns, ring_o[1] + own_o[1], own_o[1])
    store_pair(forces.softening, group, columns, ring[3] + own[3], own[3])
    store_pair(forces.softening, 2 * columns + group, columns, ring_o[3] + own_o[3], own_o[3])
    B_i = compliance.inner.B + (ring[2] + own[2]) * (1.0 / compliance.inner.A)
    B_o = compliance.outer.B + (ring_o[2] + own_o[2]) * (1.0 / compliance.outer.A)
    store_pair(forces.bracket_now, group, columns, B_i, B_o)
    return inner + ring[0] + own[0], outer + ring_o[0] + own_o[0]


@part
def met_surfaces(slope, bodies, compliance, forces, group, turn, outer):
    """What eight rollers' contacts meet of inner ring, roller, outer ring and roller; on perfect circles nothing.

    Each minus the sinkage, m, minus its slope per rad, the compliance of edges, m/N, and its slope.
    """
    still = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    if slope is None:
        return still, still, still, still
    columns = bodies.columns
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    c, s = cos(turn), sin(turn)
    ring = lowered_ring(compliance.ring_profiles[0], 1.0, still, c * ix + s * iy, c * iy - s * ix)
    bx, by = on_outer(outer, ox, oy)
    ring_o = lowered_ring(compliance.ring_profiles[1], 1.0, still, bx, by)
    c, s = cosine_and_sine(load(bodies.turn, group))
    own = lowered_rollers(compliance.roller_profiles[0], group, still, -(c * ix + s * iy), s * ix - c * iy)
    own_o = lowered_rollers(compliance.roller_profiles[1], group, still, c * ox + s * oy, c * oy - s * ox)
    return ring, own, ring_o, own_o


@part
def store_pair(array, at, apart, one, other):
    store(array, at, one)
    store(array, at + apart, other)


@part
def corrected_forces(bodies, compliance, forces):
    """The forces with what all others have gained; their sums on hub and outer ring, N.

    Leaves approaches in `first`.
    """
    columns, n, halo = bodies.columns, bodies.n, forces.halo
    width, across = columns + 2 * halo, compliance.across
    hub_x, hub_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        at = halo + group
        less_i = coupled_approach(compliance, forces, forces.gained, INNER, group)
        less_o = coupled_approach(compliance, forces, forces.gained, OUTER, group)
        stiff_i, stiff_o = load(forces.stiffness, group), load(forces.stiffness, columns + group)
        guess_i, guess_o = load(forces.guess, at), load(forces.guess, width + at)
        Q_i = load(forces.estimate, group) - stiff_i * less_i
        Q_o = load(forces.estimate, columns + group) - stiff_o * less_o
        Q_i, Q_o = both_forces(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
        Q_i, Q_o = maximum(Q_i, 0.0), maximum(Q_o, 0.0)
        store_pair(forces.estimate, group, columns, Q_i, Q_o)
        first_i, first_o = load(forces.first, group), load(forces.first, columns + group)
        take_more(forces.taken, columns, group, less_i + across * (Q_o - guess_o), less_o + across * (Q_i - guess_i))
        first_i = first_i - less_i - across * (Q_o - guess_o)
        first_o = first_o - less_o - across * (Q_i - guess_i)
        store_pair(forces.first, group, columns, first_i, first_o)
        hub_x -= Q_i * load(forces.normal, group)
        hub_y -= Q_i * load(forces.normal, columns + group)
        ring_x += Q_o * load(forces.normal, 2 * columns + group)
        ring_y += Q_o * load(forces.normal, 3 * columns + group)
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part
def take_more(taken, columns, group, inner, outer):
    if taken is not None:
        at = columns + group
        store_pair(taken, group, columns, load(taken, group) + inner, load(taken, at) + outer)
