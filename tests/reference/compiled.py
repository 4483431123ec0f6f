"""ReportOptions of the time loop as kernels that Python can call, kept compiled as the time loop is."""

import numpy as np

from fem.elastic.reciprocal_mass import ReciprocalMass
from fem.kernels import (
    contact_kernels,
    disc_kernels,
    friction_solution,
    law,
    patches,
    ring_kernels,
    sample_kernels,
    shear_kernels,
    surfaces,
    time_loop,
)
from fem.kernels import law as creep
from fem.kernels.jit import kernel
from fem.kernels.lanes import splat
from fem.solver.elements.arrays import Arrays

kick_disc, drift_disc = kernel(disc_kernels.kick), kernel(disc_kernels.drift)
slow_disc, calm_ring = kernel(disc_kernels.slow_waves), kernel(ring_kernels.calm)
kick_ring, kick_ring_and_add = kernel(ring_kernels.kick), kernel(ring_kernels.kick_and_add)
drift_ring, drift_slowed_ring = kernel(ring_kernels.drift), kernel(ring_kernels.drift_slowed)
find_velocities = kernel(ring_kernels.find_velocities)
row_force, resultant = kernel(ring_kernels.row_force), kernel(ring_kernels.resultant)
wrap, set_rigid = kernel(ring_kernels.wrap), kernel(ring_kernels.set_rigid)
wrap_all = kernel(ring_kernels.wrap_all)
kick_force, stored_energy = kernel(law.kick_force), kernel(law.contact_energy)
next_force = kernel(law.next_force)
weight_slopes, place = kernel(patches.weight_slopes), kernel(surfaces.place)
creep_traction = kernel(creep.creep_traction)


@kernel
def kick(bodies, groups, contacts, drive, time, scratch):
    """`fem.kernels.time_loop.kick`."""
    return time_loop.kick(bodies, groups, contacts, drive, time, scratch)


@kernel
def drift(bodies, groups, contacts, drive, scratch):
    """`fem.kernels.time_loop.slide` and `drift`; the work that friction takes, J."""
    taken = time_loop.slide(bodies, groups, contacts, drive, scratch)
    time_loop.drift(bodies, drive, scratch)
    return taken


@kernel
def remember(bodies, drive, scratch):
    """`fem.kernels.sample_kernels.remember`."""
    sample_kernels.remember(bodies, drive, scratch)


@kernel
def kinetic_energy(bodies, drive, scratch):
    """`fem.kernels.sample_kernels.kinetic_energy`, J."""
    return sample_kernels.kinetic_energy(bodies, drive, scratch)


@kernel
def elastic_energy(bodies, drive, scratch):
    """`fem.kernels.sample_kernels.elastic_energy`, J."""
    return sample_kernels.elastic_energy(bodies, drive, scratch)


@kernel
def _press(groups, bodies, contacts, drive, points):
    time_loop.press_contacts(groups, bodies, contacts, drive, points)


@kernel
def _push(groups, bodies, contacts, drive, points):
    time_loop.push_surfaces(groups, bodies, contacts, drive, points)


@kernel
def _press_groups(groups, rollers, surface, contacts, drive):
    contact_kernels.press_patches(groups, rollers, surface, contacts, drive)
    contact_kernels.push_patches(groups, rollers, surface, contacts, None, drive.dt)


@kernel
def _slips(groups, rollers, surface, contacts, turn_kick, out):
    friction_solution.grip_all(groups, rollers, surface, contacts)
    friction_solution.slip_all(groups, rollers, surface, contacts, turn_kick, out)


@kernel
def _rub(groups, rollers, surface, contacts, drive, overlapping, whole, later):
    shear_kernels.follow_slips_before(contacts.friction.shear, contacts.friction, rollers.n)
    friction_solution.friction_contacts(groups, rollers, surface, contacts, drive, overlapping, whole, later)
    return 0.5 * drive.dt * friction_solution.slips_after(groups, rollers, surface, contacts, drive.dt, True)


@kernel
def _energy(groups, contacts, n, points, out):
    sample_kernels.add_contact_energy(groups, contacts, n, points, out)


@kernel
def pull_spring(shear, contacts, pair, dt, limit, full_slip):
    """Pull with the first eight springs; see `fem.kernels.shear_kernels.pull`."""
    shear_kernels.pull(shear, contacts, pair, 0, dt, splat(limit), splat(full_slip))


@kernel
def follow_slips(shear, forces, friction, dt, n):
    """Both halves of `fem.kernels.shear_kernels`."""
    shear_kernels.follow_slips_after(shear, forces, friction, dt, n)
    shear_kernels.follow_slips_before(shear, friction, n)


@kernel
def spring_energy(shear, n):
    """`fem.kernels.shear_kernels.spring_energy`, J."""
    return shear_kernels.spring_energy(shear, n)


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
    _press(state.groups, state.bodies, state.contacts, state.drive, state.contacts.points)


def push_surfaces(state: Arrays) -> None:
    """Give the impulses of the normal forces that `press_contacts` has found."""
    _push(state.groups, state.bodies, state.contacts, state.drive, state.contacts.points)


def press_groups(state: Arrays, groups: tuple) -> None:
    """Both, of some groups of pairs with the law below the grid."""
    _press_groups(groups, state.bodies.rollers, state.bodies.surface, state.contacts, state.drive)


def find_slips(state: Arrays, turn_kick: np.ndarray, out: np.ndarray) -> None:
    """How a state's patches grip and slip; see `fem.kernels.friction_kernels.slip_velocity`."""
    _slips(state.groups, state.bodies.rollers, state.bodies.surface, state.contacts, turn_kick, out)


def rub_contacts(state: Arrays, later: bool = False) -> float:
    """Tractions of a state whose patches grip and slip, and their impulses; what they take in a step, J.

    `later`: the normal forces' impulses are still to be given, see `fem.kernels.friction_solution.pushes_later`.
    """
    friction, bodies = state.contacts.friction, state.bodies
    options = friction.overlapping, friction.whole, later
    return _rub(state.groups, bodies.rollers, bodies.surface, state.contacts, state.drive, *options)


def contact_energy(state: Arrays) -> float:
    """Energy of a state's contacts, J."""
    out = np.zeros(sample_kernels.CONTACT + 1)
    _energy(state.groups, state.contacts, state.bodies.rollers.n, state.contacts.points, out)
    return float(out[sample_kernels.CONTACT])
