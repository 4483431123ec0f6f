"""Tractions of all contacts at once, in turn where patches overlap, or on rigid bodies that contacts share."""

from fem.kernels.contact_kernels import next_rollers
from fem.kernels.friction_kernels import (
    ALL,
    drag,
    drag_bodies,
    find_tractions,
    grip_pair,
    normals,
    push_and_drag,
    slip_of_push,
    slip_pair,
    slip_with_nodes,
    whole_mobility,
)
from fem.kernels.jit import every, part, verb
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, any_lane, count_from, select, splat, total
from fem.kernels.state import CONTACTS, ROLLER, Neighbours, Raceway
from fem.kernels.surfaces import body_motion

WHERE_ROLLERS_TOUCH, ALWAYS = 0, 1  # when patches of neighbouring contacts overlap

grip_all = every(grip_pair, *CONTACTS)
slip_all = every(slip_pair, *CONTACTS)
slip_all_with_nodes = every(slip_with_nodes, *CONTACTS)


@part
def slips_before(groups, rollers, disc, contacts, still):
    """Slips before a kick, m/s; `still`, (columns,), is 0: no roller is to gain anything by turning as a whole."""
    grip_all(groups, rollers, disc, contacts)
    slip_all(groups, rollers, disc, contacts, still, contacts.friction.slip)


@part
def pushes_later(friction, points, whole):
    """Whether the normal forces' impulses on nodes are given with the tractions', in one pass.

    They can be where no patches share a node: a contact's own then is all that reaches its slip, and known beforehand.
    """
    if points is None:
        if whole is None:
            return friction.apart
    return False


@part
def friction_contacts(groups, rollers, disc, contacts, drive, overlapping, whole, later):
    """Tractions of every contact and their impulses; returns the work they take in this step, J: lost, or in springs.

    Each is implicit in its own patch's velocity. Where patches of neighbours overlap (on coarse meshes), each starts
    from its last value and every other one is solved for in turn (Gauss and Seidel): without neighbours' part sticking
    contacts would shake each other. Where they share a rigid body, each knows the others' last values.

    `overlapping`, `whole`: of `Friction`; what is None is not compiled; `later`: see `pushes_later`.
    """
    if overlapping is None:
        _solve_at_once(groups, rollers, disc, contacts, drive, whole, later)
    elif overlapping == ALWAYS or _rollers_touch(contacts, rollers):
        _solve_in_turn(groups, rollers, disc, contacts, drive)
    else:
        _solve_at_once(groups, rollers, disc, contacts, drive, whole, later)
    friction = contacts.friction
    taken = splat(0.0)
    for at in range(0, friction.traction.size, WIDTH):
        taken -= load(friction.traction, at) * (load(friction.slip, at) + load(friction.slip_left, at))
    return 0.5 * drive.dt * total(taken)


@part
def _solve_at_once(groups, rollers, disc, contacts, drive, whole, later):
    """Tractions and impulses of contacts that share no nodes."""
    if whole is None:
        _slips_left(groups, rollers, disc, contacts, contacts.dampers, later)
        if later:
            _creep_all_and_push(groups, rollers, disc, contacts, drive)
        else:
            _creep_all(groups, rollers, disc, contacts, drive)
    else:
        _solve_on_whole_bodies(groups, rollers, disc, contacts, drive)


@part
def _slips_left(groups, rollers, disc, contacts, dampers, later):
    """Slips left; what raceways' nodes add to them dampers may have found already, see `damping_kernels`."""
    if dampers is None:
        slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
    elif later:
        slip_all_with_nodes(groups, rollers, disc, contacts, rollers.turn_kick)
    else:
        slip_all(groups, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)


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
    drag(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


@part
def _creep_and_push(pair, rollers, disc, contacts, drive):
    """The same from slips that the normal forces' impulses are not in yet, and these impulses."""
    slip_of_push(pair, rollers, contacts, drive.dt)
    find_tractions(pair, rollers, disc, contacts, drive.dt, ALL, False)
    push_and_drag(pair, rollers, disc, contacts, drive.dt)


@part
def _creep_in_turn(pair, rollers, disc, contacts, drive):
    """Every other one of a pair's contacts, and then the others, each with all the others' tractions."""
    for some in range(2):
        slip_pair(pair, rollers, disc, contacts, rollers.turn_kick, contacts.friction.slip_left)
        find_tractions(pair, rollers, disc, contacts, drive.dt, some, True)
        drag(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


@part
def _drag_as_before(pair, rollers, disc, contacts, drive):
    """The last tractions of a pair's contacts that are still closed."""
    _take_last(pair, rollers, contacts)
    drag(pair, rollers, disc, contacts, contacts.friction.change, drive.dt)


_creep_all, _creep_all_and_push, _creep_all_in_turn, _drag_all_as_before = (
    every(_creep, *CONTACTS),
    every(_creep_and_push, *CONTACTS),
    every(_creep_in_turn, *CONTACTS),
    every(_drag_as_before, *CONTACTS),
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
    drag(pair, rollers, disc, contacts, contacts.friction.traction, drive.dt)


_drag_all_bodies, _creep_all_beside = every(_drag_bodies_as_before, *CONTACTS), every(_creep_beside, *CONTACTS)
_all_without_bodies, _drag_all_nodes, _all_with_bodies = (
    every(_without_bodies, *CONTACTS),
    every(_drag_nodes, *CONTACTS),
    every(_with_bodies, *CONTACTS),
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


@verb
def _whole_slip(pair, rollers, disc, contacts, group):
    """What the rigid bodies' motion adds to the slip of eight contacts, m/s."""


@_whole_slip.of(Raceway)
def _whole_slip_on_raceway(raceway, rollers, disc, contacts, group):
    nx, ny = normals(contacts, raceway, group)
    along, around = body_motion(disc, count_from(group), nx, ny)
    return along - raceway.sign * around - body_motion(raceway.surface, count_from(group), nx, ny)[0]


@_whole_slip.of(Neighbours)
def _whole_slip_of_neighbours(pair, rollers, disc, contacts, group):
    nx, ny = normals(contacts, pair, group)
    along, around = body_motion(disc, count_from(group), nx, ny)
    along_next, around_next = body_motion(disc, next_rollers(group, rollers.n), nx, ny)
    return along_next - along - around - around_next
