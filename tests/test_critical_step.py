"""The critical time step: dense eigenvalues, and leapfrog itself just below and just above it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.critical_step import LANCZOS_TOLERANCE, critical_time_step
from fem.contacts.patch import disc_patch_force, ring_patch_force
from fem.elastic.assembly import assemble
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
    """Largest ω² of K + Σ 2k f fᵀ and M."""
    stiffness = body.stiffness.toarray()
    for j, spring in enumerate(springs):
        patch = disc_patch_force(body, 2.0 * np.pi * j / len(springs))
        stiffness += 2.0 * spring * np.outer(patch, patch)
    scale = 1.0 / np.sqrt(np.repeat(body.mass, 2))
    return eigh(scale[:, None] * stiffness * scale, eigvals_only=True)[-1]


def dense_ring(body, spring=0.0):
    """Largest ω² of the held ring in Cartesian components, from scikit-fem's own matrix."""
    stiffness = assemble(Mesh(points=body.points, cells=body.cells), body.material, LENGTH).stiffness.toarray()
    angle = body.angles
    radial, across = np.moveaxis(ring_patch_force(body, 0.0), 1, 0)
    x, y = radial * np.cos(angle) - across * np.sin(angle), radial * np.sin(angle) + across * np.cos(angle)
    patch = np.stack([x, y], axis=-1).ravel()
    stiffness += 2.0 * spring * np.outer(patch, patch)
    node = np.arange(body.n_rows * body.n_sectors).reshape(body.n_rows, -1)[body.free_rows].ravel()
    free = (2 * node[:, None] + np.arange(2)).ravel()
    scale = 1.0 / np.sqrt(np.repeat(body.row_mass[body.free_rows], 2 * body.n_sectors))
    return eigh(scale[:, None] * stiffness[np.ix_(free, free)] * scale, eigvals_only=True)[-1]


def dense_step(whole, springs):
    fastest = max(
        dense_disc(whole.roller, springs),
        dense_ring(whole.inner_ring, springs[0]),
        dense_ring(whole.outer_ring, springs[1]),
    )
    return 2.0 / np.sqrt(fastest)


def test_without_contacts_it_is_the_dense_eigenvalue():
    whole = model(paper(), 2e-3)
    found = critical_time_step(without_contacts(whole), LOAD)
    wanted = dense_step(whole, [0.0, 0.0, 0.0])
    # never above; Lanczos' tolerance below, and the same added for safety
    assert found <= wanted * (1.0 + 1e-9)
    assert found >= wanted * (1.0 - 1.1 * LANCZOS_TOLERANCE)


def test_with_contacts_it_is_the_dense_eigenvalue_with_springs():
    whole = model(paper(), 2e-3)
    springs = [getattr(whole, name).stiffness(LOAD_MARGIN * LOAD) for name in LAWS]
    found, wanted = critical_time_step(whole, LOAD), dense_step(whole, springs)
    assert found <= wanted * (1.0 + 1e-9)
    assert found >= wanted * (1.0 - 1.1 * LANCZOS_TOLERANCE)


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
    assert steps[1] < 1e-3 / STEEL.dilatational_wave_speed  # no faster than a wave crosses an element


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
        compiled.drift_still_ring(u, w, dt, first, last)
    return np.abs(u).max() / start


@pytest.mark.parametrize("which", ["roller", "inner ring", "outer ring"])
def test_leapfrog_is_stable_just_below_it_and_blows_up_just_above(which):
    if which == "roller":
        body, leapfrog = disc(0.005, 3), leapfrog_disc
        limit = 2.0 / np.sqrt(dense_disc(body))
    else:
        inside = which == "inner ring"
        body = ring(0.0125, 0.018, 56, 3, True) if inside else ring(0.028, 0.0325, 88, 2, False)
        limit, leapfrog = 2.0 / np.sqrt(dense_ring(body)), leapfrog_ring
    # at ω dt = 2·0.98 a mode is amplified at most 1/sqrt(1 − 0.98²) = 5 times, at any number of steps
    assert leapfrog(body, 0.98 * limit, 4000) < 20.0
    # at ω dt = 2·1.02 it grows by exp(2 arcosh 1.02) = 1.49 a step; modes just below it still count
    growth = np.log([leapfrog(body, 1.02 * limit, n_steps) for n_steps in (200, 250)])
    assert growth[0] > 40.0
    assert np.diff(growth)[0] / 50 == pytest.approx(2.0 * np.arccosh(1.02), rel=0.02)
