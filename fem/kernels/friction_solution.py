"""Tractions of all contacts at once, in turn where patches overlap, or on rigid bodies that contacts share."""

from fem.kernels.contact_kernels import first_surface, second_rollers
from fem.kernels.friction_kernels import (
    ALL,
    apply_friction,
    drag_bodies,
    find_tractions,
    grip_pair,
    normals,
    push_and_drag,
    slip_velocity,
    spring_tractions,
    whole_mobility,
)
from fem.kernels.jit import every, part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, total
from fem.kernels.shear_kernels import follow_slips_after, follow_slips_before
from fem.kernels.state import ROLLER, Pair
from fem.kernels.surfaces import body_motion

WHERE_ROLLERS_TOUCH, ALWAYS = 0, 1  # when patches of neighbouring contacts overlap

grip_all = every(grip_pair, Pair)
slip_all = every(slip_velocity, Pair)


@part
def slips_before(groups, rollers, disc, contacts, still, lumped):
    """Slips before a kick, m/s; in long steps springs are content with those after the last.

    `still`, (columns,), is 0: no roller is to gain anything by turning as a whole.
    """
    friction = contacts.friction
    grip_all(groups, rollers, disc, contacts)
    if lumped:
        slip_all(groups, rollers, disc, contacts, still, friction.slip)
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
def pushes_later(friction, whole):
    """Whether the normal forces' impulses on nodes are given with the tractions', in one pass: no spring needs them."""
    if friction.shear is not None:
        return whole is None
    return False


@part
def friction_contacts(groups, rollers, disc, contacts, drive, overlapping, whole, later):
    """Tractions of every contact and their impulses.

    Those of springs are given by places. Of others each is implicit in its own patch's velocity. Where patches of
    neighbours overlap (on coarse meshes), each starts from its last value and every other one is solved for in turn
    (Gauss and Seidel): without neighbours' part sticking contacts would shake each other. Where they share a rigid
    body, each knows the others' last values.

    `overlapping`, `whole`: of `Friction`; what is None is not compiled; `later`: see `pushes_later`.
    """
    if contacts.friction.shear is not None:
        if later:
            _pull_all_and_push(groups, rollers, disc, contacts, drive)
        else:
            _pull_all(groups, rollers, disc, contacts, drive)
    elif overlapping is None:
        _solve_at_once(groups, rollers, disc, contacts, drive, whole)
    elif overlapping == ALWAYS or _rollers_touch(contacts, rollers):
        _solve_in_turn(groups, rollers, disc, contacts, drive)
    else:
        _solve_at_once(groups, rollers, disc, contacts, drive, whole)


@part
def _solve_at_once(groups, rollers, disc, contacts, drive, whole):
    """Tractions and impulses of contacts that share no nodes."""
    if whole is None:
        slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
        _creep_all(groups, rollers, disc, contacts, drive)
    else:
        _solve_on_whole_bodies(groups, rollers, disc, contacts, drive)


@part
def _rollers_touch(contacts, rollers):
    found = splat(0.0)
    for group in range(0, rollers.n, WIDTH):
        found += load(contacts.forces.force, ROLLER * rollers.columns + group)
    return any_lane(found > 0.0)


