"""States of random contacts that rub, with tangential springs and without."""

from dataclasses import replace

import numpy as np

from tests.reference.bearings import copies
from tests.reference.compiled import (
    find_slips,
    press_contacts,
    push_surfaces,
    rub_contacts,
)
from tests.reference.contact_states import (
    DT,
    random_state,
    with_random_velocities,
)


def by_contact(normal):
    """(kind, 2, columns) as (kind, 13, 2)."""
    return np.moveaxis(normal[:, :, :13], 1, 2)


def rubbing_state(seed=1, mesh_size=1e-3):
    state = pressed_state(seed, mesh_size)
    push_surfaces(state)
    state.drive.moment[0] = 0.0
    return state


def pressed_state(seed, mesh_size):
    state = with_random_velocities(random_state(seed, mesh_size=mesh_size), 7)
    state = with_friction(state, coefficient=0.1)
    state.contacts.forces.force[:] = 0.0
    state.drive.impulse[:] = 0.0
    press_contacts(state)
    for entry in (state.bodies.rollers.node_impulse, state.bodies.rollers.body_impulse, state.bodies.rollers.turn_kick):
        entry[:] = 0.0
    return state


def with_friction(state, **changes):
    return replace(state, contacts=state.contacts._replace(friction=state.contacts.friction._replace(**changes)))


def without_springs(state):
    """Contacts whose creep is solved for, as pressure points have it."""
    return with_friction(state, shear=None)


def rub(state):
    """Friction at a copy; returns it, slips before and after, and the energy it takes, J."""
    state = copies(state)
    find_slips(state, state.bodies.rollers.turn_kick, state.contacts.friction.slip)
    before = state.contacts.friction.slip.copy()
    taken = rub_contacts(state)
    after = np.zeros_like(before)
    find_slips(state, state.bodies.rollers.turn_kick, after)
    return state, before, after, taken


def stretched_state():
    """Springs of closed contacts stretched at random, some beyond what sliding stretches them by, and slipping."""
    state, rng = rubbing_state(), np.random.default_rng(3)
    shear, force = state.contacts.friction.shear, state.contacts.forces.force
    shear.compliance[:] = 1e-9 * rng.uniform(1.0, 4.0, force.shape)
    shear.stretch[:] = 0.1 * force * shear.compliance * rng.uniform(-1.5, 1.5, force.shape)
    shear.stretch[rng.uniform(size=force.shape) < 0.2] = 0.0  # these have just closed
    shear.creep[:] = 1e-3 * np.sign(shear.stretch)
    shear.since[:] = DT * (shear.stretch != 0.0)
    state.bodies.rollers.velocity[:] *= 0.05
    return state
