"""CONTACT FORCES of rigid bodies at given places: approaches, laws, and what contacts of one body do to each other.

Where bodies are elastic (`Contacts.coupling`) a contact's approach depends on the forces on others:

    approach = overlap of the circles − across·(force on the roller's other contact) − Σ along_k·(force k rollers away)
               − Σ crossed_k·(traction k rollers away)

Those forces are extrapolated from the last steps (predictor), the law gives force and stiffness, and a linear sweep
corrects them (corrector): the error left is the square of a few hundredths of the predictor's. In rings of soft
material with many rollers a neighbour's compliance is as large as a contact's own, and whole load zones would gain and
lose force alternately: there the increments that neighbours use are multiplied by a relaxation factor
(`fem.solver.rigid.reduced.relaxation_factor`). Rigid bodies have no coupling: each contact is alone with its law.

Where rollers tilt (`Contacts.tilted`) a contact is a table of energy by approach and misalignment. The misalignment is
the bodies' plus the response to moments along its ring: a ring of the compliance C under a force that is spread along
the length L has 12 C/L² under a moment. Forces, moments and energy further on follow by Taylor's series of second
order from one look at the table, whose derivatives are exact.

Equation (1) of docs/reduced.md.
"""

from fem.kernels.columns import INNER, OUTER
from fem.kernels.drive import SPEED, turn_at
from fem.kernels.jit import part
from fem.kernels.lane_functions import arc_tangent, exponential, load_pair, logarithm, maximum, minimum, store_pair
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, load, select, splat, square_root, store, total
from fem.kernels.law import STEEPEST, distant_force, next_force, stored_energy
from fem.kernels.mounts import ring_place
from fem.kernels.rigid.state import CROSS, MOMENT, SLOPE, PowerConstants, normals
from fem.kernels.rigid.surfaces import keep_edges, keep_slopes, surfaces_met
from fem.kernels.tilted_contact import table_at
from fem.kernels.tilts import push_axes

AGAIN = 16  # steps, and at samples, between looks at angles: compliances change by far less than forces are solved to
NEAR = 0.03  # of a force: a step of third order no longer leaves a hundredth of its cube, less than sweeps do
MOST_STEPS, SETTLED = 60, 1e-10  # of Newton's method, and of a depth: what is left is of its square


