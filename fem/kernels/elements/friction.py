"""FRICTION: Coulomb's limit, Carter's creep below it; tangential springs of contacts; all contacts in a step.

A traction T acts along t = Jn, spread over the nodes of both patches. The slip is the velocity conjugate to it, so that
what T dissipates is exactly what it takes from the bodies. Without a tangential spring creep is solved for implicitly
(equation (6) of docs/method.md).

A spring, the compliance of a contact that sticks, which the mesh lacks, is in series with Carter's creep. Its stretch e
follows the places of the surfaces' nodes, as normal forces do, and the traction at a kick follows from its value there:

    e − e₋ = dt (slip − creep),    T C = e,    C = A (level − ½ ln Q).

The slip is the mean of what the patches before and after the motion make of it, so that what tractions take from the
bodies is what springs store and creep loses. In long steps, which are for bearings that roll, it is that of the patches
before. The creep is the mean of both kicks', implicit in the traction, so that none, however fast, limits the step (of
a contact that slides, whose traction is given, what is left). The springs do, as normal contacts do. With a reciprocal
mass slips must be those of places, too: a spring stretched by momenta and the normal forces would belong to different
masses, and waves that both reach would flutter.

C follows the normal force: as that grows the traction stays, as it falls the stretch does, and neither makes energy.

Source: Hairer, Lubich and Wanner, Acta Numerica 12 (2003) 399, on leapfrog; Elata and Berryman, Mechanics of Materials
24 (1996) 229, on the last.

Equation (7) of docs/method.md.
"""

from fem.kernels import lanes
from fem.kernels.columns import ROLLER
from fem.kernels.elements import surfaces
from fem.kernels.elements.contacts import first_surface, second_rollers, share_nodes, with_dampers
from fem.kernels.elements.state import Pair
from fem.kernels.jit import every, part
from fem.kernels.lane_functions import load_pair, maximum, minimum
from fem.kernels.lanes import WIDTH, absolute, any_lane, count_from, load, select, splat, store, total
from fem.kernels.law import SLIP_FLOOR, STEEPEST, creep_traction

WHERE_ROLLERS_TOUCH, ALWAYS = 0, 1  # when patches of neighbouring contacts overlap
EVEN, ODD, ALL = 0, 1, 2  # contacts of a pair that are solved for at once
ALONE, IN_TURN, AS_BEFORE = range(3)  # steps of `_creep`


@part
def slips_before(groups, rollers, disc, contacts, still, lumped):
    """Slips before a kick, m/s; in long steps springs are content with those after the last.

    `still`, (columns,), is 0: no roller is to gain anything by turning as a whole.
    """
    friction = contacts.friction
    grip_all(groups, rollers, disc, contacts)
    if lumped:
        slip_all(groups, rollers, disc, contacts, still, friction.slip)
    if friction.shear is not None:
        follow_slips_before(friction.shear, friction, rollers.n)


@part
def slips_after(groups, rollers, disc, contacts, dt, lumped):
    """Slips after a kick, m/s, which springs follow; of others the solution leaves them.

    Returns what tractions take per second in the steps before and after the kick, together, W: lost, or in springs.
    """
    friction, taken = contacts.friction, splat(0.0)
    if friction.shear is not None:
        slip_all(groups, rollers, disc, contacts, rollers.turn_kick, friction.slip_left)
    for at in range(0, friction.traction.size, WIDTH):
        slips = load(friction.slip, at) + load(friction.slip_left, at)
        taken -= select(load(contacts.forces.force, at) > 0.0, load(friction.traction, at) * slips, 0.0)
    if friction.shear is not None:
        follow_slips_after(friction.shear, contacts.forces, friction, dt, rollers.n)
        if not lumped:
            for at in range(0, friction.slip.size, WIDTH):
                store(friction.slip, at, load(friction.slip_left, at))
    return total(taken)


