"""Steps of single elastic bodies: their order in dt, and what spinning discs conserve."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from fem.contacts.critical_step import critical_time_step
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.ring_kernels import HALO
from fem.solver.elements.arrays import disc_nodes
from lagrange import Bearing
from tests.reference import compiled
from tests.reference.bearings import (
    LENGTH,
    STEEL,
    arrays,
    copies,
    disc,
    model,
    operation,
    ring,
)
from tests.reference.compiled import drift, elastic_energy, kick, remember


def observed_order(h, error):
    return np.polyfit(np.log(h), np.log(error), 1)[0]


# order in dt ----------------------------------------------------------------------------------------------------


def disc_mode(body):
    """Lowest vibration: ω, rad/s, and its shape, (2 n_nodes,), of unit largest entry."""
    mass = sparse.diags(np.repeat(body.mass, 2))
    shift = STEEL.lame_mu / STEEL.density / body.shape.radius**2
    start = np.random.default_rng(1).standard_normal(2 * body.n_nodes)
    values, vectors = eigsh(body.stiffness, k=5, M=mass, sigma=shift, which="LM", v0=start)
    order = np.argsort(values)
    values, vectors = values[order], vectors[:, order]
    shape = vectors[:, 3]
    return np.sqrt(values[3]), shape / np.abs(shape).max()


def phase(mass):
    """A wave's error of phase over ω t (ω dt)²: a seventh and a fifth of leapfrog's."""
    return abs(1.0 / 12.0 - mass.share) / 2.0


def ring_up_disc(body, shape, omega, dt, n_steps, mass):
    """Amplitude of the mode at every step, from rest at the first, with frames that do not turn."""
    columns = 16
    slowing = mass.at(dt)
    nodes = disc_nodes(body, dt, columns)
    nodes = nodes if mass.calming else nodes._replace(calmed=nodes.w)
    u, w = np.zeros((2 * body.n_nodes, columns)), np.zeros((2 * body.n_nodes, columns))
    u[:, 3] = 1e-6 * shape
    w[:, 3] = 0.5 * dt * omega**2 * u[:, 3]  # at −dt/2, and after the kick that follows
    weight = np.repeat(body.mass, 2) * shape
    weight /= weight @ shape * 1e-6
    nodes.u[:], nodes.w[:] = u.ravel(), w.ravel()
    still, torque, found = np.zeros(columns), np.zeros(columns), []
    turns = disc_kernels.Turns(still, np.ones(columns), still, still, still)
    for _ in range(n_steps):
        found.append(weight @ nodes.u.reshape(-1, columns)[:, 3])
        compiled.kick_disc(nodes, nodes.w, columns, torque)
        compiled.slow_disc(nodes, turns.cosine, columns, slowing.waves, slowing.velocities / dt, dt, torque)
        compiled.drift_disc(nodes, turns, columns, dt, torque)
    return np.array(found)


LONG = pytest.mark.parametrize("mass", [SECOND, THIRD], ids=["second degree", "third degree"])


@LONG
def test_a_vibrating_disc_is_followed_with_order_two(mass):
    body = disc(0.005, 3)
    omega, shape = disc_mode(body)
    end = 3.3 * 2.0 * np.pi / omega
    counts = np.array([100, 200, 400, 800])
    error = []
    for count in counts:
        dt = end / count
        found = ring_up_disc(body, shape, omega, dt, count + 1, mass)
        error.append(np.abs(found - np.cos(omega * dt * np.arange(count + 1))).max())
    assert observed_order(end / counts, error) == pytest.approx(2.0, abs=0.03)
    assert error[-1] == pytest.approx(phase(mass) * omega * end * (omega * end / counts[-1]) ** 2, rel=0.1)


@LONG
def test_a_vibrating_held_ring_is_followed_with_order_two(mass):
    body, harmonic = ring(0.0125, 0.018, 56, 3, True), 2
    keep = (2 * body.free_rows[:, None] + np.arange(2)).ravel()
    stiffness = body.harmonic_stiffness(np.array([harmonic]))[0][np.ix_(keep, keep)]
    values, vectors = eigh(stiffness, np.diag(np.repeat(body.row_mass, 2)[keep]))
    omega = np.sqrt(values[0])
    shape = np.zeros((body.n_rows, 2, body.n_sectors + 2 * HALO))
    wave = np.exp(1j * harmonic * 2.0 * np.pi * (np.arange(body.n_sectors + 2 * HALO) - HALO) / body.n_sectors)
    shape[body.free_rows] = (vectors[:, 0].reshape(-1, 2)[:, :, None] * wave).real
    shape /= np.abs(shape).max()
    at = np.unravel_index(np.argmax(np.abs(shape[:, :, HALO:-HALO])), (body.n_rows, 2, body.n_sectors))
    at = (at[0], at[1], at[2] + HALO)
    end, counts, error = 3.3 * 2.0 * np.pi / omega, np.array([100, 200, 400]), []
    for count in counts:
        dt = end / count
        table = -dt * ring_kernels.coefficients(body.stencil) / body.row_mass[:, None]
        u, w, found = 1e-6 * shape, 0.5e-6 * dt * omega**2 * shape, []
        for _ in range(count + 1):
            found.append(u[at] / (1e-6 * shape[at]))
            compiled.kick_ring(table, u, w, 1, body.n_rows)
            compiled.wrap_all(w)
            compiled.move_slowed_ring(table, u, w, mass, dt, (1, body.n_rows), body.raceway_row)
        error.append(np.abs(np.array(found) - np.cos(omega * dt * np.arange(count + 1))).max())
    assert observed_order(end / counts, error) == pytest.approx(2.0, abs=0.03)
    assert error[-1] == pytest.approx(phase(mass) * omega * end * (omega * end / counts[-1]) ** 2, rel=0.1)


# spinning freely ------------------------------------------------------------------------------------------------


# rollers of 18 mm that touch nothing for a millimetre
FREE = Bearing(
    n_rollers=3, roller_radius=0.018, roller_length=LENGTH, inner_raceway_radius=0.018, outer_raceway_radius=0.056,
    bore_radius=0.0125, outside_radius=0.065, roller=STEEL, inner_ring=STEEL, outer_ring=STEEL,
)  # fmt: skip
SPIN = 4500.0 * np.pi / 30.0


def spinning(mesh_size, courant, mass=LUMPED):
    """Three free undeformed discs that turn on the spot."""
    whole = model(FREE, mesh_size)
    dt = courant * critical_time_step(whole, 1.0, mass=mass)
    how = operation(speed=0.0, gravity=0.0, radial_load=0.0)
    state = copies(arrays(whole, how, dt, from_rest=True, mass=mass))
    rollers = state.bodies.rollers
    points = state.bodies.disc.points.reshape(-1, 2)
    field = state.bodies.disc.w.reshape(-1, 2, rollers.columns)[:, :, :3]
    field[:] = SPIN * (np.stack([-points[:, 1], points[:, 0]], axis=1) + 0.5 * dt * SPIN * points)[:, :, None]
    rollers.spin[:3], rollers.increment[:3] = SPIN, SPIN * dt
    return state, dt


def step(state):
    kick(state.bodies, state.groups, state.contacts, state.drive, 0.0, state.scratch)
    drift(state.bodies, state.groups, state.contacts, state.drive, state.scratch)


def discs(state, name):
    """(n_nodes, 2, 3) of a field."""
    return getattr(state.bodies.disc, name).reshape(-1, 2, state.bodies.rollers.columns)[:, :, :3]


def test_a_disc_spins_up_to_its_centrifugal_growth_in_the_mean():
    """u(R) = (1+ν)(1−2ν) ρ ω² R³/(4E) = 6.29 nm (Timoshenko and Goodier, article 32, plane strain)."""
    state, dt = spinning(3e-3, 0.8)
    disc = state.bodies.disc
    surface = slice(state.bodies.surface.first, None)
    outward = disc.points.reshape(-1, 2)[surface] / 0.018
    period = 2.0 * np.pi * 0.018 / (3.9769 * np.sqrt(STEEL.lame_mu / STEEL.density))  # of breathing
    growth = []
    for _ in range(int(40 * period / dt)):
        step(state)
        growth.append(np.einsum("na,naj->j", outward, discs(state, "u")[surface]) / len(outward))
    growth = np.array(growth)
    static = model(FREE, 3e-3).roller.relaxed(SPIN**2 * (disc.mass[:, None] * disc.points.reshape(-1, 2)).ravel())
    static = np.einsum("na,na->", outward, static.reshape(-1, 2)[surface]) / len(outward)
    # forty periods' mean of 1 − cos and a few faster modes
    np.testing.assert_allclose(growth.mean(axis=0), static, rtol=0.01)
    np.testing.assert_allclose(growth.mean(axis=0), 6.29e-9, rtol=0.03)  # h² of the 3 mm mesh, 1.9 %
    assert growth.max() > 1.9 * static, "it was let go undeformed"


def vibrate(courant, smooth, n_steps, masses=SECOND):
    """Energies, angular momenta, largest mean displacement and lead of spinning discs set vibrating, 1 µm."""
    state, dt = spinning(6e-3, courant, masses)
    rollers, rng = state.bodies.rollers, np.random.default_rng(3)
    mass, points = state.bodies.disc.mass[:, None, None], state.bodies.disc.points.reshape(-1, 2)
    if smooth:
        u = 1e-6 * disc_mode(model(FREE, 6e-3).roller)[1].reshape(-1, 2, 1) * np.array([1.0, 0.5, -1.0])
    else:
        u = 1e-6 * rng.standard_normal(discs(state, "u").shape)
    u -= np.sum(mass * u, axis=0) / rollers.total_mass
    turned = np.stack([-points[:, 1], points[:, 0]], axis=1)[:, :, None]
    u -= turned * np.sum(mass * turned * u, axis=(0, 1)) / rollers.inertia
    discs(state, "u")[:] = u
    moving, stiffness = (state.bodies, state.drive, state.scratch), model(FREE, 6e-3).roller.stiffness
    energy, angular, mean, lead = [], [], [], []
    for _ in range(n_steps):
        remember(*moving)
        before = discs(state, "w").copy()
        kick(state.bodies, state.groups, state.contacts, state.drive, 0.0, state.scratch)
        after = discs(state, "w") + turned * rollers.turn_kick[:3]
        position = points[:, :, None] + discs(state, "u")
        calmed = after - masses.at(dt).velocities * (stiffness @ after.reshape(-1, 3)).reshape(after.shape) / mass
        stiffness_after = (stiffness @ calmed.reshape(-1, 3)).reshape(after.shape)
        kinetic = np.sum(mass * before * after) - state.drive.slowing * np.sum(before * stiffness_after)
        energy.append(0.5 * kinetic + elastic_energy(*moving))
        angular.append(np.sum(mass[:, 0] * (position[:, 0] * after[:, 1] - position[:, 1] * after[:, 0]), axis=0))
        drift(state.bodies, state.groups, state.contacts, state.drive, state.scratch)
        mean.append(np.abs(np.sum(mass * discs(state, "u"), axis=0)).max() / rollers.total_mass)
        lead.append(np.abs(rollers.lead[:3]).max())
    energy, angular = np.array(energy), np.array(angular)
    vibration = energy[0] - 1.5 * rollers.inertia * SPIN**2
    np.testing.assert_allclose(rollers.turn[:3] + rollers.lead[:3], SPIN * dt * n_steps, rtol=1e-4)  # u/R of inertia
    assert np.abs(rollers.velocity[:, :3]).max() < 1e-12
    return energy / vibration, angular / angular[0], max(mean), max(lead)


SMOOTH = pytest.mark.parametrize("smooth", [True, False], ids=["lowest mode", "noise"])


@SMOOTH
@pytest.mark.parametrize(("courant", "mass"), [(0.26, SECOND), (0.19, THIRD)], ids=["second degree", "third degree"])
def test_a_spinning_vibrating_disc_conserves_energy_and_angular_momentum(smooth, courant, mass):
    energy, angular, mean, lead = vibrate(courant, smooth, 3000, mass)
    # the energy swings with the frame's turn in a step; angular momentum with (u/R)², small angles of the polar fit
    wobble, twist, drift = (8e-6, 1e-13, 1e-10) if smooth else (3e-5, 2.0 * (1e-6 / 0.018) ** 2, 2e-8)
    assert np.ptp(energy) < wobble
    window = np.hanning(1500)  # a plain mean would keep part of the swing
    gained = window @ (energy[1500:] - energy[:1500]) / window.sum()
    assert abs(gained) < drift, "nothing is gained or lost in the long run"
    assert np.ptp(angular, axis=0).max() < twist
    # frames stay with their bodies: at the centre of mass, turned with the body to within one step's wobble
    assert mean < 1e-16  # m, round-off of 3000 steps
    assert lead < 1e-8


@SMOOTH
def test_the_energy_of_a_spinning_vibrating_disc_swings_by_the_square_of_the_step(smooth):
    coarse, fine = vibrate(0.8, smooth, 1000)[0], vibrate(0.2, smooth, 4000)[0]
    assert np.ptp(fine) < 0.07 * np.ptp(coarse)  # (1/4)² = 0.0625