@part
def find_forces(step, inside):
    """Forces and moments of all contacts; sums of the forces on hub and outer ring, N."""
    bodies, contacts, forces, drive = step.bodies, step.contacts, step.forces, step.drive
    coupling, tilted, tilts, columns = contacts.coupling, contacts.tilted, bodies.tilts, bodies.columns
    if coupling is not None:
        if inside % AGAIN == 0:
            follow_angles(bodies, coupling, forces)
    reach, track = touching(contacts, drive)
    ring_x, ring_y = ring_place(bodies.housing)
    turn = turn_at(drive, step.time)
    for group in range(0, bodies.n, WIDTH):
        there, guess_i, guess_o = count_from(group) < bodies.n, splat(0.0), splat(0.0)
        x, y = load_pair(bodies.centre, group, columns)
        out, ox, oy = direction(x - ring_x, y - ring_y + contacts.sag[1], there)
        away, ix, iy = direction(x - bodies.hub[0], y - bodies.hub[1] + contacts.sag[0], there)
        store_pair(forces.normal, group, columns, ix, iy)
        store_pair(forces.normal, 2 * columns + group, columns, ox, oy)
        deep_i, deep_o = reach - away, out - track
        if forces.slope is not None:
            met = surfaces_met(step, group, turn)
            deep_i = keep_edges(step, INNER, group, met, deep_i)
            deep_o = keep_edges(step, OUTER, group, met, deep_o)
        if coupling is not None:
            guess_i, guess_o = guesses(forces, forces.guess, group, there)
            less_i, less_o = along_rings(coupling, forces, forces.guess, group)
            less_i, less_o = coupling.across * guess_o + less_i, coupling.across * guess_i + less_o
            if drive.friction > 0.0:  # what tractions along the rings, of the last step, take away
                counts = coupling.crossing[INNER], coupling.crossing[OUTER]
                lift_i, lift_o = _summed(coupling, forces, coupling.crossed, forces.pulled, counts, group)
                store_pair(forces.lifted, group, columns, lift_i, lift_o)
                less_i, less_o = less_i + lift_i, less_o + lift_o
            # how fast approaches grow along the rings by the forces guessed, m/rad: rollers that neither friction nor a
            # cage holds apart are spread by that
            counts = coupling.counts[INNER, 0], coupling.counts[OUTER, 0]
            tilt_i, tilt_o = _summed(coupling, forces, forces.steep, forces.guess, counts, group)
            over_i, over_o = 1.0 / away, 1.0 / out
            if tilted is not None:
                over_i, over_o = splat(1.0 / contacts.reach), splat(1.0 / contacts.track)
            store_pair(forces.tilt, group, columns, tilt_i * over_i, tilt_o * over_o)
            if forces.taken is not None:
                store_pair(forces.taken, group, columns, less_i, less_o)
            deep_i, deep_o = deep_i - less_i, deep_o - less_o
        deep_i, deep_o = select(there, deep_i, -1.0), select(there, deep_o, -1.0)
        if tilted is None:
            Q_i = _look(step, contacts.inner, group, deep_i, guess_i)
            Q_o = _look(step, contacts.outer, columns + group, deep_o, guess_o)
        else:
            tilt = load(tilts.tilt, group)
            slope_i = (tilt * ox - tilts.slope[0]) * ix + (tilt * oy - tilts.slope[1]) * iy
            slope_o = -tilt
            if coupling is not None:
                turn_i, turn_o = along_rings(coupling, forces, forces.tilted.guess, group)
                slope_i, slope_o = slope_i + tilted.share * turn_i, slope_o + tilted.share * turn_o
            Q_i, M_i = _look_up(forces, (tilted.tables[0], tilted.rests[0]), columns, group, deep_i, slope_i)
            Q_o, M_o = _look_up(forces, (tilted.tables[1], tilted.rests[1]), columns, columns + group, deep_o, slope_o)
        if coupling is not None:  # keep what forces, each with the other's change, turn out beyond the guesses
            by_i, by_o = load_pair(forces.stiffness, group, columns)
            by_i, by_o = by_i * coupling.across, by_o * coupling.across
            Q_i, Q_o = both_forces(Q_i, Q_o, by_i, by_o, guess_i, guess_o)
            at, width, factor = forces.halo + group, forces.gained.shape[1], coupling.relaxation_factor
            store_pair(forces.gained, at, width, factor * (Q_i - guess_i), factor * (Q_o - guess_o))
            if tilted is not None:
                given_i, given_o = guesses(forces, forces.tilted.guess, group, there)
                cross_i, cross_o = met_of(forces, CROSS, columns, group)
                turn_i = M_i + cross_i * (coupling.across * (Q_o - guess_o)) - given_i
                turn_o = M_o + cross_o * (coupling.across * (Q_i - guess_i)) - given_o
                store_pair(forces.tilted.gained, at, width, factor * turn_i, factor * turn_o)
        if forces.slope is not None:
            keep_slopes(step, INNER, group, met, Q_i)
            keep_slopes(step, OUTER, group, met, Q_o)
    if coupling is not None:
        _correct(bodies, contacts, forces)
    return _sums(bodies, forces, drive)


@part
def touching(contacts, drive):
    """Distances from hub and centre, m, at which rollers touch the rings, grown by their spin."""
    history = drive.history
    if history is None:
        return contacts.reach, contacts.track
    more = history.now[SPEED] * history.now[SPEED] - drive.speed * drive.speed
    reach, track = contacts.reach + history.growth * more, contacts.track - history.roller_growth * more
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
def direction(x, y, there):
    """Lengths and unit vectors of eight ways; of spare lanes numbers."""
    length = square_root(select(there, x * x + y * y, 1.0))
    over = 1.0 / length
    return length, select(there, x * over, 1.0), select(there, y * over, 0.0)


@part
def met_of(forces, what, columns, group):
    """Of eight rollers' inner and outer contacts that tilt: SLOPE, ENERGY, MOMENT or CROSS."""
    return load_pair(forces.tilted.met, 2 * what * columns + group, columns)


