"""ReportOptions of the time loop as kernels that Python can call, kept compiled as the time loop is."""

import numpy as np

from fem.elastic.reciprocal_mass import ReciprocalMass
from fem.kernels import columns, law, profiles
from fem.kernels.elements import contacts as of_patches
from fem.kernels.elements import discs, friction, loop, rings, samples, surfaces
from fem.kernels.jit import kernel
from fem.kernels.lanes import splat
from fem.solver.elements.arrays import Arrays

kick_disc, drift_disc = kernel(discs.kick), kernel(discs.drift)
slow_disc, calm_ring = kernel(discs.slow_waves), kernel(rings.calm)
kick_ring, kick_ring_and_add = kernel(rings.kick), kernel(rings.kick_and_add)
drift_ring, drift_slowed_ring = kernel(rings.drift), kernel(rings.drift_slowed)
find_velocities = kernel(rings.find_velocities)
row_force, resultant = kernel(rings.row_force), kernel(rings.resultant)
wrap, set_rigid = kernel(rings.wrap), kernel(rings.set_rigid)
wrap_all = kernel(rings.wrap_all)
kick_force, stored_energy = kernel(law.kick_force), kernel(law.contact_energy)
next_force = kernel(law.next_force)
weight_slopes, place = kernel(surfaces.weight_slopes), kernel(profiles.place)
creep_traction = kernel(law.creep_traction)


@kernel
def kick(bodies, groups, contacts, drive, time, scratch):
    """`fem.kernels.elements.loop.kick`."""
    return loop.kick(bodies, groups, contacts, drive, time, scratch)


@kernel
def drift(bodies, groups, contacts, drive, scratch):
    """`fem.kernels.elements.loop.slide` and `drift`; the work that friction takes, J."""
    taken = loop.slide(bodies, groups, contacts, drive, scratch)
    loop.drift(bodies, drive, scratch)
    return taken


@kernel
def remember(bodies, drive, scratch):
    """`fem.kernels.elements.samples.remember`."""
    samples.remember(bodies, drive, scratch)


@kernel
def kinetic_energy(bodies, drive, scratch):
    """`fem.kernels.elements.samples.kinetic_energy`, J."""
    return samples.kinetic_energy(bodies, drive, scratch)


@kernel
def elastic_energy(bodies, drive, scratch):
    """`fem.kernels.elements.samples.elastic_energy`, J."""
    return samples.elastic_energy(bodies, drive, scratch)


@kernel
def _press(groups, bodies, contacts, drive):
    loop.press_contacts(groups, bodies, contacts, drive)


@kernel
def _push(groups, bodies, contacts, drive):
    loop.push_surfaces(groups, bodies, contacts, drive)


@kernel
def _press_groups(groups, rollers, surface, contacts, drive):
    of_patches.press_patches(groups, rollers, surface, contacts, drive)
    of_patches.push_patches(groups, rollers, surface, contacts, None, drive.dt)


@kernel
def _slips(groups, rollers, surface, contacts, turn_kick, out):
    friction.grip_all(groups, rollers, surface, contacts)
    friction.slip_all(groups, rollers, surface, contacts, turn_kick, out)


@kernel
def _rub(groups, rollers, surface, contacts, drive, later):
    if contacts.friction.shear is not None:
        friction.follow_slips_before(contacts.friction.shear, contacts.friction, rollers.n)
    friction.friction_contacts(groups, rollers, surface, contacts, drive, later)
    return 0.5 * drive.dt * friction.slips_after(groups, rollers, surface, contacts, drive.dt, True)


@kernel
def _energy(groups, contacts, n, out):
    samples.add_contact_energy(groups, contacts, n, out)


@kernel
def pull_spring(shear, contacts, pair, dt, limit, full_slip):
    """Pull with the first eight springs; see `fem.kernels.elements.friction.pull`."""
    friction.pull(shear, contacts, pair, 0, dt, splat(limit), splat(full_slip))


@kernel
def follow_slips(shear, forces, of_contacts, dt, n):
    """Both halves of `fem.kernels.elements.friction`."""
    friction.follow_slips_after(shear, forces, of_contacts, dt, n)
    friction.follow_slips_before(shear, of_contacts, n)


@kernel
def spring_energy(shear, n):
    """`fem.kernels.elements.friction.spring_energy`, J."""
    return friction.spring_energy(shear, n)


def move_slowed_ring(
    table: np.ndarray,
    u: np.ndarray,
    w: np.ndarray,
    mass: ReciprocalMass,
    dt: float,
    rows: tuple[int, int],
    raceway: int,
) -> None:
    """Move a ring that does not turn in a long step; `table` : −dt·M⁻¹K. Halos of w must repeat its ends."""
    slowing, v, calmed = mass.at(dt), np.zeros_like(w), w
    if mass.calming:
        calmed = np.zeros_like(w)
        calm_ring(slowing.velocities / dt * table, w, calmed, np.zeros(len(w)), 0.0, *rows)
    find_velocities(slowing.waves * table, calmed, w, v, dt, raceway)
    drift_slowed_ring(slowing.waves * table, (u, w, v), calmed, dt, (*rows, raceway))


def press_contacts(state: Arrays) -> None:
    """Find the normal forces of a state by its contact model; with many points their impulses are given too."""
    _press(state.groups, state.bodies, state.contacts, state.drive)


def push_surfaces(state: Arrays) -> None:
    """Give the impulses of the normal forces that `press_contacts` has found."""
    _push(state.groups, state.bodies, state.contacts, state.drive)


def press_groups(state: Arrays, groups: tuple) -> None:
    """Both, of some groups of pairs with the law below the grid."""
    _press_groups(groups, state.bodies.rollers, state.bodies.surface, state.contacts, state.drive)


def find_slips(state: Arrays, turn_kick: np.ndarray, out: np.ndarray) -> None:
    """How a state's patches grip and slip; see `fem.kernels.elements.friction.slip_velocity`."""
    _slips(state.groups, state.bodies.rollers, state.bodies.surface, state.contacts, turn_kick, out)


def rub_contacts(state: Arrays, later: bool = False) -> float:
    """Tractions of a state whose patches grip and slip, and their impulses; what they take in a step, J.

    `later`: the normal forces' impulses are still to be given, see `fem.kernels.elements.loop.kick`.
    """
    bodies = state.bodies
    return _rub(state.groups, bodies.rollers, bodies.surface, state.contacts, state.drive, later)


def contact_energy(state: Arrays) -> float:
    """Energy of a state's contacts, J."""
    out = np.zeros(columns.CONTACT + 1)
    _energy(state.groups, state.contacts, state.bodies.rollers.n, out)
    return float(out[columns.CONTACT])
