"""States of a bearing whose contacts are pressed at random, and what contacts do to their bodies."""

import numpy as np

from fem.kernels.contact_kernels import contact_forces, push_nodes
from fem.kernels.ring_kernels import HALO
from tests.reference.bearings import arrays, copies, model, operation, paper, resolved_model, soft

DT = 1e-7
PRESSED = 5e-6  # m, typical overlap of the circles
WAVY = 1e-6  # m, random displacement of every node: surfaces tilt by a milliradian


def set_turns(state, roller_turn, ring_turn):
    rollers = state.rollers
    rollers.turn[: rollers.n] = roller_turn
    rollers.cosine[:], rollers.sine[:] = np.cos(rollers.turn), np.sin(rollers.turn)
    state.drive.ring[:3] = ring_turn, np.cos(ring_turn), np.sin(ring_turn)


def roller_field(state, flat):
    """(n_nodes, 2, n) view of a flat roller array."""
    return flat.reshape(state.rollers.mass.size, 2, state.rollers.columns)[:, :, : state.rollers.n]


def fill_ring(field, values):
    """Put values into (rows, 2, n + 2 HALO) and close the seam."""
    field[:, :, HALO:-HALO] = values
    field[:, :, HALO - 1], field[:, :, -HALO] = field[:, :, -HALO - 1], field[:, :, HALO]


def random_state(seed, resolved=False, mesh_size=1e-3):
    """Rollers pressed on both raceways and two on each other, everything turned and wavy at random."""
    rng = np.random.default_rng(seed)
    whole = resolved_model(soft(), 2e-4) if resolved else model(paper(), mesh_size)
    state = copies(arrays(whole, operation(speed=300.0), DT, from_rest=True))
    rollers, n = state.rollers, state.rollers.n
    angle = np.cumsum(rng.uniform(0.95, 1.05, n)) * 2.0 * np.pi / n
    angle[4] = angle[3] + 2.0 * np.arcsin((rollers.radius - 0.5 * PRESSED) / 0.023)  # 3 and 4 press on each other
    rho = 0.023 + PRESSED * rng.uniform(-1.0, 1.0, n)
    rho[4] = rho[3]
    rollers.centre[:, :n] = rho * np.cos(angle), rho * np.sin(angle)
    state.drive.hub[:] = PRESSED * rng.uniform(-1.0, 1.0, 2)
    set_turns(state, rng.uniform(-np.pi, np.pi, n), rng.uniform(-np.pi, np.pi))
    roller_field(state, rollers.u)[:] = WAVY * rng.standard_normal((rollers.mass.size, 2, n))
    for ring in (state.inner, state.outer):
        fill_ring(ring.u, WAVY * rng.standard_normal((ring.radii.size, 2, ring.n_sectors)))
    return state


def press(state):
    """Normal forces at a copy of a state with all velocities and impulses cleared."""
    state = copies(state)
    rollers, drive = state.rollers, state.drive
    for entry in (
        rollers.w,
        rollers.impulse,
        rollers.tilt,
        rollers.turn_kick,
        drive.impulse,
        state.inner.w,
        state.outer.w,
    ):
        entry[:] = 0.0
    drive.ring[3] = 0.0
    state.contacts.force[:] = 0.0
    contacts = state.contacts
    contact_forces(rollers, state.inner, state.outer, contacts, drive, state.scratch.slope, contacts.resolved)
    push_nodes(rollers, state.inner, state.outer, contacts, drive, contacts.resolved)
    return state


def cartesian_resultant(ring, c=1.0, s=0.0):
    """Momentum of a ring's velocities, N s, fixed axes."""
    w = ring.w[:, :, HALO:-HALO] * ring.row_mass[:, None, None]
    cosine, sine = ring.cosines[HALO:-HALO], ring.sines[HALO:-HALO]
    x, y = np.sum(w[:, 0] * cosine - w[:, 1] * sine), np.sum(w[:, 0] * sine + w[:, 1] * cosine)
    return np.array([c * x - s * y, s * x + c * y])


def roller_resultants(state):
    """Momentum of each roller's nodal velocities, (n, 2), fixed axes."""
    rollers, n = state.rollers, state.rollers.n
    x, y = np.sum(roller_field(state, rollers.w) * rollers.mass[:, None, None], axis=0)
    c, s = rollers.cosine[:n], rollers.sine[:n]
    return np.column_stack([c * x - s * y, s * x + c * y])


def with_random_velocities(state, seed):
    rng = np.random.default_rng(seed)
    n = state.rollers.n
    roller_field(state, state.rollers.w)[:] = rng.standard_normal((state.rollers.mass.size, 2, n))
    fill_ring(state.inner.w, rng.standard_normal((state.inner.radii.size, 2, state.inner.n_sectors)))
    fill_ring(state.outer.w, rng.standard_normal((state.outer.radii.size, 2, state.outer.n_sectors)))
    state.rollers.velocity[:, :n] = rng.standard_normal((n, 2)).T
    state.rollers.spin[:n] = 500.0 * rng.standard_normal(n)
    return state