# the laws


@part
def _look(step, law, at, deep, guess):
    """Forces, N, of eight contacts of rollers that stand straight; approach, force and stiffness are kept."""
    forces = step.forces
    soft = None if forces.soft is None else load(forces.soft, at)
    if step.contacts.coupling is None:  # from forces of the last step before they were taken ahead
        soft_before = None if forces.soft is None else load(forces.soft_before, at)
        last = load(forces.estimate, at), load(forces.first, at), soft_before
        Q, stiffness = law_force(law, deep, soft, last)
    else:
        Q, stiffness = _guessed_force(law, _level(law, soft), deep, guess)
    store(forces.first, at, deep)
    store(forces.estimate, at, Q)
    store(forces.stiffness, at, stiffness)
    return Q


@part
def law_force(law, depth, soft, last):
    """Forces of eight contacts, N, and their stiffness, N/m, 0 of open ones.

    depth : m; soft : m/N, compliance of edges, or None; last : force, depth and compliance of the last step
    """
    if isinstance(law, PowerConstants):
        return _power_force(law, depth, soft)
    Q_before, before, soft_before = last
    Q = next_force(depth, law.A, _level(law, soft), law.Q_line, Q_before, before, _level(law, soft_before))
    closed = Q > 0.0
    give = select(closed, depth - 0.5 * law.A * minimum(Q, law.Q_line), 1.0)  # Q dδ/dQ
    return Q, select(closed, Q / give, 0.0)


@part
def _level(law, soft):
    """B of eight contacts with a compliance of edges, m/N, or None."""
    return splat(law.B) if soft is None else law.B + soft * (1.0 / law.A)


@part
def _power(law, depth):
    return law.stiffness * exponential(law.exponent * logarithm(depth))


@part
def _power_force(law, depth, soft):
    closed = depth > 0.0
    own = select(closed, depth, 1.0)
    if soft is not None:  # depths less what a compliance in series takes of them: Newton's method
        deep, yielding = own, select(closed, soft, 0.0)
        if any_lane(yielding != 0.0):
            for _ in range(MOST_STEPS):
                force = _power(law, own)
                step = (own + yielding * force - deep) / (1.0 + yielding * law.exponent * force / own)
                own = maximum(own - step, 0.1 * own)
                if not any_lane(absolute(step) > SETTLED * own):
                    break
    Q = select(closed, _power(law, own), depth - depth)  # what is not a number stays so
    stiffness = law.exponent * Q / own
    if soft is not None:
        stiffness = stiffness / (1.0 + soft * stiffness)
    return Q, stiffness


@part
def law_energy(law, Q, depth, soft):
    """Energy of eight contacts under forces, N, that their depths, m, go with, J: ∫ Q dδ."""
    if isinstance(law, PowerConstants):
        if soft is None:
            return Q * depth * (1.0 / (law.exponent + 1.0))
        return Q * (depth - soft * Q) * (1.0 / (law.exponent + 1.0)) + 0.5 * soft * Q * Q
    return stored_energy(Q, depth, law.A, law.Q_line)


@part
def _guessed_force(law, B, approach, guess):
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
def _look_up(forces, laws, columns, at, deep, slope):
    """Forces, N, and moments, N m, of eight contacts that tilt, by their tables; all derivatives are kept."""
    met, apart = forces.tilted.met, 2 * columns
    energy, Q, M, stiff, cross, tilting = table_at(forces, laws, at, columns, deep, slope)
    store(forces.first, at, deep)
    store(forces.estimate, at, Q)
    store(forces.stiffness, at, stiff)
    store(forces.tilted.stiffness, at, tilting)
    store_pair(met, SLOPE * apart + at, apart, slope, energy)
    store_pair(met, MOMENT * apart + at, apart, M, cross)
    return Q, M


# what contacts of elastic bodies do to each other


@part
def wrap(array, row, n, halo):
    """Repeat a ring's first and last contacts beyond its ends."""
    for k in range(halo):
        array[row, halo - 1 - k] = array[row, halo + n - 1 - k]
        array[row, halo + n + k] = array[row, halo + k]