@part
def friction_contacts(groups, rollers, disc, contacts, drive):
    """Tractions of every contact and their impulses.

    Those of springs are given by places. Of others each is implicit in its own patch's velocity. Where patches of
    neighbours overlap (on coarse meshes), each starts from its last value and every other one is solved for in turn
    (Gauss and Seidel): without neighbours' part sticking contacts would shake each other. Bodies declared rigid have
    springs at all contacts; where none has, these give nodes the impulses of the normal forces too, in one pass.
    """
    friction = contacts.friction
    if friction.shear is not None:
        _pull_all(groups, rollers, disc, contacts, drive)
    elif friction.overlapping is None:
        _creep_at_once(groups, rollers, disc, contacts, drive)
    else:
        touch = splat(0.0)  # forces of rollers that touch
        for group in range(0, rollers.n, WIDTH):
            touch += load(contacts.forces.force, ROLLER * rollers.columns + group)
        if friction.overlapping == ALWAYS or any_lane(touch > 0.0):
            _creep_in_turn(groups, rollers, disc, contacts, drive)
        else:
            _creep_at_once(groups, rollers, disc, contacts, drive)


@part
def _creep_at_once(groups, rollers, disc, contacts, drive):
    """Of contacts that share no nodes."""
    slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
    _creep_all(groups, rollers, disc, contacts, drive, ALONE)


@part(inlined=False)
def _creep_in_turn(groups, rollers, disc, contacts, drive):
    """Of contacts whose patches overlap; seldom needed, so kept out of the time loop."""
    _creep_all(groups, rollers, disc, contacts, drive, AS_BEFORE)
    _creep_all(groups, rollers, disc, contacts, drive, IN_TURN)
    slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)


# the steps of a pair


@part
def _normals(contacts, pair, group):
    columns = contacts.patches.columns
    return load_pair(contacts.patches.normal, 2 * pair.row * columns + group, columns)


@part
def _grip(pair, rollers, disc, contacts):
    """How the patches of a pair's closed contacts grip, for all that follows."""
    for group in range(0, rollers.n, WIDTH):
        row, side = pair.row * rollers.columns + group, 2 * pair.row
        if any_lane(load(contacts.forces.force, row) > 0.0):
            mobility = surfaces.tangential_mobility(first_surface(pair, disc), contacts.patches, side, group)
            mobility = mobility + surfaces.tangential_mobility(disc, contacts.patches, side + 1, group)
            store(contacts.friction.mobility, row, mobility)


@part
def slip_velocity(pair, rollers, disc, contacts, turn_kick, out):
    """Sideways velocity of side 1 less that of side 0 along t = Jn for closed contacts, m/s, to `out`, (3, columns).

    `_grip` must have been called at the present positions. `turn_kick`, (columns,), rad/s: increment of the rollers'
    spin as a whole. Open contacts get what has no meaning.
    """
    velocity, columns, side, patches = rollers.velocity, rollers.columns, 2 * pair.row, contacts.patches
    surfaces.ghost_nodes(first_surface(pair, disc), surfaces.FILL)
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * columns + group
        if any_lane(load(contacts.forces.force, row) > 0.0):
            nx, ny = _normals(contacts, pair, group)
            i = second_rollers(pair, group, rollers.n)
            own = lanes.gather(turn_kick, i) * rollers.radius
            own += surfaces.tangential_velocity(disc, patches, side + 1, group, i, nx, ny)
            slip = lanes.gather(velocity, i + columns) * nx - lanes.gather(velocity, i) * ny
            if pair.surface is not None:
                slip = slip - own if pair.sign > 0.0 else slip + own
                slip -= surfaces.tangential_velocity(pair.surface, patches, side, group, 0, nx, ny)
            else:
                slip -= own + load(turn_kick, group) * rollers.radius
                slip -= surfaces.tangential_velocity(disc, patches, side, group, count_from(group), nx, ny)
                slip -= load(velocity, columns + group) * nx - load(velocity, group) * ny
            store(out, row, slip)


@part
def _full_slip(pair, rollers, contacts, group, Q):
    """Creep speeds, m/s, beyond which eight contacts slide; where two rollers meet nothing rolls."""
    half_width, velocity, rolling = lanes.square_root(pair.law.half_width_factor * Q), rollers.velocity, splat(0.0)
    if pair.surface is not None:
        nx, ny = _normals(contacts, pair, group)
        turning = (load(velocity, rollers.columns + group) * nx - load(velocity, group) * ny) * (1.0 / pair.orbit)
        rolling = absolute(load(rollers.spin, group) - turning) * rollers.radius
    return maximum(contacts.friction.coefficient * pair.law.curvature * half_width * rolling, SLIP_FLOOR)


