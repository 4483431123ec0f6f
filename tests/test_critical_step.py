"""The critical time step: dense eigenvalues, and leapfrog itself just below and just above it."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals

from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.critical_step import FASTEST, LANCZOS_TOLERANCE, STEP_TOLERANCE, WORTH, critical_time_step
from fem.contacts.patch import disc_patch_force, ring_patch_force
from fem.elastic.assembly import assemble
from fem.elastic.reciprocal_mass import SHARE, slowing
from fem.kernels import disc_kernels, ring_kernels
from fem.kernels.ring_kernels import HALO
from fem.solver.arrays import disc_nodes
from meshes import Mesh
from tests.reference import compiled
from tests.reference.bearings import LENGTH, STEEL, disc, model, paper, ring

LOAD = 650.0  # N, on the most loaded roller


def without_contacts(whole):
    """The model with contacts a million million times softer."""
    soft = {name: replace(getattr(whole, name), A=1e12 * getattr(whole, name).A) for name in LAWS}
    return replace(whole, **soft)


LAWS = ("inner_law", "outer_law", "roller_law")


def dense_disc(body, springs=()):
    """M⁻¹K and Σ 2k M⁻¹ f fᵀ, symmetric."""
    stiffness, pressed = body.stiffness.toarray(), np.zeros(body.stiffness.shape)
    for j, spring in enumerate(springs):
        patch = disc_patch_force(body, 2.0 * np.pi * j / len(springs))
        pressed += 2.0 * spring * np.outer(patch, patch)
    scale = 1.0 / np.sqrt(np.repeat(body.mass, 2))
    return scale[:, None] * stiffness * scale, scale[:, None] * pressed * scale


def dense_ring(body, spring=0.0):
    """The same of the held ring in Cartesian components, from scikit-fem's own matrix."""
    stiffness = assemble(Mesh(points=body.points, cells=body.cells), body.material, LENGTH).stiffness.toarray()
    angle = body.angles
    radial, across = np.moveaxis(ring_patch_force(body, 0.0), 1, 0)
    x, y = radial * np.cos(angle) - across * np.sin(angle), radial * np.sin(angle) + across * np.cos(angle)
    patch = np.stack([x, y], axis=-1).ravel()
    node = np.arange(body.n_rows * body.n_sectors).reshape(body.n_rows, -1)[body.free_rows].ravel()
    free = (2 * node[:, None] + np.arange(2)).ravel()
    scale = 1.0 / np.sqrt(np.repeat(body.row_mass[body.free_rows], 2 * body.n_sectors))
    pressed = 2.0 * spring * np.outer(scale * patch[free], scale * patch[free])
    return scale[:, None] * stiffness[np.ix_(free, free)] * scale, pressed


def longest(waves, pressed):
    """By bisection: dt² ω² of (1 − γ dt² A)(A + S) reaches 4, or the parenthesis 0."""
    fastest = eigh(waves, eigvals_only=True)[-1]

    def bears(dt):
        inverse_mass = np.eye(len(waves)) - SHARE * dt**2 * waves
        return dt**2 * np.abs(eigvals(inverse_mass @ (waves + pressed))).max() <= 4.0

    low, high = 0.0, np.sqrt(FASTEST / (SHARE * fastest))
    if bears(high):
        return high
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bears(middle) else (low, middle)
    return 0.5 * (low + high)


def dense_step(whole, springs):
    return min(
        longest(*dense_disc(whole.roller, springs)),
        longest(*dense_ring(whole.inner_ring, springs[0])),
        longest(*dense_ring(whole.outer_ring, springs[1])),
    )


def test_without_contacts_it_is_the_dense_eigenvalue():
    whole = model(paper(), 2e-3)
    found = critical_time_step(without_contacts(whole), LOAD)
    wanted = dense_step(whole, [0.0, 0.0, 0.0])
    # never above; Lanczos' tolerance below, and the same added for safety
    assert found <= wanted * (1.0 + 1e-9)
    assert found >= wanted * (1.0 - 1.1 * LANCZOS_TOLERANCE)


def test_with_contacts_it_is_the_dense_eigenvalue_with_springs():
    whole, load = model(paper(), 2e-3), LOAD
    springs = [getattr(whole, name).stiffness(LOAD_MARGIN * load) for name in LAWS]
    found, wanted = critical_time_step(whole, load), dense_step(whole, springs)
    assert found <= wanted * (1.0 + 3e-4)  # of twelve halves
    assert found >= wanted * (1.0 - 2.0 * STEP_TOLERANCE)


@pytest.mark.parametrize("load", [LOAD, 4.0 * LOAD, 7.0 * LOAD, 20.0 * LOAD])
def test_all_shorter_steps_are_stable(load):
    """dt² ω² of slowed waves on springs rises with the step, and then may fall."""
    whole = model(paper(), 2e-3)
    springs = [getattr(whole, name).stiffness(LOAD_MARGIN * load) for name in LAWS]
    found = critical_time_step(whole, load)
    lumped = critical_time_step(whole, load, share=0.0)
    share = SHARE if found > lumped else 0.0
    for waves, pressed in (dense_disc(whole.roller, springs), dense_ring(whole.outer_ring, springs[1])):
        for dt in found * np.array([0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0]):
            slowed = waves + pressed - share * dt**2 * waves @ (waves + pressed)
            assert dt**2 * np.abs(eigvals(slowed)).max() <= 4.0 + 1e-6