@part
def guesses(forces, array, group, there):
    """Forces or moments expected of eight rollers' contacts, inner and outer."""
    at = forces.halo + group
    return select(there, load(array, at), 0.0), select(there, load(array, array.shape[1] + at), 0.0)


@part
def _summed(coupling, forces, compliance, array, counts, group):
    """Σ compliance_k·(entry k rollers away) of eight rollers' contacts, inner and outer; `counts` : of k."""
    inner, outer, columns, width = splat(0.0), splat(0.0), forces.normal.shape[2], array.shape[1]
    to, apart = forces.halo + group, coupling.distance.size * columns
    for k in range(counts[0]):
        inner += load(compliance, k * columns + group) * load(array, to + coupling.distance[k])
    for k in range(counts[1]):
        outer += load(compliance, apart + k * columns + group) * load(array, width + to + coupling.distance[k])
    return inner, outer


@part
def along_rings(coupling, forces, array, group):
    """Approaches of eight rollers' contacts, m, that forces along their rings take away, inner and outer."""
    return _summed(coupling, forces, forces.along, array, (coupling.counts[INNER, 1], coupling.counts[OUTER, 1]), group)


@part
def both_forces(inner, outer, by_inner, by_outer, guess_inner, guess_outer):
    """A roller's two forces, each with the other's change; `by_`: stiffness times what a newton on the other does."""
    beyond_inner, beyond_outer = inner - guess_inner, outer - guess_outer
    more = by_inner * (by_outer * beyond_inner - beyond_outer) / (1.0 - by_inner * by_outer)
    return inner + more, outer - by_outer * (beyond_inner + more)


@part
def _correct(bodies, contacts, forces):
    """Forces, moments and approaches with what all others have gained."""
    columns, n, halo, coupling, tilted = bodies.columns, bodies.n, forces.halo, contacts.coupling, contacts.tilted
    across = coupling.across
    for row in range(2):
        wrap(forces.gained, row, n, halo)
        if tilted is not None:
            wrap(forces.tilted.gained, row, n, halo)
    for group in range(0, n, WIDTH):
        guess_i, guess_o = guesses(forces, forces.guess, group, count_from(group) < n)
        less_i, less_o = along_rings(coupling, forces, forces.gained, group)
        stiff_i, stiff_o = load_pair(forces.stiffness, group, columns)
        Q_i, Q_o = load_pair(forces.estimate, group, columns)
        Q_i, Q_o = Q_i - stiff_i * less_i, Q_o - stiff_o * less_o
        if tilted is not None:
            turn_i, turn_o = along_rings(coupling, forces, forces.tilted.gained, group)
            turn_i, turn_o = tilted.share * turn_i, tilted.share * turn_o
            cross_i, cross_o = met_of(forces, CROSS, columns, group)
            Q_i, Q_o = Q_i + cross_i * turn_i, Q_o + cross_o * turn_o
        Q_i, Q_o = both_forces(Q_i, Q_o, stiff_i * across, stiff_o * across, guess_i, guess_o)
        Q_i, Q_o = maximum(Q_i, 0.0), maximum(Q_o, 0.0)
        less_i, less_o = less_i + across * (Q_o - guess_o), less_o + across * (Q_i - guess_i)
        take_more(forces.taken, columns, group, less_i, less_o)
        if tilted is None:
            store_pair(forces.estimate, group, columns, Q_i, Q_o)
            first_i, first_o = load_pair(forces.first, group, columns)
            store_pair(forces.first, group, columns, first_i - less_i, first_o - less_o)
        else:
            move(forces, columns, group, -less_i, turn_i)
            move(forces, columns, columns + group, -less_o, turn_o)


@part
def take_more(taken, columns, group, inner, outer):
    """Keep what other contacts' forces take of eight rollers' approaches more, m, where that is asked for."""
    if taken is not None:
        store_pair(taken, group, columns, load(taken, group) + inner, load(taken, columns + group) + outer)