@part
def _find_tractions(pair, rollers, disc, contacts, dt, some):
    """Tractions of a pair's contacts, EVEN, ODD or ALL, from the slips, which become those that are left.

    The slips are without tractions, or, but of ALL contacts, with the last ones. The difference from the tractions that
    the bodies have been given is left in `change`.
    """
    friction = contacts.friction
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        Q = with_dampers(contacts.dampers, row, load(contacts.forces.force, row))
        if not any_lane(Q > 0.0):
            store(friction.traction, row, splat(0.0))
            store(friction.change, row, splat(0.0))
            continue
        full_slip, mobility = _full_slip(pair, rollers, contacts, group, Q), load(friction.mobility, row) * dt
        given, slip, chosen = splat(0.0), load(friction.slip_left, row), Q > 0.0
        if some != ALL:
            given, number = load(friction.traction, row), count_from(group + some)
            chosen = chosen & (number - lanes.to_int(lanes.to_float(number) * 0.5) * 2 == 0)
        T, left = creep_traction(slip - mobility * given, friction.coefficient * Q, full_slip, mobility)
        T = select(chosen, -T, select(Q > 0.0, given, 0.0))  # on side 1, along t
        store(friction.slip_left, row, select(chosen, left, slip))
        store(friction.traction, row, T)
        store(friction.change, row, T - given)


@part
def _apply(pair, rollers, disc, contacts, kick, dt):
    """Give the bodies of a pair the impulses of the changes of its tractions in a step; nodes in one pass with those of
    `kick`, the normal forces, unless it is None."""
    patches, side, moment, surface = contacts.patches, 2 * pair.row, splat(0.0), first_surface(pair, disc)
    surfaces.ghost_nodes(surface, surfaces.CLEAR)
    for group in range(0, rollers.n, WIDTH):
        row, outward, inward = pair.row * rollers.columns + group, None, None
        rubbed = load(contacts.friction.change, row) * dt  # along t on side 1
        acts = rubbed != 0.0
        if kick is not None:
            inward = with_dampers(contacts.dampers, row, load(kick, row)) * -dt
            outward, acts = inward * pair.sign, acts | (inward != 0.0)
        if any_lane(acts):
            nx, ny = _normals(contacts, pair, group)
            surfaces.scatter_force(disc, patches, side + 1, group, inward, rubbed * -pair.sign)
            share_nodes(pair, rollers, disc, group, -(rubbed * ny), rubbed * nx)
            moment += surfaces.scatter_force(surface, patches, side, group, outward, -rubbed)
    surfaces.ghost_nodes(surface, surfaces.GIVE)
    if pair.surface is not None:
        pair.moment[1] += total(moment)
    if contacts.friction.whole is not None:
        _drag_bodies(pair, rollers, disc, contacts, dt)


@part
def _drag_bodies(pair, rollers, disc, contacts, dt):
    """Give the rigid bodies of a pair the impulses of the changes of its tractions in a step."""
    normal, change, row, moment = contacts.patches.normal, contacts.friction.change, pair.row, 0.0
    for j in range(rollers.n):
        given, nx, ny = change[row, j] * dt, normal[row, 0, j], normal[row, 1, j]
        i = j + 1 if j + 1 < rollers.n else 0
        if pair.surface is not None:
            i = j
        surfaces.push_body(disc, i, -given * ny, given * nx, -pair.sign * given)
        moment += surfaces.push_body(first_surface(pair, disc), j, given * ny, -given * nx, -given)
    if pair.surface is not None:
        pair.moment[1] += moment


@part
def _creep(pair, rollers, disc, contacts, drive, what):
    """Tractions from slips without any; or of every other contact in turn, each with all others' tractions, which
    begin as they were before."""
    friction, dt = contacts.friction, drive.dt
    if what == ALONE:
        _find_tractions(pair, rollers, disc, contacts, dt, ALL)
        _apply(pair, rollers, disc, contacts, None, dt)
    if what == AS_BEFORE:  # of contacts that are still closed
        for group in range(0, rollers.n, WIDTH):
            row = pair.row * rollers.columns + group
            last = select(load(contacts.forces.force, row) > 0.0, load(friction.traction, row), 0.0)
            store(friction.traction, row, last)
            store(friction.change, row, last)
        _apply(pair, rollers, disc, contacts, None, dt)
    if what == IN_TURN:
        for some in range(2):
            slip_velocity(pair, rollers, disc, contacts, rollers.turn_kick, friction.slip_left)
            _find_tractions(pair, rollers, disc, contacts, dt, some)
            _apply(pair, rollers, disc, contacts, None, dt)


