"""States of a bearing whose contacts are pressed at random, and what contacts do to their bodies."""

import numpy as np

from fem.kernels.elements.rings import HALO
from tests.reference.bearings import arrays, copies, model, operation, paper, resolved_model, soft
from tests.reference.compiled import press_contacts, push_surfaces

DT = 1e-7
PRESSED = 5e-6  # m, typical overlap of the circles
WAVY = 1e-6  # m, random displacement of every node: surfaces tilt by a milliradian


def set_turns(state, roller_turn, ring_turn):
    rollers = state.bodies.rollers
    rollers.turn[: rollers.n] = roller_turn
    rollers.cosine[:], rollers.sine[:] = np.cos(rollers.turn), np.sin(rollers.turn)
    state.drive.frame[:] = ring_turn, np.cos(ring_turn), np.sin(ring_turn)


def roller_field(state, flat):
    """(n_nodes, 2, n) view of a flat roller array."""
    return flat.reshape(state.bodies.disc.mass.size, 2, state.bodies.rollers.columns)[:, :, : state.bodies.rollers.n]


def fill_ring(field, values):
    """Put values into (rows, 2, n + 2 HALO) and close the seam."""
    field[:, :, HALO:-HALO] = values
    field[:, :, HALO - 1], field[:, :, -HALO:] = field[:, :, -HALO - 1], field[:, :, HALO : 2 * HALO]


def random_state(seed, resolved=False, mesh_size=1e-3):
    """Rollers pressed on both raceways and two on each other, everything turned and wavy at random."""
    rng = np.random.default_rng(seed)
    whole = resolved_model(soft(), 2e-4) if resolved else model(paper(), mesh_size)
    state = copies(arrays(whole, operation(speed=300.0), DT, from_rest=True))
    rollers, n = state.bodies.rollers, state.bodies.rollers.n
    angle = np.cumsum(rng.uniform(0.95, 1.05, n)) * 2.0 * np.pi / n
    angle[4] = angle[3] + 2.0 * np.arcsin((rollers.radius - 0.5 * PRESSED) / 0.023)  # 3 and 4 press on each other
    rho = 0.023 + PRESSED * rng.uniform(-1.0, 1.0, n)
    rho[4] = rho[3]
    rollers.centre[:, :n] = rho * np.cos(angle), rho * np.sin(angle)
    state.drive.hub[:] = PRESSED * rng.uniform(-1.0, 1.0, 2)
    set_turns(state, rng.uniform(-np.pi, np.pi, n), rng.uniform(-np.pi, np.pi))
    roller_field(state, state.bodies.disc.u)[:] = WAVY * rng.standard_normal((state.bodies.disc.mass.size, 2, n))
    for ring in (state.bodies.inner, state.bodies.outer):
        fill_ring(ring.u, WAVY * rng.standard_normal((ring.radii.size, 2, ring.n_sectors)))
    return state


def press(state):
    """Normal forces at a copy of a state with all velocities and impulses cleared."""
    state = copies(state)
    rollers, drive = state.bodies.rollers, state.drive
    for entry in (
        state.bodies.disc.w,
        rollers.node_impulse,
        rollers.body_impulse,
        rollers.turn_kick,
        drive.impulse,
        state.bodies.inner.w,
        state.bodies.outer.w,
    ):
        entry[:] = 0.0
    drive.moment[:] = 0.0
    state.contacts.forces.force[:] = 0.0
    press_contacts(state)
    push_surfaces(state)
    return state


def cartesian_resultant(ring, c=1.0, s=0.0):
    """Momentum of a ring's velocities, N s, fixed axes."""
    w = ring.w[:, :, HALO:-HALO] * ring.row_mass[:, None, None]
    cosine, sine = ring.cosines[HALO:-HALO], ring.sines[HALO:-HALO]
    x, y = np.sum(w[:, 0] * cosine - w[:, 1] * sine), np.sum(w[:, 0] * sine + w[:, 1] * cosine)
    return np.array([c * x - s * y, s * x + c * y])


def roller_resultants(state):
    """Momentum of each roller's nodal velocities, (n, 2), fixed axes."""
    rollers, n = state.bodies.rollers, state.bodies.rollers.n
    x, y = np.sum(roller_field(state, state.bodies.disc.w) * state.bodies.disc.mass[:, None, None], axis=0)
    c, s = rollers.cosine[:n], rollers.sine[:n]
    return np.column_stack([c * x - s * y, s * x + c * y])


def with_random_velocities(state, seed):
    rng = np.random.default_rng(seed)
    n = state.bodies.rollers.n
    roller_field(state, state.bodies.disc.w)[:] = rng.standard_normal((state.bodies.disc.mass.size, 2, n))
    fill_ring(
        state.bodies.inner.w, rng.standard_normal((state.bodies.inner.radii.size, 2, state.bodies.inner.n_sectors))
    )
    fill_ring(
        state.bodies.outer.w, rng.standard_normal((state.bodies.outer.radii.size, 2, state.bodies.outer.n_sectors))
    )
    state.bodies.rollers.velocity[:, :n] = rng.standard_normal((n, 2)).T
    state.bodies.rollers.spin[:n] = 500.0 * rng.standard_normal(n)
    return state
