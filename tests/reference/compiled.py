"""Parts of the time loop as kernels that Python can call, kept compiled as the time loop is."""

import numpy as np

from fem.kernels import (
    contact_kernels,
    disc_kernels,
    friction_kernels,
    friction_solution,
    law,
    patches,
    ring_kernels,
    sample_kernels,
    shear_kernels,
    surfaces,
    time_loop,
)
from fem.kernels.jit import kernel
from fem.kernels.lanes import splat
from fem.solver.run_arrays import Arrays

kick_disc, drift_disc = kernel(disc_kernels.kick), kernel(disc_kernels.drift)
slow_disc, slow_ring = kernel(disc_kernels.slow_waves), kernel(ring_kernels.slow_waves)
kick_ring, kick_ring_and_add = kernel(ring_kernels.kick), kernel(ring_kernels.kick_and_add)
drift_ring, drift_slowed_ring = kernel(ring_kernels.drift), kernel(ring_kernels.drift_slowed)
row_force, resultant = kernel(ring_kernels.row_force), kernel(ring_kernels.resultant)
wrap, set_rigid = kernel(ring_kernels.wrap), kernel(ring_kernels.set_rigid)
wrap_all = kernel(ring_kernels.wrap_all)
kick_force, stored_energy = kernel(law.kick_force), kernel(law.contact_energy)
next_force = kernel(law.next_force)
weight_slopes, place = kernel(patches.weight_slopes), kernel(surfaces.place)
creep_traction = kernel(friction_kernels.creep_traction)


@kernel
def kick(bodies, groups, contacts, drive, time, scratch):
    """`fem.kernels.time_loop.kick`."""
    return time_loop.kick(bodies, groups, contacts, drive, time, scratch)


@kernel
def drift(bodies, drive, scratch):
    """`fem.kernels.time_loop.drift`."""
    time_loop.drift(bodies, drive, scratch)


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
    return friction_solution.friction_contacts(groups, rollers, surface, contacts, drive, overlapping, whole, later)


@kernel
def _energy(groups, contacts, n, points, out):
    sample_kernels.add_contact_energy(groups, contacts, n, points, out)


@kernel
def stretch_spring(shear, traction, limit, creep, slip):
    """Stretch the first eight springs, all alike; see `fem.kernels.shear_kernels.stretch`."""
    force = splat(traction)
    shear_kernels.stretch(shear, 0, force == traction, force, splat(limit), splat(creep), splat(slip))


@kernel
def spring_energy(shear, traction, n):
    """`fem.kernels.shear_kernels.spring_energy`, J."""
    return shear_kernels.spring_energy(shear, traction, n)


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
    """How a state's patches grip and slip; see `fem.kernels.friction_kernels.slip_pair`."""
    _slips(state.groups, state.bodies.rollers, state.bodies.surface, state.contacts, turn_kick, out)


def rub_contacts(state: Arrays, later: bool = False) -> float:
    """Tractions of a state whose patches grip, and their impulses; what they take in a step, J.

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