# tangential springs


@part
def _pull(pair, rollers, disc, contacts, drive):
    """Tractions of a pair's contacts from springs that have followed the slips, and their impulses."""
    friction, dt = contacts.friction, drive.dt
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        Q, T = with_dampers(contacts.dampers, row, load(contacts.forces.force, row)), splat(0.0)
        if any_lane(Q > 0.0):
            full_slip = _full_slip(pair, rollers, contacts, group, Q)
            # on side 1, along t
            T = -pull(friction.shear, contacts, pair, row, dt, friction.coefficient * Q, full_slip)
        else:
            store(friction.shear.stretch, row, splat(0.0))
            store(friction.shear.creep, row, splat(0.0))
            store(friction.shear.since, row, splat(0.0))
        store(friction.traction, row, T)
        store(friction.change, row, T)
    kick = None
    if friction.whole is None:
        # dampers of rollers that touch come one by one, need the normal forces' impulses before, and have had them
        if pair.surface is not None or contacts.dampers is None:
            kick = contacts.forces.kick
    _apply(pair, rollers, disc, contacts, kick, dt)


@part
def pull(shear, contacts, pair, row, dt, limit, full_slip):
    """Forces, N, of the springs of eight contacts along their slips; `limit`, N, and `full_slip`, m/s, as Carter's."""
    forces, law, Q = contacts.forces, pair.law, load(contacts.forces.force, row)
    closed, level = Q > 0.0, lanes.gather(shear.level, pair.row) - load(forces.bracket, row)
    # compliances by the present normal forces, m/N: approach over force is A (bracket − ½ ln Q), saves a logarithm
    soft = select(closed, load(forces.approach, row), 0.0) / select(closed, Q, 1.0) + law.A * level
    soft = maximum(soft, STEEPEST * law.A)
    kept = select(closed, minimum(soft / load(shear.compliance, row), 1.0), 0.0)
    store(shear.compliance, row, soft)
    stretched = kept * load(shear.stretch, row)
    force, creep = creep_traction(stretched * (2.0 / dt), limit, full_slip, soft * (2.0 / dt))
    stretch = soft * force
    slid = (stretched - stretch) * (1.0 / dt) + 0.5 * load(shear.creep, row)
    store(shear.stretch, row, stretch)
    store(shear.creep, row, select(closed, select(absolute(force) >= limit, slid, creep), 0.0))
    store(shear.since, row, select(closed, splat(dt), 0.0))
    return force


@part
def follow_slips_after(shear, forces, friction, dt, n):
    """Stretch the springs of closed contacts by half of the slips that a kick leaves, less half of their creep."""
    columns, half = shear.stretch.shape[1], 0.5 * dt
    for row in range(shear.stretch.shape[0]):
        for at in range(row * columns, row * columns + n, WIDTH):
            gained = half * (load(friction.slip_left, at) - load(shear.creep, at))
            store(shear.stretch, at, load(shear.stretch, at) + select(load(forces.force, at) > 0.0, gained, 0.0))


@part
def follow_slips_before(shear, friction, n):
    """The other half of the slips, before the next kick, of contacts that were closed at the last."""
    columns = shear.stretch.shape[1]
    for row in range(shear.stretch.shape[0]):
        for at in range(row * columns, row * columns + n, WIDTH):
            gained = 0.5 * load(shear.since, at) * load(friction.slip, at)
            store(shear.stretch, at, load(shear.stretch, at) + select(load(shear.since, at) > 0.0, gained, 0.0))


@part
def spring_energy(shear, n):
    """What all springs store at the kick just made, J."""
    found = 0.0
    if shear is not None:
        for row in range(shear.stretch.shape[0]):
            for j in range(n):
                stretch = shear.stretch[row, j]
                found += 0.5 * stretch * stretch / shear.compliance[row, j]
    return found


grip_all, slip_all, _pull_all = every(_grip, Pair), every(slip_velocity, Pair), every(_pull, Pair)
_creep_all = every(_creep, Pair)