@part
def move(forces, columns, at, further, turned):
    """Move eight contacts that tilt by a further approach, m, and misalignment, rad."""
    met, apart = forces.tilted.met, 2 * columns
    slope, energy = load_pair(met, SLOPE * apart + at, apart)
    M, cross = load_pair(met, MOMENT * apart + at, apart)
    Q = load(forces.estimate, at)
    Q_now = Q + load(forces.stiffness, at) * further + cross * turned
    M_now = M - cross * further - load(forces.tilted.stiffness, at) * turned
    energy += 0.5 * (Q + Q_now) * further - 0.5 * (M + M_now) * turned
    closed = (Q > 0.0) & (Q_now > 0.0)
    store(forces.estimate, at, select(closed, Q_now, 0.0))
    store(forces.first, at, load(forces.first, at) + further)
    store_pair(met, SLOPE * apart + at, apart, slope + turned, select(closed, maximum(energy, 0.0), 0.0))
    store(met, MOMENT * apart + at, select(closed, M_now, 0.0))


@part
def _sums(bodies, forces, drive):
    """Sums of forces on hub and outer ring, N; angular accelerations of rollers and hub are kept."""
    columns, n, tilts = bodies.columns, bodies.n, bodies.tilts
    hub_x, hub_y, ring_x, ring_y = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    on_x, on_y = splat(0.0), splat(0.0)
    for group in range(0, n, WIDTH):
        ix, iy, ox, oy = normals(forces, group, columns)
        Q_i, Q_o = load_pair(forces.estimate, group, columns)
        hub_x, hub_y = hub_x - Q_i * ix, hub_y - Q_i * iy
        ring_x, ring_y = ring_x + Q_o * ox, ring_y + Q_o * oy
        if tilts is not None:
            (M_i, M_o), there = met_of(forces, MOMENT, columns, group), count_from(group) < n
            M_i, M_o = select(there, M_i, 0.0), select(there, M_o, 0.0)
            store(tilts.pushed, group, (M_i * (ix * ox + iy * oy) - M_o) * (1.0 / tilts.inertia))
            on_x, on_y = on_x - M_i * ix, on_y - M_i * iy
    if tilts is not None:
        push_axes(tilts, drive, (total(on_x), total(on_y)))
    return total(hub_x), total(hub_y), total(ring_x), total(ring_y)


@part(inlined=False)
def follow_angles(bodies, coupling, forces):
    """Compliances along both rings, and their slopes, at the angles where rollers are now.

    First by how much rollers are ahead of their pockets' angles from the first one's, about the outer ring. About the
    hub they are ahead by as much but for a thousandth of a roller's distance.
    """
    columns, n, halo, most, strayed = bodies.columns, bodies.n, forces.halo, coupling.strays, forces.strayed
    ring_x, ring_y = ring_place(bodies.housing)
    first_x, first_y, neighbours = bodies.centre[0, 0] - ring_x, bodies.centre[1, 0] - ring_y, coupling.distance.size
    for group in range(0, n, WIDTH):
        cosine, sine = load_pair(coupling.apart, group, columns)
        to_x, to_y = cosine * first_x - sine * first_y, sine * first_x + cosine * first_y
        here_x, here_y = load_pair(bodies.centre, group, columns)
        here_x, here_y = here_x - ring_x, here_y - ring_y
        store(strayed, halo + group, arc_tangent(to_x * here_y - to_y * here_x, to_x * here_x + to_y * here_y))
    for k in range(halo):
        strayed[halo - 1 - k] = strayed[halo + n - 1 - k]
        strayed[halo + n + k] = strayed[halo + k]
    for row in range(2):
        for k in range(coupling.counts[row, 0]):
            distance = coupling.distance[k]
            for group in range(0, n, WIDTH):
                at, to, apart = halo + group, (row * neighbours + k) * columns + group, neighbours * columns
                first = to + 3 * row * apart
                a, b = load_pair(coupling.bent, first, apart)
                c, d = load_pair(coupling.bent, first + 2 * apart, apart)
                steep = load(coupling.steep, to)
                off = load(strayed, at + distance) - load(strayed, at)
                x = maximum(minimum(off, most), -most)
                along = load(coupling.along, to) + x * (steep + x * (a + x * (b + x * (c + x * d))))
                store(forces.along, to, along)
                slope = steep + x * (2.0 * a + x * (3.0 * b + x * (4.0 * c + x * (5.0 * d))))
                store(forces.steep, to, select(x == off, slope, 0.0))