@part
def _creep(pair, rollers, disc, contacts, drive):
    """Tractions of a pair's contacts from slips without any, and their impulses."""
    find_tractions(pair, rollers, disc, contacts, drive.dt, ALL, False)
    apply_friction(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


@part
def _pull(pair, rollers, disc, contacts, drive):
    """Tractions of the springs of a pair's contacts, and their impulses."""
    spring_tractions(pair, rollers, contacts, drive.dt)
    apply_friction(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


@part
def _pull_and_push(pair, rollers, disc, contacts, drive):
    """The same, and the normal forces' impulses."""
    spring_tractions(pair, rollers, contacts, drive.dt)
    push_and_drag(pair, rollers, disc, contacts, drive.dt)


@part
def _creep_in_turn(pair, rollers, disc, contacts, drive):
    """Every other one of a pair's contacts, and then the others, each with all the others' tractions."""
    for some in range(2):
        slip_velocity(pair, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
        find_tractions(pair, rollers, disc, contacts, drive.dt, some, True)
        apply_friction(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


@part
def _drag_as_before(pair, rollers, disc, contacts, drive):
    """The last tractions of a pair's contacts that are still closed."""
    _take_last(pair, rollers, contacts)
    apply_friction(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


_pull_all, _pull_all_and_push = every(_pull, Pair), every(_pull_and_push, Pair)
_creep_all, _creep_all_in_turn, _drag_all_as_before = (
    every(_creep, Pair),
    every(_creep_in_turn, Pair),
    every(_drag_as_before, Pair),
)


@part(inlined=False)
def _solve_in_turn(groups, rollers, disc, contacts, drive):
    """Tractions and impulses of contacts whose patches overlap; seldom needed, so kept out of the time loop."""
    _drag_all_as_before(groups, rollers, disc, contacts, drive)
    _creep_all_in_turn(groups, rollers, disc, contacts, drive)
    slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)


@part
def _drag_bodies_as_before(pair, rollers, disc, contacts, drive):
    """Give rigid bodies the last tractions of a pair's contacts that are still closed."""
    _take_last(pair, rollers, contacts)
    drag_bodies(pair, rollers, disc, contacts, drive.dt)


@part
def _creep_beside(pair, rollers, disc, contacts, drive):
    """Tractions of a pair's contacts from slips with all last tractions."""
    find_tractions(pair, rollers, disc, contacts, drive.dt, ALL, True)


@part
def _without_bodies(pair, rollers, disc, contacts, drive):
    """Take out of the slips left what rigid bodies move, and what the change of a contact's own traction will."""
    friction, mobility = contacts.friction, whole_mobility(pair, disc) * drive.dt
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        moved = _whole_slip(pair, rollers, disc, contacts, group)
        store(friction.slip_left, row, load(friction.slip_left, row) - moved - mobility * load(friction.change, row))


@part
def _with_bodies(pair, rollers, disc, contacts, drive):
    """Add to the slips left what rigid bodies move."""
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        moved = _whole_slip(pair, rollers, disc, contacts, group)
        store(contacts.friction.slip_left, row, load(contacts.friction.slip_left, row) + moved)


@part
def _drag_nodes(pair, rollers, disc, contacts, drive):
    """The bodies with nodes have been given nothing yet, the rigid ones the last tractions."""
    apply_friction(pair, rollers, disc, contacts, contacts.friction.traction, drive.dt)


_drag_all_bodies, _creep_all_beside = every(_drag_bodies_as_before, Pair), every(_creep_beside, Pair)
_all_without_bodies, _drag_all_nodes, _all_with_bodies = (
    every(_without_bodies, Pair),
    every(_drag_nodes, Pair),
    every(_with_bodies, Pair),
)


@part
def _solve_on_whole_bodies(groups, rollers, disc, contacts, drive):
    """Tractions and impulses of contacts that share a rigid body but no nodes.

    The rigid bodies have been given all last tractions when each contact finds its own: a step's tractions differ from
    the last by so little that what they do to each other's slip is caught up with in the next.
    """
    _drag_all_bodies(groups, rollers, disc, contacts, drive)
    slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
    _creep_all_beside(groups, rollers, disc, contacts, drive)
    _all_without_bodies(groups, rollers, disc, contacts, drive)
    _drag_all_nodes(groups, rollers, disc, contacts, drive)
    _all_with_bodies(groups, rollers, disc, contacts, drive)


@part
def _take_last(pair, rollers, contacts):
    """Begin with the last tractions of a pair's contacts that are still closed."""
    friction = contacts.friction
    for group in range(0, rollers.n, WIDTH):
        row = pair.row * rollers.columns + group
        last = select(load(contacts.forces.force, row) > 0.0, load(friction.traction, row), 0.0)
        store(friction.traction, row, last)
        store(friction.change, row, last)


@part
def _whole_slip(pair, rollers, disc, contacts, group):
    """What the rigid bodies' motion adds to the slip of eight contacts, m/s."""
    nx, ny = normals(contacts, pair, group)
    along, around = body_motion(disc, second_rollers(pair, group, rollers.n), nx, ny)
    along_0, around_0 = body_motion(first_surface(pair, disc), count_from(group), nx, ny)
    found = along - pair.sign * around - along_0
    return found if pair.surface is not None else found - around_0