def test_where_a_reciprocal_mass_gains_too_little_masses_are_lumped():
    whole = model(paper(), 2e-3)
    stiff = 1e3 * LOAD
    lumped = critical_time_step(whole, stiff, share=0.0)
    assert critical_time_step(whole, stiff) == lumped
    springs = [getattr(whole, name).stiffness(LOAD_MARGIN * stiff) for name in LAWS]
    assert dense_step(whole, springs) < WORTH * lumped * (1.0 + 3e-4)
    assert critical_time_step(whole, LOAD) > WORTH * critical_time_step(whole, LOAD, share=0.0)


def test_contacts_lower_it_or_leave_it():
    whole = model(paper(), 2e-3)
    free = critical_time_step(without_contacts(whole), LOAD)
    steps = np.array([critical_time_step(whole, load) for load in (1.0, 100.0, 1e4, 1e6, 1e9)])
    assert np.all(np.diff(steps) <= 1e-12 * free)  # stiffer with the load
    assert np.all(steps <= free * (1.0 + LANCZOS_TOLERANCE))
    assert steps[-2] == pytest.approx(steps[-1], rel=1e-6)  # the straight line has a stiffness of its own
    hard = replace(whole, roller_law=replace(whole.roller_law, A=1e-2 * whole.roller_law.A))
    assert critical_time_step(hard, LOAD) < 0.7 * free


def test_it_is_the_same_number_every_time():
    whole = model(paper(), 2e-3)
    assert critical_time_step(whole, LOAD) == critical_time_step(whole, LOAD)


def test_it_shrinks_with_the_mesh():
    steps = [critical_time_step(model(paper(), size), LOAD) for size in (2e-3, 1e-3)]
    # half the spacing, half the step; node counts are rounded: 18 and 30 on the roller, 2 and 4 layers in the ring
    assert steps[0] / steps[1] == pytest.approx(2.0, rel=0.25)
    # by 14/4 of the square of the time in which a wave crosses an element
    assert steps[1] < sqrt(0.25 / SHARE) * 1e-3 / STEEL.dilatational_wave_speed


def leapfrog_disc(body, dt, n_steps):
    """Largest displacement, relative to the first, after free leapfrog steps."""
    columns = 16
    nodes = disc_nodes(body, dt, columns)
    u = np.zeros((body.n_nodes, 2, columns))
    u[:, :, 0] = np.random.default_rng(1).standard_normal((body.n_nodes, 2))
    nodes.u[:] = u.ravel()
    still, torque = np.zeros(columns), np.zeros(columns)
    turns = disc_kernels.Turns(still, np.ones(columns), still, still, still)
    first = np.abs(u).max()
    for _ in range(n_steps):
        compiled.kick_disc(nodes, nodes.w, columns, torque)
        compiled.slow_disc(nodes, turns.cosine, columns, slowing(dt), dt, torque)
        compiled.drift_disc(nodes, turns, columns, dt, torque)
    return np.abs(nodes.u).max() / first


def leapfrog_ring(body, dt, n_steps):
    table = -dt * ring_kernels.coefficients(body.stencil) / body.row_mass[:, None]
    first, last = (1, body.n_rows) if body.held_row == 0 else (0, body.n_rows - 1)
    u = np.zeros((body.n_rows, 2, body.n_sectors + 2 * HALO))
    u[first:last, :, HALO:-HALO] = np.random.default_rng(2).standard_normal((last - first, 2, body.n_sectors))
    width = u.shape[2]
    for at in range(0, u.size, width):
        compiled.wrap(u, at, width)
    w, start = np.zeros_like(u), np.abs(u).max()
    for _ in range(n_steps):
        compiled.kick_ring(table, u, w, first, last)
        compiled.wrap_all(w)
        compiled.drift_slowed_ring(slowing(dt) * table, u, w, dt, first, last)
    return np.abs(u).max() / start


@pytest.mark.parametrize("which", ["roller", "inner ring", "outer ring"])
def test_leapfrog_is_stable_just_below_it_and_blows_up_just_above(which):
    if which == "roller":
        body, leapfrog = disc(0.005, 3), leapfrog_disc
        limit = longest(*dense_disc(body))
    else:
        inside = which == "inner ring"
        body = ring(0.0125, 0.018, 56, 3, True) if inside else ring(0.028, 0.0325, 88, 2, False)
        limit, leapfrog = longest(*dense_ring(body)), leapfrog_ring
    limit /= np.sqrt(FASTEST)
    # dt² ω² of a step is z (1 − γ z) with z = (ω dt)², at most 1/(4 γ) = 3.5: at any number of steps a mode is
    # amplified at most 1/sqrt(1 − 3.5/4) = 2.8 times, the fastest 1/sqrt(1 − 0.98²) = 5 times
    assert leapfrog(body, 0.98 * limit, 4000) < 20.0
    # at 1.02 it is −14·1.02²·(1.02² − 1) for the fastest: exp(2 arsinh(½ sqrt(0.588))) = 2.1 a step
    growth = np.log([leapfrog(body, 1.02 * limit, n_steps) for n_steps in (200, 250)])
    assert growth[0] > 40.0
    negative = 1.02**2 * (1.02**2 - 1.0) / SHARE
    assert np.diff(growth)[0] / 50 == pytest.approx(2.0 * np.arcsinh(0.5 * np.sqrt(negative)), rel=0.02)
